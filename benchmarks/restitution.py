"""Bounds over bands of restitution against other bodies that are drawn from the same boxes, which hop.

    python benchmarks/restitution.py [--boxes 200] [--bodies 4096] [--first 0]

Bounds are those of samples: a table says for how many boxes some body is slower, or faster, than its bound,
and by how much over the larger bound.
"""

from __future__ import annotations

import argparse
import sys
import time
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[1] / "tests"))

from helpers.restitution_boxes import beyond, box_of, drawn_band

import vibro


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--boxes", type=int, default=200)
    parser.add_argument("--bodies", type=int, default=4096)
    parser.add_argument("--first", type=int, default=0, help="first seed")
    asked = parser.parse_args()
    found, spent = [], 0.0
    for seed in range(asked.first, asked.first + asked.boxes):
        scene, bands = drawn_band(seed)
        start = time.process_time()
        guarantee = vibro.guarantee(scene, **bands)
        spent += time.process_time() - start
        found.append(beyond(guarantee, box_of(scene, bands), asked.bodies, seed))
    print(
        f"{asked.boxes} boxes, {asked.bodies} other bodies of each; {spent / asked.boxes:.2f} s a guarantee"
    )
    for name, excess in zip(("slower", "faster"), np.array(found).T, strict=True):
        counts = ", ".join(
            f"{np.count_nonzero(excess > size)} by more than {size:g}" for size in (1e-9, 1e-6, 1e-3)
        )
        print(f"a body {name} than its bound: {counts}; at most {max(excess.max(), 0.0):.2g}")


if __name__ == "__main__":
    main()
