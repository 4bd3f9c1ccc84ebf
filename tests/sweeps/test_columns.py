"""Tables: exact floats, separators, and the same numbers as the library's."""

from __future__ import annotations

import csv
import io
import math
import pickle
from dataclasses import replace

import numpy as np
import pyarrow as pa
from hypothesis import given
from hypothesis import strategies as st

import vibro
from vibro.axes import parse_axis
from vibro.files.csv_tables import CsvFormat
from vibro.quantities import DRIVES, QUANTITIES, SWEPT
from vibro.results.operating import FIELDS, OPERATING
from vibro.results.sweep import Block, Column
from vibro.sweeps import derived
from vibro.sweeps.columns import arrow_table, chosen, columns_of, frame_of
from vibro.sweeps.derived import WITH_STROKES
from vibro.sweeps.grid import Grid
from vibro.sweeps.run import sweep_blocks

COLUMNS = columns_of()

HEADER = (
    "amplitude_mm,frequency_hz,drive_angle_deg,static_friction,kinetic_friction,trough_angle_deg,regime,pattern,"
    "mean_velocity_mm_s,displacement_per_cycle_mm,peak_velocity_mm_s,traverse_time_s,throw_number,forward_ratio,"
    "back_ratio,flight_fraction,impact_speed_mm_s,period_cycles,mean_velocity_error_mm_s,coexists,model,status"
)


def one_block(length: float | None = 600.0, **texts: str) -> Block:
    given = {
        "amplitude": "0.1:4:40",
        "frequency": "10:50:9",
        "drive_angle": "20",
        "static_friction": "0.74",
        "kinetic_friction": "0.57",
        "trough_angle": "0",
        "gravity": "9.81",
        "restitution": "0",
    } | texts
    specs = {name: parse_axis(text, QUANTITIES[name]) for name, text in given.items()}
    axes = {name: spec.axis(7) for name, spec in specs.items() if spec.varies}
    fixed = {name: spec.value for name, spec in specs.items() if not spec.varies}
    (block,) = sweep_blocks(Grid(axes, fixed, length))
    return block


def csv_of(block: Block, form: CsvFormat) -> str:
    cells = arrow_table(COLUMNS, block)
    return (form.header(cells.column_names) + form.rows(cells)).decode()


def read(text: str, form: CsvFormat) -> dict[str, list[str]]:
    """Read a CSV as texts, by column."""
    header, *rows = csv.reader(io.StringIO(text, newline=""), delimiter=form.separator)
    return dict(zip(header, map(list, zip(*rows, strict=True)), strict=True))


def floats(texts: list[str]) -> list[float]:
    return [float(text.replace(",", ".") or "nan") for text in texts]


def test_the_columns_are_the_documented_ones() -> None:
    assert CsvFormat().header(column.name for column in COLUMNS).decode() == HEADER + "\n"
    names = [column.name for column in columns_of((), WITH_STROKES)]
    assert names[-3:] == ["strokes", "model", "status"]


def test_numbers_are_short_plain_ascii_without_negative_zero() -> None:
    text = csv_of(one_block(amplitude="0.0000001,1,2", frequency="15"), CsvFormat())
    rows = [line.split(",") for line in text.splitlines()[1:]]
    assert [row[0] for row in rows] == ["1e-7", "1", "2"]
    assert rows[0][8:12] == ["0", "0", "0", ""]
    assert "-0," not in text
    assert text.isascii()


def test_decimal_commas_reach_every_number() -> None:
    text = csv_of(one_block(amplitude="1.5,2", frequency="15"), CsvFormat(decimal_comma=True))
    assert text.splitlines()[1].startswith("1,5;15;20;0,74;0,57;0;back-slip;FB_;40,5906")
    assert "." not in text


@given(st.lists(st.floats()), st.booleans())
def test_every_double_is_read_back(values: list[float], decimal_comma: bool) -> None:
    form = CsvFormat(decimal_comma=decimal_comma)
    lines = form.table(dict.fromkeys("xy", np.array(values, float))).decode().splitlines()[1:]
    read_back = [floats(line.split(form.separator)) for line in lines]
    np.testing.assert_array_equal(
        read_back, [[x if math.isfinite(x) else math.nan] * 2 for x in values] or []
    )


def test_texts_are_quoted_where_they_must_be_and_no_formulas() -> None:
    texts = ["plain", "", 'a "b"', "1;2", "1, 2", "two\nlines", "=1+1", "@a", "-x", "+49", "\u00e4"]
    for form in (CsvFormat(), CsvFormat(decimal_comma=True)):
        text = form.table({"=head": texts, "x": np.arange(11.0)}).decode()
        table = read(text, form)
        assert table.pop("x") == [str(i) for i in range(11)]
        assert table == {"'=head": [*texts[:6], "'=1+1", "'@a", "'-x", "'+49", "\u00e4"]}
        assert text.splitlines()[1] == f"plain{form.separator}0"


