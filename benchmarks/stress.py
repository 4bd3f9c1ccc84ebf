"""Does the steady solve hold at the extremes? Invariants on many scenes, arbitrary precision on some.

Usage: python benchmarks/stress.py [--corners DRIVE ...] [--scenes 20000] [--invariants 1000000]
           [--hopping 200] [--processes 2]

First the corners of all that quantities may be, and their neighbours by an ulp, are solved for each kind of
drive. Then scenes are drawn where floating point is weakest: amplitudes and frequencies up to their limits,
friction from 0 and 1e-12 to 10, mu_d/mu_s of 0, 1 and all but 1, drive angles of 0, 1e-300 and up to an ulp
below 90 deg, troughs as steep as the friction angles, loads within a few ulp of each threshold, and
restitution in every fifth. Hopping has its own: neighbours an ulp apart, slow accumulation, no kinetic
friction, hardly any flight, disturbed starts (hopping_truth.py).
Results are maxima observed over the scenes drawn, not bounds.
"""

from __future__ import annotations

import argparse
import itertools
import sys
import time
import warnings
from collections.abc import Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path
from typing import Any, Final, NamedTuple

import hopping_truth
import mpmath
import numpy as np
from extremes import EPS, KINDS, LARGEST, SMALLEST, Fields, corners_of, ends_of, extreme_fields
from numpy.typing import NDArray

import vibro
from vibro.core.codes import is_answered

sys.path.insert(0, str(Path(__file__).parents[1] / "tests"))
from engines.digits_walk import DIGITS, exact_cycle, exact_sensitivity

BOUNDARY: Final = 16 * EPS  # [1] relative distance to a threshold within which either class is right
CHUNK: Final = 1000  # scenes a task
_LEAST_FRICTION: Final = 1e-290  # [1] below, products with it are no doubles
NAMES: Final = (
    "amplitude",
    "frequency",
    "drive_angle",
    "static_friction",
    "kinetic_friction",
    "trough_angle",
    "gravity",
)


def scene_of(fields: Fields) -> vibro.Scene:
    return vibro.Scene(**fields)


def broken_invariants(fields: Fields) -> Iterator[tuple[str, NDArray[np.intp]]]:
    """Solve scenes with warnings as errors; yield what does not hold, and for which of them."""
    for problem, cell in _complaints(fields, np.arange(fields["amplitude"].size)):
        yield problem, np.array([cell])
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        cycle = vibro.solve(scene_of(fields))
        scaled = vibro.solve(scene_of(_rescaled(fields)))
    answered = is_answered(cycle.status)
    numbers = (cycle.displacement_per_cycle, cycle.mean_velocity, cycle.peak_velocity)
    finite = np.all([np.isfinite(x) for x in numbers], axis=0)
    nan = np.any([np.isnan(x) for x in numbers], axis=0)
    representable = fields["amplitude"] < 1e-10 * LARGEST / np.maximum(fields["frequency"], 1.0)
    one_way = {"F_": 1.0, "B_": -1.0}
    wrong_way = np.zeros(answered.shape, np.bool_)
    for pattern, way in one_way.items():
        wrong_way |= (cycle.pattern == pattern) & (way * cycle.displacement_per_cycle < 0.0)
    moderate = _moderate(fields)
    with np.errstate(over="ignore"):
        as_long = cycle.displacement_per_cycle == 4.0 * scaled.displacement_per_cycle
    checks = {
        "unresolved": (cycle.status == vibro.Status.UNRESOLVED)
        & (fields["static_friction"] > _LEAST_FRICTION),
        "NaN without a status": answered & nan,
        "a number in spite of its status": ~answered & ~np.isnan(cycle.mean_velocity),
        "speed not finite": answered & representable & ~finite,
        "pattern and status disagree": answered != (cycle.pattern != ""),
        "ratios not numbers": np.isnan(cycle.throw_number)
        | np.isnan(cycle.forward_ratio)
        | np.isnan(cycle.back_ratio),
        "slides the wrong way": wrong_way,
        "negative peak speed": answered & (cycle.peak_velocity < 0.0),
        "rest that moves": (cycle.pattern == "_") & (cycle.displacement_per_cycle != 0.0),
        "not similar": moderate & (cycle.pattern != scaled.pattern),
        "not similar in length": moderate
        & answered
        & (np.abs(cycle.displacement_per_cycle) > 1e-280)
        & ~as_long,
        **_wrong_classes(fields, cycle),
    }
    for name, broken in checks.items():
        if broken.any():
            yield name, np.flatnonzero(broken)


