"""Periodic loads beyond one harmonic: harmonics, or pieces of polynomials; their values and integrals.

S and B are the inertial loads along the trough and off it, x'' = -S and y'' = -B, without a mean. Every load
that decides a motion is a mix c + x S + y B of both: the load along the trough, that on it, and what exceeds
friction. Equation numbers are those of docs/theory. Lengths in A, loads in m A w^2, phases in radians.
"""

from __future__ import annotations

import math
from typing import Final, NamedTuple

from vibro.core.numbers import (
    FEW_ULP,
    HARMONICS,
    INF,
    PIECES,
    QUARTER,
    ROOM,
    TURN,
    Doubles,
    Integers,
    Value,
    circle,
    wrap,
)

#: [kind] One harmonic, for which there are closed forms; the others are ``HARMONICS`` and ``PIECES``.
SINE: Final = 0

#: [row] Zeros are kept of the load along the trough, of that off it, and of what exceeds friction.
FORCE: Final = 0
NORMAL: Final = 1
STATIC_FORWARD: Final = 2
STATIC_BACK: Final = 3
KINETIC_FORWARD: Final = 4
KINETIC_BACK: Final = 5

#: [1] Cells of a period, per harmonic, in which zeros are isolated.
CELLS: Final = 8

_WAVE: Final = 2  # [part] the mix whose zeros are sought
_LOCAL: Final = 3  # [part] a mix, as seen from the start of a leg
_NODES: Final = 4  # [part] zeros, a part for each row
_INTEGRALS: Final = 10  # [part] integrals of a kinetic row at its zeros, a part for each row
_CELLS: Final = 12  # [part] S, its slope, B and its slope where cells of harmonics begin

# [1] Largest velocity and position of a trough whose acceleration has no mean and is nowhere above 1.
_MOST_VELOCITY: Final = QUARTER
_MOST_POSITION: Final = 0.5 * QUARTER * QUARTER
_ABOVE_ONE: Final = 1e-9  # [1] rounding of accelerations that are nowhere above 1, generously


# [rad] Phases of events are rounded, and loads jump at breaks: an event this close to a break is at it.
_AT_BREAK: Final = 1e-12
_HALVINGS: Final = 62  # of a list, down to one place

_NO_NUMBERS: Doubles = memoryview(b"").cast("d")
_NO_MARKS: Integers = memoryview(b"").cast("q")


class Waves(NamedTuple):
    """S and B of one scene, in the memory of one thread.

    Attributes
    ----------
    kind : int
        ``SINE``, ``HARMONICS`` or ``PIECES``; all else is empty with the first.
    size : int
        Number of harmonics H, or of pieces J.
    number : Doubles
        Parts of 2 H, or 4 J, numbers: the coefficients of S, those of B, and scratch memory; then a table.
    mark : Integers
        For each row the number of zeros, and then the sign behind the last of them.
    velocity, height : float
        Bounds of the trough's velocity along itself, and of its height.
    steep : float
        Bound of the rate of B; inf where B jumps.
    """

    kind: int
    size: int
    number: Doubles
    mark: Integers
    velocity: float
    height: float
    steep: float


class Mix(NamedTuple):
    """The load ``constant + along S + normal B``."""

    constant: float
    along: float
    normal: float


class _Curve(NamedTuple):
    """A wave at a phase, its slope and its second derivative there."""

    value: float
    slope: float
    bend: float


class _Bounds(NamedTuple):
    """Bounds of a wave, its mean included, and of its first, second and fourth derivatives within cells."""

    size: float
    slope: float
    bend: float
    fourth: float


class Moved(NamedTuple):
    """What a mix of loads has done to a body since the start of a leg.

    Attributes
    ----------
    load : float
        Now.
    velocity, path : float
        Its first and its second integral.
    slope : float
        Its derivative.
    """

    load: float
    velocity: float
    path: float
    slope: float


class _Departure(NamedTuple):
    """A mix where a leg begins, and its integral less its constant's, without a mean."""

    load: float
    integral: float


