"""Smoothed friction: no rest and no events, only one ordinary differential equation."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, Final

import numpy as np
from scipy.integrate import solve_ivp

from vibro.accuracy.motion import Found

if TYPE_CHECKING:
    from vibro.accuracy.motion import TroughBody


_TURN: Final = 2.0 * math.pi
_RTOL: Final = 1e-6
_PLACE_ATOL: Final = 1e-9  # [A]
_SPEED_ATOL: Final = 1e-4  # [width]

# The coefficient rises to mu_s within this many widths, and falls to mu_d within about twice as many.
_PEAK: Final = 5.0  # [width]

_SETTLED: Final = 1e-3  # [width] smaller changes of the displacement from cycle to cycle count as none
_MOST_TURNS: Final = 200


def simulate_smoothed(motion: TroughBody, width: float) -> Found:
    """Simulate from rest, with a friction law that has no jump, until the displacement repeats.

    The coefficient is ``tanh(v/w) (mu_d + (mu_s - mu_d) exp(-(max(abs(v)/w - 5, 0)/5)^2))``. This smoothed
    law reaches the static value, so it tends to Coulomb's law with stiction as w -> 0. Where a body should
    rest, it creeps at up to a few w.

    Parameters
    ----------
    motion : TroughBody
        One scene in contact.
    width : float
        w [A w].

    Returns
    -------
    Found
        Slides are speeds beyond the peak of the friction law; NaN if the motion does not settle.
    """
    along, across, normal, tangential, mu_s, mu_d = motion
    extra = mu_s - mu_d

    def rates(phase: float, y: Any) -> tuple[float, float]:
        sine = math.sin(phase)
        speed = y[1] / width
        beyond = max(abs(speed) - _PEAK, 0.0) / _PEAK
        coefficient = math.tanh(speed) * (mu_d + extra * math.exp(-beyond * beyond))
        return y[1], along * sine - tangential - coefficient * (normal - across * sine)

    speed, before = 0.0, math.inf
    for _ in range(_MOST_TURNS):
        atol = (_PLACE_ATOL, _SPEED_ATOL * width)
        run = solve_ivp(rates, (0.0, _TURN), (0.0, speed), method="LSODA", rtol=_RTOL, atol=atol)
        if run.status != 0:
            break
        place, speed = run.y[:, -1]
        if abs(place - before) <= _SETTLED * width:
            forward, back = np.max(run.y[1]) > _PEAK * width, np.min(run.y[1]) < -_PEAK * width
            return Found(float(place), "F" * bool(forward) + "B" * bool(back))
        before = place
    return Found(math.nan, "")
