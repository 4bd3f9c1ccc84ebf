"""Scenes where floating point is weakest, drawn at random: what stress.py and its tests are run on."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

import vibro
from vibro.quantities import POSITIVE, QUANTITIES, SHAKEN

Floats = NDArray[np.float64]
Fields = dict[str, Floats]

EPS: Final = 2.0**-52
SMALLEST: Final = 5e-324
LARGEST: Final = 1.7e308
#: Kinds of drive that ``corners_of`` knows.
KINDS: Final = ("line", "ellipse", "harmonics", "steps", "samples")
_RIGHT_ANGLE: Final = 0.5 * np.pi


def extreme_fields(n: int, seed: int) -> Fields:
    """Draw scenes, most of them within reach of slipping, as fields of ``vibro.Scene``."""
    rng = np.random.default_rng(seed)

    def pick(*choices: tuple[float, Callable[[], Any]]) -> Floats:
        shares = np.array([share for share, _ in choices])
        which = rng.choice(len(choices), n, p=shares / shares.sum())
        return np.array(np.choose(which, [np.broadcast_to(make(), n) for _, make in choices]), np.float64)

    def decades(low: float, high: float) -> Floats:
        return np.asarray(10.0 ** rng.uniform(low, high, n), np.float64)

    def ulps(most: int = 8) -> Floats:
        return np.asarray(rng.integers(-most, most + 1, n) * EPS, np.float64)

    sign = rng.choice((-1.0, 1.0), n)
    alpha = pick(
        (50, lambda: rng.uniform(0.0, _RIGHT_ANGLE, n)),
        (15, lambda: decades(-12, 0)),
        (8, lambda: 0.0),
        (7, lambda: 1e-300),
        (10, lambda: np.nextafter(_RIGHT_ANGLE, 0.0)),
        (10, lambda: _RIGHT_ANGLE - decades(-15.5, -1)),
    )
    mu_s = pick(
        (3, lambda: 0.0),
        (40, lambda: decades(-12, 1)),
        (50, lambda: rng.uniform(0.05, 1.5, n)),
        (3, lambda: decades(-320, -100)),
        (4, lambda: 10.0),
    )
    ratio = pick(
        (5, lambda: 0.0),
        (15, lambda: 1.0),
        (5, lambda: 1.0 - 1e-15),
        (15, lambda: decades(-15, 0)),
        (15, lambda: 1.0 - decades(-15, 0)),
        (45, lambda: rng.uniform(0.0, 1.0, n)),
    )
    mu_d = np.minimum(mu_s * ratio, mu_s)
    beta = pick(
        (50, lambda: 0.0),
        (15, lambda: rng.uniform(-1.0, 1.0, n) * np.arctan(mu_s)),
        (5, lambda: sign * np.arctan(mu_s) * (1.0 + ulps())),
        (5, lambda: sign * np.arctan(mu_d) * (1.0 + ulps())),
        (8, lambda: sign * decades(-300, -1)),
        (8, lambda: rng.uniform(-_RIGHT_ANGLE, _RIGHT_ANGLE, n)),
        (4, lambda: sign * np.nextafter(_RIGHT_ANGLE, 0.0)),
        (5, lambda: (_RIGHT_ANGLE - alpha) * (1.0 - rng.integers(0, 8, n) * EPS)),
    )
    beta = np.clip(beta, -np.nextafter(_RIGHT_ANGLE, 0.0), np.nextafter(_RIGHT_ANGLE, 0.0))
    beta = np.where(alpha + beta < _RIGHT_ANGLE, beta, -np.abs(beta))
    gravity = pick((95, lambda: 9.81), (5, lambda: decades(-12, 12)))
    frequency = pick(
        (5, lambda: 15.0),
        (90, lambda: 15.0 * decades(-3, 6)),
        (5, lambda: decades(-12, 12)),
    )
    load = _loads_near_thresholds(rng, alpha, mu_s, beta, pick, decades)
    load *= 1.0 + pick((20, lambda: 0.0), (40, ulps), (40, lambda: sign * decades(-16, -1)))
    with np.errstate(all="ignore"):
        w = 2.0 * np.pi * frequency
        amplitude = np.nan_to_num((load / w) * (gravity / w), nan=1.0, posinf=1.0)
    wild, ends = rng.random(n) < 0.1, {name: ends_of(name) for name in ("amplitude", "frequency", "gravity")}
    amplitude = np.where(
        wild, pick((80, lambda: 1e-3 * decades(-12, 12)), (20, lambda: decades(-15, 6))), amplitude
    )
    frequency = np.where(
        wild, pick((80, lambda: 15.0 * decades(-12, 12)), (20, lambda: decades(-12, 12))), frequency
    )
    for name in ends:  # some at the limits, and beside them
        ends[name] = [*ends[name], *np.nextafter(ends[name], ends[name][::-1])]
    amplitude = np.where(rng.random(n) < 0.01, rng.choice(ends["amplitude"], n), amplitude)
    frequency = np.where(rng.random(n) < 0.01, rng.choice(ends["frequency"], n), frequency)
    gravity = np.where(rng.random(n) < 0.01, rng.choice(ends["gravity"], n), gravity)
    restitution = pick((80, lambda: 0.0), (20, lambda: rng.uniform(0.0, 1.0, n)))
    return {
        "amplitude": np.clip(amplitude, min(ends["amplitude"]), max(ends["amplitude"])),
        "frequency": np.clip(frequency, min(ends["frequency"]), max(ends["frequency"])),
        "drive_angle": alpha,
        "static_friction": mu_s,
        "kinetic_friction": mu_d,
        "trough_angle": beta,
        "gravity": gravity,
        "restitution": restitution,
    }


def _loads_near_thresholds(
    rng: np.random.Generator,
    alpha: Floats,
    mu_s: Floats,
    beta: Floats,
    pick: Callable[..., Floats],
    decades: Callable[[float, float], Floats],
) -> Floats:
    """G at a threshold, or between the first slip and the hop; any where there is none."""
    n = alpha.size
    along, across, normal, tangential = np.cos(alpha), np.sin(alpha), np.cos(beta), np.sin(beta)
    with np.errstate(all="ignore"):
        hop = normal / across
        forward = (mu_s * normal + tangential) / (along + mu_s * across)
        back = (mu_s * normal - tangential) / (along - mu_s * across)
        first = np.fmin(np.where(forward > 0.0, forward, np.inf), np.where(back > 0.0, back, np.inf))
        between = first * (np.fmin(hop, 1e6 * first) / first) ** rng.uniform(0.0, 1.0, n)
        load = pick(
            (12, lambda: hop),
            (12, lambda: forward),
            (12, lambda: back),
            (10, lambda: first * decades(-1, 2)),
            (54, lambda: between),
        )
    return np.where(np.isfinite(load) & (load > 0.0), load, decades(-3, 3))


# ------------------------------------------------------------------------------- corners of the allowed box


def ends_of(name: str, *, with_zero: bool = False, with_ulps: bool = False) -> list[float]:
    """Return the least and the largest value of a quantity in SI units; next to an end that is open.

    ``with_ulps`` adds their neighbours inside, ``with_zero`` 0.
    """
    quantity = QUANTITIES[name]
    allowed = quantity.allowed
    low, high = float(quantity.to_si(allowed.low)), float(quantity.to_si(allowed.high))
    low = low if allowed.with_low else float(np.nextafter(low, high))
    high = high if allowed.with_high else float(np.nextafter(high, low))
    inside = [float(np.nextafter(low, high)), float(np.nextafter(high, low))]
    return [low, high, *([0.0] if with_zero else []), *(inside if with_ulps else [])]


def corners_of(kind: str, *, with_ulps: bool = False) -> Iterator[vibro.Scene]:
    """Yield grids of scenes at the corners of the box of all that a kind of drive may be."""

    def ends(name: str) -> list[float]:
        return ends_of(name, with_ulps=with_ulps)

    least, most = ends_of("amplitude")
    near, far = ends_of("normal_phase")
    common = {
        "static_friction": [0.0, SMALLEST, 0.5, *ends("static_friction")[1:]],
        "ratio": [0.0, 0.5, 1.0],
        "trough_angle": ends_of("trough_angle", with_zero=True, with_ulps=with_ulps),
        "gravity": ends("gravity"),
        "restitution": ends("restitution"),
        "frequency": ends("frequency"),
    }
    if kind == "line":
        yield _grid({**common, "amplitude": ends("amplitude"), "drive_angle": ends("drive_angle")})
    elif kind == "ellipse":
        sizes = [0.0, SMALLEST, least, most]
        yield _grid(
            {**common, "along_amplitude": sizes, "normal_amplitude": sizes, "normal_phase": [near, 0.0, far]}
        )
    else:
        scales = ends("motion_scale")
        for motion, normal in motions_at_corners(kind, least, most, far):
            fixed: dict[str, Any] = {"motion": motion}
            yield _grid({**common, "motion_scale": scales}, fixed)
            if not normal:
                clamped = {
                    **common,
                    "motion_scale": scales,
                    "normal_acceleration": ends("normal_acceleration"),
                }
                yield _grid(clamped, fixed)


def motions_at_corners(
    kind: str, least: float, most: float, far: float
) -> Iterator[tuple[vibro.Motion, bool]]:
    """Yield motions with extreme members, and whether they move the trough normal to itself."""
    push = float(SHAKEN.to_si(SHAKEN.allowed.high))
    if kind == "harmonics":
        last = [(0.0, 0.0)] * 15 + [(most, far)]
        for along in ([(most, far), (least, -far)], [(least, 0.0), (most, far)], last, [(0.0, 0.0)] * 2):
            for normal in (None, [(SMALLEST, far), (least, 0.0)], [(most, -far), (most, far)], last):
                yield vibro.Motion.harmonics(along, normal), normal is not None
    elif kind == "steps":
        for size in (POSITIVE.low, 1.0, push):
            swing = [(0.5, size), (0.5, -size)]
            brief = [(1e-8, size), (1.0 - 1e-8, -1e-8 * size)]
            for normal in (None, swing, brief):
                yield vibro.Motion.steps(swing, normal), normal is not None
    else:
        rough = np.resize([1.0, -1.0, 0.5, -0.5, 0.0], 16)
        for size in (POSITIVE.low, 1.0, push):
            yield vibro.Motion.samples(size * rough), False
            yield vibro.Motion.samples(size * rough, size * rough[::-1]), True


def _grid(axes: dict[str, list[float]], fixed: dict[str, Any] | None = None) -> vibro.Scene:
    """Return the scenes of all combinations, in one row."""
    values = dict(zip(axes, map(np.ravel, np.meshgrid(*axes.values(), indexing="ij")), strict=True))
    values["kinetic_friction"] = values.pop("ratio") * values["static_friction"]
    return vibro.Scene(**values, **(fixed or {}))


def cells_of(scene: vibro.Scene, count: int, seed: int) -> Iterator[vibro.Scene]:
    """Yield some scenes of a row, as single operating points."""
    random = np.random.default_rng(seed)
    names = [name for name in scene.__dataclass_fields__ if getattr(scene, name) is not None]
    for i in random.integers(0, scene.shape[0], count):
        values: dict[str, Any] = {name: getattr(scene, name) for name in names}
        yield vibro.Scene(**{name: x if name == "motion" else x[i] for name, x in values.items()})
