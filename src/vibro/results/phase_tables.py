"""Phases of a history in rows, in the units of tables."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import TYPE_CHECKING, Final

import numpy as np

from vibro.core.codes import PHASE_NAMES
from vibro.quantities import LENGTH

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from vibro.results.history import History, Phase

    Floats = NDArray[np.float64]

__all__ = ["in_mm", "phase_table", "trough_phase", "with_chains"]

_SHORT: Final = 0.1  # [drive cycles] a longer flight has a row of its own
_FEWEST: Final = 3  # bounces of a chain


def with_chains(phases: Sequence[Phase], period: float) -> list[tuple[str, Phase]]:
    """Sum up chains of bounces: flights within a tenth of a cycle, each landing slower than the one before.

    Parameters
    ----------
    phases : sequence of Phase
        One after the other.
    period : float
        Of the drive [s].

    Returns
    -------
    list of tuple of str and Phase
        What people call each row, and the phase; a chain of three bounces or more is one phase, from its
        start to its end, with the largest of its impact velocities.
    """
    rows: list[tuple[str, Phase]] = []
    chain: list[Phase] = []
    for phase in phases:
        bounces = phase.kind == "H" and phase.end - phase.start < _SHORT * period
        if chain and not (bounces and phase.impact_velocity < chain[-1].impact_velocity):
            rows += _summed(chain, dies=phase.kind != "H")
            chain = []
        if bounces:
            chain.append(phase)
        else:
            rows.append(_named(phase))
    return rows + _summed(chain, dies=False)


def _named(phase: Phase) -> tuple[str, Phase]:
    return PHASE_NAMES[phase.kind], phase


def _summed(chain: Sequence[Phase], *, dies: bool) -> list[tuple[str, Phase]]:
    """Return the one row of a chain, or the rows of one that is too short to be summed up."""
    if len(chain) < _FEWEST:
        return [_named(bounce) for bounce in chain]
    first, last = chain[0], chain[-1]
    whole = replace(
        first,
        end=last.end,
        end_position=last.end_position,
        end_velocity=last.end_velocity,
        impact_velocity=max(bounce.impact_velocity for bounce in chain),
    )
    return [(f"{len(chain)} bounces{', until they die out' if dies else ''}", whole)]


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
