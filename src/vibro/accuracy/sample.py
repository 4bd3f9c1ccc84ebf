"""Scenes drawn evenly from the cells of a grid."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from vibro.quantities import to_si
from vibro.scene import Scene

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from vibro.sweeps.run import Grid

__all__ = ["draw_scenes", "take_scenes"]


def draw_scenes(grid: Grid, start: int, count: int) -> Scene:
    """Draw scenes from a grid, evenly over all its axes at once.

    Parameters
    ----------
    grid : Grid
        What to draw from.
    start, count : int
        Which scenes of an endless sequence, whose every beginning covers the grid evenly: the additive
        recurrence i / phi^j mod 1 with phi^(d+1) = phi + 1, for d axes. A grid of at most ``count`` cells is
        returned whole, and has nothing beyond.

    Returns
    -------
    Scene
        Flat; infeasible combinations are left out.
    """
    if grid.size <= count:
        cells = np.unravel_index(np.arange(grid.size if start == 0 else 0), grid.shape)
    else:
        phi = 2.0
        for _ in range(60):  # converges by a factor of at least 2 a step
            phi = (1.0 + phi) ** (1.0 / (len(grid.shape) + 1))
        numbers = np.arange(start + 1, start + count + 1)
        cells = tuple(
            (n * ((0.5 + numbers * phi**-j) % 1.0)).astype(np.intp) for j, n in enumerate(grid.shape, 1)
        )
    values: dict[str, Any] = dict(grid.fixed)
    values |= {axis.name: axis.values[i] for axis, i in zip(grid.axes.values(), cells, strict=True)}
    if "friction_ratio" in values:
        values["kinetic_friction"] = values.pop("friction_ratio") * values["static_friction"]
    si = {name: np.broadcast_to(to_si(name, value), cells[0].shape) for name, value in values.items()}
    feasible = (si["kinetic_friction"] <= si["static_friction"]) & (
        si["drive_angle"] + si["trough_angle"] < 0.5 * np.pi
    )
    return Scene(**{name: value[feasible] for name, value in si.items()})


def take_scenes(scene: Scene, cells: NDArray[Any] | slice) -> Scene:
    """Select scenes of a flat collection."""
    names = Scene.__dataclass_fields__
    return Scene(**{name: np.broadcast_to(getattr(scene, name), scene.shape)[cells] for name in names})
