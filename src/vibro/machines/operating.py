"""Operating points of a machine with its filling: the amplitude at which both agree, Eq. (87)."""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import TYPE_CHECKING, Any, Final, NamedTuple

import numpy as np

from vibro.core.codes import Status, is_answered
from vibro.drives import Motion
from vibro.errors import InputError, shown
from vibro.fillings import filling_of
from vibro.machines.machine import Machine, broadcast, driven, transfer
from vibro.quantities import QUANTITIES, STANDARD_GRAVITY
from vibro.reals import NotRealError, real_array, shielded
from vibro.results.operating import WARNED_HARMONIC
from vibro.scene import Scene
from vibro.steady import check_switch, solve
from vibro.threads import Grid, Scratch, doors, lasting, over_cells

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray

    from vibro.machines.machine import Transfer
    from vibro.reals import Complexes, Floats

    Cells = NDArray[np.int64]


_QUIET: Final = np.errstate(divide="ignore", over="ignore", invalid="ignore")  # of what is checked after it
_NEIGHBOUR: Final = 1.0 + 1e-6  # [1] of a frequency at which no trough is as wide as an amplitude
_RANGE: Final = 64  # [cells] so that an interrupt is noticed within a fraction of a second
_MOST_POINTS: Final = 64  # that are listed
#: What is in doubt about operating points, with places for numbers.
DOUBTS: Final = {
    "near resonance": "the drive is within 2 zeta = {percent} % of resonance: the amplitude depends much on"
    " damping, which is known least",
    "several": "{number} operating points exist: this is the one with the least amplitude, which the machine"
    " reaches when it starts",
    "jumps": "the filling's force jumps at this amplitude: there is no steady operating point",
    "irregular": "the filling's motion is irregular: its force and the amplitude are known within bounds",
    "bent": "the filling adds a second harmonic of {percent} % of the amplitude: speeds of a sinusoidal"
    " motion may be 8 % too high to 24 % too low",
    "strikes": "the relative amplitude exceeds the gap: the machine strikes",
}


