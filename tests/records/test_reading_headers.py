"""Which columns of a table are the signals, by name, unit and word."""

from __future__ import annotations

from functools import partial
from pathlib import Path

import numpy as np
import pytest
from helpers.cases import each

from vibro import measured_motion
from vibro.errors import InputError
from vibro.records.reading import Record, read_record, read_sensitivities


def read(folder: Path, header: str, row: str, *sensitivities: str, **columns: str) -> Record:
    """Read a table of two rows, the cells of ``row`` behind the times 0 and 1."""
    path = folder / "data.csv"
    path.write_text(f"{header}\n0;{row}\n1;{row}\n", encoding="utf-8")
    return read_record(path, columns, read_sensitivities(sensitivities))


# --- rows of units ------------------------------------------------------------------------------------


@each("units", ["[s];[mm];", "(s);(mm);", "s;mm;", "s;(mm);[]"])
def test_a_row_of_units_may_leave_some_out(tmp_path: Path, units: str) -> None:
    record = read(tmp_path, f"Time;X;Y\n{units}", "1;5")
    assert record.headers == {"time": "Time [s]", "displacement": "X [mm]"}
    np.testing.assert_allclose(record.signals["displacement"], 1e-3)


# --- names and units ----------------------------------------------------------------------------------


@each(
    ("header", "signal", "expected"),
    [
        ("speed_in_s", "velocity", 0.0254),
        ("speed_m_s", "velocity", 1.0),
        ("speed_um_s", "velocity", 1e-6),
        ("pull_in_s2", "acceleration", 0.0254),
        ("position_in", "displacement", 0.0254),
        ("pull_kN", "friction", 1e3),
    ],
)
def test_names_that_end_in_a_unit(tmp_path: Path, header: str, signal: str, expected: float) -> None:
    record = read(tmp_path, f"time_s;{header}", "1")
    assert record.headers == {"time": "time_s", signal: header}
    assert record.signals[signal][0] == pytest.approx(expected, rel=1e-15)


@each(
    ("header", "name", "signal", "sensitivity", "expected"),
    [
        ("a/mV", "a", "acceleration", "2mV/m/s2", 0.5),
        ("Laser/V", "Laser", "displacement", "2V/mm", 5e-4),
        ("x / V", "x", "displacement", "4mm/V", 4e-3),
    ],
)
def test_a_signal_over_a_unit_of_voltages(
    tmp_path: Path, header: str, name: str, signal: str, sensitivity: str, expected: float
) -> None:
    record = read(tmp_path, f"t/s;{header}", "1", sensitivity, **{signal: name})
    assert record.headers[signal] == header
    assert record.signals[signal] == pytest.approx([expected] * 2)


@each(
    ("words", "role", "unit"),
    [
        (("Position", "Weg_2", "Relative x", "xi", "s", "X2"), "displacement", "mm"),
        (("Speed", "Velocity", "Geschwindigkeit", "relative_", "v", "vx_1"), "velocity", "m/s"),
        (("Acceleration", "Beschleunigung", "relative a", "ax", "A"), "acceleration", "g"),
        (("Friction", "Friction force", "Reibkraft", "F"), "friction", "N"),
    ],
)
def test_of_several_columns_of_a_unit_that_with_the_word_is_taken(
    tmp_path: Path, words: tuple[str, ...], role: str, unit: str
) -> None:
    for word in words:
        record = read(tmp_path, f"clock [ms];other [{unit}];{word} [{unit}];third [{unit}]", "1;2;3")
        assert record.headers[role] == f"{word} [{unit}]"


@each("word", ["Zeit 2", "zeit", "T", "t_1", "TIME"])
def test_of_several_clocks_that_with_the_word_is_taken(tmp_path: Path, word: str) -> None:
    path = tmp_path / "data.csv"
    path.write_text(f"trigger [s],{word} [ms],x [mm]\n7,1,5\n7,2,6\n", encoding="utf-8")
    np.testing.assert_allclose(read_record(path).time, [1e-3, 2e-3])


def test_a_header_as_it_is_written_goes_before_one_in_other_letters(tmp_path: Path) -> None:
    header = "t [s];x [mm];X [mm]"
    for name, row in (("x [mm]", 1), ("X [mm]", 2)):
        record = read(tmp_path, header, "1;2", displacement=name)
        assert record.headers["displacement"] == name
        assert record.signals["displacement"] == pytest.approx([1e-3 * row] * 2)


def test_letters_of_either_case_name_a_column(tmp_path: Path) -> None:
    for name in ("WEG IN MM", "weg", "WEG"):
        assert read(tmp_path, "Zeit [s];Weg in mm", "1", displacement=name).headers["displacement"] == (
            "Weg in mm"
        )


@pytest.mark.parametrize(
    ("header", "role"), [("a [g];b [m/s^2]", "acceleration"), ("a [mm];b [um]", "displacement")]
)
def test_a_column_like_one_of_the_troughs_is_not_taken_for_a_part(
    tmp_path: Path, header: str, role: str
) -> None:
    """It would be the trough, compared with itself; other kinds are taken as ever."""
    assert not read(tmp_path, f"t [s];{header}", "1;2", trough_along="a").signals
    named = read(tmp_path, f"t [s];{header}", "1;2", trough_along="a", **{role: "b"})
    assert set(named.signals) == {role}
    found = read(tmp_path, f"t [s];{header};v [mm/s]", "1;2;3", trough_along="a")
    assert set(found.signals) == {"velocity"}


