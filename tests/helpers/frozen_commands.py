"""What the frozen answers ask of designs and of the command line."""

from __future__ import annotations

import json
import math
import shlex
from contextlib import chdir
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Any, Final
from unittest import mock

import numpy as np
from helpers.frozen_questions import Draws
from typer.testing import CliRunner

import vibro
from vibro.cli.app import app

if TYPE_CHECKING:
    from collections.abc import Callable


_NUT: Final = "-f 15 -a 20 --mu-s .74 --mu-d .57"
_BOWL: Final = "along=1 phase=-60 -f 25 --mu-s .4 --mu-d .3 normal"
_TWO: Final = "along=2 along_2=.4 along_phase_2=90 -f 10 --mu-s .4 --mu-d .3 normal"
_SIDES: Final = "--trough-along along --trough-normal normal"

#: Commands whose answers are kept as JSON, or as the rows of a table where they write to stdout.
COMMANDS: Final = f"""
solve -A .5 {_NUT}
solve -A 1 {_NUT} -L 600 --pitch 30 --mass .01
solve -A 1.25 {_NUT} --trough-angle 3 --stand-ratio .8
solve -A 2 {_NUT}
solve -A 4 {_NUT} -L 600
solve -A 4 {_NUT}
solve -A 4 {_NUT} --restitution .3
solve -A 1 {_NUT} --regimes-only
solve -A 1 -f 15 -a 20 --mu-s .2 --mu-ratio .5 --trough-angle=-15
solve --stroke 2 -f 900rpm -a 20 --mu-s .74 --mu-ratio .8
solve {_BOWL}=.3 -L 400
solve {_BOWL}=1
solve {_TWO}=.5 -L 400
solve {_TWO}=4 --restitution .2
solve steps.toml
solve samples.toml -L 500
solve clamped.toml
solve feeder.toml
solve feeder.toml filling=1.5
solve {_NUT} --speed 30
solve {_NUT} --speed 40 --hopping
solve {_BOWL}=.3 --speed 20
solve {_TWO}=.5 --speed 20
traverse-time -A 1 {_NUT} -L 600
traverse-time -A 4 {_NUT} -L 600 --restitution .2
traverse-time {_BOWL}=.3 -L 300 --exact
traverse-time samples.toml -L 300
simulate -A 1 {_NUT}
simulate -A 2 {_NUT} --cycles 2 start_phase=30 start_velocity=50
simulate -A 5 {_NUT} --duration .2 start_height=2
simulate {_BOWL}=.3 --cycles 2
simulate steps.toml
drive feeder.toml
drive feeder.toml filling=0:2 voltage=95:105
friction
design line.toml
friction 'steel on steel'
map -A .5:4:4 {_NUT} -L 600 --force
map {_BOWL}=.2:1.4:4 --restitution .2 --force
compare slide.csv -A 1 {_NUT} --fit mu_s,mu_d
motion trough.csv {_SIDES}
motion trough.csv --trough-along along -a 20 --mu-s .74 --mu-d .57
motion trough.csv --trough-normal normal -a 20
drive feeder.toml --fit points.csv
drive --fit points.csv --law square
map -A .5:4:8 -f 10:20:6 -a 20 --mu-s .74 --mu-d .57 -L 600 -o -
map -A .5:4:8 -f 10:20:6 -a 20 --mu-s .74 --mu-d .57 --decimal-comma -o -
map along=1 phase=-90:90:7 -f 25 --mu-s .4 --mu-d .3 normal=.2:1.4:7 -o -
map {_TWO}=.5 motion_scale=.5:2:30 -o -
map samples.toml motion_scale=.5:2:30 -o -
map feeder.toml filling=0:2:5 voltage=90:110:5 -o -
map -A 3:9:40 {_NUT} --restitution .5 --columns amplitude_mm,mean_velocity_mm_s,pattern,status -o -
traverse-time -A .5:4:40 {_NUT} -L 600 --exact -o -
simulate -A 2 {_NUT} --cycles 12 -o -
simulate -A 5 {_NUT} --cycles 4 --restitution .4 --decimal-comma -o -
compare slide.csv -A 1 {_NUT} -o -
drive feeder.toml --decimal-comma -o -
""".strip().splitlines()


