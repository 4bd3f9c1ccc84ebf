"""Controls of the page: quantities with the ranges of their sliders, drives, views, presets."""

from __future__ import annotations

import math
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, Final, NamedTuple

from vibro.quantities import LINEAR, MACHINE, QUANTITIES, RATES, SCALE, SWEPT

if TYPE_CHECKING:
    from collections.abc import Collection, Mapping

    from vibro.files.machines import GivenMachine


class Control(NamedTuple):
    """A slider: its ends, its step, and the default range of a map's axis, in the unit outside."""

    low: float
    high: float
    step: float
    axis: str = ""


class Drive(NamedTuple):
    """A kind of drive: the quantities that describe it, the default axes of its map, sliders of its own."""

    label: str
    quantities: tuple[str, ...]
    x: str
    y: str
    controls: Mapping[str, Control] = MappingProxyType({})

    def data(self) -> dict[str, Any]:
        """Return what the page's script has to know of it, as JSON values; sliders stand with their scene."""
        return {"label": self.label, "quantities": self.quantities, "x": self.x, "y": self.y}


class Preset(NamedTuple):
    """Common drives, and the values that they set."""

    label: str
    state: dict[str, str]


_ELLIPSE: Final = ("along_amplitude", "normal_amplitude", "normal_phase")
_NORMAL: Final = ("normal_amplitude", "normal_phase", "normal_amplitude_2", "normal_phase_2")
_SECOND: Final = ("along_amplitude_2", "along_phase_2", "normal_amplitude_2", "normal_phase_2")

#: By name.
DRIVES: Final = {
    "line": Drive("along a line", LINEAR, "frequency", "amplitude"),
    "ellipse": Drive("along an ellipse", _ELLIPSE, "normal_phase", "along_amplitude"),
    "harmonics": Drive("with a second harmonic", (*_ELLIPSE, *_SECOND), "along_phase_2", "along_amplitude_2"),
}

#: Name of a further drive: that of a scene which none of these can hold (``given_drive``).
GIVEN: Final = "given"
#: Name of a further drive: the machine of a scene, from which the amplitude follows (``machine_drive``).
DRIVEN: Final = "machine"

#: Sliders by quantity, in the order of the page.
CONTROLS: Final = {
    "setting": Control(1.0, 100.0, 0.5, "10:100"),
    "voltage": Control(70.0, 120.0, 0.5, "80:110"),
    "filling": Control(0.0, 10.0, 0.01, "0:5"),
    "natural": Control(1.0, 120.0, 0.1, "5:100"),
    "amplitude": Control(0.01, 5.0, 0.005, "0.1:3"),
    "along_amplitude": Control(0.0, 5.0, 0.01, "0.1:3"),
    "normal_amplitude": Control(0.0, 2.0, 0.005, "0:1"),
    "frequency": Control(1.0, 120.0, 0.1, "5:60"),
    "drive_angle": Control(0.0, 89.0, 0.1, "0:80"),
    "normal_phase": Control(-180.0, 180.0, 1.0, "-180:180"),
    "along_amplitude_2": Control(0.0, 2.0, 0.005, "0:1"),
    "along_phase_2": Control(-180.0, 180.0, 1.0, "-180:180"),
    "normal_amplitude_2": Control(0.0, 2.0, 0.005, "0:0.5"),
    "normal_phase_2": Control(-180.0, 180.0, 1.0, "-180:180"),
    "motion_scale": Control(0.05, 3.0, 0.01, "0.2:3"),
    "normal_acceleration": Control(0.5, 100.0, 0.1, "1:50"),
    "static_friction": Control(0.01, 1.5, 0.005, "0.1:1.2"),
    "friction_ratio": Control(0.0, 1.0, 0.005, "0.3:1"),
    "kinetic_friction": Control(0.0, 1.5, 0.005, "0.1:1.2"),
    "trough_angle": Control(-20.0, 20.0, 0.1, "-10:15"),
    "restitution": Control(0.0, 0.95, 0.01, "0:0.9"),
    "trough_length": Control(50.0, 5000.0, 10.0),
    "gravity": Control(1.0, 20.0, 0.01),
}
assert set(SWEPT) - RATES.keys() <= set(CONTROLS) <= set(QUANTITIES)

