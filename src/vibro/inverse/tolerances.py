"""The tolerances of inverse design, each with its unit and the reason for its size."""

from __future__ import annotations

from typing import Final, NamedTuple

__all__ = ["TOLERANCES", "Tolerances"]


class Tolerances(NamedTuple):
    """Distances at which two numbers count as one; all are relative, unless they have a unit.

    Attributes
    ----------
    beside : float
        From a load that is not to be exceeded: more than the rounding of the products that form a load (4
        ulp), less than any number that is printed.
    rounding : float
        Of a load that is formed anew from its setting, and of conversions between units: below ``beside``.
    converted : float
        Of a printed setting against the limits of its drive, after two conversions of units.
    short : float
        Distance of scaled bands from impossible values: from a right angle [rad], from a load of 0 [1].
    searched : float
        Of a speed, by which the slowest body of a search may exceed the slowest of the scenarios
        (tests/inverse/test_guarantees.py: searches agree to 1e-9 with ten times their effort).
    near : float
        Distance from a critical load within which its one-sided limit is computed: searches end within 1e-7.
    either_side : float
        From a critical load at which both sides are compared: beyond the rounding of 1e-12 of its root.
    jump : float
        Change of a speed over ``either_side`` that is a jump: slopes just above an onset reach 1e3.
    fall : float
        The same over ``at``, where a design is scaled instead of a body.
    at : float
        From a limit, within which a design stands at it: the coarsest margins are found to 1e-6.
    nearly : float
        Share of a limit on landings that counts as reached: landings are sampled.
    drop : float
        [share of a band] Beside a scenario, within which a drop of the speed is looked for.
    past_drop : float
        Way back from a drop by which a scenario is kept on its slow side: rounding decides at the drop.
    top : float
        [share of a band] To which the fastest drive angle is found; the speed there is flat.
    digits : int
        [decimals of coordinates] In which scenarios differ.
    braked : float
        Share of the weight down the trough by which friction must exceed it: below, rounding decides whether
        bodies run away.
    """

    beside: float = 1e-12
    rounding: float = 1e-13
    converted: float = 1e-12
    short: float = 1e-6
    searched: float = 1e-9
    near: float = 1e-7
    either_side: float = 1e-9
    jump: float = 1e-6
    fall: float = 1e-4
    at: float = 1e-6
    nearly: float = 0.98
    drop: float = 1e-6
    past_drop: float = 1e-9
    top: float = 1e-10
    digits: int = 6
    braked: float = 1e-12


TOLERANCES: Final = Tolerances()
