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
from scipy.special import chdtrc, chdtri, fdtri

from vibro.axes import AxisSpec, one_value_of
from vibro.errors import InputError, cut, shown
from vibro.files.points import MeasuredSpeeds, read_speeds
from vibro.inverse_friction import USUAL_RATIO
from vibro.quantities import QUANTITIES, RATES, STANDS_FOR, scene_fields
from vibro.reals import shielded
from vibro.records.fitting import merged
from vibro.records.reading import TOL, rounded
from vibro.scene import Scene
from vibro.steady import solve
from vibro.sweeps.request import gather
from vibro.sweeps.whole import Inputs, inputs_of_call

if TYPE_CHECKING:
    from vibro.reals import Floats
    from vibro.sweeps.request import Request

#: What can be fitted to times or speeds.
FITTED: Final = ("kinetic_friction", "static_friction", "restitution")
_KINETIC, _STATIC, _BOUNCE = FITTED
_RATIO: Final = "friction_ratio"
#: Values that are tried: friction from a polished bearing to rubber, restitution up to hard balls.
TRIED: Final[Mapping[str, tuple[float, float]]] = {
    _KINETIC: (0.02, 2.0),
    _STATIC: (0.02, 2.0),
    _BOUNCE: (0.0, 0.6),
}
# Cells of the first grid along each coordinate, by the number of these: powers of 2, so that corners of
# their parts are equal where they meet.
_CELLS: Final = (1,), (128,), (32, 32), (32, 8, 8)
# Of the range that is tried: cells as small are not split, as a speed may jump there, and hops depend on
# restitution without end.
_SMALL: Final = {_KINETIC: 2e-5, _STATIC: 2e-5, _BOUNCE: 5e-3}
# Of the range of a residual over the corners of a cell, how far it may exceed them: of friction, and of hops.
_OUTSIDE: Final = 0.5, 1.0
_FINE: Final = 0.1  # of the threshold's root: range of the residuals over a cell that needs no splitting
_MOST_SCENES: Final = 400_000, 50_000  # that the search solves: in contact, and where parts hop
_AT_ONCE: Final = 20_000  # scenes in memory
_STARTS: Final = 3  # of least squares, and places around which an extreme speed is refined
_STEP: Final = 1e-4  # of the values that are tried, for derivatives
_ROUNDS: Final = 3  # of the search, where one finds a better fit than it began with,
_BETTER: Final = 0.02  # of the threshold, by which it must be better
_ASSUMED: Final = 0.02  # relative error of a time, or a speed, where nothing tells it: 0.1 s of 5 s
_LEAST: Final = 1e-3  # least relative error: amplitude and frequency are not known better
_LEFT_OUT: Final = 3.0  # errors beyond all that is computed at which a row is left out
_BY_CHANCE: Final = 0.01  # probability by which noise makes rows scatter more than their errors say
_NO_SPEED: Final = 1e-3  # [m/s] where no part moves: a speed that nobody overlooks
_FAR: Final = 50.0  # [1] logarithm of the ratio of two speeds of opposite sign: beyond all others
_WORTH: Final = 3.0  # [standard errors] least difference of speeds that a further point would tell apart
_SETTINGS: Final = 11  # amplitudes among which the next one is sought, each
_OTHERS: Final = 5  # with the other quantities of so many settings at most,
_SAMPLES: Final = 24  # and values that fit, whose speeds there are compared


