"""Does the model convey as a laboratory measured? A part clamped on a vibrating finger (theory/validation).

Usage: python benchmarks/validation.py                            one mean cycle of each trial
       python benchmarks/validation.py --records FOLDER           the whole records too
       python benchmarks/validation.py --records FOLDER --write   make the table of mean cycles anew

Source: C. L. Yako, J. Nowak, S. Yuan, K. Salisbury, "Vertical Vibratory Transport of Grasped Parts Using
Impacts", arXiv:2502.05693 (2025). A finger moves up slowly and is knocked down by impacts; a part pressed on
it by a constant force climbs. Ten records of both, 960 positions a second. They are public without a licence,
so that FOLDER is ``matlab/data`` of a clone of
https://github.com/clyako/vertical-vibratory-transport-of-grasped-parts-using-impacts, and
``data/grasped_part.csv`` holds what was measured: of each trial the normal force over the part's weight, the
velocity of the finger over one mean cycle, and the part's advance a cycle. Friction is as measured,
nothing is fitted.
"""

from __future__ import annotations

import argparse
import csv
import math
from pathlib import Path
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.interpolate import CubicSpline

import vibro

Floats = NDArray[np.float64]

TABLE: Final = Path(__file__).parent / "data" / "grasped_part.csv"
STATIC_FRICTION, KINETIC_FRICTION, GRAVITY = (
    0.72,
    0.59,
    9.81,
)  # [1], [1], [m/s^2], as the authors' scripts have them
SAMPLING: Final = 960.0  # [1/s]
STEPS: Final = 8  # [1] steps of acceleration a sample, along a cubic spline of the finger's velocity
FORCE_ERRORS: Final = (0.8, 1.0, 1.2)  # [1] times the measured normal force
FIRST, LAST = 3, -2  # rows between which the authors read their records: velocities are missing at both ends
WALKED_CYCLES: Final = 400
CLOSING: Final = 0.1  # [s] after a record, in which the finger comes back to its first velocity
MM: Final = 1e-3
COLUMNS: Final = (
    "trial", "cycles", "normal_force_weights", "period_ms", "advance_mm", "advance_error_mm", "finger_mm_s",
)  # fmt: skip

# Normal force over the part's weight [1], as the authors' scripts list it.
NORMAL_FORCES: Final = (11.089, 16.901, 5.278, 5.278, 5.278, 5.278, 5.278, 5.278, 5.278, 22.841)
# The authors' own fit to the same records, from the same scripts: kinetic friction, and normal forces.
FITTED_FRICTION: Final = 0.6234
FITTED_FORCES: Final = (10.65, 13.0009, 9.9833, 6.7872, 6.0413, 7.0798, 6.2765, 6.618, 7.1825, 8.2225)
# When the finger has begun to repeat itself [s], and about how often it does [1/s]: read off the records.
REPEATS: Final = (
    (0.045, 9.8), (0.09, 9.7), (0.07, 9.7), (0.06, 20.3), (0.025, 50.8),
    (0.15, 30.0), (0.02, 9.6), (0.06, 20.8), (0.06, 20.8), (0.065, 20.8),
)  # fmt: skip


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


class Record(NamedTuple):
    """Times [s], positions [m] of finger and part from their first on, and velocities [m/s]."""

    time: Floats
    finger: Floats
    part: Floats
    finger_velocity: Floats
    part_velocity: Floats


def walk(velocity: Floats, step: float, static: float, kinetic: float, start: float = 0.0) -> Floats:
    """Follow a part on a finger whose velocity is linear between equally spaced times, slide by slide.

    A witness: it shares nothing with ``vibro``.

    Parameters
    ----------
    velocity : array
        Of the finger, upwards [m/s].
    step : float
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
    for change in np.diff(velocity).tolist():
        pull, left = (
            -GRAVITY - change / step,
            step,
        )  # what moves the part against the finger, but for friction
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


def walked_advance(velocity: Floats, period: float, force: float) -> float:
    """Advance of the part a cycle [m] by the witness, once cycles repeat."""
    push, step = force * GRAVITY, period / (velocity.size - 1)
    run = np.append(np.tile(velocity[:-1], WALKED_CYCLES), velocity[-1])
    places = walk(run, step, STATIC_FRICTION * push, KINETIC_FRICTION * push)[:: velocity.size - 1]
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


def read_record(folder: Path, number: int) -> Record:
    """Read what the authors use of a record; they write what is missing as a byte that is no number."""
    with (folder / f"Trial #{number}.csv").open(encoding="latin-1", newline="") as file:
        rows = list(csv.DictReader(file))[FIRST:LAST]
    time, finger, part, finger_velocity, part_velocity = (
        np.array([float(row[name]) for row in rows]) for name in ("t", "zp", "zo", "vzp", "vzo")
    )
    return Record(
        time - time[0],
        (finger - finger[0]) * MM,
        (part - part[0]) * MM,
        finger_velocity * MM,
        part_velocity * MM,
    )


def mean_cycle(record: Record, number: int) -> Trial:
    """Average the last whole cycles, with the period after which the finger's velocity differs least."""
    begin, frequency = REPEATS[number - 1]
    time, velocity = record.time, CubicSpline(record.time, record.finger_velocity)

    def change(period: float) -> float:
        here = time[(time >= begin) & (time + period <= time[-1])]
        return float(np.mean((velocity(here + period) - velocity(here)) ** 2))

    period = min(np.linspace(0.95, 1.05, 401) / frequency, key=change)
    cycles = int((time[-1] - begin) / period)
    ends = time[-1] - period * np.arange(cycles, -1, -1)
    advances = np.diff(np.interp(ends, time, record.part - record.finger))
    count = round(period * SAMPLING)
    finger = velocity(ends[:-1, np.newaxis] + period * np.arange(count) / count).mean(axis=0)
    error = float(np.std(advances, ddof=1)) / math.sqrt(cycles) if cycles > 1 else math.nan
    return Trial(
        number, cycles, NORMAL_FORCES[number - 1], float(period), float(np.mean(advances)), error, finger
    )


