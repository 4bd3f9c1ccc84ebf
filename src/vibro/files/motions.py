"""Motions of scene files: the table ``[motion]``, as it is given and as the solver takes it."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, Final, NamedTuple

from vibro.drives import Motion, harmonic_motion, sampled_motion, step_motion
from vibro.errors import InputError, SceneError
from vibro.quantities import HARMONIC, MOST_HARMONICS, QUANTITIES

if TYPE_CHECKING:
    from collections.abc import Mapping

#: Keys of harmonics, which become single quantities, so that each of them can be an axis.
HARMONICS: Final = ("along_harmonics_mm_deg", "normal_harmonics_mm_deg")
_STEPS: Final = ("along_steps", "normal_steps")
_ACCELERATIONS: Final = ("along_samples_m_s2", "normal_samples_m_s2")
_DISPLACEMENTS: Final = ("along_samples_mm", "normal_samples_mm")
#: Ways to give a motion: the keys along the trough and normal to it.
MOTIONS: Final = (HARMONICS, _STEPS, _ACCELERATIONS, _DISPLACEMENTS)
_MILLIMETRES: Final = 1000.0  # [mm] of a metre


class GivenMotion(NamedTuple):
    """A motion, and the table that gives it, to be written back as given."""

    table: Mapping[str, Any]
    motion: Motion


def way_of(table: Mapping[str, Any]) -> tuple[str, str]:
    """Return the keys of the way in which a table gives a motion.

    Raises
    ------
    InputError
        If it gives none, or several.
    """
    ways = [way for way in MOTIONS if not table.keys().isdisjoint(way)]
    if not ways:
        example = "along_steps = [[0.8, 6.9], [0.2, -27.6]]"
        raise InputError("gives no motion", hint=f"[motion] for example: {example}")
    if len(ways) > 1:
        given = " and ".join(key for way in ways for key in way if key in table)
        hint = "give both directions as harmonics, as steps or as samples of one kind"
        raise InputError(f"gives {given}", hint=hint)
    return ways[0]


def motion_of(table: Mapping[str, Any]) -> GivenMotion:
    """Make the motion of a table.

    Parameters
    ----------
    table : mapping
        Lists by key.

    Raises
    ------
    InputError
        If they are no motion; the message names their keys.
    """
    keys = way_of(table)
    along, normal = map(table.get, keys)
    try:
        if keys == HARMONICS:
            pairs = [_harmonics(table.get(key), key) for key in keys]
            return GivenMotion(table, harmonic_motion(pairs, keys))
        if keys == _STEPS:
            return GivenMotion(table, step_motion(along, normal, keys))
        if keys == _ACCELERATIONS:
            return GivenMotion(table, sampled_motion(along, normal, "acceleration", keys))
        x, y = (None if mm is None else [value / _MILLIMETRES for value in mm] for mm in (along, normal))
        return GivenMotion(table, sampled_motion(x, y, "displacement", keys))
    except SceneError as exc:
        raise InputError(*(str(problem) for problem in exc.problems)) from None


def harmonic_lists(values: Mapping[str, float]) -> tuple[dict[str, list[float]], dict[str, float]]:
    """Return the lists of [scene] that give the same harmonics as single quantities.

    Parameters
    ----------
    values : mapping of str to float
        By quantity, in the units outside; a phase that is left out is 0.

    Returns
    -------
    dict of str to list of float
        By key; of directions with one harmonic without a phase of its own there are none.
    dict of str to float
        The other quantities.
    """
    lists, others = {}, {**values}
    for way in ("along", "normal"):
        if not any(name in values for name in HARMONIC if name.startswith(way)):
            continue
        for first in (f"{way}_amplitude", f"{way}_phase"):
            names = [first, *(f"{first}_{n}" for n in range(2, MOST_HARMONICS + 1))]
            while len(names) > 1 and names[-1] not in values:
                names.pop()
            key = f"{first}s{QUANTITIES[first].kind.suffix}"
            lists[key] = [others.pop(name, 0.0) for name in names]
    return lists, others


def _harmonics(pairs: list[list[float]] | None, key: str) -> list[tuple[float, float]] | None:
    """Return pairs of amplitude [m] and phase [rad]."""
    if pairs is None:
        return None
    for pair in pairs:
        if not (0.0 <= pair[0] < math.inf and math.isfinite(pair[1])):
            raise InputError(f"{key} has {pair}", hint=f"{key}: give amplitudes >= 0 mm, finite")
    return [(amplitude / _MILLIMETRES, math.radians(phase)) for amplitude, phase in pairs]
