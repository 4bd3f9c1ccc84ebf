"""Long samples of kicked bodies: their hops, where their parts begin and end, and sums over them."""

from __future__ import annotations

import itertools
import math

import pytest
from helpers.cases import each

from vibro.core.drive import Loads, directions, line_loads
from vibro.core.flight import BOUNCE, after_landing, bed_of, flight
from vibro.core.hops import _spread, fly_sample, kick
from vibro.core.numbers import BODIES, MOST_HOPS
from vibro.core.return_map import Hops, write_hop

TURN = 2.0 * math.pi
LENGTH = 12  # events in each half of the samples below


def _hops() -> Hops:
    return Hops(*(memoryview(bytearray(8 * (MOST_HOPS + 10))).cast("d") for _ in range(8)))


HOPS, OTHERS = _hops(), _hops()


def _line(throw: float) -> Loads:
    angles = directions(0.5, 0.05)
    return line_loads(math.sin(0.5) / throw / math.cos(0.05), angles, 0.5, 0.4)


# Bodies that come to contact in every flight, after some, rarely, and never.
KINDS = [(2.0, 0.0), (1.3, 0.5), (4.3, 0.2), (1.6, 0.6), (1.7, 0.7), (2.24, 0.3), (3.5, 0.0)]


# ------------------------------------------------------------------------------- kicks


def testkicks_are_spread_evenly_and_differ_by_tenths_from_body_to_body() -> None:
    numbers = sorted(_spread(count, body) for count in range(50) for body in range(BODIES))
    assert numbers[0] >= 0.0
    assert numbers[-1] < 1.0
    gaps = [after - before for before, after in itertools.pairwise(numbers)]
    assert max(gaps) < 3.0 / len(numbers)  # multiples of the golden ratio: gaps of three lengths
    assert min(gaps) > 0.3 / len(numbers)
    for body in range(BODIES):
        assert kick(3, body) == pytest.approx(1e-4 * 10.0**-body * _spread(3, body), rel=1e-14)
    assert _spread(2, 1) == pytest.approx((26 * (math.sqrt(5.0) - 1.0) / 2.0) % 1.0, rel=1e-13)


# ------------------------------------------------------------------------------- hops


@each(("throw", "restitution"), KINDS)
@each("body", [0, 5, 6, 11])
def test_each_hop_starts_where_the_one_before_it_ends_or_iskicked(
    throw: float, restitution: float, body: int
) -> None:
    loads = _line(throw)
    bed = bed_of(loads)
    sample = fly_sample(loads, restitution, body, LENGTH, HOPS, 3)
    assert sample.ends
    phase, speed, hardest, landed = bed.lift_off, kick(0, body), 0.0, False
    events, shoved = 0, False
    for count, row in enumerate(range(3, sample.last), start=1):
        flown = flight(bed, phase, speed)
        hardest = max(hardest, flown.impact)
        after = after_landing(bed, phase + flown.length, flown.impact, restitution, 1e-4)
        length = flown.length + after.length
        assert HOPS.length[row] == length
        assert HOPS.landing[row] == pytest.approx((phase + length) % TURN, rel=1e-12)
        write_hop(loads, phase, length, after.impulse, OTHERS, row)
        for got, expected in zip(HOPS[:6], OTHERS[:6], strict=True):
            assert got[row] == expected[row]
        landed = landed or after.contact
        events += length > BOUNCE or after.contact
        if after.contact:
            rest = (bed.lift_off - HOPS.landing[row]) % TURN
            assert HOPS.rest[row] == pytest.approx(rest, abs=1e-9)
            phase, speed = bed.lift_off, kick(count, body)
            continue
        assert HOPS.rest[row] == 0.0
        phase, speed = HOPS.landing[row], restitution * flown.impact
        patience = 1 if body < 6 else 3  # soft kicks get three times as long until the first contact
        if not landed and not shoved and events >= patience * (LENGTH // 2 + body):
            shoved = True
            speed *= 1.0 + 1e-2 * _spread(count, body)
    assert sample.impact == hardest
    assert sample.lands is landed


# ------------------------------------------------------------------------------- parts
