"""What ``vibro compare`` prints: where the data lie in the cycle, figures beside each other, estimates."""

from __future__ import annotations

import math
import sys
from typing import TYPE_CHECKING

from vibro.answers.answer import aligned
from vibro.errors import printable
from vibro.quantities import DEFAULTS, QUANTITIES
from vibro.sweeps.one_scene import number

if TYPE_CHECKING:
    from pathlib import Path

    from vibro.records.comparison import Comparison, Row
    from vibro.records.comparison_tables import ComparisonTables
    from vibro.records.fitting import Fit, Parameter
    from vibro.records.folding import Estimate
    from vibro.records.trough import MeasuredDrive
    from vibro.records.waveforms import HarmonicDrive
    from vibro.sweeps.request import Request

__all__ = ["comparison_report", "measured", "uncertain"]


def comparison_report(tables: ComparisonTables, data: Path, request: Request) -> str:
    """Report measured, computed and estimated values.

    Parameters
    ----------
    tables : ComparisonTables
        The comparison.
    data : Path
        The record.
    request : Request
        The scene as given, or measured, before anything was estimated.
    """
    return _Report(tables, data, request).text()


class _Report:
    """The comparison in words."""

    def __init__(self, tables: ComparisonTables, data: Path, request: Request) -> None:
        self.tables = tables
        self.comparison, self.fit, self.units = tables.comparison, tables.fit, tables.units
        self.data = data
        self.request = request

    def text(self) -> str:
        """Return the report as text."""
        parts = [aligned(self._facts(), right=False)]
        head = ("", "measured", "computed", "difference")
        parts.append(aligned([head, *map(self._row, self.comparison.rows)]))
        if self.fit is not None:
            rows = []
            for p, (unit, size) in self.tables.parameters():
                own = self.request.fixed[p.name]
                label = f"{QUANTITIES[p.name].letter} {f'[{unit}]' if unit else ''}".strip()
                rows.append((label, *_estimated(p, size), f"{own:.6g}"))
            parts.append(aligned([("fitted", "estimate", "95 % interval", "given"), *rows]))
            statements = [*self.fit.statements, *self._taken_as_exact(self.fit)]
            parts += ["\n".join(statements)] if statements else []
        return "\n\n".join(parts)

    def _taken_as_exact(self, fit: Fit) -> list[str]:
        """Say that a drive angle that is neither fitted nor measured has an error that no interval holds."""
        angle = self.request.fixed.get("drive_angle")
        measured_names = self.tables.drive.quantities if self.tables.drive is not None else ()
        known = {*measured_names, *(p.name for p in fit.parameters)}
        if angle is None or "drive_angle" in known:
            return []
        value = number(angle, QUANTITIES["drive_angle"].unit)
        return [f"the drive angle of {value} is taken as exact: no interval covers its error"]

    def _facts(self) -> list[tuple[str, str]]:
        observation, alignment = self.comparison.observation, self.comparison.alignment
        span = float(observation.time[-1] - observation.time[0])
        cycles = span * observation.frequency
        facts = [
            (
                "data",
                f"{printable(str(self.data))}: {observation.time.size} rows, {cycles:.4g} cycles,"
                f" {(observation.time.size - 1) / cycles:.4g} samples a cycle",
            ),
            ("scene", self._scene()),
            ("computed", f"pattern {self.comparison.motion.pattern}"),
        ]
        if self.comparison.recorded.absolute:
            seen = "the data are over the ground: the trough's computed motion is taken off them"
            facts.insert(1, ("", seen))
        if self.tables.drive is not None:
            facts += _trough(self.tables.drive)
        if not math.isnan(alignment.shift):
            begin = (float(observation.time[0]) + alignment.shift) % observation.period
            facts.append(
                (
                    "alignment",
                    f"the data begin {1e3 * begin:.3f} \u00b1 {1e3 * alignment.error:.2g} ms after"
                    f" {_zero_of(self.comparison)} ({360.0 * begin / observation.period:.1f} deg)",
                )
            )
        return facts

    def _scene(self) -> str:
        """Name the scene file, and its operating point."""
        given = (
            f"{QUANTITIES[name].label} {number(value, QUANTITIES[name].unit)}"
            for name, value in self.request.told.items()
            if value != DEFAULTS.get(name)
        )
        return ": ".join(filter(None, (printable(self.request.name or ""), ", ".join(given))))

    def _row(self, row: Row) -> tuple[str, str, str, str]:
        unit, size = self.units[row.kind]
        measured, error = row.measured.value / size, row.measured.error / size
        text = "not seen" if math.isnan(measured) else uncertain(measured, error)
        computed = "" if math.isnan(row.computed) else f"{row.computed / size:.6g}"
        difference = ""
        if not math.isnan(measured) and not math.isnan(row.computed):
            off = measured - row.computed / size
            relative = row.kind != "time" and row.computed != 0.0
            difference = f"{100.0 * off / (row.computed / size):+.1f} %" if relative else f"{off:+.3g}"
        return f"{row.label} [{unit}]", text, computed, difference


def _zero_of(comparison: Comparison) -> str:
    """Say what happens at trough time 0."""
    way = comparison.passing
    return f"the trough passes its middle {way}" if way else "phase 0 of the drive"


def _estimated(parameter: Parameter, size: float) -> tuple[str, str]:
    """Write an estimate and its intervals, to two digits of the narrowest interval's half."""
    pieces = [(low / size, high / size) for low, high in parameter.intervals]
    if not pieces:
        return "-", "not identified"
    half = max(min(0.5 * (high - low) for low, high in pieces), sys.float_info.epsilon * abs(pieces[-1][1]))
    digits = max(0, 1 - math.floor(math.log10(half)))
    interval = " or ".join(f"{low:.{digits}f} ... {high:.{digits}f}" for low, high in pieces)
    return f"{parameter.value / size:.{digits}f}" if parameter.identified else "-", interval


def _trough(drive: MeasuredDrive | HarmonicDrive) -> list[tuple[str, str]]:
    """Say what was measured of the trough's motion."""
    facts = [("trough", ", ".join(measured(name, estimate) for name, estimate in drive.quantities.items()))]
    for wave in drive.trough.waves:
        shares = (
            f"harmonics {100.0 * wave.harmonics:.2g} % of the fundamental, the rest {100.0 * wave.rest:.2g} %"
        )
        facts.append(("", f"{printable(wave.header)}: {shares}"))
    phase = math.degrees(drive.trough.phase)
    if not math.isnan(phase) and "normal_phase" not in drive.quantities:
        ahead = "ahead of" if phase > 0.0 else "behind"
        facts.append(("", f"its normal motion is {abs(phase):.1f} deg {ahead} that along it"))
    return facts


def measured(name: str, estimate: Estimate) -> str:
    """Write an estimate of a quantity of a scene, given in SI units, in the user's."""
    quantity = QUANTITIES[name]
    value, error = (float(quantity.from_si(number)) for number in estimate)
    return f"{quantity.label} {uncertain(value, error)} {quantity.unit}"


def uncertain(value: float, error: float) -> str:
    """Write a value with its standard error, to two digits of that."""
    if not math.isfinite(error) or error <= 0.0:
        return f"{value:.4g}"
    digits = max(0, 1 - math.floor(math.log10(error)))
    return f"{value:z.{digits}f} \u00b1 {error:.{digits}f}"
