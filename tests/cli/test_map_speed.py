"""``vibro map --speed``: the share of the cells that reach a speed."""

from __future__ import annotations

from helpers.commands import NUT_ANGLE_AND_FRICTION, Run, rows_of

IRREGULAR = ("-A", "0.5:3:6", "-f", "20:60:5", *NUT_ANGLE_AND_FRICTION, "--restitution", "0.6")


def test_every_map_tells_the_share_that_reaches_a_speed(run: Run) -> None:
    result = run("map", *IRREGULAR, "--speed", "150", "-o", "-")
    rows = rows_of(result.stdout)
    fast = [row for row in rows if float(row["mean_velocity_mm_s"] or "-inf") >= 150.0]
    means = sum(row["status"] == "averaged" for row in fast)
    assert 0 < means < len(fast) < len(rows) == 30
    assert result.stderr.splitlines()[-1] == (
        f"at least 150 mm/s: {len(fast)} of 30 possible cells ({100.0 * len(fast) / 30:.1f} %),"
        f" {means} of them by the mean of irregular motion"
    )


def test_cells_of_a_folder_are_not_counted(run: Run) -> None:
    result = run("map", *IRREGULAR, "--speed", "150", "-o", "wide.parquet")
    assert "--speed: cells of a folder are not counted" in result.stderr
