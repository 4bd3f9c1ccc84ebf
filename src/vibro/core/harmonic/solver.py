"""The whole steady solve of a block of scenes with harmonics."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from vibro.core.codes import Model, Pattern, Regime, Status
from vibro.core.harmonic.arrays import FEW_ULP
from vibro.core.harmonic.coexistence import coexisting
from vibro.core.harmonic.cycle import stopped
from vibro.core.harmonic.patterns import spelt
from vibro.core.harmonic.settling import settle
from vibro.core.harmonic.slides import lanes
from vibro.core.harmonic.waves import turning_points, values

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from vibro.core.harmonic.loads import HarmonicLoads
    from vibro.core.harmonic.settling import Settled
    from vibro.core.harmonic.slides import Lanes

    Floats = NDArray[np.float64]
    Bools = NDArray[np.bool_]
    Codes = NDArray[np.int8]
    Indices = NDArray[np.intp]

__all__ = ["SteadyState", "from_rest", "harmonic_state", "lanes_of", "scenes_of"]


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


class Scenes(NamedTuple):
    """Scenes, 1-D, as waves: arrays of shape (2 H + 1, scenes), and their thresholds.

    Attributes
    ----------
    along, across : array
        Loads along the trough and off it.
    normal, tangential, static_friction, kinetic_friction : array
        As in ``HarmonicLoads``.
    static : array
        Loads beyond static friction, forward and, in as many more columns, back.
    points, at : array
        Turning points of these, and their values there.
    noise : array
        What rounding may make of zero in ``static``.
    most, throw : array
        Largest load of a body at rest each way, of shape (2, scenes), and off the trough.
    """

    along: Floats
    across: Floats
    normal: Floats
    tangential: Floats
    static_friction: Floats
    kinetic_friction: Floats
    static: Floats
    points: Floats
    at: Floats
    noise: Floats
    most: Floats
    throw: Floats

    @property
    def exceptional(self) -> Bools:
        """Whether there is no steady contact cycle: hopping, infeasible, or steeper than static friction."""
        infeasible = self.kinetic_friction > self.static_friction
        unheld = np.abs(self.tangential) >= self.static_friction * self.normal
        return np.asarray(self.hops | infeasible | unheld)

    @property
    def hops(self) -> Bools:
        """Whether the throw number exceeds 1, by more than rounding."""
        return np.asarray(self.throw - self.normal > FEW_ULP * self.normal)

    @property
    def slips(self) -> Bools:
        """Whether slip begins either way, by more than rounding."""
        n = self.normal.size
        margins = self.at.max(axis=0).reshape(2, n)
        return np.asarray((margins > self.noise.reshape(2, n)).any(axis=0) & ~self.exceptional)

    @property
    def edge(self) -> Bools:
        """Whether rounding decides one of these."""
        n = self.normal.size
        margins = np.abs(self.at.max(axis=0)).reshape(2, n)
        throw = np.abs(self.throw - self.normal) <= FEW_ULP * self.normal
        return np.asarray((margins <= self.noise.reshape(2, n)).any(axis=0) | throw)


def scenes_of(loads: HarmonicLoads, n: int) -> Scenes:
    """Form the waves of n scenes and their thresholds."""

    def stack(sines: tuple[Floats, ...], cosines: tuple[Floats, ...]) -> Floats:
        waves = np.zeros((1 + 2 * len(sines), n))
        for row, part in enumerate((*sines, *cosines), 1):
            waves[row] = part
        return waves

    along = stack(loads.along_sine, loads.along_cosine)
    across = stack(loads.across_sine, loads.across_cosine)
    normal, tangential, mu_s, mu_d = (np.broadcast_to(x, n) for x in loads[4:])
    resting = np.concatenate([along + mu_s * across, mu_s * across - along, across], axis=1)
    points = turning_points(resting)
    at = values(resting, points)
    most = at.max(axis=0).reshape(3, n)
    static = resting[:, : 2 * n]
    static[0] = -np.concatenate([mu_s * normal + tangential, mu_s * normal - tangential])
    noise = FEW_ULP * np.abs(static).sum(axis=0)
    return Scenes(
        along, across, normal, tangential, mu_s, mu_d, static, points[:, : 2 * n], at[:, : 2 * n] + static[0],
        noise, most[:2], most[2],
    )  # fmt: skip


def lanes_of(scenes: Scenes, cells: Indices) -> Lanes:
    """Prepare some scenes for slides."""
    both = np.concatenate([cells, cells + scenes.normal.size])
    along, across = (x.take(cells, axis=1) for x in (scenes.along, scenes.across))
    normal, lean, mu_s, mu_d = (x[cells] for x in scenes[2:6])
    kinetic = np.concatenate([along + mu_d * across, mu_d * across - along], axis=1)
    kinetic[0] = -np.concatenate([mu_d * normal + lean, mu_d * normal - lean])
    static, points, at, noise = (x.take(both, axis=-1) for x in scenes[6:10])
    return lanes(static, kinetic, points, at, across, normal, noise, mu_s - mu_d)


def from_rest(at: Lanes) -> Settled:
    """Cycles that bodies at rest at phase 0 settle into."""
    n = at.noise.size // 2
    cells = np.arange(n)
    return settle(at, cells, stopped(at, cells, np.zeros(n), (cells, cells + n)))


def harmonic_state(scene: HarmonicLoads, out: SteadyState, *, classes_alone: bool = False) -> None:
    """Solve the steady cycle from rest at phase 0 of every scene but the hopping ones.

    Parameters
    ----------
    scene : HarmonicLoads
        Groups of the scenes, 1-D, or 0-d where one value serves all.
    out : SteadyState
        1-D arrays that are filled: lengths over the scene's scale A, speeds over A w.
    classes_alone : bool
        Whether to find the regimes only: slipping cells then have neither pattern nor numbers.
    """
    scenes = scenes_of(scene, out.status.size)
    hold, lean = scenes.static_friction * scenes.normal, scenes.tangential
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        out.throw_number[:] = scenes.throw / scenes.normal
        out.forward_ratio[:] = scenes.most[0] / (hold + lean)
        out.back_ratio[:] = scenes.most[1] / (hold - lean)
    out.status[:] = scenes.edge
    out.pattern.fill(Pattern.R)
    out.model.fill(Model.REST)
    out.regime.fill(Regime.NO_SLIP)
    for array in (out.displacement, out.peak, out.coexists):
        array.fill(0)
    slipping = scenes.slips.nonzero()[0]
    if slipping.size:
        _slip(out, slipping, lanes_of(scenes, slipping), classes_alone)
    # Where gravity along the trough exceeds kinetic friction a pushed body may slide on for ever.
    loose = np.abs(lean) > scenes.kinetic_friction * scenes.normal
    out.coexists[loose & (out.coexists >= 0)] = 1
    exceptions = scenes.exceptional.nonzero()[0]
    if exceptions.size:
        _except(out, exceptions, scenes)
    if classes_alone:
        _withdraw(out, ((out.regime == Regime.FORWARD_SLIP) | (out.regime == Regime.BACK_SLIP)).nonzero()[0])


def _slip(out: SteadyState, cells: Indices, at: Lanes, classes_alone: bool) -> None:
    """Solve slipping cells."""
    n = cells.size
    cycles, endless, edge = from_rest(at)
    back = cycles.lane >= n
    out.displacement[cells] = np.where(back, -cycles.path, cycles.path).sum(axis=0)
    out.peak[cells] = cycles.peak.max(axis=0)
    slides_back = (back & (np.arange(back.shape[0])[:, np.newaxis] < cycles.size)).any(axis=0)
    out.regime[cells] = np.where(slides_back | (endless >= n), Regime.BACK_SLIP, Regime.FORWARD_SLIP)
    out.pattern[cells], _ = spelt(cycles, n)
    out.model[cells] = Model.SLIDES
    out.status[cells] |= edge
    if not classes_alone:
        held = (at.kinetic[0] <= 0.0).reshape(2, n).all(axis=0)
        out.coexists[cells] = coexisting(at, cycles._replace(size=np.where(held, cycles.size, 0)))
    lost = cells[cycles.size == 0]
    _withdraw(out, lost)
    out.status[lost] = Status.UNRESOLVED
    runs = cells[endless >= 0]
    out.status[runs] = Status.RUNAWAY
    out.regime[lost[out.status[lost] == Status.UNRESOLVED]] = Regime.UNDEFINED


def _withdraw(out: SteadyState, cells: Indices) -> None:
    """Leave cells their regime and status alone."""
    out.pattern[cells] = Pattern.NONE
    out.model[cells] = Model.NONE
    out.coexists[cells] = -1
    for numbers in (out.displacement, out.peak):
        numbers[cells] = np.nan


def _except(out: SteadyState, cells: Indices, scenes: Scenes) -> None:
    """Give scenes without a steady contact cycle the status that says why."""
    hold, lean = (scenes.static_friction * scenes.normal)[cells], scenes.tangential[cells]
    infeasible = (scenes.kinetic_friction > scenes.static_friction)[cells]
    kinds = [infeasible, scenes.hops[cells], scenes.static_friction[cells] == 0.0]  # the rest is unheld
    status = np.select(
        kinds, [Status.INFEASIBLE, Status.FLIGHT_NOT_MODELLED, Status.INDETERMINATE], Status.RUNAWAY
    )
    downhill = np.where(lean > 0.0, Regime.BACK_SLIP, Regime.FORWARD_SLIP)
    _withdraw(out, cells)
    out.status[cells] = status
    out.regime[cells] = np.select(kinds, [Regime.UNDEFINED, Regime.HOPPING, Regime.UNDEFINED], downhill)
    # Where nothing rests, any load makes it slip.
    for ratio, way, held in ((out.forward_ratio, 0, hold + lean), (out.back_ratio, 1, hold - lean)):
        free = np.where(scenes.most[way, cells] > 0.0, np.inf, 0.0)
        ratio[cells] = np.where(held > 0.0, ratio[cells], free)
    for ratio in (out.throw_number, out.forward_ratio, out.back_ratio):
        ratio[cells[infeasible]] = np.nan
