"""Read and check questions of inverse design, from files or mappings."""

from __future__ import annotations

import math
import os
from collections import Counter
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from vibro.designs.machine_drives import machine_drives
from vibro.designs.questions import Drift, Drive, Goal, Spec
from vibro.designs.spaces import SPACES, MotionSpace
from vibro.drives import Ellipse, HarmonicMotion, Harmonics, Line, Motion, Piecewise
from vibro.errors import InputError, Problems, shown
from vibro.files.descriptions import DESIGN_FILE, MACHINE_KEYS
from vibro.files.entries import ABSENT
from vibro.files.machines import given_machine
from vibro.files.motions import MOTIONS, motion_of
from vibro.files.toml_files import read_toml, refuse_other_kinds, refuse_unknown_tables
from vibro.friction import static_row
from vibro.quantities import ELLIPTICAL, LINEAR, QUANTITIES, SCALE

if TYPE_CHECKING:
    from collections.abc import Sequence

    from vibro.files.entries import Span, Table
    from vibro.friction import Row

# [rad] Exceeds the rounding of four angles near 90 deg that are converted and added.
_ROUNDED: Final = 1e-15
# [1] Far beyond any machine; above it, loads and their bounds leave the range in which searches converge.
_MOST_LOAD: Final = 1e9
_LINE: Final = (*LINEAR, "stroke")
# Stands for a motion that is refused, so that the rest is checked.
_UNREAD: Final = Motion.harmonics(along=[(1e-3, 0.0)])
_SETTING: Final = QUANTITIES["setting"].column
_SEVERAL: Final = ("frequency", "drive_angle")  # knobs that may have several ranges
_PAIRS: Final = "either amplitude_mm and drive_angle_deg, or along_amplitude_mm and normal_amplitude_mm"


def read_spec(source: str | os.PathLike[str] | Mapping[str, Any]) -> Spec:
    """Read a question of inverse design.

    Parameters
    ----------
    source : path or mapping
        TOML with the tables ``[scene]``, ``[[drive]]``, ``[goal]`` and, optionally, ``[drift]`` and
        ``[part]``, or a mapping with the same keys; docs/reference/design-files.md lists them.

    Returns
    -------
    Spec
        In SI units and radians. A band of kinetic friction is as given; ``Question.box`` cuts it at static
        friction.

    Raises
    ------
    FileError
        If the file cannot be read.
    InputError
        If something is wrong; everything is named, each with its table and key. Of a scene file that alone.

    Examples
    --------
    >>> spec = read_spec({
    ...     "scene": {"static_friction": "0.3:0.5", "friction_ratio": "0.7:0.9", "trough_length_mm": 1200},
    ...     "drive": [{"amplitude_mm": 0.8, "frequency_hz": "50, 100", "drive_angle_deg": "10:40"}],
    ...     "goal": {"traverse_time_s": 15},
    ... })
    >>> spec.drives[0].frequency, spec.goal.speed
    (((50.0, 50.0), (100.0, 100.0)), 0.08)
    """
    if isinstance(source, Mapping):
        return _spec(source, "", Problems(), None)
    if not isinstance(source, str | os.PathLike):
        raise InputError(f"{shown(source)}: must be a path, or a mapping with the tables of a question")
    path = Path(source)
    content = read_toml(path)
    refuse_other_kinds(content, DESIGN_FILE, path)
    return _spec(content, path.stem, Problems(f"{path}: "), path.parent)


def _spec(content: Mapping[Any, Any], name: str, problems: Problems, folder: Path | None) -> Spec:
    refuse_unknown_tables(content, DESIGN_FILE, problems)
    scene, drift, goal, part = (
        DESIGN_FILE.table(table, content.get(table, ABSENT), problems)
        for table in ("scene", "drift", "goal", "part")
    )
    tables = _drive_tables(content.get("drive", []), problems)
    bands = _bands(scene, problems)
    drives = [
        (drive, table)
        for i, table in enumerate(tables, 1)
        for drive in _drives(table, f"drive {i}", problems, folder, drift.values.get("frequency", 0.0))
    ]
    spec = Spec(
        bands=bands,
        drives=tuple(drive for drive, _ in drives),
        goal=_goal(goal, scene),
        drift=Drift(**drift.values),
        length=scene.values.get("trough_length"),
        gravity=scene.values.get("gravity", Spec.gravity),
        restitution=scene.values.get("restitution"),
        stand_ratio=_stand_ratio(part) if "part" in content else Spec.stand_ratio,
        name=name,
    )
    _check_names(spec.drives, problems)
    _check_drift(spec, drift)
    _check_angles(spec, drives, problems)
    _check_accelerations(spec.gravity, drives)
    problems.settle()
    return spec


