"""Every cell of the table in docs/guide/drives.md against what the program does."""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from helpers.commands import Run
from helpers.made_records import EXAMPLES

import vibro
from vibro.designs.guarantees import certain
from vibro.explore.scenes import scene_data
from vibro.records.problem import FITTABLE
from vibro.records.reading import TOL
from vibro.sweeps.whole import request_of_call

PAGE = (Path(__file__).parents[2] / "docs" / "guide" / "drives.md").read_text(encoding="utf-8")
POINT = "[scene]\nstatic_friction = 0.4\nkinetic_friction = 0.3\ntrough_length_mm = 600\nfrequency_hz = {}\n"
HARMONICS = "along_amplitudes_mm = [1, 0.3]\nalong_phases_deg = [0, -90]\n"
NORMAL = "normal_amplitudes_mm = [0.2, 0]\nnormal_phases_deg = [30, 0]\n"
WAVE = [round(6.0 * math.sin(p) + 2.0 * math.cos(2.0 * p), 6) for p in (i * math.tau / 32 for i in range(32))]

#: Scenes of each column; parts move forwards on all of them.
FILES = {
    "line": [POINT.format(15) + "amplitude_mm = 1\ndrive_angle_deg = 20\n"],
    "ellipse": [
        POINT.format(15) + "along_amplitude_mm = 1\nnormal_amplitude_mm = 0.3\nnormal_phase_deg = -60\n"
    ],
    "harmonics": [
        POINT.format(15) + HARMONICS + NORMAL,
        POINT.format(25) + HARMONICS + NORMAL.replace("0.2", "0.6") + "restitution = 0.3\n",
    ],
    "steps, samples": [
        POINT.format(15) + "[motion]\nalong_steps = [[0.8, 3.5], [0.2, -14]]\n",
        POINT.format(8) + f"[motion]\nalong_samples_m_s2 = {WAVE}\n",
    ],
    "clamped part": [POINT.format(25) + HARMONICS + "normal_acceleration_m_s2 = 20\ntrough_angle_deg = 5\n"],
}


def command(*arguments: str) -> Callable[[Run, Path], str]:
    """Return what a command answers to a scene file; its error where it refuses."""

    def ask(run: Run, file: Path) -> str:
        result = run(arguments[0], file, *(text.format(file.stem) for text in arguments[1:]))
        assert result.exception is None or isinstance(result.exception, SystemExit), result.exception
        if result.exit_code == 2:
            assert re.search("^error: ", result.stderr, re.MULTILINE)  # after notes on a record
            assert re.search("hint: |must be left out|did you mean", result.stderr)
            return result.stderr
        assert result.exit_code in (0, 3), result.stderr  # 3: no amplitude reaches the speed
        assert result.stdout or "wrote" in result.stderr
        return "yes"

    return ask


def function(*asks: Callable[[vibro.Scene], Any]) -> Callable[[Run, Path], str]:
    """Return what functions answer to a scene."""

    def ask(_: Run, file: Path) -> str:
        scene = vibro.read_scene(file)
        try:
            for asked in asks:
                assert asked(scene) is not None
        except vibro.InputError as exc:
            return str(exc)
        return "yes"

    return ask


def explored(_: Run, file: Path) -> str:
    """Return whether the page shows a scene."""
    try:
        scene_data(request_of_call(file, {}))
    except vibro.InputError as exc:
        return str(exc)
    return "yes"


RECORD = "record.csv"  # the beginning of that of examples/data
TROUGH = (
    *("--trough-along", "Trog l\u00e4ngs", "--trough-normal", "Trog normal"),
    *("--sensitivity", "100mV/g"),
)

MOVED = "along_harmonics_mm_deg = [[1, 0], [0.3, -90]]\nmotion_scale = 1\nfrequency_hz = 25\n"
#: Drives of questions for ``vibro design``, for each column.
DRIVES = {
    "line": "amplitude_mm = 2\ndrive_angle_deg = 20\nfrequency_hz = 15\n",
    "ellipse": "along_amplitude_mm = 2\nnormal_amplitude_mm = 0.6\nnormal_phase_deg = 9\nfrequency_hz = 15\n",
    "harmonics": MOVED,
    "steps, samples": "along_steps = [[0.8, 3.5], [0.2, -14]]\nmotion_scale = 1\nfrequency_hz = 5\n",
    "clamped part": MOVED + "normal_acceleration_m_s2 = 20\n",
}


def designed(run: Run, file: Path) -> str:
    """Return what ``vibro design`` answers to a question with the drive of a scene's column."""
    kind = next(kind for kind, texts in FILES.items() if file.read_text(encoding="utf-8") in texts)
    question = file.with_name("question.toml")
    scene = "[scene]\nstatic_friction = 0.4\nkinetic_friction = 0.3\n[goal]\nspeed_mm_s = 5\n[[drive]]\n"
    question.write_text(scene + DRIVES[kind], encoding="utf-8")
    return command("design")(run, question)


