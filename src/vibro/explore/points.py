"""The report on the operating point, and command and scene file that make the same map."""

from __future__ import annotations

import shlex
from typing import TYPE_CHECKING, Any, Final

from vibro.explore.bands import bands_if, guaranteed_text
from vibro.explore.markup import tag
from vibro.explore.state import HEIGHT, WIDTH, number_text
from vibro.files.motions import harmonic_lists
from vibro.plots.style import REGIME_COLOURS
from vibro.quantities import DEFAULTS, QUANTITIES
from vibro.sweeps.grid import Grid
from vibro.sweeps.one_scene import OneScene, beginnings, estimate, facts_of, phase_rows
from vibro.sweeps.run import sweep_blocks

if TYPE_CHECKING:
    from collections.abc import Sequence

    from vibro.explore.state import State

__all__ = ["command_of", "point_of", "scene_text"]

_APART: Final = "Of the operating point's own friction: commands and scene files know no bands."
_SAVED: Final = "scene.toml"  # as the page calls it
_IN_FILE: Final = f"The motion has no options: the command reads the scene file, saved as {_SAVED}."


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
        ``speed``; ``tables`` with what ``vibro solve`` prints, as HTML; ``guaranteed``, for all bodies in the
        bands, and whether their least speed is ``unproved``; ``bands``, with kinetic friction given by
        itself, and following static friction; ``command`` and ``toml``, which make the same map, and
        ``apart``, how their maps differ from it, or what the command needs.
    """
    grid = Grid({}, state.point.fixed, state.point.length, motion=state.point.motion)
    (block,) = sweep_blocks(grid)
    one = OneScene(block)
    facts = facts_of(one, grid)
    if state.point.length is not None:
        time = one.traverse_time
        told = one.why_never() if time is None else estimate(time, time * one.relative_error, "s")
        facts.append(("traverse time", told))
    speed = dict(facts).get("mean speed", "")
    guaranteed, is_open = guaranteed_text(state)
    return {
        "state": dict(state.texts),
        "title": ", ".join(filter(None, (one.regime.label, speed))),
        "colour": REGIME_COLOURS.get(one.regime, "transparent"),
        "speed": speed,
        "regime": one.regime.label,
        "tables": _table("What the body does", [(), *facts])
        + _table("What begins when", beginnings(one))
        + _table("Phases of a steady cycle", phase_rows(one)),
        "guaranteed": guaranteed,
        "unproved": is_open,
        "bands": [bands_if(state, follows=follows) for follows in (False, True)],
        "command": command_of(state),
        "apart": _IN_FILE if state.is_given else _APART if state.bands else "",
        "toml": scene_text(state),
    }


def command_of(state: State) -> str:
    """Return the command line that makes the same map, of the same cells."""
    words = ["vibro", "map", *[_SAVED] * state.is_given]
    for name, text in _given(state).items() if not state.is_given else ():
        option = QUANTITIES[name].options[0]
        # an option of two dashes may begin its value with one only behind =
        words += [f"{option}={text}"] if option.startswith("--") else [option, text]
    words += ["--x", state.x.quantity.name, "--y", state.y.quantity.name]
    words += ["--show", state.view] if state.view in ("impact", "flight") else []
    words += ["--speed", number_text(state.target)] if state.target is not None else []
    return shlex.join([*words, "-o", f"out/{state.point.name or 'map'}"])


def scene_text(state: State) -> str:
    """Return the scene file that makes the same map, of the same cells."""
    given = _given(state)
    point = state.point.fixed | ({} if state.point.length is None else {"trough_length": state.point.length})
    lists, others = harmonic_lists(point) if state.is_given else ({}, point)
    scene = [f"{key} = [{', '.join(map(number_text, values))}]" for key, values in lists.items()]
    scene += [f"{QUANTITIES[name].column} = {number_text(value)}" for name, value in others.items()]
    swept = [
        f'{QUANTITIES[name].column} = "{text}"' if ":" in text else f"{QUANTITIES[name].column} = {text}"
        for name, text in given.items()
        if ":" in text or name == "friction_ratio"
    ]
    motion = state.point.motion.table if state.point.motion else {}
    moved = ["[motion]", *(f"{key} = {value}" for key, value in motion.items()), ""] if motion else []
    return "\n".join(["[scene]", *scene, "", *moved, "[map]", *swept, ""])


def _given(state: State) -> dict[str, str]:
    """Return every quantity of the map without its usual value, as it is typed: ranges with counts."""
    grid = state.grid()
    given = {name: number_text(value) for name, value in grid.fixed.items() if value != DEFAULTS.get(name)}
    for spec, count in ((state.x, WIDTH), (state.y, HEIGHT)):
        ends = ":".join(map(number_text, spec.values))
        given[spec.quantity.name] = f"{ends}:{count}" + ":log" * spec.log
    if grid.length is not None:
        given["trough_length"] = number_text(grid.length)
    return {name: given[name] for name in QUANTITIES if name in given}


def _table(caption: str, rows: Sequence[tuple[str, ...]]) -> str:
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
