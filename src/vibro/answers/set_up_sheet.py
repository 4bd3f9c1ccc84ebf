"""The numbers of a set-up sheet: a machine's motion over settings, bands and springs, empty and full."""

from __future__ import annotations

import math
from itertools import product
from typing import TYPE_CHECKING, Any, Final, NamedTuple, TypeAlias

import numpy as np

from vibro.core.codes import Regime, Status
from vibro.designs.guarantees import guarantee
from vibro.errors import InputError, Problems
from vibro.fillings import filling_of
from vibro.limits import critical_loads
from vibro.machines.operating import operating_points
from vibro.quantities import QUANTITIES
from vibro.results.operating import WARNED_HARMONIC
from vibro.scene import Scene
from vibro.steady import solve
from vibro.sweeps.machines import OF_SCENE, case_of, check_operating, operated, points_of
from vibro.units import LENGTH

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence

    from vibro.files.machines import GivenMachine
    from vibro.machines.machine import Machine
    from vibro.machines.operating import OperatingPoints
    from vibro.plots.responses import DrivePicture

#: One operating point and its motion, by the names of columns; NaN where there is none.
Row: TypeAlias = dict[str, Any]

_MAINS: Final = 0.01  # [1] change of the mains' frequency whose effect is on every sheet
_STEP: Final = 1e-3  # [1] relative change from which sensitivities are taken
_FILLINGS: Final = 17  # computed over the band of the filling for the bounds of the amplitude
_GIVEN: Final = 0.01  # [1] change of speed within which "the motion is given" counts as right
# Fillings over the trough's mass among which that change is sought, 12 % apart.
_LIGHT: Final = np.geomspace(1e-4, 1.0, 82)
_CURVE_POINTS: Final = 241
_CURVE_BEYOND: Final = 0.12  # of the frequencies of interest, on either side
_AMPLITUDES: Final = ("amplitude", "amplitude_low", "amplitude_high")
_OF_POINTS: Final = (
    "frequency_ratio", "filled_frequency_ratio", "added_mass_share", "added_damping_share", "at_jump",
    "strikes", "uncertain",
)  # fmt: skip
_SLIDES: Final = (Regime.FORWARD_SLIP.label, Regime.BACK_SLIP.label)


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
    def fillings(self) -> tuple[float, ...]:
        """Fillings of the sheet: none, and the largest [kg]."""
        return (0.0, self.full) if self.full else (0.0,)

    @property
    def fitted(self) -> Machine:
        """The machine with the springs that are fitted."""
        if not self.machine.has_springs:
            return self.machine.machine
        return self.machine.machine.with_natural_frequency(self.values["natural"])

    @property
    def varies(self) -> bool:
        """Whether some band has two ends."""
        return any(low < high for low, high in (*self.bands.values(), *self.machine.shares.values()))

    def band(self, name: str) -> tuple[float, float]:
        """Return the ends of a band; both are the nominal value where it does not vary."""
        return self.bands.get(name, (self.values[name], self.values[name]))


