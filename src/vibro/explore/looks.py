"""How a map looks, in words and numbers: regimes, statuses, axes, curves, colours."""

from __future__ import annotations

from base64 import b64encode
from typing import TYPE_CHECKING, Any, Final

import numpy as np
from matplotlib import colormaps
from matplotlib.ticker import MaxNLocator

from vibro.core.codes import Status
from vibro.plots.style import INK, NO_ANSWER_HATCH, REGIME_COLOURS, value_text
from vibro.quantities import QUANTITIES

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from vibro.axes import Axis
    from vibro.explore.state import State
    from vibro.plots.scales import Scale
    from vibro.plots.style import CurveStyle

    Floats = NDArray[np.float64]

__all__ = ["STYLES", "caption_of", "look_of_axis", "look_of_curve", "look_of_scale"]

#: How regimes and statuses look and are called, for the page.
STYLES: Final = {
    "regimes": [
        {"code": int(regime), "label": regime.label, "colour": colour}
        for regime, colour in REGIME_COLOURS.items()
    ],
    "statuses": [
        {
            "code": int(status),
            "label": status.label.replace("-", " "),
            "message": status.message,
            "hatch": NO_ANSWER_HATCH.get(status, "")[:1],
            "answered": status.answered,
        }
        for status in Status
    ],
}

_COLOURS: Final = 256  # of a scale
_GREEK: Final = {
    "alpha": "α", "beta": "β", "varphi": "φ", "mu": "μ", "xi": "ξ", "eta": "η",
}  # fmt: skip


def caption_of(state: State) -> str:
    """Say what does not vary over a map and is not as usual, as pictures do: ``α = 20°, μ_s = 0.74``."""
    grid = state.grid()
    fixed = {**grid.fixed, "trough_length": grid.length}
    parts = []
    for name, quantity in QUANTITIES.items():
        value = fixed.get(name)
        if name in state.bands:
            low, high = (value_text(name, end) for end in state.bands[name])
            parts.append(f"{_plain(quantity.symbol)} = {low} to {high}")
        elif value is not None and value != quantity.default:
            parts.append(f"{_plain(quantity.symbol)} = {value_text(name, value)}")
    return ", ".join(parts)


def _plain(symbol: str) -> str:
    """Turn a symbol in TeX into one that can be read anywhere: ``μ_s``."""
    for name, letter in _GREEK.items():
        symbol = symbol.replace(f"\\{name}", letter)
    return symbol


def look_of_axis(axis: Axis) -> dict[str, Any]:
    """Describe an axis of a map."""
    first, last = (float(end) for end in axis.values[[0, -1]])
    described = {"column": axis.column, "label": axis.label, "symbol": QUANTITIES[axis.name].letter}
    return {
        **described,
        "unit": axis.unit,
        "from": first,
        "to": last,
        "log": axis.spacing == "log",
        "count": len(axis),
    }


def look_of_curve(name: str, style: CurveStyle, lines: list[Floats]) -> dict[str, Any]:
    """Describe a curve, and how many points its pieces have."""
    return {
        "name": name,
        "label": style.label,
        "dash": _dashes_of(style),
        "width": style.width,
        "colour": "ink" if style.colour == INK else "white",
        "pieces": [len(line) for line in lines],
    }


def _dashes_of(style: CurveStyle) -> list[float]:
    """Return the lengths of dashes and gaps [px]; none of a line without."""
    return [] if isinstance(style.dashes, str) else [length * style.width for length in style.dashes[1]]


def look_of_scale(scale: Scale, numbers: Floats) -> dict[str, Any]:
    """Describe a scale such that the page can turn numbers into colours; without ticks if there are none."""
    norm: Any = scale.norm
    low, high = float(norm.vmin), float(norm.vmax)
    if low == high:  # all numbers are the same: shares of no width are none
        low, high = min(low, 0.0), max(high, 0.0)
    kind = {"LogNorm": "log", "AsinhNorm": "asinh"}.get(type(norm).__name__, "linear")
    ticks = MaxNLocator(6).tick_values(low, high) if scale.ticks is None else scale.ticks
    colours = colormaps[scale.colours](np.linspace(0.0, 1.0, _COLOURS), bytes=True)[:, :3]
    return {
        "kind": kind,
        "low": low,
        "high": high,
        "width": float(norm.linear_width) if kind == "asinh" else 0.0,
        "colours": b64encode(colours.tobytes()).decode(),
        "ticks": [float(tick) for tick in ticks if low <= tick <= high] if np.isfinite(numbers).any() else [],
    }
