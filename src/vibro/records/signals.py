"""The signals that a record may hold, their units, and how programs spell these."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING, Final

from vibro.quantities import LENGTH

if TYPE_CHECKING:
    from collections.abc import Mapping

__all__ = [
    "FAR_OFF",
    "KINDS",
    "MOST",
    "SIGNALS",
    "SIGNAL_UNITS",
    "TROUGH",
    "doubt",
    "option_of",
    "rounded",
    "signal_unit",
]

#: Most that a record, or a scene beside it, may hold of anything [SI]. Up to the fourth power of it is summed
#: over the rows, which must stay far below the largest double, and nothing that is measured comes near it.
MOST: Final = 1e20

#: Signals of the body that a record may hold in addition to its time; each name is also the kind of its unit.
SIGNALS: Final = ("displacement", "velocity", "acceleration", "force")
#: Accelerations of the trough that it may hold: along its surface, and normal to it.
TROUGH: Final = ("trough_along", "trough_normal")
#: Times by which a size is off, either way, before its unit is doubted: less than 10, as a sensitivity that
#: is wrong by 10 and a motion that is a little smaller than computed go together.
FAR_OFF: Final = 7.0
#: What each column is measured in.
KINDS: Final[Mapping[str, str]] = {kind: kind for kind in ("time", *SIGNALS)} | dict.fromkeys(
    TROUGH, "acceleration"
)


def _per_time(suffix: str) -> dict[str, float]:
    return {f"{unit}{suffix}": float(size / 1000) for unit, size in LENGTH.sizes.items()}


# What a measured signal may be given in, and its size in SI units; the first one is the one of tables.
SIGNAL_UNITS: Final[Mapping[str, Mapping[str, float]]] = {
    "time": {"s": 1.0, "ms": 1e-3, "us": 1e-6, "\u00b5s": 1e-6, "min": 60.0},
    "displacement": _per_time(""),
    "velocity": _per_time("/s"),
    "acceleration": {"m/s^2": 1.0, "g": 9.80665} | _per_time("/s^2"),
    "force": {"N": 1.0, "mN": 1e-3, "kN": 1e3},
    "voltage": {"V": 1.0, "mV": 1e-3},
}
# How programs spell the same: MATLAB, SolidWorks and the column names of vibro.
_SPELLINGS: Final = (
    (r"seconds?|sec", "s"),
    (r"newtons?", "n"),
    (r"volts?", "v"),
    (r"\u00b2", "2"),
    (r"[\s\u00b7.*^]", ""),
    (r"(?<=[mn])_(?=s)", "/"),
)


def signal_unit(text: str) -> tuple[str, float] | None:
    """Find what a unit measures.

    Parameters
    ----------
    text : str
        Such as ``mm``, ``mm/sec**2``, ``m_s2``, ``newton`` or ``mV``.

    Returns
    -------
    tuple of str and float, or None
        A key of ``SIGNAL_UNITS`` and the unit's size in SI units; None where the text is no unit of a signal.
    """
    if text == "v":  # a velocity's name, not a volt
        return None
    name = text.casefold()
    for spelling, plain in _SPELLINGS:
        name = re.sub(spelling, plain, name)
    for kind, sizes in SIGNAL_UNITS.items():
        for unit, size in sizes.items():
            if name == unit.casefold().replace("^", ""):
                return kind, size
    return None


def doubt(sensitivity: str) -> str:
    """Ask for what makes a signal far too large or small: its sensitivity, if it has one, else its unit."""
    return f"is its sensitivity {sensitivity} right?" if sensitivity else "is its unit right?"


def rounded(ratio: float) -> str:
    """Write a ratio to two digits, as 1000 and not as 1e+03."""
    return f"{float(f'{ratio:.2g}'):g}"


def option_of(role: str) -> str:
    """Name the option that gives the column of a signal."""
    return "--" + role.replace("_", "-")
