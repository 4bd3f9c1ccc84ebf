"""State of the page, read from the texts of its address and checked: the solver gets no other input."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Final

from vibro.axes import AxisSpec, parse_axis
from vibro.errors import InputError, Problems, cut, shown
from vibro.explore.controls import BANDS, CONTROLS, DRIVES, ELSEWHERE, VIEWS, drive_named
from vibro.files.descriptions import EXAMPLES
from vibro.quantities import (
    AMPLITUDES,
    BY_COLUMN,
    DEFAULTS,
    LEAST_SPEED,
    QUANTITIES,
    SWEPT,
    checked_number,
    kinetic_friction,
)
from vibro.sweeps.grid import Grid
from vibro.sweeps.request import Request, gather

if TYPE_CHECKING:
    from collections.abc import Mapping
    from fractions import Fraction

    from vibro.axes import Axis
    from vibro.quantities import Quantity

__all__ = ["HEIGHT", "WIDTH", "State", "initial_state", "number_text", "read_state"]

#: [cells] of a map.
WIDTH: Final = 200
HEIGHT: Final = 150

_MOST_CYCLES: Final = 20  # drive cycles of a history: more could not be told apart
# The nut of examples/safety_nut.toml, and drives of other kinds with about its load.
_VALUES: Final = {**EXAMPLES, **DEFAULTS, "normal_amplitude_2": 0.0, "normal_phase_2": 0.0}
_USUAL: Final = {QUANTITIES[n].column: f"{_VALUES[n]:g}" for n in CONTROLS if n != "friction_ratio"}
_OTHERS: Final = {
    "drive": "line",
    "view": "regime",
    "x": "",
    "y": "",
    "x_range": "",
    "y_range": "",
    "follow": "1",
    "static_friction_band": "",
    "kinetic_friction_band": "",
    "friction_ratio_band": "",
    "target": "",
    "cycles": "3",
}


class _Page:
    """How messages name the inputs of the page."""

    gives = "the page"
    takes_one_value = ("it takes one value", "a decimal is written with a point; axes are chosen at the map")

    def axis(self, quantity: Quantity) -> str:
        return f"{quantity.label} 0.1:3"

    def name(self, quantity: Quantity) -> str:
        return quantity.label

    def example(self, values: Mapping[str, str], *, from_scratch: bool) -> str:
        return ", ".join(f"{QUANTITIES[name].label} {value}" for name, value in values.items())


@dataclass(frozen=True)
class State:
    """State of the page.

    Attributes
    ----------
    texts : mapping of str to str
        The full state by the keys of the page's address, numbers in the units outside.
    point : Request
        The operating point.
    x, y : AxisSpec
        Ranges that the map is drawn over.
    bands : mapping of str to pair of float
        Bands of static friction, and of kinetic friction or its ratio, if they are not known exactly.
    target : float or None
        Speed that is to be reached [mm/s].
    """

    texts: Mapping[str, str]
    point: Request
    x: AxisSpec
    y: AxisSpec
    bands: Mapping[str, tuple[float, float]]
    target: float | None

    @property
    def view(self) -> str:
        """View of the map, a key of ``VIEWS``."""
        return self.texts["view"]

    @property
    def cycles(self) -> int:
        """Drive cycles of the history."""
        return int(self.texts["cycles"])

    @property
    def follows(self) -> bool:
        """Whether kinetic friction keeps its ratio to static friction."""
        return self.texts["follow"] == "1"

    @property
    def friction_ratio(self) -> float:
        """Kinetic over static friction of the operating point."""
        mu_s, mu_d = (self.point.fixed[name] for name in ("static_friction", "kinetic_friction"))
        return mu_d / mu_s if mu_s else 1.0

    def grid(self) -> Grid:
        """Make the grid of the map, which decides all its cells."""
        drawn: dict[str, Axis] = {axis.name: axis for axis in (self.x.axis(WIDTH), self.y.axis(HEIGHT))}
        fixed = {name: value for name, value in self.point.fixed.items() if name not in drawn}
        if "friction_ratio" in drawn:
            fixed.pop("kinetic_friction", None)
        elif self.follows and "static_friction" in drawn and "kinetic_friction" not in drawn:
            del fixed["kinetic_friction"]
            fixed["friction_ratio"] = self.friction_ratio
        return Grid({axis.name: axis for axis in map(drawn.get, SWEPT) if axis}, fixed, self.point.length)


def initial_state(request: Request | None = None) -> State:
    """Return the state at the start.

    Parameters
    ----------
    request : Request, optional
        Request of a scene file and options; its first two axes are drawn, and the operating point has the
        scene's values, or those in the middle of the axes. Without it the nut of examples/safety_nut.toml.

    Raises
    ------
    InputError
        If the page cannot show its drive.
    """
    if request is None:
        return _state({**_USUAL, **_OTHERS})
    if request.motion is not None:
        raise InputError(
            "the page shows no motions of steps or samples",
            hint="vibro solve and vibro map take all that a scene file can give",
        )
    point = request.fixed | ({} if request.length is None else {"trough_length": request.length})
    if not point.get("along_phase"):  # where phases are counted from
        point.pop("along_phase", None)
    other = [QUANTITIES[name].label for name in ELSEWHERE if name in {*point, *request.varying}]
    if other:
        raise InputError(
            f"the page shows neither motions with a scale nor clamped parts, as {' and '.join(other)} tells",
            hint="vibro solve and vibro map take all that a scene file can give",
        )
    drive = drive_named([name for name in request.drive if name in {*point, *request.varying}])
    if not drive:
        raise InputError(
            "the page shows drives of at most two harmonics, the first along the trough without a phase",
            hint="vibro solve takes all harmonics that a scene file can give",
        )
    texts = {**_USUAL, **_OTHERS, "drive": drive, "trough_length_mm": ""}
    texts |= {QUANTITIES[name].column: "0" for name in DRIVES[drive].quantities}  # unless it is given
    for name in request.varying:
        values = request.axes()[name].values
        point[name] = request.own.get(name, float(values[len(values) // 2]))
    if "friction_ratio" in point:
        mu_d = float(kinetic_friction(point.pop("friction_ratio"), point["static_friction"]))
        own = request.own if "friction_ratio" in request.varying else {}
        point["kinetic_friction"] = own.get("kinetic_friction", mu_d)
    texts |= {QUANTITIES[name].column: number_text(value) for name, value in point.items()}
    drawn = [name for name in request.varying if name in CONTROLS]
    if "frequency" in drawn and drawn[0] in AMPLITUDES:  # as pictures have it
        drawn = ["frequency", *(name for name in drawn if name != "frequency")]
    for key, name in zip("xy", drawn, strict=False):
        spec = request.specs[name]
        texts[key] = QUANTITIES[name].column
        texts[f"{key}_range"] = _range_text(spec)
    if len(drawn) == 1:
        texts["y"] = next(QUANTITIES[n].column for n in (DRIVES[drive].y, DRIVES[drive].x) if n != drawn[0])
    state = _state(texts)
    return replace(state, point=replace(state.point, name=request.name))


def read_state(query: Mapping[str, str], initial: State) -> State:
    """Read a state from the texts of an address.

    Parameters
    ----------
    query : mapping of str to str
        Keys that differ from the initial state.
    initial : State
        Gives the other keys.

    Raises
    ------
    InputError
        It lists all errors; its fields are keys.
    """
    texts = {**_USUAL, **_OTHERS, **initial.texts}
    for key in "xy":  # a drive of its own has axes of its own, and an axis has a range of its own
        if query.get("drive", texts["drive"]) != texts["drive"]:
            texts[key] = ""
        if query.get(key, texts[key]) != initial.texts[key]:
            texts[f"{key}_range"] = ""
    unknown = sorted(query.keys() - texts.keys())
    if unknown:
        raise InputError(*(f"unknown key {shown(key)}" for key in unknown), fields=[""] * len(unknown))
    state = _state({**texts, **{key: text.strip() for key, text in query.items()}})
    return replace(state, point=replace(state.point, name=initial.point.name))


def _state(texts: dict[str, str]) -> State:
    wrong = Problems()
    choices = {"drive": (*DRIVES,), "view": (*VIEWS,), "follow": ("0", "1")}
    for key, known in choices.items():
        if texts[key] not in known:
            wrong.add(f"{key} = {shown(texts[key])}: must be {', '.join(known)}", field=key)
    if texts["cycles"] not in map(str, range(1, _MOST_CYCLES + 1)):
        said = shown(texts["cycles"])
        wrong.add(f"cycles = {said}: must be a whole number from 1 to {_MOST_CYCLES}", field="cycles")
    wrong.settle()
    drive = DRIVES[texts["drive"]]
    other = {name for d in DRIVES.values() for name in d.quantities} - set(drive.quantities)
    shown_names = [name for name in CONTROLS if name not in other and name != "friction_ratio"]
    point = _point(texts, shown_names)
    axes = {}
    for key, usual, count in (("x", drive.x, WIDTH), ("y", drive.y, HEIGHT)):
        with wrong.taken(field=f"{key}_range"):
            axes[key] = _axis(key, usual, count, texts, [n for n in SWEPT if n not in {*other, *ELSEWHERE}])
    wrong.settle()
    x, y = axes["x"], axes["y"]
    drawn = {axis.quantity.name for axis in (x, y)}
    if len(drawn) == 1:
        wrong.add(f"x and y are both {x.quantity.label}", "choose two quantities", "y")
    elif {"friction_ratio", "kinetic_friction"} == drawn:
        wrong.add("friction ratio and kinetic friction stand for the same", "choose one of them", "y")
    bands = {}
    for name in BANDS:
        if text := texts[f"{name}_band"]:
            with wrong.taken(field=f"{name}_band"):
                bands[name] = _band(name, text, drive.label if texts["drive"] != "line" else "", drawn)
    if {"kinetic_friction", "friction_ratio"} <= bands.keys():
        wrong.add("kinetic friction has a band too", "leave one of them out", "friction_ratio_band")
    static, kinetic = (
        bands.get(name, (point.fixed[name],) * 2) for name in ("static_friction", "kinetic_friction")
    )
    follows = "friction_ratio" in bands or (texts["follow"] == "1" and "kinetic_friction" not in bands)
    if bands and not follows and kinetic[0] > static[1]:
        key = next(f"{name}_band" for name in reversed(BANDS) if name in bands)
        least, most = number_text(kinetic[0]), number_text(static[1])
        said = f"kinetic friction = {least} and more: must reach down to static friction = {most}"
        wrong.add(said, field=key)
    target = None
    if texts["target"]:
        with wrong.taken(field="target"):
            target = checked_number(texts["target"], LEAST_SPEED)
    if texts["view"] == "traverse" and point.length is None:
        wrong.add("the traverse time needs the length of the trough", "give it", "trough_length_mm")
    wrong.settle()
    kept = {name: number_text(value) for name, value in point.fixed.items()}
    kept["trough_length"] = "" if point.length is None else number_text(point.length)
    canonical = {
        **{key: texts[key] for key in _OTHERS},
        **{QUANTITIES[name].column: kept[name] for name in shown_names if name in kept},
        **{key: axis.quantity.column for key, axis in axes.items()},
        **{f"{key}_range": _range_text(axis) for key, axis in axes.items()},
        **{f"{name}_band": ":".join(map(number_text, band)) for name, band in bands.items()},
        "target": "" if target is None else number_text(target),
    }
    return State(canonical, point, x, y, bands, target)


def _point(texts: Mapping[str, str], names: list[str]) -> Request:
    """Read the operating point."""
    given = {name: texts[QUANTITIES[name].column] for name in names}
    if not given["trough_length"]:
        del given["trough_length"]
    try:
        return gather(given, None, _Page())
    except InputError as exc:
        fields = [QUANTITIES[f].column if f in QUANTITIES else f for f in exc.fields]
        raise InputError(*exc.problems, hint=exc.hint, fields=fields) from None


def _axis(key: str, usual: str, count: int, texts: Mapping[str, str], names: list[str]) -> AxisSpec:
    """Read an axis of the map; an InputError says what is wrong with its range, or names another field."""
    column, text = texts[key], texts[f"{key}_range"]
    quantity = BY_COLUMN.get(column) if column else QUANTITIES[usual]
    if quantity is None or quantity.name not in names:
        hint = f"choose from {', '.join(QUANTITIES[name].column for name in names)}"
        raise InputError(f"{key} = {shown(column)}: no axis of this drive", hint=hint, fields=[key])
    spec = parse_axis(text or CONTROLS[quantity.name].axis, quantity)
    if not spec.is_range or spec.count is not None:
        raise InputError(f"{quantity.label} = {cut(text)}: must be a range", hint="write it like 0.1:3")
    if not quantity.allows(quantity.to_si(spec.axis(count).values)).all():
        allowed = quantity.allowed.text(quantity.unit)
        raise InputError(f"{quantity.label} = {cut(text)}: must be {allowed}")
    return spec


def _band(name: str, text: str, other_drive: str, drawn: set[str]) -> tuple[float, float]:
    """Read the band of a friction."""
    quantity = QUANTITIES[name]
    if other_drive:
        said = f"bands of friction are not known of drives {other_drive}"
        raise InputError(said, hint="take a drive along a line")
    if drawn & {*BANDS}:
        hint = "choose other axes, or leave the band out"
        raise InputError("a friction that is drawn over has no band", hint=hint)
    low, colon, high = text.partition(":")
    ends, wrong = [], Problems()
    for end in (low, high if colon else low):
        with wrong.taken():
            ends.append(checked_number(end, quantity))
    wrong.settle()
    if ends[0] > ends[1]:
        raise InputError(f"{quantity.label} = {cut(text)}: the band does not ascend", hint="swap its ends")
    if name == "static_friction" and not ends[0]:
        raise InputError("bodies without static friction have no regime", hint="begin the band above 0")
    return ends[0], ends[1]


def _range_text(spec: AxisSpec) -> str:
    """Write the range of an axis; of a list from its first value to its last."""
    return f"{number_text(spec.values[0])}:{number_text(spec.values[-1])}" + ":log" * spec.log


def number_text(value: Fraction | float) -> str:
    """Write a number as people type it, such that it is read as the same double."""
    return f"{float(value):.15g}" if float(f"{float(value):.15g}") == float(value) else repr(float(value))
