"""Messages: whatever is wrong, a few lines that a console can show."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from helpers.cases import each

from vibro.errors import MOST_LISTED, InputError, Problems, did_you_mean, shown


@each("value", [1.5, -3, "0.1:3", "it's", [1, 2.0, "3mm"], {"a": 1}, None, True, 1e-300, "µm", (0, 74)])
def test_short_values_are_shown_as_they_are(value: Any) -> None:
    assert shown(value) == repr(value)


@each(
    ("value", "part"),
    [
        (10**400, "a whole number of about 401 digits"),
        ("9" * 5000, "(5000 characters)"),
        ("\x1b[31m\n\x07" * 100, "\\x1b[31m\\n"),
        ([10**5000, 1], "[a whole number of about 5001 digits, 1]"),
        (list(range(1_000_000)), "[0, 1, 2, 3, 4, 5, ...]"),
        (np.arange(10_000.0).reshape(100, 100), "array([[0."),
    ],
)
def test_long_values_are_cut_to_a_line(value: Any, part: str) -> None:
    text = shown(value)
    assert part in text
    assert len(text) < 150
    assert text.isprintable()


def test_what_cannot_be_written_is_shown_all_the_same() -> None:
    class Broken:
        def __repr__(self) -> str:
            raise RuntimeError

    nested: list[Any] = []
    for _ in range(10_000):
        nested = [nested]
    assert "Broken" in shown(Broken())
    assert shown(nested) == "[[[[[[[...]]]]]]]"


def test_the_first_problems_are_told_and_the_others_counted() -> None:
    error = InputError(*(f"problem {i}" for i in range(20_000)), hint="\n".join(map(str, range(100))))
    assert error.problems[:2] == ("problem 0", "problem 1")
    assert error.problems[-1] == f"{20_000 - MOST_LISTED} more such problems"
    assert len(error.problems) == MOST_LISTED + 1
    assert error.hint.splitlines()[-1] == f"{100 - MOST_LISTED} more such hints"
    assert InputError(*(["x"] * MOST_LISTED)).problems == ("x",) * MOST_LISTED
    many = InputError(*map(str, range(50)), fields=[f"f{n}" for n in range(50)])
    assert len(many.fields) == MOST_LISTED == len(many.problems) - 1
    # no line of a message is long or obeyed by a terminal
    wild = InputError("--show " + "9" * 5000, "\x1b[2J", hint="write " + "9" * 5000)
    assert all(len(line) < 600 and line.isprintable() for line in (*wild.problems, wild.hint))


def refuse(*problems: str, hint: str = "", fields: tuple[str, ...] = ()) -> None:
    raise InputError(*problems, hint=hint, fields=fields)


def test_problems_are_raised_together_each_hint_once() -> None:
    problems = Problems("nut.toml: ")
    problems.settle()
    problems.add("first", "sort them")
    with problems.taken("[scene] ", "a"):
        refuse("second", "third", hint="sort them", fields=("", "b"))
    with problems.taken():
        refuse(*map(str, range(50)))
    with pytest.raises(InputError) as caught:
        problems.settle()
    told = [problem.removeprefix("nut.toml: ") for problem in caught.value.problems]
    assert told[:4] == ["first", "[scene] second", "[scene] third", "0"]
    assert caught.value.fields[:4] == ("", "a", "b", "")
    assert caught.value.hint == "sort them"


@each(
    ("word", "more", "meant"),
    [
        ("amplitud_mm", {}, "did you mean 'amplitude_mm'?"),
        ("nut.TML", {}, "did you mean 'Nut.toml'?"),
        ("nut.tml", {"before": "in/"}, "did you mean 'in/Nut.toml'?"),
        ("a_mm", {"most": 2, "cutoff": 0.3}, "did you mean 'amplitude_mm' or 'odd\\x1b name'?"),
        ("odd name", {}, "did you mean 'odd\\x1b name'?"),
        ("", {}, ""),
        ("9" * 100_000, {}, ""),
    ],
)
def test_what_was_meant_is_asked_in_one_way(word: Any, more: dict[str, Any], meant: str) -> None:
    assert did_you_mean(word, ["amplitude_mm", "Nut.toml", "odd\x1b name"], **more) == meant
