"""``vibro solve --speed``: which amplitudes convey a body at least so fast."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from vibro.cli.report import aligned, bound
from vibro.cli.request import request_of
from vibro.core.codes import Regime
from vibro.files.publication import json_text
from vibro.inverse.windows import feasible_amplitudes
from vibro.limits import critical_loads
from vibro.quantities import DEFAULTS, LEAST_SPEED, LENGTH, QUANTITIES, SPEED, checked_number, scene_fields
from vibro.scene import Scene
from vibro.steady import solve
from vibro.sweeps.one_scene import number

if TYPE_CHECKING:
    from collections.abc import Sequence

    from vibro.cli.options import Options
    from vibro.results.designs import Interval

__all__ = ["list_amplitudes"]

_NOT_MET: Final = 4  # exit code
_LINE_ALONE: Final = (
    "--speed finds amplitudes of a drive along a line, not of an ellipse",
    "vibro map --speed draws where an elliptical drive reaches a speed: give --along or --normal as a range",
)
_HIGHEST: Final = Regime.BACK_SLIP
_SAMPLES: Final = 4097  # amplitudes that are tried where none is fast enough
_LEAST: Final = 1e-6  # of the largest of them, where bodies start at once
_MOST: Final = 1e3  # of the smallest, where bodies never hop
_BESIDE: Final = 1e-12
_BEGINS: Final = {
    "speed": "the speed is reached",
    "onset": "the body starts",
    "back slip": "the body slips back",
}
_ENDS: Final = {"speed": "it gets slower", "back slip": "back slip makes it slower", "hop": "the body hops"}


def list_amplitudes(text: str, options: Options, argv: Sequence[str]) -> int:
    """Print the amplitudes that reach a speed in contact, and return the exit code.

    Parameters
    ----------
    text : str
        The speed, with or without a unit.
    options : Options
        The scene; its amplitude is not given.
    argv : sequence of str
        The arguments as typed.

    Raises
    ------
    InputError
        If something is wrong or missing, or the amplitude is given.
    FileError
        If the scene file cannot be read.
    """
    speed = checked_number(text, LEAST_SPEED)
    request = request_of(options, argv, asked_for="amplitude", line_alone=_LINE_ALONE)
    scene = Scene(**scene_fields({**request.fixed, "amplitude": 1.0}))  # whatever it is, it does not count
    found = feasible_amplitudes(scene, SPEED.to_si(speed), highest_regime=_HIGHEST.label)
    if options.json:
        given = {QUANTITIES[name].column: spec.value for name, spec in request.specs.items()}
        content = {
            "scene": given,
            LEAST_SPEED.column: speed,
            "highest_regime": _HIGHEST.label,
            "met": bool(found),
            "amplitudes": [_record(interval) for interval in found],
        }
        print(json_text(content))
    else:
        words = [
            f"{QUANTITIES[name].label} {QUANTITIES[name].text(value)}"
            for name, value in request.fixed.items()
            if value != DEFAULTS.get(name)
        ]
        facts = [
            ("scene", ", ".join(words)),
            ("asked for", f"at least {number(speed, 'mm/s')} without hopping"),
        ]
        print(aligned(facts, right=False), end="\n\n")
        print(_table(found) if found else f"no amplitude does it: {_at_best(scene)}")
    return 0 if found else _NOT_MET


def _record(interval: Interval) -> dict[str, Any]:
    high = float(LENGTH.from_si(interval.high))
    return {
        "amplitude_low_mm": float(LENGTH.from_si(interval.low)),
        "amplitude_high_mm": high if math.isfinite(high) else None,
        "low_set_by": interval.low_set_by,
        "high_set_by": interval.high_set_by,
    }


def _table(found: Sequence[Interval]) -> str:
    rows = [("from [mm]", "to [mm]", "at its beginning", "at its end")]
    for interval in found:
        ends = [float(LENGTH.from_si(end)) for end in (interval.low, interval.high)]
        low, high = bound(ends[0], upper=True), bound(ends[1], upper=False)
        if float(low) > float(high):  # so narrow that six digits miss it
            low, high = map(repr, ends)
        last = (high, _ENDS[interval.high_set_by]) if math.isfinite(ends[1]) else ("any", "-")
        rows.append((low, last[0], _BEGINS[interval.low_set_by], last[1]))
    return aligned(rows, right=False)


def _at_best(scene: Scene) -> str:
    """Say how fast a body gets that does not hop."""
    loads, per_load = critical_loads(scene), float(scene.scale / scene.load)
    starts, hops = (per_load * float(load) for load in (loads.forward_onset, loads.hop))
    low = starts or _LEAST * hops
    high = (1.0 - _BESIDE) * hops if math.isfinite(hops) else _MOST * low
    if not 0.0 < low < high < math.inf:
        return "it moves forwards only where it hops, if at all"
    amplitudes = np.geomspace(low, high, _SAMPLES)
    speeds = solve(replace(scene, amplitude=amplitudes), flight=False).mean_velocity
    if np.isnan(speeds).all():
        return "it has no steady motion without hopping"
    best = int(np.nanargmax(speeds))
    speed, amplitude = SPEED.from_si(speeds[best]), LENGTH.from_si(amplitudes[best])
    return f"without hopping it gets about {speed:.4g} mm/s, at {amplitude:.4g} mm"
