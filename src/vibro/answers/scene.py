"""The answer about one scene: what the part does, how fast, and what begins next."""

from __future__ import annotations

import math
from functools import cached_property
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from vibro.answers.answer import (
    METRES_PER_MINUTE,
    NO_BOUNCE,
    UNKNOWN,
    Answer,
    Fact,
    Table,
    brief,
    given_text,
    is_listed,
    label_of,
    letters,
    shown,
    uncertain,
)
from vibro.core.codes import PHASE_NAMES, Output, Regime, Status
from vibro.designs.sensitivities import LARGEST, RESTITUTIONS, changed_cycles, speeds_over_restitution
from vibro.drives import PiecewiseMotion
from vibro.errors import VibroError
from vibro.limits import HOP, LOADS, MOTIONS, transitions
from vibro.motion.attractors import attractors
from vibro.motion.settled import cycle_phases
from vibro.quantities import QUANTITIES, RATES, SCALE, SIZES, as_given, scene_fields, with_amplitude
from vibro.results.operating import OPERATING, bent
from vibro.scene import Scene
from vibro.steady import LEAST_DIFFERENCE
from vibro.sweeps.derived import WITH_ACCELERATION, WITH_BENT_SPEED, WITH_STROKE, standing, throughput
from vibro.sweeps.weighed import weighed
from vibro.units import LENGTH, SPEED

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from numpy.typing import NDArray

    from vibro.answers.answer import Value
    from vibro.results.attractors import Attractors
    from vibro.results.sweep import Block, Column
    from vibro.sweeps.grid import Grid
    from vibro.sweeps.request import Request

_NEXT: Final = ("forward slip", "back slip", HOP)  # what people ask for; the others on request
_MOST_PHASES: Final = 40  # a longer table is not readable
_LEAST_CERTAIN: Final = 1.0 / 3.0  # standard error over the size of a mean whose sign is not in doubt
_STANDS: Final[dict[Any, str]] = {True: "yes", False: "no", -1: "unknown"}  # in records None is unknown
_SEVERAL: Final = (
    "several motions exist {where}; speeds are those of a part released at the start of a cycle:"
    " solve of one scene, or map --starts 16, tells the shares"
)
# What tables of several scenes have where it was asked for.
_WHERE_ASKED: Final = (
    ("traverse_time_s", "traverse time", "s"),
    ("parts_per_min", "throughput", "parts/min"),
    ("mass_flow_kg_h", "throughput", "kg/h"),
    ("upright", "upright", ""),
    ("power_w", "power of the filling", "W"),
)
_MOST_KINDS: Final = 5  # of motions in one line
_DIGITS_OF_SHARES: Final = 3
_QUANTILES: Final = (0.1, 0.5, 0.9)  # of times over the trough
_STEPS: Final = {"drive": "some more", "restitution": "bounced"}
_ROUNDING: Final = 1e-9  # [%] change of a speed that is rounding alone