def _slide(count: int) -> str:
    """Write a record of parts that slide forward once in a cycle, by the closed form of their speed."""
    pull, drag, start = 9.4, 5.6, 0.8  # [m/s^2], [m/s^2], [rad]
    rows, w = ["time [s],displacement [mm],velocity [mm/s]"], 2.0 * math.pi * 15.0
    phases = np.linspace(start, 2.0 * math.pi, 20_001)
    speeds = (pull * (np.cos(start) - np.cos(phases)) - drag * (phases - start)) / w * 1e3
    ends = 1 + int(np.argmax(speeds[1:] < 0.0))
    speeds[ends:] = 0.0
    path = np.cumsum(speeds) * (phases[1] - phases[0]) / w
    for i in range(count):
        cycle, phase = divmod(w * i / 300.0 + 1.0, 2.0 * math.pi)
        values = (np.interp(phase, phases, x, left=0.0) for x in (path, speeds))
        position, velocity = values
        rows.append(f"{i / 300.0:.6f},{cycle * path[-1] + position:.5f},{velocity:.3f}")
    return "\n".join(rows) + "\n"


def _trough(count: int) -> str:
    """Write a record of two accelerometers on a trough with a second harmonic, and noise."""
    noise, rows = Draws("trough")(-0.05, 0.05, 2, count), ["time [s],along [m/s^2],normal [m/s^2]"]
    for i in range(count):
        phase = 2.0 * math.pi * 15.0 * i / 600.0 + 0.5
        along, second = -8.5 * math.sin(phase), 0.6 * math.sin(2.0 * phase + 1.0)
        rows.append(f"{i / 600.0:.6f},{along + second + noise[0, i]:.4f},{0.36 * along + noise[1, i]:.4f}")
    return "\n".join(rows) + "\n"


def files() -> dict[str, str]:
    """Return what the commands read, by the names of files."""
    scene = "[scene]\nfrequency_hz = 5\nstatic_friction = 0.4\nkinetic_friction = 0.3\n"
    moved = scene + "[motion]\n"
    row = [x / 4.0 * (1.0 - x / 8.0) * (x - 8.0) for x in range(16)]
    points = "40,.04 45,.1 47,.17 48,.24 49,.34 50,.38 51,.3 53,.16 56,.08 60,.05"
    return {
        "steps.toml": moved + "along_steps = [[0.8, 2.5], [0.2, -10.0]]\n",
        "samples.toml": moved + f"along_samples_m_s2 = {row}\n",
        "clamped.toml": scene + "normal_acceleration_m_s2 = 12\n"
        + "[motion]\nalong_steps = [[0.7, 4.5], [0.3, -10.5]]\n",
        "feeder.toml": scene.replace("= 5", "= 50") + "drive_angle_deg = 20\ntrough_length_mm = 400\n"
        + '[machine]\nkind = "magnet"\ntrough_mass_kg = 6\ncounter_mass_kg = 12\nnatural_hz = 55\n'
        + "damping_ratio = 0.015\ncalibration = { amplitude_mm = 0.3, frequency_hz = 50 }\n",
        "line.toml": '[scene]\nstatic_friction = "0.7:0.78"\nkinetic_friction = 0.55\n'
        + '[[drive]]\namplitude_mm = 3\nfrequency_hz = "10:30"\ndrive_angle_deg = 30\n'
        + '[goal]\nspeed_mm_s = 30\nhighest_regime = "forward-slip"\n',
        "slide.csv": _slide(61),
        "trough.csv": _trough(300),
        "points.csv": "frequency_hz,amplitude_mm\n" + points.replace(" ", "\n") + "\n",
    }  # fmt: skip


def asked(command: str) -> Any:
    """Run a command in this folder; return its JSON, or the first and last rows of its table."""
    is_table = command.endswith("-o -")
    with mock.patch("vibro.sweeps.solved.pictures_of", return_value=[]):
        result = CliRunner().invoke(app, shlex.split(command) + ([] if is_table else ["--json"]))
    assert result.exit_code in {0, 3}, (command, result.output)
    if not is_table:
        return json.loads(result.stdout)
    rows = result.stdout.splitlines()
    return [*rows[:21], *rows[max(21, len(rows) - 20) :]]


_PARTS: Final = {"static_friction": "0.7:0.78", "kinetic_friction": "0.5:0.6"}
_ONE: Final = {"static_friction": 0.4, "kinetic_friction": 0.3}
_MAGNET: Final = {
    "kind": "magnet", "trough_mass_kg": 6, "counter_mass_kg": 12, "damping_ratio": 0.015, "natural_hz": 55.6,
    "calibration": {"amplitude_mm": 0.35, "frequency_hz": 50}, "setting_percent": "20:100", "filling_kg": 1,
    "voltage_percent": "95:105", "frequency_hz": 50, "drive_angle_deg": 20,
}  # fmt: skip


