"""What the tests of the explorer's answers share: states, and reading answers as the page does."""

from __future__ import annotations

import json
from typing import Any

import numpy as np
from numpy.typing import NDArray

from vibro.explore.answers import Answers
from vibro.explore.state import State, initial_state, read_state

TYPES = {"f4": "<f4", "i1": "i1", "u1": "u1", "u2": "<u2"}


def unpacked(content: bytes) -> tuple[dict[str, Any], dict[str, NDArray[Any]]]:
    """Read a binary answer; every array begins where JavaScript can make one."""
    length = int.from_bytes(content[:4], "little")
    header = json.loads(content[4 : 4 + length])
    start = 4 + length
    arrays = {}
    assert start % 8 == 0
    for told in header["arrays"]:
        assert told["offset"] % 8 == 0
        shape = tuple(told["shape"])
        count = int(np.prod(shape))
        values = np.frombuffer(content, TYPES[told["type"]], count, start + told["offset"])
        arrays[told["name"]] = values.reshape(shape)
    assert len(content) % 8 == 0
    return header, arrays


def state_of(**query: str) -> State:
    """Read a state that differs from the nut's."""
    return read_state(query, initial_state())


def table_of(answers: Answers, state: State) -> str:
    """Return the cells of a map as CSV."""
    return b"".join(answers.table(state)).decode()
