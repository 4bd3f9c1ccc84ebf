"""Answer a question of inverse design: ``vibro.design``."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final

from vibro.core.codes import Regime
from vibro.inverse.costs import speed_costs
from vibro.inverse.proofs import first_ratio, last_ratio
from vibro.inverse.questions import Question
from vibro.inverse.reading import read_spec
from vibro.inverse.rows import KINDS, find
from vibro.inverse.spaces import Setting
from vibro.quantities import SPEED
from vibro.results.designs import DesignResult

if TYPE_CHECKING:
    import os
    from collections.abc import Callable, Mapping

    from vibro.inverse.exchange import Found
    from vibro.inverse.spaces import UncertaintySet
    from vibro.inverse.specs import Drive, Spec
    from vibro.results.designs import Design

__all__ = ["Chosen", "chosen_of", "design", "find_designs"]

_REGIMES: Final = (Regime.FORWARD_SLIP, Regime.BACK_SLIP, Regime.HOPPING)


def design(spec: str | os.PathLike[str] | Mapping[str, Any]) -> DesignResult:
    """Find the drive settings that guarantee a speed to every part of a box of bands.

    Parameters
    ----------
    spec : path or mapping
        A TOML file, or a mapping with its keys; docs/design.md lists them.

    Returns
    -------
    DesignResult
        For every drive and each of the regimes forward-slip, back-slip and hopping: the gentlest, the fastest
        and the safest design.

    Raises
    ------
    InputError
        If the question is invalid; it lists every problem.
    FileError
        If the file cannot be read.

    Examples
    --------
    >>> import vibro
    >>> result = vibro.design({
    ...     "scene": {"static_friction": "0.7:0.78", "kinetic_friction": "0.5:0.6"},
    ...     "drive": [{"amplitude_mm": 3, "frequency_hz": "10:30", "drive_angle_deg": "5:45"}],
    ...     "goal": {"speed_mm_s": 30, "highest_regime": "forward-slip"},
    ... })
    >>> gentlest = result.designs[0]
    >>> print(result.met, f"{gentlest.acceleration_g:.6f} g, {gentlest.amplitude_mm:.5f} mm")
    True 0.965580 g, 2.39937 mm
    """
    return find_designs(read_spec(spec))


def find_designs(spec: Spec, tell: Callable[[int, int], None] | None = None) -> DesignResult:
    """Find the designs of a checked question; ``tell(done, total)`` reports the progress."""
    designs: list[Design] = []
    settings: list[tuple[float, ...] | None] = []
    total = len(spec.drives) * len(_REGIMES) * len(KINDS)
    for drive in spec.drives:
        calmer: Mapping[str, Found] = {}
        for regime in _REGIMES:
            finder = find(Question(spec, drive, regime), calmer)
            calmer = finder.found
            designs += [finder.row(kind) for kind in KINDS]
            settings += [calmer[kind].setting if kind in calmer else None for kind in KINDS]
            if tell:
                tell(len(designs), total)
    target, highest = spec.goal.speed, spec.goal.highest_regime.label
    met = any(
        d.highest_regime == highest and (d.speed_min_mm_s or 0.0) >= SPEED.from_si(target) for d in designs
    )
    return DesignResult(met, tuple(designs), tuple(settings))


@dataclass(frozen=True)
class Chosen:
    """The design that pictures and margins show.

    Attributes
    ----------
    drive : Drive
        Its drive.
    design : Design
        The safest of the best drive within the goal's regime; if no drive meets the goal, the fastest.
    setting : Setting
        In SI units and radians.
    loads : dict of str to float
        Load of the setting over the critical load of the first, or the last, body [1].
    costs : dict of str to float
        Change of the nominal speed for a change of 1 % (angles: 1 deg) of each input, by field [%].
    """

    drive: Drive
    design: Design
    setting: Setting
    loads: dict[str, float]
    costs: dict[str, float]


def chosen_of(spec: Spec, result: DesignResult) -> Chosen | None:
    """Return the design that the report shows; None if no design guarantees any speed."""
    highest = spec.goal.highest_regime
    wanted = "safest" if result.met else "fastest"
    rows = [
        (d, setting, drive)
        for drive in spec.drives
        for d, setting in zip(result.designs, result.settings, strict=True)
        if (d.drive, d.highest_regime, d.design) == (drive.name, highest.label, wanted) and setting
    ]
    if not rows:
        return None
    best, values, drive = max(rows, key=lambda row: (row[0].margin or 0.0, row[0].speed_min_mm_s or 0.0))
    question, setting = Question(spec, drive, highest), Setting(*values)
    costs = speed_costs(question.nominal_scene(setting))
    return Chosen(drive, best, setting, _loads(question.box(setting)), costs)


def _loads(box: UncertaintySet) -> dict[str, float]:
    """Return the load over the critical loads of the first body to slip back or hop and the last to start."""
    return {
        "the first part slips back": first_ratio(box, Regime.BACK_SLIP),
        "the first part hops": first_ratio(box, Regime.HOPPING),
        "the last part starts": last_ratio(box, Regime.FORWARD_SLIP),
    }
