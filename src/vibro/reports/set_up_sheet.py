"""The set-up sheet of a machine: its motion empty and full, over settings, bands and spring packs."""

from __future__ import annotations

import math
from itertools import product
from typing import TYPE_CHECKING, Any, Final, NamedTuple

import numpy as np

from vibro.core.codes import Regime, Status
from vibro.errors import InputError
from vibro.fillings import filling_of
from vibro.inverse.guarantees import guarantee
from vibro.limits import critical_loads
from vibro.machines.operating import operating_points
from vibro.plots.responses import DrivePicture
from vibro.quantities import LENGTH
from vibro.results.operating import WARNED_HARMONIC
from vibro.scene import Scene
from vibro.steady import solve
from vibro.sweeps.machines import OF_SCENE, case_of, points_of

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence

    from numpy.typing import NDArray

    from vibro.files.machines import GivenMachine
    from vibro.results.designs import Guarantee

    Floats = NDArray[np.float64]

__all__ = ["CHANGES", "Bounds", "Change", "Pack", "Row", "Sheet", "SheetRequest", "make_sheet"]

_MAINS: Final = 0.01  # [1] change of the mains' frequency whose effect is on every sheet
_STEP: Final = 1e-3  # [1] relative change from which sensitivities are taken
_FILLINGS: Final = 17  # computed over the band of the filling for the bounds of the amplitude
_ROOM: Final = 0.98  # [1] of the largest setting at which masses do not strike, as a filling may push it
_GIVEN: Final = 0.01  # [1] change of speed within which "the motion is given" counts as right
# Fillings over the trough's mass among which that change is sought, 12 % apart.
_LIGHT: Final = np.geomspace(1e-4, 1.0, 82)
_CURVE_POINTS: Final = 241
_CURVE_BEYOND: Final = 0.12  # of the frequencies of interest, on either side
#: What is changed for the sensitivities, and what it is called; springs by their stiffness.
CHANGES: Final = {
    "setting": "setting",
    "voltage": "voltage",
    "frequency": "mains frequency",
    "filling": "filling",
    "natural": "stiffness of the springs",
}


class SheetRequest(NamedTuple):
    """What a sheet is made of, in the units outside.

    Attributes
    ----------
    machine : GivenMachine
        The machine.
    values : mapping of str to float
        Nominal values of the scene and the machine by quantity, the empty trough's.
    settings : sequence of float
        Settings of the sheet [%]; results for one setting are those of the last.
    bands : mapping of str to pair of float
        Ends of ``voltage``, ``filling``, ``static_friction`` and ``kinetic_friction``, where they vary.
    """

    machine: GivenMachine
    values: Mapping[str, float]
    settings: Sequence[float]
    bands: Mapping[str, tuple[float, float]]

    @property
    def full(self) -> float:
        """Largest filling [kg]."""
        return max(self.band("filling"))

    @property
    def varies(self) -> bool:
        """Whether some band has two ends."""
        return any(low < high for low, high in self.bands.values()) or any(
            low < high for low, high in self.machine.shares.values()
        )

    def band(self, name: str) -> tuple[float, float]:
        """Return the ends of a band; both are the nominal value where it does not vary."""
        return self.bands.get(name, (self.values[name], self.values[name]))


