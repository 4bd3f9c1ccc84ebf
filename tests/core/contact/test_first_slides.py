"""Where cycles coexist, a body on an elliptical drive gets the one that it comes to from rest at phase 0."""

from __future__ import annotations

from itertools import islice

import numpy as np
import pytest
from two_axis_scenes import Drives, drives, random_drives
from two_axis_walk import NeverEndsError
from vibro.core.contact.first_slides import first_from_rest
from vibro.core.contact.onset import thresholds
from vibro.core.contact.starts import pair_of

# Loads X w^2/g and Y w^2/g, lead [rad], mu_s, mu_d, trough angle [rad]: phase 0 lies inside the forward
# window, late enough for the slide from there not to outlast the back window as that from its onset does.
LATE = [
    (0.035078004855695004, 0.9369076525784381, 1.6439811358949825, 0.06540132750691191, 0.006086180619499455,
     -0.006011990038374929),
    (0.05148122204769334, 0.9891420589239103, 1.5624640529169769, 0.1297837233247174, 0.005136760479272244,
     -0.005123629877855466),
]  # fmt: skip


def first_ways(some: Drives) -> np.ndarray:
    scene = some.scene().flat().loads()
    return first_from_rest(scene, pair_of(scene, thresholds(scene).margins))


@pytest.mark.parametrize("late", LATE)
def test_a_late_start_in_a_window_leads_to_another_cycle_than_a_start_from_rest(
    late: tuple[float, ...],
) -> None:
    some = drives(*late)
    (body,) = some.bodies()
    assert body.settle().pattern == "FB" == some.solve().pattern[0]
    (body,) = some.bodies()
    body.p, body.way = body.opens[1], 1
    assert body.settle().pattern == "F_"
    assert some.solve().coexists[0] == 1
    assert first_ways(some)[0] == 0


def test_on_a_level_trough_the_first_slide_goes_forward() -> None:
    some = random_drives(3000, 43, throw=(0.5, 0.999))
    both = (some.solve().forward_ratio > 1.0) & (some.solve().back_ratio > 1.0)
    assert np.count_nonzero(both) > 1000
    assert np.all(first_ways(Drives(*(x[both] for x in some))) == 1)


def test_on_an_incline_it_is_that_of_the_walk() -> None:
    some = random_drives(8_000, 44, throw=(0.9, 0.999))
    some = some.changed(trough=0.95 * np.sign(some.lead) * np.arctan(some.mu_d))
    cycle = some.solve()
    both = (cycle.forward_ratio > 1.0) & (cycle.back_ratio > 1.0)
    some = Drives(*(x[both] for x in some))
    ways = first_ways(some)
    seen = set()
    for way in (1, -1, 0):
        for i in np.flatnonzero(ways == way)[:25]:
            (body,) = Drives(*(x[[i]] for x in some)).bodies()
            try:
                kinds = "".join(leg.kind for leg in islice(body.legs(), 200))
            except NeverEndsError:
                continue
            slides = [kinds[j + 1] for j in range(len(kinds) - 1) if kinds[j] == "_"]
            assert {"F": 1, "B": -1}[slides[0]] == way if slides else way == 0
            seen.add(way)
    assert seen >= {1, -1}
