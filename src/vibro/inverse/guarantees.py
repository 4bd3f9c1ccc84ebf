"""Bounds on speed and regime over a box of bands: ``vibro.guarantee``."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import TYPE_CHECKING, Any, Final, NamedTuple

import numpy as np

from vibro.core.codes import Regime
from vibro.inverse.bands import uncertainty_set
from vibro.inverse.extremes import SEEDS, Extreme, Seen, look_around, sampled, searched, speeds_of, taken
from vibro.inverse.proofs import back_slip_load, is_braked, steeper_is_slower
from vibro.inverse.tolerances import TOLERANCES
from vibro.limits import critical_loads
from vibro.results.designs import Guarantee
from vibro.scene import Scene

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from vibro.inverse.spaces import UncertaintySet

    Floats = NDArray[np.float64]

__all__ = ["Bound", "bound", "guarantee", "guarantee_of"]

_AMPLITUDES: Final = ("amplitude", "along_amplitude", "normal_amplitude")
# Loads at which the speed may jump, and how the report names them.
_JUMPS: Final = {
    "back_slip": "back slip begins",
    "back_onset": "the load for back slip is reached",
    "forward_onset": "forward slip begins",
}


def guarantee(scene: Scene, **bands: Any) -> Guarantee:
    """Return bounds on speed and regime over a box of bands, for bodies that start from rest.

    Parameters
    ----------
    scene : Scene
        One operating point; it gives the values of fields without a band.
    **bands
        Pairs (low, high) by the names of fields, in SI units and radians: ``static_friction``,
        ``kinetic_friction`` or ``friction_ratio``, ``frequency``, ``trough_angle``, and those of the scene's
        drive: ``amplitude``, ``drive_angle``, or ``along_amplitude``, ``normal_amplitude``,
        ``normal_phase``. They need not hold the scene's own value. The box is cut at mu_d <= mu_s.

    Returns
    -------
    Guarantee
        Infimum and supremum of the mean speed (one-sided limits at a jump included), and the regimes.

    Raises
    ------
    SceneError
        If the scene is more than one operating point, or a band is invalid; it lists every problem.
    InputError
        If the drive has harmonics: it lacks ``Ability.FLIGHT``.

    Notes
    -----
    If the drive moves along a line and no body slips back or hops, the speed is monotone, so that both
    bounds lie at corners of the box (``corners``; theory.md, section 14). Otherwise bodies in contact are
    searched by differential evolution from several seeds (``searched``), and hopping ones are sampled
    (``sampled``). The regimes are those of all bodies that were solved. If a body's motion has no short
    period, its mean speed is widened by three standard errors.

    Examples
    --------
    >>> import math, vibro
    >>> scene = vibro.Scene(amplitude=1.195e-3, frequency=15, drive_angle=math.radians(20),
    ...                     static_friction=0.74, kinetic_friction=0.57)
    >>> g = vibro.guarantee(scene, amplitude=(0.99 * 1.195e-3, 1.01 * 1.195e-3))
    >>> print(f"{1e3 * g.speed_min:.4f} to {1e3 * g.speed_max:.4f} mm/s, {g.proof_min}; {g.max_limit}")
    27.0464 to 29.0414 mm/s, searched; from below the load at which back slip begins
    """
    return guarantee_of(uncertainty_set(scene, bands))


def guarantee_of(box: UncertaintySet) -> Guarantee:
    """Return the guarantee over a single box."""
    seen = Seen()
    look_around(box, seen)
    least, most = (bound(box, fast=fast, seen=seen) for fast in (False, True))
    return Guarantee(
        speed_min=least.extreme.speed,
        speed_max=most.extreme.speed,
        min_at=_place(least.extreme.scene),
        max_at=_place(most.extreme.scene),
        min_limit=_limit(least.extreme),
        max_limit=_limit(most.extreme),
        regimes=frozenset(seen.regimes),
        proof_min=least.proof,
        proof_max=most.proof,
        coexists=seen.coexists,
        excluded=seen.excluded,
    )


class Bound(NamedTuple):
    """The slowest or the fastest body of a box, and its proof: a label of ``Guarantee``."""

    extreme: Extreme
    proof: str


def bound(
    box: UncertaintySet, *, fast: bool, seen: Seen, seeds: int = SEEDS, highest: Regime = Regime.HOPPING
) -> Bound:
    """Find the slowest or the fastest body of a single box.

    A body in a higher regime than ``highest`` is slower, or faster, than all others.
    """
    hops = box.may_hop
    if not box.varies.any():
        only = taken(box, np.zeros((len(box.axes), 1)), fast=fast, flight=True, seen=seen, highest=highest)
        return Bound(only, "corners" if box.space.proves else "sampled" if hops else "searched")
    if box.space.proves and not hops and _is_monotone(box):
        return _fastest_forward(box, seen) if fast else Bound(_slowest_forward(box, seen), "corners")
    extreme = searched(box, fast=fast, hops=hops, seen=seen, seeds=seeds, highest=highest)
    if not hops:
        return Bound(extreme, "searched")
    hopping = sampled(box, fast=fast, seen=seen)
    key = (lambda e: -e.speed) if fast else (lambda e: e.speed)
    if math.isnan(hopping.speed):  # no sample has a known speed, so none is guaranteed
        return Bound(replace(hopping, speed=math.inf if fast else -math.inf), "sampled")
    return Bound(hopping if math.isnan(extreme.speed) else min(extreme, hopping, key=key), "sampled")


def _is_monotone(box: UncertaintySet) -> bool:
    """Whether the speed is proved monotone along every band: no body slips back or runs away."""
    slips_forward = float(box.load[1]) <= float(back_slip_load(box))
    return slips_forward and is_braked(box) and steeper_is_slower(box)


def _slowest_forward(box: UncertaintySet, seen: Seen) -> Extreme:
    """Return the slowest body where none slips back: the roughest and least driven, on the steepest trough.

    The speed rises, then falls, with the drive angle: one of its two ends.
    """
    coordinates = np.array([[0.0, 0.0], [0.0, 1.0], [1.0, 1.0], [1.0, 1.0], [1.0, 1.0]])
    found = [taken(box, coordinates[:, [i]], fast=False, flight=False, seen=seen) for i in range(2)]
    return min(found, key=lambda extreme: extreme.speed)


def _fastest_forward(box: UncertaintySet, seen: Seen) -> Bound:
    """Return the fastest body where none slips back; between two drive angles its maximum is searched."""
    coordinates = np.array([[1.0, 1.0], [0.0, 1.0], [0.0, 0.0], [0.0, 0.0], [0.0, 0.0]])
    found = [taken(box, coordinates[:, [i]], fast=True, flight=False, seen=seen) for i in range(2)]
    (low, high), point = box.shape["drive_angle"], box.points(coordinates[:, :1])
    tops = (math.atan(float(mu[0])) for mu in (point.kinetic_friction, point.static_friction))
    first, last = ((min(max(top, low), high) - low) / ((high - low) or 1.0) for top in tops)

    def at(share: float) -> Extreme:
        return taken(box, np.array([[1.0], [share], [0.0], [0.0], [0.0]]), fast=True, flight=False, seen=seen)

    found += [at(first), at(last)]
    best = max(found, key=lambda extreme: extreme.speed)
    if first < last:
        from scipy.optimize import minimize_scalar  # late: it takes a fifth of a second to load

        peak = minimize_scalar(
            lambda u: -at(u).speed, bounds=(first, last), method="bounded", options={"xatol": TOLERANCES.top}
        )
        top = at(float(peak.x))
        if top.speed > best.speed:
            return Bound(top, "searched")
    return Bound(best, "corners")


def _place(scene: Scene) -> dict[str, float]:
    """Return the fields of a scene of one cell."""
    return {name: float(np.ravel(value)[0]) for name, value in scene.arrays()._asdict().items()}


def _limit(extreme: Extreme) -> str:
    """Return the side from which a speed is the limit at a jump; empty where it does not jump."""
    at = _place(extreme.scene)
    load = float(np.ravel(extreme.scene.load)[0])
    known = critical_loads(extreme.scene)
    for name, text in _JUMPS.items():
        critical = float(np.ravel(getattr(known, name))[0])
        if not (math.isfinite(critical) and abs(load - critical) <= TOLERANCES.near * critical):
            continue
        beside = critical / load * (1.0 + TOLERANCES.either_side * np.array([-1.0, 1.0]))
        fields: dict[str, Any] = {**at, **{field: at[field] * beside for field in _AMPLITUDES if field in at}}
        below, above = speeds_of(Scene(**fields), fast=False, flight=False)
        if abs(above - below) > TOLERANCES.jump * max(abs(above), abs(below)):
            is_above = abs(extreme.speed - above) < abs(extreme.speed - below)
            return f"from {'above' if is_above else 'below'} the load at which {text}"
    return ""
