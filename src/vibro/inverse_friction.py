"""Which friction a known speed means, and below which friction a part slips, if the drive is known."""

from __future__ import annotations

import math
from dataclasses import fields
from typing import TYPE_CHECKING, Any, Final, NamedTuple

import numpy as np

from vibro.core.codes import Regime, Status, is_answered
from vibro.errors import InputError
from vibro.reals import NotRealError, real_number, shielded
from vibro.scene import Scene, check_single
from vibro.steady import solve

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import NDArray

    from vibro.reals import Bools, Floats
    from vibro.results.steady import SteadyCycle


#: [1] Kinetic frictions that are searched: all pairs of the catalogue lie between.
LEAST_FRICTION: Final = 1e-6
MOST_FRICTION: Final = 3.0
#: [1] Kinetic over static friction where nobody has measured it: dry metals on steel have 0.67 to 0.89.
USUAL_RATIO: Final = 0.8

# Frictions of the first grid: of drives of one harmonic, of other motions, which take up to 1.5 ms each, and
# of irregular motions, which take 10 ms; a tenth of them lie below the next number, above which parts are.
_GRID: Final = 2049
_GRID_OF_MOTIONS: Final = 1025
_GRID_OF_MEANS: Final = 129
_SLIPPERY: Final = 0.01
_PROBES: Final = (0.03, 0.1, 0.3, 1.0)  # which show whether motions are irregular

# Places at which the curve is refined at a time, those first where the speed changes most: a filling whose
# amplitude hovers about a threshold has thousands, and each of its cells takes 1 to 10 ms.
_MOST_PLACES: Final = 64
_MOST_PLACES_FED: Final = 8
_GRID_FED: Final = 257

_CLOSER: Final = 33  # frictions of each refinement around an extremum of the speed
_ROUNDS: Final = 4  # of refinement: down to 1e-7 of the friction, where the speed changes by its rounding
_BESIDE: Final = np.exp2(-np.arange(8.0, 50.0, 2.0))  # distances from a change of the pattern, over friction
_NARROW: Final = 1e-6  # [1] relative width of frictions below which an interval is one point
_EQUAL: Final = 1e-10  # [1] relative difference of speeds that may be rounding
_JUMP: Final = 1e-6  # [1] relative change of a speed between neighbouring doubles that is a jump
_SURE: Final = 3.0  # standard errors within which the mean of an irregular motion agrees
_ALIKE: Final = 6.0  # and up to which intervals of such agreement are one

_NO_PATTERN: Final = np.int64(-(2**62))  # less the status: no pattern has this code
_UNKNOWN: Final = 9.0  # stands for the sign of a difference that is unknown

_LEAST_STATIC: Final = 1e-12
_MOST_STATIC: Final = 1e12
_HALVINGS: Final = 64  # of the logarithm of a friction between these: down to its rounding


class Frictions(NamedTuple):
    """Kinetic frictions between two ends, which may be equal, and the mean speeds at these.

    Attributes
    ----------
    low, high : float
        Ends of the interval of kinetic friction [1].
    static_low, static_high : float
        Static friction at both ends [1].
    speed_low, speed_high : float
        Mean speeds at both ends [m/s].
    error : float
        Largest standard error of the speed in it, where motion is irregular; else 0 [m/s].
    regime : Regime
        Of the motion at the low end.
    """

    low: float
    high: float
    static_low: float
    static_high: float
    speed_low: float
    speed_high: float
    error: float
    regime: Regime


class Unanswered(NamedTuple):
    """Kinetic frictions between two ends that have no mean speed, and the status that says why."""

    low: float
    high: float
    status: Status


class FrictionForSpeed(NamedTuple):
    """The kinetic frictions at which a part has a given mean speed; returned by ``friction_for_speed``.

    Attributes
    ----------
    solutions : tuple of Frictions
        All frictions with that speed, ascending: single values, whose ends are equal, and intervals in which
        the speed does not depend on friction, or in which the mean of an irregular motion is within 3
        standard errors of the speed. Empty if there are none.
    jumps : tuple of Frictions
        Neighbouring frictions between which the speed jumps past the given one.
    fastest, slowest : Frictions
        Where the speed is largest, and smallest; negative if the part moves backwards. NaN if no friction
        has a mean speed.
    unanswered : tuple of Unanswered
        Where there is no mean speed: where the part runs away, its motion is unresolved, or flights are not
        computed.
    """

    solutions: tuple[Frictions, ...]
    jumps: tuple[Frictions, ...]
    fastest: Frictions
    slowest: Frictions
    unanswered: tuple[Unanswered, ...]


