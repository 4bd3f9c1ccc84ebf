"""Methods run on the same scenes, and the error of each against the reference."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from vibro.accuracy.methods import METHODS, Answers, reference_answers
from vibro.accuracy.reference import NAME
from vibro.accuracy.sample import draw_scenes, take_scenes
from vibro.core.codes import Regime
from vibro.drives import Line
from vibro.scene import Scene

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from numpy.typing import NDArray

    from vibro.accuracy.methods import Method, Tick
    from vibro.sweeps.grid import Grid


_FEWEST: Final = 20  # scenes that every method is run on at least
_DRAWS: Final = 20  # most times that a sample is drawn to find enough scenes in contact

# [1] An error of this fraction of the true speed, or more, is a failure and no lack of accuracy.
_FAILURE: Final = 0.5


@dataclass(frozen=True)
class Row:
    """One method compared with the reference; errors are of the mean speed, in A f.

    Attributes
    ----------
    method, setting : str
        What was run.
    scenes : int
        Number of scenes.
    time_us : float
        Time per scene [us].
    error_max, error_999 : float
        Largest error, and the one that 99.9 % of the answers do not exceed; NaN if the method gives no speed.
    error_median : float
        Over the scenes in which the body slips; where it rests most methods are exact.
    beyond_tolerance : int
        Number of answers whose error exceeds the tolerance.
    wrong_regime_share : float
        Answers with a wrong regime, as a share of all answers.
    silent_failures : int
        Number of answers whose error is half of the true speed or more, although the method reports no
        failure.
    gave_up : int
        Number of scenes without an answer.
    drift_at_rest : float
        Largest speed where the body is really at rest [A f].
    """

    method: str
    setting: str
    scenes: int
    time_us: float
    error_max: float
    error_999: float
    error_median: float
    beyond_tolerance: int
    wrong_regime_share: float
    silent_failures: int
    gave_up: int
    drift_at_rest: float


@dataclass(frozen=True)
class Trade:
    """Methods compared with one reference: what each trades of speed for accuracy.

    Attributes
    ----------
    rows : tuple of Row
        One for each method, in their order.
    reference : str
        What errors are measured against.
    scenes, drawn : int
        Number of scenes in contact, and of those drawn to find them.
    tolerance : float
        Errors up to this count as none [A f].
    """

    rows: tuple[Row, ...]
    reference: str
    scenes: int
    drawn: int
    tolerance: float


def runs(methods: Sequence[Method], scenes: int) -> list[int]:
    """Return how many scenes each method is run on."""
    return [min(scenes, max(_FEWEST, round(method.share * scenes))) for method in methods]


def run_methods(
    grid: Grid,
    scenes: int,
    *,
    tolerance: float,
    methods: Sequence[Method] = METHODS,
    report: Callable[[int], None] = lambda done: None,
) -> Trade:
    """Run methods on scenes drawn from a grid.

    Parameters
    ----------
    grid : Grid
        What to draw from. Scenes that hop, run away or have no steady cycle are left out.
    scenes : int
        How many to draw; each method is run on the first of them, according to its share.
    tolerance : float
        Errors in mean speed up to this count as none [A f].
    methods : sequence of Method, optional
        What to run.
    report : callable, optional
        Called with the number of scenes done, of ``scenes + sum(runs(methods, scenes))``.

    Returns
    -------
    Trade
        The trade-off, of fewer scenes than requested if the grid does not contain enough; without a row if
        it contains none.
    """
    done = 0

    def tick(number: int = 1) -> None:
        nonlocal done
        done += number
        report(done)

    sample, truth, drawn = _sample(grid, scenes, tick)
    found = sample.shape[0]
    if not found:
        return Trade((), NAME, 0, drawn, tolerance)
    rows = []
    for method, n in zip(methods, runs(methods, found), strict=True):
        before = done
        answers, seconds = method.answer(take_scenes(sample, slice(n)), tick)
        tick(n - (done - before))
        rows.append(_row(method, answers, seconds, Answers(*(x[:n] for x in truth)), tolerance))
    return Trade(tuple(rows), NAME, found, drawn, tolerance)


def _sample(grid: Grid, scenes: int, tick: Tick) -> tuple[Scene, Answers, int]:
    """Draw scenes until enough of them have a steady cycle in contact."""
    samples: list[Scene] = []
    truths: list[Answers] = []
    found = drawn = 0
    while found < scenes and drawn < min(_DRAWS * scenes, grid.size):
        part = draw_scenes(grid, drawn, scenes)
        drawn += scenes
        answers = reference_answers(part, tick)
        cells = np.flatnonzero(np.isfinite(answers.displacement))[: scenes - found]
        found += cells.size
        samples.append(take_scenes(part, cells))
        truths.append(Answers(*(x[cells] for x in answers)))
    fields = {name: np.concatenate([getattr(sample, name) for sample in samples]) for name in Line._fields}
    truth = Answers(*map(np.concatenate, zip(*truths, strict=True)))
    return Scene(**fields), truth, min(drawn, grid.size)


def _row(method: Method, answers: Answers, seconds: float, truth: Answers, tolerance: float) -> Row:
    n = answers.displacement.size
    answered = answers.regime != Regime.UNDEFINED
    measured = np.isfinite(answers.displacement)
    error = np.abs(answers.displacement - truth.displacement)[measured]
    known = truth.displacement[measured]
    still = truth.regime[measured] == Regime.NO_SLIP
    return Row(
        method.name,
        method.setting,
        n,
        1e6 * seconds / n,
        error_max=_quantile(error, 1.0),
        error_999=_quantile(error, 0.999),
        error_median=_quantile(error[~still], 0.5),
        beyond_tolerance=int(np.sum(error > tolerance)),
        wrong_regime_share=float(np.mean((answers.regime != truth.regime)[answered]))
        if answered.any()
        else 0.0,
        silent_failures=int(np.sum((known != 0.0) & (error >= _FAILURE * np.abs(known)))),
        gave_up=int(np.sum(~answered)),
        drift_at_rest=float(np.max(error[still], initial=0.0)),
    )


def _quantile(values: NDArray[np.float64], share: float) -> float:
    return float(np.quantile(values, share, method="higher")) if values.size else np.nan


def advice(trade: Trade) -> str:
    """Recommend a method in one line."""
    right = [
        row
        for row in trade.rows
        if math.isfinite(row.error_max)
        and row.beyond_tolerance == row.wrong_regime_share == row.silent_failures == row.gave_up == 0
    ]
    limit = f"within {trade.tolerance:g} A f in every scene"
    if not right:
        closest = min((r for r in trade.rows if math.isfinite(r.error_max)), key=lambda r: r.error_max)
        reached = f"{closest.method} ({closest.setting}), within {closest.error_max:.2g}"
        return f"No method stays {limit}; the closest is {reached}."
    best = min(right, key=lambda row: row.time_us)
    rivals = [row for row in right if row.method != best.method]
    if not rivals:
        return f"Use {best.method} ({best.setting}): no other method run here stays {limit}."
    rival = min(rivals, key=lambda row: row.time_us)
    faster = _times(rival.time_us / best.time_us)
    return (
        f"Use {best.method} ({best.setting}): {faster} as fast as the next that stays {limit} "
        f"({rival.method}, {rival.setting})."
    )


def _times(ratio: float) -> str:
    return f"{float(f'{ratio:.2g}'):.0f} times" if ratio >= 10.0 else f"{ratio:.2g} times"
