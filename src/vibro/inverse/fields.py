"""What pictures of a design show: what the settings around it guarantee."""

from __future__ import annotations

import math
from itertools import product
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from vibro.core.codes import Regime
from vibro.inverse.boxes import Box
from vibro.inverse.caps import back_slip_load, hop_load, onset_load
from vibro.inverse.ellipses import critical, extreme_ratio
from vibro.inverse.elliptical_questions import EllipticalSetting, question_of
from vibro.inverse.extremes import corners, counted
from vibro.inverse.questions import Setting
from vibro.inverse.rows import nominal_scene
from vibro.inverse.specs import Drive
from vibro.limits import critical_loads_of_lines, tipping_load
from vibro.quantities import LENGTH, SPEED
from vibro.results.designs import SettingFields, SpeedBand
from vibro.steady import solve

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from vibro.inverse.boxes import Parts
    from vibro.inverse.designs import Chosen
    from vibro.inverse.ellipses import EllipticalBox
    from vibro.inverse.specs import Spec

    Floats = NDArray[np.float64]
    Begins = dict[Regime, tuple[float, float]]

__all__ = ["setting_fields", "speed_band"]

_POINTS: Final = {False: 801, True: 81}  # of a curve; the second where impacts are not plastic: it takes long
_BEYOND: Final = 1.25  # times a limit of the drive, as far as pictures go
_LEAST: Final = 0.05  # of the largest amplitude, where pictures begin
_BELOW: Final = 0.5  # of the chosen amplitude, where they begin at the latest
_BESIDE: Final = 1e-9  # relative distance from a load at which numbers jump
_LEVELS: Final = (0.0, 0.5, 1.0)  # shares of every band, of the bodies that pictures look at
_CRITICAL: Final = {
    Regime.FORWARD_SLIP: "forward_onset",
    Regime.BACK_SLIP: "back_slip",
    Regime.HOPPING: "hop",
}
_MOST: Final = 4  # bands; of more the corners alone are looked at


