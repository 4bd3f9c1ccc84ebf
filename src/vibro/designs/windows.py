"""Find the amplitudes that guarantee a speed: ``vibro.feasible_amplitudes``, and the windows of designs.

``_Scan`` computes the least speed of some scenarios over the amplitude. Where it reaches the target,
``Family`` searches whole intervals for slower bodies, which join the scenarios.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, Final, NamedTuple

import numpy as np

from vibro.core.codes import Regime
from vibro.designs.guarantees import ANY_LANDING, BRIEF, Extreme, Landings, Seen, bound, counted, least_of
from vibro.designs.proofs import change_loads, corners, first_ratio, last_ratio, tip_ratio
from vibro.designs.questions import Scenarios, at_loads
from vibro.designs.search import close_in
from vibro.designs.spaces import TOLERANCES, inside, uncertainty_set
from vibro.errors import InputError, Problem, SceneError, shown
from vibro.quantities import AMPLITUDES, SCALE
from vibro.reals import NotRealError, real_number, shielded
from vibro.results.designs import Interval
from vibro.scene import Scene
from vibro.steady import solve

if TYPE_CHECKING:
    from collections.abc import Mapping

    from numpy.typing import NDArray

    from vibro.designs.questions import Question
    from vibro.designs.spaces import AnySetting, Points, UncertaintySet
    from vibro.reals import Floats
    from vibro.results.designs import Guarantee


#: Amplitudes at which a single body that may hop is solved, without and with restitution: bounces take up to
#: a hundred times as long. Its speed jumps with the amplitude, so that more samples find more slivers alone.
HOPS_SAMPLED: Final[Mapping[bool, int]] = {False: 32769, True: 4097}

# Bodies that never hop are scanned up to this factor on the largest critical load, or up to this one on the
# target speed: far beyond the critical loads the speed is proportional to the amplitude.
_BEYOND: Final = 1e3
_FASTER: Final = 2.0
_CLOSER: Final = 33  # amplitudes of each refinement around an extremum of the speed
_STEEP: Final = 100.0  # largest change of a speed that is no jump, over that of the amplitude, both relative
_PAST_EDGE: Final = 1e-8  # relative distance beyond an end at which the speed has jumped


class _Detail(NamedTuple):
    """Sizes and resolutions of a scan.

    Attributes
    ----------
    amplitudes, rounds : int
        Amplitudes of the first grid, and rounds of refinement at extrema between them.
    end : float
        Relative width to which ends are found.
    exchanges, halves : int
        Largest numbers of searches for slower bodies, and of bisections of unconfirmed intervals.
    edge : float
        Relative width to which an end is found by the slowest body of every amplitude.
    """

    amplitudes: int
    rounds: int
    end: float
    exchanges: int
    halves: int
    edge: float


# For one body in contact, and for its hops: between these the speed jumps, and has no smooth extrema.
_ONE: Final = _Detail(4097, 3, 0.0, 0, 0, 0.0)
_ONE_HOPS: Final = {
    bounces: _Detail(count, 0, 1e-5 if bounces else 0.0, 0, 0, 0.0) for bounces, count in HOPS_SAMPLED.items()
}
# For a box in contact, for plastic hops, and for bounces, which are slow to solve.
_BOX: Final = _Detail(257, 3, 0.0, 6, 5, 1e-10)
_FLYING: Final = _Detail(129, 1, 1e-9, 2, 2, 1e-4)
_BOUNCING: Final = _Detail(33, 0, 1e-4, 1, 1, 1e-2)


def _regime_of(text: object) -> Regime:
    """Read the highest regime that is allowed."""
    allowed = {r.label: r for r in (Regime.FORWARD_SLIP, Regime.BACK_SLIP, Regime.HOPPING)}
    if not isinstance(text, str) or text not in allowed:
        raise InputError(f"highest_regime = {shown(text)}: must be one of {', '.join(allowed)}")
    return allowed[text]


def _number(name: str, value: Any) -> float:
    """Read a number that is an argument."""
    try:
        return real_number(value)
    except NotRealError as exc:
        raise InputError(f"{name} = {exc.value}: must be {exc.allowed}") from None


def _positive(name: str, value: Any, unit: str, *, finite: bool = True) -> float:
    """Read a positive number that is an argument."""
    x = _number(name, value)
    if not x > 0.0 or (finite and math.isinf(x)):
        allowed = f"finite and > 0 {unit}" if finite else f"> 0 {unit}"
        raise InputError(f"{name} = {f'{x:.15g} {unit}'.rstrip()}: must be {allowed.rstrip()}")
    return x


@shielded
def feasible_amplitudes(
    scene: Scene,
    speed: float,
    *,
    highest_regime: str = "back-slip",
    limit: float = math.inf,
    amplitude_percent: float = 0.0,
    **bands: Any,
) -> list[Interval]:
    """Return the nominal amplitudes that guarantee a speed over a box of bands.

    Parameters
    ----------
    scene : Scene
        One operating point. Its amplitude is ignored, so any number will do; of an ellipse the proportion of
        both amplitudes is kept.
    speed : float
        Least mean speed, > 0 [m/s].
    highest_regime : {"back-slip", "forward-slip", "hopping"}, optional
        Highest regime that may occur anywhere in the box.
    limit : float, optional
        Largest nominal amplitude [m], or scale of a motion [1]; it must be finite if bodies may hop.
    amplitude_percent : float, optional
        Drift of the amplitude from its nominal value, up and down, in per cent; both amplitudes of an ellipse
        drift together.
    **bands
        As for ``vibro.guarantee``, except amplitudes.

    Returns
    -------
    list of Interval
        Closed intervals of the amplitude [m], ascending, with the constraint at each end: of the amplitude of
        a line; of an ellipse ``along_amplitude``, or ``normal_amplitude`` if that is 0; of another motion
        ``motion_scale`` [1]. Empty if no amplitude guarantees the speed, whatever the reason. To see what a
        part reaches without hopping, solve the scene at amplitudes up to hop g / w^2, where
        ``hop = vibro.critical_loads(scene).hop``.

    Raises
    ------
    SceneError
        If the scene is more than one operating point, both amplitudes of an ellipse are 0, or a band is
        invalid.
    InputError
        If another argument is invalid.

    Notes
    -----
    The least speed of a few scenarios is computed as a function of the amplitude, with all its critical loads
    and extrema; where it crosses the target is found to rounding. ``vibro.guarantee`` then checks whole
    intervals, and slower bodies that it finds are added to the scenarios.

    The speed of hopping bodies jumps as the amplitude changes, and for irregular motion it does so
    everywhere. A single body is solved at 32769 amplitudes, or at 4097 if it bounces, and ends are found to
    1e-5; intervals or gaps between two of these amplitudes may be missed. Three standard errors are
    subtracted from a mean of irregular motion. With ``highest_regime="forward-slip"`` an interval ends where
    back slip first begins, even if back slip ends again at larger amplitudes.

    Examples
    --------
    >>> import math, vibro
    >>> scene = vibro.Scene(amplitude=1e-3, frequency=15, drive_angle=math.radians(20),
    ...                     static_friction=0.74, kinetic_friction=0.57)
    >>> for i in vibro.feasible_amplitudes(scene, 0.02815):
    ...     print(f"{1e3 * i.low:.6f} to {1e3 * i.high:.6f} mm, from {i.low_set_by} to {i.high_set_by}")
    1.177843 to 1.190299 mm, from speed to back slip
    1.233006 to 3.229052 mm, from speed to hop

    An ellipse keeps the proportion of its amplitudes, here 3 to 1:

    >>> bowl = vibro.Scene(along_amplitude=3e-3, normal_amplitude=1e-3, normal_phase=math.radians(-60),
    ...                    frequency=25, static_friction=0.4, kinetic_friction=0.3)
    >>> for i in vibro.feasible_amplitudes(bowl, 0.02):
    ...     print(f"{1e3 * i.low:.6f} to {1e3 * i.high:.6f} mm along, from {i.low_set_by} to {i.high_set_by}")
    0.428533 to 1.192753 mm along, from speed to hop
    """
    highest = _regime_of(highest_regime)
    target = _positive("speed", speed, "m/s")
    unit = "m" if getattr(scene, "motion", None) is None else ""
    largest = _positive("limit", limit, unit, finite=False)
    percent = _number("amplitude_percent", amplitude_percent)
    if not 0.0 <= percent < 100.0:
        raise InputError(f"amplitude_percent = {percent:.15g}: must be in [0, 100)")
    if highest is Regime.HOPPING and math.isinf(largest):
        raise InputError("limit = inf: must be finite where bodies may hop", hint="give limit=")
    box = _of_amplitudes(uncertainty_set(scene, bands, leaves_out=(*AMPLITUDES, SCALE)))
    return Family(box, percent / 100.0).intervals(target, highest, largest)


def _of_amplitudes(box: UncertaintySet) -> UncertaintySet:
    """Return the box of a factor that is the amplitude [m]: of an ellipse along the trough, or normal to it.

    Raises
    ------
    SceneError
        If both amplitudes of an ellipse are 0.
    """
    given = {name: ends[0] for name, ends in box.shape.items() if name in AMPLITUDES}
    size = next(filter(None, given.values()), 1.0)
    if given and not any(given.values()):
        raise SceneError(tuple(Problem(name, "0 m", "> 0 m, or the other amplitude is") for name in given))
    shares = {name: (x / size, x / size) for name, x in given.items()}
    return replace(box, factor=(1.0, 1.0), shape={**box.shape, **shares})


def span_of(question: Question, setting: AnySetting) -> tuple[float, float]:
    """Return the smallest and largest amplitude of the drive in the proportions of a setting [m]."""
    space, turned = question.space, question.space.turned(setting)
    amplitude = float(space.amplitude(setting))
    shares = [
        [end / float(turned[knob]) for end in question.drive.span(knob)]
        for knob in space.sizes
        if turned[knob] > 0.0
    ]
    return max(low for low, _ in shares) * amplitude, min(high for _, high in shares) * amplitude


def window_of(question: Question, setting: AnySetting, guarantee: Guarantee) -> Interval | None:
    """Return the interval of amplitudes around a design that guarantee the target, in its proportions."""
    space, target = question.space, question.spec.goal.speed
    if guarantee.speed_min < target:
        return None
    amplitude = float(space.amplitude(setting))
    least, most = span_of(question, setting)
    most = min(most, amplitude * question.drive.acceleration / float(question.load(setting)))
    box = question.box(setting)
    unit = amplitude / (sum(box.factor) / 2.0)  # amplitude where the factor is 1
    family = Family(replace(box, factor=(1.0, 1.0)), question.drift.amplitude, question.landings)
    one = family.across(1.0, 1.0)
    tips = tip_ratio(one, question.spec.stand_ratio)
    if question.flies and math.isfinite(question.spec.stand_ratio):  # tipping at landings is not modelled
        tips = max(tips, first_ratio(one, Regime.HOPPING))
    at, others = amplitude / unit, {"tip": 1.0 / tips} if tips else {}
    for i in family.intervals(target, question.highest, most / unit, others, near=at):
        if i.low * (1.0 - TOLERANCES.at) <= at <= i.high * (1.0 + TOLERANCES.at):
            # Where the speed jumps at an end, rounding of units and drifts must not cross it: move inwards.
            inwards = [TOLERANCES.beside * (by != "limit") for by in i[2:]]
            low, high = i.low * unit * (1.0 + inwards[0]), i.high * unit * (1.0 - inwards[1])
            low, by = (low, i.low_set_by) if low >= least else (least, "limit")
            return Interval(min(low, amplitude), max(high, amplitude), by, i.high_set_by)
    # no interval around the design was confirmed: a window of the design alone
    below, above = (family.ends_at(at, at * (1.0 + side * TOLERANCES.at), target) for side in (-1.0, 1.0))
    return Interval(amplitude, amplitude, below, above)


@dataclass(frozen=True)
class Family:
    """Boxes that differ only in their nominal factor: the amplitude of a line, a number of an ellipse.

    Attributes
    ----------
    template : UncertaintySet
        With any factor.
    drift : float
        Largest relative deviation of the factor.
    landings : Landings
        Limits on landings.
    """

    template: UncertaintySet
    drift: float
    landings: Landings = ANY_LANDING

    def boxes(self, factors: Floats) -> UncertaintySet:
        """Return the boxes of nominal factors of shape (m, 1)."""
        return self.across(factors, factors)

    def across(self, low: Any, high: Any) -> UncertaintySet:
        """Return the box of all factors between two nominal ones, with their deviations."""
        return replace(self.template, factor=(low * (1.0 - self.drift), high * (1.0 + self.drift)))

    def caps(self, highest: Regime, largest: float, others: Mapping[str, float]) -> dict[str, float]:
        """Return the largest nominal factor by constraint: regime, limit, and others."""
        one = self.across(1.0, 1.0)
        ratios = {}
        if highest is not Regime.HOPPING:
            ratios["hop"] = first_ratio(one, Regime.HOPPING)
        if highest is Regime.FORWARD_SLIP:
            ratios["back slip"] = first_ratio(one, Regime.BACK_SLIP)
        ends = dict(others) | {name: 1.0 / ratio if ratio else math.inf for name, ratio in ratios.items()}
        # rounding must bring no body beyond
        caps = {name: end * (1.0 - TOLERANCES.beside) for name, end in ends.items()}
        return {**caps, "limit": largest}

    def intervals(
        self,
        target: float,
        highest: Regime,
        largest: float,
        others: Mapping[str, float] | None = None,
        near: float | None = None,
    ) -> list[Interval]:
        """Return the nominal amplitudes that guarantee a speed; arguments as for ``caps`` and ``_Scan``."""
        caps = self.caps(highest, largest, others or {})
        top_by = min(caps, key=lambda name: caps[name])
        top = caps[top_by]
        one = self.across(1.0, 1.0)
        flies = highest is Regime.HOPPING
        started = last_ratio(one, Regime.FORWARD_SLIP)
        if flies and not one.space.proves:
            # an ellipse may throw bodies forward at loads that are too low for forward slip
            started = max(started, one.throw_number)
        start = 1.0 / started if started > 0.0 else math.inf
        wide = bool(one.varies.any())
        bounces = flies and self.template.restitution > 0.0
        if wide:
            detail = _BOUNCING if bounces else _FLYING if flies else _BOX
        else:
            detail = _ONE_HOPS[bounces] if flies else _ONE
        scenarios = Scenarios.fixed(corners(one.varies))
        endless = math.isinf(top)  # without hops there is no largest amplitude
        if endless:
            scan = _Scan(self, scenarios, target, flies)
            top, top_by = _BEYOND * max([start, *scan.criticals()]), "limit"
            if 0.0 < (speed := float(scan.least(np.array([top]))[0])) < target:
                top *= _FASTER * target / speed
        found: list[Interval] = []
        missing: list[bool] = []
        for _ in range(max(detail.exchanges, 1)):
            found = _Scan(self, scenarios, target, flies).intervals(start, top, top_by, detail, near)
            missing = []
            for interval in found:
                worse = self._with_worse(scenarios, interval, target) if wide else None
                missing.append(worse is not None)
                scenarios = worse or scenarios
            if not any(missing):
                break
        found = [
            part
            for interval, misses in zip(found, missing, strict=True)
            for part in (self._confirmed(interval, target, detail) if misses else [interval])
        ]
        return [i._replace(high=math.inf) if endless and i.high == top else i for i in found]

    def _with_worse(self, scenarios: Scenarios, interval: Interval, target: float) -> Scenarios | None:
        """Add bodies that miss the target in an interval; None if none does.

        Both ends are searched by themselves too: a body that misses the target just before an end, past a
        drop of the speed, does so within a sliver of the whole interval.
        """
        found = scenarios
        for low, high in dict.fromkeys([interval[:2], (interval.low,) * 2, (interval.high,) * 2]):
            found = self._with_slowest(found, low, high, target) or found
        return None if found is scenarios else found

    def _with_slowest(
        self, scenarios: Scenarios, least: float, most: float, target: float
    ) -> Scenarios | None:
        """Add the slowest body between two factors, and the hardest landings, if they miss the target."""
        slowest, landing = self._slowest(least, most)
        is_slow = slowest.speed < target * (1.0 - TOLERANCES.searched)
        if not is_slow and not landing.size:
            return None
        coordinates = np.hstack([landing, slowest.coordinates]) if is_slow else landing
        # factor at which it was found, and its deviation there
        load = float(inside(self.across(least, most).load, slowest.coordinates[0])[0])
        middle = 2.0 / sum(float(end) for end in self.across(1.0, 1.0).load)
        factor = min(max(load * middle, least), most)
        box = self.across(factor, factor)
        low, high = (float(end) for end in box.load)
        own = min(max((load - low) / (high - low), 0.0), 1.0) if low < high else 0.0
        return scenarios.joined(box, at_loads(box, coordinates, own))

    def _slowest(self, low: float, high: float) -> tuple[Extreme, Floats]:
        """Return the slowest body between two amplitudes, and those that land too hard or fly too long."""
        box = self.across(low, high)
        return bound(box, fast=False, seen=Seen(), boxes=BRIEF).extreme, self.landings.worst(box)

    def _holds(self, low: float, high: float, target: float) -> bool:
        """Return whether all amplitudes between two guarantee a speed."""
        slowest, landing = self._slowest(low, high)
        return slowest.speed >= target * (1.0 - TOLERANCES.searched) and not landing.size

    def _confirmed(self, interval: Interval, target: float, detail: _Detail) -> list[Interval]:
        """Return the parts of an interval that guarantee a speed, where the slowest bodies differ everywhere.

        The slowest body is searched for each amplitude by itself. Parts that are not confirmed as a whole are
        halved, and dropped when they are short.
        """
        low, high = interval.low, interval.high
        parts: list[tuple[float, float]] = []
        for part in self._parts(low, high, self._at(low, target), self._at(high, target), target, detail):
            if parts and parts[-1][1] == part[0]:  # adjacent halves
                part = parts.pop()[0], part[1]
            parts.append(part)
        return [
            Interval(
                a,
                b,
                interval.low_set_by if a == low else self.ends_by(a, a * (1.0 - _PAST_EDGE)),
                interval.high_set_by if b == high else self.ends_by(b, b * (1.0 + _PAST_EDGE)),
            )
            for a, b in parts
        ]

    def _parts(
        self, low: float, high: float, holds_low: bool, holds_high: bool, target: float, detail: _Detail
    ) -> list[tuple[float, float]]:
        """Return the confirmed parts between two amplitudes, given whether these hold."""
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
        return self._holds(amplitude, amplitude, target)

    def _edge(self, holding: float, failing: float, target: float, width: float) -> float:
        """Close in on the last factor that holds before one that does not."""

        def holds(factors: Floats) -> Floats:
            return np.array([1.0 if self._at(float(x), target) else -1.0 for x in factors])

        return float(close_in(holds, holding, failing, relative=width)[0])

    def ends_at(self, here: float, beyond: float, target: float) -> str:
        """Return the constraint that ends a window; "unconfirmed" if the goal is also met just beyond it."""
        slowest, landing = self._slowest(beyond, beyond)
        if landing.size:
            return "limit"
        return self.ends_by(here, beyond) if slowest.speed < target else "unconfirmed"

    def ends_by(self, inside: float, outside: float) -> str:
        """Return "speed", or, if the least speed jumps between two amplitudes, "onset" or "back slip"."""
        here, there = (self._slowest(a, a)[0].speed for a in (inside, outside))
        if there >= here * (1.0 - TOLERANCES.fall) or self.across(outside, outside).may_hop:
            return "speed"
        return "onset" if outside < inside else "back slip"


def _run(holds: NDArray[np.bool_], at: int) -> NDArray[np.bool_]:
    """Return which places hold without a gap around one of them."""
    gaps = np.flatnonzero(~holds)
    before, after = gaps[gaps < at], gaps[gaps > at]
    places = np.arange(holds.size)
    low = before[-1] if before.size else -1
    high = after[0] if after.size else holds.size
    return np.asarray((places > low) & (places < high))


@dataclass(frozen=True)
class _Scan:
    """The least speed of scenarios over the nominal amplitude.

    Attributes
    ----------
    family : Family
        Boxes of the amplitudes.
    scenarios : Scenarios
        Of each box.
    target : float
        Target speed [m/s].
    flies : bool
        Whether bodies may hop.
    """

    family: Family
    scenarios: Scenarios
    target: float
    flies: bool

    def intervals(
        self, start: float, top: float, top_by: str, detail: _Detail, near: float | None = None
    ) -> list[Interval]:
        """Return where the target is reached between two amplitudes.

        Parameters
        ----------
        start, top : float
            The amplitudes [m].
        top_by : str
            Constraint that sets ``top``.
        detail : Detail
            Resolution of the scan.
        near : float, optional
            An amplitude: only the interval that contains it is returned.
        """
        criticals = self.criticals()
        if start == 0.0:
            start = min(criticals, default=top) / _BEYOND
        if not start < top:
            return []
        grid = np.geomspace(start, top, detail.amplitudes)
        beside = np.outer(criticals, [1.0 - TOLERANCES.beside, 1.0 + TOLERANCES.beside]).ravel()
        grid = np.unique(np.concatenate([grid, beside[(beside > grid[0]) & (beside < top)]]))
        least = self.least(grid)
        for _ in range(detail.rounds):
            grid, least = self._closer(grid, least)
        holds = least >= self.target
        if near is not None:
            holds &= _run(holds, int(np.argmin(np.abs(grid - near))))
        edges = np.flatnonzero(holds[1:] != holds[:-1])
        holding, failing = self._crossings(
            np.where(holds[edges], grid[edges], grid[edges + 1]),
            np.where(holds[edges], grid[edges + 1], grid[edges]),
            detail.end,
        )
        ends = [
            (x, self._set_by(x, y, detail.end))
            for x, y in zip(holding.tolist(), failing.tolist(), strict=True)
        ]
        if holds[0]:
            ends.insert(0, (float(grid[0]), "onset"))
        if holds[-1]:
            ends.append((top, top_by))
        return [
            Interval(low, high, low_by, high_by)
            for (low, low_by), (high, high_by) in zip(ends[::2], ends[1::2], strict=True)
        ]

    def _points(self, amplitudes: Floats) -> tuple[UncertaintySet, Points]:
        boxes = self.family.boxes(amplitudes[:, None])
        return boxes, boxes.points(self.scenarios.at(boxes))

    def _scene(self, amplitudes: Floats) -> Scene:
        boxes, points = self._points(amplitudes)
        return boxes.scene(points, fast=False)

    def _speeds(self, amplitudes: Floats) -> Floats:
        """Speeds of all bodies at some amplitudes, of shape (m, n); NaN where one is left out."""
        boxes, points = self._points(amplitudes)
        cycle = solve(boxes.scene(points, fast=False), flight=self.flies)
        bad = self.family.landings.broken(boxes, points, cycle)
        return np.where(bad, -np.inf, counted(cycle, fast=False))

    def least(self, amplitudes: Floats) -> Floats:
        """Return the least speed at each amplitude [m/s]."""
        return least_of(self._speeds(amplitudes))

    def criticals(self) -> list[float]:
        """Nominal amplitudes at which some body changes its regime."""
        scene = self._scene(np.ones(1))
        found = np.array([load / scene.load for load in change_loads(scene).values()])
        return [float(x) for x in np.unique(found[np.isfinite(found) & (found > 0.0)])]

    def _closer(self, grid: Floats, least: Floats) -> tuple[Floats, Floats]:
        """Add amplitudes around every extremum that may cross the target between two of them.

        Where the speed does not depend on the amplitude, as on level troughs that move along themselves,
        rounding makes an extremum of every third amplitude: those that differ from both neighbours by
        rounding alone are left out.
        """
        middle, before, after = least[1:-1], least[:-2], least[2:]
        lower, upper = np.minimum(before, after), np.maximum(before, after)
        rounding = TOLERANCES.searched * self.target
        dips = (middle <= lower) & (upper > middle + rounding) & (middle >= self.target)
        tops = (middle >= upper) & (lower < middle - rounding) & (middle < self.target) & (middle > 0.0)
        cells = np.flatnonzero(dips | tops) + 1
        if not cells.size:
            return grid, least
        more = np.linspace(grid[cells - 1], grid[cells + 1], _CLOSER)[1:-1].ravel()
        amplitudes, first = np.unique(np.concatenate([grid, more]), return_index=True)
        return amplitudes, np.concatenate([least, self.least(more)])[first]

    def _crossings(self, holding: Floats, failing: Floats, width: float) -> tuple[Floats, Floats]:
        """Close in on amplitudes beyond which the target is missed, to a relative width or to two doubles."""

        def surplus(amplitudes: Floats) -> Floats:
            return (self.least(amplitudes[:, 0]) - self.target)[:, None]

        return close_in(surplus, holding, failing, relative=width)

    def _set_by(self, inside: float, outside: float, width: float = 0.0) -> str:
        """Return the constraint between an amplitude that reaches the target and one that misses it.

        ``width`` is their largest relative distance.
        """
        speed = self._speeds(np.array([inside, outside]))
        if np.isnan(speed[1]).all():
            return "unconfirmed"
        body = int(np.nanargmin(speed[1]))
        if abs(speed[0, body] - speed[1, body]) <= max(TOLERANCES.jump, _STEEP * width) * abs(speed[0, body]):
            return "speed"
        if math.isinf(speed[1, body]):
            boxes, points = self._points(np.array([outside]))
            slow = solve(boxes.scene(points, fast=False), flight=self.flies)
            if self.family.landings.broken(boxes, points, slow)[0, body]:
                return "limit"
        regimes = np.asarray(solve(self._scene(np.array([inside, outside])), flight=False).regime)[:, body]
        if Regime.HOPPING in regimes:
            return "hop"
        if outside < inside and regimes[0] >= regimes[1]:  # else a larger ellipse ends back slip
            return "onset"
        return "back slip"


# ------------------------------------------------------------------------------
# Compute the share of parts that reach a speed: ``vibro.yield_share``.

_SCRAMBLES: Final = 8
_FIRST: Final = 14  # base-2 logarithm of the points of a scramble, doubled until the error is small enough
_LAST: Final = 20
_ERROR: Final = 3e-4


@shielded
def yield_share(scene: Scene, speed: float, *, highest_regime: str, **bands: Any) -> tuple[float, float]:
    """Return the share of a box of bands that reaches a speed without exceeding a regime.

    Parameters
    ----------
    scene : Scene
        One operating point, with the values of all quantities that have no band.
    speed : float
        Least mean speed, > 0 [m/s].
    highest_regime : {"forward-slip", "back-slip", "hopping"}
        Highest regime allowed.
    **bands
        As for ``vibro.guarantee``. Quantities are independent and uniform in their bands, subject to mu_d <=
        mu_s.

    Returns
    -------
    share, standard_error : float
        Share, in [0, 1], and its standard error, which is at most 3e-4 unless 8 million points do not suffice
        [1]. Points whose speed is unknown count as not reaching it.

    Raises
    ------
    SceneError
        If the scene is more than one operating point, or a band is invalid.
    InputError
        If another argument is invalid.

    Notes
    -----
    The share is a mean over 8 scrambled Sobol sequences, whose scatter gives the error; their length is
    doubled until the error is small enough.

    Examples
    --------
    >>> import math, vibro
    >>> scene = vibro.Scene(amplitude=0.9e-3, frequency=15, drive_angle=math.radians(25),
    ...                     static_friction=0.6, kinetic_friction=0.5)
    >>> share, error = vibro.yield_share(scene, 0.02, highest_regime="forward-slip",
    ...                                  static_friction=(0.5, 0.8), friction_ratio=(0.6, 0.95))
    >>> print(f"{share:.3f}")
    0.095
    """
    highest = _regime_of(highest_regime)
    target = _positive("speed", speed, "m/s")
    box = uncertainty_set(scene, bands)
    shares: list[float] = []
    error = math.inf
    for logarithm in range(_FIRST, _LAST + 1):
        shares = [_share(box, target, highest, logarithm, seed) for seed in range(_SCRAMBLES)]
        # if all scrambles agree, a share below one point may have been missed
        least = 1.0 / (_SCRAMBLES * 2**logarithm)
        error = max(float(np.std(shares, ddof=1)) / math.sqrt(_SCRAMBLES), least)
        if error <= _ERROR:
            break
    return float(np.mean(shares)), error


def _share(box: UncertaintySet, target: float, highest: Regime, logarithm: int, seed: int) -> float:
    """Return the share of one scramble."""
    from scipy.stats import qmc  # late: it takes a fifth of a second to load

    spans = (
        box.factor, box.frequency, *box.shape.values(), box.trough_angle, box.static_span,
        box.second_friction,
    )  # fmt: skip
    low, high = (np.array(ends, np.float64)[:, None] for ends in zip(*spans, strict=True))
    points = qmc.Sobol(len(spans), rng=np.random.default_rng(seed)).random_base2(logarithm).T
    factor, frequency, *shape, beta, mu_s, mu_d = low + points * (high - low)
    if box.is_ratio:
        mu_d = np.minimum(mu_d * mu_s, mu_s)
    else:
        mu_s, mu_d = _cut(box, points[-2], points[-1])
    motion = box.space.motion(factor, tuple(shape))
    cycle = solve(
        Scene.computed(
            **motion, frequency=frequency, trough_angle=beta, static_friction=mu_s, kinetic_friction=mu_d,
            **box.constants,
        )
    )  # fmt: skip
    reaches = (cycle.mean_velocity >= target) & (cycle.regime <= highest)
    return float(np.mean(reaches))


def _cut(box: UncertaintySet, u: Floats, v: Floats) -> tuple[Floats, Floats]:
    """Return frictions that are uniform where mu_d <= mu_s, for uniform numbers.

    Beside a static friction the kinetic one has the width min(mu_s, k_high) - k_low, which is the density of
    static friction: a trapezoid, whose share up to a friction is inverted.
    """
    (s_low, s_high), (k_low, k_high) = box.static_span, box.second_friction
    knee = min(max(k_high, s_low), s_high)  # up to where kinetic friction is cut
    slope = 0.5 * (knee - s_low) * (s_low + knee - 2.0 * k_low)
    whole = slope + (k_high - k_low) * (s_high - knee)
    if whole > 0.0:
        area = u * whole
        rising = k_low + np.sqrt((s_low - k_low) ** 2 + 2.0 * area)
        flat = knee + (area - slope) / (k_high - k_low)
        mu_s = np.clip(np.where(area < slope, rising, flat), s_low, s_high)
    else:  # one friction has no width
        mu_s = s_low + u * (s_high - s_low)
    low, high = box.kinetic_span(mu_s)
    return mu_s, low + v * (high - low)
