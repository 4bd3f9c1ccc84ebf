"""Frozen answers, kept in tests/data/frozen: answers again and compares, or makes them anew (a program).

    cd tests
    python -m helpers.frozen --compare   # each set: cells, equal to the bit, largest difference, beyond
    python -m helpers.frozen --make      # only where answers are meant to change: CHANGELOG.md says so

Beside the answers, the file of numbers has scales that put scenes next to one of their thresholds, and a byte
for each number: its condition, the sum over all inputs of its relative change over that of the input, as an
exponent of 2. Cells whose text rounding may change are not compared: no input may change it by 64 eps.
"""

from __future__ import annotations

import argparse
import math
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, NamedTuple

import numpy as np
from helpers.frozen_questions import Draws, batches

import vibro
from vibro.core.compiled import doors

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from helpers.frozen_questions import Batch
    from numpy.typing import NDArray

    Floats = NDArray[np.float64]
    Stored = dict[str, NDArray[Any]]


NUMBERS: Final = Path(__file__).parents[1] / "data" / "frozen" / "numbers.npz"
_NEAR: Final = ("contact", "harmonics", "steps", "samples")  # of these every tenth is next to a threshold
SETS: Final = (*_NEAR, "hops", "others", "histories", "machines")

_EPS: Final = float(np.finfo(np.float64).eps)
_PROMISE: Final = 16.0  # [eps] of a number in contact, over one more than its condition
_FOLLOWED: Final = 1e-9  # [1] relative promise of flights, histories, machines, and beyond one harmonic
_ERRORS: Final = 4.0  # [standard errors] of a mean over irregular motion
_LOOSE: Final = 1.0  # [1] of its largest speeds, which are those of a sample; its error is not compared
_SHARE: Final = 0.02  # [1] of its share in flight
_CLEAR: Final = 64.0  # [eps] change of an input that must not change a text
_MOST: Final = 38  # [log2] condition beyond which a number is not compared: rounding leaves it 3 digits
_OPEN: Final = 255  # code of such a condition
_EVERY: Final = 50  # without the compiled solver one cell of so many is compared

_STEADY: Final = (
    "displacement_per_cycle", "peak_velocity", "throw_number", "forward_ratio", "back_ratio",
    "flight_fraction", "impact_velocity", "period_cycles", "mean_velocity_error", "largest_multiplier",
)  # fmt: skip
_OPERATED: Final = (
    "amplitude", "amplitude_sine", "amplitude_empty", "amplitude_low", "amplitude_high", "phase",
    "relative_amplitude", "frequency_ratio", "filled_frequency_ratio", "added_mass_share",
    "added_damping_share", "second_harmonic",
)  # fmt: skip
_SCALED: Final = ("amplitude", "along_amplitude", "normal_amplitude", "motion_scale")
_CYCLES: Final = 6.0  # drive cycles of a history
_SAMPLED: Final = np.arange(1.0, 6.0) / 5.03  # [1] times at which it is sampled, over its length


class Answers(NamedTuple):
    """Answers to a batch: texts, and numbers by name, some with the size that may cancel in them."""

    texts: list[str]
    numbers: dict[str, Floats]
    sizes: dict[str, Floats]


def answer(name: str, batch: Batch) -> Answers:
    """Answer the questions of one batch of a set."""
    if name == "machines":
        return _operated(batch)
    return (
        _followed(batch) if name == "histories" else _solved(batch, starts=64 if name == "others" else None)
    )


