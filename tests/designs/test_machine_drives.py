"""Machines as drives of questions: expansion into plain drives, and designs that hold with a full trough."""

from __future__ import annotations

import csv
import json
import math
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest
from typer.testing import CliRunner

import vibro
from vibro import Calibration, Machine, Regime
from vibro.cli.app import app
from vibro.designs import machine_drives
from vibro.designs.design import chosen_of, find_designs
from vibro.designs.machine_drives import amplitudes_met
from vibro.designs.optima import LineOptimiser
from vibro.designs.pictured import setting_fields, speed_band
from vibro.designs.questions import Met, Question
from vibro.designs.reading import read_spec
from vibro.designs.rows import find
from vibro.errors import InputError
from vibro.plots.design import design_figures

if TYPE_CHECKING:
    from vibro.results.designs import Design, DesignResult

EXAMPLE = Path(__file__).parents[2] / "examples" / "design_machine.toml"
PARTS = {"static_friction": "0.32:0.38", "kinetic_friction": "0.26:0.30"}
#: Worked feeder of docs/guide/machines.md, 0.35 mm at 50 Hz below resonance.
FEEDER: dict[str, Any] = {
    "name": "feeder", "kind": "magnet", "trough_mass_kg": 6, "counter_mass_kg": 12, "damping_ratio": 0.015,
    "natural_hz": 50 / 0.9, "calibration": {"amplitude_mm": 0.35, "frequency_hz": 50}, "frequency_hz": 50,
    "drive_angle_deg": 20,
}  # fmt: skip
#: 1 mm at 100 %, so that settings in percent have the digits of amplitudes.
MOTORS: dict[str, Any] = {
    "name": "motors", "kind": "unbalance", "vibrating_mass_kg": 100, "static_moment_kg_mm": 50, "motors": 2,
    "frequency_hz": "20:30", "drive_angle_deg": "10:40", "acceleration_g": 3,
}  # fmt: skip


def asked(
    drive: dict[str, Any], speed: float = 8.0, regime: str = "back-slip", **tables: Any
) -> dict[str, Any]:
    goal = {"speed_mm_s": speed, "highest_regime": regime}
    return {"scene": PARTS, "drive": [drive], "goal": goal, **tables}


def without(drive: dict[str, Any], *keys: str, **more: Any) -> dict[str, Any]:
    return {key: value for key, value in (drive | more).items() if key not in keys}


def design_of(result: DesignResult, kind: str, drive: str = "") -> Design:
    return next(d for d in result.designs if d.design == kind and (not drive or d.drive == drive))


GUARANTEED = (
    "amplitude_mm", "frequency_hz", "drive_angle_deg", "acceleration_g", "speed_min_mm_s",
    "speed_proved_mm_s", "speed_nominal_mm_s", "speed_max_mm_s", "margin", "throw_number_max", "set_by",
    "proof",
)  # fmt: skip


@pytest.fixture(autouse=True)
def brief(monkeypatch: pytest.MonkeyPatch) -> None:
    """Search fewer settings: few suffice here."""
    contact, *others = LineOptimiser._efforts
    monkeypatch.setattr(LineOptimiser, "_efforts", (replace(contact, generations=10, polish=20), *others))


@pytest.fixture
def fastest_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    """Search the fastest design of a full trough alone: the two others take twice as long."""
    monkeypatch.setattr(machine_drives, "SEARCHED", ("fastest",))


