"""Machines as drives of a design question: the amplitude that each setting gives, empty and full.

A machine with one spring pack at one frequency is a drive along a line. Of an empty trough the amplitude is
in proportion to the setting; voltage and filling make an interval of it. The drive has the middle of that
interval as its amplitude, and half of its width as drift, so that searches and guarantees are those of any
other drive.
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from vibro.core.codes import Regime
from vibro.designs.guarantees import counted
from vibro.designs.proofs import corners
from vibro.designs.questions import Drive, MachineDrive, Met
from vibro.designs.rows import DIGITS, KINDS, SEARCHED, Finder, Rounded, best_of, find, finder_of
from vibro.designs.search import sobol
from vibro.designs.spaces import inside, off
from vibro.drives import Line
from vibro.machines.operating import operate
from vibro.quantities import QUANTITIES
from vibro.reals import rounded
from vibro.steady import solve

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from vibro.designs.questions import Question
    from vibro.designs.spaces import Setting, Span
    from vibro.files.entries import Table
    from vibro.files.machines import GivenMachine
    from vibro.machines.machine import Machine, Response
    from vibro.reals import Floats


_DRAWN: Final = 9  # base-2 logarithm of the number of samples that are drawn evenly
_SEED: Final = 20


def covering(drive: Drive, covered: Span, most: float = math.inf, ended_by: str = "gap") -> Drive:
    """Return the drive of the same machine whose designs cover another interval of amplitudes.

    ``most`` is the largest setting [1], where that of the machine is too large, and ``ended_by`` tells why.
    """
    assert drive.machine is not None
    low, high = drive.machine.settings
    if most < high:
        high = rounded(100.0 * most, DIGITS, down=True) / 100.0
    else:
        ended_by = drive.machine.ended_by
    machine = replace(drive.machine, covered=covered, settings=(low, high), ended_by=ended_by)
    low, high = (setting * machine.amplitude for setting in machine.settings)
    choices = {**drive.choices, "amplitude": ((low, high),)}
    return replace(
        drive, machine=machine, choices=choices, acceleration=machine.acceleration * machine.middle
    )


def amplitudes_met(question: Question, setting: Setting) -> Met:
    """Return the amplitudes at a setting of a machine's drive, over all bands and drifts.

    Parameters
    ----------
    question : Question
        Of the machine's drive.
    setting : Setting
        Nominal motion of the trough; its amplitude is the middle of the covered interval.

    Notes
    -----
    The interval is that of samples: at all corners of the bands, and at 512 points drawn evenly from them.
    """
    machine = question.drive.machine
    assert machine is not None
    drift, box = question.spec.drift, question.box(setting)
    size = float(question.space.amplitude(setting)) / machine.amplitude
    spans = np.array(
        [
            (size * (1.0 - drift.amplitude), size * (1.0 + drift.amplitude)),
            off(float(setting.frequency), drift.frequency),
            machine.voltage,
            machine.filling,
            *machine.shares.values(),
        ]
    )
    varies = np.append(spans[:, 0] < spans[:, 1], box.varies & (np.array(box.axes) != "load"))
    even = sobol(varies.size, _DRAWN, _SEED) * varies[:, None]
    cube = np.hstack([corners(varies), even])
    scale, f, voltage, filling, *shares = inside(tuple(spans.T[..., None]), cube[: len(spans)])
    points = box.points(cube[len(spans) :])
    given: dict[str, Any] = dict(zip(machine.shares, shares, strict=True))
    found = operate(
        machine.machine,
        frequency=f,
        drive_angle=points.shape[0],
        static_friction=points.static_friction,
        kinetic_friction=points.kinetic_friction,
        trough_angle=points.trough_angle,
        gravity=question.spec.gravity,
        restitution=points.restitution,
        setting=scale,
        voltage=voltage,
        filling=filling,
        allow_strikes=True,
        **given,
    )
    # the amplitude of an empty trough is in proportion to the setting
    empty = scale * machine.full_amplitude
    low, high = (np.asarray(x) / empty for x in (found.amplitude_low, found.amplitude_high))
    most = scale * machine.machine.gap / np.asarray(found.relative_amplitude)
    met = Met(
        float(low.min()),
        float(high.max()),
        int(np.max(found.number)),
        float(np.min(most[np.isfinite(most)], initial=math.inf)),
        bool(np.any(found.strikes)),
    )
    if not met.low > 0.0:
        return met
    cycle = solve(found.scene_with_second_harmonic)
    return met._replace(
        second_harmonic=float(np.nan_to_num(found.second_harmonic).max()),
        speed=float(np.fmin.reduce(counted(cycle, fast=False))),
        regime=Regime(int(cycle.regime.max())),
        throw_number=float(cycle.throw_number.max()),
    )


def most_setting(machine: MachineDrive, drift: float) -> float:
    """Return the setting at which trough and counter mass of an empty machine strike each other [1].

    Parameters
    ----------
    machine : MachineDrive
        The machine.
    drift : float
        Of the frequency, either way [1].
    """
    return float(machine.machine.gap / np.max(_empty(machine, drift).relative_amplitude))


def _empty_band(machine: MachineDrive, drift: float) -> Span:
    """Return the smallest and the largest amplitude of an empty trough, over that at the middle voltage.

    Parameters
    ----------
    machine : MachineDrive
        The machine.
    drift : float
        Of the frequency, either way [1].
    """
    ratios = np.asarray(_empty(machine, drift).amplitude) / machine.full_amplitude
    return float(ratios.min()), float(ratios.max())


def _empty(machine: MachineDrive, drift: float) -> Response:
    """Return the empty machine's motion over the drift of its frequency and the band of its voltage."""
    frequencies = _around(machine.frequency, drift, machine.natural_frequency)
    return machine.machine.response(frequencies[:, None], voltage=np.array(machine.voltage))


