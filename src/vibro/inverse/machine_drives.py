"""Machines as drives of a design question: the amplitude that each setting gives, empty and full.

A machine with one spring pack at one frequency is a drive along a line. Of an empty trough the amplitude is
in proportion to the setting; voltage and filling make an interval of it. The drive has the middle of that
interval as its amplitude, and half of its width as drift, so that searches and guarantees are those of any
other drive.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any, Final, NamedTuple

import numpy as np

from vibro.core.codes import Regime
from vibro.inverse.extremes import counted
from vibro.inverse.proofs import corners
from vibro.inverse.rounding import DIGITS, rounded
from vibro.inverse.search import sobol
from vibro.inverse.spaces import inside, off
from vibro.machines.operating import operate
from vibro.steady import solve

if TYPE_CHECKING:
    from collections.abc import Mapping

    from numpy.typing import NDArray

    from vibro.inverse.questions import Question
    from vibro.inverse.spaces import Setting
    from vibro.inverse.specs import Drive, Span
    from vibro.machines.machine import Machine, Response

    Floats = NDArray[np.float64]

__all__ = ["MachineDrive", "Met", "amplitudes_met", "covering"]

_EMPTY: Final = (0.0, 0.0)
_LEVELS: Final = (0.0, 0.25, 0.5, 0.75, 1.0)  # shares of the band of filling
_NEAR: Final = 2.0  # damping ratios from resonance within which damping decides much of the amplitude
_DRAWN: Final = 8  # base-2 logarithm of the number of samples that are drawn evenly
_SHARES: Final = ("added_mass_share", "added_damping_share")
_SEED: Final = 20


@dataclass(frozen=True, kw_only=True)
class MachineDrive:
    """A machine with one spring pack, and what its amplitude depends on.

    Attributes
    ----------
    machine : Machine
        With this pack.
    pack : str
        Name of the pack; empty of a machine with one.
    natural_frequency : float or None
        Of the empty machine [Hz]; None of machines without one.
    frequency : float
        At which it is driven [Hz]; where its amplitude does not depend on it, any of the frequencies.
    settings : pair of float
        That may be chosen, over 100 % [1].
    voltage : pair of float
        Band of the voltage over the nominal one [1].
    filling : pair of float
        Band of the mass in the trough [kg].
    shares : mapping of str to pair of float
        Bands of ``added_mass_share`` and ``added_damping_share``, where they are given [1].
    acceleration : float
        Largest acceleration of the empty trough over g [1]; inf without a limit.
    covered : pair of float
        Smallest and largest amplitude that voltage and filling make, over that of the empty trough at the
        middle voltage, which designs cover [1].
    ended_by : str
        What keeps settings from being larger: ``limit``, ``gap``, ``hop`` or ``back slip``.
    """

    machine: Machine
    pack: str = ""
    natural_frequency: float | None = None
    frequency: float
    settings: Span = (0.0, 1.0)
    voltage: Span = (1.0, 1.0)
    filling: Span = _EMPTY
    shares: Mapping[str, Span] = field(default_factory=dict)
    acceleration: float = math.inf
    covered: Span = (1.0, 1.0)
    ended_by: str = "limit"

    @cached_property
    def full_amplitude(self) -> float:
        """Amplitude of the empty trough at 100 % and the middle voltage [m]."""
        voltage = 0.5 * sum(self.voltage)
        return float(self.machine.response(self.frequency, setting=1.0, voltage=voltage).amplitude)

    @cached_property
    def amplitude(self) -> float:
        """Amplitude in the middle of the covered interval, at 100 % [m]."""
        return self.middle * self.full_amplitude

    @property
    def middle(self) -> float:
        """Middle of the covered interval [1]."""
        return 0.5 * sum(self.covered)

    def doubt(self, name: str) -> str:
        """Return a warning if the drive is near resonance, else an empty text; ``name`` is the drive's."""
        natural, zeta = self.natural_frequency, self.machine.damping_ratio
        if natural is None or abs(self.frequency / natural - 1.0) > _NEAR * zeta:
            return ""
        return (
            f"{name}: {self.frequency:.6g} Hz is within {_NEAR:g} damping ratios of the resonance at "
            f"{natural:.6g} Hz, where the amplitude depends much on damping; exchange springs"
        )

    @property
    def drift(self) -> float:
        """Deviation of the amplitude from that middle, either way, over it [1]."""
        low, high = self.covered
        return (high - low) / (high + low)

    @property
    def is_filled(self) -> bool:
        """Whether anything lies in its trough, so that its amplitude depends on the parts."""
        return self.filling[1] > 0.0

    @staticmethod
    def is_tuned(machine: Machine) -> bool:
        """Whether springs make the amplitude depend on the frequency; a crank and soft mounts do not."""
        return 0.0 < machine.natural_frequency < math.inf

    @property
    def is_plain(self) -> bool:
        """Whether its amplitude at a setting is the same at all frequencies and for all parts."""
        return self.natural_frequency is None and not self.is_filled

    @property
    def has_bands(self) -> bool:
        """Whether its amplitude at a setting is an interval."""
        return self.voltage[0] < self.voltage[1] or self.is_filled


