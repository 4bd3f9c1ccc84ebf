"""Which of the trough's measured motions stands in a scene, in place of the drive that the scene gives."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Final, NamedTuple

from vibro.errors import InputError, VibroError, argument, shown
from vibro.quantities import AMPLITUDES, DRIVES, ELLIPTICAL, LINEAR, QUANTITIES
from vibro.records.measured_speeds import change_by_harmonics
from vibro.records.reading import Record
from vibro.records.signals import doubt, rounded
from vibro.records.tolerances import TOL
from vibro.records.trough import MeasuredDrive, spelled, trough_of
from vibro.records.waveforms import HarmonicDrive, MeasuredMotion, motion_of

#: What sensors on the trough measure: every quantity of a drive, and its frequency.
MEASURED: Final = (*DRIVES, "frequency")
_ANY_LINE: Final = 0.25 * math.pi  # [rad] of one sensor's own harmonics any line tells the same


class TroughDrive(NamedTuple):
    """The measured motion of a trough.

    Attributes
    ----------
    first : MeasuredDrive
        Line or ellipse of its first harmonic.
    drive : MeasuredDrive or HarmonicDrive
        What stands in the scene.
    measured : MeasuredMotion or None
        All harmonics; None if the record does not determine them.
    notes, warnings : sequence of str
        How it was chosen, and reasons to doubt it.
    """

    first: MeasuredDrive
    drive: MeasuredDrive | HarmonicDrive
    measured: MeasuredMotion | None
    notes: Sequence[str]
    warnings: Sequence[str]

    @property
    def needed(self) -> set[str]:
        """Quantities of the drive that one sensor does not measure, and the scene gives."""
        family = LINEAR if "amplitude" in self.first.quantities else ELLIPTICAL
        return {*family} - self.first.quantities.keys()

    @property
    def texts(self) -> dict[str, str]:
        """Quantities of the drive in users' units, to two digits below their standard errors."""
        return {
            name: spelled(*map(QUANTITIES[name].from_si, estimate))
            for name, estimate in self.drive.quantities.items()
        }


def trough_drive(
    record: Record,
    own: Mapping[str, float],
    others: Mapping[str, float] | None = None,
    *,
    reverse: bool = False,
    fits: bool = False,
) -> TroughDrive:
    """Measure the trough's motion, and choose what stands in a scene.

    Parameters
    ----------
    record : Record
        Record with motions of the trough.
    own : mapping of str to float
        Quantities of the drive that the scene gives [SI].
    others : mapping of str to float, optional
        The other fields of ``Scene``, if the record holds signals of a part.
    reverse : bool
        Whether the axis along the trough points against the conveying direction.
    fits : bool
        Whether quantities are fitted to the part's signals.

    Raises
    ------
    InputError
        As for ``motion_of`` where its harmonics must be known, else as for ``trough_of``.

    Notes
    -----
    A part is computed on the harmonics if they change its speed. An estimate would take their effect for
    friction: it is on them wherever they stand out of the noise, and refused where they are not known.
    """
    elliptical = not own.keys().isdisjoint(ELLIPTICAL)
    is_single = len(record.trough) == 1
    angle = own.get("drive_angle") if is_single else None
    is_half = is_single and elliptical and others is not None  # of a motion whose other half the scene gives
    measured = None
    try:
        measured = motion_of(
            record, reverse=reverse, drive_angle=_ANY_LINE if is_half else angle, down=elliptical
        )
    except VibroError:  # the record may be too short for harmonics
        if fits or others is None or (is_single and not is_half and angle is None):
            raise
    if measured is None:
        trough = trough_of(record, reverse=reverse, down=elliptical)
        assert trough is not None
    else:
        trough = measured.trough
    if elliptical or trough.on_an_ellipse:
        first = trough.drive_on_ellipse(own.get("normal_phase", 0.0) if elliptical else None)
    else:
        first = trough.drive_on_line(angle)
    if measured is not None and is_half:
        if fits and measured.order > 1:
            raise InputError(
                f"the trough moves with {measured.order} harmonics: one sensor measures one direction alone",
                hint=f"a fit needs {argument('trough_along')} and {argument('trough_normal')}",
            )
        measured = None
    far_off = _far_off(first, own)
    if measured is None:
        return TroughDrive(first, first, None, (), (*first.warnings, *far_off))
    takes, text = (True, "") if others is None else _takes_harmonics(measured, others, fits=fits)
    if takes:
        drive = measured.measured_drive() if measured.order > 1 else first
        return TroughDrive(first, drive, measured, (text,) if text else (), (*measured.warnings, *far_off))
    doubts = dict.fromkeys((*first.warnings, *measured.warnings, *far_off, text))
    return TroughDrive(first, first, measured, (), [*filter(None, doubts)])


def _takes_harmonics(
    measured: MeasuredMotion, others: Mapping[str, float], *, fits: bool
) -> tuple[bool, str]:
    """Return whether a part is computed on all harmonics; and a note if it is, a warning if it is not."""
    if measured.order == 1:
        return False, ""
    many = f"the trough moves with {measured.order} harmonics"
    if fits:
        return True, f"{many}: they are part of the fit"
    change = change_by_harmonics(measured, others)
    if math.isnan(change):
        return False, f"{many}, but the speed of a part on them is not known: the first is taken alone"
    if abs(change) <= TOL.harmonics_matter:
        return False, ""
    by = f"by {100.0 * change:+.2g} %" if math.isfinite(change) else "from 0"
    return True, f"{many}, which change the computed speed {by}: they are taken"


def _far_off(drive: MeasuredDrive, own: Mapping[str, float]) -> list[str]:
    """Question the sensors where an amplitude, or the drive angle, is far from the scene's."""
    waves, found = drive.trough.waves, []
    columns = " and ".join(shown(wave.header) for wave in waves)
    for name in {*AMPLITUDES} & drive.quantities.keys() & own.keys():
        ratio = drive.quantities[name].value / own[name] if own[name] else 1.0
        if not 1.0 / TOL.far_off <= ratio <= TOL.far_off:
            texts = dict.fromkeys(wave.sensitivity for wave in waves if wave.sensitivity)
            what = f"the {QUANTITIES[name].label} is about {rounded(float(ratio))} times the scene's"
            found.append(f"column {columns}: {what}: {doubt(' or '.join(texts))}")
    angle, given = drive.quantities.get("drive_angle"), own.get("drive_angle")
    if angle and given is not None and abs(angle.value - given) > TOL.far_angle:
        here, there = (f"{QUANTITIES['drive_angle'].from_si(x):.3g} deg" for x in (angle.value, given))
        what = f"the drive angle is {here}, the scene's {there}: does each name stand for its sensor?"
        found.append(f"column {columns}: {what}")
    return found
