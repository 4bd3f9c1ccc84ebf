"""Boxes of operating points within bands, and the speed of one of their bodies.

Speeds have the sign of ``Box.way``: the fastest body is the slowest one for somebody who looks at the trough
from its other side.
"""

from __future__ import annotations

import math
from typing import Final, NamedTuple

from vibro.core.buffers import Doubles
from vibro.core.codes import Regime, Status
from vibro.core.contact import steady_cycle
from vibro.core.drives import Loads, directions, ellipse_loads, ellipse_scale, line_loads
from vibro.core.elementary import INF, NAN, TURN
from vibro.core.windows import thresholds

__all__ = [
    "AXES", "BETA", "FIRST", "KINETIC", "LOAD", "SECOND", "STATIC", "THIRD", "Box", "frequency_at",
    "mean_speed", "speed_at",
]  # fmt: skip

#: Coordinates of a box: the load, three of the drive, the trough angle, both frictions.
AXES: Final = 7
LOAD: Final = 0
FIRST: Final = 1
SECOND: Final = 2
THIRD: Final = 3
BETA: Final = 4
STATIC: Final = 5
KINETIC: Final = 6


class Box(NamedTuple):
    """Bands of operating points, cut where mu_d / mu_s would leave a band of its own, up to 1 at most.

    Attributes
    ----------
    low, high : Doubles
        Ends of the bands, ``AXES`` long. The load is w^2 / g times the factor of the motion: G of a line [1],
        1/m of an ellipse. The drive has the drive angle of a line [rad], then nothing; both amplitudes [m]
        and the phase [rad] of an ellipse.
    ellipse : bool
        Which drive it is.
    ratio_low, ratio_high : float
        Band of mu_d / mu_s.
    factor_low, factor_high, frequency_low, frequency_high : float
        Bands of the factor [m, 1] and of the frequency [Hz], which the loads stand for.
    gravity : float
        [m/s^2].
    way : float
        1 where the slowest body is sought, -1 where the fastest one is.
    highest : int
        Code of the regime above which a body counts as slower than all others.
    """

    low: Doubles
    high: Doubles
    ellipse: bool
    ratio_low: float
    ratio_high: float
    factor_low: float
    factor_high: float
    frequency_low: float
    frequency_high: float
    gravity: float
    way: float
    highest: int


def frequency_at(box: Box, load: float, slow: bool) -> float:
    """Return the highest, or the lowest, frequency that has a load [Hz]: its bodies are the slowest ones."""
    factor = box.factor_low if slow else box.factor_high
    frequency = math.sqrt(load * box.gravity / factor) / TURN
    return min(max(frequency, box.frequency_low), box.frequency_high)


def mean_speed(box: Box, load: float, path: float) -> float:
    """Return the least mean speed of bodies with a load, from their path per cycle over load g / w^2 [m/s].

    At one load the speed is proportional to 1/f, Eq. (52), so that the sign of the path decides which of its
    frequencies is the slow one.
    """
    frequency = frequency_at(box, load, path > 0.0)
    return path * load * box.gravity / (TURN * TURN * frequency)


def _loads_at(box: Box, x: Doubles, row: int) -> Loads:
    """Form the groups of the body at a point; beyond the cut, of that at the cut."""
    angles = directions(x[row + THIRD] if box.ellipse else x[row + FIRST], x[row + BETA])
    mu_s = x[row + STATIC]
    mu_d = min(max(x[row + KINETIC], box.ratio_low * mu_s), box.ratio_high * mu_s)
    if not box.ellipse:
        return line_loads(1.0 / x[row + LOAD], angles, mu_s, mu_d)
    along, normal = x[row + FIRST], x[row + SECOND]
    scale = ellipse_scale(along, normal)
    return ellipse_loads(along / scale, normal / scale, 1.0 / (x[row + LOAD] * scale), angles, mu_s, mu_d)


def speed_at(box: Box, x: Doubles, row: int) -> float:
    """Return the mean speed, the ``way`` that is sought, of the body in contact at a point [m/s].

    Of the frequencies that have its load, the slowest. -inf where there is no steady motion, or a regime too
    high; NaN where the body hops, or could not be solved.
    """
    loads = _loads_at(box, x, row)
    found = steady_cycle(loads, thresholds(loads))
    if found.regime > box.highest:
        return -INF
    if found.status == Status.FLIGHT_NOT_MODELLED or found.status == Status.UNRESOLVED:
        return NAN
    if found.regime == Regime.UNDEFINED or found.status == Status.RUNAWAY:
        return -INF
    scale = ellipse_scale(x[row + FIRST], x[row + SECOND]) if box.ellipse else 1.0
    return mean_speed(box, x[row + LOAD], box.way * found.displacement * scale)
