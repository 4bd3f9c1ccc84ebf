"""Check certificates of guarantees: own comparison bodies, own stepping (theory, section 14).

It shares nothing with vibro but the certificate that it is given. The sines of Eq. (66) are the imaginary
part of z exp(i theta): friction adds the normal motion to the arrow z of the motion along the trough.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy import pi

TURN = 2.0 * pi
SLIDES = 4000  # of a body until its cycles repeat
SAME = 1e-13  # [rad] between cycles that repeat


class Push(NamedTuple):
    """``weak sin q - drag`` where sin q > 0, ``strong sin q - drag`` elsewhere, at q = phase + lead."""

    weak: Any
    strong: Any
    lead: Any
    drag: Any

    def window(self) -> Any:
        """Return the middle of the phases at which it pushes, and half their length; NaN where none."""
        opens = self.weak > np.maximum(self.drag, 0.0)
        share = np.divide(self.drag, self.weak, out=np.full(opens.shape, np.nan), where=opens)
        return pi / 2 - self.lead, np.arccos(np.maximum(share, -1.0))

    def integrals(self, q: Any) -> Any:
        """Integrate it from q = 0, once and twice."""
        turns, s = np.divmod(q, TURN)
        more = 2 * (self.weak - self.strong)  # of a turn
        pushed = self.weak * np.array([1 - np.cos(s), s - np.sin(s)])
        late = self.weak * np.array([0 * s + 2, 2 * s - pi])
        late -= self.strong * np.array([1 + np.cos(s), s - pi + np.sin(s)])
        whole = turns * np.array([more + 0 * s, pi * (3 * self.weak - self.strong) + more * s])
        return np.where(s > pi, late, pushed) + whole - self.drag * np.array([q, 0.5 * q * q])

    def slide(self, begin: Any) -> Any:
        """Return length and path of a slide from where it pushes; NaN if it lasts until it pushes again."""
        first, turn = (begin + self.lead) % TURN, np.arcsin(np.clip(self.drag / self.weak, 0.0, 1.0))
        speed, start = self.integrals(first)
        low, high = pi - turn, TURN + turn  # the speed falls between these
        ends = self.integrals(high)[0] <= speed
        for _ in range(51):
            q = 0.5 * (low + high)
            moves = self.integrals(q)[0] > speed
            low, high = np.where(moves, q, low), np.where(moves, high, q)
        path = self.integrals(q)[1] - start - speed * (q - first)
        return np.where(ends, [q - first, path], np.nan)

    def turned(self) -> Push:
        """Return the push on a body that slides back, as that which drives it."""
        return Push(self.strong, self.weak, self.lead - pi, -self.drag)


def _push(ends: Any, sigma: float, mu: Any, way: float) -> Push:
    """Bound pushes on bodies of boxes, over m g times the load and, if that has no 0, X of an ellipse."""
    b = np.vstack([ends["trough_angle"], np.clip(np.arctan2(way, sigma * mu), *ends["trough_angle"])])
    weight = (way * np.sin(b) + sigma * mu * np.cos(b)).max(axis=0)
    if "drive_angle" in ends:
        a = np.vstack([ends["drive_angle"], np.clip(way * sigma * np.arctan(mu), *ends["drive_angle"])])
        arrows = way * np.cos(a) + sigma * mu * np.sin(a)
        weak, strong = arrows.min(axis=0), arrows.max(axis=0)
        middle, mixed = 0.5 * (weak + strong), (weak < 0) & (strong > 0)
        size = np.sort(np.abs(np.where(mixed, middle, [weak, strong])), axis=0)
        drag = weight / np.where(weight > 0, *ends["load"]) + np.where(mixed, 0.5 * (strong - weak), 0.0)
        return Push(size[0], size[1], np.where(middle < 0, pi, 0.0), drag)
    unit = _unit(ends)
    x, y = ends["along_amplitude"] / unit, ends["normal_amplitude"] / unit[::-1]
    chord = 2 * np.sin(0.25 * np.ptp(ends["normal_phase"], axis=0))
    turn, normal = np.exp(1j * ends["normal_phase"].mean(axis=0)), y.mean(axis=0)
    arrow = way * x.mean(axis=0) + sigma * mu * normal * turn
    radius = 0.5 * np.ptp(x, axis=0) + mu * (0.5 * np.ptp(y, axis=0) + chord * normal)
    drag = weight / np.where(weight > 0, *(ends["load"] * unit)) + radius
    return Push(np.abs(arrow), np.abs(arrow), np.angle(arrow), drag)


def _unit(ends: Any) -> Any:
    """Return the amplitude X that pushes are counted in; 1 of a line, or where it is 0 or less than Y."""
    x, y = (ends.get(f"{name}_amplitude", np.ones_like(ends["load"])) for name in ("along", "normal"))
    return np.where((x[0] > 0) & (x[0] >= y[1]), x, 1.0)


def _paths(pushes: Any, rests: Any) -> Any:
    """Follow bodies from rest at phase 0 until a slide starts a turn after the one before; else -inf.

    Forward, then back. A rest ends where static friction lets go and the body is then pushed.
    """
    both, held = (Push(*np.stack(sides, axis=1)) for sides in (pushes, rests))
    (middle, half), (other, wide) = both.window(), held.window()
    other = middle + (other - middle + pi) % TURN - pi
    begins, ends = np.maximum(middle - half, other - wide), np.minimum(middle + half, other + wide)
    ends[~(begins < ends)] = np.nan
    found, phase = np.full(ends.shape[1], -np.inf), np.zeros(ends.shape[1])
    start, path, rows = np.full(ends.shape, np.nan), np.zeros(ends.shape), np.arange(found.size)
    for _ in range(SLIDES):
        turns = np.floor((phase[rows] - ends[:, rows]) / TURN) + 1
        nexts = np.fmin(np.maximum(begins[:, rows] + TURN * turns, phase[rows]), np.inf)
        way, begin = nexts.argmin(axis=0), nexts.min(axis=0)
        rested, repeated = np.isinf(begin), np.abs(begin - start[way, rows] - TURN) < SAME
        found[rows[repeated]], found[rows[rested]] = path[way, rows][repeated], 0.0
        rows, way, begin = (x[~(rested | repeated)] for x in (rows, way, begin))
        start[way, rows], path[way, rows] = begin, 0.0
        length, distance = Push(*(x[way, rows] for x in both)).slide(begin)
        path[:, rows] += np.where(way == 0, distance, -distance)
        phase[rows] = begin + length
        rows = rows[np.isfinite(length)]
        if not rows.size:
            break
    return np.where((both.drag < 0).any(axis=0) | (held.drag <= 0).any(axis=0), -np.inf, found)


def bounds(ends: Any, band: Any, way: float) -> Any:
    """Bound the speeds of the bodies of boxes from below; of those of the other way, and turned [m/s]."""
    ratio, stick, slip = band["friction_ratio"], ends["static_friction"], ends["kinetic_friction"]
    least, most = np.maximum(slip[0], ratio[0] * stick[0]), np.minimum(slip[1], ratio[1] * stick[1])
    loose = np.maximum(stick[0], least / max(ratio[1], 1e-300))
    forward, held = (_push(ends, 1.0, mu, way) for mu in (most, stick[1]))
    behind, freed = (_push(ends, -1.0, mu, way) for mu in (least, loose))
    path = _paths([forward, behind.turned()], [held, freed.turned()])
    load, unit = (np.where(path > 0, *x) for x in (ends["load"], _unit(ends)))
    w = np.sqrt(load * band["gravity"][0] / np.where(path > 0, *band["amplitude"]))
    speed = path * unit * load * band["gravity"][0] / np.clip(w, *(TURN * np.array(band["frequency"]))) / TURN
    return np.where(least > most, np.inf, speed)


def _covered(low: Any, high: Any, whole: Any) -> bool:
    """Whether boxes, rows of ends, cover a whole that was halved again and again."""
    if not len(low) or np.any(np.all((low <= whole[0]) & (high >= whole[1]), axis=1)):
        return len(low) > 0
    middle = whole.mean(axis=0)
    below, above = low < middle, high > middle
    for axis in np.flatnonzero((whole[0] < whole[1]) & ~np.any(below & above, axis=0))[:1]:
        lower, upper = whole.copy(), whole.copy()
        lower[1, axis] = upper[0, axis] = middle[axis]
        parts = (below[:, axis], lower), (above[:, axis], upper)
        return all(_covered(low[rows], high[rows], part) for rows, part in parts)
    return False


def _asked(scene: Any, bands: Any, certificate: Any) -> tuple[Any, Any]:
    """Return ends of the boxes, and of the whole, by the names of the fields."""
    band = {"amplitude": (1.0, 1.0), "friction_ratio": (0.0, 1.0)} | {k: (x, x) for k, x in scene.items()}
    band = {name: np.array(x) for name, x in (band | bands).items()}
    ends = {name: np.array([certificate.low[name], certificate.high[name]]) for name in certificate.low}
    ratio, mu_s, slip = band["friction_ratio"], band["static_friction"], band["kinetic_friction"]
    slip = ratio * mu_s if "friction_ratio" in bands else np.minimum(slip, mu_s[1])
    band["load"] = band["amplitude"] * (TURN * band["frequency"]) ** 2 / band["gravity"]
    band["static_friction"], band["kinetic_friction"] = np.maximum(mu_s, [slip[0], 0.0]), slip
    return ends, band


def least_speeds(scene: Any, bands: Any, certificate: Any, *, fast: bool = False) -> Any:
    """Bound the speeds of the bodies of each box, turned where the fastest counts [m/s]; see ``refusal``."""
    return bounds(*_asked(scene, bands, certificate), -1.0 if fast else 1.0)


def refusal(
    scene: Any, bands: Any, certificate: Any, proved: float, *, fast: bool = False, least: Any = None
) -> str:
    """Return why a certificate does not prove a speed of the slowest, or fastest, body; empty if it does.

    Parameters
    ----------
    scene, bands : mapping
        Fields of the scene [SI], and pairs of those that have a band.
    certificate : vibro.results.designs.Certificate
        Boxes and their bounds.
    proved : float
        The speed [m/s].
    fast : bool
        Whether it is that of the fastest body.
    least : array, optional
        ``least_speeds`` of these boxes, which takes most of the time, if they are known.
    """
    ends, band = _asked(scene, bands, certificate)
    normal = band["normal_amplitude"] if "normal_phase" in ends else np.sin(band["drive_angle"])
    if band["load"][1] * normal[1] > np.cos(band["trough_angle"]).min():
        return "some body hops"
    low, high = np.stack([ends[name] for name in ends], axis=-1)
    if not _covered(low, high, np.stack([band[name] for name in ends], axis=-1)):
        return "the boxes do not cover the set"
    side = -1.0 if fast else 1.0
    slack = 1e-9 * TURN * (band["frequency"] * band["amplitude"] * band.get("along_amplitude", 1.0))[1]
    known = bounds(ends, band, side) if least is None else least
    if not np.all(side * certificate.bound <= known + slack):
        return "a box has bodies beyond its bound"
    return "" if side * proved == np.min(side * certificate.bound) else "the bounds prove another speed"
