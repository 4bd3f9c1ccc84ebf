"""Tables of units, columns and codes in docs/reference, made from what the code says of them.

python docs/ext/nomenclature.py    # writes them into their pages
"""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from vibro.cli.exit_codes import ExitCode
from vibro.core.codes import Status
from vibro.files.descriptions import SCENE_FILE
from vibro.quantities import HARMONIC, MASS, QUANTITIES, SWEPT
from vibro.results.designs import DESIGN_COLUMNS
from vibro.results.operating import BENT_SPEED, MACHINE_RESULTS, WEIGHED
from vibro.results.steady import (
    ACCELERATION,
    ARRIVAL_TIME,
    MASS_RATE,
    PARTS_RATE,
    RESULTS,
    SPEED_EXPONENT,
    STROKES,
    TIPPING_LOAD_RATIO,
    TRAVERSE_TIME,
    UPRIGHT,
    Result,
)
from vibro.scene import Scene
from vibro.units import SPEED, TIME

if TYPE_CHECKING:
    from collections.abc import Iterable

UNITS = """\
Options, axes of scene files and arguments of `vibro.sweep` take numbers with these units. Capital and small
letters are the same; `um` may be written with either micro sign. Inches are `in`, feet `ft`:
`-A 0.04in`; answers are in the units of the second column. Frictions and the restitution are pure numbers.
The amplitude of a line may have the unit of its largest acceleration or speed, from which it follows at the
frequency: `-A 4g` (of 9.80665 m/s², whatever the gravity of the scene), `-A 110mm/s`; with `rms` after the
unit it is the rms value of the sine: `"110mm/s rms"`, `"0.7mm rms"`; `peak` changes nothing. `--stroke 4g` is
from peak to peak, an amplitude of 2 g."""
STATUSES = """\
Every cell has one status. [Chapter 7 of the theory](../theory/07-special-cases.md) says when each occurs."""
EXIT_CODES = """\
The exit code says how a run ended. Code 1 means a file that is missing or exists already, or a full disk."""
OTHERS = "Bold symbols have another meaning on these pages: German practice (VDI 2333) swaps letters."
DESIGNS = """\
A row is a drive, a highest regime and a design. Inputs, and `acceleration_g`, are those of the chosen
(*nominal*) setting, about which the bands and drifts lie."""
FILLING = """\
What `vibro solve filling=` adds to the shares above, where the trough moves as the scene says (theory,
section 18). Three columns `given_motion_..._percent` say up to which filling, as a share of the trough's
mass, this holds within 1 % of the speed."""
TOGETHER = {
    "amplitude_low_mm amplitude_high_mm stroke_low_mm stroke_high_mm motion_scale_low motion_scale_high":
        "ends of the window of amplitudes (of an ellipse, along the trough), strokes or scales, within which "
        "a search finds no part that misses the goal",
    "frequency_needed_hz amplitude_needed_mm stroke_needed_mm motion_scale_needed":
        "nearest drive that meets the goal",
    "restitution_low restitution_high restitution_assumed":
        "band of restitution of its parts, where some hop, and whether it is assumed, as none is given",
    "amplitude_least_mm amplitude_most_mm":
        "smallest and largest amplitude within the bands of voltage and filling",
    "low_set_by high_set_by": "constraints at the ends of the window",
    "added_mass_share_error added_damping_share_error":
        "standard errors of the shares where they are means over many cycles, else 0",
}  # fmt: skip
"""Columns of designs and fillings that share a row, and what they mean together."""
REFERENCE = Path(__file__).parents[1] / "reference"
FIELDS = {"along_amplitude_2": "along_harmonics", "normal_amplitude_2": "normal_harmonics"}
"""Fields of a scene that hold several quantities, by the one beside which they are listed."""
SCENE = {*Scene.__dataclass_fields__, *FIELDS}
HIGHER = [name for name in HARMONIC if name not in SWEPT and name != "along_phase"]
"""Harmonics beyond the second, which have its quantities with another number."""
ELSEWHERE = (
    ARRIVAL_TIME,
    STROKES,
    ACCELERATION,
    SPEED_EXPONENT,
    PARTS_RATE,
    MASS_RATE,
    UPRIGHT,
    TIPPING_LOAD_RATIO,
)
"""Results that are no attributes of ``SteadyCycle``."""
NOMINAL = {ACCELERATION.column, *(q.column for q in QUANTITIES.values())}
"""Columns that designs have like other tables."""
INPUTS = """\
[Scene files](scene-files.md) explain all but these, which are no keys:

- `Scene.motion`: any periodic motion, a `Motion`.
"""
SYNONYMS = {
    "amplitude_mm": "$r$, $X_0$, $e$ (eccentricity); half of *Schwingweite* or *Hub*",
    "stroke_mm": "peak-to-peak, $A_{pp}$, $2r$; *Schwingweite*, *Hub*",
    "frequency_hz": "$n$ [1/min], speed of the motor; *Erregerfrequenz*",
    "drive_angle_deg": "**$\\beta$** (German practice), $\\psi$, $i$; angle of vibration, *Wurfwinkel*",
    "along_amplitude_mm": "$X_0$, $a$; longitudinal, horizontal amplitude",
    "normal_amplitude_mm": "$Z_0$, $b$; vertical amplitude",
    "normal_phase_deg": "$\\varepsilon$, $\\delta$; phase difference; as a phase lag of the opposite sign",
    "static_friction": "$\\mu_0$, $f_0$; *Haftreibung*",
    "kinetic_friction": "$\\mu$, $f$, $\\mu_k$; dynamic, sliding friction; *Gleitreibung*",
    "trough_angle_deg": "**$\\alpha$** (German practice), $\\theta$; slope, inclination; *Rinnenneigung*",
    "throw_number": "**$\\Gamma$** (German practice); throw coefficient, *Wurfkennzahl*, *Wurfkennziffer*",
    "acceleration_g": "**$K$** (German practice); machine number, *Maschinenkennzahl*",
    "restitution": "$k$, $R$; *Stoßzahl*",
    "trough_length_mm": "track length",
    "mean_velocity_mm_s": "$v$, transport rate; *Fördergeschwindigkeit*",
    "displacement_per_cycle_mm": "advance a stroke, conveying step",
    "flight_fraction": "$n$ over a period; *relative Wurfzeit*, *Zeitkennziffer*",
    "traverse_time_s": "transit time, *Durchlaufzeit*",
    "filling_kg": "load, bed; *Füllung*, *Beladung*",
    "natural_hz": "$f_n$, $n_0$; *Eigenfrequenz*",
    "frequency_ratio": "$z$, $\\lambda$; tuning, *Abstimmung*",
    "added_mass_share": "coefficient of combination; *Mitschwingfaktor*",
}
"""What others write for the same, by column."""


