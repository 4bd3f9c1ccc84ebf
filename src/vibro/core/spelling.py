"""All legs of a steady cycle, also where they are more than a number has room for.

The return map counts on the digits of one number, as most cycles have few legs. The others are followed once
more, from their fixed point, leg by leg.
"""

from __future__ import annotations

from typing import NamedTuple

from vibro.core.buffers import Bytes
from vibro.core.codes import Mode
from vibro.core.legs import contact_leg, mode_of
from vibro.core.orbits import HoppingCycle
from vibro.core.return_map import CLOSE, MOST_LEGS, Hops, is_chained, landed
from vibro.core.waves import at_break

__all__ = ["Spelt", "no_letters", "spell"]

_NONE: Bytes = memoryview(b"").cast("b")


class Spelt(NamedTuple):
    """The legs of a cycle so far.

    Attributes
    ----------
    velocity : float
        Relative velocity at the end of the last one.
    number : int
        How many there are.
    last : int
        The ``Mode`` of the last one; 0 before the first.
    forward, back, rest : bool
        Whether there are slides forward, slides back, and rests among them.
    """

    velocity: float
    number: int
    last: int
    forward: bool
    back: bool
    rest: bool


def no_letters() -> Bytes:
    """Stand for a buffer where no legs are to be written."""
    return _NONE


def spell(cycle: HoppingCycle, hops: Hops, velocity: float, out: Bytes, room: int) -> Spelt:
    """Follow a body through a cycle as ``return_map`` does, and write its legs.

    Parameters
    ----------
    cycle, hops : HoppingCycle, Hops
        The cycle.
    velocity : float
        Relative velocity at its first take-off, or where it begins if it has none.
    out : Bytes
        The first ``room`` legs are written there, each as a ``Mode``.
    room : int
        How many ``out`` has room for.

    Returns
    -------
    Spelt
        All legs, those beyond the room too.
    """
    spelt = Spelt(velocity, 0, 0, False, False, False)
    for row in range(cycle.first, cycle.last):
        after = landed(hops, row, spelt.velocity)
        if is_chained(cycle.track, spelt.last, hops.length[row]):
            spelt = spelt._replace(velocity=after)
        else:
            spelt = _with_leg(spelt, Mode.FLIGHT, after, out, room)
        if hops.rest[row] > 0.0:
            spelt = _with_contact(cycle, spelt, hops.landing[row], hops.rest[row], out, room)
    if cycle.rest > 0.0:
        spelt = _with_contact(cycle, spelt, cycle.landing, cycle.rest, out, room)
    return spelt


def _with_contact(
    cycle: HoppingCycle, spelt: Spelt, landing: float, rest: float, out: Bytes, room: int
) -> Spelt:
    """Append the legs from a landing until the lift-off."""
    track, phase, left = cycle.track, landing, rest
    mode = mode_of(track.loads, landing, spelt.velocity, track.landed_friction)
    for _ in range(MOST_LEGS):
        leg = contact_leg(track, mode, phase, spelt.velocity, left)
        spelt = _with_leg(spelt, mode, leg.velocity, out, room)
        if not leg.length < left - CLOSE:
            break
        phase, left, mode = at_break(track.loads.waves, phase + leg.length), left - leg.length, leg.next_mode
    return spelt


def _with_leg(spelt: Spelt, mode: int, velocity: float, out: Bytes, room: int) -> Spelt:
    """Append a leg that ends with a velocity."""
    if spelt.number < room:
        out[spelt.number] = mode
    return Spelt(
        velocity,
        spelt.number + 1,
        mode,
        spelt.forward or mode == Mode.FORWARD,
        spelt.back or mode == Mode.BACK,
        spelt.rest or mode == Mode.REST,
    )
