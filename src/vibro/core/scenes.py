"""Scenes as they come in: fields in SI units that broadcast against each other, read cell by cell.

Nothing is copied to broadcast it: each field has a stride along every axis of the grid, 0 where one value
serves the whole axis.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from vibro.core.cells import largest
from vibro.core.drive import (
    Directions,
    Loads,
    directions,
    ellipse_loads,
    ellipse_scale,
    line_loads,
    wave_loads,
    weight_over_load,
)
from vibro.core.numbers import ELLIPSE, FIELDS, HARMONICS, LINE, PIECES, TURN, Doubles, Integers
from vibro.core.waves import Mix, Waves, prepare_cells, prepare_pieces, read_harmonic, tabulate, with_bounds


class Scenes(NamedTuple):
    """A grid of scenes.

    Attributes
    ----------
    first, second, third : Doubles
        Amplitude [m], drive angle [rad] and nothing of a line; amplitude along and normal to the trough [m]
        and the phase of the latter [rad] of an ellipse; of other drives the factor of all amplitudes, the
        normal force of a clamped body over its mass, NaN for others [m/s^2], and nothing.
    frequency, static_friction, kinetic_friction, trough_angle, gravity, restitution : Doubles
        As in ``vibro.Scene``.
    harmonics : Doubles
        One after the other the arrays of further fields: amplitudes along the trough, harmonic by harmonic
        [m], their phases [rad], and the same normal to it.
    starts : Integers
        Where each of these begins.
    shape : Integers
        Of the grid, ``axes`` long.
    strides : Integers
        Along each axis, of each field in the order above: 9 + 4 H times ``axes`` long.
    axes : int
        Number of axes, at least 1.
    kind : int
        ``LINE``, ``ELLIPSE``, ``HARMONICS`` or ``PIECES``.
    size : int
        Number of harmonics H, or of pieces.
    most : float
        Largest acceleration of pieces [m/s^2].
    """

    first: Doubles
    second: Doubles
    third: Doubles
    frequency: Doubles
    static_friction: Doubles
    kinetic_friction: Doubles
    trough_angle: Doubles
    gravity: Doubles
    restitution: Doubles
    harmonics: Doubles
    starts: Integers
    shape: Integers
    strides: Integers
    axes: int
    kind: int
    size: int
    most: float


class Place(NamedTuple):
    """Where a thread is in a grid, and its memory for the waves of one scene.

    Attributes
    ----------
    index : Integers
        Indices of the grid, and then offsets of the fields.
    number, mark : Doubles, Integers
        Those of ``Waves``.
    """

    index: Integers  # type: ignore[assignment]  # nobody looks for members of this tuple
    number: Doubles
    mark: Integers


class Point(NamedTuple):
    """One scene: its groups and its scales.

    ``scale`` is the length A that the solver counts in [m], ``frequency`` that of the drive [Hz].
    """

    loads: Loads
    scale: float
    frequency: float
    restitution: float


def prepare(scenes: Scenes, place: Place, breaks: Doubles, pieces: Doubles) -> None:
    """Fill in what a thread's memory holds for all cells; ``breaks`` and ``pieces`` are those of a drive."""
    if scenes.kind == HARMONICS:
        prepare_cells(scenes.size, place.number)
    elif scenes.kind == PIECES:
        waves = Waves(PIECES, scenes.size, place.number, place.mark, 0.0, 0.0, 0.0)
        prepare_pieces(waves, breaks, pieces, scenes.most)


def _fields(scenes: Scenes) -> int:
    """Return how many fields a scene has."""
    return FIELDS + 4 * scenes.size if scenes.kind == HARMONICS else FIELDS


def seek(scenes: Scenes, place: Place, cell: int) -> None:
    """Set a place to a cell in the order of the grid."""
    axes, index, fields = scenes.axes, place.index, _fields(scenes)
    for field in range(FIELDS):
        index[axes + field] = 0
    for field in range(FIELDS, fields):
        index[axes + field] = scenes.starts[field - FIELDS]
    for back in range(axes):
        axis = axes - 1 - back
        index[axis] = cell % scenes.shape[axis]
        cell = cell // scenes.shape[axis]
        for field in range(fields):
            index[axes + field] += index[axis] * scenes.strides[fields * axis + field]


def advance(scenes: Scenes, place: Place) -> None:
    """Move a place to the next cell."""
    axes, index, fields = scenes.axes, place.index, _fields(scenes)
    for back in range(axes):
        axis = axes - 1 - back
        index[axis] += 1
        for field in range(fields):
            index[axes + field] += scenes.strides[fields * axis + field]
        if axis == 0 or index[axis] < scenes.shape[axis]:
            return
        for field in range(fields):
            index[axes + field] -= scenes.shape[axis] * scenes.strides[fields * axis + field]
        index[axis] = 0


def visit(scenes: Scenes, place: Place, cell: int, begin: int) -> None:
    """Set a place to the next cell of a range, the first of which is ``begin``."""
    if cell == begin:
        seek(scenes, place, cell)
    else:
        advance(scenes, place)


