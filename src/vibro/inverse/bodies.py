"""Bodies that stand for a box: at fixed shares of its bands, or where back slip has just entered."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final, NamedTuple

import numpy as np

from vibro.inverse.boxes import AXES
from vibro.limits import critical_loads_of_lines

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from vibro.inverse.boxes import Box, Points

    Floats = NDArray[np.float64]
    Bools = NDArray[np.bool_]

__all__ = ["Bodies"]

_STILL: Final = -1  # in place of an axis
_LOAD: Final = AXES.index("load")
# Along these back slip enters once; frictions first, which are seldom known.
_ALONG: Final = tuple(AXES.index(name) for name in ("static_friction", "second_friction", "drive_angle"))
_BESIDE: Final = 1e-6  # of a band, within which a drop is looked for
_STEPS: Final = 40  # of bisection
_INSIDE: Final = 1e-9  # of the way back from a drop that is kept away from it
_SAME: Final = 6  # digits of shares in which bodies differ


class Bodies(NamedTuple):
    """Bodies of a box.

    Attributes
    ----------
    shares : (5, n) array
        Of the bands.
    axes : (n,) array
        Index of the band along which a body keeps to the point where back slip has just entered: where that
        is moves with the setting, so that no share stands for it; -1 for bodies that stay.
    ratios : (n,) array
        Of bodies that keep to a load, that over the load at which back slip enters: past it the speed may
        fall for a while.
    """

    shares: Floats
    axes: NDArray[np.intp]
    ratios: Floats

    @classmethod
    def staying(cls, shares: Floats) -> Bodies:
        """Return bodies at shares of the bands."""
        return cls(shares, np.full(shares.shape[1], _STILL), np.ones(shares.shape[1]))

    def joined(self, box: Box, shares: Floats) -> Bodies:
        """Add bodies at shares of the bands of a single box; those on a drop keep to it from now on."""
        if not shares.shape[1]:
            return self
        axes = np.array([_drops_along(box, shares[:, [i]]) for i in range(shares.shape[1])])
        points = box.points(shares)
        ratios = points.load / _entry_load(points)
        inside = (axes == _STILL) & (shares[_LOAD] > 0.0) & (shares[_LOAD] < 1.0)
        axes[inside & (ratios >= 1.0)] = _LOAD
        known = set(self._keys())
        new = Bodies(shares, axes, np.where(axes == _LOAD, ratios, 1.0))
        fresh = [i for i, key in enumerate(new._keys()) if key not in known]
        return Bodies(
            np.hstack([self.shares, shares[:, fresh]]),
            np.append(self.axes, axes[fresh]),
            np.append(self.ratios, new.ratios[fresh]),
        )

    def _keys(self) -> list[tuple[float, ...]]:
        shares = np.round(self.shares, _SAME)
        moving = np.flatnonzero(self.axes != _STILL)
        shares[self.axes[moving], moving] = 0.0
        ratios = np.round(self.ratios, _SAME)
        columns = zip(self.axes.tolist(), ratios.tolist(), shares.T.tolist(), strict=True)
        return [(axis, ratio, *share) for axis, ratio, share in columns]

    def at(self, boxes: Box) -> Floats:
        """Return the shares of all bodies in m boxes, of shape (5, m, n)."""
        ends = np.broadcast(*(end for span in boxes.spans for end in span))
        shares = np.repeat(self.shares[:, None, :], ends.shape[0], axis=1)
        moving = np.flatnonzero((self.axes != _STILL) & (self.axes != _LOAD))
        if moving.size:
            shares[:, :, moving] = _on_drops(boxes, shares[:, :, moving], self.axes[moving])
        loaded = np.flatnonzero(self.axes == _LOAD)
        if loaded.size:
            low, high = boxes.load
            entries = _entry_load(boxes.points(shares[:, :, loaded]))
            with np.errstate(divide="ignore", invalid="ignore"):
                share = (self.ratios[loaded] * entries - low) / (high - low)
            shares[_LOAD][:, loaded] = np.clip(np.nan_to_num(share, nan=1.0), 0.0, 1.0)
        return shares


def _on_drops(boxes: Box, shares: Floats, axes: NDArray[np.intp]) -> Floats:
    """Move bodies along their axes to where back slip has just entered; they stay where it does not."""
    bodies = np.arange(shares.shape[2])

    def moved(to: Floats) -> Floats:
        there = shares.copy()
        there[axes, :, bodies] = to
        return there

    n, m = len(axes), shares.shape[1]
    slipping, other = np.zeros((n, m)), np.ones((n, m))
    first, last = (_slips_back(boxes.points(moved(end))).T for end in (slipping, other))
    turned = last & ~first
    slipping, other = np.where(turned, other, slipping), np.where(turned, slipping, other)
    for _ in range(_STEPS):
        middle = 0.5 * (slipping + other)
        slips = _slips_back(boxes.points(moved(middle))).T
        slipping, other = np.where(slips, middle, slipping), np.where(slips, other, middle)
    # well on the side that slips back: rounding decides at the drop itself
    slipping += _INSIDE * (turned - slipping)
    return moved(np.where(first == last, shares[axes, :, bodies], slipping))


def _entry_load(at: Points) -> Floats:
    """Return the load at which back slip enters, or just above."""
    known = critical_loads_of_lines(at.drive_angle, at.static_friction, at.kinetic_friction, at.trough_angle)
    return np.asarray(known.back_slip * (1.0 + _INSIDE))


def _drops_along(box: Box, shares: Floats) -> int:
    """Return the axis along which back slip enters at a body of a single box; -1 where there is none."""
    for axis in _ALONG:
        if not box.varies[axis]:
            continue
        beside = np.repeat(shares, 2, axis=1)
        beside[axis] = np.clip(beside[axis] + np.array([-_BESIDE, _BESIDE]), 0.0, 1.0)
        below, above = _slips_back(box.points(beside))
        if below != above:
            return axis
    return _STILL


def _slips_back(at: Points) -> Bools:
    """Tell which bodies in contact that slip forward from rest slip back, too, Eqs. (5) and (22).

    ``solve`` would tell as much, but designs would take twice as long: this is asked forty times a setting.
    """
    along, across = np.cos(at.drive_angle), np.sin(at.drive_angle)
    normal, tangential = np.cos(at.trough_angle), np.sin(at.trough_angle)
    hold, lift = at.static_friction * normal, at.static_friction * across
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        s_f = (hold + tangential) / (along + lift) / at.load
        s_b = (hold - tangential) / (along - lift) / at.load
        cosines = np.sqrt((1.0 - s_f) * (1.0 + s_f)) + np.sqrt((1.0 - s_b) * (1.0 + s_b))
        gain = (s_b - s_f) * (s_b + s_f) / cosines
        k = (at.kinetic_friction * normal + tangential) / (along + at.kinetic_friction * across) / at.load
        lasts = gain > k * (np.pi + np.arccos(s_f) + np.arccos(s_b))
    return np.asarray((along > lift) & (s_b < 1.0) & ~lasts)
