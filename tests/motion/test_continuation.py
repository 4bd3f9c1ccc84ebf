"""Branches of cycles: against closed forms of the cycle of one bounce, Eq. (72)."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from helpers.scenes import GRAVITY, Groups, driven

import vibro
from vibro import Attractor, Branch, Scene, SceneError

DRIVE = 0.5
UNIT = GRAVITY / (2.0 * math.pi * 15.0) ** 2 / math.sin(DRIVE)  # [m] amplitude at which K = 1


def thrown(throw: float, restitution: float) -> Scene:
    return driven(Groups(throw / math.sin(DRIVE), math.degrees(DRIVE), 0.6, 0.5), None, restitution)


def cycle(throw: float, restitution: float, pattern: str) -> Attractor:
    return next(one for one in vibro.attractors(thrown(throw, restitution)) if one.pattern == pattern)


def branch(
    first: float, last: float, restitution: float = 0.5, pattern: str = "H", steps: int = 31
) -> Branch:
    values, start = UNIT * np.linspace(first, last, steps), cycle(first, restitution, pattern)
    return vibro.follow(thrown(first, restitution), "amplitude", values, start=start)


def events(found: Branch) -> list[tuple[str, Any]]:
    return [(one.kind, one.value / UNIT) for one in found.events]


def folds(e: float) -> float:
    return math.pi * (1.0 - e) / (1.0 + e)


def doubles(e: float) -> float:
    return math.hypot(folds(e), 2.0 * (1.0 + e * e) / (1.0 + e) ** 2)


@pytest.mark.parametrize("e", [0.3, 0.5, 0.6])
def test_one_bounce_doubles_and_is_followed_beyond(e: float) -> None:
    first = 0.5 * (max(folds(e), 1.0) + doubles(e))
    found = branch(first, 2.0 * doubles(e), e)
    assert events(found) == [("doubling", pytest.approx(doubles(e), abs=1e-9)), ("end", 2.0 * doubles(e))]
    throw = found.values / UNIT
    assert (np.diff(throw) > 0.0).all()
    assert (found.stable == (throw < doubles(e) - 1e-9)).all()
    lift = np.sqrt(throw**2 - folds(e) ** 2)
    trace, determinant = 1.0 + e * e - (1.0 + e) ** 2 * lift, e * e
    expected = [max(abs(np.roots([1.0, -t, determinant]))) for t in trace]
    np.testing.assert_allclose(abs(found.normal_multipliers).max(axis=1), expected, rtol=1e-6)
    np.testing.assert_allclose(np.prod(found.normal_multipliers, axis=1), e * e, rtol=1e-9)
    landing = 2.0 * math.pi / (1.0 + e) * GRAVITY / (2.0 * math.pi * 15.0)
    np.testing.assert_allclose(found.landing_speeds[:, 0], landing, rtol=1e-9)


def test_one_bounce_turns_at_its_fold_and_comes_back_unstable() -> None:
    found = branch(1.3, 1.0001)
    assert events(found) == [("fold", pytest.approx(folds(0.5), abs=1e-9)), ("end", pytest.approx(1.3))]
    turn = found.events[0].row
    throw = found.values / UNIT
    assert throw.min() == throw[turn]
    assert found.stable[:turn].all()
    assert not found.stable[turn:].any()
    assert (found.largest_multiplier[turn + 1 :] > 1.0).all()
    # to one side of the fold the trough rises faster, to the other it slows down: cos p = K_fold / K
    sides = np.where(np.arange(len(found)) < turn, 1.0, -1.0)
    phase = sides * np.arccos(np.minimum(folds(0.5) / throw, 1.0))
    np.testing.assert_allclose(np.sin(0.5 * (found.start_phase - phase)), 0.0, atol=1e-7)


def test_two_flights_end_where_one_bounce_doubles() -> None:
    found = branch(1.56, 1.3, pattern="HH")
    assert events(found) == [("doubling", pytest.approx(doubles(0.5), abs=1e-9))]
    assert found.stable[:-1].all()
    assert np.ptp(found.landing_speeds[-1]) < 1e-8
    assert np.ptp(found.landing_speeds[0]) > 0.01
    assert found.period_cycles == 2
    np.testing.assert_allclose(np.prod(found.normal_multipliers, axis=1), 0.5**4, rtol=1e-7)


def test_a_branch_agrees_with_what_bodies_do() -> None:
    found = branch(1.56, 1.7, pattern="HH", steps=6)
    for row in np.flatnonzero(found.stable)[:3]:
        one = cycle(found.values[row] / UNIT, 0.5, "HH")
        assert found.mean_velocity[row] == pytest.approx(one.mean_velocity, rel=1e-8)
        assert found.largest_multiplier[row] == pytest.approx(one.largest_multiplier, rel=1e-6)
    for row in (0, len(found) - 1):
        start = {name: float(getattr(found, name)[row]) for name in ("start_phase", "start_velocity")}
        history = vibro.simulate(
            thrown(found.values[row] / UNIT, 0.5),
            cycles=2.0,
            start_normal_velocity=float(found.start_normal_velocity[row]),
            **start,
        )
        begin, end = history.sample([0.0, history.end]).position
        moved = end - begin
        assert moved == pytest.approx(2.0 * found.displacement_per_cycle[row], rel=1e-6)


@pytest.mark.parametrize(
    ("name", "last", "fold"),
    [
        ("frequency", 12.0, lambda: 15.0 * math.sqrt(folds(0.5) / 1.3)),
        ("restitution", 0.2, lambda: (math.pi - 1.3) / (math.pi + 1.3)),
    ],
)
def test_any_quantity_may_be_followed(name: str, last: float, fold) -> None:  # type: ignore[no-untyped-def]
    scene = thrown(1.3, 0.5)
    values = np.linspace(float(getattr(scene, name)), last, 21)
    found = vibro.follow(scene, name, values, start=cycle(1.3, 0.5, "H"))
    assert [one.kind for one in found.events] == ["fold", "end"]
    assert found.events[0].value == pytest.approx(fold(), rel=1e-9)


def test_a_drive_with_hardly_any_harmonics_doubles_as_its_line() -> None:
    size = 1.3 * UNIT
    along, normal = size * math.cos(DRIVE), size * math.sin(DRIVE)
    motion = vibro.Motion.harmonics(along=[(along, 0.0), (1e-12, 0.0)], normal=[(normal, 0.0), (1e-12, 0.0)])
    scene = Scene(
        motion=motion,
        frequency=15.0,
        static_friction=0.6,
        kinetic_friction=0.5,
        restitution=0.5,
        gravity=GRAVITY,
    )
    start = next(one for one in vibro.attractors(scene) if one.pattern == "H")
    found = vibro.follow(scene, "motion_scale", np.linspace(1.0, 1.3, 11), start=start)
    assert found.events[0].kind == "doubling"
    assert found.events[0].value == pytest.approx(doubles(0.5) / 1.3, rel=1e-6)


def test_where_no_body_is_thrown_or_lands_for_good_the_branch_ends() -> None:
    """Without restitution the trough holds a body that lands where K sin p < 1: K = hypot(1, pi)."""
    found = vibro.follow(thrown(3.5, 0.0), "amplitude", UNIT * np.linspace(3.5, 2.0, 16))
    assert events(found) == [("contact", pytest.approx(math.hypot(1.0, math.pi), abs=1e-7))]
    assert events(branch(1.1, 0.5, 0.7)) == [("hop_limit", pytest.approx(1.0, abs=1e-7))]


def test_what_cannot_be_followed_is_said() -> None:
    scene, values = thrown(1.3, 0.5), UNIT * np.linspace(1.3, 1.5, 3)
    for one, options in ((thrown(1.3, 0.0), {}), (scene, {"start": cycle(1.3, 0.5, "H")})):
        with pytest.raises(SceneError, match="start = "):
            vibro.follow(one, "amplitude", 1.1 * values, **options)


def _fields(scene: Scene) -> dict[str, Any]:
    names = ("amplitude", "frequency", "drive_angle", "static_friction", "kinetic_friction", "restitution")
    return {name: float(getattr(scene, name)) for name in names}


def test_the_picture_and_the_table() -> None:
    found = branch(1.56, 1.9, pattern="HH")
    assert "doubling at" in repr(found)
    frame = found.to_frame()
    assert frame["event"].tolist().count("doubling") == 1
    assert frame["stable"].tolist() == found.stable.tolist()
    axes = found.draw().axes[0]
    lines = {gid: [line for line in axes.lines if line.get_gid() == gid] for gid in ("stable", "unstable")}
    assert [len(drawn) for drawn in lines.values()] == [2, 2]
    assert lines["stable"][0].get_linestyle() == "-"
    assert lines["unstable"][0].is_dashed()
    turn = 1e3 * found.events[0].value
    assert np.nanmax(lines["stable"][0].get_xdata()) == pytest.approx(turn)
    assert np.nanmin(lines["unstable"][0].get_xdata()) == pytest.approx(turn)
    texts = [text.get_text() for text in axes.figure.legends[0].get_texts()]
    assert texts[:2] == ["stable", "unstable"]
    assert texts[2].startswith("period doubling: ")
    assert axes.get_xlabel() == "amplitude $A$ [mm]"
    with pytest.raises(vibro.InputError, match="no picture"):
        found.draw("regime")  # type: ignore[arg-type]
