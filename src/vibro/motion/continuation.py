"""Follows one cycle of flights along a quantity, past folds and period doublings.

The normal motion does not depend on that along the trough, and a cycle with a contact forgets its normal
motion: so the cycles that fold and double are those of flights alone, each a fixed point of the map of a
take-off's phase and normal speed over its flights, Eq. (73). Pseudo-arclength continuation: a step along the
tangent of the branch, then Newton's iteration across it.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, Final, NamedTuple

import numpy as np

from vibro.core.buffers import LONGEST_CYCLE
from vibro.core.codes import Status
from vibro.core.compiled import doors
from vibro.core.elementary import TURN
from vibro.errors import Problem, SceneError
from vibro.motion.attractors import attractors
from vibro.motion.branches import Branch, BranchEvent
from vibro.motion.histories import grid_of
from vibro.quantities import QUANTITIES
from vibro.reals import real_array, shielded
from vibro.scene import Scene
from vibro.solver import Grid, Scratch

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import ArrayLike, NDArray

    from vibro.results.attractors import Attractor

    Floats = NDArray[np.float64]

__all__ = ["follow"]

_NEWTONS: Final = 10
_CLOSED: Final = 1e-10  # [rad, 1] Newton step after which rounding alone is left
_DIFFERENCE: Final = 1e-6  # [1] of the range: step of the difference by the quantity
_LONGEST: Final = 0.02  # [rad, 1] step of the phase and of the speed
_BEGINS: Final = 0.05  # [rad, 1] distance of a start from its cycle, at most
_LEAST: Final = 1e-9  # [rad, 1] step at which the branch has ended
_ASIDE: Final = 0.3  # [1] of a step: distance of a cycle from its prediction above which the step is too long
_BEND: Final = 0.9  # [1] cosine of the angle between tangents below which it is, too
_JUMP: Final = 1e-3  # [rad, 1] change of a landing over that step, above which it is another one
_MOST: Final = 20_000  # cycles of a branch


class _Round(NamedTuple):
    """A cycle's flights: what is left open at their end, derivatives, and the map's trace and determinant."""

    open: Floats
    slopes: Floats  # with respect to phase and speed
    trace: float
    determinant: float


class _Point(NamedTuple):
    """A cycle of the branch: phase [rad], speed and value in units of theirs, and the branch's tangent."""

    state: Floats
    tangent: Floats
    round: _Round


class _LostError(Exception):
    """No cycle was found near the one that was expected; it may name the kind of event that ends there."""


