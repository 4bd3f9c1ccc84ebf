"""One leg in contact: when a body at rest starts, and what rounding of a phase does to that."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scenes import at_load, loads_of
from vibro.core.contact.legs import mode_of, track_of, until

from vibro.core.codes import Mode

TURN = 2.0 * math.pi


def test_a_body_at_rest_starts_where_the_load_outgrows_static_friction() -> None:
    scene = loads_of(at_load([1.2], 20.0, 0.5, 0.4, 3.0))
    track = track_of(scene)
    for onset, mode in ((track.forward_onset, Mode.FORWARD), (track.back_onset, Mode.BACK)):
        assert mode_of(scene, onset - 1e-9, np.zeros(1))[0] == Mode.REST
        assert mode_of(scene, onset + 1e-9, np.zeros(1))[0] == mode


@pytest.mark.parametrize(
    ("load", "drive", "trough"), [(3.2, 73.0, -39.0), (1.8, 46.5, 40.1), (1.6, 65.2, 8.0)]
)
def test_a_body_that_its_drive_presses_down_never_starts_back_in_contact(
    load: float, drive: float, trough: float
) -> None:
    # Eq. (7) holds up to the lift-off at any throw number
    scene = loads_of(at_load([load], drive, 1.6, 0.8, trough))
    assert (scene.along < scene.static_friction * scene.across).all()
    assert np.isnan(track_of(scene).back_onset).all()
    phase = np.linspace(0.0, TURN, 20_001)
    touches = scene.normal > scene.across * np.sin(phase)
    assert touches.mean() > 0.5
    assert not (mode_of(scene, phase[touches], np.zeros(touches.sum())) == Mode.BACK).any()


def test_a_phase_a_rounding_after_an_event_is_at_the_event() -> None:
    event = np.array([0.3, 0.3, 0.3, 6.2831])
    phase = event + np.array([0.0, 1e-12, -1e-12, 8e-16])
    assert until(event, phase)[[0, 1, 3]].tolist() == [0.0, 0.0, 0.0]
    assert until(event, phase)[2] == pytest.approx(1e-12, abs=1e-15)
    assert until(event, event + 1e-6) == pytest.approx(TURN - 1e-6)