def _bands(scene: Table, problems: Problems) -> dict[str, Span]:
    static: Any = scene.values.get("static_friction")
    row: Row | None = None
    named = isinstance(static, str)
    if named:
        with problems.taken(f"{scene.heading} static_friction = "):
            row = static_row(static)
        static = row and row.static_friction
    keys = [key for key in ("kinetic_friction", "friction_ratio") if key in scene.given]
    bands = {"static_friction": static} | {key: scene.values.get(key) for key in keys}
    if keys or not named:
        scene.needs("kinetic_friction", "friction_ratio")
    elif row:
        bands["kinetic_friction"] = row.kinetic_friction
        if not row.kinetic_friction:
            hint = "give kinetic_friction or friction_ratio too"
            scene.refuse("static_friction", "the catalogue has no kinetic friction of it", hint)
    bands["trough_angle"] = scene.values.get("trough_angle", (0.0, 0.0))
    known = {key: ends for key, ends in bands.items() if ends}
    kinetic = known.get("kinetic_friction", (0.0, 0.0))
    if static and kinetic[0] > static[1]:
        why = f"all of it is above static friction, which is at most {static[1]:g}"
        scene.refuse("kinetic_friction", why)
    return known


def _drive_tables(given: Any, problems: Problems) -> list[Table]:
    """Read the drives; a single one may be a table of its own."""
    tables = list(given) if isinstance(given, list | tuple) else [given]
    if not tables:
        kind = DESIGN_FILE.tables["drive"]
        example = ", ".join(kind.example(key) for key in ("amplitude_mm", "frequency_hz", "drive_angle_deg"))
        problems.add(
            "[[drive]] is missing: there must be one drive or more", f"[[drive]] for example: {example}"
        )
    several = len(tables) > 1
    return [DESIGN_FILE.table("drive", table, problems, several * i) for i, table in enumerate(tables, 1)]


def _drives(
    table: Table, usual_name: str, problems: Problems, folder: Path | None, drift: float
) -> list[Drive]:
    """Read a drive; a machine is one for each spring pack and frequency."""
    keys = {key: entry.quantity.name for key, entry in MACHINE_KEYS.items() if key in table.given}
    if not keys:
        return [_drive(table, usual_name, problems)]
    others = [*_keys(("amplitude", "stroke", *ELLIPTICAL)), *(key for way in MOTIONS for key in way), SCALE]
    for key in others:
        if key in table.given:
            hint = 'leave it out: setting_percent = "20:100" says what may be chosen'
            table.refuse(key, "not beside a machine, whose amplitude follows from its setting", hint)
    table.needs("drive_angle_deg")
    if not table.values.keys() >= {*keys.values()}:
        return []
    drives: list[Drive] = []
    with problems.taken(f"{table.heading} "):
        values = {name: table.values[name] for name in keys.values()}
        choices = {_SETTING: 100.0} if _SETTING in keys else {}  # no setting of its own
        given = given_machine({key: table.given[key] for key in keys} | choices, values, folder)
        drives += machine_drives(table, given, usual_name, drift)
    return drives


def _drive(table: Table, usual_name: str, problems: Problems) -> Drive:
    if any(key in table.given for way in MOTIONS for key in way):
        return _moved_drive(table, usual_name, problems)
    if SCALE in table.given:
        table.refuse(SCALE, "without a motion", "give one, such as along_steps = [[0.8, 6.9], [0.2, -27.6]]")
    elliptical = [key for key in _keys(ELLIPTICAL) if key in table.given]
    if elliptical:
        for key in _keys(ELLIPTICAL[:2]):
            table.needs(key)
        for key in _keys(_LINE):
            if key in table.given:
                beside = " and ".join(elliptical)
                table.refuse(key, f"not beside {beside} of an elliptical drive", f"give {_PAIRS}")
    else:
        table.needs("amplitude_mm", "stroke_mm")
        table.needs("drive_angle_deg")
    kind, values = Ellipse if elliptical else Line, table.values
    low, high = values.get("stroke", (0.0, 0.0))
    usual = {"amplitude": (low / 2.0, high / 2.0), **dict.fromkeys(_SEVERAL, ())}
    found = {knob: values.get(knob, usual.get(knob, (0.0, 0.0))) for knob in SPACES[kind].knobs}
    choices = {knob: ends if knob in _SEVERAL else (ends,) for knob, ends in found.items()}
    most = values.get("acceleration", Drive.acceleration)
    return Drive(values.get("name", usual_name), kind, choices, most, in_stroke="stroke" in values)


