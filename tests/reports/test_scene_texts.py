"""What a report says of one scene: numbers against ``solve``, rounding, and what is not known."""

from __future__ import annotations

import pytest
from helpers.reports import scene_at as at

from vibro.reports.scene_texts import (
    kept_rows,
    traverse_text,
)


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
    for changes, end in (({"trough_angle": 4.0, "amplitude": 1.2}, "runs away"), ({}, "slips back")):
        (row,) = (row for row in kept_rows(at(**changes)) if row[0].startswith("static friction"))
        assert row[4].endswith(end)


def test_a_part_that_crosses_within_a_cycle_or_a_period_has_no_time_by_its_mean_speed() -> None:
    one = at(600.0)
    assert traverse_text(one)[0] == f"{600.0 / one.result('mean_velocity'):.6g} s"
    bounces = {"amplitude": 3.0, "frequency": 30.0, "restitution": 0.3}  # every 3 drive cycles, 333 mm/s
    assert traverse_text(at(34.0, **bounces))[0] == "0.102012 s"
    for length, values in ((33.0, bounces), (1.0, {})):
        assert traverse_text(at(length, **values))[0] == "unknown"
