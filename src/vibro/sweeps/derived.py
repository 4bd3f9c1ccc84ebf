"""Columns beside the common ones: they follow from solved cells and from the parts' properties."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from vibro.limits import stays_upright, tipping_load
from vibro.quantities import MASS, PITCH, QUANTITIES
from vibro.results.operating import BENT_SPEED
from vibro.results.steady import (
    ACCELERATION,
    ARRIVAL_TIME,
    LARGEST_MULTIPLIER,
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
from vibro.steady import speed_exponent
from vibro.sweeps.grid import scene_of
from vibro.sweeps.machines import bent_speed
from vibro.units import LENGTH, SPEED

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from numpy.typing import NDArray

    from vibro.quantities import Quantity
    from vibro.reals import Floats


def column_of(result: Result, values: Callable[[Block], NDArray[Any]]) -> Column:
    """Return the column of a result; ``values`` must pickle, and returns numbers in the unit outside."""
    return Column(
        result.column,
        result.kind.unit,
        values,
        result.texts,
        result.is_flag,
        result.decode,
        meaning=result.meaning.replace("$", ""),
    )


def given_column(quantity: Quantity, values: Callable[[Block], NDArray[Any]]) -> Column:
    """Return the column of a quantity that is given; ``values`` must pickle."""
    return Column(quantity.column, quantity.unit, values, meaning=quantity.meaning)


def constant(value: float | None, block: Block) -> Floats:
    """Return a value of all cells; NaN if there is none."""
    return np.full((1,) * len(block.shape), np.nan if value is None else value)


def _length(block: Block) -> Floats:
    return constant(block.length, block)


def _traverse_time(block: Block) -> Floats:
    if block.length is None:
        return constant(None, block)
    return np.asarray(block.cycle.traverse_time(LENGTH.to_si(block.length)))


def _arrival(block: Block) -> Floats:
    return constant(None, block) if block.arrival is None else block.arrival


def _strokes(block: Block) -> Floats:
    return _traverse_time(block) * block.values["frequency"]


def _stroke(block: Block) -> Floats:
    """From one end of the trough's path to the other, the farther way."""
    if "amplitude" in block.values:
        return 2.0 * block.values["amplitude"]
    return np.asarray(LENGTH.from_si(scene_of(block.values).arrays().stroke))


def _speed_exponent(block: Block) -> Floats:
    return speed_exponent(scene_of(block.values), block.cycle)


def _known(block: Block) -> Any:
    """Whether cells have a drive: where a machine has no operating point, its amplitude is unknown."""
    return np.isfinite(block.values.get("amplitude", 0.0))


def _acceleration(block: Block) -> Floats:
    if "acceleration" in block.values:  # as it was given, in units of the standard gravity
        return block.values["acceleration"]
    return np.where(_known(block), scene_of(block.values).load, np.nan)


def _bent_speed(block: Block) -> Floats:
    return np.asarray(SPEED.from_si(bent_speed(block.values, scene_of(block.values))))


def _multiplier(block: Block) -> Floats:
    return np.asarray(block.cycle.largest_multiplier)


def _upright(ratio: float, block: Block) -> NDArray[np.int8]:
    return np.where(_known(block), stays_upright(scene_of(block.values), ratio), np.int8(-1))


def _tipping_load_ratio(ratio: float, block: Block) -> Floats:
    scene = scene_of(block.values)
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        return np.where(_known(block), scene.load / tipping_load(scene, ratio), np.nan)


def _rate(result: Result, pitch: float, of_one: float, block: Block) -> Floats:
    """Return the rate at which parts in a row pass: 0 where they are not conveyed forward."""
    with np.errstate(over="ignore"):  # inf beyond the range of doubles
        passing = np.maximum(block.cycle.mean_velocity, 0.0) / LENGTH.to_si(pitch) * of_one
    return np.asarray(result.kind.from_si(passing))


TRAVERSE: Final = column_of(TRAVERSE_TIME, _traverse_time)
WITH_ACCELERATION: Final = column_of(ACCELERATION, _acceleration)
WITH_ARRIVAL: Final = column_of(ARRIVAL_TIME, _arrival)
WITH_BENT_SPEED: Final = column_of(BENT_SPEED, _bent_speed)
WITH_EXPONENT: Final = column_of(SPEED_EXPONENT, _speed_exponent)
WITH_LENGTH: Final = given_column(QUANTITIES["trough_length"], _length)
WITH_MULTIPLIER: Final = column_of(LARGEST_MULTIPLIER, _multiplier)
WITH_STROKE: Final = given_column(QUANTITIES["stroke"], _stroke)
WITH_STROKES: Final = column_of(STROKES, _strokes)


def standing(ratio: float) -> tuple[Column, Column]:
    """Return the columns of a part with a stand ratio: whether it stays upright, and how near it is."""
    return (
        column_of(UPRIGHT, partial(_upright, ratio)),
        column_of(TIPPING_LOAD_RATIO, partial(_tipping_load_ratio, ratio)),
    )


def throughput(part: Mapping[str, float]) -> tuple[Column, ...]:
    """Return the columns of parts in a row, by their pitch and mass: how many pass, and how many kg."""
    if PITCH.column not in part:
        return ()
    rates = [(PARTS_RATE, 1.0)] + ([(MASS_RATE, part[MASS.column])] if MASS.column in part else [])
    return tuple(column_of(rate, partial(_rate, rate, part[PITCH.column], of_one)) for rate, of_one in rates)
