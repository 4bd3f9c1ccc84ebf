"""The figures that are drawn here."""

from __future__ import annotations

from typing import Any

from matplotlib.figure import Figure

from vibro.plots.style import house_style


class Picture(Figure):
    """A figure that several threads may save at once, while others draw: one does so at a time."""

    #: Rows of the legend for which the figure has room.
    legend_rows = 3

    def savefig(self, *args: Any, **more: Any) -> None:
        """Write the picture to a file, as matplotlib does, in the style in which it was drawn."""
        with house_style():
            super().savefig(*args, **more)
