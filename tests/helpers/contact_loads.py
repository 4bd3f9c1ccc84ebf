"""Loads of bodies on the trough, for the tests: made, drawn at random, and their motion with 50 digits.

Nothing of the solver but the record ``Loads`` enters what is exact here. Phases are those of the normal
motion.
"""

from __future__ import annotations

import math
import random
from typing import TYPE_CHECKING, Any

import mpmath
from engines import two_axis_walk

from vibro.core.drive import Loads, directions, ellipse_loads, line_loads

if TYPE_CHECKING:
    from collections.abc import Iterator

MP = mpmath.mp.clone()
MP.dps = 50
TURN = 2.0 * math.pi
EPS = 2.0**-52


def line(drive_deg: float, weight: float, mu_s: float, mu_d: float, trough_deg: float = 0.0) -> Loads:
    """Make the loads of a drive along a line, from 1/G."""
    return line_loads(weight, directions(math.radians(drive_deg), math.radians(trough_deg)), mu_s, mu_d)


def ellipse(
    along: float, normal: float, phase: float, weight: float, mu_s: float, mu_d: float, trough: float = 0.0
) -> Loads:
    """Make the loads of an elliptical drive; angles [rad]."""
    return ellipse_loads(along, normal, weight, directions(phase, trough), mu_s, mu_d)


def random_lines(
    count: int, seed: int, *, steepest: float = 0.0, least_ratio: float = 0.1
) -> Iterator[Loads]:
    """Draw lines in contact that slip, on troughs of up to a share of the angle of static friction."""
    draw = random.Random(seed)
    while count:
        mu_s = math.exp(draw.uniform(math.log(0.05), math.log(1.2)))
        trough = draw.uniform(-steepest, steepest) * math.atan(mu_s)
        drive = draw.uniform(0.02, min(1.3, 1.5 - trough))
        onset = (mu_s * math.cos(trough) - abs(math.sin(trough))) / (math.cos(drive) + mu_s * math.sin(drive))
        hop = math.cos(trough) / math.sin(drive)
        onset = max(onset, 0.01 * hop)
        if onset < hop:
            load = onset * (0.999 * hop / onset) ** draw.uniform(0.0, 1.0)
            mu_d = mu_s * draw.uniform(least_ratio, 1.0)
            count -= 1
            yield line_loads(1.0 / load, directions(drive, trough), mu_s, mu_d)


def random_ellipses(
    count: int, seed: int, *, steepest: float = 0.0, least_ratio: float = 0.1, least_throw: float = 0.02
) -> Iterator[Loads]:
    """Draw ellipses in contact, on troughs of up to a share of the angle of static friction."""
    draw = random.Random(seed)
    for _ in range(count):
        mu_s = math.exp(draw.uniform(math.log(0.05), math.log(1.2)))
        trough = draw.uniform(-steepest, steepest) * math.atan(mu_s)
        normal = math.exp(draw.uniform(math.log(least_throw), math.log(0.999))) * math.cos(trough)
        along = mu_s * math.exp(draw.uniform(math.log(0.3), math.log(20.0)))
        scale, mu_d = max(along, normal), mu_s * draw.uniform(least_ratio, 1.0)
        angles = directions(draw.uniform(-math.pi, math.pi), trough)
        yield ellipse_loads(along / scale, normal / scale, 1.0 / scale, angles, mu_s, mu_d)


def random_loads(count: int, seed: int, *, steepest: float = 0.0, least_ratio: float = 0.1) -> list[Loads]:
    """Draw lines and ellipses, as many of each."""
    lines = random_lines(count, seed, steepest=steepest, least_ratio=least_ratio)
    return [*lines, *random_ellipses(count, seed, steepest=steepest, least_ratio=least_ratio)]


def heavier(loads: Loads, by: float) -> Loads:
    """Change the weight: 1/G times a number."""
    return loads._replace(
        weight_normal=by * loads.weight_normal,
        weight_tangential=by * loads.weight_tangential,
        weight_across=by * loads.weight_across,
    )


def body_of(loads: Loads) -> two_axis_walk.Body:
    """Make the body of the walk that uses nothing of the package; its lengths are in A times the weight."""
    weight = math.hypot(loads.weight_normal, loads.weight_tangential)
    return two_axis_walk.Body(
        along=loads.drive_tangential / weight,
        normal=loads.drive_normal / weight,
        lead=math.atan2(loads.phase_sine, loads.phase_cosine),
        frequency=1.0,
        mu_s=loads.static_friction,
        mu_d=loads.kinetic_friction,
        trough=math.atan2(loads.weight_tangential, loads.weight_normal),
        gravity=TURN**2,
    )


class Exact:
    """The motion of a body on the trough with 50 digits, from its loads as they are rounded."""

    def __init__(self, loads: Loads) -> None:
        names = loads._asdict()
        self.a, self.b, self.n, self.t, _, self.mu_s, self.mu_d, sine, cosine = (
            MP.mpf(names[name]) for name in list(names)[:9]
        )
        self.turn = MP.mpc(cosine, -sine)  # e^{-i phi}

    def load(self, way: float, mu: Any) -> Any:
        """Complex amplitude C e^{i psi} of the load one way against friction of a coefficient."""
        return way * self.a * self.turn + mu * self.b

    def resistance(self, way: float, mu: Any) -> Any:
        return mu * self.n + way * self.t

    def pull(self, way: float, mu: Any, p: Any) -> Any:
        """Load less friction, at a phase: the acceleration if ``mu`` is that of kinetic friction."""
        along = self.a * (self.turn * MP.expj(p)).imag - self.t
        return way * along - mu * (self.n - self.b * MP.sin(p))

    def speed(self, way: float, p0: Any, p: Any) -> Any:
        """Speed of a slide that starts at a phase."""
        load = self.load(way, self.mu_d)
        return (load * (MP.expj(p0) - MP.expj(p))).real - self.resistance(way, self.mu_d) * (p - p0)

    def path(self, way: float, p0: Any, p: Any) -> Any:
        """Path of a slide that starts at a phase, positive in its direction."""
        load, length = self.load(way, self.mu_d), p - p0
        moved = (load * MP.expj(p0)).real * length - (load * (MP.expj(p) - MP.expj(p0))).imag
        return moved - self.resistance(way, self.mu_d) * length**2 / 2

    def window(self, way: float) -> tuple[Any, Any]:
        """Phases at which the static window opens and closes; the former in [0, 2 pi)."""
        load = self.load(way, self.mu_s)
        half = MP.acos(self.resistance(way, self.mu_s) / abs(load))
        opens = (MP.pi / 2 - MP.arg(load) - half) % (2 * MP.pi)
        return opens, opens + 2 * half

    def next_window(self, way: float, p: Any) -> tuple[Any, Any]:
        """Return the static window that is the first to open after a phase."""
        opens, closes = self.window(way)
        turns = MP.ceil((p - opens) / (2 * MP.pi)) * 2 * MP.pi
        return opens + turns, closes + turns
