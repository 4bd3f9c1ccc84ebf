"""The page's map in node: its cells, curves, colours and files are those of vibro."""

from __future__ import annotations

import math
import shlex
import tomllib
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import numpy as np
import pytest
from helpers.commands import rows_of
from helpers.explored_scenes import FEEDER, GIVEN_DRIVES
from helpers.whole_page import in_modules
from matplotlib.ticker import LogLocator, MaxNLocator
from typer.testing import CliRunner

import vibro
from vibro.axes import parse_axis
from vibro.cli.app import app
from vibro.core.codes import Regime, Status
from vibro.plots.scales import scale_of, time_scale
from vibro.quantities import QUANTITIES, SWEPT
from vibro.results.steady import SteadyCycle
from vibro.sweeps.grid import Grid, scene_of
from vibro.sweeps.whole import request_of_call

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from vibro.sweeps.request import Request

BAND: Final = {"static_friction_band": "0.6:0.8"}
CURVES: Final = ("forward_onset", "back_slip", "continuous_sliding", "hop")

# Solve maps of few cells, and tell what they show.
_SOLVE = """
export async function run({ data, stateOf, jobOf, MapCells, Pool, drawnMap }, asked) {
  const pool = new Pool(data, []), answers = [];
  for (const { scene = 0, texts, nx, ny, isDrawn } of asked) {
    const { state, problems } = stateOf(data, scene, texts);
    if (!state) throw new Error(JSON.stringify(problems));
    const cells = new MapCells(jobOf(state, nx, ny));
    await pool.solve(cells.job, 3, (block) => cells.put(block));
    const { cells: _, scale, ...map } = isDrawn ? drawnMap(data, state, cells) : {};
    answers.push({ job: cells.job, rows: cells.rows, state, map, scale: scale && { ...scale } });
  }
  return answers;
}
"""


def solved(*texts: dict[str, str], nx: int = 40, ny: int = 30, **more: Any) -> list[Any]:
    """Solve maps of the nut that differ from the page's first one, as the page does."""
    return list(in_modules(_SOLVE, [{"texts": t, "nx": nx, "ny": ny, **more} for t in texts]))


def drawn(*texts: dict[str, str], nx: int = 60, ny: int = 45) -> list[Any]:
    """Return what maps show."""
    return solved(*texts, nx=nx, ny=ny, isDrawn=True)


def array(values: Any) -> NDArray[Any]:
    return np.array(values, float)


def grid_of(one: Any, request: Request | None = None) -> Grid:
    """Return the grid of a map's cells."""
    job, axes = one["job"], {}
    for key in ("x", "y"):
        axis, count = one["state"][key], len(job[key]["values"])
        text = f"{axis['from']!r}:{axis['to']!r}:{count}" + ":log" * axis["log"]
        axes[axis["name"]] = parse_axis(text, QUANTITIES[axis["name"]]).axis(count)
    swept = {name: axes[name] for name in SWEPT if name in axes}
    if request is None:
        return Grid(swept, job["values"], None)
    motion = request.motion if (job["given"] or {}).get("kind") == "pieces" else None
    return Grid(swept, job["values"], None, motion=motion, machine=request.machine)


def cells_of(one: Any, request: Request | None = None) -> SteadyCycle:
    """Solve the cells of a map by vibro, row after row."""
    grid = grid_of(one, request)
    cycle = grid.solve(grid.values())
    if next(iter(grid.axes)) == one["state"]["x"]["name"]:
        cycle = SteadyCycle(**{name: x.T for name, x in cycle.arrays().items()})
    return cycle


def assert_same(one: Any, request: Request | None = None) -> None:
    cycle = cells_of(one, request)
    rows = one["rows"]
    for name in ("regime", "status", "coexists", "model_code"):
        assert np.array_equal(rows[name], getattr(cycle, name).ravel()), name
    means = cycle.status.ravel() == Status.AVERAGED
    for name in ("mean_velocity", "impact_velocity", "flight_fraction", "throw_number", "peak_velocity"):
        ours, theirs = array(rows[name]), getattr(cycle, name).ravel()
        size = np.nanmax(np.abs(theirs), initial=1e-3)
        assert np.allclose(ours[~means], theirs[~means], 1e-9, 1e-10 * size, equal_nan=True), name
    off = np.abs(array(rows["mean_velocity"]) - cycle.mean_velocity.ravel())[means]
    assert (off <= 8.0 * cycle.mean_velocity_error.ravel()[means]).all()


