"""``vibro friction``: its rows, and how a pair is typed."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING

import pytest

from vibro.friction import rows

if TYPE_CHECKING:
    from helpers.commands import Run


def test_all_rows_stand_below_their_headings(run: Run) -> None:
    result = run("friction")
    assert (result.exit_code, result.stderr) == (0, "")
    table, _, sources = result.stdout.partition("\n\n")
    heading, units, *lines = table.splitlines()
    assert heading.split() == ["pair", "condition", "mu_s", "mu_d", "e", "impact", "source"]
    assert units.split() == ["[m/s]"]
    assert units.index("[m/s]") == heading.index("impact")
    assert len(lines) == len(rows())
    for line, row in zip(lines, rows(), strict=True):
        assert line.startswith(row.pair)
        for name, cell in (("condition", row.condition), ("source", row.source)):
            assert line[heading.index(name) :].startswith(cell)
        assert row.url in sources
        assert row.note in sources
    assert lines[1][heading.index("mu_s") :].split()[:2] == ["0.12:0.6", "0.08:0.5"]
    (pellets,) = (line for line in lines if line.startswith("polyethylene on steel"))
    assert pellets[heading.index("mu_s") :].split()[:4] == ["-", "-", "0.335:0.364", "0.79:0.93"]


def test_json_has_restitution_and_its_impact_speed(run: Run) -> None:
    content = json.loads(run("friction", "polyethylene on steel", "--json").stdout)["rows"][0]
    assert {key: value for key, value in content.items() if "low" in key or "high" in key} == {
        "static_friction_low": None,
        "static_friction_high": None,
        "kinetic_friction_low": None,
        "kinetic_friction_high": None,
        "restitution_low": 0.335,
        "restitution_high": 0.364,
        "impact_speed_low_m_s": 0.79,
        "impact_speed_high_m_s": 0.93,
    }


@pytest.mark.parametrize("words", [["steel", "on", "steel"], ["steel on steel"], ["Steel on STEEL"]])
def test_a_pair_may_be_typed_with_or_without_quotes(run: Run, words: list[str]) -> None:
    result = run("friction", *words)
    assert result.exit_code == 0
    assert sum(line.startswith("steel on steel  ") for line in result.stdout.splitlines()) == 9
    assert "brass" not in result.stdout
