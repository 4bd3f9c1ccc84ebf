"""One solved scene in words: its regime, where the next ones begin, its phases."""

from __future__ import annotations

import math
from dataclasses import replace
from decimal import ROUND_CEILING, ROUND_FLOOR, Context
from typing import TYPE_CHECKING, Final

import numpy as np

from vibro.core.codes import PHASE_NAMES, Regime, Status
from vibro.limits import transitions
from vibro.motion.histories import simulate
from vibro.motion.settled import cycle_phases
from vibro.quantities import (
    DEFAULTS,
    LENGTH,
    MACHINE,
    QUANTITIES,
    SCALE,
    SIZES,
    SPEED,
    TOLD_HARMONICS,
    as_given,
    counted_harmonics,
    scene_fields,
)
from vibro.results.operating import OPERATING
from vibro.scene import Scene
from vibro.sweeps.derived import (
    LEAST_DIFFERENCE,
    WITH_ACCELERATION,
    WITH_EXPONENT,
    WITH_STROKE,
    throughput,
)
from vibro.sweeps.run import sweep_blocks
from vibro.waveforms import PiecewiseMotion

if TYPE_CHECKING:
    from collections.abc import Mapping

    from vibro.limits import Transition
    from vibro.motion.settled import CyclePhase
    from vibro.results.sweep import Block, Column
    from vibro.sweeps.grid import Grid

__all__ = [
    "OneScene",
    "beginnings",
    "bounce_text",
    "bound",
    "estimate",
    "facts_of",
    "motion_text",
    "number",
    "phase_rows",
    "throughput_text",
]

_MOST_PHASES: Final = 40  # a longer table is not readable
_RAISED: Final = 1.1  # larger amplitude of the estimate, over that of the scene
_TOLD: Final = 9  # decimals of a percentage, below which there is rounding alone
_LEAST_CERTAIN: Final = 1.0 / 3.0  # standard error over the size of a mean whose sign is not in doubt
_FIRST: Final = 1000  # drive cycles of an undisturbed body, printed beside a mean
_SIGMAS: Final = 3.0  # standard errors by which a mean may be off


