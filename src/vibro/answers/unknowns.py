"""Answers to scenes with something left out: which friction it is, and where each motion begins."""

from __future__ import annotations

import math
from functools import partial
from typing import TYPE_CHECKING, Any, Final, NamedTuple

import numpy as np

from vibro.answers.answer import METRES_PER_MINUTE, NO_BOUNCE, Answer, Fact, Table, shown
from vibro.answers.scene import scene_record, scene_text, several_motions
from vibro.core.codes import Regime, Status
from vibro.errors import InputError
from vibro.inverse_friction import (
    LEAST_FRICTION,
    MOST_FRICTION,
    USUAL_RATIO,
    critical_friction,
    friction_for_speed,
    matching_friction,
)
from vibro.limits import LOADS, transitions
from vibro.quantities import LEAST_SPEED, LOAD, QUANTITIES
from vibro.scene import Scene
from vibro.steady import solve
from vibro.sweeps.grid import scene_of
from vibro.sweeps.machines import operated, withheld
from vibro.units import SPEED

if TYPE_CHECKING:
    from vibro.inverse_friction import FrictionForSpeed, Frictions
    from vibro.reals import Floats
    from vibro.results.steady import SteadyCycle
    from vibro.sweeps.request import Request

#: Quantities of friction, which stand in a request for what is asked for.
FRICTIONS: Final = ("static_friction", "friction_ratio", "kinetic_friction")
_LISTED: Final = 4  # frictions beside each other in one line
_MOST_ROWS: Final = 20
_JUST: Final = 1e-9  # [1] below the least friction at which nothing slips


class Ratio(NamedTuple):
    """Kinetic over static friction, None where that is known, and where it comes from."""

    value: float | None
    origin: str


USUAL: Final = Ratio(USUAL_RATIO, f"at the usual ratio {USUAL_RATIO:g}; --mu-ratio takes another")


def friction_answer(request: Request, speed: float, asked: str, ratio: Ratio, *, hopping: bool) -> Answer:
    """Find the frictions that give a speed.

    Parameters
    ----------
    request : Request
        The scene; its kinetic friction has no effect, nor its static friction beside a ratio.
    speed : float
        Mean speed [mm/s].
    asked : str
        The same as it was typed, with its unit, or a length and a time.
    ratio : Ratio
        Kinetic over static friction.
    hopping : bool
        Whether parts may hop.

    Returns
    -------
    Answer
        Its record says under ``met`` whether there are any.

    Raises
    ------
    InputError
        If parts hop with any friction, and may not.
    """
    scene = request.scene()
    found = _frictions(request, scene, speed, ratio, hopping=hopping)
    if not hopping and {x.status for x in found.unanswered} == {Status.FLIGHT_NOT_MODELLED}:
        throw = shown(float(solve(scene, output="regimes").throw_number))
        raise InputError(f"this drive makes parts hop: its throw number is {throw}", hint="add --hopping")
    sought = FRICTIONS if ratio.value is not None else FRICTIONS[1:]
    given = {name: spec.value for name, spec in request.specs.items() if name not in sought}
    record = {
        "scene": _record(request, sought),
        LEAST_SPEED.column: speed,
        "friction_ratio": ratio.value,
        "met": bool(found.solutions),
        "frictions": [_row(one) for one in found.solutions],
        "jumps": [_row(one) for one in found.jumps],
        "fastest": _row(found.fastest),
        "slowest": _row(found.slowest),
        "unanswered": [
            {"kinetic_friction_low": x.low, "kinetic_friction_high": x.high, "status": x.status.label}
            for x in found.unanswered
        ],
    }
    text, several = "", len(found.solutions) > 1
    speed_text = "" if "mm/s" in asked else f", {shown(speed)} mm/s"
    if not found.solutions:
        text = f"none gives {asked}{speed_text}; {_extremes(found)}"
    elif len(found.solutions) <= _LISTED:
        text = " or ".join(_span(one.low, one.high) for one in found.solutions)
    else:
        text = f"{len(found.solutions)} values or ranges"
    facts = [Fact("kinetic friction", text, note=f"for {asked}{speed_text}" if found.solutions else "")]
    tables = []
    if several:
        cells = [
            (_span(x.low, x.high), _span(x.static_low, x.static_high), x.regime.label)
            for x in found.solutions[:_MOST_ROWS]
        ]
        heads = [("kinetic friction", ""), ("static friction", ""), ("motion", "")]
        tables = [Table("frictions", heads, cells)]
    else:
        for one in found.solutions:
            static = _span(one.static_low, one.static_high)
            facts += [Fact("static friction", static, note=ratio.origin), Fact("motion", one.regime.label)]
    facts.append(Fact("scene", scene_text(scene, given), is_rare=True))
    notes = _notes(found, speed, ratio, restitution=request.fixed["restitution"])
    if found.solutions:
        ends = [
            (getattr(x, f"static_{end}"), getattr(x, end)) for x in found.solutions for end in ("low", "high")
        ]
        cycles = _cycles(request, scene, *np.transpose(ends), flight=False)
        notes += several_motions(cycles.coexists, "frictions")
    return Answer(facts, tables, notes, record, request.name or "Friction for a speed")


