"""The page's solver against the compiled one: 100 000 scenes of all drives and 5000 histories, in node.

    python benchmarks/page_solver.py [--scenes 100000] [--histories 5000]

Regimes and statuses are equal but within 16 ulp of a threshold, and where a long cycle is told from irregular
motion. Numbers are equal within 1e-9, or that times how much each input's change is amplified; means within 4
errors. What is beyond is listed; ``largest`` is of all others.
"""

from __future__ import annotations

import argparse
import math
import re
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, NamedTuple

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[1] / "tests"))

from helpers import frozen
from helpers.frozen_questions import Draws, ellipse, harmonics, line, samples, steps
from helpers.node_doors import in_node

if TYPE_CHECKING:
    from collections.abc import Iterator

    from helpers.frozen import Answers
    from helpers.frozen_questions import Batch

EPS: Final = float(np.finfo(np.float64).eps)
#: Shares of the scenes, with the ranges of throw numbers and restitutions; batches of one motion are short.
SHARES: Final[tuple[tuple[Any, float, int, tuple[float, float], float], ...]] = (
    *((kind, 0.27, 10_000, (0.02, 0.98), 0.0) for kind in (line, ellipse)),
    *((kind, 0.05, 1_000, (0.02, 0.98), 0.0) for kind in (harmonics, steps, samples)),
    *((kind, 0.01, 500, (0.0, 0.0), 0.0) for kind in (harmonics, steps, samples)),
    *((kind, 0.08, 2_000, (1.2, 5.0), 0.0) for kind in (line, ellipse)),
    *((kind, 0.01, 200, (1.2, 5.0), 0.0) for kind in (harmonics, steps, samples)),
    *((kind, 0.02, 500, (1.2, 5.0), e) for kind in (line, ellipse) for e in (0.3,)),
    *((kind, 0.01, 500, (1.2, 5.0), e) for kind in (line, ellipse) for e in (0.6,)),
)


class Found(NamedTuple):
    """How many cells were compared, were near a threshold, were amplified, and are beyond."""

    cells: int
    near: int
    amplified: int
    worst: float
    beyond: list[str]


def drawn(scenes: int) -> Iterator[Batch]:
    """Draw scenes."""
    draw = Draws("page")
    for kind, share, size, throw, e in SHARES:
        wanted = math.ceil(share * scenes)
        for begin in range(0, wanted, size):
            yield kind(draw, min(size, wanted - begin), throw, e)


def followed(histories: int) -> Iterator[Batch]:
    """Draw histories, a third of them from another start than rest."""
    draw = Draws("histories of the page")
    for _ in range(histories // 250):
        for kind in (line, ellipse, harmonics, steps, samples):
            for throw, e in (((0.02, 0.98), 0.0), ((1.2, 5.0), 0.3)):
                batch = kind(draw, 25, throw, e)
                yield batch | {
                    "start_phase": draw(-3.0, 3.0, 25) * draw.one_in(3, 25),
                    "start_velocity": draw(-0.2, 0.2, 25) * draw.one_in(3, 25),
                    "length": draw(0.01, 0.2, 25),
                }


def apart(old: Answers, new: Answers) -> dict[str, Any]:
    """Return the differences of numbers over what they are compared with; inf where one is missing."""
    found = {}
    for key, x in old.numbers.items():
        y = new.numbers[key]
        with np.errstate(all="ignore"):
            size = np.maximum(np.maximum(np.abs(x), np.abs(y)), old.sizes.get(key, 0.0))
            found[key] = np.where((x == y) | (np.isnan(x) & np.isnan(y)), 0.0, np.abs(x - y) / size)
        found[key] = np.where(np.isnan(found[key]), math.inf, found[key])
    return found


def short(text: str) -> str:
    """Leave out a long pattern: its code is beyond 2^53, and pages spell it letter by letter."""
    return re.sub(r" [FBH_ ]{19,} (?=[a-z])", " ", text)


def compare(name: str, batch: Batch) -> Found:
    """Answer a batch with both solvers."""
    old = frozen.answer(name, batch)
    with in_node():
        new = frozen.answer(name, batch)
    differences = apart(old, new)
    means = np.array([" averaged " in text for text in old.texts])
    nothing = np.zeros(means.size)
    error = np.hypot(*(x.numbers.get("mean_velocity_error", nothing) for x in (old, new)))
    shift = np.abs(np.subtract(*(x.numbers.get("displacement_per_cycle", nothing) for x in (old, new))))
    worst = np.max(list(differences.values()), axis=0)
    worst = np.where(means, np.where(shift <= 4.0 * error, 0.0, math.inf), worst)
    texts = np.array([short(x) != short(y) for x, y in zip(old.texts, new.texts, strict=True)])
    near = amplified = 0
    beyond = []
    for i in np.flatnonzero(texts | (worst > 1e-9)).tolist():
        one = frozen._cell(batch, slice(i, i + 1))
        inputs = [key for key, x in batch.items() if isinstance(x, np.ndarray)]
        moved = [
            frozen.answer(name, frozen._changed(one, key, 1.0 + side * 16.0 * EPS))
            for key in inputs
            for side in (-1.0, 1.0)
        ]
        if texts[i]:
            if any(short(other.texts[0]) != short(old.texts[i]) for other in moved):
                near += 1
            else:
                beyond.append(f"{old.texts[i]} | {new.texts[i]} | {one}")
            continue
        alone = frozen.answer(name, one)
        spread = max(float(np.max(list(apart(alone, other).values()))) for other in moved) / (16.0 * EPS)
        if worst[i] <= 1e-9 * max(1.0, spread) or spread > 1e-3 / 1e-9:
            amplified, worst[i] = amplified + 1, 0.0
        else:
            key = max(differences, key=lambda k: differences[k][i])
            beyond.append(f"{key}: {old.numbers[key][i]!r} | {new.numbers[key][i]!r} | {one}")
            worst[i] = 0.0
    exact = worst[~texts & ~means]
    return Found(worst.size, near, amplified, float(exact.max(initial=0.0)), beyond)


def main() -> None:
    """Compare, and print a table."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--scenes", type=int, default=100_000)
    parser.add_argument("--histories", type=int, default=5_000)
    given = parser.parse_args()
    print(f"{'set':12}{'cells':>9}{'at thresholds':>15}{'amplified':>11}{'largest':>10}{'beyond':>8}")
    for name, batches in (("contact", drawn(given.scenes)), ("histories", followed(given.histories))):
        found = [compare(name, batch) for batch in batches]
        cells, near, amplified = (sum(x) for x in list(zip(*found, strict=True))[:3])
        beyond = [text for one in found for text in one.beyond]
        print(f"{name:12}{cells:9}{near:15}{amplified:11}{max(x.worst for x in found):10.2g}{len(beyond):8}")
        for text in beyond[:10]:
            print(f"  {text}")


if __name__ == "__main__":
    main()
