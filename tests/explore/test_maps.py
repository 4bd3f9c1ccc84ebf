"""A map as the page gets it: what it is told of cells and curves is what the library says."""

from __future__ import annotations

from base64 import b64decode
from typing import Any

import numpy as np
import pytest
from helpers.packed import state_of, unpacked
from numpy.typing import NDArray

import vibro
from vibro.core.codes import Regime, Status
from vibro.explore.bands import extreme_frictions
from vibro.explore.controls import DRIVES, VIEWS
from vibro.explore.levels import MapCells
from vibro.explore.looks import HATCHES, MARKS
from vibro.explore.maps import packed_map
from vibro.explore.packing import pack
from vibro.explore.state import HEIGHT, WIDTH, State
from vibro.quantities import QUANTITIES
from vibro.results.steady import SteadyCycle
from vibro.sweeps.grid import scene_of

CURVES = ("forward_onset", "back_slip", "continuous_sliding", "hop")
NO_ANSWER = 4  # in the palette, after the regimes
BAND = {"static_friction_band": "0.6:0.8"}


def drawn(state: State, *, done: bool = False) -> tuple[dict[str, Any], dict[str, NDArray[Any]], SteadyCycle]:
    """Return a map as the page gets it, and what is solved of it, of the shape (y, x)."""
    cells = MapCells(state.grid())
    while done and not cells.shown.is_done:
        cells.advance(0.2)
    header, arrays = unpacked(packed_map(state, cells.shown))
    cycle = cells.shown.cycle
    if next(iter(state.grid().axes)) == state.x.quantity.name:
        cycle = SteadyCycle(**{name: values.T for name, values in cycle.arrays().items()})
    return header, arrays, cycle


def marked(arrays: dict[str, NDArray[Any]], name: str) -> NDArray[np.bool_]:
    return (arrays["marks"] & MARKS[name]) > 0


def points_of(header: dict[str, Any], arrays: dict[str, NDArray[Any]]) -> dict[str, NDArray[Any]]:
    """Return the points of every curve, by its name."""
    found, first = {}, 0
    for curve in header["curves"]:
        last = first + curve["count"]
        points = arrays["points"][first:last]
        found[curve["name"]] = points[~np.isnan(points[:, 0])]
        assert np.isnan(points[-1]).all()
        first = last
    assert first == len(arrays["points"])
    return found


def scene_at(state: State, points: NDArray[Any], **frictions: float) -> vibro.Scene:
    """Make the scenes of points, which are shares of the axes; ``frictions`` in place of the state's."""
    fixed = {**state.grid().fixed, **frictions}
    for spec, share in zip((state.x, state.y), points.T, strict=True):
        ends = [float(end) for end in spec.values]
        fixed[spec.quantity.name] = (
            ends[0] * (ends[1] / ends[0]) ** share if spec.log else ends[0] + share * (ends[1] - ends[0])
        )
    return scene_of({name: np.atleast_1d(value).astype(float) for name, value in fixed.items()})


@pytest.mark.parametrize(
    ("drive", "view"), [*(("line", view) for view in VIEWS), *((drive, "speed") for drive in [*DRIVES][1:])]
)
def test_every_view_and_every_drive_is_drawn(drive: str, view: str) -> None:
    header, arrays, cycle = drawn(state_of(drive=drive, view=view, target="20", frequency_hz="35"))
    shape = (HEIGHT, WIDTH)
    names = ["speed"] * (view != "speed") + ["values"] * (view != "regime")
    names += ["regime", "status", "faces", "others", "marks"]
    cells = {name: x.shape for name, x in arrays.items() if name != "points"}
    assert cells == dict.fromkeys(names, shape)
    assert (header["x"]["count"], header["y"]["count"]) == (WIDTH, HEIGHT)
    speed = arrays["values" if view == "speed" else "speed"]
    assert np.array_equal(speed, (1e3 * cycle.mean_velocity).astype("f4"), equal_nan=True)
    assert np.array_equal(arrays["regime"], cycle.regime)
    told = arrays["status"] >= 0  # the others are not computed yet
    assert np.array_equal(arrays["status"][told], cycle.status[told])
    assert np.isnan(speed[~told]).all()
    assert (header["scale"] is None) == (view == "regime")
    first, count = header["scale"]["colours"] if header["scale"] else (9, 0)
    assert len(b64decode(header["palette"])) == 3 * (first + count)
    assert arrays["faces"].max() < first + count
    assert all(0.0 <= share <= 1.0 for axis in ("x", "y") for share, _ in header[axis]["ticks"])
    for name, points in points_of(header, arrays).items():
        assert len(points), name
        assert (np.abs(points - 0.5) < 0.5 + 1e-6).all(), name


