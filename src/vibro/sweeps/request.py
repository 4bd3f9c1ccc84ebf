"""The request of a caller and a scene file together, checked before anything is computed."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from fractions import Fraction
from typing import TYPE_CHECKING, Any, Final, Protocol

import numpy as np

from vibro.axes import AxisSpec, axis_of, default_count, drive_axis_of, one_value_of
from vibro.core.codes import Output
from vibro.errors import Problems, argument, shown
from vibro.files.descriptions import EXAMPLES
from vibro.files.scene_files import SceneFile
from vibro.quantities import (
    DEFAULTS,
    DRIVES,
    HARMONIC,
    LINEAR,
    LOAD,
    MACHINE,
    QUANTITIES,
    RATES,
    SCALE,
    SIZES,
    STANDS_FOR,
    SWEPT,
    TWO_AXIS,
    as_given,
    drive_of,
    millimetres,
    of_part,
    scene_fields,
)
from vibro.scene import Scene
from vibro.sweeps.drives import MOTION, MOVED, SLOTS, drive_given
from vibro.sweeps.grid import Grid, scene_of
from vibro.sweeps.machines import check_operating, empty_amplitude

if TYPE_CHECKING:
    from collections.abc import Collection, Sequence

    from vibro.axes import Axis
    from vibro.files.machines import GivenMachine
    from vibro.files.motions import GivenMotion
    from vibro.quantities import Quantity

#: Swept where they are not given. Friction and drive angle are never invented.
RANGES: Final = {"amplitude": "0.1:3", "frequency": "5:60"}
#: Warning of a trough that is shorter than a stroke.
SHORT_TROUGH: Final = (
    "trough length = {length} mm is less than the {largest}stroke, {stroke} mm: for metres write -L {length}m"
)

# What must be given, in the order in which messages name what is missing.
_REQUIRED: Final = (
    "amplitude", "along_amplitude", "normal_amplitude", "along_amplitude_2", "normal_amplitude_2",
    "frequency", "drive_angle", "static_friction", "kinetic_friction",
)  # fmt: skip
Specs = dict[str, AxisSpec]
# An amplitude that follows from an acceleration or a speed.
_FOLLOWS: Final = replace(QUANTITIES["amplitude"], slips=("is the frequency right?",) * 2)


class Caller(Protocol):
    """How messages name inputs: as options, or as arguments of a function."""

    @property
    def gives(self) -> str:
        """The source of the input: ``the command line``."""

    @property
    def takes_one_value(self) -> tuple[str, str]:
        """Message and hint if an axis was given and one value is wanted."""

    def name(self, quantity: Quantity) -> str:
        """Name an argument: ``-A``."""

    def example(self, values: Mapping[str, str], *, from_scratch: bool) -> str:
        """Show input that gives these values by name; from scratch if the input given is wrong."""


@dataclass(frozen=True)
class Request:
    """A checked request.

    Attributes
    ----------
    name : str or None
        The scene file's name.
    specs : mapping of str to AxisSpec
        Every quantity of the scene by its name, axes and single values, in the order of a table's columns.
    own : mapping of str to float
        Values of the scene file's table ``[scene]``, in the user's units.
    motion : GivenMotion or None
        Of its table ``[motion]``, if that gives steps or samples.
    in_stroke : bool
        Whether the amplitude of a drive along a line was given as its stroke.
    machine : GivenMachine or None
        From which the amplitude follows, which is not among ``specs``.
    assumes_plastic : bool
        Whether no restitution was given, so that one of 0 is assumed.
    """

    name: str | None
    specs: Mapping[str, AxisSpec]
    own: Mapping[str, float]
    motion: GivenMotion | None = None
    in_stroke: bool = False
    machine: GivenMachine | None = None
    assumes_plastic: bool = False

    @property
    def varying(self) -> tuple[str, ...]:
        """Names of the axes."""
        return tuple(name for name, spec in self.specs.items() if spec.varies)

    @property
    def length(self) -> float | None:
        """Length of the trough [mm]."""
        return self.specs["trough_length"].value if "trough_length" in self.specs else None

    @property
    def drive(self) -> tuple[str, ...]:
        """Names of the drive's quantities."""
        return LINEAR if self.machine is not None else drive_of(self.specs)

    @property
    def given_values(self) -> dict[str, float]:
        """``fixed`` in the quantities that were given, for texts."""
        return as_given(self.fixed, in_stroke=self.in_stroke)

    @property
    def is_waveform(self) -> bool:
        """Whether the drive has harmonics, steps or samples, or its part is clamped."""
        names = {*HARMONIC, "normal_acceleration"}
        return self.motion is not None or not names.isdisjoint(self.specs)

    @property
    def fixed(self) -> dict[str, float]:
        """Every quantity of the scene that does not vary, in the units outside."""
        return {
            name: spec.value
            for name, spec in self.specs.items()
            if not spec.varies and name != "trough_length"
        }

    def doubts(self, found: Collection[str] = ()) -> list[str]:
        """Return warnings about unusual values, probably in wrong units; a colon precedes the remedy.

        Unusual are values beyond a usual range, those of an axis only if all of them are; without these, an
        acceleration, which they would explain; and a trough that is shorter than the largest stroke. Nobody
        mistypes the quantities in ``found``, which were measured or are asked for.
        """
        first, last = (
            as_given({name: spec.values[i] for name, spec in self.specs.items()}, in_stroke=self.in_stroke)
            for i in (0, -1)
        )
        doubts = {name: QUANTITIES[name].doubt(value, last[name]) for name, value in first.items()}
        if not RATES.keys().isdisjoint(first) and not doubts["frequency"]:
            doubts["amplitude"] = _FOLLOWS.doubt(*amplitude_ends(self.specs))
        explained = any(doubts.get(name) for name in (*SIZES, "frequency", "gravity"))
        if not explained and LOAD.name not in {*found, *first}:
            doubts[LOAD.name] = self._doubted_load()
        doubts |= dict.fromkeys(found, "")
        if self.machine is not None:
            doubts["filling"] = self.machine.doubt(float(first.get("filling", 0.0)))
        return [text for text in (*doubts.values(), self._short_trough()) if text]

    def _doubted_load(self) -> str:
        """Question the acceleration of the drive; of a sweep the least one."""
        moved = {} if self.motion is None else {MOTION: self.motion.motion}
        least = {name: float(spec.values[0]) for name, spec in self.specs.items()}
        if self.machine is not None:
            least["amplitude"] = empty_amplitude(self.machine, least)
            if not 0.0 < least["amplitude"] < np.inf:
                return ""
        load = float(f"{float(Scene.allowing_infeasible(**scene_fields({**least, **moved})).load):.4g}")
        return LOAD.doubt(load, load)

    def _short_trough(self) -> str:
        """Question a trough that is shorter than the largest stroke: people may expect metres."""
        ends = amplitude_ends(self.specs)
        if self.length is None or not ends or self.length >= 2 * ends[1]:
            return ""
        stroke, largest = 2 * ends[1], "largest " if ends[0] < ends[1] else ""
        return SHORT_TROUGH.format(
            length=f"{self.length:.15g}", largest=largest, stroke=f"{float(stroke):.15g}"
        )

    def scene(self) -> Scene:
        """Make the scene of a request without axes; that of a machine with the amplitude found.

        Raises
        ------
        InputError
            If the machine has no operating point.
        """
        values = self.grid().values()
        if self.machine is not None:
            check_operating(self.machine, values)
        return scene_of({name: x.reshape(()) for name, x in values.items()})

    def axes(self, count: int = 0) -> dict[str, Axis]:
        """Spell out the axes; ``count`` values where a range leaves that open, the usual number without."""
        count = count or default_count(len(self.varying))
        return {name: self.specs[name].axis(count) for name in self.varying}

    def grid(self, output: Output = Output.EXACT, *, flight: bool = True, **how: Any) -> Grid:
        """Make the grid of all combinations; regimes alone need no flights."""
        return Grid(
            self.axes(),
            self.fixed,
            self.length,
            output,
            flight and output is Output.EXACT,
            motion=self.motion,
            in_stroke=self.in_stroke,
            machine=self.machine,
            **how,
        )


