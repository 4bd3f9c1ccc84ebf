"""Compiled and plain doors: the same bits, no exception on wild scenes, and which libraries are refused."""

from __future__ import annotations

import ctypes
import dataclasses
import math
import shutil
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest
from extremes import extreme_fields
from helpers.draws import draws
from helpers.reference_tables import CONTACT, HOPPING, columns_of, read_rows, scene_of
from helpers.scenes import random_scenes
from helpers.solver_doors import compiled, plain

import vibro
from vibro import Scene, Status
from vibro.core import compiled as module
from vibro.core.codes import SPELT_PATTERNS, Pattern
from vibro.core.compiled import Doors, doors, library_path
from vibro.fillings import filling_of
from vibro.steady import load_slope, slides_of

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import NDArray

    Floats = NDArray[np.float64]

RIGHT = 0.5 * math.pi


# --------------------------------------------------------------------------------------------- scenes


TABLES = [*CONTACT, *HOPPING]


def hopping_lines(count: int, seed: int) -> Scene:
    """Draw lines that hop, on inclines too, with and without restitution."""
    random = np.random.default_rng(seed)
    mu_s, drive = random.uniform(0.1, 1.2, count), random.uniform(0.05, 1.2, count)
    throw = np.exp(random.uniform(math.log(1.0001), math.log(8.0), count))
    trough = random.choice([0.0, 1.0], count) * random.uniform(-0.3, 0.3, count)
    return Scene(
        amplitude=throw * 9.81 * np.cos(trough) / np.sin(drive) / (50.0 * math.pi) ** 2,
        frequency=25.0,
        drive_angle=drive,
        static_friction=mu_s,
        kinetic_friction=mu_s * random.uniform(0.0, 1.0, count),
        trough_angle=trough,
        restitution=random.choice([0.0, 1.0], count) * random.uniform(0.0, 0.9, count),
    )


def ellipses(count: int, seed: int, throw: tuple[float, float]) -> Scene:
    """Draw ellipses of some throw numbers."""
    random = np.random.default_rng(seed)
    mu_s, trough = random.uniform(0.1, 1.2, count), random.uniform(-0.2, 0.2, count)
    unit = 9.81 / (50.0 * math.pi) ** 2
    return Scene(
        along_amplitude=unit * mu_s * np.exp(random.uniform(-1.0, 3.0, count)),
        normal_amplitude=unit * np.cos(trough) * throw[0] * (throw[1] / throw[0]) ** random.random(count),
        normal_phase=random.uniform(-math.pi, math.pi, count),
        frequency=25.0,
        static_friction=mu_s,
        kinetic_friction=mu_s * random.uniform(0.0, 1.0, count),
        trough_angle=random.choice([0.0, 1.0], count) * trough,
        restitution=random.choice([0.0, 1.0], count) * random.uniform(0.0, 0.9, count),
    )


DRAWN = {
    "lines": lambda: random_scenes(600, 1, most_trough_deg=20.0, least_ratio=0.02),
    "extreme": lambda: Scene.allowing_infeasible(**extreme_fields(600, seed=3)),
    "hopping": lambda: hopping_lines(16, 4),
    "ellipses": lambda: ellipses(600, 5, (0.01, 0.9999)),
    "hopping ellipses": lambda: ellipses(16, 6, (1.0001, 6.0)),
}


# --------------------------------------------------------------------------------------- the same bits


def bits(found: Any) -> list[bytes]:
    """List the bytes of all arrays of a result; one NaN is as good as another."""
    if dataclasses.is_dataclass(found):
        return bits([getattr(found, f.name) for f in dataclasses.fields(found)])
    if isinstance(found, dict):  # texts by their codes
        return [repr(sorted(found.items())).encode()]
    if isinstance(found, (tuple, list)):
        return [b for x in found for b in bits(x)]
    array = np.asarray(found)
    return [(np.where(np.isnan(array), np.nan, array) if array.dtype.kind == "f" else array).tobytes()]


