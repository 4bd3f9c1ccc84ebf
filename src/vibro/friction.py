"""Coefficients of friction and restitution by pair of materials, as bands taken from printed sources.

The table beside this module has one row per pair, condition and source, with the values as printed there.
Sources disagree by a factor of up to six about one pair, and do not say which parts and surfaces they mean.
Therefore all rows are kept, and none are averaged.
"""

from __future__ import annotations

import csv
import re
from dataclasses import dataclass
from functools import cache
from importlib.resources import files
from typing import TYPE_CHECKING, Final

from vibro.errors import InputError, did_you_mean, shown

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping, Sequence

_Span = tuple[float, float]

_TABLE: Final = "friction_catalogue.csv"
#: Other names of materials that the catalogue has.
_SYNONYMS: Final = {
    "aluminum": "aluminium", "nylon": "polyamide", "pa": "polyamide", "pc": "polycarbonate",
    "pe": "polyethylene", "pmma": "acrylic", "pom": "acetal", "pp": "polypropylene", "pu": "polyurethane",
    "teflon": "ptfe",
}  # fmt: skip


@dataclass(frozen=True)
class Row:
    """Friction and restitution of one pair in one condition, from one source.

    Attributes
    ----------
    pair, condition : str
        For example ``steel on steel`` and ``dry``.
    static_friction, kinetic_friction : tuple of float or None
        Bands of mu_s and mu_d [1]; both ends are equal if the source gives one value, None if it gives none.
    restitution, impact_speed : tuple of float or None
        Bands of the normal coefficient of restitution [1] and of the impact speeds that it holds for [m/s].
    source, url : str
        Citation and web address; the address may be empty.
    note : str
        Remark on the row; may be empty.
    """

    pair: str
    condition: str
    static_friction: _Span | None
    kinetic_friction: _Span | None
    restitution: _Span | None
    impact_speed: _Span | None
    source: str
    url: str
    note: str


@cache
def rows() -> tuple[Row, ...]:
    """Return the catalogue."""
    table = files("vibro").joinpath(_TABLE).read_text(encoding="utf-8")
    return tuple(
        Row(
            pair=line["pair"],
            condition=line["condition"],
            static_friction=_band(line, "mu_s"),
            kinetic_friction=_band(line, "mu_d"),
            restitution=_band(line, "e"),
            impact_speed=_band(line, "impact", "_m_s"),
            source=line["source"],
            url=line["url"],
            note=line["note"],
        )
        for line in csv.DictReader(table.splitlines())
    )


def _band(line: Mapping[str, str], name: str, unit: str = "") -> _Span | None:
    low, high = line[f"{name}_low{unit}"], line[f"{name}_high{unit}"]
    return (float(low), float(high)) if low else None


def band_text(band: _Span | None) -> str:
    """Return a band in the syntax of ``vibro design``, or a dash for None."""
    if band is None:
        return "-"
    low, high = band
    return f"{low:g}" if low == high else f"{low:g}:{high:g}"


def find(words: str) -> tuple[Row, ...]:
    """Return the rows whose pair matches the given words.

    Parameters
    ----------
    words : str
        Part of a pair's name, or words of it in any order; an empty text matches every row.

    Returns
    -------
    tuple of Row
        In catalogue order.

    Raises
    ------
    InputError
        If no pair matches; it suggests the nearest names.
    """
    wanted = _folded(words)
    found = [row for row in rows() if wanted in _folded(row.pair)]
    found = found or [row for row in rows() if all(word in _folded(row.pair) for word in wanted.split())]
    if not found:
        raise _unknown_pair(words)
    return tuple(found)


