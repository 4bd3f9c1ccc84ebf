"""Stretches of a scale with names and looks of their own: regimes, phases, what a goal allows."""

from __future__ import annotations

from itertools import groupby
from typing import TYPE_CHECKING, Any, Final, NamedTuple

from vibro.plots.frame import renderer_of, settle
from vibro.plots.labels import outline
from vibro.plots.style import ink_on

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping

    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

#: Opacity of bands behind curves.
TINT: Final = 0.35


class Band(NamedTuple):
    """A stretch of a scale: ends, name, style of its fill, and the hatches over it by their names."""

    low: float
    high: float
    name: str
    style: Mapping[str, Any]
    over: Mapping[str, Mapping[str, Any]] = {}


def shade(axes: Axes, bands: Iterable[Band], *, named: bool = False) -> None:
    """Fill bands behind the curves of a panel; the legend names them where no strip does."""
    for band in bands:
        look = band.style if "hatch" in band.style else {**band.style, "alpha": TINT, "linewidth": 0.0}
        label = band.name if named else ""
        axes.axvspan(band.low, band.high, zorder=0, gid=band.name, label=label, **look)
        for name, style in band.over.items():
            axes.axvspan(band.low, band.high, zorder=0.5, linewidth=0.0, gid=name, label=name, **style)


def settle_bands(figure: Figure, strip: Axes, bands: Iterable[Band]) -> None:
    """Fix the layout, and write the names of bands into a strip above the panels, or else into the legend."""
    strip.set_yticks([])
    strip.tick_params(axis="x", which="both", bottom=False, labelbottom=False)
    settle(figure)
    renderer, to_pixels = renderer_of(figure), strip.transData
    (first, last), named, others = strip.get_xlim(), set(), []
    for name, group in groupby(bands, key=lambda band: band.name):
        run = list(group)
        low, high, style = max(run[0].low, first), min(run[-1].high, last), run[0].style
        area = strip.axvspan(low, high, gid=name, **{"linewidth": 0.0, **style})
        (left, y), (right, _) = to_pixels.transform([(end, 0.5) for end in (low, high)])
        middle = to_pixels.inverted().transform((0.5 * (left + right), y))[0]
        place: dict[str, Any] = {"ha": "center", "va": "center_baseline", "fontsize": 9.0}
        text = strip.text(middle, 0.5, name, color=ink_on(style["facecolor"]), **place)
        if "hatch" in style:
            outline(text, style["facecolor"])
        if text.get_window_extent(renderer).width <= right - left - 4.0:
            named.add(name)
        else:
            text.remove()
            others.append((name, area))
    for name, area in others:
        area.set_label("" if name in named else name)
    if any(area.get_label() for _, area in others):
        settle(figure)
