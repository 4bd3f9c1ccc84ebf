"""Friction and restitution from times or speeds of parts over settings, with every value that fits."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import product
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, NamedTuple

import numpy as np
from scipy.optimize import least_squares
from scipy.special import chdtrc, chdtri, fdtri, ndtri, stdtrit

from vibro.axes import AxisSpec, one_value_of
from vibro.errors import InputError, cut, shown
from vibro.files.points import ACCELERATION, MeasuredSpeeds, read_speeds
from vibro.inverse_friction import USUAL_RATIO, friction_for_speed
from vibro.quantities import QUANTITIES, STANDS_FOR, scene_fields
from vibro.reals import shielded
from vibro.records.fitting import merged
from vibro.records.reading import TOL, rounded
from vibro.scene import Scene
from vibro.steady import solve
from vibro.sweeps.machines import operated
from vibro.sweeps.request import gather
from vibro.sweeps.whole import Inputs, inputs_of_call

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from vibro.reals import Bools, Floats
    from vibro.sweeps.request import Request

#: What can be fitted to times or speeds.
FITTED: Final = ("kinetic_friction", "static_friction", "restitution")
_FRICTIONS: Final = ("static_friction", "kinetic_friction")
_RATIO: Final = "friction_ratio"
#: Values that are tried: friction from a polished bearing to rubber, restitution up to hard balls.
TRIED: Final[Mapping[str, tuple[float, float]]] = {
    "kinetic_friction": (0.02, 2.0),
    "static_friction": (0.02, 2.0),
    _RATIO: (0.4, 1.0),
    "restitution": (0.0, 0.6),
}
# Cells of the first grid along each coordinate, by the number of coordinates.
_CELLS: Final = {
    "kinetic_friction": (128, 40, 32),
    "static_friction": (128, 40, 32),
    _RATIO: (32, 8, 5),
    "restitution": (64, 20, 12),
}
_ASSUMED: Final = 0.02  # relative error of a time, or a speed, where nothing tells it: 0.1 s of 5 s
_LEAST: Final = 1e-3  # least relative error: amplitude and frequency are not known better
_LEFT_OUT: Final = 3.0  # errors beyond all that is computed at which a row is left out
_BY_CHANCE: Final = 0.01  # probability by which noise makes a row, or a table, seem wrong
_NO_SPEED: Final = 1e-3  # [m/s] where no part moves: a speed that nobody overlooks
_FAR: Final = 50.0  # [1] logarithm of the ratio of two speeds of opposite sign: beyond all others
_BEYOND: Final = 0.5  # of the range of a residual over the corners of a cell: how far it may exceed them
_FINE: Final = 0.3  # of the threshold's root: range of the residuals over a cell that needs no splitting
# Of the values that are tried: cells as small are not split, as a speed may jump there, and hops depend on
# restitution without end.
_SMALL: Final = {"kinetic_friction": 2e-5, "static_friction": 2e-5, _RATIO: 1e-3, "restitution": 1 / 200}
_MOST_COST: Final = 300_000  # scenes in contact, of which about 100 000 are solved in a second,
_IRREGULAR: Final = 120  # and how many of them an irregular one is worth
_MOST_SPLITS: Final = 60
_AT_ONCE: Final = 20_000  # scenes in memory
_STARTS: Final = 4  # of least squares
_CLOSER: Final = 5  # refinements of an extreme speed, each by a factor of 4
_DRAWS: Final = 3, 24  # rounds of points that are drawn around a start, and of these
_STEP: Final = 1e-4  # of the values that are tried, for derivatives
_ROUNDS: Final = 3  # of the search, where one finds a better fit than it began with,
_BETTER: Final = 0.02  # of the threshold, by which it must be better
_USUAL_STEPS: Final = 15  # of the search, for its progress
_WORTH: Final = 3.0  # [standard errors] least difference of speeds that a further point would tell apart
_SIZES: Final = ("amplitude", "stroke", ACCELERATION.name, "setting", "along_amplitude", "normal_amplitude")
_SETTINGS: Final = 11  # of an axis, among which the next one is sought,
_SAMPLES: Final = 24  # and values that fit, whose speeds there are compared
_HALF: Final = 0.5  # of an amplitude, to both sides, where no range is known


@dataclass(frozen=True)
class SpeedParameter:
    """What times or speeds tell of one quantity.

    Attributes
    ----------
    name : str
        Its field of ``Scene``.
    intervals : tuple of pair of float
        Every value that fits, at 95 %: ascending and disjoint; several where the speed is not monotonic.
    values : tuple of tuple of float
        Within each of them the best fit; of a single row all kinetic frictions that give its time exactly.
    value : float
        The best of all; NaN where no row could be fitted.
    open_low, open_high : bool
        Whether the first interval begins, and the last ends, where the values that are tried do: there the
        rows set no bound.
    """

    name: str
    value: float
    values: tuple[tuple[float, ...], ...]
    intervals: tuple[tuple[float, float], ...]
    open_low: bool
    open_high: bool


@dataclass(frozen=True)
class NextPoint:
    """The setting at which values that fit differ most.

    Attributes
    ----------
    setting : mapping of str to float
        Quantities in the units outside, by their names.
    low, high : float
        Least and largest speed there of values that fit [m/s].
    errors : float
        Difference of both, in standard errors of a measured time or speed.
    """

    setting: Mapping[str, float]
    low: float
    high: float
    errors: float


@dataclass(frozen=True, eq=False)
class SpeedFit:
    """Friction and restitution that are fitted to times or speeds.

    Attributes
    ----------
    parameters : tuple of SpeedParameter
        What was fitted; empty if nothing was.
    table : MeasuredSpeeds
        The rows.
    length : array of shape (n,)
        Of the trough, for each row; NaN where it is not known [m].
    measured, computed : array of shape (n,)
        Speeds of the rows: measured, 0 of a part that did not arrive, and of the best fit [m/s].
    errors : array of shape (n,)
        Measured minus computed time or speed, in standard errors; NaN where one of them is unknown.
    error : float
        Relative standard error of a time or speed: the median of what is stated, or what the scatter gives.
    error_is : str
        ``"stated"``, ``"widened"`` (stated, but the rows scatter more), ``"scatter"`` or ``"assumed"``.
    left_out : tuple of int
        Rows that no value that is tried comes near to, which the fit leaves out; places among the rows.
    doubtful : tuple of int
        Rows that do not agree with the others.
    reach : array of shape (n, 2)
        Least and largest speed of each row for the values that are tried [m/s].
    next_point : NextPoint or None
        Where to measure next.
    statements : tuple of str
        What is assumed, what the rows cannot tell, which rows are wrong, one sentence each.
    scene : Scene
        The rows' scenes at the best fit, shape (n,).
    """

    parameters: tuple[SpeedParameter, ...]
    table: MeasuredSpeeds
    length: Floats
    measured: Floats
    computed: Floats
    errors: Floats
    error: float
    error_is: str
    left_out: tuple[int, ...]
    doubtful: tuple[int, ...]
    reach: Floats
    next_point: NextPoint | None
    statements: tuple[str, ...]
    scene: Scene


@shielded
def fit_speeds(
    table: str | PathLike[str] | Mapping[str, Any],
    scene_file: str | PathLike[str] | None = None,
    *,
    fit: Sequence[str] = (),
    progress: Callable[[int, int, str], None] | None = None,
    **quantities: Any,
) -> SpeedFit:
    """Find friction and restitution from times or speeds of parts, like ``vibro measure``.

    Parameters
    ----------
    table : path or mapping of str to sequence
        A CSV, or its columns by their headers, of one row or more: what was set, such as ``amplitude_mm``,
        ``stroke_mm``, ``acceleration_g``, ``frequency_hz``, ``drive_angle_deg`` or ``setting_percent``, and
        ``traverse_time_s``, over the trough's length, or ``mean_velocity_mm_s``; if known a standard error,
        ``time_error_s``, ``speed_error_mm_s`` or ``error_percent``. A time may be ``never``.
    scene_file : path, optional
        A scene file: what no column gives. Within its table ``[map]`` the next point is sought.
    fit : sequence of str, optional
        What is fitted, among ``"kinetic_friction"``, ``"static_friction"`` and ``"restitution"``. By default
        what is not given: static friction only where there are more settings than numbers to be found, else
        it follows by a ratio of 0.8, and restitution only where a part hops.
    progress : callable, optional
        Called with the number of steps that are done, of those that are known, and what is done.
    **quantities
        As for ``vibro.sweep``, one value each.

    Returns
    -------
    SpeedFit
        With intervals that hold every value that fits, at 95 %.

    Raises
    ------
    InputError
        If a column, a cell or a quantity is wrong or missing.
    FileError
        If a file cannot be read.

    Notes
    -----
    Least squares over the logarithms of the exact mean speeds [m/s], each row weighted by its error; without
    a column of errors all rows have the same relative error, which their scatter gives. The intervals are
    those of the profile likelihood [1]_, and the whole range is searched: cells of it are split until none is
    left that may hold a value that fits. Of 320 tables that another solver simulated, 94 to 97 % of the
    intervals hold the true value (``benchmarks/times.py``).

    References
    ----------
    .. [1] S. A. Murphy and A. W. van der Vaart, "On profile likelihood", Journal of the American Statistical
       Association 95 (2000), 449-465.

    Examples
    --------
    >>> import vibro
    >>> times = {"amplitude_mm": [1.0, 1.4, 1.8, 2.4], "traverse_time_s": [36.1, 17.0, 10.4, 7.0]}
    >>> found = vibro.fit_speeds(times, frequency_hz=15, drive_angle_deg=20, trough_length_mm=600,
    ...                          friction_ratio=0.77)
    >>> [(p.name, round(p.value, 2)) for p in found.parameters]
    [('kinetic_friction', 0.56)]
    """
    is_path = isinstance(table, str | PathLike)
    inputs = inputs_of_call(scene_file, quantities, fit_speeds, repr(str(table)) if is_path else "table")
    if not is_path and not hasattr(table, "keys"):
        hint = 'write it like "times.csv", or {"amplitude_mm": [1, 2], "traverse_time_s": [36, 9]}'
        raise InputError(f"table = {shown(table)}: must be a path or columns by their headers", hint=hint)
    rows = read_speeds(Path(table) if isinstance(table, str | PathLike) else table)
    names = (fit,) if isinstance(fit, str) else tuple(fit)
    return fit_question(speed_question(rows, inputs, names), progress)


# ------------------------------------------------------------------------------
# What is given, and what is to be found.


class SpeedQuestion(NamedTuple):
    """Rows, the rest of their scene, and what is fitted.

    Attributes
    ----------
    table : MeasuredSpeeds
        The rows.
    request : Request
        The rest of the scene.
    names : tuple of str
        What is fitted, among ``FITTED``.
    frictions : mapping of str to float
        Both coefficients of friction, and their ratio, as far as they are given.
    is_chosen : bool
        Whether the caller chose the names.
    ranges : mapping of str to pair of float
        Within which the next point is sought, in the units outside, as far as the scene file gives them.
    """

    table: MeasuredSpeeds
    request: Request
    names: tuple[str, ...]
    frictions: Mapping[str, float]
    is_chosen: bool
    ranges: Mapping[str, tuple[float, float]]


def speed_question(table: MeasuredSpeeds, inputs: Inputs, names: Sequence[str] = ()) -> SpeedQuestion:
    """Merge rows, a scene file and the caller's input, and decide what is fitted.

    Parameters
    ----------
    table : MeasuredSpeeds
        The rows, whose columns replace what the file gives.
    inputs : Inputs
        Scene file and caller's input.
    names : sequence of str
        What is to be fitted, among ``FITTED``; else all of these that neither file nor caller give.

    Raises
    ------
    InputError
        It names everything that is wrong or missing.
    """
    given, file, caller, pack = inputs
    wrong = [name for name in names if name not in FITTED]
    if wrong or len(set(names)) < len(names):
        named = shown(wrong[0]) if wrong else "a name that is given twice"
        hint = f"choose from {', '.join(QUANTITIES[name].letter for name in FITTED)}"
        raise InputError(
            f"fit {cut(','.join(names))}: {named} cannot be fitted to times or speeds", hint=hint
        )
    columns = {"amplitude" if name == ACCELERATION.name else name for name in table.settings}
    slots = {STANDS_FOR.get(name, name) for name in columns}
    if twice := [name for name in given if STANDS_FOR.get(name, name) in slots]:
        labels = (QUANTITIES[name].label for name in twice)
        raise InputError(
            *(f"{x} is given, and a column of {table.where}" for x in labels), hint="leave one out"
        )
    own = dict(file.scene) if file else {}
    if not {_FRICTIONS[1], _RATIO}.isdisjoint(given):  # one stands for the other
        own = {name: value for name, value in own.items() if name not in (_FRICTIONS[1], _RATIO)}
    frictions = {
        n: _friction(value, n) for n, value in {**own, **given}.items() if n in (*_FRICTIONS, _RATIO)
    }
    if {*_FRICTIONS} <= frictions.keys() - {*names}:
        static, kinetic = (frictions[name] for name in _FRICTIONS)
        if kinetic > static:
            wrong_pair = f"kinetic friction = {kinetic:.15g}: must be at most static friction = {static:.15g}"
            raise InputError(wrong_pair, hint="friction at rest is the larger one: exchange them")
    fitted = tuple(names)
    if not fitted:
        unknown = [] if len(frictions) > 1 else [name for name in _FRICTIONS[::-1] if name not in frictions]
        unknown = unknown[:1] if _RATIO in frictions else unknown
        fitted = (*unknown, *(["restitution"] if "restitution" not in {*own, *given} else []))
    typed = {name: x for name, x in given.items() if name not in frictions}
    typed |= {n: repr(float(table.settings[n][0])) if n in table.settings else "1" for n in columns}
    is_lengthless = table.is_time and "trough_length" not in columns
    request = gather(typed, file, caller, asked_for=_FRICTIONS, needs_length=is_lengthless, pack=pack)
    if request.machine is not None and request.fixed.get("filling", 0.0):
        raise InputError(
            "times on a full trough: its amplitude depends on the friction that is to be found",
            hint="measure the amplitude, and give it in place of [machine]; or leave the filling out",
        )
    ranges = {
        name: (float(spec.values[0]), float(spec.values[-1]))
        for name, spec in (file.sweep if file else {}).items()
        if spec.varies and name in (*_SIZES, "frequency")
    }
    return SpeedQuestion(table, request, fitted, frictions, bool(names), ranges)


def _friction(value: Any, name: str) -> float:
    """Read a coefficient of friction, or the ratio of both."""
    quantity = QUANTITIES[name]
    number = float((value if isinstance(value, AxisSpec) else one_value_of(value, quantity)).value)
    if not quantity.allows(number) or not number > 0.0:
        wrong = f"{quantity.label} = {number:.15g}: must be above 0"
        raise InputError(wrong + " and at most 1" * (name == _RATIO))
    return number


# ------------------------------------------------------------------------------
# The computed speeds of rows.


class _Axis(NamedTuple):
    """A coordinate: its name and the values that are tried, on a scale of logarithms or not."""

    name: str
    low: float
    high: float
    is_log: bool

    def at(self, share: Floats) -> Floats:
        """Return values by their places between both ends."""
        if self.is_log:
            return np.asarray(self.low * (self.high / self.low) ** share)
        return self.low + (self.high - self.low) * share


class _Speeds:
    """Speeds of the distinct settings of rows, as functions of what is fitted."""

    def __init__(self, question: SpeedQuestion) -> None:
        table, request = question.table, question.request
        own = {name: x for name, x in table.settings.items() if name != "trough_length"}
        rows = np.stack([np.zeros(table.measured.size), *own.values()], axis=1)
        distinct, self.which = np.unique(rows, axis=0, return_inverse=True)
        self.count = len(distinct)
        self.fixed = {name: np.float64(x) for name, x in request.fixed.items() if name != "restitution"}
        self.request, self.frictions = request, question.frictions
        self.bounce = float(request.fixed["restitution"])
        self.columns = dict(zip(own, distinct.T[1:], strict=True))
        self.fields = self.settings(self.columns)
        self.cost = self.price = 0.0
        self.axes: list[_Axis] = []

    def settings(self, columns: Mapping[str, Floats]) -> dict[str, Any]:
        """Return the quantities of settings besides friction and restitution, in the units outside.

        Raises
        ------
        InputError
            If a machine has no operating point there.
        """
        values: dict[str, Any] = {**self.fixed, **columns}
        if "stroke" in values:
            values["amplitude"] = values.pop("stroke") / 2.0
        if ACCELERATION.name in values:
            load = values.pop(ACCELERATION.name) * values.get("gravity", QUANTITIES["gravity"].default)
            values["amplitude"] = 1e3 * load / (math.tau * values["frequency"]) ** 2
        machine = self.request.machine
        if machine is not None:
            size = np.broadcast_shapes(*(np.shape(x) for x in values.values()))
            full = {name: np.broadcast_to(x, size or (1,)) for name, x in values.items()}
            ones = np.ones(size or (1,))
            found = operated(machine, full | {"static_friction": ones, "kinetic_friction": ones})["amplitude"]
            if np.isnan(found).any():
                raise InputError("the machine has no operating point at a setting of the rows")
            values["amplitude"] = found if size else found[0]
        if self.request.motion is not None:
            values["motion"] = self.request.motion.motion
        return values

    def choose(self, names: Sequence[str]) -> None:
        """Choose what is fitted; the other coefficient of friction is given, or follows by the ratio."""
        known = {n: x for n, x in self.frictions.items() if n not in names}
        axes = [name for name in FITTED if name in names]
        if {*_FRICTIONS} <= {*names}:
            axes[1], known = _RATIO, {}
        tried = dict(TRIED)
        if "static_friction" in known:
            most = known["static_friction"]
            tried["kinetic_friction"] = (min(TRIED["kinetic_friction"][0], 0.1 * most), most)
        elif "kinetic_friction" in known:
            least = known["kinetic_friction"]
            tried["static_friction"] = (least, max(TRIED["static_friction"][1], 10.0 * least))
        if len(known) > 1 and {*_FRICTIONS} & {*names}:
            known.pop(_RATIO, None)
        self.known = known
        self.axes = [_Axis(name, *tried[name], is_log=name in _FRICTIONS) for name in axes]
        self.cells = np.array([_CELLS[name][len(axes) - 1] for name in axes], np.int64)

    def values(self, points: Floats) -> dict[str, Floats]:
        """Return both frictions and the restitution at points of the unit cube, shape (M, d)."""
        one = np.ones(len(points))
        found = {name: x * one for name, x in self.known.items()}
        found |= {axis.name: axis.at(points[:, i]) for i, axis in enumerate(self.axes)}
        ratio = found.get(_RATIO, USUAL_RATIO * one)
        static, kinetic = (found.get(name) for name in _FRICTIONS)
        if kinetic is None:
            assert static is not None
            kinetic = ratio * static
        static = kinetic / ratio if static is None else static
        bounce = found.get("restitution", self.bounce * one)
        return {
            "kinetic_friction": kinetic,
            "static_friction": np.maximum(static, kinetic),
            "restitution": bounce,
        }

    def scene(self, points: Floats, fields: Mapping[str, Any]) -> Scene:
        """Return the scenes of points at settings, shape (M, K)."""
        found = {name: x[:, None] for name, x in self.values(points).items()}
        return Scene(**scene_fields({**fields, **found}))

    def of_rows(self, point: Floats) -> Scene:
        """Return the scenes of all rows at a point, shape (N,)."""
        fields = self.settings({name: x[self.which] for name, x in self.columns.items()})
        found = {name: np.full(self.which.size, x[0]) for name, x in self.values(point[None]).items()}
        return Scene(**scene_fields({**fields, **found}))

    def __call__(self, points: Floats, fields: Mapping[str, Any] | None = None) -> tuple[Floats, Floats]:
        """Return the speeds and their standard errors, each of shape (M, K); NaN where there is no answer."""
        fields = self.fields if fields is None else fields
        width = max((np.size(x) for x in fields.values()), default=1)
        size = max(1, _AT_ONCE // width)
        parts = []
        for start in range(0, len(points), size):
            cycle = solve(self.scene(points[start : start + size], fields))
            parts.append((cycle.mean_velocity, cycle.mean_velocity_error))
        speeds, errors = (np.concatenate(part) for part in zip(*parts, strict=True))
        self.price = width * (1.0 + _IRREGULAR * float(np.mean(errors > 0.0)))
        self.cost += len(points) * self.price
        return speeds, np.where(np.isnan(speeds), np.nan, errors)

    def exact(self, residuals: _Residuals) -> list[float]:
        """Return the kinetic frictions that give a single row's speed exactly, if they alone are sought."""
        rows = np.flatnonzero(residuals.kept)
        if [axis.name for axis in self.axes] != ["kinetic_friction"] or len(rows) > 1:
            return []
        speed = float(residuals.speed[rows[0]])
        if not speed > 0.0:
            return []
        at = self.settings({name: x[self.which[rows[0]]] for name, x in self.columns.items()})
        frictions = {name: float(x[0]) for name, x in self.values(np.zeros((1, 1))).items()}
        ratio = None if "static_friction" in self.known else self.known.get(_RATIO, USUAL_RATIO)
        found = friction_for_speed(Scene(**scene_fields({**at, **frictions})), speed, ratio=ratio)
        return [x for one in found.solutions for x in dict.fromkeys((one.low, one.high))]

    def throws(self) -> Bools:
        """Return which settings make parts hop, which depends on neither friction nor restitution."""
        scene = Scene(
            **scene_fields(
                {**self.fields, "static_friction": 1.0, "kinetic_friction": 1.0, "restitution": 0.0}
            )
        )
        throw = solve(scene, output="regimes").throw_number
        return np.broadcast_to(throw > 1.0, (self.count,))


