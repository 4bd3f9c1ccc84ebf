"""Questions of inverse design that nobody would ask: understood, or refused in lines."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
from helpers.questions import PLACES, changed
from helpers.wild import KEY, TOML_VALUE, exactly
from hypothesis import given
from hypothesis import strategies as st

from vibro.designs.questions import Spec
from vibro.designs.reading import read_spec
from vibro.errors import InputError


def check(spec: Spec) -> None:
    """Check what everybody may rely on."""
    static, trough = spec.bands["static_friction"], spec.bands["trough_angle"]
    assert set(spec.bands) - {"static_friction", "trough_angle"} in ({"friction_ratio"}, {"kinetic_friction"})
    for low, high in spec.bands.values():
        assert -math.inf < low <= high < math.inf
    assert static[0] > max(math.tan(abs(end) + spec.drift.trough_angle) for end in trough) >= 0.0
    assert spec.drives
    assert len({drive.name for drive in spec.drives}) == len(spec.drives)
    for drive in spec.drives:
        low, high = drive.span("amplitude")
        assert 0.0 <= low <= high < math.inf
        assert high > 0.0
        assert drive.acceleration > 0.0
        assert all(0.0 < low <= high < math.inf for low, high in drive.frequency)
        assert drive.frequency
        assert drive.choices["drive_angle"]
        for low, high in drive.choices["drive_angle"]:
            assert 0.0 <= low <= high
            assert high + spec.drift.drive_angle + trough[1] + spec.drift.trough_angle < math.pi / 2
    assert 0.0 < spec.goal.speed < math.inf
    assert 0.0 <= spec.drift.amplitude < 1.0
    assert 0.0 <= spec.drift.frequency < 1.0


def check_answer(source: Any) -> None:
    """Check what is understood, or the message that says why it is not."""
    lines = []
    try:
        check(read_spec(source))
    except InputError as exc:
        lines = [*exc.problems, *exc.hint.splitlines()]
    assert all(line.strip() and line.isprintable() for line in lines), lines


OWN_KEY = st.sampled_from([key for _, key in PLACES])
HEADING = st.sampled_from(
    [
        "[scene]",
        "[[drive]]",
        "[drive]",
        "[drift]",
        "[goal]",
        "[part]",
        "[map]",
        "",
        "[[goal]]",
        "[scene.goal]",
    ]
)
LINE = st.tuples(st.one_of(OWN_KEY, OWN_KEY, KEY), TOML_VALUE).map(" = ".join)


@exactly("texts")
@given(st.lists(st.tuples(HEADING, st.lists(LINE, max_size=4)), max_size=4))
def test_any_file_is_understood_or_refused_in_lines(
    tmp_path: Path, sections: list[tuple[str, list[str]]]
) -> None:
    path = tmp_path / "wild.toml"
    text = "\n".join("\n".join([heading, *lines]) for heading, lines in sections)
    path.write_text(text, encoding="utf-8", errors="surrogatepass")
    check_answer(path)


NUMBER = st.one_of(st.floats(), st.floats(0.0, 100.0), st.integers(), st.integers(0, 90))
ENDS = st.tuples(st.floats(0.0, 60.0), st.floats(0.0, 60.0)).map(lambda ends: "{:.4g}:{:.4g}".format(*ends))
VALUE = st.recursive(
    st.one_of(NUMBER, ENDS, st.none(), st.booleans(), st.text(max_size=5), st.sampled_from(
        ["steel on steel, dry, lust", "brass on steel", "wood on steel", "hopping", "0.1:0.2:3", "1mm", "5%"]
    ), st.binary(max_size=2), st.just(np.array([1.0, 2.0])), st.just(object())),
    lambda some: st.one_of(st.lists(some, max_size=2), st.dictionaries(OWN_KEY, some, max_size=2)),
    max_leaves=3,
)  # fmt: skip
PLAUSIBLE = st.one_of(st.floats(0.3, 1.0), st.floats(0.3, 1.0).map("0.3:{:.4g}".format))


@exactly("texts")
@given(st.dictionaries(st.sampled_from(PLACES), st.one_of(VALUE, PLAUSIBLE), min_size=1, max_size=2))
def test_a_good_question_with_anything_in_it_is_understood_or_refused(
    entries: dict[tuple[str, str], Any],
) -> None:
    content = changed(**{f"{table}__{key}": value for (table, key), value in entries.items()})
    check_answer(content)
