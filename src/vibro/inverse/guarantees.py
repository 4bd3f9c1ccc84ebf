"""Bounds on speed and regime over a box of bands: ``vibro.guarantee``."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import TYPE_CHECKING, Any, Final, NamedTuple

import numpy as np

from vibro.core.codes import Regime
from vibro.inverse.bands import uncertainty_set
from vibro.inverse.bounds import small_speed
from vibro.inverse.changes import change_loads
from vibro.inverse.extremes import (
    Extreme,
    Seen,
    evolved,
    look_around,
    sampled,
    searched,
    speeds_of,
    taken,
)
from vibro.inverse.proofs import back_slip_load, is_braked, steeper_is_slower
from vibro.inverse.tolerances import TOLERANCES
from vibro.reals import shielded
from vibro.results.designs import Guarantee
from vibro.scene import Scene

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from vibro.inverse.spaces import UncertaintySet
    from vibro.results.designs import Certificate

    Floats = NDArray[np.float64]

__all__ = ["BOXES", "BRIEF", "Bound", "bound", "guarantee", "guarantee_of"]

_AMPLITUDES: Final = ("amplitude", "along_amplitude", "normal_amplitude", "motion_scale")
#: Most boxes of a proof that is printed.
BOXES: Final = 8000
#: The same where a slower body alone is sought.
BRIEF: Final = 400
_CLOSE: Final = 1e-2  # [1] largest relative distance of a proved bound from a speed called proved
# Coordinates of the slowest and the fastest body on a line where none slips back: the slowest is the roughest
# and least driven one, on the steepest trough.
_CORNERS: Final = (
    np.array([[0.0], [0.0], [1.0], [1.0], [1.0]]),
    np.array([[1.0], [0.0], [0.0], [0.0], [0.0]]),
)
# Loads at which the speed may jump, and how the report names them.
_JUMPS: Final = {
    "back_slip": "back slip begins",
    "back_onset": "the load for back slip is reached",
    "forward_onset": "forward slip begins",
}


@shielded
def guarantee(scene: Scene, **bands: Any) -> Guarantee:
    """Return bounds on speed and regime over a box of bands, for bodies that start from rest.

    Parameters
    ----------
    scene : Scene
        One operating point, with the values of all quantities that have no band.
    **bands
        Pairs (low, high) by quantity, in SI units and radians: ``static_friction``, ``kinetic_friction`` or
        ``friction_ratio``, ``frequency``, ``trough_angle``, and quantities of the drive: ``amplitude`` and
        ``drive_angle`` of a line; ``along_amplitude``, ``normal_amplitude`` and ``normal_phase`` of an
        ellipse; ``motion_scale`` of another motion. The scene's own value may be outside the band. Points
        with mu_d > mu_s do not count.

    Returns
    -------
    Guarantee
        Infimum and supremum of the mean speed (one-sided limits at a jump included), and the regimes.

    Raises
    ------
    SceneError
        If the scene is more than one operating point, or a band is invalid; the message lists all problems.

    Notes
    -----
    ``Guarantee.proof_min`` and ``proof_max`` say how each bound is known:

    * ``corners``: the drive moves along a line of fixed angle, and no body slides back or hops. The speed is
      then monotone, and the bounds lie at corners of the box (theory, section 14).
    * ``proved``: bodies in contact are searched by differential evolution, and a proved bound, from boxes
      that cover the set, is within 1 % of the result.
    * ``searched``: the same, but 8000 boxes do not bring the proved bound within 1 %; and all motions that
      are neither lines nor ellipses, for which nothing is proved (measurements: :doc:`/guide/design`).
    * ``sampled``: bodies hop; their speeds are those of a sample.

    The regimes are those of all bodies that were computed. The mean speed of irregular motion is widened by
    three standard errors.

    Examples
    --------
    >>> import math, vibro
    >>> scene = vibro.Scene(amplitude=1.195e-3, frequency=15, drive_angle=math.radians(20),
    ...                     static_friction=0.74, kinetic_friction=0.57)
    >>> g = vibro.guarantee(scene, amplitude=(0.99 * 1.195e-3, 1.01 * 1.195e-3))
    >>> print(f"{1e3 * g.speed_min:.4f} to {1e3 * g.speed_max:.4f} mm/s, {g.proof_min}; {g.max_limit}")
    27.0464 to 29.0414 mm/s, proved; from below the load at which back slip begins
    """
    return guarantee_of(uncertainty_set(scene, bands))


def guarantee_of(box: UncertaintySet) -> Guarantee:
    """Return the guarantee over a single box."""
    seen = Seen()
    look_around(box, seen)
    least, most = (bound(box, fast=fast, seen=seen, boxes=BOXES) for fast in (False, True))
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
        proved_min=least.proved,
        proved_max=most.proved,
        certificate_min=least.certificate,
        certificate_max=most.certificate,
        samples=seen.samples,
        coexists=seen.coexists,
        excluded=seen.excluded,
    )


class Bound(NamedTuple):
    """The slowest or the fastest body of a box, and its proof, as ``Guarantee`` describes them."""

    extreme: Extreme
    proof: str
    proved: float
    certificate: Certificate | None = None


def bound(
    box: UncertaintySet, *, fast: bool, seen: Seen, boxes: int, highest: Regime = Regime.HOPPING
) -> Bound:
    """Find the slowest or the fastest body of a single box.

    A body in a higher regime than ``highest`` is slower, or faster, than all others; ``boxes`` is the largest
    number of those of a proof.
    """
    hops = box.may_hop
    if not box.varies.any():
        only = taken(box, np.zeros((len(box.axes), 1)), fast=fast, flight=True, seen=seen, highest=highest)
        return _cornered(only)
    if box.space.proves and not hops and _is_monotone(box):
        return _cornered(taken(box, _CORNERS[fast], fast=fast, flight=False, seen=seen))
    if box.space.is_bounded:
        extreme, certificate = searched(box, fast=fast, boxes=boxes, seen=seen, highest=highest)
    else:
        extreme, certificate = evolved(box, fast=fast, seen=seen, brief=boxes <= BRIEF, highest=highest), None
    if certificate is not None:
        if math.isinf(extreme.speed):  # one body without a speed proves it
            return Bound(extreme, "proved", extreme.speed)
        proved = float(certificate.bound.max() if fast else certificate.bound.min())
        size = max(abs(extreme.speed), small_speed(box))
        is_close = extreme.speed == proved or abs(proved - extreme.speed) <= _CLOSE * size
        return Bound(extreme, "proved" if is_close else "searched", proved, certificate)
    if not hops:
        return Bound(extreme, "searched", math.nan)
    hopping = sampled(box, fast=fast, seen=seen)
    key = (lambda e: -e.speed) if fast else (lambda e: e.speed)
    if math.isnan(hopping.speed):  # no sample has a known speed, so none is guaranteed
        hopping = replace(hopping, speed=math.inf if fast else -math.inf)
    elif not math.isnan(extreme.speed):
        hopping = min(extreme, hopping, key=key)
    return Bound(hopping, "sampled", math.nan)


def _cornered(extreme: Extreme) -> Bound:
    """Return the guarantee of a body at a corner of its box, whose speed is exact."""
    return Bound(extreme, "corners", extreme.speed)


def _is_monotone(box: UncertaintySet) -> bool:
    """Whether the speed is proved monotone along every band: no body slips back or runs away.

    Along the drive angle it is not: there it rises, then falls.
    """
    low, high = box.shape["drive_angle"]
    slips_forward = float(box.load[1]) <= float(back_slip_load(box))
    return bool(low == high) and slips_forward and is_braked(box) and steeper_is_slower(box)


def _place(scene: Scene) -> dict[str, float]:
    """Return the fields of a scene of one cell."""
    members = scene.arrays().members()
    return {name: float(np.ravel(x)[0]) for field, name, x in members if field == name}


def _limit(extreme: Extreme) -> str:
    """Return the side from which a speed is the limit at a jump; empty where it does not jump."""
    at = _place(extreme.scene)
    load = float(np.ravel(extreme.scene.load)[0])
    known = change_loads(extreme.scene)
    motion: Any = {} if extreme.scene.motion is None else {"motion": extreme.scene.motion}
    for name, text in _JUMPS.items():
        critical = float(np.ravel(known.get(name, math.inf))[0])
        if not (math.isfinite(critical) and abs(load - critical) <= TOLERANCES.near * critical):
            continue
        beside = critical / load * (1.0 + TOLERANCES.either_side * np.array([-1.0, 1.0]))
        fields: dict[str, Any] = {
            **motion,
            **at,
            **{field: at[field] * beside for field in _AMPLITUDES if field in at},
        }
        below, above = speeds_of(Scene(**fields), fast=False, flight=False)
        if abs(above - below) > TOLERANCES.jump * max(abs(above), abs(below)):
            is_above = abs(extreme.speed - above) < abs(extreme.speed - below)
            return f"from {'above' if is_above else 'below'} the load at which {text}"
    return ""