class Row(NamedTuple):
    """One operating point and its motion; NaN without one.

    Attributes
    ----------
    setting, voltage, filling, frequency, natural : float
        Of the case, in the units outside.
    amplitude, amplitude_low, amplitude_high, relative_amplitude : float
        [mm]; the amplitude lies between both for certain.
    speed, speed_error : float
        Mean speed with its standard error, of a trough that moves as a sine [mm/s].
    regime : Regime
        What happens to the filling, or to a single part in the empty trough.
    status : Status
        Of the operating point, and if that is settled, of the motion.
    throw_number, frequency_ratio, filled_frequency_ratio : float
        [1].
    added_mass_share, added_damping_share, second_harmonic : float
        Of the filling, and the trough's second harmonic over its amplitude [1].
    number : int
        Operating points that exist.
    at_jump, near_resonance, strikes : bool
        Whether no steady operating point exists; whether the drive is within 2 zeta of resonance; whether
        the masses strike each other, so that there is no amplitude.
    amplitudes : tuple of float
        All of them where several exist [mm].
    bent_speed : float
        Mean speed with the trough's second harmonic, where that is above 0.1 % of the amplitude and the case
        is one of the settings; else NaN [mm/s].
    """

    setting: float
    voltage: float
    filling: float
    frequency: float
    natural: float
    amplitude: float
    amplitude_low: float
    amplitude_high: float
    relative_amplitude: float
    speed: float
    speed_error: float
    regime: Regime
    status: Status
    throw_number: float
    frequency_ratio: float
    filled_frequency_ratio: float
    added_mass_share: float
    added_damping_share: float
    second_harmonic: float
    number: int
    at_jump: bool
    near_resonance: bool
    strikes: bool
    amplitudes: tuple[float, ...] = ()
    bent_speed: float = math.nan

    @property
    def hops(self) -> bool:
        """Whether bodies hop."""
        return self.regime is Regime.HOPPING


class Change(NamedTuple):
    """The operating points where one thing is at an end of its band: what is changed, empty and full."""

    name: str
    value: float
    empty: Row
    full: Row


class Pack(NamedTuple):
    """What a spring pack would do: its name, its natural frequency [Hz], the force it takes, empty, full."""

    name: str
    natural: float
    force: float
    empty: Row
    full: Row


class Bounds(NamedTuple):
    """Guaranteed speeds at one setting.

    Attributes
    ----------
    setting : float
        [%].
    low, high : float
        Amplitudes between which all computed operating points lie [mm]; NaN if one is unknown.
    looked_at : int
        How many these are.
    guarantee : Guarantee or None
        Over that interval and the friction; None where an operating point is missing.
    """

    setting: float
    low: float
    high: float
    looked_at: int
    guarantee: Guarantee | None


class Sheet(NamedTuple):
    """A set-up sheet.

    Attributes
    ----------
    request : SheetRequest
        The request.
    settings : tuple of pair of Row
        Empty and full, at each setting.
    bounds : tuple of Bounds
        Guaranteed speeds at each setting; empty without bands.
    changes : tuple of Change
        The ends of the bands of voltage, and of mains' frequency.
    part_filled : Row or None
        At the least filling of its band, where that is not 0.
    sensitivities : mapping of str to pair of float
        Percent of speed that 1 % more brings, empty and full, by the names of ``CHANGES``; NaN where bodies
        hop, rest or have no settled motion.
    packs : tuple of Pack
        The springs as fitted, other packs, and last the load-proof one, if there is one.
    no_load_proof : str
        Why there is no load-proof pack; else empty.
    resonant_filling : float
        Filling with which the natural frequency comes to the drive, at the share that was found [kg]; NaN if
        none does.
    more_mass : float
        Percent of amplitude that 1 % more of the trough's mass brings, empty [1].
    tolerated : float
        Filling up to which its force changes the speed by less than 1 % [kg]; inf if one as heavy as the
        trough does not, NaN if nothing moves in the empty trough, or its speed is unknown.
    picture : DrivePicture or None
        Amplitude and speed over frequency, if wanted.
    warnings : tuple of str
        What a reader must know, a sentence each.
    """

    request: SheetRequest
    settings: tuple[tuple[Row, Row], ...]
    bounds: tuple[Bounds, ...]
    changes: tuple[Change, ...]
    part_filled: Row | None
    sensitivities: Mapping[str, tuple[float, float]]
    packs: tuple[Pack, ...]
    no_load_proof: str
    resonant_filling: float
    more_mass: float
    tolerated: float
    picture: DrivePicture | None
    warnings: tuple[str, ...]


