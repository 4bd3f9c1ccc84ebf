"""Bounces do not matter to the displacement while the slide keeps its way.

From a lift-off to the contact after the last bounce the contact force and the impacts bring what the load of
the body on the trough brings, negative part included, also of the first moment: both ends have no height and
no normal speed. Friction is the same share of it as long as the velocity has one sign at all impacts. So
velocity and displacement then are those of a body that does not bounce, but slides on that way.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, NamedTuple

import pytest
from helpers.draws import examples
from hypothesis import assume, given
from hypothesis import strategies as st

import vibro
from vibro import Scene, Status

if TYPE_CHECKING:
    from vibro.results.history import Phase

CYCLES = 60


class Chain(NamedTuple):
    """Flights of a steady cycle from its lift-off to the contact behind them; times over the drive cycle."""

    lift_off: float
    contact: float
    slides_until: float  # end of the slide behind them
    way: int  # of the velocity at all impacts, 0 where it changes


def _way(velocity: float) -> int:
    return (velocity > 0.0) - (velocity < 0.0)


def _chain(scene: Scene) -> Chain | None:
    """Return the flights of a cycle of one turn; None where there are several groups of them, or none."""
    history = vibro.simulate(scene, cycles=CYCLES)
    if history.period_cycles != 1 or not history.settles_at * float(scene.frequency) < CYCLES - 3:
        return None
    f = float(scene.frequency)
    phases = [p for p in history.phases if p.start >= history.settles_at - 1e-9 / f]
    first = next((i for i in range(1, len(phases)) if _takes_off(phases, i)), None)
    if first is None:
        return None
    last = first
    while phases[last + 1].kind == "H":
        last += 1
    following = next(i for i in range(last + 1, len(phases)) if _takes_off(phases, i))
    if abs((phases[following].start - phases[first].start) * f - 1.0) > 1e-9:
        return None
    ways = {_way(p.end_velocity) for p in phases[first : last + 1]}
    ways |= {_way(p.start_velocity) for p in phases[first + 1 : last + 2]}
    after = phases[last + 1]
    begin = phases[first].start
    slides = after.kind in "FB"
    return Chain(
        begin * f % 1.0,
        (after.start - begin) * f,
        ((after.end if slides else after.start) - begin) * f,
        ways.pop() if len(ways) == 1 else 0,
    )


def _takes_off(phases: list[Phase], i: int) -> bool:
    return phases[i].kind == "H" and phases[i - 1].kind != "H"


def _motion(
    kind: str, throw: float, ratio: float, shares: list[float], phases: list[float]
) -> dict[str, Any]:
    """Make a drive whose first harmonic has a load off the trough of ``throw`` at 1 / (2 pi) Hz, g = 1."""
    if kind == "line":
        return {"amplitude": math.hypot(throw * ratio, throw), "drive_angle": math.atan2(1.0, ratio)}
    if kind == "ellipse":
        return {"along_amplitude": throw * ratio, "normal_amplitude": throw, "normal_phase": phases[0]}
    return {
        "along_harmonics": [(throw * ratio, 0.0), (throw * ratio * shares[0], phases[1])],
        "normal_harmonics": [(throw, phases[0]), (0.25 * throw * shares[1], phases[2])],
    }


@examples(25)
@given(
    kind=st.sampled_from(["line", "ellipse", "harmonics", "harmonics"]),
    throw=st.floats(1.01, 1.25),
    ratio=st.floats(0.5, 3.0),
    shares=st.lists(st.floats(0.01, 0.3), min_size=2, max_size=2),
    phases=st.lists(st.floats(-3.1, 3.1), min_size=3, max_size=3),
    mu_s=st.floats(0.2, 0.8),
    mu_d=st.floats(0.4, 1.0),
    slope=st.floats(-0.3, 0.3),
    restitution=st.floats(0.05, 0.5),
)
def test_bounces_do_not_matter_while_the_slide_keeps_its_way(
    kind: str,
    throw: float,
    ratio: float,
    shares: list[float],
    phases: list[float],
    mu_s: float,
    mu_d: float,
    slope: float,
    restitution: float,
) -> None:
    rest = {
        "frequency": 0.5 / math.pi,
        "static_friction": mu_s,
        "kinetic_friction": mu_s * mu_d,
        "trough_angle": slope * math.atan(mu_s * mu_d),
        "gravity": 1.0,
    }
    plastic, bouncing = (
        Scene(**_motion(kind, throw, ratio, shares, phases), **rest, restitution=e)
        for e in (0.0, restitution)
    )
    one, other = vibro.solve(plastic), vibro.solve(bouncing)
    assume(one.status == other.status == Status.OK and float(one.throw_number) > 1.0)
    here, there = _chain(plastic), _chain(bouncing)
    assume(here is not None and there is not None)
    assert here is not None
    assert there is not None
    assert here.lift_off == pytest.approx(there.lift_off, abs=1e-9)
    assert there.contact >= here.contact - 1e-9
    # the premise: one way at all impacts, and on until the bounces have ended
    assume(here.way == there.way != 0 and here.slides_until >= there.contact)
    size = max(throw, throw * ratio)
    expected = float(one.displacement_per_cycle)
    assert abs(float(other.displacement_per_cycle) - expected) <= 1e-11 * (abs(expected) + size)


def test_bounces_matter_where_the_body_would_have_turned_round() -> None:
    """The premise is needed: here the plastic body comes to rest before the bounces end."""
    drive = {"amplitude": 1.6 / math.sin(0.5), "frequency": 0.5 / math.pi, "drive_angle": 0.5, "gravity": 1.0}
    found = [
        float(
            vibro.solve(
                Scene(**drive, static_friction=0.7, kinetic_friction=0.6, restitution=e)
            ).displacement_per_cycle
        )
        for e in (0.0, 0.4)
    ]
    assert abs(found[1] / found[0] - 1.0) > 1e-3
