"""Are guarantees what they say, and what do they cost? Boxes, references and whole questions.

Usage: python benchmarks/design.py [REFERENCE.json QUESTION.toml...] [--rows N] [--boxes 100] [--seed 0]
       python benchmarks/design.py --random 300 [--seed 0]

REFERENCE.json is tests/data/design_specs.json, the questions those of examples/. Random boxes of lines and
ellipses in contact, and of lines that hop, are guaranteed; bodies are drawn in them, and the slowest and the
fastest of these moved on by samples around them. A violation is a body beyond a speed: beyond one that is
guaranteed, beyond one of a sample, and beyond the extreme body that the search has found. Sizes are over the
speed or, where that is less, 1 % of the trough's largest speed. The gap is the distance of what is proved
from the body found. CPU times are in seconds, and in units of one ``vibro.solve`` of a million scenes in
contact, of the same run. Exits with 1 if a guaranteed speed is violated by more than rounding, if a row of
the reference is missed by more than its rtol, or if a call takes longer than its budget.

With --random, random questions of all drives are asked instead; it exits with 1 if one ends by an unexpected
error.
"""

from __future__ import annotations

import argparse
import json
import math
import time
import traceback
from collections import Counter, defaultdict
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import numpy as np

import vibro
from vibro import Regime, Scene
from vibro.designs.guarantees import counted, guarantee_of
from vibro.designs.proofs import trough_speed
from vibro.designs.spaces import uncertainty_set
from vibro.results.designs import GUARANTEED

if TYPE_CHECKING:
    from collections.abc import Callable

    from vibro.designs.spaces import UncertaintySet

    Row = dict[str, Any]

BODIES: Final = 4096  # drawn in each box
KEPT, AROUND, ROUNDS = 16, 24, 14  # extreme bodies, bodies around each, and rounds, each half as wide
ROUNDING: Final = 1e-12  # [1] of the speed
#: Most that a call may take, in units of a solution of 1e6 scenes.
BUDGETS: Final = {
    "range": 20.0,
    "amplitude": 5.0,
    "window": 5.0,
    "fastest": 20.0,
    "gentlest": 20.0,
    "yield": 20.0,
    "question": 30.0,
}
#: A question whose slowest part lies in a narrow valley just past the entry of back slip.
VALLEY: Final = {
    "scene": {"static_friction": "0.5:0.6", "friction_ratio": "0.7:0.9", "trough_angle_deg": 1.0},
    "drive": [{"amplitude_mm": 3.0, "frequency_hz": "15.0:25.0", "drive_angle_deg": "25.0:30.0"}],
    "drift": {"drive_angle_deg": 2.0},
    "goal": {"speed_mm_s": 20.0, "highest_regime": "forward-slip"},
}


def seconds(run: Callable[[], Any]) -> tuple[float, Any]:
    start = time.process_time()
    result = run()
    return time.process_time() - start, result


def million() -> Scene:
    """Make a million scenes in contact."""
    return Scene(
        amplitude=np.linspace(0.5e-3, 3e-3, 1000)[:, None],
        frequency=15.0,
        drive_angle=math.radians(20),
        static_friction=0.74,
        kinetic_friction=np.linspace(0.3, 0.74, 1000),
    )


def random_box(rng: np.random.Generator, *, kind: str) -> UncertaintySet:
    """Draw a box, a third each level, climbing and declining; each band is there with some chance."""
    low = rng.uniform(0.1, 0.9)
    ratio = np.sort(rng.uniform(0.35, 1.0, 2))
    trough = rng.choice([0.0, 1.0, -1.0]) * rng.uniform(0.05, 0.7) * math.atan(low * ratio[0])
    tilt = rng.uniform(0.0, 0.1) * abs(trough) + rng.uniform(0.0, 0.01)
    drive, frequency = math.radians(rng.uniform(2.0, 60.0)), rng.uniform(8.0, 50.0)
    drive = min(drive, 1.3 - max(trough, 0.0))
    motion: dict[str, Any] = {"amplitude": 1.0, "drive_angle": drive}
    bands: dict[str, Any] = {"drive_angle": (drive, drive + rng.uniform(0.0, 0.08))}
    if kind == "ellipses":
        normal, phase = 10.0 ** rng.uniform(-1.0, 0.1), rng.uniform(-math.pi, math.pi)
        motion = {"along_amplitude": 1.0, "normal_amplitude": normal, "normal_phase": phase}
        bands = {"normal_phase": (phase, phase + rng.uniform(0.0, 0.1))}
    kinetic = {"kinetic_friction": (low * ratio[0], low * ratio[1])}
    bands |= {
        "static_friction": (low, low * rng.uniform(1.0, 1.7)),
        "trough_angle": (trough - tilt, trough + tilt),
        "frequency": (frequency * rng.uniform(0.95, 1.0), frequency),
        **({"friction_ratio": tuple(ratio)} if rng.random() < 0.5 else kinetic),
    }
    scene = Scene(
        **motion,
        frequency=frequency,
        trough_angle=trough,
        static_friction=low,
        kinetic_friction=low * ratio[0],
    )
    box = uncertainty_set(scene, {name: band for name, band in bands.items() if rng.random() < 0.5})
    share = rng.uniform(1.0, 3.0) if kind == "hops" else rng.uniform(0.1, 0.98)
    factor = float(share * box.hop_load / box.load[1])
    return replace(box, factor=(factor * (1.0 - rng.uniform(0.0, 0.4) * (rng.random() < 0.7)), factor))


