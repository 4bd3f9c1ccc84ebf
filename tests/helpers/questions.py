"""A good question of inverse design, and others made of it."""

from __future__ import annotations

import copy
import math
import tomllib
from typing import Any

from vibro import Regime
from vibro.designs.questions import Question
from vibro.designs.reading import read_spec
from vibro.designs.spaces import SPACES
from vibro.drives import Ellipse, Line
from vibro.quantities import QUANTITIES
from vibro.results.designs import Design, DesignResult

FEEDER = """
[scene]
static_friction = "0.3:0.5"
friction_ratio = "0.7:0.9"
trough_angle_deg = 3
trough_length_mm = 1200
[[drive]]
name = "magnet"
amplitude_mm = 0.8
frequency_hz = "50, 100"
drive_angle_deg = "10:40"
acceleration_g = 4
[[drive]]
stroke_mm = "1:6"
frequency_hz = "900rpm:25"
drive_angle_deg = [20, 30.5]
[drift]
amplitude_percent = 5
frequency_percent = "1%"
drive_angle_deg = 1
trough_angle_deg = 0.5
[goal]
speed_mm_s = 80
highest_regime = "forward-slip"
impact_speed_mm_s = 100
flight_fraction = 0.4
[part]
half_base_mm = 6
centre_height_mm = 8
"""

GOOD: dict[str, Any] = {
    "scene": {"static_friction": "0.3:0.5", "friction_ratio": "0.7:0.9"},
    "drive": [{"amplitude_mm": 0.8, "frequency_hz": 50, "drive_angle_deg": "10:40"}],
    "goal": {"speed_mm_s": 80},
}

# Every table and key, with the ways to give the same that the feeder's question does not use.
PLACES = [
    *((table, key) for table, given in tomllib.loads(FEEDER).items() if table != "drive" for key in given),
    *(("drive", key) for key in {**tomllib.loads(FEEDER)["drive"][0], "stroke_mm": 1}),
    *(("drive", key) for key in ("along_amplitude_mm", "normal_amplitude_mm", "normal_phase_deg")),
    ("drift", "normal_phase_deg"),
    *(("scene", key) for key in ("kinetic_friction", "gravity_m_s2", "restitution")),
    ("goal", "traverse_time_s"),
]


def changed(**entries: Any) -> dict[str, Any]:
    """Change a good question: ``goal__speed_mm_s=0``; None leaves a key out."""
    content = copy.deepcopy(GOOD)
    for place, value in entries.items():
        table, _, key = place.partition("__")
        if not key:
            content[table] = value
            continue
        entry = content["drive"][0] if table == "drive" else content.setdefault(table, {})
        entry[key] = value
        if value is None:
            del entry[key]
    return content


def answered(met: bool, *designs: Design) -> DesignResult:
    """Make an answer of designs that a test wrote by hand, with their settings in SI units."""
    settings = []
    for design in designs:
        space = SPACES[Line if design.drive_angle_deg is not None else Ellipse]
        values = {knob: getattr(design, QUANTITIES[knob].column) for knob in space.knobs}
        if design.stroke_mm is not None:
            values["amplitude"] = design.stroke_mm / 2.0
        known = {knob: QUANTITIES[knob].to_si(x) for knob, x in values.items() if x is not None}
        settings.append(space.setting(**known) if known.keys() == values.keys() else None)
    return DesignResult(met, designs, tuple(settings))


def asked(question: dict[str, Any], highest: Regime = Regime.BACK_SLIP) -> Question:
    """Return what is asked of the first drive."""
    spec = read_spec(question)
    return Question(spec, spec.drives[0], highest)


def one_drive(
    scene: dict[str, Any], drive: dict[str, Any], speed: float = 1.0, **more: Any
) -> dict[str, Any]:
    """Ask for a speed of one drive, or machine."""
    return {"scene": scene, "drive": [drive], "goal": {"speed_mm_s": speed}, **more}


UNIT = 9.81 / (2.0 * math.pi * 25.0) ** 2
"""[m] Of amplitudes at 25 Hz, as in the question below: g/w^2."""

LOOSE = one_drive(
    {"static_friction": "0.35:0.45", "friction_ratio": "0.85:0.95"},
    {
        "along_amplitude_mm": "0.1:1",
        "normal_amplitude_mm": "0.05:0.5",
        "normal_phase_deg": "-180:180",
        "frequency_hz": 25,
        "acceleration_g": 1.5,
    },
    speed=20.0,
    drift={"amplitude_percent": 2, "normal_phase_deg": 3},
)
