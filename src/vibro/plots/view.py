"""The part of a sweep that a picture shows: its axes, curves and facets for short lists, others held."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from vibro.errors import InputError
from vibro.quantities import SIZES, STANDS_FOR, as_given, kinetic_friction

if TYPE_CHECKING:
    from collections.abc import Mapping

    from numpy.typing import NDArray

    from vibro.axes import Axis
    from vibro.results.sweep import SweepResult

MAX_FACETS: Final = 12
# A value that is typed with another unit, or copied from a picture, differs in its last digits.
_SAME: Final = 5e-5  # relative difference
_CURVES: Final = ("hop", "forward_onset", "back_slip", "continuous_sliding")


@dataclass(frozen=True)
class View:
    """The drawn part of a sweep.

    Attributes
    ----------
    x : Axis
        Across.
    y : Axis or None
        Up, on maps; None on pictures of lines or points.
    curves : Axis or None
        The axis with a curve for each value.
    facet : Axis or None
        The axis with a panel for each value.
    facet_indices : tuple of int
        Indices of the facets' values on that axis; one entry, -1, without facets.
    held : mapping of str to int
        Index of the value at which every other axis is held.
    """

    x: Axis
    y: Axis | None
    curves: Axis | None
    facet: Axis | None
    facet_indices: tuple[int, ...]
    held: Mapping[str, int]

    @property
    def drawn(self) -> dict[str, tuple[int, ...]]:
        """Indices of the values that are drawn of every axis that is no continuum here.

        By the names of a grid, which has amplitudes also where they were given as strokes.
        """
        drawn: dict[str, tuple[int, ...]] = {name: (index,) for name, index in self.held.items()}
        if self.facet is not None:
            drawn[self.facet.name] = self.facet_indices
        for axis in filter(None, (self.x, self.curves)):
            if is_discrete(axis):
                drawn[axis.name] = tuple(range(len(axis)))
        return {"amplitude" if name == "stroke" else name: indices for name, indices in drawn.items()}


def is_discrete(axis: Axis) -> bool:
    """Whether an axis is a short list, whose values are drawn one by one."""
    return axis.spacing == "list" and len(axis) <= MAX_FACETS


def value_of(axis: Axis, index: int) -> str:
    """Write a value of an axis with its unit, to so many digits that it is known when it is typed."""
    return f"{axis.values[index]:.10g} {axis.unit}".rstrip()


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
        Critical loads G, by the field of ``CriticalLoads``; of length 1 where they do not vary, and none of
        drives with harmonics.
    load : array, optional
        Load G; without it that of the scenes that the values and axes make.
    amplitude : array, optional
        Amplitudes that follow from a machine, which are not among ``values`` [mm].
    """

    x: Axis
    y: Axis | None
    values: Mapping[str, float]
    facet: str | None
    cycle: Mapping[str, NDArray[Any]]
    critical: Mapping[str, NDArray[np.float64]]
    load: NDArray[np.float64] | None = None
    amplitude: NDArray[np.float64] | None = None


def choose_view(
    axes: Mapping[str, Axis],
    x: str | None = None,
    y: str | None = None,
    at: Mapping[str, float] | None = None,
    fixed: Mapping[str, float] | None = None,
) -> View:
    """Choose the part of a sweep to be drawn.

    Parameters
    ----------
    axes : mapping of str to Axis
        The axes that vary. One that is a list of at most ``MAX_FACETS`` values is discrete; any other is a
        range here.
    x, y : str, optional
        Names of the axes to draw across and up; an amplitude may be called so where the axis is its stroke,
        acceleration or speed, and the other way round; in ``at`` where it is its stroke. Without them x is
        the frequency and y the amplitude where both are ranges, and no other amplitude is; else the first two
        ranges that are not held; of discrete axes alone, x is the longest.
    at : mapping of str to float, optional
        Values, in the user's units, at which axes are held.
    fixed : mapping of str to float, optional
        Every other quantity, in the user's units: it may make values of an axis infeasible.

    Returns
    -------
    View
        Beside two ranges the first discrete axis, or a third range, makes facets, of a range up to
        ``MAX_FACETS``, spread evenly over its values. Beside one range, or on their own, the first two
        discrete axes make curves and facets. All others are held, in their order, at the middle of their
        values that leave feasible combinations.

    Raises
    ------
    InputError
        If a name is no axis of the sweep, or is used twice, a value is not one of its axis, or a discrete
        axis is asked for as an axis of a map.
    """
    x, y = (name and _called(name, axes) for name in (x, y))
    at = as_given(at or {}, in_stroke="stroke" in axes)
    _check_names(axes, x, y, at)
    free = [name for name in axes if name not in at]
    if not free:
        raise InputError("every axis of the sweep is fixed: nothing is left to draw", hint="hold one less")
    lists = [name for name in free if is_discrete(axes[name])]
    ranges = [name for name in free if name not in lists]
    _check_map(axes, x, y, lists, ranges)
    amplitudes = [name for name in SIZES if name in ranges]
    if x is None and y is None and len(amplitudes) == 1 and "frequency" in ranges:
        x, y = "frequency", amplitudes[0]
    ranges = [name for name in ranges if name not in (x, y)]
    if x is None:
        x = ranges.pop(0) if ranges else max(lists, key=lambda name: len(axes[name]))
    if y is None and ranges:
        y = ranges.pop(0)
    lists = [name for name in lists if name != x]
    curves = axes[lists.pop(0)] if y is None and lists else None
    others = [*lists, *ranges]
    facet = axes[others.pop(0)] if others else None
    held = {name: index_of(axes[name], value) for name, value in at.items()}
    held |= _middles(axes, [name for name in axes if name in others], held, fixed or {})
    shown = np.round(np.linspace(0, len(facet) - 1, min(len(facet), MAX_FACETS))) if facet else [-1]
    return View(axes[x], axes[y] if y else None, curves, facet, tuple(map(int, shown)), held)


