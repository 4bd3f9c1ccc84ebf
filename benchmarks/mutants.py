"""Do the tests of a room notice faults in its code? Mutants: each is one fault that people make.

Usage: python benchmarks/mutants.py [--only TEXT ...]

Works on a copy of this checkout, which stays as it is. The tests of a room run with each of its faults in
turn, until the first of them fails; in the end those that failed run without any. A mutant that survives
shows what they do not test, unless its fault changes nothing that can be seen. The solver is compiled anew
for each mutant in it, so that a C compiler is needed; those in the page need Chromium. Exits with 1 if fewer
than ``ENOUGH`` are killed, or a test that has killed one fails without a fault too.

``--only`` takes parts of a mutant's file or text: "core/", "plots/scales".
"""

from __future__ import annotations

import argparse
import os
import re
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Final, NamedTuple

ROOT: Final = Path(__file__).parents[1]
ENOUGH: Final = 50  # killed
LIMIT: Final = 300.0  # [s] of a mutant's tests: one that runs for longer never ends, and is killed too
SHOWN: Final = 60  # characters of a mutant


class Mutant(NamedTuple):
    """A fault: a text that is in a file once, what stands in its place, and the tests of the room."""

    file: str
    old: str
    new: str
    tests: str

    def __str__(self) -> str:
        return f"{self.file}: {self.old} -> {self.new or 'nothing'}"

    def put_into(self, text: str) -> str:
        """Return a file's text with the fault in it."""
        if text.count(self.old) != 1:
            raise ValueError(f"{self.file} has {self.old!r} {text.count(self.old)} times, not once")
        return text.replace(self.old, self.new)