def _solved(batch: Batch, *, starts: int | None) -> Answers:
    scene = vibro.Scene.allowing_infeasible(**batch)
    cycle = vibro.solve(scene, starts=starts)
    advance = cycle.displacement_per_cycle * batch["frequency"]
    as_fast = np.isclose(cycle.mean_velocity, advance, rtol=4.0 * _EPS, atol=0.0, equal_nan=True)
    codes = zip(cycle.regime, cycle.pattern, cycle.status, cycle.coexists, cycle.model, as_fast, strict=True)
    texts = [
        f"{vibro.Regime(r).label} {p} {vibro.Status(s).label} {c} {m}{'' if same else ' at another speed'}"
        for r, p, s, c, m, same in codes
    ]
    numbers = {key: np.array(getattr(cycle, key)) for key in _STEADY}
    numbers["mean_velocity_error"] /= batch["frequency"]  # that of the displacement
    cancels = [("F" in p and "B" in p) or "H" in p for p in cycle.pattern]
    sizes = {
        "displacement_per_cycle": np.where(cancels, scene.scale, np.abs(cycle.displacement_per_cycle)),
        "impact_velocity": 2.0 * math.pi * batch["frequency"] * scene.scale,
        "flight_fraction": np.ones(len(texts)),
    }
    return Answers(texts, numbers, sizes)


def _followed(batch: Batch) -> Answers:
    moments = [f"{key}_{i}" for key in ("position", "velocity", "gap") for i in range(_SAMPLED.size)]
    names = [*moments, "cycle_displacement", "settles_at", "arrival_time"]
    texts, rows, scales = [], [], []
    for i, frequency in enumerate(batch["frequency"].tolist()):
        one = _cell(batch, i)
        length, start = one.pop("length"), {key: float(one.pop(key)) for key in list(one) if "start" in key}
        scene = vibro.Scene.allowing_infeasible(**one)
        scales.append(float(scene.scale))
        try:
            history = vibro.simulate(scene, cycles=_CYCLES, **start)
        except vibro.VibroError as exc:
            texts.append(str(exc))
            rows.append([math.nan] * len(names))
            continue
        kinds = "".join(phase.kind for phase in history.phases)
        texts.append(f"{history.pattern} {history.period_cycles} {kinds}")
        at = history.sample(_SAMPLED * (_CYCLES / frequency))
        arrives = float(vibro.arrival_time(scene, length, **start))
        moved = np.concatenate([at.position, at.velocity, at.gap]).tolist()
        rows.append([*moved, history.cycle_displacement, history.settles_at, arrives])
    scale, w = np.array(scales), 2.0 * math.pi * batch["frequency"]
    sizes = {name: scale * w if "velocity" in name else scale for name in names[:-2]}
    return Answers(texts, dict(zip(names, np.array(rows).T.copy(), strict=True)), sizes)


def _operated(batch: Batch) -> Answers:
    point = vibro.operate(**batch, allow_strikes=True)
    codes = zip(point.status, point.number, point.at_jump, point.strikes, strict=True)
    texts = [f"{vibro.Status(s).label} {n} jump={j:d} strikes={x:d}" for s, n, j, x in codes]
    return Answers(texts, {key: np.array(getattr(point, key)) for key in _OPERATED}, {})


def _cell(batch: Batch, cells: Any) -> Batch:
    """Take some cells of a batch."""
    return {key: x[..., cells] if isinstance(x, np.ndarray) else x for key, x in batch.items()}


def questions(name: str, stored: Stored) -> Iterator[Batch]:
    """Draw the questions of a set, and put some next to a threshold."""
    begin = 0
    for batch in batches(name):
        end = begin + batch["frequency"].size
        scale = stored[f"{name}.scale"][begin:end] if name in _NEAR else 1.0
        yield batch | {key: batch[key] * scale for key in _SCALED if key in batch and name in _NEAR}
        begin = end


def _scales(name: str) -> Floats:
    """Find the scales that put every tenth scene 2^-40 to 2^-20 from one of its thresholds."""
    found, draw = [], Draws(f"near {name}")
    for batch in batches(name):
        scale = np.ones(batch["frequency"].size)
        for i in range(0, scale.size, 10):
            try:
                thresholds = vibro.transitions(vibro.Scene(**_cell(batch, i)))
            except vibro.VibroError:  # impossible frictions
                thresholds = ()
            pick, side, distance = draw(0.0, 1.0, 3).tolist()
            if thresholds:
                beside = math.copysign(2.0 ** -(20 + int(20 * distance)), side - 0.5)
                scale[i] = (1.0 + beside) / thresholds[int(pick * len(thresholds))].ratio
        found.append(scale)
    return np.concatenate(found)


