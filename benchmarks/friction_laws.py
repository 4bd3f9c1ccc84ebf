"""How far are other laws of friction from Coulomb's with stiction? The paper's scene under each of them.

Usage: python benchmarks/friction_laws.py

Two kinds. Laws that fall with sliding speed but hold a body at rest by static friction start from the same
onset and need an event where the slide ends. Laws that are functions of the speed alone have no rest: the
body creeps under any load, and the equation is stiff. v is the sliding speed; mu_s = 0.74 and mu_d = 0.57.

- Stribeck: mu = mu_d + (mu_s - mu_d) exp(-(v/v_s)^2).
  B. Armstrong-Helouvry, P. Dupont, C. Canudas de Wit, Automatica 30 (1994) 1083.
- Benson: mu = mu_d + (mu_s - mu_d) exp(-v/v_s), the exponential law of contact programs.
  D. J. Benson, J. O. Hallquist, Comput. Methods Appl. Mech. Eng. 78 (1990) 141.
- Bengisu-Akay: mu = mu_s (1 - (1 - v/v_0)^2) for v < v_0, then mu_d + (mu_s - mu_d) exp(-xi (v - v_0)).
  M. T. Bengisu, A. Akay, J. Sound Vib. 171 (1994) 557, as reviewed by
  F. Marques, P. Flores, J. C. Pimenta Claro, H. M. Lankarani, Nonlinear Dyn. 86 (2016) 1407.
- Cubic step: a cubic from -mu_s at -v_s to mu_s at v_s, another to mu_d at v_d, as in multibody programs.
- Smoothed Coulomb: tanh, as in ``vibro accuracy``.

The names are the paper's, which prints no formulas; where a source leaves a speed open, several are run.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from scipy.integrate import solve_ivp

import vibro

AMPLITUDE, FREQUENCY, DRIVE_ANGLE = 1e-3, 15.0, math.radians(20.0)  # [m], [Hz], [rad]
MU_S, MU_D, GRAVITY = 0.74, 0.57, 9.81  # [1], [1], [m/s^2]
RESTING_AMPLITUDE = 0.6e-3  # [m] below the onset of forward slip, at 0.685 mm
W = 2.0 * math.pi * FREQUENCY
PERIOD = 1.0 / FREQUENCY
MOST_CYCLES = 50
MM = 1e-3

Law = Callable[[float], float]


class Steady(NamedTuple):
    """What a steady cycle is like."""

    advance: float  # [m] per cycle
    peak: float  # [m/s]


def loads(amplitude: float, t: float) -> tuple[float, float]:
    """Return the inertial load along the trough and the normal load, per mass, at a time."""
    push = amplitude * W * W * math.sin(W * t)
    return push * math.cos(DRIVE_ANGLE), GRAVITY - push * math.sin(DRIVE_ANGLE)


def with_stiction(law: Law, onset_friction: float = MU_S) -> Steady:
    """Follow one slide from its onset to rest; the paper's scene has only forward slides."""
    reach = AMPLITUDE * W * W * (math.cos(DRIVE_ANGLE) + onset_friction * math.sin(DRIVE_ANGLE))
    start = math.asin(onset_friction * GRAVITY / reach) / W

    def rates(t: float, y: Any) -> tuple[float, float]:
        push, normal = loads(AMPLITUDE, t)
        return y[1], push - law(abs(y[1])) * normal

    def speed(t: float, y: Any) -> float:
        return float(y[1])

    speed.terminal = True  # type: ignore[attr-defined]
    speed.direction = -1.0  # type: ignore[attr-defined]
    run = solve_ivp(
        rates, (start, start + PERIOD), (0.0, 0.0), method="DOP853", events=speed,
        rtol=1e-10, atol=1e-13, max_step=PERIOD / 500.0,
    )  # fmt: skip
    assert run.status == 1
    push, normal = loads(AMPLITUDE, run.t[-1])
    assert abs(push) < MU_S * normal, "it slides on, the other way"
    return Steady(float(run.y[0, -1]), float(run.y[1].max()))


def without_rest(law: Law, amplitude: float = AMPLITUDE) -> Steady:
    """Integrate from rest until the advance per cycle repeats."""

    def rates(t: float, y: Any) -> tuple[float, float]:
        push, normal = loads(amplitude, t)
        return y[1], push - math.copysign(law(abs(y[1])), y[1]) * normal

    speed, before = 0.0, math.inf
    for _ in range(MOST_CYCLES):
        run = solve_ivp(
            rates, (0.0, PERIOD), (0.0, speed), method="LSODA", rtol=1e-8, atol=1e-11, max_step=PERIOD / 200.0
        )
        assert run.status == 0
        advance, speed = run.y[:, -1]
        if abs(advance - before) < 1e-12:
            break
        before = advance
    return Steady(float(advance), float(np.abs(run.y[1]).max()))


