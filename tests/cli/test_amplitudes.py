"""``vibro solve --speed``: amplitudes along lines and ellipses, in contact and with hops."""

from __future__ import annotations

import json
import math
import re
from pathlib import Path
from typing import Any

import pytest
from helpers.cases import each
from helpers.commands import NUT, Run
from helpers.made_records import EXAMPLES

BOWL = ("--along", "3", "--normal", "1", "-f", "25", "--mu-s", ".4", "--mu-d", ".3")


def test_the_amplitudes_that_reach_a_speed(run: Run) -> None:
    scene = NUT[2:]
    result = run("solve", *scene, "--speed", "0.02815m/s")
    assert (result.exit_code, result.stderr) == (0, "")
    lines = [" ".join(line.split()) for line in result.stdout.splitlines()]
    assert lines[1] == "asked for at least 0.02815 m/s without hopping"
    # Published: 1.177843 to 1.190299 mm and 1.233006 to 3.229052 mm; rounded inwards.
    assert lines[4:] == [
        "1.17785 1.19029 the speed is reached back slip makes it slower",
        "1.23301 3.22905 the speed is reached the body hops",
    ]
    answer = json.loads(run("solve", *scene, "--speed", "28.15", "--json").stdout)
    assert (answer["met"], answer["speed_mm_s"], answer["highest_regime"]) == (True, 28.15, "back-slip")
    assert "amplitude_mm" not in answer["scene"]
    for interval in answer["amplitudes"]:
        for end in ("amplitude_low_mm", "amplitude_high_mm"):
            cycle = json.loads(run("solve", *scene, "-A", repr(interval[end]), "--json").stdout)
            assert cycle["mean_velocity_mm_s"] >= 28.15 * (1.0 - 1e-12)
            assert cycle["regime"] != "hopping"


@pytest.mark.parametrize(
    ("speed", "told"), [("5m/min", "5 m/min"), ("3.97 M/MIN", "3.97 m/min"), ("83", "83 mm/s")]
)
def test_speeds_are_told_in_the_unit_of_the_question(run: Run, speed: str, told: str) -> None:
    unit = told.split()[1]
    lines = run("solve", *NUT[2:], "--speed", speed).stdout.splitlines()
    assert " ".join(lines[1].split()) == f"asked for at least {told} without hopping"
    fast = {"m/min": 30, "mm/s": 500}[unit]
    best = {"m/min": "7.396 m/min", "mm/s": "123.3 mm/s"}[unit]
    last = run("solve", *NUT[2:], "--speed", f"{fast}{unit}").stdout.splitlines()[-1]
    assert last == f"no amplitude does it: without hopping it gets about {best}, at 3.229 mm"
    answer = json.loads(run("solve", *NUT[2:], "--speed", "6m/min", "--json").stdout)
    assert answer["speed_mm_s"] == 100.0


def test_hopping_goes_on_to_a_throw_number_of_10(run: Run) -> None:
    result = run("solve", *NUT[2:], "--speed", "50m/min", "--hopping")
    lines = [" ".join(line.split()) for line in result.stdout.splitlines()]
    assert lines[1] == "asked for at least 50 m/min, hopping or not"
    assert lines[3] == "restitution 0: parts land without a bounce"
    assert lines[2].startswith("hops sampled at 32769 amplitudes up to 32.29 mm (throw number 10):")
    assert [line.split()[:2] for line in lines[7:]] == [
        ["9.50335", "14.2365"], ["16.7411", "24.9105"], ["26.439", "32.2905"],
    ]  # fmt: skip
    assert lines[-1].endswith("the speed is reached throw number 10")
    answer = json.loads(run("solve", *NUT[2:], "--speed", "50m/min", "--hopping", "--json").stdout)
    assert answer["highest_regime"] == "hopping"
    last = answer["amplitudes"][-1]
    cycle = json.loads(run("solve", *NUT[2:], "-A", repr(last["amplitude_high_mm"]), "--json").stdout)
    assert cycle["throw_number"] == pytest.approx(10.0, rel=1e-12)
    assert last["high_set_by"] == "limit"
    bouncing = run("solve", *NUT[2:], "--restitution", "0.3", "--speed", "1000m/min", "--hopping")
    assert bouncing.exit_code == 4
    assert "sampled at 4097 amplitudes" in bouncing.stdout
    assert "no amplitude does it: up to a throw number of 10 it gets about" in bouncing.stdout


