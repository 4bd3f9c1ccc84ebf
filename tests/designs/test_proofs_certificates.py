"""Certificates of guarantees: accepted by a checker that shares nothing with vibro, refused when changed."""

from __future__ import annotations

from functools import cache
from typing import Any, NamedTuple
from unittest import mock

import numpy as np
import pytest
from engines.certificates import least_speeds, refusal
from helpers.scenes import scene_with

import vibro
from vibro import Guarantee, Scene
from vibro.designs import proofs
from vibro.results.designs import Certificate

UNCOVERED, BEYOND, OTHER = (
    "the boxes do not cover the set", "a box has bodies beyond its bound", "the bounds prove another speed",
)  # fmt: skip


def oval(**fields: float) -> Scene:
    known = {
        "along_amplitude": 5e-4, "normal_amplitude": 2e-4, "normal_phase": -0.5, "frequency": 25.0,
        "static_friction": 0.4, "kinetic_friction": 0.3,
    }  # fmt: skip
    return Scene(**(known | fields))


BACK = {"amplitude": 1.4e-3, "drive_angle": 0.35}
NEVER_AT_REST = {"amplitude": 3e-3, "drive_angle": 0.2, "static_friction": 0.2, "kinetic_friction": 0.15}
SLOWLY_SETTLED = {
    "amplitude": 3.1966e-3, "drive_angle": 0.2308, "static_friction": 0.18177, "kinetic_friction": 0.13857,
    "trough_angle": 0.12184,
}  # fmt: skip
BOXES: dict[str, tuple[Scene, dict[str, Any]]] = {
    "level": (scene_with(**BACK), {"static_friction": (0.6, 0.8)}),
    "level, ratio": (scene_with(**BACK), {"static_friction": (0.6, 0.8), "friction_ratio": (0.7, 0.9)}),
    "level, kinetic": (scene_with(**BACK), {"static_friction": (0.6, 0.8), "kinetic_friction": (0.5, 0.7)}),
    "climb": (
        scene_with(**BACK, trough_angle=0.05),
        {"static_friction": (0.65, 0.75), "friction_ratio": (0.75, 0.85), "amplitude": (1.38e-3, 1.4e-3),
         "frequency": (14.95, 15.05), "drive_angle": (0.34, 0.36)},
    ),
    "decline": (
        scene_with(**BACK),
        {"static_friction": (0.6, 0.8), "friction_ratio": (0.75, 0.77), "trough_angle": (-0.06, -0.04)},
    ),
    "a drop inside": (scene_with(), {"amplitude": (1.18e-3, 1.21e-3)}),
    "slowly settled": (scene_with(**SLOWLY_SETTLED), {"static_friction": (0.175, 0.19)}),
    "continuous sliding": (
        scene_with(**NEVER_AT_REST), {"static_friction": (0.198, 0.2), "kinetic_friction": (0.159, 0.16)},
    ),
    "backward": (
        scene_with(drive_angle=0.05, trough_angle=0.3, static_friction=0.74, kinetic_friction=0.5),
        {"amplitude": (1.9e-3, 2e-3), "frequency": (14.0, 15.0), "trough_angle": (0.28, 0.3)},
    ),
    "ellipse": (oval(), {"static_friction": (0.38, 0.42), "friction_ratio": (0.75, 0.85)}),
    "ellipse, phase": (oval(), {"static_friction": (0.38, 0.42), "normal_phase": (-0.55, -0.45)}),
    "ellipse, all of its motion": (
        oval(),
        {"along_amplitude": (4.98e-4, 5.02e-4), "normal_amplitude": (1.98e-4, 2.02e-4),
         "normal_phase": (2.0, 2.02), "frequency": (24.95, 25.0)},
    ),
    "ellipse across": (oval(), {"along_amplitude": (0.0, 1e-4), "static_friction": (0.38, 0.4)}),
}  # fmt: skip
SIDES = [pytest.param(name, fast, id=f"{name}, {'fast' if fast else 'slow'}est")
         for name in BOXES for fast in (False, True)]  # fmt: skip


class Proof(NamedTuple):
    """A bound as it is printed: the word, the speed of the extreme body, that proved, and the certificate."""

    word: str
    speed: float
    proved: float
    certificate: Certificate


@cache
def guarantee(name: str) -> Guarantee:
    scene, bands = BOXES[name]
    with mock.patch.object(proofs, "GAP", 1e-3):  # fewer boxes
        return vibro.guarantee(scene, **bands)


def proof(name: str, fast: bool) -> Proof:
    found, end = guarantee(name), "max" if fast else "min"
    return Proof(*(getattr(found, f"{field}_{end}") for field in ("proof", "found", "proved", "certificate")))


def checked(name: str, fast: bool, certificate: Certificate, proved: float | None = None) -> str:
    """Check a certificate of the least, or largest, of its own bounds unless another speed is given."""
    scene, bands = BOXES[name]
    if proved is None:
        proved = float(certificate.bound.max() if fast else certificate.bound.min())
    own = proof(name, fast).certificate
    least = known(name, fast) if certificate.low is own.low and certificate.high is own.high else None
    return refusal(scene.arrays()._asdict(), bands, certificate, proved, fast=fast, least=least)


