"""Regimes and speeds that hold for every body within bands of friction, over a map of operating points."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final, NamedTuple

import numpy as np

from vibro.core.codes import Regime
from vibro.drives import Ability, Line
from vibro.inverse.bands import uncertainty_set
from vibro.inverse.tolerances import TOLERANCES
from vibro.limits import back_slip_of
from vibro.scene import Scene
from vibro.steady import solve

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from vibro.inverse.spaces import UncertaintySet
    from vibro.inverse.specs import Span

    Bools = NDArray[np.bool_]
    Codes = NDArray[np.int8]
    Floats = NDArray[np.float64]

__all__ = ["Certain", "certain"]

# Bisections of a band of static friction on declines; each halves the interval that stays undecided.
_HALVINGS: Final = 12

# Any operating point will do: ``uncertainty_set`` needs a scene to check the bands of friction.
_ANY: Final = {"amplitude": 1e-3, "frequency": 50.0, "drive_angle": 0.3}


class Certain(NamedTuple):
    """Bounds that hold for every body of a box of frictions, at every operating point.

    Attributes
    ----------
    lowest, highest : int8 array
        Codes of ``Regime`` that bound the regimes of all bodies. ``lowest`` is -1 if the box holds bodies
        without friction, which have no regime.
    speed_min : array
        Lower bound of the mean speeds of all bodies [m/s]; NaN where none is proved.
    """

    lowest: Codes
    highest: Codes
    speed_min: Floats


def certain(scene: Scene, *, static_friction: Span, second_friction: Span, is_ratio: bool) -> Certain:
    """Return bounds on regime and speed for friction known as a band, at every operating point.

    They hold for bodies that start from rest on a drive along a line.

    Parameters
    ----------
    scene : Scene
        Operating points of any shape; their own frictions are ignored.
    static_friction : pair of float
        Smallest and largest static friction [1].
    second_friction : pair of float
        Smallest and largest kinetic friction, or ratio of it to static friction [1]. The box is cut at
        mu_d <= mu_s.
    is_ratio : bool
        Whether ``second_friction`` is a ratio.

    Returns
    -------
    Certain
        Arrays of the shape of the operating points.

    Raises
    ------
    SceneError
        If a band is invalid; it lists every problem.
    InputError
        If the drive does not move along a line (``Ability.PROOF``).

    Notes
    -----
    The bounds are regimes of ``vibro.solve`` at corners of the box, equality at thresholds included. Every
    body stays within them, except where its friction equals that of a corner up to the last digits and
    rounding puts the two on different sides of a threshold. Where the bounds differ, both regimes occur, with
    two exceptions. First, on declines where the largest or the least kinetic friction changes with static
    friction (a ratio, or the cut), the first or the last body to slip back may lie between corners: that edge
    of the box is bisected until all its parts are proved, and a narrow interval at the threshold stays
    undecided (tests/inverse/test_certain.py counts its cells). Second, if the box holds bodies without static
    friction, ``lowest`` is -1 and ``highest`` back slip, where they do not hop.

    ``speed_min`` is the speed of the body with the highest friction, where no body slips back and kinetic
    friction exceeds the weight component down the trough for all (theory, section 14), or where all rest.
    For a single body it is the body's own speed. It is NaN where bodies may slip back or hop.

    Why corners: both onsets, Eq. (5), rise with mu_s. Of its speed over A w a forward slide keeps
    cos p - cos q - k (q - p) until the back window closes, where sin p = s_f and sin q = -s_b, Eq. (17). That
    falls with k, and so with mu_d. With mu_s it rises by (s_b + k) s_b'/cos q - (s_f - k) s_f'/cos p, which
    is positive for 0 <= k and s_f < s_b; elsewhere the slide lasts always, or never. At a given ratio r of
    frictions the sign of Eq. (22) over kappa follows (S_b^2 - S_f^2)/kappa; with T = tan(beta) and
    t = tan(alpha) that goes as mu_s (mu_s^2 t - T) (1 + r mu_s t) / ((r mu_s + T) (1 - mu_s^2 t^2)^2), which
    rises with mu_s for T >= 0.

    Examples
    --------
    >>> import math, vibro
    >>> line = vibro.Scene(amplitude=[0.6e-3, 0.7e-3, 0.9e-3, 1.1e-3, 1.4e-3, 4e-3], frequency=15,
    ...                    drive_angle=math.radians(20), static_friction=0.74, kinetic_friction=0.57)
    >>> found = certain(line, static_friction=(0.65, 0.8), second_friction=(0.5, 0.6), is_ratio=False)
    >>> found.lowest.tolist(), found.highest.tolist()
    ([0, 0, 1, 1, 2, 3], [0, 1, 1, 2, 2, 3])
    """
    hint = "vibro.guarantee bounds the speed of one operating point of any drive"
    scene.arrays().require(Ability.PROOF, hint=hint)
    second = "friction_ratio" if is_ratio else "kinetic_friction"
    bands = {"static_friction": static_friction, second: second_friction}
    box = uncertainty_set(Scene(**_ANY, static_friction=1.0, kinetic_friction=0.0), bands)
    low, high = (np.asarray(end) for end in box.static_span)
    least, most = box.kinetic_span(low), box.kinetic_span(high)

    roughest = solve(_bodies(scene, high, most[1]), flight=False)
    lowest = np.asarray(roughest.regime) if most[0] == most[1] else _regimes(scene, high, most[0])
    highest = _regimes(scene, low, least[1])
    if low == 0.0 < high:
        lost = (highest == Regime.UNDEFINED) & (lowest >= 0)
        lowest = np.where(lost, np.int8(Regime.UNDEFINED), lowest)
        highest = np.where(lost, np.int8(Regime.BACK_SLIP), highest)
    if least[0] < most[0]:  # all bodies may have more kinetic friction than the one that was solved
        _settle(scene, lowest, box, was=Regime.BACK_SLIP, otherwise=Regime.FORWARD_SLIP)
    if least[1] < most[1]:
        _settle(scene, highest, box, was=Regime.FORWARD_SLIP, otherwise=Regime.BACK_SLIP)

    speed = np.asarray(roughest.mean_velocity)
    if low < high or least[0] < most[1]:
        lean = np.sin(scene.trough_angle)
        braked = least[0] * np.cos(scene.trough_angle) + lean >= TOLERANCES.braked * np.abs(lean)
        proved = (highest == Regime.NO_SLIP) | ((highest == Regime.FORWARD_SLIP) & braked)
        speed = np.where(proved, speed, np.nan)
    return Certain(lowest, highest, speed)


def _bodies(scene: Scene, static_friction: Floats, kinetic_friction: Floats) -> Scene:
    """Return the operating points with the frictions of one body."""
    fields = scene.arrays()._asdict()
    fields.update(static_friction=static_friction, kinetic_friction=kinetic_friction)
    return Scene.allowing_infeasible(**fields)


def _regimes(scene: Scene, static_friction: Floats, kinetic_friction: Floats) -> Codes:
    return np.asarray(solve(_bodies(scene, static_friction, kinetic_friction), output="regimes").regime)


def _settle(scene: Scene, codes: Codes, box: UncertaintySet, *, was: Regime, otherwise: Regime) -> None:
    """Replace a bound, in place, on declines for which it is not proved for all bodies.

    A body slips back at a lower load the lower its static and the higher its kinetic friction. So each part
    of the band of static friction is proved by a body that bounds it, refuted by the body in its middle, and
    bisected if neither decides.
    """
    slips_back = was is Regime.BACK_SLIP
    last = 0 if slips_back else 1  # the end of kinetic friction
    cells = np.flatnonzero((scene.trough_angle < 0.0) & (codes == was))
    points = [np.asarray(x).take(cells) for x in _bodies(scene, *(np.zeros(()),) * 2).flat()]
    which = np.arange(cells.size)  # the cells of all open parts
    start, end = (np.full(cells.size, value) for value in box.static_span)
    fails = np.zeros(cells.size, np.bool_)
    for _ in range(_HALVINGS):
        if not which.size:
            break
        part = Line(*(x.take(which) for x in points))
        near, far = (end, start) if slips_back else (start, end)
        proved = _slips_back(part, near, box.kinetic_span(far)[last]) == slips_back
        middle = 0.5 * (start + end)
        fails[which[_slips_back(part, middle, box.kinetic_span(middle)[last]) != slips_back]] = True
        left = ~(proved | fails[which])
        which, start, middle, end = (np.tile(x[left], 2) for x in (which, start, middle, end))
        half = which.size // 2
        start[half:], end[:half] = middle[half:], middle[:half]
    fails[which] = True
    codes.reshape(-1)[cells[fails]] = otherwise


def _slips_back(fields: Line, static_friction: Floats, kinetic_friction: Floats) -> Bools:
    """Return whether bodies on a decline slip back, by Eqs. (5) and (17).

    A body that static friction cannot hold at rest runs away forward. So does one that it just holds and that
    kinetic friction does not slow down, so the former is replaced by the latter.
    """
    held = np.maximum(static_friction, np.abs(np.tan(fields.trough_angle)))
    return back_slip_of(fields._replace(static_friction=held, kinetic_friction=kinetic_friction))
