"""What a report says of one scene, in sentences."""

from __future__ import annotations

import math
from itertools import groupby
from typing import TYPE_CHECKING, Any, Final

from vibro.core.codes import PHASE_NAMES, Regime, Status
from vibro.explore.words import unit_of
from vibro.inverse.friction_windows import friction_windows
from vibro.quantities import QUANTITIES, SCALE
from vibro.sweeps.one_scene import bound, estimate, number
from vibro.waveforms import PiecewiseMotion

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from vibro.inverse.friction_windows import FrictionWindow
    from vibro.limits import Transition
    from vibro.sweeps.one_scene import OneScene

__all__ = [
    "AS_STATED",
    "DOES",
    "LIMITS",
    "MEANINGS",
    "REGIMES",
    "answer_text",
    "assumptions",
    "kept_rows",
    "motion_rows",
    "next_text",
    "pattern_text",
    "speed_per_minute",
    "transition_texts",
    "traverse_text",
    "valued",
]

_MOST_PHASES: Final = 8  # in a sentence
_MOST_ITEMS: Final = 8  # of a list
_NOTHING: Final = "\N{EN DASH}"
_PER_MINUTE: Final = 0.06  # [m/min] of 1 mm/s
# What the lists of a motion hold, and their units, by what follows the direction in their keys.
_LISTED: Final[Mapping[str, tuple[str, str]]] = {
    "steps": ("steps", " m/s²"),
    "samples_m_s2": ("samples", " m/s²"),
    "samples_mm": ("samples", " mm"),
    "amplitudes_mm": ("amplitudes", " mm"),
    "phases_deg": ("phases", "°"),
}
#: What a regime means for the part.
REGIMES: Final[Mapping[Regime, str]] = {
    Regime.UNDEFINED: "It has none.",
    Regime.NO_SLIP: "The part rests on the trough: the forces along it never exceed static friction.",
    Regime.FORWARD_SLIP: "The part slides forward, never backwards, and stays on the trough.",
    Regime.BACK_SLIP: "In every cycle the part slides back too, which costs speed. It stays on the trough.",
    Regime.HOPPING: "The part leaves the trough and lands again: faster, but with noise and wear.",
}
#: What the numbers of ``facts_of`` mean, by their names.
MEANINGS: Final[Mapping[str, str]] = {
    "note": "Of parts that are pushed, or dropped onto the trough.",
    "mean speed": "Positive in the conveying direction.",
    "peak speed": "Largest, relative to the trough, either way: wear.",
    "from rest": "Of one undisturbed part, not the mean over many.",
    "per cycle": "Travel in one drive cycle.",
    "in flight": "Off the trough.",
    "impact speed": "How hard the part lands: noise, wear, damage.",
    "repeats": "",
    "throughput": "In one row, none pushed by another.",
}
_BEGINS: Final[Mapping[str, str]] = {
    "forward slip": "begins to slide forward",
    "back slip": "begins to slip back",
    "continuous sliding": "no longer comes to rest: it slides all the time",
    "hopping": "begins to hop",
    "load for forward slip": "is pushed forward harder than static friction can hold it",
    "load for back slip": "is pushed back harder than static friction can hold it",
}
_BEGUN: Final[Mapping[str, str]] = {
    **_BEGINS,
    "forward slip": "slides forward",
    "back slip": "slips back",
    "continuous sliding": "never comes to rest: it slides all the time",
    "hopping": "hops",
}
# What the part does below and above the loads at which its regime changes, by the names of transitions.
_ENDS: Final[Mapping[str, tuple[str, str]]] = {
    "forward slip": ("the part rests", "the part slides forward"),
    "back slip": ("the part no longer slips back", "the part slips back"),
    "hopping": ("the part stays on the trough", "the part hops"),
}
#: What the part does in a regime.
DOES: Final[Mapping[Regime, str]] = {
    Regime.NO_SLIP: "rests",
    Regime.FORWARD_SLIP: "slides forward",
    Regime.BACK_SLIP: "slips back",
    Regime.HOPPING: "hops",
}
_ASSUMED: Final[Mapping[str, str]] = {
    "trough_angle": "The trough is level (trough angle {}).",
    "gravity": "Gravity is {}.",
    "restitution": "A part that lands does not bounce (restitution {}): it counts only where parts hop.",
    "normal_phase": "Both motions of the trough pass their middles together (normal phase {}).",
}
#: Of ``LIMITS`` what a machine does otherwise.
AS_STATED: Final = (
    "A rigid trough that moves exactly as stated, the same over its whole length and with any parts on it."
)
#: What the model leaves out.
LIMITS: Final = (
    "One rigid part that is small against the trough, alone: no tipping or rolling, no parts that push each"
    " other, no air.",
    "Dry friction with one static and one kinetic coefficient. Those of real parts scatter by a tenth and"
    " more, and change with wear, dust, oil and humidity: measure them on the trough.",
    AS_STATED,
    "The numbers are exact for this model, but for means of irregular hopping, which carry a standard error:"
    " a feeder differs from them by what the model leaves out and by errors of the input.",
)


