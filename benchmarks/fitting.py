"""Do the intervals of fitted friction hold what they should? Simulated records with known coefficients.

Usage: python benchmarks/fitting.py [--records 800] [--seed 1]

Scenes are drawn at random, a fifth each of the patterns F_, FB_, F_B_, FB and F_B, one half on a level trough
and one half climbing by up to 8 deg: drive angle 10-40 deg, mu_s 0.1-0.9, mu_d/mu_s 0.5-1, 10-60 Hz, any load
below the hop. A record has 6 cycles of 50-200 samples from a random trigger time on, and normal noise of
1-5 % of its peak. Its motion comes from the walk of the tests, which shares nothing with the package. Kinds:

  velocity       the relative velocity
  displacement   the relative displacement; peak means its range within a cycle
  jitter         the velocity, each sample taken early or late by a normal 0.3 sample times
  offset         the velocity with an offset of 3 % of its peak, and a drift of as much over the record

mu_s and mu_d are fitted from a scene whose coefficients are up to 30 % wrong. Of each kind the table counts
the values asked for; the refused ones, which have no interval; the points, which have an estimate; the
ranges, which have an interval alone; and what share of points, and of all that is answered, holds the true
value. Beyond is the largest distance of a true value from the nearest interval of its answer, over half the
hull of these intervals. Width is the median half-width of the points, relative to the true value.
"""

from __future__ import annotations

import argparse
import math
import sys
import time
from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from typing import Any, Final, NamedTuple

import numpy as np

import vibro
from vibro.records.alignment import Observation
from vibro.records.fitting import Parameter, fit

sys.path.insert(0, str(Path(__file__).parents[1] / "tests"))
from helpers.made_records import Walked

CYCLES: Final = 6
JITTER: Final = 0.3  # [sample times]
OFFSET: Final = 0.03  # of the peak
PATTERNS: Final = ("F_", "FB_", "F_B_", "FB", "F_B")
KINDS: Final = ("velocity", "displacement", "jitter", "offset")
NAMES: Final = ("static_friction", "kinetic_friction")


class Answer(NamedTuple):
    """One fitted value: where it comes from, what was found, what is true, and what was said about it."""

    kind: str
    pattern: str
    parameter: Parameter
    true: float
    statements: tuple[str, ...]
    seconds: float
    record: int

    @property
    def beyond(self) -> float:
        """Distance of the true value from the nearest interval over half the hull; NaN if refused."""
        pieces = self.parameter.intervals
        if not pieces:
            return math.nan
        distance = min(max(low - self.true, self.true - high, 0.0) for low, high in pieces)
        return distance / (0.5 * (pieces[-1][1] - pieces[0][0])) if distance else 0.0


def draw_scene(random: np.random.Generator, pattern: str) -> tuple[vibro.Scene, Walked]:
    """Draw scenes until one has the pattern."""
    while True:
        alpha = math.radians(random.uniform(10.0, 40.0))
        beta = math.radians(random.choice([0.0, random.uniform(0.0, 8.0)]))
        mu_s, frequency = random.uniform(0.1, 0.9), random.uniform(10.0, 60.0)
        load = random.uniform(0.1, 0.99) * math.cos(beta) / math.sin(alpha)
        scene = vibro.Scene(
            amplitude=load * 9.81 / (2.0 * math.pi * frequency) ** 2,
            frequency=frequency,
            drive_angle=alpha,
            static_friction=mu_s,
            kinetic_friction=mu_s * random.uniform(0.5, 1.0),
            trough_angle=beta,
            gravity=9.81,
        )
        try:
            walked = Walked(scene)
        except ArithmeticError:  # it runs away
            continue
        if walked.pattern == pattern:
            return scene, walked


def record_of(random: np.random.Generator, walked: Walked, kind: str) -> Observation:
    """Sample a motion with noise."""
    step = walked.period / random.uniform(50.0, 200.0)
    clock = np.arange(0.0, CYCLES * walked.period, step)
    trough = clock + random.uniform(0.0, walked.period)
    if kind == "jitter":
        trough += JITTER * step * random.standard_normal(clock.size)
    cycle = np.linspace(0.0, walked.period, 2001)
    if kind == "displacement":
        name, exact, peak = kind, walked.displacement(trough), float(np.ptp(walked.displacement(cycle)))
    else:
        name, exact, peak = "velocity", walked.velocity(trough), float(np.abs(walked.velocity(cycle)).max())
    values = exact + random.uniform(0.01, 0.05) * peak * random.standard_normal(clock.size)
    if kind == "offset":
        values += OFFSET * peak * random.choice([-1.0, 1.0])
        values += OFFSET * peak * random.choice([-1.0, 1.0]) * (clock / clock[-1] - 0.5)
    return Observation(clock, {name: values}, 1.0 / walked.period)


def fitted(records: int, seed: int, only: int | None = None) -> Iterator[Answer]:
    """Fit records one after the other."""
    for number in range(records) if only is None else (only,):
        random = np.random.default_rng((seed, number))
        kind = KINDS[number % len(KINDS)]
        pattern = PATTERNS[number // len(KINDS) % len(PATTERNS)]
        scene, walked = draw_scene(random, pattern)
        observation = record_of(random, walked, kind)
        values: dict[str, Any] = {field: float(getattr(scene, field)) for field in scene.arrays()._fields}
        start = values | {"static_friction": values["static_friction"] * random.uniform(0.7, 1.3)}
        start["kinetic_friction"] *= random.uniform(0.7, 1.3)
        start["kinetic_friction"] = min(start["kinetic_friction"], start["static_friction"])
        begun = time.perf_counter()
        found = fit(vibro.Scene(**start), observation, NAMES)
        seconds = time.perf_counter() - begun
        for parameter in found.parameters:
            yield Answer(kind, pattern, parameter, values[parameter.name], found.statements, seconds, number)


def print_table(answers: list[Answer], group: str) -> None:
    """Print what the answers of each kind, or pattern, and all of them are worth."""
    print(
        f"{group:>14} {'values':>7} {'refused':>8} {'points':>7} {'hold':>7} {'ranges':>7} {'all hold':>9}"
        f" {'beyond':>7} {'width':>7} {'s a fit':>8}"
    )
    for name in (*dict.fromkeys(getattr(a, group) for a in answers), "all"):
        part = [a for a in answers if name in (getattr(a, group), "all")]
        given = [a for a in part if a.parameter.intervals]
        points = [a for a in given if a.parameter.identified]
        held, held_points = (sum(a.beyond == 0.0 for a in some) for some in (given, points))
        widths = [(a.parameter.high - a.parameter.low) / (2.0 * a.true) for a in points]
        print(
            f"{name:>14} {len(part):7} {1.0 - len(given) / len(part):8.1%} {len(points):7}"
            f" {held_points / max(len(points), 1):7.1%} {len(given) - len(points):7}"
            f" {held / max(len(given), 1):9.1%} {max((a.beyond for a in given), default=0.0):7.2f}"
            f" {np.median(widths) if widths else math.nan:7.2%} {np.mean([a.seconds for a in part]):8.2f}"
        )
    print()


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--records", type=int, default=800)
    parser.add_argument("--seed", type=int, default=1)
    arguments = parser.parse_args()
    answers = list(fitted(arguments.records, arguments.seed))
    print_table(answers, "kind")
    print_table(answers, "pattern")
    reasons = Counter(" / ".join(a.statements) or "no reason" for a in answers if not a.parameter.intervals)
    print("refused because:")
    for reason, count in reasons.most_common():
        print(f"{count:5}  {reason}")


if __name__ == "__main__":
    main()
