"""How the cells of a map look: their colours, the marks over these, and the legend."""

from __future__ import annotations

from base64 import b64encode
from typing import TYPE_CHECKING, Any, Final, NamedTuple

import numpy as np

from vibro.core.codes import Regime
from vibro.plots.scales import colours_of
from vibro.plots.style import (
    AVERAGED_LABEL,
    BACKWARDS_LABEL,
    COEXISTS_LABEL,
    INK,
    NO_ANSWER_FACE,
    NO_ANSWER_HATCH,
    REGIME_COLOURS,
)

if TYPE_CHECKING:
    from collections.abc import Mapping

    from numpy.typing import NDArray

    from vibro.plots.scales import Scale
    from vibro.plots.style import CurveStyle

    Mask = NDArray[np.bool_]

__all__ = ["HATCHES", "MARKS", "STRIPES", "Looks", "curve_look", "looks_of"]

# Faces are places in a palette: of regimes their codes, then these, then the colours of the scale.
_NO_ANSWER, _GREY, _FAINT, _INK, _WHITE, _SCALE = range(4, 10)
_COLOURS: Final = 256 - _SCALE  # of a scale: with those before as many as a byte can number
_PLAIN: Final = [
    *(REGIME_COLOURS[Regime(code)] for code in range(4)),
    NO_ANSWER_FACE,
    *("#808080", "#8A8A8A", "#222222", "#FFFFFF"),
]

#: Bits of the marks over a cell, for the page.
MARKS: Final = {
    name: 1 << bit
    for bit, name in enumerate(
        ("backwards", "averaged", "coexists", "preview", "unknown", "unproved", "either", "misses",
         "rising", "falling", "crossed", "level", "grid")
    )
}  # fmt: skip
_HATCHES: Final = {"/": "rising", "\\": "falling", "x": "crossed", "-": "level", "+": "grid"}
#: Marks of statuses without an answer.
HATCHES: Final = {status: _HATCHES[hatch[0]] for status, hatch in NO_ANSWER_HATCH.items()}


def _stripe(right: int, down: int, period: int, to: float, start: float = 0.0) -> dict[str, float]:
    """Return lines of a width, a period [px] apart, across the direction of so much right and down."""
    return {"right": right, "down": down, "period": period, "from": start, "to": to}


def _dots(period: int, size: float) -> list[dict[str, float]]:
    return [_stripe(1, 0, period, size), _stripe(0, 1, period, size)]


#: How the page draws marks over cells, the last on top: the ``marks``, the ``face`` whose colour it takes,
#: or none for the cell's other colour, and the ``stripes``: it is seen where all of them overlap.
STRIPES: Final[list[dict[str, Any]]] = [
    {"marks": sum(MARKS[name] for name in names.split()), "face": face, "stripes": stripes}
    for names, face, stripes in (
        ("either", None, [_stripe(1, 1, 14, 7.0)]),
        ("rising crossed", _FAINT, [_stripe(1, 1, 9, 1.0)]),
        ("falling crossed", _FAINT, [_stripe(1, -1, 9, 1.0)]),
        ("level grid", _FAINT, [_stripe(0, 1, 8, 1.0)]),
        ("grid", _FAINT, [_stripe(1, 0, 8, 1.0)]),
        ("coexists", _FAINT, _dots(7, 1.6)),
        ("unknown unproved", _FAINT, _dots(10, 1.0)),
        ("backwards", _INK, [_stripe(1, 0, 12, 1.0)]),
        ("averaged", _WHITE, [_stripe(1, 1, 24, 2.4)]),
        ("averaged", _FAINT, [_stripe(1, 1, 24, 1.8, 0.6)]),
        ("preview", _WHITE, _dots(5, 1.0)),
    )
]

# Their names in the legend, and the faces on which it shows them.
_NAMES: Final = {
    **{name: (status.label.replace("-", " "), (_NO_ANSWER,)) for status, name in HATCHES.items()},
    "backwards": (BACKWARDS_LABEL, (Regime.NO_SLIP,)),
    "averaged": (AVERAGED_LABEL, (Regime.NO_SLIP,)),
    "coexists": (COEXISTS_LABEL, (Regime.NO_SLIP,)),
    "preview": ("preview, not exact yet", (_GREY,)),
    "unknown": ("not computed yet", (_NO_ANSWER,)),
    "unproved": ("not proved here", (_NO_ANSWER,)),
    "either": (
        "either regime or one between, depending on friction",
        (Regime.FORWARD_SLIP, Regime.BACK_SLIP),
    ),
    "misses": ("slower than the target speed, or hops", (_GREY,)),
}


