"""Thresholds of slip, hop and rest in closed form, and the class that they alone decide."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final, NamedTuple

import numpy as np

from vibro.core.contact.windows import static_lifts

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from vibro.core.contact.slide import Floats
    from vibro.core.groups import Loads

    Bools = NDArray[np.bool_]

__all__ = ["FEW_ULP", "Margins", "Thresholds", "thresholds"]

# [1] Relative distance to a threshold below which rounding of the inputs decides the side: f^2, g and the
# angles bring about four roundings into G.
FEW_ULP: Final = 4 * 2.0**-52


class Margins(NamedTuple):
    """Distance of a body at rest from slipping.

    Attributes
    ----------
    forward, back : array
        (1 - s_f) C_f and (1 - s_b) C_b, sharing their rounding: > 0 where the load exceeds static friction
        that way, Eqs. (5) and (55).
    forward_load, back_load : array
        C_f and C_b: a + mu_s b and a - mu_s b of drives along a line.
    """

    forward: Floats
    back: Floats
    forward_load: Floats
    back_load: Floats


class Thresholds(NamedTuple):
    """Where the scenes stand beside the closed-form thresholds; arrays of the scenes' shape.

    Attributes
    ----------
    margins : Margins
        Distances from slipping.
    forward, back : bool array
        Whether slip begins that way, by more than rounding.
    hops : bool array
        Whether the throw number exceeds 1, by more than rounding.
    unheld : bool array
        Whether the trough is so steep that static friction cannot hold a body.
    edge : bool array
        Whether rounding decides one of the above.
    """

    margins: Margins
    forward: Bools
    back: Bools
    hops: Bools
    unheld: Bools
    edge: Bools


def thresholds(scene: Loads) -> Thresholds:
    """Compare each load with its threshold; equality is rest, and contact."""
    # A friction that overflows holds everything: no comparison with inf or NaN says that a slide begins.
    with np.errstate(over="ignore", invalid="ignore"):
        hold = scene.static_friction * scene.normal
        ahead, behind = static_lifts(scene)
        slack = scene.along - hold
        forward_margin = slack + (ahead - scene.tangential)
        back_margin = slack + (behind + scene.tangential)
        forward_load = scene.along + ahead
        back_load = scene.along + behind
        noise = FEW_ULP * (forward_load + hold + np.abs(scene.tangential))
        can_slip_back = back_load > 0.0
        throw = scene.across - scene.normal
        throw_noise = FEW_ULP * scene.normal
        edge = (np.abs(forward_margin) <= noise) | (np.abs(throw) <= throw_noise)
        edge |= can_slip_back & (np.abs(back_margin) <= noise)
        if scene.lead and np.count_nonzero(scene.tangential):
            edge |= np.abs(np.abs(scene.tangential) - hold) <= FEW_ULP * hold
    return Thresholds(
        Margins(forward_margin, back_margin, forward_load, back_load),
        forward=forward_margin > noise,
        back=can_slip_back & (back_margin > noise),
        hops=throw > throw_noise,
        unheld=np.abs(scene.tangential) >= hold,
        edge=edge,
    )
