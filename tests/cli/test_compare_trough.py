"""``vibro compare`` with accelerometers on the trough, voltages, lost samples, and without a scene file."""

from __future__ import annotations

import contextlib
import json
import re
import runpy
import shlex
import shutil
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from engines.harmonic_flight import Body, Settled
from helpers.commands import NUT, Run
from helpers.made_records import EXAMPLES, STUDY_FILE, trough_record
from helpers.measured_drives import Drawn, write_record
from matplotlib.figure import Figure

from vibro.plots.comparison import comparison_figure
from vibro.records.signals import read_sensitivities

SCENE = EXAMPLES / "safety_nut.toml"
MADE: dict[str, Any] = runpy.run_path(str(EXAMPLES / "data" / "make_nut_trough_mv.py"))
FILE = EXAMPLES / "data" / "nut_trough_mv.csv"
ALONG, NORMAL = ("--trough-along", "Trog längs [mV]"), ("--trough-normal", "Trog normal [mV]")
BOTH = (*ALONG, *NORMAL, "--sensitivity", "100mV/g")
FRICTION = ("--mu-s", "0.74", "--mu-d", "0.57")
TRUE = {"amplitude_mm": 1.02, "frequency_hz": 15.003, "drive_angle_deg": 20.5}
GUIDE = (EXAMPLES.parent / "docs" / "guide" / "compare.md").read_text(encoding="utf-8")


def test_the_committed_record_is_what_its_script_makes() -> None:
    header, *lines = FILE.read_text(encoding="utf-8").splitlines()
    made = MADE["table"]()
    assert header == ";".join(made)
    rows = [[float(cell.replace(",", ".") or "nan") for cell in line.split(";")] for line in lines]
    for values, column in zip(made.values(), np.array(rows).T, strict=True):
        np.testing.assert_allclose(column, values, atol=2e-2)
    assert FILE.stat().st_size < 60_000


def test_the_measured_drive_replaces_what_the_scene_gives(run: Run) -> None:
    result = run("compare", SCENE, FILE, *BOTH, "-o", "out")
    assert result.exit_code == 0, result.stderr
    content = json.loads(Path("out.json").read_text(encoding="utf-8"))
    for column, true in TRUE.items():
        found = content["trough"][column]
        assert abs(found["measured"] - true) < 3.0 * found["standard_error"] < 0.02 * true
        assert content["scene"][column] == pytest.approx(
            found["measured"], abs=0.01 * found["standard_error"]
        )
    assert abs(content["trough_time_at_zero_s"] - MADE["TRIGGER_TIME"]) < 3.0 * content["trough_time_error_s"]
    assert content["trough_time_error_s"] < 5e-5
    assert content["trough"]["along"]["column"] == "Trog längs [mV]"
    assert content["trough"]["normal"]["rest"] < 0.1
    assert content["columns"]["displacement"] == "Weg in mm"
    assert content["warnings"] == content["trough"]["warnings"] == []


def test_the_scene_needs_no_amplitude_and_no_frequency_then(run: Run) -> None:
    result = run("compare", FILE, *FRICTION, *BOTH, "--json")
    assert result.exit_code == 0, result.stderr
    assert json.loads(result.stdout)["scene"]["drive_angle_deg"] == pytest.approx(20.5, abs=0.3)
    one = (*ALONG, "--sensitivity", "100mV/g")
    result = run("compare", FILE, *FRICTION, "-a", "20.5", *one, "--json")
    assert result.exit_code == 0, result.stderr
    trough = json.loads(result.stdout)["trough"]
    assert abs(trough["amplitude_mm"]["measured"] - 1.02) < 3.0 * trough["amplitude_mm"]["standard_error"]
    assert "drive_angle_deg" not in trough
    assert trough["phase_normal_to_along_deg"] is None


