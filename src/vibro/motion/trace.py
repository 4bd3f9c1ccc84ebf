"""A history in rows: its motion at even steps and at every event."""

from __future__ import annotations

import math
from dataclasses import fields
from typing import TYPE_CHECKING, Final

import numpy as np

from vibro.core.codes import PHASE_NAMES
from vibro.results.history import Sample
from vibro.results.phase_tables import in_mm, trough_phase

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from vibro.files.csv_tables import TableColumns
    from vibro.results.history import History

    Floats = NDArray[np.float64]

__all__ = ["motion_table", "trace"]

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
        "trough_phase_deg": trough_phase(history, sample.time),
        "phase": [PHASE_NAMES[phases[i].kind] for i in place],
        **_trough(sample),
        "relative_position_mm": in_mm(sample.position),
        "relative_velocity_mm_s": in_mm(sample.velocity),
        "relative_acceleration_m_s2": sample.acceleration,
        "inertial_m_s2": sample.inertial,
        "friction_m_s2": sample.friction,
        "normal_m_s2": sample.normal,
        "static_limit_m_s2": sample.static_limit,
        "gap_mm": in_mm(sample.gap),
    }


def _trough(sample: Sample) -> TableColumns:
    """Return the columns of the trough's own motion: one along a line, two of an ellipse."""
    if np.isnan(sample.trough_displacement).all():
        return {
            "trough_along_mm": in_mm(sample.trough_along),
            "trough_normal_mm": in_mm(sample.trough_normal),
        }
    return {"trough_displacement_mm": in_mm(sample.trough_displacement)}
