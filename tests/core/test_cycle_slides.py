"""The slides of known patterns: starts, ends and paths with 50 digits, and their order."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import pytest
from helpers.contact_loads import MP, TURN, Exact, ellipse, line, random_loads

from vibro.core.codes import PATTERNS, Pattern, Status
from vibro.core.contact import CycleSlides, SlideLeg, cycle_slides, steady_cycle
from vibro.core.slides import thresholds

if TYPE_CHECKING:
    from vibro.core.drive import Loads

# Direction of each slide, and whether it starts from rest, in the order of the pattern.
SLIDES = {
    "F_": ((1.0, True),),
    "B_": ((-1.0, True),),
    "F_B_": ((1.0, True), (-1.0, True)),
    "FB_": ((1.0, True), (-1.0, False)),
    "F_B": ((1.0, False), (-1.0, True)),
    "FB": ((1.0, False), (-1.0, False)),
}
MOST = 12  # scenes of a pattern and kind of drive


def _check(loads: Loads, leg: SlideLeg) -> None:
    exact, phase = Exact(loads), MP.atan2(loads.phase_sine, loads.phase_cosine)
    begin, end = leg.begin + phase, leg.end + phase  # of the normal motion
    if leg.from_rest:
        opens, closes = exact.window(leg.way)
        assert math.remainder(float(begin - opens), TURN) == pytest.approx(0.0, abs=1e-11)
        assert leg.start.window == pytest.approx(float(closes - opens) / 2, abs=1e-11)
    else:
        assert exact.pull(leg.way, exact.mu_s, begin) > -1e-11
    assert abs(exact.speed(leg.way, begin, end)) < 1e-12
    assert exact.speed(leg.way, begin, (begin + end) / 2) > 0
    assert leg.displacement == pytest.approx(float(leg.way * exact.path(leg.way, begin, end)), abs=1e-11)
    # the load's zero, where it rises
    kinetic = exact.load(leg.way, exact.mu_d)
    wave = kinetic * MP.expj(leg.zero + phase)
    assert abs(wave.imag) < 1e-14
    assert wave.real > 0
    assert leg.start.onset.load == pytest.approx(float(abs(kinetic)), rel=1e-14)
    resistance = exact.resistance(leg.way, exact.mu_d) / abs(kinetic)
    assert leg.start.onset.k == pytest.approx(float(resistance), abs=1e-13)
    own = leg.begin - leg.zero + leg.start.onset.c
    assert math.remainder(own - 0.5 * math.pi, TURN) == pytest.approx(0.0, abs=1e-12)


@pytest.mark.parametrize("name", SLIDES)
def test_slides_start_at_their_onsets_or_where_the_other_one_ends(name: str) -> None:
    pattern, seen = PATTERNS.index(name), {True: 0, False: 0}
    for loads in random_loads(500, 1, steepest=0.6):
        cycle = steady_cycle(loads, thresholds(loads))
        if cycle.pattern != pattern or cycle.status != Status.OK or seen[loads.line] == MOST:
            continue
        seen[loads.line] += 1
        found = cycle_slides(loads, pattern)
        legs = [leg for leg in found if leg.way]
        assert tuple((leg.way, leg.from_rest) for leg in legs) == SLIDES[name]
        for leg in legs:
            _check(loads, leg)
        assert 0.0 <= legs[0].begin < TURN
        assert sum(leg.displacement for leg in legs) == pytest.approx(cycle.displacement, abs=1e-10)
        if len(legs) == 2:
            first, second = legs
            follows = second.begin - first.end
            assert -1e-8 < follows < TURN
            if not second.from_rest:
                assert follows == pytest.approx(0.0, abs=1e-10)
            wait = first.begin + TURN - second.end
            assert wait > -1e-9
            assert (wait == pytest.approx(0.0, abs=1e-9)) == (not first.from_rest)
        else:
            assert found.second.way == 0.0
            assert math.isnan(found.second.begin)
    assert min(seen.values()) >= 5


def _is_empty(found: CycleSlides) -> bool:
    return all(leg.way == 0.0 and math.isnan(leg.displacement) for leg in found)


def test_there_are_none_without_slip() -> None:
    both = line(20.0, 0.5, 0.74, 0.57)
    assert _is_empty(cycle_slides(both, Pattern.R))
    assert _is_empty(cycle_slides(both, Pattern.NONE))
    assert not _is_empty(cycle_slides(both, Pattern.FB))
    one_way = line(20.0, 1.0, 0.74, 0.57)  # no back slip
    for pattern in (Pattern.F_B_, Pattern.FB_, Pattern.F_B, Pattern.FB):
        assert _is_empty(cycle_slides(one_way, pattern))


@pytest.mark.parametrize(
    ("loads", "pattern"),
    [
        (line(20.0, 1.0, 0.3, 0.02, -14.0), Pattern.F_),
        (line(5.0, 0.4, 0.3, 0.02, -14.0), Pattern.F_B_),
        (ellipse(1.0, 0.2, 2.0, 1.0, 0.3, 0.02, 0.25), Pattern.B_),
    ],
)
def test_a_slide_that_never_ends_has_a_start(loads: Loads, pattern: int) -> None:
    first = cycle_slides(loads, pattern).first
    assert 0.0 <= first.begin < TURN
    assert first.end == math.inf
    assert math.isnan(first.displacement)
