"""What bodies of ``bouncing_body`` do in the long run: cycles that recur, and means over many bodies."""

from __future__ import annotations

from typing import Final, NamedTuple

import numpy as np
from bouncing_body import KICK, TURN, Bodies, Fields, Floats, Indices, Mask
from numpy.typing import ArrayLike, NDArray

SAME: Final = 1e-8  # [A, A w] smaller differences of states count as none
FIRST_TURNS: Final = 32  # before a recurrence is looked for; then twice as many more, and so on
MOST_TURNS: Final = 2048
MOST_PERIOD: Final = 64  # [turns]
FAST: Final = 8.0  # speeds of the trough: a body that is faster along it, and still gains speed, runs away

COPIES: Final = 32  # bodies of a scene, for a mean
FIRST_WINDOW: Final = 512  # turns of the drive
LAST_WINDOW: Final = 16_384
MOST_LANDINGS: Final = 200_000  # of a body in a window after the first
RELAXATIONS: Final = 10.0  # before a window, of the speed along the trough
DRIFT: Final = 3.0  # standard errors between the halves of a window: beyond, they have not settled


class Recurrence(NamedTuple):
    """What bodies repeat; arrays over bodies, NaN where nothing recurs.

    Attributes
    ----------
    period : array of int
        Turns of the drive until the state recurs; 0 where it does not.
    displacement : array
        A turn [m].
    peak : array
        Largest relative speed along the trough [m/s].
    flight_fraction : array
    runs_away : array of bool
        Whether the body gains speed for ever: friction cannot hold the weight of one that keeps sliding, and
        its speed is beyond that of the trough and grows.
    """

    period: NDArray[np.int64]
    displacement: Floats
    peak: Floats
    flight_fraction: Floats
    runs_away: Mask


