"""Critical loads, at which a scene changes its regime, and the transitions next to one operating point."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Final, NamedTuple

import numpy as np

from vibro.core.codes import Regime
from vibro.core.numbers import CLASSES
from vibro.drives import Line, Moved, PiecewiseMotion
from vibro.errors import SceneError
from vibro.quantities import STAND_RATIO
from vibro.reals import NotRealError, real_array, shielded
from vibro.scene import check_single
from vibro.steady import solve
from vibro.threads import Grid, doors, over_cells

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import ArrayLike, NDArray

    from vibro.reals import Floats
    from vibro.scene import Fields, Scene


#: Names of transitions: motions that begin in contact, loads that exceed static friction, and the hop.
MOTIONS: Final = ("forward slip", "back slip", "continuous sliding")
LOADS: Final = ("load for forward slip", "load for back slip")
HOP: Final = "hopping"

# [1] Relative distance within which a closed form and a root count as the same load.
_SAME: Final = 1e-12

# [cells] per call, so that threads share the work evenly
_RANGE: Final = 8_192
_RANGE_OF_MOTIONS: Final = 64  # of 2 ms each per harmonic
_ROOM: Final = 64  # [intervals] of one class, to begin with; the most that were met are 6


class CriticalLoads(NamedTuple):
    """Critical loads G = A w^2 / g [1]; inf if a transition never happens, 0 if no load is too small for it.

    Attributes
    ----------
    hop : array
        Load above which the throw number exceeds 1 and the body leaves the trough.
    forward_onset, back_onset : array
        Load above which the tangential force on a body at rest exceeds static friction, forward or back.
    back_slip : array
        Load above which the steady cycle from rest has a back slide. It is larger than ``back_onset`` if the
        forward slide lasts until the force back has fallen again. Elliptical drives on troughs steeper than
        the angle of kinetic friction may lose the back slide again at higher loads.
    continuous_sliding : array
        Load above which the body slides continuously, without a rest.

    Notes
    -----
    The body starts from rest at the phase where static friction is first exceeded. On inclines a start at
    phase 0 may come after that phase and, where several cycles coexist, lead to another one.
    """

    hop: Floats
    forward_onset: Floats
    back_onset: Floats
    back_slip: Floats
    continuous_sliding: Floats


class Transition(NamedTuple):
    """Amplitude, frequency and load at which a kind of motion begins, relative to one operating point.

    Attributes
    ----------
    name : str
        The motion that begins.
    ratio : float
        The scene's load over the load at which the motion begins; the motion has begun if it is above 1 [1].
    amplitude : float
        Amplitude at which the motion begins at the scene's frequency: of a line its amplitude, of an ellipse
        its larger semi-axis, of other motions the largest distance from the middle. Every amplitude of the
        scene is divided by ``ratio`` there [m].
    frequency : float
        Frequency at which the motion begins at the scene's amplitude; NaN for steps and samples, whose
        accelerations do not depend on the frequency [Hz].
    load : float
        Load G at which the motion begins [1].
    end_ratio : float
        The scene's load over the load at which the motion ends, which is that of hopping at the latest; 0 if
        no load ends it [1].
    """

    name: str
    ratio: float
    amplitude: float
    frequency: float
    load: float
    end_ratio: float

    @property
    def scales(self) -> tuple[float, float]:
        """Factors of the scene's amplitudes at which the motion begins and ends; inf if it never ends [1]."""
        return 1.0 / self.ratio, 1.0 / self.end_ratio if self.end_ratio > 0.0 else math.inf

    @property
    def loads(self) -> tuple[float, float]:
        """Loads G at which the motion begins and ends; inf if it never ends [1]."""
        end = self.load * (self.ratio / self.end_ratio) if self.end_ratio > 0.0 else math.inf
        return self.load, end