def _moved_drive(table: Table, usual_name: str, problems: Problems) -> Drive:
    """Read a drive that is a given motion, of which scale and frequency may be chosen."""
    keys = [key for way in MOTIONS for key in way if key in table.given]
    for key in _keys((*_LINE, *ELLIPTICAL)):
        if key in table.given:
            table.refuse(
                key, f"not beside {' and '.join(keys)} of a given motion", f"give {key} or the motion"
            )
    values, motion = table.values, None
    if all(key in values for key in keys):
        with problems.taken(f"{table.heading} "):
            motion = motion_of({key: values[key] for key in keys}).motion
    if motion is not None and not MotionSpace.of(motion).unit > 0.0:
        table.refuse(keys[0], "the trough stands still", "give a motion with accelerations")
        motion = None
    choices = {SCALE: (values.get(SCALE, (1.0, 1.0)),), "frequency": values.get("frequency", ())}
    most = values.get("acceleration", Drive.acceleration)
    kind = Harmonics if isinstance(motion, HarmonicMotion) else Piecewise
    return Drive(values.get("name", usual_name), kind, choices, most, motion=motion or _UNREAD)


def _keys(names: Sequence[str]) -> list[str]:
    return [QUANTITIES[name].column for name in names]


def _goal(goal: Table, scene: Table) -> Goal:
    time, length = goal.values.pop("traverse_time", None), scene.values.get("trough_length")
    if "traverse_time_s" in goal.given and "trough_length_mm" not in scene.given:
        hint = f"[scene] for example: {DESIGN_FILE.tables['scene'].example('trough_length_mm')}"
        goal.refuse("traverse_time_s", "needs trough_length_mm in [scene]", hint)
    if time and length:
        goal.values["speed"] = speed = length / time
        if not 0.0 < speed < math.inf:
            goal.refuse("traverse_time_s", "the length of the trough over it is beyond the range of doubles")
    return Goal(**{"speed": math.nan} | goal.values)


def _stand_ratio(part: Table) -> float:
    return float(part.values.get("half_base", 1.0) / part.values.get("centre_height", 1.0))


def _check_names(drives: Sequence[Drive], problems: Problems) -> None:
    for name, count in Counter(drive.name for drive in drives).items():
        if count > 1:
            what = f"[[drive]] name = {shown(name)}: {count} drives have it"
            problems.add(what, "give each drive its own name")


def _check_drift(spec: Spec, drift: Table) -> None:
    """Refuse drifts of quantities that no drive has."""
    knobs = {knob for drive in spec.drives for knob in drive.choices}
    for name in ("normal_phase", "drive_angle"):
        key = QUANTITIES[name].column
        if knobs and name not in knobs and key in drift.given:
            drift.refuse(key, f"no drive has {key}")


def _check_angles(spec: Spec, drives: Sequence[tuple[Drive, Table]], problems: Problems) -> None:
    """Refuse troughs so steep that parts slide by themselves, and drives that reach the trough's normal."""
    low, high = spec.bands["trough_angle"]
    highest = high + spec.drift.trough_angle
    steepest = max(-low, high) + spec.drift.trough_angle
    if "static_friction" in spec.bands:
        friction, _ = spec.bands["static_friction"]
        slides = math.atan(friction)
        if steepest >= slides - _ROUNDED:
            problems.add(
                f"[scene] trough_angle_deg: it is up to {_degrees(steepest)} either way, drift included; must"
                f" be less than {_degrees(slides)}, where parts of static_friction {friction:g} slide down"
            )
    for drive, table in drives:
        angles = drive.choices.get("drive_angle", ())
        reach = max((end for _, end in angles), default=0.0) + spec.drift.drive_angle + highest
        if angles and reach >= 0.5 * math.pi - _ROUNDED:
            why = f"with the trough and the drifts it is up to {_degrees(reach)}; must be less than 90 deg"
            table.refuse("drive_angle_deg", why)


def _check_accelerations(gravity: float, drives: Sequence[tuple[Drive, Table]]) -> None:
    """Refuse drives whose least acceleration exceeds their own limit."""
    for drive, table in drives:
        least, most = (a / gravity for a in drive.accelerations)
        if least > drive.acceleration:
            table.refuse(
                "acceleration_g", f"amplitude and frequency are such that it is at least {least:.6g}"
            )
        if drive.frequency and not most <= _MOST_LOAD:
            why = (
                f"with the amplitude the acceleration is up to {most:.6g} g; must be at most {_MOST_LOAD:g} g"
            )
            table.refuse("frequency_hz", why)


def _degrees(angle: float) -> str:
    return f"{QUANTITIES['drive_angle'].from_si(angle):.6g} deg"
