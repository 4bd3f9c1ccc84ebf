"""The kinds of quantities, by their units inside and outside: the only place that converts."""

from __future__ import annotations

import math
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from typing import TYPE_CHECKING, Any, Final

if TYPE_CHECKING:
    from collections.abc import Mapping


@dataclass(frozen=True)
class Kind:
    """A kind of quantity, by its units.

    Attributes
    ----------
    unit, si_unit : str
        Outside and inside; empty for pure numbers.
    suffix : str
        What a column's name ends with.
    sizes : mapping of str to Fraction
        Every unit that a number may carry, in the unit outside.
    per_si, si : float
        Size of the SI unit in the unit outside, and the other way round: 1 where the other is the round one.
    of_sine : bool
        Whether it is the amplitude of a sine, whose numbers may be rms values: ``0.7mm rms``.
    """

    unit: str
    si_unit: str
    suffix: str
    sizes: Mapping[str, Fraction]
    per_si: float = 1.0
    si: float = 1.0
    of_sine: bool = False

    @property
    def units(self) -> dict[str, Fraction]:
        """Every unit that a number may carry, with those of rms and of peak values of a sine."""
        ways = {"rms": _RMS, "peak": Fraction(1)} if self.of_sine else {}
        named = {f"{u} {way}": by * size for way, by in ways.items() for u, size in self.sizes.items()}
        return {**self.sizes, **named}

    @cached_property
    def ratios(self) -> dict[str, tuple[int, int]]:
        """Sizes as whole numbers, by the unit folded: users type hz and MM, and there are two micro signs."""
        return {unit.casefold(): size.as_integer_ratio() for unit, size in self.units.items()}

    def to_si(self, values: Any) -> Any:
        """Convert from the unit outside to SI units and radians."""
        return values * self.si if self.si != 1.0 else values / self.per_si if self.per_si != 1.0 else values

    def from_si(self, values: Any) -> Any:
        """Convert from SI units and radians to the unit outside; inf beyond the range of doubles."""
        if self.per_si == 1.0:
            return values
        import numpy as np  # here, so that ``vibro --help`` loads no numpy

        with np.errstate(over="ignore"):
            return values * self.per_si


_RMS: Final = Fraction(math.isqrt(2 * 10**80), 10**40)  # amplitude of a sine over its rms value
STANDARD_GRAVITY: Final = 9.80665  # [m/s^2] in a g
_IN_G: Final = 1 / Fraction(str(STANDARD_GRAVITY))  # [g s^2/m]
_MILLIMETRES: Final[Mapping[str, Fraction]] = {
    "mm": Fraction(1),
    "um": Fraction(1, 1000),
    "\u00b5m": Fraction(1, 1000),  # the micro sign; the Greek mu folds to the same
    "cm": Fraction(10),
    "m": Fraction(1000),
    "in": Fraction("25.4"),
    "ft": Fraction("304.8"),
}
# fmt: off
PURE: Final = Kind("", "", "", {"%": Fraction(1, 100)})
PERCENT: Final = Kind("%", "", "_percent", {"%": Fraction(1)}, per_si=100.0)
# of a drive that is given in g, wherever it stands: the standard one, whatever the gravity of the scene
IN_G: Final = Kind("g", "m/s^2", "_g",
                   {"g": Fraction(1), **dict.fromkeys(("m/s^2", "m/s2", "m/s\u00b2"), _IN_G)},
                   per_si=float(_IN_G), si=STANDARD_GRAVITY, of_sine=True)
IN_GRAVITIES: Final = Kind("g", "", "_g", {"g": Fraction(1)})  # an acceleration over that of gravity
LENGTH: Final = Kind("mm", "m", "_mm", _MILLIMETRES, per_si=1000.0)
SPEED: Final = Kind("mm/s", "m/s", "_mm_s",
                    {f"{unit}/s": size for unit, size in _MILLIMETRES.items()}
                    | {f"{unit}/min": _MILLIMETRES[unit] / 60 for unit in ("mm", "m", "in", "ft")},
                    per_si=1000.0)
FREQUENCY: Final = Kind("Hz", "Hz", "_hz",
                        {"Hz": Fraction(1), "kHz": Fraction(1000), "rpm": Fraction(1, 60),
                         "U/min": Fraction(1, 60), "/min": Fraction(1, 60), "1/min": Fraction(1, 60)})
ANGLE: Final = Kind("deg", "rad", "_deg",
                    {"deg": Fraction(1), "\u00b0": Fraction(1), "rad": Fraction(180) / Fraction(math.pi)},
                    per_si=180 / math.pi, si=math.pi / 180)
ACCELERATION: Final = Kind("m/s^2", "m/s^2", "_m_s2",
                           dict.fromkeys(("m/s^2", "m/s2", "m/s\u00b2"), Fraction(1)))
MASS: Final = Kind("kg", "kg", "_kg",
                   {"kg": Fraction(1), "g": Fraction(1, 1000), "mg": Fraction(1, 1_000_000),
                    "lb": Fraction("0.45359237")})
FORCE: Final = Kind("N", "N", "_n", {"N": Fraction(1), "kN": Fraction(1000)})
ENERGY: Final = Kind("J", "J", "_j", {})
POWER: Final = Kind("W", "W", "_w", {})
STIFFNESS: Final = Kind("N/m", "N/m", "_n_m",
                        {"N/m": Fraction(1), "kN/m": Fraction(1000), "N/mm": Fraction(1000)})
ROTATION: Final = Kind("rpm", "Hz", "_rpm",
                       {unit: size * 60 for unit, size in FREQUENCY.sizes.items()}, per_si=60.0)
_MOMENTS: Final[Mapping[str, Fraction]] = {
    "kg mm": Fraction(1), "kg cm": Fraction(10), "kg m": Fraction(1000), "g mm": Fraction(1, 1000),
}
MOMENT: Final = Kind("kg mm", "kg m", "_kg_mm", _MOMENTS, per_si=1000.0)  # mass times radius
WORKING_MOMENT: Final = Kind("kg cm", "kg m", "_kg_cm",
                             {unit: size / 10 for unit, size in _MOMENTS.items()}, per_si=100.0)
TIME: Final = Kind("s", "s", "_s",
                    {"s": Fraction(1), "ms": Fraction(1, 1000), "min": Fraction(60), "h": Fraction(3600)})
PER_MINUTE: Final = Kind("1/min", "1/s", "_per_min", {}, per_si=60.0)
MASS_FLOW: Final = Kind("kg/h", "kg/s", "_kg_h", {}, per_si=3600.0)
# fmt: on


#: Units whose spelling by the CF conventions of netCDF (UDUNITS, where g is a gram) follows no rule.
_CF_UNITS: Final = {
    PURE.unit: "1",
    PERCENT.unit: "percent",
    IN_GRAVITIES.unit: "1",  # over the gravity of the scene, which need not be that of the Earth
    ANGLE.unit: "degree",
    ROTATION.unit: "min-1",
    PER_MINUTE.unit: "min-1",
}


def cf_unit(unit: str) -> str:
    """Spell a unit outside as the CF conventions of netCDF do: ``mm/s`` is ``mm s-1``."""
    over, _, under = unit.partition("/")
    divisor, _, power = under.partition("^")
    return _CF_UNITS.get(unit) or (f"{over} {divisor}-{power or 1}" if under else unit)
