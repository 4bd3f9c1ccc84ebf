"""Steady cycles of whole grids of scenes: the public face of the core."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, Final, Literal

import numpy as np

from vibro.core.codes import SPELT_PATTERNS, Level, Model, Status
from vibro.core.contact.solver import SteadyState, steady_state
from vibro.core.flight.averages import AVERAGES
from vibro.core.flight.coexistence import coexisting
from vibro.core.flight.cycles import MOST_THROW, HoppingCycles, cycles, short_cycles
from vibro.core.groups import each
from vibro.core.harmonic.solver import harmonic_state
from vibro.errors import InputError, shown
from vibro.harmonics import HarmonicFields
from vibro.parallel import BLOCK, grid_blocks, in_parallel, within
from vibro.results.steady import RESULTS, SteadyCycle

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import NDArray

    from vibro.core.groups import Loads
    from vibro.scene import Fields, Scene

    Floats = NDArray[np.float64]
    Hopping = Callable[[Loads, Floats], HoppingCycles]

__all__ = ["check_switch", "level_of", "solve"]

# How hopping cells are solved, the cheapest first, and how many at once: many enough to share the NumPy calls
# of a step. What one leaves unresolved is gathered from all blocks for the next.
_HOPPING: Final = ((short_cycles, 32_768), (cycles, 32_768), *AVERAGES)

_LOOKED_AT: Final = 256  # hopping cells at once in which other motions are looked for

# What the core calls its results, which are over A and A w, and how ``SteadyCycle`` calls them.
_NAMES: Final = {
    "pattern": "pattern_code",
    "model": "model_code",
    "displacement": "displacement_per_cycle",
    "peak": "peak_velocity",
    "period": "period_cycles",
    "impact": "impact_velocity",
}
_OF_STATE: Final = tuple(_NAMES.get(name, name) for name in SteadyState._fields)
_SAME_IN_CONTACT: Final = tuple(r.name for r in RESULTS if r.in_contact is not None)
# What is zero in contact is zero from the start, which costs nothing.
_MADE: Final = tuple((r.name, np.zeros if r.in_contact == 0.0 else np.empty, r.dtype) for r in RESULTS)


def solve(
    scene: Scene,
    *,
    accuracy: Literal["exact", "regimes"] | Level = "exact",
    flight: bool = True,
    coexistence: bool = False,
    threads: int | None = None,
) -> SteadyCycle:
    """Steady cycle that a body at rest settles into, for every scene.

    Parameters
    ----------
    scene : Scene
        Operating points of any shape.
    accuracy : {"exact", "regimes"}, optional
        With "regimes" only the classes, ratios and statuses are found: a slipping cell has neither
        pattern nor model, NaN for its numbers, and no ``BOUNDARY`` between patterns of one class. It
        stands for ``flight=False``.
    flight : bool, optional
        Whether hopping scenes are followed through flight and impact; else, and above a throw number of
        1e6, they have no numbers and the status ``FLIGHT_NOT_MODELLED``.
    coexistence : bool, optional
        Whether to look for other motions of hopping scenes, to which a disturbed body could settle
        (``SteadyCycle.coexists``); it takes several ms a cell. In contact they are known without a search.
    threads : int, optional
        How many threads share the work, at least 1; without, one a core. The numbers are the same bit for
        bit, however many there are.

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
    Exact up to rounding, see docs/theory.md: on the reference tables the displacement is within
    16 eps (condition * abs(d) + S), where S = A if the body slides both ways and abs(d) otherwise
    (tests/test_reference.py). Cells are solved in blocks that stay in a core's cache.

    Examples
    --------
    >>> import math, vibro
    >>> cycle = vibro.solve(vibro.Scene(amplitude=1e-3, frequency=15, drive_angle=math.radians(20),
    ...                                 static_friction=0.74, kinetic_friction=0.57))
    >>> print(f"{cycle.mean_velocity:.9f} m/s, {cycle.pattern}")
    0.016263456 m/s, F_
    """
    classes_alone = level_of(accuracy) is Level.REGIMES
    check_switch("flight", flight)
    check_switch("coexistence", coexistence)
    _check_threads(threads)
    shape = scene.shape
    grid = shape or (1,)
    ones = (1,) * len(grid)
    inputs = each(scene.arrays(), lambda a: a.reshape(ones[a.ndim :] + a.shape))
    blocks = list(grid_blocks(grid, BLOCK))
    out = _unsolved(grid)

    def contact(block: tuple[slice, ...]) -> None:
        part = inputs
        if len(blocks) > 1:
            part = each(inputs, lambda a: a[within(block, a.shape)])
        _solve_block({name: array[block] for name, array in vars(out).items()}, part, classes_alone)

    in_parallel(contact, blocks, threads)
    if flight and not classes_alone and not isinstance(inputs, HarmonicFields):
        # Beyond the largest throw number the phase of a landing is lost to rounding. NumPy takes 2 us to
        # compare with an enum, a tenth of it with an int.
        followed = (out.status == int(Status.FLIGHT_NOT_MODELLED)) & (out.throw_number <= MOST_THROW)
        hopping = left = followed.reshape(-1).nonzero()[0]
        for model, size in _HOPPING:

            def hops(cells: NDArray[np.intp], model: Hopping = model) -> None:
                where = np.unravel_index(cells, grid)
                _solve_hops(out, cells, each(inputs, lambda a: _at(where, a)), model)

            in_parallel(hops, [left[i : i + size] for i in range(0, left.size, size)], threads)
            left = left[out.status.reshape(-1)[left] == int(Status.UNRESOLVED)]
        if coexistence:
            answered = ~np.isnan(out.mean_velocity.reshape(-1)[hopping])
            known = hopping[answered & (out.coexists.reshape(-1)[hopping] < 0)]

            def look(cells: NDArray[np.intp]) -> None:
                where = np.unravel_index(cells, grid)
                _look_for_others(out, cells, each(inputs, lambda a: _at(where, a)))

            in_parallel(look, [known[i : i + _LOOKED_AT] for i in range(0, known.size, _LOOKED_AT)], threads)
    return out if shape else SteadyCycle(**{name: array[0] for name, array in vars(out).items()})


def level_of(accuracy: str) -> Level:
    """Read how much is wanted of every cell."""
    try:
        return Level(accuracy)
    except ValueError:
        raise InputError(f"accuracy = {shown(accuracy)}: must be one of {', '.join(Level)}") from None


def check_switch(name: str, value: bool) -> None:
    """Refuse what only looks like a switch: the text "off" would count as on."""
    if not isinstance(value, bool | np.bool_):
        raise InputError(f"{name} = {shown(value)}: must be True or False")


def _check_threads(threads: int | None) -> None:
    whole = isinstance(threads, int | np.integer) and not isinstance(threads, bool)
    if threads is not None and not (whole and threads >= 1):
        raise InputError(f"threads = {shown(threads)}: must be a whole number of at least 1, or None")


def _unsolved(shape: tuple[int, ...]) -> SteadyCycle:
    """Make arrays to be filled."""
    return SteadyCycle(**{name: make(shape, dtype) for name, make, dtype in _MADE})


def _solve_block(part: dict[str, NDArray[Any]], inputs: Fields, classes_alone: bool) -> None:
    """Solve one block in place, given as arrays of ``SteadyCycle``, and scale it to SI."""
    shape = part["status"].shape
    # views: blocks are contiguous
    flat = part if len(shape) == 1 else {name: array.reshape(-1) for name, array in part.items()}
    state = SteadyState(*(flat[name] for name in _OF_STATE))
    if isinstance(inputs, HarmonicFields):
        harmonics = each(inputs.harmonic_loads(), lambda group: _flat(group, shape))
        harmonic_state(harmonics, state, classes_alone=classes_alone)
    else:
        loads = each(inputs.loads(), lambda group: _flat(group, shape))
        steady_state(loads, state, classes_alone=classes_alone)
    with np.errstate(over="ignore"):  # inf where the result is beyond the range of doubles
        scale = inputs.scale
        part["displacement_per_cycle"] *= scale
        np.multiply(part["displacement_per_cycle"], inputs.frequency, out=part["mean_velocity"])
        part["peak_velocity"] *= 2.0 * np.pi * inputs.frequency * scale
    flat["period_cycles"].fill(1.0)
    unanswered = np.isnan(flat["displacement_per_cycle"]).nonzero()[0]
    if unanswered.size:
        for name in _SAME_IN_CONTACT:
            flat[name][unanswered] = np.nan


def _at(where: tuple[NDArray[np.intp], ...], field: Floats) -> Floats:
    """Pick cells of the grid from a field that broadcasts against it; 0-d where one value serves all."""
    if field.size == 1:
        return field.reshape(())
    picked: Floats = field[tuple(i * (n > 1) for i, n in zip(where, field.shape, strict=True))]
    return picked


def _solve_hops(out: SteadyCycle, cells: NDArray[np.intp], inputs: Fields, model: Hopping) -> None:
    """Solve hopping scenes in place, at flat indices of the grid, and scale them to SI."""
    # Extreme frictions overflow on the way; what is lost by that ends as NaN, and has a status.
    with np.errstate(over="ignore", divide="ignore", invalid="ignore"):
        cycles = model(inputs.loads(), inputs.restitution)
    answered = np.isfinite(cycles.displacement)
    codes = np.where(cycles.pattern > 0, cycles.pattern + SPELT_PATTERNS, cycles.pattern)
    found = {_NAMES.get(name, name): values for name, values in cycles._asdict().items()}
    found["pattern_code"] = np.where(answered, codes, 0)
    found["model_code"] = np.where(answered, np.int8(Model.FLIGHT), np.int8(Model.NONE))
    with np.errstate(over="ignore"):
        speed = 2.0 * np.pi * inputs.frequency * inputs.scale
        found["displacement_per_cycle"] = inputs.scale * cycles.displacement
        found["mean_velocity"] = found["displacement_per_cycle"] * inputs.frequency
        found["mean_velocity_error"] = inputs.scale * found.pop("deviation") * inputs.frequency
        for name in ("peak_velocity", "impact_velocity"):
            found[name] = speed * found[name]
    for name, values in found.items():
        getattr(out, name).reshape(-1)[cells] = values


def _look_for_others(out: SteadyCycle, cells: NDArray[np.intp], inputs: Fields) -> None:
    """Tell in place whether other motions coexist, at flat indices of the grid."""
    speed = 2.0 * np.pi * inputs.frequency * inputs.scale
    period, impact = (x.reshape(-1)[cells] for x in (out.period_cycles, out.impact_velocity))
    with np.errstate(over="ignore", divide="ignore", invalid="ignore"):
        found = coexisting(inputs.loads(), inputs.restitution, period, impact / speed)
    out.coexists.reshape(-1)[cells] = found


def _flat(field: Floats, shape: tuple[int, ...]) -> Floats:
    """Make a field 1-D over a block; 0-d where one value serves all its cells."""
    if field.shape == shape:
        return field.reshape(-1)
    if not field.ndim or (field.size == 1 and math.prod(shape) > 1):
        return field.reshape(())
    return np.broadcast_to(field, shape).reshape(-1)
