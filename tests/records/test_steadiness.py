"""Records that are steady, and others, against motions with known truth; frequencies that samples hide."""

from __future__ import annotations

import math
from contextlib import suppress
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from helpers.cases import each
from helpers.unsteady_records import BAD, bad_record, good_record
from numpy.typing import NDArray

from vibro.errors import InputError
from vibro.records.reading import Record
from vibro.records.trough import MeasuredMotion, motion_of

Floats = NDArray[np.float64]
TOLD = ("errors include it", "the steady part")


def told(motion: MeasuredMotion) -> list[str]:
    return [text for text in motion.warnings if any(one in text for one in TOLD)]


def times(seconds: float, rate: float) -> Floats:
    return np.arange(round(seconds * rate) + 1) / rate


def recorded(time: Floats, along: Floats, normal: Floats | None = None, **fields: Any) -> Record:
    """Add the noise of a sensor, 5 mg."""
    random = np.random.default_rng(7)
    trough = {"trough_along": along} | ({} if normal is None else {"trough_normal": normal})
    noisy = {name: values + 0.05 * random.standard_normal(time.size) for name, values in trough.items()}
    headers = {"time": "t (s)", "trough_along": "ax (m/s^2)", "trough_normal": "az (m/s^2)"}
    return Record(time, {}, noisy, headers, **fields)


def one(time: Floats, values: Floats, frequency: float | None = None, **options: Any) -> MeasuredMotion:
    return motion_of(recorded(time, values), drive_angle=0.0, stated=frequency, **options)


def wave(time: Floats, frequency: float = 25.0, size: Any = 25.0) -> Floats:
    return np.asarray(size * np.sin(math.tau * frequency * time))


def amplitude_mm(motion: MeasuredMotion) -> tuple[float, float]:
    value, error = motion.drive_on_line().quantities["amplitude"]
    return 1e3 * value, 1e3 * error


# --- steady, or not -------------------------------------------------------------------------------------


def test_steady_records_are_accepted_with_all_that_sensors_add() -> None:
    for seed in range(36):
        made = good_record(seed)
        motion = motion_of(made.record)
        assert not told(motion), made.kind
        assert amplitude_mm(motion)[0] == pytest.approx(1e3 * made.amplitude, rel=0.05)


@pytest.mark.parametrize("kind", BAD)
def test_records_that_are_not_steady_are_told_or_refused(kind: str) -> None:
    """By half of the amplitude, or some turns of the phase."""
    for seed in range(4):
        made = bad_record(seed + 40, kind)
        with suppress(InputError):  # its words: test_what_is_not_steady_is_named
            assert told(motion_of(made.record)), kind


@each("tau", [0.1, 0.2, 0.5])
def test_of_a_start_the_steady_part_is_taken(tau: float) -> None:
    """The amplitude grows to 1 mm: its mean is 0.975, 0.95, 0.875."""
    time = times(4.0, 500.0)
    size = 1e-3 * (math.tau * 25.0) ** 2
    motion = one(time, wave(time, size=size * (1.0 - np.exp(-time / tau))))
    value, error = amplitude_mm(motion)
    assert abs(value - 1.0) < min(3.0 * error, 0.005)
    assert "rises from" in motion.warnings[0]
    assert "the steady part from" in motion.warnings[0]
    assert motion.start > 2.0 * tau
    assert motion.start + motion.span == pytest.approx(4.0, abs=0.01)
    # the same part, by the user: there is nothing to warn of but what is left
    again = one(time, wave(time, size=size * (1.0 - np.exp(-time / tau))), start=motion.start)
    assert "the steady part" not in "".join(again.warnings)