def test_irregular_hops_fill_no_screen(run: Run) -> None:
    scene = (*BOWL, "--restitution", "0.2", "--phase", "-60")
    lines = run("solve", *scene, "--speed", "12m/min", "--hopping").stdout.splitlines()
    rows = lines[lines.index("") + 2 :]
    assert len(rows) == 21
    assert re.fullmatch(r"and \d+ narrower ones, where hops are irregular: --json has all", rows[-1])


def test_both_amplitudes_of_an_ellipse_keep_their_proportion(run: Run) -> None:
    scene = (*BOWL, "--phase", "-60")
    result = run("solve", *scene, "--speed", "5m/min")
    assert (result.exit_code, result.stderr) == (0, "")
    lines = [" ".join(line.split()) for line in result.stdout.splitlines()]
    assert lines[2] == "amplitudes both change together, in the proportion of the scene"
    assert lines[4:] == [
        "along from [mm] normal from [mm] along to [mm] normal to [mm] at its beginning at its end",
        "0.922276 0.307426 1.19275 0.397584 the speed is reached the body hops",
    ]
    (found,) = json.loads(run("solve", *scene, "--speed", "5m/min", "--json").stdout)["amplitudes"]
    for end in ("low", "high"):
        x, y = (found[f"{way}_amplitude_{end}_mm"] for way in ("along", "normal"))
        assert x == pytest.approx(3.0 * y, rel=1e-15)
        at = ("--along", repr(x), "--normal", repr(y), *scene[4:])
        cycle = json.loads(run("solve", *at, "--json").stdout)
        assert cycle["mean_velocity_mm_s"] >= 250.0 / 3.0 * (1.0 - 1e-12)
        assert cycle["regime"] != "hopping"


def test_an_ellipse_that_conveys_backwards_is_turned(run: Run) -> None:
    result = run("solve", *BOWL, "--phase", "120", "--speed", "5m/min")
    assert result.exit_code == 4
    assert result.stdout.splitlines()[-1] == (
        "no amplitude does it: without hopping it moves backwards, about 7.495 m/min at along 1.193 mm,"
        " normal 0.3976 mm; --phase -60 drives it the other way"
    )
    assert run("solve", *BOWL, "--phase", "-60", "--speed", "5m/min").exit_code == 0


def test_an_amplitude_of_an_ellipse_may_be_0(run: Run) -> None:
    friction = ("-f", "25", "--mu-s", ".4", "--mu-d", ".3")
    down = run("solve", "--along", "0", "--normal", "1", *friction, "--beta", "-3", "--speed", "0.3mm/s")
    assert down.stdout.splitlines()[-1].split()[:4] == ["0", "0.386308", "0", "0.397039"]
    flat = run("solve", "--along", "1", "--normal", "0", *friction, "--beta", "-10", "--speed", "20")
    assert flat.stdout.splitlines()[-1].split()[1:4] == ["0", "any", "0"]
    none = run("solve", "--along", "0", "--normal", "0", *friction, "--speed", "20")
    assert none.exit_code == 2
    assert none.stderr.splitlines()[0].startswith("error: along amplitude = normal amplitude = 0 mm: ")


STEPS = """[scene]
frequency_hz = 2.5
static_friction = 0.3
kinetic_friction = 0.25
motion_scale = 7
[motion]
along_steps = [[0.8, 2.4], [0.2, -9.6]]
"""
SAMPLES = STEPS.partition("along")[0] + "along_samples_m_s2 = [0, 3, 4, 2, 1, -3, -6, -1]\n"
DISPLACEMENTS = STEPS.partition("along")[0] + "along_samples_mm = [0, -13, -14, -12, -1, 23, 16, 1]\n"
WAVE = """[scene]
frequency_hz = 15
static_friction = 0.5
kinetic_friction = 0.4
along_amplitudes_mm = [1, 0.2, 0.05]
along_phases_deg = [10, 20, 30]
normal_amplitudes_mm = [0.3, 0.1, 0.03]
normal_phases_deg = [0, 20, 50]
"""
CLAMPED = """[scene]
frequency_hz = 25
static_friction = 0.4
kinetic_friction = 0.3
trough_angle_deg = 90
normal_acceleration_m_s2 = 200
along_amplitudes_mm = [4, 1.2]
along_phases_deg = [0, -90]
"""


