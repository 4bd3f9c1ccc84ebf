"""Machines of scene files: the table ``[machine]``, as it is given and as the solver takes it."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING, Any, Final

from vibro.errors import InputError, Problems, did_you_mean, shown
from vibro.files.descriptions import KINDS, MACHINE_KEYS, SCENE_FILE
from vibro.files.entries import ends_of
from vibro.files.points import read_points
from vibro.quantities import MACHINE, QUANTITIES

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping
    from pathlib import Path

    from vibro.files.entries import Entry
    from vibro.machines.machine import Machine

_ARGUMENTS: Final = (
    "trough_mass", "counter_mass", "vibrating_mass", "natural", "damping_ratio", "mount", "voltage_exponent",
    "base_stiffness", "gap", "crank_radius", "rod_stiffness", "law", "force", "calibration",
)  # fmt: skip
_NAMES: Final = {  # of arguments of Machine, where they are called otherwise
    "natural": "natural_frequency", "mount": "mount_frequency", "crank_radius": "radius",
}  # fmt: skip
# What stands beside a way to give a moment, one of them, and why.
_BESIDE: Final = (
    ("static_moment_kg_mm", ("motors",), "is that of one motor", "for example: motors = 2"),
    ("centrifugal_force_n", ("motors",), "is that of one motor", "for example: motors = 2"),
    ("centrifugal_force_n", ("at_hz", "at_rpm"), "is that at a speed", "for example: at_rpm = 1500"),
    (
        "working_moment_kg_cm",
        ("working_moment_is",),
        "makers print the vibrating mass times the amplitude, or times the stroke, which is twice as much",
        'add working_moment_is = "amplitude" or working_moment_is = "stroke"',
    ),
)
_SAME: Final = 0.01  # relative difference of two moments that differ only by the maker's rounding
#: A filling that is heavier, in masses of the trough, is questioned, and how.
HEAVY: Final = 10.0
HEAVY_FILLING: Final = (
    "filling = {filling} kg is {times} times the mass of the trough: for grams write filling={filling}g"
)
_MILLIMETRES: Final = 1000.0  # [mm] of a metre


@dataclass(frozen=True, eq=False)
class GivenMachine:
    """A machine, and the table that gives it, to be written back as given.

    Attributes
    ----------
    table : mapping
        The table; points of a file are in it as pairs.
    kind : str
        Of ``KINDS``.
    arguments : mapping
        Those of the constructor ``vibro.Machine.<kind>``, in SI units.
    packs : mapping of str to float
        Natural frequencies of spring packs by name [Hz].
    bands : mapping of str to pair of float
        Setting, voltage and filling that are given as ``lo:hi``, by quantity, in the units outside.
    shares : mapping of str to pair of float
        ``added_mass_share`` and ``added_damping_share`` where they are given, with both ends [1].
    own : mapping of str to float
        Default values of ``MACHINE``, in the units outside. Of a band: the
        upper end of the setting, the nominal voltage if it lies in its band, an empty trough.
    """

    table: Mapping[str, Any]
    kind: str
    arguments: Mapping[str, Any]
    packs: Mapping[str, float] = field(default_factory=dict)
    bands: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    shares: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    own: Mapping[str, float] = field(default_factory=dict)

    @property
    def has_springs(self) -> bool:
        """Whether it has springs that may be exchanged."""
        return _belongs(MACHINE_KEYS["natural_hz"], self.kind)

    def takes(self, name: str) -> bool:
        """Whether a quantity of ``MACHINE`` has a meaning for this kind of machine."""
        return _belongs(MACHINE_KEYS[QUANTITIES[name].column], self.kind)

    @property
    def share(self) -> tuple[float, float] | None:
        """Added mass and damping shares that replace the computed ones: the middles of bands [1]."""
        if not self.shares:
            return None
        mass, damping = (self.shares.get(f"added_{of}_share", (0.0, 0.0)) for of in ("mass", "damping"))
        return 0.5 * (mass[0] + mass[1]), 0.5 * (damping[0] + damping[1])

    def doubt(self, filling: float) -> str:
        """Return a warning about a filling [kg] far heavier than the trough, else an empty text."""
        trough = self.machine.trough_mass
        if filling <= HEAVY * trough:
            return ""
        return HEAVY_FILLING.format(filling=f"{filling:.15g}", times=f"{filling / trough:.3g}")

    @cached_property
    def machine(self) -> Machine:
        """The machine, with its own springs, or with the first pack if those are not given.

        Raises
        ------
        InputError
            If there can be no such machine.
        """
        from vibro.machines.machine import Calibration, Machine

        arguments = {**self.arguments}
        if "calibration" in arguments:
            arguments["calibration"] = Calibration(**arguments["calibration"])
        if self.has_springs:
            arguments.setdefault("natural_frequency", next(iter(self.packs.values()), math.nan))
        make: Callable[..., Machine] = getattr(Machine, self.kind)
        return make(**arguments)

    def pack(self, name: str) -> float:
        """Return the natural frequency of a pack by its name [Hz].

        Raises
        ------
        InputError
            If there is no such pack.
        """
        if name not in self.packs:
            known = f"there are {', '.join(self.packs)}" if self.packs else "give [[machine.pack]] tables"
            hint = did_you_mean(name, self.packs) or known
            raise InputError(f"there is no spring pack {shown(name)}", hint=hint)
        return self.packs[name]


def machine_of(table: Mapping[str, Any]) -> GivenMachine:
    """Make the machine of a table that was written back, ``GivenMachine.table``.

    Raises
    ------
    InputError
        If it is no machine; the message names the keys.
    """
    problems = Problems()
    values = SCENE_FILE.table("machine", table, problems).values
    problems.settle()
    return given_machine(table, values, None)


def given_machine(table: Mapping[str, Any], values: Mapping[str, Any], folder: Path | None) -> GivenMachine:
    """Make the machine of a table whose values are read.

    Parameters
    ----------
    table : mapping
        As given: ``MACHINE_KEYS`` with their values.
    values : mapping
        What the entries read, by the names of their quantities, in SI units.
    folder : Path or None
        Folder of the scene file, for the file of points; None without a scene file.

    Raises
    ------
    InputError
        If it is no machine; the message names the keys.
    FileError
        If the points cannot be read.
    """
    kind = values.get("kind")
    if kind is None:
        raise InputError("kind is missing", hint=f"it is {', '.join(KINDS)}")
    _check_keys(table, kind)
    _check_ways(values, kind)
    table = dict(table)
    arguments = {_NAMES.get(name, name): values[name] for name in _ARGUMENTS if name in values}
    if _belongs(MACHINE_KEYS["motors"], kind):
        arguments["static_moment"] = _static_moment(table, values)
    if kind == "measured":
        table["points"] = _points_of(values["points"], folder)
        arguments["points"] = [(f, mm / _MILLIMETRES) for f, mm in table["points"]]
    packs = {pack["name"]: pack["natural"] for pack in values.get("pack", ())}
    own, bands = _settings(table)
    if "natural" in values:
        own["natural"] = ends_of(QUANTITIES["natural"], table["natural_hz"])[0]
    shares = {name: values[name] for name in ("added_mass_share", "added_damping_share") if name in values}
    return GivenMachine(table, kind, arguments, packs, bands, shares, own)


def _check_ways(values: Mapping[str, Any], kind: str) -> None:
    """Refuse what is given twice, or lacks what goes with it."""
    names = [pack["name"] for pack in values.get("pack", ())]
    if twice := [name for i, name in enumerate(names) if name in names[:i]]:
        raise InputError(f"pack {shown(twice[0])} is given twice", hint="name each pack differently")
    if kind == "magnet" and ("force" in values) is ("calibration" in values):
        both = "force_n and calibration are both given"
        example = "calibration = { amplitude_mm = 0.35, frequency_hz = 50, setting_percent = 100 }"
        problem = both if "force" in values else "force_n or calibration is missing"
        raise InputError(problem, hint=f"give one of them; for example: {example}")
    if _belongs(MACHINE_KEYS["natural_hz"], kind) and "natural" not in values:
        why = "the calibration was measured with one of the packs" if "calibration" in values else ""
        if not names:
            why = f"the amplitude of a machine of kind {kind} depends on it most"
        if why:
            hint = "measure it on the empty machine, which side of resonance it runs on is never assumed"
            raise InputError(f"natural_hz is missing: {why}", hint=f"{hint}; for example: natural_hz = 55.6")
    if "added_damping_share" in values and "added_mass_share" not in values:
        raise InputError("added_damping_share is given alone", hint="give added_mass_share too, or neither")


def _belongs(entry: Entry, kind: str) -> bool:
    return not entry.kinds or kind in entry.kinds


def _check_keys(table: Mapping[str, Any], kind: str) -> None:
    """Refuse keys that a kind of machine does not have, and missing ones."""
    problems = Problems()
    for key in table:
        if not _belongs(MACHINE_KEYS[key], kind):
            own = ", ".join(entry.key for entry in MACHINE_KEYS.values() if kind in entry.kinds)
            hint = f"it belongs to {', '.join(MACHINE_KEYS[key].kinds)}; those of {kind} are {own}"
            problems.add(f"{key} = {shown(table[key])}: does not belong to a machine of kind {kind}", hint)
    for entry in MACHINE_KEYS.values():
        if kind in entry.needed and entry.key not in table:
            what = f"{entry.key} is missing: a machine of kind {kind} needs it"
            problems.add(what, f"for example: {entry.shown}")
    problems.settle()


def _static_moment(table: Mapping[str, Any], values: Mapping[str, Any]) -> float:
    """Return the static moment of all motors together [kg m], of all ways in which it is given."""
    for key, beside, why, hint in _BESIDE:
        there = [other for other in beside if other in table]
        if key in table and len(there) != 1:
            lacks = f"{' and '.join(there)} are given" if there else f"{' or '.join(beside)} is missing"
            raise InputError(f"{key} = {shown(table[key])}: {why}, and {lacks}", hint=hint)
        if key not in table and there and there != ["motors"]:
            raise InputError(f"{there[0]} is given without {key}", hint="leave it out")
    found: dict[str, float] = {}
    if "static_moment" in values:
        found["static_moment_kg_mm"] = values["motors"] * values["static_moment"]
    if "centrifugal_force" in values:
        of_one = values["centrifugal_force"] / (2.0 * math.pi * values["at"]) ** 2
        found["centrifugal_force_n"] = values["motors"] * of_one
    if "working_moment" in values:
        found["working_moment_kg_cm"] = values["working_moment"] * values["working_moment_is"]
    if not found:
        ways = "static_moment_kg_mm and motors, or working_moment_kg_cm and working_moment_is, or"
        hint = f"give {ways} centrifugal_force_n, at_rpm and motors"
        raise InputError("the moment is missing", hint=hint)
    (first, moment), *others = found.items()
    for other, value in others:
        if abs(value / moment - 1.0) > _SAME:
            one, two = (f"{m * _MILLIMETRES:.5g} kg mm" for m in (moment, value))
            problem = f"{first} and {other} are moments of {one} and {two} of all motors"
            which = "makers give moments of one motor or of all, of amplitude or of stroke"
            times = f"{problem}: {value / moment:.4g} times as much"
            raise InputError(times, hint=f"{which}: check which; then leave the other out")
    return moment


def _settings(table: Mapping[str, Any]) -> tuple[dict[str, float], dict[str, tuple[float, float]]]:
    """Return setting, voltage and filling, and those of them that are bands, in the units outside."""
    own: dict[str, float] = {}
    bands: dict[str, tuple[float, float]] = {}
    for name in MACHINE[:3]:
        quantity = QUANTITIES[name]
        ends = ends_of(quantity, table.get(quantity.column, quantity.default))
        low, high = ends[0], ends[-1]
        nominal = quantity.default or 0.0
        inside = nominal if low <= nominal <= high else 0.5 * (low + high)
        own[name] = low if low == high else {"setting": high, "voltage": inside, "filling": 0.0}[name]
        bands |= {name: (low, high)} if low < high else {}
    return own, bands


def _points_of(given: Any, folder: Path | None) -> list[list[float]]:
    if not isinstance(given, str):
        return [[float(x) for x in pair] for pair in given]
    if folder is None:
        hint = "points = [[45, 0.2], ...]"
        raise InputError(f"points = {shown(given)}: must be pairs of numbers", hint=hint)
    return [[f, float(f"{_MILLIMETRES * a:.15g}")] for f, a in read_points(folder / given).pairs.tolist()]
