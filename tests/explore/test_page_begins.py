"""What the page's script makes of the scenes that vibro gives it: the operating point is that of the file."""

from __future__ import annotations

import json
import subprocess
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from helpers.explored_scenes import FEEDER, GIVEN_DRIVES
from helpers.node_doors import node

import vibro
from vibro.explore import page as pages
from vibro.explore.page import page_data, solver_script
from vibro.explore.scenes import scene_data
from vibro.sweeps.whole import read_scene, request_of_call

EXAMPLES = Path(__file__).parents[2] / "examples"
FILES = {
    **{path.stem: path.read_text(encoding="utf-8") for path in sorted(EXAMPLES.glob("*.toml"))},
    **GIVEN_DRIVES,
    "feeder": FEEDER,
}
SCENES = [name for name in FILES if not name.startswith("design")]
RUN = """
import { readFileSync } from "node:fs";
import vm from "node:vm";
import { stateOf } from "./state.js";
const { data, solver } = JSON.parse(readFileSync(0, "utf8"));
const page = vm.createContext({ console, data });
vm.runInContext(solver + "\\nconst engine = engineOf(exports, data.known);", page);
const answers = data.scenes.map((_, scene) => {
  const { state, problems } = stateOf(data, scene, {});
  if (!state) return problems;
  page.state = state;
  const solved = vm.runInContext(`
    if (state.machine) {
      const given = { ...state, machine: { ...state.machine.fields, share: state.machine.share } };
      state.values.amplitude = 1000 * operatingOf(data, engine, given).amplitude[0];
    }
    const cycle = engine.solve(engine.gridOf(driveOf(data, state)));
    ({ speed: cycle.mean_velocity[0], regime: cycle.regime[0] })`.replace(/const /g, "var "), page);
  return [solved.speed, solved.regime, state.x.name, state.y.name];
});
console.log(JSON.stringify(answers));
"""


def test_operating_points_are_those_of_the_files(tmp_path: Path) -> None:
    """Each with its own drive, machine and axes; of axes in [map] the middle."""
    requests, expected = [], []
    for name in SCENES:
        (file := tmp_path / f"{name}.toml").write_text(FILES[name], encoding="utf-8")
        for data in (EXAMPLES / "data").glob("*.csv"):
            (tmp_path / "data").mkdir(exist_ok=True)
            (tmp_path / "data" / data.name).write_bytes(data.read_bytes())
        request = request_of_call(file, {})
        requests.append(request)
        expected.append(vibro.solve(read_scene(file)) if {*request.varying} <= {*request.own} else None)
    static = Path(pages.__file__).with_name("static")
    for module in ("state.js", "typed.js"):
        (tmp_path / module).write_text((static / module).read_text(encoding="utf-8"), encoding="utf-8")
    (tmp_path / "package.json").write_text('{"type": "module"}', encoding="utf-8")
    (tmp_path / "run.js").write_text(RUN, encoding="utf-8")
    data = json.loads(pages._json(page_data([scene_data(request) for request in requests])))
    asked = pages._json({"data": data, "solver": solver_script()})
    run = subprocess.run(
        [node(), str(tmp_path / "run.js")], input=asked, capture_output=True, text=True, check=False
    )
    assert run.returncode == 0, run.stderr
    answers: list[list[Any]] = json.loads(run.stdout)
    for name, request, cycle, answer in zip(SCENES, requests, expected, answers, strict=True):
        assert isinstance(answer[0], float | int | None), (name, answer)
        assert {*request.varying[:2]} <= {*answer[2:]}, name
        if cycle is not None:
            assert answer[1] == int(cycle.regime), name
            speed = np.nan if answer[0] is None else answer[0]
            mean, error = float(cycle.mean_velocity), float(cycle.mean_velocity_error)
            tolerance = 8.0 * error + 1e-9 * abs(mean) + 1e-12
            assert speed == pytest.approx(mean, abs=tolerance, nan_ok=True), name
