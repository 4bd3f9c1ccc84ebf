"""Compute the data of the design pictures: what parts do at the settings around a design."""

from __future__ import annotations

import math
from dataclasses import replace
from itertools import product
from typing import TYPE_CHECKING, Final

import numpy as np

from vibro.core.codes import Regime
from vibro.designs.guarantees import counted
from vibro.designs.proofs import corners, first_ratio, last_ratio, tip_ratio
from vibro.designs.questions import Question
from vibro.designs.spaces import TOLERANCES
from vibro.designs.windows import span_of
from vibro.results.designs import SettingFields, SpeedBand
from vibro.steady import solve
from vibro.units import SPEED

if TYPE_CHECKING:
    from vibro.designs.design import Chosen
    from vibro.designs.questions import Spec
    from vibro.designs.spaces import UncertaintySet
    from vibro.reals import Floats

    Begins = dict[Regime, tuple[float, float]]

# points of a curve; fewer with restitution, since bounces are slow to solve
_POINTS: Final = {False: 801, True: 81}
_BEYOND: Final = 1.25  # factor on the drive's limits up to which pictures reach
_LEAST: Final = 0.05  # share of the largest amplitude at which pictures begin
_BELOW: Final = 0.5  # share of the chosen amplitude at which they begin at the latest
_LEVELS: Final = (0.0, 0.5, 1.0)  # shares of every band at which bodies are drawn
_MOST: Final = 4  # bands; with more of them the corners alone are drawn


def setting_fields(spec: Spec, chosen: Chosen) -> SettingFields:
    """Return what parts do at the drive angle of the chosen setting, over the load.

    Pictures take the slowest of some bodies of the box; tables have the slowest that a search found.
    """
    spec = _drawn(spec)
    question, setting = Question(spec, chosen.drive, Regime.HOPPING), chosen.setting
    limits, amplitude = span_of(question, setting), float(question.space.amplitude(setting))
    amplitudes = min(_LEAST * limits[1], _BELOW * amplitude), _BEYOND * limits[1]
    ends = [end for span in chosen.drive.frequency for end in span]
    frequencies = min(ends) / _BEYOND, max(ends) * _BEYOND
    load_at, gravity = question.space.load_at, spec.gravity
    unit = 1.0 / float(load_at(1.0, 1.0, gravity))  # [m] of load 1 at 1 Hz, or scale
    one = setting.scaled(unit / amplitude)._replace(frequency=1.0)
    box = question.box(one)
    begins = _begins(box)
    least, most = (float(load_at(a, f, gravity)) for a, f in zip(amplitudes, frequencies, strict=True))
    loads = _with_jumps(least, most, begins, spec)
    boxes = question.box(one.scaled(loads[:, None]))
    points = boxes.points(_bodies(box)[:, None, :])
    slow, fast = (solve(boxes.scene(points, fast=which)) for which in (False, True))
    goal = spec.goal
    # an ellipse's load exceeds that of its motion along the trough
    share = float(load_at(amplitude, setting.frequency, gravity)) / float(question.load(setting))
    size = chosen.drive.size(setting)
    return SettingFields(
        amplitude=size.name,
        limits=(size.printed(limits[0]), size.printed(limits[1])),
        most_load=chosen.drive.acceleration * share,
        amplitudes=(size.printed(amplitudes[0]), size.printed(amplitudes[1])),
        frequency_hz=frequencies,
        load=loads,
        speed_min=SPEED.from_si(_least(counted(slow, fast=False))),
        begins=begins,
        tips=_tips(question, box),
        impact_speed=SPEED.from_si(_most(fast.impact_velocity)) if math.isfinite(goal.impact_speed) else None,
        flight_fraction=_most(fast.flight_fraction) if math.isfinite(goal.flight_fraction) else None,
    )