def make_sheet(
    request: SheetRequest, *, picture: bool, progress: Callable[[int], None] = lambda done: None
) -> Sheet:
    """Compute a sheet.

    Parameters
    ----------
    request : SheetRequest
        The request.
    picture : bool
        Whether the curves of the picture are wanted; they take most of the time.
    progress : callable, optional
        Called with the number of settings whose speeds are guaranteed.

    Returns
    -------
    Sheet
        Everything.

    Raises
    ------
    InputError
        If the masses strike each other, or an empty trough has no operating point.
    """
    book = _Book(request)
    full, last = request.full, request.settings[-1]
    settings = [(book.add(setting=s), book.add(setting=s, filling=full)) for s in request.settings]
    nominal = {"setting": last}
    ends: list[tuple[str, float]] = []
    if "voltage" in request.bands:
        ends += [("voltage", end) for end in request.band("voltage")]
    frequency = request.values["frequency"]
    ends += [("frequency", frequency * (1.0 + way * _MAINS)) for way in (-1.0, 1.0)]
    changes = [
        (
            name,
            value,
            book.add(**{**nominal, name: value}),
            book.add(**{**nominal, "filling": full, name: value}),
        )
        for name, value in ends
    ]
    least = min(request.band("filling"))
    part = book.add(**nominal, filling=least) if 0.0 < least < full else None
    steps = _steps(request, full)
    moved = {}
    for name, growth in steps.items():
        states = [{**request.values, **nominal, "filling": filling} for filling in (0.0, full)]
        moved[name] = [[book.add(**{**at, name: at[name] * grown}) for grown in growth] for at in states]
    packs, no_load_proof = _packs(request)
    fitted = [
        [book.add(setting=force * last, filling=filling, natural=natural) for filling in (0.0, full)]
        for _, natural, force in packs
    ]
    machine = _fitted(request)
    mass = machine.trough_mass
    light = [book.add(setting=last, filling=mass * share) for share in _LIGHT if mass < math.inf]
    rows = book.solved()
    book.bend(rows, [full for _, full in settings])
    pairs = tuple((rows[i], rows[j]) for i, j in settings)
    _refuse_strikes(request.machine, pairs)
    sensitivities = {
        name: (_elasticity(rows, empty), _elasticity(rows, filled) if full else math.nan)
        for name, (empty, filled) in moved.items()
    }
    bounds = []
    for done, setting in enumerate(request.settings):
        progress(done)
        if request.varies:
            bounds.append(_bounds(request, setting))
    progress(len(request.settings))
    response = machine.response(frequency)
    share = _share(request, pairs[-1][0])
    return Sheet(
        request=request,
        settings=pairs,
        bounds=tuple(bounds),
        changes=tuple(Change(name, value, rows[i], rows[j]) for name, value, i, j in changes),
        part_filled=None if part is None else rows[part],
        sensitivities=sensitivities,
        packs=tuple(Pack(*pack, rows[i], rows[j]) for pack, (i, j) in zip(packs, fitted, strict=True)),
        no_load_proof=no_load_proof,
        resonant_filling=_resonant_filling(
            machine, frequency, share if not full else _share_of(pairs[-1][1])
        ),
        more_mass=float(response.elasticities["trough_mass"]),
        tolerated=_tolerated(pairs[-1][0], [rows[i] for i in light]),
        picture=_picture(request) if picture else None,
        warnings=tuple(_warnings(request, pairs, bounds)),
    )


