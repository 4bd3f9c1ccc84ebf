"""How often intervals of fitted friction hold the truth where accelerometers measured the drive.

Usage: python benchmarks/measured_drives.py [--records 200] [--seed 1]

Each record goes through ``vibro measure DATA.csv --trough-along ... --fit mu_s,mu_d --json``, as a user's
would, from coefficients up to 30 % wrong. Its motion comes from tests/engines/harmonic_flight.py, which
shares nothing with the package. Scenes are drawn at random: drive angle 10-40 deg, mu_s 0.1-0.9, mu_d/mu_s
0.5-1, 10-60 Hz, one half climbing by up to 6 deg; of each ten records eight stay in contact, and two hop with
a motion that repeats in every cycle. Kinds:

  sine        the trough moves along a line as a sine
  harmonics   its acceleration has a second harmonic of 2-40 % and a third of up to half of that, whose
              phases along the trough and normal to it differ

A record has 8-25 cycles of 30-100 samples from a random trigger time on: the displacement or the velocity of
the body, with noise of 0.5-5 % of its peak, and the trough's accelerations, with noise of 0.2-5 % of the
drive's. One fifth of the sines has one accelerometer alone and a known drive angle. In one half of the
records the noise of every sensor is correlated: an AR(1) process of 0.3-0.8.

The table counts the values asked for; the refused ones, which have no interval; the points, which have an
estimate, and what share of their intervals holds the true value, with its standard error; the ranges, which
have an interval alone; and what share of all that is answered holds the true value. Beyond is the largest
distance of a true value from the nearest interval of its answer, over half the hull of these intervals;
width the median of that half for the points, relative to the true value. Seconds are those of the processor.
"""

from __future__ import annotations

import argparse
import json
import math
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.signal import lfilter
from typer.testing import CliRunner

from vibro.cli.app import app

sys.path.insert(0, str(Path(__file__).parents[1] / "tests"))
from engines.harmonic_flight import Body, NeverRepeatsError, Settled

KINDS: Final = ("sine", "harmonics")
GRAVITY: Final = 9.81
TURN: Final = 2.0 * math.pi
SETTLING: Final = 80  # [cycles]

Floats = NDArray[np.float64]
Complexes = NDArray[np.complex128]


class Drawn(NamedTuple):
    """A feeder and how it is recorded.

    Lengths are counted in g/w^2; the trough's acceleration along each axis is minus the sum of
    Im(w_n exp(i n p)), in g.
    """

    frequency: float
    drive_angle: float
    trough_angle: float
    along: Complexes
    normal: Complexes
    settled: Settled
    true: dict[str, float]
    motion: str
    signal: str
    noise: str
    cycles: int
    one_sensor: bool


def _phases(random: np.random.Generator, size: int) -> NDArray[np.float64]:
    return np.append(0.0, random.uniform(-math.pi, math.pi, size - 1))


def draw_record(random: np.random.Generator, *, harmonics: bool, hops: bool) -> Drawn:
    """Draw feeders until one moves its body, with flights or without, and repeats in every cycle."""
    cycles = int(random.integers(8, 26))
    while True:
        alpha = math.radians(random.uniform(10.0, 40.0))
        beta = math.radians(random.choice([0.0, random.uniform(0.0, 6.0)]))
        static = random.uniform(0.1, 0.9)
        kinetic = static * random.uniform(0.5, 1.0)
        throw = random.uniform(1.05, 2.2) if hops else random.uniform(0.1, 0.95)
        load = throw * math.cos(beta) / math.sin(alpha)
        second = math.exp(random.uniform(math.log(0.02), math.log(0.4)))
        shares = np.array([1.0, second, second * random.uniform(0.0, 0.5)])
        shares = shares if harmonics else shares[:1]
        ways: list[Complexes] = [
            np.asarray(load * part * shares * np.exp(1j * _phases(random, shares.size)), np.complex128)
            for part in (math.cos(alpha), math.sin(alpha))
        ]
        try:
            settled = Settled(Body(ways[0], ways[1], static, kinetic, beta), cycles + 3, SETTLING)
        except NeverRepeatsError:
            continue
        if ("H" in settled.kinds) == hops and set(settled.kinds) & set("FB"):
            break
    return Drawn(
        frequency=random.uniform(10.0, 60.0),
        drive_angle=alpha,
        trough_angle=beta,
        along=ways[0],
        normal=ways[1],
        settled=settled,
        true={"static_friction": static, "kinetic_friction": kinetic},
        motion="hops" if hops else "slides",
        signal=str(random.choice(["displacement", "velocity"])),
        noise=str(random.choice(["white", "AR(1)"])),
        cycles=cycles,
        one_sensor=not harmonics and random.random() < 0.2,
    )


