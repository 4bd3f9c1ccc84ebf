"""The options of ``vibro map`` about its pictures: their kinds, and their axes."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from vibro.errors import InputError, cut

if TYPE_CHECKING:
    from collections.abc import Mapping

    from vibro.axes import Axis
    from vibro.cli.console import Console
    from vibro.plots.view import View

#: Pictures on request.
SHOWN: Final = ("impact", "flight")


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


def held_axes(texts: list[str]) -> list[tuple[str, str]]:
    """Read at which values axes are held, such as ``mu_s=0.6``."""
    held = [text.partition("=") for given in texts for text in given.split(",")]
    for name, equals, _ in held:
        if not equals:
            raise InputError(
                f"--at {cut(name)}: not of the form AXIS=VALUE", hint="write it like --at mu_s=0.6"
            )
    return [(name, value) for name, _, value in held]
