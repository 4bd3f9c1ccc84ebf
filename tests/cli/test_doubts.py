"""Values that are possible but likely slips of units are questioned on stderr, once a run."""

from __future__ import annotations

from pathlib import Path

import pytest
from helpers.cases import each
from helpers.commands import FRICTION, NUT, Run

EXAMPLES = Path(__file__).parents[2] / "examples"
REST = ("-a", "20", *FRICTION)
LOAD = "acceleration = 3260 g is above what is usual, 20 g: is the amplitude in um (800um)"
SENSORS = ("--trough-along", "Trog längs", "--trough-normal", "Trog normal", "--sensitivity", "100mV/g")
RPM = "frequency = 3000 Hz is above what is usual, 1000 Hz: for revolutions a minute write 3000rpm"


def warnings(stderr: str) -> list[str]:
    return [line.removeprefix("warning: ") for line in stderr.splitlines() if line.startswith("warning: ")]


@each(
    ("args", "expected"),
    [
        (("-A", "1", "-f", "900", *REST), LOAD),
        (("--along", "1", "--normal", "0", "-f", "900", *FRICTION), LOAD),
        (("-A", "1", "-f", "3000", *REST), RPM),
        (("-A", "800", "-f", "15", *REST), "amplitude = 800 mm is above what is usual, 100 mm"),
        (("--stroke", "800", "-f", "15", *REST), "stroke = 800 mm is above what is usual, 200 mm"),
        (("-A", "0.001", "-f", "15", *REST), "amplitude = 0.001 mm is below what is usual, 0.002 mm"),
        (("-A", "1", "-f", "15", "-a", "0.35", *FRICTION), "drive angle = 0.35 deg is below what is usual"),
        (("-A", "1", "-f", "15", "-a", "20", "--mu-s", "74", "--mu-ratio", "0.8"), "static friction = 74 is"),
        ((*NUT, "--gravity", "9810"), "gravity = 9810 m/s^2 is above what is usual, 100 m/s^2"),
    ],
)  # fmt: skip
def test_a_likely_slip_is_questioned_once(run: Run, args: tuple[str, ...], expected: str) -> None:
    result = run("solve", *args)
    assert result.exit_code == 0, result.stderr
    (warning,) = warnings(result.stderr)
    assert warning.startswith(expected)
    assert ": " in warning
    assert run("solve", *args, "-q").stderr == ""


def test_a_size_that_is_asked_for_is_no_slip(run: Run) -> None:
    assert (
        run("solve", "-f", "400", *FRICTION, "--along", "10", "--normal", "1", "--speed", "5m/min").stderr
        == ""
    )


@pytest.mark.parametrize("args", [NUT, (*NUT, "-a", "0"), ("-A", "0.05", "-f", "300", *REST)])
def test_what_is_usual_is_not(run: Run, args: tuple[str, ...]) -> None:
    assert run("solve", *args).stderr == ""


@pytest.mark.parametrize(
    ("axes", "expected"),
    [
        (("-A", "0.001:3:5", "-f", "5:3000:5"), []),  # it runs up to an extreme on purpose
        (("-A", "1:3:5", "-f", "900"), [LOAD]),
        (("-A", "0.1:3:3", "-f", "1500:3000:3"), [RPM.replace("3000", "1500")]),
    ],
)
def test_axes_are_questioned_as_a_whole(run: Run, axes: tuple[str, ...], expected: list[str]) -> None:
    result = run("traverse-time", *axes, *REST, "-L", "600")
    assert result.exit_code == 0
    found = warnings(result.stderr)
    assert len(found) == len(expected)
    assert all(text.startswith(start) for text, start in zip(found, expected, strict=True))


def test_an_axis_of_angles_in_radians(run: Run) -> None:
    result = run("traverse-time", "-A", "1", "-f", "15", "-a", "0:0.5:3", *FRICTION, "-L", "600")
    (warning,) = warnings(result.stderr)
    assert warning.endswith("for radians write 0.5rad")


@each(
    "args",
    [
        ("map", "odd.toml", "-A", "0.5:2:3", "-f", "10:30:3", "-o", "-"),
        ("simulate", "odd.toml"),
        ("traverse-time", "odd.toml"),
        ("report", "odd.toml"),
        ("accuracy", "odd.toml", "--scenes", "2", "-o", "-"),
        ("compare", "odd.toml", EXAMPLES / "data" / "nut_smoothed_600hz.csv"),
        ("motion", "odd.toml", EXAMPLES / "data" / "nut_trough_mv.csv", *SENSORS),
    ],
)
def test_every_command_questions_what_it_reads(run: Run, args: tuple[object, ...]) -> None:
    Path("odd.toml").write_text(
        "[scene]\namplitude_mm = 1\nfrequency_hz = 15\ndrive_angle_deg = 20\nstatic_friction = 74\n"
        "kinetic_friction = 0.5\ntrough_length_mm = 600\n"
    )
    result = run(*args)
    found = [text for text in warnings(result.stderr) if "usual" in text]
    assert found == ["static friction = 74 is above what is usual, 2: for 74 % write 0.74"], result.stderr


def test_what_was_measured_is_no_slip(run: Run) -> None:
    record = EXAMPLES / "data" / "nut_trough_mv.csv"
    result = run("motion", record, *SENSORS[:2], SENSORS[4], SENSORS[5], "-a", "0.5")
    assert warnings(result.stderr)[0].startswith("drive angle = 0.5 deg is below what is usual")
    assert not warnings(run("motion", record, *SENSORS).stderr)


def test_a_question_of_design_is_questioned_too(run: Run) -> None:
    Path("odd.toml").write_text(
        "[scene]\nstatic_friction = 0.4\nkinetic_friction = 0.3\n[[drive]]\nstroke_mm = 1.1\n"
        'frequency_hz = 50\ndrive_angle_deg = "0.2:0.5"\n[goal]\nspeed_mm_s = 1\n'
    )
    result = run("design", "odd.toml", "--only", "goal")
    assert warnings(result.stderr) == [
        "drive angle = 0.5 deg is below what is usual, 1 deg: for radians write 0.5rad"
    ]


def test_the_report_asks_on_its_page_too(run: Run) -> None:
    pytest.importorskip("jinja2")
    text = run("report", *NUT, "-a", "0.35").stdout
    assert "Is this meant? Drive angle = 0.35 deg is below what is usual, 1 deg; for radians" in text
