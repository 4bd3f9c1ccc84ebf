"""The steady contact cycle of drives beyond one harmonic: the return map of a motion without flights.

A body is followed through one drive cycle from an onset on, Eq. (36) of docs/theory: its velocity a turn
later never decreases with that at its start, and the fixed point to which a body at rest leads is the steady
motion. Lengths in A, speeds in A w, phases in radians.
"""

from __future__ import annotations

from typing import Final, NamedTuple

from vibro.core.cells import Event, behind, number_of_nodes
from vibro.core.codes import MOST_LETTERS, SPELT_PATTERNS, Mode, Model, Pattern, Regime, Status
from vibro.core.contact import Steady, unanswered, without_cycle
from vibro.core.drive import Loads
from vibro.core.legs import next_onset, track_of
from vibro.core.numbers import INF, TURN, Bytes
from vibro.core.return_map import (
    HoppingCycle,
    Hops,
    Orbit,
    attracts_all,
    cycle_from,
    followed,
    has_stop,
    hopping_cycle,
    is_closed,
    no_hops,
    only_orbit,
    orbit_from,
    others_on,
    return_map,
    write_letters,
)
from vibro.core.slides import Thresholds
from vibro.core.waves import STATIC_BACK, STATIC_FORWARD, nodes_of

_ROUNDS: Final = 4  # [cycle] after which a body is near its motion, or slow to come there
_MOST_WEIGHT: Final = 1e50  # [1] above which bodies slip next to no friction alone, and products overflow


class Classes(NamedTuple):
    """Legs of the steady contact cycle from rest.

    Attributes
    ----------
    pattern : int
        Digits of ``Mode``, as ``canonical`` gives them, or a negative mark; 0 where the cycle is unknown.
    forward, back, rest : bool
        Whether the body slides forward, slides back, and rests; none of them where the cycle is unknown.
    spare : float
        How far it is from other legs: ``Return.spare``; inf where that is not known.
    """

    pattern: int
    forward: bool
    back: bool
    rest: bool
    spare: float


class _Settled(NamedTuple):
    """A motion from rest: its cycle, its orbit, and the velocity with which the body enters the cycle.

    ``alone`` says that no other motion repeats, ``loose`` that a body may run away.
    """

    cycle: HoppingCycle
    home: Orbit
    start: float
    alone: bool
    loose: bool


def wave_cycle(loads: Loads, at: Thresholds, classes_alone: bool) -> Steady:
    """Solve the steady contact cycle from rest at phase 0; one that hops is left to the flight model."""
    none = without_cycle(loads, at)
    if none.status != Status.OK:
        return none
    status = int(Status.BOUNDARY) if at.edge else int(Status.OK)
    if _is_unbounded(at):
        return unanswered(Regime.UNDEFINED, Status.UNRESOLVED)
    if not (at.forward or at.back):
        return Steady(Regime.NO_SLIP, status, Pattern.R, Model.REST, 0.0, 0.0, int(_is_loose(loads)), 0.0)
    if _is_heavy(loads):
        return unanswered(Regime.UNDEFINED, Status.UNRESOLVED)
    settled = _settle(loads, at)
    cycle, home = settled.cycle, settled.home
    regime = _regime_of(_classes_of(cycle, home))
    if home.status != Status.OK and home.status != Status.BOUNDARY:
        return unanswered(regime if home.status == Status.RUNAWAY else Regime.UNDEFINED, home.status)
    if home.status == Status.BOUNDARY or _is_hidden(loads, at):
        status = int(Status.BOUNDARY)
    if classes_alone:
        return unanswered(regime, status)
    coexists = settled.loose or (not settled.alone and others_on(cycle, no_hops(), settled.start, home))
    return Steady(
        regime, status, _code_of(home.cycle.pattern), Model.SLIDES, home.cycle.displacement, home.cycle.peak,
        int(coexists), home.cycle.slope,
    )  # fmt: skip


