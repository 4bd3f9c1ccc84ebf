"""The report on one scene."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import TYPE_CHECKING, Final, NamedTuple

from vibro.core.codes import Status
from vibro.errors import VibroError
from vibro.explore.state import initial_state
from vibro.files.motions import harmonic_lists
from vibro.inverse.friction_windows import MOST_FRICTION
from vibro.motion.histories import simulate
from vibro.motion.trace import trace
from vibro.plots import map_figures
from vibro.plots.history import choose_panels, history_figure
from vibro.quantities import LENGTH, MACHINE, QUANTITIES, SCALE, STANDS_FOR, counted_harmonics
from vibro.reports.change_texts import change_texts
from vibro.reports.page import Page, Section, Table
from vibro.reports.pictures import picture
from vibro.reports.scene_texts import (
    AS_STATED,
    LIMITS,
    MEANINGS,
    REGIMES,
    answer_text,
    assumptions,
    kept_rows,
    motion_rows,
    next_text,
    pattern_text,
    speed_per_minute,
    transition_texts,
    traverse_text,
    valued,
)
from vibro.sweeps.derived import WITH_STROKE
from vibro.sweeps.machine_facts import machine_warnings
from vibro.sweeps.one_scene import (
    OneScene,
    facts_of,
    machine_lines,
    number,
    phase_rows,
    throughput_text,
)
from vibro.sweeps.run import sweep_picture
from vibro.waveforms import PiecewiseMotion

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping

    from matplotlib.figure import Figure

    from vibro.files.machines import GivenMachine
    from vibro.results.history import History
    from vibro.results.sweep import Block
    from vibro.sweeps.grid import Grid
    from vibro.sweeps.request import Request

__all__ = ["SceneReport", "scene_page"]

_CYCLES: Final = 3.0  # of the drive that are drawn
_FOLLOWED: Final = 1000.0  # cycles within which the motion is expected to repeat
_SAMPLES: Final = 200  # a cycle
_PANELS: Final = "trough,velocity,position"
_MOST_LETTERS: Final = 12  # of a pattern
_MOST_PHASES: Final = 8  # in a table that still fits on the page
_HELD: Final = (
    "The amplitude is held at {} here. The machine and its filling change it with most inputs:"
    " a set-up sheet tells what that does."
)
_OF_MACHINES: Final = (
    "A linear machine, and a rigid trough that moves as a sine along its line, the same over its whole"
    " length. The filling acts by the first harmonic of its force."
)
_MAPS: Final = {
    "regime": "What the part does",
    "speed": "How fast it is conveyed",
}


class SceneReport(NamedTuple):
    """What a report on a scene is about.

    Attributes
    ----------
    point : Request
        The operating point.
    swept : Request
        The same with the axes of the scene file's ``[map]``, if any.
    given : frozenset of str
        Names of the quantities that were given; of a stroke the amplitude.
    part : mapping of str to float
        As for ``throughput_text``.
    grid : Grid
        Of the operating point.
    block : Block
        Its solution.
    command : str
        That makes the page.
    """

    point: Request
    swept: Request
    given: frozenset[str]
    part: Mapping[str, float]
    grid: Grid
    block: Block
    command: str


def scene_page(report: SceneReport) -> Page:
    """Write the report on one scene.

    Parameters
    ----------
    report : SceneReport
        What it is about.

    Returns
    -------
    Page
        Numbers that are unknown are said to be so.
    """
    one = OneScene(report.block)
    facts = dict(facts_of(one, report.grid))
    return Page(
        title=report.point.name or "Scene",
        kind="Report on a vibratory conveyor",
        answer=answer_text(one),
        highlights=[*_highlights(one, facts, report.part)],
        sections=[*_sections(report, one, facts)],
        command=report.command,
    )


def _highlights(
    one: OneScene, facts: Mapping[str, str], part: Mapping[str, float]
) -> Iterator[tuple[str, str, str]]:
    yield "Mean speed", facts["mean speed"], speed_per_minute(one)
    if told := throughput_text(one, part):
        rate, _, rest = told.partition(", ")
        yield "Throughput", rate.removesuffix(" at most"), rest and "at most"
    yield "Regime", one.regime.label or "none", pattern_text(one.pattern)
    when, what = next_text(one)
    if when:
        yield "Next", what, when
    if "impact speed" in facts:
        yield "Landing", facts["impact speed"], f"in flight {facts['in flight']}"


def _sections(report: SceneReport, one: OneScene, facts: Mapping[str, str]) -> Iterator[Section]:
    yield Section(
        title="Operating point",
        is_half=True,
        texts=[_questioned(doubt) for doubt in report.point.doubts()],
        tables=[Table("The drive, the trough and the part", (), [*_inputs(report, one, facts)])],
    )
    if report.grid.machine is not None:
        yield _machine(report.grid.machine, one, report.grid)
    yield Section(
        title="What the part does",
        is_half=True,
        tables=[Table("Steady motion", (), [*_results(report, one, facts)])],
    )
    if said := transition_texts(one, of_machine=report.grid.machine is not None):
        has_frequencies = report.grid.machine is None
        has_frequencies &= not any(math.isnan(t.frequency) for t in one.transitions())
        at = f"; the frequency is that at the present {one.size}" if has_frequencies else ""
        yield Section(
            title="What comes next, and how far it is",
            is_half=True,
            texts=[f"The drive is scaled as a whole here{at}."],
            items=said,
        )
    held = "" if report.grid.machine is None else _HELD.format(number(one.given["amplitude"], LENGTH.unit))
    yield _changes(one, held)
    yield _kept(one, held)
    yield _maps(report, one)
    yield _motion(report, one)
    phases = phase_rows(one)
    if 1 < len(phases) <= _MOST_PHASES + 1:
        table = Table("Times since the drive passed its middle", phases[0], phases[1:], True)
        yield Section(title="One steady cycle", is_half=True, tables=[table])
    yield Section(
        title="What was assumed",
        is_half=True,
        items=assumptions(one.given, report.given)
        or ["Nothing: trough angle, gravity and restitution were given."],
    )
    limits = [_OF_MACHINES if text == AS_STATED and report.grid.machine else text for text in LIMITS]
    yield Section(title="Limits of the model", items=limits)


def _machine(machine: GivenMachine, one: OneScene, grid: Grid) -> Section:
    """Tell from what the amplitude follows, and what a reader must know of that."""
    warnings = [f"{text[:1].upper()}{text[1:]}." for text in machine_warnings(machine, one.values)]
    table = Table("The amplitude follows from these", (), machine_lines(one, grid))
    return Section(title="The machine and its filling", texts=warnings, tables=[table])


def _questioned(doubt: str) -> str:
    said, _, remedy = doubt.partition(": ")
    return f"Is this meant? {said[:1].upper()}{said[1:]}; {remedy}."


def _inputs(report: SceneReport, one: OneScene, facts: Mapping[str, str]) -> Iterator[tuple[str, ...]]:
    """List the quantities of the scene, and what follows from them at once."""
    shown, lists = one.given, {} if report.point.motion is None else report.point.motion.table
    if counted_harmonics(one.given):
        lists, shown = harmonic_lists(one.given)
    for key, told in motion_rows(lists):
        yield key, told, "given"
    for name, value in shown.items():
        quantity = QUANTITIES[name]
        if report.grid.machine is not None and name in MACHINE:  # shown with the machine
            continue
        if name == SCALE and value == 1.0:
            continue
        source = "given" if STANDS_FOR.get(name, name) in report.given else "assumed"
        if name == "kinetic_friction" and "friction_ratio" in one.given:
            source = "from the ratio"
        if report.grid.machine is not None and name == "amplitude":
            yield quantity.label, number(value, quantity.unit), "of the machine"
            continue
        yield quantity.label, valued(name, value), source
    if report.point.length is not None:
        yield "trough length", valued("trough_length", report.point.length), "given"
    if "stroke" in shown:
        yield "amplitude", valued("amplitude", 0.5 * shown["stroke"]), "half of the stroke"
    else:
        yield "stroke", number(one.value(WITH_STROKE), LENGTH.unit), "peak to peak, at most"
    size, _, where = facts["acceleration"].partition(" g ")
    yield "acceleration", f"{size} g", where.replace("A w^2/g", "Aω²/g")
    size, _, where = facts["throw number"].partition(" ")
    yield "throw number", size, where.strip("()")


def _results(report: SceneReport, one: OneScene, facts: Mapping[str, str]) -> Iterator[tuple[str, ...]]:
    """List the results of the motion, with their meanings."""
    yield "regime", one.regime.label or "none", REGIMES[one.regime]
    if one.pattern:
        said = pattern_text(one.pattern)
        yield "phases", said, f"Pattern {one.pattern}." if len(one.pattern) <= _MOST_LETTERS else ""
    if "status" in facts:
        yield "status", one.status.label, f"{one.status.message}."
    for name, told in facts.items():
        if name in MEANINGS:
            per_minute = speed_per_minute(one) if name == "mean speed" else ""
            is_none = name == "mean speed" and not per_minute
            meaning = "" if is_none else MEANINGS[name]
            yield name, f"{told} = {per_minute}" if per_minute else told, meaning
    if report.point.length is not None:
        yield "traverse time", *traverse_text(one)
    if told := throughput_text(one, report.part):
        yield "throughput", told, MEANINGS["throughput"]


def _maps(report: SceneReport, one: OneScene) -> Section:
    """Draw what the drive would do elsewhere, over the axes with which ``vibro explore`` begins."""
    point = initial_state(report.point).point
    grid = replace(initial_state(report.swept), point=point).grid()
    grid = replace(grid, in_stroke=report.point.in_stroke)
    own = {**grid.fixed, **{name: point.fixed.get(name, 1.0) for name in grid.axes}}
    if "friction_ratio" in grid.axes:
        own["friction_ratio"] = point.fixed["kinetic_friction"] / point.fixed["static_friction"]
    names = " and ".join(axis.label for axis in grid.told_axes.values())
    inside = all(axis.values[0] <= own[name] <= axis.values[-1] for name, axis in grid.axes.items())
    mark = "The circle is the operating point." if inside else "The operating point lies outside."
    result = sweep_picture(grid, {}, own, report.point.name or "")
    figures = map_figures(result, [*_MAPS])
    return Section(
        title=f"Map over {names}",
        texts=[f"All else is as at the operating point. {mark}"],
        pictures=[
            picture(
                figure,
                name,
                f"{_MAPS[name]} over {names}; at the operating point {one.regime.label or 'no regime'}.",
                f"{_MAPS[name]} over {names}.",
            )
            for name, figure in figures.items()
        ],
    )


def _changes(one: OneScene, held: str) -> Section:
    texts, rows = change_texts(one)
    texts = [*([held] if held and rows else []), *texts]
    caption = "One change at a time, solved again" + ", with standard errors" * any(
        "+-" in r[1] for r in rows
    )
    tables = [Table(caption, rows[0], rows[1:], len(rows[0]) == 2)] if rows else []
    return Section(title="What the speed depends on", is_half=True, texts=texts, tables=tables)


def _kept(one: OneScene, held: str) -> Section:
    title, rows = "What keeps the regime", kept_rows(one)
    if not rows:
        why = "the part gains speed in every cycle" if one.runs else one.status.message
        return Section(title=title, texts=[f"There is no steady motion that could be kept: {why}."])
    notes = [held] if held else []
    notes += [
        "Exact: by closed forms or proofs, to rounding; ends are rounded inwards. Searched: others"
        " may be missed between the values that were tried. Static friction is looked at up to"
        f" {MOST_FRICTION:g}."
    ]
    if isinstance(one.scene.motion, PiecewiseMotion):
        notes.append(
            "The file gives accelerations, which are the same at any frequency: so is the regime,"
            " while strokes and speeds change."
        )
    caption = f"One at a time, all else being as it is: {one.regime.label} stays"
    return Section(title=title, tables=[Table(caption, rows[0], rows[1:])], notes=notes)


def _motion(report: SceneReport, one: OneScene) -> Section:
    """Draw three cycles of the steady motion, or the first three where none is known."""
    title = "The motion over three cycles of the drive"
    try:
        history = simulate(one.scene, cycles=_FOLLOWED)
    except VibroError as exc:
        return Section(title=title, texts=[f"It cannot be drawn: {exc}."])
    frequency = float(one.scene.frequency)
    first = history.settles_at * frequency
    if first + _CYCLES > _FOLLOWED or not one.status.answered:
        first, told = 0.0, "The first three cycles from rest"
        told += ", of irregular motion." if one.status is Status.AVERAGED else "."
    else:
        since = f"{1e3 * history.settles_at:.4g} ms"
        told = f"Three cycles of the steady motion, which begins {since} after a start from rest."
    history = simulate(one.scene, cycles=first + _CYCLES)
    alt = f"Motion of trough and part over time: {pattern_text(one.pattern) or 'no steady cycle'}."
    return Section(
        title=title,
        pictures=[picture(_history(history, first / frequency, report), "motion", alt, told)],
    )


def _history(history: History, since: float, report: SceneReport) -> Figure:
    phases = [p for p in history.phases if p.end > since]
    flies = any(p.kind == "H" for p in phases)
    rows = trace(history, since=since, until=history.end, samples_per_cycle=_SAMPLES, both_sides=True)
    panels = choose_panels(_PANELS + ",gap" * flies, flies=flies)
    title, period = report.point.name or "Motion", 1.0 / float(history.scene.frequency)
    return history_figure(phases, rows, panels, title, report.point.told, period=period)
