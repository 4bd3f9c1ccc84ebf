"""Fixed-step time stepping of Coulomb friction with stiction, many scenes at once."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from vibro.accuracy.motion import Found, TroughBody

if TYPE_CHECKING:
    from numpy.typing import NDArray


_TURN: Final = 2.0 * math.pi
# [A per rad of a step] Smaller changes of the displacement from cycle to cycle count as none.
_SETTLED: Final = 1e-3
_MOST_TURNS: Final = 300


def simulate_by_steps(motion: TroughBody, steps: int) -> list[Found]:
    """Simulate scenes from rest with equal time steps until the displacement repeats.

    Moreau's rule: the load at the end of a step acts during the whole step; then friction reduces the speed
    by its impulse, but at most to zero. Static friction applies if the body was at rest.

    Parameters
    ----------
    motion : TroughBody
        Scenes in contact, as flat arrays.
    steps : int
        Steps per drive cycle.

    Returns
    -------
    list of Found
        One for each scene; NaN where the motion does not settle.
    """
    n = motion.along.size
    displacement, forward, back = np.full(n, np.nan), np.zeros(n, np.bool_), np.zeros(n, np.bool_)
    cells = np.arange(n)
    speed, before = np.zeros(n), np.full(n, np.inf)
    for _ in range(_MOST_TURNS):
        speed, place, highest, lowest = _turn(motion, speed, steps)
        settled = np.abs(place - before) <= _SETTLED * _TURN / steps
        done = cells[settled]
        displacement[done] = place[settled]
        forward[done], back[done] = highest[settled] > 0.0, lowest[settled] < 0.0
        going = ~settled
        if not going.any():
            break
        cells, speed, before = cells[going], speed[going], place[going]
        motion = TroughBody(*(field[going] for field in motion))
    return [
        Found(d, "F" * f + "B" * b)
        for d, f, b in zip(displacement.tolist(), forward.tolist(), back.tolist(), strict=True)
    ]


def _turn(motion: TroughBody, speed: NDArray[Any], steps: int) -> tuple[NDArray[Any], ...]:
    """Speed after one drive cycle, displacement in it, and the highest and lowest speed."""
    along, across, normal, tangential, mu_s, mu_d = motion
    h = _TURN / steps
    place, highest, lowest = (np.zeros_like(speed) for _ in range(3))
    for step in range(1, steps + 1):
        sine = math.sin(h * step)
        free = speed + h * (along * sine - tangential)
        impulse = h * (normal - across * sine)  # of the normal load
        grip = np.where(speed == 0.0, mu_s, mu_d) * impulse
        speed = np.where(np.abs(free) <= grip, 0.0, free - np.copysign(mu_d * impulse, free))
        place += speed
        np.maximum(highest, speed, out=highest)
        np.minimum(lowest, speed, out=lowest)
    return speed, h * place, highest, lowest
