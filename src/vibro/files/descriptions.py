"""Describe the tables and keys of scene files and design questions, and the form of each value.

The readers, the tables of keys in docs/ and the JSON Schema are derived from this description.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any, Final, NamedTuple

from vibro import quantities, units
from vibro.core.codes import Regime
from vibro.files import entries as form
from vibro.files.entries import Table, TableKind
from vibro.quantities import BY_COLUMN, MACHINE, POSITIVE, QUANTITIES, SWEPT, ZERO_OR_MORE, Quantity, Range
from vibro.units import FORCE, FREQUENCY, LENGTH, PERCENT, PURE, SPEED, STIFFNESS

if TYPE_CHECKING:
    from vibro.errors import Problems
    from vibro.files.entries import Entry, Form
    from vibro.units import Kind


class FileKind(NamedTuple):
    """A kind of file: its name, its description, the function that reads it, and its tables by name."""

    name: str
    meaning: str
    function: str
    tables: dict[str, TableKind]

    def table(self, name: str, given: Any, problems: Problems, place: int = 0) -> Table:
        """Read a table; ``place`` is its number, if it is repeated."""
        kind = self.tables[name]
        return Table(kind, given, problems, f"{kind.heading} {place or ''}".rstrip(), self.tables.values())


#: Example values by quantity: the nut of examples/safety_nut.toml, and other drives of about its load.
EXAMPLES: Final = {
    "amplitude": 1, "along_amplitude": 1, "normal_amplitude": 0.3, "frequency": 15, "drive_angle": 20,
    "normal_phase": -60, "along_amplitude_2": 0.2, "along_phase_2": 90, "normal_amplitude_2": 0.1,
    "static_friction": 0.74, "friction_ratio": 0.77, "kinetic_friction": 0.57, "trough_length": 600,
}  # fmt: skip

#: Kinds of machines, as files spell them.
KINDS: Final = ("unbalance", "magnet", "exciter", "crank", "rod", "measured")

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
    """Describe a key by a quantity of a scene, or by a quantity of its own, which is positive by default."""
    quantity = Quantity(name, kind, allowed=POSITIVE) if kind else QUANTITIES[name]
    told = replace(quantity, meaning=meaning or quantity.meaning, allowed=allowed or quantity.allowed)
    return form.Entry(of, told, usual, example)


def _of(kinds: str, *described: Any, **others: Any) -> Entry:
    """Describe a key of some kinds of machine; those with a ``!`` need it."""
    entry = _entry(*described, **others)
    all_of, needed = (
        tuple(kind.rstrip("!") for kind in kinds.split() if kind.endswith(end)) for end in ("", "!")
    )
    both = " and ".join(filter(None, [", ".join(needed[:-1]), *needed[-1:]]))
    usual = "; ".join(filter(None, [f"needed of {both}" if needed else "", entry.usual]))
    return entry._replace(usual=usual, kinds=all_of, needed=needed)


def _value(quantity: Quantity) -> Entry:
    quantity = quantities.of_part(quantity, is_clamped=True)  # other keys decide whether a part is clamped
    usual = "" if quantity.default is None else f"{quantity.default:g}"
    return form.Entry(form.VALUE, quantity, usual, EXAMPLES.get(quantity.name))


def _axis(quantity: Quantity) -> Entry:
    is_swept = quantities.STANDS_FOR.get(quantity.name, quantity.name) in SWEPT
    return _value(quantity)._replace(form=form.AXIS if is_swept else form.VALUE, usual="", example=None)


# fmt: off
_MOTION: Final = tuple(
    form.Entry(of, Quantity(f"{way}_{key}", meaning=meaning))
    for key, of, along in (
        ("harmonics_mm_deg", form.HARMONICS, "amplitude [mm] and phase [deg] of each harmonic along"),
        ("steps", form.STEPS, "shares of the period, and the accelerations in them [m/s^2]"),
        ("samples_m_s2", form.ACCELERATIONS, "accelerations of one period along, equally spaced"),
        ("samples_mm", form.DISPLACEMENTS, "displacements of one period along, equally spaced"),
    )
    for way, meaning in (("along", along), ("normal", "the same normal to the trough"))
)
_CALIBRATION: Final = TableKind(
    "calibration = { amplitude_mm = 0.35, frequency_hz = 50 }", "one measured amplitude", _by_key(
        _entry(form.NUMBER, "amplitude", "measured amplitude of the empty trough", example=0.35),
        _entry(form.NUMBER, "frequency", "frequency at which it was measured", example=50),
        _entry(form.NUMBER, "setting", "setting at which it was measured", "100"),
        _entry(form.NUMBER, "voltage", "voltage at which it was measured", "100"),
    ), needs=(("amplitude_mm",), ("frequency_hz",)))
_PACK: Final = TableKind("[[machine.pack]]", "a spring pack", _by_key(
    _entry(form.TEXT, "name", "name of the spring pack", example="6 leaves", kind=PURE),
    _entry(form.NUMBER, "natural", "natural frequency of the empty machine with it", example=55.6),
), needs=(("name",), ("natural_hz",)))
_SPRUNG: Final = "magnet exciter rod"
_TURNING: Final = "unbalance exciter"
#: Keys of a machine, in ``[machine]`` of a scene file and in ``[[drive]]`` of a design question.
MACHINE_KEYS: Final = (
    _entry(form.one_of({kind: kind for kind in KINDS}), "kind", "what drives the trough", "needed",
           "magnet", kind=PURE),
    _of("magnet! exciter! rod! measured!", form.NUMBER, "trough_mass",
        "mass of the empty trough and of what moves with it", "", 6, units.MASS),
    _of("magnet! exciter! measured", form.MASS_OR_FLOOR, "counter_mass",
        "mass on the other side of the springs, or the floor", "", 12, units.MASS),
    _of("unbalance!", form.NUMBER, "vibrating_mass", "whole mass on the mounts, with its motors", "", 120,
        units.MASS),
    _of(_SPRUNG, form.NUMBER, "natural", "", "needed of magnet, exciter and rod, or packs", 55.6),
    _of(_SPRUNG, form.table_of("table, or list of tables", _PACK, several=True), "pack",
        "spring packs that may be fitted: their names and natural_hz", "none", kind=PURE),
    _of("unbalance magnet! exciter! rod!", form.NUMBER, "damping_ratio",
        "damping over critical damping, of the empty machine", "0 of unbalance", 0.015, PURE,
        Range(0.0, 1.0)),
    _of("magnet", form.NUMBER, "force", "amplitude of the magnet's force at 100 %",
        "needed of magnet, or the calibration", kind=FORCE),
    _of("magnet", form.table_of("table", _CALIBRATION), "calibration",
        "one measured amplitude, in place of a force: amplitude_mm, frequency_hz, setting_percent,"
        " voltage_percent", "needed of magnet, or the force", kind=PURE),
    _of("magnet measured", form.NUMBER, "voltage_exponent",
        "exponent of the force over the voltage; 1 for a piezo drive", "2", kind=PURE),
    _of("magnet exciter", form.NUMBER, "base_stiffness", "stiffness of the counter mass's own mounts", "0",
        kind=STIFFNESS, allowed=ZERO_OR_MORE),
    _of("magnet measured", form.NUMBER, "gap",
        "largest relative amplitude of trough and counter mass, at which they strike", "no limit",
        kind=LENGTH),
    _of("unbalance", form.NUMBER, "mount", "natural frequency on the mounts", "0: infinitely soft",
        kind=FREQUENCY, allowed=ZERO_OR_MORE),
    _of(_TURNING, form.COUNT, "motors", "number of motors", "needed with values of one motor", 2, PURE,
        replace(POSITIVE, low=1.0)),
    _of(_TURNING, form.NUMBER, "static_moment", "eccentric mass times its radius, of one motor",
        "needed of unbalance and exciter, or one of the two below", 95, units.MOMENT),
    _of(_TURNING, form.NUMBER, "working_moment",
        "vibrating mass times amplitude, or stroke, of all motors together", kind=units.WORKING_MOMENT),
    _of(_TURNING, form.one_of({"amplitude": 1.0, "stroke": 0.5}), "working_moment_is",
        "whether the working moment is taken with amplitude or stroke", "needed with it", "stroke", PURE),
    _of(_TURNING, form.NUMBER, "centrifugal_force", "centrifugal force of one motor, at the speed below",
        kind=FORCE),
    _of(_TURNING, form.NUMBER, "at", "speed of that force", "needed with it", 25, FREQUENCY),
    _of(_TURNING, form.NUMBER, "at", "the same", "needed with it", 1500, units.ROTATION),
    _of("crank! rod!", form.NUMBER, "crank_radius", "radius of the crank", "", 5, LENGTH),
    _of("rod!", form.NUMBER, "rod_stiffness", "stiffness of the elastic rod", "", 200000, STIFFNESS),
    _of("measured!", form.POINTS, "points", "measured frequency [Hz] and amplitude [mm] of the empty trough",
        "", "points.csv", PURE),
    _of("measured!", form.one_of({"constant": "constant", "square": "square"}), "law",
        "how the force of the measured machine depends on the frequency", "", "constant", PURE),
    _of("unbalance magnet exciter measured", form.BAND, "setting", "", "100"),
    _of("magnet measured", form.BAND, "voltage", "", "100"),
    _entry(form.BAND, "filling", "", "0"),
    _entry(form.BAND, "added_mass_share", "share of the filling's mass that moves with the trough",
           "computed", kind=PURE, allowed=Range(-10.0, 10.0)),
    _entry(form.BAND, "added_damping_share", "share of the filling's mass that acts as damping",
           "computed, or 0 if the mass share is given", kind=PURE, allowed=ZERO_OR_MORE),
)

#: Input of the commands that take a scene.
SCENE_FILE: Final = FileKind("scene", "a scene of vibro: a drive, a trough and a part", "read_scene", {
    "scene": TableKind("[scene]", "the operating point: one value each", _by_key(
        *(_value(quantity) for quantity in BY_COLUMN.values() if quantity.name not in MACHINE),
        *(
            form.Entry(form.LIST, replace(QUANTITIES[f"{way}_{what}"], name=f"{way}_{what}s", meaning=told))
            for way, where in (("along", "along the trough"), ("normal", "normal to the trough"))
            for what, told in (("amplitude", f"amplitudes of all harmonics {where}, from the first on"),
                               ("phase", f"phases of all harmonics {where}"))
        ),
        _entry(form.NUMBER, "normal_force", "constant normal force on a clamped part", kind=FORCE),
        _entry(form.NUMBER, "mass", "mass of the clamped part", kind=units.MASS),
    )),
    "motion": TableKind("[motion]", "how the trough moves, in place of a drive in [scene]",
                        _by_key(*_MOTION)),
    "machine": TableKind("[machine]", "what drives the trough, in place of an amplitude in [scene]",
                         _by_key(*MACHINE_KEYS), needs=(("kind",),)),
    "map": TableKind("[map]", "axes of a sweep, instead of values in [scene] and [machine]",
                     _by_key(*map(_axis, BY_COLUMN.values()))),
})

# Of a machine in a question settings may be chosen, as amplitudes may.
_CHOSEN: Final = _of("unbalance magnet exciter measured", form.LIMITS, "setting",
                     "settings of a machine that may be chosen", "up to 100, of a crank 100", "20:100")

#: Input of ``vibro design``; static friction must be positive, since without it no body rests.
DESIGN_FILE: Final = FileKind("design", "a design question: parts, drives and a goal", "design", {
    "scene": TableKind("[scene]", "what is known of the parts and the trough", _by_key(
        _entry(form.FRICTION, "static_friction", "static friction of the parts", "needed", "0.3:0.5",
               allowed=POSITIVE),
        _entry(form.BAND, "kinetic_friction", "kinetic friction; values above static friction are left out",
               "needed, or its ratio, unless a row of the catalogue has it"),
        _entry(form.BAND, "friction_ratio", "kinetic over static friction",
               "needed, or kinetic friction", "0.7:0.9"),
        _entry(form.BAND, "trough_angle", "inclination of the trough, too small for parts to slide down",
               "0"),
        _entry(form.NUMBER, "trough_length", "length of the trough, for traverse times", "", 1200),
        _entry(form.NUMBER, "gravity", "", "9.81"),
        _entry(form.NUMBER, "restitution", "", "0"),
    ), True, (("static_friction",),)),
    "drive": TableKind("[[drive]]", "a drive, along a line, an ellipse, in a given motion or of a machine,"
                       " and what may be chosen", _by_key(
        _entry(form.TEXT, "name", "name for tables, each its own", "`drive 1`, ...", kind=PURE),
        _entry(form.LIMITS, "amplitude", "amplitude along a line", "needed of a line, or the stroke", 0.8),
        _entry(form.LIMITS, "stroke", "twice that amplitude", "needed of a line, or the amplitude"),
        _entry(form.SPAN, "along_amplitude", "amplitude of an ellipse along the trough",
               "needed of an ellipse", 1),
        _entry(form.SPAN, "normal_amplitude", "amplitude of an ellipse normal to the trough",
               "needed of an ellipse", 0.3),
        _entry(form.SPAN, "normal_phase", "phase lead of the normal motion of an ellipse", "0"),
        *(_CHOSEN if entry.key == _CHOSEN.key else entry for entry in MACHINE_KEYS),
        *_MOTION,
        _entry(form.SPAN, "motion_scale", "factor by which that motion is multiplied", "1"),
        _entry(form.CHOICES, "frequency", "frequencies that may be chosen", "needed", "15:25"),
        _entry(form.CHOICES, "drive_angle", "drive angles that may be chosen", "needed of a line", "10:40"),
        _entry(form.NUMBER, "acceleration", "largest acceleration along the path, over gravity", "no limit",
               kind=units.IN_GRAVITIES),
    ), True, (("frequency_hz",),)),
    "drift": TableKind("[drift]", "drift of drive and trough from their chosen values, up and down", _by_key(
        _entry(form.NUMBER, "amplitude", "drift of all amplitudes", "0", kind=PERCENT, allowed=_RELATIVE),
        _entry(form.NUMBER, "frequency", "drift of the frequency", "0", kind=PERCENT, allowed=_RELATIVE),
        _entry(form.NUMBER, "drive_angle", "drift of the drive angle, of a line", "0"),
        _entry(form.NUMBER, "trough_angle", "drift of the trough angle", "0", allowed=_ACUTE),
        _entry(form.NUMBER, "normal_phase", "drift of the phase, of an ellipse", "0", allowed=_HALF_TURN),
    )),
    "goal": TableKind("[goal]", "requirements for every part", _by_key(
        _entry(form.NUMBER, "speed", "mean speed, at least", "needed, or the time", 80, SPEED),
        _entry(form.NUMBER, "traverse_time", "time over the trough's length, at most",
               "needed, or the speed", kind=units.TIME),
        _entry(form.NUMBER, "impact_speed", "largest normal speed of landings; for designs that hop",
               "no limit", kind=SPEED),
        _entry(form.NUMBER, "flight_fraction", "largest share of the time in flight; for designs that hop",
               "no limit", kind=PURE, allowed=_SHARE),
        _entry(form.one_of({regime.label: regime for regime in _REGIMES}), "highest_regime",
               "highest regime that any part may reach", "`back-slip`", kind=PURE),
    ), True, (("speed_mm_s", "traverse_time_s"),)),
    "part": TableKind("[part]", "stability of a part; without this table parts may tip", _by_key(
        _entry(form.NUMBER, "half_base", "from the centre of mass to the edge over which the part would tip",
               "needed", 6, LENGTH),
        _entry(form.NUMBER, "centre_height", "height of the centre of mass", "needed", 8, LENGTH),
    ), needs=(("half_base_mm",), ("centre_height_mm",))),
})
# fmt: on

#: All kinds of file, by name.
FILES: Final = {kind.name: kind for kind in (SCENE_FILE, DESIGN_FILE)}
