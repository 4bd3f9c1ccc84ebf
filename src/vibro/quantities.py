"""Every quantity that users enter: its names, units and range.

Outside (options, scene files, tables) a quantity has the unit of its column; inside (``Scene``) it is in SI
units and radians.
"""

from __future__ import annotations

import math
import re
import sys
from dataclasses import dataclass, replace
from decimal import Decimal
from fractions import Fraction
from functools import cached_property
from typing import TYPE_CHECKING, Any, Final

from vibro.errors import InputError, cut, shown
from vibro.units import (
    ACCELERATION,
    ANGLE,
    FORCE,
    FREQUENCY,
    IN_G,
    IN_GRAVITIES,
    LENGTH,
    PERCENT,
    PURE,
    SPEED,
    TIME,
    Kind,
)  # fmt: skip
from vibro.units import MASS as _MASS

if TYPE_CHECKING:
    from collections.abc import Collection, Iterable, Mapping


@dataclass(frozen=True)
class Range:
    """Allowed finite values of a quantity, in users' units; each end is included or not."""

    low: float = -math.inf
    high: float = math.inf
    with_low: bool = True
    with_high: bool = False

    def text(self, unit: str) -> str:
        """Return the range as text: ``finite and > 0 mm``, ``in [0, 90) deg``."""
        left, right = "[" if self.with_low else "(", "]" if self.with_high else ")"
        ends = f"in {left}{self.low:g}, {self.high:g}{right}"
        if math.isinf(self.low):
            return f"finite {unit}".rstrip()
        above = f"finite and {'>=' if self.with_low else '>'} {self.low:g}"
        return f"{above if math.isinf(self.high) else ends} {unit}".rstrip()


@dataclass(frozen=True)
class Quantity:
    """A quantity that users give.

    Attributes
    ----------
    name : str
        Name of the field of ``Scene``, if it is one.
    kind : Kind
        Its units.
    letter, symbol : str
        Short name as people type it, and as TeX for pictures.
    options : tuple of str
        The command line's, the shortest first; a name without dashes is that of ``NAME=VALUE``.
    allowed : Range
        What it may be.
    meaning : str
        What it is, for people.
    default : float or None
        Default value in the unit outside; None if it must be given.
    usual : Range
        Usual values; 0 is usual for all. Others are questioned as slips.
    slips : pair of str
        What to write instead where a value is below, and above: the likely slip of units. ``{0}`` is the
        value, ``{1}`` a hundredth of it.
    called : str
        Name in words, where that is not ``name``.
    """

    name: str
    kind: Kind = PURE
    letter: str = ""
    symbol: str = ""
    options: tuple[str, ...] = ()
    allowed: Range = Range()
    meaning: str = ""
    default: float | None = None
    usual: Range = Range()
    slips: tuple[str, str] = ("", "")
    called: str = ""

    @property
    def label(self) -> str:
        """Name in words, for messages and pictures."""
        words = self.called or self.name.replace("_", " ")
        return f"second {words[:-2]}" if words.endswith(" 2") else words  # of the harmonic

    @property
    def order(self) -> int:
        """Number of the harmonic that it is of; 1 of all other quantities."""
        last = self.name.rpartition("_")[2]
        return int(last) if last.isdigit() else 1

    @property
    def unit(self) -> str:
        """Unit outside: of options, files and tables; empty for pure numbers."""
        return self.kind.unit

    @property
    def column(self) -> str:
        """Name with unit, as tables and scene files spell it."""
        return self.name + self.kind.suffix

    @property
    def is_option(self) -> bool:
        """Whether the command line has an option for it; else it is given as ``NAME=VALUE``."""
        return any(option.startswith("-") for option in self.options)

    def typed(self, value: str = "VALUE") -> str:
        """Write how the command line gives a value: ``-A 3mm``, ``gravity=3.7``."""
        return f"{self.options[0]}{' ' if self.is_option else '='}{value}"

    @property
    def swept(self) -> Quantity:
        """The same with what an axis may hold: a friction ratio above 1, whose cells are infeasible."""
        return replace(self, allowed=ZERO_OR_MORE) if self.name == "friction_ratio" else self

    @property
    def range_text(self) -> str:
        """Allowed range as text, in SI units, but angles in degrees."""
        if self.kind.si_unit == "rad":
            return self.allowed.text("deg")
        low, high = self.si_ends
        return replace(self.allowed, low=low, high=high).text(self.kind.si_unit)

    def doubt(self, first: float | Fraction, last: float | Fraction) -> str:
        """Return a warning about an axis, or a single value, that is unusual as a whole; else an empty text.

        An axis may run up to an extreme on purpose.
        """
        if first > self.usual.high:
            nearest, text = first, self.doubts[1]
        elif last < self.usual.low and last:
            nearest, text = last, self.doubts[0]
        else:
            return ""
        return text.format(f"{float(nearest):.15g}", f"{float(nearest) / 100.0:.15g}")

    @property
    def doubts(self) -> tuple[str, str]:
        """Warnings of a value below the usual ones, and of one above; ``{0}`` and ``{1}`` as in ``slips``."""
        value = f"{self.label} = {{0}} {self.unit}".rstrip()
        low, high = self.text(self.usual.low), self.text(self.usual.high)
        return (
            f"{value} is below what is usual, {low}: {self.slips[0]}",
            f"{value} is above what is usual, {high}: {self.slips[1]}",
        )

    def text(self, value: float | Fraction) -> str:
        """Write a value with its unit, as messages do."""
        return f"{float(value):.15g} {self.unit}".rstrip()

    def to_si(self, values: Any) -> Any:
        """Convert from the unit outside to SI units and radians."""
        return self.kind.to_si(values)

    def from_si(self, values: Any) -> Any:
        """Convert from SI units and radians to the unit outside."""
        return self.kind.from_si(values)

    @cached_property
    def si_ends(self) -> tuple[float, float]:
        """Ends of the range in SI units."""
        return self.to_si(self.allowed.low), self.to_si(self.allowed.high)

    def allows(self, values: Any) -> Any:
        """Return whether finite values in SI units lie in the range."""
        low, high = self.si_ends
        above = values >= low if self.allowed.with_low else values > low
        return above & (values <= high if self.allowed.with_high else values < high)


