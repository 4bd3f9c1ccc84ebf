"""Does a contact stick, slide and hop as it should? Physics engines against exact histories, over the step.

Usage: python benchmarks/engines/run.py [--engines plain,mujoco,pybullet,drake] [--steps 4,1,0.1] [--page]

The scenes and what is compared: docs/theory/benchmark.md. Needs NumPy, and of the engines those that are
installed (pip install mujoco pybullet drake); ``plain`` is two textbook methods. Each engine first lets a
block slide to a stop, from 1 m/s at friction 0.4 with a step of 1 ms: if its distance is off by more than 2 %
the engine is not set up as meant, and the benchmark ends with 1. ``--page`` writes the table into the page.
"""

from __future__ import annotations

import argparse
import datetime
import importlib
import platform
import re
import sys
from importlib.metadata import version
from pathlib import Path
from typing import Any, Final

from scenes import CYCLES, WINDOW, Scene, exact_displacements, scenes

PAGE: Final = Path(__file__).parents[2] / "docs" / "theory" / "benchmark.md"
ENGINES: Final = ("plain", "mujoco", "pybullet", "drake")
STOP: Final = Scene("stop", 0.0, 25.0, 0.0, 0.0, 0.4, 0.0, 9.81)
STOP_STEP: Final = 1e-3  # [s]
MOST_STOP_ERROR: Final = 0.02  # [1] of the distance
AT_REST: Final = 1e-9  # [m] displacement below which a scene is one at rest
ROUNDING: Final = 1e-12  # [m/s] of an engine that holds it


def check(engine: Any, variant: str) -> None:
    """Let a block slide to a stop; end the program if its distance is wrong."""
    exact = 1.0 / (2.0 * STOP.friction * STOP.gravity)
    found = engine.follow(STOP, STOP.mean_loads(STOP_STEP), STOP_STEP, variant, velocity=1.0)[-1]
    if abs(found / exact - 1.0) > MOST_STOP_ERROR:
        raise SystemExit(f"{variant}: a block slides {found:.4g} m to its stop, in place of {exact:.4g} m")


def error(engine: Any, variant: str, scene: Scene, step: float) -> str:
    """Error of the mean speed over the window."""
    exact_first, exact_last = exact_displacements(scene)
    positions = engine.follow(scene, scene.mean_loads(step), step, variant)
    if positions is None:
        return "-"
    first = positions[round((CYCLES - WINDOW) / scene.frequency / step)]
    speed = (positions[-1] - first) * scene.frequency / WINDOW
    exact_speed = (exact_last - exact_first) * scene.frequency / WINDOW
    if abs(exact_last) < AT_REST:
        return f"{1e6 * speed:.3g} µm/s" if abs(speed) > ROUNDING else "0 µm/s"
    return f"{speed / exact_speed - 1.0:+.2%}"


def markdown(rows: list[list[str]]) -> str:
    """Return a table, its first row as heading."""
    head, *body = rows
    return "\n".join("| " + " | ".join(row) + " |" for row in [head, ["---"] * len(head), *body])


def main() -> None:
    parser = argparse.ArgumentParser(description="Physics engines against exact histories.")
    parser.add_argument("--engines", default=",".join(ENGINES), help="which of " + ", ".join(ENGINES))
    parser.add_argument("--steps", default="4,1,0.1", help="steps [ms]; 40 ms must be a multiple of each")
    parser.add_argument("--page", action="store_true", help="write the table into the page")
    wanted = parser.parse_args()
    heading = ["method", "step [ms]", *(scene.name for scene in scenes())]
    speeds, made_with = [heading], []
    for name in wanted.engines.split(","):
        try:
            engine = importlib.import_module("plain" if name == "plain" else f"with_{name}")
        except ModuleNotFoundError as missing:
            print(f"{name} is not run: no {missing.name} (pip install {name})", file=sys.stderr)
            continue
        if name != "plain":
            made_with.append(f"{name} {version(name)}")
        for variant in engine.VARIANTS:
            check(engine, variant)
            for step in wanted.steps.split(","):
                cells = [error(engine, variant, scene, float(step) / 1e3) for scene in scenes()]
                speeds.append([variant, step, *cells])
    table = "\n\n".join(
        (
            f"Error of the mean speed over the last {WINDOW} cycles; of the scene at rest its drift:",
            markdown(speeds),
            f"Made on {datetime.date.today()} with {', '.join(made_with) or 'no engine'} and Python "
            f"{platform.python_version()} on {platform.machine()}, by `benchmarks/engines/run.py --page`.",
        )
    )
    print(table)
    if wanted.page:
        text = PAGE.read_text(encoding="utf-8")
        new = re.sub(
            r"(<!-- made by the benchmark -->\n).*(<!-- to here -->)",
            lambda found: f"{found[1]}\n{table}\n\n{found[2]}",
            text,
            flags=re.DOTALL,
        )
        PAGE.write_text(new, encoding="utf-8")


if __name__ == "__main__":
    main()