def test_a_separator_alone_is_a_reason_to_quote() -> None:
    for form in (CsvFormat(), CsvFormat(decimal_comma=True)):
        texts = ["plain", f"1{form.separator}2"]
        assert read(form.table({"x": texts}).decode(), form) == {"x": texts}


def test_an_arrow_table_has_nulls_texts_and_units() -> None:
    block = one_block(length=None, amplitude="1, 9", frequency="15", kinetic_friction="0.5,0.9")
    table = arrow_table(COLUMNS, block)
    assert table["mean_velocity_mm_s"].null_count == 2
    assert table["traverse_time_s"].null_count == 4
    assert table["amplitude_mm"].null_count == 0
    assert table["coexists"].type == pa.int8()
    flags = [column.values(block).ravel().tolist() for column in COLUMNS if column.name == "coexists"]
    assert table["coexists"].to_pylist() == [flag if flag >= 0 else None for flag in flags[0]]
    assert 0 in flags[0]
    assert table["regime"].chunk(0).dictionary.to_pylist() == [*(r.label for r in vibro.Regime if r >= 0), ""]
    assert table.schema.field("mean_velocity_mm_s").metadata[b"unit"] == b"mm/s"


def test_columns_by_name() -> None:
    block = one_block(frequency="15, 25")
    names = ["mean_velocity_mm_s", "stroke_mm", "regime", "acceleration_g", "strokes", "amplitude_mm"]
    columns = chosen(names, COLUMNS)
    frame, usual = (frame_of(arrow_table(of, block)) for of in (columns, COLUMNS))
    assert list(frame) == names
    assert (frame["stroke_mm"] == 2.0 * usual["amplitude_mm"]).all()
    w = 2.0 * math.pi * usual["frequency_hz"]
    np.testing.assert_allclose(
        frame["acceleration_g"], 1e-3 * usual["amplitude_mm"] * w**2 / 9.81, rtol=1e-15
    )
    np.testing.assert_array_equal(frame["strokes"], usual["frequency_hz"] * usual["traverse_time_s"])
    assert (frame["regime"] == usual["regime"]).all()


def test_no_number_is_an_empty_cell_and_null() -> None:
    block = one_block(length=None, amplitude="1, 9", frequency="15", kinetic_friction="0.5,0.9")
    rows = [
        dict(zip(HEADER.split(","), line.split(","), strict=True))
        for line in csv_of(block, CsvFormat()).splitlines()[1:]
    ]
    assert [row["status"] for row in rows] == ["ok", "infeasible", "ok", "infeasible"]
    assert rows[1]["mean_velocity_mm_s"] == rows[1]["throw_number"] == rows[0]["traverse_time_s"] == ""
    infeasible = arrow_table(COLUMNS, block).to_pylist()[1]
    assert infeasible["mean_velocity_mm_s"] is None
    assert infeasible["regime"] == ""
    assert infeasible["throw_number"] is None


def test_every_column_pickles() -> None:
    solved = replace(one_block(amplitude="0.1:6:9", restitution="0,0.3"), arrival=np.array([[0.5], [np.inf]]))
    inputs = {QUANTITIES[name].column for name in (*SWEPT, *DRIVES)}
    given = replace(solved, values={name: np.full((1, 1), i) for i, name in enumerate(QUANTITIES, 1)})
    extra = [column for column in vars(derived).values() if isinstance(column, Column)]
    extra += [*derived.throughput({"pitch_mm": 25.0, "mass_kg": 0.012}), *derived.standing(0.8)]
    solved = replace(solved, values={**solved.values, OPERATING: np.ones((1, 1), FIELDS)})
    columns = columns_of(QUANTITIES, *extra, drive=DRIVES, machine=True)
    names = {column.name for column in columns}
    assert names >= {*inputs, "arrival_time_s", "mass_flow_kg_h", "upright", "pattern"}
    for column in columns:
        again = pickle.loads(pickle.dumps(column))
        assert replace(again, values=column.values) == column
        block = given if column.name in inputs else solved
        np.testing.assert_array_equal(again.values(block), column.values(block), strict=True)


def test_patterns_are_codes_until_they_are_texts() -> None:
    block = one_block(amplitude="0.1:9:40", restitution="0,0.4")
    (column,) = (column for column in COLUMNS if column.name == "pattern")
    np.testing.assert_array_equal(column.values(block), block.cycle.pattern_code, strict=True)
    cells = arrow_table([column], block)["pattern"].combine_chunks()
    texts = cells.dictionary.to_pylist()
    assert texts == sorted({*texts})
    assert len(texts) > 20
    assert cells.to_pylist() == block.cycle.pattern.ravel().tolist()
    assert abs(column.values(block)).max() > 1e9  # codes of long patterns
