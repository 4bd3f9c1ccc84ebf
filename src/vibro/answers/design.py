"""The answer about a design: which settings of which drive guarantee a speed for all parts."""

from __future__ import annotations

import json
import math
from typing import TYPE_CHECKING, Final

from vibro.answers.answer import METRES_PER_MINUTE, Answer, Fact, Table, bound, number, shown
from vibro.core.codes import Regime
from vibro.designs.design import at_most
from vibro.designs.rows import KINDS
from vibro.files.descriptions import DESIGN_FILE
from vibro.quantities import BY_COLUMN, LEAST_SPEED, LOAD, QUANTITIES
from vibro.results.designs import DESIGN_COLUMNS
from vibro.units import LENGTH, SPEED

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator, Mapping
    from typing import Any

    from vibro.answers.answer import Value
    from vibro.designs.design import Chosen
    from vibro.designs.questions import Drive, Spec
    from vibro.results.designs import Design, DesignResult

_ALLOWED: Final = {regime.label: at_most(regime) for regime in Regime}
_DIGITS: Final = 4  # of bounds
_NOTHING: Final = 1e-6  # [%] of speed: above the rounding of finite differences
_MOST_MARGIN: Final = 10.0
_APART: Final = 1e-2  # [1] distance of the speed found from the guaranteed one at which both are shown
_UNSEEN: Final = 3.0  # -ln 5 %: what happens in none of n samples has a chance of this / n at most
# What happens beyond the end of a window of amplitudes.
_BEYOND: Final[Mapping[str, str]] = {
    "speed": "the slowest part gets too slow",
    "onset": "the last part rests",
    "back slip": "the first part slips back",
    "hop": "the first part hops",
    "limit": "the drive ends",
    "tip": "the first part lifts an edge",
    "gap": "trough and counter mass strike each other",
    "unconfirmed": "no amplitude is confirmed",
}
_OTHER_HOPS: Final = "parts hop otherwise, and too slowly"  # where they hop within the window too
_PROOFS: Final[Mapping[str, str]] = {
    "corners": "the slowest part is at the ends of all bands, along which speed only rises, or only falls",
    "proved": "boxes that cover all parts show that none is slower",
    "searched": "nothing is proved: the slowest part that was found; another part may be slower",
    "sampled": "parts hop: the slowest of sampled parts; another part may be slower",
}
# What people call the columns of designs: the usual ones, others, those where no drive meets the goal.
_USUAL: Final = {
    "amplitude_empty_mm": "empty", "speed_min_mm_s": "guaranteed", "speed_found_mm_s": "found",
    "margin": "margin", "set_by": "set by", "proof": "proof", "restitution": "restitution",
}  # fmt: skip
_RARE: Final = {
    "acceleration_g": "acceleration", "amplitude_least_mm": "least", "amplitude_most_mm": "most",
    "speed_found_mm_s": "found", "speed_nominal_mm_s": "nominal", "speed_max_mm_s": "largest",
}  # fmt: skip
_REACHED: Final = {
    "speed_min_mm_s": "guaranteed", "speed_found_mm_s": "found", "set_by": "set by",
    "frequency_needed_hz": "nearest",
    "amplitude_needed_mm": "amplitude", "stroke_needed_mm": "stroke", "motion_scale_needed": "scale",
    "restitution": "restitution",
}  # fmt: skip
_UNITS: Final = {column.name: column.unit for column in DESIGN_COLUMNS}
_IS_UPPER: Final = {
    "acceleration_g": True, "speed_max_mm_s": True, "speed_min_mm_s": False, "speed_found_mm_s": False,
    "margin": False,
}  # fmt: skip
_ASSUMED: Final = (
    "restitution: none is given, so parts that hop are computed over 0 to 0.5; give your own band in [scene]"
)
_NOMINAL: Final = "nominal: of the part in the middle of all bands"
_FILLED: Final = (
    "filling: speeds hold from the least to the most amplitude; that no voltage and filling makes others, and"
    " that the goal is kept with the second harmonic, is sampled, not proved"
)