# Limits far beyond any trough, so that products and squares of all quantities are doubles; in users' units.
_FEW: Final = 1e-12  # [mm, Hz, m/s^2, kg, %...] least value of what may not be 0: an atom is 1e-7 mm wide
_MANY: Final = 1e12  # [1, Hz, m/s^2, kg, %...] nothing holds, shakes, pulls or weighs so much
_FAR: Final = 1e9  # [mm] no trough is as large as a country
_ROUND: Final = 1e8  # [deg] the rounding of a larger phase would be felt

#: Range of what is positive, and of what may be 0 too.
POSITIVE: Final = Range(_FEW, _MANY, with_high=True)
ZERO_OR_MORE: Final = Range(0.0, _MANY, with_high=True)
#: Range of what may be of either sign.
EITHER_WAY: Final = Range(-_MANY, _MANY, with_high=True)
_SIZE: Final = Range(_FEW, _FAR, with_high=True)
_SIZE_OR_NONE: Final = Range(0.0, _FAR, with_high=True)
_PHASE: Final = Range(-_ROUND, _ROUND, with_high=True)

STANDARD_GRAVITY: Final = 9.81  # [m/s^2], the value of the paper and of all published figures here

MOST_HARMONICS: Final = 16  # of a drive
LISTED_HARMONICS: Final = 2  # whose quantities are listed one by one; more would fill a page


# fmt: off
def _harmonic(n: int) -> tuple[Quantity, ...]:
    """Describe the n-th harmonic of a drive, n > 1; the second alone has options."""
    parts = (
        ("along", "X", "xi", r"\xi", "along the trough"),
        ("normal", "Y", "eta", r"\eta", "normal to the trough"),
    )
    return tuple(
        quantity
        for way, size, letter, symbol, where in parts
        for quantity in (
            Quantity(f"{way}_amplitude_{n}", LENGTH, f"{size}{n}", f"{size}_{n}",
                     (f"{way}_{n}",) if n == 2 else (), _SIZE_OR_NONE,
                     f"amplitude of harmonic {n} of the motion {where}"),
            Quantity(f"{way}_phase_{n}", ANGLE, f"{letter}{n}", rf"{symbol}_{n}",
                     (f"{way}_phase_{n}",) if n == 2 else (), _PHASE,
                     f"phase of harmonic {n} of the motion {where}"),
        )
    )


