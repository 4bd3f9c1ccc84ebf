"""What is handed to the solver: flat buffers of one type of number, their sizes, kinds of drives, and limits.

The rooms above import these from here, since they need no other source of a solver that is compiled.
"""

from __future__ import annotations

from typing import Final, NamedTuple, TypeAlias

__all__ = [
    "BODIES", "CLASSES", "ELLIPSE", "EXTREME", "FIELDS", "HARMONICS", "LINE", "LONGEST_CYCLE", "MIXES",
    "MOST_BOUNCES", "MOST_CYCLES", "MOST_HOPS", "MOST_THROW", "PIECES", "ROOM", "Bytes",
    "Doubles", "Integers", "Moments", "doubles", "integers",
]  # fmt: skip

Doubles: TypeAlias = "memoryview[float]"
Integers: TypeAlias = "memoryview[int]"
Bytes: TypeAlias = "memoryview[int]"

#: [kind] Drives of one harmonic, along a line or an ellipse; of several; of pieces of cubic polynomials.
LINE: Final = 0
ELLIPSE: Final = 1
HARMONICS: Final = 2
PIECES: Final = 3
#: Fields that every scene has; each harmonic brings four more.
FIELDS: Final = 9
#: [1] Parts of the memory, each of which has room for the coefficients of one wave, before the tables.
ROOM: Final = 4 + 6 + 2 + 16
#: [row] Mixes of loads of which zeros are kept.
MIXES: Final = 6
#: [row] Intervals are kept of forward slip, of back slip, and of cycles without a rest.
CLASSES: Final = 3
#: Bodies of each scene whose samples are averaged.
BODIES: Final = 12
#: Most hops of such a body, short bounces included: rows that it needs.
MOST_HOPS: Final = 10_000
#: Flights of one scene, short bounces included; restitutions above 0.995 may need more.
MOST_BOUNCES: Final = 8192
#: Flights in a cycle that never rests on the trough.
LONGEST_CYCLE: Final = 64
#: [1] Throw number above which the phase of a landing is lost to rounding.
MOST_THROW: Final = 1e6
#: [1] Of so many cycles doubles hold the phase.
MOST_CYCLES: Final = 1e15
#: [1] Of loads and frictions, and one over the least: motions form products of up to four of them, and
#: differences of those.
EXTREME: Final = 1e50


def doubles(count: int) -> memoryview[float]:
    """Make an array of zeros; compiled it has a constant length, and ends with the function that makes it."""
    return memoryview(bytearray(8 * count)).cast("d")


def integers(count: int) -> memoryview[int]:
    """Make an array of zeros, as ``doubles``."""
    return memoryview(bytearray(8 * count)).cast("q")


class Moments(NamedTuple):
    """Motion and loads at moments of a history, one element each; lengths in A, speeds in A w.

    Attributes
    ----------
    sine : Doubles
        Of the trough's motion normal to itself.
    trough_along, trough_normal : Doubles
        Position of the trough.
    path, velocity, acceleration : Doubles
        Of the body along the trough, relative to it; ``path`` since the start of the leg.
    inertial, normal : Doubles
        Load along the trough, and force of the trough on the body.
    gap : Doubles
        Height above the trough.
    """

    sine: Doubles
    trough_along: Doubles
    trough_normal: Doubles
    path: Doubles
    velocity: Doubles
    acceleration: Doubles
    inertial: Doubles
    normal: Doubles
    gap: Doubles
