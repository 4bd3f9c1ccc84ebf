"""Phases of a history in rows, in the units of tables."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from vibro.core.codes import PHASE_NAMES
from vibro.quantities import LENGTH

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from vibro.results.history import History, Phase

    Floats = NDArray[np.float64]

__all__ = ["in_mm", "phase_table", "trough_phase"]


def phase_table(history: History, phases: Sequence[Phase]) -> dict[str, Floats | list[str]]:
    """Return the columns of a list of phases, one row a phase, by their names with units."""
    return {
        "phase": [PHASE_NAMES[p.kind] for p in phases],
        "start_s": np.array([p.start for p in phases]),
        "end_s": np.array([p.end for p in phases]),
        "trough_phase_at_start_deg": trough_phase(history, np.array([p.start for p in phases])),
        "start_position_mm": in_mm(np.array([p.start_position for p in phases])),
        "end_position_mm": in_mm(np.array([p.end_position for p in phases])),
        "start_velocity_mm_s": in_mm(np.array([p.start_velocity for p in phases])),
        "end_velocity_mm_s": in_mm(np.array([p.end_velocity for p in phases])),
        "impact_velocity_mm_s": in_mm(np.array([p.impact_velocity for p in phases])),
    }


def in_mm(values: Floats) -> Floats:
    """Convert from m, or m/s, to mm, or mm/s; without negative zeros."""
    return np.asarray(LENGTH.from_si(values)) + 0.0


def trough_phase(history: History, time: Floats) -> Floats:
    """Trough phase in [0, 360) [deg]."""
    turns = float(history.scene.frequency) * time + history.start_phase / (2.0 * math.pi)
    return np.asarray(360.0 * (turns - np.floor(turns)))
