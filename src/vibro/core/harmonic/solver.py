"""The whole steady solve of a block of scenes with harmonics."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final, NamedTuple

import numpy as np

from vibro.core.codes import SPELT_PATTERNS, Mode, Model, Pattern, Regime, Status
from vibro.core.contact.onset import FEW_ULP
from vibro.core.harmonic.coexistence import coexisting
from vibro.core.harmonic.cycle import stopped
from vibro.core.harmonic.settling import settle
from vibro.core.harmonic.slides import lanes
from vibro.core.harmonic.waves import turning_points, values

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from vibro.core.contact.solver import SteadyState
    from vibro.core.harmonic.cycle import Cycles
    from vibro.core.harmonic.loads import HarmonicLoads
    from vibro.core.harmonic.slides import Lanes

    Floats = NDArray[np.float64]
    Bools = NDArray[np.bool_]
    Indices = NDArray[np.intp]

__all__ = ["harmonic_state"]


class _Waves(NamedTuple):
    """Loads of scenes, 1-D, as waves: arrays of shape (2 H + 1, scenes)."""

    along: Floats
    across: Floats
    normal: Floats
    tangential: Floats
    static_friction: Floats
    kinetic_friction: Floats

    def beyond(self, friction: Floats, direction: int) -> Floats:
        """Load of a direction beyond friction."""
        waves: Floats = direction * self.along + friction * self.across
        waves[0] -= friction * self.normal + direction * self.tangential
        return waves


def _waves(scene: HarmonicLoads, n: int) -> _Waves:
    def stack(sines: tuple[Floats, ...], cosines: tuple[Floats, ...]) -> Floats:
        waves = np.zeros((1 + 2 * len(sines), n))
        for row, values in enumerate((*sines, *cosines), 1):
            waves[row] = values
        return waves

    return _Waves(
        stack(scene.along_sine, scene.along_cosine),
        stack(scene.across_sine, scene.across_cosine),
        *(np.broadcast_to(x, n) for x in scene[4:]),
    )


def harmonic_state(scene: HarmonicLoads, out: SteadyState, *, classes_alone: bool = False) -> None:
    """Solve the steady cycle from rest at phase 0 of every scene but the hopping ones.

    Parameters
    ----------
    scene : HarmonicLoads
        Groups of the scenes, 1-D, or 0-d where one value serves all.
    out : SteadyState
        1-D arrays that are filled.
    classes_alone : bool
        Whether to find the regimes only: slipping cells then have neither pattern nor numbers.
    """
    n = out.status.size
    waves = _waves(scene, n)
    static = np.concatenate([waves.beyond(waves.static_friction, way) for way in (1, -1)], axis=1)
    both = np.concatenate([static, waves.across], axis=1)
    points = turning_points(both)
    at = values(both, points)
    most = at.max(axis=0)
    noise = FEW_ULP * np.abs(static).sum(axis=0)
    hold, lean = waves.static_friction * waves.normal, waves.tangential
    margins = most[: 2 * n].reshape(2, n)
    noises = noise.reshape(2, n)
    loads = margins + np.array([hold + lean, hold - lean])
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        out.throw_number[:] = most[2 * n :] / waves.normal
        out.forward_ratio[:] = np.maximum(loads[0], 0.0) / (hold + lean)
        out.back_ratio[:] = np.maximum(loads[1], 0.0) / (hold - lean)
    throw = most[2 * n :] - waves.normal
    hops = throw > FEW_ULP * waves.normal
    infeasible = waves.kinetic_friction > waves.static_friction
    unheld = np.abs(lean) >= hold
    exceptional = hops | infeasible | unheld
    slipping = ((margins > noises).any(axis=0) & ~exceptional).nonzero()[0]
    edge = (np.abs(margins) <= noises).any(axis=0) | (np.abs(throw) <= FEW_ULP * waves.normal)

    out.status[:] = edge
    out.pattern.fill(Pattern.R)
    out.model.fill(Model.REST)
    out.regime.fill(Regime.NO_SLIP)
    for array in (out.displacement, out.peak, out.coexists):
        array.fill(0)
    out.coexists[np.abs(lean) > waves.kinetic_friction * waves.normal] = 1
    if slipping.size:
        _slip(out, waves, slipping, static, points, at, noise, classes_alone)
    exceptions = exceptional.nonzero()[0]
    if exceptions.size:
        _except(out, exceptions, waves, hops, infeasible, loads)
    if classes_alone:
        _withdraw(out, ((out.regime == Regime.FORWARD_SLIP) | (out.regime == Regime.BACK_SLIP)).nonzero()[0])


def _slip(
    out: SteadyState,
    waves: _Waves,
    cells: Indices,
    static: Floats,
    points: Floats,
    at: Floats,
    noise: Floats,
    classes_alone: bool,
) -> None:
    """Solve slipping cells."""
    n = out.status.size
    both = np.concatenate([cells, cells + n])
    own = _Waves(
        waves.along[:, cells],
        waves.across[:, cells],
        *(x[cells] for x in waves[2:]),
    )
    kinetic = np.concatenate([own.beyond(own.kinetic_friction, way) for way in (1, -1)], axis=1)
    track = lanes(
        static[:, both],
        kinetic,
        points[:, both],
        at[:, both],
        own.across,
        own.normal,
        noise[both],
        own.static_friction - own.kinetic_friction,
    )
    m = cells.size
    all_cells = np.arange(m)
    begun = stopped(track, all_cells, np.zeros(m), (all_cells, all_cells + m))
    settled = settle(track, all_cells, begun)
    cycles = settled.cycles
    forward = cycles.lane < m
    rows = np.arange(forward.shape[0])[:, np.newaxis]
    own_slides = rows < cycles.count
    out.displacement[cells] = np.where(forward, cycles.path, -cycles.path).sum(axis=0)
    out.peak[cells] = cycles.peak.max(axis=0)
    back = (own_slides & ~forward).any(axis=0)
    back |= settled.endless >= m
    out.regime[cells] = np.where(back, Regime.BACK_SLIP, Regime.FORWARD_SLIP)
    out.pattern[cells] = spelt(cycles, m)
    out.model[cells] = Model.SLIDES
    out.status[cells] |= settled.edge
    if not classes_alone:
        held = (np.abs(own.tangential) <= own.kinetic_friction * own.normal) & (cycles.count > 0)
        out.coexists[cells[held]] = coexisting(track, cycles._replace(count=np.where(held, cycles.count, 0)))[held]
    lost = cells[cycles.count == 0]
    _withdraw(out, lost)
    out.status[lost] = Status.UNRESOLVED
    out.status[cells[settled.endless >= 0]] = Status.RUNAWAY


# Patterns that have a code of their own, by their digits.
_NAMED: Final = {
    Mode.FORWARD * 5 + Mode.REST: Pattern.F_,
    Mode.BACK * 5 + Mode.REST: Pattern.B_,
    ((Mode.FORWARD * 5 + Mode.REST) * 5 + Mode.BACK) * 5 + Mode.REST: Pattern.F_B_,
    (Mode.FORWARD * 5 + Mode.BACK) * 5 + Mode.REST: Pattern.FB_,
    (Mode.FORWARD * 5 + Mode.REST) * 5 + Mode.BACK: Pattern.F_B,
    Mode.FORWARD * 5 + Mode.BACK: Pattern.FB,
}


def spelt(cycles: Cycles, scenes: int) -> NDArray[np.int64]:
    """Codes of the patterns: the rotation whose digits are least, F before B before a rest."""
    rows, n = cycles.lane.shape
    count = np.maximum(cycles.count, 1)
    codes = np.full(n, np.iinfo(np.int64).max)
    columns = np.arange(n)
    for first in range(rows):
        code = np.zeros(n, np.int64)
        for j in range(rows):
            row = (first + j) % count
            way = np.where(cycles.lane[row, columns] < scenes, Mode.FORWARD, Mode.BACK)
            more = code * 5 + way
            more = np.where(cycles.rests[row, columns], more * 5 + Mode.REST, more)
            code = np.where(j < cycles.count, more, code)
        codes = np.minimum(codes, code)
    out = codes + SPELT_PATTERNS
    for digits, pattern in _NAMED.items():
        out[codes == digits] = pattern
    return out


def _withdraw(out: SteadyState, cells: Indices) -> None:
    """Leave cells their regime and status alone."""
    out.pattern[cells] = Pattern.NONE
    out.model[cells] = Model.NONE
    out.coexists[cells] = -1
    for numbers in (out.displacement, out.peak):
        numbers[cells] = np.nan


def _except(
    out: SteadyState, cells: Indices, waves: _Waves, hops: Bools, infeasible: Bools, loads: Floats
) -> None:
    """Give scenes without a steady contact cycle the status that says why."""
    hold = (waves.static_friction * waves.normal)[cells]
    lean = waves.tangential[cells]
    kinds = [infeasible[cells], hops[cells], waves.static_friction[cells] == 0.0]  # the rest is unheld
    status = np.select(
        kinds, [Status.INFEASIBLE, Status.FLIGHT_NOT_MODELLED, Status.INDETERMINATE], Status.RUNAWAY
    )
    downhill = np.where(lean > 0.0, Regime.BACK_SLIP, Regime.FORWARD_SLIP)
    _withdraw(out, cells)
    out.status[cells] = status
    out.regime[cells] = np.select(kinds, [Regime.UNDEFINED, Regime.HOPPING, Regime.UNDEFINED], downhill)
    # Where nothing rests, any load makes it slip.
    for ratio, way, held in ((out.forward_ratio, 0, hold + lean), (out.back_ratio, 1, hold - lean)):
        ratio[cells] = np.where(held > 0.0, ratio[cells], np.where(loads[way, cells] > 0.0, np.inf, 0.0))
    for ratio in (out.throw_number, out.forward_ratio, out.back_ratio):
        ratio[cells[infeasible[cells]]] = np.nan
