"""Solved sweeps: a block of cells as tables need it, and a grid as pictures need it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final, NamedTuple

import numpy as np

from vibro.core.codes import Regime, Status
from vibro.quantities import QUANTITIES, RATES, SIZES, scene_fields
from vibro.scene import Scene
from vibro.units import SPEED

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence

    from numpy.typing import NDArray

    from vibro.axes import Axis
    from vibro.limits import CriticalLoads
    from vibro.reals import Floats
    from vibro.results.steady import SteadyCycle


# The load falls with none of these; critical loads depend on none.
_LAST_MOVES_FIRST: Final = ("amplitude", "stroke", *RATES, "frequency", "restitution")
_SIGMAS: Final = 3.0  # standard errors by which a mean may be off
_WAYS: Final = {"fastest": 1.0, "fastest_backwards": -1.0}


@dataclass(frozen=True)
class Column:
    """One column of every table; it pickles, so that other processes can write it.

    Attributes
    ----------
    name : str
        Header, with the unit.
    unit : str
        Unit of the numbers; empty for pure numbers, flags and texts.
    values : callable
        From a ``Block`` to an array that broadcasts to its shape: floats, NaN or inf where there is no
        number; or integer codes.
    texts : tuple of str, optional
        What the codes mean, the last one standing for -1; None for a column of numbers, or with ``decode``.
    is_flag : bool
        Whether the codes are 0, 1 and, for unknown, -1: written as numbers where the format allows.
    decode : callable, optional
        From an array of codes and ``SteadyCycle.long_patterns`` to an array of texts, where there are too
        many to list.
    meaning : str, optional
        Description of the column, in plain text.
    """

    name: str
    unit: str
    values: Callable[[Block], NDArray[Any]]
    texts: tuple[str, ...] | None = None
    is_flag: bool = False
    decode: Callable[[NDArray[Any], Mapping[int, str]], NDArray[np.object_]] | None = None
    meaning: str = ""

    @property
    def is_number(self) -> bool:
        """Whether it holds numbers, not codes."""
        return self.texts is None and self.decode is None

    @property
    def codes(self) -> dict[str, int]:
        """The codes of ``texts``: their places, and -1 of an empty last one."""
        texts = self.texts or ()
        return {text: i if text or i + 1 < len(texts) else -1 for i, text in enumerate(texts)}


@dataclass(frozen=True, eq=False)
class Block:
    """Solved cells of a part of a grid, for tables.

    Attributes
    ----------
    values : mapping of str to array
        Every quantity by name, in the user's units; broadcastable to the cycle's shape.
    cycle : SteadyCycle
        Results of the block's cells.
    length : float or None
        Length of the trough [mm].
    arrival : array or None
        Time from rest to the arrival; inf if the body never arrives, NaN if unknown; None if not requested
        [s].
    in_stroke : bool
        Whether texts tell the stroke of a drive along a line, as it was given, in place of its amplitude.
    """

    values: Mapping[str, Floats]
    cycle: SteadyCycle
    length: float | None
    arrival: Floats | None = None
    in_stroke: bool = False

    @property
    def shape(self) -> tuple[int, ...]:
        """Shape of the block's cells."""
        return self.cycle.status.shape


class Peak(NamedTuple):
    """The cell that is conveyed fastest, forwards or backwards.

    Attributes
    ----------
    speed, error : float
        Mean conveying speed, and its standard error; 0 where it is exact [mm/s].
    values : dict of str to float
        Quantities of the cell by name, in the user's units.
    """

    speed: float
    error: float
    values: dict[str, float]


@dataclass(frozen=True, eq=False)
class SweepResult:
    """A solved grid, as pictures need it.

    Attributes
    ----------
    axes : mapping of str to Axis
        The axes that vary, in the order of ``quantities.SWEPT``; values in the user's units. They are the
        dimensions of ``cycle``, in this order. Where strokes were given, ``stroke`` is in the place of
        ``amplitude``, here and below.
    fixed : mapping of str to float
        Every other quantity of the scene, by name, in the user's units, with gravity. It has
        kinetic_friction or, where that was given instead, friction_ratio.
    cycle : SteadyCycle
        Arrays of the grid's shape.
    limits : CriticalLoads or None
        Critical loads G of the grid's angles and frictions, and of the shapes of its ellipses: arrays of the
        grid's shape, but of length 1 along amplitude, frequency and restitution. None if drives have
        harmonics.
    length : float or None
        Length of the trough [mm].
    operating_point : mapping of str to float, or None
        Values of the axes in the scene file, in the user's units; None unless it gives all of them.
    title : str
        Description of the sweep, in one line.
    amplitude : array, optional
        Amplitudes that follow from a machine, broadcastable to the grid's shape; NaN where there is none
        [mm].
    peaks : mapping of str to Peak, optional
        The fastest of the table that the picture belongs to, as ``peaks`` names them.
    """

    axes: Mapping[str, Axis]
    fixed: Mapping[str, float]
    cycle: SteadyCycle
    limits: CriticalLoads | None
    length: float | None
    operating_point: Mapping[str, float] | None
    title: str
    amplitude: Floats | None = None
    peaks: Mapping[str, Peak] | None = None

    @property
    def fastest(self) -> Mapping[str, Peak]:
        """The fastest cells, of the table if there is one, else of these."""
        if self.peaks is not None:
            return self.peaks
        values = cell_values(self.axes, self.fixed)
        return peaks(self.cycle.mean_velocity, self.cycle.mean_velocity_error, values)

    @property
    def shape(self) -> tuple[int, ...]:
        """Number of values of each axis."""
        return tuple(len(axis) for axis in self.axes.values())

    @property
    def hops(self) -> bool:
        """Whether a body hops in any cell."""
        return bool(np.any(self.cycle.regime == Regime.HOPPING))

    @property
    def rest_text(self) -> str:
        """Where motion begins, if every body rests; else empty."""
        rests = np.all(at_rest(self.cycle))
        return where_motion_begins(self.axes, self.fixed, self.limits) if rests else ""