_OF_SINE: Final = replace(LENGTH, of_sine=True)
_LENGTHS: Final = ("for metres write {0}m", "for micrometres write {0}um")
_FRICTIONS: Final = ("", "for {0} % write {1}")
_PERCENT: Final = ("it is in percent: 100 is all of it", "100 is all of it")
_ALL: Final = (
    Quantity("setting", PERCENT, "s", "s", ("setting",), POSITIVE,
             "setting of a machine: its force over that at 100 %", 100.0, Range(2.0, 100.0, with_high=True),
             _PERCENT),
    Quantity("voltage", PERCENT, "U", "U", ("voltage",), POSITIVE,
             "voltage of a machine's supply over its nominal voltage", 100.0, Range(50.0, 150.0), _PERCENT),
    Quantity("filling", _MASS, "m", "m", ("filling",), ZERO_OR_MORE,
             "mass of the filling in the trough", 0.0, Range(high=1e5),
             ("", "for grams write {0}g")),
    Quantity("natural", FREQUENCY, "f0", "f_0", ("natural",), POSITIVE,
             "natural frequency of the empty machine", usual=Range(high=1000.0),
             slips=("", "for cycles a minute write {0}rpm"), called="natural frequency"),
    Quantity("amplitude", _OF_SINE, "A", "A", ("-A", "--amplitude"), _SIZE,
             "amplitude of the trough's motion, half of its stroke",
             usual=Range(0.002, 100.0), slips=_LENGTHS),
    Quantity("stroke", LENGTH, "stroke", "2A", ("--stroke",), _SIZE,
             "stroke of the trough from peak to peak, twice the amplitude",
             usual=Range(0.004, 200.0), slips=_LENGTHS),
    Quantity("drive_speed", replace(SPEED, of_sine=True), "drive_speed", r"A\omega", (), POSITIVE,
             "largest speed of the trough's motion, where it gives the amplitude"),
    Quantity("acceleration", IN_G, "acceleration", r"A\omega^2", (), POSITIVE,
             "largest acceleration of the trough's motion in units of 9.80665 m/s^2, where it gives the"
             " amplitude",
             usual=Range(high=20.0), slips=("", "for m/s^2 write {0}m/s2")),
    Quantity("along_amplitude", LENGTH, "X", "X", ("along",), _SIZE_OR_NONE,
             "amplitude of an elliptical motion along the trough",
             usual=Range(high=100.0), slips=_LENGTHS),
    Quantity("normal_amplitude", LENGTH, "Y", "Y", ("normal",), _SIZE_OR_NONE,
             "amplitude of an elliptical motion normal to the trough",
             usual=Range(high=100.0), slips=_LENGTHS),
    Quantity("frequency", FREQUENCY, "f", "f", ("-f", "--frequency"), POSITIVE, "frequency of the drive",
             usual=Range(high=1000.0), slips=("", "for revolutions a minute write {0}rpm")),
    Quantity("drive_angle", ANGLE, "alpha", r"\alpha", ("-a", "--drive-angle"),
             Range(0.0, 90.0), "angle of the drive's line above the trough",
             usual=Range(1.0), slips=("for radians write {0}rad", "")),
    Quantity("normal_phase", ANGLE, "phi", r"\varphi", ("phase",), _PHASE,
             "phase lead of the normal motion over the motion along the trough"),
    Quantity("along_phase", ANGLE, "xi", r"\xi", (), _PHASE,
             "phase of the first harmonic along the trough, where arrays give it; else 0"),
    *(quantity for n in range(2, MOST_HARMONICS + 1) for quantity in _harmonic(n)),
    Quantity("motion_scale", PURE, "c", "c", ("motion_scale",), POSITIVE,
             "factor of all amplitudes, or accelerations, of a motion", 1.0),
    Quantity("static_friction", PURE, "mu_s", r"\mu_s", ("--mu-s",), ZERO_OR_MORE,
             "coefficient of friction at rest", usual=Range(high=2.0), slips=_FRICTIONS),
    Quantity("friction_ratio", PURE, "mu_ratio", r"\mu_d/\mu_s", ("--mu-ratio",),
             Range(0.0, 1.0, with_high=True), "kinetic over static friction, instead of kinetic friction"),
    Quantity("kinetic_friction", PURE, "mu_d", r"\mu_d", ("--mu-d",), ZERO_OR_MORE,
             "coefficient of friction while sliding, at most the static one",
             usual=Range(high=2.0), slips=_FRICTIONS),
    Quantity("trough_angle", ANGLE, "beta", r"\beta", ("--trough-angle",),
             Range(-90.0, 90.0, with_low=False), "inclination of the trough (> 0 uphill)", 0.0),
    Quantity("gravity", ACCELERATION, "g", "g", ("gravity",), POSITIVE, "acceleration of gravity",
             STANDARD_GRAVITY, Range(1.0, 100.0), 2 * ("it is in m/s^2, 9.81 on Earth",)),
    Quantity("normal_acceleration", ACCELERATION, "P", "N/m", ("normal_acceleration",), POSITIVE,
             "constant normal force on a clamped part over its mass"),
    Quantity("restitution", PURE, "e", "e", ("--restitution",), Range(0.0, 1.0),
             "normal coefficient of restitution of an impact on the trough", 0.0),
    Quantity("trough_length", LENGTH, "L", "L", ("-L", "--length"), POSITIVE, "length of the trough"),
)
# fmt: on
#: The normal force on a clamped part, which a scene file may give beside the part's mass.
NORMAL_FORCE: Final = Quantity("normal_force", FORCE, allowed=POSITIVE)
#: Every quantity of a scene by its name, in the order of a table's columns.
QUANTITIES: Final[Mapping[str, Quantity]] = {q.name: q for q in _ALL}
#: Those with options by their names with units, the keys of scene files and of ``vibro.sweep``.
BY_COLUMN: Final[Mapping[str, Quantity]] = {q.column: q for q in _ALL if q.options}

