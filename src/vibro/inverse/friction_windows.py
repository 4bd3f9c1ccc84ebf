"""Find the frictions with which a body keeps its regime."""

from __future__ import annotations

import math
from dataclasses import fields
from functools import partial
from typing import TYPE_CHECKING, Final, NamedTuple

import numpy as np

from vibro.core.codes import Regime, Status
from vibro.drives import Ability
from vibro.errors import Problem, SceneError
from vibro.roots import close_in
from vibro.scene import Scene
from vibro.steady import solve

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import NDArray

    from vibro.results.steady import SteadyCycle

    Floats = NDArray[np.float64]
    # from the friction that is varied to static and kinetic friction
    Frictions = Callable[[Floats], tuple[Floats, Floats]]

__all__ = ["MOST_FRICTION", "FrictionWindow", "friction_windows"]

#: [1] Largest static friction that is searched: no pair of materials has more.
MOST_FRICTION: Final = 10.0
_LEAST: Final = 1e-3  # of the scene's friction: lower end of the search
_TRIED: Final = 129  # frictions to either side, between which a regime that comes and goes may be missed


class FrictionWindow(NamedTuple):
    """Frictions around that of a scene with which its regime stays.

    Attributes
    ----------
    low, high : float
        The last frictions that keep it [1]; where nothing ends it the last that were looked at: from a
        thousandth of static friction to ``MOST_FRICTION``, from no kinetic friction to the static one.
    below, above : Regime or Status or None
        What comes beyond each end: a regime, or a status where the body has no steady cycle; None where
        nothing ends it.
    is_proved : bool
        Whether every friction in between keeps it by proof; else between 129 frictions to either side others
        may be missed.
    """

    low: float
    high: float
    below: Regime | Status | None
    above: Regime | Status | None
    is_proved: bool


def friction_windows(scene: Scene) -> dict[str, FrictionWindow]:
    """Find the frictions with which a body keeps its regime, its drive and its trough being the same.

    Parameters
    ----------
    scene : Scene
        One operating point, of shape ().

    Returns
    -------
    dict of str to FrictionWindow
        ``static_friction``, with kinetic friction in the proportion of the scene, and ``kinetic_friction``
        alone; empty where the body has no steady cycle. Ends are found to neighbouring doubles.

    Raises
    ------
    SceneError
        If the scene is more than one operating point.

    Notes
    -----
    The throw number does not depend on friction: a body that hops does so with any. A body at rest stays at
    rest with more static friction, as the forces that it bears are more. Of drives along lines on level and
    climbing troughs the regime falls with static friction at any ratio, and rises with kinetic friction
    (``vibro.inverse.certain.certain`` has the proofs), and where kinetic friction exceeds gravity along the
    trough no body runs away. Elsewhere the windows are searched.

    Examples
    --------
    >>> import math, vibro
    >>> scene = vibro.Scene(amplitude=1e-3, frequency=15, drive_angle=math.radians(20),
    ...                     static_friction=0.74, kinetic_friction=0.57)
    >>> window = friction_windows(scene)["static_friction"]
    >>> print(f"{window.low:.6f} {window.below.label}, {window.high:.6f} {window.above.label}")
    0.649667 back-slip, 1.232577 no-slip
    """
    if scene.shape:
        raise SceneError((Problem("scene", f"shape {scene.shape}", "one operating point, of shape ()"),))
    cycle = solve(scene, output="regimes")
    regime = Regime(int(cycle.regime))
    mu_s, mu_d = float(scene.static_friction), float(scene.kinetic_friction)
    if regime is Regime.HOPPING:
        ends = {"static_friction": max(mu_s, MOST_FRICTION), "kinetic_friction": mu_s}
        return {name: FrictionWindow(0.0, high, None, None, is_proved=True) for name, high in ends.items()}
    if not Status(int(cycle.status)).answered:
        return {}
    slope = math.tan(float(scene.trough_angle))
    is_monotone = scene.arrays().can(Ability.PROOF) and slope >= 0.0
    most = max(mu_s, MOST_FRICTION)
    ways: dict[str, tuple[Frictions, Floats, Floats]] = {
        "static_friction": (
            lambda static: (static, np.minimum(mu_d / mu_s * static, static)),
            np.geomspace(mu_s, _LEAST * mu_s, _TRIED),
            np.geomspace(mu_s, most, _TRIED),
        ),
        "kinetic_friction": (
            lambda kinetic: (np.full(kinetic.shape, mu_s), kinetic),
            np.linspace(mu_d, 0.0, _TRIED),
            np.linspace(mu_d, mu_s, _TRIED),
        ),
    }
    found = {}
    for name, (frictions, down, up) in ways.items():
        solved = partial(_solved, scene, frictions)
        (low, below), (high, above) = (_end(solved, regime, values) for values in (down, up))
        is_braked = float(frictions(np.array(low))[1]) >= slope
        is_proved = regime is Regime.NO_SLIP or (is_monotone and is_braked)
        found[name] = FrictionWindow(low, high, below, above, is_proved)
    return found


def _solved(scene: Scene, frictions: Frictions, values: Floats) -> SteadyCycle:
    """Return the regimes of a scene with other frictions."""
    given = {f.name: getattr(scene, f.name) for f in fields(scene)}
    given["static_friction"], given["kinetic_friction"] = frictions(values)
    given = {name: value for name, value in given.items() if value is not None}
    return solve(Scene.computed(**given), output="regimes")


def _end(
    solved: Callable[[Floats], SteadyCycle], regime: Regime, values: Floats
) -> tuple[float, Regime | Status | None]:
    """Return the last of some frictions in a row that keeps a regime, to rounding, and what comes next."""

    def keeps(x: Floats) -> NDArray[np.bool_]:
        cycle = solved(x)
        return np.asarray((cycle.regime == regime) & (cycle.status <= Status.BOUNDARY))

    kept = keeps(values)
    if kept.all():
        return float(values[-1]), None
    first = int(np.argmin(kept))
    if not first:  # the scene stands on a threshold: rounding alone moves it across
        return float(values[0]), None
    inside, outside = close_in(lambda x: np.where(keeps(x), 1.0, -1.0), values[first - 1], values[first])
    beyond = solved(outside)
    status = Status(int(beyond.status))
    return float(inside), Regime(int(beyond.regime)) if status.answered else status
