"""Other motions of hopping scenes than the one from rest: where a disturbed body can settle.

Two kinds: it slides otherwise between the same flights, or it flies otherwise.
Lengths in A, speeds in A w, phases in radians.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np

from vibro.core.codes import Status
from vibro.core.flight.bounces import bounces
from vibro.core.flight.cycles import entered
from vibro.core.flight.drift import FLOOR, has_stop, span_of
from vibro.core.flight.orbits import Fixed, between, from_rest, joined, stopping
from vibro.core.flight.repeats import single_bounces
from vibro.core.flight.returns import hops_of, return_map
from vibro.core.groups import take

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from vibro.core.contact.slide import Floats
    from vibro.core.flight.drift import Span
    from vibro.core.flight.orbits import Orbits
    from vibro.core.flight.returns import Cells, Hops
    from vibro.core.groups import Loads

    Bools = NDArray[np.bool_]

__all__ = ["coexisting"]

_TURN: Final = 2.0 * np.pi

_APART: Final = 1e-9  # [A w] fixed points closer than this are one
_OTHER: Final = 1e-6  # [A w n] difference of the largest landing speeds of two cycles of flights

# Starts from which other flights are looked for: on the cycles of one bounce each that lasts up to so many
# turns, and on a grid of phases and speeds.
_LONGEST: Final = 16
_PHASES: Final = 8
_SPEEDS: Final = 6
_MOST_FLIGHTS: Final = 64


def coexisting(scene: Loads, restitution: Floats, period: Floats, impact: Floats) -> Bools:
    """Tell where other motions than that from rest were found.

    Parameters
    ----------
    scene : Loads
        Groups of scenes that hop, 1-D, or 0-d members for all.
    restitution : array
        e, 1-D or 0-d.
    period : array
        Drive cycles of the motion from rest, NaN where it does not repeat; 1-D.
    impact : array
        Its largest landing speed [A w]; 1-D.

    Returns
    -------
    bool array
        True where other relative velocities repeat with the same flights (all of them are found), or where
        other flights repeat, of those that 64 starts lead to within 64 flights.
    """
    found = np.zeros(period.shape, np.bool_)
    throw = np.broadcast_to(scene.across / scene.normal, period.shape)
    restitution = np.broadcast_to(restitution, period.shape)
    for search in (_slides_otherwise, _flies_otherwise):
        left = np.flatnonzero(~found)
        if left.size:
            group = throw, restitution, period, impact / scene.normal
            found[left] = search(take(scene, left), *take(group, left))
    return found


def _flies_otherwise(
    scene: Loads, throw: Floats, restitution: Floats, period: Floats, impact: Floats
) -> Bools:
    """Tell whether other flights repeat than those from rest."""
    del scene  # friction has no part in it
    phase, speed = _starts(throw, restitution)
    count = phase.shape[1]
    owner = np.repeat(np.arange(throw.size), count)
    start = phase.reshape(-1), speed.reshape(-1)
    motion = bounces(throw[owner], restitution[owner], _MOST_FLIGHTS, start)
    largest = np.zeros(owner.size)
    np.maximum.at(largest, motion.cycle.owner, motion.cycle.impact)
    # a contact leads to the motion from rest
    amid = motion.repeats & (motion.rest == 0.0)
    same = (motion.cycles == period[owner]) & (np.abs(largest - impact[owner]) <= _OTHER * (1.0 + largest))
    other: Bools = (amid & ~same).reshape(-1, count).any(axis=1)
    return other


def _starts(throw: Floats, restitution: Floats) -> tuple[Floats, Floats]:
    """Phases and speeds of take-offs, one row a scene."""
    k, e = throw[:, None], restitution[:, None]
    bounce_phase, bounce_speed, _ = single_bounces(k, e, np.arange(1, _LONGEST + 1))
    exists = np.isfinite(bounce_phase)
    most = np.maximum(exists.sum(axis=1, keepdims=True), 1)
    grid = np.arange(_PHASES * _SPEEDS)
    phase = np.broadcast_to(_TURN * (grid % _PHASES) / _PHASES, (throw.size, grid.size))
    share = (grid // _PHASES + 0.5) / _SPEEDS
    speed = share * (most + 0.5) * np.pi
    # where there is no such bounce a start from the crest, with its speed, is as good as any
    bounce_phase = np.where(exists, bounce_phase, 0.5 * np.pi)
    return np.concatenate((bounce_phase, phase), axis=1), np.concatenate((bounce_speed, speed), axis=1)


def _slides_otherwise(
    scene: Loads, throw: Floats, restitution: Floats, period: Floats, impact: Floats
) -> Bools:
    """Tell whether other velocities repeat with the flights from rest."""
    del impact
    several = np.zeros(throw.size, np.bool_)
    motion = bounces(throw, restitution)
    cyclic = np.flatnonzero(motion.repeats & np.isfinite(period))
    if cyclic.size:
        cells, start = take(entered(scene, motion), cyclic)
        hops, turns = hops_of(scene, motion.cycle), np.multiply(_TURN, motion.cycles[cyclic])
        span = span_of(cells, turns)
        several[cyclic] = _several(cells, hops, start, span, from_rest(cells, hops, start, span))
    return several


def _several(cells: Cells, hops: Hops, start: Floats, span: Span, home: Orbits) -> Bools:
    """Tell whether there are more fixed points than ``home``.

    The one without a stop is either ``home``, or it is looked for: between the limits of all velocities and
    the outermost fixed points with a stop, and between ``home`` and these limits.
    """
    n = start.size
    fixed = stopping(cells, hops, start, span, return_map(cells, hops, start))
    fixed = joined(fixed, Fixed(np.arange(n), home.velocity, home.cycle))
    low, high = span.bound.copy(), -span.bound
    np.minimum.at(low, fixed.owner, fixed.velocity)
    np.maximum.at(high, fixed.owner, fixed.velocity)
    unknown = np.flatnonzero(has_stop(home.cycle))
    owner = np.concatenate((unknown, unknown))
    begin = np.concatenate((-span.bound[unknown], span.bound[unknown]))
    aim = np.concatenate((low[unknown], high[unknown]))
    sliding = between(take(cells, owner), hops, begin, aim, take(span, owner))
    seen = np.flatnonzero(sliding.status == Status.OK)
    fixed = joined(fixed, Fixed(owner[seen], sliding.velocity[seen], take(sliding.cycle, seen)))

    with np.errstate(divide="ignore", invalid="ignore"):
        blur = FLOOR * span.forces[fixed.owner] / (1.0 - fixed.cycle.slope)
    apart = np.abs(fixed.velocity - home.velocity[fixed.owner]) > np.maximum(_APART, 8.0 * blur)
    several = np.zeros(n, np.bool_)
    several[fixed.owner[apart]] = True
    return several
