"""The catalogue of friction: what it holds, and how its rows are named."""

from __future__ import annotations

import re
from importlib.resources import files

import pytest
from helpers.cases import each

from vibro.errors import InputError
from vibro.friction_catalogue import Row, band_text, find, number_hint, rows, static_row


def test_every_row_has_a_source_and_bands_that_can_be() -> None:
    assert len(rows()) == 14
    for row in rows():
        assert row.pair
        assert row.condition
        assert row.source
        assert row.url.startswith("https://") or row.note
        assert row.static_friction or row.kinetic_friction
        for low, high in filter(None, (row.static_friction, row.kinetic_friction)):
            assert 0.0 < low <= high < 2.0
        if row.static_friction and row.kinetic_friction:  # the bands of one source may overlap, no more
            assert row.kinetic_friction[0] <= row.static_friction[0]
            assert row.kinetic_friction[1] <= row.static_friction[1]


def test_values_are_those_of_the_table() -> None:
    text = files("vibro").joinpath("friction_catalogue.csv").read_text(encoding="utf-8")
    assert '\nsteel on steel,dry,0.12,0.60,0.08,0.50,"Lust CDA3000' in text
    row = static_row("steel on steel, dry, Lust")
    assert (row.static_friction, row.kinetic_friction) == ((0.12, 0.6), (0.08, 0.5))
    (autodesk,) = (row for row in rows() if row.pair == "brass on steel")
    assert (autodesk.static_friction, autodesk.kinetic_friction) == ((0.35, 0.35), None)


def test_sources_that_contradict_each_other_are_all_there() -> None:
    bands = [row.static_friction for row in find("steel on steel") if row.condition == "dry"]
    assert bands == [(0.74, 0.74), (0.12, 0.6), (0.45, 0.8), (0.8, 0.8)]


@pytest.mark.parametrize(
    ("words", "pairs"),
    [
        ("brass", {"brass on steel"}),
        ("PLASTIC", {"steel on plastic", "plastic belt on steel", "plastic on steel"}),
        ("steel on steel", {"steel on steel"}),
        ("  steel  on   plastic", {"steel on plastic"}),
        ("steel belt", {"plastic belt on steel"}),
        ("ptfe", {"PTFE on steel"}),
        ("", {row.pair for row in rows()}),
    ],
)
def test_pairs_are_found_by_words(words: str, pairs: set[str]) -> None:
    assert {row.pair for row in find(words)} == pairs


@pytest.mark.parametrize(
    ("words", "meant"), [("plastik", "'steel on plastic'"), ("stel on steel", "'steel on steel'")]
)
def test_a_pair_that_is_not_there_has_near_ones(words: str, meant: str) -> None:
    with pytest.raises(InputError, match="no such pair") as caught:
        find(words)
    assert meant in caught.value.hint


@pytest.mark.parametrize("words", ["qqq", "\x1b[31m", 5000 * "z"])
def test_a_word_that_is_like_no_pair(words: str) -> None:
    with pytest.raises(InputError, match="no such pair") as caught:
        find(words)
    assert caught.value.hint.startswith("its pairs are steel on steel, brass on steel, ")
    assert str(caught.value).isprintable()


@each("row", [row for row in rows() if row.static_friction])
def test_every_row_with_static_friction_can_be_named(row: Row) -> None:
    assert static_row(f" {row.pair.upper()},{row.condition} ,  {row.source}") is row


def test_what_a_refusal_lists_names_each_row() -> None:
    with pytest.raises(
        InputError, match="'steel on steel': 5 rows of the catalogue, name the source"
    ) as caught:
        static_row("steel on steel")
    lines = caught.value.hint.splitlines()
    written = [re.fullmatch(r'write "(.*)" for mu_s (.*), mu_d (.*)', line) for line in lines]
    named = [static_row(match[1]) for match in written if match]
    assert named == [row for row in find("steel on steel") if row.static_friction]
    assert [match[2] for match in written if match] == [band_text(row.static_friction) for row in named]


