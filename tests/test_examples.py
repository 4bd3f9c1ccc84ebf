"""Every scene file and every question among the examples runs and shows what its comment says."""

from __future__ import annotations

import json
import re
from collections import Counter
from pathlib import Path

import pytest
from helpers.commands import rows_of
from helpers.drawn import coarse_pictures
from typer.testing import CliRunner, Result

import vibro
from vibro.cli.app import app

EXAMPLES = Path(__file__).parents[1] / "examples"
SCENES = sorted(path.name for path in EXAMPLES.glob("*.toml") if not path.name.startswith("design"))
PAGES = ("README.md", "docs/guide/tour.md")
TOUR = "".join((EXAMPLES.parent / page).read_text(encoding="utf-8") for page in PAGES)
OTHERS = (*EXAMPLES.parent.glob("docs/tasks/*.md"), *EXAMPLES.glob("gallery/*.py"))
MAPPED = TOUR + "".join(page.read_text(encoding="utf-8") for page in OTHERS)


def run(*args: object) -> Result:
    return CliRunner().invoke(app, [str(arg) for arg in args])


def test_what_people_copy_uses_public_names_alone() -> None:
    text = (EXAMPLES / "paper_maps.py").read_text(encoding="utf-8")
    assert re.findall(r"^(?:from|import) vibro.*$", text, flags=re.MULTILINE) == ["import vibro"]
    assert {*re.findall(r"\bvibro\.(\w+)", text)} <= {*vibro.__all__}


# What README and the tour map is run by .ci/run, what tasks and the gallery map when the site is built.
@pytest.mark.parametrize("name", [name for name in SCENES if f"map examples/{name}" not in MAPPED])
def test_a_map_of_every_scene(name: str, tmp_path: Path) -> None:
    with coarse_pictures():
        result = run("map", EXAMPLES / name, "-o", f"{tmp_path}/")
    assert result.exit_code == 0, result.stderr
    stem = Path(name).stem
    written = {path.name for path in tmp_path.iterdir()}
    assert {f"{stem}.csv", f"{stem}.json", f"{stem}-speed.png", f"{stem}-traverse.png"} <= written
    content = json.loads((tmp_path / f"{stem}.json").read_text(encoding="utf-8"))
    assert set(content["files"]) == written


def rows_of_map(name: str) -> list[dict[str, str]]:
    result = run("map", EXAMPLES / name, "-o", "-")
    assert result.exit_code == 0
    return rows_of(result.stdout)


def test_the_safety_nut_is_the_papers_scene() -> None:
    answer = json.loads(run("traverse-time", EXAMPLES / "safety_nut.toml", "--json").stdout)
    assert answer["mean_velocity_mm_s"] == pytest.approx(16.263456166287, rel=1e-13)
    assert answer["traverse_time_s"] == pytest.approx(600 / 16.263456166287, rel=1e-13)


def test_the_mains_feeder_hops_above_the_amplitude_that_its_comment_says() -> None:
    rows = rows_of_map("mains_feeder.toml")
    hopping = [float(row["amplitude_mm"]) for row in rows if row["regime"] == "hopping"]
    assert min(hopping) == pytest.approx(0.29, abs=0.005)


def test_the_climbing_track_climbs_and_too_steep_a_one_conveys_backwards() -> None:
    def speed(*more: object) -> float:
        answer = json.loads(run("solve", EXAMPLES / "climbing_track.toml", *more, "--json").stdout)
        return float(answer["mean_velocity_mm_s"])

    assert speed() == pytest.approx(10.7, abs=0.05)
    assert speed("--trough-angle", 7.25) > 0 > speed("--trough-angle", 7.35)
    speeds = [float(row["mean_velocity_mm_s"] or "nan") for row in rows_of_map("climbing_track.toml")]
    assert min(speeds) < 0 < max(speeds)


def test_half_of_the_friction_grid_is_infeasible() -> None:
    status = Counter(row["status"] for row in rows_of_map("friction_grid.toml"))
    assert status == {"infeasible": 81 * 80 // 2, "ok": 81 * 82 // 2}


def test_the_feeder_cannot_and_says_how_far_it_gets(tmp_path: Path) -> None:
    # of parts that do not bounce: a band of restitution takes minutes
    question, text = tmp_path / "feeder.toml", (EXAMPLES / "design_feeder.toml").read_text(encoding="utf-8")
    question.write_text(text.replace("[scene]\n", "[scene]\nrestitution = 0\n"), encoding="utf-8")
    result = run("design", question, "--digits", 9, "--other-regimes")
    assert result.exit_code == 4, result.stderr
    said = result.stdout.split("\n\n")[1]
    assert said.startswith("The fastest of each drive, and the nearest drive that meets the goal")
    needed = [float(x) for line in said.splitlines()[2:] for x in re.findall(r"\d+\.\d+", line)]
    # guaranteed [mm/s], nearest [Hz], amplitude [mm] of the magnet and of the motor
    assert needed == pytest.approx([4.641, 2.9, 30.41, 15.43, 2.892, 30.56], rel=1e-2)


def test_a_full_feeder_is_slower_above_resonance_and_faster_below() -> None:
    def speed(filling: int, *more: object) -> float:
        result = run("solve", EXAMPLES / "full_feeder.toml", f"filling={filling}", *more, "--json")
        return float(json.loads(result.stdout)["mean_velocity_mm_s"])

    below = ("--pack", "6 leaves", "setting=92.6")
    assert [speed(0), speed(0, *below)] == pytest.approx([24.2, 24.2], abs=0.05)
    assert speed(4) / speed(0) - 1.0 == pytest.approx(-0.55, abs=0.005)
    assert speed(4, *below) / speed(0, *below) - 1.0 == pytest.approx(0.33, abs=0.005)


def test_the_amplitudes_over_frequency_are_of_that_feeder() -> None:
    points = EXAMPLES / "data" / "feeder_response.csv"
    fitted = json.loads(run("drive", EXAMPLES / "full_feeder.toml", "--fit", points, "--json").stdout)
    low, high = fitted["natural_frequency_hz"]["interval"]
    assert low < 47.619 < high
    low, high = fitted["damping_ratio"]["interval"]
    assert low < 0.015 < high