@dataclass(frozen=True, eq=False, kw_only=True)
class OperatingPoints:
    """Operating points of a machine with its filling; returned by ``vibro.operate``.

    Arrays have the broadcast shape of the arguments; one case gives NumPy scalars. Where several operating
    points exist, the one with the least amplitude is returned, which the machine reaches when it starts.

    Attributes
    ----------
    scene : Scene
        The scene at the amplitude of the operating point, for ``vibro.solve(points.scene)``.
    amplitude : array
        Amplitude of the trough; NaN where the motion of the filling has no steady state (see ``status``), or
        where the masses strike each other [m].
    amplitude_empty : array
        Amplitude without filling [m].
    amplitude_low, amplitude_high : array
        Bounds on the amplitude, which differ from it only where ``status`` is ``AVERAGED`` [m].
    phase : array
        Phase lead of the trough over the force, in (-pi, pi]; NaN where the share is unknown [rad].
    relative_amplitude : array
        Amplitude of the trough relative to the counter mass or the floor; where ``status`` is ``AVERAGED``, a
        bound above it [m].
    frequency_ratio, filled_frequency_ratio : array
        Drive frequency over the natural frequency of the empty machine, and of that with the filling's added
        mass; NaN where that is unknown [1].
    added_mass_share, added_damping_share : array
        Shares of the filling's mass that act as added mass and as added damping; NaN without a filling, and
        where they are unknown [1].
    second_harmonic : array
        Amplitude of the second harmonic of the trough's motion, which the filling causes, over that of the
        first; NaN where it is unknown [1].
    second_phasor : complex array
        The second harmonic with its phase: if the first harmonic is ``A sin(w t)``, the second one is the
        imaginary part of ``A second_phasor exp(2j w t)`` [1].
    number : array of int
        Number of operating points that were found; 0 where none can be determined.
    at_jump : array of bool
        Whether the shares jump at the amplitude. There is no steady operating point then: just above, the
        filling reduces the amplitude, just below, it lets it grow. The motion returned is that just below.
    strikes : array of bool
        Whether the relative amplitude, or its bound, exceeds the machine's gap, so that the linear model is
        not valid, or the amplitude is infinite.
    status : array of int8
        Code of the ``Status``: OK; BOUNDARY at a jump; AVERAGED where the motion of the filling is irregular
        and its force is known to a bound; or the reason why there is no steady state.
    machine : Machine
        The machine that drives the trough.
    """

    scene: Scene
    amplitude: Floats
    amplitude_empty: Floats
    amplitude_low: Floats
    amplitude_high: Floats
    phase: Floats
    relative_amplitude: Floats
    frequency_ratio: Floats
    filled_frequency_ratio: Floats
    added_mass_share: Floats
    added_damping_share: Floats
    second_harmonic: Floats
    second_phasor: Complexes
    number: NDArray[np.int64]
    at_jump: NDArray[np.bool_]
    strikes: NDArray[np.bool_]
    status: NDArray[np.int8]
    machine: Machine

    @property
    @shielded
    def near_resonance(self) -> NDArray[np.bool_]:
        """Whether the drive is within 2 zeta of resonance, empty or filled: damping matters there."""
        ratios = np.stack(np.broadcast_arrays(self.frequency_ratio, self.filled_frequency_ratio))
        return np.asarray(np.any(np.abs(ratios - 1.0) <= 2.0 * self.machine.damping_ratio, axis=0))[()]

    @property
    @shielded
    def scene_with_second_harmonic(self) -> Scene:
        """The scene with the second harmonic of the trough's motion, where that is known."""
        return with_second_harmonic(self.scene, self.second_phasor)

    @shielded
    def speed_with_second_harmonic(self, *, threads: int | None = None) -> Floats:
        """Return the mean speed with the second harmonic of the trough's motion.

        Parameters
        ----------
        threads : int, optional
            As for ``vibro.solve``.

        Returns
        -------
        array
            Mean speed [m/s]; NaN where the amplitude or the speed is unknown. Where the second harmonic is
            unknown, it is the speed without it.

        Notes
        -----
        The second harmonic follows from the force of the filling on a sinusoidal trough, Eq. (90). On ten
        machines with fillings of 10 to 50 % of the trough's mass, and the worked feeder of docs/theory, it
        reduces the error of the speed from up to 16 % to 4 %
        (tests/machines/test_operating_second_harmonic.py).
        """
        speed = solve(self.scene_with_second_harmonic, threads=threads).mean_velocity
        return np.where(np.isnan(self.amplitude), np.nan, speed)[()]

    @shielded
    def doubts(self) -> list[tuple[NDArray[np.bool_], str]]:
        """Return what is in doubt: the cells that it concerns, and a sentence."""
        zeta = self.machine.damping_ratio
        second = np.nan_to_num(self.second_harmonic)
        near = DOUBTS["near resonance"].format(percent=f"{100.0 * 2.0 * zeta:.3g}")
        several = DOUBTS["several"].format(number=np.max(self.number, initial=0))
        bent = DOUBTS["bent"].format(percent=f"{100.0 * np.max(second, initial=0.0):.2g}")
        return [
            (self.near_resonance & (zeta > 0.0), near),
            (np.asarray(self.number) > 1, several),
            (self.at_jump, DOUBTS["jumps"]),
            (np.asarray(self.status) == int(Status.AVERAGED), DOUBTS["irregular"]),
            (second > WARNED_HARMONIC, bent),
            (self.strikes, DOUBTS["strikes"]),
        ]

    def remarks(self) -> list[str]:
        """Return warnings and remarks on the numbers.

        Returns
        -------
        list of str
            One sentence each; for arrays it begins with the number of cells concerned.
        """
        size = np.size(self.amplitude)
        where = [(int(np.count_nonzero(cells)), text) for cells, text in self.doubts()]
        return [text if size == 1 else f"{count} of {size}: {text}" for count, text in where if count]


