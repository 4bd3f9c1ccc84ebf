"""Bodies at rest on an elliptical trough about to throw them: which way they slide, how fast they leave."""

from __future__ import annotations

import math

import numpy as np
import pytest
from integrated import TURN, Body
from scenes import Groups

from vibro.core.codes import Mode
from vibro.core.contact.legs import loads_at, mode_of, track_of, until
from vibro.core.flight.returns import velocity_from_rest
from vibro.core.groups import Lead, Loads

SIZE = 120
RANDOM = np.random.default_rng(11)
THROW = 1.0 + 10.0 ** RANDOM.uniform(-2.0, 0.6, SIZE)
DRIVE = np.radians(RANDOM.uniform(10.0, 80.0, SIZE))
TROUGH = np.radians(RANDOM.choice((0.0, -7.0, 7.0), SIZE))
LEAD = RANDOM.uniform(-math.pi, math.pi, SIZE)
MU_S = RANDOM.uniform(0.2, 1.0, SIZE)
MU_D = MU_S * RANDOM.uniform(0.2, 1.0, SIZE)


def loads() -> Loads:
    weight = np.sin(DRIVE) / THROW  # over the hypotenuse of the amplitudes, as the integrated body has it
    along, across, tangential = np.cos(DRIVE), np.sin(DRIVE), weight * np.tan(TROUGH)
    contrast = along * weight - across * tangential
    lead = Lead(np.sin(LEAD), np.cos(LEAD))
    return Loads(along, across, weight, tangential, contrast, MU_S, MU_D, lead)


def test_bodies_at_rest_begin_to_slide_where_the_load_exceeds_static_friction() -> None:
    scene = loads()
    track = track_of(scene)
    for way, onset in ((1, track.forward_onset), (-1, track.back_onset)):
        exists = np.isfinite(onset)
        assert exists.sum() > SIZE // 2
        for shift, sign in ((-1e-6, -1.0), (1e-6, 1.0)):
            load, normal = loads_at(scene, onset + shift)
            beyond = way * load - MU_S * normal
            assert (sign * beyond[exists] > 0.0).all()
        _, normal = loads_at(scene, onset + 1e-6)
        modes = mode_of(scene, onset + 1e-6, np.zeros(SIZE))[exists & (normal > 0.0)]
        assert (modes == (Mode.FORWARD if way > 0 else Mode.BACK)).all()


def test_before_lift_off_bodies_slide_the_way_of_the_load_there() -> None:
    scene = loads()
    track = track_of(scene)
    load, normal = loads_at(scene, track.lift_off)
    assert normal == pytest.approx(np.zeros(SIZE), abs=1e-15)
    modes = mode_of(scene, track.lift_off - 1e-6, np.zeros(SIZE))
    assert (modes == np.where(load > 0.0, Mode.FORWARD, Mode.BACK)).all()
    assert min((load > 0.0).sum(), (load < 0.0).sum()) > SIZE // 5
    velocity = velocity_from_rest(track)
    # bodies that slid the other way before may not have stopped yet
    against = velocity * load < 0.0
    assert 0 < against.sum() < SIZE // 4


def test_the_velocity_at_the_first_lift_off_is_that_of_the_integrated_body() -> None:
    track = track_of(loads())
    velocity, wait = velocity_from_rest(track), until(track.lift_off, LEAD)
    bears = THROW * np.sin(LEAD) < 1.0
    assert bears.sum() > SIZE // 2
    for i in np.flatnonzero(bears):
        load = THROW[i] * math.cos(TROUGH[i]) / math.sin(DRIVE[i])
        angles = math.degrees(DRIVE[i]), MU_S[i], MU_D[i], math.degrees(TROUGH[i])
        body = Body(Groups(load, *angles), lead=float(LEAD[i]))
        body._stick()
        body.until(float(wait[i]))
        assert velocity[i] == pytest.approx(body.state[1], abs=1e-9), i
    assert (wait[bears] < TURN).all()
