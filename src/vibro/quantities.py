"""Quantities, their units outside and inside: the only place that converts.

Outside (options, scene files, tables) a quantity has the unit of its column; inside (``Scene``) it is in SI
units and radians.
"""

from __future__ import annotations

import math
import re
import sys
from dataclasses import dataclass
from fractions import Fraction
from typing import TYPE_CHECKING, Any, Final

from vibro.errors import InputError

if TYPE_CHECKING:
    from collections.abc import Mapping

__all__ = [
    "DURATION",
    "MASS",
    "QUANTITIES",
    "SIGNAL_UNITS",
    "START_PHASE",
    "START_VELOCITY",
    "SWEPT",
    "Quantity",
    "exact_number",
    "from_si",
    "signal_unit",
    "to_si",
]

_LENGTHS: Final[Mapping[str, Fraction]] = {  # [mm]
    "mm": Fraction(1),
    "um": Fraction(1, 1000),
    "\u00b5m": Fraction(1, 1000),  # the micro sign; the Greek mu folds to the same
    "cm": Fraction(10),
    "m": Fraction(1000),
    "in": Fraction("25.4"),
}
_FREQUENCIES: Final[Mapping[str, Fraction]] = {  # [Hz]
    "Hz": Fraction(1),
    "kHz": Fraction(1000),
    "rpm": Fraction(1, 60),
}
_DEGREES_PER_RADIAN: Final = Fraction(180) / Fraction(math.pi)
_ANGLES: Final[Mapping[str, Fraction]] = {  # [deg]
    "deg": Fraction(1),
    "\u00b0": Fraction(1),
    "rad": _DEGREES_PER_RADIAN,
}
_ACCELERATIONS: Final[Mapping[str, Fraction]] = {  # [m/s^2]
    "m/s^2": Fraction(1),
    "m/s2": Fraction(1),
    "m/s\u00b2": Fraction(1),
}

_NUMBER = re.compile(r"([+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)\s*([^\W\d_].*|\u00b0)?")
_NOT_FINITE = re.compile(r"[+-]?(nan|inf|infinity)(?![a-z])", re.IGNORECASE)


@dataclass(frozen=True)
class Quantity:
    """A quantity that users give: how it is called and in which units it may come.

    Attributes
    ----------
    name : str
        Name of the field of ``Scene``, where there is one.
    label : str
        Name in words, for messages and pictures.
    unit : str
        Default unit, that of tables; empty for pure numbers.
    column : str
        Name with unit, as tables and scene files spell it.
    option : str
        The command line's option.
    units : mapping of str to Fraction
        Every unit it may carry, and its size in the default unit.
    """

    name: str
    label: str
    unit: str
    column: str
    option: str
    units: Mapping[str, Fraction]

    def text(self, value: float | Fraction) -> str:
        """Write a value with its unit, as messages do."""
        return f"{float(value):.15g} {self.unit}".rstrip()


QUANTITIES: Final[Mapping[str, Quantity]] = {
    q.name: q
    for q in (
        Quantity("amplitude", "amplitude", "mm", "amplitude_mm", "-A", _LENGTHS),
        Quantity("stroke", "stroke", "mm", "stroke_mm", "--stroke", _LENGTHS),
        Quantity("frequency", "frequency", "Hz", "frequency_hz", "-f", _FREQUENCIES),
        Quantity("drive_angle", "drive angle", "deg", "drive_angle_deg", "-a", _ANGLES),
        Quantity("static_friction", "static friction", "", "static_friction", "--mu-s", {}),
        Quantity("kinetic_friction", "kinetic friction", "", "kinetic_friction", "--mu-d", {}),
        Quantity("friction_ratio", "friction ratio", "", "friction_ratio", "--mu-ratio", {}),
        Quantity("trough_angle", "trough angle", "deg", "trough_angle_deg", "--trough-angle", _ANGLES),
        Quantity("trough_length", "trough length", "mm", "trough_length_mm", "-L", _LENGTHS),
        Quantity("gravity", "gravity", "m/s^2", "gravity_m_s2", "--gravity", _ACCELERATIONS),
        Quantity("restitution", "restitution", "", "restitution", "--restitution", {}),
    )
}

# Quantities of a run or of a record, not of a scene.
MASS: Final = Quantity(
    "mass",
    "mass",
    "kg",
    "mass_kg",
    "--mass",
    {"kg": Fraction(1), "g": Fraction(1, 1000), "lb": Fraction("0.45359237")},
)
DURATION: Final = Quantity(
    "duration",
    "duration",
    "s",
    "duration_s",
    "--duration",
    {"s": Fraction(1), "ms": Fraction(1, 1000), "min": Fraction(60), "h": Fraction(3600)},
)
START_PHASE: Final = Quantity(
    "start_phase", "start phase", "deg", "start_phase_deg", "--start-phase", _ANGLES
)
START_VELOCITY: Final = Quantity(
    "start_velocity",
    "start velocity",
    "mm/s",
    "start_velocity_mm_s",
    "--start-velocity",
    {f"{unit}/s": size for unit, size in _LENGTHS.items()},
)

# The quantities that can be axes of a sweep, in the order of a table's columns.
SWEPT: Final = (
    "amplitude",
    "frequency",
    "drive_angle",
    "static_friction",
    "kinetic_friction",
    "friction_ratio",
    "trough_angle",
)

