"""Smooth fields on a picture's grid, and the regions and curves that they bound.

A regime begins where the load G passes a critical one, so ``ln(G / G_critical)`` is a smooth function of the
drawn quantities whose zero line is the boundary, between the grid's points too. Amplitude and frequency enter
it through ln A + 2 ln f, or ln v + ln f, or ln a: contoured over their logarithms it is exact to rounding.
The amplitudes of an ellipse change its critical loads too, and may be 0: over them it is contoured without a
logarithm.
"""

from __future__ import annotations

from functools import cached_property
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from vibro.core.codes import Regime, Status
from vibro.plots import style
from vibro.plots.neighbours import dilate, erode, fill_unknown
from vibro.quantities import RATES, scene_fields
from vibro.results.steady import MINORITY
from vibro.scene import Scene

if TYPE_CHECKING:
    from collections.abc import Sequence

    from matplotlib.path import Path
    from numpy.typing import NDArray

    from vibro.axes import Axis
    from vibro.plots.view import Panel
    from vibro.reals import Floats


# Beyond one of these other curves another regime holds: the curve is no boundary there.
HIDDEN_BY: Final = {
    "forward_onset": ("back_slip", "hop"),
    "back_slip": ("hop",),
    "continuous_sliding": ("hop",),
    "hop": (),
}
# Where several have begun, the last of them holds.
BEGINS_AT: Final = {
    Regime.FORWARD_SLIP: "forward_onset",
    Regime.BACK_SLIP: "back_slip",
    Regime.HOPPING: "hop",
}

# Where the motion takes many cycles to repeat, or never does, numbers jump from point to point, and contours
# would be noise. No contour passes between two such points that are less than the first width apart, nor
# through the square of the second width around one.
_FEW_CYCLES: Final = 4.0
_SMOOTH_ACROSS: Final = 21
_SMOOTH_AROUND: Final = 5
# Irregular motion forms single points as well as patches. A hatch extends this far from each such point,
# which closes gaps and makes single points visible: cells without a hatch are exact.
_SEEN: Final = 0.01  # of the side of the map

# The load grows with these quantities of the drive only.
_LOADING: Final = ("amplitude", "stroke", *RATES, "frequency", "setting", "voltage")

_ROUNDING: Final = 1e-9  # of the largest speed: less counts as none
_SEEN_SHARE: Final = 0.02  # of a map: less of it does not decide on the colours
_CERTAIN: Final = 3.0  # standard errors below zero, from which a mean is negative

_EVEN_POINTS: Final = 200  # points along an axis, to find places for words
# Without a critical load G / G_critical is 0 or infinite. Contours need finite numbers: this and its inverse.
_LEAST_RATIO: Final = 1e-30


