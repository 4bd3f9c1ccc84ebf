"""The walk from event to event with slides in closed form, in many digits where mpmath is installed."""

from __future__ import annotations

import math
from functools import partial
from typing import TYPE_CHECKING, Any, Final

from scipy.optimize import brentq

from vibro.accuracy.events import walk
from vibro.accuracy.motion import trough_body

if TYPE_CHECKING:
    from collections.abc import Sequence

    from vibro.accuracy.motion import Found, TroughBody


try:
    import mpmath
except ModuleNotFoundError:
    _LIBRARY: Any = math
    _DOUBLINGS, _SETTLED, NAME = 0, 1e-13, "event walk in double precision"
else:
    _LIBRARY = mpmath.mp.clone()
    _LIBRARY.dps = 60
    # Steps of Newton's method, each of which doubles the digits; and how closely starts settle [rad].
    _DOUBLINGS, _SETTLED, NAME = 3, 1e-20, "event walk in 60-digit arithmetic"
_LEAST: Final = 1e-300  # [rad] ends of slides are found to rounding


def exact(values: Sequence[float]) -> Found:
    """Follow one scene in contact from rest until its motion repeats.

    Parameters
    ----------
    values : sequence of float
        Amplitude [m], frequency [Hz], drive angle [rad], mu_s, mu_d, trough angle [rad], gravity [m/s^2],
        taken as exact.
    """
    number = float if _LIBRARY is math else _LIBRARY.mpf
    body = trough_body([number(value) for value in values], _LIBRARY)
    return walk(body, _slide, _SETTLED, library=_LIBRARY, extrapolates=True)


def _slide(motion: TroughBody, kind: str, phase: Any) -> tuple[Any, Any]:
    """End and distance of a slide, whose speed over its load is cos p0 - cos p - k (p - p0).

    It rises to p = pi - asin k and falls to 2 pi + asin k: its first zero lies between, or there is none.
    """
    sign = 1 if kind == "F" else -1
    load, resistance = motion.sliding(sign)
    k, pi = resistance / load, _LIBRARY.pi
    if not -1 < k < 1:
        return None, math.nan
    p0 = (phase if kind == "F" else phase - pi) % (
        2 * pi
    )  # phase since the load that way was zero and rising
    rough = partial(_speed, float(p0), float(k))
    low, high = (float(end - p0) for end in (pi - _LIBRARY.asin(k), 2 * pi + _LIBRARY.asin(k)))
    if rough(high) > 0.0:
        return None, math.nan
    x = brentq(rough, low, high, xtol=_LEAST, rtol=1e-15)
    cos, sin = _LIBRARY.cos(p0), _LIBRARY.sin(p0)
    for _ in range(_DOUBLINGS):
        x -= (cos - _LIBRARY.cos(p0 + x) - k * x) / (_LIBRARY.sin(p0 + x) - k)
    distance = x * cos - (_LIBRARY.sin(p0 + x) - sin) - k * x * x / 2
    return phase + x, sign * load * distance


def _speed(start: float, k: float, length: float) -> float:
    return 2.0 * math.sin(start + 0.5 * length) * math.sin(0.5 * length) - k * length
