"""What ``vibro design`` prints: the question, all designs, and details of the chosen one."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from vibro.cli.report import aligned
from vibro.core.codes import Regime
from vibro.reports.design_texts import (
    chosen_facts,
    closest_rows,
    cost_rows,
    design_table,
    drive_limits,
    load_rows,
    question_facts,
    remarks,
    size_of,
)

if TYPE_CHECKING:
    from collections.abc import Sequence

    from vibro.inverse.designs import Chosen
    from vibro.inverse.specs import Drive, Spec
    from vibro.results.designs import DesignResult

__all__ = ["design_report"]

_REGIMES: Final = (Regime.FORWARD_SLIP, Regime.BACK_SLIP, Regime.HOPPING)


def design_report(spec: Spec, result: DesignResult, chosen: Chosen | None) -> str:
    """Write the answer to a question for people.

    Parameters
    ----------
    spec : Spec
        The question.
    result : DesignResult
        Its answer.
    chosen : Chosen or None
        The design to report in detail; None if no design guarantees a speed.

    Returns
    -------
    str
        The answer first, then what other regimes would give. Settings with all their digits, so that typed in
        they hold; other numbers with at most six, and bounds among them rounded so that they hold too.
    """
    highest = spec.goal.highest_regime
    parts = [aligned(question_facts(spec, result), right=False)]
    if not result.met:
        parts.append(aligned(closest_rows(spec, result)))
    parts += [
        f"{drive.name}: {drive_limits(drive)}\n{_table(drive, spec, result, [highest])}"
        for drive in spec.drives
    ]
    if chosen is not None:
        parts += [
            aligned(chosen_facts(spec, chosen, met=result.met), right=False),
            aligned(load_rows(chosen)),
            aligned(cost_rows(chosen.costs, size_of(chosen.design))),
        ]
    answered = {design.highest_regime for design in result.designs}
    if others := [regime for regime in _REGIMES if regime is not highest and regime.label in answered]:
        parts.append("Other regimes than the goal's, for comparison (--only goal leaves them out):")
        parts += [f"{drive.name}\n{_table(drive, spec, result, others)}" for drive in spec.drives]
    parts += ["\n".join(lines)] if (lines := remarks(result)) else []
    return "\n\n".join(parts)


def _table(drive: Drive, spec: Spec, result: DesignResult, regimes: Sequence[Regime]) -> str:
    """Write the designs of a drive within some regimes, below the title of each."""
    table = design_table(drive, spec, result, regimes)
    designs = [[f"  {name}", *cells] for _, rows in table.groups for name, *cells in rows]
    lines = iter(aligned([["", *table.heads], ["", *table.units], *designs]).splitlines())
    written = [next(lines), next(lines)] if designs else []
    for title, rows in table.groups:
        written.append(title)
        written += [next(lines) for _ in rows]
    return "\n".join(written)
