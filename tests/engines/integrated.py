"""A body integrated in time by SciPy, in both directions of motion, with an event for every change."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np
from scipy.integrate import solve_ivp

if TYPE_CHECKING:
    from collections.abc import Callable

    from helpers.scenes import Groups
    from numpy.typing import NDArray

    Floats = NDArray[np.float64]

TURN = 2.0 * math.pi
TOLERANCE = 1e-12  # of the integrator, relative and absolute [A]
LONGEST_STEP = 0.1  # [rad] no step contains both changes of sign of a landing that hardly touches
LEAST_BOUNCE = 1e-7  # [A w] slower take-offs are left out: their flights are shorter than its square


class Body:
    """A body on the trough in time: Coulomb's law, free flight, Newton's impact; no closed form.

    The trough's motion normal to itself may lead that along it by a phase [rad].
    """

    def __init__(
        self,
        groups: Groups,
        e: float = 0.0,
        *,
        phase: float = 0.0,
        velocity: float = 0.0,
        lead: float = 0.0,
    ) -> None:
        alpha, beta = math.radians(groups.drive_deg), math.radians(groups.trough_deg)
        self.along, self.across, self.lead = math.cos(alpha), math.sin(alpha), lead
        self.weight, self.slope = math.cos(beta) / groups.load, math.sin(beta) / groups.load
        self.mu_s, self.mu_d, self.e = groups.mu_s, groups.mu_d, e
        self.p, self.aloft, self.way = phase, self.normal(phase) < 0.0, int(np.sign(velocity))
        self.state = np.array([0.0, velocity, 0.0, 0.0])  # position, velocity, height and its rate

    def load(self, p: float) -> float:
        return self.along * math.sin(p) - self.slope

    def normal(self, p: float) -> float:
        return self.weight - self.across * math.sin(p + self.lead)

    def until(self, end: float) -> None:
        """Follow the motion up to a phase."""
        while self.p < end:
            if self.aloft:
                self._fly(end)
            elif self.way:
                self._slide(end)
            else:
                self._rest(end)

    def _integrate(self, end: float, *events: Callable[[float, Floats], float]) -> int:
        """Integrate to the first event; its number, or -1 at the end."""
        friction = 0.0 if self.aloft else -self.way * self.mu_d

        def rates(p: float, y: Floats) -> list[float]:
            lift = -self.normal(p) if self.aloft else 0.0
            return [y[1], self.load(p) + friction * self.normal(p), y[3], lift]

        for event in events:
            event.terminal, event.direction = True, -1.0  # type: ignore[attr-defined]
        run = solve_ivp(
            rates,
            (self.p, end),
            self.state,
            "DOP853",
            events=events,
            rtol=TOLERANCE,
            atol=TOLERANCE,
            max_step=LONGEST_STEP,
        )
        self.p, self.state = float(run.t[-1]), run.y[:, -1].copy()
        assert run.t_events is not None
        return next((i for i, times in enumerate(run.t_events) if times.size), -1)

    def _rest(self, end: float) -> None:
        """Wait until the load exceeds static friction."""

        def holds(p: float) -> float:
            return self.mu_s * self.normal(p) - abs(self.load(p))

        mesh = np.linspace(self.p, self.p + TURN, 2001)
        normal = self.weight - self.across * np.sin(mesh + self.lead)
        slips = np.flatnonzero(self.mu_s * normal < np.abs(self.along * np.sin(mesh) - self.slope))
        if not slips.size:
            self.p = end
            return
        low, high = mesh[max(slips[0] - 1, 0)], mesh[slips[0]]
        for _ in range(60):
            middle = 0.5 * (low + high)
            low, high = (middle, high) if holds(middle) >= 0.0 else (low, middle)
        self.p = min(high, end)
        if high <= end:
            self.way = int(math.copysign(1.0, self.load(high)))

    def _slide(self, end: float) -> None:
        """Slide until the body stops or the load is gone."""
        way = self.way
        event = self._integrate(end, lambda p, y: way * y[1] + 0.0 * p, lambda p, _: self.normal(p))
        if event == 0:
            self.state[1] = 0.0
            self._stick()
        elif event == 1:
            self.aloft, self.state[2:] = True, 0.0

    def _stick(self) -> None:
        load = self.load(self.p)
        slips = abs(load) > self.mu_s * self.normal(self.p)
        self.way = int(math.copysign(1.0, load)) if slips else 0

    def _fly(self, end: float) -> None:
        """Fly to the next landing, and apply the impact."""
        if self.state[2] <= 0.0:  # off the surface first, where the event would see only the start
            self._leave()
        if self._integrate(end, lambda p, y: y[2] + 0.0 * p) < 0:
            return
        impact = -self.state[3]
        speed = max(abs(self.state[1]) - self.mu_d * (1.0 + self.e) * impact, 0.0)
        self.state[1] = math.copysign(speed, self.state[1])
        self.state[2], self.state[3] = 0.0, self.e * impact
        if self.normal(self.p) > 0.0 and self.state[3] < LEAST_BOUNCE:
            self.aloft, self.state[3] = False, 0.0
            self.way = int(np.sign(self.state[1]))
            if not self.way:
                self._stick()

    def _leave(self) -> None:
        """Take a short step of the flight by its Taylor series, up to the fifth power."""
        p, (_, velocity, _, rate) = self.p, self.state
        q, lift = p + self.lead, -self.normal(p)
        s = 1e-3 if rate == 0.0 else min(1e-3, 0.1 * rate / max(abs(lift), 1e-3))

        def bend(p: float) -> float:
            return math.cos(p) * (s**3 / 6.0 - s**5 / 120.0) - math.sin(p) * s**4 / 24.0

        self.state += np.array(
            [
                velocity * s + self.load(p) * s**2 / 2.0 + self.along * bend(p),
                self.along * (math.cos(p) - math.cos(p + s)) - self.slope * s,
                rate * s + lift * s**2 / 2.0 + self.across * bend(q),
                self.across * (math.cos(q) - math.cos(q + s)) - self.weight * s,
            ]
        )
        self.p = p + s