class _Rounds:
    """The map over ``count`` flights and ``cycles`` turns, of scenes that differ in one quantity.

    Parameters
    ----------
    scene : Scene
        One operating point.
    name : str
        The quantity.
    ends : tuple of float
        Its first and last value; a state counts from the one to the other, 0 to 1.
    count, cycles : int
        Flights, and drive cycles.
    unit : float
        Of speeds in a state, over A w n.
    """

    def __init__(
        self, scene: Scene, name: str, ends: tuple[float, float], count: int, cycles: int, unit: float
    ) -> None:
        self.scene, self.name, self.ends = scene, name, ends
        self.count, self.cycles, self.unit = count, cycles, unit
        self._fields, self._scratch = scene.arrays(), Scratch()
        self._numbers, self._along = np.zeros((7, 1)), np.zeros(3)
        self._flown = np.zeros((8, LONGEST_CYCLE))
        self._rows = doors().rows(self._numbers), doors().rows(self._flown), doors().row(self._along)

    def value(self, state: Floats) -> float:
        """Return the value of the quantity, exact at both ends."""
        first, last = self.ends
        return float(last if state[2] == 1.0 else first + (last - first) * state[2])

    def _grid(self, value: float) -> Grid:
        if not (math.isfinite(value) and QUANTITIES[self.name].allows(value)):
            raise _LostError
        changed: dict[str, Any] = {self.name: np.asarray(value)}
        return Grid(self._fields._replace(**changed))

    def weight(self, value: float) -> float:
        """Return the unit n of normal speeds, over A w."""
        grid = self._grid(value)
        doors().return_of_flights(grid.scenes, grid.place(), self._rows[1], 0.0, 0.0, 1, self._rows[0])
        return float(self._numbers[6, 0])

    def fly(self, state: Floats) -> _Round:
        """Fly from a state.

        Raises
        ------
        _LostError
            If a landing leads to a contact, or the trough throws no body.
        """
        grid = self._grid(self.value(state))
        phase, speed = float(state[0]), float(state[1]) * self.unit
        if not (math.isfinite(phase) and speed >= 0.0):
            raise _LostError
        flies = doors().return_of_flights(
            grid.scenes, grid.place(), self._rows[1], phase, speed, self.count, self._rows[0]
        )
        if flies != 1:
            raise _LostError("contact" if flies == 0 else "hop_limit")
        elapsed, after, a, b, c, d, _ = self._numbers[:, 0].tolist()
        left = np.array([elapsed - TURN * self.cycles, (after - speed) / self.unit])
        if not np.isfinite(left).all():
            raise _LostError
        slopes = np.array([[a - 1.0, b * self.unit], [c / self.unit, d - 1.0]])
        return _Round(left, slopes, a + d, a * d - b * c)

    def jacobian(self, state: Floats, at: _Round) -> Floats:
        """Return the derivatives with respect to phase, speed and value; shape (2, 3)."""
        ends = []
        for x in (state[2] - _DIFFERENCE, state[2] + _DIFFERENCE):
            try:
                ends.append((x, self.fly(np.array([*state[:2], x])).open))
            except _LostError:  # at the end of a branch, or of what the quantity may be
                ends.append((state[2], at.open))
        (low, before), (high, after) = ends
        if low == high:
            raise _LostError
        return np.column_stack((at.slopes, (after - before) / (high - low)))

    def close(self, guess: Floats, across: Floats, tangent: Floats) -> _Point:
        """Find the cycle near a guess, in the plane through it with the normal vector ``across``.

        Raises
        ------
        _LostError
            If Newton's iteration does not end.
        """
        state = guess.copy()
        for _ in range(_NEWTONS):
            now = self.fly(state)
            slopes = self.jacobian(state, now)
            try:
                step = np.linalg.solve(
                    np.vstack((slopes, across)), -np.append(now.open, across @ (state - guess))
                )
            except np.linalg.LinAlgError:
                raise _LostError from None
            state = state + step
            state[1] = max(state[1], 0.0)
            if np.abs(step).max() <= _CLOSED:
                break
        else:
            raise _LostError
        if across[2] == 1.0 and not across[:2].any():
            state[2] = guess[2]  # to the last bit
        now = self.fly(state)
        along = np.cross(*self.jacobian(state, now))
        along /= math.copysign(float(np.linalg.norm(along)), float(along @ tangent))
        return _Point(state, along, now)

    def halves(self, state: Floats) -> Floats:
        """Return the difference of the take-offs that begin both halves of a cycle: phase, speed."""
        self.fly(state)
        phase, speed = self._flown[0], self._flown[1] / self.unit
        half = self.count // 2
        return np.array([math.remainder(phase[half] - phase[0], TURN), speed[half] - speed[0]])

    def along(self, state: Floats, velocity: float) -> tuple[list[float], bool, float]:
        """Follow a body along the trough from a velocity [A w].

        Returns the velocity at which it repeats, its displacement per drive cycle and the slope of its map;
        whether it repeats; and the unit of normal speeds over A w.
        """
        grid = self._grid(self.value(state))
        self.fly(state)
        status = doors().flights_along(
            grid.scenes, grid.place(), self._rows[1], self._scratch.hops, self.count, self.cycles, velocity,
            self._rows[2],
        )  # fmt: skip
        return self._along.tolist(), status <= Status.BOUNDARY, float(self._numbers[6, 0])

    def impacts(self) -> Floats:
        """Landing speeds of the cycle that was flown last [A w n]."""
        return self._flown[3, : self.count].copy()


