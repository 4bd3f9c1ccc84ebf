"""The answer of ``vibro design`` in words: the question, all designs, and details of the chosen one."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Final, NamedTuple

from vibro.core.codes import Regime
from vibro.inverse.designs import at_most
from vibro.inverse.rows import KINDS
from vibro.quantities import LENGTH, QUANTITIES, SPEED
from vibro.sweeps.one_scene import bound, number

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping, Sequence

    from vibro.inverse.designs import Chosen
    from vibro.inverse.specs import Drive, Spec
    from vibro.results.designs import Design, DesignResult

__all__ = [
    "DesignTable",
    "chosen_facts",
    "closest_rows",
    "cost_rows",
    "design_table",
    "drive_limits",
    "load_rows",
    "question_facts",
    "remarks",
    "size_of",
]

_REGIMES: Final = (Regime.FORWARD_SLIP, Regime.BACK_SLIP, Regime.HOPPING)
_NEARLY: Final = 0.999  # throw number of a setting that is about to hop
_NOTHING: Final = 1e-6  # [%] of speed: above the rounding of finite differences
_NONE: Final = "-"
# Heads of a setting, by its knobs.
_HEAD_OF: Final = {
    "amplitude": "amplitude",
    "stroke": "stroke",
    "setting": "setting",
    "along_amplitude": "along",
    "normal_amplitude": "normal",
    "normal_phase": "phase",
    "frequency": "frequency",
    "drive_angle": "angle",
    "motion_scale": "scale",
}
# Heads of the amplitudes of a machine at a setting: of its empty trough, and those that its bands make of it.
_OF_MACHINES: Final = {
    "empty": "amplitude_empty_mm", "least": "amplitude_least_mm", "most": "amplitude_most_mm",
}  # fmt: skip
# Heads of what follows from it, with their units.
_HEADS: Final = {
    "accel.": "[g]",
    "guaranteed": "[mm/s]",
    "proved above": "[mm/s]",
    "nominal": "[mm/s]",
    "largest": "[mm/s]",
    "margin": "",
    "set by": "",
    "proof": "",
}
_OF_BANDS: Final = ("proved above", "nominal", "largest", "margin")  # heads without meaning for a single part
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
    "proved": 'boxes that cover all parts show that none falls short of the speed "proved above"',
    "searched": "the slowest part that was found; the proved speed is lower, or none is proved",
    "sampled": "parts hop: the slowest of sampled parts; another part may be slower",
}


# What is sure of a filled machine.
_FILLED: Final = (
    "filling: speeds hold from the least to the most amplitude; that no voltage and filling makes others, and"
    " that the goal is kept with the second harmonic, is sampled, not proved"
)


class DesignTable(NamedTuple):
    """Designs of a drive as texts.

    Attributes
    ----------
    heads, units : list of str
        Of the columns behind the name of a design.
    groups : list of tuple
        For each highest regime its title and its rows, each with the name of the design first; a regime
        without a design has no rows.
    """

    heads: list[str]
    units: list[str]
    groups: list[tuple[str, list[list[str]]]]


def question_facts(spec: Spec, result: DesignResult) -> list[tuple[str, str]]:
    """Return the question and which drives meet its goal, as pairs of a name and a text."""
    met = [d.drive for d in _of(result, "gentlest", spec.goal.highest_regime) if d.frequency_hz is not None]
    return [
        ("goal", _goal(spec)),
        ("met by", ", ".join(met) or "no drive"),
        ("parts", ", ".join(_span(name, spec.bands[name]) for name in spec.bands if "friction" in name)),
        (
            "trough",
            ", ".join(
                _trough(spec, hops=any(d.highest_regime == Regime.HOPPING.label for d in result.designs))
            ),
        ),
        ("drift", ", ".join(_drift(spec)) or "none"),
    ]


def _goal(spec: Spec) -> str:
    goal = spec.goal
    parts = [f"at least {_speed(goal.speed)} for every part"]
    if spec.length is not None:
        parts[0] += (
            f", {number(LENGTH.from_si(spec.length), 'mm')} in {number(spec.length / goal.speed, 's')}"
        )
    parts.append(at_most(goal.highest_regime))
    if math.isfinite(goal.impact_speed):
        parts.append(f"impacts of at most {_speed(goal.impact_speed)}")
    if math.isfinite(goal.flight_fraction):
        parts.append(f"in flight at most {number(100.0 * goal.flight_fraction)} % of the time")
    if math.isfinite(spec.stand_ratio):
        parts.append(f"upright, with the stand ratio {number(spec.stand_ratio)}")
    return "; ".join(parts)


def _speed(speed: float) -> str:
    return number(SPEED.from_si(speed), SPEED.unit)


def _span(name: str, span: tuple[float, float]) -> str:
    quantity = QUANTITIES[name]
    ends = dict.fromkeys(_given(quantity.from_si(end)) for end in span)
    return f"{quantity.label} {' ... '.join(ends)} {quantity.unit}".rstrip()


def _given(value: float) -> str:
    """Write a number as it was given: nobody writes more than 15 digits."""
    return f"{value:.15g}"


def _trough(spec: Spec, *, hops: bool) -> list[str]:
    parts = [_span("trough_angle", spec.bands.get("trough_angle", (0.0, 0.0)))]
    if spec.length is not None:
        parts.append(_span("trough_length", (spec.length, spec.length)))
    for name in ("gravity", "restitution"):
        value = getattr(spec, name)
        if value != QUANTITIES[name].default or (hops and name == "restitution"):
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


def closest_rows(spec: Spec, result: DesignResult) -> list[tuple[str, ...]]:
    """Return the rows of a table of what each drive reaches, its head first.

    It contains the designs within the next regimes too, and the drive that would meet the goal.
    """
    highest = spec.goal.highest_regime
    answered = {design.highest_regime for design in result.designs}
    higher = [regime for regime in _REGIMES if regime > highest and regime.label in answered]
    nearest = "nearest drive that meets the goal"
    rows = [("largest guaranteed", at_most(highest), "set by", *(r.label for r in higher), nearest)]
    # another frequency changes the amplitude of these
    tuned = {d.name for d in spec.drives if d.machine is not None and not d.machine.is_plain}
    others = [{d.drive: d for d in _of(result, "fastest", regime)} for regime in higher]
    for design in _of(result, "fastest", highest):
        needed = _NONE
        if design.drive in tuned:
            needed = "not computed for machines"
        if design.frequency_needed_hz is not None:
            size = _exact(design.amplitude_needed_mm or design.stroke_needed_mm)
            stroke = " stroke" if design.stroke_needed_mm is not None else ""
            needed = f"{_exact(design.frequency_needed_hz)} Hz, "
            needed += f"{size} mm{stroke}" if design.motion_scale is None else "scale "
            if design.motion_scale is not None:
                needed += _exact(design.motion_scale_needed)
            elif design.drive_angle_deg is not None:
                needed += f" at {_exact(design.drive_angle_deg)} deg"
            else:
                needed += f" along, the rest in proportion, at {_exact(design.normal_phase_deg)} deg"
        reached = [_least(design), design.set_by or _NONE, *(_least(other[design.drive]) for other in others)]
        rows.append((design.drive, *reached, needed))
    return rows


def _least(design: Design) -> str:
    speed = design.speed_min_mm_s
    return "nothing" if speed is None else bound(speed, SPEED.unit, upper=False)


def design_table(drive: Drive, spec: Spec, result: DesignResult, regimes: Sequence[Regime]) -> DesignTable:
    """Write the designs of a drive within some regimes; those that do not exist are left out.

    Settings have all their digits, so that typed in they hold; bounds are rounded so that they hold too.
    """
    units = {name: QUANTITIES[name].unit for name in drive.told}
    heads = {_HEAD_OF[name]: f"[{unit}]" if unit else "" for name, unit in units.items()}
    if drive.machine is not None:
        heads |= dict.fromkeys([*_OF_MACHINES][: 3 if drive.machine.has_bands else 1], "[mm]")
    heads |= _HEADS
    shown = [head for head in heads if spec.has_bands or head not in _OF_BANDS]
    # without uncertainty no design is safer than another
    kinds = KINDS if spec.has_bands else KINDS[:2]
    groups = []
    for regime in regimes:
        group = [
            d
            for d in result.designs
            if (d.drive, d.highest_regime) == (drive.name, regime.label) and d.design in kinds
        ]
        goal = " (the goal)" if regime is spec.goal.highest_regime else ""
        rows = []
        for design in group:
            if design.frequency_hz is not None:
                cells = _cells(design, drive)
                rows.append([design.design, *(cells[head] for head in shown)])
        groups.append((f"{at_most(regime)}{goal}{_missed(spec, group)}", rows))
    return DesignTable(shown, [heads[head] for head in shown], groups)


def _missed(spec: Spec, designs: Sequence[Design]) -> str:
    """Say if designs do not guarantee the speed of the goal, or none at all."""
    fastest = next((d for d in designs if d.design == "fastest"), None)
    if fastest is None or fastest.frequency_hz is None:
        why = f", set by {fastest.set_by}" if fastest and fastest.set_by else ""
        # a search that the filling ends has not shown that there is none
        unknown = fastest is not None and fastest.set_by == "filling"
        return f": {'none was found that holds' if unknown else 'no speed is guaranteed'}{why}"
    met = any(d.design == "gentlest" and d.frequency_hz is not None for d in designs)
    return "" if met else f": less than {_speed(spec.goal.speed)}"


def _regime(label: str) -> Regime:
    return next(regime for regime in _REGIMES if regime.label == label)


def drive_limits(drive: Drive) -> str:
    """Say what a drive can do."""
    parts = []
    for knob, name in zip(drive.space.knobs, drive.told, strict=True):
        quantity, scale = QUANTITIES[name], drive.scale(knob)
        label = quantity.label
        spans = [(low * scale, high * scale) for low, high in drive.choices[knob]]
        if knob == "amplitude" and spans[0][0] == 0.0:
            parts.append(f"{label} up to {_given(quantity.from_si(spans[0][1]))} {quantity.unit}")
            continue
        parts.append(f"{label} {' or '.join(_span(name, span).removeprefix(f'{label} ') for span in spans)}")
    machine = drive.machine
    limit = drive.acceleration if machine is None else machine.acceleration
    if math.isfinite(limit):
        parts.append(f"acceleration up to {number(limit)} g")
    if machine is not None:
        parts[1:1] = [f"{number(LENGTH.from_si(machine.full_amplitude), 'mm')} empty at 100 %"]
        parts += [f"springs of {number(f0, 'Hz')}" for f0 in [machine.natural_frequency] if f0 is not None]
        bands = {"voltage": (machine.voltage, (1.0, 1.0)), "filling": (machine.filling, (0.0, 0.0))}
        parts += [_span(name, band) for name, (band, usual) in bands.items() if band != usual]
    return ", ".join(parts)


def _cells(design: Design, drive: Drive) -> dict[str, str]:
    """Write the numbers of a design, by their heads."""
    setting = {_HEAD_OF[name]: _exact(getattr(design, QUANTITIES[name].column)) for name in drive.told}
    sizes = {head: getattr(design, column) for head, column in _OF_MACHINES.items()}
    setting |= {head: _NONE if size is None else number(size) for head, size in sizes.items()}
    return setting | {
        "accel.": _rounded(design.acceleration_g, upper=True),
        "guaranteed": _rounded(design.speed_min_mm_s, upper=False),
        "proved above": _rounded(design.speed_proved_mm_s, upper=False),
        "nominal": _NONE if design.speed_nominal_mm_s is None else number(design.speed_nominal_mm_s),
        "largest": _rounded(design.speed_max_mm_s, upper=True),
        "margin": _rounded(design.margin, upper=False),
        "set by": design.set_by or _NONE,
        "proof": design.proof or _NONE,
    }


def _exact(value: float | None) -> str:
    return _NONE if value is None else repr(float(value)).removesuffix(".0")


def _rounded(value: float | None, *, upper: bool) -> str:
    return _NONE if value is None else bound(value, upper=upper)


def chosen_facts(spec: Spec, chosen: Chosen, *, met: bool) -> list[tuple[str, str]]:
    """Return the facts about the chosen design, as pairs of a name and a text."""
    design = chosen.design
    if design.setting_percent is not None:
        empty = number(design.amplitude_empty_mm or 0.0)
        setting = f"setting {_exact(design.setting_percent)} %, {empty} mm empty,"
        setting += f" {_exact(design.frequency_hz)} Hz, {_exact(design.drive_angle_deg)} deg"
    elif design.motion_scale is not None:
        setting = f"scale {_exact(design.motion_scale)}, {_exact(design.frequency_hz)} Hz"
    elif design.drive_angle_deg is not None:
        stroke = " stroke" if design.stroke_mm is not None else ""
        setting = f"{_exact(design.nominal)} mm{stroke}, {_exact(design.frequency_hz)} Hz, "
        setting += f"{_exact(design.drive_angle_deg)} deg"
    else:
        setting = (
            f"{_exact(design.along_amplitude_mm)} mm along, {_exact(design.normal_amplitude_mm)} mm normal, "
        )
        setting += f"{_exact(design.normal_phase_deg)} deg, {_exact(design.frequency_hz)} Hz"
    facts = [
        (
            "chosen" if met else "closest",
            f"{design.drive}, {design.design} with {at_most(_regime(design.highest_regime))}: {setting}",
        ),
        (size_of(design), _window(design, chosen.drive)),
        ("margin", _margin(spec, design)),
    ]
    machine = chosen.drive.machine
    if machine is not None and machine.has_bands:
        least, most = (number(x or 0.0) for x in (design.amplitude_least_mm, design.amplitude_most_mm))
        if design.second_harmonic_percent is not None:
            size, speed = design.second_harmonic_percent, design.speed_second_harmonic_mm_s
            with_it = f"up to {number(size)} % of the amplitude from the filling"
            slowest = "" if speed is None else f"; with it the slowest sampled part has {number(speed)} mm/s"
            facts.insert(1, ("second harmonic", with_it + slowest))
        facts.insert(1, ("amplitude met", f"{least} ... {most} mm over voltage and filling, covered"))
    if design.traverse_time_max_s is not None:
        facts.append(("traverse time", f"at most {bound(design.traverse_time_max_s, 's', upper=True)}"))
    if design.throw_number_max is not None:
        facts.append(("throw number", f"at most {bound(design.throw_number_max, upper=True)}"))
    return facts


def load_rows(chosen: Chosen) -> list[tuple[str, str]]:
    """Return the rows of a table of the load over critical loads of the parts, its head first."""
    rows = [(what, number(load)) for what, load in chosen.loads.items()]
    return [("", "load now / load at which"), *rows]


def cost_rows(costs: Mapping[str, float | str], size: str) -> list[tuple[str, str]]:
    """Return the rows of a table of sensitivities, its head first.

    Parameters
    ----------
    costs : mapping of str to float or str
        As from ``speed_costs``.
    size : str
        What the amplitude is called: ``amplitude``, ``stroke`` or ``scale``.
    """
    rows = [(_input(name, size), _cost(cost)) for name, cost in costs.items()]
    return [("1 % more", "changes the nominal speed by"), *rows]


def size_of(design: Design) -> str:
    """Name the quantity of the printed amplitudes of a design."""
    if design.motion_scale is not None:
        return "scale"
    return "amplitude" if design.stroke_mm is None else "stroke"


def _input(field: str, size: str) -> str:
    name = field.removesuffix("_deg").replace("_", " ")
    if name in ("amplitude", "motion scale"):
        return size
    return name if name == field.replace("_", " ") else f"{name}, 1 deg more"


def _cost(cost: float | str) -> str:
    """Write a sensitivity, which is 0 where rounding alone is left of it, or why there is none."""
    if isinstance(cost, str):
        return cost
    return f"{cost:+.3g} %" if abs(cost) > _NOTHING else "0 %"


def _window(design: Design, drive: Drive) -> str:
    """Say which amplitudes, or scales, keep the guarantee at the same frequency and drive angle."""
    if drive.machine is not None and drive.machine.is_filled:
        return "no window: the filling changes other amplitudes in another proportion"
    if design.window is None:
        return "none keeps the goal"
    low, high = design.window
    beyond = {**_BEYOND, "hop": _OTHER_HOPS} if (design.throw_number_max or 0.0) > 1.0 else _BEYOND
    below, above = (beyond.get(end or "", end or "") for end in (design.low_set_by, design.high_set_by))
    # rounded inwards, but not past the design itself
    own = design.nominal or low
    first = _exact(own) if float(bound(low, upper=True)) > own else bound(low, upper=True)
    last = _exact(own) if float(bound(high, upper=False)) < own else bound(high, upper=False)
    along = " along, the normal one in proportion," if design.along_amplitude_mm else ""
    unit = " mm" if design.motion_scale is None else ""
    if (first, design.low_set_by, design.high_set_by) == (last, "limit", "limit"):
        return f"{first}{unit}, all that the drive can do, keeps the goal"
    return f"{first} ... {last}{unit}{along} keep the goal; below, {below}; above, {above}"


def _margin(spec: Spec, design: Design) -> str:
    """Say how much wider all that is unknown may be."""
    margin = design.margin
    if margin is None:
        return (
            "none: even without bands the goal is missed"
            if spec.has_bands
            else "none: no band and no drift is given"
        )
    if margin < 1.0:
        return f"{bound(margin, upper=False)}: all bands and drifts would have to shrink to this share"
    if not _drift(spec) and _NEARLY < (design.throw_number_max or 0.0) <= 1.0:
        edge = "; no drift of the drive is given, and it is set where parts begin to hop"
        return f"{bound(margin, upper=False)}: all bands may be that many times as wide{edge}"
    if margin >= _MOST_MARGIN:
        return f"{number(_MOST_MARGIN)} or more: all bands and drifts may be that many times as wide"
    return f"{bound(margin, upper=False)}: all bands and drifts may be that many times as wide"


def remarks(result: DesignResult) -> list[str]:
    """Explain the proofs, coexisting motions and parts that were left out, a line each."""
    proofs = {d.proof for d in result.designs}
    lines = [f"{name}: {text}" for name, text in _PROOFS.items() if name in proofs]
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
    return "; ".join(map(_called, designs))


def _called(design: Design) -> str:
    return f"{design.drive}, {design.highest_regime}, {design.design}"
