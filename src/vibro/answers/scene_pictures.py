"""The pictures on the page about a scene: maps around it, and its motion over time."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Final

import numpy as np

from vibro.answers.drawing import history_picture
from vibro.axes import Axis
from vibro.core.codes import Status
from vibro.errors import VibroError
from vibro.motion.histories import simulate
from vibro.plots import map_figures
from vibro.quantities import RATES, SCALE, SWEPT
from vibro.sweeps.run import sweep_picture

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from vibro.answers.scene import OneScene
    from vibro.sweeps.grid import Grid
    from vibro.sweeps.request import Request

_AROUND: Final = (0.25, 2.5)  # [1] ends of the map's axes over the scene's own values
_CYCLES: Final = 3.0  # of the drive that are drawn
_FOLLOWED: Final = 1000.0  # cycles within which the motion is expected to repeat
_SIZES: Final = ("setting", "amplitude", *RATES, "along_amplitude", "normal_amplitude", SCALE)


def scene_pictures(request: Request, grid: Grid, one: OneScene) -> dict[str, Figure]:
    """Draw a scene, by what each picture shows.

    Parameters
    ----------
    request : Request
        The scene as it was given.
    grid : Grid
        Its single cell.
    one : OneScene
        The same, solved.
    """
    return {**_maps(request, grid), **_motion(request, one)}


def _maps(request: Request, grid: Grid) -> dict[str, Figure]:
    """Draw what the drive would do at other sizes and frequencies."""
    sizes = [name for name in _SIZES if grid.fixed.get(name)]
    names = *(sizes[:1] or ["static_friction"]), "frequency"
    own: dict[str, float] = {name: grid.fixed[name] for name in SWEPT if name in names}
    ends = {name: np.multiply(_AROUND, value) for name, value in own.items()}
    if "setting" in own:  # 100 % is all of it
        ends["setting"] = ends["setting"].clip(max=max(100.0, own["setting"]))
    axes = {name: Axis(name, values, "linear") for name, values in ends.items()}
    fixed = {name: value for name, value in grid.fixed.items() if name not in axes}
    around = replace(grid, axes=axes, fixed=fixed, arrivals=False, starts=None)
    figures = map_figures(sweep_picture(around, {}, own, request.name or "Scene"), ["regime", "speed"])
    over = " and ".join(axis.label for axis in around.given_axes.values())
    shows = {"regime": "What the part does", "speed": "How fast it is conveyed"}
    return {f"{shows[name]} over {over}": figure for name, figure in figures.items()}


def _motion(request: Request, one: OneScene) -> dict[str, Figure]:
    """Draw three cycles of the steady motion, or the first three where none is known."""
    try:
        history = simulate(one.scene, cycles=_FOLLOWED)
    except VibroError:  # it runs away, or its motion is not determined
        return {}
    period = 1.0 / float(one.scene.frequency)
    since, shows = history.settles_at, "Three cycles of the steady motion"
    steady = one.status.answered and one.status is not Status.AVERAGED
    if not steady or not since + _CYCLES * period <= _FOLLOWED * period:
        since, shows = 0.0, "The first three cycles from rest"
    history = simulate(one.scene, cycles=since / period + _CYCLES)
    flies = any(p.kind == "H" and p.end > since for p in history.phases)
    panels = "trough,velocity,position" + ",gap" * flies
    title, window = request.name or "Motion", (since, history.end)
    return {shows: history_picture(history, window, title, request.given_values, panels, part="")}
