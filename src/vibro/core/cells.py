"""Where a periodic load changes its sign: all zeros of a wave, proved cell by cell.

On a cell of length d a function with a fourth derivative of at most M differs from the cubic through its
values and slopes at both ends by M d^4/384 at most, its slope from the cubic's by sqrt(3) M d^3/216. A cubic
lies within the hull of its Bernstein coefficients. So coefficients of one sign, beyond the first bound, say
that there is no zero, and those of the slope, beyond the second one, that there is one at most. A cell for
which neither holds is halved. Polynomial pieces are cubics themselves: M = 0.
"""

from __future__ import annotations

import math
from typing import Final, NamedTuple

from vibro.core.numbers import AT_EVENT, EPS, HARMONICS, INF, TURN, Value, until, wrap
from vibro.core.waves import (
    Mix,
    Waves,
    at_cell_begin,
    cell_begin,
    cells_of,
    combine,
    curve_in_cell,
    nodes_of,
    part_of,
    place_in,
    value_at_cell_begin,
    value_in_cell,
)

_VALUE_BOUND: Final = 1.0 / 384.0
_SLOPE_BOUND: Final = 0.00801875373874480  # sqrt(3) / 216
# [1] Share of a cell at which a doubtful zero, double to rounding, is left to the signs.
_NARROW: Final = 1e-9
_ROUNDED: Final = 1e-11  # [1] rise over a maximum, of which a hundred thousandth is unknown
_SETTLED: Final = 1e-5  # [1] of a cell: a step of Halley's below leaves an error of its cube, a rounding
# [zero] looked at one by one; of more of them those so many places beside the next one, and the first two
_MANY: Final = 8
_BESIDE: Final = 2
_STEPS: Final = 60  # of such iterations with halvings, in a bracket
# [part] of a cell that are looked at. Those next to a double zero, or a maximum, are halved some 30 times,
# and a cell has few of them. Where squares of loads are no doubles no part has a bound.
_MOST_PARTS: Final = 10_000

# What is known of a cell: no zero, or at most one as the function is monotone, or neither.
_NONE: Final = 0
_MONOTONE: Final = 1
_OPEN: Final = 2


class Event(NamedTuple):
    """A zero that lies ahead: its phase in [0, 2 pi), and the phase until then; inf where there is none."""

    phase: float
    wait: float


def find_nodes(waves: Waves, row: int, mix: Mix) -> None:
    """Find where a mix changes its sign, and keep these phases in a row, in order.

    A jump counts as a zero, a touch does not.
    """
    bounds, constant = combine(waves, mix), mix.constant
    noise = 4.0 * EPS * bounds.size
    cells, start, count = cells_of(waves), nodes_of(waves, row), 0
    at_begin = value_at_cell_begin(waves, 0, mix)
    positive = at_begin > 0.0
    if waves.kind != HARMONICS:
        positive = value_in_cell(waves, cells - 1, constant, TURN).value > 0.0
    flat = bounds.slope * TURN / cells
    for cell in range(cells):
        onward = cell + 1 if cell + 1 < cells else 0
        at_end = value_at_cell_begin(waves, onward, mix)
        # far from zero at both ends, beside the largest slope
        if (at_end > 0.0) == positive and abs(at_begin + at_end) > flat:
            at_begin = at_end
            continue
        low, end = cell_begin(waves, cell), cell_begin(waves, cell + 1)
        whole = end - low
        here, width = at_cell_begin(waves, cell, mix), whole
        if waves.kind == HARMONICS:
            there = at_cell_begin(waves, onward, mix)
        else:
            there = value_in_cell(waves, cell, constant, end)
            if (here.value > 0.0) != positive:
                count = _keep(waves, start, count, low)
                positive = not positive
        for _ in range(_MOST_PARTS):
            known = _verdict(here, there, width, bounds.fourth, noise)
            if known == _OPEN and width > _NARROW * whole:
                width *= 0.5
                there = value_in_cell(waves, cell, constant, low + width)
                continue
            if known != _NONE and (there.value > 0.0) != positive:
                zero = _zero(waves, cell, constant, low, low + width, here, there)
                count = _keep(waves, start, count, zero)
                positive = not positive
            low, here = low + width, there
            if low >= end:
                break
            width = min(2.0 * width, end - low)
            there = value_in_cell(waves, cell, constant, low + width)
        at_begin = at_end
    waves.mark[2 * row], waves.mark[2 * row + 1] = count, 1 if positive else 0


