"""Steady cycles of whole grids of scenes, and how those in contact follow the load: the face of the core."""

from __future__ import annotations

from dataclasses import fields as fields_of
from functools import cache
from typing import TYPE_CHECKING, Any, Final, Literal, NamedTuple

import numpy as np

from vibro.core.codes import (
    IRREGULAR,
    LETTERS,
    SPELT_PATTERNS,
    Output,
    Pattern,
    Regime,
    Status,
    spelt_code,
)
from vibro.core.numbers import KNOWN
from vibro.drives import Ability
from vibro.errors import InputError, shown
from vibro.reals import shielded
from vibro.results.steady import RESULTS, SteadyCycle
from vibro.scene import Scene
from vibro.threads import Grid, Scratch, doors, over_cells

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from numpy.typing import ArrayLike, NDArray

    from vibro.reals import Floats

# ------------------------------------------------------------------------------
# Texts of patterns that have more letters than a code has room for.
#
# The solver marks them: marks are equal where two bodies have the same legs from the same phase on. One cell
# of each mark is followed once more to spell them, and its mark gives way to the code of the text, which is
# the same from whatever phase the legs are counted.

_ROOM: Final = 512  # [letter] for a first try; 16 harmonics alone have up to 64 in contact
_SPELT: Final = 16  # [cell] of a range; each takes up to some ms


def _spell_long(grid: Grid, codes: NDArray[np.int64], *, threads: int | None) -> dict[int, str]:
    """Replace marks of long patterns by their codes.

    Parameters
    ----------
    grid : Grid
        The cells.
    codes : int array
        Codes of their patterns, as the solver leaves them; changed in place.
    threads : int, optional
        As for ``vibro.solve``.

    Returns
    -------
    dict of int to str
        Texts of long patterns by their codes.
    """
    marked = (codes < IRREGULAR).nonzero()[0]
    if not marked.size:
        return {}
    _, first, which = np.unique(codes[marked], return_index=True, return_inverse=True)
    cells, texts, scratch = marked[first].tolist(), [""] * first.size, Scratch()

    def spell(begin: int, end: int) -> None:
        for i in range(begin, end):
            texts[i] = "".join(LETTERS[mode] for mode in _legs(grid, cells[i], scratch))

    over_cells(spell, len(cells), _SPELT, threads, cost=grid.cost)
    found = {text: spelt_code(text) for text in texts}
    codes[marked] = np.array([found[text] for text in texts])[which]
    return {code: text for text, code in found.items() if code < IRREGULAR}


def _legs(grid: Grid, cell: int, scratch: Scratch) -> bytes:
    """Follow the steady cycle of a cell once more; return the ``Mode`` of every leg."""
    legs, number = np.empty(0, np.int8), _ROOM
    while number > legs.size:
        legs = np.empty(number, np.int8)
        number = doors().write_letters(
            grid.scenes, grid.place(), cell, scratch.flights, scratch.hops, legs, legs.size
        )
    return legs[:number].tobytes()


# Cells of a range, of drives of one harmonic: many enough that Python takes no time between them, few enough
# that threads share the work evenly.
_IN_CONTACT: Final = 8192
_HOPPING: Final = 32
_SURVEYED: Final = 2

_MOST_STARTS: Final = 4096  # few seconds
#: Buffers of ``core.attractors.Attractors``: of numbers, and of codes.
NUMBERS: Final = 10
CODES: Final = 3

_MANY_FLIGHTS: Final = 10_000  # [cells] above which plain Python takes minutes

# What is zero in contact is zero from the start.
_MADE: Final = tuple((r.name, np.zeros if r.in_contact == 0.0 else np.empty, r.dtype) for r in RESULTS)
_OF_STARTS: Final = tuple(r.name for r in RESULTS if r.of_starts)