def cell_values(
    axes: Mapping[str, Axis], fixed: Mapping[str, float], box: Sequence[slice] | None = None
) -> dict[str, Floats]:
    """Return every quantity of a box of cells by name, one slice for each axis; of all without a box."""
    box = (slice(None),) * len(axes) if box is None else box
    values = {name: np.full((1,) * len(axes), value) for name, value in fixed.items()}
    for i, (axis, part) in enumerate(zip(axes.values(), box, strict=True)):
        values[axis.name] = axis.values[part].reshape([-1 if j == i else 1 for j in range(len(axes))])
    return values


def peaks(speed: Floats, error: Floats, values: Mapping[str, Any]) -> dict[str, Peak]:
    """Find the cells that are conveyed fastest.

    Parameters
    ----------
    speed, error : float array
        Mean speed of each cell and its standard error; NaN where unknown [m/s].
    values : mapping of str to float or array
        Quantities by name, in the user's units; broadcastable to the shape of the speeds.

    Returns
    -------
    dict of str to Peak
        ``fastest`` and ``fastest_backwards``, as far as any cell is known to move that way; of equally fast
        cells the first.
    """
    error = np.nan_to_num(error)
    known = np.where(np.isfinite(speed) & (np.abs(speed) > _SIGMAS * error), speed, 0.0)
    of_cells = {name: np.broadcast_to(values[name], known.shape) for name in QUANTITIES if name in values}
    found = {}
    for name, way in _WAYS.items():
        place = np.unravel_index(np.argmax(way * known), known.shape)
        if way * known[place] > 0.0:
            here = {of: float(cells[place]) for of, cells in of_cells.items()}
            found[name] = Peak(SPEED.from_si(float(known[place])), SPEED.from_si(float(error[place])), here)
    return found


def at_rest(cycle: SteadyCycle) -> NDArray[np.bool_]:
    """Whether each body rests, or the combination is infeasible."""
    return np.asarray((cycle.regime == Regime.NO_SLIP) | (cycle.status == Status.INFEASIBLE))


def where_motion_begins(
    axes: Mapping[str, Axis], fixed: Mapping[str, float], limits: CriticalLoads | None
) -> str:
    """Say at which amplitude and frequency the first body of a sweep begins to move.

    Parameters
    ----------
    axes, fixed, limits
        As in ``SweepResult``.

    Returns
    -------
    str
        The amplitude at the frequency of the body that is nearest to moving, and the frequency at its
        amplitude, or the acceleration; of an ellipse the factor of both amplitudes, which grow together; of a
        drive with harmonics neither.
    """
    if limits is None or {*axes, *fixed}.isdisjoint(SIZES):  # amplitudes that follow from a machine
        return "at rest everywhere"
    # A sweep may have more cells than fit in memory; the last ones along these axes are nearest to moving.
    box = [slice(-1, None) if name in _LAST_MOVES_FIRST else slice(None) for name in axes]
    values = cell_values(axes, fixed, box)
    load = Scene.allowing_infeasible(**scene_fields(values)).load
    with np.errstate(divide="ignore", invalid="ignore"):  # a threshold or a load of 0
        ratio = np.fmax.reduce(
            [load / limit for limit in (limits.forward_onset, limits.back_onset, limits.hop)]
        )
    nearest = np.unravel_index(np.argmax(np.nan_to_num(ratio)), ratio.shape)
    passed = float(ratio[nearest])
    if not passed > 0.0:
        return "at rest everywhere"
    here = {name: float(np.broadcast_to(value, ratio.shape)[nearest]) for name, value in values.items()}
    name, *others = (name for name in SIZES if name in here)
    power = 2 - RATES.get(name, 0)  # of the frequency, with which the load grows
    frequency, fast = here["frequency"], here["frequency"] * passed ** (-1.0 / power if power else 0.0)
    begins = "at rest everywhere: motion begins at"
    if others:
        return f"{begins} {fast:.4g} Hz, or at {frequency:.4g} Hz with {1.0 / passed:.4g} x both amplitudes"
    given, unit = here[name], QUANTITIES[name].unit + " stroke" * (name == "stroke")
    if not power:
        return f"{begins} {given / passed:.4g} {unit}"
    return (
        f"{begins} {given / passed:.4g} {unit} with {frequency:.4g} Hz,"
        f" or at {fast:.4g} Hz with {given:.4g} {unit}"
    )
