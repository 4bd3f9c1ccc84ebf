"""What a filling weighs: its force on the trough at the drive's frequency, and at twice it."""

from __future__ import annotations

import math
from dataclasses import fields
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from vibro.core.codes import Regime, Status
from vibro.drives import Ability, Ellipse, Line
from vibro.errors import SceneError
from vibro.reals import shielded
from vibro.results.operating import Filling
from vibro.scene import Scene
from vibro.steady import solve, speed_exponent
from vibro.threads import Grid, Scratch, doors, over_cells

if TYPE_CHECKING:
    from vibro.results.steady import SteadyCycle


_KINK: Final = 0.2  # [1] relative difference of both sides that shows a kink
_DAMPING_RATIO: Final = 0.015  # [1] of steel springs in feeders
# [cells] of a range, so that threads share the work evenly.
_RANGE: Final = 1024
_AVERAGED: Final = 16  # each of which takes several ms
_AMPLITUDE_STEP: Final = (
    0.01  # [1] relative change of the amplitude that speeds of hopping bodies are compared over
)
_ROWS: Final = 7  # shares, both parts of the second harmonic, errors of the shares, and the bound


def _compliance(frequency_ratio: float, trough_share: float) -> float:
    """Compliance of a free machine of two masses to more mass on the trough, times the trough's mass.

    Eq. (78); ``trough_share`` is that of the trough in both masses, 0 for one mass on springs.
    """
    damping, square = 2j * _DAMPING_RATIO * frequency_ratio, frequency_ratio * frequency_ratio
    return abs((square - trough_share * (1.0 + damping)) / (square - 1.0 - damping))


#: Compliance ``abs(m1 H)`` of typical machines, Eq. (78), by their kind [1].
TYPICAL_MACHINES: Final = {
    "unbalance motors, soft mounts (f/f0 = 4)": _compliance(4.0, 0.0),
    "two masses, m2 = 2 m1, below resonance (f/f0 = 0.90)": _compliance(0.90, 1.0 / 3.0),
    "two masses, m2 = 2 m1, above resonance (f/f0 = 1.05)": _compliance(1.05, 1.0 / 3.0),
}


@shielded
def filling(scene: Scene, *, threads: int | None = None) -> Filling:
    """Return the steady force of the filling on its trough, per kg of filling.

    The trough moves as the scene prescribes; the filling does not change its motion (``vibro.operate``
    computes that change). Valid for single parts or a thin bed.

    Parameters
    ----------
    scene : Scene
        Operating points of any shape, with drives along lines or ellipses.
    threads : int, optional
        Number of threads, at least 1; by default one per core.

    Returns
    -------
    Filling
        Arrays of the scene's shape; NumPy scalars for a single scene.

    Raises
    ------
    SceneError
        If the drive is neither a line nor an ellipse.
    InputError
        If ``threads`` is not a whole number of at least 1.

    Notes
    -----
    Eqs. (73)-(77) of docs/theory, summed over the slides and flights of the cycle; within 1e-11 of an
    event-driven simulation in 34 digits (tests/test_fillings.py). For irregular motion they are means over
    the same flights as the mean speed of ``solve``, which takes several ms per cell.

    Examples
    --------
    >>> import math, vibro
    >>> found = vibro.filling(vibro.Scene(amplitude=1e-3, frequency=15, drive_angle=math.radians(20),
    ...                                   static_friction=0.74, kinetic_friction=0.57))
    >>> print(f"{found.added_mass_share:.6f} {found.added_damping_share:.6f}")
    0.798523 0.179928
    """
    _check_drive(scene)
    return filling_of(scene, solve(scene, threads=threads), averages=True, threads=threads)


def filling_of(
    scene: Scene, cycle: SteadyCycle, *, averages: bool = False, threads: int | None = None
) -> Filling:
    """Return the same for scenes whose steady cycles ``solve`` has found.

    Without ``averages``, which take several ms a cell, cells of irregular motion have NaN for shares.
    """
    _check_drive(scene)
    grid, solver, scratch = Grid(scene.arrays()), doors(), Scratch()
    pattern = np.ascontiguousarray(cycle.pattern_code, np.int64).reshape(-1)
    status = np.ascontiguousarray(cycle.status, np.int8).reshape(-1)
    values = np.empty((_ROWS, grid.size))
    given, out = (solver.row(pattern), solver.row(status)), solver.rows(values)
    grid.hold(pattern, status, values)

    def weigh(begin: int, end: int) -> None:
        solver.weigh(
            grid.scenes, grid.place(), *given, out, scratch.flights, scratch.hops, begin, end, averages
        )

    step = _AVERAGED if averages and (status == Status.AVERAGED).any() else _RANGE
    over_cells(weigh, grid.size, step, threads, cost=grid.cost)
    mass, damping, real, imaginary, mass_error, damping_error, bound = (
        row.reshape(grid.shape)[()] for row in values
    )
    return Filling(
        added_mass_share=mass,
        added_damping_share=damping,
        added_mass_share_error=mass_error,
        added_damping_share_error=damping_error,
        energy_per_cycle=_energy(scene, damping),
        second_harmonic=real + 1j * imaginary,
        bound=bound,
        status=cycle.status,
    )