@shielded
def critical_loads(scene: Scene) -> CriticalLoads:
    """Return the critical loads G = A w^2 / g at which the steady cycle from rest changes its regime.

    For an ellipse A is the larger semi-axis, as in ``Scene.load``, and both amplitudes keep their proportion.
    For any other motion G is the largest acceleration over gravity; the motion is scaled as a whole.

    Parameters
    ----------
    scene : Scene
        Operating points of any shape. Amplitude, scale of a motion, frequency, gravity (unless the body is
        clamped) and restitution have no effect.

    Returns
    -------
    CriticalLoads
        ``hop``, ``forward_onset``, ``back_onset``, ``back_slip`` and ``continuous_sliding``: arrays of the
        common shape of angles and frictions, which broadcasts against the scene's [1]. inf if a transition
        never happens, 0 if no load is too small for it; NaN if mu_d > mu_s or mu_s = 0.

    Notes
    -----
    Closed forms, Eqs. (4), (5) and (21), and one root in a bracket, Eq. (22). They agree with ``solve`` on
    both sides of each load (tests/core/test_limits.py).

    With more than one harmonic, back slip and continuous sliding may end and begin again as the load rises.
    ``back_slip`` and ``continuous_sliding`` are then the lowest loads at which they begin; ``transitions``
    lists all. These loads are searched, not proved: the steady cycle is solved at 256 loads between the first
    onset and the hop (or a million times the onset if there is no hop), and each change of its pattern is
    located by bisection. In 4 000 random scenes with 2 to 5 harmonics a scan of 1 500 loads found one more
    interval. A scene takes 5 to 10 ms.

    Examples
    --------
    >>> import math, vibro
    >>> scene = vibro.Scene(amplitude=1e-3, frequency=15, drive_angle=math.radians(20),
    ...                     static_friction=0.74, kinetic_friction=0.57)
    >>> print(f"{vibro.critical_loads(scene).forward_onset:.6f}")
    0.620395
    """
    fields = scene.arrays().at_any_load()
    found = _critical_loads(Grid(fields), _RANGE if scene.motion is None else _RANGE_OF_MOTIONS)
    return CriticalLoads(*_as_loads(found, fields))


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
    return _critical_loads(_lines(drive_angle, static_friction, kinetic_friction, trough_angle), _RANGE)


def _lines(*fields: ArrayLike) -> Grid:
    """Make a grid of drives along lines from their angles and frictions alone."""
    alpha, mu_s, mu_d, beta = (np.asarray(x, np.float64) for x in fields)
    one = np.ones(())
    return Grid(Line(one, one, alpha, mu_s, mu_d, beta, one, one - one))


def _critical_loads(grid: Grid, step: int) -> CriticalLoads:
    found = np.empty((len(CriticalLoads._fields), grid.size))
    rows = doors().rows(found)
    grid.hold(found)

    def find(begin: int, end: int) -> None:
        doors().transition_loads(grid.scenes, grid.place(), rows, begin, end)

    over_cells(find, grid.size, step, None, cost=grid.cost)
    return CriticalLoads(*(row.reshape(grid.shape)[()] for row in found))


def _as_loads(found: Sequence[Floats], fields: Fields) -> Sequence[Floats]:
    """Turn scales of motions, with which the solver counts beyond one harmonic, into loads G."""
    if not isinstance(fields, Moved):
        return found
    load = fields.acceleration_reach * (2.0 * np.pi * fields.frequency) ** 2 / fields.gravity
    with np.errstate(invalid="ignore", over="ignore"):
        return [np.where(np.isinf(x), x, x * load)[()] for x in found]


@shielded
def transitions(scene: Scene) -> tuple[Transition, ...]:
    """Return the amplitudes, frequencies and loads at which each kind of motion begins and ends.

    Parameters
    ----------
    scene : Scene
        One operating point, of shape ().

    Returns
    -------
    tuple of Transition
        Transitions by rising amplitude: "forward slip", "back slip", "continuous sliding" (the body slides
        continuously, or runs away) and "hopping". "load for forward slip" and "load for back slip" are loads
        at which static friction is exceeded but the body does not slide yet. Transitions that no load causes,
        or that lie above the load of hopping or beyond the range of doubles, are left out.

        With one harmonic each motion lasts until the body hops. With others a motion may end and begin again:
        there is one entry for each interval.

    Raises
    ------
    SceneError
        If the scene is more than one operating point.

    Notes
    -----
    Closed forms for one harmonic, as in ``critical_loads``. For other motions the intervals are searched at
    256 loads, as ``critical_loads`` explains. On 60 reference scenes all intervals are found, with a relative
    error of their ends below 3e-12 (tests/test_critical_scales.py). An interval does not end at a load whose
    cycle is unresolved.

    Examples
    --------
    >>> import math, vibro
    >>> scene = vibro.Scene(amplitude=1e-3, frequency=15, drive_angle=math.radians(20),
    ...                     static_friction=0.74, kinetic_friction=0.57)
    >>> for t in vibro.transitions(scene):
    ...     print(f"{t.name} at {1e3 * t.amplitude:.4f} mm or {t.frequency:.4f} Hz")
    forward slip at 0.6852 mm or 12.4162 Hz
    back slip at 1.1903 mm or 16.3651 Hz
    continuous sliding at 1.5623 mm or 18.7486 Hz
    hopping at 3.2291 mm or 26.9543 Hz
    """
    check_single(scene)
    now, reach = float(scene.load), float(scene.reach)
    hop, intervals = _of_one_harmonic(scene) if scene.motion is None else _of_any_motion(scene, now)
    found = []
    for name, load, end in [*intervals, (HOP, hop, math.inf)]:
        if not 0.0 < load < math.inf or (name != HOP and load >= hop):
            continue
        ratio = now / load
        if not 0.0 < ratio < math.inf:  # beyond the range of doubles
            continue
        amplitude, frequency = reach / ratio, float(scene.frequency) / math.sqrt(ratio)
        if isinstance(scene.motion, PiecewiseMotion):
            frequency = math.nan
        found.append(Transition(name, ratio, amplitude, frequency, load, now / end))
    return tuple(sorted(found, key=lambda transition: transition.amplitude))