def test_what_is_not_steady_is_named() -> None:
    time = times(8.0, 500.0)
    there = np.clip((time - 1.0) / 0.4, 0.0, 1.0) * np.clip((6.3 - time) / 0.5, 0.0, 1.0)
    motion = one(time, wave(time, size=25.0 * there))
    assert "rises from" in motion.warnings[0]
    assert "and falls to" in motion.warnings[0]
    assert amplitude_mm(motion)[0] == pytest.approx(25e3 / (math.tau * 25.0) ** 2, rel=0.005)
    refused = {
        r"beats at 0\.4\d? Hz: .* 25 and 25\.4 Hz": wave(time) + wave(time, 25.4, 8.0),
        r"from 24 to 26 Hz": 25.0 * np.sin(math.tau * (24.0 * time + 0.125 * time**2)),
        r"from 0 to 20 Hz": 25.0 * np.sin(math.tau * 1.25 * time**2),
        r"24\.9\d+ to 25\.0\d+ Hz": 25.0 * np.sin(math.tau * (24.95 * time + 0.00625 * time**2)),
        r"falls from 1\.1\d to 0\.8\d+ mm": wave(time, size=25.0 * (1.1 - 0.25 * time / 8.0)),
    }
    late = wave(time, size=25.0 * (time > 6.0))
    with pytest.raises(InputError, match="25 Hz stands out from 6 to 8 s alone"):
        one(time, late)
    assert one(time, late, 25.0).start == pytest.approx(6.0, abs=0.4)
    assert amplitude_mm(one(time, late, start=6.01))[0] == pytest.approx(1.013, rel=1e-3)
    for text, values in refused.items():
        with pytest.raises(InputError, match=text):
            one(time, values)
        with pytest.raises(InputError, match=text):
            one(time, values, 25.0)


def test_reasons_are_the_right_ones() -> None:
    """What goes to and fro neither rises nor falls, and a slow rise in a clean record is no wave alone."""
    time = times(4.0, 500.0)
    turns = 25.0 * time + 0.1 * np.cos(math.tau * 0.75 * time)
    refused = {
        r"rises from 0\.08\d+ to 0\.98\d* mm": (time, wave(time, size=24.674 * (1.0 - np.exp(-time)))),
        r"varies between 0\.9\d+ and 1\.0\d+ mm": (
            time, wave(time, size=24.674 * (1.0 + 0.1 * np.sin(math.tau * 2.0 * time))),
        ),
        r"frequency changes, between 24\.\d+ and 25\.\d+ Hz": (time, 25.0 * np.sin(math.tau * turns)),
    }  # fmt: skip
    few = times(0.24, 500.0)  # six cycles
    refused["rises from"] = few, wave(few, size=24.674 * (1.0 - np.exp(-few / 0.07)))
    many = times(10.0, 201.0)  # harmonic 5 is shown beside the first
    folds = wave(many, 50.0) + wave(many, 250.0, 7.5)
    refused["201 samples a second show harmonic 5 at 49 Hz: sample at another rate"] = many, folds
    for text, (at, values) in refused.items():
        with pytest.raises(InputError, match=text):
            one(at, values)
    mains = times(10.0, 60.0)
    with pytest.raises(InputError, match="60 Hz is too near to a multiple of 60 samples a second"):
        one(mains, wave(mains, 60.0), 60.0)
    slower = times(10.0, 119.9)
    with pytest.raises(InputError, match="no wave stands out") as error:
        one(slower, wave(slower, 60.0))
    assert "above 57.1 Hz must be given" in str(error.value.hint)


def test_errors_include_a_small_drift() -> None:
    """Of 3.8 %, 33 standard errors: its root mean square is 1.1 %."""
    time = times(8.0, 500.0)
    motion = one(time, wave(time, size=25.0 * (1.0 - 0.038 * time / 8.0)))
    value, error = amplitude_mm(motion)
    assert error / value == pytest.approx(0.011, rel=0.05)
    assert "falls from" in motion.warnings[0]
    assert "errors include it" in motion.warnings[0]
    drawn = motion.drawn(4000).along[0]
    assert np.std(abs(drawn)) / value == pytest.approx(0.011e-3, rel=0.1)
    steady = one(time, wave(time))
    assert not steady.warnings
    assert amplitude_mm(steady)[1] < 0.1 * error


# --- frequencies that are given, or hidden --------------------------------------------------------------


