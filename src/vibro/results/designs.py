"""What inverse design finds: guarantees over a box of bands, amplitude windows, and designs."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, fields
from functools import partial
from typing import TYPE_CHECKING, Any, Final, Literal, NamedTuple

from vibro.html_tables import Shown, amount
from vibro.quantities import BY_COLUMN, QUANTITIES
from vibro.reals import rounded, shielded
from vibro.results.drawing import drawn
from vibro.units import SPEED

if TYPE_CHECKING:
    from collections.abc import Mapping
    from os import PathLike

    from matplotlib.figure import Figure

    from vibro.core.codes import Regime
    from vibro.reals import Floats


#: Proofs of bounds that are guaranteed.
GUARANTEED: Final = ("corners", "proved")


class Interval(NamedTuple):
    """Closed interval of nominal amplitudes, or of scales of a motion, that guarantee a speed.

    Attributes
    ----------
    low, high : float
        Ends of the interval: amplitudes [m], or scales [1].
    low_set_by, high_set_by : str
        The constraint at each end: ``speed``, ``onset``, ``back slip``, ``hop``, ``limit`` or ``tip``;
        ``unconfirmed`` where the search for slower bodies was not finished.
    """

    low: float
    high: float
    low_set_by: str
    high_set_by: str


class Certificate(NamedTuple):
    """Boxes that cover an uncertainty set, each with a bound on the mean speeds in it.

    Points of a box whose kinetic friction is outside its band do not belong to the set.

    Attributes
    ----------
    low, high : mapping of str to (n,) array
        Lower and upper ends of the boxes, by quantity: ``load``, which is w^2 / g times the amplitude of a
        line [1] or times the common factor of both amplitudes of an ellipse [1/m]; ``drive_angle`` [rad], or
        ``along_amplitude``, ``normal_amplitude`` [m] and ``normal_phase`` [rad]; ``trough_angle`` [rad],
        ``static_friction`` and ``kinetic_friction`` [1].
    bound : (n,) array
        Bound on the mean speeds in each box: a lower one for ``Guarantee.certificate_min``, an upper one for
        ``certificate_max`` [m/s].
    """

    low: Mapping[str, Floats]
    high: Mapping[str, Floats]
    bound: Floats


@dataclass(frozen=True, eq=False, kw_only=True)
class Guarantee(Shown):
    """Bounds on speed and regime over a box of bands, for bodies that start from rest.

    Attributes
    ----------
    speed_min, speed_max : float
        Bounds on the mean speed of every body, guaranteed where ``proof_min``, or ``proof_max``, is
        ``corners`` or ``proved``; else the extreme speed that was found [m/s]. -inf and inf if somewhere in
        the box a body runs away or has no steady motion.
    found_min, found_max : float
        Speeds of the slowest and the fastest body that were found [m/s]: infimum and supremum are between
        these and the bounds.
    min_at, max_at : mapping of str to float
        Points of the box where these bodies are, by the fields of ``Scene``, in SI units and radians.
    min_limit, max_limit : str
        Side of the jump if their speed is a one-sided limit at a jump; empty if the speed is attained.
    regimes : frozenset of Regime
        Regimes that occur in the box.
    proof_min, proof_max : str
        How each bound is known: ``corners`` (the speed is monotone, so a corner of the box is extreme),
        ``proved`` (by boxes that cover the set), ``searched`` (nothing is proved) or ``sampled`` (bodies
        hop).
    proved_min, proved_max : float
        Proved lower and upper bounds on the speed of every body [m/s]; NaN if bodies hop or the drive is
        neither a line nor an ellipse, infinite if the proof failed.
    certificate_min, certificate_max : Certificate or None
        Boxes that prove these bounds; None for ``corners`` and where nothing is proved.
    coexists : bool
        Whether a disturbed body can settle in another cycle at a point that was computed.
    samples : int
        Number of hopping bodies, spread evenly over the box, whose speeds are known; all of them lie within
        ``found_min`` and ``found_max``.
    excluded : int
        Number of sampled hopping bodies whose speed could not be found; they are left out.
    """

    speed_min: float
    speed_max: float
    found_min: float
    found_max: float
    min_at: Mapping[str, float]
    max_at: Mapping[str, float]
    min_limit: str
    max_limit: str
    regimes: frozenset[Regime]
    proof_min: str
    proof_max: str
    proved_min: float
    proved_max: float
    certificate_min: Certificate | None = field(repr=False)
    certificate_max: Certificate | None = field(repr=False)
    coexists: bool
    samples: int
    excluded: int

    def _table(self) -> tuple[str, list[list[str]], list[str]]:
        proofs = (self.proof_min, self.proof_max)
        bounds = [
            amount(rounded(float(SPEED.from_si(x)), 6, down=not i), SPEED.unit) if proof in GUARANTEED else ""
            for i, (x, proof) in enumerate(zip((self.speed_min, self.speed_max), proofs, strict=True))
        ]
        found = [amount(SPEED.from_si(x), SPEED.unit) for x in (self.found_min, self.found_max)]
        shared = [QUANTITIES[name] for name in self.min_at if name in QUANTITIES and name in self.max_at]
        ends = (self.min_at, self.max_at)
        places = [[q.label, *(amount(q.from_si(at[q.name]), q.unit) for at in ends)] for q in shared]
        rows = [
            ["guaranteed", *bounds],
            ["proof", *proofs],
            ["found", *found],
            ["limit", self.min_limit, self.max_limit],
            *places,
            ["regimes", ", ".join(regime.label or "none" for regime in sorted(self.regimes))],
            ["other cycles", "a disturbed body can settle elsewhere" if self.coexists else "none found"],
            ["sampled", f"{self.samples} hopping bodies" if self.samples else ""],
            ["left out", f"{self.excluded} hopping points without a speed" if self.excluded else ""],
        ]
        return "guarantee", rows, ["", "slowest", "fastest"]


class _DesignColumn(NamedTuple):
    """One column of a table of designs: its name with the unit, the unit, its meaning, and whose it is.

    ``of`` names the kinds of drives that have it; empty where all do.
    """

    name: str
    unit: str
    meaning: str
    of: str

    @property
    def heading(self) -> str:
        """Name in words, and the unit."""
        suffix = f"_{self.unit.lower().replace('/', '_')}"
        name = self.name.removesuffix(suffix).replace("_", " ")
        return f"{name} [{self.unit}]" if self.unit else name


def _column(unit: str, meaning: str, of: str = "", **default: Any) -> Any:
    return field(metadata={"unit": unit, "meaning": meaning, "of": of}, **default)


_optional = partial(_column, default=None)
_line, _stroke, _ellipse, _motion, _machine, _straight, _amplitude = (
    partial(_optional, of=kinds)
    for kinds in ("line", "stroke", "ellipse", "motion", "machine", "line stroke", "line ellipse")
)


@dataclass(frozen=True, kw_only=True)
class Design:
    """One design: settings of one drive and what they guarantee, in the units of the attributes' names.

    The attributes are the columns of tables and the keys of JSON, which :doc:`/reference/columns` lists under
    "Designs"; those that do not apply are None.
    """

    drive: str = _column("", "name of the drive")
    highest_regime: str = _column("", "highest regime allowed")
    design: str = _column("", "gentlest, fastest or safest")
    setting_percent: float | None = _machine("%", "setting of a machine: its force over that at 100 %")
    pack: str | None = _machine("", "name of its spring pack")
    natural_hz: float | None = _machine("Hz", "natural frequency of the empty machine")
    amplitude_empty_mm: float | None = _machine("mm", "amplitude of its empty trough, at the middle voltage")
    amplitude_least_mm: float | None = _machine(
        "mm", "smallest amplitude within the bands of voltage and filling"
    )
    amplitude_most_mm: float | None = _machine("mm", "largest amplitude within these bands")
    second_harmonic_percent: float | None = _machine(
        "%", "largest second harmonic that the filling causes in the trough's motion, over the amplitude"
    )
    speed_second_harmonic_mm_s: float | None = _machine(
        "mm/s", "least speed of sampled parts with that harmonic in the motion"
    )
    operating_points: int | None = _machine("", "largest number of operating points for one filling")
    amplitude_mm: float | None = _line("mm", "nominal amplitude; of a machine between the last two")
    stroke_mm: float | None = _stroke("mm", "nominal stroke, where the question gives strokes")
    frequency_hz: float | None = _optional("Hz", "nominal frequency")
    drive_angle_deg: float | None = _straight("deg", "nominal drive angle")
    along_amplitude_mm: float | None = _ellipse("mm", "nominal amplitude of an ellipse along the trough")
    normal_amplitude_mm: float | None = _ellipse("mm", "nominal amplitude of an ellipse normal to it")
    normal_phase_deg: float | None = _ellipse("deg", "nominal phase lead of the normal motion")
    motion_scale: float | None = _motion("", "nominal scale of a given motion")
    acceleration_g: float | None = _optional("g", "nominal peak acceleration of the drive over gravity")
    speed_min_mm_s: float | None = _optional(
        "mm/s", "guaranteed speed where `proof` is corners or proved, else that of the slowest part found"
    )
    speed_proved_mm_s: float | None = _optional("mm/s", "proved lower bound on the speed of every part")
    speed_found_mm_s: float | None = _optional("mm/s", "speed of the slowest part that was found")
    speed_nominal_mm_s: float | None = _optional("mm/s", "speed in the middle of all bands")
    speed_max_mm_s: float | None = _optional(
        "mm/s", "speed that no part exceeds where this is proved, else that of the fastest part found"
    )
    traverse_time_max_s: float | None = _optional("s", "trough length over `speed_min_mm_s`")
    amplitude_low_mm: float | None = _amplitude(
        "mm", "lower end of the window: nominal amplitude, of an ellipse along the trough"
    )
    amplitude_high_mm: float | None = _amplitude(
        "mm", "upper end of the window, within which a search finds no part that misses the goal"
    )
    stroke_low_mm: float | None = _stroke("mm", "lower end of the window of strokes")
    stroke_high_mm: float | None = _stroke("mm", "upper end of the window of strokes")
    motion_scale_low: float | None = _motion("", "lower end of the window of scales")
    motion_scale_high: float | None = _motion("", "upper end of the window of scales")
    low_set_by: str | None = _optional("", "constraint at the lower end")
    high_set_by: str | None = _optional("", "constraint at the upper end")
    margin: float | None = _optional(
        "", "factor by which all bands and drifts, but that of restitution, may grow about their middles"
    )
    throw_number_max: float | None = _optional("", "largest throw number in the box")
    set_by: str | None = _optional("", "active constraint of the design")
    frequency_needed_hz: float | None = _optional("Hz", "frequency of the nearest drive that meets the goal")
    amplitude_needed_mm: float | None = _amplitude("mm", "its amplitude, or that along the trough")
    stroke_needed_mm: float | None = _stroke("mm", "its stroke")
    motion_scale_needed: float | None = _motion("", "its scale")
    proof: str | None = _optional("", "corners, proved, searched or sampled")
    restitution_low: float | None = _optional("", "least restitution of its parts, where some hop")
    restitution_high: float | None = _optional("", "largest restitution of its parts, where some hop")
    restitution_assumed: bool | None = _optional("", "whether that band is assumed, as none is given")
    coexists: bool | None = _optional("", "whether a disturbed part can settle in another cycle")
    samples: int | None = _optional(
        "", "number of sampled parts that hop, spread evenly; none of them is slower"
    )
    excluded: int | None = _optional("", "number of sampled parts without a known speed, left out")

    @property
    def is_guaranteed(self) -> bool:
        """Whether ``speed_min_mm_s`` is proved for every part."""
        return self.proof in GUARANTEED

    @property
    def restitution(self) -> str | None:
        """Band of restitution of its numbers, and whether it is assumed; None where no part hops."""
        low, high = self.restitution_low, self.restitution_high
        if low is None or high is None:
            return None
        band = f"{low:.15g}" if low == high else f"{low:.15g}:{high:.15g}"
        return f"{band} assumed" if self.restitution_assumed else band

    @property
    def nominal(self) -> float | None:
        """Amplitude or stroke [mm], or scale [1], that windows and pictures vary.

        Of an ellipse the amplitude along the trough, or the normal one if that is 0.
        """
        given = (self.motion_scale, self.stroke_mm, self.amplitude_mm, self.along_amplitude_mm)
        return next(filter(None, given), self.normal_amplitude_mm)

    @property
    def window(self) -> tuple[float, float] | None:
        """Ends of the window that keeps the guarantee: amplitudes or strokes [mm], or scales [1]; or None."""
        low, high = self.amplitude_low_mm, self.amplitude_high_mm
        if self.stroke_mm is not None:
            low, high = self.stroke_low_mm, self.stroke_high_mm
        elif self.motion_scale is not None:
            low, high = self.motion_scale_low, self.motion_scale_high
        return None if low is None or high is None else (low, high)


#: The columns of a table of designs, in order, of all kinds of drives.
DESIGN_COLUMNS: Final = tuple(_DesignColumn(f.name, **f.metadata) for f in fields(Design))


# The column that each design of a kind of drive has; without a design the columns are those of lines.
_KINDS: Final = {
    "line": "amplitude_mm", "stroke": "stroke_mm", "ellipse": "along_amplitude_mm", "motion": "motion_scale",
    "machine": "setting_percent",
}  # fmt: skip


def _cell(name: str, value: Any) -> str:
    """Write a value of a column; settings hold with all their digits alone."""
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, float):
        return f"{value:.15g}" if name in BY_COLUMN else amount(value)
    return "" if value is None else str(value)


@dataclass(frozen=True, eq=False)
class DesignResult(Shown):
    """Answer to a design question.

    Attributes
    ----------
    met : bool
        Whether some drive guarantees the goal within its highest regime.
    designs : tuple of Design
        The gentlest, the fastest and the safest design of every drive and regime; those within the goal's
        highest regime first.
    settings : tuple of tuple of float, or None
        For each design the motion of the trough in full precision: amplitudes along the trough and normal to
        it [m], phase lead of the normal motion [rad] and frequency [Hz]; of a given motion its scale [1] and
        the frequency [Hz].
    covered : tuple of pair of float, or None
        For each design of a machine the smallest and the largest amplitude that it covers, over that of the
        empty trough [1]; an empty tuple without machines.
    spec : object
        The checked question, from which the designs are drawn.
    """

    met: bool
    designs: tuple[Design, ...]
    settings: tuple[tuple[float, ...] | None, ...]
    covered: tuple[tuple[float, float] | None, ...] = ()
    spec: Any = field(default=None, repr=False)

    @shielded
    def draw(
        self,
        name: Literal["speed", "regime", "band"] = "speed",
        path: str | PathLike[str] | None = None,
        *,
        design: Design | None = None,
    ) -> Figure:
        """Draw what the settings around a design do to all parts, as ``vibro design -o`` does.

        Parameters
        ----------
        name : {"speed", "regime", "band"}, optional
            The speed of the slowest part over amplitude and frequency, with the settings that meet the goal;
            the regimes of all parts; or the speeds of all parts over the amplitude.
        path : str or path, optional
            File to write, by its ending: ``.png``, ``.svg`` or ``.pdf``; an existing one is replaced.
        design : Design, optional
            One of ``designs``. By default the safest of all drives; the gentlest where every value is known
            exactly, and the fastest where no drive meets the goal.

        Returns
        -------
        matplotlib.figure.Figure
            No window opens.

        Raises
        ------
        InputError
            If there is no such picture, or the design guarantees no speed.
        FileError
            If the file cannot be written.
        """
        return drawn(self, name, path, design=design)

    @property
    def columns(self) -> tuple[_DesignColumn, ...]:
        """Columns of the table of designs; those of a kind of drive only if a design uses it."""
        known = [k for k, name in _KINDS.items() if any(getattr(d, name) is not None for d in self.designs)]
        kinds = set(known or ["line"])
        return tuple(column for column in DESIGN_COLUMNS if not column.of or kinds & {*column.of.split()})

    def _table(self) -> tuple[str, list[list[str]], list[str]]:
        columns = [c for c in self.columns if any(getattr(d, c.name) is not None for d in self.designs)]
        rows = [[_cell(c.name, getattr(d, c.name)) for c in columns] for d in self.designs]
        return f"designs: the goal is {'met' if self.met else 'not met'}", rows, [c.heading for c in columns]

    def to_dict(self) -> dict[str, Any]:
        """Return the answer as ``vibro design --json`` prints it.

        Returns
        -------
        dict
            ``met``, and ``designs``: one mapping of columns to values per design.
        """
        designs = [{c.name: getattr(d, c.name) for c in self.columns} for d in self.designs]
        return {"met": self.met, "designs": designs}


@dataclass(frozen=True, eq=False, kw_only=True)
class SettingFields:
    """What parts do at settings of a drive over amplitude and frequency, at one drive angle.

    Of an ellipse, at one shape of it: the amplitude is that along the trough, the other one in proportion. Of
    a given motion the scale stands for the amplitude [1].

    Patterns and regimes depend on amplitude and frequency through the load G = A w^2 / g alone, and speeds at
    the same load go with 1/f; drifts in percent keep that. So numbers over the load suffice.

    Attributes
    ----------
    amplitude : str
        Which amplitude it is, or the stroke: a name of a quantity.
    limits, most_load : pair of float, float
        Amplitudes, and the largest load, that the drive can reach.
    amplitudes, frequency_hz : pair of float
        Nominal settings to be shown, both ends > 0: those of the drive, and a margin on every side. The
        amplitude's scale is logarithmic.
    load : (n,) array
        Nominal loads, ascending, that cover all shown settings; a load appears twice where numbers jump [1].
    speed_min : (n,) array
        Speed of the slowest of some parts times nominal frequency; NaN or -inf if one has none [mm/s Hz].
    begins : mapping of Regime to pair of float
        Of forward slip, back slip and hopping the nominal load from which the first, and from which the last
        part of the box is in that regime or in a higher one; inf where that never happens.
    tips : float
        Nominal load from which the first part that must stay upright lifts an edge; inf without such parts.
    impact_speed : (n,) array or None
        Largest normal speed of landings times nominal frequency, 0 in contact; None without such a limit
        [mm/s Hz].
    flight_fraction : (n,) array or None
        Largest share of the time in flight, 0 in contact; None without such a limit.
    """

    amplitude: str
    limits: tuple[float, float]
    most_load: float
    amplitudes: tuple[float, float]
    frequency_hz: tuple[float, float]
    load: Floats
    speed_min: Floats
    begins: Mapping[Regime, tuple[float, float]]
    tips: float = math.inf
    impact_speed: Floats | None = None
    flight_fraction: Floats | None = None


@dataclass(frozen=True, eq=False, kw_only=True)
class SpeedBand:
    """Speeds over the nominal amplitude at one frequency and drive angle.

    Attributes
    ----------
    amplitude : (n,) array
        Ascending, in the unit of its quantity, from where no part moves to beyond the design and what the
        goal allows.
    speed_min, speed_nominal, speed_max : (n,) array
        Of the slowest part, of the part in the middle of all bands, and of the fastest part; not finite where
        unknown, or where a part runs away [mm/s].
    window : pair of float, or None
        Nominal amplitudes around the design that keep the goal.
    """

    amplitude: Floats
    speed_min: Floats
    speed_nominal: Floats
    speed_max: Floats
    window: tuple[float, float] | None
