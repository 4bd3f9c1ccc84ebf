"""What the commands say of one scene: its regime, where the next ones begin, its phases."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Final, NamedTuple

import numpy as np

from vibro.core.codes import Regime, Status
from vibro.core.contact.legs import Mode
from vibro.core.contact.limits import critical_loads
from vibro.core.contact.phases import Phase, steady_phases
from vibro.core.groups import loads
from vibro.quantities import QUANTITIES, from_si, to_si
from vibro.scene import STANDARD_GRAVITY

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

    from vibro.core.groups import Loads
    from vibro.sweeps.run import Block

__all__ = ["OneScene", "Transition", "aligned", "number"]

# Left out of a report, where everybody takes them for granted.
_UNSAID: Final = {"trough_angle": 0.0, "gravity": STANDARD_GRAVITY, "restitution": 0.0}
_PHASES: Final = {"H": "flight", "h": "short flights", "F": "forward slide", "B": "back slide", "_": "rest"}
_KINDS: Final = {Mode.FLIGHT: "H", Mode.FORWARD: "F", Mode.BACK: "B", Mode.REST: "_"}
_LONGEST_RUN: Final = 1000.0  # drive cycles from rest in which phases with flights must have begun to repeat
_MOST_PHASES: Final = 40  # a longer table says nothing
_SHORT: Final = 1e-2  # [rad] flights below this are told together
_BEGINNINGS: Final = {
    "forward_onset": "forward slip",
    "back_onset": "load for back slip",
    "back_slip": "back slip",
    "rest_vanishes": "never at rest",
    "hop": "hopping",
}


class Transition(NamedTuple):
    """Where a kind of motion begins, as seen from one scene.

    Attributes
    ----------
    name : str
        What begins.
    ratio : float
        The scene's load over the load at which it begins; it has begun above 1.
    amplitude : float
        Amplitude at which it begins at the scene's frequency [mm].
    frequency : float
        Frequency at which it begins at the scene's amplitude [Hz].
    """

    name: str
    ratio: float
    amplitude: float
    frequency: float


class OneScene:
    """One solved scene in words and in the user's units.

    Parameters
    ----------
    block : Block
        Of a single cell.

    Attributes
    ----------
    given : dict of str to float
        Every quantity of the scene.
    load : float
        Peak acceleration of the drive over gravity, G.
    length : float
        Length of the trough, NaN without one [mm].
    """

    def __init__(self, block: Block) -> None:
        self.given = {name: float(value.item()) for name, value in block.values.items()}
        self.length = math.nan if block.length is None else block.length
        self._cycle = block.cycle
        self._arrival = block.arrival
        self._si = {name: to_si(name, value) for name, value in self.given.items()}
        self.load = self._si["amplitude"] * (2 * math.pi * self._si["frequency"]) ** 2 / self._si["gravity"]

    def result(self, name: str) -> float:
        """Return a length or speed of the cycle [mm, mm/s]."""
        return float(from_si("amplitude", getattr(self._cycle, name).item()))

    @property
    def traverse_time(self) -> float | None:
        """Length over mean speed [s]; None where the body never arrives or nobody knows."""
        if math.isnan(self.length):
            return None
        time = float(self._cycle.traverse_time(to_si("trough_length", self.length)))
        return time if math.isfinite(time) else None

    @property
    def arrival_time(self) -> float:
        """Time from rest at trough phase 0 to the arrival; inf where there is none, NaN if unknown [s]."""
        return math.nan if self._arrival is None else float(self._arrival.item())

    def facts(self) -> list[tuple[str, str]]:
        """Return what every report says, as pairs of a name and a text."""
        given = (
            f"{QUANTITIES[name].label} {QUANTITIES[name].text(value)}"
            for name, value in self.given.items()
            if value != _UNSAID.get(name)
        )
        regime, pattern = Regime(int(self._cycle.regime)), str(self._cycle.pattern)
        status = Status(int(self._cycle.status))
        facts = [
            ("scene", ", ".join(given)),
            ("regime", (regime.label or "none") + (f", pattern {pattern}" if pattern else "")),
        ]
        if status is not Status.OK:
            facts.append(("status", f"{status.label} ({status.message})"))
        if self._cycle.coexists:
            facts.append(("note", "a disturbed body can settle into another steady cycle than one from rest"))
        speed, error = self.result("mean_velocity"), self.result("mean_velocity_error")
        spread = f" +- {error:.2g} mm/s (standard error)" if error > 0.0 else ""
        known = number(speed, "mm/s") + spread
        facts.append(("mean speed", "unknown" if math.isnan(speed) else known))
        return facts

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
                ("repeats", "no short period" if math.isnan(period) else _cycles(period)),
            ]
        return numbers

    def why_never(self) -> str:
        """Say why there is no traverse time, and what to change where the body rests."""
        speed = self.result("mean_velocity")
        if math.isnan(speed):
            return f"unknown: {Status(int(self._cycle.status)).message}"
        if speed < 0:
            return f"never: the body is conveyed backwards at {number(-speed, 'mm/s')}"
        if Regime(int(self._cycle.regime)) is not Regime.NO_SLIP:
            return "never: the body slides to and fro without being conveyed"
        begins = next(t for t in self.transitions() if t.name in ("forward slip", "hopping"))
        amplitude, frequency = self.given["amplitude"], self.given["frequency"]
        by_amplitude = f"above {number(begins.amplitude, 'mm')} ({begins.amplitude / amplitude:.4g} x)"
        by_frequency = f"above {number(begins.frequency, 'Hz')} ({begins.frequency / frequency:.4g} x)"
        return (
            f"never: the body rests; {begins.name} begins with the amplitude {by_amplitude}"
            f" or with the frequency {by_frequency}"
        )

    def transitions(self) -> list[Transition]:
        """Return where each kind of motion begins, by its load; without those that hopping forestalls."""
        names = ("drive_angle", "static_friction", "kinetic_friction", "trough_angle")
        limits = {
            name: float(value)
            for name, value in critical_loads(*(self._si[n] for n in names))._asdict().items()
        }
        found = []
        for name, limit in limits.items():
            merely_load = name == "back_onset" and limit == limits["back_slip"]
            if merely_load or not 0.0 < limit < math.inf or (name != "hop" and limit >= limits["hop"]):
                continue
            ratio = self.load / limit
            amplitude, frequency = self.given["amplitude"] / ratio, self.given["frequency"] / math.sqrt(ratio)
            found.append(Transition(_BEGINNINGS[name], ratio, amplitude, frequency))
        return sorted(found, key=lambda transition: transition.amplitude)

    def phases(self) -> list[tuple[str, float, float, float]]:
        """Return the cycle's phases: name, start and end after trough phase 0 [ms], displacement [mm]."""
        names = (
            "amplitude", "frequency", "drive_angle", "static_friction", "kinetic_friction", "trough_angle",
            "gravity",
        )  # fmt: skip
        scene = loads(*(np.array([self._si[name]]) for name in names))
        if self._cycle.flight_fraction > 0.0:
            phases = _phases_with_flights(scene, self._si["restitution"])
        else:
            phases = steady_phases(scene, int(self._cycle.pattern_code))
        milliseconds = 1e3 / (2 * math.pi * self.given["frequency"])
        return [
            (
                _PHASES[p.kind],
                p.start * milliseconds,
                p.end * milliseconds,
                p.displacement * self.given["amplitude"],
            )
            for p in phases
        ]