class OneScene:
    """One solved scene in words and in the user's units.

    Parameters
    ----------
    block : Block
        Of a single cell.

    Attributes
    ----------
    given : dict of str to float
        Every quantity of the scene, in the units outside; the stroke in place of the amplitude if it was
        given.
    scene : Scene
        The same.
    length : float
        Length of the trough, NaN without one [mm].
    regime : Regime
        Class of the motion.
    status : Status
        Whether the numbers are exact, or why there are none.
    values : mapping of str to array
        Of the block.
    """

    def __init__(self, block: Block) -> None:
        values = {name: float(value.item()) for name, value in block.values.items() if name in QUANTITIES}
        self.given = as_given(values, in_stroke=block.in_stroke)
        moved = {name: value for name, value in block.values.items() if name not in QUANTITIES}
        self.scene = Scene(**scene_fields({**self.given, **moved}))
        self.length = math.nan if block.length is None else block.length
        self.regime = Regime(int(block.cycle.regime.item()))
        self.status = Status(int(block.cycle.status.item()))
        self.values = block.values
        self._block = block
        self._cycle = block.cycle

    def value(self, column: Column) -> float:
        """Return the number that a table has in a column."""
        return float(np.asarray(column.values(self._block)).item())

    def result(self, name: str) -> float:
        """Return a length or speed of the cycle [mm, mm/s]."""
        return float(LENGTH.from_si(getattr(self._cycle, name).item()))

    @property
    def traverse_time(self) -> float | None:
        """Length over mean speed [s]; None where the body never arrives or that is unknown."""
        if math.isnan(self.length):
            return None
        time = float(self._cycle.traverse_time(LENGTH.to_si(self.length)))
        return time if math.isfinite(time) else None

    @property
    def pattern(self) -> str:
        """Letters of the phases of a steady cycle, ``F_B_``; empty if there is none."""
        return str(self._cycle.pattern)

    @property
    def throw_number(self) -> float:
        """Most unloading over the weight on the trough [1]."""
        return float(self._cycle.throw_number)

    @property
    def hops(self) -> bool:
        """Whether the body leaves the trough."""
        return self.regime is Regime.HOPPING

    @property
    def relative_error(self) -> float:
        """Standard error of the mean speed over its size; 0 if the speed is not a mean [1]."""
        error = float(self._cycle.mean_velocity_error)
        return error / abs(float(self._cycle.mean_velocity)) if error > 0.0 else 0.0

    @property
    def is_certain(self) -> bool:
        """Whether it is sure which way the body is conveyed."""
        return self.relative_error <= _LEAST_CERTAIN

    @property
    def is_still(self) -> bool:
        """Whether the displacement of the body is rounding alone."""
        size = LENGTH.from_si(float(self.scene.scale))
        return bool(abs(self.result("displacement_per_cycle")) <= LEAST_DIFFERENCE * size)

    @property
    def period(self) -> float:
        """Time after which the steady motion repeats; NaN where that is never, or not soon [s]."""
        return float(self._cycle.period_cycles) / float(self.scene.frequency)

    @property
    def arrival_time(self) -> float:
        """Time from rest at trough phase 0 to the arrival; inf if it never arrives, NaN if unknown [s]."""
        arrival = self._block.arrival
        return math.nan if arrival is None else float(arrival.item())

    def facts(self) -> list[tuple[str, str]]:
        """Return the lines of every report, as pairs of a name and a text."""
        given = {
            name: f"{QUANTITIES[name].label} {self._told(name, value)}"
            for name, value in self.given.items()
            if value != DEFAULTS.get(name)
            and QUANTITIES[name].order <= TOLD_HARMONICS
            and name not in MACHINE
        }
        if "amplitude" in given:
            stroke = self._told("stroke", 2.0 * self.given["amplitude"])
            given["amplitude"] += f" (stroke {stroke} peak to peak)"
        elif "stroke" in given:
            amplitude = QUANTITIES["amplitude"].text(0.5 * self.given["stroke"])
            given["stroke"] += f" peak to peak (amplitude {amplitude})"
        else:
            stroke = f"stroke {number(self.value(WITH_STROKE), LENGTH.unit)} peak to peak"
            if "normal_phase" in given:
                path = "path" if self.scene.motion else "ellipse"
                told = ", ".join([*counted_harmonics(self.given), stroke])
                given["normal_phase"] += f" ({told}, the longest way across the {path})"
            else:
                given = {"motion": f"{motion_text(self.scene)} ({stroke})"} | given
        pattern = self.pattern
        facts = [
            ("scene", ", ".join(given.values())),
            ("regime", (self.regime.label or "none") + (f", pattern {pattern}" if pattern else "")),
        ]
        if self.status is not Status.OK:
            facts.append(("status", f"{self.status.label} ({self.status.message})"))
        if note := self._other_motions():
            facts.append(("note", note))
        speed = self.result("mean_velocity")
        known = estimate(speed, self.result("mean_velocity_error"), "mm/s")
        unknown = f"none: it gains speed every cycle, {self.runs}" if self.runs else "unknown"
        facts.append(("mean speed", unknown if math.isnan(speed) else known))
        if self.status is Status.AVERAGED:
            facts.append(("from rest", f"{number(self._at_first(), 'mm/s')} in the first {_FIRST} cycles"))
        if self._cycle.flight_fraction > 0.0:
            facts.append(("restitution", bounce_text(self.given["restitution"])))
        return facts

    def _told(self, name: str, value: float) -> str:
        """Write a quantity as it was given; an amplitude that follows from a machine to 6 digits."""
        if OPERATING in self.values and name in ("amplitude", "stroke"):
            return number(value, LENGTH.unit)
        return QUANTITIES[name].text(value)

    def _at_first(self) -> float:
        """Return the mean speed of an undisturbed body in its first cycles from rest [mm/s]."""
        last = simulate(self.scene, cycles=_FIRST).phases[-1]
        return float(LENGTH.from_si(last.end_position / last.end))

    @property
    def runs(self) -> str:
        """Direction of a body that gains speed every cycle; empty for other bodies."""
        slope = float(self.scene.trough_angle)
        if self.status is not Status.RUNAWAY or not slope:
            return ""
        return "backwards, down the track" if slope > 0.0 else "forwards, down the trough"

    def _other_motions(self) -> str:
        """Describe other motions of a disturbed body; empty if none exist, or none were searched for.

        Those that may end irregular motion are looked for, which takes a few ms: a mean over many bodies is
        of no use to somebody whose body is captured.
        """
        if self.status is Status.AVERAGED:
            from vibro.motion.attractors import attractors

            speeds = sorted(SPEED.from_si(one.mean_velocity) for one in attractors(self.scene) if one.stable)
            if not speeds:
                return ""
            ends = dict.fromkeys(number(speed) for speed in (speeds[0], speeds[-1]))
            count = (
                f"one that repeats, at {number(speeds[0], 'mm/s')},"
                if len(speeds) == 1
                else (f"{len(speeds)} that repeat, at {' to '.join(ends)} mm/s,")
            )
            return f"several motions exist: {count} may capture the body for good"
        if self._cycle.coexists > 0:
            slope, mu_d = math.tan(float(self.scene.trough_angle)), float(self.scene.kinetic_friction)
            if abs(slope) > mu_d:
                return "a body pushed downhill runs away: gravity along the trough exceeds kinetic friction"
            return "a disturbed body can settle into another steady motion than one from rest"
        if self._cycle.coexists == 0 and self.hops:
            return "no other steady motion was found, within 64 flights from 64 disturbed starts"
        return ""

    def numbers(self) -> list[tuple[str, str]]:
        """Return the other numbers of the cycle, as pairs of a name and a text; none if unknown."""
        if math.isnan(self.result("mean_velocity")):
            return []
        numbers = [
            ("peak speed", number(self.result("peak_velocity"), "mm/s")),
            ("per cycle", number(self.result("displacement_per_cycle"), "mm")),
        ]
        if self._cycle.flight_fraction > 0.0:
            period = float(self._cycle.period_cycles)
            numbers += [
                ("in flight", f"{number(100.0 * float(self._cycle.flight_fraction))} % of the time"),
                ("impact speed", f"{number(self.result('impact_velocity'), 'mm/s')} normal to the trough"),
                ("repeats", "never: irregular motion" if math.isnan(period) else _cycles(period)),
            ]
        return numbers

    def why_never(self) -> str:
        """Say why there is no traverse time and, if the body rests, what to change."""
        speed = self.result("mean_velocity")
        if self.runs:
            return f"none at a mean speed: the body runs {self.runs}, and gains speed every cycle"
        if math.isnan(speed):
            return f"unknown: {self.status.message}"
        if not self.is_certain:
            return "unknown: within the standard error the mean speed may have either direction"
        if speed < 0:
            return f"never: the body is conveyed backwards at {number(-speed, 'mm/s')}"
        if self.regime is not Regime.NO_SLIP:
            return "never: the body slides to and fro without being conveyed"
        begins = next((t for t in self.transitions() if t.name in ("forward slip", "hopping")), None)
        if begins is None:  # beyond the range of doubles
            return "never: the body rests"
        frequency, factor = begins.frequency, f"{1.0 / begins.ratio:.4g} x"
        by_amplitude = f"{self.amplitudes(begins.ratio)} ({factor})" if len(self.driven) <= 2 else factor
        which = self.all_amplitudes or f"the {self.size}"
        told = f"never: the body rests; {begins.name} begins with {which} above {by_amplitude}"
        if math.isnan(frequency):
            return told
        by_frequency = f"above {number(frequency, 'Hz')} ({frequency / self.given['frequency']:.4g} x)"
        return f"{told} or with the frequency {by_frequency}"

    @property
    def size(self) -> str:
        """What the drive is scaled by, as it was given: ``amplitude``, ``stroke`` or ``scale``."""
        return "scale" if SCALE in self.driven else "stroke" if "stroke" in self.driven else "amplitude"

    @property
    def all_amplitudes(self) -> str:
        """Common name of the drive's amplitudes; empty for a drive along a line, which has one."""
        if SCALE in self.driven:
            return QUANTITIES[SCALE].label
        return {1: "", 2: "both amplitudes"}.get(len(self.driven), "all amplitudes")

    @property
    def driven(self) -> dict[str, float]:
        """What scales the drive, in the units outside: the size of a line, all amplitudes, or the scale."""
        amplitudes = {name: value for name, value in self.given.items() if name in SIZES}
        return amplitudes or {SCALE: self.given[SCALE]}

    def amplitudes(self, ratio: float) -> str:
        """Write the amplitudes at which the load is the scene's over ``ratio``; of many, their factor."""
        if SCALE in self.driven:
            return number(self.driven[SCALE] / ratio)
        if len(self.driven) > 2:
            return f"{number(1.0 / ratio)} x"
        return " and ".join(number(value / ratio, LENGTH.unit) for value in self.driven.values())

    @property
    def is_two_axis(self) -> bool:
        """Whether the drive moves along an ellipse, or has harmonics."""
        return self.driven.keys().isdisjoint(("amplitude", "stroke"))

    def transitions(self) -> tuple[Transition, ...]:
        """Return where each class of motion begins."""
        return transitions(self.scene)

    def phases(self) -> tuple[CyclePhase, ...]:
        """Return the cycle's phases; empty if they are not modelled, or too many."""
        if self.hops and not self._cycle.flight_fraction > 0.0:
            return ()
        phases = cycle_phases(self.scene)
        return phases if len(phases) <= _MOST_PHASES else ()


