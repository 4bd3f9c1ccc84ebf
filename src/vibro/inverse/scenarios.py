"""Scenarios: bodies that represent an uncertainty set.

A design is optimal for some scenarios; a body that turns out to be slower joins them. Where the speed drops
as back slip enters, the slowest body is just past the drop. The drop moves with the setting, so that such a
scenario has no fixed place in the unit cube: it is moved to the drop of every box.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Final, NamedTuple

import numpy as np

from vibro.core.codes import Regime
from vibro.inverse.changes import change_loads
from vibro.inverse.tolerances import TOLERANCES
from vibro.roots import close_in
from vibro.steady import solve

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from vibro.inverse.spaces import Points, UncertaintySet

    Floats = NDArray[np.float64]
    Bools = NDArray[np.bool_]

__all__ = ["Scenarios", "at_loads", "entry_loads"]

_FIXED: Final = -1  # in place of an axis: the body has a fixed place
_LOAD: Final = 0  # the axis of the load
# Axes along which back slip enters once; frictions first, since their bands are the widest.
_ALONG: Final = ("static_friction", "second_friction", "drive_angle")
_LOADS: Final = np.linspace(0.0, 1.0, 5)  # shares of the load's band at which slowest bodies join
_PAST: Final = 1.0 + TOLERANCES.past_drop
_SECTIONS: Final = 3  # of its bracket that are computed in one call
_WIDTH: Final = 2.0**-40  # [share of a band] to which a drop is found; ``past_drop`` is a thousand times that


class Scenarios(NamedTuple):
    """Bodies of an uncertainty set.

    Attributes
    ----------
    coordinates : (axes, n) array
        Unit-cube coordinates.
    axes : (n,) array
        Index of the band along which a body keeps to the point where back slip has just entered; -1 for
        bodies at fixed coordinates.
    ratios : (n,) array
        Of bodies that keep to a load, that over the load at which back slip enters: past it the speed may
        fall for a while.
    """

    coordinates: Floats
    axes: NDArray[np.intp]
    ratios: Floats

    @classmethod
    def fixed(cls, coordinates: Floats) -> Scenarios:
        """Return bodies at fixed places."""
        return cls(coordinates, np.full(coordinates.shape[1], _FIXED), np.ones(coordinates.shape[1]))

    @property
    def size(self) -> int:
        """Number of bodies."""
        return int(self.coordinates.shape[1])

    def joined(self, box: UncertaintySet, coordinates: Floats) -> Scenarios:
        """Add bodies of a single box; those just past a drop follow it from now on."""
        if not coordinates.shape[1]:
            return self
        axes = np.array([_drop_axis(box, coordinates[:, [i]]) for i in range(coordinates.shape[1])])
        points = box.points(coordinates)
        ratios = points.load / (entry_loads(box, points) * _PAST)
        inside = (axes == _FIXED) & (coordinates[_LOAD] > 0.0) & (coordinates[_LOAD] < 1.0)
        axes[inside & (ratios >= 1.0)] = _LOAD
        known = set(self._keys())
        new = Scenarios(coordinates, axes, np.where(axes == _LOAD, ratios, 1.0))
        fresh = [i for i, key in enumerate(new._keys()) if key not in known]
        return Scenarios(
            np.hstack([self.coordinates, coordinates[:, fresh]]),
            np.append(self.axes, axes[fresh]),
            np.append(self.ratios, new.ratios[fresh]),
        )

    def _keys(self) -> list[tuple[float, ...]]:
        coordinates = np.round(self.coordinates, TOLERANCES.digits)
        moving = np.flatnonzero(self.axes != _FIXED)
        coordinates[self.axes[moving], moving] = 0.0
        ratios = np.round(self.ratios, TOLERANCES.digits)
        columns = zip(self.axes.tolist(), ratios.tolist(), coordinates.T.tolist(), strict=True)
        return [(axis, ratio, *share) for axis, ratio, share in columns]

    def at(self, boxes: UncertaintySet) -> Floats:
        """Return the coordinates of all bodies in m boxes, of shape (axes, m, n)."""
        ends = np.broadcast_shapes(*(np.shape(end) for span in boxes.spans for end in span))
        coordinates = np.repeat(self.coordinates[:, None, :], ends[0], axis=1)
        moving = np.flatnonzero((self.axes != _FIXED) & (self.axes != _LOAD))
        if moving.size:
            coordinates[:, :, moving] = _moved_to_drops(boxes, coordinates[:, :, moving], self.axes[moving])
        loaded = np.flatnonzero(self.axes == _LOAD)
        if loaded.size:
            low, high = boxes.load
            entries = entry_loads(boxes, boxes.points(coordinates[:, :, loaded])) * _PAST
            with np.errstate(divide="ignore", invalid="ignore"):
                share = (self.ratios[loaded] * entries - low) / (high - low)
            coordinates[_LOAD][:, loaded] = np.clip(np.nan_to_num(share, nan=1.0), 0.0, 1.0)
        return coordinates


def at_loads(box: UncertaintySet, coordinates: Floats, own: float) -> Floats:
    """Return bodies of a single box at loads over the whole band, and at a share of it of their own."""
    loads = np.append(_LOADS, own) if box.varies[_LOAD] else np.zeros(1)
    bodies = np.repeat(coordinates, loads.size, axis=1)
    bodies[_LOAD] = np.tile(loads, coordinates.shape[1])
    return bodies


def entry_loads(boxes: UncertaintySet, points: Points) -> Floats:
    """Return the loads at which back slip enters at points; inf where it never does, or is not known."""
    scene = boxes.scene(points, fast=False)
    entry = points.load * change_loads(scene).get("back_slip", np.inf) / scene.load
    return np.nan_to_num(entry, nan=np.inf, posinf=np.inf)


def _moved_to_drops(boxes: UncertaintySet, coordinates: Floats, axes: NDArray[np.intp]) -> Floats:
    """Move bodies along their axes to where back slip has just entered, if it does."""
    bodies = np.arange(coordinates.shape[2])

    def moved(to: Floats) -> Floats:
        """Put each body of each box at some values, of shape (bodies, boxes, values)."""
        count = to.shape[2]
        there = np.repeat(coordinates, count, axis=2)
        values = np.moveaxis(to, 2, 1).reshape(there.shape[2], to.shape[1])
        there[np.repeat(axes, count), :, np.arange(there.shape[2])] = values
        return there

    def slips(to: Floats) -> Bools:
        slip = _slips_back(boxes, boxes.points(moved(to)))
        return np.moveaxis(slip.reshape(to.shape[1], bodies.size, to.shape[2]), 0, 1)

    ends = np.broadcast_to((0.0, 1.0), (*coordinates.shape[:0:-1], 2))
    first, last = np.moveaxis(slips(ends), 2, 0)
    slipping, other = np.where(first, 0.0, 1.0), np.where(first, 1.0, 0.0)
    slipping, other = close_in(
        lambda x: np.where(slips(x), 1.0, -1.0), slipping, other, absolute=_WIDTH, sections=_SECTIONS
    )
    # stay clear of the drop itself, where rounding decides the side
    slipping = slipping + TOLERANCES.past_drop * ((last & ~first) - slipping)
    return moved(np.where(first == last, coordinates[axes, :, bodies], slipping)[..., None])


def _drop_axis(box: UncertaintySet, coordinates: Floats) -> int:
    """Return the axis along which back slip enters at a body of a single box; -1 without one."""
    for axis in map(box.axes.index, _ALONG[: 3 if _ALONG[2] in box.axes else 2]):
        if not box.varies[axis]:
            continue
        beside = np.repeat(coordinates, 2, axis=1)
        beside[axis] = np.clip(beside[axis] + TOLERANCES.drop * np.array([-1.0, 1.0]), 0.0, 1.0)
        below, above = _slips_back(box, box.points(beside))
        if below != above:
            return axis
    return _FIXED


def _slips_back(boxes: UncertaintySet, points: Points) -> Bools:
    """Return which bodies slip back or hop."""
    scene = boxes.scene(points, fast=False)
    return np.asarray(solve(scene, output="regimes").regime >= Regime.BACK_SLIP)
