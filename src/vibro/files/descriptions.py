"""What scene files and questions of design may hold: every table, every key, and the form of each.

The one description of both: what reads them, the tables of keys in docs/ and the JSON Schema follow from it.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any, Final, NamedTuple

from vibro.core.codes import Regime
from vibro.files import entries as form
from vibro.quantities import BY_COLUMN, QUANTITIES, STANDS_FOR, SWEPT, Quantity, Range
from vibro.units import IN_GRAVITIES, LENGTH, PERCENT, PURE, SPEED, TIME, Kind

if TYPE_CHECKING:
    from vibro.files.entries import Entry, Form

__all__ = ["DESIGN_FILE", "EXAMPLES", "FILES", "SCENE_FILE", "FileKind", "TableKind"]


class TableKind(NamedTuple):
    """A table of a file.

    Attributes
    ----------
    heading : str
        How it begins: ``[scene]``, or ``[[drive]]`` where there may be several.
    meaning : str
        What it says, for people.
    entries : mapping of str to Entry
        What it may hold, by key.
    required : bool
        Whether every such file has it.
    needs : tuple of tuple of str
        Groups of keys of each of which exactly one is given, wherever the table is.
    """

    heading: str
    meaning: str
    entries: dict[str, Entry]
    required: bool = False
    needs: tuple[tuple[str, ...], ...] = ()


class FileKind(NamedTuple):
    """A kind of file: its name, what it is, and its tables by their names."""

    name: str
    meaning: str
    tables: dict[str, TableKind]


#: The nut of examples/safety_nut.toml, and drives of other kinds with about its load, by quantity.
EXAMPLES: Final = {
    "amplitude": 1, "along_amplitude": 1, "normal_amplitude": 0.3, "frequency": 15, "drive_angle": 20,
    "normal_phase": -60, "along_amplitude_2": 0.2, "along_phase_2": 90, "normal_amplitude_2": 0.1,
    "static_friction": 0.74, "friction_ratio": 0.77, "kinetic_friction": 0.57, "trough_length": 600,
}  # fmt: skip

_POSITIVE: Final = Range(0.0, with_low=False)
_RELATIVE: Final = Range(0.0, 100.0)
_ACUTE: Final = Range(0.0, 90.0)
_HALF_TURN: Final = Range(0.0, 180.0, with_high=True)
_SHARE: Final = Range(0.0, 1.0, with_low=False, with_high=True)
_REGIMES: Final = (Regime.FORWARD_SLIP, Regime.BACK_SLIP, Regime.HOPPING)


def _by_key(*entries: Entry) -> dict[str, Entry]:
    return {entry.key: entry for entry in entries}


def _entry(
    of: Form,
    name: str,
    meaning: str = "",
    usual: str = "",
    example: Any = None,
    kind: Kind | None = None,
    allowed: Range | None = None,
) -> Entry:
    """Describe a key by a quantity of a scene, or by one of its own kind, positive unless told."""
    quantity = Quantity(name, kind, allowed=_POSITIVE) if kind else QUANTITIES[name]
    told = replace(quantity, meaning=meaning or quantity.meaning, allowed=allowed or quantity.allowed)
    return form.Entry(of, told, usual, example)


def _harmonics(name: str, meaning: str) -> Entry:
    return form.Entry(form.LIST, replace(QUANTITIES[name], name=f"{name}s", meaning=meaning))


def _value(quantity: Quantity) -> Entry:
    usual = "" if quantity.default is None else f"{quantity.default:g}"
    return form.Entry(form.VALUE, quantity, usual, EXAMPLES.get(quantity.name))


def _axis(quantity: Quantity) -> Entry:
    is_swept = STANDS_FOR.get(quantity.name, quantity.name) in SWEPT
    return form.Entry(form.AXIS if is_swept else form.POINT, quantity)


# fmt: off
#: Of the commands that take a scene.
SCENE_FILE: Final = FileKind("scene", "a scene of vibro: a drive, a trough and a part", {
    "scene": TableKind("[scene]", "the operating point: one value each", _by_key(
        *map(_value, BY_COLUMN.values()),
        _harmonics("along_amplitude", "amplitudes of all harmonics along the trough, from the first on"),
        _harmonics("along_phase", "their phases"),
        _harmonics("normal_amplitude", "amplitudes of all harmonics normal to the trough, from the first on"),
        _harmonics("normal_phase", "their phases"),
    )),
    "map": TableKind("[map]", "what is swept, in place of values of [scene]",
                     _by_key(*map(_axis, BY_COLUMN.values()))),
})

#: Of ``vibro design``. Without static friction a body rests on no trough, not even on a level one.
DESIGN_FILE: Final = FileKind("design", "a question of vibro design: parts, drives and a goal", {
    "scene": TableKind("[scene]", "what is known of the parts and the trough", _by_key(
        _entry(form.FRICTION, "static_friction", "$\\mu_s$ of the parts", "needed", "0.3:0.5",
               allowed=_POSITIVE),
        _entry(form.BAND, "kinetic_friction", "$\\mu_d$; what of the band is above $\\mu_s$ is cut off",
               "it or its ratio is needed,"),
        _entry(form.BAND, "friction_ratio", "$\\mu_d/\\mu_s$", "but with a row that has it", "0.7:0.9"),
        _entry(form.BAND, "trough_angle", "climb of the trough, less steep than where parts slide down", "0"),
        _entry(form.NUMBER, "trough_length", "length of the trough, for traverse times", "", 1200),
        _entry(form.NUMBER, "gravity", "", "9.81"),
        _entry(form.NUMBER, "restitution", "", "0"),
    ), True, (("static_friction",),)),
    "drive": TableKind("[[drive]]", "a drive, and what may be chosen of it", _by_key(
        _entry(form.TEXT, "name", "for tables, each its own", "`drive 1`, ...", kind=PURE),
        _entry(form.LIMITS, "amplitude", "what may be chosen of a line", "it or the stroke", 0.8),
        _entry(form.LIMITS, "stroke", "the same from peak to peak", "is needed of a line"),
        _entry(form.SPAN, "along_amplitude", "of an ellipse, in place of amplitude and drive angle",
               "needed of an ellipse", 1),
        _entry(form.SPAN, "normal_amplitude", "of an ellipse", "needed of an ellipse", 0.3),
        _entry(form.SPAN, "normal_phase", "by which the normal motion of an ellipse leads", "0"),
        _entry(form.CHOICES, "frequency", "what may be chosen", "needed", "15:25"),
        _entry(form.CHOICES, "drive_angle", "what may be chosen of a line", "needed of a line", "10:40"),
        _entry(form.NUMBER, "acceleration", "largest along the path, over $g$: $A\\omega^2/g$ of a line",
               "no limit", kind=IN_GRAVITIES),
    ), True, (("frequency_hz",),)),
    "drift": TableKind("[drift]", "how far drive and trough may be off, either way", _by_key(
        _entry(form.NUMBER, "amplitude", "how far the drive may be off what was chosen, either way", "0",
               kind=PERCENT, allowed=_RELATIVE),
        _entry(form.NUMBER, "frequency", "the same", "0", kind=PERCENT, allowed=_RELATIVE),
        _entry(form.NUMBER, "drive_angle", "the same of a line", "0"),
        _entry(form.NUMBER, "trough_angle", "the same of the trough", "0", allowed=_ACUTE),
        _entry(form.NUMBER, "normal_phase", "the same of an ellipse", "0", allowed=_HALF_TURN),
    )),
    "goal": TableKind("[goal]", "what every part is to do", _by_key(
        _entry(form.NUMBER, "speed", "mean speed, at least", "one of both", 80, SPEED),
        _entry(form.NUMBER, "traverse_time", "time over the trough, at most", "is needed", kind=TIME),
        _entry(form.NUMBER, "impact_speed", "largest normal speed of landings; for designs that hop",
               "no limit", kind=SPEED),
        _entry(form.NUMBER, "flight_fraction", "largest share of the time in flight; for designs that hop",
               "no limit", kind=PURE, allowed=_SHARE),
        _entry(form.one_of({regime.label: regime for regime in _REGIMES}), "highest_regime",
               "what parts may do at most", "`back-slip`", kind=PURE),
    ), True, (("speed_mm_s", "traverse_time_s"),)),
    "part": TableKind("[part]", "what is known of tipping", _by_key(
        _entry(form.NUMBER, "half_base", "from the centre of mass to the edge over which the part would tip",
               "both, or no table:", 6, LENGTH),
        _entry(form.NUMBER, "centre_height", "height of the centre of mass", "it may tip", 8, LENGTH),
    ), needs=(("half_base_mm",), ("centre_height_mm",))),
})
# fmt: on

#: By name.
FILES: Final = {kind.name: kind for kind in (SCENE_FILE, DESIGN_FILE)}
