"""The designs of an elliptical drive within one regime."""

from __future__ import annotations

import math
from dataclasses import replace
from itertools import product
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from vibro.core.codes import Regime
from vibro.inverse.ellipses import critical, extreme_ratio
from vibro.inverse.elliptical_optima import EllipticalOptimiser
from vibro.inverse.elliptical_questions import EllipticalQuestion, EllipticalSetting
from vibro.inverse.exchange import MOST_MARGIN, Optimum
from vibro.inverse.extremes import least_of
from vibro.inverse.rounding import within
from vibro.inverse.rows import AT, NEARLY, Rows
from vibro.inverse.specs import Goal
from vibro.quantities import QUANTITIES
from vibro.results.designs import Interval

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping

    from numpy.typing import NDArray

    from vibro.inverse.rows import Found
    from vibro.results.designs import Design

    Floats = NDArray[np.float64]

__all__ = ["EllipticalRows", "ellipse_of"]

_ROUNDING: Final = 1e-12  # relative, of conversions between units
_NUDGES: Final = 3  # steps of the last digit that amplitudes may be moved inwards
_FACTORS: Final = 129  # amplitudes looked at first of a window
_LEAST: Final = 0.05  # of the design's amplitudes, from where on a window is looked for
_STEPS: Final = 40  # of bisection
_CHECKS: Final = 5  # amplitudes of a window whose boxes are searched
_EXCHANGES: Final = 4
_JUMP: Final = 1e-4  # of the speed, that is a jump over a relative distance of AT