#: Quantities of a machine, from which the amplitude follows: beside a machine alone.
MACHINE: Final = ("setting", "voltage", "filling", "natural")
#: The quantities that can be axes of a sweep, in the same order.
SWEPT: Final = (
    "setting", "voltage", "filling", "natural",
    "amplitude", "drive_speed", "acceleration", "along_amplitude", "normal_amplitude", "frequency",
    "drive_angle", "normal_phase", "along_amplitude_2", "along_phase_2", "normal_amplitude_2",
    "normal_phase_2", "motion_scale", "static_friction", "friction_ratio", "kinetic_friction", "trough_angle",
    "normal_acceleration", "restitution",
)  # fmt: skip
#: Fields of a drive along a line, and of one along an ellipse, whose phase is 0 if it is not given.
LINEAR: Final = ("amplitude", "drive_angle")
ELLIPTICAL: Final = ("along_amplitude", "normal_amplitude", "normal_phase")
#: Fields of a drive with harmonics besides those of an ellipse.
HARMONIC: Final = ("along_phase", *(q.name for n in range(2, MOST_HARMONICS + 1) for q in _harmonic(n)))
#: Quantities of drives along an ellipse, with harmonics or without.
TWO_AXIS: Final = (*ELLIPTICAL, *HARMONIC)
#: Factor of a drive that is a motion, with harmonics, steps or samples.
SCALE: Final = "motion_scale"
#: Fields of all drives.
DRIVES: Final = (*LINEAR, *ELLIPTICAL, *HARMONIC, SCALE)
#: The amplitudes of a drive, with all of which its load grows.
AMPLITUDES: Final = tuple(name for name in DRIVES if "amplitude" in name)
#: What gives the amplitude of a line together with the frequency, by the power of this.
RATES: Final[Mapping[str, int]] = {"drive_speed": 1, "acceleration": 2}
#: What the load of a drive grows with, as a drive's size may be given.
SIZES: Final = ("stroke", *RATES, *AMPLITUDES)
#: Two ways to give the same thing: the first fills the place of the second.
STANDS_FOR: Final[Mapping[str, str]] = {
    **dict.fromkeys(("stroke", *RATES), "amplitude"),
    "friction_ratio": "kinetic_friction",
}
#: Default values, in the units outside.
DEFAULTS: Final[Mapping[str, float]] = {
    q.name: q.default for q in _ALL if q.default is not None and q.name not in (*DRIVES, *MACHINE)
}
#: The trough angle of a clamped part, which may hang on a vertical trough.
_CLAMPED_TROUGH: Final = replace(QUANTITIES["trough_angle"], allowed=Range(-90.0, 90.0, with_high=True))

