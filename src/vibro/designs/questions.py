"""A question about one drive within a regime: the uncertainty sets of its settings, and their speeds."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any, Final, NamedTuple

import numpy as np

from vibro.core.codes import Regime
from vibro.designs.guarantees import ANY_LANDING, Landings, counted
from vibro.designs.spaces import SPACES, TOLERANCES, MotionSpace, UncertaintySet, cut, off
from vibro.files.entries import AT_MOST, EXACTLY
from vibro.limits import stays_upright
from vibro.quantities import LOAD, QUANTITIES, STANDARD_GRAVITY
from vibro.scene import Scene
from vibro.steady import solve

if TYPE_CHECKING:
    from collections.abc import Mapping

    from vibro.designs.spaces import AnySetting, Ends, Space, Span
    from vibro.drives import Ellipse, Harmonics, Line, Motion, Piecewise
    from vibro.machines.machine import Machine
    from vibro.quantities import Quantity
    from vibro.reals import Floats


# ------------------------------------------------------------------------------
# Questions of inverse design: bands of parts and trough, the choices of the drives, the goal.


#: [1] Band of restitution of parts that hop where none is given: most parts on most troughs
#: (docs/guide/restitution.md).
ASSUMED_RESTITUTION: Final = (0.0, 0.5)
#: Digits that reproduce every value that a user gives.
MOST_DIGITS: Final = 15
# [1] Distance from an end that is none: above the rounding of an optimum there, below all digits chosen.
_AT_END: Final = 1e-9
# quantities whose smallest value is none
_FROM_NOTHING: Final = ("amplitude", "stroke", "setting", "along_amplitude", "normal_amplitude")
# damping ratios from resonance within which damping decides much of the amplitude
_NEAR_RESONANCE: Final = 2.0


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
    filling: Span = (0.0, 0.0)
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
        if natural is None or abs(self.frequency / natural - 1.0) > _NEAR_RESONANCE * zeta:
            return ""
        return (
            f"{name}: {self.frequency:.6g} Hz is within {_NEAR_RESONANCE:g} damping ratios of the resonance "
            f"at {natural:.6g} Hz, where the amplitude depends much on damping; exchange springs"
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


@dataclass(frozen=True)
class Input:
    """A quantity that a user gives and reads, of which ranges may be chosen.

    Attributes
    ----------
    name : str
        Of the quantity: a stroke, or a machine's setting, may stand for an amplitude.
    ranges : tuple of pairs of float
        To choose from, each with its ends, equal for a single value [SI, of the knob].
    ratio : float
        Of the quantity to the knob: 2 of a stroke; of a setting over the amplitude at 100 % [1/m].
    """

    name: str
    ranges: tuple[Span, ...]
    ratio: float = 1.0

    @property
    def quantity(self) -> Quantity:
        """Its name, unit and limits."""
        return QUANTITIES[self.name]

    def printed(self, knob: Any) -> Any:
        """Convert values of the knob [SI] to what is printed, in the unit outside."""
        return self.quantity.from_si(self.ratio * knob)

    def read(self, printed: Any) -> Any:
        """Convert printed values to those of the knob [SI]."""
        return self.quantity.to_si(printed) / self.ratio

    def rounded(self, value: float, near: float, digits: int) -> float:
        """Round a printed value, within the range nearest to a knob [SI], whose ends are kept as given.

        One that may be 0 has no more decimals than a value from 10 to 100 with that many digits.
        """
        span = min(self.ranges, key=lambda span: max(span[0] - near, near - span[1]))
        low, high = (nearest(float(self.printed(end)), MOST_DIGITS) for end in span)
        for end in (low, high):
            if math.isclose(value, end, rel_tol=_AT_END):
                return end
        value = nearest(value, digits)
        if self.quantity.allowed.low < 0.0:
            value = round(value, digits - 2)
        return min(max(value, low), high)

    @property
    def choice(self) -> str:
        """What may be chosen, as files have it: ``at most 3``, ``exactly 50``, ``10:30`` or ``50, 100``."""
        spans = [
            [f"{nearest(float(self.printed(x)), MOST_DIGITS):.15g}" for x in ends] for ends in self.ranges
        ]
        if len(spans) > 1:
            return ", ".join(low for low, _ in spans)
        ((low, high),) = spans
        if low == high:
            return f"{EXACTLY} {low}"
        return f"{AT_MOST} {high}" if low == "0" and self.name in _FROM_NOTHING else f"{low}:{high}"

    @property
    def doubt(self) -> str:
        """Warning about ranges that are possible, but as a whole a likely slip of units; else empty."""
        ends = min(low for low, _ in self.ranges), max(high for _, high in self.ranges)
        return self.quantity.doubt(*(nearest(float(self.printed(end)), MOST_DIGITS) for end in ends))


def nearest(value: float, digits: int) -> float:
    """Round to so many digits."""
    return float(f"{value:.{digits}g}")


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
    def chosen_from(self) -> dict[str, str]:
        """What may be chosen of each quantity, by its key in a file."""
        choices = {given.quantity.column: given.choice for given in self.inputs.values()}
        most = self.acceleration if self.machine is None else self.machine.acceleration
        return choices | ({LOAD.column: f"{AT_MOST} {most:.15g}"} if math.isfinite(most) else {})

    @cached_property
    def inputs(self) -> dict[str, Input]:
        """What its user chooses, by knob: of a machine its setting in place of the amplitude."""
        inputs = {knob: Input(knob, self.choices[knob]) for knob in self.space.knobs}
        if self.machine is not None:
            inputs["amplitude"] = Input("setting", self.choices["amplitude"], 1.0 / self.machine.amplitude)
        elif self.in_stroke:
            inputs["amplitude"] = Input("stroke", self.choices["amplitude"], 2.0)
        return inputs

    def size(self, setting: AnySetting) -> Input:
        """Return what windows and pictures vary: a stroke, an amplitude, of an ellipse one, or a scale."""
        leading = self.space.leading(setting)
        return self.inputs[leading] if self.machine is None else Input(leading, self.choices[leading])

    def span(self, knob: str) -> Span:
        """Return the range of a knob that has one [SI]."""
        (span,) = self.choices[knob]
        return span

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
    gravity : float
        As in ``Scene``.
    restitution : pair of float, or None
        Band of the restitution of parts that hop [1]; None where none is given.
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
    restitution: Span | None = None
    stand_ratio: float = math.inf
    name: str = ""

    def doubts(self) -> list[str]:
        """Return warnings about ranges that are possible, but as a whole likely slips of units."""
        doubts = [Input(name, (span,)).doubt for name, span in self.bands.items()]
        for drive in self.drives:
            doubts += [given.doubt for given in drive.inputs.values()]
            if drive.machine is not None:
                doubts.append(drive.machine.doubt(drive.name))
            gentle = nearest(drive.accelerations[0] / self.gravity, 4)
            doubts.append(LOAD.doubt(gentle, gentle))
        return [text for text in dict.fromkeys(doubts) if text]

    @property
    def bounces(self) -> Span:
        """Band of restitution over which designs that hop are computed."""
        return ASSUMED_RESTITUTION if self.restitution is None else self.restitution

    @property
    def has_bands(self) -> bool:
        """Whether any band has a width or any quantity drifts; that of restitution is none of a margin."""
        machines = [drive.machine for drive in self.drives if drive.machine is not None]
        return (
            self.drift != Drift()
            or any(low < high for low, high in self.bands.values())
            or any(machine.has_bands for machine in machines)
        )


_RIGHT_ANGLE: Final = 0.5 * math.pi
#: [1] Throw number up to which hopping settings are searched: beyond, flights last many cycles, and landings
#: damage parts and drive.
MOST_DESIGN_THROW: Final = 10.0


@dataclass(frozen=True)
class Question:
    """A question about one drive within a regime.

    Attributes
    ----------
    spec : Spec
        The whole question.
    drive : Drive
        The drive.
    highest : Regime
        Highest regime that may occur.
    """

    spec: Spec
    drive: Drive
    highest: Regime

    @property
    def space(self) -> Space:
        """Space of the drive's settings."""
        return self.drive.space

    @property
    def flies(self) -> bool:
        """Whether bodies may hop."""
        return self.highest is Regime.HOPPING

    @cached_property
    def drift(self) -> Drift:
        """Deviations of drive and trough; voltage and filling of a machine add to that of the amplitude."""
        drift, machine = self.spec.drift, self.drive.machine
        if machine is None:
            return drift
        return replace(drift, amplitude=(1.0 + drift.amplitude) * (1.0 + machine.drift) - 1.0)

    @property
    def landings(self) -> Landings:
        """Limits on landings."""
        goal = self.spec.goal
        return Landings(goal.impact_speed, goal.flight_fraction) if self.flies else ANY_LANDING

    def box(self, setting: AnySetting, scale: Floats | float = 1.0) -> UncertaintySet:
        """Return the uncertainty set of a setting, or of several where these are arrays of shape (m, 1).

        Parameters
        ----------
        setting : AnySetting
            Nominal values.
        scale : float or array
            Factor on all bands and drifts about their middles; bands are cut at impossible values. That of
            restitution is not scaled: speeds go up and down along it.
        """
        bands, drift = self.spec.bands, self.drift
        is_ratio = "friction_ratio" in bands
        low, high = bands["trough_angle"]
        short, most = TOLERANCES.short, 1.0 if is_ratio else math.inf
        trough = cut(
            _scaled((low - drift.trough_angle, high + drift.trough_angle), scale),
            short - _RIGHT_ANGLE,
            _RIGHT_ANGLE - short,
        )
        second = _scaled(bands["friction_ratio" if is_ratio else "kinetic_friction"], scale)
        factor, shape = self.space.band(setting, drift, scale, _RIGHT_ANGLE - short - trough[1])
        return UncertaintySet(
            space=self.space,
            factor=factor,
            frequency=off(setting.frequency, drift.frequency * scale),
            shape=shape,
            trough_angle=trough,
            static_friction=cut(_scaled(bands["static_friction"], scale), 0.0, math.inf),
            second_friction=cut(second, 0.0, most),
            is_ratio=is_ratio,
            restitution=self.spec.bounces if self.flies else (0.0, 0.0),
            gravity=self.spec.gravity,
        )

    def load(self, setting: AnySetting) -> Floats:
        """Nominal load of a setting: the largest acceleration along its path over g [1]."""
        return self.space.load(setting, self.spec.gravity)

    def nominal_scene(self, setting: AnySetting) -> Scene:
        """Return the scene of a setting in the middle of all bands."""
        box = self.box(setting, 0.0)
        points = box.points(np.full((len(box.axes), *np.shape(setting[0])), 0.5))
        return box.scene(points, fast=False)

    def growth(self, scale: Floats | float) -> Floats | float:
        """Return the ratio of the largest load in a box to the nominal one."""
        drift = self.drift
        return (1.0 + drift.amplitude * scale) * (1.0 + drift.frequency * scale) ** self.space.power

    def speeds(self, setting: AnySetting, scenarios: Floats, scale: Floats | float = 1.0) -> Floats:
        """Speeds of scenarios at settings, 1-D, of shape (settings, scenarios).

        -inf where a body breaks a constraint; NaN where its speed is unknown and it is left out.
        """
        columns = setting._make(np.reshape(x, (-1, 1)) for x in setting)
        boxes = self.box(columns, np.reshape(scale, (-1, 1)))
        points = boxes.points(scenarios[:, None, :])
        scene = boxes.scene(points, fast=False)
        cycle = solve(scene, flight=self.flies)
        bad = self.landings.broken(boxes, points, cycle)
        bad |= np.asarray(cycle.regime) > self.highest
        if math.isfinite(self.spec.stand_ratio):
            bad |= stays_upright(scene, self.spec.stand_ratio) != 1
        return np.where(bad, -np.inf, counted(cycle, fast=False))


def _scaled(band: Span, scale: Any) -> Ends:
    """Scale a band about its middle; a scale of 1 keeps it to the last bit."""
    low, high = band
    middle, half = 0.5 * (low + high), 0.5 * (high - low)
    plain = np.equal(scale, 1.0)
    return np.where(plain, low, middle - half * scale), np.where(plain, high, middle + half * scale)
