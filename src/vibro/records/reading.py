"""Measured records: which columns of a file are which signals, in SI units over a clock without faults."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from vibro.errors import InputError, argument, cut, did_you_mean, shown
from vibro.quantities import RATE, checked_number
from vibro.records import clocks
from vibro.records.channels import (
    AXES,
    CELLS_NAMED,
    DECIMAL,
    DELETE,
    DERIVATIVES,
    KINDS,
    LARGEST,
    SIGNALS,
    TROUGH,
    WORDS,
    Flags,
    Header,
    Table,
    Unit,
    headers_of,
    kinds_of,
    split_header,
)
from vibro.records.channels import SIGNAL_UNITS as SIGNAL_UNITS
from vibro.records.channels import signal_unit as signal_unit
from vibro.records.formats import read_channels
from vibro.records.texts import text_table
from vibro.units import STANDARD_GRAVITY

if TYPE_CHECKING:
    from vibro.reals import Floats

# ------------------------------------------------------------------------------
# Limits, steps and thresholds of the analysis of records, each with its unit and reason.


class _Tolerances(NamedTuple):
    """Limits, steps and thresholds; shares or factors if no unit is given."""

    # --- reading --------------------------------------------------------------------------------------
    # Largest value in a record, or in a scene that is compared with one [SI]; the smallest in a scene is its
    # inverse. Fourth powers are summed over the rows and must stay far below the largest double.
    largest: float = LARGEST
    # Ratio of measured and computed size, either way, from which a unit is doubted: less than 10, as a
    # sensitivity may be wrong by 10 and the motion a little smaller than computed.
    far_off: float = 7.0
    far_angle: float = float(np.radians(20.0))  # [rad] from the scene's drive angle: sensors may be exchanged
    gap: float = 3.5  # usual steps of the time in one step: two missing rows and the rounding of times
    even: float = 0.5  # of the usual step: largest deviation of a step of a slower column
    fewest_values: int = 4  # of a column that is sampled more slowly than others
    skipped: float = 0.05  # largest share of rows without a value
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
    coarsest: float = 2.1  # samples in a cycle of the largest wave
    # Of a frequency that is stated: induction motors slip by up to 7 % and follow the mains within 1 %; the
    # next machine usually is farther away.
    near_stated: float = 0.1
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

    most_acceleration: float = 50.0 * STANDARD_GRAVITY  # [m/s^2] of a trough: more is refused,
    most_speed: float = 10.0  # [m/s] as are a faster one
    most_amplitude: float = 0.1  # [m] and one that moves farther
    near_gravity: float = 0.03  # of gravity: distance of a mean that is taken for gravity in another unit,
    most_beside_gravity: float = 20.0 * STANDARD_GRAVITY  # [m/s^2] unless the motion would be larger
    lowest_frequency: float = 0.5  # [Hz] below it, or above the next, the time has the wrong unit
    most_frequency: float = 1000.0  # [Hz]
    usual_frequency: float = 1.0  # [Hz] up to the one before: where the unit of the time is sought
    slow_drive: float = 5.0  # [Hz] hardly a drive is slower: a lower frequency may be another one's
    slowest_rate: float = 5.0  # [Hz] nobody samples vibration more slowly: the unit of the time is wrong
    hides_drives: float = 250.0  # [Hz] a lower sampling rate is told with the drives that look the same,
    highest_drive: float = 200.0  # [Hz] up to this frequency,
    drives_named: int = 4  # of them so many

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

    # --- steady running -------------------------------------------------------------------------------
    steady_windows: int = 24  # at most, in which amplitude and phase are told,
    window_cycles: float = 4.0  # of so many cycles at least
    near_offset: float = 0.1  # of the frequency: a second wave within it beats with the first,
    least_beats: float = 1.5  # so often at least in the record,
    beat_share: float = 0.7  # and with so much of the power of all departures
    # Relative swing of the amplitude, and of the phase [rad], up to which the mean is taken, with an error.
    # A frequency that changes steadily then takes 1 % off the amplitude.
    steady_amplitude: float = 0.1
    steady_phase: float = 0.45
    seen_change: float = 0.005  # relative: less is not warned of
    monotonic: float = 0.7  # of a swing, that the amplitude rises or falls from the first to the last window
    courses: tuple[int, ...] = (24, 12, 6)  # parts of a record in which a frequency is sought that changes,
    least_course: int = 24  # of so many rows at least
    folded_harmonics: int = 8  # that may be shown beside the first one, where samples are few
    standing: float = 0.3  # of the largest amplitude: with less a phase is not known
    least_windows: int = 5  # of a part that is steady where the record is not,
    least_part: float = 0.2  # and its share of the record
    much_less: float = 0.3  # of the change of the whole record, at the same pace

    harmonics_matter: float = 1e-3  # of the speed: a smaller change by harmonics is left out of a comparison
    draws: int = 200  # of the noise: their standard deviation is known to 5 %

    # --- comparison -----------------------------------------------------------------------------------
    slide_level: float = 0.1  # of a slide's computed peak speed, at its start and end
    fine: int = 4096  # points a cycle at which folded signals are searched
    curve: int = 1001  # points of a smooth curve
    clocks_apart: float = 0.02  # [cycles] least difference of the clocks of trough and body to warn of
    proposed: float = 0.01  # [cycles] drift of a proposed frequency from the data over the record

    # --- residuals of a fit ---------------------------------------------------------------------------
    filtered: int = 1024  # points a cycle at which the model passes through a filter
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

    misfit_by_chance: float = 1e-5  # probability by which noise passes for a misfit that repeats
    farthest_error: float = 8.0  # standard errors of a drive that are tried

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


def doubt(sensitivity: str) -> str:
    """Question the sensitivity of a signal of the wrong size, or its unit if it has no sensitivity."""
    return f"is its sensitivity {sensitivity} right?" if sensitivity else "is its unit right?"


def rounded(ratio: float) -> str:
    """Write a ratio to two digits, such as 1000, not 1e+03."""
    return f"{float(f'{ratio:.2g}'):g}"


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


# Possessive quantifiers: the time for a text is proportional to its length, not to the square of it.
_SENSITIVITY: Final = re.compile(
    r"([+-]?+(?:[0-9]++\.?+[0-9]*+|\.[0-9]++)(?:[eE][+-]?+[0-9]++)?+)\s*+([^\W\d].*|\(.*)"
)
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
        If one is no sensitivity, is 0 or beyond 1e-20 to 1e20 in SI units; or if two apply to the same column
        or kind.
    """
    found = dict[str, _Sensitivity]()
    for one in map(_sensitivity, texts):
        served = one.role or _a(one.kind)
        if served in found:
            both = f"{_given(found[served].text)} and {_given(one.text)}: each is for {served}"
            hint = f"say which column each is for: {_given('trough-along=100mV/g')}"
            raise InputError(both, hint=hint)
        found[served] = one
    return tuple(found.values())


