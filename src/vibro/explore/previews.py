"""A map over a machine with a filling, before its cells are solved: the filling's weight is interpolated.

What a filling weighs changes slowly from cell to cell, while the amplitude has a peak at resonance. So shares
of added mass and damping are taken between the cells of a lattice, and the amplitude of every cell follows.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from vibro.plots.neighbours import fill_unknown
from vibro.results.operating import OPERATING
from vibro.sweeps.machines import operated

if TYPE_CHECKING:
    from collections.abc import Mapping

    from numpy.typing import NDArray

    from vibro.reals import Floats
    from vibro.results.steady import SteadyCycle
    from vibro.sweeps.grid import Grid


__all__ = ["foreseen"]


def foreseen(
    grid: Grid, given: Mapping[str, Floats], found: Mapping[str, NDArray[Any]], spacing: int
) -> tuple[dict[str, NDArray[Any]], SteadyCycle]:
    """Foresee the cells of a grid from those of a lattice.

    Parameters
    ----------
    grid : Grid
        With a machine, of two axes.
    given : mapping of str to array
        Quantities of its cells, without what the machine adds.
    found : mapping of str to array
        What the machine adds, of the grid's shape; known where both indices are multiples of ``spacing``.
    spacing : int
        Of the lattice [cells].

    Returns
    -------
    dict of str to array
        What the machine adds, of the grid's shape.
    SteadyCycle
        Results without flights.
    """
    assert grid.machine is not None
    every = slice(None, None, spacing)
    shares = []
    for name in ("added_mass_share", "added_damping_share"):
        known = found[OPERATING][name][every, every]
        shares.append(_between(fill_unknown(known, ~np.isnan(known)), grid.shape, spacing))
    added = operated(grid.machine, given, share=(shares[0], shares[1]))
    cycle = replace(grid, flight=False).solve({**given, **added})
    return {name: np.broadcast_to(values, grid.shape).copy() for name, values in added.items()}, cycle


def _between(values: Floats, shape: tuple[int, ...], spacing: int) -> Floats:
    """Interpolate linearly between the points of a lattice; beyond the last they are as there."""
    for place, count in enumerate(shape):
        at = np.arange(count) / spacing
        low = np.minimum(at.astype(np.intp), values.shape[place] - 1)
        high = np.minimum(low + 1, values.shape[place] - 1)
        weight = (at - low).reshape([-1 if i == place else 1 for i in range(len(shape))])
        values = values.take(low, place) * (1.0 - weight) + values.take(high, place) * weight
    return values