def covering(drive: Drive, covered: Span, most: float = math.inf, ended_by: str = "gap") -> Drive:
    """Return the drive of the same machine whose designs cover another interval of amplitudes.

    ``most`` is the largest setting [1], where that of the machine is too large, and ``ended_by`` tells why.
    """
    assert drive.machine is not None
    low, high = drive.machine.settings
    if most < high:
        high = rounded(100.0 * most, DIGITS, down=True) / 100.0
    else:
        ended_by = drive.machine.ended_by
    machine = replace(drive.machine, covered=covered, settings=(low, high), ended_by=ended_by)
    low, high = (setting * machine.amplitude for setting in machine.settings)
    choices = {**drive.choices, "amplitude": ((low, high),)}
    return replace(
        drive, machine=machine, choices=choices, acceleration=machine.acceleration * machine.middle
    )


class Met(NamedTuple):
    """Amplitudes that a machine has at a setting, over that of its empty trough at the middle voltage.

    Attributes
    ----------
    low, high : float
        Smallest and largest one; NaN where the motion of some filling is unknown [1].
    number : int
        Largest number of operating points at one setting, voltage, filling and friction.
    most_setting : float
        Setting up to which trough and counter mass do not strike each other, about: their relative amplitude
        is nearly in proportion to it; inf without a gap [1].
    strikes : bool
        Whether they do strike each other.
    second_harmonic : float
        Largest second harmonic that the filling puts on the trough, over its amplitude [1].
    speed : float
        Least mean speed of the samples with that harmonic in the trough's motion [m/s].
    regime : Regime
        Highest one of them.
    throw_number : float
        Largest one of them [1].
    """

    low: float
    high: float
    number: int
    most_setting: float = math.inf
    strikes: bool = False
    second_harmonic: float = 0.0
    speed: float = math.inf
    regime: Regime = Regime.NO_SLIP
    throw_number: float = 0.0