def wave_classes(loads: Loads, at: Thresholds) -> Classes:
    """Tell which legs the steady contact cycle from rest has; a body that runs away slides for ever."""
    if _is_unbounded(at):
        return _unknown()
    if not (at.forward or at.back):
        return Classes(Mode.REST, forward=False, back=False, rest=True, spare=INF)
    if _is_heavy(loads):
        return _unknown()
    settled = _settle(loads, at)
    if settled.home.status == Status.UNRESOLVED:
        return _unknown()
    return _classes_of(settled.cycle, settled.home)


def write_contact_letters(loads: Loads, at: Thresholds, out: Bytes, room: int) -> int:
    """Write the legs of a steady cycle that ``wave_cycle`` has found; return their number."""
    settled = _settle(loads, at)
    return write_letters(settled.cycle, no_hops(), settled.home.velocity, out, room)


class Begin(NamedTuple):
    """Where a steady cycle begins, the velocity there, its status and its displacement.

    A body at rest begins anywhere.
    """

    phase: float
    velocity: float
    status: int
    displacement: float


def cycle_begin(loads: Loads, at: Thresholds) -> Begin:
    """Solve the steady contact cycle from rest, of which no more is wanted than where it begins."""
    none = without_cycle(loads, at)
    if none.status != Status.OK:
        return Begin(0.0, 0.0, none.status, 0.0)
    if _is_unbounded(at) or _is_heavy(loads):
        return Begin(0.0, 0.0, int(Status.UNRESOLVED), 0.0)
    status = int(Status.BOUNDARY) if at.edge else int(Status.OK)
    if not (at.forward or at.back):
        return Begin(0.0, 0.0, status, 0.0)
    settled = _settle(loads, at)
    if settled.home.status != Status.OK:
        status = settled.home.status
    home = settled.home
    return Begin(settled.cycle.landing, home.velocity, status, home.cycle.displacement)


def _unknown() -> Classes:
    return Classes(0, forward=False, back=False, rest=False, spare=INF)


def _is_loose(loads: Loads) -> bool:
    """Return whether gravity along the trough exceeds kinetic friction."""
    return abs(loads.weight_tangential) > loads.kinetic_friction * loads.weight_normal


def _is_unbounded(at: Thresholds) -> bool:
    """Return whether the largest loads were not found."""
    return not (at.forward_load < INF and at.back_load < INF)


def _is_heavy(loads: Loads) -> bool:
    return not loads.weight_normal + abs(loads.weight_tangential) < _MOST_WEIGHT


def _settle(loads: Loads, at: Thresholds) -> _Settled:
    """Follow a body from rest that slips, as ``at`` says.

    The cycle begins at the first onset, where bodies mostly rest, so that one turn tells most motions.
    """
    loose, hops, track = _is_loose(loads), no_hops(), track_of(loads, 0.0)
    ahead, behind = next_onset(track, 1.0, 0.0), next_onset(track, -1.0, 0.0)
    onset = ahead if ahead.wait <= behind.wait else behind
    if not onset.wait < INF:
        onset = Event(0.0, 0.0)  # rounding hides it, and the body rests
    cycle = hopping_cycle(track, 0, 0, onset.phase, TURN, TURN)
    start = return_map(track, hops, 0, 0, 0.0, onset.wait, 0.0).velocity
    # one-way bodies are in order, so that all are at rest when the fastest one stops
    alone = not loose and not (at.forward and at.back)
    home = followed(cycle, hops, start, 1)
    if home.status != Status.OK:
        alone = alone or (not loose and not _may_rest(cycle, hops, start))
        if alone:
            home = only_orbit(cycle, hops, home)
        else:
            home = followed(cycle, hops, home.cycle.velocity, _ROUNDS)
            if home.status != Status.OK:
                home = orbit_from(cycle, hops, start)
    if not (loose or alone) and has_stop(home.cycle):
        alone = attracts_all(cycle, hops, home, _ROUNDS)
    return _Settled(cycle, home, start, alone, loose)