def _given(text: str) -> str:
    """Write a sensitivity as it is given."""
    return argument("sensitivity", cut(text))


def _sensitivity(text: str) -> _Sensitivity:
    name, equals, value = text.rpartition("=")
    role = name.strip().removeprefix("--").replace("-", "_").casefold()
    given = _given(text)
    if equals and (role not in KINDS or role == "time"):
        known = ", ".join(r.replace("_", "-") for r in KINDS if r not in ("time", *AXES))
        raise InputError(f"{given}: {shown(name.strip())} is no signal", hint=f"signals are {known}")
    match = _SENSITIVITY.fullmatch(value.strip())
    unit = _unit(match[2]) if match else None
    if match is None or unit is None:
        neither = f"{given}: not a number, with a decimal point, and a unit of a sensitivity"
        raise InputError(neither, hint=_HINT)
    (kind, size, inverse), number = unit, float(match[1])
    if role and kind not in kinds_of(role):
        other = f"{given}: {shown(match[2])} is no sensitivity of {_a(' or '.join(kinds_of(role)))}"
        raise InputError(other, hint=f"write it like {_EXAMPLES[KINDS[role]]}")
    if number == 0.0:
        raise InputError(f"{given}: must not be 0", hint=_HINT)
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


_OF_SIZE: Final = re.compile(r"(\S+?) ?(?:rms|pp|p-p|0-p|pk|peak)(?:\W.*)?", re.IGNORECASE)  # mm/s rms
_EVENLY: Final = f"give the sampling rate, {argument('rate', 'HZ')}, in place of {argument('time')}"


