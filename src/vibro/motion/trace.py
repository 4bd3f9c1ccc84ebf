"""A history in rows: its phases, and its motion at even steps and at every event."""

from __future__ import annotations

import math
from dataclasses import fields
from typing import TYPE_CHECKING, Final

import numpy as np

from vibro.core.codes import PHASE_NAMES
from vibro.quantities import LENGTH
from vibro.results.history import Sample

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from vibro.files.tables import TableColumns
    from vibro.results.history import History, Phase

    Floats = NDArray[np.float64]

__all__ = ["motion_table", "phase_table", "trace"]

_ROUNDING: Final = 1e-9  # of the number of steps, or of a drive cycle


def trace(
    history: History, *, since: float = 0.0, until: float, samples_per_cycle: int, both_sides: bool = False
) -> Sample:
    """Sample a history at even steps and at every event.

    Parameters
    ----------
    history : History
        What to sample.
    since, until : float
        When the samples begin and end [s].
    samples_per_cycle : int
        Even steps in a drive cycle; 0 for the events alone.
    both_sides : bool
        Whether there are two rows at an event, before and after it, as a picture needs them, also where the
        trough's acceleration jumps; else there is one, after it.

    Returns
    -------
    Sample
        Arrays of one row a time, ascending, from ``since`` on.
    """
    events = np.array([p.start for p in history.phases if since < p.start < until])
    if both_sides:
        jumps, beside = history.jumps(since, until), _ROUNDING / float(history.scene.frequency)
        # Where a phase begins at a jump, both times may differ by rounding: they are one event.
        ends = (np.searchsorted(events, jumps + side) for side in (-beside, beside))
        events = np.union1d(events, jumps[np.equal(*ends)])
    rate = samples_per_cycle * float(history.scene.frequency)
    # A last step that differs from the end by rounding alone is dropped: the end is added below.
    steps = np.arange(math.ceil(rate * since), math.ceil(rate * until * (1.0 - _ROUNDING)))
    even = steps / rate if rate else np.array([])
    times = np.unique(np.concatenate([[since], even, events, [until]]))
    if not both_sides:
        return history.sample(times)
    after, before = history.sample(times[:-1]), history.sample(np.append(events, until), side="left")
    # Stable: the row before an event stands first.
    order = np.argsort(np.concatenate([before.time, after.time]), kind="stable")
    return Sample(
        *(np.concatenate([getattr(before, f.name), getattr(after, f.name)])[order] for f in fields(Sample))
    )


def motion_table(history: History, sample: Sample) -> TableColumns:
    """Return the columns of a sampled motion, forces per unit mass."""
    phases = history.phases
    place = np.searchsorted([p.start for p in phases], sample.time, side="right") - 1
    return {
        "time_s": sample.time,
        "trough_phase_deg": _degrees(history, sample.time),
        "phase": [PHASE_NAMES[phases[i].kind] for i in place],
        **_trough(sample),
        "relative_position_mm": _mm(sample.position),
        "relative_velocity_mm_s": _mm(sample.velocity),
        "relative_acceleration_m_s2": sample.acceleration,
        "inertial_m_s2": sample.inertial,
        "friction_m_s2": sample.friction,
        "normal_m_s2": sample.normal,
        "static_limit_m_s2": sample.static_limit,
        "gap_mm": _mm(sample.gap),
    }


def phase_table(history: History, phases: Sequence[Phase]) -> TableColumns:
    """Return the columns of a list of phases."""
    return {
        "phase": [PHASE_NAMES[p.kind] for p in phases],
        "start_s": np.array([p.start for p in phases]),
        "end_s": np.array([p.end for p in phases]),
        "trough_phase_at_start_deg": _degrees(history, np.array([p.start for p in phases])),
        "start_position_mm": _mm(np.array([p.start_position for p in phases])),
        "end_position_mm": _mm(np.array([p.end_position for p in phases])),
        "start_velocity_mm_s": _mm(np.array([p.start_velocity for p in phases])),
        "end_velocity_mm_s": _mm(np.array([p.end_velocity for p in phases])),
        "impact_velocity_mm_s": _mm(np.array([p.impact_velocity for p in phases])),
    }


def _trough(sample: Sample) -> TableColumns:
    """Return the columns of the trough's own motion: one along a line, two of an ellipse."""
    if np.isnan(sample.trough_displacement).all():
        return {
            "trough_along_mm": _mm(sample.trough_along),
            "trough_normal_mm": _mm(sample.trough_normal),
        }
    return {"trough_displacement_mm": _mm(sample.trough_displacement)}


def _mm(values: Floats) -> Floats:
    return np.asarray(LENGTH.from_si(values)) + 0.0  # not -0.0


def _degrees(history: History, time: Floats) -> Floats:
    """Trough phase in [0, 360) [deg]."""
    turns = float(history.scene.frequency) * time + history.start_phase / (2.0 * math.pi)
    return np.asarray(360.0 * (turns - np.floor(turns)))