class CriticalFriction(NamedTuple):
    """Static frictions below which a part at rest begins to slip [1]; inf if it does at any, 0 at none.

    Attributes
    ----------
    forward, back : array
        Least static friction at which the part does not slip forward, or back. It rests if its static
        friction is at least the larger of the two.
    """

    forward: Floats
    back: Floats


@shielded
def critical_friction(scene: Scene) -> CriticalFriction:
    """Return the least static frictions at which a part that lies at rest does not slip.

    Parameters
    ----------
    scene : Scene
        Operating points of any shape. Their frictions and restitution have no effect.

    Returns
    -------
    CriticalFriction
        ``forward`` and ``back``: arrays of the scene's shape [1]. Both are inf where the throw number
        exceeds 1, as nothing holds a part that hops.

    Notes
    -----
    The largest ratio of the force along the trough, either way, to the normal force over a period, Eq. (5);
    it is found by bisection, to rounding, so that ``solve`` finds the part at rest with the friction that is
    returned, and slipping with one that is smaller by 1e-12 of it.

    Examples
    --------
    >>> import math, vibro
    >>> scene = vibro.Scene(amplitude=1e-3, frequency=15, drive_angle=math.radians(20),
    ...                     static_friction=0.74, kinetic_friction=0.57)
    >>> print(f"{vibro.critical_friction(scene).forward:.6f}")
    1.232577
    """
    shape = scene.shape
    given = _given(scene)
    hops = np.broadcast_to(np.asarray(solve(scene, output="regimes").throw_number) > 1.0, shape)
    found = []
    for name in ("forward_ratio", "back_ratio"):
        low, high = np.full(shape, _LEAST_STATIC), np.full(shape, _MOST_STATIC)
        for _ in range(_HALVINGS):
            middle = np.sqrt(low) * np.sqrt(high)
            scenes = Scene.computed(**{**given, "static_friction": middle, "kinetic_friction": middle})
            slips = getattr(solve(scenes, output="regimes"), name) > 1.0
            low, high = np.where(slips, middle, low), np.where(slips, high, middle)
        high = np.where(low == _LEAST_STATIC, 0.0, high)
        found.append(np.where(hops | (low > 0.5 * _MOST_STATIC), np.inf, high)[()])
    return CriticalFriction(*found)


@shielded
def friction_for_speed(
    scene: Scene, speed: float, *, ratio: float | None = USUAL_RATIO, flight: bool = True
) -> FrictionForSpeed:
    """Return all kinetic frictions at which a part that starts from rest has a given mean speed.

    Parameters
    ----------
    scene : Scene
        One operating point. Its kinetic friction has no effect, nor has its static friction if a ratio is
        given, so any numbers will do.
    speed : float
        Mean speed, > 0 [m/s]: a length over the time that a part takes.
    ratio : float, optional
        Kinetic over static friction, in (0, 1] [1]. None keeps the static friction of the scene.
    flight : bool, optional
        Whether flights of hopping parts are computed. If False, parts that hop have no speed.

    Returns
    -------
    FrictionForSpeed
        All solutions with a kinetic friction from 1e-6 to 3, or up to the scene's static friction; the
        fastest and the slowest friction; jumps of the speed past the given one.

    Raises
    ------
    SceneError
        If the scene is more than one operating point.
    InputError
        If another argument is invalid.

    Notes
    -----
    The speed is a piecewise smooth function of friction: it jumps, or has a kink, where the pattern of the
    cycle changes. It is solved at 2049 frictions (at 1025 for motions that are no ellipse). Every change of
    the pattern between two of them is enclosed between neighbouring doubles, and frictions that approach it
    geometrically are added on both sides. Extrema between changes are refined to 1e-7 of the friction. Each
    change of sign of the difference from the given speed is then bisected down to neighbouring doubles: a
    root, or a jump. Irregular motion, whose mean has a standard error, is solved at 129 frictions.

    So what is missed is a pair of solutions closer than two frictions of the grid, 0.3 % apart, without an
    extremum or a change of pattern that shows: in 60 random scenes of all drives an independent scan found
    none (tests/test_inverse_friction.py).

    Examples
    --------
    Parts take 3.9 s for 300 mm:

    >>> import math, vibro
    >>> scene = vibro.Scene(amplitude=1.1e-3, frequency=25, drive_angle=math.radians(20),
    ...                     static_friction=1, kinetic_friction=1)
    >>> for found in vibro.friction_for_speed(scene, 0.3 / 3.9).solutions:
    ...     print(f"kinetic friction {found.low:.4f}, static {found.static_low:.4f}")
    kinetic friction 0.6478, static 0.8097
    kinetic friction 1.7096, static 2.1370
    """
    check_single(scene)
    wanted = _in_range("speed", speed, math.inf, "finite and > 0 m/s", " m/s")
    if ratio is not None:
        ratio = _in_range("ratio", ratio, 1.0, "in (0, 1]")
    given = _given(scene)

    def cycles(static: Floats, kinetic: Floats) -> SteadyCycle:
        scenes = Scene.computed(**{**given, "static_friction": static, "kinetic_friction": kinetic})
        return solve(scenes, flight=flight)

    grid = _GRID if scene.motion is None else _GRID_OF_MOTIONS
    static = float(scene.static_friction)
    return matching_friction(cycles, wanted, ratio, static, grid=grid, most=_MOST_PLACES)


