"""``vibro friction``: its rows, and how a pair is typed."""

from __future__ import annotations

from typing import TYPE_CHECKING

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
