"""``vibro solve --speed``: which amplitudes, or scales of a motion, convey a body at least so fast."""

from __future__ import annotations

import math
from dataclasses import dataclass, fields
from functools import cached_property
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from vibro.cli.console import Console
from vibro.cli.exit_codes import ExitCode
from vibro.cli.report import aligned
from vibro.cli.request import question, request_of
from vibro.core.codes import Regime
from vibro.errors import InputError
from vibro.inverse.extremes import counted
from vibro.inverse.questions import MOST_DESIGN_THROW
from vibro.inverse.windows import HOPS_SAMPLED, feasible_amplitudes
from vibro.limits import critical_loads
from vibro.quantities import (
    DEFAULTS,
    LEAST_SPEED,
    LOAD,
    QUANTITIES,
    SCALE,
    SPEED,
    TOLD_HARMONICS,
    as_given,
    checked_number,
    exact_number,
    given_unit,
    scene_fields,
)
from vibro.scene import Scene
from vibro.steady import solve
from vibro.sweeps.one_scene import bounce_text, bound, motion_text
from vibro.tables.record import json_text

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence
    from fractions import Fraction

    from numpy.typing import NDArray

    from vibro.cli.options import Options
    from vibro.results.designs import Interval
    from vibro.sweeps.request import Request

    Floats = NDArray[np.float64]

__all__ = ["list_amplitudes"]

_NO_MACHINE: Final = (
    "--speed asks for an amplitude, which follows from the machine; vibro map setting=10:100 shows"
    " the setting that reaches a speed"
)
_MOST_AMPLITUDES: Final = 2  # of a motion in the table; more would not fit
_MOST_ROWS: Final = 20  # of the table: irregular hops may give hundreds of slivers
_SAMPLES: Final = 4097  # amplitudes that are tried where none is fast enough
_LEAST: Final = 1e-6  # of the largest of them, where bodies start at once or hop
_MOST: Final = 1e3  # times the largest critical load, where bodies never hop
_BELOW_HOP: Final = 1e-12
_BEGINS: Final = {
    "speed": "the speed is reached",
    "onset": "forward slip begins",
    "back slip": "back slip ends",
    "hop": "its hops change",
    "unconfirmed": "its speed is unknown before",
}
_ENDS: Final = {
    "speed": "it gets slower",
    "back slip": "back slip makes it slower",
    "hop": "its hops change",
    "unconfirmed": "its speed is unknown beyond",
    "limit": f"throw number {MOST_DESIGN_THROW:g}",
}
_HOPS: Final = "the body hops"


def list_amplitudes(text: str, options: Options, argv: Sequence[str], *, hopping: bool) -> int:
    """Print the amplitudes that reach a speed, and return the exit code.

    Parameters
    ----------
    text : str
        The speed, with or without a unit; speeds of the answer have this unit too.
    options : Options
        The scene. The amplitude of a line is not given, nor the scale of a motion; the amplitudes of an
        ellipse give its proportion.
    argv : sequence of str
        The arguments as typed.
    hopping : bool
        Whether the body may hop.

    Raises
    ------
    InputError
        If something is wrong or missing, or the amplitude is given.
    FileError
        If the scene file cannot be read.
    """
    speed = checked_number(text, LEAST_SPEED)
    request = request_of(options, argv, asked_for=("amplitude", SCALE), without_machine=_NO_MACHINE)
    question(request, options, found=(LOAD.name,))
    unit, size = given_unit(text, LEAST_SPEED)
    drive = _Drive.of(request, hopping=hopping, unit=unit, size=size)
    with Console(quiet=options.quiet).progress("searching", None):
        found = drive.intervals(SPEED.to_si(speed))
    if options.json:
        given = {QUANTITIES[name].column: spec.value for name, spec in request.specs.items() if name != SCALE}
        moved = {} if request.motion is None else {"motion": dict(request.motion.table)}
        content = {
            "scene": {**given, **moved},
            LEAST_SPEED.column: speed,
            "highest_regime": (Regime.HOPPING if hopping else Regime.BACK_SLIP).label,
            "met": bool(found),
            "amplitudes": [drive.record(interval) for interval in found],
        }
        print(json_text(content))
    else:
        asked = f"{float(exact_number(text, LEAST_SPEED) / size):.15g} {unit}"
        print(aligned(drive.facts(request.fixed, asked), right=False), end="\n\n")
        print(drive.table(found) if found else f"no {drive.sizes[:-1]} does it: {drive.at_best()}")
    return ExitCode.DONE if found else ExitCode.NOT_MET


