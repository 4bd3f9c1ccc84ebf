"""What errors of sensors, of their noise, and of a stated drive make of the drive of a scene."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from vibro.quantities import AMPLITUDES, ELLIPTICAL
from vibro.records.trough import Motions

if TYPE_CHECKING:
    from vibro.records.sensors import SensorErrors
    from vibro.records.trough import TroughDrive
    from vibro.scene import Scene


class DriveError(NamedTuple):
    """An independent error of a drive: fields of the scene, one standard error to either side [SI].

    Attributes
    ----------
    name : str
        What is wrong: a field of ``SensorErrors``, or ``noise``.
    more, less : mapping of str to object
        The fields that it changes.
    """

    name: str
    more: Mapping[str, Any]
    less: Mapping[str, Any]


def drive_errors(scene: Scene, trough: TroughDrive | None, errors: SensorErrors) -> list[DriveError]:
    """Return the errors of a scene's drive: as sensors on the trough measured it, or else as it is stated."""
    if trough is None:
        found = [*_stated(scene, errors), *_turned(scene, errors.angle)]
    else:
        sides = trough.drive.motion.moved_by_kind.items()
        fields = trough.drive.fields_of
        found = [
            DriveError(name, fields(more), fields(less)) for name, pairs in sides for more, less in pairs
        ]
        if trough.drive is trough.first:
            found += _stated(scene, errors, {*ELLIPTICAL} & trough.needed)
    acting = [{name for name, x in error.more.items() if x != error.less[name]} for error in found]
    return [
        DriveError(error.name, *({name: side[name] for name in names} for side in error[1:]))
        for error, names in zip(found, acting, strict=True)
        if names
    ]


def _stated(scene: Scene, errors: SensorErrors, of: set[str] | None = None) -> list[DriveError]:
    """Return the errors of a stated drive, or of some of its quantities."""
    fields = {name: x for name, x in scene.arrays()._asdict().items() if of is None or name in of}
    found = []
    for name in (n for n in (*AMPLITUDES, "motion_scale") if n in fields):
        size = float(fields[name])
        more, less = (1.0 + errors.amplitude) * size, (1.0 - errors.amplitude) * size
        found.append(DriveError("amplitude", {name: more}, {name: less}))
    for name in (n for n in ("drive_angle", "normal_phase") if n in fields):
        angle = float(fields[name])
        found.append(DriveError("angle", {name: angle + errors.angle}, {name: angle - errors.angle}))
    return found


def _turned(scene: Scene, angle: float) -> list[DriveError]:
    """Turn a stated ellipse, or harmonics, as a whole."""
    if scene.along_amplitude is not None:
        size, phase = float(scene.normal_amplitude or 0.0), float(scene.normal_phase or 0.0)
        pairs: list[Any] = [[(float(scene.along_amplitude), 0.0)], [(size, phase)]]
    else:
        pairs = [scene.along_harmonics or (), scene.normal_harmonics or ()]
    if not any(pairs):
        return []
    count = max(map(len, pairs))
    waves = (
        [size * np.exp(1j * phase) for size, phase in way] + [0.0j] * (count - len(way)) for way in pairs
    )
    x, y = (np.array(way, np.complex128) for way in waves)
    cosine, sides = math.cos(angle), []
    for sine in (math.sin(angle), -math.sin(angle)):
        fields = Motions(np.array(1.0), cosine * x - sine * y, sine * x + cosine * y).drive()
        kept = (*ELLIPTICAL, "along_harmonics", "normal_harmonics")
        sides.append(
            {
                n: value if isinstance(value, list) else float(value)
                for n, value in fields.items()
                if n in kept
            }
        )
    return [DriveError("angle", *sides)]