def _phases_with_flights(scene: Loads, restitution: float) -> list[Phase]:
    """Phases of the steady cycle of a body that hops; empty if they do not repeat soon, or are too many."""
    from vibro.core.walk.histories import follow
    from vibro.core.walk.steps import course_of

    steady = follow(course_of(scene, np.array([restitution])), 0.0, 0.0, _LONGEST_RUN).steady
    starts = 2 * math.pi * (steady.cycle - steady.cycle[:1]) + steady.phase
    columns = (steady.mode, starts, starts + steady.length, steady.displacement)
    rows = zip(*(column.tolist() for column in columns), strict=True)
    phases: list[Phase] = []
    for mode, start, end, displacement in rows:
        kind = "h" if mode == Mode.FLIGHT and end - start < _SHORT else _KINDS[mode]
        if phases and phases[-1].kind == kind == "h":
            start, displacement = phases[-1].start, phases.pop().displacement + displacement
        phases.append(Phase(kind, start, end, displacement))
    return phases if len(phases) <= _MOST_PHASES else []


def _cycles(count: float) -> str:
    return "every drive cycle" if count == 1.0 else f"every {count:.0f} drive cycles"


def number(value: float, unit: str = "") -> str:
    """Write a number for people, with six digits."""
    return f"{value:.6g} {unit}".rstrip()


def aligned(rows: Iterable[Sequence[str]], *, right: bool = True) -> str:
    """Return rows as lines with their cells below each other, all but the first to the right if wanted."""
    rows = list(rows)
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    lines = []
    for first, *rest in rows:
        cells = [cell.rjust(w) if right else cell for cell, w in zip(rest, widths[1:], strict=True)]
        lines.append("  ".join([first.ljust(widths[0]), *cells]).rstrip())
    return "\n".join(lines)
