"""How pictures look: colours, hatches, lines and words, the same in every one."""

from __future__ import annotations

import re
import threading
import unicodedata
from bisect import bisect_right
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any, Final, NamedTuple

from vibro.core.codes import Regime, Status
from vibro.quantities import QUANTITIES, TOLD_HARMONICS, counted_harmonics

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping

    from vibro.axes import Axis

# From Tol's medium-contrast palette, which is safe for the colour-blind. Printed in grey, the colours have
# CIE lightness 100, 83, 62 and 41.
REGIME_COLOURS: Final[Mapping[Regime, str]] = {
    Regime.NO_SLIP: "#FFFFFF",
    Regime.BACK_SLIP: "#EECC66",
    Regime.FORWARD_SLIP: "#6699CC",
    Regime.HOPPING: "#994455",
}
INK: Final = "#222222"

NO_ANSWER_FACE: Final = "#E9E9E9"
NO_ANSWER_INK: Final = "#8A8A8A"
NO_ANSWER_HATCH: Final[Mapping[Status, str]] = {
    Status.INFEASIBLE: "////",
    Status.FLIGHT_NOT_MODELLED: "\\\\\\\\",
    Status.RUNAWAY: "xxx",
    Status.INDETERMINATE: "---",
    Status.UNRESOLVED: "+++",
}
BACKWARDS_FACE: Final = "#F4A582"  # for bodies without a number: a colour of speeds below 0
BACKWARDS_LABEL: Final = "moves backwards"
COEXISTS_LABEL: Final = "another motion exists"
AVERAGED_LABEL: Final = "irregular motion: mean over many flights"
#: Hatches over colours, by their names.
OVER: Final[Mapping[str, Mapping[str, Any]]] = {
    label: {"facecolor": "none", "hatch": hatch, "edgecolor": ink}
    for label, hatch, ink in (
        (BACKWARDS_LABEL, "|", INK),
        (COEXISTS_LABEL, "...", NO_ANSWER_INK),
        (AVERAGED_LABEL, "/", NO_ANSWER_INK),
    )
}
ERROR_LABEL: Final = "standard error of this mean"

# Dashes, each with one meaning all over the pictures.
_FORWARD: Final = (0, (7, 2, 1.5, 2))
_BACK: Final = (0, (5, 2))
_CONTINUOUS: Final = (0, (1, 1.6))
_WANTED: Final = (0, (11, 2))
#: What the last part of a batch does; the first part has the dashes of the curve itself.
LAST_PART: Final = (0, (1.5, 3.5))
TIPPING: Final = (0, (3, 1, 1, 1, 1, 1))
#: Limits of a drive, or of static friction.
LIMITS: Final = (0, (3, 1.2))
#: The second of two alike: a full trough beside an empty one, the motion normal to a trough.
SECOND: Final = (0, (6, 1.5, 1, 1.5))
#: Values of a list, in turn.
IN_TURN: Final[tuple[Any, ...]] = ("-", (0, (8, 1.2)), (0, (2, 0.8)), (0, (4, 1, 2, 1)))


class CurveStyle(NamedTuple):
    """The name of a critical curve, and how it is drawn."""

    label: str
    dashes: Any
    width: float
    colour: str = INK


# Keys are the fields of CriticalLoads, in the order in which the usual scene passes them as the load rises.
CURVES: Final[Mapping[str, CurveStyle]] = {
    "forward_onset": CurveStyle("forward-slip onset", _FORWARD, 1.4),
    "back_slip": CurveStyle("back-slip onset", _BACK, 1.4),
    "continuous_sliding": CurveStyle("continuous sliding", _CONTINUOUS, 1.4),
    "hop": CurveStyle("hop limit", "-", 1.8),
}

ZERO_SPEED: Final = CurveStyle("zero speed", "-", 1.6, "#FFFFFF")
#: A speed or an error that is asked for; its label says which.
WANTED: Final = CurveStyle("", _WANTED, 2.2, "#CC3311")