def _complaints(fields: Fields, cells: NDArray[np.intp]) -> Iterator[tuple[str, int]]:
    """Exceptions and warnings, each with the scene that causes it: half by half."""
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            vibro.solve(scene_of({name: field[cells] for name, field in fields.items()}))
    except Exception as exc:
        if cells.size == 1:
            yield f"{type(exc).__name__}: {exc}", int(cells[0])
        else:
            for half in np.array_split(cells, 2):
                yield from _complaints(fields, half)


def _rescaled(fields: Fields) -> Fields:
    """Quarter the length, double the pace: powers of two, so that nothing rounds differently."""
    return fields | {
        "amplitude": np.maximum(fields["amplitude"] / 4.0, ends_of("amplitude")[0]),
        "frequency": np.minimum(fields["frequency"] * 2.0, ends_of("frequency")[1]),
    }


def _moderate(fields: Fields) -> NDArray[np.bool_]:
    """Scenes that can be rescaled, and whose drive angles are far from the ends of what doubles hold."""
    moderate = np.ones(fields["amplitude"].shape, np.bool_)
    least, most = ends_of("amplitude")[0], ends_of("frequency")[1]
    moderate &= (fields["amplitude"] >= 4.0 * least) & (fields["frequency"] <= 0.5 * most)
    # A displacement is proportional to the drive angle where both slides nearly cancel.
    moderate &= (fields["drive_angle"] == 0.0) | (fields["drive_angle"] > 1e-120)
    return moderate


def _wrong_classes(fields: Fields, cycle: Any) -> dict[str, NDArray[np.bool_]]:
    """Compare classes with the closed-form thresholds in the longest floats there are."""
    amplitude, frequency, alpha, mu_s, _, beta, gravity = (
        np.asarray(fields[name], np.longdouble) for name in NAMES
    )
    pi = np.longdouble("3.14159265358979323846264338327950288")
    with np.errstate(all="ignore"):
        w = 2 * pi * frequency
        weight = (gravity / w) / (amplitude * w)
        along, across, normal, tangential = (
            np.cos(alpha),
            np.sin(alpha),
            weight * np.cos(beta),
            weight * np.sin(beta),
        )
        known = np.isfinite(weight) & (weight > 0)
        known &= (mu_s == 0) | (np.fmin(mu_s, mu_s * weight) > _LEAST_FRICTION)

        def beyond(load: Any, limit: Any, scale: Any) -> tuple[Any, Any]:
            clear = known & (np.abs(load - limit) > BOUNDARY * scale)
            return clear & (load > limit), clear & (load < limit)

        hold = mu_s * normal
        hops, stays = beyond(across, normal, normal)
        restless, rests = beyond(np.abs(tangential), hold, hold)
        size = along + mu_s * across + hold + np.abs(tangential)
        forward, not_forward = beyond(along + mu_s * across, hold + tangential, size)
        back, not_back = beyond(along - mu_s * across, hold - tangential, size)
    rubs = mu_s > 0
    calm = stays & rests & rubs
    regime, status = cycle.regime, cycle.status
    frictionless = np.where(tangential == 0, vibro.Status.INDETERMINATE, vibro.Status.RUNAWAY)
    still, ahead = vibro.Regime.NO_SLIP, vibro.Regime.FORWARD_SLIP
    return {
        "no hop": hops & (regime != vibro.Regime.HOPPING),
        "hops too soon": stays & (regime == vibro.Regime.HOPPING),
        "without friction, but not said": stays & (mu_s == 0) & (status != frictionless),
        "no runaway": stays & rubs & restless & (status != vibro.Status.RUNAWAY),
        "slips too soon": calm & not_forward & not_back & (regime != still),
        "does not slip": calm & (forward | (back & (along > mu_s * across))) & (regime == still),
        "slips back too soon": calm
        & forward
        & not_back
        & (regime != ahead)
        & (status != vibro.Status.RUNAWAY),
    }


