"""Pictures as their colours, point by point."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg

if TYPE_CHECKING:
    from matplotlib.figure import Figure
    from numpy.typing import NDArray


def pixels(figure: Figure) -> NDArray[np.uint8]:
    """Render a figure: an array of shape (height, width, 4)."""
    canvas: Any = FigureCanvasAgg(figure)
    canvas.draw()
    return np.asarray(canvas.buffer_rgba())
