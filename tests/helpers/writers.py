"""Writers that are killed, or write one set at once: what they leave is whole, and of one of them.

Run as a program, ``python -m helpers.writers HOW FOLDER``, by tests/files/test_placing.py.
"""

from __future__ import annotations

import os
import random
import signal
import sys
import time
from pathlib import Path

import pytest
from helpers.outputs import NAMES, every, fail_at, output_set, put, texts, visible

from vibro.errors import FileError

OLD = ("x.csv", "x-flight.png", "x.json")


def between_steps(root: Path, *, force: bool) -> None:
    """Kill a writer before each of its steps of publishing."""
    for which in range(1, 100):
        folder = root / str(which)
        if force:
            put(folder, *OLD, text="old")
        child = os.fork()
        if not child:
            with output_set(folder, force=force) as output:
                for name in NAMES:
                    output[folder / name].write_text("new", encoding="utf-8")
                patch = pytest.MonkeyPatch()
                patch.setattr("os.strerror", lambda _: os.kill(os.getpid(), signal.SIGKILL))
                fail_at(patch, which, for_good=False)
            os._exit(0)
        _, status = os.waitpid(child, 0)
        left = visible(folder)
        if "x.json" in left:
            assert left in (every("new"), every("old", *OLD)), left
        elif left:
            with pytest.raises(FileError, match=r"but no x\.json: a run did not end there"):
                put(folder)
        put(folder, force=True)
        assert texts(folder) == every("new")
        if status == 0:
            break
    assert which > (10 if force else 5)


def any_time(folder: Path) -> None:
    """Kill a writer at 100 instants, and at more where the machine is so busy that it hardly begins."""
    instants, whole, sets = random.Random(7), 0, 0
    for generation in range(1000):
        if generation >= 100 and whole > 100 and sets > 20:
            break
        child = os.fork()
        if not child:
            while True:
                put(folder, text=f"{generation}\n" * 20_000, force=True)
        time.sleep(instants.uniform(0.0, 0.02))
        os.kill(child, signal.SIGKILL)
        os.waitpid(child, 0)
        left = visible(folder)
        for text in left.values():
            lines = text.splitlines()
            assert len(lines) == 20_000
            assert len(set(lines)) == 1
            whole += 1
        if "x.json" in left:
            assert len(left) == len(NAMES)
            assert len(set(left.values())) == 1
            sets += 1
    put(folder, force=True)
    assert texts(folder) == every("new")
    assert whole > 100
    assert sets > 20


def at_once(root: Path, *, force: bool) -> None:
    """Let eight writers begin at once."""
    for i in range(20):
        folder = root / str(i)
        begin, go = os.pipe()
        children = {}
        for number in range(8):
            child = os.fork()
            if not child:
                os.close(go)
                os.read(begin, 1)
                try:
                    put(folder, text=f"{number}", force=force)
                except FileError:
                    os._exit(1)
                os._exit(0)
            children[child] = number
        os.close(go)
        os.close(begin)
        codes = {number: os.waitpid(child, 0)[1] >> 8 for child, number in children.items()}
        winners = [f"{number}" for number, code in codes.items() if code == 0]
        assert set(codes.values()) <= {0, 1}
        assert winners
        assert force or len(winners) == 1
        left = texts(folder)
        assert left in [every(text) for text in winners], left


if __name__ == "__main__":
    how, root = sys.argv[1], Path(sys.argv[2])
    if how == "any-time":
        any_time(root)
    elif how.startswith("at-once"):
        at_once(root, force=how.endswith("force"))
    else:
        between_steps(root, force=how.endswith("force"))