class Sheet(NamedTuple):
    """A set-up sheet.

    Attributes
    ----------
    request : SheetRequest
        The request.
    record : mapping
        Its numbers, as JSON has them.
    doubts : sequence of str
        A sentence each.
    picture : DrivePicture or None
        Amplitude and speed over frequency, if wanted.
    """

    request: SheetRequest
    record: Mapping[str, Any]
    doubts: Sequence[str]
    picture: DrivePicture | None


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
        Called with the number of settings whose speeds are bounded.

    Raises
    ------
    InputError
        If the masses strike each other, or an empty trough has no operating point.
    """
    cases = [{"setting": s, "filling": m} for s in request.settings for m in request.fillings]
    rows, points = _solved(request, cases, bends=True)
    for row in rows:
        if row["strikes"]:
            _refuse_strikes(request, row)
    settings = _paired(request, rows)
    empty, full = settings[-1].values()
    bounds = []
    for done, setting in enumerate(request.settings if request.varies else ()):
        progress(done)
        bounds.append(_bounds(request, setting))
    progress(len(request.settings))
    packs, no_load_proof = _packs(request)
    record = {
        "scene": {QUANTITIES[name].column: value for name, value in request.values.items()},
        "machine": dict(request.machine.table),
        "bands": {QUANTITIES[name].column: list(band) for name, band in request.bands.items()},
        "settings": settings,
        "bounds": bounds,
        "changes": _changes(request),
        "sensitivities": _sensitivities(request),
        "packs": packs,
        "no_load_proof_pack": no_load_proof or None,
        "resonant_filling_kg": _resonant(request, empty, full),
        "tolerated_filling_kg": _tolerated(request, empty),
    }
    return Sheet(request, record, _doubts(rows, points), _picture(request) if picture else None)


def _solved(
    request: SheetRequest, changes: Sequence[Mapping[str, float]], *, bends: bool = False
) -> tuple[list[Row], OperatingPoints]:
    """Solve cases that differ from the nominal one, if wanted with the trough's second harmonics too."""
    given, nominal = request.machine, {**request.values, "filling": 0.0}
    cases = [{**nominal, **change} for change in changes]
    values = {name: np.array([case[name] for case in cases]) for name in nominal}
    points = points_of(given, values)
    cycle = solve(points.scene)
    bent = np.full(len(cases), math.nan)
    if bends and (which := np.nan_to_num(points.second_harmonic) > WARNED_HARMONIC).any():
        moved = points_of(given, {name: x[which] for name, x in values.items()})
        bent[which] = LENGTH.from_si(moved.speed_with_second_harmonic())

    def known(x: Any, nothing: Any = math.nan) -> Any:
        return np.where(np.isnan(points.amplitude) | points.strikes, nothing, x)

    of_point = np.array([status not in (Status.OK, Status.BOUNDARY) for status in points.status])
    statuses = np.where(of_point, points.status, cycle.status)
    columns = {
        **{QUANTITIES[name].column: values[name] for name in ("setting", "voltage", "filling", "frequency")},
        "natural_hz": values.get("natural", np.full(len(cases), given.machine.natural_frequency)),
        **{f"{name}_mm": known(LENGTH.from_si(getattr(points, name))) for name in _AMPLITUDES},
        "relative_amplitude_mm": LENGTH.from_si(points.relative_amplitude),
        "mean_velocity_mm_s": known(LENGTH.from_si(cycle.mean_velocity)),
        "mean_velocity_error_mm_s": known(LENGTH.from_si(cycle.mean_velocity_error)),
        "mean_velocity_with_second_harmonic_mm_s": bent,
        "throw_number": known(cycle.throw_number),
        **{name: getattr(points, name) for name in _OF_POINTS},
        "second_harmonic_percent": 100.0 * points.second_harmonic,
        "operating_points": points.number,
        "regime": known([Regime(code).label for code in cycle.regime], ""),
        "status": np.array([Status(code).label for code in statuses]),
    }
    rows = [
        dict(zip(columns, cells, strict=True))
        for cells in zip(*(np.asarray(x).tolist() for x in columns.values()), strict=True)
    ]
    for row, case in zip(rows, cases, strict=True):
        row["all_amplitudes_mm"] = _all_amplitudes(given, case) if row["operating_points"] > 1 else None
    return rows, points


def _paired(request: SheetRequest, rows: Sequence[Any], nothing: Any = None) -> list[dict[str, Any]]:
    """Return what was found for cases, empty and full."""
    n = len(request.fillings)
    return [{"empty": rows[i], "full": rows[i + 1] if n > 1 else nothing} for i in range(0, len(rows), n)]


def _pairs(request: SheetRequest, changes: Sequence[Mapping[str, float]]) -> list[dict[str, Any]]:
    """Solve cases that differ from the nominal one, empty and full."""
    cases = [{**change, "filling": filling} for change in changes for filling in request.fillings]
    return _paired(request, _solved(request, cases)[0])


def _changes(request: SheetRequest) -> list[dict[str, Any]]:
    """Solve the last setting at the ends of the voltage, and with another frequency of the mains."""
    frequency = request.values["frequency"]
    ends = [("voltage", end) for end in request.bands.get("voltage", ())]
    ends += [("frequency", frequency * (1.0 + change)) for change in (-_MAINS, _MAINS)]
    pairs = _pairs(request, [{"setting": request.settings[-1], name: value} for name, value in ends])
    return [
        {"changed": QUANTITIES[name].column, "value": value, **pair}
        for (name, value), pair in zip(ends, pairs, strict=True)
    ]


def _refuse_strikes(request: SheetRequest, row: Row) -> None:
    """Refuse a setting at which the masses strike each other."""
    values = {**request.values, "setting": row["setting_percent"], "filling": row["filling_kg"]}
    cell = {name: np.array([value]) for name, value in values.items()}
    problems = Problems(f"setting {row['setting_percent']:g} % {_state(row['filling_kg'])}: ")
    with problems.taken():
        check_operating(request.machine, {**cell, **operated(request.machine, cell)})
    problems.settle()


def _all_amplitudes(given: GivenMachine, case: Mapping[str, float]) -> list[float]:
    """Return the amplitudes of all operating points of a case [mm]."""
    arguments = {name: x if x is None else float(x) for name, x in case_of(given, case).items()}
    return [float(LENGTH.from_si(x)) for x in operating_points(given.machine, **arguments)]


