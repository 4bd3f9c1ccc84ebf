"""The signals that a record may hold, their units, how programs spell these, and what voltages stand for."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence
from typing import Final, NamedTuple

from vibro.errors import InputError, cut, shown
from vibro.quantities import LENGTH
from vibro.records.tolerances import TOL

__all__ = [
    "EXAMPLES", "KINDS", "SIGNALS", "SIGNAL_UNITS", "TROUGH", "Sensitivity", "Unit", "doubt", "option_of",
    "read_sensitivities", "rounded", "signal_unit",
]  # fmt: skip

#: What a unit measures, a key of ``SIGNAL_UNITS``, and its size in SI units.
Unit = tuple[str, float]
#: Signals of the body that a record may hold in addition to its time; each name is also the kind of its unit.
SIGNALS: Final = ("displacement", "velocity", "acceleration", "force")
#: Accelerations of the trough that it may hold: along its surface, and normal to it.
TROUGH: Final = ("trough_along", "trough_normal")
#: What each column is measured in.
KINDS: Final[Mapping[str, str]] = {r: r for r in ("time", *SIGNALS)} | dict.fromkeys(TROUGH, "acceleration")


def _per_time(suffix: str) -> dict[str, float]:
    return {f"{unit}{suffix}": float(size / 1000) for unit, size in LENGTH.sizes.items()}


# What a measured signal may be given in, and its size in SI units; the first one is the one of tables.
SIGNAL_UNITS: Final[Mapping[str, Mapping[str, float]]] = {
    "time": {"s": 1.0, "ms": 1e-3, "us": 1e-6, "\u00b5s": 1e-6, "min": 60.0},
    "displacement": _per_time(""),
    "velocity": _per_time("/s"),
    "acceleration": {"m/s^2": 1.0, "g": 9.80665} | _per_time("/s^2"),
    "force": {"N": 1.0, "mN": 1e-3, "kN": 1e3},
    "voltage": {"V": 1.0, "mV": 1e-3},
}
_BY_NAME: Final = {
    unit.casefold().replace("^", ""): (kind, size)
    for kind, sizes in SIGNAL_UNITS.items()
    for unit, size in sizes.items()
}
# How programs spell the same: MATLAB, SolidWorks and the column names of vibro.
_SPELLINGS: Final = (
    (r"seconds?|sec", "s"),
    (r"newtons?", "n"),
    (r"volts?", "v"),
    (r"\u00b2", "2"),
    (r"[\s\u00b7.*^]", ""),
    (r"(?<=[mn])_(?=s)", "/"),
)


def signal_unit(text: str) -> Unit | None:
    """Find what a unit measures.

    Parameters
    ----------
    text : str
        Such as ``mm``, ``mm/sec**2``, ``m_s2``, ``newton`` or ``mV``.

    Returns
    -------
    Unit or None
        None where the text is no unit of a signal.
    """
    if text == "v":  # a velocity's name, not a volt
        return None
    name = text.casefold()
    for spelling, plain in _SPELLINGS:
        name = re.sub(spelling, plain, name)
    return _BY_NAME.get(name)


def doubt(sensitivity: str) -> str:
    """Ask for what makes a signal far too large or small: its sensitivity, if it has one, else its unit."""
    return f"is its sensitivity {sensitivity} right?" if sensitivity else "is its unit right?"


def rounded(ratio: float) -> str:
    """Write a ratio to two digits, as 1000 and not as 1e+03."""
    return f"{float(f'{ratio:.2g}'):g}"


def _a(kind: str) -> str:
    return f"{'an' if kind[0] in 'aeiou' else 'a'} {kind}"


def option_of(role: str) -> str:
    """Name the option that gives the column of a signal."""
    return "--" + role.replace("_", "-")


#: Of each kind of signal a sensitivity as people write it.
EXAMPLES: Final[Mapping[str, str]] = {
    "displacement": "2V/mm",
    "velocity": "20mV/mm/s",
    "acceleration": "100mV/g",
    "force": "50mV/N",
}


class Sensitivity(NamedTuple):
    """What a voltage stands for.

    Attributes
    ----------
    text : str
        As typed.
    role : str
        The column that it is for, a key of ``KINDS``; empty for every voltage of its kind.
    kind : str
        What the sensor measures: a key of ``SIGNAL_UNITS``.
    per_volt : float
        What one volt stands for, in the SI unit of the kind; negative for a sensor that points the other way.
    """

    text: str
    role: str
    kind: str
    per_volt: float

    @property
    def served(self) -> str:
        """The option of the column that it is for, or the kind of signal in words."""
        return option_of(self.role) if self.role else _a(self.kind)

    def serves(self, role: str) -> bool:
        """Whether it is for the column of a signal, if that is a voltage."""
        return self.role == role if self.role else self.kind == KINDS[role]


# Possessive, so that the time of a refusal grows with the length of a text and not with its square.
_NUMBER: Final = r"[+-]?+(?:(?:\d++\.?+\d*+|\.\d++)(?:[eE][+-]?+\d++)?+|(?i:nan|inf))"
_SENSITIVITY: Final = re.compile(rf"({_NUMBER})\s*+([^\W\d].*|\(.*)")
_DECIMAL_COMMA: Final = re.compile(r"([+-]?\d{1,20}),(\d.{0,20})")
_HINT: Final = f"write it like {', '.join(EXAMPLES.values())} or 125mm/s/V"


def read_sensitivities(texts: Sequence[str]) -> tuple[Sensitivity, ...]:
    """Read the sensitivities of sensors, of which the record holds voltages.

    Parameters
    ----------
    texts : sequence of str
        Such as ``100mV/g``, ``-10.2 mV/(m/s²)`` or ``2mm/V``: its unit says which kind of signal it serves.
        ``trough-along=101.3mV/g`` serves that column alone.

    Raises
    ------
    InputError
        If one is no sensitivity, is 0, not finite, or of no size that could be computed with; or if two of
        them serve the same.
    """
    found: list[Sensitivity] = []
    for text in texts:
        one = _sensitivity(text)
        for other in found:
            if one.served == other.served:
                both = f"--sensitivity {cut(other.text)} and {cut(one.text)}: each is for {one.served}"
                hint = "say which column each is for: --sensitivity trough-along=100mV/g"
                raise InputError(both, hint=hint)
        found.append(one)
    return tuple(found)


def _sensitivity(text: str) -> Sensitivity:
    name, equals, value = text.rpartition("=")
    role = name.strip().removeprefix("--").replace("-", "_").casefold()
    said = f"--sensitivity {cut(text)}"
    if equals and (role not in KINDS or role == "time"):
        known = ", ".join(option_of(r).removeprefix("--") for r in KINDS if r != "time")
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
    if role and KINDS[role] != kind:
        other = f"{said}: {shown(unit_text)} is no sensitivity of {_a(KINDS[role])}"
        raise InputError(other, hint=f"write it like {EXAMPLES[KINDS[role]]}")
    if number == 0.0 or not math.isfinite(number):
        raise InputError(f"{said}: must be finite and not 0", hint=_HINT)
    per_volt = number * size if inverse else size / number
    if not 1.0 / TOL.largest <= abs(per_volt) <= TOL.largest:
        raise InputError(f"{said}: 1 V would be {per_volt:g} in SI units, which is beyond any sensor")
    return Sensitivity(text.strip(), role, kind, per_volt)


def _unit(text: str) -> tuple[str, float, bool] | None:
    """Read ``mV/g``, or the other way round ``mm/V``.

    Returns the kind, the SI units of it in a volt for a number of 1, and whether it is the other way round.
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
