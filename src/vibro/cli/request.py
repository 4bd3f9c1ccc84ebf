"""What the options and the scene file ask for together, checked before anything is computed."""

from __future__ import annotations

import shlex
from collections.abc import Mapping
from dataclasses import dataclass
from fractions import Fraction
from typing import TYPE_CHECKING, Final

from vibro.axes import AxisSpec, parse_axis
from vibro.errors import InputError, SceneError
from vibro.files.outputs import SceneFile, read_scene_file
from vibro.quantities import QUANTITIES, SWEPT, to_si
from vibro.scene import STANDARD_GRAVITY, Scene

if TYPE_CHECKING:
    from collections.abc import Sequence

    from vibro.cli.options import Options

__all__ = ["Request", "gather"]

# Two ways to give the same thing: a specification stands under the slot that it fills.
_SLOTS: Final = {"stroke": "amplitude", "friction_ratio": "kinetic_friction"}
_OPTIONAL: Final = {"trough_angle": "0", "gravity": repr(STANDARD_GRAVITY), "restitution": "0"}
# How to give what may be missing. As an example the ratio, which fits whatever static friction is given.
_REQUIRED: Final = {
    "amplitude": ("-A", "-A 1"),
    "frequency": ("-f", "-f 15"),
    "drive_angle": ("-a", "-a 20"),
    "static_friction": ("--mu-s", "--mu-s 0.74"),
    "kinetic_friction": ("--mu-d or --mu-ratio", "--mu-ratio 0.77"),
}
_LENGTH: Final = {"trough_length": ("-L", "-L 600")}
# Valid whatever the others are, in SI units.
_HARMLESS: Final = {
    "amplitude": 1e-3,
    "frequency": 1.0,
    "drive_angle": 0.0,
    "static_friction": 0.0,
    "kinetic_friction": 0.0,
}

Specs = dict[str, AxisSpec]
_Ways = Mapping[str, tuple[str, str]]


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
        What the scene file's table ``[scene]`` gives, in the user's units.
    """

    name: str | None
    specs: Mapping[str, AxisSpec]
    own: Mapping[str, float]

    @property
    def varying(self) -> tuple[str, ...]:
        """Names of the axes."""
        return tuple(name for name, spec in self.specs.items() if spec.varies)

    @property
    def length(self) -> float | None:
        """Length of the trough [mm]."""
        return self.specs["trough_length"].value if "trough_length" in self.specs else None


class _Problems:
    """Everything that is wrong, to be told at once."""

    def __init__(self) -> None:
        self.slots: set[str] = set()
        self._texts: list[tuple[str, str]] = []
        self._hints: list[tuple[str, str]] = []

    def add(self, slot: str, text: str, hint: str = "") -> None:
        self.slots.add(slot)
        self._texts.append((slot, text))
        self._hints += [(slot, hint)] if hint else []

    def settle(self) -> None:
        if not self._texts:
            return
        order = [*QUANTITIES, ""]
        texts = [text for _, text in sorted(self._texts, key=lambda problem: order.index(problem[0]))]
        hints = [hint for _, hint in self._hints]
        if len(texts) > 1:
            hints = [f"{QUANTITIES[slot].label}: {hint}" if slot else hint for slot, hint in self._hints]
        raise InputError(*texts, hint="\n".join(hints))


def gather(
    options: Options,
    argv: Sequence[str],
    *,
    reads_map: bool = False,
    takes_axes: bool = False,
    ranges: Mapping[str, str] | None = None,
    needs_length: bool = False,
) -> Request:
    """Merge the scene file and the options, and check all that can be known beforehand.

    Parameters
    ----------
    options : Options
        The shared options.
    argv : sequence of str
        The arguments as typed, the command first: for messages, and for an example that runs.
    reads_map : bool
        Whether the scene file's table ``[map]`` counts.
    takes_axes : bool
        Whether quantities may vary.
    ranges : mapping of str to str, optional
        Axes for what is not given; where nothing else varies, also for what the table ``[scene]`` gives.
    needs_length : bool
        Whether the length of the trough is needed.

    Returns
    -------
    Request
        Every value within its range, and not every combination infeasible.

    Raises
    ------
    InputError
        It names everything that is wrong or missing.
    FileError
        If the scene file cannot be read.
    """
    ranges = ranges or {}
    file = read_scene_file(options.scene) if options.scene else SceneFile("", {}, {})
    problems = _Problems()
    typed = _by_slot(_typed(options, problems), "the command line", problems)
    swept = _by_slot(file.sweep, "[map]", problems) if reads_map else {}
    own = _by_slot(file.scene, "[scene]", problems)

    merged = own | swept | typed
    if not any(spec.varies for spec in merged.values()):
        for slot in ranges.keys() & own.keys() - swept.keys() - typed.keys():
            del merged[slot]
    defaults = {slot: parse_axis(text, QUANTITIES[slot]) for slot, text in (_OPTIONAL | dict(ranges)).items()}
    merged = defaults | merged
    for slot in problems.slots:
        merged.pop(slot, None)

    for slot, spec in merged.items():
        _check_varies(slot, spec, argv[0], takes_axes, problems)
        _check_range(slot, spec, problems)
    _check_combinations(merged, problems)
    if ranges and not problems.slots and not any(spec.varies for spec in merged.values()):
        problems.add("", "nothing varies", "give an axis, for example -A 0.1:3:200")
    required = {
        s: how for s, how in (_REQUIRED | (_LENGTH if needs_length else {})).items() if s not in ranges
    }
    _check_missing({s: how for s, how in required.items() if s not in merged}, required, argv, problems)
    problems.settle()

    named = {spec.quantity.name: spec for spec in map(_amplitude_for_stroke, merged.values())}
    order = [name for name in (*SWEPT, "gravity", "restitution", "trough_length") if name in named]
    values = {s.quantity.name: s.value for s in map(_amplitude_for_stroke, own.values())}
    return Request(file.name or None, {name: named[name] for name in order}, values)


def _typed(options: Options, problems: _Problems) -> Specs:
    specs = {}
    for name, quantity in QUANTITIES.items():
        text = getattr(options, name)
        if text is None:
            continue
        try:
            specs[name] = parse_axis(text, quantity)
        except InputError as exc:
            problems.add(_SLOTS.get(name, name), str(exc), exc.hint)
    return specs


def _by_slot(specs: Mapping[str, AxisSpec], source: str, problems: _Problems) -> Specs:
    result: Specs = {}
    for name, spec in specs.items():
        slot = _SLOTS.get(name, name)
        if slot in result:
            both = f"{result[slot].quantity.label} and {spec.quantity.label}"
            problems.add(slot, f"{source} gives both {both}", "give one of them")
        result[slot] = spec
    return result


def _amplitude_for_stroke(spec: AxisSpec) -> AxisSpec:
    if spec.quantity.name != "stroke":
        return spec
    return spec.scaled(Fraction(1, 2), QUANTITIES["amplitude"])


def _text(spec: AxisSpec, value: Fraction) -> str:
    return f"{spec.quantity.label} = {spec.quantity.text(value)}"


def _check_varies(slot: str, spec: AxisSpec, command: str, takes_axes: bool, problems: _Problems) -> None:
    if not spec.varies or (takes_axes and slot in SWEPT):
        return
    values = "...".join(spec.quantity.text(v) for v in (spec.values[0], spec.values[-1]))
    if slot in SWEPT:
        hint = "vibro map takes axes; a decimal is written with a point"
        problems.add(slot, f"{spec.quantity.label} = {values}: vibro {command} takes one value", hint)
    else:
        problems.add(slot, f"{spec.quantity.label} = {values}: it cannot be an axis", "give it one value")


def _check_range(slot: str, spec: AxisSpec, problems: _Problems) -> None:
    """Let a scene judge every value, and tell it in the user's units."""
    name = spec.quantity.name
    for value in spec.values:
        allowed = ""
        if name == "trough_length":
            allowed = "" if value > 0 else "finite and > 0"
        elif name == "friction_ratio":
            allowed = "" if value >= 0 and (spec.varies or value <= 1) else "in [0, 1]"
        else:
            inside = to_si(slot, float(value / 2 if name == "stroke" else value))
            try:
                Scene.allowing_infeasible(**(_HARMLESS | {slot: inside}))
            except SceneError as exc:
                allowed = exc.problems[0].allowed
        if allowed:
            if spec.quantity.unit == "mm":
                allowed = f"{allowed.removesuffix(' m')} mm"
            problems.add(slot, f"{_text(spec, value)}: must be {allowed}")
            return