def amplitudes_met(question: Question, setting: Setting) -> Met:
    """Return the amplitudes at a setting of a machine's drive, over all bands and drifts.

    Parameters
    ----------
    question : Question
        Of the machine's drive.
    setting : Setting
        Nominal motion of the trough; its amplitude is the middle of the covered interval.

    Notes
    -----
    The interval is that of samples: voltages at both ends of their band, fillings at ends and between, parts
    at the corners and in the middle of the bands of friction and angles; and as many drawn evenly from all.
    """
    machine = question.drive.machine
    assert machine is not None
    drift = question.spec.drift
    share = float(question.space.amplitude(setting)) / machine.amplitude
    settings = share * np.unique([1.0 - drift.amplitude, 1.0, 1.0 + drift.amplitude])
    frequencies = _around(float(setting.frequency), drift.frequency, machine.natural_frequency)
    box = question.box(setting)
    bands = [_span(x) for x in (settings, frequencies, machine.voltage, machine.filling)]
    bands += [machine.shares[name] for name in _SHARES if name in machine.shares]
    levels = [settings, frequencies, np.unique(machine.voltage), _levels(machine.filling)]
    levels += [np.unique(span) for span in bands[4:]]
    varies = box.varies & (np.array(box.axes) != "load")
    parts = np.hstack([corners(varies), np.full((len(box.axes), 1), 0.5)])[:, : 1 + 2 ** varies.sum()]
    grid = np.meshgrid(*levels, np.arange(parts.shape[1]), indexing="ij")
    *values, which = (x.ravel() for x in grid)
    coordinates = parts[:, which]
    drawn = sobol(len(bands) + len(box.axes), _DRAWN, _SEED)
    values = [
        np.append(known, inside(span, share))
        for known, span, share in zip(values, bands, drawn, strict=False)
    ]
    coordinates = np.hstack([coordinates, drawn[len(bands) :]])
    scale, f, voltage, filling, *shares = values
    points = box.points(coordinates)
    given: dict[str, Any] = dict(zip(_SHARES, shares, strict=False))
    found = operate(
        machine.machine,
        frequency=f,
        drive_angle=points.shape[0],
        static_friction=points.static_friction,
        kinetic_friction=points.kinetic_friction,
        trough_angle=points.trough_angle,
        gravity=question.spec.gravity,
        restitution=question.spec.restitution,
        setting=scale,
        voltage=voltage,
        filling=filling,
        allow_strikes=True,
        **given,
    )
    # the amplitude of an empty trough is in proportion to the setting
    empty = scale * machine.full_amplitude
    low, high = (np.asarray(x) / empty for x in (found.amplitude_low, found.amplitude_high))
    most = scale * machine.machine.gap / np.asarray(found.relative_amplitude)
    met = Met(
        float(low.min()),
        float(high.max()),
        int(np.max(found.number)),
        float(np.min(most[np.isfinite(most)], initial=math.inf)),
        bool(np.any(found.strikes)),
    )
    if not met.low > 0.0:
        return met
    cycle = solve(found.scene_with_second_harmonic)
    return met._replace(
        second_harmonic=float(np.nan_to_num(found.second_harmonic).max()),
        speed=float(np.fmin.reduce(counted(cycle, fast=False))),
        regime=Regime(int(cycle.regime.max())),
        throw_number=float(cycle.throw_number.max()),
    )


def most_setting(machine: MachineDrive, drift: float) -> float:
    """Return the setting at which trough and counter mass of an empty machine strike each other [1].

    Parameters
    ----------
    machine : MachineDrive
        The machine.
    drift : float
        Of the frequency, either way [1].
    """
    return float(machine.machine.gap / np.max(_empty(machine, drift).relative_amplitude))


def empty_band(machine: MachineDrive, drift: float) -> Span:
    """Return the smallest and the largest amplitude of an empty trough, over that at the middle voltage.

    Parameters
    ----------
    machine : MachineDrive
        The machine.
    drift : float
        Of the frequency, either way [1].
    """
    ratios = np.asarray(_empty(machine, drift).amplitude) / machine.full_amplitude
    return float(ratios.min()), float(ratios.max())


def _empty(machine: MachineDrive, drift: float) -> Response:
    """Return the empty machine's motion over the drift of its frequency and the band of its voltage."""
    frequencies = _around(machine.frequency, drift, machine.natural_frequency)
    return machine.machine.response(frequencies[:, None], voltage=np.array(machine.voltage))


def _around(frequency: float, drift: float, resonance: float | None) -> Floats:
    """Return a frequency with both ends of its drift, and resonance, where the drift passes it [Hz]."""
    low, high = off(frequency, drift)
    ends = (
        [low, frequency, high] if resonance is None else [low, frequency, high, np.clip(resonance, low, high)]
    )
    return np.unique(np.array(ends, np.float64))


def _span(values: Any) -> Span:
    return float(min(values)), float(max(values))


def _levels(span: Span) -> Floats:
    return np.unique(inside(span, np.array(_LEVELS)))
