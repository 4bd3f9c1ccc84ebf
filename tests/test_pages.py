"""What the site's pages show is what happens: their commands run, and print what is shown."""

from __future__ import annotations

from pathlib import Path

import pytest
from commands import run_page, run_pages


@pytest.mark.parametrize("page", run_pages(), ids=lambda page: page.stem)
def test_commands_of_a_page_print_what_it_shows(page: Path, tmp_path: Path) -> None:
    run_page(page, tmp_path)


def test_a_wrong_output_and_a_command_that_fails_are_noticed(tmp_path: Path) -> None:
    for name, block in {
        "wrong": "console\n$ echo one\ntwo\n",
        "fails": "bash\nfalse\n",
        "raises": "python\n1 / 0\n",
    }.items():
        page = tmp_path / f"{name}.md"
        page.write_text(f"```{block}```\n", encoding="utf-8")
        with pytest.raises(RuntimeError, match=name):
            run_page(page, tmp_path / name)
