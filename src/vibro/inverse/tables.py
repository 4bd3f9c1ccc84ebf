"""The tables of a question, of which every key is read, or refused."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING, Any, Final

from vibro.core.codes import Regime
from vibro.errors import InputError, shown
from vibro.files.toml_files import did_you_mean
from vibro.inverse.catalogue import Row, static_row
from vibro.inverse.entries import Span, band, choices, limits, number, text
from vibro.quantities import IN_GRAVITIES, LENGTH, PERCENT, PURE, QUANTITIES, SPEED, TIME, Quantity, Range

if TYPE_CHECKING:
    from collections.abc import Callable, Collection

__all__ = ["ANGLE", "EXAMPLES", "KEYS", "Problems", "Table", "is_name"]

_POSITIVE: Final = Range(0.0, with_low=False)
_RELATIVE: Final = Range(0.0, 100.0)
ANGLE: Final = QUANTITIES["drive_angle"]  # a drift may be what such an angle may be

# Without static friction a body rests on no trough, not even on a level one.
_STATIC_FRICTION: Final = replace(QUANTITIES["static_friction"], allowed=_POSITIVE)
_REGIMES: Final = {r.label: r for r in (Regime.FORWARD_SLIP, Regime.BACK_SLIP, Regime.HOPPING)}
# How a text that names a row of the catalogue begins, unlike any number.
_NAME: Final = re.compile(r"\s*(?!(nan|inf|infinity)\b)[^\W\d_]", re.IGNORECASE)


def _static_friction(value: Any) -> Span | Row:
    """Read a band, or find a row of the catalogue."""
    if not is_name(value):
        return band(_STATIC_FRICTION, value)
    try:
        return static_row(value)
    except InputError as exc:
        raise InputError(f"static_friction = {exc.problems[0]}", hint=exc.hint) from exc


def is_name(value: Any) -> bool:
    """Whether a text begins as the name of a row does, and no number."""
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
KEYS: Final[Mapping[str, Mapping[str, Callable[[Any], Any]]]] = {
    "scene": {
        "static_friction": _static_friction,
        **_each(band, *_of_scene("kinetic_friction", "friction_ratio", "trough_angle")),
        **_each(number, *_of_scene("trough_length", "gravity", "restitution")),
    },
    "drive": {
        "name": partial(text, "name"),
        **_each(limits, *_of_scene("amplitude", "stroke")),
        **_each(band, *_of_scene("along_amplitude", "normal_amplitude", "normal_phase")),
        **_each(choices, *_of_scene("frequency", "drive_angle")),
        **_each(number, Quantity("acceleration", IN_GRAVITIES, allowed=_POSITIVE)),
    },
    "drift": _each(
        number,
        Quantity("amplitude", PERCENT, allowed=_RELATIVE),
        Quantity("frequency", PERCENT, allowed=_RELATIVE),
        ANGLE,
        replace(ANGLE, name="trough_angle"),
        replace(ANGLE, name="normal_phase", allowed=Range(0.0, 180.0, with_high=True)),
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
_HEADINGS: Final = {name: "[[drive]]" if name == "drive" else f"[{name}]" for name in KEYS}
EXAMPLES: Final = {
    "static_friction": 'static_friction = "0.3:0.5"',
    "kinetic_friction": 'friction_ratio = "0.7:0.9"',
    "amplitude_mm": "amplitude_mm = 0.8",
    "frequency_hz": 'frequency_hz = "15:25"',
    "drive_angle_deg": 'drive_angle_deg = "10:40"',
    "along_amplitude_mm": "along_amplitude_mm = 1",
    "normal_amplitude_mm": "normal_amplitude_mm = 0.3",
    "speed_mm_s": "speed_mm_s = 80",
    "trough_length_mm": "trough_length_mm = 1200",
    "half_base_mm": "half_base_mm = 6",
    "centre_height_mm": "centre_height_mm = 8",
}


class Problems:
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
        """Take note of one thing, and of what may be done about it."""
        self._texts.append(self._where + text)
        self._hints += [hint] if hint else []

    def add_unknown(self, what: str, key: object, known: Collection[str]) -> None:
        """Refuse a key or table, and say where it belongs or what it may stand for."""
        homes = [_HEADINGS[name] for name, keys in KEYS.items() if key in keys]
        if homes:
            meant = f"; it belongs in {' or '.join(homes)}"
        else:
            meant = did_you_mean(key if isinstance(key, str) else "", known, len(self._texts))
        self.add(f"{what} {shown(key)}{meant}")

    def settle(self) -> None:
        """Raise all of it."""
        if self._texts:
            raise InputError(*self._texts, hint="\n".join(dict.fromkeys(self._hints)))


class Table:
    """One table of a question, of which every key is read, or refused.

    Parameters
    ----------
    name : str
        A key of ``KEYS``.
    given : object
        What the file says; nothing where it has no such table.
    problems : Problems
        Where to tell what is wrong.
    place : int, optional
        Which of several drives it is.
    """

    def __init__(self, name: str, given: Any, problems: Problems, place: int = 0) -> None:
        self.heading = f"{_HEADINGS[name]} {place}" if place else _HEADINGS[name]
        self._problems = problems
        self._values: dict[str, Any] = {}
        self.given: Mapping[Any, Any] = given if isinstance(given, Mapping) else {}
        if not isinstance(given, Mapping):
            problems.add(f"{name} = {shown(given)}: must be a table, written {_HEADINGS[name]}")
        for key, value in self.given.items():
            if key not in KEYS[name]:
                problems.add_unknown(f"{self.heading} unknown key", key, KEYS[name])
                continue
            try:
                self._values[key] = KEYS[name][key](value)
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
                f"{self.heading} for example: {EXAMPLES[keys[0]]}",
            )
        elif len(found) > 1:
            self._problems.add(
                f"{self.heading} gives both {' and '.join(found)}", f"give {' or '.join(found)}"
            )
