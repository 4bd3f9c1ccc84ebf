"""Legs and histories of one body: beside the law of Newton and 60 digits."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import mpmath
import numpy as np
import pytest
from helpers.cases import each

from vibro.core.bounces import Flights
from vibro.core.codes import Mode
from vibro.core.drive import Loads, directions, ellipse_loads, line_loads
from vibro.core.history import (
    Course,
    Followed,
    LastStarts,
    Launch,
    Legs,
    State,
    Step,
    course_of,
    follow_legs,
    sections_of,
    starting,
    step,
)
from vibro.core.numbers import LONGEST_CYCLE, MOST_BOUNCES

if TYPE_CHECKING:
    from numpy.typing import NDArray


TURN = 2.0 * math.pi
ROWS = 20_000

_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(24)
_SIZE = MOST_BOUNCES + LONGEST_CYCLE


def view(values: Any) -> Any:
    """See numbers as a buffer."""
    array: Any = np.asarray(values)
    return memoryview(array)


FLIGHTS = Flights(*(view(np.zeros(_SIZE)) for _ in Flights._fields))
LAST = LastStarts(view(np.zeros(_SIZE, np.int64)), view(np.zeros(_SIZE)))


def line(load: float, drive_deg: float, mu_s: float, mu_d: float, trough_deg: float = 0.0) -> Loads:
    """Make the loads of a drive along a line from G."""
    return line_loads(1.0 / load, directions(math.radians(drive_deg), math.radians(trough_deg)), mu_s, mu_d)


def ellipse(
    load: float, normal: float, phase_deg: float, mu_s: float, mu_d: float, trough_deg: float = 0.0
) -> Loads:
    """Make the loads of an elliptical drive, as high as ``normal`` times its length, from that length's G."""
    angles = directions(math.radians(phase_deg), math.radians(trough_deg))
    return ellipse_loads(1.0, normal, 1.0 / load, angles, mu_s, mu_d)


CONTACT = {
    "F_": line(0.9, 20.0, 0.74, 0.57),
    "F_B_": line(0.7, 1.0, 0.5, 0.49),
    "FB_": line(0.9, 20.0, 0.5, 0.4),
    "BF_": line(0.781, 57.03, 0.27, 0.155, 3.46),
    "FB": line(2.0, 25.0, 0.2, 0.15),
    "FB uphill": line(2.2, 20.0, 0.45, 0.3, 3.0),
    "B_": line(0.5, 5.0, 0.3, 0.29, 12.0),
    "presses": line(1.0, 75.0, 0.6, 0.5, -6.0),
    "more than 90 deg": line(0.85, 70.0, 0.9, 0.6, 30.0),
    "ellipse F_B_": ellipse(0.6, 0.4, -60.0, 0.5, 0.35),
    "ellipse FB_": ellipse(0.8, 0.4, -60.0, 0.5, 0.35),
    "ellipse FB": ellipse(2.2, 0.4, 130.0, 0.2, 0.15, 2.0),
    "ellipse turned": ellipse(1.8, 0.5, 200.0, 0.45, 0.4, -3.0),
}
HOPS = {
    "HFB": (line(3.4, 30.0, 0.5, 0.4), 0.0),
    "HB": (line(4.5, 25.0, 0.2, 0.1, 5.0), 0.0),
    "HHB": (line(8.6, 30.0, 0.5, 0.4), 0.0),
    "HHH": (line(8.5, 30.0, 0.5, 0.4), 0.3),
    "bounces": (line(3.0, 30.0, 0.5, 0.4), 0.3),
    "many bounces": (line(2.5, 30.0, 0.5, 0.2, -4.0), 0.6),
    "ellipse": (ellipse(3.0, 0.6, -35.0, 0.5, 0.4), 0.0),
    "ellipse back": (ellipse(3.0, 0.6, -170.0, 0.5, 0.4, 2.0), 0.3),
    "ellipse thrown at once": (ellipse(4.0, 0.5, 80.0, 0.6, 0.45, 5.0), 0.0),
}
ALL = {
    **{name: (loads, 0.0) for name, loads in CONTACT.items()},
    **{f"hops, {k}": v for k, v in HOPS.items()},
}


def load_along(loads: Loads, p: NDArray[np.float64] | float) -> NDArray[np.float64]:
    """F of Eq. (54), at phases of the normal motion."""
    phi = math.atan2(loads.phase_sine, loads.phase_cosine)
    return np.asarray(loads.drive_tangential * np.sin(p - phi) - loads.weight_tangential)


def load_normal(loads: Loads, p: NDArray[np.float64] | float) -> NDArray[np.float64]:
    """N of Eq. (54)."""
    return np.asarray(loads.weight_normal - loads.drive_normal * np.sin(p))


