"""Do sweeps keep the kernel's pace? A sweep's blocks beside ``vibro.solve`` of the same cells.

Usage: python benchmarks/sweep.py [--side 2000] [--repeats 5]

The cells stay in contact. Both ways are timed in turn, in one process, after a warm-up; each figure is the
shortest time. Exits with 1 if a cell of a sweep takes more than 1.25 times as long.
"""

from __future__ import annotations

import argparse
import time
from typing import TYPE_CHECKING, Final

from vibro.axes import parse_axis
from vibro.quantities import DEFAULTS, QUANTITIES, scene_fields
from vibro.scene import Scene
from vibro.steady import solve
from vibro.sweeps.grid import Grid
from vibro.sweeps.run import sweep_blocks

if TYPE_CHECKING:
    from collections.abc import Callable

NUT: Final = {**DEFAULTS, "drive_angle": 20.0, "static_friction": 0.74, "kinetic_friction": 0.57}
MOST: Final = 1.25  # [1] budget of a sweep over the solver's time


def seconds(run: Callable[[], object]) -> float:
    start = time.perf_counter()
    run()
    return time.perf_counter() - start


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--side", type=int, default=2000, help="values of each of the two axes")
    parser.add_argument("--repeats", type=int, default=5)
    arguments = parser.parse_args()
    side = arguments.side
    axes = {"amplitude": f"0.1:3:{side}", "frequency": f"5:25:{side}"}
    grid = Grid(
        {name: parse_axis(text, QUANTITIES[name]).axis(side) for name, text in axes.items()}, NUT, None
    )
    scene = Scene(**scene_fields(grid.values((slice(None),) * 2)))

    def sweep() -> int:
        return sum(block.cycle.status.size for block in sweep_blocks(grid))

    assert sweep() == side * side
    solve(scene)
    whole, blocks = [], []
    for _ in range(arguments.repeats):
        whole.append(seconds(lambda: solve(scene)))
        blocks.append(seconds(sweep))
    cell = 1e9 / (side * side)
    ratio = min(blocks) / min(whole)
    print(f"vibro.solve       {cell * min(whole):6.1f} ns a cell")
    print(f"blocks of a sweep {cell * min(blocks):6.1f} ns a cell, {ratio:.2f} times as long (budget {MOST})")
    if ratio > MOST:
        raise SystemExit(1)


if __name__ == "__main__":
    main()
