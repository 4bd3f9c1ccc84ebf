"""Reading engineers' tables: names, units, separators, and what is wrong with a row."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from helpers.cases import each
from helpers.made_tables import read


@each(
    ("encoding", "mark"),
    [
        ("utf-8", b""),
        ("utf-8-sig", b""),
        ("utf-16-le", b"\xff\xfe"),
        ("utf-16-be", b"\xfe\xff"),
        ("cp1252", b""),
    ],
)
def test_encodings(tmp_path: Path, encoding: str, mark: bytes) -> None:
    content = mark + "Time [s],Auslenkung [µm]\n0,1\n1,2\n2,5\n".encode(encoding)
    record = read(tmp_path, content, time="Time [s]")
    np.testing.assert_allclose(record.signals["displacement"], [1e-6, 2e-6, 5e-6])
    assert record.headers == {"time": "Time [s]", "displacement": "Auslenkung [µm]"}


HEADERS: dict[str, tuple[list[str], dict[str, str]]] = {
    "units in the names": (["Time [s],X [mm]"], {}),
    "a preamble": (["Motion study,7", "rate,1000", "Time [s],X [mm]"], {}),
    "a row of units": (["Time,X", "[s],[mm]"], {}),
    "units from options": (["t,x"], {"time": "t [s]", "displacement": "x [mm]"}),
    "numbers as names": (["Time [s],1"], {"displacement": "1 [mm]"}),
}
BAD = {
    "text": "0,abc",
    "an empty cell": "start,",
    "a bad time": "start,1.5",
    "no number at all": "NaN,NaN",
    "a spreadsheet's error": "n/a,#DIV/0!",
    "thousands": "0,1.000.5",
}


@each("header", HEADERS)
@each("bad", BAD)
@each("rows", [1, 3])
def test_bad_cells_above_the_first_row_of_numbers_are_no_headers(
    tmp_path: Path, header: str, bad: str, rows: int
) -> None:
    above, columns = HEADERS[header]
    data = [f"{i}.5,{i * i}.25" for i in range(10)]
    record = read(tmp_path, [*above, *[BAD[bad]] * rows, *data], **columns)
    clean = read(tmp_path, [*above, *data], **columns)
    np.testing.assert_array_equal(record.time, clean.time)
    np.testing.assert_array_equal(record.signals["displacement"], clean.signals["displacement"])
    assert record.headers == clean.headers
    assert f"row {len(above) + 1}" in record.notes[0]


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


def test_the_largest_value_is_read(tmp_path: Path) -> None:
    record = read(tmp_path, ["t [s],x [m]", "0,1e20", "1,-1e20"])
    np.testing.assert_array_equal(record.signals["displacement"], [1e20, -1e20])


def test_a_row_that_is_too_short_lacks_its_last_values(tmp_path: Path) -> None:
    content = ["t [s],x [mm],v [mm/s]", *(f"{i},{i},{i}" for i in range(30))]
    content[7] = "6,6"
    record = read(tmp_path, content)
    assert record.time.tolist() == [i for i in range(30) if i != 6]
    content[7] = "6"
    assert read(tmp_path, content, velocity="v").time.size == 29


def test_decimal_commas_between_quotes(tmp_path: Path) -> None:
    record = read(tmp_path, ["Time [s],X [mm]", '"0,5","1,25"', '"1,0","2,5"', "2,3"])
    np.testing.assert_allclose(record.signals["displacement"], [1.25e-3, 2.5e-3, 3e-3])
    np.testing.assert_array_equal(record.time, [0.5, 1.0, 2.0])


def test_a_byte_that_the_code_page_lacks_is_replaced(tmp_path: Path) -> None:
    """0x81 has no character in Windows-1252, and 0xb5 is the micro sign."""
    record = read(tmp_path, b"Time [s],\x81 [\xb5m]\n0,1\n1,2\n")
    np.testing.assert_allclose(record.signals["displacement"], [1e-6, 2e-6])
    assert record.headers["displacement"] == "\ufffd [\u00b5m]"


def test_cells_beyond_the_header_row_may_be_empty(tmp_path: Path) -> None:
    """Some programs end each row of data with a separator."""
    assert read(tmp_path, ["t [s],x [mm]", "0,1,", "1,2, ,"]).time.size == 2


def test_a_step_of_three_and_a_half_usual_ones_is_no_gap(tmp_path: Path) -> None:
    """Exactly that, in times that doubles hold exactly."""
    times = [0.0, 0.5, 1.0, 1.5, 2.0, 3.75]
    assert read(tmp_path, ["t [s],x [mm]", *(f"{t},0" for t in times)]).time.size == 6


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
