"""The whole steady solve of a block of scenes: classify, then the cheapest exact model for each cell."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING, Final, NamedTuple

import numpy as np

from vibro.core.codes import Model, Pattern, Regime, Status
from vibro.core.contact.cycle import one_way_cycles, slides_forward_only, two_way_cycles
from vibro.core.contact.onset import Thresholds, thresholds
from vibro.core.groups import put, take

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from vibro.core.contact.cycle import Cycles
    from vibro.core.contact.slide import Floats
    from vibro.core.groups import Loads

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
    """Steady cycles of scenes, 1-D: codes, lengths in A, speeds in A w, ratios.

    ``coexists`` is 1 where a disturbed body can settle elsewhere or run away, 0 where it cannot, and -1 where
    there is no cycle to compare with.
    """

    regime: Codes
    status: Codes
    pattern: NDArray[np.int64]
    model: Codes
    displacement: Floats
    peak: Floats
    throw_number: Floats
    forward_ratio: Floats
    back_ratio: Floats
    coexists: Codes


def steady_state(scene: Loads, out: SteadyState, *, classes_alone: bool = False) -> None:
    """Solve the steady cycle from rest of every scene but the hopping ones.

    Scenes at rest cost their thresholds, scenes that slip one way a slide, others what
    ``two_way_cycles`` needs; each kind is compressed before it is solved.

    Parameters
    ----------
    scene : Loads
        Groups of the scenes, 1-D, or 0-d where one value serves all.
    out : SteadyState
        1-D arrays that are filled.
    classes_alone : bool
        Whether to find the regimes only: slipping cells then have neither pattern nor numbers.
    """
    if not scene.normal.ndim:  # so that every threshold is 1-D
        scene = scene._replace(normal=np.broadcast_to(scene.normal, out.status.shape))
    at = thresholds(scene)
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        hold = scene.static_friction * scene.normal
        np.divide(scene.across, scene.normal, out=out.throw_number)
        np.add(hold, scene.tangential, out=out.forward_ratio)
        np.divide(at.margins.forward_load, out.forward_ratio, out=out.forward_ratio)
        np.subtract(hold, scene.tangential, out=out.back_ratio)
        np.divide(np.maximum(at.margins.back_load, 0.0), out.back_ratio, out=out.back_ratio)
    out.status[:] = at.edge  # OK is 0, BOUNDARY is 1
    out.pattern.fill(Pattern.R)
    for array in (out.displacement, out.peak, out.coexists):
        array.fill(0)

    # where mu_s = 0 nothing is held either
    exceptional = at.hops | at.unheld | scene.infeasible
    exceptions = exceptional.nonzero()[0]
    if exceptions.size:
        at = at._replace(forward=at.forward & ~exceptional, back=at.back & ~exceptional)
    if classes_alone:
        at = _classify(out, scene, at)
    for slipping, solver in (
        (at.forward > at.back, partial(one_way_cycles, direction=1)),
        (at.back > at.forward, partial(one_way_cycles, direction=-1)),
        (at.forward & at.back, two_way_cycles),
    ):
        cells = slipping.nonzero()[0]
        if cells.size:
            # of drives that do not push along the trough, or have no friction to push against
            with np.errstate(divide="ignore", invalid="ignore"):
                _write(out, cells, solver(take(scene, cells), take(at.margins, cells)))
    for codes, table in ((out.regime, _REGIME_OF_PATTERN), (out.model, _MODEL_OF_PATTERN)):
        table.take(out.pattern, out=codes, mode="clip")  # unlike the default, without a buffer
    if np.count_nonzero(scene.tangential):
        # Where gravity along the trough exceeds kinetic friction a pushed body may slide on for ever.
        loose = np.abs(scene.tangential) > scene.kinetic_friction * scene.normal
        np.copyto(out.coexists, 1, where=loose)
    _withdraw(out, np.isnan(out.displacement))
    if exceptions.size:
        _except(out, exceptions, take(scene, exceptions), take(at, exceptions))
    if classes_alone:
        _withdraw(out, (out.regime == Regime.FORWARD_SLIP) | (out.regime == Regime.BACK_SLIP))


def _classify(out: SteadyState, scene: Loads, at: Thresholds) -> Thresholds:
    """Find the regimes of slipping cells without solving a slide; return the cells that need one.

    A cell that slips both ways slips back in its steady cycle unless its forward slide outlasts the back
    window; F_ and B_ stand for all patterns of their regimes. Only where the trough is steeper than the
    angle of kinetic friction may a slide never end.
    """
    steep = np.abs(scene.tangential) >= scene.kinetic_friction * scene.normal
    out.pattern[at.forward & ~steep] = Pattern.F_
    out.pattern[at.back & ~steep] = Pattern.B_
    cells = (at.forward & at.back & ~steep).nonzero()[0]
    if cells.size:
        lasts, edge = slides_forward_only(take(scene, cells), take(at.margins, cells))
        out.pattern[cells[lasts]] = Pattern.F_
        out.status[cells] |= edge.view(np.int8)
    return at._replace(forward=at.forward & steep, back=at.back & steep)


def _withdraw(out: SteadyState, which: Bools) -> None:
    """Leave cells their regime and status alone."""
    cells = which.nonzero()[0]
    if cells.size:
        out.pattern[cells] = Pattern.NONE
        out.model[cells] = Model.NONE
        out.coexists[cells] = -1
        for numbers in (out.displacement, out.peak):
            numbers[cells] = np.nan


def _except(out: SteadyState, cells: NDArray[np.intp], scene: Loads, at: Thresholds) -> None:
    """Give scenes without a steady contact cycle the status that says why."""
    hold = scene.static_friction * scene.normal
    lean = scene.tangential
    infeasible = np.broadcast_to(scene.infeasible, cells.shape)
    kinds = [infeasible, at.hops, scene.static_friction == 0.0]  # the rest is unheld
    status = np.select(
        kinds, [Status.INFEASIBLE, Status.FLIGHT_NOT_MODELLED, Status.INDETERMINATE], Status.RUNAWAY
    )
    downhill = np.where(lean > 0.0, Regime.BACK_SLIP, Regime.FORWARD_SLIP)
    out.status[cells] = status
    out.regime[cells] = np.select(kinds, [Regime.UNDEFINED, Regime.HOPPING, Regime.UNDEFINED], downhill)
    out.pattern[cells] = Pattern.NONE
    out.model[cells] = Model.NONE
    out.coexists[cells] = -1
    for numbers in (out.displacement, out.peak):
        numbers[cells] = np.nan
    # Where nothing rests, any load makes it slip.
    out.forward_ratio[cells] = np.where(hold + lean > 0.0, out.forward_ratio[cells], np.inf)
    slips_back = (hold - lean <= 0.0) & (at.margins.back_load > 0.0)
    out.back_ratio[cells] = np.where(slips_back, np.inf, out.back_ratio[cells])
    for ratio in (out.throw_number, out.forward_ratio, out.back_ratio):
        ratio[cells[infeasible]] = np.nan


def _write(out: SteadyState, cells: NDArray[np.intp], cycles: Cycles) -> None:
    """Put the solved cells where they belong; those without an answer get NaN and a status that says why."""
    for target, flags in ((out.status, cycles.edge), (out.coexists, cycles.coexists)):
        if np.count_nonzero(flags):
            target[cells] |= flags  # OK is 0, BOUNDARY is 1
    endless = np.isnan(cycles.displacement)
    if np.count_nonzero(endless) or np.count_nonzero(cycles.settled) < cells.size:
        out.status[cells[endless]] = Status.RUNAWAY
        out.status[cells[~cycles.settled]] = Status.UNRESOLVED
        cycles.displacement[~cycles.settled] = np.nan
    put((out.pattern, out.displacement, out.peak), cells, (cycles.pattern, cycles.displacement, cycles.peak))
