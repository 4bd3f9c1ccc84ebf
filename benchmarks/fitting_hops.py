"""How long fits of bodies that hop take, and what they find.

Usage: python benchmarks/fitting_hops.py [--only TEXT]

Each record has 8 cycles of 40 samples from an unknown trigger time on, and normal noise of 2 % of its peak;
the fit begins at coefficients that are 20 % too large. Records are sampled from the package's own motion:
how often intervals hold is not counted here. Seconds are those of the processor.
"""

from __future__ import annotations

import argparse
import math
import time
from typing import Any, Final, NamedTuple

import numpy as np

import vibro
from vibro.motion.settled import settled_motion
from vibro.records.alignment import Observation
from vibro.records.fitting import fit

FRICTION: Final = ("static_friction", "kinetic_friction")


class Case(NamedTuple):
    """A body that hops, what is measured of it, and what is fitted."""

    name: str
    signal: str
    fitted: tuple[str, ...]
    scene: dict[str, Any]


def line(throw: float, degrees: float, frequency: float, **others: float) -> dict[str, Any]:
    alpha, rate = math.radians(degrees), math.tau * frequency
    amplitude = throw * 9.81 / math.sin(alpha) / rate**2
    given = {"static_friction": 0.4, "kinetic_friction": 0.3} | others
    return {"amplitude": amplitude, "frequency": frequency, "drive_angle": alpha, **given}


ELLIPSE: Final = {
    "along_amplitude": 1e-3, "normal_amplitude": 1.3e-3, "normal_phase": math.radians(-60.0),
    "frequency": 15.0, "static_friction": 0.4, "kinetic_friction": 0.3,
}  # fmt: skip
HARMONICS: Final = {
    "along_harmonics": [(1e-3, 0.0), (2e-4, 1.0)], "normal_harmonics": [(8e-4, 0.0), (1e-4, 1.0)],
    "frequency": 20.0, "static_friction": 0.4, "kinetic_friction": 0.3,
}  # fmt: skip
CASES: Final = (
    Case("a little, K = 1.1", "displacement", FRICTION, line(1.1, 30.0, 50.0)),
    Case("K = 1.6", "velocity", FRICTION, line(1.6, 25.0, 25.0)),
    Case("K = 2.6, one flight", "displacement", ("kinetic_friction",), line(2.6, 35.0, 50.0)),
    Case("bounces, e = 0.4", "velocity", ("kinetic_friction",), line(1.1, 30.0, 30.0, restitution=0.4)),
    Case("A too", "velocity", ("kinetic_friction", "amplitude"), line(1.6, 25.0, 25.0)),
    Case("A and alpha too", "displacement", (*FRICTION, "amplitude", "drive_angle"), line(1.6, 25.0, 25.0)),
    Case("ellipse", "velocity", FRICTION, ELLIPSE),
    Case("ellipse, phase too", "velocity", ("kinetic_friction", "normal_phase"), ELLIPSE),
    Case("two harmonics", "displacement", FRICTION, HARMONICS),
)


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--only", default="", metavar="TEXT", help="in the names of bodies")
    only = parser.parse_args().only
    print(f"{'body':20} {'signal':12} {'pattern':8} {'s':>6}  found (true)")
    for seed, case in enumerate(CASES):
        if only not in case.name:
            continue
        motion = settled_motion(vibro.Scene(**case.scene))
        clock = np.arange(8 * 40) / 40.0 * motion.period
        exact = getattr(motion.sample(clock + 0.3 * motion.period), _FIELDS[case.signal])
        size = float(np.ptp(exact[:40]))
        noisy = exact + 0.02 * size * np.random.default_rng(seed).standard_normal(clock.size)
        observation = Observation(clock, {case.signal: noisy}, 1.0 / motion.period)
        start = vibro.Scene(**case.scene | {name: 1.2 * case.scene[name] for name in FRICTION})
        begun = time.process_time()
        found = fit(start, observation, case.fitted)
        seconds = time.process_time() - begun
        told = ", ".join(
            f"{p.name} {p.low:.5g} ... {p.high:.5g} ({case.scene[p.name]:.5g})" for p in found.parameters
        )
        print(f"{case.name:20} {case.signal:12} {motion.pattern:8} {seconds:6.2f}  {told}", flush=True)


_FIELDS: Final = {"displacement": "position", "velocity": "velocity"}


if __name__ == "__main__":
    main()
