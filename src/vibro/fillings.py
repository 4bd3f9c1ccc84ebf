"""What a filling weighs: its force on the trough at the drive's frequency, and at twice it."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from vibro.core.compiled import doors
from vibro.drives import Ability, Ellipse, Line
from vibro.errors import Problem, SceneError
from vibro.reals import shielded
from vibro.results.filling import Filling
from vibro.solver import Grid, Scratch, over_cells
from vibro.steady import solve

if TYPE_CHECKING:
    from vibro.results.steady import SteadyCycle
    from vibro.scene import Scene

__all__ = ["filling", "filling_of"]

_RANGE: Final = 1024  # [cells] of a range, so that an interrupt is noticed within a fraction of a second
_ROWS: Final = 5  # shares, both parts of the second harmonic, and the bound


@shielded
def filling(scene: Scene, *, threads: int | None = None) -> Filling:
    """Return the settled force of what lies in the trough on it, per kg, for every scene.

    The trough moves as the scene says, whatever the filling does to it. Valid for parts that move one by one,
    or a thin bed.

    Parameters
    ----------
    scene : Scene
        Operating points of any shape, with drives along lines or ellipses.
    threads : int, optional
        How many threads share the work, at least 1; without, one a core.

    Returns
    -------
    Filling
        Arrays of the scene's shape; NumPy scalars for a single scene.

    Raises
    ------
    SceneError
        If the drive is neither a line nor an ellipse.
    InputError
        If ``threads`` is no whole number of at least 1.

    Notes
    -----
    Eqs. (75)-(79) of docs/theory.md, summed over the slides and flights of the cycle. Within 1e-11 of an
    event walk in 34 digits (tests/test_fillings.py).

    Examples
    --------
    >>> import math, vibro
    >>> found = vibro.filling(vibro.Scene(amplitude=1e-3, frequency=15, drive_angle=math.radians(20),
    ...                                   static_friction=0.74, kinetic_friction=0.57))
    >>> print(f"{found.added_mass_share:.6f} {found.added_damping_share:.6f}")
    0.798523 0.179928
    """
    _check_drive(scene)
    return filling_of(scene, solve(scene, threads=threads), threads=threads)


def filling_of(scene: Scene, cycle: SteadyCycle, *, threads: int | None = None) -> Filling:
    """Return the same for scenes whose steady cycles ``solve`` has found."""
    _check_drive(scene)
    grid, solver, scratch = Grid(scene.arrays()), doors(), Scratch()
    pattern = np.ascontiguousarray(cycle.pattern_code, np.int64).reshape(-1)
    status = np.ascontiguousarray(cycle.status, np.int8).reshape(-1)
    values = np.empty((_ROWS, grid.size))
    given, out = (solver.row(pattern), solver.row(status)), solver.rows(values)
    grid.hold(pattern, status, values)

    def weigh(begin: int, end: int) -> None:
        solver.weigh(grid.scenes, grid.place(), *given, out, scratch.flights, scratch.hops, begin, end)

    over_cells(weigh, grid.size, _RANGE, threads)
    mass, damping, real, imaginary, bound = (row.reshape(grid.shape)[()] for row in values)
    error: Any = np.where(np.isnan(mass), np.nan, 0.0)[()]
    return Filling(
        added_mass_share=mass,
        added_damping_share=damping,
        added_mass_share_error=error,
        added_damping_share_error=error,
        energy_per_cycle=math.pi * _squared_speed(scene) * damping,
        second_harmonic=real + 1j * imaginary,
        bound=bound,
        status=cycle.status,
    )


def _check_drive(scene: Scene) -> None:
    drive = scene.arrays()
    if not drive.can(Ability.ONE_HARMONIC):
        allowed = "along a line or an ellipse: the force of a filling is found for these alone"
        raise SceneError((Problem("drive", drive.kind, allowed),))


def _squared_speed(scene: Scene) -> Any:
    """Sum of the squared amplitudes of the trough's velocity in both directions [m^2/s^2]."""
    drive = scene.arrays()
    w = 2.0 * math.pi * drive.frequency
    if isinstance(drive, Ellipse):
        return (drive.along_amplitude * w) ** 2 + (drive.normal_amplitude * w) ** 2
    return (drive.amplitude * w) ** 2 if isinstance(drive, Line) else np.nan