@pytest.mark.parametrize("text", [STEPS, SAMPLES, DISPLACEMENTS, WAVE, CLAMPED])
@pytest.mark.parametrize("hopping", [(), ("--hopping",)])
def test_the_scales_of_a_motion_that_reach_a_speed(
    run: Run, tmp_path: Path, text: str, hopping: tuple[str, ...]
) -> None:
    file = tmp_path / "scene.toml"
    file.write_text(text, encoding="utf-8")
    speed = 15.0
    result = run("solve", file, "--speed", speed, *hopping, "--json")
    assert (result.exit_code, result.stderr) == (0, "")
    answer = json.loads(result.stdout)
    assert answer["met"]
    assert "motion_scale" not in answer["scene"]
    assert ("motion" in answer["scene"]) == ("[motion]" in text)

    def solved(scale: float) -> dict[str, Any]:
        found = json.loads(run("solve", file, "--motion-scale", repr(scale), "--json").stdout)
        assert isinstance(found, dict)
        return found

    for interval in answer["amplitudes"][:5]:
        low, high = interval["motion_scale_low"], interval["motion_scale_high"]
        at = solved(low)
        assert at["mean_velocity_mm_s"] >= speed * (1.0 - 1e-9)
        assert (at["regime"] == "hopping") <= bool(hopping)
        if interval["low_set_by"] == "speed":
            assert solved(low * (1.0 - 1e-6))["mean_velocity_mm_s"] < speed
        if high is not None and interval["high_set_by"] == "hop" and not hopping:
            assert solved(high)["regime"] != "hopping"
            assert solved(high * (1.0 + 1e-9))["regime"] == "hopping"
        assert solved(2.0 * low if high is None else 0.5 * (low + high))["mean_velocity_mm_s"] >= speed
        if "along_amplitude_low_mm" in interval:  # as large as the scene's times the scale
            given = answer["scene"].get("along_amplitude_mm", interval["along_amplitude_low_mm"] / low)
            assert interval["along_amplitude_low_mm"] == pytest.approx(low * given, rel=1e-15)
    assert ("along_amplitude_low_mm" in answer["amplitudes"][0]) == (text not in (STEPS, SAMPLES))


def test_scales_of_a_line_are_its_amplitudes(run: Run, tmp_path: Path) -> None:
    """A line given as a motion: an independent path to the same answer."""
    angle = math.radians(20.0)
    x, y = math.cos(angle), math.sin(angle)
    file = tmp_path / "line.toml"
    text = f"[motion]\nalong_harmonics_mm_deg = [[{x!r}, 0]]\nnormal_harmonics_mm_deg = [[{y!r}, 0]]\n"
    file.write_text(text + "[scene]\nfrequency_hz = 15\n", encoding="utf-8")
    for speed, hopping in (("28.15", ()), ("50m/min", ("--hopping",))):
        line = json.loads(run("solve", *NUT[2:], "--speed", speed, *hopping, "--json").stdout)
        given = ("--mu-s", 0.74, "--mu-d", 0.57, "--along-2", 0, "--normal-2", 0)
        moved = json.loads(run("solve", file, *given, "--speed", speed, *hopping, "--json").stdout)
        assert len(line["amplitudes"]) == len(moved["amplitudes"]) > 1
        for a, b in zip(line["amplitudes"], moved["amplitudes"], strict=True):
            for end in ("low", "high"):
                assert b[f"motion_scale_{end}"] == pytest.approx(a[f"amplitude_{end}_mm"], rel=1e-6)
                assert b[f"along_amplitude_{end}_mm"] == pytest.approx(x * b[f"motion_scale_{end}"])
                assert b[f"{end}_set_by"] == a[f"{end}_set_by"]


