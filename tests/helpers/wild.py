"""Wild input for the tests of axes, scene files, options and records, and how a command must end with it."""

from __future__ import annotations

from typing import TYPE_CHECKING

from hypothesis import HealthCheck, settings
from hypothesis import strategies as st

from vibro.quantities import QUANTITIES

if TYPE_CHECKING:
    from helpers.commands import Run

# Of the profile's number of examples.
SHARES = {"axes": 2.0, "texts": 1.5, "tables": 1.5, "commands": 0.25, "wild": 0.5, "records": 0.4}

QUANTITY = st.sampled_from(list(QUANTITIES.values()))
NUMBER = st.sampled_from(
    [
        "",
        *[
            "1",
            "15",
            "0.1",
            "-3",
            "1e3",
            "1e400",
            "1e-400",
            ".5",
            "5.",
            "0x1f",
            "1_000",
            "nan",
            "inf",
            "-inf",
            "1/2",
            "½",
            "٣",
        ],
    ]
)
UNIT = st.sampled_from(
    ["", *["mm", "um", "µm", "Hz", "rpm", "deg", "°", "rad", "m/s^2", "in", "Mm", "parsec", "%", "$"]]
)
PIECE = st.one_of(
    st.builds(str.__add__, NUMBER, UNIT),
    st.sampled_from(
        ["log", "step=", "step=0.1", "step=1mm", "step=-1", "step=x", "0", "1.5", "1e9", "10000001"]
    ),
    st.text(max_size=4),
)
AXIS = st.one_of(
    st.lists(PIECE, min_size=1, max_size=5).map(":".join),
    st.lists(PIECE, min_size=1, max_size=5).map(",".join),
    st.text(alphabet="0123456789.,:-+eE stpelogµ°mHz\t\n\0", max_size=20),
    st.text(max_size=20),
)

KEYS = [q.column for q in QUANTITIES.values()]
KEY = st.one_of(
    st.sampled_from(KEYS),
    st.sampled_from(["amplitude", "frequency_Hz", "static_fiction", "scene", "mu_s"]),
    st.text(alphabet="abcdefgh_-", min_size=1, max_size=12),
)
TOML_VALUE = st.one_of(
    st.sampled_from(
        [
            "1",
            "1.5",
            "-1",
            "0",
            "nan",
            "inf",
            "true",
            '""',
            '"1"',
            '"0.1:3"',
            '"3:0.1"',
            '"0,74"',
            "[]",
            "[1]",
            "[3,2]",
        ]
    ),
    st.sampled_from(
        ['["a"]', "[[1]]", "{}", "{a = 1}", "1979-05-27", "07:32:00", "1e999", "0x10", "9" * 400, "0,74"]
    ),
    AXIS.map(lambda text: '"' + text.replace("\\", "").replace('"', "") + '"'),
)
TABLE = st.sampled_from(
    ["", *["[scene]", "[map]", "[Scene]", "[sweep]", "[[scene]]", "[scene.map]", "[scene", "[]"]]
)
SECTION = st.tuples(TABLE, st.lists(st.tuples(KEY, TOML_VALUE), max_size=5)).map(
    lambda section: "\n".join([section[0], *(f"{key} = {value}" for key, value in section[1])])
)


def exactly(name: str) -> settings:
    return settings(
        max_examples=round(SHARES[name] * settings().max_examples),
        suppress_health_check=[HealthCheck.function_scoped_fixture, HealthCheck.too_slow],
    )


DIGITS = st.sampled_from(
    [
        *(f"{sign}{'9' * 5000}" for sign in ("", "-", "1e")),
        *(f"0.{'3' * count}" for count in (400, 5000)),
        *(f"{base}{'1' * 5000}" for base in ("0x", "0b")),
        "9" * 400, "1" + "0" * 308, "1_" * 3000 + "1", "0" * 3000 + "1", "." + "0" * 500 + "1",
    ]
)  # fmt: skip
EXTREME = st.one_of(
    st.floats(width=64).map(repr),
    st.sampled_from(
        ["5e-324", "1e-308", "1e-200", "1e-20", "1e20", "1e200", "1.7976931348623157e308", "-0.0"]
    ),
)
# Half of what is drawn is what a person might type, so that commands come to their computations.
PLAUSIBLE = st.one_of(
    st.floats(0.01, 60.0).map(lambda x: f"{x:.4g}"), st.integers(-320, 308).map("1e{}".format)
)
WILD = st.one_of(DIGITS, EXTREME, EXTREME, NUMBER, st.text(max_size=6))


def end(run: Run, *args: str) -> int:
    """Run a command whose input may be wrong, check how it ends, and return its exit code."""
    result = run(*args)
    lines = result.stderr.split("\n")
    assert result.exit_code in (0, 1, 2, 3), (args, result.output)
    assert all(line.isprintable() for line in lines), (args, lines)
    assert "Traceback" not in result.output, args
    assert "Warning" not in result.stderr, (args, lines)
    if result.exit_code in (1, 2):
        assert result.stdout == "", args
        # Above the errors there may be the echo of what was understood.
        said = [line for line in lines if line.startswith(("error: ", "hint: "))]
        assert said[0].startswith("error: "), (args, lines)
        assert [*lines[-len(said) - 1 : -1], ""] == [*said, ""], (args, lines)
        assert "unexpected" not in said[0], (args, said)
    return int(result.exit_code)
