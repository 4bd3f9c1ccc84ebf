"""Tables of keys in files.md and design.md of docs/guide, made from the description of both kinds of file.

python tests/helpers/key_tables.py    # writes them into the pages
"""

from __future__ import annotations

import re
from pathlib import Path

from vibro.files.descriptions import DESIGN_FILE, SCENE_FILE, FileKind
from vibro.files.entries import Entry

DOCS = Path(__file__).parents[2] / "docs" / "guide"
PAGES = {"files.md": SCENE_FILE, "design.md": DESIGN_FILE}
HEAD = "| table | key | what | range | form | where it is left out |\n|---|---|---|---|---|---|\n"


def _row(heading: str, key: str, entry: Entry) -> str:
    quantity, form = entry.quantity, entry.form
    is_number = "line" not in form.spellings and not form.words
    allowed = quantity.allowed.text(quantity.unit).removeprefix("finite and ") if is_number else ""
    cells = (heading, f"`{key}`", quantity.meaning, allowed, form.says, entry.usual)
    return f"|{'|'.join(f' {cell} ' if cell else ' ' for cell in cells)}|\n"


def table_of(file: FileKind) -> str:
    """Make the table of all keys; of [map] in one row, as it has those of [scene] that are single numbers."""
    rows = []
    for table in file.tables.values():
        if table.heading == "[map]":
            rows.append(
                "| `[map]` | those of `[scene]` but lists | what is swept | the same"
                " | number, list or axis | |\n"
            )
            continue
        for i, (key, entry) in enumerate(table.entries.items()):
            rows.append(_row("" if i else f"`{table.heading}`", key, entry))
    return HEAD + "".join(rows)


def page_with(name: str) -> str:
    """Put the table into its page."""
    page = (DOCS / name).read_text(encoding="utf-8")
    return re.sub(r"\| table \| key \|.*?\n(?=\n)", lambda _: table_of(PAGES[name]), page, flags=re.DOTALL)


if __name__ == "__main__":
    for name in PAGES:
        (DOCS / name).write_text(page_with(name), encoding="utf-8")
