"""The least speed of chosen bodies over the amplitude: where it reaches a target."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final, NamedTuple

import numpy as np

from vibro.core.codes import Regime
from vibro.inverse.extremes import counted, least_of
from vibro.limits import critical_loads_of_lines
from vibro.results.designs import Interval
from vibro.steady import solve

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import NDArray

    from vibro.inverse.bodies import Bodies
    from vibro.inverse.boxes import Box
    from vibro.inverse.extremes import Landings
    from vibro.scene import Scene

    Floats = NDArray[np.float64]

__all__ = ["BEYOND", "Detail", "Scan"]

#: Times the largest critical load, as far as a body that never hops is followed.
BEYOND: Final = 1e3

_CLOSER: Final = 33  # amplitudes around each extremum of the speed between two of the grid
_BESIDE: Final = 1e-12  # relative distance from a critical load at which both its sides are looked at
_JUMP: Final = 1e-6  # relative change of the speed that is a jump


class Detail(NamedTuple):
    """How closely is looked.

    Attributes
    ----------
    amplitudes, rounds : int
        Amplitudes looked at first, and rounds of looking closer at extrema between them.
    end : float
        Relative width to which ends are found.
    exchanges, halves : int
        How often slower bodies are looked for, and parts halved that are not confirmed.
    edge : float
        Relative width to which an end is found by the slowest body of every amplitude.
    """

    amplitudes: int
    rounds: int
    end: float
    exchanges: int
    halves: int
    edge: float


def _run(holds: NDArray[np.bool_], at: int) -> NDArray[np.bool_]:
    """Return the neighbours of a place that hold without a gap."""
    gaps = np.flatnonzero(~holds)
    before, after = gaps[gaps < at], gaps[gaps > at]
    places = np.arange(holds.size)
    low = before[-1] if before.size else -1
    high = after[0] if after.size else holds.size
    return np.asarray((places > low) & (places < high))


class Scan:
    """The least speed of chosen bodies of a box, over the nominal amplitude.

    Parameters
    ----------
    boxes : callable
        Returns the boxes of nominal amplitudes of shape (m, 1).
    bodies : Bodies
        Of each box.
    target : float
        Speed that is wanted [m/s].
    landings : Landings or None
        What landings may be at most; None where no body hops.
    """

    def __init__(
        self,
        boxes: Callable[[Floats], Box],
        bodies: Bodies,
        target: float,
        landings: Landings | None,
    ) -> None:
        self._boxes, self._bodies, self._target, self._landings = boxes, bodies, target, landings

    def intervals(
        self, start: float, top: float, top_by: str, detail: Detail, near: float | None = None
    ) -> list[Interval]:
        """Return where the target is reached between two amplitudes.

        Parameters
        ----------
        start, top : float
            The amplitudes [m].
        top_by : str
            What sets the second.
        detail : Detail
            How closely is looked.
        near : float, optional
            An amplitude: of the intervals that alone is wanted which holds it.
        """
        criticals = self.criticals()
        if start == 0.0:
            start = min(criticals, default=top) / BEYOND
        if not start < top:
            return []
        grid = np.geomspace(start, top, detail.amplitudes)
        beside = np.outer(criticals, [1.0 - _BESIDE, 1.0 + _BESIDE]).ravel()
        grid = np.unique(np.concatenate([grid, beside[(beside > grid[0]) & (beside < top)]]))
        least = self._least(grid)
        for _ in range(detail.rounds):
            grid, least = self._closer(grid, least)
        holds = least >= self._target
        if near is not None:
            holds &= _run(holds, int(np.argmin(np.abs(grid - near))))
        edges = np.flatnonzero(holds[1:] != holds[:-1])
        inside, outside = self._crossings(
            np.where(holds[edges], grid[edges], grid[edges + 1]),
            np.where(holds[edges], grid[edges + 1], grid[edges]),
            detail.end,
        )
        ends = [(x, self._set_by(x, y)) for x, y in zip(inside.tolist(), outside.tolist(), strict=True)]
        if holds[0]:
            ends.insert(0, (float(grid[0]), "onset"))
        if holds[-1]:
            ends.append((top, top_by))
        return [
            Interval(low, high, low_by, high_by)
            for (low, low_by), (high, high_by) in zip(ends[::2], ends[1::2], strict=True)
        ]

    def _scene(self, amplitudes: Floats) -> Scene:
        boxes = self._boxes(amplitudes[:, None])
        return boxes.scene(boxes.points(self._bodies.at(boxes)), fast=False)

    def _speeds(self, amplitudes: Floats) -> Floats:
        """Speeds of all bodies at some amplitudes, of shape (m, n); NaN where one is left out."""
        cycle = solve(self._scene(amplitudes), flight=self._landings is not None)
        speed = counted(cycle, fast=False)
        return speed if self._landings is None else np.where(self._landings.exceeded(cycle), -np.inf, speed)

    def _least(self, amplitudes: Floats) -> Floats:
        return least_of(self._speeds(amplitudes))

    def criticals(self) -> list[float]:
        """Nominal amplitudes at which some body changes its regime."""
        boxes = self._boxes(np.ones((1, 1)))
        points = boxes.points(self._bodies.at(boxes))
        loads = critical_loads_of_lines(
            points.drive_angle, points.static_friction, points.kinetic_friction, points.trough_angle
        )
        found = np.array([np.broadcast_to(load, points.load.shape) for load in loads]) / points.load
        return [float(x) for x in np.unique(found[np.isfinite(found) & (found > 0.0)])]

    def _closer(self, grid: Floats, least: Floats) -> tuple[Floats, Floats]:
        """Add amplitudes around every extremum that may cross the target between two of them."""
        middle, before, after = least[1:-1], least[:-2], least[2:]
        dips = (middle <= before) & (middle <= after) & (middle >= self._target)
        tops = (middle >= before) & (middle >= after) & (middle < self._target) & (middle > 0.0)
        cells = np.flatnonzero(dips | tops) + 1
        if not cells.size:
            return grid, least
        more = np.linspace(grid[cells - 1], grid[cells + 1], _CLOSER)[1:-1].ravel()
        amplitudes, first = np.unique(np.concatenate([grid, more]), return_index=True)
        return amplitudes, np.concatenate([least, self._least(more)])[first]

    def _crossings(self, inside: Floats, outside: Floats, width: float) -> tuple[Floats, Floats]:
        """Close in on amplitudes beyond which the target is missed, to a relative width or to two doubles."""
        while inside.size and np.any(np.abs(outside - inside) > width * inside):
            middle = 0.5 * (inside + outside)
            if np.all((middle == inside) | (middle == outside)):
                break
            holds = self._least(middle) >= self._target
            inside, outside = np.where(holds, middle, inside), np.where(holds, outside, middle)
        return inside, outside

    def _set_by(self, inside: float, outside: float) -> str:
        """Tell what happens between two amplitudes of which one misses the target."""
        speed = self._speeds(np.array([inside, outside]))
        body = int(np.nanargmin(speed[1]))
        if abs(speed[0, body] - speed[1, body]) <= _JUMP * abs(speed[0, body]):
            return "speed"
        regimes = np.asarray(solve(self._scene(np.array([inside, outside])), flight=False).regime)[:, body]
        if Regime.HOPPING in regimes:
            return "hop"
        return "onset" if outside < inside else "back slip"
