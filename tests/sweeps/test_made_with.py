"""Tables tell what they were made with: restitution where bodies may fly, and the trough's length."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from helpers.cases import each
from helpers.plans import NUT

import vibro

LINE: dict[str, Any] = {"amplitude_mm": [1, 4], "frequency_hz": 15, **NUT}
FRICTION: dict[str, Any] = {"static_friction": 0.4, "kinetic_friction": 0.3}
CLAMPED: dict[str, Any] = {
    "along_amplitude_mm": [1, 9], "normal_amplitude_mm": 0, "normal_acceleration_m_s2": 20,
    "frequency_hz": 15, **FRICTION,
}  # fmt: skip
LENGTH: dict[str, Any] = {"trough_length_mm": 600.1}
BOUNCING: dict[str, Any] = {"restitution": 0.5}


@each(
    ("given", "told"),
    [
        (LINE | BOUNCING | LENGTH, BOUNCING | LENGTH),
        (LINE | BOUNCING | LENGTH | {"flight": False}, LENGTH),
        (LINE | LENGTH | {"output": "regimes"}, LENGTH),
        (LINE | {"restitution": [0, 0.5]}, {}),
        (LINE | LENGTH | {"restitution": [0, 0.5], "flight": False}, LENGTH),
        (CLAMPED | BOUNCING, {}),
        (CLAMPED | LENGTH | {"normal_acceleration_m_s2": [20, 30]}, LENGTH),
        (LINE | LENGTH | {"amplitude_mm": 4}, {"restitution": 0.0} | LENGTH),
    ],
)
def test_what_results_depend_on_stands_before_those_of_flights(
    given: dict[str, Any], told: dict[str, float], tmp_path: Path
) -> None:
    frame = vibro.sweep(**given).to_frame()
    names = list(frame)
    between = names[names.index("back_ratio") + 1 : names.index("flight_fraction")]
    assert between == list(told)
    for name, value in told.items():
        assert frame[name].tolist() == [value] * len(frame)
    if isinstance(given.get("restitution"), list):
        assert names[names.index("trough_angle_deg") + 1] == "restitution"
    else:
        assert names.count("restitution") == ("restitution" in told)
    stored = vibro.write_sweep(tmp_path / "folder", force=True, **given)
    pd.testing.assert_frame_equal(stored.to_frame(), frame)
    asked = ["trough_length_mm", "restitution"]
    on_request = vibro.sweep(**given).to_frame(asked)
    assert list(on_request) == asked
    np.testing.assert_array_equal(on_request["trough_length_mm"], given.get("trough_length_mm", np.nan))
    np.testing.assert_array_equal(np.unique(on_request["restitution"]), given.get("restitution", 0.0))
