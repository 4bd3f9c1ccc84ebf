"""Are guarantees what they say, and what do they cost? Boxes, references and whole questions.

Usage: python benchmarks/design.py REFERENCE.json QUESTION.toml... [--rows N] [--boxes 100] [--seed 0]
       python benchmarks/design.py --random 300 [--seed 0]

REFERENCE.json is tests/data/design_specs.json, the questions those of examples/. The slowest and the fastest
body of random boxes in contact, with bands of everything, are looked for, and again with ten times as many
bodies: an outlier is a body of the larger search that is further out by more than 1e-6 of the speed. The
gap is the distance of what is proved from the body found, over its speed. CPU times are in seconds, and in
units of one ``vibro.solve`` of a million scenes in contact, of the same run. Exits with 1 if there is an
outlier, if a row of the reference is missed by more than its rtol, or if a call takes longer than its budget.

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
from unittest import mock

import numpy as np

import vibro
from vibro import Regime, Scene
from vibro.designs import proofs
from vibro.designs.guarantees import BOXES
from vibro.designs.proofs import slowest_in_contact
from vibro.designs.spaces import uncertainty_set

if TYPE_CHECKING:
    from collections.abc import Callable

    from vibro.designs.spaces import UncertaintySet

    Row = dict[str, Any]

LARGE: Final = 10  # times as many bodies in a generation
OUTLIER: Final = 1e-6  # [1] of the speed
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


def random_box(rng: np.random.Generator) -> UncertaintySet:
    """Draw a box whose bodies stay in contact, a third each level, climbing and declining."""
    low = rng.uniform(0.15, 0.9)
    ratio = np.sort(rng.uniform(0.35, 1.0, 2))
    trough = rng.choice([0.0, 1.0, -1.0]) * rng.uniform(0.05, 0.7) * math.atan(low * ratio[0])
    drive = math.radians(rng.uniform(3.0, 50.0))
    drift, wobble = rng.uniform(0.0, 0.05), math.radians(rng.uniform(0.0, 1.5))
    kinetic = {"kinetic_friction": (low * ratio[0], low * ratio[1])}
    scene = Scene(
        amplitude=1.0,
        frequency=15.0,
        drive_angle=drive,
        static_friction=low,
        kinetic_friction=low * ratio[0],
        trough_angle=trough,
    )
    bands: dict[str, Any] = {
        "static_friction": (low, low * rng.uniform(1.0, 1.7)),
        "drive_angle": (max(drive - wobble, 0.0), drive + wobble),
        "trough_angle": (trough - 0.1 * abs(trough), trough + 0.1 * abs(trough)),
        "frequency": (15.0 * (1.0 - 0.2 * drift), 15.0 * (1.0 + 0.2 * drift)),
        **({"friction_ratio": tuple(ratio)} if rng.random() < 0.5 else kinetic),
    }
    box = uncertainty_set(scene, bands)
    load = float(box.hop_load) * rng.uniform(0.3, 0.98)
    amplitude = load * box.gravity / (2.0 * math.pi * box.frequency[1]) ** 2
    return replace(box, factor=(amplitude * (1.0 - drift), amplitude))


def compare_searches(count: int, seed: int) -> bool:
    rng = np.random.default_rng(seed)
    print("searches       boxes  outliers  most behind  gap > 1 %  largest gap  ms a box")
    sought = [random_box(rng) for _ in range(count)]
    outliers = 0
    for name, fast in (("slowest", False), ("fastest", True)):
        behind, gaps, times = [], [], []
        for box in sought:
            took, found = seconds(partial(slowest_in_contact, box, fast=fast, boxes=BOXES))
            with mock.patch.object(proofs, "_POPULATION", LARGE * proofs._POPULATION):
                large = slowest_in_contact(box, fast=fast, boxes=1).speeds[0]
            speed, proved = found.speeds[0], found.certificate.bound
            if math.isinf(speed):
                continue  # a body runs away, and nothing is further out
            size = max(abs(speed), 1e-12)
            behind.append((speed - large) / size)
            gaps.append((speed - (-proved.max() if fast else proved.min())) / size)
            times.append(took)
        beyond = int(np.count_nonzero(np.array(behind) > OUTLIER))
        outliers += beyond
        wide = int(np.count_nonzero(np.array(gaps) > 1e-2))
        numbers = f"{len(gaps):9d} {beyond:9d} {max(behind):12.1e} {wide:10d} {max(gaps):12.1e}"
        print(f"{name:10s} {numbers} {1e3 * sum(times) / len(times):9.1f}")
    return outliers == 0


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
    parser.add_argument("--boxes", type=int, default=100, help="random boxes to search")
    parser.add_argument("--random", type=int, default=0, help="random questions to ask, in place of all else")
    parser.add_argument("--seed", type=int, default=0)
    arguments = parser.parse_args()
    if arguments.random:
        raise SystemExit(not ask_random(arguments.random, arguments.seed))
    if arguments.reference is None:
        parser.error("give REFERENCE.json, or --random")
    rows = json.loads(arguments.reference.read_text(encoding="utf-8"))[: arguments.rows]
    agree = compare_searches(arguments.boxes, arguments.seed)
    if not (compare_rows(rows, arguments.questions) and agree):
        raise SystemExit(1)


if __name__ == "__main__":
    main()
