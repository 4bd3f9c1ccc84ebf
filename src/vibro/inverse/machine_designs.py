"""Find the designs of a machine whose amplitude depends on what lies in its trough.

What a filling weighs depends on the motion, and so does the interval of amplitudes at one setting. A design
is found for an interval that is assumed, and holds where that covers the amplitudes that are met at its
setting. If it does not, the interval of those is assumed, and the design is sought again.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Final

from vibro.inverse.machine_drives import amplitudes_met, covering
from vibro.inverse.questions import Question
from vibro.inverse.rounding import DIGITS
from vibro.inverse.rows import Finder, find, finder_of

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable

    from vibro.inverse.machine_drives import Met
    from vibro.inverse.specs import Span

__all__ = ["find_covered"]

_ROUNDS: Final = 8
_FREE: Final = 3  # rounds after which an interval grows only, so that rounds come to an end
# Room at both ends beyond samples: a share of the interval's width [1], and of its upper end [1].
_ROOM: Final = (0.05, 1e-3)


def find_covered(
    question: Question,
    calmer: Finder | None,
    digits: int = DIGITS,
    tell: Callable[[str], None] = lambda _: None,
) -> Finder:
    """Find the designs of a drive, of a filled machine those whose amplitudes are covered.

    Parameters
    ----------
    question : Question
        Drive, goal and bands.
    calmer : Finder or None
        Designs within a lower regime, which are candidates here too.
    digits : int, optional
        Of printed settings.
    tell : callable, optional
        ``tell(kind)`` says which design is searched.
    """
    machine = question.drive.machine
    if machine is None or not machine.is_filled:
        return find(question, calmer.found if calmer else {}, digits, tell)
    known = {}
    if calmer is not None:
        question, known = replace(question, drive=calmer.question.drive), dict(calmer.found)
        if not finder_of(question, digits).optimiser.has_more():
            return replace(finder_of(question, digits), found=known, refused=calmer.refused)
    for turn in range(_ROUNDS):
        finder = find(question, known, digits, tell)
        assert finder.question.drive.machine is not None
        covered = finder.question.drive.machine.covered
        met = {kind: amplitudes_met(question, found.setting) for kind, found in finder.found.items()}
        seen = [one for one in met.values() if one.low > 0.0]  # not NaN
        if all(_covers(covered, one) for one in seen):
            break
        if turn < _ROUNDS - 1:
            if turn >= _FREE:
                seen.append(seen[0]._replace(low=covered[0], high=covered[1]))
            question, known = replace(question, drive=covering(question.drive, _hull(seen))), {}
    held = {kind: found for kind, found in finder.found.items() if _covers(covered, met[kind])}
    return replace(
        finder,
        found={k: replace(found, operating_points=met[k].number) for k, found in held.items()},
        refused=frozenset(finder.found) - frozenset(held),
    )


def _covers(covered: Span, met: Met) -> bool:
    """Whether all amplitudes are known and within an interval."""
    return bool(covered[0] <= met.low <= met.high <= covered[1])


def _hull(seen: Iterable[Met]) -> Span:
    """Return an interval around those of all designs, with some room at its ends."""
    low, high = min(one.low for one in seen), max(one.high for one in seen)
    room = _ROOM[0] * (high - low) + _ROOM[1] * high
    return max(low - room, (1.0 - _ROOM[0]) * low), high + room