#: Acceleration of the drive over that of gravity.
LOAD: Final = Quantity(
    "acceleration",
    IN_GRAVITIES,
    usual=Range(high=20.0),
    slips=("", "is the amplitude in um (800um), or the frequency in rpm (900rpm)?"),
)

#: Accelerations and displacements of a motion, as steps and samples have them.
SHAKEN: Final = Quantity("acceleration", ACCELERATION, allowed=EITHER_WAY)
SHIFTED: Final = Quantity("displacement", LENGTH, allowed=Range(-_FAR, _FAR, with_high=True))

# Quantities of a run, of a part or of a record, not of a scene.
MASS: Final = Quantity("mass", _MASS, allowed=POSITIVE)
#: Sampling rate of a record.
RATE: Final = Quantity("rate", FREQUENCY, allowed=POSITIVE)
#: Mass of an empty trough and of what moves with it, beside the mass of its filling.
TROUGH_MASS: Final = Quantity(
    "trough_mass", _MASS, "", "", ("trough_mass",), POSITIVE, "mass of the empty trough, beside a filling"
)
PITCH: Final = Quantity("pitch", LENGTH, allowed=POSITIVE)
LEAST_SPEED: Final = Quantity("speed", SPEED, allowed=POSITIVE)
STAND_RATIO: Final = Quantity("stand_ratio", allowed=POSITIVE)
#: Length that a part moves along the trough.
WAY: Final = Quantity("length", LENGTH, allowed=POSITIVE)
CYCLES: Final = Quantity("cycles", allowed=Range(_FEW, 1e15, with_high=True))  # as many as doubles count
DURATION: Final = Quantity("duration", TIME, allowed=POSITIVE)
#: Time on the clock of a record, whose zero may be years away.
CLOCK: Final = Quantity("time", TIME, allowed=EITHER_WAY)
START_PHASE: Final = Quantity(
    "start_phase", ANGLE, "", "", ("start_phase",), _PHASE, "phase of the trough at the start"
)
START_VELOCITY: Final = Quantity(
    "start_velocity",
    SPEED,
    "",
    "",
    ("start_velocity",),
    EITHER_WAY,
    "velocity along the trough at the start",
)
START_HEIGHT: Final = Quantity(
    "start_height", LENGTH, "", "", ("start_height",), ZERO_OR_MORE, "height above the trough at the start"
)
START_NORMAL_VELOCITY: Final = Quantity(
    "start_normal_velocity", SPEED, "", "", ("start_normal_velocity",), EITHER_WAY,
    "speed away from the trough at the start",
)  # fmt: skip

# Possessive, so that the time of a refusal grows with the length of a text and not with its square.
_NUMBER = re.compile(
    r"([+-]?+(?:[0-9]++\.?+[0-9]*+|\.[0-9]++)(?:[eE][+-]?+[0-9]++)?+)\s*+([^\W\d_].*|[\u00b0%]|1?/.*)?"
)
# A decimal comma; before three digits it may part thousands, and between long numbers two of them.
_COMMA: Final = re.compile(
    r"([+-]?[0-9]+),(?![0-9]{3}(?![0-9])|(?<=[0-9]{2},)[0-9]{3})([0-9]+)(?![0-9]|.*,)", re.DOTALL
)
_AROUND_PER: Final = re.compile(r"\s*/\s*")
_NOT_FINITE = re.compile(r"[+-]?(nan|inf|infinity)(?![a-z])", re.IGNORECASE)
_CATALOGUED: Final = ("static_friction", "kinetic_friction", "restitution")
# More digits than this are no number that somebody measured or computed: those of every double fit.
_LONGEST: Final = 1000  # characters
_ONE: Final = (1, 1)
_HINTED: Final = 40  # characters of a text that a hint repeats
_SPELLED_DIGITS: Final = 15  # every double has them, and people write no more


