"""The benchmark for physics engines: its histories are what vibro gives, and its page names its scenes."""

from __future__ import annotations

import csv
import importlib.util
from pathlib import Path
from typing import Final

import numpy as np
import pytest

FOLDER: Final = Path(__file__).parents[1] / "benchmarks" / "engines"
CLOSE: Final = 1e-11  # [mm, mm/s, m/s^2]: rounding of 30 cycles, of numbers up to 200


def table(path: Path) -> list[list[str]]:
    return list(csv.reader(path.read_text(encoding="utf-8").splitlines()))


def test_histories_are_what_vibro_gives(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.syspath_prepend(str(FOLDER))
    spec = importlib.util.spec_from_file_location("engine_histories", FOLDER / "histories.py")
    assert spec
    assert spec.loader
    histories = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(histories)
    histories.write(tmp_path)
    written = sorted(path.name for path in tmp_path.glob("*.csv"))
    assert written == sorted(path.name for path in (FOLDER / "data").glob("*.csv") if path.stem != "scenes")
    for name in written:
        texts = 2 if name == "phases.csv" else 0
        for row, known in zip(table(tmp_path / name), table(FOLDER / "data" / name), strict=True):
            assert row[:texts] == known[:texts]
            if row != known:
                numbers, expected = (np.array(cells[texts:], dtype=float) for cells in (row, known))
                np.testing.assert_allclose(numbers, expected, rtol=1e-11, atol=CLOSE)


def test_the_page_describes_the_scenes() -> None:
    page = (FOLDER.parents[1] / "docs" / "theory" / "benchmark.md").read_text(encoding="utf-8")
    for row in table(FOLDER / "data" / "scenes.csv")[1:]:
        assert f"| {' | '.join(row[:7])} | " in page
