"""The cycle without rest: two slides, each of which starts where the other one ends.

Equation numbers are those of docs/theory.md. Lengths in A, speeds in A w. The middle m of the forward slide
is a phase of the motion along the trough [rad].
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Final, NamedTuple

import numpy as np

from vibro.core.contact.slide import slide, start_inside
from vibro.core.contact.starts import Verdict, verdict
from vibro.core.contact.windows import own_phase, skew_of
from vibro.core.groups import put, take
from vibro.core.roots import OpenCells

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from vibro.core.contact.slide import Floats
    from vibro.core.contact.starts import Start
    from vibro.core.groups import Loads

    Bools = NDArray[np.bool_]

__all__ = [
    "NeverAtRest",
    "by_half_length",
    "is_sure",
    "likely_never_at_rest",
    "never_at_rest",
    "never_at_rest_motion",
    "never_at_rest_slope",
]

_FEW_STEPS: Final = 3  # of Halley's iteration, which nearly every cell needs
_MORE_STEPS: Final = 60
_SETTLED: Final = 1e-8  # [1] a last step below this share of 1 - cot m leaves rounding errors only
_STEEP: Final = 0.8  # [1] tan(beta) / mu_d above which Eq. (61) is solved: y = x - pi/2 is its unknown

#: k and load of the forward slide, and of the back slide.
Slides = tuple[tuple["Floats", "Floats"], tuple["Floats", "Floats"]]


class NeverAtRest(NamedTuple):
    """The never-at-rest cycle, Eqs. (18)-(19) and (59)-(61); NaN where there is none.

    Attributes
    ----------
    y, sin_y, cos_y : array
        x - pi/2, where x is half the length of the forward slide.
    sin_m, cos_m : array
        Of pi - m: positive, along a line both.
    """

    y: Floats
    sin_y: Floats
    cos_y: Floats
    sin_m: Floats
    cos_m: Floats


def never_at_rest(scene: Loads, forward: Start, back: Start) -> tuple[NeverAtRest, Verdict]:
    """Phases of the never-at-rest cycle, and whether both its slides start beyond static friction."""
    cycle, valid = likely_never_at_rest(scene, forward, back)
    if scene.lead:
        cells = (~is_sure(scene, cycle)).nonzero()[0]
        if cells.size:
            better, verdicts = by_half_length(*take((scene, forward, back), cells))
            put(cycle, cells, better)
            put(valid, cells, verdicts)
    return cycle, valid


def likely_never_at_rest(scene: Loads, forward: Start, back: Start) -> tuple[NeverAtRest, Verdict]:
    """Return the same at less cost, of elliptical drives only where ``is_sure``."""
    if scene.lead is None:
        return _of_a_line(scene, forward, back)
    with np.errstate(invalid="ignore", divide="ignore", over="ignore"):
        cycle = _from_middle(scene, _lower_root(scene))
        steep = _is_steep(scene).nonzero()[0]
        if steep.size:
            put(cycle, steep, by_half_length(*take((scene, forward, back), steep))[0])
        return cycle, _starts_beyond(scene, cycle)


def _is_steep(scene: Loads) -> Bools:
    """Whether the trough is about as steep as kinetic friction holds: y follows cot m too closely there."""
    steep = np.abs(scene.tangential) > _STEEP * scene.kinetic_friction * scene.normal
    return np.broadcast_to(steep, np.broadcast_shapes(steep.shape, scene.along.shape))


def _of_a_line(scene: Loads, forward: Start, back: Start) -> tuple[NeverAtRest, Verdict]:
    """Solve drives along a line, Eqs. (18) and (19)."""
    mu_d = scene.kinetic_friction
    possible = (forward.onset.k > 0.0) & (back.onset.k > 0.0)
    with np.errstate(invalid="ignore", divide="ignore", over="ignore"):
        turn = mu_d * scene.across * scene.normal - scene.tangential / mu_d * scene.along
        y = np.where(possible, 0.5 * np.pi * turn / scene.contrast, np.nan)
    t = np.tan(0.5 * y)
    cos_y = 2.0 / (1.0 + t * t)
    sin_y = cos_y * t
    cos_y -= 1.0
    sin_m = forward.onset.k * (0.5 * np.pi + y) / cos_y
    possible &= (sin_m > 0.0) & (sin_m < 1.0)
    sin_m = np.where(possible, sin_m, np.nan)
    cos_m = np.sqrt((1.0 - sin_m) * (1.0 + sin_m))
    rise, fall = cos_m * cos_y, sin_m * sin_y
    scale = 1.0 + sin_m
    ahead = verdict(rise - fall - forward.onset.cos, scale)
    behind = verdict(rise + fall - back.onset.cos, scale)
    valid = (ahead.positive | ahead.edge) & (behind.positive | behind.edge)
    return NeverAtRest(y, sin_y, cos_y, sin_m, cos_m), Verdict(valid, valid & (ahead.edge | behind.edge))


def _sine_and_cosine(y: Floats) -> tuple[Floats, Floats]:
    """Sine and cosine of angles within +-pi/2 from one tangent."""
    half = np.tan(0.5 * y)
    scale = 1.0 / (1.0 + half * half)
    return 2.0 * half * scale, (1.0 - half) * (1.0 + half) * scale


class _Equation(NamedTuple):
    """What Eq. (60) is made of, over a: arrays that broadcast against each other.

    ``rho = rho_0 + rho_1 z`` is mu_d times the ratio of the normal to the tangential swing in the middle of
    the slides, z = cot m; ``hold`` is pi mu_d n / 2 and ``lean`` t.
    """

    rho_0: Floats
    rho_1: Floats
    slope: Floats  # t / (mu_d n)
    hold: Floats
    lean: Floats

    def half_length(self, z: Floats) -> tuple[Floats, Floats]:
        """Y of Eq. (59), and its derivative."""
        rho = self.rho_0 + self.rho_1 * z
        if not np.count_nonzero(self.lean):
            return 0.5 * np.pi * rho, 0.5 * np.pi * self.rho_1
        share = 1.0 / (1.0 - rho * self.slope)
        y = 0.5 * np.pi * (rho - self.slope) * share
        return y, 0.5 * np.pi * self.rho_1 * (1.0 - self.slope) * (1.0 + self.slope) * share * share

    def halley(self, z: Floats) -> tuple[Floats, Floats]:
        """Halley's step of Eq. (60) at z, and the slope of its left side.

        The curvature leaves out what is of the order of t on inclines.
        """
        y, rate = self.half_length(z)
        sine, cosine = _sine_and_cosine(y)
        square = 1.0 + z * z
        root = np.sqrt(square)
        drag = self.hold
        slope = -sine * rate
        if np.count_nonzero(self.lean):
            drag = drag + self.lean * y
            slope -= self.lean * rate * root
        drag = drag * root
        slope -= drag * z / square
        left = cosine - drag
        curve = cosine * rate * rate + drag / (square * square)  # with the sign turned
        return -left * slope / (slope * slope + 0.5 * left * curve), slope


def _equation(scene: Loads) -> _Equation:
    assert scene.lead is not None
    mu_d, a, t = scene.kinetic_friction, scene.along, scene.tangential
    swing = mu_d * scene.across / a
    inclined = np.count_nonzero(t)
    return _Equation(
        swing * scene.lead.cosine,
        swing * scene.lead.sine,
        t / (mu_d * scene.normal) if inclined else t,
        0.5 * np.pi * mu_d * scene.normal / a,
        t / a if inclined else t,
    )


def _lower_root(scene: Loads) -> Floats:
    """Find z = cot m of the cycle, the lower root of Eq. (60); NaN where there is none.

    On a level trough its left side is concave and not positive at the start, so that the iteration rises
    to the root, or passes the top of the curve. On an incline it need not be, and a root may be missed.
    """
    assert scene.lead is not None
    equation = _equation(scene)
    least = equation.hold - 0.5 * np.pi * np.abs(equation.lean)
    possible = (least > 0.0) & (least < 1.0)
    # where the drive cannot outweigh the drag, and where a slide would take the whole cycle
    z = -np.sqrt((1.0 - least) * (1.0 + least)) / least
    whole = (-np.copysign(1.0, equation.rho_1) - equation.rho_0) / equation.rho_1
    z = np.where(possible, np.where(np.isfinite(whole), np.maximum(z, whole), z), np.nan)
    step, slope = z, z
    for _ in range(_FEW_STEPS):
        step, slope = equation.halley(z)
        z = z + step
    left = np.flatnonzero(possible & ~((np.abs(step) <= _SETTLED * (1.0 + np.abs(z))) & (slope > 0.0)))
    if left.size:
        z[left] = _refined(take(equation, left), z[left])
    return z


def _refined(equation: _Equation, z: Floats) -> Floats:
    """Go on with Halley's iteration; NaN where it does not settle on a rising branch."""
    found = np.full(z.shape, np.nan)
    going = OpenCells(np.arange(z.size), (equation, z), _MORE_STEPS)
    for cells, (part, at) in going:
        step, slope = part.halley(at)
        at = at + step
        lost = ~(slope > 0.0)
        settled = ~lost & (np.abs(step) <= _SETTLED * (1.0 + np.abs(at)))
        found[cells[settled]] = at[settled]
        going.keep(~lost & ~settled, (part, at))
    return found


