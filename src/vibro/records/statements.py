"""A fit in words: what each estimate comes from, and what the data cannot identify."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np

from vibro.motion.settled import settled_motion
from vibro.quantities import QUANTITIES
from vibro.records.cycles import HOPS
from vibro.records.descent import derivatives
from vibro.scene import Scene

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from vibro.records.descent import Minimum
    from vibro.records.fitting import Parameter
    from vibro.records.misfits import Problem

    Floats = NDArray[np.float64]

__all__ = ["groups", "statements"]

# A combination whose relative standard error exceeds this counts as unknown.
_UNKNOWN: Final = 0.3
_SHARE: Final = 0.05  # of an unknown combination: a parameter with a smaller share is not part of it
_AT_LIMIT: Final = 1e-4  # of the range of what is tried
_HALVINGS: Final = 30


def statements(problem: Problem, minima: Sequence[Minimum], parameters: Sequence[Parameter]) -> list[str]:
    """Say what the estimates come from, what cannot be identified, and what ended at a bound.

    Parameters
    ----------
    problem : Problem
        The misfit.
    minima : sequence of Minimum
        Of the patterns that fit, the best first.
    parameters : sequence of Parameter
        The estimates.
    """
    best = minima[0]
    values = problem.fixed | {p.name: p.value for p in parameters}
    pattern = settled_motion(Scene(**values)).pattern if best.label == HOPS else best.label
    lost = {p.name for p in parameters if not p.identified}
    if "F" not in pattern and "B" not in pattern:
        said = ", ".join(QUANTITIES[p.name].letter for p in parameters if p.name in lost)
        return [f"the fitted body rests: beyond that, the data cannot identify {said}"] if said else []
    found = []
    rests = "_" in pattern
    told = [n for n in ("static_friction", "kinetic_friction") if n in problem.names and n not in lost]
    if rests and told:
        effects = {"static_friction": "mu_s sets the start of a slide", "kinetic_friction": "mu_d its end"}
        if told == ["kinetic_friction"]:
            effects["kinetic_friction"] = "mu_d sets the end of a slide"
        found.append(f"pattern {pattern}: " + " and ".join(effects[name] for name in told))
    if best.label == HOPS:
        found.append("the body hops: intervals are those of small changes, and end at no other pattern")
    if any(len(p.intervals) > 1 for p in parameters):
        labels = dict.fromkeys(m.label for m in minima)
        several = (
            f"patterns {' and '.join(labels)} fit" if len(labels) > 1 else "phases to both sides of 0 fit"
        )
        found.append(f"{several}: an interval in pieces holds the values of each")
    found += _unidentified(problem, best, pattern, {p.name: p for p in parameters if p.name in lost})
    return found + _limits(problem, pattern, parameters, values)


def _unidentified(problem: Problem, best: Minimum, pattern: str, lost: dict[str, Parameter]) -> list[str]:
    """Say of each quantity without an estimate why it has none."""
    found = []
    left = set(lost)
    for group in groups(problem, best):
        if not left & set(group):
            continue
        left -= set(group)
        *first, last = (QUANTITIES[name].letter for name in group)
        symbols = f"{', '.join(first)} and {last}" if first else last
        if group == ("static_friction",) and "_" not in pattern:
            until = (
                ""
                if best.label == HOPS
                else f", from mu_d up to {_highest_static_friction(problem, best):.4g}"
            )
            found.append(
                f"the data cannot identify mu_s: in pattern {pattern} the body never rests, and mu_s has no"
                f" effect at all{until}"
            )
        elif len(group) == 1:
            found.append(f"the data cannot identify {symbols}: its effect is smaller than the misfit")
        else:
            found.append(f"the data cannot tell {symbols} apart: their effects cancel; give one of them")
    for name in sorted(left):
        why = (
            "a wide range of values fits"
            if lost[name].intervals
            else "no end of the values that fit was found"
        )
        found.append(f"the data cannot identify {QUANTITIES[name].letter}: {why}")
    return found


def groups(problem: Problem, best: Minimum) -> list[tuple[str, ...]]:
    """Find combinations of quantities that the data do not determine.

    They are singular directions of the relative sensitivities, without the effect of the trigger time.
    """
    _, jacobian = derivatives(problem, best.label, best.point, list(range(best.point.size)))
    clock, free = jacobian[:, -1:], jacobian[:, :-1]
    power = float((clock**2).sum())
    if power > 0.0:
        free = free - clock @ (clock.T @ free) / power
    _, singular, directions = np.linalg.svd(free * problem.scale(best.point)[:-1], full_matrices=False)
    return [
        tuple(name for name, share in zip(problem.names, direction, strict=True) if abs(share) > _SHARE)
        for direction in directions[singular * _UNKNOWN < 1.0]
    ]


def _limits(
    problem: Problem, pattern: str, parameters: Sequence[Parameter], values: dict[str, float]
) -> list[str]:
    """Say which estimates ended at a limit."""
    found = []
    both = {"static_friction", "kinetic_friction"} <= set(problem.names)
    for p, low, high in zip(parameters, *problem.bounds, strict=True):
        if p.name == "static_friction" and "_" not in pattern:
            continue  # it has no effect: its value means nothing
        within = _AT_LIMIT * (high - low)
        limits = [
            (p.value - low, f"the lowest value that is tried, {low:.4g}"),
            (high - p.value, f"the highest value that is tried, {high:.4g}"),
        ]
        if p.name == "static_friction" or (p.name == "kinetic_friction" and not both):
            limits.append((values["static_friction"] - values["kinetic_friction"], "mu_d = mu_s"))
        found += [f"{QUANTITIES[p.name].letter} is at its limit, {what}" for d, what in limits if d < within]
    return found


def _highest_static_friction(problem: Problem, best: Minimum) -> float:
    """Largest static friction that gives the fitted pattern, by bisection."""
    column = problem.names.index("static_friction")
    point = best.point.copy()
    low, high = float(point[column]), float(problem.bounds[1, column])
    for _ in range(_HALVINGS):
        point[column] = 0.5 * (low + high)
        low, high = (
            (point[column], high) if problem.labels(point[None])[0] == best.label else (low, point[column])
        )
    return low