# ------------------------------------------------------------------------------
# Residuals.


class _Residuals:
    """Residuals of rows: logarithms of computed over measured speed, in the errors that are stated.

    The logarithm treats times and speeds alike. A part that did not arrive has a speed of at most 0: its
    residual is the computed speed over the usual one.
    """

    def __init__(self, table: MeasuredSpeeds, length: Floats, which: NDArray[np.intp]) -> None:
        self.which, self.is_never = which, np.isinf(table.measured)
        speed = length / table.measured if table.is_time else table.measured
        self.speed, self.moves = speed, speed != 0.0
        self.usual = float(np.median(abs(speed[self.moves]))) if self.moves.any() else _NO_SPEED
        self.size = np.where(self.moves, abs(speed), self.usual)
        digits = table.resolution[self.moves] / abs(table.measured[self.moves])
        self.rounding = float(np.sqrt(np.mean(digits**2) / 12.0)) if digits.size else 0.0
        self.is_stated = table.error is not None
        self.error = np.ones(speed.size)
        if table.error is not None:
            self.error = table.error / np.where(
                self.is_never, np.nan, self.size if not table.is_time else table.measured
            )
            usual = np.nanmedian(self.error) if not self.is_never.all() else _ASSUMED
            self.error = np.where(np.isnan(self.error), usual, self.error)
        self.kept = np.ones(speed.size, np.bool_)

    def __call__(self, speeds: Floats, errors: Floats) -> tuple[Floats, Floats]:
        """Return residuals, and the part of their errors that is the model's, of the rows that are kept.

        Parameters
        ----------
        speeds, errors : array, shape (M, K)
            Computed, of the distinct settings.

        Returns
        -------
        pair of array, shape (M, N)
            Large and finite where a part moves the other way, or has no speed.
        """
        kept = np.flatnonzero(self.kept)
        v, e = speeds[:, self.which[kept]], errors[:, self.which[kept]]
        size, moves = self.size[kept], self.moves[kept]
        forth = v * np.where(self.speed[kept] < 0.0, -1.0, 1.0)
        with np.errstate(divide="ignore", invalid="ignore"):
            r = np.where(forth > 0.0, np.log(np.maximum(forth, 0.0) / size), -_FAR)
            still = np.where(self.is_never[kept], np.maximum(v, 0.0), v) / size
            r, d = np.where(moves, r, still), np.where(moves, e / abs(v), e / size)
        r = np.clip(np.nan_to_num(r, nan=_FAR), -_FAR, _FAR)
        return r / self.error[kept], np.nan_to_num(d, posinf=0.0) / self.error[kept]


