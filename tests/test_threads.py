"""Threads that share the work of ``vibro.solve``: as many as asked for, with the same numbers."""

from __future__ import annotations

import subprocess
import sys
from threading import Barrier, get_ident
from typing import Any

import numpy as np
import pytest
from helpers.scenes import assert_same, scene_with

from vibro import Status, solve, steady
from vibro.core.compiled import doors
from vibro.threads import heard, in_parallel


def test_any_number_of_threads_gives_the_same_numbers(monkeypatch: pytest.MonkeyPatch) -> None:
    # at rest, sliding, hopping in cycles and in means; starts beside means take seconds
    few = scene_with(amplitude=np.linspace(0.3e-3, 6e-3, 13), restitution=[[0.0], [0.3]])
    many = scene_with(amplitude=np.linspace(0.3e-3, 9e-3, 31), restitution=[[0.0], [0.4]])
    searched, whole = solve(few, starts=16), solve(many)
    assert (solve(few).coexists != searched.coexists).sum() > 5
    assert len(np.unique(whole.regime)) == 4
    assert (whole.status == Status.AVERAGED).sum() > 3  # more than a part
    monkeypatch.setattr(steady, "_IN_CONTACT", 6)
    monkeypatch.setattr(steady, "_HOPPING", 3)
    monkeypatch.setattr(steady, "_SURVEYED", 4)
    one_and_three: list[Any] = [1, np.int64(3)]
    for threads in one_and_three:
        assert_same(solve(few, starts=16, threads=threads), searched)
        assert_same(solve(many, threads=threads), whole)


@pytest.mark.skipif(not doors().compiled, reason="the solver is not compiled: one thread")
@pytest.mark.parametrize(
    ("stage", "asked", "expected"),
    [("solve_contact", None, 2), ("solve_hops", 100, 5), ("share_starts", 3, 3), ("solve_hops", 1, 1)],
)
@pytest.mark.usefixtures("two_cores")
def test_so_many_threads_share_each_stage(
    stage: str, asked: int | None, expected: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Every thread waits for its first part until all have one; with one thread missing that never ends."""
    met, seen = Barrier(expected, timeout=20.0), set[int]()

    def wait(*_: object) -> None:
        if get_ident() not in seen:
            seen.add(get_ident())
            met.wait()

    for ranges in ("_IN_CONTACT", "_HOPPING", "_SURVEYED"):
        monkeypatch.setattr(steady, ranges, 4)
    scene = scene_with(amplitude=np.linspace(4e-3, 4.1e-3, 20))  # five parts
    monkeypatch.setattr(doors(), stage, wait, raising=False)
    solve(scene, starts=16, threads=asked)
    assert len(seen) == expected


LASTING = """
import os, signal, threading
import numpy as np
import vibro
from vibro.core.compiled import doors

whole, random, begun, ended = doors().class_scales, np.random.default_rng(1), threading.Event(), []

def class_scales(*values):
    begun.set()
    try:
        whole(*values)
    finally:
        ended.append(True)

def interrupt():
    begun.wait()
    os.kill(os.getpid(), signal.SIGINT)

doors().class_scales = class_scales
motion = vibro.Motion.samples(along=3.0 * random.normal(size=1024), normal=random.normal(size=1024))
signal.signal(signal.SIGINT, signal.default_int_handler)
threading.Thread(target=interrupt).start()
try:
    vibro.transitions(vibro.Scene(motion=motion, frequency=10, static_friction=0.4, kinetic_friction=0.3))
except KeyboardInterrupt:
    print("interrupted", ended, flush=True)
    os._exit(0)
"""


@pytest.mark.skipif(sys.platform == "win32", reason="processes are interrupted otherwise there")
@pytest.mark.skipif(not doors().compiled, reason="plain Python hears signals")
def test_an_interrupt_is_heard_while_a_compiled_function_runs() -> None:
    done = subprocess.run([sys.executable, "-c", LASTING], capture_output=True, text=True, timeout=120.0)
    assert (done.returncode, done.stdout) == (0, "interrupted []\n"), done.stderr


ENDING = """
import os, signal, threading
import numpy as np
import vibro
from vibro.core.compiled import doors

whole, begun, random = doors().solve_hops, threading.Event(), np.random.default_rng(1)

def solve_hops(*values):
    begun.set()
    whole(*values)

def interrupt():
    begun.wait()
    os.kill(os.getpid(), signal.SIGINT)

doors().solve_hops = solve_hops
motion = vibro.Motion.samples(*30.0 * random.normal(size=(2, 4096)))
scales, friction = np.geomspace(0.1, 1.0, 50), {"static_friction": 0.5, "kinetic_friction": 0.3}
signal.signal(signal.SIGINT, signal.default_int_handler)
threading.Thread(target=interrupt).start()
try:
    vibro.solve(vibro.Scene(motion=motion, motion_scale=scales, frequency=20.0, **friction))
except KeyboardInterrupt:
    print("interrupted")
"""


@pytest.mark.skipif(not doors().compiled, reason="plain Python hears interrupts by itself")
@pytest.mark.skipif(sys.platform == "win32", reason="os.kill ends a process of Windows")
def test_python_may_end_while_an_interrupted_call_runs_on() -> None:
    done = subprocess.run([sys.executable, "-c", ENDING], capture_output=True, text=True, timeout=120.0)
    assert (done.returncode, done.stdout) == (0, "interrupted\n"), done.stderr


def test_what_lasts_hands_over_its_answer_or_its_error() -> None:
    assert heard(lambda: 3) == 3
    with pytest.raises(ZeroDivisionError):
        heard(lambda: 1 // 0)
    threads: list[int] = []
    in_parallel(lambda _: threads.append(get_ident()), [1, 2], 1, lasting=True)
    assert get_ident() not in threads
    in_parallel(lambda _: heard(lambda: threads.append(get_ident())), [1], 1)
    assert len(threads) == 3
