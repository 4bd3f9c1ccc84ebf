"""Steady cycles of whole grids of scenes: the public face of the core."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from vibro.core.codes import MODELS, PATTERNS

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from vibro.scene import Scene

    Floats = NDArray[np.float64]
    Codes = NDArray[np.int8]

__all__ = ["SteadyCycle", "solve"]

_PATTERN_TEXTS = np.array(PATTERNS)
_MODEL_TEXTS = np.array(MODELS)


@dataclass(frozen=True, eq=False)
class SteadyCycle:
    """What the body on the trough does once it has settled, from rest; one value a scene.

    Every attribute has the scene's shape. A cell without an answer holds NaN and a status that says why.

    Attributes
    ----------
    regime, status : int8 array
        Codes of ``Regime`` and ``Status``.
    pattern_code, model_code : int8 array
        Codes behind ``pattern`` and ``model``.
    displacement_per_cycle : float array
        Displacement relative to the trough in one drive cycle, positive in the conveying direction [m].
    mean_velocity : float array
        Mean conveying speed [m/s].
    peak_velocity : float array
        Largest relative speed, either way, >= 0 [m/s].
    throw_number : float array
        K = G sin(alpha) / cos(beta); the body hops above 1 [1].
    forward_ratio, back_ratio : float array
        1/s_f and 1/s_b, the load over the load at which forward and back slip begin [1];
        0 where no load makes the body slip that way.
    coexists : bool array
        Whether a disturbed body can settle into another steady cycle than the one from rest.
    """

    regime: Codes
    status: Codes
    pattern_code: Codes
    model_code: Codes
    displacement_per_cycle: Floats
    mean_velocity: Floats
    peak_velocity: Floats
    throw_number: Floats
    forward_ratio: Floats
    back_ratio: Floats
    coexists: NDArray[np.bool_]

    @property
    def pattern(self) -> Any:
        """Phases of the cycle as text: F forward slide, B back slide, _ rest; empty without a steady cycle."""
        return _PATTERN_TEXTS[self.pattern_code]

    @property
    def model(self) -> Any:
        """The cheapest exact model that gave the answer, as text."""
        return _MODEL_TEXTS[self.model_code]

    def traverse_time(self, length: Any) -> Any:
        """Time to convey over a length at the mean speed.

        Parameters
        ----------
        length : array_like
            Length of the trough, > 0 [m]; broadcasts against the scene.

        Returns
        -------
        array
            ``length / mean_velocity`` [s]; inf where the body does not move forward, NaN where its
            speed is unknown.
        """
        raise AssertionError


def solve(scene: Scene) -> SteadyCycle:
    """Steady cycle from rest of every scene."""
    raise AssertionError
