"""The answer about a record: what the trough does, and what a part does beside the exact motion."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from vibro.answers.answer import Answer, Fact, Table, given_text, letters, number, shown, uncertain
from vibro.errors import printable
from vibro.files.csv_tables import columns_of
from vibro.files.motions import harmonic_lists
from vibro.quantities import QUANTITIES
from vibro.records.comparison import UNITS
from vibro.records.reading import TOL
from vibro.records.trough import MEASURED
from vibro.units import STANDARD_GRAVITY

if TYPE_CHECKING:
    from collections.abc import Mapping
    from pathlib import Path

    from vibro.files.csv_tables import TableColumns
    from vibro.records.alignment import Estimate
    from vibro.records.comparison import Comparison
    from vibro.records.fitting import Fit, Parameter
    from vibro.records.measurement import Measurement
    from vibro.records.reading import Record
    from vibro.records.sensors import SensorErrors
    from vibro.records.trough import HopOnset, MeasuredMotion, TroughDrive
    from vibro.sweeps.request import Request

_MM: Final = 1e3  # in a metre
_USUAL: Final = ("advance", "mean_speed", "peak", "slip")  # words in the names of figures that people ask for
_RECORDED: Final = ("unit", "measured", "standard_error", "computed")  # of a figure
_OF_A_WAVE: Final = (("amplitude", "mm"), ("phase", "deg"))
_SLIPS: Final = (
    "slips, measured and computed, start and end where the speed passes"
    f" {100.0 * TOL.slide_level:g} % of its peak"
)
# Errors by the fields of ``SensorErrors``, in words, and their sizes in the unit of these.
_ERRORS: Final = {
    "tilt": ("a sensor tilt of {:.2g} deg", math.degrees(1.0)),
    "gain": ("a gain error of {:.2g} %", 100.0),
    "cross": ("a cross-axis sensitivity of {:.2g} %", 100.0),
    "delay": ("{:.2g} us between the channels", 1e6),
    "offset": ("an offset of {:.2g} mg", 1e3 / STANDARD_GRAVITY),
    "angle": ("an error of the drive angle of {:.2g} deg", math.degrees(1.0)),
    "amplitude": ("an error of the amplitude of {:.2g} %", 100.0),
}
_MATTERS: Final = 0.1  # of an interval: an error that makes it wider by less is not named
_WAYS: Final = {"trough_along": "along", "trough_normal": "normal"}
_NOTHING: Final = 1e-3  # of the largest contribution to an error: less is not worth a word
#: Kinds of error, for people.
_KINDS: Final = {
    "noise": "noise",
    "tilt": "tilt",
    "gain": "gain",
    "cross": "cross-axis sensitivity",
    "offset": "offset",
    "delay": "delay of channels",
    "angle": "the drive angle as given",
}


def measurement_answer(m: Measurement, data: Path, request: Request) -> Answer:
    """Make the answer about a record.

    Parameters
    ----------
    m : Measurement
        What is known of it.
    data : Path
        Its file.
    request : Request
        The scene, with what was measured of its drive.
    """
    time = m.record.time
    cycles = float(np.ptp(time)) * request.fixed["frequency"]
    size = f"{time.size} rows, {shown(cycles)} cycles, {shown((time.size - 1) / cycles)} samples a cycle"
    facts = [Fact("record", f"{printable(str(data))}: {size}")]
    record: dict[str, Any] = {
        "record": str(data),
        "rows": time.size,
        "columns": dict(m.record.headers),
        "scene": scene_table(request),
        "warnings": [*m.warnings, *(m.fit.doubts if m.fit else ())],
    }
    tables: list[Table] = []
    if m.trough:
        facts += [*_turn_facts(m.record, m.trough.drive.motion), *_drive_facts(m.trough, request)]
        record["trough"] = _trough_record(m.trough)
    if m.motion and m.onset:
        facts += [*_motion_facts(m, m.motion, m.onset), *_speed_facts(m, m.motion, m.onset)]
        record |= _motion_record(m, m.motion, m.onset)
    if m.comparison:
        figures = _figures(m, m.comparison)
        taken = {n: x for n, x in request.given_values.items() if m.trough is None or n not in MEASURED}
        scene = ": ".join(filter(None, (printable(request.name or ""), given_text(taken))))
        pattern = m.comparison.motion.pattern
        facts += [Fact("scene", scene), Fact("pattern", pattern, note=f"computed: {letters(pattern)}")]
        tables += [_figure_table(figures, is_rare=is_rare) for is_rare in (False, True)]
        record |= {
            "absolute": m.comparison.recorded.absolute,
            "pattern": pattern,
            "trough_time_at_zero_s": m.comparison.alignment.shift,
            "trough_time_error_s": m.comparison.alignment.error,
            "figures": {figure["quantity"]: {key: figure[key] for key in _RECORDED} for figure in figures},
        }
    if m.motion:
        tables.append(_harmonics_table(m.motion, is_rare=m.motion.order == 1 or m.comparison is not None))
    if m.fit:
        tables.append(_fit_table(m.fit, request))
        record["fit"] = {p.name: _parameter_record(p) for p in m.fit.parameters}
        record["assumed"] = _assumed(m.errors)
    title = " – ".join(filter(None, (data.name, request.name)))
    return Answer(facts, [table for table in tables if table.rows], _notes(m, request), record, title)


def scene_table(request: Request) -> dict[str, Any]:
    """Return the table ``[scene]`` of the file of a scene; harmonics are lists."""
    lists, others = harmonic_lists({name: spec.value for name, spec in request.specs.items()})
    return {QUANTITIES[name].column: value for name, value in others.items()} | lists


def scene_file(m: Measurement, data: Path, request: Request) -> str:
    """Write the scene file of a measured trough."""
    import tomlkit

    assert m.trough is not None
    head = [f"# The motion of a trough, measured in {printable(data.name)}. Its first harmonic:"]
    head += [f"# {fact.label} {fact.text}" for fact in _drive_facts(m.trough, request)]
    return "\n".join([*head, "", tomlkit.dumps({"scene": scene_table(request)})])


# --- the trough -----------------------------------------------------------------------------------------


def _turn_facts(record: Record, motion: MeasuredMotion) -> list[Fact]:
    """Say how the sensor is turned, where that is known."""
    found = motion.placement
    mounting = found.mounting
    if not (found.by_gravity or mounting.turned):
        return []
    note = "as given"
    if found.by_gravity:
        slope, offset = math.degrees(mounting.trough_angle), 1e3 * mounting.errors.offset / STANDARD_GRAVITY
        note = f"from gravity, which is taken off: a trough at {slope:.3g} deg, offsets of {offset:.3g} mg"
    if not record.trough.keys() & {"trough_along", "trough_normal"}:  # axes that nobody named
        axis = record.headers[[*record.trough][found.nearest]]
        where = "against" if found.axes[0, found.nearest] < 0.0 else "along"
        note = f"forwards is {where} '{printable(axis)}'; {note}"
    return [Fact("sensor turned", math.degrees(found.turn), "deg", math.degrees(found.turn_error), note)]


def _drive_facts(trough: TroughDrive, request: Request) -> list[Fact]:
    """Return line or ellipse of the first harmonic."""
    given = [(name, request.fixed[name]) for name in sorted(trough.needed & request.fixed.keys())]
    errors = {"drive_angle": math.degrees(trough.first.motion.drive_angle_error)}
    return [
        *(_estimated(name, estimate) for name, estimate in trough.first.quantities.items()),
        *(Fact(QUANTITIES[n].label, x, QUANTITIES[n].unit, errors.get(n, 0.0), "as given") for n, x in given),
    ]


def _estimated(name: str, estimate: Estimate) -> Fact:
    quantity = QUANTITIES[name]
    value, error = (float(quantity.from_si(x)) for x in estimate)
    return Fact(quantity.label, value, quantity.unit, error)


def _motion_facts(m: Measurement, measured: MeasuredMotion, onset: HopOnset) -> list[Fact]:
    standing = f"{measured.significant} of {measured.p_values.size} stand out of the noise"
    begins = Fact("hopping begins", "never: the trough moves along itself alone")
    if onset.amplitudes:
        sizes = (_estimated(*pair) for pair in onset.amplitudes.items())
        note = ", ".join(f"{size.label} {size.text}" for size in sizes)
        begins = Fact(begins.label, onset.growth.value, "times today's motion", onset.growth.error, note)
    return [
        Fact("harmonics", standing, is_rare=m.comparison is not None),
        Fact("throw number", onset.throw_number.value, "", onset.throw_number.error, "parts hop above 1"),
        begins,
    ]


def _parts(parts: Mapping[str, float], size: float, unit: str) -> str:
    """Write what noise and the kinds of error that count contribute, in a unit of some size."""
    least = _NOTHING * max(parts.values())
    kept = {kind: x for kind, x in parts.items() if kind == "noise" or not x < least}
    return ", ".join(f"{_KINDS[kind]} {shown(x / size, 2)} {unit}" for kind, x in kept.items())


def _speed_facts(m: Measurement, measured: MeasuredMotion, onset: HopOnset) -> list[Fact]:
    """Return the speed of a part on the measured motion, and what would change it."""
    speeds = m.speeds
    if speeds is None:
        facts = [Fact("speed", None, note="it needs the friction of a part: mu_s and mu_d")]
        if throw := onset.throw_number.value:
            parts = _parts(onset.parts, throw / 100.0, "%")
            facts.insert(0, Fact("error from", parts, note="of the throw number"))
        return facts
    speed, error = (_MM * x for x in speeds.speed)
    is_known = not math.isnan(speed)
    note = f"computed, {speeds.regime.label}" if is_known else speeds.status.message
    shares = [f"{shown(100.0 * share, 3)} % {one.label}" for one, share in speeds.shares.items()]
    shares += [f"{shown(100.0 * speeds.unknown, 3)} % without a speed"] if speeds.unknown else []
    facts = [
        Fact("speed", speed, "mm/s", error, note),
        Fact("noise", f"{', '.join(shares)}, in {speeds.draws} draws", is_rare=True),
    ]
    if is_known:
        size, unit = (0.01 * abs(speed), "%") if speed else (1.0, "mm/s")
        parts = _parts(speeds.parts, size / _MM, unit)
        last = f"the last harmonic adds {shown(_MM * abs(speeds.last_harmonic) / size, 2)} {unit} of speed"
        facts.append(Fact("error from", parts, note=last if measured.order > 1 else ""))
    return facts


def _harmonics(measured: MeasuredMotion) -> list[dict[str, float]]:
    """Return amplitude and phase of each harmonic in the directions that were measured."""
    ways = [_WAYS[channel] for channel in measured.channels]
    rows = []
    for k in range(measured.order):
        row: dict[str, float] = {"order": k + 1, "acceleration_share": float(measured.shares[k])}
        for i, way in enumerate(ways):
            wave = getattr(measured, way)[k]
            row |= {
                f"{way}_amplitude_mm": _MM * abs(wave),
                f"{way}_amplitude_error_mm": _MM * float(measured.standard_errors[k, i]),
                f"{way}_phase_deg": math.degrees(float(np.angle(wave))),
                f"{way}_phase_error_deg": math.degrees(measured.phase_errors[k, i]),
            }
        rows.append(row | {"p_value": float(measured.p_values[k])})
    return rows


def _harmonics_table(measured: MeasuredMotion, *, is_rare: bool) -> Table:
    kinds = [(_WAYS[c], what, unit) for c in measured.channels for what, unit in _OF_A_WAVE]
    rows: list[list[Any]] = []
    for one in _harmonics(measured):
        waves = [uncertain(one[f"{w}_{x}_{unit}"], one[f"{w}_{x}_error_{unit}"]) for w, x, unit in kinds]
        rows.append([str(one["order"]), *waves, 100.0 * one["acceleration_share"]])
    heads = [("harmonic", ""), *((way, unit) for way, _, unit in kinds), ("acceleration", "%")]
    return Table("harmonics", heads, rows, "Harmonics of the trough", is_rare)


def _trough_record(trough: TroughDrive) -> dict[str, Any]:
    content: dict[str, Any] = {}
    for name, estimate in trough.drive.quantities.items():
        fact = _estimated(name, estimate)
        content[QUANTITIES[name].column] = {"measured": fact.value, "standard_error": fact.error}
    motion = trough.drive.motion
    content |= {
        "turned_deg": math.degrees(motion.placement.turn),
        "turned_error_deg": math.degrees(motion.placement.turn_error),
        "turned_by_gravity": motion.placement.by_gravity,
    }
    content["phase_normal_to_along_deg"] = math.degrees(motion.phase)
    sizes, errors = abs(motion.accelerations[0]).tolist(), motion.acceleration_errors[0].tolist()
    for channel, sensor, size, error in zip(motion.channels, motion.sensors, sizes, errors, strict=True):
        content[_WAYS[channel]] = {
            "column": sensor.header,
            "acceleration_m_s2": {"measured": size, "standard_error": error},
            "harmonics": sensor.harmonics,
            "rest": sensor.rest,
        }
    return content


def _recorded(name: str, estimate: Estimate, unit: str = "") -> dict[str, float]:
    return {f"{name}{unit}": estimate.value, f"{name}_error{unit}": estimate.error}


def _motion_record(m: Measurement, measured: MeasuredMotion, onset: HopOnset) -> dict[str, Any]:
    hops = _recorded("times_todays_amplitude", onset.growth)
    for name, size in onset.amplitudes.items():
        hops |= _recorded(name, size.scaled(_MM), "_mm")
    speeds = m.speeds
    return {
        "frequency_hz": measured.frequency,
        "frequency_error_hz": measured.frequency_error,
        "time_of_phase_0_s": measured.clock,
        "harmonics_found": measured.significant,
        "harmonics_sought": measured.p_values.size,
        "harmonics": _harmonics(measured),
        **_recorded("throw_number", onset.throw_number),
        "throw_number_error_parts": dict(onset.parts),
        "hop_onset": hops if onset.amplitudes else None,
        "speed": speeds
        and {
            **_recorded("mean_velocity", speeds.speed.scaled(_MM), "_mm_s"),
            "regime": speeds.regime.label,
            "status": speeds.status.label,
            "draws": speeds.draws,
            "shares": {regime.label: share for regime, share in speeds.shares.items()},
            "share_without_speed": speeds.unknown,
            "last_harmonic_mm_s": _MM * speeds.last_harmonic,
            "error_parts_mm_s": {kind: _MM * x for kind, x in speeds.parts.items()},
        },
    }


# --- the part -------------------------------------------------------------------------------------------


def _unit(kind: str, mass: float | None) -> tuple[str, float]:
    """Return the unit of a kind of figure, and its size in SI units."""
    return ("N", 1.0 / mass) if kind == "friction" and mass is not None else UNITS[kind]


def _figures(m: Measurement, comparison: Comparison) -> list[dict[str, Any]]:
    """Return every figure, measured and computed."""
    figures = []
    for row in comparison.rows:
        unit, size = _unit(row.kind, m.mass)
        measured, error, computed = (x / size for x in (*row.measured, row.computed))
        figure = {"quantity": row.key, "unit": unit, "measured": measured, "standard_error": error}
        is_relative = row.kind != "time" and computed != 0.0
        difference = 100.0 * (measured - computed) / computed if is_relative else math.nan
        figures.append({**figure, "computed": computed, "difference_percent": difference})
    return figures


def _figure_table(figures: list[dict[str, Any]], *, is_rare: bool) -> Table:
    """List the usual figures, or the others."""
    rows = []
    for key, unit, measured, error, computed, difference in map(dict.values, figures):
        if any(word in key for word in _USUAL) is not is_rare:
            own = uncertain(measured, error) if math.isfinite(measured) else "not seen"
            exact = None if math.isnan(computed) else number(computed)
            off = None if math.isnan(difference) else round(difference, 2)
            rows.append([key.replace("_", " "), unit, own, exact, off])
    heads = [("", ""), ("unit", ""), ("measured", ""), ("computed", ""), ("difference", "%")]
    return Table("figures", heads, rows, "More of the part" if is_rare else "The part", is_rare)


def tables_of(m: Measurement) -> dict[str, TableColumns]:
    """Return the columns of its CSVs: signals over time and figures of a part, else a trough's harmonics."""
    if m.comparison is None:
        return {"": columns_of(_harmonics(m.motion) if m.motion else [])}
    observation, comparison = m.comparison.observation, m.comparison
    signals: dict[str, Any] = {
        "time_s": observation.time,
        "trough_time_s": comparison.trough_time % comparison.motion.period,
    }
    for name, values in observation.signals.items():
        unit, size = _unit(name, m.mass)
        suffix = unit.replace("/", "_").replace("^", "")
        signals[f"{name}_measured_{suffix}"] = values / size
        signals[f"{name}_computed_{suffix}"] = comparison.computed[name] / size
    return {"": signals, "summary": columns_of(_figures(m, comparison))}


