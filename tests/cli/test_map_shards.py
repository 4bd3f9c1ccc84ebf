"""``vibro map --table parquet``: its options, what it says, and what it writes."""

from __future__ import annotations

import json
import re
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pandas as pd
import pytest
from helpers.commands import NUT, Run, rows_of
from helpers.sharded_maps import AXES, SHARD_NAMES, SHARDED, WHOLE, frame, names, told
from pyarrow import parquet

WIDE = Path(__file__).parents[2] / "examples" / "wide_sweep.toml"

pytestmark = pytest.mark.usefixtures("no_pictures")


def test_a_folder_of_shards_is_the_csv(run: Run) -> None:
    result = run(*AXES, "--table", "parquet", "--shard-cells", "4", "-o", "far/out")
    assert (result.exit_code, result.stdout) == (0, "")
    assert names("far/out") == WHOLE
    rows = rows_of(run(*AXES, "-o", "-").stdout)
    found = frame("far/out")
    assert list(found.columns) == list(rows[0])
    for name in found.columns:
        written = [row[name] for row in rows]
        if not pd.api.types.is_numeric_dtype(found[name].dtype):
            assert found[name].tolist() == written
        else:
            numbers = [float(cell or "nan") for cell in written]
            np.testing.assert_array_equal(found[name].astype(float), numbers, err_msg=name)


def test_what_was_written_is_told(run: Run) -> None:
    said = run(*SHARDED, "-o", "out").stderr.splitlines()
    assert said[:2] == [
        "amplitude: 3 values, 0.5 ... 2 mm, step 0.75",
        "frequency: 3 values, 10 ... 30 Hz, step 10",
    ]
    success = told()
    size = sum(Path("out", name).stat().st_size for name in SHARD_NAMES)
    assert said[-8:] == [
        f"wrote out: 3 shards, {size / 1e3:.3g} kB, {size / 9:.1f} bytes a cell; digest {success['digest']}",
        f"wrote {Path('out', '_manifest.json')}",
        f"wrote {Path('out', '_SUCCESS')}",
        "3 of 9 cells: flight-not-modelled (the body leaves the trough; its flight is not modelled)",
        "     no-slip   22.2%",
        "forward-slip   22.2%",
        "   back-slip   22.2%",
        "     hopping   33.3%",
    ]
    assert told("_manifest.json")["argv"] == ["vibro", *SHARDED, "-o", "out"]
    assert told("_manifest.json")["shard_cells"] == 4