def _sensitivities(request: SheetRequest) -> dict[str, dict[str, float]]:
    """Return percent of speed for 1 % more of each input, empty and full; NaN where bodies do not slide."""
    given = request.machine
    names = [name for name in ("setting", "voltage") if given.takes(name)] + ["frequency"]
    names += ["filling"] * bool(request.full) + ["natural"] * given.has_springs
    either = 1.0 - _STEP, 1.0 + _STEP
    cases = []
    for name, filling in product(names, request.fillings):
        case = {**request.values, "setting": request.settings[-1], "filling": filling}
        # of stiffness, which goes with the square of the natural frequency
        steps = (math.sqrt(either[0]), math.sqrt(either[1])) if name == "natural" else either
        cases += [{**case, name: case[name] * step} for step in steps]
    rows, _ = _solved(request, cases)
    rates = [_rate(low, high) for low, high in zip(rows[::2], rows[1::2], strict=True)]
    pairs = _paired(request, rates, math.nan)
    return {{"natural": "stiffness"}.get(name, name): pair for name, pair in zip(names, pairs, strict=True)}


def _rate(low: Row, high: Row) -> float:
    """Return percent of speed for 1 % of what was changed; NaN where bodies do not slide the same way."""
    slides = all(row["regime"] in _SLIDES and not row["at_jump"] for row in (low, high))
    settled = all(row["status"] in (Status.OK.label, Status.BOUNDARY.label) for row in (low, high))
    slow, fast = (row["mean_velocity_mm_s"] for row in (low, high))
    if not (slides and settled and slow * fast > 0.0):
        return math.nan
    return math.log(fast / slow) / math.log((1.0 + _STEP) / (1.0 - _STEP))


def _packs(request: SheetRequest) -> tuple[list[dict[str, Any]], str]:
    """Solve the last setting with each pack of springs, and say why none is load-proof."""
    given = request.machine
    if not given.has_springs:
        return [], "the machine has no springs that could be exchanged"
    own = request.values["natural"]
    name = next((name for name, natural in given.packs.items() if natural == own), "")
    packs, why = [(f"fitted: {name}" if name else "as fitted", own, 1.0)], ""
    packs += [(other, natural, 1.0) for other, natural in given.packs.items() if natural != own]
    try:
        natural = request.fitted.load_proof_frequency(request.values["frequency"])
        force = request.fitted.load_proof_force(request.values["frequency"])
    except InputError as exc:
        why = exc.problems[0].partition(": ")[2] + (f" ({exc.hint})" if exc.hint else "")
    else:
        if force < math.inf:
            packs.append(("load-proof", natural, force))
        else:
            why = "today's amplitude is infinite: the drive is at resonance, without damping"
    last = request.settings[-1]
    pairs = _pairs(request, [{"setting": force * last, "natural": f0} for _, f0, force in packs])
    return [
        {"name": name, "natural_hz": f0, "force_ratio": force, **pair}
        for (name, f0, force), pair in zip(packs, pairs, strict=True)
    ], why


def _resonant(request: SheetRequest, empty: Row, full: Row | None) -> float:
    """Return the filling that brings the machine to resonance; NaN if none does [kg]."""
    share = _share(request, empty) if full is None else full["added_mass_share"]
    added = float(request.fitted.mass_to_resonance(request.values["frequency"]))
    return added / share if 0.0 < added < math.inf and share > 0.0 else math.nan


def _share(request: SheetRequest, empty: Row) -> float:
    """Return the mass share of a filling that is small enough to leave the amplitude as it is."""
    if request.machine.share is not None:
        return request.machine.share[0]
    if not empty["amplitude_mm"] > 0.0:
        return math.nan
    scene = Scene(amplitude=LENGTH.to_si(empty["amplitude_mm"]), **_scene_of(request))
    return float(np.real(filling_of(scene, solve(scene)).share))


def _tolerated(request: SheetRequest, empty: Row) -> float:
    """Return the largest filling before one changes the speed by 1 %; inf if none does [kg]."""
    speed, last = empty["mean_velocity_mm_s"], 0.0
    if not abs(speed) > 0.0:
        return math.nan
    trough_mass = request.fitted.trough_mass
    if math.isinf(trough_mass):
        return math.inf
    fillings = (trough_mass * _LIGHT).tolist()
    light, _ = _solved(request, [{"setting": request.settings[-1], "filling": m} for m in fillings])
    for row in light:
        if not abs(row["mean_velocity_mm_s"] / speed - 1.0) < _GIVEN:
            return last
        last = row["filling_kg"]
    return math.inf


