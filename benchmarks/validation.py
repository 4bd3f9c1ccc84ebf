"""Does the model convey as a laboratory measured? Parts clamped on a vibrating finger (theory/validation).

Usage: python benchmarks/validation.py                   mean cycles of the trials, and the runs
       python benchmarks/validation.py --add TABLE.csv   compare somebody's measured speeds

Trials: C. L. Yako, J. Nowak, S. Yuan, K. Salisbury, "Vertical Vibratory Transport of Grasped Parts Using
Impacts", arXiv:2502.05693 (2025). A finger moves up slowly and is knocked down by impacts; a part pressed on
it by a constant force climbs. Ten records of both, 960 positions a second. They are public without a licence
(https://github.com/clyako/vertical-vibratory-transport-of-grasped-parts-using-impacts, ``matlab/data``), so
that ``data/grasped_part.csv`` holds what was measured: of each trial the normal force over the part's weight,
the velocity of the finger over one cycle, the mean of the last whole ones, and the part's advance a cycle.
Friction is as measured, nothing is fitted.

Runs: C. L. Yako, S. Yuan, K. Salisbury, "Two Degree-of-Freedom Vibratory Transport in a Grasp",
arXiv:2605.30780 (2026). A finger under control of its position rises gently and drops fast. The records are
public without a licence (https://github.com/clyako/2-DoF-vibrational-transport, ``python/data``), so that
``data/clamped_runs.csv`` holds what was commanded (frequency, both accelerations) and measured (normal force,
how often the motion repeats, the part's speed between marks at 5.056 and 10.644 mm, as the authors take it).
"""

from __future__ import annotations

import argparse
import csv
import math
from pathlib import Path
from typing import Any, Final, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.interpolate import CubicSpline

import vibro
from vibro.errors import InputError, Problems, VibroError
from vibro.files.points import read_speeds
from vibro.files.reading import read_text, rows_of

Floats = NDArray[np.float64]

TABLE: Final = Path(__file__).parent / "data" / "grasped_part.csv"
FRICTION = STATIC_FRICTION, KINETIC_FRICTION = 0.72, 0.59  # as the authors' scripts have them
GRAVITY: Final = 9.81  # [m/s^2], in theirs too
STEPS: Final = 8  # [1] steps of acceleration a sample, along a cubic spline of the finger's velocity
FORCE_ERRORS: Final = (0.8, 1.0, 1.2)  # [1] times the measured normal force
WALKED_CYCLES: Final = 400
MM: Final = 1e-3


# The 67 runs.
RUNS: Final = TABLE.with_name("clamped_runs.csv")
MASS: Final = 0.358  # [kg] of the part, in the script that computes the waveform
# Static and kinetic friction: in that script, and as the authors' page has it, from later tests.
SCRIPT_FRICTION, PAGE_FRICTION = (0.22, 0.19), (0.44, 0.34)

# Columns of a table of measured speeds that are no input of a scene, and those that it must have.
TOLD: Final = ("mean_velocity", "velocity", "mean_speed", "speed", "error", "source")
NEEDED: Final = ("static_friction", "kinetic_friction", "source")


class Trial(NamedTuple):
    """One mean cycle of a record.

    Attributes
    ----------
    number, cycles : int
        Of the trial, and how many cycles the mean is of.
    force : float
        Normal force over the part's weight [1].
    period : float
        [s].
    advance, error : float
        Of the part relative to the finger a cycle [m], and its standard error (NaN of a single cycle).
    finger : array
        Velocity of the finger, equally spaced over the period [m/s].
    """

    number: int
    cycles: int
    force: float
    period: float
    advance: float
    error: float
    finger: Floats


class Run(NamedTuple):
    """A part that climbs a finger with two accelerations.

    Attributes
    ----------
    frequency, rise, drop : float
        As commanded [Hz], and accelerations upwards and downwards [g].
    force : float
        Mean normal force [N].
    repeats : float
        Frequency at which the part's motion repeats itself [Hz].
    cycles : float
        Over which the speed is the mean.
    speed, error : float
        Of the part, upwards, and its standard error (NaN of a single cycle) [mm/s].
    """

    frequency: float
    rise: float
    drop: float
    force: float
    repeats: float
    cycles: float
    speed: float
    error: float


