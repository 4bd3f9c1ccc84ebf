"""What holds for all bodies while their friction is known as bands alone."""

from __future__ import annotations

from typing import TYPE_CHECKING

from vibro.core.codes import Regime
from vibro.inverse.certain import Certain, certain
from vibro.sweeps.one_scene import number

if TYPE_CHECKING:
    from vibro.explore.state import State
    from vibro.inverse.specs import Span
    from vibro.scene import Scene

__all__ = ["certain_of", "extreme_frictions", "guaranteed_text", "is_outside"]


def certain_of(state: State, scene: Scene) -> Certain | None:
    """Find what is certain at every operating point of a scene; nothing without bands."""
    if not state.bands:
        return None
    static, second, is_ratio = _box(state)
    return certain(scene, static_friction=static, second_friction=second, is_ratio=is_ratio)


def extreme_frictions(state: State) -> dict[str, tuple[float, float]]:
    """Return static and kinetic friction of the bodies of the bands that slip first and last.

    Of least static friction it is the one of most kinetic friction, of most static the one of least: on level
    and climbing troughs these are also the first and the last to slip back.
    """
    static, second, is_ratio = _box(state)
    low, high = static if is_ratio else (max(static[0], second[0]), static[1])
    kinetic = [mu_s * end if is_ratio else end for mu_s, end in ((low, second[1]), (high, second[0]))]
    return {"least": (low, min(low, kinetic[0])), "most": (high, min(high, kinetic[1]))}


def _box(state: State) -> tuple[Span, Span, bool]:
    """Return the bands of static and of kinetic friction, or of its ratio, and whether it is that."""
    static, second = (
        state.bands.get(name, (state.point.fixed[name],) * 2)
        for name in ("static_friction", "kinetic_friction")
    )
    if "friction_ratio" in state.bands:
        return static, state.bands["friction_ratio"], True
    is_ratio = state.follows and "kinetic_friction" not in state.bands
    return static, (state.friction_ratio,) * 2 if is_ratio else second, is_ratio


def is_outside(state: State) -> bool:
    """Whether the operating point's own friction lies outside of the bands."""
    own = {**state.point.fixed, "friction_ratio": state.friction_ratio}
    return any(not low <= own[name] <= high for name, (low, high) in state.bands.items())


def guaranteed_text(state: State) -> str:
    """Say what is certain at the operating point; nothing without bands."""
    found = certain_of(state, state.point.scene())
    if found is None:
        return ""
    lowest, highest = (Regime(int(code)) for code in (found.lowest, found.highest))
    regimes = lowest.label if lowest is highest else f"from {lowest.label or 'no regime'} to {highest.label}"
    speed = 1e3 * float(found.speed_min)
    least = (
        f"at least {number(speed, 'mm/s')}"
        if speed == speed
        else "no least speed is proved (vibro.guarantee searches for it)"
    )
    return f"{regimes}, {least}"
