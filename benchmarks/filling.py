"""How far is the motion of a full feeder from what ``vibro.operate`` says? Both masses are followed in time.

Usage: python benchmarks/filling.py [--machines 20] [--seed 33] [--ratios 0.9 0.95 1.05 1.1]

First the worked feeder of docs/guide/machines.md on both sides of resonance: trough 6 kg, counter mass 12 kg,
damping ratio 0.015, 50 Hz, 20 deg, friction 0.35/0.28, 0.35 mm when empty. Then random machines: magnets
between two masses and against the floor, exciters and unbalances, throw number 0.4 to 2.5 when empty, with
fillings of 1 % of the trough's mass and of 10 to 50 % of it. ``tests/engines/two_way.py`` follows trough and
body; it shares nothing with ``vibro``. ``vibro.operate`` takes the motion for a sine: the differences
are the filling's harmonics, of which the second is the largest. A is the amplitude, A2 that of the second
harmonic, v the speed; columns "off" are followed over predicted - 1, "with A2" against the speed that is
predicted with the second harmonic.
"""

from __future__ import annotations

import argparse
import math
import sys
from pathlib import Path
from typing import Final, NamedTuple

import numpy as np

import vibro

sys.path.insert(0, str(Path(__file__).parents[1] / "tests"))
from engines import two_way
from helpers.two_way_machines import Case, drawn, masses_of

FILLINGS: Final = (0.0, 0.06, 0.5, 1.0, 2.0, 3.0, 4.0)  # [kg]
MM: Final = 1e-3


class Compared(NamedTuple):
    """Amplitude [m], speed [m/s] and second harmonic [1], and the speed predicted with that one."""

    predicted: tuple[float, float, float]
    followed: tuple[float, float, float]
    with_second: float


def compare(case: Case) -> Compared:
    """Predict a machine's operating point, and follow it."""
    points = case.operate()
    speed = float(vibro.solve(points.scene).mean_velocity)
    body = two_way.Body(mass=max(case.filling, 1e-9), **case.body)
    motion = two_way.follow(masses_of(case.machine, case.frequency), body)
    size = abs(motion.amplitude)
    predicted = float(points.amplitude), speed, float(np.nan_to_num(points.second_harmonic))
    with_second = float(points.speed_with_second_harmonic())
    return Compared(predicted, (size, motion.speed, abs(motion.second) / size), with_second)


def row(name: str, found: Compared, empty: Compared | None = None) -> str:
    """One line of a table."""
    (a, v, h), (b, u, k) = found.predicted, found.followed
    changes = ""
    if empty is not None:
        changes = f" {v / empty.predicted[1] - 1.0:8.1%} {u / empty.followed[1] - 1.0:8.1%}"
    return (
        f"{name:34} {a / MM:8.4f} {b / a - 1.0:9.3%} {v / MM:8.3f} {u / v - 1.0 if v else 0.0:8.2%}"
        f" {u / found.with_second - 1.0 if v else 0.0:8.2%} {h:8.3%} {k:8.3%}{changes}"
    )


def feeder(ratio: float, filling: float) -> Case:
    """Return the worked feeder with springs of a frequency ratio."""
    machine = vibro.Machine.magnet(
        trough_mass=6.0, counter_mass=12.0, natural_frequency=50.0 / ratio, damping_ratio=0.015,
        calibration=vibro.Calibration(0.35 * MM, 50.0),
    )  # fmt: skip
    body = {"drive_angle": math.radians(20.0), "static_friction": 0.35, "kinetic_friction": 0.28}
    return Case("worked feeder", machine, 50.0, filling, body)


def near_onset() -> Case:
    """Return a feeder of the same masses whose parts mostly stick: amplitude changes the speed most there."""
    body = {"drive_angle": math.radians(29.0), "static_friction": 0.62, "kinetic_friction": 0.44}
    amplitude = 0.43 * 9.81 / math.sin(body["drive_angle"]) / (2.0 * math.pi * 50.0) ** 2
    machine = vibro.Machine.magnet(
        trough_mass=6.0, counter_mass=12.0, natural_frequency=50.0 / 0.85, damping_ratio=0.012,
        calibration=vibro.Calibration(amplitude, 50.0),
    )  # fmt: skip
    return Case("onset of slip", machine, 50.0, 0.31 * 6.0, body)


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--machines", type=int, default=20)
    parser.add_argument("--seed", type=int, default=33)
    parser.add_argument(
        "--ratios", type=float, nargs="*", default=[0.90, 0.95, 1.05, 1.10], help="f/f0 of the feeder"
    )
    options = parser.parse_args()
    head = f"{'':34} {'A [mm]':>8} {'off':>9} {'v [mm/s]':>8} {'off':>8} {'with A2':>8} {'A2/A':>8}"
    head += f" {'followed':>8}"
    print(f"{head} {'speed':>8} {'followed':>8}")
    for ratio in options.ratios:
        empty = compare(feeder(ratio, 0.0))
        for filling in FILLINGS:
            found = compare(feeder(ratio, filling))
            print(row(f"f/f0 {ratio:.2f}, {filling:g} kg", found, empty), flush=True)
    print(row("onset of slip, f/f0 0.85, 31 %", compare(near_onset())), flush=True)
    print(f"\n{head}")
    off: dict[bool, list[tuple[float, ...]]] = {True: [], False: []}
    for case in drawn(options.machines, options.seed):
        found = compare(case)
        print(row(case.name, found), flush=True)
        (a, v, _), (b, u, k) = found.predicted, found.followed
        speeds = [u / speed - 1.0 if speed else 0.0 for speed in (v, found.with_second)]
        off[case.share < 0.05].append((b / a - 1.0, *speeds, k))
    for few, rows in off.items():
        amplitude, speed, better, second = np.array(rows).T
        print(
            f"\nfilling {'1 %' if few else '10 to 50 %'} of the trough, {len(rows)} machines: A off by"
            f" {amplitude.min():.3%} to {amplitude.max():.3%},"
            f" speed by {speed.min():.2%} to {speed.max():.2%}, with the second harmonic by"
            f" {better.min():.2%} to {better.max():.2%}; second harmonic up to {second.max():.2%}"
        )


if __name__ == "__main__":
    main()