def amplitude_ends(specs: Mapping[str, AxisSpec]) -> tuple[float, float] | tuple[()]:
    """Return the least and the largest amplitude along a line, or along the trough [mm]; none of others."""
    name = next((name for name in ("amplitude", *RATES, "along_amplitude") if name in specs), "")
    if not name:
        return ()
    frequencies = specs["frequency"].values[:: len(specs["frequency"].values) - 1 or 1]
    factors = [millimetres(name, float(f)) if name in RATES else 1 for f in frequencies]
    return float(specs[name].values[0] * min(factors)), float(specs[name].values[-1] * max(factors))


class _Problems(Problems):
    """All problems, reported together in the order of a table's columns; fields are slots."""

    def __init__(self) -> None:
        super().__init__()
        self.slots: set[str] = set()

    def add(self, text: str, hint: str = "", field: str = "") -> None:
        self.slots.add(field)
        super().add(text, hint, field)

    def settle(self) -> None:
        order = [*QUANTITIES, ""]
        if len(self.found) > 1:
            self.found = [
                (slot, text, f"{QUANTITIES[slot].label}: {hint}" if slot and hint else hint)
                for slot, text, hint in sorted(self.found, key=lambda problem: order.index(problem[0]))
            ]
        super().settle()


def gather(
    given: Mapping[str, object],
    file: SceneFile | None,
    caller: Caller,
    *,
    reads_map: bool = False,
    takes_axes: bool = False,
    ranges: Mapping[str, str] | None = None,
    needs_length: bool = False,
    asked_for: Sequence[str] = (),
    pack: str | None = None,
) -> Request:
    """Merge a scene file and the caller's input, and check everything before anything is computed.

    Parameters
    ----------
    given : mapping of str to object
        What the caller gives by the name of its quantity, for ``axis_of`` to read.
    file : SceneFile or None
        Overridden by ``given``.
    caller : Caller
        For messages.
    reads_map : bool
        Whether the scene file's table ``[map]`` counts.
    takes_axes : bool
        Whether quantities may vary.
    ranges : mapping of str to str, optional
        Axes for quantities that are not given; if nothing else varies, also for those in ``[scene]``.
    needs_length : bool
        Whether the length of the trough is needed.
    asked_for : sequence of str, optional
        Names of quantities that are to be found: a caller may not give them, and the file's are ignored.
    pack : str, optional
        Name of the machine's spring pack, in place of its natural frequency.

    Returns
    -------
    Request
        Every value within its range, and not every combination infeasible.

    Raises
    ------
    InputError
        It names everything that is wrong or missing.
    """
    file = file or SceneFile("", {}, {})
    machine, problems = file.machine, _Problems()
    typed = _by_slot(_understood(given, problems, takes_axes=takes_axes), caller.gives, problems)
    swept = _by_slot(file.sweep, "[map]", problems) if reads_map else {}
    own = _by_slot(file.scene, "[scene]", problems)
    ranges = ranges or {}
    if machine is not None:
        own |= {name: axis_of(value, QUANTITIES[name]) for name, value in machine.own.items()}
        bands = {name: str(machine.table[QUANTITIES[name].column]) for name in machine.bands}
        ranges = ranges and (bands or ranges)
    if pack is not None:
        swept.pop("natural", None)  # that of the file; a pack of its own overrides it
    _check_machine(machine, pack, swept | typed, own, problems)
    dropped = [own.pop(name) for name in asked_for if name in own]
    for name in asked_for:
        if name in typed:
            label = typed.pop(name).quantity.label
            problems.add(f"{label} is given, and asked for", "leave it out", name)
    values = {s.quantity.name: s.value for s in map(_amplitude_for_stroke, own.values())}

    layers = [(caller.gives, typed), ("[map]", swept), ("[scene]", own)]
    sources = [dict.fromkeys(specs, source) for source, specs in layers]
    if file.motion is not None:
        sources[-1][MOTION] = "[motion]"
    drive, mixed = drive_given(sources, caller.name, {*problems.slots, *asked_for})
    if mixed is not None:
        problems.add(*mixed)
        problems.slots |= {*DRIVES}
    if machine is not None:
        _check_line(drive, layers, problems)
    unused = {*DRIVES} - SLOTS[drive] | ({"amplitude"} if machine else set())
    ranges = {slot: text for slot, text in ranges.items() if slot not in unused}
    typed, swept, own = (
        {slot: spec for slot, spec in specs.items() if slot not in unused} for specs in (typed, swept, own)
    )
    merged = _merged(typed, swept, own, ranges, drive)
    for slot in problems.slots:
        merged.pop(slot, None)

    for slot in merged:
        _check_values(slot, merged, caller, takes_axes, problems)
    _check_amplitude(merged, problems)
    _check_combinations(merged, problems)
    _check_clamped(drive, merged, caller, problems)
    needless = {*ranges, *asked_for, *unused}
    needless |= {n for n in HARMONIC if n.replace("amplitude", "phase") not in merged}
    required = [*_REQUIRED, "trough_length"] if needs_length else _REQUIRED
    _check_missing([slot for slot in required if slot not in needless], merged, caller, problems)
    problems.settle()

    named = {spec.quantity.name: spec for spec in map(_amplitude_for_stroke, merged.values())}
    specs = {name: named[name] for name in QUANTITIES if name in named}
    in_stroke = any(spec.quantity.name == "stroke" for spec in (*merged.values(), *dropped))
    motion = file.motion if drive is MOVED else None
    plastic = not any("restitution" in layer for layer in (typed, swept, own))
    return Request(file.name or None, specs, values, motion, in_stroke and drive is LINEAR, machine, plastic)