def matching_friction(
    cycles: Callable[[Floats, Floats], SteadyCycle],
    speed: float,
    ratio: float | None,
    static_friction: float,
    *,
    grid: int = _GRID_FED,
    most: int = _MOST_PLACES_FED,
) -> FrictionForSpeed:
    """Return what ``friction_for_speed`` does of any function from static and kinetic frictions to cycles.

    Parameters
    ----------
    cycles : callable
        From static and kinetic frictions, arrays of one shape (n,), to their steady cycles.
    speed : float
        To be reached [m/s].
    ratio : float or None
        Kinetic over static friction; None where static friction is known [1].
    static_friction : float
        If it is known [1].
    grid : int, optional
        Number of frictions of the first grid; without it, of machines with a filling.
    most : int, optional
        Number of changes of the pattern, or extrema, that are refined at a time.

    Raises
    ------
    InputError
        If static friction is known, and smaller than all kinetic frictions that are searched.
    """
    top = MOST_FRICTION if ratio is not None else min(MOST_FRICTION, static_friction)
    if not top > LEAST_FRICTION:
        allowed = f"> {LEAST_FRICTION:g}, the least kinetic friction that is searched"
        raise InputError(f"static_friction = {static_friction:.15g}: must be {allowed}")

    def static_of(kinetic: Floats) -> Floats:
        if ratio is None:
            return np.full_like(kinetic, static_friction)
        return np.maximum(kinetic / ratio, kinetic)

    curve = _Curve(cycles, static_of)
    curve.add(np.append(top * np.array(_PROBES), [LEAST_FRICTION, top]))
    if curve.irregular.any():
        grid = min(grid, _GRID_OF_MEANS)
    knee = min(_SLIPPERY, math.sqrt(LEAST_FRICTION * top))
    few = grid // 10
    curve.add(np.append(np.geomspace(LEAST_FRICTION, knee, few), np.geomspace(knee, top, grid - few)))
    curve.part(most)
    curve.refine(most)
    curve.part(most)
    return curve.matches(speed)


def _given(scene: Scene) -> dict[str, Any]:
    """Return the fields that a scene has."""
    values = {field.name: getattr(scene, field.name) for field in fields(scene)}
    return {name: value for name, value in values.items() if value is not None}


def _in_range(name: str, value: Any, high: float, allowed: str, unit: str = "") -> float:
    """Read a number above 0, up to a finite value, or below an infinite one."""
    try:
        number = real_number(value)
    except NotRealError as exc:
        raise InputError(f"{name} = {exc.value}: must be {exc.allowed}") from None
    if not 0.0 < number <= high or math.isinf(number):
        raise InputError(f"{name} = {number:.15g}{unit}: must be {allowed}")
    return number


def _gaps(x: Floats) -> Bools:
    """Return whether there is another double between each number and the next."""
    return np.nextafter(x[:-1], x[1:]) < x[1:]


