"""The answer to a target: which amplitudes, or scales of a motion, convey a part at least so fast."""

from __future__ import annotations

import math
from dataclasses import dataclass, fields
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from vibro.answers.answer import METRES_PER_MINUTE, NO_BOUNCE, Answer, Fact, Table, bound, shown
from vibro.answers.scene import scene_record, scene_text, several_motions
from vibro.core.codes import Regime
from vibro.designs.guarantees import counted
from vibro.designs.questions import MOST_DESIGN_THROW
from vibro.designs.windows import HOPS_SAMPLED, feasible_amplitudes
from vibro.errors import InputError
from vibro.limits import critical_loads
from vibro.quantities import LEAST_SPEED, QUANTITIES, SCALE, as_given, scene_fields
from vibro.scene import Scene
from vibro.steady import solve
from vibro.units import SPEED

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from vibro.reals import Floats
    from vibro.results.designs import Interval
    from vibro.sweeps.request import Request


_MOST_ROWS: Final = 20  # of the table: irregular hops may give hundreds of slivers
_SAMPLES: Final = 4097  # amplitudes that are tried where none is fast enough
_WIDE: Final = 1.01  # end over beginning of a range in which a drive can be set
_LOOKED_AT: Final = 33  # amplitudes of an interval at which other motions are looked for
_LEAST: Final = 1e-6  # of the largest of them, where parts start at once or hop
_MOST: Final = 1e3  # times the largest critical load, where parts never hop
_BELOW_HOP: Final = 1e-12
_SETS: Final = {
    "speed": "the speed",
    "onset": "forward slip begins",
    "back slip": "back slip",
    "hop": "hopping",
    "unconfirmed": "the speed beyond is unknown",
    "limit": f"throw number {MOST_DESIGN_THROW:g}",
}


@dataclass(frozen=True)
class _Drive:
    """The drive whose size is searched.

    Attributes
    ----------
    scene : Scene
        The scene at some size.
    size : float
        That size: an amplitude [m], or the scale of a motion [1].
    shares : mapping of str to float
        Every amplitude over the size, and of a motion its scale, by name [1], of a motion's amplitudes [m].
    """

    scene: Scene
    size: float
    shares: Mapping[str, float]

    @classmethod
    def of(cls, request: Request) -> _Drive:
        """Return the drive of a request."""
        fixed = request.fixed
        if request.is_waveform:
            scene = request.scene()
            ways = (("along_amplitude", scene.along_harmonics), ("normal_amplitude", scene.normal_harmonics))
            amplitudes = {
                first if n == 1 else f"{first}_{n}": float(x)
                for first, pairs in ways
                for n, (x, _) in enumerate(pairs or (), 1)
            }
            return cls(scene, 1.0, {SCALE: 1.0, **amplitudes})
        names: list[str] = [name for name in ("along_amplitude", "normal_amplitude") if name in fixed]
        if names and not any(fixed[name] for name in names):
            raise InputError(
                "along amplitude = normal amplitude = 0 mm: their proportion is that of the answer",
                hint="give along= or normal= a value above 0",
            )
        given = fixed if names else {**fixed, "amplitude": 1.0}  # its value has no effect
        scene = Scene(**scene_fields(given))
        sizes: dict[str, float] = {name: float(getattr(scene, name)) for name in names or ("amplitude",)}
        size = next(filter(None, sizes.values()))
        return cls(scene, size, {name: x / size for name, x in sizes.items()})

    def scenes(self, sizes: Floats) -> Scene:
        """Return the scenes of some sizes."""
        given = {f.name: getattr(self.scene, f.name) for f in fields(self.scene)}
        scaled = [SCALE] if SCALE in self.shares else self.shares
        given |= {name: sizes * self.shares[name] for name in scaled}
        return Scene(**{name: value for name, value in given.items() if value is not None})

    def limit(self) -> float:
        """Return the size up to which hops are searched; inf where parts do not hop."""
        throw = float(solve(self.scene, output="regimes").throw_number)
        return self.size * (MOST_DESIGN_THROW / throw) if throw > 0.0 else math.inf

    def best(self, limit: float) -> tuple[float, float]:
        """Return the fastest of the sizes that are tried, and its speed [m/s]; NaN without any."""
        low, high = (_LEAST * limit, limit) if math.isfinite(limit) else self._contact()
        if not low < high:
            return math.nan, math.nan
        sizes = np.geomspace(low, high, _SAMPLES)
        speeds = np.asarray(counted(solve(self.scenes(sizes), flight=math.isfinite(limit)), fast=False))
        best = int(np.argmax(np.where(np.isfinite(speeds), speeds, -np.inf)))
        return float(sizes[best]), float(speeds[best])

    def _contact(self) -> tuple[float, float]:
        """Return the sizes between which a part moves that does not hop; NaN where there are none."""
        loads = critical_loads(self.scene)
        known = [float(load) for load in loads if 0.0 < float(load) < math.inf]
        if not known:
            return math.nan, math.nan
        high = min((1.0 - _BELOW_HOP) * float(loads.hop), _MOST * max(known))
        low = min(known) if float(loads.forward_onset) else _LEAST * high
        per_load = self.size / float(self.scene.load)
        return low * per_load, high * per_load

    def record(self, interval: Interval) -> dict[str, Any]:
        """Return an interval as JSON has it."""
        ends = {}
        for name, share in self.shares.items():
            quantity = QUANTITIES[name]
            for side, end in (("low", interval.low), ("high", interval.high)):
                value = float(quantity.from_si(end * share)) if share else 0.0
                ends[f"{name}_{side}{quantity.kind.suffix}"] = value
        return {**ends, "low_set_by": interval.low_set_by, "high_set_by": interval.high_set_by}


