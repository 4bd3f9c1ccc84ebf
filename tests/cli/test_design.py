"""``vibro design``: what it prints and writes, and how it ends. What it finds is tested elsewhere."""

from __future__ import annotations

import contextlib
import json
import os
import re
import subprocess
import sys
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import pytest
from helpers.cases import each
from helpers.commands import Run, rows_of
from helpers.questions import answered

import vibro
from vibro.files.toml_files import read_toml
from vibro.inverse import designs as designs_module
from vibro.results.designs import Design, DesignResult

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    from vibro.inverse.specs import Spec


class Asked(NamedTuple):
    """A question, as the search for its answer takes it."""

    spec: Spec
    digits: int
    goal_only: bool


QUESTION = """
[scene]
static_friction = "0.7:0.78"
kinetic_friction = "0.5:0.6"
trough_length_mm = 600
[[drive]]
name = "motor"
amplitude_mm = 3
frequency_hz = "10:30"
drive_angle_deg = "5:45"
acceleration_g = 4
[[drive]]
name = "magnet"
amplitude_mm = 0.8
frequency_hz = "50,100"
drive_angle_deg = 20
[drift]
amplitude_percent = 5
[goal]
speed_mm_s = 30
highest_regime = "forward-slip"
"""
SAFEST = Design(
    drive="motor",
    highest_regime="forward-slip",
    design="safest",
    amplitude_mm=2.80763335,
    frequency_hz=10.0,
    drive_angle_deg=45.0,
    acceleration_g=1.129883,
    speed_min_mm_s=45.29399999,
    speed_proved_mm_s=45.25,
    speed_nominal_mm_s=48.45,
    speed_max_mm_s=51.89570001,
    traverse_time_max_s=13.2468,
    amplitude_low_mm=2.46843701,
    amplitude_high_mm=3.0,
    low_set_by="speed",
    high_set_by="limit",
    margin=7.39704,
    throw_number_max=0.798944,
    set_by="back slip",
    proof="corners",
    coexists=False,
    excluded=0,
)


def rows(drive: str, regime: str, **known: Design) -> list[Design]:
    """Return the three designs of a drive and a regime; those that are not known have no numbers."""
    found = []
    for kind in ("gentlest", "fastest", "safest"):
        row: dict[str, Any] = {"drive": drive, "highest_regime": regime, "design": kind}
        found.append(replace(known[kind], **row) if kind in known else Design(**row))
    return found


def answer(*, met: bool) -> DesignResult:
    """Return an answer as the optimisers give them: the motor meets the goal, or no drive does."""
    slow = replace(
        SAFEST, speed_min_mm_s=4.649, margin=None, frequency_needed_hz=2.9, amplitude_needed_mm=30.4,
        amplitude_low_mm=None, amplitude_high_mm=None, low_set_by=None, high_set_by=None,
    )  # fmt: skip
    all_three = {"gentlest": SAFEST, "fastest": SAFEST, "safest": SAFEST}
    hopping = replace(
        SAFEST,
        speed_min_mm_s=228.0,
        set_by="limit",
        margin=12.0,
        proof="sampled",
        coexists=True,
        excluded=7,
        samples=2000,
        speed_proved_mm_s=None,
    )
    found = [
        *rows("motor", "forward-slip", **(all_three if met else {"fastest": slow})),
        *rows("magnet", "forward-slip"),
        *rows("motor", "back-slip", fastest=replace(slow, speed_min_mm_s=6.22, proof="searched")),
        *rows("motor", "hopping", gentlest=hopping, fastest=hopping, safest=hopping),
        *rows("magnet", "back-slip"),
        *rows("magnet", "hopping"),
    ]
    return answered(met, *found)


def found(monkeypatch: pytest.MonkeyPatch, result: DesignResult) -> list[Asked]:
    """Have every question answered so; return the list of those that are asked."""
    asked: list[Asked] = []

    def find(
        spec: Spec, tell: Callable[[int, int, str], None], *, digits: int, goal_only: bool
    ) -> DesignResult:
        asked.append(Asked(spec, digits, goal_only))
        for done in (0, 4, 18):
            tell(done, 18, "motor: gentlest, forward-slip at most")
        kept = [d for d in result.designs if not goal_only or d.highest_regime == "forward-slip"]
        return answered(result.met, *kept)

    monkeypatch.setattr(designs_module, "find_designs", find)
    return asked


