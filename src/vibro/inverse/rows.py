"""The designs of one drive within one regime, as rows of a table."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from vibro.inverse.caps import hop_load
from vibro.inverse.guarantees import guarantee_of
from vibro.inverse.rounding import rounded
from vibro.quantities import SPEED
from vibro.results.designs import Design
from vibro.scene import Scene
from vibro.steady import solve

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Mapping

    from vibro.inverse.exchange import Exchange, Optimum
    from vibro.results.designs import Guarantee, Interval

__all__ = ["AT", "KINDS", "NEARLY", "Found", "Rows", "nominal_scene"]

KINDS: Final = ("gentlest", "fastest", "safest")
DIGITS: Final = (9, 12, 15)  # of printed settings; more where fewer do not hold
_SPARE: Final = 1e-8  # of the frequency of the nearest drive, for what is lost by rounding its amplitude
NEARLY: Final = 0.98  # of a limit on landings: a setting there is at it
_OF_PARTS: Final = ("trough_angle", "static_friction", "kinetic_friction")
AT: Final = 1e-6  # relative distance to a limit that is at it


@dataclass(frozen=True)
class Found:
    """A setting as it is printed, what it guarantees, and its margin, and by which optimiser."""

    setting: Any
    printed: tuple[float, ...]
    guarantee: Guarantee
    margin: float | None = None
    optimiser: Exchange | None = None


class Rows(ABC):
    """The designs of one drive within one regime.

    Parameters
    ----------
    question : Question or EllipticalQuestion
        What is asked.
    optimiser : Exchange
        What looks for optimal settings.
    calmer : mapping of str to Found
        The designs within a lower regime, which are designs here too.
    """

    #: Of the goal, for a gentlest setting that can be rounded.
    _surpluses: tuple[float, ...]
    #: What the gentlest design is set by that is faster than it need be.
    _gentlest_above: str
    #: Columns of a printed setting.
    _columns: tuple[str, ...]

    def __init__(self, question: Any, optimiser: Exchange, calmer: Mapping[str, Found]) -> None:
        self._question = question
        self._target = question.spec.goal.speed
        self._optimiser = optimiser
        #: The designs by their kind, without those that there are not.
        self.found: dict[str, Found] = {}
        if not self._has_more():
            self.found.update(calmer)
            return
        self._keep("fastest", [self._settled(optimiser.fastest(), None, up=False), calmer.get("fastest")])
        fastest = self.found.get("fastest")
        if fastest is None or fastest.guarantee.speed_min < self._target:
            return
        self._keep("gentlest", [self._gentlest(), calmer.get("gentlest"), fastest])
        safest: list[Found | None] = [fastest]
        if question.spec.has_bands:
            best = self._settled(optimiser.safest(self._target), self._target, up=False)
            safest = [best, calmer.get("safest"), *self.found.values()]
        self._keep("safest", safest)

    @abstractmethod
    def _roundings(self, setting: Any, digits: int, *, up: bool) -> Iterable[tuple[tuple[float, ...], Any]]:
        """Return settings in the units outside with so many digits, from the nearest one inwards."""

    @abstractmethod
    def _is_allowed(self, setting: Any) -> bool:
        """Tell whether a drive may be set so."""

    @abstractmethod
    def _limit(self, found: Found, scale: float) -> str:
        """Tell what keeps a setting from being better with bands of a scale."""

    @abstractmethod
    def _first_cap(self) -> str:
        """Tell what ends the load before any speed is guaranteed."""

    @abstractmethod
    def _window(self, found: Found) -> Interval | None:
        """Return the amplitudes that keep the guarantee and hold the design."""

    def _gentlest(self) -> Found | None:
        """Return the gentlest setting that holds as it is printed.

        It may stand where the speed just reaches the goal and back slip just enters: no rounding holds there,
        but one beside a setting for a little more speed does.
        """
        for surplus in self._surpluses:
            optimum = self._optimiser.gentlest(self._target * (1.0 + surplus))
            if found := self._settled(optimum, self._target, up=True):
                return found
        return None

    def _keep(self, kind: str, candidates: Iterable[Found | None]) -> None:
        """Keep the best of candidates, with its margin."""
        known = [found for found in candidates if found is not None]
        if kind == "safest":
            known = [self._with_margin(found) for found in known]
        merits: dict[str, Callable[[Found], float]] = {
            "fastest": lambda found: found.guarantee.speed_min,
            "gentlest": lambda found: -float(self._question.load(found.setting)),
            "safest": lambda found: found.margin or 0.0,
        }
        if known:
            self.found[kind] = self._with_margin(max(known, key=merits[kind]))

    def _with_margin(self, found: Found) -> Found:
        """Add the margin of a design: at least 1 where it meets the goal."""
        if found.optimiser is self._optimiser or not self._question.spec.has_bands:
            return found
        margin = self._optimiser.margin(found.setting, self._target)
        if found.guarantee.speed_min >= self._target:  # what holds in a lower regime holds here
            margin = max(margin or 1.0, found.margin or 1.0, 1.0)
        return replace(found, margin=margin, optimiser=self._optimiser)

    def _settled(self, optimum: Optimum | None, target: float | None, *, up: bool) -> Found | None:
        """Round a setting inwards, so that it holds as it is printed."""
        if optimum is None:
            return None
        for digits in DIGITS:
            for printed, setting in self._roundings(optimum.setting, digits, up=up):
                if not self._optimiser.holds(setting, target or 0.0) or not self._is_allowed(setting):
                    continue
                found = Found(setting, printed, guarantee_of(self._question.boxes(setting)))
                if found.guarantee.speed_min >= (target or 0.0) and self._keeps_to_regime(found):
                    return found
        return None

    def _has_more(self) -> bool:
        """Whether some setting, or a wider band, is allowed here that a lower regime does not allow."""
        return True

    def _keeps_to_regime(self, found: Found) -> bool:
        """Tell whether every body of a setting keeps to the regime."""
        return True

    def _set_by(self, kind: str) -> str | None:
        """Tell what keeps a design from being better; None where the goal is not met, but for the fastest."""
        found = self.found.get(kind)
        if found is None:
            return self._first_cap() if kind == "fastest" else None
        if kind == "gentlest":
            return self._gentlest_above if found.guarantee.speed_min > self._target * (1.0 + AT) else "speed"
        return self._limit(found, found.margin or 1.0 if kind == "safest" else 1.0)

    def row(self, kind: str) -> Design:
        """Return a design as a row of a table; with what ends it alone where there is none."""
        found = self.found.get(kind)
        question, goal = self._question, self._question.spec.goal
        row = Design(
            drive=question.drive.name,
            highest_regime=question.highest.label,
            design=kind,
            set_by=self._set_by(kind),
        )
        if found is None:
            return row
        g = found.guarantee
        settings: dict[str, Any] = dict(zip(self._columns, found.printed, strict=True))
        row = replace(row, **settings)
        amplitude, frequency = row.nominal_mm or 0.0, settings["frequency_hz"]
        window = self._window(found)
        length, speed = question.spec.length, g.speed_min
        met = speed >= goal.speed
        # the nearest drive, rounded so that it does
        needed = rounded(frequency * speed / goal.speed * (1.0 - _SPARE), DIGITS[0], down=True)
        stroke = rounded(amplitude * (frequency / needed) ** 2, DIGITS[0], down=True)
        box = question.boxes(found.setting)
        return replace(
            row,
            acceleration_g=float(question.load(found.setting)),
            speed_min_mm_s=_mm(speed),
            speed_nominal_mm_s=_mm(float(solve(nominal_scene(question, found.setting)).mean_velocity)),
            speed_max_mm_s=_mm(g.speed_max),
            traverse_time_max_s=length / speed if length is not None else None,
            amplitude_low_mm=None if window is None else _mm(window.low),
            amplitude_high_mm=None if window is None else _mm(window.high),
            low_set_by=None if window is None else window.low_set_by,
            high_set_by=None if window is None else window.high_set_by,
            margin=found.margin,
            throw_number_max=float(box.load[1] / hop_load(box)),
            frequency_needed_hz=None if met else needed,
            amplitude_needed_mm=None if met else stroke,
            proof=g.proof_min,
            coexists=g.coexists,
            excluded=g.excluded,
        )


def nominal_scene(question: Any, setting: Any) -> Scene:
    """Return the scene of a setting in the middle of all bands."""
    box = question.boxes(setting, 0.0)
    point = box.points(np.full((len(box.axes), 1), 0.5))
    parts = {name: float(getattr(point, name)[0]) for name in _OF_PARTS}
    return Scene(**setting._asdict(), **parts, **box.constants)


def _mm(value: float) -> float | None:
    """Convert a length or a speed to the unit outside; None where there is no number."""
    return float(SPEED.from_si(value)) if math.isfinite(value) else None