@each(("rate", "frequency"), [(101.14, 100.0), (98.3, 100.0), (52.0, 50.0), (73.0, 50.0), (411.57, 100.0)])
@each("lead_deg", [-60.0, 120.0])
def test_a_drive_above_half_the_sampling_rate_is_measured_where_it_is_given(
    rate: float, frequency: float, lead_deg: float
) -> None:
    """Samples show it turned round where they show it below a multiple of their rate."""
    time = times(10.0, rate) + 3.3
    along, normal = (-math.tau * math.tau * frequency**2 * 2e-5 * x for x in (1.0, 0.6))
    turn = math.tau * frequency * time
    record = recorded(time, along * np.sin(turn), normal * np.sin(turn + math.radians(lead_deg)))
    motion = motion_of(record, stated=1.01 * frequency if rate > 400.0 else frequency)
    found = motion.drive_on_ellipse().quantities
    assert found["frequency"].value == pytest.approx(frequency, rel=1e-5)
    assert found["along_amplitude"].value == pytest.approx(2e-5, rel=0.01)
    assert found["normal_amplitude"].value == pytest.approx(1.2e-5, rel=0.01)
    assert math.degrees(found["normal_phase"].value) == pytest.approx(lead_deg, abs=0.6)
    assert ("aliasing" in "".join(motion.warnings)) == (rate < 200.0)
    assert "the first harmonic alone" in "".join(motion.notes)


def test_a_frequency_that_is_given_must_be_that_of_the_record() -> None:
    """Motors slip; another machine may shake more; half the frequency is that of the motion."""
    time = times(10.0, 500.0)
    assert one(time, wave(time, 24.3), 25.0).frequency == pytest.approx(24.3, rel=1e-4)
    shaken = one(time, wave(time, 24.3) + wave(time, 36.1, 50.0), 25.0)
    assert shaken.frequency == pytest.approx(24.3, rel=1e-3)
    assert shaken.warnings
    for given, moves in ((50.0, 100.0), (100.0, 25.0), (25.0, 28.0), (25.0, 22.0)):
        with pytest.raises(InputError, match=f"moves at {moves:g} Hz, the drive is given as {given:g} Hz"):
            one(time, wave(time, moves), given)
    with pytest.raises(InputError, match="moves at 25 Hz"):
        one(time, wave(time, 50.0) + wave(time, 25.0, 10.0), 50.0)
    with pytest.raises(InputError, match="no wave of 25 Hz stands out"):
        one(time, 0.0 * time, 25.0)


def test_drives_that_would_look_the_same_are_named() -> None:
    time = times(10.0, 52.0)
    slow = one(time, wave(time, 50.0, 4.0))
    assert slow.frequency == pytest.approx(2.0, rel=1e-4)
    assert "at 52 samples a second drives of 50 Hz (0.04 mm), 54 Hz" in slow.warnings[0]
    time = times(10.0, 208.0)
    quick = one(time, wave(time, 60.0))  # 3.5 samples a cycle
    assert amplitude_mm(quick)[0] == pytest.approx(25e3 / (math.tau * 60.0) ** 2, rel=1e-3)
    assert "drives of 148 Hz" in quick.notes[-1]
    assert not quick.warnings
    assert not any("look the same" in text for text in one(time, wave(time, 60.0), 60.0).notes)
    time = times(10.0, 250.0)
    assert not any("look the same" in text for text in one(time, wave(time)).notes)


# --- scale ----------------------------------------------------------------------------------------------


@each(
    ("slower", "larger", "text", "remedy"),
    [
        (1e3, 1.0, "160 m/s, 1000 m at 0.025 Hz", "t [ms]"),
        (1e-3, 1.0, "at 25000 Hz", "t [s]"),
        (1.0, 19.0, None, ""),
        (1.0, 20.0, "51 g at 25 Hz", "ax [mm/s^2]"),
        (5.0, 3.9, None, ""),
        (5.0, 4.1, "0.1 m at 5 Hz", "ax [mm/s^2]"),
    ],
)
def test_motions_that_nothing_makes_are_refused_unless_the_unit_is_given(
    slower: float, larger: float, text: str | None, remedy: str
) -> None:
    time = times(10.0, 500.0)
    record = recorded(slower * time, wave(time, size=25.0 * larger))
    if text is None:
        assert not motion_of(record, drive_angle=0.0).notes
        return
    with pytest.raises(InputError) as caught:
        motion_of(record, drive_angle=0.0)
    assert text in str(caught.value)
    assert remedy in str(caught.value.hint)
    believed = replace(record, believed={"time": "s", "trough_along": "g"})
    assert "as its unit is given" in "".join(motion_of(believed, drive_angle=0.0).notes)
