"""Read the machine of a ``[[drive]]``, and expand it into drives: one for each spring pack and frequency."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import TYPE_CHECKING, Final

from vibro.drives import Line
from vibro.inverse.machine_drives import MachineDrive, covering, empty_band, most_setting
from vibro.inverse.specs import Drive
from vibro.quantities import QUANTITIES

if TYPE_CHECKING:
    from vibro.files.entries import Table
    from vibro.files.machines import GivenMachine
    from vibro.inverse.specs import Span
    from vibro.machines.machine import Machine

__all__ = ["machine_drives"]

_FIXED: Final = ("crank", "rod")  # kinds whose setting is their crank's radius
_OWN: Final = "own springs"


def machine_drives(table: Table, given: GivenMachine, usual_name: str, drift: float) -> list[Drive]:
    """Return the drives of a machine.

    Parameters
    ----------
    table : Table
        ``[[drive]]`` with the machine's keys.
    given : GivenMachine
        The machine.
    usual_name : str
        Of a drive without a name.
    drift : float
        Of the frequency, either way [1].

    Returns
    -------
    list of Drive
        Drives with different names; empty if the table has problems.
    """
    packs = _packs(given)
    frequencies = _frequencies(table, given.machine)
    if frequencies is None:
        return []
    name = table.values.get("name", usual_name)
    drives = []
    for pack, machine in packs.items():
        for spans in frequencies:
            parts = [pack, f"{spans[0][0]:.15g} Hz" if len(frequencies) > 1 else ""]
            which = ", ".join(filter(None, parts))
            told = f"{name} ({which})" if which else name
            if (drive := _drive(table, given, machine, spans, drift, told, pack)) is None:
                return []
            drives.append(drive)
    return drives


def _packs(given: GivenMachine) -> dict[str, Machine]:
    """Return the machine with each of its spring packs by name; its own springs have none, if alone."""
    if not given.packs:
        return {"": given.machine}
    own = given.machine.natural_frequency
    springs = given.packs if own in given.packs.values() else {_OWN: own, **given.packs}
    return {name: given.machine.with_natural_frequency(f0) for name, f0 in springs.items()}


def _frequencies(table: Table, machine: Machine) -> list[tuple[Span, ...]] | None:
    """Return the frequencies of each drive: all of them, or one, where the amplitude depends on it."""
    spans: tuple[Span, ...] | None = table.values.get("frequency")
    if spans is None:
        return None
    if not MachineDrive.is_tuned(machine):
        return [spans]
    if any(low < high for low, high in spans):
        key = "mount_hz" if machine.kind == "unbalance" else "natural_hz"
        why = f"a range, but the amplitude of a machine with {key} changes with the frequency"
        table.refuse("frequency_hz", why, "frequency_hz: give the frequencies that may be chosen: [45, 50]")
        return None
    return [(span,) for span in spans]


def _drive(
    table: Table,
    given: GivenMachine,
    machine: Machine,
    spans: tuple[Span, ...],
    drift: float,
    name: str,
    pack: str,
) -> Drive | None:
    values = table.values
    usual = (1.0, 1.0) if given.kind in _FIXED else (0.0, 1.0)
    low, high = (
        float(QUANTITIES["voltage"].to_si(x)) for x in given.bands.get("voltage", (given.own["voltage"],) * 2)
    )
    tuned = MachineDrive.is_tuned(machine)
    drive = MachineDrive(
        machine=machine,
        pack=pack,
        natural_frequency=machine.natural_frequency if tuned else None,
        frequency=spans[0][0],
        settings=values.get("setting", usual),
        voltage=(low, high),
        filling=given.bands.get("filling", (given.own["filling"],) * 2),
        shares=given.shares,
        acceleration=values.get("acceleration", math.inf),
    )
    if not math.isfinite(drive.full_amplitude):
        hint = "give damping_ratio, or another frequency"
        table.refuse("frequency_hz", "it is the resonance, and the machine has no damping", hint)
        return None
    most = most_setting(drive, drift)
    if most < drive.settings[0]:
        why = f"trough and counter mass strike each other above {100.0 * most:.4g} %"
        table.refuse("setting_percent", why, 'setting_percent: allow less, such as "10:50"')
        return None
    drive = replace(drive, covered=empty_band(drive, drift))
    choices = {"amplitude": (), "frequency": spans, "drive_angle": values.get("drive_angle", ())}
    return covering(Drive(name, Line, choices, machine=drive), drive.covered, most)
