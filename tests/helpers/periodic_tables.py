"""Reference tables of drives with harmonics (tests/data/periodic): rows, their scenes, their patterns."""

from __future__ import annotations

import csv
import json
import re
from pathlib import Path
from typing import Any

from vibro import Scene

PERIODIC = Path(__file__).parents[1] / "data" / "periodic"
ROWS = {
    "steady_plastic": 60,
    "steady_bouncing": 40,
    "histories": 40,
    "critical_scales": 60,
    "arrival_times": 20,
    "counterexamples": 29,
}
_ORDER = str.maketrans("HFB_", "0123")


def read_rows(name: str) -> list[dict[str, str]]:
    """Read a table: rows of texts."""
    with (PERIODIC / f"{name}.csv").open(encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == ROWS[name]
    return rows


def harmonics_of(row: dict[str, str], motion: str) -> list[tuple[float, float]]:
    """List the pairs of amplitude [m] and phase [rad] of one motion of the trough."""
    return [(size, phase) for size, phase in json.loads(row[f"{motion}_harmonics_m_rad"])]


def scene_of(row: dict[str, str], *, scale: float = 1.0, start: float = 0.0, **others: Any) -> Scene:
    """Return the scene of a row, all amplitudes times a factor, begun at a phase [rad]."""
    motions: dict[str, Any] = {
        f"{motion}_harmonics": [
            (size * scale, phase + k * start) for k, (size, phase) in enumerate(harmonics_of(row, motion), 1)
        ]
        for motion in ("along", "normal")
    }
    values = {
        "frequency": float(row["frequency_hz"]),
        "static_friction": float(row["static_friction"]),
        "kinetic_friction": float(row["kinetic_friction"]),
        "trough_angle": float(row["trough_angle_rad"]),
        "restitution": float(row["restitution"]),
    }
    return Scene(**motions, **(values | others))


def size_of(row: dict[str, str]) -> float:
    """Return the largest amplitude [m]."""
    return max(size for motion in ("along", "normal") for size, _ in harmonics_of(row, motion))


def least_rotation(pattern: str) -> str:
    """Turn a cycle so that it comes first in the order H F B _, consecutive flights as one."""
    if set(pattern) == {"H"}:
        return "H"
    turned = min((pattern[i:] + pattern[:i] for i in range(len(pattern))), key=lambda x: x.translate(_ORDER))
    turned = re.sub("H+", "H", turned)
    return turned[:-1] if turned[0] == turned[-1] == "H" else turned
