"""``vibro design``: what it prints and writes, and how it ends. What it finds is tested elsewhere."""

from __future__ import annotations

import json
import re
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest
from helpers.commands import Run, rows_of
from helpers.made_designs import IN_STROKE, QUESTION, answer, found, of_motor
from helpers.questions import answered
from helpers.read_pages import ReadPage

import vibro
from vibro.designs.reading import read_spec
from vibro.files.entries import WORDS
from vibro.files.toml_files import read_toml

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator


pytestmark = pytest.mark.usefixtures("unsaved")


@pytest.fixture(autouse=True)
def coarse() -> Iterator[None]:
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("vibro.plots.design._RESOLVED", 41)
        patch.setattr("vibro.designs.pictured._POINTS", {False: 41, True: 41})
        yield


@pytest.fixture
def ask(run: Run, monkeypatch: pytest.MonkeyPatch) -> Callable[..., Any]:
    """Ask the question of ``nut.toml``, in a folder of its own."""
    Path("nut.toml").write_text(QUESTION, encoding="utf-8")

    def invoke(*args: object, met: bool = True) -> Any:
        found(monkeypatch, answer(met=met))
        return run("design", "nut.toml", *args)

    return invoke


def test_json_is_the_answer_alone(ask: Callable[..., Any]) -> None:
    for met, code in ((True, 0), (False, 4)):
        result = ask("--other-regimes", "--json", met=met)
        assert (result.exit_code, result.stderr) == (code, "")
        found = json.loads(result.stdout)
        assert {key: found[key] for key in ("met", "designs")} == answer(met=met).to_dict()
        assert found["choices"] == [
            {
                "drive": "motor", "amplitude_mm": "at most 3", "frequency_hz": "10:30",
                "drive_angle_deg": "5:45", "acceleration_g": "at most 4",
            },
            {
                "drive": "magnet", "amplitude_mm": "at most 0.8", "frequency_hz": "50, 100",
                "drive_angle_deg": "exactly 20",
            },
        ]  # fmt: skip
        assert found["chosen"] == {"drive": "motor", "design": "safest" if met else "fastest"}
        assert [row["begins"] for row in found["loads"]] == [
            "the first part slips back", "the first part hops", "the last part starts",
        ]  # fmt: skip
        assert all(isinstance(row["nominal_speed_percent"], float) for row in found["costs"])
        assert any(note.startswith("sampled: ") for note in found["notes"])
    assert list(Path().iterdir()) == [Path("nut.toml")]


def test_the_files(ask: Callable[..., Any]) -> None:
    result = ask("--other-regimes", "-o", "out/nut", "-o", "out/nut.html", "--json")
    assert result.exit_code == 0
    names = ["nut.csv", "nut.html", "nut-regime.png", "nut-speed.png", "nut-band.png", "nut.json"]
    assert sorted(path.name for path in Path("out").iterdir()) == sorted(names)
    content = json.loads(Path("out/nut.json").read_text(encoding="utf-8"))
    assert content["version"] == vibro.__version__
    typed = ["design", "nut.toml", "--other-regimes", "-o", "out/nut", "-o", "out/nut.html", "--json"]
    assert content["argv"] == ["vibro", *typed]
    assert content["spec"] == read_toml(Path("nut.toml"))
    assert content["files"] == names
    said = json.loads(result.stdout)
    assert {key: content[key] for key in said} == said
    assert content["columns"]["speed_min_mm_s"] == "mm/s"
    table = rows_of(Path("out/nut.csv").read_text(encoding="utf-8"))
    assert list(table[0]) == [column.name for column in answer(met=True).columns]
    for row, design in zip(table, content["designs"], strict=True):
        for name, value in design.items():
            wanted = "" if value is None else str(int(value)) if isinstance(value, bool | int) else value
            assert row[name] == wanted if isinstance(wanted, str) else float(row[name]) == wanted


def test_the_question_is_never_overwritten(run: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    Path("nut-band.svg").write_text(QUESTION, encoding="utf-8")
    asked = found(monkeypatch, answer(met=True))
    assert (run("design", "nut-band.svg", "-o", "nut.svg", "--force").exit_code, asked) == (1, [])
    assert Path("nut-band.svg").read_text(encoding="utf-8") == QUESTION


def test_a_question_in_stroke_is_answered_in_stroke(run: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    Path("known.toml").write_text(QUESTION.replace("amplitude_mm = 3\n", "stroke_mm = 6\n"), encoding="utf-8")
    found(monkeypatch, of_motor(gentlest=IN_STROKE, fastest=IN_STROKE))
    assert run("design", "known.toml", "-o", "known").exit_code == 0
    table = rows_of(Path("known.csv").read_text(encoding="utf-8"))
    assert [name for name in table[0] if "stroke" in name or "amplitude" in name] == [
        "stroke_mm", "stroke_low_mm", "stroke_high_mm", "stroke_needed_mm",
    ]  # fmt: skip
    assert table[0]["stroke_mm"] == "5.615"


def test_other_regimes_are_searched_on_request(ask: Callable[..., Any]) -> None:
    for more, regimes in (
        ("--all", {"forward-slip"}),
        ("--other-regimes", {"forward-slip", "back-slip", "hopping"}),
    ):
        assert ask(more, "-o", "nut", "--force").exit_code == 0
        table = rows_of(Path("nut.csv").read_text(encoding="utf-8"))
        designs = json.loads(Path("nut.json").read_text(encoding="utf-8"))["designs"]
        for written in (table, designs):
            assert {row["highest_regime"] for row in written} == regimes
            assert len(written) == 6 * len(regimes)


def test_the_example_is_a_question_that_says_how_much_its_numbers_bind(run: Run) -> None:
    result = run("design", "--example")
    assert result.exit_code == 0
    assert all(f'= "{word} ' in result.stdout for word in WORDS)
    Path("question.toml").write_text(result.stdout, encoding="utf-8")
    spec = read_spec("question.toml")
    assert [drive.name for drive in spec.drives] == ["magnet", "unbalance motor"]
    assert not spec.doubts()


@pytest.mark.parametrize("met", [True, False])
def test_the_page(met: bool, run: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    name = 'name = "a <i>magnet</i>"'
    Path("nut.toml").write_text(QUESTION.replace('name = "motor"', name), encoding="utf-8")
    named = [replace(d, drive=d.drive.replace("motor", "a <i>magnet</i>")) for d in answer(met=met).designs]
    found(monkeypatch, answered(met, *named))
    result = run("design", "nut.toml", "-o", "nut.html", "-q")
    assert (result.exit_code, result.stderr) == (0 if met else 4, "")
    read = ReadPage(Path("nut.html").read_text(encoding="utf-8"))
    assert read.row("met by") == ["a <i>magnet</i>" if met else "no drive"]
    ((least, per_minute),) = re.findall(
        r"at least ([\d.]+) mm/s \(([\d.]+) m/min\)", read.row("every part")[0]
    )
    assert float(per_minute) == pytest.approx(0.06 * float(least), rel=1e-3)
    assert ("nearest drive" in read.text) is not met
    assert "amplitude at most 3 mm, frequency 10:30 Hz, drive angle 5:45 deg" in read.text
    assert any('amplitude_mm = "at most 0.8"' in cell for row in read.rows for cell in row)
    assert "i" not in read.tags
    assert read.tags.count("figure") == 2