@dataclass(frozen=True)
class SpeedParameter:
    """What times or speeds tell of one quantity.

    Attributes
    ----------
    name : str
        Its field of ``Scene``.
    value : float
        The best fit.
    intervals : tuple of pair of float
        Every value that fits, at 95 %: ascending and disjoint; several where the speed is not monotonic.
    """

    name: str
    value: float
    intervals: tuple[tuple[float, float], ...]

    @property
    def open_low(self) -> bool:
        """Whether the first interval begins where the values that are tried do: the rows set no bound."""
        low = TRIED[self.name][0]
        return 0.0 < self.intervals[0][0] <= low * (1.0 + TOL.rounding)

    @property
    def open_high(self) -> bool:
        """Whether the last interval ends where the values that are tried do."""
        return self.intervals[-1][1] >= TRIED[self.name][1] * (1.0 - TOL.rounding)

    @property
    def is_untold(self) -> bool:
        """Whether all values that are tried fit."""
        least = self.open_low or self.intervals[0][0] == 0.0
        return least and self.open_high and len(self.intervals) == 1


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
    length : float
        Of the trough; NaN where it is not known [m].
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
    reach : array of shape (n, 2)
        Least and largest speed of each row for the values that are tried [m/s].
    next_point : NextPoint or None
        Where to measure next.
    statements : tuple of str
        What is assumed, what the rows cannot tell, which rows are wrong, one sentence each.
    """

    parameters: tuple[SpeedParameter, ...]
    table: MeasuredSpeeds
    length: float
    measured: Floats
    computed: Floats
    errors: Floats
    error: float
    error_is: str
    left_out: tuple[int, ...]
    reach: Floats
    next_point: NextPoint | None
    statements: tuple[str, ...]


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
        ``stroke_mm``, ``frequency_hz`` or ``drive_angle_deg``, and ``traverse_time_s``, over the trough's
        length, or ``mean_velocity_mm_s``; if known a standard error, ``error_percent``. A time may be
        ``never``.
    scene_file : path, optional
        A scene file: what no column gives.
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
    left that may hold a value that fits. How often they hold the true value is counted by
    ``tests/records/test_speeds.py``.

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
    """

    table: MeasuredSpeeds
    request: Request
    names: tuple[str, ...]
    frictions: Mapping[str, float]
    is_chosen: bool


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
    wrong = [name for name in names if name not in FITTED or names.count(name) > 1]
    if wrong:
        hint = f"choose from {', '.join(QUANTITIES[name].letter for name in FITTED)}, each once"
        raise InputError(f"fit {cut(','.join(names))}: {shown(wrong[0])} cannot be fitted", hint=hint)
    slots = {STANDS_FOR.get(name, name) for name in table.settings}
    if twice := [QUANTITIES[name].label for name in given if STANDS_FOR.get(name, name) in slots]:
        raise InputError(
            *(f"{x} is given, and a column of {table.where}" for x in twice), hint="leave one out"
        )
    own = dict(file.scene) if file else {}
    if not {_KINETIC, _RATIO}.isdisjoint(given):  # one stands for the other
        own = {name: value for name, value in own.items() if name not in (_KINETIC, _RATIO)}
    frictions = {
        n: _friction(value, n) for n, value in {**own, **given}.items() if n in (_KINETIC, _STATIC, _RATIO)
    }
    if {_KINETIC, _STATIC} <= frictions.keys() - {*names} and frictions[_KINETIC] > frictions[_STATIC]:
        kinetic, static = frictions[_KINETIC], frictions[_STATIC]
        wrong_pair = f"kinetic friction = {kinetic:.15g}: must be at most static friction = {static:.15g}"
        raise InputError(wrong_pair, hint="friction at rest is the larger one: exchange them")
    fitted = tuple(names)
    if not names:
        implied = {_STATIC, *([_KINETIC] if _STATIC in frictions else [])} if _RATIO in frictions else {""}
        unknown = [name for name in FITTED if name not in {*own, *given, *implied}]
        fitted = tuple(unknown)
    elif _KINETIC not in names and (_KINETIC not in frictions if _STATIC in names else len(frictions) < 2):
        lacking = [QUANTITIES[n].label for n in (_STATIC, _KINETIC) if n not in {*frictions, *names}]
        raise InputError(f"missing: {' and '.join(lacking)}", hint="give them, or fit mu_d, or mu_s and mu_d")
    typed = {name: x for name, x in given.items() if name not in frictions}
    typed |= {name: repr(float(x[0])) for name, x in table.settings.items()}
    request = gather(
        typed, file, caller, asked_for=(_STATIC, _KINETIC), needs_length=table.is_time, pack=pack
    )
    if request.machine is not None:
        hint = "measure the amplitude, and give it in place of [machine]"
        raise InputError("[machine]: times and speeds need the amplitude itself", hint=hint)
    return SpeedQuestion(table, request, fitted, frictions, bool(names))


