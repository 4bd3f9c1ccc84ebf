"""Find the slowest and the fastest body of an uncertainty set: search in contact, sample hops.

Of the settings with one load that of the highest frequency is the slowest (theory, section 14).
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Final, NamedTuple

import numpy as np

from vibro.core.codes import Regime, Status, is_answered
from vibro.inverse.bounds import slowest_in_contact
from vibro.inverse.changes import change_loads
from vibro.inverse.proofs import corners
from vibro.inverse.search import evolve, placed, scatter, sobol
from vibro.inverse.tolerances import TOLERANCES
from vibro.results.steady import SteadyCycle
from vibro.steady import solve

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from vibro.inverse.spaces import Points, UncertaintySet
    from vibro.results.designs import Certificate
    from vibro.scene import Scene

    Floats = NDArray[np.float64]

__all__ = [
    "ANY_LANDING", "Extreme", "Landings", "Seen", "counted", "evolved", "least_of", "look_around",
    "sampled", "searched", "speeds_of", "taken",
]  # fmt: skip

# Standard errors by which a statistical mean is reduced, or increased, before it counts.
_ERRORS: Final = 3.0

_SEED: Final = 1  # of samples
_TRIED: Final = 8  # bodies of a search, the slowest first

# Samples of hopping bodies: base-2 logarithms of those of the first round, and of each round around the
# extreme ones; the second pair for impacts that are not plastic, which take up to a hundred times as long.
_SAMPLES: Final = {False: (11, 7), True: (9, 7)}
_LOOKS: Final = 12  # base-2 logarithm of the samples whose regimes are solved
_LANDINGS: Final = 9  # base-2 logarithm of the samples of landings
_ROUNDS: Final = 3  # of samples closer to the extreme ones

# Base-2 logarithm of the bodies that are looked at first; how many of them begin each of two evolutions,
# beside the corners, once the slowest and once those of an even spread; generations. The second row serves
# where a slower body alone is sought.
_EVOLVED: Final = {False: (11, 48, 60), True: (8, 16, 20)}


@dataclass
class Seen:
    """Regimes and other events at all points solved so far, and how many even samples have a speed."""

    regimes: set[Regime] = field(default_factory=set)
    coexists: bool = False
    excluded: int = 0
    samples: int = 0

    def add(self, cycle: SteadyCycle) -> None:
        """Record the regimes and events of these cycles."""
        self.regimes |= {Regime(code) for code in np.unique(cycle.regime) if code >= 0}
        self.coexists |= bool(np.any(np.asarray(cycle.coexists) > 0))


@dataclass(frozen=True)
class Extreme:
    """The slowest or the fastest body.

    Attributes
    ----------
    speed : float
        Its mean speed [m/s]; infinite if some body has none; NaN if there is no body.
    coordinates : array
        Its unit-cube coordinates, of shape (axes, 1).
    scene : Scene
        The scene of that body.
    """

    speed: float
    coordinates: Floats
    scene: Scene


def speeds_of(
    scene: Scene,
    *,
    fast: bool,
    flight: bool,
    seen: Seen | None = None,
    highest: Regime = Regime.HOPPING,
) -> Floats:
    """Return mean speeds of scenes as ``counted`` does; NaN where a body hops and flight is not wanted.

    A body in a higher regime than ``highest`` counts as slower, or faster, than all others.
    """
    cycle = solve(scene, flight=flight)
    if seen is not None:
        seen.add(cycle)
    speed = counted(cycle, fast=fast)
    return np.where(cycle.regime > highest, np.inf if fast else -np.inf, speed)


class Landings(NamedTuple):
    """Limits on landings: largest impact speed normal to the trough [m/s], largest flight fraction [1]."""

    impact_speed: float = math.inf
    flight_fraction: float = math.inf

    def scaled(self, factor: float) -> Landings:
        """Return the limits multiplied by a factor."""
        return Landings(self.impact_speed * factor, self.flight_fraction * factor)

    @property
    def limited(self) -> bool:
        """Whether there is a limit."""
        return math.isfinite(self.impact_speed) or math.isfinite(self.flight_fraction)

    def broken(self, box: UncertaintySet, points: Points, slow: SteadyCycle) -> NDArray[np.bool_]:
        """Return which points of boxes land too hard, or fly too long; ``slow`` has their slowest bodies.

        At one load landings are hardest at the lowest frequency, where bodies are also the fastest.
        """
        differs = all(np.any(np.not_equal(*span)) for span in (box.factor, box.frequency))
        return self.exceeded(solve(box.scene(points, fast=True)) if self.limited and differs else slow)

    def exceeded(self, cycle: SteadyCycle) -> NDArray[np.bool_]:
        """Return which bodies land too hard or fly too long."""
        too_hard = np.asarray(cycle.impact_velocity > self.impact_speed)
        return too_hard | (cycle.flight_fraction > self.flight_fraction)

    def worst(self, box: UncertaintySet) -> Floats:
        """Return the unit-cube coordinates, (axes, n), of the sampled bodies that exceed the limits most."""
        if not self.limited or not box.may_hop:
            return np.empty((len(box.axes), 0))
        coordinates = corners(box.varies)
        if box.varies.any():
            samples = sobol(int(box.varies.sum()), _LANDINGS, _SEED)
            coordinates = np.hstack([coordinates, placed(box.varies, samples)])
        # at one load landings are hardest at the lowest frequency
        cycle = solve(box.scene(box.points(coordinates), fast=True))
        found = ((cycle.impact_velocity, self.impact_speed), (cycle.flight_fraction, self.flight_fraction))
        worst = [int(np.nanargmax(x)) for x, limit in found if np.nanmax(x, initial=0.0) > limit]
        return coordinates[:, worst]


#: No limit.
ANY_LANDING: Final = Landings()


def counted(cycle: SteadyCycle, *, fast: bool) -> Floats:
    """Mean speeds as they count in a guarantee [m/s].

    A statistical mean is reduced, or increased, by three standard errors. A body that runs away, or whose
    motion is indeterminate, counts as slower, or faster, than all others. NaN if a hopping body was unsolved.
    """
    side = 1.0 if fast else -1.0
    status = np.asarray(cycle.status)
    error = np.where(status == Status.AVERAGED, cycle.mean_velocity_error, 0.0)
    speed = cycle.mean_velocity + side * _ERRORS * error
    lost = ~is_answered(status) & (status != Status.FLIGHT_NOT_MODELLED) & (status != Status.UNRESOLVED)
    return np.where(lost, side * np.inf, speed)


def least_of(speed: Floats) -> Floats:
    """Return the least speed of each row of bodies, ignoring NaN unless all are."""
    known = ~np.isnan(speed)
    return np.where(known.any(axis=1), np.where(known, speed, np.inf).min(axis=1), -np.inf)


def look_around(box: UncertaintySet, seen: Seen) -> None:
    """Record the regimes in a box: at samples, at corners, and beside the corners' critical loads."""
    free, middle = box.varies, np.full((len(box.axes), 1), 0.5)
    samples = [placed(free, sobol(int(free.sum()), _LOOKS, _SEED))] if free.any() else []
    coordinates = np.hstack([corners(free), *samples, middle])
    points = _with_changes(box, box.points(coordinates))
    speeds_of(box.scene(points, fast=False), fast=False, flight=False, seen=seen)


