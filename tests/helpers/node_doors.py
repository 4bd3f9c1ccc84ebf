"""The solver in JavaScript, in place of the compiled one: its doors, run by node in a process of its own.

Without node the tests that need it are skipped by name; where VIBRO_NODE is "required" they fail.
"""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import threading
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

from vibro.core import compiled

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    from vibro.reals import Floats

SCRIPT = Path(compiled.__file__).with_name("_solver.js")
_HOST = Path(__file__).with_name("doors.cjs")


class NodeDoors:
    """Doors as ``vibro.core.compiled.Doors`` has them; each call copies its buffers there and back."""

    compiled = True  # as fast as that, nearly

    def __init__(self, process: subprocess.Popen[bytes]) -> None:
        self._process, self._lock = process, threading.Lock()

    def rows(self, array: Floats) -> tuple[Floats, ...]:
        """Hand over the rows of an array."""
        return tuple(array)

    def row(self, array: Floats) -> Floats:
        """Hand over an array as one buffer."""
        return array.reshape(-1)

    def __getattr__(self, name: str) -> Callable[..., Any]:
        return lambda *values: self._call(name, values)

    def _call(self, name: str, values: tuple[Any, ...]) -> Any:
        numbers: list[float] = []
        rooms: list[Any] = []

        def place(value: Any) -> Any:
            if isinstance(value, tuple):
                return [place(part) for part in value]
            if isinstance(value, np.ndarray):
                rooms.append(value)
                return [len(rooms)]
            numbers.append(value)
            return len(numbers) - 1

        to, back = self._process.stdin, self._process.stdout
        assert to is not None
        assert back is not None
        places = [place(value) for value in values]
        sizes = [len(numbers), *(room.size for room in rooms)]
        head = json.dumps({"door": name, "values": places, "sizes": sizes}).encode()
        with self._lock:  # threads fill parts of the same buffers
            to.write(len(head).to_bytes(4, "little") + head)
            to.writelines(np.asarray(room, np.float64).tobytes() for room in [numbers, *rooms])
            to.flush()
            result = float(np.frombuffer(back.read(8))[0])
            for room in rooms:
                left = np.frombuffer(back.read(8 * room.size))
                if room.flags.writeable:
                    with np.errstate(invalid="ignore"):  # integers that nothing has been written to
                        room.reshape(-1)[:] = left.astype(room.dtype)
        is_whole = result.is_integer() and (result or not np.signbit(result))  # -0.0 is not 0
        return int(result) if is_whole else result


def node() -> str:
    """Return the path of node."""
    path = shutil.which("node")
    if path is None and os.environ.get("VIBRO_NODE") == "required":
        pytest.fail("node is not installed")
    return path or pytest.skip("node is not installed")


@contextmanager
def running(script: Path) -> Iterator[NodeDoors]:
    """Run a script's doors."""
    command = [node(), str(_HOST), str(script)]
    with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE) as process:
        yield NodeDoors(process)
        assert process.stdin is not None
        process.stdin.close()


@contextmanager
def in_node() -> Iterator[None]:
    """Let vibro take the solver's script for the compiled solver."""
    with running(SCRIPT) as doors, pytest.MonkeyPatch.context() as patch:
        patch.setattr(compiled, "doors", lambda: doors)
        yield