def test_one_row_needs_no_more_than_its_pair() -> None:
    assert static_row("wood on steel") is static_row("wood on steel, dry") is find("wood")[0]


@pytest.mark.parametrize(
    ("text", "problem", "hint"),
    [
        ("steel on nylon, dry", "'steel on nylon': no such pair", "did you mean 'steel on steel' or"),
        ("steel on steel, dry", "'steel on steel, dry': 4 rows", 'write "steel on steel, dry, the paper on'),
        ("steel on steel, wet", "listed as dry, greased, unspecified alone", 'write "steel on'),
        ("steel on steel, dry, Siemens", "no source of this pair has that name", 'write "steel on'),
        ("steel on steel, unspecified", "the catalogue has no static friction for it", "give a number or"),
        ("PTFE on steel, dry", "the catalogue has no static friction for it", "give a number or"),
    ],
)  # fmt: skip
def test_a_text_that_names_no_row_is_refused(text: str, problem: str, hint: str) -> None:
    with pytest.raises(InputError) as caught:
        static_row(text)
    assert problem in str(caught.value)
    assert caught.value.hint.startswith(hint)


@pytest.mark.parametrize(
    ("band", "text"), [(None, "-"), ((0.3, 0.3), "0.3"), ((0.3, 0.5), "0.3:0.5"), ((0.0, 0.125), "0:0.125")]
)
def test_bands_as_they_are_typed(band: tuple[float, float] | None, text: str) -> None:
    assert band_text(band) == text


def test_a_source_counts_with_its_commas() -> None:
    assert static_row("wood on steel, dry, lust cda3000 engineering guide, table 7.21").static_friction == (
        0.45,
        0.75,
    )
    with pytest.raises(InputError, match="no source of this pair has that name"):
        static_row("wood on steel, dry, lust cda3000 engineering guide, table 9")


def test_two_rows_are_too_many() -> None:
    """A table of a drive maker and one of a program's help."""
    with pytest.raises(InputError, match="2 rows of the catalogue, name the source of one") as told:
        static_row("steel on steel, dry, table")
    assert str(told.value.hint).count("\n") == 1


def test_a_list_has_the_rows_of_the_pair_by_the_shortest_name_of_their_source() -> None:
    """The same source may list a pair in two conditions."""
    with pytest.raises(InputError) as told:
        static_row("steel on steel, wet")
    lines = str(told.value.hint).splitlines()
    assert len(lines) == 6
    assert all(line.startswith('write "steel on steel, ') for line in lines)
    for condition, bands in (
        ("dry", "mu_s 0.12:0.6, mu_d 0.08:0.5"),
        ("greased", "mu_s 0.12:0.35, mu_d 0.04:0.25"),
    ):
        assert f'write "steel on steel, {condition}, Lust CDA3000 Engineering Guide" for {bands}' in lines


@pytest.mark.parametrize(
    ("text", "field", "hint"),
    [
        (
            " Steel  on STEEL",
            "static_friction",
            "steel on steel has 0.12:0.8 (dry), 0.12:0.35 (greased): choose from it;"
            " vibro friction steel on steel names sources",
        ),
        (
            "steel on steel",
            "kinetic_friction",
            "steel on steel has 0.08:0.7 (dry), 0.04:0.25 (greased), 0.58 (unspecified): choose from it;"
            " vibro friction steel on steel names sources",
        ),
        ("PTFE on steel", "static_friction", "give a number: the catalogue has no static friction of PTFE"),
        ("steel on plastik", "static_friction", "did you mean 'steel on plastic' or 'steel on steel' or"),
        ("qqq", "static_friction", "write it like 0.5; vibro friction lists pairs of materials"),
    ],
)  # fmt: skip
def test_materials_in_place_of_a_number_are_answered_with_what_is_printed(
    text: str, field: str, hint: str
) -> None:
    assert number_hint(text, field).startswith(hint)