def bounce_text(restitution: float) -> str:
    """Say what the restitution means where a body lands."""
    return number(restitution) + ("" if restitution else ": parts land without a bounce")


def motion_text(scene: Scene) -> str:
    """Say what kind of motion a scene has: ``motion of 2 pieces``."""
    motion = scene.motion
    if isinstance(motion, PiecewiseMotion):
        return f"motion of {motion.breaks.size - 1} pieces"
    count = max(len(scene.along_harmonics or ()), len(scene.normal_harmonics or ()))
    return f"motion of {count} harmonic{'s' * (count > 1)}"


def _cycles(count: float) -> str:
    return "every drive cycle" if count == 1.0 else f"every {count:.0f} drive cycles"


def facts_of(one: OneScene, grid: Grid) -> list[tuple[str, str]]:
    """Return the lines of the report on one scene, as pairs of a name and a text.

    Parameters
    ----------
    one : OneScene
        The scene.
    grid : Grid
        Its single cell; it is solved once more with a larger amplitude.
    """
    along = "at most along the path" if one.is_two_axis else "along the drive (machine number A w^2/g)"
    scene, *others = one.facts()
    return [
        scene,
        *others,
        *one.numbers(),
        ("acceleration", f"{number(one.value(WITH_ACCELERATION))} g {along}"),
        ("throw number", f"{number(one.throw_number)} (above 1 the body hops)"),
        *_sensitivity(one, grid),
    ]


