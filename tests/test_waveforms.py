"""Motions of the trough: what is read, merged, removed and refused, and how far they reach."""

from __future__ import annotations

import pickle
from typing import Any

import numpy as np
import pytest
from helpers.cases import each

from vibro import Motion, SceneError
from vibro.drives import MOST_PIECES, HarmonicMotion, PiecewiseMotion
from vibro.records.trough import measured_motion, trough_motion

SLIP_STICK = [(0.8, 6.9), (0.2, -27.6)]


def steps(along: Any = None, normal: Any = None) -> PiecewiseMotion:
    motion = Motion.steps(along, normal)
    assert isinstance(motion, PiecewiseMotion)
    return motion


def sampled(samples: Any, **options: Any) -> Motion:
    return Motion.samples(along=samples, **options)


def test_steps_are_pieces_of_constant_acceleration() -> None:
    motion = steps(along=SLIP_STICK)
    assert motion.breaks.tolist() == [0.0, 0.8, 1.0]
    np.testing.assert_allclose(motion.pieces[0, :, 0], [6.9, -27.6], rtol=1e-15)
    assert not motion.pieces[1].any()
    assert not motion.pieces[..., 1:].any()
    assert not motion.pieces.flags.writeable
    again = pickle.loads(pickle.dumps(motion))
    np.testing.assert_array_equal(again.pieces, motion.pieces)


def test_steps_of_both_directions_are_cut_at_the_breaks_of_either() -> None:
    normal = [(0.1, 2.0), (0.7, -1.0), (0.2, 2.5)]  # 0.1 + 0.7 is 0.7999999999999999
    motion = steps(along=SLIP_STICK, normal=normal)
    np.testing.assert_allclose(motion.breaks, [0.0, 0.1, 0.8, 1.0], rtol=1e-15)
    np.testing.assert_allclose(motion.pieces[0, :, 0], [6.9, 6.9, -27.6], rtol=1e-15)
    np.testing.assert_allclose(motion.pieces[1, :, 0], [2.0, -1.0, 2.5], rtol=1e-14)
    shares = np.array([0.05, 0.5, 0.9, 1.05, -0.1])
    np.testing.assert_allclose(motion.accelerations(shares)[1], [2.0, -1.0, 2.5, 2.0, 2.5], rtol=1e-14)


def means(motion: PiecewiseMotion) -> Any:
    return (motion.pieces / [1, 2, 3, 4]).sum(axis=-1) @ np.diff(motion.breaks)


def test_a_small_mean_is_removed_and_a_large_one_refused_with_what_would_close_the_cycle() -> None:
    steps(along=[(0.5, 1.0), (0.5, -0.9802)])  # a mean of 0.99 % of the largest
    motion = steps(along=[(0.8, 6.9), (0.2, -27.5)])
    np.testing.assert_allclose(motion.pieces[0, :, 0], [6.88, -27.52], rtol=1e-14)
    assert np.abs(means(motion)).max() <= 1e-15 * 27.6
    with pytest.raises(SceneError, match=r"along = .* 0\.0101 m/s"):
        Motion.steps(along=[(0.5, 1.0), (0.5, -0.9798)])  # 1.01 %


def test_shares_add_up_to_one() -> None:
    motion = steps(along=[(0.5 + 0.9e-9, 1.0), (0.5, -1.0)])
    assert motion.breaks[-1] == 1.0
    assert motion.breaks[1] == pytest.approx(0.5 + 0.45e-9, abs=1e-15)
    with pytest.raises(SceneError, match=r"along = .* 1\.000000001 "):
        Motion.steps(along=[(0.5 + 1.1e-9, 1.0), (0.5, -1.0)])