def _from_middle(scene: Loads, z: Floats) -> NeverAtRest:
    """Form the cycle from z = cot m, where it is one; Eq. (59)."""
    assert scene.lead is not None
    swing = scene.kinetic_friction * scene.across / scene.along
    rho = swing * (scene.lead.cosine + z * scene.lead.sine)
    slope = scene.tangential / (scene.kinetic_friction * scene.normal)
    y = 0.5 * np.pi * (rho - slope) / (1.0 - rho * slope)
    sin_y, cos_y = _sine_and_cosine(np.where(np.abs(rho) < 1.0, y, np.nan))
    sin_m = 1.0 / np.sqrt(1.0 + z * z)
    return NeverAtRest(y, sin_y, cos_y, sin_m, -z * sin_m)


def _turned(scene: Loads, cycle: NeverAtRest) -> tuple[Floats, Floats]:
    """Sine and cosine of m + phi."""
    assert scene.lead is not None
    sine = cycle.sin_m * scene.lead.cosine - cycle.cos_m * scene.lead.sine
    return sine, -cycle.cos_m * scene.lead.cosine - cycle.sin_m * scene.lead.sine


def _sines(sine: Floats, cosine: Floats, cycle: NeverAtRest) -> tuple[Floats, Floats]:
    """Sines of a motion where the forward and the back slide start, from its phase in the middle m."""
    level, tilt = cosine * cycle.cos_y, sine * cycle.sin_y
    return -level - tilt, level - tilt


