"""Units of signals, however programs spell them, and what voltages of sensors stand for."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from helpers.cases import each

from vibro.errors import InputError
from vibro.records.reading import Record, read_record, read_sensitivities, rounded, signal_unit


@each(
    ("texts", "kind", "size"),
    [
        ("s sec second seconds", "time", 1.0),
        ("ms", "time", 1e-3),
        ("us \u00b5s", "time", 1e-6),
        ("min", "time", 60.0),
        ("m", "displacement", 1.0),
        ("cm", "displacement", 1e-2),
        ("mm MM", "displacement", 1e-3),
        ("um \u03bcm", "displacement", 1e-6),
        ("in", "displacement", 0.0254),
        ("m/s", "velocity", 1.0),
        ("cm/s", "velocity", 1e-2),
        ("mm/sec mm_s", "velocity", 1e-3),
        ("um_s", "velocity", 1e-6),
        ("in/s in_s", "velocity", 0.0254),
        ("m_s2 m/second**2", "acceleration", 1.0),
        ("cm/s^2", "acceleration", 1e-2),
        ("mm/sec**2 mm/s\u00b2", "acceleration", 1e-3),
        ("in_s2 in/s\u00b2", "acceleration", 0.0254),
        ("g", "acceleration", 9.80665),
        ("N newton newtons", "force", 1.0),
        ("mN", "force", 1e-3),
        ("kN", "force", 1e3),
        ("V Volt volts", "voltage", 1.0),
        ("mV", "voltage", 1e-3),
    ],
)
def test_spellings_of_units(texts: str, kind: str, size: float) -> None:
    for text in texts.split():
        found = signal_unit(text)
        assert found is not None
        assert found[0] == kind
        assert found[1] == pytest.approx(size, rel=1e-15)


@each("text", ["", "deg", "1/s", "furlong", "v"])
def test_what_is_no_unit(text: str) -> None:
    assert signal_unit(text) is None


# --- voltages ----------------------------------------------------------------------------------------


def volts(folder: Path, content: list[str], *texts: str, **columns: str) -> Record:
    path = folder / "data.csv"
    path.write_text("\n".join(content) + "\n", encoding="utf-8")
    return read_record(path, columns, read_sensitivities(texts))


@each(
    ("role", "sensitivity", "expected"),
    [
        ("acceleration", "100mV/g", 9.80665),
        ("acceleration", "-100 mV/g", -9.80665),
        ("acceleration", "10.2mV/(m/s²)", 1 / 0.102),
        ("acceleration", "0.1 V per m/s^2", 1.0),
        ("acceleration", "1e2mV/m/s2", 1.0),
        ("velocity", "20mV/mm/s", 5e-3),
        ("velocity", "125mm/s/V", 12.5e-3),
        ("velocity", "125 (mm/s)/V", 12.5e-3),
        ("displacement", "2V/mm", 5e-5),
        ("displacement", "50 µm/mV", 5e-3),
        ("displacement", "-0.5mm/V", -5e-5),
        ("friction", "50mV/N", 2.0),
        ("trough_along", "100mV/g", 9.80665),
        ("trough_along", "trough-along=0.2V/g", 4.903325),
        ("trough_along", "trough-along=2V/mm", 5e-5),
    ],
)
def test_voltages_have_the_size_that_their_sensitivity_says(
    tmp_path: Path, role: str, sensitivity: str, expected: float
) -> None:
    content = ["t [s],x [mm],u [mV]", "0,1,100", "1,2,-200", "2,3,300"]
    columns = {"displacement": "x"} | {role: "u [mV]"}
    record = volts(tmp_path, content, sensitivity, **columns)
    np.testing.assert_allclose(
        {**record.signals, **record.trough}[role], np.array([1.0, -2.0, 3.0]) * expected
    )
    assert record.sensitivities[role] == sensitivity


def test_each_voltage_has_its_own_sensitivity(tmp_path: Path) -> None:
    content = ["t [s],a [V],b [mV],c [mV],v [V]", "0,1,100,100,1", "1,2,200,200,2", "2,3,300,300,3"]
    record = volts(
        tmp_path, content, "100mV/g", "trough-normal=-200mV/g", "2m/s/V",
        acceleration="a", trough_along="b", trough_normal="c", velocity="v",
    )  # fmt: skip
    assert record.signals["acceleration"][0] == pytest.approx(98.0665)
    assert record.trough["trough_along"][0] == pytest.approx(9.80665)
    assert record.trough["trough_normal"][0] == pytest.approx(-4.903325)
    assert record.signals["velocity"][0] == 2.0


@each(
    ("ratio", "text"),
    [(1234.0, "1200"), (0.01256, "0.013"), (9.96, "10"), (1e5, "100000"), (7.04, "7"), (-12.4, "-12")],
)
def test_a_ratio_is_written_with_two_digits(ratio: float, text: str) -> None:
    assert rounded(ratio) == text


@each("text", ["1e20m/V", "-1e20m/V", "1e20V/m", "-1e20 V/m"])
def test_sensitivities_reach_to_the_ends_of_what_can_be_computed_with(text: str) -> None:
    (one,) = read_sensitivities([text])
    assert abs(one.per_volt) == pytest.approx(1e20 if text.endswith("m/V") else 1e-20, rel=1e-15)
    with pytest.raises(InputError, match=r"1\.001e20"):
        read_sensitivities([text.replace("1e20", "1.001e20")])


@each(
    ("text", "role", "kind", "per_volt"),
    [
        ("trough-along=200mV/g", "trough_along", "acceleration", 5.0 * 9.80665),
        (" --Trough-Along = 200 mV per g ", "trough_along", "acceleration", 5.0 * 9.80665),
        ("friction=4V pro N", "friction", "force", 0.25),
        ("50 mV/[mm/s]", "", "velocity", 0.02),
        (".5mm/V", "", "displacement", 5e-4),
        ("+2.V/kN", "", "force", 500.0),
    ],
)
def test_spellings_of_sensitivities(text: str, role: str, kind: str, per_volt: float) -> None:
    (one,) = read_sensitivities([text])
    assert one[:3] == (text.strip(), role, kind)
    assert one.per_volt == pytest.approx(per_volt, rel=1e-12)
