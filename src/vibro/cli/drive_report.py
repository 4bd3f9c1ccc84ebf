"""What ``vibro drive`` prints and writes: the set-up sheet of a machine in words, as a table and as JSON."""

from __future__ import annotations

import math
import textwrap
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from vibro.answers.answer import aligned
from vibro.core.codes import Regime
from vibro.errors import printable
from vibro.quantities import DEFAULTS, LENGTH, MACHINE, QUANTITIES
from vibro.reports.set_up_sheet import CHANGES
from vibro.results.steady import NO_REGIME

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from vibro.reports.set_up_sheet import Bounds, Row, Sheet

__all__ = ["columns", "content", "picture_texts", "report"]

_WIDTH: Final = 80  # characters of a line
_MASSES: Final = {
    "vibrating_mass_kg": "vibrating mass", "trough_mass_kg": "trough", "counter_mass_kg": "counter mass",
}  # fmt: skip
_TOLD: Final = ("drive_angle", "static_friction", "kinetic_friction", "trough_angle", "restitution")
_PROOFS: Final = {
    "corners": "proved",
    "proved": "proved within 1 %",
    "searched": "searched, not proved",
    "sampled": "sampled, not proved",
}
_AT: Final = 0.01  # [%] distance from resonance that counts as none
_FAR: Final = 100.0  # [%] distance from resonance that is printed as "far"
_FRICTIONS: Final = ("static_friction", "kinetic_friction")


def report(sheet: Sheet, name: str) -> str:
    """Return the report as text.

    Parameters
    ----------
    sheet : Sheet
        The sheet.
    name : str
        Of the scene file.
    """
    parts = [
        _facts(sheet, name),
        _settings(sheet),
        _guaranteed(sheet),
        _changes(sheet),
        _sensitivities(sheet),
    ]
    parts.append(_packs(sheet))
    return "\n\n".join(filter(None, parts))


def _lines(facts: Sequence[tuple[str, str]]) -> str:
    """Return names and texts, these broken into lines below each other."""
    width = max(len(name) for name, _ in facts) + 2
    lines = []
    for name, text in facts:
        first, *others = textwrap.wrap(text, _WIDTH - width, break_long_words=False) or [""]
        lines += [f"{name.ljust(width)}{first}", *(f"{' ' * width}{line}" for line in others)]
    return "\n".join(line.rstrip() for line in lines)


def _facts(sheet: Sheet, name: str) -> str:
    request, (empty, full) = sheet.request, sheet.settings[-1]
    facts = [
        ("set-up sheet", printable(name)),
        ("machine", _machine(sheet)),
        ("drive", _drive(sheet)),
        ("bands", _bands(sheet)),
        ("resonance", _resonance(sheet, empty, full)),
    ]
    if request.full and request.machine.kind != "crank":
        facts.append(("filling", _filling(sheet, full)))
    facts += [("to resonance", text) for text in [_to_resonance(sheet)] if text]
    facts.append(("motion as given", _tolerated(sheet)))
    return _lines(facts)


def _machine(sheet: Sheet) -> str:
    given = sheet.request.machine
    said = [given.kind]
    for key, called in _MASSES.items():
        if key in given.table:
            unit = " kg" if isinstance(given.table[key], int | float) else ""
            said.append(f"{called} {given.table[key]}{unit}")
    if given.has_springs:
        said.append(f"natural frequency {_hz(sheet.request.values['natural'])}")
    elif given.kind == "unbalance":
        soft = "infinitely soft mounts, as no mount_hz is given"
        said.append(
            f"mounts {_hz(given.machine.natural_frequency)}" if given.machine.natural_frequency else soft
        )
    if given.kind != "crank":
        said.append(f"damping ratio {given.machine.damping_ratio:.4g}")
    return ", ".join(said)


def _drive(sheet: Sheet) -> str:
    values = sheet.request.values
    said = [_hz(values["frequency"])]
    for name in _TOLD:
        if name in values and values[name] != DEFAULTS.get(name):
            said.append(f"{QUANTITIES[name].label} {QUANTITIES[name].text(values[name])}")
    return ", ".join(said)