def with_second_harmonic(scene: Scene, phasor: Complexes) -> Scene:
    """Add the trough's second harmonic, as of ``OperatingPoints``, to scenes along a line."""
    second = np.nan_to_num(phasor)
    first, angle = scene.amplitude, scene.drive_angle
    assert first is not None
    assert angle is not None
    along, normal = first * np.cos(angle), first * np.sin(angle)
    size, phase = np.abs(second), np.asarray(np.angle(second))
    still = np.zeros(())
    given: dict[str, Any] = {f.name: getattr(scene, f.name) for f in fields(scene)}
    motion = Motion.harmonics(
        along=[(along, still), (along * size, phase)], normal=[(normal, still), (normal * size, phase)]
    )
    other = {"amplitude": None, "drive_angle": None, "motion": motion}
    return Scene.computed(**{**given, **other})


class _Case(NamedTuple):
    """Arguments of a machine, checked and broadcast, and its empty motion: flat arrays over the cells.

    They are contiguous, so that a cell has the same bits in every grid: NumPy's loops differ by strides.
    """

    shape: tuple[int, ...]
    frequency: Floats
    setting: Floats
    voltage: Floats
    natural: Floats
    filling: Floats
    empty: Floats
    linear: Transfer
    body: dict[str, Floats]
    unbounded: NDArray[np.bool_]

    @property
    def compliance(self) -> Complexes:
        """H [1/kg]."""
        return self.linear.compliance


@shielded
@_QUIET
def operate(
    machine: Machine,
    *,
    frequency: ArrayLike,
    drive_angle: ArrayLike,
    static_friction: ArrayLike,
    kinetic_friction: ArrayLike,
    trough_angle: ArrayLike = 0.0,
    gravity: ArrayLike = STANDARD_GRAVITY,
    restitution: ArrayLike = 0.0,
    setting: ArrayLike = 1.0,
    voltage: ArrayLike = 1.0,
    filling: ArrayLike = 0.0,
    natural_frequency: ArrayLike | None = None,
    added_mass_share: ArrayLike | None = None,
    added_damping_share: ArrayLike | None = None,
    allow_strikes: bool = False,
    threads: int | None = None,
) -> OperatingPoints:
    """Return the operating point of a machine with a filling in its trough.

    The amplitude is found at which the force of the filling on the trough and the motion of the machine
    agree. The trough moves sinusoidally along the line of the drive; of the filling's force the first
    harmonic acts. All arrays broadcast against each other.

    Parameters
    ----------
    machine : Machine
        What drives the trough.
    frequency : array_like
        Drive frequency, > 0 [Hz].
    drive_angle, static_friction, kinetic_friction, trough_angle, gravity, restitution : array_like
        As for ``Scene``.
    setting, voltage : array_like, optional
        Setting and voltage over those at 100 %, > 0 [1].
    filling : array_like, optional
        Mass of the filling, >= 0 [kg].
    natural_frequency : array_like, optional
        Natural frequencies of other spring packs; by default that of the machine [Hz].
    added_mass_share, added_damping_share : array_like, optional
        Measured shares of the filling's mass; by default they are computed. If only the mass share is given,
        the damping share is 0; the damping share alone is an error [1].
    allow_strikes : bool, optional
        If True, cells whose relative amplitude exceeds the machine's gap, or is infinite, have no amplitude
        and are marked in ``OperatingPoints.strikes``; by default they are an error.
    threads : int, optional
        As for ``vibro.solve``.

    Returns
    -------
    OperatingPoints
        Arrays of the broadcast shape. The result of a cell does not depend on the other cells.

    Raises
    ------
    InputError
        If an argument of the machine is out of its range, the masses strike each other, or the amplitude is
        infinite.
    SceneError
        If an angle, a friction or a restitution is out of its range. Kinetic above static friction is no
        error but gives the status ``INFEASIBLE``.

    Notes
    -----
    Eqs. (87) to (90). All operating points lie between two proved bounds. Between these amplitudes 3 %
    apart are looked at, and more of them where slides begin: a pair of operating points that differ by less
    than 3 % may be missed. Within 1e-9 of a reference on 6 machines (tests/machines/test_operating.py).
    Because only the first harmonic of the force is fed back, a simulation of trough and body together has
    amplitudes from 1 % less to 5 % more, for fillings of up to half of the trough's mass
    (benchmarks/filling.py).

    Examples
    --------
    >>> import math, vibro
    >>> feeder = vibro.Machine.magnet(trough_mass=6, counter_mass=12, natural_frequency=50 / 1.05,
    ...                               damping_ratio=0.015, calibration=vibro.Calibration(0.35e-3, 50))
    >>> points = vibro.operate(feeder, frequency=50, drive_angle=math.radians(20), static_friction=0.35,
    ...                        kinetic_friction=0.28, filling=[0, 2])
    >>> print(*(f"{1000 * v:.1f} mm/s" for v in vibro.solve(points.scene).mean_velocity))
    24.2 mm/s 16.4 mm/s
    """
    check_switch("allow_strikes", allow_strikes)
    friction = {"static_friction": static_friction, "kinetic_friction": kinetic_friction}
    trough = {"drive_angle": drive_angle, "trough_angle": trough_angle, "gravity": gravity}
    body: dict[str, Any] = {**friction, **trough, "restitution": restitution}
    drive: dict[str, Any] = {"frequency": frequency, "setting": setting, "voltage": voltage}
    own: dict[str, Any] = {"natural_frequency": natural_frequency, "filling": filling}
    case = _case(machine, **drive, **own, **body, allow_unbounded=allow_strikes)
    shares = _shares(added_mass_share, added_damping_share, case.shape)
    found = _Found.empty(case, shares)
    if shares is None:
        full = np.flatnonzero((case.filling > 0.0) & (case.compliance != 0.0))
        _solve(case, full, found, threads)
        _weigh(case, found, threads)
    return _points(machine, case, found, allow_strikes=allow_strikes)


