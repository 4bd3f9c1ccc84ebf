"""How phases of motion are shaded and named, the same in every picture over time."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final, NamedTuple

from vibro.core.codes import PHASE_NAMES, Regime
from vibro.plots.style import REGIME_COLOURS

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping

    from matplotlib.axes import Axes
    from matplotlib.patches import Patch

__all__ = ["PHASE_STYLES", "PhaseStyle", "legend_entries", "shade"]

_STRENGTH: Final = 0.35


class PhaseStyle(NamedTuple):
    """How a kind of phase looks and is called."""

    label: str
    colour: str


# Keys are the letters of a pattern. Colours are those of the regime that each brings.
PHASE_STYLES: Final[Mapping[str, PhaseStyle]] = {
    kind: PhaseStyle(PHASE_NAMES[kind], REGIME_COLOURS[regime])
    for kind, regime in (
        ("F", Regime.FORWARD_SLIP),
        ("B", Regime.BACK_SLIP),
        ("H", Regime.HOPPING),
        ("_", Regime.NO_SLIP),
    )
}


def shade(axes: Axes, kind: str, start: float, end: float) -> None:
    """Shade a phase over the height of the axes."""
    axes.axvspan(start, end, facecolor=PHASE_STYLES[kind].colour, alpha=_STRENGTH, edgecolor="none", zorder=0)


def legend_entries(styles: Iterable[PhaseStyle]) -> list[Patch]:
    """Return what a legend shows of shaded phases."""
    from matplotlib.patches import Patch

    return [
        Patch(facecolor=style.colour, alpha=_STRENGTH, edgecolor="none", label=style.label)
        for style in styles
    ]
