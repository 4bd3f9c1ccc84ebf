"""What the page shows first: the scene of a request, its drive or machine, and the axes of its map."""

from __future__ import annotations

import hashlib
import json
import re
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, Final, NamedTuple

import numpy as np

from vibro.answers.machine import machine_parts
from vibro.axes import axis_of
from vibro.drives import HarmonicMotion, PiecewiseMotion
from vibro.explore.controls import (
    BANDS,
    CONTROLS,
    DRIVEN,
    DRIVES,
    GIVEN,
    Control,
    drive_named,
    given_drive,
    machine_drive,
)
from vibro.files.descriptions import EXAMPLES
from vibro.files.motions import GivenMotion
from vibro.files.scene_files import SceneFile
from vibro.plots.style import visible
from vibro.quantities import (
    AMPLITUDES,
    DEFAULTS,
    MACHINE,
    QUANTITIES,
    RATES,
    SCALE,
    kinetic_friction,
    with_amplitude,
)
from vibro.scene import check_single, harmonic_values, values_of
from vibro.sweeps.request import RANGES, Request

if TYPE_CHECKING:
    from fractions import Fraction

    from vibro.axes import AxisSpec
    from vibro.explore.controls import Drive
    from vibro.files.machines import GivenMachine
    from vibro.scene import Scene

_FINGERPRINT: Final = 8  # hexadecimal digits
_LONGEST: Final = 60  # letters of a file's name
#: Values of quantities where no scene gives one, in the units outside: the nut of examples/safety_nut.toml,
#: and drives of other kinds with about its load.
USUAL: Final = {**EXAMPLES, **DEFAULTS, "normal_amplitude_2": 0.0, "normal_phase_2": 0.0, SCALE: 1.0}
_OTHERS: Final = {
    "drive": "line",
    "motion": "",  # of the drives GIVEN and DRIVEN, to distinguish scene files
    "view": "regime",
    "x": "",
    "y": "",
    "x_range": "",
    "y_range": "",
    "follow": "1",
    **{f"{name}_band": "" for name in BANDS},
    "target": "",
    "cycles": "3",
}


class _Start(NamedTuple):
    """A scene as the page begins with it.

    Attributes
    ----------
    point : dict of str to float
        The operating point, in the units outside.
    drive : str
        Name of its drive.
    own : Drive or None
        That drive, if the page has it for this scene alone.
    values : dict of str to float
        Quantities of the drive ``GIVEN`` without sliders.
    """

    point: dict[str, float]
    drive: str
    own: Drive | None
    values: dict[str, float]


def scene_data(request: Request | None = None) -> dict[str, Any]:
    """Return a scene as the page begins with it, as JSON values.

    Parameters
    ----------
    request : Request, optional
        Request of a scene file and options; its first two axes are drawn, and the operating point has the
        scene's values, or the usual ones, or those in the middle of the axes. Without it the nut of
        examples/safety_nut.toml.

    Returns
    -------
    dict
        ``name``; ``file``, with which the names of its downloads begin; ``state``, texts by the keys of the
        page's address, empty where the page has usual ones; ``controls`` by name, where sliders have to reach
        other values than usual; ``given``, the drive of a scene that no sliders can make, or None;
        ``machine``, from which the amplitude follows, or None.
    """
    texts = dict(_OTHERS)
    if request is None:
        own: dict[str, Any] = {"state": texts, "controls": {}, "given": None, "machine": None}
        return {"name": "", "file": file_name([]), **own}
    start = _start_of(request)
    texts |= {"trough_length_mm": "", "drive": start.drive}
    if start.own is None:
        texts |= {QUANTITIES[name].column: "0" for name in DRIVES[start.drive].quantities}
    else:
        texts["motion"] = _fingerprint(start.values, request.motion, request.machine)
    texts |= {QUANTITIES[name].column: typed_number(value) for name, value in start.point.items()}
    texts |= _axes_of(request, start.own or DRIVES[start.drive])
    return {
        "name": visible(request.name or ""),
        "file": file_name([request.name or "scene"]),
        "state": texts,
        "controls": {name: control._asdict() for name, control in _reaching(start).items()},
        "given": _given(start, request) if start.drive == GIVEN else None,
        "machine": _driven(start, request.machine) if request.machine is not None else None,
    }