@shielded
@_QUIET
def operating_points(machine: Machine, **case: Any) -> tuple[float, ...]:
    """Return the amplitudes of all operating points of one case.

    Parameters
    ----------
    machine : Machine
        What drives the trough.
    **case
        Arguments of ``operate``, one number each.

    Returns
    -------
    tuple of float
        Ascending amplitudes [m], including those at jumps, and one for each range of irregular motion that
        contains an operating point. It is empty if the filling has no steady motion. The second, fourth, ...
        amplitudes are unstable.

    Raises
    ------
    InputError, SceneError
        As for ``operate``, and if an argument is more than one number.

    Notes
    -----
    As for ``operate``, with up to 2048 amplitudes 0.2 % apart.

    Examples
    --------
    >>> import math, vibro
    >>> feeder = vibro.Machine.magnet(trough_mass=6, counter_mass=12, natural_frequency=50 / 1.05,
    ...                               damping_ratio=0.015, calibration=vibro.Calibration(0.35e-3, 50))
    >>> found = vibro.operating_points(feeder, frequency=50, drive_angle=math.radians(20), filling=2,
    ...                                static_friction=0.35, kinetic_friction=0.28)
    >>> print(*(f"{1000 * amplitude:.4f} mm" for amplitude in found))
    0.2518 mm
    """
    points = operate(machine, **case)
    if shape := np.shape(points.amplitude):
        raise InputError(f"shape = {shape}: must be one case", hint="vibro.operate takes arrays")
    share = case.pop("added_mass_share", None)
    for name in ("added_damping_share", "threads"):
        case.pop(name, None)
    one = _case(machine, allow_unbounded=case.pop("allow_strikes", False), **case)
    if share is not None or one.filling == 0.0 or one.compliance == 0.0 or points.number == 0:
        return (float(points.amplitude),) * int(points.number)
    grid, machines = _grid_of(one, np.zeros(1, np.int64))
    scratch, amplitudes = Scratch(), np.empty(_MOST_POINTS)
    buffers = doors().rows(machines), scratch.flights, scratch.hops, doors().row(amplitudes)
    number = lasting(lambda: doors().operating_points(grid.scenes, grid.place(), *buffers, amplitudes.size))
    return tuple(amplitudes[:number].tolist())


_FRICTIONS: Final = ("drive_angle", "static_friction", "kinetic_friction")
_DEFAULTS: Final = ("trough_angle", "gravity", "restitution")  # which a scene has defaults of