class _Book:
    """Cases that are solved together."""

    def __init__(self, request: SheetRequest) -> None:
        self._request = request
        self._cases: list[dict[str, float]] = []

    def add(self, **changes: float) -> int:
        """Add a case that differs from the nominal one, and return its place."""
        self._cases.append({**self._request.values, "filling": 0.0, **changes})
        return len(self._cases) - 1

    def _values(self, cases: Sequence[Mapping[str, float]]) -> dict[str, Floats]:
        return {name: np.array([case[name] for case in cases]) for name in cases[0]}

    def bend(self, rows: list[Row], places: Sequence[int]) -> None:
        """Add speeds with the trough's second harmonic to rows in which it matters."""
        bent = [i for i in places if rows[i].second_harmonic > WARNED_HARMONIC]
        if not bent:
            return
        points = points_of(self._request.machine, self._values([self._cases[i] for i in bent]))
        speeds = LENGTH.from_si(points.speed_with_second_harmonic())
        for i, speed in zip(bent, speeds.tolist(), strict=True):
            rows[i] = rows[i]._replace(bent_speed=speed)

    def solved(self) -> list[Row]:
        """Return the rows of all cases."""
        values = self._values(self._cases)
        given = self._request.machine
        points = points_of(given, values)
        cycle = solve(points.scene)
        near = np.broadcast_to(points.near_resonance, points.amplitude.shape)
        rows = []
        for i, case in enumerate(self._cases):
            known = not (math.isnan(points.amplitude[i]) or points.strikes[i])
            status = Status(int(points.status[i]))
            if status in (Status.OK, Status.BOUNDARY):
                status = Status(int(cycle.status[i]))
            number = int(points.number[i])
            rows.append(
                Row(
                    setting=case["setting"],
                    voltage=case["voltage"],
                    filling=case["filling"],
                    frequency=case["frequency"],
                    natural=case.get("natural", given.machine.natural_frequency),
                    **{
                        name: float(LENGTH.from_si(getattr(points, name)[i])) if known else math.nan
                        for name in ("amplitude", "amplitude_low", "amplitude_high")
                    },
                    relative_amplitude=float(LENGTH.from_si(points.relative_amplitude[i])),
                    speed=float(LENGTH.from_si(cycle.mean_velocity[i])) if known else math.nan,
                    speed_error=float(LENGTH.from_si(cycle.mean_velocity_error[i])) if known else math.nan,
                    regime=Regime(int(cycle.regime[i])) if known else Regime.UNDEFINED,
                    status=status,
                    throw_number=float(cycle.throw_number[i]) if known else math.nan,
                    frequency_ratio=float(points.frequency_ratio[i]),
                    filled_frequency_ratio=float(points.filled_frequency_ratio[i]),
                    added_mass_share=float(points.added_mass_share[i]),
                    added_damping_share=float(points.added_damping_share[i]),
                    second_harmonic=float(points.second_harmonic[i]),
                    number=number,
                    at_jump=bool(points.at_jump[i]),
                    near_resonance=bool(near[i]),
                    strikes=bool(points.strikes[i]),
                    amplitudes=_all_amplitudes(given, case) if number > 1 else (),
                )
            )
        return rows


def _refuse_strikes(given: GivenMachine, pairs: Sequence[tuple[Row, Row]]) -> None:
    """Refuse settings at which the masses strike each other: name the first."""
    for row in (row for pair in pairs for row in pair):
        if not row.strikes:
            continue
        across, gap = row.relative_amplitude, LENGTH.from_si(given.machine.gap)
        if math.isinf(across):
            raise InputError(
                f"{_case(row)}: the amplitude is infinite: the drive is at resonance, without damping",
                hint="give a damping_ratio > 0",
            )
        raise InputError(
            f"{_case(row)}: the masses strike: the relative amplitude would be {across:.4g} mm, and"
            f" gap_mm allows {gap:.4g} mm",
            hint=f"lower it, such as setting={_ROOM * row.setting * gap / across:.3g}, or take a spring pack"
            " farther from resonance",
        )


def _all_amplitudes(given: GivenMachine, case: Mapping[str, float]) -> tuple[float, ...]:
    """Return the amplitudes of all operating points of a case [mm]."""
    arguments = {name: x if x is None else float(x) for name, x in case_of(given, case).items()}
    found = operating_points(given.machine, **arguments)
    return tuple(float(LENGTH.from_si(x)) for x in found)


