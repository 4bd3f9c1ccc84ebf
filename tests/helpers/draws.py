"""How many random draws, or examples, a test takes: 25 times as many with --hypothesis-profile=thorough."""

from __future__ import annotations

from hypothesis import settings

_USUAL = 40  # examples of the usual profile (tests/conftest.py)


def draws(count: int) -> int:
    """Return a count for the profile that is loaded."""
    return max(1, round(count * settings().max_examples / _USUAL))


def examples(count: int) -> settings:
    """Let a test have so many examples, in place of 40."""
    return settings(max_examples=draws(count))