def _with_changes(box: UncertaintySet, points: Points) -> Points:
    """Add points on both sides of every critical load of the corners."""
    ends = box.points(corners(box.varies))
    # the onset load is least where the drive angle equals the angle of friction
    if "drive_angle" in box.shape:
        angle = np.clip(np.arctan(ends.static_friction), *box.shape["drive_angle"])
        ends = ends.joined(ends._replace(shape=(angle,)))
    scene = box.scene(ends, fast=False)
    for load in change_loads(scene).values():
        at = ends.load * np.nan_to_num(load, posinf=np.inf) / scene.load
        for side in (1.0 - TOLERANCES.beside, 1.0 + TOLERANCES.beside):
            points = points.joined(ends._replace(load=np.clip(at * side, *box.load)))
    return points


def evolved(
    box: UncertaintySet, *, fast: bool, seen: Seen, brief: bool, highest: Regime = Regime.HOPPING
) -> Extreme:
    """Return the slowest or the fastest body in contact of a drive whose boxes the solver does not bound.

    Two evolutions move to it, from corners and points that fill the box evenly; arguments as ``searched``.
    Of 140 boxes of random harmonics and steps, as wide as in tests/inverse/test_motions.py, none had among
    32768 points a slower body, or a faster one, by more than 1e-6 of the largest speed.
    """
    free, side, (looks, count, generations) = box.varies, -1.0 if fast else 1.0, _EVOLVED[brief]

    def cost(x: Floats) -> Floats:
        points = box.points(placed(free, x))
        scene, other = (box.scene(points, fast=which) for which in (fast, not fast))
        speed = speeds_of(scene, fast=fast, flight=False, highest=highest)
        # at one load speeds go with 1/f, Eq. (52)
        return np.minimum(side * speed, side * speed * (scene.frequency / other.frequency))

    even, ends = sobol(int(free.sum()), looks, _SEED), corners(free)[free]
    best = even[:, np.argsort(cost(even))[:count]]
    runs = (np.hstack([ends, best]), np.hstack([ends, best[:, :1], even[:, :count]]))
    found = [evolve(cost, first, generations=generations, seed=_SEED) for first in runs]
    x, _ = min(found, key=lambda run: run[1])
    return taken(box, placed(free, x), fast=fast, flight=False, seen=seen, highest=highest)