# ------------------------------------------------------------------------------
# The search: every point that fits, by cells that are split where they may hold one.


class _Region(NamedTuple):
    """What fits.

    Attributes
    ----------
    points : array, shape (M, d)
        Points of the unit cube that fit, and those on edges of cells where the misfit passes the threshold.
    cell : array of int, shape (M,)
        Number of the cell of each.
    is_coarse : bool
        Whether the search ended before the region was resolved: then cells count as a whole.
    """

    points: Floats
    cell: NDArray[np.intp]
    is_coarse: bool

    def intervals(self, values: Floats) -> tuple[tuple[float, float], ...]:
        """Return the intervals in which a quantity lies, given its values at the points."""
        if not values.size:
            return ()
        low, high = np.full(self.cell.max() + 1, np.inf), np.full(self.cell.max() + 1, -np.inf)
        np.minimum.at(low, self.cell, values)
        np.maximum.at(high, self.cell, values)
        return merged([pair for pair in zip(low.tolist(), high.tolist(), strict=True) if pair[0] <= pair[1]])


class _Search:
    """Evaluate residuals at points of the unit cube, and remember all of them."""

    def __init__(self, speeds: _Speeds, residuals: _Residuals) -> None:
        self.speeds, self.residuals, size = speeds, residuals, len(speeds.axes)
        ticks = [np.arange(count + 1) / count for count in speeds.cells.tolist()]
        self.grid = (
            np.stack(np.meshgrid(*ticks, indexing="ij"), axis=-1).reshape(-1, size)
            if size
            else np.zeros((1, 0))
        )
        self.on_grid = speeds(self.grid)
        self.least = np.array([_SMALL[axis.name] for axis in speeds.axes])

    def begin(self) -> None:
        """Remember the first grid alone, with the rows that are kept now."""
        self.points, self.found = self.grid, self.residuals(*self.on_grid)

    def __call__(self, points: Floats) -> tuple[Floats, Floats]:
        """Return residuals and the model's part of their errors at points, and remember them."""
        found = self.residuals(*self.speeds(points))
        self.points = np.concatenate([self.points, points])
        self.found = (np.concatenate([self.found[0], found[0]]), np.concatenate([self.found[1], found[1]]))
        return found

    def best(self, scale: float, within: Bools | None = None, without: int | None = None) -> Floats:
        """Return the best point that is remembered, improved by least squares.

        Parameters
        ----------
        scale : float
            Error of a residual.
        within : bool array, optional
            Which of the points that are remembered count.
        without : int, optional
            A row that does not count.
        """
        r, d = self.found
        weight = np.ones(r.shape[1])
        if without is not None:
            weight[without] = 0.0
        squares = _squares(r * weight, d, scale)
        squares = squares if within is None else np.where(within, squares, np.inf)
        starts = self.points[np.argsort(squares, kind="stable")[: _STARTS if within is None else 1]]
        if "restitution" in [axis.name for axis in self.speeds.axes]:
            starts = np.array([self._nearby(start, weight, scale) for start in starts])

        def residual(point: Floats) -> Floats:
            one, error = self(np.clip(point, 0.0, 1.0)[None])
            off: Floats = (one * weight / np.hypot(scale, error))[0]
            return off

        ends = [self.points[np.argmin(squares)]]
        for start in starts if ends[0].size else starts[:0]:
            bounds = np.zeros(start.size), np.ones(start.size)
            inner = np.clip(start, 1e-9, 1.0 - 1e-9)
            steps = np.full(start.size, _STEP)
            ends.append(least_squares(residual, inner, bounds=bounds, diff_step=steps, max_nfev=30).x)
        values = [float(np.square(residual(end)).sum()) for end in ends]
        return np.asarray(ends[int(np.argmin(values))])

    def _nearby(self, point: Floats, weight: Floats, scale: float) -> Floats:
        """Return the best of points that are drawn closer and closer to a point, as hops have no slopes."""
        random, widths = np.random.default_rng(0), 1.0 / self.speeds.cells
        for _ in range(_DRAWS[0]):
            drawn = point + widths * random.uniform(-1.0, 1.0, (_DRAWS[1], point.size))
            points = np.concatenate([point[None], np.clip(drawn, 0.0, 1.0)])
            r, d = self(points)
            point, widths = points[np.argmin(_squares(r * weight, d, scale))], widths / 3.0
        return point

    def squares(self, point: Floats, scale: float) -> float:
        """Return the misfit at a point."""
        return float(_squares(*self.residuals(*self.speeds(point[None])), scale)[0])

    def region(self, scale: float, most: float, report: Callable[[], None]) -> _Region:
        """Return every point whose misfit is at most ``most``."""
        size = self.points.shape[1]
        counts = self.speeds.cells.copy()
        cells = np.stack(np.meshgrid(*map(np.arange, counts), indexing="ij"), axis=-1).reshape(-1, size)
        corners = np.array([*product((0, 1), repeat=size)], np.int64)
        root = math.sqrt(most)
        is_coarse = False
        done: list[tuple[Floats, Floats]] = []  # nodes and misfits of cells that need no splitting
        for turn in range(_MOST_SPLITS):
            report()
            nodes = cells[:, None] + corners
            unique, back = np.unique(nodes.reshape(-1, size), axis=0, return_inverse=True)
            r, d = self(unique / counts) if turn else self.residuals(*self.on_grid)
            back = back.reshape(nodes.shape[:2])
            misfit, scaled = np.sqrt(_squares(r, d, scale))[back], (r / np.hypot(scale, d))[back]
            low, high = scaled.min(axis=1), scaled.max(axis=1)
            reach = _BEYOND * (high - low)
            least = np.maximum(np.maximum(low - reach, -high - reach), 0.0)
            kept = (np.square(least).sum(axis=1) <= most) | self._homes(cells, counts, scale, most)
            cells, nodes, misfit = cells[kept], nodes[kept], misfit[kept]
            if not len(cells):
                break
            spreads = self._spreads(scaled[kept], size)
            wide = (spreads > _FINE * max(root, 1.0)) & (counts * self.least < 1.0)
            active = wide.any(axis=1) & ~(misfit <= root).all(axis=1)
            total = np.square(spreads[active] * wide[active]).sum(axis=0)
            split = total >= 0.25 * total.max(initial=0.0)
            # A cell that is split has as many new corners as parts.
            cost = float(active.sum() * 2.0 ** split.sum() * self.speeds.price)
            is_coarse = bool(active.any()) and self.speeds.cost + cost > _MOST_COST
            done.append((nodes[~active] / counts, misfit[~active]))
            if is_coarse:
                done.append((nodes[active] / counts, misfit[active]))
            if is_coarse or not active.any():
                break
            counts = np.where(split, 2 * counts, counts)
            cells = np.where(split, 2 * cells[active], cells[active])
            cells = (cells[:, None] + np.unique(corners * split, axis=0)).reshape(-1, size)
        nodes_of, misfits_of = zip(*done, strict=True)
        found = np.concatenate(nodes_of), np.concatenate(misfits_of)
        return self._resolved(*found, scale, root, is_coarse=is_coarse)

    def _homes(self, cells: NDArray[np.int64], counts: NDArray[np.int64], scale: float, most: float) -> Bools:
        """Return which cells hold a point that is known to fit, such as the best one."""
        fitting = self.points[_squares(*self.found, scale) <= most]
        homes = np.minimum((fitting * counts).astype(np.int64), counts - 1)
        cell, home = (np.ravel_multi_index(tuple(x.T), tuple(counts)) for x in (cells, homes))
        return np.isin(cell, home)

    @staticmethod
    def _spreads(scaled: Floats, size: int) -> Floats:
        """Return how far residuals differ along each coordinate of cells, shape (C, d)."""
        cube = scaled.reshape(len(scaled), *(2,) * size, scaled.shape[-1])
        steps = [np.diff(cube, axis=1 + i).reshape(len(scaled), -1, cube.shape[-1]) for i in range(size)]
        return np.asarray(
            np.sqrt(np.stack([np.square(step).sum(axis=2).max(axis=1) for step in steps], axis=1))
        )

    def _resolved(
        self, nodes: Floats, misfit: Floats, scale: float, root: float, *, is_coarse: bool
    ) -> _Region:
        """Find where the misfit passes the threshold on the edges of cells."""
        size = nodes.shape[-1]
        inside = misfit <= root
        holds = inside.any(axis=1) | is_coarse
        nodes, misfit, inside = nodes[holds], misfit[holds], inside[holds]
        parts, owners = [nodes[inside]], [np.nonzero(inside)[0]]
        if is_coarse:
            parts, owners = [nodes.reshape(-1, size)], [np.repeat(np.arange(len(nodes)), nodes.shape[1])]
        pairs = [(i, i | 1 << b) for i in range(1 << size) for b in range(size) if not i >> b & 1]
        for i, j in pairs:
            for a, b in ((i, j), (j, i)):
                cross = inside[:, a] & ~inside[:, b]
                share = (root - misfit[cross, a]) / (misfit[cross, b] - misfit[cross, a])
                parts.append(nodes[cross, a] + share[:, None] * (nodes[cross, b] - nodes[cross, a]))
                owners.append(np.flatnonzero(cross))
        own = self.points[_squares(*self.found, scale) <= root**2]  # each a cell of its own
        parts.append(own)
        owners.append(np.arange(len(own)) + len(nodes))
        points, owner = np.concatenate(parts), np.concatenate(owners)
        return _Region(points, owner, is_coarse)


