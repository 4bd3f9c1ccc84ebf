"""Machines with fillings, as ``vibro`` takes them and as ``engines.two_way`` does; random ones among them."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from engines import two_way

import vibro

if TYPE_CHECKING:
    from collections.abc import Iterator

TURN = 2.0 * math.pi
KINDS = ("magnet", "exciter", "magnet on the floor", "unbalance")


@dataclass(frozen=True)
class Case:
    """A machine, its frequency [Hz], what lies in the trough [kg], and the arguments of a scene for that."""

    name: str
    machine: vibro.Machine
    frequency: float
    filling: float
    body: dict[str, float]

    @property
    def share(self) -> float:
        """Filling over the trough's mass."""
        return self.filling / self.machine.trough_mass

    def operate(self, **others: Any) -> vibro.OperatingPoints:
        """Let ``vibro`` find the operating point."""
        given = {"frequency": self.frequency, "filling": self.filling, **self.body, **others}
        return vibro.operate(self.machine, **given)

    def followed(self) -> two_way.Motion:
        """Follow trough and body in time."""
        body = two_way.Body(mass=self.filling, **self.body)
        return two_way.follow(masses_of(self.machine, self.frequency), body)


def masses_of(machine: vibro.Machine, frequency: float) -> two_way.Machine:
    """Masses, springs and forces of a machine, as the engine takes them."""
    m1, m2 = machine.trough_mass, machine.counter_mass
    reduced = m1 if math.isinf(m2) else m1 * m2 / (m1 + m2)
    natural = TURN * machine.natural_frequency
    force = machine.force * (frequency / machine.force_frequency) ** machine.force_exponent
    is_exciter = machine.kind == "exciter"
    return two_way.Machine(
        frequency=frequency,
        trough_mass=m1,
        counter_mass=m2,
        stiffness=reduced * natural**2,
        damping=2.0 * machine.damping_ratio * reduced * natural,
        base_stiffness=machine.base_stiffness,
        force_on_trough=0.0 if is_exciter else force,
        force_on_counter_mass=0.0 if math.isinf(m2) else force if is_exciter else -force,
    )


def drawn(count: int, seed: int) -> Iterator[Case]:
    """Draw machines on both sides of resonance, each with 1 % and with 10 to 50 % of filling."""
    random = np.random.default_rng(seed)
    for number in range(count):
        kind = KINDS[number % len(KINDS)]
        frequency, trough = float(random.choice([25.0, 50.0, 60.0, 100.0])), random.uniform(2.0, 20.0)
        ratio = random.uniform(3.0, 5.0) if kind == "unbalance" else random.choice(
            [random.uniform(0.85, 0.95), random.uniform(1.05, 1.15)]
        )  # fmt: skip
        throw, angle, friction = random.uniform(0.4, 2.5), random.uniform(0.3, 0.55), random.uniform(0.3, 0.7)
        body = {
            "drive_angle": angle,
            "static_friction": friction,
            "kinetic_friction": friction * random.uniform(0.7, 1.0),
        }
        amplitude = throw * 9.81 / math.sin(angle) / (TURN * frequency) ** 2
        counter, damping = trough * random.uniform(1.5, 3.0), random.uniform(0.01, 0.03)
        machine = _machine(kind, trough, counter, frequency / ratio, damping, amplitude, frequency)
        for share in (0.01, random.uniform(0.1, 0.5)):
            name = f"{kind} {ratio:.2f}, {100 * share:.0f} %, K {throw:.2f}"
            yield Case(name, machine, frequency, share * trough, body)


def drawn_widely(count: int, seed: int) -> Iterator[Case]:
    """Draw machines nearer to resonance with 5 to 67 % of filling, on slopes too, that may bounce."""
    random = np.random.default_rng(seed)
    for number in range(count):
        kind = KINDS[number % len(KINDS)]
        frequency = float(random.choice([16.0, 25.0, 50.0, 60.0, 100.0]))
        trough = random.uniform(2.0, 20.0)
        if kind == "unbalance":
            ratio = random.uniform(3.0, 5.0)
        else:
            ratio = random.uniform(0.8, 0.97) if random.random() < 0.5 else random.uniform(1.03, 1.2)
        throw, angle = random.uniform(0.35, 2.8), math.radians(random.uniform(15.0, 40.0))
        friction = random.uniform(0.2, 0.8)
        body = {
            "drive_angle": angle,
            "static_friction": friction,
            "kinetic_friction": friction * random.uniform(0.6, 1.0),
            "trough_angle": math.radians(random.choice([0.0, random.uniform(-5.0, 5.0)])),
            "restitution": float(random.choice([0.0, 0.0, random.uniform(0.0, 0.3)])),
        }
        amplitude = throw * 9.81 / math.sin(angle) / (TURN * frequency) ** 2
        counter, damping = trough * random.uniform(1.2, 4.0), random.uniform(0.01, 0.05)
        machine = _machine(kind, trough, counter, frequency / ratio, damping, amplitude, frequency)
        share = random.uniform(0.05, 0.67)
        name = f"{seed}.{number} {kind} {ratio:.2f}, {100 * share:.0f} %, K {throw:.2f}"
        yield Case(name, machine, frequency, share * trough, body)


def _machine(
    kind: str,
    trough: float,
    counter: float,
    natural: float,
    damping: float,
    amplitude: float,
    frequency: float,
) -> vibro.Machine:
    """Make a machine that has an amplitude when it is empty."""
    springs: dict[str, Any] = {"natural_frequency": natural, "damping_ratio": damping}
    if kind == "unbalance":

        def make(moment: float) -> vibro.Machine:
            return vibro.Machine.unbalance(
                vibrating_mass=trough, static_moment=moment, mount_frequency=natural, damping_ratio=damping
            )
    elif kind == "exciter":

        def make(moment: float) -> vibro.Machine:
            return vibro.Machine.exciter(
                trough_mass=trough, counter_mass=counter, static_moment=moment, **springs
            )
    else:

        def make(moment: float) -> vibro.Machine:
            other = counter if kind == "magnet" else math.inf
            return vibro.Machine.magnet(trough_mass=trough, counter_mass=other, force=moment, **springs)

    one = float(make(1.0).response(frequency).amplitude)
    return make(amplitude / one)
