"""Bracketed root search along one unknown, for all rooms above the core."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import NDArray

    from vibro.reals import Floats


_NEIGHBOURS: Final = 4.0 * float(np.finfo(np.float64).eps)  # [1] relative width of a bracket that is closed


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
        Arguments per bracket and call, for functions whose calls cost the same for many arguments.

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


def sign_changes(
    residual: Callable[[NDArray[np.int64], Floats], Floats],
    below: Floats,
    above: Floats,
    values: tuple[Floats, Floats],
) -> tuple[Floats, Floats, Floats, Floats]:
    """Narrow brackets, each around one change of sign, to neighbouring doubles or an exact zero.

    Chandrupatla's method (1997): inverse quadratic interpolation where it is safe, else halving. A residual
    may jump: then the values at both ends stay apart.

    Parameters
    ----------
    residual : callable
        Of the indices of brackets and as many arguments; returns their values.
    below, above : (n,) array
        Ends at which it is < 0, and > 0; 0 at one of them is a root.
    values : pair of (n,) array
        Its values there.

    Returns
    -------
    below, above, at_below, at_above : (n,) array
        The last brackets, and the residual at their ends.
    """
    a, b = below.copy(), above.copy()
    fa, fb = (x.copy() for x in values)
    c, fc, share = a.copy(), fa.copy(), np.full(a.shape, 0.5)
    while (
        open_ := np.flatnonzero((np.abs(b - a) > _NEIGHBOURS * np.abs(b)) & (fa != 0.0) & (fb != 0.0))
    ).size:
        i = open_
        x = a[i] + share[i] * (b[i] - a[i])
        fx = np.asarray(residual(i, x))
        same = (fx < 0.0) == (fa[i] < 0.0)
        c[i], fc[i] = np.where(same, a[i], b[i]), np.where(same, fa[i], fb[i])
        b[i], fb[i] = np.where(same, b[i], a[i]), np.where(same, fb[i], fa[i])
        a[i], fa[i] = x, fx
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
            xi, phi = (a[i] - b[i]) / (c[i] - b[i]), (fa[i] - fb[i]) / (fc[i] - fb[i])
            safe = (phi**2 < xi) & ((1.0 - phi) ** 2 < 1.0 - xi)
            t = fa[i] / (fb[i] - fa[i]) * fc[i] / (fb[i] - fc[i])
            t += (c[i] - a[i]) / (b[i] - a[i]) * fa[i] / (fc[i] - fa[i]) * fb[i] / (fc[i] - fb[i])
            least = np.minimum(_NEIGHBOURS * np.abs(a[i]) / np.abs(b[i] - a[i]), 0.5)
        share[i] = np.clip(np.where(safe, t, 0.5), 0.5 * least, 1.0 - 0.5 * least)
    low = (fa < 0.0) | ((fa == 0.0) & (fb > 0.0))
    return np.where(low, a, b), np.where(low, b, a), np.where(low, fa, fb), np.where(low, fb, fa)