_MAPS: Final[tuple[dict[str, str], ...]] = (
    {},
    {"x_range": "5:60:log", "y_range": "0.1:3:log"},
    {"x": "amplitude_mm", "y": "frequency_hz", "x_range": "0.1:0.7", "restitution": "0.2"},
    {"x": "drive_angle_deg", "y": "static_friction", "follow": "0"},
    {"x": "static_friction", "y": "trough_angle_deg"},
    {"x": "static_friction", "y": "friction_ratio"},
    {"x": "frequency_hz", "y": "restitution", "x_range": "10:40"},
    {"drive": "ellipse"},
    {"drive": "harmonics", "frequency_hz": "20"},
)  # fmt: skip


def test_cells_are_those_of_vibro() -> None:
    found = solved(*_MAPS, nx=24, ny=18)
    for one in found:
        for key in ("x", "y"):  # to the last bit, and powers to rounding
            values = grid_of(one).axes[one["state"][key]["name"]].values
            off = np.abs(np.array(one["job"][key]["values"]) - values)
            assert (off <= np.abs(values) * (3e-15 if one["state"][key]["log"] else 0.0)).all()
        assert_same(one)


@pytest.fixture
def requests(tmp_path: Path) -> list[Request]:
    """Return the requests of scenes that no slider makes, and of a machine."""
    found = []
    for number, text in enumerate([*GIVEN_DRIVES.values(), FEEDER]):
        (file := tmp_path / f"scene{number}.toml").write_text(text, encoding="utf-8")
        found.append(request_of_call(file, {}))
    return found


def test_cells_of_given_drives_and_machines_are_those_of_vibro(requests: list[Request]) -> None:
    asked = [{"scene": number, "texts": {}, "nx": 6, "ny": 5} for number in range(len(requests))]
    for one, request in zip(in_modules(_SOLVE, asked, requests), requests, strict=True):
        assert_same(one, request)
        if request.machine is not None:
            values = grid_of(one, request).values()
            assert np.allclose(array(one["rows"]["amplitude"]) * 1e3, values["amplitude"].T.ravel(), 1e-9)


def points_of(one: Any) -> dict[str, NDArray[Any]]:
    """Return the points of each curve, in the units outside."""
    found = {}
    for curve in one["map"]["curves"]:
        shares = np.array([point for line in curve["lines"] for point in line])
        ends = [(one["state"][key]["from"], one["state"][key]["to"]) for key in ("x", "y")]
        logs = [one["state"][key]["log"] for key in ("x", "y")]
        columns = [
            low * (high / low) ** share if log else low + share * (high - low)
            for (low, high), share, log in zip(ends, shares.T, logs, strict=True)
        ]
        found[curve["name"]] = np.column_stack(columns)
    return found


def scene_at(one: Any, points: NDArray[Any], **frictions: float) -> vibro.Scene:
    fixed = {**one["job"]["values"], **frictions}
    for key, column in zip(("x", "y"), points.T, strict=True):
        fixed[one["state"][key]["name"]] = column
    if "friction_ratio" in fixed:
        fixed["kinetic_friction"] = fixed["friction_ratio"] * fixed["static_friction"]
    return scene_of({name: np.atleast_1d(value).astype(float) for name, value in fixed.items()})


def test_curves_lie_where_regimes_begin() -> None:
    """Exactly over amplitude and frequency, elsewhere to a small part of a cell."""
    axes = ({"x": "trough_angle_deg", "y": "frequency_hz"}, {"x": "amplitude_mm", "y": "frequency_hz"})
    for one in drawn(_MAPS[0], _MAPS[1], _MAPS[3], *axes):
        curves = points_of(one)
        exact = {one["state"][key]["name"] for key in ("x", "y")} == {"amplitude", "frequency"}
        assert "back_slip" in curves
        for name in {*CURVES} & {*curves}:
            scene = scene_at(one, curves[name])
            off = np.abs(scene.load / getattr(vibro.critical_loads(scene), name) - 1.0)
            assert off.max() < (1e-9 if exact else 0.02), name
            if one["state"]["y"]["name"] == "static_friction":  # it ends where kinetic friction is the larger
                assert curves[name][:, 1].min() >= 0.57 - 1e-9