def _bands(sheet: Sheet) -> str:
    said = []
    for name, (low, high) in sheet.request.bands.items():
        quantity = QUANTITIES[name]
        said.append(f"{quantity.label} {f'{low:.15g} to ' if low < high else ''}{quantity.text(high)}")
    lacks = [f"--{name} {text}" for name, text in _EXAMPLES.items() if name not in sheet.request.bands]
    lacks = [text for text in lacks if "voltage" not in text or sheet.request.machine.takes("voltage")]
    told = ", ".join(said) or "none"
    return f"{told} (add {' and '.join(lacks)})" if lacks else told


_EXAMPLES: Final = {"voltage": "90:110", "filling": "0:2kg"}


def _resonance(sheet: Sheet, empty: Row, full: Row) -> str:
    if sheet.request.machine.kind == "crank":
        return "none: the trough follows the crank with any filling"
    ratios = [empty.frequency_ratio]
    if sheet.request.full and math.isfinite(full.filled_frequency_ratio):
        ratios.append(full.filled_frequency_ratio)
    if math.isinf(ratios[0]):
        return "far above resonance, as the mounts are infinitely soft: more filling, less amplitude"
    told = "f/f0 = " + ", ".join(
        f"{ratio:.4g} {state}" for ratio, state in zip(ratios, ("empty", "full"), strict=False)
    )
    away = 100.0 * abs(ratios[0] - 1.0)
    if away < _AT:
        return f"{told}: at resonance when empty"
    side = "below" if ratios[0] < 1.0 else "above"
    told += f": {'far' if away >= _FAR else f'{away:.2g} %'} {side} resonance when empty"
    sides = {ratio < 1.0 for ratio in ratios}
    if len(sides) == 2:
        return f"{told}; the filling takes the machine across resonance"
    if sheet.request.full:
        grows = full.amplitude > empty.amplitude
        return f"{told}. This filling brings {'more' if grows else 'less'} amplitude"
    more = "more" if sheet.more_mass > 0.0 else "less"
    return f"{told}. {side.capitalize()} resonance: more filling, {more} amplitude"


def _filling(sheet: Sheet, full: Row) -> str:
    if math.isnan(full.added_mass_share):
        return f"{full.filling:g} kg, whose share is not known: {full.status.message}"
    whose = "as given" if sheet.request.machine.shares else "computed"
    said = (
        f"{full.filling:g} kg act like {full.filling * full.added_mass_share:.4g} kg more of trough, a mass"
        f" share of {100.0 * full.added_mass_share:z.3g} %; damping share"
        f" {100.0 * full.added_damping_share:z.3g} % ({whose}, at {full.setting:g} %)"
    )
    if not math.isnan(full.second_harmonic):
        said += f"; second harmonic {100.0 * full.second_harmonic:.2g} % of the amplitude"
    return said


def _to_resonance(sheet: Sheet) -> str:
    empty = sheet.settings[-1][0]
    if sheet.request.machine.kind == "crank":
        return ""
    if empty.frequency_ratio > 1.0:
        return "no filling brings the machine to resonance: it moves away from it"
    if math.isnan(sheet.resonant_filling):
        return "no filling brings the machine to resonance"
    return f"about {sheet.resonant_filling:.3g} kg of filling, at this share, bring the machine to resonance"


def _tolerated(sheet: Sheet) -> str:
    """Say up to which filling the empty amplitude is good enough."""
    mass = sheet.request.machine.machine.trough_mass
    if math.isnan(sheet.tolerated):
        moves = math.isnan(sheet.settings[-1][0].speed)
        return "unknown, as the empty trough has no speed" if moves else "nothing moves in the empty trough"
    if math.isinf(mass):
        return "holds for any filling: the crank does not give way"
    if math.isinf(sheet.tolerated):
        return "holds within 1 % of speed for fillings as heavy as the trough"
    if not sheet.tolerated:
        return "any filling changes the speed by 1 % or more"
    share = f"{100.0 * sheet.tolerated / mass:.2g} % of the trough's mass"
    return f"fillings up to {sheet.tolerated:.2g} kg ({share}) change the speed by less than 1 %"


def _states(sheet: Sheet, empty: Row, full: Row) -> list[tuple[str, Row]]:
    return [("empty", empty), (f"{full.filling:g} kg", full)] if sheet.request.full else [("empty", empty)]


