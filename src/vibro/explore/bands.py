"""Guarantees for all bodies if friction is known as bands only."""

from __future__ import annotations

import math
from functools import lru_cache
from typing import TYPE_CHECKING, Final

from vibro.answers.answer import number
from vibro.core.codes import Regime
from vibro.designs.guarantees import Certain, certain, guarantee
from vibro.quantities import MACHINE, scene_fields
from vibro.scene import Scene
from vibro.units import LENGTH

if TYPE_CHECKING:
    from vibro.designs.spaces import Span
    from vibro.explore.state import State

__all__ = [
    "bands_if",
    "box_of",
    "certain_of",
    "extreme_frictions",
    "guaranteed_text",
    "is_outside",
    "searched_text",
]

_KEPT: Final = 64  # searches, a second each: a change of the view asks again


def certain_of(state: State, scene: Scene) -> Certain | None:
    """Find the guarantees at every operating point of a scene; None without bands."""
    if not state.bands:
        return None
    static, second, is_ratio = box_of(state)
    return certain(scene, static_friction=static, second_friction=second, is_ratio=is_ratio)


def bands_if(state: State, *, follows: bool) -> dict[str, str]:
    """Return the bands, by keys, of this state if kinetic friction follows static friction, or does not.

    Where it follows, a band of the ratio replaces that of kinetic friction. New bands reach a tenth to either
    side.
    """
    mu_s, mu_d = state.point.fixed["static_friction"], state.point.fixed["kinetic_friction"]
    bands = {**state.bands} or {"static_friction": _scaled((0.9, 1.1), mu_s)}
    own, ratio = bands.pop("kinetic_friction", None), bands.pop("friction_ratio", None)
    if not follows:
        own = _scaled(ratio, mu_s) if ratio else own
        bands["kinetic_friction"] = own or _scaled((0.9, 1.1), mu_d)
    elif own and mu_s:
        low, high = _scaled(own, 1.0 / mu_s)
        ratio = min(low, 1.0), min(high, 1.0)
    if follows and ratio:
        bands["friction_ratio"] = ratio
    return {f"{name}_band": ":".join(f"{end:.4g}" for end in band) for name, band in bands.items()}


def _scaled(band: Span, factor: float) -> Span:
    low, high = band
    return low * factor, high * factor


def extreme_frictions(state: State) -> dict[str, tuple[float, float]]:
    """Return static and kinetic friction of the bodies of the bands that slip first and last.

    These have least static and most kinetic friction, and most static and least kinetic friction: on level
    and climbing troughs they are also the first and the last to slip back.
    """
    static, second, is_ratio = box_of(state)
    low, high = static if is_ratio else (max(static[0], second[0]), static[1])
    kinetic = [mu_s * end if is_ratio else end for mu_s, end in ((low, second[1]), (high, second[0]))]
    return {"least": (low, min(low, kinetic[0])), "most": (high, min(high, kinetic[1]))}


def box_of(state: State) -> tuple[Span, Span, bool]:
    """Return the bands of static friction and of kinetic friction or its ratio, and whether it is a ratio."""
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


def guaranteed_text(state: State) -> tuple[str, bool]:
    """Describe the proved bounds at the operating point, empty without bands; and whether none was proved."""
    found = certain_of(state, state.point.scene())
    if found is None:
        return "", False
    speed = 1e3 * float(found.speed_min)
    is_open = math.isnan(speed)
    least = "least speed not proved here" if is_open else f"at least {number(speed, 'mm/s')}"
    return f"{_regimes(found)}, {least}", is_open


def searched_text(state: State) -> str:
    """Search for the guaranteed speeds at the operating point, and describe them; takes up to seconds."""
    static, second, is_ratio = box_of(state)
    scene = state.point.scene()
    found = certain_of(state, scene)
    regimes = [] if found is None else [_regimes(found)]
    fixed = {name: value for name, value in state.point.fixed.items() if name not in MACHINE}
    if state.point.machine is not None:
        fixed["amplitude"] = LENGTH.from_si(scene.amplitude)
    return ", ".join([*regimes, _searched(tuple(fixed.items()), static, second, is_ratio)])


def _regimes(found: Certain) -> str:
    lowest, highest = (Regime(int(code)) for code in (found.lowest, found.highest))
    return lowest.label if lowest is highest else f"from {lowest.label or 'no regime'} to {highest.label}"


@lru_cache(_KEPT)
def _searched(fixed: tuple[tuple[str, float], ...], static: Span, second: Span, is_ratio: bool) -> str:
    ratio_or_own = {"friction_ratio" if is_ratio else "kinetic_friction": second}
    found = guarantee(Scene(**scene_fields(dict(fixed))), static_friction=static, **ratio_or_own)
    said = []
    for end, speed, proof, proved in (
        ("least", found.speed_min, found.proof_min, found.proved_min),
        ("most", found.speed_max, found.proof_max, found.proved_max),
    ):
        speed = proved if proof == "proved" else speed
        also = f"; {number(1e3 * proved)} proved" if proof == "searched" and math.isfinite(proved) else ""
        if math.isfinite(speed):
            said.append(f"at {end} {number(1e3 * speed, 'mm/s')} ({proof}{also})")
    if len(said) < 2:
        said.append("a body runs away or has no steady motion")
    if found.excluded:
        said.append(f"{found.excluded} bodies of unknown speed left out")
    return ", ".join(said)