def _changed(batch: Batch, name: str, factor: float) -> Batch:
    """Change one input, and keep kinetic friction possible."""
    new = batch | {name: batch[name] * factor}
    possible = batch["kinetic_friction"] <= batch["static_friction"]
    limit = np.where(possible, new["static_friction"], math.inf)
    return new | {"kinetic_friction": np.minimum(new["kinetic_friction"], limit)}


def _conditions(name: str, batch: Batch, found: Answers) -> tuple[list[str], Stored]:
    """Return the texts, empty where rounding may change them, and the codes of the numbers' conditions."""
    clear = np.ones(len(found.texts), np.bool_)
    sums = {key: np.zeros(clear.size) for key in found.numbers}
    for field in [key for key, x in batch.items() if isinstance(x, np.ndarray)]:
        others = [answer(name, _changed(batch, field, 1.0 + side * _CLEAR * _EPS)) for side in (-1.0, 1.0)]
        for other in others:
            clear &= np.array(other.texts) == np.array(found.texts)
        for key, x in found.numbers.items():
            with np.errstate(all="ignore"):
                changes = [np.abs((other.numbers[key] - x) / (_CLEAR * _EPS * x)) for other in others]
            same = [_equal(other.numbers[key], x) for other in others]
            sums[key] += np.max(np.where(same, 0.0, changes), axis=0)
            mean = _is_mean(found.texts) & (key in _STEADY)
            for other in others:
                clear &= ~mean | (_units(name, key, found, other, np.full(x.shape, _OPEN)) <= 1.0)
    with np.errstate(all="ignore"):
        logs = {key: np.ceil(np.log2(np.maximum(x, 1.0))) for key, x in sums.items()}
    codes = {key: np.where(x <= _MOST, x, _OPEN).astype(np.uint8) for key, x in logs.items()}
    return np.where(clear, found.texts, "").tolist(), codes


def _is_mean(texts: list[str]) -> NDArray[np.bool_]:
    return np.array([" averaged " in text for text in texts])


def _equal(x: Floats, y: Floats) -> NDArray[np.bool_]:
    return np.asarray((x == y) | (np.isnan(x) & np.isnan(y)))


def _units(name: str, key: str, old: Answers, new: Answers, code: NDArray[Any]) -> Floats:
    """Return the differences of a number in units of what is promised of it."""
    x, y = old.numbers[key], new.numbers[key]
    magnitude = np.abs(x)
    size = old.sizes.get(key, magnitude)
    condition = np.where(code == _OPEN, math.inf, 2.0 ** np.minimum(code, _MOST).astype(np.float64))
    in_contact = [name == "contact" and "flight" not in text for text in old.texts]
    with np.errstate(all="ignore"):
        followed = np.where(in_contact, 0.0, _FOLLOWED) * np.maximum(size, magnitude)
        promise = _PROMISE * _EPS * (np.where(x == 0.0, 0.0, condition * magnitude) + size) + followed
        if key in _STEADY:
            errors = np.hypot(old.numbers["mean_velocity_error"], new.numbers["mean_velocity_error"])
            means = {
                "displacement_per_cycle": _ERRORS * errors,
                "mean_velocity_error": np.full(x.shape, math.inf),
                "flight_fraction": _SHARE * magnitude,
            }
            mean = means.get(key, _LOOSE * magnitude)
            promise = np.where(_is_mean(old.texts), mean, promise)
        units = np.where(np.isinf(promise), 0.0, np.abs(x - y) / promise)
    return np.where(_equal(x, y), 0.0, np.where(np.isnan(units), math.inf, units))


class Comparison(NamedTuple):
    """How a set compares: its cells or values, those not compared, and those equal to the bit.

    ``worst`` is the largest difference in units of its promise, infinite for texts; ``beyond`` describes
    those that differ by more than one.
    """

    cells: int
    left_out: int
    equal: int
    worst: float
    beyond: list[str]