def _cosines(sine: Floats, cosine: Floats, cycle: NeverAtRest) -> tuple[Floats, Floats]:
    """Cosines, as ``_sines``."""
    level, tilt = sine * cycle.cos_y, cosine * cycle.sin_y
    return level - tilt, -level - tilt


def _starts_beyond(scene: Loads, cycle: NeverAtRest) -> Verdict:
    """Whether both slides start where the load exceeds static friction, Eq. (62)."""
    a, lift, hold = scene.along, scene.static_friction * scene.across, scene.static_friction * scene.normal
    scale = a + lift + hold
    along, normal = _sines(cycle.sin_m, -cycle.cos_m, cycle), _sines(*_turned(scene, cycle), cycle)
    ahead = verdict(a * along[0] + lift * normal[0] - hold - scene.tangential, scale)
    behind = verdict(lift * normal[1] - a * along[1] - hold + scene.tangential, scale)
    valid = (ahead.positive | ahead.edge) & (behind.positive | behind.edge)
    return Verdict(valid, valid & (ahead.edge | behind.edge))


def is_sure(scene: Loads, cycle: NeverAtRest) -> Bools:
    """Whether the lower root of Eq. (60), or its absence, is sure to be that of Eq. (61), which has but one.

    It is where the middle of each slide comes after the crest of its load, and on a level trough, where the
    left side of Eq. (60) is concave, where there is no root. On steep troughs it is that of Eq. (61).
    """
    assert scene.lead is not None
    lift = scene.kinetic_friction * scene.across
    after = np.abs(lift * _turned(scene, cycle)[1]) < scene.along * cycle.cos_m
    return np.where(np.isnan(cycle.y), scene.tangential == 0.0, after) | _is_steep(scene)


def by_half_length(scene: Loads, forward: Start, back: Start) -> tuple[NeverAtRest, Verdict]:
    """Cycle of elliptical drives by Eq. (61), whose root is the only one: where the lower root is not sure.

    It is looked for between the lengths at which one of the slides would start with the load that resists it,
    as half the length of the slide that is the shorter one where the other hardly ends.
    """
    assert scene.lead is not None
    from scipy.optimize import elementwise  # late: few scenes need its import time

    def middles(x: Floats, k: Floats, k_other: Floats) -> tuple[Floats, Floats]:
        """Phases from the middle of each slide to half a turn after its own zero."""
        return _arc(k * x, np.sin(x)), _arc(k_other * (np.pi - x), np.sin(x))

    def apart(x: Floats, k: Floats, k_other: Floats, swing: Floats) -> Floats:
        """Phase between the middles of both slides: monotone."""
        own, other = middles(x, k, k_other)
        return np.asarray(own - other + swing)

    with np.errstate(invalid="ignore", divide="ignore", over="ignore"):
        k_f, k_b, swing = forward.onset.k, back.onset.k, skew_of(scene, scene.kinetic_friction)
        ahead = k_b <= k_f  # the forward slide is the shorter one
        k, k_other, swing = np.where(ahead, (k_f, k_b, swing + 0.0 * k_f), (k_b, k_f, -swing + 0.0 * k_f))
        possible = (k_other > 0.0) & (k < 1.0)
        low = np.pi - _longest(np.where(possible, k_other, 0.5))
        high = _longest(np.where(possible, k, 0.5))
        ends = apart(low, k, k_other, swing), apart(high, k, k_other, swing)
        cells = np.flatnonzero(possible & (low < high) & (ends[0] <= 0.0) & (ends[1] >= 0.0))
        x, before, after = np.full((3, k.size), np.nan)
        if cells.size:
            members = take((k, k_other, swing), cells)
            x[cells] = elementwise.find_root(
                apart,
                (low[cells], high[cells]),
                args=members,
                tolerances={"xatol": 0.0, "xrtol": 4 * 2.0**-52, "fatol": 0.0, "frtol": 0.0},
            ).x
            before[cells], after[cells] = middles(x[cells], *members[:2])
        # from the slide whose load is farther from its crest there; m is a phase of the motion along
        own = before <= after
        zero = own_phase(scene, np.where(own == ahead, 1, -1)) + scene.lead.angle
        middle = np.pi - np.where(own, before, after) - zero
        middle = np.where(own == ahead, middle, middle - np.pi)  # that of the back slide is half a turn later
        y, sin_y = x - 0.5 * np.pi, -np.cos(x)
        cycle = NeverAtRest(
            np.where(ahead, y, -y), np.where(ahead, sin_y, -sin_y), np.sin(x), np.sin(middle), -np.cos(middle)
        )
        return cycle, _starts_beyond(scene, cycle)