@pytest.mark.parametrize(
    "query",
    [
        {},
        {"x_range": "5:60:log", "y_range": "0.1:3:log"},
        {"x": "amplitude_mm", "y": "frequency_hz"},
        {"x": "drive_angle_deg", "y": "static_friction"},
        {"x": "trough_angle_deg", "y": "frequency_hz"},
    ],
    ids=lambda query: "-".join(query.values()) or "usual",
)
def test_curves_lie_where_regimes_begin(query: dict[str, str]) -> None:
    state = state_of(**query)
    header, arrays, _ = drawn(state)
    exact = {state.x.quantity.name, state.y.quantity.name} == {"amplitude", "frequency"}
    curves = points_of(header, arrays)
    curves.pop("zero_speed", None)
    assert curves
    for name, points in curves.items():
        scene = scene_at(state, points)
        critical = getattr(vibro.critical_loads(scene), name)
        off = np.abs(scene.load / critical - 1.0)
        # Over amplitude and frequency curves are exact but for single precision, elsewhere to a small part of
        # a cell, over which loads change by several percent.
        assert off.max() < (1e-5 if exact else 0.02), name


@pytest.mark.parametrize("query", [{}, {"trough_angle_deg": "-6", "follow": "0"}, {"drive": "ellipse"}])
def test_a_target_is_met_where_bodies_are_fast_enough_and_do_not_hop(query: dict[str, str]) -> None:
    state = state_of(view="speed", target="20", **query)
    header, arrays, cycle = drawn(state)
    with np.errstate(invalid="ignore"):
        fast = (1e3 * cycle.mean_velocity >= 20.0) & (cycle.regime != Regime.HOPPING)
    assert fast.any()
    assert np.array_equal(marked(arrays, "misses"), ~fast)
    assert "target" in points_of(header, arrays)


