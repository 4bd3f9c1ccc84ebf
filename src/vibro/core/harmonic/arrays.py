"""What the scenes with harmonics share: nested tuples of arrays, and series without cancellation."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Final, NamedTuple

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import NDArray

    Floats = NDArray[np.float64]

__all__ = ["FEW_ULP", "GAP", "CycleLeg", "R", "each", "largest_amplitude", "polynomial", "until"]

FEW_ULP: Final = 4 * 2.0**-52  # [1] relative distance to a threshold that rounding decides

# Of s - sin s = s^3 GAP(s^2) for s <= 1, and sin x - x cos x = x^3 R(x^2) for x <= pi, highest power first.
GAP: Final = (
    7.54937170418124304e-13, -1.60577019225797864e-10, 2.50520992449141141e-08,
    -2.75573191920112204e-06, 0.000198412698412165663, -0.00833333333333330026, 0.166666666666666657,
)  # fmt: skip
R: Final = (
    7.7088580917279416e-22, -3.89610970345939686e-19, 1.47947161254262735e-16, -4.49831175269064113e-14,
    1.07060281802820307e-11, -1.92708525689134348e-9, 2.5052108384699699e-7, -0.0000220458553791796289,
    0.00119047619047618481, -0.033333333333333332, 0.333333333333333333,
)  # fmt: skip

_TURN: Final = 2.0 * np.pi
_AT_EVENT: Final = 1e-9  # [rad] this close after an event a rounded phase counts as being at it


class CycleLeg(NamedTuple):
    """One leg of a cycle.

    Attributes
    ----------
    kind : str
        F forward slide, B back slide, _ rest, as in a pattern.
    start, end : float
        Drive phase [rad]; the first start lies in [0, 2 pi), each other one at the end before it.
    displacement : float
        Displacement relative to the trough during the leg [A].
    """

    kind: str
    start: float
    end: float
    displacement: float


def polynomial(y: Floats, coefficients: tuple[Any, ...]) -> Floats:
    """Evaluate by Horner's rule, in place."""
    value: Floats = coefficients[0] * y
    for a in coefficients[1:-1]:
        value += a
        value *= y
    value += coefficients[-1]
    return value


def until(event: Floats, phase: Floats) -> Floats:
    """Phase from ``phase`` to the next passage of an event phase, 0 where it is there [rad]."""
    return np.maximum(np.mod(event - phase + _AT_EVENT, _TURN) - _AT_EVENT, 0.0)


def each(group: Any, change: Callable[[NDArray[Any]], NDArray[Any]]) -> Any:
    """Change every array of a nested (named) tuple of arrays."""
    if not isinstance(group, tuple):
        return change(group)
    members = [each(member, change) for member in group]
    return group._make(members) if hasattr(group, "_make") else tuple(members)


def largest_amplitude(first: Floats, *others: Floats) -> Floats:
    """Scale of the lengths of a drive with several amplitudes; 1 where the trough stands still [m]."""
    largest = first
    for amplitude in others:
        largest = np.maximum(largest, amplitude)
    return largest if np.all(largest) else np.where(largest > 0.0, largest, 1.0)
