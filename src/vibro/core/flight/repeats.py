"""Cycles of the normal motion without contact: flights that nearly repeat, closed by Newton's iteration.

Phases in radians, normal speeds over n = cos(beta)/G [A w n].
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np

from vibro.core.flight.landing import Flights, after_landing, carried, landed
from vibro.core.flight.trajectory import flight
from vibro.core.groups import take
from vibro.core.roots import OpenCells

if TYPE_CHECKING:
    from collections.abc import Iterator

    from numpy.typing import NDArray

    from vibro.core.contact.slide import Floats

    Bools = NDArray[np.bool_]
    Counts = NDArray[np.intp]

__all__ = ["close", "near_repeat", "single_bounces"]

_TURN: Final = 2.0 * np.pi

_LONGEST_CYCLE: Final = 64  # flights in a cycle that never rests on the trough
_NEAR: Final = 0.1  # [rad, A w n] distance, over the number of flights between, of states that may be one
_PREFERRED: Final = 4.0  # [1] factor by which more flights must bring a state closer to be preferred
_NEWTON_STEPS: Final = 12
_FIRST_STEP: Final = 0.1  # [rad, A w n] longest first step
_SHRINKS: Final = 0.75  # [1] a longer next step, over the one before, shows that there is no cycle nearby
_CLOSED: Final = 1e-12  # [1] relative distance at which a cycle is closed
_SAME: Final = 1e-8  # [1] relative distance below which a cycle repeats within itself


def single_bounces(throw: Floats, restitution: Floats, turns: Counts) -> tuple[Floats, Floats, Bools]:
    """Cycles of one bounce of so many turns: phase and speed of the take-off, and whether they are stable.

    Eq. (37): it lands with the speed 2 pi m / (1 + e), where K cos p = pi m (1 - e) / (1 + e). The phase is
    NaN where there is no such cycle.
    """
    e = restitution
    cosine = np.pi * turns * (1.0 - e) / (throw * (1.0 + e))
    phase = np.arccos(np.where(cosine < 1.0, cosine, np.nan))
    stiffness = (1.0 + e) ** 2 * throw * np.sin(phase)
    return phase, _TURN * turns * e / (1.0 + e) + 0.0 * throw, stiffness < 2.0 * (1.0 + e * e)


def near_repeat(records: list[Flights]) -> Counts:
    """Count back to the flight that began nearly as the last did; 0 where there is none."""
    last = records[-1]
    found = np.zeros(last.owner.shape, np.intp)
    nearest = np.full(last.owner.shape, _NEAR)
    for lag in range(1, min(_LONGEST_CYCLE, len(records) // 2) + 1):
        before = take(records[-1 - lag], np.searchsorted(records[-1 - lag].owner, last.owner))
        apart = lag * _apart(before.phase, before.speed, last.phase, last.speed)
        closer = (apart < nearest) & (last.before - before.before > np.pi)  # not within one chain of bounces
        found[closer] = lag
        nearest[closer] = apart[closer] / _PREFERRED
    return found


def _apart(phase: Floats, speed: Floats, other_phase: Floats, other_speed: Floats) -> Floats:
    return np.abs(2.0 * np.sin(0.5 * (phase - other_phase))) + np.abs(speed - other_speed)


def close(
    throw: Floats, restitution: Floats, records: list[Flights], guess: Counts
) -> Iterator[tuple[list[Flights], Counts, Counts]]:
    """Solve cycles of ``guess`` flights by Newton's iteration, from the last take-offs.

    Yields the flights of the stable ones, their scenes and their periods, for each number of flights.
    """
    for lag in np.unique(guess[guess > 0]).tolist():
        last = take(records[-1], np.flatnonzero(guess == lag))
        group = throw[last.owner], restitution[last.owner], last.phase, last.speed
        unclosed = OpenCells(last.owner, (*group, np.full(last.owner.shape, _FIRST_STEP)), _NEWTON_STEPS)
        for owner, (k, e, phase, speed, least) in unclosed:
            flights, end, slope, valid = _around(owner, k, e, phase, speed, lag)
            turn = np.mod(end[0] - phase + np.pi, _TURN) - np.pi
            residual = np.stack((turn, end[1] - speed))
            matrix = np.eye(2)[:, :, None] - slope
            determinant = matrix[0, 0] * matrix[1, 1] - matrix[0, 1] * matrix[1, 0]
            with np.errstate(divide="ignore", invalid="ignore"):
                step_phase = (matrix[1, 1] * residual[0] - matrix[0, 1] * residual[1]) / determinant
                step_speed = (matrix[0, 0] * residual[1] - matrix[1, 0] * residual[0]) / determinant
                step = np.abs(step_phase) + np.abs(step_speed)
                onward = np.mod(phase + step_phase, _TURN), np.maximum(speed + step_speed, 0.0)
            closed = step <= _CLOSED * (1.0 + k)
            trace = slope[0, 0] + slope[1, 1]
            product = slope[0, 0] * slope[1, 1] - slope[0, 1] * slope[1, 0]
            stable = (np.abs(trace) < 1.0 + product) & (np.abs(product) < 1.0)
            done = np.flatnonzero(closed & valid & stable)
            if done.size:
                yield from _shortest(take(tuple(flights), done), phase[done], end[0][done], lag)
            unclosed.keep(valid & ~closed & (step < least), (k, e, *onward, _SHRINKS * step))


def _around(
    owner: Counts, throw: Floats, restitution: Floats, phase: Floats, speed: Floats, lag: int
) -> tuple[list[Flights], tuple[Floats, Floats], Floats, Bools]:
    """Fly ``lag`` times; return the flights, the state after them, its derivatives and whether none rests."""
    flights = []
    slope = np.eye(2)[:, :, None] * np.ones(phase.size)
    valid = np.ones(phase.shape, np.bool_)
    total = phase.copy()
    for _ in range(lag):
        # a resting start that the trough would not let go stays where it is
        valid &= (speed > 0.0) | (throw * np.sin(phase) > 1.0)
        start = np.where(valid, phase, 0.5 * np.pi)
        step = flight(throw, start, speed)
        touch = start + step.length
        after = after_landing(throw, touch, step.impact, restitution)
        record, end = landed((owner, total, start, speed), step, touch, after)
        valid &= ~after.contact & (step.impact > 0.0)
        moderate = step._replace(impact=np.where(valid, step.impact, 1.0))
        slope = np.stack(carried(throw, restitution, start, moderate, (slope[0], slope[1])))
        flights.append(record)
        total = total + step.length
        phase, speed = np.mod(end, _TURN), after.take_off
    return flights, (total, speed), slope, valid


def _shortest(
    flights: tuple[Flights, ...], phase: Floats, end: Floats, lag: int
) -> Iterator[tuple[list[Flights], Counts, Counts]]:
    """Cut cycles that repeat within themselves."""
    period = np.rint((end - phase) / _TURN).astype(np.intp)
    left = np.ones(phase.shape, np.bool_)
    first = flights[0]
    for part in (n for n in range(1, lag + 1) if lag % n == 0):
        again = left.copy()
        if part < lag:
            apart = _apart(first.phase, first.speed, flights[part].phase, flights[part].speed)
            again &= apart <= _SAME * (1.0 + first.impact)
        cells = np.flatnonzero(again)
        if cells.size:
            yield list(take(flights[:part], cells)), first.owner[cells], period[cells] * part // lag
        left &= ~again
