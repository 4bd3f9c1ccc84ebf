"""Questions of inverse design as files and mappings: read, and checked before anything is computed."""

from __future__ import annotations

import math
import os
import re
from collections import Counter
from collections.abc import Mapping
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from vibro.core.codes import Regime
from vibro.errors import InputError, shown
from vibro.files.toml_files import did_you_mean, read_toml
from vibro.inverse.catalogue import Row, static_row
from vibro.inverse.entries import Span, band, choices, limits, number, text
from vibro.inverse.specs import Drift, Drive, Goal, Spec
from vibro.quantities import IN_GRAVITIES, LENGTH, PERCENT, PURE, QUANTITIES, SPEED, TIME, Quantity, Range

if TYPE_CHECKING:
    from collections.abc import Callable, Collection, Sequence

__all__ = ["read_spec"]

_POSITIVE: Final = Range(0.0, with_low=False)
_RELATIVE: Final = Range(0.0, 100.0)
_ANGLE: Final = QUANTITIES["drive_angle"]  # a drift may be what such an angle may be

# Without static friction a body rests on no trough, not even on a level one.
_STATIC_FRICTION: Final = replace(QUANTITIES["static_friction"], allowed=_POSITIVE)
_REGIMES: Final = {r.label: r for r in (Regime.FORWARD_SLIP, Regime.BACK_SLIP, Regime.HOPPING)}
# [rad] More than is lost where four angles near 90 deg are converted and added.
_ROUNDED: Final = 1e-15
# How a text that names a row of the catalogue begins, unlike any number.
_NAME: Final = re.compile(r"\s*(?!(nan|inf|infinity)\b)[^\W\d_]", re.IGNORECASE)


def _static_friction(value: Any) -> Span | Row:
    """Read a band, or find a row of the catalogue."""
    if not _is_name(value):
        return band(_STATIC_FRICTION, value)
    try:
        return static_row(value)
    except InputError as exc:
        raise InputError(f"static_friction = {exc.problems[0]}", hint=exc.hint) from exc


def _is_name(value: Any) -> bool:
    return isinstance(value, str) and _NAME.match(value) is not None


def _highest_regime(value: Any) -> Regime:
    regime = _REGIMES.get(value) if isinstance(value, str) else None
    if regime is None:
        raise InputError(f"highest_regime = {shown(value)}: must be {' or '.join(_REGIMES)}")
    return regime


def _each(read: Callable[[Quantity, Any], Any], *quantities: Quantity) -> dict[str, Callable[[Any], Any]]:
    return {quantity.column: partial(read, quantity) for quantity in quantities}


def _of_scene(*names: str) -> list[Quantity]:
    return [QUANTITIES[name] for name in names]


# Every key of every table, and how it is read.
_KEYS: Final[Mapping[str, Mapping[str, Callable[[Any], Any]]]] = {
    "scene": {
        "static_friction": _static_friction,
        **_each(band, *_of_scene("kinetic_friction", "friction_ratio", "trough_angle")),
        **_each(number, *_of_scene("trough_length", "gravity", "restitution")),
    },
    "drive": {
        "name": partial(text, "name"),
        **_each(limits, *_of_scene("amplitude", "stroke")),
        **_each(choices, *_of_scene("frequency", "drive_angle")),
        **_each(number, Quantity("acceleration", IN_GRAVITIES, allowed=_POSITIVE)),
    },
    "drift": _each(
        number,
        Quantity("amplitude", PERCENT, allowed=_RELATIVE),
        Quantity("frequency", PERCENT, allowed=_RELATIVE),
        _ANGLE,
        replace(_ANGLE, name="trough_angle"),
    ),
    "goal": {
        **_each(
            number,
            Quantity("speed", SPEED, allowed=_POSITIVE),
            Quantity("traverse_time", TIME, allowed=_POSITIVE),
            Quantity("impact_speed", SPEED, allowed=_POSITIVE),
            Quantity("flight_fraction", PURE, allowed=Range(0.0, 1.0, with_low=False, with_high=True)),
        ),
        "highest_regime": _highest_regime,
    },
    "part": _each(
        number,
        Quantity("half_base", LENGTH, allowed=_POSITIVE),
        Quantity("centre_height", LENGTH, allowed=_POSITIVE),
    ),
}
_HEADINGS: Final = {name: "[[drive]]" if name == "drive" else f"[{name}]" for name in _KEYS}
_EXAMPLES: Final = {
    "static_friction": 'static_friction = "0.3:0.5"',
    "kinetic_friction": 'friction_ratio = "0.7:0.9"',
    "amplitude_mm": "amplitude_mm = 0.8",
    "frequency_hz": 'frequency_hz = "15:25"',
    "drive_angle_deg": 'drive_angle_deg = "10:40"',
    "speed_mm_s": "speed_mm_s = 80",
    "trough_length_mm": "trough_length_mm = 1200",
    "half_base_mm": "half_base_mm = 6",
    "centre_height_mm": "centre_height_mm = 8",
}


