"""What a record measures: the trough's motion, and a part beside the exact motion of a scene."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Final

from vibro.errors import InputError, VibroError
from vibro.records.alignment import Observation
from vibro.records.comparison import Comparison, compare
from vibro.records.drive_errors import drive_errors
from vibro.records.fitting import Fit, check_names, fit
from vibro.records.reading import Record
from vibro.records.sensors import SensorErrors
from vibro.records.trough import HopOnset, MeasuredMotion, Speeds, TroughDrive, hop_onset, speeds_of
from vibro.scene import Scene

_USUAL: Final = SensorErrors()


@dataclass(frozen=True, eq=False)
class Measurement:
    """What is known of a record.

    Attributes
    ----------
    record : Record
        Its signals.
    trough : TroughDrive or None
        The trough's motion, if sensors were on it.
    onset : HopOnset or None
        Its throw number, and where parts begin to hop, if all its harmonics are known.
    speeds : Speeds or None
        The speed of a part on it, if friction is known too.
    comparison, fitted : Comparison or None
        The signals of a part beside the scene, and beside the one that is fitted to them.
    fit : Fit or None
        Estimates from these signals.
    mass : float or None
        Mass of the part [kg]; without it friction is per unit mass.
    errors : SensorErrors
        Of the sensors, and of a drive that is stated.
    """

    record: Record
    trough: TroughDrive | None = None
    onset: HopOnset | None = None
    speeds: Speeds | None = None
    comparison: Comparison | None = None
    fit: Fit | None = None
    fitted: Comparison | None = None
    mass: float | None = None
    errors: SensorErrors = _USUAL

    @property
    def motion(self) -> MeasuredMotion | None:
        """The trough's motion with all its harmonics, if they are known."""
        return self.trough.measured if self.trough else None

    @property
    def warnings(self) -> list[str]:
        """Reasons to doubt it."""
        return [text for one in (self.trough, self.comparison) if one for text in one.warnings]


def measure(
    record: Record,
    trough: TroughDrive | None,
    others: Mapping[str, float],
    scene: Scene | None = None,
    names: Sequence[str] = (),
    *,
    mass: float | None = None,
    reverse: bool = False,
    absolute: bool = False,
    errors: SensorErrors = _USUAL,
    progress: Callable[[int, int, str], None] | None = None,
) -> Measurement:
    """Measure the trough, and compare and fit the part, as far as a record has their signals.

    Parameters
    ----------
    record : Record
        The record.
    trough : TroughDrive or None
        The trough's motion, if sensors were on it.
    others : mapping of str to float
        Fields of ``Scene`` besides the drive; a speed is computed if friction is among them [SI].
    scene : Scene, optional
        With which the signals of a part are compared.
    names : sequence of str
        Quantities that are fitted to them.
    mass : float, optional
        Mass of the part [kg].
    reverse, absolute : bool
        As for ``Observation.of``.
    errors : SensorErrors
        Those of the sensors, and of a drive that is stated.
    progress : callable, optional
        As for ``fit``.

    Raises
    ------
    InputError, VibroError
        As for ``compare`` and ``fit``.
    """
    onset = speeds = comparison = found = fitted = None
    if trough:
        record = trough.record
    if trough and trough.measured:
        onset = hop_onset(trough.measured, others)
        speeds = speeds_of(trough.measured, others) if "static_friction" in others else None
    if scene is not None:
        check_names(scene, names)
        clock = trough.drive.clock if trough else None
        error = trough.drive.quantities["frequency"].error if trough else 0.0
        seen = Observation.of(
            record, float(scene.frequency), mass=mass, reverse=reverse, clock=clock, absolute=absolute,
            frequency_error=error, lowpass=errors.lowpass,
        )  # fmt: skip
        try:
            comparison = compare(scene, seen)
        except VibroError as exc:
            if onset is None or isinstance(exc, InputError):
                raise
            raise InputError(str(exc), hint="without friction the trough alone is measured") from exc
        if names:
            found = fit(scene, seen, names, drive_errors(scene, trough, errors), errors, progress)
            fitted = compare(found.scene, seen)
    return Measurement(record, trough, onset, speeds, comparison, found, fitted, mass, errors)
