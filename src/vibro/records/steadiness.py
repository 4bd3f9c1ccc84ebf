"""Whether a trough runs steadily: amplitude, phase and frequency of its first harmonic over a record.

The residual of the harmonic regression, turned back by the phase of the fundamental, is how far amplitude and
phase are from their means at any time. Of steady running it is noise, as strong at every offset from the
fundamental's frequency; what changes slowly is strong at the smallest offsets, a second drive at one of them.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Final, NamedTuple

import numpy as np
from scipy.fft import dct
from scipy.special import chdtrc, fdtrc

from vibro.errors import InputError, argument, shown
from vibro.records.channels import AXES, SIGNAL_UNITS, signal_unit, unit_of_header
from vibro.records.reading import TOL, Record, doubt, rounded
from vibro.units import STANDARD_GRAVITY

if TYPE_CHECKING:
    from vibro.reals import Complexes, Floats

#: What to do with a record of a trough that does not run steadily.
STEADY_HINT: Final = (
    "record steady running, or choose a steady part of it: --from and --to, in Python start and end"
)
#: A smaller unit than the one of each kind that is usual.
_SMALL: Final = {"acceleration": "mm/s^2", "velocity": "mm/s", "displacement": "mm"}
_OF_GRAVITY: Final = ("g", "m/s^2", "mg", "mm/s^2")
#: Numbers of slow components that are tested, each alone.
_SLOW: Final = (1, 3, 8)
_MEDIAN: Final = math.log(2.0)  # of an exponential distribution, over its mean
_OF_MEDIAN: Final = 0.48  # degrees of freedom of the median of a sample over those of its mean
_OF_QUADRATIC: Final = 1.23  # standard deviation of a linear frequency, times T over the phase's


# --- part of a record, and its sampling rate ------------------------------------------------------------


def part_of(record: Record, start: float | None, end: float | None) -> Record:
    """Return the part of a record between two times on its own clock, both included [s].

    Raises
    ------
    InputError
        If fewer than three rows lie between them.
    """
    if start is None and end is None:
        return record
    first = float(record.time[0]) if start is None else start
    last = float(record.time[-1]) if end is None else end
    kept = (record.time >= first) & (record.time <= last)
    if np.count_nonzero(kept) < 3:
        few = f"{np.count_nonzero(kept)} rows lie from {clock_text(first)} to {clock_text(last)} s"
        ends = " to ".join(clock_text(float(at)) for at in record.time[[0, -1]])
        whole = f"the record goes from {ends} s"
        raise InputError(few, hint=f"{whole}, on its own clock")
    signals, trough = (
        {name: values[kept] for name, values in one.items()} for one in (record.signals, record.trough)
    )
    return replace(record, time=record.time[kept], signals=signals, trough=trough)


def clock_text(time: float) -> str:
    """Write a time on a record's clock, to the millisecond."""
    return f"{round(time, 3):.13g}"


def rate_of(time: Floats) -> float:
    """Return the sampling rate; rows that are left out do not lower it [Hz]."""
    steps = np.diff(time)
    # Where times are rounded the median is too: the mean of the steps over which no row is left out is not.
    return 1.0 / float(steps[steps < 1.5 * np.median(steps)].mean())


def apparent(frequency: float, rate: float) -> float:
    """Return the frequency at or below half the sampling rate at which samples show a frequency [Hz]."""
    return abs(math.remainder(frequency, rate))


def room_of(frequency: float, rate: float) -> float:
    """Return how far an apparent frequency is from an offset and from its own image [Hz]."""
    shown = apparent(frequency, rate)
    return min(shown, rate - 2.0 * shown)


def folding_onto(frequency: float, rate: float, highest: float) -> list[float]:
    """Return the other frequencies that samples show at the same apparent frequency, ascending [Hz]."""
    shown, turns = apparent(frequency, rate), range(int(highest / rate) + 2)
    found = {one for turn in turns for one in (turn * rate - shown, turn * rate + shown)}
    return sorted(one for one in found if shown < one <= highest and abs(one - frequency) > 1e-6 * rate)


