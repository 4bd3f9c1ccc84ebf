"""How fast is the steady solve? Beside a root finder, an event loop and the machine's floor, in one run.

Usage: python benchmarks/kernel.py [--scenes 1000000] [--linearity 10000000]

All inputs are random: drive angle 2-45 deg, mu_s 0.1-1, mu_d/mu_s 0.4-1, G log-uniform from 0.1 to 6 or to
hopping if that comes first; elliptical drives have the same amplitudes. Times are the best of a few;
ratios are of the same run.
"""

from __future__ import annotations

import argparse
import functools
import math
import os
import time
from collections.abc import Callable
from typing import Any
from unittest.mock import patch

import numpy as np
from against import GRAVITY, as_ellipses, contact_fields
from scipy.optimize import elementwise

import vibro
from vibro.accuracy.events import simulate_by_events
from vibro.accuracy.motion import motions

MOTION_SCENES = 16_384  # they take ten times as long, and more
BLOCK = 16_384  # [scenes] so that the temporaries of the plain formulas stay in cache too


def motion_scene(fields: dict[str, np.ndarray], harmonics: int, throw: np.ndarray) -> vibro.Scene:
    """Give these drives further harmonics, each of up to half the acceleration, and throw numbers."""
    others = {name: x for name, x in fields.items() if name not in ("amplitude", "drive_angle")}
    rng = np.random.default_rng(3)
    n, phases = throw.size, np.linspace(0.0, 2.0 * np.pi, 256, endpoint=False)
    along, normal, load = [], [], np.zeros((n, phases.size))
    for k in range(1, harmonics + 1):
        shares = rng.uniform(0.0, 0.5, (2, n)) if k > 1 else np.ones((2, n))
        at = rng.uniform(-np.pi, np.pi, (2, n))
        along.append((fields["amplitude"] * np.cos(fields["drive_angle"]) * shares[0] / k**2, at[0]))
        normal.append((shares[1] / k**2, at[1]))
        load += shares[1][:, None] * np.sin(k * phases + at[1][:, None])
    scale = throw * GRAVITY / (2.0 * np.pi * fields["frequency"]) ** 2 / load.max(axis=1)
    return vibro.Scene(
        along_harmonics=along, normal_harmonics=[(scale * size, at) for size, at in normal], **others
    )


def steps_scene(fields: dict[str, np.ndarray]) -> vibro.Scene:
    """Drive these bodies by two levels of acceleration along the trough, as slip-stick conveyors do."""
    others = {name: x for name, x in fields.items() if name not in ("amplitude", "drive_angle")}
    motion = vibro.Motion.steps(along=[[0.8, 6.9], [0.2, -27.6]])
    return vibro.Scene(motion=motion, motion_scale=np.linspace(0.3, 1.0, fields["amplitude"].size), **others)


def best_time(run: Callable[[], Any], repeats: int) -> float:
    """Shortest time of a call [s]."""
    times = []
    for _ in range(repeats):
        start = time.perf_counter()
        run()
        times.append(time.perf_counter() - start)
    return min(times)


def solve_time(scene: vibro.Scene, threads: int, repeats: int) -> float:
    """Time of solving a scene: onsets, pattern, displacement, speeds, ratios and status [s]."""
    with patch("os.cpu_count", return_value=threads):
        return best_time(lambda: vibro.solve(scene), repeats)


def forward_slides(fields: dict[str, np.ndarray]) -> tuple[np.ndarray, np.ndarray]:
    """Start p0 and resistance k of the forward slides of the scenes that slip, by the textbook formulas."""
    along, across = np.cos(fields["drive_angle"]), np.sin(fields["drive_angle"])
    mu_s, mu_d = fields["static_friction"], fields["kinetic_friction"]
    load = fields["amplitude"] * (2.0 * np.pi * fields["frequency"]) ** 2 / GRAVITY
    s = mu_s / (load * (along + mu_s * across))
    slips = s < 1.0
    return np.arcsin(s[slips]), (mu_d / (load * (along + mu_d * across)))[slips]


def find_root_time(p0: np.ndarray, k: np.ndarray, repeats: int) -> float:
    """Time of the slides' ends (E1) by SciPy's root finder, bracketed by peak speed and x = pi - p0."""

    def equation(x: np.ndarray, p0: np.ndarray, k: np.ndarray) -> Any:
        return np.sin(p0 + x) * np.sin(x) - k * x

    def run() -> None:
        for i in range(0, p0.size, BLOCK):
            part = slice(i, i + BLOCK)
            bracket = (0.5 * (np.pi - np.arcsin(k[part]) - p0[part]), np.pi - p0[part])
            elementwise.find_root(equation, bracket, args=(p0[part], k[part]))

    return best_time(run, repeats)


def plain_functions_time(p0: np.ndarray, repeats: int) -> float:
    """Time of one sin, one cos and one asin of each value, in cache-sized blocks [s]."""

    def run() -> None:
        for i in range(0, p0.size, BLOCK):
            sine = np.sin(p0[i : i + BLOCK])
            np.cos(p0[i : i + BLOCK])
            np.arcsin(sine)

    return best_time(run, repeats)


def copy_time(fields: dict[str, np.ndarray], repeats: int) -> float:
    """Time of copying the inputs in and the outputs of a ``SteadyCycle`` out, nothing else [s]."""
    n = fields["amplitude"].size
    numbers, codes = np.zeros(n), np.zeros(n, np.int8)

    def run() -> None:
        for field in fields.values():
            field.copy()
        for _ in range(6):
            numbers.copy()
        for _ in range(5):
            codes.copy()

    return best_time(run, repeats)