def newton(loads: Loads, mode: int, at: State, s: float) -> tuple[float, float, float, float]:
    """Path, velocity, height and its rate of a body a phase after the start of a leg, by quadrature."""
    friction = {Mode.FORWARD: -1.0, Mode.BACK: 1.0}.get(Mode(mode), 0.0) * loads.kinetic_friction
    panels = max(1, math.ceil(s))
    u = (np.arange(panels)[:, None] + 0.5 * (1.0 + _NODES)) * (s / panels)
    weights = 0.5 * (s / panels) * _WEIGHTS
    normal = load_normal(loads, at.phase + u)
    pull = load_along(loads, at.phase + u) + friction * normal
    rate = at.rate * loads.weight_normal
    return (
        at.velocity * s + float((weights * (s - u) * pull).sum()),
        at.velocity + float((weights * pull).sum()),
        rate * s - float((weights * (s - u) * normal).sum()),
        rate - float((weights * normal).sum()),
    )


def walked(course: Course, phase: float, velocity: float, count: int) -> list[tuple[State, Step]]:
    """Follow a body through some legs."""
    at, legs = starting(course, phase, velocity), []
    for _ in range(count):
        leg = step(course, at)
        legs.append((at, leg))
        if math.isinf(leg.length):
            break
        at = leg.after
    return legs


def history_of(
    loads: Loads, restitution: float, cycles: float, *, phase: float = 0.0, velocity: float = 0.0,
    rows: int = ROWS,
) -> tuple[Followed, Legs]:  # fmt: skip
    """Follow a body until it repeats, as ``vibro.simulate`` does."""
    course = course_of(loads, restitution)
    legs = room(rows)
    sections = sections_of(course, FLIGHTS)
    return follow_legs(course, sections, Launch(phase, velocity, 0.0, 0.0), cycles, legs, rows, LAST), legs


def room(rows: int) -> Legs:
    """Make room for legs."""
    return Legs(*(view(np.zeros(rows, kind)) for kind in ("b", "q", *"dddddddd")))


STARTS = [(0.0, 0.0), (4.0, -0.8), (-8.0, 0.5)]


def _check(loads: Loads, restitution: float, at: State, leg: Step) -> None:
    """Compare a leg with Newton's law, and its end with the event that ends it."""
    after, s = leg.after, leg.length
    path, velocity, height, rate = newton(loads, at.mode, at, s)
    mesh = at.phase + s * np.linspace(1e-6, 1.0 - 1e-6, 60)
    along, normal = load_along(loads, mesh), load_normal(loads, mesh)
    end_along, end_normal = float(load_along(loads, at.phase + s)), float(load_normal(loads, at.phase + s))
    capacity = loads.static_friction * end_normal
    assert after.cycle * TURN + after.phase == pytest.approx(at.cycle * TURN + at.phase + s, abs=1e-12)
    assert -1e-15 <= after.phase < TURN
    assert after.position == at.position + leg.displacement
    if at.mode == Mode.FLIGHT:
        assert leg.displacement == pytest.approx(path, abs=1e-12)
        assert leg.velocity == pytest.approx(velocity, abs=1e-12)
        inside = [newton(loads, at.mode, at, share * s)[2] for share in (0.01, 0.3, 0.6, 0.9, 0.99)]
        assert min(inside) > 0.0 or s < 1e-4
        n = loads.weight_normal
        assert height == pytest.approx(0.0, abs=1e-8)  # of the bounces that are summed
        if after.mode == Mode.FLIGHT:
            assert leg.impact * n == pytest.approx(-rate, abs=1e-12)
            assert after.rate == restitution * leg.impact
        impulse = loads.kinetic_friction * n * (1.0 + restitution) * leg.impact
        left = max(abs(leg.velocity) - impulse, 0.0)
        assert after.velocity == pytest.approx(math.copysign(left, leg.velocity), abs=1e-7)
        assert leg.gain == (1.0 if after.velocity else 0.0)
        return
    assert (normal > -1e-12).all()
    assert leg.impact == after.rate == at.rate == 0.0
    assert after.velocity == leg.velocity
    leaves = after.mode == Mode.FLIGHT
    if at.mode == Mode.REST:
        assert leg.displacement == leg.velocity == leg.gain == 0.0
        assert (np.abs(along) <= loads.static_friction * normal + 1e-9).all()
        if not leaves:
            way = 1.0 if after.mode == Mode.FORWARD else -1.0
            assert way * end_along == pytest.approx(capacity, abs=1e-12)
    else:
        way = 1.0 if at.mode == Mode.FORWARD else -1.0
        inside = [way * newton(loads, at.mode, at, share * s)[1] for share in (0.05, 0.3, 0.6, 0.95)]
        assert min(inside) > 0.0 or s < 1e-4
        assert leg.displacement == pytest.approx(path, abs=1e-12)
        assert leg.velocity == pytest.approx(velocity, abs=1e-12)
        if leaves:
            assert leg.gain == 1.0
            assert way * leg.velocity >= 0.0
        else:
            assert leg.velocity == 0.0
            expected = (
                Mode.REST if abs(end_along) <= capacity else Mode.FORWARD if end_along > 0 else Mode.BACK
            )
            assert after.mode == expected
            assert (leg.gain == 0.0) == (after.mode == Mode.REST)
    if leaves:
        assert end_normal == pytest.approx(0.0, abs=1e-12)
        assert math.cos(at.phase + s) > 0.0  # the trough begins to fall away