def setting_fields(spec: Spec, chosen: Chosen) -> SettingFields:
    """Return what settings guarantee at the drive angle of the chosen one, over the load.

    The slowest of some bodies of the box stands for the slowest: pictures show lines, and tables what was
    searched.
    """
    question, setting = question_of(spec, chosen.drive, Regime.HOPPING), chosen.setting
    limits = _limits(chosen)
    amplitudes = min(_LEAST * limits[1], _BELOW * _amplitude(setting)), _BEYOND * limits[1]
    ends = [end for span in chosen.drive.frequency for end in span]
    frequencies = min(ends) / _BEYOND, max(ends) * _BEYOND
    unit = spec.gravity / (2.0 * math.pi) ** 2  # [m] of load 1 at 1 Hz
    box: Any = question.boxes(_at(setting, unit, 1.0))
    begins = _begins(box)
    least, most = (a * f**2 / unit for a, f in zip(amplitudes, frequencies, strict=True))
    loads = _with_jumps(least, most, begins, spec)
    boxes: Any = question.boxes(_at(setting, unit * loads[:, None], 1.0))
    points = boxes.points(_bodies(box)[:, None, :])
    slow, fast = (solve(boxes.scene(points, fast=which)) for which in (False, True))
    goal = spec.goal
    # the load of an ellipse is more than that of its motion along the trough
    share = _amplitude(setting) * float(setting.frequency) ** 2 / unit / float(question.load(setting))
    return SettingFields(
        amplitude="amplitude" if isinstance(setting, Setting) else setting.leading,
        limits_mm=(LENGTH.from_si(limits[0]), LENGTH.from_si(limits[1])),
        most_load=chosen.drive.acceleration * share,
        amplitude_mm=(LENGTH.from_si(amplitudes[0]), LENGTH.from_si(amplitudes[1])),
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

    Of the bodies that ``setting_fields`` looks at too.
    """
    question, setting = question_of(spec, chosen.drive, Regime.HOPPING), chosen.setting
    amplitude, frequency = _amplitude(setting), setting.frequency
    box = question.boxes(setting)
    begins = {regime: (first * amplitude, last * amplitude) for regime, (first, last) in _begins(box).items()}
    low = min(_BELOW * amplitude, 0.8 * begins[Regime.FORWARD_SLIP][0])
    high = max(_limits(chosen)[1], amplitude)
    if spec.goal.highest_regime is not Regime.HOPPING:
        high = max(min(high, begins[Regime.HOPPING][0]), amplitude)
    high *= _BEYOND
    amplitudes = _with_jumps(low, high, begins, spec)
    boxes: Any = question.boxes(_at(setting, amplitudes[:, None], frequency))
    points = boxes.points(_bodies(box)[:, None, :])
    slow, fast = (counted(solve(boxes.scene(points, fast=which)), fast=which) for which in (False, True))
    middle = nominal_scene(question, _at(setting, amplitudes, frequency))
    design = chosen.design
    window = design.amplitude_low_mm, design.amplitude_high_mm
    return SpeedBand(
        amplitude_mm=LENGTH.from_si(amplitudes),
        speed_min=SPEED.from_si(_least(slow)),
        speed_nominal=SPEED.from_si(solve(middle).mean_velocity),
        speed_max=SPEED.from_si(_most(fast)),
        window_mm=None if window[0] is None or window[1] is None else (window[0], window[1]),
    )


def _at(setting: Any, amplitude: Any, frequency: Any) -> Any:
    """Change the amplitude of a setting, or both in proportion, and its frequency."""
    if isinstance(setting, Setting):
        return Setting(amplitude, frequency, setting.drive_angle)
    factor = amplitude / _amplitude(setting)
    x, y, phase, _ = setting
    return EllipticalSetting(factor * x, factor * y, phase, frequency)


def _amplitude(setting: Any) -> float:
    """Return the amplitude that pictures are over."""
    return float(setting.amplitude if isinstance(setting, Setting) else getattr(setting, setting.leading))


def _limits(chosen: Chosen) -> tuple[float, float]:
    """Smallest and largest amplitude that the drive is capable of; of an ellipse of the chosen shape."""
    if isinstance(chosen.drive, Drive):
        return chosen.drive.amplitude
    drive, lead = chosen.drive, _amplitude(chosen.setting)
    spans = ((drive.along_amplitude, chosen.setting[0]), (drive.normal_amplitude, chosen.setting[1]))
    shares = [(low / size, high / size) for (low, high), size in spans if size > 0.0]
    low, high = max(low for low, _ in shares) * lead, min(high for _, high in shares) * lead
    return low, high


def _tips(question: Any, box: Box | EllipticalBox) -> float:
    """Nominal load over the present one from which the first part lifts an edge, or hops."""
    if isinstance(box, Box):
        return float(question.tip_loads(box).get("tip", np.inf) / box.load[1])
    ratio = question.spec.stand_ratio
    if math.isinf(ratio):
        return math.inf
    tips = extreme_ratio(box, lambda scene: tipping_load(scene, ratio), largest=True)[0]
    return 1.0 / max(tips, float(box.load[1] / hop_load(box)))


def _with_jumps(low: float, high: float, begins: Begins, spec: Spec) -> Floats:
    """Return values between two ends, with both sides of those at which something begins."""
    jumps = [value for pair in begins.values() for value in pair if low < value < high]
    beside = np.outer(jumps, (1.0 - _BESIDE, 1.0 + _BESIDE)).ravel()
    return np.union1d(np.geomspace(low, high, _POINTS[spec.restitution > 0.0]), beside)


def _most(values: Floats) -> Floats:
    """Largest value of each row; NaN does not count, unless nothing else is there."""
    return -_least(-values)


def _least(speed: Floats) -> Floats:
    """Least speed of each row; what is left out is NaN and does not count, unless nothing else is there."""
    least = np.where(np.isnan(speed), np.inf, speed).min(axis=1)
    return np.where(np.isinf(least) & (least > 0.0), np.nan, least)


def _bodies(box: Parts) -> Floats:
    """Bodies of a box, as shares, of shape (axes, n): its corners and, of few bands, points between them."""
    if box.varies.sum() > _MOST:
        return corners(box)
    levels = [_LEVELS if varies else (0.0,) for varies in box.varies]
    return np.array(list(product(*levels))).T


def _begins(box: Box | EllipticalBox) -> Begins:
    """Nominal loads over the present one from which the first, and the last, part is in a regime or beyond.

    Forward slip, back slip and hopping. Of a drive along a line their loads have their extremes at corners of
    the box, or at the angle of friction (theory.md, sections 6 and 14); of an ellipse they are searched.
    """
    pairs = _line_begins(box) if isinstance(box, Box) else _ellipse_begins(box)
    begins: Begins = {}
    beyond = (math.inf, math.inf)
    for regime in reversed(Regime):  # a higher regime counts as this one
        if regime in pairs:
            beyond = min(pairs[regime][0], beyond[0]), min(pairs[regime][1], beyond[1])
            begins[regime] = beyond
    return begins


def _line_begins(box: Box) -> Begins:
    (a_low, a_high), (b_low, b_high) = box.drive_angle, box.trough_angle
    (s_low, s_high), (least, most) = box.static_span, box.load
    flattest = max(math.cos(b_low), math.cos(b_high), 1.0 if b_low < 0.0 < b_high else 0.0)
    with np.errstate(divide="ignore"):
        hops = float(hop_load(box) / most), float(flattest / np.sin(a_low) / least)
    slips_back = (
        float(back_slip_load(box) / most),
        float(critical_loads_of_lines(a_high, s_high, box.kinetic_span(s_high)[0], b_low).back_slip / least),
    )
    angles = np.array([a_low, a_high, np.clip(math.atan(s_low), a_low, a_high)])
    slips = (
        float(np.min(critical_loads_of_lines(angles, s_low, s_low, b_low).forward_onset) / most),
        float(onset_load(box) / least),
    )
    return {Regime.FORWARD_SLIP: slips, Regime.BACK_SLIP: slips_back, Regime.HOPPING: hops}


def _ellipse_begins(box: EllipticalBox) -> Begins:
    """Return the same of ellipses, by searches of the box."""
    found = {}
    for regime, name in _CRITICAL.items():
        ratios = (extreme_ratio(box, critical(name), largest=which)[0] for which in (True, False))
        first, last = (1.0 / ratio if ratio > 0.0 else math.inf for ratio in ratios)
        found[regime] = first, last
    return found