def _case(
    machine: object,
    *,
    frequency: ArrayLike,
    setting: ArrayLike = 1.0,
    voltage: ArrayLike = 1.0,
    natural_frequency: ArrayLike | None = None,
    filling: ArrayLike = 0.0,
    allow_unbounded: bool = False,
    **body: Any,
) -> _Case:
    """Check and broadcast all arguments, and find the empty machine's amplitude."""
    if not isinstance(machine, Machine):
        hint = "make one by vibro.Machine.magnet(...) or another kind"
        raise InputError(f"machine = {shown(machine)}: must be a vibro.Machine", hint=hint)
    f, s, u, f0, _ = machine.broadcast(frequency, setting, voltage, natural_frequency)
    mass = _masses(filling)
    known = Scene.allowing_infeasible(amplitude=1.0, frequency=f, **body)  # refuses angles by their names
    rest = {name: getattr(known, name) for name in (*_FRICTIONS, *_DEFAULTS)}
    shape = broadcast({"frequency": f, "filling": mass, **rest})[0].shape

    def flat(x: Any) -> Any:
        return np.ascontiguousarray(np.broadcast_to(x, shape)).reshape(-1)

    f, s, u, f0, mass = (flat(x) for x in (f, s, u, f0, mass))
    empty, linear = driven(machine, f, s, u, f0)
    size = QUANTITIES["amplitude"]
    good = size.allows(empty)
    unbounded = ~good & ~(empty < 1.0) & allow_unbounded  # and not too small
    if unbounded.any():  # these cells have no answer: a neighbour's numbers stand in for theirs
        f = np.where(unbounded, f * _NEIGHBOUR, f)
        empty, linear = driven(machine, f, s, u, f0)
        good = size.allows(empty)
    if not good.all():
        i = int(np.argmin(good))
        raise InputError(
            f"amplitude = {empty[i]:.6g} m at frequency = {f[i]:.15g} Hz: must be {size.range_text}",
            hint="damping alone bounds the amplitude at resonance: give a damping_ratio > 0",
        )
    body = {name: flat(x) for name, x in rest.items()}
    case = _Case(shape, f, s, u, f0, mass, empty, linear, body, unbounded)
    sizes = case.filling * np.abs(case.compliance), _reach(case)
    if not (good := np.isfinite(sizes[0]) & np.isfinite(sizes[1])).all():
        wrong = float(case.filling[int(np.argmin(good))])
        raise InputError(
            f"filling = {wrong:.15g} kg: its inertia is beyond the range of numbers", fields=["filling"]
        )
    return case


def _numbers(name: str, value: Any) -> Floats:
    """Read an argument by its name; InputError unless it is numbers."""
    try:
        return real_array(value)
    except NotRealError as exc:
        raise InputError(f"{name} = {exc.value}: must be {exc.allowed}", fields=[name]) from None


def _masses(value: Any) -> Floats:
    """Read masses of fillings [kg]."""
    mass, allowed = _numbers("filling", value), QUANTITIES["filling"]
    for wrong in mass[~allowed.allows(mass)][:1]:
        raise InputError(f"filling = {wrong:.15g} kg: must be {allowed.range_text}", fields=["filling"])
    return mass


def _shares(mass: Any, damping: Any, shape: tuple[int, ...]) -> Complexes | None:
    """Return the shares that are given, complex."""
    if mass is None and damping is None:
        return None
    if mass is None:
        raise InputError(
            f"added_damping_share = {shown(damping)}: must be given beside added_mass_share",
            fields=["added_damping_share"],
        )
    given = {"added_mass_share": mass, "added_damping_share": 0.0 if damping is None else damping}
    parts = {name: _numbers(name, value) for name, value in given.items()}
    for name, part in parts.items():
        for wrong in part[~np.isfinite(part)][:1]:
            raise InputError(f"{name} = {wrong}: must be finite", fields=[name])
    share = parts["added_mass_share"] - 1j * parts["added_damping_share"]
    if np.broadcast_shapes(share.shape, shape) != shape:
        raise InputError(f"added_mass_share of shape {share.shape}: must broadcast to {shape}")
    return np.ascontiguousarray(np.broadcast_to(share, shape)).reshape(-1)


