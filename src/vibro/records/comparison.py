"""A measured record compared with the exact steady motion."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Final, NamedTuple

import numpy as np

from vibro.motion.settled import SettledMotion, settled_motion
from vibro.records.alignment import Alignment, Observation, align, check_scene, computed
from vibro.records.folding import Estimate, fold
from vibro.records.frequencies import foreign_frequency
from vibro.records.signals import FAR_OFF, doubt, rounded

if TYPE_CHECKING:
    from collections.abc import Mapping

    from numpy.typing import NDArray

    from vibro.records.folding import Folded
    from vibro.results.history import Phase
    from vibro.scene import Scene

    Floats = NDArray[np.float64]

__all__ = ["Comparison", "Row", "compare"]

_THRESHOLD: Final = 0.1  # of a slide's computed peak speed: the level that marks its start and end
_FINE: Final = 4096  # points per cycle at which folded signals are searched
_CURVE: Final = 1001  # points of a smooth curve
_ASTRAY: Final = 0.01  # cycles by which a frequency that is proposed may drift from the data over the record
_SIGMAS: Final = 4.0  # between the clock of the trough and that of the body: less is no difference,
_APART: Final = 0.02  # nor is less than this share of a cycle
_OPPOSITE: Final = 0.06  # of a cycle: as near to half of one
_WAYS: Final = {"F": 1, "B": -1}
_NAN: Final = Estimate(math.nan, math.nan)


class Row(NamedTuple):
    """One quantity, measured and computed.

    Attributes
    ----------
    key : str
        Name for tables.
    label : str
        Name in words.
    kind : str
        ``displacement``, ``velocity``, ``time``, ``acceleration`` or ``friction``: values are in SI units.
    measured : Estimate
        With its standard error; NaN where the record does not show it.
    computed : float
        The model's value; NaN where there is none.
    """

    key: str
    label: str
    kind: str
    measured: Estimate
    computed: float


@dataclass(frozen=True, eq=False)
class Comparison:
    """A record and the model on one clock.

    Attributes
    ----------
    observation : Observation
        The record.
    motion : SettledMotion
        The model.
    alignment : Alignment
        Trough time of the record's clock.
    rows : tuple of Row
        Measured and computed quantities.
    trough_time : array
        Trough time of each sample; the trough passes its middle at whole periods, as ``passing`` says [s].
    passing : str
        ``upwards`` along a line, ``forwards`` along an ellipse; empty without a motion along the trough.
    computed : mapping of str to array
        The model's signals at the record's times, by the names of the measured ones; measured and computed
        displacements have the same mean.
    curve_time, curves : array, mapping of str to array
        The same as smooth curves over one cycle of trough time; displacements begin at 0.
    warnings : tuple of str
        Reasons to doubt the comparison.
    """

    observation: Observation
    motion: SettledMotion
    alignment: Alignment
    rows: tuple[Row, ...]
    trough_time: Floats
    passing: str
    computed: Mapping[str, Floats]
    curve_time: Floats
    curves: Mapping[str, Floats]
    warnings: tuple[str, ...]


def compare(scene: Scene, observation: Observation) -> Comparison:
    """Compare a record with the steady motion of a scene.

    Parameters
    ----------
    scene : Scene
        Of shape ().
    observation : Observation
        The record; its drive frequency is the scene's.

    Returns
    -------
    Comparison
        With the record's position in the drive cycle, which the data do not contain.

    Raises
    ------
    InputError
        If the record has too few cycles, or too few samples a cycle, or the scene is of no size that could be
        compared.
    VibroError
        If the scene has no steady motion.

    Notes
    -----
    Mean values come from a regression on a trend and the harmonics of the drive (``folding``), so that whole
    cycles are not needed. Peaks, starts and ends of slides come from its velocity. Errors are one
    standard error of the noise, correlation allowed for.
    """
    check_scene(scene)
    _ = observation.folded  # first of all, because it refuses a record that is too short
    motion = settled_motion(scene)
    alignment = align(observation, motion)
    # A body at rest fits any shift: take none.
    shift = 0.0 if math.isnan(alignment.shift) else alignment.shift
    trough_time = observation.time + shift
    step = observation.sample_time
    signals = computed(motion, observation.signals, trough_time, step)
    cycle = np.linspace(0.0, motion.period, _CURVE)
    curves = computed(motion, observation.signals, cycle, step)
    if "displacement" in signals:
        offset = float((observation.signals["displacement"] - signals["displacement"]).mean())
        signals["displacement"] = signals["displacement"] + offset
        curves["displacement"] = curves["displacement"] - curves["displacement"][0]
    rows = [*_means(observation, motion)]
    velocity = _Velocity.of(observation, shift)
    if velocity is not None:
        rows += _speeds(velocity, motion, alignment)
    rows += _misfits(observation, motion, shift)
    return Comparison(
        observation=observation,
        motion=motion,
        alignment=alignment,
        rows=tuple(rows),
        trough_time=trough_time,
        passing="upwards" if scene.amplitude is not None else "forwards" if scene.along_amplitude else "",
        computed=signals,
        curve_time=cycle,
        curves=curves,
        warnings=_warnings(observation, motion, alignment, signals),
    )


def _means(observation: Observation, motion: SettledMotion) -> list[Row]:
    """Advance, mean speed and its drift, from the displacement if there is one, else from the velocity."""
    folded = observation.folded
    if "displacement" in folded:
        mean = folded["displacement"].trend(1)
        drift = _drift(observation, "displacement")
    elif "velocity" in folded:
        mean = folded["velocity"].trend(0)
        drift = _drift(observation, "velocity")
    else:
        return []
    period = observation.period
    return [
        Row("stroke_advance", "stroke advance", "displacement", _scaled(mean, period), motion.advance),
        Row("mean_speed", "mean speed", "velocity", mean, motion.advance / period),
        Row("drift", "drift of the mean speed over the record", "velocity", drift, 0.0),
    ]


def _drift(observation: Observation, name: str) -> Estimate:
    """Change of the mean speed over the record."""
    power = 2 if name == "displacement" else 1
    folded = fold(observation.time, observation.signals[name], observation.frequency, power + 1)
    return _scaled(folded.trend(power), power * 2.0 * folded.half)


def _scaled(estimate: Estimate, factor: float) -> Estimate:
    return Estimate(estimate.value * factor, estimate.error * factor)


@dataclass(frozen=True, eq=False)
class _Velocity:
    """The folded velocity over trough time, from a velocity or by differentiating a displacement."""

    folded: Folded
    derivative: int
    mean: float
    shift: float

    @classmethod
    def of(cls, observation: Observation, shift: float) -> _Velocity | None:
        folded = observation.folded
        if "velocity" in folded:
            return cls(folded["velocity"], 0, folded["velocity"].trend(0).value, shift)
        if "displacement" in folded:
            return cls(folded["displacement"], 1, folded["displacement"].trend(1).value, shift)
        return None

    def at(self, time: Floats) -> Floats:
        return self.mean + self.folded.periodic(time - self.shift, self.derivative)

    def error(self, time: float) -> float:
        return float(self.folded.error(np.array([time - self.shift]), self.derivative, self.derivative)[0])

    def slope(self, time: float) -> float:
        return float(self.folded.periodic(np.array([time - self.shift]), self.derivative + 1)[0])


def _speeds(velocity: _Velocity, motion: SettledMotion, alignment: Alignment) -> list[Row]:
    """Peak speed, the speed at rest, start and end of every slide."""
    period = motion.period
    cycle = np.arange(_FINE) * period / _FINE
    measured, model = velocity.at(cycle), motion.sample(cycle).velocity
    fastest = int(np.argmax(np.abs(measured)))
    peak = Estimate(abs(float(measured[fastest])), velocity.error(float(cycle[fastest])))
    rows = [Row("peak_speed", "peak speed", "velocity", peak, float(np.abs(model).max()))]
    rest = _middle_of_rest(motion)
    if rest is not None:
        creep = Estimate(float(velocity.at(np.array([rest]))[0]), velocity.error(rest))
        rows.append(Row("rest_speed", "speed in the middle of the rest", "velocity", creep, 0.0))
    if "H" not in motion.pattern:  # next to a flight a slide may start or end at any speed
        for phase in motion.phases:
            if phase.kind in _WAYS:
                rows += _slip(velocity, motion, phase, alignment)
    return rows


def _slip(velocity: _Velocity, motion: SettledMotion, phase: Phase, alignment: Alignment) -> list[Row]:
    """Start and end of a slide: where its speed passes a level, the same for measured and computed speed."""
    way = _WAYS[phase.kind]
    name = "forward" if way > 0 else "back"
    inside = phase.start + (phase.end - phase.start) * np.linspace(0.0, 1.0, _FINE)
    speed = way * motion.sample(inside).velocity
    level = _THRESHOLD * float(speed.max())
    fast = np.flatnonzero(speed >= level)
    rows = []
    for key, label, rising, reached in (
        ("start", "starts", True, float(inside[fast[0]])),
        ("end", "ends", False, float(inside[fast[-1]])),
    ):
        seen = _crossing(velocity, way, level, reached, rising, motion.period)
        error = math.hypot(seen.error, 0.0 if math.isnan(alignment.error) else alignment.error)
        label = f"{name} slip {label} ({1e3 * level:.3g} mm/s)"
        rows.append(Row(f"{name}_slip_{key}", label, "time", Estimate(seen.value, error), reached))
    return rows


def _middle_of_rest(motion: SettledMotion) -> float | None:
    """Middle of the longest rest of a cycle, as a trough time [s]."""
    rests = [phase for phase in motion.phases if phase.kind == "_" and motion.slides]
    longest = max(rests, key=lambda phase: phase.end - phase.start, default=None)
    return 0.5 * (longest.start + longest.end) if longest else None


def _crossing(
    velocity: _Velocity, way: int, level: float, near: float, rising: bool, period: float
) -> Estimate:
    """Trough time nearest to ``near`` at which the folded velocity passes a level."""
    time = near + period * (np.arange(_FINE + 1) / _FINE - 0.5)
    above = way * velocity.at(time) >= level
    passed = np.flatnonzero(above[1:] & ~above[:-1] if rising else above[:-1] & ~above[1:])
    if not passed.size:
        return _NAN
    i = int(passed[np.argmin(np.abs(time[passed] - near))])
    ends = way * velocity.at(time[i : i + 2])
    at = float(time[i] + (time[i + 1] - time[i]) * (level - ends[0]) / (ends[1] - ends[0]))
    slope = abs(velocity.slope(at))
    return Estimate(at, velocity.error(at) / slope if slope else math.nan)


def _misfits(observation: Observation, motion: SettledMotion, shift: float) -> list[Row]:
    """Root mean squares of measured minus computed."""
    rows = []
    for trend in (True, False):
        for name, residual in observation.residuals(motion, shift, trend=trend).items():
            if trend or name == "displacement":
                without = "" if trend else " without trend"
                rms = Estimate(float(np.sqrt(np.mean(residual**2))), math.nan)
                key = f"rms_{name}{without.replace(' ', '_')}"
                rows.append(Row(key, f"RMS difference of {name}{without}", name, rms, math.nan))
    return rows


def _warnings(
    observation: Observation, motion: SettledMotion, alignment: Alignment, model: Mapping[str, Floats]
) -> tuple[str, ...]:
    warnings = []
    if math.isnan(alignment.shift):
        warnings.append("the computed body rests: the position of the data in the cycle cannot be found")
    for rival in alignment.rivals:
        warnings.append(
            f"the data fit almost as well if they begin {1e3 * rival:.4g} ms after the trough's middle"
        )
    warnings += _of_another_size(observation, motion)
    warnings += _of_another_frequency(observation)
    warnings += _of_another_clock(observation, motion, alignment)
    advance = next((r.measured.value for r in _means(observation, motion)), math.nan)
    if advance * motion.advance < 0.0:
        warnings.append("the data run against the computed direction: --reverse reverses their axis")
    if "friction" in model and _oppose(model["friction"], observation.signals["friction"]):
        warnings.append(
            "the friction has the opposite sign: it must be the force on the body, not on the trough"
        )
    return tuple(warnings)


def _of_another_size(observation: Observation, motion: SettledMotion) -> list[str]:
    """Name signals that are so much larger or smaller than computed that their unit may be wrong."""
    cycle = np.arange(_FINE) * motion.period / _FINE
    model = computed(motion, observation.signals, cycle, observation.sample_time)
    found = []
    for name, values in observation.signals.items():
        trend = motion.advance / motion.period * cycle if name == "displacement" else 0.0
        size = float(np.std(model[name] - trend))
        # Noise is no motion, but motion at another frequency is: what repeats may be too much, and all of it
        # too little.
        repeated = float(np.std(observation.folded[name].periodic(cycle)))
        whole = _swing(observation.time, values, 1 if name == "displacement" else 0)
        moved = repeated if repeated > FAR_OFF * size else whole
        # A body that rests has no size, and a signal that is dead no unit.
        if size and whole and not size / FAR_OFF <= moved <= FAR_OFF * size:
            what = doubt(observation.sensitivities.get(name, ""))
            also = " Is the mass?" if name == "friction" else ""
            found.append(f"the {name} is about {rounded(moved / size)} times the computed one: {what}{also}")
    return found


def _swing(time: Floats, values: Floats, power: int) -> float:
    """Root mean square of a signal about its trend, a polynomial."""
    centred = time - time.mean()
    return float(np.std(values - np.polyval(np.polyfit(centred, values, power), centred)))


def _of_another_frequency(observation: Observation) -> list[str]:
    """Name the frequency of data that are not those of the drive."""
    foreign = foreign_frequency(observation)
    if foreign is None:
        return []
    found, error = foreign.frequency
    off = max(error, _ASTRAY / float(np.ptp(observation.time)))
    plain = next(text for digits in range(18) if abs(float(text := f"{found:.{digits}f}") - found) <= off)
    said, remedy = f"{found:.5g} Hz", f"-f {plain}"
    if observation.clock is not None:
        trough = f"the trough at {observation.frequency:.5g} Hz"
        return [f"the body's signals repeat at {said}, {trough}: are both of one run, and of one clock?"]
    if foreign.cycles:
        return [
            f"the data repeat at {said}, every {foreign.cycles} cycles of the drive: the body hops so, or the"
            f" drive runs at that frequency: {remedy}"
        ]
    return [f"the data repeat at {said}, the scene says {observation.frequency:.5g} Hz: {remedy}"]


def _of_another_clock(observation: Observation, motion: SettledMotion, clock: Alignment) -> list[str]:
    """Say where the body's signals alone would place the record in the cycle, if that is elsewhere."""
    if observation.clock is None:
        return []
    own = align(replace(observation, clock=None), motion)
    off = math.remainder(own.shift - clock.shift, motion.period)
    least = max(_SIGMAS * math.hypot(own.error, clock.error), _APART * motion.period)
    if math.isnan(off) or abs(off) < least:
        return []
    where = "later" if off > 0.0 else "earlier"
    why = "a channel lags, or the body does not move as computed"
    if abs(off) > (0.5 - _OPPOSITE) * motion.period:
        why = "one of the sensors may be inverted (--reverse, or a negative sensitivity)"
    apart = f"{1e3 * abs(off):.3g} ms ({360.0 * abs(off) / motion.period:.0f} deg) {where} in the cycle"
    return [f"the body's signals alone fit best {apart} than the trough's acceleration says: {why}"]


def _oppose(one: Floats, other: Floats) -> bool:
    """Whether two signals are correlated negatively; a constant is not."""
    return float((one - one.mean()) @ (other - other.mean())) < 0.0