def test_scales_are_told_with_the_amplitudes_of_few_harmonics(run: Run) -> None:
    """Of examples/slip_stick_harmonics.toml."""
    wave = run("solve", EXAMPLES / "slip_stick_harmonics.toml", "--speed", "6m/min")
    heads, row = (re.split(r" {2,}", line) for line in wave.stdout.splitlines()[-2:])
    assert heads[:3] == ["scale from", "along from [mm]", "second along from [mm]"]
    assert heads[3:6] == ["scale to", "along to [mm]", "second along to [mm]"]
    assert row[3:6] == ["any", "any", "any"]
    scale = float(row[0])
    assert [float(text) for text in row[1:3]] == pytest.approx([20.0 * scale, 5.0 * scale], rel=1e-5)
    steps = run("solve", EXAMPLES / "slip_stick.toml", "--speed", "6m/min")
    assert (
        steps.stdout.splitlines()[0].split(maxsplit=1)[1].startswith("motion of 2 pieces, frequency 2.5 Hz,")
    )
    assert steps.stdout.splitlines()[-1].split()[:2] == ["0.834699", "any"]
    none = run("solve", EXAMPLES / "slip_stick.toml", "--speed", "50m/min")
    assert none.exit_code == 4
    assert none.stdout.splitlines()[-1] == (
        "no scale does it: without hopping it gets about 12.17 m/min, at scale 1.225"
    )


def test_a_scale_is_not_given_where_it_is_asked_for(run: Run) -> None:
    steps = EXAMPLES / "slip_stick.toml"
    result = run("solve", steps, "--speed", "100", "--motion-scale", "2")
    assert (result.exit_code, result.stdout) == (2, "")
    assert result.stderr == "error: motion scale is given, and asked for\nhint: leave it out\n"


def test_a_motion_that_does_not_move_is_refused(run: Run, tmp_path: Path) -> None:
    file = tmp_path / "still.toml"
    file.write_text(CLAMPED.replace("[4, 1.2]", "[0, 0]"), encoding="utf-8")
    result = run("solve", file, "--speed", "5")
    assert (result.exit_code, result.stdout) == (2, "")
    assert "error: motion" in result.stderr


def test_hopping_is_about_amplitudes(run: Run) -> None:
    result = run("solve", *NUT, "--hopping")
    assert (result.exit_code, result.stdout) == (2, "")
    assert result.stderr.startswith("error: --hopping needs --speed\nhint: ")


def test_a_speed_that_no_amplitude_reaches(run: Run) -> None:
    result = run("solve", *NUT[2:], "--speed", "500")
    assert result.exit_code == 4
    # what the amplitude of the hop limit gives
    best = "no amplitude does it: without hopping it gets about 123.3 mm/s, at 3.229 mm"
    assert result.stdout.splitlines()[-1] == best
    answer = json.loads(run("solve", *NUT[2:], "--speed", "500", "--json").stdout)
    assert (answer["met"], answer["amplitudes"]) == (False, [])


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        (("-a", "0", "--trough-angle", "-20"), "any"),
        (("--mu-s", "0", "--mu-d", "0"), "it moves forwards only where it hops, if at all"),
        (("--trough-angle", "-55"), "it has no steady motion without hopping"),
        (("--trough-angle", "29"), "without hopping it moves backwards, about 193.3 mm/s at 2.824 mm\n"),
        (("-a", "0"), "without hopping it does not move"),
        (("-a", "0", "--hopping"), "none: the trough does not move normal to itself"),
    ],
)
def test_speeds_of_odd_scenes(run: Run, changes: tuple[str, ...], said: str) -> None:
    result = run("solve", *NUT[2:], *changes, "--speed", "5")
    assert result.exit_code == (0 if said == "any" else 4)
    assert said in result.stdout


def test_an_amplitude_is_not_given_where_it_is_asked_for(run: Run) -> None:
    for option in ("-A", "--stroke"):
        result = run("solve", *NUT[2:], option, "1", "--speed", "20")
        assert (result.exit_code, result.stdout) == (2, "")
        assert "is given, and asked for" in result.stderr
    scene = Path(__file__).parents[2] / "examples" / "safety_nut.toml"  # whose own amplitude does not count
    assert json.loads(run("solve", scene, "--speed", "28.15", "--json").stdout)["met"]
    result = run("solve", "--speed", "20")
    assert result.exit_code == 2
    assert "amplitude" not in result.stderr


@each("more", [("--coexist",), ("-o", "x"), ("--stand-ratio", "1"), ("--flight", "off")])
def test_amplitudes_take_no_other_options(run: Run, more: tuple[str, ...]) -> None:
    result = run("solve", *NUT[2:], "--speed", "20", *more)
    assert result.exit_code == 2
    assert f"{more[0]} cannot be used with it" in result.stderr
    assert run("solve", *NUT[2:], "--speed", "0").exit_code == 2
    assert run("solve", *NUT[2:], "--speed", "20Hz").exit_code == 2