# By a file below src/vibro and its tests, a file below tests or one test of it: a text, and what replaces it.
_FAULTS: Final = {
    ("core/slide.py", "core/test_slide.py"): [
        ("kappa - c_square * series_q", "kappa + c_square * series_q"),
        ("resistance = 2.0 * k", "resistance = 4.0 * k"),
    ],
    ("core/legs.py", "core/test_legs.py"): [
        ("drag = friction * loads.weight_normal + way", "drag = friction * loads.weight_normal - way"),
        ("last_top if at.drag < 0.0", "last_top if at.drag > 0.0"),
    ],
    ("core/contact.py", "core/test_contact.py"): [
        ("f_only = f_lasts >= 0", "f_only = f_lasts > 0"),
        ("cycle.valid or _settles_in_f_b(loads, pair, b_lasts)", "cycle.valid"),
    ],
    ("core/limits.py", "core/test_limits.py"): [
        ("held = abs(t) < capacity", "held = abs(t) <= capacity"),
        ("if not unit.static_friction > stand_ratio", "if not unit.static_friction >= stand_ratio"),
    ],
    ("core/flight.py", "core/test_flight.py"): [
        ("crest - 3.0 * QUARTER - at.lift_off", "crest - 3.0 * QUARTER + at.lift_off"),
    ],
    ("core/windows.py", "core/test_windows.py"): [
        (" or (t != 0.0 and abs(over) <= held_noise)", ""),
        ("opens = near - far", "opens = near + far"),
    ],
    ("core/arrival.py", "core/test_arrival.py"): [
        ("series = gain / left", "series = 1.0 / left"),
        ("advance <= 0.0 and (settled", "advance < 0.0 and (settled"),
    ],
    ("core/boxes.py", "core/test_boxes.py"): [("load, path > 0.0)", "load, path < 0.0)")],
    ("core/captures.py", "core/test_captures.py"): [("orbit.status > Status", "orbit.status >= Status")],
    ("core/return_map.py", "core/test_return_map.py"): [
        ("abs(v + hops.high[row]), abs(v + hops.low[row])", "abs(v + hops.high[row]), abs(v)"),
    ],
    ("core/steps.py", "core/test_steps.py"): [
        ("rests = abs(loads.weight_tangential) <", "rests = abs(loads.weight_tangential) <="),
    ],
    ("core/wave_slides.py", "core/test_wave_slides.py"): [
        ("(math.floor(fall.value / drop) + 1.0)", "math.floor(fall.value / drop)"),
    ],
    ("core/history.py", "core/test_history.py"): [
        ("legs.cycle[first] + nearest_turn(", "legs.cycle[first] - nearest_turn("),
    ],
    ("core/attractors.py", "motion/test_attractors.py"): [
        ("lost += 0 if entry.motion.repeats else 1", "lost += 1"),
    ],
    ("core/filling.py", "test_fillings.py"): [
        ("b * math.cos(phase), b * math.sin(phase), n)", "b * math.sin(phase), b * math.cos(phase), n)"),
    ],
    ("results/filling.py", "test_fillings.py"): [("- 1j * self.added", "+ 1j * self.added")],
    ("slopes.py", "test_slopes_of_motions.py"): [
        ("(2.0 * _STEP) - coarse) / 3.0", "(2.0 * _STEP) + coarse) / 3.0"),
    ],
    ("roots.py", "test_roots.py"): [
        ("np.asarray(residual(between)) >= 0.0", "np.asarray(residual(between)) > 0.0"),
    ],
    ("axes.py", "test_axes.py"): [("count=steps + 1", "count=steps")],
    ("units.py", "test_axes.py"): [('"um": Fraction(1, 1000)', '"um": Fraction(1, 100)')],
    ("reals.py", "test_reals.py"): [("bool | np.timedelta64", "np.timedelta64")],
    ("results/steady.py", "test_steady.py"): [
        ("np.where(self.mean_velocity > 0.0, self.mean_velocity, 0.0)", "self.mean_velocity"),
    ],
    ("results/sweep.py", "results/test_sweep.py"): [("> _SIGMAS * error", "> error")],
    ("motion/trace.py", "motion/test_trace.py"): [('side="right") - 1', 'side="left") - 1')],
    ("motion/histories.py", "motion/test_histories_starts.py"): [
        ("start.height / length_unit", "start.height / speed_unit"),
    ],
    ("motion/settled.py", "records/test_settled_motion.py"): [
        ("sample.position + turns * self.advance", "sample.position"),
    ],
    ("machines/linear.py", "machines/test_machine.py"): [("- ww * free  # dZ/dM", "+ ww * free")],
    ("machines/fitting.py", "machines/test_fitting.py"): [("(quantile * factor) ** 2", "quantile * factor")],
    ("machines/operating.py", "machines/test_operating.py"): [
        ("<= 2.0 * self.machine.damping_ratio", "<= self.machine.damping_ratio"),
    ],
    ("sweeps/tally.py", "sweeps/test_tally.py"): [("[-value for value in", "[value for value in")],
    ("sweeps/grid.py", "sweeps/test_grid.py"): [("-(-stop // length)", "stop // length")],
    ("sweeps/derived.py", "sweeps/test_derived.py"): [
        ("np.maximum(block.cycle.mean_velocity, 0.0)", "block.cycle.mean_velocity"),
    ],
    ("units.py", "sweeps/test_derived.py"): [("{}, per_si=3600.0)", "{}, per_si=60.0)")],
    ("output/workers.py", "output/test_workers.py"): [("logging.getLogger(name).setLevel(level)", "pass")],
    ("output/staging.py", "output/test_staging.py"): [
        ("(*self._json, *old)", "(*old, *self._json)"),
        ("*pictures.values(), *self._json]", "*self._json, *pictures.values()]"),
    ],
    ("output/selection.py", "output/test_selection.py"): [("or kept[place] != index", "")],
    ("output/gathered.py", "output/test_stored.py"): [("place += len(chunk)", "place = len(chunk)")],
    ("output/plan.py", "output/test_plan.py"): [
        ("min((shard + 1) * self.shard_cells, self.grid.size)", "(shard + 1) * self.shard_cells"),
    ],
    ("output/shard_folder.py", "output/test_shard_folder.py"): [
        ("(path.name != SUCCESS,", "(path.name == SUCCESS,")
    ],
    ("inverse/search.py", "inverse/test_search.py"): [
        ("np.clip(first - 1, 0, last)", "np.clip(first, 0, last)"),
    ],
    ("inverse/yields.py", "inverse/test_yields.py"): [
        ("(k_high - k_low) * (s_high - knee)", "(k_high - k_low) * (s_high - s_low)"),
    ],
    ("inverse/costs.py", "inverse/test_costs.py"): [('"frequency": 1.0 + 2.0', '"frequency": 2.0 + 2.0')],
    ("inverse/rounding.py", "inverse/test_rounding.py"): [
        ("(count + steps) * unit", "(count - steps) * unit"),
    ],
    ("inverse/certain.py", "inverse/test_certain.py"): [
        ("Regime.FORWARD_SLIP) & braked", "Regime.FORWARD_SLIP)"),
    ],
    ("inverse/friction_windows.py", "inverse/test_friction_windows.py"): [
        ("values[first - 1], values[first]", "values[first - 2], values[first]"),
    ],
    ("inverse/bands.py", "inverse/test_bands.py"): [
        ("box.frequency[loads[0] > 0.0]", "box.frequency[loads[0] <= 0.0]"),
    ],
    ("inverse/extremes.py", "inverse/test_extremes.py"): [("+ side * _ERRORS * error", "+ _ERRORS * error")],
    ("explore/levels.py", "explore/test_levels.py"): [("math.expm1(0.5 * np.diff", "math.expm1(np.diff")],
    ("explore/bands.py", "explore/test_maps.py"): [("max(static[0], second[0])", "static[0]")],
    ("explore/packed_histories.py", "explore/test_answers.py"): [
        ("max(low, -most), min(high, most)", "max(low, -most), high"),
    ],
    ("explore/packing.py", "explore/test_answers.py"): [
        ("-(len(text) + 4) % _ALIGNED", "-len(text) % _ALIGNED"),
    ],
    ("explore/guards.py", "explore/test_guards.py"): [("len(hosts) != 1 or hosts[0]", "hosts[0]")],
    ("explore/static/map.js", "explore/test_page.py::test_the_point_is_dragged_without_asking_for_the_map"): [
        ("1 - (clientY - area.top)", "(clientY - area.top)"),
    ],
    ("explore/static/map.js", "explore/test_page.py::test_arrow_keys_move_the_point_and_the_speed_is_said"): [
        ("ArrowUp: [NaN, 1]", "ArrowUp: [NaN, -1]"),
    ],
    ("explore/static/history.js", "explore/test_page.py::test_zero_is_drawn_where_its_axis_has_it"): [
        ("(value - low) / (high - low)", "value / (high - low)"),
    ],
    ("plots/scales.py", "plots/test_numbers.py"): [
        ("foot = min(foot, high / _OVER_REGULAR)", "foot = max(foot, high / _OVER_REGULAR)"),
        ("foot = max(float(", "foot = min(float("),
    ],
    ("plots/fields.py", "plots/test_fields.py"): [("-_CERTAIN * cycle", "-cycle")],
    ("plots/neighbours.py", "plots/test_neighbours.py"): [
        ("(size - 1) // 2 if reflected else size // 2", "size // 2 if reflected else (size - 1) // 2"),
    ],
    ("plots/history.py", "plots/test_history.py"): [("friction = max(float(", "friction = min(float(")],
    ("reports/change_texts.py", "reports/test_change_texts.py"): [
        ("key=lambda change: abs(change.percent))", "key=lambda change: change.percent)"),
    ],
    ("reports/scene_texts.py", "reports/test_scene_texts.py"): [
        ("bound(window.low, upper=True)", "bound(window.low, upper=False)"),
    ],
    ("records/folding.py", "records/test_folding.py"): [("self.half**-power", "self.half**power")],
    ("records/cycles.py", "records/test_cycles.py"): [
        ("0.5 * resistance * since**2", "resistance * since**2"),
    ],
    ("records/frequencies.py", "records/test_frequencies.py"): [
        ("max(TOL.drifted / signals.span", "min(TOL.drifted / signals.span"),
    ],
    ("records/signals.py", "records/test_signals.py"): [
        ("number * size if inverse else size / number", "size / number if inverse else number * size"),
    ],
    ("files/points.py", "files/test_points.py"): [("others[0] / 2.0 if stroke", "others[0] if stroke")],
    ("files/rounding.py", "files/test_rounding.py"): [
        ("quick &= 0.5 - np.abs(scaled - whole) > np.spacing(most)", "pass"),
    ],
    ("files/motions.py", "files/test_motions.py"): [("others.pop(name, 0.0)", "others.get(name, 0.0)")],
    ("cli/target_speed.py", "cli/test_map_speed.py"): [("cells[-1] + 1)", "cells[-1])")],
    ("cli/amplitudes.py", "cli/test_amplitudes.py"): [
        ("ExitCode.DONE if found else ExitCode.NOT_MET", "ExitCode.DONE"),
    ],
    ("cli/traverse_time.py", "cli/test_traverse_time.py"): [("'later' if apart > 0", "'later' if apart < 0")],
    ("accuracy/trade.py", "accuracy/test_trade.py"): [("best = min(right", "best = max(right")],
}
MUTANTS: Final = [
    Mutant(file, *fault, tests) for (file, tests), faults in _FAULTS.items() for fault in faults
]


