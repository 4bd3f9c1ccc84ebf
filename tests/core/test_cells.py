"""Zeros and largest values of waves beside the roots of their polynomials, double zeros included."""

from __future__ import annotations

import math
from typing import Any

import mpmath as mp
import numpy as np
import pytest
from helpers.draws import draws
from helpers.waves import (
    coefficients_of,
    drawn_harmonics,
    drawn_pieces,
    harmonic_value,
    harmonic_waves,
    piecewise_value,
    piecewise_waves,
)

from vibro.core.cells import behind, find_nodes, largest, next_event, number_of_nodes
from vibro.core.numbers import TURN
from vibro.core.waves import FORCE, Mix, Waves, nodes_of

EPS = 2.0**-52
ALONG = Mix(0.0, 1.0, 0.0)
CIRCLE = 1e-9  # distance from the unit circle below which a well-separated root lies on it
DOUBT = 1e-4  # ... and up to which rounding of the roots may have taken one of two near ones
ROUNDED = 1e-7  # ... and up to which rounding of the wave itself may have


def _nodes(waves: Waves, mix: Mix) -> list[float]:
    find_nodes(waves, FORCE, mix)
    start = nodes_of(waves, FORCE)
    return list(waves.number[start : start + number_of_nodes(waves, FORCE)])


def _roots(coefficients: Any, constant: float) -> Any:
    """Return the roots of z^H times a wave, z = exp(i p)."""
    half = -0.5j * coefficients
    return np.roots(np.concatenate((half[::-1], [constant], np.conj(half))))


def _exact_roots(coefficients: Any, constant: float) -> Any:
    """Return the same roots from 50 digits, rounded; those on the circle are on it to rounding."""
    half = [mp.mpc(0, -0.5) * mp.mpc(x) for x in coefficients.tolist()]
    with mp.workdps(50):
        polynomial = [*half[::-1], mp.mpf(constant), *(mp.conj(x) for x in half)]
        return np.array([complex(x) for x in mp.polyroots(polynomial, maxsteps=500, extraprec=400)])


def _slope(coefficients: Any) -> Any:
    return 1j * np.arange(1, len(coefficients) + 1) * coefficients


def _turn_of(roots: Any) -> list[float]:
    return sorted((np.angle(roots) % TURN).tolist())


def _agree(one: list[float], other: list[float], within: float) -> bool:
    """Whether phases are the same but for rounding, also across phase 0."""
    if len(one) != len(other):
        return False
    if not one:
        return True
    a, b = np.array(one), np.array(other)
    apart = min(np.abs(np.angle(np.exp(1j * (a - np.roll(b, shift))))).max() for shift in (-1, 0, 1))
    return bool(apart <= within)


@pytest.mark.parametrize("harmonics", range(1, 17))
def test_zeros_are_the_roots_on_the_unit_circle(harmonics: int) -> None:
    """In 400 waves; roots next to the circle are looked at with 50 digits."""
    rng = np.random.default_rng(harmonics)
    for _ in range(draws(25)):
        waves = harmonic_waves(drawn_harmonics(rng, harmonics), np.zeros(harmonics, complex))
        c = coefficients_of(waves, normal=False)
        size = float(np.abs(c).sum())
        constant = float(rng.choice([0.0, rng.uniform(-1.1, 1.1) * size, rng.normal() * 0.3 * size]))
        roots = _roots(c, constant)
        off = np.abs(np.abs(roots) - 1.0)
        if ((off > CIRCLE) & (off < DOUBT)).any():
            roots = _exact_roots(c, constant)
            off = np.abs(np.abs(roots) - 1.0)
            assert not ((off > CIRCLE) & (off < ROUNDED)).any()  # else no double could tell
        mix = Mix(constant, 1.0, 0.0)
        found = _nodes(waves, mix)
        assert _agree(found, _turn_of(roots[off <= CIRCLE]), 1e-7)
        assert found == sorted(found)
        if found:
            at = np.array(found)
            assert np.abs(harmonic_value(c, at, constant)).max() <= 32.0 * EPS * harmonics * (
                size + abs(constant)
            )
            between = 0.5 * (at + np.append(at[1:], at[0] + TURN))
            signs = harmonic_value(c, between, constant) > 0.0
            assert signs.tolist() == [behind(waves, FORCE, i) for i in range(len(found))]
        else:
            assert (waves.mark[2 * FORCE + 1] == 1) is (constant > 0.0)


