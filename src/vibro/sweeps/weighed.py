"""Columns and lines about a filling of known mass, whose trough moves as the scene says."""

from __future__ import annotations

import math
from functools import lru_cache, partial
from typing import TYPE_CHECKING, Final

import numpy as np

from vibro.fillings import TYPICAL_MACHINES, filling_of, most_mass_ratio, path_amplitude
from vibro.quantities import MASS, TROUGH_MASS
from vibro.results.operating import WEIGHED
from vibro.results.sweep import Column
from vibro.sweeps.derived import column_of, constant
from vibro.sweeps.grid import scene_of
from vibro.units import PERCENT

if TYPE_CHECKING:
    from collections.abc import Mapping

    from vibro.reals import Floats
    from vibro.results.operating import Filling
    from vibro.results.sweep import Block


_FILLING: Final = "filling_kg"
#: Of ``TYPICAL_MACHINES``, in their order.
_LIMITS: Final = ("soft_mounts", "below_resonance", "above_resonance")


def weighed(part: Mapping[str, float]) -> tuple[Column, ...]:
    """Return the columns about a filling.

    Parameters
    ----------
    part : mapping of str to float
        ``filling_kg``, and ``trough_mass_kg`` if it is known; without a filling there are no columns.
    """
    if _FILLING not in part:
        return ()
    mass, trough = part[_FILLING], part.get(TROUGH_MASS.column)
    columns = [Column(_FILLING, MASS.unit, partial(constant, mass), meaning="mass of the filling")]
    if trough is not None:
        meaning = "mass of the empty trough and of what moves with it"
        columns.append(Column(TROUGH_MASS.column, MASS.unit, partial(constant, trough), meaning=meaning))
    columns += [column_of(result, partial(_weight, result.name, mass)) for result in WEIGHED]
    for name, (machine, compliance) in zip(_LIMITS, TYPICAL_MACHINES.items(), strict=True):
        columns.append(
            Column(
                f"given_motion_{name}_percent",
                PERCENT.unit,
                partial(_limit, compliance),
                meaning=f"filling over the trough's mass up to which its motion is as given: {machine}",
            )
        )
    return tuple(columns)


@lru_cache(maxsize=1)  # every column asks for the same block
def _filling(block: Block) -> Filling:
    return filling_of(scene_of(block.values), block.cycle, averages=True)


def _weight(name: str, mass: float, block: Block) -> Floats:
    """Evaluate a result of ``WEIGHED`` [SI]."""
    scene, found = scene_of(block.values), _filling(block)
    if name == "energy":
        return np.asarray(mass * found.energy_per_cycle)
    if name == "power":
        return np.asarray(mass * found.energy_per_cycle * scene.frequency)
    if name == "second_harmonic_force":
        acceleration = path_amplitude(scene) * (2.0 * math.pi * scene.frequency) ** 2
        return np.asarray(mass * np.abs(found.second_harmonic) * acceleration)
    return np.asarray(getattr(found, name))


def _limit(compliance: float, block: Block) -> Floats:
    return np.asarray(PERCENT.from_si(_at_unit_compliance(block) / compliance))


@lru_cache(maxsize=1)
def _at_unit_compliance(block: Block) -> Floats:
    """Return up to what mass ratio the motion is given at a compliance of 1; it is inverse to that."""
    return np.asarray(most_mass_ratio(scene_of(block.values), block.cycle, _filling(block), 1.0))
