"""What README and the site show is what happens; .ci/run runs the commands of README and of the tour too."""

from __future__ import annotations

import os
import re
import runpy
from pathlib import Path

import pytest
from commands import BLOCK, DOCS, run_page, tasks
from helpers.drawn import coarse_pictures

README = DOCS.parent / "README.md"
GUIDES = [DOCS / "guide" / name for name in ("machines.md", "measure.md", "restitution.md")]
TOUR = [README, DOCS / "index.md", *sorted(DOCS.glob("guide/tour*.md"))]


@pytest.mark.skipif("VIBRO_SITE" in os.environ, reason="the build of the site has run them")
@pytest.mark.parametrize("page", tasks(), ids=lambda page: page.stem)
def test_commands_of_a_task_print_what_it_shows(page: Path, tmp_path: Path) -> None:
    run_page(page, tmp_path / "page")


@pytest.mark.parametrize("page", GUIDES, ids=lambda page: page.stem)
def test_commands_of_a_guide_print_what_it_shows(page: Path, tmp_path: Path) -> None:
    run_page(page, tmp_path / "page")


@pytest.mark.parametrize("page", TOUR, ids=lambda page: page.stem)
def test_outputs_of_the_tour_are_those_shown_and_its_scripts_run(
    page: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    run_page(page, tmp_path / "page", ["console"])
    monkeypatch.chdir(tmp_path / "page")
    for _, kind, block in BLOCK.findall(page.read_text(encoding="utf-8")):
        if kind == "python":
            script = Path("script.py")
            script.write_text(block, encoding="utf-8")
            with coarse_pictures():
                runpy.run_path(str(script))


def test_a_wrong_output_and_a_command_that_fails_are_noticed(tmp_path: Path) -> None:
    for name, block in {
        "wrong": "```console\n$ echo one\ntwo\n",
        "fails": "```bash\nfalse\n",
        "raises": "```python\n1 / 0\n",
        "another-code": "<!-- exit code 4 -->\n```console\n$ exit 3\n",
    }.items():
        page = tmp_path / f"{name}.md"
        page.write_text(f"{block}```\n", encoding="utf-8")
        with pytest.raises(RuntimeError, match=name):
            run_page(page, tmp_path / name)


def test_a_page_may_show_messages_and_a_named_exit_code(tmp_path: Path) -> None:
    page = tmp_path / "page.md"
    block = "<!-- exit code 4 -->\n```console\n$ echo said >&2; exit 4\nsaid\n```\n"
    page.write_text(block, encoding="utf-8")
    run_page(page, tmp_path / "page")


def test_every_file_that_a_page_names_exists() -> None:
    pages = [path for path in DOCS.rglob("*.md") if "_made" not in path.parts]
    for page in (README, *pages):
        text = page.read_text(encoding="utf-8")
        links = [link for link in re.findall(r"\]\((?!\w+:)([^)#\s]+)", text) if "_made/" not in link]
        named = re.findall(r"`((?:docs|examples|benchmarks|tests|src|tools)/[\w./-]+)`", text)
        lost = [link for link in links if not (page.parent / link).exists()]
        assert not [*lost, *(name for name in named if not (DOCS.parent / name).exists())], page
