"""``vibro design``: which settings of which drive guarantee a speed for all parts."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Final

from vibro.cli.exit_codes import ExitCode
from vibro.cli.options import AllOption, Options, option, rare
from vibro.errors import InputError

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from vibro.files.csv_tables import TableColumns
    from vibro.results.designs import DesignResult

#: Pictures of the page, and what they show.
_SHOWN: Final = {
    "speed": "Speed of the slowest part over amplitude and frequency; the circle is the design",
    "band": "Speeds from the slowest to the fastest part over the amplitude",
}
#: A question that may be asked as it is: what people change first.
_EXAMPLE: Final = """\
# vibro design this.toml

[scene]                           # the parts and the trough: numbers, or bands of which every value counts
static_friction = "0.3:0.5"
friction_ratio = "0.7:0.9"        # kinetic over static friction
trough_angle_deg = 0
trough_length_mm = 1200

[[drive]]                         # what may be chosen; several drives are compared
name = "magnet"
amplitude_mm = "at most 0.8"      # half of the stroke
frequency_hz = "exactly 50"       # or a list "50, 100"
drive_angle_deg = "10:40"         # all between the ends

[[drive]]
name = "unbalance motor"
amplitude_mm = "at most 3"
frequency_hz = "15:25"
drive_angle_deg = "10:40"
acceleration_g = "at most 4"

[drift]                           # of the drive from what is set
amplitude_percent = 3

[goal]
speed_mm_s = "at least 30"        # of every part
highest_regime = "back-slip"      # what may happen: "forward-slip", "back-slip" or "hopping"
"""


def design_command(
    options: Options,
    every: AllOption = False,
    example: Annotated[bool, option("example", "Print an example of a design file, and exit.")] = False,
    other_regimes: Annotated[
        bool, option("other-regimes", "Search within other highest regimes too, for comparison.")
    ] = False,
    digits: Annotated[
        str | None,
        rare(
            "digits",
            "Significant digits of settings [default: 4]; those that do not hold so have more.",
            "1...15",
        ),
    ] = None,
) -> int:
    """Find drive settings that convey every part at least at a required speed, for all its frictions.

    The design file gives parts and trough as bands lo:hi, the drives, their drifts, and the goal. What may be
    chosen of a drive is "at most 3", "exactly 50", "10:30" (all between) or "50, 100" (one of these).
    For every drive three designs are printed: the gentlest (least acceleration) that meets the goal, the
    fastest, and the safest. If no drive meets the goal, the closest ones are, and the exit code is 4.
    """
    from vibro.answers.design import design_answer
    from vibro.answers.drawing import design_pictures
    from vibro.cli.outputs import Outputs
    from vibro.cli.request import whole_number
    from vibro.designs.design import chosen_of, find_designs
    from vibro.designs.questions import MOST_DIGITS
    from vibro.designs.reading import read_spec
    from vibro.designs.rows import DIGITS
    from vibro.files.toml_files import read_toml
    from vibro.plots import DESIGN_PICTURES

    if example:
        print(_EXAMPLE, end="")
        return ExitCode.DONE
    console = options.console
    count = DIGITS if digits is None else whole_number("--digits", digits, range(1, MOST_DIGITS + 1))
    source = options.scene
    if source is None:
        raise InputError("missing: a design file", hint="vibro design --example prints one")
    spec = read_spec(source)
    for doubt in spec.doubts():
        console.warn(doubt)
    with Outputs(options, f"{spec.name}-design", pictures=DESIGN_PICTURES) as output:
        with console.progress("searching", None) as report:
            result = find_designs(
                spec,
                lambda done, total, what: report(done, what, total),
                digits=count,
                goal_only=not other_regimes,
            )
            chosen = chosen_of(spec, result)
        question = read_toml(source)
        answer = design_answer(spec, result, chosen, question)

        def draw() -> dict[str, Figure]:
            with console.progress("drawing", None):
                return {} if chosen is None else design_pictures(spec, chosen)

        units = {column.name: column.unit for column in result.columns}
        more = {"spec": question, "columns": units}
        output.write_answer(answer, lambda: {"": _columns(result)}, draw, _SHOWN, more=more)
    output.print_answer(answer, every=every)
    return ExitCode.DONE if result.met else ExitCode.NOT_MET


def _columns(result: DesignResult) -> TableColumns:
    """Return the table."""
    from vibro.files.csv_tables import column_of

    return {c.name: column_of([getattr(design, c.name) for design in result.designs]) for c in result.columns}
