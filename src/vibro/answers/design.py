"""The answer about a design: which settings of which drive guarantee a speed for all parts."""

from __future__ import annotations

import math
from decimal import ROUND_CEILING, ROUND_FLOOR, Context
from typing import TYPE_CHECKING, Final

from vibro.answers.answer import Answer, Fact, Table, shown
from vibro.core.codes import Regime
from vibro.inverse.designs import at_most
from vibro.inverse.rows import KINDS
from vibro.quantities import BY_COLUMN, LENGTH, QUANTITIES, SPEED
from vibro.results.designs import DESIGN_COLUMNS

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator, Mapping

    from vibro.answers.answer import Value
    from vibro.inverse.designs import Chosen
    from vibro.inverse.specs import Drive, Spec
    from vibro.results.designs import Design, DesignResult

_REGIMES: Final = (Regime.FORWARD_SLIP, Regime.BACK_SLIP, Regime.HOPPING)
_DIGITS: Final = 4  # of bounds
_NOTHING: Final = 1e-6  # [%] of speed: above the rounding of finite differences
_MOST_MARGIN: Final = 10.0
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
    "corners": "the slowest part is at the ends of all bands, along which speeds are monotone",
    "proved": "boxes that cover all parts show that none is slower by more than 1 %",
    "searched": "the slowest part that was found; that none is slower by more than 1 % is not proved",
    "sampled": "parts hop: the slowest of sampled parts; another part may be slower",
}
# Columns of designs, by what people call them; whether a bound is an upper one.
_USUAL: Final = (
    ("guaranteed", "speed_min_mm_s"), ("margin", "margin"), ("set by", "set_by"), ("proof", "proof"),
)  # fmt: skip
_RARE: Final = (
    ("acceleration", "acceleration_g"),
    ("amplitude, empty", "amplitude_empty_mm"),
    ("amplitude, least", "amplitude_least_mm"),
    ("amplitude, most", "amplitude_most_mm"),
    ("proved above", "speed_proved_mm_s"),
    ("nominal", "speed_nominal_mm_s"),
    ("largest", "speed_max_mm_s"),
)
_UNITS: Final = {column.name: column.unit for column in DESIGN_COLUMNS}
_BOUNDS: Final = {
    "acceleration_g": True, "speed_max_mm_s": True, "speed_min_mm_s": False, "speed_proved_mm_s": False,
    "margin": False,
}  # fmt: skip
_FILLED: Final = (
    "filling: speeds hold from the least to the most amplitude; that no voltage and filling makes others, and"
    " that the goal is kept with the second harmonic, is sampled, not proved"
)


def design_answer(spec: Spec, result: DesignResult, chosen: Chosen | None, title: str) -> Answer:
    """Make the answer to a question.

    Parameters
    ----------
    spec : Spec
        The question.
    result : DesignResult
        The designs that were found.
    chosen : Chosen or None
        The one that is told in detail; None if no design guarantees a speed.
    title : str
        Of its page.
    """
    tables = [] if result.met else [_closest(spec, result)]
    for drive in spec.drives:
        tables += _designs(spec, result, drive)
    found = None
    if chosen is not None:
        tables += [_loads(chosen), _costs(chosen)]
        found = {"drive": chosen.design.drive, "design": chosen.design.design}
    designs = result.to_dict()["designs"]
    return Answer(
        [*_question(spec, result), *_chosen(spec, result, chosen), *_given(spec, result)],
        [table for table in tables if table.rows],
        _notes(result),
        {"met": result.met, "chosen": found, "designs": designs},
        title,
    )


def _question(spec: Spec, result: DesignResult) -> list[Fact]:
    met = [d.drive for d in _of(result, "gentlest", spec.goal.highest_regime) if d.frequency_hz is not None]
    return [Fact("goal", _goal(spec)), Fact("met by", ", ".join(met) or "no drive")]


def _goal(spec: Spec) -> str:
    goal = spec.goal
    parts = [f"at least {_speed(goal.speed)} for every part"]
    if spec.length is not None:
        time = shown(spec.length / goal.speed)
        parts[0] += f", {_typed(LENGTH.from_si(spec.length))} mm in {time} s"
    parts.append(at_most(goal.highest_regime))
    if math.isfinite(goal.impact_speed):
        parts.append(f"impacts of at most {_speed(goal.impact_speed)}")
    if math.isfinite(goal.flight_fraction):
        parts.append(f"in flight at most {_typed(100.0 * goal.flight_fraction)} % of the time")
    if math.isfinite(spec.stand_ratio):
        parts.append(f"upright, with the stand ratio {_typed(spec.stand_ratio)}")
    return "; ".join(parts)


