"""Codes of the patterns of cycles with any number of slides."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np

from vibro.core.codes import SPELT_PATTERNS, Mode, Pattern

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from vibro.core.harmonic.cycle import Cycles

__all__ = ["spelt"]

# Patterns that have a code of their own, by their digits.
_NAMED: Final = {
    Mode.FORWARD * 5 + Mode.REST: Pattern.F_,
    Mode.BACK * 5 + Mode.REST: Pattern.B_,
    ((Mode.FORWARD * 5 + Mode.REST) * 5 + Mode.BACK) * 5 + Mode.REST: Pattern.F_B_,
    (Mode.FORWARD * 5 + Mode.BACK) * 5 + Mode.REST: Pattern.FB_,
    (Mode.FORWARD * 5 + Mode.REST) * 5 + Mode.BACK: Pattern.F_B,
    Mode.FORWARD * 5 + Mode.BACK: Pattern.FB,
}


def spelt(cycles: Cycles, scenes: int) -> tuple[NDArray[np.int64], NDArray[np.intp]]:
    """Codes of the patterns of cycles with slides, and the row of the slide with which each begins.

    Of all rotations of the legs a pattern is the first one in the order F, B, rest, letter by letter, which
    is that of the least digits. So it begins with a forward slide if there is one, with one that another
    slide follows if there is such, and so on: ``F_B``, not ``BF_``.

    Parameters
    ----------
    cycles : Cycles
        With a slide each.
    scenes : int
        Number of scenes in the ``Lanes`` that the cycles are about.
    """
    rows, n = cycles.lane.shape
    slides = np.arange(rows)[:, np.newaxis] < cycles.size
    # one slide with the rest after it, and by how much it shifts the digits before it
    digits = np.where(cycles.lane < scenes, np.int64(Mode.FORWARD), np.int64(Mode.BACK))
    digits = np.where(cycles.rests, 5 * digits + Mode.REST, digits) * slides
    shift = np.where(slides, np.where(cycles.rests, 25, 5), 1)
    # turned by one slide, the first one goes from the front to the end
    before = np.ones(n, np.int64)
    code = np.zeros(n, np.int64)
    for j in range(rows):
        code = code * shift[j] + digits[j]
        before *= shift[j]
    least, first = code.copy(), np.zeros(n, np.intp)
    for j in range(rows - 1):
        code = (code - digits[j] * (before // shift[j])) * shift[j] + digits[j]
        better = (code < least) & slides[j + 1]
        np.copyto(least, code, where=better)
        np.copyto(first, j + 1, where=better)
    out = least + SPELT_PATTERNS
    for spelling, pattern in _NAMED.items():
        np.copyto(out, np.int64(pattern), where=least == spelling)
    return out, first
