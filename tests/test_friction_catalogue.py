"""The catalogue of friction and restitution: what it holds, and how its rows are named."""

from __future__ import annotations

import re
from importlib.resources import files

import pytest
from helpers.cases import each

from vibro.errors import InputError
from vibro.friction import Row, band_text, find, rows, static_row
from vibro.inverse_friction import LEAST_FRICTION, MOST_FRICTION, USUAL_RATIO


def test_every_row_has_a_source_and_bands_that_can_be() -> None:
    assert len(rows()) == 89
    assert sum(row.restitution is not None for row in rows()) == 16
    for row in rows():
        assert row.pair
        assert row.condition
        assert row.source
        assert row.url.startswith("https://") or row.note
        assert row.static_friction or row.kinetic_friction or row.restitution
        assert row.restitution or not row.impact_speed
        for band, most in (
            (row.static_friction, 2.0),
            (row.kinetic_friction, 3.0),
            (row.restitution, 1.0),
            (row.impact_speed, 10.0),
        ):
            assert band is None or 0.0 < band[0] <= band[1] < most
        if row.static_friction and row.kinetic_friction:  # the bands of one source may overlap, no more
            assert row.kinetic_friction[0] <= row.static_friction[0]
            assert row.kinetic_friction[1] <= row.static_friction[1]


def test_values_are_those_of_the_table() -> None:
    text = files("vibro").joinpath("friction_catalogue.csv").read_text(encoding="utf-8")
    assert '\nsteel on steel,dry,0.12,0.60,0.08,0.50,,,,,"Lust CDA3000' in text
    row = static_row("steel on steel, dry, Lust")
    assert (row.static_friction, row.kinetic_friction) == ((0.12, 0.6), (0.08, 0.5))
    autodesk = static_row("brass on steel, dry, Autodesk")
    assert (autodesk.static_friction, autodesk.kinetic_friction) == ((0.35, 0.35), None)
    (pellets,) = find("polyethylene on steel")
    assert (pellets.restitution, pellets.impact_speed) == ((0.335, 0.364), (0.79, 0.93))
    assert (pellets.static_friction, pellets.kinetic_friction) == (None, None)


def test_sources_that_contradict_each_other_are_all_there() -> None:
    bands = [row.static_friction for row in find("steel on steel") if row.condition == "dry"]
    assert bands == [(0.74, 0.74), (0.12, 0.6), (0.45, 0.8), (0.8, 0.8), (0.3, 0.3), (0.13, 0.13)]
    assert [row.restitution for row in find("steel on steel") if row.restitution] == [(0.26, 0.26)]
    assert [row.restitution for row in find("steel ball")] == [(0.85, 0.85)]


@pytest.mark.parametrize(
    ("words", "pairs"),
    [
        ("brass", {"brass on steel"}),
        ("belt plastic", {"plastic belt on steel"}),
        ("POLYURETHANE", {"polyurethane on unnamed surface", "metal on polyurethane"}),
        ("steel on steel", {"steel on steel"}),
        ("  steel  on   plastic", {"steel on plastic"}),
        ("steel belt", {"plastic belt on steel"}),
        ("ptfe", {"PTFE on steel", "acetal with PTFE on steel"}),
        ("Teflon", {"PTFE on steel", "acetal with PTFE on steel"}),
        ("nylon aluminum", {"polyamide on aluminium"}),
        ("", {row.pair for row in rows()}),
    ],
)
def test_pairs_are_found_by_words(words: str, pairs: set[str]) -> None:
    assert {row.pair for row in find(words)} == pairs


@each("row", [row for row in rows() if row.static_friction])
def test_every_row_with_static_friction_can_be_named(row: Row) -> None:
    assert static_row(f" {row.pair.upper()},{row.condition} ,  {row.source}") is row


def test_what_a_refusal_lists_names_each_row() -> None:
    with pytest.raises(InputError, match="8 rows") as caught:
        static_row("steel on steel")
    lines = caught.value.hint.splitlines()
    written = [re.fullmatch(r'write "(.*)" for mu_s (.*), mu_d (.*)', line) for line in lines]
    named = [static_row(match[1]) for match in written if match]
    assert named == [row for row in find("steel on steel") if row.static_friction]
    assert [match[2] for match in written if match] == [band_text(row.static_friction) for row in named]


def test_the_usual_ratio_and_the_frictions_that_are_searched_are_those_of_the_catalogue() -> None:
    pairs = [row for row in rows() if row.static_friction and row.kinetic_friction and row.condition == "dry"]
    metals = [row for row in pairs if re.fullmatch("(steel|copper|brass|aluminium) on steel", row.pair)]
    ratios = [
        round(kinetic / static, 2)
        for row in metals
        for kinetic, static in zip(row.kinetic_friction or (), row.static_friction or (), strict=True)
    ]
    assert (min(ratios), max(ratios)) == (0.67, 0.89)
    assert min(ratios) < USUAL_RATIO < max(ratios)
    kinetic_frictions = [mu for row in rows() for mu in row.kinetic_friction or ()]
    assert LEAST_FRICTION < min(kinetic_frictions) < max(kinetic_frictions) < MOST_FRICTION
    with_steel = [mu for row in rows() if "steel" in row.pair for mu in row.kinetic_friction or ()]
    assert max(with_steel) < 1.71  # docs/tasks/friction.md
