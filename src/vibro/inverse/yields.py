"""Which share of parts does it: ``vibro.yield_share``."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from vibro.inverse.amplitudes import positive, regime_of
from vibro.inverse.bands import box_of
from vibro.scene import Scene
from vibro.steady import solve

if TYPE_CHECKING:
    from vibro.core.codes import Regime
    from vibro.inverse.boxes import Box

__all__ = ["yield_share"]

_SCRAMBLES: Final = 8
_FIRST: Final = 14  # base-2 logarithm of the points of a scramble, doubled until the error is small enough
_LAST: Final = 20
_ERROR: Final = 3e-4
_FIELDS: Final = (
    "amplitude", "frequency", "drive_angle", "static_friction", "kinetic_friction", "trough_angle",
)  # fmt: skip


def yield_share(scene: Scene, speed: float, *, highest_regime: str, **bands: Any) -> tuple[float, float]:
    """Share of the box of bands that reaches a speed without exceeding a regime.

    Parameters
    ----------
    scene : Scene
        One operating point; what has no band is known.
    speed : float
        Least mean speed, > 0 [m/s].
    highest_regime : {"forward-slip", "back-slip", "hopping"}
        Highest regime that counts.
    **bands
        As for ``vibro.guarantee``. Everything is uniform in its band and independent, cut at mu_d <= mu_s.

    Returns
    -------
    share, standard_error : float
        In [0, 1]; the error is that of 8 scrambles of a Sobol sequence, of which as many points are taken as
        it needs to be at most 3e-4. Points whose speed is unknown do not count as reaching it.

    Raises
    ------
    SceneError, InputError
        If the scene is more than one operating point, or an argument cannot be.

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
    box = box_of(scene, bands)
    shares: list[float] = []
    error = math.inf
    for logarithm in range(_FIRST, _LAST + 1):
        shares = [_share(box, target, highest, logarithm, seed) for seed in range(_SCRAMBLES)]
        error = float(np.std(shares, ddof=1)) / math.sqrt(_SCRAMBLES)
        if error <= _ERROR:
            break
    return float(np.mean(shares)), error


def _share(box: Box, target: float, highest: Regime, logarithm: int, seed: int) -> float:
    """Share of one scramble."""
    from scipy.stats import qmc  # late: it takes a fifth of a second to load

    spans = (
        box.amplitude, box.frequency, box.drive_angle, box.trough_angle, box.static_friction,
        box.second_friction,
    )  # fmt: skip
    low, high = (np.array(ends, np.float64)[:, None] for ends in zip(*spans, strict=True))
    points = qmc.Sobol(len(spans), rng=np.random.default_rng(seed)).random_base2(logarithm).T
    amplitude, frequency, alpha, beta, mu_s, second = low + points * (high - low)
    mu_d = second * mu_s if box.is_ratio else second
    inside = mu_d <= mu_s
    if not inside.any():  # the bands have one friction in common
        mu_s, inside = mu_d, np.ones_like(inside)
    fields = (x[inside] for x in (amplitude, frequency, alpha, mu_s, mu_d, beta))
    cycle = solve(Scene.allowing_infeasible(**dict(zip(_FIELDS, fields, strict=True)), **box.constants))
    reaches = (cycle.mean_velocity >= target) & (cycle.regime <= highest)
    return float(np.mean(reaches))