def _settings(sheet: Sheet) -> str:
    is_bent = any(not math.isnan(full.bent_speed) for _, full in sheet.settings)
    bent = [("speed*", "[mm/s]")] if is_bent else []
    first = [("setting", ""), ("trough", ""), ("amplitude", "[mm]"), ("speed", "[mm/s]")]
    heads = [*first, *bent, ("throw", "number"), ("f/f0", ""), ("regime", "")]
    rows: list[tuple[str, ...]] = [*zip(*heads, strict=True)]
    for empty, full in sheet.settings:
        for state, row in _states(sheet, empty, full):
            ratio = row.filled_frequency_ratio if row.filling else row.frequency_ratio
            other = [("" if math.isnan(row.bent_speed) else f"{row.bent_speed:.4g}")] if is_bent else []
            near = "-" if math.isinf(ratio) or not ratio else _number(ratio, 4)
            told = [
                state,
                _amplitude(row),
                _speed(row),
                *other,
                _number(row.throw_number, 3),
                near,
                _regime(row),
            ]
            rows.append((f"{row.setting:.4g} %", *told))
    note = "\n* with the second harmonic that the filling gives its trough" if is_bent else ""
    return aligned(rows) + note


def _guaranteed(sheet: Sheet) -> str:
    if not sheet.bounds:
        return "guaranteed speed: of bands alone; give voltage=90:110 or --mu-s 0.3:0.4"
    rows = [("guaranteed", "amplitude", "slowest", "fastest", "how sure")]
    rows.append(("", "[mm]", "[mm/s]", "[mm/s]", ""))
    for one in sheet.bounds:
        known = one.guarantee
        if known is None:
            rows.append((f"{one.setting:.4g} %", "-", "-", "-", "unknown"))
            continue
        low, high = (float(LENGTH.from_si(x)) for x in (known.speed_min, known.speed_max))
        rows.append(
            (
                f"{one.setting:.4g} %", _span(one.low, one.high), _number(low, 4), _number(high, 4),
                _PROOFS[known.proof_min],
            )
        )  # fmt: skip
    bounded = [one for one in sheet.bounds if one.guarantee is not None]
    return aligned(rows) + (f"\n{textwrap.fill(_how(sheet, bounded[-1]), _WIDTH)}" if bounded else "")


def _span(low: float, high: float) -> str:
    return f"{low:.4g} ... {high:.4g}" if low < high else f"{low:.4g}"


def _how(sheet: Sheet, last: Bounds) -> str:
    """Say over what the speeds hold, and how the amplitudes were found."""
    varies = [name for name, (low, high) in sheet.request.bands.items() if low < high]
    frictions = [QUANTITIES[name].label for name in _FRICTIONS if name in varies]
    over = "".join(f" and the band of {name}" for name in frictions)
    found = {"voltage": "both ends of the voltage", "filling": "17 fillings over their band"}
    looked = [found[name] for name in found if name in varies]
    looked += ["all corners of friction"] if frictions else []
    looked += ["both ends of the shares"] if sheet.request.machine.shares else []
    return (
        f"Speeds hold over every amplitude of the interval{over}, for a trough that moves as a sine. The"
        f" interval holds the {last.looked_at} operating points that were looked at ({', '.join(looked)});"
        " between them it is not proved."
    )


def _heads(sheet: Sheet, *first: tuple[str, str]) -> list[tuple[str, ...]]:
    """Return three lines of heads: own columns with their units, then amplitude and speed, empty and full."""
    states = _state_names(sheet)
    names, units = zip(*first, strict=True)
    blank = ("",) * len(first)
    return [
        (*names, *(cell for state in states for cell in (state, state))),
        (*blank, *("amplitude", "speed") * len(states)),
        (*units, *("[mm]", "[mm/s]") * len(states)),
    ]


def _state_names(sheet: Sheet) -> list[str]:
    return ["empty", f"{sheet.request.full:g} kg"] if sheet.request.full else ["empty"]


def _cells(rows: Sequence[Row]) -> list[str]:
    return [text for row in rows for text in (_amplitude(row), _speed(row))]


def _changes(sheet: Sheet) -> str:
    states = len(_state_names(sheet))
    pairs = [("nominal", sheet.settings[-1])]
    pairs += [(_change(sheet, change), (change.empty, change.full)) for change in sheet.changes]
    rows = _heads(sheet, (f"at {sheet.settings[-1][0].setting:.4g} %", ""))
    rows += [(name, *_cells(pair[:states])) for name, pair in pairs]
    if sheet.part_filled is not None:
        rows.append((f"filling {sheet.part_filled.filling:g} kg", "", "", *_cells([sheet.part_filled])))
    return aligned(rows)


