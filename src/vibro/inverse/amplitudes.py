"""Which amplitudes guarantee a speed: ``vibro.feasible_amplitudes``."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from vibro.core.codes import Regime
from vibro.errors import InputError, shown
from vibro.inverse.bands import line_box_of
from vibro.inverse.bodies import Bodies
from vibro.inverse.caps import onset_load, regime_loads
from vibro.inverse.extremes import ANY_LANDING, SEEDS, Extreme, Landings, Seen, corners
from vibro.inverse.guarantees import bound
from vibro.inverse.scans import BEYOND, Detail, Scan
from vibro.reals import NotRealError, real_number
from vibro.results.designs import Interval

if TYPE_CHECKING:
    from collections.abc import Mapping

    from numpy.typing import NDArray

    from vibro.inverse.boxes import Box
    from vibro.scene import Scene

    Floats = NDArray[np.float64]

__all__ = ["Family", "feasible_amplitudes", "number", "positive", "regime_of"]

# Of one body, of a box of them, and where they hop, with plastic impacts and others, which take long.
_ONE: Final = Detail(4097, 3, 0.0, 0, 0, 0.0)
_BOX: Final = Detail(257, 3, 0.0, 6, 5, 1e-10)
_FLYING: Final = Detail(129, 1, 1e-9, 2, 2, 1e-4)
_BOUNCING: Final = Detail(33, 0, 1e-4, 1, 1, 1e-2)
_BESIDE: Final = 1e-12  # [1] below a load that is not to be exceeded
_HOLDS: Final = 1e-9  # of the speed, by which a search may find less than the bodies at hand
_BEYOND_EDGE: Final = 1e-8  # relative distance from there at which a jump of the speed has happened
_JUMP_BETWEEN: Final = 1e-4  # of the speed, that is a jump over this distance
_DRIFTS: Final = np.linspace(0.0, 1.0, 5)  # shares of the drift in load, for every body that was found worst


def regime_of(text: object) -> Regime:
    """Read the highest regime that is allowed."""
    allowed = {r.label: r for r in (Regime.FORWARD_SLIP, Regime.BACK_SLIP, Regime.HOPPING)}
    if not isinstance(text, str) or text not in allowed:
        raise InputError(f"highest_regime = {shown(text)}: must be one of {', '.join(allowed)}")
    return allowed[text]


def number(name: str, value: Any) -> float:
    """Read a number that is an argument."""
    try:
        return real_number(value)
    except NotRealError as exc:
        raise InputError(f"{name} = {exc.value}: must be {exc.allowed}") from None


def positive(name: str, value: Any, unit: str, *, finite: bool = True) -> float:
    """Read a positive number that is an argument."""
    x = number(name, value)
    if not x > 0.0 or (finite and math.isinf(x)):
        allowed = f"finite and > 0 {unit}" if finite else f"> 0 {unit}"
        raise InputError(f"{name} = {x:.15g} {unit}: must be {allowed}")
    return x


def feasible_amplitudes(
    scene: Scene,
    speed: float,
    *,
    highest_regime: str = "back-slip",
    limit: float = math.inf,
    amplitude_percent: float = 0.0,
    **bands: Any,
) -> list[Interval]:
    """Nominal amplitudes that guarantee a speed over a box of bands.

    Parameters
    ----------
    scene : Scene
        One operating point; its own amplitude is ignored.
    speed : float
        Least mean speed, > 0 [m/s].
    highest_regime : {"back-slip", "forward-slip", "hopping"}, optional
        Highest regime that may occur anywhere in the box.
    limit : float, optional
        Largest nominal amplitude [m]; it must be finite where bodies may hop.
    amplitude_percent : float, optional
        By how much the amplitude may be off its nominal value either way, in per cent of it.
    **bands
        As for ``vibro.guarantee``, but for the amplitude.

    Returns
    -------
    list of Interval
        Closed intervals by rising amplitude [m], with what ends each below and above; empty where no
        amplitude does it.

    Raises
    ------
    SceneError, InputError
        If the scene is more than one operating point, or an argument cannot be.

    Notes
    -----
    The least speed over the box is followed over the amplitude through every critical load and between its
    extrema, and crossings are found to rounding. What it is over the box, ``vibro.guarantee`` confirms for
    whole intervals; bodies that it finds slower are followed too.

    Examples
    --------
    >>> import math, vibro
    >>> scene = vibro.Scene(amplitude=1e-3, frequency=15, drive_angle=math.radians(20),
    ...                     static_friction=0.74, kinetic_friction=0.57)
    >>> for i in vibro.feasible_amplitudes(scene, 0.02815):
    ...     print(f"{1e3 * i.low:.6f} to {1e3 * i.high:.6f} mm, from {i.low_set_by} to {i.high_set_by}")
    1.177843 to 1.190299 mm, from speed to back slip
    1.233006 to 3.229052 mm, from speed to hop
    """
    highest = regime_of(highest_regime)
    target = positive("speed", speed, "m/s")
    largest = positive("limit", limit, "m", finite=False)
    percent = number("amplitude_percent", amplitude_percent)
    if not 0.0 <= percent < 100.0:
        raise InputError(f"amplitude_percent = {percent:.15g}: must be in [0, 100)")
    if highest is Regime.HOPPING and math.isinf(largest):
        raise InputError("limit = inf: must be finite where bodies may hop", hint="give limit=")
    box = line_box_of(scene, bands, leaves_out="amplitude")
    family = Family(replace(box, amplitude=(1.0, 1.0)), percent / 100.0)
    return family.intervals(target, highest, largest)


@dataclass(frozen=True)
class Family:
    """Boxes that differ by their nominal amplitude alone.

    Attributes
    ----------
    template : Box
        With any amplitude.
    drift : float
        By how much the amplitude may be off, relative to the nominal one.
    landings : Landings
        What landings may be at most.
    """

    template: Box
    drift: float
    landings: Landings = ANY_LANDING

    def boxes(self, amplitudes: Floats) -> Box:
        """Return the boxes of nominal amplitudes, which have the shape (m, 1)."""
        return replace(
            self.template, amplitude=(amplitudes * (1.0 - self.drift), amplitudes * (1.0 + self.drift))
        )

    def across(self, low: float, high: float) -> Box:
        """Return the box of all that these nominal amplitudes bring."""
        return replace(self.template, amplitude=(low * (1.0 - self.drift), high * (1.0 + self.drift)))

    def amplitude_of(self, load: float, *, most: bool) -> float:
        """Nominal amplitude at which the most, or the least, load of the box is this one."""
        frequency = self.template.frequency[1 if most else 0]
        drift = 1.0 + self.drift if most else 1.0 - self.drift
        return load * self.template.gravity / (2.0 * math.pi * float(frequency)) ** 2 / drift

    def caps(self, highest: Regime, largest: float, others: Mapping[str, float]) -> dict[str, float]:
        """Nominal amplitudes up to which a box keeps to a regime, by what ends there; or to other loads."""
        regimes = {name: float(load) for name, load in regime_loads(self.template, highest).items()}
        loads = {**others, **regimes}
        # so that its rounding brings no body over it
        caps = {name: self.amplitude_of(load, most=True) * (1.0 - _BESIDE) for name, load in loads.items()}
        return {**caps, "limit": largest}

    def intervals(
        self,
        target: float,
        highest: Regime,
        largest: float,
        others: Mapping[str, float] | None = None,
        near: float | None = None,
    ) -> list[Interval]:
        """Return the nominal amplitudes that guarantee a speed; arguments as for ``caps`` and ``Scan``."""
        caps = self.caps(highest, largest, others or {})
        top_by = min(caps, key=lambda name: caps[name])
        top = caps[top_by]
        start = self.amplitude_of(float(onset_load(self.template)), most=False)
        wide = bool(self.across(1.0, 1.0).varies.any())
        flies = highest is Regime.HOPPING
        bounces = flies and self.template.restitution > 0.0
        if wide:
            detail = _BOUNCING if bounces else _FLYING if flies else _BOX
        else:
            detail = _FLYING if bounces else _ONE
        bodies = Bodies.staying(corners(self.across(1.0, 1.0)))
        endless = math.isinf(top)  # bodies that never hop are followed to where all has begun
        if endless:
            criticals = Scan(self.boxes, bodies, target, None).criticals()
            top, top_by = BEYOND * max([start, *criticals]), "limit"
        found: list[Interval] = []
        missing: list[bool] = []
        for _ in range(max(detail.exchanges, 1)):
            scan = Scan(self.boxes, bodies, target, self.landings if flies else None)
            found = scan.intervals(start, top, top_by, detail, near)
            missing = []
            for interval in found:
                worse = self._with_worse(bodies, interval, target) if wide else None
                missing.append(worse is not None)
                bodies = worse or bodies
            if not any(missing):
                break
        found = [
            part
            for interval, misses in zip(found, missing, strict=True)
            for part in (self._confirmed(interval, target, detail) if misses else [interval])
        ]
        return [i._replace(high=math.inf) if endless and i.high == top else i for i in found]

    def _with_worse(self, bodies: Bodies, interval: Interval, target: float) -> Bodies | None:
        """Add bodies that miss the target in an interval; None where none does."""
        slowest, landing = self._slowest(interval.low, interval.high)
        is_slow = slowest.speed < target * (1.0 - _HOLDS)
        if not is_slow and not landing.size:
            return None
        shares = np.hstack([landing, slowest.shares]) if is_slow else landing
        # the amplitude at which it was found, and how far it drifts there
        load = float(np.ravel(slowest.scene.load)[0])
        middle = 2.0 / sum(float(end) for end in self.across(1.0, 1.0).load)
        amplitude = min(max(load * middle, interval.low), interval.high)
        box = self.across(amplitude, amplitude)
        low, high = (float(end) for end in box.load)
        if low < high:
            drifts = np.append(_DRIFTS, min(max((load - low) / (high - low), 0.0), 1.0))
            count = shares.shape[1]
            shares = np.repeat(shares, drifts.size, axis=1)
            shares[0] = np.tile(drifts, count)
        else:
            shares[0] = 0.0
        return bodies.joined(box, shares)

    def _slowest(self, low: float, high: float, seeds: int = SEEDS) -> tuple[Extreme, Floats]:
        """Return the slowest body between two amplitudes, and those that land too hard or fly too long."""
        box = self.across(low, high)
        return bound(box, fast=False, seen=Seen(), seeds=seeds).extreme, self.landings.worst(box)

    def _holds(self, low: float, high: float, target: float, seeds: int = SEEDS) -> bool:
        """Tell whether all amplitudes between two guarantee a speed."""
        slowest, landing = self._slowest(low, high, seeds)
        return slowest.speed >= target * (1.0 - _HOLDS) and not landing.size

    def _confirmed(self, interval: Interval, target: float, detail: Detail) -> list[Interval]:
        """Return the parts of an interval that guarantee a speed, where the slowest bodies differ everywhere.

        Every amplitude is asked for its own slowest body; parts that are not confirmed as a whole are halved,
        and given up when they are short.
        """
        low, high = interval.low, interval.high
        parts: list[tuple[float, float]] = []
        for part in self._parts(low, high, self._at(low, target), self._at(high, target), target, detail):
            if parts and parts[-1][1] == part[0]:  # halves of one
                part = parts.pop()[0], part[1]
            parts.append(part)
        return [
            Interval(
                a,
                b,
                interval.low_set_by if a == low else self.ends_by(a, a * (1.0 - _BEYOND_EDGE)),
                interval.high_set_by if b == high else self.ends_by(b, b * (1.0 + _BEYOND_EDGE)),
            )
            for a, b in parts
        ]

    def _parts(
        self, low: float, high: float, holds_low: bool, holds_high: bool, target: float, detail: Detail
    ) -> list[tuple[float, float]]:
        """Return confirmed parts between two amplitudes of which it is known whether they hold."""
        if holds_low and holds_high and self._holds(low, high, target):
            return [(low, high)]
        if holds_low != holds_high:
            edge = (
                self._edge(low, high, target, detail.edge)
                if holds_low
                else self._edge(high, low, target, detail.edge)
            )
            inner = (low, edge) if holds_low else (edge, high)
            return self._parts(*inner, True, True, target, detail)
        if not detail.halves:
            return []
        detail = detail._replace(halves=detail.halves - 1)
        middle = math.sqrt(low * high)
        holds = self._at(middle, target)
        lower = self._parts(low, middle, holds_low, holds, target, detail)
        return lower + self._parts(middle, high, holds, holds_high, target, detail)

    def _at(self, amplitude: float, target: float) -> bool:
        return self._holds(amplitude, amplitude, target, seeds=1)

    def _edge(self, inside: float, outside: float, target: float, width: float) -> float:
        """Close in on the last amplitude that holds before one that does not."""
        while abs(outside - inside) > width * inside:
            middle = 0.5 * (inside + outside)
            inside, outside = (middle, outside) if self._at(middle, target) else (inside, middle)
        return inside

    def ends_by(self, inside: float, outside: float) -> str:
        """Tell whether the least speed jumps between two amplitudes, which it does where back slip enters."""
        here, there = (self._slowest(a, a)[0].speed for a in (inside, outside))
        if there >= here * (1.0 - _JUMP_BETWEEN):
            return "speed"
        return "onset" if outside < inside else "back slip"
