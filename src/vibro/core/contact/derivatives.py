"""How the displacement of a steady contact cycle changes with the inputs, in closed form.

Equation numbers are those of docs/theory.md. Lengths in A, phases in radians. Derivatives are the rows of
arrays of shape (5, n), in the order of ``Gradient``.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Final, NamedTuple

import numpy as np

from vibro.core.codes import Pattern
from vibro.core.contact.never_at_rest import never_at_rest
from vibro.core.contact.onset import thresholds
from vibro.core.contact.slide import slide, start_inside
from vibro.core.contact.starts import resting_start
from vibro.core.groups import take
from vibro.core.series import R, polynomial

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray

    from vibro.core.contact.onset import Margins
    from vibro.core.contact.slide import Floats, Onset
    from vibro.core.groups import Loads

__all__ = ["Gradient", "displacement_gradient"]

_SLIDING: Final = (Pattern.F_, Pattern.B_, Pattern.F_B_, Pattern.FB_, Pattern.F_B, Pattern.FB)


class Gradient(NamedTuple):
    """Derivatives of the displacement per drive cycle over A, with respect to one input each; 1-D.

    Attributes
    ----------
    log_load : array
        ln G, G = A w^2 / g [1].
    drive_angle, trough_angle : array
        alpha and beta [1/rad].
    static_friction, kinetic_friction : array
        mu_s and mu_d [1].
    """

    log_load: Floats
    drive_angle: Floats
    static_friction: Floats
    kinetic_friction: Floats
    trough_angle: Floats


def displacement_gradient(scene: Loads, pattern: NDArray[np.integer]) -> Gradient:
    """Differentiate the displacement of steady contact cycles whose patterns are known.

    Parameters
    ----------
    scene : Loads
        Groups of the scenes, 1-D, or 0-d where one value serves all.
    pattern : int array
        Codes of ``Pattern``, 1-D, from ``steady_state``; it does not change with the inputs, but at a few of
        their values.

    Returns
    -------
    Gradient
        0 at rest; NaN where there is no steady contact cycle.

    Notes
    -----
    Eqs. (45)-(50). Just above an onset it grows without bound, like 1 over the root of the distance. Within
    16 eps (1 + 1 / d) of its largest member of differences with 60 digits, where d is 1 - s of the onsets
    in the cycle, and 1 - abs(t) / (mu_d n) in FB (tests/core/contact/test_derivatives.py).
    """
    scene = scene._replace(normal=np.broadcast_to(scene.normal, pattern.shape))
    margins = thresholds(scene).margins
    out = np.full((len(Gradient._fields), pattern.size), np.nan)
    out[:, pattern == Pattern.R] = 0.0
    for code in _SLIDING:
        cells = np.flatnonzero(pattern == code)
        if cells.size:
            out[:, cells] = _gradient(take(scene, cells), take(margins, cells), code)
    return Gradient(*out)


def _rows(*rows: ArrayLike) -> Floats:
    """Stack the derivatives with respect to the five inputs."""
    return np.stack(np.broadcast_arrays(*rows))


def _gradient(scene: Loads, at: Margins, pattern: Pattern) -> Floats:
    """Differentiate the displacement of scenes of one pattern."""
    if pattern in (Pattern.F_, Pattern.B_):
        direction = 1 if pattern is Pattern.F_ else -1
        return direction * _Way(scene, at, direction).from_rest().displacement
    forward, back = _Way(scene, at, 1), _Way(scene, at, -1)
    if pattern is Pattern.FB:
        return _never_at_rest(scene, forward, back)
    if pattern is Pattern.F_B:
        first = back.from_rest()
        return forward.after(first).displacement - first.displacement
    first = forward.from_rest()
    second = back.after(first) if pattern is Pattern.FB_ else back.from_rest()
    return first.displacement - second.displacement


class _Slid(NamedTuple):
    """One slide: its end [rad], and the derivatives of its displacement [A] and of its end, (5, n)."""

    end: Floats
    displacement: Floats
    end_change: Floats


class _Way:
    """Slides forward (+1) or back (-1), in their own phase: the derivatives of their load amplitude and k."""

    def __init__(self, scene: Loads, at: Margins, direction: int) -> None:
        self._scene, self._direction = scene, direction
        self.start = resting_start(scene, at, direction)
        self._static_load = at.forward_load if direction > 0 else at.back_load
        mu_d, k, load = scene.kinetic_friction, self.start.onset.k, self.start.load
        swing = direction * mu_d * scene.along - scene.across
        lean = (direction * scene.normal - mu_d * scene.tangential) / load
        self.load_change = _rows(0.0, swing, 0.0, direction * scene.across, 0.0)
        self.k_change = _rows(-k, -k * swing / load, 0.0, scene.contrast / (load * load), lean)  # Eq. (47)

    def from_rest(self) -> _Slid:
        """Slide from the onset, Eq. (48)."""
        scene, static_load, mu_s = self._scene, self._static_load, self._scene.static_friction
        swing = self._direction * mu_s * scene.along - scene.across
        lean = (self._direction * scene.normal - mu_s * scene.tangential) / static_load
        s = self.start.onset.cos
        grip = scene.contrast / (static_load * static_load)
        sine_change = _rows(-s, -s * swing / static_load, grip, 0.0, lean)
        return self._slid(self.start.onset, sine_change / self.start.onset.sin)

    def after(self, before: _Slid) -> _Slid:
        """Slide from where the opposite slide ends."""
        c = 1.5 * np.pi - before.end
        return self._slid(start_inside(c, self.start.onset.k), before.end_change)

    def _slid(self, start: Onset, start_change: Floats) -> _Slid:
        """Differentiate a slide, Eqs. (45) and (46)."""
        end = slide(start)
        x, u = end.x, end.x - start.c
        lost = start.excess * start_change
        way_lost = 2.0 * x * self.start.load * (x * self.k_change + lost)
        displacement = end.reach * self.load_change - way_lost
        braking = 2.0 * np.sin(u) * np.sin(x) - start.excess  # k - sin p1
        end_change = -(2.0 * x * self.k_change + lost) / braking
        return _Slid(0.5 * np.pi + x + u, displacement, end_change)


def _never_at_rest(scene: Loads, forward: _Way, back: _Way) -> Floats:
    """Differentiate the displacement of cycles without rest, Eqs. (49) and (50)."""
    cycle, _ = never_at_rest(scene, forward.start, back.start)
    mu_d, a, b, n, t = scene.kinetic_friction, scene.along, scene.across, scene.normal, scene.tangential
    h = scene.contrast
    turn = _rows(
        0.0,
        (mu_d * n - t) * (mu_d * n + t) / (mu_d * h * h),
        0.0,
        (b * n + a * t / (mu_d * mu_d)) / h,
        -(a - mu_d * b) * (a + mu_d * b) * (n * n + t * t) / (mu_d * h * h),
    )
    y_change = 0.5 * np.pi * turn
    lift, lift_change = mu_d * b, _rows(0.0, mu_d * a, 0.0, b, 0.0)
    x = 0.5 * np.pi + cycle.y
    widening = x * x * polynomial(x * x, R) / cycle.cos_y  # 1/x - cot x
    middle_change = x / cycle.cos_y * forward.k_change + cycle.sin_m * widening * y_change
    span = 2.0 * lift * cycle.y + np.pi * a
    lean = 2.0 * lift * cycle.cos_y + span * cycle.sin_y
    lean_change = (
        span * cycle.cos_y * y_change
        + 2.0 * (cycle.cos_y + cycle.y * cycle.sin_y) * lift_change
        + np.pi * cycle.sin_y * _rows(0.0, -b, 0.0, 0.0, 0.0)
    )
    return 2.0 * (cycle.cos_m * lean_change - lean * cycle.sin_m / cycle.cos_m * middle_change)