def forget_nodes(waves: Waves, row: int) -> None:
    """Mark a row as unknown: the number of its zeros is negative."""
    waves.mark[2 * row] = -1


def _keep(waves: Waves, start: int, count: int, phase: float) -> int:
    """Write down a zero, as long as there is room: a wave has no more of them than coefficients."""
    if count == part_of(waves):
        return count
    waves.number[start + count] = min(max(phase, 0.0), TURN * (1.0 - EPS))
    return count + 1


def _verdict(here: Value, there: Value, d: float, bound: float, noise: float) -> int:
    """Tell what is known of a cell from values and slopes at its ends."""
    third = d / 3.0
    inner, outer = here.value + third * here.slope, there.value - third * there.slope
    low = min(min(here.value, there.value), min(inner, outer))
    high = max(max(here.value, there.value), max(inner, outer))
    error = bound * d * d * d * d * _VALUE_BOUND
    if low > error or high < -error:
        return _NONE
    middle = (outer - inner) / third
    flat = bound * d * d * d * _SLOPE_BOUND
    if min(min(here.slope, there.slope), middle) > flat or max(max(here.slope, there.slope), middle) < -flat:
        return _MONOTONE
    return _MONOTONE if max(high, -low) <= noise else _OPEN


def _zero(
    waves: Waves, cell: int, constant: float, low: float, high: float, here: Value, there: Value
) -> float:
    """Find the zero in a bracket of both signs: Halley's iteration, or halving where that leaves it."""
    rises, width = there.value > here.value, high - low
    x = low + width * _share(here, there, width)
    for _ in range(_STEPS):
        at = curve_in_cell(waves, cell, constant, x)
        if (at.value > 0.0) == rises:
            high = x
        else:
            low = x
        scale = at.slope * at.slope - 0.5 * at.value * at.bend
        onward = x - at.value * at.slope / scale if scale > 0.0 else INF
        inside = low <= onward <= high
        if not inside:
            onward = 0.5 * (low + high)
        step, x = abs(onward - x), onward
        # the next step would be of the cube of this one, over the square of the distance from a double zero
        error, most = step * step * step * at.bend * at.bend, EPS * x * at.slope * at.slope
        if step <= EPS * x or (inside and step <= _SETTLED * width and error <= most):
            break
    return x


def _share(here: Value, there: Value, d: float) -> float:
    """Return where in a cell the cubic through its ends is 0, about: a secant, and two steps of Newton's."""
    a, b = here.value, there.value
    if a == b:
        return 0.0
    p, q = d * here.slope, d * there.slope
    bend, turn = 3.0 * (b - a) - 2.0 * p - q, 2.0 * (a - b) + p + q
    x = a / (a - b)
    for _ in range(2):
        slope = p + x * (2.0 * bend + x * 3.0 * turn)
        if slope != 0.0:
            x = min(max(x - (a + x * (p + x * (bend + x * turn))) / slope, 0.0), 1.0)
    return x


def largest(waves: Waves, mix: Mix) -> float:
    """Return the largest value of a mix.

    Only cells in which the wave may exceed what was found so far are halved, until it rises to one maximum
    in them. The one that rises from the highest end, or to it, comes first. inf where a cell has no bound.
    """
    bounds, cells, most, first = combine(waves, mix), cells_of(waves), -INF, 0
    if waves.kind == HARMONICS:
        for cell in range(cells):
            value = value_at_cell_begin(waves, cell, mix)
            if value > most:
                most, first = value, cell
        if at_cell_begin(waves, first, mix).slope < 0.0:
            first += cells - 1
    width = TURN / cells
    bow = bounds.bend * width * width / 8.0  # the wave is nowhere further above a chord of a cell
    for i in range(cells):
        cell = (first + i) % cells
        onward = cell + 1 if cell + 1 < cells else 0
        if waves.kind == HARMONICS:
            above = max(value_at_cell_begin(waves, cell, mix), value_at_cell_begin(waves, onward, mix)) + bow
            if above <= most:
                continue
        most = _largest_in_cell(waves, mix, cell, onward, bounds.fourth, most)
    return most