class Fields:
    """The drawn fields of one panel, arrays of shape (y, x).

    Parameters
    ----------
    panel : Panel
        Its cells.

    Attributes
    ----------
    x, y : array
        The grid, in the user's units; without a y axis that is a single zero.
    u, v : array
        The same in the coordinates in which the fields are nearly linear.
    """

    def __init__(self, panel: Panel) -> None:
        self.panel = panel
        self.x, self.u = panel.x.values, _straightened(panel.x, panel.x.values)
        self.y = self.v = np.zeros(1)
        if panel.y is not None:
            self.y, self.v = panel.y.values, _straightened(panel.y, panel.y.values)

    @cached_property
    def log_ratio(self) -> dict[str, Floats]:
        """ln(G / G_critical) of each critical curve: positive beyond it.

        For drives with harmonics these follow from the cycles; for back slip only the sign counts.
        """
        if not self.panel.critical:
            return self._ratios_of_cycles
        load = (self._scene.load if self.panel.load is None else self.panel.load) + self._zeros
        ratios = {}
        for name, critical in self.panel.critical.items():
            # Infeasible points have no critical load, but contours at the edge of their region need one. A
            # cover hides them up to the exact boundary.
            filled = fill_unknown(critical, ~np.isnan(critical))
            with np.errstate(divide="ignore", invalid="ignore"):  # a body that always slides needs no load
                ratio = np.clip(np.nan_to_num(load / filled, nan=np.inf), _LEAST_RATIO, 1.0 / _LEAST_RATIO)
            ratios[name] = np.log(ratio)
        return ratios

    @property
    def _ratios_of_cycles(self) -> dict[str, Floats]:
        cycle = self.panel.cycle
        filled = (fill_unknown(cycle[n], ~np.isnan(cycle[n])) for n in ("forward_ratio", "throw_number"))
        onset, hop = (np.log(np.clip(ratio, _LEAST_RATIO, 1.0 / _LEAST_RATIO)) for ratio in filled)
        # Back slip does not end where hopping begins: beyond, it is as next to it.
        in_contact = cycle["regime"] != Regime.HOPPING
        back = np.where(cycle["regime"] == Regime.BACK_SLIP, 0.5, -0.5)
        back = fill_unknown(back, in_contact) if in_contact.any() else back
        return dict(zip(HIDDEN_BY, (onset, back, self._zeros - 0.5, hop), strict=True))

    @cached_property
    def infeasible(self) -> Floats:
        """Positive where the combination is infeasible: mu_d > mu_s, or the masses of a machine strike."""
        excess = np.asarray(self._scene.kinetic_friction - self._scene.static_friction + self._zeros)
        cells = self.panel.cycle["status"] == Status.INFEASIBLE
        return np.where(cells & (excess <= 0.0), 0.5, excess)

    @cached_property
    def rest(self) -> Floats:
        """Positive where nothing moves."""
        curves = ("forward_onset", "back_slip", "hop")
        return np.asarray(-np.maximum.reduce([self.log_ratio[name] for name in curves]))

    @cached_property
    def velocity(self) -> Floats:
        """Mean conveying speed [m/s]; at rest that of a point nearby that moves, NaN if none does.

        The region at rest is covered up to its exact boundary, between points: numbers must reach that far.
        """
        return self.reaching("mean_velocity", self.panel.cycle["regime"] != Regime.NO_SLIP)

    def reaching(self, name: str, wanted: NDArray[np.bool_]) -> Floats:
        """Return a result of wanted points; elsewhere that of one nearby, NaN if none is wanted."""
        values = self.panel.cycle[name]
        known = np.isfinite(values) & wanted
        return fill_unknown(values, known) if known.any() else np.full(values.shape, np.nan)

    @cached_property
    def regular(self) -> Floats:
        """Positive where motion repeats after few cycles, with a margin; elsewhere lines would be noise."""
        answered = np.isfinite(self.panel.cycle["mean_velocity"])
        rough = answered & ~(self.panel.cycle["period_cycles"] <= _FEW_CYCLES)
        # And away from the gaps between such points.
        closed = erode(dilate(rough, _SMOOTH_ACROSS), _SMOOTH_ACROSS - _SMOOTH_AROUND + 1, beyond=True)
        return np.where(closed, -0.5, 0.5)

    @cached_property
    def reversal(self) -> Floats:
        """Positive where the mean speed is negative, relative to the largest; zero where it is rounding."""
        known = np.nan_to_num(self.velocity)
        largest = float(np.abs(known).max()) or 1.0
        return np.where(np.abs(known) <= _ROUNDING * largest, 0.0, -known / largest)

    @property
    def unknown(self) -> Floats:
        """Positive where no speed is known, for any reason."""
        return np.where(np.isnan(self.panel.cycle["mean_velocity"]), 0.5, -0.5)

    @cached_property
    def backwards(self) -> Floats:
        """Positive where bodies move backwards; where numbers are uncertain means, in patches and surely."""
        cycle = self.panel.cycle
        with np.errstate(invalid="ignore"):
            certain = cycle["mean_velocity"] < -_CERTAIN * cycle["mean_velocity_error"]
        patches = dilate(erode(certain, _SMOOTH_AROUND, beyond=True), _SMOOTH_AROUND)
        exact = cycle["period_cycles"] == 1.0
        return np.minimum(np.where(exact, self.reversal, np.where(patches, 0.5, -0.5)), -self.rest)

    @property
    def reverses(self) -> bool:
        """Whether bodies move backwards in a part of the picture that is seen."""
        return float(np.mean(self.backwards > 0.0)) > _SEEN_SHARE

    @cached_property
    def averaged(self) -> Floats:
        """Positive at irregular motion, whose numbers are means over many cycles, and close to it."""
        cells = self.panel.cycle["status"] == Status.AVERAGED
        margin = round(_SEEN * min(cells.shape))
        return np.where(erode(dilate(cells, 4 * margin + 1), 2 * margin + 1, beyond=True), 0.5, -0.5)

    @cached_property
    def coexists(self) -> Floats:
        """Positive where another motion exists: a cycle, or running away."""
        return np.where(self.panel.cycle["coexists"] > 0, 0.5, -0.5)

    @cached_property
    def minority(self) -> Floats:
        """Positive where fewer than half of all starts lead to the motion that is shown."""
        return np.where(self.panel.cycle["share"] < MINORITY, 0.5, -0.5)

    @property
    def others(self) -> tuple[str, Floats]:
        """What marks other motions, and where: those that most parts have, if their shares are known."""
        if np.isnan(self.panel.cycle["share"]).all():
            return style.COEXISTS_LABEL, self.coexists
        return style.MINORITY_LABEL, self.minority

    @cached_property
    def statuses(self) -> set[Status]:
        """Statuses that occur."""
        return {Status(int(code)) for code in np.unique(self.panel.cycle["status"])}

    def unanswered(self, status: Status) -> Floats:
        """Positive where points have a status without an answer.

        Zero on the exact boundary where that has a formula, else midway between points.
        """
        if status is Status.INFEASIBLE:
            return self.infeasible
        cells = self.panel.cycle["status"] == status
        hopping = self.panel.cycle["regime"] == Regime.HOPPING
        if status is Status.FLIGHT_NOT_MODELLED and np.array_equal(cells, hopping):
            return self.log_ratio["hop"]
        return np.where(cells, 0.5, -0.5)

    def on_paper(self, points: Floats) -> Floats:
        """Turn points (u, v) into points (x, y) in the user's units."""
        y = points[:, 1] if self.panel.y is None else _unstraightened(self.panel.y, points[:, 1])
        return np.column_stack([_unstraightened(self.panel.x, points[:, 0]), y])

    def evenly(self, field: Floats) -> Floats:
        """Return a field of a map on points that lie evenly on the paper, to find places for words."""
        panel = self.panel
        axes = ((panel.x.on_paper, self.u), ((panel.y or panel.x).on_paper, self.v))
        grid = [
            np.interp(np.linspace(places[0], places[-1], _EVEN_POINTS), places, own) for places, own in axes
        ]
        points = np.stack(np.meshgrid(*grid), axis=-1)
        return _sample(self, field, points.reshape(-1, 2)).reshape(points.shape[:2])

    def along(self, field: Floats, x: float) -> float:
        """Return the value of a field of one row at a place, in the user's units."""
        return float(np.interp(_straightened(self.panel.x, np.array([x])), self.u, field[0])[0])

    @property
    def _zeros(self) -> Floats:
        return np.zeros((len(self.y), len(self.x)))

    @cached_property
    def _scene(self) -> Scene:
        """The scenes of the grid's points."""
        values: dict[str, Any] = {**self.panel.values, self.panel.x.name: self.x[np.newaxis, :]}
        if self.panel.y is not None:
            values[self.panel.y.name] = self.y[:, np.newaxis]
        if (amplitude := self.panel.amplitude) is not None:  # hatches cover cells without one
            known = np.isfinite(amplitude)
            values["amplitude"] = fill_unknown(amplitude, known) if known.any() else np.ones(amplitude.shape)
        return Scene.allowing_infeasible(**scene_fields(values))


