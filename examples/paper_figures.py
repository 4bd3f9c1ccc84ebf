"""Figures 2, 4, 6, 7 and 9 to 11 of the paper on the safety nut: its forces and its motion in time.

    python examples/paper_figures.py FOLDER

The nut of the paper (1 mm, 15 Hz, 20 deg, 0.74 / 0.57) as exactly computed. Figures 9 and 11 lay beside it
a motion study whose friction is smoothed as CAD programs do (examples/data/make_nut_smoothed_600hz.py);
Figure 6 also shows the onset that the paper prints, with kinetic friction in its denominator. Figures 3
and 5: paper_maps.py.
"""

from __future__ import annotations

import argparse
import math
import runpy
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.figure import Figure

import vibro
from vibro.motion.histories import trace
from vibro.plots.frame import set_heading, shade
from vibro.plots.history import history_figure, phase_bands
from vibro.plots.style import INK, house_style, values_text

if TYPE_CHECKING:
    from collections.abc import Callable

    from matplotlib.axes import Axes
    from numpy.typing import NDArray

    from vibro.results.history import Sample

    Floats = NDArray[np.float64]

BLUE, RED, GREEN, ORANGE = "#004488", "#BB5566", "#117733", "#997700"
FREQUENCY, DRIVE_ANGLE = 15.0, math.radians(20.0)
STATIC, KINETIC, GRAVITY = 0.74, 0.57, 9.81
CYCLES = 3
STUDY = runpy.run_path(str(Path(__file__).with_name("data") / "make_nut_smoothed_600hz.py"))
GIVEN = {
    "amplitude": 1.0,  # [mm]
    "frequency": FREQUENCY,
    "drive_angle": 20.0,  # [deg]
    "static_friction": STATIC,
    "kinetic_friction": KINETIC,
}
NAME = "The safety nut (the paper's Fig. {})"


def nut(amplitude: float = 1e-3) -> vibro.Scene:
    """Make the scene of the paper, at an amplitude [m]."""
    return vibro.Scene(
        amplitude=amplitude,
        frequency=FREQUENCY,
        drive_angle=DRIVE_ANGLE,
        static_friction=STATIC,
        kinetic_friction=KINETIC,
    )


def run(cycles: float = CYCLES, amplitude: float = 1e-3) -> tuple[vibro.History, Sample]:
    """Follow the nut from rest; the rows hold both sides of every event."""
    history = vibro.simulate(nut(amplitude), cycles=cycles)
    return history, trace(history, until=history.end, samples_per_cycle=400, both_sides=True)


def friction_over_load() -> Figure:
    """Figure 2: friction against the load along the trough, over one cycle."""
    _, rows = run(1.0)
    history = vibro.simulate(nut(), cycles=1)
    slide = next(p for p in history.phases if p.kind == "F")
    figure, axes = frame(NAME.format(2), (7.4, 5.4))
    axes.plot(rows.inertial, rows.friction, color=BLUE, linewidth=2.0)
    limit = 1.15 * float(np.abs(rows.inertial).max())
    axes.plot([-limit, limit], [limit, -limit], color=INK, linewidth=0.6, linestyle=(0, (4, 3)))
    start, stop = (history.sample(t, side="left") for t in (slide.start, slide.end))
    end = history.sample(slide.end)
    for at, mark, words, offset, side in (
        (
            start,
            "s",
            f"slide starts at {1e3 * slide.start:.2f} ms: friction\ndrops from static to kinetic",
            (-10, -16),
            "right",
        ),
        (stop, "o", f"slide stops at {1e3 * slide.end:.2f} ms ...", (-6, -14), "right"),
        (end, "o", "... and friction holds the body again", (12, 8), "left"),
    ):
        axes.plot(at.inertial, at.friction, mark, color=INK, markersize=6)
        place = (float(at.inertial), float(at.friction))
        axes.annotate(words, place, xytext=offset, textcoords="offset points", ha=side, va="center")
    axes.text(-0.75 * limit, 0.88 * limit, "at rest: friction = − load", ha="left")
    axes.text(0.45 * limit, -0.36 * limit, "sliding: $-\\mu_d N$", ha="left")
    cross(axes)
    axes.set_xlabel("inertial load along the trough, per unit mass [m/s²]")
    axes.set_ylabel("friction on the body, per unit mass [m/s²]")
    axes.set(xlim=(-limit, limit), ylim=(-limit, limit))
    return figure


