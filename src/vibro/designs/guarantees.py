"""Bounds on speed and regime over a box of bands: ``vibro.guarantee``."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any, Final, NamedTuple

import numpy as np

from vibro.core.codes import Regime, Status, is_answered
from vibro.designs.proofs import (
    back_slip_load,
    change_loads,
    corners,
    is_braked,
    slowest_in_contact,
    steeper_is_slower,
    trough_speed,
)
from vibro.designs.search import evolve, placed, scatter, sobol
from vibro.designs.spaces import TOLERANCES, share, uncertainty_set
from vibro.drives import Ability, Line
from vibro.limits import back_slip_of
from vibro.reals import shielded
from vibro.results.designs import Guarantee
from vibro.results.steady import SteadyCycle
from vibro.scene import Scene
from vibro.steady import solve

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from vibro.designs.spaces import Points, Span, UncertaintySet
    from vibro.reals import Bools, Floats
    from vibro.results.designs import Certificate

    Codes = NDArray[np.int8]

# ------------------------------------------------------------------------------
# Find the slowest and the fastest body of an uncertainty set: search in contact, sample hops.
#
# Of the settings with one load that of the highest frequency is the slowest (theory, section 14).

# Standard errors by which a statistical mean is reduced, or increased, before it counts.
_ERRORS: Final = 3.0

_SEED: Final = 1  # of samples
# [share of a band] Distances from a body that may lie at a jump: beyond rounding, and that of roots.
_SIDES: Final = (1e-14, 1e-12, 1e-10)
_LOOSE: Final = 1e-5  # [1] Gap of a proof at which bodies are looked for at their critical loads.
_MORE: Final = 256  # of these in every round

# Samples of hopping bodies: base-2 logarithms of those of the first round, and of each round around the
# extreme ones; and how many rounds. Of 200 random boxes with a band of restitution two had slower bodies than
# their bound among 4096 others, by 0.55 % at most, and two faster ones, by 0.1 %.
_SAMPLES: Final = (12, 6, 8)
# The same where a slower body alone is sought.
_FEWER_SAMPLES: Final = (11, 6, 4)
_LOOKS: Final = 12  # base-2 logarithm of the samples whose regimes are solved
_LANDINGS: Final = 9  # base-2 logarithm of the samples of landings
_ROUNDS: Final = 3  # of samples closer to the extreme ones, beside jumps of bodies in contact

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
    hops: SteadyCycle | None = None  # of the first samples of hopping bodies, which serve both extremes

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
    box = box.in_contact
    free, middle = box.varies, np.full((len(box.axes), 1), 0.5)
    samples = [placed(free, sobol(int(free.sum()), _LOOKS, _SEED))] if free.any() else []
    coordinates = np.hstack([corners(free), *samples, middle])
    for points in (box.points(coordinates), _changes(box)):
        speeds_of(box.scene(points, fast=False), fast=False, flight=False, seen=seen)


def _changes(box: UncertaintySet) -> Points:
    """Return points on both sides of every critical load of the corners."""
    ends = box.points(corners(box.varies))
    # the onset load is least where the drive angle equals the angle of friction
    if "drive_angle" in box.shape:
        angle = np.clip(np.arctan(ends.static_friction), *box.shape["drive_angle"])
        ends = ends._replace(shape=(np.array([ends.shape[0], angle]),))
    return _beside(box, ends, TOLERANCES.beside)


def _beside(box: UncertaintySet, points: Points, distance: float) -> Points:
    """Move points to both sides of all of their critical loads, by a relative distance."""
    scene = box.scene(points, fast=False)
    changes = np.array([np.nan_to_num(load, posinf=np.inf) for load in change_loads(scene).values()])
    loads = np.multiply.outer(np.array([1.0 - distance, 1.0 + distance]), points.load * changes / scene.load)
    return points._replace(load=np.clip(loads, *box.load))


def _evolved(
    box: UncertaintySet, *, fast: bool, seen: Seen, brief: bool, highest: Regime = Regime.HOPPING
) -> Extreme:
    """Return the slowest or the fastest body in contact of a drive whose boxes the solver does not bound.

    Two evolutions move to it, from corners and points that fill the box evenly; arguments as ``searched``.
    Of 140 boxes of random harmonics and steps, as wide as in tests/designs/test_motions.py, none had among
    32768 points a slower body, or a faster one, by more than 1e-6 of the largest speed.
    """
    box = box.in_contact
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

    It agrees with the reference designs to 1e-9 (tests/designs/test_guarantees.py); benchmarks/design.py
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
    free, side = box.varies, -1.0 if fast else 1.0

    def costs(coordinates: Floats, loads: Floats | None = None) -> Floats:
        points = box.points(coordinates)
        scene = box.scene(points if loads is None else points._replace(load=loads), fast=fast)
        speed = side * speeds_of(scene, fast=fast, flight=False, highest=highest)
        return np.where(np.isnan(speed), math.inf, speed)

    def sides(x: Floats) -> Floats:
        loads = _beside(box, box.points(placed(free, x)), TOLERANCES.either_side).load
        return loads.reshape(-1, x.shape[1])

    def ridge(x: Floats) -> Floats:
        least: Floats = costs(placed(free, x), sides(x)).min(axis=0)
        return least

    at = box.coordinates(points.kept(np.arange(speeds.size) == 0))
    # At a jump rounding brings the body to the other side, where its speed is another: both sides count.
    steps = np.multiply.outer(np.eye(len(at))[:, free], np.outer(_SIDES, (1.0, -1.0)).ravel())
    near = np.clip(at + np.hstack([np.zeros_like(at), steps.reshape(len(at), -1)]), 0.0, 1.0)
    at = near[:, [int(np.argmin(costs(near)))]]
    speed = costs(at)[0]
    loose = certificate is None or (side * certificate.bound).min() < speed - _LOOSE * abs(speed)
    if loose and math.isfinite(speed):
        x, least = scatter(ridge, at[free], more=_MORE, rounds=_ROUNDS, seed=_SEED)
        if least < speed:
            at, loads = placed(free, x), sides(x)
            at[0] = share(loads[np.argmin(costs(at, loads))], box.load)
    return taken(box, at, fast=fast, flight=False, seen=seen, highest=highest), certificate


def sampled(box: UncertaintySet, *, fast: bool, seen: Seen, brief: bool) -> Extreme:
    """Return the slowest or the fastest of the hopping bodies among samples; NaN if none was found.

    Speeds of hopping bodies are not smooth in any coordinate, which defeats a search. So up to a few thousand
    points of the whole box are sampled, then some closer and closer around the extreme ones.
    """
    free = box.varies
    first, more, rounds = _FEWER_SAMPLES if brief else _SAMPLES
    side = -1.0 if fast else 1.0
    met: list[Floats] = []

    def cost(x: Floats) -> Floats:
        points = box.points(placed(free, x))
        costs = np.full(x.shape[1], np.nan)
        hops = box.hops(points)
        if hops.any():
            slow, scene = (box.scene(points.kept(hops), fast=which) for which in (False, fast))
            cycle = seen.hops
            if met or cycle is None:
                cycle = solve(slow)
                seen.add(cycle)
                seen.hops = seen.hops or cycle
            # at one load speeds go with 1/f, Eq. (52)
            costs[hops] = side * counted(cycle, fast=fast) * (slow.frequency / scene.frequency)
            seen.excluded += int(np.count_nonzero(np.isnan(costs[hops])))
        met.append(costs)
        return costs

    even = sobol(int(free.sum()), first, _SEED)
    coordinates = np.hstack([corners(free)[free], even])
    x, best = scatter(cost, coordinates, more=2**more, rounds=rounds, seed=_SEED)
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


_AMPLITUDES: Final = ("amplitude", "along_amplitude", "normal_amplitude", "motion_scale")
#: Most boxes of a proof that is printed.
BOXES: Final = 8000
#: The same where a slower body alone is sought.
BRIEF: Final = 400
# [1] Over the trough's largest speed: rounding of the speed of a body at a corner, and of its load.
_ROUNDING: Final = 1e-13
# Coordinates of the slowest and the fastest body on a line where none slips back: the slowest is the roughest
# and least driven one, on the steepest trough.
_CORNERS: Final = (
    np.array([[0.0], [0.0], [1.0], [1.0], [1.0], [0.0]]),
    np.array([[1.0], [0.0], [0.0], [0.0], [0.0], [0.0]]),
)
# Loads at which the speed may jump, and how the report names them.
_JUMPS: Final = {
    "back_slip": "back slip begins",
    "back_onset": "the load for back slip is reached",
    "forward_onset": "forward slip begins",
}


@shielded
def guarantee(scene: Scene, **bands: Any) -> Guarantee:
    """Return bounds on speed and regime over a box of bands, for bodies that start from rest.

    Parameters
    ----------
    scene : Scene
        One operating point, with the values of all quantities that have no band.
    **bands
        Pairs (low, high) by quantity, in SI units and radians: ``static_friction``, ``kinetic_friction`` or
        ``friction_ratio``, ``restitution`` (which bodies in contact do not have), ``frequency``,
        ``trough_angle``, and quantities of the drive: ``amplitude`` and
        ``drive_angle`` of a line; ``along_amplitude``, ``normal_amplitude`` and ``normal_phase`` of an
        ellipse; ``motion_scale`` of another motion. The scene's own value may be outside the band. Points
        with mu_d > mu_s do not count.

    Returns
    -------
    Guarantee
        Bounds on the mean speed, the extreme bodies that were found (one-sided limits at a jump included),
        and the regimes.

    Raises
    ------
    SceneError
        If the scene is more than one operating point, or a band is invalid; the message lists all problems.

    Notes
    -----
    ``Guarantee.proof_min`` and ``proof_max`` say how each bound is known. The first two are guaranteed: no
    body is beyond, rounding included.

    * ``corners``: the drive moves along a line of fixed angle, and no body slides back or hops. The speed is
      then monotone, and the extreme bodies are at corners of the box (theory, section 14).
    * ``proved``: boxes that cover the set prove the bound. They are divided until it is within 1e-6 of the
      extreme body that a differential evolution has found, or there are 8000; ``found_min`` and
      ``found_max`` show the gap that is left.
    * ``searched``: the extreme body that was found, and another may be beyond: all motions that are neither
      lines nor ellipses, and sets in which the boxes prove nothing (measurements: :doc:`/guide/design`).
    * ``sampled``: bodies hop, and the bound is the extreme one of a sample: of ``Guarantee.samples``, spread
      evenly, none is beyond. A body drawn at random is, at 95 % confidence, with a chance of at most
      3 / ``samples``.

    The regimes are those of all bodies that were computed. The mean speed of irregular motion is widened by
    three standard errors.

    Examples
    --------
    >>> import math, vibro
    >>> scene = vibro.Scene(amplitude=1.195e-3, frequency=15, drive_angle=math.radians(20),
    ...                     static_friction=0.74, kinetic_friction=0.57)
    >>> g = vibro.guarantee(scene, amplitude=(0.99 * 1.195e-3, 1.01 * 1.195e-3))
    >>> print(f"{1e3 * g.speed_min:.4f} to {1e3 * g.speed_max:.4f} mm/s, {g.proof_min}; {g.max_limit}")
    27.0464 to 29.0414 mm/s, proved; from below the load at which back slip begins
    """
    return guarantee_of(uncertainty_set(scene, bands))


def guarantee_of(box: UncertaintySet) -> Guarantee:
    """Return the guarantee over a single box."""
    seen = Seen()
    look_around(box, seen)
    least, most = (bound(box, fast=fast, seen=seen, boxes=BOXES) for fast in (False, True))
    return Guarantee(
        speed_min=least.speed,
        speed_max=most.speed,
        found_min=least.extreme.speed,
        found_max=most.extreme.speed,
        min_at=_place(least.extreme.scene),
        max_at=_place(most.extreme.scene),
        min_limit=_limit(least.extreme),
        max_limit=_limit(most.extreme),
        regimes=frozenset(seen.regimes),
        proof_min=least.proof,
        proof_max=most.proof,
        proved_min=least.proved,
        proved_max=most.proved,
        certificate_min=least.certificate,
        certificate_max=most.certificate,
        samples=seen.samples,
        coexists=seen.coexists,
        excluded=seen.excluded,
    )


class Bound(NamedTuple):
    """The slowest or the fastest body of a box, and its proof, as ``Guarantee`` describes them."""

    extreme: Extreme
    proof: str
    proved: float
    certificate: Certificate | None = None

    @property
    def speed(self) -> float:
        """The bound that is proved; where none is, the speed of the body [m/s]."""
        return self.proved if math.isfinite(self.proved) else self.extreme.speed


def bound(
    box: UncertaintySet, *, fast: bool, seen: Seen, boxes: int, highest: Regime = Regime.HOPPING
) -> Bound:
    """Find the slowest or the fastest body of a single box.

    A body in a higher regime than ``highest`` is slower, or faster, than all others; ``boxes`` is the largest
    number of those of a proof.
    """
    hops, side = box.may_hop, 1.0 if fast else -1.0
    if not hops:
        box = box.in_contact
    if not box.varies.any():
        only = taken(box, np.zeros((len(box.axes), 1)), fast=fast, flight=True, seen=seen, highest=highest)
        if hops and np.any(solve(only.scene).status == Status.AVERAGED):
            return Bound(only, "sampled", math.nan)
        return Bound(only, "corners", only.speed)
    if box.space.proves and not hops and _is_monotone(box):
        extreme = taken(box, _CORNERS[fast], fast=fast, flight=False, seen=seen)
        rounding = _ROUNDING * trough_speed(box) if extreme.speed else 0.0
        return Bound(extreme, "corners", extreme.speed + side * rounding)
    if box.space.is_bounded:
        extreme, certificate = searched(box.in_contact, fast=fast, boxes=boxes, seen=seen, highest=highest)
    else:
        extreme, certificate = (
            _evolved(box, fast=fast, seen=seen, brief=boxes <= BRIEF, highest=highest),
            None,
        )
    if certificate is not None:
        if math.isinf(extreme.speed):  # one body without a speed proves it
            return Bound(extreme, "proved", extreme.speed)
        proved = float(certificate.bound.max() if fast else certificate.bound.min())
        return Bound(extreme, "proved" if math.isfinite(proved) else "searched", proved, certificate)
    if not hops:
        return Bound(extreme, "searched", math.nan)
    hopping = sampled(box, fast=fast, seen=seen, brief=boxes <= BRIEF)
    if math.isnan(hopping.speed):  # no sample has a known speed, so none bounds them
        hopping = replace(hopping, speed=side * math.inf)
    elif not math.isnan(extreme.speed):
        hopping = min(extreme, hopping, key=lambda one: -side * one.speed)
    return Bound(hopping, "sampled", math.nan)


def _is_monotone(box: UncertaintySet) -> bool:
    """Whether the speed is proved monotone along every band: no body slips back or runs away.

    Along the drive angle it is not: there it rises, then falls.
    """
    low, high = box.shape["drive_angle"]
    slips_forward = float(box.load[1]) <= float(back_slip_load(box))
    return bool(low == high) and slips_forward and is_braked(box) and steeper_is_slower(box)


def _place(scene: Scene) -> dict[str, float]:
    """Return the fields of a scene of one cell."""
    members = scene.arrays().members()
    return {name: float(np.ravel(x)[0]) for field, name, x in members if field == name}


def _limit(extreme: Extreme) -> str:
    """Return the side from which a speed is the limit at a jump; empty where it does not jump."""
    at = _place(extreme.scene)
    load = float(np.ravel(extreme.scene.load)[0])
    known = change_loads(extreme.scene)
    motion: Any = {} if extreme.scene.motion is None else {"motion": extreme.scene.motion}
    for name, text in _JUMPS.items():
        critical = float(np.ravel(known.get(name, math.inf))[0])
        if not (math.isfinite(critical) and abs(load - critical) <= TOLERANCES.near * critical):
            continue
        beside = critical / load * (1.0 + TOLERANCES.either_side * np.array([-1.0, 1.0]))
        fields: dict[str, Any] = {
            **motion,
            **at,
            **{field: at[field] * beside for field in _AMPLITUDES if field in at},
        }
        below, above = speeds_of(Scene(**fields), fast=False, flight=False)
        if abs(above - below) > TOLERANCES.jump * max(abs(above), abs(below)):
            is_above = abs(extreme.speed - above) < abs(extreme.speed - below)
            return f"from {'above' if is_above else 'below'} the load at which {text}"
    return ""


# ------------------------------------------------------------------------------
# Regimes and speeds that hold for every body within bands of friction, over a map of operating points.

# Bisections of a band of static friction on declines; each halves the interval that stays undecided.
_HALVINGS: Final = 12

# Any operating point will do: ``uncertainty_set`` needs a scene to check the bands of friction.
_ANY: Final = {"amplitude": 1e-3, "frequency": 50.0, "drive_angle": 0.3}


class Certain(NamedTuple):
    """Bounds that hold for every body of a box of frictions, at every operating point.

    Attributes
    ----------
    lowest, highest : int8 array
        Codes of ``Regime`` that bound the regimes of all bodies. ``lowest`` is -1 if the box holds bodies
        without friction, which have no regime.
    speed_min : array
        Lower bound of the mean speeds of all bodies [m/s]; NaN where none is proved.
    """

    lowest: Codes
    highest: Codes
    speed_min: Floats


def certain(scene: Scene, *, static_friction: Span, second_friction: Span, is_ratio: bool) -> Certain:
    """Return bounds on regime and speed for friction known as a band, at every operating point.

    They hold for bodies that start from rest on a drive along a line.

    Parameters
    ----------
    scene : Scene
        Operating points of any shape; their own frictions are ignored.
    static_friction : pair of float
        Smallest and largest static friction [1].
    second_friction : pair of float
        Smallest and largest kinetic friction, or ratio of it to static friction [1]. The box is cut at
        mu_d <= mu_s.
    is_ratio : bool
        Whether ``second_friction`` is a ratio.

    Returns
    -------
    Certain
        Arrays of the shape of the operating points.

    Raises
    ------
    SceneError
        If a band is invalid; it lists every problem.
    InputError
        If the drive does not move along a line (``Ability.PROOF``).

    Notes
    -----
    The bounds are regimes of ``vibro.solve`` at corners of the box, equality at thresholds included. Every
    body stays within them, except where its friction equals that of a corner up to the last digits and
    rounding puts the two on different sides of a threshold. Where the bounds differ, both regimes occur, with
    two exceptions. First, on declines where the largest or the least kinetic friction changes with static
    friction (a ratio, or the cut), the first or the last body to slip back may lie between corners: that edge
    of the box is bisected until all its parts are proved, and a narrow interval at the threshold stays
    undecided (tests/designs/test_guarantees_certain.py counts its cells). Second, if the box holds bodies
    without static friction, ``lowest`` is -1 and ``highest`` back slip, where they do not hop.

    ``speed_min`` is the speed of the body with the highest friction, where no body slips back and kinetic
    friction exceeds the weight component down the trough for all (theory, section 14), or where all rest.
    For a single body it is the body's own speed. It is NaN where bodies may slip back or hop.

    Why corners: both onsets, Eq. (5), rise with mu_s. Of its speed over A w a forward slide keeps
    cos p - cos q - k (q - p) until the back window closes, where sin p = s_f and sin q = -s_b, Eq. (17). That
    falls with k, and so with mu_d. With mu_s it rises by (s_b + k) s_b'/cos q - (s_f - k) s_f'/cos p, which
    is positive for 0 <= k and s_f < s_b; elsewhere the slide lasts always, or never. At a given ratio r of
    frictions the sign of Eq. (22) over kappa follows (S_b^2 - S_f^2)/kappa; with T = tan(beta) and
    t = tan(alpha) that goes as mu_s (mu_s^2 t - T) (1 + r mu_s t) / ((r mu_s + T) (1 - mu_s^2 t^2)^2), which
    rises with mu_s for T >= 0.

    Examples
    --------
    >>> import math, vibro
    >>> line = vibro.Scene(amplitude=[0.6e-3, 0.7e-3, 0.9e-3, 1.1e-3, 1.4e-3, 4e-3], frequency=15,
    ...                    drive_angle=math.radians(20), static_friction=0.74, kinetic_friction=0.57)
    >>> found = certain(line, static_friction=(0.65, 0.8), second_friction=(0.5, 0.6), is_ratio=False)
    >>> found.lowest.tolist(), found.highest.tolist()
    ([0, 0, 1, 1, 2, 3], [0, 1, 1, 2, 2, 3])
    """
    hint = "vibro.guarantee bounds the speed of one operating point of any drive"
    scene.arrays().require(Ability.PROOF, hint=hint)
    second = "friction_ratio" if is_ratio else "kinetic_friction"
    bands = {"static_friction": static_friction, second: second_friction}
    box = uncertainty_set(Scene(**_ANY, static_friction=1.0, kinetic_friction=0.0), bands)
    low, high = (np.asarray(end) for end in box.static_span)
    least, most = box.kinetic_span(low), box.kinetic_span(high)

    roughest = solve(_bodies(scene, high, most[1]), flight=False)
    lowest = np.asarray(roughest.regime) if most[0] == most[1] else _regimes(scene, high, most[0])
    highest = _regimes(scene, low, least[1])
    if low == 0.0 < high:
        lost = (highest == Regime.UNDEFINED) & (lowest >= 0)
        lowest = np.where(lost, np.int8(Regime.UNDEFINED), lowest)
        highest = np.where(lost, np.int8(Regime.BACK_SLIP), highest)
    if least[0] < most[0]:  # all bodies may have more kinetic friction than the one that was solved
        _settle(scene, lowest, box, was=Regime.BACK_SLIP, otherwise=Regime.FORWARD_SLIP)
    if least[1] < most[1]:
        _settle(scene, highest, box, was=Regime.FORWARD_SLIP, otherwise=Regime.BACK_SLIP)

    speed = np.asarray(roughest.mean_velocity)
    if low < high or least[0] < most[1]:
        lean = np.sin(scene.trough_angle)
        braked = least[0] * np.cos(scene.trough_angle) + lean >= TOLERANCES.braked * np.abs(lean)
        proved = (highest == Regime.NO_SLIP) | ((highest == Regime.FORWARD_SLIP) & braked)
        speed = np.where(proved, speed, np.nan)
    return Certain(lowest, highest, speed)


def _bodies(scene: Scene, static_friction: Floats, kinetic_friction: Floats) -> Scene:
    """Return the operating points with the frictions of one body."""
    fields = scene.arrays()._asdict()
    fields.update(static_friction=static_friction, kinetic_friction=kinetic_friction)
    return Scene.allowing_infeasible(**fields)


def _regimes(scene: Scene, static_friction: Floats, kinetic_friction: Floats) -> Codes:
    return np.asarray(solve(_bodies(scene, static_friction, kinetic_friction), output="regimes").regime)


def _settle(scene: Scene, codes: Codes, box: UncertaintySet, *, was: Regime, otherwise: Regime) -> None:
    """Replace a bound, in place, on declines for which it is not proved for all bodies.

    A body slips back at a lower load the lower its static and the higher its kinetic friction. So each part
    of the band of static friction is proved by a body that bounds it, refuted by the body in its middle, and
    bisected if neither decides.
    """
    slips_back = was is Regime.BACK_SLIP
    last = 0 if slips_back else 1  # the end of kinetic friction
    cells = np.flatnonzero((scene.trough_angle < 0.0) & (codes == was))
    points = [np.asarray(x).take(cells) for x in _bodies(scene, *(np.zeros(()),) * 2).flat()]
    which = np.arange(cells.size)  # the cells of all open parts
    start, end = (np.full(cells.size, value) for value in box.static_span)
    fails = np.zeros(cells.size, np.bool_)
    for _ in range(_HALVINGS):
        if not which.size:
            break
        part = Line(*(x.take(which) for x in points))
        near, far = (end, start) if slips_back else (start, end)
        proved = _slips_back(part, near, box.kinetic_span(far)[last]) == slips_back
        middle = 0.5 * (start + end)
        fails[which[_slips_back(part, middle, box.kinetic_span(middle)[last]) != slips_back]] = True
        left = ~(proved | fails[which])
        which, start, middle, end = (np.tile(x[left], 2) for x in (which, start, middle, end))
        half = which.size // 2
        start[half:], end[:half] = middle[half:], middle[:half]
    fails[which] = True
    codes.reshape(-1)[cells[fails]] = otherwise


def _slips_back(fields: Line, static_friction: Floats, kinetic_friction: Floats) -> Bools:
    """Return whether bodies on a decline slip back, by Eqs. (5) and (17).

    A body that static friction cannot hold at rest runs away forward. So does one that it just holds and that
    kinetic friction does not slow down, so the former is replaced by the latter.
    """
    held = np.maximum(static_friction, np.abs(np.tan(fields.trough_angle)))
    return back_slip_of(fields._replace(static_friction=held, kinetic_friction=kinetic_friction))