@pytest.fixture(autouse=True)
def coarse() -> Iterator[None]:
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("vibro.plots.settings._RESOLVED", 41)
        patch.setattr("vibro.inverse.pictured._POINTS", {False: 41, True: 41})
        yield


@pytest.fixture
def ask(run: Run, monkeypatch: pytest.MonkeyPatch) -> Callable[..., Any]:
    """Ask the question of ``nut.toml``, in a folder of its own."""
    Path("nut.toml").write_text(QUESTION, encoding="utf-8")

    def invoke(*args: object, met: bool = True) -> Any:
        found(monkeypatch, answer(met=met))
        return run("design", "nut.toml", *args)

    return invoke


def squeezed(text: str) -> list[str]:
    return [" ".join(line.split()) for line in text.splitlines()]


def test_the_report_of_a_goal_that_is_met(ask: Callable[..., Any]) -> None:
    result = ask()
    assert (result.exit_code, result.stderr) == (0, "")
    lines = squeezed(result.stdout)
    assert lines[0] == "goal at least 30 mm/s for every part, 600 mm in 20 s; forward-slip at most"
    assert lines[1] == "met by motor"
    assert lines[2] == "parts static friction 0.7 ... 0.78, kinetic friction 0.5 ... 0.6"
    assert lines[4] == "drift amplitude +- 5 %"
    limits = "amplitude up to 3 mm, frequency 10 ... 30 Hz, drive angle 5 ... 45 deg, acceleration up to 4 g"
    head = lines.index(f"motor: {limits}")
    # Every digit of a setting; a guarantee is never rounded up, nor what no part exceeds rounded down.
    setting = "2.80763335 10 45 1.12989 45.2939 45.25 48.45 51.8958 7.39704 back slip corners"
    assert lines[head + 3 : head + 5] == ["forward-slip at most (the goal)", f"gentlest {setting}"]
    magnet = lines.index("magnet: amplitude up to 0.8 mm, frequency 50 Hz or 100 Hz, drive angle 20 deg")
    assert lines[magnet + 1] == "forward-slip at most (the goal): no speed is guaranteed"
    # the answer comes first, and then what nobody asked for
    others = lines.index("Other regimes than the goal's, for comparison (--only goal leaves them out):")
    assert head < magnet < lines.index("1 % more changes the nominal speed by") < others
    assert all(i > others for i, line in enumerate(lines) if line.startswith(("back-slip", "hopping")))
    assert lines[others + 2] == "motor"
    assert lines[others + 5] == "back-slip at most: less than 30 mm/s"
    assert lines[others + 6].startswith("fastest 2.80763335 10 45 1.12989 6.22 ")
    assert lines[others + 7] == "hopping allowed"
    assert "chosen motor, safest with forward-slip at most: 2.80763335 mm, 10 Hz, 45 deg" in lines
    window = "2.46844 ... 3 mm keep the goal; below, the slowest part gets too slow; above, the drive ends"
    assert f"amplitude {window}" in lines
    assert "margin 7.39704: all bands and drifts may be that many times as wide" in lines
    assert "traverse time at most 13.2468 s" in lines
    assert "load now / load at which" in lines
    for name in ("the first part slips back", "the first part hops", "the last part starts"):
        assert any(line.startswith(name) for line in lines)
    costs = lines[lines.index("1 % more changes the nominal speed by") + 1 :]
    assert costs[0].startswith("amplitude +")
    assert costs[5].startswith("trough angle, 1 deg more -")
    assert any(line.startswith("sampled: ") for line in lines)
    chance = "one drawn at random is with a chance of at most 0.15 % (confidence 95 %)"
    assert f"samples: of 2000 hopping parts, spread evenly, none is slower: {chance}" in lines
    settles = "disturbed parts can settle into another motion than those from rest: motor, hopping, gentlest"
    assert any(line.startswith(settles) for line in lines)
    assert any(
        line.startswith("samples without a speed are left out, up to 7 of: motor, hop") for line in lines
    )