class Worst(NamedTuple):
    """What the comparison with arbitrary precision found."""

    scenes: int
    slipping: int
    undecided: int  # scenes that the reference gives up
    error: float  # [eps (condition |d| + S)]
    where: tuple[float, ...]
    pattern: str
    wrong: tuple[tuple[tuple[float, ...], str, str], ...]  # scene, pattern found, pattern in truth


def against_reference(n: int, seed: int) -> Worst:
    """Compare patterns and displacements of scenes that do not hop with arbitrary precision."""
    fields = extreme_fields(n, seed)
    cycle = vibro.solve(scene_of(fields))
    worst = Worst(n, 0, 0, 0.0, (), "", ())
    slipping, undecided, wrong = 0, 0, []
    friction = fields["static_friction"]
    usual = (friction == 0.0) | (friction > _LEAST_FRICTION)
    cells = np.flatnonzero(usual & (cycle.regime != vibro.Regime.HOPPING))
    for i in cells.tolist():
        values = tuple(float(fields[name][i]) for name in NAMES)
        exact = exact_cycle(values)
        if not exact.pattern:
            undecided += 1
            continue
        found = _pattern(cycle, i)
        if found != exact.pattern:
            said = int(cycle.status[i]) == vibro.Status.BOUNDARY
            if not _near_boundary(values, found, exact.pattern, said=said):
                wrong.append((values, found, exact.pattern))
            continue
        if "F" in found or "B" in found:
            slipping += 1
            error = _error(values, float(cycle.displacement_per_cycle[i]), exact, worst.error)
            if error > worst.error:
                worst = worst._replace(error=error, where=values, pattern=found)
    return worst._replace(slipping=slipping, undecided=undecided, wrong=tuple(wrong))


def _pattern(cycle: Any, i: int) -> str:
    status = vibro.Status(int(cycle.status[i]))
    return str(cycle.pattern[i]) if status.answered else status.label


def _near_boundary(values: tuple[float, ...], found: str, true: str, *, said: bool) -> bool:
    """Whether some change of the inputs by 16 eps or less explains a pattern.

    Either it gives the pattern found, changing two inputs if one is not enough; or it gives another one than
    the true, and the status said so. A class may be narrower than any change that is tried.
    """
    near = set(_patterns_nearby(values, 1))
    if near & {found, ""} or (said and near != {true}):
        return True
    return found in _patterns_nearby(values, 2)


def _patterns_nearby(values: tuple[float, ...], number: int) -> Iterator[str]:
    """Find the true patterns after changes of so many inputs, in multiple precision."""
    changes = [sign * size * EPS for size in (0.25, 1.0, 4.0, 16.0) for sign in (-1.0, 1.0)]
    for inputs in itertools.combinations(range(len(values) - 1), number):
        for sizes in itertools.product(changes, repeat=number):
            moved = [mpmath.mpf(v) for v in values]
            for i, size in zip(inputs, sizes, strict=True):
                moved[i] += moved[i] * size
            moved[4] = min(moved[4], moved[3])
            yield exact_cycle(moved).pattern


def _error(values: tuple[float, ...], displacement: float, exact: Any, best: float) -> float:
    """Error in units of rounding, eps (condition |d| + S); 0 if it cannot exceed ``best``."""
    amplitude = values[0]
    both = "F" in exact.pattern and "B" in exact.pattern
    size = 1 if both else abs(exact.displacement)
    # Next to the smallest double a displacement has few digits.
    error = max(abs(displacement - exact.displacement * amplitude) - SMALLEST, 0) / amplitude
    if error <= best * EPS * size:
        return 0.0
    return float(error / (EPS * (exact_sensitivity(values) + size)))


class Corners(NamedTuple):
    """What solving the corners of one kind of drive has found."""

    scenes: int
    statuses: dict[str, int]
    wrong: int  # cells whose status and number disagree
    seconds: float  # [s] of the processor, of the slowest grid of them


