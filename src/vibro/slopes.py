"""Steady contact cycles in detail: derivatives of the displacement, and the phases of the slides."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from vibro.core.compiled import doors
from vibro.solver import Grid

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray

    from vibro.scene import Scene

    Floats = NDArray[np.float64]

__all__ = ["Gradient", "Slides", "displacement_gradient", "load_slope", "slides_of"]


class Gradient(NamedTuple):
    """Derivatives of the displacement per drive cycle over A, with respect to one input each.

    Attributes
    ----------
    log_load : array
        ln G, G = A w^2 / g [1].
    drive_angle : array
        alpha [1/rad].
    static_friction, kinetic_friction : array
        mu_s and mu_d [1].
    trough_angle : array
        beta [1/rad].
    """

    log_load: Floats
    drive_angle: Floats
    static_friction: Floats
    kinetic_friction: Floats
    trough_angle: Floats


class Slides(NamedTuple):
    """Slides of steady contact cycles, of shape (2, *shape): in the order of the pattern.

    Attributes
    ----------
    way : array
        +1 forward, -1 back, 0 where there is no slide.
    zero : array
        Phase of the trough's motion along itself at which the load of the slide is zero and rises [rad].
    begin, end : array
        Phases of the trough's motion along itself; the first slide begins in [0, 2 pi) [rad].
    load, resistance : array
        C over m A w^2 and k of Eq. (3) [1].
    displacement : array
        Of the body during the slide, with its sign [A].
    """

    way: Floats
    zero: Floats
    begin: Floats
    end: Floats
    load: Floats
    resistance: Floats
    displacement: Floats


def load_slope(scene: Scene, pattern: ArrayLike) -> Floats:
    """Differentiate the displacement of steady contact cycles with respect to ln G.

    Parameters
    ----------
    scene : Scene
        Operating points of any shape; of an ellipse the amplitudes keep their ratio.
    pattern : int array_like
        ``SteadyCycle.pattern_code`` of each, of the scene's shape.

    Returns
    -------
    array
        Over A; 0 at rest, NaN where there is no steady contact cycle [1].

    Raises
    ------
    InputError
        If the drive has harmonics.

    Notes
    -----
    Eqs. (45)-(50). Just above an onset it grows without bound, like 1 over the root of the distance.
    """
    grid, patterns = Grid(scene.arrays()), np.ascontiguousarray(pattern, np.int64)
    found = np.empty(grid.size)
    row = doors().row
    doors().load_slopes(grid.scenes, grid.place(), row(patterns), row(found), 0, grid.size)
    return np.asarray(found.reshape(grid.shape))


def displacement_gradient(scene: Scene, pattern: ArrayLike) -> Gradient:
    """Differentiate the displacement of steady contact cycles of drives along lines.

    Parameters
    ----------
    scene : Scene
        Operating points of any shape.
    pattern : int array_like
        ``SteadyCycle.pattern_code`` of each, of the scene's shape; it is constant except at isolated values
        of the inputs.

    Returns
    -------
    Gradient
        0 at rest; NaN where there is no steady contact cycle.

    Raises
    ------
    InputError
        If the drive has harmonics.

    Notes
    -----
    Eqs. (45)-(50). Within 16 eps (1 + 1 / d) of its largest member of differences with 60 digits, where d is
    1 - s of the onsets in the cycle, and 1 - abs(t) / (mu_d n) in FB (tests/core/test_derivatives.py).
    """
    grid, patterns = Grid(scene.arrays()), np.ascontiguousarray(pattern, np.int64)
    found = np.empty((len(Gradient._fields), grid.size))
    buffers = doors().row(patterns), doors().rows(found)
    doors().displacement_gradients(grid.scenes, grid.place(), *buffers, 0, grid.size)
    return Gradient(*(row.reshape(grid.shape) for row in found))


def slides_of(scene: Scene, pattern: ArrayLike) -> Slides:
    """Solve the slides of steady contact cycles.

    Parameters
    ----------
    scene : Scene
        Operating points of any shape.
    pattern : int array_like
        ``SteadyCycle.pattern_code`` of each, of the scene's shape.

    Raises
    ------
    InputError
        If the drive has harmonics.
    """
    grid, patterns = Grid(scene.arrays()), np.ascontiguousarray(pattern, np.int64)
    found = np.empty((len(Slides._fields), 2 * grid.size))
    buffers = doors().row(patterns), doors().rows(found)
    doors().cycle_legs(grid.scenes, grid.place(), *buffers, 0, grid.size, grid.size)
    return Slides(*(row.reshape(2, *grid.shape) for row in found))
