"""What ``vibro map`` and ``vibro solve`` tell of hopping: other motions, restitution as an axis."""

from __future__ import annotations

import json
from pathlib import Path

from helpers.commands import NUT, NUT_FILE, Run, other, rows_of


def test_other_motions_are_looked_for_on_request(run: Run) -> None:
    slopes = ("map", *other(NUT, "-A", "0.1,6", "-a", "55"), "--trough-angle", "0:31:2")
    flags = [row["coexists"] for row in rows_of(run(*slopes, "-o", "-").stdout)]
    assert flags == ["0", "1", "", "1"]
    flags = [row["coexists"] for row in rows_of(run(*slopes, "--coexist", "-o", "-").stdout)]
    assert flags == ["0", "1", "0", "1"]


def test_the_sidecar_says_whether_other_motions_were_looked_for(run: Run) -> None:
    for more, looked in (((), False), (("--coexist",), True)):
        assert run("solve", *NUT, "-o", "nut", "--force", *more).exit_code == 0
        assert json.loads(Path("nut.json").read_text(encoding="utf-8"))["coexistence"] is looked


def test_restitution_is_an_axis(run: Run) -> None:
    Path("hop.toml").write_text(
        NUT_FILE + '\n[map]\namplitude_mm = [1, 4.5]\nrestitution = "0:0.2:3"\n', encoding="utf-8"
    )
    rows = rows_of(run("map", "hop.toml", "-o", "-", "--at", "restitution=0.1").stdout)
    columns = list(rows[0])
    assert columns[columns.index("restitution") - 1] == "trough_angle_deg"
    assert [row["restitution"] for row in rows] == ["0", "0.1", "0.2"] * 2
    speeds = [row["mean_velocity_mm_s"] for row in rows]
    assert len(set(speeds[:3])) == 1  # it does not leave the trough
    assert len(set(speeds[3:])) == 3
    for row in rows[3:]:
        alone = run("solve", *other(NUT, "-A", "4.5"), "--restitution", row["restitution"], "-o", "-").stdout
        (same,) = rows_of(alone)
        assert {name: row[name] for name in same} == same
