"""The answers about a machine: its operating point, its set-up sheet, several machines side by side."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, Final

from vibro.answers.answer import Answer, Fact, Table, bound, given_text, label_of, shown, uncertain
from vibro.files.csv_tables import columns_of
from vibro.machines.operating import DOUBTS
from vibro.quantities import MASS, QUANTITIES, TROUGH_MASS, exact_number
from vibro.results.operating import MACHINE_RESULTS, OPERATING, WARNED_HARMONIC

if TYPE_CHECKING:
    from collections.abc import Mapping

    from vibro.answers.answer import Value
    from vibro.answers.set_up_sheet import Row, Sheet
    from vibro.files.csv_tables import TableColumns
    from vibro.files.machines import GivenMachine

_MASSES: Final = ("vibrating_mass_kg", "trough_mass_kg", "counter_mass_kg")
_PROOFS: Final = {
    "corners": "proved", "proved": "proved", "searched": "searched, not guaranteed",
    "sampled": "sampled, not guaranteed",
}  # fmt: skip
_DIGITS: Final = 4  # of bounds
_INPUTS: Final = {"frequency": "mains frequency", "stiffness": "stiffness of the springs"}
_UNKNOWN: Final = "unknown, as an operating point is, or the masses strike,"
_HEADS: Final = (("empty", "mm"), ("speed", "mm/s"), ("full", "mm"), ("speed", "mm/s"))
# Rows of machines side by side: labels, and where the sheet has them, empty or full.
_SIDE_BY_SIDE: Final = (
    ("f0 [Hz]", "empty", "natural_hz"),
    ("f/f0", "empty", "frequency_ratio"),
    ("setting [%]", "empty", "setting_percent"),
    ("empty [mm]", "empty", "amplitude_mm"),
    ("speed [mm/s]", "empty", "mean_velocity_mm_s"),
    ("filling [kg]", "full", "filling_kg"),
    ("full [mm]", "full", "amplitude_mm"),
    ("speed [mm/s]", "full", "mean_velocity_mm_s"),
)
# What the answer about one operating point says, with places for its numbers: pages fill them in too.
_SAYS: Final = {
    "empty": "empty",
    "when empty": "{amplitude} mm empty",
    "supplied": "{name} {percent} %",
    "springs": "f0 = {natural} Hz",
    "pack": " ({name})",
}
_FACTS: Final = {"amplitude": ("amplitude", "mm"), "machine": ("machine", "")}
_FACT_RESULTS: Final = tuple(result for result in MACHINE_RESULTS if result.is_number)
_LISTED: Final = ("strikes", "at_jump", "all_amplitudes_mm")  # in JSON alone


def machine_facts(given: GivenMachine, values: Mapping[str, Any]) -> list[Fact]:
    """Make the facts about a machine at one operating point.

    Parameters
    ----------
    given : GivenMachine
        The machine.
    values : mapping of str to array
        Quantities of a single cell by name, in the units outside.
    """
    one = {name: float(values[name].item()) for name in QUANTITIES if name in values}
    found = {x.name: float(x.kind.from_si(values[OPERATING][x.name].item())) for x in _FACT_RESULTS}
    empty = _SAYS["when empty"].format(amplitude=shown(found["amplitude_empty"]))
    note = empty if one["filling"] else _SAYS["empty"]
    supply = [name for name in ("setting", "voltage") if given.takes(name)]
    at = [_SAYS["supplied"].format(name=name, percent=f"{one[name]:g}") for name in supply]
    (label, unit), (machine, _) = _FACTS["amplitude"], _FACTS["machine"]
    facts = [
        Fact(label, one["amplitude"], unit, note=note),
        Fact(machine, ", ".join([_machine(given, one.get("natural")), *at]), is_rare=True),
    ]
    for result in _FACT_RESULTS:
        if not math.isnan(found[result.name]) and result.name != "amplitude_empty":
            label = label_of(result.column, result.kind.unit)
            facts.append(Fact(label, found[result.name], result.kind.unit, is_rare=True))
    return facts


def machine_texts() -> dict[str, Any]:
    """Return the texts of ``machine_facts`` for pages, as JSON has them; results in the unit outside."""
    from vibro.files.machines import HEAVY, HEAVY_FILLING  # late, as no other answer needs it

    results = {
        result.name: (label_of(result.column, result.kind.unit), result.kind.unit, result.kind.per_si)
        for result in _FACT_RESULTS
        if result.name != "amplitude_empty"
    }
    own = {"says": _SAYS, "facts": _FACTS, "results": results}
    heavy = {"heavy": HEAVY, "heavy filling": HEAVY_FILLING}
    return {**own, **heavy, "doubts": DOUBTS, "warned harmonic": WARNED_HARMONIC}


def _machine(given: GivenMachine, natural: float | None) -> str:
    springs = ""
    if natural is not None:
        pack = next((name for name, f0 in given.packs.items() if f0 == natural), None)
        springs = _SAYS["springs"].format(natural=f"{natural:.5g}")
        springs += "" if pack is None else _SAYS["pack"].format(name=pack)
    return ", ".join(filter(None, (springs if part is None else part for part in machine_parts(given))))


def machine_parts(given: GivenMachine) -> list[str | None]:
    """Return what a machine is in words; None where its springs belong, which may be exchanged."""
    masses = [str(given.table[key]) for key in _MASSES if key in given.table]
    weights = [m if m == "floor" else f"{float(exact_number(m, TROUGH_MASS)):g} kg" for m in masses]
    parts: list[str | None] = [given.kind, *filter(None, [" against ".join(weights)])]
    if given.has_springs:
        parts.append(None)
    elif given.kind == "unbalance":
        mounts = given.machine.natural_frequency
        parts.append(f"mounts of {mounts:.5g} Hz" if mounts else "infinitely soft mounts")
    if given.kind != "crank":
        parts.append(f"damping ratio {given.machine.damping_ratio:.4g}")
    return parts


def _resonance(empty: Row, full: Row | None) -> str:
    """Name the side of resonance, from the frequency over the natural frequency, empty and filled."""
    ratios = {"empty": empty["frequency_ratio"]} | ({"full": full["filled_frequency_ratio"]} if full else {})
    sides = (
        f"{shown(ratio)} {state}, {'below' if ratio < 1.0 else 'above' if ratio > 1.0 else 'at'} resonance"
        for state, ratio in ratios.items()
        if not math.isnan(ratio)
    )
    return f"f/f0 = {'; '.join(sides)}, at a setting of {empty['setting_percent']:g} %"


def sheet_answer(name: str, sheet: Sheet) -> Answer:
    """Make the answer of a set-up sheet.

    Parameters
    ----------
    name : str
        Of the machine.
    sheet : Sheet
        The numbers.
    """
    notes = [*sheet.doubts, *_notes(sheet)]
    tables = [_settings(sheet), _changes(sheet), _sensitivities(sheet), _packs(sheet)]
    return Answer(_facts(sheet), [table for table in tables if table.rows], notes, sheet.record, name)


def sheets_answer(sheets: Mapping[str, Sheet]) -> Answer:
    """Make the answer about several machines, by name: a column for each, at its last setting."""
    last = {name: sheet.record["settings"][-1] for name, sheet in sheets.items()}
    kinds = [sheet.request.machine.kind for sheet in sheets.values()]
    rows: list[list[Any]] = [["kind", *kinds]]
    rows += [
        [label, *((pair[state] or {}).get(key) for pair in last.values())]
        for label, state, key in _SIDE_BY_SIDE
    ]
    bounds: list[Mapping[str, Any]] = [
        next(reversed(sheet.record["bounds"]), {}) for sheet in sheets.values()
    ]
    rows += [
        [label, *(_bounds(x)[end] for x in bounds)]
        for end, label in enumerate(("slowest [mm/s]", "fastest [mm/s]"))
    ]
    rows.append(["how sure", *(_sureness(x) if "proof" in x else None for x in bounds)])
    notes = [f"{name}: {note}" for name, sheet in sheets.items() for note in sheet.doubts]
    record = {"machines": [{"name": name, **sheet.record} for name, sheet in sheets.items()]}
    table = Table("machines", [("machine", ""), *((name, "") for name in sheets)], rows)
    return Answer((), [table], notes, record, "Machines side by side")


def cases(sheets: Mapping[str, Sheet]) -> TableColumns:
    """Return all operating points as the columns of a CSV: a row for each, with its purpose."""
    rows = []
    for name, sheet in sheets.items():
        record, own = sheet.record, {"machine": name} if len(sheets) > 1 else {}
        pairs = [("setting", pair) for pair in record["settings"]]
        pairs += [(one["changed"].rpartition("_")[0], one) for one in record["changes"]]
        pairs += [(pack["name"], pack) for pack in record["packs"]]
        rows += [
            {**own, "case": case, **pair[state]}
            for case, pair in pairs
            for state in ("empty", "full")
            if pair[state]
        ]
    return columns_of([{key: x for key, x in row.items() if key not in _LISTED} for row in rows])


def picture_texts(sheet: Sheet, name: str) -> tuple[str, str]:
    """Return the headline of the picture and what holds for all of it."""
    request = sheet.request
    setting = f"setting {request.settings[-1]:g} %"
    return f"{request.machine.kind} \N{EN DASH} {name}", f"{setting}, {given_text(request.values)}"


def _facts(sheet: Sheet) -> list[Fact]:
    request, record = sheet.request, sheet.record
    given, values = request.machine, request.values
    empty, full = record["settings"][-1].values()
    bands = [
        f"{QUANTITIES[name].label} {f'{low:.15g} to ' if low < high else ''}{QUANTITIES[name].text(high)}"
        for name, (low, high) in request.bands.items()
        if high
    ]
    facts = [
        Fact("machine", _machine(given, values.get("natural"))),
        Fact("bands", ", ".join(bands) or "none, such as voltage=90:110 or filling=0:2"),
        Fact("drive", given_text(values), is_rare=True),
    ]
    if given.kind == "crank":  # which the filling does not change
        return facts
    facts.insert(2, Fact("resonance", _resonance(empty, full)))
    if full and not math.isnan(full["added_mass_share"]):
        mass, damping = (shown(100.0 * full[f"added_{of}_share"], 3) for of in ("mass", "damping"))
        acts = f"{MASS.text(request.full)}: {mass} % of it acts as mass, {damping} % as damping"
        facts.insert(3, Fact("filling", f"{acts}, at a setting of {full['setting_percent']:g} %"))
    resonant, tolerated = record["resonant_filling_kg"], record["tolerated_filling_kg"]
    none = "none" if math.isnan(resonant) else f"{shown(resonant)} kg"
    note = "changes the speed by less than 1 %"
    return [
        *facts,
        Fact("filling to resonance", none, is_rare=True),
        Fact("light filling", tolerated, "kg", note=note, is_rare=True),
    ]


def _cells(row: Row) -> list[Value]:
    low, high = row["amplitude_low_mm"], row["amplitude_high_mm"]
    amplitude = f"{shown(low)}...{shown(high)}" if shown(low) != shown(high) else row["amplitude_mm"]
    speed = uncertain(row["mean_velocity_mm_s"], row["mean_velocity_error_mm_s"])
    return ["strikes" if row["strikes"] else amplitude, speed]


def _both(pair: Mapping[str, Any]) -> list[Value]:
    return [x for state in ("empty", "full") for x in (_cells(pair[state]) if pair[state] else (None, None))]


def _settings(sheet: Sheet) -> Table:
    """List amplitude and speed of each setting, empty and full, and the bounds on the speed."""
    speeds = ("with 2nd harmonic", "slowest", "fastest")
    columns = [("setting", "%"), *_HEADS, *((name, "mm/s") for name in speeds)]
    record, rows = sheet.record, []
    for i, pair in enumerate(record["settings"]):
        bent = (pair["full"] or {}).get("mean_velocity_with_second_harmonic_mm_s", math.nan)
        bounds = _bounds(record["bounds"][i] if record["bounds"] else {})
        bounds = [None if math.isnan(bent) else bent, *bounds]
        rows.append([pair["empty"]["setting_percent"], *_both(pair), *bounds])
    full = f" and with {sheet.request.full:g} kg" if sheet.request.full else ""
    return Table("settings", columns, rows, f"Amplitude and speed, empty{full}")


def _bounds(found: Mapping[str, Any]) -> list[Value]:
    """Write the speeds of the slowest and the fastest part, rounded outwards."""
    speeds = found.get("speed_mm_s") or (None, None)
    return [None if x is None else bound(x, upper=bool(i), digits=_DIGITS) for i, x in enumerate(speeds)]


def _sureness(found: Mapping[str, Any]) -> str:
    """Say how both bounds are known."""
    return " and ".join(dict.fromkeys(_PROOFS[proof] for proof in found["proof"]))


def _notes(sheet: Sheet) -> list[str]:
    """Say for what the bounds on the speeds hold, and how sure they are."""
    sureness: dict[str, list[str]] = {}
    for one in sheet.record["bounds"]:
        proof = _sureness(one) if one["speed_mm_s"] else _UNKNOWN
        sureness.setdefault(proof, []).append(f"{one['setting_percent']:g}")
    if not sureness:
        return []
    proofs = "; ".join(f"{proof} at {', '.join(settings)} %" for proof, settings in sureness.items())
    count = max(one["operating_points_looked_at"] for one in sheet.record["bounds"])
    notes = [
        f"slowest, fastest: for all amplitudes that {count} operating points in the bands span; {proofs}"
    ]
    if min(sheet.request.band("static_friction")) < max(sheet.request.band("kinetic_friction")):
        notes.append("parts with more kinetic than static friction cannot be, and do not count")
    return notes


def _changes(sheet: Sheet) -> Table:
    rows = [["as set", *_both(sheet.record["settings"][-1])]]
    for change in sheet.record["changes"]:
        name, value = change["changed"], change["value"]
        more = 100.0 * (value / sheet.record["scene"][name] - 1.0)
        rows.append([f"{name.rpartition('_')[0]} {more:+.3g} %", *_both(change)])
    title = f"Mains, at a setting of {sheet.request.settings[-1]:g} %"
    return Table("changes", [("", ""), *_HEADS], rows, title, is_rare=True)


def _sensitivities(sheet: Sheet) -> Table:
    count = 3 if sheet.request.full else 2
    rows = [
        [_INPUTS.get(name, name), *rates.values()][:count]
        for name, rates in sheet.record["sensitivities"].items()
        if not all(map(math.isnan, rates.values()))
    ]
    columns = [("1 % more", ""), ("empty", "%"), ("full", "%")][:count]
    title = "Change of speed; none where parts hop, rest or never settle"
    return Table("sensitivities", columns, rows, title, is_rare=True)


def _packs(sheet: Sheet) -> Table:
    columns = [("springs", ""), ("f0", "Hz"), ("f/f0", ""), ("force ratio", ""), *_HEADS]
    rows = [
        [
            pack["name"],
            pack["natural_hz"],
            pack["empty"]["frequency_ratio"],
            pack["force_ratio"],
            *_both(pack),
        ]
        for pack in sheet.record["packs"]
    ]
    why = sheet.record["no_load_proof_pack"]
    title = f"Springs: {why}" if why else "Springs; the load-proof ones hold the amplitude"
    return Table("packs", columns, rows, title, is_rare=True)