def _merged(
    typed: Specs, swept: Specs, own: Specs, ranges: Mapping[str, str], drive: tuple[str, ...]
) -> Specs:
    """Merge what is given with ranges, which override a scene of which nothing varies, and usual values."""
    merged = own | swept | typed
    if not any(spec.varies for spec in merged.values()):
        for slot in ranges.keys() & own.keys() - swept.keys() - typed.keys():
            del merged[slot]
    usual: Mapping[str, float | str] = {**DEFAULTS, **_left_out(drive, merged), **ranges}
    return {slot: axis_of(value, QUANTITIES[slot]) for slot, value in usual.items()} | merged


def _check_machine(
    machine: GivenMachine | None, pack: str | None, given: Specs, own: Specs, problems: _Problems
) -> None:
    """Check the values given for a machine, and add the natural frequency of its springs as a default."""
    natural, describe = QUANTITIES["natural"], "describe one in the table [machine] of a scene file"
    for slot in (slot for slot in MACHINE if slot in given):
        found = _text(given[slot], given[slot].values[0])
        if machine is None:
            problems.add(f"{found}: there is no machine", f"leave it out, or {describe}", slot)
        elif not machine.takes(slot):
            problems.add(f"{found}: does not apply to a machine of kind {machine.kind}", "leave it out", slot)
    if machine is None:
        if pack is not None:
            problems.add(f"spring pack {shown(pack)}: there is no machine", describe, natural.name)
        return
    with problems.taken("[machine] "):
        _ = machine.machine
    if pack is not None:
        if natural.name in given:
            problems.add("a spring pack and a natural frequency are given", "give one of them", natural.name)
        with problems.taken(field=natural.name):
            own[natural.name] = axis_of(machine.pack(pack), natural)
    elif machine.has_springs and natural.name not in given | own:
        if len(machine.packs) == 1:
            own[natural.name] = axis_of(next(iter(machine.packs.values())), natural)
        else:
            packs = " or ".join(argument("pack", name) for name in machine.packs)
            hint = f"give {packs}, or a natural frequency"
            problems.add("which spring pack is fitted is not given", hint, natural.name)


