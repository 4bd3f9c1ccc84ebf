"""What a machine and its filling add to the results of a cell: every column described once."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final, NamedTuple

import numpy as np

from vibro.results.steady import Result
from vibro.units import ENERGY, FORCE, LENGTH, PERCENT, POWER, SPEED

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from vibro.reals import Floats
    from vibro.results.sweep import Block


# ------------------------------------------------------------------------------
# What lies in a trough, as its drive feels it: shares of added mass and damping, energy, second harmonic.


@dataclass(frozen=True, eq=False, kw_only=True)
class Filling:
    """Steady force of the filling on its trough, per kg of filling; returned by ``vibro.filling``.

    At the drive frequency a filling of mass m acts on the trough like the complex mass ``m * share``, with
    ``share = added_mass_share - 1j * added_damping_share``. Arrays have the scene's shape. They hold NaN
    where the motion has no steady state, and means over many cycles where it is irregular (status
    ``AVERAGED``).

    Attributes
    ----------
    added_mass_share, added_damping_share : float array
        Shares lambda and delta of the filling's mass that act as added mass and as added damping [1].
    added_mass_share_error, added_damping_share_error : float array
        Their standard errors; 0 where the motion repeats [1].
    energy_per_cycle : float array
        Energy that the filling takes from the drive in a drive cycle [J/kg].
    second_harmonic : complex array
        Second harmonic of the force along the drive's line over m A w^2: the force is the imaginary part of
        ``m A w^2 second_harmonic exp(2j w t)``, with the trough at ``A sin(w t)``. For an ellipse, the size
        of the second harmonic of the force over that of the trough's motion [1].
    bound : float array
        Upper bound on ``abs(share)`` and on the size of every other harmonic [1].
    status : int8 array
        Code of the ``Status`` of the motion.
    """

    added_mass_share: Floats
    added_damping_share: Floats
    added_mass_share_error: Floats
    added_damping_share_error: Floats
    energy_per_cycle: Floats
    second_harmonic: NDArray[np.complex128]
    bound: Floats
    status: NDArray[np.int8]

    @property
    def share(self) -> Any:
        """Complex share ``added_mass_share - 1j * added_damping_share`` [1]."""
        return self.added_mass_share - 1j * self.added_damping_share


#: Columns of the shares, beside a machine too.
_MASS_SHARE: Final = Result(
    name="added_mass_share",
    meaning="share of the filling's mass that acts as mass of the trough",
    symbol=r"\lambda",
    column="added_mass_share",
)
_DAMPING_SHARE: Final = Result(
    name="added_damping_share",
    meaning="share of the filling's mass, times the frequency, that acts as damping of the trough",
    symbol="δ",
    column="added_damping_share",
)
#: Columns about a filling whose mass is given, and whose trough moves as the scene says.
WEIGHED: Final = (
    _MASS_SHARE,
    Result(
        name="added_mass_share_error",
        meaning="standard error of that share where it is a mean over many cycles, else 0",
        column="added_mass_share_error",
    ),
    _DAMPING_SHARE,
    Result(
        name="added_damping_share_error",
        meaning="standard error of that share where it is a mean over many cycles, else 0",
        column="added_damping_share_error",
    ),
    Result(
        name="bound",
        meaning="bound of both shares together, by the filling's weight alone",
        column="share_bound",
    ),
    Result(
        name="energy",
        meaning="energy that the filling takes from the drive in a cycle",
        kind=ENERGY,
        column="energy_per_cycle_j",
    ),
    Result(name="power", meaning="power that the filling takes from the drive", kind=POWER, column="power_w"),
    Result(
        name="second_harmonic_force",
        meaning="amplitude of the filling's force on the trough at twice the frequency, along the drive",
        kind=FORCE,
        column="second_harmonic_force_n",
    ),
)


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
    _MASS_SHARE,
    _DAMPING_SHARE,
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
    Result(
        name="uncertain",
        meaning="whether that harmonic changes the motion so much that the speed may be far off: 1 yes, 0 no",
        column="uncertain",
        dtype=np.int8,
        texts=("0", "1", ""),
        is_flag=True,
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
        *((result.name, result.dtype) for result in MACHINE_RESULTS),
        ("second_phasor", np.complex128),
        ("status", np.int8),
        ("number", np.int8),
    ]
)


class Bent(NamedTuple):
    """Numbers of cells whose filling bends the motion of the trough, and of uncertain ones."""

    number: int
    uncertain: int


def bent(block: Block) -> Bent:
    """Count the cells of a block whose filling bends the motion of the trough."""
    if OPERATING not in block.values:
        return Bent(0, 0)
    found: Any = np.broadcast_to(block.values[OPERATING], block.shape)
    number = np.count_nonzero(found["second_harmonic"] > WARNED_HARMONIC)
    return Bent(int(number), int(np.count_nonzero(found["uncertain"])))
