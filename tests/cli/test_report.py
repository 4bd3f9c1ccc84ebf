"""``vibro report``: what is on the page and in its record, where they go, and how the command ends."""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import pytest
from helpers.commands import NUT
from helpers.packed import FEEDER
from helpers.reports import ReadPage

import vibro

if TYPE_CHECKING:
    from helpers.commands import Run

EXAMPLES = Path(__file__).parents[2] / "examples"
#: One setting is found quickly.
QUESTION = """
[scene]
static_friction = "0.4:0.45"
kinetic_friction = 0.3
trough_length_mm = 600
[[drive]]
name = "a <i>magnet</i>"
amplitude_mm = 0.25
frequency_hz = 50
drive_angle_deg = 25
[goal]
speed_mm_s = {}
highest_regime = "forward-slip"
"""


@pytest.fixture(autouse=True)
def _unsaved(request: pytest.FixtureRequest) -> None:
    if "saved" not in request.fixturenames:
        request.getfixturevalue("unsaved")


@pytest.fixture
def saved() -> None:
    """Have pictures on the page."""


def page(run: Run, *args: object, code: int = 0) -> ReadPage:
    result = run("report", *args, "-q")
    assert (result.exit_code, result.stderr) == (code, "")
    return ReadPage(result.stdout)


def test_what_is_given_is_not_assumed(run: Run) -> None:
    read = page(run, *NUT, "gravity=9.81")
    assert "The trough is level" in read.text
    assert "Gravity is" not in read.text


def test_a_point_outside_of_the_map_has_no_circle(run: Run, tmp_path: Path) -> None:
    scene = (EXAMPLES / "safety_nut.toml").read_text(encoding="utf-8")
    path = tmp_path / "nut.toml"
    path.write_text(scene.partition("[map]")[0] + '[map]\namplitude_mm = "0.1:0.5"\n', encoding="utf-8")
    assert "The operating point lies outside." in page(run, path).text


def test_the_numbers_are_those_of_the_solver(run: Run) -> None:
    nut = EXAMPLES / "safety_nut.toml"
    read = page(run, nut, "--pitch", "25mm")
    scene = vibro.read_scene(nut)
    cycle = vibro.solve(scene)
    speed = 1e3 * float(cycle.mean_velocity)
    assert read.row("mean speed")[0] == f"{speed:.6g} mm/s = {0.06 * speed:.6g} m/min"
    assert read.row("regime")[0] == "forward-slip"
    assert read.row("peak speed")[0] == f"{1e3 * float(cycle.peak_velocity):.6g} mm/s"
    assert read.row("traverse time")[0] == f"{600.0 / speed:.6g} s"
    assert read.row("throughput")[0].startswith(f"{60.0 * speed / 25.0:.6g} parts/min at most")
    assert read.row("throw number")[0] == f"{float(cycle.throw_number):.6g}"
    assert "At 1.19 times the present amplitude (1.1903 mm)" in read.text
    assert read.row("gravity") == ["9.81 m/s²", "assumed"]
    assert "vibro report" in read.text
    assert f"vibro {vibro.__version__}" in read.text
    assert "The circle is the operating point." in read.text


def test_a_machine_is_told_with_what_its_amplitude_follows_from(run: Run, tmp_path: Path) -> None:
    path = tmp_path / "feeder.toml"
    axes = '[map]\nsetting_percent = "20:60"\nfrequency_hz = "45:52"\n'
    given = "setting_percent = 50\nadded_mass_share = 0.2\n"
    path.write_text(FEEDER + given + axes, encoding="utf-8")
    read = page(run, path)
    amplitude = 1e3 * float(np.asarray(vibro.read_scene(path).amplitude).item())
    assert ["amplitude", f"{amplitude:.6g} mm", "of the machine"] in read.rows
    assert "magnet, trough 6 kg, counter mass 12 kg, setting 50 %" in read.text
    assert "below resonance, where more mass mostly means more amplitude" in read.text
    assert f"The amplitude is held at {amplitude:.6g} mm here." in read.text
    assert "Map over setting and frequency" in read.text
    assert "present amplitude, or at" not in read.text  # at another frequency it has another amplitude
    assert "moves exactly as stated" not in read.text
    assert "A linear machine" in read.text


@pytest.mark.parametrize(
    ("args", "told"),
    [
        ((*NUT, "--trough-angle=-40"), "none: it gains speed every cycle, forwards, down the trough"),
        ((*NUT[:6], "--mu-s", "0", "--mu-d", "0"), "unknown"),
        ((*NUT, "-A", "0.3"), "0 mm/s = 0 m/min"),
    ],
    ids=["runaway", "indeterminate", "rest"],
)
def test_no_number_is_told_that_is_not_known(run: Run, args: tuple[str, ...], told: str) -> None:
    read = page(run, *args)
    assert read.row("mean speed")[0] == told
    assert "nan" not in read.text.casefold().split()
    assert "peak speed" not in {row[0] for row in read.rows} or told.startswith("0")


