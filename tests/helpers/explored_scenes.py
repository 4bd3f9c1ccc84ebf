"""Scene files of drives that the explorer's sliders cannot make."""

from __future__ import annotations

from helpers import machine_files
from helpers.machine_files import SCENE

_POINT = "static_friction = 0.4\nkinetic_friction = 0.3\nfrequency_hz = 8\n"
_WAVE = "along_amplitudes_mm = [1, 0.3, 0.1]\nalong_phases_deg = [15, -90, 20]\n"
#: Scene files of drives that the page shows as they are given.
GIVEN_DRIVES = {
    "third harmonic": f"[scene]\n{_POINT}{_WAVE}"
    "normal_amplitudes_mm = [0, 0.1, 0]\nnormal_phases_deg = [0, 7, 0]\n",
    "phase of the first": f"[scene]\n{_POINT}along_amplitudes_mm = [1]\nalong_phases_deg = [15]\n",
    "scaled ellipse": f"[scene]\n{_POINT}motion_scale = 2\n"
    "along_amplitude_mm = 1\nnormal_amplitude_mm = 0.1\n",
    "clamped": f"[scene]\n{_POINT}{_WAVE}normal_acceleration_m_s2 = 20\ntrough_angle_deg = 90\n",
    "clamped, one harmonic": f"[scene]\n{_POINT}along_amplitude_mm = 9\nnormal_amplitude_mm = 0\n"
    "normal_force_n = 3\nmass_kg = 0.1\n",
    "steps, clamped": f"[scene]\n{_POINT}normal_acceleration_m_s2 = 5\nmotion_scale = 1.5\n"
    "[motion]\nalong_steps = [[0.8, 2.4], [0.2, -9.6]]\n",
    "samples": f"[scene]\n{_POINT}[motion]\nalong_samples_m_s2 = [0, 3, 4, 3, 0, -3, -4, -3]\n",
    "displacements": f"[scene]\n{_POINT}[motion]\nnormal_samples_mm = [0, 0, 0, 0, 0, 0, 0, 0]\n"
    "along_samples_mm = [0, 3, 4, 3, 0, -3, -4, -3]\n",
}

#: Scene file of a magnetic feeder with two kilogrammes in its trough.
FEEDER = f"""{SCENE}trough_length_mm = 800
{machine_files.FEEDER}voltage_percent = "90:110"
filling_kg = 2
pack = [{{ name = "6 leaves", natural_hz = 55.6 }}, {{ name = "4 & a half", natural_hz = 47.6 }}]
"""
