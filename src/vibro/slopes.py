"""Steady contact cycles in detail: derivatives of the displacement, and the phases of the slides.

There are closed forms for drives of one harmonic; of others the displacement is differenced.
"""

from __future__ import annotations

from dataclasses import fields
from typing import TYPE_CHECKING, Final, NamedTuple

import numpy as np

from vibro.core.codes import SPELT_PATTERNS, Pattern, Regime, Status
from vibro.drives import Ability
from vibro.scene import Scene
from vibro.steady import solve
from vibro.threads import Grid, doors, over_cells

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from vibro.reals import Floats
    from vibro.results.steady import SteadyCycle


#: [A] Where slides to and fro nearly cancel, their difference has lost half of its digits, and more below.
LEAST_DIFFERENCE: Final = 2.0**-26

_RANGE: Final = 8_192  # [cells] per call, so that an interrupt is noticed within a fraction of a second
_STEP: Final = 1e-4  # [1] of the logarithm of the scale
_AGREES: Final = 1e-3  # [1] of both differences, relative: the better one is closer by the square of that


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


def _one_harmonic(scene: Scene) -> Grid:
    fields = scene.arrays()
    fields.require(Ability.ONE_HARMONIC, hint="vibro.simulate follows the slides of any drive")
    return Grid(fields)


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
        Slope over A; 0 at rest, NaN without a steady cycle in contact [1].

    Raises
    ------
    InputError
        If the drive is neither a line nor an ellipse: it lacks ``Ability.ONE_HARMONIC``.

    Notes
    -----
    Eqs. (45)-(50). Just above an onset it grows without bound, like 1 over the root of the distance.
    """
    grid, patterns = _one_harmonic(scene), np.ascontiguousarray(pattern, np.int64)
    found = np.empty(grid.size)

    def find(begin: int, end: int) -> None:
        row = doors().row
        doors().load_slopes(grid.scenes, grid.place(), row(patterns), row(found), begin, end)

    over_cells(find, grid.size, _RANGE, None)
    return np.asarray(found.reshape(grid.shape))


def scale_slope(scene: Scene, cycle: SteadyCycle) -> Floats:
    """Difference the displacement of steady contact cycles with respect to the logarithm of the motion.

    Parameters
    ----------
    scene : Scene
        Operating points of any shape, with a motion.
    cycle : SteadyCycle
        Their solution.

    Returns
    -------
    array
        d ln(displacement) / d ln(motion_scale); NaN at rest, for bodies that hop, and beside a change of
        the pattern or of the way [1].

    Notes
    -----
    A central difference of fourth order with steps of 1e-4. It is kept where the one of second order agrees
    within 1e-3, so that its own error is of the order of 1e-6 at most; rounding is 1e-11
    (tests/test_slopes_of_motions.py).
    """
    given = {f.name: getattr(scene, f.name) for f in fields(scene)}
    given = {name: value for name, value in given.items() if value is not None}
    logarithms = []
    known = (cycle.regime != Regime.HOPPING) & (cycle.status == Status.OK)
    for steps in (-2, -1, 1, 2):
        scale = scene.motion_scale * np.exp(steps * _STEP)
        beside = solve(Scene.computed(**{**given, "motion_scale": scale}), flight=False)
        known = known & (beside.pattern_code == cycle.pattern_code) & (beside.status == Status.OK)
        with np.errstate(divide="ignore", invalid="ignore"):
            ratio = beside.displacement_per_cycle / cycle.displacement_per_cycle
            logarithms.append(np.log(ratio))
    before, less, more, after = logarithms
    with np.errstate(invalid="ignore"):
        coarse = (after - before) / (4.0 * _STEP)
        fine = (4.0 * (more - less) / (2.0 * _STEP) - coarse) / 3.0
        known = known & (np.abs(fine - coarse) <= _AGREES * (1.0 + np.abs(fine)))
    return np.where(known, fine, np.nan)


def speed_exponent(scene: Scene, cycle: SteadyCycle) -> Floats:
    """Return the exponent of the speed over the amplitude, Eq. (51), of contact cycles.

    Beyond one harmonic it is a difference of speeds, ``scale_slope``.

    Parameters
    ----------
    scene : Scene
        Operating points of any shape.
    cycle : SteadyCycle
        Their solution.

    Returns
    -------
    array
        d ln(speed) / d ln(amplitude) within the pattern; NaN at thresholds, for bodies that hop, and where
        the speed is 0 [1].
    """
    pattern = cycle.pattern_code
    displacement = cycle.displacement_per_cycle / scene.scale
    one_way = (pattern == Pattern.F_) | (pattern == Pattern.B_)
    conveyed = np.abs(displacement) > np.where(one_way, 0.0, LEAST_DIFFERENCE)
    if not scene.arrays().can(Ability.ONE_HARMONIC):
        return np.where(conveyed, scale_slope(scene, cycle), np.nan)
    slides = (pattern > Pattern.R) & (pattern < SPELT_PATTERNS)
    known = slides & conveyed & (cycle.status == Status.OK)
    slope = load_slope(scene, np.where(known, pattern, Pattern.NONE))
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.where(known, 1.0 + slope / displacement, np.nan)


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
        If the drive is neither a line nor an ellipse: it lacks ``Ability.ONE_HARMONIC``.

    Notes
    -----
    Eqs. (45)-(50). Within 16 eps (1 + 1 / d) of its largest member of differences with 60 digits, where d is
    1 - s of the onsets in the cycle, and 1 - abs(t) / (mu_d n) in FB (tests/core/test_derivatives.py).
    """
    grid, patterns = _one_harmonic(scene), np.ascontiguousarray(pattern, np.int64)
    found = np.empty((len(Gradient._fields), grid.size))

    def find(begin: int, end: int) -> None:
        buffers = doors().row(patterns), doors().rows(found)
        doors().displacement_gradients(grid.scenes, grid.place(), *buffers, begin, end)

    over_cells(find, grid.size, _RANGE, None)
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
        If the drive is neither a line nor an ellipse: it lacks ``Ability.ONE_HARMONIC``.
    """
    grid, patterns = _one_harmonic(scene), np.ascontiguousarray(pattern, np.int64)
    found = np.empty((len(Slides._fields), 2 * grid.size))

    def find(begin: int, end: int) -> None:
        buffers = doors().row(patterns), doors().rows(found)
        doors().cycle_legs(grid.scenes, grid.place(), *buffers, begin, end, grid.size)

    over_cells(find, grid.size, _RANGE, None)
    return Slides(*(row.reshape(2, *grid.shape) for row in found))