def _check_line(drive: tuple[str, ...], layers: Sequence[tuple[str, Specs]], problems: _Problems) -> None:
    """Refuse a drive of its own beside a machine, which moves the trough along a line."""
    for source, specs in layers:
        if "amplitude" in specs:
            label = specs["amplitude"].quantity.label
            problems.add(
                f"{source} gives the {label} beside [machine], from which the amplitude follows",
                "leave it out, or the table [machine]; a machine's drive is set by setting=, in percent",
                "amplitude",
            )
    if drive is not LINEAR:
        problems.add(
            "a machine moves its trough along a line: an ellipse or a motion stands beside [machine]",
            f"give {QUANTITIES['drive_angle'].column} alone, or leave the table [machine] out",
        )


def _understood(given: Mapping[str, object], problems: _Problems, *, takes_axes: bool) -> Specs:
    specs = {}
    for name, value in given.items():
        with problems.taken(field=STANDS_FOR.get(name, name)):
            quantity = QUANTITIES[name]
            read = axis_of if takes_axes and STANDS_FOR.get(name, name) in SWEPT else one_value_of
            specs[name] = drive_axis_of(value, quantity, read)
    return specs


def _by_slot(specs: Mapping[str, AxisSpec], source: str, problems: _Problems) -> Specs:
    result: Specs = {}
    for name, spec in specs.items():
        slot = STANDS_FOR.get(name, name)
        if slot in result:
            both = f"{result[slot].quantity.label} and {spec.quantity.label}"
            problems.add(f"{source} gives both {both}", "give one of them", slot)
        result[slot] = spec
    return result


def _amplitude_for_stroke(spec: AxisSpec) -> AxisSpec:
    if spec.quantity.name != "stroke":
        return spec
    return spec.halved(QUANTITIES["amplitude"])


def _left_out(drive: tuple[str, ...], given: Collection[str]) -> dict[str, float]:
    """Return what drives need not give: phases, motions of drives with harmonics, the scale of a motion."""
    if drive is MOVED:
        return {SCALE: 1.0}
    sizes = {name for name in given if name in HARMONIC and "amplitude" in name}
    phases = {name.replace("amplitude", "phase") for name in sizes}
    motions = ("along_amplitude", "normal_amplitude") if sizes else ()
    return dict.fromkeys({"normal_phase", *phases, *motions} if drive is TWO_AXIS else (), 0.0)


def _text(spec: AxisSpec, value: Fraction | float) -> str:
    return f"{spec.quantity.label} = {spec.quantity.text(value)}"


