"""Which columns of a table are the signals, by name, unit and word; what cells and voltages stand for."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING

import numpy as np
import pytest
from helpers.cases import each

from vibro import measured_motion
from vibro.errors import InputError
from vibro.records.reading import Record, read_record, read_sensitivities, signal_unit

if TYPE_CHECKING:
    from pathlib import Path


def read(folder: Path, content: list[str] | bytes, *sensitivities: str, **columns: str) -> Record:
    """Read a table of these lines, or of these bytes."""
    path = folder / "data.csv"
    path.write_bytes(content if isinstance(content, bytes) else "\n".join([*content, ""]).encode())
    return read_record(path, columns, read_sensitivities(sensitivities))


def of(folder: Path, header: str, row: str, *sensitivities: str, **columns: str) -> Record:
    """Read a table of two rows, these cells behind the times 0 and 1."""
    return read(folder, [header, f"0;{row}", f"1;{row}"], *sensitivities, **columns)


# --- files, rows and cells ------------------------------------------------------------------------------


@each(("encoding", "mark"), [
    ("utf-8", b""), ("utf-8-sig", b""), ("cp1252", b""), ("utf-16-le", b"\xff\xfe"),
    ("utf-16-be", b"\xfe\xff"),
])  # fmt: skip
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


@each("header", HEADERS)
@each("bad", ["0,abc", "start,", "start,1.5", "NaN,NaN", "n/a,#DIV/0!", "0,1.000.5"])
def test_bad_cells_above_the_first_row_of_numbers_are_no_headers(
    tmp_path: Path, header: str, bad: str
) -> None:
    above, columns = HEADERS[header]
    data = [f"{i}.5,{i * i}.25" for i in range(10)]
    record, clean = (read(tmp_path, [*above, *some, *data], **columns) for some in ([bad] * 2, []))
    np.testing.assert_array_equal(record.time, clean.time)
    np.testing.assert_array_equal(record.signals["displacement"], clean.signals["displacement"])
    assert record.headers == clean.headers
    assert f"row {len(above) + 1}" in record.notes[0]


@each("cell", ["", "NaN", "-nan", "+nan", "n/a", "NA", "#N/A", "null", "None", "-", "--", "?", "*", "***"])
@each("first", [2, 40, 100])
def test_a_few_rows_without_a_value_are_skipped_and_counted(tmp_path: Path, cell: str, first: int) -> None:
    lost = {first: f"0.1,{cell}", first + 1: f"{cell},3", 20: f"0.03,{cell}"}
    rows = {row: f"{(row - 2) / 600.0:.6f},{row}" for row in range(2, 102)} | lost
    record = read(tmp_path, ["t [s],x [mm]", *rows.values()])
    kept = [row for row in range(2, 102) if row not in lost]
    np.testing.assert_allclose(record.signals["displacement"], np.array(kept) / 1000)


def test_a_row_apart_by_spaces_that_is_too_short_is_skipped(tmp_path: Path) -> None:
    """Nothing tells which of its cells is missing."""
    content = ["t x v", "s mm mm/s", *(f"{i}  {i}  {2 * i}" for i in range(40))]
    content[12] = "10      20"
    record = read(tmp_path, content, displacement="x")
    assert record.time.tolist() == [i for i in range(40) if i != 10]
    np.testing.assert_allclose(record.signals["displacement"], 1e-3 * record.time)


@each("fill", ["", "last"])
@each("every", [2, 4, 5])
def test_a_column_that_is_sampled_more_slowly(tmp_path: Path, every: int, fill: str) -> None:
    """Its own rows are used, whether the others are empty or repeat its value."""
    slow = [f"{(i // every) % 7 + 0.1 * (i // every)}" for i in range(80)]
    if not fill:
        slow = ["" if i % every else cell for i, cell in enumerate(slow)]
    content = ["t [s],a [g],x [mm]", *(f"{i},{i % 9},{cell}" for i, cell in enumerate(slow))]
    record = read(tmp_path, content, displacement="x")
    assert record.time.tolist() == [*range(0, 80, every)]
    np.testing.assert_allclose(record.signals["displacement"], [1e-3 * float(x) for x in slow[::every]])


# --- names and units ------------------------------------------------------------------------------------


@each(("texts", "kind", "size"), [
    ("s sec second seconds", "time", 1.0), ("ms", "time", 1e-3), ("us \u00b5s", "time", 1e-6),
    ("min", "time", 60.0), ("m", "displacement", 1.0), ("cm", "displacement", 1e-2),
    ("mm MM", "displacement", 1e-3), ("um \u03bcm", "displacement", 1e-6), ("in", "displacement", 0.0254),
    ("m/s", "velocity", 1.0), ("cm/s", "velocity", 1e-2), ("mm/sec mm_s", "velocity", 1e-3),
    ("um_s", "velocity", 1e-6), ("in/s in_s", "velocity", 0.0254), ("m_s2 m/second**2", "acceleration", 1.0),
    ("cm/s^2", "acceleration", 1e-2), ("mm/sec**2 mm/s\u00b2", "acceleration", 1e-3),
    ("in_s2 in/s\u00b2", "acceleration", 0.0254), ("g", "acceleration", 9.80665),
    ("N newton newtons", "force", 1.0), ("mN", "force", 1e-3), ("kN", "force", 1e3),
    ("V Volt volts", "voltage", 1.0), ("mV", "voltage", 1e-3), ("deg 1/s furlong v", "", 0.0),
])  # fmt: skip
def test_spellings_of_units(texts: str, kind: str, size: float) -> None:
    for text in texts.split():
        found = signal_unit(text) or ("", 0.0)
        assert found[0] == kind
        assert found[1] == pytest.approx(size, rel=1e-15)


@each(("header", "signal", "size"), [
    ("Weg in mm", "displacement", 1e-3), ("Weg (in mm)", "displacement", 1e-3),
    ("Weg [in mm]", "displacement", 1e-3), ("position in the box in mm", "displacement", 1e-3),
    ("Weg/mm", "displacement", 1e-3), ("s/mm", "displacement", 1e-3), ("v / (mm/s)", "velocity", 1e-3),
    ("v/mm/s", "velocity", 1e-3), ("a/(m/s²)", "acceleration", 1.0), ("F/N", "friction", 1.0),
    ("Laser 1/µm", "displacement", 1e-6), ("speed_in_s", "velocity", 0.0254),
    ("pull_in_s2", "acceleration", 0.0254), ("position_in", "displacement", 0.0254),
    ("pull_kN", "friction", 1e3),
])  # fmt: skip
def test_units_in_words_behind_a_slash_or_an_underscore(
    tmp_path: Path, header: str, signal: str, size: float
) -> None:
    record = of(tmp_path, f"Zeit/s;{header}", "4")
    assert record.headers == {"time": "Zeit/s", signal: header}
    np.testing.assert_allclose(record.signals[signal], 4.0 * size, rtol=1e-15)


@each("header", [
    "mm/s", "m / s", "mm / sec", "N/mm", "mV/g", "mV/(m/s²)", "Kraft/Weg", "Weg/Zeit", "Weg/s", "Force/mm",
])  # fmt: skip
def test_a_quotient_that_is_no_signal_over_its_unit_has_no_unit(tmp_path: Path, header: str) -> None:
    record = of(tmp_path, f"Zeit/s;X [mm];{header}", "1;5")
    assert record.headers == {"time": "Zeit/s", "displacement": "X [mm]"}


@each("units", ["[s];[mm];", "(s);(mm);", "s;mm;", "s;(mm);[]"])
def test_a_row_of_units_may_leave_some_out(tmp_path: Path, units: str) -> None:
    record = of(tmp_path, f"Time;X;Y\n{units}", "1;5")
    assert record.headers == {"time": "Time [s]", "displacement": "X [mm]"}
    np.testing.assert_allclose(record.signals["displacement"], 1e-3)


@each(("words", "role", "unit"), [
    (("Position", "Weg_2", "Relative x", "xi", "s", "X2"), "displacement", "mm"),
    (("Speed", "Velocity", "Geschwindigkeit", "relative_", "v", "vx_1"), "velocity", "m/s"),
    (("Acceleration", "Beschleunigung", "relative a", "ax", "A"), "acceleration", "g"),
    (("Friction", "Friction force", "Reibkraft", "F"), "friction", "N"),
    (("Zeit 2", "zeit", "T", "t_1", "TIME"), "time", "ms"),
])  # fmt: skip
def test_of_several_columns_of_a_unit_that_with_the_word_is_taken(
    tmp_path: Path, words: tuple[str, ...], role: str, unit: str
) -> None:
    for word in words:
        clock = "x [mm]" if role == "time" else "clock [ms]"
        rows = [f"{clock};other [{unit}];{word} [{unit}];third [{unit}]", "0;1;2;3", "1;2;3;4"]
        assert read(tmp_path, rows).headers[role] == f"{word} [{unit}]"


def test_a_column_is_named_as_it_is_written_or_in_other_letters_or_by_its_number(tmp_path: Path) -> None:
    for header, name, found in (
        ("t [s];x [mm];X [mm]", "x [mm]", "x [mm]"), ("t [s];x [mm];X [mm]", "X [mm]", "X [mm]"),
        ("Zeit [s];Weg in mm;n", "WEG", "Weg in mm"), ("t [s];3 [mm];1 [mm]", "3", "3 [mm]"),
    ):  # fmt: skip
        assert of(tmp_path, header, "1;2", displacement=name).headers["displacement"] == found
    header = "clock [ms];left [mm];right (g)"
    record = of(tmp_path, header, "1;2", time="1 [s]", trough_along="3 [m/s^2]", displacement="left [mm]")
    np.testing.assert_array_equal(record.trough["trough_along"], [2.0, 2.0])
    assert record.believed == {"time": "s", "trough_along": "m/s^2"}  # the header alone says nothing new
    assert not of(tmp_path, header, "1;2", trough_along="3").believed


@pytest.mark.parametrize(
    ("header", "role"), [("a [g];b [m/s^2]", "acceleration"), ("a [mm];b [um]", "displacement")]
)
def test_a_column_like_one_of_the_troughs_is_not_taken_for_a_part(
    tmp_path: Path, header: str, role: str
) -> None:
    """It would be the trough, compared with itself; other kinds are taken as ever."""
    assert not of(tmp_path, f"t [s];{header}", "1;2", trough_along="a").signals
    named = of(tmp_path, f"t [s];{header}", "1;2", trough_along="a", **{role: "b"})
    assert set(named.signals) == {role}
    found = of(tmp_path, f"t [s];{header};v [mm/s]", "1;2;3", trough_along="a")
    assert set(found.signals) == {"velocity"}


@each("typed", ["V", "1 [V]", "Laser [V]"])
@each("mark", [".", ","])
def test_a_single_column_needs_no_name(tmp_path: Path, typed: str, mark: str) -> None:
    """Nor a point: a second number between commas would not begin with zeros."""
    path = tmp_path / "data.txt"
    path.write_text("0.50\n-0.25\n0.05\n1.25\n".replace(".", mark), encoding="utf-8")
    volts = read_sensitivities(["1V/g"])
    record = read_record(path, {"trough_along": typed}, volts, body=False, rate="0.01 kHz")
    np.testing.assert_allclose(record.trough["trough_along"] / 9.80665, [0.5, -0.25, 0.05, 1.25])
    np.testing.assert_allclose(record.time, [0.0, 0.1, 0.2, 0.3])


# --- voltages -------------------------------------------------------------------------------------------


@each(("role", "sensitivity", "expected"), [
    ("acceleration", "100mV/g", 9.80665), ("acceleration", "-100 mV/g", -9.80665),
    ("acceleration", "10.2mV/(m/s²)", 1 / 0.102), ("acceleration", "0.1 V per m/s^2", 1.0),
    ("acceleration", "1e2mV/m/s2", 1.0), ("velocity", "20mV/mm/s", 5e-3), ("velocity", "125mm/s/V", 12.5e-3),
    ("velocity", "125 (mm/s)/V", 12.5e-3), ("velocity", "50 mV/[mm/s]", 2e-3),
    ("displacement", "2V/mm", 5e-5), ("displacement", "50 µm/mV", 5e-3),
    ("displacement", "-.5mm/V", -5e-5), ("friction", "50mV/N", 2.0),
    ("friction", "friction=4V pro N", 0.025), ("friction", "+2.V/kN", 50.0),
    ("trough_along", "100mV/g", 9.80665), ("trough_along", "trough-along=2V/mm", 5e-5),
    ("trough_along", "--Trough-Along = 200 mV per g", 4.903325), ("displacement", "1e20V/m", 1e-21),
])  # fmt: skip
def test_voltages_have_the_size_that_their_sensitivity_says(
    tmp_path: Path, role: str, sensitivity: str, expected: float
) -> None:
    content = ["t [s],y [mm],u [mV]", "0,1,100", "1,2,-200", "2,3,300"]
    record = read(tmp_path, content, sensitivity, **{role: "u [mV]"})
    found = {**record.signals, **record.trough}[role]
    np.testing.assert_allclose(found, np.array([1.0, -2.0, 3.0]) * expected)
    assert record.sensitivities[role] == sensitivity


def test_the_sensitivity_of_a_column_goes_before_that_of_its_kind(tmp_path: Path) -> None:
    for texts in (("1V/g", "acceleration=2V/g"), ("acceleration=2V/g", "1V/g")):
        record = of(tmp_path, "t [s];u [V];w [V]", "1;1", *texts, acceleration="u", trough_along="w")
        assert record.signals["acceleration"] == pytest.approx([0.5 * 9.80665] * 2)
        assert record.trough["trough_along"] == pytest.approx([9.80665] * 2)


# --- hints ----------------------------------------------------------------------------------------------


@each(("header", "proposed"), [
    ("Vel along (ips pk)", "Vel along [ips]"), ("Vel along (bananas)", "Vel along [mm/s]"),
    ("Disp. x (counts)", "Disp. x [mm]"), ("ax (gRMS)", "ax [g]"), ("ax", "ax [m/s^2]"),
    ("ax (m per square s)", "ax [m/s^2]"),
])  # fmt: skip
def test_a_hint_proposes_a_unit_of_the_likely_kind_that_works(
    tmp_path: Path, header: str, proposed: str
) -> None:
    with pytest.raises(InputError) as refused:
        of(tmp_path, f"time [s];{header}", "1", trough_along=header)
    assert f'trough_along="{proposed}"' in f"{refused.value.hint}"
    assert "trough_along" in of(tmp_path, f"time [s];{header}", "1", trough_along=proposed).believed


@each(("unit", "frequency"), [("ms", None), ("ms", 25.0), ("us", None), ("ns", None)])
def test_seconds_that_are_a_smaller_unit_are_no_aliasing(
    tmp_path: Path, unit: str, frequency: float | None
) -> None:
    path = tmp_path / "data.csv"
    step = {"ms": 2, "us": 2000, "ns": 2000000}[unit]
    rows = "\n".join(f"{step * i},{20.0 * np.sin(0.1 * np.pi * i + 0.7):.5f}" for i in range(1000))
    path.write_text(f"Time (s),ax (m/s^2)\n{rows}\n", encoding="utf-8")
    call = partial(measured_motion, path, trough_along="ax", drive_angle=0.0, frequency=frequency)
    for typed in (None, "Time [ms]", "Time [min]")[: 1 if unit == "ms" else 3]:
        with pytest.raises(InputError) as refused:
            call(time=typed)
        assert f"{refused.value.hint}" == f'the time may be in {unit}: time="Time [{unit}]"'
    assert call(time=f"Time [{unit}]").frequency == pytest.approx(25.0, rel=1e-6)


def test_hints_for_times_that_are_unknown_or_missing_name_the_sampling_rate(tmp_path: Path) -> None:
    path = tmp_path / "data.csv"
    for cells in (["10.00.59.000", "10.00.59.002"], ["0", ""]):
        rows = "\n".join(f"{cell};{i}" for i, cell in enumerate(cells * 20))
        path.write_text(f"time;ax [g]\n{rows}\n", encoding="utf-8")
        with pytest.raises(InputError, match=r"rate=.HZ"):
            read_record(path, {"time": "time [s]", "trough_along": "ax"}, body=False)
        record = read_record(path, {"trough_along": "ax"}, body=False, rate=500)
        np.testing.assert_allclose(np.diff(record.time), 0.002)
