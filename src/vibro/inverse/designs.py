"""From a question to its designs: ``vibro.design``."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from vibro.core.codes import Regime
from vibro.inverse.amplitudes import Family
from vibro.inverse.caps import back_slip_load, hop_load, onset_load
from vibro.inverse.costs import speed_costs
from vibro.inverse.guarantees import guarantee_of
from vibro.inverse.optima import Optimiser
from vibro.inverse.questions import Question, Setting
from vibro.inverse.reading import read_spec
from vibro.inverse.rounding import in_si, outside, rounded, within
from vibro.quantities import QUANTITIES, SPEED
from vibro.results.designs import Design, DesignResult, Interval
from vibro.scene import Scene
from vibro.steady import solve

if TYPE_CHECKING:
    import os
    from collections.abc import Callable, Iterable, Mapping

    from vibro.inverse.exchange import Optimum
    from vibro.inverse.specs import Drive, Spec
    from vibro.results.designs import Guarantee

__all__ = ["Chosen", "chosen_of", "design", "find_designs", "nominal_scene"]

_REGIMES: Final = (Regime.FORWARD_SLIP, Regime.BACK_SLIP, Regime.HOPPING)
_KINDS: Final = ("gentlest", "fastest", "safest")
_DIGITS: Final = (9, 12, 15)  # of printed settings; more where fewer do not hold
_NUDGES: Final = 4  # steps of the last digit that an amplitude may be moved inwards
_SURPLUSES: Final = (0.0, 1e-6, 1e-5, 1e-4, 1e-3, 1e-2)  # of the goal, for a setting that can be rounded
_ROUNDING: Final = 1e-12  # relative, of conversions between units
_SPARE: Final = 1e-8  # of the frequency of the nearest drive, for what is lost by rounding its amplitude
_NEARLY: Final = 0.98  # of a limit on landings: a setting there is at it
_AT: Final = 1e-6  # relative distance to a limit that is at it


def design(spec: str | os.PathLike[str] | Mapping[str, Any]) -> DesignResult:
    """Find the drive settings that guarantee a speed to every part of a box of bands.

    Parameters
    ----------
    spec : path or mapping
        A TOML file, or a mapping with its keys; docs/design.md lists them.

    Returns
    -------
    DesignResult
        For every drive and each of the regimes forward-slip, back-slip and hopping the gentlest, the fastest
        and the safest design.

    Raises
    ------
    InputError
        If the question cannot be; it lists all that is wrong.
    FileError
        If the file cannot be read.

    Examples
    --------
    >>> import vibro
    >>> result = vibro.design({
    ...     "scene": {"static_friction": "0.7:0.78", "kinetic_friction": "0.5:0.6"},
    ...     "drive": [{"amplitude_mm": 3, "frequency_hz": "10:30", "drive_angle_deg": "5:45"}],
    ...     "goal": {"speed_mm_s": 30, "highest_regime": "forward-slip"},
    ... })
    >>> gentlest = result.designs[0]
    >>> print(result.met, f"{gentlest.acceleration_g:.6f} g, {gentlest.amplitude_mm:.5f} mm")
    True 0.965580 g, 2.39937 mm
    """
    return find_designs(read_spec(spec))


def find_designs(spec: Spec, tell: Callable[[int, int], None] | None = None) -> DesignResult:
    """Find the designs of a checked question; ``tell`` is told how many of all are found."""
    designs: list[Design] = []
    total = len(spec.drives) * len(_REGIMES) * len(_KINDS)
    for drive in spec.drives:
        calmer: dict[str, _Found] = {}
        for regime in _REGIMES:
            rows = _Rows(Question(spec, drive, regime), calmer)
            designs += [rows.row(kind) for kind in _KINDS]
            if tell:
                tell(len(designs), total)
            calmer = rows.found
    target, highest = spec.goal.speed, spec.goal.highest_regime.label
    met = any(
        d.highest_regime == highest and (d.speed_min_mm_s or 0.0) >= SPEED.from_si(target) for d in designs
    )
    return DesignResult(met, tuple(designs))


@dataclass(frozen=True)
class _Found:
    """A setting as it is printed, what it guarantees, and its margin, and by which optimiser."""

    setting: Setting
    printed: tuple[float, float, float]
    guarantee: Guarantee
    margin: float | None = None
    optimiser: Optimiser | None = None


class _Rows:
    """The designs of one drive within one regime.

    Parameters
    ----------
    question : Question
        What is asked.
    calmer : mapping of str to _Found
        The designs within a lower regime, which are designs here too.
    """

    def __init__(self, question: Question, calmer: Mapping[str, _Found]) -> None:
        self._question = question
        self._target = question.spec.goal.speed
        self._optimiser = optimiser = Optimiser(question)
        #: The designs by their kind, without those that there are not.
        self.found: dict[str, _Found] = {}
        self._keep("fastest", [self._settled(optimiser.fastest(), None, up=False), calmer.get("fastest")])
        fastest = self.found.get("fastest")
        if fastest is None or fastest.guarantee.speed_min < self._target:
            return
        self._keep("gentlest", [self._gentlest(), calmer.get("gentlest"), fastest])
        safest: list[_Found | None] = [fastest]
        if question.spec.has_bands:
            best = self._settled(optimiser.safest(self._target), self._target, up=False)
            safest = [best, calmer.get("safest"), *self.found.values()]
        self._keep("safest", safest)

    def _gentlest(self) -> _Found | None:
        """Return the gentlest setting that holds as it is printed.

        It may stand where the speed just reaches the goal and back slip just enters: no rounding holds there,
        but one beside a setting for a little more speed does.
        """
        for surplus in _SURPLUSES:
            optimum = self._optimiser.gentlest(self._target * (1.0 + surplus))
            if found := self._settled(optimum, self._target, up=True):
                return found
        return None

    def _keep(self, kind: str, candidates: Iterable[_Found | None]) -> None:
        """Keep the best of candidates, with its margin."""
        known = [found for found in candidates if found is not None]
        if kind == "safest":
            known = [self._with_margin(found) for found in known]
        merits: dict[str, Callable[[_Found], float]] = {
            "fastest": lambda found: found.guarantee.speed_min,
            "gentlest": lambda found: -float(self._question.load(found.setting)),
            "safest": lambda found: found.margin or 0.0,
        }
        if known:
            self.found[kind] = self._with_margin(max(known, key=merits[kind]))

    def _with_margin(self, found: _Found) -> _Found:
        """Add the margin of a design: at least 1 where it meets the goal."""
        if found.optimiser is self._optimiser or not self._question.spec.has_bands:
            return found
        margin = self._optimiser.margin(found.setting, self._target)
        if found.guarantee.speed_min >= self._target:  # what holds in a lower regime holds here
            margin = max(margin or 1.0, found.margin or 1.0, 1.0)
        return replace(found, margin=margin, optimiser=self._optimiser)

    def _settled(self, optimum: Optimum | None, target: float | None, *, up: bool) -> _Found | None:
        """Round a setting inwards, so that it holds as it is printed."""
        if optimum is None:
            return None
        for digits in _DIGITS:
            for printed in self._roundings(optimum.setting, digits, up=up):
                setting = in_si(printed)
                if not self._optimiser.holds(setting, target or 0.0) or not self._is_allowed(setting):
                    continue
                found = _Found(setting, printed, guarantee_of(self._question.boxes(setting)))
                if found.guarantee.speed_min >= (target or 0.0):
                    return found
        return None

    def _roundings(self, setting: Setting, digits: int, *, up: bool) -> list[tuple[float, float, float]]:
        """Return settings in the units outside with so many digits, from the nearest one inwards."""
        amplitude, frequency, angle = (
            float(QUANTITIES[name].from_si(float(value))) for name, value in setting._asdict().items()
        )
        f_ends, a_ends = min(self._question.ranges, key=lambda ends: outside(ends, setting))
        near = (
            within(frequency, "frequency", f_ends, digits),
            within(angle, "drive_angle", a_ends, digits),
        )
        # the load that the setting has, with the rounded frequency
        amplitude *= (frequency / near[0]) ** 2
        unit = 10.0 ** (math.floor(math.log10(amplitude)) - digits + 1)
        count = math.ceil(amplitude / unit) if up else math.floor(amplitude / unit)
        step = 1 if up else -1
        steps = (count + step * n for n in range(-1, _NUDGES))
        ends = self._question.drive.amplitude
        return [(within(n * unit, "amplitude", ends, digits), *near) for n in steps]

    def _is_allowed(self, setting: Setting) -> bool:
        """Tell whether a drive may be set so."""
        question, drive = self._question, self._question.drive
        inside = min(outside(ends, setting) for ends in question.ranges) <= _ROUNDING
        least, most = drive.amplitude
        load = float(question.load(setting))
        stroke = least * (1.0 - _ROUNDING) <= setting.amplitude <= most * (1.0 + _ROUNDING)
        return bool(inside and stroke and load <= drive.acceleration * (1.0 + _ROUNDING))

    def _limit(self, found: _Found, scale: float) -> str:
        """Tell what keeps a setting from being better with bands of a scale."""
        question = self._question
        load = float(question.load(found.setting))
        if question.landings.scaled(_NEARLY).worst(question.boxes(found.setting, scale)).size:
            return "limit"
        caps = question.caps(np.array([[found.setting.drive_angle]]), scale)
        name, cap = min(((name, float(cap[0, 0])) for name, cap in caps.items()), key=lambda pair: pair[1])
        if load >= cap * (1.0 - _AT):
            return name
        most = question.drive.amplitude[1]
        return "limit" if found.setting.amplitude >= most * (1.0 - _AT) else "speed"

    def _set_by(self, kind: str) -> str | None:
        """Tell what keeps a design from being better; None where the goal is not met, but for the fastest."""
        found = self.found.get(kind)
        if found is None:
            return self._first_cap() if kind == "fastest" else None
        if kind == "gentlest":
            return "onset" if found.guarantee.speed_min > self._target * (1.0 + _AT) else "speed"
        return self._limit(found, found.margin or 1.0 if kind == "safest" else 1.0)

    def _first_cap(self) -> str:
        """Tell what ends the load before any speed is guaranteed, in the middle of the drive angles."""
        middle = np.array([[float(np.mean(self._question.ranges[0].drive_angle))]])
        caps = {name: float(cap[0, 0]) for name, cap in self._question.caps(middle).items()}
        reach = max(self._question.reach(choice.frequency)[1] for choice in self._question.ranges)
        caps["limit"] = min(caps["limit"], reach)
        return min(caps, key=lambda name: caps[name])

    def row(self, kind: str) -> Design:
        """Return a design as a row of a table; with what ends it alone where there is none."""
        found = self.found.get(kind)
        question, goal = self._question, self._question.spec.goal
        row = Design(
            drive=question.drive.name,
            highest_regime=question.highest.label,
            design=kind,
            set_by=self._set_by(kind),
        )
        if found is None:
            return row
        g = found.guarantee
        amplitude, frequency, angle = found.printed
        window = self._window(found)
        length, speed = question.spec.length, g.speed_min
        met = speed >= goal.speed
        # the nearest drive, rounded so that it does
        needed = rounded(frequency * speed / goal.speed * (1.0 - _SPARE), _DIGITS[0], down=True)
        stroke = rounded(amplitude * (frequency / needed) ** 2, _DIGITS[0], down=True)
        box = question.boxes(found.setting)
        return replace(
            row,
            amplitude_mm=amplitude,
            frequency_hz=frequency,
            drive_angle_deg=angle,
            acceleration_g=float(question.load(found.setting)),
            speed_min_mm_s=_mm(speed),
            speed_nominal_mm_s=_mm(float(solve(nominal_scene(question.spec, found.setting)).mean_velocity)),
            speed_max_mm_s=_mm(g.speed_max),
            traverse_time_max_s=length / speed if length is not None else None,
            amplitude_low_mm=None if window is None else _mm(window.low),
            amplitude_high_mm=None if window is None else _mm(window.high),
            low_set_by=None if window is None else window.low_set_by,
            high_set_by=None if window is None else window.high_set_by,
            margin=found.margin,
            throw_number_max=float(box.load[1] / hop_load(box)),
            frequency_needed_hz=None if met else needed,
            amplitude_needed_mm=None if met else stroke,
            proof=g.proof_min,
            coexists=g.coexists,
            excluded=g.excluded,
        )

    def _window(self, found: _Found) -> Interval | None:
        """Return the amplitudes that keep the guarantee and hold the design."""
        question, setting = self._question, found.setting
        box = question.boxes(setting)
        w = 2.0 * math.pi * float(setting.frequency)
        least, most = question.drive.amplitude
        most = min(most, question.drive.acceleration * question.spec.gravity / w**2)
        family = Family(replace(box, amplitude=(1.0, 1.0)), question.spec.drift.amplitude, question.landings)
        others = {name: float(load) for name, load in question.tip_loads(box).items()}
        for i in family.intervals(self._target, question.highest, most, others, setting.amplitude):
            if i.low * (1.0 - _AT) <= setting.amplitude <= i.high * (1.0 + _AT):
                low, by = (i.low, i.low_set_by) if i.low >= least else (least, "limit")
                ends = min(low, setting.amplitude), max(i.high, setting.amplitude)
                return Interval(*ends, by, i.high_set_by)
        if found.guarantee.speed_min < self._target:
            return None
        beyond = family.ends_by(setting.amplitude, setting.amplitude * (1.0 + _AT))
        return Interval(setting.amplitude, setting.amplitude, "speed", beyond)


@dataclass(frozen=True)
class Chosen:
    """The design that pictures and margins show.

    Attributes
    ----------
    drive : Drive
        Its drive.
    design : Design
        The safest of the best drive within the goal's regime; the fastest where no drive meets the goal.
    setting : Setting
        In SI units and radians.
    loads : dict of str to float
        Load now over the load at which something happens first, or last.
    costs : dict of str to float
        Change of the speed in the middle of all bands for 1 % of an input, by its field [%].
    """

    drive: Drive
    design: Design
    setting: Setting
    loads: dict[str, float]
    costs: dict[str, float]


def chosen_of(spec: Spec, result: DesignResult) -> Chosen | None:
    """Choose a design to be shown; None where nothing is guaranteed at all."""
    highest = spec.goal.highest_regime
    wanted = "safest" if result.met else "fastest"
    rows = [
        (d, drive)
        for drive in spec.drives
        for d in result.designs
        if (d.drive, d.highest_regime, d.design) == (drive.name, highest.label, wanted)
        and d.amplitude_mm is not None
    ]
    if not rows:
        return None
    best, drive = max(rows, key=lambda row: (row[0].margin or 0.0, row[0].speed_min_mm_s or 0.0))
    setting = in_si((best.amplitude_mm or 0.0, best.frequency_hz or 0.0, best.drive_angle_deg or 0.0))
    box = Question(spec, drive, highest).boxes(setting)
    least, most = (float(load) for load in box.load)
    with np.errstate(divide="ignore"):
        loads = {
            "the first part slips back": most / float(back_slip_load(box)),
            "the first part hops": most / float(hop_load(box)),
            "the last part starts": least / float(onset_load(box)),
        }
    return Chosen(drive, best, setting, loads, speed_costs(nominal_scene(spec, setting)))


def nominal_scene(spec: Spec, setting: Setting) -> Scene:
    """Return the scene of a setting in the middle of all bands."""
    box = Question(spec, spec.drives[0], Regime.BACK_SLIP).boxes(setting, 0.0)
    point = box.points(np.full((5, 1), 0.5))
    fields = {name: float(value[0]) for name, value in point._asdict().items() if name != "load"}
    return Scene(amplitude=setting.amplitude, frequency=setting.frequency, **fields, **box.constants)


def _mm(value: float) -> float | None:
    """Convert a length or a speed to the unit outside; None where there is no number."""
    return float(SPEED.from_si(value)) if math.isfinite(value) else None
