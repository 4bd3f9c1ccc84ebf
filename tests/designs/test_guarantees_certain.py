"""Regimes and speeds that are certain in a band of frictions, beside many of its bodies, one by one."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
import pytest
from helpers.scenes import scene_with

from vibro import Regime, Scene, Status, guarantee, solve
from vibro.designs.guarantees import certain
from vibro.limits import critical_loads_of_lines

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from vibro import SteadyCycle
    from vibro.designs.guarantees import Certain

    Floats = NDArray[np.float64]
    Span = tuple[float, float]

FREQUENCY, GRAVITY = 25.0, 9.81
CELLS, BODIES = 40, 180
SLOPES = {"level": 0.0, "climb": 1.0, "decline": -1.0}
# Widths of bands, of static friction over its lower end and of the rest over what there is.
WIDTHS = (0.0, 1e-9, 0.02, 0.3, 2.0)


class Frictions(NamedTuple):
    """A box of frictions."""

    static: Span
    second: Span
    is_ratio: bool

    @property
    def is_single(self) -> bool:
        return self.static[0] == self.static[1] and self.second[0] == self.second[1]

    def bodies(self, shares: Floats) -> tuple[Floats, Floats]:
        """Return both frictions at shares of the box, of shape (2, n)."""
        low, high = self.static
        if not self.is_ratio:
            low = max(low, self.second[0])
        mu_s = np.where(shares[0] == 1.0, high, np.clip(low + shares[0] * (high - low), low, high))
        least, most = (np.minimum(end * mu_s if self.is_ratio else end, mu_s) for end in self.second)
        mu_d = np.where(shares[1] == 1.0, most, np.clip(least + shares[1] * (most - least), least, most))
        return mu_s, mu_d

    def certain_of(self, points: dict[str, Any]) -> Certain:
        scene = Scene.allowing_infeasible(**points, static_friction=1.0, kinetic_friction=1.0)
        return certain(
            scene, static_friction=self.static, second_friction=self.second, is_ratio=self.is_ratio
        )


def drawn(rng: np.random.Generator, *, is_ratio: bool) -> Frictions:
    """Draw a box, narrow or wide, which the cut may touch."""
    low = float(10.0 ** rng.uniform(-1.5, 0.2))
    static = (low, low * (1.0 + float(rng.choice(WIDTHS) * rng.random())))
    least, width = float(rng.choice([0.0, rng.random(), 0.99])), float(rng.choice(WIDTHS) * rng.random())
    if is_ratio:
        return Frictions(static, (least, min(least + width, 1.0)), is_ratio)
    return Frictions(static, (least * static[1], least * static[1] + width * low), is_ratio)


def attackers(rng: np.random.Generator, box: Frictions) -> tuple[Floats, Floats]:
    """Draw bodies of a box: its corners, many on its edges and close to them, the rest anywhere."""
    shares = rng.random((2, BODIES))
    shares[0, : BODIES // 3] = rng.integers(0, 2, BODIES // 3)
    shares[1, BODIES // 6 : BODIES // 2] = rng.integers(0, 2, BODIES // 2 - BODIES // 6)
    shares[:, -BODIES // 6 :] **= 6
    shares[:, :4] = [[0.0, 0.0, 1.0, 1.0], [0.0, 1.0, 0.0, 1.0]]
    return box.bodies(shares)


def operating_points(rng: np.random.Generator, box: Frictions, slope: float) -> dict[str, Any]:
    """Draw points about the critical loads of bodies of the box, on troughs on which it may not rest too."""
    mu_s, mu_d = box.bodies(rng.random((2, CELLS)))
    steep = rng.random(CELLS) < 0.3
    beta = slope * np.arctan(np.where(steep, mu_d * rng.choice([0.98, 1.0, 1.02], CELLS), rng.random(CELLS)))
    alpha = rng.uniform(0.0, 1.4, CELLS) * rng.choice([0.1, 1.0], CELLS)
    known = np.stack(critical_loads_of_lines(alpha, mu_s, mu_d, beta))
    load = known[rng.choice(5, CELLS, p=[0.05, 0.3, 0.2, 0.4, 0.05]), np.arange(CELLS)]
    load = np.where((load > 1e-9) & (load < 1e9), load, rng.uniform(0.1, 3.0, CELLS))
    load *= 1.0 + rng.choice([1e-9, 1e-6, 1e-3, 0.05, 0.5], CELLS) * rng.uniform(-1.0, 1.0, CELLS)
    amplitude = load * GRAVITY / (2.0 * math.pi * FREQUENCY) ** 2
    return {"amplitude": amplitude, "frequency": FREQUENCY, "drive_angle": alpha, "trough_angle": beta}


def solved(points: dict[str, Any], mu_s: Any, mu_d: Any) -> SteadyCycle:
    return solve(
        Scene.allowing_infeasible(**points, static_friction=mu_s, kinetic_friction=mu_d), flight=False
    )


@pytest.mark.parametrize("is_ratio", [False, True], ids=["rectangle", "ratio"])
@pytest.mark.parametrize("slope", SLOPES.values(), ids=SLOPES.keys())
def test_no_body_leaves_the_bounds(slope: float, is_ratio: bool) -> None:
    rng = np.random.default_rng(20)
    alike = open_ = known = 0
    for _ in range(50):
        box = drawn(rng, is_ratio=is_ratio)
        points = operating_points(rng, box, slope)
        found = box.certain_of(points)
        mu_s, mu_d = attackers(rng, box)
        bodies = solved(points, mu_s[:, None], mu_d[:, None])
        assert np.all(bodies.regime >= found.lowest)
        assert np.all(bodies.regime <= found.highest)
        proved = ~np.isnan(found.speed_min)
        short = found.speed_min - bodies.mean_velocity  # NaN where a body has no speed
        largest = 2.0 * math.pi * FREQUENCY * points["amplitude"]
        assert np.all((short <= 1e-9 * np.abs(found.speed_min) + 1e-13 * largest)[:, proved])
        assert box.is_single or np.all(found.highest[proved] <= Regime.FORWARD_SLIP)
        known += int(np.count_nonzero(proved))
        same = bodies.regime.min(axis=0) == bodies.regime.max(axis=0)
        alike += int(np.count_nonzero(same))
        open_ += int(np.count_nonzero(same & (found.lowest < found.highest)))
    assert alike > 1000
    assert known > 200
    # On declines a sliver stays open, or none of its bodies is met that differs: measured, .0002 of the cells
    # with a rectangle and .002 with a ratio.
    assert open_ <= (0.005 if slope < 0.0 else 0.0) * alike


@pytest.mark.parametrize("is_ratio", [False, True], ids=["rectangle", "ratio"])
@pytest.mark.parametrize("slope", SLOPES.values(), ids=SLOPES.keys())
def test_a_single_body_is_solved(slope: float, is_ratio: bool) -> None:
    rng = np.random.default_rng(21)
    for _ in range(20):
        mu_s, ratio = float(10.0 ** rng.uniform(-1.5, 0.2)), float(rng.choice([0.0, 1.0, rng.random()]))
        second = ratio if is_ratio else ratio * mu_s
        box = Frictions((mu_s, mu_s), (second, second), is_ratio)
        points = operating_points(rng, box, slope)
        found, body = box.certain_of(points), solved(points, mu_s, ratio * mu_s)
        assert np.array_equal(found.lowest, body.regime)
        assert np.array_equal(found.highest, body.regime)
        assert np.array_equal(found.speed_min, body.mean_velocity, equal_nan=True)


# By hand: level, 20 deg, mu_s .65 to .8, mu_d .5 to .6. What the roughest and the smoothest bodies do first.
ALPHA = math.radians(20.0)
STATIC, KINETIC = (0.65, 0.8), (0.5, 0.6)


def bounds_at(load: float, *, beta: float = 0.0) -> tuple[int, int]:
    amplitude = load * GRAVITY / (2.0 * math.pi * FREQUENCY) ** 2
    points = {"amplitude": amplitude, "frequency": FREQUENCY, "drive_angle": ALPHA, "trough_angle": beta}
    found = Frictions(STATIC, KINETIC, False).certain_of(points)
    return int(found.lowest), int(found.highest)


@pytest.mark.parametrize(
    ("mu_s", "mu_d", "kind", "below", "above"),
    [
        (0.65, 0.6, "forward_onset", (0, 0), (0, 1)),
        (0.8, 0.5, "forward_onset", (0, 1), (1, 1)),
        (0.65, 0.6, "back_slip", (1, 1), (1, 2)),
        (0.8, 0.5, "back_slip", (1, 2), (2, 2)),
        (0.8, 0.5, "hop", (2, 2), (3, 3)),
    ],
)
def test_bounds_change_at_corners(
    mu_s: float, mu_d: float, kind: str, below: tuple[int, int], above: tuple[int, int]
) -> None:
    load = float(getattr(critical_loads_of_lines(ALPHA, mu_s, mu_d, 0.0), kind))
    assert bounds_at(load * (1.0 - 1e-12)) == below
    assert bounds_at(load) == below  # equality belongs to the lower regime
    assert bounds_at(load * (1.0 + 1e-12)) == above


@pytest.mark.parametrize("trough_deg", [-8.0, 0.0, 5.0])
@pytest.mark.parametrize("bands", [{"kinetic_friction": (0.5, 0.6)}, {"friction_ratio": (0.7, 0.9)}])
def test_the_guarantee_of_a_box_is_the_same(trough_deg: float, bands: dict[str, Span]) -> None:
    amplitudes = np.array([0.3, 0.6, 0.75, 0.9, 1.0]) * 1e-3
    scenes = scene_with(amplitude=amplitudes, trough_angle=math.radians(trough_deg))
    ((name, second),) = bands.items()
    is_ratio = name == "friction_ratio"
    found = certain(scenes, static_friction=STATIC, second_friction=second, is_ratio=is_ratio)
    proved = np.flatnonzero(~np.isnan(found.speed_min))
    assert proved.size > 1
    for i in proved:
        scene = scene_with(amplitude=amplitudes[i], trough_angle=math.radians(trough_deg))
        whole = guarantee(scene, static_friction=STATIC, **bands)
        assert whole.found_min == found.speed_min[i]
        assert (min(whole.regimes), max(whole.regimes)) == (found.lowest[i], found.highest[i])


def test_back_slip_may_begin_inside_a_ratio_band_on_a_decline(monkeypatch: pytest.MonkeyPatch) -> None:
    ratio, shares = (0.41, 0.48), np.linspace(0.0, 1.0, 401)
    beta = math.radians(-8.0)
    mu_s = 0.2 + shares * 0.6
    known = critical_loads_of_lines(ALPHA, mu_s, ratio[1] * mu_s, beta).back_slip
    first = int(np.argmin(known))
    assert 0 < first < 400
    assert known[first] < 0.99 * min(known[0], known[-1])
    box, loads = Frictions((0.2, 0.8), ratio, True), np.array([0.999, 1.001]) * known[first]
    amplitude = loads * GRAVITY / (2.0 * math.pi * FREQUENCY) ** 2
    points = {"amplitude": amplitude, "frequency": FREQUENCY, "drive_angle": ALPHA, "trough_angle": beta}
    assert box.certain_of(points).highest.tolist() == [Regime.FORWARD_SLIP, Regime.BACK_SLIP]
    monkeypatch.setattr("vibro.designs.guarantees._HALVINGS", 1)
    assert box.certain_of(points).highest.tolist() == [Regime.BACK_SLIP] * 2  # what is not proved is not said


def test_bodies_that_run_away() -> None:
    steep = {"frequency": FREQUENCY, "drive_angle": ALPHA, "amplitude": np.array([1e-6, 5e-4])}
    box = Frictions((0.3, 0.5), (0.1, 0.2), False)
    # steeper than any friction: all slide, at a speed that has no end
    for slope, regime in ((-1.0, Regime.FORWARD_SLIP), (1.0, Regime.BACK_SLIP)):
        found = box.certain_of(steep | {"trough_angle": slope * math.atan(0.6)})
        assert np.all(found.lowest == regime)
        assert np.all(found.highest == regime)
        assert np.all(np.isnan(found.speed_min))
    # all rest, until one is pushed that nothing brakes
    found = box.certain_of(steep | {"trough_angle": -math.atan(0.15)})
    assert (found.lowest[0], found.highest[0], found.speed_min[0]) == (0, 0, 0.0)
    assert found.highest[1] > 0
    assert np.isnan(found.speed_min[1])


def test_kinetic_friction_that_rounding_alone_tells_from_the_weight() -> None:
    rng = np.random.default_rng(22)
    lost = 0
    for _ in range(40):
        mu_d = float(rng.uniform(0.1, 0.6))
        box = Frictions((mu_d, mu_d * 1.3), (mu_d, mu_d), False)
        load = rng.uniform(0.05, 0.6, CELLS)
        points = {
            "amplitude": load * GRAVITY / (2.0 * math.pi * FREQUENCY) ** 2,
            "frequency": FREQUENCY,
            "drive_angle": rng.uniform(0.0, 1.0, CELLS),
            "trough_angle": -np.arctan(mu_d * (1.0 + 2.0**-52 * rng.integers(-4, 5, CELLS))),
        }
        mu_s, kinetic = attackers(rng, box)
        bodies = solved(points, mu_s[:, None], kinetic[:, None])
        lost += int(np.count_nonzero(bodies.status == Status.RUNAWAY))
        proved = ~np.isnan(box.certain_of(points).speed_min)
        assert not np.isnan(bodies.mean_velocity[:, proved]).any()
    assert lost > 1000


def test_bodies_without_friction_have_no_regime() -> None:
    points = {"amplitude": np.array([1e-3, 1e-1]), "frequency": FREQUENCY, "drive_angle": ALPHA}
    found = Frictions((0.0, 0.5), (0.0, 0.1), False).certain_of(points)
    assert found.lowest.tolist() == [Regime.UNDEFINED, Regime.HOPPING]
    assert found.highest.tolist() == [Regime.BACK_SLIP, Regime.HOPPING]
    assert np.isnan(found.speed_min).all()
    none = Frictions((0.0, 0.0), (0.0, 0.0), False).certain_of(points)
    assert none.lowest.tolist() == none.highest.tolist() == [Regime.UNDEFINED, Regime.HOPPING]
