"""Single scenes of all drives, and what the page's state is of each."""

from __future__ import annotations

from typing import Any

import numpy as np
from helpers.scenes import NUT_POINT

from vibro import Motion
from vibro.drives import HarmonicMotion, PiecewiseMotion
from vibro.explore.scenes import pieces_data
from vibro.files.motions import GivenMotion
from vibro.quantities import LINEAR, QUANTITIES
from vibro.scene import harmonic_values
from vibro.sweeps.grid import Grid


def cell(motion: Motion | None = None, length: float | None = 600.0, /, **changes: float) -> Grid:
    """Return a single cell with changes to the nut, in the units outside; another drive replaces the line."""
    names = {"along_amplitude", "normal_amplitude", "motion_scale"}.intersection(changes)
    own = {name: value for name, value in NUT_POINT.items() if not names or name not in LINEAR} | changes
    given = None if motion is None else GivenMotion({"along_samples": []}, motion)
    fixed = {name: own[name] for name in QUANTITIES if name in own}
    return Grid({}, fixed, length, arrivals=length is not None, motion=given)


def state_of(grid: Grid, cycles: int = 3, machine: dict[str, Any] | None = None) -> dict[str, Any]:
    """Return the page's state of a single cell; with a machine that is given as the page's data have it."""
    values = dict(grid.fixed)
    if grid.length is not None:
        values["trough_length"] = grid.length
    given: dict[str, Any] | None = None
    if grid.motion is not None:
        motion = grid.motion.motion
        given = {"kind": "harmonics", "values": {}, "motion": None, "table": [*grid.motion.table]}
        if isinstance(motion, PiecewiseMotion):
            given |= {"kind": "pieces", "motion": pieces_data(motion)}
        elif isinstance(motion, HarmonicMotion):
            given["values"] = harmonic_values(motion)
        values |= given["values"]
    drive = "machine" if machine else "given" if given else "line"
    state = {"scene": 0, "drive": drive, "values": values, "cycles": cycles}
    return {**state, "given": given, "machine": machine}


def cells() -> dict[str, Grid]:
    """Return single cells of all drives and regimes, by what they are."""
    turn = 2.0 * np.pi * np.arange(64) / 64
    ellipse = {"along_amplitude": 0.9, "normal_amplitude": 0.4, "normal_phase": -40.0}
    second = {
        "along_amplitude_2": 0.2,
        "along_phase_2": 30.0,
        "normal_amplitude_2": 0.05,
        "normal_phase_2": 10.0,
    }
    harmonics, high = {**ellipse, **second}, {"normal_amplitude": 1.45}
    chains = {
        "along_amplitude": 6.41, "normal_amplitude": 3.31, "normal_phase": -78.7, "along_amplitude_2": 1.4,
        "along_phase_2": 108.0, "normal_amplitude_2": 0.225, "normal_phase_2": -121.0, "frequency": 12.0,
        "static_friction": 0.47, "kinetic_friction": 0.31,
    }  # fmt: skip
    pull = {"along_amplitude": 20.0, "along_amplitude_2": 5.0, "along_phase_2": -110.0, "frequency": 2.5}
    slow = {"frequency": 2.5, "static_friction": 0.3, "kinetic_friction": 0.25}
    saw = Motion.steps(along=[(0.8, 6.9), (0.2, -27.6)])
    two_way = Motion.steps(along=[(0.5, 9.0), (0.5, -9.0)], normal=[(0.25, -4.2), (0.75, 1.4)])
    along = 9.0 * np.sin(turn) + 2.0 * np.cos(2.0 * turn)
    shaken = Motion.samples(along=along, normal=5.0 * np.sin(turn + 0.5))
    moved = Motion.samples(along=1e-4 * along, normal=5e-4 * np.sin(turn + 0.5), of="displacement")
    return {
        "nut": cell(),
        "without length": cell(None, None),
        "another length": cell(None, 1234.5),
        "resting": cell(amplitude=0.3),
        "both ways": cell(amplitude=1.3),
        "continuous": cell(amplitude=2.0),
        "hopping": cell(amplitude=4.0),
        "hopping high": cell(amplitude=7.0),
        "hopping higher": cell(amplitude=12.0),
        "bouncing": cell(amplitude=4.0, restitution=0.3),
        "bouncing high": cell(amplitude=4.5, restitution=0.5),
        "bouncing beside irregular motion": cell(amplitude=5.0, restitution=0.6),
        "irregular": cell(amplitude=6.3, restitution=0.6),
        "uphill": cell(trough_angle=6.0, amplitude=1.5),
        "downhill": cell(trough_angle=-10.0),
        "backwards": cell(trough_angle=20.0, amplitude=2.1, static_friction=0.5, kinetic_friction=0.4),
        "runaway": cell(trough_angle=-31.0),
        "on the moon": cell(gravity=1.62, amplitude=0.25),
        "flat": cell(drive_angle=0.0),
        "at the onset": cell(amplitude=0.6852),
        "slow": cell(frequency=5.0, amplitude=10.0),
        "fast": cell(frequency=100.0, amplitude=0.05, drive_angle=30.0),
        "equal frictions": cell(kinetic_friction=0.74),
        "tie": cell(amplitude=1.03125, frequency=16.0),
        "ellipse": cell(**ellipse),
        "ellipse backwards": cell(**{**ellipse, "normal_phase": 140.0}),
        "ellipse hopping": cell(**{**ellipse, **high}),
        "ellipse bouncing": cell(restitution=0.3, **{**ellipse, **high}),
        "harmonics": cell(**harmonics),
        "harmonics uphill": cell(trough_angle=3.0, **harmonics),
        "harmonics hopping": cell(**{**harmonics, **high}),
        "harmonics bouncing": cell(restitution=0.3, **{**harmonics, **high}),
        "harmonics with chains of bounces": cell(restitution=0.3, **chains),
        "clamped": cell(normal_acceleration=3.0, along_phase=0.0, **{**pull, **slow}),
        "steps": cell(saw, motion_scale=1.0),
        "steps slow": cell(saw, motion_scale=0.5, **slow),
        "steps clamped": cell(saw, motion_scale=1.0, normal_acceleration=5.0, frequency=4.0),
        "steps both ways": cell(two_way, motion_scale=1.2),
        "steps hopping": cell(two_way, motion_scale=3.2),
        "samples": cell(shaken, motion_scale=1.0),
        "samples hopping": cell(shaken, motion_scale=2.4, restitution=0.3),
        "displacements": cell(moved, motion_scale=1.0),
    }