@shielded
def follow(scene: Scene, name: str, values: ArrayLike, *, start: Attractor | None = None) -> Branch:
    """Follow one cycle of flights as a quantity varies, past folds and period doublings, stable or not.

    Parameters
    ----------
    scene : Scene
        One operating point, of shape ().
    name : str
        Name of the quantity that varies: a field of the scene, such as ``amplitude`` or ``restitution``.
    values : array_like
        Values of the quantity in SI units, rising or falling. The branch is followed from the first towards
        the last value, with steps no longer than the distance between neighbours, until it leaves their
        range.
    start : Attractor, optional
        The cycle at the first value, one of ``vibro.attractors``; by default that of a body from rest.

    Returns
    -------
    Branch
        The cycles in the order of the branch, with its folds and period doublings.

    Raises
    ------
    SceneError
        If the scene is more than one operating point, it has no such quantity, or the cycle has a phase in
        contact. The normal motion of such a cycle is always stable: use ``vibro.solve`` over the quantity.

    Notes
    -----
    Folds and doublings agree with the closed forms, Eq. (72), to 1e-9 (tests/motion/test_continuation.py).
    The branch is that of the normal motion. Where several motions along the trough belong to it, that one is
    taken in which a body settles that starts with the velocity of the previous cycle of the branch.

    Examples
    --------
    A part without restitution that is thrown once per drive cycle; its period doubles at K = hypot(pi, 2):

    >>> import numpy as np, vibro
    >>> scene = vibro.Scene(amplitude=9e-3, frequency=15, drive_angle=0.5, static_friction=0.6,
    ...                     kinetic_friction=0.5)
    >>> vibro.follow(scene, "amplitude", np.linspace(8e-3, 9e-3, 11))
    <cycle of 1 flight in 1 turn: doubling at 8.579018902 mm, end at 9 mm>
    """
    if scene.shape:
        raise SceneError((Problem("scene", f"shape {scene.shape}", "one operating point, of shape ()"),))
    points = _checked(scene, name, values)
    begin = _at(scene, name, float(points[0]))
    grid_of(begin)  # raises where nothing can be followed
    if start is None:
        start = next((one for one in attractors(begin) if one.from_rest), None)
    if start is None or set(start.pattern) != {"H"}:
        given = "no cycle from rest" if start is None else f"a cycle {start.pattern}"
        allowed = (
            "a cycle of flights alone (H), such as one of vibro.attractors at the first value; one with a"
            " contact is stable in its normal motion, use vibro.solve over the quantity"
        )
        raise SceneError((Problem("start", given, allowed),))
    rounds, first = _begin(scene, name, points, begin, start)
    velocity = start.start_velocity / (float(begin.scale) * TURN * float(begin.frequency))
    branch, events = _continued(rounds, first, points)
    return _measured(rounds, branch, events, velocity)


def _checked(scene: Scene, name: str, values: ArrayLike) -> Floats:
    """Return the values, which the scene must be able to have."""
    fields = scene.arrays()._asdict()
    known = [key for key in fields if key in QUANTITIES and getattr(scene, key, None) is not None]
    if name not in known:
        raise SceneError((Problem("name", repr(name), f"one of {', '.join(known)}"),))
    points = real_array(values)
    if points.ndim != 1 or points.size < 2 or not (
        (np.diff(points) > 0.0).all() or (np.diff(points) < 0.0).all()
    ):  # fmt: skip
        shown = f"shape {points.shape}"
        raise SceneError((Problem("values", shown, "at least two in a row, all rising or all falling"),))
    for value in (points.min(), points.max()):
        _at(scene, name, float(value))
    return points


def _at(scene: Scene, name: str, value: float) -> Scene:
    """Return the scene with another value of a quantity."""
    given = {key: getattr(scene, key) for key in scene.__dataclass_fields__}
    return Scene(**{key: x for key, x in given.items() if x is not None} | {name: value})