# What an answer says, with places for its numbers: vibro explore fills in the same texts in its page.
_SAYS: Final = {
    "none": "none",
    "runs away": "gains speed every cycle",
    "speed": "{speed} mm/s ({rate} m/min), {advance} mm a cycle",
    "to": " to ",
    "assumed": "0 assumed: {speeds} mm/s over 0 to 0.5",
    "sampled": "{count} values; between them may lie more",
    "over": "s over {length} mm",
    "from rest": "{time} s from rest",
    "from rest unknown": "from rest unknown",
    "never": "never",
    "not steady": "none at a steady speed",
    "lands": "lands at {impact} mm/s, {again}",
    "irregular": "irregular",
    "every cycle": "repeats every cycle",
    "every few cycles": "repeats every {period} cycles",
    "hops": "the part hops above 1",
    "both": "both amplitudes",
    "all": "all amplitudes",
    "a little more": "{what}, {step}",
    "some more": "10 %",
    "more": "1 %",
    "turned": "1 deg",
    "bounced": "0.01",
    "pieces": "motion of {count} pieces, {given}",
    "harmonic": "motion of {count} harmonic, {given}",
    "harmonics": "motion of {count} harmonics, {given}",
    "laid down": "of parts laid down at random",
    "share": "{share} % {speed} mm/s",
    "share irregular": "{share} % irregular, {speed} mm/s on average",
    "share lost": "{share} % run away or are not known",
    "share of others": "{share} % otherwise",
    "within": "{share} % within {time} s",
    "fewer": "fewer than {share} % arrive",
    "released": "released at the start of a cycle: {speed}",
    "may run away": "a part pushed downhill runs away: the slope exceeds kinetic friction",
    "may settle elsewhere": "a disturbed part can settle into another steady motion than one from rest",
}
# Labels and units of facts, and heads of tables.
_FACTS: Final = {
    "traverse": ("traverse time", ""),
    "restitution": ("restitution", ""),
    "peak": ("peak speed", "mm/s"),
    "flight": ("in flight", "% of the time"),
    "throw": ("throw number", ""),
    "scene": ("scene", ""),
    "pattern": ("pattern", ""),
}
_HEADS: Final = {
    "motion": ("begins", ""),
    "begin": ("times the drive", ""),
    "frequency": ("frequency", "Hz"),
    "end": ("until times the drive", ""),
    "input": ("more of", ""),
    "speed": ("speed", "mm/s"),
    "change": ("change", "%"),
    "then": ("then", ""),
    "phase": ("phase", ""),
    "from": ("start", "ms"),
    "until": ("end", "ms"),
    "displacement": ("displacement", "mm"),
}
_TITLES: Final = {
    "beginnings": "Where each motion begins",
    "sensitivities": "A little more of each input",
    "phases": "One cycle, from the drive's middle on",
}


def page_texts() -> dict[str, Any]:
    """Return the texts of ``scene_answer`` for pages that make the answer themselves, as JSON has them."""
    from vibro.answers.machine import machine_texts  # late, as below
    from vibro.sweeps.request import SHORT_TROUGH

    columns = {"stroke": WITH_STROKE, "acceleration": WITH_ACCELERATION, "bent": WITH_BENT_SPEED}
    numbers = {key: (label_of(column.name, column.unit), column.unit) for key, column in columns.items()}
    return {
        "says": {**_SAYS, "unknown": UNKNOWN, "no bounce": NO_BOUNCE},
        "facts": {**_FACTS, **numbers},
        "heads": _HEADS,
        "titles": _TITLES,
        "phases": PHASE_NAMES,
        "motions": MOTIONS,
        "loads": LOADS,
        "hop": HOP,
        "listed": [name for name in QUANTITIES if is_listed(name)],
        "most phases": _MOST_PHASES,
        "restitutions": (RESTITUTIONS, LARGEST),
        "machine": machine_texts(),
        "short trough": SHORT_TROUGH,
    }


