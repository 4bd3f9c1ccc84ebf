"""How well the harmonics of a trough are known, and the speed of a part on them.

Usage: python benchmarks/measured_troughs.py [--feeders 60]

Feeders are those of tests/helpers/feeders.py: 20 to 60 Hz, a second and a third harmonic of 5 to 30 % of the
acceleration each, other along the trough than normal to it; noise that is white above 10 Hz and 1/f below.

The first table counts for one second of each record which share of all amplitudes and phases lies within one
and two of its standard errors, and in how many records the number of harmonics is right. The second one
compares for four seconds the speed of a part (mu_s 0.4, mu_d 0.3) with that on the true motion: where the
motion is taken for the best line, and with its harmonics.
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from typing import Any, Final

import numpy as np

import vibro
from vibro.records.trough import MeasuredMotion, motion_of

sys.path.insert(0, str(Path(__file__).parents[1] / "tests"))
from helpers.feeders import QUIET, Feeder, feeder

PART: Final = {"static_friction": 0.4, "kinetic_friction": 0.3}


def standard_scores(measured: MeasuredMotion, true: Feeder) -> list[float]:
    """Return the errors of all amplitudes and phases that are measured, in standard errors."""
    true = true.on_its_clock
    found = []
    for k in range(min(measured.order, true.along.size)):
        for i, (got, exact) in enumerate(((measured.along, true.along), (measured.normal, true.normal))):
            found.append((abs(got[k]) - abs(exact[k])) / measured.standard_errors[k, i])
            if k or i:
                found.append(float(np.angle(got[k] / exact[k])) / measured.phase_errors[k, i])
    return found


def speed(drive: dict[str, Any]) -> float:
    """Return the speed of the part [m/s]."""
    return float(vibro.solve(vibro.Scene(**drive, **PART)).mean_velocity)


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--feeders", type=int, default=60)
    count = parser.parse_args().feeders
    print(f"{'noise':>12} {'1 error':>8} {'2 errors':>9} {'right number':>13}")
    for density, name in ((QUIET, "0.2 mg/rtHz"), (10.0 * QUIET, "2 mg/rtHz")):
        scores, right = [], 0
        for seed in range(count):
            measured = motion_of(feeder(seed).record(seed, seconds=1.0, density=density))
            scores += standard_scores(measured, feeder(seed))
            right += measured.order == feeder(seed).along.size
        within = [float(np.mean(np.abs(scores) < errors)) for errors in (1.0, 2.0)]
        print(f"{name:>12} {within[0]:8.1%} {within[1]:9.1%} {right:6} of {count}")
    off: dict[str, list[float]] = {"line": [], "harmonics": []}
    for seed in range(count):
        true = feeder(seed)
        measured, exact = motion_of(true.record(seed, seconds=4.0)), speed(true.drive())
        line = {name: estimate.value for name, estimate in measured.drive_on_line().quantities.items()}
        off["line"].append(abs(speed(line) / exact - 1.0))
        off["harmonics"].append(abs(speed(measured.drive()) / exact - 1.0))
    print(f"\n{'taken for':>12} {'median':>8} {'one in ten':>11}")
    for name, values in off.items():
        print(f"{name:>12} {np.median(values):8.2%} {np.quantile(values, 0.9):11.2%}")


if __name__ == "__main__":
    main()
