"""Bound the loads at which the bodies of an uncertainty set change their regime: by corners, else by search.

Results are ratios of a body's load to its critical load. If the largest ratio of a box exceeds 1, some body
is in the regime; if the smallest one does, all are. Ratios are proportional to the amplitude.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, Final, NamedTuple

import numpy as np

from vibro.core.boxes import AXES, BETA
from vibro.core.codes import Regime
from vibro.designs.search import evolve, placed, sobol
from vibro.designs.spaces import Points
from vibro.limits import critical_loads, critical_loads_of_lines, tipping_load, tipping_load_of_lines
from vibro.results.designs import Certificate
from vibro.steady import solve
from vibro.threads import doors

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import NDArray

    from vibro.designs.spaces import UncertaintySet
    from vibro.reals import Floats
    from vibro.scene import Scene


# ------------------------------------------------------------------------------
# Loads at which bodies change their regime, for every kind of drive.

# The field of ``CriticalLoads`` at which each regime begins.
_BEGINS: Final = {
    Regime.FORWARD_SLIP: "forward_onset",
    Regime.BACK_SLIP: "back_slip",
    Regime.HOPPING: "hop",
}


def change_loads(scene: Scene) -> dict[str, Floats]:
    """Return loads at which bodies change their regime, by the names of ``CriticalLoads``.

    Of a given motion those that are closed forms: hop and onsets. inf where a change never happens.
    """
    if scene.motion is None:
        return critical_loads(scene)._asdict()
    cycle, load = solve(scene, output="regimes"), scene.load
    ratios = {
        "hop": cycle.throw_number, "forward_onset": cycle.forward_ratio, "back_onset": cycle.back_ratio,
    }  # fmt: skip
    with np.errstate(divide="ignore", invalid="ignore"):
        return {name: np.asarray(load / ratio) for name, ratio in ratios.items()}


def begin_load(scene: Scene, regime: Regime) -> Floats:
    """Return the load at which a regime begins; inf where it never does.

    Of back slip under a given motion, which may end and begin again, the least load that ``critical_loads``
    finds.
    """
    if regime is Regime.BACK_SLIP:
        return np.asarray(critical_loads(scene).back_slip)
    return np.asarray(change_loads(scene)[_BEGINS[regime]])


def _slip_load(scene: Scene) -> Floats:
    """Return a load below that of the scene if the body slips back, and at least that of the scene if not.

    It is that at which back slip begins. Of a given motion, which may end back slip at higher loads, it is
    the onset of a back slide, but where that is not enough the load of the scene: one steady cycle decides.
    """
    if scene.motion is None:
        return np.asarray(critical_loads(scene).back_slip)
    onset = change_loads(scene)["back_onset"]
    slips = solve(scene, output="regimes").regime >= Regime.BACK_SLIP
    return np.where(slips, onset, np.maximum(onset, scene.load))


_EDGE: Final = 17  # static frictions of each grid along an edge of the box
_SLOPES: Final = 17  # trough angles of each grid, where the first body need not be at an end
_ROUNDS: Final = 8  # refinements of these grids, to 6e-8 of a band
_FIRST: Final = 5  # base-2 logarithm of the first population, beside the corners
_GENERATIONS: Final = 60
_FEWER: Final = 15  # of given motions, whose loads are searched by many steady cycles
_SEED: Final = 1


def corners(varies: NDArray[np.bool_]) -> Floats:
    """Return distinct corners of a box in the unit cube, of shape (axes, n); 0 where a band has no width."""
    ends = np.meshgrid(*((0.0, 1.0) if free else (0.0,) for free in varies), indexing="ij")
    return np.array([end.ravel() for end in ends])


def first_ratio(box: UncertaintySet, regime: Regime) -> float:
    """Return the largest ratio of a load to that at which a regime begins; above 1 some body is in it."""
    most = float(box.load[1])
    if regime is Regime.HOPPING:
        return box.throw_number
    if not box.space.proves:
        return extreme_ratio(box, _critical(regime), largest=True)[0]
    if regime is Regime.BACK_SLIP:
        return _ratio(most, back_slip_load(box))
    # the onset is least at an end of the drive angles, or at the angle of friction, on the flattest trough
    (a_low, a_high), mu_s = box.shape["drive_angle"], box.static_span[0]
    angles = np.array([a_low, a_high, np.clip(math.atan(mu_s), a_low, a_high)])
    onsets = critical_loads_of_lines(angles, mu_s, mu_s, box.trough_angle[0]).forward_onset
    return _ratio(most, np.min(onsets))


def last_ratio(box: UncertaintySet, regime: Regime) -> float:
    """Return the smallest ratio of a load to that at which a regime begins; above 1 every body is in it."""
    if not box.space.proves:
        return extreme_ratio(box, _critical(regime), largest=False)[0]
    least, (b_low, b_high) = float(box.load[0]), box.trough_angle
    if regime is Regime.FORWARD_SLIP:
        return _ratio(least, onset_load(box))
    if regime is Regime.BACK_SLIP:
        return _ratio(least, back_slip_load(box, last=True))
    flattest = 1.0 if b_low < 0.0 < b_high else np.maximum(np.cos(b_low), np.cos(b_high))
    with np.errstate(divide="ignore"):  # spelled as ``hop_load`` is: without bands first and last are equal
        return _ratio(least, np.divide(flattest, np.sin(box.shape["drive_angle"][0])))


def slip_ratio(box: UncertaintySet) -> tuple[float, Floats]:
    """Return a ratio that is above 1 if a body of a single box slips back, and where it is largest."""
    return extreme_ratio(box, _slip_load, largest=True)


def tip_ratio(box: UncertaintySet, stand_ratio: float) -> float:
    """Return the largest ratio of a load to that at which a part tips; 0 where none can."""
    if math.isinf(stand_ratio):
        return 0.0
    if box.space.proves:
        return _ratio(box.load[1], tip_load(box, stand_ratio))
    return extreme_ratio(box, lambda scene: tipping_load(scene, stand_ratio), largest=True)[0]


def _ratio(load: Floats | float, critical: Floats | float) -> float:
    """Divide a load by a critical one, which may be 0 or inf."""
    with np.errstate(divide="ignore"):
        return float(np.divide(load, critical))


def _critical(regime: Regime) -> Callable[[Scene], Floats]:
    return lambda scene: begin_load(scene, regime)


def extreme_ratio(
    box: UncertaintySet, critical_load: Callable[[Scene], Floats], *, largest: bool
) -> tuple[float, Floats]:
    """Search a single box for the largest, or the smallest, load over a critical load.

    Parameters
    ----------
    box : UncertaintySet
        A single box.
    critical_load : callable
        Returns that load of scenes.
    largest : bool
        Which of the two.

    Returns
    -------
    ratio, coordinates : float, (axes, 1) array
        The ratio, and where it is.
    """
    free = box.in_contact.varies  # no critical load depends on restitution
    side = -1.0 if largest else 1.0

    def ratios(coordinates: Floats) -> Floats:
        scene = box.scene(box.points(coordinates), fast=True)
        with np.errstate(divide="ignore", invalid="ignore"):
            return np.asarray(scene.load / critical_load(scene))

    best = np.zeros((0, 1))
    if free.any():
        first = np.hstack([corners(free)[free], sobol(int(free.sum()), _FIRST, _SEED)])
        generations = _GENERATIONS if box.space.is_bounded else _FEWER
        best, _ = evolve(lambda x: side * ratios(placed(free, x)), first, generations=generations, seed=_SEED)
    return float(ratios(placed(free, best))[0]), placed(free, best)


def regime_loads(box: UncertaintySet, highest: Regime) -> dict[str, Floats]:
    """Return the loads up to which every body on a line keeps to a regime, by the constraint that ends it."""
    loads = {}
    if highest is not Regime.HOPPING:
        loads["hop"] = box.hop_load
    if highest is Regime.FORWARD_SLIP:
        loads["back slip"] = back_slip_load(box)
    return loads


def onset_load(box: UncertaintySet) -> Floats:
    """Load above which the last body starts forward, Eq. (5).

    Over the drive angle it has one minimum, over the trough angle one maximum.
    """
    mu_s, angles = box.static_friction[1], box.shape["drive_angle"]
    hardest = np.clip(0.5 * np.pi - np.arctan(mu_s), *box.trough_angle)
    return np.maximum(*(critical_loads_of_lines(a, mu_s, mu_s, hardest).forward_onset for a in angles))


def back_slip_load(box: UncertaintySet, *, last: bool = False) -> Floats:
    """Load above which the first body, or the last, slips back.

    It rises with static friction and the drive angle and falls with kinetic friction and the trough angle
    (theory, section 14): a corner of the box. Two cases are searched: on a decline, where kinetic friction
    goes along with the static one, the edge of static frictions; where mu_s tan |beta| >= 1, trough angles.
    """
    sign = -1.0 if last else 1.0
    low, high = (np.asarray(end, np.float64) for end in box.trough_angle)
    load = _back_slip_load(box, low if last else high, sign)
    if np.all(low == high):
        return sign * load
    load = np.minimum(load, _back_slip_load(box, high if last else low, sign))
    if steeper_is_slower(box):
        return sign * load
    # So high a friction holds better on a steeper trough, and the extreme may lie between both ends. There
    # it is the only one (measured), which refined grids find.
    for _ in range(_ROUNDS):
        angles = np.linspace(0.0, 1.0, _SLOPES)
        betas = [low + share * (high - low) for share in angles]
        loads = np.array(np.broadcast_arrays(*(_back_slip_load(box, beta, sign) for beta in betas)))
        best = np.argmin(loads, axis=0)
        load = np.minimum(load, loads.min(axis=0))
        width = high - low
        low, high = (low + width * angles[np.clip(best + side, 0, _SLOPES - 1)] for side in (-1, 1))
    return sign * load


def _back_slip_load(box: UncertaintySet, beta: Floats | float, sign: float) -> Floats:
    """Return the least ``sign`` times load of back slip at one trough angle: sign -1 is of the last body."""
    first = sign > 0.0
    alpha = box.shape["drive_angle"][0 if first else 1]
    low, high = box.static_span

    def load(mu_s: Floats) -> Floats:
        mu_d = box.kinetic_span(mu_s)[1 if first else 0]
        return sign * np.asarray(critical_loads_of_lines(alpha, mu_s, mu_d, beta).back_slip)

    kinetic = [box.kinetic_span(end)[1 if first else 0] for end in (low, high)]
    if np.all(np.asarray(beta) >= 0.0) or np.all(kinetic[0] == kinetic[1]):
        return load(np.asarray(low if first else high))
    start, end = (np.asarray(x, np.float64) for x in (low, high))
    for _ in range(_ROUNDS):
        mu_s = start + np.linspace(0.0, 1.0, _EDGE) * (end - start)
        loads = load(mu_s)
        best = np.argmin(loads, axis=-1)[..., None]
        around = (np.clip(best + side, 0, _EDGE - 1) for side in (-1, 1))
        start, end = (np.take_along_axis(np.broadcast_to(mu_s, loads.shape), i, -1) for i in around)
    least = np.take_along_axis(loads, best, -1)
    return least if np.ndim(alpha) else least[..., 0]


def tip_load(box: UncertaintySet, stand_ratio: float) -> Floats:
    """Load up to which no edge of any part lifts that starts from rest, Eq. (43); inf where none can.

    The onset that decides is least at an end of each band, or at the angle whose tangent is the stand ratio.
    """
    least = math.atan(stand_ratio)
    (a_low, a_high), mu_s = box.shape["drive_angle"], box.static_friction[1]
    loads = [
        tipping_load_of_lines(alpha, mu_s, beta, stand_ratio)
        for alpha in (a_low, a_high, np.clip(least, a_low, a_high))
        for beta in box.trough_angle
    ]
    return np.asarray(np.min(np.broadcast_arrays(*loads), axis=0))


def is_braked(box: UncertaintySet) -> bool:
    """Whether kinetic friction outweighs the weight down the trough for every body that slides forward."""
    steepest = box.trough_angle[0]
    kinetic, _ = box.kinetic_span(np.asarray(box.static_span[0]))
    return bool(kinetic * math.cos(steepest) + math.sin(steepest) >= 0.0)


def steeper_is_slower(box: UncertaintySet) -> bool:
    """Whether a steeper trough is slower for every body of all boxes, Eq. (53)."""
    steepest = np.maximum(*np.abs(box.trough_angle))
    return bool(np.all(box.static_friction[1] * np.tan(steepest) < 1.0))


# ------------------------------------------------------------------------------
# Find the slowest or the fastest body in contact, and prove that none is much slower, or faster.
#
# An evolution moves to an extreme body; branch and bound covers the whole set by small boxes, each with a
# bound of its own (theory, section 14). They share the speed of a single body alone: what the evolution
# misses by more than the gap that is left, the bounds find, and the evolution starts anew from there.

#: [1] Relative distance of the proved bound from the slowest body at which the proof ends.
GAP: Final = 1e-6
_POPULATION: Final = 64
_MOST_GENERATIONS: Final = 300
_SMALL: Final = 1e-2  # [1] share of the trough's largest speed below which speeds are alike small
_BETTER: Final = 1e-12  # [1] by which a body that the bounds have met must be slower, to start anew


class _Slowest(NamedTuple):
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
) -> _Slowest:
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
        population = solver.row(points), solver.row(speeds)
        solver.evolve(scene(), population, len(first), _MOST_GENERATIONS, _SEED)
        order = np.argsort(speeds[:-1], kind="stable")
        return points[order], speeds[order]

    points, speeds = evolved(_first(low, high))
    if hops:
        return _Slowest(_points(box, points), speeds, None)
    lows, highs, bounds = np.empty((boxes, AXES)), np.empty((boxes, AXES)), np.empty(boxes)
    heap, met, speed = np.empty(boxes, np.int64), np.vstack([points[0]] * 2), speeds[:1].copy()
    room = tuple(map(solver.row, (lows, highs, bounds, heap, met, speed)))
    count = solver.cover(scene(), room, GAP, _SMALL * trough_speed(box), boxes)
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
    return _Slowest(_points(box, points), speeds, Certificate(below, above, -bounds if fast else bounds))


def trough_speed(box: UncertaintySet) -> float:
    """Return the largest speed of the trough of a single box, of an ellipse along one axis [m/s]."""
    sizes = [high for name, (_, high) in box.shape.items() if name.endswith("amplitude")]
    amplitude = box.factor[1] * max(sizes, default=1.0)
    return float(2.0 * math.pi * box.frequency[1] * amplitude)


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
    mu_d = np.clip(mu_d, *box.kinetic_span(mu_s))
    return Points(load, tuple(shape), beta, mu_s, mu_d, np.full(mu_s.shape, box.restitution[0]))


def _may_run_away(box: UncertaintySet) -> bool:
    """Whether the weight component along the trough exceeds kinetic friction for some body, up or down."""
    least, _ = box.kinetic_span(np.asarray(box.static_span[0]))
    return bool(least <= math.tan(max(abs(angle) for angle in box.trough_angle)))
