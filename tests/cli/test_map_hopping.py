"""What ``vibro map`` and ``vibro solve`` tell of hopping: other motions, restitution as an axis."""

from __future__ import annotations

import json
from pathlib import Path

from helpers.commands import NUT, NUT_FILE, Run, other, rows_of


def test_other_motions_are_looked_for_on_request(run: Run) -> None:
    slopes = ("map", *other(NUT, "-A", "0.1,6", "-a", "55"), "--trough-angle", "0:31:2")
    flags = [row["coexists"] for row in rows_of(run(*slopes, "-o", "-").stdout)]
    assert flags == ["0", "1", "", "1"]
    flags = [row["coexists"] for row in rows_of(run(*slopes, "--starts", "16", "-o", "-").stdout)]
    assert flags == ["0", "1", "0", "1"]


def test_cells_where_most_parts_move_otherwise_are_counted(run: Run) -> None:
    scene = ("map", "-A", "0.5,1.65", "-f", "15", "-a", "40.3", "--mu-s", ".458", "--mu-d", ".043", "-o", "-")
    told = "in 1 of 2 cells most parts move otherwise than the one released at the start of a cycle"
    found = run(*scene, "--starts", "16")
    assert [float(row["share"]) < 0.5 for row in rows_of(found.stdout)] == [False, True]
    assert told in found.stderr
    assert "most parts" not in run(*scene).stderr


def test_columns_and_sidecar_of_starts_are_there_where_they_were_asked_for(run: Run) -> None:
    scene = ("map", *other(NUT, "-A", "1, 3"), "--force")
    for more, starts in (((), None), (("--starts", "16"), 16)):
        rows = rows_of(run(*scene, *more, "-o", "-").stdout)
        assert ("share" in rows[0]) is ("mean_velocity_over_starts_mm_s" in rows[0]) is (starts is not None)
        assert run(*scene, *more, "-o", "nut.csv").exit_code == 0
        assert json.loads(Path("nut.json").read_text(encoding="utf-8")).get("starts") == starts
    assert float(rows[0]["share"]) == 1.0
    assert rows[0]["mean_velocity_over_starts_mm_s"] == rows[0]["mean_velocity_mm_s"]


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


def test_every_map_tells_the_share_that_reaches_a_speed(run: Run) -> None:
    axes = ("-A", "0.5:3:6", "-f", "20:60:5", *NUT[4:], "--restitution", "0.6")
    result = run("map", *axes, "--speed", "150", "-o", "-")
    rows = rows_of(result.stdout)
    fast = [row for row in rows if float(row["mean_velocity_mm_s"] or "-inf") >= 150.0]
    means = sum(row["status"] == "averaged" for row in fast)
    assert 0 < means < len(fast) < len(rows) == 30
    assert result.stderr.splitlines()[-1] == (
        f"at least 150 mm/s: {len(fast)} of 30 possible cells ({100.0 * len(fast) / 30:.1f} %),"
        f" {means} of them by the mean of irregular motion"
    )
