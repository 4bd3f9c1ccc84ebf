"""Questions of inverse design: bands of parts and trough, the choices of the drives, the goal."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING

from vibro.core.codes import Regime
from vibro.inverse.spaces import SPACES, MotionSpace
from vibro.quantities import LOAD, QUANTITIES, STANDARD_GRAVITY

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from vibro.drives import Ellipse, Harmonics, Line, Piecewise
    from vibro.inverse.machine_drives import MachineDrive
    from vibro.inverse.spaces import Space
    from vibro.waveforms import Motion

__all__ = ["Drift", "Drive", "Goal", "Span", "Spec"]

#: Both ends of a closed interval.
Span = tuple[float, float]


@dataclass(frozen=True)
class Drive:
    """A drive and what may be chosen of it; limits hold for nominal values.

    Attributes
    ----------
    name : str
        For tables.
    kind : type
        ``Line`` or ``Ellipse``, or that of its motion.
    choices : mapping of str to tuple of pairs of float
        Of every knob (``Space.knobs``) the ranges to choose from, each with its ends, equal for a single
        value [SI]. Of the frequency and of the drive angle of a line there may be several.
    acceleration : float
        Largest acceleration along the path over g [1]; inf without a limit.
    in_stroke : bool
        Whether the amplitude of a line was given as its stroke, which texts then contain.
    motion : Motion or None
        Of a drive that is a given motion.
    machine : MachineDrive or None
        The machine from whose setting the amplitude follows; texts contain the setting.
    """

    name: str
    kind: type[Line | Ellipse | Harmonics | Piecewise]
    choices: Mapping[str, tuple[Span, ...]]
    acceleration: float = math.inf
    in_stroke: bool = False
    motion: Motion | None = None
    machine: MachineDrive | None = None

    @cached_property
    def space(self) -> Space:
        """Space of its settings."""
        return SPACES[self.kind] if self.motion is None else MotionSpace.of(self.motion)

    @property
    def frequency(self) -> tuple[Span, ...]:
        """All ranges of its frequency [Hz]."""
        return self.choices["frequency"]

    @property
    def told(self) -> tuple[str, ...]:
        """Names of the printed quantities of its variables: a stroke or a setting for the amplitude."""
        size = "setting" if self.machine is not None else "stroke" if self.in_stroke else "amplitude"
        return tuple(size if knob == "amplitude" else knob for knob in self.space.knobs)

    @property
    def told_per_amplitude(self) -> float:
        """Ratio of the printed size, a stroke or an amplitude, to the amplitude [1]."""
        return 2.0 if self.in_stroke else 1.0

    def scale(self, knob: str) -> float:
        """Ratio of what is told of a knob to the knob [1]; of a machine's amplitude its setting [1/m]."""
        if knob != "amplitude":
            return 1.0
        return self.told_per_amplitude if self.machine is None else 1.0 / self.machine.amplitude

    def span(self, knob: str) -> Span:
        """Return the range of a knob that has one [SI]."""
        (span,) = self.choices[knob]
        return span

    def nearest(self, knob: str, value: float) -> Span:
        """Return the range of a knob that holds a value, or is the nearest to it [SI]."""
        return min(self.choices[knob], key=lambda span: max(span[0] - value, value - span[1]))

    @property
    def accelerations(self) -> Span:
        """Largest acceleration of its gentlest and of its hardest setting, its limit aside [m/s^2].

        That of an ellipse is at least this for any phase: its larger amplitude's.
        """
        sizes = [self.span(knob) for knob in self.space.sizes]
        slow = min((low for low, _ in self.frequency), default=0.0)
        quick = max((high for _, high in self.frequency), default=0.0)
        least, most = max(low for low, _ in sizes), max(high for _, high in sizes)
        gentle, hard = self.space.load_at(least, slow, 1.0), self.space.load_at(most, quick, 1.0)
        return float(gentle), float(hard)


@dataclass(frozen=True)
class Drift:
    """Largest deviations of the drive and the trough from their nominal values, either way.

    Attributes
    ----------
    amplitude, frequency : float
        Relative to the nominal value [1]; all amplitudes drift together.
    drive_angle, trough_angle, normal_phase : float
        [rad].
    """

    amplitude: float = 0.0
    frequency: float = 0.0
    drive_angle: float = 0.0
    trough_angle: float = 0.0
    normal_phase: float = 0.0


@dataclass(frozen=True)
class Goal:
    """Goal that a design must guarantee.

    Attributes
    ----------
    speed : float
        Least mean speed [m/s].
    highest_regime : Regime
        Highest regime that may occur.
    impact_speed : float
        Largest speed of impacts normal to the trough, where bodies hop [m/s].
    flight_fraction : float
        Largest share of the time in flight.
    """

    speed: float
    highest_regime: Regime = Regime.BACK_SLIP
    impact_speed: float = math.inf
    flight_fraction: float = math.inf


@dataclass(frozen=True)
class Spec:
    """A checked question.

    Attributes
    ----------
    bands : mapping of str to pair of float
        Bands of parts and trough, by field: static_friction, kinetic_friction or friction_ratio, and
        trough_angle, without drift; both ends are equal where a value is known [1, rad].
    drives : tuple of Drive
        Drives to choose from.
    goal : Goal
        Goal of the design.
    drift : Drift
        Deviations of drive and trough.
    length : float or None
        Of the trough [m].
    gravity, restitution : float
        As in ``Scene``.
    stand_ratio : float
        Half base over height of the centre of mass of a part that must stay upright; inf where it need not.
    name : str
        Name of the file without its suffix; empty without a file.
    """

    bands: Mapping[str, Span]
    drives: tuple[Drive, ...]
    goal: Goal
    drift: Drift = field(default_factory=Drift)
    length: float | None = None
    gravity: float = STANDARD_GRAVITY
    restitution: float = 0.0
    stand_ratio: float = math.inf
    name: str = ""

    def doubts(self) -> list[str]:
        """Return warnings about ranges that are possible, but as a whole likely slips of units."""
        told = [QUANTITIES[name].doubt(*_outside(name, (span,))) for name, span in self.bands.items()]
        for drive in self.drives:
            for name, knob in zip(drive.told, drive.space.knobs, strict=True):
                told.append(QUANTITIES[name].doubt(*_outside(name, drive.choices[knob], drive.scale(knob))))
            if drive.machine is not None:
                told.append(drive.machine.doubt(drive.name))
            gentle = float(f"{drive.accelerations[0] / self.gravity:.4g}")
            told.append(LOAD.doubt(gentle, gentle))
        return [text for text in dict.fromkeys(told) if text]

    @property
    def has_bands(self) -> bool:
        """Whether any band has a width or any quantity drifts."""
        machines = [drive.machine for drive in self.drives if drive.machine is not None]
        return (
            self.drift != Drift()
            or any(low < high for low, high in self.bands.values())
            or any(machine.has_bands for machine in machines)
        )


def _outside(name: str, spans: Sequence[Span], scale: float = 1.0) -> Span:
    """Return the ends of ranges in the unit outside, as they were given."""
    ends = (min(low for low, _ in spans), max(high for _, high in spans))
    first, last = (float(f"{float(QUANTITIES[name].from_si(scale * end)):.15g}") for end in ends)
    return first, last
