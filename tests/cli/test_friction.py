"""``vibro friction``: its rows, and how a pair is typed."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pytest

from vibro.friction import rows

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
