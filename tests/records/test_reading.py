"""Reading engineers' tables: names, units, separators, and what is wrong with a row."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from helpers.cases import each
from helpers.made_tables import POSITIONS, TIMES, lines, read, refusal

from vibro.errors import FileError
from vibro.records.reading import read_record


@each("newline", ["\n", "\r\n"])
@each(
    ("separator", "comma", "note"),
    [
        (",", False, None),
        (";", False, "separated by semicolons"),
        (";", True, "separated by semicolons, decimal commas"),
        ("\t", False, "separated by tabs"),
        ("\t", True, "separated by tabs, decimal commas"),
    ],
)
def test_separators_and_decimals(
    tmp_path: Path, separator: str, comma: bool, note: str | None, newline: str
) -> None:
    content = lines(separator, f"Time [s]{separator}X [mm]", comma)
    record = read(tmp_path, content, newline)
    np.testing.assert_array_equal(record.time, TIMES)
    np.testing.assert_allclose(record.signals["displacement"], POSITIONS / 1000, rtol=1e-15)
    said = [text for text in record.notes if "separated" in text]
    assert said == ([f"data.csv: {note}"] if note else [])


def test_quoted_decimal_commas_between_commas(tmp_path: Path) -> None:
    content = ["Time [s],X [mm]", '"0,5","1,25"', '"1,0","2,5"']
    np.testing.assert_array_equal(read(tmp_path, content).time, [0.5, 1.0])


@each(
    ("encoding", "note"),
    [("utf-8", None), ("utf-8-sig", None), ("utf-16", "UTF-16"), ("cp1252", "Windows-1252")],
)
def test_encodings(tmp_path: Path, encoding: str, note: str | None) -> None:
    content = "Time [s],Auslenkung [µm]\n0,1\n1,2\n2,5\n".encode(encoding)
    record = read(tmp_path, content)
    np.testing.assert_allclose(record.signals["displacement"], [1e-6, 2e-6, 5e-6])
    assert record.headers["displacement"] == "Auslenkung [µm]"
    assert (
        any(note in text for text in record.notes) if note else not any("data.csv" in t for t in record.notes)
    )


def test_columns_by_name_part_of_it_and_number_of_words(tmp_path: Path) -> None:
    content = ["Time (sec),Weg (mm),Weg 2 (mm),Force (newton)", "0,1,2,3", "1,2,3,4", "2,0,0,0"]
    record = read(tmp_path, content, time="time", displacement="Weg 2 (mm)", friction="FORCE (newton)")
    np.testing.assert_allclose(record.signals["displacement"], [2e-3, 3e-3, 0.0])
    np.testing.assert_array_equal(record.signals["friction"], [3.0, 4.0, 0.0])
    assert set(record.signals) == {"displacement", "friction"}


def test_the_unit_may_come_from_the_option(tmp_path: Path) -> None:
    content = ["t,v", "0,1", "10,2", "20,3"]
    record = read(tmp_path, content, time="t [ms]", velocity="v [mm/s]")
    np.testing.assert_allclose(record.time, [0.0, 0.01, 0.02])
    np.testing.assert_allclose(record.signals["velocity"], [1e-3, 2e-3, 3e-3])


def test_a_long_record_may_count_minutes(tmp_path: Path) -> None:
    record = read(tmp_path, ["t [min],x [mm]", "0,1", "0.5,2", "1,3"])
    np.testing.assert_array_equal(record.time, [0.0, 30.0, 60.0])


def test_preamble_and_row_of_units(tmp_path: Path) -> None:
    content = ["Motion study 1", "Time;X", "[ms];[mm]", "0;1,5", "1;2,5", "2;0,5"]
    record = read(tmp_path, content)
    np.testing.assert_allclose(record.time, [0.0, 1e-3, 2e-3])
    np.testing.assert_allclose(record.signals["displacement"], [1.5e-3, 2.5e-3, 0.5e-3])


def test_a_preamble_above_a_header_with_units(tmp_path: Path) -> None:
    record = read(tmp_path, ["study,1", *lines()])
    assert record.headers == {"time": "Time [s]", "displacement": "X [mm]"}


def test_names_of_own_tables_carry_their_units(tmp_path: Path) -> None:
    header = "time_s,trough_displacement_mm,relative_position_mm,relative_velocity_mm_s,inertial_m_s2"
    header += ",relative_acceleration_m_s2"
    record = read(tmp_path, [header, "0,1,2,3,4,5", "1,1,2,3,4,5", "2,1,2,3,4,5"])
    assert record.headers == {
        "time": "time_s",
        "displacement": "relative_position_mm",
        "velocity": "relative_velocity_mm_s",
        "acceleration": "relative_acceleration_m_s2",
    }


def test_columns_of_text_beside_the_numbers_do_not_matter(tmp_path: Path) -> None:
    record = read(tmp_path, ["phase,t [s],x [mm]", "rest,0,1", "slide,1,2", ",2,3"])
    np.testing.assert_array_equal(record.time, [0.0, 1.0, 2.0])


def test_ambiguous_columns_are_named(tmp_path: Path) -> None:
    error = refusal(tmp_path, ["t [s],left [mm],right [mm]", "0,1,2", "1,2,3"])
    assert "'left [mm]', 'right [mm]' could each be the displacement" in str(error)
    assert error.hint == 'choose: displacement="left [mm]" of a part, trough_along="left [mm]" of the trough'


def test_a_missing_column_suggests_the_nearest(tmp_path: Path) -> None:
    error = refusal(tmp_path, lines(), displacement="X [mn]")
    assert "no column 'X [mn]' for displacement=" in str(error)
    assert "'Time [s]', 'X [mm]'" in str(error)
    assert error.hint == "did you mean 'X [mm]'?"


def test_a_column_without_unit_is_refused_with_the_way_to_give_it(tmp_path: Path) -> None:
    error = refusal(tmp_path, ["t [s],X", "0,1", "1,2"], displacement="X")
    assert "column 'X' for displacement=: it has no unit" in str(error)
    assert 'displacement="X [mm]"' in error.hint


def test_a_unit_of_another_kind_is_refused(tmp_path: Path) -> None:
    error = refusal(tmp_path, lines(), velocity="X [mm]")
    assert "'mm' is no unit of velocity" in str(error)


def test_one_column_cannot_be_two_signals(tmp_path: Path) -> None:
    content = ["t [s],a", "0,1", "1,2"]
    error = refusal(tmp_path, content, acceleration="a [m/s^2]", friction="a [N]")
    assert "given as acceleration and as friction" in str(error)


def test_no_time_and_no_signal(tmp_path: Path) -> None:
    assert "no column of time" in str(refusal(tmp_path, ["n,X [mm]", "0,1", "1,2"]))
    error = refusal(tmp_path, ["t [s],X", "0,1", "1,2"])
    assert "no signal found" in str(error)
    assert "displacement=" in error.hint


@each(
    ("cell", "said"),
    [
        ("overflow", "row 4, column 'X [mm]': 'overflow' is not a number"),
        ("", "row 4, column 'X [mm]': the cell is empty"),
        ("nan", "row 4, column 'X [mm]': 'nan' is not a number"),
        ("1e999", "row 4, column 'X [mm]': 1e999 is too large to compute with, at most 1e+23 is allowed"),
        ("-1e308", "row 4, column 'X [mm]': -1e308 is too large to compute with, at most 1e+23 is allowed"),
        ("9" * 5000, "row 4, column 'X [mm]': 99999"),
        ("9" * 5000 + "x", "9x' (5001 characters) is not a number"),
    ],
)
def test_text_rows_are_named(tmp_path: Path, cell: str, said: str) -> None:
    content = lines()
    content[3] = f"{TIMES[2]},{cell}"
    error = refusal(tmp_path, content)
    assert said in str(error)
    assert error.hint


def test_row_numbers_count_blank_lines_and_preambles(tmp_path: Path) -> None:
    content = ["study", "", *lines()]
    content[5] = f"{TIMES[2]},bad"
    assert "row 6, column 'X [mm]': 'bad' is not a number" in str(refusal(tmp_path, content))


def test_many_bad_cells_are_counted(tmp_path: Path) -> None:
    content = lines()[:3] + [f"{t},-" for t in range(20)]
    problems = refusal(tmp_path, content).problems
    assert len(problems) == 7
    assert "15 more such cells" in problems[-2]
    assert "20 of 22 rows lack a value: at most 5 % are skipped" in problems[-1]


@pytest.mark.parametrize(
    ("order", "said"),
    [
        ([0, 1, 2, 2, 3, 4, 5], "row 5, column 'Time [s]': time repeats 0.00333333333 s"),
        ([0, 1, 3, 2, 4, 5], "row 5, column 'Time [s]': time goes back to 0.00333333333 s after 0.005 s"),
    ],
)
def test_repeated_and_unsorted_times(tmp_path: Path, order: list[int], said: str) -> None:
    header, *rows = lines()
    error = refusal(tmp_path, [header, *(rows[i] for i in order)])
    assert said in str(error)
    assert error.hint


def test_a_gap_is_named(tmp_path: Path) -> None:
    times = [0.0, 1.0, 2.0, 6.0, 7.0, 8.0, 12.0]
    error = refusal(tmp_path, ["t [s],X [mm]", *(f"{t},0" for t in times)])
    assert "row 5, column 't [s]': time jumps to 6 s after 2 s, usual steps are 1 s; 1 more such row" in str(
        error
    )


def test_unquoted_decimal_commas_between_commas(tmp_path: Path) -> None:
    error = refusal(tmp_path, ["t [s],X [mm]", "0,0,1,5", "0,1,2,5"])
    assert "row 2 has 4 cells, the header row 2" in str(error)
    assert "semicolons" in error.hint


def test_thousands_are_no_numbers(tmp_path: Path) -> None:
    error = refusal(tmp_path, ["t [s];X [mm]", "0;1,5", "1;1.000,5", "2;1,5"])
    assert "'1.000,5' is not a number" in str(error)


@each("content", [b"", b"hello\nworld\n", b"\x89PNG\0\0", b"\xff\xfeabc"])
def test_files_that_are_no_tables(tmp_path: Path, content: bytes) -> None:
    assert "data.csv: " in str(refusal(tmp_path, content))


def test_a_table_without_header(tmp_path: Path) -> None:
    error = refusal(tmp_path, ["0,1", "1,2"])
    assert "row 1 holds numbers" in str(error)
    assert "Time [s]" in error.hint


def test_a_missing_file_suggests_its_neighbour(tmp_path: Path) -> None:
    (tmp_path / "nut.csv").write_text("", encoding="utf-8")
    with pytest.raises(FileError) as caught:
        read_record(tmp_path / "nuts.csv")
    assert "nut.csv" in caught.value.hint


HEADERS: dict[str, tuple[list[str], dict[str, str]]] = {
    "units in the names": (["Time [s],X [mm]"], {}),
    "a preamble": (["Motion study,7", "rate,1000", "Time [s],X [mm]"], {}),
    "a row of units": (["Time,X", "[s],[mm]"], {}),
    "units from options": (["t,x"], {"time": "t [s]", "displacement": "x [mm]"}),
    "numbers as names": (["Time [s],1"], {"displacement": "1 [mm]"}),
}
BAD: dict[str, tuple[str, str, str]] = {
    "text": ("0,abc", "x", "'abc' is not a number"),
    "an empty cell": ("0,", "x", "the cell is empty"),
    "a bad time": ("start,1.5", "t", "'start' is not a number"),
    "no number at all": ("NaN,NaN", "t", "'NaN' is not a number"),
    "a spreadsheet's error": ("#N/A,-", "t", "'#N/A' is not a number"),
    "a number too large": ("0,1e308", "x", "1e308 is too large to compute with"),
    "thousands": ("0,1.000.5", "x", "'1.000.5' is not a number"),
}


@each("header", HEADERS)
@each("bad", BAD)
@each("rows", [1, 3])
def test_bad_cells_in_the_first_rows_are_no_headers(tmp_path: Path, header: str, bad: str, rows: int) -> None:
    above, columns = HEADERS[header]
    row, column, said = BAD[bad]
    data = [f"{i},{i * i}" for i in range(10)]
    error = refusal(tmp_path, [*above, *[row] * rows, *data], **columns)
    names = {"t": ("Time", "[s]", "t"), "x": ("X", "[mm]", "x", "1")}[column]
    problem = next(text for text in error.problems if said in text)
    assert f"row {len(above) + 1}, column " in problem
    assert any(name in problem for name in names)
    assert read(tmp_path, [*above, *data], **columns).time.size == 10


@each("bad", ["abc", "", "NaN"])
def test_a_bad_first_row_of_a_table_without_header(tmp_path: Path, bad: str) -> None:
    assert "no column of time found" in str(refusal(tmp_path, [f"0,{bad}", "1,2", "2,3"]))


def test_many_columns_are_counted_in_messages(tmp_path: Path) -> None:
    header = ",".join(f"channel {i}" for i in range(5000))
    row = ",".join(["1"] * 5000)
    error = refusal(tmp_path, [header, row, row])
    assert "and 4988 more" in str(error)
    assert len(str(error)) < len(str(tmp_path)) + 600


@each("cell", ["9" * 100_000 + "x", "1" * 60_000 + "e" + "1" * 60_000, "," * 100_000])
def test_long_cells_take_no_time(tmp_path: Path, cell: str) -> None:
    error = refusal(tmp_path, ["t [s];x [mm]", "0;1", f"1;{cell}", "2;3"])
    assert "row 3, column 'x [mm]': " in str(error)
    assert len(str(error)) < len(str(tmp_path)) + 300


@each(
    "header",
    [
        "Zeit in s;Weg in mm",
        "Zeit (in s);Weg [in mm]",
        "Zeit / s;Weg / mm",
        "time in s;position in the box in mm",
    ],
)
def test_units_in_words(tmp_path: Path, header: str) -> None:
    record = read(tmp_path, [header, "0;1", "1;2", "2;3"])
    np.testing.assert_array_equal(record.time, [0.0, 1.0, 2.0])
    np.testing.assert_allclose(record.signals["displacement"], [1e-3, 2e-3, 3e-3])
    record = read(tmp_path, [header, "0;1", "1;2", "2;3"], displacement=header.split(";")[1])
    assert record.headers["displacement"] == header.split(";")[1]


def test_a_word_that_is_no_unit_belongs_to_the_name(tmp_path: Path) -> None:
    content = ["t [s],change in place", "0,1", "1,2"]
    np.testing.assert_allclose(
        read(tmp_path, content, displacement="change in place [in]").signals["displacement"], [0.0254, 0.0508]
    )
    assert "it has no unit" in str(refusal(tmp_path, content, displacement="change in place"))


def test_a_column_of_the_trough_is_no_signal_of_the_body(tmp_path: Path) -> None:
    content = ["t [s],x [mm],a [m/s^2]", "0,1,5", "1,2,6"]
    record = read(tmp_path, content, trough_along="a")
    assert set(record.signals) == {"displacement"}
    np.testing.assert_array_equal(record.trough["trough_along"], [5.0, 6.0])
    assert "motions of the trough alone" in str(
        refusal(tmp_path, ["t [s],a [g]", "0,1", "1,2"], trough_along="a")
    )
    assert "given as trough along and as trough normal" in str(
        refusal(tmp_path, content, trough_along="a", trough_normal="a")
    )


@each(
    ("header", "signal", "size"),
    [
        ("Weg/mm", "displacement", 1e-3),
        ("s/mm", "displacement", 1e-3),
        ("v/(mm/s)", "velocity", 1e-3),
        ("v / (mm/s)", "velocity", 1e-3),
        ("v/mm/s", "velocity", 1e-3),
        ("a/(m/s²)", "acceleration", 1.0),
        ("F/N", "friction", 1.0),
        ("Laser 1/µm", "displacement", 1e-6),
    ],
)
def test_a_header_may_be_a_signal_over_its_unit(
    tmp_path: Path, header: str, signal: str, size: float
) -> None:
    record = read(tmp_path, [f"Zeit/s;{header}", "0;1", "1;2", "2;4"])
    np.testing.assert_array_equal(record.time, [0.0, 1.0, 2.0])
    np.testing.assert_allclose(record.signals[signal], np.array([1.0, 2.0, 4.0]) * size, rtol=1e-15)
    assert len(record.signals) == 1
    name = header.split("/")[0].strip()
    named = read(tmp_path, [f"Zeit/s;{header}", "0;1", "1;2", "2;4"], time="Zeit", **{signal: name})
    assert named.headers == {"time": "Zeit/s", signal: header}


@each("header", ["mm/s", "m / s", "N/mm", "mV/g", "mV/(m/s²)", "Kraft/Weg", "Weg/Zeit", "Weg/s", "Force/mm"])
def test_a_quotient_that_is_no_signal_over_its_unit_has_no_unit(tmp_path: Path, header: str) -> None:
    record = read(tmp_path, [f"Zeit/s;X [mm];{header}", "0;1;5", "1;2;6", "2;4;7"])
    assert record.headers == {"time": "Zeit/s", "displacement": "X [mm]"}


# --- edges of what is read ----------------------------------------------------------------------------


def test_the_largest_value_is_read_and_the_next_one_refused(tmp_path: Path) -> None:
    record = read(tmp_path, ["t [s],x [m]", "0,1e20", "1,-1e20"])
    np.testing.assert_array_equal(record.signals["displacement"], [1e20, -1e20])
    error = refusal(tmp_path, ["t [s],x [m]", "0,1", "1,1.0000001e20"])
    assert str(error).endswith(
        "row 3, column 'x [m]': 1.0000001e20 is too large to compute with, at most 1e+20 is allowed"
    )


def test_a_row_that_is_too_short_lacks_its_last_values(tmp_path: Path) -> None:
    content = ["t [s],x [mm],v [mm/s]", *(f"{i},{i},{i}" for i in range(30))]
    content[7] = "6,6"
    record = read(tmp_path, content)
    assert record.time.tolist() == [i for i in range(30) if i != 6]
    assert "data.csv: 1 of 30 rows lacks a value and is skipped: row 8" in record.notes
    content[7] = "6"
    assert read(tmp_path, content, velocity="v").time.size == 29


@each(("bad", "more"), [(4, ""), (5, ""), (6, "1 more such cell"), (7, "2 more such cells")])
def test_five_bad_cells_are_named_and_more_of_them_counted(tmp_path: Path, bad: int, more: str) -> None:
    content = ["t [s],x [mm]", "0,1", "1,2", *(f"{i},bad{i}" for i in range(2, 2 + bad))]
    error = refusal(tmp_path, content)
    named = [f"row {i + 2}, column 'x [mm]': 'bad{i}' is not a number" for i in range(2, 2 + min(bad, 5))]
    counted = [f"column 'x [mm]': {more}"] if more else []
    assert list(error.problems) == [f"{tmp_path / 'data.csv'}: {text}" for text in named + counted]


def test_decimal_commas_between_quotes_are_echoed(tmp_path: Path) -> None:
    record = read(tmp_path, ["Time [s],X [mm]", '"0,5","1,25"', '"1,0","2,5"', "2,3"])
    np.testing.assert_allclose(record.signals["displacement"], [1.25e-3, 2.5e-3, 3e-3])
    assert record.notes[0] == "data.csv: separated by commas, decimal commas"


@pytest.mark.parametrize("mark", [b"\xff\xfe", b"\xfe\xff"])
def test_utf_16_in_either_order_of_bytes(tmp_path: Path, mark: bytes) -> None:
    text = "Time [s],Weg [µm]\n0,1\n1,2\n"
    record = read(tmp_path, mark + text.encode("utf-16-le" if mark == b"\xff\xfe" else "utf-16-be"))
    assert record.headers == {"time": "Time [s]", "displacement": "Weg [µm]"}
    assert record.notes[0] == "data.csv: UTF-16"


def test_a_byte_order_mark_is_no_part_of_the_first_header(tmp_path: Path) -> None:
    record = read(tmp_path, "Time [s],X [mm]\n0,1\n1,2\n".encode("utf-8-sig"), time="Time [s]")
    assert record.headers["time"] == "Time [s]"


def test_a_byte_that_the_code_page_lacks_is_replaced(tmp_path: Path) -> None:
    """0x81 has no character in Windows-1252, and 0xb5 is the micro sign."""
    record = read(tmp_path, b"Time [s],\x81 [\xb5m]\n0,1\n1,2\n")
    np.testing.assert_allclose(record.signals["displacement"], [1e-6, 2e-6])
    assert record.headers["displacement"] == "\ufffd [\u00b5m]"


@each("before", [1, 1000, 4000])
def test_a_file_with_a_null_byte_is_no_text(tmp_path: Path, before: int) -> None:
    error = refusal(tmp_path, b"t [s],x [mm]\n" + b"0,1\n" * (before // 4) + b"\0\n")
    assert str(error).endswith("data.csv: not a text file")


def test_a_first_row_with_more_numbers_than_usual_is_data(tmp_path: Path) -> None:
    """A column of text may hold a number in it; without a header row above, that is what is said."""
    rows = ["0,1,7", "1,2,slide", "2,3,rest"]
    np.testing.assert_array_equal(read(tmp_path, ["t [s],x [mm],phase", *rows]).time, [0.0, 1.0, 2.0])
    error = refusal(tmp_path, ["", *rows])
    assert str(error).endswith("data.csv: row 2 holds numbers, but there is no header row above it")


def test_cells_beyond_the_header_row_may_be_empty(tmp_path: Path) -> None:
    """Some programs end each row of data with a separator."""
    assert read(tmp_path, ["t [s],x [mm]", "0,1,", "1,2, ,"]).time.size == 2
    rows = [f"{i},1" for i in range(400)]
    error = refusal(tmp_path, ["t [s],x [mm]", *rows, "400,1,2,3"])
    assert str(error).endswith("data.csv: row 402 has 4 cells, the header row 2")


@each("row", ["overflow,#DIV/0!", "error,inf", "-Infinity,#REF"])
def test_a_first_row_in_which_all_went_wrong_is_no_header(tmp_path: Path, row: str) -> None:
    error = refusal(tmp_path, ["t [s],x [mm]", row, "1,2", "2,3"])
    said, other = (f": row 2, column '{name}': '{cell}' is not a number" for name, cell in
                   zip(("t [s]", "x [mm]"), row.split(","), strict=True))  # fmt: skip
    assert str(error).endswith(said) or str(error).endswith(other)


def times(values: list[float]) -> list[str]:
    return ["t [s],x [mm]", *(f"{t!r},{i}" for i, t in enumerate(values))]


def test_a_step_of_three_and_a_half_usual_ones_is_no_gap(tmp_path: Path) -> None:
    """Exactly that, in times that doubles hold exactly; the next larger step is one."""
    even = [0.0, 0.5, 1.0, 1.5, 2.0]
    assert read(tmp_path, times([*even, 3.75])).time.size == 6
    error = refusal(tmp_path, times([*even, 3.751]))
    where = f"{tmp_path / 'data.csv'}: row 7, column 't [s]'"
    assert str(error) == f"{where}: time jumps to 3.751 s after 2 s, usual steps are 0.5 s"


@each(
    ("values", "said"),
    [
        ([0.0, 1.0, 1.0, 2.0], "row 4, column 't [s]': time repeats 1 s, usual steps are 1 s"),
        (
            [0.0, 1.0, 1.0, 1.0, 2.0, 3.0, 4.0],
            "row 4, column 't [s]': time repeats 1 s, usual steps are 1 s; 1 more such row",
        ),
        (
            [0.0, 0.25, 0.5, 0.125, 0.75, 0.875],
            "row 5, column 't [s]': time goes back to 0.125 s after 0.5 s, usual steps are 0.25 s",
        ),
    ],
)
def test_a_wrong_time_is_told_in_full(tmp_path: Path, values: list[float], said: str) -> None:
    assert str(refusal(tmp_path, times(values))) == f"{tmp_path / 'data.csv'}: {said}"


def test_a_text_file_is_suggested_too(tmp_path: Path) -> None:
    (tmp_path / "measured.txt").write_text("", encoding="utf-8")
    with pytest.raises(FileError) as caught:
        read_record(tmp_path / "measured.csv")
    assert caught.value.hint == f"did you mean '{tmp_path / 'measured.txt'}'?"


@each(
    ("cell", "value"),
    [
        ("+1.5", 1.5),
        ("-.5", -0.5),
        ("5.", 5.0),
        ("1e-3", 1e-3),
        ("-2.5E+2", -250.0),
        ("7e1", 70.0),
        (" 4 ", 4.0),
    ],
)
def test_spellings_of_numbers(tmp_path: Path, cell: str, value: float) -> None:
    for text, separator in ((cell, ","), (cell.replace(".", ","), ";")):
        record = read(
            tmp_path, [separator.join(row) for row in (("t [s]", "x [m]"), ("0", text), ("1", "0"))]
        )
        assert record.signals["displacement"].tolist() == [value, 0.0]


@each("cell", ["1e", "1.2.3", "--1", "1 2", "0x10", "1_000", "e5", ".", "1e5.5"])
def test_what_is_no_number(tmp_path: Path, cell: str) -> None:
    error = refusal(tmp_path, ["t [s],x [m]", "0,1", "1,2", f"2,{cell}"])
    assert str(error).endswith(f"row 4, column 'x [m]': {cell!r} is not a number")
