"""Find the designs of a machine whose amplitude depends on what lies in its trough.

What a filling weighs depends on the motion, and so does the interval of amplitudes at one setting. A design
is found for an interval that is assumed, and holds where that covers the amplitudes that are met at its
setting. If it does not, the interval of those is assumed, and the design is sought again.
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import TYPE_CHECKING, Final, NamedTuple

from vibro.core.codes import Regime
from vibro.inverse.machine_drives import amplitudes_met, covering
from vibro.inverse.rounding import DIGITS
from vibro.inverse.rows import KINDS, SEARCHED, Finder, Rounded, best_of, find, finder_of

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from vibro.inverse.machine_drives import Met
    from vibro.inverse.questions import Question
    from vibro.inverse.specs import Span

__all__ = ["find_covered"]

_ROUNDS: Final = 8
_WIDE: Final = 1.1  # [1] of the width that is needed, above which a narrower interval is tried
_BELOW: Final = 0.999  # of the setting at which masses strike each other, or bodies begin to hop
_STEP: Final = 1.02  # by which settings are lowered at least where bodies slip back or hop
# What ends the settings of a design that a second harmonic brings beyond a regime.
_BEYOND: Final = {Regime.FORWARD_SLIP: "back slip", Regime.BACK_SLIP: "hop"}
# Room at both ends beyond samples: a share of the interval's width [1], and of its upper end [1].
_ROOM: Final = (0.02, 1e-3)


class _Held(NamedTuple):
    """A design that holds with the filling, and the finder of its interval."""

    finder: Finder
    found: Rounded


def find_covered(
    question: Question,
    calmer: Mapping[str, Finder],
    digits: int = DIGITS,
    tell: Callable[[str], None] = lambda _: None,
) -> dict[str, Finder]:
    """Find the designs of a drive, of a filled machine those whose amplitudes are covered.

    Parameters
    ----------
    question : Question
        Drive, goal and bands.
    calmer : mapping of str to Finder
        Designs within a lower regime, which are candidates here too; empty without any.
    digits : int, optional
        Of printed settings.
    tell : callable, optional
        ``tell(kind)`` says which design is searched.

    Returns
    -------
    dict of str to Finder
        The finder of every kind of design, which has it, if it exists. Of a filled machine each has its own
        drive, which covers the amplitudes at that design.
    """
    machine = question.drive.machine
    if machine is None or not machine.is_filled:
        found = calmer["fastest"].found if calmer else {}
        return dict.fromkeys(KINDS, find(question, found, digits, tell))
    if calmer:
        same = {kind: replace(question, drive=one.question.drive) for kind, one in calmer.items()}
        new = {kind: finder_of(one, digits) for kind, one in same.items()}
        if not any(one.optimiser.has_more() for one in new.values()):
            return {
                kind: replace(one, found=calmer[kind].found, refused=calmer[kind].refused)
                for kind, one in new.items()
            }
    return _Settled(question, calmer, digits, tell).finders()


class _Settled:
    """Finds each design for the interval of amplitudes at its own setting."""

    def __init__(
        self, question: Question, calmer: Mapping[str, Finder], digits: int, tell: Callable[[str], None]
    ) -> None:
        self._question, self._calmer, self._digits, self._tell = question, calmer, digits, tell
        self._refused: set[str] = set()

    def finders(self) -> dict[str, Finder]:
        """Return the finder of every kind of design."""
        held: dict[str, _Held] = {}
        start = self._question
        for kind in SEARCHED:
            if "fastest" in held:
                start = held["fastest"].finder.question
            if (one := self._settle(kind, start)) is not None:
                held[kind] = one
        for kind, finder in self._calmer.items():
            if kind in finder.found:
                question = replace(self._question, drive=finder.question.drive)
                held[f"{kind} before"] = _Held(finder_of(question, self._digits), finder.found[kind])
        return {kind: self._best(kind, list(held.values())) for kind in KINDS}

    def _best(self, kind: str, held: list[_Held]) -> Finder:
        """Return the finder with the best design of a kind; only the fastest may miss the goal."""
        target = self._question.spec.goal.speed
        able = [one for one in held if kind == "fastest" or one.found.guarantee.speed_min >= target]
        if not able:
            return replace(finder_of(self._question, self._digits), refused=frozenset(self._refused))
        best = max(able, key=lambda one: best_of(kind, one.finder.question, one.found))
        return replace(best.finder, found={kind: best.found}, refused=frozenset())

    def _settle(self, kind: str, question: Question) -> _Held | None:
        """Find a design whose interval holds the amplitudes at its setting, and little more."""
        best: _Held | None = None
        narrow: Span | None = None  # does not cover the amplitudes of its design
        wide: Span | None = None  # covers it, or leaves no design
        for _ in range(_ROUNDS):
            finder, machine = find(question, {}, self._digits, self._tell, until=kind), question.drive.machine
            found = finder.found.get(kind)
            assert machine is not None
            covered, most, ended_by = machine.covered, math.inf, "gap"
            if found is None:
                if narrow is None:
                    return best
                wide, covered = covered, _middle(covered, narrow)
            else:
                met = amplitudes_met(question, found.setting)
                most = _most_setting(question, found, met)
                if met.regime > question.highest:
                    ended_by = _BEYOND[question.highest]
                if most <= machine.settings[0] or not (met.low > 0.0 or met.strikes):
                    break
                needed = _hull(met) if met.low > 0.0 else covered
                if covered[0] <= met.low <= met.high <= covered[1] and math.isinf(most):
                    if met.speed < min(found.guarantee.speed_min, question.spec.goal.speed):
                        break
                    one = _Held(finder, replace(found, met=met))
                    best = max(filter(None, (best, one)), key=lambda x: best_of(kind, question, x.found))
                    if covered[1] - covered[0] <= _WIDE * (needed[1] - needed[0]):
                        return best
                    wide, covered = covered, _middle(covered, needed)
                else:
                    narrow, covered = covered, needed if wide is None else _middle(covered, wide)
            question = replace(question, drive=covering(question.drive, covered, most, ended_by))
        if best is None:
            self._refused.add(kind)
        return best


def _most_setting(question: Question, found: Rounded, met: Met) -> float:
    """Return the setting to try where that of a design is too large, about; inf where it is not [1].

    It is where masses strike each other, or where the second harmonic, of which the search knows nothing,
    brings bodies into a regime that the goal forbids.
    """
    machine, least = question.drive.machine, math.inf
    assert machine is not None
    if met.strikes:
        least = _BELOW * met.most_setting
    if met.regime > question.highest:
        setting = float(question.space.amplitude(found.setting)) / machine.amplitude
        least = min(least, _BELOW * setting / max(met.throw_number, _STEP))
    return least


def _hull(met: Met) -> Span:
    """Return an interval around the amplitudes of a design, with some room at its ends."""
    room = _ROOM[0] * (met.high - met.low) + _ROOM[1] * met.high
    return max(met.low - room, (1.0 - _ROOM[0]) * met.low), met.high + room


def _middle(one: Span, other: Span) -> Span:
    return 0.5 * (one[0] + other[0]), 0.5 * (one[1] + other[1])
