"""The benchmark for physics engines: its histories are what vibro gives, and obey Newton's law."""

from __future__ import annotations

import csv
import importlib.util
import math
import subprocess
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import numpy as np
import pytest
from helpers.cases import each

import vibro

if TYPE_CHECKING:
    from types import ModuleType

ROOT: Final = Path(__file__).parents[1]
FOLDER: Final = ROOT / "benchmarks" / "engines"
PAGE: Final = (ROOT / "docs" / "theory" / "benchmark.md").read_text(encoding="utf-8")
NAMES: Final = ("rest", "forward slip", "both ways", "never at rest", "hop", "hop and bounce")
LAST: Final = 1e-5  # [mm/s] impact below which a body counts as lying
CLOSE: Final = 1e-11  # [mm, mm/s, m/s^2]: rounding of 30 cycles, of numbers up to 200


def table(name: str) -> list[dict[str, str]]:
    with (FOLDER / "data" / f"{name.replace(' ', '_')}.csv").open(encoding="utf-8", newline="") as file:
        return list(csv.DictReader(file))


def script(name: str) -> ModuleType:
    spec = importlib.util.spec_from_file_location(f"engine_benchmark_{name}", FOLDER / f"{name}.py")
    assert spec
    assert spec.loader
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_histories_are_what_vibro_gives(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.syspath_prepend(str(FOLDER))
    script("histories").write(tmp_path)
    written = sorted(path.name for path in tmp_path.glob("*.csv"))
    assert written == sorted(path.name for path in (FOLDER / "data").glob("*.csv") if path.stem != "scenes")
    for name in written:
        new, old = (
            list(csv.reader((folder / name).read_text(encoding="utf-8").splitlines()))
            for folder in (tmp_path, FOLDER / "data")
        )
        assert len(new) == len(old)
        for row, known in zip(new[1:], old[1:], strict=True):
            texts = 2 if name == "phases.csv" else 0
            assert row[:texts] == known[:texts]
            numbers, expected = (np.array(cells[texts:], dtype=float) for cells in (row, known))
            np.testing.assert_allclose(numbers, expected, rtol=1e-11, atol=CLOSE)


class Newton:
    """Motion from Newton's law in the trough's frame, written from it alone; mm, s, per unit mass."""

    def __init__(self, scene: dict[str, str]) -> None:
        self.mu, self.e = float(scene["friction"]), float(scene["restitution"])
        self.w = 2.0 * math.pi * float(scene["frequency_hz"])
        line, climb = (math.radians(float(scene[f"{key}_angle_deg"])) for key in ("drive", "trough"))
        amplitude, gravity = float(scene["amplitude_mm"]), 1e3 * float(scene["gravity_m_s2"])
        self.x, self.y = amplitude * math.cos(line), amplitude * math.sin(line)
        self.gx, self.gy = gravity * math.sin(climb), gravity * math.cos(climb)

    def load(self, t: float) -> float:
        """Tangential load: inertia and weight."""
        return self.x * self.w**2 * math.sin(self.w * t) - self.gx

    def normal(self, t: float) -> float:
        """Normal force of a body in contact."""
        return self.gy - self.y * self.w**2 * math.sin(self.w * t)

    def moved(self, size: float, weight: float, t0: float, t: float, v: float) -> tuple[float, float]:
        """Way and velocity after t0 under ``size w^2 sin wt - weight``, from the velocity v."""
        w, d = self.w, t - t0
        way = size * (w * d * math.cos(w * t0) - math.sin(w * t) + math.sin(w * t0))
        velocity = size * w * (math.cos(w * t0) - math.cos(w * t))
        return v * d + way - weight * d * d / 2.0, v + velocity - weight * d

    def slide(self, sign: float, t0: float, t: float, v: float) -> tuple[float, float]:
        """Way and velocity of a slide; ``sign`` is its direction, 0 for a flight."""
        mu = sign * self.mu
        return self.moved(self.x + mu * self.y, self.gx + mu * self.gy, t0, t, v)

    def flight(self, t0: float, t: float, v: float) -> tuple[float, float]:
        """Height and its velocity."""
        return self.moved(self.y, self.gy, t0, t, v)


SIGNS: Final = {"forward slide": 1.0, "back slide": -1.0, "flight": 0.0}


@each("name", NAMES)
def test_histories_obey_newtons_law(name: str) -> None:
    law = Newton(next(row for row in table("scenes") if row["scene"] == name))
    samples = [{key: float(value) for key, value in row.items()} for row in table(name)]
    lift, before, kinds = 0.0, None, set()
    for row in (row for row in table("phases") if row["scene"] == name):
        kind = row["kind"]
        start, end, x0, x1, v0, v1, impact = (float(row[key]) for key in list(row)[2:])
        inside = [row for row in samples if start < row["time_s"] < end]
        kinds.add(kind)
        if before is None:
            assert (start, x0, v0) == (0.0, 0.0, 0.0)
        else:  # nothing jumps but the velocity at an impact, by Coulomb's friction
            assert (start, x0) == (before["end"], before["x1"])
            jump = v0 - before["v1"]
            most = law.mu * (1.0 + law.e) * before["impact"]
            # The last of ever lower bounces stands for all that are lower still.
            rounding = CLOSE if before["impact"] > LAST else LAST
            assert abs(jump) <= most + rounding
            if jump:
                assert jump * before["v1"] < 0.0
                assert v0 == 0.0 or abs(jump) == pytest.approx(most, abs=rounding)
            lift = law.e * before["impact"]
            if kind == "flight" and not lift:
                assert law.normal(start) == pytest.approx(0.0, abs=1e-6)
        if kind == "rest":
            assert (v0, v1) == (0.0, 0.0)
            assert x1 == pytest.approx(x0, abs=CLOSE)
            for time in np.linspace(start, end, 50):
                assert abs(law.load(time)) <= law.mu * law.normal(time) * (1.0 + 1e-12)
        else:
            way, velocity = law.slide(SIGNS[kind], start, end, v0)
            assert (x0 + way, velocity) == pytest.approx((x1, v1), abs=CLOSE)
            height, fall = law.flight(start, end, lift)
            if kind == "flight" and end < samples[-1]["time_s"]:
                assert (height, -fall) == pytest.approx((0.0, impact), abs=CLOSE if impact > LAST else LAST)
        for at in inside:
            t, friction = at["time_s"], 1e3 * at["friction_m_s2"]
            if kind == "rest":
                place = (x0, 0.0)
                assert friction == pytest.approx(-law.load(t), abs=1e-9)
            else:
                way, velocity = law.slide(SIGNS[kind], start, t, v0)
                place = (x0 + way, velocity)
                assert velocity * SIGNS[kind] >= 0.0
                assert friction == pytest.approx(-SIGNS[kind] * law.mu * law.normal(t), abs=1e-9)
            assert (at["displacement_mm"], at["velocity_mm_s"]) == pytest.approx(place, abs=CLOSE)
            height, normal = (
                (law.flight(start, t, lift)[0], 0.0) if kind == "flight" else (0.0, law.normal(t))
            )
            assert at["height_mm"] == pytest.approx(height, abs=CLOSE)
            assert 1e3 * at["normal_force_m_s2"] == pytest.approx(normal, abs=1e-9)
            assert height >= 0.0
            assert normal >= 0.0
            assert at["trough_along_mm"] == pytest.approx(law.x * math.sin(law.w * t), abs=CLOSE)
            assert at["trough_normal_mm"] == pytest.approx(law.y * math.sin(law.w * t), abs=CLOSE)
        before = {"end": end, "x1": x1, "v1": v1, "impact": impact}
    assert before
    assert before["end"] == samples[-1]["time_s"] == 1.2
    assert (
        kinds
        == {
            "rest": {"rest"},
            "forward slip": {"rest", "forward slide"},
            "both ways": {"rest", "forward slide", "back slide"},
            "never at rest": {"rest", "forward slide", "back slide"},
            "hop": {"rest", "forward slide", "back slide", "flight"},
            "hop and bounce": {"rest", "forward slide", "back slide", "flight"},
        }[name]
    )


def test_the_page_describes_the_scenes(monkeypatch: pytest.MonkeyPatch) -> None:
    for row in table("scenes"):
        keys = (
            "amplitude_mm",
            "frequency_hz",
            "drive_angle_deg",
            "trough_angle_deg",
            "friction",
            "restitution",
        )
        assert f"| {' | '.join((row['scene'], *(row[key] for key in keys)))} | " in PAGE
    monkeypatch.syspath_prepend(str(FOLDER))
    histories = script("histories")
    rest, *_, hop, bounce = map(histories.of_vibro, histories.scenes())
    assert float(vibro.solve(rest).back_ratio) == pytest.approx(0.99, abs=1e-3)  # at most 99 % ... holds
    assert [len(vibro.attractors(scene)) for scene in (hop, bounce)] == [1, 1]  # one and the same motion


@pytest.mark.process
def test_the_benchmark_runs_without_engines() -> None:
    command = [sys.executable, str(FOLDER / "run.py"), "--steps", "1"]
    done = subprocess.run(command, capture_output=True, encoding="utf-8", check=True)
    rows = [
        [cell.strip() for cell in line.split("|")[1:-1]] for line in done.stdout.splitlines() if "|" in line
    ]
    moreau: Any = next(row for row in rows if row[0].startswith("Moreau"))
    assert moreau[2] == "0 µm/s"
    assert all(abs(float(cell.rstrip("%"))) < 15.0 for cell in moreau[3:])
    assert f"| {' | '.join(moreau)} |" in PAGE  # the page shows what it prints
