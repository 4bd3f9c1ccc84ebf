"""The codes of results: which statuses have numbers, how patterns are spelt, and that they need no NumPy."""

from __future__ import annotations

import subprocess
import sys

import numpy as np
import pytest

from vibro.core.codes import (
    IRREGULAR,
    LETTERS,
    SPELT_PATTERNS,
    Mode,
    Pattern,
    Status,
    is_answered,
    pattern_texts,
    spelt_code,
    spelt_text,
)


def test_cells_with_these_statuses_have_numbers() -> None:
    assert {status for status in Status if status.answered} == {Status.OK, Status.BOUNDARY, Status.AVERAGED}
    codes = np.array([[status, Status.OK] for status in Status], np.int8)
    assert is_answered(codes).tolist() == [[status.answered, True] for status in Status]


def test_hopping_patterns_are_spelt_by_their_digits() -> None:
    assert [LETTERS[mode] for mode in Mode] == ["H", "F", "B", "_"]
    assert [spelt_text(digits) for digits in (0, 1, 1 * 25 + 2 * 5 + 4)] == ["", "H", "HF_"]
    codes = np.array([[0, Pattern.F_B, SPELT_PATTERNS + 1], [-1, SPELT_PATTERNS + 9, Pattern.R]])
    assert pattern_texts(codes, {}).tolist() == [["", "F_B", "H"], ["H...", "H_", "_"]]


def test_a_long_pattern_has_a_code_of_all_its_letters() -> None:
    fits = "HB" * 13 + "F"
    assert spelt_text(spelt_code(fits) - SPELT_PATTERNS) == fits
    assert spelt_code(fits) < 2**63
    longer = [fits + letter for letter in "HFB_"]
    codes = [spelt_code(text) for text in longer]
    assert len(set(codes)) == len(codes)
    assert all(-(2**63) <= code < IRREGULAR for code in codes)
    known = dict(zip(codes, longer, strict=True))
    assert pattern_texts(np.array(codes), known).tolist() == longer
    with pytest.raises(KeyError):
        pattern_texts(np.array([codes[0] + 1]), known)


def test_the_enums_load_no_numpy() -> None:
    code = "import sys, vibro.core.codes; print('numpy' in sys.modules)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "False"