def solve_corners(kind: str, *, with_ulps: bool = False) -> Corners:
    """Solve all scenes at the corners of the box of a kind of drive, with warnings as errors."""
    scenes, statuses, wrong, seconds = 0, np.zeros(len(vibro.Status), np.int64), 0, 0.0
    for scene in corners_of(kind, with_ulps=with_ulps):
        start = time.process_time()
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            cycle = vibro.solve(scene, threads=1)
        seconds = max(seconds, time.process_time() - start)
        scenes += cycle.status.size
        statuses += np.bincount(cycle.status, minlength=statuses.size)
        wrong += int((is_answered(cycle.status) == np.isnan(cycle.mean_velocity)).sum())
    counts = {vibro.Status(i).label: int(n) for i, n in enumerate(statuses) if n}
    return Corners(scenes, counts, wrong, seconds)


def print_corners(kinds: Sequence[str]) -> int:
    """Print what the corners of the box of kinds of drive, and their neighbours, give."""
    wrong = 0
    print(f"{'drive':10s}{'corners':>9s}{'CPU of slowest grid':>21s}  statuses")
    for kind in kinds:
        # Of others than lines and ellipses the neighbours are millions, which take minutes.
        found = solve_corners(kind, with_ulps=kind in ("line", "ellipse"))
        wrong += found.wrong
        told = ", ".join(f"{label} {number}" for label, number in found.statuses.items())
        print(f"{kind:10s}{found.scenes:9d}{found.seconds:19.2f} s  {told}")
    return wrong


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--scenes", type=int, default=20_000, help="scenes against arbitrary precision")
    parser.add_argument(
        "--invariants", type=int, default=1_000_000, help="scenes whose invariants are checked"
    )
    parser.add_argument("--hopping", type=int, default=200, help="scenes of each kind that hops")
    parser.add_argument("--processes", type=int, default=2)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--corners", nargs="*", default=KINDS, metavar="DRIVE", help=", ".join(KINDS))
    arguments = parser.parse_args()

    at_corners = print_corners(arguments.corners)
    start = time.perf_counter()
    broken: dict[str, tuple[int, dict[str, float]]] = {}
    block = min(arguments.invariants, 100_000)
    for i in range(-(-arguments.invariants // block)):
        fields = extreme_fields(block, arguments.seed + i)
        for name, cells in broken_invariants(fields):
            example = {field: float(values[cells[0]]) for field, values in fields.items()}
            number, example = broken.get(name, (0, example))
            broken[name] = (number + cells.size, example)
    print(f"{arguments.invariants} scenes, invariants: {time.perf_counter() - start:.0f} s")
    for name, (number, example) in broken.items():
        print(f"  BROKEN {name}: {number} scenes, such as {example}")
    if not broken:
        print("  all hold")

    start = time.perf_counter()
    chunks = -(-arguments.scenes // CHUNK)
    with ProcessPoolExecutor(arguments.processes) as pool:
        seeds = range(arguments.seed, arguments.seed + chunks)
        results = list(pool.map(against_reference, [CHUNK] * chunks, seeds))
    slipping = sum(r.slipping for r in results)
    undecided = sum(r.undecided for r in results)
    seconds = time.perf_counter() - start
    print(f"{chunks * CHUNK} scenes against {DIGITS} digits: {seconds:.0f} s")
    print(f"  {slipping} slip, {undecided} are left undecided by the reference")
    worst = max(results, key=lambda r: r.error)
    print(f"  largest error {worst.error:.2f} eps (condition |d| + S), {worst.pattern}, at")
    print("  " + ", ".join(f"{name}={value!r}" for name, value in zip(NAMES, worst.where, strict=False)))
    wrong = [w for r in results for w in r.wrong]
    print(f"  wrong patterns farther than 16 eps from a boundary: {len(wrong)}")
    for values, found, true in wrong[:20]:
        print(f"  WRONG {found!r} for {true!r} at {values}")
    hops = True
    for name in ("ulps", "edges", "starts"):
        print(f"hopping_truth.py {name}")
        table, _ = hopping_truth.TABLES[name]
        hops &= table(arguments.hopping, arguments.seed, arguments.processes)
    if at_corners or broken or wrong or not hops:
        raise SystemExit(1)


if __name__ == "__main__":
    main()