def find_quantity(text: str) -> Quantity | None:
    """Find a quantity of a scene by its name, letter or option, or a name with its unit."""
    called = text.strip()
    spelled = called.removeprefix("--").replace("-", "_").replace(" ", "_").casefold()
    # A single letter keeps its case: A is the amplitude, while the option -a is the drive angle.
    letters = {called} if len(called) == 1 else {called, spelled}
    for q in _ALL:
        names = {q.name, *q.options}
        if (
            called in q.options
            or spelled in {*names, *(n + q.kind.suffix for n in names)}
            or q.letter in letters
        ):
            return q
    return None


def of_part(quantity: Quantity, *, is_clamped: bool) -> Quantity:
    """Return a quantity with the range that it may have of a part that lies on the trough, or is clamped."""
    return _CLAMPED_TROUGH if is_clamped and quantity.name == _CLAMPED_TROUGH.name else quantity


def as_given(values: Mapping[str, Any], *, in_stroke: bool) -> dict[str, Any]:
    """Tell the size of a drive along a line by the quantity in which it was given.

    Parameters
    ----------
    values : mapping of str to float or array
        Quantities in the unit outside, by name; an amplitude or a stroke may be among them.
    in_stroke : bool
        Whether strokes were given, not amplitudes.

    Returns
    -------
    dict
        The same in the same order, with ``stroke`` in the place of ``amplitude``, or the other way round: one
        is twice the other, which rounds nothing. Without the amplitude where it follows from a speed or an
        acceleration that was given.
    """
    if not RATES.keys().isdisjoint(values):
        return {name: value for name, value in values.items() if name != "amplitude"}
    wanted, other, factor = ("stroke", "amplitude", 2.0) if in_stroke else ("amplitude", "stroke", 0.5)
    return {
        wanted if name == other else name: factor * value if name == other else value
        for name, value in values.items()
    }


def millimetres(rate: str, frequency: Any) -> Any:
    """Return the amplitude [mm] of a sine whose largest speed or acceleration is 1 in its unit outside.

    Parameters
    ----------
    rate : str
        A name of ``RATES``: ``A = v/(2 pi f)``, or ``a/(2 pi f)^2`` with g = 9.80665 m/s^2.
    frequency : float or array
        [Hz].
    """
    return 1e3 * QUANTITIES[rate].to_si(1.0) / (2.0 * math.pi * frequency) ** RATES[rate]


def with_amplitude(values: Mapping[str, Any]) -> dict[str, Any]:
    """Add the amplitude of a line that follows from its speed or acceleration, and from the frequency.

    Quantities are in the units outside, by name, as they are returned.
    """
    found = dict(values)
    for name in RATES:
        if {name, "frequency"} <= found.keys():
            found["amplitude"] = found[name] * millimetres(name, found["frequency"])
    return found


def drive_of(names: Collection[str]) -> tuple[str, ...]:
    """Return the names among the given ones that describe the drive, in the order of a table's columns."""
    given = {STANDS_FOR.get(name, name) for name in names}
    return tuple(name for name in QUANTITIES if name in given and name in DRIVES)


def counted_harmonics(names: Collection[str]) -> list[str]:
    """Write how many harmonics quantities describe; empty if all are listed one by one."""
    highest = max((QUANTITIES[name].order for name in names), default=1)
    return [f"{highest} harmonics"] * (highest > LISTED_HARMONICS)


def kinetic_friction(ratio: Any, static_friction: Any) -> Any:
    """Kinetic friction by its ratio to static friction, spelled as a person would: 0.8 of 0.2 is 0.16.

    Parameters
    ----------
    ratio, static_friction : float or array
        Broadcastable.

    Returns
    -------
    float or array
        The product to 15 digits, where that is as good a rounding of it as the nearest double, which for 0.8
        of 0.2 is 0.16000000000000003. For a ratio of at most 1 it is at most static friction.
    """
    import numpy as np

    product = np.asarray(np.multiply(ratio, static_friction), np.float64)
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        digits = np.clip(_SPELLED_DIGITS - 1.0 - np.floor(np.log10(product)), 0.0, 22.0)
        scale = np.power(10.0, digits)  # exact up to 1e22, so that the quotient is correctly rounded
        spelled = np.rint(product * scale) / scale
        close = np.abs(spelled - product) <= np.spacing(product)
    result = np.where(close, spelled, product)
    result = np.where(np.less(ratio, 1.0), np.minimum(result, static_friction), result)
    return np.where(np.equal(ratio, 1.0), static_friction, result)[()]