def _arc(sine: Floats, over: Floats) -> Floats:
    """Arc sine of a quotient that rounding may bring above 1."""
    return np.asarray(np.arcsin(np.minimum(sine / over, 1.0)))


def _longest(k: Floats) -> Floats:
    """Half the length of the longest slide, which starts with the load that resists it: sin x = k x."""
    return slide(start_inside(np.arccos(k), k)).x


def never_at_rest_motion(scene: Loads, slides: Slides, cycle: NeverAtRest) -> tuple[Floats, Floats]:
    """Displacement, Eqs. (20) and (63), and peak speed of the never-at-rest cycle.

    ``slides`` are the k and the load of the forward and the back slide. They are never short, so that
    Eq. (14) is used as it stands.
    """
    lift = scene.kinetic_friction * scene.across
    if scene.lead is None:
        span = (2.0 * lift * cycle.y + np.pi * scene.along) * cycle.sin_y
        displacement = 2.0 * cycle.cos_m * (2.0 * lift * cycle.cos_y + span)
        c_m = np.arcsin(cycle.sin_m)
        middle, tilt = cycle.sin_m * cycle.cos_y, cycle.cos_m * cycle.sin_y
        starts = [(middle + side * tilt, c_m + side * cycle.y) for side in (1.0, -1.0)]
    else:
        turned, widening = _turned(scene, cycle), cycle.cos_y + cycle.y * cycle.sin_y
        displacement = (
            2.0 * np.pi * scene.along * cycle.cos_m * cycle.sin_y - 4.0 * lift * turned[1] * widening
        )
        sine, cosine = cycle.sin_m, -cycle.cos_m
        sines = zip(_sines(sine, cosine, cycle), _sines(*turned, cycle), strict=True)
        cosines = zip(_cosines(sine, cosine, cycle), _cosines(*turned, cycle), strict=True)
        starts = []
        for way, load, at, after in zip((1.0, -1.0), slides, sines, cosines, strict=True):
            rate = way * scene.along * after[0] + lift * after[1]
            starts.append((rate / load[1], np.arctan2(rate, way * scene.along * at[0] + lift * at[1])))
    peaks = [
        load * (sine + np.sqrt((1.0 - k) * (1.0 + k)) - k * (c + np.arccos(k)))
        for (k, load), (sine, c) in zip(slides, starts, strict=True)
    ]
    return displacement, np.maximum(*peaks)


def never_at_rest_slope(scene: Loads, cycle: NeverAtRest) -> Floats:
    """Differentiate the displacement of elliptical drives with respect to ln G, Eq. (64)."""
    z = -cycle.cos_m / cycle.sin_m
    equation, turns = _equation(scene), 2.0 / np.pi * cycle.y
    steep = (1.0 - equation.slope) * (1.0 + equation.slope)
    y_rate = 0.5 * np.pi * equation.rho_1 * (1.0 + equation.slope * turns) ** 2 / steep
    lift, lean = scene.kinetic_friction * scene.across, equation.lean
    root = np.sqrt(1.0 + z * z)
    drag = cycle.cos_y / root  # over a, by Eq. (60)
    slope = -cycle.sin_y * y_rate - lean * y_rate * root - drag * z / root
    sine, cosine = _turned(scene, cycle)
    middle = 2.0 * np.pi * scene.along * cycle.sin_m * cycle.sin_y
    middle += 4.0 * lift * sine * (cycle.cos_y + cycle.y * cycle.sin_y)
    length = (2.0 * np.pi * scene.along * cycle.cos_m - 4.0 * lift * cosine * cycle.y) * cycle.cos_y
    return -cycle.cos_y / slope * (length * y_rate - middle * cycle.sin_m * cycle.sin_m)
