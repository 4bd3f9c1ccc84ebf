"""Is what ``vibro.solve`` says of hopping bodies true? Each table compares it with independent witnesses.

Usage: python benchmarks/hopping_truth.py {ulps,digits,means,starts,edges} [--scenes N] [--seed 1]
       [--processes 2]

ulps    Scenes solved at amplitudes of 0, 1, 2 and 3 ulp more. All OK means equal speeds, within 1e-6 of
        A cos(alpha); at e < .2 at least 90 % are OK.
digits  Scenes with status OK and e > .3 against 40 to 320 digits: period, displacement, peak speed.
means   The mean and the standard error of scenes with status AVERAGED against means over many bodies, and
        what is OK against the same: K 1-50, e to .95, any friction, slopes to 45 deg.
starts  Bodies started anyhow: which repeat another cycle of up to 8 turns than the one from rest, or run
        away, and whether ``coexists`` says so.
edges   Where bounces accumulate slowly (K near 1, e to .97), where nothing rubs (mu_d = 0), where there is
        hardly any flight: displacement, peak speed and flight fraction against bodies followed from event to
        event, and means against means over many bodies.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor
from functools import partial
from itertools import pairwise
from typing import Any, Final, NamedTuple

import numpy as np
from bouncing_body import KICK, NAMES, Floats, Mask
from bouncing_exact import settled
from bouncing_runs import long_run, recurrence
from hopping_scenes import (
    Drawn,
    hardly_hopping,
    in_contact,
    scene_text,
    slow_chains,
    some_of,
    usual_scenes,
    wide_scenes,
    without_kinetic_friction,
)
from numpy.typing import NDArray

import vibro
from vibro import Status

Draw = Callable[[int, int], Drawn]

ULPS: Final = 4
BANDS: Final = (0.0, 0.1, 0.2, 0.3, 0.5, 0.7, 0.9)  # of e
SAME: Final = 1e-6  # [A cos(alpha)], [A w], [1] larger differences are disagreements
SLOWEST: Final = 1e3  # periods that a cycle may take to attract, while the witness is on its way there
COARSE: Final = 1e-3  # [A cos(alpha)] from a mean over many bodies, beyond its own error
FAR: Final = 3.0  # standard errors
BEYOND: Final = 6.0
STARTS: Final = 48  # of each scene
SHORT: Final = 8  # [turns] period of a cycle that is looked for
LISTED: Final = 20  # scenes that disagree

EDGES: Final[dict[str, Draw]] = {
    "K near 1, e .9-.97": slow_chains,
    "mu_d = 0": without_kinetic_friction,
    "e = 0, K 1-3.3": hardly_hopping,
    "e .1-.5": partial(usual_scenes, e=(0.1, 0.5)),
}
DISTURBED: Final[dict[str, Draw]] = {
    "e .2-.8, ratio > .76": partial(usual_scenes, e=(0.2, 0.8), ratio=0.76),
    "e = 0, K 1-3.3": hardly_hopping,
    "K to 50, slopes": wide_scenes,
    "K < 1": in_contact,
}


class Ulps(NamedTuple):
    """What neighbouring amplitudes give; arrays over scenes."""

    ok: Mask  # at each of them
    spread: Floats  # of the displacement [A cos(alpha)]; 0 where it is not OK


def over_ulps(fields: Drawn) -> Ulps:
    """Solve scenes at amplitudes some ulp apart, and compare those that are OK at all."""
    answers, amplitude = [], fields["amplitude"]
    for _ in range(ULPS):
        answers.append(vibro.solve(vibro.Scene(**(fields | {"amplitude": amplitude}))))
        amplitude = np.nextafter(amplitude, np.inf)
    ok = np.all([answer.status == Status.OK for answer in answers], axis=0)
    displacement = np.array([answer.displacement_per_cycle for answer in answers])
    return Ulps(ok, np.where(ok, np.ptp(displacement, axis=0), 0.0) / _step(fields))


class Digits(NamedTuple):
    """What arbitrary precision says of scenes that are OK; arrays over them, NaN where nothing repeats."""

    agrees: Mask
    displacement: Floats  # error [A cos(alpha)]
    peak: Floats  # error [A w]


def against_digits(fields: Drawn, processes: int = 1) -> Digits:
    """Compare the answers to scenes that are all OK with arbitrary precision."""
    answer = vibro.solve(vibro.Scene(**fields))
    rows = list(zip(*(fields[name].tolist() for name in NAMES), strict=True))
    with ProcessPoolExecutor(processes) as pool:
        truth = list(pool.map(settled, rows))
    none = (np.nan,) * 4
    values = [none if t is None else (t.period, t.displacement, t.peak, t.change) for t in truth]
    period, displacement, peak, change = np.array(values).reshape(-1, 4).T
    displacement = np.abs(answer.displacement_per_cycle - displacement * fields["amplitude"]) / _step(fields)
    peak = np.abs(answer.peak_velocity / _speed(fields) - peak)
    close = np.maximum(displacement, peak) <= np.maximum(SAME, SLOWEST * change)
    return Digits((period == answer.period_cycles) & close, displacement, peak)


class Means(NamedTuple):
    """Answers against means over many bodies; arrays over scenes."""

    status: NDArray[np.int8]
    settled: Mask  # whether the witness has settled
    z: Floats  # difference over the standard errors of both
    beyond: Floats  # difference that the witness's error does not explain [A cos(alpha)]


def against_means(fields: Drawn, seed: int) -> Means:
    """Compare means, and what is said to be exact, with means over many bodies."""
    answer = vibro.solve(vibro.Scene(**fields))
    truth = long_run(fields, seed=seed)
    difference = answer.displacement_per_cycle - truth.displacement
    error = np.hypot(answer.mean_velocity_error / fields["frequency"], truth.error)
    beyond = np.maximum(np.abs(difference) - BEYOND * truth.error, 0.0)
    with np.errstate(divide="ignore", invalid="ignore"):
        return Means(answer.status, truth.settled, difference / error, beyond / _step(fields))


class Events(NamedTuple):
    """Cycles against bodies followed from event to event; arrays over scenes, NaN where nothing recurs."""

    displacement: Floats  # error [A cos(alpha)]
    peak: Floats  # error [A w]
    flight_fraction: Floats  # error


def against_events(fields: Drawn, seed: int) -> Events:
    """Compare cycles with bodies followed from rest until they recur."""
    answer, truth = vibro.solve(vibro.Scene(**fields)), recurrence(fields, seed=seed)
    return Events(
        np.abs(answer.displacement_per_cycle - truth.displacement) / _step(fields),
        np.abs(answer.peak_velocity - truth.peak) / _speed(fields),
        np.abs(answer.flight_fraction - truth.flight_fraction),
    )


class Others(NamedTuple):
    """What bodies do that are laid down at random phases; arrays over scenes."""

    coexists: NDArray[np.int8]  # what the solver says
    cycles: Mask  # whether some repeat another short cycle than the body from rest
    runaways: Mask  # whether some run away
    start: Floats  # phase [rad], take-off speed, relative velocity [m/s] of one that does either; (n, 3)


def among_starts(fields: Drawn, seed: int) -> Others:
    """Lay bodies down at random phases, and compare what they do with ``coexists``."""
    n, rng = fields["amplitude"].size, np.random.default_rng(seed)
    at_rest = np.zeros(n * STARTS)
    start = (rng.uniform(0.0, 2.0 * np.pi, n * STARTS), at_rest, at_rest)
    found = recurrence(fields, STARTS, start=start, kick=KICK, seed=seed)
    answer = vibro.solve(vibro.Scene(**fields), starts=64)
    displacement = found.displacement.reshape(n, STARTS) - answer.displacement_per_cycle[:, None]
    flight = found.flight_fraction.reshape(n, STARTS) - answer.flight_fraction[:, None]
    other = (np.abs(displacement) > SAME * _step(fields)[:, None]) | (np.abs(flight) > SAME)
    period = found.period.reshape(n, STARTS)
    other &= period <= SHORT
    away = found.runs_away.reshape(n, STARTS)
    first = np.argmax(other | away, axis=1)
    one = np.array(start).reshape(3, n, STARTS)[:, np.arange(n), first].T
    return Others(answer.coexists, np.any(other, axis=1), np.any(away, axis=1), one)


def _step(fields: Drawn) -> Floats:
    """Return A cos(alpha)."""
    return fields["amplitude"] * np.cos(fields["drive_angle"])


def _speed(fields: Drawn) -> Floats:
    """Return A w."""
    return 2.0 * np.pi * fields["frequency"] * fields["amplitude"]


def shared(compare: Callable[[Drawn, int], Any], fields: Drawn, seed: int, processes: int) -> Any:
    """Compare scenes in several processes, each with its share of every kind."""
    n = fields["amplitude"].size
    parts = [np.arange(n)[k::processes] for k in range(processes)]
    with ProcessPoolExecutor(processes) as pool:
        tasks = [pool.submit(compare, some_of(fields, part), seed + k) for k, part in enumerate(parts)]
        found = [task.result() for task in tasks]
    order = np.argsort(np.concatenate(parts))
    return type(found[0])(*(np.concatenate(arrays)[order] for arrays in zip(*found, strict=True)))


def with_status(fields: Drawn, *statuses: Status) -> Drawn:
    """Pick scenes by the status of their answer."""
    return some_of(fields, np.isin(vibro.solve(vibro.Scene(**fields)).status, statuses))


def listed(label: str, fields: Drawn, which: Any, say: Callable[[int], str] = lambda _: "") -> None:
    """Print the first of some scenes."""
    for i in np.flatnonzero(which)[:LISTED].tolist():
        print(f"  {label} {say(i)}", scene_text(fields, i))


def _text(label: str, values: Floats, i: int) -> str:
    return f"{label} {values[i].tolist()}:"


def print_ulps(n: int, seed: int, processes: int) -> bool:
    fields = usual_scenes(n, seed)
    found = over_ulps(fields)
    e, wrong = fields["restitution"], found.spread > SAME
    print(f"{'e':>10} {'scenes':>8} {'OK':>8} {'differ':>8}")
    for low, high in pairwise(BANDS):
        band = (e >= low) & (e < high)
        print(f"{f'{low:g}-{high:g}':>10} {band.sum():8} {found.ok[band].mean():8.1%} {wrong[band].sum():8}")
    share = found.ok[e < 0.2].mean()
    print(
        f"{found.ok.sum()} of {n} are OK at {ULPS} amplitudes; {wrong.sum()} of them differ by more than "
        f"{SAME:g} A cos(alpha) (target 0), by {found.spread.max():.2g} at most\n"
        f"{share:.1%} are OK at e < .2 (target 90 %)"
    )
    listed("DIFFERS", fields, wrong)
    return not wrong.any() and share >= 0.9


def print_digits(n: int, seed: int, processes: int) -> bool:
    fields = with_status(usual_scenes(8 * n, seed, e=(0.3, 0.9)), Status.OK)
    fields = some_of(fields, slice(n))
    agrees, displacement, peak = against_digits(fields, processes)
    print(
        f"{n} OK scenes with e > .3: {(~agrees).sum()} disagree with arbitrary precision (target 0), "
        f"{np.isnan(displacement).sum()} of them because nothing repeats there\nof the others the "
        f"displacement is within {displacement[agrees].max(initial=0.0):.2g} A cos(alpha), the peak speed "
        f"within {peak[agrees].max(initial=0.0):.2g} A w"
    )
    listed("WRONG", fields, ~agrees, lambda i: f"by {displacement[i]:.2g}, peak {peak[i]:.2g}:")
    return bool(agrees.all())


def print_means(n: int, seed: int, processes: int) -> bool:
    fields = with_status(wide_scenes(n, seed), Status.OK, Status.AVERAGED)
    status, has_settled, z, beyond = shared(against_means, fields, seed, processes)
    averaged = status == Status.AVERAGED
    kinds = {"AVERAGED": averaged, "OK": ~averaged}
    counts = [f"{k.sum()} {name} ({(k & ~has_settled).sum()} not settled)" for name, k in kinds.items()]
    print(f"{n} scenes: {', '.join(counts)}, {n - status.size} without an answer")
    sizes = np.abs(z[averaged & has_settled])
    spread, far = np.sqrt(np.mean(sizes**2)), np.mean(sizes > FAR)
    print(
        f"AVERAGED: standard deviation of z {spread:.2f} (target 1.2), {far:.1%} beyond {FAR:g} "
        f"(target 1 %), {(sizes > BEYOND).sum()} beyond {BEYOND:g} (target 0), largest {sizes.max():.1f}"
    )
    wrong = has_settled & ~averaged & (beyond > COARSE)
    print(f"OK: {wrong.sum()} farther than {COARSE:g} A cos(alpha) from a mean over many bodies (target 0)")
    beyond_all = has_settled & averaged & (np.abs(z) > BEYOND)
    listed("BEYOND", fields, beyond_all, partial(_text, "z", z))
    listed("WRONG", fields, wrong, partial(_text, "by", beyond))
    return bool(spread <= 1.2 and far <= 0.01) and not (beyond_all | wrong).any()


def print_starts(n: int, seed: int, processes: int) -> bool:
    missed = 0
    print(
        f"{'scenes':>22} {'OK':>6} {'cycles':>7} {'run away':>9} {'said':>6} {'not looked':>11} {'missed':>7}"
    )
    for name, draw in DISTURBED.items():
        fields = with_status(draw(n, seed), Status.OK)
        coexists, cycles, runaways, start = shared(among_starts, fields, seed, processes)
        other = cycles | runaways
        wrong = other & (coexists == 0)
        counts = [int(c.sum()) for c in (cycles, runaways, coexists == 1, coexists == -1, wrong)]
        print(f"{name:>22}{wrong.size:9}" + "".join(f"{count:11}" for count in counts))
        listed("MISSED", fields, wrong, partial(_text, "from", start))
        missed += int(wrong.sum())
    print(f"{missed} scenes said to have no other motion have one (target 0)")
    return not missed


def print_edges(n: int, seed: int, processes: int) -> bool:
    good = True
    heads = ("OK", "recur", "displ.", "peak", "flight", "AVERAGED", "beyond 6")
    print(f"{'scenes':>22}" + "".join(f"{head:>9}" for head in heads) + "   largest of the right")
    for name, draw in EDGES.items():
        drawn = draw(n, seed)
        fields, mean = with_status(drawn, Status.OK), with_status(drawn, Status.AVERAGED)
        errors = np.array(shared(against_events, fields, seed, processes))
        z, beyond = np.zeros(0), np.zeros(0, np.bool_)
        if mean["amplitude"].size:
            _, has_settled, z, _ = shared(against_means, mean, seed, processes)
            beyond = has_settled & (np.abs(z) > BEYOND)
        bad = errors > SAME
        wrong = bad.any(axis=0)
        recurs = np.isfinite(errors[0])
        counts = (wrong.size, recurs.sum(), *bad.sum(axis=1), beyond.size, beyond.sum())
        largest = np.max(errors, axis=1, where=recurs & ~wrong, initial=0.0)
        print(
            f"{name:>22}" + "".join(f"{c:9}" for c in counts) + "   " + " ".join(f"{x:.0e}" for x in largest)
        )
        listed("WRONG", fields, wrong)
        listed("BEYOND", mean, beyond, partial(_text, "z", z))
        good &= not (wrong.any() or beyond.any())
    return good


TABLES: Final = {
    "ulps": (print_ulps, 4000),
    "digits": (print_digits, 100),
    "means": (print_means, 1000),
    "starts": (print_starts, 100),
    "edges": (print_edges, 400),
}


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("table", choices=TABLES)
    parser.add_argument("--scenes", type=int, help="how many are drawn; a default for each table")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--processes", type=int, default=2)
    arguments = parser.parse_args()
    table, scenes = TABLES[arguments.table]
    start = time.perf_counter()
    good = table(arguments.scenes or scenes, arguments.seed, arguments.processes)
    print(f"{time.perf_counter() - start:.0f} s: {'as it should be' if good else 'NOT as it should be'}")
    if not good:
        raise SystemExit(1)


if __name__ == "__main__":
    main()
