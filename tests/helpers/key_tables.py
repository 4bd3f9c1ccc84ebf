"""Tables of keys in scene-files.md and design-files.md of docs/reference, from the description of files.

python tests/helpers/key_tables.py    # writes them into the pages
"""

from __future__ import annotations

from pathlib import Path

from vibro.files.descriptions import DESIGN_FILE, SCENE_FILE, FileKind
from vibro.files.entries import Entry

REFERENCE = Path(__file__).parents[2] / "docs" / "reference"
PAGES = {"scene-files.md": SCENE_FILE, "design-files.md": DESIGN_FILE}
HEAD = "| key | what | range | form | where it is left out |\n|---|---|---|---|---|\n"
OF_MAP = "Keys of `[scene]` but lists, and `[machine]`'s bands: each a number, a list or an axis.\n"


def _row(key: str, entry: Entry) -> str:
    quantity, form = entry.quantity, entry.form
    is_number = "line" not in form.spellings and not form.words
    allowed = quantity.allowed.text(quantity.unit).removeprefix("finite and ") if is_number else ""
    cells = (f"`{key}`", quantity.meaning, allowed, form.says, entry.usual)
    return f"|{'|'.join(f' {cell} ' if cell else ' ' for cell in cells)}|\n"


def tables_of(file: FileKind) -> str:
    """Make a table of the keys of each table of a file; [map] has those of other tables."""
    parts = []
    for table in file.tables.values():
        rows = (_row(key, entry) for key, entry in table.entries.items())
        keys = OF_MAP if table.heading == "[map]" else HEAD + "".join(rows)
        meaning = f"{table.meaning[:1].upper()}{table.meaning[1:]}"
        parts.append(f"## `{table.heading}`\n\n{meaning}.\n\n{keys}")
    return "\n".join(parts)


def page_with(name: str) -> str:
    """Put the tables into their page, after its first words."""
    page = (REFERENCE / name).read_text(encoding="utf-8")
    return page[: page.index("## ")] + tables_of(PAGES[name])


if __name__ == "__main__":
    for name in PAGES:
        (REFERENCE / name).write_text(page_with(name), encoding="utf-8")