def compare(name: str, stored: Stored) -> Comparison:
    """Answer a set anew, and compare."""
    texts, begin, all_units, equal, beyond = _texts_of(stored, name), 0, [0.0], 0, []
    every = 1 if doors().compiled else _EVERY
    cells = left_out = 0
    for whole in questions(name, stored):
        size = whole["frequency"].size
        batch, own = _cell(whole, slice(None, None, every)), slice(begin, begin + size, every)
        new, begin = answer(name, batch), begin + size
        old = Answers(texts[own], {key: stored[f"{name}.{key}"][own] for key in new.numbers}, new.sizes)
        asked = np.array([text != "" for text in old.texts])
        worst = np.where(np.array(old.texts) == np.array(new.texts), 0.0, math.inf)
        same, where = worst == 0.0, np.full(worst.shape, "text", dtype=object)
        for key, x in new.numbers.items():
            units = _units(name, key, old, new, stored[f"{name}.{key}.condition"][own])
            where[units > worst] = key
            worst = np.maximum(worst, units)
            same &= _equal(x, old.numbers[key])
        for i in np.flatnonzero(asked & (worst > 1.0)).tolist():
            was, now = old.texts[i], new.texts[i]
            if where[i] != "text":
                was, now = (f"{float(z.numbers[where[i]][i])!r}" for z in (old, new))
            one = _cell(batch, i)
            given = {
                key: x.tolist() if isinstance(x, np.ndarray | np.generic) else x for key, x in one.items()
            }
            beyond.append(f"{name}: {where[i]} was {was}, is {now} ({worst[i]:.3g}) of {given}")
        cells += asked.size
        left_out += int((~asked).sum())
        equal += int((asked & same).sum())
        all_units.append(float(worst[asked].max(initial=0.0)))
    return Comparison(cells, left_out, equal, max(all_units), beyond)


def read() -> Stored:
    """Read the numbers that are stored."""
    with np.load(NUMBERS) as stored:
        return dict(stored)


def _texts_of(stored: Stored, name: str) -> list[str]:
    return stored[f"{name}.texts"].tobytes().decode().split("\n")


def _made(name: str, stored: Stored) -> Stored:
    """Answer a set of scenes for the first time."""
    texts, numbers, codes = [], [], []
    for batch in questions(name, stored):
        found = answer(name, batch)
        told, code = _conditions(name, batch, found)
        texts += told
        numbers.append(found.numbers)
        codes.append(code)
    made: Stored = {f"{name}.texts": np.frombuffer("\n".join(texts).encode(), np.uint8)}
    for key in numbers[0]:
        made[f"{name}.{key}"] = np.concatenate([part[key] for part in numbers])
        made[f"{name}.{key}.condition"] = np.concatenate([part[key] for part in codes])
    return made


def make(names: Sequence[str]) -> None:
    """Make the answers of some sets anew."""
    stored: Stored = dict(read()) | {f"{name}.scale": _scales(name) for name in _NEAR if name in names}
    for name in SETS:
        if name in names:
            stored |= _made(name, stored)
    np.savez_compressed(NUMBERS, **stored)  # type: ignore[arg-type]


if __name__ == "__main__":
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    ways = parser.add_mutually_exclusive_group(required=True)
    ways.add_argument("--make", nargs="*", choices=SETS, help="make the answers of these sets, or all, anew")
    ways.add_argument("--compare", action="store_true", help="compare, after --make too")
    wanted = parser.parse_args().make
    if wanted is not None:
        make(wanted or SETS)
    kept = read()
    print(f"{'set':12}{'values':>8}{'left out':>10}{'equal':>8}{'largest':>12}{'beyond':>8}")
    for name in SETS:
        count, left_out, equal, worst, beyond = compare(name, kept)
        print(f"{name:12}{count:8}{left_out:10}{equal:8}{worst:12.3g}{len(beyond):8}")
        for line in beyond[:3]:
            print(f"  {line}")