class _Curve:
    """Speeds at some kinetic frictions, ascending, to which more are added.

    Attributes
    ----------
    cycles, static_of : callable
        As ``matching_friction`` has them.
    x, speed, error : (n,) array
        Kinetic frictions [1], mean speeds, NaN where there is none, and their standard errors [m/s].
    kind : (n,) array of int
        Code of the pattern; one of the status where there is no speed, or the mean of irregular motion.
    status, regime : (n,) array of int
        Codes of ``Status`` and ``Regime``.
    """

    def __init__(
        self, cycles: Callable[[Floats, Floats], SteadyCycle], static_of: Callable[[Floats], Floats]
    ) -> None:
        self.cycles, self.static_of = cycles, static_of
        self.x, self.speed, self.error = np.empty((3, 0))
        self.kind = np.empty(0, np.int64)
        self.status, self.regime = np.empty((2, 0), np.int8)

    @property
    def irregular(self) -> Bools:
        """Where a speed is the mean of an irregular motion."""
        return np.asarray(self.status == Status.AVERAGED)

    def add(self, x: Floats) -> None:
        """Solve more frictions."""
        x = np.setdiff1d(x, self.x)
        if not x.size:
            return
        cycle = self.cycles(self.static_of(x), x)
        status = np.asarray(cycle.status)
        known, means = is_answered(status), status == Status.AVERAGED
        places = np.searchsorted(self.x, x)
        new = {
            "x": x,
            "speed": np.where(known, cycle.mean_velocity, np.nan),
            "error": np.where(means, np.nan_to_num(cycle.mean_velocity_error), 0.0),
            "kind": np.where(known & ~means, cycle.pattern_code, _NO_PATTERN - status),
            "status": status,
            "regime": cycle.regime,
        }
        for name, values in new.items():
            setattr(self, name, np.insert(getattr(self, name), places, values))

    def part(self, most: int) -> None:
        """Enclose every change of the pattern between neighbouring doubles, and solve frictions beside it."""
        for _ in range(_ROUNDS):
            means = self.irregular
            change = (self.kind[1:] != self.kind[:-1]) & _gaps(self.x) & ~(means[1:] | means[:-1])
            at = np.flatnonzero(change)
            if not at.size:
                return
            leaps = np.abs(self.speed[at + 1] - self.speed[at])  # NaN, of lost cells, counts as the largest
            at = at[np.argsort(leaps)[-most:]]
            low, high = self._enclosed(at, at + 1, lambda kind, _: kind)
            ends = self.x[0], self.x[-1]
            beside = np.append(low[:, None] * (1.0 - _BESIDE), high[:, None] * (1.0 + _BESIDE))
            beside = beside[(beside > ends[0]) & (beside < ends[1])]
            self.add(np.concatenate([low, high, beside]))

    def refine(self, most: int) -> None:
        """Solve frictions around every extremum of the speed within a pattern."""
        for _ in range(_ROUNDS):
            before, middle, after = self.speed[:-2], self.speed[1:-1], self.speed[2:]
            one = (self.kind[:-2] == self.kind[1:-1]) & (self.kind[2:] == self.kind[1:-1])
            one &= ~self.irregular[1:-1]
            lowest, highest = np.minimum(before, after), np.maximum(before, after)
            rounding = _EQUAL * np.abs(middle)
            top = (middle >= highest) & (lowest < middle - rounding)
            dip = (middle <= lowest) & (highest > middle + rounding)
            cells = np.flatnonzero(one & (top | dip))
            if not cells.size:
                return
            cells = (
                cells[np.argsort((np.maximum(highest, middle) - np.minimum(lowest, middle))[cells])[-most:]]
                + 1
            )
            self.add(np.linspace(self.x[cells - 1], self.x[cells + 1], _CLOSER)[1:-1].ravel())

    def _enclosed(
        self,
        inside: NDArray[np.intp],
        outside: NDArray[np.intp],
        mark: Callable[[NDArray[np.int64], Floats], NDArray[Any]],
    ) -> tuple[Floats, Floats]:
        """Bisect between places, down to neighbouring doubles.

        ``mark`` makes of patterns and speeds what changes from inside to outside.
        """
        wanted = mark(self.kind[inside], self.speed[inside])
        near, far = self.x[inside], self.x[outside]
        while True:
            middle = 0.5 * (near + far)
            if np.all((middle == near) | (middle == far)):
                return near, far
            found = _Curve(self.cycles, self.static_of)
            found.add(middle)
            where = np.searchsorted(found.x, middle)
            same = mark(found.kind[where], found.speed[where]) == wanted
            near, far = np.where(same, middle, near), np.where(same, far, middle)

    def matches(self, speed: float) -> FrictionForSpeed:
        """Find where the curve has a speed [m/s], where it jumps past that, and its extremes."""
        x, off = self.x, self.speed - speed
        near = np.where(self.irregular, _SURE * self.error, _EQUAL * speed)
        signs = np.where(np.abs(off) <= near, 0.0, np.sign(off))  # NaN where there is no speed
        runs = _runs(np.nan_to_num(signs, nan=_UNKNOWN))
        brackets: list[tuple[int, int]] = []
        means: list[tuple[int, int]] = []
        found: list[tuple[float, float]] = []
        for (before, _, _), (sign, first, last), (after, _, _) in zip(
            [(_UNKNOWN, 0, 0), *runs], runs, [*runs[1:], (_UNKNOWN, 0, 0)], strict=False
        ):
            if sign != 0.0:
                if sign == -after:
                    means_here = self.irregular[last : last + 2].any()
                    (means if means_here else brackets).append((last, last + 1))
            elif self.irregular[first : last + 1].any():
                means.append((first, last))
            elif x[last] - x[first] > _NARROW * x[last]:
                found.append(self._level(first, last, speed))
            elif abs(before) == 1.0 and before == -after:
                brackets.append((first - 1, last + 1))
            else:  # an extremum that touches the speed, or an end
                best = x[first + np.argmin(np.abs(off[first : last + 1]))]
                found.append((best, best))
        found += self._joined(means, np.abs(off) <= _ALIKE * self.error)
        at = np.array(brackets, np.intp).reshape(-1, 2).T
        low, high = self._enclosed(at[0], at[1], lambda _, v: v > speed)
        self.add(np.append(low, high))
        speeds = self._speeds(low), self._speeds(high)
        leaps = np.abs(speeds[1] - speeds[0]) > _JUMP * speed
        roots = np.where(np.abs(speeds[0] - speed) <= np.abs(speeds[1] - speed), low, high)[~leaps]
        found += zip(roots, roots, strict=True)
        return FrictionForSpeed(
            tuple(self._between(*ends) for ends in sorted(found)),
            tuple(self._between(*ends) for ends in zip(low[leaps], high[leaps], strict=True)),
            self._extreme(1.0),
            self._extreme(-1.0),
            tuple(
                Unanswered(float(self.x[first]), float(self.x[last]), Status(int(status)))
                for status, first, last in _runs(self.status)
                if math.isnan(self.speed[first])
            ),
        )

    def _level(self, first: int, last: int, speed: float) -> tuple[float, float]:
        """Return the ends of an interval in which the speed is this one, but for rounding."""
        ends = [self.x[first], self.x[last]]
        for k, inside, outside in ((0, first, first - 1), (1, last, last + 1)):
            if 0 <= outside < self.x.size and self.kind[outside] == self.kind[inside]:
                places = np.array([inside]), np.array([outside])
                near, _ = self._enclosed(*places, lambda _, v: np.abs(v - speed) <= _EQUAL * abs(speed))
                ends[k] = near[0]
        return ends[0], ends[1]

    def _joined(self, means: list[tuple[int, int]], alike: Bools) -> list[tuple[float, float]]:
        """Join intervals of irregular motion between which all means nearly agree."""
        joined: list[tuple[int, int]] = []
        for first, last in sorted(means):
            if joined and alike[joined[-1][1] : first + 1].all():
                joined[-1] = joined[-1][0], max(last, joined[-1][1])
            else:
                joined.append((first, last))
        return [(self.x[first], self.x[last]) for first, last in joined]

    def _extreme(self, side: float) -> Frictions:
        """Return where the speed is largest, or smallest if the side is -1."""
        if np.isnan(self.speed).all():
            nan = math.nan
            return Frictions(nan, nan, nan, nan, nan, nan, nan, Regime.UNDEFINED)
        best = int(np.nanargmax(side * self.speed))
        speed = float(self.speed[best])
        level = (np.abs(self.speed - speed) <= _EQUAL * abs(speed)) & ~self.irregular
        first = last = best
        while first > 0 and level[first - 1]:
            first -= 1
        while last < self.x.size - 1 and level[last + 1]:
            last += 1
        if self.x[last] - self.x[first] > _NARROW * self.x[last]:
            return self._between(*self._level(first, last, speed))
        return self._between(self.x[best], self.x[best])

    def _speeds(self, x: Floats) -> Floats:
        """Return the speeds at frictions that are solved."""
        return self.speed[np.searchsorted(self.x, x)]

    def _between(self, low: float, high: float) -> Frictions:
        ends = np.array([low, high])
        self.add(ends)
        (static_low, static_high), (speed_low, speed_high) = (
            x.tolist() for x in (self.static_of(ends), self._speeds(ends))
        )
        error = float(self.error[(self.x >= low) & (self.x <= high)].max())
        regime = Regime(int(self.regime[np.searchsorted(self.x, low)]))
        low, high = ends.tolist()
        return Frictions(low, high, static_low, static_high, speed_low, speed_high, error, regime)


def _runs(keys: NDArray[Any]) -> list[tuple[Any, int, int]]:
    """Return each key of equal neighbours with the places of the first and the last."""
    starts = [0, *(np.flatnonzero(keys[1:] != keys[:-1]) + 1).tolist()]
    return [(keys[a], a, b - 1) for a, b in zip(starts, [*starts[1:], keys.size], strict=True)]
