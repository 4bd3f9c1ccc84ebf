"""The whole steady solve of a block of scenes: classify, then the cheapest exact model for each cell."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING, Final, NamedTuple

import numpy as np

from vibro.core.codes import Model, Pattern, Regime, Status
from vibro.core.cycle import one_way_cycles, two_way_cycles
from vibro.core.groups import take
from vibro.core.onset import thresholds

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from vibro.core.cycle import Cycles
    from vibro.core.groups import Loads
    from vibro.core.onset import Margins
    from vibro.core.slide import Floats

    Codes = NDArray[np.int8]
    Bools = NDArray[np.bool_]

__all__ = ["SteadyState", "steady_state"]

_REGIME_OF_PATTERN: Final = np.array(
    [
        Regime.UNDEFINED,
        Regime.NO_SLIP,
        Regime.FORWARD_SLIP,
        *[Regime.BACK_SLIP] * 5,
    ],
    np.int8,
)
_MODEL_OF_PATTERN: Final = np.array(
    [
        Model.NONE,
        Model.REST,
        Model.ONE_SLIDE,
        Model.ONE_SLIDE,
        *[Model.TWO_SLIDES] * 3,
        Model.CLOSED_FORM,
    ],
    np.int8,
)


class SteadyState(NamedTuple):
    """Steady cycles of scenes, 1-D: codes, lengths in A, speeds in A w, ratios."""

    regime: Codes
    status: Codes
    pattern: Codes
    model: Codes
    displacement: Floats
    peak: Floats
    throw_number: Floats
    forward_ratio: Floats
    back_ratio: Floats
    coexists: Bools


def _ratios(scene: Loads, at: Margins) -> tuple[Floats, Floats, Floats]:
    """Throw number, 1/s_f and 1/s_b; inf where nothing rests, 0 where no load slips it back."""
    hold = scene.static_friction * scene.normal
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        throw = scene.across / scene.normal
        forward = np.where(hold > -scene.tangential, at.forward_load / (hold + scene.tangential), np.inf)
        back = np.where(hold > scene.tangential, at.back_load / (hold - scene.tangential), np.inf)
    return throw, forward, np.where(at.back_load > 0.0, back, 0.0)


def steady_state(scene: Loads) -> SteadyState:
    """Solve the steady cycle from rest of every scene.

    Scenes at rest cost their thresholds, scenes that slip one way a slide, others what
    ``two_way_cycles`` needs; each kind is compressed before it is solved.

    Parameters
    ----------
    scene : Loads
        Groups of the scenes, 1-D, or 0-d where one value serves all.

    Returns
    -------
    SteadyState
        1-D arrays.
    """
    at = thresholds(scene)
    mu_s, mu_d = scene.static_friction, scene.kinetic_friction
    n = at.edge.size
    status = np.where(at.edge, Status.BOUNDARY, Status.OK).astype(np.int8)
    regime = np.full(n, Regime.NO_SLIP, np.int8)
    # later lines overrule earlier ones
    status[at.restless] = Status.RUNAWAY
    status[np.broadcast_to(mu_s == 0.0, n)] = Status.INDETERMINATE
    status[at.hops] = Status.FLIGHT_NOT_MODELLED
    status[np.broadcast_to((mu_d > mu_s) | (scene.contrast <= 0.0), n)] = Status.INFEASIBLE
    answered = status <= Status.BOUNDARY
    regime[~answered] = Regime.UNDEFINED
    regime[status == Status.FLIGHT_NOT_MODELLED] = Regime.HOPPING
    runaway = status == Status.RUNAWAY
    if runaway.any():
        uphill = np.broadcast_to(scene.tangential > 0.0, n)
        regime[runaway] = np.where(uphill[runaway], Regime.BACK_SLIP, Regime.FORWARD_SLIP)

    throw, forward, back = (np.broadcast_to(ratio, n) for ratio in _ratios(scene, at.margins))
    out = SteadyState(
        regime,
        status,
        pattern=np.where(answered, np.int8(Pattern.R), np.int8(Pattern.NONE)),
        model=np.where(answered, np.int8(Model.REST), np.int8(Model.NONE)),
        displacement=np.where(answered, 0.0, np.nan),
        peak=np.where(answered, 0.0, np.nan),
        throw_number=throw,
        forward_ratio=forward,
        back_ratio=back,
        coexists=np.zeros(n, np.bool_),
    )
    for slipping, solver in (
        (at.forward & ~at.back, partial(one_way_cycles, direction=1)),
        (at.back & ~at.forward, partial(one_way_cycles, direction=-1)),
        (at.forward & at.back, two_way_cycles),
    ):
        cells = np.flatnonzero(answered & slipping)
        if cells.size:
            _write(out, cells, solver(take(scene, cells), take(at.margins, cells)))
    return out


def _write(out: SteadyState, cells: NDArray[np.intp], cycles: Cycles) -> None:
    """Put the solved cells where they belong, with the status that each has earned."""
    endless = np.isnan(cycles.displacement)
    edge = cycles.edge | (out.status[cells] == Status.BOUNDARY)
    status = np.where(edge, np.int8(Status.BOUNDARY), np.int8(Status.OK))
    status[endless] = Status.RUNAWAY
    status[~cycles.settled] = Status.UNRESOLVED
    pattern = cycles.pattern
    out.regime[cells] = _REGIME_OF_PATTERN[pattern]
    out.status[cells] = status
    unanswered = status > Status.BOUNDARY
    pattern[unanswered] = Pattern.NONE
    cycles.displacement[unanswered] = np.nan
    cycles.peak[unanswered] = np.nan
    out.pattern[cells] = pattern
    out.model[cells] = _MODEL_OF_PATTERN[pattern]
    out.displacement[cells] = cycles.displacement
    out.peak[cells] = cycles.peak
    out.coexists[cells] = cycles.coexists