def test_a_given_motion_is_listed_and_its_regime_stays_at_any_frequency(run: Run) -> None:
    read = page(run, EXAMPLES / "slip_stick.toml")
    assert read.row("steps along the trough")[0].endswith("0.2 of the period at -9.6 m/s²")
    assert read.tags.count("figure") == 3
    assert ["frequency", "2.5 Hz", "any", "any", "–", "–", "exact"] in read.rows
    assert "accelerations, which are the same at any frequency" in read.text
    assert "the frequency is that at" not in read.text
    again = page(run, EXAMPLES / "slip_stick.toml", "-f", "300")
    assert again.row("regime") == read.row("regime")


def test_a_runaway_has_no_regime_to_keep_and_it_says_so(run: Run) -> None:
    read = page(run, *NUT, "--trough-angle=-50")
    assert "There is no steady motion that could be kept: the part gains speed in every cycle." in read.text
    assert "Positive in the conveying direction" not in read.text


@pytest.mark.usefixtures("saved")
def test_the_page_needs_nothing_else_and_users_texts_are_text(run: Run, tmp_path: Path) -> None:
    scene = tmp_path / "<b onclick=x>&amp;$_{x$.toml"
    scene.write_text((EXAMPLES / "safety_nut.toml").read_text(encoding="utf-8"), encoding="utf-8")
    read = page(run, scene)
    assert scene.stem in read.text
    assert not {"b", "script", "link", "iframe", "img", "object"} & {*read.tags}
    assert all(link.startswith(("#", "data:image/png;base64,")) for link in read.links)
    assert {link for link in read.links if link[0] == "#"} <= {f"#{one}" for one in read.ids}
    assert len(read.ids) == len(set(read.ids))


def test_files_and_their_record(run: Run, tmp_path: Path) -> None:
    result = run("report", EXAMPLES / "safety_nut.toml", "-A", "1.3", "--pitch", "25", "-o", "out/nut")
    assert (result.exit_code, result.stdout) == (0, "")
    assert sorted(path.name for path in (tmp_path / "out").iterdir()) == ["nut.html", "nut.json"]
    record = json.loads((tmp_path / "out/nut.json").read_text(encoding="utf-8"))
    assert record["argv"][:2] == ["vibro", "report"]
    assert record["files"] == ["nut.html", "nut.json"]
    assert record["scene"]["amplitude_mm"] == 1.3
    assert record["part"] == {"pitch_mm": 25.0}
    assert record["result"]["regime"] == "back-slip"
    html = (tmp_path / "out/nut.html").read_text(encoding="utf-8")
    assert ReadPage(html).row("per cycle")[0] == f"{record['result']['displacement_per_cycle_mm']:.6g} mm"
    again = run("report", *NUT, "-o", "out/nut")
    assert again.exit_code == 1
    assert "--force" in again.stderr


@pytest.mark.parametrize(("speed", "code"), [(2, 0), (900, 4)], ids=["met", "not met"])
def test_designs(run: Run, tmp_path: Path, speed: float, code: int) -> None:
    (tmp_path / "question.toml").write_text(QUESTION.format(speed), encoding="utf-8")
    result = run("report", "question.toml", "-o", "answer", "-q")
    assert (result.exit_code, result.stderr) == (code, "")
    read = ReadPage((tmp_path / "answer.html").read_text(encoding="utf-8"))
    record = json.loads((tmp_path / "answer.json").read_text(encoding="utf-8"))
    assert record["met"] is (code == 0)
    fastest = next(d for d in record["designs"] if d["design"] == "fastest")
    assert fastest["highest_regime"] == "forward-slip"
    assert f"{fastest['amplitude_mm']:.15g}" in read.row("fastest")
    ((least, per_minute),) = re.findall(r"Every part at least\n([\d.]+) mm/s([\d.]+) m/min", read.text)
    assert float(per_minute) == pytest.approx(0.06 * float(least), rel=1e-4)
    answer = "The goal is met by: a <i>magnet</i>." if code == 0 else "No drive meets the goal."
    assert answer in read.text
    assert ("Why no drive meets the goal" in read.text) is (code == 4)
    assert "i" not in read.tags
    assert read.tags.count("figure") == 2
    assert "Drive and trough stay as set: no drift was given." in read.text