@shielded
def solve(
    scene: Scene,
    *,
    output: Literal["exact", "regimes"] | Output = "exact",
    flight: bool = True,
    starts: int | None = None,
    threads: int | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> SteadyCycle:
    """Return the steady cycle in which a body that starts from rest settles, for every scene.

    Parameters
    ----------
    scene : Scene
        Operating points of any shape.
    output : {"exact", "regimes"}, optional
        With "regimes" only regimes, ratios and statuses are computed: cells that slip have no pattern and no
        model, their numbers are NaN, and ``BOUNDARY`` between patterns of one regime is not detected. It
        implies ``flight=False``.
    flight : bool, optional
        Whether to compute flights and impacts of hopping scenes. If False, and for throw numbers above 1e6,
        hopping scenes have no numbers and the status ``FLIGHT_NOT_MODELLED``.
    starts : int, optional
        Number of starts, 1 to 4096, of which ``SteadyCycle.share`` and ``mean_velocity_over_starts`` are
        found, and of cells that hop ``coexists``, as by ``vibro.attractors``; a start of a cell that hops
        takes about 0.4 ms. Without, these are unknown, but in contact ``coexists`` is known.
    threads : int, optional
        Number of threads, at least 1; by default one per core. Results do not depend on it. Without the
        compiled solver one thread is used.
    progress : callable, optional
        Function of the number of cells done and the number of all cells, called now and then in the calling
        thread. Hopping cells count twice, because they take longest.

    Returns
    -------
    SteadyCycle
        Arrays of the scene's shape; NumPy scalars for a single scene.

    Raises
    ------
    InputError
        If an argument is not one of those above.

    Notes
    -----
    Exact up to rounding, see docs/theory: on the reference tables the error of the displacement d is at
    most ``16 eps (condition * abs(d) + S)``, where S = A if the body slides both ways and S = abs(d)
    otherwise (tests/test_reference.py). The result of a scene does not depend on the other scenes of the
    array. Ctrl-C stops the computation within a fraction of a second.

    Examples
    --------
    >>> import math, vibro
    >>> cycle = vibro.solve(vibro.Scene(amplitude=1e-3, frequency=15, drive_angle=math.radians(20),
    ...                                 static_friction=0.74, kinetic_friction=0.57))
    >>> print(f"{cycle.mean_velocity:.9f} m/s, {cycle.pattern}")
    0.016263456 m/s, F_
    """
    classes_alone = output_of(output) is Output.REGIMES
    check_switch("flight", flight)
    number = None if starts is None else checked_starts(starts)
    _check_threads(threads)
    fields = scene.arrays()
    grid, solver = Grid(fields), doors()
    rows: dict[str, NDArray[Any]] = {name: make(grid.size, dtype) for name, make, dtype in _MADE}
    for name in _OF_STARTS:
        rows[name].fill(np.nan)
    answers = tuple(map(solver.row, rows.values()))
    grid.hold(*rows.values())

    def contact(begin: int, end: int) -> None:
        solver.solve_contact(grid.scenes, grid.place(), answers, begin, end, classes_alone)

    over_cells(contact, grid.size, _IN_CONTACT, threads, progress, cost=grid.cost)
    if flight and not classes_alone:
        # NumPy takes 2 us to compare with an enum, a tenth of it with an int
        hopping = (rows["status"] == int(Status.FLIGHT_NOT_MODELLED)).nonzero()[0]
        if hopping.size:
            _hop(grid, answers, hopping, threads, progress)
        if number is not None:
            _share(grid, rows, answers, number, threads)
    texts = _spell_long(grid, rows["pattern_code"], threads=threads)
    if not grid.shape:
        return SteadyCycle(**{name: row[0] for name, row in rows.items()}, long_patterns=texts)
    return SteadyCycle(**{name: row.reshape(grid.shape) for name, row in rows.items()}, long_patterns=texts)


def _hop(
    grid: Grid,
    answers: tuple[Any, ...],
    cells: NDArray[np.int64],
    threads: int | None,
    progress: Callable[[int, int], None] | None,
) -> None:
    """Follow the bodies of some cells that hop."""
    if not doors().compiled and cells.size > _MANY_FLIGHTS:
        _say_that_it_takes_long()
    scratch = Scratch()

    def follow(begin: int, end: int) -> None:
        room = scratch.flights, scratch.hops
        doors().solve_hops(grid.scenes, grid.place(), answers, cells, *room, begin, end)

    over_cells(follow, cells.size, _HOPPING, threads, progress, cost=grid.cost)


def _share(
    grid: Grid, rows: Mapping[str, NDArray[Any]], answers: tuple[Any, ...], starts: int, threads: int | None
) -> None:
    """Follow bodies from many starts in every cell that may have several motions."""
    share, mean = rows["share"], rows["mean_velocity_over_starts"]
    answered = ~np.isnan(rows["mean_velocity"])
    alone = answered & (rows["regime"] != int(Regime.HOPPING)) & (rows["coexists"] == 0)
    share[alone], mean[alone] = 1.0, rows["mean_velocity"][alone]
    cells, scratch, solver = (answered & ~alone).nonzero()[0], Scratch(), doors()
    room = starts + KNOWN

    def follow(begin: int, end: int) -> None:
        numbers, codes = np.empty((NUMBERS, room)), np.empty((CODES, room), np.int64)
        motions = *solver.rows(numbers), *solver.rows(codes)
        solver.share_starts(
            grid.scenes, grid.place(), answers, cells, starts, scratch.flights, scratch.hops, motions, room,
            begin, end,
        )  # fmt: skip

    over_cells(follow, cells.size, _SURVEYED, threads, cost=grid.cost)


@cache
def _say_that_it_takes_long() -> None:
    """Warn, once, that the solver is not compiled and that this takes minutes."""
    import logging

    logging.getLogger("vibro").warning(
        "hint: the solver is not compiled, so that many flights take minutes; install vibro again where"
        " there is a C compiler, or where pip finds the package ziglang"
    )


def output_of(output: str) -> Output:
    """Return the output that a text names; raise InputError if there is no such output."""
    try:
        return Output(output)
    except ValueError:
        raise InputError(f"output = {shown(output)}: must be one of {', '.join(Output)}") from None


def check_switch(name: str, value: bool) -> None:
    """Raise InputError unless a switch is a bool: the text "off" would count as on."""
    if not isinstance(value, bool | np.bool_):
        raise InputError(f"{name} = {shown(value)}: must be True or False")


def checked_starts(starts: Any) -> int:
    """Return a number of starts; raise InputError unless it is a whole number in range."""
    whole = isinstance(starts, int | np.integer) and not isinstance(starts, bool)
    if not (whole and 1 <= starts <= _MOST_STARTS):
        raise InputError(f"starts = {shown(starts)}: must be a whole number from 1 to {_MOST_STARTS}")
    return int(starts)


def _check_threads(threads: int | None) -> None:
    whole = isinstance(threads, int | np.integer) and not isinstance(threads, bool)
    if threads is not None and not (whole and threads >= 1):
        raise InputError(f"threads = {shown(threads)}: must be a whole number of at least 1, or None")


# ------------------------------------------------------------------------------
# Steady contact cycles in detail: how the displacement follows the load, and the phases of the slides.
#
# There are closed forms for drives of one harmonic; of others the displacement is differenced.

#: [A] Where slides to and fro nearly cancel, their difference has lost half of its digits, and more below.
LEAST_DIFFERENCE: Final = 2.0**-26

_STEP: Final = 1e-4  # [1] of the logarithm of the scale
_AGREES: Final = 1e-3  # [1] of both differences, relative: the better one is closer by the square of that


class Slides(NamedTuple):
    """Slides of steady contact cycles, of shape (2, *shape): in the order of the pattern.

    Attributes
    ----------
    way : array
        +1 forward, -1 back, 0 where there is no slide.
    zero : array
        Phase of the trough's motion along itself at which the load of the slide is zero and rises [rad].
    begin, end : array
        Phases of the trough's motion along itself; the first slide begins in [0, 2 pi) [rad].
    load, resistance : array
        C over m A w^2 and k of Eq. (3) [1].
    displacement : array
        Of the body during the slide, with its sign [A].
    """

    way: Floats
    zero: Floats
    begin: Floats
    end: Floats
    load: Floats
    resistance: Floats
    displacement: Floats


def _one_harmonic(scene: Scene) -> Grid:
    fields = scene.arrays()
    fields.require(Ability.ONE_HARMONIC, hint="vibro.simulate follows the slides of any drive")
    return Grid(fields)


def load_slope(scene: Scene, pattern: ArrayLike) -> Floats:
    """Differentiate the displacement of steady contact cycles with respect to ln G.

    Parameters
    ----------
    scene : Scene
        Operating points of any shape; of an ellipse the amplitudes keep their ratio.
    pattern : int array_like
        ``SteadyCycle.pattern_code`` of each, of the scene's shape.

    Returns
    -------
    array
        Slope over A; 0 at rest, NaN without a steady cycle in contact [1].

    Raises
    ------
    InputError
        If the drive is neither a line nor an ellipse: it lacks ``Ability.ONE_HARMONIC``.

    Notes
    -----
    Eqs. (45)-(50). Just above an onset it grows without bound, like 1 over the root of the distance.
    """
    grid, patterns = _one_harmonic(scene), np.ascontiguousarray(pattern, np.int64)
    found = np.empty(grid.size)

    def find(begin: int, end: int) -> None:
        row = doors().row
        doors().load_slopes(grid.scenes, grid.place(), row(patterns), row(found), begin, end)

    over_cells(find, grid.size, _IN_CONTACT, None)
    return np.asarray(found.reshape(grid.shape))


def scale_slope(scene: Scene, cycle: SteadyCycle) -> Floats:
    """Difference the displacement of steady contact cycles with respect to the logarithm of the motion.

    Parameters
    ----------
    scene : Scene
        Operating points of any shape, with a motion.
    cycle : SteadyCycle
        Their solution.

    Returns
    -------
    array
        Per cent of displacement that 1 % of motion_scale brings; NaN at rest, for bodies that hop, and
        beside a change of the pattern or of the way [1].

    Notes
    -----
    A central difference of fourth order with steps of 1e-4. It is kept where the one of second order agrees
    within 1e-3, so that its own error is of the order of 1e-6 at most; rounding is 1e-11
    (tests/test_steady.py).
    """
    given = {f.name: getattr(scene, f.name) for f in fields_of(scene)}
    given = {name: value for name, value in given.items() if value is not None}
    logarithms = []
    known = (cycle.regime != Regime.HOPPING) & (cycle.status == Status.OK)
    for steps in (-2, -1, 1, 2):
        scale = scene.motion_scale * np.exp(steps * _STEP)
        beside = solve(Scene.computed(**{**given, "motion_scale": scale}), flight=False)
        known = known & (beside.pattern_code == cycle.pattern_code) & (beside.status == Status.OK)
        with np.errstate(divide="ignore", invalid="ignore"):
            ratio = beside.displacement_per_cycle / cycle.displacement_per_cycle
            logarithms.append(np.log(ratio))
    before, less, more, after = logarithms
    with np.errstate(invalid="ignore"):
        coarse = (after - before) / (4.0 * _STEP)
        fine = (4.0 * (more - less) / (2.0 * _STEP) - coarse) / 3.0
        known = known & (np.abs(fine - coarse) <= _AGREES * (1.0 + np.abs(fine)))
    return np.where(known, fine, np.nan)


def speed_exponent(scene: Scene, cycle: SteadyCycle) -> Floats:
    """Return the exponent of the speed over the amplitude, Eq. (51), of contact cycles.

    Beyond one harmonic it is a difference of speeds, ``scale_slope``.

    Parameters
    ----------
    scene : Scene
        Operating points of any shape.
    cycle : SteadyCycle
        Their solution.

    Returns
    -------
    array
        Per cent of speed that 1 % of amplitude brings, within the pattern; NaN at thresholds, for bodies
        that hop, and where the speed is 0 [1].
    """
    pattern = cycle.pattern_code
    displacement = cycle.displacement_per_cycle / scene.scale
    one_way = (pattern == Pattern.F_) | (pattern == Pattern.B_)
    conveyed = np.abs(displacement) > np.where(one_way, 0.0, LEAST_DIFFERENCE)
    if not scene.arrays().can(Ability.ONE_HARMONIC):
        return np.where(conveyed, scale_slope(scene, cycle), np.nan)
    slides = (pattern > Pattern.R) & (pattern < SPELT_PATTERNS)
    known = slides & conveyed & (cycle.status == Status.OK)
    slope = load_slope(scene, np.where(known, pattern, Pattern.NONE))
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.where(known, 1.0 + slope / displacement, np.nan)


def slides_of(scene: Scene, pattern: ArrayLike) -> Slides:
    """Solve the slides of steady contact cycles.

    Parameters
    ----------
    scene : Scene
        Operating points of any shape.
    pattern : int array_like
        ``SteadyCycle.pattern_code`` of each, of the scene's shape.

    Raises
    ------
    InputError
        If the drive is neither a line nor an ellipse: it lacks ``Ability.ONE_HARMONIC``.
    """
    grid, patterns = _one_harmonic(scene), np.ascontiguousarray(pattern, np.int64)
    found = np.empty((len(Slides._fields), 2 * grid.size))

    def find(begin: int, end: int) -> None:
        buffers = doors().row(patterns), doors().rows(found)
        doors().cycle_legs(grid.scenes, grid.place(), *buffers, begin, end, grid.size)

    over_cells(find, grid.size, _IN_CONTACT, None)
    return Slides(*(row.reshape(2, *grid.shape) for row in found))