def design_answer(
    spec: Spec, result: DesignResult, chosen: Chosen | None, question: Mapping[str, Any]
) -> Answer:
    """Make the answer to a question.

    Parameters
    ----------
    spec : Spec
        The question.
    result : DesignResult
        The designs that were found.
    chosen : Chosen or None
        The one that is described in detail; None if no design guarantees a speed.
    question : mapping
        The question as its file puts it.
    """
    tables = [*_designs(spec, result)]
    found = None
    if chosen is not None:
        tables += [_loads(chosen), _costs(chosen)]
        found = {"drive": chosen.design.drive, "design": chosen.design.design}
    goal = spec.goal.highest_regime.label
    met = [d.drive for d in _of(result, "gentlest", goal) if d.frequency_hz is not None]
    facts = [Fact("goal", _goal(spec)), Fact("met by", ", ".join(met) or "no drive")]
    facts += [*_chosen(spec, result, chosen), *_given(question)]
    choices = [{"drive": drive.name, **drive.chosen_from} for drive in spec.drives]
    record = {"met": result.met, "chosen": found, "choices": choices, **result.to_dict()}
    return Answer(facts, [table for table in tables if table.rows], _notes(spec, result), record, spec.name)


def _goal(spec: Spec) -> str:
    goal = spec.goal
    parts = [f"at least {_speed(goal.speed)} for every part"]
    if spec.length is not None:
        parts[0] += f", {_length(spec)} in {shown(spec.length / goal.speed)} s"
    parts.append(at_most(goal.highest_regime))
    if math.isfinite(goal.impact_speed):
        parts.append(f"impacts of at most {_speed(goal.impact_speed)}")
    if math.isfinite(goal.flight_fraction):
        parts.append(f"in flight at most {100.0 * goal.flight_fraction:.15g} % of the time")
    if math.isfinite(spec.stand_ratio):
        parts.append(f"upright, with the stand ratio {spec.stand_ratio:.15g}")
    return "; ".join(parts)


def goal_text(spec: Spec, chosen: Chosen) -> str:
    """Say what is wanted, and if the chosen design misses it, for headings of pictures."""
    met = (chosen.design.speed_min_mm_s or 0.0) >= SPEED.from_si(spec.goal.speed)
    return f"goal: {_goal(spec)}{'' if met else ' (not met)'}"


def _given(question: Mapping[str, Any]) -> Iterator[Fact]:
    """Repeat the tables of the question, but for the goal, and say what a number alone means."""
    for name, tables in question.items():
        entries = DESIGN_FILE.tables[name].entries
        for table in tables if isinstance(tables, list) else [tables] * (name != "goal"):
            plain = {key: entries[key].form.plain(value) for key, value in table.items()}
            pairs = (f"{key} = {json.dumps(value, ensure_ascii=False)}" for key, value in plain.items())
            yield Fact(name, ", ".join(pairs), is_rare=True)


def _chosen(spec: Spec, result: DesignResult, chosen: Chosen | None) -> Iterator[Fact]:
    """Tell what the chosen design promises, and what keeps it."""
    if chosen is None:
        yield Fact("design", "none: no setting of any drive guarantees a speed")
        return
    design, machine = chosen.design, chosen.drive.machine
    settings = ", ".join(_setting(design, given.name) for given in chosen.drive.inputs.values())
    yield Fact("design" if result.met else "closest", f"{design.drive}, {design.design}: {settings}")
    speed = design.speed_min_mm_s
    if speed is None:
        yield Fact("every part", "no speed is guaranteed")
    else:
        rate = bound(METRES_PER_MINUTE * speed, "m/min", upper=False, digits=_DIGITS)
        least = bound(speed, "mm/s", upper=False, digits=_DIGITS)
        bounces = f"restitution {design.restitution}" if design.restitution else ""
        rate = "; ".join(filter(None, [rate, bounces]))
        if design.is_guaranteed:
            yield Fact("every part", f"at least {least}", note=rate)
        else:
            among = f"of {design.samples} sampled" if design.samples else "found"
            yield Fact("slowest part", f"{least} {among}, not guaranteed", note=rate)
    if design.traverse_time_max_s is not None:
        time = bound(design.traverse_time_max_s, "s", upper=True, digits=_DIGITS)
        yield Fact("traverse time", f"{'at most ' * design.is_guaranteed}{time} over {_length(spec)}")
    if machine is not None and machine.has_bands:
        least, most = (shown(x or 0.0) for x in (design.amplitude_least_mm, design.amplitude_most_mm))
        yield Fact("amplitude", f"{least} ... {most} mm over voltage and filling")
    if machine is None or not machine.is_filled:  # a filling changes other amplitudes in another proportion
        yield _window(design)
    if spec.has_bands:
        yield _margin(design)
    if design.throw_number_max is not None:
        throw = bound(design.throw_number_max, upper=True, digits=_DIGITS)
        yield Fact("throw number", f"at most {throw}", is_rare=True)


def _setting(design: Design, name: str) -> str:
    """Write a quantity with all its digits, so that typed in it holds."""
    quantity = QUANTITIES[name]
    return f"{quantity.label} {_exact(getattr(design, quantity.column))} {quantity.unit}".rstrip()


