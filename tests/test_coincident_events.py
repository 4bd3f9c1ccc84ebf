"""Steps with round numbers: events at jumps of the load, and loads at the limit of friction or contact."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest
from engines.steps_walk import Drive, walk
from helpers.draws import draws

import vibro
from vibro import Motion, Scene, Status

Steps = list[tuple[float, float]]

GRAVITY = 8.0


def scene(along: Steps, normal: Steps | None, static: float, kinetic: float, frequency: float = 1.0) -> Scene:
    return Scene(
        motion=Motion.steps(along=along, normal=normal),
        frequency=frequency,
        static_friction=static,
        kinetic_friction=kinetic,
        gravity=GRAVITY,
        restitution=0.0,
    )


def phases(drive: Scene, cycles: float) -> list[tuple[str, float]]:
    return [(phase.kind[0], phase.start) for phase in vibro.simulate(drive, cycles=cycles).phases]


def test_friction_holds_a_body_that_stops_at_its_limit() -> None:
    """It coasts to rest at 0.75, where F = mu_d N = mu_s N begins, and stays until 1."""
    drive = scene([(0.375, 2.0), (0.25, -2.0), (0.125, 0.0), (0.25, -1.0)], None, 0.125, 0.125)
    found = phases(drive, 3)
    assert [kind for kind, _ in found] == list("BF_BF_BF_")
    assert [start for _, start in found[3:6]] == pytest.approx([1.0, 1.5, 1.75], abs=1e-14)
    assert sorted(vibro.solve(drive).pattern) == ["B", "F", "_"]


def test_where_static_friction_alone_bears_a_body_that_stops_rounding_decides() -> None:
    """In the last eighth |F| = mu_s N > mu_d N: kinetic friction would let it slip."""
    along = [(0.125, 8.0), (0.25, 8.0), (0.375, -2.0), (0.25, -9.0)]
    found = vibro.solve(scene(along, [(0.875, -4.0), (0.125, 28.0)], 0.25, 0.125))
    assert found.status == Status.BOUNDARY
    assert found.displacement_per_cycle == pytest.approx(-1.5839120370370372, abs=1e-13)


def test_an_arrival_counts_the_cycles_of_landings_at_phase_0() -> None:
    drive = scene([(0.375, -4.0), (0.375, 2.0), (0.25, 3.0)], [(0.75, -32.0), (0.25, 96.0)], 0.125, 0.125)
    time = vibro.arrival_time(drive, 3.0683525256981996)
    assert time == pytest.approx(3.717541444682038, rel=1e-12)
    assert vibro.simulate(drive, cycles=5).sample(time).position == pytest.approx(
        3.0683525256981996, rel=1e-12
    )


def drawn(rng: np.random.Generator, parts: int, unit: Fraction) -> list[tuple[Fraction, Fraction]]:
    """Draw levels of whole units on equal parts of the period, the last such that their mean is 0."""
    while True:
        cuts = np.sort(rng.choice(np.arange(1, parts), int(rng.integers(1, 5)), replace=False))
        shares = [Fraction(int(n), parts) for n in np.diff(np.concatenate(([0], cuts, [parts])))]
        levels = [int(n) * unit for n in rng.integers(-4, 5, size=len(cuts))]
        levels.append(-sum(x * y for x, y in zip(shares, levels, strict=False)) / shares[-1])
        if any(levels) and abs(levels[-1]) < 20 * unit:
            return list(zip(shares, levels, strict=True))


def levels_of(steps: list[tuple[Fraction, Fraction]], parts: int) -> list[Fraction]:
    return [level for share, level in steps for _ in range(int(parts * share))]


def rounded(steps: list[tuple[Fraction, Fraction]]) -> Steps:
    return [(float(share), float(level)) for share, level in steps]


@pytest.mark.parametrize(("parts", "gravity"), [(8, "8"), (10, "9.81")])
@pytest.mark.parametrize("seed", range(3))
def test_round_steps_agree_with_rational_numbers(parts: int, gravity: str, seed: int) -> None:
    """Histories up to the first irrational landing, and cycles that repeat exactly; 180 drives.

    Loads along are whole multiples of the friction under the weight, or of half of it; decimals are rounded.
    """
    rng, repeating, g = np.random.default_rng(seed), 0, Fraction(gravity)
    for _ in range(draws(30)):
        static = Fraction(str(rng.choice([0.125, 0.25, 0.3, 0.5])))
        kinetic = static * Fraction(str(rng.choice([0.5, 0.8, 1.0])))
        along, share = (
            drawn(rng, parts, static * g / int(rng.integers(1, 3))),
            Fraction(int(rng.integers(0, 4))),
        )
        normal = [(width, share * level) for width, level in drawn(rng, parts, g / 2)]
        steps = zip(levels_of(along, parts), levels_of(normal, parts), strict=True)
        exact = walk(Drive([(Fraction(1, parts), x, y) for x, y in steps], static, kinetic, g), 20)
        drive = Scene(
            motion=Motion.steps(along=rounded(along), normal=rounded(normal) if share else None),
            frequency=1.0,
            static_friction=float(static),
            kinetic_friction=float(kinetic),
            gravity=float(g),
            restitution=0.0,
        )
        history = vibro.simulate(drive, cycles=12)
        times = np.minimum(np.arange(min(len(exact), 13)), history.end)
        wanted = [float(body.x) for body in exact[: times.size]]
        assert history.sample(times).position == pytest.approx(wanted, rel=1e-10, abs=1e-10)
        last = exact[-1]
        period = next((k for k in range(1, 10) if len(exact) > 20 and exact[-1 - k][1:] == last[1:]), 0)
        if period:
            repeating += 1
            found = vibro.solve(drive)
            assert found.status in (Status.OK, Status.BOUNDARY)
            mean = float(last.x - exact[-1 - period].x) / period
            assert found.displacement_per_cycle == pytest.approx(mean, rel=1e-10, abs=1e-10)
    assert repeating > 5
