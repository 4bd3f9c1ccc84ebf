"""At which frequency data repeat: named where it is clearly not that of the drive, and never else."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from helpers.cases import each
from helpers.made_records import FREQUENCY, Walked, nut

from vibro.motion.histories import simulate
from vibro.records.alignment import Foreign, Observation, foreign_frequency

SIGNALS = ("displacement", "velocity", "acceleration", "friction")


def seen(observation: Observation, factor: float = 1.0) -> Foreign | None:
    """Ask of a record beside a drive whose frequency is the true one times a factor."""
    return foreign_frequency(
        Observation(observation.time, observation.signals, observation.frequency * factor)
    )


def noisy(scene: Any, signal: str, cycles: float, samples: int, level: float, seed: int) -> Observation:
    """Sample a signal of a scene, with normal noise of a level relative to its range, and an offset."""
    frequency = float(scene.frequency)
    time = 0.3 + np.arange(round(cycles * samples) + 1) / (samples * frequency)
    exact = getattr(Walked(scene), signal)(time)
    span = float(np.ptp(exact - np.polyval(np.polyfit(time, exact, 1), time)))
    random = np.random.default_rng(seed)
    return Observation(
        time, {signal: exact + span * (0.5 + level * random.standard_normal(time.size))}, frequency
    )


SCENES = {
    "F_": nut(),
    "F_B": nut(1.5),
    "FB": nut(2.0),
    "climbing": nut(2.0, trough_angle=math.radians(4.0)),
    "a magnet": nut(0.1, frequency=50.0),
}


@each("name", SCENES)
@each("signal", SIGNALS)
def test_no_other_frequency_is_claimed_of_data_that_repeat_with_the_drive(name: str, signal: str) -> None:
    """Also of records that are short, coarse and noisy, of which no frequency could be told sharply."""
    claims = []
    turn = SIGNALS.index(signal)
    for seed, cycles in enumerate((2.0, 2.6, 4.0, 7.7, 20.0)):
        samples, level = ((10, 0.05), (24, 0.2), (60, 0.0))[(seed + turn) % 3]
        claim = seen(noisy(SCENES[name], signal, cycles, samples, level, seed))
        claims += [] if claim is None else [(cycles, samples, level, claim)]
    assert claims == []


@each("signal", SIGNALS)
@each("name", ["F_", "FB"])
def test_a_wrong_frequency_is_named_with_the_right_one(signal: str, name: str) -> None:
    """Twice and half the true one too; all within what the record tells."""
    observation = noisy(SCENES[name], signal, 20.0, 40, 0.05, 1)
    for factor in (0.5, 1.02, 2.5) if name == "F_" else (0.7, 0.98, 2.0):
        claim = seen(observation, factor)
        assert claim is not None, factor
        off = abs(claim.frequency.value - FREQUENCY)
        assert off < 4.0 * claim.frequency.error, factor
        assert off * 20.0 / FREQUENCY < 0.02, factor


@pytest.mark.parametrize("seed", range(2))
def test_a_multiple_of_the_drives_frequency_may_be_off_by_as_many_of_its_errors(seed: int) -> None:
    """Data at twice the drive's frequency, of which five errors are two and a half of the drive's."""
    time = np.arange(1201) / 600.0
    values = np.sin(2.0 * math.pi * 30.0 * time) + np.random.default_rng(seed).standard_normal(time.size)
    found = seen(Observation(time, {"velocity": values}, 15.0))
    assert found is not None
    value, error = found.frequency
    for off in (-5.0, 5.0):
        claim = seen(Observation(time, {"velocity": values}, 0.5 * (value + off * error)))
        assert claim is not None
        assert claim.cycles == 0
        assert claim.frequency.value == pytest.approx(value, abs=1e-3 * error)


@pytest.mark.parametrize("throw", [1.3, 2.6, 4.0, 7.0])
def test_hopping_is_no_wrong_frequency(throw: float) -> None:
    """A body that hops may repeat its motion every few cycles, or never: no other drive is named."""
    frequency, angle = 25.0, math.radians(30.0)
    amplitude = throw * 9.81 / math.sin(angle) / (2.0 * math.pi * frequency) ** 2
    scene = nut(frequency=frequency, amplitude=amplitude, drive_angle=angle)
    history = simulate(scene, cycles=100)
    time = np.arange(40 * 40 + 1) / (40 * frequency)
    sample = history.sample(time + 50.3 / frequency)
    for name, values in (("velocity", sample.velocity), ("displacement", sample.position)):
        claim = seen(Observation(time, {name: values}, frequency))
        assert claim is None or claim.cycles > 1


@pytest.mark.parametrize("kind", ["noise", "slow", "still", "drift", "digits"])
def test_data_without_a_wave_have_no_frequency(kind: str) -> None:
    random = np.random.default_rng(5)
    time = np.arange(801) / 600.0
    for _ in range(4):
        white = random.standard_normal(time.size)
        values = {
            "noise": white,
            "slow": np.cumsum(white),
            "still": np.zeros(time.size),
            "drift": 3.0 * time,
            "digits": np.round(0.3 + 1e-7 * time, 9),
        }[kind]
        assert seen(Observation(time, {"velocity": values}, FREQUENCY)) is None


@pytest.mark.parametrize(("fraction", "cycles"), [(2, 2), (2.5, 0), (5, 5), (8, 8), (9, 0)])
def test_a_body_may_repeat_its_motion_every_eight_cycles_at_most(fraction: float, cycles: int) -> None:
    time = np.arange(2001) / 250.0
    claim = seen(Observation(time, {"velocity": np.sin(10.0 * math.pi * time)}, 5.0 * fraction))
    assert claim is not None
    assert claim.cycles == cycles
    assert claim.frequency.value == pytest.approx(5.0, abs=1e-4)