class _Problems:
    """Everything that is wrong with a question, to be told at once.

    Parameters
    ----------
    where : str
        The file, as messages begin.
    """

    def __init__(self, where: str) -> None:
        self._where = where
        self._texts: list[str] = []
        self._hints: list[str] = []

    def add(self, text: str, hint: str = "") -> None:
        self._texts.append(self._where + text)
        self._hints += [hint] if hint else []

    def add_unknown(self, what: str, key: object, known: Collection[str]) -> None:
        """Refuse a key or table, and say where it belongs or what it may stand for."""
        homes = [_HEADINGS[name] for name, keys in _KEYS.items() if key in keys]
        if homes:
            meant = f"; it belongs in {' or '.join(homes)}"
        else:
            meant = did_you_mean(key if isinstance(key, str) else "", known, len(self._texts))
        self.add(f"{what} {shown(key)}{meant}")

    def settle(self) -> None:
        if self._texts:
            raise InputError(*self._texts, hint="\n".join(dict.fromkeys(self._hints)))


class _Table:
    """One table of a question, of which every key is read, or refused.

    Parameters
    ----------
    name : str
        A key of ``_KEYS``.
    given : object
        What the file says; nothing where it has no such table.
    problems : _Problems
        Where to tell what is wrong.
    place : int, optional
        Which of several drives it is.
    """

    def __init__(self, name: str, given: Any, problems: _Problems, place: int = 0) -> None:
        self.heading = f"{_HEADINGS[name]} {place}" if place else _HEADINGS[name]
        self._problems = problems
        self._values: dict[str, Any] = {}
        self.given: Mapping[Any, Any] = given if isinstance(given, Mapping) else {}
        if not isinstance(given, Mapping):
            problems.add(f"{name} = {shown(given)}: must be a table, written {_HEADINGS[name]}")
        for key, value in self.given.items():
            if key not in _KEYS[name]:
                problems.add_unknown(f"{self.heading} unknown key", key, _KEYS[name])
                continue
            try:
                self._values[key] = _KEYS[name][key](value)
            except InputError as exc:
                problems.add(f"{self.heading} {exc.problems[0]}", exc.hint)

    def get(self, key: str, default: Any = None) -> Any:
        """Return what was read, in SI units; the default where it is missing or wrong."""
        return self._values.get(key, default)

    def refuse(self, key: str, why: str, hint: str = "") -> None:
        """Tell what is wrong with an entry."""
        self._problems.add(f"{self.heading} {key} = {shown(self.given[key])}: {why}", hint)

    def needs(self, *keys: str) -> None:
        """Check that exactly one of some keys is given."""
        found = [key for key in keys if key in self.given]
        if not found:
            self._problems.add(
                f"{self.heading} {' or '.join(keys)} is missing",
                f"{self.heading} for example: {_EXAMPLES[keys[0]]}",
            )
        elif len(found) > 1:
            self._problems.add(
                f"{self.heading} gives both {' and '.join(found)}", f"give {' or '.join(found)}"
            )