def forces() -> Figure:
    """Figure 4: the trough, and the forces on the nut."""
    history, rows = run()
    return history_figure(history.phases, rows, ["trough", "forces"], NAME.format(4), GIVEN)


def onsets() -> Figure:
    """Figure 6: when the load reaches static friction, by the derived and by the printed condition."""
    load = 1e-3 * (2.0 * math.pi * FREQUENCY) ** 2 / GRAVITY
    along, across = load * math.cos(DRIVE_ANGLE), load * math.sin(DRIVE_ANGLE)
    thresholds = {
        f"derived: $\\mu_s$ in the denominator, {STATIC / (along + STATIC * across):.6f}": (
            STATIC / (along + STATIC * across),
            GREEN,
        ),
        f"as printed, Eq. 14: $\\mu_d$ in the denominator, {STATIC / (along + KINETIC * across):.6f}": (
            STATIC / (along + KINETIC * across),
            ORANGE,
        ),
    }
    period = 1e3 / FREQUENCY
    time = np.linspace(0.0, CYCLES * period, 1200)
    figure, axes = frame(NAME.format(6), (9.0, 4.4))
    axes.plot(time, np.sin(2.0 * math.pi * time / period), color=BLUE, label="$y_1 = \\sin \\omega t$")
    axes.axhline(1.0, color=INK, linewidth=0.8)
    for label, (threshold, colour) in thresholds.items():
        axes.axhline(threshold, color=colour, label=f"$y_2 = \\Phi$, {label}")
        rises = period * (math.asin(threshold) / (2.0 * math.pi) + np.arange(CYCLES))
        falls = period * (0.5 - math.asin(threshold) / (2.0 * math.pi) + np.arange(CYCLES))
        axes.plot(rises, np.full(CYCLES, threshold), "s", color=colour, markersize=6, zorder=4)
        axes.plot(falls, np.full(CYCLES, threshold), "o", color=colour, markerfacecolor="w", zorder=4)
    axes.plot([], [], "s", color=INK, label="slide starts")
    axes.plot([], [], "o", color=INK, markerfacecolor="w", label="no meaning: the body slides")
    cross(axes)
    axes.set(xlim=(0.0, CYCLES * period), ylim=(-1.15, 1.25), xlabel="time [ms]", ylabel="$y_1$, $y_2$ [1]")
    figure.legend(loc="outside lower center", ncols=2)
    return figure


def relative_motion() -> Figure:
    """Figure 7: relative acceleration and velocity."""
    history, rows = run()
    panels = ["forces", "acceleration", "velocity"]
    return history_figure(history.phases, rows, panels, NAME.format(7), GIVEN)


def friction_and_acceleration() -> Figure:
    """Figure 9: friction and relative acceleration, exact and with smoothed friction."""
    history, rows = run()
    time, _, velocity = study()
    inertial, friction = STUDY["forces"](time, velocity)
    return beside_the_study(
        NAME.format(9),
        history,
        rows,
        time,
        (
            ("friction on the body,\nper unit mass [m/s²]", rows.friction, friction),
            ("relative\nacceleration [m/s²]", rows.acceleration, inertial + friction),
        ),
    )


def velocity_and_displacement() -> Figure:
    """Figure 11: relative velocity and displacement, exact and with smoothed friction."""
    history, rows = run()
    time, displacement, velocity = study()
    return beside_the_study(
        NAME.format(11),
        history,
        rows,
        time,
        (
            ("relative\nvelocity [mm/s]", 1e3 * rows.velocity, 1e3 * velocity),
            ("relative\ndisplacement [mm]", 1e3 * rows.position, 1e3 * displacement),
        ),
    )


