"""The report on the operating point, and command and scene file that make the same map."""

from __future__ import annotations

import json
import math
import shlex
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, Final

from vibro.answers.answer import uncertain
from vibro.answers.scene import OneScene, scene_answer
from vibro.explore.bands import bands_if, guaranteed_text
from vibro.explore.controls import DRIVEN, GIVEN
from vibro.explore.markup import tag
from vibro.explore.state import HEIGHT, WIDTH, typed_number
from vibro.files.motions import harmonic_lists
from vibro.plots.style import REGIME_COLOURS
from vibro.quantities import DEFAULTS, MACHINE, QUANTITIES
from vibro.sweeps.grid import Grid
from vibro.sweeps.machines import check_operating, points_of
from vibro.sweeps.run import sweep_blocks

if TYPE_CHECKING:
    from vibro.explore.state import State

__all__ = ["command_of", "point_of", "scene_text"]

_APART: Final = "For the operating point's own friction: these commands and scene files have no bands."
_SAVED: Final = "scene.toml"  # as the page calls it
_IN_FILE: Final = {
    GIVEN: f"The command reads the motion from the scene file, saved as {_SAVED}.",
    DRIVEN: f"The command reads the machine from the scene file, saved as {_SAVED}.",
}


def point_of(state: State) -> dict[str, Any]:
    """Return the report on the operating point.

    Parameters
    ----------
    state : State
        State of the page.

    Returns
    -------
    dict
        JSON values: ``state`` in full; ``title``, and of that the ``regime`` with its ``colour`` and the
        ``speed``; ``tables`` with what ``vibro solve`` prints and warns of, as HTML; ``guaranteed``, for all
        bodies in the bands, and whether their least speed is ``unproved``; ``bands``, with kinetic friction
        given by itself, and following static friction; ``command`` and ``toml``, which make the same map, and
        ``apart``, how their maps differ from it, or what the command needs.
    """
    point = state.point
    grid = Grid({}, point.fixed, point.length, motion=point.motion, machine=point.machine)
    (block,) = sweep_blocks(grid)
    warnings = []
    if grid.machine is not None:
        check_operating(grid.machine, block.values)
        warnings = points_of(grid.machine, block.values).remarks()
    one = OneScene(block)
    answer = scene_answer(one, grid, {}, {}, every=True)
    mean, error = one.result("mean_velocity"), one.result("mean_velocity_error")
    speed = "unknown" if math.isnan(mean) else f"{uncertain(mean, error, 6)} mm/s"
    guaranteed, is_open = guaranteed_text(state)
    return {
        "state": dict(state.texts),
        "title": ", ".join(filter(None, (one.regime.label, speed))),
        "colour": REGIME_COLOURS.get(one.regime, "transparent"),
        "speed": speed,
        "regime": one.regime.label,
        "tables": "".join(tag("p", f"Warning: {text}.", class_="warning") for text in warnings)
        + _table("What the body does", [(), *((fact.label, fact.text) for fact in answer.facts)])
        + "".join(_table(table.title, table.texts) for table in answer.tables)
        + "".join(tag("p", note) for note in answer.notes),
        "guaranteed": guaranteed,
        "unproved": is_open,
        "bands": [bands_if(state, follows=follows) for follows in (False, True)],
        "command": command_of(state),
        "apart": " ".join([*filter(None, (_IN_FILE.get(state.texts["drive"]), _APART * bool(state.bands)))]),
        "toml": scene_text(state),
    }


def command_of(state: State) -> str:
    """Return the command line that makes the same map, of the same cells."""
    words = ["vibro", "map", *[_SAVED] * state.is_given]
    for name, text in _given(state).items() if not state.is_given else ():
        words += QUANTITIES[name].typed(text).split(" ", 1)
    words += ["--x", state.x.quantity.name, "--y", state.y.quantity.name]
    words += ["--show", state.view] if state.view in ("impact", "flight") else []
    words += ["--speed", typed_number(state.target)] if state.target is not None else []
    return shlex.join([*words, "-o", f"out/{state.point.name or 'map'}"])


def scene_text(state: State) -> str:
    """Return the scene file that makes the same map, of the same cells."""
    given = _given(state)
    point = state.point.fixed | ({} if state.point.length is None else {"trough_length": state.point.length})
    lists, others = harmonic_lists(point) if state.is_given else ({}, point)
    scene = [f"{key} = [{', '.join(map(typed_number, values))}]" for key, values in lists.items()]
    scene += [
        f"{QUANTITIES[name].column} = {typed_number(value)}"
        for name, value in others.items()
        if name not in MACHINE
    ]
    moved = _moved_of_machine(state)
    # Another spring pack stands here: a machine's own may be the one that it was calibrated with.
    swept = [
        f'{QUANTITIES[name].column} = "{text}"' if ":" in text else f"{QUANTITIES[name].column} = {text}"
        for name, text in given.items()
        if ":" in text or name in ("friction_ratio", *moved.intersection(["natural"]))
    ]
    motion = state.point.motion.table if state.point.motion else {}
    machine = dict(state.point.machine.table) if state.point.machine else {}
    for name in moved - {"natural"}:
        value = point[name]
        machine[QUANTITIES[name].column] = int(value) if value == int(value) else value
    tables = ["[scene]", *scene, ""]
    for name, table in (("motion", motion), ("machine", machine)):
        if table:
            tables += [f"[{name}]", *(f"{key} = {_toml(value)}" for key, value in table.items()), ""]
    return "\n".join([*tables, "[map]", *swept, ""])


def _moved_of_machine(state: State) -> set[str]:
    """Name what has another value than the machine's table gives it."""
    machine, values = state.point.machine, state.point.fixed
    if machine is None:
        return set()
    return {name for name in MACHINE if name in values and values[name] != machine.own.get(name)}


def _toml(value: object) -> str:
    """Write a value of a scene file."""
    if isinstance(value, str):
        return json.dumps(value, ensure_ascii=False)
    if isinstance(value, Mapping):
        return f"{{ {', '.join(f'{key} = {_toml(inner)}' for key, inner in value.items())} }}"
    if isinstance(value, Sequence):
        return f"[{', '.join(map(_toml, value))}]"
    return str(value)


def _given(state: State) -> dict[str, str]:
    """Return every quantity of the map without its usual value, as it is typed: ranges with counts."""
    grid = state.grid()
    given = {name: typed_number(value) for name, value in grid.fixed.items() if value != DEFAULTS.get(name)}
    for spec, count in ((state.x, WIDTH), (state.y, HEIGHT)):
        ends = ":".join(map(typed_number, spec.values))
        given[spec.quantity.name] = f"{ends}:{count}" + ":log" * spec.log
    if grid.length is not None:
        given["trough_length"] = typed_number(grid.length)
    return {name: given[name] for name in QUANTITIES if name in given}


def _table(caption: str, rows: Sequence[Sequence[str]]) -> str:
    """Write a table, its first row as heads of columns; empty without other rows."""
    head, *body = rows or [()]
    if not body:
        return ""
    heads = tag("thead", tag("tr", *(tag("th", text, scope="col") for text in head)))
    lines = [
        tag("tr", tag("th", name, scope="row"), *(tag("td", text) for text in texts)) for name, *texts in body
    ]
    parts = [tag("caption", caption), *([heads] if head else []), tag("tbody", *lines)]
    return tag("table", *parts, class_="numeric" if head else "facts")