class EllipticalRows(Rows):
    """The designs of an elliptical drive within one regime; the parameters are those of ``Rows``."""

    _surpluses = (0.0, 1e-4, 1e-2)  # each asks for a search
    _gentlest_above = "limit"
    _columns = ("along_amplitude_mm", "normal_amplitude_mm", "normal_phase_deg", "frequency_hz")
    _question: EllipticalQuestion
    _optimiser: EllipticalOptimiser

    def __init__(self, question: EllipticalQuestion, calmer: Mapping[str, Found]) -> None:
        super().__init__(question, EllipticalOptimiser(question), calmer)

    def _has_more(self) -> bool:
        """Whether some setting, or a wider band, is allowed here that a lower regime does not allow."""
        question, drive = self._question, self._question.drive
        contact = replace(question, highest=Regime.BACK_SLIP)
        fastest = np.array(max(high for _, high in drive.frequency))
        return not question.flies or drive.normal_amplitude[1] > float(
            contact.most_throw(fastest, MOST_MARGIN)
        )

    def _roundings(
        self, setting: Any, digits: int, *, up: bool
    ) -> Iterator[tuple[tuple[float, ...], EllipticalSetting]]:
        """Return settings in the units outside with so many digits, from the nearest one inwards."""
        drive = self._question.drive
        f = setting.frequency
        frequency = min(drive.frequency, key=lambda span: max(span[0] - f, f - span[1]))
        spans = (drive.along_amplitude, drive.normal_amplitude, drive.normal_phase, frequency)
        values = [float(QUANTITIES[name].from_si(x)) for name, x in setting._asdict().items()]
        step = 1 if up else -1
        for along, normal in product(range(-1, _NUDGES), repeat=2):
            moved = [_moved(x, digits, step * n) for x, n in zip(values, (along, normal), strict=False)]
            # a phase has its digits after the point: 0 is one like all others
            rounded = [*moved, round(values[2], digits - 3), values[3]]
            printed = tuple(
                within(x, name, span, digits)
                for x, name, span in zip(rounded, EllipticalSetting._fields, spans, strict=True)
            )
            yield printed, _in_si(printed)

    def _is_allowed(self, setting: Any) -> bool:
        """Tell whether a drive may be set so."""
        load = float(self._question.load(setting))
        return load <= self._question.drive.acceleration * (1.0 + _ROUNDING)

    def _keeps_to_regime(self, found: Found) -> bool:
        """Tell whether every body of a setting keeps to the regime, as far as searches find."""
        if any(regime > self._question.highest for regime in found.guarantee.regimes):
            return False
        if self._question.highest is not Regime.FORWARD_SLIP:
            return True
        return (
            extreme_ratio(self._question.boxes(found.setting), critical("back_slip"), largest=True)[0] <= 1.0
        )

    def _limit(self, found: Found, scale: float) -> str:
        """Tell what keeps a setting from being better with bands of a scale."""
        question, setting, drive = self._question, found.setting, self._question.drive
        if question.landings.scaled(NEARLY).worst(question.boxes(setting, scale)).size:
            return "limit"
        frequency, normal = np.array(setting.frequency), setting.normal_amplitude
        if not question.flies and normal >= float(question.most_throw(frequency, scale)) * (1.0 - AT):
            return "hop"
        here, beyond = self._speeds(setting, np.array([1.0, 1.0 + AT]), scale)
        if math.isinf(beyond):
            return self._forbids(_scaled(setting, 1.0 + AT), scale)
        if beyond < here * (1.0 - _JUMP):
            return "back slip"
        at_most = (
            setting.along_amplitude >= drive.along_amplitude[1] * (1.0 - AT),
            normal >= drive.normal_amplitude[1] * (1.0 - AT),
            float(question.load(setting)) >= drive.acceleration * (1.0 - AT),
        )
        return "limit" if any(at_most) else "speed"

    def _first_cap(self) -> str:
        """Tell what ends the load before any speed is guaranteed."""
        question = self._question
        lowest = np.array([min(low for low, _ in question.drive.frequency)])
        if question.drive.normal_amplitude[0] > float(question.most_throw(lowest, 1.0)[0]):
            return "hop"
        if question.highest is Regime.FORWARD_SLIP:
            slips = EllipticalQuestion(question.spec, question.drive, Regime.BACK_SLIP)
            if EllipticalOptimiser(slips).fastest():
                return "back slip"
        return "limit"

    def _window(self, found: Found) -> Interval | None:
        """Return the amplitudes along the trough, the normal ones in proportion, that keep the guarantee.

        The bodies looked at tell where it ends. Boxes of some amplitudes between both ends are searched for
        slower ones, and it is looked for again with these.
        """
        if found.guarantee.speed_min < self._target:
            return None
        setting = found.setting
        x = getattr(setting, setting.leading)
        low, high, by_low, by_high = 1.0, 1.0, "speed", "speed"
        for _ in range(_EXCHANGES):
            low, high, by_low, by_high = self._factors(setting)
            tried = [_scaled(setting, float(f)) for f in np.geomspace(low, high, _CHECKS)]
            found_slower = [self._optimiser.finds_slower(Optimum(s, self._target)) for s in tried]
            if not any(found_slower):
                return Interval(low * x, high * x, by_low, by_high)
        return Interval(x, x, "speed", "speed")

    def _factors(self, setting: EllipticalSetting) -> tuple[float, float, str, str]:
        """Factors on both amplitudes between which no body looked at misses the goal, and what ends them."""
        question, drive = self._question, self._question.drive
        x, y, _, frequency = setting
        spans = [(drive.along_amplitude, x), (drive.normal_amplitude, y)]
        caps = [min(span[1] / size for span, size in spans if size > 0.0)]
        caps.append(drive.acceleration / float(question.load(setting)))
        hop = float(question.most_throw(np.array(frequency), 1.0)) / y if y > 0.0 else math.inf
        least = max(_LEAST, *(span[0] / size for span, size in spans if size > 0.0))
        bottom, top = min(1.0, least), max(1.0, min(*caps, hop))
        factors = np.union1d(np.geomspace(bottom, top, _FACTORS), [1.0])
        holds = self._speeds(setting, factors, 1.0) >= self._target
        here = int(np.searchsorted(factors, 1.0))
        low, by_low = self._end(setting, factors[: here + 1][::-1], holds[: here + 1][::-1], "limit")
        at_top = "hop" if hop <= min(caps) and not question.flies else "limit"
        high, by_high = self._end(setting, factors[here:], holds[here:], at_top)
        return low, high, by_low, by_high

    def _end(
        self, setting: EllipticalSetting, factors: Floats, holds: NDArray[np.bool_], last: str
    ) -> tuple[float, str]:
        """Follow factors to the last one before the goal is missed, and tell what happens there."""
        if holds.all():
            return float(factors[-1]), last
        first = max(int(np.argmin(holds)), 1)
        inside, outside = float(factors[first - 1]), float(factors[first])
        for _ in range(_STEPS):
            middle = 0.5 * (inside + outside)
            reaches = self._speeds(setting, np.array([middle]), 1.0)[0] >= self._target
            inside, outside = (middle, outside) if reaches else (inside, middle)
        here, there = self._speeds(setting, np.array([inside, outside]), 1.0)
        if math.isinf(there):
            return inside, self._forbids(_scaled(setting, outside), 1.0)
        if there < here * (1.0 - _JUMP):
            return inside, "onset" if there == 0.0 else "back slip"
        return inside, "speed"

    def _forbids(self, setting: EllipticalSetting, scale: float) -> str:
        """Tell what keeps a setting from being allowed: what it may do without."""
        spec = self._question.spec
        anywhere = replace(spec, stand_ratio=math.inf)
        for name, question in {
            "tip": replace(self._question, spec=anywhere),
            "limit": replace(self._question, spec=replace(anywhere, goal=Goal(spec.goal.speed))),
            "back slip": replace(self._question, spec=anywhere, highest=Regime.BACK_SLIP),
        }.items():
            one = EllipticalSetting(*(np.array([x]) for x in setting))
            if np.isfinite(least_of(question.speeds(one, self._optimiser.bodies, scale))[0]):
                return name
        return "hop"

    def _speeds(self, setting: EllipticalSetting, factors: Floats, scale: float) -> Floats:
        """Least speeds of the bodies looked at, where both amplitudes are multiplied."""
        many = _scaled(setting, factors)
        full = EllipticalSetting(*(np.broadcast_to(v, factors.shape) for v in many))
        return self._optimiser.least(full, scale)


def ellipse_of(design: Design) -> EllipticalSetting:
    """Return the setting of a design, in SI units and radians."""
    return _in_si(tuple(getattr(design, name) for name in EllipticalRows._columns))


def _scaled(setting: EllipticalSetting, factor: Any) -> EllipticalSetting:
    x, y, phase, frequency = setting
    return EllipticalSetting(factor * x, factor * y, phase, frequency)


def _in_si(printed: tuple[float, ...]) -> EllipticalSetting:
    """Convert a setting from the units outside."""
    pairs = zip(EllipticalSetting._fields, printed, strict=True)
    return EllipticalSetting(*(QUANTITIES[name].to_si(value) for name, value in pairs))


def _moved(value: float, digits: int, steps: int) -> float:
    """Move a value by some steps of its last digit, to the next whole one at least."""
    if value == 0.0:
        return value
    unit = 10.0 ** (math.floor(math.log10(value)) - digits + 1)
    count = math.ceil(value / unit) if steps > 0 else math.floor(value / unit)
    return (count + steps) * unit
