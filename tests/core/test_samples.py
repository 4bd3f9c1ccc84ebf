"""Long samples of kicked bodies: their hops, where their parts begin and end, and sums over them."""

from __future__ import annotations

import itertools
import math

import pytest
from helpers.cases import each

from vibro.core.drive import Loads, directions, ellipse_loads, line_loads
from vibro.core.flight import BOUNCE, after_landing, bed_of, flight
from vibro.core.hops import BodySample, _spread, fly_sample, kick
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


def _ellipse(throw: float) -> Loads:
    return ellipse_loads(0.8, 1.0, 1.0 / throw, directions(-1.2, 0.0), 0.5, 0.4)


def _fly(throw: float, restitution: float, body: int = 0, length: int = LENGTH, row: int = 0) -> BodySample:
    return fly_sample(_line(throw), restitution, body, length, HOPS, row)


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


@pytest.mark.parametrize("loads", [_line(2.5), _ellipse(2.5), _line(1.3), _ellipse(4.3)])
@pytest.mark.parametrize("body", [1, 9])
def test_sums_are_those_of_the_hops_of_each_half(loads: Loads, body: int) -> None:
    sample = fly_sample(loads, 0.3, body, LENGTH, HOPS, 2)
    assert sample.ends
    assert 2 < sample.first < sample.middle < sample.last
    halves = range(sample.first, sample.middle), range(sample.middle, sample.last)
    times = [sum(HOPS.length[row] + HOPS.rest[row] for row in half) for half in halves]
    assert (sample.first_time, sample.second_time) == pytest.approx(times)
    assert sample.aloft == pytest.approx(sum(HOPS.length[row] for half in halves for row in half))
    phi = math.atan2(loads.phase_sine, loads.phase_cosine)
    lift_off = math.asin(loads.weight_normal / loads.drive_normal)
    first, middle, last = (
        math.cos((lift_off if HOPS.rest[row - 1] > 0.0 else HOPS.landing[row - 1]) - phi)
        for row in (sample.first, sample.middle, sample.last)
    )
    assert sample.trough == pytest.approx(first, abs=1e-12)
    assert sample.first_swing == pytest.approx(first - middle, abs=1e-12)
    assert sample.second_swing == pytest.approx(middle - last, abs=1e-12)
    assert sample.lands is any(HOPS.rest[row] > 0.0 for row in range(2, sample.last))
    # swings, with gravity, are what the hops and contacts between add to the velocity in flight
    if all(HOPS.rest[row] == 0.0 for half in halves for row in half):
        gain = sum(HOPS.gain[row] for row in halves[0])
        fall = loads.weight_tangential * sample.first_time
        assert gain == pytest.approx(loads.drive_tangential * sample.first_swing - fall, abs=1e-9)


def test_rows_before_the_first_are_left_alone() -> None:
    for column in HOPS:
        column[6] = -7.0
    assert _fly(2.0, 0.0, row=7).first == 7 + LENGTH // 2
    assert [column[6] for column in HOPS] == [-7.0] * 8


# ------------------------------------------------------------------------------- parts


@each("body", [0, 1, 6, 11])
@each("length", [12, 13, 48])
def test_a_body_that_lands_in_every_flight_has_one_transient_and_two_halves(body: int, length: int) -> None:
    # the transient is longer from body to body, so that what repeats is met at different moments
    sample = _fly(2.0, 0.0, body, length)
    assert sample.lands
    assert sample.first == length // 2 + body
    assert sample.middle - sample.first == sample.last - sample.middle == length


@each(("body", "transient"), [(0, 2 * 6), (5, 2 * 11), (6, 4 * 12), (11, 4 * 17)])
@each(("throw", "restitution"), [(2.24, 0.3), (3.5, 0.0)])
def test_a_body_that_never_lands_has_two_transients_of_which_softkicks_prolong_the_first(
    throw: float, restitution: float, body: int, transient: int
) -> None:
    sample = _fly(throw, restitution, body)
    assert not sample.lands
    assert sample.first == transient
    assert sample.middle - sample.first == sample.last - sample.middle == LENGTH


def test_parts_end_with_a_contact_once_there_was_one_or_after_three_times_their_events() -> None:
    ends = set()
    for throw, restitution, body in itertools.product((1.3, 1.6, 1.7, 3.0, 4.3), (0.2, 0.6, 0.7), (0, 4, 10)):
        sample = _fly(throw, restitution, body)
        assert sample.ends
        for start, end in ((sample.first, sample.middle), (sample.middle, sample.last)):
            contact = [HOPS.rest[row] > 0.0 for row in range(start, end)]
            event = [HOPS.length[row] > BOUNCE or HOPS.rest[row] > 0.0 for row in range(start, end)]
            landed = any(HOPS.rest[row] > 0.0 for row in range(end))
            assert event[-1]
            if contact[-1]:
                # no contact before it came late enough
                assert LENGTH <= sum(event) <= 3 * LENGTH
                counts = itertools.accumulate(event)
                assert [n >= LENGTH and c for n, c in zip(counts, contact, strict=True)].index(True) == len(
                    event
                ) - 1
            else:
                assert sum(event) == (3 * LENGTH if landed else LENGTH)
            ends.add((contact[-1], landed))
    assert ends == {(True, True), (False, True), (False, False)}


def test_bounces_that_are_short_are_no_events_and_those_within_a_ten_thousandth_are_summed() -> None:
    sample = _fly(1.002, 0.9)
    lengths = [HOPS.length[row] for row in range(sample.last)]
    assert sum(length < BOUNCE for length in lengths) > 5 * LENGTH
    # the first flight of an excursion and its contact are events: 6 of the transient and 12 of each half
    contacts = [row for row in range(sample.last) if HOPS.rest[row] > 0.0]
    assert len(contacts) == (6 + 12 + 12) / 2
    # with the last flight that is no bounce to be summed, a little shorter than what is
    assert min(lengths[row] for row in contacts) > 0.8e-4
    assert max(lengths[row] for row in contacts) < 1.2e-4


def test_a_body_with_too_many_bounces_does_not_come_to_the_end() -> None:
    sample = _fly(1.00001, 0.9999)
    assert not sample.ends
    assert sample.last == MOST_HOPS
    assert HOPS.length[MOST_HOPS - 1] > 0.0
    assert _fly(1.00001, 0.9).ends
