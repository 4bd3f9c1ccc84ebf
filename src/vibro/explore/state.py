"""State of the page, read from the texts of its address and checked: the solver gets no other input."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, Final

from vibro.axes import AxisSpec, parse_axis
from vibro.errors import InputError, SceneError, cut, shown
from vibro.explore.controls import BANDS, CONTROLS, DRIVES, VIEWS, drive_named
from vibro.quantities import (
    AMPLITUDES,
    BY_COLUMN,
    LEAST_SPEED,
    QUANTITIES,
    SWEPT,
    exact_number,
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
_USUAL: Final = {
    "amplitude_mm": "1",
    "along_amplitude_mm": "1",
    "normal_amplitude_mm": "0.3",
    "frequency_hz": "15",
    "drive_angle_deg": "20",
    "normal_phase_deg": "-60",
    "along_amplitude_2_mm": "0.2",
    "along_phase_2_deg": "90",
    "normal_amplitude_2_mm": "0",
    "normal_phase_2_deg": "0",
    "static_friction": "0.74",
    "kinetic_friction": "0.57",
    "trough_angle_deg": "0",
    "gravity_m_s2": "9.81",
    "restitution": "0",
    "trough_length_mm": "600",
}
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
    point = request.fixed | ({} if request.length is None else {"trough_length": request.length})
    if not point.get("along_phase"):  # where phases are counted from
        point.pop("along_phase", None)
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
        texts[f"{key}_range"] = (
            f"{number_text(spec.values[0])}:{number_text(spec.values[-1])}" + ":log" * spec.log
        )
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


class _Wrong:
    """All errors of a state, reported at once."""

    def __init__(self) -> None:
        self._found: list[tuple[str, str, str]] = []

    def add(self, field: str, text: str, hint: str = "") -> None:
        self._found.append((field, text, hint))

    def read(self, field: str, reading: Any) -> Any:
        """Call a function without arguments, and book its input errors under the field."""
        try:
            return reading()
        except InputError as exc:
            self.add(field, str(exc), exc.hint)
        except SceneError as exc:
            self.add(field, str(exc))
        return None

    def settle(self) -> None:
        if self._found:
            fields, texts, hints = zip(*self._found, strict=True)
            raise InputError(*texts, hint="\n".join(filter(None, hints)), fields=fields)


def _state(texts: dict[str, str]) -> State:
    wrong = _Wrong()
    choices = {"drive": (*DRIVES,), "view": (*VIEWS,), "follow": ("0", "1")}
    for key, known in choices.items():
        if texts[key] not in known:
            wrong.add(key, f"{key} = {shown(texts[key])}: must be {', '.join(known)}")
    if texts["cycles"] not in map(str, range(1, _MOST_CYCLES + 1)):
        said = shown(texts["cycles"])
        wrong.add("cycles", f"cycles = {said}: must be a whole number from 1 to {_MOST_CYCLES}")
    wrong.settle()
    drive = DRIVES[texts["drive"]]
    other = {name for d in DRIVES.values() for name in d.quantities} - set(drive.quantities)
    shown_names = [name for name in CONTROLS if name not in other and name != "friction_ratio"]
    point = _point(texts, shown_names, wrong)
    axes = {
        key: _axis(key, usual, count, texts, [n for n in SWEPT if n in CONTROLS and n not in other], wrong)
        for key, usual, count in (("x", drive.x, WIDTH), ("y", drive.y, HEIGHT))
    }
    wrong.settle()
    x, y = axes["x"], axes["y"]
    drawn = {axis.quantity.name for axis in (x, y)}
    if len(drawn) == 1:
        wrong.add("y", f"x and y are both {x.quantity.label}", "choose two quantities")
    elif {"friction_ratio", "kinetic_friction"} == drawn:
        wrong.add("y", "friction ratio and kinetic friction stand for the same", "choose one of them")
    bands = {
        name: band
        for name in BANDS
        if (band := _band(name, texts, drive.label if texts["drive"] != "line" else "", drawn, wrong))
    }
    if {"kinetic_friction", "friction_ratio"} <= bands.keys():
        wrong.add("friction_ratio_band", "kinetic friction has a band too", "leave one of them out")
    static, kinetic = (
        bands.get(name, (point.fixed[name],) * 2) for name in ("static_friction", "kinetic_friction")
    )
    follows = "friction_ratio" in bands or (texts["follow"] == "1" and "kinetic_friction" not in bands)
    if bands and not follows and kinetic[0] > static[1]:
        key = next(f"{name}_band" for name in reversed(BANDS) if name in bands)
        least, most = number_text(kinetic[0]), number_text(static[1])
        wrong.add(key, f"kinetic friction = {least} and more: must reach down to static friction = {most}")
    target = None
    if texts["target"]:
        target = wrong.read("target", lambda: _checked(texts["target"], LEAST_SPEED))
    if texts["view"] == "traverse" and point.length is None:
        wrong.add("trough_length_mm", "the traverse time needs the length of the trough", "give it")
    wrong.settle()
    kept = {QUANTITIES[name].column: number_text(value) for name, value in point.fixed.items()}
    length = "" if point.length is None else number_text(point.length)
    canonical = {
        **{key: texts[key] for key in _OTHERS},
        **{key: kept[key] for key in (QUANTITIES[name].column for name in shown_names) if key in kept},
        "trough_length_mm": length,
        **{key: axis.quantity.column for key, axis in axes.items()},
        **{f"{key}_range": _range_text(axis) for key, axis in axes.items()},
        **{f"{name}_band": ":".join(map(number_text, band)) for name, band in bands.items()},
        "target": "" if target is None else number_text(target),
    }
    return State(canonical, point, x, y, bands, target)


def _point(texts: Mapping[str, str], names: list[str], wrong: _Wrong) -> Request:
    """Read the operating point."""
    given: dict[str, AxisSpec | InputError] = {}
    for name in names:
        quantity = QUANTITIES[name]
        text = texts[quantity.column]
        if name == "trough_length" and not text:
            continue
        try:
            given[name] = parse_axis(text, quantity)
        except InputError as exc:
            given[name] = exc
    try:
        return gather(given, None, _Page())
    except InputError as exc:
        fields = [QUANTITIES[f].column if f in QUANTITIES else f for f in exc.fields]
        raise InputError(*exc.problems, hint=exc.hint, fields=fields) from None


def _axis(key: str, usual: str, count: int, texts: Mapping[str, str], names: list[str], wrong: _Wrong) -> Any:
    """Read an axis of the map; None on an error."""
    column, text = texts[key], texts[f"{key}_range"]
    quantity = BY_COLUMN.get(column) if column else QUANTITIES[usual]
    if quantity is None or quantity.name not in names:
        columns = ", ".join(QUANTITIES[name].column for name in names)
        wrong.add(key, f"{key} = {shown(column)}: no axis of this drive", f"choose from {columns}")
        return None
    spec = wrong.read(f"{key}_range", lambda: parse_axis(text or CONTROLS[quantity.name].axis, quantity))
    if spec is None:
        return None
    if not spec.is_range or spec.count is not None:
        wrong.add(f"{key}_range", f"{quantity.label} = {cut(text)}: must be a range", "write it like 0.1:3")
        return None
    axis = wrong.read(f"{key}_range", lambda: spec.axis(count))
    if axis is None:
        return None
    values = axis.values
    if not quantity.allows(quantity.to_si(values)).all():
        allowed = quantity.allowed.text(quantity.unit)
        wrong.add(f"{key}_range", f"{quantity.label} = {cut(text)}: must be {allowed}")
        return None
    return spec


def _band(
    name: str, texts: Mapping[str, str], other_drive: str, drawn: set[str], wrong: _Wrong
) -> tuple[float, float] | None:
    """Read the band of a friction; None without one."""
    key, quantity = f"{name}_band", QUANTITIES[name]
    if not texts[key]:
        return None
    if other_drive:
        said = f"bands of friction are not known of drives {other_drive}"
        wrong.add(key, said, "take a drive along a line")
        return None
    if drawn & {*BANDS}:
        wrong.add(
            key, "a friction that is drawn over has no band", "choose other axes, or leave the band out"
        )
        return None
    low, colon, high = texts[key].partition(":")
    texts_of_ends = (low, high if colon else low)
    ends = [wrong.read(key, lambda text=text: _checked(text, quantity)) for text in texts_of_ends]
    if None in ends:
        return None
    if ends[0] > ends[1]:
        wrong.add(key, f"{quantity.label} = {cut(texts[key])}: the band does not ascend", "swap its ends")
        return None
    if name == "static_friction" and not ends[0]:
        wrong.add(key, "bodies without static friction have no regime", "begin the band above 0")
        return None
    return ends[0], ends[1]


def _checked(text: str, quantity: Quantity) -> float:
    """Read a number, and check its range."""
    value = float(exact_number(text, quantity))
    if not quantity.allows(quantity.to_si(value)):
        raise InputError(f"{quantity.label} = {cut(text)}: must be {quantity.allowed.text(quantity.unit)}")
    return value


def _range_text(spec: AxisSpec) -> str:
    return ":".join(map(number_text, spec.values)) + ":log" * spec.log


def number_text(value: Fraction | float) -> str:
    """Write a number as people type it, such that it is read as the same double."""
    return f"{float(value):.15g}" if float(f"{float(value):.15g}") == float(value) else repr(float(value))
