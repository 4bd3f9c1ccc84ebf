"""Exports of ``exports.py`` with damage: cut short, bytes changed, cells and rows replaced."""

from __future__ import annotations

import random
from collections.abc import Callable, Iterator, Sequence
from typing import Final

from helpers.exports import Export

_Damage = Callable[[random.Random, bytes], bytes]
_CELLS: Final = (
    "nan", "inf", "-inf", "1e308", "-1e308", "1e400", "1e-320", "", "-", "n/a", "error", "####", "0x1f",
    "12:61:00", "1,2,3", "--5", "٣", "\0", "9" * 400, '"', "'", "1 2", "true", "2031-13-45T99:00:00Z",
)  # fmt: skip


def damaged(exports: Sequence[Export], count: int, seed: int) -> Iterator[Export]:
    """Damage exports in turn, each by a kind of damage and at places drawn at random; names tell which."""
    for i in range(count):
        export = exports[i % len(exports)]
        draw = random.Random(f"{seed} {i}")
        binary = b"\0" in export.content[:400]
        name = draw.choice([*_BYTES] if binary else [*_BYTES, *_ROWS])
        content = (_BYTES | _ROWS)[name](draw, export.content)
        yield export._replace(name=f"{i}, {export.name}: {name}", content=content)


def _flipped(draw: random.Random, content: bytes) -> bytes:
    changed = bytearray(content)
    for _ in range(draw.choice((1, 3, 30))):
        changed[draw.randrange(len(changed))] = draw.randrange(256)
    return bytes(changed)


def _flipped_above(draw: random.Random, content: bytes) -> bytes:
    return _flipped(draw, content[:300]) + content[300:]


def _inserted(draw: random.Random, content: bytes) -> bytes:
    at = draw.randrange(len(content))
    return (
        content[:at]
        + draw.choice((bytes(7), "Zeit µs °".encode("utf-16"), "ä".encode("cp1252")))
        + content[at:]
    )


#: What happens to bytes, whatever they mean.
_BYTES: Final[dict[str, _Damage]] = {
    "cut short": lambda draw, content: content[: draw.randrange(1, len(content))],
    "cut short within its beginning": lambda draw, content: content[: draw.randrange(1, 400)],
    "empty": lambda draw, content: b"",
    "bytes changed": _flipped,
    "bytes changed in its beginning": _flipped_above,
    "bytes inserted": _inserted,
    "beginning lost": lambda draw, content: content[draw.randrange(1, len(content)) :],
    "twice": lambda draw, content: content + content,
}


def _by_rows(change: Callable[[random.Random, list[str]], list[str]]) -> _Damage:
    """Make damage of what happens to lines."""

    def damage(draw: random.Random, content: bytes) -> bytes:
        code = "utf-16" if content.startswith(b"\xff\xfe") else "latin-1"
        lines = content.decode(code).splitlines(keepends=True)
        return "".join(change(draw, lines)).encode(code, errors="replace")

    return damage


def _cells_replaced(draw: random.Random, lines: list[str]) -> list[str]:
    cell = draw.choice(_CELLS)
    for _ in range(draw.choice((1, 5, 300))):
        i = draw.randrange(len(lines))
        separator = next((s for s in "\t;, " if s in lines[i].strip()), ",")
        cells = lines[i].rstrip("\r\n").split(separator)
        cells[draw.randrange(len(cells))] = cell
        lines[i] = separator.join(cells) + "\n"
    return lines


def _swapped(draw: random.Random, lines: list[str]) -> list[str]:
    """Turn the cells of rows from one on round."""
    for i in range(draw.randrange(len(lines)), len(lines)):
        separator = next((s for s in "\t;, " if s in lines[i].strip()), ",")
        lines[i] = separator.join(reversed(lines[i].rstrip("\r\n").split(separator))) + "\n"
    return lines


def _other_separators(draw: random.Random, lines: list[str]) -> list[str]:
    at, (old, new) = draw.randrange(len(lines)), draw.choice((",;", ".,", "\t,", ";\t", ", "))
    return [*lines[:at], *(line.replace(old, new) for line in lines[at:])]


def _some_twice(draw: random.Random, lines: list[str]) -> list[str]:
    at = draw.randrange(len(lines))
    return lines[:at] + lines[max(0, at - draw.choice((1, 10, 500))) : at] + lines[at:]


def _some_lost(draw: random.Random, lines: list[str]) -> list[str]:
    at = draw.randrange(len(lines))
    return lines[:at] + lines[at + draw.choice((1, 10, 300)) :]


def _shuffled(draw: random.Random, lines: list[str]) -> list[str]:
    at = draw.randrange(len(lines))
    some = lines[at : at + draw.choice((2, 20, 2000))]
    return lines[:at] + draw.sample(some, len(some)) + lines[at + len(some) :]


#: What happens to the rows of a text.
_ROWS: Final[dict[str, _Damage]] = {
    "cells replaced": _by_rows(_cells_replaced),
    "cells turned round": _by_rows(_swapped),
    "other separators from a row on": _by_rows(_other_separators),
    "rows twice": _by_rows(_some_twice),
    "rows lost": _by_rows(_some_lost),
    "rows shuffled": _by_rows(_shuffled),
    "header alone": _by_rows(lambda draw, lines: lines[: draw.randrange(1, 4)]),
    "one row": _by_rows(lambda draw, lines: lines[: draw.randrange(1, 4)] + lines[-1:]),
    "header twice": _by_rows(lambda draw, lines: lines[:1] + lines),
    "header in the middle": _by_rows(lambda draw, lines: lines[:500] + lines[:1] + lines[500:]),
    "no header": _by_rows(lambda draw, lines: lines[draw.randrange(1, 4) :]),
    "every cell quoted": _by_rows(lambda draw, lines: [f'"{line.rstrip()}"\n' for line in lines]),
}
