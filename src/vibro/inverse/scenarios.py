"""Scenarios: bodies that stand for an uncertainty set, at fixed shares of its bands or just past a drop.

A design is optimal for some scenarios; a body that turns out to be slower than all of them joins them. Where
the speed drops as back slip enters, the slowest body stands just past the drop, and that moves with the
setting: no fixed share of a band stands for it, so such scenarios are moved to the drop in every box.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Final, NamedTuple

import numpy as np

from vibro.core.codes import Regime
from vibro.inverse.tolerances import TOLERANCES
from vibro.limits import critical_loads
from vibro.roots import close_in
from vibro.steady import solve

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from vibro.inverse.spaces import Box, Points

    Floats = NDArray[np.float64]
    Bools = NDArray[np.bool_]

__all__ = ["Scenarios", "entry_loads"]

_FIXED: Final = -1  # in place of an axis
_LOAD: Final = 0  # the axis of the load
# Along these back slip enters once; frictions first, which are seldom known.
_ALONG: Final = ("static_friction", "second_friction", "drive_angle")
_PAST: Final = 1.0 + TOLERANCES.past_drop
_WIDTH: Final = 2.0**-40  # [share of a band] to which a drop is found; ``past_drop`` is a thousand times that


class Scenarios(NamedTuple):
    """Bodies of a box.

    Attributes
    ----------
    shares : (axes, n) array
        Unit-cube coordinates: shares of the bands.
    axes : (n,) array
        Index of the band along which a body keeps to the point where back slip has just entered; -1 for
        bodies at fixed shares.
    ratios : (n,) array
        Of bodies that keep to a load, that over the load at which back slip enters: past it the speed may
        fall for a while.
    """

    shares: Floats
    axes: NDArray[np.intp]
    ratios: Floats

    @classmethod
    def fixed(cls, shares: Floats) -> Scenarios:
        """Return bodies at shares of the bands."""
        return cls(shares, np.full(shares.shape[1], _FIXED), np.ones(shares.shape[1]))

    @property
    def size(self) -> int:
        """How many there are."""
        return int(self.shares.shape[1])

    def joined(self, box: Box, shares: Floats) -> Scenarios:
        """Add bodies at shares of the bands of a single box; those on a drop keep to it from now on."""
        if not shares.shape[1]:
            return self
        axes = np.array([_drop_axis(box, shares[:, [i]]) for i in range(shares.shape[1])])
        points = box.points(shares)
        ratios = points.load / (entry_loads(box, points) * _PAST)
        inside = (axes == _FIXED) & (shares[_LOAD] > 0.0) & (shares[_LOAD] < 1.0)
        axes[inside & (ratios >= 1.0)] = _LOAD
        known = set(self._keys())
        new = Scenarios(shares, axes, np.where(axes == _LOAD, ratios, 1.0))
        fresh = [i for i, key in enumerate(new._keys()) if key not in known]
        return Scenarios(
            np.hstack([self.shares, shares[:, fresh]]),
            np.append(self.axes, axes[fresh]),
            np.append(self.ratios, new.ratios[fresh]),
        )

    def _keys(self) -> list[tuple[float, ...]]:
        shares = np.round(self.shares, TOLERANCES.digits)
        moving = np.flatnonzero(self.axes != _FIXED)
        shares[self.axes[moving], moving] = 0.0
        ratios = np.round(self.ratios, TOLERANCES.digits)
        columns = zip(self.axes.tolist(), ratios.tolist(), shares.T.tolist(), strict=True)
        return [(axis, ratio, *share) for axis, ratio, share in columns]

    def at(self, boxes: Box) -> Floats:
        """Return the shares of all bodies in m boxes, of shape (axes, m, n)."""
        ends = np.broadcast_shapes(*(np.shape(end) for span in boxes.spans for end in span))
        shares = np.repeat(self.shares[:, None, :], ends[0], axis=1)
        moving = np.flatnonzero((self.axes != _FIXED) & (self.axes != _LOAD))
        if moving.size:
            shares[:, :, moving] = _moved_to_drops(boxes, shares[:, :, moving], self.axes[moving])
        loaded = np.flatnonzero(self.axes == _LOAD)
        if loaded.size:
            low, high = boxes.load
            entries = entry_loads(boxes, boxes.points(shares[:, :, loaded])) * _PAST
            with np.errstate(divide="ignore", invalid="ignore"):
                share = (self.ratios[loaded] * entries - low) / (high - low)
            shares[_LOAD][:, loaded] = np.clip(np.nan_to_num(share, nan=1.0), 0.0, 1.0)
        return shares


def entry_loads(boxes: Box, points: Points) -> Floats:
    """Return the loads at which back slip enters at points; inf where it never does."""
    scene = boxes.scene(points, fast=False)
    entry = points.load * critical_loads(scene).back_slip / scene.load
    return np.nan_to_num(entry, nan=np.inf, posinf=np.inf)


def _moved_to_drops(boxes: Box, shares: Floats, axes: NDArray[np.intp]) -> Floats:
    """Move bodies along their axes to where back slip has just entered; they stay where it does not."""
    bodies = np.arange(shares.shape[2])

    def moved(to: Floats) -> Floats:
        there = shares.copy()
        there[axes, :, bodies] = to
        return there

    def slips(to: Floats) -> Bools:
        return _slips_back(boxes, boxes.points(moved(to))).T

    start, end = np.zeros(shares.shape[:0:-1]), np.ones(shares.shape[:0:-1])
    first, last = slips(start), slips(end)
    slipping, other = np.where(first, start, end), np.where(first, end, start)
    slipping, other = close_in(
        lambda x: np.where(slips(x[..., 0]), 1.0, -1.0)[..., None], slipping, other, absolute=_WIDTH
    )
    # well on the side that slips back: rounding decides at the drop itself
    slipping = slipping + TOLERANCES.past_drop * ((last & ~first) - slipping)
    return moved(np.where(first == last, shares[axes, :, bodies], slipping))


def _drop_axis(box: Box, shares: Floats) -> int:
    """Return the axis along which back slip enters at a body of a single box; -1 where there is none."""
    for axis in map(box.axes.index, _ALONG[: 3 if _ALONG[2] in box.axes else 2]):
        if not box.varies[axis]:
            continue
        beside = np.repeat(shares, 2, axis=1)
        beside[axis] = np.clip(beside[axis] + TOLERANCES.drop * np.array([-1.0, 1.0]), 0.0, 1.0)
        below, above = _slips_back(box, box.points(beside))
        if below != above:
            return axis
    return _FIXED


def _slips_back(boxes: Box, points: Points) -> Bools:
    """Return which bodies slip back or hop."""
    scene = boxes.scene(points, fast=False)
    return np.asarray(solve(scene, accuracy="regimes").regime >= Regime.BACK_SLIP)
