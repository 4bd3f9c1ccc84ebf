"""Which part of a sweep a picture shows: two axes, facets for a third, and all others held."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from vibro.errors import InputError

if TYPE_CHECKING:
    from collections.abc import Mapping

    from numpy.typing import NDArray

    from vibro.axes import Axis
    from vibro.results.sweep import SweepResult

__all__ = [
    "MAX_FACETS",
    "Panel",
    "View",
    "check_drawable",
    "choose_view",
    "panels",
]

MAX_FACETS: Final = 12
_LEAST, _MOST = 1e-100, 1e100  # of what is drawn, in its unit


@dataclass(frozen=True)
class View:
    """The drawn part of a sweep.

    Attributes
    ----------
    x : Axis
        Across.
    y : Axis or None
        Up; None where one axis varies.
    facet : Axis or None
        What differs from panel to panel.
    facet_indices : tuple of int
        Indices of the facets' values on that axis; one entry, -1, without facets.
    held : mapping of str to int
        Index of the value at which every other axis is held.
    """

    x: Axis
    y: Axis | None
    facet: Axis | None
    facet_indices: tuple[int, ...]
    held: Mapping[str, int]

    @property
    def drawn(self) -> dict[str, tuple[int, ...]]:
        """Indices of the values that are drawn, for every axis but x and y, by name."""
        drawn: dict[str, tuple[int, ...]] = {name: (index,) for name, index in self.held.items()}
        if self.facet is not None:
            drawn[self.facet.name] = self.facet_indices
        return drawn


@dataclass(frozen=True, eq=False)
class Panel:
    """One map or line of a picture; arrays have the shape (y, x), or (1, x) without a y axis.

    Attributes
    ----------
    values : mapping of str to float
        Every quantity but x and y, in the user's units.
    facet : str or None
        Name of the quantity that differs from panel to panel.
    cycle : mapping of str to array
        The attributes of ``SteadyCycle``.
    critical : mapping of str to array
        Critical loads G, by the field of ``CriticalLoads``; of length 1 where they do not vary.
    """

    x: Axis
    y: Axis | None
    values: Mapping[str, float]
    facet: str | None
    cycle: Mapping[str, NDArray[Any]]
    critical: Mapping[str, NDArray[np.float64]]


def choose_view(
    axes: Mapping[str, Axis],
    x: str | None = None,
    y: str | None = None,
    at: Mapping[str, float] | None = None,
) -> View:
    """Decide what is drawn of a sweep.

    Parameters
    ----------
    axes : mapping of str to Axis
        The axes that vary.
    x, y : str, optional
        Names of the axes to draw across and up. Without them x is the frequency and y the amplitude
        where both vary, else the first two axes that are not held.
    at : mapping of str to float, optional
        Values, in the user's units, at which axes are held; the nearest on the axis is taken.

    Returns
    -------
    View
        A third axis makes up to ``MAX_FACETS`` facets, spread evenly over its values; the others are held at
        their first values.

    Raises
    ------
    InputError
        If a name is no axis of the sweep, is used twice, or a value lies outside of its axis.
    """
    at = at or {}
    _check_names(axes, x, y, at)
    free = [name for name in axes if name not in at and name not in (x, y)]
    if x is None and y is None and {"amplitude", "frequency"} <= set(free):
        x, y = "frequency", "amplitude"
        free = [name for name in free if name not in (x, y)]
    if x is None:
        if not free:
            if y is not None and not at:
                raise InputError("the only axis of the sweep is drawn across", hint="leave y out")
            raise InputError("every axis of the sweep is held: nothing is left to draw", hint="hold one less")
        x = free.pop(0)
    if y is None and free:
        y = free.pop(0)
    facet = axes[free.pop(0)] if free else None
    held = {name: _index(axes[name], value) for name, value in at.items()}
    held |= dict.fromkeys(free, 0)
    return View(axes[x], axes[y] if y else None, facet, _facet_indices(facet), held)


def check_drawable(view: View) -> None:
    """Refuse axes whose lengths matplotlib's arithmetic loses or overflows.

    Raises
    ------
    InputError
        If a value that is drawn is beyond 1e100, or but for 0 below 1e-100.
    """
    for axis in filter(None, (view.x, view.y, view.facet)):
        sizes = np.abs(axis.values[axis.values != 0.0])
        if np.any((sizes < _LEAST) | (sizes > _MOST)):
            ends = f"{axis.label} = {axis.values[0]:g} ... {axis.values[-1]:g}"
            raise InputError(f"{ends}: no picture has such an axis", hint="-o - writes the table alone")


def _check_names(axes: Mapping[str, Axis], x: str | None, y: str | None, at: Mapping[str, float]) -> None:
    named = [name for name in (x, y, *at) if name is not None]
    for name in named:
        if name not in axes:
            label = name.replace("_", " ")
            known = ", ".join(axis.label for axis in axes.values())
            raise InputError(f"{label} does not vary in this sweep", hint=f"its axes are {known}")
        if named.count(name) > 1:
            raise InputError(f"{axes[name].label} is asked for twice", hint="give x, y and at different axes")


def _index(axis: Axis, value: float) -> int:
    low, high = float(axis.values[0]), float(axis.values[-1])
    if not low <= value <= high:
        raise InputError(
            f"{axis.label} = {value:.6g} {axis.unit}".rstrip() + " lies outside of the sweep",
            hint=f"give a value from {low:.6g} to {high:.6g} {axis.unit}".rstrip(),
        )
    return int(np.argmin(np.abs(axis.values - value)))


def _facet_indices(facet: Axis | None) -> tuple[int, ...]:
    if facet is None:
        return (-1,)
    n = min(len(facet), MAX_FACETS)
    return tuple(int(i) for i in np.round(np.linspace(0, len(facet) - 1, n)))


def panels(result: SweepResult, view: View) -> list[Panel]:
    """Cut the drawn panels out of a sweep, as views of its arrays where possible."""
    return [_panel(result, view, index) for index in view.facet_indices]


def _panel(result: SweepResult, view: View, facet_index: int) -> Panel:
    held = dict(view.held)
    if view.facet is not None:
        held[view.facet.name] = facet_index
    names = list(result.axes)

    def cut(values: NDArray[Any]) -> NDArray[Any]:
        # Critical loads do not vary with amplitude or frequency, and have length 1 along them. The modulus
        # turns any index along those axes into 0.
        part = values[
            tuple(
                held[name] % n if name in held else slice(None)
                for name, n in zip(names, values.shape, strict=True)
            )
        ]
        drawn = [name for name in names if name not in held]
        if view.y is None:
            return part[np.newaxis, :]
        return part.T if drawn[0] == view.x.name else part

    values = {**result.fixed, **{name: float(result.axes[name].values[i]) for name, i in held.items()}}
    return Panel(
        view.x,
        view.y,
        values,
        view.facet.name if view.facet else None,
        {name: cut(field) for name, field in vars(result.cycle).items()},
        {
            name: cut(getattr(result.limits, name))
            for name in ("hop", "forward_onset", "back_slip", "rest_vanishes")
        },
    )
