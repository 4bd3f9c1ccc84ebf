"""What ``vibro design`` prints: the question, all designs, and what is to be known of the chosen one."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Final

from vibro.cli.report import aligned, bound
from vibro.core.codes import Regime
from vibro.quantities import LENGTH, QUANTITIES, SPEED
from vibro.sweeps.one_scene import number

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping

    from vibro.inverse.designs import Chosen
    from vibro.inverse.specs import Drive, Spec
    from vibro.results.designs import Design, DesignResult

__all__ = ["design_report"]

_REGIMES: Final = (Regime.FORWARD_SLIP, Regime.BACK_SLIP, Regime.HOPPING)
_NEARLY: Final = 0.999  # throw number of a setting that is about to hop
_NONE: Final = "-"
# Heads of a setting, by its knobs.
_HEAD_OF: Final = {
    "amplitude": "amplitude",
    "along_amplitude": "along",
    "normal_amplitude": "normal",
    "normal_phase": "phase",
    "frequency": "frequency",
    "drive_angle": "angle",
}
_HEADS: Final = tuple(
    zip(
        ("accel.", "[g]"),
        ("guaranteed", "[mm/s]"),
        ("nominal", "[mm/s]"),
        ("largest", "[mm/s]"),
        ("margin", ""),
        ("set by", ""),
        ("proof", ""),
        strict=True,
    )
)
_MOST_MARGIN: Final = 10.0
# What happens beyond the end of a window of amplitudes.
_BEYOND: Final[Mapping[str, str]] = {
    "speed": "the slowest part gets too slow",
    "onset": "the last part rests",
    "back slip": "the first part slips back",
    "hop": "the first part hops",
    "limit": "the drive ends",
    "tip": "the first part lifts an edge",
    "unconfirmed": "no amplitude is confirmed",
}
_PROOFS: Final[Mapping[str, str]] = {
    "corners": "speeds are monotone along every band (measured over drive angles, else proven)",
    "searched": "bounds found by searches with several seeds, and checked by looking for a worse part",
    "sampled": "parts hop: bounds of sampled parts and settings, which another part may miss",
}


def design_report(spec: Spec, result: DesignResult, chosen: Chosen | None) -> str:
    """Write the answer to a question for people.

    Parameters
    ----------
    spec : Spec
        The question.
    result : DesignResult
        Its answer.
    chosen : Chosen or None
        The design that is told more of; None where nothing is guaranteed anywhere.

    Returns
    -------
    str
        Settings with all their digits, so that typed in they hold; other numbers with at most six, and bounds
        among them rounded so that they hold too.
    """
    parts = [_question(spec, result)]
    if not result.met:
        parts.append(_closest(spec, result))
    parts += [_table(drive, spec, result) for drive in spec.drives]
    if chosen is not None:
        parts += _chosen(spec, chosen, met=result.met)
    parts += _remarks(result)
    return "\n\n".join(parts)


def _question(spec: Spec, result: DesignResult) -> str:
    met = [d.drive for d in _of(result, "gentlest", spec.goal.highest_regime) if d.frequency_hz is not None]
    facts = [
        ("goal", _goal(spec)),
        ("met by", ", ".join(met) or "no drive"),
        ("parts", ", ".join(_span(name, spec.bands[name]) for name in spec.bands if "friction" in name)),
        ("trough", ", ".join(_trough(spec))),
        ("drift", ", ".join(_drift(spec)) or "none"),
    ]
    return aligned(facts, right=False)


def _goal(spec: Spec) -> str:
    goal = spec.goal
    parts = [f"at least {_speed(goal.speed)} for every part"]
    if spec.length is not None:
        parts[0] += (
            f", {number(LENGTH.from_si(spec.length), 'mm')} in {number(spec.length / goal.speed, 's')}"
        )
    parts.append(_at_most(goal.highest_regime))
    if math.isfinite(goal.impact_speed):
        parts.append(f"impacts of at most {_speed(goal.impact_speed)}")
    if math.isfinite(goal.flight_fraction):
        parts.append(f"in flight at most {number(100.0 * goal.flight_fraction)} % of the time")
    if math.isfinite(spec.stand_ratio):
        parts.append(f"upright, with the stand ratio {number(spec.stand_ratio)}")
    return "; ".join(parts)


def _at_most(regime: Regime) -> str:
    return "hopping allowed" if regime is Regime.HOPPING else f"{regime.label} at most"


def _speed(speed: float) -> str:
    return number(SPEED.from_si(speed), SPEED.unit)


def _span(name: str, span: tuple[float, float]) -> str:
    quantity = QUANTITIES[name]
    ends = dict.fromkeys(number(quantity.from_si(end)) for end in span)
    return f"{quantity.label} {' ... '.join(ends)} {quantity.unit}".rstrip()


def _trough(spec: Spec) -> list[str]:
    parts = [_span("trough_angle", spec.bands.get("trough_angle", (0.0, 0.0)))]
    if spec.length is not None:
        parts.append(_span("trough_length", (spec.length, spec.length)))
    for name in ("gravity", "restitution"):
        value = getattr(spec, name)
        if value != QUANTITIES[name].default:
            parts.append(_span(name, (value, value)))
    return parts


def _drift(spec: Spec) -> list[str]:
    drift = spec.drift
    sizes = {
        "amplitude": (100.0 * drift.amplitude, "%"),
        "frequency": (100.0 * drift.frequency, "%"),
        "drive angle": (math.degrees(drift.drive_angle), "deg"),
        "trough angle": (math.degrees(drift.trough_angle), "deg"),
        "phase": (math.degrees(drift.normal_phase), "deg"),
    }
    return [f"{name} +- {number(size, unit)}" for name, (size, unit) in sizes.items() if size]


def _of(result: DesignResult, kind: str, regime: Regime) -> list[Design]:
    """Return a kind of design of all drives."""
    return [d for d in result.designs if d.design == kind and d.highest_regime == regime.label]


def _closest(spec: Spec, result: DesignResult) -> str:
    """Say what each drive reaches, what the next regimes would give, and which drive would do."""
    highest = spec.goal.highest_regime
    higher = [regime for regime in _REGIMES if regime > highest]
    nearest = "nearest drive that meets the goal"
    rows = [("largest guaranteed", _at_most(highest), "set by", *(r.label for r in higher), nearest)]
    others = [{d.drive: d for d in _of(result, "fastest", regime)} for regime in higher]
    for design in _of(result, "fastest", highest):
        needed = _NONE
        if design.frequency_needed_hz is not None and design.amplitude_needed_mm is not None:
            frequency, amplitude = _exact(design.frequency_needed_hz), _exact(design.amplitude_needed_mm)
            needed = f"{frequency} Hz, {amplitude} mm"
            if design.drive_angle_deg is not None:
                needed += f" at {_exact(design.drive_angle_deg)} deg"
            else:
                needed += f" along, the rest in proportion, at {_exact(design.normal_phase_deg)} deg"
        reached = [_least(design), design.set_by or _NONE, *(_least(other[design.drive]) for other in others)]
        rows.append((design.drive, *reached, needed))
    return aligned(rows)


def _least(design: Design) -> str:
    speed = design.speed_min_mm_s
    return "nothing" if speed is None else bound(speed, SPEED.unit, upper=False)


def _table(drive: Drive, spec: Spec, result: DesignResult) -> str:
    designs = [d for d in result.designs if d.drive == drive.name]
    knobs = [QUANTITIES[knob] for knob in drive.space.knobs]
    setting = {knob.column: (_HEAD_OF[knob.name], f"[{knob.unit}]") for knob in knobs}
    heads = [
        ("", *first, *others)
        for first, others in zip(zip(*setting.values(), strict=True), _HEADS, strict=True)
    ]
    lines = iter(aligned([*heads, *(_row(design, setting) for design in designs)]).splitlines())
    written = [_limits(drive), *(next(lines) for _ in heads)]
    regime = ""
    for design, line in zip(designs, lines, strict=True):
        if design.highest_regime != regime:
            regime = design.highest_regime
            goal = " (the goal)" if regime == spec.goal.highest_regime.label else ""
            written.append(f"{_at_most(_regime(regime))}{goal}")
        written.append(line)
    return "\n".join(written)


def _regime(label: str) -> Regime:
    return next(regime for regime in _REGIMES if regime.label == label)


def _limits(drive: Drive) -> str:
    """Say what a drive can do."""
    parts = []
    for name in drive.space.knobs:
        label, spans = QUANTITIES[name].label, drive.choices[name]
        if name == "amplitude" and spans[0][0] == 0.0:
            parts.append(f"amplitude up to {number(LENGTH.from_si(spans[0][1]), 'mm')}")
            continue
        parts.append(f"{label} {' or '.join(_span(name, span).removeprefix(f'{label} ') for span in spans)}")
    if math.isfinite(drive.acceleration):
        parts.append(f"acceleration up to {number(drive.acceleration)} g")
    return f"{drive.name}: {', '.join(parts)}"


def _row(design: Design, setting: Iterable[str]) -> tuple[str, ...]:
    return (
        f"  {design.design}",
        *(_exact(getattr(design, name)) for name in setting),
        _rounded(design.acceleration_g, upper=True),
        _rounded(design.speed_min_mm_s, upper=False),
        _NONE if design.speed_nominal_mm_s is None else number(design.speed_nominal_mm_s),
        _rounded(design.speed_max_mm_s, upper=True),
        _rounded(design.margin, upper=False),
        design.set_by or _NONE,
        design.proof or _NONE,
    )


def _exact(value: float | None) -> str:
    return _NONE if value is None else repr(float(value)).removesuffix(".0")


def _rounded(value: float | None, *, upper: bool) -> str:
    return _NONE if value is None else bound(value, upper=upper)


def _chosen(spec: Spec, chosen: Chosen, *, met: bool) -> list[str]:
    design = chosen.design
    if design.drive_angle_deg is not None:
        setting = f"{_exact(design.amplitude_mm)} mm, {_exact(design.frequency_hz)} Hz, "
        setting += f"{_exact(design.drive_angle_deg)} deg"
    else:
        setting = (
            f"{_exact(design.along_amplitude_mm)} mm along, {_exact(design.normal_amplitude_mm)} mm normal, "
        )
        setting += f"{_exact(design.normal_phase_deg)} deg, {_exact(design.frequency_hz)} Hz"
    facts = [
        (
            "chosen" if met else "closest",
            f"{design.drive}, {design.design} with {_at_most(_regime(design.highest_regime))}: {setting}",
        ),
        ("amplitude", _window(design)),
        ("margin", _margin(spec, design)),
    ]
    if design.traverse_time_max_s is not None:
        facts.append(("traverse time", f"at most {bound(design.traverse_time_max_s, 's', upper=True)}"))
    if design.throw_number_max is not None:
        facts.append(("throw number", f"at most {bound(design.throw_number_max, upper=True)}"))
    loads = [(what, number(load)) for what, load in chosen.loads.items()]
    costs = [(_input(name), _cost(cost)) for name, cost in chosen.costs.items()]
    return [
        aligned(facts, right=False),
        aligned([("", "load now / load at which"), *loads]),
        aligned([("1 % more", "changes the nominal speed by"), *costs]),
    ]


def _input(field: str) -> str:
    name = field.removesuffix("_deg").replace("_", " ")
    return name if name == field.replace("_", " ") else f"{name}, 1 deg more"


def _cost(cost: float) -> str:
    return f"{cost:+.3g} %" if math.isfinite(cost) else "unknown"


def _window(design: Design) -> str:
    """Say which amplitudes keep the guarantee at the same frequency and drive angle."""
    low, high = design.amplitude_low_mm, design.amplitude_high_mm
    if low is None or high is None:
        return "none keeps the goal"
    below, above = (_BEYOND.get(end or "", end or "") for end in (design.low_set_by, design.high_set_by))
    # rounded inwards, but not past the design itself
    own = design.nominal_mm or low
    first = _exact(own) if float(bound(low, upper=True)) > own else bound(low, upper=True)
    last = _exact(own) if float(bound(high, upper=False)) < own else bound(high, upper=False)
    along = " along, the normal one in proportion," if design.along_amplitude_mm else ""
    ends = f"{first} ... {last} mm{along}"
    return f"{ends} keep the goal; below, {below}; above, {above}"


def _margin(spec: Spec, design: Design) -> str:
    """Say how much wider all that is unknown may be."""
    margin = design.margin
    if margin is None:
        return "none: the goal is not met" if spec.has_bands else "none: nothing is uncertain"
    if not _drift(spec) and _NEARLY < (design.throw_number_max or 0.0) <= 1.0:
        edge = "; no drift of the drive is asked for, and it stands where parts begin to hop"
        return f"{bound(margin, upper=False)}: all bands may be that many times as wide{edge}"
    if margin >= _MOST_MARGIN:
        return f"{number(_MOST_MARGIN)} or more: all bands and drifts may be that many times as wide"
    if margin >= 1.0:
        return f"{bound(margin, upper=False)}: all bands and drifts may be that many times as wide"
    return f"{bound(margin, upper=False)}: all bands and drifts would have to be that share as wide"


def _remarks(result: DesignResult) -> list[str]:
    """Explain the proofs, and tell of coexisting motions and of parts that were left out."""
    proofs = {d.proof for d in result.designs}
    lines = [f"{name}: {text}" for name, text in _PROOFS.items() if name in proofs]
    if coexists := _all_called(d for d in result.designs if d.coexists):
        lines.append(f"disturbed parts can settle into another motion than those from rest: {coexists}")
    if excluded := [d for d in result.designs if d.excluded]:
        most = max(d.excluded or 0 for d in excluded)
        lines.append(f"samples without a speed are left out, up to {most} of: {_all_called(excluded)}")
    return ["\n".join(lines)] if lines else []


def _all_called(designs: Iterable[Design]) -> str:
    return "; ".join(map(_called, designs))


def _called(design: Design) -> str:
    return f"{design.drive}, {design.highest_regime}, {design.design}"
