"""How pictures over time shade and name the phases of motion."""

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
    """The name and the colour of a kind of phase."""

    label: str
    colour: str


# Keys are the letters of a pattern. Each phase has the colour of the regime in which it is typical.
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
    """Return the legend's entries for shaded phases."""
    from matplotlib.patches import Patch

    return [
        Patch(facecolor=style.colour, alpha=_STRENGTH, edgecolor="none", label=style.label)
        for style in styles
    ]
