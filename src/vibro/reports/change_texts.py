"""Texts of a report about small changes of each input: the speed and motion of the part."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Final, NamedTuple

from vibro.core.codes import Regime, Status
from vibro.inverse.costs import changed_cycles
from vibro.quantities import LENGTH, QUANTITIES, as_given
from vibro.reports.scene_texts import DOES, pattern_text
from vibro.results.operating import OPERATING
from vibro.sweeps.one_scene import estimate

if TYPE_CHECKING:
    from collections.abc import Sequence

    from vibro.results.steady import SteadyCycle
    from vibro.sweeps.one_scene import OneScene

__all__ = ["change_texts"]

_TOLD: Final = 9  # decimals of a percentage, below which there is rounding alone
_SIGMAS: Final = 3.0  # standard errors by which two means differ for sure
_DRIVE: Final = "drive"  # not a single input


class _Change(NamedTuple):
    """By how much the speed changes, NaN if that is no number, its standard error [%], and their texts."""

    name: str
    percent: float
    error: float
    told: str
    motion: str


def change_texts(one: OneScene) -> tuple[list[str], list[tuple[str, ...]]]:
    """Say what a little more of each input does to the speed.

    Parameters
    ----------
    one : OneScene
        It is solved again with every change.

    Returns
    -------
    texts : list of str
        The input with the largest effect, or why it is unknown.
    rows : list of tuple of str
        Of a table, its head first; empty where the texts say all.
    """
    if math.isnan(one.result("mean_velocity")):
        why = "it gains speed in every cycle" if one.runs else one.status.message
        return [f"The part has no known speed that could change: {why}."], []
    names, cycle = changed_cycles(one.scene)
    names = [*as_given(dict.fromkeys(names, 1.0), in_stroke=one.size == "stroke")]
    which = one.all_amplitudes or one.size
    rests = (cycle.regime == Regime.NO_SLIP) | (cycle.status == Status.INFEASIBLE)
    if rests.all():
        return [f"The part rests with a little more of any input too, and with 10 % more {which}."], []
    in_percent = not one.is_still and one.is_certain
    left_out = "frequency" if OPERATING in one.values else ""  # with which a machine's amplitude changes
    changes = [
        _change(name, cycle, cell, in_percent) for cell, name in enumerate(names, 1) if name != left_out
    ]
    labels = [_label(change.name, which) for change in changes]
    told = "the mean speed changes by" if in_percent else "the mean speed becomes"
    rows: list[tuple[str, ...]] = [("1 % more", told, "and the part then")]
    rows += [(label, change.told, change.motion) for label, change in zip(labels, changes, strict=True)]
    if not any(change.motion for change in changes):
        rows = [(label, cell) for label, cell, _ in rows]
    texts = [_ranking([c for c in changes if c.name != _DRIVE and not c.name.endswith("_deg")])]
    if one.hops:
        texts.append(
            "Where parts hop the speed jumps and bends: 2 % more, or 1 % less, may do something else."
        )
    return [text for text in texts if text], rows


def _label(name: str, which: str) -> str:
    if name == _DRIVE:
        return f"{which}, 10 % more"
    angle = name.removesuffix("_deg")
    return QUANTITIES[angle].label + ("" if angle == name else ", 1° more")


def _change(name: str, cycle: SteadyCycle, cell: int, in_percent: bool) -> _Change:
    """Compare a cell with the first one."""
    before, after = float(cycle.mean_velocity[0]), float(cycle.mean_velocity[cell])
    if math.isnan(after):
        status = Status(int(cycle.status[cell]))
        what = "runs away" if status is Status.RUNAWAY else f"has no speed ({status.label})"
        return _Change(name, math.nan, 0.0, "unknown", what)
    motion = _other_motion(cycle, cell)
    errors = [max(float(cycle.mean_velocity_error[i]), 0.0) for i in (0, cell)]
    if not in_percent or not after / before > 0.0:
        told = estimate(float(LENGTH.from_si(after)), float(LENGTH.from_si(errors[1])), "mm/s")
        return _Change(name, math.nan, 0.0, told, motion)
    if after == before:  # the very same motion
        return _Change(name, 0.0, 0.0, "0 %", motion)
    percent = round(100.0 * (after / before - 1.0), _TOLD)
    error = 100.0 * after / before * math.hypot(errors[0] / before, errors[1] / after)
    told = f"{percent:+.3g} %" if percent else "0 %"
    return _Change(name, percent, error, told + f" +- {error:.2g} %" * (error > 0.0), motion)


def _other_motion(cycle: SteadyCycle, cell: int) -> str:
    """Say what the part does if it differs from the first cell; else an empty text."""
    regime, status = Regime(int(cycle.regime[cell])), Status(int(cycle.status[cell]))
    if regime != cycle.regime[0]:
        return DOES[regime]
    if status is Status.AVERAGED:
        return "" if cycle.status[0] == status else "hops in irregular motion"
    period = float(cycle.period_cycles[cell])
    if period != cycle.period_cycles[0]:
        return "repeats every drive cycle" if period == 1.0 else f"repeats every {period:.0f} drive cycles"
    pattern = str(cycle.pattern[cell])
    return "" if pattern == cycle.pattern[0] else f"has other phases ({pattern_text(pattern)})"


def _ranking(changes: Sequence[_Change]) -> str:
    """Name the input of which 1 % more has the largest effect, if that is certain."""
    if any(math.isnan(change.percent) for change in changes):
        return ""
    most = max(changes, key=lambda change: abs(change.percent))
    gaps = [
        (abs(most.percent) - abs(other.percent), _SIGMAS * math.hypot(most.error, other.error))
        for other in changes
        if other is not most
    ]
    if any(gap < noise for gap, noise in gaps):
        return "Within the standard errors it is not clear which change has the largest effect."
    if any(gap <= 0.0 for gap, _ in gaps):
        return ""
    word = "faster" if most.percent > 0.0 else "slower"
    size = f"{abs(most.percent):.3g} % {word}"
    return f"Of 1 % more of each, the {QUANTITIES[most.name].label} counts most: {size}."