def _check_drive(scene: Scene) -> None:
    drive = scene.arrays()
    if not drive.can(Ability.ONE_HARMONIC):
        allowed = "along a line or an ellipse: the force of a filling is found for these alone"
        raise SceneError.of("drive", drive.kind, allowed)


def _energy(scene: Scene, damping: Any) -> Any:
    """Energy that is lost in a cycle, pi abs(X)^2 w^2 delta; inf beyond the range of doubles [J/kg]."""
    with np.errstate(over="ignore", invalid="ignore"):
        speed = path_amplitude(scene) * (2.0 * math.pi * scene.frequency)
        return np.where(damping == 0.0, 0.0, math.pi * speed**2 * damping)[()]


def path_amplitude(scene: Scene) -> Any:
    """Return abs(X), of lines the amplitude and of ellipses the root of the sum of both squares [m]."""
    drive = scene.arrays()
    if isinstance(drive, Ellipse):
        return np.hypot(drive.along_amplitude, drive.normal_amplitude)
    assert isinstance(drive, Line)
    return drive.amplitude


def amplitude_exponent(scene: Scene, cycle: SteadyCycle) -> Any:
    """Return by how many percent the speed changes with one percent of amplitude.

    In contact the exponent of Eq. (51). Of bodies that hop, and at thresholds, a difference of the speeds at
    1 % less and 1 % more amplitude, which is no derivative; where both sides differ by more than a fifth,
    that of the steeper side.

    Parameters
    ----------
    scene : Scene
        Operating points of any shape, with drives along lines or ellipses.
    cycle : SteadyCycle
        Their solution.

    Returns
    -------
    array
        NaN at rest, of means over irregular motion, and where the regime changes within 1 % [1].
    """
    _check_drive(scene)
    exponent = np.asarray(speed_exponent(scene, cycle))
    missing = np.isnan(exponent) & (cycle.status <= Status.BOUNDARY) & (cycle.regime != Regime.NO_SLIP)
    if not missing.any():
        return exponent[()]
    sizes = ("amplitude", "along_amplitude", "normal_amplitude")
    given = {f.name: getattr(scene, f.name) for f in fields(scene)}
    given = {name: value for name, value in given.items() if value is not None}
    found = []
    for factor in (1.0 - _AMPLITUDE_STEP, 1.0 + _AMPLITUDE_STEP):
        changed = {name: factor * value for name, value in given.items() if name in sizes}
        beside = solve(Scene.computed(**{**given, **changed}))
        known = (beside.status <= Status.BOUNDARY) & (beside.regime == cycle.regime)
        with np.errstate(divide="ignore", invalid="ignore"):
            change = np.log(beside.mean_velocity / cycle.mean_velocity) / math.log(factor)
        found.append(np.where(known, change, np.nan))
    less, more = found
    largest = np.where(np.isnan(less) | (np.abs(less) > np.abs(more)), less, more)
    smooth = np.abs(less - more) <= _KINK * np.abs(largest)
    return np.where(missing, np.where(smooth, 0.5 * (less + more), largest), exponent)[()]


def most_mass_ratio(
    scene: Scene, cycle: SteadyCycle, found: Filling, compliance: Any, *, change: float = 0.01
) -> Any:
    """Return up to what mass of the filling the motion may be taken as given.

    Parameters
    ----------
    scene, cycle, found : Scene, SteadyCycle, Filling
        Operating points, their solution, and what a filling weighs there.
    compliance : array_like
        Complex ``m1 H`` of the machine, or its size: how strongly its amplitude follows a mass on the trough
        [1].
    change : float, optional
        Change of the speed that is tolerated [1].

    Returns
    -------
    array
        Mass of the filling over that of the trough, to first order, Eq. (79); NaN where the speed's
        dependence on the amplitude, or the filling's share, is unknown [1].
    """
    exponent = np.abs(amplitude_exponent(scene, cycle))
    with np.errstate(divide="ignore"):
        return (change / (exponent * np.abs(found.share) * np.abs(compliance)))[()]