def _largest_in_cell(waves: Waves, mix: Mix, cell: int, onward: int, fourth: float, most: float) -> float:
    """Return the largest value of a mix in a cell, or ``most`` if that is larger."""
    low, end, constant = cell_begin(waves, cell), cell_begin(waves, cell + 1), mix.constant
    whole = end - low
    here, width = at_cell_begin(waves, cell, mix), whole
    if waves.kind == HARMONICS:
        there = at_cell_begin(waves, onward, mix)
    else:
        there = value_in_cell(waves, cell, constant, end)
        most = max(most, max(here.value, there.value))
    for _ in range(_MOST_PARTS):
        top = _highest(here, there, width, fourth)
        if top > most + EPS * abs(most) and width > _NARROW * whole:
            if here.slope > 0.0 > there.slope and _is_concave(here, there, width, fourth):
                most = max(most, _maximum(waves, cell, constant, low, low + width, here, there))
            else:
                width *= 0.5
                there = value_in_cell(waves, cell, constant, low + width)
                most = max(most, there.value)
                continue
        low, here = low + width, there
        if low >= end:
            return most
        width = min(2.0 * width, end - low)
        there = value_in_cell(waves, cell, constant, low + width)
    return INF


def _highest(here: Value, there: Value, d: float, bound: float) -> float:
    """Bound a wave from above in a cell."""
    third = d / 3.0
    inner, outer = here.value + third * here.slope, there.value - third * there.slope
    high = max(max(here.value, there.value), max(inner, outer))
    return high + bound * d * d * d * d * _VALUE_BOUND


def _is_concave(here: Value, there: Value, d: float, bound: float) -> bool:
    """Return whether a wave is concave in a cell: the cubic's second derivative is within M d^2 / 12."""
    rise = 6.0 * (there.value - here.value) / d
    bend, turn = rise - 4.0 * here.slope - 2.0 * there.slope, 2.0 * here.slope + 4.0 * there.slope - rise
    return max(bend, turn) < -bound * d * d * d / 12.0


def _maximum(
    waves: Waves, cell: int, constant: float, low: float, high: float, here: Value, there: Value
) -> float:
    """Return the maximum of a wave in a bracket in which it is concave: Newton's iteration on its slope."""
    most = max(here.value, there.value)
    x = low + (high - low) * _top(here, there, high - low)
    for _ in range(_STEPS):
        at = curve_in_cell(waves, cell, constant, x)
        if at.slope < 0.0:
            high = x
        else:
            low = x
        most = max(most, at.value)
        # the parabola with this slope and curvature rises so much further; far from the top it may overshoot
        rise = -0.5 * at.slope * at.slope / at.bend if at.bend < 0.0 else 0.0
        if rise <= _ROUNDED * abs(most):  # only now is it known: farther off the parabola may be too high
            return max(most, at.value + rise)
        onward = x - at.slope / at.bend
        x = onward if low < onward < high else 0.5 * (low + high)
    return most


def _top(here: Value, there: Value, d: float) -> float:
    """Return where in a cell the cubic through its ends is highest, which rises at its start alone."""
    p, q, rise = here.slope, there.slope, 3.0 * (there.value - here.value) / d
    # its slope is p - 2 m x + (p + q - 2 (rise - p - q)) x^2
    m = 2.0 * p + q - rise
    root = math.sqrt(max(m * m - p * (3.0 * (p + q) - 2.0 * rise), 0.0))
    return min(p / (m + root), 1.0) if m + root > 0.0 else p / (p - q)


def number_of_nodes(waves: Waves, row: int) -> int:
    """Return how many zeros of a row there are in a period."""
    return waves.mark[2 * row]


def behind(waves: Waves, row: int, index: int) -> bool:
    """Return whether the load is positive behind the zero of an index, in front of the next one."""
    positive = waves.mark[2 * row + 1] == 1
    return positive == ((number_of_nodes(waves, row) - 1 - index) % 2 == 0)


def next_event(waves: Waves, row: int, rising: bool, phase: float) -> Event:
    """Return the next zero of a row at which the load rises, or falls; one that the phase is at counts."""
    start, count, found = nodes_of(waves, row), number_of_nodes(waves, row), Event(INF, INF)
    low, high, others = 0, count, 0
    if count > _MANY:  # zeros are in order: the next one is the first of them ahead, or the first of the turn
        place = place_in(waves, start, count, wrap(phase - AT_EVENT))
        low, high, others = max(place - _BESIDE, 0), min(place + _BESIDE + 1, count), 2
    for k in range(-others, high - low):
        i = k + 2 if k < 0 else low + k
        if i < count and behind(waves, row, i) == rising:
            zero = waves.number[start + i]
            wait = until(zero, phase)
            if wait < found.wait:
                found = Event(zero, wait)
    return found
