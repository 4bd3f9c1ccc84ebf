"""Which drive a scene file and a caller give together: one along a line, or one along an ellipse."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from vibro.quantities import DRIVES, ELLIPTICAL, HARMONIC, LINEAR, QUANTITIES

if TYPE_CHECKING:
    from collections.abc import Callable, Collection, Mapping, Sequence

    from vibro.axes import AxisSpec
    from vibro.quantities import Quantity

__all__ = ["TWO_AXIS", "drive_given"]

#: Quantities of drives along an ellipse, with harmonics or without.
TWO_AXIS: Final = (*ELLIPTICAL, *HARMONIC)


def drive_given(
    layers: Sequence[tuple[str, dict[str, AxisSpec]]],
    spelled: Callable[[Quantity], str],
    known: Collection[str],
) -> tuple[tuple[str, ...], tuple[str, str] | None]:
    """Find which drive is given; if it is complete, drop quantities of another drive from lower layers.

    Parameters
    ----------
    layers : sequence of pair of str and dict
        Source and its quantities, by slot; each overrides those after it.
    spelled : callable
        How the caller names a quantity, for messages.
    known : collection of str
        Slots that need not be given.

    Returns
    -------
    tuple of str
        ``LINEAR``, also if nothing is given, or ``TWO_AXIS``.
    pair of str, or None
        Message and hint if two drives are given and neither is complete in a higher layer.
    """
    given: dict[str, str] = {}
    for source, specs in layers:
        both = given | {slot: source for slot in specs if slot in DRIVES}
        line, ellipse = ([slot for slot in both if slot in drive] for drive in (LINEAR, TWO_AXIS))
        if not (line and ellipse):
            given = both
            continue
        for drive, whole in ((LINEAR, LINEAR), (TWO_AXIS, ELLIPTICAL[:2])):
            if given.keys() <= set(drive) and set(whole) <= {*given, *known}:
                for slot in both.keys() - set(drive):
                    del specs[slot]
                break
        else:
            return LINEAR, _two_drives(both, spelled)
    named = {*given} or {*known}
    return (TWO_AXIS if named & set(TWO_AXIS) else LINEAR), None


def _two_drives(both: Mapping[str, str], spelled: Callable[[Quantity], str]) -> tuple[str, str]:
    """Return message and hint for quantities of two drives: their sources, and the remedy."""
    said = [
        f"{source} gives {', '.join(QUANTITIES[slot].label for slot in both if both[slot] == source)}"
        for source in dict.fromkeys(both.values())
    ]
    why = "a drive moves either along a line or along an ellipse"
    if both.keys() <= {*LINEAR, "normal_phase"}:
        why = "a drive along a line has no phase"
    a, alpha, x, y, phi = (spelled(QUANTITIES[name]) for name in (*LINEAR, *ELLIPTICAL))
    return (
        f"{' and '.join(said)}: {why}",
        f"for an ellipse give {x}, {y} and {phi}; for a line {a} and {alpha} alone",
    )
