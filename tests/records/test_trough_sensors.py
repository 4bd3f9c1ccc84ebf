"""The turn of sensors from gravity, and errors of sensors, against records made from kinematics alone."""

from __future__ import annotations

import math
import re
import runpy
from typing import TYPE_CHECKING, Any, Final

import numpy as np
import pytest
from helpers.cases import each
from helpers.made_records import EXAMPLES
from helpers.turned_sensors import Case, Line, record_of

import vibro
from vibro.errors import InputError
from vibro.records.channels import AXES, SIGNAL_UNITS
from vibro.records.reading import read_record
from vibro.records.sensors import EXACT, Mounting, SensorErrors
from vibro.records.trough import MeasuredMotion, motion_of, speeds_of

if TYPE_CHECKING:
    from pathlib import Path

TWO: Final = {"trough_along": 0, "trough_normal": 1}
THREE: Final = {**TWO, "trough_across": 2}
FRICTION: Final = {"static_friction": 0.5, "kinetic_friction": 0.4}
CASES: Final = 40
GOOD: Final = SensorErrors(gain=1e-3, cross=1e-3, offset=0.01, delay=0.0)


def is_the_motion(measured: MeasuredMotion, line: Line, within: float = 2e-3) -> None:
    drive = measured.drive_on_line()
    assert drive.quantities["amplitude"].value == pytest.approx(line.amplitude, rel=within)
    assert drive.quantities["drive_angle"].value == pytest.approx(line.angle, abs=within)


@pytest.mark.parametrize("turn", [-50.0, 0.0, 15.0])
@pytest.mark.parametrize("climb", [-8.0, 5.0])
def test_gravity_gives_the_turn_of_two_axes(turn: float, climb: float) -> None:
    line = Line(climb=math.radians(climb))
    record = record_of(line, Case(pitch=math.radians(turn)), TWO)
    measured = motion_of(record, Mounting(GOOD, trough_angle=line.climb))
    is_the_motion(measured, line)
    assert measured.placement.turn == pytest.approx(math.radians(turn), abs=1e-3)
    assert measured.placement.by_gravity


@pytest.mark.parametrize("roles", [{"trough_along": 0, "trough_normal": ~1}, {**TWO, "trough_along": ~0}])
def test_axes_that_point_the_other_way_are_turned(roles: dict[str, int]) -> None:
    """Downwards is known by gravity; backwards is said by the user."""
    line = Line()
    record = record_of(line, Case(pitch=0.2), roles)
    backwards = roles["trough_along"] < 0
    is_the_motion(motion_of(record, Mounting(GOOD), reverse=backwards), line)
    with pytest.raises(InputError, match="down while it moves forwards"):
        motion_of(record, Mounting(GOOD), reverse=not backwards)


def test_a_third_axis_gives_the_turn_about_the_normal() -> None:
    line = Line(climb=0.05)
    case = Case(pitch=0.2, yaw=-0.7, roll=0.3)
    is_the_motion(motion_of(record_of(line, case, THREE), Mounting(GOOD, trough_angle=line.climb)), line)
    # Without gravity the normal is as it is named, or stated.
    for turned in (0.0, 0.3):
        record = record_of(line, Case(pitch=turned, yaw=0.6), THREE, gravity=False)
        is_the_motion(motion_of(record, Mounting(GOOD, turned=turned or None)), line)
    with pytest.raises(InputError, match=r"'trough_along' for trough_along is 77 deg off"):
        motion_of(record_of(line, Case(pitch=1.3), THREE), Mounting(GOOD))


@each("seed", range(4))
def test_axes_of_a_phone_need_no_names(seed: int) -> None:
    """However it lies, and whether its signs are those of Android or the opposite ones."""
    random = np.random.default_rng(seed)
    line = Line(climb=math.radians(random.uniform(-5.0, 5.0)))
    case = Case(random.uniform(-0.3, 0.3), random.uniform(-math.pi, math.pi), random.uniform(-0.3, 0.3))
    signs = random.permutation(3)
    roles = dict(zip(AXES, (~signs if seed % 2 else signs).tolist(), strict=True))
    mounting = Mounting(GOOD, trough_angle=line.climb)
    record = record_of(line, case, roles)
    is_the_motion(motion_of(record, mounting), line)
    with pytest.raises(InputError, match="moves down while it moves forwards, by gravity"):
        motion_of(record, mounting, reverse=True)
    with pytest.raises(InputError, match="no gravity within the errors"):
        motion_of(record_of(line, case, roles, gravity=False), mounting)


def test_columns_of_a_phone_are_found(tmp_path: Path) -> None:
    path = EXAMPLES / "data" / "phone_trough_200hz.csv"
    made = runpy.run_path(str(path.parent / "make_phone_trough_200hz.py"))
    made["main"](tmp_path / "made.csv")
    assert (tmp_path / "made.csv").read_text(encoding="utf-8") == path.read_text(encoding="utf-8")
    record = read_record(path)
    assert [record.headers[role][:14] for role in record.trough] == [f"Acceleration {x}" for x in "xyz"]
    drive = motion_of(record, Mounting(SensorErrors())).drive_on_line().quantities
    for name, true in (("amplitude", made["NUT"]["AMPLITUDE"]), ("drive_angle", made["NUT"]["DRIVE_ANGLE"])):
        assert abs(drive[name].value - true) < 1.0 * drive[name].error


PHONE: Final = dict(zip(AXES, (2, 0, 1), strict=True))