def _around(frequency: float, drift: float, resonance: float | None) -> Floats:
    """Return a frequency with both ends of its drift, and resonance, where the drift passes it [Hz]."""
    low, high = off(frequency, drift)
    ends = (
        [low, frequency, high] if resonance is None else [low, frequency, high, np.clip(resonance, low, high)]
    )
    return np.unique(np.array(ends, np.float64))


# ------------------------------------------------------------------------------
# Find the designs of a machine whose amplitude depends on what lies in its trough.
#
# What a filling weighs depends on the motion, and so does the interval of amplitudes at one setting. A design
# is found for an interval that is assumed, and holds where that covers the amplitudes that are met at its
# setting. If it does not, the interval of those is assumed, and the design is sought again.

_ROUNDS: Final = 8
_FREE: Final = 3  # rounds after which intervals only grow
_BELOW: Final = 0.999  # of the setting at which masses strike each other, or bodies begin to hop
_STEP: Final = 1.02  # by which settings are lowered at least where bodies slip back or hop
# What ends the settings of a design that a second harmonic brings beyond a regime.
_BEYOND: Final = {Regime.FORWARD_SLIP: "back slip", Regime.BACK_SLIP: "hop"}
# Room at both ends beyond samples: a share of the interval's width [1], and of its upper end [1].
_ROOM: Final = (0.02, 1e-3)


