"""Motions in which bodies from many starts settle, in SI units."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import TYPE_CHECKING, Final

import numpy as np

from vibro.core.codes import LETTERS, PATTERNS, Regime, spelt_text
from vibro.core.numbers import KNOWN, STARTS
from vibro.drives import Ability
from vibro.motion.histories import Start, follow_body, grid_of, number_of, start_of
from vibro.quantities import START_HEIGHT
from vibro.reals import shielded
from vibro.results.attractors import Attractor, Attractors, share_interval
from vibro.steady import CODES, NUMBERS, checked_starts
from vibro.threads import Scratch, doors

if TYPE_CHECKING:
    from vibro.scene import Scene
    from vibro.threads import Grid


_ROUNDING: Final = 1e-6  # [drive cycles] by which a cycle may seem to go on


@shielded
def attractors(scene: Scene, starts: int = STARTS, drops: float = 0.0) -> Attractors:
    """Find the motions in which bodies from many starts settle, and the share of the starts of each.

    Parameters
    ----------
    scene : Scene
        One operating point, of shape ().
    starts : int, optional
        Number of bodies, 1 to 4096: they start at rest relative to the trough, at the phases 2 pi i / starts
        of its motion along itself.
    drops : float, optional
        Height over the trough from which they start, >= 0; by default they are laid down on it [m].

    Returns
    -------
    Attractors
        Sequence of ``Attractor``, that of a body from rest at phase 0 first, the others by their shares; and
        the share of the starts whose motion is irregular.

    Raises
    ------
    SceneError, VibroError
        If the scene is more than one operating point, an argument is out of its range, or the motion cannot
        be simulated.

    Notes
    -----
    Every body is followed until its flights repeat, for up to 1024 flights (theory, section 10); the numbers
    of the motion are then those of the fixed point of Eq. (36), to rounding. Those that do not repeat are
    irregular. A body that rounding has led to a contact is kicked by up to 1e-12 A w there, so that no motion
    is listed which the least disturbance ends. In contact all cycles are fixed points of the return map
    (theory, section 5): also those are listed that no start leads to.

    Intervals of shares are those of random starts. Evenly spread starts are more precise where the starts of
    a motion lie together, but no random sample: a motion whose share is below ``Attractors.missed``, 5.7 % of
    64 starts, may be missing. Shares agree with those of bodies that another solver follows from random
    phases (tests/motion/test_attractors.py).

    Examples
    --------
    >>> import vibro
    >>> scene = vibro.Scene(amplitude=9.81 * 1.49149 / (2 * 3.141592653589793 * 15) ** 2, frequency=15,
    ...                     drive_angle=0.7034, static_friction=0.457783, kinetic_friction=0.0429106)
    >>> vibro.attractors(scene)
    share of starts         mm/s     pattern  period  mm a cycle  multiplier
    0.172 (0.099 to 0.282)  107.156  F_       1       7.14373     0           from rest
    0.828 (0.718 to 0.901)  9.49547  FB       1       0.633031    0.8593
    <64 bodies laid down at rest at evenly spread phases; all motions are known>
    """
    number, height = checked_starts(starts), number_of(replace(START_HEIGHT, name="drops"), drops)
    grid, solver, scratch = grid_of(scene), doors(), Scratch()
    start_of(scene, 0.0, 0.0, height, 0.0)
    room = number + KNOWN
    values, codes = np.empty((NUMBERS, room)), np.empty((CODES, room), np.int64)
    counts, means = np.empty(5, np.int64), np.empty(3)
    rows = *solver.rows(values), *solver.rows(codes)
    found = solver.row(counts), solver.row(means)
    solver.attractors(
        grid.scenes, grid.place(), number, height, scratch.flights, scratch.hops, rows, found, room
    )
    size, home, irregular, lost, away = counts.tolist()
    length, frequency = float(scene.scale), float(scene.frequency)
    speed = length * 2.0 * math.pi * frequency
    one_harmonic = scene.arrays().can(Ability.ONE_HARMONIC)
    motions = []
    for i, row in enumerate(values[:, :size].T.tolist()):
        phase, rate, velocity, displacement, period, multiplier, _, _, flights, peak = row
        code, regime, count = codes[:, i].tolist()
        if rate > 0.0:
            text = "H" * int(flights)
        else:
            text = spelt_text(code) if code > 0 else _spelt(grid, phase, velocity, period)
        low, high = share_interval(count, number)
        motions.append(
            Attractor(
                share=count / number,
                share_low=low,
                share_high=high,
                mean_velocity=length * displacement * frequency + 0.0,
                regime=Regime(regime),
                period_cycles=int(period),
                displacement_per_cycle=length * displacement + 0.0,
                peak_velocity=speed * peak,
                pattern=_as_named(text, one_harmonic=one_harmonic),
                largest_multiplier=multiplier,
                from_rest=i == home,
                start_phase=phase,
                start_velocity=speed * velocity + 0.0,
                start_normal_velocity=speed * rate,
            )
        )
    motions.sort(key=lambda one: (not one.from_rest, -one.share))
    in_contact = not irregular and not any(one.regime is Regime.HOPPING for one in motions)
    complete = in_contact and size and one_harmonic and not scene.restitution and scene.kinetic_friction
    to_speed = length * frequency
    return Attractors(
        tuple(motions), number, height, irregular / number, to_speed * means[0], to_speed * means[1],
        to_speed * means[2] + 0.0, lost, bool(away), bool(complete),
    )  # fmt: skip


def _as_named(text: str, *, one_harmonic: bool) -> str:
    """Turn the legs of a cycle as ``SteadyCycle.pattern`` has them."""
    if len(text) > 1 and text[0] == text[-1] != "H":
        text = text[:-1]  # one leg, amid which the cycle begins
    turns = [text[i:] + text[:i] for i in range(len(text))]
    if "H" not in text and (named := next((turn for turn in turns if turn in PATTERNS), "")):
        return named
    return text if one_harmonic else min(turns, key=lambda turn: [*map(LETTERS.index, turn)])


def _spelt(grid: Grid, phase: float, velocity: float, period: float) -> str:
    """Follow a cycle for its legs, where they are more than a code has room for."""
    motion = follow_body(grid, Start(phase, velocity, 0.0, 0.0), 3.0 * period)
    legs = motion.legs.mode[motion.first :]
    if not len(legs):  # rounding grows in it: the next one does not repeat to the last bit
        legs = follow_body(grid, Start(phase, velocity, 0.0, 0.0), period - _ROUNDING).legs.mode
    return "".join(LETTERS[mode] for mode in legs)
