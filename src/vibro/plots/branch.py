"""A bifurcation diagram: a branch of cycles over a quantity, stable or not, with its events."""

from __future__ import annotations

from itertools import pairwise
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from vibro.plots.frame import set_heading, settle
from vibro.plots.style import INK, UNIT_SIGNS, house_style, value_text
from vibro.quantities import QUANTITIES

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from matplotlib.figure import Figure
    from numpy.typing import NDArray

    Floats = NDArray[np.float64]

__all__ = ["branch_figure"]

_STABLE: Final[Mapping[str, Any]] = {"color": "#004488", "linestyle": "-", "linewidth": 2.2}
_UNSTABLE: Final[Mapping[str, Any]] = {"color": "#BB5566", "linestyle": (0, (4, 2)), "linewidth": 1.4}
_NAMES: Final = {
    "fold": "fold",
    "doubling": "period doubling",
    "contact": "a landing leads to contact",
    "grazing": "a flight grazes",
    "hop_limit": "throw number 1",
    "cut": "followed no further",
}
_FLAT: Final = 1e-6  # [1] of a number, below which it is constant
_AROUND: Final = 0.1  # [1] of it, shown above and below
_MARKERS: Final = {"fold": "o", "doubling": "D", "contact": "s", "grazing": "^", "hop_limit": "v", "cut": "X"}


def branch_figure(
    heading: str,
    name: str,
    x: Floats,
    curves: Floats,
    label: str,
    stable: NDArray[np.bool_],
    events: Sequence[tuple[str, int]],
) -> Figure:
    """Draw a branch.

    Parameters
    ----------
    heading : str
        Title.
    name : str
        The quantity across.
    x : array, shape (n,)
        Its values, in the user's unit, in the order of the branch.
    curves : array, shape (n, m)
        What is drawn over it.
    label : str
        Name and unit of that.
    stable : bool array, shape (n,)
        Where the cycle is stable.
    events : sequence of (str, int)
        Kinds of events, and their rows; ends of the range are not marked.

    Returns
    -------
    Figure
        Of m lines; a piece is solid if its ends, except events, are stable, else dashed.
    """
    with house_style():
        from vibro.plots.picture import Picture

        figure = Picture(figsize=(7.4, 4.6))
        axes = figure.subplots()
        legend: dict[str, dict[str, Any]] = {}
        at_events = {row for _, row in events}
        # a piece between neighbours is as that end of it which is no event
        solid = np.array(
            [
                stable[a] if b in at_events and a not in at_events else stable[b]
                for a, b in pairwise(range(x.size))
            ],
            bool,
        )
        for text, look, wanted in (("stable", _STABLE, True), ("unstable", _UNSTABLE, False)):
            if (solid == wanted).any():
                for curve in curves.T:
                    axes.plot(*_pieces(x, curve, solid == wanted), gid=text, zorder=3, **look)
                legend[text] = dict(look)
        quantity = QUANTITIES[name]
        for kind in _NAMES:
            rows = [row for event, row in events if event == kind]
            if rows:
                mark: dict[str, Any] = {
                    "linestyle": "none",
                    "marker": _MARKERS[kind],
                    "markersize": 6.5,
                    "zorder": 5,
                }
                mark |= {"markerfacecolor": "#FFFFFF", "markeredgecolor": INK, "markeredgewidth": 1.4}
                places = ", ".join(value_text(name, float(x[row])) for row in rows)
                text = f"{_NAMES[kind]}: {places}"
                axes.plot(np.repeat(x[rows], curves.shape[1]), curves[rows].ravel(), gid=kind, **mark)
                legend[text] = mark
        unit = f" [{UNIT_SIGNS.get(quantity.unit, quantity.unit)}]" if quantity.unit else ""
        axes.set_xlabel(f"{quantity.label} ${quantity.symbol}${unit}")
        axes.set_ylabel(label)
        finite = curves[np.isfinite(curves)]
        low, high = (finite.min(), finite.max()) if finite.size else (0.0, 1.0)
        if high - low <= _FLAT * abs(high):  # a scale would show rounding alone
            axes.set_ylim(low - _AROUND * abs(low), high + _AROUND * abs(high))
        axes.grid(axis="y", color="#BBBBBB", linewidth=0.5, zorder=0.8)
        set_heading(figure, heading, "")
        settle(figure, legend)
        return figure


def _pieces(x: Floats, y: Floats, wanted: NDArray[np.bool_]) -> tuple[Floats, Floats]:
    """Return the pieces of a line that are wanted, NaN between; those that follow each other are one."""
    starts, ends = np.append(wanted, False), np.append(False, wanted)
    across, up = (np.where(starts | ends, values, np.nan) for values in (x, y))
    # both ends of a piece that is not wanted may belong to others that are
    gaps = np.flatnonzero(~wanted) + 1
    return np.insert(across, gaps, np.nan), np.insert(up, gaps, np.nan)
