"""Reference tables of tests/data (its README says how they were made): rows, scenes, solved scenes."""

from __future__ import annotations

import csv
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from vibro import Scene, SteadyCycle, solve

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Floats = NDArray[np.float64]

DATA = Path(__file__).parents[1] / "data"
LINES = {
    "contact_regular": 160,
    "contact_extreme": 160,
    "contact_incline": 100,
    "contact_steep": 50,
    "contact_descent": 50,
}
CONTACT = {**LINES, "elliptic_contact": 150, "harmonic_contact": 60}
"""Tables of bodies in contact, with their rows."""
HOPPING = {"hopping": 47, "elliptic_hopping": 30}
"""Those of bodies that hop."""

# The impact speed of this row of elliptic_hopping is that of a landing before the motion settled. Each flight
# takes one turn, and the impact what gravity gave in it: g cos(beta)/f.
UNSETTLED_IMPACT = 19

# The tables of lines print the smallest rotation of a pattern in ASCII order.
_LINE_PATTERN = {"B_F_": "F_B_", "B_F": "FB_", "BF_": "F_B", "BF": "FB"}
_TEXTS = {"kind", "regime", "pattern", "other_rest_start"}
_FRICTIONS = ("static_friction", "kinetic_friction")


def read_rows(name: str) -> list[dict[str, str]]:
    """Read a table: rows of texts."""
    folder = DATA if (DATA / f"{name}.csv").exists() else DATA / "two_axis"
    with (folder / f"{name}.csv").open(encoding="utf-8", newline="") as file:
        return list(csv.DictReader(file))


def columns_of(rows: list[dict[str, str]]) -> dict[str, Any]:
    """Return columns: texts as lists, numbers as arrays, in the units of the table."""
    return {
        name: [row[name] for row in rows]
        if name in _TEXTS
        else np.array([float(row[name] or "nan") for row in rows])
        for name in rows[0]
    }


def scene_of(columns: dict[str, Any]) -> Scene:
    """Return the scenes of columns, or of one row of numbers."""
    rest = {name: columns[name] for name in ("frequency_hz", *_FRICTIONS)}
    rest["frequency"] = rest.pop("frequency_hz")
    if "x1_amplitude_m" in columns:
        harmonics: Any = {
            f"{motion}_harmonics": [
                (columns[f"{axis}{n}_amplitude_m"], columns[f"{axis}{n}_phase_rad"]) for n in (1, 2)
            ]
            for axis, motion in (("x", "along"), ("y", "normal"))
        }
        return Scene(**harmonics, trough_angle=columns["trough_angle_rad"], **rest)
    if "x_amplitude_m" in columns:
        return Scene(
            along_amplitude=columns["x_amplitude_m"],
            normal_amplitude=columns["y_amplitude_m"],
            normal_phase=columns["phase_rad"],
            trough_angle=columns["trough_angle_rad"],
            **rest,
        )
    return Scene(
        amplitude=columns["amplitude_mm"] / 1000.0,
        drive_angle=np.radians(columns["drive_angle_deg"]),
        trough_angle=np.radians(columns.get("trough_angle_deg", 0.0)),
        **rest,
    )


class Table(NamedTuple):
    """A table, and what the package says of its scenes."""

    name: str
    columns: dict[str, Any]
    scene: Scene
    cycle: SteadyCycle

    @property
    def pattern(self) -> list[str]:
        """Patterns as the package writes them; empty where no motion repeats."""
        patterns: list[str] = self.columns["pattern"]
        if self.name in LINES:
            patterns = [_LINE_PATTERN.get(text, text) for text in patterns]
        return ["" if text == "runaway" else text for text in patterns]

    @property
    def both_ways(self) -> NDArray[np.bool_]:
        """Whether bodies slide both ways."""
        return np.array([set(text) >= set("FB") for text in self.pattern])

    @property
    def metre(self) -> float:
        """How many of the table's units of length a metre has."""
        return 1000.0 if "amplitude_mm" in self.columns else 1.0

    @property
    def displacement(self) -> Floats:
        """Displacements a drive cycle [the table's unit]."""
        unit = "m" if self.metre == 1.0 else "mm"
        return np.asarray(self.columns[f"displacement_per_cycle_{unit}"])

    @property
    def mean_velocity(self) -> Floats:
        """Mean speeds [the table's unit]."""
        unit = "m" if self.metre == 1.0 else "mm"
        return np.asarray(self.columns[f"mean_velocity_{unit}_s"])

    @property
    def amplitude(self) -> Floats:
        """Amplitudes, of several the largest [the table's unit]."""
        names = [name for name in self.columns if "amplitude" in name]
        return np.asarray(np.max([self.columns[name] for name in names], axis=0))

    @property
    def size(self) -> Floats:
        """Displacements, and the amplitudes where bodies slide both ways [the table's unit]."""
        return np.where(self.both_ways, self.amplitude, np.abs(self.displacement))


def read_table(name: str) -> Table:
    """Read a table, and solve its scenes."""
    rows = read_rows(name)
    assert len(rows) == (CONTACT | HOPPING)[name]
    columns = columns_of(rows)
    scene = scene_of(columns)
    return Table(name, columns, scene, solve(scene))