def _begin(scene: Scene, name: str, points: Floats, begin: Scene, start: Attractor) -> tuple[_Rounds, _Point]:
    """Close the cycle at the first value."""
    speed = start.start_normal_velocity / (float(begin.scale) * TURN * float(begin.frequency))
    ends = float(points[0]), float(points[-1])
    rounds = _Rounds(scene, name, ends, len(start.pattern), start.period_cycles, 1.0)
    inwards = np.array([0.0, 0.0, 1.0])
    try:
        weight = rounds.weight(ends[0])
        rounds.unit = max(speed / weight, 1.0)
        guess = np.array([start.start_phase, speed / weight / rounds.unit, 0.0])
        found = rounds.close(guess, inwards, inwards)
    except _LostError:
        found = None
    if found is None or np.abs(found.state - guess).max() > _BEGINS:
        shown = f"{start.pattern} at {QUANTITIES[name].text(QUANTITIES[name].from_si(ends[0]))}"
        raise SceneError((Problem("start", shown, "a cycle of the scene at the first of the values"),))
    return rounds, found


def _continued(rounds: _Rounds, first: _Point, points: Floats) -> tuple[list[_Point], list[tuple[str, int]]]:
    """Follow the branch; return its cycles, and the kinds of its events with their rows."""
    branch, events = [first], list[tuple[str, int]]()
    marks = np.abs((points - points[0]) / (points[-1] - points[0]))
    length = math.inf
    while len(branch) < _MOST:
        last = branch[-1]
        length = min(length, _longest(last, marks))
        try:
            found = _step(rounds, last, length)
            between = _events(rounds, last, found)
        except _LostError:
            length *= 0.5
            if length >= _LEAST:
                continue
            return branch, [*events, (_why_lost(rounds, last), len(branch) - 1)]
        for kind, point in between:
            branch.append(point)
            events.append((kind, len(branch) - 1))
        if between and between[-1][0] == "halved":
            return branch, [*events[:-1], ("doubling", len(branch) - 1)]
        branch.append(found)
        length *= 2.0
        if found.state[2] in (0.0, 1.0):
            return branch, [*events, ("end", len(branch) - 1)]
    return branch, [*events, ("cut", len(branch) - 1)]


def _longest(last: _Point, marks: Floats) -> float:
    """Return the longest step: the distance of neighbouring values, or less where the branch bends."""
    ahead = last.tangent[2] > 0.0
    row = int(np.searchsorted(marks, last.state[2], side="right" if ahead else "left"))
    row = min(max(row, 1), marks.size - 1)
    room = np.array([_LONGEST, _LONGEST, marks[row] - marks[row - 1]])
    with np.errstate(divide="ignore"):
        return float((room / np.abs(last.tangent)).min())


def _step(rounds: _Rounds, last: _Point, length: float) -> _Point:
    """Step along the branch, to the end of the range at most."""
    guess = last.state + length * last.tangent
    if 0.0 < guess[2] < 1.0:
        found = rounds.close(guess, last.tangent, last.tangent)
        guess = found.state
    if not 0.0 < guess[2] < 1.0:
        end = 1.0 if guess[2] >= 1.0 else 0.0
        if last.tangent[2] == 0.0 or last.state[2] == end:
            raise _LostError
        guess = last.state + (end - last.state[2]) / last.tangent[2] * last.tangent
        guess[2] = end  # exactly, without rounding
        found = rounds.close(guess, np.array([0.0, 0.0, 1.0]), last.tangent)
    way = found.state - last.state
    size = float(np.linalg.norm(way))
    if (
        not 0.0 < size <= 2.0 * length
        or np.linalg.norm(way - (way @ last.tangent) * last.tangent) > _ASIDE * size
        or found.tangent @ last.tangent < _BEND
    ):
        raise _LostError
    return found


def _events(rounds: _Rounds, last: _Point, found: _Point) -> list[tuple[str, _Point]]:
    """Locate what happens to the cycle between two neighbours, in order; ``halved`` where the branch ends."""
    if rounds.count % 2 == 0 and rounds.cycles % 2 == 0:
        before, after = rounds.halves(last.state), rounds.halves(found.state)
        if before @ after <= 0.0 and before.any():
            return [("halved", _halved(rounds, last, found, before, after))]
    reach = float((found.state - last.state) @ last.tangent)

    def point(s: float) -> _Point:
        return rounds.close(last.state + s * last.tangent, last.tangent, last.tangent)

    events = []
    for kind, test in (("fold", _turning), ("doubling", _flipping)):
        if test(last) * test(found) < 0.0:
            s = _root(lambda s, test=test: test(point(s)), 0.0, reach)  # type: ignore[misc]
            events.append((s, kind, point(s)))
    return [(kind, at) for _, kind, at in sorted(events, key=lambda event: event[0])]


