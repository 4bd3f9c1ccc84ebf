"""Only vibro's own processes keep the memory that they free: a user's keeps its settings of malloc."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest
from helpers.buffers import is_glibc, keeps_large_buffers

from vibro.output.workers import Processes

pytestmark = pytest.mark.skipif(not is_glibc(), reason="a setting of glibc's malloc")

SOLVE = """
import numpy as np
import vibro
amplitude = np.linspace(1e-4, 1.2e-3, 400)[:, None]
friction = np.linspace(0.5, 0.9, 400)
scene = vibro.Scene(amplitude=amplitude, frequency=15.0, drive_angle=0.35, static_friction=friction,
                    kinetic_friction=0.4)
vibro.solve(scene, threads=2)
"""
WRITE = """
import vibro
nut = {"drive_angle_deg": 20, "static_friction": 0.74, "kinetic_friction": 0.57}
vibro.write_sweep("wide", amplitude_mm="0.1:1.2:300", frequency_hz="15:20:300", shard_cells=40_000, **nut)
"""
ON_A_CLUSTER = """
import vibro
from distributed import LocalCluster
nut = {"drive_angle_deg": 20, "static_friction": 0.74, "kinetic_friction": 0.57}
with LocalCluster(n_workers=1, processes=False, protocol="tcp", dashboard_address=":0") as cluster:
    vibro.write_sweep("wide", amplitude_mm="0.1:1.2:30", frequency_hz="15:20:30", shard_cells=400,
                      scheduler=cluster.scheduler_address, **nut)
"""
COMMAND = """
import sys
from vibro.__main__ import main
sys.argv = ["vibro", "solve", "-A", "1", "-f", "15", "-a", "20", "--mu-s", ".74", "--mu-d", ".57"]
try:
    main()
except SystemExit:
    pass
"""
TELL = "\nfrom helpers.buffers import keeps_large_buffers\nprint(keeps_large_buffers())"


def kept_after(program: str, folder: Path) -> bool:
    """Whether a fresh process keeps large buffers once it has run a program."""
    done = subprocess.run(
        [sys.executable, "-c", program + TELL],
        cwd=folder,
        env=os.environ | {"PYTHONPATH": str(Path(__file__).parent)},
        capture_output=True,
        text=True,
        check=True,
    )
    return {"True": True, "False": False}[done.stdout.split()[-1]]


@pytest.mark.parametrize("program", [SOLVE, WRITE, ON_A_CLUSTER])
def test_a_users_process_keeps_its_settings(program: str, tmp_path: Path) -> None:
    if program is ON_A_CLUSTER:
        pytest.importorskip("distributed")
    assert not kept_after(program, tmp_path)


def test_the_command_keeps_what_it_frees(tmp_path: Path) -> None:
    assert kept_after(COMMAND, tmp_path)


def test_workers_that_a_sweep_starts_keep_what_they_free() -> None:
    with Processes(1) as workers:
        assert workers.submit(keeps_large_buffers).result()