def _squares(residuals: Floats, errors: Floats, scale: float) -> Floats:
    return np.asarray(np.square(residuals / np.hypot(scale, errors)).sum(axis=-1))


# ------------------------------------------------------------------------------
# The fit.


def fit_question(
    question: SpeedQuestion, progress: Callable[[int, int, str], None] | None = None
) -> SpeedFit:
    """Fit friction and restitution to times or speeds.

    Parameters
    ----------
    question : SpeedQuestion
        Rows, scene and names.
    progress : callable, optional
        Called with the number of steps that are done, of those that are known, and what is done.

    Raises
    ------
    InputError
        If a scene of a row is impossible, or friction that is not fitted is not given.
    """
    table, speeds = question.table, _Speeds(question)
    length = question.request.length
    lengths = table.settings.get("trough_length", np.full(table.measured.size, length or np.nan)) / 1e3
    residuals = _Residuals(table, np.asarray(lengths), speeds.which)
    names = _chosen(question, speeds)
    speeds.choose(names)
    steps = 0

    def report() -> None:
        nonlocal steps
        if progress:
            progress(steps, max(steps, _USUAL_STEPS), "fitting")
        steps += 1

    report()
    search = _Search(speeds, residuals)
    reach = _reach(search)
    left_out = _unreachable(search, reach) if names else np.zeros(table.measured.size, np.bool_)
    residuals.kept = ~left_out
    search.begin()
    moving = residuals.kept & residuals.moves
    free = int(moving.sum()) - min(len(names), np.unique(speeds.which[moving]).size)
    scale, error_is = (1.0, "stated") if residuals.is_stated else (_ASSUMED, "assumed")
    best, region = np.full(len(names), 0.5), None
    for _ in range(_ROUNDS if residuals.kept.any() else 0):
        best = search.best(1.0 if residuals.is_stated else _ASSUMED)
        scale, error_is = _scale(search, best, free)
        if not names:
            break
        root = _threshold(names, free if error_is in ("scatter", "widened") else 0)
        least = search.squares(best, scale)
        region = search.region(scale, least + root**2, report)
        if _squares(*search.found, scale).min() > least - _BETTER * root**2:
            break
    error = float(np.median(residuals.error)) * scale if residuals.is_stated else scale
    parameters, doubtful, ahead = tuple[SpeedParameter, ...](), tuple[int, ...](), None
    if region is not None:
        parameters = tuple(_parameter(name, search, region, best, scale) for name in names)
        doubtful = _doubtful(search, best, scale, free)
        ahead = _next_point(question, speeds, residuals, region, error)
    residuals.kept[:] = True
    speed, its_error = speeds(best[None])
    r, d = residuals(speed, its_error)
    is_known = not left_out.all()
    computed, off = speed[0, speeds.which], (r / np.hypot(scale, d))[0] * (1.0 if table.is_time else -1.0)
    found = SpeedFit(
        parameters, table, np.asarray(lengths), residuals.speed, np.where(is_known, computed, np.nan),
        np.where(is_known, off, np.nan), error, error_is, tuple(np.flatnonzero(left_out).tolist()), doubtful,
        reach[speeds.which], ahead, (), speeds.of_rows(best),
    )  # fmt: skip
    return replace(found, statements=tuple(_statements(found, question, speeds, region)))