def write_record(path: Path, random: np.random.Generator, drawn: Drawn) -> list[str]:
    """Sample a feeder with noise into a file; return the arguments of ``vibro measure`` to fit friction."""
    rate = TURN * drawn.frequency
    samples = random.uniform(30.0, 100.0)
    time = np.arange(int(drawn.cycles * samples)) / (samples * drawn.frequency)
    phase = rate * time + random.uniform(0.0, TURN)
    lasting = random.uniform(0.3, 0.8) if drawn.noise == "AR(1)" else 0.0

    def noise(size: float) -> Floats:
        white = random.standard_normal(time.size + 100)
        made = lfilter([math.sqrt(1.0 - lasting**2)], [1.0, -lasting], white)[100:]
        return np.asarray(size * made)

    cycle = np.linspace(0.0, TURN, 2001)
    if drawn.signal == "displacement":
        header, unit = "x [mm]", 1e3 * GRAVITY / rate**2
        exact, peak = drawn.settled.path(phase), float(np.ptp(drawn.settled.path(cycle)))
    else:
        header, unit = "v [mm/s]", 1e3 * GRAVITY / rate
        exact, peak = drawn.settled.speed(phase), float(np.abs(drawn.settled.speed(cycle)).max())
    columns = {"t [s]": time, header: unit * (exact - exact[0] + noise(random.uniform(0.005, 0.05) * peak))}
    if drawn.signal == "velocity":
        columns[header] += unit * exact[0]
    size = math.exp(random.uniform(math.log(0.002), math.log(0.05)))
    strength = size * math.hypot(abs(drawn.along[0]), abs(drawn.normal[0]))
    orders = np.arange(1, drawn.along.size + 1)
    for name, waves in (("along", drawn.along), ("normal", drawn.normal)):
        exact = -(np.exp(1j * np.outer(phase, orders)) @ waves).imag
        columns[f"{name} [m/s^2]"] = GRAVITY * (exact + noise(strength) + random.uniform(-1.0, 1.0))
    if drawn.one_sensor:
        del columns["normal [m/s^2]"]
    np.savetxt(
        path, np.stack(list(columns.values()), axis=1), "%.9g", ",", header=",".join(columns), comments=""
    )
    start = {name: value * random.uniform(0.7, 1.3) for name, value in drawn.true.items()}
    kinetic = min(start["kinetic_friction"], start["static_friction"])
    sensors = [*([] if drawn.one_sensor else ["--trough-normal", "normal"]), "--trough-along", "along"]
    angle = ["-a", f"{math.degrees(drawn.drive_angle):.12g}"] if drawn.one_sensor else []
    return [
        str(path), *sensors, *angle, "--mu-s", f"{start['static_friction']:.6g}", "--mu-d", f"{kinetic:.6g}",
        "--trough-angle", f"{math.degrees(drawn.trough_angle):.12g}", "--fit", "mu_s,mu_d",
    ]  # fmt: skip


class Answer(NamedTuple):
    """One fitted value: where it comes from, its intervals and what is true."""

    kind: str
    motion: str
    noise: str
    signal: str
    name: str
    intervals: list[list[float]]
    is_point: bool
    true: float
    why: str
    seconds: float
    record: int

    @property
    def beyond(self) -> float:
        """Distance of the true value from the nearest interval over half the hull."""
        distance = min(max(low - self.true, self.true - high, 0.0) for low, high in self.intervals)
        return distance / self.half if distance else 0.0

    @property
    def half(self) -> float:
        """Half the hull of the intervals."""
        return 0.5 * (self.intervals[-1][1] - self.intervals[0][0])


