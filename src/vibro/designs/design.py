"""Answer a question of inverse design: ``vibro.design``."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final, Literal

from vibro.core.codes import Regime
from vibro.designs.machine_drives import covering, find_covered
from vibro.designs.proofs import first_ratio, last_ratio
from vibro.designs.questions import MOST_DIGITS, Question
from vibro.designs.reading import read_spec
from vibro.designs.rows import DIGITS, KINDS, SEARCHED
from vibro.designs.sensitivities import speed_costs
from vibro.errors import InputError, shown
from vibro.reals import shielded
from vibro.results.designs import Design, DesignResult
from vibro.units import SPEED

if TYPE_CHECKING:
    import os
    from collections.abc import Callable, Iterator, Mapping

    from vibro.designs.questions import Drive, Spec
    from vibro.designs.rows import Finder
    from vibro.designs.spaces import AnySetting, UncertaintySet

_Row = tuple[Design, tuple[float, ...] | None, tuple[float, float] | None]
_REGIMES: Final = (Regime.FORWARD_SLIP, Regime.BACK_SLIP, Regime.HOPPING)


@shielded
def design(
    spec: str | os.PathLike[str] | Mapping[str, Any],
    *,
    digits: int = DIGITS,
    only: Literal["goal"] | None = None,
) -> DesignResult:
    """Find the drive settings that guarantee a speed for every part within given tolerances.

    Parameters
    ----------
    spec : path or mapping
        A design file in TOML, or a mapping with the same keys, those of :doc:`/reference/design-files`.
    digits : int, optional
        Significant digits of settings, from 1 to 15. A setting that would lose its guarantee by rounding has
        more.
    only : {"goal"}, optional
        ``"goal"`` leaves out designs within other regimes than the goal's highest one.

    Returns
    -------
    DesignResult
        The gentlest (least acceleration), the fastest and the safest design of every drive within the goal's
        highest regime; then those within forward-slip, back-slip and hopping, as far as these differ from it.

    Raises
    ------
    InputError
        If the question or an argument is invalid; the message lists all problems.
    FileError
        If the file cannot be read.

    Examples
    --------
    >>> import vibro
    >>> result = vibro.design({
    ...     "scene": {"static_friction": "0.7:0.78", "kinetic_friction": "0.5:0.6"},
    ...     "drive": [{"amplitude_mm": 3, "frequency_hz": "10:30", "drive_angle_deg": "5:45"}],
    ...     "goal": {"speed_mm_s": 30, "highest_regime": "forward-slip"},
    ... }, only="goal")
    >>> gentlest = result.designs[0]
    >>> print(result.met, f"{gentlest.acceleration_g:.4f} g, {gentlest.amplitude_mm} mm")
    True 0.9658 g, 2.4 mm
    """
    if only not in (None, "goal"):
        raise InputError(f"only = {shown(only)}: must be 'goal' or None")
    return find_designs(read_spec(spec), digits=_checked_digits("digits", digits), goal_only=only is not None)


def at_most(regime: Regime) -> str:
    """Say what a highest regime allows."""
    return "hopping allowed" if regime is Regime.HOPPING else f"{regime.label} at most"


def _checked_digits(name: str, digits: object) -> int:
    """Return a number of digits; raises InputError, which calls it by a name, if it is none."""
    if isinstance(digits, bool) or not isinstance(digits, int) or not 1 <= digits <= MOST_DIGITS:
        raise InputError(f"{name} = {shown(digits)}: must be a whole number from 1 to {MOST_DIGITS}")
    return digits


def find_designs(
    spec: Spec,
    tell: Callable[[int, int, str], None] = lambda *_: None,
    *,
    digits: int = DIGITS,
    goal_only: bool = False,
) -> DesignResult:
    """Find the designs of a checked question.

    ``tell(done, total, what)`` reports how many searches are done, and what is searched. With ``goal_only``
    the designs of other regimes are left out.
    """
    highest = spec.goal.highest_regime
    # designs of lower regimes are candidates for those of the goal's
    regimes = [regime for regime in _REGIMES if regime <= highest or not goal_only]
    total = len(spec.drives) * len(regimes) * len(KINDS)
    finders: dict[tuple[str, Regime], dict[str, Finder]] = {}

    def search(drive: Drive, regime: Regime) -> None:
        done, where = len(finders) * len(KINDS), at_most(regime)
        calmer = finders.get((drive.name, Regime(regime - 1)), {})
        finders[drive.name, regime] = find_covered(
            Question(spec, drive, regime),
            calmer,
            digits,
            lambda kind: tell(done + SEARCHED.index(kind), total, f"{drive.name}: {kind}, {where}"),
        )

    def rows(drive: Drive, regime: Regime) -> Iterator[_Row]:
        for kind in KINDS:
            finder = finders[drive.name, regime][kind]
            machine = finder.question.drive.machine
            setting = finder.found[kind].setting if kind in finder.found else None
            yield finder.row(kind), setting, None if machine is None else machine.covered

    found: list[_Row] = []
    for drive in spec.drives:
        for regime in regimes:
            if regime <= highest:
                search(drive, regime)
        found += rows(drive, highest)
    for drive in spec.drives if not goal_only else ():
        for regime in regimes:
            if regime > highest:
                search(drive, regime)
            if regime is not highest:
                found += rows(drive, regime)
    tell(total, total, "")
    designs, settings, covered = zip(*found, strict=True)
    met = any(
        d.highest_regime == highest.label and (d.speed_min_mm_s or 0.0) >= SPEED.from_si(spec.goal.speed)
        for d in designs
    )
    return DesignResult(met, designs, settings, covered if any(covered) else (), spec)


@dataclass(frozen=True)
class Chosen:
    """The design that pictures and margins show.

    Attributes
    ----------
    drive : Drive
        Its drive.
    design : Design
        Within the goal's regime the safest of all drives; the gentlest without uncertainty, and the
        fastest where no drive meets the goal.
    setting : Setting or Scaled
        In SI units and radians.
    loads : dict of str to float
        Load of the setting over the critical load of the first, or the last, body [1].
    costs : dict of str to float or str
        Change of the nominal speed for a change of 1 % (angles: 1 deg) of each input, by field [%]; why there
        is none, if so.
    """

    drive: Drive
    design: Design
    setting: AnySetting
    loads: dict[str, float]
    costs: dict[str, float | str]


def chosen_of(spec: Spec, result: DesignResult, design: Design | None = None) -> Chosen | None:
    """Return the design that the report shows, or one of the result; None if it guarantees no speed."""
    highest = spec.goal.highest_regime
    # without uncertainty no design is safer than another, and the safest would be the drive's limit
    wanted = "fastest" if not result.met else "safest" if spec.has_bands else "gentlest"
    covered = result.covered or (None,) * len(result.designs)
    rows = [
        (d, setting, covering(drive, interval) if interval else drive)
        for drive in spec.drives
        for d, setting, interval in zip(result.designs, result.settings, covered, strict=True)
        if d.drive == drive.name and setting
        if d is design or (design is None and (d.highest_regime, d.design) == (highest.label, wanted))
    ]
    if not rows:
        return None

    def merit(row: tuple[Design, tuple[float, ...], Drive]) -> tuple[float, float]:
        design, speed = row[0], row[0].speed_min_mm_s or 0.0
        return (-(design.acceleration_g or 0.0) if wanted == "gentlest" else design.margin or 0.0), speed

    best, values, drive = max(rows, key=merit)
    question, setting = Question(spec, drive, highest), drive.space.settings._make(values)
    costs = speed_costs(question.nominal_scene(setting))
    if drive.machine is not None and drive.machine.natural_frequency is not None:
        costs["frequency"] = "changes the amplitude too"
    return Chosen(drive, best, setting, _loads(question.box(setting)), costs)


def _loads(box: UncertaintySet) -> dict[str, float]:
    """Return the load over the critical loads of the first body to slip back or hop and the last to start."""
    return {
        "the first part slips back": first_ratio(box, Regime.BACK_SLIP),
        "the first part hops": first_ratio(box, Regime.HOPPING),
        "the last part starts": last_ratio(box, Regime.FORWARD_SLIP),
    }
