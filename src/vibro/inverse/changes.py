"""Loads at which bodies change their regime, for every kind of drive."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Final

import numpy as np

from vibro.core.codes import Regime
from vibro.limits import critical_loads
from vibro.roots import close_in
from vibro.scene import Scene
from vibro.steady import solve

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Floats = NDArray[np.float64]

__all__ = ["begin_load", "change_loads", "slip_load"]

# The field of ``CriticalLoads`` at which each regime begins.
_BEGINS: Final = {
    Regime.FORWARD_SLIP: "forward_onset",
    Regime.BACK_SLIP: "back_slip",
    Regime.HOPPING: "hop",
}
_SCALES: Final = 17  # between the onset of a back slide and the hop, among which the first is looked for
_FAR: Final = 100.0  # [1] times the onset, where the last of these is if no body ever hops
_WIDTH: Final = 1e-7  # [1] to which the load between two of them is found
_SECTIONS: Final = 7  # of a bracket that are looked at in one call
# Fields beside the motion and its scale.
_OTHERS: Final = (
    "normal_acceleration", "frequency", "static_friction", "kinetic_friction", "trough_angle", "gravity",
)  # fmt: skip


def change_loads(scene: Scene) -> dict[str, Floats]:
    """Return loads at which bodies change their regime, by the names of ``CriticalLoads``.

    Of a given motion those that are closed forms: hop and onsets. inf where a change never happens.
    """
    if scene.motion is None:
        return critical_loads(scene)._asdict()
    cycle, load = solve(scene, accuracy="regimes"), scene.load
    ratios = {
        "hop": cycle.throw_number, "forward_onset": cycle.forward_ratio, "back_onset": cycle.back_ratio,
    }  # fmt: skip
    with np.errstate(divide="ignore", invalid="ignore"):
        return {name: np.asarray(load / ratio) for name, ratio in ratios.items()}


def begin_load(scene: Scene, regime: Regime) -> Floats:
    """Return the load at which a regime begins; inf where it never does.

    Of back slip under a given motion the least of 17 loads between its onset and the hop at which it occurs,
    closed in on from below to 1e-7: it may end and begin again, and what lies between two of them may be
    missed.
    """
    if regime is Regime.BACK_SLIP and scene.motion is not None:
        return _back_slip_load(scene)
    return np.asarray(change_loads(scene)[_BEGINS[regime]])


def slip_load(scene: Scene) -> Floats:
    """Return a load below that of the scene if the body slips back, and at least that of the scene if not.

    It is that at which back slip begins. Of a given motion, which may end back slip at higher loads, it is
    the onset of a back slide, but where that is not enough the load of the scene: one steady cycle decides.
    """
    if scene.motion is None:
        return np.asarray(critical_loads(scene).back_slip)
    onset = change_loads(scene)["back_onset"]
    slips = solve(scene, accuracy="regimes").regime >= Regime.BACK_SLIP
    return np.where(slips, onset, np.maximum(onset, scene.load))


def _back_slip_load(scene: Scene) -> Floats:
    """Search the first load between the onset of a back slide and the hop at which there is one."""
    loads = change_loads(scene)
    given: Any = scene.motion_scale
    onset, hop, load, scale = (
        np.asarray(x) for x in np.broadcast_arrays(loads["back_onset"], loads["hop"], scene.load, given)
    )
    found = np.full(onset.shape, np.inf)
    opens = (onset > 0.0) & np.isfinite(onset) & (onset < hop)
    if not opens.any():
        return found
    last = np.minimum(hop, _FAR * onset)[opens]
    others = {
        name: np.broadcast_to(x, found.shape)[opens][:, None]
        for _, name, x in scene.arrays().members()
        if name in _OTHERS
    }
    unit = (scale / load)[opens][:, None]

    def slips(at: Floats) -> Floats:
        fields: dict[str, Any] = {"motion": scene.motion, "motion_scale": unit * at, **others}
        there = Scene.allowing_infeasible(**fields)
        return np.where(solve(there, accuracy="regimes").regime >= Regime.BACK_SLIP, 1.0, -1.0)

    ladder = onset[opens][:, None] * (last / onset[opens])[:, None] ** np.linspace(0.0, 1.0, _SCALES)
    holds = slips(ladder) > 0.0
    first, rows = np.argmax(holds, axis=1), np.arange(len(ladder))
    _, before = close_in(
        slips,
        ladder[rows, first],
        ladder[rows, np.maximum(first - 1, 0)],
        relative=_WIDTH,
        sections=_SECTIONS,
    )
    found[opens] = np.where(holds.any(axis=1), before, np.inf)
    return found