def _window(design: Design) -> Fact:
    """Tell which amplitudes, or scales, keep the guarantee at the same frequency and drive angle."""
    sizes = {"motion_scale": "", "stroke_mm": " mm", "amplitude_mm": " mm"}
    size = next((name for name in sizes if getattr(design, name) is not None), "amplitude_mm")
    label = QUANTITIES[size.removesuffix("_mm")].label
    if design.window is None:
        return Fact(label, "none keeps the goal")
    beyond = {**_BEYOND, "hop": _OTHER_HOPS} if (design.throw_number_max or 0.0) > 1.0 else _BEYOND
    below, above = (beyond.get(end or "", end or "") for end in (design.low_set_by, design.high_set_by))
    low, high = (float(bound(x, upper=not i, digits=_DIGITS)) for i, x in enumerate(design.window))
    own = design.nominal or low
    ends = dict.fromkeys(map(_exact, (min(low, own), max(high, own))))  # rounded not past the design itself
    along = " along, the normal one in proportion," if design.along_amplitude_mm else ""
    keeps = f"{' ... '.join(ends)}{sizes[size]}{along} keeps the goal"
    return Fact(label, keeps, note=f"below, {below}; above, {above}")


def _margin(design: Design) -> Fact:
    """Tell how much wider all that is unknown may be."""
    if design.margin is None:
        return Fact("margin", "none", note="even without bands and drifts the goal is missed")
    may = "may be that many times as wide" if design.margin >= 1.0 else "would have to shrink to this share"
    least = bound(min(design.margin, _MOST_MARGIN), upper=False, digits=_DIGITS)
    more = " or more" if design.margin >= _MOST_MARGIN else ""
    but = " but that of restitution" if design.restitution else ""
    return Fact("margin", f"{least}{more}", note=f"all bands and drifts{but} {may}")


def _designs(spec: Spec, result: DesignResult) -> Iterator[Table]:
    """Make the tables of designs: the fastest if none meets the goal, and those of each drive."""
    goal = spec.goal.highest_regime.label
    if not result.met:
        reached = {(design.drive, ""): design for design in _of(result, "fastest", goal)}
        yield _table(
            "The fastest of each drive, and the nearest drive that meets the goal", _REACHED, reached
        )
    # without uncertainty no design is safer than another
    kinds = KINDS if spec.has_bands else KINDS[:2]
    for drive in spec.drives:
        found = {
            (d.design, "" if d.highest_regime == goal else _ALLOWED[d.highest_regime]): d
            for d in result.designs
            if d.drive == drive.name and d.design in kinds and d.frequency_hz is not None
        }
        missed = ("fastest", "") in found and ("gentlest", "") not in found
        title = f"{drive.name}{f' (less than {_speed(spec.goal.speed)})' * missed}: {_choices(drive)}"
        quantities = [given.quantity for given in drive.inputs.values()]
        settings = {quantity.column: quantity.label for quantity in quantities}
        yield _table(title, {**settings, **_USUAL}, found)
        yield _table(f"{drive.name}, other numbers ({_NOMINAL})", _RARE, found, is_rare=True)


def _choices(drive: Drive) -> str:
    """Say what may be chosen of a drive."""
    quantities = {q.column: q for q in (*(given.quantity for given in drive.inputs.values()), LOAD)}
    return ", ".join(
        f"{quantities[key].label} {choice} {quantities[key].unit}".rstrip()
        for key, choice in drive.chosen_from.items()
    )


def _table(
    title: str,
    columns: Mapping[str, str],
    designs: Mapping[tuple[str, str], Design],
    *,
    is_rare: bool = False,
) -> Table:
    """Make a table of some columns of designs, by what people call them; JSON has them already.

    Each is named by its kind, or drive, and by what may happen, if that is another regime than the goal's.
    Those with the same values are one row.
    """
    heads = [("design", ""), *((label, _UNITS.get(column, "")) for column, label in columns.items())]
    same: dict[tuple[Value, ...], dict[str, list[str]]] = {}
    for (kind, allowed), design in designs.items():
        cells = tuple(_cell(column, _value(design, column, is_rare=is_rare)) for column in columns)
        same.setdefault(cells, {}).setdefault(allowed, []).append(kind)
    rows = [
        ("; ".join(", ".join(filter(None, [*kinds, allowed])) for allowed, kinds in names.items()), *cells)
        for cells, names in same.items()
    ]
    return Table("designs", heads, rows, title, is_rare)


