"""Compiled and plain doors: the same bits, no exception on wild scenes, and which libraries are refused."""

from __future__ import annotations

import dataclasses
import shutil
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest
from extremes import KINDS, cells_of, corners_of, extreme_fields
from helpers import frozen_questions
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
    from collections.abc import Callable, Iterator

REGIMES = {"rests": (0.02, 0.98, 0.0), "hops": (1.2, 5.0, 0.0), "bounces": (1.2, 4.0, 0.3)}
DRAWN = pytest.mark.parametrize("kind", KINDS)


def drawn(kind: str, regime: str, count: int) -> dict[str, Any]:
    """Draw scenes of a kind of drive, with throw numbers and a restitution: their fields."""
    *throw, restitution = REGIMES[regime]
    draw = frozen_questions.Draws(f"twin {kind} {regime}")
    fields: dict[str, Any] = getattr(frozen_questions, kind)(draw, count, tuple(throw), restitution)
    return fields | {"kinetic_friction": np.minimum(fields["kinetic_friction"], fields["static_friction"])}


def one_of(fields: dict[str, Any], i: int) -> Scene:
    return Scene(**{name: x[..., i] if np.ndim(x) else x for name, x in fields.items()})


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


@pytest.mark.parametrize("name", [*CONTACT, *HOPPING])
def test_reference_tables_have_the_same_bits(name: str) -> None:
    scene = scene_of(columns_of(read_rows(name)))
    assert_same(lambda: [vibro.solve(scene, threads=1), vibro.solve(scene, output="regimes")])


@DRAWN
def test_drawn_scenes_have_the_same_bits(kind: str) -> None:
    one_harmonic = kind in ("line", "ellipse")
    counts, searched = ((600, 12, 6), 3) if one_harmonic else ((20, 4, 2), 1)

    def answers() -> Iterator[Any]:
        for regime, n in zip(REGIMES, counts, strict=True):
            scene = Scene(**drawn(kind, regime, n))
            cycle = vibro.solve(scene)
            yield cycle
            if one_harmonic:
                yield filling_of(scene, cycle, averages=True)
                yield from (load_slope(scene, cycle.pattern_code), slides_of(scene, cycle.pattern_code))
            if regime == "rests":
                few = Scene(**drawn(kind, regime, 100 if one_harmonic else 1))
                yield from (vibro.critical_loads(few), vibro.limits.tipping_load(few, 0.3))
            else:
                yield vibro.solve(Scene(**drawn(kind, regime, searched)), starts=16)

    assert_same(lambda: list(answers()))


@DRAWN
def test_arrivals_histories_and_transitions_have_the_same_bits(kind: str) -> None:
    count = 3 if kind in ("line", "ellipse") else 1

    def answers() -> Iterator[Any]:
        for regime in REGIMES:
            fields = drawn(kind, regime, count)
            yield vibro.arrival_time(Scene(**fields), 0.02)
            for i in range(count):
                history = vibro.simulate(one_of(fields, i), cycles=7.3, start_phase=0.4)
                yield [[ord(leg.kind[0]), leg.start, leg.end] for leg in history.phases]
        yield [t.ratio for t in vibro.transitions(one_of(fields, 0))]

    assert_same(lambda: list(answers()))


def test_threads_do_not_matter() -> None:
    scene = random_scenes(70_000, 8, most_trough_deg=20.0)
    with compiled():
        assert bits(vibro.solve(scene, threads=1)) == bits(vibro.solve(scene, threads=3))


# ---------------------------------------------------------------------------------------- wild scenes


def assert_answered(scene: Scene, cycle: vibro.SteadyCycle) -> None:
    """Check that each status has its numbers, and that shares are within their bound."""
    answered = np.isin(cycle.status, (Status.OK, Status.BOUNDARY, Status.AVERAGED))
    assert (np.isfinite(cycle.displacement_per_cycle) == answered).all()
    assert ((cycle.pattern_code != Pattern.NONE) == answered).all()
    assert not (cycle.status == Status.UNRESOLVED).any()
    found = filling_of(scene, cycle)
    cycles = np.isin(found.status, (Status.OK, Status.BOUNDARY))
    assert (np.isfinite(found.share) == cycles)[found.status != Status.AVERAGED].all()
    assert (np.abs(found.share[cycles]) <= found.bound[cycles] * (1.0 + 1e-9) + 1e-12).all()


def test_no_extreme_scene_raises_or_divides_by_zero() -> None:
    scene = Scene.allowing_infeasible(**extreme_fields(1000, seed=11))
    with plain():
        cycle = vibro.solve(scene, flight=False)
        assert_answered(scene, cycle)
        vibro.solve(scene, output="regimes")
        vibro.critical_loads(scene)
        others = [np.full(scene.shape, pattern) for pattern in Pattern]  # of another scene, too
        for codes in (cycle.pattern_code, *others):
            load_slope(scene, codes)
            slides_of(scene, codes)
    seen = {*cycle.pattern_code[cycle.status == Status.OK].tolist()}
    assert seen >= {Pattern.F_, Pattern.B_, Pattern.FB}
    assert_same(lambda: [vibro.solve(scene, flight=False), vibro.critical_loads(scene)])


def test_no_extreme_scene_that_hops_raises() -> None:
    every = Scene.allowing_infeasible(**extreme_fields(draws(400), seed=4))
    hops = vibro.solve(every, flight=False).throw_number > 1.0
    scene = Scene.allowing_infeasible(**{k: x[hops] for k, x in extreme_fields(draws(400), seed=4).items()})
    with plain():
        cycle = vibro.solve(scene)
        assert_answered(scene, cycle)
    assert (cycle.throw_number[cycle.status == Status.FLIGHT_NOT_MODELLED] > 0.99e6).all()
    assert (cycle.pattern_code[cycle.status == Status.OK] >= SPELT_PATTERNS).sum() > 10


@DRAWN
def test_no_corner_raises(kind: str) -> None:
    with plain():
        for row in corners_of(kind):
            for scene in cells_of(row, 30 if kind in ("line", "ellipse") else 3, 2):
                vibro.solve(scene, flight=False)


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