def answer_text(one: OneScene) -> str:
    """Say how fast the part is conveyed, and why it has no speed if it has none."""
    speed = one.result("mean_velocity")
    if one.runs:
        return f"The part runs away {one.runs}: it gains speed in every cycle and has no mean speed."
    if math.isnan(speed):
        return f"The speed is unknown: {one.status.message}."
    if one.regime is Regime.NO_SLIP:
        return "The part rests on the trough: nothing is conveyed."
    if one.relative_error > 1.0 / 3.0:
        return "Within the standard error of the speed the part may be conveyed either way."
    if not speed:
        return "The part slides to and fro and is not conveyed."
    way = "" if speed > 0.0 else " backwards, against the conveying direction,"
    size = f"{abs(speed):.3g} mm/s ({_PER_MINUTE * abs(speed):.3g} m/min)"
    size = f"about {size}" if one.relative_error else size
    return f"The part is conveyed{way} at {size}. {REGIMES[one.regime]}"


def speed_per_minute(one: OneScene) -> str:
    """Write the mean speed in m/min, with its standard error; empty if it is unknown."""
    speed, error = one.result("mean_velocity"), one.result("mean_velocity_error")
    return "" if math.isnan(speed) else estimate(_PER_MINUTE * speed, _PER_MINUTE * error, "m/min")


def pattern_text(pattern: str) -> str:
    """Spell the phases of a cycle: ``F_B_`` is forward slide, rest, back slide, rest."""
    if "." in pattern:
        return "irregular flights"
    said = []
    for letter, run in groupby(pattern):
        count, name = len([*run]), PHASE_NAMES[letter]
        said.append(name if count == 1 else f"{count} {name}s")
    return ", ".join(said if len(said) <= _MOST_PHASES else [f"{len(pattern)} phases"])


def next_text(one: OneScene) -> tuple[str, str]:
    """Return the next transition as the drive grows, and where it is; empty texts without one."""
    for t in one.transitions():
        if t.ratio <= 1.0:
            return f"at {_times(t.ratio)} × the {_today(one)}", f"the part {_BEGINS[t.name]}"
    return "", ""


def transition_texts(one: OneScene, *, of_machine: bool = False) -> list[str]:
    """Say what begins where as the drive grows, a sentence each; of a machine not at which frequency."""
    said = []
    for t in one.transitions():
        t = t._replace(frequency=math.nan) if of_machine else t
        end = f", until {_where(one, t.end_ratio)}" if one.scene.motion is not None and t.end_ratio else ""
        if t.ratio > 1.0:
            said.append(f"From {_where(one, t.ratio)}{_or_at(t)} on the part {_BEGUN[t.name]}{end}.")
        else:
            said.append(f"At {_where(one, t.ratio)}{_or_at(t)} the part {_BEGINS[t.name]}{end}.")
    return said


def _times(ratio: float) -> str:
    return f"{1.0 / ratio:.4g}"


def _today(one: OneScene) -> str:
    """Name the scaled quantity: the amplitude of a line, all amplitudes of others."""
    if SCALE in one.driven:
        return "present motion scale"
    return "present amplitudes" if len(one.driven) > 1 else f"present {one.size}"


def _where(one: OneScene, ratio: float) -> str:
    own = f" ({one.amplitudes(ratio)})" if len(one.driven) <= 2 else ""
    return f"{_times(ratio)} times the {_today(one)}{own}"


def _or_at(t: Transition) -> str:
    return "" if math.isnan(t.frequency) else f", or at {number(t.frequency, 'Hz')},"


def traverse_text(one: OneScene) -> tuple[str, str]:
    """Say how long the part takes over the trough, and what that means.

    The mean speed says so only of parts that take longer than a cycle, and than a period of their motion.
    """
    time = one.traverse_time
    if time is None:
        return one.why_never(), ""
    cycle, period = 1.0 / float(one.scene.frequency), one.period
    if time >= cycle and not time < period:
        return estimate(time, time * one.relative_error, "s"), "Over the trough, at the mean speed."
    within = f"one drive cycle, {number(cycle, 's')}"
    if period > cycle:
        within = f"one period of the motion, {number(period, 's')}"
    return "unknown", (
        f"At the mean speed it would be {number(time, 's')}, less than {within}: the mean is no guide."
    )


def motion_rows(table: Mapping[str, Sequence[Any]]) -> list[tuple[str, str]]:
    """List a motion as a file gives it, a row for each direction; of long lists the first values.

    Parameters
    ----------
    table : mapping of str to sequence
        Steps, samples, or amplitudes and phases of harmonics, by their keys in scene files.
    """
    rows = []
    for key, values in table.items():
        way, _, what = key.partition("_")
        kind, unit = _LISTED[what]
        if what == "steps":
            items = [f"{share:.15g} of the period at {size:.15g}{unit}" for share, size in values]
        else:
            items = [f"{value:.15g}" for value in values]
        left = len(items) - _MOST_ITEMS
        told = ", ".join(items[:_MOST_ITEMS]) + unit * (what != "steps")
        where = "normal to the trough" if way == "normal" else "along the trough"
        rows.append((f"{kind} {where}", f"{told} and {left} more" if left > 0 else told))
    return rows


