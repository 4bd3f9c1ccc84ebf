"""Make nut_video_240fps.csv: a nut on a feeder, tracked in two seconds of a telephone's slow motion.

The camera stands on a tripod beside the trough: the track of the nut holds the trough's motion, and a mark on
the trough is tracked beside it. It is the nut of nut_trough_mv.csv, by the same closed form; vibro has no
part in it. The clock starts at a trough phase that the file does not tell.

    python examples/data/make_nut_video_240fps.py examples/data/nut_video_240fps.csv
"""

from __future__ import annotations

import math
import runpy
import sys
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

NUT: dict[str, Any] = runpy.run_path(str(Path(__file__).parent / "make_nut_trough_mv.py"))

FRAME_RATE = 240.0  # [1/s]
FRAMES = 481
TRIGGER_TIME = 0.0214  # [s] after the trough passed its middle upwards
PLACES = {"nut": 83.0, "mark": 21.0}  # [mm] in the picture, while the trough passes its middle
NOISE = 0.02e-3  # [m] of a tracked point, one sigma
SEED = 240

Floats = NDArray[np.float64]


def table() -> dict[str, Floats]:
    """Make the columns of the file."""
    time = np.arange(FRAMES) / FRAME_RATE
    phase = 2.0 * math.pi * NUT["FREQUENCY"] * (time + TRIGGER_TIME)
    random = np.random.default_rng(SEED)
    trough = NUT["AMPLITUDE"] * math.cos(NUT["DRIVE_ANGLE"]) * np.sin(phase)
    relative = NUT["displacement"](phase)
    return {
        "t [s]": time,
        "nut [mm]": PLACES["nut"]
        + 1e3 * (trough + relative - relative[0] + NOISE * random.standard_normal(FRAMES)),
        "mark [mm]": PLACES["mark"] + 1e3 * (trough + NOISE * random.standard_normal(FRAMES)),
    }


def main(path: Path) -> None:
    columns = table()
    rows = (f"{t:.5f},{nut:.3f},{mark:.3f}" for t, nut, mark in zip(*columns.values(), strict=True))
    path.write_text("\n".join([",".join(columns), *rows]) + "\n", encoding="utf-8", newline="\n")


if __name__ == "__main__":
    main(Path(sys.argv[1]))
