"""Find the slowest or the fastest body in contact, and prove that none is much slower, or faster.

An evolution moves to an extreme body; branch and bound covers the whole set by small boxes, each with a bound
of its own (theory, section 14). They share the speed of a single body alone: what the evolution misses by
more than the gap that is left, the bounds find, and the evolution starts anew from there.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, Final, NamedTuple

import numpy as np

from vibro.core.boxes import AXES, BETA
from vibro.core.codes import Regime
from vibro.core.compiled import doors
from vibro.inverse.proofs import corners, steeper_is_slower
from vibro.inverse.search import sobol
from vibro.inverse.spaces import Points
from vibro.results.designs import Certificate
from vibro.solver import lasting

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from vibro.inverse.spaces import UncertaintySet

    Floats = NDArray[np.float64]

__all__ = ["Slowest", "slowest_in_contact", "small_speed"]

_GAP: Final = 1e-3  # [1] relative distance of the proved bound from the slowest body at which the proof ends
_POPULATION: Final = 64
_GENERATIONS: Final = 300
_SEED: Final = 1
_SMALL: Final = 1e-2  # [1] share of the trough's largest speed
_BETTER: Final = 1e-12  # [1] by which a body that the bounds have met must be slower, to start anew


class Slowest(NamedTuple):
    """Bodies that the search has computed, the slowest one first, and the proved bound on all.

    Attributes
    ----------
    points : Points
        The bodies.
    speeds : array
        Theirs, with the sign turned where the fastest body is sought [m/s]; inf where unknown.
    certificate : Certificate or None
        Boxes that cover the set; None without a proof.
    """

    points: Points
    speeds: Floats
    certificate: Certificate | None


def slowest_in_contact(
    box: UncertaintySet, *, fast: bool, boxes: int, highest: Regime = Regime.HOPPING
) -> Slowest:
    """Search a single box, some band of which has a width.

    Parameters
    ----------
    box : UncertaintySet
        The box; bodies that hop are left out.
    fast : bool
        Whether to find the fastest body instead of the slowest.
    boxes : int
        Most boxes of the proof.
    highest : Regime
        A body in a higher regime is slower, or faster, than all others.
    """
    hops = box.may_hop
    spans = _spans(box)
    trough = spans[BETA].copy()
    if not hops and steeper_is_slower(box) and not _may_run_away(box):
        spans[BETA] = trough[0 if fast else 1]  # Eq. (53)
    low, high = np.ascontiguousarray(spans.T)
    ratios = box.second_friction if box.is_ratio else (0.0, 1.0)
    numbers = *ratios, *box.factor, *box.frequency, box.gravity, -1.0 if fast else 1.0
    solver = doors()

    def scene() -> tuple[Any, ...]:
        ends = solver.row(low), solver.row(high)
        return *ends, len(box.shape) > 1, *map(float, numbers), int(highest)

    def evolved(first: Floats) -> tuple[Floats, Floats]:
        points = np.ascontiguousarray(np.vstack([first, first[:1]]))
        speeds = np.empty(len(points))

        def evolve() -> Any:
            population = solver.row(points), solver.row(speeds)
            return solver.evolve(scene(), population, len(first), _GENERATIONS, _SEED)

        lasting(evolve)
        order = np.argsort(speeds[:-1], kind="stable")
        return points[order], speeds[order]

    points, speeds = evolved(_first(low, high))
    if hops:
        return Slowest(_points(box, points), speeds, None)
    lows, highs, bounds = np.empty((boxes, AXES)), np.empty((boxes, AXES)), np.empty(boxes)
    heap, met, speed = np.empty(boxes, np.int64), np.vstack([points[0]] * 2), speeds[:1].copy()

    def cover() -> Any:
        room = tuple(map(solver.row, (lows, highs, bounds, heap, met, speed)))
        return solver.cover(scene(), room, _GAP, small_speed(box), boxes)

    count = lasting(cover)
    lows, highs, bounds = lows[:count], highs[:count], bounds[:count]
    is_slower = speed[0] < speeds[0] - _BETTER * abs(speeds[0])
    if is_slower or count == boxes:
        near = np.argsort(bounds)[: _POPULATION - 1]
        first = 0.5 * (lows[near] + highs[near])
        anew = evolved(np.vstack([met[:1], first]) if is_slower else first)
        points, speeds = min((points, speeds), anew, key=lambda found: found[1][0])
    if low[BETA] == high[BETA]:  # such a bound holds for flatter troughs too
        lows[:, BETA], highs[:, BETA] = trough
    names = ("load", *box.shape, "trough_angle", "static_friction", "kinetic_friction")
    columns = [0, *range(1, 1 + len(box.shape)), *range(BETA, AXES)]
    below, above = (dict(zip(names, x[:, columns].T, strict=True)) for x in (lows, highs))
    return Slowest(_points(box, points), speeds, Certificate(below, above, -bounds if fast else bounds))


def small_speed(box: UncertaintySet) -> float:
    """Return a share of the trough's largest speed: speeds of a single box below it are alike small [m/s]."""
    sizes = [high for name, (_, high) in box.shape.items() if name.endswith("amplitude")]
    amplitude = box.factor[1] * max(sizes, default=1.0)
    return float(_SMALL * 2.0 * math.pi * box.frequency[1] * amplitude)


def _spans(box: UncertaintySet) -> Floats:
    """Return the bands of the solver's coordinates, of shape (AXES, 2)."""
    static = [np.asarray(end) for end in box.static_span]
    kinetic = box.kinetic_span(static[0])[0], box.kinetic_span(static[1])[1]
    unused = ((0.0, 0.0),) * (BETA - 1 - len(box.shape))
    return np.array([box.load, *box.shape.values(), *unused, box.trough_angle, static, kinetic], np.float64)


def _first(low: Floats, high: Floats) -> Floats:
    """Return the first population: corners, and points that fill the box evenly."""
    free = high > low
    ends = corners(free)
    inside = np.zeros((AXES, max(_POPULATION - ends.shape[1], _POPULATION // 2)))
    inside[free] = sobol(int(free.sum()), math.ceil(math.log2(inside.shape[1])), _SEED)[:, : inside.shape[1]]
    shares = np.hstack([ends, inside]).T
    return np.where(shares == 1.0, high, np.minimum(low + shares * (high - low), high))


def _points(box: UncertaintySet, x: Floats) -> Points:
    """Return the bodies at rows of the solver's coordinates."""
    load, *shape = x.T[: 1 + len(box.shape)]
    beta, mu_s, mu_d = x.T[BETA:]
    return Points(load, tuple(shape), beta, mu_s, np.clip(mu_d, *box.kinetic_span(mu_s)))


def _may_run_away(box: UncertaintySet) -> bool:
    """Whether the weight component along the trough exceeds kinetic friction for some body, up or down."""
    least, _ = box.kinetic_span(np.asarray(box.static_span[0]))
    return bool(least <= math.tan(max(abs(angle) for angle in box.trough_angle)))