_MILLIMETRE: Final = 1000.0  # [1/m]


def to_si(name: str, values: Any) -> Any:
    """Convert values of a quantity from its default unit to SI units and radians.

    Parameters
    ----------
    name : str
        A key of ``QUANTITIES``.
    values : float or array
        In the quantity's default unit.

    Returns
    -------
    float or array
        In [m], [Hz], [rad], [m/s^2] or [1].
    """
    units = QUANTITIES[name].units
    if units is _LENGTHS:
        return values / _MILLIMETRE
    if units is _ANGLES:
        return values * (math.pi / 180)
    return values


def from_si(name: str, values: Any) -> Any:
    """Convert values of a quantity from SI units and radians to its default unit.

    Parameters
    ----------
    name : str
        A key of ``QUANTITIES``.
    values : float or array
        In [m], [Hz], [rad], [m/s^2] or [1].

    Returns
    -------
    float or array
        In the quantity's default unit.
    """
    units = QUANTITIES[name].units
    if units is _LENGTHS:
        return values * _MILLIMETRE
    if units is _ANGLES:
        return values * (180 / math.pi)
    return values


def _per_time(suffix: str) -> dict[str, float]:
    return {f"{unit}{suffix}": float(size / 1000) for unit, size in _LENGTHS.items()}


# What a measured signal may be given in, and its size in SI units; the first one is the one of tables.
SIGNAL_UNITS: Final[Mapping[str, Mapping[str, float]]] = {
    "time": {"s": 1.0, "ms": 1e-3, "us": 1e-6, "\u00b5s": 1e-6, "min": 60.0},
    "displacement": _per_time(""),
    "velocity": _per_time("/s"),
    "acceleration": {"m/s^2": 1.0, "g": 9.80665} | _per_time("/s^2"),
    "force": {"N": 1.0, "mN": 1e-3, "kN": 1e3},
}
# How programs spell the same: MATLAB, SolidWorks and the column names of vibro.
_SPELLINGS: Final = (
    (r"seconds?|sec", "s"),
    (r"newtons?", "n"),
    (r"\u00b2", "2"),
    (r"[\s\u00b7.*^]", ""),
    (r"(?<=[mn])_(?=s)", "/"),
)


def signal_unit(text: str) -> tuple[str, float] | None:
    """Find what a unit measures.

    Parameters
    ----------
    text : str
        Such as ``mm``, ``mm/sec**2``, ``m_s2`` or ``newton``.

    Returns
    -------
    tuple of str and float, or None
        A key of ``SIGNAL_UNITS`` and the unit's size in SI units; None where the text is no unit of a signal.
    """
    name = text.casefold()
    for spelling, plain in _SPELLINGS:
        name = re.sub(spelling, plain, name)
    for kind, sizes in SIGNAL_UNITS.items():
        for unit, size in sizes.items():
            if name == unit.casefold().replace("^", ""):
                return kind, size
    return None


def exact_number(text: str, quantity: Quantity) -> Fraction:
    """Read a number that may carry a unit, exactly, in the quantity's default unit.

    Parameters
    ----------
    text : str
        Such as ``15``, ``1.2mm``, ``800um``, ``900rpm`` or ``20°``.
    quantity : Quantity
        What the number is for; it decides which units fit.

    Returns
    -------
    Fraction
        In the default unit of the quantity.

    Raises
    ------
    InputError
        If the text is no finite number, or its unit does not fit the quantity.

    Examples
    --------
    >>> float(exact_number("800um", QUANTITIES["amplitude"]))
    0.8
    """
    text = text.strip()
    if _NOT_FINITE.match(text):
        raise InputError(f"{quantity.label} = {text}: must be a finite number")
    match = _NUMBER.fullmatch(text)
    if match is None:
        raise InputError(f"{quantity.label} = {text!r}: not a number", hint=_number_hint(text, quantity))
    digits, unit = match[1], (match[2] or "").strip()
    # Doubles bound the exponent, so that the exact value below stays small enough to compute with.
    rounded = float(digits)
    if not math.isfinite(rounded):
        raise InputError(f"{quantity.label} = {text}: must be a finite number")
    exact = Fraction(digits) if rounded else Fraction(0)
    if unit:
        exact *= _unit_size(unit, text, quantity)
    if abs(exact) > sys.float_info.max:
        raise InputError(f"{quantity.label} = {text}: must be a finite number")
    return exact


def _unit_size(unit: str, text: str, quantity: Quantity) -> Fraction:
    # Users type hz and MM, and keyboards have two micro signs; no two units of a quantity fold to the same.
    sizes = {name.casefold(): size for name, size in quantity.units.items()}
    if unit.casefold() in sizes:
        return sizes[unit.casefold()]
    problem = f"{quantity.label} = {text!r}: {unit!r} is no unit of {quantity.label}"
    if not sizes:
        raise InputError(problem, hint="it is a pure number")
    raise InputError(problem, hint=f"its units are {', '.join(quantity.units)}")


def _number_hint(text: str, quantity: Quantity) -> str:
    comma = re.fullmatch(r"([+-]?\d+),(\d+)\s*(\D*)", text)
    if comma:
        return f"write a decimal point: {comma[1]}.{comma[2]}{comma[3]}"
    unit = next(iter(quantity.units), "")
    return f"write it like 1.5{unit}" if unit else "write it like 0.5"
