"""Texts of patterns that have more letters than a code has room for.

The solver marks them: marks are equal where two bodies have the same legs from the same phase on. One cell of
each mark is followed once more to spell them, and its mark gives way to the code of the text, which is the
same from whatever phase the legs are counted.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np

from vibro.core.codes import IRREGULAR, LETTERS, Mode, spelt_code
from vibro.core.compiled import doors
from vibro.solver import Scratch, over_cells

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from vibro.solver import Grid

__all__ = ["spell_long", "turned"]

_ROOM: Final = 512  # [letter] for a first try; 16 harmonics alone have up to 64 in contact
_SPELT: Final = 16  # [cell] of a range; each takes up to some ms


def spell_long(
    grid: Grid, codes: NDArray[np.int64], *, one_harmonic: bool, threads: int | None
) -> dict[int, str]:
    """Replace marks of long patterns by their codes.

    Parameters
    ----------
    grid : Grid
        The cells.
    codes : int array
        Codes of their patterns, as the solver leaves them; changed in place.
    one_harmonic : bool
        Whether the drives have one harmonic: then all cycles with so many legs begin at their first flight.
    threads : int, optional
        As for ``vibro.solve``.

    Returns
    -------
    dict of int to str
        Texts of long patterns by their codes.
    """
    marked = (codes < IRREGULAR).nonzero()[0]
    if not marked.size:
        return {}
    _, first, which = np.unique(codes[marked], return_index=True, return_inverse=True)
    cells, texts, scratch = marked[first].tolist(), [""] * first.size, Scratch()

    def spell(begin: int, end: int) -> None:
        for i in range(begin, end):
            legs = _legs(grid, cells[i], scratch)
            texts[i] = "".join(LETTERS[mode] for mode in (legs if one_harmonic else turned(legs)))

    over_cells(spell, len(cells), _SPELT, threads, cost=grid.cost)
    found = {text: spelt_code(text) for text in texts}
    codes[marked] = np.array([found[text] for text in texts])[which]
    return {code: text for text, code in found.items() if code < IRREGULAR}


def _legs(grid: Grid, cell: int, scratch: Scratch) -> bytes:
    """Follow the steady cycle of a cell once more; return the ``Mode`` of every leg."""
    legs, number = np.empty(0, np.int8), _ROOM
    while number > legs.size:
        legs = np.empty(number, np.int8)
        number = doors().write_letters(
            grid.scenes, grid.place(), cell, scratch.flights, scratch.hops, legs, legs.size
        )
    return legs[:number].tobytes()


def turned(legs: bytes) -> bytes:
    """Turn the legs of a cycle as ``canonical`` turns the digits of short ones."""
    if len(legs) < 2:
        return legs
    if legs[0] == legs[-1] != Mode.FLIGHT:
        legs = legs[:-1]
    return min(legs[i:] + legs[:i] for i in range(len(legs)))