def kept_rows(one: OneScene) -> list[tuple[str, ...]]:
    """Return the rows of a table of what may change without a change of the regime, its head first.

    Empty where the body has no steady motion. Bounds are rounded so that they hold.
    """
    if not one.status.answered:
        return []
    head = ("this alone", "present", "from", "to", "below", "above", "how known")
    rows = [*_kept_drives(one)]
    names = {
        "static_friction": "static friction, kinetic in proportion",
        "kinetic_friction": "kinetic friction",
    }
    for name, window in friction_windows(one.scene).items():
        rows.append(
            (names[name], number(float(getattr(one.scene, name))), *_window_cells(window, one.regime))
        )
    return [head, *rows]


def _kept_drives(one: OneScene) -> list[tuple[str, ...]]:
    """Return the rows of the drive: its size, and its frequency where that counts."""
    changes = [t for t in one.transitions() if t.name in _ENDS]
    # factors of the motion, what comes below, and what comes above
    ends = [(1.0 / t.ratio, _ENDS[t.name]) for t in changes]
    if one.scene.motion is not None:  # others last until the hop
        ends += [(1.0 / t.end_ratio, _ENDS[t.name][::-1]) for t in changes if t.end_ratio]
    low, (below, _) = max((end for end in ends if end[0] < 1.0), default=(0.0, (_NOTHING, "")))
    high, (_, above) = min((end for end in ends if end[0] >= 1.0), default=(math.inf, ("", _NOTHING)))
    # under an ellipse on a steep trough back slip may end again (``CriticalLoads``)
    is_steep = abs(math.tan(float(one.scene.trough_angle))) > float(one.scene.kinetic_friction)
    known = "exact" if one.scene.motion is None and not (one.is_two_axis and is_steep) else "searched"
    rows: list[tuple[str, ...]] = []
    if len(one.driven) == 1:
        ((name, value),) = one.driven.items()
        unit = QUANTITIES[name].unit
        first = "any" if not low else bound(low * value, unit, upper=True)
        last = "any" if math.isinf(high) else bound(high * value, unit, upper=False)
        rows.append((QUANTITIES[name].label, number(value, unit), first, last, below, above, known))
    else:
        first = "any" if not low else f"{bound(low, upper=True)} ×"
        last = "any" if math.isinf(high) else f"{bound(high, upper=False)} ×"
        rows.append((one.all_amplitudes, "1 ×", first, last, below, above, known))
    frequency = one.given["frequency"]
    if isinstance(one.scene.motion, PiecewiseMotion):  # its accelerations are the same at any frequency
        told = ("any", "any", _NOTHING, _NOTHING, "exact")
        rows.append(("frequency", number(frequency, "Hz"), *told))
    else:
        first = "any" if not low else bound(frequency * math.sqrt(low), "Hz", upper=True)
        last = "any" if math.isinf(high) else bound(frequency * math.sqrt(high), "Hz", upper=False)
        rows.append(("frequency", number(frequency, "Hz"), first, last, below, above, known))
    return rows


def _window_cells(window: FrictionWindow, own: Regime) -> tuple[str, ...]:
    """Write a window of frictions, its ends rounded inwards, what comes beyond them, and how it is known."""
    ends = bound(window.low, upper=True), bound(window.high, upper=False)
    beyond = (_NOTHING if end is None else _beyond(end, own) for end in (window.below, window.above))
    return *ends, *beyond, "exact" if window.is_proved else "searched"


def _beyond(end: Regime | Status, own: Regime) -> str:
    if end is Regime.FORWARD_SLIP and own is Regime.BACK_SLIP:
        return "the part no longer slips back"
    if isinstance(end, Status):  # a code of its own, which may equal that of a regime
        return "the part runs away" if end is Status.RUNAWAY else "it has no steady motion"
    return f"the part {DOES[end]}"


def valued(name: str, value: float) -> str:
    """Write a quantity as it was given, with its unit."""
    unit = unit_of(QUANTITIES[name])
    return f"{value:.15g}{unit}" if unit == "°" else f"{value:.15g} {unit}".rstrip()


def assumptions(values: Mapping[str, float], given: frozenset[str]) -> list[str]:
    """Name what was assumed because it was not given, a sentence each.

    Parameters
    ----------
    values : mapping of str to float
        Quantities in the units outside, by name.
    given : frozenset of str
        Names of those that were given.
    """
    return [
        text.format(valued(name, values[name]))
        for name, text in _ASSUMED.items()
        if name in values and name not in given
        if name != "normal_phase" or values["normal_amplitude"]
    ]