def test_a_target_is_reached_at_its_curve() -> None:
    (one,) = drawn({"view": "speed", "target": "30"}, nx=100, ny=75)
    scene = scene_at(one, points_of(one)["target"])
    limits = vibro.critical_loads(scene)
    off = np.abs(1e3 * vibro.solve(scene).mean_velocity / 30.0 - 1.0)
    # where back slip begins speeds jump from above the target to below it
    jumps, hops = (np.abs(scene.load / limit - 1.0) < 1e-9 for limit in (limits.back_slip, limits.hop))
    assert jumps.any()
    assert hops.any()
    assert off[~jumps & ~hops].max() < 0.015


def test_bands_show_curves_of_their_extreme_bodies_and_the_least_of_their_samples() -> None:
    frictions = {"static_friction_band": "0.6:0.8", "kinetic_friction_band": "0.4:0.7", "follow": "0"}
    edge, second, one, narrow, flights = drawn(
        BAND,
        {**BAND, "drive": "harmonics"},  # no formula has its critical loads
        {**frictions, "view": "speed", "restitution_band": "0:0.1", "x_range": "5:25"},
        {"static_friction_band": "0.7:0.7"},
        {"static_friction_band": "0.7:0.8", "view": "flight"},
        nx=20,
        ny=15,
    )
    curves, edges = points_of(edge), {"forward_onset", "back_slip"}
    assert {*curves} == {"hop", *(f"{name}_{which}" for name in edges for which in ("least", "most"))}
    for which, mu_s in (("least", 0.6), ("most", 0.8)):
        for name in edges:
            own = {"static_friction": mu_s, "kinetic_friction": mu_s * 0.57 / 0.74}
            body = scene_at(edge, curves[f"{name}_{which}"], **own)
            assert np.abs(body.load / getattr(vibro.critical_loads(body), name) - 1.0).max() < 1e-9
    assert {*points_of(second)} <= {"hop"}
    assert len(one["job"]["bodies"]) == 15
    least, lowest, highest = (array(one["rows"][n]) for n in ("sampled_velocity", "lowest", "highest"))
    grid, speeds = grid_of(one), []
    for body in one["job"]["bodies"]:
        assert body["kinetic_friction"] <= body["static_friction"]
        fixed = {**grid.fixed, **{name: x for name, x in body.items() if x is not None}}
        cycle = Grid(grid.axes, fixed, None).solve(Grid(grid.axes, fixed, None).values())
        assert (lowest <= cycle.regime.ravel()).all()
        assert (highest >= cycle.regime.ravel()).all()
        speeds.append(np.where(cycle.status == Status.AVERAGED, np.inf, cycle.mean_velocity).ravel())
    sure = np.isfinite(speeds).all(axis=0)
    assert sure.mean() > 0.5
    assert np.allclose(least[sure], np.min(speeds, axis=0)[sure], 1e-9, 1e-12)
    assert "sampled: the least of a few bodies" in [item["text"] for item in one["map"]["legend"]]
    assert len(narrow["job"]["bodies"]) == 1
    assert "lies outside of its bands" in narrow["map"]["notes"][0]
    assert not flights["job"]["bodies"]
    assert flights["map"]["notes"][-1].startswith("Flights are those of the operating point")


_VIEWS: Final = ("regime", "speed", "traverse", "impact", "flight")


def test_every_view_shows_its_numbers() -> None:
    for view, one in zip(_VIEWS, drawn(*({"view": v, "target": "20"} for v in _VIEWS)), strict=True):
        assert_shows(view, one)