class Outcome(NamedTuple):
    """How tests ended: pytest's exit code, those that failed, what was said last, and how long it took."""

    code: int
    failed: list[str]
    said: str
    seconds: float


class Copy:
    """A copy of the files of this checkout, in which faults can be put."""

    def __init__(self, place: Path) -> None:
        self._place = place
        self._is_compiled = False
        listed = ["git", "ls-files", "-z", "--cached", "--others", "--exclude-standard"]
        names = subprocess.run(listed, cwd=ROOT, check=True, capture_output=True, text=True).stdout
        for name in filter(None, names.split("\0")):
            if (ROOT / name).is_file():  # and not removed
                (place / name).parent.mkdir(parents=True, exist_ok=True)
                (place / name).write_bytes((ROOT / name).read_bytes())

    def run(self, *tests: str, options: tuple[str, ...] = ()) -> Outcome:
        """Run tests, by files or names below ``tests``."""
        if not self._is_compiled:
            compiling = [sys.executable, str(self._place / "tools/compiling.py")]
            subprocess.run(compiling, check=True, stdout=subprocess.DEVNULL)
            self._is_compiled = True
        command = [sys.executable, "-m", "pytest", "-n", "0", "-q", "-rfE", "--tb=no", *options]
        command += [f"tests/{test}" for test in tests]
        env = {**os.environ, "PYTHONPATH": str(self._place / "src"), "VIBRO_BROWSER": "required"}
        start = time.perf_counter()
        with subprocess.Popen(
            command, cwd=self._place, env=env, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
            start_new_session=True,
        ) as child:  # fmt: skip
            try:
                out, code = child.communicate(timeout=LIMIT)[0], child.returncode
            except subprocess.TimeoutExpired:
                os.killpg(child.pid, signal.SIGKILL)  # with all that its tests have started
                out, code = f"no end within {LIMIT:g} s", 1
        failed = re.findall(r"^(?:FAILED|ERROR) tests/(.*?)(?: - .*)?$", out, flags=re.MULTILINE)
        return Outcome(code, failed, out.strip().rpartition("\n")[2], time.perf_counter() - start)

    def run_mutant(self, mutant: Mutant) -> Outcome:
        """Run the tests of a mutant with its fault, until the first of them fails."""
        file = self._place / "src/vibro" / mutant.file
        text = file.read_text("utf-8")
        changes_solver = mutant.file.startswith("core/")
        self._is_compiled &= not changes_solver
        file.write_text(mutant.put_into(text), "utf-8")
        try:
            return self.run(mutant.tests, options=("-x",))
        finally:
            file.write_text(text, "utf-8")
            self._is_compiled &= not changes_solver


