"""The exact motion of one body from any start: a list of legs, and one steady cycle with a count.

A walk from leg to leg is compared with itself at the starts of slides, or of flights where the body hops.
Once it repeats, the legs between are a cycle, which is stored once, with a count, so that rounding does not
grow with the number of cycles. Lengths in A, speeds in A w, phases in radians.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Final, NamedTuple

import numpy as np

from vibro.core.codes import Mode
from vibro.core.contact.cycle_legs import middle_of
from vibro.core.contact.never_at_rest import never_at_rest
from vibro.core.contact.starts import resting_start
from vibro.core.flight.bounces import bounces
from vibro.core.walk.steps import starting, step

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from vibro.core.contact.slide import Floats
    from vibro.core.walk.steps import Course, State, Step

__all__ = ["Legs", "Motion", "Sections", "follow", "is_section", "sections_of"]

_TURN: Final = 2.0 * np.pi

# [rad, A w] Change from one cycle to the next that rounding alone brings.
_REPEATS: Final = 2e-15
# [rad, A w] Where cycles converge slowly rounding is amplified, up to this. A change below it that no longer
# shrinks is taken for rounding.
_NOISE: Final = 1e-11
_SHORTEST: Final = 2e-15  # [rad] legs up to this are rounding too
_NEAR: Final = 1e-6  # [rad] distance from a fixed point that rounding cannot bring


class Legs(NamedTuple):
    """Legs of one body, one after the other; 1-D arrays.

    Attributes
    ----------
    mode : int8 array
        Codes of ``Mode``.
    cycle : int64 array
        Drive cycles completed at the start.
    phase : array
        Phase of the trough's motion normal to itself at the start, in [0, 2 pi) [rad].
    length : array
        Phase from start to end [rad]; inf for a last one that never ends.
    position, velocity : array
        At the start.
    displacement : array
        Until the end.
    end_velocity : array
        At the end, before an impact.
    rate, impact : array
        Normal speed away from the trough at the start, and towards it at the end [A w].
    """

    mode: NDArray[np.int8]
    cycle: NDArray[np.int64]
    phase: Floats
    length: Floats
    position: Floats
    velocity: Floats
    displacement: Floats
    end_velocity: Floats
    rate: Floats
    impact: Floats


class Motion(NamedTuple):
    """A whole run.

    Attributes
    ----------
    transient : Legs
        Legs before the first repeat.
    steady : Legs
        The cycle that follows again and again; empty where it was not reached.
    period : int
        Drive cycles of the steady cycle, 0 without one.
    advance : float
        Displacement in it.
    """

    transient: Legs
    steady: Legs
    period: int
    advance: float


class Sections(NamedTuple):
    """Starts at which the motion of scenes is compared with itself; 1-D.

    In contact these are the starts of slides; of hopping bodies that come to rest on the trough in normal
    direction, the lift-offs; of others, every take-off.

    Attributes
    ----------
    lag : int array
        How many such starts of one kind make a cycle; 0 where the motion never repeats.
    lands : bool array
        Whether the cycle of a hopping body has a contact that ends with a lift-off.
    """

    lag: NDArray[np.intp]
    lands: NDArray[np.bool_]


def sections_of(course: Course) -> Sections:
    """Where to compare the motion of scenes with itself."""
    lag = np.ones(course.throw.shape, np.intp)
    lands = np.ones(course.throw.shape, np.bool_)
    hopping = np.flatnonzero(np.isfinite(course.track.lift_off))
    if hopping.size:
        flights = bounces(course.throw[hopping], course.restitution[hopping])
        lands[hopping] = flights.rest > 0.0
        lag[hopping] = np.where(lands[hopping], 1, np.where(flights.repeats, flights.cycle.number, 0))
    return Sections(lag, lands)


def is_section(course: Course, sections: Sections, at: State) -> NDArray[np.bool_]:
    """Whether a leg starts where the motion is compared."""
    lift_off = course.track.lift_off
    slides = np.isinf(lift_off) & (at.mode != Mode.REST)
    lifted = (at.rate == 0.0) & (at.phase == lift_off)
    flies = np.isfinite(lift_off) & (at.mode == Mode.FLIGHT) & (~sections.lands | lifted)
    return np.asarray((sections.lag > 0) & (slides | flies))


def follow(course: Course, phase: float, velocity: float, cycles: float) -> Motion:
    """Follow one body until its motion repeats, ends or has lasted ``cycles`` drive cycles.

    Parameters
    ----------
    course : Course
        Of one scene.
    phase, velocity : float
        Drive phase, and how fast the body slides, at the start.
    cycles : float
        Drive cycles from the start on; the last leg may end later.

    Returns
    -------
    Motion
        Positions count from the start.
    """
    sections = sections_of(course)
    lag = int(sections.lag[0])
    at = starting(course, np.array([phase]), np.array([velocity]))
    origin = at.phase[0]
    records: list[tuple[float, ...]] = []
    starts: dict[int, list[tuple[int, float]]] = {}  # by mode: which record, and its change since the last
    polished = False
    while at.cycle[0] + (at.phase[0] - origin) / _TURN < cycles:
        if is_section(course, sections, at)[0]:
            mode = int(at.mode[0])
            before = starts.get(mode, [])
            change = math.inf
            if len(before) >= lag:
                first, last_change = before[-lag]
                change = _change(records[first], at)
                stalls = change <= _NOISE and (polished or change >= last_change)
                if change <= _REPEATS or stalls:
                    exact = _never_at_rest_start(course, at) if change and not polished else None
                    if exact is None:
                        return _motion(course, records, first, at)
                    at = at._replace(phase=np.array([exact]))
                    polished, change = True, math.inf
                    starts.clear()
            starts.setdefault(mode, []).append((len(records), change))
        leg = step(course, at)
        if leg.length[0] > _SHORTEST:
            records.append(_record(at, leg))
        at = leg.after
        if not np.isfinite(leg.length[0]):
            break
    return _motion(course, records, len(records), at)


def _record(at: State, leg: Step) -> tuple[float, ...]:
    """Put a leg of one body in the order of ``Legs``."""
    values = (
        at.mode, at.cycle, at.phase, leg.length, at.position, at.velocity, leg.displacement,
        leg.velocity, at.rate, leg.impact,
    )  # fmt: skip
    return tuple(x.item() for x in values)


def _change(before: tuple[float, ...], now: State) -> float:
    """Distance between the states at two starts."""
    then = Legs._make(before)
    turn = math.remainder(now.phase.item() - float(then.phase), _TURN)
    return max(
        abs(turn), abs(now.velocity.item() - float(then.velocity)), abs(now.rate.item() - float(then.rate))
    )


def _never_at_rest_start(course: Course, at: State) -> float | None:
    """Start of this slide in the never-at-rest cycle, Eqs. (18)-(19); None where it does not settle there."""
    if np.isfinite(course.track.lift_off[0]) or not course.rests[0]:
        return None
    scene = course.track.scene
    with np.errstate(divide="ignore", invalid="ignore"):
        pair = [resting_start(scene, course.margins, direction) for direction in (1, -1)]
        cycle, _ = never_at_rest(scene, *pair)
    middle, half = middle_of(scene, cycle).item(), 0.5 * np.pi + cycle.y.item()
    start = (middle - half if at.mode[0] == Mode.FORWARD else middle + half) % _TURN
    return start if abs(math.remainder(start - at.phase.item(), _TURN)) < _NEAR else None


def _motion(course: Course, records: list[tuple[float, ...]], first: int, end: State) -> Motion:
    """Divide the legs into transient and steady cycle, and scale the normal speeds."""
    kinds = (np.int8, np.int64, *(np.float64,) * 8)
    columns = zip(*records, strict=True) if records else ((),) * len(kinds)
    legs = Legs._make(np.array(x, kind) for x, kind in zip(columns, kinds, strict=True))
    n = course.track.scene.normal[0]
    legs = legs._replace(rate=n * legs.rate, impact=n * legs.impact)
    transient, steady = (Legs._make(x[part] for x in legs) for part in (slice(first), slice(first, None)))
    if not steady.mode.size:
        return Motion(transient, steady, 0, 0.0)
    turn = (end.phase[0] - steady.phase[0]) / _TURN
    period = int(end.cycle[0] - steady.cycle[0]) + round(turn)
    return Motion(transient, steady, period, float(end.position[0] - steady.position[0]))