def _names(column: str, name: str) -> str:
    return f"`{column}`<br>`{name}`" if name else f"`{column}`"


def _units() -> list[str]:
    """Make a row a kind of unit: what takes it, the unit outside, and all that a number may carry."""
    takers = [(q.kind, q.label) for q in QUANTITIES.values() if q.kind.sizes and q.name not in HARMONIC]
    takers += [(SPEED, "speeds"), (MASS.kind, "mass"), (TIME, "durations")]
    kinds = {kind.unit: kind for kind, _ in takers}
    return [
        f"| {', '.join(label for kind, label in takers if kind.unit == unit)} | `{unit}`"
        f" | {', '.join(f'`{size}`' for size in kind.sizes)} |"
        for unit, kind in kinds.items()
    ]


def _result(result: Result) -> str:
    name = f"SteadyCycle.{result.name}"
    if result in ELSEWHERE:
        name = ""
    elif result in (*MACHINE_RESULTS, BENT_SPEED):
        name = f"OperatingPoints.{result.name}"
    symbol = f"${result.symbol}$, " if result.symbol else ""
    return f"| {_names(result.column, name)} | {symbol}{result.meaning} |"


def _shared(columns: Iterable[tuple[str, str]]) -> list[str]:
    """Make a row a column and its meaning, or a group of them."""
    group = {name: names for names in TOGETHER for name in names.split()}
    rows = []
    for column, meaning in columns:
        names = group.get(column, column).split()
        if names[0] == column:
            shown = "<br>".join(f"`{name}`" for name in names)
            rows.append(f"| {shown} | {TOGETHER.get(' '.join(names), meaning)} |")
    return rows


