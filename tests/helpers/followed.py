"""Bodies followed by the plain solver, for the tests, and Newton's law for their legs by quadrature."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np

from vibro.core.bounces import Flights
from vibro.core.codes import Mode
from vibro.core.drive import Loads, directions, ellipse_loads, line_loads
from vibro.core.history import (
    Course,
    Followed,
    LastStarts,
    Launch,
    Legs,
    State,
    Step,
    course_of,
    follow_legs,
    sections_of,
    starting,
    step,
)
from vibro.core.numbers import LONGEST_CYCLE, MOST_BOUNCES

if TYPE_CHECKING:
    from numpy.typing import NDArray

TURN = 2.0 * math.pi
LETTERS = " HFB_"
ROWS = 20_000

_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(24)
_SIZE = MOST_BOUNCES + LONGEST_CYCLE


def view(values: Any) -> Any:
    """See numbers as a buffer."""
    array: Any = np.asarray(values)
    return memoryview(array)


FLIGHTS = Flights(*(view(np.zeros(_SIZE)) for _ in Flights._fields))
LAST = LastStarts(view(np.zeros(_SIZE, np.int64)), view(np.zeros(_SIZE)))


def line(load: float, drive_deg: float, mu_s: float, mu_d: float, trough_deg: float = 0.0) -> Loads:
    """Make the loads of a drive along a line from G."""
    return line_loads(1.0 / load, directions(math.radians(drive_deg), math.radians(trough_deg)), mu_s, mu_d)


def ellipse(
    load: float, normal: float, phase_deg: float, mu_s: float, mu_d: float, trough_deg: float = 0.0
) -> Loads:
    """Make the loads of an elliptical drive, as high as ``normal`` times its length, from that length's G."""
    angles = directions(math.radians(phase_deg), math.radians(trough_deg))
    return ellipse_loads(1.0, normal, 1.0 / load, angles, mu_s, mu_d)


CONTACT = {
    "F_": line(0.9, 20.0, 0.74, 0.57),
    "F_B_": line(0.7, 1.0, 0.5, 0.49),
    "FB_": line(0.9, 20.0, 0.5, 0.4),
    "BF_": line(0.781, 57.03, 0.27, 0.155, 3.46),
    "FB": line(2.0, 25.0, 0.2, 0.15),
    "FB uphill": line(2.2, 20.0, 0.45, 0.3, 3.0),
    "B_": line(0.5, 5.0, 0.3, 0.29, 12.0),
    "presses": line(1.0, 75.0, 0.6, 0.5, -6.0),
    "more than 90 deg": line(0.85, 70.0, 0.9, 0.6, 30.0),
    "ellipse F_B_": ellipse(0.6, 0.4, -60.0, 0.5, 0.35),
    "ellipse FB_": ellipse(0.8, 0.4, -60.0, 0.5, 0.35),
    "ellipse FB": ellipse(2.2, 0.4, 130.0, 0.2, 0.15, 2.0),
    "ellipse turned": ellipse(1.8, 0.5, 200.0, 0.45, 0.4, -3.0),
}
HOPS = {
    "HFB": (line(3.4, 30.0, 0.5, 0.4), 0.0),
    "HB": (line(4.5, 25.0, 0.2, 0.1, 5.0), 0.0),
    "HHB": (line(8.6, 30.0, 0.5, 0.4), 0.0),
    "HHH": (line(8.5, 30.0, 0.5, 0.4), 0.3),
    "bounces": (line(3.0, 30.0, 0.5, 0.4), 0.3),
    "many bounces": (line(2.5, 30.0, 0.5, 0.2, -4.0), 0.6),
    "ellipse": (ellipse(3.0, 0.6, -35.0, 0.5, 0.4), 0.0),
    "ellipse back": (ellipse(3.0, 0.6, -170.0, 0.5, 0.4, 2.0), 0.3),
    "ellipse thrown at once": (ellipse(4.0, 0.5, 80.0, 0.6, 0.45, 5.0), 0.0),
}
ALL = {
    **{name: (loads, 0.0) for name, loads in CONTACT.items()},
    **{f"hops, {k}": v for k, v in HOPS.items()},
}


def load_along(loads: Loads, p: NDArray[np.float64] | float) -> NDArray[np.float64]:
    """F of Eq. (54), at phases of the normal motion."""
    phi = math.atan2(loads.phase_sine, loads.phase_cosine)
    return np.asarray(loads.drive_tangential * np.sin(p - phi) - loads.weight_tangential)


def load_normal(loads: Loads, p: NDArray[np.float64] | float) -> NDArray[np.float64]:
    """N of Eq. (54)."""
    return np.asarray(loads.weight_normal - loads.drive_normal * np.sin(p))


def newton(loads: Loads, mode: int, at: State, s: float) -> tuple[float, float, float, float]:
    """Path, velocity, height and its rate of a body a phase after the start of a leg, by quadrature."""
    friction = {Mode.FORWARD: -1.0, Mode.BACK: 1.0}.get(Mode(mode), 0.0) * loads.kinetic_friction
    panels = max(1, math.ceil(s))
    u = (np.arange(panels)[:, None] + 0.5 * (1.0 + _NODES)) * (s / panels)
    weights = 0.5 * (s / panels) * _WEIGHTS
    normal = load_normal(loads, at.phase + u)
    pull = load_along(loads, at.phase + u) + friction * normal
    rate = at.rate * loads.weight_normal
    return (
        at.velocity * s + float((weights * (s - u) * pull).sum()),
        at.velocity + float((weights * pull).sum()),
        rate * s - float((weights * (s - u) * normal).sum()),
        rate - float((weights * normal).sum()),
    )


def walked(course: Course, phase: float, velocity: float, count: int) -> list[tuple[State, Step]]:
    """Follow a body through some legs."""
    at, legs = starting(course, phase, velocity), []
    for _ in range(count):
        leg = step(course, at)
        legs.append((at, leg))
        if math.isinf(leg.length):
            break
        at = leg.after
    return legs


def history_of(
    loads: Loads, restitution: float, cycles: float, *, phase: float = 0.0, velocity: float = 0.0,
    rows: int = ROWS,
) -> tuple[Followed, Legs]:  # fmt: skip
    """Follow a body until it repeats, as ``vibro.simulate`` does."""
    course = course_of(loads, restitution)
    legs = room(rows)
    sections = sections_of(course, FLIGHTS)
    return follow_legs(course, sections, Launch(phase, velocity, 0.0, 0.0), cycles, legs, rows, LAST), legs


def room(rows: int) -> Legs:
    """Make room for legs."""
    return Legs(*(view(np.zeros(rows, kind)) for kind in ("b", "q", *"dddddddd")))