def _value(design: Design, column: str, *, is_rare: bool) -> Value:
    """Return a value of a table: a speed is guaranteed, or found; both where they differ much."""
    value: Value = getattr(design, column)
    least, found = design.speed_min_mm_s, design.speed_found_mm_s
    if column == "speed_min_mm_s" and not design.is_guaranteed:
        return None
    if column == "speed_found_mm_s" and design.is_guaranteed and not is_rare:
        return value if abs((found or 0.0) - (least or 0.0)) > _APART * abs(found or 0.0) else None
    return value


def _cell(column: str, value: Value) -> Value:
    """Write bounds rounded so that they hold, and settings as they are typed in."""
    if isinstance(value, float) and column in _IS_UPPER:
        return bound(value, upper=_IS_UPPER[column], digits=_DIGITS)
    return _exact(value) if isinstance(value, float) and column in BY_COLUMN else value


def _loads(chosen: Chosen) -> Table:
    """Tell where regimes begin: above 1 they have."""
    title = "Acceleration over that at which it begins: above 1 it has begun"
    return Table("loads", [("begins", ""), ("ratio", "")], [*chosen.loads.items()], title, is_rare=True)


def _costs(chosen: Chosen) -> Table:
    """Tell what the nominal speed depends on."""
    rows = [
        (
            field.removesuffix("_deg").replace("_", " "),
            cost if isinstance(cost, str) or abs(cost) > _NOTHING else 0.0,
        )
        for field, cost in chosen.costs.items()
    ]
    columns = [("input", ""), ("nominal speed", "%")]
    bounces = ", restitution by 0.01" * ("restitution" in chosen.costs)
    return Table(
        "costs", columns, rows, f"Each input 1 % larger, angles by 1 deg{bounces} ({_NOMINAL})", is_rare=True
    )


def _notes(spec: Spec, result: DesignResult) -> list[str]:
    """Explain where no speed is guaranteed, the proofs, and the doubts."""
    lines = []
    known = {design.drive for design in result.designs if design.frequency_hz is not None}
    # a drive with a table says in its title what may be chosen
    asked = {drive.name: f" ({_choices(drive)})" for drive in spec.drives if drive.name not in known}
    for design in result.designs:
        if design.design == "fastest" and design.frequency_hz is None:
            # a search that the filling ends has not shown that there is none
            why = "none was found that holds" if design.set_by == "filling" else "no speed is guaranteed"
            by = f", set by {design.set_by}" if design.set_by else ""
            drive = f"{design.drive}{asked.get(design.drive, '')}"
            lines.append(f"{drive}, {_ALLOWED[design.highest_regime]}: {why}{by}")
    proofs = {d.proof for d in result.designs}
    lines += [f"{name}: {text}" for name, text in _PROOFS.items() if name in proofs]
    if any(d.restitution_assumed for d in result.designs):
        lines.append(_ASSUMED)
    if samples := min((d.samples for d in result.designs if d.samples), default=0):
        lines.append(
            f"samples: of {samples} hopping parts, spread evenly, none is slower: one drawn at random is "
            f"with a chance of at most {100.0 * _UNSEEN / samples:.2g} % (confidence 95 %)"
        )
    if any(d.operating_points is not None for d in result.designs):
        lines.append(_FILLED)
    if several := _all_called(d for d in result.designs if (d.operating_points or 0) > 1):
        lines.append(
            "some filling has several amplitudes; the least, which is reached when the feeder is switched on,"
            f" is covered: {several}"
        )
    if coexists := _all_called(d for d in result.designs if d.coexists):
        lines.append(f"disturbed parts can settle into another motion than those from rest: {coexists}")
    if excluded := [d for d in result.designs if d.excluded]:
        most = max(d.excluded or 0 for d in excluded)
        lines.append(f"samples without a speed are left out, up to {most} of: {_all_called(excluded)}")
    return lines


def _all_called(designs: Iterable[Design]) -> str:
    return "; ".join(f"{d.drive}, {d.highest_regime}, {d.design}" for d in designs)


def _of(result: DesignResult, kind: str, regime: str) -> list[Design]:
    """Return a kind of design of all drives."""
    return [d for d in result.designs if (d.design, d.highest_regime) == (kind, regime)]


def _speed(speed: float) -> str:
    return number(SPEED.from_si(speed), LEAST_SPEED.unit)


def _length(spec: Spec) -> str:
    assert spec.length is not None
    return QUANTITIES["trough_length"].text(LENGTH.from_si(spec.length))


def _exact(value: float) -> str:
    """Write a setting with all its digits."""
    return repr(float(value)).removesuffix(".0")
