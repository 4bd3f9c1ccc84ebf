"""The options of ``vibro map`` about its pictures: their kinds, and their axes."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from vibro.core.codes import Output
from vibro.errors import InputError, cut, shown

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping

    from vibro.axes import Axis
    from vibro.cli.console import Console
    from vibro.plots.view import View
    from vibro.sweeps.grid import Grid

#: Pictures on request.
SHOWN: Final = ("impact", "flight")


def view_of(grid: Grid, x: str | None, y: str | None, at: list[str]) -> tuple[View, dict[str, float]]:
    """Choose what the pictures of a sweep show; return the axes that are held on request, too."""
    from vibro.plots.view import choose_view

    axes = grid.told_axes
    held = grid.told(held_axes(at, axes))
    return choose_view(axes, x and axis_name(x), y and axis_name(y), held, grid.told(grid.fixed)), held


def names_of(view: View, grid: Grid, shown: list[str]) -> list[str]:
    """Name the pictures of a sweep, with those that are asked for."""
    from vibro.plots import picture_names

    names = picture_names(view, has_length=grid.length is not None, on_request=False) + shown
    return names if grid.output is Output.EXACT else [name for name in names if name == "regime"]


def tell_choices(view: View, axes: Mapping[str, Axis], asked: Mapping[str, float], console: Console) -> None:
    """Print which values the pictures show, for axes that they do not show whole."""
    from vibro.plots.view import value_of
    from vibro.quantities import QUANTITIES

    for name, index in view.held.items():
        if name not in asked:
            at = f"--at {QUANTITIES[name].letter}=VALUE"
            console.echo(f"pictures: {axes[name].label} held at {value_of(axes[name], index)}; {at} chooses")
    facet, shown = view.facet, len(view.facet_indices)
    if facet is not None and len(facet) > shown:
        at = f"--at {QUANTITIES[facet.name].letter}=VALUE"
        console.echo(f"pictures: {facet.label} at {shown} of its {len(facet)} values; {at} chooses one")


def shown_pictures(texts: list[str]) -> list[str]:
    """Check the names of the additional pictures."""
    names = list(dict.fromkeys(name.strip().casefold() for text in texts for name in text.split(",")))
    for name in names:
        if name not in SHOWN:
            raise InputError(
                f"--show {cut(name)}: there is no such picture", hint=f"there are {', '.join(SHOWN)}"
            )
    return names


def axis_name(text: str) -> str:
    """Return the name of the quantity that a user calls an axis."""
    from vibro.quantities import find_quantity

    quantity = find_quantity(text)
    return quantity.name if quantity else text


def held_axes(texts: list[str], varying: Iterable[str]) -> dict[str, float]:
    """Read at which values axes are held, such as ``mu_s=0.6``; those that vary are for the hint."""
    from vibro.quantities import QUANTITIES, exact_number, find_quantity

    held: dict[str, float] = {}
    for text in (part for given in texts for part in given.split(",")):
        name, equals, value = text.partition("=")
        if not equals:
            raise InputError(
                f"--at {cut(text)}: not of the form AXIS=VALUE", hint="write it like --at mu_s=0.6"
            )
        quantity = find_quantity(name)
        if quantity is None:
            raise InputError(
                f"--at {cut(text)}: {shown(name)} is no axis",
                hint=f"the axes are {', '.join(varying)}",
            )
        number = float(exact_number(value, quantity))
        if quantity.name == "stroke":
            quantity, number = QUANTITIES["amplitude"], 0.5 * number
        if quantity.name in held:
            raise InputError(f"--at: {quantity.label} is given twice", hint="give it once")
        held[quantity.name] = number
    return held