def _of_one_harmonic(scene: Scene) -> tuple[float, list[tuple[str, float, float]]]:
    """Return the load of the hop, and those between which motions last, by their names: all end there."""
    loads, (forward, back, never) = critical_loads(scene), MOTIONS
    for_forward, for_back = LOADS
    # where back slip comes first its slides may outlast the forward window
    firsts = [
        (for_forward if loads.back_onset < loads.forward_onset else forward, loads.forward_onset),
        (back, loads.back_slip),
        (never, loads.continuous_sliding),
    ]
    if not math.isclose(loads.back_onset, loads.back_slip, rel_tol=_SAME):
        firsts.append((for_back, loads.back_onset))
    hop = float(loads.hop)
    return hop, [(name, float(first), hop) for name, first in firsts]


def _of_any_motion(scene: Scene, now: float) -> tuple[float, list[tuple[str, float, float]]]:
    """Return the same of a motion beyond one harmonic, at the load ``now``: its classes have intervals."""
    grid, room, counts = Grid(scene.arrays()), _ROOM, np.zeros(2 * CLASSES + 1, np.int64)
    while True:
        out = np.empty(2 * CLASSES * room + 3)
        doors().class_scales(grid.scenes, grid.place(), doors().row(out), doors().row(counts), room)
        most = int(counts[:CLASSES].max())
        if most <= room:
            break
        room = most
    hop, *onsets = (now * scale for scale in out[-3:].tolist())
    found = [
        (name, now * low, now * high)
        for name, spans, count in zip(MOTIONS, out[:-3].reshape(CLASSES, room, 2), counts, strict=False)
        for low, high in spans[:count].tolist()
    ]
    begun = {name: low for name, low, _ in reversed(found)}
    for name, load, onset in zip(MOTIONS[:2], LOADS, onsets, strict=True):
        if not math.isclose(begun.get(name, math.inf), onset, rel_tol=_SAME):
            found.append((load, onset, hop))
    return hop, found


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

    def find(begin: int, end: int) -> None:
        doors().slips_back(grid.scenes, grid.place(), doors().row(found), begin, end)

    over_cells(find, grid.size, _RANGE, None)
    return np.asarray(found.reshape(grid.shape) > 0)


@shielded
def tipping_load(scene: Scene, stand_ratio: ArrayLike) -> Floats:
    """Return the load G = A w^2 / g up to which no edge of a part that starts from rest lifts.

    Parameters
    ----------
    scene : Scene
        Operating points of any shape; amplitude, scale of a motion, frequency, gravity, kinetic friction and
        restitution have no effect.
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
        If a stand ratio is no number, or not > 0, or the body is clamped.

    Notes
    -----
    Closed form, Eq. (43). Above it an edge lifts before the part first slips: theory, section 12, has the
    proof, and tests/test_limits.py integrates Newton's law on both sides of it.
    """
    if scene.normal_acceleration is not None:
        shown, allowed = (
            f"{np.ravel(scene.normal_acceleration)[0]:.15g}",
            "left out: a clamped part cannot tip",
        )
        raise SceneError.of("normal_acceleration", shown, allowed)
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

    def find(begin: int, end: int) -> None:
        buffers = doors().row(ratios), doors().row(found)
        doors().tipping_loads(grid.scenes, grid.place(), *buffers, begin, end)

    over_cells(find, grid.size, _RANGE, None, cost=grid.cost)
    return np.asarray(_as_loads([found.reshape(grid.shape)[()]], fields)[0])


@shielded
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
        If a stand ratio is no number, or not > 0, or the body is clamped.
    """
    load = tipping_load(scene, stand_ratio)
    hops = solve(scene, output="regimes").regime == int(Regime.HOPPING)
    unheld = np.abs(np.tan(scene.trough_angle)) >= scene.static_friction
    tips = scene.load > load
    unknown = np.where(np.isinf(load), hops, unheld)
    return np.where(unknown, -1, ~tips).astype(np.int8)[()]


def _stand_ratios(value: ArrayLike) -> Floats:
    """Convert stand ratios to doubles; raise SceneError unless they are positive numbers."""
    try:
        ratios = real_array(value)
    except NotRealError as exc:
        raise SceneError.of("stand_ratio", exc.value, exc.allowed) from None
    bad = ~(STAND_RATIO.allows(ratios) | (ratios == np.inf))
    if bad.any():
        raise SceneError.of("stand_ratio", f"{ratios[bad].flat[0]:.15g}", STAND_RATIO.range_text)
    return ratios
