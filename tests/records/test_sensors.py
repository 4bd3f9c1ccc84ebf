"""Errors of sensors: how they are read, and what is refused."""

from __future__ import annotations

import math
import re

import numpy as np
import pytest

from vibro.errors import InputError
from vibro.records.sensors import SensorErrors, read_sensor_errors


def test_errors_are_read_with_their_units_and_the_others_are_usual() -> None:
    read = read_sensor_errors(" tilt=0.2deg, gain=1%,cross=0.02,lowpass=100Hz,offset=5mg,delay=0.02ms,")
    assert read.tilt == pytest.approx(math.radians(0.2))
    assert (read.gain, read.cross, read.lowpass) == (0.01, 0.02, 100.0)
    assert read.offset == pytest.approx(5e-3 * 9.80665)
    assert read.delay == pytest.approx(20e-6)
    assert (read.angle, read.amplitude) == (SensorErrors().angle, SensorErrors().amplitude)
    assert read.stated == {"tilt", "gain", "cross", "lowpass", "offset", "delay"}
    assert read_sensor_errors("") == SensorErrors()


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("tlt=1deg", "'tlt' is no error of a sensor.*did you mean 'tilt'"),
        ("gain", "no value.*known are tilt, gain"),
        ("gain=1%,gain=2%", "gain is given twice"),
        ("gain=1", r"sensor gain = 1: must be in \[0, 0.5\)"),
        ("tilt=45deg", r"sensor tilt = 45deg: must be in \[0, 30\) deg"),
        ("tilt=1mm", "'mm' is no unit of sensor tilt"),
        ("lowpass=0", "sensor lowpass = 0: must be"),
        ("cross=nan", "must be a finite number"),
    ],
)
def test_what_is_wrong_is_named(text: str, message: str) -> None:
    with pytest.raises(InputError) as caught:
        read_sensor_errors(text)

    assert re.search(message, f"{caught.value} {caught.value.hint}", re.DOTALL)


def test_the_filter_halves_the_power_at_its_corner() -> None:
    response = read_sensor_errors("lowpass=40Hz").response(np.array([0.0, 40.0, 4000.0]))
    np.testing.assert_allclose(np.abs(response) ** 2, [1.0, 0.5, 1.0 / 10001.0])
    assert math.degrees(float(np.angle(response[1]))) == pytest.approx(-45.0)
    assert (SensorErrors().response(np.array([50.0])) == 1.0).all()
