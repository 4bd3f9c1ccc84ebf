"""Results of a steady cycle: every field described once, in the order of a table's columns.

Containers, CSV, JSON, data frames, sidecars and the reference follow from these descriptions.
"""

from __future__ import annotations

from dataclasses import dataclass, field, fields
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from vibro.core.codes import MODELS, Regime, Status, pattern_texts
from vibro.errors import SceneError
from vibro.html_tables import Shown, counts, span
from vibro.quantities import WAY
from vibro.reals import NotRealError, real_array, shielded
from vibro.units import IN_GRAVITIES, LENGTH, MASS_FLOW, PER_MINUTE, PURE, SPEED, TIME, Kind

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from numpy.typing import NDArray

    from vibro.reals import Floats

    Codes = NDArray[np.int8]


#: What people read where a body has no regime.
NO_REGIME: Final = "no regime"
#: [1] Share of starts below which most parts move otherwise than the one released at phase 0.
MINORITY: Final = 0.5


@dataclass(frozen=True, kw_only=True)
class Result:
    """The description of one result.

    Attributes
    ----------
    name : str
        Attribute of ``SteadyCycle``.
    meaning : str
        What it is, for people, in the words of every table; mathematics between dollar signs.
    symbol : str
        As in docs/theory, in TeX; empty if it has none.
    kind : Kind
        Units inside and outside.
    column : str
        Name with unit, as tables and JSON spell it.
    dtype : type
        Of the array.
    texts : tuple of str, optional
        What codes mean in tables, the last one standing for -1; None for numbers and patterns.
    is_flag : bool
        Whether the codes are 0, 1 and, for unknown, -1.
    decode : callable, optional
        From an array of codes and ``SteadyCycle.long_patterns`` to an array of texts, where there are too
        many to list.
    in_contact : float, optional
        Its value in every cell in contact that is answered, where that is always the same.
    on_request : bool
        Whether tables have its column only on request.
    """

    name: str
    meaning: str
    symbol: str = ""
    kind: Kind = PURE
    column: str = ""
    dtype: type = np.float64
    texts: tuple[str, ...] | None = None
    is_flag: bool = False
    decode: Callable[[NDArray[Any], Mapping[int, str]], NDArray[np.object_]] | None = None
    in_contact: float | None = None
    on_request: bool = False
    of_starts: bool = False

    @property
    def is_number(self) -> bool:
        """Whether it is a number, not a code or a flag."""
        return self.dtype is np.float64


def _result(column: str, meaning: str, **more: Any) -> Any:
    return field(metadata={"column": column, "meaning": meaning, **more})