class OneScene:
    """One solved scene in the user's units.

    Parameters
    ----------
    block : Block
        Of a single cell.

    Attributes
    ----------
    given : dict of str to float
        Every quantity of the scene, in the units outside; the stroke in place of the amplitude if it was
        given.
    scene : Scene
        The same.
    length : float
        Length of the trough, NaN without one [mm].
    speed, error : float
        Mean speed, 0 of a part that slides both ways and advances by rounding alone, and its standard error;
        NaN where it is unknown [mm/s].
    regime : Regime
        Class of the motion.
    status : Status
        Whether the numbers are exact, or why there are none.
    """

    def __init__(self, block: Block) -> None:
        values = {name: float(value.item()) for name, value in block.values.items() if name in QUANTITIES}
        self.given = as_given(values, in_stroke=block.in_stroke)
        moved = {name: value for name, value in block.values.items() if name not in QUANTITIES}
        self.scene = Scene(**scene_fields({**self.given, **moved}))
        self.length = math.nan if block.length is None else block.length
        self.regime = Regime(int(block.cycle.regime.item()))
        self.status = Status(int(block.cycle.status.item()))
        self.block, self.cycle = block, block.cycle
        small = abs(self.cycle.displacement_per_cycle) <= LEAST_DIFFERENCE * self.scene.scale
        is_still = bool(small) and {*"FB"} <= {*str(self.cycle.pattern)}
        self.speed = 0.0 if is_still else self.result("mean_velocity")
        self.error = self.result("mean_velocity_error")

    def value(self, column: Column) -> float:
        """Return the number that a table has in a column."""
        return float(np.asarray(column.values(self.block)).item())

    def result(self, name: str) -> float:
        """Return a length or speed of the cycle [mm, mm/s]."""
        return float(LENGTH.from_si(getattr(self.cycle, name).item()))

    @cached_property
    def motions(self) -> Attractors | None:
        """What parts do that are laid down at ``STARTS`` moments; None where the speed is unknown."""
        if math.isnan(self.speed) or not self.may_differ:
            return None
        try:
            return attractors(self.scene)
        except VibroError:  # loads or frictions are too large
            return None

    @property
    def may_differ(self) -> bool:
        """Whether parts from other starts may move otherwise: known in contact, and asked for hops."""
        return bool(self.regime is Regime.HOPPING or self.cycle.coexists > 0)

    @property
    def relative_error(self) -> float:
        """Standard error of the mean speed over its size; 0 if the speed is not a mean [1]."""
        return abs(self.error / self.speed) if self.speed else 0.0

    @property
    def is_certain(self) -> bool:
        """Whether the error of a mean leaves no doubt which way parts go."""
        return not self.relative_error > _LEAST_CERTAIN

    @property
    def size(self) -> tuple[str, str, float]:
        """What the drive is scaled by, as it was given: its name, unit and value, NaN if it has several."""
        sizes = [name for name in self.given if name in SIZES] or [SCALE]
        if len(sizes) > 1:
            return _SAYS["both" if len(sizes) == 2 else "all"], "", math.nan
        return QUANTITIES[sizes[0]].label, QUANTITIES[sizes[0]].unit, self.given.get(sizes[0], math.nan)

    @property
    def traverse_time(self) -> float:
        """Length over mean speed [s]; NaN without a length or a known speed, inf where it never arrives."""
        return math.inf if self.speed <= 0.0 else self.length / self.speed

    @property
    def arrival_time(self) -> float:
        """Time from rest at trough phase 0 to the arrival; inf if it never arrives, NaN if unknown [s]."""
        return math.nan if self.block.arrival is None else float(self.block.arrival.item())

    @property
    def frequency_counts(self) -> bool:
        """Whether the frequency changes the accelerations, and the amplitude stays as it is."""
        return not (isinstance(self.scene.motion, PiecewiseMotion) or self.frequency_moves)

    @property
    def frequency_moves(self) -> bool:
        """Whether the amplitude changes with the frequency: of a machine, or at a given acceleration."""
        return OPERATING in self.block.values or not RATES.keys().isdisjoint(self.given)


def scene_answer(
    one: OneScene,
    grid: Grid,
    part: Mapping[str, float],
    record: Mapping[str, Any],
    *,
    every: bool,
    assumes_plastic: bool = False,
    title: str = "",
) -> Answer:
    """Make the answer about one solved scene.

    Parameters
    ----------
    one : OneScene
        The scene.
    grid : Grid
        Its single cell.
    part : mapping of str to float
        What is known of the parts, by its names with units: pitch and mass, stand ratio, filling.
    record : mapping
        What JSON says.
    every : bool
        Whether all is printed: phases, sensitivities, the scene.
    assumes_plastic : bool
        Whether no restitution was given, so that one of 0 was assumed.
    title : str
        Of its page.
    """
    # with a filling restitution changes the amplitude too
    is_filled = OPERATING in one.block.values and one.given["filling"] > 0.0
    is_open = assumes_plastic and one.cycle.flight_fraction > 0.0 and not is_filled
    over = _over_restitution(one) if is_open else None
    moves = [*_shares(one), _motion(one), *_assumed(over), *_traverse(one)]
    if grid.output is Output.REGIMES:
        moves = [Fact(one.regime.label or _SAYS["none"], "no speed is computed")]
    facts = [*moves, *_speeds(one), *_asked(one, part)]
    if grid.machine is not None:
        from vibro.answers.machine import machine_facts  # late: few scenes have a machine

        facts += machine_facts(grid.machine, one.block.values)
        facts += [_fact(one, WITH_BENT_SPEED)] * bent(one.block).number
    tables = [_beginnings(one, every=every)]
    if every:
        facts += _rare(one)
        if grid.output is Output.EXACT:
            # so do friction and angles: vibro drive tells how much
            tables += [] if is_filled else [_sensitivities(one)]
            tables.append(_phases(one))
    record = {**record, **_starts_record(one)} if record else record
    record = {**record, "over_restitution": over}
    notes = _notes(one, is_said=over is not None)
    return Answer(facts, [table for table in tables if table.rows], notes, record, title)