def trajectories() -> Figure:
    """Figure 10: the path of the nut in the frame of the trough, sliding and hopping."""
    figure = Figure(figsize=(9.0, 4.6), layout="constrained")
    upper, lower = figure.subplots(2, 1)
    for axes, amplitude in ((upper, 1e-3), (lower, 4e-3)):
        length = 60e-3
        history = vibro.simulate(nut(amplitude), length=length)
        rows = trace(history, until=history.end, samples_per_cycle=400, both_sides=True)
        axes.plot(1e3 * rows.position, 1e3 * rows.gap, color=BLUE, linewidth=1.8)
        throw = float(vibro.solve(nut(amplitude)).throw_number)
        stays = "stays on the trough" if throw <= 1.0 else "hops"
        axes.set_title(f"A = {1e3 * amplitude:g} mm, K = {throw:.3f}: {stays}, {history.end:.2f} s for 60 mm")
        axes.set_ylabel("height above\nthe trough [mm]")
        axes.set(xlim=(0.0, 1e3 * length), ylim=(-0.05, 0.3))
        cross(axes)
    lower.set_xlabel("displacement relative to the trough [mm]")
    figure.suptitle("Path of the safety nut in the frame of the trough (the paper's Fig. 10)", fontsize=10.5)
    return figure


def study() -> tuple[Floats, Floats, Floats]:
    """Compute the motion study at 600 samples a second: time, displacement and velocity, SI."""
    time = np.arange(1, round(CYCLES * 600 / FREQUENCY) + 1) / 600.0
    return time, *STUDY["simulate"](time)


def beside_the_study(
    title: str,
    history: vibro.History,
    rows: Sample,
    time: Floats,
    panels: tuple[tuple[str, Floats, Floats], ...],
) -> Figure:
    """Draw exact curves, and the samples of the study, above each other."""
    figure = Figure(figsize=(9.0, 5.6), layout="constrained")
    grid = figure.subplots(len(panels), 1, sharex=True)
    for axes, (label, exact, smoothed) in zip(grid, panels, strict=True):
        axes.plot(1e3 * rows.time, exact, color=RED, linewidth=1.8, label="exact")
        axes.plot(
            1e3 * time, smoothed, ".-", color=BLUE, linewidth=0.8, markersize=4, label="smoothed friction"
        )
        shade(axes, phase_bands([phase for phase in history.phases if phase.kind == "F"]), named=True)
        axes.set_ylabel(label)
        cross(axes)
    grid[-1].set(xlim=(0.0, 1e3 * history.end), xlabel="time [ms]")
    named = dict(zip(*grid[0].get_legend_handles_labels()[::-1], strict=True))
    figure.legend(handles=list(named.values()), loc="outside lower center", ncols=len(named))
    figure.align_ylabels(grid)
    set_heading(figure, title, values_text(GIVEN))
    return figure


def frame(title: str, size: tuple[float, float]) -> tuple[Figure, Axes]:
    figure = Figure(figsize=size, layout="constrained")
    set_heading(figure, title, values_text(GIVEN))
    return figure, figure.subplots()


def cross(axes: Axes) -> None:
    axes.axhline(0.0, color=INK, linewidth=0.5)


FIGURES: dict[str, Callable[[], Figure]] = {
    "paper-figure-2": friction_over_load,
    "paper-figure-4": forces,
    "paper-figure-6": onsets,
    "paper-figure-7": relative_motion,
    "paper-figure-9": friction_and_acceleration,
    "paper-figure-10": trajectories,
    "paper-figure-11": velocity_and_displacement,
}


def main() -> None:
    parser = argparse.ArgumentParser(description="Draw the paper's Figures 2, 4, 6, 7 and 9 to 11.")
    parser.add_argument("folder", type=Path, help="where the pictures go; made if missing")
    folder: Path = parser.parse_args().folder
    folder.mkdir(parents=True, exist_ok=True)
    with house_style():
        for name, draw in FIGURES.items():
            path = folder / f"{name}.png"
            draw().savefig(path)
            print(path)


if __name__ == "__main__":
    main()