def _turning(at: _Point) -> float:
    """Return a function that is 0 at a fold."""
    return float(at.tangent[2])


def _flipping(at: _Point) -> float:
    """Return a function that is 0 at a period doubling."""
    return 1.0 + at.round.trace + at.round.determinant


def _halved(rounds: _Rounds, last: _Point, found: _Point, before: Floats, after: Floats) -> _Point:
    """Locate where both halves of a cycle become one: where the cycle of half the period doubles.

    There two branches meet, the one of the doubled cycle and that of the other, so that only the latter is
    well conditioned.
    """
    half = _Rounds(rounds.scene, rounds.name, rounds.ends, rounds.count // 2, rounds.cycles // 2, rounds.unit)
    share = float(before @ before / (before @ before - before @ after))
    guess = last.state + share * (found.state - last.state)
    guess[:2] += 0.5 * (before + share * (after - before))
    across = np.array([0.0, 0.0, 1.0])
    beside = max(abs(float(found.state[2] - last.state[2])), _DIFFERENCE)

    def at(x: float) -> _Point:
        return half.close(np.array([*guess[:2], x]), across, across)

    from scipy.optimize import newton

    try:
        x = float(newton(lambda x: _flipping(at(x)), guess[2], x1=guess[2] + 0.1 * beside, tol=1e-14))
    except RuntimeError:
        raise _LostError from None
    single = at(x)
    length = float(np.linalg.norm(found.state - last.state))
    if np.abs(single.state - guess).max() > length:
        raise _LostError
    return _Point(single.state, found.tangent, rounds.fly(single.state))


def _root(function: Callable[[float], float], low: float, high: float) -> float:
    from scipy.optimize import brentq

    return float(brentq(function, low, high, xtol=1e-14, rtol=1e-14))


def _why_lost(rounds: _Rounds, last: _Point) -> str:
    """Return the kind of the end of a branch, beyond which there is no such cycle."""
    try:
        beyond = rounds.fly(last.state + 2.0 * _LEAST * last.tangent)
    except _LostError as lost:
        return str(lost) or "cut"
    return "grazing" if np.abs(beyond.open).max() > _JUMP else "cut"  # it lands elsewhere


def _measured(
    rounds: _Rounds, branch: list[_Point], events: list[tuple[str, int]], velocity: float
) -> Branch:
    """Follow the body along the trough, and put all into SI units."""
    columns: dict[str, list[Any]] = {}
    for point in branch:
        value = rounds.value(point.state)
        scene = _at(rounds.scene, rounds.name, value)
        (along, displacement, slope), repeats, weight = rounds.along(point.state, velocity)
        velocity = along if repeats else velocity
        length, frequency = float(scene.scale), float(scene.frequency)
        speed = length * TURN * frequency
        half, determinant = 0.5 * point.round.trace, point.round.determinant
        root = np.sqrt(complex(half * half - determinant))
        normal = np.array([half + root, half - root])
        row = {
            "values": value,
            "start_phase": float(point.state[0]) % TURN,
            "start_velocity": speed * along if repeats else math.nan,
            "start_normal_velocity": speed * weight * rounds.unit * float(point.state[1]),
            "landing_speeds": speed * weight * rounds.impacts(),
            "displacement_per_cycle": length * displacement if repeats else math.nan,
            "mean_velocity": length * displacement * frequency if repeats else math.nan,
            "normal_multipliers": normal,
            "largest_multiplier": max(slope, *np.abs(normal)) if repeats else math.nan,
        }
        for key, x in row.items():
            columns.setdefault(key, []).append(x)
    arrays: dict[str, Any] = {key: np.array(column) for key, column in columns.items()}
    told = tuple(
        BranchEvent(kind=kind, value=float(arrays["values"][row]), row=row)  # type: ignore[arg-type]
        for kind, row in events
    )
    return Branch(name=rounds.name, period_cycles=rounds.cycles, events=told, **arrays)
