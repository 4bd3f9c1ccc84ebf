"""The report on the answer to a design question."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any, Final

from vibro.inverse.pictured import setting_fields, speed_band
from vibro.plots.design import design_figures
from vibro.quantities import QUANTITIES
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
from vibro.reports.page import Page, Section, Table
from vibro.reports.pictures import picture
from vibro.reports.scene_texts import LIMITS, assumptions
from vibro.sweeps.one_scene import bound

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping

    from vibro.inverse.designs import Chosen
    from vibro.inverse.specs import Spec
    from vibro.results.designs import DesignResult

__all__ = ["design_page"]

_PICTURES: Final = {
    "speed": "Guaranteed speed over amplitude and frequency, and which settings meet the goal",
    "band": "Speeds from the slowest to the fastest part over the amplitude",
}
_HEADS: Final = {
    "empty": "amplitude, empty",
    "least": "amplitude, least",
    "most": "amplitude, most",
    "accel.": "acceleration",
    "guaranteed": "every part at least",
    "proved above": "proved above",
    "nominal": "part in the middle",
    "largest": "every part at most",
}


def design_page(
    spec: Spec, result: DesignResult, chosen: Chosen | None, tables: Mapping[str, Any], command: str
) -> Page:
    """Write the report on the answer to a design question.

    Parameters
    ----------
    spec, result, chosen : Spec, DesignResult, Chosen or None
        As for ``design_report``.
    tables : mapping
        The question as its file gives it: what is missing there was assumed.
    command : str
        That makes the page.
    """
    question = question_facts(spec, result)
    facts = dict(question)
    met = f"The goal is met by: {facts['met by']}." if result.met else "No drive meets the goal."
    return Page(
        title=spec.name or "Design",
        kind="Report on the design of a vibratory conveyor",
        answer=f"{met} The goal is {facts['goal']}.",
        highlights=[*_highlights(chosen, met=result.met)],
        sections=[*_sections(spec, result, chosen, question, tables)],
        command=command,
    )


def _highlights(chosen: Chosen | None, *, met: bool) -> Iterator[tuple[str, str, str]]:
    if chosen is None:
        yield "Guaranteed", "nothing", "by no setting of any drive"
        return
    design = chosen.design
    yield "Design" if met else "Closest", f"{design.drive}, {design.design}", ""
    speed = design.speed_min_mm_s
    told = "nothing" if speed is None else bound(speed, "mm/s", upper=False)
    yield "Every part at least", told, "" if speed is None else bound(0.06 * speed, "m/min", upper=False)
    if design.traverse_time_max_s is not None:
        yield "Over the trough", f"at most {bound(design.traverse_time_max_s, 's', upper=True)}", ""


def _sections(
    spec: Spec,
    result: DesignResult,
    chosen: Chosen | None,
    question: list[tuple[str, str]],
    tables: Mapping[str, Any],
) -> Iterator[Section]:
    drives = [(f"drive: {drive.name}", drive_limits(drive)) for drive in spec.drives]
    yield Section(
        title="Question", tables=[Table("Goal, parts, trough and drives", (), [*question, *drives])]
    )
    if not result.met:
        head, *rows = closest_rows(spec, result)
        yield Section(
            title="Why no drive meets the goal",
            texts=['"Set by" names the constraint that limits each drive.'],
            tables=[Table("Largest guaranteed speed of each drive", ("drive", *head[1:]), rows)],
        )
    shown = tuple(d for d in result.designs if d.highest_regime == spec.goal.highest_regime.label)
    yield Section(
        title="Designs",
        tables=[*_designs(spec, result)],
        notes=remarks(replace(result, designs=shown)),
    )
    if chosen is not None:
        size = size_of(chosen.design)
        loads, costs = load_rows(chosen), cost_rows(chosen.costs, size)
        yield Section(
            title="What holds for every part" if result.met else "The closest design",
            tables=[Table("The design that is shown", (), chosen_facts(spec, chosen, met=result.met))],
        )
        yield Section(
            title="How far other motions are",
            is_half=True,
            texts=["Above 1 it has happened; 0.8 means: at 1/0.8 = 1.25 times the amplitude."],
            tables=[
                Table("Load now over that at which it begins", ("event", "load now / then"), loads[1:], True)
            ],
        )
        yield Section(
            title="What the nominal speed depends on",
            is_half=True,
            tables=[
                Table("Small changes, one at a time", ("1 % more", "changes the speed by"), costs[1:], True)
            ],
        )
        figures = design_figures(spec, chosen, setting_fields(spec, chosen), speed_band(spec, chosen))
        yield Section(
            title="Settings around it",
            pictures=[
                picture(
                    figures[name],
                    name,
                    f"{what}; the design is marked.",
                    f"{what}. The circle is the design.",
                )
                for name, what in _PICTURES.items()
            ],
        )
    yield Section(title="What was assumed", items=_assumed(spec, tables))
    yield Section(title="Limits of the model", items=LIMITS)


def _designs(spec: Spec, result: DesignResult) -> Iterator[Table]:
    """Write the designs of every drive within the goal's highest regime."""
    for drive in spec.drives:
        heads, units, groups = design_table(drive, spec, result, [spec.goal.highest_regime])
        ((title, rows),) = groups
        named = [f"{_HEADS.get(head, head)} {unit}".rstrip() for head, unit in zip(heads, units, strict=True)]
        yield Table(f"{drive.name}: {title}", ("design", *named) if rows else (), rows)


def _assumed(spec: Spec, tables: Mapping[str, Any]) -> list[str]:
    scene = tables.get("scene", {})
    values = {"gravity": spec.gravity, "restitution": spec.restitution, "trough_angle": 0.0}
    given = frozenset(name for name in values if QUANTITIES[name].column in scene)
    said = assumptions(values, given)
    if "drift" not in tables:
        said.append("Drive and trough stay as set: no drift was given.")
    return said or ["Nothing: trough angle, gravity, restitution and drift were given."]