def _friction(value: Any, name: str) -> float:
    """Read a coefficient of friction, or the ratio of both."""
    quantity = QUANTITIES[name]
    number = float((value if isinstance(value, AxisSpec) else one_value_of(value, quantity)).value)
    low, high = TRIED.get(name, (0.0, 1.0))
    if not low <= number <= high or number == 0.0:
        allowed = "above 0 and at most 1" if name == _RATIO else f"{low:g} to {high:g}"
        raise InputError(f"{quantity.label} = {number:.15g}: must be {allowed}")
    return number


# ------------------------------------------------------------------------------
# Computed speeds and residuals of rows.


class _Rows:
    """Speeds of the distinct settings of rows over places of the unit cube, and residuals of the rows.

    A residual is the logarithm of computed over measured speed, in the error that is stated, if any: it
    treats times and speeds alike. A part that did not arrive has a speed of at most 0: its residual is the
    computed speed over the usual one.
    """

    def __init__(self, question: SpeedQuestion) -> None:
        table, self.request = question.table, question.request
        settings = table.settings
        stacked = np.stack([np.zeros(table.measured.size), *settings.values()], axis=1)
        distinct, self.which = np.unique(stacked, axis=0, return_inverse=True)
        self.settings = dict(zip(settings, distinct.T[1:], strict=True))
        self.count, self.names, self.known = len(distinct), question.names, question.frictions
        throw = solve(self.scenes({_STATIC: 1.0, _KINETIC: 1.0, _BOUNCE: 0.0}), output="regimes").throw_number
        self.hops = bool((throw > 1.0).any())
        if not question.is_chosen:
            if not self.hops:
                self.names = tuple(name for name in self.names if name != _BOUNCE)
            if self.count <= len(self.names) and _KINETIC in self.names:
                self.names = tuple(name for name in self.names if name != _STATIC)
        self.known = {name: x for name, x in question.frictions.items() if name not in self.names}

        length = float(self.request.length or math.nan) / 1e3
        self.length, self.is_never = length, np.isinf(table.measured)
        self.speed = length / table.measured if table.is_time else table.measured
        self.moves = self.speed != 0.0
        self.usual = float(np.median(abs(self.speed[self.moves]))) if self.moves.any() else _NO_SPEED
        self.size = np.where(self.moves, abs(self.speed), self.usual)
        self.is_stated = table.error is not None
        self.error = np.ones(self.speed.size) if table.error is None else table.error
        self.kept = np.ones(self.speed.size, np.bool_)
        finite = table.measured[self.moves]
        unit = next(
            (x for x in 10.0 ** -np.arange(6) if np.allclose(finite / x, np.rint(finite / x), 0, 1e-6)), 0.0
        )
        self.rounding = float(np.sqrt(np.mean((unit / finite) ** 2) / 12.0)) if finite.size else 0.0

    def values(self, points: Floats) -> dict[str, Floats]:
        """Return both frictions and the restitution at points of the unit cube, shape (M, d).

        Kinetic friction lies between what is tried and the static one that is given, static friction
        between the kinetic one and what is tried, both on scales of logarithms.
        """
        place = dict(zip(self.names, points.T, strict=True))
        static, kinetic, ratio = (self.known.get(name) for name in (_STATIC, _KINETIC, _RATIO))
        one, low, high = np.ones(len(points)), *TRIED[_KINETIC]
        top = high if static is None else static
        if _KINETIC in place:
            mu_d = np.minimum(low * (top / low) ** place[_KINETIC], top)
        else:
            mu_d = one * ((static or 0.0) * (ratio or 0.0) if kinetic is None else kinetic)
        if _STATIC in place:
            mu_s = mu_d * (high / mu_d) ** place[_STATIC]
        else:
            mu_s = mu_d / (ratio or USUAL_RATIO) if static is None else one * static
        bounce = place[_BOUNCE] * TRIED[_BOUNCE][1] if _BOUNCE in place else one * self.request.fixed[_BOUNCE]
        return {_KINETIC: mu_d, _STATIC: np.maximum(mu_s, mu_d), _BOUNCE: bounce}

    def scenes(self, found: Mapping[str, Any], settings: Mapping[str, Floats] | None = None) -> Scene:
        """Return the scenes of frictions and restitution at settings, by default those of the rows."""
        fields: dict[str, Any] = {**self.request.fixed, **(self.settings if settings is None else settings)}
        if "stroke" in fields:
            fields["amplitude"] = fields.pop("stroke") / 2.0
        if self.request.motion is not None:
            fields["motion"] = self.request.motion.motion
        return Scene(**scene_fields({**fields, **found}))

    def speeds(self, points: Floats, settings: Mapping[str, Floats] | None = None) -> tuple[Floats, Floats]:
        """Return the speeds and their standard errors, each of shape (M, K); NaN where there is no answer."""
        size, parts = max(1, _AT_ONCE // max(self.count, _SETTINGS)), []
        for start in range(0, len(points), size):
            found = {name: x[:, None] for name, x in self.values(points[start : start + size]).items()}
            cycle = solve(self.scenes(found, settings))
            parts.append((cycle.mean_velocity, np.nan_to_num(cycle.mean_velocity_error)))
        speeds, errors = (np.concatenate(part) for part in zip(*parts, strict=True))
        return speeds, errors

    def residuals(self, speeds: Floats, errors: Floats) -> tuple[Floats, Floats]:
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
        v, e, size = speeds[:, self.which[kept]], errors[:, self.which[kept]], self.size[kept]
        moves, forth = self.moves[kept], v * np.where(self.speed[kept] < 0.0, -1.0, 1.0)
        with np.errstate(divide="ignore", invalid="ignore"):
            r = np.where(forth > 0.0, np.log(np.maximum(forth, 0.0) / size), -_FAR)
            still = np.where(self.is_never[kept], np.maximum(v, 0.0), v) / size
            r, d = np.where(moves, r, still), np.where(moves, e / abs(v), e / size)
        r = np.clip(np.nan_to_num(r, nan=_FAR), -_FAR, _FAR)
        return r / self.error[kept], np.nan_to_num(d, posinf=0.0) / self.error[kept]


# ------------------------------------------------------------------------------
# The search: every point that fits, by cells that are split where they may hold one.


class _Search:
    """Evaluate residuals at points of the unit cube, and remember all of them."""

    def __init__(self, rows: _Rows) -> None:
        self.rows, self.size = rows, len(rows.names)
        self.cells = np.array(_CELLS[self.size][: self.size], float)
        self.points = np.array([*product(*(np.arange(n + 1) / n for n in self.cells))])
        self.grid = rows.speeds(self.points)

    def begin(self) -> None:
        """Compute the residuals of the first grid for the rows that are kept now."""
        self.found = self.rows.residuals(*self.grid)

    def __call__(self, points: Floats) -> tuple[Floats, Floats]:
        """Return residuals and the model's part of their errors at points, and remember them."""
        found = self.rows.residuals(*self.rows.speeds(points))
        self.points = np.concatenate([self.points, points])
        self.found = np.concatenate([self.found[0], found[0]]), np.concatenate([self.found[1], found[1]])
        return found

    def best(self, scale: float) -> Floats:
        """Return the best point that is remembered, improved by least squares."""

        def residual(point: Floats) -> Floats:
            r, d = self(np.clip(point, 0.0, 1.0)[None])
            return np.asarray((r / np.hypot(scale, d))[0])

        starts = self.points[np.argsort(_squares(*self.found, scale), kind="stable")[:_STARTS]]
        for start in np.clip(starts, 1e-9, 1.0 - 1e-9) if self.size else ():
            steps = np.full(self.size, _STEP)
            least_squares(residual, start, bounds=(0.0, 1.0), diff_step=steps, max_nfev=20)
        return np.asarray(self.points[np.argmin(_squares(*self.found, scale))])

    def region(self, scale: float, most: float, report: Callable[[], None]) -> tuple[Floats, bool]:
        """Return the corners of every cell that holds a point whose misfit is at most ``most``.

        Returns
        -------
        tuple
            Least and largest corners of cells, shape (2, C, d), and whether the search ended before cells
            were resolved: then all count that may hold a point.
        """
        size, root, best = self.size, math.sqrt(most), self.points[np.argmin(_squares(*self.found, scale))]
        corners = np.array([*product((0.0, 1.0), repeat=size)])
        low = np.array([*product(*(np.arange(n) / n for n in self.cells))])
        width = np.ones(low.shape) / self.cells
        small = np.array([_SMALL[name] for name in self.rows.names])
        left, done = _MOST_SCENES[self.rows.hops], [np.empty((2, 0, size))]
        while True:
            report()
            nodes = low[:, None] + width[:, None] * corners
            unique, back = np.unique(nodes.reshape(-1, size), axis=0, return_inverse=True)
            left -= len(unique) * self.rows.count
            is_first = len(done) == 1  # whose corners are the first grid
            r, d = (x[: len(unique)] for x in self.found) if is_first else self(unique)
            back = back.reshape(nodes.shape[:2])
            misfit, scaled = np.sqrt(_squares(r, d, scale))[back], (r / np.hypot(scale, d))[back]
            below, above = scaled.min(axis=1), scaled.max(axis=1)
            reach = _OUTSIDE[_BOUNCE in self.rows.names] * (above - below)
            nearest = np.maximum(np.maximum(below - reach, -above - reach), 0.0)
            bound = np.square(nearest).sum(axis=1)
            kept = (bound <= most) | ((low <= best) & (best <= low + width)).all(axis=1)
            cube = scaled.reshape(len(scaled), *(2,) * size, -1)
            edges, others = (abs(np.diff(cube, axis=1 + i)) for i in range(size)), tuple(range(1, size + 1))
            spread = np.stack([np.sqrt(np.square(x.max(axis=others)).sum(axis=1)) for x in edges], axis=1)
            spread = np.where(width > small, spread, 0.0)
            inside = misfit <= root
            least = -math.inf if _BOUNCE in self.rows.names else _squares(*self.found, scale).min()
            unsure = ~inside.all(axis=1) | (bound < least - _BETTER * most)  # or may hold a better fit
            active = kept & (spread.max(axis=1) > _FINE * root) & unsure
            is_coarse = bool(active.any()) and left < 2 * active.sum() * self.rows.count
            ends = kept & inside.any(axis=1) & ~active | (kept & active if is_coarse else False)
            done.append(np.stack([low, low + width])[:, ends])
            if is_coarse or not active.any():
                break
            axis = np.argmax(spread[active], axis=1)
            low, width = low[active], width[active]
            half = width * (np.arange(size) == axis[:, None]) / 2.0
            low, width = np.concatenate([low, low + half]), np.concatenate([width - half] * 2)
        fitting = self.points[_squares(*self.found, scale) <= most]
        return np.concatenate([*done, np.stack([fitting, fitting])], axis=1), is_coarse


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
        If a scene of a row is impossible.
    """
    rows, steps = _Rows(question), 0

    def report() -> None:
        nonlocal steps
        if progress:
            progress(steps, max(steps, 30), "fitting")
        steps += 1

    report()
    search = _Search(rows)
    search.begin()
    start = 1.0 if rows.is_stated else _ASSUMED
    reach, beyond = _beyond(rows, search)
    left_out = beyond > _LEFT_OUT
    rows.kept = ~left_out
    search.begin()
    moving = rows.kept & rows.moves
    free = int(moving.sum()) - min(search.size, np.unique(rows.which[moving]).size) if search.size else 0
    best, scale, error_is, is_coarse = search.points[0], start, "", False
    region = np.empty((2, 0, search.size))
    for _ in range(_ROUNDS):
        best = best if left_out.all() else search.best(start)
        scale, error_is = _scale(rows, float(_squares(*search.found, start).min()), free)
        if not search.size or left_out.all():
            break
        root = _threshold(rows.names, free if error_is in ("scatter", "widened") else 0)
        least = float(_squares(*search.found, scale).min())
        region, is_coarse = search.region(scale, least + root**2, report)
        if _squares(*search.found, scale).min() > least - _BETTER * root**2:
            break
    error = float(np.median(rows.error)) * scale
    parameters = []
    for name in rows.names if region.size else ():
        low, high = (rows.values(ends)[name].tolist() for ends in region)
        value = float(rows.values(best[None])[name][0])
        parameters.append(SpeedParameter(name, value, merged([*zip(low, high, strict=True)])))
    rows.kept[:] = True
    speed, its_error = rows.speeds(best[None])
    r, d = rows.residuals(speed, its_error)
    unknown = np.nan if left_out.all() else 0.0
    off = (r / np.hypot(scale, d))[0] * (1.0 if question.table.is_time else -1.0)
    ahead = _next_point(rows, region, error) if parameters else None
    found = SpeedFit(
        tuple(parameters), question.table, rows.length, rows.speed, speed[0, rows.which] + unknown,
        off + unknown, error, error_is, tuple(np.flatnonzero(left_out).tolist()), reach.T[rows.which],
        ahead, (),
    )  # fmt: skip
    statements = _statements(found, np.flatnonzero(beyond > 1.0).tolist(), rows, is_coarse=is_coarse)
    return replace(found, statements=tuple(statements))


def _beyond(rows: _Rows, search: _Search) -> tuple[Floats, Floats]:
    """Return the least and largest speed of each setting, and how far each row lies outside, in its errors.

    Speeds have shape (2, K); NaN where none is known. They are refined where a row lies outside.
    """
    speeds = search.grid[0]
    reach = np.stack([np.fmin.reduce(speeds), np.fmax.reduce(speeds)])
    error = 1.0 if rows.is_stated else max(_ASSUMED, rows.rounding)

    def outside() -> Floats:
        ends = rows.residuals(reach, np.zeros(reach.shape))[0] / error
        return np.where(ends[0] * ends[1] > 0.0, abs(ends).min(axis=0), 0.0)

    if not search.size:
        return reach, np.zeros(rows.speed.size)
    shifts = np.array([*product(np.linspace(-1.0, 1.0, 9), repeat=search.size)]) / search.cells
    for row in np.flatnonzero(outside() > 1.0).tolist():
        k, order = rows.which[row], np.argsort(abs(search.found[0][:, row]), kind="stable")
        near = (search.points[order[:_STARTS], None] + shifts).reshape(-1, search.size)
        v = np.append(rows.speeds(np.clip(near, 0.0, 1.0))[0][:, k], reach[:, k])
        reach[:, k] = np.fmin.reduce(v), np.fmax.reduce(v)
    return reach, outside()


def _scale(rows: _Rows, squares: float, free: int) -> tuple[float, str]:
    """Return the error of residuals, and where it is from, given their sum of squares at the best fit."""
    ratio = math.sqrt(squares / free) if free > 0 else 0.0
    if rows.is_stated:
        return (ratio, "widened") if free > 0 and chdtrc(free, squares) < _BY_CHANCE else (1.0, "stated")
    # The best of many fits that hops make as irregularly as noise scatters too little.
    least = max(_ASSUMED if _BOUNCE in rows.names else _LEAST, rows.rounding)
    return (max(_ASSUMED * ratio, least), "scatter") if free > 0 else (max(_ASSUMED, least), "assumed")


def _threshold(names: Sequence[str], free: int) -> float:
    """Return the root of the increase of the misfit at the ends of intervals.

    Hops depend on restitution as irregularly as noise, so that the least misfit is one of many: there the
    threshold is that of all quantities together. ``free`` is 0 where the error is known.
    """
    count = len(names) if _BOUNCE in names else 1
    if free:
        return math.sqrt(count * fdtri(count, free, TOL.confidence))
    return math.sqrt(chdtri(count, 1.0 - TOL.confidence))


def _next_point(rows: _Rows, region: Floats, error: float) -> NextPoint | None:
    """Return the setting at which values that fit differ most: an amplitude within the range of the rows.

    Of rows with a single one, it lies between a half and one and a half times that.
    """
    size = "stroke" if "stroke" in rows.settings else "amplitude"
    size = next((name for name in RATES if name in rows.request.fixed), size)
    given = rows.settings.get(size, np.atleast_1d(rows.request.fixed.get(size, np.nan)))
    if np.isnan(given).any():
        return None
    low, high = float(given.min()), float(given.max())
    tried = np.linspace(low, high, _SETTINGS) if low < high else np.linspace(0.5, 1.5, _SETTINGS) * low
    others = {name: x for name, x in rows.settings.items() if name != size}
    distinct = np.unique(np.stack([np.zeros(rows.count), *others.values()], axis=1), axis=0)
    distinct = distinct[np.linspace(0, len(distinct) - 1, min(len(distinct), _OTHERS)).round().astype(int)]
    columns = {name: np.repeat(x, _SETTINGS) for name, x in zip(others, distinct.T[1:], strict=True)}
    columns[size] = np.tile(tried, len(distinct))
    ends = np.unique(region.reshape(-1, region.shape[-1]), axis=0)
    chosen = np.linspace(0, len(ends) - 1, _SAMPLES).round().astype(int)
    points = ends[np.unique([*chosen, *ends.argmin(axis=0), *ends.argmax(axis=0)])]
    v, e = rows.speeds(points, columns)
    # Logarithms of fast parts, shares of a tenth of the usual speed of slow ones: nobody waits for those.
    slow = 0.1 * rows.usual
    placed, unknown = np.arcsinh(v / slow), np.isnan(v).any(axis=0)
    noise = np.hypot(error, (e / np.hypot(v, slow)).max(axis=0))
    gain = np.where(unknown, -np.inf, (placed.max(axis=0) - placed.min(axis=0)) / noise)
    at = int(np.argmax(gain))
    if not math.isfinite(gain[at]):
        return None
    setting = {name: float(f"{x[at]:.3g}") for name, x in columns.items()}
    return NextPoint(setting, float(v[:, at].min()), float(v[:, at].max()), float(gain[at]))


def _statements(found: SpeedFit, beyond: Sequence[int], rows: _Rows, *, is_coarse: bool) -> list[str]:
    """Say what is assumed, what the rows cannot tell, and which of them are wrong."""
    table, names = found.table, rows.names
    said = [_wrong_row(found, row) for row in beyond]
    said += [f"column {shown(text)} is not used" for text in table.ignored]
    if len(found.left_out) == len(table.rows):
        return [*said, "no row could be fitted"]
    if len({_KINETIC, _STATIC} & {*names}) == 1 and not rows.known:
        said.append(f"mu_d/mu_s is taken as {USUAL_RATIO:g}, which is usual; give mu_s, or the ratio")
    if found.error_is == "assumed" and names:
        said.append(
            f"nothing tells the error of a row: {100.0 * found.error:.2g} % is assumed; repeat rows, or"
            " give a column error_percent"
        )
    if found.error_is == "widened":
        ratio = found.error / float(np.median(rows.error))
        said.append(
            f"the rows scatter {ratio:.2g} times as much as their errors say: intervals are widened by that"
        )
    for parameter in found.parameters:
        letter, pieces = QUANTITIES[parameter.name].letter, len(parameter.intervals)
        if parameter.is_untold:
            said.append(f"these rows cannot tell {letter}: all values that are tried fit")
        if pieces > 1:
            said.append(f"{pieces} separate ranges of {letter} fit, as the speed rises and falls with it")
    if _BOUNCE in names and not rows.hops:
        said.append("no part hops in these rows: restitution has no effect")
    if is_coarse:
        said.append("the search ended early: intervals hold all that fits, and may be too wide")
    return said


def as_measured(found: SpeedFit, speed: float) -> str:
    """Write a speed as the table has it: as a time over the length, or as it is."""
    if not found.table.is_time:
        return f"{1e3 * speed:.4g} mm/s"
    return f"{found.length / speed:.4g} s" if speed > 0.0 else "never"


def _wrong_row(found: SpeedFit, row: int) -> str:
    low, high = found.reach[row].tolist()
    is_fast = bool(found.measured[row] > high)
    limit = as_measured(found, high if is_fast else low)
    what = f"{'faster' if is_fast else 'slower'} than any that was tried, {limit}"
    if math.isnan(low):
        what = "where no speed is known"
    out = "; it is left out" * (row in found.left_out)
    measured = as_measured(found, float(found.measured[row]))
    own = f"amplitude and {'time' if found.table.is_time else 'speed'}"
    check = f"check its {own}, and restitution and slope of the scene"
    return f"row {found.table.rows[row]}, {measured}, is {what}{out}: {check}"


def next_text(found: SpeedFit) -> str:
    """Say where to measure next, and what is expected there; empty where nothing is fitted."""
    point = found.next_point
    if point is None:
        return ""
    if point.errors < _WORTH:
        return f"no setting tells more than {rounded(point.errors)} errors: repeat these rows"
    where = ", ".join(f"{QUANTITIES[n].label} {QUANTITIES[n].text(x)}" for n, x in point.setting.items())
    ends = [as_measured(found, speed) for speed in (point.high, point.low)]
    between = " to ".join(dict.fromkeys(ends if found.table.is_time else ends[::-1]))
    return f"{where}: values that fit give {between} there, {rounded(point.errors)} errors apart"
