"""How numbers become colours: scales, and the round numbers of contours."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, Final, NamedTuple

import numpy as np

if TYPE_CHECKING:
    from matplotlib.colors import Colormap, Normalize

    from vibro.reals import Floats


_NICE: Final = (1, 2, 2.5, 5, 10)  # steps between contours, in powers of ten
_BELOW_TOP: Final = 1.0 - 1e-6  # of the largest number: a contour there would trace its rounding errors
# If all numbers are nearly equal, a scale from zero would hide their differences.
_ALIKE: Final = 0.5  # least over largest
# Bodies that hop are 10 to 100 times as fast as those in contact, and irregular motion is faster still: an
# even scale shows all other numbers in one colour. It is left where the largest is so many times ...
_OVER_CONTACT: Final = 3.0  # ... the largest in contact,
_OVER_REGULAR: Final = 2.0  # the largest of motion that repeats with the drive,
_OVER_MIDDLE: Final = 10.0  # or the median.
# Near rest speeds fall to 0, and times grow without bound: ...
_BEYOND: Final = 0.02  # ... of the visible numbers so many may lie beyond the end of a logarithmic scale.
_MOST_DECADES: Final = 5.0  # of a logarithmic scale
_DENSE_DECADES: Final = 3.0  # up to which contours lie at 1, 2 and 5 of each
_LINEAR_SHARE: Final = 0.25  # of the numbers in contact, up to which an asinh scale is nearly even
_WIDE: Final = 5.0  # ratio of the longest to the shortest time above which contours are at 1, 2, 5, 10 ...
#: Names of the colours of speeds, of speeds of both signs, and of times.
SEQUENTIAL: Final = "cividis"
DIVERGING: Final = "RdBu"
TIME: Final = "cividis_r"
_PALE: Final = 0.14  # of the diverging colours, on either side of their middle: as good as white


class Scale(NamedTuple):
    """The colour scale, the levels of contours, and the ticks of the colour bar."""

    norm: Normalize
    colours: str
    levels: Floats
    ticks: Floats | None = None  # None leaves them to matplotlib
    extend: str = "neither"  # ends of the bar that also represent numbers beyond it


def scale_of(seen: Floats, regular: Floats, calm: Floats, *, reverses: bool) -> Scale:
    """Choose the scale of speeds, or of shares.

    Parameters
    ----------
    seen : float array
        All visible numbers.
    regular : float array
        Those of motion that repeats with the drive.
    calm : float array
        Those of bodies that stay in contact.
    reverses : bool
        Whether any body is certain to move backwards.

    Returns
    -------
    Scale
        Diverging about zero where motion reverses. From zero up elsewhere; from the least number where all
        are alike, and logarithmic where few large ones would leave most others in one colour.
    """
    from matplotlib.colors import AsinhNorm, CenteredNorm, LogNorm, Normalize

    if not seen.any():
        return Scale(Normalize(0.0, 1.0), SEQUENTIAL, np.empty(0))
    low, high = float(seen.min()), float(seen.max())
    sizes = np.abs(seen)
    least, middle, most = (float(size) for size in np.quantile(sizes, (0.0, 0.5, 1.0)))
    if low * high > 0.0 and least > _ALIKE * most:
        return Scale(Normalize(low, high), SEQUENTIAL, even_levels(low, high))
    usual = float(np.abs(calm).max(initial=0.0))
    slowest, fastest = float(regular.min(initial=0.0)), float(regular.max(initial=0.0))
    uneven = (
        0.0 < _OVER_CONTACT * usual < most
        or 0.0 < _OVER_REGULAR * max(-slowest, fastest) < most
        or _OVER_MIDDLE * middle < most
    )
    if not uneven:
        levels = even_levels(slowest if reverses else 0.0, fastest)
        levels = levels[levels != 0.0]
        if reverses:
            return Scale(CenteredNorm(0.0, most), DIVERGING, levels)
        # A few bounces of irregular motion, or an uncertain mean, may lie below.
        return Scale(Normalize(0.0, high), SEQUENTIAL, levels, extend="min" if low < 0.0 else "neither")
    if reverses:
        width = _LINEAR_SHARE * (usual or middle)
        ticks = log_levels(width, most)
        ticks = np.concatenate([-ticks[::-1], [0.0], ticks])
        levels = ticks[(ticks > slowest) & (ticks < _BELOW_TOP * fastest) & (ticks != 0.0)]
        return Scale(AsinhNorm(width, -most, most), DIVERGING, levels, ticks)
    foot = max(float(np.quantile(seen[seen > 0.0], _BEYOND)), high * 10.0**-_MOST_DECADES)
    foot = min(foot, high / _OVER_REGULAR)
    ticks = log_levels(foot, high)
    levels = ticks[ticks < _BELOW_TOP * fastest]
    return Scale(LogNorm(foot, high), SEQUENTIAL, levels, ticks, "min" if low < foot else "neither")


def colours_of(name: str) -> Colormap:
    """Return the colours of a scale by their name: none is white, which is the colour of bodies at rest."""
    from matplotlib import colormaps
    from matplotlib.colors import LinearSegmentedColormap

    colours = colormaps[name]
    if name != DIVERGING:
        return colours
    shown = np.concatenate([np.linspace(0.0, 0.5 - _PALE, 128), np.linspace(0.5 + _PALE, 1.0, 128)])
    return LinearSegmentedColormap.from_list(name, colours(shown), N=256)


def time_scale(seen: Floats) -> Scale:
    """Choose the scale of the visible times, logarithmic."""
    from matplotlib.colors import LogNorm

    if not seen.size:
        return Scale(LogNorm(1.0, 2.0), TIME, np.empty(0))
    bottom, longest = float(seen.min()), float(seen.max())
    top = min(float(np.quantile(seen, 1.0 - _BEYOND)), bottom * 10.0**_MOST_DECADES)
    top = max(1.01 * bottom, top)
    levels = log_levels(bottom, top) if top > _WIDE * bottom else even_levels(bottom, top)
    return Scale(LogNorm(bottom, top), TIME, levels, levels, "max" if longest > top else "neither")


def even_levels(least: float, most: float) -> Floats:
    """Return the round numbers within a range, evenly spaced."""
    from matplotlib.ticker import MaxNLocator

    levels = MaxNLocator(nbins=8, steps=_NICE).tick_values(least, most)
    return _between(least, levels, most)


def log_levels(least: float, most: float) -> Floats:
    """Return the numbers 1, 2, 5, 10 ... within a range above 0; within a long one powers of ten alone."""
    from matplotlib.ticker import LogLocator

    subs = (1.0, 2.0, 5.0) if math.log10(most / least) <= _DENSE_DECADES else (1.0,)
    locator: Any = LogLocator(subs=subs, numticks=99)
    return _between(least, locator.tick_values(least, most), most)


def _between(least: float, levels: Any, most: float) -> Floats:
    found = np.asarray(levels)
    return np.asarray(found[(found > least) & (found < (_BELOW_TOP * most if most > 0.0 else most))])
