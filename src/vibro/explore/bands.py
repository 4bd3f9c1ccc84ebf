"""What holds for all bodies while their friction is known as bands alone."""

from __future__ import annotations

from typing import TYPE_CHECKING

from vibro.core.codes import Regime
from vibro.inverse.certain import Certain, certain
from vibro.sweeps.one_scene import number

if TYPE_CHECKING:
    from vibro.explore.state import State
    from vibro.scene import Scene

__all__ = ["certain_of", "guaranteed_text"]


def certain_of(state: State, scene: Scene) -> Certain | None:
    """Find what is certain at every operating point of a scene; nothing without bands."""
    if not state.bands:
        return None
    static, second = (
        state.bands.get(name, (state.point.fixed[name],) * 2)
        for name in ("static_friction", "kinetic_friction")
    )
    is_ratio = state.follows and "kinetic_friction" not in state.bands
    if is_ratio:
        second = (state.friction_ratio,) * 2
    return certain(scene, static_friction=static, second_friction=second, is_ratio=is_ratio)


def guaranteed_text(state: State) -> str:
    """Say what is certain at the operating point; nothing without bands."""
    found = certain_of(state, state.point.scene())
    if found is None:
        return ""
    lowest, highest = (Regime(int(code)) for code in (found.lowest, found.highest))
    regimes = lowest.label if lowest is highest else f"from {lowest.label or 'no regime'} to {highest.label}"
    speed = 1e3 * float(found.speed_min)
    least = f"at least {number(speed, 'mm/s')}" if speed == speed else "no least speed is proved"
    return f"{regimes}, {least}"
