"""Records beside elliptical drives: signals, the trough's own motion, comparison and estimates."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from made_records import FREQUENCY, ON_ELLIPSES, PERIOD, Walked, bowl, nut, trough_record

import vibro
from vibro.errors import InputError
from vibro.records.comparison import compare
from vibro.records.fitting import FITTABLE, Fit, fit
from vibro.records.trough import MeasuredDrive, trough_of

SIGNALS = ("displacement", "velocity", "acceleration", "friction")
SLIP = ("static_friction", "kinetic_friction")
ELLIPSE = ("along_amplitude", "normal_amplitude", "normal_phase")
TURN = 2.0 * math.pi


@pytest.mark.parametrize("label", ["F_", "B_", "F_B_", "FB_", "F_B", "FB"])
@pytest.mark.parametrize("signals", [("displacement",), ("velocity",), ("acceleration", "friction")])
def test_a_record_is_aligned_and_compared(label: str, signals: tuple[str, ...]) -> None:
    walked = Walked(ON_ELLIPSES[label])
    comparison = compare(ON_ELLIPSES[label], walked.observe(*signals))
    assert comparison.passing == "forwards"
    assert comparison.motion.pattern == label
    assert abs(comparison.alignment.shift - 0.0137) < 4.0 * comparison.alignment.error < 0.05 * PERIOD
    assert comparison.warnings == ()
    for row in comparison.rows:
        if row.key in ("stroke_advance", "mean_speed"):
            assert abs(row.measured.value - row.computed) < 4.0 * row.measured.error


def held(found: Fit, true: vibro.Scene) -> list[bool]:
    """Whether each interval holds the true value; phases within their turn."""
    return [
        any(low <= float(getattr(true, p.name)) <= high for low, high in p.intervals)
        for p in found.parameters
    ]


def begun(true: vibro.Scene, **wrong: float) -> vibro.Scene:
    return vibro.Scene(**{n: float(x) for n, x in true.arrays()._asdict().items()} | wrong)


@pytest.fixture
def own_start_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    """Search from the scene's own values alone, which takes a fraction of the time."""
    monkeypatch.setattr("vibro.records.problem._GRID", dict.fromkeys(FITTABLE, ()))


@pytest.mark.parametrize(
    ("label", "names", "wrong"),
    [
        ("FB_", (*SLIP, "normal_phase"), {"static_friction": 0.42, "normal_phase": -1.1}),
        ("FB_", ELLIPSE, {"along_amplitude": 1.05e-3, "normal_phase": -1.1}),
        ("FB", ELLIPSE, {"along_amplitude": 1.4e-3, "normal_amplitude": 0.9e-3}),
        ("F_B_", ("normal_amplitude", "normal_phase"), {"normal_amplitude": 3.2e-4, "normal_phase": -1.1}),
    ],
)
@pytest.mark.usefixtures("own_start_alone")
def test_intervals_hold_the_unknowns_of_an_ellipse(
    label: str, names: tuple[str, ...], wrong: dict[str, float]
) -> None:
    """Three seeds; of the quantities at 95 % at most two lie outside, and none by far."""
    true = ON_ELLIPSES[label]
    walked = Walked(true)
    inside: list[bool] = []
    for seed in range(3):
        observed = walked.observe("displacement", "velocity", cycles=6, seed=seed)
        found = fit(begun(true, **wrong), observed, names)
        inside += held(found, true)
        for p in found.parameters:
            value = float(getattr(true, p.name))
            assert p.identified
            assert abs(p.value - value) < 4.0 / 1.96 * 0.5 * (p.high - p.low), p.name
            assert p.high - p.low < 0.35 * abs(value), p.name
    assert inside.count(False) <= 2


def test_an_ellipse_is_found_from_afar() -> None:
    """The valley of the misfit bends: straight steps would end far from its lowest point."""
    true = ON_ELLIPSES["FB"]
    far = begun(true, along_amplitude=1.95e-3, normal_amplitude=7e-4, normal_phase=0.5)
    found = fit(far, Walked(true).observe("displacement", "velocity", cycles=6), ELLIPSE)
    for p in found.parameters:
        half, value = 0.5 * (p.high - p.low), float(getattr(true, p.name))
        assert abs(p.value - value) < 4.0 / 1.96 * half < 0.05 * abs(value), p.name