def assert_shows(view: str, one: Any) -> None:
    shown, rows = one["map"], one["rows"]
    speed, regime = 1e3 * array(rows["mean_velocity"]), array(rows["regime"])
    hops = regime == Regime.HOPPING
    expected = {
        "speed": speed,
        "traverse": np.where(speed > 0.0, 600.0 / np.where(speed > 0.0, speed, 1.0), np.nan),
        "impact": 1e3 * array(rows["impact_velocity"]),
        "flight": array(rows["flight_fraction"]),
    }
    faces = np.array(shown["faces"])
    if view == "regime":
        assert shown["numbers"] is None
        assert np.array_equal(faces, regime)
    else:
        assert np.array_equal(array(shown["numbers"]), expected[view], equal_nan=True)
        rests = regime == Regime.NO_SLIP if view in ("speed", "traverse") else ~hops
        assert np.array_equal(faces == 0, rests)
        best = np.nanargmin if view == "traverse" else np.nanargmax
        number = expected[view][best(np.where(rests, np.nan, expected[view]))]
        assert f"here: {number:.5g}" in shown["notes"][0]
    marks = {item["text"]: item["marks"] for item in shown["legend"]}
    misses = (np.array(shown["marks"]) & marks["slower than 20 mm/s, or hops"]) > 0
    assert np.array_equal(misses, ~((speed >= 20.0) & ~hops))
    assert shown["curves"][-1]["label"] == "20 mm/s, without hopping"
    assert shown["caption"] == "α = 20°, μ_s = 0.74, μ_d = 0.57, L = 600 mm"
    assert (shown["x"]["title"], shown["y"]["title"]) == ("frequency f [Hz]", "amplitude A [mm]")


def test_bodies_that_move_backwards_are_marked() -> None:
    (one,) = drawn({"view": "speed", "trough_angle_deg": "12"})
    marks = {item["text"]: item["marks"] for item in one["map"]["legend"]}
    backwards = (np.array(one["map"]["marks"]) & marks["moves backwards"]) > 0
    speed = array(one["rows"]["mean_velocity"])
    assert backwards.any()
    assert (speed[backwards] < 0.0).all()
    assert one["scale"]["palette"] == "RdBu"
    assert "zero_speed" in points_of(one)


# ------------------------------------------------------------------------------
# Scales and round numbers.


_SCALES = """
export const run = ({ speedScale, timeScale, roundNumbers }, { speeds, times, ranges }) => ({
  speeds: speeds.map(({ seen, regular, calm, reverses }) => {
    const scale = speedScale(...[seen, regular, calm].map((x) => Float64Array.from(x)), reverses);
    return { ...scale, shares: seen.map(scale.share) };
  }),
  times: times.map((seen) => {
    const scale = timeScale(Float64Array.from(seen));
    return { ...scale, shares: seen.map(scale.share) };
  }),
  ranges: ranges.map(([low, high, log]) => roundNumbers(low, high, log)),
});
"""


def test_scales_are_those_of_pictures() -> None:
    rng = np.random.default_rng(1)
    speeds, ranges = [], []
    for _ in range(200):
        seen = rng.choice([1.0, 10.0, 300.0]) * rng.lognormal(0.0, rng.choice([0.1, 1.0, 3.0]), 60)
        reverses = bool(rng.random() < 0.4)
        seen *= np.where(rng.random(60) < 0.3, -1.0, 1.0) if reverses else 1.0
        speeds.append((seen, seen[: rng.integers(0, 60)], seen[rng.integers(0, 60) :], reverses))
        low = float(rng.lognormal(0.0, 3.0))
        ranges.append((low, low * float(1.0 + rng.lognormal(0.0, 3.0)), bool(rng.random() < 0.5)))
    times = [np.abs(seen) for seen, *_ in speeds[:50]] + [np.array([2.0, 3.0])]
    asked = {
        "speeds": [
            dict(
                zip(
                    ("seen", "regular", "calm", "reverses"),
                    (a.tolist(), b.tolist(), c.tolist(), r),
                    strict=True,
                )
            )
            for a, b, c, r in speeds
        ],
        "times": [seen.tolist() for seen in times],
        "ranges": ranges,
    }
    found = in_modules(_SCALES, asked)
    expected = [scale_of(*parts, reverses=reverses) for *parts, reverses in speeds]
    for told, scale, (seen, *_) in zip(found["speeds"], expected, speeds, strict=True):
        assert told["palette"] == scale.colours
        shares = np.ma.filled(np.clip(scale.norm(np.where(seen > 0, seen, scale.norm.vmin)), 0.0, 1.0), 0.0)
        usual = scale.norm(seen) if told["palette"] == "RdBu" or scale.norm.vmin == 0.0 else shares
        assert np.allclose(told["shares"], np.clip(usual, 0.0, 1.0), atol=1e-9)
        assert all(0.0 <= share <= 1.0 for share, _ in told["ticks"])
    for told, seen in zip(found["times"], times, strict=True):
        assert np.allclose(told["shares"], np.clip(time_scale(seen).norm(seen), 0.0, 1.0), atol=1e-9)
    for (low, high, log), numbers in zip(ranges, found["ranges"], strict=True):
        subs = (1.0, 2.0, 5.0) if high < 200.0 * low else (1.0,)
        locator: Any = MaxNLocator(8, steps=[1, 2, 2.5, 5, 10])
        if log and high > 5.0 * low:
            locator = LogLocator(subs=subs, numticks=99)
        slack = 1e-9 * (high - low)
        ours = [x for x in locator.tick_values(low, high) if low - slack <= x <= high + slack]
        assert numbers == pytest.approx(ours, rel=1e-9), (low, high, log)