def hiding_fields(fields: Fields, curve: str) -> list[Floats]:
    """Return fields that are positive where a critical curve is no boundary, or there is no answer."""
    statuses = [Status.INFEASIBLE, Status.INDETERMINATE]
    if curve != "hop":
        statuses.append(Status.RUNAWAY)
    hiding = [fields.log_ratio[other] for other in HIDDEN_BY[curve]]
    return hiding + [fields.unanswered(status) for status in statuses if status in fields.statuses]


def _straightened(axis: Axis, values: Floats) -> Floats:
    return np.log(values) if axis.name in _LOADING else values


def _unstraightened(axis: Axis, values: Floats) -> Floats:
    return np.exp(values) if axis.name in _LOADING else values


def zero_region(fields: Fields, field: Floats) -> Path | None:
    """Area in which a field is positive, as a path in the user's units; None if it never is."""
    from contourpy import FillType, contour_generator
    from matplotlib.path import Path

    generator: Any = contour_generator(fields.u, fields.v, field, fill_type=FillType.OuterCode)
    points, codes = generator.filled(0.0, np.inf)
    if not points:
        return None
    return Path(fields.on_paper(np.concatenate(points)), np.concatenate(codes))


def zero_lines(fields: Fields, field: Floats, hidden_by: Sequence[Floats] = ()) -> list[Floats]:
    """Lines on which a field is zero, cut off where a hiding field is positive, in the user's units."""
    from contourpy import LineType, contour_generator

    lines: Any = contour_generator(fields.u, fields.v, field, line_type=LineType.Separate).lines(0.0)
    for hiding in hidden_by:
        lines = [part for line in lines for part in clip_line(line, _sample(fields, hiding, line))]
    return [fields.on_paper(line) for line in lines]