_HALO: Final = 2.4  # [pt]
_DPI: Final = 150
_FONT: Final = "DejaVu Sans"  # comes with matplotlib
_RC: Final[Any] = {
    "font.family": "sans-serif",
    "font.sans-serif": [_FONT],
    "font.size": 9.0,
    "axes.titlesize": 9.0,
    "axes.labelsize": 9.5,
    "axes.edgecolor": INK,
    "axes.linewidth": 0.8,
    "xtick.direction": "out",
    "ytick.direction": "out",
    "hatch.linewidth": 0.6,
    # Numbers along axes are written in full, without an offset or a common factor.
    "axes.formatter.useoffset": False,
    "axes.formatter.limits": (-99, 99),
    "legend.fontsize": 8.5,
    "legend.frameon": False,
    "mathtext.fontset": "dejavusans",
    "svg.fonttype": "path",
    "svg.hashsalt": "vibro",  # makes files reproducible
    "figure.dpi": _DPI,
    "savefig.dpi": _DPI,
}

# Categories of characters that are hidden, break lines, turn the direction, or are unassigned. Two of them
# belong to the spelling of Persian and of Indian languages.
_HIDING: Final = frozenset({"Cc", "Cf", "Cn", "Cs", "Zl", "Zp"})
_JOINERS: Final = "\N{ZERO WIDTH JOINER}\N{ZERO WIDTH NON-JOINER}"
_HIDDEN: Final = "\N{REPLACEMENT CHARACTER}"
_NO_GLYPH: Final = "\N{WHITE SQUARE}"

UNIT_SIGNS: Final = {"deg": "°", "m/s^2": "m/s²"}
_COMMAND: Final = re.compile(r"\\[a-z]+")
_MARKUP: Final = re.compile(r"[${}_]")
_LETTER: Final = 0.56  # width of a letter of a formula, over the size of the type
_EVEN_LUMINANCE: Final = 0.2  # relative luminance of a colour on which INK and white are about as legible


#: Held by the thread that draws or saves: matplotlib has one set of settings, and one parser of formulas.
DRAWING: Final = threading.RLock()


@contextmanager
def house_style() -> Iterator[None]:
    """Draw or save in this style over matplotlib's own defaults: the same on every machine.

    One thread does so at a time. A user's configuration (matplotlibrc, style sheets) does not change.
    """
    import matplotlib as mpl

    with DRAWING:
        # The context restores every setting but the backend, which no figure here needs.
        defaults: Any = {key: value for key, value in mpl.rcParamsDefault.items() if key != "backend"}
        with mpl.rc_context({**defaults, **_RC}):
            yield


def visible(text: str) -> str:
    """Replace hidden characters in a user's text, such as controls and halves of undecodable names."""
    return "".join(c if c in _JOINERS or unicodedata.category(c) not in _HIDING else _HIDDEN for c in text)


def figure_text(text: str, size: float, room: float) -> str:
    """Turn a user's text, such as the name of a file, into words on one line of a figure.

    Parameters
    ----------
    text : str
        Anything; none of it is markup.
    size : float
        Of the type [pt].
    room : float
        Width that the words may have [pt].

    Returns
    -------
    str
        For matplotlib, with dollars escaped. Hiding characters show as a replacement sign, those that the
        font lacks as a box, and the middle of what is too long as an ellipsis.
    """
    from matplotlib.font_manager import FontProperties, findfont, get_font

    font = get_font(findfont(FontProperties(family=_FONT)))
    font.set_size(size, _DPI)

    words = "".join(c if font.get_char_index(ord(c)) else _NO_GLYPH for c in visible(text))

    def width(line: str) -> float:
        font.set_text(line)
        return float(font.get_width_height()[0] / 64.0 * 72.0 / _DPI)

    def shortened(kept: int) -> str:
        return f"{words[: (kept + 1) // 2]}…{words[len(words) - kept // 2 :]}"

    if width(words) > room:
        kept = bisect_right(range(len(words)), room, key=lambda kept: width(shortened(kept))) - 1
        words = shortened(kept)
    return words.replace("$", r"\$")


