"""``vibro map DIR``: pictures of stored cells."""

from __future__ import annotations

import json
import shutil
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest
from helpers.plans import store
from PIL import Image

import vibro

if TYPE_CHECKING:
    from helpers.commands import Run

    from vibro.sweeps.whole import Sweep

GIVEN: dict[str, Any] = {"static_friction": "0.3,0.74", "friction_ratio": "0.5:0.9:5"}


@pytest.fixture(scope="module")
def held() -> Sweep:
    return vibro.sweep(amplitude_mm="0.2:6:11", frequency_hz="5:25:7", drive_angle_deg=20, **GIVEN)


@pytest.fixture(scope="module")
def stored(held: Sweep, tmp_path_factory: pytest.TempPathFactory) -> Path:
    return store(held, tmp_path_factory.mktemp("sweeps") / "wide")


@pytest.fixture
def wide(stored: Path, tmp_path: Path) -> Path:
    """Store cells where commands run."""
    return Path(shutil.copytree(stored, tmp_path / "wide"))


@pytest.fixture(autouse=True)
def _nothing_is_solved(stored: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def solve(*_: object, **__: object) -> None:
        raise AssertionError("a cell is solved")

    monkeypatch.setattr("vibro.sweeps.grid.solve", solve)


def names() -> list[str]:
    return sorted(path.name for path in Path().iterdir() if path.is_file())


def test_pictures_are_drawn_of_what_is_stored(run: Run, wide: Path, held: Sweep) -> None:
    result = run("map", "wide", "--at", "mu_s=.3,mu_ratio=0.7", "--show", "flight")
    assert result.exit_code == 0, result.stderr
    assert result.stdout == ""
    written = ["wide-flight.png", "wide-regime.png", "wide-speed.png", "wide.json"]
    assert names() == written
    assert [line for line in result.stderr.splitlines() if line.startswith("pictures")] == []
    assert "amplitude: 11 values, 0.2 ... 6 mm, step 0.58\n" in result.stderr
    for name in written:
        assert f"wrote {name}\n" in result.stderr
    content = json.loads(Path("wide.json").read_text(encoding="utf-8"))
    assert content["argv"] == ["vibro", "map", "wide", "--at", "mu_s=.3,mu_ratio=0.7", "--show", "flight"]
    assert set(content["files"]) == set(written)
    assert content["sweep"]["folder"] == "wide"
    assert content["cells"] == 770
    assert content["axes"]["static_friction"]["values"] == [0.3, 0.74]
    held.draw("flight", at={"mu_s": 0.3, "mu_ratio": 0.7}).savefig("held.png", metadata={})
    drawn, expected = (np.asarray(Image.open(name)) for name in ("wide-flight.png", "held.png"))
    np.testing.assert_array_equal(drawn, expected)


def test_what_was_not_solved_is_not_drawn(run: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.undo()
    monkeypatch.chdir(tmp_path)
    given: dict[str, Any] = {"static_friction": 0.5, "kinetic_friction": 0.4, "drive_angle_deg": 20}
    given |= {"amplitude_mm": "0.2:6:5", "frequency_hz": "5:25:5", "flight": False}
    for level in ("exact", "regimes"):
        store(vibro.sweep(**given, output=level), tmp_path / level)
    assert "--show flight: exact was solved without flights" in run("map", "exact", "--show", "flight").stderr
    assert "--speed: regimes was solved for regimes alone" in run("map", "regimes", "--speed", "5").stderr
    assert run("map", "regimes").exit_code == 0
    assert names() == ["regimes-regime.png", "regimes.json"]
    assert "no picture of regimes" in run("map", "regimes", "--at", "f=5", "-o", "x").stderr