def event_loop_time(fields: dict[str, np.ndarray], n: int) -> float:
    """Time of ``n`` scenes by ``solve_ivp`` with events (DOP853, rtol 1e-9) [s]."""
    scene = vibro.Scene(**{name: field[:n] for name, field in fields.items()})
    return best_time(lambda: [simulate_by_events(m, "DOP853", 1e-9) for m in motions(scene)], 1)


def single_scene_times() -> tuple[float, dict[str, float]]:
    """Time the building of one scene, and its solution by pattern as the amplitude grows [s]."""
    fields = {
        "frequency": 15.0,
        "drive_angle": math.radians(20.0),
        "static_friction": 0.74,
        "kinetic_friction": 0.57,
    }
    solving = {}
    for amplitude in (0.5e-3, 1e-3, 1.2e-3, 1.5e-3, 2.5e-3):
        scene = vibro.Scene(amplitude=amplitude, **fields)
        pattern = vibro.solve(scene).pattern
        solving[pattern] = best_time(functools.partial(vibro.solve, scene), 1000)
    return best_time(lambda: vibro.Scene(amplitude=1e-3, **fields), 1000), solving


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--scenes", type=int, default=1_000_000, help="scenes of the main table")
    parser.add_argument(
        "--linearity", type=int, default=10_000_000, help="scenes of the last line of the second"
    )
    parser.add_argument("--repeats", type=int, default=5)
    parser.add_argument("--event-scenes", type=int, default=100)
    arguments = parser.parse_args()

    n, repeats = arguments.scenes, arguments.repeats
    cores = os.cpu_count() or 1
    fields = contact_fields(n)
    scene = vibro.Scene(**fields)
    cycle = vibro.solve(scene)
    patterns, counts = np.unique(cycle.pattern, return_counts=True)
    shares = ", ".join(f"{p} {c / n:.1%}" for p, c in zip(patterns, counts, strict=True))
    print(f"{n} contact scenes: {shares}\n")

    p0, k = forward_slides(fields)
    few = min(arguments.event_scenes, n)
    one = solve_time(scene, 1, repeats)
    rows = [("vibro.solve, 1 thread", n, one)]
    if cores > 1:
        rows.append((f"vibro.solve, {cores} threads", n, solve_time(scene, cores, repeats)))
    phases = np.random.default_rng(2).uniform(-np.pi, np.pi, n)
    for name, phase in (("phase 0", 0.0), ("random phase", phases)):
        ellipses = vibro.Scene(**as_ellipses(fields, phase))
        rows.append((f"the same drives as ellipses, {name}, 1 thread", n, solve_time(ellipses, 1, repeats)))
    some = {name: field[:MOTION_SCENES] for name, field in fields.items()}
    count, rng = some["frequency"].size, np.random.default_rng(4)
    held, thrown = rng.uniform(0.1, 0.98, count), rng.uniform(1.05, 2.5, count)
    motions = {f"{h} harmonics in contact": motion_scene(some, h, held) for h in (1, 2, 3, 5, 8)}
    motions["two levels of acceleration"] = steps_scene(some)
    motions |= {f"{h} harmonics, hopping, e = 0": motion_scene(some, h, thrown) for h in (1, 3, 8)}
    hopping = as_ellipses(some, phases[:count]) | {
        "normal_amplitude": thrown * GRAVITY / (2.0 * np.pi * some["frequency"]) ** 2
    }
    motions["ellipses, hopping, e = 0"] = vibro.Scene(**hopping)
    rows += [(f"{name}, 1 thread", count, solve_time(x, 1, repeats)) for name, x in motions.items()]
    regimes = best_time(lambda: vibro.solve(scene, output="regimes"), repeats)
    rows += [
        (f'vibro.solve, {cores} threads, output="regimes"', n, regimes),
        ("vibro.Scene: copying and checking inputs", n, best_time(lambda: vibro.Scene(**fields), repeats)),
        ("find_root on (E1) alone, 1 thread, of scenes that slip forward", p0.size, find_root_time(p0, k, 2)),
        ("solve_ivp with events, DOP853, rtol 1e-9", few, event_loop_time(fields, few)),
        ("sin + cos + asin of one value, 1 thread", p0.size, plain_functions_time(p0, repeats)),
        ("copying inputs in and outputs out, 1 thread", n, copy_time(fields, repeats)),
    ]
    print(f"{'':64} {'scenes':>9} {'ns a scene':>12} {'ratio':>10}")
    for name, number, seconds in rows:
        ns = 1e9 * seconds / number
        print(f"{name:64} {number:9} {ns:12.1f} {ns / (1e9 * one / n):10.3g}")

    print(f"\n{'scenes':>9} {'ns, 1 thread':>14} {f'ns, {cores} threads':>14}")
    size = 10_000
    while size <= arguments.linearity:
        many = vibro.Scene(**contact_fields(size))
        few_repeats = max(3, min(50, 10_000_000 // size // 2))
        single, all_cores = (1e9 * solve_time(many, t, few_repeats) / size for t in (1, cores))
        print(f"{size:9} {single:14.1f} {all_cores:14.1f}")
        size *= 10
    building, solving = single_scene_times()
    times = ", ".join(f"{1e6 * seconds:.0f} us ({pattern})" for pattern, seconds in solving.items())
    print(f"\none scene through vibro.solve: {times}; and {1e6 * building:.0f} us to build it")


if __name__ == "__main__":
    main()
