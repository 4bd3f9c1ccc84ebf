"""A map as the page draws it: cells, the curves between regimes, and how numbers become colours."""

from __future__ import annotations

from dataclasses import replace
from functools import cached_property
from typing import TYPE_CHECKING, Any, Final

import numpy as np

# Before any thread: where several import it at once, some of them see half of it.
from vibro.core.codes import Regime, Status
from vibro.explore.bands import certain_of, extreme_frictions, is_outside
from vibro.explore.controls import VIEWS
from vibro.explore.looks import STYLES, caption_of, look_of_axis, look_of_curve, look_of_scale
from vibro.explore.packing import pack
from vibro.inverse.certain import Certain
from vibro.plots.fields import HIDDEN_BY, Fields, hiding_fields, without_hidden, zero_lines
from vibro.plots.neighbours import fill_unknown
from vibro.plots.scales import scale_of, time_scale
from vibro.plots.style import (
    CURVES,
    ZERO_SPEED,
    CurveStyle,
    number_text,
    value_text,
)
from vibro.plots.view import choose_view, panels
from vibro.results.sweep import SweepResult
from vibro.sweeps.grid import scene_of
from vibro.sweeps.run import limits_of

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from vibro.axes import Axis
    from vibro.explore.levels import Shown
    from vibro.explore.state import State
    from vibro.plots.scales import Scale

    Floats = NDArray[np.float64]
    Curves = list[tuple[str, CurveStyle, list[Floats]]]

__all__ = ["MARKS", "packed_map"]

# Bits of what is marked in a cell.
BACKWARDS, AVERAGED, COEXISTS, PREVIEW, UNKNOWN, MEETS, COVERED, UNPROVED = (1 << i for i in range(8))

#: What they mean, for the page.
MARKS: Final = {
    "backwards": BACKWARDS,
    "averaged": AVERAGED,
    "coexists": COEXISTS,
    "preview": PREVIEW,
    "unknown": UNKNOWN,
    "meets": MEETS,
    "covered": COVERED,
    "unproved": UNPROVED,
}

_CERTAIN: Final = 3.0  # standard errors below zero, from which a mean is negative
_TARGET_WIDTH: Final = 2.6  # of its curve
_WIDTHS: Final = {"least": 0.7, "most": 1.3}  # of the curves of bodies of so much friction
_UNITS: Final = {"speed": "mm/s", "traverse": "s", "impact": "mm/s", "flight": ""}
_OF_SPEED: Final = ("speed", "traverse")
_FLIGHT_ALONE: Final = {"impact": "impact_velocity", "flight": "flight_fraction"}
_MILLIMETRE: Final = 1e3  # [1/m]
_WITHOUT_SPEED: Final = (Status.INFEASIBLE, Status.INDETERMINATE, Status.RUNAWAY, Status.UNRESOLVED)
_LARGEST: Final = float(np.finfo(np.float32).max)


def packed_map(state: State, cells: Shown) -> bytes:
    """Pack what the page draws of a map.

    Parameters
    ----------
    state : State
        What is shown.
    cells : Shown
        Of ``state.grid()``, as far as they are solved.

    Returns
    -------
    bytes
        As ``pack`` makes them. Arrays of cells have the shape (y, x), the lowest row first:
        ``speed`` [mm/s], ``values`` of the view unless that is of regimes, ``regime``, ``status``, ``marks``,
        with bands ``lowest`` and ``highest`` regime; ``points`` of the curves are shares of the axes.
    """
    drawn = _Drawn(state, cells)
    curves, numbers = drawn.curves(), drawn.numbers
    arrays: dict[str, NDArray[Any]] = {
        "speed": _single(_MILLIMETRE * drawn.cycle["mean_velocity"]),
        "regime": drawn.cycle["regime"],
        "status": drawn.cycle["status"],
        "marks": drawn.marks(),
    }
    if numbers is not None:
        arrays["values"] = _single(numbers)
    if drawn.certain is not None:
        arrays |= {"lowest": drawn.certain.lowest, "highest": drawn.certain.highest}
    pieces = [drawn.shares(piece) for _, _, lines in curves for piece in lines]
    arrays["points"] = _single(np.concatenate(pieces) if pieces else np.empty((0, 2)))
    header = {
        "view": state.view,
        "label": drawn.label,
        "title": drawn.title,
        "caption": caption_of(state),
        "x": look_of_axis(drawn.panel.x),
        "y": look_of_axis(drawn.y),
        "point": drawn.operating_point(),
        "scale": None if numbers is None else look_of_scale(drawn.scale(numbers), drawn.seen),
        "curves": [look_of_curve(name, style, lines) for name, style, lines in curves],
        "bands": drawn.certain is not None,
        "progress": {"done": cells.is_done, "share": cells.share, "text": drawn.progress_text(cells)},
        "notes": drawn.notes(),
        **STYLES,
    }
    return pack(header, arrays)