def timed(run: Run, file: Path) -> str:
    """Return what ``vibro solve --time`` answers about a scene without friction."""
    text = re.sub(".*_friction.*\n", "", file.read_text(encoding="utf-8"))
    left_out = file.with_name("frictionless.toml")
    left_out.write_text(text, encoding="utf-8")
    result = run("solve", left_out, "--time", "20", "--hopping")
    assert result.exit_code in (0, 4), result.stderr  # 4: no friction gives the time
    return "yes"


BANDS = {"static_friction": (0.38, 0.4)}
ASKED = {
    "`vibro solve`: regime, speed, phases": command("solve"),
    "`vibro map --starts`: the share of parts that moves so": command("map", "--starts", "8"),
    "`vibro solve --stand-ratio`: tipping": command("solve", "--stand-ratio", "0.3"),
    "`vibro solve --speed`: amplitudes that reach a speed, of motions their scale": command(
        "solve", "--speed", "5"
    ),
    "`vibro solve --time`: friction of parts that take a time": timed,
    "`vibro simulate`: history, and its picture": command("simulate", "--cycles", "3", "-o", "{}-history"),
    "`vibro simulate start_height=`: a part that is dropped, or thrown": command(
        "simulate", "start_height=2"
    ),
    "`vibro traverse-time`: mean and exact": command("traverse-time"),
    "`vibro map`: tables and pictures": command("map", "-f", "4:9:3", "-o", "{}-map"),
    "`vibro explore`": explored,
    "`vibro design`: the gentlest drive that reaches a speed": designed,
    "`vibro measure`: beside the record of a part": command("measure", RECORD, "-f", "15.003"),
    "`vibro measure --fit`: friction from that record": command(
        "measure", RECORD, "-f", "15.003", "--fit", "mu_s"
    ),
    "`vibro measure --trough-along`: on the trough's measured motion": command("measure", RECORD, *TROUGH),
    "`vibro accuracy`: other methods": command("accuracy", "--scenes", "2"),
    "`vibro.critical_loads`, `vibro.transitions`": function(vibro.critical_loads, vibro.transitions),
    "`vibro.friction_for_speed`, `vibro.critical_friction`": function(
        lambda scene: vibro.friction_for_speed(scene, 0.01).solutions, vibro.critical_friction
    ),
    "`vibro.attractors`: the motions of bodies from many starts": function(vibro.attractors),
    "`vibro.guarantee`, `vibro.yield_share`": function(
        lambda scene: vibro.guarantee(scene, **BANDS),
        lambda scene: vibro.yield_share(scene, 1e-3, highest_regime="hopping"),
    ),
    "`vibro.feasible_amplitudes`: of motions, their scale": function(
        lambda scene: vibro.feasible_amplitudes(scene, 0.01, limit=1.0)
    ),
    "`vibro.designs.guarantees`: bands of friction over a whole map": function(
        lambda scene: certain(scene, static_friction=(0.38, 0.4), second_friction=(0.7, 0.8), is_ratio=True)
    ),
}

#: What is asked of the first scene of each column alone: its pictures, searches or questions take the time.
OF_ONE_SCENE = ("`vibro simulate`", "`vibro map`", "`vibro design`", "`vibro measure")


def table() -> dict[str, dict[str, str]]:
    """Read the table of the page."""
    lines = [line for line in PAGE.splitlines() if line.startswith("|")]
    head, _, *rows = [[cell.strip() for cell in line.strip("|").split("|")] for line in lines]
    return {row[0]: dict(zip(head[1:], row[1:], strict=True)) for row in rows}


def test_the_table_has_what_is_asked_here() -> None:
    assert list(table()) == list(ASKED)
    assert all(list(row) == list(FILES) for row in table().values())


@pytest.mark.usefixtures("unsaved")
@pytest.mark.parametrize("kind", FILES)
@pytest.mark.parametrize("what", ASKED)
def test_every_cell_is_what_the_program_answers(
    run: Run, tmp_path: Path, what: str, kind: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Whether there is an answer: how good it is does not matter here, so searches and samples are small."""
    monkeypatch.setattr("vibro.records.problem._GRID", dict.fromkeys(FITTABLE, ()))
    few = TOL._replace(weighings=1, restarts=1, most_steps=2, neighbours=2, kept=1)
    monkeypatch.setattr("vibro.records.fitting.TOL", few)
    monkeypatch.setattr("vibro.designs.windows._FIRST", 8)
    monkeypatch.setattr("vibro.designs.windows._ERROR", 1.0)
    lines = (EXAMPLES / "data" / "nut_trough_mv.csv").read_text(encoding="utf-8").splitlines()
    (tmp_path / RECORD).write_text("\n".join(lines[:242]) + "\n", encoding="utf-8")
    for i, text in enumerate(FILES[kind][:1] if what.startswith(OF_ONE_SCENE) else FILES[kind]):
        file = tmp_path / f"scene{i}.toml"
        file.write_text(text, encoding="utf-8")
        assert table()[what][kind] in ASKED[what](run, file)
