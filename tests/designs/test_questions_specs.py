"""Drives and what may be chosen of them: nearest ranges, accelerations, and whether anything is uncertain."""

from __future__ import annotations

import math
from dataclasses import fields
from typing import Any

import pytest

from vibro import Regime
from vibro.designs.questions import Drift, Drive, Goal, Spec
from vibro.designs.spaces import SPACES
from vibro.drives import Ellipse, Line

SEVERAL = ((10.0, 20.0), (40.0, 50.0), (100.0, 100.0))
LINE = Drive(
    "motor", Line, {"amplitude": ((1e-3, 2e-3),), "frequency": SEVERAL, "drive_angle": ((0.1, 0.5),)}
)
OVAL = Drive(
    "bowl",
    Ellipse,
    {
        "along_amplitude": ((1e-4, 3e-4),),
        "normal_amplitude": ((2e-4, 2.5e-4),),
        "normal_phase": ((0.0, 0.0),),
        "frequency": ((25.0, 30.0),),
    },
)


@pytest.mark.parametrize(
    ("value", "kept"),
    [(5.0, 10.0), (15.0, 15.0), (29.0, 20.0), (31.0, 40.0), (74.0, 50.0), (76.0, 100.0), (200.0, 100.0)],
)
def test_a_knob_is_kept_within_its_nearest_range(value: float, kept: float) -> None:
    assert LINE.inputs["frequency"].rounded(value, value, 9) == kept


def test_a_knob_of_one_range_has_a_span() -> None:
    assert LINE.span("amplitude") == (1e-3, 2e-3)
    assert LINE.frequency == SEVERAL
    with pytest.raises(ValueError, match="unpack"):
        LINE.span("frequency")


def test_accelerations_of_the_gentlest_and_the_hardest_setting() -> None:
    """A w^2, from the smallest amplitude at the lowest frequency to the largest at the highest."""
    assert LINE.accelerations == pytest.approx(
        (1e-3 * (2 * math.pi * 10) ** 2, 2e-3 * (2 * math.pi * 100) ** 2)
    )


def test_an_ellipse_accelerates_by_its_larger_amplitude_at_least() -> None:
    assert OVAL.accelerations == pytest.approx(
        (2e-4 * (2 * math.pi * 25) ** 2, 3e-4 * (2 * math.pi * 30) ** 2)
    )


def test_a_drive_without_frequencies_does_not_accelerate() -> None:
    assert Drive("", Line, {"amplitude": ((1e-3, 2e-3),), "frequency": ()}).accelerations == (0.0, 0.0)


def test_what_is_left_out_of_a_question() -> None:
    assert LINE.acceleration == math.inf
    assert (LINE.space, OVAL.space) == (SPACES[Line], SPACES[Ellipse])
    assert Goal(0.1) == Goal(0.1, Regime.BACK_SLIP, math.inf, math.inf)
    spec = Spec({}, (LINE,), Goal(0.1))
    assert (spec.gravity, spec.restitution, spec.stand_ratio, spec.length) == (9.81, None, math.inf, None)
    assert (spec.bounces, spec.has_bands) == ((0.0, 0.5), False)
    assert spec.drift == Drift(0.0, 0.0, 0.0, 0.0, 0.0)


@pytest.mark.parametrize(
    ("bands", "drift", "has"),
    [
        ({"static_friction": (0.4, 0.4), "trough_angle": (0.0, 0.0)}, {}, False),
        ({"static_friction": (0.4, 0.4), "trough_angle": (0.0, 0.1)}, {}, True),
        ({"static_friction": (0.4, 0.5), "trough_angle": (0.0, 0.0)}, {}, True),
        *(({"static_friction": (0.4, 0.4)}, {f.name: 0.01}, True) for f in fields(Drift)),
    ],
)
def test_a_band_or_a_drift_makes_a_question_uncertain(bands: Any, drift: Any, has: bool) -> None:
    assert Spec(bands, (LINE,), Goal(0.1), Drift(**drift)).has_bands is has
