"""Linear machines: against 60 digits, and in their limits."""

from __future__ import annotations

import csv
import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from helpers.cases import each
from hypothesis import given
from hypothesis import strategies as st

from vibro import Calibration, InputError, Machine

TABLE = Path(__file__).parents[1] / "data" / "machines" / "machines.csv"
with TABLE.open(encoding="utf-8") as _file:
    ROWS = [{k: v for k, v in row.items() if v} for row in csv.DictReader(_file)]

FEEDER: dict[str, Any] = {"trough_mass": 6.0, "counter_mass": 12.0, "damping_ratio": 0.015}
CLOSE = 1e-12  # relative


def machine_of(row: dict[str, str]) -> Machine:
    """Make the machine of a row."""
    number = {name: float(text) for name, text in row.items() if name not in ("id", "kind", "law")}
    masses: dict[str, Any] = {
        "trough_mass": number["m1_kg"],
        "natural_frequency": number.get("natural_hz"),
        "damping_ratio": number.get("damping_ratio"),
    }
    base: dict[str, Any] = {"base_stiffness": number.get("base_stiffness_n_m", 0.0)}
    moment = number.get("static_moment_kg_mm", 0.0) / 1000.0
    match row["kind"]:
        case "unbalance":
            return Machine.unbalance(
                vibrating_mass=number["m1_kg"],
                static_moment=moment,
                mount_frequency=number["natural_hz"],
                damping_ratio=number["damping_ratio"],
            )
        case "magnet":
            law: dict[str, Any] = {"law": "voltage", "force_frequency": number["force_frequency_hz"]}
            return Machine.magnet(
                **masses,
                **base,
                counter_mass=number.get("m2_kg", math.inf),
                force=number["force_n"],
                **(law if row["law"] == "voltage" else {}),
            )
        case "exciter":
            return Machine.exciter(**masses, **base, counter_mass=number["m2_kg"], static_moment=moment)
        case "crank":
            return Machine.crank(radius=number["crank_radius_mm"] / 1000.0)
    return Machine.rod(
        **masses, radius=number["crank_radius_mm"] / 1000.0, rod_stiffness=number["rod_stiffness_n_m"]
    )


def added_of(row: dict[str, str]) -> complex:
    share = complex(float(row.get("added_mass_share", 0.0)), -float(row.get("added_damping_share", 0.0)))
    return float(row.get("filling_kg", 0.0)) * share


@each("row", ROWS)
def test_a_machine_moves_as_with_60_digits(row: dict[str, str]) -> None:
    machine = machine_of(row)
    given = {
        name: float(row.get(key, 1.0)) for name, key in (("setting", "setting"), ("voltage", "voltage_ratio"))
    }
    found = machine.response(float(row["frequency_hz"]), **given, added_mass=added_of(row))
    empty = machine.response(float(row["frequency_hz"]), **given)
    for value, name, scale in (
        (found.amplitude, "amplitude_mm", 1e3),
        (empty.amplitude, "amplitude_empty_mm", 1e3),
        (found.counter_amplitude, "counter_amplitude_mm", 1e3),
        (found.relative_amplitude, "relative_amplitude_mm", 1e3),
        (found.filled_natural_frequency, "filled_natural_hz", 1.0),
    ):
        if name in row:
            assert value * scale == pytest.approx(float(row[name]), rel=CLOSE), name
    if "phase_deg" in row:
        assert math.degrees(found.phase) == pytest.approx(float(row["phase_deg"]), rel=CLOSE)
    shrunk = empty.amplitude / abs(1.0 + added_of(row) * found.compliance)
    assert shrunk == pytest.approx(found.amplitude, rel=CLOSE)