class _Found(NamedTuple):
    """Results of all cells, flat, as they are found; of empty machines and known shares from the start."""

    amplitude: Floats
    low: Floats
    high: Floats
    share: Complexes
    second: Complexes
    number: NDArray[np.int64]
    at_jump: NDArray[np.bool_]
    status: NDArray[np.int8]
    solved_at: Floats

    @classmethod
    def empty(cls, case: _Case, shares: Complexes | None) -> _Found:
        size = case.empty.size
        share = np.full(size, complex(np.nan, np.nan)) if shares is None else shares
        known = np.zeros(size) if shares is None else shares
        amplitude = case.empty / np.abs(1.0 + case.filling * known * case.compliance)
        second = np.where(case.filling > 0.0, np.nan, 0.0).astype(np.complex128)
        return cls(
            amplitude=amplitude,
            low=amplitude.copy(),
            high=amplitude.copy(),
            share=share,
            second=second,
            number=np.ones(size, np.int64),
            at_jump=np.zeros(size, np.bool_),
            status=np.zeros(size, np.int8),
            solved_at=amplitude.copy(),
        )


def _grid_of(case: _Case, cells: Cells) -> tuple[Grid, Floats]:
    """Return the scenes of some cells at an amplitude of 1 m, and what the solver takes of their machines."""
    body = {name: x[cells] for name, x in case.body.items()}
    pull = (case.filling * case.compliance)[cells]
    machines = np.stack([case.empty[cells], pull.real, pull.imag])
    scene = Scene.computed(amplitude=np.ones(cells.shape), frequency=case.frequency[cells], **body)
    grid = Grid(scene.arrays())
    grid.hold(machines)
    return grid, machines


def _solve(case: _Case, cells: Cells, found: _Found, threads: int | None) -> None:
    """Find the least operating point of some cells, and count all."""
    grid, machines = _grid_of(case, cells)
    solver, scratch = doors(), Scratch()
    numbers, count = np.empty((4, cells.size)), np.empty(cells.size, np.int64)
    status = np.empty(cells.size, np.int8)
    grid.hold(numbers, count, status)
    rows, out = solver.rows(machines), (*solver.rows(numbers), solver.row(count), solver.row(status))

    def run(begin: int, end: int) -> None:
        solver.operate(grid.scenes, grid.place(), rows, out, scratch.flights, scratch.hops, begin, end)

    over_cells(run, cells.size, _RANGE, threads, cost=2)
    found.amplitude[cells], found.low[cells], found.high[cells], found.solved_at[cells] = numbers
    found.number[cells], found.status[cells] = count, status
    found.at_jump[cells] = status == int(Status.BOUNDARY)


def _weigh(case: _Case, found: _Found, threads: int | None) -> None:
    """Weigh the filling at the amplitudes found; its motion may turn out to be irregular there."""
    full = np.flatnonzero(case.filling > 0.0)
    if not full.size:
        return
    fields = {"frequency": case.frequency, **case.body}
    scene = Scene.computed(amplitude=found.solved_at[full], **{name: x[full] for name, x in fields.items()})
    filling = filling_of(scene, solve(scene, threads=threads), threads=threads)
    stiff = case.compliance[full] == 0.0  # a filling without any effect on the amplitude
    is_known = ~stiff & (found.status[full] != int(Status.OK))
    found.status[full] = np.where(is_known, found.status[full], filling.status)
    unknown, nothing = np.isnan(found.amplitude[full]), complex(np.nan, np.nan)
    found.share[full] = np.where(unknown, nothing, filling.share)
    found.second[full] = np.where(unknown, nothing, filling.second_harmonic)
    late = full[~is_known & ~stiff & (filling.status == int(Status.AVERAGED))]
    reach = _reach(case)[late]
    found.low[late], found.high[late] = np.maximum(case.empty[late] - reach, 0.0), case.empty[late] + reach
    late = full[~is_known & ~stiff & ~is_answered(filling.status)]
    found.amplitude[late] = found.low[late] = found.high[late] = np.nan
    found.number[late] = 0