def scene_fields(values: Mapping[str, Any]) -> dict[str, Any]:
    """Turn quantities in the units outside into the fields of ``Scene``, in SI units and radians.

    Parameters
    ----------
    values : mapping of str to float or array
        By name; ``stroke``, or a speed or an acceleration, may replace the amplitude, and ``friction_ratio``
        the kinetic friction. A trough length, the quantities of a machine and its results are left out. Under
        ``motion`` a ``Motion`` may stand, or an array of one.
    """
    given = with_amplitude(as_given(values, in_stroke=False))
    for name in ("trough_length", "operating", *MACHINE, *RATES):
        given.pop(name, None)
    if "friction_ratio" in given:
        ratio = given.pop("friction_ratio")
        if "kinetic_friction" not in given:
            given["kinetic_friction"] = kinetic_friction(ratio, given["static_friction"])
    motion = given.pop("motion", None)
    fields = {name: QUANTITIES[name].to_si(value) for name, value in given.items()}
    if motion is not None:
        return {**fields, "motion": motion.item() if hasattr(motion, "item") else motion}
    if fields.keys() & {*HARMONIC, "normal_acceleration"} and fields.keys() & set(TWO_AXIS):
        ways = {"along": ("along_amplitude", "along_phase"), "normal": ("normal_amplitude", "normal_phase")}
        for way, names in ways.items():
            pairs = [
                tuple(fields.pop(name if n == 1 else f"{name}_{n}", 0.0) for name in names)
                for n in range(1, MOST_HARMONICS + 1)
            ]
            last = max((n for n, (size, _) in enumerate(pairs, 1) if not _is_zero(size)), default=1)
            fields[f"{way}_harmonics"] = pairs[:last]
    elif SCALE in fields:
        scale = fields.pop(SCALE)
        fields |= {name: scale * fields[name] for name in AMPLITUDES if name in fields}
    return fields


def _is_zero(value: Any) -> bool:
    """Whether a value is none, and no array of such."""
    return isinstance(value, float) and not value


def exact_number(text: str, quantity: Quantity) -> Fraction:
    """Read a number that may carry a unit, exactly, in the quantity's default unit.

    Parameters
    ----------
    text : str
        Such as ``15``, ``1.2mm``, ``800um``, ``900rpm`` or ``20°``; of at most 1000 characters.
    quantity : Quantity
        What the number is for; it decides which units fit.

    Returns
    -------
    Fraction
        In the default unit of the quantity; 0 where the nearest double is 0.

    Raises
    ------
    InputError
        If the text is no finite number, or its unit does not fit the quantity.

    Examples
    --------
    >>> float(exact_number("800um", QUANTITIES["amplitude"]))
    0.8
    """
    digits, size = _split(text, quantity)
    # Doubles bound the exponent, so that the exact value below stays small enough to compute with.
    rounded = float(digits)
    if not math.isfinite(rounded):
        raise _not_finite(text, quantity)
    exact = Fraction(Decimal(digits)) * Fraction(*size) if rounded else Fraction(0)
    if abs(exact) > sys.float_info.max:
        raise _not_finite(text, quantity)
    return exact if float(exact) else Fraction(0)


