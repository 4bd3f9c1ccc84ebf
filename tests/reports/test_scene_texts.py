"""What a report says of one scene: numbers against ``solve``, rounding, and what is not known."""

from __future__ import annotations

from typing import Any

import pytest
from helpers.cases import each

from vibro.reports.scene_texts import (
    answer_text,
    assumptions,
    kept_rows,
    motion_rows,
    next_text,
    pattern_text,
    transition_texts,
    traverse_text,
)
from vibro.sweeps.grid import Grid
from vibro.sweeps.one_scene import OneScene
from vibro.sweeps.run import sweep_blocks

NUT = {
    "amplitude": 1.0,
    "frequency": 15.0,
    "drive_angle": 20.0,
    "static_friction": 0.74,
    "kinetic_friction": 0.57,
    "trough_angle": 0.0,
    "gravity": 9.81,
    "restitution": 0.0,
}


def at(length: float | None = None, **changes: float) -> OneScene:
    grid = Grid({}, NUT | changes, length)
    (block,) = sweep_blocks(grid)
    return OneScene(block)


@each(
    ("changes", "said"),
    [
        ({}, "The part is conveyed at 16.3 mm/s (0.976 m/min). The part slides forward"),
        ({"trough_angle": 25.0, "amplitude": 2.0}, "conveyed backwards, against the conveying direction, at"),
        ({"amplitude": 0.3}, "The part rests on the trough: nothing is conveyed."),
        ({"trough_angle": -40.0}, "The part runs away forwards, down the trough: it gains speed"),
        ({"static_friction": 0.0, "kinetic_friction": 0.0}, "The speed is unknown: without static friction"),
        (
            {"amplitude": 3.0, "frequency": 45.0, "restitution": 0.62},
            "is conveyed at about 494 mm/s",
        ),
    ],
)
def test_the_answer(changes: dict[str, float], said: str) -> None:
    assert said in answer_text(at(**changes))


def test_what_comes_next() -> None:
    one = at()
    assert next_text(one) == ("at 1.19 × the present amplitude", "the part begins to slip back")
    slides, slips_back, never_rests, hops = transition_texts(one)
    when = "From 0.6852 times the present amplitude (0.685165 mm), or at 12.4162 Hz,"
    assert slides == f"{when} on the part slides forward."
    assert slips_back.startswith("At 1.19 times the present amplitude (1.1903 mm), or at 16.3651 Hz, ")
    assert never_rests.endswith("the part no longer comes to rest: it slides all the time.")
    assert hops.startswith("At 3.229 times the present amplitude (3.22905 mm), or at 26.9543 Hz, ")
    assert next_text(at(amplitude=4.0)) == ("", "")


@pytest.mark.parametrize("amplitude", [0.3, 1.0, 1.3, 4.0])
def test_ends_that_keep_the_regime_keep_it_as_they_are_written(amplitude: float) -> None:
    one = at(amplitude=amplitude)
    for name, _, *ends, below, above, known in kept_rows(one)[1:]:
        field = name.partition(",")[0].replace(" ", "_")
        for text, beyond, out in zip(ends, (below, above), (0.9999, 1.0001), strict=True):
            if text in ("any", "0"):
                continue
            value = float(text.split()[0])
            inside, outside = {field: value}, {field: value * out}
            for changes in (inside, outside):
                if field == "static_friction":
                    changes["kinetic_friction"] = 0.57 / 0.74 * changes[field]
            assert at(**{"amplitude": amplitude, **inside}).regime is one.regime
            if beyond != "–":
                assert at(**{"amplitude": amplitude, **outside}).regime is not one.regime
        assert known == "exact"


def test_an_end_in_a_runaway_is_not_taken_for_back_slip() -> None:
    # both have the code 2
    rows = {row[0]: row for row in kept_rows(at(trough_angle=4.0, amplitude=1.2))}
    assert rows["static friction, kinetic in proportion"][4] == "the part runs away"
    rows = {row[0]: row for row in kept_rows(at())}
    assert rows["static friction, kinetic in proportion"][4] == "the part slips back"


def test_nothing_is_kept_where_nothing_is_steady() -> None:
    assert kept_rows(at(trough_angle=-40.0)) == []


def test_patterns() -> None:
    assert pattern_text("F_B_") == "forward slide, rest, back slide, rest"
    assert pattern_text("H" * 21 + "FB") == "21 flights, forward slide, back slide"
    assert pattern_text("H...") == "irregular flights"
    assert pattern_text("HF" * 5) == "10 phases"
    assert pattern_text("") == ""


def test_assumptions_name_what_was_not_given() -> None:
    values = {name: NUT[name] for name in ("trough_angle", "gravity", "restitution")}
    assert len(assumptions(values, frozenset())) == 3
    assert assumptions(values, frozenset({"trough_angle", "restitution"})) == ["Gravity is 9.81 m/s²."]
    ellipse = {"normal_phase": 0.0, "normal_amplitude": 0.1}
    assert "normal phase 0°" in assumptions(ellipse, frozenset())[0]
    assert assumptions({**ellipse, "normal_amplitude": 0.0}, frozenset()) == []


def test_a_part_that_crosses_within_a_cycle_or_a_period_has_no_time_by_its_mean_speed() -> None:
    one = at(600.0)
    told = f"{600.0 / one.result('mean_velocity'):.6g} s"
    assert traverse_text(one) == (told, "Over the trough, at the mean speed.")
    bounces = {"amplitude": 3.0, "frequency": 30.0, "restitution": 0.3}  # every 3 drive cycles, 333 mm/s
    assert traverse_text(at(34.0, **bounces))[0] == "0.102012 s"
    told, meaning = traverse_text(at(33.0, **bounces))
    assert told == "unknown"
    assert "would be 0.0990115 s, less than one period of the motion, 0.1 s" in meaning
    assert "less than one drive cycle, 0.0666667 s" in traverse_text(at(1.0))[1]
    assert traverse_text(at(600.0, amplitude=0.3))[0].startswith("never: the body rests")


def test_motions_are_listed_as_they_were_given() -> None:
    table: dict[str, list[Any]] = {
        "along_steps": [[0.8, 2.4], [0.2, -9.6]],
        "normal_samples_mm": [0.5] * 7 + [0.1] * 5,
    }
    assert motion_rows(table) == [
        ("steps along the trough", "0.8 of the period at 2.4 m/s², 0.2 of the period at -9.6 m/s²"),
        ("samples normal to the trough", "0.5, 0.5, 0.5, 0.5, 0.5, 0.5, 0.5, 0.1 mm and 4 more"),
    ]