class Looks(NamedTuple):
    """How cells look.

    Attributes
    ----------
    faces, others : uint8 array
        Colours of cells, and those of the stripes on them where either regime may be: places in the palette.
    marks : uint16 array
        Marks over them, as bits.
    palette : str
        Red, green and blue of each colour, a byte each, in base64.
    scale : tuple of int
        The first place in the palette of the colours of numbers, and how many there are.
    legend : list of dict
        Entries: the ``text``, the ``faces`` of a sample, and the ``marks`` over it.
    """

    faces: NDArray[np.uint8]
    others: NDArray[np.uint8]
    marks: NDArray[np.uint16]
    palette: str
    scale: tuple[int, int]
    legend: list[dict[str, Any]]


def looks_of(
    lowest: NDArray[np.int8],
    highest: NDArray[np.int8],
    shown: tuple[Scale, NDArray[np.float64], Mask] | None,
    marked: Mapping[str, Mask],
    words: Mapping[str, str],
) -> Looks:
    """Choose how cells look.

    Parameters
    ----------
    lowest, highest : int8 array
        The regimes that a body may have there, by code; -1: none. The same where friction is known.
    shown : tuple, optional
        Scale of the numbers, the numbers, NaN where unknown, and whether the colour of rest covers each;
        without it regimes are shown.
    marked : mapping of str to bool array
        Where each of ``MARKS`` applies; reasons for a missing answer only where it is missing.
    words : mapping of str to str
        Names in the legend that differ from the usual ones; ``rest`` names the colour of rest.
    """
    palette = np.array([[int(c[n : n + 2], 16) for n in (1, 3, 5)] for c in _PLAIN], np.uint8)
    if shown is None:
        faces = np.where(lowest >= 0, lowest, _NO_ANSWER)
        marked = {**marked, "either": lowest < highest}
        is_empty = lowest < 0
    else:
        scale, numbers, covered = shown
        palette = np.concatenate([palette, _colours_of(scale)])
        with np.errstate(all="ignore"):
            share = np.ma.filled(scale.norm(np.nan_to_num(numbers, nan=scale.norm.vmin or 0.0)), 0.0)
        faces = _SCALE + np.rint((_COLOURS - 1) * np.clip(share, 0.0, 1.0))
        faces = np.where(np.isnan(numbers), _NO_ANSWER, faces)
        faces = np.where(covered, Regime.NO_SLIP, faces)
        is_empty = np.isnan(numbers) & ~covered
    told_of_numbers = ("averaged", "preview")
    bits = np.zeros(lowest.shape, np.uint16)
    for name, where in marked.items():
        if name in told_of_numbers:
            where = where & (faces >= _SCALE)
        elif name in ("unknown", "unproved", *HATCHES.values()):
            where = where & is_empty
        bits |= np.where(where, np.uint16(MARKS[name]), np.uint16(0))
    # Cells that are not computed yet, or not proved, may still have an answer.
    open_bits = MARKS["unknown"] | MARKS["unproved"]
    hatches = sum(MARKS[name] for name in HATCHES.values())
    bits = np.where(bits & open_bits, bits & ~np.uint16(hatches), bits)
    others = np.where(highest >= 0, highest, _NO_ANSWER).astype(np.uint8)
    faces = faces.astype(np.uint8)
    return Looks(
        faces,
        others,
        bits,
        b64encode(palette.tobytes()).decode(),
        (_SCALE, _COLOURS),
        _legend(faces, others, bits, words),
    )


def _legend(
    faces: NDArray[np.uint8], others: NDArray[np.uint8], bits: NDArray[np.uint16], words: Mapping[str, str]
) -> list[dict[str, Any]]:
    seen = {*np.unique(faces), *np.unique(others[(bits & MARKS["either"]) > 0])}
    called = {Regime.NO_SLIP: words.get("rest", Regime.NO_SLIP.label)}
    regimes = [
        {"text": called.get(r, r.label), "faces": [int(r)], "marks": 0} for r in Regime if int(r) in seen
    ]
    found = int(np.bitwise_or.reduce(bits, axis=None))
    return regimes + [
        {"text": words.get(name, text), "faces": [int(face) for face in sample], "marks": MARKS[name]}
        for name, (text, sample) in _NAMES.items()
        if found & MARKS[name]
    ]


def _colours_of(scale: Scale) -> NDArray[np.uint8]:
    colours = colours_of(scale.colours)(np.linspace(0.0, 1.0, _COLOURS), bytes=True)
    return np.asarray(colours[:, :3])


def curve_look(
    name: str, style: CurveStyle, lines: list[NDArray[np.float64]], *, on_numbers: bool
) -> dict[str, Any]:
    """Describe a curve; on numbers a halo parts it from their colours."""
    return {
        "name": name,
        "label": style.label,
        "dash": _dashes_of(style),
        "width": style.width,
        "colour": style.colour,
        "halo": INK if style.colour != INK else "#FFFFFF" if on_numbers else "",
        "count": sum(len(line) + 1 for line in lines),
    }


def _dashes_of(style: CurveStyle) -> list[float]:
    """Return the lengths of dashes and gaps [px]; none of a line without."""
    return [] if isinstance(style.dashes, str) else [length * style.width for length in style.dashes[1]]
