"""Signals of a record: their names, their units as programs spell them, the sensitivities of voltages."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence
from typing import Final, NamedTuple

from vibro.errors import InputError, argument, cut, shown
from vibro.quantities import LENGTH, SPEED
from vibro.records.tolerances import TOL

#: Kind of a unit, a key of ``SIGNAL_UNITS``, and its size in SI units.
Unit = tuple[str, float]
#: Signals of the body that a record may hold; each name but friction's is also the kind of its unit.
SIGNALS: Final = ("displacement", "velocity", "acceleration", "friction")
#: Motions of the trough that it may hold: along the trough's surface, and normal to it.
TROUGH: Final = ("trough_along", "trough_normal")
#: Kinds of unit that a motion of the trough may have, with the derivatives from each to the acceleration.
DERIVATIVES: Final[Mapping[str, int]] = {"acceleration": 0, "velocity": 1, "displacement": 2}
#: Kind of unit of each column; of the trough's the usual one.
KINDS: Final[Mapping[str, str]] = {r: r for r in ("time", *SIGNALS)} | {
    "friction": "force",
    **dict.fromkeys(TROUGH, "acceleration"),
}


def _per_time(suffix: str) -> dict[str, float]:
    return {f"{unit}{suffix}": float(size / 1000) for unit, size in LENGTH.sizes.items()}


# Units of each kind, and their sizes in SI units; hints use the first one.
SIGNAL_UNITS: Final[Mapping[str, Mapping[str, float]]] = {
    "time": {"s": 1.0, "ms": 1e-3, "us": 1e-6, "\u00b5s": 1e-6, "min": 60.0},
    "displacement": _per_time(""),
    "velocity": {unit: float(size / 1000) for unit, size in SPEED.sizes.items()},
    "acceleration": {"m/s^2": 1.0, "g": 9.80665} | _per_time("/s^2"),
    "force": {"N": 1.0, "mN": 1e-3, "kN": 1e3},
    "voltage": {"V": 1.0, "mV": 1e-3},
}
_BY_NAME: Final = {
    unit.casefold().replace("^", ""): (kind, size)
    for kind, sizes in SIGNAL_UNITS.items()
    for unit, size in sizes.items()
}
# Spellings of MATLAB, SolidWorks and the column names of vibro.
_SPELLINGS: Final = (
    (r"seconds?|sec", "s"),
    (r"newtons?", "n"),
    (r"volts?", "v"),
    (r"\u00b2", "2"),
    (r"[\s\u00b7.*^]", ""),
    (r"(?<=[mn])_(?=s)", "/"),
)


def signal_unit(text: str) -> Unit | None:
    """Return the kind and the size of a unit.

    Parameters
    ----------
    text : str
        A unit such as ``mm``, ``mm/sec**2``, ``m_s2``, ``newton`` or ``mV``.

    Returns
    -------
    Unit or None
        None if the text is no unit of a signal.
    """
    if text == "v":  # a velocity's name, not a volt
        return None
    name = text.casefold()
    for spelling, plain in _SPELLINGS:
        name = re.sub(spelling, plain, name)
    return _BY_NAME.get(name)


def doubt(sensitivity: str) -> str:
    """Question the sensitivity of a signal of the wrong size, or its unit if it has no sensitivity."""
    return f"is its sensitivity {sensitivity} right?" if sensitivity else "is its unit right?"


def rounded(ratio: float) -> str:
    """Write a ratio to two digits, such as 1000, not 1e+03."""
    return f"{float(f'{ratio:.2g}'):g}"


def kinds_of(role: str) -> tuple[str, ...]:
    """Return the kinds of unit that a column may have, the usual one first."""
    return tuple(DERIVATIVES) if role in TROUGH else (KINDS[role],)


def _a(kind: str) -> str:
    return f"{'an' if kind[0] in 'aeiou' else 'a'} {kind}"


#: A usual sensitivity for each kind of signal.
EXAMPLES: Final[Mapping[str, str]] = {
    "displacement": "2V/mm",
    "velocity": "20mV/mm/s",
    "acceleration": "100mV/g",
    "force": "50mV/N",
}


class Sensitivity(NamedTuple):
    """Sensitivity of a sensor whose voltage is in a record.

    Attributes
    ----------
    text : str
        The sensitivity as typed.
    role : str
        Column that it is for, a key of ``KINDS``; empty for every voltage of its kind.
    kind : str
        Kind of unit that the sensor measures, a key of ``SIGNAL_UNITS``.
    per_volt : float
        Value of one volt, in the SI unit of the kind; negative for a sensor that points the other way.
    """

    text: str
    role: str
    kind: str
    per_volt: float

    @property
    def served(self) -> str:
        """The argument that names its column, or the kind of signal in words."""
        return self.role or _a(self.kind)

    def serves(self, role: str) -> bool:
        """Whether it applies to a voltage in the column of a signal."""
        return self.role == role if self.role else self.kind == KINDS[role]


# Possessive quantifiers: the time for a text is proportional to its length, not to the square of it.
_NUMBER: Final = r"[+-]?+(?:(?:[0-9]++\.?+[0-9]*+|\.[0-9]++)(?:[eE][+-]?+[0-9]++)?+|(?i:nan|inf))"
_SENSITIVITY: Final = re.compile(rf"({_NUMBER})\s*+([^\W\d].*|\(.*)")
_DECIMAL_COMMA: Final = re.compile(r"([+-]?[0-9]{1,20}),([0-9].{0,20})")
_HINT: Final = f"write it like {', '.join(EXAMPLES.values())} or 125mm/s/V"


def read_sensitivities(texts: Sequence[str]) -> tuple[Sensitivity, ...]:
    """Read the sensitivities of sensors whose voltages a record holds.

    Parameters
    ----------
    texts : sequence of str
        Sensitivities such as ``100mV/g``, ``-10.2 mV/(m/s²)`` or ``2mm/V``: the unit gives the kind of signal
        that each applies to. ``trough-along=101.3mV/g`` applies to that column alone.

    Raises
    ------
    InputError
        If one is no sensitivity, is 0, not finite or beyond 1e-20 to 1e20 in SI units; or if two apply to the
        same column or kind.
    """
    found: list[Sensitivity] = []
    for text in texts:
        one = _sensitivity(text)
        for other in found:
            if one.served == other.served:
                both = f"{_given(other.text)} and {_given(one.text)}: each is for {one.served}"
                hint = f"say which column each is for: {_given('trough-along=100mV/g')}"
                raise InputError(both, hint=hint)
        found.append(one)
    return tuple(found)


def _given(text: str) -> str:
    """Write a sensitivity as it is given."""
    return argument("sensitivity", cut(text))


def _sensitivity(text: str) -> Sensitivity:
    name, equals, value = text.rpartition("=")
    role = name.strip().removeprefix("--").replace("-", "_").casefold()
    said = _given(text)
    if equals and (role not in KINDS or role == "time"):
        known = ", ".join(r.replace("_", "-") for r in KINDS if r != "time")
        raise InputError(f"{said}: {shown(name.strip())} is no signal", hint=f"signals are {known}")
    value = value.strip()
    match = _SENSITIVITY.fullmatch(value)
    if match is None:
        comma = _DECIMAL_COMMA.fullmatch(value)
        hint = f"write a decimal point: {comma[1]}.{comma[2]}" if comma and comma[2].isprintable() else _HINT
        raise InputError(f"{said}: not a number with a unit", hint=hint)
    number, unit_text = float(match[1]), match[2].strip()
    unit = _unit(unit_text)
    if unit is None:
        raise InputError(f"{said}: {shown(unit_text)} is no unit of a sensitivity", hint=_HINT)
    kind, size, inverse = unit
    if role and kind not in kinds_of(role):
        other = f"{said}: {shown(unit_text)} is no sensitivity of {_a(' or '.join(kinds_of(role)))}"
        raise InputError(other, hint=f"write it like {EXAMPLES[KINDS[role]]}")
    if number == 0.0 or not math.isfinite(number):
        raise InputError(f"{said}: must be finite and not 0", hint=_HINT)
    per_volt = number * size if inverse else size / number
    if not 1.0 / TOL.largest <= abs(per_volt) <= TOL.largest:
        raise InputError(f"{said}: 1 V would be {per_volt:g} in SI units, which is beyond any sensor")
    return Sensitivity(text.strip(), role, kind, per_volt)


def _unit(text: str) -> tuple[str, float, bool] | None:
    """Read the unit of a sensitivity: ``mV/g``, or inverse ``mm/V``.

    Returns the kind of signal, the size of its unit over that of the voltage, both in SI units, and whether
    it is inverse.
    """
    plain = re.sub(r"\s+(?:per|pro)\s+", "/", text)
    volt, _, measured = plain.partition("/")
    inverse = (signal_unit(volt.strip()) or "")[:1] != ("voltage",)
    if inverse:
        measured, _, volt = plain.rpartition("/")
    of_volt, of_signal = signal_unit(volt.strip()), signal_unit(measured.strip().strip("()[]").strip())
    if of_volt is None or of_volt[0] != "voltage" or of_signal is None or of_signal[0] not in EXAMPLES:
        return None
    return of_signal[0], of_signal[1] / of_volt[1], inverse
