"""Whether the motion of a part is relative to the trough, or over the ground and holds the trough's."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from vibro.motion.settled import SettledMotion
from vibro.records.alignment import Observation, align
from vibro.records.folding import Floats, detrended
from vibro.records.signals import DERIVATIVES, rounded
from vibro.records.tolerances import TOL
from vibro.results.history import Sample


@dataclass(frozen=True, eq=False)
class _AtRest(SettledMotion):
    """A body that rests on the trough of another motion."""

    def sample(self, time: Floats) -> Sample:
        sample, rest = super().sample(time), np.zeros_like(time)
        return replace(sample, position=rest, velocity=rest, acceleration=rest, friction=-sample.inertial)


def of_another_frame(observation: Observation, motion: SettledMotion) -> list[str]:
    """Warn of motions that are better explained in the frame that was not given.

    Four explanations are compared: the computed motion and a part that rests, each relative to the trough and
    over the ground. One of the other frame must leave a quarter of what the best of the given frame leaves,
    and little of the trough's motion.

    Parameters
    ----------
    observation : Observation
        The record, as it was recorded.
    motion : SettledMotion
        The model.
    """
    names = [name for name in observation.signals if name in DERIVATIVES]
    cycle = np.arange(TOL.shifts) * motion.period / TOL.shifts
    sizes = {name: float(np.abs(x).mean()) for name, x in motion.trough(cycle).items() if name in names}
    if not sizes or not all(sizes.values()):
        return []
    seen = replace(observation.middle, signals={name: observation.middle.signals[name] for name in names})
    resting = _AtRest(**vars(motion) | {"advance": 0.0})
    bodies = {"computed": motion, "resting": resting}
    given = min(_left(seen, body, sizes) for body in bodies.values())
    other = replace(seen, absolute=not seen.absolute)
    found = {name: _left(other, body, sizes) for name, body in bodies.items()}
    best = min(found, key=found.__getitem__)
    most = TOL.other_frame_left if best == "computed" else TOL.rest_left
    if found[best] > min(most, TOL.other_frame_gain * given):
        return []
    what = f"the {' and the '.join(names)} fit{'s' if len(names) == 1 else ''}"
    times = f"{rounded(given / max(found[best], TOL.least_misfit))} times better"
    if seen.absolute:
        return [f"{what} {times} relative to the trough: leave out --absolute if the sensor rides on it"]
    if best == "computed":
        return [f"{what} {times} over the ground: give --absolute if a camera or a sensor stands there"]
    own = "give --absolute of a part that does not slide, --trough-along of a sensor on the trough"
    return [f"{what} the trough's own motion {times}: {own}"]


def _left(observation: Observation, motion: SettledMotion, sizes: dict[str, float]) -> float:
    """Return the mean absolute misfit over that of the trough's motion; the geometric mean of all signals."""
    shift = align(observation, motion).shift
    model = observation.model(motion, observation.time + (0.0 if math.isnan(shift) else shift))
    left = []
    for name, size in sizes.items():
        off = observation.signals[name] - model[name]
        if name == "displacement":
            # Wrong friction changes the computed advance; a part that rests has none.
            off = detrended(observation.time, off, 0 if isinstance(motion, _AtRest) else 1)
        left.append(float(np.abs(off).mean()) / size)
    return math.prod(left) ** (1.0 / len(left))