@dataclass(frozen=True, eq=False, kw_only=True)
class SteadyCycle(Shown):
    """The steady motion of bodies that start from rest; returned by ``vibro.solve``.

    Every attribute is an array of the scene's shape. A cell without an answer holds NaN, and its status says
    why. ``regime`` and ``status`` hold codes of the enums ``Regime`` and ``Status``; the properties
    ``pattern`` and ``model`` give their codes as texts. ``coexists`` is -1, and ``share`` NaN, where nothing
    was looked for.
    """

    regime: Codes = _result(
        "regime",
        "class of the body's motion: no-slip, forward-slip, back-slip or hopping",
        dtype=np.int8,
        texts=(*(regime.label for regime in Regime if regime >= 0), ""),
    )
    pattern_code: NDArray[np.int64] = _result(
        "pattern",
        "phases of a cycle: H flight, F forward slide, B back slide, _ rest",
        dtype=np.int64,
        decode=pattern_texts,
    )
    mean_velocity: Floats = _result("mean_velocity_mm_s", "mean conveying speed", symbol="fd", kind=SPEED)
    displacement_per_cycle: Floats = _result(
        "displacement_per_cycle_mm",
        "displacement relative to the trough in a drive cycle, positive in the conveying direction",
        symbol="d=AD",
        kind=LENGTH,
    )
    peak_velocity: Floats = _result(
        "peak_velocity_mm_s",
        "largest relative speed along the trough, either way",
        symbol=r"A\omega v_{\max}",
        kind=SPEED,
    )
    throw_number: Floats = _result(
        "throw_number",
        "largest downward acceleration of the trough, normal to its surface, divided by that of gravity;"
        " above 1 the trough falls away and the part hops",
        symbol="K",
    )
    forward_ratio: Floats = _result(
        "forward_ratio", "load divided by the load at the forward onset; 0 if there is none", symbol="1/s_f"
    )
    back_ratio: Floats = _result(
        "back_ratio", "load divided by the load at the back onset; 0 if there is none", symbol="1/s_b"
    )
    flight_fraction: Floats = _result(
        "flight_fraction",
        "share of the time that the body is off the trough",
        symbol=r"\sum\tau_i/2\pi m",
        in_contact=0.0,
    )
    impact_velocity: Floats = _result(
        "impact_speed_mm_s",
        "largest normal speed of a landing; 0 without flight",
        symbol=r"A\omega\max\lvert\eta'_-\rvert",
        kind=SPEED,
        in_contact=0.0,
    )
    period_cycles: Floats = _result(
        "period_cycles",
        "drive cycles until the motion repeats; no number where it does not",
        symbol="m",
        in_contact=1.0,
    )
    mean_velocity_error: Floats = _result(
        "mean_velocity_error_mm_s",
        "standard error of the mean speed where it is a mean over many cycles (status averaged), else 0",
        kind=SPEED,
        in_contact=0.0,
    )
    coexists: Codes = _result(
        "coexists",
        "whether another motion (a cycle, running away) exists: 1 yes, 0 none found, else not searched",
        dtype=np.int8,
        texts=("0", "1", ""),
        is_flag=True,
    )
    share: Floats = _result(
        "share",
        "share of parts, laid down at rest at any moment, that move as one released at the start of a cycle"
        " (phase 0)",
        of_starts=True,
    )
    mean_velocity_over_starts: Floats = _result(
        "mean_velocity_over_starts_mm_s",
        "mean speed of parts laid down at rest at any moment",
        kind=SPEED,
        of_starts=True,
    )
    model_code: Codes = _result(
        "model", "simplest exact model that gave the answer", dtype=np.int8, texts=MODELS
    )
    status: Codes = _result(
        "status",
        "kind of the numbers, or why there are none",
        dtype=np.int8,
        texts=tuple(status.label for status in Status),
    )
    largest_multiplier: Floats = _result(
        "largest_multiplier",
        "modulus of the largest Floquet multiplier: factor of a small disturbance over a period",
        symbol=r"\max\lvert\lambda\rvert",
        on_request=True,
    )
    long_patterns: dict[int, str] = field(default_factory=dict)

    @property
    @shielded
    def pattern(self) -> Any:
        """Phases of the cycle as text: H flight, F forward slide, B back slide, _ rest; empty if none.

        Irregular hopping is ``H...``. Arrays have the dtype ``object``, because texts differ in length.
        """
        return pattern_texts(np.asarray(self.pattern_code), self.long_patterns)[()]

    @property
    def model(self) -> Any:
        """Simplest exact model that gave the answer, as text."""
        return np.array(MODELS)[self.model_code]

    def _table(self) -> tuple[str, list[tuple[str, str]], tuple[()]]:
        shape = np.shape(self.status)
        caption = " x ".join(map(str, shape)) + " steady cycles" if shape else "steady cycle"
        return caption, summary(self), ()

    def arrays(self) -> dict[str, Any]:
        """Return all results by name.

        Returns
        -------
        dict of str to array
            Attributes by their names, each of the scene's shape.
        """
        return {result.name: getattr(self, result.name) for result in RESULTS}

    @shielded
    def traverse_time(self, length: Any) -> Any:
        """Return the time to convey over a length at the mean speed.

        Parameters
        ----------
        length : array_like
            Length of the trough, > 0 [m]; broadcasts against the scene.

        Returns
        -------
        array
            ``length / mean_velocity`` [s]; inf where the body does not move forward, NaN where its
            speed is unknown.

        Raises
        ------
        SceneError
            If a length is not finite and positive, or does not broadcast.

        Examples
        --------
        >>> import math, vibro
        >>> cycle = vibro.solve(vibro.Scene(amplitude=1e-3, frequency=15, drive_angle=math.radians(20),
        ...                                 static_friction=0.74, kinetic_friction=0.57))
        >>> print(*(f"{time:.2f} s" for time in cycle.traverse_time([0.3, 0.6])))
        18.45 s 36.89 s
        """
        lengths = lengths_of(length, np.shape(self.mean_velocity))
        velocity = np.where(self.mean_velocity > 0.0, self.mean_velocity, 0.0)
        with np.errstate(divide="ignore", over="ignore"):  # inf where the time is beyond the range of doubles
            return np.where(np.isnan(self.mean_velocity), np.nan, lengths / velocity)[()]


def lengths_of(value: Any, shape: tuple[int, ...]) -> Floats:
    """Convert lengths that bodies are to cover [m], and broadcast them against scenes of a shape.

    Raises
    ------
    SceneError
        If one is no number, or out of its range, or they do not broadcast.
    """
    try:
        lengths = real_array(value)
    except NotRealError as exc:
        raise SceneError.of("length", exc.value, exc.allowed) from None
    bad = ~WAY.allows(lengths)
    if bad.any():
        raise SceneError.of("length", f"{lengths[bad].flat[0]:.15g} m", WAY.range_text)
    try:
        return np.broadcast_to(lengths, np.broadcast_shapes(shape, lengths.shape))
    except ValueError:
        allowed = f"broadcastable against the scene's shape {shape}"
        raise SceneError.of("length", f"shape {lengths.shape}", allowed) from None


