"""Tables of keys in scene-files.md and design-files.md of docs/reference, from the description of files.

python docs/ext/key_tables.py    # writes them into the pages
"""

from __future__ import annotations

from pathlib import Path

from vibro.files.descriptions import DESIGN_FILE, SCENE_FILE, FileKind
from vibro.files.entries import Entry

REFERENCE = Path(__file__).parents[1] / "reference"
PAGES = {"scene-files.md": SCENE_FILE, "design-files.md": DESIGN_FILE}
HEAD = "| key | what | value |\n|---|---|---|\n"
OF_MAP = "Keys of `[scene]` but lists, and `[machine]`'s bands: each a number, a list or an axis.\n"
SHARED = """
A machine has the other keys of `[machine]`, and a given motion those of `[motion]`, as in
[scene files](scene-files.md).
"""
LARGE = 1e8  # [1] a limit of this size keeps arithmetic finite; the pages' first words have all of them


def _range(entry: Entry) -> str:
    """Say which numbers are allowed; nothing of what most keys allow: all above 0."""
    form, allowed = entry.form, entry.quantity.allowed
    is_number = "line" not in form.spellings and not form.words
    if not is_number or allowed.high < LARGE:
        return allowed.text(entry.quantity.unit).removeprefix("finite and ") if is_number else ""
    if allowed.low > 0.0:
        return "" if allowed.low < 1.0 else f"{allowed.low:g} or more"
    if allowed.low < 0.0:
        return "" if form.rows[1] else "any sign"
    return "0 or more"


def _cells(entry: Entry) -> tuple[str, str]:
    """Return what a key means, and its value with what stands for it where it is left out."""
    form, span = entry.form.says, _range(entry)
    value = span if form == "number" else f"{form}{f', {span}' if span else ''}"
    usual = entry.usual
    if usual and not usual.startswith(("needed", "no")):
        usual = f"default {usual}"
    return entry.quantity.meaning, "; ".join(filter(None, (value, usual)))


def _rows(entries: dict[str, Entry]) -> list[str]:
    """Make the rows of a table; a key along the trough and the same normal to it share one."""
    rows: list[str] = []
    for key, entry in entries.items():
        meaning, *others = _cells(entry)
        keys, twin = [key], key.replace("along_", "normal_", 1)
        normal = _cells(entries[twin]) if twin != key and twin in entries else None
        if normal and normal[1:] == tuple(others):
            keys = [key, twin]
        if not any(f"`{key}`" in row for row in rows):
            cells = ("<br>".join(f"`{name}`" for name in keys), meaning, *others)
            rows.append(f"|{'|'.join(f' {cell} ' if cell else ' ' for cell in cells)}|\n")
    return rows


def tables_of(file: FileKind) -> str:
    """Make a table of the keys of each table of a file; designs' without what scenes' say alike."""
    parts, known = [], set()
    if file is DESIGN_FILE:
        known = {row for name in ("machine", "motion") for row in _rows(SCENE_FILE.tables[name].entries)}
    for table in file.tables.values():
        rows = _rows(table.entries)
        shared = SHARED if known & {*rows} else ""
        keys = HEAD + "".join(row for row in rows if row not in known) + shared
        meaning = f"{table.meaning[:1].upper()}{table.meaning[1:]}"
        parts.append(f"## `{table.heading}`\n\n{meaning}.\n\n{OF_MAP if table.heading == '[map]' else keys}")
    return "\n".join(parts)


def page_with(name: str) -> str:
    """Put the tables into their page, after its first words."""
    page = (REFERENCE / name).read_text(encoding="utf-8")
    return page[: page.index("## ")] + tables_of(PAGES[name])


if __name__ == "__main__":
    for name in PAGES:
        (REFERENCE / name).write_text(page_with(name), encoding="utf-8")
