"""Which drive a scene file and a caller give together: along a line, along an ellipse, or a motion."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from vibro.quantities import DRIVES, ELLIPTICAL, LINEAR, QUANTITIES, SCALE, TWO_AXIS

if TYPE_CHECKING:
    from collections.abc import Callable, Collection, Iterable, Mapping

    from vibro.quantities import Quantity

#: Slot of a motion of steps or samples, which is no quantity.
MOTION: Final = "motion"
#: Quantities of a drive by such a motion.
MOVED: Final = (SCALE,)
#: The slots that each drive may have.
SLOTS: Final = {LINEAR: {*LINEAR}, TWO_AXIS: {*TWO_AXIS, SCALE}, MOVED: {*MOVED, MOTION}}

# Those that make it whole.
_WHOLE: Final = {LINEAR: {*LINEAR}, TWO_AXIS: {*ELLIPTICAL[:2]}, MOVED: {MOTION}}


def drive_given(
    layers: Iterable[Mapping[str, str]], spelled: Callable[[Quantity], str], known: Collection[str]
) -> tuple[tuple[str, ...], tuple[str, str] | None]:
    """Find which drive is given: a layer that makes one whole overrides another drive in those after it.

    Parameters
    ----------
    layers : iterable of mapping of str to str
        Slots and the source of each.
    spelled : callable
        How the caller names a quantity, for messages.
    known : collection of str
        Slots that need not be given.

    Returns
    -------
    tuple of str
        ``LINEAR``, also if nothing is given, ``TWO_AXIS`` or ``MOVED``.
    pair of str, or None
        Message and hint if two drives are given and neither is complete in a higher layer.
    """
    given: dict[str, str] = {}
    for layer in layers:
        both = given | {slot: source for slot, source in layer.items() if slot in (*DRIVES, MOTION)}
        if any(both.keys() <= slots for slots in SLOTS.values()):
            given = both
        elif not any(given.keys() <= SLOTS[d] and whole <= {*given, *known} for d, whole in _WHOLE.items()):
            return LINEAR, _two_drives(both, spelled)
    named = {*given} or {*known} & {*DRIVES}
    return next((drive for drive, slots in SLOTS.items() if named <= slots), LINEAR), None


def _two_drives(both: Mapping[str, str], spelled: Callable[[Quantity], str]) -> tuple[str, str]:
    """Return message and hint for quantities of two drives: their sources, and the remedy."""
    given = [
        f"{source} gives {', '.join(_label(slot) for slot in both if both[slot] == source)}"
        for source in dict.fromkeys(both.values())
    ]
    if MOTION in both:
        return f"{' and '.join(given)}: a drive has one motion", "give either the table [motion] or these"
    why = "a drive moves either along a line or along an ellipse"
    if both.keys() <= {*LINEAR, "normal_phase"}:
        why = "a drive along a line has no phase"
    if both.keys() <= {*LINEAR, SCALE}:
        return (
            f"{' and '.join(given)}: a drive along a line has no {_label(SCALE)}",
            f"scale its amplitude, {spelled(QUANTITIES['amplitude'])}",
        )
    a, alpha, x, y, phi = (spelled(QUANTITIES[name]) for name in (*LINEAR, *ELLIPTICAL))
    return (
        f"{' and '.join(given)}: {why}",
        f"for an ellipse give {x}, {y} and {phi}; for a line {a} and {alpha} alone",
    )


def _label(slot: str) -> str:
    return QUANTITIES[slot].label if slot in QUANTITIES else slot