def _threshold(names: Sequence[str], free: int) -> float:
    """Return the root of the increase of the misfit at the ends of intervals.

    Hops depend on restitution as irregularly as noise, so that the least misfit is one of many: there the
    threshold is that of all quantities together. ``free`` is 0 where the error is known.
    """
    count = len(names) if "restitution" in names else 1
    if free:
        return math.sqrt(count * fdtri(count, free, TOL.confidence))
    return math.sqrt(chdtri(count, 1.0 - TOL.confidence))


def _chosen(question: SpeedQuestion, speeds: _Speeds) -> tuple[str, ...]:
    """Return what is fitted: of what is not given, what the rows can depend on."""
    names = question.names
    if not question.is_chosen:
        if not speeds.throws().any():
            names = tuple(name for name in names if name != "restitution")
        if {*_FRICTIONS} <= {*names} and speeds.count <= len(names):
            names = tuple(name for name in names if name != "static_friction")
    known = {*question.frictions} | {name for name in names if name in _FRICTIONS}
    if len(known) < 2 and {*_FRICTIONS}.isdisjoint(names):
        lacking = " and ".join(QUANTITIES[name].label for name in _FRICTIONS if name not in known)
        raise InputError(f"missing: {lacking}", hint="give them, or fit mu_d, or mu_s and mu_d")
    return names


