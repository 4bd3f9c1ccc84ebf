"""Figures 3 and 5 of the paper on the safety nut: where bodies leave the trough, and where they slip forward.

    python examples/paper_maps.py FOLDER

Figure 5 compares two onsets of forward slip: the one that follows from the paper's own force balance (its
Eqs. 9 and 12), and the one that its Eqs. 13-18 print, with kinetic friction in the denominator.
"""

from __future__ import annotations

import argparse
import math
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.figure import Figure

import vibro

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from numpy.typing import NDArray

GRAVITY = 9.81  # [m/s^2]
PAPER_ANGLE = 20.0  # [deg]
PAPER_STATIC, PAPER_KINETIC = 0.74, 0.57
DRIVE_ANGLES = (10.0, 15.0, 20.0, 30.0, 45.0)  # [deg]
STATIC_FRICTIONS = {0.6: "#997700", 0.74: "#222222", 0.9: "#004488", 1.1: "#994455"}  # with their colours
INK, BLUE, RED = "#222222", "#6699CC", "#994455"


def amplitude_at(load: float, frequency: NDArray[np.float64]) -> NDArray[np.float64]:
    """Amplitude [mm] at which A w^2 / g reaches a load, over frequency [Hz]."""
    return 1e3 * load * GRAVITY / (2.0 * math.pi * frequency) ** 2


def scene(angle: float, static: float) -> vibro.Scene:
    """Make a scene of a drive angle [deg]; its critical loads depend on neither amplitude nor frequency."""
    return vibro.Scene(
        amplitude=1e-3,
        frequency=15.0,
        drive_angle=math.radians(angle),
        static_friction=static,
        kinetic_friction=min(static, PAPER_KINETIC),
        gravity=GRAVITY,
    )


def hop_load(angle: float) -> float:
    """Load above which a body leaves a horizontal trough, at a drive angle [deg]."""
    return float(vibro.critical_loads(scene(angle, PAPER_STATIC)).hop)


def onset_load(static: float) -> float:
    """Load above which a body at rest slips forward."""
    return float(vibro.critical_loads(scene(PAPER_ANGLE, static)).forward_onset)


def onset_load_as_printed(static: float) -> float:
    """Load at which the paper's Phi, Eq. 14, is 1. Wrong: a body at rest meets static friction alone."""
    alpha = math.radians(PAPER_ANGLE)
    return static / (math.cos(alpha) + PAPER_KINETIC * math.sin(alpha))


def hop_limits() -> Figure:
    """Figure 3: sign of the normal force, with the hop limits of several drive angles."""
    frequency = np.linspace(5.0, 60.0, 400)
    figure, axes = frame("Contact and hopping (the paper's Fig. 3)", frequency, most_amplitude=3.0)
    curves = {angle: amplitude_at(hop_load(angle), frequency) for angle in DRIVE_ANGLES}
    axes.fill_between(frequency, 0.0, curves[PAPER_ANGLE], color=BLUE, alpha=0.4, linewidth=0.0)
    axes.fill_between(frequency, curves[PAPER_ANGLE], 3.0, color=RED, alpha=0.4, linewidth=0.0)
    axes.text(0.04, 0.05, f"continuous contact at {PAPER_ANGLE:g}°", transform=axes.transAxes)
    axes.text(0.6, 0.85, f"intermittent contact at {PAPER_ANGLE:g}°", transform=axes.transAxes)
    for angle, curve in curves.items():
        axes.plot(frequency, curve, color=INK, linewidth=2.4 if angle == PAPER_ANGLE else 0.9)
        label(axes, f"α = {angle:g}°", frequency, curve, height=1.6)
    return figure


def label(
    axes: Axes, name: str, frequency: NDArray[np.float64], amplitude: NDArray[np.float64], height: float
) -> None:
    """Write a name on a falling curve where it comes down to a height, along the curve."""
    at = int(np.argmax(amplitude < height))
    slope = math.degrees(math.atan(np.gradient(amplitude, frequency)[at]))
    axes.text(
        frequency[at],
        amplitude[at],
        name,
        rotation=slope,
        transform_rotates_text=True,
        rotation_mode="anchor",
        ha="center",
        va="center",
        fontsize=9,
        bbox={"facecolor": "white", "edgecolor": "none", "alpha": 0.85, "pad": 1.0},
    )


def forward_onsets() -> Figure:
    """Figure 5: where forward slip begins for several coefficients of static friction."""
    frequency = np.linspace(8.0, 20.0, 400)
    title = f"Onset of forward slip (the paper's Fig. 5), α = {PAPER_ANGLE:g}°, $\\mu_d$ = {PAPER_KINETIC:g}"
    figure, axes = frame(title, frequency, most_amplitude=2.5)
    for static, colour in STATIC_FRICTIONS.items():
        width = 2.4 if static == PAPER_STATIC else 1.2
        derived = amplitude_at(onset_load(static), frequency)
        printed = amplitude_at(onset_load_as_printed(static), frequency)
        axes.plot(frequency, derived, color=colour, linewidth=width, label=f"$\\mu_s$ = {static:g}, derived")
        axes.plot(
            frequency,
            printed,
            color=colour,
            linewidth=width,
            linestyle=(0, (5, 2)),
            label=f"$\\mu_s$ = {static:g}, as printed",
        )
        if static == PAPER_STATIC:
            axes.fill_between(frequency, derived, 2.5, color=BLUE, alpha=0.3, linewidth=0.0)
    axes.text(0.6, 0.6, f"forward slip for $\\mu_s$ = {PAPER_STATIC:g}", transform=axes.transAxes)
    axes.text(0.08, 0.1, f"no forward slip for $\\mu_s$ = {PAPER_STATIC:g}", transform=axes.transAxes)
    axes.legend(loc="upper right", ncols=2)
    return figure


def frame(title: str, frequency: NDArray[np.float64], most_amplitude: float) -> tuple[Figure, Axes]:
    """Make a figure with axes of frequency and amplitude, of final size."""
    figure = Figure(figsize=(7.4, 5.2), dpi=150, layout="constrained")
    axes = figure.subplots()
    axes.set(title=title, xlabel="frequency f [Hz]", ylabel="amplitude A [mm]")
    axes.set(xlim=(frequency[0], frequency[-1]), ylim=(0.0, most_amplitude))
    figure.draw_without_rendering()
    figure.set_layout_engine("none")
    return figure, axes


def main() -> None:
    parser = argparse.ArgumentParser(description="Draw the paper's Figures 3 and 5.")
    parser.add_argument("folder", type=Path, help="where the pictures go; made if missing")
    folder: Path = parser.parse_args().folder
    folder.mkdir(parents=True, exist_ok=True)
    for name, figure in (("paper-figure-3", hop_limits()), ("paper-figure-5", forward_onsets())):
        path = folder / f"{name}.png"
        figure.savefig(path)
        print(path)
    print("onset of forward slip at 15 Hz: mu_s, amplitude derived [mm], as printed [mm], difference")
    for static in STATIC_FRICTIONS:
        at_15_hz = np.array(15.0)
        derived = float(amplitude_at(onset_load(static), at_15_hz))
        printed = float(amplitude_at(onset_load_as_printed(static), at_15_hz))
        print(f"{static:4.2f}  {derived:.6f}  {printed:.6f}  {printed / derived - 1:+.1%}")


if __name__ == "__main__":
    main()
