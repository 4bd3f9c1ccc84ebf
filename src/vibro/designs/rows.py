"""Find the designs of one drive within one regime, rounded so that they hold as printed; make table rows."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from functools import cache
from itertools import islice, product
from typing import TYPE_CHECKING, Any, Final

from vibro.designs.guarantees import BOXES, Seen, bound, guarantee_of
from vibro.designs.optima import EllipseOptimiser, LineOptimiser, MotionOptimiser
from vibro.designs.proofs import GAP
from vibro.designs.questions import MOST_DIGITS, nearest
from vibro.designs.spaces import TOLERANCES
from vibro.designs.windows import window_of
from vibro.drives import Ellipse, Harmonics, Line, Piecewise
from vibro.reals import rounded
from vibro.results.designs import Design
from vibro.steady import solve
from vibro.units import SPEED

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Mapping

    from vibro.designs.optima import Optimiser, Optimum
    from vibro.designs.questions import Drive, Met, Question
    from vibro.designs.spaces import AnySetting
    from vibro.results.designs import Guarantee, Interval

# ------------------------------------------------------------------------------
# Round settings to few digits in users' units.

#: Digits of printed settings: one unit of the last of four is at most 0.1 % of a value, as fine as a person
#: sets a drive.
DIGITS: Final = 4
_MORE: Final = (5, 6, 7, 9, 12, MOST_DIGITS)  # where a setting with fewer does not hold
_NUDGES: Final = 4  # steps of the last digit that knobs may be moved


def more_digits(digits: int) -> list[int]:
    """Return numbers of digits to try in turn until a setting holds."""
    return [digits, *(more for more in _MORE if more > digits)]


def roundings(drive: Drive, setting: AnySetting, digits: int, *, up: bool) -> Iterator[tuple[float, ...]]:
    """Return settings rounded to some digits in the units and quantities of the user, the nearest first.

    Every knob stays within its nearest range. Amplitudes keep the load at the rounded frequency, up to some
    steps inwards: upwards or downwards.
    """
    turned = {knob: float(x) for knob, x in drive.space.turned(setting).items()}
    values = {knob: float(drive.inputs[knob].printed(x)) for knob, x in turned.items()}

    def kept(knob: str, value: float) -> float:
        return drive.inputs[knob].rounded(value, turned[knob], digits)

    # where two constraints meet, one knob beside the optimum may leave room between them for the others
    beside = {
        knob: [kept(knob, x) for x in (values[knob], *_beside(values[knob], digits))]
        for knob in turned
        if knob not in drive.space.sizes
    }
    sizes, step = [knob for knob in turned if knob not in beside], 1 if up else -1
    nudges = [*product(range(-step, step * _NUDGES, step), repeat=len(sizes))]
    seen = set()
    for others in product(*map(dict.fromkeys, beside.values())):
        printed = dict.fromkeys(turned, 0.0) | dict(zip(beside, others, strict=True))
        growth = (values["frequency"] / printed["frequency"]) ** drive.space.power
        for steps in nudges:
            for knob, n in zip(sizes, steps, strict=True):
                printed[knob] = kept(knob, moved(values[knob] * growth, digits, n, up=up))
            found = tuple(printed.values())
            if found not in seen:
                seen.add(found)
                yield found


def _beside(value: float, digits: int) -> Iterator[float]:
    """Return values some steps of the last digit above and below, the nearest first."""
    size = abs(value)
    for n in range(1, _NUDGES):
        for steps in (n, -n):
            yield math.copysign(moved(size, digits, steps, up=False), value)


def setting_of(drive: Drive, printed: tuple[float, ...]) -> AnySetting:
    """Return the setting of knobs as they are printed."""
    inputs = zip(drive.inputs.items(), printed, strict=True)
    return drive.space.setting(**{knob: given.read(x) for (knob, given), x in inputs})


def moved(value: float, digits: int, steps: int, *, up: bool) -> float:
    """Round a value up or down to some digits, then move it by some steps of the last one."""
    if value == 0.0:
        return value
    unit = 10.0 ** (math.floor(math.log10(value)) - digits + 1)
    count = math.ceil(value / unit) if up else math.floor(value / unit)
    return (count + steps) * unit


KINDS: Final = ("gentlest", "fastest", "safest")
#: The same in the order in which they are searched.
SEARCHED: Final = ("fastest", "gentlest", "safest")
_MISSED: Final = 8  # roundings of one number of digits whose guarantee may miss a speed
_MARGINS: Final = 4  # roundings of one number of digits whose margin is searched
_COARSEST: Final = 1e-5  # relative: above the resolution of all margins in contact
_RAISED: Final = 3  # times that a goal is raised by what the proof falls short of the target
_CLOSE: Final = 1e-4  # [1] what roundings make up for, over the target
_LOWERED: Final = 10  # steps of the last digit by which the frequency of the nearest drive may be lowered
_OPTIMISERS: Final[Mapping[type, Callable[[Question], Optimiser]]] = {
    Line: LineOptimiser,
    Ellipse: EllipseOptimiser,
    Harmonics: MotionOptimiser,
    Piecewise: MotionOptimiser,
}


@dataclass(frozen=True)
class Rounded:
    """A setting as it is printed, its guarantee, its margin with the optimiser of that, and its optimum.

    Of a filled machine with its amplitudes and other numbers over all fillings.
    """

    setting: AnySetting
    printed: tuple[float, ...]
    guarantee: Guarantee
    margin: float | None = None
    optimiser: Optimiser | None = None
    optimum: Optimum | None = None
    met: Met | None = None


@dataclass(frozen=True)
class Finder:
    """Finds the designs of a question, and writes them as rows.

    Attributes
    ----------
    question : Question
        Drive, goal and bands.
    optimiser : Optimiser
        Finds optimal settings; it keeps the scenarios that it met.
    found : mapping of str to Rounded
        The designs by their kind; those that do not exist are left out.
    digits : int
        Of printed settings; there are more where a setting with fewer does not hold.
    refused : frozenset of str
        Designs of a machine that are left out, as its filling makes unknown or other amplitudes there.
    windows : dict
        Windows of amplitudes that are known, by their settings: those of bodies that bounce take seconds.
    """

    question: Question
    optimiser: Optimiser
    found: Mapping[str, Rounded]
    digits: int = DIGITS
    refused: frozenset[str] = frozenset()
    windows: dict[AnySetting, Interval | None] = field(default_factory=dict, compare=False)

    @property
    def target(self) -> float:
        """Target speed [m/s]."""
        return self.question.spec.goal.speed

    def set_by(self, kind: str) -> str | None:
        """Return the active constraint of a design; without a design only the fastest has one."""
        machine, by = self.question.drive.machine, self._set_by(kind)
        return machine.ended_by if by == "limit" and machine is not None else by

    def _set_by(self, kind: str) -> str | None:
        found, optimiser = self.found.get(kind), self.optimiser
        if kind in self.refused:
            return "filling"
        if found is None:
            return optimiser.first_cap() if kind == "fastest" else None
        if kind == "safest" and found.margin:
            return optimiser.limit(found.setting, found.margin)
        # an optimum is at its constraint, from which rounding moves the setting
        setting, speed = found.optimum or (found.setting, found.guarantee.speed_min)
        if kind != "gentlest":
            return optimiser.limit(setting, 1.0)
        if speed <= self.target * (1.0 + TOLERANCES.at):
            return "speed"
        least = optimiser.least_set_by(setting)
        # where parts may hop, the speed may jump past the target, and settings are sampled
        return "speed" if least == "onset" and self.question.flies else least

    def row(self, kind: str) -> Design:
        """Return a design as a row of a table; without a design the row has only what prevents it."""
        found, question = self.found.get(kind), self.question
        row = Design(
            drive=question.drive.name,
            highest_regime=question.highest.label,
            design=kind,
            set_by=self.set_by(kind),
        )
        if found is None:
            return row
        g, length, drive = found.guarantee, question.spec.length, question.drive
        columns = (given.quantity.column for given in drive.inputs.values())
        settings: dict[str, Any] = dict(zip(columns, found.printed, strict=True))
        row = replace(row, **settings, **self._of_machine(found))
        speed, size = g.speed_min, drive.size(found.setting)
        stem, unit = size.name.removeprefix("along_").removeprefix("normal_"), size.quantity.kind.suffix
        needed = self._nearest_drive(found, row.nominal or 0.0, settings["frequency_hz"])
        sizes: dict[str, Any] = {"frequency_needed_hz": needed[0], f"{stem}_needed{unit}": needed[1]}
        # what voltage and filling make of another amplitude is not covered
        is_covered = drive.machine is None or not drive.machine.is_filled
        if is_covered and (window := self._window(found)) is not None:
            low, high = (float(size.printed(end)) for end in window[:2])
            sizes |= {f"{stem}_low{unit}": low, "low_set_by": window.low_set_by}
            sizes |= {f"{stem}_high{unit}": high, "high_set_by": window.high_set_by}
        throw, (least, most) = question.box(found.setting).throw_number, question.spec.bounces
        if throw > 1.0:
            row = replace(
                row,
                restitution_low=least,
                restitution_high=most,
                restitution_assumed=question.spec.restitution is None,
            )
        return replace(
            row,
            **sizes,
            acceleration_g=float(question.load(found.setting)),
            speed_min_mm_s=_mm(speed),
            speed_proved_mm_s=_mm(g.proved_min),
            speed_found_mm_s=_mm(g.found_min),
            speed_nominal_mm_s=_mm(float(solve(question.nominal_scene(found.setting)).mean_velocity)),
            speed_max_mm_s=_mm(g.speed_max),
            traverse_time_max_s=length / speed if length is not None and speed > 0.0 else None,
            margin=found.margin,
            throw_number_max=throw,
            proof=g.proof_min,
            coexists=g.coexists,
            samples=g.samples,
            excluded=g.excluded,
        )

    def _window(self, found: Rounded) -> Interval | None:
        """Return the amplitudes around a design that keep its goal, as ``window_of`` does."""
        if found.setting not in self.windows:
            self.windows[found.setting] = window_of(self.question, found.setting, found.guarantee)
        return self.windows[found.setting]

    def _of_machine(self, found: Rounded) -> dict[str, Any]:
        """Return the columns of a machine: its spring pack, and its amplitudes at a setting."""
        machine = self.question.drive.machine
        if machine is None:
            return {}
        amplitude = float(self.question.space.amplitude(found.setting))
        empty, met = amplitude / machine.middle, found.met
        more: dict[str, Any] = {}
        if met is not None:
            more = {
                "operating_points": met.number,
                "second_harmonic_percent": 100.0 * met.second_harmonic,
                "speed_second_harmonic_mm_s": _mm(met.speed),
            }
        return {
            "pack": machine.pack or None,
            "natural_hz": machine.natural_frequency,
            "amplitude_mm": _mm(amplitude),
            "amplitude_empty_mm": _mm(empty),
            "amplitude_least_mm": _mm(machine.covered[0] * empty),
            "amplitude_most_mm": _mm(machine.covered[1] * empty),
            **more,
        }

    def designs(
        self,
        calmer: Mapping[str, Rounded],
        tell: Callable[[str], None] = lambda _: None,
        until: str = SEARCHED[-1],
    ) -> dict[str, Rounded]:
        """Find the designs, by their kind; ``tell(kind)`` reports the search, ``until`` is the last kind."""
        if not self.optimiser.has_more():
            return dict(calmer)
        found: dict[str, Rounded] = {}
        searches: dict[str, Callable[[], Rounded | None]] = {
            "fastest": self._fastest,
            "gentlest": self._least_acceleration,
            "safest": self._safest if self.question.spec.has_bands else lambda: found["fastest"],
        }
        for kind in SEARCHED:
            tell(kind)
            best = self._best(kind, searches[kind](), calmer, *found.values())
            if best is None:
                return {}
            found[kind] = best
            if found["fastest"].guarantee.speed_min < self.target or (kind == until != SEARCHED[-1]):
                return found
        # A search with sampled bodies may miss the best setting, and another of these may be better.
        for kind in ("fastest", "gentlest"):
            found[kind] = max(found.values(), key=lambda one: best_of(kind, self.question, one))
        return found

    def _fastest(self) -> Rounded | None:
        """Return the fastest setting that holds as printed.

        Few digits might lose speed, as it drops just past the load at which back slip enters, and even the
        goal. So roundings that keep the goal and nearly all of the speed are taken first.
        """
        optimum = self.optimiser.fastest()
        speed = 0.0 if optimum is None else max(self._bound(optimum), 0.0)
        for nearly in (True, False):
            goal = self.target if nearly and speed >= self.target else 0.0
            for digits in more_digits(self.digits):
                least = max(goal, speed * (1.0 - 10.0 ** (2 - digits))) if nearly else 0.0
                for found in self._rounded(optimum, digits, least, goal, up=False):
                    return found
        return None

    def _safest(self) -> Rounded | None:
        """Return the setting of the largest margin that holds as printed, with nearly that margin."""
        optimum, best = self.optimiser.safest(self.target), None
        if optimum is None:
            return None
        widest = self.optimiser.margin(optimum.setting, self.target) or 0.0
        for digits in more_digits(self.digits):
            for found in islice(self._rounded(optimum, digits, self.target, self.target, up=False), _MARGINS):
                best = self._best("safest", found, {}, *filter(None, [best]))
                if best and (best.margin or 0.0) >= widest * (1.0 - max(10.0 ** (2 - digits), _COARSEST)):
                    return best
        return best

    def _rounded(
        self, optimum: Optimum | None, digits: int, least: float, target: float, *, up: bool
    ) -> Iterator[Rounded]:
        """Yield the roundings whose scenarios reach one speed, and whose guarantee reaches another."""
        if optimum is None:
            return
        drive, missed = self.question.drive, 0
        for printed in roundings(drive, optimum.setting, digits, up=up):
            setting = setting_of(drive, printed)
            if not self.optimiser.holds(setting, least):
                continue
            found = Rounded(setting, printed, guarantee_of(self.question.box(setting)), optimum=optimum)
            g = found.guarantee
            if g.speed_min >= target and self.optimiser.keeps_to_regime(setting, g.regimes):
                yield found
            else:
                missed += 1
            if missed == _MISSED:
                return

    def _least_acceleration(self) -> Rounded | None:
        """Return the least-acceleration setting that holds as printed.

        Where the speed just reaches the target and back slip just enters, no rounded setting may hold. Then
        the optimum for a slightly higher target is rounded: by about as much as the rounding changes it, or
        in the end by whatever it takes.
        """
        best = cache(self.optimiser.least_acceleration)
        goal = self._raised(best)
        ladder = more_digits(self.digits)
        for digits in ladder:
            step = max(10.0 ** (1 - digits), GAP)  # the proof may miss the target by the latter
            for surplus in self.optimiser.surpluses:
                if not surplus or step <= surplus <= 10.0 * step or digits == ladder[-1]:
                    for found in self._rounded(
                        best(goal * (1.0 + surplus)), digits, self.target, self.target, up=True
                    ):
                        return replace(found, optimum=best(self.target))
        return None

    def _bound(self, optimum: Optimum) -> float:
        """Return the bound on the speeds of all parts at an optimum; its own, found, where none is proved."""
        question = self.question
        if question.flies or not question.space.is_bounded:
            return optimum.speed
        box = question.box(optimum.setting)
        return min(bound(box, fast=False, seen=Seen(), boxes=BOXES).speed, optimum.speed)

    def _raised(self, best: Callable[[float], Optimum | None]) -> float:
        """Return the speed of the slowest part found at whose gentlest setting the target is proved [m/s]."""
        goal = self.target
        for _ in range(_RAISED):
            optimum = best(goal)
            proved = 0.0 if optimum is None else self._bound(optimum)
            if not 0.0 < proved < self.target * (1.0 - _CLOSE):
                break
            goal *= self.target / proved
        return goal

    def _best(
        self, kind: str, new: Rounded | None, calmer: Mapping[str, Rounded], *others: Rounded
    ) -> Rounded | None:
        """Return the best of some designs, with its margin; None without any."""
        known = [found for found in (new, calmer.get(kind), *others) if found is not None]
        if kind == "safest":
            known = [self._with_margin(found) for found in known]
        if not known:
            return None
        return self._with_margin(max(known, key=lambda found: best_of(kind, self.question, found)))

    def _with_margin(self, found: Rounded) -> Rounded:
        """Add the margin of a design: at least 1 where it meets the goal."""
        if found.optimiser is self.optimiser or not self.question.spec.has_bands:
            return found
        margin = self.optimiser.margin(found.setting, self.target)
        if found.guarantee.speed_min >= self.target:  # a margin within a lower regime holds here too
            margin = max(margin or 1.0, found.margin or 1.0, 1.0)
        return replace(found, margin=margin, optimiser=self.optimiser)

    def _nearest_drive(
        self, found: Rounded, size: float, frequency: float
    ) -> tuple[float, float] | tuple[None, None]:
        """Return frequency and amplitude, or stroke, of the nearest drive that meets the goal [Hz, mm].

        At one load the speed is proportional to 1/f. The amplitude is rounded down, so that the load is not
        exceeded, and the frequency is lowered until the goal is met. None if the goal is met already, if the
        drive conveys nothing, and if parts would land too hard.
        """
        speed, power = found.guarantee.speed_min, self.question.space.power
        # another frequency changes a machine's amplitude, but on soft mounts
        machine = self.question.drive.machine
        if speed >= self.target or not speed > 0.0 or (machine is not None and not machine.is_plain):
            return None, None
        for digits in more_digits(self.digits):
            for steps in range(_LOWERED):
                needed = nearest(moved(frequency * speed / self.target, digits, -steps, up=False), digits)
                larger = rounded(size * (frequency / needed) ** power, digits, down=True)
                # a lower load is slower, and mostly by more than its own share
                if speed * larger * needed ** (power - 1) < self.target * size * frequency ** (power - 1):
                    continue
                setting = found.setting.scaled(larger / size)._replace(frequency=needed)
                box = self.question.box(setting)
                if self.question.landings.worst(box).size:
                    return None, None
                if guarantee_of(box).speed_min >= self.target:
                    return needed, larger
        return None, None


def best_of(kind: str, question: Question, found: Rounded) -> float:
    """Return the merit of a design: the best of a kind has the largest."""
    if kind == "fastest":
        return found.guarantee.speed_min
    return -float(question.load(found.setting)) if kind == "gentlest" else found.margin or 0.0


def find(
    question: Question,
    calmer: Mapping[str, Rounded],
    digits: int = DIGITS,
    tell: Callable[[str], None] = lambda _: None,
    *,
    until: str = SEARCHED[-1],
) -> Finder:
    """Find the gentlest, the fastest and the safest setting that hold as they are printed.

    Parameters
    ----------
    question : Question
        Drive, goal and bands.
    calmer : mapping of str to Rounded
        The designs within a lower regime, which are candidates here too.
    digits : int, optional
        Of printed settings.
    tell : callable, optional
        ``tell(kind)`` says which design is searched.
    until : str, optional
        Kind of design that is searched last, in the order of ``SEARCHED``.
    """
    finder = finder_of(question, digits)
    return replace(finder, found=finder.designs(calmer, tell, until))


def finder_of(question: Question, digits: int = DIGITS) -> Finder:
    """Return the finder of a question, without designs."""
    return Finder(question, _OPTIMISERS[question.drive.kind](question), {}, digits)


def _mm(value: float) -> float | None:
    """Convert a length or a speed to users' units; None if it is not finite."""
    return float(SPEED.from_si(value)) if math.isfinite(value) else None