def _called(name: str, axes: Mapping[str, Axis]) -> str:
    """Return the name of the axis that gives what a name means: of an amplitude its stroke."""
    meant = STANDS_FOR.get(name, name)
    alike = (axis for axis in axes if STANDS_FOR.get(axis, axis) == meant)
    return name if name in axes else next(alike, name)


def _check_names(axes: Mapping[str, Axis], x: str | None, y: str | None, at: Mapping[str, float]) -> None:
    named = [name for name in (x, y, *at) if name is not None]
    for name in named:
        if name not in axes:
            label = name.replace("_", " ")
            known = ", ".join(axis.label for axis in axes.values())
            raise InputError(f"{label} does not vary in this sweep", hint=f"its axes are {known}")
        if named.count(name) > 1:
            raise InputError(f"{axes[name].label} is asked for twice", hint="give x, y and at different axes")


def _check_map(
    axes: Mapping[str, Axis], x: str | None, y: str | None, lists: list[str], ranges: list[str]
) -> None:
    """Refuse a discrete axis for a map, and a y without another range to draw across."""
    asked = y if y in lists else x if x in lists and ranges else None
    if asked is not None:
        axis = axes[asked]
        hint = f"for a map give it as a range, {axis.values[0]:.10g}:{axis.values[-1]:.10g}; "
        others = " and ".join(axes[name].label for name in ranges)
        hint += "else leave y out" if asked == y else f"for points over it, hold {others} at a value"
        raise InputError(
            f"{axis.label} is a list of {len(axis)} values, drawn one by one: no axis of a map", hint=hint
        )
    if y is not None and x is None and ranges == [y]:
        raise InputError(f"there is no range beside {axes[y].label} to draw across", hint="leave y out")


def index_of(axis: Axis, value: float) -> int:
    """Find a value of an axis by its number, in the user's units.

    Raises
    ------
    InputError
        If it is not one of its values; the error names the nearest.
    """
    nearest = int(np.argmin(np.abs(axis.values - value)))
    if np.isclose(axis.values[nearest], value, rtol=_SAME, atol=0.0):
        return nearest
    above = int(np.searchsorted(axis.values, value))
    inside = 0 < above < len(axis)
    where = "is none of the values of this axis" if inside else "lies outside of the sweep"
    around = " or ".join(f"{axis.values[i]:.10g}" for i in ([above - 1, above] if inside else [nearest]))
    raise InputError(
        f"{axis.label} = {value:.10g} {axis.unit}".rstrip() + f" {where}",
        hint=f"give the nearest, {around} {axis.unit}".rstrip(),
    )


def _middles(
    axes: Mapping[str, Axis], names: list[str], held: Mapping[str, int], fixed: Mapping[str, float]
) -> dict[str, int]:
    """Hold axes in the middle of those of their values that leave a feasible combination."""
    # The most feasible of all: the most static friction, and the least of everything else.
    best: dict[str, Any] = dict(fixed)
    best |= {name: axis.values[-1 if name == "static_friction" else 0] for name, axis in axes.items()}
    best |= {name: axes[name].values[i] for name, i in held.items()}
    middles = {}
    for name in names:
        values = axes[name].values
        best[name] = values
        static, kinetic = best.get("static_friction", np.inf), best.get("kinetic_friction", 0.0)
        if "friction_ratio" in best:
            kinetic = kinetic_friction(best["friction_ratio"], static)
        feasible = np.flatnonzero(np.broadcast_to(kinetic <= static, values.shape))
        # If all requested combinations are infeasible, the picture shows that.
        middles[name] = int(feasible[len(feasible) // 2]) if feasible.size else len(values) // 2
        best[name] = values[middles[name]]
    return middles


def panels(result: SweepResult, view: View) -> list[list[Panel]]:
    """Cut the drawn part out of a sweep, as views of its arrays where possible.

    Returns
    -------
    list of list of Panel
        For every facet its curves; one where there are no curves.
    """
    curves = range(len(view.curves)) if view.curves else (-1,)
    return [[_panel(result, view, facet, curve) for curve in curves] for facet in view.facet_indices]


def _panel(result: SweepResult, view: View, facet_index: int, curve_index: int) -> Panel:
    others = (view.facet, facet_index), (view.curves, curve_index)
    held = {**view.held, **{axis.name: index for axis, index in others if axis is not None}}
    drawn = [name for name in result.axes if name not in held]

    def cut(values: NDArray[Any]) -> NDArray[Any]:
        # Critical loads do not vary with the frequency and some other axes, and have length 1 along them. The
        # modulus turns any index along those axes into 0.
        sizes = zip(result.axes, values.shape, strict=True)
        index = tuple(held[name] % n if name in held else slice(None) for name, n in sizes)
        part = np.atleast_2d(values[index])
        return part if drawn[-1] == view.x.name else part.T

    values = {**result.fixed, **{name: float(result.axes[name].values[i]) for name, i in held.items()}}
    return Panel(
        view.x,
        view.y,
        values,
        view.facet.name if view.facet else None,
        {name: cut(field) for name, field in result.cycle.arrays().items()},
        {name: cut(getattr(result.limits, name)) for name in _CURVES} if result.limits else {},
        amplitude=None if result.amplitude is None else cut(result.amplitude),
    )
