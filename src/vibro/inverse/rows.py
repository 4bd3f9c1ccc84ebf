"""Find the designs of one drive within one regime, rounded so that they hold as printed; make table rows."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, Final

from vibro.drives import Ellipse, Line
from vibro.inverse.ellipses import EllipseOptimiser
from vibro.inverse.exchange import Found
from vibro.inverse.guarantees import guarantee_of
from vibro.inverse.lines import LineOptimiser
from vibro.inverse.rounding import rounded
from vibro.inverse.tolerances import TOLERANCES
from vibro.inverse.windows import window_of
from vibro.quantities import QUANTITIES, SPEED
from vibro.results.designs import Design
from vibro.steady import solve

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from vibro.inverse.exchange import Exchange, Optimum
    from vibro.inverse.questions import Question

__all__ = ["KINDS", "Finder", "find"]

KINDS: Final = ("gentlest", "fastest", "safest")
_DIGITS: Final = (9, 12, 15)  # of printed settings; more where a setting with fewer does not hold
_OPTIMISERS: Final[Mapping[type, Callable[[Question], Exchange]]] = {
    Line: LineOptimiser,
    Ellipse: EllipseOptimiser,
}


@dataclass(frozen=True)
class Finder:
    """Finds the designs of a question, and writes them as rows.

    Attributes
    ----------
    question : Question
        Drive, goal and bands.
    optimiser : Exchange
        Finds optimal settings; it keeps the scenarios that it met.
    found : mapping of str to Found
        The designs by their kind; those that do not exist are left out.
    """

    question: Question
    optimiser: Exchange
    found: Mapping[str, Found]

    @property
    def target(self) -> float:
        """Target speed [m/s]."""
        return self.question.spec.goal.speed

    def set_by(self, kind: str) -> str | None:
        """Return the active constraint of a design; without a design only the fastest has one."""
        found, optimiser = self.found.get(kind), self.optimiser
        if found is None:
            return optimiser.first_cap() if kind == "fastest" else None
        if kind == "gentlest":
            enough = self.target * (1.0 + TOLERANCES.at)
            return optimiser.least_set_by(found) if found.guarantee.speed_min > enough else "speed"
        return optimiser.limit(found, found.margin or 1.0 if kind == "safest" else 1.0)

    def row(self, kind: str) -> Design:
        """Return a design as a row of a table; without a design the row has only what prevents it."""
        found, question = self.found.get(kind), self.question
        row = Design(
            drive=question.drive.name,
            highest_regime=question.highest.label,
            design=kind,
            set_by=self.set_by(kind),
        )
        if found is None:
            return row
        g, goal, length = found.guarantee, question.spec.goal, question.spec.length
        columns = (QUANTITIES[knob].column for knob in question.space.knobs)
        settings: dict[str, Any] = dict(zip(columns, found.printed, strict=True))
        row = replace(row, **settings)
        window, speed = window_of(question, found), g.speed_min
        needed, stroke = _nearest_drive(row.nominal_mm or 0.0, settings["frequency_hz"], speed, goal.speed)
        return replace(
            row,
            acceleration_g=float(question.load(found.setting)),
            speed_min_mm_s=_mm(speed),
            speed_nominal_mm_s=_mm(float(solve(question.nominal_scene(found.setting)).mean_velocity)),
            speed_max_mm_s=_mm(g.speed_max),
            traverse_time_max_s=length / speed if length is not None and speed > 0.0 else None,
            amplitude_low_mm=None if window is None else _mm(window.low),
            amplitude_high_mm=None if window is None else _mm(window.high),
            low_set_by=None if window is None else window.low_set_by,
            high_set_by=None if window is None else window.high_set_by,
            margin=found.margin,
            throw_number_max=question.box(found.setting).throw_number,
            frequency_needed_hz=needed,
            amplitude_needed_mm=stroke,
            proof=g.proof_min,
            coexists=g.coexists,
            excluded=g.excluded,
        )

    def designs(self, calmer: Mapping[str, Found]) -> dict[str, Found]:
        """Find the designs, by their kind."""
        if not self.optimiser.has_more():
            return dict(calmer)
        fastest = self._best("fastest", self._held(self.optimiser.fastest(), None, up=False), calmer)
        if fastest is None:
            return {}
        if fastest.guarantee.speed_min < self.target:
            return {"fastest": fastest}
        gentlest = self._best("gentlest", self._least_acceleration(), calmer, fastest)
        assert gentlest is not None
        if self.question.spec.has_bands:
            best = self._held(self.optimiser.safest(self.target), self.target, up=False)
            safest = self._best("safest", best, calmer, fastest, gentlest)
        else:
            safest = fastest
        assert safest is not None
        # A search with sampled bodies may miss the fastest setting, and another of these may be faster.
        fastest = max(fastest, gentlest, safest, key=lambda design: design.guarantee.speed_min)
        return {"fastest": fastest, "gentlest": gentlest, "safest": safest}

    def _least_acceleration(self) -> Found | None:
        """Return the least-acceleration setting that holds as printed.

        Where the speed just reaches the target and back slip just enters, no rounded setting holds. Then the
        optimum for a slightly higher target is rounded.
        """
        for surplus in self.optimiser.surpluses:
            optimum = self.optimiser.least_acceleration(self.target * (1.0 + surplus))
            if found := self._held(optimum, self.target, up=True):
                return found
        return None

    def _best(
        self, kind: str, new: Found | None, calmer: Mapping[str, Found], *others: Found
    ) -> Found | None:
        """Return the best of some designs, with its margin; None without any."""
        known = [found for found in (new, calmer.get(kind), *others) if found is not None]
        if kind == "safest":
            known = [self._with_margin(found) for found in known]
        merits: dict[str, Callable[[Found], float]] = {
            "fastest": lambda found: found.guarantee.speed_min,
            "gentlest": lambda found: -float(self.question.load(found.setting)),
            "safest": lambda found: found.margin or 0.0,
        }
        return self._with_margin(max(known, key=merits[kind])) if known else None

    def _with_margin(self, found: Found) -> Found:
        """Add the margin of a design: at least 1 where it meets the goal."""
        if found.optimiser is self.optimiser or not self.question.spec.has_bands:
            return found
        margin = self.optimiser.margin(found.setting, self.target)
        if found.guarantee.speed_min >= self.target:  # a margin within a lower regime holds here too
            margin = max(margin or 1.0, found.margin or 1.0, 1.0)
        return replace(found, margin=margin, optimiser=self.optimiser)

    def _held(self, optimum: Optimum | None, target: float | None, *, up: bool) -> Found | None:
        """Round a setting inwards, so that it holds as printed; None if no rounding holds."""
        if optimum is None:
            return None
        least, space = target or 0.0, self.question.space
        for digits in _DIGITS:
            for printed in self.optimiser.roundings(optimum.setting, digits, up=up):
                pairs = zip(space.knobs, printed, strict=True)
                setting = space.setting(**{knob: QUANTITIES[knob].to_si(x) for knob, x in pairs})
                if not self.optimiser.holds(setting, least) or not self.optimiser.is_allowed(setting):
                    continue
                found = Found(setting, printed, guarantee_of(self.question.box(setting)))
                if found.guarantee.speed_min >= least and self.optimiser.keeps_to_regime(found):
                    return found
        return None


def find(question: Question, calmer: Mapping[str, Found]) -> Finder:
    """Find the gentlest, the fastest and the safest setting that hold as they are printed.

    Parameters
    ----------
    question : Question
        Drive, goal and bands.
    calmer : mapping of str to Found
        The designs within a lower regime, which are candidates here too.
    """
    finder = Finder(question, _OPTIMISERS[question.drive.kind](question), {})
    return replace(finder, found=finder.designs(calmer))


def _nearest_drive(
    amplitude: float, frequency: float, speed: float, goal: float
) -> tuple[float | None, float | None]:
    """Return frequency and amplitude of the nearest drive that meets the goal, as rounded [Hz, mm].

    At one load the speed is proportional to 1/f. None if the goal is met, and if the drive conveys nothing.
    """
    if speed >= goal or not speed > 0.0:
        return None, None
    needed = rounded(frequency * speed / goal * (1.0 - TOLERANCES.spare), _DIGITS[0], down=True)
    stroke = rounded(amplitude * (frequency / needed) ** 2, _DIGITS[0], down=True)
    return needed, stroke


def _mm(value: float) -> float | None:
    """Convert a length or a speed to users' units; None if it is not finite."""
    return float(SPEED.from_si(value)) if math.isfinite(value) else None
