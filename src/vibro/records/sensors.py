"""Standard errors of sensors and of a stated drive: what data sheets say, or what is usual."""

from __future__ import annotations

import math
from fractions import Fraction
from typing import TYPE_CHECKING, Final, NamedTuple

import numpy as np

from vibro.errors import InputError, argument, cut, did_you_mean, shown
from vibro.quantities import Quantity, Range, checked_number
from vibro.units import ANGLE, FREQUENCY, PURE, TIME, Kind

if TYPE_CHECKING:
    from collections.abc import Mapping

    from vibro.reals import Complexes, Floats

_STANDARD_GRAVITY: Final = 9.80665  # [m/s^2] in a g
_GS: Final = Kind(
    "g", "m/s^2", "_g", {"g": Fraction(1), "mg": Fraction(1, 1000), "m/s^2": 1 / Fraction("9.80665")},
    per_si=1.0 / _STANDARD_GRAVITY, si=_STANDARD_GRAVITY,
)  # fmt: skip
_SHARE: Final = Range(0.0, 0.5)
_TURN: Final = Range(0.0, 30.0)  # [deg] linear effects of a larger one would be wrong
# fmt: off
_KEYS: Final[Mapping[str, Quantity]] = {
    name: Quantity(name, kind, allowed=allowed, called=f"sensor {name}")
    for name, kind, allowed in (
        ("tilt", ANGLE, _TURN), ("gain", PURE, _SHARE), ("cross", PURE, _SHARE), ("offset", _GS, _SHARE),
        ("delay", TIME, Range(0.0, 0.01)), ("lowpass", FREQUENCY, Range(1e-3, 1e9)),
        ("angle", ANGLE, _TURN), ("amplitude", PURE, _SHARE),
    )
}
# fmt: on
_EXAMPLE: Final = argument("sensor", "tilt=0.2deg,gain=1%,cross=1%,lowpass=100Hz")


class SensorErrors(NamedTuple):
    """Standard errors of sensors and of a stated drive; the limits of a data sheet are on the safe side.

    The defaults are those of cheap sensors that somebody puts on by eye: MEMS accelerometers such as the
    ADXL345, BMI160 or LSM6DSO state zero offsets of 20 to 40 mg, and sensitivities to 1 to 3 %.

    Attributes
    ----------
    tilt : float
        Turn of the sensors in the plane of motion, against that which is stated [rad].
    gain : float
        Sensitivity of each sensor, relative [1].
    cross : float
        Cross-axis sensitivity: share of a motion that a sensor at right angles to it shows [1].
    offset : float
        Zero offset of each axis, which turns gravity in a record [m/s^2].
    delay : float
        Time between two channels [s].
    lowpass : float
        Corner of the first-order low-pass filter in each channel, taken as exact; inf without one [Hz].
    angle : float
        Drive angle that is stated, not measured [rad].
    amplitude : float
        Amplitude that is stated, relative [1].
    stated : frozenset of str
        Those that the user gave.
    """

    tilt: float = math.radians(1.0)
    gain: float = 0.03
    cross: float = 0.03
    offset: float = 0.02 * _STANDARD_GRAVITY
    delay: float = 50e-6
    lowpass: float = math.inf
    angle: float = math.radians(1.0)
    amplitude: float = 0.03
    stated: frozenset[str] = frozenset()

    def response(self, frequency: Floats) -> Complexes:
        """Return by what the filter multiplies a wave ``exp(2j pi f t)`` of each frequency [Hz]."""
        return np.asarray(1.0 / (1.0 + 1j * frequency / self.lowpass), np.complex128)


def read_sensor_errors(text: str) -> SensorErrors:
    """Read errors of sensors such as ``tilt=0.2deg,gain=1%``; those that are not named are the usual ones.

    Raises
    ------
    InputError
        If a name is unknown or comes twice, or a value is no number in its range.

    Examples
    --------
    >>> read_sensor_errors("gain=1%,lowpass=100Hz").gain
    0.01
    """
    found: dict[str, float] = {}
    for part in filter(None, (part.strip() for part in text.split(","))):
        name, equals, value = (piece.strip() for piece in part.partition("="))
        given = argument("sensor", cut(part))
        key = _KEYS.get(name.casefold())
        if key is None or not equals:
            wrong = f"{given}: {shown(name)} is no error of a sensor" if equals else f"{given}: no value"
            hint = (key is None and did_you_mean(name, _KEYS)) or f"known are {', '.join(_KEYS)}"
            raise InputError(wrong, hint=f"{hint}; for example {_EXAMPLE}")
        if key.name in found:
            raise InputError(f"{given}: {key.name} is given twice", hint="leave one out")
        found[key.name] = float(key.to_si(checked_number(value, key)))
    return SensorErrors(**found, stated=frozenset(found))