def assert_same(call: Callable[[], Any]) -> None:
    """Compare what both kinds of doors give."""
    with compiled() as fast:
        assert fast.compiled
        ours = bits(call())
    with plain() as slow:
        assert not slow.compiled
        assert ours == bits(call())


@pytest.mark.parametrize("name", TABLES)
def test_reference_tables_have_the_same_bits(name: str) -> None:
    scene = scene_of(columns_of(read_rows(name)))
    assert_same(lambda: [vibro.solve(scene, threads=1), vibro.solve(scene, output="regimes")])


@pytest.mark.parametrize("name", DRAWN)
def test_random_scenes_have_the_same_bits(name: str) -> None:
    scene = DRAWN[name]()

    def everything() -> list[Any]:
        cycle = vibro.solve(scene, flight="extreme" not in name)
        return [cycle, filling_of(scene, cycle)]

    assert_same(everything)


@pytest.mark.parametrize("name", ["lines", "ellipses"])
def test_limits_slopes_and_slides_have_the_same_bits(name: str) -> None:
    whole = DRAWN[name]()
    scene = Scene(**{key: x[:300] if np.ndim(x) else x for key, x in whole.arrays()._asdict().items()})
    patterns = vibro.solve(scene, flight=False).pattern_code

    def everything() -> list[Any]:
        limits = [vibro.critical_loads(scene), vibro.limits.tipping_load(scene, 0.3)]
        return [*limits, load_slope(scene, patterns), slides_of(scene, patterns)]

    assert_same(everything)


@pytest.mark.parametrize("name", ["hopping", "hopping ellipses"])
def test_searches_for_other_motions_have_the_same_bits(name: str) -> None:
    scene = DRAWN[name]()
    few = Scene(**{key: x[:4] if np.ndim(x) else x for key, x in scene.arrays()._asdict().items()})
    assert_same(lambda: vibro.solve(few, coexistence=True))


def test_arrivals_and_histories_have_the_same_bits() -> None:
    found = columns_of(read_rows("arrival"))
    scene = scene_of(found)
    assert_same(lambda: vibro.arrival_time(scene, found["length_mm"] / 1000.0))
    scenes = [DRAWN[name]() for name in ("lines", "hopping", "hopping ellipses")]

    def histories() -> list[Any]:
        legs = []
        for scene in scenes:
            for i in range(4):
                fields = {key: x[i] if np.ndim(x) else x for key, x in scene.arrays()._asdict().items()}
                history = vibro.simulate(Scene(**fields), cycles=7.3, start_phase=0.4)
                legs.append([(p.kind, p.start, p.end) for p in history.phases])
        return [[[row[1:] for row in leg] for leg in legs], [[ord(row[0]) for row in leg] for leg in legs]]

    assert_same(histories)


def test_threads_do_not_matter() -> None:
    scene = random_scenes(70_000, 8, most_trough_deg=20.0)
    with compiled():
        assert bits(vibro.solve(scene, threads=1)) == bits(vibro.solve(scene, threads=3))


# ---------------------------------------------------------------------------------------- wild scenes