def _is_hidden(loads: Loads, at: Thresholds) -> bool:
    """Return whether rounding hides a window of slip, as it may where that begins beneath many harmonics."""
    ahead, behind = loads.waves.mark[2 * STATIC_FORWARD + 1], loads.waves.mark[2 * STATIC_BACK + 1]
    none_ahead = number_of_nodes(loads.waves, STATIC_FORWARD) == 0 and ahead == 0
    none_behind = number_of_nodes(loads.waves, STATIC_BACK) == 0 and behind == 0
    return (at.forward and none_ahead) or (at.back and none_behind)


def _may_rest(cycle: HoppingCycle, hops: Hops, start: float) -> bool:
    """Return whether a body that rests until an onset may rest there again a turn later.

    If none does, no motion with a rest repeats, and there is one without a rest at most. The one that begins
    the cycle with the velocity ``start`` does not.
    """
    waves = cycle.track.loads.waves
    for row in range(STATIC_FORWARD, STATIC_BACK + 1):
        for i in range(number_of_nodes(waves, row)):
            begun = cycle._replace(landing=waves.number[nodes_of(waves, row) + i])
            known = start == 0.0 and begun.landing == cycle.landing
            if behind(waves, row, i) and not known and is_closed(begun, 0.0, cycle_from(begun, hops, 0.0)):
                return True
    return False


def _regime_of(classes: Classes) -> int:
    """Return the class of a cycle: any slide back counts; of one that runs away it is its way."""
    if classes.back:
        return Regime.BACK_SLIP
    return Regime.FORWARD_SLIP if classes.forward else Regime.NO_SLIP


def _classes_of(cycle: HoppingCycle, home: Orbit) -> Classes:
    """Tell the legs of a cycle; a body that runs away slides down for ever, whatever its first cycles are."""
    now = home.cycle
    if home.status == Status.RUNAWAY:
        down = cycle.track.loads.weight_tangential > 0.0
        return Classes(Mode.BACK if down else Mode.FORWARD, not down, down, rest=False, spare=INF)
    return Classes(canonical(now.pattern), now.forward, now.back, now.rest, now.spare)


def canonical(pattern: int) -> int:
    """Turn the legs of a cycle, digits to base 5, so that their number is least; a mark stays.

    A leg that the cycle begins amid is one with that at its end.
    """
    if pattern <= 5:
        return pattern
    power, left = 1, pattern
    for _ in range(MOST_LETTERS):
        if left < 5:
            break
        power, left = 5 * power, left // 5
    if left == pattern % 5 and left != Mode.FLIGHT:
        pattern, power = pattern // 5, power // 5
    least, turned = pattern, pattern
    length = power
    for _ in range(MOST_LETTERS):
        if length <= 1:
            break
        digit = turned // power
        turned = (turned - digit * power) * 5 + digit
        least = min(least, turned)
        length = length // 5
    return least


def _code_of(pattern: int) -> int:
    """Return the code of a contact pattern."""
    code = canonical(pattern)
    if code == Mode.FORWARD * 5 + Mode.REST:
        return Pattern.F_
    if code == Mode.BACK * 5 + Mode.REST:
        return Pattern.B_
    if code == ((Mode.FORWARD * 5 + Mode.REST) * 5 + Mode.BACK) * 5 + Mode.REST:
        return Pattern.F_B_
    if code == (Mode.FORWARD * 5 + Mode.BACK) * 5 + Mode.REST:
        return Pattern.FB_
    if code == (Mode.FORWARD * 5 + Mode.REST) * 5 + Mode.BACK:
        return Pattern.F_B
    if code == Mode.FORWARD * 5 + Mode.BACK:
        return Pattern.FB
    if code == Mode.REST:
        return Pattern.R
    return code + SPELT_PATTERNS if code > 0 else code
