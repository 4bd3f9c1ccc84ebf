"""Scenes drawn evenly from the cells of a grid."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from vibro.scene import Scene
from vibro.sweeps.grid import scene_of

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from vibro.sweeps.grid import Grid


def draw_scenes(grid: Grid, start: int, count: int) -> Scene:
    """Draw scenes from a grid, evenly over all its axes at once.

    Parameters
    ----------
    grid : Grid
        What to draw from.
    start, count : int
        Which scenes of an endless sequence. Its first n scenes cover the grid evenly for any n: it is the
        additive recurrence i / phi^j mod 1 with phi^(d+1) = phi + 1, for d axes. A grid of at most ``count``
        cells is returned whole at ``start`` 0, and is empty afterwards.

    Returns
    -------
    Scene
        Of a 1-D shape; infeasible combinations are left out.
    """
    if grid.size <= count:
        cells = np.arange(grid.size if start == 0 else 0)
    else:
        phi = 2.0
        for _ in range(60):  # each step reduces the error by a factor of at least 2
            phi = (1.0 + phi) ** (1.0 / (len(grid.shape) + 1))
        numbers = np.arange(start + 1, start + count + 1)
        places = [(n * ((0.5 + numbers * phi**-j) % 1.0)).astype(int) for j, n in enumerate(grid.shape, 1)]
        cells = np.ravel_multi_index(places, grid.shape)
    drawn = scene_of(grid.picked(cells))
    return take_scenes(drawn, ~drawn.infeasible)


def take_scenes(scene: Scene, cells: NDArray[Any] | slice) -> Scene:
    """Select some of the scenes of a 1-D shape."""
    return Scene(**{name: field[cells] for name, field in scene.flat()._asdict().items()})
