"""What the sessions of tests/messages call: short records and questions, read as users' are."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import pytest
from helpers.machine_files import SCENE
from helpers.questions import changed

import vibro
from vibro.designs.reading import read_spec
from vibro.files.points import read_points
from vibro.records.alignment import Observation
from vibro.records.fitting import fit
from vibro.records.problem import FITTABLE
from vibro.records.reading import Record, read_record, read_sensitivities
from vibro.sweeps.whole import Sweep


def record(*rows: str | bytes, sensitivity: str | list[str] = "", **columns: str) -> Record:
    """Read a table of these rows, or of these bytes."""
    data = b"".join(row if isinstance(row, bytes) else f"{row}\n".encode() for row in rows)
    Path("data.csv").write_bytes(data)
    texts = [sensitivity] if isinstance(sensitivity, str) else sensitivity
    return read_record(Path("data.csv"), columns, read_sensitivities([text for text in texts if text]))


def table(
    count: int, cells: Mapping[int, str] | None = None, times: Mapping[int, float] | None = None
) -> list[str]:
    """Write a table whose rows of data are numbered from 2, with other cells or times in some of them."""
    clock = {row: (row - 2) / 600.0 for row in range(2, count + 2)} | dict(times or {})
    return ["t [s],x [mm]", *(f"{clock[row]:.6f},{(cells or {}).get(row, row)}" for row in clock)]


def volts(*sensitivities: str, **columns: str) -> Record:
    """Read a table with a voltage."""
    rows = ("t [s],x [mm],u [mV]", "0,1,100", "1,2,200", "2,3,300")
    return record(*rows, sensitivity=[*sensitivities], **columns)


_FRICTION = {"static_friction": 0.74, "kinetic_friction": 0.57}
BOWL = vibro.Scene(
    along_amplitude=3e-3, normal_amplitude=1e-3, normal_phase=-1.0, frequency=25.0, static_friction=0.4,
    kinetic_friction=0.3,
)  # fmt: skip


def question(**entries: Any) -> None:
    """Read a good question with other entries."""
    read_spec(changed(**entries))


def swept(**given: Any) -> Sweep:
    """Sweep the published example with other quantities."""
    nut = {"amplitude_mm": 1, "frequency_hz": 15, "drive_angle_deg": 20, "static_friction": 0.74}
    ratio = {} if "kinetic_friction" in given else {"friction_ratio": 0.77}
    return vibro.sweep(**nut | ratio | given, output="regimes")


def line(**fields: Any) -> vibro.Scene:
    """Make the published example with other fields."""
    return vibro.Scene(**{"amplitude": 1e-3, "frequency": 15, "drive_angle": 0.35, **_FRICTION, **fields})


def oval(**fields: Any) -> vibro.Scene:
    """Make a scene on an ellipse with other fields."""
    drive = {"along_amplitude": 1e-3, "normal_amplitude": 3e-4, "normal_phase": -1.0, "frequency": 15}
    return vibro.Scene(**drive | _FRICTION | fields)


def machine(kind: str, **changed: Any) -> vibro.Machine:
    """Make a machine of a kind with other fields."""
    two = {"trough_mass": 6.0, "counter_mass": 12.0, "damping_ratio": 0.015, "natural_frequency": 50.0}
    rod = {"radius": 0.01, "rod_stiffness": 3e4, "trough_mass": 10.0, "damping_ratio": 0.02}
    good = {
        "magnet": {**two, "force": 1.0},
        "exciter": {**two, "static_moment": 0.1},
        "unbalance": {"vibrating_mass": 300.0, "static_moment": 0.9},
        "crank": {"radius": 0.01},
        "rod": {**rod, "natural_frequency": 10.0},
    }[kind]
    made: vibro.Machine = getattr(vibro.Machine, kind)(**{**good, **changed})
    return made


def scene_file(text: str, **given: Any) -> Sweep:
    """Sweep what a scene file with a text says."""
    Path("scene.toml").write_text(text, encoding="utf-8")
    return vibro.sweep("scene.toml", **given, output="regimes")


def machine_file(text: str, **given: Any) -> Sweep:
    """Sweep what a scene file with a machine says, which follows the table of the scene."""
    return scene_file(SCENE + text, **given)


def points(text: str) -> Any:
    """Read a file of measured amplitudes."""
    Path("points.csv").write_text(text, encoding="utf-8")
    return read_points(Path("points.csv"))


def estimates(scene: vibro.Scene, seen: Observation, names: Sequence[str]) -> None:
    """Print which quantities a fit from the scene's own values identifies, and what is said of them."""
    with pytest.MonkeyPatch.context() as patch:  # searches from other values take most of the time
        patch.setattr("vibro.records.problem._GRID", dict.fromkeys(FITTABLE, ()))
        found = fit(scene, seen, names)
    print("identified:", *(p.name for p in found.parameters if p.identified))
    print(*found.statements, sep="\n")