@pytest.mark.parametrize("given", [-50.0, 300.0, 119.0, -420.0])
def test_a_phase_is_told_in_the_turn_of_the_scenes(given: float) -> None:
    """Also next to the phase opposite to it, where a search crosses from one turn to the other."""
    true = ON_ELLIPSES["FB_"]
    observed = Walked(true).observe("velocity", cycles=6)
    (p,) = fit(begun(true, normal_phase=math.radians(given)), observed, ["normal_phase"]).parameters
    assert p.identified
    assert abs(p.value - math.radians(given)) <= 0.5 * TURN
    off = math.remainder(p.value - math.radians(-60.0), TURN)
    assert abs(off) < 4.0 / 1.96 * 0.5 * (p.high - p.low) < 0.02
    assert p.low < p.value < p.high


def test_a_phase_without_a_normal_motion_cannot_be_identified() -> None:
    level = bowl(normal_amplitude=0.0, static_friction=0.3, kinetic_friction=0.2)
    found = fit(level, Walked(level).observe("velocity", cycles=6), ["kinetic_friction", "normal_phase"])
    friction, phase = found.parameters
    assert friction.identified
    assert not phase.identified
    assert phase.intervals == ()
    assert any("cannot identify phi" in said for said in found.statements)


@pytest.mark.parametrize(
    ("one", "name", "said", "hint"),
    [
        (bowl(), "drive_angle", "moves along an ellipse, which has no drive angle", "mu_s, mu_d, X, Y, phi"),
        (nut(), "normal_phase", "moves along a line, which has no normal phase", "mu_s, mu_d, A, alpha"),
        (bowl(normal_amplitude=0.0), "normal_amplitude", "begins at the scene's, which is 0", "--normal 0.3"),
    ],
)
def test_what_a_drive_does_not_have_is_not_fitted(one: vibro.Scene, name: str, said: str, hint: str) -> None:
    with pytest.raises(InputError, match=said) as caught:
        fit(one, Walked(one).observe("velocity", cycles=3), [name])
    assert hint in caught.value.hint


def test_scenes_that_cannot_be_compared_are_refused() -> None:
    observed = Walked(bowl()).observe("velocity", cycles=3)
    shared = {"frequency": FREQUENCY, "static_friction": 0.4, "kinetic_friction": 0.3}
    waves = vibro.Scene(along_harmonics=[(1e-3, 0.0), (3e-4, 1.0)], normal_harmonics=[(1e-4, 0.0)], **shared)
    for run in (lambda: compare(waves, observed), lambda: fit(waves, observed, SLIP)):
        with pytest.raises(InputError, match="a drive with harmonics cannot be compared") as caught:
            run()
        assert "--along, --normal and --phase" in caught.value.hint
    for x, y in ((0.0, 0.0), (1e-21, 1e-22), (1e21, 1e-3)):
        with pytest.raises(InputError, match=r"along_amplitude = .* beside a record"):
            compare(bowl(along_amplitude=x, normal_amplitude=y), observed)
    assert compare(bowl(along_amplitude=0.0, trough_angle=-0.28), observed).passing == ""


def measured(phase: float | None, lead: float, **options: Any) -> MeasuredDrive:
    trough = trough_of(trough_record(ellipse=lead, **options), down=True)
    assert trough is not None
    return trough.drive_on_ellipse(phase)


@pytest.mark.parametrize("lead_deg", [-179.0, -60.0, 0.0, 90.0])
def test_errors_of_an_ellipse_are_those_of_repeated_noise(lead_deg: float) -> None:
    lead = math.radians(lead_deg)
    x, y = (1.02e-3 * side(math.radians(20.5)) for side in (math.cos, math.sin))
    true = {"along_amplitude": x, "normal_amplitude": y, "normal_phase": lead, "frequency": 15.003}
    off: dict[str, list[float]] = {}
    for seed in range(20):
        drive = measured(0.0, lead, noise=0.5, offset=3.0, seed=seed)
        assert list(drive.quantities) == ["along_amplitude", "normal_amplitude", "frequency", "normal_phase"]
        for name, estimate in drive.quantities.items():
            wrapped = math.remainder(estimate.value - true[name], TURN)
            off.setdefault(name, []).append(wrapped / estimate.error)
        error = math.remainder(drive.clock.value - 0.0137, 1.0 / 15.003)
        off.setdefault("clock", []).append(error / drive.clock.error)
    for name, values in off.items():
        assert 0.5 < float(np.sqrt(np.mean(np.square(values)))) < 1.6, name
        assert max(map(abs, values)) < 4.0, name