def walk(velocity: Floats, step: ArrayLike, static: float, kinetic: float, start: float = 0.0) -> Floats:
    """Follow a part on a finger whose velocity is linear between given times, slide by slide.

    A witness: it shares nothing with ``vibro``.

    Parameters
    ----------
    velocity : array
        Of the finger, upwards [m/s].
    step : float or array
        Between two of them [s].
    static, kinetic : float
        Friction times normal force over mass [m/s^2].
    start : float
        Velocity of the part relative to the finger at first [m/s].

    Returns
    -------
    array
        Position of the part relative to the finger at those times [m].
    """
    way, speed, place, places = math.copysign(1.0, start), start, 0.0, [0.0]
    slides = start != 0.0
    changes = np.diff(velocity)
    for change, left in zip(changes.tolist(), np.broadcast_to(step, changes.shape).tolist(), strict=True):
        pull = -GRAVITY - change / left  # what moves the part against the finger, but for friction
        while left > 0.0:
            if not slides:
                if abs(pull) <= static:
                    break
                slides, way = True, math.copysign(1.0, pull)
            rate = pull - way * kinetic
            stop = -speed / rate if speed * rate < 0.0 else math.inf
            time = min(stop, left)
            place += (speed + 0.5 * rate * time) * time
            speed += rate * time
            left -= time
            if stop <= time:
                slides, speed = False, 0.0
        places.append(place)
    return np.array(places)


def walked_advance(velocity: Floats, steps: Floats, friction: tuple[float, float], force: float) -> float:
    """Advance of the part a cycle [m] by the witness, once cycles repeat."""
    static, kinetic = (mu * force * GRAVITY for mu in friction)
    run = np.append(np.tile(velocity[:-1], WALKED_CYCLES), velocity[-1])
    places = walk(run, np.tile(steps, WALKED_CYCLES), static, kinetic)[:: steps.size]
    before, last = np.diff(places)[-2:]
    assert abs(last - before) < 1e-9, "the motion does not repeat"
    return float(last)


def fine(finger: Floats) -> Floats:
    """Velocities at the ends of the steps, along a periodic cubic spline: first and last are equal."""
    nodes = np.arange(finger.size + 1)
    spline = CubicSpline(nodes, np.append(finger, finger[0]), bc_type="periodic")
    out = spline(np.arange(STEPS * finger.size + 1) / STEPS)
    out[-1] = out[0]
    return out


def read_table() -> list[Trial]:
    with TABLE.open(newline="") as file:
        return [
            Trial(
                int(row["trial"]),
                int(row["cycles"]),
                float(row["normal_force_weights"]),
                float(row["period_ms"]) * MM,
                float(row["advance_mm"]) * MM,
                float(row["advance_error_mm"]) * MM,
                np.array([float(v) for v in row["finger_mm_s"].split()]) * MM,
            )
            for row in csv.DictReader(file)
        ]


def clamped(
    durations: Floats, changes: Floats, friction: tuple[float, float], force: ArrayLike
) -> vibro.Scene:
    """Return the vertical finger as a trough, by changes of its velocity [m/s] and their times [s]."""
    period = durations.sum()
    along = list(zip((durations / period).tolist(), (changes / durations).tolist(), strict=True))
    return vibro.Scene(
        motion=vibro.Motion.steps(along=along),
        frequency=1.0 / period,
        static_friction=friction[0],
        kinetic_friction=friction[1],
        normal_acceleration=np.asarray(force) * GRAVITY,
        trough_angle=0.5 * math.pi,
        gravity=GRAVITY,
    )


def computed_advances(trial: Trial) -> Floats:
    """Advance a cycle [m] for each of ``FORCE_ERRORS``."""
    changes = np.diff(fine(trial.finger))
    durations = np.full(changes.size, trial.period / changes.size)
    forces = np.array(FORCE_ERRORS) * trial.force
    steady = vibro.solve(clamped(durations, changes, FRICTION, forces))
    return np.asarray(steady.displacement_per_cycle)


def walked_advances(trial: Trial) -> Floats:
    """Return the same by the witness."""
    velocity = fine(trial.finger)
    steps = np.full(velocity.size - 1, trial.period / (velocity.size - 1))
    return np.array([walked_advance(velocity, steps, FRICTION, x * trial.force) for x in FORCE_ERRORS])


