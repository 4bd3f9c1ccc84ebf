"""What a record measures: the trough's motion, and a part beside the exact motion of a scene."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from os import PathLike
from pathlib import Path
from typing import Final

from vibro.errors import InputError, VibroError
from vibro.reals import shielded
from vibro.records.alignment import Observation
from vibro.records.comparison import Comparison
from vibro.records.comparison import compare as compared
from vibro.records.drive_errors import drive_errors
from vibro.records.fitting import Fit, check_names, fit
from vibro.records.reading import Record, read_record, read_sensitivities
from vibro.records.sensors import SensorErrors
from vibro.records.steadiness import part_of
from vibro.records.trough import HopOnset, MeasuredMotion, Speeds, TroughDrive, hop_onset, speeds_of
from vibro.scene import Scene, check_single

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
            comparison = compared(scene, seen)
        except VibroError as exc:
            if onset is None or isinstance(exc, InputError):
                raise
            raise InputError(str(exc), hint="without friction the trough alone is measured") from exc
        if names:
            found = fit(scene, seen, names, drive_errors(scene, trough, errors), errors, progress)
            fitted = compared(found.scene, seen)
    return Measurement(record, trough, onset, speeds, comparison, found, fitted, mass, errors)


@shielded
def compare(
    scene: Scene,
    path: str | PathLike[str],
    *,
    displacement: str | None = None,
    velocity: str | None = None,
    acceleration: str | None = None,
    friction: str | None = None,
    time: str | None = None,
    rate: float | str | None = None,
    sensitivity: str | Sequence[str] = (),
    mass: float | None = None,
    reverse: bool = False,
    absolute: bool = False,
    start: float | None = None,
    end: float | None = None,
) -> Comparison:
    """Compare the record of a part with the steady motion of a scene, as ``vibro measure`` does.

    Parameters
    ----------
    scene : Scene
        One operating point, of a trough that moves as it did in the record.
    path : str or path
        Text file of columns, with any separator and decimal points or commas.
    displacement, velocity, acceleration, friction : str, optional
        Headers of the columns of the part's motion on the trough and of the friction force on it; by default
        they are found by their units.
    time : str, optional
        Header of the time column; by default the only column with a unit of time.
    rate : float or str, optional
        Sampling rate, in place of a column of time: in Hz, or with its unit.
    sensitivity : str or sequence of str
        Sensitivities of voltages, as of ``vibro.measured_motion``.
    mass : float, optional
        Mass of the part, without which forces cannot be compared [kg].
    reverse : bool
        Whether the axis of the data points against the conveying direction.
    absolute : bool
        Whether the data are over the ground, as on video.
    start, end : float, optional
        Part of the record that is taken, on its own clock [s].

    Returns
    -------
    Comparison
        ``rows`` has what was measured beside what is computed, ``warnings`` reasons to doubt it, and
        ``draw()`` shows both.

    Raises
    ------
    FileError
        If the file cannot be read.
    InputError
        If columns are missing or wrong, or the record is too short or sampled too coarsely.
    SceneError
        If it is more than one scene.
    VibroError
        If the scene has no steady motion.

    Examples
    --------
    >>> import math, vibro
    >>> nut = vibro.read_scene("examples/safety_nut.toml")
    >>> found = vibro.compare(nut, "examples/data/nut_smoothed_600hz.csv")
    >>> for row in found.rows[:2]:
    ...     print(row.key, f"{1e3 * row.measured.value:.3f} {1e3 * row.computed:.3f}")
    stroke_advance 0.955 1.084
    mean_speed 14.331 16.263
    """
    check_single(scene)
    given = {
        "displacement": displacement, "velocity": velocity, "acceleration": acceleration,
        "friction": friction, "time": time,
    }  # fmt: skip
    columns = {name: text for name, text in given.items() if text is not None}
    texts = [sensitivity] if isinstance(sensitivity, str) else sensitivity
    record = part_of(read_record(Path(path), columns, read_sensitivities(texts), rate=rate), start, end)
    seen = Observation.of(record, float(scene.frequency), mass=mass, reverse=reverse, absolute=absolute)
    return compared(scene, seen)
