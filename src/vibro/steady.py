"""Steady cycles of whole grids of scenes: the public face of the core."""

from __future__ import annotations

import math
import os
from collections import deque
from dataclasses import dataclass
from functools import cache
from threading import Thread
from typing import TYPE_CHECKING, Any, Literal, get_args

import numpy as np

from vibro.core.codes import MODELS, Model, Status
from vibro.core.contact.solver import HOPPING_PATTERNS, SteadyState, pattern_texts, steady_state
from vibro.core.flight.cycles import MOST_THROW, hopping_cycles
from vibro.core.groups import Loads, loads
from vibro.errors import Problem, SceneError, VibroError

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    from numpy.typing import NDArray

    from vibro.scene import Scene

    Floats = NDArray[np.float64]
    Codes = NDArray[np.int8]

__all__ = ["Accuracy", "SteadyCycle", "grid_blocks", "solve"]

Accuracy = Literal["exact", "regimes"]
_LEVELS = get_args(Accuracy)

_MODEL_TEXTS = np.array(MODELS)

# Cells a block: few enough that temporaries stay near a core, many enough that threads seldom wait for
# each other between two NumPy calls (benchmarks/kernel.py).
_BLOCK = 131_072

# Hopping cells at once: many enough to share the steps that a few of them, with hundreds of flights, need.
_HOPPING_BLOCK = 32_768

# [s] How long an interrupt may go unnoticed: on Windows a wait without an end ignores it.
_PATIENCE = 0.1


@dataclass(frozen=True, eq=False)
class SteadyCycle:
    """What the body on the trough does once it has settled, from rest; one value a scene.

    Every attribute has the scene's shape. A cell without an answer holds NaN and a status that says why.

    Attributes
    ----------
    regime, status : int8 array
        Codes of ``Regime`` and ``Status``.
    pattern_code, model_code : int64 and int8 array
        Codes behind ``pattern`` and ``model``.
    displacement_per_cycle : float array
        Displacement relative to the trough in one drive cycle, positive in the conveying direction [m].
    mean_velocity : float array
        Mean conveying speed [m/s].
    mean_velocity_error : float array
        Standard error of the mean speed where it is a mean over many cycles (``AVERAGED``), else 0 [m/s].
    peak_velocity : float array
        Largest relative speed along the trough, either way, >= 0 [m/s].
    flight_fraction : float array
        Share of the time that the body is off the trough [1].
    impact_velocity : float array
        Largest normal speed at which it lands, 0 without flight [m/s].
    period_cycles : float array
        Drive cycles until the motion repeats; NaN where it does not [1].
    throw_number : float array
        K = G sin(alpha) / cos(beta); the body hops above 1 [1].
    forward_ratio, back_ratio : float array
        1/s_f and 1/s_b, the load over the load at which forward and back slip begin [1];
        0 where no load makes the body slip that way.
    coexists : bool array
        Whether a disturbed body can settle into another steady cycle than the one from rest.
    """

    regime: Codes
    status: Codes
    pattern_code: NDArray[np.int64]
    model_code: Codes
    displacement_per_cycle: Floats
    mean_velocity: Floats
    mean_velocity_error: Floats
    peak_velocity: Floats
    flight_fraction: Floats
    impact_velocity: Floats
    period_cycles: Floats
    throw_number: Floats
    forward_ratio: Floats
    back_ratio: Floats
    coexists: NDArray[np.bool_]

    @property
    def pattern(self) -> Any:
        """Phases of the cycle as text: H flight, F forward slide, B back slide, _ rest; empty if none."""
        return pattern_texts(np.asarray(self.pattern_code))[()]

    @property
    def model(self) -> Any:
        """The cheapest exact model that gave the answer, as text."""
        return _MODEL_TEXTS[self.model_code]

    def traverse_time(self, length: Any) -> Any:
        """Time to convey over a length at the mean speed.

        Parameters
        ----------
        length : array_like
            Length of the trough, > 0 [m]; broadcasts against the scene.

        Returns
        -------
        array
            ``length / mean_velocity`` [s]; inf where the body does not move forward, NaN where its
            speed is unknown.
        """
        length = np.asarray(length, dtype=np.float64)
        if not (np.isfinite(length) & (length > 0.0)).all():
            raise SceneError((Problem("length", str(length), "finite and > 0 m"),))
        velocity = np.where(self.mean_velocity > 0.0, self.mean_velocity, 0.0)
        with np.errstate(divide="ignore"):
            return np.where(np.isnan(self.mean_velocity), np.nan, length / velocity)[()]


