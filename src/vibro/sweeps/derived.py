"""Columns beside the common ones: what follows from solved cells, and from what is known of the parts."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Final

import numpy as np

from vibro.core.codes import SPELT_PATTERNS, Pattern, Status
from vibro.core.contact.load_slopes import load_slope
from vibro.core.groups import each, take
from vibro.limits import stays_upright, tipping_load
from vibro.quantities import LENGTH, QUANTITIES
from vibro.results.steady import (
    ACCELERATION,
    ARRIVAL_TIME,
    MASS_RATE,
    PARTS_RATE,
    SPEED_EXPONENT,
    STROKES,
    TIPPING_LOAD_RATIO,
    TRAVERSE_TIME,
    UPRIGHT,
    Result,
)
from vibro.results.sweep import Block, Column
from vibro.scene import HarmonicFields
from vibro.sweeps.grid import scene_of

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import NDArray

    Floats = NDArray[np.float64]

__all__ = [
    "LEAST_DIFFERENCE",
    "TRAVERSE",
    "WITH_ACCELERATION",
    "WITH_ARRIVAL",
    "WITH_EXPONENT",
    "WITH_STROKE",
    "WITH_STROKES",
    "standing",
    "throughput",
]

#: [A] Where slides to and fro nearly cancel, their difference has lost half of its digits, and more below.
LEAST_DIFFERENCE: Final = 2.0**-26


def _column(result: Result, values: Callable[[Block], NDArray[Any]]) -> Column:
    return Column(result.column, result.kind.unit, values, result.texts, result.is_flag)


def _unknown(block: Block) -> Floats:
    return np.full((1,) * len(block.shape), np.nan)


def _traverse_time(block: Block) -> Floats:
    if block.length is None:
        return _unknown(block)
    return np.asarray(block.cycle.traverse_time(LENGTH.to_si(block.length)))


def _arrival(block: Block) -> Floats:
    return _unknown(block) if block.arrival is None else block.arrival


def _strokes(block: Block) -> Floats:
    return _traverse_time(block) * block.values["frequency"]


def _stroke(block: Block) -> Floats:
    """From one end of the trough's path to the other, the farther way."""
    if "amplitude" in block.values:
        return 2.0 * block.values["amplitude"]
    scene = scene_of(block.values)
    if isinstance(scene.arrays(), HarmonicFields):  # whose path need not be symmetric
        return _unknown(block)
    return np.asarray(LENGTH.from_si(2.0 * scene.reach))


def _speed_exponent(block: Block) -> Floats:
    """Follow the speed as the amplitude changes, Eq. (51); NaN at thresholds, and where none is conveyed."""
    cycle, scene = block.cycle, scene_of(block.values)
    if isinstance(scene.arrays(), HarmonicFields):
        return _unknown(block)
    pattern = cycle.pattern_code.reshape(-1)
    displacement = (cycle.displacement_per_cycle / scene.scale).reshape(-1)
    one_way = (pattern == Pattern.F_) | (pattern == Pattern.B_)
    conveyed = np.abs(displacement) > np.where(one_way, 0.0, LEAST_DIFFERENCE)
    slides = (pattern > Pattern.R) & (pattern < SPELT_PATTERNS)
    cells = np.flatnonzero(slides & conveyed & (cycle.status.reshape(-1) == Status.OK))
    groups = each(scene.arrays().loads(), lambda x: np.broadcast_to(x, block.shape).reshape(-1))
    slope = load_slope(take(groups, cells), pattern[cells])
    exponent = np.full(pattern.size, np.nan)
    exponent[cells] = 1.0 + slope / displacement[cells]
    return exponent.reshape(block.shape)


TRAVERSE: Final = _column(TRAVERSE_TIME, _traverse_time)
WITH_ACCELERATION: Final = _column(ACCELERATION, lambda block: scene_of(block.values).load)
WITH_ARRIVAL: Final = _column(ARRIVAL_TIME, _arrival)
WITH_EXPONENT: Final = _column(SPEED_EXPONENT, _speed_exponent)
WITH_STROKE: Final = Column(QUANTITIES["stroke"].column, LENGTH.unit, _stroke)
WITH_STROKES: Final = _column(STROKES, _strokes)


def standing(ratio: float) -> tuple[Column, Column]:
    """Return the columns of a part with a stand ratio: whether it stays upright, and how near it is."""

    def load_ratio(block: Block) -> Floats:
        scene = scene_of(block.values)
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
            return scene.load / tipping_load(scene, ratio)

    return (
        _column(UPRIGHT, lambda block: stays_upright(scene_of(block.values), ratio)),
        _column(TIPPING_LOAD_RATIO, load_ratio),
    )


def throughput(pitch: float, mass: float | None = None) -> tuple[Column, ...]:
    """Return the columns of parts in a row: how many pass in a minute, and their mass.

    Parameters
    ----------
    pitch : float
        From each part to the next [mm].
    mass : float, optional
        Of one part [kg].
    """

    def rate(block: Block, of_one: float) -> Floats:
        """Return what passes in a second: nothing where it is not conveyed forward."""
        with np.errstate(over="ignore"):  # inf beyond the range of doubles
            passing: Floats = np.maximum(block.cycle.mean_velocity, 0.0) / LENGTH.to_si(pitch) * of_one
        return passing

    parts = _column(PARTS_RATE, lambda block: PARTS_RATE.kind.from_si(rate(block, 1.0)))
    if mass is None:
        return (parts,)
    return (parts, _column(MASS_RATE, lambda block: MASS_RATE.kind.from_si(rate(block, mass))))
