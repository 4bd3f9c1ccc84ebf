"""Scene files with machines: the worked feeder of the theory, and one machine of every kind."""

from __future__ import annotations

from pathlib import Path

SCENE = """
[scene]
frequency_hz = 50
drive_angle_deg = 20
static_friction = 0.35
kinetic_friction = 0.28
"""
FEEDER = """
[machine]
kind = "magnet"
trough_mass_kg = 6
counter_mass_kg = 12
natural_hz = 55.6
damping_ratio = 0.015
calibration = { amplitude_mm = 0.35, frequency_hz = 50, setting_percent = 100 }
"""
UNBALANCE = """
[machine]
kind = "unbalance"
vibrating_mass_kg = 120
motors = 2
static_moment_kg_mm = 95
"""
POINTS = [[f, round(200.0 / abs(55.0**2 - f**2 + 1.65j * f), 5)] for f in (48.0, 51.0, 54.0, 56.0, 59.0)]
"""Of a machine with f0 = 55 Hz and zeta = 0.015, in Hz and mm."""
KINDS = {
    "unbalance": UNBALANCE,
    "magnet": FEEDER,
    "exciter": """
[machine]
kind = "exciter"
trough_mass_kg = 60
counter_mass_kg = 120
natural_hz = 55.6
damping_ratio = 0.03
motors = 1
static_moment_kg_mm = 10
""",
    "crank": '[machine]\nkind = "crank"\ncrank_radius_mm = 0.3\n',
    "rod": """
[machine]
kind = "rod"
trough_mass_kg = 200
crank_radius_mm = 1
rod_stiffness_n_m = 1000000
natural_hz = 55.6
damping_ratio = 0.03
""",
    "measured": f"""
[machine]
kind = "measured"
points = {POINTS}
trough_mass_kg = 6
counter_mass_kg = "floor"
law = "constant"
""",
}


def written(folder: Path, text: str, name: str = "feeder.toml") -> Path:
    """Write a file."""
    path = folder / name
    path.write_text(text, encoding="utf-8")
    return path


def feeder(folder: Path, more: str = "", scene: str = SCENE, table: str = FEEDER) -> Path:
    """Write the worked feeder, with more lines of its machine."""
    return written(folder, f"{scene}{table}{more}")
