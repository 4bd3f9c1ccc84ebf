"""Tables of traverse times with known friction and restitution, made without the package."""

from __future__ import annotations

import math
from typing import Any, Final, NamedTuple

import numpy as np
from engines.two_axis_walk import Body, NeverSettlesError

LENGTH: Final = 0.6  # [m]
GRAVITY: Final = 9.81


class Made(NamedTuple):
    """A table, the quantities that it leaves out, as arguments of ``vibro.fit_speeds``, and what is true."""

    table: dict[str, list[Any]]
    rest: dict[str, Any]
    truth: dict[str, float]


def walked_speed(
    amplitude: float,
    frequency: float,
    drive: float,
    mu_s: float,
    mu_d: float,
    e: float = 0.0,
    trough: float = 0.0,
) -> float:
    """Follow a part from rest until its cycle repeats; return its mean speed [m, Hz, rad, m/s]."""
    body = Body(
        amplitude * math.cos(drive),
        amplitude * math.sin(drive),
        0.0,
        frequency,
        mu_s,
        mu_d,
        trough,
        GRAVITY,
        e,
    )
    return body.settle(400).displacement * body.unit * frequency


def made_table(random: np.random.Generator, kind: str) -> Made:
    """Draw a table of 5 to 9 rows, whose times have normal errors of 1 to 4 %; half state them.

    Unknown is kinetic friction at a known "ratio", "both" frictions, or of "hops" restitution too, where half
    of the rows hop.
    """
    while True:
        made = _made(random, kind)
        if made is not None:
            return made


def _made(random: np.random.Generator, kind: str) -> Made | None:
    rows = int(random.integers(5, 10))
    drive, trough = math.radians(random.uniform(12.0, 35.0)), math.radians(random.choice([0.0, 3.0]))
    mu_d, ratio = random.uniform(0.15, 0.7), random.uniform(0.6, 0.95)
    e = random.uniform(0.05, 0.4) if kind == "hops" else 0.0
    frequency = np.round(random.uniform(12.0, 50.0) * random.uniform(0.8, 1.2, rows), 1)
    hop = GRAVITY * math.cos(trough) / math.sin(drive) / (2.0 * math.pi * frequency) ** 2
    share = random.uniform(0.15, 0.98, rows)
    if kind == "hops":
        share[::2] = random.uniform(1.05, 1.8, share[::2].size)
    amplitude = np.array([float(f"{x:.3g}") for x in 1e3 * share * hop])
    try:
        speeds = np.array([
            walked_speed(1e-3 * a, f, drive, mu_d / ratio, mu_d, e, trough)
            for a, f in zip(amplitude.tolist(), frequency.tolist(), strict=True)
        ])  # fmt: skip
    except NeverSettlesError:
        return None
    if np.count_nonzero(speeds > 1e-4) < 4:
        return None
    error = random.uniform(0.01, 0.04)
    noise = 1.0 + error * random.standard_normal(rows)
    times = [
        f"{x:.5g}" if v > 1e-4 else "never"
        for x, v in zip(LENGTH / np.where(speeds > 1e-4, speeds, 1.0) * noise, speeds, strict=True)
    ]
    table: dict[str, list[Any]] = {
        "amplitude_mm": amplitude.tolist(),
        "frequency_hz": frequency.tolist(),
        "traverse_time_s": times,
    }
    if random.random() < 0.5:
        table["error_percent"] = [100.0 * error] * rows
    rest: dict[str, Any] = {
        "drive_angle_deg": math.degrees(drive),
        "trough_angle_deg": math.degrees(trough),
        "trough_length_mm": 1e3 * LENGTH,
    }
    if kind != "both":
        rest["friction_ratio"] = ratio
    more = {"both": {"static_friction": mu_d / ratio}, "hops": {"restitution": e}}
    return Made(table, rest, {"kinetic_friction": mu_d, **more.get(kind, {})})
