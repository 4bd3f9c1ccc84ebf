"""``vibro solve``: each regime begins at the amplitudes and frequencies that it tells."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING

import pytest
from helpers.commands import ELLIPSE, NUT, other

if TYPE_CHECKING:
    from helpers.commands import Run


@pytest.mark.parametrize(
    ("drive", "sizes", "near", "steps"),
    [
        (
            NUT,
            ("amplitude",),
            1e-5,
            {
                "forward slip": ("no-slip", "forward-slip"),
                "back slip": ("forward-slip", "back-slip"),
                "hopping": ("back-slip", "hopping"),
            },
        ),
        (
            ELLIPSE,
            ("along_amplitude", "normal_amplitude"),
            1e-4,
            {"forward slip": ("no-slip", "forward-slip"), "hopping": ("back-slip", "hopping")},
        ),
    ],
    ids=["line", "ellipse"],
)
def test_each_regime_begins_where_the_report_says(
    run: Run, drive: tuple[str, ...], sizes: tuple[str, ...], near: float, steps: dict[str, tuple[str, str]]
) -> None:
    known = json.loads(run("solve", *drive, "--json").stdout)
    rows = {row["begins"]: row for row in known["beginnings"]}
    for name, regimes in steps.items():
        times, frequency = rows[name]["times_the_drive"], rows[name]["frequency_hz"]
        limits = [times * known[f"{amplitude}_mm"] for amplitude in sizes]
        for factor, regime in zip((1.0 - near, 1.0 + near), regimes, strict=True):
            larger = [f"{x}={factor * limit!r}" for x, limit in zip(sizes, limits, strict=True)]
            others = (
                drive[2:] if drive is NUT else [text for text in drive if text[:4] not in ("alon", "norm")]
            )
            for given in ((*others, *larger), other(drive, "-f", repr(factor * frequency))):
                assert json.loads(run("solve", *given, "--json").stdout)["regime"] == regime
