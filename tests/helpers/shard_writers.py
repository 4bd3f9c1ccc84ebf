"""Runs that write one folder and are killed, or meet: what they leave is whole, and of the same bytes.

Run as a program, ``python -m helpers.shard_writers HOW FOLDER``, by tests/output/test_faults.py and
test_ranges.py.
"""

from __future__ import annotations

import os
import random
import signal
import sys
import time
from collections import Counter
from pathlib import Path
from typing import Any

from helpers.plans import written
from helpers.sharded import PLAN, SHARDS

from vibro.errors import FileError
from vibro.output.shard_folder import MANIFEST, SUCCESS

WHOLE = {*SHARDS, MANIFEST, SUCCESS}
HOWS: list[dict[str, Any]] = [
    {"shards": "0:4"}, {"shards": "4:9"}, {"shards": "2:15"}, {"shards": "9:15"}, {"shards": "9:15"},
    {"resume": True}, {"force": True}, {},
]  # fmt: skip
"""Of runs that begin at once."""


def begun(folder: Path, **how: Any) -> int:
    """Start a run in a process of its own."""
    child = os.fork()
    if not child:
        try:
            written(folder, PLAN, **how)
        except FileError as exc:
            os._exit(1 if "is writing" in str(exc) else 2 if "holds a sweep" in str(exc) else 3)
        except BaseException:
            sys.excepthook(*sys.exc_info())
            os._exit(4)
        os._exit(0)
    return child


def ended(child: int) -> int:
    """Return the exit code of a run, or minus the signal that ended it."""
    return os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])


def files(folder: Path) -> dict[str, bytes]:
    return {path.name: path.read_bytes() for path in folder.glob("[!.]*")}


def check(folder: Path, calm: dict[str, bytes]) -> dict[str, bytes]:
    """Compare all files there are with those of an undisturbed run."""
    there = files(folder)
    for name, content in there.items():
        assert content == calm[name], name
    assert SUCCESS not in there or there.keys() == WHOLE
    return there


def kills(root: Path, calm: dict[str, bytes]) -> None:
    """Kill runs that go on with one another at any moment."""
    began = time.monotonic()
    assert ended(begun(root / "calm")) == 0
    length = time.monotonic() - began
    instants, lengths = random.Random(7), Counter[int]()
    for generation in range(28):
        folder = root / str(generation // 4)
        child = begun(folder, resume=True)
        time.sleep(instants.uniform(0.0, length))
        os.kill(child, signal.SIGKILL)
        ended(child)
        lengths[len(check(folder, calm))] += 1
        assert len(list(folder.glob(".*"))) <= 1
    assert len(lengths) > 4, lengths  # some were cut early, some late
    for folder in root.iterdir():
        assert ended(begun(folder, resume=True)) == 0
        assert check(folder, calm).keys() == WHOLE
        assert list(folder.glob(".*")) == []


def meetings(root: Path, calm: dict[str, bytes]) -> None:
    """Let ranges that overlap, and runs of all shards, begin at once; some are killed."""
    instants, codes = random.Random(7), Counter[int]()
    for generation in range(6):
        folder = root / str(generation)
        children = [begun(folder, **how) for how in instants.sample(HOWS, len(HOWS))]
        if generation % 2:
            time.sleep(instants.uniform(0.0, 0.1))
            os.kill(children[instants.randrange(len(HOWS))], signal.SIGKILL)
        codes.update(map(ended, children))
        check(folder, calm)
        assert ended(begun(folder, resume=True)) == 0
        assert check(folder, calm).keys() == WHOLE
        assert list(folder.glob(".*")) == []
    assert codes.keys() <= {0, 1, 2, -signal.SIGKILL}, codes
    assert min(codes[0], codes[1]) > 7, codes


if __name__ == "__main__":
    how, root = sys.argv[1], Path(sys.argv[2])
    written(
        root / "calm", PLAN
    )  # here, so that runs need not import each for itself what takes most of their time
    calm = files(root / "calm")
    (root / how).mkdir()
    {"kills": kills, "meetings": meetings}[how](root / how, calm)
