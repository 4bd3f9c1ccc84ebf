"""One motion in any layout, and of any clock, is read to the same numbers."""

from __future__ import annotations

import re
from datetime import UTC, datetime, timedelta
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest
from helpers.cases import each
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from vibro.errors import InputError
from vibro.records.reading import Record, read_record, read_sensitivities

if TYPE_CHECKING:
    from pathlib import Path

RATE = 500
COUNT = 60
START = datetime(2031, 1, 2, 23, 59, 59, 950_000, tzinfo=UTC)
ALONG = np.round(20.0 * np.sin(0.3 * np.arange(COUNT)) + 0.05 * np.arange(COUNT), 4)
NORMAL = np.round(15.0 * np.cos(0.3 * np.arange(COUNT)) + 9.80665, 4)
EPOCH = 1_925_251_199_950


def _stamp(i: int, form: str) -> str:
    """Write the time of a row, 2 ms after the one before, from shortly before midnight."""
    ms, moment = 2 * i, START + timedelta(milliseconds=2 * i)
    whole = {"ms": 1, "us": 1000, "ns": 1_000_000}
    if form in whole:
        return f"{ms * whole[form]}"
    if form == "s":
        return f"{0.001 * ms:.3f}"
    if form.startswith("epoch"):
        unit = form.split()[1]
        return f"{0.001 * (EPOCH + ms):.3f}" if unit == "s" else f"{(EPOCH + ms) * whole[unit]}"
    return moment.strftime(form).replace("MMM", f"{moment.microsecond // 1000:03d}")


#: Forms of the time, and the unit that a header states for them.
CLOCKS = {
    f"{since}{unit}": unit for since in ("", "epoch ") for unit in ("s", "ms", "us", "ns")
} | dict.fromkeys(
    (
        *("%H:%M:%S.MMM", "%H:%M:%S:MMM", "%M:%S.MMM", "%I:%M:%S.MMM %p"),
        *("%Y-%m-%dT%H:%M:%S.MMMZ", "%d.%m.%Y %H:%M:%S.MMM"),
    ),
    "",
)
UNITS = {"m/s^2": 1.0, "g": 9.80665, "mm/s²": 1e-3, "m/sec2": 1.0, "mg": 9.80665e-3}
PREAMBLES: tuple[list[str], ...] = (
    [],
    ["Recorded by Smith"],
    ["Trough 7", "Rate: 500 Hz", ""],
    ["sensors{0}2", "[Header]", "range{0}16{0}V"],
    ["Operator{0}Smith{0}Trough 7", "{0}{0}", "Channels{0}{0}2"],
    ["1000"],
    ["# 2 channels at 500 Hz"],
)
TRAILERS: tuple[list[str], ...] = (
    [], ["EOF"], ["", "STOP TRG"], ["Mean{0}1.5{0}2.5", "Max{0}20{0}25"], ["# end"],
)  # fmt: skip
STYLES = ("brackets", "parentheses", "slash", "row", "row in brackets", "typed", "no header")