def test_progress_is_told_where_nobody_watches(run: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("os.cpu_count", lambda: 1)  # of more workers' shards all may come at once
    lines = [line for line in run(*SHARDED, "-o", "out").stderr.splitlines() if " % of " in line]
    assert 1 <= len(lines) <= 2
    told_as = r"\d0 % of 9 cells: [12] of 3 shards, \S+ cells/s, about \d+ s left"
    assert all(re.fullmatch(told_as, line) for line in lines), lines
    assert run(*SHARDED, "-o", "quiet", "-q").stderr == ""


@pytest.mark.parametrize("free", [0, 10**15])
def test_a_disk_that_will_be_full_is_told_early(run: Run, monkeypatch: pytest.MonkeyPatch, free: int) -> None:
    monkeypatch.setattr("os.cpu_count", lambda: 1)
    monkeypatch.setattr("shutil.disk_usage", lambda _: SimpleNamespace(free=free))
    result = run(*SHARDED, "-o", "out")
    assert result.exit_code == 0
    lines = [line for line in result.stderr.splitlines() if line.startswith("warning: ")]
    assert len(lines) == (free == 0)
    for line in lines:
        assert re.fullmatch(r"warning: about \d\S* kB more are needed, and 0 B are free", line)


@pytest.mark.parametrize(("room", "is_told"), [(1.5, True), (2.2, False)])
def test_a_disk_with_less_room_than_the_shards_to_come_need_is_told(
    run: Run, monkeypatch: pytest.MonkeyPatch, room: float, is_told: bool
) -> None:
    monkeypatch.setattr("os.cpu_count", lambda: 1)
    assert run(*SHARDED, "-o", "out").exit_code == 0
    one = Path("out", "part-000000.parquet").stat().st_size
    monkeypatch.setattr("shutil.disk_usage", lambda _: SimpleNamespace(free=room * one))
    assert ("more are needed" in run(*SHARDED, "-o", "again").stderr) is is_told


def test_json_is_what_there_is(run: Run) -> None:
    result = run(*SHARDED, "-o", "out", "--json", "-q", "--digits", "4")
    said = json.loads(result.stdout)
    success, manifest = told(), told("_manifest.json")
    assert (said["folder"], said["shards"], said["cells"], said["digits"]) == ("out", 3, 9, 4)
    for key in ("bytes", "digest", "status", "regime"):
        assert said[key] == success[key]
    for key in ("scene", "accuracy", "flight", "coexistence", "columns"):
        assert said[key] == manifest[key]
    assert result.stderr == ""


def test_the_folder_has_the_name_of_the_scene(run: Run) -> None:
    assert run(*SHARDED).exit_code == 0
    assert "_SUCCESS" in names("vibro-map")
    scene = "[scene]\ndrive_angle_deg = 20\nstatic_friction = 0.74\nkinetic_friction = 0.57\n"
    Path("nut.toml").write_text(scene, encoding="utf-8")
    assert run("map", "nut.toml", *SHARDED[1:5], *SHARDED[-5:]).exit_code == 0
    assert "_SUCCESS" in names("nut")
    assert told("_manifest.json", "nut")["name"] == "nut"


def test_unresolved_cells_are_exit_code_3_however_often_resumed(
    run: Run, monkeypatch: pytest.MonkeyPatch
) -> None:
    import vibro.sweeps.grid
    from vibro.core.codes import Status
    from vibro.results import SteadyCycle
    from vibro.scene import Scene
    from vibro.steady import solve

    def doubtful(scene: Scene, **how: Any) -> SteadyCycle:
        cycle = solve(scene, **how)
        cycle.status.flat[0] = Status.UNRESOLVED
        return cycle

    with monkeypatch.context() as patch:
        patch.setattr(vibro.sweeps.grid, "solve", doubtful)
        result = run(*SHARDED, "-o", "out")
    assert result.exit_code == 3
    assert "3 of 9 cells: unresolved" in result.stderr
    assert told()["status"] == {"ok": 4, "flight-not-modelled": 2, "unresolved": 3}
    assert (frame()["status"] == "unresolved").sum() == 3
    assert run(*SHARDED, "-o", "out", "--resume").exit_code == 3


def test_cells_that_all_rest_are_told_where_motion_begins(run: Run) -> None:
    still = (*SHARDED, "-A", "0.001:0.002:3", "-o", "out")
    assert (
        run(*still).stderr.splitlines()[-1]
        == run(*still[:-6], *still[-4:-2], "-o", "csv").stderr.splitlines()[-1]
    )
    again = run(*still, "--resume").stderr.splitlines()[-1]
    assert again.startswith("at rest everywhere: motion begins at 0.1713 mm with 30 Hz")
    assert "at rest" not in run(*SHARDED, "-o", "moves").stderr


@pytest.mark.parametrize("table", ["csv", "parquet"])
def test_bodies_that_rest_may_have_restitutions(run: Run, table: str) -> None:
    still = ("map", *NUT, "-A", "0.001,0.002", "--restitution", "0:0.3:2", "--table", table, "-o", "out")
    result = run(*still)
    assert result.exit_code == 0
    assert result.stderr.splitlines()[-1].startswith("at rest everywhere: motion begins at ")


def test_infeasible_cells_are_no_error(run: Run) -> None:
    result = run("map", *NUT, "--mu-s", "0.5,0.7", "--table", "parquet", "-o", "out", "--regimes-only")
    assert result.exit_code == 0
    assert frame()["status"].tolist() == ["infeasible", "ok"]
    assert "1 of 2 cells: infeasible" in result.stderr


def test_the_wide_example_in_small(run: Run) -> None:
    result = run(
        "map", WIDE, "-A", "0.5,1", "-f", "10:50:3", "-a", "20,30", "--mu-s", "0.2:0.98:4",
        "--mu-ratio", "0.5:0.98:3", "--table", "parquet", "-o", "out", "--shard-cells", "50",
    )  # fmt: skip
    assert result.exit_code == 0
    cells = frame()
    assert len(cells) == 2 * 3 * 2 * 4 * 3
    manifest = told("_manifest.json")
    assert list(manifest["axes"]) == [
        "amplitude_mm", "frequency_hz", "drive_angle_deg", "static_friction", "friction_ratio",
    ]  # fmt: skip
    assert manifest["scene"]["trough_length_mm"] == 600
    assert manifest["name"] == "wide_sweep"
    assert cells["traverse_time_s"].notna().any()
    assert parquet.read_schema(Path("out", SHARD_NAMES[0])).names == list(manifest["columns"])
