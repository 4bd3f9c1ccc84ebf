"""Tables as people ask for them: columns by name, and what they were made with."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from helpers.commands import NUT, NUT_ANGLE_AND_FRICTION, Run, rows_of

MAP = ("map", "-A", "0.1,1,1.15,4", "-f", "14.9876,15", *NUT_ANGLE_AND_FRICTION)
TRAVERSE = ("traverse-time", *MAP[1:], "-L", "600")
NAMES = "mean_velocity_mm_s,amplitude_mm,regime,acceleration_g,frequency_hz"


def test_the_sidecar_tells_what_the_table_holds(run: Run) -> None:
    options = ("--columns", f"{NAMES},parts_per_min", "--pitch", "1in", "--mass", "12g")
    assert run(*MAP, *options, "-o", "few").exit_code == 0
    content = json.loads(Path("few.json").read_text(encoding="utf-8"))
    assert list(content["columns"]) == [*NAMES.split(","), "parts_per_min"]
    assert (content["columns"]["acceleration_g"], content["columns"]["parts_per_min"]) == ("g", "1/min")
    assert content["part"] == {"pitch_mm": 25.4, "mass_kg": 0.012}
    assert Path("few.csv").read_text(encoding="utf-8").splitlines()[0] == ",".join(content["columns"])
    assert run(*MAP, "-o", "all", "--regimes-only").exit_code == 0
    content = json.loads(Path("all.json").read_text(encoding="utf-8"))
    assert "part" not in content


BOUNCING = ("--restitution", "0.5")
LONG = ("-L", "600")


@pytest.mark.parametrize(
    ("args", "told"),
    [
        (("solve", *NUT, *BOUNCING, *LONG), {"restitution": 0.5, "trough_length_mm": 600}),
        (("solve", *NUT, *BOUNCING, "--regimes-only"), {}),
        ((*MAP, *BOUNCING, *LONG), {"restitution": 0.5, "trough_length_mm": 600}),
        ((*MAP, *LONG, "--regimes-only"), {"trough_length_mm": 600}),
        ((*TRAVERSE, *BOUNCING), {"restitution": 0.5, "trough_length_mm": 600}),
    ],
)
def test_a_table_tells_what_it_was_made_with(run: Run, args: tuple[str, ...], told: dict[str, float]) -> None:
    rows = rows_of(run(*args, "-o", "-").stdout)
    names = list(rows[0])
    assert names[names.index("back_ratio") + 1 : names.index("flight_fraction")] == list(told)
    for row in rows:
        assert {name: float(row[name]) for name in told} == told
    if args[0] != "map":
        answer = json.loads(run(*args, "--json").stdout)
        for cell in answer if isinstance(answer, list) else [answer]:
            assert [name for name in cell if name in names] == names
            assert cell.items() >= told.items()