def scale_notes(record: Record, role: str, size: float, frequency: float, other: str = "") -> list[str]:
    """Refuse a motion that neither troughs nor parts have; note it where its unit was typed.

    Parameters
    ----------
    record : Record
        The record.
    role : str
        Name of the signal.
    size, frequency : float
        Amplitude of its acceleration [m/s^2], and its frequency [Hz].
    other : str
        Another likely cause, before the hint.

    Raises
    ------
    InputError
        If a unit that was not typed is the likely cause.
    """
    limits = (
        (TOL.most_acceleration, 0, STANDARD_GRAVITY, "g"),
        (TOL.most_speed, 1, 1.0, "m/s"),
        (TOL.most_amplitude, 2, 1.0, "m"),
    )
    w = math.tau * frequency
    over = [(size / w**power / one, unit) for most, power, one, unit in limits if size > most * w**power]
    is_slow, is_fast = frequency < TOL.lowest_frequency, frequency > TOL.most_frequency
    if not over and not is_fast:
        return []
    header = record.headers[role]
    moves = ", ".join(f"{rounded(value)} {unit}" for value, unit in over)
    at = f"{moves and f'of {moves} '}at {float(f'{frequency:.4g}'):g} Hz"
    text = f"column {shown(header)}: a vibration {at} is not credible"
    if role in record.believed and (not (is_slow or is_fast) or "time" in record.believed):
        return [f"{text}, but is taken, as its unit is given"]
    sensitivity = record.sensitivities.get(role, "")
    if is_slow or is_fast:
        seconds, said = SIGNAL_UNITS["time"], frequency * _unit_size(record, "time")
        likely = [
            u
            for u in ("s", "ms", "us", "ns")
            if TOL.usual_frequency <= said / seconds[u] <= TOL.most_frequency
        ]
        unit = next(iter(likely), "ms" if is_slow else "s")
        typed = argument("time", f"{_bare(record.headers.get('time', 't'))} [{unit}]")
        hint = f"the time may be in {unit}: {typed}"
    elif sensitivity:
        hint = doubt(sensitivity)
    else:
        kind = record.trough_kinds.get(role, "acceleration") if role in record.trough else role
        named = "trough_along" if role in AXES else role  # nobody named the axes of a phone
        typed = argument(named, f"{_bare(header)} [{_SMALL[kind]}]")
        hint = f"its unit may be wrong: give it with the column, {typed}"
    raise InputError(text, hint=f"{other}{hint}")


def gravity_notes(record: Record, level: Floats, sizes: Sequence[float]) -> list[str]:
    """Refuse accelerations whose mean is gravity in another unit; note it where their unit was typed.

    Parameters
    ----------
    record : Record
        The record.
    level : array, shape (C,)
        Constant part of each motion of the trough; NaN of what is no acceleration [m/s^2].
    sizes : sequence of float
        Amplitudes of their accelerations [m/s^2].

    Raises
    ------
    InputError
        If the unit was not typed.
    """
    roles, mean = [*record.trough], float(np.linalg.norm(level))
    up = roles[int(np.argmax(abs(level)))]
    said = _unit_size(record, up)
    for unit in _OF_GRAVITY:
        size = SIGNAL_UNITS["acceleration"][unit] / said
        is_gravity = abs(mean * size / STANDARD_GRAVITY - 1.0) <= TOL.near_gravity
        if size == 1.0 or not is_gravity or max(sizes) * size > TOL.most_beside_gravity:
            continue
        named = ", ".join(shown(record.headers[role]) for role in roles)
        seen = f"column {named}: the mean is {mean / STANDARD_GRAVITY:.3g} g"
        text = f"{seen}, which is gravity if the unit is {unit}"
        if up in record.believed:
            return [f"{text}, but {record.believed[up]} is taken, as it is given"]
        if not record.sensitivities:
            flat = sorted(set(roles) - {up}, key=lambda role: -sizes[roles.index(role)])
            axes = dict(zip((up, *flat), ("trough_normal", "trough_along", "trough_across"), strict=False))
            names = {role: axes[role] if role in AXES else role for role in roles}
            typed = [argument(names[r], f"{_bare(record.headers[r])} [{unit}]") for r in roles]
            raise InputError(text, hint=f"give the unit with the column: {' '.join(typed)}")
    return []