@each(("phase", "velocity"), STARTS)
@each("name", ALL)
def test_legs_obey_newtons_law_and_end_at_their_events(name: str, phase: float, velocity: float) -> None:
    loads, restitution = ALL[name]
    legs = walked(course_of(loads, restitution), phase, velocity, 24)
    for (at, leg), (then, _) in zip(legs, [*legs[1:], (legs[-1][1].after, None)], strict=True):
        assert then == leg.after
        _check(loads, restitution, at, leg)


@each("name", ALL)
def test_rests_end_at_onsets_and_contacts_at_the_lift_off_themselves(name: str) -> None:
    loads, restitution = ALL[name]
    course = course_of(loads, restitution)
    exact = {Mode.FORWARD: course.track.forward_onset, Mode.BACK: course.track.back_onset}
    for at, leg in walked(course, 0.0, 0.0, 24):
        if leg.after.mode == Mode.FLIGHT and at.mode != Mode.FLIGHT:
            assert leg.after.phase == course.track.lift_off
        elif at.mode == Mode.REST:
            assert leg.after.phase == exact[Mode(leg.after.mode)]


@pytest.mark.parametrize("slope", [0.0, 3.0])
@pytest.mark.parametrize("excess", [1e-13, 1e-9, 1e-5])
def test_short_slides_keep_their_digits(excess: float, slope: float) -> None:
    """Just above the onset, beside 60 digits: the length, and the displacement of the order of its cube."""
    static, kinetic = 0.5, 0.5 * (1.0 - 1e-3 * excess)
    drive, trough = math.radians(20.0), math.radians(slope)
    onset = (static * math.cos(trough) + math.sin(trough)) / (math.cos(drive) + static * math.sin(drive))
    loads = line(onset * (1.0 + excess), 20.0, static, kinetic, slope)
    (_, rest), (at, leg) = walked(course_of(loads, 0.0), 0.0, 0.0, 2)
    assert rest.after.mode == Mode.FORWARD
    with mpmath.workdps(60):
        a, b, n, t = (mpmath.mpf(x) for x in loads[:4])
        p = mpmath.asin((static * n + t) / (a + static * b))
        c = a + kinetic * b
        k = (kinetic * n + t) / c

        def velocity(s: mpmath.mpf) -> mpmath.mpf:
            return (mpmath.cos(p) - mpmath.cos(p + s)) / s - k

        s = mpmath.findroot(velocity, (0.9 * leg.length, 1.1 * leg.length))
        path = c * (s * mpmath.cos(p) - mpmath.sin(p + s) + mpmath.sin(p) - k * s * s / 2)
        assert leg.length == pytest.approx(float(s), rel=2e-15)
        assert leg.displacement == pytest.approx(float(path), rel=1e-14)
        assert at.phase == pytest.approx(float(p), abs=4e-16)


def test_a_body_leaves_at_once_where_the_trough_cannot_bear_it() -> None:
    loads, _ = HOPS["HFB"]
    course = course_of(loads, 0.0)
    edge = course.track.lift_off
    assert edge == pytest.approx(math.asin(1.0 / (3.4 * math.sin(math.radians(30.0)))), rel=1e-15)
    modes = [starting(course, edge + d, 0.0).mode for d in (-1e-9, 1e-9)]
    assert modes == [Mode.FORWARD, Mode.FLIGHT]
    modes = [starting(course, math.pi - edge + d, 0.7).mode for d in (-1e-9, 1e-9)]
    assert modes == [Mode.FLIGHT, Mode.FORWARD]
    loads, _ = HOPS["ellipse thrown at once"]  # from rest too
    at = starting(course_of(loads, 0.0), 0.0, 0.0)
    assert (at.mode, at.rate) == (Mode.FLIGHT, 0.0)
    assert load_normal(loads, at.phase) < 0.0


