"""Bracketed root search along one unknown, for all rooms above the core."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import NDArray

    Floats = NDArray[np.float64]

__all__ = ["close_in"]


def close_in(
    residual: Callable[[Floats], Floats],
    inside: Floats | float,
    outside: Floats | float,
    *,
    relative: float = 0.0,
    absolute: float = 0.0,
    sections: int = 1,
) -> tuple[Floats, Floats]:
    """Narrow brackets around a change of a residual's sign.

    Parameters
    ----------
    residual : callable
        Of arguments of shape ``(*shape, sections)``; returns as many values, >= 0 where what is asked for
        holds. Speeds jump, so that its sign counts and its size does not.
    inside, outside : array or float
        Arguments of one shape at which it holds, and at which it does not.
    relative, absolute : float
        Widths at which the search ends: of the argument, and in its unit. Without both it goes on to
        neighbouring doubles.
    sections : int
        Arguments looked at in every bracket at once: a call that costs the same for many is best asked so.

    Returns
    -------
    inside, outside : array
        The last argument at which it holds, and the first at which it does not.
    """
    inside, outside = np.asarray(inside, np.float64), np.asarray(outside, np.float64)
    shares = np.arange(1.0, sections + 1.0) / (sections + 1.0)
    while inside.size and np.any(np.abs(outside - inside) > relative * np.abs(inside) + absolute):
        between = inside[..., None] + shares * (outside - inside)[..., None]
        if np.all((between == inside[..., None]) | (between == outside[..., None])):
            break
        fails = ~(np.asarray(residual(between)) >= 0.0)
        all_held = ~fails.any(axis=-1)
        first = np.where(all_held, sections, np.argmax(fails, axis=-1))
        points = np.concatenate([inside[..., None], between, outside[..., None]], axis=-1)
        inside, outside = (np.take_along_axis(points, (first + i)[..., None], -1)[..., 0] for i in range(2))
    return inside, outside