def wild(count: int, seed: int, *, ellipse: bool) -> Scene:
    """Draw scenes over 24 decades of amplitude and frequency, with frictions and angles at their ends."""
    random = np.random.default_rng(seed)

    def pick(*values: Any) -> Floats:
        which = random.integers(0, len(values), count)
        return np.choose(which, [np.broadcast_to(np.asarray(v, float), count) for v in values])

    def decades(low: float, high: float) -> Floats:
        return np.asarray(10.0 ** random.uniform(low, high, count))

    usual = random.uniform(0.0, 1.5, count)
    mu_s = pick(0.0, 1e-300, decades(-12, 2), usual, usual, 1e6, 1e12)
    ratio = pick(0.0, 1.0, 1.0 - 2.0**-53, decades(-20, 0), random.uniform(0.0, 1.0, count))
    end = np.nextafter(RIGHT, 0.0)
    hold = np.arctan(mu_s) * (1.0 + random.integers(-6, 7, count) * 2.0**-52)
    slide = np.arctan(mu_s * ratio) * (1.0 + random.integers(-6, 7, count) * 2.0**-52)
    trough = pick(0.0, 0.0, random.uniform(-1.5, 1.5, count), hold, -slide, slide, end, -end, 1e-300)
    others: dict[str, Any] = {
        "frequency": pick(25.0, 25.0, decades(-12, 12)),
        "static_friction": mu_s,
        "kinetic_friction": np.minimum(mu_s * ratio, mu_s),
        "trough_angle": np.clip(trough, -end, end),
        "restitution": pick(0.0, 0.0, 0.5, 0.9999, random.uniform(0.0, 1.0, count)),
    }
    load = pick(1.0, random.uniform(0.1, 3.0, count), decades(-1, 6), decades(-12, 12), mu_s + 1e-300)
    # [m], of G = A w^2 / g
    amplitude = np.minimum(9.81 / (2.0 * math.pi * others["frequency"]) ** 2 * load, 1e6)
    if ellipse:
        return Scene(
            along_amplitude=amplitude
            * pick(0.0, 1.0, 1e-300, decades(-16, 0), random.uniform(0.0, 1.0, count)),
            normal_amplitude=amplitude
            * pick(0.0, 1.0, 1e-300, decades(-16, 0), random.uniform(0.0, 1.0, count)),
            normal_phase=pick(
                0.0, math.pi, -math.pi, RIGHT, -RIGHT, 1e6, random.uniform(-math.pi, math.pi, count)
            ),
            **others,
        )
    drive = pick(0.0, 1e-300, decades(-12, 0), random.uniform(0.0, RIGHT, count), end, RIGHT - np.abs(trough))
    return Scene(amplitude=np.maximum(amplitude, 1e-15), drive_angle=np.clip(drive, 0.0, end), **others)


def assert_weighed(found: vibro.Filling) -> None:
    """Check that shares are within their bound where there is a cycle, and nowhere else."""
    cycles = np.isin(found.status, (Status.OK, Status.BOUNDARY))
    assert (np.isfinite(found.share) == cycles)[found.status != Status.AVERAGED].all()
    means = found.status == Status.AVERAGED
    errors = found.added_mass_share_error + found.added_damping_share_error
    assert (np.abs(found.share) <= found.bound + 4.0 * errors)[means & np.isfinite(found.share)].all()
    assert (np.abs(found.share[cycles]) <= found.bound[cycles] * (1.0 + 1e-9) + 1e-12).all()


WILD = pytest.mark.parametrize("ellipse", [False, True], ids=["lines", "ellipses"])


def assert_answered(cycle: vibro.SteadyCycle) -> None:
    """Check that each status has its numbers."""
    answered = np.isin(cycle.status, (Status.OK, Status.BOUNDARY, Status.AVERAGED))
    assert (np.isfinite(cycle.displacement_per_cycle) == answered).all()
    assert ((cycle.pattern_code != Pattern.NONE) == answered).all()
    assert not (cycle.status == Status.UNRESOLVED).any()


@WILD
def test_no_wild_scene_raises_or_divides_by_zero_in_contact(ellipse: bool) -> None:
    scene = wild(2000, 1, ellipse=ellipse)
    with plain():
        cycle = vibro.solve(scene, flight=False)
        assert_answered(cycle)
        vibro.solve(scene, output="regimes")
        assert_weighed(filling_of(scene, cycle))
    seen = set(cycle.pattern_code[cycle.status == Status.OK].tolist())
    assert seen >= {Pattern.R, Pattern.F_, Pattern.B_, Pattern.FB}


@WILD
def test_no_wild_scene_raises_in_limits_slopes_and_slides(ellipse: bool) -> None:
    scene = wild(500, 3, ellipse=ellipse)
    with plain():
        patterns = vibro.solve(scene, flight=False).pattern_code
        vibro.critical_loads(scene)
        vibro.limits.tipping_load(scene, 0.2)
        load_slope(scene, patterns)
        slides_of(scene, patterns)
        for pattern in list(Pattern):  # of another scene, too
            codes = np.full(scene.shape, pattern)
            load_slope(scene, codes)
            slides_of(scene, codes)