def _starts_record(one: OneScene) -> dict[str, Any]:
    """Return what JSON says of parts that are laid down at any moment."""
    found = one.motions
    if found is None:
        return {}
    in_mm_s = [SPEED.from_si(x) for x in (found.mean_velocity, found.irregular_velocity)]
    motions = [
        {
            "share": x.share,
            "share_low": x.share_low,
            "share_high": x.share_high,
            "mean_velocity_mm_s": float(SPEED.from_si(x.mean_velocity)),
            "regime": x.regime.label,
            "pattern": x.pattern,
            "period_cycles": x.period_cycles,
            "from_rest": x.from_rest,
        }
        for x in found
    ]
    return {
        "starts": found.starts,
        "share": next((x.share for x in found if x.from_rest), found.irregular_share),
        "mean_velocity_over_starts_mm_s": float(in_mm_s[0]),
        "irregular_share": found.irregular_share,
        "lost_share": found.lost / found.starts,
        "irregular_velocity_mm_s": float(in_mm_s[1]),
        "motions": motions,
    }


def traverse_answer(one: OneScene, record: Mapping[str, Any]) -> Answer:
    """Make the answer about the time over a trough: at the mean speed, and from rest."""
    facts, time = _traverse(one), one.traverse_time
    if math.isfinite(time) and one.is_certain:
        strokes = time * one.given["frequency"]
        facts.append(Fact("strokes", strokes, error=strokes * one.relative_error))
    quantiles = _quantiles(one)
    if _shares(one):
        texts = ", ".join(_within(part, time) for part, time in quantiles.items())
        facts.insert(0, Fact(_SAYS["laid down"], texts, is_line=True))
    if record and quantiles:
        record = {**record, "traverse_time_quantiles_s": {f"{x:g}": time for x, time in quantiles.items()}}
    tables = [_beginnings(one, every=False)]
    never = [table for table in tables if table.rows and one.regime is Regime.NO_SLIP]
    return Answer([*facts, _motion(one)], never, _notes(one), record)


def _quantiles(one: OneScene) -> dict[float, float]:
    """Return the times within which shares of parts that are laid down at any moment have passed [s]."""
    found = one.motions
    if found is None or math.isnan(one.length):
        return {}
    speeds = [(x.share, x.mean_velocity) for x in found]
    speeds += [(found.irregular_share, found.irregular_velocity), (found.lost / found.starts, 0.0)]
    times = sorted(
        (one.length / float(SPEED.from_si(speed)) if speed > 0.0 else math.inf, share)
        for share, speed in speeds
        if share
    )
    passed = np.cumsum([share for _, share in times])
    return {q: times[int(np.searchsorted(passed, q - _ROUNDING))][0] for q in _QUANTILES}


def _within(share: float, time: float) -> str:
    says = _SAYS["within" if math.isfinite(time) else "fewer"]
    return says.format(share=round(100.0 * share), time=shown(time))


