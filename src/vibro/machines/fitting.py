"""Natural frequency, damping and static amplitude of a machine from measured amplitudes."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final, Literal, NamedTuple

import numpy as np

from vibro.errors import Problem, SceneError, shown
from vibro.reals import NotRealError, real_array, shielded

if TYPE_CHECKING:
    from vibro.reals import Floats


Law = Literal["constant", "square"]

#: Exponents of the force over frequency, by the name of the law.
_LAWS: Final = {"constant": 0, "square": 2}
#: Least number of points at different frequencies: there are three unknowns.
LEAST_POINTS: Final = 3
#: Least number of points whose residuals give the error of an amplitude: two degrees of freedom.
POINTS_FOR_ERROR: Final = 5
_CONFIDENCE: Final = 0.95
# Starts of the search: natural frequencies over those of the points [1], and 4 zeta^2 [1].
_STARTS_BEYOND: Final = 4.0
_START_COUNTS: Final = 60
_START_DAMPING: Final = np.geomspace(1e-5, 1.0, 9)
_KEPT_STARTS: Final = 3
# The search ends where a step would lower the sum of squares, which is of the order of 1, by less.
_ENOUGH: Final = 1e-8
_MOST_STEPS: Final = 100
# A profile that does not end within this change of a logarithm is unbounded: a factor of about 1000.
_FARTHEST: Final = 7.0
_MOST_DAMPING: Final = 16.0  # 4 zeta^2 at a damping ratio of 2, far above those with a resonance
_CLOSE: Final = 1e-4  # [1] accuracy of the increase of the misfit at an end of an interval
_MOST_TRIES: Final = 60


@dataclass(frozen=True, eq=False, kw_only=True)
class ResponseFit:
    """Estimates from amplitudes over frequency, with errors.

    Attributes
    ----------
    law : str
        ``constant`` (magnet) or ``square`` (unbalance): how the force depends on frequency.
    frequency, amplitude : (n,) array
        The points [Hz, m], by ascending frequency.
    natural_frequency, damping_ratio, static_amplitude : float
        Estimates [Hz, 1, m]; the static amplitude is force over stiffness, under ``square`` the amplitude
        far above resonance. All NaN unless points lie on both sides of the largest amplitude;
        ``damping_ratio`` is NaN where its square is negative.
    damping_squared : float
        Estimate of the square of the damping ratio [1], negative where the errors are larger than damping;
        NaN as above.
    natural_frequency_sd, damping_ratio_sd, static_amplitude_sd : float
        Standard errors by the delta method, in the same units; NaN without an estimate or an amplitude error.
    natural_frequency_interval, damping_ratio_interval, static_amplitude_interval : pair of float
        Confidence intervals at 95 %, by the profile of the misfit; also where there is no estimate. An end
        may be 0 or infinite. NaN without an amplitude error.
    amplitude_error : (n,) array
        Relative standard error of each amplitude [1]: as stated, or from the residuals; NaN if neither.
    is_error_stated : bool
        Whether it was stated.
    brackets_peak : bool
        Whether points lie on both sides of the largest amplitude.
    residual : (n,) array
        Measured over fitted amplitude, less 1 [1].
    curve : tuple of float
        Natural frequency, damping ratio and static amplitude of the fitted curve [Hz, 1, m]: the estimates,
        and without them the best fit with a damping ratio of 0 or more.
    """

    law: str
    frequency: Floats
    amplitude: Floats
    natural_frequency: float
    damping_ratio: float
    static_amplitude: float
    damping_squared: float
    natural_frequency_sd: float
    damping_ratio_sd: float
    static_amplitude_sd: float
    natural_frequency_interval: tuple[float, float]
    damping_ratio_interval: tuple[float, float]
    static_amplitude_interval: tuple[float, float]
    amplitude_error: Floats
    is_error_stated: bool
    brackets_peak: bool
    residual: Floats
    curve: tuple[float, float, float]

    def amplitudes(self, frequency: Any) -> Floats:
        """Return fitted amplitudes [m] at frequencies [Hz]."""
        return _amplitudes(np.asarray(frequency, np.float64), self.curve, self.law)


def _amplitudes(frequency: Floats, curve: tuple[float, float, float], law: str) -> Floats:
    natural, damping, static = curve
    x = (frequency / natural) ** 2
    size = static * (x if _LAWS[law] else 1.0)
    with np.errstate(divide="ignore"):  # at resonance without damping
        return np.asarray(size / np.sqrt((1.0 - x) ** 2 + 4.0 * damping**2 * x))


class _LeastSquares(NamedTuple):
    """Estimates [Hz, 1, m] and their standard errors; NaN where there are none."""

    natural_frequency: float
    damping_squared: float
    static_amplitude: float
    natural_frequency_sd: float
    damping_squared_sd: float
    static_amplitude_sd: float


@shielded
def fit_response(points: Any, *, law: Law = "constant", amplitude_error: Any = None) -> ResponseFit:
    """Estimate natural frequency, damping ratio and static amplitude from measured amplitudes.

    Assumes one linear resonance, a force that is constant or grows with the square of frequency, and
    amplitudes with independent relative errors; frequencies are exact.

    Parameters
    ----------
    points : array_like, shape (n, 2)
        Frequency [Hz] and amplitude [m] of each point, at 3 or more different frequencies.
    law : str
        ``constant`` for magnets, ``square`` for unbalance.
    amplitude_error : array_like, optional
        Relative standard error of an amplitude, of all or of each [1]. Without it, it is estimated from the
        residuals of 5 or more points.

    Returns
    -------
    ResponseFit
        Estimates, their standard errors and intervals.

    Raises
    ------
    SceneError
        If points are too few, not positive, or a value is invalid.

    Notes
    -----
    ``f^(2 e) / A^2 = a f^4 + b f^2 + c`` is linear in a, b, c (e = 0 for ``constant``, 2 for ``square``); it
    is weighted by ``1 / (2 s y)^2``, and ``f0 = (c / a)^(1/4)``, ``zeta^2 = (2 + b / sqrt(a c)) / 4``. The
    intervals hold every value with which the logarithms of the amplitudes can be fitted, ``zeta >= 0``:
    their sum of squares may exceed the least by the square of Student's t (of the normal quantile, if the
    error is stated). Measured coverage: ``tests/machines/test_fitting.py``, benchmarks/machine_fits.py.

    Examples
    --------
    >>> from vibro.machines.fitting import fit_response
    >>> points = [(47.07, 0.0955e-3), (50.21, 0.182e-3), (54.39, 0.1725e-3)]
    >>> fit = fit_response(points, amplitude_error=0.02)
    >>> print(f"{fit.natural_frequency:.2f} +- {fit.natural_frequency_sd:.2f} Hz, {fit.damping_ratio:.4f}")
    52.31 +- 0.06 Hz, 0.0368
    """
    if law not in _LAWS:
        raise SceneError((Problem("law", shown(law), "constant or square"),))
    frequency, amplitude, stated = _checked(points, amplitude_error)
    error = np.ones(frequency.size) if stated is None else stated
    search = _Search(frequency, amplitude, error, law)
    best = search.best()
    spare = frequency.size - len(best)
    factor, quantile = 1.0, 1.0
    if stated is None:
        knows = frequency.size >= POINTS_FOR_ERROR
        factor = math.sqrt(search.squares(best) / spare) if knows else math.nan
        error = error * factor
    if not math.isnan(factor):
        quantile = _quantile(spare if stated is None else math.inf)
        intervals = search.intervals(best, (quantile * factor) ** 2)
    else:
        intervals = [(math.nan, math.nan)] * 3
    peak = frequency[np.argmax(amplitude)]
    brackets = bool(frequency[0] < peak < frequency[-1])
    linear = least_squares(
        frequency, amplitude, error if not math.isnan(factor) else np.ones(error.size), law
    )
    if math.isnan(factor):
        linear = linear._replace(
            natural_frequency_sd=math.nan, damping_squared_sd=math.nan, static_amplitude_sd=math.nan
        )
    if not brackets:
        linear = _LeastSquares(*[math.nan] * 6)
    damping = math.sqrt(linear.damping_squared) if linear.damping_squared > 0.0 else math.nan
    curve = (linear.natural_frequency, damping, linear.static_amplitude)
    if math.isnan(damping):
        curve = (math.exp(0.5 * best[1]), 0.5 * math.sqrt(best[2]), math.exp(best[0]))
    return ResponseFit(
        law=law,
        frequency=frequency,
        amplitude=amplitude,
        natural_frequency=linear.natural_frequency,
        damping_ratio=damping,
        static_amplitude=linear.static_amplitude,
        damping_squared=linear.damping_squared,
        natural_frequency_sd=linear.natural_frequency_sd,
        damping_ratio_sd=linear.damping_squared_sd / (2.0 * damping),
        static_amplitude_sd=linear.static_amplitude_sd,
        static_amplitude_interval=intervals[0],
        natural_frequency_interval=intervals[1],
        damping_ratio_interval=intervals[2],
        amplitude_error=error,
        is_error_stated=stated is not None,
        brackets_peak=brackets,
        residual=amplitude / _amplitudes(frequency, curve, law) - 1.0,
        curve=curve,
    )


def least_squares(frequency: Floats, amplitude: Floats, error: Floats, law: str) -> _LeastSquares:
    """Fit ``f^(2 e) / A^2 = a f^4 + b f^2 + c``, weighted by the relative errors of the amplitudes."""
    scale = math.exp(float(np.mean(np.log(frequency))))  # keeps the columns of the same size
    x = (frequency / scale) ** 2
    y = x ** _LAWS[law] / amplitude**2
    rows = np.stack([x * x, x, np.ones(x.size)], axis=1) / (2.0 * error * y)[:, None]
    (a, b, c), *_ = np.linalg.lstsq(rows, 1.0 / (2.0 * error), rcond=None)
    if not (a > 0.0 and c > 0.0):
        return _LeastSquares(*[math.nan] * 6)
    covariance = np.linalg.pinv(rows.T @ rows, hermitian=True)
    ratio = 1.0 / math.sqrt(a * c)
    gain = 1.0 / math.sqrt(a if _LAWS[law] else c)
    frequency_0 = (c / a) ** 0.25

    def sd(gradient: list[float]) -> float:
        return math.sqrt(max(float(np.array(gradient) @ covariance @ gradient), 0.0))

    slope = -0.125 * b * ratio
    return _LeastSquares(
        scale * frequency_0,
        0.25 * (2.0 + b * ratio),
        gain,
        scale * 0.25 * frequency_0 * sd([-1.0 / a, 0.0, 1.0 / c]),
        sd([slope / a, 0.25 * ratio, slope / c]),
        0.5 * gain**3 * sd([1.0, 0.0, 0.0] if _LAWS[law] else [0.0, 0.0, 1.0]),
    )


class _Search:
    """Misfit of the logarithms of amplitudes, over ``p = (ln A_static, ln f0^2, 4 zeta^2)``."""

    def __init__(self, frequency: Floats, amplitude: Floats, error: Floats, law: str) -> None:
        self.squared = frequency**2
        self.measured = np.log(amplitude)
        self.error = error
        self.is_square = bool(_LAWS[law])

    def residuals(self, p: Floats) -> Floats:
        """Return logarithms of measured over fitted amplitudes, over their errors [1]."""
        x = self.squared * math.exp(-p[1])
        model = p[0] - 0.5 * np.log((1.0 - x) ** 2 + p[2] * x)
        if self.is_square:
            model = model + np.log(x)
        return np.asarray((self.measured - model) / self.error)

    def squares(self, p: Floats) -> float:
        """Return the sum of squares."""
        with np.errstate(divide="ignore"):  # a point at resonance without damping: infinite
            r = self.residuals(p)
        return float(r @ r)

    def _jacobian(self, p: Floats) -> Floats:
        """Return derivatives of the residuals, a column for each coordinate."""
        x = self.squared * math.exp(-p[1])
        d = (1.0 - x) ** 2 + p[2] * x
        along = 0.5 * x * (p[2] - 2.0 * (1.0 - x)) / d - self.is_square
        return np.asarray(-np.stack([np.ones(x.size), along, -0.5 * x / d], axis=1) / self.error[:, None])

    def minimum(self, p: Floats, free: Sequence[int] = (0, 1, 2)) -> Floats:
        """Minimise over some coordinates by Levenberg-Marquardt; the damping stays at 0 or above."""
        squares, weight = self.squares(p), 1e-3
        for _ in range(_MOST_STEPS):
            jacobian, r = self._jacobian(p), self.residuals(p)
            gradient = jacobian.T @ r
            moves = [k for k in free if k != 2 or p[2] > 0.0 or gradient[2] < 0.0]
            part = jacobian[:, moves]
            normal = part.T @ part
            while True:
                damped = normal + weight * np.diag(normal.diagonal())
                step = np.linalg.solve(damped, -gradient[moves])
                tried = p.copy()
                tried[moves] += step
                tried[2] = max(tried[2], 0.0)
                tried[1] = min(max(tried[1], p[1] - 1.0), p[1] + 1.0)
                found = self.squares(tried)
                if found < squares or weight > 1e12:
                    break
                weight *= 10.0
            if not found < squares:
                break
            gain, p, squares, weight = squares - found, tried, found, max(weight / 10.0, 1e-9)
            if gain <= _ENOUGH * min(1.0, squares):
                break
        return p

    def _starts(self) -> list[Floats]:
        """Return the best points of a grid of natural frequencies and damping."""
        low, high, beyond = np.log(self.squared[0]), np.log(self.squared[-1]), math.log(_STARTS_BEYOND)
        across = np.linspace(low - beyond, high + beyond, _START_COUNTS)
        grid = np.array([(0.0, u, z) for u in across for z in _START_DAMPING])
        x = self.squared * np.exp(-grid[:, 1:2])
        above = self.measured + 0.5 * np.log((1.0 - x) ** 2 + grid[:, 2:] * x) - self.is_square * np.log(x)
        weights = self.error**-2
        grid[:, 0] = above @ weights / weights.sum()
        squares = (above - grid[:, :1]) ** 2 @ weights
        return [*grid[np.argsort(squares)[:_KEPT_STARTS]]]

    def best(self) -> Floats:
        """Return the least misfit."""
        return min((self.minimum(p) for p in self._starts()), key=self.squares)

    def intervals(self, best: Floats, increase: float) -> list[tuple[float, float]]:
        """Return intervals of static amplitude [m], natural frequency [Hz] and damping ratio [1]."""
        ends = [[self._end(best, k, way, increase) for way in (-1.0, 1.0)] for k in range(3)]
        (a, b), (c, d), (e, f) = ends
        return [
            (math.exp(a), math.exp(b)),
            (math.exp(0.5 * c), math.exp(0.5 * d)),
            (0.5 * math.sqrt(max(e, 0.0)), 0.5 * math.sqrt(f)),
        ]

    def _end(self, best: Floats, k: int, way: float, increase: float) -> float:
        """Return where the profile of a coordinate has risen by ``increase``; infinite if it does not."""
        least, aim = self.squares(best), math.sqrt(increase)
        free = [j for j in range(3) if j != k]
        limit = best[k] + way * _FARTHEST if k < 2 else (_MOST_DAMPING if way > 0.0 else 0.0)
        covariance = np.linalg.pinv(self._jacobian(best).T @ self._jacobian(best), hermitian=True)
        step = way * max(aim * math.sqrt(max(covariance[k, k], 0.0)), 1e-9)
        inside, root = best, 0.0
        outside, far = limit, math.inf
        is_bracketed = False
        for _ in range(_MOST_TRIES):
            if not is_bracketed:
                value = inside[k] + step
                step *= 2.0
                if way * (value - limit) >= 0.0:
                    value = limit
            else:
                share = min(max((aim - root) / (far - root), 0.05), 0.95) if math.isfinite(far) else 0.5
                value = inside[k] + share * (outside - inside[k])
            start = inside.copy()
            start[k] = value
            found = self.minimum(start, free)
            risen = math.sqrt(max(self.squares(found) - least, 0.0))
            if abs(risen - aim) <= _CLOSE * aim:
                return float(value)
            if risen >= aim:
                outside, far, is_bracketed = value, risen, True
            elif value == limit:
                return limit if k == 2 and way < 0.0 else way * math.inf
            else:
                inside, root = found, risen
            if is_bracketed and abs(outside - inside[k]) <= _CLOSE * abs(outside - best[k]):
                break
        return float(outside)


def _quantile(freedom: float) -> float:
    """Return Student's t at both ends of the confidence, for so many degrees of freedom."""
    from scipy.special import stdtrit  # late: it takes a tenth of a second to load

    return float(stdtrit(min(freedom, 1e9), 0.5 + 0.5 * _CONFIDENCE))