def fitted(numbers: Iterator[int] | range, seed: int) -> Iterator[Answer]:
    """Fit records one after the other."""
    for number in numbers:
        random = np.random.default_rng((seed, number))
        drawn = draw_record(random, harmonics=number % 2 == 1, hops=number // 2 % 5 == 4)
        begun = time.process_time()
        found, why = answer_of(random, drawn)
        seconds = time.process_time() - begun
        kinds = KINDS[number % 2], drawn.motion, drawn.noise, drawn.signal
        for name, true in drawn.true.items():
            intervals, is_point = found.get(name, ([], False))
            yield Answer(*kinds, name, intervals, is_point, true, why, seconds, number)


def answer_of(
    random: np.random.Generator, drawn: Drawn
) -> tuple[dict[str, tuple[list[list[float]], bool]], str]:
    """Return the intervals that the command prints, whether it tells an estimate, and what it says."""
    with tempfile.TemporaryDirectory() as folder:
        arguments = write_record(Path(folder) / "record.csv", random, drawn)
        result = CliRunner().invoke(app, ["measure", *arguments, "--json"], catch_exceptions=False)
    if result.exit_code:
        return {}, next(line for line in result.stderr.splitlines() if line.startswith("error"))
    content = json.loads(result.stdout)
    found = {name: (p["intervals"], p["estimate"] is not None) for name, p in content["fit"].items()}
    return found, " / ".join(content["notes"])


def print_table(answers: list[Answer], group: str) -> None:
    """Print what the answers of each kind, and all of them, are worth."""
    print(
        f"{group:>16} {'values':>7} {'refused':>8} {'points':>7} {'hold':>7} {'+-':>6} {'ranges':>7}"
        f" {'all hold':>9} {'beyond':>7} {'width':>7} {'s a fit':>8} {'longest':>8}"
    )
    for name in (*dict.fromkeys(getattr(a, group) for a in answers), "all"):
        part = [a for a in answers if name in (getattr(a, group), "all")]
        given = [a for a in part if a.intervals]
        points = [a for a in given if a.is_point]
        held, held_points = (sum(a.beyond == 0.0 for a in some) for some in (given, points))
        share = held_points / max(len(points), 1)
        error = math.sqrt(share * (1.0 - share) / max(len(points), 1))
        width = np.median([a.half / a.true for a in points]) if points else math.nan
        print(
            f"{name:>16} {len(part):7} {1.0 - len(given) / len(part):8.1%} {len(points):7} {share:7.1%}"
            f" {error:6.1%} {len(given) - len(points):7} {held / max(len(given), 1):9.1%}"
            f" {max((a.beyond for a in given), default=0.0):7.2f} {width:7.2%}"
            f" {np.mean([a.seconds for a in part]):8.2f} {max(a.seconds for a in part):8.2f}"
        )
    print()


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--records", type=int, default=200)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--only", type=int, nargs="*", help="numbers of records, of which each value is told")
    arguments = parser.parse_args()
    answers = []
    for a in fitted(arguments.only or range(arguments.records), arguments.seed):
        answers.append(a)
        if arguments.only or not a.intervals or a.beyond:
            beyond = f"{a.beyond:.2f}" if a.intervals else "refused"
            told = " or ".join(f"{low:.5f} ... {high:.5f}" for low, high in a.intervals)
            print(
                f"{a.record:4} {a.kind:10} {a.motion:6} {a.noise:5} {a.signal:12} {a.name:16}"
                f" {a.true:.5f}: {told} {beyond} {a.seconds:.1f} s {a.why}",
                flush=True,
            )
    for group in ("kind", "motion", "noise", "signal", "name"):
        print_table(answers, group)
    reasons = Counter(a.why or "no reason" for a in answers if not a.intervals)
    print("refused because:")
    for reason, count in reasons.most_common():
        print(f"{count:5}  {reason}")


if __name__ == "__main__":
    main()