def solve(scene: Scene, *, accuracy: Accuracy = "exact", flight: bool = True) -> SteadyCycle:
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

    Returns
    -------
    SteadyCycle
        Arrays of the scene's shape; NumPy scalars for a single scene.

    Notes
    -----
    Exact up to rounding, see docs/theory.md: on the reference tables the displacement is within
    16 eps (condition * abs(d) + S), where S = A if the body slides both ways and abs(d) otherwise
    (tests/test_reference.py). Cells are solved in blocks that stay in a core's cache, on all cores.

    Examples
    --------
    >>> import math, vibro
    >>> cycle = vibro.solve(vibro.Scene(amplitude=1e-3, frequency=15, drive_angle=math.radians(20),
    ...                                 static_friction=0.74, kinetic_friction=0.57))
    >>> print(f"{cycle.mean_velocity:.9f} m/s, {cycle.pattern}")
    0.016263456 m/s, F_
    """
    if accuracy not in _LEVELS:
        raise VibroError(f"accuracy = {accuracy!r}: must be one of {', '.join(_LEVELS)}")
    shape = scene.shape
    grid = shape or (1,)
    ones = (1,) * len(grid)
    arrays = [a.reshape(ones[a.ndim :] + a.shape) for a in scene.arrays()]
    blocks = list(grid_blocks(grid, _BLOCK))
    out = _unsolved(grid)

    def contact(block: tuple[slice, ...]) -> None:
        inputs = arrays if len(blocks) == 1 else [a[_within(block, a.shape)] for a in arrays]
        _solve_block(out, block, inputs, accuracy == "regimes")

    def hops(cells: NDArray[np.intp]) -> None:
        where = np.unravel_index(cells, grid)
        _solve_hops(out, cells, [_at(where, a) for a in arrays])

    _in_parallel(contact, blocks)
    if flight and accuracy == "exact":
        # Beyond the largest throw number the phase of a landing is lost to rounding. NumPy takes 2 us to
        # compare with an enum, a tenth of it with an int.
        followed = (out.status == int(Status.FLIGHT_NOT_MODELLED)) & (out.throw_number <= MOST_THROW)
        hopping = followed.reshape(-1).nonzero()[0]
        _in_parallel(hops, [hopping[i : i + _HOPPING_BLOCK] for i in range(0, hopping.size, _HOPPING_BLOCK)])
    return out if shape else SteadyCycle(*(array[0] for array in vars(out).values()))


def _in_parallel(run: Callable[[Any], None], parts: list[Any]) -> None:
    """Run parts on all cores; after an interrupt the other threads end with the part they are at."""
    if len(parts) < 2:
        for part in parts:
            run(part)
        return
    _retain_freed_memory()
    left = deque(parts)
    failures: list[BaseException] = []

    def work() -> None:
        while True:
            try:
                part = left.popleft()
            except IndexError:  # none left; another thread may have taken the last
                return
            run(part)

    def work_along() -> None:
        try:
            work()
        except BaseException as exc:
            failures.append(exc)
            left.clear()

    others = [Thread(target=work_along, daemon=True) for _ in range(min(os.cpu_count() or 1, len(parts)) - 1)]
    try:
        for thread in others:
            thread.start()
        work()
        for thread in others:
            while thread.is_alive():
                thread.join(_PATIENCE)
    finally:
        left.clear()
    if failures:
        raise failures[0]


@cache
def _retain_freed_memory() -> None:
    """Free one large buffer, once.

    From then on glibc's malloc keeps freed temporaries for reuse instead of handing them back to the
    system after every step, which otherwise costs a fifth of the time in page faults. Harmless elsewhere.
    """
    np.empty((32 << 20) - 8192, np.uint8)  # just below the largest threshold that malloc adapts to


def _unsolved(shape: tuple[int, ...]) -> SteadyCycle:
    """Make arrays to be filled; what only flight changes is zero from the start, which costs nothing."""

    def codes() -> Codes:
        return np.empty(shape, np.int8)

    def numbers() -> Floats:
        return np.empty(shape)

    return SteadyCycle(
        codes(), codes(), np.empty(shape, np.int64), codes(),
        numbers(), numbers(), np.zeros(shape), numbers(), np.zeros(shape), np.zeros(shape), numbers(),
        numbers(), numbers(), numbers(),
        np.empty(shape, np.bool_),
    )  # fmt: skip


def grid_blocks(shape: tuple[int, ...], size: int) -> Iterator[tuple[slice, ...]]:
    """Cut a grid into slabs of at most ``size`` cells, in the order of its cells."""
    if 0 in shape:
        return
    inner = 1
    axis = len(shape)
    while axis > 0 and inner * shape[axis - 1] <= size:
        axis -= 1
        inner *= shape[axis]
    if axis == 0:
        yield (slice(None),) * len(shape)
        return
    rows = max(1, size // inner)
    rest = (slice(None),) * (len(shape) - axis)
    for outer in np.ndindex(*shape[: axis - 1]):
        fixed = tuple(slice(i, i + 1) for i in outer)
        for start in range(0, shape[axis - 1], rows):
            yield (*fixed, slice(start, start + rows), *rest)


def _within(block: tuple[slice, ...], shape: tuple[int, ...]) -> tuple[slice, ...]:
    """Restrict a block of the grid to a field that broadcasts against it."""
    return tuple(slice(None) if n == 1 else part for part, n in zip(block, shape, strict=True))


def _solve_block(
    out: SteadyCycle, block: tuple[slice, ...], arrays: list[Floats], classes_alone: bool
) -> None:
    """Solve one block in place and scale it to SI."""
    part = {name: array[block] for name, array in vars(out).items()}
    shape = part["status"].shape
    # views: blocks are contiguous
    flat = part if len(shape) == 1 else {name: array.reshape(-1) for name, array in part.items()}
    state = SteadyState(
        regime=flat["regime"],
        status=flat["status"],
        pattern=flat["pattern_code"],
        model=flat["model_code"],
        displacement=flat["displacement_per_cycle"],
        peak=flat["peak_velocity"],
        throw_number=flat["throw_number"],
        forward_ratio=flat["forward_ratio"],
        back_ratio=flat["back_ratio"],
        coexists=flat["coexists"],
    )
    steady_state(Loads(*(_flat(a, shape) for a in loads(*arrays[:7]))), state, classes_alone=classes_alone)
    amplitude, frequency = arrays[0], arrays[1]
    with np.errstate(over="ignore"):  # inf where the result is beyond the range of doubles
        part["displacement_per_cycle"] *= amplitude
        np.multiply(part["displacement_per_cycle"], frequency, out=part["mean_velocity"])
        part["peak_velocity"] *= 2.0 * np.pi * frequency * amplitude
    flat["period_cycles"].fill(1.0)
    unanswered = np.isnan(flat["displacement_per_cycle"]).nonzero()[0]
    if unanswered.size:
        for name in ("mean_velocity_error", "flight_fraction", "impact_velocity", "period_cycles"):
            flat[name][unanswered] = np.nan


def _at(where: tuple[NDArray[np.intp], ...], field: Floats) -> Floats:
    """Pick cells of the grid from a field that broadcasts against it; 0-d where one value serves all."""
    if field.size == 1:
        return field.reshape(())
    picked: Floats = field[tuple(i * (n > 1) for i, n in zip(where, field.shape, strict=True))]
    return picked


def _solve_hops(out: SteadyCycle, cells: NDArray[np.intp], arrays: list[Floats]) -> None:
    """Solve hopping scenes in place, at flat indices of the grid, and scale them to SI."""
    amplitude, frequency = arrays[0], arrays[1]
    # Extreme frictions overflow on the way; what is lost by that ends as NaN, and has a status.
    with np.errstate(over="ignore", divide="ignore", invalid="ignore"):
        cycles = hopping_cycles(loads(*arrays[:7]), arrays[7])
    answered = np.isfinite(cycles.displacement)
    pattern = np.where(cycles.pattern > 0, cycles.pattern + HOPPING_PATTERNS, cycles.pattern)
    with np.errstate(over="ignore"):
        speed = 2.0 * np.pi * frequency * amplitude
        results = {
            "status": cycles.status,
            "pattern_code": np.where(answered, pattern, 0),
            "model_code": np.where(answered, np.int8(Model.FLIGHT), np.int8(Model.NONE)),
            "displacement_per_cycle": amplitude * cycles.displacement,
            "mean_velocity": amplitude * cycles.displacement * frequency,
            "mean_velocity_error": amplitude * cycles.deviation * frequency,
            "peak_velocity": speed * cycles.peak,
            "flight_fraction": cycles.flight_fraction,
            "impact_velocity": speed * cycles.impact,
            "period_cycles": cycles.period,
            "coexists": cycles.coexists,
        }
    for name, values in results.items():
        getattr(out, name).reshape(-1)[cells] = values


def _flat(field: Floats, shape: tuple[int, ...]) -> Floats:
    """Make a field 1-D over a block; 0-d where one value serves all its cells."""
    if field.shape == shape:
        return field.reshape(-1)
    if not field.ndim or (field.size == 1 and math.prod(shape) > 1):
        return field.reshape(())
    return np.broadcast_to(field, shape).reshape(-1)