def axis_label(axis: Axis) -> str:
    """Name, symbol and unit of an axis: ``frequency f [Hz]``."""
    unit = f" [{UNIT_SIGNS.get(axis.unit, axis.unit)}]" if axis.unit else ""
    return f"{axis.label} ${QUANTITIES[axis.name].symbol}${unit}"


def no_answer(status: Status) -> tuple[str, dict[str, Any]]:
    """Return the name of a status without an answer, and the look of an area that has it."""
    look = {"facecolor": NO_ANSWER_FACE, "edgecolor": NO_ANSWER_INK, "hatch": NO_ANSWER_HATCH[status]}
    return status.label.replace("-", " "), look


def number_text(value: float) -> str:
    """Write a number with five digits and a proper minus."""
    return f"{value:.5g}".replace("-", "\N{MINUS SIGN}")


def value_text(name: str, value: float) -> str:
    """Write a value of a quantity with its unit."""
    unit = QUANTITIES[name].unit
    sign = UNIT_SIGNS.get(unit, unit)
    return number_text(value) + ("" if sign in ("°", "") else " ") + sign


def values_text(values: Mapping[str, float], *, all_of_them: bool = False, hops: bool = False) -> str:
    """Write quantities in the user's units, in the order of tables: ``α = 20°, f = 15 Hz``.

    Quantities with their usual value are left out unless ``all_of_them``, and so are harmonics from the
    third on, which are counted. Restitution is never left out where bodies hop.
    """
    parts = [
        f"${quantity.symbol}$ = {value_text(name, values[name])}"
        for name, quantity in QUANTITIES.items()
        if name in values
        if all_of_them or quantity.default != values[name] or (hops and name == "restitution")
        if quantity.order <= TOLD_HARMONICS or all_of_them
    ]
    return ", ".join([*parts, *counted_harmonics(values)])


def broken_lines(text: str, size: float, room: float) -> str:
    """Break a list of formulas after its commas, into lines of about the width that they may have [pt]."""
    lines = [""]
    for part in text.split(", "):
        longer = f"{lines[-1]}, {part}" if lines[-1] else part
        letters = len(_MARKUP.sub("", _COMMAND.sub("x", longer)))
        if lines[-1] and letters * _LETTER * size > room:
            lines[-1] += ","
            lines.append(part)
        else:
            lines[-1] = longer
    return "\n".join(lines)


def spans_text(spans: Mapping[str, tuple[float, float]]) -> str:
    """Write bands of quantities, given in SI units, in the user's units: ``f = 15 Hz, μ_s = 0.3 ... 0.5``."""
    parts = []
    for name, quantity in QUANTITIES.items():
        if name in spans:
            low, high = (quantity.from_si(end) for end in spans[name])
            text = value_text(name, high)
            parts.append(
                f"${quantity.symbol}$ = " + (f"{number_text(low)} ... {text}" if low < high else text)
            )
    return ", ".join(parts)


def ink_on(colour: Any) -> str:
    """Return INK or white, whichever is more legible on a colour."""
    from matplotlib.colors import to_rgb

    linear = [c / 12.92 if c <= 0.04045 else ((c + 0.055) / 1.055) ** 2.4 for c in to_rgb(colour)]
    luminance = 0.2126 * linear[0] + 0.7152 * linear[1] + 0.0722 * linear[2]
    return INK if luminance > _EVEN_LUMINANCE else "#FFFFFF"


def outline(artist: Any, halo: Any) -> None:
    """Outline words in a colour, so that they stand out from the background; None leaves them."""
    if halo is not None:
        from matplotlib.patheffects import withStroke

        artist.set_path_effects([withStroke(linewidth=_HALO, foreground=halo)])
