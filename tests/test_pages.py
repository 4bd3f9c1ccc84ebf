"""What the build of the site and .ci/run do with the commands of pages, and files that pages name."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from commands import DOCS, pages, run_page


def test_a_wrong_output_and_a_command_that_fails_are_noticed(tmp_path: Path) -> None:
    names = [page.relative_to(DOCS.parent).as_posix() for page in pages()]
    assert {"README.md", "docs/index.md", "docs/guide/tour.md", "docs/guide/measure.md"} < {*names}
    assert len({page.stem for page in pages()}) == len(names)  # each has a folder
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
    page.write_text(
        "<!-- exit code 4 -->\n```console\n$ echo said >&2; exit 4\nsaid\n```\n", encoding="utf-8"
    )
    run_page(page, tmp_path / "page")


def test_every_file_that_a_page_names_exists() -> None:
    written = [path for path in DOCS.rglob("*.md") if "_made" not in path.parts]
    for page in (DOCS.parent / "README.md", *written):
        text = page.read_text(encoding="utf-8")
        links = [link for link in re.findall(r"\]\((?!\w+:)([^)#\s]+)", text) if "_made/" not in link]
        named = re.findall(r"`((?:docs|examples|benchmarks|tests|src|tools)/[\w./-]+)`", text)
        lost = [link for link in links if not (page.parent / link).exists()]
        assert not [*lost, *(name for name in named if not (DOCS.parent / name).exists())], page
