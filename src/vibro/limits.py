"""Critical loads, at which a scene changes its regime, and the transitions next to one operating point."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Final, NamedTuple

import numpy as np

from vibro.core.codes import Regime
from vibro.core.compiled import doors
from vibro.drives import Line
from vibro.errors import Problem, SceneError
from vibro.reals import NotRealError, real_array
from vibro.solver import Grid, over_cells
from vibro.steady import solve

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray

    from vibro.scene import Fields, Scene

    Floats = NDArray[np.float64]

__all__ = [
    "CriticalLoads", "Transition", "back_slip_of", "critical_loads", "critical_loads_of_lines",
    "stays_upright", "tipping_load", "tipping_load_of_lines", "transitions",
]  # fmt: skip

_BEGINNINGS: Final = {
    "forward_onset": "forward slip",
    "back_onset": "load for back slip",
    "back_slip": "back slip",
    "rest_vanishes": "never at rest",
    "hop": "hopping",
}
_LATE: Final = "load for forward slip"

# [1] Relative distance within which a closed form and a root count as the same load.
_SAME: Final = 1e-13

_RANGE: Final = 8_192  # [cells] per call, so that an interrupt is noticed within a fraction of a second


class CriticalLoads(NamedTuple):
    """Critical loads G = A w^2 / g; inf if a transition never happens, 0 if it has happened at any load.

    Attributes
    ----------
    hop : array
        Above it the throw number exceeds 1 and the body leaves the trough.
    forward_onset, back_onset : array
        Above it the tangential force on a body at rest exceeds static friction forward, or back.
    back_slip : array
        Above it the steady cycle from rest has a back slide. It exceeds ``back_onset`` where the forward
        slide outlasts the back window. Elliptical drives on troughs steeper than the angle of kinetic
        friction may lose the back slide again at higher loads.
    rest_vanishes : array
        Above it the body slides continuously.

    Notes
    -----
    A body starts from rest at the phase where static friction is first exceeded. On inclines phase 0 may lie
    later, and a start there may lead to another cycle where several coexist.
    """

    hop: Floats
    forward_onset: Floats
    back_onset: Floats
    back_slip: Floats
    rest_vanishes: Floats


class Transition(NamedTuple):
    """Amplitude and frequency at which a kind of motion begins, starting from one operating point.

    Attributes
    ----------
    name : str
        The motion that begins.
    ratio : float
        The scene's load over the load at which it begins: above 1 it has begun [1].
    amplitude : float
        Amplitude at which it begins at the scene's frequency; of an ellipse half of its larger axis, where
        both amplitudes are the scene's over ``ratio`` [m].
    frequency : float
        Frequency at which it begins at the scene's amplitude [Hz].
    """

    name: str
    ratio: float
    amplitude: float
    frequency: float


def critical_loads(scene: Scene) -> CriticalLoads:
    """Critical loads G = A w^2 / g, at which the steady cycle from rest changes its regime.

    For an ellipse A is its larger semi-axis, as in ``Scene.load``: both amplitudes change in proportion.

    Parameters
    ----------
    scene : Scene
        Operating points of any shape; amplitude, frequency, gravity and restitution have no effect.

    Returns
    -------
    CriticalLoads
        ``hop``, ``forward_onset``, ``back_onset``, ``back_slip`` and ``rest_vanishes``: arrays of the common
        shape of angles and frictions, which broadcasts against the scene's [1]. inf where a transition never
        happens, 0 where it always has; NaN where mu_d > mu_s or mu_s = 0.

    Raises
    ------
    InputError
        If the drive lacks ``Ability.LIMITS``.

    Notes
    -----
    Closed forms, Eqs. (4), (5) and (21), and one root in a bracket, Eq. (22). They agree with ``solve`` on
    both sides of each load (tests/core/test_limits.py).

    Examples
    --------
    >>> import math, vibro
    >>> scene = vibro.Scene(amplitude=1e-3, frequency=15, drive_angle=math.radians(20),
    ...                     static_friction=0.74, kinetic_friction=0.57)
    >>> print(f"{vibro.critical_loads(scene).forward_onset:.6f}")
    0.620395
    """
    return _critical_loads(Grid(scene.arrays().at_any_load()))


def critical_loads_of_lines(
    drive_angle: ArrayLike,
    static_friction: ArrayLike,
    kinetic_friction: ArrayLike,
    trough_angle: ArrayLike = 0.0,
) -> CriticalLoads:
    """Return critical loads of drives along a line from the angles and frictions that decide them.

    Parameters
    ----------
    drive_angle, trough_angle : array_like
        Drive and trough angle [rad].
    static_friction, kinetic_friction : array_like
        mu_s and mu_d [1].

    Returns
    -------
    CriticalLoads
        As from ``critical_loads``; arrays of the broadcast shape.
    """
    return _critical_loads(_lines(drive_angle, static_friction, kinetic_friction, trough_angle))


def _lines(*fields: ArrayLike) -> Grid:
    """Make a grid of drives along lines from their angles and frictions alone."""
    alpha, mu_s, mu_d, beta = (np.asarray(x, np.float64) for x in fields)
    one = np.ones(())
    return Grid(Line(one, one, alpha, mu_s, mu_d, beta, one, one - one))


def _critical_loads(grid: Grid) -> CriticalLoads:
    found = np.empty((len(CriticalLoads._fields), grid.size))
    rows = doors().rows(found)
    grid.hold(found)

    def find(begin: int, end: int) -> None:
        doors().transition_loads(grid.scenes, grid.place(), rows, begin, end)

    over_cells(find, grid.size, _RANGE, None)
    return CriticalLoads(*(row.reshape(grid.shape)[()] for row in found))


def transitions(scene: Scene) -> tuple[Transition, ...]:
    """Return where each kind of motion begins, starting from one operating point.

    Parameters
    ----------
    scene : Scene
        One operating point, of shape ().

    Returns
    -------
    tuple of Transition
        By rising amplitude; without transitions that hopping forestalls, that no load causes, or that lie
        beyond the range of doubles.

    Raises
    ------
    SceneError
        If the scene is more than one operating point.
    InputError
        If its drive lacks ``Ability.LIMITS``.

    Examples
    --------
    >>> import math, vibro
    >>> scene = vibro.Scene(amplitude=1e-3, frequency=15, drive_angle=math.radians(20),
    ...                     static_friction=0.74, kinetic_friction=0.57)
    >>> for t in vibro.transitions(scene):
    ...     print(f"{t.name} at {1e3 * t.amplitude:.4f} mm or {t.frequency:.4f} Hz")
    forward slip at 0.6852 mm or 12.4162 Hz
    back slip at 1.1903 mm or 16.3651 Hz
    never at rest at 1.5623 mm or 18.7486 Hz
    hopping at 3.2291 mm or 26.9543 Hz
    """
    if scene.shape:
        raise SceneError((Problem("scene", f"shape {scene.shape}", "one operating point, of shape ()"),))
    loads = {name: float(value) for name, value in critical_loads(scene)._asdict().items()}
    found = []
    for name, load in loads.items():
        merely_load = name == "back_onset" and math.isclose(load, loads["back_slip"], rel_tol=_SAME)
        if merely_load or not 0.0 < load < math.inf or (name != "hop" and load >= loads["hop"]):
            continue
        ratio = float(scene.load) / load
        if not 0.0 < ratio < math.inf:  # beyond the range of doubles
            continue
        amplitude, frequency = float(scene.reach) / ratio, float(scene.frequency) / math.sqrt(ratio)
        # where back slip comes first its slides may outlast the forward window
        late = name == "forward_onset" and loads["back_onset"] < load
        found.append(Transition(_LATE if late else _BEGINNINGS[name], ratio, amplitude, frequency))
    return tuple(sorted(found, key=lambda transition: transition.amplitude))


def back_slip_of(fields: Line) -> NDArray[np.bool_]:
    """Return whether bodies slip back by Eqs. (5) and (17) alone, also where mu_d > mu_s.

    Parameters
    ----------
    fields : Line
        Drives along a line in contact; the fields broadcast against each other.

    Returns
    -------
    bool array
        Of the common shape.
    """
    grid = Grid(fields)
    found = np.empty(grid.size, np.int8)
    doors().slips_back(grid.scenes, grid.place(), doors().row(found), 0, grid.size)
    return np.asarray(found.reshape(grid.shape) > 0)


def tipping_load(scene: Scene, stand_ratio: ArrayLike) -> Floats:
    """Return the load G = A w^2 / g up to which no edge of a part that starts from rest lifts.

    Parameters
    ----------
    scene : Scene
        Operating points of any shape; amplitude, frequency, gravity, kinetic friction and restitution have no
        effect.
    stand_ratio : array_like
        Half base over height of the centre of mass, > 0; broadcasts against the scene [1]. The half base is
        the distance along the trough from the centre of mass to the nearer edge.

    Returns
    -------
    array
        Common shape of angles, static friction and stand ratio [1]. inf if static friction is at most the
        stand ratio, 0 if the trough is so steep that the part tips at rest.

    Raises
    ------
    SceneError
        If a stand ratio is no number, or not > 0.
    InputError
        If the drive lacks ``Ability.LIMITS``.

    Notes
    -----
    Closed form, Eq. (43). Above it an edge lifts before the part first slips: theory.md, section 12, has the
    proof, and tests/test_limits.py integrates Newton's law on both sides of it.
    """
    fields = scene.arrays().at_any_load()
    return _tipping_load(fields._replace(kinetic_friction=np.zeros(())), _stand_ratios(stand_ratio))


def tipping_load_of_lines(
    drive_angle: ArrayLike, static_friction: ArrayLike, trough_angle: ArrayLike, stand_ratio: ArrayLike
) -> Floats:
    """Return ``tipping_load`` of drives along a line from angles and frictions, of the broadcast shape."""
    alpha, mu_s, beta = (np.asarray(x, np.float64) for x in (drive_angle, static_friction, trough_angle))
    one = np.ones(())
    fields = Line(one, one, alpha, mu_s, one - one, beta, one, one - one)
    return _tipping_load(fields, np.asarray(stand_ratio, np.float64))


def _tipping_load(fields: Fields, ratio: Floats) -> Floats:
    # restitution has no effect, so it carries the shape of the ratio
    grid = Grid(fields._replace(restitution=np.zeros(ratio.shape)))
    ratios = np.ascontiguousarray(np.broadcast_to(ratio, grid.shape))
    found = np.empty(grid.size)
    doors().tipping_loads(grid.scenes, grid.place(), doors().row(ratios), doors().row(found), 0, grid.size)
    return np.asarray(found.reshape(grid.shape)[()])


def stays_upright(scene: Scene, stand_ratio: ArrayLike) -> NDArray[np.int8]:
    """Return whether a part that starts from rest keeps its whole base on the trough.

    Parameters
    ----------
    scene : Scene
        Operating points of any shape.
    stand_ratio : array_like
        As for ``tipping_load``.

    Returns
    -------
    int8 array
        Common shape: 1 where no edge ever lifts, 0 where one does, -1 where that is unknown because the part
        hops and may land on an edge, or the trough is too steep for it to rest.

    Raises
    ------
    SceneError
        If a stand ratio is no number, or not > 0.
    InputError
        If the drive lacks ``Ability.LIMITS``.
    """
    load = tipping_load(scene, stand_ratio)
    hops = solve(scene, accuracy="regimes").regime == int(Regime.HOPPING)
    unheld = np.abs(np.tan(scene.trough_angle)) >= scene.static_friction
    tips = scene.load > load
    unknown = np.where(np.isinf(load), hops, unheld)
    return np.where(unknown, -1, ~tips).astype(np.int8)[()]


def _stand_ratios(value: ArrayLike) -> Floats:
    """Convert stand ratios to doubles; raise SceneError unless they are positive numbers."""
    try:
        ratios = real_array(value)
    except NotRealError as exc:
        raise SceneError((Problem("stand_ratio", exc.value, exc.allowed),)) from None
    bad = ~(ratios > 0.0)
    if bad.any():
        raise SceneError((Problem("stand_ratio", f"{ratios[bad].flat[0]:.15g}", "> 0"),))
    return ratios
