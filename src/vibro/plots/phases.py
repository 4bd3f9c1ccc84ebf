"""How pictures over time shade and name the phases of motion."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Final, NamedTuple

from vibro.core.codes import PHASE_NAMES, Regime
from vibro.plots.bands import Band
from vibro.plots.style import INK, REGIME_COLOURS

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping, Sequence

    from vibro.results.history import Phase

_START_MARK: Final[Mapping[str, Any]] = {"marker": "s", "markersize": 5, "color": INK, "linestyle": "none"}
_STOP_MARK: Final[Mapping[str, Any]] = {**_START_MARK, "marker": "o", "markerfacecolor": "#FFFFFF"}
_IMPACT_MARK: Final[Mapping[str, Any]] = {**_START_MARK, "marker": "v", "color": "#994455"}


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


class Event(NamedTuple):
    """A mark where phases meet: name, style, times [s], and whether at the values before or after."""

    label: str
    mark: Mapping[str, Any]
    instants: list[float]
    before: bool


def events_of(phases: Sequence[Phase]) -> list[Event]:
    """List the starts and the stops of slides, and the impacts."""
    slides = [p for p in phases if p.kind in "FB"]
    return [
        Event("slide starts", _START_MARK, [p.start for p in slides if p.start_velocity == 0.0], before=True),
        Event("slide stops", _STOP_MARK, [p.end for p in slides if p.end_velocity == 0.0], before=False),
        Event("impact", _IMPACT_MARK, [p.end for p in phases if p.kind == "H"], before=False),
    ]


def phase_bands(phases: Iterable[Phase], *, later: float = 0.0) -> list[Band]:
    """Return the bands of phases over time [ms], so much later [s]."""
    return [
        Band(1e3 * (p.start + later), 1e3 * (p.end + later), style.label, {"facecolor": style.colour})
        for p in phases
        for style in [PHASE_STYLES[p.kind]]
    ]
