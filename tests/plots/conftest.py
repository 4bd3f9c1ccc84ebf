"""Pictures that several tests look at."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pytest
from helpers import drawn
from helpers.drawn import OWN, pictures_of, sweep

from vibro.results.sweep import SweepResult

if TYPE_CHECKING:
    from collections.abc import Iterator

    from matplotlib.figure import Figure


@pytest.fixture
def unarranged() -> Iterator[None]:
    """Leave the axes of a test's own pictures where they happen to be."""
    with drawn.unarranged():
        yield


@pytest.fixture(scope="session")
def nut() -> SweepResult:
    return sweep(points=361, own=OWN, length=600, amplitude="0.1:3", frequency="5:60")


@pytest.fixture(scope="session")
def pictures(nut: SweepResult) -> dict[str, Figure]:
    return pictures_of(nut)


@pytest.fixture(scope="session")
def friction() -> SweepResult:
    return sweep(points=181, static_friction="0.2:1", kinetic_friction="0.2:1")


@pytest.fixture(scope="session")
def friction_pictures(friction: SweepResult) -> dict[str, Figure]:
    with drawn.unarranged():
        return pictures_of(friction)


@pytest.fixture(scope="session")
def climb() -> SweepResult:
    return sweep(points=181, length=600, amplitude="0.1:3", trough_angle="-15:15")


@pytest.fixture(scope="session")
def climb_pictures(climb: SweepResult) -> dict[str, Figure]:
    with drawn.unarranged():
        return pictures_of(climb)


@pytest.fixture(scope="session")
def facets() -> dict[str, Figure]:
    return pictures_of(
        sweep(own=OWN, points=81, amplitude="0.2:3", frequency="10:50", drive_angle="10,20,30")
    )


@pytest.fixture(scope="session")
def one_axis() -> SweepResult:
    return sweep(own=OWN, length=600, amplitude="0.1:4")


@pytest.fixture(scope="session")
def line_pictures(one_axis: SweepResult) -> dict[str, Figure]:
    return pictures_of(one_axis)