def cells_answer(
    cells: Sequence[Mapping[str, Any]], axes: Sequence[str], given: Mapping[str, Mapping[str, float]]
) -> Answer:
    """Make the answer about several scenes: a line for each.

    Parameters
    ----------
    cells : sequence of mapping
        Quantities and results of each, by column; of several files its name under ``scene``.
    axes : sequence of str
        Names of the quantities that vary.
    given : mapping of str to mapping
        What does not vary, in the units outside, by the name of each scene file.
    """
    heads = [("scene", "scene", "")] * ("scene" in cells[0])
    heads += [(q.column, q.label, q.unit) for q in map(QUANTITIES.__getitem__, axes)]
    lengths = {cell.get("trough_length_mm") for cell in cells}
    statuses = {cell["status"] for cell in cells}
    columns = [
        *heads, ("regime", "regime", ""), ("speed", "speed", "mm/s"), ("rate", "speed", "m/min"),
        ("displacement_per_cycle_mm", "a cycle", "mm"), ("throw_number", "throw number", ""),
    ]  # fmt: skip
    columns += [one for one in _WHERE_ASKED if any(cell.get(one[0]) is not None for cell in cells)]
    columns += [("trough_length_mm", "length", "mm")] * (len(lengths) > 1)
    columns += [("status", "status", "")] * (statuses != {Status.OK.label})
    rows = []
    for cell in cells:
        stands = _STANDS.get(cell.get("upright"))
        found = {**cell, "regime": cell["regime"] or "none", "upright": stands}
        speed, error = cell["mean_velocity_mm_s"], cell.get("mean_velocity_error_mm_s") or 0.0
        if speed is not None:
            found["speed"], found["rate"] = (
                uncertain(x * speed, x * error) for x in (1.0, METRES_PER_MINUTE)
            )
            if error > _LEAST_CERTAIN * abs(speed):
                found |= dict.fromkeys(key for key, *_ in _WHERE_ASKED[:3])
        rows.append([found.get(key) for key, *_ in columns])
    notes = [f"{x.label}: {x.message}" for x in Status if x is not Status.OK and x.label in statuses]
    if any(cell["regime"] == Regime.HOPPING.label and cell.get("restitution") == 0.0 for cell in cells):
        notes.append(NO_BOUNCE)
    if several := sum((cell.get("coexists") or 0) > 0 for cell in cells):
        notes.append(_SEVERAL.format(where=f"in {several} of {len(cells)} scenes"))
    if len(lengths) == 1 and any(cell.get("traverse_time_s") is not None for cell in cells):
        notes.append(f"traverse times are over {lengths.pop():.10g} mm")
    facts = [Fact(name, given_text(values), is_rare=True) for name, values in given.items()]
    table = Table("scenes", [(label, unit) for _, label, unit in columns], rows)
    return Answer(facts, [table], notes, title=", ".join(given))


def several_motions(coexists: NDArray[np.int8], what: str) -> list[str]:
    """Note that several motions exist in some of the scenes that were found, if they do."""
    return [_SEVERAL.format(where=f"at some of these {what}")] if (coexists > 0).any() else []


def _shares(one: OneScene) -> list[Fact]:
    """Tell what parts laid down at any moment do, where they do not all move as the one from rest."""
    found = one.motions
    if found is None:
        return []
    kinds = [(x.share, _SAYS["share"], float(SPEED.from_si(x.mean_velocity))) for x in found if x.share]
    if found.irregular_share:
        speed = float(SPEED.from_si(found.irregular_velocity))
        kinds.append((found.irregular_share, _SAYS["share irregular"], speed))
    if found.lost:
        kinds.append((found.lost / found.starts, _SAYS["share lost"], math.nan))
    alike = found.irregular_share == 1.0 if one.status is Status.AVERAGED else len(kinds) < 2
    if alike:
        return []
    kinds.sort(key=lambda kind: -kind[0])
    texts = [
        text.format(share=math.floor(100.0 * share + 0.5), speed=shown(speed, _DIGITS_OF_SHARES))
        for share, text, speed in kinds[:_MOST_KINDS]
    ]
    if others := sum(share for share, *_ in kinds[_MOST_KINDS:]):
        texts.append(_SAYS["share of others"].format(share=math.floor(100.0 * others + 0.5)))
    # in the end the body from rest may repeat, where a mean is not that of a cycle
    home = next((float(SPEED.from_si(x.mean_velocity)) for x in found if x.from_rest), one.speed)
    note = _SAYS["released"].format(speed=shown(home, _DIGITS_OF_SHARES))
    return [Fact(_SAYS["laid down"], ", ".join(texts), note=note, is_line=True)]


def _motion(one: OneScene) -> Fact:
    label = one.regime.label or _SAYS["none"]
    if math.isnan(one.speed):
        return Fact(label, _SAYS["runs away"] if one.status is Status.RUNAWAY else None)
    speed, rate, advance = (
        uncertain(x * one.speed, x * one.error, digits)
        for x, digits in ((1.0, 4), (METRES_PER_MINUTE, 3), (1.0 / one.given["frequency"], 4))
    )
    return Fact(label, _SAYS["speed"].format(speed=speed, rate=rate, advance=advance))


def _over_restitution(one: OneScene) -> dict[str, float]:
    """Return between which speeds a part that hops may be where no restitution is given."""
    low, high = (float(SPEED.from_si(speed)) for speed in speeds_over_restitution(one.scene))
    ends = {"restitution_low": 0.0, "restitution_high": LARGEST}
    return {**ends, "values": RESTITUTIONS, "speed_low_mm_s": low, "speed_high_mm_s": high}