def _frictions(
    request: Request, scene: Scene, speed: float, ratio: Ratio, *, hopping: bool
) -> FrictionForSpeed:
    """Search frictions; with a machine its filling, and so the amplitude, changes with friction."""
    wanted = SPEED.to_si(speed)
    if request.machine is None or not request.fixed.get("filling"):
        return friction_for_speed(scene, wanted, ratio=ratio.value, flight=hopping)
    cycles = partial(_cycles, request, scene, flight=hopping)
    return matching_friction(cycles, wanted, ratio.value, request.fixed["static_friction"])


def _cycles(request: Request, scene: Scene, static: Floats, kinetic: Floats, *, flight: bool) -> SteadyCycle:
    """Solve a scene with other frictions."""
    frictions = {"static_friction": static, "kinetic_friction": kinetic}
    if request.machine is None:
        given = {name: getattr(scene, name) for name in scene.__dataclass_fields__}
        return solve(Scene(**{**given, **frictions}), flight=flight)
    values = {name: np.array([x]) for name, x in request.fixed.items() if name not in FRICTIONS} | frictions
    values |= operated(request.machine, values)
    return withheld(solve(scene_of(values), flight=flight), values)


def _record(request: Request, sought: tuple[str, ...]) -> dict[str, Any]:
    """Return the scene without what is asked for."""
    columns = {QUANTITIES[name].column for name in sought}
    return {column: value for column, value in scene_record(request).items() if column not in columns}


def _row(one: Frictions) -> dict[str, Any]:
    """Return frictions as JSON has them."""
    fields = one._asdict()
    speeds = {end: float(SPEED.from_si(fields[f"speed_{end}"])) for end in ("low", "high")}
    return {
        **{f"kinetic_friction_{end}": fields[end] for end in speeds},
        **{f"static_friction_{end}": fields[f"static_{end}"] for end in speeds},
        **{f"mean_velocity_{end}_mm_s": speed for end, speed in speeds.items()},
        "mean_velocity_error_mm_s": float(SPEED.from_si(one.error)),
        "regime": one.regime.label,
    }


def _span(low: float, high: float) -> str:
    return shown(low) if low == high else f"{shown(low)} to {shown(high)}"


def _extremes(found: FrictionForSpeed) -> str:
    """Tell the largest and the smallest speed, and at which kinetic friction."""
    if math.isnan(found.fastest.low):
        return "no friction has a mean speed"
    fast, slow = (float(SPEED.from_si(x.speed_low)) for x in (found.fastest, found.slowest))
    at = [_span(x.low, x.high) for x in (found.fastest, found.slowest)]
    rate = shown(METRES_PER_MINUTE * fast)
    return (
        f"the most is {shown(fast)} mm/s ({rate} m/min) at {at[0]}, the least {shown(slow)} mm/s at {at[1]}"
    )


def _notes(found: FrictionForSpeed, speed: float, ratio: Ratio, *, restitution: float) -> list[str]:
    notes: list[str] = []
    if len(found.solutions) > 1:
        differ = len({one.regime for one in found.solutions}) > 1
        watch = "watch whether parts slide back, or " * differ
        notes = [f"static friction is {ratio.origin}"]
        notes.append(f"which one it is: {watch}take the time at a second amplitude")
    if any(one.error for one in found.solutions):
        notes.append("irregular hops: in a range all means are within 3 standard errors of the speed")
    for x in found.jumps:
        ends = " to ".join(shown(float(SPEED.from_si(v))) for v in (x.speed_low, x.speed_high))
        notes.append(f"at kinetic friction {shown(x.low)} the speed jumps from {ends} mm/s, past this one")
    for lost in found.unanswered:
        why = "parts run away" if lost.status is Status.RUNAWAY else lost.status.message
        notes.append(f"kinetic friction {_span(lost.low, lost.high)}: {why}")
    if found.fastest.regime is Regime.HOPPING and restitution == 0.0:
        notes.append(NO_BOUNCE)
    if found.solutions:
        return notes
    if not found.jumps and found.fastest.regime not in (Regime.HOPPING, Regime.UNDEFINED):
        slow = speed > SPEED.from_si(found.fastest.speed_low)
        notes.append(
            "parts that are faster have a larger amplitude or frequency, a trough that falls more, or hop"
            if slow
            else "parts that are slower have a smaller amplitude or frequency, or a trough that climbs more"
        )
    return [
        *notes,
        "check amplitude, frequency, time and length, both angles and, of parts that hop, their restitution",
        f"kinetic friction was searched from {LEAST_FRICTION:g} to {MOST_FRICTION:g}, static friction"
        f" {ratio.origin}",
    ]