@st.composite
def machines(draw: st.DrawFn, kinds: tuple[str, ...] = ("unbalance", "magnet", "exciter", "rod")) -> Machine:
    """Draw a machine of any kind, light or heavy, with and without mounts."""
    kind = draw(st.sampled_from(kinds))
    mass, f0 = draw(st.floats(0.1, 5e3)), draw(st.floats(2.0, 150.0))
    ratio, split = draw(st.floats(0.002, 0.2)), draw(st.floats(0.2, 10.0))
    springs: dict[str, Any] = {"trough_mass": mass, "natural_frequency": f0, "damping_ratio": ratio}
    reduced = mass * split / (1.0 + split) * (2.0 * math.pi * f0) ** 2
    base = draw(st.one_of(st.just(0.0), st.floats(1e-3, 0.3))) * reduced
    if kind == "unbalance":
        return Machine.unbalance(
            vibrating_mass=mass, static_moment=mass * 1e-3, mount_frequency=f0, damping_ratio=ratio
        )
    if kind == "rod":
        stiffness = draw(st.floats(0.05, 0.95)) * mass * (2.0 * math.pi * f0) ** 2
        return Machine.rod(**springs, radius=5e-3, rod_stiffness=stiffness)
    if kind == "exciter":
        return Machine.exciter(
            **springs, counter_mass=split * mass, static_moment=mass * 1e-3, base_stiffness=base
        )
    law: dict[str, Any] = draw(st.sampled_from([{}, {"law": "voltage", "force_frequency": 50.0}]))
    exponent = draw(st.sampled_from([1.0, 2.0]))
    return Machine.magnet(
        **springs,
        counter_mass=split * mass,
        base_stiffness=base,
        force=50.0,
        voltage_exponent=exponent,
        **law,
    )


@given(machines(("magnet", "exciter")), st.floats(0.3, 3.0), st.floats(0.01, 3.0), st.floats(0.0, 1.0))
def test_no_filling_changes_a_load_proof_machine_without_damping(
    machine: Machine, ratio: float, filling: float, damping: float
) -> None:
    f = ratio * machine.natural_frequency
    if machine.counter_mass * (2.0 * math.pi * f) ** 2 <= 1.001 * machine.base_stiffness:
        with pytest.raises(InputError, match="base_stiffness"):
            replace(machine, base_stiffness=1e3 * machine.base_stiffness + 1e12).load_proof_frequency(f)
        return
    proof = replace(machine.with_natural_frequency(machine.load_proof_frequency(f)), damping_ratio=0.0)
    added = filling * proof.trough_mass * complex(1.0, -damping)
    empty, full = proof.response(f), proof.response(f, added_mass=added)
    w2 = (2.0 * math.pi * f) ** 2
    conditioning = (
        proof.counter_mass * (1.0 + filling) * w2 / abs(proof.counter_mass * w2 - proof.base_stiffness)
    )
    assert full.amplitude == pytest.approx(empty.amplitude, rel=1e-13 * conditioning)
    k = proof.counter_mass * w2 - proof.base_stiffness
    right = float(machine.force_at(f)) / k
    assert empty.amplitude == pytest.approx(right, rel=1e-12 * conditioning)


@given(machines(("magnet",)), st.floats(0.2, 4.0), st.floats(0.0, 1.0), st.floats(0.0, 1.0))
def test_an_infinite_counter_mass_is_the_floor(
    machine: Machine, ratio: float, mass: float, damping: float
) -> None:
    f = ratio * machine.natural_frequency
    added = machine.trough_mass * complex(mass, -damping)
    floor = replace(machine, counter_mass=math.inf, base_stiffness=0.0)
    large = replace(machine, counter_mass=1e14 * machine.trough_mass, base_stiffness=0.0)
    one, other = (m.response(f, added_mass=added) for m in (floor, large))
    assert one.amplitude == pytest.approx(other.amplitude, rel=1e-9)
    assert one.counter_amplitude == 0.0
    assert one.relative_amplitude == one.amplitude
    w, m1, f0 = 2.0 * math.pi * f, machine.trough_mass, machine.natural_frequency
    eta = f / f0
    size = math.hypot(1.0 - eta**2, 2.0 * machine.damping_ratio * eta)
    force = float(floor.force_at(f))
    assert floor.response(f).amplitude == pytest.approx(
        force / (m1 * (2.0 * math.pi * f0) ** 2 * size), rel=1e-9
    )
    assert abs(one.compliance) == pytest.approx(w**2 / (m1 * (2.0 * math.pi * f0) ** 2 * size), rel=1e-9)


@given(machines(), st.floats(0.2, 4.0), st.floats(0.0, 1.0), st.floats(0.0, 1.0))
def test_a_filling_shrinks_the_amplitude_by_its_share_of_the_impedance(
    machine: Machine, ratio: float, mass: float, damping: float
) -> None:
    f = ratio * machine.natural_frequency
    added = machine.trough_mass * complex(mass, -damping)
    empty, full = machine.response(f), machine.response(f, added_mass=added)
    shrunk = empty.amplitude / abs(1.0 + added * empty.compliance)
    assert full.amplitude == pytest.approx(shrunk, rel=1e-11)


