"""What a machine and its filling add to the results of a cell: every column described once."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Final

import numpy as np

from vibro.quantities import LENGTH, PERCENT, SPEED
from vibro.results.filling import DAMPING_SHARE, MASS_SHARE
from vibro.results.steady import Result

if TYPE_CHECKING:
    from vibro.results.sweep import Block

__all__ = ["BENT_SPEED", "FIELDS", "MACHINE_RESULTS", "OPERATING", "WARNED_HARMONIC", "bent"]

#: Key of a block's values under which these results are, as one array of ``FIELDS``, in SI units.
OPERATING: Final = "operating"
#: [1] Second harmonic of the trough over its amplitude above which users are warned.
WARNED_HARMONIC: Final = 1e-3

#: Columns of tables with a machine, after its own quantities and before ``model``.
MACHINE_RESULTS: Final = (
    Result(
        name="frequency_ratio",
        meaning="frequency of the drive over the natural frequency of the empty machine",
        symbol=r"\eta=f/f_0",
        column="frequency_ratio",
    ),
    Result(
        name="amplitude_empty",
        meaning="amplitude of the same machine with an empty trough",
        symbol="A_0",
        kind=LENGTH,
        column="amplitude_empty_mm",
    ),
    MASS_SHARE,
    DAMPING_SHARE,
    Result(
        name="relative_amplitude",
        meaning="amplitude of the trough against its counter mass, or the floor: what the springs bend",
        symbol=r"\lvert X_1-X_2\rvert",
        kind=LENGTH,
        column="relative_amplitude_mm",
    ),
    Result(
        name="second_harmonic",
        meaning="amplitude at twice the frequency that the filling puts on the trough, over its amplitude",
        symbol="A_2/A",
        kind=PERCENT,
        column="second_harmonic_percent",
    ),
)
#: A column only on request: it takes far longer than the speed under the sine.
BENT_SPEED: Final = Result(
    name="speed_with_second_harmonic",
    meaning="mean conveying speed where the trough moves with the second harmonic of its filling too",
    kind=SPEED,
    column="mean_velocity_with_second_harmonic_mm_s",
)
#: Numbers of each cell: the results, the second harmonic with its phase, the status (``vibro.Status``), and
#: how many operating points exist.
FIELDS: Final = np.dtype(
    [
        *((result.name, np.float64) for result in MACHINE_RESULTS),
        ("second_phasor", np.complex128),
        ("status", np.int8),
        ("number", np.int8),
    ]
)


def bent(block: Block) -> int:
    """Count the cells of a block whose trough does not move as a sine, because of its filling."""
    if OPERATING not in block.values:
        return 0
    found: Any = block.values[OPERATING]
    second = np.broadcast_to(found["second_harmonic"], block.shape)
    return int(np.count_nonzero(second > WARNED_HARMONIC))
