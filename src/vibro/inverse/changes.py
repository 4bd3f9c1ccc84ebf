"""Loads at which bodies change their regime, for every kind of drive."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np

from vibro.core.codes import Regime
from vibro.limits import critical_loads
from vibro.steady import solve

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from vibro.scene import Scene

    Floats = NDArray[np.float64]

__all__ = ["begin_load", "change_loads", "slip_load"]

# The field of ``CriticalLoads`` at which each regime begins.
_BEGINS: Final = {
    Regime.FORWARD_SLIP: "forward_onset",
    Regime.BACK_SLIP: "back_slip",
    Regime.HOPPING: "hop",
}


def change_loads(scene: Scene) -> dict[str, Floats]:
    """Return loads at which bodies change their regime, by the names of ``CriticalLoads``.

    Of a given motion those that are closed forms: hop and onsets. inf where a change never happens.
    """
    if scene.motion is None:
        return critical_loads(scene)._asdict()
    cycle, load = solve(scene, output="regimes"), scene.load
    ratios = {
        "hop": cycle.throw_number, "forward_onset": cycle.forward_ratio, "back_onset": cycle.back_ratio,
    }  # fmt: skip
    with np.errstate(divide="ignore", invalid="ignore"):
        return {name: np.asarray(load / ratio) for name, ratio in ratios.items()}


def begin_load(scene: Scene, regime: Regime) -> Floats:
    """Return the load at which a regime begins; inf where it never does.

    Of back slip under a given motion, which may end and begin again, the least load that ``critical_loads``
    finds.
    """
    if regime is Regime.BACK_SLIP:
        return np.asarray(critical_loads(scene).back_slip)
    return np.asarray(change_loads(scene)[_BEGINS[regime]])


def slip_load(scene: Scene) -> Floats:
    """Return a load below that of the scene if the body slips back, and at least that of the scene if not.

    It is that at which back slip begins. Of a given motion, which may end back slip at higher loads, it is
    the onset of a back slide, but where that is not enough the load of the scene: one steady cycle decides.
    """
    if scene.motion is None:
        return np.asarray(critical_loads(scene).back_slip)
    onset = change_loads(scene)["back_onset"]
    slips = solve(scene, output="regimes").regime >= Regime.BACK_SLIP
    return np.where(slips, onset, np.maximum(onset, scene.load))