def _change(sheet: Sheet, change: Any) -> str:
    if change.name == "frequency":
        percent = 100.0 * (change.value / sheet.request.values["frequency"] - 1.0)
        return f"frequency {percent:+.3g} %"
    return f"{QUANTITIES[change.name].label} {QUANTITIES[change.name].text(change.value)}"


def _sensitivities(sheet: Sheet) -> str:
    states = _state_names(sheet)
    rows = [("1 % more of", *(f"{state}: speed [%]" for state in states))]
    missing = 0
    for name, pair in sheet.sensitivities.items():
        if name in MACHINE and not sheet.request.machine.takes(name):
            continue  # of a crank
        told = ["" if name == "filling" and i == 0 else _signed(x) for i, x in enumerate(pair)][: len(states)]
        missing += told.count("-")
        rows.append((CHANGES[name], *told))
    if missing == sum(bool(cell) for _, *cells in rows[1:] for cell in cells):
        return "no rates for 1 % more: bodies hop, rest or never settle; see the table above"
    note = "-: bodies hop, rest or never settle: a rate would mislead; see the table above"
    return aligned(rows) + (f"\n{note}" if missing else "")


def _packs(sheet: Sheet) -> str:
    if not sheet.packs:
        return ""
    states = len(_state_names(sheet))
    rows = _heads(sheet, ("springs", ""), ("natural", "[Hz]"), ("f/f0", ""), ("force", "[today's]"))
    for pack in sheet.packs:
        ratio, force = _number(pack.empty.frequency_ratio, 3), f"{pack.force:.3g}"
        own = (printable(pack.name), _number(pack.natural, 4), ratio, force)
        rows.append((*own, *_cells((pack.empty, pack.full)[:states])))
    if sheet.no_load_proof:
        note = f"No pack is load-proof: {sheet.no_load_proof}."
    else:
        note = (
            "With the load-proof pack no filling changes the amplitude. It takes"
            f" {sheet.packs[-1].force:.3g} times today's force for the same empty amplitude."
        )
    return f"{aligned(rows)}\n{textwrap.fill(note, _WIDTH)}"


def _hz(value: float) -> str:
    return QUANTITIES["frequency"].text(value)


def _number(value: float, digits: int) -> str:
    if math.isinf(value):
        return "unbounded"
    return "-" if math.isnan(value) else f"{value:.{digits}g}"


def _signed(value: float) -> str:
    return "-" if math.isnan(value) else f"{value:+.3g}"


def _amplitude(row: Row) -> str:
    if row.strikes:
        return "strikes"
    if math.isnan(row.amplitude):
        return "-"
    low, high = f"{row.amplitude_low:.4g}", f"{row.amplitude_high:.4g}"
    if low != high:
        return f"{low}...{high}"
    return f"{row.amplitude:.4g}"


def _speed(row: Row) -> str:
    if math.isnan(row.speed):
        return "-"
    return f"{row.speed:.4g}" + (f" \u00b1 {row.speed_error:.2g}" if row.speed_error > 0.0 else "")


def _regime(row: Row) -> str:
    if not row.status.answered:
        return row.status.label
    return row.regime.label or NO_REGIME


def picture_texts(sheet: Sheet, name: str) -> tuple[str, str]:
    """Return the headline of the picture and what holds for all of it."""
    values = sheet.request.values
    given = sheet.request.machine
    said = [f"setting {sheet.request.settings[-1]:g} %"]
    said += [f"damping ratio {given.machine.damping_ratio:.4g}"] if given.kind != "crank" else []
    said += [f"{QUANTITIES[n].label} {QUANTITIES[n].text(values[n])}" for n in _TOLD[:3]]
    return f"{given.kind} \u2013 {name}", ", ".join(said)


_NUMBERS: Final = {
    "amplitude": "amplitude_mm",
    "amplitude_low": "amplitude_low_mm",
    "amplitude_high": "amplitude_high_mm",
    "relative_amplitude": "relative_amplitude_mm",
    "speed": "mean_velocity_mm_s",
    "speed_error": "mean_velocity_error_mm_s",
    "bent_speed": "mean_velocity_with_second_harmonic_mm_s",
    "throw_number": "throw_number",
    "frequency_ratio": "frequency_ratio",
    "filled_frequency_ratio": "filled_frequency_ratio",
    "added_mass_share": "added_mass_share",
    "added_damping_share": "added_damping_share",
}