def _inputs() -> list[str]:
    """Make a row an input; those that no scene file has are explained, the keys of these files are there."""
    inputs = [
        q for q in QUANTITIES.values()
        if q.name not in HIGHER and q.column != ACCELERATION.column  # which the results have
    ]  # fmt: skip
    keys = {key for table in SCENE_FILE.tables.values() for key in table.entries}
    explained = [f"- `{q.column}`: {q.meaning}." for q in inputs if q.column not in keys]
    fields = {q.column: f"Scene.{FIELDS.get(q.name, q.name)}" for q in inputs if q.name in SCENE}
    rows = [f"| {_names(q.column, fields.get(q.column, ''))} | ${q.symbol}$ |" for q in inputs]
    head = ["| column, name in Python | symbol |", "|---|---|"]
    return [INPUTS + "\n".join(explained), "", *head, *rows, "| `Scene.motion` | - |"]


def _columns() -> list[list[str]]:
    results = []
    for result in RESULTS:
        results.append(_result(result))
        if result.name == "peak_velocity":
            results.append(_result(TRAVERSE_TIME))
    results += [_result(result) for result in (*ELSEWHERE, *MACHINE_RESULTS, BENT_SPEED)]
    designs = _shared((c.name, c.meaning) for c in DESIGN_COLUMNS if c.name not in NOMINAL)
    weighed = _shared((r.column, r.meaning) for r in WEIGHED if r not in MACHINE_RESULTS)
    head = ["| column, name in Python | symbol and meaning |", "|---|---|"]
    others = [f"| `{column}` | {words} |" for column, words in SYNONYMS.items()]
    plain = ["| column | meaning |", "|---|---|"]
    return [
        ["## Inputs", "", *_inputs()],
        ["## Results", "", *head, *results],
        ["## Designs", "", DESIGNS, "", *plain, *designs],
        ["## A filling", "", FILLING, "", *plain, *weighed],
        ["## What others call it", "", OTHERS, "", "| column | elsewhere |", "|---|---|", *others],
    ]


def _codes() -> list[list[str]]:
    statuses = [f"| `{s.label}` | {s.message} | {'yes' if s.answered else 'none'} |" for s in Status]
    exits = [f"| {code:d} | {code.meaning} |" for code in ExitCode]
    return [
        ["## Statuses", "", STATUSES, "", "| status | meaning | numbers |", "|---|---|---|", *statuses],
        ["## Exit codes", "", EXIT_CODES, "", "| code | meaning |", "|---|---|", *exits],
    ]


def tables(page: str) -> str:
    """Make the tables of a page, with their titles: all that follows its first words."""
    if page == "units.md":
        head = ["| quantity | without a unit | a number may carry |", "|---|---|---|"]
        parts = [[UNITS, "", *head, *_units()]]
    else:
        parts = _columns() if page == "columns.md" else _codes()
    return "\n\n".join("\n".join(part) for part in parts) + "\n"


def page_with(page: str) -> str:
    """Put the tables into their page."""
    text = (REFERENCE / page).read_text(encoding="utf-8")
    return text[: text.index(tables(page).split("\n", 1)[0])] + tables(page)


PAGES = ("columns.md", "statuses.md", "units.md")


if __name__ == "__main__":
    for page in PAGES:
        (REFERENCE / page).write_text(page_with(page), encoding="utf-8")