def searched(
    box: UncertaintySet, *, fast: bool, boxes: int, seen: Seen, highest: Regime = Regime.HOPPING
) -> tuple[Extreme, Certificate | None]:
    """Return the slowest or the fastest of the bodies in contact, and the proof that none is much slower.

    It agrees with the reference designs to 1e-9 (tests/inverse/test_guarantees.py); benchmarks/design.py
    compares it with searches ten times as large.

    Parameters
    ----------
    box : UncertaintySet
        A single box; bodies that hop are left out.
    fast : bool
        Whether to find the fastest body instead of the slowest.
    boxes : int
        Most boxes of the proof.
    seen : Seen
        Records the regimes.
    highest : Regime
        As for ``speeds_of``.
    """
    points, speeds, certificate = slowest_in_contact(box, fast=fast, boxes=boxes, highest=highest)
    found = []
    for i in range(_TRIED):  # rounding may bring a body that is just past a jump to its other side
        at = box.coordinates(points.kept(np.arange(speeds.size) == i))
        found.append(taken(box, at, fast=fast, flight=False, seen=seen, highest=highest))
        speed = -found[i].speed if fast else found[i].speed
        if not speed > speeds[i] or math.isclose(speed, speeds[i], rel_tol=TOLERANCES.searched):
            return found[i], certificate
    return found[0], certificate


def sampled(box: UncertaintySet, *, fast: bool, seen: Seen) -> Extreme:
    """Return the slowest or the fastest of the hopping bodies among samples; NaN if none was found.

    Speeds of hopping bodies are not smooth in any coordinate, which defeats a search. So up to a few thousand
    points of the whole box are sampled, then some around the extreme ones.
    """
    free = box.varies
    first, more = _SAMPLES[box.restitution > 0.0]
    side = -1.0 if fast else 1.0
    met: list[Floats] = []

    def cost(x: Floats) -> Floats:
        points = box.points(placed(free, x))
        costs = np.full(x.shape[1], np.nan)
        hops = box.hops(points)
        if hops.any():
            scene = box.scene(points.kept(hops), fast=fast)
            costs[hops] = side * speeds_of(scene, fast=fast, flight=True, seen=seen)
            seen.excluded += int(np.count_nonzero(np.isnan(costs[hops])))
        met.append(costs)
        return costs

    even = sobol(int(free.sum()), first, _SEED)
    coordinates = np.hstack([corners(free)[free], even])
    x, best = scatter(cost, coordinates, more=2**more, rounds=_ROUNDS, seed=_SEED)
    seen.samples = int(np.count_nonzero(~np.isnan(met[0][-even.shape[1] :])))
    at = placed(free, x)
    if math.isnan(best):
        return Extreme(math.nan, at, box.scene(box.points(at), fast=fast))
    return taken(box, at, fast=fast, flight=True, seen=seen)


def taken(
    box: UncertaintySet,
    coordinates: Floats,
    *,
    fast: bool,
    flight: bool,
    seen: Seen,
    highest: Regime = Regime.HOPPING,
) -> Extreme:
    """Return the slower, or the faster, of the two ends of the frequencies that have one load."""
    scenes = [box.scene(box.points(coordinates), fast=which) for which in (fast, not fast)]
    found = [
        float(speeds_of(scene, fast=fast, flight=flight, seen=seen, highest=highest)[0]) for scene in scenes
    ]
    keys = [-s if fast else s for s in found]
    which = 1 if keys[1] < keys[0] else 0
    return Extreme(found[which], coordinates, scenes[which])
