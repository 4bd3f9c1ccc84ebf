"""The force of a filling on its trough from a history, by quadrature of sampled forces and by impulses.

It shares nothing with ``vibro.core.filling`` but the scene: ``vibro.simulate`` follows the body from rest,
and the history says where it is and what force acts on it.
"""

from __future__ import annotations

import math
from bisect import bisect_left
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

import vibro
from vibro.drives import Ellipse, Line

if TYPE_CHECKING:
    from collections.abc import Sequence

    from vibro.results.history import History, Phase

TURN = 2.0 * math.pi
_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(20)
_PANEL = 0.7  # [rad] longest piece that the rule is used on


class Measured(NamedTuple):
    """Shares, second harmonic over |X| w^2, and energy a cycle [J/kg] in two ways."""

    share: complex
    second_along: complex
    second_normal: complex
    work: float
    losses: float


def measured_reaction(scene: vibro.Scene, cycles: float = 400.0) -> Measured:
    """Follow a body from rest until its motion repeats, and integrate over the cycle."""
    frequency = float(scene.frequency)
    first = vibro.simulate(scene, cycles=cycles)
    assert first.period_cycles, "does not settle"
    begin, period = first.settles_at, first.period_cycles
    history = vibro.simulate(scene, cycles=begin * frequency + period + 1.0)
    return _measured(history, history.phases, begin, period)


def measured_means(scene: vibro.Scene, cycles: int, parts: int) -> list[Measured]:
    """Follow a body whose motion does not repeat from rest, and integrate over parts of some cycles each."""
    history = vibro.simulate(scene, cycles=(parts + 1) * cycles)
    period, found = cycles / float(scene.frequency), []
    starts = [phase.start for phase in history.phases]
    for part in range(1, parts + 1):
        begin = part * period
        some = history.phases[bisect_left(starts, begin) : bisect_left(starts, begin + period) + 1]
        found.append(_measured(history, some, begin, cycles))
    return found


def _measured(history: History, phases: Sequence[Phase], begin: float, period: int) -> Measured:
    """Integrate over the phases that begin in some drive cycles."""
    scene = history.scene
    frequency, e = float(scene.frequency), float(scene.restitution)
    w, end = TURN * frequency, begin + period / frequency
    drive = scene.arrays()
    if scene.along_harmonics is not None and scene.normal_harmonics is not None:
        # the first harmonics are to have the phase 0
        lead, x, y = 0.0, float(scene.along_harmonics[0][0]), float(scene.normal_harmonics[0][0])
    else:
        assert isinstance(drive, Line | Ellipse)
        lead, x = float(drive.phase), float(drive.along)
        if isinstance(drive, Line):
            y = float(drive.amplitude * np.sin(drive.drive_angle))
        else:
            y = float(drive.normal_amplitude)
    force = np.zeros((2, 2), complex)  # harmonic, axis
    moved = float(history.sample(end).position - history.sample(begin).position)
    losses = float(scene.gravity) * math.sin(float(scene.trough_angle)) * moved
    for i, phase in enumerate(phases):
        if phase.start < begin - 1e-9 / frequency or phase.start > end - 1e-9 / frequency:
            continue
        count = max(1, math.ceil((phase.end - phase.start) * w / _PANEL))
        edges = np.linspace(phase.start, phase.end, count + 1)
        half = 0.5 * np.diff(edges)[:, np.newaxis]
        time = (edges[:-1, np.newaxis] + half + half * _NODES).ravel()
        weight = (half * _WEIGHTS).ravel()
        if phase.kind != "H":
            at = history.sample(time)
            losses -= float(weight @ (at.friction * at.velocity))
            for k in (1, 2):
                turn = np.exp(-1j * k * w * time) * weight
                force[k - 1] -= turn @ at.friction, turn @ at.normal
        elif i + 1 < len(phases):
            after = phases[i + 1]
            speed, flies = phase.impact_velocity, after.kind == "H"
            impulse = speed * (1.0 + e) / (1.0 if flies else 1.0 - e)
            slip = after.start_velocity - phase.end_velocity
            losses += 0.5 * speed * speed * (1.0 - e * e if flies else 1.0)
            losses += 0.5 * (phase.end_velocity**2 - after.start_velocity**2)
            for k in (1, 2):
                force[k - 1] -= np.exp(-1j * k * w * phase.end) * np.array([slip, impulse])
    force *= 1j / math.pi * w / period / w**2
    path = np.array([x, y * np.exp(1j * lead)])
    size = x * x + y * y
    share = complex(path.conj() @ force[0]) / size
    root = math.sqrt(size)
    return Measured(
        share,
        complex(force[1, 0]) / root,
        complex(force[1, 1]) / root,
        -math.pi * size * w * w * share.imag,
        losses / period,
    )
