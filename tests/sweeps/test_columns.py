"""Tables: exact floats, separators, and the same numbers as the library's."""

from __future__ import annotations

import csv
import io
import math
import pickle
from typing import Any

import numpy as np
import pyarrow as pa
from helpers.plans import swept
from hypothesis import given
from hypothesis import strategies as st

import vibro
from vibro.files.csv_tables import CsvFormat
from vibro.quantities import DRIVES, QUANTITIES, SWEPT
from vibro.results.sweep import Block
from vibro.sweeps.columns import arrow_table, chosen, columns_of, frame_of
from vibro.sweeps.derived import standing, throughput
from vibro.sweeps.run import sweep_blocks

COLUMNS = columns_of()
FORMS = (CsvFormat(), CsvFormat(decimal_comma=True))
HEADER = (
    "amplitude_mm,frequency_hz,drive_angle_deg,static_friction,kinetic_friction,trough_angle_deg,regime,pattern,"
    "mean_velocity_mm_s,displacement_per_cycle_mm,peak_velocity_mm_s,traverse_time_s,throw_number,forward_ratio,"
    "back_ratio,flight_fraction,impact_speed_mm_s,period_cycles,mean_velocity_error_mm_s,coexists,model,status"
)


def block_of(**given: Any) -> Block:
    (block,) = sweep_blocks(swept(**given)._grid)
    return block


def csv_of(block: Block, form: CsvFormat) -> str:
    cells = arrow_table(COLUMNS, block)
    return (form.header(cells.column_names) + form.rows(cells)).decode()


def read(text: str, form: CsvFormat) -> dict[str, list[str]]:
    """Read a CSV as texts, by column."""
    header, *rows = csv.reader(io.StringIO(text, newline=""), delimiter=form.separator)
    return dict(zip(header, map(list, zip(*rows, strict=True)), strict=True))


def test_numbers_are_short_plain_ascii_without_negative_zero() -> None:
    block = block_of(amplitude_mm=[0.0000001, 1.5], trough_length_mm=600)
    text, german = (csv_of(block, form) for form in FORMS)
    header, *rows = text.splitlines()
    assert header == HEADER
    assert [row.split(",")[0] for row in rows] == ["1e-7", "1.5"]
    assert rows[0].split(",")[8:12] == ["0", "0", "0", ""]
    assert "-0," not in text
    assert text.isascii()
    assert german.splitlines()[2].startswith("1,5;15;20;0,74;0,57;0;back-slip;FB_;40,5906")
    assert "." not in german


@given(st.lists(st.floats(), min_size=1), st.booleans())
def test_every_double_is_read_back(values: list[float], decimal_comma: bool) -> None:
    form = FORMS[decimal_comma]
    table = read(form.table(dict.fromkeys("xy", np.array(values))).decode(), form)
    for found in table.values():
        numbers = [float(text.replace(",", ".") or "nan") for text in found]
        np.testing.assert_array_equal(numbers, [x if math.isfinite(x) else math.nan for x in values])


def test_texts_are_quoted_where_they_must_be_and_no_formulas() -> None:
    texts = ["plain", "", 'a "b"', "1;2", "1, 2", "two\nlines", "=1+1", "@a", "-x", "+49", "\u00e4"]
    for form in FORMS:
        text = form.table({"=head": texts, "x": np.arange(11.0)}).decode()
        table = read(text, form)
        assert table.pop("x") == [str(i) for i in range(11)]
        assert table == {"'=head": [*texts[:6], "'=1+1", "'@a", "'-x", "'+49", "\u00e4"]}
        assert text.splitlines()[1] == f"plain{form.separator}0"
        # a separator alone is a reason to quote
        alone = ["plain", f"1{form.separator}2"]
        assert read(form.table({"x": alone}).decode(), form) == {"x": alone}


def test_what_has_no_number_is_null_and_an_empty_cell() -> None:
    block = block_of(amplitude_mm=[1, 9], kinetic_friction=[0.5, 0.9])
    table = arrow_table(COLUMNS, block)
    assert table["status"].to_pylist() == ["ok", "infeasible", "ok", "infeasible"]
    assert table["traverse_time_s"].null_count == 4
    assert table["amplitude_mm"].null_count == 0
    lost = table.to_pylist()[1]
    assert (lost["mean_velocity_mm_s"], lost["throw_number"], lost["regime"]) == (None, None, "")
    cells = read(csv_of(block, CsvFormat()), CsvFormat())
    assert [cells[name][1] for name in ("mean_velocity_mm_s", "throw_number", "regime")] == ["", "", ""]
    assert table["coexists"].type == pa.int8()
    flags = block.cycle.coexists.ravel().tolist()
    assert table["coexists"].to_pylist() == [flag if flag >= 0 else None for flag in flags]
    assert 0 in flags
    assert table["regime"].chunk(0).dictionary.to_pylist() == [*(r.label for r in vibro.Regime if r >= 0), ""]
    assert table.schema.field("mean_velocity_mm_s").metadata[b"unit"] == b"mm/s"


def test_columns_by_name() -> None:
    block = block_of(amplitude_mm="0.1:4:40", frequency_hz=[15, 25], trough_length_mm=600)
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


def test_every_column_reaches_workers() -> None:
    extra = [*throughput({"pitch_mm": 25.0, "mass_kg": 0.012}), *standing(0.8)]
    columns = columns_of(QUANTITIES, *extra, drive=DRIVES, machine=True)
    inputs = {QUANTITIES[name].column for name in (*SWEPT, *DRIVES)}
    assert {column.name for column in columns} >= {*inputs, "mass_flow_kg_h", "upright", "pattern"}
    assert [column.name for column in pickle.loads(pickle.dumps(columns))] == [c.name for c in columns]
