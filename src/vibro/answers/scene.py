"""The answer about one scene: what the part does, how fast, and what begins next."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, Final

from vibro.answers.answer import Answer, Fact, Table, shown
from vibro.core.codes import PHASE_NAMES, Status
from vibro.quantities import LENGTH
from vibro.sweeps.one_scene import OneScene, facts_of, machine_lines, throughput_text

if TYPE_CHECKING:
    from collections.abc import Mapping

    from vibro.sweeps.grid import Grid

_RATE: Final = 0.06  # m/min a mm/s
_SHORT: Final = 3  # digits of ratios, and of where a regime begins
_NEXT: Final = ("forward slip", "back slip", "hopping")  # what people ask for; the others on request


def scene_answer(one: OneScene, grid: Grid, part: Mapping[str, float], record: Mapping[str, Any]) -> Answer:
    """Make the answer about one solved scene.

    Parameters
    ----------
    one : OneScene
        The scene.
    grid : Grid
        Its single cell.
    part : mapping of str to float
        What is known of parts in a row, by its names with units.
    record : mapping
        What JSON says.
    """
    return Answer(
        [*_usual(one), *_rare(one, grid, part)],
        [table for table in (_next(one), _beginnings(one), _phases(one)) if table.rows],
        [one.status.message] if one.status is not Status.OK else [],
        record,
    )


def _usual(one: OneScene) -> list[Fact]:
    speed, error = one.result("mean_velocity"), one.result("mean_velocity_error")
    cycle = f"{shown(_RATE * speed, _SHORT)} m/min, {shown(one.result('displacement_per_cycle'))} mm a cycle"
    facts = [Fact(one.regime.label or "none", speed, "mm/s", error, "" if math.isnan(speed) else cycle)]
    if not math.isnan(one.length):
        time, exact = one.traverse_time, one.arrival_time
        over = f" over {one.length:.10g} mm"
        from_rest = f"{shown(exact, 6)} s from rest" if math.isfinite(exact) else ""
        if time is None:
            facts.append(Fact("traverse time", one.why_never()))
        else:
            facts.append(Fact("traverse time", time, f"s{over}", time * one.relative_error, from_rest))
    if not math.isnan(speed):
        facts.append(Fact("peak speed", one.result("peak_velocity"), "mm/s"))
    facts.append(Fact("throw number", shown(one.throw_number, _SHORT), note="the part hops above 1"))
    return facts


def _rare(one: OneScene, grid: Grid, part: Mapping[str, float]) -> list[Fact]:
    pairs = [*machine_lines(one, grid), *facts_of(one, grid)]
    if text := throughput_text(one, part):
        pairs.append(("throughput", text))
    return [Fact(label, text, is_rare=True) for label, text in pairs]


def _next(one: OneScene) -> Table:
    """Where the regimes begin that have not begun."""
    rows = [
        (t.name, f"{shown(LENGTH.from_si(t.amplitude), _SHORT)} mm", f"{shown(t.frequency, _SHORT)} Hz")
        for t in one.transitions()
        if t.name in _NEXT and t.ratio < 1.0 and not one.is_two_axis
    ]
    return Table("next", [("begins", ""), (one.size, ""), ("frequency", "")], rows)


def _beginnings(one: OneScene) -> Table:
    rows = [(t.name, t.ratio, LENGTH.from_si(t.amplitude), t.frequency) for t in one.transitions()]
    columns = [("begins", ""), ("load over its load", ""), ("amplitude", "mm"), ("frequency", "Hz")]
    return Table("beginnings", columns, rows, is_rare=True)


def _phases(one: OneScene) -> Table:
    rows = [
        (PHASE_NAMES[p.kind], 1e3 * p.start, 1e3 * p.end, LENGTH.from_si(p.displacement))
        for p in one.phases()
    ]
    columns = [("phase", ""), ("start", "ms"), ("end", "ms"), ("displacement", "mm")]
    return Table("phases", columns, rows, is_rare=True)