@pytest.mark.parametrize("column", ["trough_along", "trough_normal"])
def test_one_acceleration_gives_one_amplitude_and_the_clock(column: str) -> None:
    drive = measured(1.1, 1.1, columns=(column,))
    amplitude = "along_amplitude" if column == "trough_along" else "normal_amplitude"
    assert list(drive.quantities) == [amplitude, "frequency"]
    assert drive.clock.value == pytest.approx(0.0137, abs=1e-6)
    assert drive.warnings == ()


def test_a_motion_normal_to_the_trough_alone_tells_the_clock_by_the_scenes_phase() -> None:
    drive = measured(1.1, 1.1, angle=0.5 * math.pi, noise=0.3)
    assert "normal_phase" not in drive.quantities
    assert abs(drive.clock.value - 0.0137) < 4.0 * drive.clock.error < 1e-3


@pytest.mark.parametrize(
    ("lead_deg", "noise", "ellipse"),
    [(0.0, 0.0, False), (1.9, 0.0, False), (2.1, 0.0, True), (-2.1, 0.0, True), (4.0, 3.0, False),
     (60.0, 3.0, True), (-150.0, 0.0, True), (177.8, 0.0, True)],
)  # fmt: skip
def test_an_ellipse_is_one_beyond_its_error(lead_deg: float, noise: float, ellipse: bool) -> None:
    trough = trough_of(trough_record(ellipse=math.radians(lead_deg), noise=noise))
    assert trough is not None
    assert trough.on_an_ellipse == ellipse


@pytest.mark.parametrize("lead_deg", [-150.0, -60.0, 12.0, 120.0])
def test_an_ellipse_in_the_place_of_a_line_is_told_with_the_options_to_give(lead_deg: float) -> None:
    drive = measured(None, math.radians(lead_deg), noise=1e-3)
    said, *more = drive.warnings
    numbers = [float(word) for word in said.replace("=", " ").replace("mm", " ").replace("deg", " ").split()
               if word.lstrip("-").replace(".", "").isdigit()]  # fmt: skip
    expected = [1.02 * math.cos(math.radians(20.5)), 1.02 * math.sin(math.radians(20.5)), lead_deg]
    assert numbers == pytest.approx([*expected, *expected], rel=2e-3)
    assert f"--phase{'=' if lead_deg < 0.0 else ' '}" in said
    assert len(more) == (abs(lead_deg) > 90.0)
    assert all("one of the two sensors may be inverted" in text for text in more)


@pytest.mark.parametrize(("given", "doubts"), [(170.0, 0), (-170.0, 0), (0.0, 1), (-75.0, 1), (-85.0, 0)])
def test_a_phase_nearly_opposite_to_the_scenes_is_doubted(given: float, doubts: int) -> None:
    drive = measured(math.radians(given), math.radians(-170.0))
    assert len(drive.warnings) == doubts


def test_the_troughs_clock_places_the_record() -> None:
    observed = Walked(bowl()).observe("velocity", trigger=0.02)
    drive = measured(None, math.radians(-60.0), frequency=FREQUENCY, trigger=0.02)
    comparison = compare(bowl(), replace(observed, clock=drive.clock))
    assert comparison.alignment.shift == pytest.approx(0.02, abs=1e-6)
    assert comparison.warnings == ()


def test_one_slide_a_cycle_leaves_phases_to_both_sides() -> None:
    """Its load is the same for a phase and its opposite, and the start of a slide tells little."""
    true = ON_ELLIPSES["F_"]
    wrong = begun(true, static_friction=0.42, normal_phase=1.1)
    found = fit(wrong, Walked(true).observe("velocity", cycles=6), ("static_friction", "normal_phase"))
    assert all(held(found, true))
    phase = found.parameters[1]
    assert [low > 0.0 for low, _ in phase.intervals] == [False, True]
    assert not phase.identified