def _reach(case: _Case) -> Floats:
    """Return an upper bound of m abs(H) A abs(lambda - i delta) for all amplitudes, Eq. (89) [m]."""
    body = case.body
    alpha, beta = body["drive_angle"], body["trough_angle"]
    unit = body["gravity"] / (2.0 * np.pi * case.frequency) ** 2
    pressed = 2.0 * (np.sin(alpha) + body["static_friction"] * np.cos(alpha)) * np.cos(beta)
    return np.asarray(case.filling * np.abs(case.compliance) * pressed * unit)


def _bend(moved: Transfer) -> Floats:
    """Return the relative amplitude over that of the trough."""
    return np.asarray(np.abs(moved.relative / moved.trough))


def _most_relative(machine: Machine, case: _Case, found: _Found) -> Floats:
    """Return an upper bound of the relative amplitude, whatever the share is [m].

    Over the amplitude of the trough it is linear in the added mass, of which Eq. (89) bounds m A abs(z).
    """
    one = transfer(machine, case.frequency, case.natural, 1.0)
    slope = np.abs(one.relative / one.trough - case.linear.relative / case.linear.trough)
    return np.asarray(found.high * _bend(case.linear) + slope * _reach(case) / np.abs(case.compliance))


def _points(machine: Machine, case: _Case, found: _Found, *, allow_strikes: bool) -> OperatingPoints:
    """Assemble the results."""
    f, f0, infinite = case.frequency, case.natural, case.unbounded | np.isinf(found.amplitude)
    # a crank moves its trough as it does, whatever the share is
    unsure = (case.filling > 0.0) & np.isnan(found.share) & (case.compliance != 0.0)
    unsure &= found.status == int(Status.AVERAGED)
    added = np.where(case.filling > 0.0, case.filling * np.nan_to_num(found.share), 0.0)
    moved, twice = transfer(machine, f, f0, added), transfer(machine, 2.0 * f, f0, 0.0)
    harmonic = -0.25 * case.filling * found.second * twice.compliance  # Eq. (90)
    filled = f / machine.filled_natural_frequency(f0, added.real)
    phase, unknown = np.angle(moved.trough + 0.0), unsure | np.isnan(found.amplitude)
    phase, filled = (np.where(unknown, np.nan, x) for x in (phase, filled))
    relative = np.where(unsure, _most_relative(machine, case, found), found.amplitude * _bend(moved))
    relative = np.where(infinite, np.inf, relative)
    ratio = np.where(case.unbounded, f / _NEIGHBOUR, f) / f0
    strikes = (relative > machine.gap) | infinite
    if np.any(strikes) and not allow_strikes:
        i = int(np.argmax(strikes))
        where = f"at frequency = {f[i]:.15g} Hz, setting = {case.setting[i]:.6g}"
        if infinite[i]:
            hint = "the added mass brings the machine into resonance: give a damping_ratio > 0"
            raise InputError(f"amplitude = inf m {where}: must be finite", hint=hint)
        raise InputError(
            f"relative amplitude = {relative[i]:.6g} m {where}: must be <= gap = {machine.gap:.6g} m, or the"
            " masses strike each other",
            hint="lower the setting, or take a spring pack farther from resonance",
            fields=["gap"],
        )
    for x in (found.amplitude, found.low, found.high):
        x[strikes] = np.nan
    found.number[strikes] = 0

    amplitude = np.where(infinite, case.empty, found.solved_at)
    fields = {"amplitude": amplitude, "frequency": f, **case.body}
    solved = Scene.computed(**{name: x.reshape(case.shape)[()] for name, x in fields.items()})
    values = {
        "amplitude": found.amplitude,
        "amplitude_empty": np.where(case.unbounded, np.inf, case.empty),
        "amplitude_low": found.low,
        "amplitude_high": found.high,
        "phase": phase,
        "relative_amplitude": relative,
        "frequency_ratio": ratio,
        "filled_frequency_ratio": filled,
        "added_mass_share": found.share.real,
        "added_damping_share": 0.0 - found.share.imag,
        "second_harmonic": np.abs(harmonic),
        "second_phasor": harmonic,
        "number": found.number,
        "at_jump": found.at_jump,
        "strikes": strikes,
        "status": found.status,
    }
    shaped: dict[str, Any] = {name: x.reshape(case.shape)[()] for name, x in values.items()}
    return OperatingPoints(scene=solved, machine=machine, **shaped)
