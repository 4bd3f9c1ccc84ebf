"""Which columns of a table are the signals, by name, unit and word; what is said of none or several."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from helpers.cases import each
from helpers.made_tables import refusal

from vibro.errors import InputError
from vibro.records.headers import TroughAloneError
from vibro.records.reading import Record, read_record
from vibro.records.signals import read_sensitivities


def read(folder: Path, header: str, row: str, *sensitivities: str, **columns: str) -> Record:
    """Read a table of two rows, the cells of ``row`` behind the times 0 and 1."""
    path = folder / "data.csv"
    path.write_text(f"{header}\n0;{row}\n1;{row}\n", encoding="utf-8")
    return read_record(path, columns, read_sensitivities(sensitivities))


def told(folder: Path, header: str, row: str, *sensitivities: str, **columns: str) -> InputError:
    with pytest.raises(InputError) as caught:
        read(folder, header, row, *sensitivities, **columns)
    return caught.value


# --- rows of units ------------------------------------------------------------------------------------


@each("units", ["[s];[mm];", "(s);(mm);", "s;mm;", "s;(mm);[]"])
def test_a_row_of_units_may_leave_some_out(tmp_path: Path, units: str) -> None:
    record = read(tmp_path, f"Time;X;Y\n{units}", "1;5")
    assert record.headers == {"time": "Time [s]", "displacement": "X [mm]"}
    np.testing.assert_allclose(record.signals["displacement"], 1e-3)
    error = told(tmp_path, f"Time;X;Y\n{units}", "1;5", velocity="Y")
    assert "column 'Y' for velocity=: it has no unit" in str(error)


def test_a_row_of_units_of_another_width_is_none(tmp_path: Path) -> None:
    """The row above it is a title then, and the units alone are the headers."""
    assert "no column of time found among 's', 'mm'" in str(told(tmp_path, "Study;of;a;nut\ns;mm", "1"))


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


def test_a_word_that_only_begins_like_one_does_not_decide(tmp_path: Path) -> None:
    error = told(tmp_path, "t [s];xylem [mm];weggang [mm]", "1;2")
    assert str(error).endswith(": 'xylem [mm]', 'weggang [mm]' could each be the displacement")
    assert (
        error.hint == 'choose: displacement="xylem [mm]" of a part, trough_along="xylem [mm]" of the trough'
    )


def test_a_header_as_it_is_written_goes_before_one_in_other_letters(tmp_path: Path) -> None:
    header = "t [s];x [mm];X [mm]"
    for name, row in (("x [mm]", 1), ("X [mm]", 2)):
        record = read(tmp_path, header, "1;2", displacement=name)
        assert record.headers["displacement"] == name
        assert record.signals["displacement"] == pytest.approx([1e-3 * row] * 2)
    error = told(tmp_path, header, "1;2", displacement="x")
    assert str(error).endswith(": 2 columns are called 'x'")
    assert error.hint == "give them different names in the file"


def test_letters_of_either_case_name_a_column(tmp_path: Path) -> None:
    for name in ("WEG IN MM", "weg", "WEG"):
        assert read(tmp_path, "Zeit [s];Weg in mm", "1", displacement=name).headers["displacement"] == (
            "Weg in mm"
        )


def test_the_unit_of_the_header_is_not_changed_by_the_option(tmp_path: Path) -> None:
    error = told(tmp_path, "t [s];X [mm]", "1", displacement="X [m]")
    assert str(error).endswith("no column 'X [m]' for displacement=; its columns are 't [s]', 'X [mm]'")
    assert error.hint == "did you mean 'X [mm]'?"
    error = told(tmp_path, "t [s];X [mm]", "1", displacement="Auslenkung")
    assert error.hint == "write it as the header row does"


def test_a_wrong_unit_is_told_with_those_that_would_do(tmp_path: Path) -> None:
    units = "mm/s, um/s, µm/s, cm/s, m/s, in/s, ft/s, mm/min, m/min, in/min, ft/min"
    for header, given, problem in (
        ("X [mm]", "X [mm]", "'mm' is no unit of velocity"),
        ("X", "X [mm]", "'mm' is no unit of velocity"),
        ("X [mm]", "X", "'mm' is no unit of velocity"),
        ("X", "X", "it has no unit"),
    ):
        error = told(tmp_path, f"t [s];{header}", "1", velocity=given)
        assert str(error).endswith(f"data.csv: column {header!r} for velocity=: {problem}")
        begin, end = error.hint.split("; units of velocity are ")
        assert begin == 'write the unit in brackets: velocity="X [mm/s]"'
        listed, voltage = end.split(", or ")
        assert set(listed.split(", ")) >= set(units.split(", ")) - {"µm/s"}
        assert voltage == 'mV and V with sensitivity="20mV/mm/s"'
    error = told(tmp_path, "t [mm];X [mm]", "1", time="t")
    assert error.hint == 'write the unit in brackets: time="t [s]"; units of time are s, ms, us, µs, min'


def test_everything_that_is_wrong_is_told_at_once(tmp_path: Path) -> None:
    error = told(tmp_path, "t [s];X [mm];F [N]", "1;2", velocity="V", friction="X", acceleration="A")
    path = tmp_path / "data.csv"
    assert [text.removeprefix(f"{path}: ").split(";")[0] for text in error.problems] == [
        "no column 'V' for velocity=",
        "no column 'A' for acceleration=",
        "column 'X [mm]' for friction=: 'mm' is no unit of force",
    ]
    assert error.hint.count("\n") == 1
    assert error.hint.startswith("write it as the header row does\nwrite the unit in brackets: friction=")


def test_two_columns_of_one_name_are_two_columns(tmp_path: Path) -> None:
    header = "t [s];u [mm];u [mm]"
    assert "2 columns are called 'u [mm]'" in str(told(tmp_path, header, "1;2", displacement="u [mm]"))


def test_time_and_no_signal_beside_the_troughs(tmp_path: Path) -> None:
    error = told(tmp_path, "t [s];n", "1")
    assert str(error).endswith("data.csv: no signal found among 't [s]', 'n'")
    assert error.hint == 'name one, with its unit: displacement="X [mm]"'
    error = told(tmp_path, "t [s];a [g]", "1", trough_normal="a")
    assert isinstance(error, TroughAloneError)
    assert str(error).endswith("data.csv: 'a [g]': motions of the trough alone, no part to compare")
    assert error.hint == 'to compare a part, name its signal: displacement="X [mm]"'


@pytest.mark.parametrize(
    ("header", "role", "other"),
    [("a [g];b [m/s^2]", "acceleration", "b [m/s^2]"), ("a [mm];b [um]", "displacement", "b [um]")],
)
def test_a_column_like_one_of_the_troughs_is_not_taken_for_a_part(
    tmp_path: Path, header: str, role: str, other: str
) -> None:
    """It would be the trough, compared with itself; other kinds are taken as ever."""
    error = told(tmp_path, f"t [s];{header}", "1;2", trough_along="a")
    assert isinstance(error, TroughAloneError)
    choice = f'{role}="{other}" of a part, or trough_normal="{other}" of the trough'
    assert error.hint == f"say what column '{other}' is: {choice}"
    named = read(tmp_path, f"t [s];{header}", "1;2", trough_along="a", **{role: "b"})
    assert set(named.signals) == {role}
    found = read(tmp_path, f"t [s];{header};v [mm/s]", "1;2;3", trough_along="a")
    assert set(found.signals) == {"velocity"}


@each("unit", ["mm", "mm/s", "m/s^2"])
def test_the_troughs_motion_may_have_any_kind(tmp_path: Path, unit: str) -> None:
    record = read(tmp_path, f"t [s];a [{unit}];x [N]", "1;2", trough_along="a")
    assert record.trough_derivatives == {"trough_along": ["m/s^2", "mm/s", "mm"].index(unit)}


@each("count", [11, 12, 13, 14])
def test_twelve_headers_are_named_and_more_of_them_counted(tmp_path: Path, count: int) -> None:
    """Columns without a header are none of them."""
    names = [f"c{i}" for i in range(count)]
    error = refusal(tmp_path, [",".join([*names, ""]), ",".join("1" * (count + 1))])
    more = f" and {count - 12} more" if count > 12 else ""
    assert str(error).endswith(f": no column of time found among {', '.join(map(repr, names[:12]))}{more}")


# --- voltages -----------------------------------------------------------------------------------------


@each(
    ("header", "role", "example"),
    [
        ("Weg [V]", "displacement", "2V/mm"),
        ("v [mV]", "velocity", "20mV/mm/s"),
        ("Friction [V]", "friction", "50mV/N"),
        ("a [V]", "acceleration", "100mV/g"),
        ("channel [V]", "acceleration", "100mV/g"),
    ],
)
def test_a_voltage_without_a_signal_is_pointed_at_by_its_word(
    tmp_path: Path, header: str, role: str, example: str
) -> None:
    error = told(tmp_path, f"t [s];{header}", "1")
    named = f'{role}="{header}"'
    what = "name one, and the sensitivity of its sensor"
    assert error.hint == f'{what}: {named} sensitivity="{example}"'
    assert told(tmp_path, f"t [s];{header}", "1", example).hint == f"name the voltage: {named}"


def test_a_sensitivity_without_a_voltage_points_at_one_that_is_free(tmp_path: Path) -> None:
    header, row = "t [s];u [V];w [V]", "1;2"
    error = told(tmp_path, header, row, "2V/mm", "100mV/g", displacement="u")
    assert str(error).endswith(
        'data.csv: no column that is read as acceleration is a voltage for sensitivity="100mV/g"'
    )
    assert error.hint == 'name the column: acceleration="w [V]"'


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