# --- the fit --------------------------------------------------------------------------------------------


def _fit_table(fit: Fit, request: Request) -> Table:
    rows: list[list[str]] = []
    for p in fit.parameters:
        quantity, found = QUANTITIES[p.name], _parameter_record(p)
        pieces = [f"{shown(low)} ... {shown(high)}" for low, high in found["intervals"]]
        estimate = "-" if found["estimate"] is None else shown(found["estimate"])
        name = f"{quantity.letter} [{quantity.unit}]" if quantity.unit else quantity.letter
        interval = " or ".join(pieces) or "not identified"
        rows.append([name, estimate, interval, shown(request.fixed[p.name])])
    heads = [(head, "") for head in ("fitted", "estimate", "95 % interval", "given")]
    return Table("fit", heads, rows, "Fit")


def _parameter_record(p: Parameter) -> dict[str, Any]:
    quantity = QUANTITIES[p.name]

    def outside(value: float) -> float:
        return float(quantity.from_si(value))

    return {
        "unit": quantity.unit,
        "estimate": outside(p.value) if p.identified else None,
        "low": outside(p.low),
        "high": outside(p.high),
        "intervals": [[outside(low), outside(high)] for low, high in p.intervals],
        "narrower_without": dict(p.narrower),
    }


def _assumed(errors: SensorErrors) -> dict[str, Any]:
    """Return the standard errors of sensors and of a stated drive that a fit assumes."""
    return {
        "tilt_deg": math.degrees(errors.tilt),
        "gain": errors.gain,
        "cross": errors.cross,
        "delay_s": errors.delay,
        "lowpass_hz": errors.lowpass if math.isfinite(errors.lowpass) else None,
        "angle_deg": math.degrees(errors.angle),
        "amplitude": errors.amplitude,
        "stated": sorted(errors.stated),
    }