def goal_text(spec: Spec, chosen: Chosen) -> str:
    """Say what is wanted, and if the chosen design misses it, for headings of pictures."""
    met = (chosen.design.speed_min_mm_s or 0.0) >= SPEED.from_si(spec.goal.speed)
    return f"goal: {_goal(spec)}{'' if met else ' (not met)'}"


def _given(spec: Spec, result: DesignResult) -> list[Fact]:
    """Tell what the question says of parts, trough and drives."""
    hops = any(d.highest_regime == Regime.HOPPING.label for d in result.designs)
    trough = [_span("trough_angle", spec.bands.get("trough_angle", (0.0, 0.0)))]
    if spec.length is not None:
        trough.append(_span("trough_length", (spec.length, spec.length)))
    for name in ("gravity", "restitution"):
        value = getattr(spec, name)
        if value != QUANTITIES[name].default or (hops and name == "restitution"):
            trough.append(_span(name, (value, value)))
    frictions = [_span(name, spec.bands[name]) for name in spec.bands if "friction" in name]
    pairs = [("parts", frictions), ("trough", trough), ("drift", _drift(spec) or ["none"])]
    pairs += [(drive.name, _limits(drive)) for drive in spec.drives]
    return [Fact(label, ", ".join(texts), is_rare=True) for label, texts in pairs]


def _drift(spec: Spec) -> list[str]:
    drift = spec.drift
    sizes = {
        "amplitude": (100.0 * drift.amplitude, "%"),
        "frequency": (100.0 * drift.frequency, "%"),
        "drive angle": (math.degrees(drift.drive_angle), "deg"),
        "trough angle": (math.degrees(drift.trough_angle), "deg"),
        "phase": (math.degrees(drift.normal_phase), "deg"),
    }
    return [f"{name} ± {_typed(size)} {unit}" for name, (size, unit) in sizes.items() if size]


def _limits(drive: Drive) -> list[str]:
    """Say what a drive can do."""
    parts = []
    for knob, name in zip(drive.space.knobs, drive.told, strict=True):
        quantity, scale = QUANTITIES[name], drive.scale(knob)
        spans = [(low * scale, high * scale) for low, high in drive.choices[knob]]
        if knob == "amplitude" and spans[0][0] == 0.0:
            most = f"{_typed(quantity.from_si(spans[0][1]))} {quantity.unit}"
            parts.append(f"{quantity.label} up to {most}")
            continue
        texts = [_span(name, span).removeprefix(f"{quantity.label} ") for span in spans]
        parts.append(f"{quantity.label} {' or '.join(texts)}")
    machine = drive.machine
    limit = drive.acceleration if machine is None else machine.acceleration
    if math.isfinite(limit):
        parts.append(f"acceleration up to {_typed(limit)} g")
    if machine is not None:
        parts[1:1] = [f"{shown(LENGTH.from_si(machine.full_amplitude))} mm empty at 100 %"]
        parts += [f"springs of {_typed(f0)} Hz" for f0 in [machine.natural_frequency] if f0 is not None]
        bands = {"voltage": (machine.voltage, (1.0, 1.0)), "filling": (machine.filling, (0.0, 0.0))}
        parts += [_span(name, band) for name, (band, usual) in bands.items() if band != usual]
    return parts


def _chosen(spec: Spec, result: DesignResult, chosen: Chosen | None) -> Iterator[Fact]:
    """Tell what the chosen design promises, and what keeps it."""
    if chosen is None:
        yield Fact("design", "none: no setting of any drive guarantees a speed")
        return
    design, machine = chosen.design, chosen.drive.machine
    yield Fact("design" if result.met else "closest", f"{design.drive}, {design.design}: {_setting(design)}")
    speed = design.speed_min_mm_s
    if speed is None:
        yield Fact("every part", "no speed is guaranteed")
    else:
        rate = _bound(0.06 * speed, upper=False)
        yield Fact("every part", f"at least {_bound(speed, upper=False)} mm/s", note=f"{rate} m/min")
    if design.traverse_time_max_s is not None and spec.length is not None:
        time = _bound(design.traverse_time_max_s, upper=True)
        yield Fact("traverse time", f"at most {time} s over {_typed(LENGTH.from_si(spec.length))} mm")
    if machine is not None and machine.has_bands:
        least, most = (shown(x or 0.0) for x in (design.amplitude_least_mm, design.amplitude_most_mm))
        yield Fact("amplitude", f"{least} ... {most} mm over voltage and filling")
    if machine is None or not machine.is_filled:  # a filling changes other amplitudes in another proportion
        yield _window(design)
    if spec.has_bands:
        yield _margin(design)
    if design.throw_number_max is not None:
        yield Fact("throw number", f"at most {_bound(design.throw_number_max, upper=True)}", is_rare=True)


