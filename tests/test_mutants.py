"""The faults of benchmarks/mutants.py can be put in, in every room, and what kills them is there."""

from __future__ import annotations

from pathlib import Path

from mutants import ENOUGH, ROOT, killers, mutants

SOURCE, TESTS = ROOT / "src" / "vibro", ROOT / "tests"
ROOMS = {path.parent.name for path in SOURCE.glob("*/__init__.py")}
OUTER = {"cli", "tables", "sweeps", "plots", "files", "answers", "explore", "results"}
MUTANTS = mutants()


def test_there_are_enough_in_every_room() -> None:
    rooms = [Path(mutant.file).parts[0] for mutant in MUTANTS]
    assert {*rooms} >= ROOMS
    assert len(MUTANTS) >= ENOUGH
    assert sum(room in OUTER for room in rooms) >= 150


def test_each_can_be_put_in_and_is_still_a_program() -> None:
    for mutant in MUTANTS:
        text = (SOURCE / mutant.file).read_text(encoding="utf-8")
        changed = mutant.put_into(text)
        assert changed != text, mutant
        if mutant.file.endswith(".py"):
            compile(changed, mutant.file, "exec")


def test_those_that_kill_them_are_there() -> None:
    known = killers()
    assert known.keys() == {*map(str, MUTANTS)}
    for mutant, killer in known.items():
        file, _, test = killer.partition("::")
        assert (TESTS / file).exists(), f"{mutant}: {file}"
        name = test.partition("[")[0]
        assert f"def {name}(" in (TESTS / file).read_text(encoding="utf-8"), f"{mutant}: {killer}"