def _fitted(request: SheetRequest) -> Any:
    """Return the machine with the springs that are fitted."""
    machine = request.machine.machine
    natural = request.values.get("natural")
    if natural is None or not request.machine.has_springs:
        return machine
    return machine.with_natural_frequency(natural)


def _steps(request: SheetRequest, full: float) -> dict[str, tuple[float, float]]:
    """Return the factors of the quantities that are changed for sensitivities."""
    given = request.machine
    either = 1.0 - _STEP, 1.0 + _STEP
    steps = {name: either for name in ("setting", "voltage") if given.takes(name) or name == "setting"}
    steps["frequency"] = either
    if full:
        steps["filling"] = either
    if given.has_springs:  # whose stiffness goes with the square of the natural frequency
        steps["natural"] = math.sqrt(either[0]), math.sqrt(either[1])
    return steps


def _elasticity(rows: Sequence[Row], pair: Sequence[int]) -> float:
    """Return percent of speed for 1 % of what was changed; NaN where bodies do not slide the same way."""
    low, high = (rows[i] for i in pair)
    slides = all(row.regime in (Regime.FORWARD_SLIP, Regime.BACK_SLIP) for row in (low, high))
    settled = all(row.status in (Status.OK, Status.BOUNDARY) and not row.at_jump for row in (low, high))
    if not (slides and settled and low.speed * high.speed > 0.0):
        return math.nan
    return math.log(high.speed / low.speed) / math.log((1.0 + _STEP) / (1.0 - _STEP))


def _packs(request: SheetRequest) -> tuple[list[tuple[str, float, float]], str]:
    """Return name, natural frequency [Hz] and force over today's of each pack, and why none is load-proof."""
    given = request.machine
    if not given.has_springs:
        return [], "the machine has no springs that could be exchanged"
    own = request.values["natural"]
    name = next((name for name, natural in given.packs.items() if natural == own), "")
    packs = [(f"fitted: {name}" if name else "as fitted", own, 1.0)]
    packs += [(other, natural, 1.0) for other, natural in given.packs.items() if natural != own]
    machine = _fitted(request)
    try:
        natural = machine.load_proof_frequency(request.values["frequency"])
        force = machine.load_proof_force(request.values["frequency"])
    except InputError as exc:
        return packs, exc.problems[0].partition(": ")[2] + (f" ({exc.hint})" if exc.hint else "")
    if not force < math.inf:
        return packs, "today's amplitude is infinite: the drive is at resonance, without damping"
    return [*packs, ("load-proof", natural, force)], ""


def _share_of(row: Row) -> complex:
    return complex(row.added_mass_share, -row.added_damping_share)


def _share(request: SheetRequest, empty: Row) -> complex:
    """Return the complex share of a filling that is small enough to leave the amplitude as it is."""
    if request.machine.share is not None:
        mass, damping = request.machine.share
        return complex(mass, -damping)
    if not empty.amplitude > 0.0:
        return complex(math.nan)
    scene = Scene(amplitude=LENGTH.to_si(empty.amplitude), **_scene_of(request))
    return complex(filling_of(scene, solve(scene)).share)


def _resonant_filling(machine: Any, frequency: float, share: complex) -> float:
    """Return the filling whose share of mass lowers the natural frequency to the drive's [kg]."""
    mass = float(machine.mass_to_resonance(frequency))
    return mass / share.real if 0.0 < mass < math.inf and share.real > 0.0 else math.nan


def _tolerated(empty: Row, light: Sequence[Row]) -> float:
    """Return the last of ascending fillings before one changes the speed by 1 %; inf if none does [kg]."""
    if not abs(empty.speed) > 0.0:
        return math.nan
    last = 0.0
    for row in light:
        if not abs(row.speed / empty.speed - 1.0) < _GIVEN:
            return last
        last = row.filling
    return math.inf


