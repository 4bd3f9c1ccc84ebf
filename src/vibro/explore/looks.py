"""How the page looks: colours of cells, the marks over these, curves, panels of the motion."""

from __future__ import annotations

from base64 import b64encode
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from vibro.core.codes import PHASE_NAMES, Regime
from vibro.plots.history import ELLIPSE, PANELS, PHASE_COLOURS
from vibro.plots.scales import colours_of
from vibro.plots.style import (
    AVERAGED_LABEL,
    BACKWARDS_LABEL,
    COEXISTS_LABEL,
    CURVES,
    INK,
    NO_ANSWER_FACE,
    NO_ANSWER_HATCH,
    REGIME_COLOURS,
    WANTED,
    ZERO_SPEED,
)

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from vibro.plots.history import Panel
    from vibro.plots.style import CurveStyle

# Faces are places in a palette: of regimes their codes, then these, then the colours of a scale.
_NO_ANSWER, _GREY, _FAINT, _INK, _WHITE, _SCALE = range(4, 10)
_COLOURS: Final = 256 - _SCALE  # of a scale: with those before as many as a byte can number
_PLAIN: Final = [
    *(REGIME_COLOURS[Regime(code)] for code in range(4)),
    NO_ANSWER_FACE,
    *("#808080", "#8A8A8A", "#222222", "#FFFFFF"),
]
_SCALES: Final = ("cividis", "cividis_r", "RdBu")

#: Bits of the marks over a cell.
MARKS: Final = {
    name: 1 << bit
    for bit, name in enumerate(
        ("backwards", "averaged", "coexists", "preview", "sampled", "either", "misses",
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


#: How marks lie over cells, the last on top: the ``marks``, the ``face`` whose colour they take, or none
#: for the cell's other colour, and the ``stripes``: it is seen where all of them overlap.
STRIPES: Final[list[dict[str, Any]]] = [
    {"marks": sum(MARKS[name] for name in names.split()), "face": face, "stripes": stripes}
    for names, face, stripes in (
        ("either", None, [_stripe(1, 1, 14, 7.0)]),
        ("rising crossed", _FAINT, [_stripe(1, 1, 9, 1.0)]),
        ("falling crossed", _FAINT, [_stripe(1, -1, 9, 1.0)]),
        ("level grid", _FAINT, [_stripe(0, 1, 8, 1.0)]),
        ("grid", _FAINT, [_stripe(1, 0, 8, 1.0)]),
        ("coexists", _FAINT, _dots(7, 1.6)),
        ("sampled", _FAINT, [_stripe(1, -1, 16, 1.0)]),
        ("backwards", _INK, [_stripe(1, 0, 12, 1.0)]),
        ("averaged", _WHITE, [_stripe(1, 1, 24, 2.4)]),
        ("averaged", _FAINT, [_stripe(1, 1, 24, 1.8, 0.6)]),
        ("preview", _WHITE, _dots(5, 1.0)),
    )
]

# Names of marks in the legend, and the faces on which it shows them.
_NAMES: Final = {
    **{name: (status.label.replace("-", " "), [_NO_ANSWER]) for status, name in HATCHES.items()},
    "backwards": (BACKWARDS_LABEL, [int(Regime.NO_SLIP)]),
    "averaged": (AVERAGED_LABEL, [int(Regime.NO_SLIP)]),
    "coexists": (COEXISTS_LABEL, [int(Regime.NO_SLIP)]),
    "preview": ("not solved yet: a neighbour's", [_GREY]),
    "sampled": ("sampled: the least of a few bodies", [int(Regime.NO_SLIP)]),
    "either": (
        "either regime or one between, depending on friction",
        [int(Regime.FORWARD_SLIP), int(Regime.BACK_SLIP)],
    ),
    "misses": ("slower than the target speed, or hops", [_GREY]),
}


def looks() -> dict[str, Any]:
    """Return how the page looks, as JSON values.

    Returns
    -------
    dict
        ``palettes``: ``plain``, the colours of regimes by code and those after them, and those of each scale,
        red, green and blue a byte each, in base64; ``scale``, the first place of a scale's colours and how
        many there are; ``faces``, the place of cells without an answer; ``marks``, ``stripes``, ``legend``,
        each mark's ``text`` and ``faces``; ``curves`` and ``panels`` by name, with lengths in px; ``phases``.
    """
    plain = np.array([[int(c[n : n + 2], 16) for n in (1, 3, 5)] for c in _PLAIN], np.uint8)
    curves = {**CURVES, "zero_speed": ZERO_SPEED, "wanted": WANTED}
    return {
        "palettes": {"plain": _bytes(plain)} | {name: _bytes(_scale_colours(name)) for name in _SCALES},
        "scale": [_SCALE, _COLOURS],
        "faces": {"no_answer": _NO_ANSWER},
        "marks": MARKS,
        "stripes": STRIPES,
        "legend": {name: {"text": text, "faces": faces} for name, (text, faces) in _NAMES.items()},
        "curves": {name: _curve(style) for name, style in curves.items()},
        "panels": {name: _panel(panel) for name, panel in {**PANELS, "ellipse": ELLIPSE}.items()},
        "phases": {kind: {"name": PHASE_NAMES[kind], "colour": c} for kind, c in PHASE_COLOURS.items()},
    }


def _bytes(colours: NDArray[np.uint8]) -> str:
    return b64encode(colours.tobytes()).decode()


def _scale_colours(name: str) -> NDArray[np.uint8]:
    return np.asarray(colours_of(name)(np.linspace(0.0, 1.0, _COLOURS), bytes=True)[:, :3])


def _curve(style: CurveStyle) -> dict[str, Any]:
    """Describe a curve; on numbers a ``halo`` parts it from their colours."""
    dash = [] if isinstance(style.dashes, str) else [length * style.width for length in style.dashes[1]]
    halo = INK if style.colour != INK else "#FFFFFF"
    return {"label": style.label, "colour": style.colour, "width": style.width, "dash": dash, "halo": halo}


def _panel(panel: Panel) -> dict[str, Any]:
    """Describe a panel of a history: values in SI units times ``per_si`` are in its unit."""
    named = ("field", "label", "colour", "width", "in_contact")
    curves = [
        {name: getattr(curve, name) for name in named}
        | {"dash": [] if curve.dashes == "-" else curve.dashes[1]}
        for curve in panel.curves
    ]
    title, per_si = panel.label.replace("\n", " "), 1.0 / panel.size
    return {"title": title, "unit": panel.unit, "per_si": per_si, "height": panel.height, "curves": curves}
