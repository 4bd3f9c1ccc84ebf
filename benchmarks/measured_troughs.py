"""How well the speed of a part is known from the harmonics of a trough.

Usage: python benchmarks/measured_troughs.py [--feeders 60]

Feeders are those of tests/helpers/feeders.py: 20 to 60 Hz, a second and a third harmonic of 5 to 30 % of the
acceleration each, other along the trough than normal to it; noise that is white above 10 Hz and 1/f below.

The table compares for four seconds of each record the speed of a part (mu_s 0.4, mu_d 0.3) with that on the
true motion: where the motion is taken for the best line, and with its harmonics. Errors of the harmonics are
checked by tests/records/test_trough_harmonics.py.
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from typing import Any, Final

import numpy as np

import vibro
from vibro.records.trough import motion_of

sys.path.insert(0, str(Path(__file__).parents[1] / "tests"))
from helpers.feeders import feeder

PART: Final = {"static_friction": 0.4, "kinetic_friction": 0.3}


def speed(drive: dict[str, Any]) -> float:
    """Return the speed of the part [m/s]."""
    return float(vibro.solve(vibro.Scene(**drive, **PART)).mean_velocity)


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--feeders", type=int, default=60)
    count = parser.parse_args().feeders
    off: dict[str, list[float]] = {"line": [], "harmonics": []}
    for seed in range(count):
        true = feeder(seed)
        measured, exact = motion_of(true.record(seed, seconds=4.0)), speed(true.drive())
        line = {name: estimate.value for name, estimate in measured.drive_on_line().quantities.items()}
        off["line"].append(abs(speed(line) / exact - 1.0))
        off["harmonics"].append(abs(speed(measured.drive()) / exact - 1.0))
    print(f"{'taken for':>12} {'median':>8} {'one in ten':>11}")
    for name, values in off.items():
        print(f"{name:>12} {np.median(values):8.2%} {np.quantile(values, 0.9):11.2%}")


if __name__ == "__main__":
    main()