def _sensitivity(one: OneScene, grid: Grid) -> list[tuple[str, str]]:
    """Describe how the speed follows the amplitude: its exponent, and the speed at a larger amplitude."""
    speed = one.result("mean_velocity")
    if math.isnan(speed):
        return []
    raised = as_given({name: _RAISED * value for name, value in one.driven.items()}, in_stroke=False)
    if not all(map(math.isfinite, raised.values())):  # beyond the range of doubles
        return []
    raised_grid = replace(grid, fixed={**grid.fixed, **raised}, coexistence=False, machine=None)
    (block,) = sweep_blocks(raised_grid)
    more = OneScene(block)
    then = more.result("mean_velocity")
    if math.isnan(then):
        told = f"speed unknown ({more.status.message})"
    elif not one.is_still and then / speed > 0.0:
        gain = then / speed
        error = 100.0 * gain * math.hypot(one.relative_error, more.relative_error)
        told = f"{round(100.0 * (gain - 1.0), _TOLD):+z.3g} % speed"
        told += f" +- {error:.2g} % (standard error)" if error else ""
    else:
        told = estimate(then, more.result("mean_velocity_error"), "mm/s")
    if more.regime is not one.regime:
        told += f", {more.regime.label}"
    exponent = one.value(WITH_EXPONENT)
    power = (
        "" if math.isnan(exponent) else f" (d ln speed / d ln {one.size} = {number(round(exponent, _TOLD))})"
    )
    return [("sensitivity", f"+10 % {one.all_amplitudes or one.size}: {told}{power}")]