def beyond(box: UncertaintySet, fast: bool, rng: np.random.Generator) -> float:
    """Return the speed of the slowest, or the fastest, of bodies that are drawn, and of those around."""
    side = -1.0 if fast else 1.0

    def costs(x: Any) -> Any:
        points = box.points(x)
        cycles = (vibro.solve(box.scene(points, fast=which)) for which in (False, True))
        return np.nan_to_num(np.minimum(*(side * counted(one, fast=fast) for one in cycles)), nan=np.inf)

    x = np.clip(1.3 * rng.random((len(box.axes), BODIES)) - 0.15, 0.0, 1.0)
    found, width = costs(x), 0.1
    for _ in range(ROUNDS):
        best = np.argsort(found)[:KEPT]
        near = np.repeat(x[:, best], AROUND, axis=1)
        near = np.clip(near + width * rng.standard_normal(near.shape), 0.0, 1.0)
        x, found = np.hstack([x[:, best], near]), np.append(found[best], costs(near))
        width *= 0.5
    return side * float(found.min())


def count_violations(count: int, seed: int) -> bool:
    print(
        "boxes      proof     speeds  violated  by at most  found beaten  by at most  gap > 1 %  largest gap"
    )
    good, times = True, []
    for kind in ("lines", "ellipses", "hops"):
        groups: dict[str, list[tuple[float, float, float]]] = defaultdict(list)
        for i in range(count if kind == "lines" else count // 4):
            rng = np.random.default_rng([seed, i])
            box = random_box(rng, kind=kind)
            took, known = seconds(partial(guarantee_of, box))
            times.append(took)
            for end, fast in (("min", False), ("max", True)):
                speed, found, proof = (
                    getattr(known, f"{name}_{end}") for name in ("speed", "found", "proof")
                )
                if not math.isfinite(speed):
                    continue  # a body runs away, and nothing is further out
                met, side = beyond(box, fast, rng), -1.0 if fast else 1.0
                size = max(abs(speed), 0.01 * trough_speed(box))
                groups[proof].append(
                    tuple(side * x / size for x in (speed - met, found - met, found - speed))
                )
        for proof, rows in groups.items():
            outside, behind, gap = np.array(rows).T
            sure = proof in GUARANTEED
            good &= not (sure and outside.max() > ROUNDING)
            least = ROUNDING if sure else 1e-6
            numbers = f"{len(rows):7d} {np.count_nonzero(outside > least):9d} {max(outside.max(), 0.0):11.1e}"
            numbers += f" {np.count_nonzero(behind > 1e-6):13d} {max(behind.max(), 0.0):11.1e}"
            print(f"{kind:10s} {proof:9s} {numbers} {np.count_nonzero(gap > 1e-2):10d} {gap.max():12.1e}")
    print(f"guarantees: {1e3 * np.mean(times):.0f} ms on average, {1e3 * max(times):.0f} at most")
    return good


def friction(row: Row) -> Row:
    """Read the friction bands of a row."""
    name = "friction_ratio" if "mu_d_over_mu_s" in row else "kinetic_friction"
    return {"static_friction": row["mu_s"], name: row.get("mu_d_over_mu_s") or row["mu_d"]}


def scene_of(row: Row) -> Scene:
    static, kinetic = (float(np.max(row[name if name in row else "mu_s"])) for name in ("mu_s", "mu_d"))
    return Scene(
        amplitude=row.get("amplitude_mm", 1.0) / 1e3,
        frequency=row["frequency_hz"],
        drive_angle=math.radians(row["drive_angle_deg"]),
        trough_angle=math.radians(row["trough_angle_deg"]),
        static_friction=static,
        kinetic_friction=kinetic,
    )


def text(value: Any) -> str:
    """Write a band, or a number, as specs do."""
    return ":".join(map(repr, value)) if isinstance(value, list) else repr(value)


def spec_of(row: Row) -> Row:
    """Write a row as a spec; the drive's limits as they are."""
    ratio = "friction_ratio" if "mu_d_over_mu_s" in row else "kinetic_friction"
    drive = {
        "amplitude_mm": row["amplitude_max_mm"],
        "frequency_hz": text(row["frequency_hz"]),
        "drive_angle_deg": text(row["drive_angle_deg"]),
    }
    if "acceleration_max_g" in row:
        drive["acceleration_g"] = row["acceleration_max_g"]
    scene = {
        "static_friction": text(row["mu_s"]),
        ratio: text(row.get("mu_d_over_mu_s") or row["mu_d"]),
        "trough_angle_deg": row["trough_angle_deg"],
    }
    return {
        "scene": scene,
        "drive": [drive],
        "goal": {"speed_mm_s": row["target_mm_s"], "highest_regime": row["regime"]},
    }


def designed(row: Row) -> tuple[Callable[[], Any], Callable[[Any], float]]:
    """Return the call that answers a row that asks for a setting, and how far its result is off."""
    name, key = {
        "fastest": ("speed_min_mm_s", "speed_guaranteed_mm_s"),
        "gentlest": ("acceleration_g", "acceleration_g"),
    }[row["kind"]]

    def error(result: Any) -> float:
        (design,) = (
            d for d in result.designs if (d.design, d.highest_regime) == (row["kind"], row["regime"])
        )
        value = getattr(design, name)
        return math.inf if value is None else abs(float(value / row["answer"][key]) - 1.0)

    return lambda: vibro.design(spec_of(row), digits=9), error


def ranged(row: Row) -> tuple[Callable[[], Any], Callable[[Any], float]]:
    bands = friction(row)
    for name, unit in (("amplitude", "mm"), ("frequency", "hz")):
        value, drift = (
            row[f"{name}_{unit}"] / (1e3 if unit == "mm" else 1.0),
            row[f"tol_{name}_percent"] / 100.0,
        )
        bands[name] = (value * (1.0 - drift), value * (1.0 + drift))
    for name in ("drive_angle", "trough_angle"):
        bands[name] = tuple(np.radians(row[f"{name}_deg"] + row[f"tol_{name}_deg"] * np.array([-1.0, 1.0])))

    def error(found: Any) -> float:
        return max(
            abs(float(1e3 * value / row["answer"][key]) - 1.0)
            for value, key in ((found.speed_min, "speed_min_mm_s"), (found.speed_max, "speed_max_mm_s"))
        )

    return lambda: vibro.guarantee(scene_of(row), **bands), error


def windowed(row: Row) -> tuple[Callable[[], Any], Callable[[Any], float]]:
    answer = row["answer"]
    expected = answer.get("feasible_mm") or ([answer["amplitude_mm"]] if answer["feasible"] else [])
    bands = friction(row) if row["kind"] == "window" else {}
    highest = row.get("regime", Regime.BACK_SLIP.label)

    def error(found: Any) -> float:
        if len(found) != len(expected):
            return math.inf
        ends = (
            (1e3 * a, b)
            for i, e in zip(found, expected, strict=True)
            for a, b in zip(i[:2], e[:2], strict=True)
        )
        return max((abs(a / b - 1.0) for a, b in ends), default=0.0)

    return (
        lambda: vibro.feasible_amplitudes(
            scene_of(row), row["target_mm_s"] / 1e3, highest_regime=highest, **bands
        )
    ), error


def shared(row: Row) -> tuple[Callable[[], Any], Callable[[Any], float]]:
    def error(found: Any) -> float:  # in units of four standard errors, of the tolerance
        share, standard = found
        off = abs(share - float(row["answer"]["share"])) / (4.0 * standard)
        return float(off * row["rtol"]) if standard <= 3e-4 else math.inf

    return (
        lambda: vibro.yield_share(
            scene_of(row), row["target_mm_s"] / 1e3, highest_regime=row["regime"], **friction(row)
        )
    ), error


ASK: Final = {
    "amplitude": windowed,
    "window": windowed,
    "range": ranged,
    "fastest": designed,
    "gentlest": designed,
    "yield": shared,
}


def compare_rows(rows: list[Row], questions: list[Path]) -> bool:
    scene = million()
    vibro.solve(scene)
    unit = min(seconds(lambda: vibro.solve(scene))[0] for _ in range(3))
    groups: dict[str, list[tuple[float, float]]] = defaultdict(list)
    for row in rows:
        run, error = ASK[row["kind"]](row)
        took, result = seconds(run)
        groups[row["kind"]].append((error(result) / row["rtol"], took / unit))
    asked: list[Row | Path] = [VALLEY, *questions]
    for question in asked:
        took, _ = seconds(partial(vibro.design, question))
        groups["question"].append((0.0, took / unit))
    print(f"\none solution of 1e6 scenes: {unit:.2f} s, the unit of time")
    print("rows        count    missed  error/rtol  longest    [s]  budget")
    good = True
    for kind, pairs in groups.items():
        errors, times = (np.array(x) for x in zip(*pairs, strict=True))
        missed = int(np.count_nonzero(~(errors <= 1.0)))
        good &= missed == 0 and bool(times.max() <= BUDGETS[kind])
        numbers = f"{missed:9d} {errors.max():11.1e} {times.max():8.1f} {unit * times.max():6.1f}"
        print(f"{kind:10s} {len(pairs):6d} {numbers} {BUDGETS[kind]:7.0f}")
    designs = unit * np.array([t for kind in ("fastest", "gentlest", "question") for _, t in groups[kind]])
    print(f"designs: {len(designs)}, median {np.median(designs):.2f} s, longest {designs.max():.2f} s")
    return good


def random_question(rng: np.random.Generator, kind: str, slope: float) -> Row:
    """Draw a question about a drive of a kind, on a trough inclined by a share of the angle of friction."""

    def drawn(low: float, high: float) -> float:
        return float(f"{rng.uniform(low, high):.3g}")

    def band(low: float, high: float, widest: float = 1.5) -> float | str:
        """Draw a number, or a range that is wider by a factor."""
        first = drawn(low, high)
        return f"{first}:{first * drawn(1.02, widest):.4g}" if rng.random() < 0.7 else first

    def some(chance: float, **entries: Any) -> Row:
        return entries if rng.random() < chance else {}

    friction, hertz = drawn(0.15, 0.7), drawn(8.0, 50.0)
    size = 1e3 * 9.81 / (2.0 * math.pi * hertz) ** 2  # [mm] at a load of 1
    along, normal = drawn(0.5, 3.0) * size, drawn(0.1, 0.5) * size
    wave = np.sin(np.arange(12) * math.pi / 6.0) + rng.normal(0.0, 0.3, (2, 12))
    wave -= wave.mean(axis=1, keepdims=True)
    push, share = drawn(0.4, 0.95) * 9.81 * friction, drawn(0.55, 0.85)
    lift = drawn(-3.0, 3.0)
    scaled = {"motion_scale": band(0.7, 1.5), "frequency_hz": band(0.8 * hertz, hertz)}
    line = {"drive_angle_deg": band(5.0, 45.0)}
    drive = {
        "line": {
            str(rng.choice(["amplitude_mm", "stroke_mm"])): band(0.3 * size, 4.0 * size, 5.0),
            "frequency_hz": f"{hertz},{1.5 * hertz}" if rng.random() < 0.2 else band(hertz, 1.2 * hertz),
            **line,
            **some(0.3, acceleration_g=drawn(5.0, 20.0)),
        },
        "ellipse": {
            "along_amplitude_mm": band(along, 1.5 * along),
            "normal_amplitude_mm": band(normal, 1.5 * normal),
            "normal_phase_deg": f"{drawn(-60.0, 0.0)}:{drawn(0.0, 60.0)}",
            "frequency_hz": hertz,
        },
        "harmonics": {
            "along_harmonics_mm_deg": [[along, 0.0], [drawn(0.0, 0.2) * along, drawn(-180.0, 180.0)]],
            "normal_harmonics_mm_deg": [[normal, drawn(-40.0, 40.0)]],
            **scaled,
        },
        "steps": {
            "along_steps": [[share, push], [1.0 - share, -push * share / (1.0 - share)]],
            **some(0.3, normal_steps=[[0.5, lift], [0.5, -lift]]),
            "motion_scale": band(0.7, 1.5),
            "frequency_hz": band(1.0, 5.0),
        },
        "samples": {
            "along_samples_m_s2": (drawn(6.0, 20.0) * wave[0]).tolist(),
            "normal_samples_m_s2": (drawn(1.0, 5.0) * wave[1]).tolist(),
            **scaled,
        },
        "magnet": {
            "kind": "magnet", "trough_mass_kg": 6, "counter_mass_kg": 12, "damping_ratio": 0.015,
            "natural_hz": drawn(45.0, 62.0),
            "calibration": {"amplitude_mm": drawn(0.1, 0.6), "frequency_hz": 50},
            **some(0.2, filling_kg="0:1"), **some(0.5, voltage_percent="95:105"),
            "frequency_hz": 50,
            **line,
        },
        "crank": {
            "kind": "crank", "crank_radius_mm": along, "frequency_hz": band(0.8 * hertz, hertz), **line
        },
    }[kind]  # fmt: skip
    ratio = band(0.5, 0.85, 1.15) if rng.random() < 0.7 else None
    return {
        "scene": {
            "static_friction": band(friction, friction, 1.3),
            **(
                {"friction_ratio": ratio}
                if ratio
                else {"kinetic_friction": band(0.6 * friction, 0.7 * friction)}
            ),
            "trough_angle_deg": float(f"{slope * math.degrees(math.atan(friction)):.2g}"),
            **some(0.03, restitution=drawn(0.1, 0.6)),
        },
        "drive": [drive],
        "drift": {
            **some(0.5, amplitude_percent=drawn(0.0, 4.0)),
            **some(0.3, frequency_percent=drawn(0.0, 1.0)),
            **some(0.3, trough_angle_deg=0.2),
        },
        "goal": {
            "speed_mm_s": float(f"{10.0 ** rng.uniform(0.0, 1.5):.2g}"),
            "highest_regime": str(rng.choice(["forward-slip", "back-slip", "hopping"], p=[0.5, 0.4, 0.1])),
            **some(0.1, impact_speed_mm_s=drawn(10.0, 200.0)),
            **some(0.1, flight_fraction=drawn(0.1, 0.8)),
        },
        **some(0.15, part={"half_base_mm": drawn(2.0, 10.0), "centre_height_mm": drawn(2.0, 10.0)}),
    }


RANDOM_DRIVES: Final = ("line", "ellipse", "harmonics", "steps", "samples", "magnet", "crank")


def ask_random(count: int, seed: int) -> bool:
    """Ask random questions, in turn of every kind of drive; return whether none ends unexpectedly."""
    groups: dict[str, list[tuple[str, float]]] = defaultdict(list)
    for i in range(count):
        rng = np.random.default_rng([seed, i])
        kind = RANDOM_DRIVES[i % len(RANDOM_DRIVES)]
        question = random_question(rng, kind, float(rng.choice([0.0, 1.0, -1.0]) * rng.uniform(0.05, 0.6)))
        only: Any = "goal" if rng.random() < 0.9 else None
        start, why = time.process_time(), ""
        try:
            end = "met" if vibro.design(question, only=only).met else "missed"
        except vibro.VibroError as exc:
            end, why = "refused", str(exc)
        except Exception:
            end, why = "broken", f"{question}\n{traceback.format_exc()}"
        groups[kind].append((end, took := time.process_time() - start))
        print(f"{i} {kind}, only={only}: {end} {took:.1f} s {why}", flush=True)
    print("drive      questions   met  missed  refused  broken  median [s]  longest [s]")
    for kind, ends in groups.items():
        counts = Counter(end for end, _ in ends)
        times = np.array([took for _, took in ends])
        told = f"{counts['met']:5d} {counts['missed']:7d} {counts['refused']:8d} {counts['broken']:7d}"
        print(f"{kind:10s} {len(ends):9d} {told} {np.median(times):11.1f} {times.max():12.1f}")
    return all(end != "broken" for ends in groups.values() for end, _ in ends)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("reference", type=Path, nargs="?", help="tests/data/design_specs.json")
    parser.add_argument("questions", type=Path, nargs="*", help="questions, as those of examples/")
    parser.add_argument("--rows", type=int, help="how many of the reference are asked; all if left out")
    parser.add_argument("--boxes", type=int, default=100, help="random boxes of lines; of others a quarter")
    parser.add_argument("--random", type=int, default=0, help="random questions to ask, in place of all else")
    parser.add_argument("--seed", type=int, default=0)
    arguments = parser.parse_args()
    if arguments.random:
        raise SystemExit(not ask_random(arguments.random, arguments.seed))
    rows = []
    if arguments.reference is not None:
        rows = json.loads(arguments.reference.read_text(encoding="utf-8"))[: arguments.rows]
    agree = count_violations(arguments.boxes, arguments.seed)
    if not (agree and (not rows or compare_rows(rows, arguments.questions))):
        raise SystemExit(1)


if __name__ == "__main__":
    main()
