"""Rounding to a number of significant digits."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Floats = NDArray[np.float64]

__all__ = ["MOST_DIGITS", "rounded"]

#: Digits that distinguish every double from its neighbours.
MOST_DIGITS: Final = 17
# Up to so many, a number of so many digits without a point is a double.
_WHOLE_DIGITS: Final = 15
_POWERS: Final = 10.0 ** np.arange(23)  # 1e22 is the last power of ten that is a double


def rounded(values: Floats, digits: int) -> Floats:
    """Round to significant digits, correctly.

    Parameters
    ----------
    values : float array
        Of any shape; NaN and inf stay as they are.
    digits : int
        From 1 to 17.

    Returns
    -------
    float array
        The doubles nearest to the decimals that are nearest to the values, of two the even one: those of
        ``float(format(x, f".{digits}g"))``. A value that would be rounded beyond the range of doubles stays.

    Notes
    -----
    Python's rounding of one number takes half a microsecond. Here values are scaled to whole numbers with so
    many digits: one rounding of half an ulp, which decides nothing unless a tie is as near. Scaling back is
    exact up to the last rounding, as whole number and power of ten are doubles. Python rounds the others.
    """
    if digits >= MOST_DIGITS:
        return values
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        size = np.abs(values)
        places = digits - 1.0 - np.floor(np.log10(size))
        quick = np.abs(places) < _POWERS.size
        large = places < 0.0
        power = _POWERS[np.where(quick, np.abs(places), 0.0).astype(np.intp)]
        scaled = np.where(large, size / power, size * power)
        whole = np.rint(scaled)
        least, most = 10.0 ** (digits - 1), 10.0**digits
        quick &= (scaled >= least) & (scaled < most)  # else the logarithm was off
        quick &= 0.5 - np.abs(scaled - whole) > np.spacing(most)
    if digits > _WHOLE_DIGITS:
        quick[...] = False
    result = np.where(quick, np.copysign(np.where(large, whole * power, whole / power), values), values)
    others = ~quick & np.isfinite(values) & (values != 0.0)
    spelled = np.array([float(f"{x:.{digits - 1}e}") for x in values[others].tolist()], np.float64)
    result[others] = np.where(np.isfinite(spelled), spelled, values[others])
    return result