def write_table(trials: list[Trial]) -> None:
    with TABLE.open("w", newline="") as file:
        out = csv.writer(file, lineterminator="\n")
        out.writerow(COLUMNS)
        for trial in trials:
            number, cycles, force, period, advance, error, finger = trial
            numbers = f"{period / MM:.3f}", f"{advance / MM:.4f}", f"{error / MM:.4f}"
            out.writerow([number, cycles, force, *numbers, " ".join(f"{v / MM:.1f}" for v in finger)])


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


def clamped(durations: Floats, changes: Floats, kinetic: float, force: ArrayLike) -> vibro.Scene:
    """Return the vertical finger as a trough, by changes of its velocity [m/s] and their times [s]."""
    period = durations.sum()
    along = list(zip((durations / period).tolist(), (changes / durations).tolist(), strict=True))
    return vibro.Scene(
        motion=vibro.Motion.steps(along=along),
        frequency=1.0 / period,
        static_friction=STATIC_FRICTION,
        kinetic_friction=kinetic,
        normal_acceleration=np.asarray(force) * GRAVITY,
        trough_angle=0.5 * math.pi,
        gravity=GRAVITY,
    )


def computed_advances(trial: Trial) -> Floats:
    """Advance a cycle [m] for each of ``FORCE_ERRORS``."""
    changes = np.diff(fine(trial.finger))
    durations = np.full(changes.size, trial.period / changes.size)
    forces = np.array(FORCE_ERRORS) * trial.force
    steady = vibro.solve(clamped(durations, changes, KINETIC_FRICTION, forces))
    return np.asarray(steady.displacement_per_cycle)


def walked_advances(trial: Trial) -> Floats:
    """Return the same by the witness."""
    velocity = fine(trial.finger)
    return np.array([walked_advance(velocity, trial.period, factor * trial.force) for factor in FORCE_ERRORS])


def computed_places(velocity: Floats, step: float, kinetic: float, force: float, start: float) -> Floats:
    """Position of the part relative to the finger at the ends of the steps of a whole record [m]."""
    changes = np.append(np.diff(velocity), velocity[0] - velocity[-1])
    durations = np.append(np.full(velocity.size - 1, step), CLOSING)
    end = step * (velocity.size - 1)
    scene = clamped(durations, changes, kinetic, force)
    history = vibro.simulate(scene, duration=end, start_velocity=start)
    return history.sample(np.linspace(0.0, history.end, velocity.size)).position


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


def compare_records(records: list[Record]) -> None:
    print("\nWhole records; mean |computed - measured position| of the part [mm], as the authors define it:")
    apart = 0.0
    for name, kinetic, forces, steps in (
        ("as measured, velocity linear between samples", KINETIC_FRICTION, NORMAL_FORCES, 1),
        ("as measured, spline of the velocity", KINETIC_FRICTION, NORMAL_FORCES, STEPS),
        ("the authors' fit, velocity linear", FITTED_FRICTION, FITTED_FORCES, 1),
        ("the authors' fit, spline of the velocity", FITTED_FRICTION, FITTED_FORCES, STEPS),
    ):
        errors, largest, wrong = np.empty(len(records)), np.empty(len(records)), []
        for i, (record, force) in enumerate(zip(records, forces, strict=True)):
            step = record.time[-1] / (record.time.size - 1) / steps
            times = step * np.arange(steps * (record.time.size - 1) + 1)
            splined = steps > 1
            velocity = (
                CubicSpline(record.time, record.finger_velocity)(times) if splined else record.finger_velocity
            )
            push, start = force * GRAVITY, record.part_velocity[0] - record.finger_velocity[0]
            places = computed_places(velocity, step, kinetic, force, start)
            walked = walk(velocity, step, STATIC_FRICTION * push, kinetic * push, start)
            apart = max(apart, float(np.abs(places - walked).max()))
            part = record.finger + places[::steps]
            errors[i], largest[i] = np.mean(np.abs(part - record.part)) / MM, np.max(np.abs(record.part)) / MM
            wrong += [str(i + 1)] * bool(part[-1] * record.part[-1] <= 0.0)
        share = 100.0 * errors / largest
        print(
            f"{name}: mean {errors.mean():.3f}; of the largest position: mean {share.mean():.1f} %,", end=" "
        )
        print(f"median {np.median(share):.1f} %; wrong side at the end: {', '.join(wrong) or 'none'}")
        print("   trial by trial:", *(f"{error:.2f}" for error in errors))
    print(f"largest difference from the witness at any time: {apart / MM:.1e} mm")


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument(
        "--records", type=Path, metavar="FOLDER", help="matlab/data of a clone of the records"
    )
    parser.add_argument("--write", action="store_true", help="make the table of mean cycles anew")
    given = parser.parse_args()
    if given.write and not given.records:
        parser.error("--write needs --records FOLDER, from which the mean cycles are made")
    numbers = range(1, len(NORMAL_FORCES) + 1)
    records = [read_record(given.records, number) for number in numbers] if given.records else []
    if given.write:
        write_table([mean_cycle(record, number) for record, number in zip(records, numbers, strict=True)])
    compare_cycles(read_table())
    if records:
        compare_records(records)


if __name__ == "__main__":
    main()