@dataclass(frozen=True)
class _Drive:
    """The drive whose size is searched: an amplitude, of an ellipse along or normal, or a motion's scale.

    Attributes
    ----------
    scene : Scene
        The scene at some size.
    amplitude : float
        That size [m], of a motion [1].
    shares : mapping of str to float
        Every amplitude over the size, and of a motion its scale, by name [1], of a motion's amplitudes [m].
    unit, size : str, Fraction
        Unit of speeds, and its size [mm/s].
    hopping : bool
        Whether the body may hop.
    in_stroke : bool
        Whether the scene has the stroke of a line, which the answer then has too.
    """

    scene: Scene
    amplitude: float
    shares: Mapping[str, float]
    unit: str
    size: Fraction
    hopping: bool
    in_stroke: bool = False

    @classmethod
    def of(cls, request: Request, *, unit: str, size: Fraction, hopping: bool) -> _Drive:
        """Return the drive of a request."""
        fixed = request.fixed
        if request.is_waveform:
            scene = request.scene()
            ways = (("along_amplitude", scene.along_harmonics), ("normal_amplitude", scene.normal_harmonics))
            amplitudes = {
                first if n == 1 else f"{first}_{n}": float(x)
                for first, pairs in ways
                for n, (x, _) in enumerate(pairs or (), 1)
            }
            return cls(scene, 1.0, {SCALE: 1.0, **amplitudes}, unit, size, hopping)
        names: list[str] = [name for name in ("along_amplitude", "normal_amplitude") if name in fixed]
        given = fixed if names else {**fixed, "amplitude": 1.0}  # its value has no effect
        if names and not any(fixed[name] for name in names):
            raise InputError(
                "along amplitude = normal amplitude = 0 mm: their proportion is that of the answer",
                hint="give along= or normal= a value above 0",
            )
        scene = Scene(**scene_fields(given))
        sizes = {name: float(getattr(scene, name)) for name in names or ["amplitude"]}
        amplitude = next(filter(None, sizes.values()))
        shares = {name: x / amplitude for name, x in sizes.items()}
        return cls(scene, amplitude, shares, unit, size, hopping, request.in_stroke)

    def scenes(self, amplitudes: Floats) -> Scene:
        """Return the scenes of some amplitudes [m]."""
        given = {f.name: getattr(self.scene, f.name) for f in fields(self.scene)}
        sizes = [SCALE] if self.is_moved else self.shares
        given |= {name: amplitudes * self.shares[name] for name in sizes}
        return Scene(**{name: value for name, value in given.items() if value is not None})

    @property
    def is_moved(self) -> bool:
        """Whether the drive is a motion, whose scale is found."""
        return SCALE in self.shares

    @property
    def told(self) -> dict[str, float]:
        """The shares of the sizes in the table, as given; of a motion with few amplitudes these too."""
        if not self.is_moved:
            return as_given(self.shares, in_stroke=self.in_stroke)
        amplitudes = {name: share for name, share in self.shares.items() if share and name != SCALE}
        return {SCALE: 1.0, **(amplitudes if len(amplitudes) <= _MOST_AMPLITUDES else {})}

    def intervals(self, speed: float) -> list[Interval]:
        """Return the amplitudes that reach a speed [m/s]."""
        if math.isinf(self.limit):  # it cannot hop
            return feasible_amplitudes(self.scene, speed)
        highest = Regime.HOPPING.label
        return feasible_amplitudes(self.scene, speed, highest_regime=highest, limit=self.limit)

    @cached_property
    def limit(self) -> float:
        """Size up to which hops are searched; inf without hops, or if they are not allowed."""
        throw = float(solve(self.scene, output="regimes").throw_number)
        return self.amplitude * (MOST_DESIGN_THROW / throw) if self.hopping and throw > 0.0 else math.inf

    def facts(self, fixed: Mapping[str, float], speed: str) -> list[tuple[str, str]]:
        """Return the question, as pairs of a name and a text."""
        words = [
            f"{QUANTITIES[name].label} {QUANTITIES[name].text(value)}"
            for name, value in fixed.items()
            if value != DEFAULTS.get(name) and name != SCALE and QUANTITIES[name].order <= TOLD_HARMONICS
        ]
        words = [motion_text(self.scene)] * self.is_moved + words
        regime = ", hopping or not" if self.hopping else " without hopping"
        facts = [("scene", ", ".join(words)), ("asked for", f"at least {speed}{regime}")]
        if self.is_moved:
            facts.append(("scale", "of the whole motion, in the proportions of the scene"))
        elif len(self.shares) > 1:
            facts.append(("amplitudes", "both change together, in the proportion of the scene"))
        if math.isfinite(self.limit):
            count = HOPS_SAMPLED[bool(self.scene.restitution > 0.0)]
            facts += [
                (
                    "hops",
                    f"sampled at {count} {self.sizes} up to {self.at(self.limit)} (throw number"
                    f" {MOST_DESIGN_THROW:g}): what lies between two of them may be missed",
                ),
                ("restitution", bounce_text(float(self.scene.restitution))),
                ("irregular hops", "count with their mean speed less three standard errors"),
            ]
        elif self.hopping:
            part = ", or the part is clamped" if self.scene.normal_acceleration is not None else ""
            facts.append(("hops", "none: the trough does not move normal to itself" + part))
        return facts

    @property
    def sizes(self) -> str:
        """What is listed."""
        return "scales" if self.is_moved else "strokes" if self.in_stroke else "amplitudes"

    def at(self, amplitude: float) -> str:
        """Write all amplitudes for people, or the scale of a motion."""
        texts = [
            f"{_word(name)}{QUANTITIES[name].from_si(amplitude * share):.4g} {QUANTITIES[name].unit}".rstrip()
            for name, share in [*self.told.items()][: 1 if self.is_moved else None]
        ]
        return ", ".join(texts)

    def record(self, interval: Interval) -> dict[str, Any]:
        """Return an interval as JSON has it."""
        ends = {}
        for name, share in self.shares.items():
            for side, end in (("low", interval.low), ("high", interval.high)):
                quantity = QUANTITIES[name]
                value = float(quantity.from_si(end * share)) if share else 0.0
                ends[f"{name}_{side}{quantity.kind.suffix}"] = value if math.isfinite(value) else None
        return {**ends, "low_set_by": interval.low_set_by, "high_set_by": interval.high_set_by}

    def table(self, found: Sequence[Interval]) -> str:
        """Return the intervals as a table, the widest ones if there are many."""
        kept = sorted(found, key=lambda i: i.low / i.high)[:_MOST_ROWS]
        units = {name: f" [{QUANTITIES[name].unit}]" if QUANTITIES[name].unit else "" for name in self.told}
        heads = [f"{_word(name)}{end}{unit}" for end in ("from", "to") for name, unit in units.items()]
        rows = [(*heads, "at its beginning", "at its end")]
        ends = _ENDS if math.isfinite(self.limit) else {**_ENDS, "hop": _HOPS}
        for interval in found:
            if interval not in kept:
                continue
            ends_told = (_rounded(interval, name, share) for name, share in self.told.items())
            lows, highs = zip(*ends_told, strict=True)
            last = ends[interval.high_set_by] if math.isfinite(interval.high) else "-"
            rows.append((*lows, *highs, _BEGINS[interval.low_set_by], last))
        lines = [aligned(rows, right=False)]
        if len(found) > _MOST_ROWS:
            lines.append(
                f"and {len(found) - _MOST_ROWS} narrower ones, where hops are irregular: --json has all"
            )
        return "\n".join(lines)

    def at_best(self) -> str:
        """Say how fast the body gets where no amplitude reaches the speed."""
        flies = math.isfinite(self.limit)
        low, high = (_LEAST * self.limit, self.limit) if flies else self._contact()
        if not low < high:
            return "it moves forwards only where it hops, if at all"
        amplitudes = np.geomspace(low, high, _SAMPLES)
        speeds = counted(solve(self.scenes(amplitudes), flight=flies), fast=False)
        where = f"up to a throw number of {MOST_DESIGN_THROW:g}" if flies else "without hopping"
        if not np.isfinite(speeds).any():
            return f"it has no steady motion {where}"
        known = np.where(np.isfinite(speeds), speeds, 0.0)
        best = int(np.argmax(known))
        if known[best] > 0.0:
            return f"{where} it gets about {self._fast(known[best])}, at {self.at(amplitudes[best])}"
        least = int(np.argmin(known))
        if not known[least] < 0.0:
            return f"{where} it does not move"
        back = (
            f"{where} it moves backwards, about {self._fast(-known[least])} at {self.at(amplitudes[least])}"
        )
        return back + self._turned()

    def _contact(self) -> tuple[float, float]:
        """Return the amplitudes between which a body moves that does not hop; nan where there are none."""
        loads = critical_loads(self.scene)
        known = [float(load) for load in loads if 0.0 < float(load) < math.inf]
        if not known:
            return math.nan, math.nan
        high = min((1.0 - _BELOW_HOP) * float(loads.hop), _MOST * max(known))
        low = min(known) if float(loads.forward_onset) else _LEAST * high
        per_load = self.amplitude / float(self.scene.load)
        return low * per_load, high * per_load

    def _fast(self, speed: float) -> str:
        return f"{float(SPEED.from_si(speed)) / float(self.size):.4g} {self.unit}"

    def _turned(self) -> str:
        """Say how to turn the direction of an ellipse."""
        if len(self.shares) == 1 or self.is_moved:
            return ""
        phase = QUANTITIES["normal_phase"]
        now = float(phase.from_si(float(self.scene.arrays()._asdict()["normal_phase"])))
        turned = now - 180.0 if now > 0.0 else now + 180.0
        return f"; {phase.typed(f'{turned:.6g}')} drives it the other way"


def _word(name: str) -> str:
    """Return a word and a space before a size: none of a line, ``along`` of an ellipse, ``scale``."""
    word = QUANTITIES[name].label.removesuffix("amplitude").removeprefix("motion ").strip()
    return f"{word} " if word else ""


def _rounded(interval: Interval, name: str, share: float) -> tuple[str, str]:
    """Write both ends of a size in the unit outside, with six digits inside the interval."""
    if not share:
        return "0", "0"
    ends = [float(QUANTITIES[name].from_si(end * share)) for end in interval[:2]]
    if math.isinf(ends[1]):
        return bound(ends[0], upper=True), "any"
    low, high = bound(ends[0], upper=True), bound(ends[1], upper=False)
    return (low, high) if float(low) <= float(high) else (repr(ends[0]), repr(ends[1]))
