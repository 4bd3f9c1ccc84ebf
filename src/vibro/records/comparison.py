"""A measured record compared with the exact steady motion."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING, Final, NamedTuple

import numpy as np

from vibro.html_tables import Shown, amount
from vibro.motion.settled import SettledMotion, settled_motion
from vibro.reals import shielded
from vibro.records.alignment import (
    Alignment,
    Estimate,
    Folded,
    Observation,
    align,
    check_scene,
    detrended,
    fold,
    foreign_frequency,
)
from vibro.records.reading import TOL, doubt, rounded
from vibro.records.steadiness import change_of, envelope_of
from vibro.results.drawing import drawn
from vibro.results.history import Phase
from vibro.scene import Scene

if TYPE_CHECKING:
    from os import PathLike

    from matplotlib.figure import Figure

    from vibro.reals import Floats

_DERIVATIVES: Final = {"velocity": 1, "displacement": 0, "acceleration": 2}
_WAYS: Final = {"F": 1, "B": -1}
#: Kind of a row -> its unit, and the size of that in SI units; friction is per unit mass without a mass.
UNITS: Final = {
    "displacement": ("mm", 1e-3),
    "velocity": ("mm/s", 1e-3),
    "time": ("ms", 1e-3),
    "acceleration": ("m/s^2", 1.0),
    "friction": ("m/s^2", 1.0),
}


class Row(NamedTuple):
    """One quantity, measured and computed.

    Attributes
    ----------
    key : str
        Name in answers.
    kind : str
        ``displacement``, ``velocity``, ``time``, ``acceleration`` or ``friction``; values have SI units.
    measured : Estimate
        Measured value with its standard error; NaN if it cannot be found in the record.
    computed : float
        The model's value; NaN if it has none.
    """

    key: str
    kind: str
    measured: Estimate
    computed: float


@dataclass(frozen=True, eq=False, repr=False)
class Comparison(Shown):
    """A record beside the model, on the same clock; returned by ``vibro.compare``.

    Attributes
    ----------
    scene : Scene
        That of the model.
    observation : Observation
        The record, relative to the trough.
    motion : SettledMotion
        The model.
    alignment : Alignment
        Trough time of the record's clock.
    rows : tuple of Row
        Quantities, each with its ``key``, ``measured.value`` with its standard error ``measured.error``, and
        ``computed``, in SI units.
    trough_time : array
        Trough time of each sample [s].
    passing : str
        Direction in which the trough passes its middle at trough time 0: ``upwards`` along a line,
        ``forwards`` along an ellipse; empty without a motion along the trough.
    computed : mapping of str to array
        The model's signals at the record's times, by the names of the measured ones; the computed
        displacement has the mean of the measured one.
    curve_time, curves : array, mapping of str to array
        Trough times over one cycle, and the model's signals there; the displacement begins at 0.
    recorded : Observation
        The record as it was recorded, in absolute coordinates maybe.
    """

    scene: Scene
    observation: Observation
    motion: SettledMotion
    alignment: Alignment
    rows: tuple[Row, ...]
    trough_time: Floats
    passing: str
    computed: Mapping[str, Floats]
    curve_time: Floats
    curves: Mapping[str, Floats]
    recorded: Observation

    def __repr__(self) -> str:
        """Return a summary: ``<Comparison of 900 samples, computed pattern F_>``."""
        return f"<Comparison of {self.trough_time.size} samples, computed pattern {self.motion.pattern}>"

    def _table(self) -> tuple[str, list[tuple[str, ...]], tuple[str, ...]]:
        """Return the rows in the units of tables."""
        rows = []
        for key, kind, measured, computed in self.rows:
            unit, size = UNITS[kind]
            numbers = (*measured, computed)
            rows.append((key, *("" if math.isnan(x) else amount(x / size, unit) for x in numbers)))
        return repr(self).strip("<>"), rows, ("", "measured", "standard error", "computed")

    @shielded
    def draw(self, path: str | PathLike[str] | None = None) -> Figure:
        """Draw the record beside the model, as ``vibro measure -o`` does.

        Parameters
        ----------
        path : str or path, optional
            File to write, by its ending: ``.png``, ``.svg`` or ``.pdf``; an existing one is replaced.

        Returns
        -------
        matplotlib.figure.Figure
            A row for each signal: the first cycles of the record, and all cycles laid on one; no window
            opens.

        Raises
        ------
        InputError, FileError
            If the file is no picture, or cannot be written.
        """
        return drawn(self, path)

    @cached_property
    def warnings(self) -> tuple[str, ...]:
        """Reasons to doubt the comparison."""
        observation, motion, alignment = self.recorded, self.motion, self.alignment
        warnings = []
        if math.isnan(alignment.shift):
            warnings.append("the computed body rests: the position of the data in the cycle cannot be found")
        for rival in alignment.rivals:
            first = (rival + float(observation.time[0])) % observation.period
            begin = f"{1e3 * first:.4g} ms after the trough's middle"
            warnings.append(f"the data fit almost as well if they begin {begin}")
        warnings += _of_another_size(observation, motion)
        warnings += _of_another_frequency(observation) or _of_a_change(observation)
        warnings += _of_another_clock(observation, motion, alignment)
        advance = next((r.measured.value for r in self.rows if r.key == "stroke_advance"), math.nan)
        if advance * motion.advance < 0.0:
            warnings.append("the data run against the computed direction: reverse their axis, or leave it")
        computed, measured = (signals.get("friction") for signals in (self.computed, observation.signals))
        if computed is not None and np.cov(computed, measured)[0, 1] < 0.0:
            must = "it must be the force on the body, not on the trough"
            warnings.append(f"the friction has the opposite sign: {must}")
        return tuple(warnings)


def compare(scene: Scene, observation: Observation) -> Comparison:
    """Compare a record with the steady motion of a scene.

    Parameters
    ----------
    scene : Scene
        Scene of shape ().
    observation : Observation
        The record; its drive frequency is the scene's.

    Raises
    ------
    InputError
        If the record has too few cycles, or too few samples a cycle; or if the scene cannot be compared with
        a record (``check_scene``).
    VibroError
        If the scene has no steady motion.

    Notes
    -----
    Mean values come from a regression on a trend and the harmonics of the drive (``folding``), so that the
    record need not hold whole cycles. Peaks, starts and ends of slides come from its velocity. Errors are
    standard errors from noise, which may be correlated.
    """
    check_scene(scene)
    _ = observation.folded  # refuses a record that is too short, before anything is computed
    motion = settled_motion(scene)
    alignment = align(observation, motion)
    # A body at rest fits with any shift.
    shift = 0.0 if math.isnan(alignment.shift) else alignment.shift
    trough_time = observation.time + shift
    recorded, observation = observation, observation.relative_to(motion, shift)
    signals = observation.model(motion, trough_time)
    cycle = np.linspace(0.0, motion.period, TOL.curve)
    curves = observation.model(motion, cycle)
    if "displacement" in signals:
        offset = float((observation.signals["displacement"] - signals["displacement"]).mean())
        signals["displacement"] = signals["displacement"] + offset
        curves["displacement"] = curves["displacement"] - curves["displacement"][0]
    rows = _means(observation, motion)
    folded = observation.folded
    if "velocity" in folded or "displacement" in folded:
        velocity = folded["velocity"] if "velocity" in folded else folded["displacement"].derivative()
        clocked = _Clocked(velocity, shift, alignment.error, motion if recorded.absolute else None)
        rows += _speeds(clocked, motion)
    rows += _misfits(observation, signals)
    passing = "upwards" if scene.amplitude is not None else "forwards" if scene.along_amplitude else ""
    seen = (scene, observation, motion, alignment, tuple(rows))
    return Comparison(*seen, trough_time, passing, signals, cycle, curves, recorded)


def _means(observation: Observation, motion: SettledMotion) -> list[Row]:
    """Compare advance, mean speed and its drift, from the displacement or else from the velocity."""
    powers, period = {"displacement": 1, "velocity": 0}, observation.period
    name = next((name for name in powers if name in observation.signals), None)
    if name is None:
        return []
    power, mean = powers[name], observation.folded[name].trend(powers[name])
    curved = fold(observation.time, observation.signals[name], observation.frequency, power + 2)
    drift = curved.trend(power + 1).scaled((power + 1) * 2.0 * curved.half)
    advance, period_error = mean.scaled(period), period * observation.frequency_error / observation.frequency
    advance = advance._replace(error=math.hypot(advance.error, mean.value * period_error))
    return [
        Row("stroke_advance", "displacement", advance, motion.advance),
        Row("mean_speed", "velocity", mean, motion.advance / period),
        Row("drift", "velocity", drift, 0.0),
    ]


@dataclass(frozen=True, eq=False)
class _Clocked:
    """A folded velocity over trough time: the record's time plus a shift with an error [s].

    With a ``subtracted`` motion, that of its trough was subtracted at this shift, with the same error.
    """

    folded: Folded
    shift: float
    clock_error: float
    subtracted: SettledMotion | None = None

    def at(self, time: Floats) -> Floats:
        return self.folded.fitted(time - self.shift)

    def estimate(self, time: float) -> Estimate:
        at = np.array([time - self.shift])
        late = self._known_clock_error * abs(self._trough_slope(time))
        return Estimate(float(self.folded.fitted(at)[0]), math.hypot(float(self.folded.error(at)[0]), late))

    @property
    def _known_clock_error(self) -> float:
        return 0.0 if math.isnan(self.clock_error) else self.clock_error

    def _trough_slope(self, time: float) -> float:
        """Return the acceleration of the trough that was subtracted."""
        return float(self.subtracted.trough(np.array([time]))["acceleration"][0]) if self.subtracted else 0.0

    def passing(self, time: float) -> Estimate:
        """Return a time at which a speed is passed, with its error from those of speed and clock."""
        at = np.array([time - self.shift])
        slope = float(self.folded.derivative().periodic(at)[0])
        error = float(self.folded.error(at)[0]) / abs(slope) if slope else math.nan
        # A clock that is late moves the velocity as it was recorded.
        late = self._known_clock_error * abs(1.0 + self._trough_slope(time) / slope if slope else 1.0)
        return Estimate(time, math.hypot(error, late))


def _speeds(velocity: _Clocked, motion: SettledMotion) -> list[Row]:
    """Compare peak speed, speed at rest, start and end of every slide."""
    cycle = np.arange(TOL.fine) * motion.period / TOL.fine
    model = motion.sample(cycle).velocity
    value, error = velocity.estimate(float(cycle[np.argmax(np.abs(velocity.at(cycle)))]))
    peak = Estimate(abs(value), error)
    rows = [Row("peak_speed", "velocity", peak, float(np.abs(model).max()))]
    rest = _middle_of_rest(motion)
    if rest is not None:
        creep = velocity.estimate(rest)
        rows.append(Row("rest_speed", "velocity", creep, 0.0))
    if "H" not in motion.pattern:  # next to a flight a slide may start or end at any speed
        for phase in motion.phases:
            rows += _slide(velocity, motion, phase) if phase.kind in _WAYS else []
    return rows


def _slide(velocity: _Clocked, motion: SettledMotion, phase: Phase) -> list[Row]:
    """Compare start and end of a slide, where measured and computed speed pass the same level."""
    way = _WAYS[phase.kind]
    name = "forward" if way > 0 else "back"
    inside = phase.start + (phase.end - phase.start) * np.linspace(0.0, 1.0, TOL.fine)
    speed = way * motion.sample(inside).velocity
    level = TOL.slide_level * float(speed.max())
    fast = inside[speed >= level].tolist()
    rows = []
    for key, reached, rising in (("start", fast[0], True), ("end", fast[-1], False)):
        seen = _crossing(velocity, way, level, reached, rising, motion.period)
        rows.append(Row(f"{name}_slip_{key}", "time", seen, reached))
    return rows


def _middle_of_rest(motion: SettledMotion) -> float | None:
    """Return the middle of the longest rest of a cycle, as a trough time [s]."""
    rests = [phase for phase in motion.phases if phase.kind == "_" and motion.slides]
    longest = max(rests, key=lambda phase: phase.end - phase.start, default=None)
    return 0.5 * (longest.start + longest.end) if longest else None


def _crossing(
    velocity: _Clocked, way: int, level: float, near: float, rising: bool, period: float
) -> Estimate:
    """Return the trough time nearest to ``near`` at which the folded velocity passes a level."""
    time = near + period * (np.arange(TOL.fine + 1) / TOL.fine - 0.5)
    excess = way * velocity.at(time) - level
    above = excess >= 0.0
    passed = np.flatnonzero(above[1:] & ~above[:-1] if rising else above[:-1] & ~above[1:])
    if not passed.size:
        return Estimate(math.nan, math.nan)
    i = int(passed[np.argmin(np.abs(time[passed] - near))])
    step = excess[i] / (excess[i] - excess[i + 1])
    return velocity.passing(float(time[i] + (time[i + 1] - time[i]) * step))


def _misfits(observation: Observation, computed: Mapping[str, Floats]) -> list[Row]:
    """Return root mean squares of measured minus computed; of a displacement also without its trend."""
    residuals = {name: values - computed[name] for name, values in observation.signals.items()}
    if "displacement" in residuals:
        plain = detrended(observation.time, residuals["displacement"], 1)
        residuals["displacement without trend"] = plain
    rows = []
    for text, values in residuals.items():
        rms = Estimate(float(np.sqrt(np.mean(values**2))), math.nan)
        key, kind = f"rms_{text.replace(' ', '_')}", text.partition(" ")[0]
        rows.append(Row(key, kind, rms, math.nan))
    return rows


def _of_another_size(observation: Observation, motion: SettledMotion) -> list[str]:
    """Warn of signals so much larger or smaller than computed that their unit may be wrong."""
    found = []
    for name, model in observation.model(motion, observation.time).items():
        # The slope of a displacement is its conveying speed.
        degree = int(name == "displacement")
        measured, computed = (
            float(np.std(detrended(observation.time, x, degree))) for x in (observation.signals[name], model)
        )
        if computed and measured and not 1.0 / TOL.far_off <= measured / computed <= TOL.far_off:
            what = doubt(observation.sensitivities.get(name, "")) + " Is the mass?" * (name == "friction")
            times = rounded(measured / computed)
            found.append(f"the {name} is about {times} times the computed one: {what}")
    return found


def _of_a_change(observation: Observation) -> list[str]:
    """Warn of a motion whose amplitude or frequency changes over the record."""
    name = next((name for name in _DERIVATIVES if name in observation.signals), "")
    if not name:
        return []
    folded, time = observation.folded[name], observation.time
    cosines, sines = folded.coefficients[folded.trends :].reshape(2, -1)[:, :1]
    size, values = math.hypot(float(sines[0]), float(cosines[0])), observation.signals[name]
    if size <= TOL.rounding * float(np.abs(values).max()):  # there is no wave that could change
        return []
    left = (values - folded.fitted(time))[:, None] / size  # whose squares are doubles too
    wave = sines / size + 1j * (cosines / size)
    envelope = envelope_of(time, left, wave, np.ones(1), observation.frequency)
    change = change_of(envelope, size / (math.tau * observation.frequency) ** _DERIVATIVES[name])
    if envelope.p_value > TOL.by_chance or not change.is_seen:
        return []
    return [f"the part's motion is not steady: {change.text}; --from and --to choose a part of the record"]


def _of_another_frequency(observation: Observation) -> list[str]:
    """Warn of data that repeat at another frequency than the drive's."""
    foreign = foreign_frequency(observation)
    if foreign is None:
        return []
    found, error = foreign.frequency
    off = max(error, TOL.proposed / float(np.ptp(observation.time)))
    plain = next(text for digits in range(18) if abs(float(text := f"{found:.{digits}f}") - found) <= off)
    at, remedy = f"{found:.5g} Hz", f"give the frequency {plain}Hz"
    if observation.clock is not None:
        trough = f"the trough at {observation.frequency:.5g} Hz"
        return [
            f"the body's signals repeat at {at}, {trough}: are both from the same run, with the same clock?"
        ]
    if foreign.cycles:
        why = "the body hops so, or the drive runs at that frequency"
        return [f"the data repeat at {at}, every {foreign.cycles} cycles of the drive: {why}: {remedy}"]
    return [f"the data repeat at {at}, the scene says {observation.frequency:.5g} Hz: {remedy}"]


def _of_another_clock(observation: Observation, motion: SettledMotion, clock: Alignment) -> list[str]:
    """Warn if the body's signals alone would place the record elsewhere in the cycle."""
    own = clock if observation.clock is None else align(replace(observation, clock=None), motion)
    off = math.remainder(own.shift - clock.shift, motion.period)
    least = max(TOL.sigmas * math.hypot(own.error, clock.error), TOL.clocks_apart * motion.period)
    if not abs(off) > least:
        return []
    apart = f"{1e3 * off:+.3g} ms ({360.0 * off / motion.period:+.0f} deg)"
    why = "a channel lags or is inverted, or the body does not move as computed"
    return [f"by its own signals the body is {apart} from where the trough's sensor has it: {why}"]
