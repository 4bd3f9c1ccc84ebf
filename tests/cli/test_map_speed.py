"""``vibro map --speed``: the contour, and the frictions that keep a speed."""

from __future__ import annotations

from pathlib import Path

from helpers.cases import each
from helpers.commands import NUT_ANGLE_AND_FRICTION, Run, rows_of

NUT_MAP = ("map", "-A", "0.5,1.1", "-f", "10:30:5", *NUT_ANGLE_AND_FRICTION, "-o", "out/nut")


def window(run: Run, *args: str) -> str:
    result = run("map", "-A", "1", "-f", "15", "-a", "20", *args, "-o", "-")
    assert result.exit_code == 0, result.stderr
    return str(result.stderr.splitlines()[-1])


def test_a_map_of_frictions_tells_which_keep_a_speed(run: Run) -> None:
    frictions = ("--mu-s", "0.2:1:17", "--mu-d", "0.2:1:17")
    result = run("map", "-A", "1", "-f", "15", "-a", "20", *frictions, "--speed", "0.02m/s", "-o", "-")
    fast = [row for row in rows_of(result.stdout) if float(row["mean_velocity_mm_s"] or "-inf") >= 20.0]
    possible = [row for row in rows_of(result.stdout) if row["status"] != "infeasible"]
    ends = [
        (min(values), max(values))
        for values in ([float(row[name]) for row in fast] for name in ("static_friction", "kinetic_friction"))
    ]
    inside = [
        row
        for row in possible
        if all(
            low <= float(row[name]) <= high
            for (low, high), name in zip(ends, ("static_friction", "kinetic_friction"), strict=True)
        )
    ]
    (static, kinetic), share = ends, 100.0 * len(fast) / len(inside)
    assert result.stderr.splitlines()[-1] == (
        f"at least 20 mm/s: {len(fast)} of {len(possible)} possible cells"
        f" ({100.0 * len(fast) / len(possible):.1f} %); they lie within static friction {static[0]:g} ..."
        f" {static[1]:g} and kinetic friction {kinetic[0]:g} ... {kinetic[1]:g}, where"
        f" {share:.1f} % of the possible cells reach it"
    )
    assert 0 < len(fast) < len(inside) < len(possible)


def test_the_window_of_a_friction_ratio_may_be_whole_or_empty(run: Run) -> None:
    frictions = ("--mu-s", "0.7,0.8", "--mu-ratio", "0.6,0.7")
    ranges = "static friction 0.7 ... 0.8 and friction ratio 0.6 ... 0.7"
    whole = f"they lie within {ranges}, where all of the possible cells reach it"
    assert (
        window(run, *frictions, "--speed", "1")
        == f"at least 1 mm/s: 4 of 4 possible cells (100.0 %); {whole}"
    )
    none = window(run, *frictions, "--speed", "900")
    assert none.startswith("at least 900 mm/s: 0 of 4 possible cells; the fastest: 25.7184")
    assert none.endswith(" mm/s at static friction 0.7, friction ratio 0.6")


def test_other_maps_tell_no_window(run: Run) -> None:
    for axes in (("--mu-s", ".7,.8", "--mu-d", ".5"), ("--mu-s", ".7,.8", "--mu-d", ".5,.6", "-f", "15,16")):
        assert "lie within" not in window(run, *axes, "--speed", "1")


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


def test_a_speed_that_no_cell_reaches_tells_the_largest(run: Run) -> None:
    lines = run("map", *IRREGULAR, "--speed", "5m/s", "-o", "-").stderr.splitlines()
    (fastest,) = [line for line in lines if line.startswith("fastest: ")]
    assert f"at least 5000 mm/s: 0 of 30 possible cells; the {fastest}" in lines
    rests = ("map", "-A", "0.01,0.02", "-f", "10", *NUT_ANGLE_AND_FRICTION, "--speed", "1", "-o", "-")
    said = run(*rests).stderr.splitlines()
    assert "at least 1 mm/s: 0 of 2 possible cells; none moves forwards" in said


def test_folders_and_what_is_drawn_of_them_tell_the_share(run: Run) -> None:
    made = run("map", *IRREGULAR, "--speed", "150", "--table", "parquet", "-o", "wide").stderr
    assert " possible cells of the pictures (" in made
    read = run("map", "wide", "--speed", "150", "-o", "read").stderr.splitlines()[-1]
    assert read == run("map", *IRREGULAR, "--speed", "150", "-o", "-").stderr.splitlines()[-1]


def test_a_speed_is_drawn_where_it_is_reached(run: Run) -> None:
    line = ("-A", "0.5:1.5:9", "-f", "15", *NUT_ANGLE_AND_FRICTION)
    assert run("map", *line, "--speed", "20", "-o", "with", "--format", "svg").exit_code == 0
    assert run("map", *line, "-o", "without", "--format", "svg").exit_code == 0
    assert Path("with-speed.svg").stat().st_size > Path("without-speed.svg").stat().st_size


@each("wrong", [("0",), ("-5",), ("20Hz",), ("20", "--regimes-only")])
def test_speeds_that_cannot_be_asked_for(run: Run, wrong: tuple[str, ...]) -> None:
    result = run(*NUT_MAP, "--speed", *wrong)
    assert (result.exit_code, list(Path().rglob("*"))) == (2, [])
    assert "speed" in result.stderr


def test_frictions_that_keep_a_speed_on_an_elliptical_drive(run: Run) -> None:
    drive = ("--along", "0.2", "--normal", "0.08", "--phase=-60", "-f", "50", "--trough-angle", "2")
    frictions = ("--mu-s", "0.2:0.8:13", "--mu-ratio", "0.7:0.9:3")
    result = run("map", *drive, *frictions, "--speed", "30", "-o", "-")
    assert result.exit_code == 0
    fast = [row for row in rows_of(result.stdout) if float(row["mean_velocity_mm_s"]) >= 30.0]
    assert 5 < len(fast) < 34
    assert f"at least 30 mm/s: {len(fast)} of 39 possible cells" in result.stderr
