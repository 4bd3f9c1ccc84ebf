"""Workers do their tasks, run no file of the current folder, and nobody waits for them without end."""

from __future__ import annotations

import gc
import logging
import threading
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING

import pytest
from helpers.sharded import made, undisturbed

from vibro.errors import FileError
from vibro.output import workers as room
from vibro.output.workers import Cluster

if TYPE_CHECKING:
    pass

if find_spec("distributed") is None:
    pytest.skip("Dask is not installed", allow_module_level=True)

"""What pip makes of the command."""


def levels() -> dict[str, int]:
    """Return the levels of all loggers."""
    return {name: logging.getLogger(name).level for name in [*logging.root.manager.loggerDict]}


@pytest.mark.parametrize(
    ("kind", "told"),
    [
        ("nothing", "^no Dask scheduler answers at tcp://127.0.0.1:1: "),
        ("tls", "^tls://127.0.0.1:1 needs certificates, and Dask's configuration names none"),
    ],
)
def test_an_address_without_a_scheduler_is_told_and_nothing_remains(
    monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str], kind: str, told: str
) -> None:
    monkeypatch.setattr(room, "_CONNECTING", 0.1)
    address = {"nothing": "tcp://127.0.0.1:1", "tls": "tls://127.0.0.1:1"}[kind]
    before, levels_before = set(threading.enumerate()), levels()
    with pytest.raises(FileError, match=told) as caught:
        Cluster(address).__enter__()
    assert "--" not in f"{caught.value} {caught.value.hint}"  # options are the command line's matter
    left = set(threading.enumerate()) - before
    assert [thread.name for thread in left] == []
    assert levels() | levels_before == levels()
    del caught
    gc.collect()  # a client that is left behind writes a traceback now, or a warning
    assert capfd.readouterr() == ("", "")


def test_a_cluster_makes_the_same_shards(tmp_path: Path) -> None:
    how = {"n_workers": 1, "threads_per_worker": 1, "processes": False, "protocol": "tcp"}
    from distributed import LocalCluster

    with LocalCluster(**how, dashboard_address=None) as dask:
        assert made(tmp_path / "wide", Cluster(dask.scheduler_address)) == undisturbed()