@pytest.mark.parametrize("harmonics", [2, 5, 10, 16])
@pytest.mark.parametrize("side", [-1, 0, 1], ids=["below", "at", "above"])
def test_zeros_that_nearly_touch_are_two_or_none(harmonics: int, side: int) -> None:
    """Waves (1 - cos(p - a)) g(p) + gap, g of degree H - 1: 156 of them, gaps of 1e-12 to 1e-8."""
    rng = np.random.default_rng(100 * harmonics + side)
    checked = 0
    for _ in range(13):
        a = rng.uniform(0.0, TURN)
        g = drawn_harmonics(rng, harmonics - 1)
        mean = float(rng.uniform(-1.0, 1.0)) * float(np.abs(g).sum())
        at = float(harmonic_value(g, a, mean))
        g, mean = g / at, mean / at
        # products of complex coefficients from -H to H, of which the wave is the real part
        spectrum = np.concatenate((np.conj(0.5 * -1j * g)[::-1], [mean], 0.5 * -1j * g))
        turn = np.exp(-1j * a)
        whole = np.convolve(spectrum, [-0.5 * np.conj(turn), 1.0, -0.5 * turn])
        middle = len(whole) // 2
        constant, c = float(whole[middle].real), 2j * whole[middle + 1 :]
        size = float(np.abs(c).sum()) + abs(constant)
        if size > 100.0:
            continue
        gap = side * 10.0 ** rng.uniform(-12.0, -8.0) * size
        waves = harmonic_waves(c, np.zeros(harmonics, complex))
        found = _nodes(waves, Mix(constant + gap, 1.0, 0.0))
        apart = [abs(math.remainder(x - a, TURN)) for x in found]
        expected = math.sqrt(2.0 * abs(gap))  # as g(a) = 1
        near = 2.0 * expected if side else 1e-5
        touching = [x for x in apart if x <= near]
        assert len(touching) in {-1: {2}, 0: {0, 2}, 1: {0}}[side]
        if side < 0:
            assert touching == pytest.approx([expected, expected], rel=0.1)
        roots = _roots(c, constant + gap)
        window = max(2.0 * near, 1e-3)
        away = np.abs(roots - np.exp(1j * a)) > window
        if (~away).sum() > 2:
            continue
        checked += 1
        others = [x for x, y in zip(found, apart, strict=True) if y > window]
        assert _agree(others, _turn_of(roots[away & (np.abs(np.abs(roots) - 1.0) < 1e-7)]), 1e-6)
    assert checked >= 6


@pytest.mark.parametrize("harmonics", range(1, 17))
def test_the_largest_value_is_that_of_the_highest_turning_point(harmonics: int) -> None:
    rng = np.random.default_rng(200 + harmonics)
    for _ in range(12):
        waves = harmonic_waves(drawn_harmonics(rng, harmonics), drawn_harmonics(rng, harmonics))
        mix = Mix(*rng.normal(size=3))
        c = mix.along * coefficients_of(waves, normal=False)
        c = c + mix.normal * coefficients_of(waves, normal=True)
        turning = np.angle(_roots(_slope(c), 0.0))
        expected = float(harmonic_value(c, turning, mix.constant).max())
        size = float(np.abs(c).sum()) + abs(mix.constant)
        assert largest(waves, mix) == pytest.approx(expected, rel=0.0, abs=8.0 * EPS * harmonics * size)


def test_jumps_are_zeros_where_the_sign_changes() -> None:
    rng = np.random.default_rng(9)
    for i in range(96):
        count = 1 + i % 12
        breaks, pieces = drawn_pieces(rng, count)
        waves = piecewise_waves(breaks, pieces)
        mix = Mix(float(rng.normal() * 0.5), 1.0, float(rng.normal()))
        mixed = -(mix.along * pieces[0] + mix.normal * pieces[1])
        mixed[:, 0] += mix.constant
        events, highest = [], -math.inf
        for j in range(count):
            inside = [0.0]
            flat = mixed[j, :0:-1] * (3.0, 2.0, 1.0)
            for roots, kept in ((np.roots(mixed[j, ::-1]), True), (np.roots(flat), False)):
                real = roots[np.abs(roots.imag) < 1e-12].real
                real = real[(real > 0.0) & (real < 1.0)]
                inside += real.tolist() if kept else []
                highest = max(highest, *np.polyval(mixed[j, ::-1], [0.0, 1.0, *real]))
            events += [breaks[j] + u * (breaks[j + 1] - breaks[j]) for u in inside]
        events.sort()
        phases = TURN * np.array(events)
        middles = 0.5 * (phases + np.append(phases[1:], TURN))
        signs = piecewise_value(breaks, mixed, middles) > 0.0
        changes = phases[signs != np.roll(signs, 1)]
        assert _agree(_nodes(waves, mix), changes.tolist(), 1e-10)
        assert largest(waves, mix) == pytest.approx(highest, rel=1e-13)


def test_a_load_that_does_not_change_its_sign_has_no_zeros() -> None:
    waves = harmonic_waves(np.array([1.0 + 0j]), np.array([0.0 + 0j]))
    for constant, positive in ((1.0 + 1e-12, 1), (-1.0 - 1e-12, 0)):
        assert _nodes(waves, Mix(constant, 1.0, 0.0)) == []
        assert waves.mark[2 * FORCE + 1] == positive
        assert next_event(waves, FORCE, True, 0.0).wait == math.inf
    assert len(_nodes(waves, Mix(1.0 - 1e-12, 1.0, 0.0))) == 2
    still = harmonic_waves(np.zeros(3, complex), np.zeros(3, complex))
    assert _nodes(still, Mix(0.0, 1.0, 1.0)) == []
    assert largest(still, Mix(-0.5, 1.0, 1.0)) == -0.5


def test_the_next_event_is_the_nearest_ahead_and_one_that_is_reached_counts() -> None:
    waves = harmonic_waves(np.array([0.0, 1.0 + 0j]), np.zeros(2, complex))  # sin 2 p
    _nodes(waves, ALONG)
    assert next_event(waves, FORCE, True, 1.0).phase == pytest.approx(math.pi, rel=1e-15)
    assert next_event(waves, FORCE, True, 1.0).wait == pytest.approx(math.pi - 1.0, rel=1e-14)
    assert next_event(waves, FORCE, False, 1.0).wait == pytest.approx(0.5 * math.pi - 1.0, rel=1e-13)
    falls = next_event(waves, FORCE, False, 1.0).phase
    for behind_it, wait in ((0.0, 0.0), (0.9e-9, 0.0), (1.1e-9, math.pi)):
        assert next_event(waves, FORCE, False, falls + behind_it).wait == pytest.approx(wait, abs=2e-9)
    assert next_event(waves, FORCE, True, 6.0).wait == pytest.approx(TURN - 6.0, rel=1e-13)
