"""Pictures of machines: what is drawn of data that is made up, and that labels stand apart."""

from __future__ import annotations

from types import SimpleNamespace
from typing import TYPE_CHECKING, Any

import numpy as np

from vibro.plots.responses import DrivePicture, drive_figure, fit_figure

if TYPE_CHECKING:
    from matplotlib.figure import Figure

X = np.linspace(40.0, 60.0, 201)


def response(natural: float, x: Any = X) -> Any:
    return 0.03 / np.hypot(1.0 - (x / natural) ** 2, 0.03 * x / natural)


def drive(**changes: Any) -> DrivePicture:
    empty, full = response(48.0), response(46.0)
    drawn = DrivePicture(
        frequency=X,
        curves=((empty, 100.0 * empty), (full, 100.0 * full)),
        voltage=((0.81 * empty, 1.21 * empty), (0.81 * full, 1.21 * full)),
        drive=50.0,
        points=((0.34, 34.0), (0.15, 15.0)),
        resonances=(48.0, 46.0),
        hop=np.full(X.size, 0.3),
        slip=np.full(X.size, 0.03),
        full=2.0,
    )
    return drawn._replace(**changes)


def texts(figure: Figure) -> list[str]:
    (legend,) = figure.legends
    return [text.get_text() for text in legend.get_texts()]


def apart(figure: Figure) -> None:
    """No text lies on another one, or outside the figure."""
    figure.draw_without_rendering()
    renderer = figure.canvas.get_renderer()  # type: ignore[attr-defined]
    (legend,) = figure.legends
    labels = [axes.xaxis.label for axes in figure.axes] + [axes.yaxis.label for axes in figure.axes]
    drawn = [text for text in (*legend.get_texts(), *labels, figure._suptitle) if text and text.get_text()]  # type: ignore[attr-defined]
    boxes = [text.get_window_extent(renderer) for text in drawn]
    for i, box in enumerate(boxes):
        assert figure.bbox.x0 <= box.x0
        assert box.x1 <= figure.bbox.x1
        assert not any(box.overlaps(later) for later in boxes[i + 1 :]), drawn[i].get_text()


def test_amplitude_stands_above_speed_on_one_axis() -> None:
    figure = drive_figure(drive(), "magnet", "setting 100 %")
    above, beneath = figure.axes
    assert above.get_xlim() == beneath.get_xlim() == (40.0, 60.0)
    assert above.get_ylabel() == "amplitude $A$ [mm]"
    assert beneath.get_ylabel() == "mean speed [mm/s]"
    assert beneath.get_xlabel() == "frequency of the drive $f$ [Hz]"
    assert set(texts(figure)) == {
        "empty", "with 2 kg", "band of voltage, empty", "band of voltage, with 2 kg",
        "natural frequency empty", "natural frequency with 2 kg", "frequency of the drive",
        "operating point empty", "operating point with 2 kg", "bodies hop above", "bodies slip above",
    }  # fmt: skip
    for which, axes in enumerate(figure.axes):
        curves = [line.get_ydata() for line in axes.lines if len(np.asarray(line.get_xdata())) == X.size]
        np.testing.assert_array_equal(curves[:2], [pair[which] for pair in drive().curves])
    points = [tuple(np.ravel(line.get_xydata())) for line in above.lines if line.get_marker() in ("o", "s")]
    assert (50.0, 0.34) in points
    assert (50.0, 0.15) in points
    lines = {float(line.get_xdata()[0]) for line in above.lines if len(line.get_xdata()) == 2}  # type: ignore[arg-type,index]
    assert {50.0, 48.0, 46.0} <= lines
    apart(figure)


def test_without_a_filling_a_voltage_and_hops() -> None:
    empty = response(48.0)
    bare = drive(
        curves=((empty, 0.0 * empty),), voltage=(), points=((0.34, 0.0),), resonances=(),
        hop=np.full(X.size, np.inf), slip=np.full(X.size, np.inf), full=0.0,
    )  # fmt: skip
    figure = drive_figure(bare._replace(others=(0.2, 0.25)), "crank", "")
    more = "other operating points empty"
    assert set(texts(figure)) == {"empty", "frequency of the drive", "operating point empty", more}
    apart(figure)


def fitted(natural: float = 48.0, peak: float = 0.0, error: float = 0.02) -> Any:
    f = np.array([45.0, 47.0, 48.0, 50.0, 53.0])
    return SimpleNamespace(
        frequency=f, amplitude=1e-3 * response(48.0, f), amplitude_error=error * f / f,
        amplitudes=lambda x: 1e-3 * response(48.0, x) + np.where(x == 50.0, peak, 0.0),
        natural_frequency=natural, natural_frequency_interval=(natural - 0.2, natural + 0.3),
    )  # fmt: skip


def test_a_fit_shows_what_is_known() -> None:
    figure = fit_figure(fitted(), X, "points", "natural frequency 48 Hz")
    interval = "95 % interval of the natural frequency"
    assert set(texts(figure)) == {interval, "natural frequency", "fitted", "measured, with standard error"}
    apart(figure)
    figure = fit_figure(fitted(np.nan, np.inf, np.nan), X, "points", "none")
    assert texts(figure) == ["fitted", "measured"]
    assert np.isfinite(figure.axes[0].get_ylim()).all()