def read_spec(source: str | os.PathLike[str] | Mapping[str, Any]) -> Spec:
    """Read a question of inverse design.

    Parameters
    ----------
    source : path or mapping
        TOML with the tables ``[scene]``, ``[[drive]]``, ``[goal]`` and, optionally, ``[drift]`` and
        ``[part]``, or a mapping with the same keys; docs/design.md lists them.

    Returns
    -------
    Spec
        In SI units and radians. A band of kinetic friction is as given: where it exceeds static friction it
        is cut by whoever makes the box.

    Raises
    ------
    FileError
        If the file cannot be read.
    InputError
        If something is wrong; everything is named, each with its table and key.

    Examples
    --------
    >>> spec = read_spec({
    ...     "scene": {"static_friction": "0.3:0.5", "friction_ratio": "0.7:0.9", "trough_length_mm": 1200},
    ...     "drive": [{"amplitude_mm": 0.8, "frequency_hz": "50,100", "drive_angle_deg": "10:40"}],
    ...     "goal": {"traverse_time_s": 15},
    ... })
    >>> spec.drives[0].frequency, spec.goal.speed
    (((50.0, 50.0), (100.0, 100.0)), 0.08)
    """
    if isinstance(source, Mapping):
        return _spec(source, "", _Problems(""))
    if not isinstance(source, str | os.PathLike):
        raise InputError(f"{shown(source)}: must be a path, or a mapping with the tables of a question")
    path = Path(source)
    return _spec(read_toml(path), path.stem, _Problems(f"{path}: "))


def _spec(content: Mapping[Any, Any], name: str, problems: _Problems) -> Spec:
    for key, value in content.items():
        if key not in _KEYS:
            what = "table" if isinstance(value, Mapping | list) else "key"
            problems.add_unknown(f"unknown {what}", key, _KEYS)
    scene, drift, goal, part = (
        _Table(table, content.get(table, {}), problems) for table in ("scene", "drift", "goal", "part")
    )
    drives = _drive_tables(content.get("drive", []), problems)
    spec = Spec(
        bands=_bands(scene),
        drives=tuple(_drive(table, f"drive {i}") for i, table in enumerate(drives, 1)),
        goal=_goal(goal, scene),
        drift=Drift(
            amplitude=drift.get("amplitude_percent", 0.0),
            frequency=drift.get("frequency_percent", 0.0),
            drive_angle=drift.get("drive_angle_deg", 0.0),
            trough_angle=drift.get("trough_angle_deg", 0.0),
        ),
        length=scene.get("trough_length_mm"),
        gravity=scene.get("gravity_m_s2", Spec.gravity),
        restitution=scene.get("restitution", Spec.restitution),
        stand_ratio=_stand_ratio(part) if "part" in content else Spec.stand_ratio,
        name=name,
    )
    _check_names(spec.drives, problems)
    _check_angles(spec, drives, problems)
    _check_accelerations(spec, drives)
    problems.settle()
    return spec


def _bands(scene: _Table) -> dict[str, Span]:
    scene.needs("static_friction")
    static = scene.get("static_friction")
    row = static if isinstance(static, Row) else None
    static = row.static_friction if row else static
    keys = [key for key in ("kinetic_friction", "friction_ratio") if key in scene.given]
    bands = {"static_friction": static} | {key: scene.get(key) for key in keys}
    if keys or not _is_name(scene.given.get("static_friction")):
        scene.needs("kinetic_friction", "friction_ratio")
    elif row:
        bands["kinetic_friction"] = row.kinetic_friction
        if not row.kinetic_friction:
            hint = "give kinetic_friction or friction_ratio too"
            scene.refuse("static_friction", "the catalogue has no kinetic friction of it", hint)
    bands["trough_angle"] = scene.get("trough_angle_deg", (0.0, 0.0))
    known = {key: ends for key, ends in bands.items() if ends}
    kinetic = known.get("kinetic_friction", (0.0, 0.0))
    if static and kinetic[0] > static[1]:
        why = f"all of it is above static friction, which is at most {static[1]:g}"
        scene.refuse("kinetic_friction", why)
    return known


