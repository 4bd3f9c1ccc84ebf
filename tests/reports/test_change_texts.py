"""What a report says of small changes, against scenes that are solved with these changes."""

from __future__ import annotations

import math

import pytest
from helpers.reports import NUT
from helpers.reports import scene_at as at

import vibro
from vibro.inverse.costs import changed_cycles, speed_costs
from vibro.reports.change_texts import change_texts

BOUNCES = {"amplitude": 3.0, "frequency": 30.0, "restitution": 0.3}
IRREGULAR = {"amplitude": 3.0, "frequency": 40.0, "restitution": 0.6}


def speed(values: dict[str, float]) -> float:
    si = {name: math.radians(x) if name.endswith("_angle") else x for name, x in values.items()}
    return 1e3 * float(vibro.solve(vibro.Scene(**{**si, "amplitude": 1e-3 * si["amplitude"]})).mean_velocity)


@pytest.mark.parametrize(
    "changes",
    [{}, {"trough_angle": 27.0, "amplitude": 0.9}, {"amplitude": 4.0}, BOUNCES],
    ids=["contact", "backwards", "hops", "bounces"],
)
def test_changes_are_those_of_the_changed_scenes(changes: dict[str, float]) -> None:
    values = NUT | changes
    _, rows = change_texts(at(**changes))
    told = {row[0]: row[1] for row in rows[1:]}
    assert len(told) == 7
    now = speed(values)
    for label, text in told.items():
        name = label.partition(",")[0].replace(" ", "_")
        factor = 1.1 if "10 %" in label else 1.01
        then = speed({**values, name: values[name] + 1.0 if "1°" in label else factor * values[name]})
        assert float(text.removesuffix(" %")) == pytest.approx(100.0 * (then / now - 1.0), rel=6e-3, abs=1e-9)


def test_in_contact_they_agree_with_the_closed_form_to_second_order() -> None:
    scene = at().scene
    names, cycle = changed_cycles(scene)
    costs = speed_costs(scene)
    speeds = dict(zip(["", *names], cycle.mean_velocity, strict=True))
    for name in ("amplitude", "frequency", "drive_angle", "static_friction", "kinetic_friction"):
        cost = costs[name]
        assert not isinstance(cost, str)
        assert 100.0 * (speeds[name] / speeds[""] - 1.0) == pytest.approx(cost, abs=0.01 * (1.0 + cost**2))


def test_the_change_that_counts_most_is_named_where_that_is_sure() -> None:
    for changes, found in (({}, "frequency counts most: 6.65 %"), (BOUNCES, "frequency counts most: 1.47 %")):
        assert found in change_texts(at(**changes))[0][0]
    texts, rows = change_texts(at(**IRREGULAR))
    assert "standard errors" in texts[0]
    assert {row[0]: row[1] for row in rows}["amplitude, 10 % more"].startswith("+9.81 % +- 4.9 %")


def test_what_counts_most_may_be_a_loss() -> None:
    texts, rows = change_texts(at(amplitude=1.2, kinetic_friction=0.37, trough_angle=2.0))
    changes = {row[0]: float(row[1].removesuffix(" %")) for row in rows[1:]}
    loss = changes["frequency"]
    assert loss < 0.0 < -loss > changes["static friction"] > 0.0
    (text,) = texts
    assert f"frequency counts most: {-loss:.3g} % slower" in text


def test_other_motions_are_told() -> None:
    then = {row[0]: row[-1] for row in change_texts(at(amplitude=1.185))[1]}
    assert then["amplitude"] == then["frequency"] == "slips back"
    assert then["static friction"] == ""
    then = {row[0]: row[-1] for row in change_texts(at(**BOUNCES))[1]}
    assert then["amplitude, 10 % more"] == "repeats every 11 drive cycles"
    then = {row[0]: row[-1] for row in change_texts(at(amplitude=500.0, frequency=400.0))[1]}
    assert then["amplitude"] == "hops in irregular motion"


def test_a_part_at_rest() -> None:
    assert change_texts(at(amplitude=0.5))[1] == []
    texts, rows = change_texts(at(amplitude=0.68))
    assert texts == []
    assert ("amplitude", f"{speed(NUT | {'amplitude': 0.6868}):.6g} mm/s", "slides forward") in rows
    assert ("static friction", "0 mm/s", "") in rows


def test_what_cannot_be_is_unknown() -> None:
    rows = {row[0]: row[1:] for row in change_texts(at(kinetic_friction=0.74))[1]}
    assert rows["kinetic friction"] == ("unknown", "has no speed (infeasible)")
    assert change_texts(at(kinetic_friction=0.74, amplitude=0.5))[1] == []
