"""The faults of benchmarks/mutants.py can still be put in, in every room, and their tests are there."""

from __future__ import annotations

from pathlib import Path

from mutants import MUTANTS, ROOT

SOURCE, TESTS = ROOT / "src" / "vibro", ROOT / "tests"
ROOMS = {path.parent.name for path in SOURCE.glob("*/__init__.py")}


def test_every_room_has_some() -> None:
    assert {Path(mutant.file).parts[0] for mutant in MUTANTS} >= ROOMS
    assert len(MUTANTS) >= 60


def test_each_can_be_put_in_and_is_still_a_program() -> None:
    for mutant in MUTANTS:
        text = (SOURCE / mutant.file).read_text(encoding="utf-8")
        changed = mutant.put_into(text)
        assert changed != text, mutant
        if mutant.file.endswith(".py"):
            compile(changed, mutant.file, "exec")


def test_their_tests_are_there() -> None:
    for file, _, test in (mutant.tests.partition("::") for mutant in MUTANTS):
        assert (TESTS / file).exists(), file
        if test:
            assert f"def {test}(" in (TESTS / file).read_text(encoding="utf-8"), test