@each(("said", "true", "roles"), [
    ("m/s^2", "g", TWO), ("g", "m/s^2", {"trough_normal": 1}), ("g", "mg", PHONE), ("mg", "g", THREE),
    ("m/s^2", "mm/s^2", PHONE), ("mm/s^2", "m/s^2", TWO),
])  # fmt: skip
def test_gravity_in_another_unit_is_refused_with_the_unit_that_works(
    roles: dict[str, int], said: str, true: str, tmp_path: Path
) -> None:
    line, path = Line(), tmp_path / "trough.csv"
    record = record_of(line, Case(pitch=0.05 * (len(roles) > 1), offsets=np.array([0.1, -0.1, 0.1])), roles)
    values = np.stack([record.time, *record.trough.values()], axis=1)
    values[:, 1:] /= SIGNAL_UNITS["acceleration"][true]
    names = ("ax", "ay", "az")[: len(roles)]
    header = ",".join(["t (s)", *(f"{name} ({said})" for name in names)])
    np.savetxt(path, values, "%.9g", ",", header=header, comments="")

    def measured(unit: str, columns: dict[str, str]) -> MeasuredMotion:
        given: dict[str, Any] = {
            role: f"{column} [{unit}]" if unit else column for role, column in columns.items()
        }
        given |= {} if len(roles) > 1 else {"drive_angle": line.angle}
        return vibro.measured_motion(path, sensor="gain=0.1%,cross=0.1%,offset=10mg", **given)

    plain = {} if "trough_x" in roles else dict(zip(roles, names, strict=True))
    with pytest.raises(InputError, match=f"is gravity if the unit is {re.escape(true)}\n") as refused:
        measured("", plain)
    proposed = re.findall(r'(trough_\w+)="(\w+) \[(.*?)\]"', str(refused.value.hint))
    assert {unit for *_, unit in proposed} == {true}
    columns = {role: column for role, column, _ in proposed}
    assert columns == (plain or {"trough_across": "ax", "trough_along": "ay", "trough_normal": "az"})
    motion = measured(true, columns)
    assert motion.drive_on_line().quantities["amplitude"].value == pytest.approx(line.amplitude, rel=2e-2)
    if plain:
        assert f"but {said} is taken" in "".join(measured(said, columns).notes)


@pytest.mark.parametrize("corner", [40.0, 100.0])
def test_a_low_pass_filter_is_taken_off_each_harmonic(corner: float) -> None:
    line = Line()
    record = record_of(line, Case(), TWO, gravity=False, lowpass=corner)
    plain, corrected = (
        motion_of(record, Mounting(errors)) for errors in (EXACT, EXACT._replace(lowpass=corner))
    )
    is_the_motion(corrected, line)
    loss = math.hypot(1.0, line.frequency / corner)
    size = plain.drive_on_line().quantities["amplitude"].value
    assert size == pytest.approx(line.amplitude / loss, rel=2e-3)
    lag = math.atan(line.frequency / corner) / (math.tau * line.frequency)
    assert plain.clock - corrected.clock == pytest.approx(lag, rel=0.01)


def drawn(kind: str, seed: int) -> tuple[Line, Any, Mounting, float | None]:
    """Draw a trough, and a record by a sensor whose errors are drawn from those that are usual."""
    random, errors = np.random.default_rng([seed, 7]), SensorErrors()
    line = Line(
        frequency=random.uniform(15.0, 30.0),
        angle=math.radians(random.uniform(12.0, 40.0)),
        climb=math.radians(random.uniform(-5.0, 5.0)),
    )
    load = random.uniform(0.3, 0.8) / math.sin(line.angle)
    line = line._replace(amplitude=load * 9.81 / (math.tau * line.frequency) ** 2)
    case = Case.drawn(
        random, tilt=errors.tilt, gain=errors.gain, cross=errors.cross, offset=errors.offset,
        delay=errors.delay,
    )  # fmt: skip
    options: dict[str, Any] = {"roles": TWO, "gravity": kind in ("gravity", "three")}
    angle, mounting = None, Mounting(errors, trough_angle=line.climb)
    if options["gravity"]:
        case = case._replace(pitch=random.uniform(-0.3, 0.3))
    if kind == "three":
        case = case._replace(yaw=random.uniform(-0.4, 0.4), roll=random.uniform(-0.2, 0.2))
        options["roles"] = THREE
    if kind == "one":
        options["roles"] = {"trough_along": 0}
        angle = line.angle + errors.angle * random.standard_normal()
    record = record_of(line, case, seed=seed, rate=400.0, step=0.01, **options)
    return line, record, mounting, angle


@pytest.mark.parametrize("kind", ["plane", "gravity", "three", "one"])
def test_intervals_hold_noise_and_sensors(kind: str) -> None:
    """Of amplitude, drive angle and speed; shares of 300 records a kind stand in docs/guide/measure.md."""
    off: dict[str, list[float]] = {"amplitude": [], "angle": [], "speed": []}
    for seed in range(CASES):
        line, record, mounting, angle = drawn(kind, seed)
        measured = motion_of(record, mounting, drive_angle=angle)
        size, way = measured.drive_on_line().quantities["amplitude"], measured.line_angle
        off["amplitude"].append((size.value - line.amplitude) / size.error)
        off["angle"].append((way.value - line.angle) / way.error)
        others = {**FRICTION, "trough_angle": line.climb}
        scene = vibro.Scene(
            amplitude=line.amplitude, frequency=line.frequency, drive_angle=line.angle, **others
        )
        speed = speeds_of(measured, others, draws=60).speed
        off["speed"].append((speed.value - float(vibro.solve(scene).mean_velocity)) / speed.error)
    for name, values in off.items():
        sizes = np.abs(values)
        assert np.mean(sizes < 1.96) > 0.85, name
        assert 0.7 < np.sqrt(np.mean(np.square(values))) < 1.3, name
        assert sizes.max() < 5.0, name
