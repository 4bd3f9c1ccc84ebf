"""What accelerometers on the trough tell of a drive along an ellipse."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Final, NamedTuple

import numpy as np

from vibro.quantities import ELLIPTICAL, QUANTITIES
from vibro.records.folding import Estimate
from vibro.records.trough import spelled

if TYPE_CHECKING:
    from vibro.records.trough import Trough

__all__ = ["MeasuredEllipse", "ellipse_of"]

_SIGMAS: Final = 3.0  # of a wave: with less it tells no clock


class MeasuredEllipse(NamedTuple):
    """What was measured of a drive along an ellipse, for its scene.

    Attributes
    ----------
    trough : Trough
        From which it is.
    quantities : dict of str to Estimate
        What it gives of a scene, by the names of its fields [SI].
    clock : Estimate
        Trough time at the clock's zero, in [0, period); at 0 the motion along the trough passes its middle
        forwards [s].
    warnings : tuple of str
        Reasons to doubt it.
    """

    trough: Trough
    quantities: dict[str, Estimate]
    clock: Estimate
    warnings: tuple[str, ...]


def ellipse_of(trough: Trough, normal_phase: float | None = None) -> MeasuredEllipse:
    """Tell what the scene of an elliptical drive needs to know of the trough's motion.

    Parameters
    ----------
    trough : Trough
        One or two accelerations.
    normal_phase : float, optional
        Of the scene [rad]; None where that moves along a line, or does not say.

    Notes
    -----
    Each acceleration gives its own amplitude. The phase takes both, and the clock that along the trough; from
    the other one it follows by the phase.
    """
    frequency = trough.frequency
    rate, relative = 2.0 * math.pi * frequency.value, frequency.error / frequency.value
    found = {}
    for name, wave in (("along_amplitude", trough.along), ("normal_amplitude", trough.normal)):
        if wave is not None:
            size = abs(wave.value) / rate**2
            error = math.hypot(wave.error / rate**2, 2.0 * size * relative)
            found[name] = Estimate(size, error)
    found["frequency"] = frequency
    if not math.isnan(trough.phase):
        found["normal_phase"] = Estimate(trough.phase, trough.phase_error)
    # The acceleration of X sin(w t) is opposed to it.
    clocks = trough.along, 0.0
    if trough.along is None or abs(trough.along.value) < _SIGMAS * trough.along.error:
        clocks = trough.normal, normal_phase or 0.0
    wave, ahead = clocks
    assert wave is not None
    shift = (float(np.angle(-wave.value)) - ahead) / rate % (1.0 / frequency.value)
    # The frequency is known less well than the phase: at the ends of the record both errors count.
    error = math.hypot(wave.error / abs(wave.value) / rate, 0.5 * trough.span * relative)
    warnings = (*trough.warnings, *_doubts(trough, found, normal_phase))
    return MeasuredEllipse(trough, found, Estimate(shift, error), warnings)


def _doubts(trough: Trough, found: dict[str, Estimate], normal_phase: float | None) -> list[str]:
    """Say that the scene does not move on an ellipse, and question a phase that is nearly the opposite."""
    doubts = []
    if normal_phase is None and trough.on_an_ellipse:
        said = ", ".join(_text(name, found[name]) for name in ELLIPTICAL)
        options = " ".join(_option(name, found[name]) for name in ELLIPTICAL)
        doubts.append(
            f"the trough moves on an ellipse, not on a line: {said}; this ellipse is taken. Elsewhere give"
            f" {options}"
        )
    off = math.remainder(trough.phase - (normal_phase or 0.0), 2.0 * math.pi)
    if abs(off) > 0.5 * math.pi:
        than = "that along the trough" if normal_phase is None else "where the scene has it"
        doubts.append(
            f"the normal motion is {abs(math.degrees(off)):.0f} deg {'ahead of' if off > 0.0 else 'behind'}"
            f" {than}: one of the two sensors may be inverted (--reverse, or a negative sensitivity)"
        )
    return doubts


def _text(name: str, estimate: Estimate) -> str:
    quantity = QUANTITIES[name]
    return f"{quantity.label} {spelled(*map(quantity.from_si, estimate))} {quantity.unit}"


def _option(name: str, estimate: Estimate) -> str:
    quantity = QUANTITIES[name]
    value = spelled(*map(quantity.from_si, estimate))
    return f"{quantity.options[0]}{'=' if value.startswith('-') else ' '}{value}{quantity.unit}"
