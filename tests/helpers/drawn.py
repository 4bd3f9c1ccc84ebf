"""What tests of pictures look at: the paper's scene swept, and the artists of its pictures."""

from __future__ import annotations

import math
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any
from unittest import mock

import numpy as np
import pytest
from matplotlib.colors import to_rgb
from matplotlib.layout_engine import ConstrainedLayoutEngine
from matplotlib.path import Path as Outline

from vibro import Regime, Scene
from vibro.axes import parse_axis
from vibro.plots import map_figures
from vibro.plots.style import _RC
from vibro.plots.view import choose_view
from vibro.quantities import QUANTITIES, STANDS_FOR
from vibro.sweeps import run
from vibro.sweeps.grid import Grid

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping

    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from matplotlib.patches import PathPatch
    from matplotlib.text import Text
    from numpy.typing import NDArray

    from vibro.results.sweep import SweepResult

    Floats = NDArray[np.float64]


GRAVITY = 9.81
NUT: dict[str, object] = {
    "amplitude": 1,
    "frequency": 15,
    "drive_angle": 20,
    "static_friction": 0.74,
    "kinetic_friction": 0.57,
    "trough_angle": 0,
}
OWN = {name: float(str(value)) for name, value in NUT.items()}


@contextmanager
def unarranged() -> Iterator[None]:
    """Leave the axes of pictures where they happen to be, which takes half of the time."""
    with mock.patch.object(ConstrainedLayoutEngine, "execute"):
        yield


@contextmanager
def coarse_pictures() -> Iterator[None]:
    """Draw pictures from few values, with few pixels and where axes happen to be."""
    with unarranged(), pytest.MonkeyPatch.context() as patch:
        patch.setattr("vibro.sweeps.run._RESOLVED", {1: 501, 2: 61, 3: 41})
        patch.setitem(_RC, "savefig.dpi", 40)
        yield


def sweep(
    own: Mapping[str, float] | None = None,
    length: float | None = None,
    at: Mapping[str, float] | None = None,
    flight: bool = True,
    points: int | None = None,
    **changes: object,
) -> SweepResult:
    """Solve what pictures show of the paper's scene with some quantities changed or swept.

    Axes are resolved into as many points as pictures have, or fewer where a test looks at no edges.
    """
    texts = {**NUT, "gravity": GRAVITY, "restitution": 0, **changes}
    for name in STANDS_FOR.keys() & changes.keys():
        del texts[STANDS_FOR[name]]
    specs = {name: parse_axis(str(texts[name]), QUANTITIES[name]) for name in QUANTITIES if name in texts}
    axes = {name: spec.axis(20) for name, spec in specs.items() if spec.varies}
    fixed = {name: spec.value for name, spec in specs.items() if not spec.varies}
    view = choose_view(axes, at=at, fixed=fixed)
    counts = {} if points is None else dict.fromkeys(run._RESOLVED, points)
    with mock.patch.dict(run._RESOLVED, counts):
        return run.sweep_picture(Grid(axes, fixed, length, flight=flight), view.drawn, own, "a sweep")


def pictures_of(result: SweepResult) -> dict[str, Figure]:
    """Draw the pictures of a sweep that are drawn without being asked for."""
    is_map = choose_view(result.axes, fixed=result.fixed).y is not None
    return map_figures(result, ["regime"] * is_map + ["speed"] + ["traverse"] * (result.length is not None))


def maps_of(figure: Figure) -> list[Axes]:
    """Return the axes of a picture that are maps, without colour bars."""
    return [axes for axes in figure.axes if axes.get_label() != "<colorbar>"]


def only_map(figure: Figure) -> Axes:
    (axes,) = maps_of(figure)
    return axes


def patch(axes: Axes, name: str) -> PathPatch | None:
    found = [p for p in axes.patches if p.get_gid() == name]
    assert len(found) <= 1
    return found[0] if found else None  # type: ignore[return-value]


def path_of(axes: Axes, name: str) -> Outline:
    found = patch(axes, name)
    assert found is not None, name
    return found.get_path()


def curve(axes: Axes, name: str) -> Floats:
    """Return the points of a line, without its gaps."""
    (line,) = [line for line in axes.lines if line.get_gid() == name]
    points = np.column_stack([np.asarray(line.get_xdata(), float), np.asarray(line.get_ydata(), float)])
    return np.asarray(points[np.isfinite(points).all(axis=1)])


def words(axes: Axes) -> list[str]:
    return [text.get_text() for text in axes.texts]


def legend(figure: Figure) -> list[str]:
    return [text.get_text() for legend in figure.legends for text in legend.get_texts()]


def said(figure: Figure) -> set[str]:
    """Return every name on the maps and in the legend, broken lines mended."""
    on_maps = [text for axes in maps_of(figure) for text in words(axes)]
    return {text.replace("-\n", "-").replace("\n", " ") for text in [*on_maps, *legend(figure)]}


def drawn_regime(axes: Axes, x: Floats, y: Floats) -> NDArray[np.int8]:
    """Return the regime whose colour is uppermost at points."""
    regime = np.full(x.shape, Regime.NO_SLIP, np.int8)
    for above in (Regime.FORWARD_SLIP, Regime.BACK_SLIP, Regime.HOPPING):
        if patch(axes, above.label) is not None:
            inside = path_of(axes, above.label).contains_points(np.column_stack([x.ravel(), y.ravel()]))
            regime[inside.reshape(x.shape)] = above
    return regime


def lightness(colour: str) -> float:
    """CIE lightness, 0 ... 100: what a colour is in a grey print."""
    linear = [c / 12.92 if c <= 0.04045 else ((c + 0.055) / 1.055) ** 2.4 for c in to_rgb(colour)]
    luminance = float(np.dot(linear, [0.2126, 0.7152, 0.0722]))
    return float(116 * luminance ** (1 / 3) - 16)


def corners(text: Text) -> Floats:
    """Return the corners of a text in pixels, turned with it."""
    angle = text.get_rotation()
    text.set_rotation(0)
    box = text.get_window_extent()
    text.set_rotation(angle)
    centre = np.array([box.x0 + box.width / 2, box.y0 + box.height / 2])
    half = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1], [-1, -1]]) * [box.width / 2, box.height / 2]
    turn = math.radians(angle)
    matrix = np.array([[math.cos(turn), math.sin(turn)], [-math.sin(turn), math.cos(turn)]])
    return np.asarray(centre + half @ matrix)


def image_of(axes: Axes) -> Any:
    """Return the numbers of a map, as the only image on it, whose first row is the lowest."""
    (image,) = axes.images
    assert image.origin == "lower"
    return image


def colours_of(axes: Axes, values: Floats) -> NDArray[np.uint8]:
    """Return the colours, RGBA, that numbers have in the scale of a map."""
    image = image_of(axes)
    return np.asarray(image.cmap(image.norm(values), bytes=True))


def scene_of(amplitude: Floats, frequency: Floats) -> Scene:
    return Scene(
        amplitude=amplitude,
        frequency=frequency,
        drive_angle=math.radians(20),
        static_friction=0.74,
        kinetic_friction=0.57,
    )
