"""Run commands in this process, as a user's shell would."""

from __future__ import annotations

import signal
from pathlib import Path
from typing import TYPE_CHECKING

import pytest
from typer.testing import CliRunner, Result

from vibro.cli.app import app

if TYPE_CHECKING:
    from collections.abc import Iterator

    from helpers.commands import Run

# A shell starts what it runs in the background with interrupts ignored, nohup with hang-ups, and programs
# inherit that.
signal.signal(signal.SIGINT, signal.default_int_handler)
if hasattr(signal, "SIGHUP"):
    signal.signal(signal.SIGHUP, signal.SIG_DFL)


@pytest.fixture(scope="module", autouse=True)
def _coarse_pictures() -> Iterator[None]:
    """Tests of commands look at what is drawn, tests of plots at how well."""
    from helpers.drawn import coarse_pictures

    with coarse_pictures(), pytest.MonkeyPatch.context() as patch:
        patch.setattr("vibro.sweeps.run._RESOLVED", {1: 101, 2: 21, 3: 11})
        yield


@pytest.fixture
def run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Run:
    """Run ``vibro`` with arguments, in a folder of its own."""
    monkeypatch.chdir(tmp_path)

    def invoke(*args: object) -> Result:
        return CliRunner().invoke(app, [str(arg) for arg in args])

    return invoke


@pytest.fixture
def unsaved(monkeypatch: pytest.MonkeyPatch) -> None:
    """Leave figures as they are built, where nobody looks at files: to save them takes half of their time."""
    from vibro.answers.page import Picture

    def save(_: object, path: str | Path, **__: object) -> None:
        Path(path).touch()

    monkeypatch.setattr("vibro.plots.frame.Picture.savefig", save)
    monkeypatch.setattr("vibro.answers.page.picture", lambda _, name, shows: Picture("<svg/>", 1, shows))


@pytest.fixture
def no_pictures(monkeypatch: pytest.MonkeyPatch) -> None:
    """Draw nothing, where pictures are not the subject: they take most of a small run's time."""
    monkeypatch.setattr("vibro.sweeps.solved.pictures_of", lambda *_, **__: [])
