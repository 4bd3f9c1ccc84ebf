"""How fast is the solver, against another version of it? The same scenes, alternating, in two environments.

Usage: python benchmarks/against.py OTHER_PYTHON [--repeats 7] [--only NAME ...]

OTHER_PYTHON is the interpreter of an environment in which the other version is installed. Each workload runs
in a process of its own, first by one version and then by the other. The best time of the processor, of all
threads, is taken of each, and their ratio.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
import time
from collections.abc import Callable
from typing import Any

import numpy as np

import vibro

GRAVITY = 9.81  # [m/s^2]
EXAMPLE = {
    "amplitude": 1e-3,
    "frequency": 15.0,
    "drive_angle": 0.35,
    "static_friction": 0.74,
    "kinetic_friction": 0.57,
}


def contact_fields(n: int) -> dict[str, Any]:
    """Contact scenes of every pattern, as fields of ``vibro.Scene``."""
    rng = np.random.default_rng(1)
    alpha, mu_s = np.radians(rng.uniform(2.0, 45.0, n)), rng.uniform(0.1, 1.0, n)
    highest = np.minimum(6.0, (1.0 - 1e-9) / np.sin(alpha))
    load = 0.1 * (highest / 0.1) ** rng.uniform(0.0, 1.0, n)
    frequency = rng.uniform(5.0, 60.0, n)
    return {
        "amplitude": load * GRAVITY / (2.0 * np.pi * frequency) ** 2,
        "frequency": frequency,
        "drive_angle": alpha,
        "static_friction": mu_s,
        "kinetic_friction": mu_s * rng.uniform(0.4, 1.0, n),
    }


def as_ellipses(fields: dict[str, Any], phase: Any) -> dict[str, Any]:
    """Give the same drives by both amplitudes, with a phase between them."""
    others = {name: x for name, x in fields.items() if name not in ("amplitude", "drive_angle")}
    return others | {
        "along_amplitude": fields["amplitude"] * np.cos(fields["drive_angle"]),
        "normal_amplitude": fields["amplitude"] * np.sin(fields["drive_angle"]),
        "normal_phase": phase,
    }


def ellipse_fields(n: int) -> dict[str, Any]:
    """Contact scenes with a random phase."""
    return as_ellipses(contact_fields(n), np.random.default_rng(4).uniform(-np.pi, np.pi, n))


def hopping_scene(n: int, restitution: float) -> vibro.Scene:
    """Scenes with throw numbers from 1 to 4."""
    rng = np.random.default_rng(2)
    fields = contact_fields(n)
    alpha, throw = fields["drive_angle"], rng.uniform(1.0, 4.0, n)
    fields["amplitude"] = throw / np.sin(alpha) * GRAVITY / (2.0 * np.pi * fields["frequency"]) ** 2
    return vibro.Scene(**fields, restitution=restitution)


def slopes_scene(n: int) -> vibro.Scene:
    """Contact scenes on troughs on which a body can rest."""
    fields = contact_fields(n)
    tilt = np.random.default_rng(5).uniform(-0.8, 0.8, n)
    return vibro.Scene(**fields, trough_angle=tilt * np.arctan(fields["static_friction"]))


def timed(run: Callable[[], Any], count: int) -> float:
    """Measure the time of the processor that a call takes, and divide it by a number [s]."""
    run()  # what is loaded at the first call
    start = time.process_time()
    run()
    return (time.process_time() - start) / count


def solved(scene: vibro.Scene, **options: Any) -> Callable[[], float]:
    """Measure a grid, per cell."""
    return lambda: timed(lambda: vibro.solve(scene, **options), int(np.prod(scene.shape)))


def one_by_one(fields: dict[str, Any], count: int) -> Callable[[], float]:
    """Measure single scenes, each with the making of its ``Scene``."""
    return lambda: timed(lambda: [vibro.solve(vibro.Scene(**fields)) for _ in range(count)], count)


def limits(fields: dict[str, Any]) -> Callable[[], float]:
    """Measure critical loads, per scene."""
    scene = vibro.Scene(**fields)
    return lambda: timed(lambda: vibro.critical_loads(scene), scene.shape[0])


def a_map() -> Callable[[], float]:
    """Measure an amplitude x frequency map of a million cells in contact."""
    a, f = np.linspace(0.1e-3, 1.5e-3, 1000)[:, None], np.linspace(5.0, 20.0, 1000)
    return solved(vibro.Scene(**EXAMPLE | {"amplitude": a, "frequency": f}), flight=False)


def command() -> float:
    """Measure the CPU of ``vibro map`` over a wide plane, as a command [s]."""
    line = [
        "map",
        "-A",
        "0.1:10",
        "-f",
        "5:200",
        "-a",
        "20",
        "--mu-s",
        ".5",
        "--mu-d",
        ".4",
        "-o",
        "out/against",
        "--force",
    ]
    before = os.times()
    subprocess.run([sys.executable, "-m", "vibro", *line], check=True, capture_output=True)
    after = os.times()
    return after.children_user + after.children_system - before.children_user - before.children_system


HOP = EXAMPLE | {"amplitude": 5e-3}
WORK: dict[str, Callable[[], Callable[[], float]]] = {
    "contact, random": lambda: solved(vibro.Scene(**contact_fields(1_000_000)), flight=False),
    "contact, a map": a_map,
    "contact, slopes": lambda: solved(slopes_scene(1_000_000), flight=False),
    "contact, ellipses": lambda: solved(vibro.Scene(**ellipse_fields(1_000_000)), flight=False),
    "critical loads, lines": lambda: limits(contact_fields(20_000)),
    "critical loads, ellipses": lambda: limits(ellipse_fields(5_000)),
    "hops, e = 0": lambda: solved(hopping_scene(100_000, 0.0)),
    "hops, e = .3": lambda: solved(hopping_scene(3_000, 0.3)),
    "hops, e = .6": lambda: solved(hopping_scene(1_000, 0.6)),
    "hops, e = .3, one thread": lambda: solved(hopping_scene(3_000, 0.3), threads=1),
    "hops, e = .6, one thread": lambda: solved(hopping_scene(1_000, 0.6), threads=1),
    "one scene in contact": lambda: one_by_one(EXAMPLE, 500),
    "one scene that hops": lambda: one_by_one(HOP, 200),
    "one scene, e = .3": lambda: one_by_one(HOP | {"restitution": 0.3}, 50),
    "one scene, averaged": lambda: one_by_one(HOP | {"amplitude": 7e-3, "restitution": 0.6}, 10),
    "vibro map, CPU": lambda: command,
}


def measured(python: str, name: str) -> float:
    """Measure a workload in an environment."""
    run = subprocess.run([python, __file__, "--work", name], check=True, capture_output=True, text=True)
    return float(json.loads(run.stdout))


def main() -> None:
    """Print a table of times and ratios."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("other", nargs="?")
    parser.add_argument("--repeats", type=int, default=7)
    parser.add_argument("--only", nargs="*", default=list(WORK))
    parser.add_argument("--work", choices=WORK, help=argparse.SUPPRESS)
    given = parser.parse_args()
    if given.work:
        print(json.dumps(WORK[given.work]()()))
        return
    print(f"{'best of ' + str(given.repeats):28s}{'this [us]':>14s}{'other [us]':>14s}{'ratio':>9s}")
    for name in given.only:
        pairs = [(measured(sys.executable, name), measured(given.other, name)) for _ in range(given.repeats)]
        this, other = (1e6 * min(times) for times in zip(*pairs, strict=True))
        print(f"{name:28s}{this:14.4g}{other:14.4g}{this / other:9.3f}", flush=True)


if __name__ == "__main__":
    main()