# ------------------------------------------------------------------------------
# Workers.


_POOL = """
const later = () => new Promise((resolve) => setTimeout(resolve));
export async function run({ data, stateOf, jobOf, Pool, solveMap }) {
  const posted = [];
  const worker = () => {
    const own = { id: posted.length, postMessage: (message) => posted.push({ worker: own, message }) };
    return own;
  };
  const answer = ({ worker, message: { id, job, begin, end } }, took = 1.0) => {
    const rows = { regime: new Int8Array((end - begin) * job.x.values.length) };
    worker.onmessage({ data: { id, begin, end, rows, took } });
  };
  const workers = [worker(), worker()];
  const pool = new Pool(data, workers);
  const { state } = stateOf(data, 0, {});
  const job = jobOf(state, 20, 30);
  const taken = [];
  const first = pool.solve(job, 7, ({ begin, end }) => taken.push(["first", begin, end]));
  const stale = posted.splice(0);
  const second = pool.solve(job, 7, ({ begin, end }) => taken.push(["second", begin, end]));
  const waiting = posted.length;
  for (const one of stale) answer(one);
  const inFlight = [];
  for (let k = 0; posted.length; k++) {
    inFlight.push(posted.length);
    if (k === 3) { // a viewer stops a worker: the page does its work
      const [{ worker }] = posted.splice(0, 1);
      worker.onerror();
      await later();
      await later();
    } else answer(posted.shift(), 40.0);
    await later();
  }
  const ended = [await first, await second];
  return { stale: stale.length, waiting, inFlight, taken, ended, isIdle: pool.busy.size === 0 };
}
"""


def test_a_change_cancels_what_is_under_way() -> None:
    told = in_modules(_POOL)
    assert told["ended"] == [False, True]
    assert (told["stale"], told["waiting"]) == (2, 0)  # one block a worker, and none beside it
    assert max(told["inFlight"]) <= 2
    assert told["isIdle"]
    assert {name for name, *_ in told["taken"]} == {"second"}
    rows = [row for _, begin, end in told["taken"] for row in range(begin, end)]
    assert sorted(rows) == [*range(30)]
    distance = [min(abs(begin - 7), abs(end - 1 - 7)) for _, begin, end in told["taken"]]
    assert distance[0] <= 1  # next to the operating point


_FAILURE = """
export async function run({ data, stateOf, jobOf, Pool }) {
  console.error = () => {};
  const broken = { postMessage: () => setTimeout(() => broken.onerror()) };
  const pool = new Pool(data, [broken]), { state } = stateOf(data, 0, {}), job = jobOf(state, 20, 30);
  const ended = [await pool.solve({ ...job, edges: null }, 7, () => {})];
  let rows = 0;
  ended.push(await pool.solve(job, 7, ({ begin, end }) => (rows += end - begin)));
  return { ended, rows };
}
"""


def test_a_map_that_fails_does_not_stop_the_next() -> None:
    assert in_modules(_FAILURE) == {"ended": [False, True], "rows": 30}


