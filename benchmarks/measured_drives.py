"""How often intervals of fitted friction hold the truth, where sensors are as data sheets say.

Usage: python benchmarks/measured_drives.py [--records 40] [--seed 1] [--kinds tilt gain ...]

Each record goes through ``vibro measure DATA.csv --trough-along ... --fit mu_s,mu_d --json``, as a user's
would, from coefficients up to 30 % wrong. Motions and sensors are those of tests/engines/sensed.py, which
share nothing with the package: a body in contact, by Newton's law, a fifth each of the patterns F_, FB_,
F_B_, FB and F_B, 10 to 60 Hz, half of them climbing; its displacement, its velocity, or its acceleration over
the ground. A record has 60 cycles of 2000 samples a second, noise of 1 % of A (of A w, A w^2) on the body and
of 5 % on the trough. Kinds, of which errors are normal with the standard errors that are usual:

  plain, jitter, rounded     exact sensors; samples late or early by 0.3 sample times; 256 steps, low noise
  tilt of 1, tilt            sensors on the trough turned by -1 or 1 deg; by random angles
  gain, cross, all           gains of three sensors; cross-axis sensitivities; both and tilt
  one sensor                 that along the trough alone, all errors, a drive angle stated with its own
  filter, filter told        a low-pass filter of 40 Hz in all channels, not stated and stated
  angle of 1, size of 3      no sensor on the trough: an angle 1 deg off, an amplitude 3 % off; both are
  stated                     random
  harmonics                  a second and a third harmonic, sensors with all errors

The table counts the values asked for; the refused ones, which have no interval; the points, which have an
estimate, and what share of their intervals holds the true value; the ranges, which have an interval alone;
what share of all that is answered holds; of those that do not, how many say that the intervals may miss the
truth. Beyond is the largest distance of a true value from the nearest interval, over half their hull, where
that is not said; width the median of that half for the points, relative to the true value. Seconds are those
of the processor.
"""

from __future__ import annotations

import argparse
import json
import math
import sys
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any, Final, NamedTuple

import numpy as np
from typer.testing import CliRunner

from vibro.cli.app import app

sys.path.insert(0, str(Path(__file__).parents[1] / "tests"))
from engines.sensed import Drawn, Sensors, draw, record

DEGREE: Final = math.pi / 180.0
UNITS: Final = {
    "displacement": ("x [mm]", 1e3),
    "velocity": ("v [mm/s]", 1e3),
    "acceleration": ("a [m/s^2]", 1.0),
}
STATED: Final = ("angle of 1", "size of 3", "stated")
EXACT: Final[dict[str, Sensors]] = {
    "jitter": Sensors(late=0.3),
    "rounded": Sensors(digits=256.0, noise=(0.005, 0.001)),
    "filter": Sensors(corner=40.0),
    "filter told": Sensors(corner=40.0),
}
#: Standard errors of tilt, gain and cross-axis sensitivity.
RANDOM: Final = {
    "tilt": (DEGREE, 0.0, 0.0),
    "gain": (0.0, 0.03, 0.0),
    "cross": (0.0, 0.0, 0.03),
    **dict.fromkeys(("all", "one sensor", "harmonics"), (DEGREE, 0.03, 0.03)),
}
KINDS: Final = (
    "plain", "jitter", "rounded", "tilt of 1", "tilt", "gain", "cross", "all", "one sensor", "filter told",
    *STATED, "filter", "harmonics",
)  # fmt: skip


class Answer(NamedTuple):
    """One fitted value: where it comes from, its intervals, what is true and what was said."""

    kind: str
    signal: str
    pattern: str
    name: str
    intervals: list[list[float]]
    is_point: bool
    true: float
    said: str
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

    @property
    def is_warned(self) -> bool:
        """Whether the answer doubts its intervals."""
        return "may miss the truth" in self.said


def sensors_of(kind: str, random: np.random.Generator, sign: float) -> Sensors:
    """Return the sensors of a record, with random errors or those of the kind."""
    if kind == "tilt of 1":
        return Sensors(tilt=sign * DEGREE)
    if kind not in RANDOM:
        return EXACT.get(kind, Sensors())
    tilt, gain, cross = RANDOM[kind]
    numbers = random.standard_normal(7)
    gains, crosses = (size * part for size, part in zip((gain, cross), np.split(numbers[1:], 2), strict=True))
    return Sensors(tilt * float(numbers[0]), tuple(gains.tolist()), tuple(crosses.tolist()))