def _check_values(slot: str, specs: Specs, caller: Caller, takes_axes: bool, problems: _Problems) -> None:
    """Check whether a quantity may vary, and every value; only the first wrong one is reported."""
    spec, is_swept = specs[slot], slot in SWEPT
    if spec.varies and not (takes_axes and is_swept):
        ends = "...".join(spec.quantity.text(v) for v in (spec.values[0], spec.values[-1]))
        why = caller.takes_one_value if is_swept else ("it cannot be an axis", "give it one value")
        problems.add(f"{spec.quantity.label} = {ends}: {why[0]}", why[1], slot)
    quantity = of_part(QUANTITIES[spec.quantity.name], is_clamped="normal_acceleration" in specs)
    values = np.array(spec.values, np.float64)
    good = (quantity.swept if spec.varies else quantity).allows(quantity.to_si(values))
    for value in values[~good][:1]:
        problems.add(f"{_text(spec, value)}: must be {quantity.allowed.text(quantity.unit)}", field=slot)


def _check_amplitude(specs: Specs, problems: _Problems) -> None:
    """Refuse a speed or an acceleration whose amplitude, at one of the frequencies, is beyond its range."""
    spec, frequency = specs.get("amplitude"), specs.get("frequency")
    if spec is None or frequency is None or not problems.slots.isdisjoint(("amplitude", "frequency")):
        return
    name, size = spec.quantity.name, QUANTITIES["amplitude"]
    ends = amplitude_ends({name: spec, "frequency": frequency}) if name in RATES else ()
    for i, end in enumerate(ends):
        if not size.allows(size.to_si(end)):
            at = f"{_text(spec, spec.values[-i])} at {frequency.quantity.text(frequency.values[i - 1])}"
            allowed = size.allowed.text(size.unit)
            problems.add(f"{at}: its amplitude, {size.text(end)}, must be {allowed}", field="amplitude")
            return


def _check_clamped(drive: tuple[str, ...], specs: Specs, caller: Caller, problems: _Problems) -> None:
    """Refuse a clamped part on a trough that moves normal to itself: the force on it would change."""
    clamped = specs.get("normal_acceleration")
    if clamped is None or "normal_acceleration" in problems.slots:
        return
    found = _text(clamped, clamped.values[0])
    if drive is LINEAR:
        x, y = (caller.name(QUANTITIES[name]) for name in TWO_AXIS[:2])
        why = "of a clamped part, whose trough moves along itself alone"
        problems.add(f"{found}: {why}", f"in place of amplitude and drive angle give {x}, and 0 for {y}")
    for slot, spec in specs.items():
        if slot.startswith("normal_amplitude") and any(spec.values):
            moves = _text(spec, spec.values[-1])
            problems.add(f"{found} beside {moves}: the trough of a clamped part moves along itself alone")
            return


def _check_combinations(specs: Specs, problems: _Problems) -> None:
    """Refuse a request of which every combination is infeasible: if its most feasible one is."""
    pair = ("static_friction", "kinetic_friction")
    static, kinetic = (None if slot in problems.slots else specs.get(slot) for slot in pair)
    if kinetic is None:
        return
    least, most, hint = kinetic.values[0], "", ""
    if kinetic.quantity.name == "friction_ratio":
        most = "in [0, 1]" if kinetic.varies and least > 1 else ""
    elif static is not None and float(least) > float(static.values[-1]):
        most = f"at most {_text(static, static.values[-1])}"
        hint = "friction at rest is the larger one: give both, or exchange them"
    if most:
        problems.add(f"{_text(kinetic, least)}: must be {most}", hint, field="kinetic_friction")


def _check_missing(required: Sequence[str], merged: Specs, caller: Caller, problems: _Problems) -> None:
    missing = [slot for slot in required if slot not in merged and slot not in problems.slots]
    if not missing:
        return
    # Of friction the example is the ratio, which fits whatever static friction is given.
    shown_as = {"kinetic_friction": "friction_ratio"}
    ways = {slot: dict.fromkeys((slot, shown_as.get(slot, slot))) for slot in missing}
    listed = ", ".join(
        f"{QUANTITIES[slot].label} ({' or '.join(caller.name(QUANTITIES[name]) for name in ways[slot])})"
        for slot in missing
    )
    # The example repeats the input only if that has no error: it must run.
    wrong = bool(problems.slots)
    names = [shown_as.get(slot, slot) for slot in (required if wrong else missing)]
    values = {name: f"{EXAMPLES[name]:g}" for name in names}
    problems.add(f"missing: {listed}", f"for example: {caller.example(values, from_scratch=wrong)}")
