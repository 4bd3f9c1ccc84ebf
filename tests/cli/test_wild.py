"""Options, scene files and records of every kind: whatever a command is given, it ends as it promises.

On fifty of them, or on four thousand with --hypothesis-profile=thorough.
"""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from helpers.wild import AXIS, DIGITS, EXTREME, KEY, PLAUSIBLE, TABLE, TOML_VALUE, WILD, end, exactly
from hypothesis import given
from hypothesis import strategies as st

if TYPE_CHECKING:
    from helpers.commands import Run

OPTIONS = ["-A", "-f", "-a", "--mu-s", "--mu-d", "--mu-ratio", "--trough-angle", "--restitution", "-L"]
SCENE = {"-A": "1", "-f": "15", "-a": "20", "--mu-s": "0.74", "--mu-d": "0.57"}
VALUE = st.one_of(PLAUSIBLE, PLAUSIBLE, PLAUSIBLE, WILD)
SOME_OPTIONS = st.dictionaries(st.sampled_from(OPTIONS), st.one_of(VALUE, VALUE, AXIS), max_size=2)
FEW_VALUES = st.one_of(
    st.sampled_from(
        ["0.5,1,2", "0.1:3:3", "1:100:3:log", "0.1:0.5:step=0.1", "0.01,0.02", "1e-300:1e300:4:log"]
    ),
    st.lists(PLAUSIBLE.map(float), min_size=2, max_size=3).map(
        lambda values: ",".join(map(repr, sorted(values)))
    ),
    st.lists(WILD, min_size=2, max_size=3).map(",".join),
    st.tuples(WILD, WILD).map(lambda ends: f"{ends[0]}:{ends[1]}:3"),
)
OWN = {
    "solve": (["--regimes-only", "--json", "-q", "-o-"], ["--stand-ratio"]),
    "traverse-time": (["--exact", "--sweep", "--json", "-q", "-o-"], []),
    "simulate": (["-q"], ["--cycles", "--duration", "--samples-per-cycle"]),
    "map": (["-q", "--decimal-comma"], ["--at", "--x", "--y", "--show"]),
}


def arguments(given: dict[str, str]) -> list[str]:
    both = "--mu-ratio" in given
    return [
        f"{option}={value}" if option.startswith("--") else option + value
        for option, value in given.items()
        if not (both and option == "--mu-d")
    ]


@exactly("wild")
@given(st.sampled_from(["solve", "traverse-time", "simulate"]), SOME_OPTIONS, st.data())
def test_commands_end_well_whatever_their_options_are(
    run: Run, command: str, options: dict[str, str], data: st.DataObject
) -> None:
    flags, own = OWN[command]
    chosen = data.draw(st.lists(st.sampled_from(flags), unique=True, max_size=2))
    values = data.draw(st.dictionaries(st.sampled_from(own), VALUE, max_size=2)) if own else {}
    if command == "simulate":
        chosen.append("-o-")
    if command == "traverse-time":
        options = {"-L": "600", **options}
    end(run, command, *arguments({**SCENE, **options, **values}), *chosen)


@exactly("wild")
@given(st.dictionaries(st.sampled_from(OPTIONS), FEW_VALUES, min_size=1, max_size=2), SOME_OPTIONS, st.data())
def test_maps_end_well_whatever_their_axes_are(
    run: Run, axes: dict[str, str], options: dict[str, str], data: st.DataObject
) -> None:
    flags, own = OWN["map"]
    chosen = data.draw(st.lists(st.sampled_from(flags), unique=True, max_size=2))
    values = data.draw(
        st.dictionaries(st.sampled_from(own), st.one_of(WILD, st.builds("A={}".format, WILD)), max_size=1)
    )
    few = {
        option: text for option, text in options.items() if ":" not in text
    }  # a range without a count is long
    given_ = arguments({**SCENE, **few, **axes, **values})
    end(run, "map", *given_, *chosen, "--regimes-only", "-o-")


LINE = st.one_of(
    st.tuples(KEY, st.one_of(TOML_VALUE, DIGITS, EXTREME, DIGITS.map("[1, {}]".format))).map(" = ".join),
    TABLE,
    st.sampled_from(
        ["a.b.c = 1", "amplitude_mm.x = 1", '"\\u001b[2J" = 1', "'\x1b[31m' = 1", "x = {", "x = [" * 500]
    ),
    st.text(max_size=10),
    st.sampled_from(["\n".join(f"k{i} = 1" for i in range(300)), "\0", "\ufeff", "\u202e", "#\x07"]),
)


