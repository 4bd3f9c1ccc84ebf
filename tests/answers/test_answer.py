"""Answers: four renderers of the same facts, tables and notes."""

from __future__ import annotations

import csv
import io
import json
import math

import pytest
from helpers.read_pages import ReadPage

from vibro.answers.answer import Answer, Fact, Table, bound, brief, label_of, shown, uncertain

ANSWER = Answer(
    [
        Fact("speed", 16.26345, "mm/s", note="mean"),
        Fact("impact", math.nan, "mm/s"),
        Fact("pattern", "F_", is_rare=True),
    ],
    [
        Table("next", [("begins", ""), ("amplitude", "mm")], [("hopping", 3.22905), ("back slip", math.nan)]),
        Table("phases", [("phase", ""), ("end", "ms")], [("rest", 74.6)], "One cycle", is_rare=True),
    ],
    ["A note."],
    {"mean_velocity_mm_s": 16.26345},
    "nut",
)  # fmt: skip


def test_the_text_is_short_or_whole() -> None:
    short = [
        "speed   16.26 mm/s (mean)",
        "impact  unknown",
        "begins     amplitude [mm]",
        "hopping             3.229",
    ]
    lines = ANSWER.text().splitlines()
    assert lines[:2] == short[:2]
    assert lines[2] == ""
    assert [line.split() for line in lines[3:5]] == [line.split() for line in short[2:]]
    assert lines[5].split()[-1] == "-"
    assert lines[-1] == "A note."
    assert "pattern" not in ANSWER.text()
    assert all(text in ANSWER.text(every=True) for text in ("pattern  F_", "One cycle", "74.6"))


def test_a_wide_table_has_its_units_below_and_no_empty_column() -> None:
    columns = [("name", ""), ("n" * 60, "mm"), ("empty", "Hz"), ("w" * 60, "g")]
    heads, units, row = Table("wide", columns, [("one", 1.0, None, 2.0)]).text.splitlines()
    assert (heads.split()[0], units.split(), row.split()) == ("name", ["[mm]", "[g]"], ["one", "1", "2"])


def test_json_and_csv_have_all_digits_and_no_number_that_is_none() -> None:
    told = json.loads(ANSWER.json())
    assert told["mean_velocity_mm_s"] == 16.26345
    assert told["next"] == [
        {"begins": "hopping", "amplitude_mm": 3.22905}, {"begins": "back slip", "amplitude_mm": None},
    ]  # fmt: skip
    assert told["notes"] == ["A note."]
    rows = list(csv.reader(io.StringIO(ANSWER.csv("next"))))
    assert rows == [["begins", "amplitude_mm"], ["hopping", "3.22905"], ["back slip", ""]]


def test_the_page_has_the_figures_of_the_text() -> None:
    page = ReadPage(ANSWER.html(command="vibro solve nut.toml"))
    assert page.row("speed") == ["16.26 mm/s (mean)"]
    assert page.row("hopping") == ["3.229"]
    assert page.row("rest")[0].startswith("74.6")
    assert "vibro solve nut.toml" in page.text


@pytest.mark.parametrize(
    ("value", "error", "text"),
    [
        (16.26345, 0.0, "16.26"),
        (16.26345, 0.0123, "16.263 ± 0.012"),
        (1234.5, 37.0, "1234 ± 37"),
        (30.4645041, 2.1e-5, "30.464504 ± 0.000021"),
        (1.23456789, 1e-10, "1.235"),
        (4.6e-16, 5.7e-16, "4.6e-16"),
        (-0.0, 0.0, "0"),
    ],
)
def test_a_number_with_its_error(value: float, error: float, text: str) -> None:
    assert uncertain(value, error) == text


def test_digits_of_numbers() -> None:
    assert [brief(x) for x in (0.31, 27.0, 1.0, 1e-7, 0.0)] == ["0.310", "27.0", "1.00", "1e-07", "0"]
    assert [brief(27.0, "Hz"), brief("hopping"), brief(None, "Hz")] == ["27.0 Hz", "hopping", ""]
    assert shown(-0.0) == "0"
    assert label_of("energy_per_cycle_j", "J") == "energy per cycle"


@pytest.mark.parametrize("value", [0.1234564, 0.1234567, 3.0, 123456.78, 1e-9 / 3.0])
def test_bounds_hold_as_they_are_written(value: float) -> None:
    low, high = float(bound(value, upper=False)), float(bound(value, upper=True))
    assert low <= value <= high
    assert high - low <= 1.1e-5 * value
