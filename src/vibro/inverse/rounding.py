"""Round settings to few digits in users' units."""

from __future__ import annotations

import math
from decimal import ROUND_CEILING, ROUND_FLOOR, Context
from itertools import product
from typing import TYPE_CHECKING, Final

from vibro.quantities import QUANTITIES

if TYPE_CHECKING:
    from collections.abc import Iterator

    from vibro.inverse.spaces import AnySetting
    from vibro.inverse.specs import Drive, Span

__all__ = ["DIGITS", "MOST_DIGITS", "more_digits", "moved", "rounded", "roundings", "setting_of", "within"]

#: Digits of printed settings: one unit of the last of four is at most 0.1 % of a value, as fine as a person
#: sets a drive.
DIGITS: Final = 4
#: Digits that reproduce every value that a user gives.
MOST_DIGITS: Final = 15
_MORE: Final = (5, 6, 7, 9, 12, MOST_DIGITS)  # where a setting with fewer does not hold
_NUDGES: Final = 4  # steps of the last digit that knobs may be moved
# [1] Distance from an end that is none: above the rounding of an optimum there, below all digits chosen.
_AT_END: Final = 1e-9


def more_digits(digits: int) -> list[int]:
    """Return numbers of digits to try in turn until a setting holds."""
    return [digits, *(more for more in _MORE if more > digits)]


def roundings(drive: Drive, setting: AnySetting, digits: int, *, up: bool) -> Iterator[tuple[float, ...]]:
    """Return settings rounded to some digits in the units and quantities of the user, the nearest first.

    Every knob stays within its nearest range. Amplitudes keep the load at the rounded frequency, up to some
    steps inwards: upwards or downwards.
    """
    turned = {knob: float(x) for knob, x in drive.space.turned(setting).items()}
    names = dict(zip(turned, drive.told, strict=True))
    scales = {knob: drive.scale(knob) for knob in turned}
    values = {knob: float(QUANTITIES[names[knob]].from_si(x * scales[knob])) for knob, x in turned.items()}
    nearest_ends = {knob: drive.nearest(knob, x) for knob, x in turned.items()}
    ends = {knob: (low * scales[knob], high * scales[knob]) for knob, (low, high) in nearest_ends.items()}

    def kept(knob: str, value: float) -> float:
        return within(value, names[knob], ends[knob], digits)

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
    told = zip(drive.space.knobs, drive.told, printed, strict=True)
    knobs = {knob: QUANTITIES[name].to_si(x) / drive.scale(knob) for knob, name, x in told}
    return drive.space.setting(**knobs)


def within(value: float, name: str, ends: Span, digits: int) -> float:
    """Round a value in users' units, but not beyond its range, whose ends are kept as they were given.

    One that may be 0 has no more decimals than a value from 10 to 100 with that many digits.
    """
    quantity = QUANTITIES[name]
    low, high = (nearest(float(quantity.from_si(end)), MOST_DIGITS) for end in ends)
    for end in (low, high):
        if math.isclose(value, end, rel_tol=_AT_END):
            return end
    value = nearest(value, digits)
    if quantity.allowed.low < 0.0:
        value = round(value, digits - 2)
    return min(max(value, low), high)


def rounded(value: float, digits: int, *, down: bool) -> float:
    """Round to so many digits in one direction."""
    rounding = ROUND_FLOOR if down else ROUND_CEILING
    return float(Context(prec=digits, rounding=rounding).create_decimal(repr(value)))


def nearest(value: float, digits: int) -> float:
    """Round to so many digits."""
    return float(f"{value:.{digits}g}")


def moved(value: float, digits: int, steps: int, *, up: bool) -> float:
    """Round a value up or down to some digits, then move it by some steps of the last one."""
    if value == 0.0:
        return value
    unit = 10.0 ** (math.floor(math.log10(value)) - digits + 1)
    count = math.ceil(value / unit) if up else math.floor(value / unit)
    return (count + steps) * unit