def _drive_tables(given: Any, problems: _Problems) -> list[_Table]:
    """Read the drives; a single one may be a table of its own."""
    tables = list(given) if isinstance(given, list | tuple) else [given]
    if not tables:
        example = ", ".join(_EXAMPLES[key] for key in ("amplitude_mm", "frequency_hz", "drive_angle_deg"))
        problems.add(
            "[[drive]] is missing: there must be one drive or more", f"[[drive]] for example: {example}"
        )
    several = len(tables) > 1
    return [_Table("drive", table, problems, several * i) for i, table in enumerate(tables, 1)]


def _drive(table: _Table, usual_name: str) -> Drive:
    table.needs("amplitude_mm", "stroke_mm")
    table.needs("frequency_hz")
    table.needs("drive_angle_deg")
    low, high = table.get("stroke_mm", (0.0, 0.0))
    return Drive(
        name=table.get("name", usual_name),
        amplitude=table.get("amplitude_mm", (low / 2.0, high / 2.0)),
        frequency=table.get("frequency_hz", ()),
        drive_angle=table.get("drive_angle_deg", ()),
        acceleration=table.get("acceleration_g", Drive.acceleration),
    )


def _goal(goal: _Table, scene: _Table) -> Goal:
    goal.needs("speed_mm_s", "traverse_time_s")
    speed = goal.get("speed_mm_s", math.nan)
    time, length = goal.get("traverse_time_s"), scene.get("trough_length_mm")
    if "traverse_time_s" in goal.given and "trough_length_mm" not in scene.given:
        hint = f"[scene] for example: {_EXAMPLES['trough_length_mm']}"
        goal.refuse("traverse_time_s", "needs trough_length_mm in [scene]", hint)
    if time and length:
        speed = length / time
        if not 0.0 < speed < math.inf:
            goal.refuse("traverse_time_s", "the length of the trough over it is beyond the range of doubles")
    return Goal(
        speed=speed,
        highest_regime=goal.get("highest_regime", Goal.highest_regime),
        impact_speed=goal.get("impact_speed_mm_s", Goal.impact_speed),
        flight_fraction=goal.get("flight_fraction", Goal.flight_fraction),
    )


def _stand_ratio(part: _Table) -> float:
    part.needs("half_base_mm")
    part.needs("centre_height_mm")
    return float(part.get("half_base_mm", 1.0) / part.get("centre_height_mm", 1.0))


def _check_names(drives: Sequence[Drive], problems: _Problems) -> None:
    for name, count in Counter(drive.name for drive in drives).items():
        if count > 1:
            what = f"[[drive]] name = {shown(name)}: {count} drives have it"
            problems.add(what, "give each drive its own name")


def _check_angles(spec: Spec, drives: Sequence[_Table], problems: _Problems) -> None:
    """Refuse troughs that parts slide off by themselves, and drives that reach the trough's normal."""
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
    for drive, table in zip(spec.drives, drives, strict=True):
        reach = max((end for _, end in drive.drive_angle), default=0.0) + spec.drift.drive_angle + highest
        if drive.drive_angle and reach >= 0.5 * math.pi - _ROUNDED:
            why = f"with the trough and the drifts it is up to {_degrees(reach)}; must be less than 90 deg"
            table.refuse("drive_angle_deg", why)


def _check_accelerations(spec: Spec, drives: Sequence[_Table]) -> None:
    """Refuse drives whose gentlest setting exceeds their own limit."""
    for drive, table in zip(spec.drives, drives, strict=True):
        w = 2.0 * math.pi * min((low for low, _ in drive.frequency), default=0.0)
        least = drive.amplitude[0] * w * w / spec.gravity
        if least > drive.acceleration:
            table.refuse(
                "acceleration_g", f"amplitude and frequency are such that it is at least {least:.6g}"
            )


def _degrees(angle: float) -> str:
    return f"{_ANGLE.from_si(angle):.6g} deg"
