"""Questions of inverse design: what is known of parts and trough, what may be chosen, and what is wanted."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from vibro.core.codes import Regime
from vibro.quantities import STANDARD_GRAVITY

if TYPE_CHECKING:
    from collections.abc import Mapping

__all__ = ["AnyDrive", "Drift", "Drive", "EllipticalDrive", "Goal", "Spec"]

Span = tuple[float, float]


@dataclass(frozen=True)
class Drive:
    """A drive and what may be chosen of it; limits hold for nominal values.

    Attributes
    ----------
    name : str
        For tables.
    amplitude : tuple of float
        Smallest and largest [m]; the smallest is 0 where only the largest is given.
    frequency, drive_angle : tuple of pairs of float
        The choices: each is a range with its ends, equal for a single value [Hz, rad].
    acceleration : float
        Largest A w^2 / g [1]; inf without a limit.
    """

    name: str
    amplitude: Span
    frequency: tuple[Span, ...]
    drive_angle: tuple[Span, ...]
    acceleration: float = math.inf


@dataclass(frozen=True)
class EllipticalDrive:
    """An elliptical drive and what may be chosen of it; limits hold for nominal values.

    Attributes
    ----------
    name : str
        For tables.
    along_amplitude, normal_amplitude, normal_phase : tuple of float
        Ranges with their ends, equal for a single value [m, m, rad].
    frequency : tuple of pairs of float
        The choices, as for ``Drive`` [Hz].
    acceleration : float
        Largest acceleration along the path over g [1]; inf without a limit.
    """

    name: str
    along_amplitude: Span
    normal_amplitude: Span
    normal_phase: Span
    frequency: tuple[Span, ...]
    acceleration: float = math.inf


AnyDrive = Drive | EllipticalDrive


@dataclass(frozen=True)
class Drift:
    """By how much the drive and the trough may be off their nominal values, either way.

    Attributes
    ----------
    amplitude, frequency : float
        Relative to the nominal value [1]; both amplitudes of an ellipse drift together.
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
    """What a design must guarantee.

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
        What is known of parts and trough, by field: static_friction, kinetic_friction or friction_ratio,
        trough_angle, without drift; both ends are equal where it is known [1, rad].
    drives : tuple of Drive or EllipticalDrive
        What may be chosen.
    goal : Goal
        What is wanted.
    drift : Drift
        What the drive may do by itself.
    length : float or None
        Of the trough [m].
    gravity, restitution : float
        As in ``Scene``.
    stand_ratio : float
        Half base over height of the centre of mass of a part that must stay upright; inf where it need not.
    name : str
        Of the file, without its suffix; empty where there is none.
    """

    bands: Mapping[str, Span]
    drives: tuple[AnyDrive, ...]
    goal: Goal
    drift: Drift = field(default_factory=Drift)
    length: float | None = None
    gravity: float = STANDARD_GRAVITY
    restitution: float = 0.0
    stand_ratio: float = math.inf
    name: str = ""

    @property
    def has_bands(self) -> bool:
        """Whether anything is unknown or drifts."""
        return self.drift != Drift() or any(low < high for low, high in self.bands.values())
