"""Operating points of a machine with its filling: the amplitude at which both agree, Eqs. (87) and (90)."""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import TYPE_CHECKING, Any, Final, NamedTuple

import numpy as np

from vibro.core.codes import Status
from vibro.core.numbers import Operated
from vibro.drives import Motion
from vibro.errors import InputError, shown
from vibro.machines.machine import Machine, broadcast, springs_of
from vibro.quantities import QUANTITIES, STANDARD_GRAVITY
from vibro.reals import NotRealError, real_array, shielded
from vibro.results.operating import WARNED_HARMONIC
from vibro.scene import Scene
from vibro.steady import check_switch, solve
from vibro.threads import Grid, Scratch, doors, over_cells

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import ArrayLike, NDArray

    from vibro.reals import Complexes, Floats


_QUIET: Final = np.errstate(divide="ignore", over="ignore", invalid="ignore")  # of what is checked after it
_ROWS: Final = Operated._fields[: Operated._fields.index("number")]  # that are numbers
_RANGE: Final = 32  # [cells] so that threads share the work evenly
_UNSEARCHED: Final = 8192  # [cells] the same without a search
_MOST_POINTS: Final = 64  # that are listed
_MOST_NAMED: Final = 4  # cells of a remark
#: What is in doubt about operating points, with places for numbers.
DOUBTS: Final = {
    "near resonance": "the drive is within 2 zeta = {percent} % of resonance: the amplitude depends much on"
    " damping, which is known least",
    "several": "{number} operating points exist: this is the one with the least amplitude, which the machine"
    " reaches when it starts",
    "jumps": "the filling's force jumps at this amplitude: there is no steady operating point",
    "irregular": "the filling's motion is irregular: its force and the amplitude are known within bounds",
    "bent": "the filling adds a second harmonic of {percent} % of the amplitude: speeds of a sinusoidal"
    " motion may be off by 10 %",
    "uncertain": "the filling bends the trough's motion much, by a second harmonic of {percent} % of the"
    " amplitude: the amplitude is uncertain by 6 %, the speed by a quarter or more; measure the full feeder",
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
    amplitude_sine : array
        Amplitude of the trough if it moved as a sine, without the second harmonic [m].
    second_harmonic : array
        Amplitude of the second harmonic of the trough's motion, which the filling causes, over that of the
        first; NaN where it is unknown [1].
    second_phasor : complex array
        The second harmonic with its phase: if the first harmonic is ``A sin(w t)``, the second one is the
        imaginary part of ``A second_phasor exp(2j w t)`` [1].
    number : array of int
        Number of operating points that were found, under a sine; 0 where none can be determined.
    at_jump : array of bool
        Whether the shares jump at the amplitude. There is no steady operating point then: just above, the
        filling reduces the amplitude, just below, it lets it grow. The motion returned is that just below.
    strikes : array of bool
        Whether the relative amplitude, or its bound, exceeds the machine's gap, so that the linear model is
        not valid, or the amplitude is infinite.
    uncertain : array of bool
        Whether the second harmonic is so large, or changes the speed so much, that amplitude and speed may be
        far off; also where no amplitude was found with which it agrees, and the answer is that of a sine.
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
    amplitude_sine: Floats
    number: NDArray[np.int64]
    at_jump: NDArray[np.bool_]
    strikes: NDArray[np.bool_]
    uncertain: NDArray[np.bool_]
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
        The second harmonic is that at which the trough and the force of the filling agree, Eq. (90). Beside
        a simulation of trough and body together it is nearer than that of the sine
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
        uncertain = np.asarray(self.uncertain)
        bent = (second > WARNED_HARMONIC) & ~uncertain

        def said(name: str, cells: NDArray[np.bool_]) -> tuple[NDArray[np.bool_], str]:
            percent = f"{100.0 * np.max(second, where=cells, initial=0.0):.2g}"
            return cells, DOUBTS[name].format(percent=percent)

        return [
            (self.near_resonance & (zeta > 0.0), near),
            (np.asarray(self.number) > 1, several),
            (self.at_jump, DOUBTS["jumps"]),
            (np.asarray(self.status) == int(Status.AVERAGED), DOUBTS["irregular"]),
            said("bent", bent),
            said("uncertain", uncertain),
            (self.strikes, DOUBTS["strikes"]),
        ]

    def remarks(self, names: Sequence[str] = (), unit: str = "") -> list[str]:
        """Return warnings and remarks on the numbers.

        Parameters
        ----------
        names : sequence of str, optional
            What the cells are called, such as their fillings.
        unit : str, optional
            Printed behind names.

        Returns
        -------
        list of str
            One sentence each; for arrays it begins with the number of cells concerned, of up to four with
            their names.
        """
        found, size = [], np.size(self.amplitude)
        for cells, text in self.doubts():
            where: list[int] = np.flatnonzero(cells).tolist()
            own = ", ".join(names[i] for i in where) if names and len(where) <= _MOST_NAMED else ""
            if where:
                at = f" ({f'{own} {unit}'.rstrip()})" if own else ""
                found.append(text if size == 1 else f"{len(where)} of {size}{at}: {text}")
        return found


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
    """Arguments of a machine, checked and broadcast: flat arrays over the cells.

    Attributes
    ----------
    shape : tuple of int
        That to which they broadcast.
    frequency, setting : array
        Of the drive [Hz], and over that at 100 % [1].
    fillings : array
        Rows of the solver's ``Fillings``.
    body : dict of str to array
        Fields of a scene.
    """

    shape: tuple[int, ...]
    frequency: Floats
    setting: Floats
    fillings: Floats
    body: dict[str, Floats]

    @property
    def is_searched(self) -> bool:
        """Whether any filling has shares that are to be found."""
        _, _, filling, share, _ = self.fillings
        return bool(np.any((filling > 0.0) & np.isnan(share)))

    def grid(self) -> Grid:
        """Return the scenes at an amplitude of 1 m; it keeps the fillings alive too."""
        ones = np.ones(self.frequency.size)
        grid = Grid(Scene.computed(amplitude=ones, frequency=self.frequency, **self.body).arrays())
        grid.hold(self.fillings)
        return grid


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
    agree. The trough moves along the line of the drive, with the second harmonic that the filling puts on
    it. All arrays broadcast against each other.

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
    than 3 % may be missed. From the least one under a sine, which is within 1e-9 of a reference on 6 machines
    (tests/machines/test_operating.py), the second harmonic is fed back until both agree. Higher harmonics and
    the recoil from impacts are left out, which a simulation of trough and body together shows
    (tests/machines/test_operating_second_harmonic.py).

    Examples
    --------
    >>> import math, vibro
    >>> feeder = vibro.Machine.magnet(trough_mass=6, counter_mass=12, natural_frequency=50 / 1.05,
    ...                               damping_ratio=0.015, calibration=vibro.Calibration(0.35e-3, 50))
    >>> points = vibro.operate(feeder, frequency=50, drive_angle=math.radians(20), static_friction=0.35,
    ...                        kinetic_friction=0.28, filling=[0, 2])
    >>> print(*(f"{1000 * v:.1f} mm/s" for v in vibro.solve(points.scene).mean_velocity))
    24.2 mm/s 16.5 mm/s
    """
    check_switch("allow_strikes", allow_strikes)
    friction = {"static_friction": static_friction, "kinetic_friction": kinetic_friction}
    trough = {"drive_angle": drive_angle, "trough_angle": trough_angle, "gravity": gravity}
    body: dict[str, Any] = {**friction, **trough, "restitution": restitution}
    drive: dict[str, Any] = {"frequency": frequency, "setting": setting, "voltage": voltage}
    own: dict[str, Any] = {"natural_frequency": natural_frequency, "filling": filling}
    shares: dict[str, Any] = {
        "added_mass_share": added_mass_share,
        "added_damping_share": added_damping_share,
    }
    case = _case(machine, **drive, **own, **body, **shares)
    grid, solver, scratch, size = case.grid(), doors(), Scratch(), case.frequency.size
    numbers, count, codes = (
        np.empty((len(_ROWS), size)),
        np.empty(size, np.int64),
        np.empty((4, size), np.int8),
    )
    grid.hold(numbers, count, codes)
    given = springs_of(machine), solver.rows(case.fillings)
    out = (*solver.rows(numbers), solver.row(count), *solver.rows(codes))

    def run(begin: int, end: int) -> None:
        solver.operate(grid.scenes, grid.place(), *given, out, scratch.flights, scratch.hops, begin, end)

    over_cells(run, size, _RANGE if case.is_searched else _UNSEARCHED, threads)
    return _points(machine, case, numbers, count, codes, allow_strikes=allow_strikes)


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
    for name in ("allow_strikes", "threads"):
        case.pop(name, None)
    one = _case(machine, **case)
    if not one.is_searched or machine.kind == "crank" or points.number == 0:
        return (float(points.amplitude),) * int(points.number)
    grid, solver, scratch, amplitudes = one.grid(), doors(), Scratch(), np.empty(_MOST_POINTS)
    given = springs_of(machine), solver.rows(one.fillings), scratch.flights, scratch.hops
    buffers = *given, solver.row(amplitudes)
    number = solver.operating_points(grid.scenes, grid.place(), *buffers, amplitudes.size)
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
    added_mass_share: ArrayLike | None = None,
    added_damping_share: ArrayLike | None = None,
    **body: Any,
) -> _Case:
    """Check and broadcast all arguments."""
    if not isinstance(machine, Machine):
        hint = "make one by vibro.Machine.magnet(...) or another kind"
        raise InputError(f"machine = {shown(machine)}: must be a vibro.Machine", hint=hint)
    f, s, u, f0, _ = machine.broadcast(frequency, setting, voltage, natural_frequency)
    mass = _masses(filling)
    known = Scene.allowing_infeasible(amplitude=1.0, frequency=f, **body)  # refuses angles by their names
    rest = {name: getattr(known, name) for name in (*_FRICTIONS, *_DEFAULTS)}
    shape = broadcast({"frequency": f, "filling": mass, **rest})[0].shape
    fillings = machine.force_at(f, s, u), f0, mass, *_shares(added_mass_share, added_damping_share, shape)

    def flat(x: Any) -> Any:
        return np.ascontiguousarray(np.broadcast_to(x, shape)).reshape(-1)

    body = {name: flat(x) for name, x in rest.items()}
    return _Case(shape, flat(f), flat(s), np.stack([flat(x) for x in fillings]), body)


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


def _shares(mass: Any, damping: Any, shape: tuple[int, ...]) -> tuple[Floats, Floats]:
    """Read the shares that are given; NaN where none are."""
    if mass is None and damping is None:
        return np.array(np.nan), np.array(np.nan)
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
    own = np.broadcast_shapes(*(part.shape for part in parts.values()))
    if np.broadcast_shapes(own, shape) != shape:
        raise InputError(f"added_mass_share of shape {own}: must broadcast to {shape}")
    return parts["added_mass_share"], parts["added_damping_share"]


def _points(
    machine: Machine,
    case: _Case,
    numbers: Floats,
    count: NDArray[np.int64],
    codes: NDArray[np.int8],
    *,
    allow_strikes: bool,
) -> OperatingPoints:
    """Check and assemble the results, rows of the solver's ``Operated``."""
    found = dict(zip(_ROWS, numbers, strict=True))
    at_jump, strikes, uncertain, status = codes
    f, relative, empty = case.frequency, found["relative_amplitude"], found["amplitude_empty"]
    size = QUANTITIES["amplitude"]
    for i in np.flatnonzero(~size.allows(empty) & ~(allow_strikes & np.isinf(empty)))[:1]:
        raise InputError(
            f"amplitude = {empty[i]:.6g} m at frequency = {f[i]:.15g} Hz: must be {size.range_text}",
            hint="damping alone bounds the amplitude at resonance: give a damping_ratio > 0",
        )
    if strikes.any() and not allow_strikes:
        i = int(np.argmax(strikes))
        where = f"at frequency = {f[i]:.15g} Hz, setting = {case.setting[i]:.6g}"
        if np.isinf(relative[i]):
            hint = "the added mass brings the machine into resonance: give a damping_ratio > 0"
            raise InputError(f"amplitude = inf m {where}: must be finite", hint=hint)
        raise InputError(
            f"relative amplitude = {relative[i]:.6g} m {where}: must be <= gap = {machine.gap:.6g} m, or the"
            " masses strike each other",
            hint="lower the setting, or take a spring pack farther from resonance",
            fields=["gap"],
        )
    fields = {"amplitude": found.pop("solved_at"), "frequency": f, **case.body}
    solved = Scene.computed(**{name: x.reshape(case.shape)[()] for name, x in fields.items()})
    phasor = found.pop("second_real") + 1j * found.pop("second_imaginary")
    values = {
        **found,
        "frequency_ratio": f / case.fillings[1],
        "second_harmonic": np.abs(phasor),
        "second_phasor": phasor,
        "number": count,
        "at_jump": at_jump.astype(np.bool_),
        "strikes": strikes.astype(np.bool_),
        "uncertain": uncertain.astype(np.bool_),
        "status": status,
    }
    shaped: dict[str, Any] = {name: x.reshape(case.shape)[()] for name, x in values.items()}
    return OperatingPoints(scene=solved, machine=machine, **shaped)