def _assumed(over: Mapping[str, float] | None) -> list[Fact]:
    if over is None or math.isnan(over["speed_low_mm_s"]):
        return []
    low, high = (shown(over[f"speed_{end}_mm_s"]) for end in ("low", "high"))
    note = _SAYS["sampled"].format(count=over["values"])
    speeds = _SAYS["to"].join(dict.fromkeys((low, high)))
    return [Fact(_FACTS["restitution"][0], _SAYS["assumed"].format(speeds=speeds), note=note)]


def _traverse(one: OneScene) -> list[Fact]:
    """Tell the time over the trough at the mean speed, and exactly from rest."""
    if math.isnan(one.length):
        return []
    time, exact, (label, _) = one.traverse_time, one.arrival_time, _FACTS["traverse"]
    from_rest = _SAYS["from rest"].format(time=shown(exact, 6)) if math.isfinite(exact) else ""
    if math.isfinite(time) and one.is_certain:
        over = _SAYS["over"].format(length=f"{one.length:.10g}")
        from_rest = from_rest or _SAYS["from rest unknown"]
        return [Fact(label, time, over, time * one.relative_error, from_rest)]
    never = _SAYS["never"] if math.isinf(time) and one.is_certain else None
    if one.status is Status.RUNAWAY:
        never = _SAYS["not steady"]
    return [Fact(label, never, note=from_rest)]


def _speeds(one: OneScene) -> list[Fact]:
    facts = []
    if not math.isnan(one.speed):
        facts.append(_known("peak", one.result("peak_velocity")))
    if one.cycle.flight_fraction > 0.0:
        impact, period = shown(one.result("impact_velocity")), float(one.cycle.period_cycles)
        again = _SAYS["irregular" if math.isnan(period) else "every cycle"]
        again = _SAYS["every few cycles"].format(period=f"{period:.0f}") if period > 1.0 else again
        share = 100.0 * float(one.cycle.flight_fraction)
        facts.append(_known("flight", share, _SAYS["lands"].format(impact=impact, again=again)))
    return [*facts, _known("throw", brief(float(one.cycle.throw_number)), _SAYS["hops"])]


def _known(name: str, value: Value, note: str = "", *, is_rare: bool = False) -> Fact:
    label, unit = _FACTS[name]
    return Fact(label, value, unit, note=note, is_rare=is_rare)


def _asked(one: OneScene, part: Mapping[str, float]) -> list[Fact]:
    """Tell what follows from the parts: how many pass, whether they stand, what they weigh."""
    facts = []
    if "pitch_mm" in part:
        note = f"at most, one every {part['pitch_mm']:g} mm"
        for column in throughput(part):
            rate = one.value(column) if one.is_certain else math.nan
            unit = column.unit.replace("1/min", "parts/min")
            facts.append(Fact("throughput", rate, unit, rate * one.relative_error, note))
    if "stand_ratio" in part:
        upright, load = (one.value(column) for column in standing(part["stand_ratio"]))
        note = f"an edge lifts at {shown(1.0 / load)} times the drive" if 0.0 < load < math.inf else ""
        facts.append(Fact("upright", _STANDS[int(upright)], note=note))
    weight = ("filling_kg", "power_w")
    return [*facts, *(_fact(one, column, is_rare=column.name not in weight) for column in weighed(part))]


def _fact(one: OneScene, column: Column, *, is_rare: bool = True) -> Fact:
    label = label_of(column.name, column.unit)
    return Fact(label, one.value(column), column.unit, is_rare=is_rare)


def _rare(one: OneScene) -> list[Fact]:
    given, pattern = dict(one.given), str(one.cycle.pattern)
    if OPERATING in one.block.values:  # from which the amplitude follows
        del given["amplitude"]
    return [
        _known("scene", scene_text(one.scene, given), is_rare=True),
        _known("pattern", pattern or None, letters(pattern), is_rare=True),
        _fact(one, WITH_STROKE),
        _fact(one, WITH_ACCELERATION),
    ]