def quantity_meant(texts: Iterable[str], quantity: Quantity) -> Quantity:
    """Return what numbers are of, by their units: an amplitude may be given by its acceleration or speed.

    Parameters
    ----------
    texts : iterable of str
        As ``parse_axis`` takes them.
    quantity : Quantity
        What they are given as.

    Raises
    ------
    InputError
        If they are rms values from peak to peak, or one has no unit beside others than the usual one.
    """
    if quantity.name not in ("amplitude", "stroke"):
        return quantity
    for text in texts:
        is_log = text.rstrip().casefold().endswith("log")
        tokens = [  # without a count, and without a factor
            token.strip().removeprefix("step=")
            for place, token in enumerate(re.split("[:,]", text[:_LONGEST]))
            if place < 2 or ":" not in text or ("step=" in token and not is_log)
        ]
        matches = filter(None, map(_NUMBER.fullmatch, map(_plain, tokens)))
        units = {_AROUND_PER.sub("/", match[2] or "").casefold() for match in matches}
        rates = (QUANTITIES[name] for name in RATES)
        other = next((q for q in rates if not units.isdisjoint(q.kind.ratios)), None)
        if quantity.name == "stroke" and any(unit.endswith((" rms", " peak")) for unit in units):
            way = "rms" if any(unit.endswith("rms") for unit in units) else "peak"
            problem = f"stroke = {shown(text)}: a value from peak to peak is no {way} value"
            raise InputError(problem, hint="give it as the amplitude, not the stroke")
        if other is not None:
            if "" in units and units != {"", other.unit}:
                problem = f"{quantity.label} = {shown(text)}: a number has no unit"
                raise InputError(problem, hint="give each number its unit")
            return other
    return quantity


def checked_number(text: str, quantity: Quantity) -> float:
    """Read a number as ``exact_number`` does, and check its range.

    Returns
    -------
    float
        In the quantity's default unit.

    Raises
    ------
    InputError
        If the text is no number that the quantity may have.
    """
    value = float(exact_number(text, quantity))
    if not quantity.allows(quantity.to_si(value)):
        allowed = quantity.allowed.text(quantity.unit)
        raise InputError(f"{quantity.label} = {cut(text)}: must be {allowed}")
    return value


def given_unit(text: str, quantity: Quantity) -> tuple[str, Fraction]:
    """Return the unit that a valid number carries, and its size in the default unit, which it is without."""
    match = _NUMBER.fullmatch(_plain(text))
    given = _AROUND_PER.sub("/", (match and match[2]) or quantity.unit).casefold()
    return next((unit, size) for unit, size in quantity.kind.sizes.items() if unit.casefold() == given)


def _plain(text: str) -> str:
    """Write a number with a hyphen for a minus sign, and a point for a decimal comma."""
    text = text.strip().replace("\N{MINUS SIGN}", "-")
    return _COMMA.sub(r"\1.\2", text, count=1) if len(text) <= _HINTED and _COMMA.match(text) else text


def _split(text: str, quantity: Quantity) -> tuple[str, tuple[int, int]]:
    """Split a number from its unit, and return the size of that in the quantity's default unit."""
    text = _plain(text)
    if len(text) > _LONGEST:
        raise InputError(
            f"{quantity.label} = {shown(text)}: longer than {_LONGEST} characters",
            hint="17 digits are enough for every number that vibro computes with",
        )
    match = _NUMBER.fullmatch(text)
    if match is None:
        if _NOT_FINITE.match(text):
            raise _not_finite(text, quantity)
        raise InputError(f"{quantity.label} = {shown(text)}: not a number", hint=_number_hint(text, quantity))
    digits, unit = match[1], _AROUND_PER.sub("/", match[2] or "")
    size = quantity.kind.ratios.get(unit.casefold()) if unit else _ONE
    if size is None:
        problem = f"{quantity.label} = {shown(text)}: {shown(unit)} is no unit of {quantity.label}"
        known = ", ".join(quantity.kind.sizes)
        hint = f"its units are {known}" if quantity.unit else "it is a pure number, or one in %"
        raise InputError(problem, hint=hint)
    return digits, size


def _not_finite(text: str, quantity: Quantity) -> InputError:
    return InputError(f"{quantity.label} = {cut(text.strip())}: must be a finite number")


def _number_hint(text: str, quantity: Quantity) -> str:
    if quantity.unit:
        return f"write it like 1.5{quantity.unit}"
    return catalogue_hint(text, quantity) or "write it like 0.5"


def catalogue_hint(text: str, quantity: Quantity) -> str:
    """Return what the catalogue says of a coefficient that is given by its materials; else an empty text."""
    if quantity.name not in _CATALOGUED or not text.strip()[:1].isalpha():
        return ""
    from vibro.friction import number_hint

    return number_hint(text, quantity.name)
