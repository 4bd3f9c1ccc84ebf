"""The methods that are compared, each run as a user would run it."""

from __future__ import annotations

import math
import time
import warnings
from functools import partial
from typing import TYPE_CHECKING, Any, Final, NamedTuple

import numpy as np

from vibro.accuracy.events import simulate_by_events
from vibro.accuracy.motion import Found, motion_arrays, motions
from vibro.accuracy.reference import exact
from vibro.accuracy.sample import take_scenes
from vibro.accuracy.smoothed import simulate_smoothed
from vibro.accuracy.stepping import simulate_by_steps
from vibro.core.codes import Output, Regime
from vibro.drives import Ability
from vibro.steady import solve

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from numpy.typing import NDArray

    from vibro.accuracy.motion import TroughBody
    from vibro.reals import Floats
    from vibro.scene import Scene

    Tick = Callable[[], None]


# One run of the solver takes milliseconds, too short to be timed: take the best of several, on at least this
# many scenes.
_REPEATS: Final = 5
_BATCH: Final = 8192  # [scenes]


class Answers(NamedTuple):
    """What a method finds for several scenes.

    Attributes
    ----------
    displacement : array
        Displacement per drive cycle [A]; NaN without a steady cycle.
    regime : int array
        Codes of ``Regime``; UNDEFINED where the method gave up.
    """

    displacement: Floats
    regime: NDArray[Any]


class Method(NamedTuple):
    """A way to solve scenes.

    Attributes
    ----------
    name, setting : str
        The method, and the value of the parameter that trades speed for accuracy.
    share : float
        Fraction of the sample that it is run on; slow methods are run on the beginning only.
    answer : callable
        ``answer(scene, tick)`` solves scenes of a 1-D shape, and returns the answers and the time taken [s].
        It calls ``tick()`` after each scene, or not at all.
    """

    name: str
    setting: str
    share: float
    answer: Callable[[Scene, Tick], tuple[Answers, float]]


def _answers_of(found: Sequence[Found]) -> Answers:
    """Collect displacements, NaN where a method gave up, and regimes from the directions of the slides."""
    codes = {"": Regime.NO_SLIP, "F": Regime.FORWARD_SLIP, "B": Regime.BACK_SLIP, "BF": Regime.BACK_SLIP}
    regimes = [Regime.UNDEFINED if math.isnan(d) else codes["".join(sorted(slides))] for d, slides in found]
    return Answers(np.array([displacement for displacement, _ in found]), np.array(regimes, np.int8))


def _one_by_one(simulate: Callable[[TroughBody], Found], scene: Scene, tick: Tick) -> tuple[Answers, float]:
    bodies = list(motions(scene))
    found = []
    start = time.perf_counter()
    with warnings.catch_warnings():
        # A solver that warns also fails, and failures are counted.
        warnings.simplefilter("ignore")
        for body in bodies:
            found.append(simulate(body))
            tick()
    return _answers_of(found), time.perf_counter() - start


def _by_steps(steps: int, scene: Scene, tick: Tick) -> tuple[Answers, float]:
    motion = motion_arrays(scene)
    start = time.perf_counter()
    found = simulate_by_steps(motion, steps)
    return _answers_of(found), time.perf_counter() - start


def _by_vibro(output: Output, scene: Scene, tick: Tick) -> tuple[Answers, float]:
    """Solve the scenes as one batch; a few are repeated to fill it, because the solver is made for many."""
    n = scene.shape[0]
    batch = take_scenes(scene, np.arange(max(n, _BATCH)) % n)
    seconds = []
    for _ in range(_REPEATS):
        start = time.perf_counter()
        cycle = solve(batch, output=output)
        seconds.append(time.perf_counter() - start)
    displacement = cycle.displacement_per_cycle[:n] / scene.scale
    if output is Output.REGIMES:
        displacement[:] = np.nan  # the zeros of bodies at rest are known, but no speed was computed
    return Answers(displacement, cycle.regime[:n]), min(seconds) * n / batch.shape[0]


def reference_answers(scene: Scene, tick: Tick) -> Answers:
    """Follow the scenes that stay in contact and can rest as exactly as possible; NaN in all others."""
    flat: Any = scene.flat()
    flat.require(Ability.PROOF)
    body = motion_arrays(scene)
    cells = (body.across <= body.normal) & (np.abs(body.tangential) < body.static_friction * body.normal)
    found = []
    for here, values in zip(cells.tolist(), zip(*(f.tolist() for f in flat[:-1]), strict=True), strict=True):
        displacement, slides = exact(values) if here else Found(math.nan, "")
        found.append(Found(float(displacement), slides))
        tick()
    return _answers_of(found)


def _events(solver: Any, rtol: float, share: float, max_step: float = np.inf) -> Method:
    setting = f"rtol {rtol:.0e}".replace("e-0", "e-") + (", short steps" if np.isfinite(max_step) else "")
    run = partial(simulate_by_events, solver=solver, rtol=rtol, max_step=max_step)
    return Method(f"events, {solver}", setting, share, partial(_one_by_one, run))


def _smoothed(width: float, share: float) -> Method:
    run = partial(simulate_smoothed, width=width)
    return Method("smoothed friction", f"width {width:g} A w", share, partial(_one_by_one, run))


def _steps(steps: int, share: float) -> Method:
    return Method("time steps", f"{steps} a cycle", share, partial(_by_steps, steps))


METHODS: Final = (
    Method("vibro", "exact", 1.0, partial(_by_vibro, Output.EXACT)),
    Method("vibro", "regimes alone", 1.0, partial(_by_vibro, Output.REGIMES)),
    _events("RK45", 1e-3, 0.1),
    _events("RK45", 1e-6, 0.04),
    _events("RK45", 1e-9, 0.01),
    _events("DOP853", 1e-6, 0.04),
    _events("DOP853", 1e-9, 0.02),
    _events("DOP853", 1e-12, 0.01),
    _events("LSODA", 1e-3, 0.1),
    _events("LSODA", 1e-6, 0.04),
    _events("LSODA", 1e-6, 0.02, max_step=2.0 * np.pi / 50.0),
    _events("LSODA", 1e-9, 0.02),
    _smoothed(1e-2, 0.02),
    _smoothed(1e-3, 0.02),
    _smoothed(1e-4, 0.02),
    _steps(20, 1.0),
    _steps(40, 1.0),  # as the frames per cycle of the paper's CAD simulation
    _steps(400, 0.2),
    _steps(4000, 0.02),
)