_SLOW = """
export async function run({ data, stateOf, Pool, solveMap, drawnMap }, texts) {
  let now = 0;
  performance.now = () => (now += 200); // [ms]: each block takes long
  const pool = new Pool(data, []), { state } = stateOf(data, 0, texts), shown = [];
  await solveMap(pool, state, (cells) => {
    const { ny, lowest, curves } = drawnMap(data, state, cells);
    const points = curves.flatMap(({ lines }) => lines.flat());
    shown.push({ regime: lowest, heights: points.map(([, y]) => y * (ny - 1)) });
    if (shown.length === 5) pool.cancel();
  });
  return shown;
}
"""


def test_a_slow_map_shows_its_rows_as_they_come() -> None:
    before = 0
    for one in in_modules(_SLOW, {"view": "speed", "target": "20"}):
        regime = np.array(one["regime"]).reshape(150, 200)
        solved = (regime >= 0).all(axis=1)
        assert before < solved.sum() < 150
        before = solved.sum()
        rows = np.flatnonzero(solved)
        assert np.array_equal(rows, np.arange(rows[0], rows[-1] + 1))
        assert (regime[solved, 0] == Regime.NO_SLIP).all()
        assert (regime[solved, -1] == Regime.HOPPING).all()
        assert all(rows[0] - 0.6 <= y <= rows[-1] + 0.6 for y in one["heights"])


# ------------------------------------------------------------------------------
# Files.


_FILES = """
export async function run({ data, stateOf, Pool, solveMap, csvOf, commandOf, tomlOf }, asked) {
  const answers = [];
  for (const { scene, texts, isTable } of asked) {
    const { state, problems } = stateOf(data, scene, texts);
    if (!state) throw new Error(JSON.stringify(problems));
    const answer = { command: commandOf(data, state), toml: tomlOf(data, state) };
    if (isTable) {
      const pool = new Pool(data, []), engine = engineOf(exports, data.known);
      let cells = null;
      await solveMap(pool, state, (found) => (cells = found));
      answer.csv = csvOf(data, engine, state, cells);
      answer.comma = csvOf(data, engine, state, cells, true);
    }
    answers.push(answer);
  }
  return answers;
}
"""


def filed(*asked: dict[str, Any], scenes: tuple[Request | None, ...] = (None,)) -> list[Any]:
    return list(in_modules(_FILES, [{"scene": 0, "texts": {}, **one} for one in asked], scenes))


def run_map(command: str) -> list[dict[str, str]]:
    """Run a command line of the page, for its table alone, and read that."""
    words = shlex.split(command)
    assert words[:2] == ["vibro", "map"]
    table = Path(words[-1]).with_suffix(".csv")
    run = CliRunner().invoke(app, [*words[1:-1], str(table)])
    assert run.exit_code == 0, run.output
    return rows_of(table.read_text(encoding="utf-8"))


def assert_same_table(ours: list[dict[str, str]], theirs: list[dict[str, str]]) -> None:
    """Compare tables: texts and statuses are equal, numbers to 1e-9, means to their errors."""
    assert [*ours[0]] == [*theirs[0]]
    assert len(ours) == len(theirs)
    means = np.array([row["status"] == "averaged" for row in theirs])
    for name in ours[0]:
        one, other = ([row[name] for row in rows] for rows in (ours, theirs))
        try:
            x, y = (np.array([float(text) if text else math.nan for text in texts]) for texts in (one, other))
        except ValueError:
            assert one == other, name
            continue
        near = np.isclose(x, y, 1e-9, 1e-10 * float(np.nanmax(np.abs(y), initial=0.0)), equal_nan=True)
        assert near[~means].all(), name
        assert np.array_equal(np.isnan(x), np.isnan(y)), name


