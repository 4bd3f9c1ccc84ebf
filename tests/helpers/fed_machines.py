"""Scene files of machines: the worked feeder, and one of each other kind."""

from __future__ import annotations

from pathlib import Path

SCENE = """
[scene]
frequency_hz = {frequency}
drive_angle_deg = {angle}
static_friction = {static}
kinetic_friction = {kinetic}
"""

FINE = {"frequency": 50, "angle": 20, "static": 0.35, "kinetic": 0.28}
COARSE = {"frequency": 16, "angle": 30, "static": 0.5, "kinetic": 0.4}

MAGNET = """
[machine]
kind = "magnet"
trough_mass_kg = 6
counter_mass_kg = 12
natural_hz = {natural!r}
damping_ratio = 0.015
calibration = {{ amplitude_mm = 0.35, frequency_hz = 50 }}
"""

UNBALANCE = """
[machine]
kind = "unbalance"
vibrating_mass_kg = 120
static_moment_kg_mm = 150
motors = 2
filling_kg = 20
"""

CRANK = """
[machine]
kind = "crank"
crank_radius_mm = 1.5
filling_kg = 20
"""

EXCITER = """
[machine]
kind = "exciter"
trough_mass_kg = 40
counter_mass_kg = 60
natural_hz = 18
damping_ratio = 0.03
static_moment_kg_mm = 20
motors = 2
filling_kg = "5:10"
"""

ROD = """
[machine]
kind = "rod"
trough_mass_kg = 40
crank_radius_mm = 5
rod_stiffness_n_m = 20000
natural_hz = 18
damping_ratio = 0.03
filling_kg = 5
"""

OTHERS = {"unbalance": UNBALANCE, "crank": CRANK, "exciter": EXCITER, "rod": ROD}


def feeder(ratio: float = 1.05, more: str = "") -> str:
    """Write the worked feeder of docs/theory, driven at so many times its natural frequency."""
    return SCENE.format(**FINE) + MAGNET.format(natural=50.0 / ratio) + more


def other(kind: str) -> str:
    """Write a machine of another kind."""
    return SCENE.format(**COARSE) + OTHERS[kind]


def written(folder: Path, text: str, name: str = "feeder") -> Path:
    """Write a scene file."""
    path = folder / f"{name}.toml"
    path.write_text(text, encoding="utf-8")
    return path
