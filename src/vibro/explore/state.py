"""State of the page, read from the texts of its address and checked: the solver gets no other input."""

from __future__ import annotations

import hashlib
import math
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Final

from vibro.axes import AxisSpec, parse_axis
from vibro.errors import InputError, Problems, cut, shown
from vibro.explore.controls import (
    BANDS,
    CONTROLS,
    DRIVEN,
    DRIVES,
    GIVEN,
    VIEWS,
    drive_named,
    drives_of,
    given_drive,
    is_weighed,
    machine_drive,
)
from vibro.files.descriptions import EXAMPLES
from vibro.files.scene_files import SceneFile
from vibro.quantities import (
    AMPLITUDES,
    BY_COLUMN,
    DEFAULTS,
    LEAST_SPEED,
    MACHINE,
    QUANTITIES,
    SCALE,
    SWEPT,
    checked_number,
    kinetic_friction,
    of_part,
)
from vibro.sweeps.grid import Grid
from vibro.sweeps.request import RANGES, Request, gather

if TYPE_CHECKING:
    from collections.abc import Mapping
    from fractions import Fraction

    from vibro.axes import Axis
    from vibro.explore.controls import Control, Drive
    from vibro.quantities import Quantity

__all__ = ["HEIGHT", "WIDTH", "State", "initial_state", "read_state", "typed_number"]

#: [cells] of a map.
WIDTH: Final = 200
HEIGHT: Final = 150