def test_tables_and_commands_make_the_same_map(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """By options, and by a scene file with a machine."""
    monkeypatch.chdir(tmp_path)
    text = FEEDER.replace("filling_kg = 2", "filling_kg = 0").replace('"90:110"', "100")
    (file := tmp_path / "scene.toml").write_text(text, encoding="utf-8")
    given = {"x": "amplitude_mm", "y": "frequency_hz", "static_friction": "0.6", "gravity_m_s2": "9.8"}
    machine = {"x": "frequency_hz", "y": "setting_percent", "filling_kg": "0"}
    told, moved = filed(
        {"texts": given, "isTable": True},
        {"texts": machine, "scene": 1, "isTable": True},
        scenes=(None, request_of_call(file, {})),
    )
    ours = rows_of(told["csv"])
    assert_same_table(ours, run_map(told["command"]))
    comma = [line.split(";") for line in told["comma"].splitlines()]
    assert comma[0] == [*ours[0]]
    points = [[text.replace(",", ".") for text in row] for row in comma[1:]]
    assert points == [[*row.values()] for row in ours]
    file.write_text(moved["toml"], encoding="utf-8")
    assert_same_table(rows_of(moved["csv"]), run_map(moved["command"]))


def test_texts_give_every_quantity() -> None:
    nut, ellipse, odd = filed(
        {},
        {"texts": {"drive": "ellipse", "view": "impact", "target": "20", "trough_length_mm": ""}},
        {"texts": {"x": "restitution", "y": "friction_ratio", "x_range": "0:0.5", "y_range": "0.1:1:log"}},
    )
    assert nut["command"] == (
        "vibro map -A 0.1:3:150 -f 5:60:200 -a 20 --mu-s 0.74 --mu-d 0.57 -L 600 --x frequency --y amplitude"
        " -o out/map"
    )
    assert ellipse["command"] == (
        "vibro map along=0.1:3:150 normal=0.3 -f 15 phase=-180:180:200 --mu-s 0.74 --mu-d 0.57"
        " --x normal_phase --y along_amplitude --show impact --speed 20 -o out/map"
    )
    assert "--restitution 0:0.5:200" in odd["command"]
    assert "--mu-ratio 0.1:1:150:log" in odd["command"]
    assert "--mu-d" not in odd["command"]
    scene = tomllib.loads(nut["toml"])
    assert scene["scene"]["kinetic_friction"] == 0.57
    assert scene["map"] == {"amplitude_mm": "0.1:3:150", "frequency_hz": "5:60:200"}


def test_scene_files_of_given_drives_and_machines_are_read_by_vibro(
    requests: list[Request], tmp_path: Path
) -> None:
    machine = {"scene": len(requests) - 1, "texts": {"filling_kg": "1.5", "natural_hz": "47.6"}}
    asked = [{"scene": n} for n in range(len(requests))]
    *told, moved = filed(*asked, machine, scenes=tuple(requests))
    for answer, request in zip(told, requests, strict=True):
        assert answer["command"].startswith("vibro map scene.toml --x ")
        (file := tmp_path / "scene.toml").write_text(answer["toml"], encoding="utf-8")
        again = request_of_call(file, {})
        names = {*request.fixed} - {*again.varying}
        assert {n: again.fixed[n] for n in names} == pytest.approx({n: request.fixed[n] for n in names})
        assert (again.motion is None) == (request.motion is None)
        assert again.length == request.length
    tables = tomllib.loads(moved["toml"])
    assert tables["machine"]["filling_kg"] == 1.5
    assert (tables["machine"]["natural_hz"], tables["map"]["natural_hz"]) == (55.6, 47.6)
    said = "# with the springs that were shown: vibro solve scene.toml natural=47.6\n"
    assert moved["toml"].startswith(said)
    assert not told[-1]["toml"].startswith("#")


_HOSTILE = ("a b", "$(touch x)", "it's", '"; rm -rf /', "--out", "ä`id`", "\\n'\"$HOME")


def test_hostile_names_are_quoted(tmp_path: Path) -> None:
    requests = []
    for name in _HOSTILE:
        pack = "".join(f"\\u{ord(c):04x}" for c in name)
        (file := tmp_path / "feeder.toml").write_text(FEEDER.replace("6 leaves", pack), encoding="utf-8")
        request = request_of_call(file, {})
        object.__setattr__(request, "name", name)
        requests.append(request)
    for name, told in zip(
        _HOSTILE, filed(*({"scene": n} for n in range(len(_HOSTILE))), scenes=tuple(requests)), strict=True
    ):
        assert shlex.split(told["command"])[-1] == f"out/{name}"
        assert told["command"] == shlex.join(shlex.split(told["command"]))
        assert tomllib.loads(told["toml"])["machine"]["pack"][0]["name"] == name