@pytest.mark.parametrize(("trough", "mode"), [(-40.0, Mode.FORWARD), (40.0, Mode.BACK)])
def test_on_a_steep_trough_a_slide_never_ends(trough: float, mode: Mode) -> None:
    course = course_of(line(0.5, 20.0, 0.5, 0.4, trough), 0.0)
    assert not course.rests
    at, leg = walked(course, 0.0, 0.0, 9)[-1]
    assert (at.mode, leg.length, leg.gain) == (mode, math.inf, 1.0)
    assert math.isnan(leg.displacement)
    assert math.isnan(leg.after.position)
    assert (leg.impact, leg.after.rate, leg.after.cycle) == (0.0, 0.0, at.cycle)
    # equality is not held
    loads = line(0.5, 20.0, 0.5, 0.4, 5.0)._replace(weight_normal=1.0, weight_tangential=0.5)
    assert not course_of(loads, 0.0).rests
    assert course_of(line(0.5, 20.0, 0.5, 0.4, math.copysign(26.5, trough)), 0.0).rests
    assert not course_of(line(0.5, 20.0, 0.5, 0.4, math.copysign(26.6, trough)), 0.0).rests


def test_bounces_that_accumulate_are_one_leg() -> None:
    """A body that lands softly: its bounces last and brake as their sums say, Eq. (33)."""
    loads, e = line(3.0, 30.0, 0.5, 0.4), 0.5
    course = course_of(loads, e)
    at = State(2, 4.5, int(Mode.FLIGHT), 1.0, 0.3, 1e-9)
    leg = step(course, at)
    normal = float(load_normal(loads, 4.5))
    v = 1e-9 * loads.weight_normal
    assert leg.after.mode == Mode.FORWARD
    assert leg.after.rate == 0.0
    assert leg.length == pytest.approx(2.0 * v / normal / (1.0 - e), rel=1e-6)
    # impulses: v (1 + e) at the first landing, and the same share of each bounce after it
    assert leg.after.velocity - leg.velocity == pytest.approx(-0.4 * v * (1.0 + e) / (1.0 - e), rel=1e-6)
    assert leg.after.cycle == 2


def test_a_rest_that_ends_where_the_drive_s_cycle_begins_counts_that_cycle() -> None:
    """Rounding may leave its end on the other side."""
    course = course_of(CONTACT["F_"], 0.0)
    for onset in (0.0, 1e-16, math.nextafter(TURN, 0.0)):
        there = course._replace(track=course.track._replace(forward_onset=onset))
        for phase in np.linspace(0.5, 6.0, 200):
            after = step(there, State(7, float(phase), int(Mode.REST), 0.0, 0.0, 0.0)).after
            assert after.phase == onset
            assert after.cycle == (8 if onset < 1.0 else 7)


# ------------------------------------------------------------------------------
# Histories: legs that join, and where the cycle that repeats is looked for.


def _start(legs: Legs, row: int) -> float:
    return legs.cycle[row] * TURN + legs.phase[row]


def _assert_joined(found: Followed, legs: Legs) -> None:
    """Each leg starts where, when and as the one before it ends; the cycle's first behind its last."""
    for i in range(found.number):
        assert legs.length[i] > 0.0
        assert -1e-15 <= legs.phase[i] < TURN
        then, turns, advance = i + 1, 0, 0.0
        if then == found.number:
            if not found.period:
                break
            then, turns, advance = found.first, found.period, found.advance
        gap = _start(legs, then) + turns * TURN - _start(legs, i) - legs.length[i]
        assert abs(gap) < (1e-10 if then == found.first else 2e-14 * (100.0 + _start(legs, i)))
        end = legs.position[i] + legs.displacement[i]
        if turns:
            assert end == pytest.approx(legs.position[then] + advance, abs=1e-10)
        else:
            assert end == legs.position[then]
        if legs.mode[i] != Mode.FLIGHT:
            assert abs(legs.end_velocity[i] - legs.velocity[then]) <= (1e-10 if turns else 0.0)
            assert legs.impact[i] == legs.rate[i] == 0.0


def test_a_cycle_that_starts_with_the_drive_s_lasts_one_turn() -> None:
    """The fixed point may lie on the other side of phase 0 than the start that approaches it."""

    def start(phase_deg: float) -> tuple[float, Followed]:
        found, legs = history_of(ellipse(2.2, 0.1, phase_deg, 0.2, 0.15), 0.0, 1e9)
        _assert_joined(found, legs)
        rows = [i for i in range(found.first, found.number) if legs.mode[i] == Mode.FORWARD]
        return math.remainder(legs.phase[rows[0]], TURN), found

    low, high = -80.0, -60.0
    assert start(low)[0] < 0.0 < start(high)[0]
    seen = 0
    for _ in range(52):
        middle = 0.5 * (low + high)
        at, found = start(middle)
        assert found.period == 1
        seen += abs(at) < 1e-10
        low, high = (middle, high) if at < 0.0 else (low, middle)
    assert seen > 10