def test_without_a_scene_file_the_title_gives_the_values(run: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    headings = []

    def drawn(*args: Any) -> Any:
        figure = comparison_figure(*args)
        headings.append((figure.get_label(), figure.get_suptitle()))
        return Figure()

    monkeypatch.setattr("vibro.plots.comparison.comparison_figure", drawn)
    for scene in ((), (SCENE,)):
        result = run(
            "compare", *scene, STUDY_FILE, *NUT, "--velocity", "V [mm/s]", "-o", "out", "--force", "-q"
        )
        assert result.exit_code == 0, result.stderr
    (bare, below), (named, _) = headings
    assert bare == "nut_smoothed_600hz.csv, computed pattern F_"
    assert named == "nut_smoothed_600hz.csv – safety_nut, computed pattern F_"
    assert re.sub(r"[${}\\]", "", below).splitlines()[1].startswith("A = 1 mm, f = 15 Hz, alpha = 20°")


@pytest.mark.parametrize(
    "line", re.findall(r"^vibro .*$", "".join(re.findall(r"```bash\n(.*?)```", GUIDE, re.DOTALL)), re.M)
)
def test_the_commands_of_the_guide_run(run: Run, line: str) -> None:
    shutil.copytree(EXAMPLES, "examples")
    result = run(*shlex.split(line, comments=True)[1:])
    assert result.exit_code == 0, result.stderr
    assert "warning" not in result.stderr


def test_the_sensitivities_of_the_guide_are_understood() -> None:
    table = "".join(
        line for line in GUIDE.splitlines(keepends=True) if "--sensitivity" in line or "also" in line
    )
    texts = re.findall(r"--sensitivity ([^\s`]+)|also `([^`]+)`", table)
    assert len(texts) > 9
    for text in texts:
        assert read_sensitivities(["".join(text)])


def test_the_guide_shows_what_is_printed(run: Run) -> None:
    shutil.copytree(EXAMPLES, "examples")
    line, shown = re.findall(r"```console\n\$ (vibro .*?)\n(.*?)```", GUIDE, re.DOTALL)[0]
    assert len(shown.splitlines()) > 6
    assert run(*shlex.split(line)[1:], "-q").stdout.startswith(shown)


def test_reverse_leaves_a_sensor_normal_to_the_trough_as_it_is(run: Run) -> None:
    """It turns the axis along the trough; upwards stays upwards."""
    found = []
    for turned in ((), ("--reverse",)):
        result = run("compare", SCENE, FILE, *NORMAL, "--sensitivity", "100mV/g", *turned, "--json", "-q")
        assert result.exit_code == 0, result.stderr
        found.append(json.loads(result.stdout))
    plain, turned_round = found
    for key in ("trough", "trough_time_at_zero_s", "scene"):
        assert plain[key] == turned_round[key]
    advances = [content["figures"]["stroke_advance"]["measured"] for content in found]
    assert advances[0] == pytest.approx(-advances[1])


# --- a fit on a measured drive -------------------------------------------------------------------------


def test_a_bar_says_what_a_fit_searches(run: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    told: list[tuple[Any, ...]] = []

    @contextlib.contextmanager
    def progress(self: Any, label: str, total: int | None) -> Iterator[Callable[..., None]]:
        yield lambda *done: told.append((label, *done))

    monkeypatch.setattr("vibro.cli.console.Console.progress", progress)
    assert run("compare", SCENE, FILE, *BOTH, "--fit", "mu_d").exit_code == 0
    labels, done, whats, totals = zip(*told, strict=True)
    assert set(labels) == {"fitting"}
    assert whats[0] == "patterns"
    assert {"estimates", "intervals"} < set(whats)
    assert list(done) == list(range(len(told)))
    assert all(now < of for now, of in zip(done, totals, strict=True))
    assert totals[-1] == len(told)


def feeder_file(harmonic: float, *, cycles: float = 12.0, ellipse: float = 0.0) -> Path:
    """Write accelerations of a trough, and the displacement of a body that rests: the drive alone counts."""
    made = trough_record(cycles=cycles, noise=0.05, harmonic=harmonic, ellipse=ellipse)
    still = np.random.default_rng(1).standard_normal(made.time.size)
    columns = {"t [s]": made.time, "x [mm]": 1e-3 * still} | {
        f"{name} [m/s^2]": values for name, values in made.trough.items()
    }
    rows = np.stack(list(columns.values()), axis=1)
    np.savetxt("feeder.csv", rows, "%.9g", ",", header=",".join(columns), comments="")
    return Path("feeder.csv")


SENSORS = ("--trough-along", "trough_along", "--trough-normal", "trough_normal")


def test_a_fit_takes_harmonics_whatever_the_first_scene_makes_of_them(run: Run) -> None:
    """Frictions with which the body would rest make no difference of speed: they are only a start."""
    rests = ("--mu-s", "2", "--mu-d", "1.5")
    for harmonic, order in ((0.05, 3), (0.0, 1)):
        data = feeder_file(harmonic)
        plain = run("compare", data, *rests, *SENSORS, "--json")
        fitted = run("compare", data, *rests, *SENSORS, "--fit", "mu_d", "--json")
        assert plain.exit_code == fitted.exit_code == 0
        assert "harmonics" not in plain.stderr
        assert ("moves with 3 harmonics: they are part of the fit" in fitted.stderr) == (order == 3)
        assert ("along_amplitude_3_mm" in json.loads(fitted.stdout)["trough"]) == (order == 3)


def test_a_fit_without_the_harmonics_is_refused(run: Run) -> None:
    """Where a record does not tell them, an estimate would take their effect for its own."""
    short = feeder_file(0.0, cycles=5.0)
    assert run("compare", short, *FRICTION, *SENSORS).exit_code == 0
    result = run("compare", short, *FRICTION, *SENSORS, "--fit", "mu_d")
    assert (result.exit_code, result.stdout) == (2, "")

    one = ("--trough-along", "trough_along", "normal=0.3mm", "phase=-60deg", *FRICTION)
    data = feeder_file(0.2, ellipse=-1.0)
    assert run("compare", data, *one).exit_code == 0
    assert run("compare", data, *one, "--fit", "mu_d").exit_code == 2


def test_intervals_hold_friction_on_troughs_with_harmonics(run: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    """The search begins with a body that would rest, where harmonics make no difference of speed."""
    few = {"static_friction": (0.3,), "kinetic_friction": (-0.7,)}
    monkeypatch.setattr("vibro.records.problem._GRID", few)
    true = {"static_friction": 0.35, "kinetic_friction": 0.25}
    waves = 1.5 * np.array([1.0, 0.4 * np.exp(0.7j)])
    along, normal = (part * waves for part in (np.cos(0.35), np.sin(0.35)))
    settled = Settled(Body(along, normal, *true.values()), cycles=11)
    drawn = Drawn(25.0, 0.35, 0.0, along, normal, settled, true, "slides", "displacement", "white", 8, False)
    arguments = write_record(Path("record.csv"), np.random.default_rng(1), drawn)
    for option, start in (("--mu-s", "2"), ("--mu-d", "1.5")):
        arguments[arguments.index(option) + 1] = start
    result = run("compare", *arguments, "--json")
    assert result.exit_code == 0, result.stderr
    ((low, high),) = json.loads(result.stdout)["fit"]["kinetic_friction"]["intervals"]
    assert high - low < 0.1
    assert low < 0.25 < high