def _bounds(request: SheetRequest, setting: float) -> Bounds:
    """Find the amplitudes over the bands, and guarantee the speed over them and the friction."""
    axes = {
        "voltage": sorted(set(request.band("voltage"))),
        "filling": sorted({*np.linspace(*request.band("filling"), _FILLINGS)}),
        "static_friction": sorted({*request.band("static_friction"), request.values["static_friction"]}),
        "kinetic_friction": sorted({*request.band("kinetic_friction"), request.values["kinetic_friction"]}),
    }
    cases = [dict(zip(axes, case, strict=True)) for case in product(*axes.values())]
    cases = [case for one in cases for case in _cut(one, request)]
    values: dict[str, Any] = {name: np.full(len(cases), value) for name, value in request.values.items()}
    values |= {name: np.array([case[name] for case in cases]) for name in axes}
    values["setting"] = np.full(len(cases), setting)
    shares: list[tuple[Any, ...]] = [request.machine.share or (None, None)]
    if request.machine.shares:
        ends = [request.machine.shares.get(f"added_{of}_share", (0.0, 0.0)) for of in ("mass", "damping")]
        shares = [*product(*ends)]
    low, high, count = math.inf, -math.inf, 0
    for share in dict.fromkeys(shares):
        points = points_of(request.machine, values, share=share)
        if np.isnan(points.amplitude).any() or points.strikes.any():
            return Bounds(setting, math.nan, math.nan, count, None)
        low = min(low, float(points.amplitude_low.min()))
        high = max(high, float(points.amplitude_high.max()))
        for i in np.flatnonzero(points.number > 1):
            case = {name: float(x[i]) for name, x in values.items()}
            high = max(high, *(LENGTH.to_si(a) for a in _all_amplitudes(request.machine, case)))
        count += len(cases)
    bands: dict[str, tuple[float, float]] = {
        name: request.band(name) for name in ("static_friction", "kinetic_friction") if name in request.bands
    }
    bands |= {"amplitude": (low, high)} if low < high else {}
    found = guarantee(Scene(amplitude=0.5 * (low + high), **_scene_of(request)), **bands)
    return Bounds(setting, float(LENGTH.from_si(low)), float(LENGTH.from_si(high)), count, found)


def _cut(case: dict[str, float], request: SheetRequest) -> list[dict[str, float]]:
    """Move a corner with mu_d > mu_s to where the bands are cut: along either axis, if they reach there."""
    static, kinetic = case["static_friction"], case["kinetic_friction"]
    if kinetic <= static:
        return [case]
    moved = []
    if kinetic <= max(request.band("static_friction")):
        moved.append({**case, "static_friction": kinetic})
    if static >= min(request.band("kinetic_friction")):
        moved.append({**case, "kinetic_friction": static})
    return moved


def _warnings(request: SheetRequest, pairs: Sequence[tuple[Row, Row]], bounds: Sequence[Bounds]) -> list[str]:
    """Say what a reader of the sheet must know."""
    zeta = request.machine.machine.damping_ratio
    full = request.full
    rows = [row for pair in pairs for row in (pair if full else pair[:1])]
    said = []
    if near := [row for row in rows if row.near_resonance]:
        said.append(
            f"{_cases(near, rows)}: within 2 zeta = {200.0 * zeta:.3g} % of resonance, where damping decides"
            " much of the amplitude; it is what is known least"
        )
    for row in rows:
        if row.number > 1:
            told = ", ".join(f"{a:.4g}" for a in row.amplitudes)
            said.append(
                f"{_case(row)}: {row.number} operating points, with amplitudes of {told} mm; the sheet shows"
                " the least, which the machine reaches when it starts"
            )
    if jumps := [row for row in rows if row.at_jump]:
        said.append(
            f"{_cases(jumps, rows)}: the filling's motion changes at this amplitude, and its force jumps:"
            " there is no steady operating point"
        )
    if averaged := [row for row in rows if row.filling and row.status is Status.AVERAGED]:
        said.append(
            f"{_cases(averaged, rows)}: the filling's motion is irregular; its force and the amplitude are"
            " known within the bounds shown; the speed is that at the middle"
        )
    second = max((row.second_harmonic for row in rows if row.filling), default=math.nan)
    if second > WARNED_HARMONIC:
        said.append(
            f"the filling adds a second harmonic of up to {100.0 * second:.2g} % of the amplitude to the"
            " trough's motion; the speed with it is listed for each setting, all other speeds are those of a"
            " sinusoidal motion"
        )
    for row in rows:
        if math.isnan(row.amplitude) and not row.strikes:
            said.append(f"{_case(row)}: no operating point: {row.status.message}")
    for one in bounds:
        if one.guarantee is None:
            said.append(
                f"setting {one.setting:g} %: no speed is guaranteed, as within the bands some operating point"
                " is unknown, or the masses strike"
            )
    return said