def file_name(names: Sequence[str]) -> str:
    """Return a file's name that people recognise, in letters that every system takes."""
    joined = "-".join([*filter(None, names)] or ["nut"])
    return f"vibro-{re.sub(r'[^0-9A-Za-z_.-]+', '-', joined).strip('-.')[:_LONGEST] or 'scene'}"


def nut_file() -> SceneFile:
    """Return the scene that the page begins with where no file gives one, as if one did."""
    names = (*DRIVES["line"].quantities, "frequency", "static_friction", "kinetic_friction", "trough_length")
    return SceneFile("nut", {name: axis_of(EXAMPLES[name], QUANTITIES[name]) for name in names}, {})


def request_of_scene(scene: Scene) -> Request:
    """Return the request of a single scene, as if a scene file gave it.

    Raises
    ------
    SceneError
        If it is more than one scene.
    """
    check_single(scene)
    motion = scene.motion
    values = values_of(scene)
    specs = {name: axis_of(values[name], QUANTITIES[name]) for name in QUANTITIES if name in values}
    given = GivenMotion(_table_of(motion), motion) if isinstance(motion, PiecewiseMotion) else None
    return Request(None, specs, {}, given)


def _table_of(motion: PiecewiseMotion) -> dict[str, Any]:
    """Return the table [motion] that gives the same pieces: steps, or samples at equal distances."""
    shares, starts = np.diff(motion.breaks), motion.pieces[:, :, 0]
    steps = not motion.pieces[:, :, 1:].any()
    return {
        f"{way}_steps" if steps else f"{way}_samples_m_s2": np.column_stack([shares, at]).tolist()
        if steps
        else at.tolist()
        for way, at in zip(("along", "normal"), starts, strict=True)
        if way == "along" or at.any()
    }


