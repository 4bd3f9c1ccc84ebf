"""Time maps with flights beside maps in contact, and count scenes with several motions, and with long cycles.

Usage: python benchmarks/hopping.py [--side 500] [--scenes 20000] [--irregular 150]

The first table is of maps, drive angle 30 deg, mu_s 0.5, mu_d 0.4, A and f log-spaced: one in contact, and
others with K up to 4 of which one half hops; the ratio is that of a hopping cell to a cell of the first. A
map with bounces (e > 0) has fewer cells, because it takes longer. The second table has random scenes: drive
angle 10-45 deg, mu_s 0.1-1, K log-uniform from 1 to 3.3, level trough, e = 0, and tells in how many
bodies from 16 starts end in several motions. The last line has scenes of K 1-4 and e 0.1-0.7 that ``solve``
averages: in how many nearly all of 40 starts end in one cycle, and how many errors it is from the average.
"""

from __future__ import annotations

import argparse
import math
import time
from collections.abc import Callable
from itertools import pairwise
from typing import Any

import numpy as np

import vibro

G0 = 9.81  # [m/s^2]
REPEATS = 3
RATIOS = (0.001, 0.03, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 1.0)


def throw_map(side: int, least: float, most: float, restitution: float = 0.0) -> vibro.Scene:
    """Grid of amplitudes and frequencies whose throw numbers reach from ``least`` to ``most``."""
    slope = math.sin(math.radians(30.0)) * (2.0 * math.pi) ** 2 / G0  # K over A f^2
    frequency = np.geomspace(10.0, 20.0, side)
    spread = (most / least) / 4.0
    lowest = least / (slope * 100.0)
    return vibro.Scene(
        amplitude=np.geomspace(lowest, lowest * spread, side)[:, None],
        frequency=frequency,
        drive_angle=math.radians(30.0),
        static_friction=0.5,
        kinetic_friction=0.4,
        restitution=restitution,
    )


def best_time(run: Callable[[], Any]) -> float:
    """Shortest time of a call [s]."""
    times = []
    for _ in range(REPEATS):
        start = time.perf_counter()
        run()
        times.append(time.perf_counter() - start)
    return min(times)


def cell_time(scene: vibro.Scene, *, flight: bool = True) -> float:
    """Time of a cell [ns]."""
    return 1e9 * best_time(lambda: vibro.solve(scene, flight=flight)) / math.prod(scene.shape)


def print_costs(side: int) -> None:
    """Print the time a cell of maps in contact and in flight."""
    in_contact = cell_time(throw_map(side, 0.0625, 0.999))
    print(f"{'K':>10} {'e':>5} {'cells':>10} {'hop':>7} {'ns a cell':>11} {'a hopping one':>15} {'ratio':>8}")
    print(f"{'0.06-1':>10} {'':5} {side * side:10} {0:7.0%} {in_contact:11.0f} {'':15} {1:8.3g}")
    for restitution, share in ((0.0, 1), (0.3, 4), (0.6, 8)):
        scene = throw_map(side // share, 0.25, 4.0, restitution)
        hop = float((vibro.solve(scene, output="regimes").regime == vibro.Regime.HOPPING).mean())
        mixed = cell_time(scene)
        hopping = (mixed - cell_time(scene, flight=False)) / hop
        print(
            f"{'0.25-4':>10} {restitution:5} {math.prod(scene.shape):10} {hop:7.0%} {mixed:11.0f} "
            f"{hopping:15.0f} {hopping / in_contact:8.3g}"
        )


def print_several(scenes: int) -> None:
    """Print how often starts lead to several motions, by the ratio of the frictions."""
    rng = np.random.default_rng(1)
    print(f"\n{'mu_d/mu_s':>12} {'scenes':>9} {'several':>12}")
    for low, high in pairwise(RATIOS):
        alpha = np.radians(rng.uniform(10.0, 45.0, scenes))
        mu_s = rng.uniform(0.1, 1.0, scenes)
        throw = 3.3 ** rng.uniform(1e-6, 1.0, scenes)
        frequency = 15.0
        scene = vibro.Scene(
            amplitude=throw / np.sin(alpha) * G0 / (2.0 * math.pi * frequency) ** 2,
            frequency=frequency,
            drive_angle=alpha,
            static_friction=mu_s,
            kinetic_friction=mu_s * rng.uniform(low, high, scenes),
        )
        several = int((vibro.solve(scene, starts=16).coexists > 0).sum())
        print(f"{f'{low:g}-{high:g}':>12} {scenes:9} {several / scenes:12.4%}")


def print_long_cycles(scenes: int) -> None:
    """Print in how many scenes that are averaged a cycle takes nearly all starts."""
    rng, periods, apart, seen = np.random.default_rng(11), [], [], 0
    while seen < scenes:
        alpha, mu_s = math.radians(rng.uniform(10.0, 50.0)), rng.uniform(0.1, 1.0)
        scene = vibro.Scene(
            amplitude=1.02 * (4.0 / 1.02) ** rng.random() / math.sin(alpha) * G0 / (30.0 * math.pi) ** 2,
            frequency=15.0,
            drive_angle=alpha,
            static_friction=mu_s,
            kinetic_friction=mu_s * rng.uniform(0.02, 1.0),
            restitution=rng.choice([0.1, 0.3, 0.5, 0.7]),
        )
        cycle = vibro.solve(scene)
        if cycle.status != vibro.Status.AVERAGED:
            continue
        seen += 1
        one = max(vibro.attractors(scene, 40), key=lambda one: one.share, default=None)
        if one and one.share > 0.9:
            periods.append(one.period_cycles)
            apart.append(abs(cycle.mean_velocity - one.mean_velocity) / cycle.mean_velocity_error)
    print(
        f"\n{len(periods)} of {scenes} averages: a cycle of {min(periods)} to {max(periods)} turns takes"
        f" > 90 % of 40 starts, up to {max(apart):.1f} errors from the average"
    )


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--side", type=int, default=500, help="cells along each axis of the maps")
    parser.add_argument("--scenes", type=int, default=20_000, help="random scenes of each ratio")
    parser.add_argument("--irregular", type=int, default=150, help="scenes without a short cycle")
    arguments = parser.parse_args()
    print_costs(arguments.side)
    print_several(arguments.scenes)
    print_long_cycles(arguments.irregular)


if __name__ == "__main__":
    main()