def _case(row: Row) -> str:
    return f"setting {row.setting:g} %, {f'{row.filling:g} kg' if row.filling else 'empty'}"


def _cases(some: Sequence[Row], rows: Sequence[Row]) -> str:
    return "at all settings" if len(some) == len(rows) else "; ".join(map(_case, some))


def _picture(request: SheetRequest) -> DrivePicture:
    """Solve the curves of the picture at the last setting."""
    given, drive = request.machine, request.values["frequency"]
    states = (0.0, request.full) if request.full else (0.0,)
    ends = [_one(request, drive, filling) for filling in states]
    resonances = [
        drive / ratio
        for ratio in (ends[0].frequency_ratio, *(end.filled_frequency_ratio for end in ends[1:]))
        if 0.0 < ratio < math.inf
    ]
    interest = [drive, *resonances]
    low, high = min(interest) * (1.0 - _CURVE_BEYOND), max(interest) * (1.0 + _CURVE_BEYOND)
    x = np.union1d(np.linspace(low, high, _CURVE_POINTS), interest)
    scene = Scene(amplitude=1.0, **{**_scene_of(request), "frequency": x})
    loads = critical_loads(scene)
    length = LENGTH.from_si(float(scene.gravity) / (2.0 * math.pi * x) ** 2)
    curves, bands = [], []
    for filling in states:
        values = {**request.values, "setting": request.settings[-1], "filling": filling}
        at = {name: np.full(x.size, value) for name, value in values.items()} | {"frequency": x}
        points = points_of(given, at)
        amplitude = np.where(points.strikes, np.nan, points.amplitude)
        speed = np.where(np.isnan(amplitude), np.nan, solve(points.scene).mean_velocity)
        curves.append((np.asarray(LENGTH.from_si(amplitude)), np.asarray(LENGTH.from_si(speed))))
        if "voltage" in request.bands:
            sides = [
                points_of(given, {**at, "voltage": np.full(x.size, end)}).amplitude
                for end in request.band("voltage")
            ]
            bands.append((np.asarray(LENGTH.from_si(sides[0])), np.asarray(LENGTH.from_si(sides[1]))))
    return DrivePicture(
        frequency=x,
        curves=tuple(curves),
        voltage=tuple(bands),
        drive=drive,
        points=tuple((end.amplitude, end.speed) for end in ends),
        resonances=tuple(resonances),
        hop=np.asarray(length * loads.hop),
        slip=np.asarray(length * np.minimum(loads.forward_onset, loads.back_onset)),
        full=request.full,
        others=ends[-1].amplitudes[1:],
    )


def _one(request: SheetRequest, frequency: float, filling: float) -> Row:
    book = _Book(request)
    book.add(setting=request.settings[-1], filling=filling, frequency=frequency)
    return book.solved()[0]


def _scene_of(request: SheetRequest) -> dict[str, Any]:
    """Return the fields of the scene except the amplitude, in SI units."""
    case = case_of(request.machine, {**request.values, "filling": 0.0})
    return {name: float(case[name]) for name in OF_SCENE if name in case}
