"""Scenes by their load, for the tests: what the dimensionless numbers alone decide."""

from __future__ import annotations

import dataclasses
import math
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from hypothesis import strategies as st

from vibro import Scene, SteadyCycle, solve
from vibro.core.drive import Loads, directions, ellipse_loads, ellipse_scale, line_loads, weight_over_load
from vibro.drives import Ellipse, Line
from vibro.results.steady import RESULTS

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import ArrayLike

GRAVITY = 9.81
FIELDS = [result.name for result in RESULTS]
#: The paper's scene by the quantities of a grid, in the user's units.
NUT_POINT = {
    "amplitude": 1.0,
    "frequency": 15.0,
    "drive_angle": 20.0,
    "static_friction": 0.74,
    "kinetic_friction": 0.57,
    "trough_angle": 0.0,
    "gravity": 9.81,
    "restitution": 0.0,
}


class Groups(NamedTuple):
    """What decides a motion up to scale: load G = A w^2 / g, angles [deg], coefficients of friction."""

    load: float
    drive_deg: float
    mu_s: float
    mu_d: float
    trough_deg: float = 0.0


def at_load(
    load: ArrayLike,
    drive_deg: ArrayLike,
    mu_s: ArrayLike,
    mu_d: ArrayLike,
    trough_deg: ArrayLike = 0.0,
    frequency: ArrayLike = 15.0,
) -> Scene:
    """Make scenes whose amplitude gives the load G = A w^2 / g."""
    w = 2.0 * np.pi * np.asarray(frequency, np.float64)
    return Scene(
        amplitude=np.asarray(load, np.float64) * GRAVITY / w**2,
        frequency=frequency,
        drive_angle=np.radians(drive_deg),
        static_friction=mu_s,
        kinetic_friction=mu_d,
        trough_angle=np.radians(trough_deg),
        gravity=GRAVITY,
    )


def driven(groups: Groups, phase_deg: float | None, restitution: float = 0.0) -> Scene:
    """Make the scene of a line, or with a phase that of the ellipse whose amplitudes are the line's."""
    line = replaced(at_load(*groups), restitution=restitution)
    if phase_deg is None:
        return line
    rest = line.arrays()._asdict()
    size, angle = rest.pop("amplitude"), rest.pop("drive_angle")
    return Scene(
        along_amplitude=size * math.cos(angle),
        normal_amplitude=size * math.sin(angle),
        normal_phase=math.radians(phase_deg),
        **rest,
    )


def loads_of(scene: Scene) -> list[Loads]:
    """Form the groups of scenes, one by one over the flattened grid."""
    found, fields = [], scene.flat()
    if isinstance(fields, Line):
        for a, f, alpha, mu_s, mu_d, beta, g, _ in zip(*(x.tolist() for x in fields), strict=True):
            found.append(line_loads(weight_over_load(a, f, g), directions(alpha, beta), mu_s, mu_d))
    elif isinstance(fields, Ellipse):
        for x, y, phase, f, mu_s, mu_d, beta, g, _ in zip(*(x.tolist() for x in fields), strict=True):
            scale = ellipse_scale(x, y)
            weight, angles = weight_over_load(scale, f, g), directions(phase, beta)
            found.append(ellipse_loads(x / scale, y / scale, weight, angles, mu_s, mu_d))
    return found


def line_of(scene: Scene) -> Line:
    """Return the fields of scenes whose drives move along lines."""
    fields = scene.arrays()
    assert isinstance(fields, Line)
    return fields


def random_scenes(count: int, seed: int, *, most_trough_deg: float = 0.0, least_ratio: float = 0.4) -> Scene:
    """Draw contact scenes that can rest: loads from before any slip to the hop, log-uniform."""
    random = np.random.default_rng(seed)
    mu_s = random.uniform(0.1, 1.0, count)
    drive = random.uniform(2.0, 45.0, count)
    steepest = np.minimum(most_trough_deg, 0.95 * np.degrees(np.arctan(mu_s)))
    trough = random.uniform(-1.0, 1.0, count) * steepest
    hop = np.cos(np.radians(trough)) / np.sin(np.radians(drive))
    load = np.exp(random.uniform(np.log(0.05), np.log(0.999 * hop)))
    return at_load(load, drive, mu_s, mu_s * random.uniform(least_ratio, 1.0, count), trough)


def solve_one(groups: Groups) -> SteadyCycle:
    """Solve the scene of some groups."""
    return solve(at_load(*groups))


def scene_with(**values: ArrayLike) -> Scene:
    """Change some values of the published example."""
    example: dict[str, ArrayLike] = {
        "amplitude": 1e-3,
        "frequency": 15.0,
        "drive_angle": math.radians(20.0),
        "static_friction": 0.74,
        "kinetic_friction": 0.57,
    }
    return Scene(**(example | values))


def replaced(scene: Scene, **values: ArrayLike) -> Scene:
    """Change some fields of scenes."""
    fields = {f.name: getattr(scene, f.name) for f in dataclasses.fields(Scene)}
    return Scene(**(fields | values))


@st.composite
def contact_groups(draw: Callable[[st.SearchStrategy[float]], float], least_ratio: float = 0.2) -> Groups:
    """Draw groups of a contact scene on a trough where a body can rest."""
    drive = draw(st.floats(0.0, 60.0))
    mu_s = draw(st.floats(0.02, 1.5))
    mu_d = mu_s * draw(st.floats(least_ratio, 1.0))
    trough = draw(st.floats(-0.95, 0.95)) * min(math.degrees(math.atan(mu_s)), 29.0)
    hop = math.cos(math.radians(trough)) / max(math.sin(math.radians(drive)), 1e-3)
    load = 0.02 * (0.999 * hop / 0.02) ** draw(st.floats(0.0, 1.0))
    return Groups(load, drive, mu_s, mu_d, trough)


def assert_same(left: SteadyCycle, right: SteadyCycle, *, names: list[str] = FIELDS) -> None:
    """Compare two answers bit by bit."""
    for name in names:
        a, b = getattr(left, name), getattr(right, name)
        assert np.array_equal(a, b, equal_nan=np.asarray(a).dtype.kind == "f"), name
