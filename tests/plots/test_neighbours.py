"""What surrounds the points of a grid, against SciPy's filters of two dimensions."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from scipy import ndimage

from vibro.plots.neighbours import dilate, erode, fill_unknown

SHAPES = [(1, 1), (1, 40), (20, 9), (61, 47)]
SHARES = [0.0, 0.02, 0.3, 0.98, 1.0]
MASKS = [
    np.random.default_rng(i).random(shape) < share
    for i, (shape, share) in enumerate(itertools.product(SHAPES, SHARES))
]


@pytest.mark.parametrize("width", [1, 5, 15])
def test_windows_are_squares_of_ones(width: int) -> None:
    square = np.ones((width, width), np.bool_)
    for mask in MASKS:
        np.testing.assert_array_equal(dilate(mask, width), ndimage.binary_dilation(mask, square))
        for beyond in (False, True):
            expected = ndimage.binary_erosion(mask, square, border_value=beyond)
            np.testing.assert_array_equal(erode(mask, width, beyond=beyond), expected)


def test_known_points_stay_and_every_other_takes_one_of_theirs() -> None:
    for mask in MASKS:
        values = np.random.default_rng(0).uniform(1.0, 2.0, mask.shape)
        filled = fill_unknown(values, mask)
        np.testing.assert_array_equal(filled[mask], values[mask])
        assert np.isin(filled, values[mask] if mask.any() else [0.0]).all()