@exactly("wild")
@given(st.sampled_from(["solve", "map", "traverse-time"]), st.lists(LINE, max_size=4), st.booleans())
def test_commands_end_well_whatever_their_scene_file_holds(
    run: Run, command: str, lines: list[str], complete: bool
) -> None:
    own = {"map": ["--regimes-only", "-A1,2", "-f15", "-o-"], "traverse-time": ["--sweep", "-L600", "-o-"]}
    path = Path("scene.toml")
    text = "\n".join(["[scene]", *lines])
    path.write_text(text, encoding="utf-8", errors="surrogatepass")
    end(
        run,
        command,
        str(path),
        *own.get(command, []),
        *(arguments(SCENE) if complete and command == "solve" else []),
    )


CELL = st.one_of(
    EXTREME, DIGITS, st.sampled_from(["", "NaN", "-", '"', "'1", "1,5", "1.5.5", "#N/A", "\x1b[2J", "0"])
)
UNITS = ["t [s]", "x [mm]", "x [m]", "v [mm/s]", "a [m/s^2]", "F [N]", "t [ms]"]
HEADER = st.sampled_from([*UNITS, "time_s", "", "x", "1", "[s]", "\x07 [mm]"])
SIGNAL = st.sampled_from(["sine", "zeros", "ones", "ramp", "spike", "noise", "saw"])


def signal(kind: str, size: int) -> list[float]:
    turns = np.arange(size) / 16.0
    shapes = {
        "sine": np.sin(2.0 * np.pi * turns),
        "zeros": np.zeros(size),
        "ones": np.ones(size),
        "ramp": turns,
        "spike": (turns == 1.0).astype(float),
        "noise": np.random.default_rng(1).standard_normal(size),
        "saw": turns + turns % 1.0,
    }
    return list(shapes[kind].tolist())


@st.composite
def records(draw: st.DrawFn) -> bytes:
    """Tables of up to three signals at 240 Hz, of any size, some of whose lines are replaced."""
    size = draw(st.sampled_from([*5 * [33, 49, 97], 0, 1, 2, 20]))
    powers = st.one_of(st.just(0), st.integers(-25, 23), st.integers(-323, 308))
    scales = [10.0**power for power in draw(st.lists(powers, min_size=1, max_size=3))]
    step = draw(st.sampled_from([1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1e-3, 5e-324, 1e300])) / 240.0
    kinds = draw(st.lists(SIGNAL, min_size=len(scales), max_size=len(scales)))
    names = draw(st.permutations(["x [mm]", "v [mm/s]", "a [m/s^2]", "F [N]"]))[: len(scales)]
    separator = draw(st.sampled_from([",", ",", ";", "\t"]))
    columns = [[step * i for i in range(size)]]
    columns += [[x * scale for x in signal(kind, size)] for kind, scale in zip(kinds, scales, strict=True)]
    rows = [["t [s]", *names], *(list(map(repr, row)) for row in zip(*columns, strict=True))]
    for _ in range(draw(st.sampled_from([0, 0, 0, 1, 2]))):
        place = draw(st.integers(0, min(len(rows) - 1, 4)))
        if draw(st.booleans()):
            rows[place] = draw(st.lists(st.one_of(CELL, HEADER), max_size=4))
        else:
            rows[place] = [draw(CELL), *rows[place][1:]]
    text = "\n".join(separator.join(row) for row in rows)
    return draw(st.sampled_from([*15 * [b""], b"\xef\xbb\xbf", b"\xff\xfe", b"\0"])) + text.encode()


BYTES = st.one_of(st.binary(max_size=60), st.text(max_size=60).map(str.encode))
RECORD = st.integers(0, 9).flatmap(lambda place: records() if place else BYTES)


@exactly("records")
@given(RECORD, st.dictionaries(st.sampled_from(OPTIONS), PLAUSIBLE, max_size=1), st.data())
def test_comparisons_end_well_whatever_a_record_holds(
    run: Run, content: bytes, options: dict[str, str], data: st.DataObject
) -> None:
    Path("record.csv").write_bytes(content)
    wild = {"--mass": WILD, "--time": HEADER, "--displacement": HEADER, "--friction": HEADER}
    extra = {
        name: data.draw(wild[name]) for name in data.draw(st.lists(st.sampled_from(list(wild)), max_size=1))
    }
    if data.draw(st.integers(0, 3)) == 0:
        extra["--fit"] = data.draw(st.sampled_from(["mu_d", "mu_s,mu_d", "A", "mu_s,alpha", "9" * 5000, "x"]))
    flags = data.draw(st.sampled_from([[], ["-o-"], ["--json"], ["--reverse", "-q"]]))
    end(run, "measure", "record.csv", *arguments({"--mass": "20g", **SCENE, **options, **extra}), *flags)