class Ride(NamedTuple):
    """What acts on a body that the trough carries: S, B, and the trough's velocity normal to itself."""

    along: float
    normal: float
    velocity: float


def one_harmonic() -> Waves:
    """Stand for the waves of a drive of one harmonic."""
    return Waves(SINE, 0, _NO_NUMBERS, _NO_MARKS, 0.0, 0.0, 0.0)


def part_of(waves: Waves) -> int:
    """Return how many numbers a part of the memory has: the coefficients of one wave."""
    return 2 * waves.size if waves.kind == HARMONICS else 4 * waves.size


def nodes_of(waves: Waves, row: int) -> int:
    """Return where the zeros of a row begin."""
    return (_NODES + row) * part_of(waves)


def integrals_of(waves: Waves, row: int) -> int:
    """Return where the integrals of a kinetic row at its zeros begin."""
    return (_INTEGRALS + row - KINETIC_FORWARD) * part_of(waves)


def _table(waves: Waves) -> int:
    """Return where the table begins: sines and cosines of cells, or ends and integrals of pieces."""
    return ROOM * part_of(waves)


# ---------------------------------------------------------------------------------------------- preparation


def prepare_cells(harmonics: int, number: Doubles) -> None:
    """Fill the table of drives with so many harmonics: sines and cosines at the ends of cells of half a turn.

    The memory has room for ``ROOM`` parts of 2 H numbers and 4 H rows of 2 H more.
    """
    row = ROOM * 2 * harmonics
    for i in range(CELLS * harmonics // 2):
        for k in range(harmonics):
            # the product of whole numbers is reduced to one turn before it is rounded
            angle = TURN * ((i * (k + 1)) % (CELLS * harmonics)) / (CELLS * harmonics)
            number[row + k], number[row + harmonics + k] = math.sin(angle), math.cos(angle)
        row += 2 * harmonics


def read_harmonic(waves: Waves, normal: bool, order: int, share: float, phase: float) -> None:
    """Write harmonic k = ``order`` of S or B, of the amplitude ``share`` [A], x = X sin(k p + phase)."""
    h, k = waves.size, order - 1
    start = 2 * h if normal else 0
    load = float(order * order) * share
    sine, cosine = circle(phase)
    waves.number[start + k], waves.number[start + h + k] = load * cosine, load * sine


def with_bounds(waves: Waves) -> Waves:
    """Measure the bounds of waves whose coefficients are known."""
    if waves.kind == PIECES:
        return waves._replace(velocity=_MOST_VELOCITY, height=_MOST_POSITION, steep=_steepest(waves))
    h, velocity, height, steep = waves.size, 0.0, 0.0, 0.0
    for k in range(h):
        order = float(k + 1)
        u, w = waves.number[k], waves.number[h + k]
        velocity += math.sqrt(u * u + w * w) / order
        u, w = waves.number[2 * h + k], waves.number[3 * h + k]
        size = math.sqrt(u * u + w * w)
        height += size / (order * order)
        steep += size * order
    return waves._replace(velocity=velocity, height=height, steep=steep)


def normal_size(waves: Waves) -> float:
    """Return a bound of B, either way."""
    if waves.kind == PIECES:
        return 1.0 + _ABOVE_ONE
    h, size = waves.size, 0.0
    for k in range(h):
        u, w = waves.number[2 * h + k], waves.number[3 * h + k]
        size += math.sqrt(u * u + w * w)
    return size


def tabulate(waves: Waves) -> None:
    """Evaluate S and B of harmonics where cells begin.

    Half a turn later odd harmonics have the other sign, so that each product serves two cells.
    """
    number, h, part = waves.number, waves.size, part_of(waves)
    row, half = _table(waves), CELLS * h // 2
    for i in range(half):
        for direction in range(2):
            odd, even, odd_slope, even_slope, start = 0.0, 0.0, 0.0, 0.0, direction * part
            for k in range(h):
                u, w = number[start + k], number[start + h + k]
                sine, cosine = number[row + k], number[row + h + k]
                value, slope = u * sine + w * cosine, (k + 1) * (u * cosine - w * sine)
                if k % 2 == 0:
                    odd, odd_slope = odd + value, odd_slope + slope
                else:
                    even, even_slope = even + value, even_slope + slope
            place = _CELLS * part + 4 * i + 2 * direction
            number[place], number[place + 1] = even + odd, even_slope + odd_slope
            number[place + 4 * half], number[place + 4 * half + 1] = even - odd, even_slope - odd_slope
        row += part


def prepare_pieces(waves: Waves, breaks: Doubles, pieces: Doubles, most: float) -> None:
    """Write piecewise accelerations as S and B, and integrate them.

    Parameters
    ----------
    waves : Waves
        Of ``size`` pieces; the memory has room for ``ROOM`` parts of 4 J numbers and 6 J + 1 more.
    breaks : Doubles
        Where pieces begin, as shares of the period; J + 1 of them, 0 and 1 included.
    pieces : Doubles
        Coefficients of x'' and then of y'', lowest power first, 4 for each piece; their argument grows from
        0 to 1 over a piece.
    most : float
        Largest acceleration, by which all are divided.
    """
    number, count, table = waves.number, waves.size, _table(waves)
    for j in range(count):
        number[table + j] = TURN * breaks[j]
    number[table + count] = TURN
    for direction in range(2):
        start = direction * 4 * count
        sums = table + count + 1 + direction * 2 * count
        for j in range(count):
            width, power = number[table + j + 1] - number[table + j], 1.0
            for i in range(4):
                number[start + 4 * j + i] = -pieces[start + 4 * j + i] / most / power
                power *= width
        # the first integral without a mean, then the second one
        _integrate(waves, start, sums)


def _integrate(waves: Waves, start: int, sums: int) -> None:
    """Integrate one wave twice, both times without a mean: write the integrals where pieces begin."""
    number, count, table = waves.number, waves.size, _table(waves)
    velocity, path = 0.0, 0.0
    for j in range(count):
        number[sums + j] = velocity
        width = number[table + j + 1] - number[table + j]
        gain = _over_piece(waves, start + 4 * j, width)
        path += velocity * width + gain.path
        velocity += gain.velocity
    mean = path / TURN
    path, whole = 0.0, 0.0
    for j in range(count):
        number[sums + j] -= mean
        number[sums + count + j] = path
        c, width = start + 4 * j, number[table + j + 1] - number[table + j]
        gain = _over_piece(waves, c, width)
        cubes = number[c + 2] / 60.0 + width * number[c + 3] / 120.0
        cubes = (number[c] / 6.0 + width * (number[c + 1] / 24.0 + width * cubes)) * width * width * width
        whole += width * (path + 0.5 * width * number[sums + j]) + cubes
        path += number[sums + j] * width + gain.path
    for j in range(count):
        number[sums + count + j] -= whole / TURN


def _over_piece(waves: Waves, c: int, s: float) -> Moved:
    """Integrate the polynomial whose coefficients begin at ``c`` from the start of its piece on."""
    a0, a1, a2, a3 = waves.number[c], waves.number[c + 1], waves.number[c + 2], waves.number[c + 3]
    return _polynomial(a0, a1, a2, a3, s)


def _polynomial(a0: float, a1: float, a2: float, a3: float, s: float) -> Moved:
    """Evaluate a cubic polynomial and its integrals."""
    return Moved(
        a0 + s * (a1 + s * (a2 + s * a3)),
        s * (a0 + s * (a1 / 2.0 + s * (a2 / 3.0 + s * a3 / 4.0))),
        s * s * (a0 / 2.0 + s * (a1 / 6.0 + s * (a2 / 12.0 + s * a3 / 20.0))),
        a1 + s * (2.0 * a2 + s * 3.0 * a3),
    )


def _steepest(waves: Waves) -> float:
    """Bound the rate of a piecewise B; inf where it jumps by more than rounding."""
    number, count, table = waves.number, waves.size, _table(waves)
    steep = 0.0
    for j in range(count):
        c, width = 4 * (count + j), number[table + j + 1] - number[table + j]
        end = _over_piece(waves, c, width).load
        after = number[4 * (count + (j + 1) % count)]
        if abs(after - end) > 1e-9:
            return INF
        bound = abs(number[c + 1]) + width * (2.0 * abs(number[c + 2]) + 3.0 * width * abs(number[c + 3]))
        steep = max(steep, bound)
    return steep


# ----------------------------------------------------------------------------------------------- evaluation


def mixed(mix: Mix, along: float, normal: float) -> float:
    """Mix the loads S and B; 0 where rounding would choose the sign.

    Pieces may keep a body just at the limit of friction, or of contact, for a while: equality holds it.
    """
    value = mix.constant + mix.along * along + mix.normal * normal
    # the largest load of pieces is 1, and their mean was taken from all of them
    return value if abs(value) > FEW_ULP * (abs(mix.constant) + abs(mix.along) + abs(mix.normal)) else 0.0


def place_in(waves: Waves, start: int, count: int, phase: float) -> int:
    """Count how many of the phases that begin at ``start``, in order, are at most a phase."""
    low, high = 0, count
    for _ in range(_HALVINGS):
        if low == high:
            break
        middle = (low + high) // 2
        if waves.number[start + middle] <= phase:
            low = middle + 1
        else:
            high = middle
    return low


def _piece_of(waves: Waves, phase: float) -> int:
    """Find the piece that a phase in [0, 2 pi] lies in; the one that begins there, at an end."""
    return place_in(waves, _table(waves) + 1, waves.size - 1, phase)


def _place_of(waves: Waves, phase: float) -> tuple[int, float]:
    """Return the piece that an event lies in, and how far; but for rounding it is not just before a break."""
    p, table = wrap(phase), _table(waves)
    j = _piece_of(waves, p)
    left = waves.number[table + j + 1] - p
    if left <= _AT_BREAK:
        return (j + 1) % waves.size, -left
    return j, p - waves.number[table + j]


def at_break(waves: Waves, phase: float) -> float:
    """Reduce the phase of an event to [0, 2 pi); to that of a break, if it is there but for rounding."""
    if waves.kind != PIECES:
        return wrap(phase)
    j, offset = _place_of(waves, phase)
    return waves.number[_table(waves) + j] if abs(offset) <= _AT_BREAK else wrap(phase)


def load_at(waves: Waves, mix: Mix, phase: float) -> float:
    """Evaluate a mix at a phase; where it jumps, just behind."""
    number = waves.number
    if waves.kind == PIECES:
        j, offset = _place_of(waves, phase)
        return _mixed_piece(waves, mix, j, offset).load
    h = waves.size
    first_sine, first_cosine = circle(phase)
    sine, cosine, value = first_sine, first_cosine, mix.constant
    for k in range(h):
        u = mix.along * number[k] + mix.normal * number[2 * h + k]
        w = mix.along * number[h + k] + mix.normal * number[3 * h + k]
        value += u * sine + w * cosine
        sine, cosine = sine * first_cosine + cosine * first_sine, cosine * first_cosine - sine * first_sine
    return value


def _mixed_piece(waves: Waves, mix: Mix, j: int, offset: float) -> Moved:
    """Evaluate a mix within a piece, and integrate it from the piece's start."""
    number, one, two = waves.number, 4 * j, 4 * (waves.size + j)
    return _polynomial(
        mixed(mix, number[one], number[two]),
        mix.along * number[one + 1] + mix.normal * number[two + 1],
        mix.along * number[one + 2] + mix.normal * number[two + 2],
        mix.along * number[one + 3] + mix.normal * number[two + 3],
        offset,
    )


def depart(waves: Waves, mix: Mix, phase: float) -> _Departure:
    """Begin a leg: keep a mix as it is seen from there, for ``moved``, and evaluate it."""
    number, h = waves.number, waves.size
    if waves.kind == PIECES:
        p = wrap(phase)
        j = _piece_of(waves, p)
        offset, sums = p - number[_table(waves) + j], _table(waves) + h + 1 + j
        here = _mixed_piece(waves, mix, j, offset)
        before = mix.along * number[sums] + mix.normal * number[sums + 2 * h]
        return _Departure(here.load, before + (here.velocity - mix.constant * offset))
    first_sine, first_cosine = circle(phase)
    sine, cosine, value, integral = first_sine, first_cosine, mix.constant, 0.0
    for k in range(h):
        u = mix.along * number[k] + mix.normal * number[2 * h + k]
        w = mix.along * number[h + k] + mix.normal * number[3 * h + k]
        here_k, across_k, order = u * sine + w * cosine, u * cosine - w * sine, float(k + 1)
        share = 1.0 / (order * order)
        number[(2 * _LOCAL) * h + k], number[(2 * _LOCAL + 1) * h + k] = here_k * share, across_k * share
        value += here_k
        integral -= order * share * across_k
        sine, cosine = sine * first_cosine + cosine * first_sine, cosine * first_cosine - sine * first_sine
    return _Departure(value, integral)


def moved(waves: Waves, mix: Mix, phase: float, value: float, s: float) -> Moved:
    """Integrate a mix over a phase s >= 0 since ``depart``, without cancellation however short s is.

    Parameters
    ----------
    waves, mix : Waves, Mix
        Those of ``depart``.
    phase : float
        Where the leg began [rad].
    value : float
        The mix there: 0 exactly where the leg began at its zero.
    s : float
        Phase since [rad].
    """
    if waves.kind == PIECES:
        return _moved_over_pieces(waves, mix, phase, value, s)
    number, h = waves.number, waves.size
    first_sine, first_cosine = circle(0.5 * s)
    half_sine, half_cosine = first_sine, first_cosine
    load, velocity, path, slope = value, value * s, 0.5 * value * s * s, 0.0
    for k in range(h):
        here, across = number[(2 * _LOCAL) * h + k], number[(2 * _LOCAL + 1) * h + k]
        order = float(k + 1)
        angle, sine, versine = order * s, 2.0 * half_sine * half_cosine, 2.0 * half_sine * half_sine
        gap, bend = angle - sine, 0.5 * angle * angle - versine
        if angle < 1.0:  # both differences by their series, within 1e-17 of their values
            y = angle * angle
            gap = (
                (((((
                    7.54937170418124304e-13 * y - 1.60577019225797864e-10) * y + 2.50520992449141141e-08) * y
                    - 2.75573191920112204e-06) * y + 0.000198412698412165663) * y - 0.00833333333333330026)
                    * y + 0.166666666666666657
            ) * y * angle  # fmt: skip
            bend = (
                (((((
                    4.77947733238738529e-14 * y - 1.14707455977297247e-11) * y + 2.08767569878680990e-09) * y
                    - 2.75573192239858906e-07) * y + 2.48015873015873016e-05) * y - 0.00138888888888888889)
                    * y + 0.0416666666666666667
            ) * y * y  # fmt: skip
        path += across * gap - here * bend
        velocity += order * (across * versine - here * gap)
        load += order * order * (across * sine - here * versine)
        slope += order * order * order * (across * (1.0 - versine) - here * sine)
        half_sine, half_cosine = (
            half_sine * first_cosine + half_cosine * first_sine,
            half_cosine * first_cosine - half_sine * first_sine,
        )
    return Moved(load, velocity, path, slope)


def _moved_over_pieces(waves: Waves, mix: Mix, phase: float, value: float, s: float) -> Moved:
    """Integrate a mix from a phase on, through the piece it lies in and all others."""
    number, count, table = waves.number, waves.size, _table(waves)
    p = wrap(phase)
    j = _piece_of(waves, p)
    offset, left = p - number[table + j], number[table + j + 1] - p
    one, two = 4 * j, 4 * (count + j)
    a1 = mix.along * number[one + 1] + mix.normal * number[two + 1]
    a2 = mix.along * number[one + 2] + mix.normal * number[two + 2]
    a3 = mix.along * number[one + 3] + mix.normal * number[two + 3]
    a1 += offset * (2.0 * a2 + 3.0 * offset * a3)
    a2 += 3.0 * offset * a3
    if s < left:
        return _polynomial(value, a1, a2, a3, s)
    own, rest, begin = _polynomial(value, a1, a2, a3, left), s - left, (j + 1) % count
    reached = _beyond(waves, j, rest)
    end = _piece_of(waves, reached)
    beyond = reached - number[table + end]
    velocity, path = own.velocity + mix.constant * rest, own.path + own.velocity * rest
    path += 0.5 * mix.constant * rest * rest
    for direction in range(2):
        share = mix.normal if direction == 1 else mix.along
        if share != 0.0:
            sums = table + count + 1 + direction * 2 * count
            gain = _over_piece(waves, 4 * (direction * count + end), beyond)
            before = number[sums + begin]
            velocity += share * (number[sums + end] + gain.velocity - before)
            height = number[sums + count + end] + number[sums + end] * beyond + gain.path
            path += share * (height - number[sums + count + begin] - before * rest)
    now = _mixed_piece(waves, mix, end, beyond)
    return Moved(now.load, velocity, path, now.slope)


def _beyond(waves: Waves, j: int, rest: float) -> float:
    """Return the phase ``rest`` beyond the end of piece j, in [0, 2 pi)."""
    begin = (j + 1) % waves.size
    r = rest + (waves.number[_table(waves) + begin] if begin > 0 else 0.0)
    return r - TURN * math.floor(r / TURN)


def ride(waves: Waves, phase: float, s: float) -> Ride:
    """Evaluate what acts on a body a phase s >= 0 after another one; where loads jump, just behind."""
    number, size = waves.number, waves.size
    if waves.kind == PIECES:
        p = wrap(phase)
        j = _piece_of(waves, p)
        left, offset = number[_table(waves) + j + 1] - p, p - number[_table(waves) + j] + s
        if s >= left - _AT_BREAK:
            j, offset = _place_of(waves, _beyond(waves, j, s - left))
        along, normal = _over_piece(waves, 4 * j, offset), _over_piece(waves, 4 * (size + j), offset)
        before = number[_table(waves) + 3 * size + 1 + j]
        return Ride(along.load, normal.load, -(before + normal.velocity))
    first_sine, first_cosine = circle(phase + s)
    sine, cosine, along_load, normal_load, velocity = first_sine, first_cosine, 0.0, 0.0, 0.0
    for k in range(size):
        u, w = number[2 * size + k], number[3 * size + k]
        along_load += number[k] * sine + number[size + k] * cosine
        normal_load += u * sine + w * cosine
        velocity += (u * cosine - w * sine) / float(k + 1)
        sine, cosine = sine * first_cosine + cosine * first_sine, cosine * first_cosine - sine * first_sine
    return Ride(along_load, normal_load, velocity)


def trough_at(waves: Waves, normal: bool, phase: float) -> Value:
    """Return the trough's position, from its mean, and its velocity, along or normal to itself [A, A w]."""
    number, size = waves.number, waves.size
    if waves.kind == PIECES:
        p = wrap(phase)
        j = _piece_of(waves, p)
        table, direction = _table(waves), 1 if normal else 0
        offset, sums = p - number[table + j], table + size + 1 + direction * 2 * size
        gain = _over_piece(waves, 4 * (direction * size + j), offset)
        position = number[sums + size + j] + number[sums + j] * offset + gain.path
        return Value(-position, -(number[sums + j] + gain.velocity))
    start = 2 * size if normal else 0
    first_sine, first_cosine = circle(phase)
    sine, cosine, position, velocity = first_sine, first_cosine, 0.0, 0.0
    for k in range(size):
        u, w, order = number[start + k], number[start + size + k], float(k + 1)
        position += (u * sine + w * cosine) / (order * order)
        velocity += (u * cosine - w * sine) / order
        sine, cosine = sine * first_cosine + cosine * first_sine, cosine * first_cosine - sine * first_sine
    return Value(position, velocity)


# ---------------------------------------------------------------------------------- cells of a mix of loads


def combine(waves: Waves, mix: Mix) -> _Bounds:
    """Write the coefficients of a mix where cells read them, its constant apart for harmonics."""
    number, part = waves.number, part_of(waves)
    for i in range(part):
        number[_WAVE * part + i] = mix.along * number[i] + mix.normal * number[part + i]
    if waves.kind == PIECES:
        for j in range(waves.size):
            number[_WAVE * part + 4 * j] = mixed(mix, number[4 * j], number[part + 4 * j])
        return _Bounds(0.0, INF, INF, 0.0)
    h, bound, slope, bend, fourth = waves.size, abs(mix.constant), 0.0, 0.0, 0.0
    for k in range(h):
        c, order = _WAVE * part + k, float(k + 1)
        size = math.sqrt(number[c] * number[c] + number[c + h] * number[c + h])
        bound += size
        slope += order * size
        bend += order * order * size
        fourth += order * order * order * order * size
    return _Bounds(bound, slope, bend, fourth)


def stays_zero(waves: Waves, mix: Mix, lift: Mix) -> bool:
    """Return whether a mix is 0, but for rounding, throughout a piece at whose start the lift is negative."""
    number, part = waves.number, part_of(waves)
    combine(waves, mix)
    for j in range(waves.size):
        c, pressed = _WAVE * part + 4 * j, mixed(lift, number[4 * j], number[part + 4 * j]) < 0.0
        flat = number[c + 1] == 0.0 and number[c + 2] == 0.0 and number[c + 3] == 0.0
        if pressed and flat and number[c] == 0.0:
            return True
    return False


def cells_of(waves: Waves) -> int:
    """Return the number of cells of a period."""
    return waves.size if waves.kind == PIECES else CELLS * waves.size


def cell_begin(waves: Waves, cell: int) -> float:
    """Return the phase at which a cell begins, and the one before it ends."""
    if waves.kind == PIECES:
        return waves.number[_table(waves) + cell]
    return TURN * cell / (CELLS * waves.size)


def value_at_cell_begin(waves: Waves, cell: int, mix: Mix) -> float:
    """Evaluate the mix of ``combine`` at the start of a cell."""
    number, part = waves.number, part_of(waves)
    if waves.kind == PIECES:
        return number[_WAVE * part + 4 * cell]
    row = _CELLS * part + 4 * cell
    return mix.constant + mix.along * number[row] + mix.normal * number[row + 2]


def at_cell_begin(waves: Waves, cell: int, mix: Mix) -> Value:
    """Evaluate it, and its slope."""
    number, part = waves.number, part_of(waves)
    value = value_at_cell_begin(waves, cell, mix)
    if waves.kind == PIECES:
        return Value(value, number[_WAVE * part + 4 * cell + 1])
    row = _CELLS * part + 4 * cell
    return Value(value, mix.along * number[row + 1] + mix.normal * number[row + 3])


def curve_in_cell(waves: Waves, cell: int, constant: float, phase: float) -> _Curve:
    """Evaluate the mix of ``combine`` within a cell, or at its end."""
    number, wave = waves.number, _WAVE * part_of(waves)
    if waves.kind == PIECES:
        c, s = wave + 4 * cell, phase - number[_table(waves) + cell]
        a1, a2, a3 = number[c + 1], number[c + 2], number[c + 3]
        value = number[c] + s * (a1 + s * (a2 + s * a3))
        return _Curve(value, a1 + s * (2.0 * a2 + s * 3.0 * a3), 2.0 * a2 + s * 6.0 * a3)
    h = waves.size
    first_sine, first_cosine = circle(phase)
    sine, cosine, value, slope, bend = first_sine, first_cosine, constant, 0.0, 0.0
    for k in range(h):
        u, w, order = number[wave + k], number[wave + h + k], float(k + 1)
        here = u * sine + w * cosine
        value += here
        slope += order * (u * cosine - w * sine)
        bend -= order * order * here
        sine, cosine = sine * first_cosine + cosine * first_sine, cosine * first_cosine - sine * first_sine
    return _Curve(value, slope, bend)


def value_in_cell(waves: Waves, cell: int, constant: float, phase: float) -> Value:
    """Evaluate it, and its slope alone."""
    at = curve_in_cell(waves, cell, constant, phase)
    return Value(at.value, at.slope)
