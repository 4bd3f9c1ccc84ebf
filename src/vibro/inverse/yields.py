"""Compute the share of parts that reach a speed: ``vibro.yield_share``."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from vibro.inverse.bands import uncertainty_set
from vibro.inverse.windows import positive, regime_of
from vibro.reals import shielded
from vibro.scene import Scene
from vibro.steady import solve

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from vibro.core.codes import Regime
    from vibro.inverse.spaces import UncertaintySet

    Floats = NDArray[np.float64]

__all__ = ["yield_share"]

_SCRAMBLES: Final = 8
_FIRST: Final = 14  # base-2 logarithm of the points of a scramble, doubled until the error is small enough
_LAST: Final = 20
_ERROR: Final = 3e-4


@shielded
def yield_share(scene: Scene, speed: float, *, highest_regime: str, **bands: Any) -> tuple[float, float]:
    """Return the share of a box of bands that reaches a speed without exceeding a regime.

    Parameters
    ----------
    scene : Scene
        One operating point, with the values of all quantities that have no band.
    speed : float
        Least mean speed, > 0 [m/s].
    highest_regime : {"forward-slip", "back-slip", "hopping"}
        Highest regime allowed.
    **bands
        As for ``vibro.guarantee``. Quantities are independent and uniform in their bands, subject to mu_d <=
        mu_s.

    Returns
    -------
    share, standard_error : float
        Share, in [0, 1], and its standard error, which is at most 3e-4 unless 8 million points do not suffice
        [1]. Points whose speed is unknown count as not reaching it.

    Raises
    ------
    SceneError
        If the scene is more than one operating point, or a band is invalid.
    InputError
        If another argument is invalid.

    Notes
    -----
    The share is a mean over 8 scrambled Sobol sequences, whose scatter gives the error; their length is
    doubled until the error is small enough.

    Examples
    --------
    >>> import math, vibro
    >>> scene = vibro.Scene(amplitude=0.9e-3, frequency=15, drive_angle=math.radians(25),
    ...                     static_friction=0.6, kinetic_friction=0.5)
    >>> share, error = vibro.yield_share(scene, 0.02, highest_regime="forward-slip",
    ...                                  static_friction=(0.5, 0.8), friction_ratio=(0.6, 0.95))
    >>> print(f"{share:.3f}")
    0.095
    """
    highest = regime_of(highest_regime)
    target = positive("speed", speed, "m/s")
    box = uncertainty_set(scene, bands)
    shares: list[float] = []
    error = math.inf
    for logarithm in range(_FIRST, _LAST + 1):
        shares = [_share(box, target, highest, logarithm, seed) for seed in range(_SCRAMBLES)]
        # if all scrambles agree, a share below one point may have been missed
        least = 1.0 / (_SCRAMBLES * 2**logarithm)
        error = max(float(np.std(shares, ddof=1)) / math.sqrt(_SCRAMBLES), least)
        if error <= _ERROR:
            break
    return float(np.mean(shares)), error


def _share(box: UncertaintySet, target: float, highest: Regime, logarithm: int, seed: int) -> float:
    """Return the share of one scramble."""
    from scipy.stats import qmc  # late: it takes a fifth of a second to load

    spans = (
        box.factor, box.frequency, *box.shape.values(), box.trough_angle, box.static_span,
        box.second_friction,
    )  # fmt: skip
    low, high = (np.array(ends, np.float64)[:, None] for ends in zip(*spans, strict=True))
    points = qmc.Sobol(len(spans), rng=np.random.default_rng(seed)).random_base2(logarithm).T
    factor, frequency, *shape, beta, mu_s, mu_d = low + points * (high - low)
    if box.is_ratio:
        mu_d = np.minimum(mu_d * mu_s, mu_s)
    else:
        mu_s, mu_d = _cut(box, points[-2], points[-1])
    motion = box.space.motion(factor, tuple(shape))
    cycle = solve(
        Scene.computed(
            **motion, frequency=frequency, trough_angle=beta, static_friction=mu_s, kinetic_friction=mu_d,
            **box.constants,
        )
    )  # fmt: skip
    reaches = (cycle.mean_velocity >= target) & (cycle.regime <= highest)
    return float(np.mean(reaches))


def _cut(box: UncertaintySet, u: Floats, v: Floats) -> tuple[Floats, Floats]:
    """Return frictions that are uniform where mu_d <= mu_s, for uniform numbers.

    Beside a static friction the kinetic one has the width min(mu_s, k_high) - k_low, which is the density of
    static friction: a trapezoid, whose share up to a friction is inverted.
    """
    (s_low, s_high), (k_low, k_high) = box.static_span, box.second_friction
    knee = min(max(k_high, s_low), s_high)  # up to where kinetic friction is cut
    slope = 0.5 * (knee - s_low) * (s_low + knee - 2.0 * k_low)
    whole = slope + (k_high - k_low) * (s_high - knee)
    if whole > 0.0:
        area = u * whole
        rising = k_low + np.sqrt((s_low - k_low) ** 2 + 2.0 * area)
        flat = knee + (area - slope) / (k_high - k_low)
        mu_s = np.clip(np.where(area < slope, rising, flat), s_low, s_high)
    else:  # one friction has no width
        mu_s = s_low + u * (s_high - s_low)
    low, high = box.kinetic_span(mu_s)
    return mu_s, low + v * (high - low)
