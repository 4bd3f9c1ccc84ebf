"""Natural frequency, damping and static amplitude of a machine from measured amplitudes."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final, Literal, NamedTuple

import numpy as np

from vibro.errors import SceneError, shown
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
# Starts of the search: natural frequencies over those of the points [1], and 2 zeta [1].
_STARTS_BEYOND: Final = 4.0
_START_COUNTS: Final = 60
_START_DAMPING: Final = np.geomspace(3e-3, 1.0, 9)
_KEPT_STARTS: Final = 3
_LEAST_DAMPING: Final = 0.1  # 2 zeta of a start: at 0 the misfit is level
_NO_POLE: Final = 1e-300  # [1] at resonance without damping
_MOST_LOG: Final = 200.0  # of a square of frequencies, far beyond those that fit
# A profile that does not end within this change of a logarithm is unbounded: a factor of about 1000.
_FARTHEST: Final = 7.0
_MOST_DAMPING: Final = 4.0  # 2 zeta, far above those with a resonance
_CLOSE: Final = 1e-4  # [1] accuracy of an end of an interval


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


_UNKNOWN: Final = _LeastSquares(*[math.nan] * 6)


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
    error is stated). Measured coverage: ``tests/machines/test_fitting.py``.

    Examples
    --------
    >>> from vibro.machines.fitting import fit_response
    >>> points = [(47.07, 0.0955e-3), (50.21, 0.182e-3), (54.39, 0.1725e-3)]
    >>> fit = fit_response(points, amplitude_error=0.02)
    >>> print(f"{fit.natural_frequency:.2f} +- {fit.natural_frequency_sd:.2f} Hz, {fit.damping_ratio:.4f}")
    52.31 +- 0.06 Hz, 0.0368
    """
    if law not in _LAWS:
        raise SceneError.of("law", shown(law), "constant or square")
    frequency, amplitude, stated = _checked(points, amplitude_error)
    search = _Search(frequency, amplitude, np.ones(frequency.size) if stated is None else stated, law)
    best = search.best()
    freedom, factor = math.inf, 1.0  # of the errors: what they are over those of the search
    if stated is None:
        freedom = float(frequency.size - best.size)
        is_known = frequency.size >= POINTS_FOR_ERROR
        factor = math.sqrt(search.squares(best) / freedom) if is_known else math.nan
    intervals = [(math.nan, math.nan)] * 3
    if not math.isnan(factor):
        quantile = _quantile(freedom)
        intervals = search.intervals(best, (quantile * factor) ** 2)
    brackets = bool(frequency[0] < frequency[np.argmax(amplitude)] < frequency[-1])
    linear = least_squares(frequency, amplitude, search.error, law) if brackets else _UNKNOWN
    damping = math.sqrt(linear.damping_squared) if linear.damping_squared > 0.0 else math.nan
    curve = (linear.natural_frequency, damping, linear.static_amplitude)
    if math.isnan(damping):
        curve = (math.exp(0.5 * best[1]), 0.5 * best[2], math.exp(best[0]))
    return ResponseFit(
        law=law,
        frequency=frequency,
        amplitude=amplitude,
        natural_frequency=linear.natural_frequency,
        damping_ratio=damping,
        static_amplitude=linear.static_amplitude,
        damping_squared=linear.damping_squared,
        natural_frequency_sd=factor * linear.natural_frequency_sd,
        damping_ratio_sd=factor * linear.damping_squared_sd / (2.0 * damping),
        static_amplitude_sd=factor * linear.static_amplitude_sd,
        static_amplitude_interval=intervals[0],
        natural_frequency_interval=intervals[1],
        damping_ratio_interval=intervals[2],
        amplitude_error=factor * search.error,
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
        return _UNKNOWN
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
    """Misfit of the logarithms of amplitudes, over ``p = (ln A_static, ln f0^2, 2 zeta)``."""

    def __init__(self, frequency: Floats, amplitude: Floats, error: Floats, law: str) -> None:
        self.squared = frequency**2
        self.measured = np.log(amplitude)
        self.error = error
        self.is_square = bool(_LAWS[law])

    def residuals(self, p: Floats) -> Floats:
        """Return logarithms of measured over fitted amplitudes, over their errors, at points (..., 3) [1]."""
        a, u, z = np.moveaxis(p[..., np.newaxis], -2, 0)
        x = self._ratios(u)
        model = a - 0.5 * np.log((1.0 - x) ** 2 + z * z * x + _NO_POLE)
        if self.is_square:
            model = model + np.log(x)
        return np.asarray((self.measured - model) / self.error)

    def _ratios(self, u: Floats) -> Floats:
        """Return the squares of frequencies over natural ones."""
        return np.asarray(self.squared * np.exp(np.clip(-u, -_MOST_LOG, _MOST_LOG)))

    def squares(self, p: Floats) -> float:
        """Return the sum of squares."""
        return float(np.square(self.residuals(p)).sum())

    def _jacobian(self, p: Floats) -> Floats:
        """Return derivatives of the residuals, a column for each coordinate."""
        x = self._ratios(p[1])
        d = (1.0 - x) ** 2 + p[2] ** 2 * x + _NO_POLE
        along = 0.5 * x * (p[2] ** 2 - 2.0 * (1.0 - x)) / d - self.is_square
        return np.asarray(-np.stack([np.ones(x.size), along, -p[2] * x / d], axis=1) / self.error[:, None])

    def _minimum(self, start: Floats, free: Sequence[int] = (0, 1, 2)) -> Floats:
        """Minimise over some coordinates: with MINPACK, in half the time of ``least_squares``."""
        from scipy import optimize

        def at(coordinates: Floats) -> Floats:
            p = start.copy()
            p[list(free)] = coordinates
            return p

        first = start[list(free)]
        if 2 in free:
            first[-1] = max(first[-1], _LEAST_DAMPING)

        def slopes(coordinates: Floats) -> Floats:
            return self._jacobian(at(coordinates))[:, list(free)]

        def residuals(coordinates: Floats) -> Floats:
            return self.residuals(at(coordinates))

        p = at(optimize.leastsq(residuals, first, Dfun=slopes, full_output=True)[0])
        p[2] = abs(p[2])
        return p

    def _starts(self, held: int | None = None, value: float = 0.0) -> list[Floats]:
        """Return the best points of a grid of natural frequencies and damping, one coordinate held."""
        low, high, beyond = np.log(self.squared[0]), np.log(self.squared[-1]), math.log(_STARTS_BEYOND)
        across = np.linspace(low - beyond, high + beyond, _START_COUNTS)
        grid = np.array([(0.0, u, z) for u in across for z in _START_DAMPING])
        if held is not None:
            grid[:, held] = value
        if held != 0:  # the best static amplitude of each
            weights = self.error**-2
            grid[:, 0] = (self.residuals(grid) * self.error) @ weights / weights.sum()
        squares = np.square(self.residuals(grid)).sum(axis=1)
        return [*grid[np.argsort(squares)[:_KEPT_STARTS]]]

    def best(self) -> Floats:
        """Return the least misfit."""
        return min((self._minimum(p) for p in self._starts()), key=self.squares)

    def intervals(self, best: Floats, increase: float) -> list[tuple[float, float]]:
        """Return intervals of static amplitude [m], natural frequency [Hz] and damping ratio [1]."""
        ends = np.array([[self._end(best, k, way, increase) for way in (-1.0, 1.0)] for k in range(3)])
        ends[1:] *= 0.5
        ends[:2] = np.exp(ends[:2])
        return [(low, high) for low, high in ends.tolist()]

    def _end(self, best: Floats, k: int, way: float, increase: float) -> float:
        """Return where the profile of a coordinate has risen by ``increase``; infinite if it does not."""
        from scipy import optimize

        free = [j for j in range(3) if j != k]
        least, aim = self.squares(best), math.sqrt(increase)
        limit = best[k] + way * _FARTHEST if k < 2 else (_MOST_DAMPING if way > 0.0 else 0.0)

        def profile(value: float, *others: Floats) -> Floats:
            near = inside.copy()
            near[k] = value
            found = [self._minimum(p, free) for p in (near, *others)]
            return min(near, *found, key=self.squares)

        def excess(p: Floats) -> float:
            return math.sqrt(max(self.squares(p) - least, 0.0)) - aim

        jacobian = self._jacobian(best)
        covariance = np.linalg.pinv(jacobian.T @ jacobian, hermitian=True)
        inside, step = best, max(aim * math.sqrt(max(covariance[k, k], 0.0)), 1e-9)
        while True:
            value = inside[k] + way * step
            if way * (value - limit) >= 0.0:
                value = limit
            found = profile(value, self._starts(k, value)[0])
            if excess(found) >= 0.0:
                break
            if value == limit:
                return limit if k == 2 and way < 0.0 else way * math.inf
            inside, step = found, 2.0 * step
        width = _CLOSE * abs(value - best[k])
        return float(optimize.brentq(lambda x: excess(profile(x)), inside[k], value, xtol=width))


def _quantile(freedom: float) -> float:
    """Return Student's t at both ends of the confidence, for so many degrees of freedom."""
    from scipy.special import stdtrit  # late: it takes a tenth of a second to load

    return float(stdtrit(min(freedom, 1e9), 0.5 + 0.5 * _CONFIDENCE))


def _checked(points: Any, amplitude_error: Any) -> tuple[Floats, Floats, Floats | None]:
    """Return frequencies, amplitudes and stated errors by ascending frequency."""
    table = _numbers("points", points)
    if table.ndim != 2 or table.shape[1] != 2 or np.unique(table[:, 0]).size < LEAST_POINTS:
        rule = f"pairs of frequency [Hz] and amplitude [m] at {LEAST_POINTS} or more different frequencies"
        raise SceneError.of("points", shown(points), rule)
    for bad in table[~np.all(np.isfinite(table) & (table > 0.0), axis=1)]:
        raise SceneError.of("points", shown(bad.tolist()), "positive and finite")
    order = np.argsort(table[:, 0], kind="stable")
    frequency, amplitude = table[order].T
    if amplitude_error is None:
        return frequency, amplitude, None
    error = _numbers("amplitude_error", amplitude_error)
    if not np.all((error > 0.0) & (error < 1.0)) or error.shape not in ((), frequency.shape):
        rule = "one relative error, such as 0.02, or one for each point, above 0 and below 1"
        raise SceneError.of("amplitude_error", shown(amplitude_error), rule)
    return frequency, amplitude, np.broadcast_to(error, frequency.shape)[order]


def _numbers(name: str, value: Any) -> Floats:
    try:
        return real_array(value)
    except NotRealError as exc:
        raise SceneError.of(name, exc.value, exc.allowed) from None
