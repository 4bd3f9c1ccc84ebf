"""Questions of the frozen answers: scenes, starts and machines, drawn alike on every computer.

SplitMix64 gives the numbers, and plain arithmetic and square roots the rest, so that every double is the same
everywhere and for ever.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, Final
from zlib import crc32

import numpy as np

import vibro

if TYPE_CHECKING:
    from collections.abc import Iterator

    from numpy.typing import NDArray

    Floats = NDArray[np.float64]
    Batch = dict[str, Any]  # arguments of one call: arrays whose last axis has the cells, a motion, a machine

_GRAVITY: Final = 9.81
_Range = tuple[float, float]


class Draws:
    """SplitMix64 (Steele, Lea and Flood 2014), from a seed of its own for each set."""

    def __init__(self, name: str) -> None:
        self._count = crc32(name.encode()) << 20

    def __call__(self, low: float, high: float, *shape: int) -> Floats:
        """Draw numbers, uniform between two ends."""
        n = math.prod(shape)
        x = np.arange(self._count, self._count + n, dtype=np.uint64) * np.uint64(0x9E3779B97F4A7C15)
        self._count += n
        for shift, factor in ((30, 0xBF58476D1CE4E5B9), (27, 0x94D049BB133111EB)):
            x = (x ^ (x >> np.uint64(shift))) * np.uint64(factor)
        x ^= x >> np.uint64(31)
        unit = (x >> np.uint64(11)).astype(np.float64) * 2.0**-53
        return (low + (high - low) * unit).reshape(shape)

    def one_in(self, count: float, n: int) -> NDArray[np.bool_]:
        """Draw which of n cells are special."""
        return self(0.0, count, n) < 1.0


def _body(draw: Draws, n: int, throw: _Range, e: float) -> Batch:
    """Draw all but the drive, and now and then a special case; without a throw number parts are clamped."""
    static, ratio = draw(0.05, 1.2, n), draw(0.0, 1.0, n)
    for count, special in ((20, 1.0), (20, 0.0), (100, 1.25)):  # mu_d = mu_s, none, and what is impossible
        ratio[draw.one_in(count, n)] = special
    static[draw.one_in(50, n)] *= 4.0
    static[draw.one_in(200, n)] = 0.0
    climb = draw(-0.12, 0.12, n) * draw.one_in(2, n)
    climb[draw.one_in(40, n)] *= 5.0
    return {
        "frequency": draw(5.0, 100.0, n),
        "static_friction": static,
        "kinetic_friction": ratio * static,
        "trough_angle": climb,
        "restitution": np.full(n, e),
        **({} if throw[1] else {"normal_acceleration": draw(2.0, 30.0, n)}),
    }


def _unit(body: Batch) -> Floats:
    """Return the amplitude whose normal acceleration just bears the weight, nearly [m]."""
    w = 2.0 * math.pi * body["frequency"]
    level = 1.0 - 0.5 * body["trough_angle"] ** 2  # cos(beta)
    return np.asarray(level * _GRAVITY / (w * w))


def line(draw: Draws, n: int, throw: _Range, e: float) -> Batch:
    """Draw drives along a line by their throw number, nearly."""
    body, angle = _body(draw, n, throw, e), draw(0.0, 1.3, n)
    angle[draw.one_in(30, n)] = 0.0
    load = np.minimum(draw(*throw, n) / np.maximum(angle, 0.05), 12.0)
    return {"amplitude": load * _unit(body), "drive_angle": angle, **body}


def ellipse(draw: Draws, n: int, throw: _Range, e: float) -> Batch:
    """Draw drives along an ellipse by their throw number."""
    body, normal = _body(draw, n, throw, e), draw(*throw, n)
    normal[draw.one_in(50, n)] = 0.0
    return {
        "along_amplitude": draw(0.05, 2.0, n) * draw(0.1, 2.5, n) * _unit(body),
        "normal_amplitude": normal * _unit(body),
        "normal_phase": draw(-3.14, 3.14, n),
        **body,
    }


def harmonics(draw: Draws, n: int, throw: _Range, e: float, count: int = 3) -> Batch:
    """Draw drives with harmonics by the sum of their normal accelerations."""
    body, sizes = _body(draw, n, throw, e), draw(0.0, 1.0, 2, count, n)
    sizes[:, 1:][draw(0.0, 1.0, 2, count - 1, n) < 0.2] = 0.0
    total = np.stack([draw(0.2, 4.0, n), draw(*throw, n)])
    order = np.arange(1.0, count + 1.0)[:, None]
    amplitudes = sizes / sizes.sum(1, keepdims=True) * total[:, None] / (order * order) * _unit(body)
    along, normal = np.stack([amplitudes, draw(-3.14, 3.14, 2, count, n)], axis=2)
    moved = {"along_harmonics": along} | ({"normal_harmonics": normal} if throw[1] else {})
    return {**moved, "motion_scale": np.ones(n), **body}


def steps(draw: Draws, n: int, throw: _Range, e: float) -> Batch:
    """Draw scales of one motion of 2 to 6 steps."""
    pairs = []
    for size in (float(draw(2.0, 25.0, 1)[0]), _GRAVITY * float(draw(*throw, 1)[0])):
        count = 2 + int(draw(0.0, 5.0, 1)[0])
        shares, values = draw(0.1, 1.0, count), draw(-1.0, 1.0, count)
        shares /= math.fsum(shares)
        values -= math.fsum(shares * values)
        pairs.append(np.stack([shares, values * (size / np.abs(values).max())], axis=1).tolist())
    motion = vibro.Motion.steps(*pairs[: 2 if throw[1] else 1])
    return {"motion": motion, "motion_scale": draw(0.4, 1.0, n), **_body(draw, n, throw, e)}


def samples(draw: Draws, n: int, throw: _Range, e: float) -> Batch:
    """Draw scales of one motion of 16 to 64 smooth samples."""
    count, rows = 16 + int(draw(0.0, 49.0, 1)[0]), []
    for size in (float(draw(2.0, 25.0, 1)[0]), _GRAVITY * float(draw(*throw, 1)[0])):
        row = draw(-1.0, 1.0, count)
        for _ in range(count // 6):
            row = 0.25 * np.roll(row, 1) + 0.5 * row + 0.25 * np.roll(row, -1)
        row -= math.fsum(row) / count
        rows.append(row * (size / np.abs(row).max()))
    motion = vibro.Motion.samples(*rows[: 2 if throw[1] else 1])
    return {"motion": motion, "motion_scale": draw(0.4, 1.0, n), **_body(draw, n, throw, e)}


KINDS: Final = (line, ellipse, harmonics, steps, samples)
_RESTS, _HOPS, _CLAMPED = (0.02, 0.98), (1.2, 5.0), (0.0, 0.0)


def _machines(draw: Draws) -> Iterator[vibro.Machine]:
    """Draw two machines of each kind."""
    for _ in range(2):
        mass, natural, damping, moment, radius, beside, force = (
            float(draw(low, high, 1)[0])
            for low, high in ((4, 12), (30, 60), (0.01, 0.06), (0.01, 0.03), (3e-4, 3e-3), (1.5, 4), (10, 60))
        )
        springs: Batch = {"trough_mass": mass, "natural_frequency": natural, "damping_ratio": damping}
        two, known = springs | {"counter_mass": beside * mass}, vibro.Calibration(radius / 3.0, natural * 1.1)
        yield vibro.Machine.unbalance(vibrating_mass=mass, static_moment=moment, mount_frequency=4.0)
        yield vibro.Machine.magnet(**two, calibration=known, base_stiffness=1e4, gap=2.0 * radius)
        yield vibro.Machine.magnet(**springs, force=force, law="voltage", force_frequency=natural)
        yield vibro.Machine.exciter(**two, static_moment=moment)
        yield vibro.Machine.crank(radius=radius)
        yield vibro.Machine.rod(radius=radius, rod_stiffness=2e4 * mass, **springs)
        x = np.array([0.7, 0.85, 0.95, 1.05, 1.2, 1.5])  # frequency over the natural one
        peak = radius / np.sqrt((1.0 - x * x) ** 2 + (2.0 * damping * x) ** 2)
        points = np.stack([natural * x, 0.1 * peak * draw(0.98, 1.02, x.size)], axis=1)
        yield vibro.Machine.measured(points=points, trough_mass=mass)


def batches(name: str) -> Iterator[Batch]:
    """Draw the questions of a set."""
    draw = Draws(name)
    if name == "contact":
        yield from (kind(draw, 10_000, _RESTS, 0.0) for kind in (line, ellipse))
    elif name == "harmonics":
        for count, n in ((2, 1500), (3, 1000), (4, 800), (5, 600), (6, 500), (10, 150), (16, 100)):
            yield harmonics(draw, n, _RESTS, 0.0, count)
        yield from (harmonics(draw, 50, _CLAMPED, 0.0, count) for count in range(2, 9))
    elif name in {"steps", "samples"}:
        kind, count = {"steps": (steps, 200), "samples": (samples, 50)}[name]
        yield from (kind(draw, 10, _RESTS if i % 5 else _CLAMPED, 0.0) for i in range(count))
    elif name == "hops":
        for e, sizes in ((0.0, (900, 350, 200, 10, 5)), (0.2, (350, 150, 100, 5, 5))):
            for kind, n in zip(KINDS, sizes, strict=True):
                yield from (kind(draw, n, _HOPS, e) for _ in range(10 if kind in {steps, samples} else 1))
        for e, sizes in ((0.6, (200, 120, 60, 5, 2)), (0.9, (150, 100, 40, 5, 2))):
            for kind, n in zip(KINDS, sizes, strict=True):
                yield from (kind(draw, n, _HOPS, e) for _ in range(8 if kind in {steps, samples} else 1))
    elif name == "others":
        yield from (kind(draw, 15, _HOPS, 0.3 * (kind is ellipse)) for kind in KINDS)
    elif name == "histories":
        for kind, throw, e in (
            (k, t, e) for k in KINDS for t, e in ((_RESTS, 0.0), (_HOPS, 0.0), (_HOPS, 0.4))
        ):
            batch = kind(draw, 20, throw, e)
            lift = {"start_height": draw(0.0, 2e-3, 20), "start_normal_velocity": draw(-0.1, 0.1, 20)}
            start = {"start_phase": draw(-3.0, 3.0, 20), "start_velocity": draw(-0.2, 0.2, 20)} | lift
            yield (
                batch
                | {key: x * draw.one_in(3, 20) for key, x in start.items()}
                | {"length": draw(0.01, 0.2, 20)}
            )
    else:
        for machine in _machines(draw):
            springs, static, setting = machine.natural_frequency, draw(0.1, 0.6, 15), draw(0.1, 1.4, 15)
            beside = springs if 20.0 < springs < 100.0 else 30.0
            yield _body(draw, 15, _HOPS, 0.0) | {
                "machine": machine,
                "drive_angle": draw(0.1, 0.6, 15),
                "frequency": beside * draw(0.85, 1.1, 15),
                "static_friction": static,
                "kinetic_friction": static * draw(0.0, 1.0, 15),
                "setting": setting * setting,
                "filling": np.maximum(draw(-10.0, 30.0, 15), 0.0),
            }
        known, setting = vibro.Calibration(0.35e-3, 50.0), draw(0.3, 1.06, 40)
        masses: Batch = {
            "trough_mass": 6.0,
            "counter_mass": 12.0,
            "natural_frequency": 55.0,
            "damping_ratio": 0.015,
        }
        # Below resonance a filling that begins to slip takes away amplitude: points lie at jumps.
        yield _body(draw, 40, _HOPS, 0.0) | {
            "machine": vibro.Machine.magnet(calibration=known, gap=0.5e-3, **masses),
            "drive_angle": draw(0.2, 0.5, 40),
            "frequency": np.full(40, 50.0),
            "static_friction": draw(0.3, 0.5, 40),
            "kinetic_friction": draw(0.05, 0.15, 40),
            "setting": setting * setting * setting,
            "filling": draw(1.5, 3.0, 40),
        }
