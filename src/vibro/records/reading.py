"""Measured records: CSV files with any column names, units, separators and decimals."""

from __future__ import annotations

import math
import re
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from vibro.errors import InputError, argument, cut, did_you_mean, shown
from vibro.files.reading import read_text, rows_of
from vibro.quantities import RATE, checked_number
from vibro.records.formats import lvm_table, read_channels
from vibro.units import LENGTH, SPEED

if TYPE_CHECKING:
    from vibro.reals import Floats

# ------------------------------------------------------------------------------
# Limits, steps and thresholds of the analysis of records, each with its unit and reason.


class _Tolerances(NamedTuple):
    """Limits, steps and thresholds; shares or factors if no unit is given."""

    # --- reading --------------------------------------------------------------------------------------
    # Largest value in a record, or in a scene that is compared with one [SI]; the smallest in a scene is its
    # inverse. Fourth powers are summed over the rows and must stay far below the largest double.
    largest: float = 1e20
    # Ratio of measured and computed size, either way, from which a unit is doubted: less than 10, as a
    # sensitivity may be wrong by 10 and the motion a little smaller than computed.
    far_off: float = 7.0
    far_angle: float = float(np.radians(20.0))  # [rad] from the scene's drive angle: sensors may be exchanged
    looked_at: int = 300  # rows in which separator and header are searched
    gap: float = 3.5  # usual steps of the time in one step: two missing rows and the rounding of times
    skipped: float = 0.05  # largest share of rows without a value
    cells_named: int = 5  # bad cells of a column, or rows, that a message names
    headers_named: int = 12  # headers that a message names

    # --- harmonic regression --------------------------------------------------------------------------
    # Relative: times are rounded when they are written. Cycles and samples may fall short of a whole number
    # by as much, or 40 samples a cycle would resolve 17 or 18 harmonics depending on the last digit.
    printed: float = 1e-6
    least_cycles: float = 2.0  # cycles of any wave in the record
    least_samples: int = 8  # samples a drive cycle
    # The velocity of a slide has kinks, whose harmonics fall off quadratically: more of them do not help.
    most_harmonics: int = 24
    of_nyquist: float = 0.9  # of half the sampling rate, at which a harmonic cannot be resolved
    # Power of a harmonic over the mean power of noise in it; noise exceeds this in 3 of 10 000 harmonics.
    significant: float = 8.0

    # --- frequency of a record ------------------------------------------------------------------------
    coarsest: float = 4.0  # samples in a cycle of the largest wave
    explained_up_to: float = 8.0  # highest harmonic over the frequency of the largest wave
    padding: int = 4  # of the spectrum, so that its peaks lie within an eighth of 1/T
    near_peak: float = 0.6  # [1/T] largest distance of the best frequency from the peak
    curvature_step: float = 0.02  # [1/T] the phase at the end of the record changes by 3.6 deg
    lowest_fraction: int = 6  # highest harmonic that may be the largest wave
    rounded: float = 1e-6  # of a signal's largest value: smaller deviations from its trend are rounding
    # Of a power: the ridge of a regression, and the least residual. Of the amplitude of the drive: the least
    # standard deviation of a residual. Of a quantity: the least step.
    rounding: float = 1e-12
    # Gain of the log-likelihood: 5 sigma, besides the logarithm of the number of frequencies that are tried.
    clear: float = 12.5
    own_wave: float = 0.1  # least power of a fundamental over that of the largest wave
    least_share: float = 0.3  # of a signal's power that a frequency must explain
    most_share: float = 0.8  # of a signal's power: noise explains less,
    many_cycles: float = 5.0  # if there are so many cycles
    missing: float = 0.05  # of the power: a wave with less counts as missing
    drifted: float = 0.05  # cycles by which drive and data may drift apart over the record
    sigmas: float = 4.0  # standard errors by which two frequencies, or clocks, differ at least
    most_cycles: int = 8  # drive cycles after which a body that hops may repeat its motion

    # --- alignment ------------------------------------------------------------------------------------
    shifts: int = 512  # shifts in a cycle at which the search begins
    # Least misfit of a signal over its size. A signal that fits exactly would outweigh all others.
    least_misfit: float = 1e-9
    # Range of the log-likelihoods per sample below which all positions in the cycle fit equally well.
    flat: float = 1e-3
    # Only the middle of long records is searched: errors are far below the sample time with so many rows,
    searched_rows: int = 6000
    searched_cycles: float = 4.0  # and at least so many cycles
    searched: float = 0.05  # [cycles] to each side of the rough result,
    searched_steps: int = 41  # in so many steps
    # Standard errors above which a wave stands out, an ellipse is no line, and a rival position does not fit.
    likely_sigmas: float = 3.0

    # --- accelerations of the trough ------------------------------------------------------------------
    few_harmonics: float = 0.1  # root mean square of harmonics over the fundamental's: warn of more
    much_rest: float = 0.3  # the same of the residual
    channel_phase: float = 2.0  # [deg] phase that two channels may add, so that a line seems an ellipse
    digits: int = 2  # digits that are written below the first one of the error
    usual_acceleration: float = 50.0  # [m/s^2] conveyors hardly vibrate with more
    # Of a motion: the phase of a smaller component does not matter, and the motion cannot be scaled from it.
    least_component: float = 1e-3

    # --- harmonics of the trough's motion -------------------------------------------------------------
    motion_harmonics: int = 16  # that are tested
    of_sampling: float = 0.45  # of the sampling rate: the highest of them, with the band beside it
    band: float = 0.35  # of the drive's frequency, to each side of a harmonic: noise there is that in it
    # Two bins to each side of a harmonic, of which two channels need more than one for their covariance.
    motion_cycles: float = 6.0
    least_bins: int = 2  # to each side; with fewer noise counts as white
    about: float = 1e-3  # by which cycles and samples may fall short, as the frequency is measured
    by_chance: float = 1e-3  # probability by which noise passes for a harmonic
    frequency_rows: int = 40_000  # in the middle of a record in which its frequency is searched,
    frequency_growth: int = 4  # and growth of that part from one refinement to the next
    frequency_rounds: int = 8  # of Gauss and Newton's method; two are usual,
    frequency_step: float = 0.1  # [1/T] largest step of it, as the first frequency is better
    frequency_close: float = 1e-7  # of that step: the last one
    clip_band: float = 0.002  # of a signal's range, beside its ends
    # Rows at an end over those in the band: 2.4 of a sine of whole digits, 5.3 of a flatter crest.
    clip_ratio: float = 8.0

    harmonics_matter: float = 1e-3  # of the speed: a smaller change by harmonics is left out of a comparison
    draws: int = 200  # of the noise: their standard deviation is known to 5 %

    # --- comparison -----------------------------------------------------------------------------------
    slide_level: float = 0.1  # of a slide's computed peak speed, at its start and end
    fine: int = 4096  # points a cycle at which folded signals are searched
    curve: int = 1001  # points of a smooth curve
    clocks_apart: float = 0.02  # [cycles] least difference of the clocks of trough and body to warn of
    proposed: float = 0.01  # [cycles] drift of a proposed frequency from the data over the record

    # --- residuals of a fit ---------------------------------------------------------------------------
    jump_window: float = 0.25  # sample times over which the model's jumps are averaged: derivatives exist
    least_scale: float = 1e-3  # of the greatest value that is tried: least size of a quantity
    most_predecessors: int = 8  # samples on which the noise of one may depend,
    rows_of_a_predecessor: int = 30  # and rows for each of them
    random_share: float = 0.1  # of the power of a residual that must change from cycle to cycle, for jitter
    variance_rounds: int = 3  # regressions of the variances, each weighted by the last one
    least_jitter_variance: float = 1e-3  # of the mean variance
    jitter_gain: float = 6.0  # twice the gain of log-likelihood: 2.4 sigma, for one more parameter
    most_tried: int = 20_000  # scenes of the first grid; a random part of a larger one
    most_hopping: int = 40  # scenes with flights, each of which takes as long as a hundred others
    rough_shifts: int = 128  # shifts in a cycle at which each of these is compared
    starts: int = 3  # starts of the search in each pattern
    at_once: int = 512  # scenes in memory

    # --- least squares in a pattern -------------------------------------------------------------------
    # Relative step of derivatives: the model's noise is 1e-15, its curvature of order 1. It is also the error
    # of edges, and of a search.
    step: float = 1e-6
    edge_step: float = 1e-4  # the same along an edge, whose position has the error above
    idle: float = 1e-6  # of the largest effect of a coordinate: less is rounding, and becomes 0
    outside: float = 1e60  # [standard deviations] residuals outside the pattern: their squares are doubles
    most_steps: int = 80
    edges: int = 6  # searches along edges,
    steps_along_edge: int = 8  # and steps of each
    edge_places: tuple[int, int] = (65, 9)  # points between which an edge is searched, at first and later
    edge_rounds: int = 9  # largest number of rounds
    distances: tuple[float, float, int] = (1e-7, 0.5, 60)  # relative, at which a pattern is searched
    enough: float = 2e-3  # [variances] decrease of the sum of squares below which a search ends,
    rough: float = 1.0  # and a first one

    # --- fit ------------------------------------------------------------------------------------------
    confidence: float = 0.95
    # [variances] A pattern that fits worse by this is excluded: 4 sigma. Another pattern may have values far
    # away: excluding the true one at 2 sigma would be wrong by many half-widths once in 20 times.
    excluded: float = 16.0
    stands_out: float = 25.0  # [variances] by which a motion must fit better than rest: 5 sigma
    explained: float = 1.1  # largest sum of squares over the number of samples of an explained record
    better: float = 0.1  # of the threshold: a point better than the best by this starts another search,
    restarts: int = 3  # so often
    weighings: int = 3  # how often the weights are found anew
    neighbours: int = 400  # points around a minimum at which other patterns are searched,
    widest: float = 4.0  # up to so many standard deviations,
    farthest_neighbour: float = 0.3  # and up to this relative distance
    across: tuple[float, float, int] = (1e-5, 0.3, 40)  # relative distances beyond an edge, for the same
    kept: int = 24  # points of each of both that are kept for a pattern
    wide: float = 0.6  # half an interval over its estimate, at most: 30 % of standard error
    at_bound: float = 1e-3  # relative distance from a bound of the search at which an interval has no end
    close: float = 0.03  # of the threshold: error of the misfit at an end of an interval
    narrow: float = 0.02  # of the distance to the estimate: error of an end at an edge of a pattern
    first_step: float = 0.02  # relative, to the end of an interval, if the derivatives give none,
    most_step: float = 0.5  # and the greatest if they give one
    tries: int = 24  # points that are tried for one end
    apart: float = 0.02  # of the hull: intervals closer to each other are united
    unknown: float = 0.3  # relative standard error above which a combination is unknown
    group_share: float = 0.05  # of an unknown combination: a quantity with less is not part of it
    at_limit: float = 1e-4  # of the range that is tried: distance of an estimate at its limit


