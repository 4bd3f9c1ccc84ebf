"""Find the amplitudes at which all bodies reach a speed: ``vibro.feasible_amplitudes``, windows of designs.

``_Scan`` computes the least speed of the corners of a box over the amplitude. Where it reaches the target,
``Family`` searches whole intervals for slower bodies; where it finds one, a bisection narrows the interval.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, Final, NamedTuple

import numpy as np

from vibro.core.codes import Regime
from vibro.designs.guarantees import (
    ANY_LANDING,
    BRIEF,
    Extreme,
    Landings,
    Seen,
    bound,
    counted,
    least_of,
    speeds_of,
)
from vibro.designs.proofs import change_loads, corners, first_ratio, last_ratio, tip_ratio
from vibro.designs.search import close_in, sobol
from vibro.designs.spaces import TOLERANCES, uncertainty_set
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


class _Detail(NamedTuple):
    """Sizes and resolutions of a scan.

    Attributes
    ----------
    amplitudes, rounds : int
        Amplitudes of the first grid, and rounds of refinement at extrema between them.
    end : float
        Relative width to which ends are found.
    seeds : int
        Amplitudes from which the parts of an interval are grown some of whose bodies miss the target.
    """

    amplitudes: int
    rounds: int
    end: float
    seeds: int = 0


# For one body in contact, and for its hops: between these the speed jumps, and has no smooth extrema.
_ONE: Final = _Detail(4097, 3, 0.0)
_ONE_HOPS: Final = {
    bounces: _Detail(count, 0, 1e-5 if bounces else 0.0) for bounces, count in HOPS_SAMPLED.items()
}
# For a box in contact, for plastic hops, and for bounces, which are slow to solve.
_BOX: Final = _Detail(257, 3, 0.0, 33)
_FLYING: Final = _Detail(129, 1, 1e-9, 5)
_BOUNCING: Final = _Detail(33, 0, 1e-2, 3)
_NARROW: Final = 1e-9  # [1] relative width to which ends are found by the slowest body of an interval


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
    """Return the nominal amplitudes at which every body of a box of bands reaches a speed, by a search.

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
        ``motion_scale`` [1]. Empty if at no amplitude all bodies reach the speed. To see what a part reaches
        without hopping, solve the scene at amplitudes up to hop g / w^2, where
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
    The least speed of the corners of the box is computed as a function of the amplitude, with all its
    critical loads and extrema; where it crosses the target is found to rounding. Then the slowest body of
    each whole interval is searched. If it misses the target, the interval is grown anew from amplitudes
    inside: boxes of growing intervals contain each other, so that a bisection finds their ends, to 1e-9. The
    search proves nothing: ``vibro.guarantee`` bounds the speeds of one amplitude.

    The speed of hopping bodies jumps as the amplitude changes, and for irregular motion it does so
    everywhere. A single body is solved at 32769 amplitudes, or at 4097 if it bounces, and ends are found to
    1e-5; the corners of a box are solved at 129 amplitudes, or at 33 if they bounce, with ends to 1e-2.
    Intervals or gaps between two of these amplitudes may be missed: of boxes with bouncing bodies an
    interval is a sample, and ``vibro.guarantee`` says more of one amplitude. Three standard errors are
    subtracted from a mean of irregular motion. With ``highest_regime="forward-slip"`` an interval ends
    where back slip first begins, even if back slip ends again at larger amplitudes.

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
    if highest is not Regime.HOPPING:
        box = box.in_contact
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
        # Where the speed jumps at an end, rounding of units and drifts must not cross it: move inwards.
        inwards = [TOLERANCES.beside * (by != "limit") for by in i[2:]]
        low, high = i.low * unit * (1.0 + inwards[0]), i.high * unit * (1.0 - inwards[1])
        low, by = (low, i.low_set_by) if low >= least else (least, "limit")
        return Interval(min(low, amplitude), max(high, amplitude), by, i.high_set_by)
    # no interval around the design was confirmed: a window of the design alone
    below, above = (family.set_by(at, at * (1.0 + side * TOLERANCES.at), target) for side in (-1.0, 1.0))
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
        """Return the nominal amplitudes that guarantee a speed.

        Corners of the box are scanned. Where all of them reach the speed, the slowest body of the whole
        interval is searched; if it misses the speed, the interval is grown anew from amplitudes inside.

        Parameters
        ----------
        target : float
            Target speed [m/s].
        highest, largest, others
            As for ``caps``.
        near : float, optional
            An amplitude: only the interval that contains it is returned.
        """
        caps = self.caps(highest, largest, others or {})
        top_by = min(caps, key=lambda name: caps[name])
        top, one, flies = caps[top_by], self.across(1.0, 1.0), highest is Regime.HOPPING
        wide, bounces = bool(one.varies.any()), flies and one.bounces
        if wide:
            detail = _BOUNCING if bounces else _FLYING if flies else _BOX
        else:
            detail = _ONE_HOPS[bounces] if flies else _ONE
        scan = _Scan(self, corners(one.varies), target, flies)
        start = self._start(flies)
        endless = math.isinf(top)  # without hops there is no largest amplitude
        if endless:
            top, top_by = _BEYOND * max([start, *scan.criticals()]), "limit"
            if 0.0 < (speed := float(scan.least(np.array([top]))[0])) < target:
                top *= _FASTER * target / speed
        found = scan.parts(start, top, detail, near)
        if wide:
            found = [part for whole in found for part in self._confirmed(whole, target, detail, near)]
        return [
            Interval(
                low,
                math.inf if endless and high == top else high,
                "onset" if math.isnan(below) else self.set_by(low, below, target, detail.end),
                top_by if math.isnan(above) else self.set_by(high, above, target, detail.end),
            )
            for low, high, below, above in found
        ]

    def _start(self, flies: bool) -> float:
        """Return the factor at which the last body starts to move; inf where it never does."""
        one = self.across(1.0, 1.0)
        started = last_ratio(one, Regime.FORWARD_SLIP)
        if flies and not one.space.proves:
            # an ellipse may throw bodies forward at loads that are too low for forward slip
            started = max(started, one.throw_number)
        return 1.0 / started if started > 0.0 else math.inf

    def _confirmed(self, whole: _Part, target: float, detail: _Detail, near: float | None) -> list[_Part]:
        """Return the parts of an interval that guarantee a speed for every body.

        Boxes of growing intervals contain each other, so that the ends of a part are found by bisection.
        """
        low, high = whole.low, whole.high
        if self._holds(low, high, target):
            return [whole]
        seeds = np.geomspace(low, high, detail.seeds) if near is None else [min(max(near, low), high)]
        parts: list[_Part] = []
        for seed in map(float, seeds):
            if (parts and seed <= parts[-1].high) or not self._holds(seed, seed, target):
                continue
            first, below = self._grown(seed, low, whole.below, target, detail.end)
            last, above = self._grown(seed, high, whole.above, target, detail.end)
            parts.append(_Part(first, last, below, above))
        return parts

    def _grown(
        self, seed: float, end: float, beyond: float, target: float, width: float
    ) -> tuple[float, float]:
        """Return the amplitude farthest from one up to which all hold, and one beyond that does not."""

        def holds(ends: Floats) -> Floats:
            low, high = np.minimum(ends, seed), np.maximum(ends, seed)
            pairs = zip(low.tolist(), high.tolist(), strict=True)
            return np.array([1.0 if self._holds(*pair, target) else -1.0 for pair in pairs])

        if holds(np.array([end]))[0] > 0.0:
            return end, beyond
        inside, outside = close_in(holds, seed, end, relative=max(width, _NARROW))
        return float(inside), float(outside)

    def _slowest(self, low: float, high: float) -> tuple[Extreme, Floats]:
        """Return the slowest body between two amplitudes, and those that land too hard or fly too long."""
        box = self.across(low, high)
        return bound(box, fast=False, seen=Seen(), boxes=BRIEF).extreme, self.landings.worst(box)

    def _holds(self, low: float, high: float, target: float) -> bool:
        """Return whether all amplitudes between two guarantee a speed.

        Both ends are searched by themselves too: a body that misses the target just before an end, past a
        drop of the speed, does so within a sliver of the whole interval.
        """
        for ends in dict.fromkeys([(low, high), (low, low), (high, high)]):
            slowest, landing = self._slowest(*ends)
            if slowest.speed < target * (1.0 - TOLERANCES.searched) or landing.size:
                return False
        return True

    def set_by(self, inside: float, outside: float, target: float, width: float = 0.0) -> str:
        """Return the constraint between an amplitude that reaches the target and one that misses it.

        It is "unconfirmed" where no body is found that misses it. ``width`` is the relative distance of the
        two, over which a speed may change without a jump.
        """
        slowest, landing = self._slowest(outside, outside)
        if landing.size:
            return "limit"
        if not slowest.speed < target:
            return "unconfirmed"
        boxes = self.boxes(np.array([[inside], [outside]]))
        scene = boxes.scene(boxes.points(slowest.coordinates[:, None, :]), fast=False)
        here, there = np.ravel(speeds_of(scene, fast=False, flight=True))
        if abs(here - there) <= max(TOLERANCES.jump, _STEEP * width) * abs(here):
            return "speed"
        regimes = np.ravel(solve(scene, flight=False).regime)
        if Regime.HOPPING in regimes:
            return "hop"
        if outside < inside and regimes[0] >= regimes[1]:  # else a larger ellipse ends back slip
            return "onset"
        return "back slip"


