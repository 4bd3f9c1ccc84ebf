"""The answer about a history: its phases, and what becomes of the body."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, Final

from vibro.answers.answer import Answer, Fact, Table, letters, shown
from vibro.core.codes import PHASE_NAMES, Regime, Status
from vibro.results.history import phase_table, with_chains
from vibro.steady import solve
from vibro.units import LENGTH

if TYPE_CHECKING:
    from collections.abc import Mapping

    from vibro.results.history import History

_PRINTED: Final = 24  # phases
# Label, unit, key in the table of phases, factor and decimals of each column.
_COLUMNS: Final = (
    ("start", "ms", "start_s", 1e3, 4), ("end", "ms", "end_s", 1e3, 4),
    ("from", "mm", "start_position_mm", 1.0, 5), ("to", "mm", "end_position_mm", 1.0, 5),
    ("from", "mm/s", "start_velocity_mm_s", 1.0, 3), ("to", "mm/s", "end_velocity_mm_s", 1.0, 3),
)  # fmt: skip


def history_answer(history: History, record: Mapping[str, Any], *, every: bool) -> Answer:
    """Make the answer about a history.

    Parameters
    ----------
    history : History
        What was simulated.
    record : mapping
        What JSON says, beside the phases.
    every : bool
        Whether all phases and every bounce are printed, or the first 24 and chains of bounces as one.
    """
    advance = float(LENGTH.from_si(history.phases[-1].end_position))
    facts = [Fact(f"after {shown(history.end)} s", advance, "mm"), Fact("settles", _settles(history))]
    if any(phase.kind == "H" for phase in history.phases):
        facts.append(Fact("restitution", float(history.scene.restitution)))
    columns = phase_table(history, history.phases)
    phases = [dict(zip(columns, row, strict=True)) for row in zip(*columns.values(), strict=True)]
    return Answer(facts, [_phases(history, every=every)], record={**record, "phases": phases})


def _phases(history: History, *, every: bool) -> Table:
    if every:
        named = [(PHASE_NAMES[phase.kind], phase) for phase in history.phases]
    else:
        named = with_chains(history.phases, 1.0 / float(history.scene.frequency))
    printed = named if every else named[:_PRINTED]
    table: dict[str, Any] = phase_table(history, [phase for _, phase in printed])
    cells = ([f"{factor * x:z.{digits}f}" for x in table[key]] for *_, key, factor, digits in _COLUMNS)
    rows = [*zip([name for name, _ in printed], *cells, strict=True)]
    title = "Phases"
    if len(named) > len(printed):
        title = f"The first {_PRINTED} of {len(named)} phases; --all prints them all"
    return Table("phases", [("phase", ""), *(column[:2] for column in _COLUMNS)], rows, title)


def _settles(history: History) -> str:
    """Say from when on the motion repeats or rests, or whether it may do so yet."""
    steady, last = solve(history.scene), history.phases[-1]
    if math.isfinite(history.settles_at):
        again, pattern = str(steady.pattern), history.pattern
        if len(again) == len(pattern) and pattern in 2 * again:
            pattern = again  # the same cycle from another phase on
        advance = shown(float(LENGTH.from_si(history.cycle_displacement)))
        at = shown(1e3 * history.settles_at)
        return f"at {at} ms: the phases {pattern} ({letters(pattern)}) repeat, {advance} mm a cycle"
    if steady.regime == Regime.NO_SLIP and last.kind == "_":
        return f"at {shown(1e3 * last.start)} ms: the body rests"
    if steady.status not in (Status.OK, Status.BOUNDARY):
        return f"never: {Status(int(steady.status)).message.partition(':')[0]}"
    return "not yet: more --cycles may show it"