def test_a_target_is_met_by_all_bodies_of_a_band() -> None:
    state = state_of(view="speed", target="5", **BAND)
    _, arrays, _ = drawn(state)
    meets = ~marked(arrays, "misses")
    assert meets.any()
    points = np.argwhere(meets)[:: max(1, meets.sum() // 50)]
    shares = np.column_stack([points[:, 1] / (WIDTH - 1), points[:, 0] / (HEIGHT - 1)])
    for mu_s in (0.6, 0.65, 0.7, 0.75, 0.8):
        body = scene_at(state, shares, static_friction=mu_s, kinetic_friction=mu_s * 0.57 / 0.74)
        assert (1e3 * vibro.solve(body).mean_velocity >= 5.0 * (1 - 1e-12)).all()


def test_bands_show_what_is_certain() -> None:
    header, arrays, _ = drawn(state_of(**BAND, kinetic_friction_band="0.4:0.6"))
    assert header["bands"]
    lowest, highest = arrays["lowest"], arrays["highest"]
    assert (lowest <= highest).all()
    assert (lowest == highest).any()
    assert (lowest < highest).any()
    rng = np.random.default_rng(0)
    state = state_of()
    cells = rng.integers(0, [HEIGHT, WIDTH], (300, 2))
    shares = np.column_stack([cells[:, 1] / (WIDTH - 1), cells[:, 0] / (HEIGHT - 1)])
    for mu_s, mu_d in [
        (0.6, 0.4),
        (0.6, 0.6),
        (0.8, 0.4),
        (0.8, 0.6),
        *rng.uniform([0.6, 0.4], [0.8, 0.6], (5, 2)),
    ]:
        body = scene_at(state, shares, static_friction=mu_s, kinetic_friction=min(mu_d, mu_s))
        regime = vibro.solve(body, flight=False).regime
        at = tuple(cells.T)
        assert (lowest[at] <= regime).all()
        assert (regime <= highest[at]).all()


def test_curves_of_bands_are_of_their_extreme_bodies() -> None:
    state = state_of(**BAND)
    header, arrays, _ = drawn(state)
    curves = points_of(header, arrays)
    assert {*curves} == {
        "hop",
        *(f"{n}_{w}" for n in ("forward_onset", "back_slip") for w in ("least", "most")),
    }
    for which, mu_s in (("least", 0.6), ("most", 0.8)):
        for name in ("forward_onset", "back_slip"):
            points = curves[f"{name}_{which}"]
            body = scene_at(state, points, static_friction=mu_s, kinetic_friction=mu_s * 0.57 / 0.74)
            assert np.abs(body.load / getattr(vibro.critical_loads(body), name) - 1.0).max() < 1e-5


def test_the_first_body_to_slip_has_no_less_static_than_kinetic_friction() -> None:
    bands = {"static_friction_band": "0.5:0.8", "kinetic_friction_band": "0.6:0.7", "follow": "0"}
    assert extreme_frictions(state_of(**bands)) == {"least": (0.6, 0.6), "most": (0.8, 0.6)}
    apart = bands | {"kinetic_friction_band": "0.3:0.4"}
    assert extreme_frictions(state_of(**apart)) == {"least": (0.5, 0.4), "most": (0.8, 0.3)}


def test_a_ratio_may_be_a_band() -> None:
    narrow = drawn(state_of(**BAND))[1]
    same = drawn(state_of(**BAND, friction_ratio_band=f"{0.57 / 0.74}:{0.57 / 0.74}"))[1]
    wide = drawn(state_of(**BAND, friction_ratio_band="0.1:1"))[1]
    assert np.array_equal(narrow["lowest"], same["lowest"])
    assert np.array_equal(narrow["highest"], same["highest"])
    assert (wide["lowest"] <= narrow["lowest"]).all()
    assert (wide["highest"] >= narrow["highest"]).all()
    assert (wide["lowest"] < narrow["lowest"]).any()


def test_words_say_what_is_held_and_what_is_best() -> None:
    header, arrays, _ = drawn(state_of(view="speed", x_range="5:14", target="12"))
    assert header["caption"] == "α = 20°, μ_s = 0.74, μ_d = 0.57, L = 600 mm"
    row, column = np.unravel_index(np.nanargmax(arrays["values"]), arrays["values"].shape)
    assert (int(row), int(column)) == (HEIGHT - 1, WIDTH - 1)
    best = next(note for note in header["notes"] if note.startswith("Largest here: "))
    assert best.endswith("at frequency 14 Hz and amplitude 3 mm.")
    assert header["curves"][-1]["label"] == "12 mm/s, without hopping"
    sure = drawn(state_of(view="speed", target="5", **BAND))[0]
    assert sure["caption"] == "α = 20°, μ_s = 0.6 to 0.8, μ_d/μ_s = 0.77027, L = 600 mm"
    own = drawn(state_of(**BAND, kinetic_friction_band="0.4:0.5"))[0]
    assert own["caption"] == "α = 20°, μ_s = 0.6 to 0.8, μ_d = 0.4 to 0.5, L = 600 mm"
    assert sure["title"] == "guaranteed mean conveying speed"
    outside = drawn(state_of(static_friction_band="0.3:0.4", friction_ratio_band="0.7:0.9"))[0]["notes"]
    assert any("lies outside of its bands" in note for note in outside)
    assert drawn(state_of(restitution="0.5"))[0]["progress"]["text"] == ""  # regimes are exact at once
    flights = drawn(state_of(view="impact", x_range="5:7"))[0]
    assert flights["scale"]["ticks"] == []


def test_guaranteed_speeds_are_told_as_such() -> None:
    header, arrays, _ = drawn(state_of(view="speed", **BAND))
    assert header["label"].startswith("guaranteed")
    unproved = marked(arrays, "unproved")
    assert unproved.any()
    assert np.array_equal(unproved, arrays["faces"] == NO_ANSWER)
    assert np.isnan(arrays["values"][unproved]).all()
    assert "speed" not in arrays  # that of one body
    flights, _, _ = drawn(state_of(view="impact", **BAND))
    assert any("Flights depend on friction" in note for note in flights["notes"])


def test_marks_tell_what_a_cell_is() -> None:
    header, arrays, cycle = drawn(state_of(view="speed", trough_angle_deg="12"), done=True)
    backwards = marked(arrays, "backwards")
    assert backwards.any()
    assert (cycle.mean_velocity[backwards] < 0.0).all()
    assert np.array_equal(arrays["faces"] == Regime.NO_SLIP, cycle.regime == Regime.NO_SLIP)
    assert not marked(arrays, "preview").any()
    assert "zero_speed" in points_of(header, arrays)
    assert header["progress"] == {"done": True, "share": 1.0, "text": ""}
    flights = drawn(state_of(view="flight"))[1]
    assert np.array_equal(flights["faces"] == Regime.NO_SLIP, flights["regime"] != Regime.HOPPING)
    first, arrays, _ = drawn(state_of(restitution="0.5", view="speed"))
    assert np.array_equal(marked(arrays, "unknown"), arrays["regime"] == Regime.HOPPING)
    assert np.array_equal(marked(arrays, "unknown"), arrays["status"] < 0)
    assert not first["progress"]["done"]
    steep = drawn(state_of(x="drive_angle_deg", y="static_friction", follow="0"))[1]
    assert np.isnan(steep["speed"][steep["status"] == Status.INFEASIBLE]).all()


def test_traverse_times_are_the_length_over_the_speed() -> None:
    _, arrays, cycle = drawn(state_of(view="traverse", trough_length_mm="1234"))
    moves = cycle.mean_velocity > 0.0
    assert np.allclose(arrays["values"][moves], 1.234 / cycle.mean_velocity[moves], rtol=1e-6)
    assert np.isnan(arrays["values"][~moves]).all()


def test_the_legend_tells_what_is_seen() -> None:
    header, arrays, _ = drawn(state_of(**BAND))
    told = {item["text"]: item for item in header["legend"]}
    assert [*told][:4] == ["no-slip", "forward-slip", "back-slip", "hopping"]
    assert len(told) == 5
    (either,) = (item for item in header["legend"] if item["marks"])
    assert np.array_equal(marked(arrays, "either"), arrays["lowest"] < arrays["highest"])
    assert either["marks"] == MARKS["either"]
    assert np.array_equal(arrays["faces"], arrays["lowest"])
    assert np.array_equal(arrays["others"], arrays["highest"])
    steep, arrays, _ = drawn(state_of(x="drive_angle_deg", y="static_friction", follow="0"))
    hatched = arrays["status"] == Status.INFEASIBLE
    assert np.array_equal(marked(arrays, HATCHES[Status.INFEASIBLE]), hatched & (arrays["regime"] < 0))
    assert "infeasible" in [item["text"] for item in steep["legend"]]


def test_an_axis_is_described_as_it_is_printed() -> None:
    header = drawn(state_of(x="drive_angle_deg", y_range="0.1:3:log"))[0]
    x, y = header["x"], header["y"]
    assert (x["title"], x["unit"], x["count"]) == ("drive angle α [°]", "°", WIDTH)
    assert (x["from"], x["to"], x["log"]) == (0.0, 80.0, False)
    assert x["ticks"] == [[n / 8, str(10 * n)] for n in range(9)]
    assert [text for _, text in y["ticks"]] == ["0.1", "0.2", "0.5", "1", "2"]
    assert y["ticks"][3][0] == pytest.approx(np.log(10) / np.log(30))
    assert QUANTITIES["drive_angle"].column == x["column"]


def test_arrays_are_packed_where_they_are_told_to_be() -> None:
    arrays: dict[str, NDArray[Any]] = {
        "a": np.arange(3, dtype=np.int8),
        "b": np.arange(6, dtype=np.float32).reshape(2, 3),
        "c": np.empty((0, 2), np.float32),
        "d": np.array([255], np.uint8),
    }
    header, read = unpacked(pack({"text": "µ"}, arrays))
    assert header["text"] == "µ"
    assert all(np.array_equal(read[name], values) for name, values in arrays.items())
    with pytest.raises(ValueError, match="not JSON compliant"):
        pack({"number": float("nan")}, {})
