"""Bounds with known extremes: which proof and which end is taken, and how limits at jumps are named."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from helpers.cases import each
from helpers.scenes import replaced, scene_with

import vibro
from vibro import Regime, Scene
from vibro.designs import guarantees, proofs
from vibro.designs.guarantees import BOXES, BRIEF, Bound, Extreme, Seen, _limit, bound, guarantee_of
from vibro.designs.proofs import back_slip_load, slowest_in_contact
from vibro.designs.spaces import uncertainty_set
from vibro.limits import CriticalLoads, critical_loads
from vibro.results.designs import Certificate

INF, NAN = math.inf, math.nan
OVAL: dict[str, Any] = {
    "along_amplitude": 5e-4, "normal_amplitude": 2e-4, "normal_phase": -0.5, "frequency": 25.0,
    "static_friction": 0.4, "kinetic_friction": 0.3,
}  # fmt: skip


def extreme(speed: float, scene: Scene | None = None) -> Extreme:
    return Extreme(speed, np.zeros((6, 1)), scene or scene_with())


def boxed(*proofs: float) -> Certificate:
    """Certificate of boxes of which only the bounds count."""
    return Certificate({}, {}, np.array(proofs))


@each("side", [1.0, -1.0])
@each(
    ("speed", "least", "proof", "expected"),
    [
        (0.1, 0.1, "proved", 0.1), (0.1, 0.0991, "proved", 0.0991), (0.1, 0.02, "proved", 0.02),
        (0.1, -0.3, "proved", -0.3), (-0.1, -0.1009, "proved", -0.1009), (0.0, 0.0, "proved", 0.0),
        (0.1, -INF, "searched", 0.1),
    ],
)  # fmt: skip
def test_the_bound_is_what_the_boxes_prove_and_only_without_one_the_body_found(
    speed: float, least: float, proof: str, expected: float, side: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The least of all boxes of the slowest body, the largest of the fastest one."""
    certificate = boxed(*(side * x for x in (0.2, least, 0.3)))
    monkeypatch.setattr(guarantees, "searched", lambda *_, **__: (extreme(side * speed), certificate))
    box = uncertainty_set(scene_with(amplitude=2e-3), {"static_friction": (0.7, 0.74)})
    found = bound(box, fast=side < 0.0, seen=Seen(), boxes=BRIEF)
    assert (found.extreme.speed, found.proof, found.proved) == (side * speed, proof, side * least)
    assert found.speed == side * expected
    assert found.certificate is certificate


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_a_body_without_a_speed_proves_that_nothing_is_guaranteed(
    side: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Boxes bound a body that runs away forward from below, though it counts as the slowest."""
    monkeypatch.setattr(guarantees, "searched", lambda *_, **__: (extreme(-side * INF), boxed(0.1)))
    box = uncertainty_set(scene_with(amplitude=2e-3), {"static_friction": (0.7, 0.74)})
    found = bound(box, fast=side < 0.0, seen=Seen(), boxes=BRIEF)
    assert found[1:] == ("proved", -side * INF, None)


@pytest.mark.parametrize(
    "scene",
    [
        scene_with(),
        scene_with(amplitude=4e-3),
        Scene(**OVAL),
        Scene(**(OVAL | {"normal_amplitude": 6e-4})),
    ],
)
@pytest.mark.parametrize("fast", [False, True])
def test_the_proof_of_a_single_body(scene: Scene, fast: bool) -> None:
    """It is at its corner, also where it hops."""
    found = bound(uncertainty_set(scene, {}), fast=fast, seen=Seen(), boxes=BRIEF)
    speed = float(vibro.solve(scene).mean_velocity)
    assert (found.extreme.speed, found.proof, found.proved) == (speed, "corners", speed)
    assert found.certificate is None


@pytest.mark.parametrize(
    ("contact", "hopping", "fast", "expected"),
    [
        (0.2, 0.1, False, 0.1), (0.1, 0.2, False, 0.1), (0.2, 0.1, True, 0.2), (0.1, 0.2, True, 0.2),
        (NAN, 0.3, False, 0.3), (NAN, 0.3, True, 0.3),  # all hop
        (0.2, NAN, False, -INF), (0.2, NAN, True, INF),  # no speed of a hopping body is known
        (NAN, NAN, False, -INF), (NAN, NAN, True, INF),
    ],
)  # fmt: skip
def test_of_a_box_that_hops_the_more_extreme_body_counts(
    contact: float, hopping: float, fast: bool, expected: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(guarantees, "searched", lambda *_, **__: (extreme(contact), None))
    monkeypatch.setattr(guarantees, "sampled", lambda *_, **__: extreme(hopping))
    box = uncertainty_set(scene_with(amplitude=4e-3), {"static_friction": (0.7, 0.74)})
    found = bound(box, fast=fast, seen=Seen(), boxes=BRIEF)
    assert (found.extreme.speed, found.proof) == (expected, "sampled")
    assert math.isnan(found.proved)


@pytest.mark.parametrize(("factor", "proof"), [(1.0, "corners"), (1.0 - 1e-12, "proved"), (1.5, "corners")])
def test_at_the_load_of_back_slip_no_body_slips_back_yet(
    factor: float, proof: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    box = uncertainty_set(scene_with(), {"static_friction": (0.7, 0.74)})
    monkeypatch.setattr(guarantees, "back_slip_load", lambda box: box.load[1] * factor)
    monkeypatch.setattr(guarantees, "searched", lambda *_, **__: (extreme(0.1), boxed(0.1)))
    assert bound(box, fast=False, seen=Seen(), boxes=BRIEF).proof == proof


BELOW, ABOVE = 0.04, 0.03


def limit_at(
    monkeypatch: pytest.MonkeyPatch,
    load: str,
    factor: float,
    speed: float,
    above: float = ABOVE,
    scene: Any = None,
) -> tuple[str, Any]:
    """Return the limit of a body whose load is near a critical one, where the speed jumps."""
    scene = scene or scene_with()
    value = np.asarray(float(scene.load) * factor)
    others = dict.fromkeys(CriticalLoads._fields, np.asarray(INF))
    monkeypatch.setattr(guarantees, "change_loads", lambda _: {**others, load: value})
    solved: list[Scene] = []

    def speeds(scene: Scene, **_: Any) -> Any:
        solved.append(scene)
        return np.array([BELOW, above])

    monkeypatch.setattr(guarantees, "speeds_of", speeds)
    return _limit(extreme(speed, scene)), solved[0] if solved else None


@each(
    ("load", "text"),
    [
        ("back_slip", "back slip begins"),
        ("back_onset", "the load for back slip is reached"),
        ("forward_onset", "forward slip begins"),
        ("hop", None),
        ("continuous_sliding", None),
    ],
)
@each(("speed", "side"), [(BELOW, "below"), (ABOVE, "above"), (0.0351, "below"), (0.0349, "above")])
def test_a_limit_at_a_jump_is_named(
    load: str, text: str | None, speed: float, side: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    found, _ = limit_at(monkeypatch, load, 1.0 + 1e-8, speed)
    assert found == (f"from {side} the load at which {text}" if text else "")


@each(
    ("factor", "above", "jumps"),
    [
        (1.0 + 0.9e-7, ABOVE, True), (1.0 - 0.9e-7, ABOVE, True), (1.0 + 1.2e-7, ABOVE, False),
        (1.0 - 1.2e-7, ABOVE, False), (1.0, BELOW, False), (1.0, BELOW * (1 + 0.9e-6), False),
        (1.0, BELOW * (1 + 1.2e-6), True), (1.0, BELOW * (1 - 1.2e-6), True), (1.0, 0.0, True),
    ],
)  # fmt: skip
def test_only_a_jump_near_a_load_is_a_limit(
    factor: float, above: float, jumps: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    found, _ = limit_at(monkeypatch, "back_slip", factor, BELOW, above)
    assert bool(found) is jumps


def test_both_sides_of_a_jump_have_the_motion_scaled(monkeypatch: pytest.MonkeyPatch) -> None:
    factor = 1.0 + 0.5e-7
    beside = factor * (1.0 + 1e-9 * np.array([-1.0, 1.0]))
    for scene, names in (
        (scene_with(), ["amplitude"]),
        (Scene(**OVAL), ["along_amplitude", "normal_amplitude"]),
    ):
        _, solved = limit_at(monkeypatch, "back_slip", factor, BELOW, scene=scene)
        for name, value in scene.arrays()._asdict().items():
            expected = float(value) * beside if name in names else np.full(2, float(value))
            np.testing.assert_allclose(np.broadcast_to(getattr(solved, name), 2), expected, rtol=1e-15)


def test_the_onset_of_forward_slip_is_a_limit_of_its_speed() -> None:
    """Static friction exceeds kinetic friction, so that parts start with a jump."""
    unit = scene_with(amplitude=1.0)
    amplitude = float(critical_loads(unit).forward_onset / unit.load)
    speed = float(vibro.solve(scene_with(amplitude=amplitude * (1 + 1e-9))).mean_velocity)
    assert speed > 1e-4
    found = vibro.guarantee(scene_with(), amplitude=(amplitude * 0.99, amplitude * (1 - 1e-10)))
    assert (found.speed_max, found.max_limit) == (0.0, "from below the load at which forward slip begins")


def test_every_number_of_a_guarantee_has_its_place(monkeypatch: pytest.MonkeyPatch) -> None:
    slow, fast = scene_with(amplitude=1e-3), scene_with(amplitude=2e-3)

    def proofs(box: Any, *, fast: bool, seen: Seen, boxes: int) -> Bound:
        asked.append(boxes)
        seen.samples += 11
        seen.excluded += 3
        seen.coexists |= fast
        seen.regimes = {Regime.NO_SLIP, Regime.HOPPING}
        return (
            Bound(extreme(0.2, scenes[1]), "sampled", 0.21, most)
            if fast
            else Bound(extreme(0.1, scenes[0]), "corners", 0.09, least)
        )

    scenes = slow, fast
    asked: list[int] = []
    least, most = boxed(0.09), boxed(0.21)
    monkeypatch.setattr(guarantees, "bound", proofs)
    monkeypatch.setattr(guarantees, "_limit", lambda end: f"limit of {end.speed:g}")
    found = guarantee_of(uncertainty_set(slow, {}))
    assert (found.speed_min, found.speed_max) == (0.09, 0.21)
    assert (found.found_min, found.found_max) == (0.1, 0.2)
    assert (found.min_limit, found.max_limit) == ("limit of 0.1", "limit of 0.2")
    assert (found.proof_min, found.proof_max) == ("corners", "sampled")
    assert found.regimes == frozenset({Regime.NO_SLIP, Regime.HOPPING})
    assert (found.proved_min, found.proved_max) == (0.09, 0.21)
    assert found.certificate_min is least
    assert found.certificate_max is most
    assert (found.coexists, found.excluded, found.samples, asked) == (True, 6, 22, [BOXES, BOXES])
    for place, scene in ((found.min_at, slow), (found.max_at, fast)):
        assert place == {name: float(value) for name, value in scene.arrays()._asdict().items()}


@pytest.mark.parametrize("angles", [(0.1, 1.2), (0.1, 0.3), (0.6, 1.2), (0.42, 0.48)])
def test_the_fastest_body_where_none_slips_back(angles: tuple[float, float]) -> None:
    """Of a grid of drive angles, at the largest load, the least frictions and the flattest trough."""
    unit = 9.81 / (2.0 * math.pi * 15.0) ** 2
    least, most = 0.5 * unit, 0.55 * unit
    scene = scene_with(amplitude=least, drive_angle=angles[0], static_friction=0.6, kinetic_friction=0.5)
    bands: dict[str, Any] = {
        "amplitude": (least, most), "drive_angle": angles, "static_friction": (0.55, 0.6),
        "friction_ratio": (0.8, 0.9), "trough_angle": (0.0, 0.03),
    }  # fmt: skip
    box = uncertainty_set(scene, bands)
    found = bound(box, fast=True, seen=Seen(), boxes=BRIEF)
    assert float(box.load[1]) <= float(back_slip_load(box))
    grid = np.linspace(*angles, 2001)
    fields: dict[str, Any] = {
        "amplitude": most,
        "drive_angle": grid,
        "static_friction": 0.55,
        "kinetic_friction": 0.44,
        "trough_angle": 0.0,
    }
    speeds = np.asarray(vibro.solve(replaced(scene, **fields)).mean_velocity)
    assert np.max(speeds) > 0.0
    assert found.extreme.speed >= np.max(speeds) * (1 - 1e-12)
    assert found.extreme.speed == pytest.approx(np.max(speeds), rel=1e-5)


def test_a_slower_body_that_the_boxes_meet_starts_the_evolution_anew(monkeypatch: pytest.MonkeyPatch) -> None:
    """Here the first population is not moved, and has missed it."""
    monkeypatch.setattr(proofs, "_MOST_GENERATIONS", 0)
    box = uncertainty_set(scene_with(), {"amplitude": (1.18e-3, 1.21e-3)})
    alone, met = (slowest_in_contact(box, fast=False, boxes=boxes).speeds[0] for boxes in (1, BRIEF))
    assert met < alone * (1.0 - 1e-9)
