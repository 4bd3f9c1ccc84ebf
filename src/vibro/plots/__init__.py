"""Pictures of solved sweeps: matplotlib figures without a window, from cells that are solved.

``map_figures`` draws; ``save`` writes a figure to a file.
"""

from __future__ import annotations

from pathlib import Path
from typing import IO, TYPE_CHECKING, Any, Final

from vibro.errors import FileError, InputError, shown
from vibro.plots.style import house_style, visible
from vibro.plots.subjects import SUBJECTS
from vibro.plots.view import choose_view, panels
from vibro.results.drawing import PICTURES
from vibro.version import __version__

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Mapping, Sequence
    from os import PathLike

    from matplotlib.figure import Figure

    from vibro.results.sweep import SweepResult

# Results that every picture needs, and those that some pictures need beside.
_DRAWN: Final = (
    "regime", "mean_velocity", "displacement_per_cycle", "period_cycles", "mean_velocity_error", "coexists",
    "status",
)  # fmt: skip
#: Names of the pictures of a design.
DESIGN_PICTURES: Final = ("regime", "speed", "band")
_IN_PLACE_OF_LIMITS: Final = ("throw_number", "forward_ratio")
_KEYS: Final = {"svg": ("Description", "Date"), "pdf": ("Subject", "CreationDate")}  # of metadata
_COMPRESSION: Final = 3  # of PNG: against the usual 6, files 10 % larger in half the time


def results_drawn(names: Iterable[str], *, has_limits: bool, of_starts: bool) -> tuple[str, ...]:
    """Name the results, attributes of ``SteadyCycle``, that pictures need; all others may be unknown.

    Parameters
    ----------
    names : iterable of str
        The pictures.
    has_limits : bool
        Whether there are critical loads; without them, boundaries of regimes are read from the results.
    of_starts : bool
        Whether bodies from many starts were followed.
    """
    own = {SUBJECTS[name].result for name in names if name in SUBJECTS} - {*_DRAWN}
    more = () if has_limits else _IN_PLACE_OF_LIMITS
    return (*_DRAWN, *own, *more, *(("share",) if of_starts else ()))


@house_style()
def map_figures(
    result: SweepResult,
    names: Sequence[str],
    *,
    x: str | None = None,
    y: str | None = None,
    target_speed: float | None = None,
    progress: Callable[[int, int], None] = lambda done, size: None,
) -> dict[str, Figure]:
    """Draw a solved sweep.

    Parameters
    ----------
    result : SweepResult
        At least one axis varies; ranges that are drawn are evenly spaced, as ``sweep_picture`` has them.
    names : sequence of str
        Pictures to draw: ``regime`` (of two ranges), ``speed``, ``traverse`` (with a length), ``impact`` and
        ``flight`` (the share of time in it).
    x, y : optional
        Axes of the pictures, see ``choose_view``.
    target_speed : float, optional
        A speed that stands out where speeds are drawn [mm/s].
    progress : callable, optional
        Called with the number of pictures that are drawn, and of all.

    Returns
    -------
    dict of str to Figure
        By name: maps of two ranges, a line of one over bands of its regimes, curves for the values of a list
        beside one, and points of lists alone.

    Raises
    ------
    InputError
        If a picture cannot be drawn.
    """
    from vibro.plots.curves import curve_figure
    from vibro.plots.fields import Fields
    from vibro.plots.maps import map_figure

    view = choose_view(result.axes, x, y, fixed=result.fixed)
    groups = [[Fields(panel) for panel in curves] for curves in panels(result, view)]
    figures = {}
    for name in names:
        if view.y is None:
            figures[name] = curve_figure(name, result, view, groups, target_speed)
        else:
            figures[name] = map_figure(name, result, [fields for (fields,) in groups], target_speed)
        progress(len(figures), len(names))
    return figures


def saver(path: str | PathLike[str] | None) -> Callable[[Figure], Figure]:
    """Return what writes a figure to a file, if there is one, and returns the figure.

    Raises
    ------
    InputError
        At once, if the ending of the file is not that of a picture.
    """
    if path is None:
        return lambda figure: figure
    file = Path(path)
    form = file.suffix[1:].casefold()
    if form not in PICTURES:
        endings = " or ".join(f".{form}" for form in PICTURES)
        raise InputError(f"path = {shown(str(file))}: must end in {endings}")

    def write(figure: Figure) -> Figure:
        try:
            save(figure, file, form, {"Software": f"vibro {__version__}"})
        except OSError as exc:
            raise FileError(f"cannot write {file}: {exc.strerror or exc}") from exc
        return figure

    return write


def save(figure: Figure, path: Path | IO[bytes], picture_format: str, metadata: Mapping[str, str]) -> None:
    """Write a figure to a file.

    Parameters
    ----------
    figure : Figure
        From ``map_figures``.
    path : Path or binary file
        Where it goes; a suffix does not matter.
    picture_format : str
        ``png``, ``svg`` or ``pdf``.
    metadata : mapping of str to str
        Written into the file: entry by entry in PNG, as one text in formats with fixed keys. The headline of
        the figure is added as title, without characters that a format forbids.
    """
    more: dict[str, Any] = {"pil_kwargs": {"compress_level": _COMPRESSION}} if picture_format == "png" else {}
    described: dict[str, str | None] = {"Title": visible(str(figure.get_label())), **metadata}
    if picture_format != "png":
        text = "\n".join(f"{key}: {value}" for key, value in metadata.items())
        place, date = _KEYS[picture_format]
        # No date: equal pictures give equal files.
        described = {"Title": described["Title"], place: text, date: None}
    figure.savefig(path, format=picture_format, metadata=described, **more)