def compare_cycles(trials: list[Trial]) -> None:
    print(
        "One mean cycle; advance of the part on the finger a cycle [mm], computed for 0.8, 1, 1.2 times the"
    )
    print(
        "measured normal force; acceleration of the finger [g], and beyond which the part slides up, down it:"
    )
    print(
        "trial  f [Hz]  N/mg  cycles  measured         x 0.8      x 1    x 1.2   finger        slides beyond"
    )
    found = np.array([computed_advances(trial) for trial in trials])
    for trial, advances in zip(trials, found / MM, strict=True):
        number, cycles, force, period, advance, error, finger = trial
        velocity = fine(finger)
        acceleration = np.diff(velocity) / period * (velocity.size - 1) / GRAVITY
        spread = f"+- {error / MM:5.3f}" if cycles > 1 else 8 * " "
        print(
            f"{number:5} {1.0 / period:7.2f} {force:6.2f} {cycles:5}   {advance / MM:6.3f} {spread}",
            *(f"{d:8.3f}" for d in advances),
            f" {acceleration.min():6.1f} to {acceleration.max():4.1f}",
            f" {-STATIC_FRICTION * force - 1.0:6.1f}, {STATIC_FRICTION * force - 1.0:5.1f}",
        )
    measured, computed = np.array([trial.advance for trial in trials]), found[:, FORCE_ERRORS.index(1.0)]
    share = computed / measured
    within = (found.min(axis=1) <= measured) & (measured <= found.max(axis=1))
    miss, median = np.mean(np.abs(computed - measured)) / MM, 100.0 * np.median(np.abs(share - 1.0))
    near = ", ".join(str(trial.number) for trial, is_near in zip(trials, within, strict=True) if is_near)
    print(
        f"right direction in {np.sum(share > 0.0)} of {len(trials)}; too small in {np.sum(share < 1.0)}",
        end="; ",
    )
    print(f"median miss {median:.0f} %, mean {miss:.3f} mm a cycle")
    print(f"measured lies between the computed ones in trials {near}")
    apart = np.abs(found - [walked_advances(trial) for trial in trials]).max() / MM
    print(f"largest difference from the witness, of {found.size} advances: {apart:.1e} mm")


def known_runs() -> list[Run]:
    return [Run(*row) for row in np.loadtxt(RUNS, delimiter=",", skiprows=1).tolist()]


def repeating(runs: list[Run]) -> list[Run]:
    """Return the runs with the finger as often as the parts repeat themselves, in place of as commanded.

    That is the median over the runs with one command. The finger follows a table of positions, so that its
    accelerations go with the square of the frequency.
    """
    found = {f: float(np.median([run.repeats for run in runs if run.frequency == f])) for f in (15.0, 20.0)}
    slower = [(found[run.frequency] / run.frequency) for run in runs]
    return [
        run._replace(frequency=x * run.frequency, rise=x**2 * run.rise, drop=x**2 * run.drop)
        for run, x in zip(runs, slower, strict=True)
    ]


def waveform(run: Run) -> tuple[Floats, Floats]:
    """Return times [s] and changes of the finger's velocity [m/s]: half the rise, the drop, half the rise."""
    half = 0.5 * run.drop / (run.rise + run.drop) / run.frequency
    times = np.array([half, 1.0 / run.frequency - 2.0 * half, half])
    return times, times * np.array([run.rise, -run.drop, run.rise]) * GRAVITY


def computed_speeds(runs: list[Run], friction: tuple[float, float]) -> Floats:
    """Speeds of the parts [mm/s]."""
    scenes = [clamped(*waveform(run), friction, run.force / MASS / GRAVITY) for run in runs]
    return np.array([float(vibro.solve(scene).mean_velocity) for scene in scenes]) / MM


def walked_speeds(runs: list[Run], friction: tuple[float, float]) -> Floats:
    """Return the same by the witness."""

    def speed(run: Run) -> float:
        times, changes = waveform(run)
        velocity = np.array([0.0, changes[0], -changes[2], 0.0])
        return run.frequency * walked_advance(velocity, times, friction, run.force / MASS / GRAVITY)

    return np.array([speed(run) for run in runs]) / MM


def closed_form(runs: list[Run], friction: tuple[float, float]) -> Floats:
    """Speeds by the authors' formula, of parts that stick while the finger accelerates upwards [mm/s]."""
    frequency, rise, drop, force, *_ = np.array(runs).T
    slowing = 1.0 + friction[1] * force / MASS / GRAVITY
    way = rise**2 * (drop - slowing) / ((rise + drop) * (rise + slowing))
    return np.asarray(0.5 * GRAVITY * way / frequency / MM)


#: What is compared: by what name, with which friction, and whether the finger is as slow as the parts.
VARIANTS: Final = (
    ("friction of the script, finger as commanded", SCRIPT_FRICTION, False),
    ("friction of the script, finger as often as parts repeat", SCRIPT_FRICTION, True),
    ("friction of the page, finger as commanded", PAGE_FRICTION, False),
)


class Misses(NamedTuple):
    """How far computed speeds are from measured ones.

    Attributes
    ----------
    median, median_absolute : float
        Of computed over measured, less 1 [%].
    rms : float
        Root mean square of the differences [mm/s].
    wrong_sign, at_rest : int
        How many are computed the wrong way, and at rest where the part moved.
    """

    median: float
    median_absolute: float
    rms: float
    wrong_sign: int
    at_rest: int

    def __str__(self) -> str:
        shares = f"median {self.median:+.1f} %, median absolute {self.median_absolute:.1f} %"
        return f"{shares}, RMS {self.rms:.1f} mm/s; wrong sign {self.wrong_sign}, at rest {self.at_rest}"


