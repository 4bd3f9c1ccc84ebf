"""Times of rows: clocks of any form, and what loggers do to them."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, Any, Final

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from vibro.reals import Floats

#: A time of day, with a date, a part of the day and a zone or without: hours may be missing.
CLOCK: Final = re.compile(
    r"(?:([\w./-]{6,24}?|[A-Za-z]{3,9}\.? [0-9]{1,2}[,.] [0-9]{4})(?:[Tt]|\s+))?"
    r"(?:([0-9]{1,3}):)?([0-9]{1,2}):([0-9]{1,2})(?:([.,:])([0-9]{1,9}))?"
    r"\s*(?:([AaPp])\.?[Mm]\.?)?\s*(?:Z|UTC|GMT|[+-][0-9][0-9](?::?[0-9][0-9])?)?"
)
_DAY, _HOUR = 86400.0, 3600.0
#: Seconds since 1970 of the years 2001 to 2096, and the units in which programs write them.
_EPOCH: Final = 1e9, 4e9
_EPOCH_UNITS: Final = (1.0, 1e-3, 1e-6, 1e-9)
#: Of a step: the least coarseness of a clock that is made even, and the largest at which no rows are lost;
#: the largest deviation of a clock that is even but for its digits, over its last digit.
_COARSE, _LOSSLESS, _OFF = 0.05, 0.8, 1.1
_ON_GRID: Final = 1e-3  # of the last digit: rounding of times
_LEAST: Final = 5  # steps of each kind that tell a coarse clock from rows that are lost or written twice
#: Probability at which runs one after another may look like a counter that overflows.
_COINCIDENCE: Final = 0.01


def is_clock(cells: NDArray[Any]) -> bool:
    """Whether a column holds times of day: its first cell with a text is one."""
    first = next(filter(None, cells), "") if cells.dtype == object else ""
    return CLOCK.fullmatch(first) is not None


def epoch_unit(value: float, stated: float | None) -> float | None:
    """Return the unit [s] of a time since 1970; None if it may be another time in the stated unit."""
    low, high = _EPOCH
    if stated is not None and abs(value) * stated <= high:
        return None
    return next((unit for unit in _EPOCH_UNITS if low <= value * unit <= high), None)


def seconds_of(cells: NDArray[Any]) -> tuple[Floats, Floats]:
    """Read times of day.

    Parameters
    ----------
    cells : array of str
        Such as ``10:00:59.002``, ``10:00:59:002``, ``00:59,002`` or ``2031-01-02T10:00:59.002Z``.

    Returns
    -------
    time : float array
        Since the first midnight [s]; NaN where there is none.
    periods : float array
        Times after which such a clock starts anew [s]; none if it has dates.
    """
    found = [CLOCK.fullmatch(cell) for cell in cells]
    digits = max(
        (len(m[6]) for m in found if m and m[5] == ":"), default=0
    )  # milliseconds, say, not decimals
    time, date, days = np.full(len(found), np.nan), "", -1
    for i, m in enumerate(found):
        if m:
            days, date = days + (m[1] != date or days < 0), m[1] or ""
            part = 0.0 if not m[6] else int(m[6]) / 10.0 ** (digits if m[5] == ":" else len(m[6]))
            hour = int(m[2] or 0)
            if m[7]:
                hour = hour % 12 + 12 * (m[7] in "Pp")
            time[i] = (hour * 60.0 + int(m[3])) * 60.0 + int(m[4]) + part + (days * _DAY if m[1] else 0.0)
    first = next(m for m in found if m)
    halves = not first[7] and bool(np.nanmax(time) < 13.0 * _HOUR)
    periods = () if first[1] else (_HOUR,) if not first[2] else (_DAY, 0.5 * _DAY) if halves else (_DAY,)
    return time, np.array(periods)


def overflows(unit: float, *, whole: bool) -> Floats:
    """Return after which times [s] clocks and counters start anew, of a column of numbers in a unit [s]."""
    counts = sorted({1e-6, 1e-3, unit if whole else 1e-3})
    return np.array([_DAY, *(2.0**bits * count for bits in (16, 32) for count in counts)])


def unwrapped(time: Floats, periods: Iterable[float]) -> tuple[Floats, float, int]:
    """Continue a clock that starts anew; return the time, the period, and how often: 0 if it does not."""
    steps = np.diff(time)
    back = steps < 0.0
    count = int(np.count_nonzero(back))
    if count == 0 or count == steps.size:
        return time, 0.0, 0
    usual = float(np.median(steps[~back]))
    off = {
        p: float(np.max(np.abs(steps[back] + p - usual)))
        for p in periods
        if min(usual / p, 1.0) ** count <= _COINCIDENCE
    }
    period = min(off, key=lambda p: off[p], default=0.0)
    if period == 0.0 or off[period] > 0.5 * usual or np.ptp(time) >= period:
        return time, 0.0, 0
    return time + period * np.concatenate([[0.0], np.cumsum(back)]), period, count


def evened(time: Floats) -> Floats | None:
    """Return an even clock in place of one whose last digit is coarse; None if it is not even but for that.

    Such as whole milliseconds at 1600 rows a second, of which neighbours are equal. The even clock is that
    whose largest distance from the given times is least, and no greater than the last digit allows.
    """
    rows = np.arange(time.size, dtype=np.float64)
    mean = float(time[-1] - time[0]) / max(1, time.size - 1)
    steps = np.diff(time) / mean if mean > 0.0 else np.zeros(1)
    kinds, counts = np.unique(np.round(steps, 6), return_counts=True)
    if kinds.size < 2 or np.sort(counts)[-2] < _LEAST:
        return None
    tick = float(np.diff(np.union1d(kinds, 0.0)).min())
    if np.abs(kinds / tick - np.round(kinds / tick)).max() > _ON_GRID or tick < _COARSE:
        return None
    if kinds[0] > 0.0 and tick > _LOSSLESS:
        return None
    from scipy.optimize import minimize_scalar

    reach = 2.0 * tick * mean / time.size
    found = minimize_scalar(
        lambda step: float(np.ptp(time - step * rows)), bounds=(mean - reach, mean + reach), method="bounded",
        options={"xatol": 1e-6 * reach},
    )  # fmt: skip
    step = float(found.x)
    off = time - step * rows
    even: Floats = step * rows + 0.5 * (off.min() + off.max())
    return even if np.ptp(off) <= _OFF * tick * mean else None


def held(values: Floats) -> int:
    """Return how many rows hold each value of a slower signal, and take it out of all but the first."""
    changes = np.flatnonzero(np.diff(values) != 0.0) + 1
    every = int(np.gcd.reduce(np.diff(changes))) if changes.size >= _LEAST else 1
    if every > 1 and 2 * changes.size * every < values.size:
        return 1
    if every > 1:
        values[np.arange(values.size) % every != changes[0] % every] = np.nan
    return every


def mended(
    time: Floats, periods: Floats, signals: Sequence[Floats]
) -> tuple[Floats, NDArray[np.bool_], list[str]]:
    """Continue, thin out or even a clock where that is certain; return copies, and notes too."""
    notes, copies, rows = list[str](), np.zeros(time.size, np.bool_), np.flatnonzero(~np.isnan(time))
    time = time.copy()
    time[rows], period, count = unwrapped(time[rows], periods)
    if count:
        often = f"{count} times" if count > 1 else "once"
        notes.append(f"the time starts anew {often}, after {period:.9g} s: it is counted on")
    again = np.flatnonzero(np.diff(time[rows]) == 0.0) + 1
    now, before = rows[again], rows[again - 1]
    if again.size and all(np.array_equal(x[now], x[before], equal_nan=True) for x in signals):
        copies[now], rows = True, np.delete(rows, again)
        repeat = "rows repeat" if again.size > 1 else "row repeats"
        notes.append(f"{again.size} {repeat} the row before: left out")
    if np.all(np.diff(time[rows]) >= 0.0) and (even := evened(time[rows])) is not None:
        time[rows] = even
        rate = (rows.size - 1) / (even[-1] - even[0])
        notes.append(f"the digits of the time are coarse: it is taken as even, {rate:.7g} rows a second")
    return time, copies, notes
