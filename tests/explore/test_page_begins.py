"""What the page's script makes of the scenes that vibro gives it: the operating point is that of the file."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from helpers.explored_scenes import FEEDER, GIVEN_DRIVES
from helpers.whole_page import in_modules

import vibro
from vibro.sweeps.whole import read_scene, request_of_call

EXAMPLES = Path(__file__).parents[2] / "examples"
FILES = {
    **{path.stem: path.read_text(encoding="utf-8") for path in sorted(EXAMPLES.glob("*.toml"))},
    **GIVEN_DRIVES,
    "feeder": FEEDER,
}
SCENES = [name for name in FILES if not name.startswith("design")]
RUN = """
export const run = ({ data, engine, stateOf, pointOf }) => data.scenes.map((_, scene) => {
  const { state, problems } = stateOf(data, scene, {});
  if (!state) return problems;
  const cycle = engine.solve(engine.gridOf(pointOf(data, engine, state).drive));
  return [cycle.mean_velocity[0], cycle.regime[0], state.x.name, state.y.name];
});
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
    answers: list[list[Any]] = in_modules(RUN, scenes=requests)
    for name, request, cycle, answer in zip(SCENES, requests, expected, answers, strict=True):
        assert not isinstance(answer[0], dict), (name, answer)
        assert {*request.varying[:2]} <= {*answer[2:]}, name
        if cycle is not None:
            assert answer[1] == int(cycle.regime), name
            mean, error = float(cycle.mean_velocity), float(cycle.mean_velocity_error)
            tolerance = 8.0 * error + 1e-9 * abs(mean) + 1e-12
            assert answer[0] == pytest.approx(mean, abs=tolerance, nan_ok=True), name
