"""The conveying speed of a measured motion and its distance to the hop, with standard errors."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from vibro.core.codes import Regime, Status
from vibro.records.folding import Estimate, Floats
from vibro.records.tolerances import TOL
from vibro.records.waveforms import MeasuredMotion, Motions
from vibro.scene import Scene
from vibro.steady import solve


class HopOnset(NamedTuple):
    """How far a measured motion is from lifting parts off the trough.

    Attributes
    ----------
    throw_number : Estimate
        Largest downward acceleration normal to the trough over that of gravity; above 1 parts hop.
    growth : Estimate
        Factor of the whole motion, all harmonics alike, at which it is 1; inf of a motion along the trough
        alone.
    amplitudes : mapping of str to Estimate
        Amplitudes of the first harmonic then, by the names of the scene's fields: of a line, or both of an
        ellipse [m]. Empty where nothing makes parts hop.
    """

    throw_number: Estimate
    growth: Estimate
    amplitudes: Mapping[str, Estimate]


@dataclass(frozen=True, eq=False)
class Speeds:
    """The conveying speed of a measured motion.

    Attributes
    ----------
    speed : Estimate
        Of the motion that was measured; its error is the standard deviation of the draws that have a speed,
        NaN with fewer than two [m/s].
    regime : Regime
        Of the motion that was measured.
    status : Status
        Whether its speed is exact, or why there is none.
    draws : int
        Number of draws.
    shares : mapping of Regime to float
        Share of the draws in each regime that occurs, the most frequent first.
    unknown : float
        Share of the draws without a speed.
    last_harmonic : float
        Change of the speed by the last harmonic; NaN with one harmonic, or where a speed is unknown [m/s].
    calibrations : mapping of str to float
        Largest change of the speed by a wrong ``gain`` of a sensor, a ``tilt`` of both, and a ``delay``
        between two, each of its usual size; NaN if unknown [m/s].
    """

    speed: Estimate
    regime: Regime
    status: Status
    draws: int
    shares: Mapping[Regime, float]
    unknown: float
    last_harmonic: float
    calibrations: Mapping[str, float]


def speeds_of(measured: MeasuredMotion, others: Mapping[str, float], draws: int = TOL.draws) -> Speeds:
    """Solve a measured motion, draws of its noise, and variants of it.

    Parameters
    ----------
    measured : MeasuredMotion
        The motion.
    others : mapping of str to float
        The fields of ``Scene`` besides the drive's: friction at least [SI].
    draws : int
        Number of draws.
    """
    motion = measured.motion
    variants = {
        "as it is": [motion],
        "last": [motion.up_to(measured.order - 1)] if measured.order > 1 else [],
    }
    variants |= _miscalibrated(motion, sensors=len(measured.channels))
    cycle = solve(Scene(**_stacked([m for made in variants.values() for m in made]).drive(), **others))
    sample = solve(Scene(**measured.drawn(draws).drive(), **others))

    ends = np.cumsum([len(made) for made in variants.values()])
    found = dict(zip(variants, np.split(cycle.mean_velocity, ends[:-1]), strict=True))
    speed = float(found.pop("as it is")[0])
    last = found.pop("last")
    known = sample.mean_velocity[np.isfinite(sample.mean_velocity)]
    regimes, counts = np.unique(sample.regime, return_counts=True)
    shares = {Regime(int(regimes[i])): float(counts[i]) / draws for i in np.argsort(-counts, kind="stable")}
    return Speeds(
        speed=Estimate(speed, float(known.std(ddof=1)) if known.size > 1 else math.nan),
        regime=Regime(int(cycle.regime[0])),
        status=Status(int(cycle.status[0])),
        draws=draws,
        shares=shares,
        unknown=1.0 - known.size / draws,
        last_harmonic=speed - float(last[0]) if last.size else math.nan,
        calibrations={name: float(np.abs(x - speed).max()) for name, x in found.items() if x.size},
    )


def change_by_harmonics(measured: MeasuredMotion, others: Mapping[str, float]) -> float:
    """Return by how much the harmonics change the speed of the fundamental alone, relative to that [1].

    NaN where a speed is unknown, inf where the fundamental alone conveys nothing. Parameters are those of
    ``speeds_of``.
    """
    both = _stacked([measured.motion, measured.motion.up_to(1)])
    speed, first = (float(x) for x in solve(Scene(**both.drive(), **others)).mean_velocity)
    if speed == first:
        return 0.0
    return (speed - first) / abs(first) if first else math.copysign(math.inf, speed)


def hop_onset(measured: MeasuredMotion, others: Mapping[str, float], draws: int = TOL.draws) -> HopOnset:
    """Return the throw number of a measured motion and where it becomes 1; friction changes neither.

    Parameters are those of ``speeds_of``. Errors are standard deviations of the draws.
    """
    frictionless = {"static_friction": 0.0, "kinetic_friction": 0.0}
    motions = (measured.motion, measured.drawn(draws))
    known, sample = (
        solve(Scene(**motion.drive(), **{**others, **frictionless})).throw_number for motion in motions
    )

    def estimate(value: Floats, values: Floats) -> Estimate:
        return Estimate(float(value), float(np.std(values, ddof=1)))

    throw = estimate(known, sample)
    if not throw.value:
        return HopOnset(throw, Estimate(math.inf, 0.0), {})
    now, drawn = (
        {"along_amplitude": abs(motion.along[0]), "normal_amplitude": abs(motion.normal[0])}
        for motion in motions
    )
    if not measured.trough.on_an_ellipse:
        now, drawn = ({"amplitude": np.hypot(*sizes.values())} for sizes in (now, drawn))
    # The throw number is proportional to the whole motion.
    amplitudes = {name: estimate(now[name] / known, drawn[name] / sample) for name in now}
    return HopOnset(throw, estimate(1.0 / known, 1.0 / sample), amplitudes)


def _miscalibrated(motion: Motions, sensors: int) -> dict[str, list[Motions]]:
    """Return the motions that wrong calibrations of the sensors would make of a measured one."""
    gains = (1.0 + TOL.gain, 1.0 - TOL.gain)
    tilted = [motion.turned(TOL.tilt), motion.turned(-TOL.tilt)]
    if sensors == 1:  # it gives both motions: one gain for both, and no lag
        return {"gain": [motion.scaled(gain, gain) for gain in gains], "tilt": tilted}
    one_gain = [motion.scaled(along=gain) for gain in gains] + [motion.scaled(normal=gain) for gain in gains]
    delayed = [motion.delayed(TOL.delay), motion.delayed(-TOL.delay)]
    return {"gain": one_gain, "tilt": tilted, "delay": delayed}


def _stacked(motions: list[Motions]) -> Motions:
    """Put single motions into one with an axis."""
    arrays = [(m.frequency, m.along, m.normal) for m in motions]
    frequency, along, normal = (np.stack(parts, axis=-1) for parts in zip(*arrays, strict=True))
    return Motions(frequency, along, normal)
