"""A map as the page draws it: cells, the curves between regimes, and how numbers become colours."""

from __future__ import annotations

from dataclasses import replace
from functools import cached_property
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from vibro.core.codes import Regime, Status
from vibro.designs.guarantees import Certain
from vibro.explore.bands import certain_of, extreme_frictions, is_outside
from vibro.explore.controls import VIEWS, is_weighed
from vibro.explore.looks import HATCHES, STRIPES, curve_look, looks_of
from vibro.explore.packing import pack
from vibro.explore.words import caption_of, round_numbers, symbol_of, ticks_of, unit_of
from vibro.plots.fields import HIDDEN_BY, Fields, hiding_fields, zero_lines
from vibro.plots.neighbours import fill_unknown
from vibro.plots.scales import scale_of, time_scale
from vibro.plots.style import CURVES, ZERO_SPEED, CurveStyle, number_text, value_text
from vibro.plots.view import choose_view, panels
from vibro.quantities import QUANTITIES
from vibro.results.sweep import SweepResult
from vibro.sweeps.grid import scene_of
from vibro.sweeps.run import limits_of

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from vibro.axes import Axis
    from vibro.explore.levels import Shown
    from vibro.explore.state import State
    from vibro.plots.scales import Scale
    from vibro.reals import Floats

    Curves = list[tuple[str, CurveStyle, list[Floats]]]

