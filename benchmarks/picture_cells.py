"""What the pictures of a map cost that show cells of its table where motion is irregular, or solve all anew.

Usage: python benchmarks/picture_cells.py [--only MAP ...]

CPU of all threads, in seconds: of the table; of the cells of pictures, without and with those of the table;
of drawing the maps of regimes and speeds. "from table" is the share of the cells of pictures that is taken.
"""

from __future__ import annotations

import argparse
import time
from typing import Any, Final

import numpy as np

from vibro.core.codes import Output
from vibro.plots import choose_view, map_figures
from vibro.sweeps.run import DrawnCells, sweep_blocks, sweep_picture
from vibro.sweeps.whole import request_of_call

NUT: Final = {"drive_angle_deg": 20, "static_friction": 0.74, "kinetic_friction": 0.57}
COARSE: Final = {"amplitude_mm": "0.1:3:35", "frequency_hz": "5:60:45"}  # 1575 cells
ELLIPSE: Final = {
    "along_amplitude_mm": "0.5:3:35", "normal_amplitude_mm": 1, "normal_phase_deg": 40,
    "frequency_hz": "15:60:45", "static_friction": 0.74, "kinetic_friction": 0.57,
}  # fmt: skip
MAPS: Final[dict[str, dict[str, Any]]] = {
    "contact": {"amplitude_mm": "0.1:1:100", "frequency_hz": "5:17:100", **NUT},
    "e = 0.3": {**COARSE, **NUT, "restitution": 0.3},
    "e = 0.7": {**COARSE, **NUT, "restitution": 0.7},
    "e = 0.7, ellipse": {**ELLIPSE, "restitution": 0.7},
    "e = 0.2, 0.5, 0.7": {**COARSE, **NUT, "restitution": "0.2,0.5,0.7"},
    "e = 0, coexist": {**COARSE, **NUT, "coexistence": True},
}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--only", nargs="+", choices=MAPS, default=list(MAPS), metavar="MAP")
    chosen = parser.parse_args().only
    heads = ("cells", "table", "anew", "taken", "from table", "drawing")
    print(f"{'map':20}" + "".join(f"{head:>11}" for head in heads))
    for name in chosen:
        given = MAPS[name]
        quantities = {key: value for key, value in given.items() if key != "coexistence"}
        grid = request_of_call(None, quantities).grid(
            Output.EXACT, flight=True, coexistence="coexistence" in given
        )
        view = choose_view(grid.axes, fixed=grid.fixed)
        ends = [time.process_time()]
        cells = DrawnCells.of(grid, view.drawn)
        for block in sweep_blocks(grid):
            if cells:
                cells.add(block)
        ends.append(time.process_time())
        sweep_picture(grid, view.drawn, None, "")
        ends.append(time.process_time())
        result = sweep_picture(grid, view.drawn, None, "", cells)
        ends.append(time.process_time())
        map_figures(result, ["regime", "speed"])
        ends.append(time.process_time())
        table, anew, taken, drawing = np.diff(ends)
        moved = [
            values != result.axes[axis].values.reshape([-1 if axis == other else 1 for other in result.axes])
            for axis, values in result.places.items()
        ]
        share = np.mean(np.logical_or.reduce(moved)) if moved else 0.0
        print(f"{name:20}{grid.size:11}{table:11.2f}{anew:11.2f}{taken:11.2f}{share:11.1%}{drawing:11.2f}")


if __name__ == "__main__":
    main()