def _reach(search: _Search) -> Floats:
    """Return the least and the largest speed of each setting, shape (K, 2); NaN where none is known."""
    found = search.on_grid[0]
    known = ~np.isnan(found)
    low, high = np.where(known, found, np.inf).min(axis=0), np.where(known, found, -np.inf).max(axis=0)
    return np.where(np.isinf(low)[:, None], np.nan, np.stack([low, high], axis=1))


def _unreachable(search: _Search, reach: Floats) -> Bools:
    """Return which rows are beyond all that is computed by more than a few errors; refine their reach."""
    residuals = search.residuals
    relative = residuals.error if residuals.is_stated else np.maximum(_ASSUMED, residuals.rounding)
    slack = residuals.size * np.expm1(_LEFT_OUT * np.minimum(relative, 1.0))
    result = np.full(residuals.which.size, False)
    result[np.isnan(reach[residuals.which, 0])] = True
    for row in np.flatnonzero(~result).tolist():
        k, speed = residuals.which[row], residuals.speed[row]
        for side, sign in ((0, -1.0), (1, 1.0)):
            if side and residuals.is_never[row]:
                continue  # a part may go back as fast as it likes
            if sign * (speed - reach[k, side]) > 0.0:
                reach[k, side] = sign * _extreme(search, k, sign)
                result[row] |= sign * (speed - reach[k, side]) > slack[row]
    return result


