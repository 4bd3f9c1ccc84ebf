"""Standard errors of sensors and of a stated drive: what data sheets say, or what is usual."""

from __future__ import annotations

import math
from fractions import Fraction
from typing import TYPE_CHECKING, Final, NamedTuple

import numpy as np

from vibro.errors import InputError, argument, cut, did_you_mean, shown
from vibro.quantities import Quantity, Range, checked_number
from vibro.units import ANGLE, FREQUENCY, PURE, STANDARD_GRAVITY, TIME, Kind

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from vibro.reals import Complexes, Floats

_GS: Final = Kind(
    "g", "m/s^2", "_g", {"g": Fraction(1), "mg": Fraction(1, 1000), "m/s^2": 1 / Fraction("9.80665")},
    per_si=1.0 / STANDARD_GRAVITY, si=STANDARD_GRAVITY,
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
#: Angle of the sensors' axis along the trough above its surface.
TURNED: Final = Quantity("turned", ANGLE, allowed=Range(-60.0, 60.0, with_high=True))
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
    offset: float = 0.02 * STANDARD_GRAVITY
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


# ------------------------------------------------------------------------------
# The axes of the trough in the axes of its sensors, and what errors of sensors make of a motion.

#: Sensors without errors.
EXACT: Final = SensorErrors(0.0, 0.0, 0.0, 0.0, 0.0, angle=0.0, amplitude=0.0)
_MOST_OFF: Final = math.radians(60.0)  # by which an axis may be off the one that it is named for
_SIGMAS: Final = 3.0  # standard errors beyond which a turn that is stated is questioned, by gravity
_LEVEL: Final = math.radians(0.5)  # at least, as no trough is more level;
_IS_G: Final = 5.0  # standard errors by which the mean of a record may differ from gravity,
_NEAR_G: Final = 0.01  # at least, of gravity;
_MAYBE_G: Final = 0.5  # of gravity, by which it may differ to be questioned
_ACROSS: Final = 0.2  # of the motion along the trough: more across it is questioned


class Mounting(NamedTuple):
    """How sensors are mounted on a trough.

    Attributes
    ----------
    errors : SensorErrors
        Standard errors.
    turned : float or None
        Angle of the axis along the trough above its surface, where it is stated [rad].
    trough_angle : float
        Inclination of the trough, by which its normal is off the vertical [rad].
    """

    errors: SensorErrors = EXACT
    turned: float | None = None
    trough_angle: float = 0.0


class Placement(NamedTuple):
    """Axes of a trough, and what errors of its sensors make of its motion.

    Attributes
    ----------
    axes : array, shape (2, C) or (1, 1)
        By which readings are multiplied: directions along the trough and normal to it, in the axes of C
        sensors; of one sensor the factor that gives its direction [1].
    effects : mapping of str to array
        By kind of error, what one standard error of each such error adds to the motion, (errors, H, 2 or 1).
    turn, turn_error : float
        Angle of the axis nearest to forwards above the trough's surface; its standard error [rad].
    mounting : Mounting
        What was stated.
    nearest : int
        Which axis that is.
    by_gravity : bool
        Whether gravity in the record gave it.
    warnings : tuple of str
        Reasons to doubt it.
    """

    axes: Floats
    effects: Mapping[str, Complexes]
    turn: float
    turn_error: float
    mounting: Mounting = Mounting()
    nearest: int = 0
    by_gravity: bool = False
    warnings: tuple[str, ...] = ()


def place(
    waves: Complexes,
    level: Floats,
    rates: Floats,
    mounting: Mounting,
    headers: Sequence[str],
    leads: int = 0,
) -> Placement:
    """Find the axes of a trough from gravity in a record of it, or as its sensors are said to be mounted.

    Parameters
    ----------
    waves : complex array, shape (H, C)
        Harmonics of the accelerations in the axes of two sensors, along the trough and normal to it, or of
        three, the last one across [m/s^2].
    level : array, shape (C,)
        Constant part of the readings, gravity and offsets; NaN of what is no acceleration [m/s^2].
    rates : array, shape (H,)
        Angular frequencies of the harmonics [rad/s].
    mounting : Mounting
        How the sensors are mounted.
    headers : sequence of str
        Headers of their columns, for messages.
    leads : int
        0 if the axes were named; else forwards is where the motion leads upwards, 1, or downwards, -1.

    Raises
    ------
    InputError
        If an axis is more than 60 deg off the one that it is named for, or the record must show gravity.

    Notes
    -----
    An accelerometer at rest shows g upwards; where the normal one shows it downwards, it is inverted. A
    reading is ``(1 + gain) a_i + sum(cross_ij a_j) + offset``, of gravity as of the motion: errors that turn
    the one turn the other. A trough does not move across itself: of three sensors, the horizontal direction
    in which they move most leads along it.
    """
    errors, count = mounting.errors, len(level)
    ratio = float(np.linalg.norm(level)) / STANDARD_GRAVITY
    tolerance = max(_IS_G * math.hypot(errors.gain, errors.offset / STANDARD_GRAVITY), _NEAR_G)
    shows_gravity = abs(ratio - 1.0) <= tolerance
    by_gravity = shows_gravity and mounting.turned is None and "tilt" not in errors.stated
    if leads and not by_gravity:
        unknown = f"columns {_list(headers)}: which of them is normal to the trough is not known"
        mean = f"their mean is {ratio:.3g} g, no gravity within the errors of the sensor"
        hint = f"name {argument('trough_along')} and {argument('trough_normal')}, or record with gravity"
        raise InputError(f"{unknown}: {mean}", hint=hint)

    def placed(change: Floats, *, by_gravity: bool = by_gravity) -> tuple[Complexes, Floats]:
        """Return the motion in the axes of the sensors, and those of the trough, for errors of these."""
        *turns, offsets, delays, tilt = np.split(change, np.cumsum([count] * (count + 2)))
        matrix = np.linalg.inv(np.eye(count) + np.array(turns))
        true = waves * np.exp(-1j * np.outer(rates, delays)) @ matrix.T
        up = matrix @ (level - offsets) if by_gravity else np.eye(count)[1]
        slope = mounting.trough_angle if by_gravity else -(mounting.turned or 0.0) - float(tilt[0])
        return true, _axes(up / np.linalg.norm(up), true, slope, leads)

    unit = np.eye(count)
    sizes = [
        *np.where(unit, errors.gain, errors.cross).ravel(), *[errors.offset * by_gravity] * count,
        *[0.0, *[errors.delay] * (count - 1)], errors.tilt * (not by_gravity),
    ]  # fmt: skip
    kinds = [*np.where(unit, "gain", "cross").ravel(), *["offset"] * count, *["delay"] * count, "tilt"]
    changes = np.diag(sizes)
    true, axes = placed(0.0 * changes[0])
    nearest = int(np.argmax(abs(axes[0]))) if leads else 0
    if not leads:
        _check_names(axes, headers)

    def turn(found: Floats) -> float:
        return math.asin(float(np.clip(math.copysign(1.0, found[0, nearest]) * found[1, nearest], -1.0, 1.0)))

    effects: dict[str, list[Complexes]] = {}
    turns = []
    for kind, change in zip(kinds, changes, strict=True):
        if change.any():
            (more, there), (less, back) = placed(change), placed(-change)
            effects.setdefault(str(kind), []).append(0.5 * (more @ there.T - less @ back.T))
            turns.append(0.5 * (turn(there) - turn(back)))
    error = float(np.linalg.norm(turns)) if by_gravity else errors.tilt
    warnings = []
    if shows_gravity and not by_gravity:
        seen = turn(placed(0.0 * changes[0], by_gravity=True)[1])
        most = math.hypot(errors.tilt, errors.offset / STANDARD_GRAVITY, errors.cross)
        if abs(seen - turn(axes)) > max(_SIGMAS * most, _LEVEL):
            at, said = (f"{math.degrees(x):.1f} deg" for x in (seen, turn(axes)))
            warnings.append(f"by gravity in the record the sensor is turned by {at}, not by {said}")
    elif not shows_gravity and abs(ratio - 1.0) <= _MAYBE_G:
        mean = f"the mean of columns {_list(headers)} is {ratio:.3g} g, neither 0 nor gravity"
        warnings.append(f"{mean}: how the sensor is turned is not taken from it")
    if count > 2:
        across = true @ np.cross(*axes)
        share = float(np.linalg.norm(across) / np.linalg.norm(true @ axes[0]))
        if share > _ACROSS:
            warnings.append(
                f"the trough moves across itself too, by {100.0 * share:.0f} % of what it moves along"
            )
    kept = {kind: np.array(parts) for kind, parts in effects.items()}
    return Placement(axes, kept, turn(axes), error, mounting, nearest, by_gravity, tuple(warnings))


def _axes(up: Floats, waves: Complexes, slope: float, leads: int) -> Floats:
    """Return the directions along a trough and normal to it, (2, C), which is inclined by a slope.

    ``up`` is normal to a trough without a slope.
    """
    if up.size == 2:
        level = math.copysign(1.0, up[1]) * np.array([up[1], -up[0]])
    else:
        flat = waves - np.outer(waves @ up, up)
        level = np.linalg.eigh((flat.conj().T @ flat).real)[1][:, -1]
        level = level * math.copysign(1.0, level[0])
    cosine, sine = math.cos(slope), math.sin(slope)
    both = [np.array([cosine * x + sine * up, cosine * up - sine * x]) for x in (level, -level)]
    if not leads:
        return both[0]
    rises = [(x * y.conjugate()).real for x, y in (waves[0] @ axes.T for axes in both)]
    return both[int(np.argmax(leads * np.array(rises)))]


def _check_names(axes: Floats, headers: Sequence[str]) -> None:
    """Refuse axes that are far off those that they are named for."""
    for way, (place, role) in enumerate(((0, "trough_along"), (1, "trough_normal"))):
        if abs(axes[way, place]) < math.cos(_MOST_OFF):
            off = math.degrees(math.acos(abs(axes[way, place])))
            wrong = f"column {shown(headers[place])} for {argument(role)} is {off:.0f} deg off that direction"
            raise InputError(wrong, hint="does each name stand for its sensor?")


def place_one(waves: Complexes, other: float, way: float, mounting: Mounting) -> Placement:
    """Return what the errors of a single sensor make of its motion.

    Parameters
    ----------
    waves : complex array, shape (H, 1)
        Harmonics of its readings.
    other : float
        Motion in the other direction over that in its own; of a drive along a line the same in all [1].
    way : float
        1 of a sensor along the trough, -1 of one normal to it.
    mounting : Mounting
        How it is mounted.
    """
    errors, turned = mounting.errors, mounting.turned or 0.0

    def factor(gain: float = 0.0, cross: float = 0.0, tilt: float = 0.0) -> float:
        cosine, sine = math.cos(turned + tilt), way * math.sin(turned + tilt)
        return 1.0 / ((1.0 + gain) * (cosine + other * sine) + cross * (other * cosine - sine))

    effects = {
        kind: 0.5 * (factor(**{kind: size}) - factor(**{kind: -size})) * waves[None]
        for kind, size in (("gain", errors.gain), ("cross", errors.cross), ("tilt", errors.tilt))
        if size
    }
    return Placement(np.array([[factor()]]), effects, turned, errors.tilt, mounting)


def _list(headers: Sequence[str]) -> str:
    return ", ".join(map(shown, headers))