def recurrence(
    fields: Fields,
    copies: int = 1,
    *,
    start: tuple[ArrayLike, ArrayLike, ArrayLike] | None = None,
    kick: float = 0.0,
    seed: int = 1,
) -> Recurrence:
    """Follow bodies until their states at the ends of turns recur.

    Parameters
    ----------
    fields, copies, start, kick, seed
        As for ``Bodies``. With a kick only cycles recur that noise hardly changes.
    """
    bodies = Bodies(fields, copies, start=start, kick=kick, seed=seed)
    n = bodies.phase.size
    displacement, peak, flight = np.full((3, n), np.nan)
    found = Recurrence(np.zeros(n, np.int64), displacement, peak, flight, np.zeros(n, np.bool_))
    s = bodies.scenes
    steep = np.abs(s.tangential) > s.mu_d * s.normal
    going, turns = np.arange(n), FIRST_TURNS
    while going.size and turns <= MOST_TURNS:
        # A period is seen at least twice.
        watched = min(turns // 2, 2 * MOST_PERIOD)
        before = np.abs(bodies.velocity)
        for _ in range(turns - watched):
            bodies.turn(going)
        going = _watch(bodies, going, watched, found)
        # The speed of the trough along itself is A w cos(alpha).
        speed = np.abs(bodies.velocity)
        away = going[(steep & (speed > np.maximum(FAST * s.along, before)))[going]]
        found.runs_away[away] = True
        going = np.setdiff1d(going, away)
        turns *= 2
    return found


def _watch(bodies: Bodies, some: Indices, turns: int, found: Recurrence) -> Indices:
    """Watch bodies for a while, note which recur, and return those that do not."""
    states, places, flying, peaks = [], [], [], []
    for turn in range(turns + 1):
        states.append(bodies.states(some))
        places.append(bodies.place[some])
        flying.append(bodies.flying[some])
        if turn < turns:
            bodies.peak[some] = 0.0
            bodies.turn(some)
            peaks.append(bodies.peak[some])
    state, place, flight, peak = (np.array(x) for x in (states, places, flying, peaks))
    left = np.ones(some.size, np.bool_)
    for m in range(1, turns // 2 + 1):
        same = left & (np.abs(state[m:] - state[:-m]).max(axis=(0, 2)) < SAME)
        which = some[same]
        found.period[which] = m
        found.displacement[which] = (place[-1] - place[-1 - m])[same] / m * bodies.length[which]
        found.flight_fraction[which] = (flight[-1] - flight[-1 - m])[same] / (m * TURN)
        found.peak[which] = peak[-m:, same].max(axis=0) * bodies.speed[which]
        left &= ~same
    return some[left]


class Means(NamedTuple):
    """Means over many bodies of each scene, each kicked at random at its lift-offs; arrays over scenes.

    Attributes
    ----------
    displacement, error : array
        A turn, and its standard error from the differences between the bodies [m].
    flight_fraction : array
    settled : array of bool
        Whether both halves of the window agree and the speed along the trough had time to relax.
    """

    displacement: Floats
    error: Floats
    flight_fraction: Floats
    settled: Mask


def long_run(fields: Fields, *, copies: int = COPIES, last: int = LAST_WINDOW, seed: int = 1) -> Means:
    """Follow bodies of each scene side by side from rest, until what came before is forgotten.

    A window of turns follows as many turns that are left out. Where its halves disagree, or the speed along
    the trough had no time to relax, the next window is twice as long; not where even the last is too short,
    or bounces are too many.

    Parameters
    ----------
    fields : mapping
        As for ``Bodies``.
    copies : int, optional
        Bodies of each scene.
    last : int, optional
        Longest window [turns].
    seed : int, optional
        Of the kicks.
    """
    bodies = Bodies(fields, copies, kick=KICK, seed=seed)
    n = bodies.phase.size // copies
    displacement, error, flight = np.full((3, n), np.nan)
    out = Means(displacement, error, flight, np.zeros(n, np.bool_))
    # Friction takes 2 pi mu_d N a turn from a speed of the size of the trough's own.
    s = bodies.scenes
    speed, friction = s.along[::copies], TURN * (s.mu_d * s.normal)[::copies]
    relaxation = np.divide(speed, friction, out=np.zeros(n), where=friction > 0.0)
    every, window = np.arange(n * copies).reshape(n, copies), FIRST_WINDOW
    # A window holds no whole number of periods. Bodies that start up to so many turns later than others see
    # different parts of theirs, and show what that makes of the mean.
    late = np.random.default_rng(seed).integers(0, MOST_PERIOD, n * copies)
    for turn in range(MOST_PERIOD + window):
        bodies.turn(np.flatnonzero(late <= turn))
    going = np.arange(n)
    while going.size and window <= last:
        some = every[going].reshape(-1)
        places, flying = [bodies.place[some]], bodies.flying[some]
        landed = bodies.landings[every[going]].max(axis=1)
        for _ in range(2):
            for _ in range(window // 2):
                bodies.turn(some)
            places.append(bodies.place[some])
        halves = np.diff(np.array(places), axis=0).reshape(2, -1, copies) / (window // 2)
        out.displacement[going], out.error[going] = _mean(halves.mean(axis=0))
        drift, its_error = _mean(halves[1] - halves[0])
        flown = (bodies.flying[some] - flying).reshape(-1, copies).mean(axis=1)
        out.flight_fraction[going] = flown / (window * TURN)
        relaxed = window >= RELAXATIONS * relaxation[going]
        out.settled[going] = relaxed & (np.abs(drift) <= DRIFT * its_error + SAME * s.load[some[::copies]])
        landings = bodies.landings[every[going]].max(axis=1) - landed
        window *= 2
        goes_on = ~out.settled[going] & (RELAXATIONS * relaxation[going] <= last)
        going = going[goes_on & (2 * landings <= MOST_LANDINGS)]
    unit = bodies.length[::copies]
    return out._replace(displacement=out.displacement * unit, error=out.error * unit)


def _mean(values: Floats) -> tuple[Floats, Floats]:
    """Mean over the last axis and its standard error."""
    error = values.std(axis=-1, ddof=1) / np.sqrt(values.shape[-1])
    return values.mean(axis=-1), error