def test_the_report_of_a_goal_that_no_drive_meets(ask: Callable[..., Any]) -> None:
    result = ask(met=False)
    assert (result.exit_code, result.stderr) == (4, "")
    lines = squeezed(result.stdout)
    assert lines[1] == "met by no drive"
    head = (
        "largest guaranteed forward-slip at most set by back-slip hopping nearest drive that meets the goal"
    )
    first = lines.index(head)
    assert lines[first + 1] == "motor 4.649 mm/s back slip 6.22 mm/s 228 mm/s 2.9 Hz, 30.4 mm at 45 deg"
    assert lines[first + 2] == "magnet nothing - nothing nothing -"
    assert "forward-slip at most (the goal): less than 30 mm/s" in lines
    assert any(line.startswith("closest motor, fastest with forward-slip at most: ") for line in lines)
    assert "amplitude none keeps the goal" in lines
    assert "margin none: even without bands the goal is missed" in lines


def test_the_report_of_an_ellipse(run: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    drive = """
along_amplitude_mm = "0.2:1"
normal_amplitude_mm = 0.3
normal_phase_deg = "-180:180"
frequency_hz = 25
"""
    text = (
        QUESTION[: QUESTION.index("amplitude_mm = 3")]
        + drive.lstrip()
        + QUESTION[QUESTION.index("[drift]") :]
    )
    Path("bowl.toml").write_text(
        text.replace("percent = 5", "percent = 5\nnormal_phase_deg = 2"), encoding="utf-8"
    )
    design = replace(
        SAFEST, amplitude_mm=None, drive_angle_deg=None, along_amplitude_mm=0.9, normal_amplitude_mm=0.3,
        normal_phase_deg=-58.5, frequency_hz=25.0, amplitude_low_mm=0.7, amplitude_high_mm=1.0,
    )  # fmt: skip
    found(monkeypatch, answered(True, *rows("motor", "forward-slip", safest=design, gentlest=design)))
    result = run("design", "bowl.toml", "-o", "bowl")
    assert (result.exit_code, "met by motor" in squeezed(result.stdout)) == (0, True)
    lines = squeezed(result.stdout)
    assert lines[4] == "drift amplitude +- 5 %, phase +- 2 deg"
    limits = "along amplitude 0.2 ... 1 mm, normal amplitude 0.3 mm, normal phase -180 ... 180 deg"
    assert f"motor: {limits}, frequency 25 Hz" in lines
    head = next(i for i, line in enumerate(lines) if line.startswith("along normal phase frequency accel."))
    assert lines[head + 3].startswith("gentlest 0.9 0.3 -58.5 25 1.12989 45.2939")
    setting = "0.9 mm along, 0.3 mm normal, -58.5 deg, 25 Hz"
    assert f"chosen motor, safest with forward-slip at most: {setting}" in lines
    ends = "0.7 ... 1 mm along, the normal one in proportion, keep the goal"
    assert f"amplitude {ends}; below, the slowest part gets too slow; above, the drive ends" in lines
    assert any(line.startswith("normal phase, 1 deg more ") for line in lines)
    table = rows_of(Path("bowl.csv").read_text(encoding="utf-8"))
    assert [name for name in table[0] if "amplitude" in name or "angle" in name or "phase" in name] == [
        "along_amplitude_mm", "normal_amplitude_mm", "normal_phase_deg", "amplitude_low_mm",
        "amplitude_high_mm", "amplitude_needed_mm",
    ]  # fmt: skip
    assert {path.name for path in Path().glob("bowl-*.png")} == {
        f"bowl-{n}.png" for n in ("regime", "speed", "band")
    }


def test_json_is_the_answer_alone(ask: Callable[..., Any]) -> None:
    for met, code in ((True, 0), (False, 4)):
        result = ask("--json", met=met)
        assert (result.exit_code, result.stderr) == (code, "")
        assert json.loads(result.stdout) == answer(met=met).to_dict()
    assert list(Path().iterdir()) == [Path("nut.toml")]


def test_the_files(ask: Callable[..., Any]) -> None:
    result = ask("-o", "out/nut", "--json")
    assert result.exit_code == 0
    names = ["nut.csv", "nut-regime.png", "nut-speed.png", "nut-band.png", "nut.json"]
    assert sorted(path.name for path in Path("out").iterdir()) == sorted(names)
    content = json.loads(Path("out/nut.json").read_text(encoding="utf-8"))
    assert content["version"] == vibro.__version__
    assert content["argv"] == ["vibro", "design", "nut.toml", "-o", "out/nut", "--json"]
    assert content["spec"] == read_toml(Path("nut.toml"))
    assert content["files"] == names
    assert {"met": content["met"], "designs": content["designs"]} == json.loads(result.stdout)
    assert content["columns"]["speed_min_mm_s"] == "mm/s"
    table = rows_of(Path("out/nut.csv").read_text(encoding="utf-8"))
    assert list(table[0]) == [column.name for column in answer(met=True).columns]
    for row, design in zip(table, content["designs"], strict=True):
        for name, value in design.items():
            wanted = "" if value is None else str(int(value)) if isinstance(value, bool | int) else value
            assert row[name] == wanted if isinstance(wanted, str) else float(row[name]) == wanted


def test_the_table_goes_to_stdout(ask: Callable[..., Any]) -> None:
    result = ask("-o", "-", "--decimal-comma")
    assert result.exit_code == 0
    assert result.stdout.splitlines()[1].startswith("motor;forward-slip;gentlest;2,80763335;10;45;")
    assert len(result.stdout.splitlines()) == 19
    assert ask("-o", "-", met=False).exit_code == 4
    assert ask("-o", "-", "--json").exit_code == 2
    assert list(Path().iterdir()) == [Path("nut.toml")]


def test_the_formats_of_pictures(ask: Callable[..., Any]) -> None:
    assert ask("-o", "nut", "--format", "svg,pdf", "-q").exit_code == 0
    assert {path.suffix for path in Path().iterdir()} == {".toml", ".csv", ".json", ".svg", ".pdf"}
    assert ask("--format", "gif").exit_code == 2


def test_where_nothing_is_guaranteed_there_is_nothing_to_draw(
    ask: Callable[..., Any], run: Run, monkeypatch: pytest.MonkeyPatch
) -> None:
    assert ask("-o", "nut").exit_code == 0
    regimes = ("forward-slip", "back-slip", "hopping")
    empty = [d for drive in ("motor", "magnet") for regime in regimes for d in rows(drive, regime)]
    found(monkeypatch, answered(False, *empty))
    result = run("design", "nut.toml", "-o", "nut", "--force")
    assert result.exit_code == 4
    assert sorted(path.name for path in Path().iterdir()) == ["nut.csv", "nut.json", "nut.toml"]
    assert json.loads(Path("nut.json").read_text(encoding="utf-8"))["files"] == ["nut.csv", "nut.json"]
    assert "removed nut-band.png" in result.stderr
    assert "closest" not in result.stdout


def test_files_are_claimed_before_anything_is_computed(
    ask: Callable[..., Any], run: Run, monkeypatch: pytest.MonkeyPatch
) -> None:
    assert ask("-o", "nut").exit_code == 0
    asked = found(monkeypatch, answer(met=True))
    result = run("design", "nut.toml", "-o", "nut")
    assert (result.exit_code, result.stdout, asked) == (1, "", [])
    assert "exist already" in result.stderr


def test_the_question_is_never_overwritten(run: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    Path("nut.csv").write_text(QUESTION, encoding="utf-8")
    asked = found(monkeypatch, answer(met=True))
    result = run("design", "nut.csv", "-o", "nut", "--force")
    assert (result.exit_code, asked) == (1, [])
    assert "this run reads it" in result.stderr
    assert Path("nut.csv").read_text(encoding="utf-8") == QUESTION


def test_a_folder_takes_the_questions_name(ask: Callable[..., Any]) -> None:
    assert ask("-o", f"out{os.sep}").exit_code == 0
    assert Path("out/nut-design.csv").exists()


@pytest.mark.parametrize(
    ("margin", "text"),
    [
        (1.0, "1: all bands and drifts may be that many times as wide"),
        (10.0, "10 or more: all bands and drifts may be that many times as wide"),
        (0.5, "0.5: all bands and drifts would have to shrink to this share"),
    ],
)
def test_the_margin_in_words(
    run: Run, monkeypatch: pytest.MonkeyPatch, margin: float | None, text: str
) -> None:
    Path("nut.toml").write_text(QUESTION, encoding="utf-8")
    design = replace(SAFEST, margin=margin)
    found(monkeypatch, answered(True, *rows("motor", "forward-slip", safest=design, gentlest=design)))
    assert f"margin {text}" in squeezed(run("design", "nut.toml").stdout)


def test_a_margin_below_1_without_drift_is_a_share_to_shrink_to(
    run: Run, monkeypatch: pytest.MonkeyPatch
) -> None:
    Path("nut.toml").write_text(QUESTION.replace("t = 5", "t = 0"), encoding="utf-8")
    design = replace(SAFEST, margin=0.758095, throw_number_max=0.9999)
    found(monkeypatch, answered(True, *rows("motor", "forward-slip", safest=design, gentlest=design)))
    said = squeezed(run("design", "nut.toml").stdout)
    assert "margin 0.758095: all bands and drifts would have to shrink to this share" in said


def known(**changes: str) -> None:
    """Write the question with a single part and no drift to ``known.toml``, with other changes."""
    text = QUESTION.replace('"0.7:0.78"', "0.74").replace('"0.5:0.6"', "0.55").replace("t = 5", "t = 0")
    for old, new in changes.items():
        text = text.replace(f"{old} = 3\n", f"{new}\n")
    Path("known.toml").write_text(text, encoding="utf-8")


def test_where_nothing_is_uncertain_the_gentlest_is_chosen(run: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    """No design is safer than another, and one part has one speed."""
    known()
    gentle = replace(SAFEST, amplitude_mm=2.3, margin=None)
    design = replace(SAFEST, margin=None)
    answer = rows("motor", "forward-slip", gentlest=gentle, fastest=design, safest=design)
    found(monkeypatch, answered(True, *answer))
    lines = squeezed(run("design", "known.toml").stdout)
    head = lines.index("amplitude frequency angle accel. guaranteed set by proof")
    assert lines[head + 2 : head + 5] == [
        "forward-slip at most (the goal)",
        "gentlest 2.3 10 45 1.12989 45.2939 back slip corners",
        "fastest 2.80763335 10 45 1.12989 45.2939 back slip corners",
    ]
    assert not any(line.startswith("safest") for line in lines)
    assert "chosen motor, gentlest with forward-slip at most: 2.3 mm, 10 Hz, 45 deg" in lines
    assert "margin none: no band and no drift is given" in lines


def test_every_cost_has_a_number_or_a_reason(run: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    known()
    for amplitude, last in (
        (2.3, "trough angle, 1 deg more -"),
        (0.01, "trough angle, 1 deg more rests: no"),
    ):
        design = replace(SAFEST, amplitude_mm=amplitude, margin=None)
        found(monkeypatch, answered(True, *rows("motor", "forward-slip", gentlest=design)))
        lines = squeezed(run("design", "known.toml").stdout)
        costs = lines[lines.index("1 % more changes the nominal speed by") + 1 :]
        assert len(costs) >= 6
        assert costs[5].startswith(last)
        assert not any("nan" in line or "unknown" in line for line in costs)


def test_a_question_in_stroke_is_answered_in_stroke(run: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    """And a number that was given is written as it was given."""
    known(amplitude_mm="stroke_mm = 6.00000001")
    sizes: dict[str, Any] = {"amplitude_mm": None, "amplitude_low_mm": None, "amplitude_high_mm": None}
    sizes |= {"stroke_mm": 5.615, "stroke_low_mm": 4.937, "stroke_high_mm": 6.0}
    design = replace(SAFEST, margin=None, **sizes)
    found(monkeypatch, answered(True, *rows("motor", "forward-slip", gentlest=design, fastest=design)))
    lines = squeezed(run("design", "known.toml", "-o", "known").stdout)
    assert lines[6].startswith("motor: stroke up to 6.00000001 mm, frequency 10 ... 30 Hz")
    assert lines[7].startswith("stroke frequency angle")
    assert lines[10].startswith("gentlest 5.615 10 45")
    assert "chosen motor, gentlest with forward-slip at most: 5.615 mm stroke, 10 Hz, 45 deg" in lines
    ends = "4.937 ... 6 mm keep the goal; below, the slowest part gets too slow; above, the drive ends"
    assert f"stroke {ends}" in lines
    costs = lines[lines.index("1 % more changes the nominal speed by") + 1 :]
    assert costs[0].startswith("stroke +")
    assert not any(line.startswith("amplitude") for line in lines if "magnet" not in line)
    table = rows_of(Path("known.csv").read_text(encoding="utf-8"))
    assert [name for name in table[0] if "stroke" in name or "amplitude" in name] == [
        "stroke_mm", "stroke_low_mm", "stroke_high_mm", "stroke_needed_mm",
    ]  # fmt: skip
    assert table[0]["stroke_mm"] == "5.615"


def test_the_nearest_drive_is_told_in_stroke(run: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    known(amplitude_mm="stroke_mm = 6")
    slow = replace(
        SAFEST, amplitude_mm=None, stroke_mm=5.615, speed_min_mm_s=4.649, margin=None,
        frequency_needed_hz=2.9, stroke_needed_mm=60.8,
    )  # fmt: skip
    found(monkeypatch, answered(False, *rows("motor", "forward-slip", fastest=slow)))
    lines = squeezed(run("design", "known.toml", "--only", "goal").stdout)
    assert "motor 4.649 mm/s back slip 2.9 Hz, 60.8 mm stroke at 45 deg" in lines


@pytest.mark.parametrize(
    ("throw", "above"), [(1.0, "the first part hops"), (1.01, "parts hop otherwise, and too slowly")]
)
def test_where_parts_hop_already_the_window_ends_at_other_hops(
    throw: float, above: str, run: Run, monkeypatch: pytest.MonkeyPatch
) -> None:
    known()
    design = replace(SAFEST, throw_number_max=throw, high_set_by="hop")
    found(monkeypatch, answered(True, *rows("motor", "forward-slip", gentlest=design)))
    (window,) = (x for x in squeezed(run("design", "known.toml").stdout) if x.startswith("amplitude 2.46"))
    assert window.endswith(f"; above, {above}")


def test_a_drive_with_one_setting_has_no_window(run: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    known()
    only = replace(
        SAFEST, amplitude_low_mm=2.80763335, amplitude_high_mm=2.80763335, low_set_by="limit",
        high_set_by="limit",
    )  # fmt: skip
    found(monkeypatch, answered(True, *rows("motor", "forward-slip", gentlest=only)))
    lines = squeezed(run("design", "known.toml").stdout)
    assert "amplitude 2.80763335 mm, all that the drive can do, keeps the goal" in lines


@pytest.mark.parametrize("met", [True, False])
def test_other_regimes_can_be_left_out(
    met: bool, ask: Callable[..., Any], run: Run, monkeypatch: pytest.MonkeyPatch
) -> None:
    asked = found(monkeypatch, answer(met=met))
    result = run("design", "nut.toml", "--only", "goal", "-o", "nut")
    assert result.exit_code == (0 if met else 4)
    assert [call.goal_only for call in asked] == [True]
    assert not any(word in result.stdout for word in ("hopping", "back-slip", "Other regimes"))
    if not met:
        head = "largest guaranteed forward-slip at most set by nearest drive that meets the goal"
        assert head in squeezed(result.stdout)
    table = rows_of(Path("nut.csv").read_text(encoding="utf-8"))
    designs = json.loads(Path("nut.json").read_text(encoding="utf-8"))["designs"]
    for written in (table, designs):
        assert {row["highest_regime"] for row in written} == {"forward-slip"}
        assert len(written) == 6
    assert run("design", "nut.toml", "--only", "hopping").exit_code == 2


@pytest.mark.parametrize(("typed", "digits"), [((), 4), (("--digits", 9), 9), (("--digits", 15), 15)])
def test_the_digits_of_settings(
    typed: tuple[Any, ...], digits: int, ask: Callable[..., Any], run: Run, monkeypatch: pytest.MonkeyPatch
) -> None:
    asked = found(monkeypatch, answer(met=True))
    assert run("design", "nut.toml", *typed).exit_code == 0
    assert [(call.digits, call.goal_only) for call in asked] == [(digits, False)]


@each("typed", ["0", "16", "4.5", "few"])
def test_a_wrong_number_of_digits_is_refused(
    typed: str, ask: Callable[..., Any], run: Run, monkeypatch: pytest.MonkeyPatch
) -> None:
    asked = found(monkeypatch, answer(met=True))
    result = run("design", "nut.toml", "--digits", typed)
    assert (result.exit_code, result.stdout, asked) == (2, "", [])
    assert "--digits" in result.stderr


def test_a_bar_says_what_is_searched(
    ask: Callable[..., Any], run: Run, monkeypatch: pytest.MonkeyPatch
) -> None:
    """On a terminal; elsewhere nothing but the answer is written."""
    told: list[tuple[Any, ...]] = []

    @contextlib.contextmanager
    def progress(self: Any, label: str, total: int | None) -> Iterator[Callable[..., None]]:
        told.append((label, total))
        yield lambda *done: told.append(done)

    monkeypatch.setattr("vibro.cli.console.Console.progress", progress)
    assert ask("-o", "nut").exit_code == 0
    what = "motor: gentlest, forward-slip at most"
    assert told == [
        ("searching", None), (0, what, 18), (4, what, 18), (18, what, 18), ("drawing", None),
    ]  # fmt: skip


def test_what_is_wrong_ends_before_anything_is_computed(run: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    asked = found(monkeypatch, answer(met=True))
    Path("bad.toml").write_text(QUESTION.replace("speed_mm_s = 30", "speed_mm_s = 0"), encoding="utf-8")
    result = run("design", "bad.toml", "-o", "bad")
    assert (result.exit_code, result.stdout, asked) == (2, "", [])
    assert "speed_mm_s" in result.stderr
    assert run("design", "none.toml").exit_code == 1
    assert run("design").exit_code == 2
    assert list(Path().iterdir()) == [Path("bad.toml")]


@pytest.mark.skipif(sys.platform == "win32", reason="Windows has no pseudo-terminals")
def test_a_terminal_shows_how_far_a_search_is(tmp_path: Path) -> None:
    """The bar names the search and is drawn again and again, while the answer alone goes to stdout."""
    import pty

    question = tmp_path / "known.toml"
    drive = '[[drive]]\nname = "motor"\namplitude_mm = 3\nfrequency_hz = 15\ndrive_angle_deg = 25\n'
    scene = '[scene]\nstatic_friction = "0.7:0.78"\nkinetic_friction = 0.57\n'
    question.write_text(f"{scene}{drive}[goal]\nspeed_mm_s = 10\n", encoding="utf-8")
    terminal, end = pty.openpty()
    with subprocess.Popen(
        [sys.executable, "-m", "vibro", "design", str(question)],
        stdout=subprocess.PIPE, stderr=end, env={**os.environ, "TERM": "xterm", "COLUMNS": "100"},
    ) as process:  # fmt: skip
        os.close(end)
        shown = b""
        while True:
            try:
                piece = os.read(terminal, 4096)
            except OSError:  # Linux: the other end is closed
                break
            if not piece:
                break
            shown += piece
        assert process.stdout is not None
        answer = process.stdout.read()
    os.close(terminal)
    assert process.returncode == 0
    assert answer.startswith(b"goal  ")
    # what is over within a tenth of a second may not be drawn
    assert re.search(rb"motor: (fastest|gentlest|safest), hopping allowed", shown)
    assert b"0:00:0" in shown
    assert shown.count(b"0:00:0") > 3  # each is the bar, drawn anew


def test_help_has_the_options_that_apply_alone(run: Run) -> None:
    text = run("design", "--help").stdout
    for option in (
        "--only",
        "--digits",
        "-o",
        "--json",
        "--format",
        "--excel",
        "--decimal-comma",
        "--force",
        "-q",
        "--debug",
    ):
        assert option in text
    for option in ("-A", "--mu-s", "--length", "SCENE.toml", "--flight"):
        assert option not in text