def told(mutant: Mutant, outcome: Outcome) -> str:
    text = str(mutant)
    text = text if len(text) <= SHOWN else f"{text[: SHOWN - 3]}..."
    end = {0: "SURVIVES", 1: "killed by"}.get(outcome.code, "BROKEN:")
    which = (outcome.failed or [outcome.said])[0] if outcome.code else ""
    return f"{text:{SHOWN}}  {outcome.seconds:5.1f} s  {end} {which}".rstrip()


def main() -> int:
    parser = argparse.ArgumentParser(description="Do the tests of a room notice faults in its code?")
    parser.add_argument("--only", nargs="+", default=[""], metavar="TEXT", help="parts of files or texts")
    chosen = parser.parse_args().only
    mutants = [mutant for mutant in MUTANTS if any(text in str(mutant) for text in chosen)]
    codes, killers = [], list[str]()
    with tempfile.TemporaryDirectory() as place:
        copy = Copy(Path(place))
        for mutant in mutants:
            outcome = copy.run_mutant(mutant)
            codes.append(outcome.code)
            killers += outcome.failed
            print(told(mutant, outcome), flush=True)
        sound = copy.run(*dict.fromkeys(killers)) if killers else Outcome(0, [], "", 0.0)
    killed = codes.count(1)
    print(f"{killed} of {len(mutants)} killed, {codes.count(0)} survive")
    if sound.code:
        print("without a fault too there fails:", *sound.failed or [sound.said], sep="\n  ")
    return int(killed < min(ENOUGH, len(mutants)) or sound.code != 0)


if __name__ == "__main__":
    sys.exit(main())