def beginnings(one: OneScene) -> list[tuple[str, ...]]:
    """Return the rows of a table of where each kind of motion begins, its head first.

    Under a given motion classes may end and begin again: the table then has the end of each too.
    """
    which = one.all_amplitudes if one.is_two_axis else f"{one.size} [mm]"
    head = ["begins", "load now / then", which, "frequency [Hz]"]
    per_amplitude = 2.0 if one.size == "stroke" else 1.0
    rows = [
        [
            t.name,
            number(t.ratio),
            one.amplitudes(t.ratio)
            if one.is_two_axis
            else number(per_amplitude * LENGTH.from_si(t.amplitude)),
            number(t.frequency),
        ]
        for t in one.transitions()
    ]
    if one.scene.motion is not None:
        head.append(f"until {which}")
        for row, t in zip(rows, one.transitions(), strict=True):
            row.append(one.amplitudes(t.end_ratio) if t.end_ratio > 0.0 else "no end")
    # accelerations of pieces do not depend on the frequency, the amplitude of a machine does
    if isinstance(one.scene.motion, PiecewiseMotion) or OPERATING in one.values:
        del head[3]
        for row in rows:
            del row[3]
    return [tuple(row) for row in [head, *rows]]


def phase_rows(one: OneScene) -> list[tuple[str, ...]]:
    """Return the rows of a table of the cycle's phases, its head first; empty if no phases are known."""
    rows = [
        (
            PHASE_NAMES[p.kind],
            f"{1e3 * p.start:z.5f}",
            f"{1e3 * p.end:z.5f}",
            f"{LENGTH.from_si(p.displacement):z.5f}",
        )
        for p in one.phases()
    ]
    return [("phase", "start [ms]", "end [ms]", "displacement [mm]"), *rows] if rows else []


def throughput_text(one: OneScene, part: Mapping[str, float]) -> str:
    """Say how many parts pass in a row, and their mass.

    Parameters
    ----------
    one : OneScene
        The scene.
    part : mapping of str to float
        ``pitch_mm``, from each part to the next, and ``mass_kg`` of one, as far as they are known.

    Returns
    -------
    str
        Empty without a pitch.
    """
    if "pitch_mm" not in part:
        return ""
    columns = throughput(part["pitch_mm"], part.get("mass_kg"))
    values = [one.value(column) for column in columns]
    speed, error = one.result("mean_velocity"), one.result("mean_velocity_error")
    if math.isnan(speed) or speed <= 0.0 < speed + _SIGMAS * error:
        return "unknown" if math.isnan(speed) else "unknown: the direction of conveying is not certain"
    rates = [
        estimate(value, value * one.relative_error, column.unit.replace("1/min", "parts/min"))
        for value, column in zip(values, columns, strict=True)
    ]
    return f"{', '.join(rates)} at most, one part every {number(part['pitch_mm'], 'mm')}"


def estimate(value: float, error: float, unit: str = "") -> str:
    """Write a number, with its standard error if it is a mean."""
    spread = f" +- {error:.2g} {unit}".rstrip() + " (standard error)" if error > 0.0 else ""
    return number(value, unit) + spread


def number(value: float, unit: str = "") -> str:
    """Write a number for people, with six digits."""
    return f"{value:z.6g} {unit}".rstrip()


def bound(value: float, unit: str = "", *, upper: bool) -> str:
    """Write a bound for people with six digits, rounded so that it still holds."""
    rounding = ROUND_CEILING if upper else ROUND_FLOOR
    return number(float(Context(prec=6, rounding=rounding).create_decimal(repr(float(value)))), unit)