def static_row(text: str) -> Row:
    """Return the row with static friction that a text names.

    Parameters
    ----------
    text : str
        ``pair``, ``pair, condition`` or ``pair, condition, source``; any distinctive part of the source
        suffices.

    Returns
    -------
    Row
        Its ``static_friction`` is not None.

    Raises
    ------
    InputError
        If no row matches, none of them has static friction, or several match; the hint then lists them.

    Examples
    --------
    >>> static_row("steel on steel, dry, lust").static_friction
    (0.12, 0.6)
    """
    pair, condition, source = (*map(_folded, text.split(",", 2)), "", "")[:3]
    of_pair = [row for row in rows() if _folded(row.pair) == pair]
    if not of_pair:
        raise _unknown_pair(text.split(",")[0])
    found = [row for row in of_pair if condition in ("", _folded(row.condition))]
    if not found:
        known = ", ".join(dict.fromkeys(row.condition for row in of_pair))
        raise InputError(f"{shown(text)}: this pair is listed as {known} alone", hint=_listed(of_pair))
    by_source = [row for row in found if source in _folded(row.source)]
    if not by_source:
        raise InputError(f"{shown(text)}: no source of this pair has that name", hint=_listed(found))
    with_static = [row for row in by_source if row.static_friction]
    if not with_static:
        raise InputError(
            f"{shown(text)}: the catalogue has no static friction for it",
            hint="give a number or a band of your own, such as 0.3:0.5",
        )
    if len(with_static) > 1:
        raise InputError(
            f"{shown(text)}: {len(with_static)} rows of the catalogue, name the source of one",
            hint=_listed(with_static),
        )
    return with_static[0]


def number_hint(text: str, field: str) -> str:
    """Return what the catalogue says about a pair of materials that was given in place of a number.

    Parameters
    ----------
    text : str
        Such as ``steel on steel``.
    field : str
        ``static_friction``, ``kinetic_friction`` or ``restitution``.

    Returns
    -------
    str
        For each condition the band that holds those of all sources, which disagree too much for vibro to
        choose; for an unknown pair the nearest ones.

    Examples
    --------
    >>> print(number_hint("wood on steel", "static_friction"))
    wood on steel has 0.45:0.75 (dry): choose from it; vibro friction wood on steel names sources
    """
    of_pair = [row for row in rows() if _folded(row.pair) == _folded(text)]
    if not of_pair:
        return _nearest(text) or "write it like 0.5; vibro friction lists pairs of materials"
    bands: dict[str, _Span] = {}
    for row in of_pair:
        if own := getattr(row, field):
            known = (*own, *bands.get(row.condition, ()))
            bands[row.condition] = min(known), max(known)
    pair, label = of_pair[0].pair, field.replace("_", " ")
    if not bands:
        return f"give a number: the catalogue has no {label} of {pair}"
    listed = ", ".join(f"{band_text(band)} ({condition})" for condition, band in bands.items())
    return f"{pair} has {listed}: choose from it; vibro friction {pair} names sources"


def _unknown_pair(text: str) -> InputError:
    hint = _nearest(text) or "vibro friction lists all pairs"
    return InputError(f"{shown(text)}: no such pair in the catalogue of friction", hint=hint)


def _nearest(text: str) -> str:
    """Suggest the pairs nearest to a text; empty if none is near."""
    pairs = dict.fromkeys(row.pair for row in rows())
    meant = did_you_mean(_folded(text)[:60], pairs, most=3, cutoff=0.3)
    return f"{meant} vibro friction lists all pairs" if meant else ""


def _listed(several: Sequence[Row]) -> str:
    """Return one line per row that shows the text which selects it."""
    short = [re.split(r"[,(]", row.source)[0].strip() for row in several]
    return "\n".join(
        f'write "{row.pair}, {row.condition}, {name if _is_one(name, row, several) else row.source}"'
        f" for mu_s {band_text(row.static_friction)}, mu_d {band_text(row.kinetic_friction)}"
        for row, name in zip(several, short, strict=True)
    )


def _is_one(name: str, row: Row, several: Iterable[Row]) -> bool:
    same = [other for other in several if other.condition == row.condition]
    return sum(_folded(name) in _folded(other.source) for other in same) == 1


def _folded(text: str) -> str:
    return " ".join(_SYNONYMS.get(word, word) for word in text.casefold().split())
