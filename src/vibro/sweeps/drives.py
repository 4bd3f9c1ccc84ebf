"""Which drive a scene file and a caller give together: along a line, along an ellipse, or a motion."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from vibro.quantities import DRIVES, ELLIPTICAL, LINEAR, QUANTITIES, SCALE, TWO_AXIS

if TYPE_CHECKING:
    from collections.abc import Callable, Collection, Mapping, Sequence

    from vibro.axes import AxisSpec
    from vibro.quantities import Quantity

#: Slot of a motion of steps or samples, which is no quantity.
MOTION: Final = "motion"
#: Quantities of a drive by such a motion.
MOVED: Final = (SCALE,)

# The slots of each drive, and those that make it whole.
_DRIVES: Final = (
    (LINEAR, {*LINEAR}, {*LINEAR}),
    (TWO_AXIS, {*TWO_AXIS, SCALE}, {*ELLIPTICAL[:2]}),
    (MOVED, {*MOVED, MOTION}, {MOTION}),
)


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
        ``LINEAR``, also if nothing is given, ``TWO_AXIS`` or ``MOVED``.
    pair of str, or None
        Message and hint if two drives are given and neither is complete in a higher layer.
    """
    given: dict[str, str] = {}
    for source, specs in layers:
        own = {slot: source for slot in specs if slot in DRIVES}
        both = given | own | ({MOTION: "[motion]"} if MOTION in specs else {})
        if any(both.keys() <= slots for _, slots, _ in _DRIVES):
            given = both
            continue
        for _, slots, whole in _DRIVES:
            if given.keys() <= slots and whole <= {*given, *known}:
                for slot in both.keys() - slots:
                    del specs[slot]
                break
        else:
            return LINEAR, _two_drives(both, spelled)
    named = {*given} or {*known} & {*DRIVES}
    return next((drive for drive, slots, _ in _DRIVES if named <= slots), LINEAR), None


def _two_drives(both: Mapping[str, str], spelled: Callable[[Quantity], str]) -> tuple[str, str]:
    """Return message and hint for quantities of two drives: their sources, and the remedy."""
    said = [
        f"{source} gives {', '.join(_label(slot) for slot in both if both[slot] == source)}"
        for source in dict.fromkeys(both.values())
    ]
    if MOTION in both:
        return f"{' and '.join(said)}: a drive has one motion", "give either the table [motion] or these"
    why = "a drive moves either along a line or along an ellipse"
    if both.keys() <= {*LINEAR, "normal_phase"}:
        why = "a drive along a line has no phase"
    if both.keys() <= {*LINEAR, SCALE}:
        return (
            f"{' and '.join(said)}: a drive along a line has no {_label(SCALE)}",
            f"scale its amplitude, {spelled(QUANTITIES['amplitude'])}",
        )
    a, alpha, x, y, phi = (spelled(QUANTITIES[name]) for name in (*LINEAR, *ELLIPTICAL))
    return (
        f"{' and '.join(said)}: {why}",
        f"for an ellipse give {x}, {y} and {phi}; for a line {a} and {alpha} alone",
    )


def _label(slot: str) -> str:
    return QUANTITIES[slot].label if slot in QUANTITIES else slot