def _directions_at(scenes: Scenes, place: Place) -> Directions:
    """Evaluate the angles of a cell."""
    axes = scenes.axes
    trough = scenes.trough_angle[place.index[axes + 6]]
    first = 0.0
    if scenes.kind == LINE:
        first = scenes.second[place.index[axes + 1]]
    elif scenes.kind == ELLIPSE:
        first = scenes.third[place.index[axes + 2]]
    return directions(first, trough)


def point_at(scenes: Scenes, place: Place) -> Point:
    """Read the scene of a cell."""
    axes, index = scenes.axes, place.index
    angles = _directions_at(scenes, place)
    frequency, gravity = scenes.frequency[index[axes + 3]], scenes.gravity[index[axes + 7]]
    mu_s, mu_d = scenes.static_friction[index[axes + 4]], scenes.kinetic_friction[index[axes + 5]]
    restitution = scenes.restitution[index[axes + 8]]
    if scenes.kind == LINE:
        scale = scenes.first[index[axes]]
        loads = line_loads(weight_over_load(scale, frequency, gravity), angles, mu_s, mu_d)
    elif scenes.kind == ELLIPSE:
        along, normal = scenes.first[index[axes]], scenes.second[index[axes + 1]]
        scale = ellipse_scale(along, normal)
        weight = weight_over_load(scale, frequency, gravity)
        loads = ellipse_loads(along / scale, normal / scale, weight, angles, mu_s, mu_d)
    else:
        w, clamp = TURN * frequency, scenes.second[index[axes + 1]]
        scale = scenes.most * scenes.first[index[axes]] / w / w
        if scenes.kind == HARMONICS:
            scale = _largest_amplitude(scenes, place)
        weight = weight_over_load(scale, frequency, gravity)
        normal_weight = weight * angles.trough_cosine
        if not math.isnan(clamp):
            normal_weight = weight_over_load(scale, frequency, clamp)
        waves = _waves_at(scenes, place, scale)
        most = largest(waves, Mix(0.0, 0.0, 1.0))
        loads = wave_loads(waves, most, normal_weight, weight * angles.trough_sine, mu_s, mu_d)
    return Point(loads, scale, frequency, restitution)


def _largest_amplitude(scenes: Scenes, place: Place) -> float:
    """Return the largest amplitude of a drive with harmonics; 1 m where the trough stands still [m]."""
    start, count, scale = scenes.axes + FIELDS, scenes.size, 0.0
    for k in range(count):
        scale = max(scale, scenes.harmonics[place.index[start + k]])
        scale = max(scale, scenes.harmonics[place.index[start + 2 * count + k]])
    scale *= scenes.first[place.index[scenes.axes]]
    return scale if scale > 0.0 else 1.0


def _waves_at(scenes: Scenes, place: Place, scale: float) -> Waves:
    """Read the waves of a cell; those of pieces are the same in all cells."""
    waves = Waves(scenes.kind, scenes.size, place.number, place.mark, 0.0, 0.0, 0.0)
    if scenes.kind == HARMONICS:
        start, count = scenes.axes + FIELDS, scenes.size
        factor = scenes.first[place.index[scenes.axes]] / scale
        for direction in range(2):
            for k in range(count):
                amplitude = scenes.harmonics[place.index[start + 2 * direction * count + k]]
                phase = scenes.harmonics[place.index[start + (2 * direction + 1) * count + k]]
                read_harmonic(waves, direction == 1, k + 1, amplitude * factor, phase)
        tabulate(waves)
    return with_bounds(waves)


def unit_point_at(scenes: Scenes, place: Place) -> Point:
    """Read the scene of a cell at G = 1, where the trough's largest acceleration is that of gravity.

    Drives beyond one harmonic are read as they are.
    """
    if scenes.kind != LINE and scenes.kind != ELLIPSE:
        return point_at(scenes, place)
    axes, index = scenes.axes, place.index
    angles = _directions_at(scenes, place)
    mu_s, mu_d = scenes.static_friction[index[axes + 4]], scenes.kinetic_friction[index[axes + 5]]
    if scenes.kind == LINE:
        return Point(line_loads(1.0, angles, mu_s, mu_d), 1.0, 1.0, 0.0)
    along, normal = scenes.first[index[axes]], scenes.second[index[axes + 1]]
    scale = ellipse_scale(along, normal)
    x, y = along / scale, normal / scale
    # half of the ellipse's larger axis: the sum and the difference of two rotations against each other
    sine, cosine = y * angles.sine, y * angles.cosine
    ahead, behind = x + sine, x - sine
    reach = math.sqrt(ahead * ahead + cosine * cosine) + math.sqrt(behind * behind + cosine * cosine)
    share = 2.0 / reach if reach > 0.0 else 1.0
    return Point(ellipse_loads(share * x, share * y, 1.0, angles, mu_s, mu_d), scale, 1.0, 0.0)