def _setting(design: Design) -> str:
    """Write a setting with all its digits, so that typed in it holds."""
    if design.setting_percent is not None:
        parts = [
            f"setting {_exact(design.setting_percent)} %",
            f"{shown(design.amplitude_empty_mm)} mm empty",
        ]
    elif design.motion_scale is not None:
        parts = [f"scale {_exact(design.motion_scale)}"]
    elif design.drive_angle_deg is not None:
        parts = [f"{_exact(design.nominal)} mm{' stroke' if design.stroke_mm is not None else ''}"]
    else:
        along, normal = _exact(design.along_amplitude_mm), _exact(design.normal_amplitude_mm)
        parts = [f"{along} mm along, {normal} mm normal, phase {_exact(design.normal_phase_deg)} deg"]
    parts.append(f"{_exact(design.frequency_hz)} Hz")
    if design.drive_angle_deg is not None and design.motion_scale is None:
        parts.append(f"{_exact(design.drive_angle_deg)} deg")
    return ", ".join(parts)


def _window(design: Design) -> Fact:
    """Tell which amplitudes, or scales, keep the guarantee at the same frequency and drive angle."""
    label = _size_of(design)
    if design.window is None:
        return Fact(label, "none keeps the goal")
    low, high = design.window
    beyond = {**_BEYOND, "hop": _OTHER_HOPS} if (design.throw_number_max or 0.0) > 1.0 else _BEYOND
    below, above = (beyond.get(end or "", end or "") for end in (design.low_set_by, design.high_set_by))
    # rounded inwards, but not past the design itself
    own = design.nominal or low
    first = _exact(own) if float(_bound(low, upper=True)) > own else _bound(low, upper=True)
    last = _exact(own) if float(_bound(high, upper=False)) < own else _bound(high, upper=False)
    unit = "" if design.motion_scale is not None else " mm"
    if (first, design.low_set_by, design.high_set_by) == (last, "limit", "limit"):
        return Fact(label, f"{first}{unit} keeps the goal", note="all that the drive can do")
    along = " along, the normal one in proportion," if design.along_amplitude_mm else ""
    keeps = f"{first} ... {last}{unit}{along} keeps the goal"
    return Fact(label, keeps, note=f"below, {below}; above, {above}")


def _margin(design: Design) -> Fact:
    """Tell how much wider all that is unknown may be."""
    if design.margin is None:
        return Fact("margin", "none", note="even without bands and drifts the goal is missed")
    may = "may be that many times as wide" if design.margin >= 1.0 else "would have to shrink to this share"
    text = (
        f"{_MOST_MARGIN:g} or more" if design.margin >= _MOST_MARGIN else _bound(design.margin, upper=False)
    )
    return Fact("margin", text, note=f"all bands and drifts {may}")


def _closest(spec: Spec, result: DesignResult) -> Table:
    """Tell what each drive reaches, within the next regimes too, and the drive that would meet the goal."""
    highest = spec.goal.highest_regime
    answered = {design.highest_regime for design in result.designs}
    higher = [regime for regime in _REGIMES if regime > highest and regime.label in answered]
    others = [{d.drive: d.speed_min_mm_s for d in _of(result, "fastest", regime)} for regime in higher]
    # another frequency changes the amplitude of these
    tuned = {d.name for d in spec.drives if d.machine is not None and not d.machine.is_plain}
    rows = [
        (
            design.drive,
            *(
                _bound(speed, upper=False)
                for speed in (design.speed_min_mm_s, *(o[design.drive] for o in others))
            ),
            design.set_by or "-",
            "not computed for machines" if design.drive in tuned else _needed(design),
        )
        for design in _of(result, "fastest", highest)
    ]
    speeds = [(regime.label, "mm/s") for regime in (highest, *higher)]
    columns = [("drive", ""), *speeds, ("set by", ""), ("nearest drive that meets the goal", "")]
    return Table("designs", columns, rows, title="Guaranteed speed that each drive reaches")


def _needed(design: Design) -> str:
    """Write the nearest drive that meets the goal."""
    if design.frequency_needed_hz is None:
        return "-"
    frequency = f"{_exact(design.frequency_needed_hz)} Hz"
    if design.motion_scale is not None:
        return f"{frequency}, scale {_exact(design.motion_scale_needed)}"
    size = f"{_exact(design.amplitude_needed_mm or design.stroke_needed_mm)} mm"
    if design.drive_angle_deg is not None:
        stroke = " stroke" if design.stroke_needed_mm is not None else ""
        return f"{frequency}, {size}{stroke} at {_exact(design.drive_angle_deg)} deg"
    phase = _exact(design.normal_phase_deg)
    return f"{frequency}, {size} along, the rest in proportion, at {phase} deg"


