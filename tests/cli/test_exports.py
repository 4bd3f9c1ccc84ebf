"""Records as telephones, loggers, simulations and spreadsheets write them, whole and damaged."""

from __future__ import annotations

import json
import math
import os
import time
from pathlib import Path
from typing import Final

from helpers.cases import each
from helpers.commands import Run
from helpers.damaged import damaged
from helpers.exports import AMPLITUDE_MM, ANGLE_DEG, FREQUENCY, Export, binary_exports, text_exports
from helpers.wild import end

#: Damaged files that are measured; the environment may ask for more, and for others.
DAMAGED: Final = int(os.environ.get("VIBRO_DAMAGED", "60"))
SEED: Final = int(os.environ.get("VIBRO_DAMAGED_SEED", "1"))
LONGEST: Final = 5.0  # [s] of processor time for one of them
#: Times the tolerance of a whole file: a row more or less in a file without times changes the frequency;
#: or two standard errors, as what is left may be short.
OF_DAMAGED: Final = 5.0, 2.0


def misses(stdout: str, times: float = 1.0, errors: float = 0.0) -> list[str]:
    """Say what of the motion in an answer is off by more than times its tolerance, and so many errors."""
    trough = json.loads(stdout)["trough"]

    def measured(name: str) -> tuple[float, float]:
        return trough[name]["measured"], trough[name]["standard_error"]

    if "amplitude_mm" in trough:
        found = {"amplitude": measured("amplitude_mm")}
    else:
        (along, error), (normal, other) = measured("along_amplitude_mm"), measured("normal_amplitude_mm")
        found = {"amplitude": (math.hypot(along, normal), math.hypot(error, other))}
    found["frequency"] = measured("frequency_hz")
    if "drive_angle_deg" in trough:
        found["angle"] = measured("drive_angle_deg")
    wanted = {"amplitude": (AMPLITUDE_MM, 0.005), "frequency": (FREQUENCY, 0.01), "angle": (ANGLE_DEG, 0.3)}
    return [
        f"{name} {value} +- {error}"
        for name, (value, error) in found.items()
        if not abs(value - wanted[name][0]) <= max(times * wanted[name][1], errors * error)
    ]


def failure(run: Run, export: Export) -> str:
    """Measure an export; return why its motion is not found, or why it is not refused as it must be."""
    Path(export.file).write_bytes(export.content)
    result = run("measure", export.file, *export.typed, "--json")
    if export.hint:
        hints = [line for line in result.stderr.splitlines() if line.startswith("hint: ")]
        said = result.exit_code == 2 and any(export.hint in hint for hint in hints)
        return "" if said else f"exit {result.exit_code}, {hints}"
    if result.exit_code:
        return f"exit {result.exit_code}, {result.stderr}"
    return ", ".join(misses(result.stdout))


def test_every_export_of_a_motion_gives_the_motion(run: Run) -> None:
    wrong = {export.name: why for export in text_exports() if (why := failure(run, export))}
    assert not wrong


def test_files_of_other_formats_give_the_motion(run: Run) -> None:
    wrong = {export.name: why for export in binary_exports() if (why := failure(run, export))}
    assert not wrong


def test_damaged_files_are_refused_or_measured(run: Run) -> None:
    """``VIBRO_DAMAGED=500 pytest tests/cli/test_exports.py`` takes a minute and a half."""
    exports, wrong = [*text_exports(), *binary_exports()], {}
    for export in damaged(exports, DAMAGED, SEED):
        Path(export.file).write_bytes(export.content)
        arguments, began = ("measure", export.file, *export.typed, "--json"), time.process_time()
        try:
            if end(run, *arguments) == 0:
                result = run(*arguments)
                missed = misses(result.stdout, *OF_DAMAGED)
                assert not missed or "warning: " in result.stderr, missed
        except Exception as exc:
            wrong[export.name] = f"{exc}"
        if time.process_time() - began > LONGEST:
            wrong[export.name] = "takes too long"
    assert not wrong


@each("text", ["9", "1,", "a ", "a[", ")", '"', "1'000", "0."])
def test_lines_of_many_characters_end_well_at_once(run: Run, text: str) -> None:
    """Above the names of the columns and amid the data; what is done with every position takes minutes."""
    export = next(one for one in text_exports() if one.name == "TwinCAT Scope, EOF")
    lines, long = export.content.splitlines(), text.encode() * 150_001
    Path(export.file).write_bytes(b"\n".join([long, *lines[:500], long, *lines[500:]]))
    began = time.process_time()
    end(run, "measure", export.file, *export.typed, "--json")
    assert time.process_time() - began < LONGEST