class _Part(NamedTuple):
    """Amplitudes that reach a target, and those beside them that miss it; NaN where the scan ends there."""

    low: float
    high: float
    below: float
    above: float


@dataclass(frozen=True)
class _Scan:
    """The least speed of some bodies over the nominal amplitude.

    Attributes
    ----------
    family : Family
        Boxes of the amplitudes.
    bodies : (axes, n) array
        Unit-cube coordinates of the bodies of each box.
    target : float
        Target speed [m/s].
    flies : bool
        Whether bodies may hop.
    """

    family: Family
    bodies: Floats
    target: float
    flies: bool

    def parts(self, start: float, top: float, detail: _Detail, near: float | None = None) -> list[_Part]:
        """Return where the target is reached between two amplitudes, or around one that is near."""
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
        level = np.abs(least - self.target) <= TOLERANCES.searched * self.target
        holds = self._reached(least, level)
        edges = np.flatnonzero(holds[1:] != holds[:-1])
        inside, outside = np.where(holds[edges], (edges, edges + 1), (edges + 1, edges))
        beside = TOLERANCES.searched * (1.0 * level[outside] - level[inside])  # off a plateau
        holding, failing = self._crossings(
            grid[inside], grid[outside], self.target * (1.0 + beside), detail.end
        )
        ends = list(zip(holding.tolist(), failing.tolist(), strict=True))
        if holds[0]:
            ends.insert(0, (float(grid[0]), math.nan))
        if holds[-1]:
            ends.append((top, math.nan))
        found = [
            _Part(a, b, below, above) for (a, below), (b, above) in zip(ends[::2], ends[1::2], strict=True)
        ]
        if near is None:
            return found
        at = TOLERANCES.at
        return [part for part in found if part.low * (1.0 - at) <= near <= part.high * (1.0 + at)]

    def _points(self, amplitudes: Floats) -> tuple[UncertaintySet, Points]:
        boxes = self.family.boxes(amplitudes[:, None])
        return boxes, boxes.points(self.bodies[:, None, :])

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
        boxes, points = self._points(np.ones(1))
        scene = boxes.scene(points, fast=False)
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

    def _reached(self, least: Floats, level: NDArray[np.bool_]) -> NDArray[np.bool_]:
        """Return where speeds reach the target; of a run of speeds near to it, all do if one does.

        Where the speed does not depend on the amplitude, rounding would part a plateau at the target.
        """
        begins = np.concatenate([[0], 1 + np.flatnonzero(level[1:] != level[:-1])])
        most = np.repeat(np.maximum.reduceat(least, begins), np.diff(begins, append=least.size))
        reached: NDArray[np.bool_] = np.where(level, most * (1.0 + TOLERANCES.rounding), least) >= self.target
        return reached

    def _crossings(
        self, holding: Floats, failing: Floats, targets: Floats, width: float
    ) -> tuple[Floats, Floats]:
        """Close in on amplitudes beyond which targets are missed, to a relative width or to two doubles."""

        def surplus(amplitudes: Floats) -> Floats:
            return (self.least(amplitudes[:, 0]) - targets)[:, None]

        return close_in(surplus, holding, failing, relative=width)


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
    if highest is not Regime.HOPPING:
        box = box.in_contact
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
    spans = (
        box.factor, box.frequency, *box.shape.values(), box.trough_angle, box.static_span,
        box.second_friction, box.restitution,
    )  # fmt: skip
    low, high = (np.array(ends, np.float64)[:, None] for ends in zip(*spans, strict=True))
    bounces_vary = box.restitution[0] < box.restitution[1]  # an axis without a width is none of the sequence
    points = np.zeros((len(spans), 2**logarithm))
    drawn = sobol(len(spans) - (not bounces_vary), logarithm, seed)
    points[: len(drawn)] = drawn
    factor, frequency, *shape, beta, mu_s, mu_d, restitution = low + points * (high - low)
    if box.is_ratio:
        mu_d = np.minimum(mu_d * mu_s, mu_s)
    else:
        mu_s, mu_d = _cut(box, points[-3], points[-2])
    motion = box.space.motion(factor, tuple(shape))
    cycle = solve(
        Scene.computed(
            **motion, frequency=frequency, trough_angle=beta, static_friction=mu_s, kinetic_friction=mu_d,
            restitution=restitution, gravity=box.gravity,
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
