"""A comparison in the user's units: tables of signals and figures, and a record for JSON."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, Final

import numpy as np

from vibro.files.csv_tables import TableColumns
from vibro.quantities import QUANTITIES
from vibro.records.comparison import Comparison
from vibro.records.fitting import Fit, Parameter
from vibro.records.reading import Record
from vibro.records.trough import MeasuredDrive
from vibro.records.waveforms import HarmonicDrive

__all__ = ["ComparisonTables"]

# kind of a quantity -> unit in tables, its size in SI units; friction is per unit mass without a mass.
_UNITS: Final = {
    "displacement": ("mm", 1e-3),
    "velocity": ("mm/s", 1e-3),
    "time": ("ms", 1e-3),
    "acceleration": ("m/s^2", 1.0),
    "friction": ("m/s^2", 1.0),
}
_FIGURES: Final = ("measured", "standard_error", "computed")


@dataclass(frozen=True, eq=False)
class ComparisonTables:
    """Measured and computed signals and figures, in the user's units.

    Attributes
    ----------
    comparison : Comparison
        The record beside the model.
    record : Record
        The record as it was read.
    mass : float or None
        Mass of the body [kg]; without it friction is per unit mass.
    fit : Fit or None
        Estimates from the record.
    drive : MeasuredDrive, HarmonicDrive or None
        Quantities of the drive, if accelerations of the trough were measured.
    """

    comparison: Comparison
    record: Record
    mass: float | None = None
    fit: Fit | None = None
    drive: MeasuredDrive | HarmonicDrive | None = None

    @property
    def units(self) -> dict[str, tuple[str, float]]:
        """Unit of each kind of figure, and its size in SI units."""
        return _UNITS | ({} if self.mass is None else {"friction": ("N", 1.0 / self.mass)})

    def parameters(self) -> list[tuple[Parameter, tuple[str, float]]]:
        """Return the estimates, each with its unit and the size of that in SI units."""
        found = [(p, QUANTITIES[p.name]) for p in (self.fit.parameters if self.fit else ())]
        return [(p, (quantity.unit, float(quantity.to_si(1.0)))) for p, quantity in found]

    def signals(self) -> TableColumns:
        """Return measured and computed signals over time, relative to the trough."""
        comparison, observation = self.comparison, self.comparison.observation
        trough_time = comparison.trough_time % comparison.motion.period
        columns: dict[str, Any] = {"time_s": observation.time, "trough_time_s": trough_time}
        for name, values in observation.signals.items():
            unit, size = self.units[name]
            suffix = unit.replace("/", "_").replace("^", "")
            columns[f"{name}_measured_{suffix}"] = values / size
            columns[f"{name}_computed_{suffix}"] = comparison.computed[name] / size
        return columns

    def _figures(self) -> dict[str, tuple[str, tuple[float, float, float]]]:
        """Return the unit of each figure; its measured value, standard error and computed value."""
        figures = {}
        for row in self.comparison.rows:
            unit, size = self.units[row.kind]
            value, error = row.measured
            figures[row.key] = unit, (value / size, error / size, row.computed / size)
        return figures

    def summary(self) -> TableColumns:
        """Return the figures, and the columns of the data that they come from."""
        figures = self._figures()
        units, numbers = zip(*figures.values(), strict=True)
        columns = "; ".join(self.record.headers.values())
        return {
            "quantity": list(figures),
            "unit": list(units),
            **dict(zip(_FIGURES, np.array(numbers).T, strict=True)),
            "data_columns": [columns] * len(figures),
        }

    def content(self) -> dict[str, Any]:
        """Return everything, for JSON."""
        comparison, alignment = self.comparison, self.comparison.alignment
        content: dict[str, Any] = {
            "columns": dict(self.record.headers),
            "absolute": comparison.recorded.absolute,
            "pattern": comparison.motion.pattern,
            "trough_time_at_zero_s": _number(alignment.shift),
            "trough_time_error_s": _number(alignment.error),
            "warnings": list(comparison.warnings),
            "figures": {
                key: {"unit": unit, **dict(zip(_FIGURES, map(_number, numbers), strict=True))}
                for key, (unit, numbers) in self._figures().items()
            },
        }
        if self.drive is not None:
            content["trough"] = _measured(self.drive)
        if self.fit is not None:
            content["fit"] = {
                p.name: {
                    "unit": unit,
                    "estimate": _number(p.value / size if p.identified else math.nan),
                    "low": _number(p.low / size),
                    "high": _number(p.high / size),
                    "intervals": [[low / size, high / size] for low, high in p.intervals],
                }
                for p, (unit, size) in self.parameters()
            }
            content["fit_statements"] = list(self.fit.statements)
        return content


def _measured(drive: MeasuredDrive | HarmonicDrive) -> dict[str, Any]:
    """Return the measured motion of the trough."""
    trough = drive.trough
    content: dict[str, Any] = {}
    for name, estimate in drive.quantities.items():
        quantity = QUANTITIES[name]
        value, error = (float(quantity.from_si(number)) for number in estimate)
        content[quantity.column] = {"measured": value, "standard_error": _number(error)}
    content["phase_normal_to_along_deg"] = _number(math.degrees(trough.phase))
    for name, wave in (("along", trough.along), ("normal", trough.normal)):
        if wave is not None:
            content[name] = {
                "column": wave.header,
                "acceleration_m_s2": {"measured": abs(wave.value), "standard_error": _number(wave.error)},
                "harmonics": wave.harmonics,
                "rest": wave.rest,
            }
    content["warnings"] = list(drive.warnings)
    return content


def _number(value: float) -> float | None:
    return float(value) if math.isfinite(value) else None