def _all_rows(sheet: Sheet) -> list[tuple[str, Row]]:
    """Return the cases of the sheet, each once, with their purposes."""
    pairs = [("setting", pair) for pair in sheet.settings]
    pairs += [(change.name, (change.empty, change.full)) for change in sheet.changes]
    pairs += [(pack.name, (pack.empty, pack.full)) for pack in sheet.packs]
    rows = [(name, row) for name, pair in pairs for row in (pair if sheet.request.full else pair[:1])]
    return rows + ([("filling", sheet.part_filled)] if sheet.part_filled is not None else [])


def columns(sheet: Sheet) -> dict[str, Any]:
    """Return the operating points as a table: a row for each, with its purpose."""
    rows = _all_rows(sheet)
    table: dict[str, Any] = {"case": [name for name, _ in rows]}
    for name in ("setting", "voltage", "filling", "frequency", "natural"):
        table[QUANTITIES[name].column] = np.array([getattr(row, name) for _, row in rows])
    for name, column in _NUMBERS.items():
        table[column] = np.array([getattr(row, name) for _, row in rows])
    table["second_harmonic_percent"] = np.array([100.0 * row.second_harmonic for _, row in rows])
    table["operating_points"] = np.array([float(row.number) for _, row in rows])
    table["regime"] = [row.regime.label for _, row in rows]
    table["status"] = [row.status.label for _, row in rows]
    return table


def _known(value: float) -> float | None:
    return float(value) if math.isfinite(value) else None


def _row(row: Row) -> dict[str, Any]:
    told: dict[str, Any] = {
        QUANTITIES[name].column: _known(getattr(row, name))
        for name in ("setting", "voltage", "filling", "frequency", "natural")
    }
    told |= {column: _known(getattr(row, name)) for name, column in _NUMBERS.items()}
    return told | {
        "second_harmonic_percent": _known(100.0 * row.second_harmonic),
        "operating_points": row.number,
        "all_amplitudes_mm": list(row.amplitudes) or None,
        "strikes": row.strikes,
        "regime": row.regime.label or None,
        "status": row.status.label,
    }


def _bounds(one: Bounds) -> dict[str, Any]:
    told: dict[str, Any] = {
        "setting_percent": one.setting,
        "amplitude_mm": [_known(one.low), _known(one.high)],
        "operating_points_looked_at": one.looked_at,
    }
    known = one.guarantee
    if known is None:
        return {**told, "speed_mm_s": None}
    speeds = [_known(float(LENGTH.from_si(x))) for x in (known.speed_min, known.speed_max)]
    regimes = [regime.label for regime in sorted(known.regimes) if regime is not Regime.UNDEFINED]
    return {**told, "speed_mm_s": speeds, "proof": [known.proof_min, known.proof_max], "regimes": regimes}


def content(sheet: Sheet) -> dict[str, Any]:
    """Return the sheet for JSON, in the units of the names; null for missing numbers."""
    request = sheet.request
    pair = _pair_of(sheet)
    return {
        "scene": {QUANTITIES[name].column: value for name, value in request.values.items()},
        "machine": dict(request.machine.table),
        "bands": {QUANTITIES[name].column: list(band) for name, band in request.bands.items()},
        "settings": [pair(empty, full) for empty, full in sheet.settings],
        "guaranteed": [_bounds(one) for one in sheet.bounds],
        "changes": [
            {"changed": QUANTITIES[c.name].column, "value": c.value, **pair(c.empty, c.full)}
            for c in sheet.changes
        ],
        "least_filling": None if sheet.part_filled is None else _row(sheet.part_filled),
        "sensitivities": {
            "stiffness" if name == "natural" else name: {"empty": _known(empty), "full": _known(full)}
            for name, (empty, full) in sheet.sensitivities.items()
        },
        "packs": [
            {"name": p.name, "natural_hz": p.natural, "force_ratio": p.force, **pair(p.empty, p.full)}
            for p in sheet.packs
        ],
        "no_load_proof_pack": sheet.no_load_proof or None,
        "resonant_filling_kg": _known(sheet.resonant_filling),
        "tolerated_filling_kg": _known(sheet.tolerated),
        "warnings": list(sheet.warnings),
    }


def _pair_of(sheet: Sheet) -> Any:
    def pair(empty: Row, full: Row) -> Mapping[str, Any]:
        return {"empty": _row(empty), "full": _row(full) if sheet.request.full else None}

    return pair