class _Drawn:
    """What a map shows, arrays of shape (y, x).

    Attributes
    ----------
    panel : Panel
        Axes and cells.
    y : Axis
        The one that runs up.
    certain : Certain or None
        What holds for all bodies of the bands of friction, if there are any.
    numbers : array or None
        Those of the view, in the units outside; NaN where there are none.
    """

    def __init__(self, state: State, cells: Shown) -> None:
        grid = state.grid()
        values = grid.values()
        length, title = grid.length, state.point.name or ""
        solved = SweepResult(grid.axes, grid.fixed, cells.cycle, cells.limits, length, None, title)
        view = choose_view(grid.axes, state.x.quantity.name, state.y.quantity.name, None, grid.fixed)
        assert view.y is not None
        self._state, self.y = state, view.y
        self.panel = panels(solved, view)[0][0]
        self.cycle: dict[str, NDArray[Any]] = dict(self.panel.cycle)
        self._fields = Fields(self.panel)
        self._values, self._is_turned = values, next(iter(grid.axes)) == view.x.name
        self._known, self._exact = (x.T if self._is_turned else x for x in (cells.known, cells.exact))
        found = certain_of(state, scene_of(values))
        self.certain = found
        if found is not None and self._is_turned:
            self.certain = Certain(found.lowest.T, found.highest.T, found.speed_min.T)
        self.numbers = self._numbers()

    @property
    def title(self) -> str:
        """What the map shows."""
        view = self._state.view
        return f"guaranteed {VIEWS[view]}" if self.certain is not None and view in _OF_SPEED else VIEWS[view]

    @property
    def label(self) -> str:
        """What the numbers are, with their unit."""
        unit = _UNITS.get(self._state.view, "")
        return self.title + (f" [{unit}]" if unit else "")

    def progress_text(self, cells: Shown) -> str:
        """Say what is not exact yet; regimes are, but those of drives with harmonics and of ellipses."""
        is_exact = self._state.view == "regime" and cells.limits is not None
        return "" if is_exact else cells.text

    @property
    def _speed(self) -> Floats:
        """Mean speed, or with bands that which no body falls short of [mm/s]."""
        speed = self.cycle["mean_velocity"] if self.certain is None else self.certain.speed_min
        return np.asarray(_MILLIMETRE * speed)

    def _numbers(self) -> Floats | None:
        view = self._state.view
        if view == "regime":
            return None
        if view in _FLIGHT_ALONE:
            values = self.cycle[_FLIGHT_ALONE[view]]
            return np.asarray(values * (_MILLIMETRE if view == "impact" else 1.0))
        if view == "speed":
            return self._speed
        assert self.panel.values is not None
        with np.errstate(divide="ignore", invalid="ignore"):
            times = (self._state.point.length or np.nan) / self._speed
        return np.where(np.isfinite(times) & (times > 0.0), times, np.nan)

    @property
    def seen(self) -> Floats:
        """The numbers that are seen; NaN elsewhere."""
        return np.where(self._covered, np.nan, np.nan if self.numbers is None else self.numbers)

    @property
    def _covered(self) -> NDArray[np.bool_]:
        """Whether the colour of rest covers each cell: nothing moves there, or nothing flies."""
        regime = self.cycle["regime"]
        if self._state.view in _FLIGHT_ALONE:
            return np.asarray((regime >= 0) & (regime != Regime.HOPPING))
        rests = regime if self.certain is None else self.certain.highest
        return np.asarray((rests == Regime.NO_SLIP) & (self.numbers is not None))

    def marks(self) -> NDArray[np.uint8]:
        """Return what is marked in each cell, as bits."""
        cycle, alone = self.cycle, self.certain is None
        with np.errstate(invalid="ignore"):
            backwards = cycle["mean_velocity"] < -_CERTAIN * cycle["mean_velocity_error"]
        bits: dict[int, Any] = {
            BACKWARDS: backwards & alone,
            AVERAGED: (cycle["status"] == int(Status.AVERAGED)) & alone,
            COEXISTS: (cycle["coexists"] > 0) & alone,
            PREVIEW: self._known & ~self._exact,
            UNKNOWN: ~self._known,
            COVERED: self._covered,
        }
        if self._state.target is not None:
            bits[MEETS] = self._meets > 0.0
        if self.certain is not None and self._state.view in _OF_SPEED:
            assert self.numbers is not None
            bits[UNPROVED] = np.isnan(self.numbers) & (self.certain.highest >= 0) & ~self._covered
        marks = np.zeros(backwards.shape, np.uint8)
        for bit, where in bits.items():
            marks |= np.where(where, np.uint8(bit), np.uint8(0))
        return marks

    @cached_property
    def _meets(self) -> Floats:
        """Positive where bodies go at least as fast as is wanted, and do not hop."""
        fields, target = self._fields, self._state.target or 1.0
        if self.certain is not None:
            proved = np.isfinite(self._speed)
            if not proved.any():
                return np.full(proved.shape, -1.0)
            excess = fill_unknown(self._speed, proved) / target - 1.0  # up to the middle between cells
            return np.asarray(np.minimum(excess, np.where(proved, 0.5, -0.5)))
        # The speed drops where back slip enters: either side has numbers of its own up to there.
        back, known = fields.log_ratio["back_slip"], np.isfinite(self.cycle["mean_velocity"])
        known &= self.cycle["regime"] != Regime.NO_SLIP
        sides = []
        for beyond in (-back, back):
            speed = _continued(self.cycle["mean_velocity"], known & (beyond > 0.0))
            sides.append(np.minimum(_MILLIMETRE * speed / target - 1.0, beyond))
        missing = [fields.unanswered(status) for status in _WITHOUT_SPEED if status in fields.statuses]
        fails = np.maximum.reduce([fields.log_ratio["hop"], fields.rest, *missing])
        return np.asarray(np.minimum(np.maximum(*sides), -fails))

    def curves(self) -> Curves:
        """Return the curves, by name: how they are drawn, and their pieces in the units outside."""
        fields, view = self._fields, self._state.view
        alone = self.certain is not None or view in _FLIGHT_ALONE
        found: Curves = []
        for name in ("hop",) if alone else CURVES:
            lines = zero_lines(fields, fields.log_ratio[name], hiding_fields(fields, name))
            found.append((name, CURVES[name], lines))
        if self.certain is not None and view not in _FLIGHT_ALONE:
            found += self._curves_of_bands()
        if view not in _FLIGHT_ALONE and self.certain is None and (self.cycle["mean_velocity"] < 0.0).any():
            hidden = [fields.rest, fields.unknown, -fields.regular]
            lines = zero_lines(fields, without_hidden(fields.reversal, hidden), hidden)
            found.append(("zero_speed", ZERO_SPEED, lines))
        if self._state.target is not None:
            sure = "without hopping" if self.certain is None else "guaranteed"
            label = f"{number_text(self._state.target)} mm/s, {sure}"
            style = CurveStyle(label, "-", _TARGET_WIDTH)
            found.append(("target", style, zero_lines(fields, self._meets)))
        return [curve for curve in found if curve[2]]

    def _curves_of_bands(self) -> Curves:
        """Return where the bodies of least and of most static friction begin to slip, and to slip back."""
        found: Curves = []
        for which, (mu_s, mu_d) in extreme_frictions(self._state).items():
            frictions = {"static_friction": mu_s, "kinetic_friction": mu_d}
            limits = limits_of(self._values | {name: np.full((1, 1), mu) for name, mu in frictions.items()})
            assert limits is not None
            critical = {n: loads.T if self._is_turned else loads for n, loads in limits._asdict().items()}
            fields = Fields(replace(self.panel, critical=critical))
            for name in ("forward_onset", "back_slip"):
                style = CURVES[name]
                style = style._replace(
                    label=f"{style.label}, {which} friction", width=_WIDTHS[which] * style.width
                )
                hidden = [fields.log_ratio[other] for other in HIDDEN_BY[name]] + [fields.infeasible]
                found.append((f"{name}_{which}", style, zero_lines(fields, fields.log_ratio[name], hidden)))
        return found

    def shares(self, points: Floats) -> Floats:
        """Turn points in the units outside into shares of the axes, from left to right and from below."""
        return np.column_stack([_share(axis, points[:, i]) for i, axis in enumerate((self.panel.x, self.y))])

    def operating_point(self) -> list[float]:
        """Return where the operating point lies, in shares of the axes; it may lie outside."""
        fixed = self._state.point.fixed | {"friction_ratio": self._state.friction_ratio}
        point = np.array([[fixed[axis.name] for axis in (self.panel.x, self.y)]])
        with np.errstate(divide="ignore", invalid="ignore"):  # 0 and less on a logarithmic axis
            place = np.nan_to_num(self.shares(point)[0], nan=-9.0, neginf=-9.0)
        return [float(share) for share in place.clip(-9.0, 9.0)]

    def scale(self, numbers: Floats) -> Scale:
        """Choose how numbers become colours."""
        seen = np.isfinite(numbers) & ~self._covered
        if self._state.view == "traverse":
            return time_scale(numbers[seen])
        regular = seen & (self.cycle["period_cycles"] == 1.0)
        calm = seen & (self.cycle["regime"] != Regime.HOPPING)
        reverses = self.certain is None and self._state.view == "speed" and self._fields.reverses
        return scale_of(numbers[seen], numbers[regular], numbers[calm], reverses=reverses)

    def _best(self, numbers: Floats) -> str:
        """Say where the largest number is, of times the least."""
        is_time = self._state.view == "traverse"
        best = int(np.nanargmin(numbers) if is_time else np.nanargmax(numbers))
        row, column = np.unravel_index(best, numbers.shape)
        places = ((self.panel.x, column), (self.y, row))
        where = " and ".join(f"{axis.label} {value_text(axis.name, axis.values[i])}" for axis, i in places)
        unit = _UNITS[self._state.view]
        so_far = "" if self._exact.all() else " so far"
        what = "Shortest" if is_time else "Largest"
        return f"{what} here{so_far}: {number_text(numbers[row, column])} {unit}".rstrip() + f", at {where}."

    def notes(self) -> list[str]:
        """Return what else is to be said."""
        notes = []
        if not all(0.0 <= share <= 1.0 for share in self.operating_point()):
            notes.append("The operating point lies outside of this map.")
        if np.isfinite(self.seen).any():
            notes.append(self._best(self.seen))
        if self.certain is not None and is_outside(self._state):
            notes.append("The operating point's own friction lies outside of its bands.")
        if self.certain is not None:
            notes.append(
                "Flights depend on friction: they are those of the operating point's own."
                if self._state.view in _FLIGHT_ALONE
                else "Colours are of all bodies of the bands, curves of those of least and of most friction."
            )
        if self._state.view in _FLIGHT_ALONE and (self.cycle["status"] == Status.FLIGHT_NOT_MODELLED).all():
            notes.append("Flights of drives with harmonics are not modelled.")
        return notes


def _continued(values: Floats, known: NDArray[np.bool_]) -> Floats:
    """Continue numbers beyond the points where they are known: straight on by one point, then level."""
    total, count = np.zeros(values.shape), np.zeros(values.shape)
    for lines, found, sums, counts in ((values, known, total, count), (values.T, known.T, total.T, count.T)):
        for way in (slice(None), slice(None, None, -1)):
            v, k = lines[:, way], found[:, way]
            ends = ~k[:, 2:] & k[:, 1:-1] & k[:, :-2]
            sums[:, way][:, 2:][ends] += (2.0 * v[:, 1:-1] - v[:, :-2])[ends]
            counts[:, way][:, 2:] += ends
    return fill_unknown(np.where(known, values, total / np.maximum(count, 1.0)), known | (count > 0.0))


def _share(axis: Axis, values: Floats) -> Floats:
    ends = axis.values[[0, -1]]
    if axis.spacing == "log":
        values, ends = np.log(values), np.log(ends)
    return np.asarray((values - ends[0]) / (ends[1] - ends[0]))


def _single(values: Floats) -> NDArray[np.float32]:
    """Round to single precision; numbers beyond its range are the largest that it has."""
    return np.clip(values, -_LARGEST, _LARGEST).astype(np.float32)
