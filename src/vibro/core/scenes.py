"""Scenes as they come in: fields in SI units that broadcast against each other, read cell by cell.

Nothing is copied to broadcast it: each field has a stride along every axis of the grid, 0 where one value
serves the whole axis.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from vibro.core.buffers import Doubles, Integers
from vibro.core.drives import (
    Directions,
    Loads,
    directions,
    ellipse_loads,
    ellipse_scale,
    line_loads,
    weight_over_load,
)
from vibro.core.elementary import NAN

__all__ = ["Point", "Scenes", "advance", "no_directions", "point_at", "seek", "unit_point_at", "visit"]


class Scenes(NamedTuple):
    """A grid of scenes.

    Attributes
    ----------
    first, second, third : Doubles
        Amplitude [m], drive angle [rad] and nothing of a line; amplitude along and normal to the trough [m]
        and the phase of the latter [rad] of an ellipse.
    frequency, static_friction, kinetic_friction, trough_angle, gravity, restitution : Doubles
        As in ``vibro.Scene``.
    shape : Integers
        Of the grid, ``axes`` long.
    strides : Integers
        Along each axis, of each field in the order above: 9 times ``axes`` long.
    axes : int
        Number of axes, at least 1.
    ellipse : bool
        Which drive it is.
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
    shape: Integers
    strides: Integers
    axes: int
    ellipse: bool


class Point(NamedTuple):
    """One scene: its groups, its scales, and its angles, which the next cell may share.

    ``scale`` is the length A that the solver counts in [m], ``frequency`` that of the drive [Hz].
    """

    loads: Loads
    scale: float
    frequency: float
    restitution: float
    angles: Directions


def seek(scenes: Scenes, place: Integers, cell: int) -> None:
    """Set a place, indices of the grid and then offsets of the fields, to a cell in the order of the grid."""
    axes = scenes.axes
    for field in range(9):
        place[axes + field] = 0
    for back in range(axes):
        axis = axes - 1 - back
        place[axis] = cell % scenes.shape[axis]
        cell = cell // scenes.shape[axis]
        for field in range(9):
            place[axes + field] += place[axis] * scenes.strides[9 * axis + field]


def advance(scenes: Scenes, place: Integers) -> None:
    """Move a place to the next cell."""
    axes = scenes.axes
    axis = axes - 1
    while True:
        place[axis] += 1
        for field in range(9):
            place[axes + field] += scenes.strides[9 * axis + field]
        if axis == 0 or place[axis] < scenes.shape[axis]:
            return
        for field in range(9):
            place[axes + field] -= scenes.shape[axis] * scenes.strides[9 * axis + field]
        place[axis] = 0
        axis -= 1


def visit(scenes: Scenes, place: Integers, cell: int, begin: int) -> None:
    """Set a place to the next cell of a range, the first of which is ``begin``."""
    if cell == begin:
        seek(scenes, place, cell)
    else:
        advance(scenes, place)


def no_directions() -> Directions:
    """Stand in for the angles of a cell before the first."""
    return Directions(NAN, NAN, NAN, NAN, NAN, NAN, NAN)


def _angles_at(scenes: Scenes, place: Integers, known: Directions) -> Directions:
    """Evaluate the angles of a cell, but where they are those of the cell before."""
    axes = scenes.axes
    trough = scenes.trough_angle[place[axes + 6]]
    first = scenes.third[place[axes + 2]] if scenes.ellipse else scenes.second[place[axes + 1]]
    return known if known.first == first and known.trough == trough else directions(first, trough)


def point_at(scenes: Scenes, place: Integers, known: Directions) -> Point:
    """Read the scene of a cell; ``known`` are the angles of the cell before."""
    axes = scenes.axes
    angles = _angles_at(scenes, place, known)
    frequency, gravity = scenes.frequency[place[axes + 3]], scenes.gravity[place[axes + 7]]
    mu_s, mu_d = scenes.static_friction[place[axes + 4]], scenes.kinetic_friction[place[axes + 5]]
    restitution = scenes.restitution[place[axes + 8]]
    if scenes.ellipse:
        along, normal = scenes.first[place[axes]], scenes.second[place[axes + 1]]
        scale = ellipse_scale(along, normal)
        weight = weight_over_load(scale, frequency, gravity)
        loads = ellipse_loads(along / scale, normal / scale, weight, angles, mu_s, mu_d)
    else:
        scale = scenes.first[place[axes]]
        loads = line_loads(weight_over_load(scale, frequency, gravity), angles, mu_s, mu_d)
    return Point(loads, scale, frequency, restitution, angles)


def unit_point_at(scenes: Scenes, place: Integers, known: Directions) -> Point:
    """Read the scene of a cell at G = 1, where the trough's largest acceleration is that of gravity."""
    axes = scenes.axes
    angles = _angles_at(scenes, place, known)
    mu_s, mu_d = scenes.static_friction[place[axes + 4]], scenes.kinetic_friction[place[axes + 5]]
    if not scenes.ellipse:
        return Point(line_loads(1.0, angles, mu_s, mu_d), 1.0, 1.0, 0.0, angles)
    along, normal = scenes.first[place[axes]], scenes.second[place[axes + 1]]
    scale = ellipse_scale(along, normal)
    x, y = along / scale, normal / scale
    # half of the ellipse's larger axis: the sum and the difference of two rotations against each other
    sine, cosine = y * angles.sine, y * angles.cosine
    ahead, behind = x + sine, x - sine
    reach = math.sqrt(ahead * ahead + cosine * cosine) + math.sqrt(behind * behind + cosine * cosine)
    share = 2.0 / reach if reach > 0.0 else 1.0
    return Point(ellipse_loads(share * x, share * y, 1.0, angles, mu_s, mu_d), scale, 1.0, 0.0, angles)
