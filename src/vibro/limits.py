"""Where a scene changes its regime: critical loads, and what comes next from one operating point."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Final, NamedTuple

import numpy as np

from vibro.core.contact import limits
from vibro.errors import Problem, SceneError

if TYPE_CHECKING:
    from vibro.core.contact.limits import CriticalLoads
    from vibro.scene import Scene

__all__ = ["Transition", "critical_loads", "transitions"]

_BEGINNINGS: Final = {
    "forward_onset": "forward slip",
    "back_onset": "load for back slip",
    "back_slip": "back slip",
    "rest_vanishes": "never at rest",
    "hop": "hopping",
}


class Transition(NamedTuple):
    """Where a kind of motion begins, as seen from one operating point.

    Attributes
    ----------
    name : str
        What begins.
    ratio : float
        The scene's load over the load at which it begins: above 1 it has begun [1].
    amplitude : float
        Amplitude at which it begins at the scene's frequency [m].
    frequency : float
        Frequency at which it begins at the scene's amplitude [Hz].
    """

    name: str
    ratio: float
    amplitude: float
    frequency: float


def critical_loads(scene: Scene) -> CriticalLoads:
    """Critical loads G = A w^2 / g, at which the steady cycle from rest changes its regime.

    Parameters
    ----------
    scene : Scene
        Operating points of any shape; amplitude, frequency, gravity and restitution have no effect.

    Returns
    -------
    CriticalLoads
        ``hop``, ``forward_onset``, ``back_onset``, ``back_slip`` and ``rest_vanishes``: arrays of the common
        shape of angles and frictions, which broadcasts against the scene's [1]. inf where a transition never
        happens, 0 where it always has; NaN where the combination is infeasible or mu_s = 0.

    Notes
    -----
    Closed forms, Eqs. (4), (5) and (21), and one root in a bracket, Eq. (22). They agree with ``solve`` on
    both sides of each load (tests/core/contact/test_limits.py).

    Examples
    --------
    >>> import math, vibro
    >>> scene = vibro.Scene(amplitude=1e-3, frequency=15, drive_angle=math.radians(20),
    ...                     static_friction=0.74, kinetic_friction=0.57)
    >>> print(f"{vibro.critical_loads(scene).forward_onset:.6f}")
    0.620395
    """
    with np.errstate(over="ignore"):  # of frictions at the ends of the range of doubles
        return limits.critical_loads(
            scene.drive_angle, scene.static_friction, scene.kinetic_friction, scene.trough_angle
        )


def transitions(scene: Scene) -> tuple[Transition, ...]:
    """Where each kind of motion begins, as seen from one operating point.

    Parameters
    ----------
    scene : Scene
        One operating point, of shape ().

    Returns
    -------
    tuple of Transition
        By rising amplitude; without what hopping forestalls, what no load brings, and what is beyond the
        range of doubles.

    Raises
    ------
    SceneError
        If the scene is more than one operating point.

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
        merely_load = name == "back_onset" and load == loads["back_slip"]
        if merely_load or not 0.0 < load < math.inf or (name != "hop" and load >= loads["hop"]):
            continue
        ratio = float(scene.load) / load
        if not 0.0 < ratio < math.inf:  # beyond the range of doubles
            continue
        amplitude, frequency = float(scene.amplitude) / ratio, float(scene.frequency) / math.sqrt(ratio)
        found.append(Transition(_BEGINNINGS[name], ratio, amplitude, frequency))
    return tuple(sorted(found, key=lambda transition: transition.amplitude))