#: Quantities that may be given as bands.
BANDS: Final = ("static_friction", "kinetic_friction", "friction_ratio", "restitution")

VIEWS: Final = {
    "regime": "regimes",
    "speed": "mean conveying speed",
    "traverse": "traverse time",
    "impact": "impact speed",
    "flight": "share of time in flight",
}

_MAP: Final = {"drive": "line", "trough_angle_deg": "0", "x": "frequency_hz", "y": "amplitude_mm"}
# A magnet on mains of 50 Hz pulls at every half-wave, behind a diode at every second one; motors with 4 and 6
# poles turn 1500 and 1000 times a minute. Amplitudes are of the size that such drives have
# (docs/guide/makers.md, examples/bowl_feeder.toml).
# fmt: off
PRESETS: Final = {
    "bowl-50": Preset("bowl feeder, 50 Hz", {
        "drive": "ellipse", "along_amplitude_mm": "0.2", "normal_amplitude_mm": "0.08",
        "normal_phase_deg": "0", "frequency_hz": "50", "trough_angle_deg": "2",
        "x": "normal_phase_deg", "y": "along_amplitude_mm", "x_range": "-180:180", "y_range": "0.02:0.5",
    }),
    "magnet-50": Preset("magnet, 50 Hz", {
        **_MAP, "amplitude_mm": "0.5", "frequency_hz": "50", "drive_angle_deg": "25",
        "x_range": "20:80", "y_range": "0.05:1.5",
    }),
    "magnet-100": Preset("magnet, 100 Hz", {
        **_MAP, "amplitude_mm": "0.15", "frequency_hz": "100", "drive_angle_deg": "20",
        "x_range": "50:150", "y_range": "0.01:0.5",
    }),
    "motor-25": Preset("unbalance motor, 1500 rpm", {
        **_MAP, "amplitude_mm": "2", "frequency_hz": "25", "drive_angle_deg": "30",
        "x_range": "8:50", "y_range": "0.2:5",
    }),
    "motor-16": Preset("unbalance motor, 1000 rpm", {
        **_MAP, "amplitude_mm": "4", "frequency_hz": "16.6667", "drive_angle_deg": "30",
        "x_range": "5:40", "y_range": "0.2:8",
    }),
}
# fmt: on


def drive_named(quantities: Collection[str]) -> str:
    """Name the drive that has these quantities; empty if the page has no such drive."""
    for name, drive in DRIVES.items():
        if set(quantities) <= set(drive.quantities):
            return name
    return ""


def given_drive(quantities: Collection[str], varying: Collection[str]) -> Drive:
    """Return the drive of a scene with these quantities, some of which vary.

    It stays as it is given, up to a scale, where it has no sliders: steps and samples, harmonics above the
    second, the first harmonic's phase along the trough. Under a clamped part the trough does not move normal
    to itself.
    """
    moved = {*quantities, SCALE}
    if "normal_acceleration" in quantities:
        moved -= {*_NORMAL} - {*varying}
    return Drive(
        "as the scene gives it", tuple(name for name in CONTROLS if name in moved), "frequency", SCALE
    )


def machine_drive(machine: GivenMachine, values: Mapping[str, float]) -> Drive:
    """Return the drive of a machine.

    Parameters
    ----------
    machine : GivenMachine
        Of a scene.
    values : mapping of str to float
        Quantities of the scene in the units outside; sliders and axes reach to both sides of them.
    """
    tuned = [values[name] for name in ("frequency", "natural") if name in values]
    around = _control(0.5 * min(tuned), 1.5 * max(tuned), 0.1)
    controls = {"frequency": around, "natural": around}
    most = max(machine.machine.trough_mass, *machine.bands.get("filling", (0.0, 0.0)))
    if math.isfinite(most):
        controls["filling"] = _control(0.0, most, 0.001 * most)
    knobs = [name for name in MACHINE if machine.takes(name)]
    quantities = tuple(name for name in CONTROLS if name in (*knobs, "drive_angle"))
    return Drive("by the scene's machine", quantities, "frequency", "filling", controls)


def _control(low: float, high: float, step: float) -> Control:
    """Return a slider with round numbers, and an axis of the same ends."""
    low, high = (float(f"{end:.3g}") for end in (low, high))
    return Control(low, high, float(f"{step:.1g}"), f"{low:g}:{high:g}")