def find_covered(
    question: Question,
    calmer: Mapping[str, Finder],
    digits: int = DIGITS,
    tell: Callable[[str], None] = lambda _: None,
) -> dict[str, Finder]:
    """Find the designs of a drive, of a filled machine those whose amplitudes are covered.

    Parameters
    ----------
    question : Question
        Drive, goal and bands.
    calmer : mapping of str to Finder
        Designs within a lower regime, which are candidates here too; empty without any.
    digits : int, optional
        Of printed settings.
    tell : callable, optional
        ``tell(kind)`` says which design is searched.

    Returns
    -------
    dict of str to Finder
        The finder of every kind of design, which has it, if it exists. Of a filled machine each has its own
        drive, which covers the amplitudes at that design.
    """
    machine = question.drive.machine
    if machine is None or not machine.is_filled:
        found = calmer["fastest"].found if calmer else {}
        return dict.fromkeys(KINDS, find(question, found, digits, tell))
    held: list[Finder] = []  # each with one design that holds
    start, refused = question, frozenset[str]()
    for kind in SEARCHED:
        finder = _settled(kind, start, digits, tell)
        refused |= finder.refused
        if finder.found:
            held.append(finder)
            start = held[0].question if kind == SEARCHED[0] else start
    for kind, known in calmer.items():
        if kind in known.found:
            here = finder_of(replace(question, drive=known.question.drive), digits)
            held.append(replace(here, found={kind: known.found[kind]}))
    none = replace(finder_of(question, digits), refused=refused)
    return {kind: _best(kind, held) or none for kind in KINDS}


def _best(kind: str, held: list[Finder]) -> Finder | None:
    """Return the finder with the best design of a kind; only the fastest may miss the goal."""
    designs = [(finder, found) for finder in held for found in finder.found.values()]
    able = [one for one in designs if kind == "fastest" or one[1].guarantee.speed_min >= one[0].target]
    if not able:
        return None
    finder, found = max(able, key=lambda one: best_of(kind, one[0].question, one[1]))
    return replace(finder, found={kind: found})


def _settled(kind: str, question: Question, digits: int, tell: Callable[[str], None]) -> Finder:
    """Find a design whose interval covers the amplitudes that are met at its setting.

    The interval of a round holds what was met in the last one, in later rounds in all of them.
    """
    for count in range(_ROUNDS):
        finder, machine = find(question, {}, digits, tell, until=kind), question.drive.machine
        assert machine is not None
        if kind not in finder.found:
            return replace(finder, found={})
        found, covered = finder.found[kind], machine.covered
        met = amplitudes_met(question, found.setting)
        most = _most_setting(question, found, met)
        if most <= machine.settings[0] or not (met.low > 0.0 or met.strikes):
            break
        if covered[0] <= met.low <= met.high <= covered[1] and math.isinf(most):
            if met.speed < min(found.guarantee.speed_min, finder.target):
                break
            return replace(finder, found={kind: replace(found, met=met)})
        if met.low > 0.0:
            low, high = _hull(met)
            covered = (min(low, covered[0]), max(high, covered[1])) if count >= _FREE else (low, high)
        ended_by = _BEYOND[question.highest] if met.regime > question.highest else "gap"
        question = replace(question, drive=covering(question.drive, covered, most, ended_by))
    return replace(finder, found={}, refused=frozenset({kind}))


def _most_setting(question: Question, found: Rounded, met: Met) -> float:
    """Return the setting to try where that of a design is too large, about; inf where it is not [1].

    It is where masses strike each other, or where the second harmonic, of which the search knows nothing,
    brings bodies into a regime that the goal forbids.
    """
    machine, least = question.drive.machine, math.inf
    assert machine is not None
    if met.strikes:
        least = _BELOW * met.most_setting
    if met.regime > question.highest:
        setting = float(question.space.amplitude(found.setting)) / machine.amplitude
        least = min(least, _BELOW * setting / max(met.throw_number, _STEP))
    return least


def _hull(met: Met) -> Span:
    """Return an interval around the amplitudes of a design, with some room at its ends."""
    room = _ROOM[0] * (met.high - met.low) + _ROOM[1] * met.high
    return max(met.low - room, (1.0 - _ROOM[0]) * met.low), met.high + room


# ------------------------------------------------------------------------------
# Read the machine of a ``[[drive]]``, and expand it into drives: one for each spring pack and frequency.

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
            called = f"{name} ({which})" if which else name
            if (drive := _drive(table, given, machine, spans, drift, called, pack)) is None:
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
    drive = replace(drive, covered=_empty_band(drive, drift))
    choices = {"amplitude": (), "frequency": spans, "drive_angle": values.get("drive_angle", ())}
    return covering(Drive(name, Line, choices, machine=drive), drive.covered, most)