# 2 x 50 kg mm over 100 kg: 1 mm; the force of a magnet goes with the square of the voltage: 0.81 to 1.21 of
# its amplitude, which is 1.01 and 19.8 % either way
SAME: dict[str, tuple[Any, ...]] = {
    "unbalance": (
        MOTORS | {"drive_angle_deg": 30, "frequency_hz": 25}, 20.0, 1.0, (1.0, 1.0),
        {"amplitude_mm": 1, "frequency_hz": 25, "drive_angle_deg": 30, "acceleration_g": 3}, {},
    ),
    "voltage": (
        FEEDER | {"voltage_percent": "90:110"}, 6.0, 0.35, (0.81, 1.21),
        {"amplitude_mm": 0.35 * 1.01, "frequency_hz": 50, "drive_angle_deg": 20},
        {"amplitude_percent": 100.0 * 0.20 / 1.01},
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", SAME)
def test_machines_are_drives_of_their_amplitudes(name: str) -> None:
    machine, speed, full, covered, line, drift = SAME[name]
    one, other = (
        find(Question(spec, spec.drives[0], Regime.BACK_SLIP), {}, 12, until="fastest").row("fastest")
        for spec in map(read_spec, (asked(machine, speed), asked(line, speed, drift=drift)))
    )
    for field in GUARANTEED:
        value = getattr(other, field)
        value = pytest.approx(value, rel=1e-8) if isinstance(value, float) else value
        assert getattr(one, field) == value, field
    empty = one.amplitude_empty_mm or 0.0
    assert one.setting_percent == pytest.approx(100.0 * empty / full, rel=1e-12)
    assert one.amplitude_least_mm == pytest.approx(covered[0] * empty, rel=1e-12)
    assert one.amplitude_most_mm == pytest.approx(covered[1] * empty, rel=1e-12)
    assert (one.pack, one.operating_points) == (None, None)


def test_a_drift_of_the_frequency_passes_resonance() -> None:
    drive = without(FEEDER, natural_hz=50.2)
    (tuned,) = read_spec(asked(drive, drift={"frequency_percent": 1})).drives
    machine = Machine.magnet(
        trough_mass=6, counter_mass=12, natural_frequency=50.2, damping_ratio=0.015,
        calibration=Calibration(0.35e-3, 50),
    )  # fmt: skip
    seen = machine.response(np.linspace(49.5, 50.5, 2001)).amplitude / 0.35e-3
    assert tuned.machine is not None
    low, high = tuned.machine.covered
    assert low == pytest.approx(seen.min(), rel=1e-9)
    assert high == pytest.approx(seen.max(), rel=1e-3)


@pytest.mark.usefixtures("fastest_alone")
def test_a_filled_design_holds_at_every_filling_and_voltage() -> None:
    drive = FEEDER | {"natural_hz": 50 / 1.05, "voltage_percent": "95:105", "filling_kg": "0:2"}
    question = asked(drive, 5.0, drift={"amplitude_percent": 1})
    result = vibro.design(question, only="goal")
    assert result.met
    machine = Machine.magnet(
        trough_mass=6, counter_mass=12, natural_frequency=50 / 1.05, damping_ratio=0.015,
        calibration=Calibration(0.35e-3, 50),
    )  # fmt: skip
    rng = np.random.default_rng(33)
    for design in result.designs:
        assert design.setting_percent is not None
        setting = design.setting_percent / 100.0
        empty = machine.response(50.0, setting=setting).amplitude
        assert design.amplitude_empty_mm == pytest.approx(1e3 * empty, rel=1e-9)
        static, kinetic = rng.uniform(0.32, 0.38, 200), rng.uniform(0.26, 0.30, 200)
        points = vibro.operate(
            machine, frequency=50.0, drive_angle=math.radians(20), static_friction=static,
            kinetic_friction=kinetic, setting=setting, voltage=rng.uniform(0.95, 1.05, 200),
            filling=rng.uniform(0.0, 2.0, 200),
        )  # fmt: skip
        assert design.amplitude_least_mm is not None
        assert design.amplitude_most_mm is not None
        assert design.amplitude_least_mm <= 1e3 * points.amplitude_low.min()
        assert 1e3 * points.amplitude_high.max() <= design.amplitude_most_mm
        # what is covered is no wider than it need be, by a tenth
        met = 1e3 * (points.amplitude_high.max() - points.amplitude_low.min())
        assert design.amplitude_most_mm - design.amplitude_least_mm <= 1.6 * met
        cycle = vibro.solve(points.scene)
        assert cycle.regime.max() <= Regime.BACK_SLIP
        assert design.speed_min_mm_s is not None
        assert 1e3 * cycle.mean_velocity.min() >= design.speed_min_mm_s >= 5.0
        # and by the public guarantee, over the amplitudes that were met
        scene = vibro.Scene(
            amplitude=empty, frequency=50, drive_angle=math.radians(20), static_friction=0.35,
            kinetic_friction=0.28,
        )  # fmt: skip
        bands = {"static_friction": (0.32, 0.38), "kinetic_friction": (0.26, 0.30)}
        span = (0.99 * points.amplitude_low.min(), 1.01 * points.amplitude_high.max())
        assert 1e3 * vibro.guarantee(scene, amplitude=span, **bands).speed_min >= 5.0


@pytest.mark.usefixtures("fastest_alone")
def test_a_filling_prefers_springs_below_resonance() -> None:
    packs = [{"name": "stiff", "natural_hz": 50 / 0.9}, {"name": "soft", "natural_hz": 50 / 1.1}]
    drive = FEEDER | {"pack": packs}
    full = vibro.design(asked(drive | {"filling_kg": "0:2"}, 8.0), only="goal")

    def fastest(result: DesignResult, pack: str) -> float:
        design = design_of(result, "fastest", f"feeder ({pack})")
        assert design.pack == pack
        assert design.speed_min_mm_s is not None
        return design.speed_min_mm_s

    # an empty trough may be set to any amplitude with both, up to where parts hop
    empty = read_spec(asked(drive, 8.0))
    stiff, soft = (
        find(Question(empty, pack, Regime.BACK_SLIP), {}, until="fastest").row("fastest").speed_min_mm_s
        for pack in empty.drives
    )
    assert stiff == pytest.approx(soft, rel=2e-3)
    assert stiff is not None
    assert fastest(full, "soft") < fastest(full, "stiff") < stiff
    chosen = chosen_of(read_spec(asked(drive | {"filling_kg": "0:2"}, 8.0)), full)
    assert chosen is not None
    assert chosen.design.pack == "stiff"
    assert chosen.drive.machine is not None
    low, high = chosen.drive.machine.covered
    assert chosen.design.amplitude_most_mm == pytest.approx(high * (chosen.design.amplitude_empty_mm or 0.0))
    assert low < 1.0 < high


@pytest.mark.usefixtures("fastest_alone")
def test_no_design_is_told_whose_amplitudes_are_unknown(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(machine_drives, "amplitudes_met", lambda *_: Met(math.nan, math.nan, 0))
    spec = read_spec(asked(FEEDER | {"filling_kg": "0:2"}, 5.0))
    result = find_designs(spec, goal_only=True)
    assert not result.met
    assert all(design.setting_percent is None for design in result.designs)
    assert design_of(result, "fastest").set_by == "filling"
    assert chosen_of(spec, result) is None


@pytest.mark.usefixtures("fastest_alone")
def test_masses_must_not_strike_each_other() -> None:
    machine = Machine.magnet(
        trough_mass=6, counter_mass=12, natural_frequency=50 / 0.9, damping_ratio=0.015,
        calibration=Calibration(0.35e-3, 50),
    )  # fmt: skip
    relative = machine.response(50.0).relative_amplitude
    (empty,) = read_spec(asked(FEEDER | {"gap_mm": 500 * relative})).drives
    assert empty.machine is not None
    assert empty.machine.settings[1] == pytest.approx(0.5, rel=1e-12)
    with pytest.raises(InputError, match="50 %"):
        read_spec(asked(FEEDER | {"gap_mm": 500 * relative, "setting_percent": "60:100"}))
    drive = FEEDER | {"gap_mm": 600 * relative, "filling_kg": "0:2"}
    design = design_of(vibro.design(asked(drive, 3.0), only="goal"), "fastest")
    assert design.setting_percent is not None
    free = design_of(vibro.design(asked(FEEDER | {"filling_kg": "0:2"}, 3.0), only="goal"), "fastest")
    assert free.setting_percent is not None
    assert design.setting_percent < min(60.0, free.setting_percent)
    points = vibro.operate(
        machine, frequency=50.0, drive_angle=math.radians(20), static_friction=[0.32, 0.38],
        kinetic_friction=0.28, setting=design.setting_percent / 100.0, filling=2.0,
    )  # fmt: skip
    assert points.relative_amplitude.max() <= 0.6 * relative
    assert points.relative_amplitude.max() >= 0.55 * relative
    assert design.set_by == "gap"


@pytest.mark.parametrize(
    ("ratio", "followed", "by_sine", "within"),
    [(1.05, -0.490, -0.553, 0.02), (0.95, 0.453, 0.332, 0.055), (1.10, -0.23, -0.336, 0.04)],
)
def test_the_second_harmonic_explains_what_two_way_stepping_finds(
    ratio: float, followed: float, by_sine: float, within: float
) -> None:
    """Worked feeder with 4 kg: change of its speed, as followed in time."""
    scene = {"static_friction": 0.35, "kinetic_friction": 0.28, "restitution": 0}
    drive = FEEDER | {"natural_hz": 50 / ratio, "filling_kg": 4}
    spec = read_spec({**asked(drive), "scene": scene})
    question = Question(spec, spec.drives[0], Regime.HOPPING)
    machine = spec.drives[0].machine
    assert machine is not None
    setting = question.space.setting(
        amplitude=machine.amplitude, frequency=50.0, drive_angle=math.radians(20)
    )
    met = amplitudes_met(question, setting)
    empty = float(vibro.solve(question.nominal_scene(setting)).mean_velocity)
    full = replace(machine, covered=(met.low, met.high)).amplitude
    sine = question.space.setting(amplitude=full, frequency=50.0, drive_angle=math.radians(20))
    without_it = float(vibro.solve(question.nominal_scene(sine)).mean_velocity) / empty - 1.0
    assert without_it == pytest.approx(by_sine, abs=2e-3)
    assert met.speed / empty - 1.0 == pytest.approx(followed, abs=within)
    assert met.second_harmonic > 0.01


@pytest.mark.usefixtures("fastest_alone")
def test_given_shares_replace_those_that_are_computed() -> None:
    drive = FEEDER | {"filling_kg": 2, "added_mass_share": "0.1:0.25"}
    design = design_of(vibro.design(asked(drive, 5.0), only="goal"), "fastest")
    machine = Machine.magnet(
        trough_mass=6, counter_mass=12, natural_frequency=50 / 0.9, damping_ratio=0.015,
        calibration=Calibration(0.35e-3, 50),
    )  # fmt: skip
    seen = machine.response(50.0, added_mass=2.0 * np.array([0.1, 0.25])).amplitude / 0.35e-3
    least, most = (
        (size or 0.0) / (design.amplitude_empty_mm or 1.0)
        for size in (design.amplitude_least_mm, design.amplitude_most_mm)
    )
    assert least <= seen.min()
    assert seen.max() <= most
    assert most - least == pytest.approx(seen[1] - seen[0], rel=0.2)


def test_a_machine_without_bands_or_filling_is_certain() -> None:
    scene = {"static_friction": 0.35, "kinetic_friction": 0.28}
    spec = read_spec({**asked(FEEDER), "scene": scene})
    assert not spec.has_bands
    assert replace(spec).drives[0].machine is not None
    for more in ({"voltage_percent": "90:110"}, {"filling_kg": "0:1"}):
        assert read_spec({**asked(FEEDER | more), "scene": scene}).has_bands


@pytest.fixture
def coarse(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("vibro.plots.design._RESOLVED", 41)
    monkeypatch.setattr("vibro.designs.pictured._POINTS", {False: 41, True: 41})


def test_the_example_is_answered_in_settings_on_the_command_line(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("vibro.answers.drawing.design_pictures", lambda *_: {})  # drawn below
    run = CliRunner().invoke(app, ["design", str(EXAMPLE), "-o", f"{tmp_path}/"])
    assert run.exit_code == 0, run.output
    assert "met by feeder (6 leaves)" in " ".join(run.stdout.split())
    answer = json.loads((tmp_path / "design_machine-design.json").read_text(encoding="utf-8"))
    assert answer["columns"]["setting_percent"] == "%"
    designs = {(d["pack"], d["design"]): d for d in answer["designs"] if d["setting_percent"] is not None}
    assert designs.keys() == {("7 leaves", "fastest"), ("4 leaves", "fastest")} | {
        ("6 leaves", kind) for kind in ("gentlest", "fastest", "safest")
    }
    # faster than without it, as a full feeder is below resonance
    assert 12.7 < designs["6 leaves", "safest"]["speed_second_harmonic_mm_s"] < 13.0
    assert {row["nominal_speed_percent"] for row in answer["costs"]} >= {"changes the amplitude too"}
    # as examples/design_machine.toml and docs/guide/design.md say
    speeds = {key: design["speed_min_mm_s"] for key, design in designs.items()}
    assert speeds["7 leaves", "fastest"] == pytest.approx(10.0, abs=0.05)
    assert speeds["4 leaves", "fastest"] == pytest.approx(11.2, abs=0.05)
    assert speeds["6 leaves", "fastest"] == pytest.approx(13.1, abs=0.05)
    settings = [designs["6 leaves", kind]["setting_percent"] for kind in ("gentlest", "fastest")]
    assert settings == pytest.approx([63.6, 69.3], abs=0.1)
    assert designs["7 leaves", "fastest"]["set_by"] == "limit"
    assert designs["4 leaves", "fastest"]["set_by"] == "hop"
    with (tmp_path / "design_machine-design.csv").open(encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    assert [row["pack"] for row in rows if row["setting_percent"]] == [pack for pack, _ in designs]
    assert {path.suffix for path in tmp_path.iterdir()} == {".csv", ".json"}


@pytest.mark.usefixtures("coarse", "fastest_alone")
def test_a_picture_of_a_filled_machine_tells_of_its_design_alone() -> None:
    spec = read_spec(asked(FEEDER | {"filling_kg": "0:1"}, 6.0))
    chosen = chosen_of(spec, find_designs(spec, goal_only=True))
    assert chosen is not None
    figures = design_figures(spec, chosen, setting_fields(spec, chosen), speed_band(spec, chosen), "")
    for name, part in (("speed", "meets"), ("band", "window")):
        assert part not in {artist.get_gid() for artist in figures[name].findobj()}