def test_arguments_broadcast_and_equal_single_cases() -> None:
    machine = Machine.magnet(**FEEDER, natural_frequency=55.6, force=40.0)
    f, u = np.array([[40.0], [50.0], [60.0]]), np.array([0.9, 1.0])
    added = np.array([0.0, 1.0 - 0.2j])
    found = machine.response(f, voltage=u, added_mass=added, natural_frequency=[50.0, 55.6])
    assert found.amplitude.shape == (3, 2)
    for i in range(3):
        for j, f0 in enumerate((50.0, 55.6)):
            pack = machine.with_natural_frequency(f0)
            one = pack.response(f[i, 0], voltage=u[j], added_mass=added[j])
            assert one.amplitude == found.amplitude[i, j]
            assert one.compliance == found.compliance[i, j]
            assert one.phase == found.phase[i, j]


def test_a_calibration_fixes_the_force() -> None:
    known = Calibration(amplitude=0.35e-3, frequency=50.0, setting=0.8, voltage=0.95, filling=1.0)
    machine = Machine.magnet(**FEEDER, natural_frequency=55.6, calibration=known)
    reached = machine.response(50.0, setting=0.8, voltage=0.95, added_mass=1.0)
    assert reached.amplitude == pytest.approx(0.35e-3, rel=1e-14)
    law = Machine.magnet(**FEEDER, natural_frequency=55.6, calibration=known, law="voltage")
    assert law.force_frequency == 50.0
    assert law.force_at(25.0) == pytest.approx(4.0 * law.force_at(50.0))


def test_the_price_of_a_load_proof_pack() -> None:
    machine = Machine.magnet(**FEEDER, natural_frequency=50.0 / 0.9, force=49.0)
    f0 = machine.load_proof_frequency(50.0)
    assert 50.0 / f0 == pytest.approx(math.sqrt(1.0 / 3.0), rel=1e-14)
    eta, zeta = 0.9, 0.015
    root = math.hypot(1.0 - eta**2, 2.0 * zeta * eta)
    own = 12.0 * (2.0 * math.pi * 50.0) ** 2 / (6.0 * (2.0 * math.pi * 50.0 / eta) ** 2 * root)
    assert machine.load_proof_force(50.0) == pytest.approx(own, rel=1e-3)
    assert round(machine.load_proof_force(50.0), 1) == 8.4


@pytest.mark.parametrize("law", ["constant", "square"])
def test_a_machine_is_made_from_its_own_amplitudes(law: Any) -> None:
    made: dict[str, Any] = {"trough_mass": 6.0, "counter_mass": math.inf if law == "square" else 12.0}
    if law == "square":
        right = Machine.unbalance(
            vibrating_mass=6.0, static_moment=6e-3, mount_frequency=50.0, damping_ratio=0.02
        )
    else:
        right = Machine.magnet(**made, natural_frequency=50.0, damping_ratio=0.02, force=30.0)
    f = np.array([40.0, 47.0, 49.0, 50.5, 53.0, 60.0])
    found = Machine.measured(points=np.stack([f, right.response(f).amplitude], axis=1), **made, law=law)
    assert found.natural_frequency == pytest.approx(50.0, rel=1e-9)
    assert found.response(44.0, added_mass=1.0 - 0.2j).amplitude == pytest.approx(
        right.response(44.0, added_mass=1.0 - 0.2j).amplitude, rel=1e-7
    )
    assert found.voltage_exponent == right.voltage_exponent


def tuned(ratio: float, counter_mass: float) -> Machine:
    return Machine.magnet(
        trough_mass=6.0,
        counter_mass=counter_mass,
        natural_frequency=50.0 / ratio,
        damping_ratio=0.015,
        force=20.0,
    )


@pytest.mark.parametrize("counter_mass", [12.0, math.inf])
def test_the_mass_that_brings_resonance(counter_mass: float) -> None:
    machine = tuned(0.9, counter_mass)
    mass = machine.mass_to_resonance(50.0)
    assert machine.response(50.0, added_mass=mass).filled_natural_frequency == pytest.approx(50.0, rel=1e-14)
    above = tuned(1.05, counter_mass).mass_to_resonance(50.0)
    assert above < 0.0
    filled = tuned(1.05, counter_mass).response(50.0, added_mass=above).filled_natural_frequency
    assert filled == pytest.approx(50.0, rel=1e-14)
    proof = machine.mass_to_resonance(50.0, natural_frequency=[60.0, 90.0])
    assert (proof[1] == math.inf) == (counter_mass == 12.0)  # beyond the load-proof pack no mass is enough
    assert Machine.crank(radius=1e-3).mass_to_resonance(5.0) == math.inf
