"""The motion of the operating point in time, as the page draws it."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Final

import numpy as np

from vibro.core.codes import PHASE_NAMES
from vibro.explore.packing import pack
from vibro.explore.words import even_ticks
from vibro.motion.histories import simulate, trace
from vibro.plots.history import PANELS, PHASE_COLOURS, choose_panels, most_force, panels_of, values_of

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from vibro.explore.state import State

__all__ = ["packed_history"]

_MARGIN: Final = 0.06  # of a panel, above and below its curves
_OTHER_LIMIT: Final = "static_limit_below"
_SAMPLES: Final = 100  # a drive cycle, beside every event
_NAMES: Final = "trough,forces,velocity,position"


def packed_history(state: State) -> bytes:
    """Pack the first drive cycles of a body that starts from rest.

    Parameters
    ----------
    state : State
        Its operating point, and for how many cycles.

    Returns
    -------
    bytes
        As ``pack`` makes them: ``time`` [ms], and what each curve of the panels shows, in the panel's unit;
        NaN interrupts a curve.

    Raises
    ------
    VibroError
        If there is no motion to follow.
    """
    history = simulate(state.point.scene(), cycles=state.cycles)
    phases = history.phases
    rows = trace(history, until=history.end, samples_per_cycle=_SAMPLES, both_sides=True)
    flies = any(phase.kind == "H" for phase in phases)
    arrays: dict[str, NDArray[Any]] = {"time": _single(1e3 * rows.time)}
    panels = []
    for name, panel in panels_of([*choose_panels(_NAMES, flies=flies), *["gap"] * flies], rows).items():
        most = most_force(rows) if panel is PANELS["forces"] else None
        curves = []
        for curve in panel.curves:
            described: dict[str, Any] = {
                "label": curve.label,
                "colour": curve.colour,
                "dash": [] if curve.dashes == "-" else [*curve.dashes[1]],
                "width": curve.width,
                "array": curve.field,
            }
            arrays[curve.field] = _single(values_of(curve, panel, rows))
            if most is not None and (np.abs(arrays[curve.field]) > most).any():
                described["label"] += " (cut off)"
            curves.append(described)
            if curve.field == "static_limit":  # it holds either way
                arrays[_OTHER_LIMIT] = -arrays[curve.field]
                curves.append({**described, "array": _OTHER_LIMIT, "label": ""})
        low, high = _ends([arrays[curve["array"]] for curve in curves], most)
        panels.append(
            {
                "name": name,
                "title": panel.label.replace("\n", " ") + (f" [{panel.unit}]" if panel.unit else ""),
                "height": panel.height,
                "low": low,
                "high": high,
                "ticks": even_ticks(low, high, most=4),
                "curves": curves,
            }
        )
    duration = 1e3 * history.end
    header = {
        "title": f"first {state.cycles} drive cycles from rest",
        "duration_ms": duration,
        "ticks": even_ticks(0.0, duration),
        "phases": [
            {
                "kind": phase.kind,
                "name": PHASE_NAMES[phase.kind],
                "colour": PHASE_COLOURS[phase.kind],
                "start": phase.start / history.end,
                "end": phase.end / history.end,
            }
            for phase in phases
        ],
        "panels": panels,
        "note": "",
    }
    return pack(header, arrays)


def _ends(curves: list[NDArray[np.float32]], most: float | None) -> tuple[float, float]:
    """Return the ends of a panel's axis, with zero inside; forces are cut at the largest of interest."""
    values = np.concatenate([[0.0], *curves])
    low, high = float(np.nanmin(values)), float(np.nanmax(values))
    if most is not None:
        low, high = max(low, -most), min(high, most)
    margin = _MARGIN * (high - low or 1.0)
    return low - margin, high + margin


def _single(values: NDArray[np.float64]) -> NDArray[np.float32]:
    """Round to single precision, in which the page draws; no point moves visibly."""
    return values.astype(np.float32)