TOL: Final = _Tolerances()


# ------------------------------------------------------------------------------
# Signals of a record: their names, their units as programs spell them, the sensitivities of voltages.

#: Kind of a unit, a key of ``SIGNAL_UNITS``, and its size in SI units.
_Unit = tuple[str, float]
#: Signals of the body that a record may hold; each name but friction's is also the kind of its unit.
_SIGNALS: Final = ("displacement", "velocity", "acceleration", "friction")
#: Motions of the trough that it may hold: along the trough's surface, normal to it, and across both.
_TROUGH: Final = ("trough_along", "trough_normal", "trough_across")
#: Kinds of unit that a motion of the trough may have, with the derivatives from each to the acceleration.
DERIVATIVES: Final[Mapping[str, int]] = {"acceleration": 0, "velocity": 1, "displacement": 2}
#: Kind of unit of each column; of the trough's the usual one.
_KINDS: Final[Mapping[str, str]] = {r: r for r in ("time", *_SIGNALS)} | {
    "friction": "force",
    **dict.fromkeys(_TROUGH, "acceleration"),
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


def signal_unit(text: str) -> _Unit | None:
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


def _kinds_of(role: str) -> tuple[str, ...]:
    """Return the kinds of unit that a column may have, the usual one first."""
    return tuple(DERIVATIVES) if role in _TROUGH else (_KINDS[role],)


def _a(kind: str) -> str:
    return f"{'an' if kind[0] in 'aeiou' else 'a'} {kind}"


#: A usual sensitivity for each kind of signal.
_EXAMPLES: Final[Mapping[str, str]] = {
    "displacement": "2V/mm",
    "velocity": "20mV/mm/s",
    "acceleration": "100mV/g",
    "force": "50mV/N",
}


class _Sensitivity(NamedTuple):
    """Sensitivity of a sensor whose voltage is in a record.

    Attributes
    ----------
    text : str
        The sensitivity as typed.
    role : str
        Column that it is for, a key of ``_KINDS``; empty for every voltage of its kind.
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
        return self.role == role if self.role else self.kind == _KINDS[role]


# Possessive quantifiers: the time for a text is proportional to its length, not to the square of it.
_NUMBER: Final = r"[+-]?+(?:(?:[0-9]++\.?+[0-9]*+|\.[0-9]++)(?:[eE][+-]?+[0-9]++)?+|(?i:nan|inf))"
_SENSITIVITY: Final = re.compile(rf"({_NUMBER})\s*+([^\W\d].*|\(.*)")
_HINT: Final = f"write it like {', '.join(_EXAMPLES.values())} or 125mm/s/V"


def read_sensitivities(texts: Sequence[str]) -> tuple[_Sensitivity, ...]:
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
    found: list[_Sensitivity] = []
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


def _sensitivity(text: str) -> _Sensitivity:
    name, equals, value = text.rpartition("=")
    role = name.strip().removeprefix("--").replace("-", "_").casefold()
    given = _given(text)
    if equals and (role not in _KINDS or role == "time"):
        known = ", ".join(r.replace("_", "-") for r in _KINDS if r != "time")
        raise InputError(f"{given}: {shown(name.strip())} is no signal", hint=f"signals are {known}")
    value = value.strip()
    match = _SENSITIVITY.fullmatch(value)
    if match is None:
        raise InputError(f"{given}: not a number, with a decimal point, and a unit", hint=_HINT)
    number, unit_text = float(match[1]), match[2].strip()
    unit = _unit(unit_text)
    if unit is None:
        raise InputError(f"{given}: {shown(unit_text)} is no unit of a sensitivity", hint=_HINT)
    kind, size, inverse = unit
    if role and kind not in _kinds_of(role):
        other = f"{given}: {shown(unit_text)} is no sensitivity of {_a(' or '.join(_kinds_of(role)))}"
        raise InputError(other, hint=f"write it like {_EXAMPLES[_KINDS[role]]}")
    if number == 0.0 or not math.isfinite(number):
        raise InputError(f"{given}: must be finite and not 0", hint=_HINT)
    per_volt = number * size if inverse else size / number
    if not 1.0 / TOL.largest <= abs(per_volt) <= TOL.largest:
        raise InputError(f"{given}: 1 V would be {per_volt:g} in SI units, which is beyond any sensor")
    return _Sensitivity(text.strip(), role, kind, per_volt)


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
    if of_volt is None or of_volt[0] != "voltage" or of_signal is None or of_signal[0] not in _EXAMPLES:
        return None
    return of_signal[0], of_signal[1] / of_volt[1], inverse


# ------------------------------------------------------------------------------
# Find the columns of a table that hold the signals, by their units or by the names that a user gives.

# Words in a header that decide between columns whose units are of the same kind.
_WORDS: Final = {
    role: re.compile(rf"(?:{words})(?:[\W_\d].*)?", re.IGNORECASE)
    for role, words in (
        ("time", r"time|zeit|t"),
        ("displacement", r"displacement|position|weg|relative.*|x|xi|s"),
        ("velocity", r"velocity|speed|geschwindigkeit|relative.*|v|vx"),
        ("acceleration", r"acceleration|beschleunigung|relative.*|a|ax"),
        ("friction", r"friction|friction force|reibkraft|f"),
    )
}
_BRACKETS: Final = re.compile(r"(.*?)\s*[\[(](?:in\s+)?([^\])]*)[\])]\s*")
_IN: Final = re.compile(r"(.*\S)\s+(?:in|/)\s+(\S.*)", re.IGNORECASE)  # Zeit in s, or Zeit / s
_OVER: Final = re.compile(r"([^/]*[^/\s])\s*/\s*(\S.*)")  # Zeit/s, v/mm/s


class _Header(NamedTuple):
    """Header of a column: its place, text and names, and the kind and size of its unit."""

    place: int
    text: str
    names: tuple[str, ...]
    stated: str
    unit: _Unit | None

    @property
    def name(self) -> str:
        """Its name, without the unit."""
        return self.names[0]


class _Wanted(NamedTuple):
    """Columns that a user names: headers by the keys of ``_KINDS``, and the sensitivities of voltages.

    Signals of the body are needed unless ``body`` is false: then motions of the trough are. A sampling rate
    stands for a column of time.
    """

    headers: Mapping[str, str]
    sensitivities: Sequence[_Sensitivity] = ()
    body: bool = True
    rate: float | None = None


class _Column(NamedTuple):
    """Column of a signal: its header, kind and size of its unit in SI units, sensitivity of a voltage.

    ``typed`` is its unit, if the user gave it.
    """

    header: _Header
    kind: str
    size: float
    sensitivity: _Sensitivity | None = None
    typed: str = ""


#: Columns by the keys of ``_KINDS``.
_Columns = dict[str, _Column]

_NAME_ONE: Final = (
    f"name one, with its unit: {argument('displacement', 'X [mm]')}; a voltage with its sensitivity:"
    f" {argument('acceleration', 'a [mV]')} {argument('sensitivity', _EXAMPLES['acceleration'])}"
)
_NAME_THE_TROUGH: Final = (
    "name one or both, with the unit:"
    f" {argument('trough_along', 'ax [m/s^2]')} {argument('trough_normal', 'ay [m/s^2]')}"
)


def _headers(table: Table) -> list[_Header]:
    """Take the names and units of the columns apart."""
    headers = []
    for place, texts in enumerate(zip(table.names, *table.also, strict=True)):
        unit = table.units[place] if table.units else ""
        split = [_split(text) for text in texts]
        stated = unit or split[0][1]
        text = f"{texts[0]} [{unit}]" if unit else texts[0]
        names = tuple(dict.fromkeys([*(name for name, _ in split), *texts]))
        size = signal_unit(stated) if stated else _unit_at_end(split[0][0])
        headers.append(_Header(place, text, names, stated, size))
    return headers


def _split(text: str) -> tuple[str, str]:
    """Split ``X [mm]``, ``X in mm`` or ``X/mm`` into name and unit."""
    if match := _BRACKETS.fullmatch(text):
        name = match[1].removesuffix("/")
        if name == match[1]:
            return name, match[2].strip()
        parts = name.rstrip(), match[2].strip()
        return parts if signal_unit(parts[1]) is None or _is_quotient(*parts) else (text, "")
    if signal_unit(text):  # m / s is a unit
        return text, ""
    if (match := _IN.fullmatch(text)) and signal_unit(match[2].strip()):
        return match[1], match[2].strip()
    match = _OVER.fullmatch(text)
    return (match[1], match[2].strip()) if match and _is_quotient(match[1], match[2].strip()) else (text, "")


def _is_quotient(name: str, unit_text: str) -> bool:
    """Whether a text is the name of a signal over its unit, as ``s/mm``, unlike ``N/mm`` and ``Weg/s``."""
    unit = signal_unit(unit_text)
    if unit is None:
        return False
    kinds = [_KINDS[role] for role, word in _WORDS.items() if word.fullmatch(name)]
    return unit[0] in (*kinds, "voltage") if kinds else signal_unit(name) is None


def _unit_at_end(name: str) -> _Unit | None:
    """Return the unit at the end of a name in vibro's own tables, such as ``velocity_mm_s``."""
    words = name.split("_")
    for count in (2, 1):
        if len(words) > count and (unit := signal_unit("_".join(words[-count:]))):
            return unit
    return None


def _columns_of(table: Table, wanted: _Wanted) -> _Columns:
    """Find the columns of the signals.

    Parameters
    ----------
    table : Table
        Their table; names and units are read.
    wanted : Wanted
        Columns that a user names. If no signal of the body is among them, every other column whose unit is
        unambiguous is taken too. Voltages and motions of the trough must be named, and so must a signal of
        the body that has the kind of one of the trough: it may as well be another one of the trough.

    Raises
    ------
    InputError
        If a column is missing, ambiguous, without a unit, or named twice; if a voltage lacks a sensitivity,
        or a sensitivity a voltage.
    """
    path, headers = table.path, _headers(table)
    problems, hints, found = list[str](), list[str](), _Columns()
    # A user who names one signal wants no others; the time is always needed.
    named_one = any(role in wanted.headers for role in _SIGNALS)
    clock = () if wanted.rate or table.step is not None else ("time",)
    sought = clock if named_one or not wanted.body else (*clock, *_SIGNALS)
    named = [role for role in _KINDS if role in wanted.headers]
    for role in dict.fromkeys([*named, *sought]):
        try:
            if role in wanted.headers:
                found[role] = _named(path, headers, role, wanted)
            else:
                taken = {column.header.place for column in found.values()}
                if _KINDS[role] not in {found[name].kind for name in _TROUGH if name in found}:
                    found |= _detected(path, [h for h in headers if h.place not in taken], role)
        except InputError as exc:
            if role in _SIGNALS and role not in wanted.headers and not found.keys().isdisjoint(_TROUGH):
                continue  # the trough alone is measured too
            problems += exc.raw[0]
            hints += [exc.raw[1]]
    if not problems and clock and "time" not in found:
        problems.append(f"{path}: no column of time found among {_list(headers)}")
        rate = f"or give the sampling rate: {argument('rate', '1000')}"
        hints.append(f"name it, with its unit: {argument('time', 't [s]')}; {rate}")
    if not problems and found.keys().isdisjoint((*_SIGNALS, *_TROUGH) if wanted.body else _TROUGH):
        what = "signal found" if wanted.body else "motion of the trough named"
        problems.append(f"{path}: no {what} among {_list(headers)}")
        hints.append(_NAME_ONE if wanted.body else _NAME_THE_TROUGH)
    if problems:
        raise InputError(*problems, hint="\n".join(dict.fromkeys(filter(None, hints))))
    _check_use(path, found, wanted)
    return {role: found[role] for role in _KINDS if role in found}


def _check_use(path: Path, columns: _Columns, wanted: _Wanted) -> None:
    """Refuse a column that is given as two signals, and a sensitivity that no voltage uses."""
    for column in columns.values():
        same = [role for role, other in columns.items() if other.header == column.header]
        if len(same) > 1:
            names = " and as ".join(role.replace("_", " ") for role in same)
            raise InputError(f"{path}: column {shown(column.header.text)} is given as {names}")
    used = [column.sensitivity for column in columns.values()]
    for sensitivity in wanted.sensitivities:
        if sensitivity not in used:
            role = sensitivity.role or next(name for name in _SIGNALS if _KINDS[name] == sensitivity.kind)
            none = f"{path}: no column that is read as {role.replace('_', ' ')} is a voltage for"
            hint = f"name the column, {argument(role, 'HEADER')}, or leave the sensitivity out"
            raise InputError(f"{none} {argument('sensitivity', sensitivity.text)}", hint=hint)


def _named(path: Path, headers: list[_Header], role: str, wanted: _Wanted) -> _Column:
    """Find the column that a user names; its unit is the one in its header, or else in the user's name."""
    key = wanted.headers[role].strip()
    name, unit_text = _split(key)
    found = (
        [h for h in headers if h.text == key]
        or [h for h in headers if h.text.casefold() == key.casefold()]
        or [h for h in headers if name.casefold() in map(str.casefold, h.names)]
        or [h for h in headers if name == str(h.place + 1)]
    )
    kind = _KINDS[role]
    if not found:
        hint = did_you_mean(key, (h.text for h in headers)) or "write it as the header row does"
        missing = f"{path}: no column {shown(key)} for {role}; its columns are {_list(headers)}"
        raise InputError(missing, hint=hint)
    if len(found) > 1:
        several = f"{path}: {len(found)} columns are called {shown(key)}"
        number = argument(role, f"{found[0].place + 1}{f' [{unit_text}]' if unit_text else ''}")
        raise InputError(several, hint=f"give the number of the one that is meant: {number}")
    (header,) = found
    typed = unit_text if key.casefold() != header.text.casefold() else ""
    unit = signal_unit(typed) if typed else header.unit
    if unit is not None and unit[0] in _kinds_of(role):
        return _Column(header, *unit, typed=typed)
    column, example = f"{path}: column {shown(header.text)} for {role}", _EXAMPLES.get(kind)
    if unit is not None and unit[0] == "voltage" and example:
        serving = [sensitivity for sensitivity in wanted.sensitivities if sensitivity.serves(role)]
        if serving:
            # A sensitivity of this column has priority over one of its kind.
            sensitivity = max(serving, key=lambda sensitivity: bool(sensitivity.role))
            return _Column(header, sensitivity.kind, unit[1] * sensitivity.per_volt, sensitivity, typed)
        own = argument("sensitivity", f"{role.replace('_', '-')}={example}")
        missing = f"{column}: the sensitivity of its sensor is missing"
        raise InputError(missing, hint=f"give a sensitivity of {_a(kind)}: {own}")
    stated, kinds = typed or header.stated, " or ".join(_kinds_of(role))
    problem = f"{shown(stated)} is no unit of {kinds}" if stated else "it has no unit"
    usual, units = next(iter(SIGNAL_UNITS[kind])), ", ".join(SIGNAL_UNITS[kind])
    named = argument(role, f"{header.name} [{usual}]")
    hint = f"write the unit in brackets: {named}; units of {kind} are {units}"
    voltage = f", or mV and V with {argument('sensitivity', example)}" if example else ""
    raise InputError(f"{column}: {problem}", hint=hint + voltage)


def _detected(path: Path, headers: list[_Header], role: str) -> _Columns:
    """Find the column whose unit fits, among several the one whose name fits; empty if there is none."""
    fitting = [_Column(h, *h.unit) for h in headers if h.unit and h.unit[0] == _KINDS[role]]
    if len(fitting) > 1:
        fitting = [column for column in fitting if _WORDS[role].fullmatch(column.header.name)] or fitting
    if len(fitting) > 1:
        several = f"{path}: {_list([column.header for column in fitting])} could each be the {role}"
        first = fitting[0].header.text
        own = f" of a part, {argument('trough_along', first)} of the trough" if role in DERIVATIVES else ""
        raise InputError(several, hint=f"choose: {argument(role, first)}{own}")
    return {role: fitting[0]} if fitting else {}


def _list(headers: Sequence[_Header]) -> str:
    texts = [shown(h.text) for h in headers if h.text]
    more = len(texts) - TOL.headers_named
    return ", ".join(texts[: TOL.headers_named]) + (f" and {more} more" if more > 0 else "")


_Flags = NDArray[np.bool_]

# Possessive quantifiers: the time for a cell is proportional to its length.
_DECIMAL: Final = re.compile(r"[+-]?+(?:[0-9]++[.,]?+[0-9]*+|[.,][0-9]++)(?:[eE][+-]?+[0-9]++)?+")
# What programs write instead of a number: without a value, and after an error.
_NO_VALUE: Final = re.compile(r"[+-]?nan|#?n/?a|null|none|[-?*]+", re.IGNORECASE)
_WRONG: Final = re.compile(r"[+-]?inf(inity)?|error|overflow|#.*", re.IGNORECASE)
_SEPARATORS: Final = {";": "semicolon", "\t": "tab", ",": "comma"}
_DELETE: Final = "delete those rows, or keep the part before or after them"


@dataclass(frozen=True, eq=False)
class Record:
    """Signals over time, in SI units.

    Attributes
    ----------
    time : float array
        Strictly ascending [s].
    signals : mapping of str to float array
        Relative displacement [m], velocity [m/s], acceleration [m/s^2] and friction [N] at these times, by
        their names in ``_SIGNALS``.
    trough : mapping of str to float array
        Motions of the trough [m/s^2, m/s or m] at these times, by their names in ``_TROUGH``.
    headers : mapping of str to str
        The columns' headers in the file, by the same names and ``"time"``, unless a rate gives the time.
    sensitivities : mapping of str to str
        Sensitivities of the columns that are voltages, as typed, by the same names.
    trough_kinds : mapping of str to str
        What each motion of the trough is, a key of ``DERIVATIVES``; without one an acceleration.
    notes : tuple of str
        How the file was read, for the user.
    believed : frozenset of str
        Names, ``"time"`` among them, of columns whose unit was typed: ``2 [g]``, ``ax [g]``; not if the text
        is the header as it stands in the file. Their values are right, however absurd they look.
    """

    time: Floats
    signals: Mapping[str, Floats]
    trough: Mapping[str, Floats]
    headers: Mapping[str, str]
    sensitivities: Mapping[str, str] = field(default_factory=dict)
    notes: tuple[str, ...] = ()
    trough_kinds: Mapping[str, str] = field(default_factory=dict)
    believed: frozenset[str] = frozenset()

    @property
    def trough_derivatives(self) -> dict[str, int]:
        """Derivatives over time from each motion of the trough, as recorded, to its acceleration."""
        return {name: DERIVATIVES[self.trough_kinds.get(name, "acceleration")] for name in self.trough}


@dataclass(frozen=True, eq=False)
class Table:
    """Columns of a file of any format, from which ``record_of`` takes the signals that are wanted.

    A reader of a format returns one: ``Table(path, names, columns, units, step=1e-3)`` is all that a format
    with channels, units and a sampling step has to give. Which column is which signal, sensitivities, rows
    without a value and the clock are the business of ``record_of``.

    Attributes
    ----------
    path : Path
        The file, for messages.
    names : sequence of str
        Name of each column, which may hold its unit: ``Acc along`` or ``Acc along [g]``; all empty if the
        file has none. Messages list them, and users choose by them, or by their numbers, from 1.
    columns : sequence of array
        Values of each column, as long as one another: floats, NaN where there is no value; whole numbers, as
        of a clock of nanoseconds; or cells as text, if one of them is no number.
    units : sequence of str
        Unit of each column as the file spells it; empty for one without, whose name may hold it then.
    rows : sequence of int
        Number of each row in the file, for messages; from 1 if it is left out.
    also : sequence of sequence of str
        More names of the columns, such as a row of descriptions; users may choose by them too.
    notes : sequence of str
        How the file was read, for the user.
    step : float or None
        Time between two rows [s], of a file without a column of time.
    """

    path: Path
    names: Sequence[str]
    columns: Sequence[NDArray[Any]]
    units: Sequence[str] = ()
    rows: Sequence[int] = ()
    also: Sequence[Sequence[str]] = ()
    notes: Sequence[str] = ()
    step: float | None = None

    def row(self, index: int) -> int:
        """Return the number in the file of a row."""
        return int(self.rows[index]) if len(self.rows) else index + 1

    def numbers(self, header: _Header, unit: float) -> Floats:
        """Read a column in SI units; NaN for cells without a value."""
        cells = self.columns[header.place]
        values, bad = np.full(cells.size, np.nan), np.zeros(cells.size, np.bool_)
        if cells.dtype != object:
            values = np.asarray(cells * unit, np.float64)
            bad = np.abs(values) > TOL.largest
        else:
            for i, cell in enumerate(cells):
                if _DECIMAL.fullmatch(cell):
                    values[i] = float(cell.replace(",", ".")) * unit
                    bad[i] = not abs(values[i]) <= TOL.largest
                else:
                    bad[i] = bool(cell) and not _NO_VALUE.fullmatch(cell)
        if bad.any():
            raise InputError(*self.named(header, bad, values, TOL.largest / abs(unit)), hint=_DELETE)
        return values

    def named(self, header: _Header, bad: _Flags, values: Floats, most: float = math.nan) -> list[str]:
        """Describe the first bad cells of a column, and count the others; one with a value is too large."""
        problems, places, column = [], np.flatnonzero(bad).tolist(), f"column {shown(header.text)}"
        for i in places[: TOL.cells_named]:
            cell = str(self.columns[header.place][i])
            what = f"{shown(cell)} is not a number" if cell else "the cell is empty"
            if not math.isnan(values[i]):
                what = f"{cut(cell)} is too large to compute with, at most {most:g} is allowed"
            problems.append(f"{self.path}: row {self.row(i)}, {column}: {what}")
        if (more := len(places) - TOL.cells_named) > 0:
            problems.append(f"{self.path}: {column}: {more} more such cell{'s' if more > 1 else ''}")
        return problems


def read_record(
    path: Path,
    columns: Mapping[str, str] | None = None,
    sensitivities: Sequence[_Sensitivity] = (),
    *,
    body: bool = True,
    rate: float | str | None = None,
) -> Record:
    """Read a record from a file.

    Parameters
    ----------
    path : Path
        CSV with a header row; separated by commas, semicolons or tabs, with decimal points or commas,
        in UTF-8 (with or without a byte order mark), UTF-16 or a Windows code page; or LabVIEW's text, TDMS,
        UFF58, MAT or WAV.
    columns : mapping of str to str, optional
        Headers by ``"time"`` and the names of ``_SIGNALS`` and ``_TROUGH``; or the columns' numbers, from 1.
        The unit of the header, in brackets, may be left out; one that is given goes before the file's. If no
        signal of the body is named, every column whose unit is unambiguous is read.
    sensitivities : sequence of Sensitivity
        Sensitivities of the sensors whose voltages the file holds.
    body : bool
        Whether a signal of the body is needed; else a motion of the trough is.
    rate : float or str, optional
        Sampling rate in place of a column of time: in Hz, or with its unit.

    Returns
    -------
    Record
        The columns in SI units, without the few rows in which a cell of them holds no value.

    Raises
    ------
    FileError
        If the file cannot be read.
    InputError
        If a column is missing, ambiguous or without a unit; if a cell is no number, or too many are empty; if
        the time has gaps, repeats or goes back. Row and column are named.
    """
    channels, wanted = read_channels(path), _Wanted(columns or {}, sensitivities, body)
    table = Table(path, **channels._asdict()) if channels else _read_table(path, wanted)
    return record_of(table, columns, sensitivities, body=body, rate=rate)


def record_of(
    table: Table,
    columns: Mapping[str, str] | None = None,
    sensitivities: Sequence[_Sensitivity] = (),
    *,
    body: bool = True,
    rate: float | str | None = None,
) -> Record:
    """Take the wanted signals from a table; parameters, result and errors are those of ``read_record``."""
    hertz = None if rate is None else checked_number(str(rate), RATE)
    wanted = _Wanted(columns or {}, sensitivities, body, hertz)
    if hertz is not None and "time" in wanted.headers:
        both = f"{argument('time')} and {argument('rate')} are both given"
        raise InputError(both, hint="leave one of them out")
    chosen = _columns_of(table, wanted)
    notes = [*table.notes]
    values: dict[str, Floats] = {
        role: table.numbers(column.header, column.size) for role, column in chosen.items()
    }
    if not values.keys().isdisjoint(_TROUGH):  # a part that nobody named is not worth a record of the trough
        unnamed = [role for role in values if role in _SIGNALS and role not in wanted.headers]
        for role in unnamed:
            if np.isnan(values[role]).mean() > TOL.skipped:
                notes.append(
                    f"{role}: column {shown(chosen.pop(role).header.text)} lacks values: it is left out"
                )
                del values[role]
    kept = _with_values(table, {chosen[role].header: column for role, column in values.items()})
    step = 1.0 / wanted.rate if wanted.rate else table.step
    if "time" not in values and step is not None:
        values["time"] = np.arange(kept.size, dtype=np.float64) * step
        notes.append(f"time: {1.0 / step:g} rows a second")
    values = {role: column[kept] for role, column in values.items()}
    if "time" in chosen:
        _check_time(table, chosen["time"].header, values["time"], np.flatnonzero(kept))
    if not kept.all():
        rows = [str(table.row(i)) for i in np.flatnonzero(~kept).tolist()]
        named = ", ".join([*rows[: TOL.cells_named], *(["..."] if len(rows) > TOL.cells_named else [])])
        skipped = f"skipped rows without a value: {named} ({len(rows)} of {kept.size})"
        notes.append(f"{table.path.name}: {skipped}")
    texts = {role: column.sensitivity.text for role, column in chosen.items() if column.sensitivity}
    headers = {role: column.header.text for role, column in chosen.items()}
    for role, header in headers.items():
        at = f" at {texts[role]}" if role in texts else ""
        unit = f" in {chosen[role].typed}" if chosen[role].typed else ""
        notes.append(f"{role.replace('_', ' ')}: column {shown(header)}{unit}{at}")
    kinds = {role: column.kind for role, column in chosen.items() if role in _TROUGH}
    signals = {role: x for role, x in values.items() if role in _SIGNALS}
    trough = {role: x for role, x in values.items() if role in _TROUGH}
    believed = frozenset(role for role, column in chosen.items() if column.typed)
    return Record(values["time"], signals, trough, headers, texts, tuple(notes), kinds, believed)


def _first_data(rows: Sequence[tuple[int, list[str]]]) -> int | None:
    """Return the index of the first row with at least as many numbers as most rows have."""
    looked_at = [cells for _, cells in rows[: TOL.looked_at]]
    counts = [sum(_DECIMAL.fullmatch(cell) is not None for cell in cells) for cells in looked_at]
    usual = Counter(count for count in counts if count > 1).most_common(1)
    return next((i for i, count in enumerate(counts) if count >= usual[0][0]), None) if usual else None


def _read_table(path: Path, wanted: _Wanted) -> Table:
    """Find separator, decimals and header row."""
    text, notes = read_text(path)
    if text.startswith("LabVIEW Measurement"):
        text, left_out = lvm_table(path, text)
        notes += left_out
    for separator in _SEPARATORS:
        rows = rows_of(path, text, separator)
        first = _first_data(rows)
        if first is not None:
            break
    else:
        hint = "it needs a header row and rows of numbers, separated by commas, semicolons or tabs"
        raise InputError(f"{path}: no table of numbers found", hint=hint)
    if first == 0:
        bare = f"{path}: row {rows[0][0]} holds numbers, but there is no header row above it"
        raise InputError(bare, hint="name the columns in a first row, with units: Time [s],X [mm]")
    place, names, units = _header_row(path, [cells for _, cells in rows[:first]], wanted)
    width, data = len(rows[place][1]), rows[place + 1 :]
    comma = any("," in cell for _, cells in data[: TOL.looked_at] for cell in cells)
    for row, cells in data:
        if any(cells[width:]):
            wide = f"{path}: row {row} has {len(cells)} cells, the header row {width}"
            raise InputError(wide, hint="decimal commas need semicolons between the cells")
        cells += [""] * (width - len(cells))
    columns = [np.array([cells[i] for _, cells in data], object) for i in range(width)]
    if separator != "," or comma:
        decimals = ", decimal commas" if comma else ""
        notes.append(f"{path.name}: separated by {_SEPARATORS[separator]}s{decimals}")
    return Table(path, names, columns, units, [row for row, _ in data], notes=notes)


def _header_row(path: Path, above: list[list[str]], wanted: _Wanted) -> tuple[int, list[str], list[str]]:
    """Find the row that names the columns, above the first row of numbers; return names and units too.

    The lowest row may be data with a bad cell. It is no header if it does not name the columns, and holds a
    number or a text instead of one: try the row above it.
    """
    *higher, names = above
    units = [text.strip("[]()") for text in names]
    if higher and len(higher[-1]) == len(units) and all(signal_unit(unit) for unit in units if unit):
        names = higher[-1]
    else:
        units = [""] * len(names)
    try:
        _columns_of(Table(path, names, (), units), wanted)
    except InputError:
        patterns = (_DECIMAL, _NO_VALUE, _WRONG)
        if higher and any(p.fullmatch(cell) for cell in above[-1] for p in patterns):
            return _header_row(path, higher, wanted)
    return len(higher), names, units


def _with_values(table: Table, columns: Mapping[_Header, Floats]) -> _Flags:
    """Return which rows hold a value in every column; refuse a table in which too many do not."""
    kept = np.asarray(~np.isnan(list(columns.values())).any(axis=0))
    count = int(np.count_nonzero(~kept))
    if count > TOL.skipped * kept.size:
        named = [t for header, x in columns.items() for t in table.named(header, np.isnan(x), x)]
        limit = f"at most {100.0 * TOL.skipped:.0f} % are skipped"
        lost = f"{table.path}: {count} of {kept.size} rows lack a value: {limit}"
        raise InputError(*named, lost, hint=_DELETE)
    return kept


def _check_time(table: Table, header: _Header, time: Floats, kept: NDArray[np.intp]) -> None:
    """Refuse a time that repeats, goes back or jumps; ``kept`` holds the places of its rows in the table."""
    steps = np.diff(time)
    usual = float(np.median(steps)) if steps.size else 0.0
    for bad, what, hint in (
        (steps < 0.0, "goes back to", "sort the rows by time, or keep one of the runs"),
        (steps == 0.0, "repeats", "keep one row for each time, or export more digits"),
        (steps > TOL.gap * usual, "jumps to", "fill the gap, or keep the part before or after it"),
    ):
        places = np.flatnonzero(bad)
        if places.size:
            i = int(places[0]) + 1
            row = f"{table.path}: row {table.row(int(kept[i]))}, column {shown(header.text)}"
            moves = f"time {what} {time[i]:.9g} s after {time[i - 1]:.9g} s, usual steps are {usual:.3g} s"
            lost = int(kept[i] - kept[i - 1]) - 1
            between = f"; rows without a value before it: {lost}" if lost else ""
            more = f"; such rows in all: {places.size}" if places.size > 1 else ""
            raise InputError(f"{row}: {moves}{between}{more}", hint=hint)