def _unit_size(record: Record, role: str) -> float:
    """Return the size of the unit that was typed with a column or that its header states [SI]."""
    unit = signal_unit(record.believed.get(role, "")) or unit_of_header(record.headers.get(role, ""))
    return unit[1] if unit else 1.0


def _bare(header: str) -> str:
    """Return a header without its unit."""
    return header.split("[")[0].split("(")[0].strip()


# --- the first harmonic over time -----------------------------------------------------------------------


class Envelope(NamedTuple):
    """The first harmonic over a record, relative to its mean.

    Attributes
    ----------
    frequency : float
        Its frequency [Hz].
    start, span : float
        Beginning and length of the record [s].
    rate : float
        Sampling rate [Hz].
    cycles : float
        Cycles that can be told apart: those of the apparent frequency.
    off : complex array
        Departure from the mean in every half cycle: of the amplitude, and of the phase [rad].
    noise : float
        Variance of the mean by noise.
    swing : float
        Root mean square of the relative amplitude's departures, without noise; also of those that last a few
        cycles.
    p_value : float
        Probability that noise departs as far as this, or in one offset as much.
    """

    frequency: float
    start: float
    span: float
    rate: float
    cycles: float
    off: Complexes
    noise: float
    swing: float
    p_value: float

    @property
    def windows(self) -> Complexes:
        """Relative amplitude and phase in some windows."""
        count = min(TOL.steady_windows, max(3, int(self.cycles / TOL.window_cycles)))
        return np.array([1.0 + one.mean() for one in np.array_split(self.off, count)])