@WILD
def test_no_wild_scene_raises_in_flight(ellipse: bool) -> None:
    scene = wild(draws(60), 4, ellipse=ellipse)
    with plain():
        cycle = vibro.solve(scene)
        assert_weighed(filling_of(scene, cycle, averages=True))
    hops = cycle.throw_number > 1.0 + 1e-12
    assert hops.sum() > 20
    modelled = hops & (cycle.status != Status.FLIGHT_NOT_MODELLED)
    assert (cycle.throw_number[hops & ~modelled] > 0.99e6).all()
    assert modelled.sum() > 10
    assert (cycle.pattern_code[modelled & (cycle.status == Status.OK)] >= SPELT_PATTERNS).any()


def test_extreme_scenes_raise_nothing() -> None:
    scene = Scene.allowing_infeasible(**extreme_fields(3000, seed=11))
    with plain():
        assert_answered(vibro.solve(scene, flight=False))
        vibro.critical_loads(scene)


@WILD
def test_wild_scenes_have_the_same_bits(ellipse: bool) -> None:
    scene = wild(1000, 5, ellipse=ellipse)
    assert_same(lambda: [vibro.solve(scene, flight=False), vibro.critical_loads(scene)])


# ------------------------------------------------------------------------------------------ libraries


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Copy the core with its library, and load the solver from there."""
    with compiled():
        pass
    source = Path(module.__file__).parent
    for path in [*source.glob("*.py"), *source.glob("_solver.*")]:
        shutil.copyfile(path, tmp_path / path.name)
    monkeypatch.setattr(module, "_FOLDER", tmp_path)
    monkeypatch.delenv("VIBRO_SOLVER", raising=False)
    return tmp_path


def load() -> Doors:
    return doors.__wrapped__()


def test_a_library_of_its_source_is_loaded(folder: Path) -> None:
    path = library_path()
    assert path is not None
    assert path.parent == folder
    assert path.stem == "_solver"
    assert load().compiled


@pytest.mark.parametrize("name", ["slides.py", "loop.py", "codes.py"])
def test_a_library_of_another_source_is_refused(folder: Path, name: str) -> None:
    source = folder / name
    source.write_bytes(source.read_bytes() + b"\n")
    with pytest.raises(
        ImportError, match=r"was built from another version of the source; install .* VIBRO_SOLVER=python"
    ):
        load()
    source.unlink()
    with pytest.raises(ImportError, match="was built from another version of the source"):
        load()


def test_a_file_that_is_no_library_is_refused(folder: Path) -> None:
    path = library_path()
    assert path is not None
    path.unlink()  # the one that is loaded stays as it is
    path.write_bytes(b"no library")
    with pytest.raises(ImportError, match=r"cannot be loaded: .*; install the package again"):
        load()


def test_a_library_of_something_else_is_refused(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(ctypes, "CDLL", lambda path: object())
    with pytest.raises(ImportError, match="cannot be loaded"):
        load()


def test_plain_python_runs_where_it_is_wanted_or_nothing_is_compiled(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("VIBRO_SOLVER", "python")
    assert library_path() is None
    assert not load().compiled
    monkeypatch.setenv("VIBRO_SOLVER", "compiled")
    assert load().compiled
    path = library_path()
    assert path is not None
    path.unlink()
    assert library_path() is None
    assert not load().compiled


def test_rows_are_buffers() -> None:
    array = np.arange(12.0).reshape(3, 4)
    with plain() as slow:
        assert [list(row) for row in slow.rows(array)] == array.tolist()
        view = slow.row(array)
        view[5] = -1.0
        assert array[1, 1] == -1.0
        assert slow.rows(np.zeros((2, 0)))[1].nbytes == 0
    with compiled() as fast:
        start = array.ctypes.data
        assert fast.rows(array) == (start, start + 32, start + 64)
        assert fast.row(array) == start
        assert len(fast.rows(np.zeros((3, 0)))) == 3


def test_unknown_doors_are_no_attributes() -> None:
    for way in (plain, compiled):
        with way() as found, pytest.raises(AttributeError, match="no_such_door"):
            found.no_such_door()