def arguments_of(
    path: Path, random: np.random.Generator, drawn: Drawn, kind: str, sign: float, names: str
) -> list[str]:
    """Write a record; return the arguments of ``vibro measure`` to fit friction."""
    columns = record(random, drawn, sensors_of(kind, random, sign))
    header, size = UNITS[drawn.kind]
    table = {"t [s]": columns["time"]}
    if kind in STATED:
        turned = {"angle of 1": sign, "stated": random.standard_normal()}.get(kind, 0.0)
        share = 0.03 * {"size of 3": sign, "stated": random.standard_normal()}.get(kind, 0.0)
        drive = ["-A", f"{1e3 * drawn.amplitude * (1.0 + share):.12g}"]
        drive += ["-f", f"{drawn.body.along.frequency:.12g}", "-a", f"{drawn.angle / DEGREE + turned:.12g}"]
    else:
        ways = ("along",) if kind == "one sensor" else ("along", "normal")
        table |= {f"{way} [m/s^2]": columns[way] for way in ways}
        drive = [text for way in ways for text in (f"--trough-{way}", f"{way} [m/s^2]")]
        if kind == "one sensor":
            drive += ["-a", f"{drawn.angle / DEGREE + random.standard_normal():.12g}"]
    table[header] = size * columns[drawn.kind]
    rows = np.stack(list(table.values()), axis=1)
    np.savetxt(path, rows, "%.9g", ",", header=",".join(table), comments="")
    mu_s = drawn.frictions[0] * random.uniform(0.7, 1.3)
    mu_d = min(drawn.frictions[1] * random.uniform(0.7, 1.3), mu_s)
    return [
        str(path), *drive, "--mu-s", f"{mu_s:.6g}", "--mu-d", f"{mu_d:.6g}", "--fit", names,
        "--trough-angle", f"{drawn.slope / DEGREE:.12g}", f"--{drawn.kind}", header,
        *(["--absolute"] if drawn.kind == "acceleration" else []),
        *(["--sensor", "lowpass=40Hz"] if kind == "filter told" else []),
    ]  # fmt: skip


def fitted(kind: str, numbers: range | list[int], seed: int, names: str) -> Iterator[Answer]:
    """Fit records one after the other."""
    for number in numbers:
        random = np.random.default_rng((seed, sum(kind.encode()), number))
        drawn = draw(random, number, harmonics=kind == "harmonics")
        with tempfile.TemporaryDirectory() as folder:
            arguments = arguments_of(
                Path(folder) / "record.csv", random, drawn, kind, 1.0 if number % 2 else -1.0, names
            )
            begun = time.process_time()
            result = CliRunner().invoke(app, ["measure", *arguments, "--json"], catch_exceptions=False)
            seconds = time.process_time() - begun
        found: dict[str, Any] = {}
        said = result.stderr
        if not result.exit_code:
            content = json.loads(result.stdout)
            found, said = content["fit"], " / ".join([*content["warnings"], *content["notes"]])
        true = dict(zip(("static_friction", "kinetic_friction"), drawn.frictions, strict=True))
        true |= {"amplitude": 1e3 * drawn.amplitude, "drive_angle": drawn.angle / DEGREE}
        about = kind, drawn.kind, drawn.body.pattern
        for name in found or ("static_friction", "kinetic_friction"):
            one = found.get(name, {"intervals": [], "estimate": None})
            is_point = one["estimate"] is not None
            yield Answer(*about, name, one["intervals"], is_point, true[name], said, seconds, number)


def print_table(answers: list[Answer], group: str) -> None:
    """Print what the answers of each kind, and all of them, are worth."""
    print(
        f"{group:>16} {'values':>7} {'refused':>8} {'points':>7} {'hold':>7} {'ranges':>7} {'all hold':>9}"
        f" {'said':>5} {'beyond':>7} {'width':>7} {'s a fit':>8} {'longest':>8}"
    )
    for name in (*dict.fromkeys(getattr(a, group) for a in answers), "all"):
        part = [a for a in answers if name in (getattr(a, group), "all")]
        given = [a for a in part if a.intervals]
        points = [a for a in given if a.is_point]
        held, held_points = (sum(a.beyond == 0.0 for a in some) for some in (given, points))
        share, share_points = held / max(len(given), 1), held_points / max(len(points), 1)
        width = np.median([a.half / a.true for a in points]) if points else math.nan
        seconds = [a.seconds for a in part]
        print(
            f"{name:>16} {len(part):7} {len(part) - len(given):8} {len(points):7} {share_points:7.1%}"
            f" {len(given) - len(points):7} {share:9.1%} {sum(a.is_warned and a.beyond > 0 for a in given):5}"
            f" {max((a.beyond for a in given if not a.is_warned), default=0.0):7.2f} {width:7.2%}"
            f" {np.mean(seconds):8.2f} {max(seconds):8.2f}"
        )
    print()


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--records", type=int, default=40, help="of each kind")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--kinds", nargs="*", default=KINDS)
    parser.add_argument("--only", type=int, nargs="*", help="numbers of records, of which each value is told")
    parser.add_argument("--fit", default="mu_s,mu_d")
    arguments = parser.parse_args()
    answers = []
    for kind in arguments.kinds:
        numbers = arguments.only or range(arguments.records)
        for a in fitted(kind, numbers, arguments.seed, arguments.fit):
            answers.append(a)
            if arguments.only or not a.intervals or a.beyond:
                beyond = f"{a.beyond:.2f}" if a.intervals else "refused"
                told = " or ".join(f"{low:.4f} ... {high:.4f}" for low, high in a.intervals)
                where = f"{a.record:3} {a.kind:10} {a.signal:12} {a.pattern:4} {a.name:16} {a.true:.4f}"
                print(f"{where}: {told} {beyond} {a.seconds:.1f} s {a.said}", flush=True)
    for group in ("kind", "signal", "pattern", "name"):
        print_table(answers, group)


if __name__ == "__main__":
    main()
