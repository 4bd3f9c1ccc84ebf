"""``vibro friction``: tables, JSON and refusals."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING

import pytest

from vibro.friction_catalogue import rows

if TYPE_CHECKING:
    from helpers.commands import Run


def test_all_rows_stand_below_their_headings(run: Run) -> None:
    result = run("friction")
    assert (result.exit_code, result.stderr) == (0, "")
    table, _, sources = result.stdout.partition("\n\n")
    heading, *lines = table.splitlines()
    assert heading.split() == ["pair", "condition", "mu_s", "mu_d", "source"]
    assert len(lines) == len(rows())
    for line, row in zip(lines, rows(), strict=True):
        assert line.startswith(row.pair)
        for name, cell in (("condition", row.condition), ("source", row.source)):
            assert line[heading.index(name) :].startswith(cell)
        assert row.url in sources
        assert row.note in sources
    assert lines[1][heading.index("mu_s") :].split()[:2] == ["0.12:0.6", "0.08:0.5"]


@pytest.mark.parametrize("words", [["steel", "on", "steel"], ["steel on steel"], ["Steel on STEEL"]])
def test_a_pair_may_be_typed_with_or_without_quotes(run: Run, words: list[str]) -> None:
    result = run("friction", *words)
    assert result.exit_code == 0
    assert sum(line.startswith("steel on steel  ") for line in result.stdout.splitlines()) == 6
    assert "brass" not in result.stdout


def test_json(run: Run) -> None:
    answer = json.loads(run("friction", "brass", "--json").stdout)
    url = "https://help.autodesk.com/cloudhelp/2016/ENU/Inventor-Help/files/GUID-42FECEEA-1F24-4470-AA60-5C358AA88A86.htm"
    assert answer == {
        "rows": [
            {
                "pair": "brass on steel",
                "condition": "dry",
                "static_friction_low": 0.35,
                "static_friction_high": 0.35,
                "kinetic_friction_low": None,
                "kinetic_friction_high": None,
                "source": "Autodesk Inventor help, friction table",
                "url": url,
                "note": "does not say static or kinetic",
            }
        ]
    }
    steel = json.loads(run("friction", "steel on steel", "--json").stdout)["rows"][1]
    assert [x for name, x in steel.items() if "friction" in name] == [0.12, 0.6, 0.08, 0.5]
    assert len(json.loads(run("friction", "--json").stdout)["rows"]) == len(rows())


def test_a_pair_that_is_not_there_is_exit_code_2(run: Run) -> None:
    result = run("friction", "plastik")
    assert (result.exit_code, result.stdout) == (2, "")
    error, hint = result.stderr.splitlines()
    assert error == "error: 'plastik': no such pair in the catalogue of friction"
    assert hint.startswith("hint: did you mean 'steel on plastic' or 'plastic on steel' or ")


def test_it_has_no_options_of_scenes(run: Run) -> None:
    text = run("friction", "--help").stdout
    assert {word for word in text.split() if word.startswith("--")} == {
        "--json",
        "--debug",
        "--version",
        "--help",
    }
    result = run("friction", "--mu-s", "1")
    assert result.exit_code == 2
    assert result.stderr.endswith("hint: see vibro friction --help\n")