def _bounds(request: SheetRequest, setting: float) -> dict[str, Any]:
    """Bound the speed over the amplitudes of the bands, and the friction."""
    low, high, count = _amplitudes(request, setting)
    found = {
        "setting_percent": setting,
        "amplitude_mm": [float(LENGTH.from_si(x)) for x in (low, high)],
        "operating_points_looked_at": count,
    }
    if math.isnan(low):
        return {**found, "speed_mm_s": None}
    bands = {
        name: request.bands[name] for name in ("static_friction", "kinetic_friction") if name in request.bands
    }
    bands |= {"amplitude": (low, high)} if low < high else {}
    speeds = guarantee(Scene(amplitude=0.5 * (low + high), **_scene_of(request)), **bands)
    return {
        **found,
        "speed_mm_s": [float(LENGTH.from_si(x)) for x in (speeds.speed_min, speeds.speed_max)],
        "proof": [speeds.proof_min, speeds.proof_max],
        "regimes": [regime.label for regime in sorted(speeds.regimes) if regime is not Regime.UNDEFINED],
    }


def _amplitudes(request: SheetRequest, setting: float) -> tuple[float, float, int]:
    """Return the ends of the amplitudes over the bands [m], and of how many operating points they are.

    Ends are NaN if the masses strike each other somewhere, or an operating point is unknown.
    """
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
            return math.nan, math.nan, count
        low = min(low, float(points.amplitude_low.min()))
        high = max(high, float(points.amplitude_high.max()))
        for i in np.flatnonzero(points.number > 1):
            case = {name: float(x[i]) for name, x in values.items()}
            high = max(high, *(LENGTH.to_si(a) for a in _all_amplitudes(request.machine, case)))
        count += len(cases)
    return low, high, count


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


def _doubts(rows: Sequence[Row], points: OperatingPoints) -> list[str]:
    """Say what a reader of the settings must know, and of which."""
    own: list[tuple[Any, str]] = [([row["regime"] == Regime.HOPPING.label for row in rows], "parts hop")]
    for status in Status:
        if not status.answered:
            own.append(([row["status"] == status.label for row in rows], status.message))
    return [f"{_cases(rows, cells)}{text}" for cells, text in [*points.doubts(), *own] if np.any(cells)]


def _cases(rows: Sequence[Row], cells: Any) -> str:
    """Name some of the rows, unless they are all."""
    meant: dict[float, dict[float, bool]] = {}
    for row, cell in zip(rows, cells, strict=True):
        meant.setdefault(row["filling_kg"], {})[row["setting_percent"]] = bool(cell)
    names = []
    for filling, own in meant.items():
        if settings := ", ".join(f"{setting:g}" for setting in own if own[setting]):
            names.append(_state(filling) if all(own.values()) else f"setting {settings} % {_state(filling)}")
    return "" if np.all(cells) else f"{'; '.join(names)}: "


def _state(filling: float) -> str:
    return f"with {filling:g} kg" if filling else "empty"


def _picture(request: SheetRequest) -> DrivePicture:
    """Solve the curves of the picture at the last setting."""
    from vibro.plots.responses import DrivePicture

    drive, last = request.values["frequency"], {"setting": request.settings[-1]}
    ends, _ = _solved(request, [{**last, "filling": filling} for filling in request.fillings])
    ratios = [row["filled_frequency_ratio" if row["filling_kg"] else "frequency_ratio"] for row in ends]
    resonances = [drive / ratio for ratio in ratios if 0.0 < ratio < math.inf]
    interest = [drive, *resonances]
    low, high = min(interest) * (1.0 - _CURVE_BEYOND), max(interest) * (1.0 + _CURVE_BEYOND)
    x = np.union1d(np.linspace(low, high, _CURVE_POINTS), interest)
    scene = Scene(amplitude=1.0, **{**_scene_of(request), "frequency": x})
    loads = critical_loads(scene)
    length = LENGTH.from_si(float(scene.gravity) / (2.0 * math.pi * x) ** 2)

    def curve(**changes: float) -> tuple[Any, Any]:
        rows, _ = _solved(request, [{**last, **changes, "frequency": f} for f in x.tolist()])
        amplitude, speed = np.array([(row["amplitude_mm"], row["mean_velocity_mm_s"]) for row in rows]).T
        return amplitude, speed

    voltages, is_band = request.band("voltage"), "voltage" in request.bands
    bands = [[curve(voltage=v, filling=m)[0] for v in voltages] for m in request.fillings if is_band]
    return DrivePicture(
        frequency=x,
        curves=tuple(curve(filling=filling) for filling in request.fillings),
        voltage=tuple((low, high) for low, high in bands),
        drive=drive,
        points=tuple((row["amplitude_mm"], row["mean_velocity_mm_s"]) for row in ends),
        resonances=tuple(resonances),
        hop=np.asarray(length * loads.hop),
        slip=np.asarray(length * np.minimum(loads.forward_onset, loads.back_onset)),
        full=request.full,
        others=tuple((ends[-1]["all_amplitudes_mm"] or ())[1:]),
    )


def _scene_of(request: SheetRequest) -> dict[str, Any]:
    """Return the fields of the scene except the amplitude, in SI units."""
    case = case_of(request.machine, {**request.values, "filling": 0.0})
    return {name: float(case[name]) for name in OF_SCENE if name in case}
