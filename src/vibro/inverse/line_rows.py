"""The designs of a drive along a line within one regime."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from vibro.inverse.amplitudes import Family
from vibro.inverse.optima import Optimiser
from vibro.inverse.rounding import in_si, outside, within
from vibro.inverse.rows import AT, NEARLY, Rows
from vibro.quantities import QUANTITIES
from vibro.results.designs import Interval

if TYPE_CHECKING:
    from collections.abc import Mapping

    from vibro.inverse.questions import Question, Setting
    from vibro.inverse.rows import Found

__all__ = ["LineRows"]

_NUDGES: Final = 4  # steps of the last digit that an amplitude may be moved inwards
_ROUNDING: Final = 1e-12  # relative, of conversions between units


class LineRows(Rows):
    """The designs of a drive along a line within one regime; the parameters are those of ``Rows``."""

    _surpluses = (0.0, 1e-6, 1e-5, 1e-4, 1e-3, 1e-2)
    _gentlest_above = "onset"
    _columns = ("amplitude_mm", "frequency_hz", "drive_angle_deg")
    _question: Question

    def __init__(self, question: Question, calmer: Mapping[str, Found]) -> None:
        super().__init__(question, Optimiser(question), calmer)

    def _roundings(self, setting: Any, digits: int, *, up: bool) -> list[tuple[tuple[float, ...], Setting]]:
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
        rounded = [(within(n * unit, "amplitude", ends, digits), *near) for n in steps]
        return [(printed, in_si(printed)) for printed in rounded]

    def _is_allowed(self, setting: Any) -> bool:
        """Tell whether a drive may be set so."""
        question, drive = self._question, self._question.drive
        inside = min(outside(ends, setting) for ends in question.ranges) <= _ROUNDING
        least, most = drive.amplitude
        load = float(question.load(setting))
        stroke = least * (1.0 - _ROUNDING) <= setting.amplitude <= most * (1.0 + _ROUNDING)
        return bool(inside and stroke and load <= drive.acceleration * (1.0 + _ROUNDING))

    def _limit(self, found: Found, scale: float) -> str:
        """Tell what keeps a setting from being better with bands of a scale."""
        question = self._question
        load = float(question.load(found.setting))
        if question.landings.scaled(NEARLY).worst(question.boxes(found.setting, scale)).size:
            return "limit"
        caps = question.caps(np.array([[found.setting.drive_angle]]), scale)
        name, cap = min(((name, float(cap[0, 0])) for name, cap in caps.items()), key=lambda pair: pair[1])
        if load >= cap * (1.0 - AT):
            return name
        most = question.drive.amplitude[1]
        return "limit" if found.setting.amplitude >= most * (1.0 - AT) else "speed"

    def _first_cap(self) -> str:
        """Tell what ends the load before any speed is guaranteed, in the middle of the drive angles."""
        middle = np.array([[float(np.mean(self._question.ranges[0].drive_angle))]])
        caps = {name: float(cap[0, 0]) for name, cap in self._question.caps(middle).items()}
        reach = max(self._question.reach(choice.frequency)[1] for choice in self._question.ranges)
        caps["limit"] = min(caps["limit"], reach)
        return min(caps, key=lambda name: caps[name])

    def _window(self, found: Found) -> Interval | None:
        """Return the amplitudes that keep the guarantee and hold the design."""
        question, setting = self._question, found.setting
        box = question.boxes(setting)
        w = 2.0 * math.pi * float(setting.frequency)
        least, most = question.drive.amplitude
        most = min(most, question.drive.acceleration * question.spec.gravity / w**2)
        family = Family(replace(box, amplitude=(1.0, 1.0)), question.spec.drift.amplitude, question.landings)
        others = {name: float(load) for name, load in question.tip_loads(box).items()}
        for i in family.intervals(self._target, question.highest, most, others, setting.amplitude):
            if i.low * (1.0 - AT) <= setting.amplitude <= i.high * (1.0 + AT):
                low, by = (i.low, i.low_set_by) if i.low >= least else (least, "limit")
                ends = min(low, setting.amplitude), max(i.high, setting.amplitude)
                return Interval(*ends, by, i.high_set_by)
        if found.guarantee.speed_min < self._target:
            return None
        beyond = family.ends_by(setting.amplitude, setting.amplitude * (1.0 + AT))
        return Interval(setting.amplitude, setting.amplitude, "speed", beyond)