def _extreme(search: _Search, k: int, sign: float) -> float:
    """Return the largest of a speed, or of its negative, near the points of the grid where it is largest."""
    values = np.nan_to_num(sign * search.on_grid[0][:, k], nan=-np.inf)
    size = search.grid.shape[1]
    shifts = np.stack(np.meshgrid(*[np.linspace(-1.0, 1.0, 9)] * size, indexing="ij"), axis=-1).reshape(
        -1, size
    )
    best = float(values.max())
    for point in search.grid[np.argsort(-values, kind="stable")[:_STARTS]]:
        widths = 1.0 / search.speeds.cells
        for _ in range(_CLOSER):
            points = np.clip(point + widths * shifts, 0.0, 1.0)
            speeds = np.nan_to_num(sign * search.speeds(points)[0][:, k], nan=-np.inf)
            point, best = points[np.argmax(speeds)], max(best, float(speeds.max()))
            widths = widths / 4.0
    return best


def _scale(search: _Search, best: Floats, free: int) -> tuple[float, str]:
    """Return the error of residuals, and where it is from."""
    residuals = search.residuals
    squares = float(np.square(residuals(*search.speeds(best[None]))[0]).sum())
    if residuals.is_stated:
        if best.size and free > 0 and chdtrc(free, search.squares(best, 1.0)) < _BY_CHANCE:
            return math.sqrt(squares / free), "widened"
        return 1.0, "stated"
    least = max(_LEAST, residuals.rounding)
    if free > 0:
        return max(math.sqrt(squares / free), least), "scatter"
    return max(_ASSUMED, least), "assumed"


def _parameter(name: str, search: _Search, region: _Region, best: Floats, scale: float) -> SpeedParameter:
    """Return what a region tells of a quantity."""
    speeds = search.speeds
    values = speeds.values(region.points)[name]
    pieces, value = region.intervals(values), float(speeds.values(best[None])[name][0])
    bests, exact = list[tuple[float, ...]](), speeds.exact(search.residuals)
    for low, high in pieces:
        if held := tuple(x for x in exact if low <= x <= high):
            bests.append(held)
            continue
        if low <= value <= high:
            bests.append((value,))
            continue
        own = speeds.values(search.points)[name]
        within = (own >= low) & (own <= high)
        at = float(speeds.values(search.best(scale, within)[None])[name][0])
        bests.append((min(max(at, low), high),))
    places = {axis.name: region.points[:, i] for i, axis in enumerate(speeds.axes)}
    ends = [(float(place.min()) <= 0.0, float(place.max()) >= 1.0) for place in places.values()]
    at_ends = dict(zip(places, ends, strict=True))
    if name == "static_friction" and _RATIO in places:
        is_open = at_ends["kinetic_friction"][0], at_ends["kinetic_friction"][1] or at_ends[_RATIO][0]
    else:
        low, high = TRIED[name]
        axis = next(axis for axis in speeds.axes if axis.name == name)
        is_open = (
            at_ends[name][0] and name != "restitution" and axis.low <= low,
            at_ends[name][1] and axis.high >= high,
        )
    return SpeedParameter(name, value, tuple(bests), pieces, *is_open)


def _doubtful(search: _Search, best: Floats, scale: float, free: int) -> tuple[int, ...]:
    """Return the place of the row without which the others agree much better, if there is one."""
    residuals, places = search.residuals, np.flatnonzero(search.residuals.kept)
    is_stated = residuals.is_stated
    r, d = search.found
    if free < 2 or not search.speeds.axes:
        return ()
    one = 1.0 if is_stated else scale
    terms = np.square(r / np.hypot(one, d))
    without = (terms.sum(axis=1)[:, None] - terms).min(axis=0)
    row = int(np.argmin(without))
    point = search.best(one, without=row)
    residual, error = residuals(*search.speeds(point[None]))
    left = np.square(residual / np.hypot(one, error))[0]
    rest = float(left.sum() - left[row])
    gain = search.squares(best, one) - rest
    if is_stated:
        limit = float(ndtri(1.0 - 0.5 * _BY_CHANCE / places.size)) ** 2
    else:
        least = max(_LEAST, residuals.rounding) ** 2 / one**2
        limit = float(stdtrit(free - 1, 1.0 - 0.5 * _BY_CHANCE / places.size)) ** 2
        limit *= max(rest / (free - 1), least)
    return (int(places[row]),) if gain > limit else ()


def _next_point(
    question: SpeedQuestion, speeds: _Speeds, residuals: _Residuals, region: _Region, error: float
) -> NextPoint | None:
    """Return the setting, within the ranges of rows or scene file, where points that fit differ most."""
    order = np.lexsort(region.points.T)
    chosen = {*order[np.linspace(0, order.size - 1, _SAMPLES).round().astype(int)].tolist()}
    for column in region.points.T:
        chosen |= {int(column.argmin()), int(column.argmax())}
    points = region.points[sorted(chosen)]
    axes = _setting_axes(question, speeds)
    if not axes:
        return None
    columns = dict(zip(axes, (x.ravel() for x in np.meshgrid(*axes.values(), indexing="ij")), strict=True))
    others = {name: np.full_like(next(iter(columns.values())), x[0]) for name, x in speeds.columns.items()}
    taken = {STANDS_FOR.get(n, n) for n in columns}
    others = {n: x for n, x in others.items() if n not in columns and not (n in _SIZES and taken & {*_SIZES})}
    try:
        fields = speeds.settings({**others, **columns})
    except InputError:
        return None
    v, e = speeds(points, fields)
    # Logarithms of fast parts, shares of the usual speed of slow ones: a speed near 0 cannot be told from 0.
    slow = 2.0 * max(error, _LEAST) * residuals.usual
    placed, unknown = np.arcsinh(v / slow), np.isnan(v).any(axis=0)
    noise = np.hypot(error, (e / np.hypot(v, slow)).max(axis=0))
    gain = np.where(unknown, -np.inf, (placed.max(axis=0) - placed.min(axis=0)) / noise)
    at = int(np.argmax(gain))
    if not math.isfinite(gain[at]):
        return None
    setting = {name: float(f"{x[at]:.3g}") for name, x in columns.items()}
    return NextPoint(setting, float(v[:, at].min()), float(v[:, at].max()), float(gain[at]))


