"""How far is the motion of a full feeder from what ``vibro.operate`` says? Both masses are followed in time.

Usage: python benchmarks/filling.py [--machines 40] [--seed 1] [--ratios 0.9 0.95 1.05 1.1]

First the worked feeder of docs/guide/machines.md on both sides of resonance: trough 6 kg, counter mass 12 kg,
damping ratio 0.015, 50 Hz, 20 deg, friction 0.35/0.28, 0.35 mm when empty. Then random machines: magnets
between two masses and against the floor, exciters and unbalances near resonance, throw number 0.35 to 2.8
when empty, on slopes of up to 5 deg, restitution up to 0.3, with fillings of 5 to 67 % of the trough's mass.
``tests/engines/two_way.py`` follows trough and body; it shares nothing with ``vibro``. ``vibro.operate``
feeds the filling's second harmonic back; the differences are its other harmonics, and how the trough recoils
from impacts. A is the amplitude, A2 that of the second harmonic, v the speed; columns "off" are followed over
predicted - 1, "with A2" against the speed that is predicted with the second harmonic. Bodies that rest, that
never repeat in time, or whose point is known to a bound alone are left out of the summary.
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
from helpers.two_way_machines import Case, drawn_widely, masses_of

FILLINGS: Final = (0.0, 0.06, 0.5, 1.0, 2.0, 3.0, 4.0)  # [kg]
MM: Final = 1e-3
NAMES: Final = ("amplitude", "speed", "speed with A2", "size of A2")
FAR: Final = (0.005, 0.1, 0.05, 0.1)  # [1] of each of these, as docs/guide/machines.md has them


class Compared(NamedTuple):
    """Amplitude [m], speed [m/s] and second harmonic [1], the speed predicted with that one, and flags."""

    predicted: tuple[float, float, float]
    followed: tuple[float, float, float]
    with_second: float
    uncertain: bool
    counts: bool


def compare(case: Case) -> Compared:
    """Predict a machine's operating point, and follow it."""
    points = case.operate(allow_strikes=True)
    speed = float(vibro.solve(points.scene).mean_velocity)
    body = two_way.Body(mass=max(case.filling, 1e-9), **case.body)
    motion = two_way.follow(masses_of(case.machine, case.frequency), body)
    size = abs(motion.amplitude)
    predicted = float(points.amplitude), speed, float(np.nan_to_num(points.second_harmonic))
    with_second = float(points.speed_with_second_harmonic())
    counts = points.status <= vibro.Status.BOUNDARY and motion.turns > 0 and predicted[2] > 0.0
    followed = size, motion.speed, abs(motion.second) / size
    return Compared(predicted, followed, with_second, bool(points.uncertain), bool(counts))


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
    parser.add_argument("--machines", type=int, default=40)
    parser.add_argument("--seed", type=int, nargs="+", default=[1])
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
    off: dict[bool, list[tuple[float, ...]]] = {False: [], True: []}
    for seed in options.seed:
        for case in drawn_widely(options.machines, seed):
            found = compare(case)
            print(row(case.name, found) + " uncertain" * found.uncertain, flush=True)
            (a, v, h), (b, u, k) = found.predicted, found.followed
            if found.counts:
                ratios = b / a, u / v, u / found.with_second, k / h
                off[found.uncertain].append(tuple(ratio - 1.0 for ratio in ratios))
    for uncertain, rows in off.items():
        table = np.array(rows).reshape(-1, 4)
        print(f"\n{'uncertain' if uncertain else 'all others'}: {len(table)} machines")
        for name, x, far in zip(NAMES, table.T, FAR, strict=True):
            if x.size:
                middle, high = np.percentile(np.abs(x), [50, 95])
                print(
                    f"  {name:24} off by {x.min():8.2%} to {x.max():8.2%}, half within {middle:.2%}, 95 %"
                    f" within {high:.2%}, {np.count_nonzero(np.abs(x) > far)} beyond {far:.2%}"
                )


if __name__ == "__main__":
    main()
