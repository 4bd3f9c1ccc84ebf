"""At which frequency data repeat: named where it is clearly not that of the drive, and never else."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from helpers.cases import each
from helpers.made_records import FREQUENCY, Walked, nut

from vibro.motion.histories import simulate
from vibro.records.alignment import Foreign, Observation, Repetition, foreign_frequency
from vibro.records.comparison import compare

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


def test_the_standard_error_of_a_frequency_is_that_of_repeated_noise() -> None:
    found = [seen(noisy(SCENES["F_"], "velocity", 10.0, 40, 0.1, seed), 1.3) for seed in range(20)]
    off = np.array([claim.frequency.value - FREQUENCY for claim in found if claim])
    told = np.array([claim.frequency.error for claim in found if claim])
    assert off.size == 20
    assert 0.5 < float(np.sqrt(np.mean((off / told) ** 2))) < 1.8
    assert float(np.abs(off / told).max()) < 4.5


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


def test_a_motion_that_repeats_every_other_cycle_is_told_as_such() -> None:
    time = np.arange(801) / 600.0
    waves = 2.0 * math.pi * FREQUENCY * time
    values = np.cos(waves) + np.cos(0.5 * waves)
    observation = Observation(time, {"velocity": 0.01 * values}, FREQUENCY)
    claim = seen(observation)
    assert claim is not None
    assert claim.cycles == 2
    (warning,) = (text for text in compare(nut(), observation).warnings if "repeat" in text)
    assert "7.5 Hz, every 2 cycles" in warning


def test_a_multiple_is_no_other_frequency_where_the_drives_own_wave_is_seen() -> None:
    """The largest wave is the second harmonic, and the third shows that the drive has half its frequency."""
    time = np.arange(1201) / 600.0
    waves = [(0.03, 15.0), (0.65, 30.0), (0.32, 45.0)]
    values = np.sum([math.sqrt(p) * np.sin(2.0 * math.pi * f * time + f) for p, f in waves], axis=0)
    values += 0.02 * np.random.default_rng(1).standard_normal(time.size)
    signals = Repetition(time, {"velocity": values}, {"velocity": 0})
    found = signals.fundamental()
    assert found is not None
    assert found.value == pytest.approx(30.0, abs=0.01)
    assert seen(Observation(time, {"velocity": values}, 15.0)) is None


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


@pytest.mark.parametrize(("share", "cycles"), [(0.6, 3), (2.4, 3), (3.6, 0)])
def test_a_motion_of_several_cycles_may_be_off_by_as_many_of_its_errors(share: float, cycles: int) -> None:
    """Three cycles of data at a third of the drive's frequency drift three times as far as one."""
    time = np.linspace(0.0, 8.0, 4001)
    data = Observation(time, {"acceleration": np.sin(2.0 * np.pi * 5.0 * time)}, 15.0)
    apart = 0.05 / Repetition(data.middle.time, data.middle.signals, {"acceleration": -1}).span
    claim = foreign_frequency(Observation(time, data.signals, 15.0 + share * apart))
    assert claim is not None
    assert claim.cycles == cycles


# --- what a frequency explains, by hand ---------------------------------------------------------------


def waves_and_steps(*amplitudes: float) -> Repetition:
    """Take 40 s of waves of 1 Hz, with steps of sign that no frequency explains, one signal each."""
    time = np.arange(640) / 16.0
    steps = (-1.0) ** np.arange(640)
    made = {f"{a:g}": a * np.sin(2.0 * math.pi * time) + steps for a in amplitudes}
    return Repetition(time, made, dict.fromkeys(made, 0))


@pytest.mark.parametrize(("count", "other", "coefficients"), [(1, None, 0), (2, None, 0), (1, 1.37, 12)])
def test_a_frequency_explains_more_beyond_five_sigma_and_the_number_of_frequencies(
    count: int, other: float | None, coefficients: int
) -> None:
    """A wave of size a leaves 1 of 1 + a^2/2, scaled up for 16 coefficients, or 12 of 1.37 Hz.

    640 samples of each signal gain 320 times the logarithm: 12.5 and log(640) are needed.
    """
    needed = math.exp((12.5 + math.log(640.0)) / (320.0 * count))
    size = math.sqrt(2.0 * (needed * (640 - coefficients) / (640 - 16) - 1.0))
    for factor, more in ((0.98, False), (1.02, True)):
        found = waves_and_steps(*(factor * size + 1e-6 * n for n in range(count)))
        assert found.explains_more(1.0, other) == more
    assert not found.explains_more(1.37, 1.0)


@pytest.mark.parametrize(("off", "claimed"), [(-9.0, True), (-5.0, False), (5.0, False), (9.0, True)])
def test_another_frequency_must_explain_clearly_more_than_the_drives(off: float, claimed: bool) -> None:
    """Five standard errors off are beyond the four of its own, but gain 12.5 only: as much as noise may."""
    time = np.arange(1201) / 600.0
    for seed in range(2):
        noise = np.random.default_rng(seed).standard_normal(time.size)
        values = {"velocity": np.sin(2.0 * math.pi * FREQUENCY * time) + noise}
        found = Repetition(time, values, {"velocity": 0}).fundamental()
        assert found is not None
        assert 4.0 * found.error > 0.05 / 2.0
        claim = seen(Observation(time, values, found.value + off * found.error))
        assert (claim is not None) == claimed


@pytest.mark.parametrize(("fraction", "cycles"), [(2, 2), (2.5, 0), (5, 5), (8, 8), (9, 0)])
def test_a_body_may_repeat_its_motion_every_eight_cycles_at_most(fraction: float, cycles: int) -> None:
    time = np.arange(2001) / 250.0
    claim = seen(Observation(time, {"velocity": np.sin(10.0 * math.pi * time)}, 5.0 * fraction))
    assert claim is not None
    assert claim.cycles == cycles
    assert claim.frequency.value == pytest.approx(5.0, abs=1e-4)


@pytest.mark.parametrize(("share", "claimed"), [(0.25, False), (0.36, True)])
def test_less_than_three_tenths_of_the_power_are_no_repetition(share: float, claimed: bool) -> None:
    time = np.arange(6001) / 600.0
    noise = np.random.default_rng(3).standard_normal(time.size)
    values = math.sqrt(2.0 * share) * np.sin(2.0 * math.pi * 20.0 * time) + math.sqrt(1.0 - share) * noise
    assert (seen(Observation(time, {"velocity": values}, FREQUENCY)) is not None) == claimed


@pytest.mark.parametrize(
    ("signal", "other", "rate"),
    [("displacement", 1.0 / 3.3, 100.0), ("acceleration", 3.3, 600.0), ("friction", 3.3, 600.0)],
)
def test_of_two_machines_the_one_with_the_larger_velocity_is_told(
    signal: str, other: float, rate: float
) -> None:
    """Another machine is slower, with a larger displacement, or faster, with a larger acceleration."""
    time = np.arange(4001) / rate
    turns = 2.0 * math.pi * FREQUENCY * time
    claim = seen(Observation(time, {signal: np.sin(turns) + 1.2 * np.sin(other * turns)}, 1.3 * FREQUENCY))
    assert claim is not None
    assert claim.frequency.value == pytest.approx(FREQUENCY, abs=0.01)