def envelope_of(time: Floats, left: Floats, sizes: Complexes, weights: Floats, frequency: float) -> Envelope:
    """Follow the first harmonic of several channels over a record.

    Parameters
    ----------
    time : array, shape (N,)
        Ascending [s].
    left : array, shape (N, channels)
        Residuals of a regression on the harmonics.
    sizes, weights : array, shape (channels,)
        Amplitudes of the first harmonic's sines, and weights of the channels.
    frequency : float
        Its frequency [Hz].
    """
    span = float(np.ptp(time))
    rate = rate_of(time)
    cycles = span * room_of(frequency, rate)
    own = 2j * (left @ (weights * sizes.conj())) / float(abs(sizes) ** 2 @ weights)
    own = own * np.exp(-1j * math.tau * frequency * time)
    count = max(4, min(int(2.0 * cycles), time.size // 2))
    places = np.minimum(((time - time[0]) / span * count).astype(np.intp), count - 1)
    off = np.bincount(places, own.real, count) + 1j * np.bincount(places, own.imag, count)
    off *= count / time.size
    # Components at the offsets j / 2T to both sides: of noise all are as strong as its mean.
    waves = (dct(off.real) + 1j * dct(off.imag)) / (math.sqrt(2.0) * count)
    end = max(3, int(2.0 * TOL.band * cycles) + 1)
    far, waves = abs(waves[end:]) ** 2, waves[1:end]
    powers = abs(waves) ** 2
    slow = [k for k in _SLOW if 2 * k <= powers.size]
    p_values, noise = [], 0.0
    for k in reversed(slow):
        others = powers[k:]
        noise = float(np.median(others)) / _MEDIAN + TOL.rounding**2
        # The frequency of least squares leaves the phase no slope: one real component less.
        ratio = 2.0 * float(powers[:k].sum()) / (noise * (2 * k - 1))
        p_values.append(float(fdtrc(2 * k - 1, max(2.0 * _OF_MEDIAN * others.size, 1.0), ratio)))
    if slow[-1] < _SLOW[-1] and far.size > 2 * slow[-1] and powers[0] > powers[1:].sum():
        # In few cycles a run-up, unlike another machine, fills all that is near: noise is farther off.
        apart, degrees = float(np.median(far)) / _MEDIAN + TOL.rounding**2, 2 * slow[-1] - 1
        ratio = 2.0 * float(powers[: slow[-1]].sum()) / (apart * degrees)
        p_far = float(fdtrc(degrees, 2.0 * _OF_MEDIAN * far.size, ratio))
        if p_far < min(p_values):
            p_values, noise = [*p_values, p_far], min(noise, apart)
    near = powers[: max(2 * slow[-1], int(2.0 * TOL.near_offset * cycles))]
    swing = float(np.square(waves.real[: near.size]).sum()) - 0.5 * noise * near.size
    if near.size > slow[-1]:
        largest = float(near.max()) / noise
        chance = float(fdtrc(2.0, 2.0 * _OF_MEDIAN * powers.size, largest))
        p_values.append(near.size * chance)
    p_value = min(1.0, len(p_values) * min(p_values))
    rms = math.sqrt(max(0.0, swing))
    return Envelope(frequency, float(time[0]), span, rate, cycles, off, noise, rms, p_value)


class Change(NamedTuple):
    """How a first harmonic changes over a record.

    Attributes
    ----------
    text : str
        What it does, without the amplitude's size.
    amplitude : float
        Root mean square of its departures from the mean amplitude, and what a phase that wanders takes off
        the mean, relative.
    frequency : float
        Standard deviation of its frequency [Hz].
    is_large : bool
        Whether its mean tells little.
    is_seen : bool
        Whether it is worth a warning.
    """

    text: str
    amplitude: float
    frequency: float
    is_large: bool
    is_seen: bool


def change_of(envelope: Envelope, size: float, *, is_part: bool = False) -> Change:
    """Say how the first harmonic changes; ``size`` is its mean amplitude [m].

    The part of a longer record may be approaching its amplitude: its error is the whole slope then.
    """
    windows = envelope.windows
    noise = envelope.noise * windows.size  # variance of one window
    sizes: Floats = np.abs(windows)
    phases = _level(np.unwrap(np.angle(windows[sizes > TOL.standing * sizes.max()])))
    spread = math.sqrt(0.5 * noise)
    swing = max(0.0, float(np.ptp(sizes)) - 4.0 * spread)
    turn = max(0.0, float(np.ptp(phases)) - 4.0 * spread)
    beat = _beat_of(envelope)
    wave = max(0.0, float(np.var(phases)) - spread**2)
    amplitude = math.sqrt(max(0.0, float(np.var(sizes)) - spread**2) + 0.25 * wave**2)
    # What is faster than the windows swings like a sine.
    is_fast = math.sqrt(8.0) * envelope.swing > max(2.0 * swing, TOL.steady_amplitude)
    if beat or is_fast:
        swing = max(swing, 2.0 * beat[1] if beat else math.sqrt(8.0) * envelope.swing)
        amplitude = max(amplitude, envelope.swing)
    if is_part:
        place = np.arange(sizes.size)
        amplitude = max(amplitude, abs(float(np.polyfit(place, sizes, 1)[0])) * sizes.size)
    late = _OF_QUADRATIC * math.sqrt(wave) / envelope.span
    ends = _frequencies(envelope, phases)

    def mm(part: float) -> str:
        return f"{1e3 * size * part:.3g}"

    if beat:
        other = envelope.frequency + beat[0]
        both = f"two drives or machines run, at {envelope.frequency:.4g} and {other:.4g} Hz"
        rate, least = envelope.rate, 1.0 / envelope.span
        for k in range(2, TOL.folded_harmonics + 1):
            if abs(apparent(k * envelope.frequency, rate) - apparent(other, rate)) < least:
                both = f"{rate:.5g} samples a second show harmonic {k} at {other:.4g} Hz"
                both += ": sample at another rate"
        text = f"the amplitude beats at {abs(beat[0]):.2g} Hz: {both}"
    elif turn / TOL.steady_phase > swing / TOL.steady_amplitude:
        text = f"the frequency changes, {ends}"
    elif is_fast:
        text = f"the amplitude swings by {rounded(100.0 * swing)} % within a few cycles"
    else:
        text = f"the amplitude {_course(sizes, mm)} ({rounded(100.0 * float(np.ptp(sizes) / sizes.max()))} %)"
    is_large = swing > TOL.steady_amplitude or turn > TOL.steady_phase
    return Change(text, amplitude, late, is_large, max(swing, 0.5 * wave) > TOL.seen_change)


def _level(phases: Floats) -> Floats:
    """Take the mean and the slope off phases."""
    if phases.size < 3:
        return 0.0 * phases
    place = np.arange(phases.size)
    return np.asarray(phases - np.polyval(np.polyfit(place, phases, 1), place))


def _course(sizes: Floats, mm: Callable[[float], str]) -> str:
    """Say how an amplitude goes."""
    first, last, least, most = float(sizes[0]), float(sizes[-1]), float(sizes.min()), float(sizes.max())
    turns = np.count_nonzero(np.diff(sizes > 0.5 * (least + most)))
    if turns == 1 and abs(last - first) > TOL.monotonic * (most - least):
        return f"{'rises' if last > first else 'falls'} from {mm(first)} to {mm(last)} mm"
    if turns == 2 and max(first, last) < TOL.monotonic * most:
        return f"rises from {mm(first)} to {mm(most)} mm and falls to {mm(last)} mm"
    return f"varies between {mm(least)} and {mm(most)} mm"


def _frequencies(envelope: Envelope, phases: Floats) -> str:
    """Say how a frequency goes."""
    places = np.linspace(-1.0, 1.0, 2 * phases.size + 1)[1::2]
    smooth = np.polyfit(places, phases, min(3, max(0, phases.size - 2)))
    rate = math.pi * envelope.span  # of the phase over half the span
    if np.std(phases - np.polyval(smooth, places)) > TOL.much_less * np.std(phases):
        slopes = envelope.frequency + np.gradient(phases, places) / rate
        return f"between {slopes.min():.4g} and {slopes.max():.4g} Hz"
    first, last = envelope.frequency + np.polyval(np.polyder(smooth), [-1.0, 1.0]) / rate
    return f"from {first:.4g} to {last:.4g} Hz"


def _beat_of(envelope: Envelope) -> tuple[float, float] | None:
    """Return the offset [Hz] and the relative size of a second wave that makes up most of the departures."""
    off = envelope.off
    size = 32 * off.size
    waves = np.fft.fft(off, size) / off.size
    apart = np.fft.fftfreq(size, envelope.span / off.size)
    near = (abs(apart) * envelope.span > TOL.least_beats) & (
        abs(apart) < TOL.near_offset * envelope.frequency
    )
    if not near.any():
        return None
    place = int(np.argmax(np.where(near, abs(waves), 0.0)))
    largest = float(abs(waves[place]))
    rest = float(np.mean(abs(off) ** 2)) - envelope.noise * off.size
    mirrored = float(
        abs(waves[-place])
    )  # as large, if the amplitude alone or the phase alone goes to and fro
    if largest**2 < max(TOL.beat_share * rest, 10.0 * envelope.noise) or mirrored > 0.5 * largest:
        return None
    return float(apart[place]), largest


def steady_part(envelope: Envelope) -> tuple[float, float] | None:
    """Return the ends of the longest part in which amplitude and frequency are steady within noise [s].

    A part of a change that goes on all the time is none: over its length it must change far less than the
    whole record does.
    """
    if _beat_of(envelope):
        return None
    windows = envelope.windows
    count = windows.size
    variance = 0.5 * envelope.noise * count + TOL.seen_change**2 / 12.0
    sizes, phases = abs(windows), np.unwrap(np.angle(windows))
    whole = float(np.ptp(sizes)), float(np.std(_level(phases[sizes > TOL.standing * sizes.max()])))
    for length in range(count - 1, TOL.least_windows - 1, -1):
        if length * envelope.cycles / count < TOL.motion_cycles or length < TOL.least_part * count:
            break
        places = np.arange(length) - 0.5 * (length - 1)
        slope_error = math.sqrt(variance / float(places @ places))
        fits = []
        for first in range(count - length + 1):
            part, turned = sizes[first : first + length], _level(phases[first : first + length])
            mean = float(part.mean())
            if mean < 0.5 * sizes.max():
                continue
            slope = float(places @ part) / float(places @ places)
            misfit = float(((part - mean) ** 2).sum() + mean**2 * (turned**2).sum()) / variance
            share = length / count
            goes_on = (
                whole[0] > TOL.steady_amplitude
                and (abs(slope) + slope_error) * count > TOL.much_less * whole[0]
            ) or (
                whole[1] > TOL.steady_phase / 3.0
                and float(np.std(turned)) > TOL.much_less * whole[1] * share**2
            )
            if abs(slope) < 1.5 * slope_error and chdtrc(2 * length - 3, misfit) > 0.01 and not goes_on:
                fits.append((misfit, first))
        if fits:
            first = min(fits)[1]
            step = envelope.span / count
            return envelope.start + first * step, envelope.start + (first + length) * step
    return None


def course_of_frequency(time: Floats, values: Floats, *, alone: bool) -> str:
    """Say how the frequency of a wave changes that stands out in parts of a record, or where one stands out.

    Parameters
    ----------
    time, values : array, shape (N,) and (N, channels)
        Ascending [s]; signals in any units.
    alone : bool
        Whether to say too where a wave of one frequency stands out.

    Returns
    -------
    str
        Empty if neither is clear.
    """
    rate = rate_of(time)
    even = np.linspace(float(time[0]), float(time[-1]), time.size)
    columns = np.array([np.interp(even, time, x - x.mean()) / (np.std(x) or 1.0) for x in values.T])
    for count in TOL.courses:
        size = time.size // count
        if size < TOL.least_course:
            continue
        shaped = columns[:, : size * count].reshape(len(columns), count, size)
        shaped = (shaped - shaped.mean(axis=2, keepdims=True)) * np.hanning(size)
        waves = (abs(np.fft.rfft(shaped, 4 * size, axis=2)) ** 2).sum(axis=0)
        places = waves.argmax(axis=1)
        near = abs(np.arange(waves.shape[1]) - places[:, None]) <= 12
        powers = (waves * near).sum(axis=1)
        shares = powers / waves.sum(axis=1)
        found = (waves * near) @ np.arange(waves.shape[1]) / powers * rate / (4.0 * size)
        middles = (np.arange(count) + 0.5) / count
        clear = (shares > TOL.beat_share) & (powers > TOL.standing * powers.max())
        cycles = found * size / rate
        # A step is slower than its part is long; near half the sampling rate are two images.
        clear &= (cycles > 1.0) & (cycles < 0.5 * size - 3.0)
        if clear.sum() < (3 if alone else TOL.least_windows):
            continue
        if (
            alone
            and np.ptp(found[clear]) < 0.5 * rate / size
            and not clear.all()
            and np.ptp(np.flatnonzero(clear)) < clear.sum()
        ):
            places = np.flatnonzero(clear)[[0, -1]] + [0, 1]
            ends = " to ".join(clock_text(float(time[0] + np.ptp(time) * x / count)) for x in places)
            return f"a wave of {np.mean(found[clear]):.3g} Hz stands out from {ends} s alone"
        course = np.polyfit(middles[clear], found[clear], 1)
        if np.std(found[clear] - np.polyval(course, middles[clear])) > TOL.much_less * np.std(found[clear]):
            course = np.polyfit(middles[clear], found[clear], 2)
        left = float(np.std(found[clear] - np.polyval(course, middles[clear])))
        first, last = (max(0.0, float(np.polyval(course, x))) for x in (0.0, 1.0))
        if clear.sum() >= TOL.least_windows and np.ptp(found[clear]) > 4.0 * left + 0.25 * rate / size:
            return f"the frequency changes, from {first:.3g} to {last:.3g} Hz"
    return ""
