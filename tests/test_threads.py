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
from vibro.core.compiled import asking, doors, questions


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


LATE = """
import os, signal, sys, threading, time
import numpy as np
import vibro

signal.signal(signal.SIGINT, signal.default_int_handler)
random, friction = np.random.default_rng(1), {"static_friction": 0.4, "kinetic_friction": 0.3}
sizes = np.arange(1, 17)
waves = [[(1e-3 / i**2, turn * i) for i in sizes] for turn in (0.3, 0.7)]
ellipse = vibro.Scene(along_amplitude=np.linspace(1e-3, 5e-3, 60), normal_amplitude=3e-3, normal_phase=1.0,
                      frequency=30, restitution=0.5, **friction)
harmonics = vibro.Scene(motion=vibro.Motion.harmonics(*waves), frequency=30, restitution=0.5, **friction)
jolts = vibro.Motion.samples(*30.0 * random.normal(size=(2, 4096)))
samples = vibro.Scene(motion=jolts, frequency=20, **friction)
bouncing = vibro.Scene(amplitude=np.linspace(3e-3, 9e-3, 300)[:, None], frequency=np.linspace(15, 30, 300),
                       drive_angle=0.35, restitution=0.9, **friction)

def interrupt():
    global sent
    sent = time.process_time()
    os.kill(os.getpid(), signal.SIGINT)

for job in (lambda: vibro.solve(ellipse, starts=512), lambda: vibro.solve(harmonics, starts=4096),
            lambda: vibro.transitions(samples), lambda: vibro.solve(bouncing, threads=3)):
    threading.Timer(0.3, interrupt).start()
    try:
        job()
    except KeyboardInterrupt:
        heard = time.process_time()
        time.sleep(0.1)
        others = [thread for thread in threading.enumerate() if thread.daemon]
        print(len(others), heard - sent, time.process_time() - heard)
"""


@pytest.mark.skipif(sys.platform == "win32", reason="os.kill ends a process of Windows")
@pytest.mark.skipif(not doors().compiled, reason="plain Python hears interrupts by itself")
def test_an_interrupt_is_heard_at_once_and_nothing_runs_on() -> None:
    """In CPU time [s], as other processes share the machine; it was up to 1.8 s, and 27 s after the end."""
    done = subprocess.run([sys.executable, "-c", LATE], capture_output=True, text=True, timeout=120.0)
    assert done.returncode == 0, done.stderr
    found = [[float(x) for x in line.split()] for line in done.stdout.splitlines()]
    assert len(found) == 4
    for others, until_heard, after in found:
        assert (others, until_heard < 0.3, after < 0.05) == (0, True, True), done.stdout


@pytest.mark.skipif(not doors().compiled, reason="plain Python asks nothing")
def test_compiled_functions_end_with_what_a_question_raises_and_ask_within_each_other() -> None:
    scene = scene_with(amplitude=np.linspace(4e-3, 9e-3, 12), restitution=0.9)
    inner: list[Any] = []

    def ask() -> None:
        if not inner:  # a compiled function in the middle of another
            inner.append(solve(scene_with(amplitude=5e-3, restitution=0.5)))
        elif len(inner) > 2:
            raise ZeroDivisionError
        inner.append(None)

    for threads in (1, 3):
        inner.clear()
        with pytest.raises(ZeroDivisionError), asking(ask):
            solve(scene, threads=threads, starts=4096)  # each call takes seconds, and is asked all the while
        assert_same(inner[0], solve(scene_with(amplitude=5e-3, restitution=0.5)))
    assert questions() == ()