def _check_combinations(specs: Specs, problems: _Problems) -> None:
    """Refuse a request of which every combination is infeasible: if its most feasible one is."""
    least = {slot: spec.values[0] for slot, spec in specs.items() if slot not in problems.slots}
    if "static_friction" in least:
        least["static_friction"] = specs["static_friction"].values[-1]
    ratio = specs.get("kinetic_friction")
    if ratio is not None and ratio.quantity.name == "friction_ratio":
        least.pop("kinetic_friction", None)
        if ratio.values[0] > 1:
            problems.add("kinetic_friction", f"{_text(ratio, ratio.values[0])}: must be in [0, 1]")
    if "static_friction" not in least:
        least.pop("kinetic_friction", None)
    pairs = {"kinetic_friction", "static_friction", "drive_angle", "trough_angle"} & least.keys()
    try:
        Scene(**(_HARMLESS | {slot: to_si(slot, float(least[slot])) for slot in pairs}))
    except SceneError as exc:
        fields = {problem.field for problem in exc.problems}
        if "kinetic_friction" in fields:
            limit = _text(specs["static_friction"], least["static_friction"])
            text = _text(specs["kinetic_friction"], least["kinetic_friction"])
            problems.add("kinetic_friction", f"{text}: must be at most {limit}")
        if "drive_angle" in fields:
            text = _text(specs["drive_angle"], least["drive_angle"])
            other = _text(specs["trough_angle"], least["trough_angle"])
            problems.add("drive_angle", f"{text}: must be less than 90 deg together with {other}")


def _check_missing(missing: _Ways, required: _Ways, argv: Sequence[str], problems: _Problems) -> None:
    missing = {slot: how for slot, how in missing.items() if slot not in problems.slots}
    if not missing:
        return
    names = ", ".join(f"{QUANTITIES[slot].label} ({option})" for slot, (option, _) in missing.items())
    # What was typed makes an example that runs only if nothing is wrong with it.
    typed, wanted = (argv[:1], required) if problems.slots else (argv, missing)
    example = " ".join(["vibro", shlex.join(typed), *(example for _, example in wanted.values())])
    problems.add("", f"missing: {names}", f"for example: {example}")
