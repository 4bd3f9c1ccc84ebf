"""One slide under loads with harmonics: where it stops, how far it goes, how fast it gets.

A slide in the direction sigma has the acceleration g(p) = sigma F - mu_d N, a wave. A phase s after its start

    g = g_0 + sum_n [B_n sin(n s) - A_n (1 - cos(n s))],
    v = g_0 s + sum_n [B_n (1 - cos(n s)) - A_n (n s - sin(n s))]/n,

each term without cancellation for short slides. Its speed turns at the zeros of g; it stops before the first
of its minima that is not positive. Lengths in A, speeds in A w, phases in radians.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Final, NamedTuple

import numpy as np

from vibro.core.harmonic.arrays import FEW_ULP, GAP, R, polynomial
from vibro.core.harmonic.waves import TURN, crossings, harmonics, in_order, rough_crossings, values, wrapped
from vibro.core.harmonic.zeros import level_start, zeros

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Floats = NDArray[np.float64]
    Bools = NDArray[np.bool_]
    Indices = NDArray[np.intp]

__all__ = ["Lanes", "Slides", "distance", "lanes", "rates", "slides", "velocity"]

# [1] The power series of z - sin z and of sin y - y cos y are for arguments up to this.
_SHORT: Final = 1.0


class Lanes(NamedTuple):
    """Scenes by direction: the first half of the columns is forward, the second, in the same order, back.

    Attributes
    ----------
    static, kinetic : array
        Waves: load of a resting body beyond static friction, and of a sliding one beyond kinetic friction.
    noise : array
        Loads within it are zero by rounding.
    onset : array
        Phases in [0, 2 pi) at which a body at rest starts to slide, H rows, NaN after the last.
    excess : array
        Acceleration at the onsets, without cancellation.
    opening, top : array
        Phases at which the speed of a slide is least, and largest, alike.
    jump, jump_excess : array
        Phases at which a body at rest stays so but would, set in motion by as little as may be, slide on:
        kinetic friction is just overcome there, or static friction no more; 2 H rows, NaN for none.
        Acceleration there.
    """

    static: Floats
    kinetic: Floats
    noise: Floats
    onset: Floats
    excess: Floats
    opening: Floats
    top: Floats
    jump: Floats
    jump_excess: Floats


class Slides(NamedTuple):
    """Ends of slides.

    Attributes
    ----------
    length : array
        Phase from start to end [rad]; inf where a slide never ends.
    path : array
        Distance, >= 0; NaN where it never ends.
    peak : array
        Largest speed; NaN where it never ends.
    edge : bool array
        Whether rounding decides at which minimum of the speed it stops.
    settled : bool array
        Whether the end was found to rounding.
    """

    length: Floats
    path: Floats
    peak: Floats
    edge: Bools
    settled: Bools


def rates(waves: Floats, phase: Floats) -> Floats:
    """Rows [g_0, A_1 ..., B_1 ...] of waves seen from phases."""
    h = waves.shape[0] // 2
    out = np.empty(waves.shape)
    out[0] = waves[0]
    for n, (s, c) in enumerate(harmonics(phase, h), 1):
        out[n] = waves[n] * s + waves[h + n] * c
        out[h + n] = waves[n] * c - waves[h + n] * s
        out[0] += out[n]
    return out


def velocity(s: Floats, rates: Floats) -> tuple[Floats, Floats, Floats]:
    """Speed, acceleration and its derivative a phase s after a start at zero speed; s may have rows."""
    h = rates.shape[0] // 2
    speed, slope, bend = rates[0] * s, rates[0] + np.zeros(s.shape), np.zeros(s.shape)
    for n, (sine, cosine) in enumerate(harmonics(0.5 * s, h), 1):
        twice = 2.0 * sine
        rise, versine = twice * cosine, twice * sine
        z = n * s
        gap = z - rise
        _in_series(gap, z, GAP)
        a, b = rates[n], rates[h + n]
        speed += (b * versine - a * gap) * (1.0 / n)
        slope += b * rise - a * versine
        bend += n * (b - (b * versine + a * rise))
    return speed, slope, bend


def _in_series(out: Floats, argument: Floats, series: tuple[float, ...]) -> None:
    """Put the power series of functions like z - sin z where the argument is short."""
    short = (argument.reshape(-1) < _SHORT).nonzero()[0]
    if short.size:
        z = argument.reshape(-1)[short]
        square = z * z
        out.reshape(-1)[short] = polynomial(square, series) * (square * z)


def distance(s: Floats, rates: Floats) -> Floats:
    """Distance of slides of length s that end at zero speed.

    With v(s) = 0 the constant drops out, as in Eq. (11): each harmonic gives its load's slope at the middle
    times sin y - y cos y, y = n s/2.
    """
    h = rates.shape[0] // 2
    path = np.zeros(s.shape)
    for n, (sine, cosine) in enumerate(harmonics(0.5 * s, h), 1):
        y = 0.5 * n * s
        bulge = sine - y * cosine
        _in_series(bulge, y, R)
        path += (2.0 / (n * n)) * bulge * (rates[n] * sine - rates[h + n] * cosine)
    return path


def lanes(
    static: Floats,
    kinetic: Floats,
    points: Floats,
    at: Floats,
    across: Floats,
    normal: Floats,
    noise: Floats,
    friction_gap: Floats,
) -> Lanes:
    """Prepare scenes.

    Parameters
    ----------
    static, kinetic : array
        Waves of both directions.
    points, at : array
        Turning points of the static ones, and their values there.
    across : array
        Waves of the load off the trough, one column a scene.
    normal, friction_gap : array
        Weight on the trough, and mu_s - mu_d.
    noise : array
        See ``Lanes``.
    """
    onset, closing = crossings(static, points, at)
    off = np.concatenate([across, across], axis=1)
    gap = np.concatenate([friction_gap, friction_gap])
    weight = np.concatenate([normal, normal])
    excess, last_excess = (np.maximum(gap * (weight - values(off, p)), 0.0) for p in (onset, closing))
    opening, top = rough_crossings(kinetic)
    jump = np.concatenate([opening, np.where(last_excess > noise, closing, np.nan)])
    jump[:, gap == 0.0] = np.nan
    jump_excess = np.concatenate([0.0 * opening, last_excess])
    return Lanes(static, kinetic, noise, onset, excess, opening, top, jump, jump_excess)


def slides(at: Lanes, lane: Indices, phase: Floats, excess: Floats) -> Slides:
    """Follow slides from zero speed to their ends.

    Parameters
    ----------
    at : Lanes
        Scenes.
    lane : int array
        Column of each slide.
    phase : array
        Phase at its start, inside its window.
    excess : array
        Acceleration there where that is known better than from the phase; else NaN.
    """
    own = rates(at.kinetic.take(lane, axis=1), phase)
    np.copyto(own[0], excess, where=~np.isnan(excess))
    h = own.shape[0] // 2
    tops = in_order(wrapped(at.top.take(lane, axis=1) - phase))
    # a start at an opening may seem to lie before it
    bottoms = wrapped(at.opening.take(lane, axis=1) - phase)
    bottoms = in_order(np.where(bottoms < tops[0], bottoms + TURN, bottoms))
    highest, _, _ = velocity(tops, own)
    least, _, _ = velocity(bottoms, own)
    noise = FEW_ULP * (np.abs(own[0]) * TURN + 2.0 * np.abs(own[1:]).sum(axis=0))
    stops = least <= 0.0
    ends = stops.any(axis=0)
    first = np.argmax(stops, axis=0)
    before = np.arange(h)[:, np.newaxis] <= np.where(ends, first, h)
    edge = ((np.abs(least) <= noise) & before).any(axis=0)
    peak = np.where(before, highest, -np.inf)
    peak = np.fmax.reduce(peak, axis=0)
    columns = np.arange(lane.size)
    low, high = tops[first, columns], bottoms[first, columns]
    at_low, at_high = highest[first, columns], least[first, columns]
    solved = (ends & (at_low > 0.0)).nonzero()[0]
    length = np.where(ends, low, np.inf)
    settled = np.ones(lane.size, np.bool_)
    low, high = low[solved], high[solved]
    start = level_start(low, high, at_low[solved], at_high[solved])
    falls = np.ones(solved.size, np.bool_)
    length[solved], settled[solved] = zeros(velocity, own.take(solved, axis=1), start, low, high, falls, low)
    edge |= ends & (at_low <= 0.0)
    with np.errstate(invalid="ignore"):
        path = np.where(ends, distance(np.where(ends, length, 0.0), own), np.nan)
    return Slides(length, path, np.where(ends, peak, np.nan), edge, settled)
