"""The second harmonic that a body puts on its trough, fed back into the body's motion, Eq. (90).

The body's force at twice the frequency moves the trough, which thereby goes along its line as
Im(e^ip + z e^2ip) over the amplitude A of the first harmonic. That motion decides what the body does, and so
its force: A and z are sought with which both agree. Phases in radians.
"""

from __future__ import annotations

import math
from typing import Final, NamedTuple

from vibro.core.bounces import Flights
from vibro.core.cells import largest
from vibro.core.codes import Status
from vibro.core.drive import Loads, wave_loads
from vibro.core.filling import Reaction, Share, reaction_on_harmonics
from vibro.core.machines import Complex, over, plus, scaled, size_of, times
from vibro.core.numbers import HARMONICS, INF, MIXES, ROOM, Doubles, doubles, integers
from vibro.core.return_map import Hops
from vibro.core.waves import Mix, Waves, prepare_cells, read_harmonic, tabulate, with_bounds

_MOST: Final = 40  # evaluations; most operating points take five to eight
_AGREES: Final = 1e-12  # [1] residuals that are left, rounding of their sums apart
_LONGEST: Final = 0.05  # [1] step of ln A and of z together
_NUMBERS: Final = 4 * ROOM + 32  # that two harmonics need
_MARKS: Final = 2 * MIXES
_WORSE: Final = 2.0  # [1] growth of the residuals at which a step is halved


class Fed(NamedTuple):
    """An amplitude [m], what the body weighs there, and whether all agrees; if not, those of the sine."""

    amplitude: float
    share: Share
    agrees: bool


class Body(NamedTuple):
    """A body in a machine.

    Attributes
    ----------
    unit : Loads
        Of the body at G = 1, of a drive along a line.
    length : float
        Amplitude at which G is 1 [m].
    restitution : float
        Of the scene.
    flights, hops : Flights, Hops
        Scratch memory.
    """

    unit: Loads
    length: float
    restitution: float
    flights: Flights
    hops: Hops


def loads_at(body: Body, amplitude: float) -> Loads:
    """Return the groups of the scene at an amplitude [m]."""
    unit, weight = body.unit, body.length / amplitude  # 1/G
    return unit._replace(
        weight_normal=weight * unit.weight_normal,
        weight_tangential=weight * unit.weight_tangential,
        weight_across=weight * unit.weight_across,
    )


def feed_back(body: Body, empty: float, pull: Complex, second_pull: Complex, sine: Fed) -> Fed:
    """Find the operating point with the second harmonic fed back, from that under a sine on.

    Broyden's method for the zeros of ln(A abs(1 + m H lambda) / A_0) and of what z differs by from the motion
    that the force gives. It takes the shares for constant at first, and those at twice the frequency for the
    same as at the frequency.

    Parameters
    ----------
    body : Body
        The body.
    empty : float
        A_0 [m].
    pull, second_pull : Complex
        m H of the empty machine at the frequency, and at twice it [1].
    sine : Fed
        The operating point under a sine.
    """
    reaction = sine.share.reaction
    force = Complex(reaction.second_real, reaction.second_imaginary)
    if size_of(second_pull) * size_of(force) == 0.0:
        return sine._replace(agrees=True)
    rate = over(Complex(-1.0, 0.0), _grown(second_pull, reaction))
    if not size_of(second_pull) * size_of(rate) < INF:
        return sine
    # ln A over that of the sine, real and imaginary part of z; residuals; steps; inverse of the rates by rows
    now, left, step, inverse = doubles(3), doubles(3), doubles(3), doubles(9)
    inverse[0] = 1.0
    inverse[4], inverse[5], inverse[7], inverse[8] = rate.real, -rate.imaginary, rate.imaginary, rate.real
    number, mark = doubles(_NUMBERS), integers(_MARKS)
    length, worst = 0.0, INF
    prepare_cells(2, number)
    waves = Waves(HARMONICS, 2, number, mark, 0.0, 0.0, 0.0)
    for _ in range(_MOST):
        amplitude, z = sine.amplitude * math.exp(now[0]), Complex(now[1], now[2])
        share = _share_on(waves, body, loads_at(body, amplitude), z)
        reaction = share.reaction
        force = Complex(reaction.second_real, reaction.second_imaginary)
        gone = plus(times(scaled(second_pull, -0.25), force), scaled(z, -1.0))
        grown = amplitude / empty * size_of(_grown(pull, reaction))
        known = (share.status == Status.OK or share.status == Status.BOUNDARY) and 0.0 < grown < INF
        off = math.log(grown) if known else INF
        size = max(abs(off), size_of(gone))
        if known and size <= _AGREES:
            return Fed(amplitude, share, True)
        if not known and worst == INF:
            break
        if not (known and size <= _WORSE * worst):
            for i in range(3):  # back to the middle of the last step
                step[i] *= 0.5
                now[i] -= step[i]
            continue
        _improve(inverse, left, step, off, gone)
        worst = size
        length = 0.0
        for i in range(3):
            step[i] = 0.0
            for k in range(3):
                step[i] -= inverse[3 * i + k] * left[k]
            length += step[i] * step[i]
        length = math.sqrt(length)
        if not length < INF:
            break
        for i in range(3):
            step[i] *= min(1.0, _LONGEST / length)
            now[i] += step[i]
    return sine


def _grown(pull: Complex, reaction: Reaction) -> Complex:
    """Return 1 + m H lambda."""
    return plus(Complex(1.0, 0.0), times(pull, Complex(reaction.added_mass, -reaction.added_damping)))


def _improve(inverse: Doubles, left: Doubles, step: Doubles, off: float, gone: Complex) -> None:
    """Write new residuals, and let the inverse give the step for the change that was met."""
    change, image, row = doubles(3), doubles(3), doubles(3)
    change[0], change[1], change[2] = off - left[0], gone.real - left[1], gone.imaginary - left[2]
    left[0], left[1], left[2] = off, gone.real, gone.imaginary
    scale = 0.0
    for i in range(3):
        for k in range(3):
            image[i] += inverse[3 * i + k] * change[k]
            row[i] += step[k] * inverse[3 * k + i]
        scale += step[i] * image[i]
    if scale == 0.0:  # before the first step
        return
    for i in range(3):
        for k in range(3):
            inverse[3 * i + k] += (step[i] - image[i]) / scale * row[k]


def _share_on(waves: Waves, body: Body, line: Loads, second: Complex) -> Share:
    """Find the share of a body on a trough that moves along a line with two harmonics."""
    size, phase = size_of(second), math.atan2(second.imaginary, second.real)
    read_harmonic(waves, False, 1, line.drive_tangential, 0.0)
    read_harmonic(waves, True, 1, line.drive_normal, 0.0)
    read_harmonic(waves, False, 2, line.drive_tangential * size, phase)
    read_harmonic(waves, True, 2, line.drive_normal * size, phase)
    tabulate(waves)
    bounded = with_bounds(waves)
    loads = wave_loads(
        bounded, largest(bounded, Mix(0.0, 0.0, 1.0)), line.weight_normal, line.weight_tangential,
        line.static_friction, line.kinetic_friction,
    )  # fmt: skip
    return reaction_on_harmonics(loads, line, second, body.restitution, body.flights, body.hops)