def summary(cycle: SteadyCycle) -> list[tuple[str, str]]:
    """Summarise results, of however many cells: pairs of a name and a text, in the units of tables."""
    rows = []
    for result in RESULTS:
        values = getattr(cycle, result.name)
        label = result.column.removesuffix(result.kind.suffix).replace("_", " ")
        if result.is_number:
            rows.append((label, span(result.kind.from_si(np.asarray(values)), result.kind.unit)))
            continue
        texts = {} if result.texts is None else {**dict(enumerate(result.texts)), -1: result.texts[-1]}
        if result.is_flag:
            texts = {1: "yes", 0: "no", -1: "not looked for"}
        elif result.name == "regime":
            texts[-1] = NO_REGIME
        elif result.decode is not None:
            codes = np.unique(np.asarray(values))
            known = {**dict.fromkeys(codes.tolist(), "?"), **cycle.long_patterns}
            texts = dict(zip(codes.tolist(), result.decode(codes, known), strict=True))
        rows.append((label, counts(values, texts)))
    return rows


#: Fields of ``SteadyCycle``, in the order of a table's columns.
RESULTS: Final = tuple(Result(name=f.name, **f.metadata) for f in fields(SteadyCycle) if f.metadata)
(LARGEST_MULTIPLIER,) = (result for result in RESULTS if result.on_request)
#: Fields that follow from it and a length.
TRAVERSE_TIME: Final = Result(
    name="traverse_time",
    column="traverse_time_s",
    meaning="time over a length $L$ at the mean speed; empty where the body never arrives",
    symbol="L/(fd)",
    kind=TIME,
)
ARRIVAL_TIME: Final = Result(
    name="arrival_time",
    column="arrival_time_s",
    meaning="time from rest at the start of a cycle (phase 0) until the body has moved a length $L$",
    kind=TIME,
)
STROKES: Final = Result(
    name="strokes", column="strokes", meaning="drive cycles that a traverse takes", symbol="L/d"
)
#: Fields of the drive, and the exponent of the speed over the amplitude.
ACCELERATION: Final = Result(
    name="acceleration",
    column="acceleration_g",
    meaning="peak acceleration of the drive over gravity: the load, which makers call the machine number;"
    " as it was given, over 9.80665 m/s^2, of a drive in g",
    symbol=r"G=A\omega^2/g",
    kind=IN_GRAVITIES,
)
SPEED_EXPONENT: Final = Result(
    name="speed_exponent",
    column="speed_amplitude_exponent",
    meaning="percent of speed that 1 % of amplitude brings, within the pattern; empty where there is none",
    symbol=r"\partial\ln v/\partial\ln A",
)
#: Fields that follow from the pitch of parts in a row, from each to the next, and from the mass of one.
PARTS_RATE: Final = Result(
    name="parts_rate",
    column="parts_per_min",
    meaning="parts of a row that pass at the mean speed; 0 where they are not conveyed forward",
    kind=PER_MINUTE,
)
MASS_RATE: Final = Result(
    name="mass_rate", column="mass_flow_kg_h", meaning="mass of the parts that pass", kind=MASS_FLOW
)
#: Fields that follow from the part's stand ratio.
UPRIGHT: Final = Result(
    name="upright",
    column="upright",
    meaning="whether a part from rest keeps its base on the trough: 1 yes, 0 an edge lifts, else unknown",
    dtype=np.int8,
    texts=("0", "1", ""),
    is_flag=True,
)
TIPPING_LOAD_RATIO: Final = Result(
    name="tipping_load_ratio",
    column="tipping_load_ratio",
    meaning="load divided by the load above which an edge of the part lifts; 0 if there is none",
    symbol=r"G/G_{\text{tip}}",
)
SteadyCycle.__doc__ = (
    (SteadyCycle.__doc__ or "").rstrip()
    + "\n\n    Attributes\n    ----------"
    + "".join(
        f"\n    {r.name} : {np.dtype(r.dtype).name} array\n        {r.meaning[:1].upper()}{r.meaning[1:]}"
        f" [{r.kind.si_unit or 1}]."
        for r in RESULTS
    )
    + "\n    long_patterns : dict of int to str"
    + "\n        Texts of the patterns that a code has no room for, by their codes; of other cells too."
)
