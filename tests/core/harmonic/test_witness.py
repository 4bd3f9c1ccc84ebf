"""Cycles against a walk that shares nothing with the solver."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from helpers.harmonics import drawn, drive_of, solved

from vibro.core.codes import Status, pattern_texts


@pytest.mark.parametrize(
    ("harmonics", "kind"),
    [
        (2, {}),
        (2, {"along_only": True}),
        (2, {"ratio": (0.02, 0.4)}),
        (2, {"ratio": (1.0, 1.0)}),
        (2, {"steep": 0.97}),
        (2, {"load": (0.3, 1.0)}),
        (3, {}),
        (3, {"along_only": True, "ratio": (0.1, 1.0)}),
    ],
    ids=str,
)
def test_random_scenes_settle_as_the_walk_does(harmonics: int, kind: dict[str, Any]) -> None:
    count = 24
    loads = drawn(count, 20 + harmonics, harmonics, **kind)
    out = solved(loads, count)
    texts = pattern_texts(out.pattern).tolist()
    compared = 0
    for i in range(count):
        status = Status(out.status[i])
        if status is Status.FLIGHT_NOT_MODELLED:
            continue
        drive, weight = drive_of(loads, i)
        try:
            cycle = drive.settle(800)
        except ArithmeticError:
            # endless, or too slow for the walk, which decides nothing
            compared += status is Status.RUNAWAY
            continue
        assert status is Status.OK
        assert texts[i] == cycle.pattern
        assert abs(out.displacement[i] - cycle.displacement * weight) < 1e-8
        compared += 1
    assert compared > 10


def test_slow_approaches_end_where_they_lead() -> None:
    # bodies that are followed for hundreds of cycles before they settle: into cycles that begin only on the
    # way, past jumps of the return map, into a rest that none of the first cycles has
    count = 3000
    loads = drawn(count, 4, ratio=(0.02, 0.2), along_only=True, steep=0.0)
    out = solved(loads, count)
    assert np.count_nonzero(out.status == Status.UNRESOLVED) <= 1
    texts = pattern_texts(out.pattern)
    rare = np.flatnonzero(np.isin(texts, ["F_B", "FB_B", "FBF_", "FBF_B", "B_", "F_"]))[:12]
    for i in rare:
        drive, weight = drive_of(loads, int(i))
        cycle = drive.settle(20_000)
        assert texts[i] == cycle.pattern
        assert abs(out.displacement[i] - cycle.displacement * weight) < 1e-8
