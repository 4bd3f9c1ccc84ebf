"""How pictures look: colours, hatches, lines and words, the same in every one."""

from __future__ import annotations

import textwrap
import threading
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any, Final, NamedTuple

import numpy as np

from vibro.core.codes import Regime, Status
from vibro.quantities import LISTED_HARMONICS, QUANTITIES, counted_harmonics

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
#: Of curves: the first of two, and the second.
BLUE: Final = "#004488"
RED: Final = "#BB5566"

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
MINORITY_LABEL: Final = "most parts move otherwise"
AVERAGED_LABEL: Final = "irregular motion: mean over many flights"
#: Hatches over colours, by their names.
OVER: Final[Mapping[str, Mapping[str, Any]]] = {
    BACKWARDS_LABEL: {"facecolor": "none", "hatch": "|", "edgecolor": INK},
    COEXISTS_LABEL: {"facecolor": "none", "hatch": "...", "edgecolor": NO_ANSWER_INK},
    MINORITY_LABEL: {"facecolor": "none", "hatch": "oo", "edgecolor": INK},
    AVERAGED_LABEL: {"facecolor": "none", "hatch": "/", "edgecolor": NO_ANSWER_INK},
}
ERROR_LABEL: Final = "standard error of this mean"

# Dashes, each with one meaning all over the pictures.
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

    @property
    def look(self) -> dict[str, Any]:
        """Properties of the line, for matplotlib."""
        return {"color": self.colour, "linestyle": self.dashes, "linewidth": self.width}


# Keys are the fields of CriticalLoads, in the order in which the usual scene passes them as the load rises.
CURVES: Final[Mapping[str, CurveStyle]] = {
    "forward_onset": CurveStyle("forward-slip onset", (0, (7, 2, 1.5, 2)), 1.4),
    "back_slip": CurveStyle("back-slip onset", (0, (5, 2)), 1.4),
    "continuous_sliding": CurveStyle("continuous sliding", (0, (1, 1.6)), 1.4),
    "hop": CurveStyle("hop limit", "-", 1.8),
}

ZERO_SPEED: Final = CurveStyle("zero speed", "-", 1.6, "#FFFFFF")
#: A speed or an error that is asked for; its label says which.
WANTED: Final = CurveStyle("", (0, (11, 2)), 2.2, "#CC3311")

_HALO: Final = 2.4  # [pt]
_FONT: Final = "DejaVu Sans"  # comes with matplotlib
# Other settings are matplotlib's own: with them, the font above too.
_RC: Final[Any] = {
    "font.size": 9.0,
    "axes.titlesize": 9.0,
    "axes.labelsize": 9.5,
    "axes.edgecolor": INK,
    "hatch.linewidth": 0.6,
    # Numbers along axes are written in full, without an offset or a common factor.
    "axes.formatter.useoffset": False,
    "axes.formatter.limits": (-99, 99),
    "legend.fontsize": 8.5,
    "legend.frameon": False,
    "svg.hashsalt": "vibro",  # makes files reproducible
    "figure.dpi": 150,
}

# Not printable to Python, but they belong to the spelling of Persian, of Indian languages, and of numbers.
_JOINERS: Final = "\N{ZERO WIDTH JOINER}\N{ZERO WIDTH NON-JOINER}\N{NO-BREAK SPACE}"
_HIDDEN: Final = "\N{REPLACEMENT CHARACTER}"
_NO_GLYPH: Final = "\N{WHITE SQUARE}"

UNIT_SIGNS: Final = {"deg": "°", "m/s^2": "m/s²"}
_LIGHT: Final = 0.48  # luma of a colour on which INK and white are about as legible


# Held by the thread that draws or saves: matplotlib has one set of settings, and one parser of formulas.
_DRAWING: Final = threading.RLock()


@contextmanager
def house_style() -> Iterator[None]:
    """Draw or save in this style over matplotlib's own defaults: the same on every machine.

    One thread does so at a time. A user's configuration (matplotlibrc, style sheets) does not change.
    """
    from matplotlib.style import context

    with _DRAWING, context(["default", _RC]):  # the default restores every setting but the backend
        yield


def visible(text: str) -> str:
    """Replace hidden characters in a user's text, such as controls and halves of undecodable names."""
    return "".join(c if c.isprintable() or c in _JOINERS else _HIDDEN for c in text)


def figure_text(text: str, most: int) -> str:
    """Turn a user's text, such as the name of a file, into words on one line of a figure.

    Parameters
    ----------
    text : str
        Anything; none of it is markup.
    most : int
        Letters for which there is room: the middle of what is longer becomes an ellipsis.

    Returns
    -------
    str
        For matplotlib, with dollars escaped. Hiding characters show as a replacement sign, those that the
        font lacks as a box.
    """
    from matplotlib.font_manager import findfont, get_font

    font = get_font(findfont(_FONT))
    words = "".join(c if font.get_char_index(ord(c)) else _NO_GLYPH for c in visible(text))
    if len(words) > most:
        words = f"{words[: most // 2]}…{words[-(most // 2) + 1 :]}"
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
        if quantity.order <= LISTED_HARMONICS or all_of_them
    ]
    return ", ".join([*parts, *counted_harmonics(values)])


def broken_lines(text: str, most: int) -> str:
    """Break a list after its commas, into lines of about so many letters."""
    kept = text.replace(" ", "\xa0").replace(",\xa0", ", ")
    most += 2 * text.count("$")  # markup, on average
    lines = textwrap.wrap(kept, most, break_long_words=False, break_on_hyphens=False)
    return "\n".join(lines).replace("\xa0", " ")


def spans_text(spans: Mapping[str, tuple[float, float]]) -> str:
    """Write bands of quantities, given in SI units, in the user's units: ``f = 15 Hz, μ_s = 0.3 ... 0.5``."""
    ends = {name: [q.from_si(end) for end in spans[name]] for name, q in QUANTITIES.items() if name in spans}
    return ", ".join(
        f"${QUANTITIES[name].symbol}$ = " + f"{number_text(low)} ... " * (low < high) + value_text(name, high)
        for name, (low, high) in ends.items()
    )


def ink_on(colour: Any) -> str:
    """Return INK or white, whichever is more legible on a colour."""
    from matplotlib.colors import to_rgb

    return INK if np.dot(to_rgb(colour), (0.2126, 0.7152, 0.0722)) > _LIGHT else "#FFFFFF"


def halo(colour: Any, width: float = _HALO, **look: Any) -> list[Any]:
    """Return the effect of an outline [pt] by which words and lines stand out from the background."""
    from matplotlib.patheffects import withStroke

    return [withStroke(linewidth=width, foreground=colour, **look)]