def _causes(m: Measurement, fit: Fit) -> list[str]:
    """Say which errors of sensors, or of a stated drive, make intervals wide, and which are assumed."""
    errors = {name: text.format(size * getattr(m.errors, name)) for name, (text, size) in _ERRORS.items()}
    errors["noise"] = "the noise of the trough's sensors"
    causes = []
    for p in fit.parameters:
        most = sorted(p.narrower.items(), key=lambda item: -item[1])[:2]
        parts = [f"{100.0 * x:.0f} % without {errors[name]}" for name, x in most if x >= _MATTERS]
        letter = QUANTITIES[p.name].letter
        causes += [f"the interval of {letter} would be narrower by {' or '.join(parts)}"] * bool(
            parts and p.intervals
        )
    used = {name for p in fit.parameters for name in p.narrower}
    assumed = [text for name, text in errors.items() if name in used and name in m.errors._fields]
    return [*causes, *[f"assumed standard errors: {', '.join(assumed)}"] * bool(assumed)]


def _notes(m: Measurement, request: Request) -> list[str]:
    """Return which feature gives each estimate, what has none, and what no interval covers."""
    slips = [_SLIPS] if m.comparison and any("slip" in row.key for row in m.comparison.rows) else []
    if m.fit is None:
        return slips
    return [*m.fit.statements, *_causes(m, m.fit), *slips]
