"""What ``vibro motion`` prints and writes: the trough's motion, its errors, and the speed that it makes."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from vibro.answers.answer import aligned
from vibro.cli.compare_report import measured as described
from vibro.cli.compare_report import uncertain
from vibro.core.codes import Regime, Status
from vibro.errors import printable
from vibro.quantities import DEFAULTS, ELLIPTICAL, LENGTH, QUANTITIES
from vibro.records.folding import Estimate
from vibro.records.tolerances import TOL
from vibro.records.trough import spelled
from vibro.sweeps.one_scene import bounce_text, number

if TYPE_CHECKING:
    from collections.abc import Mapping
    from pathlib import Path

    from vibro.records.measured_speeds import HopOnset, Speeds
    from vibro.records.waveforms import MeasuredMotion

__all__ = ["MotionReport"]

_EXACT: Final = 1e-6  # of a value, or of its unit: nobody measures so well, or so little
_WAYS: Final = {"trough_along": "along", "trough_normal": "normal"}
_TO: Final = {"trough_along": "along the trough", "trough_normal": "normal to it"}
_CALIBRATIONS: Final = {
    "gain": f"{100.0 * TOL.gain:g} % of gain",
    "tilt": f"{math.degrees(TOL.tilt):g} deg of tilt",
    "delay": f"{1e6 * TOL.delay:g} us between the channels",
}


class MotionReport:
    """A measured motion in words, as JSON and as a scene file.

    Parameters
    ----------
    data : Path
        The record.
    measured : MeasuredMotion
        The motion.
    onset : HopOnset
        Throw number, and where parts begin to hop.
    speeds : Speeds or None
        The conveying speed; None without friction.
    others : mapping of str to float
        The quantities of the scene besides the drive's, in users' units.
    """

    def __init__(
        self,
        data: Path,
        measured: MeasuredMotion,
        onset: HopOnset,
        speeds: Speeds | None,
        others: Mapping[str, float],
    ) -> None:
        self.data = data
        self.measured = measured
        self.onset = onset
        self.speeds = speeds
        self.others = others

    @property
    def unresolved(self) -> bool:
        """Whether the requested speed is unknown."""
        return self.speeds is not None and self.speeds.status is Status.UNRESOLVED

    def text(self) -> str:
        """Return the report as text."""
        return "\n\n".join([aligned(self._facts(), right=False), aligned(self._harmonics())])

    def _facts(self) -> list[tuple[str, str]]:
        m = self.measured
        cycles = m.span * m.frequency
        per_cycle = (m.rows - 1) / cycles
        record = f"{m.rows} rows, {cycles:.4g} cycles, {per_cycle:.4g} samples a cycle"
        stands = f"{m.significant} of {m.p_values.size} stand out of the noise"
        facts = [
            ("record", f"{printable(str(self.data))}: {record}"),
            ("fundamental", self._fundamental()),
            ("harmonics", f"{stands} (each by chance in one record of {1.0 / TOL.by_chance:.0f})"),
            ("throw number", _told(*self.onset.throw_number)),
            ("hops", self._hops()),
        ]
        if self.speeds is None:
            needed = "unknown without friction: add --mu-s and --mu-d, or a scene file that gives both"
            facts.append(("mean speed", needed))
        else:
            facts += self._speed(self.speeds)
        return [*facts, ("solve with", self._options())]

    def _hops(self) -> str:
        """Say at which amplitude parts begin to hop."""
        throw, growth, amplitudes = self.onset
        if not amplitudes:
            return "never: the trough moves along itself alone"
        sizes = ", ".join(described(*pair) for pair in amplitudes.items())
        at = f"{_told(*growth)} times today's amplitude ({sizes})"
        return f"already; not below {at}" if throw.value > 1.0 else f"from {at} on"

    def _options(self) -> str:
        """Return the options with which ``vibro solve`` takes the motion, or where else it takes it from."""
        if self.measured.order > 1:
            return "-o DRIVE.toml writes all harmonics as a scene file, for vibro solve DRIVE.toml"
        said = []
        for name, value in self._quantities().items():
            said.append(QUANTITIES[name].typed(repr(value)))
        friction = "" if self.speeds is not None else ", and --mu-s and --mu-d"
        return f"vibro solve {' '.join(said)}{friction}"

    def _fundamental(self) -> str:
        """Describe the fundamental as a line, or as an ellipse where it leaves one."""
        trough, angle = self.measured.trough, self.measured.drive_angle
        if trough.on_an_ellipse:
            return "an ellipse: " + ", ".join(
                described(*pair) for pair in trough.drive_on_ellipse().quantities.items()
            )
        told = [described(*pair) for pair in trough.drive_on_line(angle).quantities.items()]
        if angle is not None:
            told.append(f"drive angle {number(math.degrees(angle), 'deg')} as given")
        return "a line: " + ", ".join(told)

    def _speed(self, speeds: Speeds) -> list[tuple[str, str]]:
        speed, error = (LENGTH.from_si(x) for x in speeds.speed)
        regime = speeds.regime.label
        shares = [f"{100.0 * share:.3g} % {one.label}" for one, share in speeds.shares.items()]
        if speeds.unknown:
            shares.append(f"{100.0 * speeds.unknown:.3g} % without a speed")
        drawn = f"noise alone, in {speeds.draws} draws: {', '.join(shares)}"
        if math.isnan(speed):
            status = speeds.status
            return [("mean speed", f"unknown, {regime}: {status.label} ({status.message})"), ("", drawn)]
        facts = [("mean speed", f"{_told(float(speed), float(error))} mm/s, {regime}"), ("", drawn)]
        if speeds.regime is Regime.HOPPING:
            facts.append(("restitution", bounce_text(self.others.get("restitution", 0.0))))
        if self.measured.order > 1:
            facts.append(("last harmonic", f"changes it by {self._change(speeds.last_harmonic, '+')}"))
        sizes = [f"{_CALIBRATIONS[name]} {self._change(x)}" for name, x in speeds.calibrations.items()]
        return [*facts, ("calibration", f"errors would change it by: {', '.join(sizes)}")]

    def _change(self, change: float, sign: str = "") -> str:
        """Write a change of the speed, in per cent if the speed is not 0."""
        assert self.speeds is not None
        speed = self.speeds.speed.value
        if math.isnan(change):
            return "unknown"
        if not speed:
            return f"{LENGTH.from_si(change):{sign}.3g} mm/s"
        return f"{100.0 * change / abs(speed):{sign}.2g} %"

    def _harmonics(self) -> list[tuple[str, ...]]:
        """Return the table of harmonics."""
        m = self.measured
        heads = [f"{_WAYS[name]} {unit}" for name in m.channels for unit in ("[mm]", "[deg]")]
        rows = [("harmonic", *heads, "acceleration [%]")]
        for k in range(m.order):
            cells = []
            for i, name in enumerate(m.channels):
                motion = m.along[k] if name == "trough_along" else m.normal[k]
                size, error = (float(LENGTH.from_si(x)) for x in (abs(motion), m.standard_errors[k, i]))
                phase, off = math.degrees(float(np.angle(motion))), math.degrees(m.phase_errors[k, i])
                cells += [_told(size, error), _told(phase, off) if off else "0"]
            rows.append((str(k + 1), *cells, f"{100.0 * m.shares[k]:.3g}"))
        return rows

    def content(self) -> dict[str, Any]:
        """Return the report for JSON."""
        m, to_mm = self.measured, LENGTH.from_si
        harmonics = []
        for k in range(m.order):
            one: dict[str, Any] = {"order": k + 1, "acceleration_share": float(m.shares[k])}
            for i, name in enumerate(m.channels):
                motion = m.along[k] if name == "trough_along" else m.normal[k]
                way = _WAYS[name]
                one |= {
                    f"{way}_amplitude_mm": float(to_mm(abs(motion))),
                    f"{way}_amplitude_error_mm": float(to_mm(m.standard_errors[k, i])),
                    f"{way}_phase_deg": math.degrees(float(np.angle(motion))),
                    f"{way}_phase_error_deg": math.degrees(m.phase_errors[k, i]),
                }
            harmonics.append(one | {"p_value": float(m.p_values[k])})
        return {
            "record": str(self.data),
            "rows": m.rows,
            "frequency_hz": m.frequency,
            "frequency_error_hz": m.frequency_error,
            "time_of_phase_0_s": m.clock,
            "harmonics_found": m.significant,
            "harmonics_sought": m.p_values.size,
            "harmonics": harmonics,
            "throw_number": self.onset.throw_number.value,
            "throw_number_error": self.onset.throw_number.error,
            "hop_onset": self._onset(),
            "scene": self._scene(),
            "speed": None if self.speeds is None else self._speed_content(self.speeds),
            "warnings": list(m.warnings),
        }

    def _speed_content(self, speeds: Speeds) -> dict[str, Any]:
        def mm(value: float) -> float | None:
            return None if math.isnan(value) else float(LENGTH.from_si(value))

        return {
            "mean_velocity_mm_s": mm(speeds.speed.value),
            "mean_velocity_error_mm_s": mm(speeds.speed.error),
            "regime": speeds.regime.label,
            "status": speeds.status.label,
            "draws": speeds.draws,
            "shares": {regime.label: share for regime, share in speeds.shares.items()},
            "share_without_speed": speeds.unknown,
            "last_harmonic_mm_s": mm(speeds.last_harmonic),
            "calibration_mm_s": {name: mm(change) for name, change in speeds.calibrations.items()},
        }

    def _onset(self) -> dict[str, float] | None:
        """Return the motion at which parts begin to hop, for JSON."""
        _, growth, amplitudes = self.onset
        if not amplitudes:
            return None
        content = {"times_todays_amplitude": growth.value, "times_todays_amplitude_error": growth.error}
        for name, size in amplitudes.items():
            value, error = (float(LENGTH.from_si(x)) for x in size)
            content |= {f"{name}_mm": value, f"{name}_error_mm": error}
        return content

    def _quantities(self) -> dict[str, float]:
        """Return a motion of one harmonic, and the rest of the scene, in users' units: a line or an ellipse.

        Measured values have the digits that the record supports.
        """
        m = self.measured
        if m.drive_angle is not None:
            found = m.trough.drive_on_line(m.drive_angle).quantities
            drive = _rounded(found) | {"drive_angle": float(f"{math.degrees(m.drive_angle):.15g}")}
        else:
            found = m.measured_drive().quantities
            phase, zero = found["normal_phase"], found.pop("along_phase")
            lead = math.remainder(phase.value - zero.value, math.tau)
            found |= {"normal_phase": Estimate(lead, math.hypot(phase.error, zero.error))}
            drive = _rounded({name: found[name] for name in (*ELLIPTICAL, "frequency")})
        return drive | {name: x for name, x in self.others.items() if x != DEFAULTS.get(name)}

    def _scene(self) -> dict[str, float | list[float]]:
        """Return the keys of the scene file: those of a line or an ellipse, or lists of harmonics."""
        m = self.measured
        if m.order == 1:
            return {QUANTITIES[name].column: x for name, x in self._quantities().items()}
        found = _rounded(m.measured_drive().quantities)
        ends = ["", *(f"_{k}" for k in range(2, m.order + 1))]
        scene: dict[str, float | list[float]] = {}
        for way, motion in (("along", m.along), ("normal", m.normal)):
            if motion.any():
                scene[f"{way}_amplitudes_mm"] = [found[f"{way}_amplitude{end}"] for end in ends]
                scene[f"{way}_phases_deg"] = [found[f"{way}_phase{end}"] for end in ends]
        scene[QUANTITIES["frequency"].column] = found["frequency"]
        rest = {name: x for name, x in self.others.items() if x != DEFAULTS.get(name)}
        return scene | {QUANTITIES[name].column: x for name, x in rest.items()}

    def scene_file(self) -> str:
        """Return the scene file."""
        import tomlkit

        m = self.measured
        cycles, plural = f"{m.span * m.frequency:.4g} cycles", "s" if m.order > 1 else ""
        name = printable(self.data.name)
        head = [f"# The motion of a trough, measured in {cycles} of {name}: {m.order} harmonic{plural}."]
        for i, channel in enumerate(m.channels):
            errors = ", ".join(f"{LENGTH.from_si(x):.2g}" for x in m.standard_errors[:, i])
            head.append(f"# Standard error{plural} of the motion {_TO[channel]}: {errors} mm")
        head.append(f"# Standard error of the frequency: {m.frequency_error:.2g} Hz")
        return "\n".join([*head, "", tomlkit.dumps({"scene": self._scene()})])


def _rounded(quantities: Mapping[str, Estimate]) -> dict[str, float]:
    """Return measured quantities in users' units, to two digits below their standard errors."""
    return {
        name: float(spelled(*(float(QUANTITIES[name].from_si(x)) for x in estimate)))
        for name, estimate in quantities.items()
    }


def _told(value: float, error: float) -> str:
    """Write a value with its standard error; of exact data with six digits, however small that error is."""
    if error < _EXACT * abs(value) or abs(value) < _EXACT:
        return f"{value:z.6g} \u00b1 {error:.2g}"
    return uncertain(value, error)
