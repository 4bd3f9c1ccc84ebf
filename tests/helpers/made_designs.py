"""Answers of ``vibro design`` that were written by hand, in place of a search."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, NamedTuple

from helpers.questions import answered

from vibro.designs import design as designs_module
from vibro.results.designs import Design, DesignResult

if TYPE_CHECKING:
    from collections.abc import Callable

    import pytest

    from vibro.designs.questions import Spec


QUESTION: Final = (Path(__file__).parents[1] / "messages/files/question.toml").read_text(encoding="utf-8")


class Asked(NamedTuple):
    """A question, as the search for its answer takes it."""

    spec: Spec
    digits: int
    goal_only: bool


SAFEST = Design(
    drive="motor",
    highest_regime="forward-slip",
    design="safest",
    amplitude_mm=2.80763335,
    frequency_hz=10.0,
    drive_angle_deg=45.0,
    acceleration_g=1.129883,
    speed_min_mm_s=45.29399999,
    speed_proved_mm_s=45.29399999,
    speed_found_mm_s=46.5,
    speed_nominal_mm_s=48.45,
    speed_max_mm_s=51.89570001,
    traverse_time_max_s=13.2468,
    amplitude_low_mm=2.46843701,
    amplitude_high_mm=3.0,
    low_set_by="speed",
    high_set_by="limit",
    margin=7.39704,
    throw_number_max=0.798944,
    set_by="back slip",
    proof="corners",
    coexists=False,
    excluded=0,
)
HOPPING = replace(
    SAFEST, speed_min_mm_s=228.0, speed_found_mm_s=228.0, set_by="limit", margin=12.0, proof="sampled",
    coexists=True, excluded=7, samples=2000, speed_proved_mm_s=None,
)  # fmt: skip
SLOW = replace(
    SAFEST, speed_min_mm_s=4.649, speed_found_mm_s=4.65, margin=None, frequency_needed_hz=2.9,
    amplitude_needed_mm=30.4, amplitude_low_mm=None, amplitude_high_mm=None,
    low_set_by=None, high_set_by=None,
)  # fmt: skip
ELLIPTICAL = replace(
    SAFEST, amplitude_mm=None, drive_angle_deg=None, along_amplitude_mm=0.9, normal_amplitude_mm=0.3,
    normal_phase_deg=-58.5, frequency_hz=25.0, amplitude_low_mm=0.7, amplitude_high_mm=1.0,
)  # fmt: skip
IN_STROKE = replace(
    SAFEST, margin=None, amplitude_mm=None, amplitude_low_mm=None, amplitude_high_mm=None, stroke_mm=5.615,
    stroke_low_mm=4.937, stroke_high_mm=6.0,
)  # fmt: skip


def rows(drive: str, regime: str, **known: Design) -> list[Design]:
    """Return the three designs of a drive and a regime; those that are not known have no numbers."""
    found = []
    for kind in ("gentlest", "fastest", "safest"):
        row: dict[str, Any] = {"drive": drive, "highest_regime": regime, "design": kind}
        found.append(replace(known[kind], **row) if kind in known else Design(**row))
    return found


def of_motor(met: bool = True, **known: Design) -> DesignResult:
    """Return an answer about one drive and the regime of the goal."""
    return answered(met, *rows("motor", "forward-slip", **known))


def answer(*, met: bool) -> DesignResult:
    """Return an answer as the optimisers give them: the motor meets the goal, or no drive does."""
    all_three = {"gentlest": SAFEST, "fastest": SAFEST, "safest": SAFEST}
    found = [
        *rows("motor", "forward-slip", **(all_three if met else {"fastest": SLOW})),
        *rows("magnet", "forward-slip"),
        *rows(
            "motor",
            "back-slip",
            fastest=replace(
                SLOW, speed_min_mm_s=6.22, speed_found_mm_s=6.22, speed_proved_mm_s=None, proof="searched"
            ),
        ),
        *rows("motor", "hopping", gentlest=HOPPING, fastest=HOPPING, safest=HOPPING),
        *rows("magnet", "back-slip"),
        *rows("magnet", "hopping"),
    ]
    return answered(met, *found)


def found(patch: pytest.MonkeyPatch, result: DesignResult) -> list[Asked]:
    """Have every question answered so; return the list of those that are asked."""
    asked: list[Asked] = []

    def find(
        spec: Spec, tell: Callable[[int, int, str], None], *, digits: int, goal_only: bool
    ) -> DesignResult:
        asked.append(Asked(spec, digits, goal_only))
        for done in (0, 4, 18):
            tell(done, 18, "motor: gentlest, forward-slip at most")
        kept = [d for d in result.designs if not goal_only or d.highest_regime == "forward-slip"]
        return answered(result.met, *kept)

    patch.setattr(designs_module, "find_designs", find)
    return asked