def _checked(points: Any, amplitude_error: Any) -> tuple[Floats, Floats, Floats | None]:
    """Return frequencies, amplitudes and stated errors by ascending frequency."""
    problems = []
    table, error = np.empty((0, 2)), None
    try:
        table = real_array(points)
    except NotRealError as exc:
        problems.append(Problem("points", exc.value, exc.allowed))
    else:
        if table.ndim != 2 or table.shape[1] != 2 or np.unique(table[:, 0]).size < LEAST_POINTS:
            rule = (
                f"pairs of frequency [Hz] and amplitude [m] at {LEAST_POINTS} or more different frequencies"
            )
            problems.append(Problem("points", shown(points), rule))
        elif not np.all(np.isfinite(table) & (table > 0.0)):
            bad = table[~np.all(np.isfinite(table) & (table > 0.0), axis=1)][0]
            problems.append(Problem("points", shown(bad.tolist()), "positive and finite"))
    if amplitude_error is not None:
        try:
            error = real_array(amplitude_error)
        except NotRealError as exc:
            problems.append(Problem("amplitude_error", exc.value, exc.allowed))
        else:
            if not np.all((error > 0.0) & (error < 1.0)) or error.shape not in ((), (len(table),)):
                rule = "one relative error, such as 0.02, or one for each point, above 0 and below 1"
                problems.append(Problem("amplitude_error", shown(amplitude_error), rule))
    if problems:
        raise SceneError(tuple(problems))
    order = np.argsort(table[:, 0], kind="stable")
    if error is not None:
        error = np.broadcast_to(error, (len(table),))[order]
    return table[order, 0], table[order, 1], error
