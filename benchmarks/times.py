"""Do the intervals of friction and restitution from traverse times hold what they should? Simulated tables.

Usage: python benchmarks/times.py [--tables 200] [--seed 1] [--kinds ratio,both,hops]

A table has 5 to 9 rows: amplitudes from a seventh of the hop on, frequencies that differ by up to a fifth,
times over 600 mm with normal errors of 1 to 4 %, which half of the tables state. The part may not arrive in
some rows. Drive angle 12-35 deg, level or 3 deg uphill, mu_d 0.15-0.7. The times come from the walk of the
tests, which shares nothing with the package. Kinds, by what is unknown:

  ratio   mu_d, at its known ratio to mu_s
  both    mu_s and mu_d
  hops    mu_d at its known ratio, and the restitution of 0.05-0.4: every second row hops

Of each quantity the table counts the intervals; those that hold the true value; the ones without an end on
one side; those in pieces; and gives the median half of their length over the true value. Further it counts
the tables in which a row is left out although none is wrong, those whose search ended early, and gives the
mean time of a fit.
"""

from __future__ import annotations

import argparse
import sys
import time
from pathlib import Path

import numpy as np

import vibro

sys.path.insert(0, str(Path(__file__).parents[1] / "tests"))
from helpers.made_times import KINDS, made_table


def main() -> None:
    """Print a table a kind."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--tables", type=int, default=200)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--kinds", default=",".join(KINDS))
    given = parser.parse_args()
    head = f"{'unknown':8} {'quantity':17} {'tables':>6} {'hold':>7} {'open':>5} {'pieces':>6} {'half':>7}"
    print(f"{head} {'named':>5} {'early':>5} {'seconds':>7}")
    for kind in given.kinds.split(","):
        random = np.random.default_rng(given.seed)
        counts: dict[str, list[tuple[bool, bool, bool, float]]] = {}
        named, early, spent = 0, 0, 0.0
        for _ in range(given.tables):
            made = made_table(random, kind)
            start = time.perf_counter()
            found = vibro.fit_speeds(made.table, **made.rest)
            spent += time.perf_counter() - start
            named += bool(found.left_out)
            early += any("ended early" in text for text in found.statements)
            for p in found.parameters:
                true, hull = made.truth[p.name], p.intervals[-1][1] - p.intervals[0][0]
                holds = any(low <= true <= high for low, high in p.intervals)
                is_open = p.open_low or p.open_high
                counts.setdefault(p.name, []).append(
                    (holds, is_open, len(p.intervals) > 1, 0.5 * hull / true)
                )
        for name, rows in counts.items():
            holds, opens, pieces, halves = (np.array(column) for column in zip(*rows, strict=True))
            shares = f"{100.0 * holds.mean():5.1f} % {opens.sum():5d} {pieces.sum():6d}"
            half, mean = 100.0 * np.median(halves), spent / given.tables
            print(
                f"{kind:8} {name:17} {len(rows):6d} {shares} {half:5.1f} % {named:5d} {early:5d} {mean:7.2f}"
            )


if __name__ == "__main__":
    main()
