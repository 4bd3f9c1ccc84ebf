"""The same scene gives the same picture, whatever the user configured for other pictures."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path
from typing import Any, Final

import matplotlib as mpl
from helpers.drawn import OWN, lightness, sweep

from vibro import Regime
from vibro.plots import map_figures, save
from vibro.plots.history import PHASE_COLOURS
from vibro.plots.style import REGIME_COLOURS, ink_on

# As a user may have them, in a matplotlibrc or a style sheet.
CONFIGURED: Final[Any] = {
    "axes.grid": True, "figure.autolayout": True, "font.size": 20.0, "hatch.color": "red",
    "lines.marker": "x", "path.sketch": (5.0, 100.0, 2.0), "savefig.bbox": "tight", "savefig.dpi": 30,
    "savefig.format": "svg", "svg.fonttype": "none",
}  # fmt: skip


def test_regimes_and_phases_have_colours_of_their_own_with_legible_words() -> None:
    assert len({*REGIME_COLOURS.values()}) == len(REGIME_COLOURS)
    for colour in REGIME_COLOURS.values():
        assert abs(lightness(colour) - lightness(ink_on(colour))) > 40.0
    phases = {"F": Regime.FORWARD_SLIP, "B": Regime.BACK_SLIP, "H": Regime.HOPPING, "_": Regime.NO_SLIP}
    assert {k: REGIME_COLOURS[regime] for k, regime in phases.items()} == PHASE_COLOURS


def test_settings_for_other_pictures_change_nothing(tmp_path: Path) -> None:
    two = sweep(points=31, own=OWN, amplitude="0.1:3", frequency="5:60")
    one = sweep(points=31, amplitude="0.1:4")

    def files(folder: Path) -> list[bytes]:
        folder.mkdir()
        (line,) = map_figures(one, ["speed"]).values()
        (plane,) = map_figures(two, ["regime"]).values()
        for figure, form in ((line, "pdf"), (line, "png"), (plane, "svg")):
            save(figure, folder / form, form, {})
        return [path.read_bytes() for path in sorted(folder.iterdir())]

    usual = files(tmp_path / "usual")
    with mpl.rc_context(CONFIGURED):
        configured = files(tmp_path / "configured")
        assert mpl.rcParams["axes.grid"] is True
        assert mpl.rcParams["font.size"] == 20.0
    assert len(usual) == 3
    assert configured == usual


def test_no_window_is_asked_for_and_other_pictures_have_their_backend() -> None:
    code = (
        "import sys, vibro\n"
        "given = dict(frequency_hz=15, drive_angle_deg=20, static_friction=0.7, kinetic_friction=0.5)\n"
        "vibro.sweep(amplitude_mm='0.1:3:5', **given).draw('speed')\n"
        "scene = dict(frequency=15, drive_angle=0.3, static_friction=0.7, kinetic_friction=0.5)\n"
        "vibro.simulate(vibro.Scene(amplitude=1e-3, **scene), cycles=3).draw()\n"
        "print([m for m in ('matplotlib.pyplot', 'tkinter', 'PyQt6') if m in sys.modules])\n"
        "import matplotlib; print(matplotlib.rcParams['axes.grid'], matplotlib.get_backend())\n"
    )
    command, environment = [sys.executable, "-W", "error", "-c", code], {**os.environ, "MPLBACKEND": "svg"}
    done = subprocess.run(command, env=environment, capture_output=True, text=True, timeout=60, check=False)
    assert done.stderr == ""
    assert done.stdout.splitlines() == ["[]", "False svg"]