def misses(computed: Floats, measured: Floats) -> Misses:
    moved = measured != 0.0
    share = 100.0 * (computed[moved] / measured[moved] - 1.0) if moved.any() else np.array([math.nan])
    return Misses(
        float(np.median(share)),
        float(np.median(np.abs(share))),
        math.sqrt(np.mean((computed - measured) ** 2)),
        int(np.sum(computed * measured < 0.0)),
        int(np.sum((computed == 0.0) & moved)),
    )


def compare_runs(runs: list[Run]) -> None:
    print(
        "\nThe runs; speed of the part [mm/s], computed with the friction of the script, finger as commanded:"
    )
    print("f [Hz]  rise, drop [g]   N [N]  measured           computed  closed form")
    columns = (x(runs, SCRIPT_FRICTION).tolist() for x in (computed_speeds, closed_form))
    for run, speed, formula in zip(runs, *columns, strict=True):
        spread = f"+- {run.error:5.2f}" if run.cycles > 1 else 8 * " "
        setting = f"{run.frequency:6.0f}     {run.rise:4.1f}, {run.drop:4.0f}   {run.force:6.2f}"
        print(f"{setting}  {run.speed:7.2f} {spread} {speed:10.2f} {formula:12.2f}")
    measured = np.array([run.speed for run in runs])
    for name, friction, repeats in VARIANTS:
        fingers = repeating(runs) if repeats else runs
        computed = computed_speeds(fingers, friction)
        print(f"{name}\n  computed:    {misses(computed, measured)}")
        print(f"  closed form: {misses(closed_form(fingers, friction), measured)}")
        apart = np.abs(computed - walked_speeds(fingers, friction)).max()
        print(f"  largest difference from the witness: {apart:.1e} mm/s")


def compare_table(path: Path) -> Misses:
    """Print a table of measured speeds beside what is computed of them; nothing is fitted.

    Raises
    ------
    VibroError
        If a column is missing or unknown, or a cell is wrong.
    """
    speeds = read_speeds(path)
    (_, header), *rows = rows_of(path, read_text(path)[0], ",")
    wanted = [*NEEDED, *(["mean_velocity_mm_s"] if speeds.is_time else [])]
    if lacking := [name for name in wanted if name not in header]:
        hint = f"needed: {', '.join(NEEDED)}; cells are separated by commas"
        raise InputError(f"{path}: no column {', '.join(lacking)}", hint=hint)
    lines, computed = ["row      measured [mm/s]   computed  difference [%]  [errors]  source"], []
    problems = Problems(f"{path}: ")
    spreads = np.full(len(rows), math.nan) if speeds.error is None else speeds.error * np.abs(speeds.measured)
    for (number, cells), measured, spread in zip(rows, speeds.measured / MM, spreads / MM, strict=True):
        row = {name: cell for name, cell in zip(header, cells, strict=False) if cell}
        inputs: dict[str, Any] = {name: cell for name, cell in row.items() if not name.startswith(TOLD)}
        with problems.taken(f"row {number}, "):
            cycle = vibro.sweep(**inputs).cycle
            if "source" not in row:
                raise InputError("source: the cell is empty", hint="say who measured it, and where it stands")
            if cycle.mean_velocity.shape:
                raise InputError("several operating points", hint="give amplitude_mm and frequency_hz")
            if cycle.flight_fraction > 0.0 and "restitution" not in row:
                raise InputError("the part hops", hint="give restitution")
            speed = float(cycle.mean_velocity) / MM
            if not math.isfinite(speed):
                raise InputError(f"no speed: status {cycle.status}", hint="leave the row out, and say so")
            share = 100.0 * (speed / measured - 1.0) if measured else math.nan
            errors = (speed - measured) / spread if spread > 0.0 else math.nan
            numbers = f"{measured:9.3f} +- {spread:7.3f} {speed:10.3f}  {share:14.1f}  {errors:8.1f}"
            lines.append(f"{number:3} {numbers.replace('nan', '  -')}  {row['source']}")
            computed.append(speed)
    problems.settle()
    print("\n".join(lines))
    miss = misses(np.array(computed), speeds.measured / MM)
    print(miss)
    return miss


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--add", type=Path, metavar="TABLE.csv", help="compare measured speeds")
    given = parser.parse_args()
    if given.add:
        try:
            compare_table(given.add)
        except VibroError as error:
            parser.exit(1, f"{error}\n{getattr(error, 'hint', '')}\n")
        return
    compare_cycles(read_table())
    compare_runs(known_runs())


if __name__ == "__main__":
    main()
