"""Drives along two axes by their loads: as scenes of the package and as bodies of the walk."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
import pytest
from engines.two_axis_walk import Body, Cycle, NeverEndsError, NeverSettlesError, smallest_rotation

from vibro import Scene, Status, SteadyCycle, solve

if TYPE_CHECKING:
    from collections.abc import Iterator

    from numpy.typing import ArrayLike, NDArray

    Floats = NDArray[np.float64]

TURN = 2.0 * math.pi
EPS = float(np.finfo(float).eps)
GRAVITY = 9.81
FREQUENCY = 20.0
UNIT = GRAVITY / (TURN * FREQUENCY) ** 2  # [m] length of the loads


class Drives(NamedTuple):
    """Loads X w^2/g and Y w^2/g, lead of the normal motion, frictions, trough angle [rad], restitution."""

    along: Floats
    normal: Floats
    lead: Floats
    mu_s: Floats
    mu_d: Floats
    trough: Floats
    e: Floats

    def scene(self, similar: float = 1.0) -> Scene:
        """Make scenes, at another frequency that leaves the loads as they are."""
        return Scene(
            along_amplitude=self.along * UNIT / similar**2,
            normal_amplitude=self.normal * UNIT / similar**2,
            normal_phase=self.lead,
            frequency=FREQUENCY * similar,
            static_friction=self.mu_s,
            kinetic_friction=self.mu_d,
            trough_angle=self.trough,
            gravity=GRAVITY,
            restitution=self.e,
        )

    def solve(self) -> SteadyCycle:
        return solve(self.scene())

    def bodies(self) -> Iterator[Body]:
        for along, normal, lead, mu_s, mu_d, trough, e in zip(*(x.tolist() for x in self), strict=True):
            yield Body(along * UNIT, normal * UNIT, lead, FREQUENCY, mu_s, mu_d, trough, GRAVITY, e)

    def changed(self, **values: ArrayLike) -> Drives:
        return drives(**(self._asdict() | values))

    def scaled(self, by: float | Floats) -> Drives:
        """Change both amplitudes alike."""
        return self.changed(along=self.along * by, normal=self.normal * by)

    def mirrored(self) -> Drives:
        """Let the body see the trough from its other end."""
        lead = self.lead + np.where(self.lead > 0.0, -math.pi, math.pi)
        return self.changed(lead=lead, trough=-self.trough)


def drives(
    along: ArrayLike = 1.0,
    normal: ArrayLike = 0.3,
    lead: ArrayLike = -math.pi / 3.0,
    mu_s: ArrayLike = 0.4,
    mu_d: ArrayLike = 0.3,
    trough: ArrayLike = 0.0,
    e: ArrayLike = 0.0,
) -> Drives:
    """Make drives from values that broadcast, 1-D."""
    values = (np.asarray(x, np.float64) for x in (along, normal, lead, mu_s, mu_d, trough, e))
    return Drives(*(np.array(x).reshape(-1) for x in np.broadcast_arrays(*values)))


def random_drives(
    count: int,
    seed: int,
    *,
    steepest: float = 0.0,
    least_ratio: float = 0.4,
    throw: tuple[float, float] = (0.01, 0.999),
) -> Drives:
    """Draw drives on troughs where a body can rest: level, or up to a share of atan(mu_s) steep."""
    random = np.random.default_rng(seed)
    mu_s = np.exp(random.uniform(np.log(0.05), np.log(1.5), count))
    mu_d = mu_s * random.uniform(least_ratio, 1.0, count)
    trough = random.uniform(-steepest, steepest, count) * np.arctan(mu_s)
    normal = np.exp(random.uniform(math.log(throw[0]), math.log(throw[1]), count)) * np.cos(trough)
    along = mu_d * np.exp(random.uniform(np.log(0.1), np.log(30.0), count))
    return drives(along, normal, random.uniform(-math.pi, math.pi, count), mu_s, mu_d, trough)


def displacement(cycle: SteadyCycle) -> Floats:
    """Displacement a drive cycle, in the unit of the loads."""
    return np.asarray(cycle.displacement_per_cycle / UNIT)


def rounding(all_drives: Drives, cycle: SteadyCycle) -> Floats:
    """Return eps (condition |d| + S): what rounding of the inputs explains of a displacement's error.

    The condition comes from central differences; that of the lead is for changes of pi, since a turn more or
    less of it rounds to that.
    """
    d = displacement(cycle)
    moves = np.zeros(d.shape)
    h = 1e-7
    for name, x in all_drives._asdict().items():
        size = np.full(x.shape, math.pi) if name == "lead" else np.abs(x)
        if name == "e" or not size.any():
            continue
        up, down = (
            displacement(_feasible(all_drives.changed(**{name: x + s * size})).solve()) for s in (h, -h)
        )
        # the way that stays on this side of a threshold
        one_sided = np.fmin(np.abs(up - d), np.abs(d - down)) / h
        central = np.abs(up - down) / (2.0 * h)
        moves += np.where(np.isnan(central), np.nan_to_num(one_sided), central)
    both = np.array([set(text) >= set("FB") for text in cycle.pattern.tolist()])
    scale = np.where(both, np.maximum(all_drives.along, all_drives.normal), np.abs(d))
    return np.asarray(EPS * (moves + scale))


def _feasible(all_drives: Drives) -> Drives:
    return all_drives.changed(mu_s=np.maximum(all_drives.mu_s, all_drives.mu_d))


def rotated(text: str) -> str:
    """Write a pattern as the tables do."""
    first = smallest_rotation(text) if text else 0
    return text[first:] + text[:first]


def compare(some: Drives, tolerance: float = 1e-10) -> dict[str, int]:
    """Compare what the package says with the walk, and count the patterns."""
    cycle, seen = some.solve(), dict[str, int]()
    d = displacement(cycle)
    for i, body in enumerate(some.bodies()):
        here = [f"{x[i]!r}" for x in some]
        try:
            walked = body.settle()
        except NeverEndsError:
            assert cycle.status[i] == Status.RUNAWAY, here
            seen["runaway"] = seen.get("runaway", 0) + 1
            continue
        except NeverSettlesError:
            seen["irregular"] = seen.get("irregular", 0) + 1
            continue
        assert cycle.status[i] == Status.OK, (here, walked.pattern)
        if some.e[i] == 0.0:  # chains of bounces are written otherwise
            assert rotated(str(cycle.pattern[i])) == walked.pattern, here
        assert cycle.period_cycles[i] == walked.period, here
        size = abs(walked.displacement) + max(some.along[i], some.normal[i])
        assert d[i] == pytest.approx(walked.displacement, abs=tolerance * size), here
        _compare_speeds(cycle, i, walked, tolerance, bounces=some.e[i] > 0.0)
        seen[walked.pattern] = seen.get(walked.pattern, 0) + 1
    return seen


def _compare_speeds(cycle: SteadyCycle, i: int, walked: Cycle, tolerance: float, bounces: bool) -> None:
    speed = GRAVITY / (TURN * FREQUENCY)
    assert cycle.peak_velocity[i] / speed == pytest.approx(walked.peak, rel=tolerance)
    # the walk leaves out the smallest bounces
    fraction = 1e-5 if bounces else tolerance
    assert cycle.flight_fraction[i] == pytest.approx(walked.flight_fraction, rel=fraction)
    assert cycle.impact_velocity[i] / speed == pytest.approx(walked.impact, rel=tolerance)