def test_the_most_pieces_of_both_directions() -> None:
    count = MOST_PIECES // 2
    half = [(1.0 / count, 1.0), (1.0 / count, -1.0)] * (count // 2)
    shifted = [(0.5 / count, 1.0), *half[:-1], (0.5 / count, -1.0)]
    motion = steps(half, shifted)
    assert motion.breaks.size == MOST_PIECES + 1
    assert np.abs(means(motion)).max() <= 1e-15
    longer = [(0.25 / count, 1.0), (0.25 / count, -1.0), *shifted[1:]]
    with pytest.raises(SceneError, match="normal = 4097 "):
        Motion.steps(half, longer)


def test_accelerations_are_joined_by_a_periodic_spline_without_their_mean() -> None:
    share = np.arange(32) / 32
    wave = 3.0 * np.sin(2.0 * np.pi * share) + np.sin(4.0 * np.pi * share + 1.0)
    motion = Motion.samples(along=wave + 9.81, normal=wave)
    assert isinstance(motion, PiecewiseMotion)
    np.testing.assert_allclose(motion.accelerations(share), [wave, wave], rtol=0, atol=1e-14 * 9.81)
    fine = np.arange(1000) / 1000
    truth = 3.0 * np.sin(2.0 * np.pi * fine) + np.sin(4.0 * np.pi * fine + 1.0)
    # A cubic spline is off by at most 5/384 of the fourth derivative times the fourth power of the spacing.
    bound = 5.0 / 384.0 * (3.0 + 16.0) * (2.0 * np.pi / 32.0) ** 4
    assert 0.01 * bound < np.abs(motion.accelerations(fine)[0] - truth).max() <= bound
    assert np.abs(means(motion)).max() <= 1e-15 * 4.0
    ends = motion.pieces.sum(axis=-1)
    np.testing.assert_allclose(ends[:, -1], motion.pieces[:, 0, 0], atol=1e-14)


def test_displacements_become_the_harmonics_that_they_bear() -> None:
    share = np.arange(100) / 100
    pairs = [(1e-3, 0.3), (0.0, 0.0), (2e-4, -2.0)]
    wave = sum(x * np.sin(2.0 * np.pi * k * share + phase) for k, (x, phase) in enumerate(pairs, 1))
    motion = sampled(5.0 + wave, of="displacement")
    assert isinstance(motion, HarmonicMotion)
    assert motion.normal == ()
    got = np.array(motion.along)
    assert got.shape == (3, 2)
    np.testing.assert_allclose(got[:, 0], [1e-3, 0.0, 2e-4], atol=1e-15)
    np.testing.assert_allclose(np.exp(1j * got[::2, 1]), np.exp([0.3j, -2.0j]), atol=1e-10)


def test_harmonics_that_are_noise_are_left_out() -> None:
    """Of noise alone beyond the third, one harmonic in a thousand is taken for one that is there."""
    rng = np.random.default_rng(2)
    share = np.arange(256) / 256
    wave = np.sin(2.0 * np.pi * share) + 0.1 * np.sin(6.0 * np.pi * share)
    orders = [
        len(motion.along)
        for _ in range(200)
        if isinstance(
            motion := sampled(wave + 0.01 * rng.standard_normal(256), of="displacement"), HarmonicMotion
        )
    ]
    assert len(orders) == 200
    assert np.count_nonzero(np.array(orders) == 3) >= 190
    assert min(orders) == 3


def motion_at(motion: PiecewiseMotion, shares: Any) -> Any:
    from vibro.drives import values_at

    return values_at(motion.positions, motion.breaks, shares)


@each("seed", range(6))
def test_extremes_of_pieces_are_not_missed(seed: int) -> None:
    rng = np.random.default_rng(seed)
    if seed % 2:
        motion: Any = Motion.samples(rng.standard_normal(8 + seed), rng.standard_normal(8 + seed))
    else:
        shares = rng.dirichlet(np.ones(3 + seed // 4), 2)
        levels = rng.standard_normal(shares.shape)
        levels -= (shares * levels).sum(axis=1, keepdims=True)
        motion = Motion.steps(*(list(zip(s, a, strict=True)) for s, a in zip(shares, levels, strict=True)))
    fine = np.arange(4000) / 4000
    fine = np.union1d(fine, motion.breaks[:-1])
    a, r = motion.accelerations(fine), motion_at(motion, fine)
    for got, points in ((motion.largest_acceleration, a), (motion.reach, r)):
        sizes = np.hypot(*points)
        assert got >= sizes.max() * (1.0 - 1e-14)
        assert got == pytest.approx(sizes.max(), rel=1e-4)
    distances = np.hypot(*(x[::4, np.newaxis] - x for x in r))
    assert motion.stroke >= distances.max() * (1.0 - 1e-14)
    assert motion.stroke == pytest.approx(distances.max(), rel=1e-4)


def test_a_measured_motion_has_the_harmonics_of_its_record() -> None:
    record = "examples/data/nut_trough_mv.csv"
    columns: dict[str, Any] = {
        "trough_along": "Trog längs",
        "trough_normal": "Trog normal",
        "sensitivity": "100mV/g",
    }
    motion, measured = trough_motion(record, **columns), measured_motion(record, **columns)
    assert isinstance(motion, HarmonicMotion)
    for way, expected in ((motion.along, measured.along), (motion.normal, measured.normal)):
        assert [float(size) for size, _ in way] == pytest.approx(np.abs(expected).tolist(), rel=1e-15)
        assert [float(phase) for _, phase in way] == pytest.approx(np.angle(expected).tolist(), abs=1e-15)
