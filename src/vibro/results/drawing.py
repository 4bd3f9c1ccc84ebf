"""How results are drawn. That is known in rooms above them: the package says where, when it is imported."""

from __future__ import annotations

TYPE_CHECKING = False  # typing takes time in which a run could not be interrupted properly
if TYPE_CHECKING:
    from collections.abc import Callable
    from typing import Any

    from matplotlib.figure import Figure

    #: Draws a result, with the arguments of its method ``draw``.
    Drawing = Callable[..., Figure]

#: Endings of the files of pictures.
PICTURES = ("png", "svg", "pdf")

_found: list[Callable[[str], Drawing]] = []


def drawings_are_found_by(find: Callable[[str], Drawing]) -> None:
    """Say how the function that draws a kind of result is found, by the name of its class."""
    _found[:] = [find]


def drawn(result: object, *args: Any, **options: Any) -> Figure:
    """Draw a result."""
    (find,) = _found
    return find(type(result).__name__)(result, *args, **options)