def zero_points(fields: Fields, field: Floats, hidden_by: Sequence[Floats] = ()) -> Floats:
    """Values of x, ascending, at which a field of one row is zero and no hiding field is positive."""
    row = field[0]
    left = np.flatnonzero((row[1:] > 0.0) != (row[:-1] > 0.0))
    share = row[left] / (row[left] - row[left + 1])
    u = fields.u[left] + share * (fields.u[left + 1] - fields.u[left])
    for hiding in hidden_by:
        u = u[np.interp(u, fields.u, hiding[0]) <= 0.0]
    return _unstraightened(fields.panel.x, u)


def clip_line(line: Floats, hidden: Floats) -> list[Floats]:
    """Keep the parts of a line where a quantity given at its points is not positive, up to its zeros."""
    inside = hidden <= 0.0
    cuts = np.flatnonzero(inside[1:] != inside[:-1])
    share = hidden[cuts] / (hidden[cuts] - hidden[cuts + 1])
    ends = line[cuts] + share[:, np.newaxis] * (line[cuts + 1] - line[cuts])
    points = np.insert(line, cuts + 1, ends, axis=0)
    kept = np.insert(inside, cuts + 1, True)
    runs = np.split(np.arange(len(points)), np.flatnonzero(kept[1:] != kept[:-1]) + 1)
    return [points[run] for run in runs if kept[run[0]] and len(run) > 1]


def _sample(fields: Fields, field: Floats, points: Floats) -> Floats:
    """Bilinear value of a field at points (u, v)."""
    column, s = _cell(fields.u, points[:, 0])
    row, t = _cell(fields.v, points[:, 1])
    below = (1 - s) * field[row, column] + s * field[row, column + 1]
    above = (1 - s) * field[row + 1, column] + s * field[row + 1, column + 1]
    return np.asarray((1 - t) * below + t * above)


def _cell(grid: Floats, values: Floats) -> tuple[NDArray[np.intp], Floats]:
    left = np.clip(np.searchsorted(grid, values) - 1, 0, len(grid) - 2)
    return left, (values - grid[left]) / (grid[left + 1] - grid[left])