def _designed(scene: Any, drive: Any, speed: float, **more: Any) -> Callable[[], Any]:
    spec = {"scene": scene, "drive": [drive], "goal": {"speed_mm_s": speed}} | more
    return lambda: vibro.design(spec, only="goal").to_dict()


def _scene(kind: str, amplitude: float) -> vibro.Scene:
    """Make the nut on its trough, a bowl feeder, or a trough with two harmonics."""
    if kind == "line":
        moved: dict[str, Any] = {"amplitude": amplitude, "drive_angle": 0.35}
        return vibro.Scene(**moved, frequency=15.0, static_friction=0.74, kinetic_friction=0.57)
    if kind == "ellipse":
        moved = {"along_amplitude": amplitude, "normal_amplitude": 0.3 * amplitude, "normal_phase": -1.05}
        return vibro.Scene(**moved, frequency=25.0, **_ONE)
    motion = vibro.Motion.harmonics(
        [(2.0 * amplitude, 0.0), (0.4 * amplitude, 1.5)], [(0.5 * amplitude, 0.0)]
    )
    return vibro.Scene(motion=motion, frequency=10.0, **_ONE)


#: Questions of inverse design, small ones.
_DESIGNS: Final[dict[str, Callable[[], Any]]] = {
    "stroke": _designed(_PARTS, {"stroke_mm": "1:6", "frequency_hz": 15, "drive_angle_deg": 20}, 20.0),
    "ellipse": _designed(
        _ONE,
        {
            "along_amplitude_mm": 0.4,
            "normal_amplitude_mm": 0.3,
            "normal_phase_deg": "-90:90",
            "frequency_hz": 20,
        },
        9.0,
    ),
    "motion": _designed(
        _ONE, {"along_steps": [[0.8, 1.5], [0.2, -6]], "motion_scale": "0.5:3", "frequency_hz": 2}, 60.0
    ),
    "machine": _designed({"static_friction": 0.35, "kinetic_friction": 0.28}, _MAGNET, 12.0),
    "guarantee, line": lambda: vibro.guarantee(
        _scene("line", 1.25e-3), static_friction=(0.7, 0.74), amplitude=(1.2e-3, 1.3e-3)
    ),
    "guarantee, hopping": lambda: vibro.guarantee(_scene("line", 4e-3), kinetic_friction=(0.5, 0.6)),
    "guarantee, ellipse": lambda: vibro.guarantee(_scene("ellipse", 1e-3), kinetic_friction=(0.28, 0.34)),
    "guarantee, harmonics": lambda: vibro.guarantee(_scene("harmonics", 1e-3), kinetic_friction=(0.25, 0.3)),
    "amplitudes, line": lambda: vibro.feasible_amplitudes(
        _scene("line", 1.0), 0.03, static_friction=(0.7, 0.78)
    ),
    "amplitudes, hopping": lambda: vibro.feasible_amplitudes(
        _scene("line", 1.0), 0.03, highest_regime="hopping", limit=6e-3
    ),
    "yield, line": lambda: vibro.yield_share(
        _scene("line", 1e-3), 0.016, highest_regime="forward-slip", static_friction=(0.7, 0.78)
    ),
    "yield, ellipse": lambda: vibro.yield_share(
        _scene("ellipse", 1e-3), 0.089, highest_regime="back-slip", kinetic_friction=(0.25, 0.35)
    ),
}


def _plain(value: Any) -> Any:
    """Turn an answer into what JSON holds; without certificates, whose boxes are no promise."""
    if isinstance(value, dict | vibro.Guarantee):
        items = value.items() if isinstance(value, dict) else vars(value).items()
        return {key: _plain(x) for key, x in items if "certificate" not in key}
    if isinstance(value, list | tuple):
        return [_plain(x) for x in value]
    return sorted(x.label for x in value) if isinstance(value, frozenset) else value


def answers_of_commands() -> dict[str, Any]:
    """Answer all commands, in a folder of their own."""
    with TemporaryDirectory() as folder, chdir(folder):
        for name, text in files().items():
            Path(name).write_text(text, encoding="utf-8")
        return {command: asked(command) for command in COMMANDS}


def answers_of_designs() -> dict[str, Any]:
    """Answer all questions of inverse design."""
    return {name: _plain(ask()) for name, ask in _DESIGNS.items()}