@cache
def known(name: str, fast: bool) -> Any:
    """Bound the speeds in the boxes of a certificate, once for all that is claimed of them."""
    scene, bands = BOXES[name]
    return least_speeds(scene.arrays()._asdict(), bands, proof(name, fast).certificate, fast=fast)


def kept(certificate: Certificate, which: Any) -> Certificate:
    low, high = ({name: x[which] for name, x in side.items()} for side in certificate[:2])
    return Certificate(low, high, certificate.bound[which])


@pytest.mark.parametrize(("name", "fast"), SIDES)
def test_what_is_printed_as_proved_is_accepted(name: str, fast: bool) -> None:
    word, speed, proved, certificate = proof(name, fast)
    assert word == "proved"
    assert (proved >= speed) if fast else (proved <= speed)
    assert checked(name, fast, certificate, proved) == ""
    assert checked(name, fast, certificate, proved + (-1e-12 if fast else 1e-12)) == OTHER


@pytest.mark.parametrize(("name", "fast"), SIDES)
def test_a_bound_beyond_the_extreme_body_is_refused(name: str, fast: bool) -> None:
    """By a thousandth of a millimetre per second, in every box."""
    _, speed, _, certificate = proof(name, fast)
    side = -1.0 if fast else 1.0
    raised = side * np.maximum(side * certificate.bound, side * speed + 1e-6)
    assert checked(name, fast, certificate._replace(bound=raised)) == BEYOND
    unknown = certificate._replace(bound=np.full_like(raised, np.nan))
    assert checked(name, fast, unknown, proved=float("nan")) == BEYOND


def body_inside(name: str, box: dict[str, tuple[float, float]]) -> float | None:
    """Speed of the body in the middle of a box, None where there is no such friction."""
    scene, bands = BOXES[name]
    fields = {key: float(x) for key, x in scene.arrays()._asdict().items()}
    frequency = bands.get("frequency", (fields["frequency"],) * 2)
    middle = {key: 0.5 * (low + high) for key, (low, high) in box.items()}
    ratio = bands.get("friction_ratio", (0.0, 1.0))
    if not ratio[0] <= middle["kinetic_friction"] / middle["static_friction"] <= ratio[1]:
        return None
    weight = middle.pop("load") * fields["gravity"] / (2.0 * np.pi) ** 2  # factor f^2
    factor = bands.get("amplitude", (fields.get("amplitude", 1.0),) * 2)
    fields |= middle | {"frequency": min(max(np.sqrt(weight / factor[0]), frequency[0]), frequency[1])}
    scale = weight / fields["frequency"] ** 2
    if "amplitude" in fields:
        fields["amplitude"] = scale
    else:
        fields["along_amplitude"], fields["normal_amplitude"] = (
            scale * fields["along_amplitude"], scale * fields["normal_amplitude"],
        )  # fmt: skip
    return float(vibro.solve(Scene(**fields)).mean_velocity)


@pytest.mark.parametrize(("name", "fast"), SIDES)
def test_a_bound_beyond_one_body_of_its_box_is_refused(name: str, fast: bool) -> None:
    certificate = proof(name, fast).certificate
    side, tried = -1.0 if fast else 1.0, 0
    for row in np.random.default_rng(0).permutation(len(certificate.bound)):
        low, high = ({key: float(x[row]) for key, x in ends.items()} for ends in certificate[:2])
        speed = body_inside(name, {key: (low[key], high[key]) for key in low})
        if speed is None:
            continue
        assert side * certificate.bound[row] <= side * speed + 1e-15
        bound = certificate.bound.copy()
        bound[row] = speed + side * 1e-7
        assert checked(name, fast, certificate._replace(bound=bound)) == BEYOND
        tried += 1
        if tried == 2:
            return
    assert tried > 0


@pytest.mark.parametrize(("name", "fast"), SIDES)
def test_boxes_that_leave_something_out_are_refused(name: str, fast: bool) -> None:
    certificate = proof(name, fast).certificate
    random, count = np.random.default_rng(1), len(certificate.bound)
    for row in {0, count - 1, int(random.integers(0, count))}:
        assert checked(name, fast, kept(certificate, np.arange(count) != row), proved=0.0) == UNCOVERED
        wide = [k for k in certificate.low if certificate.low[k][row] < certificate.high[k][row]]
        axis = wide[random.integers(0, len(wide))]
        ends = {key: x.copy() for key, x in certificate.high.items()}
        ends[axis][row] -= 1e-6 * (ends[axis][row] - certificate.low[axis][row])
        assert checked(name, fast, certificate._replace(high=ends)) == UNCOVERED


def test_boxes_of_narrower_bands_or_of_bodies_that_hop_are_refused() -> None:
    scene, bands = BOXES["climb"]
    fields, (_, _, proved, certificate) = scene.arrays()._asdict(), proof("climb", fast=False)
    for name, (low, high) in bands.items():
        for wider in ((low * (1 - 1e-9), high), (low, min(high * (1 + 1e-9), 1.0))):
            changed = bands | {name: wider}
            if wider != (low, high):
                assert refusal(fields, changed, certificate, proved) == UNCOVERED
    throwing = bands | {"amplitude": (1.38e-3, 3.6e-3)}
    assert refusal(fields, throwing, certificate, proved) == "some body hops"