def stribeck(v_s: float) -> Law:
    return lambda v: MU_D + (MU_S - MU_D) * math.exp(-((v / v_s) ** 2))


def benson(v_s: float) -> Law:
    return lambda v: MU_D + (MU_S - MU_D) * math.exp(-v / v_s)


def bengisu_akay(v_0: float, xi: float) -> Law:
    def law(v: float) -> float:
        if v < v_0:
            return MU_S * (1.0 - (1.0 - v / v_0) ** 2)
        return MU_D + (MU_S - MU_D) * math.exp(-xi * (v - v_0))

    return law


def cubic_step(v_s: float, v_d: float) -> Law:
    def step(x: float) -> float:
        return x * x * (3.0 - 2.0 * x)

    def law(v: float) -> float:
        if v < v_s:
            return MU_S * (2.0 * step(0.5 * (1.0 + v / v_s)) - 1.0)
        return MU_S + (MU_D - MU_S) * step(min((v - v_s) / (v_d - v_s), 1.0))

    return law


def smoothed(width: float) -> Law:
    def law(v: float) -> float:
        beyond = max(v / width - 5.0, 0.0) / 5.0
        return math.tanh(v / width) * (MU_D + (MU_S - MU_D) * math.exp(-beyond * beyond))

    return law


def main() -> None:
    scene = vibro.Scene(
        amplitude=AMPLITUDE,
        frequency=FREQUENCY,
        drive_angle=DRIVE_ANGLE,
        static_friction=MU_S,
        kinetic_friction=MU_D,
    )
    vibro.solve(scene)
    start = time.perf_counter()
    cycle = vibro.solve(scene)
    seconds = time.perf_counter() - start
    exact = float(cycle.displacement_per_cycle)
    print("A = 1 mm, f = 15 Hz, drive angle 20 deg, mu_s 0.74, mu_d 0.57; creep: at rest, A = 0.6 mm\n")
    print(f"{'law':46} {'advance [mm]':>12} {'off by':>8} {'peak [mm/s]':>11} {'creep [mm/h]':>12} {'ms':>6}")

    def show(name: str, steady: Steady, creep: float, seconds: float) -> None:
        print(
            f"{name:46} {steady.advance / MM:12.6f} {steady.advance / exact - 1.0:8.2%} "
            f"{steady.peak / MM:11.3f} {creep / MM:12.3g} {1e3 * seconds:6.2f}"
        )

    show("Coulomb with stiction (vibro)", Steady(exact, float(cycle.peak_velocity)), 0.0, seconds)
    holding = [
        ("Coulomb with stiction, integrated", lambda v: MU_D, MU_S),
        ("Coulomb without stiction, mu = 0.57", lambda v: MU_D, MU_D),
        *((f"Stribeck, v_s = {v:g} mm/s", stribeck(v * MM), MU_S) for v in (0.1, 1.0, 10.0, 50.0)),
        *((f"Benson, v_s = {v:g} mm/s", benson(v * MM), MU_S) for v in (0.1, 1.0, 10.0, 50.0)),
    ]
    for name, law, onset in holding:
        start = time.perf_counter()
        steady = with_stiction(law, onset)
        show(name, steady, 0.0, time.perf_counter() - start)
    creeping = [
        *((f"Bengisu-Akay, v_0 = {v:g} mm/s, xi = 1/(10 v_0)", bengisu_akay(v * MM, 0.1 / (v * MM)))
          for v in (0.1, 1.0)),
        *((f"cubic step, v_s, v_d = {a:g}, {b:g} mm/s", cubic_step(a * MM, b * MM))
          for a, b in ((0.1, 1.0), (0.1, 10.16), (1.0, 10.0))),
        *((f"smoothed Coulomb, width {v:g} mm/s", smoothed(v * MM)) for v in (0.01, 0.1, 1.0)),
    ]  # fmt: skip
    for name, law in creeping:
        start = time.perf_counter()
        steady = without_rest(law)
        seconds = time.perf_counter() - start
        creep = without_rest(law, RESTING_AMPLITUDE).advance * FREQUENCY * 3600.0
        show(name, steady, creep, seconds)


if __name__ == "__main__":
    main()