def speed_band(spec: Spec, chosen: Chosen) -> SpeedBand:
    """Return the speeds of the slowest, the middle and the fastest part over the amplitude.

    They are the bodies of ``setting_fields``. Unknown where a part hops and the goal forbids it.
    """
    forbids_hops, spec = spec.goal.highest_regime is not Regime.HOPPING, _drawn(spec)
    question, setting = Question(spec, chosen.drive, Regime.HOPPING), chosen.setting
    amplitude = float(question.space.amplitude(setting))
    box = question.box(setting)
    begins = {regime: (first * amplitude, last * amplitude) for regime, (first, last) in _begins(box).items()}
    low = min(_BELOW * amplitude, 0.8 * begins[Regime.FORWARD_SLIP][0])
    high = max(span_of(question, setting)[1], amplitude)
    if forbids_hops:
        high = max(min(high, begins[Regime.HOPPING][0]), amplitude)
    high *= _BEYOND
    amplitudes = _with_jumps(low, high, begins, spec)
    boxes = question.box(setting.scaled(amplitudes[:, None] / amplitude))
    points = boxes.points(_bodies(box)[:, None, :])
    slow, fast = (counted(solve(boxes.scene(points, fast=which)), fast=which) for which in (False, True))
    middle = question.nominal_scene(setting.scaled(amplitudes / amplitude))
    found = (_least(slow), np.asarray(solve(middle).mean_velocity), _most(fast))
    unknown = forbids_hops & (amplitudes > begins[Regime.HOPPING][0])
    least, nominal, most = (SPEED.from_si(np.where(unknown, np.nan, speed)) for speed in found)
    return SpeedBand(
        amplitude=chosen.drive.size(setting).printed(amplitudes),
        speed_min=least,
        speed_nominal=nominal,
        speed_max=most,
        window=chosen.design.window,
    )


def _tips(question: Question, box: UncertaintySet) -> float:
    """Return the ratio of the load at which the first part tips, or hops, to the present one."""
    ratio = question.spec.stand_ratio
    if math.isinf(ratio):
        return math.inf
    most = max(tip_ratio(box, ratio), box.throw_number)
    return 1.0 / most if most > 0.0 else math.inf


def _with_jumps(low: float, high: float, begins: Begins, spec: Spec) -> Floats:
    """Return values between two ends, with both sides of every load at which a regime begins."""
    jumps = [value for pair in begins.values() for value in pair if low < value < high]
    beside = np.outer(jumps, (1.0 - TOLERANCES.either_side, 1.0 + TOLERANCES.either_side)).ravel()
    return np.union1d(np.geomspace(low, high, _POINTS[spec.bounces[1] > 0.0]), beside)


def _drawn(spec: Spec) -> Spec:
    """Return a question with plastic landings where the goal forbids hops: no speed of theirs is drawn."""
    return spec if spec.goal.highest_regime is Regime.HOPPING else replace(spec, restitution=(0.0, 0.0))


def _most(values: Floats) -> Floats:
    """Return the largest value of each row, ignoring NaN; NaN if all are."""
    return -_least(-values)


def _least(speed: Floats) -> Floats:
    """Return the least speed of each row, ignoring NaN; NaN if all are."""
    least = np.where(np.isnan(speed), np.inf, speed).min(axis=1)
    return np.where(np.isinf(least) & (least > 0.0), np.nan, least)


def _bodies(box: UncertaintySet) -> Floats:
    """Return bodies of a box in the unit cube, of shape (axes, n): corners and, of few bands, middles."""
    if box.varies.sum() > _MOST:
        return corners(box.varies)
    levels = [_LEVELS if varies else (0.0,) for varies in box.varies]
    return np.array(list(product(*levels))).T


def _begins(box: UncertaintySet) -> Begins:
    """Return the ratios of the loads at which the first and the last part reach each regime to the present.

    For a line the extreme loads are at corners or on some edges of the box, or at the angle of friction
    (theory, sections 6 and 14); for an ellipse they are searched.
    """
    begins: Begins = {}
    beyond = (math.inf, math.inf)
    # a part in a higher regime has passed the lower ones
    for regime in (Regime.HOPPING, Regime.BACK_SLIP, Regime.FORWARD_SLIP):
        ratios = first_ratio(box, regime), last_ratio(box, regime)
        first, last = (1.0 / ratio if ratio > 0.0 else math.inf for ratio in ratios)
        begins[regime] = beyond = min(first, beyond[0]), min(last, beyond[1])
    return begins