def rest_answer(request: Request, ratio: Ratio) -> Answer:
    """Find the least static friction at which nothing slips, and what a part does just below it.

    Parameters
    ----------
    request : Request
        The scene, with static friction so large that a filling sticks.
    ratio : Ratio
        Kinetic over static friction, just below.

    Returns
    -------
    Answer
        Its record says under ``met`` whether there is any.
    """
    scene = request.scene()
    forward, back = (float(x) for x in critical_friction(scene))
    least = max(forward, back)
    throw = float(solve(scene, output="regimes").throw_number)
    given = {name: spec.value for name, spec in request.specs.items() if name not in FRICTIONS}
    record: dict[str, Any] = {
        "scene": _record(request, FRICTIONS),
        "throw_number": throw,
        "met": math.isfinite(least),
        "least_static_friction": least,
        "least_static_friction_forward": forward,
        "least_static_friction_back": back,
    }
    rare = Fact("scene", scene_text(scene, given), is_rare=True)
    title = request.name or "Friction at which nothing slips"
    notes = ["for a speed give friction, such as --mu-s 0.5 --mu-ratio 0.8; --speed or --time finds friction"]
    if not record["met"]:
        text = f"none holds the part: it hops, the throw number is {shown(throw)}"
        return Answer([Fact("static friction", text), rare], (), notes, record, title)
    facts = [Fact("static friction", least, note="the least at which nothing slips")]
    if least > 0.0:
        assert ratio.value is not None
        static = least * (1.0 - _JUST)
        kinetic = ratio.value * static
        values = {name: getattr(scene, name) for name in scene.__dataclass_fields__}
        cycle = solve(Scene(**{**values, "static_friction": static, "kinetic_friction": kinetic}))
        speed = float(SPEED.from_si(cycle.mean_velocity))
        regime, status = Regime(int(cycle.regime)), Status(int(cycle.status))
        text = "the part runs away" if status is Status.RUNAWAY else regime.label
        text += f", {shown(speed)} mm/s" * math.isfinite(speed)
        facts.append(Fact("just below", text, note=f"kinetic friction {ratio.origin}"))
        record |= {
            "friction_ratio": ratio.value,
            "regime_below": regime.label,
            "mean_velocity_below_mm_s": speed,
        }
    return Answer([*facts, rare], (), notes, record, title)


def onset_answer(request: Request, sought: str) -> Answer:
    """Find the amplitudes, or the frequencies, at which each motion begins.

    Parameters
    ----------
    request : Request
        The scene; the quantity that is asked for has any value.
    sought : str
        Name of that quantity: ``amplitude`` or ``frequency``.
    """
    scene, quantity = request.scene(), QUANTITIES[sought]
    found = [t for t in transitions(scene) if t.name not in LOADS]
    rows = [(t.name, float(quantity.from_si(getattr(t, sought))), t.load) for t in found]
    given = {name: spec.value for name, spec in request.specs.items() if name != sought}
    heads = [("begins", ""), (quantity.label, quantity.unit), (LOAD.label, LOAD.unit)]
    record = {
        "scene": _record(request, (sought,)),
        "beginnings": [dict(zip(("motion", quantity.column, LOAD.column), row, strict=True)) for row in rows],
    }
    notes = [f"for a speed give the {quantity.label}: {quantity.options[0]}"]
    if abs(math.tan(float(scene.trough_angle))) >= float(scene.static_friction):
        notes.insert(0, f"parts slide at any {quantity.label}: the trough is steeper than friction holds")
    rare = Fact("scene", scene_text(scene, given), is_rare=True)
    table = Table("beginnings", heads, rows)
    return Answer([rare], [table], notes, record, request.name or "Where motions begin")