@each("unit", ["mm", "mm/s", "m/s^2"])
def test_the_troughs_motion_may_have_any_kind(tmp_path: Path, unit: str) -> None:
    record = read(tmp_path, f"t [s];a [{unit}];x [N]", "1;2", trough_along="a")
    assert record.trough_derivatives == {"trough_along": ["m/s^2", "mm/s", "mm"].index(unit)}


# --- voltages -----------------------------------------------------------------------------------------


def test_the_sensitivity_of_a_column_goes_before_that_of_its_kind(tmp_path: Path) -> None:
    for texts in (("1V/g", "acceleration=2V/g"), ("acceleration=2V/g", "1V/g")):
        header = "t [s];u [V];w [V]"
        record = read(tmp_path, header, "1;1", *texts, acceleration="u", trough_along="w")
        assert record.signals["acceleration"] == pytest.approx([0.5 * 9.80665] * 2)
        assert record.trough["trough_along"] == pytest.approx([9.80665] * 2)
        assert record.sensitivities == {"acceleration": "acceleration=2V/g", "trough_along": "1V/g"}


@pytest.mark.parametrize("header", ["m / s", "mm / sec"])
def test_a_unit_alone_is_no_time(tmp_path: Path, header: str) -> None:
    record = read(tmp_path, f"clock [s];x [mm];{header}", "1;2")
    assert record.headers == {"time": "clock [s]", "displacement": "x [mm]"}


# --- columns by number, with a unit of their own, and sampling rates -----------------------------------


def test_a_column_by_number_with_a_unit_is_believed(tmp_path: Path) -> None:
    header = "clock [ms];left [mm];right (g)"
    record = read(tmp_path, header, "1;2", time="1 [s]", trough_along="3 [m/s^2]", displacement="left [mm]")
    np.testing.assert_array_equal(record.time, [0.0, 1.0])
    np.testing.assert_array_equal(record.trough["trough_along"], [2.0, 2.0])
    assert record.believed == {"time": "s", "trough_along": "m/s^2"}  # the header alone says nothing new
    assert read(tmp_path, header, "1;2", trough_along="RIGHT [m/s^2]").believed == {"trough_along": "m/s^2"}
    assert not read(tmp_path, header, "1;2", trough_along="3").believed


def test_a_header_that_is_a_number_goes_before_the_number_of_a_column(tmp_path: Path) -> None:
    record = read(tmp_path, "t [s];3 [mm];1 [mm]", "5;7", displacement="3")
    assert record.headers["displacement"] == "3 [mm]"


@each("rate", [250.0, "250", "0.25 kHz"])
def test_a_rate_stands_for_a_column_of_time(tmp_path: Path, rate: float | str) -> None:
    path = tmp_path / "data.csv"
    path.write_text("n,x [mm]\n1,7\n2,8\n3,9\n", encoding="utf-8")
    record = read_record(path, {"displacement": "x"}, rate=rate)
    np.testing.assert_allclose(record.time, [0.0, 0.004, 0.008], rtol=1e-15)


@each("typed", ["V", "1 [V]", "Laser [V]"])
@each("mark", [".", ","])
def test_a_single_column_needs_no_name(tmp_path: Path, typed: str, mark: str) -> None:
    """Nor a point: a second number between commas would not begin with zeros."""
    path = tmp_path / "data.txt"
    path.write_text("0.50\n-0.25\n0.05\n1.25\n".replace(".", mark), encoding="utf-8")
    volts = read_sensitivities(["1V/g"])
    record = read_record(path, {"trough_along": typed}, volts, body=False, rate=10.0)
    np.testing.assert_allclose(record.trough["trough_along"] / 9.80665, [0.5, -0.25, 0.05, 1.25])
    np.testing.assert_allclose(record.time, [0.0, 0.1, 0.2, 0.3])


def test_a_third_axis_of_the_trough(tmp_path: Path) -> None:
    record = read(tmp_path, "t [s];a [g];b [g]", "1;2", trough_along="a", trough_across="b")
    np.testing.assert_allclose(record.trough["trough_across"], [2 * 9.80665] * 2)


# --- hints --------------------------------------------------------------------------------------------


@each(
    ("header", "proposed"),
    [
        ("Vel along (ips pk)", "Vel along [ips]"),
        ("Vel along (bananas)", "Vel along [mm/s]"),
        ("Disp. x (counts)", "Disp. x [mm]"),
        ("ax (gRMS)", "ax [g]"),
        ("ax (m per square s)", "ax [m/s^2]"),
        ("ax", "ax [m/s^2]"),
    ],
)
def test_a_hint_proposes_a_unit_of_the_likely_kind_that_works(
    tmp_path: Path, header: str, proposed: str
) -> None:
    with pytest.raises(InputError) as refused:
        read(tmp_path, f"time [s];{header}", "1", trough_along=header)
    assert f'trough_along="{proposed}"' in f"{refused.value.hint}"
    record = read(tmp_path, f"time [s];{header}", "1", trough_along=proposed)
    assert "trough_along" in record.believed


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