def _setting_axes(question: SpeedQuestion, speeds: _Speeds) -> dict[str, Floats]:
    """Return the settings that are compared, along one or two axes, in the units outside."""
    ranges = dict(question.ranges)
    if "stroke" in ranges or "amplitude" in ranges:
        ranges = {
            name: x for name, x in ranges.items() if name not in _SIZES or name in ("stroke", "amplitude")
        }
    sizes = [name for name in _SIZES if name in ranges] or [name for name in _SIZES if name in speeds.columns]
    for name in (*sizes[:1], *(n for n in speeds.columns if n not in _SIZES)):
        x = speeds.columns.get(name)
        if name not in ranges and x is not None and x.min() < x.max():
            ranges[name] = float(x.min()), float(x.max())
    if not ranges:
        name = sizes[0] if sizes else "amplitude"
        value = float(speeds.columns[name][0]) if sizes else float(speeds.fixed.get(name, 0.0))
        ranges = {name: ((1.0 - _HALF) * value, (1.0 + _HALF) * value)} if value else {}
    kept = [*sizes[:1], *(name for name in ranges if name not in sizes)]
    kept = [name for name in kept if name in ranges][:2]
    return {name: np.linspace(*ranges[name], _SETTINGS) for name in kept}


def _statements(
    found: SpeedFit, question: SpeedQuestion, speeds: _Speeds, region: _Region | None
) -> list[str]:
    """Say what is assumed, what the rows cannot tell, and which of them are wrong."""
    names = [parameter.name for parameter in found.parameters]
    low, high = found.reach.T
    beyond = abs(found.errors) * ((found.measured < low) | (found.measured > high)) * bool(names)
    named = np.flatnonzero((beyond > 1.0) | np.isin(np.arange(beyond.size), found.left_out)).tolist()
    said = [_wrong_row(found, row) for row in named]
    said += [
        f"row {found.table.rows[row]} does not agree with the others, which fit better without it:"
        f" {_check(found)}"
        for row in found.doubtful
    ]
    if len(found.left_out) == found.measured.size:
        return [*said, "no row could be fitted"]
    if {*_FRICTIONS} & {*names} and not {*_FRICTIONS} <= {*names} and not speeds.known:
        said.append(f"mu_d/mu_s is taken as {USUAL_RATIO:g}, which is usual; give mu_s, or the ratio")
    if found.error_is == "assumed" and names:
        percent = f"{100.0 * found.error:.2g} % is assumed" + ", which rounding makes" * (
            found.error > _ASSUMED
        )
        said.append(
            f"nothing tells the error of a {_measured(found)}: {percent}; repeat rows, or give a column"
            " error_percent"
        )
    if found.error_is == "widened":
        ratio = found.error / float(np.median(_relative(found)))
        said.append(
            f"the rows scatter {ratio:.2g} times as much as their errors say: intervals are widened by that"
        )
    for parameter in found.parameters:
        letter, pieces = QUANTITIES[parameter.name].letter, parameter.intervals
        if is_untold(parameter):
            said.append(f"these rows cannot tell {letter}: all values that are tried fit")
        elif parameter.open_low or parameter.open_high:
            ends = ["lower"] * parameter.open_low + ["upper"] * parameter.open_high
            said.append(f"these rows give {letter} no {' and no '.join(ends)} limit")
        if len(pieces) > 1:
            said.append(
                f"{len(pieces)} separate ranges of {letter} fit, as the speed rises and falls with it"
            )
    ratios = [i for i, axis in enumerate(speeds.axes) if axis.name == _RATIO]
    if region is not None and any(region.points[:, i].min() <= 0.0 for i in ratios):
        said.append(f"mu_d/mu_s below {TRIED[_RATIO][0]:g} was not tried")
    if "restitution" in names and not speeds.throws().any():
        said.append("no part hops in these rows: restitution has no effect")
    if region is not None and region.is_coarse:
        said.append("the search ended early: intervals hold all that fits, and may be too wide")
    return said


def _check(found: SpeedFit) -> str:
    return f"check its amplitude and {_measured(found)}, and restitution and slope of the scene"


def _measured(found: SpeedFit) -> str:
    return "time" if found.table.is_time else "speed"


def _relative(found: SpeedFit) -> Floats:
    assert found.table.error is not None
    moving = np.isfinite(found.table.measured) & (found.table.measured != 0.0)
    return np.asarray(found.table.error[moving] / abs(found.table.measured[moving]))


def is_untold(parameter: SpeedParameter) -> bool:
    """Whether the rows tell nothing of a quantity: all values that are tried fit."""
    low, pieces = TRIED[parameter.name][0], parameter.intervals
    least = parameter.open_low or (parameter.name == "restitution" and bool(pieces) and pieces[0][0] <= low)
    return least and parameter.open_high and len(pieces) == 1


def as_measured(found: SpeedFit, row: int, speed: float) -> str:
    """Write a speed as the table has it: as a time over the length of a row, or as it is."""
    if not found.table.is_time:
        return f"{1e3 * speed:.4g} mm/s"
    return f"{found.length[row] / speed:.4g} s" if speed > 0.0 else "never"


def _wrong_row(found: SpeedFit, row: int) -> str:
    low, high = found.reach[row]
    number, measured = found.table.rows[row], as_measured(found, row, float(found.measured[row]))
    if math.isnan(low):
        return f"row {number}: no speed is known there, it is left out: {_check(found)}"
    is_fast = found.measured[row] > high
    what = "more than the fastest" if is_fast else "less than the slowest"
    if found.table.is_time:
        what = "faster than any" if is_fast else "slower than any"
    limit = as_measured(found, row, float(high if is_fast else low))
    out = "; it is left out" * (row in found.left_out)
    return f"row {number}, {measured}, is {what} that was tried, {limit}{out}: {_check(found)}"


def next_text(found: SpeedFit) -> str:
    """Say where to measure next, and what is expected there; empty where nothing is fitted."""
    point = found.next_point
    if point is None:
        return ""
    units = {**QUANTITIES, ACCELERATION.name: ACCELERATION}
    where = ", ".join(
        f"{units[name].label} {units[name].text(value)}" for name, value in point.setting.items()
    )
    ends = [as_measured(found, 0, speed) for speed in (point.high, point.low)]
    between = " to ".join(dict.fromkeys(ends if found.table.is_time else ends[::-1]))
    if point.errors < _WORTH:
        return f"no setting tells more than {rounded(point.errors)} errors: repeat these rows"
    return f"{where}: values that fit give {between} there, {rounded(point.errors)} errors apart"