def _designs(spec: Spec, result: DesignResult, drive: Drive) -> Iterator[Table]:
    """Make the tables of a drive: its designs, those of the goal's regime first, and their other numbers."""
    highest = spec.goal.highest_regime.label
    # without uncertainty no design is safer than another
    kinds = KINDS if spec.has_bands else KINDS[:2]
    found = [
        design
        for design in result.designs
        if (design.drive, design.design in kinds, design.frequency_hz is None) == (drive.name, True, False)
    ]
    settings = [(QUANTITIES[name].label, QUANTITIES[name].column) for name in drive.told]
    own = [design.design for design in found if design.highest_regime == highest]
    missed = "" if "gentlest" in own or not own else f", less than {_speed(spec.goal.speed)}"
    for title, columns in (
        (f"{drive.name}{missed}", [*settings, *_USUAL]),
        (f"{drive.name}, other numbers", [*_RARE]),
    ):
        known = [
            pair
            for pair in columns
            if pair in settings or any(getattr(d, pair[1]) is not None for d in found)
        ]
        rows = [
            (
                d.design if d.highest_regime == highest else f"{d.design}, {_allowed(d)}",
                *(_cell(column, getattr(d, column)) for _, column in known),
            )
            for d in found
        ]
        heads = [(label, _UNITS[column]) for label, column in known]
        # JSON has them already
        yield Table("designs", [("design", ""), *heads], rows, title, is_rare=columns == [*_RARE])


def _cell(column: str, value: Value) -> Value:
    """Write bounds rounded so that they hold, and settings as they are typed in."""
    if isinstance(value, float) and column in _BOUNDS:
        return _bound(value, upper=_BOUNDS[column])
    if isinstance(value, float) and column in BY_COLUMN:
        return _exact(value)
    return "-" if value is None else value


def _loads(chosen: Chosen) -> Table:
    """Tell where regimes begin: above 1 they have."""
    columns = [("begins", ""), ("load over its load", "")]
    return Table("loads", columns, [*chosen.loads.items()], "Above 1 it has begun", is_rare=True)


def _costs(chosen: Chosen) -> Table:
    """Tell what the nominal speed depends on."""

    def name(field: str) -> str:
        known = field.removesuffix("_deg").replace("_", " ")
        return _size_of(chosen.design) if known in ("amplitude", "motion scale") else known

    rows = [
        (name(field), cost if isinstance(cost, str) or abs(cost) > _NOTHING else 0.0)
        for field, cost in chosen.costs.items()
    ]
    columns = [("input", ""), ("nominal speed", "%")]
    return Table("costs", columns, rows, "Each input 1 % larger, angles by 1 deg", is_rare=True)


def _notes(result: DesignResult) -> list[str]:
    """Explain where no speed is guaranteed, the proofs, and the doubts."""
    lines = []
    for design in result.designs:
        if design.design == "fastest" and design.frequency_hz is None:
            # a search that the filling ends has not shown that there is none
            why = "none was found that holds" if design.set_by == "filling" else "no speed is guaranteed"
            by = f", set by {design.set_by}" if design.set_by else ""
            lines.append(f"{design.drive}, {_allowed(design)}: {why}{by}")
    proofs = {d.proof for d in result.designs}
    lines += [f"{name}: {text}" for name, text in _PROOFS.items() if name in proofs]
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


def _allowed(design: Design) -> str:
    return at_most(next(regime for regime in _REGIMES if regime.label == design.highest_regime))


def _of(result: DesignResult, kind: str, regime: Regime) -> list[Design]:
    """Return a kind of design of all drives."""
    return [d for d in result.designs if d.design == kind and d.highest_regime == regime.label]


def _size_of(design: Design) -> str:
    """Name the quantity of the printed amplitudes of a design."""
    if design.motion_scale is not None:
        return "scale"
    return "amplitude" if design.stroke_mm is None else "stroke"


def _speed(speed: float) -> str:
    return f"{_typed(SPEED.from_si(speed))} {SPEED.unit}"


def _span(name: str, span: tuple[float, float]) -> str:
    quantity = QUANTITIES[name]
    ends = dict.fromkeys(_typed(quantity.from_si(end)) for end in span)
    return f"{quantity.label} {' ... '.join(ends)} {quantity.unit}".rstrip()


def _typed(value: float) -> str:
    """Write a number as it was given: nobody writes more than 15 digits."""
    return f"{value:.15g}"


def _exact(value: float | None) -> str:
    """Write a setting with all its digits."""
    return "-" if value is None else repr(float(value)).removesuffix(".0")


def _bound(value: float | None, *, upper: bool) -> str:
    """Write a bound, rounded so that it still holds."""
    if value is None:
        return "-"
    rounding = ROUND_CEILING if upper else ROUND_FLOOR
    return shown(float(Context(prec=_DIGITS, rounding=rounding).create_decimal(repr(float(value)))))
