"""How pictures look: colours, hatches, lines and words, the same in every one."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Final, NamedTuple

from vibro.core.codes import Regime, Status
from vibro.quantities import QUANTITIES

if TYPE_CHECKING:
    from collections.abc import Mapping

    from vibro.axes import Axis

__all__ = [
    "AVERAGED_AREA_LABEL",
    "AVERAGED_HATCH",
    "AVERAGED_LABEL",
    "AVERAGED_RINGS",
    "COEXISTS_HATCH",
    "COEXISTS_LABEL",
    "CURVES",
    "INK",
    "NO_ANSWER_FACE",
    "NO_ANSWER_HATCH",
    "NO_ANSWER_INK",
    "RC",
    "REGIME_COLOURS",
    "axis_label",
    "ink_on",
    "number_text",
    "value_text",
    "values_text",
]

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
COEXISTS_HATCH: Final = "..."
COEXISTS_LABEL: Final = "another motion exists"
# Dark dots in white rings: on any colour one of them shows.
AVERAGED_HATCH: Final = ".."
AVERAGED_RINGS: Final = "oo"
AVERAGED_LABEL: Final = "mean of motion without a short period"
AVERAGED_AREA_LABEL: Final = "means of motion without a short period, at least in part"


class CurveStyle(NamedTuple):
    """The name of a critical curve, and how it is drawn."""

    label: str
    dashes: Any
    width: float


# Keys are the fields of CriticalLoads, in the order in which the usual scene passes them as the load rises.
CURVES: Final[Mapping[str, CurveStyle]] = {
    "forward_onset": CurveStyle("forward-slip onset", (0, (7, 2, 1.5, 2)), 1.4),
    "back_slip": CurveStyle("back-slip onset", (0, (5, 2)), 1.4),
    "rest_vanishes": CurveStyle("rest vanishes", (0, (1, 1.6)), 1.4),
    "hop": CurveStyle("hop limit", "-", 1.8),
}

RC: Final[Any] = {
    "font.family": "sans-serif",
    "font.sans-serif": ["DejaVu Sans"],
    "font.size": 9.0,
    "axes.titlesize": 9.0,
    "axes.labelsize": 9.5,
    "axes.edgecolor": INK,
    "axes.linewidth": 0.8,
    "axes.formatter.use_mathtext": False,
    "xtick.direction": "out",
    "ytick.direction": "out",
    "hatch.linewidth": 0.6,
    "legend.fontsize": 8.5,
    "legend.frameon": False,
    "mathtext.fontset": "dejavusans",
    "text.usetex": False,
    "svg.fonttype": "path",
    "svg.hashsalt": "vibro",  # makes files reproducible
    "figure.dpi": 150,
    "savefig.dpi": 150,
}

_UNIT_SIGNS: Final = {"deg": "°", "m/s^2": "m/s²"}
_EVEN_LUMINANCE: Final = 0.2  # relative luminance of a colour on which INK and white are about as legible


def axis_label(axis: Axis) -> str:
    """Name, symbol and unit of an axis: ``frequency f [Hz]``."""
    unit = f" [{_UNIT_SIGNS.get(axis.unit, axis.unit)}]" if axis.unit else ""
    return f"{axis.label} ${QUANTITIES[axis.name].symbol}${unit}"


def number_text(value: float) -> str:
    """Write a number with five digits and a proper minus."""
    return f"{value:.5g}".replace("-", "\N{MINUS SIGN}")


def value_text(name: str, value: float) -> str:
    """Write a value of a quantity with its unit."""
    unit = QUANTITIES[name].unit
    sign = _UNIT_SIGNS.get(unit, unit)
    return number_text(value) + ("" if sign in ("°", "") else " ") + sign


def values_text(values: Mapping[str, float], *, all_of_them: bool = False) -> str:
    """Write quantities in the user's units, in the order of tables: ``α = 20°, f = 15 Hz``.

    Those that have their usual value are left out unless all are asked for.
    """
    parts = []
    for name, quantity in QUANTITIES.items():
        if name in values and (all_of_them or quantity.default != values[name]):
            parts.append(f"${quantity.symbol}$ = {value_text(name, values[name])}")
    return ", ".join(parts)


def ink_on(colour: Any) -> str:
    """Return INK or white, whichever is more legible on a colour."""
    from matplotlib.colors import to_rgb

    linear = [c / 12.92 if c <= 0.04045 else ((c + 0.055) / 1.055) ** 2.4 for c in to_rgb(colour)]
    luminance = 0.2126 * linear[0] + 0.7152 * linear[1] + 0.0722 * linear[2]
    return INK if luminance > _EVEN_LUMINANCE else "#FFFFFF"