def _beginnings(one: OneScene, *, every: bool) -> Table:
    """List where each motion begins, and under a given motion ends; or what people ask for and is to come."""
    # a part that runs away slides one way for good
    names = (HOP,) if one.status is Status.RUNAWAY else _NEXT
    found = [t for t in transitions(one.scene) if every or (t.name in names and t.ratio < 1.0)]
    name, unit, size = one.size
    columns: dict[tuple[str, str], list[Value]] = {_HEADS["motion"]: [t.name for t in found]}
    if every or math.isnan(size):
        columns[_HEADS["begin"]] = [t.scales[0] for t in found]
    if not math.isnan(size):
        columns[name, unit] = [size / t.ratio for t in found]
    if one.frequency_counts:
        columns[_HEADS["frequency"]] = [t.frequency for t in found]
    if every and one.scene.motion is not None:
        columns[_HEADS["end"]] = [t.scales[1] for t in found]
    rows = [*zip(*columns.values(), strict=True)]
    if every:
        return Table("beginnings", [*columns], rows, _TITLES["beginnings"])
    return Table("next", [*columns], rows, is_brief=True)


def _sensitivities(one: OneScene) -> Table:
    """List what a little more of each input does to the speed, solved again."""
    names, cycle = changed_cycles(one.scene)
    speeds, errors = (SPEED.from_si(x) for x in (cycle.mean_velocity, cycle.mean_velocity_error))
    columns = [_HEADS[name] for name in ("input", "speed", "change", "then")]
    rows = []
    for cell, name in enumerate(names, 1):
        if name == "frequency" and one.frequency_moves:
            continue
        step = _SAYS[_STEPS.get(name, "turned" if name.endswith("_deg") else "more")]
        own = one.size[0] if name in ("amplitude", "drive") else QUANTITIES[name.removesuffix("_deg")].label
        change = 100.0 * (speeds[cell] / speeds[0] - 1.0) if speeds[0] and errors[0] == 0.0 else math.nan
        change = None if math.isnan(change) else 0.0 if abs(change) < _ROUNDING else float(change)
        regime, status = Regime(int(cycle.regime[cell])), Status(int(cycle.status[cell]))
        then = regime.label if regime != cycle.regime[0] else ""
        then = then if status.answered else status.label
        rows.append((_SAYS["a little more"].format(what=own, step=step), float(speeds[cell]), change, then))
    return Table("sensitivities", columns, rows, _TITLES["sensitivities"])


def _phases(one: OneScene) -> Table:
    known = one.regime is not Regime.HOPPING or one.cycle.flight_fraction > 0.0
    phases = cycle_phases(one.scene) if known else ()
    rows = [
        (PHASE_NAMES[p.kind], 1e3 * p.start, 1e3 * p.end, float(LENGTH.from_si(p.displacement)))
        for p in phases[:_MOST_PHASES]
    ]
    columns = [_HEADS[name] for name in ("phase", "from", "until", "displacement")]
    return Table("phases", columns, rows, _TITLES["phases"])


def _notes(one: OneScene, *, is_said: bool = False) -> list[str]:
    """Return a sentence for a status, and for each doubt; ``is_said``: of restitution facts do."""
    notes = [] if one.status is Status.OK else [one.status.message]
    if one.cycle.coexists > 0:
        if abs(math.tan(float(one.scene.trough_angle))) > float(one.scene.kinetic_friction):
            notes.append(_SAYS["may run away"])
        elif not _shares(one):
            notes.append(_SAYS["may settle elsewhere"])
    if one.cycle.flight_fraction > 0.0 and one.given["restitution"] == 0.0 and not is_said:
        notes.append(NO_BOUNCE)
    return notes


def scene_text(scene: Scene, given: Mapping[str, float]) -> str:
    """Name the quantities of a scene, after the kind of its motion, if it has one."""
    text = given_text(given)
    if scene.motion is None:
        return text
    if isinstance(scene.motion, PiecewiseMotion):
        return _SAYS["pieces"].format(count=scene.motion.breaks.size - 1, given=text)
    count = max(len(scene.along_harmonics or ()), len(scene.normal_harmonics or ()))
    return _SAYS["harmonics" if count > 1 else "harmonic"].format(count=count, given=text)


def scene_record(request: Request) -> dict[str, Any]:
    """Return the quantities of a request by their columns, as given, with its motion or machine."""
    values = with_amplitude({name: spec.value for name, spec in request.specs.items()})
    given: dict[str, Any] = {QUANTITIES[name].column: value for name, value in values.items()}
    moved = {} if request.motion is None else {"motion": dict(request.motion.table)}
    return given | moved | ({} if request.machine is None else {"machine": dict(request.machine.table)})