@st.composite
def layouts(draw: st.DrawFn) -> tuple[str, dict[str, str]]:
    """Return a file, and the columns that one types."""
    separator = draw(st.sampled_from([",", ", ", ";", "\t", " ", "   "]))
    clock = draw(
        st.sampled_from([c for c in CLOCKS if separator.strip() or separator == "\t" or " " not in c[5:]])
    )
    unit = draw(st.sampled_from(list(UNITS)))
    comma = "," not in separator and draw(st.booleans())
    style = draw(st.sampled_from(STYLES))
    mark = draw(st.sampled_from(["", "#", "# ", "% ", "// "]))
    described = draw(st.sampled_from(["", "above", "below"]))
    names, units = ["Clock", "ax", "az"], [CLOCKS[clock], unit, unit]
    form = {"brackets": "{} [{}]", "parentheses": "{} ({})", "slash": "{}/{}"}.get(style, "{}")
    heads = [[form.format(name, one) if one else name for name, one in zip(names, units, strict=True)]]
    if described:
        heads.insert(described == "below", ["of the logger", "left side", "right side"])
    if style.startswith("row"):
        heads.append([f"[{one}]" if one and "in" in style else one or "-" for one in units])
    if style == "no header":
        heads = []
    own = separator.strip(" ") or draw(st.sampled_from([";", "\t", "    "]))  # names hold spaces
    rows = []
    for i in range(COUNT):
        cells = [_stamp(i, clock), *(f"{x[i] / UNITS[unit]:.7f}" for x in (ALONG, NORMAL))]
        rows.append(separator.join(cells).replace(".", "," if comma and "%d.%m" not in clock else "."))
    if comma and "%d.%m" in clock:
        rows = [row[:10] + row[10:].replace(".", ",") for row in rows]
    if own == "," and draw(st.booleans()):
        heads = [[f'"{name}"' for name in row] for row in heads]
        rows = [",".join(f'"{cell}"' for cell in row.split(",")) for row in rows]
    if draw(st.booleans()):
        rows[COUNT // 2] += "\n"  # a blank line
    above, below = (draw(st.sampled_from(lines)) for lines in (PREAMBLES, TRAILERS))
    text = [*(line.format(own) for line in above), *(mark + own.join(row) for row in heads), *rows]
    text += [line.format(separator) for line in below]
    end = draw(st.sampled_from(["\n", "\r\n", f"{separator}\n" if separator.strip() else "\n"]))
    typed = {"time": "Clock", "trough_along": "ax", "trough_normal": "az"}
    if style in {"typed", "no header"}:
        typed = {
            role: (f"{i + 1}" if not heads else name) + (f" [{one}]" if one else "")
            for i, ((role, name), one) in enumerate(zip(typed.items(), units, strict=True))
        }
    if style not in {"typed", "no header"} and draw(st.booleans()):
        del typed["time"]  # it is found
    return end.join(text) + end, typed


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("layouts")


@settings(max_examples=120, deadline=None)
@given(layouts())
def test_any_layout_gives_the_same_numbers(
    tmp_path_factory: pytest.TempPathFactory, layout: tuple[str, dict[str, str]]
) -> None:
    text, typed = layout
    path = tmp_path_factory.getbasetemp() / "record.csv"
    path.write_text(text, encoding="utf-8")
    record = read_record(path, typed, body=False)
    np.testing.assert_allclose(record.time - record.time[0], np.arange(COUNT) / RATE, atol=1e-6)
    np.testing.assert_allclose(record.trough["trough_along"], ALONG, atol=2e-6)
    np.testing.assert_allclose(record.trough["trough_normal"], NORMAL, atol=2e-6)


# --- clocks -------------------------------------------------------------------------------------------


def recorded(folder: Path, stamps: list[str], unit: str = "ms", values: np.ndarray | None = None) -> Record:
    """Read a record of these times, and of a sine over the rows."""
    values = np.sin(np.arange(len(stamps))) if values is None else values
    rows = [f"{t},{x:.5f}" for t, x in zip(stamps, values, strict=True)]
    (folder / "clock.csv").write_text("\n".join([f"t [{unit}],a [g]", *rows]) + "\n", encoding="utf-8")
    return read_record(folder / "clock.csv", {"trough_along": "a"}, body=False)


@settings(max_examples=30)
@given(st.floats(250.0, 2500.0), st.floats(0.0, 1.0), st.sampled_from([np.floor, np.round, np.ceil]))
def test_a_clock_of_whole_milliseconds_has_the_true_rate(
    folder: Path, rate: float, start: float, whole: Any
) -> None:
    """But at whole milliseconds, where rows may be lost as well, or written twice."""
    assume(
        all(abs(rate * step - 1000.0) > 0.21 * rate * step for step in (1, 2, 3, 4)) or 1000.0 / rate < 0.75
    )
    exact = 1e3 * np.arange(1500) / rate + start
    record = recorded(folder, [f"{t:.0f}" for t in whole(exact)])
    np.testing.assert_allclose(record.time, 1e-3 * exact, atol=1e-3)
    np.testing.assert_allclose(np.diff(record.time), 1.0 / rate, rtol=1e-3)


@settings(max_examples=20)
@given(
    st.integers(8, 40),
    st.sampled_from([(16, "us", 1500), (16, "ms", 3), (32, "us", 2000), (32, "ms", 2)]),
    st.integers(0, 2**32),
)
def test_a_counter_that_overflows_is_counted_on(
    folder: Path, jitter: int, counter: tuple[int, str, int], start: int
) -> None:
    bits, unit, step = counter
    size = {"us": 1e-6, "ms": 1e-3}[unit]
    exact = np.cumsum(step + np.random.default_rng(jitter).integers(-step // jitter, step // jitter + 1, 500))
    record = recorded(folder, [f"{(start + t) % 2**bits}" for t in exact.tolist()], unit)
    np.testing.assert_allclose(np.diff(record.time), np.diff(exact) * size, rtol=1e-5, atol=1e-9)


def test_two_runs_are_no_counter_that_overflows(folder: Path) -> None:
    for length in (10, 32, 33, 500):
        times = [f"{2 * i}" for i in [*range(length), *range(length)]]
        with pytest.raises(InputError, match="goes back"):
            recorded(folder, times)
        with pytest.raises(InputError, match="goes back"):
            recorded(folder, [f"{1000 * int(t)}" for t in times], "us")


def test_rows_that_are_lost_are_no_coarse_clock(folder: Path) -> None:
    """Nor is a row that is written twice with another value."""
    lost = [f"{i}" for i in range(1000) if i % 50 != 49]
    np.testing.assert_allclose(recorded(folder, lost).time, [1e-3 * int(t) for t in lost])
    twice = sorted([*range(1000), 500, 700])
    with pytest.raises(InputError, match="repeats"):
        recorded(folder, [f"{i}" for i in twice])
    values = np.sin(np.array(twice))
    assert recorded(folder, [f"{i}" for i in twice], values=values).time.size == 1000


# --- messages whose hints work --------------------------------------------------------------------------


def typed_in(hint: str) -> dict[str, str]:
    """Return the arguments that a hint names, with values."""
    return dict(re.findall(r'(\w+)="([^"]*)"', hint))


@each(
    ("text", "typed"),
    [
        ("t,a\n{}", {"trough_along": "a [g]"}),
        ("t [s],a\n{}", {"trough_along": "a"}),
        ("t [s],a (furlong)\n{}", {"trough_along": "a"}),
        ("t [s],a (mm)\n{}", {"trough_along": "b"}),
        ("a [g],A [g],t [s]\n{}", {"trough_along": "x"}),
        ("t [s],a [g],a [g]\n{}", {"trough_along": "a"}),
        ("t [s],u [mV],U [V]\n{}", {"trough_along": "u [mV]"}),
        ("Zeit,Weg\n{}", {"trough_along": "Weg [mm]"}),
        ("{}", {"trough_along": "a [g]"}),
        ("{}", {"trough_along": "2 [g]"}),
        ("n,count\n{}", {"trough_along": "n [g]"}),
        ("Time [ms],a [g],Time [ms],b [g]\n{}", {"trough_along": "a", "trough_normal": "b"}),
    ],
)
def test_what_a_hint_says_can_be_typed(folder: Path, text: str, typed: dict[str, str]) -> None:
    width = max(2, text.split("\n")[0].count(",") + 1)
    rows = "\n".join(",".join(f"{0.002 * i + 0.0001 * k:.4f}" for k in range(width)) for i in range(50))
    path = folder / "hint.csv"
    path.write_text(text.format(rows) + "\n", encoding="utf-8")
    for _ in range(3):  # one thing after the other may be missing
        sensitivity, rate = typed.pop("sensitivity", None), typed.pop("rate", None)
        given = read_sensitivities([sensitivity] if sensitivity else [])
        try:
            record = read_record(path, typed, given, body=False, rate=rate)
        except InputError as error:
            said = typed_in(error.hint)
            assert said
            doubles = {"sensitivity", "rate"} if len(said) > 1 else set()  # the other way to the same
            typed |= {name: value for name, value in said.items() if name not in doubles}
            continue
        assert record.time.size == 50
        return
    pytest.fail(f"{typed}")