_OF_FILE: Final = (GIVEN, DRIVEN)
_FINGERPRINT: Final = 8  # hexadecimal digits
_AROUND: Final = 3.0  # factor between an operating point and the ends of an axis around it
_MOST_CYCLES: Final = 20  # drive cycles of a history: more could not be distinguished
# The nut of examples/safety_nut.toml, and drives of other kinds with about its load.
_VALUES: Final = {**EXAMPLES, **DEFAULTS, "normal_amplitude_2": 0.0, "normal_phase_2": 0.0, SCALE: 1.0}
_USUAL: Final = {
    QUANTITIES[n].column: f"{_VALUES[n]:g}" for n in CONTROLS if n in _VALUES and n != "friction_ratio"
}
_OTHERS: Final = {
    "drive": "line",
    "motion": "",  # of the drives GIVEN and DRIVEN, to distinguish scene files
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
    takes_one_value = ("it takes one value", "write 1.25 or 1250, not 1,250; axes are chosen at the map")

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
    drives : mapping of str to Drive
        Those that can be chosen, by name.
    file : SceneFile
        Name of the scene, and what the drives ``GIVEN`` and ``DRIVEN`` have besides quantities with sliders.
    """

    texts: Mapping[str, str]
    point: Request
    x: AxisSpec
    y: AxisSpec
    bands: Mapping[str, tuple[float, float]]
    target: float | None
    drives: Mapping[str, Drive]
    file: SceneFile

    @property
    def is_given(self) -> bool:
        """Whether the drive is that of the scene which ``file`` describes."""
        return self.texts["drive"] in _OF_FILE

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
        axes = {axis.name: axis for axis in map(drawn.get, SWEPT) if axis}
        return Grid(axes, fixed, self.point.length, motion=self.point.motion, machine=self.point.machine)


def initial_state(request: Request | None = None) -> State:
    """Return the state at the start.

    Parameters
    ----------
    request : Request, optional
        Request of a scene file and options; its first two axes are drawn, and the operating point has the
        scene's values, or the usual ones, or those in the middle of the axes. Without it the nut of
        examples/safety_nut.toml.
    """
    if request is None:
        return _state({**_USUAL, **_OTHERS}, DRIVES, SceneFile("", {}, {}))
    point = request.fixed | ({} if request.length is None else {"trough_length": request.length})
    if not point.get("along_phase"):  # where phases are counted from
        point.pop("along_phase", None)
    names = [n for n in (*request.drive, "normal_acceleration") if n in {*point, *request.varying}]
    drive = DRIVEN if request.machine else "" if request.motion else drive_named(names)
    drives, file = DRIVES, SceneFile(request.name or "", {}, {})
    texts = {**_USUAL, **_OTHERS, "trough_length_mm": ""}
    if request.machine:
        file = replace(file, machine=request.machine)
    elif drive:
        texts |= {QUANTITIES[name].column: "0" for name in DRIVES[drive].quantities}  # unless it is given
    else:
        drive, drives = GIVEN, {**DRIVES, GIVEN: given_drive(names, varying=request.varying)}
        unmoved = {name: request.specs[name] for name in names if name not in drives[GIVEN].quantities}
        file = replace(file, scene=unmoved, motion=request.motion)
    texts["drive"] = drive
    for name in request.varying:
        values, usual = request.axes()[name].values, QUANTITIES[name].default
        if usual is None or not values[0] <= usual <= values[-1]:
            usual = float(values[len(values) // 2])
        point[name] = request.own.get(name, usual)
    if "friction_ratio" in point:
        mu_d = float(kinetic_friction(point.pop("friction_ratio"), point["static_friction"]))
        own = request.own if "friction_ratio" in request.varying else {}
        point["kinetic_friction"] = own.get("kinetic_friction", mu_d)
    if request.machine:
        drives = {DRIVEN: machine_drive(request.machine, point), **DRIVES}
    texts |= {QUANTITIES[name].column: typed_number(value) for name, value in point.items()}
    drawn = [name for name in request.varying if name in CONTROLS]
    if "frequency" in drawn and drawn[0] in AMPLITUDES:  # as pictures have it
        drawn = ["frequency", *(name for name in drawn if name != "frequency")]
    for key, name in zip("xy", drawn, strict=False):
        spec = request.specs[name]
        texts[key] = QUANTITIES[name].column
        # Where nobody gave a range, that of the machine's slider is nearer to its resonance.
        is_usual = request.machine is not None and _range_text(spec) == RANGES.get(name)
        texts[f"{key}_range"] = "" if is_usual else _range_text(spec)
    if len(drawn) == 1:
        texts["y"] = next(QUANTITIES[n].column for n in (drives[drive].y, drives[drive].x) if n != drawn[0])
    return _state(texts, drives, file)


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
    texts |= {key: text.strip() for key, text in query.items()}
    return _state(texts, initial.drives, initial.file)


def _state(texts: dict[str, str], drives: Mapping[str, Drive], file: SceneFile) -> State:
    wrong = Problems()
    choices = {"drive": (*drives,), "view": (*VIEWS,), "follow": ("0", "1")}
    for key, known in choices.items():
        if texts[key] not in known:
            wrong.add(f"{key} = {shown(texts[key])}: must be {', '.join(known)}", field=key)
    if texts["cycles"] not in map(str, range(1, _MOST_CYCLES + 1)):
        said = shown(texts["cycles"])
        wrong.add(f"cycles = {said}: must be a whole number from 1 to {_MOST_CYCLES}", field="cycles")
    wrong.settle()
    is_given = texts["drive"] in _OF_FILE
    motion = _fingerprint(file) if is_given else ""
    if is_given and texts["motion"] not in ("", motion):
        hint = "start vibro explore with the scene file of the link"
        what = "machine" if texts["drive"] == DRIVEN else "motion"
        wrong.add(f"the link is of another {what} than that of the scene", hint, "drive")
    drive = drives[texts["drive"]]
    names = [name for name in CONTROLS if texts["drive"] in drives_of(name, drives)]
    shown_names = [name for name in names if name != "friction_ratio"]
    point = _point(texts, shown_names, file if is_given else SceneFile(file.name, {}, {}))
    axes = {}
    for key, usual, count in (("x", drive.x, WIDTH), ("y", drive.y, HEIGHT)):
        with wrong.taken(field=f"{key}_range"):
            axes[key] = _axis(key, usual, count, texts, [n for n in SWEPT if n in names], point.fixed, drive)
    wrong.settle()
    x, y = axes["x"], axes["y"]
    drawn = {axis.quantity.name for axis in (x, y)}
    if len(drawn) == 1:
        wrong.add(f"x and y are both {x.quantity.label}", "choose two quantities", "y")
    elif {"friction_ratio", "kinetic_friction"} == drawn:
        wrong.add("friction ratio and kinetic friction describe the same", "choose one of them", "y")
    bands = {}
    weighed = is_weighed(point.machine, drawn, point.fixed)
    for name in BANDS:
        if text := texts[f"{name}_band"]:
            with wrong.taken(field=f"{name}_band"):
                bands[name] = _band(name, text, texts["drive"], drawn, of_filling=weighed)
    if {"kinetic_friction", "friction_ratio"} <= bands.keys():
        wrong.add("kinetic friction has a band too", "leave one of them out", "friction_ratio_band")
    static, kinetic = (
        bands.get(name, (point.fixed[name],) * 2) for name in ("static_friction", "kinetic_friction")
    )
    follows = "friction_ratio" in bands or (texts["follow"] == "1" and "kinetic_friction" not in bands)
    if bands and not follows and kinetic[0] > static[1]:
        key = next(f"{name}_band" for name in reversed(BANDS) if name in bands)
        least, most = typed_number(kinetic[0]), typed_number(static[1])
        said = f"kinetic friction = {least} and more: must reach down to static friction = {most}"
        wrong.add(said, field=key)
    target = None
    if texts["target"]:
        with wrong.taken(field="target"):
            target = checked_number(texts["target"], LEAST_SPEED)
    if texts["view"] == "traverse" and point.length is None:
        wrong.add("the traverse time needs the length of the trough", "give it", "trough_length_mm")
    wrong.settle()
    kept = {name: typed_number(value) for name, value in point.fixed.items()}
    kept["trough_length"] = "" if point.length is None else typed_number(point.length)
    canonical = {
        **{key: texts[key] for key in _OTHERS},
        "motion": motion,
        **{QUANTITIES[name].column: kept[name] for name in shown_names if name in kept},
        **{key: axis.quantity.column for key, axis in axes.items()},
        **{f"{key}_range": _range_text(axis) for key, axis in axes.items()},
        **{f"{name}_band": ":".join(map(typed_number, band)) for name, band in bands.items()},
        "target": "" if target is None else typed_number(target),
    }
    return State(canonical, point, x, y, bands, target, drives, file)


def _fingerprint(file: SceneFile) -> str:
    """Return a short text that differs where another drive is given."""
    table = file.motion and file.motion.table
    told = repr(({name: float(spec.value) for name, spec in file.scene.items()}, table))
    if file.machine is not None:  # but for its knobs
        knobs = {QUANTITIES[name].column for name in MACHINE if name != "natural"}
        told += repr({key: value for key, value in file.machine.table.items() if key not in knobs})
    return hashlib.sha256(told.encode()).hexdigest()[:_FINGERPRINT]


def _point(texts: Mapping[str, str], names: list[str], file: SceneFile) -> Request:
    """Read the operating point; quantities without a slider come from the file."""
    given = {name: texts[QUANTITIES[name].column] for name in names}
    if not given["trough_length"]:
        del given["trough_length"]
    try:
        return gather(given, file, _Page())
    except InputError as exc:
        fields = [QUANTITIES[f].column if f in QUANTITIES else f for f in exc.fields]
        raise InputError(*exc.problems, hint=exc.hint, fields=fields) from None


def _axis(
    key: str,
    usual: str,
    count: int,
    texts: Mapping[str, str],
    names: list[str],
    point: Mapping[str, float],
    drive: Drive,
) -> AxisSpec:
    """Read an axis of the map; raises InputError for a wrong range, which may name another field."""
    column, text = texts[key], texts[f"{key}_range"]
    quantity = BY_COLUMN.get(column) if column else QUANTITIES[usual]
    if quantity is None or quantity.name not in names:
        hint = f"choose from {', '.join(QUANTITIES[name].column for name in names)}"
        raise InputError(f"{key} = {shown(column)}: no axis of this drive", hint=hint, fields=[key])
    control = drive.controls.get(quantity.name, CONTROLS[quantity.name])
    spec = parse_axis(text or _usual_range(quantity, control, point.get(quantity.name, math.nan)), quantity)
    if not spec.is_range or spec.count is not None:
        raise InputError(f"{quantity.label} = {cut(text)}: must be a range", hint="write it like 0.1:3")
    quantity = of_part(quantity, is_clamped="normal_acceleration" in point)
    if not quantity.allows(quantity.to_si(spec.axis(count).values)).all():
        allowed = quantity.allowed.text(quantity.unit)
        raise InputError(f"{quantity.label} = {cut(text)}: must be {allowed}")
    return spec


def _usual_range(quantity: Quantity, control: Control, value: float) -> str:
    """Return the range of a newly chosen axis; where it misses the operating point, one around that."""
    text = control.axis
    low, high = map(float, text.split(":"))
    outside = 0.0 < value < low or value > high
    if not outside or not quantity.allows(quantity.to_si(value * _AROUND)):
        return text
    return f"{value / _AROUND:.3g}:{value * _AROUND:.3g}"


def _band(name: str, text: str, drive: str, drawn: set[str], *, of_filling: bool) -> tuple[float, float]:
    """Read the band of a friction."""
    quantity = QUANTITIES[name]
    if drive not in ("line", DRIVEN):
        said = "bands of friction are possible only for drives along a line"
        raise InputError(said, hint="take a drive along a line")
    if of_filling:
        said = "the force of a filling depends on its friction: with a filling no band of it is possible"
        raise InputError(said, hint="set the filling to 0, or give added_mass_share in [machine]")
    if drawn & {*BANDS}:
        hint = "choose other axes, or leave the band out"
        raise InputError("a friction that is an axis of the map cannot have a band", hint=hint)
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
    return f"{typed_number(spec.values[0])}:{typed_number(spec.values[-1])}" + ":log" * spec.log


def typed_number(value: Fraction | float) -> str:
    """Write a number as people type it, such that it is read as the same double."""
    return f"{float(value):.15g}" if float(f"{float(value):.15g}") == float(value) else repr(float(value))
