"""Small integer codes of the results: regime, status, pattern and model of each cell, and their texts."""

from __future__ import annotations

from enum import IntEnum, StrEnum
from typing import TYPE_CHECKING, Final

if TYPE_CHECKING:
    from collections.abc import Mapping

    import numpy as np
    from numpy.typing import NDArray


class Output(StrEnum):
    """What is computed of every cell: all results, or its regime, ratios and status only."""

    EXACT = "exact"
    REGIMES = "regimes"


class Regime(IntEnum):
    """Class of the steady motion of a body on the trough; the integer codes of ``SteadyCycle.regime``.

    ``NO_SLIP``: it rests. ``FORWARD_SLIP``: it slides, never backwards. ``BACK_SLIP``: it slides backwards at
    some time of the cycle. ``HOPPING``: the throw number exceeds 1. ``UNDEFINED`` (-1): the status says why
    there is no regime.
    """

    UNDEFINED = -1  # the cell has no regime: see its status
    NO_SLIP = 0
    FORWARD_SLIP = 1  # slides, never backwards
    BACK_SLIP = 2  # any back slide in the steady cycle
    HOPPING = 3  # throw number above 1

    @property
    def label(self) -> str:
        """Name of the regime in tables and pictures, such as ``forward-slip``; empty for ``UNDEFINED``."""
        return "" if self is Regime.UNDEFINED else self.name.lower().replace("_", "-")


class Status(IntEnum):
    """Whether a cell has numbers and of what kind, or why it has none; codes of ``SteadyCycle.status``.

    ``OK``, ``BOUNDARY`` (within rounding of a threshold) and ``AVERAGED`` (mean of irregular motion) have
    numbers; ``RUNAWAY``, ``INDETERMINATE``, ``FLIGHT_NOT_MODELLED``, ``INFEASIBLE`` and ``UNRESOLVED`` have
    none. ``message`` explains each.

    Examples
    --------
    >>> Status(2).label, Status(2).answered
    ('runaway', False)
    """

    OK = 0
    BOUNDARY = 1
    RUNAWAY = 2
    INDETERMINATE = 3
    FLIGHT_NOT_MODELLED = 4
    INFEASIBLE = 5
    UNRESOLVED = 6
    AVERAGED = 7

    @property
    def label(self) -> str:
        """Name of the status in tables, such as ``flight-not-modelled``."""
        return self.name.lower().replace("_", "-")

    @property
    def message(self) -> str:
        """One sentence that explains the status."""
        return _STATUS_MESSAGES[self]

    @property
    def answered(self) -> bool:
        """Whether a cell with this status has numbers."""
        return self in (Status.OK, Status.BOUNDARY, Status.AVERAGED)


_STATUS_MESSAGES: Final = {
    Status.OK: "solved to rounding",
    Status.BOUNDARY: "within rounding of a threshold: solved as at the threshold itself (rest, contact)",
    Status.RUNAWAY: "the body never comes to rest and gains speed every cycle: no steady cycle exists",
    Status.INDETERMINATE: "without static friction the steady motion depends on the start of the body",
    Status.FLIGHT_NOT_MODELLED: "the body leaves the trough; its flight is not modelled",
    Status.INFEASIBLE: "impossible combination: mu_d > mu_s, or a machine whose masses strike",
    Status.AVERAGED: "irregular motion: mean over many flights, with its standard error",
    Status.UNRESOLVED: "the solver could not prove its answer; please report the scene",
}


def is_answered(status: NDArray[np.int8]) -> NDArray[np.bool_]:
    """Whether cells have numbers, by the codes of their statuses."""
    import numpy as np  # late: the enums are needed where loading NumPy would take too long

    return np.array([code.answered for code in Status])[status]


class Pattern(IntEnum):
    """Legs of one steady cycle: F forward slide, B back slide, R rest (written ``_``)."""

    NONE = 0
    R = 1
    F_ = 2
    B_ = 3
    F_B_ = 4
    FB_ = 5
    F_B = 6
    FB = 7


PATTERNS: Final = ("", "_", "F_", "B_", "F_B_", "FB_", "F_B", "FB")


class Mode(IntEnum):
    """What a body does during one leg; the values are the digits of a code that spells a pattern."""

    FLIGHT = 1
    FORWARD = 2
    BACK = 3
    REST = 4


LETTERS: Final = " HFB_"  # by Mode

#: What the letters stand for; ``"h"`` stands for several very short flights, one after the other.
PHASE_NAMES: Final = {
    "H": "flight",
    "h": "short flights",
    "F": "forward slide",
    "B": "back slide",
    "_": "rest",
}

#: Legs of a pattern that an int64 has room for, as digits to base 5.
MOST_LETTERS: Final = 27

#: [code] The patterns of contact cycles that drives of one harmonic have are those of ``Pattern``; from here
#: on up a code spells its legs, as those of hopping cycles do. Codes below ``IRREGULAR`` stand for longer
#: patterns, whose texts are kept beside the codes.
SPELT_PATTERNS: Final = 8

#: [code] Of a body that hops without a period; its text is ``H...``.
IRREGULAR: Final = -1


def spelt_text(digits: int) -> str:
    """Legs of a cycle from digits to base 5: H flight, F forward slide, B back slide, _ rest."""
    letters = ""
    for _ in range(MOST_LETTERS):
        if not digits:
            break
        digits, digit = divmod(digits, 5)
        letters = LETTERS[digit] + letters
    return letters


def spelt_code(text: str) -> int:
    """Code of a pattern that is none of ``Pattern``; of one of more than ``MOST_LETTERS`` legs a digest."""
    if len(text) > MOST_LETTERS:
        from hashlib import blake2b  # late: seldom needed

        digest = blake2b(text.encode(), digest_size=8).digest()
        return IRREGULAR - 1 - (int.from_bytes(digest) >> 2)  # within the negative half of an int64
    digits = 0
    for letter in text:
        digits = 5 * digits + LETTERS.index(letter)
    return SPELT_PATTERNS + digits


def pattern_texts(codes: NDArray[np.int64], long_patterns: Mapping[int, str]) -> NDArray[np.object_]:
    """Legs of steady cycles as text, from the codes of their patterns and the texts of long ones.

    Raises
    ------
    KeyError
        If the text of a long pattern is not known.
    """
    import numpy as np  # late, as above

    different, which = np.unique(codes.ravel(), return_inverse=True)
    texts = [
        "H..." if code == IRREGULAR
        else long_patterns[code] if code < 0
        else PATTERNS[code] if code < SPELT_PATTERNS
        else spelt_text(code - SPELT_PATTERNS)
        for code in different.tolist()
    ]  # fmt: skip
    return np.array(texts, dtype=object)[which].reshape(codes.shape)


class Model(IntEnum):
    """The cheapest exact model that a cell's answer came from."""

    NONE = 0
    REST = 1  # thresholds alone
    ONE_SLIDE = 2
    TWO_SLIDES = 3
    CLOSED_FORM = 4  # continuous sliding
    FLIGHT = 5
    SLIDES = 6  # as many as two a harmonic, of a drive that has several


MODELS: Final = ("", "rest", "one-slide", "two-slides", "closed-form", "flight", "slides")