__all__ = ["packed_map"]

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
        State of the page.
    cells : Shown
        Of ``state.grid()``, as far as they are solved.

    Returns
    -------
    bytes
        As ``pack`` makes them. Arrays of cells have the shape (y, x), the lowest row first:
        ``values`` of the view unless that is of regimes, ``regime``, ``status``, -1 where not known yet,
        ``faces``, ``others`` and ``marks`` as ``looks_of`` chooses them, with bands ``lowest`` and
        ``highest`` regime, without ``speed`` [mm/s] unless ``values`` are that; of a machine the
        ``amplitude`` [mm] that it reaches;
        ``points`` of the curves, one after the other, are shares of the axes; NaN ends every piece.
    """
    drawn = _Drawn(state, cells)
    curves, numbers, cycle = drawn.curves(), drawn.numbers, drawn.cycle
    scale = None if numbers is None else drawn.scale(numbers)
    ticks = [] if scale is None else _scale_ticks(scale, drawn.seen)
    shown = None if numbers is None or scale is None else (scale, numbers, drawn.covered)
    lowest, highest = (cycle["regime"],) * 2
    if drawn.certain is not None:
        lowest, highest = drawn.certain.lowest, drawn.certain.highest
    looks = looks_of(lowest, highest, shown, drawn.marks(), drawn.words())
    arrays: dict[str, NDArray[Any]] = {
        "regime": cycle["regime"],
        "status": np.where(drawn.known, cycle["status"], np.int8(-1)),
        "faces": looks.faces,
        "others": looks.others,
        "marks": looks.marks,
    }
    if numbers is not None:
        arrays["values"] = _single(numbers)
    if drawn.certain is not None:
        arrays |= {"lowest": lowest, "highest": highest}
    elif state.view != "speed":
        arrays["speed"] = _single(_MILLIMETRE * cycle["mean_velocity"])
    if drawn.amplitude is not None:
        arrays["amplitude"] = _single(drawn.amplitude)
    gap = np.full((1, 2), np.nan)
    points = [part for _, _, lines in curves for line in lines for part in (drawn.shares(line), gap)]
    arrays["points"] = _single(np.concatenate(points) if points else np.empty((0, 2)))
    header = {
        "view": state.view,
        "label": drawn.label,
        "title": drawn.title,
        "caption": caption_of(state),
        "x": _axis(drawn.panel.x),
        "y": _axis(drawn.y),
        "palette": looks.palette,
        "hatches": STRIPES,
        "scale": None if scale is None else {"colours": looks.scale, "ticks": ticks},
        "legend": looks.legend,
        "curves": [curve_look(*curve, on_numbers=scale is not None) for curve in curves],
        "bands": drawn.certain is not None,
        "progress": {"done": cells.is_done, "share": cells.share, "text": drawn.progress_text(cells)},
        "notes": drawn.notes(),
    }
    return pack(header, arrays)


class _Drawn:
    """Content of a map, arrays of shape (y, x).

    Attributes
    ----------
    panel : Panel
        Axes and cells.
    y : Axis
        The one that runs up.
    certain : Certain or None
        Guarantees for all bodies in the bands of friction, if any.
    known : bool array
        Whether each cell has a result.
    amplitude : array or None
        Of a machine, found for each cell [mm].
    numbers : array or None
        Numbers of the view, in the units outside; NaN if unknown.
    """

    def __init__(self, state: State, cells: Shown) -> None:
        grid = state.grid()
        values = cells.values
        length, title = grid.length, state.point.name or ""
        amplitude = None if grid.machine is None else np.broadcast_to(values["amplitude"], grid.shape)
        solved = SweepResult(
            grid.axes, grid.fixed, cells.cycle, cells.limits, length, None, title, amplitude=amplitude
        )
        view = choose_view(grid.axes, state.x.quantity.name, state.y.quantity.name, None, grid.fixed)
        assert view.y is not None
        self._state, self.y = state, view.y
        self._is_weighed = is_weighed(grid.machine, grid.axes, grid.fixed)
        self.panel = panels(solved, view)[0][0]
        self.cycle: dict[str, NDArray[Any]] = dict(self.panel.cycle)
        self._fields = Fields(self.panel)
        self._values, self._is_turned = values, next(iter(grid.axes)) == view.x.name
        self.amplitude = amplitude if amplitude is None or not self._is_turned else amplitude.T
        self.known, self._exact = (x.T if self._is_turned else x for x in (cells.known, cells.exact))
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
        """List the cells that are not exact yet: numbers, and regimes without known critical loads."""
        is_exact = self._state.view == "regime" and cells.limits is not None and not self._is_weighed
        return "" if is_exact else cells.text

    @property
    def _speed(self) -> Floats:
        """Mean speed, or with bands the guaranteed speed [mm/s]."""
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
        return np.where(self.covered, np.nan, np.nan if self.numbers is None else self.numbers)

    @property
    def covered(self) -> NDArray[np.bool_]:
        """Whether the colour of rest covers each cell, where bodies rest or do not fly."""
        regime = self.cycle["regime"]
        if self._state.view in _FLIGHT_ALONE:
            return np.asarray((regime >= 0) & (regime != Regime.HOPPING))
        rests = regime if self.certain is None else self.certain.highest
        return np.asarray((rests == Regime.NO_SLIP) & (self.numbers is not None))

    def marks(self) -> dict[str, NDArray[np.bool_]]:
        """Return which cells have which marks, by names of ``MARKS``."""
        cycle, status = self.cycle, self.cycle["status"]
        marks = {name: status == int(code) for code, name in HATCHES.items()}
        if self._state.target is not None:
            marks["misses"] = self._meets <= 0.0
        if self.certain is None or self._state.view in _FLIGHT_ALONE:
            marks |= {"preview": self.known & ~self._exact, "unknown": ~self.known}
        if self.certain is None:
            with np.errstate(invalid="ignore"):
                marks["backwards"] = cycle["mean_velocity"] < -_CERTAIN * cycle["mean_velocity_error"]
            marks["averaged"] = status == int(Status.AVERAGED)
            marks["coexists"] = cycle["coexists"] > 0
        elif self._state.view in _OF_SPEED:
            assert self.numbers is not None
            marks["unproved"] = np.isnan(self.numbers) & (self.certain.highest >= 0)
        return marks

    @cached_property
    def _meets(self) -> Floats:
        """Positive where bodies reach the wanted speed and do not hop."""
        fields, target = self._fields, self._state.target or 1.0
        if self.certain is not None:
            proved = np.isfinite(self._speed)
            if not proved.any():
                return np.full(proved.shape, -1.0)
            excess = fill_unknown(self._speed, proved) / target - 1.0  # up to the middle between cells
            return np.asarray(np.minimum(excess, np.where(proved, 0.5, -0.5)))
        # The speed jumps where back slip enters: continue the numbers of either side up to there.
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
            lines = zero_lines(fields, fields.reversal, hidden)
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
            of_all = {name: np.full((1, 1), mu) for name, mu in frictions.items()}
            limits = limits_of({**self._values, **of_all})
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

    def words(self) -> dict[str, str]:
        """Return the names in the legend that differ from those of other pictures."""
        words = {"rest": "no flight"} if self._state.view in _FLIGHT_ALONE else {}
        if self._state.target is not None:
            speed = f"{number_text(self._state.target)} mm/s"
            slow, unsure = f"slower than {speed}, or hops", f"not certain to reach {speed}"
            words["misses"] = slow if self.certain is None else unsure
        return words

    def scale(self, numbers: Floats) -> Scale:
        """Choose how numbers become colours."""
        seen = np.isfinite(self.seen)
        if self._state.view == "traverse":
            return time_scale(numbers[seen])
        regular = seen & (self.cycle["period_cycles"] == 1.0)
        calm = seen & (self.cycle["regime"] != Regime.HOPPING)
        reverses = self.certain is None and self._state.view == "speed" and self._fields.reverses
        return scale_of(numbers[seen], numbers[regular], numbers[calm], reverses=reverses)

    def _best(self, numbers: Floats) -> str:
        """Describe where the largest number is, or the shortest time."""
        is_time = self._state.view == "traverse"
        best = int(np.nanargmin(numbers) if is_time else np.nanargmax(numbers))
        row, column = np.unravel_index(best, numbers.shape)
        places = ((self.panel.x, column), (self.y, row))
        where = " and ".join(f"{axis.label} {value_text(axis.name, axis.values[i])}" for axis, i in places)
        unit = _UNITS[self._state.view]
        so_far = "" if self._exact.all() else " so far"
        what = "Shortest" if is_time else "Largest"
        what += " that is proved" if self.certain is not None and self._state.view in _OF_SPEED else ""
        return f"{what} here{so_far}: {number_text(numbers[row, column])} {unit}".rstrip() + f", at {where}."

    def notes(self) -> list[str]:
        """Return further notes."""
        notes = []
        if np.isfinite(self.seen).any():
            notes.append(self._best(self.seen))
        unproved = self.marks().get("unproved")
        if unproved is not None and unproved.any():
            notes.append("Not proved here: move the operating point there to search its speeds.")
        if self.certain is not None and is_outside(self._state):
            notes.append("The operating point's own friction lies outside of its bands.")
        if self.certain is not None:
            notes.append(
                "Flights depend on friction: they are computed with that of the operating point."
                if self._state.view in _FLIGHT_ALONE
                else "Colours are for all bodies in the bands, curves for those of least and most friction."
            )
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


def _axis(axis: Axis) -> dict[str, Any]:
    first, last = (float(end) for end in axis.values[[0, -1]])
    quantity = QUANTITIES[axis.name]
    unit, is_log = unit_of(quantity), axis.spacing == "log"
    return {
        "column": axis.column,
        "label": axis.label,
        "title": f"{axis.label} {symbol_of(quantity)}" + (f" [{unit}]" if unit else ""),
        "unit": unit,
        "from": first,
        "to": last,
        "log": is_log,
        "count": len(axis),
        "ticks": ticks_of(
            round_numbers(first, last, log=is_log), lambda number: _share(axis, np.asarray(number))
        ),
    }


def _scale_ticks(scale: Scale, seen: Floats) -> list[tuple[float, str]]:
    """Return the positions of numbers on a scale; empty if no number is visible."""
    if not np.isfinite(seen).any():
        return []
    low, high = float(scale.norm.vmin or 0.0), float(scale.norm.vmax or 1.0)
    numbers = round_numbers(low, high, most=6) if scale.ticks is None else scale.ticks
    return ticks_of((number for number in numbers if low <= number <= high), scale.norm)
