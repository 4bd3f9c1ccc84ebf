"""``vibro explore``: its options, its messages, and where the page goes."""

from __future__ import annotations

import json
import re
import sys
import webbrowser
from pathlib import Path
from typing import TYPE_CHECKING, Any
from urllib.parse import urlsplit
from urllib.request import url2pathname

import pytest
from helpers.made_records import EXAMPLES

from vibro.cli import explore
from vibro.explore.scenes import file_name

if TYPE_CHECKING:
    from helpers.commands import Run

SCENE = str(EXAMPLES / "safety_nut.toml")


@pytest.fixture(autouse=True)
def _folder(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """Let temporary folders lie in one that ends with the test, and no browser be found."""
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    monkeypatch.setattr(explore, "_SNAPS", tmp_path / "none")
    for name in explore._SCREENS:
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setattr(sys, "platform", "linux")


@pytest.fixture
def opened(monkeypatch: pytest.MonkeyPatch) -> list[Path]:
    """The files that a browser is opened with."""
    pages: list[Path] = []

    def open_(address: str) -> bool:
        pages.append(Path(url2pathname(urlsplit(address).path)))
        return True

    monkeypatch.setattr(webbrowser, "open", open_)
    monkeypatch.setenv("BROWSER", "firefox")
    return pages


def scenes_of(page: str) -> list[dict[str, Any]]:
    found = re.search('<script type="application/json" id="data">(.*?)</script>', page)
    assert found
    scenes: list[dict[str, Any]] = json.loads(found[1])["scenes"]
    return scenes


def test_a_browser_is_opened_with_a_file_that_people_recognise(
    run: Run, opened: list[Path], tmp_path: Path
) -> None:
    result = run("explore", SCENE, "-A", "2", "-f", "10:40:log")
    (page,) = opened
    assert (result.exit_code, result.stdout, result.stderr) == (0, f"{page}\n", "")
    assert page.name == "vibro-safety_nut.html"
    assert page.parent.parent == tmp_path
    assert page.parent.name.startswith("vibro-")
    (scene,) = scenes_of(page.read_text(encoding="utf-8"))
    state = scene["state"]
    assert (scene["name"], state["amplitude_mm"], state["x"], state["x_range"]) == (
        "safety_nut", "2", "frequency_hz", "10:40:log",
    )  # fmt: skip


def test_without_a_scene_it_begins_with_the_nut(run: Run, opened: list[Path]) -> None:
    run("explore")
    run("explore")
    assert [page.name for page in opened] == 2 * ["vibro-nut.html"]
    assert opened[0] != opened[1]  # one does not replace the other
    (scene,) = scenes_of(opened[0].read_text(encoding="utf-8"))
    assert (scene["name"], scene["state"]["drive"]) == ("", "line")


def test_a_page_is_kept_where_o_says(run: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(webbrowser, "open", None)  # nothing is opened
    monkeypatch.setenv("BROWSER", "firefox")
    result = run("explore", SCENE, "-o", "out/nut.html")
    assert (result.exit_code, result.stdout, result.stderr) == (0, "", "wrote out/nut.html\n")
    page = Path("out/nut.html").read_text(encoding="utf-8")
    assert page.startswith("<!doctype html>\n")
    refused = run("explore", SCENE, "-o", "out/nut.html")
    assert (refused.exit_code, "exists" in refused.stderr) == (1, True)
    assert run("explore", SCENE, "-A", "2", "-o", "out/nut.html", "--force", "-q").stderr == ""
    assert Path("out/nut.html").read_text(encoding="utf-8") != page
    assert run("explore", SCENE, "-o", "out/").stderr == "wrote out/vibro-safety_nut.html\n"
    assert run("explore", SCENE, "-o", "-").stdout == page
    assert sorted(path.name for path in Path("out").iterdir()) == ["nut.html", "vibro-safety_nut.html"]


def test_without_a_browser_it_is_said_where_the_page_is(run: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(webbrowser, "open", None)  # Python would start one that draws text into the terminal
    result = run("explore", SCENE)
    assert (result.exit_code, result.stderr) == (0, "no browser could be opened: open this file in one\n")
    assert Path(result.stdout.strip()).is_file()
    monkeypatch.setattr(webbrowser, "open", lambda _: False)
    monkeypatch.setenv("DISPLAY", ":0")
    assert run("explore", SCENE).stderr == "no browser could be opened: open this file in one\n"


def test_browsers_in_a_sandbox_find_the_page(
    run: Run, opened: list[Path], monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    """They see the home folder alone."""
    (snaps := tmp_path / "snap").mkdir()
    (downloads := tmp_path / "home" / "Downloads").mkdir(parents=True)
    monkeypatch.setattr(explore, "_SNAPS", snaps)
    for name in ("HOME", "USERPROFILE"):
        monkeypatch.setenv(name, str(tmp_path / "home"))
    run("explore", SCENE)
    assert opened[0].parent.parent == downloads


def test_a_full_disk_is_told(run: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    def full(*_: object, **__: object) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("tempfile.mkdtemp", full)
    result = run("explore", SCENE)
    assert result.exit_code == 1
    said = "error: cannot write a temporary file: No space left on device\n"
    assert result.stderr == f"{said}hint: -o nut.html writes it elsewhere\n"


@pytest.mark.parametrize("name", ["a/b", "\u00fc <b>", "..", "a" * 200, "-"])
def test_the_files_name_is_one_that_every_system_takes(name: str) -> None:
    assert re.fullmatch(r"vibro-[0-9A-Za-z_.-]{1,60}", file_name([name]))
    assert file_name([]) == "vibro-nut"