def _start_of(request: Request) -> _Start:
    """Choose the operating point and the drive."""
    point = request.fixed | ({} if request.length is None else {"trough_length": request.length})
    if not point.get("along_phase"):  # where phases are counted from
        point.pop("along_phase", None)
    for name in request.varying:
        values, usual = request.axes()[name].values, QUANTITIES[name].default
        if usual is None or not values[0] <= usual <= values[-1]:
            usual = float(values[len(values) // 2])
        point[name] = request.own.get(name, usual)
    point = {name: value for name, value in with_amplitude(point).items() if name not in RATES}
    names = [name for name in (*request.drive, "normal_acceleration") if name in point]
    if "friction_ratio" in point:
        mu_d = float(kinetic_friction(point.pop("friction_ratio"), point["static_friction"]))
        own = request.own if "friction_ratio" in request.varying else {}
        point["kinetic_friction"] = own.get("kinetic_friction", mu_d)
    if request.machine is not None:
        return _Start(point, DRIVEN, machine_drive(request.machine, point), {})
    if drive := "" if request.motion else drive_named(names):
        return _Start(point, drive, None, {})
    own_drive = given_drive(names, varying=request.varying)
    fixed = {name: point.pop(name) for name in names if name not in own_drive.quantities}
    if request.motion and isinstance(request.motion.motion, HarmonicMotion):
        fixed |= harmonic_values(request.motion.motion)
    return _Start(point, GIVEN, own_drive, fixed)


def _drawn(request: Request) -> list[str]:
    """Return the axes of the map, across first, of those that vary."""
    drawn = [name for name in request.varying if name in CONTROLS]
    if "frequency" in drawn and drawn[0] in AMPLITUDES:  # as pictures have it
        drawn = ["frequency", *(name for name in drawn if name != "frequency")]
    return drawn[:2]


def held(request: Request) -> list[str]:
    """Return the quantities that vary, and that the page holds, as its map has two axes."""
    drawn = _drawn(request)
    return [name for name in request.varying if name not in drawn]


def _axes_of(request: Request, drive: Drive) -> dict[str, str]:
    """Return the axes of the map and their ranges, as texts; none where the page has usual ones."""
    texts, drawn = {}, _drawn(request)
    for key, name in zip("xy", drawn, strict=False):
        text = _range_text(request.specs[name])
        texts[key] = QUANTITIES[name].column
        # Where nobody gave a range, that of the machine's slider is nearer to its resonance.
        is_usual = request.machine is not None and text == RANGES.get(name)
        texts[f"{key}_range"] = "" if is_usual else text
    if len(drawn) == 1:
        texts["y"] = next(QUANTITIES[n].column for n in (drive.y, drive.x) if n != drawn[0])
    return texts


def _reaching(start: _Start) -> dict[str, Control]:
    """Return sliders that differ from the usual ones: the machine's own, and those that reach the scene."""
    found = dict(start.own.controls) if start.own else {}
    for name in (name for name in CONTROLS if name in start.point):
        low, high, step, axis = found.get(name, CONTROLS[name])
        value, allowed = start.point[name], QUANTITIES[name].allowed
        if not low <= value <= high:
            low = max(min(low, value, 2.0 * value), allowed.low)
            high = min(max(high, value, 2.0 * value), allowed.high)
            found[name] = Control(low, high, step, axis)
    return found


def _given(start: _Start, request: Request) -> dict[str, Any]:
    """Describe the drive of a scene that the page's sliders cannot make.

    ``values`` has those of its quantities that stay, in the units outside; ``motion`` of pieces is what the
    solver reads, and ``table`` are the lines of [motion] in the scene file; with these it has no ``values``.
    """
    assert start.own is not None
    table = {} if request.motion is None else request.motion.table
    pieces = None
    if request.motion and isinstance(request.motion.motion, PiecewiseMotion):
        pieces = pieces_data(request.motion.motion)
    return {
        **start.own.data(),
        "kind": "harmonics" if pieces is None else "pieces",
        "values": start.values,
        "motion": pieces,
        "table": [f"{key} = {_toml(value)}" for key, value in table.items()],
    }


def pieces_data(motion: PiecewiseMotion) -> dict[str, Any]:
    """Describe steps or samples, as the page's solver reads them, and their path at 1 Hz."""
    lists = {"breaks": motion.breaks, "pieces": motion.pieces.ravel(), "jumps": motion.jumps}
    sizes = {name: getattr(motion, name) for name in ("unit", "stroke", "largest_acceleration")}
    return {**sizes, **{name: x.tolist() for name, x in lists.items()}}


def _driven(start: _Start, given: GivenMachine) -> dict[str, Any]:
    """Describe a machine: its fields in SI units, its knobs, and its table as the scene file has it."""
    assert start.own is not None
    return {
        **start.own.data(),
        "fields": vars(given.machine) | {"share": given.share},
        "parts": machine_parts(given),
        "knobs": [name for name in MACHINE if given.takes(name)],
        "own": given.own,
        "packs": {visible(name): natural for name, natural in given.packs.items()},
        "table": {key: _toml(value) for key, value in given.table.items()},
    }


def _fingerprint(fixed: Mapping[str, float], motion: GivenMotion | None, machine: GivenMachine | None) -> str:
    """Return a short text that differs where another drive is given."""
    text = repr((fixed, motion and motion.table))
    if machine is not None:  # but for its knobs
        knobs = {QUANTITIES[name].column for name in MACHINE if name != "natural"}
        text += repr({key: value for key, value in machine.table.items() if key not in knobs})
    return hashlib.sha256(text.encode(errors="backslashreplace")).hexdigest()[:_FINGERPRINT]


def _toml(value: object) -> str:
    """Write a value of a scene file."""
    if isinstance(value, str):
        return json.dumps(value, ensure_ascii=False)
    if isinstance(value, Mapping):
        return f"{{ {', '.join(f'{json.dumps(key)} = {_toml(x)}' for key, x in value.items())} }}"
    if isinstance(value, Sequence):
        return f"[{', '.join(map(_toml, value))}]"
    return str(value)


def _range_text(spec: AxisSpec) -> str:
    """Write the range of an axis; of a list from its first value to its last."""
    return f"{typed_number(spec.values[0])}:{typed_number(spec.values[-1])}" + ":log" * spec.log


def typed_number(value: Fraction | float) -> str:
    """Write a number as people type it, such that it is read as the same double."""
    return f"{float(value):.15g}" if float(f"{float(value):.15g}") == float(value) else repr(float(value))