def target_answer(request: Request, speed: float, asked: str, *, hopping: bool) -> Answer:
    """Find the amplitudes that reach a speed.

    Parameters
    ----------
    request : Request
        The scene. The amplitude of a line is not given, nor the scale of a motion; the amplitudes of an
        ellipse give its proportion.
    speed : float
        To be reached [mm/s].
    asked : str
        The same as it was typed, with its unit.
    hopping : bool
        Whether the part may hop, up to a throw number of 10.

    Returns
    -------
    Answer
        Its record says under ``met`` whether there are any.
    """
    drive = _Drive.of(request)
    limit = drive.limit() if hopping else math.inf
    is_limited = math.isfinite(limit)
    highest = Regime.HOPPING if is_limited else Regime.BACK_SLIP
    found = feasible_amplitudes(drive.scene, SPEED.to_si(speed), highest_regime=highest.label, limit=limit)
    shares = {SCALE: 1.0} if SCALE in drive.shares else as_given(drive.shares, in_stroke=request.in_stroke)
    scene = scene_record(request)
    scene.pop(SCALE, None)  # which is asked for
    record = {
        "scene": scene,
        LEAST_SPEED.column: speed,
        "highest_regime": (Regime.HOPPING if hopping else Regime.BACK_SLIP).label,
        "met": bool(found),
        "amplitudes": [drive.record(interval) for interval in found],
    }
    where = f"up to throw number {MOST_DESIGN_THROW:g}" if is_limited else "without hopping"
    name, share = next(iter(shares.items()))
    quantity = QUANTITIES[name]
    others = {n: spec.value for n, spec in request.specs.items() if n not in (SCALE, *drive.shares)}
    rare = Fact("scene", scene_text(drive.scene, others), is_rare=True)
    title, notes = request.name or "Amplitude for a speed", []
    if is_limited:
        count = HOPS_SAMPLED[bool(drive.scene.restitution > 0.0)]
        notes.append(
            f"hops are sampled at {count} sizes up to throw number {MOST_DESIGN_THROW:g}: between two of them"
            " a part may be slower, or fast enough; irregular ones count with 3 standard errors less"
        )
        if not drive.scene.restitution:
            notes.append(f"{NO_BOUNCE}; --restitution changes that")
    if not found:
        text = f"none reaches {asked} {where}"
        size, speed_there = drive.best(limit)
        if speed_there > 0.0:
            reached, fast = float(quantity.from_si(size * share)), float(SPEED.from_si(speed_there))
            record["fastest"] = {"mean_velocity_mm_s": fast, quantity.column: reached}
            at = bound(reached, quantity.unit, upper=False)  # rounded down: the speed may jump above
            text += f"; the most is {shown(fast)} mm/s ({shown(METRES_PER_MINUTE * fast)} m/min) at {at}"
        notes += [] if hopping else ["with --hopping parts may hop too"]
        return Answer([Fact(quantity.label, text), rare], (), notes, record, title)
    if request.length is not None:
        notes.insert(0, f"over {request.length:.10g} mm that takes {shown(request.length / speed)} s")
    wide = next((x for x in found if x.high >= _WIDE * x.low), None)
    if wide not in (None, found[0]):
        start = f"{_rounded(wide, name, share)[0]} {quantity.unit}".rstrip()
        notes.insert(0, f"the first range is narrow: the first that is wider than 1 % begins at {start}")
    kept = sorted(found, key=lambda i: i.low / i.high)[:_MOST_ROWS]
    if len(kept) < len(found):
        notes.append(f"and {len(found) - len(kept)} narrower ones, where hops are irregular: --json has all")
    ends = [(x.low, x.high if math.isfinite(x.high) else x.low) for x in found]
    sizes = np.concatenate([np.linspace(*end, _LOOKED_AT) for end in ends])
    notes += several_motions(solve(drive.scenes(sizes), flight=False).coexists, "amplitudes")
    least = _rounded(found[0], name, share)[0]
    facts = [Fact(quantity.label, f"{least} {quantity.unit}".rstrip(), note=f"the least for {asked} {where}")]
    if name == "amplitude":
        facts.append(Fact("stroke", bound(2.0 * float(least), "mm", upper=True), note="peak to peak"))
    table = _table([interval for interval in found if interval in kept], shares)
    return Answer([*facts, rare], [table], notes, record, title)


def _table(found: Sequence[Interval], shares: Mapping[str, float]) -> Table:
    rows = []
    for interval in found:
        lows, highs = zip(*(_rounded(interval, n, x) for n, x in shares.items()), strict=True)
        end = _SETS[interval.high_set_by] if math.isfinite(interval.high) else None
        rows.append((*lows, *highs, _SETS[interval.low_set_by], end))
    columns = [(f"{QUANTITIES[n].label} {end}", QUANTITIES[n].unit) for end in ("from", "to") for n in shares]
    columns += [("begins by", ""), ("ends by", "")]
    return Table("amplitudes", columns, rows, "Where it is reached")


def _rounded(interval: Interval, name: str, share: float) -> tuple[str, str]:
    """Write both ends of a size in the unit outside, with six digits inside the interval."""
    ends = [float(QUANTITIES[name].from_si(end * share)) if share else 0.0 for end in interval[:2]]
    if math.isinf(ends[1]):
        return bound(ends[0], upper=True), "any"
    low, high = bound(ends[0], upper=True), bound(ends[1], upper=False)
    return (low, high) if float(low) <= float(high) else (repr(ends[0]), repr(ends[1]))