class _Wanted(NamedTuple):
    """Columns that a user names: headers by the keys of ``KINDS``, and the sensitivities of voltages.

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

    header: Header
    kind: str
    size: float
    sensitivity: _Sensitivity | None = None
    typed: str = ""


#: Columns by the keys of ``KINDS``.
_Columns = dict[str, _Column]

_NAME_ONE: Final = (
    f"name one, with its unit: {argument('displacement', 'X [mm]')}; a voltage with its sensitivity:"
    f" {argument('acceleration', 'a [mV]')} {argument('sensitivity', _EXAMPLES['acceleration'])}"
)
_NAME_THE_TROUGH: Final = (
    "name one or both, with the unit:"
    f" {argument('trough_along', 'ax [m/s^2]')} {argument('trough_normal', 'ay [m/s^2]')}"
)


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
    path, headers = table.path, headers_of(table)
    problems, hints, found = list[str](), list[str](), _Columns()
    # A user who names one signal wants no others; the time is always needed, and chosen by its signals.
    named = [role for role in KINDS if role in wanted.headers and role != "time"]
    sought = () if not wanted.body or any(role in named for role in SIGNALS) else SIGNALS
    clock = () if wanted.rate else ("time",)
    if not (named or wanted.sensitivities):
        found |= _phone_axes(headers)
    for role in dict.fromkeys([*named, *sought, *clock]):
        taken = {column.header.place for column in found.values()}
        try:
            if role in wanted.headers:
                found[role] = _named(table, headers, role, wanted, taken)
            elif KINDS[role] not in {found[name].kind for name in TROUGH if name in found}:
                found |= _detected(table, headers, role, taken)
        except InputError as exc:
            if role in SIGNALS and role not in wanted.headers and not found.keys().isdisjoint(TROUGH):
                continue  # the trough alone is measured too
            problems += exc.raw[0]
            hints += [exc.raw[1]]
    taken = {column.header.place for column in found.values()}
    if not problems and clock and "time" not in found:
        free = [h for h in headers if h.place not in taken and h.unit is None and _ascends(table, h)]
        free.sort(key=lambda h: WORDS["time"].fullmatch(h.name) is None)
        name = (
            f"name it, with its unit: {argument('time', f'{_call(free[0], headers)} [s]')}; or "
            if free
            else ""
        )
        problems.append(f"{path}: no column of time found among {_list(headers)}")
        hints.append(f"{name}give the sampling rate: {argument('rate', 'HZ')}")
    if not problems and found.keys().isdisjoint((*SIGNALS, *TROUGH) if wanted.body else TROUGH):
        what = "signal found" if wanted.body else "motion of the trough named"
        problems.append(f"{path}: no {what} among {_list(headers)}")
        hints.append(_NAME_ONE if wanted.body else _NAME_THE_TROUGH)
    if problems:
        raise InputError(*problems, hint="\n".join(dict.fromkeys(filter(None, hints))))
    _check_use(path, found, wanted)
    return {role: found[role] for role in KINDS if role in found}


def _ascends(table: Table, header: Header) -> bool:
    """Whether a column may be a time: it ascends, and does not count the rows."""
    cells = table.columns[header.place]
    steps = np.diff(cells) if cells.dtype != object else np.zeros(1)
    timely = WORDS["time"].fullmatch(header.name) is not None
    return timely or bool(np.all(steps > 0.0) and not np.all(steps == 1.0))


def _call(header: Header, headers: Sequence[Header]) -> str:
    """Return the name by which a user can choose a column: its number if it has none of its own."""
    same = [h for h in headers if header.name.casefold() in map(str.casefold, h.names)]
    return header.name if header.name and len(same) == 1 else f"{header.place + 1}"


_OF_APPS: Final = {
    "gF": ("acceleration", SIGNAL_UNITS["acceleration"]["g"])
}  # Physics Toolbox: gFx, gFy, gFz


def _phone_axes(headers: Sequence[Header]) -> _Columns:
    """Return the accelerations of a record of three, whose names differ in an x, y and z; else none."""
    found: dict[tuple[str, str], dict[str, _Column]] = {}
    units = {header: header.unit or _OF_APPS.get(header.name[:2]) for header in headers}
    if {unit[0] for unit in units.values() if unit} - {"time", "acceleration"}:
        return {}
    for header, unit in units.items():
        if unit and unit[0] == "acceleration":
            for at in re.finditer("[xyz]", header.name, re.IGNORECASE):
                around = header.name[: at.start()], header.name[at.end() :]
                found.setdefault(around, {})[f"trough_{at[0].casefold()}"] = _Column(header, *unit)
    triples = [columns for columns in found.values() if len(columns) == len(AXES)]
    return {role: triples[0][role] for role in AXES} if len(triples) == 1 else {}


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
            role = sensitivity.role or next(name for name in SIGNALS if KINDS[name] == sensitivity.kind)
            none = f"{path}: no column that is read as {role.replace('_', ' ')} is a voltage for"
            hint = f"name the column, {argument(role, 'HEADER')}, or leave the sensitivity out"
            raise InputError(f"{none} {argument('sensitivity', sensitivity.text)}", hint=hint)


def _named(table: Table, headers: list[Header], role: str, wanted: _Wanted, taken: set[int]) -> _Column:
    """Find the column that a user names; its unit is the one that the user gives, or else in its header."""
    path, key = table.path, wanted.headers[role].strip()
    if not any(key in h.names for h in headers):
        key = key.lstrip("#%;!*/ ")  # marks of comments, which are no part of a name
    name, unit_text = split_header(key)
    found = list[Header]()
    for fold in (str, str.casefold):
        found = found or [h for h in headers if fold(h.text) == fold(key)]
        found = found or [h for h in headers if not {fold(key), fold(name)}.isdisjoint(map(fold, h.names))]
    if len(found) != 1:
        found = [h for h in headers if name == str(h.place + 1)] or found
    if not found and len(headers) == 1:  # whatever it is called
        found, unit_text = headers, unit_text or key * (signal_unit(key) is not None)
    kind = KINDS[role]
    if not found:
        place = min(len(headers), {"time": 1, "trough_normal": 3, "trough_across": 4}.get(role, 2))
        number = argument(role, f"{place} [{next(iter(SIGNAL_UNITS[kind]))}]")
        number = f"give its name or its number, with its unit: {number}"
        hint = did_you_mean(key, (h.text for h in headers if h.name)) or number
        missing = f"{path}: no column {shown(key)} for {role}; its columns are {_list(headers)}"
        raise InputError(missing, hint=hint)
    if len(found) > 1 and role == "time":
        found = _nearest(table, found, taken)
    if len(found) > 1:
        several = f"{path}: {len(found)} columns are called {shown(key)}"
        number = argument(role, f"{found[0].place + 1}{f' [{unit_text}]' if unit_text else ''}")
        raise InputError(several, hint=f"give the number of the one that is meant: {number}")
    (header,) = found
    typed = unit_text if key.casefold() != header.text.casefold() else ""
    unit = signal_unit(typed) if typed else header.unit
    if role == "time":
        unit = _clock_unit(table, header, unit, typed=bool(typed))
        cells = table.columns[header.place]
        text = next(filter(None, cells), "") if cells.dtype == object else ""
        if text and not (DECIMAL.fullmatch(text) or clocks.is_clock(cells)):
            unknown = f"{path}: column {shown(header.text)} for time: {shown(text)} is no time that is known"
            raise InputError(unknown, hint=f"write it like 10:00:59.002, or {_EVENLY}")
    if unit is not None and unit[0] in kinds_of(role):
        return _Column(header, *unit, typed=typed)
    column, example = f"{path}: column {shown(header.text)} for {role}", _EXAMPLES.get(kind)
    if unit is not None and unit[0] == "voltage" and example:
        # A sensitivity of this column has priority over one of its kind.
        of_column = [s for s in wanted.sensitivities if s.role == role]
        for sensitivity in of_column or [s for s in wanted.sensitivities if (s.role, s.kind) == ("", kind)]:
            return _Column(header, sensitivity.kind, unit[1] * sensitivity.per_volt, sensitivity, typed)
        own = argument("sensitivity", f"{role.replace('_', '-')}={example}")
        missing = f"{column}: the sensitivity of its sensor is missing"
        raise InputError(missing, hint=f"give a sensitivity of {_a(kind)}: {own}")
    stated, kinds = typed or header.stated, kinds_of(role)
    problem = f"{shown(stated)} is no unit of {' or '.join(kinds)}" if stated else "it has no unit"
    first = match[1] if (match := _OF_SIZE.fullmatch(stated)) else ""
    known = unit if (unit := signal_unit(first)) and unit[0] in kinds else None
    name = header.name.casefold()
    called = (k for k in kinds if name[:3] == k[:3] or (k in WORDS and WORDS[k].fullmatch(name)))
    kind = known[0] if known else next(called, kind)
    example = _EXAMPLES.get(kind)
    usual, units = first if known else next(iter(SIGNAL_UNITS[kind])), ", ".join(SIGNAL_UNITS[kind])
    own = argument(role, f"{_call(header, headers)} [{usual}]")
    hint = f"write the unit in brackets: {own}; units of {kind} are {units}"
    voltage = f", or mV and V with {argument('sensitivity', example)}" if example else ""
    raise InputError(f"{column}: {problem}", hint=hint + voltage)


def _detected(table: Table, headers: list[Header], role: str, taken: set[int]) -> _Columns:
    """Find the column whose unit fits, among several the one whose name fits; empty if there is none."""
    units = {h.place: h.unit for h in headers if h.place not in taken}
    if role == "time":
        units |= {p: _clock_unit(table, headers[p], unit) for p, unit in units.items()}
    fitting = [_Column(headers[p], *unit) for p, unit in units.items() if unit and unit[0] == KINDS[role]]
    if len(fitting) > 1:
        fitting = [c for c in fitting if any(map(WORDS[role].fullmatch, c.header.names))] or fitting
    if len(fitting) > 1 and role == "time" and len({c.header.text.casefold() for c in fitting}) == 1:
        nearest = _nearest(table, [column.header for column in fitting], taken)
        fitting = [column for column in fitting if column.header in nearest]
    if len(fitting) > 1:
        several = f"{table.path}: {_list([column.header for column in fitting])} could each be the {role}"
        first = fitting[0].header.text
        own = f" of a part, {argument('trough_along', first)} of the trough" if role in DERIVATIVES else ""
        raise InputError(several, hint=f"choose: {argument(role, first)}{own}")
    return {role: fitting[0]} if fitting else {}


def _clock_unit(table: Table, header: Header, unit: Unit | None, *, typed: bool = False) -> Unit | None:
    """Return the unit of a column: its own, but of times of day, and of times since 1970 if none is typed."""
    cells = table.columns[header.place]
    if cells.dtype == object:
        return ("time", 1.0) if clocks.is_clock(cells) else unit
    if typed or (unit and unit[0] != "time"):
        return unit
    value = next((float(x) for x in cells if x == x), 0.0)
    size = clocks.epoch_unit(value, unit[1] if unit else None)
    return ("time", size) if size else unit


def _nearest(table: Table, found: list[Header], places: set[int]) -> list[Header]:
    """Choose of clocks with one name that to the left of the signals."""
    own = [max((h for h in found if h.place < p), key=lambda h: h.place, default=found[0]) for p in places]
    for header in own:
        one, other = (table.columns[h.place] for h in (own[0], header))
        if not np.all((one == other) | ((one != one) & (other != other))):
            both = f"columns {own[0].place + 1} and {header.place + 1}, {shown(header.text)}"
            choose = argument("time", f"{header.place + 1}")
            hint = f"measure one signal alone, or choose a clock for all: {choose}"
            raise InputError(f"{table.path}: {both}, differ", hint=hint)
    return own[:1] or found


def _list(headers: Sequence[Header]) -> str:
    texts = [shown(h.text) for h in headers if h.name or h.stated]
    more = len(texts) - TOL.headers_named
    named = ", ".join(texts[: TOL.headers_named]) + (f" and {more} more" if more > 0 else "")
    return named or f"1 to {len(headers)}, without names"


@dataclass(frozen=True, eq=False)
class Record:
    """Signals over time, in SI units.

    Attributes
    ----------
    time : float array
        Strictly ascending [s]; of times of day and dates, and of times since 1970, from the first row.
    signals : mapping of str to float array
        Relative displacement [m], velocity [m/s], acceleration [m/s^2] and friction [N] at these times, by
        their names in ``SIGNALS``.
    trough : mapping of str to float array
        Motions of the trough [m/s^2, m/s or m] at these times, by their names in ``TROUGH``.
    headers : mapping of str to str
        The columns' headers in the file, by the same names and ``"time"``, unless a rate gives the time.
    sensitivities : mapping of str to str
        Sensitivities of the columns that are voltages, as typed, by the same names.
    trough_kinds : mapping of str to str
        What each motion of the trough is, a key of ``DERIVATIVES``; without one an acceleration.
    notes : tuple of str
        How the file was read, for the user.
    believed : mapping of str to str
        Units that were typed with columns, ``2 [g]``, ``ax [g]``, by their names, ``"time"`` among them; not
        if the text is the header as it stands in the file. Their values are right, however absurd they look.
    """

    time: Floats
    signals: Mapping[str, Floats]
    trough: Mapping[str, Floats]
    headers: Mapping[str, str]
    sensitivities: Mapping[str, str] = field(default_factory=dict)
    notes: tuple[str, ...] = ()
    trough_kinds: Mapping[str, str] = field(default_factory=dict)
    believed: Mapping[str, str] = field(default_factory=dict)

    @property
    def trough_derivatives(self) -> dict[str, int]:
        """Derivatives over time from each motion of the trough, as recorded, to its acceleration."""
        return {name: DERIVATIVES[self.trough_kinds.get(name, "acceleration")] for name in self.trough}


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
        Text of columns as ``texts.text_table`` reads it, in UTF-8 (with or without a byte order mark), UTF-16
        or a Windows code page; LabVIEW's text, TDMS, UFF58, MAT or WAV.
    columns : mapping of str to str, optional
        Headers by ``"time"`` and the names of ``SIGNALS`` and ``TROUGH``; or the columns' numbers, from 1.
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
    table = read_channels(path) or text_table(path)
    hertz = None if rate is None else checked_number(str(rate), RATE)
    wanted = _Wanted(columns or {}, sensitivities, body, hertz)
    if hertz is not None and "time" in wanted.headers:
        both = f"{argument('time')} and {argument('rate')} are both given"
        raise InputError(both, hint="leave one of them out")
    chosen = _columns_of(table, wanted)
    notes = [*table.notes]
    values = {r: table.numbers(c.header, c.size) for r, c in chosen.items() if r != "time"}
    for role, x in values.items():
        if (every := clocks.held(x)) > 1:
            holds = f"column {shown(chosen[role].header.text)} holds each value for {every} rows: one is used"
            notes.append(f"{role.replace('_', ' ')}: {holds}")
    if "time" in chosen:
        time, periods = table.times(chosen["time"].header, chosen["time"].size)
    else:
        rate = wanted.rate or 1.0
        time, periods = np.arange(table.columns[0].size, dtype=np.float64) / rate, np.empty(0)
        notes.append(f"time: {rate:g} rows a second")
    some = np.flatnonzero(~np.isnan([time, *values.values()]).all(axis=0))
    end = int(some[-1]) + 1 if some.size else time.size  # of columns that end before others
    time, values = time[:end], {role: x[:end] for role, x in values.items()}
    if not values.keys().isdisjoint(TROUGH):  # a part that nobody named is not worth a record of the trough
        holes = {role: np.isnan(x).mean() > TOL.skipped for role, x in values.items()}
        slow = any(holes[role] for role in TROUGH if role in holes)
        for role in [r for r in values if r in SIGNALS and r not in wanted.headers]:
            if slow or holes[role]:
                why = "lacks values" if holes[role] else "is sampled at another rate"
                notes.append(f"{role}: column {shown(chosen.pop(role).header.text)} {why}: it is left out")
                del values[role]
    time, copies, mended = clocks.mended(time, periods, [*values.values()])
    kept, skipped = _with_values(table, chosen, {"time": time, **values}, copies)
    notes += [f"{table.path.name}: {text}" for text in (*mended, *skipped)]
    values = {role: x[kept] for role, x in {"time": time, **values}.items()}
    _check_time(table, chosen, values["time"], np.flatnonzero(kept))
    texts = {role: column.sensitivity.text for role, column in chosen.items() if column.sensitivity}
    headers = {role: column.header.text for role, column in chosen.items()}
    for role, header in headers.items():
        at = f" at {texts[role]}" if role in texts else ""
        unit = f" in {chosen[role].typed}" if chosen[role].typed else ""
        notes.append(f"{role.replace('_', ' ')}: column {shown(header)}{unit}{at}")
    kinds = {role: column.kind for role, column in chosen.items() if role in TROUGH}
    signals = {role: x for role, x in values.items() if role in SIGNALS}
    trough = {role: x for role, x in values.items() if role in TROUGH}
    believed = {role: column.typed for role, column in chosen.items() if column.typed}
    return Record(values["time"], signals, trough, headers, texts, tuple(notes), kinds, believed)


def _with_values(
    table: Table, chosen: _Columns, values: Mapping[str, Floats], copies: Flags
) -> tuple[Flags, list[str]]:
    """Return which rows hold a value in every column, and what to say of the others; refuse too many."""
    if np.count_nonzero(~copies) < 2:
        raise InputError(f"{table.path}: one row is no record", hint="export all rows")
    kept = np.asarray(~np.isnan([*values.values()]).any(axis=0))
    lost = np.flatnonzero(~kept & ~copies)
    kept &= ~copies
    if lost.size <= TOL.skipped * (kept.size - np.count_nonzero(copies)):
        rows = [str(table.row(i)) for i in lost.tolist()]
        named = ", ".join([*rows[:CELLS_NAMED], *(["..."] if len(rows) > CELLS_NAMED else [])])
        return kept, [f"skipped rows without a value: {named} ({lost.size} of {kept.size})"] if rows else []
    time = values["time"]
    steps, timed = np.diff(time[kept]), not np.isnan(time[lost]).any()
    slow = float(np.median(steps)) if steps.size >= TOL.fewest_values else 0.0
    even, gaps = (
        np.count_nonzero(x)
        for x in (np.abs(steps - slow) <= TOL.even * slow, steps > (1.0 + TOL.even) * slow)
    )
    if slow > 0.0 and timed and even >= (1.0 - TOL.skipped) * steps.size and gaps <= TOL.skipped * lost.size:
        each = "all columns" if len(values) > 2 else "the column"
        return kept, [
            f"{steps.size + 1} of {kept.size} rows hold a value in {each}, {1.0 / slow:.7g} a second"
        ]
    problems, headers = list[str](), {role: chosen[role].header for role in values if role in chosen}
    if not kept.any() and not any(np.isnan(x).all() for x in values.values()):
        texts = ", ".join(shown(header.text) for header in headers.values())
        raise InputError(f"{table.path}: no row has a value in each of {texts}", hint="name one signal alone")
    for role, header in headers.items():
        problems += table.named(header, np.isnan(values[role]), values[role])
    limit = f"at most {100.0 * TOL.skipped:.0f} % are skipped"
    few = f"{table.path}: {lost.size} of {kept.size} rows lack a value: {limit}"
    raise InputError(*problems, few, hint=_EVENLY if np.isnan(time).mean() > TOL.skipped else DELETE)


def _check_time(table: Table, chosen: _Columns, time: Floats, kept: NDArray[np.intp]) -> None:
    """Refuse a time that repeats, goes back or jumps; ``kept`` holds the places of its rows in the table."""
    steps = np.diff(time)
    usual = float(np.median(steps)) if steps.size else 0.0
    for bad, what, hint in (
        (steps < 0.0, "goes back to", "sort the rows by time, or keep one of the runs"),
        (steps == 0.0, "repeats", f"keep one row for each time, or {_EVENLY}"),
        (steps > TOL.gap * usual, "jumps to", "fill the gap, or keep the part before or after it"),
    ):
        places = np.flatnonzero(bad)
        if places.size:
            i = int(places[0]) + 1
            column = f", column {shown(chosen['time'].header.text)}" if "time" in chosen else ""
            where = f"{table.path}: row {table.row(int(kept[i]))}{column}"
            moves = f"time {what} {time[i]:.9g} s after {time[i - 1]:.9g} s, usual steps are {usual:.3g} s"
            lost = int(kept[i] - kept[i - 1]) - 1
            between = f"; rows without a value before it: {lost}" if lost else ""
            more = f"; such rows in all: {places.size}" if places.size > 1 else ""
            raise InputError(f"{where}: {moves}{between}{more}", hint=hint)
