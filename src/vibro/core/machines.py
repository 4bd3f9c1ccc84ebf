"""A linear machine of one or two masses, Eq. (81): its motion for a force of 1 N, in complex numbers."""

from __future__ import annotations

import math
from typing import Final, NamedTuple

from vibro.core.numbers import INF, NAN, TURN, Springs, hypotenuse

_LEAST_SQUARE: Final = 1e-300  # [1/s^2] so that nothing is divided by 0


class Complex(NamedTuple):
    """A complex number."""

    real: float
    imaginary: float


def plus(a: Complex, b: Complex) -> Complex:
    """Add two numbers."""
    return Complex(a.real + b.real, a.imaginary + b.imaginary)


def times(a: Complex, b: Complex) -> Complex:
    """Multiply two numbers."""
    return Complex(a.real * b.real - a.imaginary * b.imaginary, a.real * b.imaginary + a.imaginary * b.real)


def scaled(a: Complex, factor: float) -> Complex:
    """Multiply by a real number."""
    return Complex(a.real * factor, a.imaginary * factor)


def over(a: Complex, b: Complex) -> Complex:
    """Divide two numbers; infinite over 0."""
    length = hypotenuse(b.real, b.imaginary)
    if length == 0.0:
        return Complex(INF if hypotenuse(a.real, a.imaginary) > 0.0 else NAN, NAN)
    x, y = b.real / length, b.imaginary / length
    return Complex((a.real * x + a.imaginary * y) / length, (a.imaginary * x - a.real * y) / length)


def size_of(a: Complex) -> float:
    """Return the absolute value."""
    return hypotenuse(a.real, a.imaginary)


class Transfer(NamedTuple):
    """Motion of the masses over the force.

    Attributes
    ----------
    trough, counter, relative : Complex
        X_1, X_2 and X_1 - X_2 over F [m/N]; of a crank over its radius [1].
    compliance : Complex
        H of Eq. (85), A / A_0 = 1 / abs(1 + m H) for a complex added mass m [1/kg].
    """

    trough: Complex
    counter: Complex
    relative: Complex
    compliance: Complex


def transfer(springs: Springs, frequency: float, natural_frequency: float, added: Complex) -> Transfer:
    """Solve Eq. (81) for a force of 1 N.

    Parameters
    ----------
    springs : Springs
        The machine.
    frequency, natural_frequency : float
        Of the drive and of the empty machine between its masses, without the base mount [Hz].
    added : Complex
        The filling's mass m (lambda - i delta) [kg].

    Notes
    -----
    Z is divided by -m2 w^2, so that a counter mass may be infinite, and grouped about the resonance: the
    detuning w0^2 - w^2 is a product, exact to rounding where the two nearly cancel.
    """
    if springs.trough_mass == INF:  # of a crank
        return Transfer(Complex(1.0, 0.0), Complex(0.0, 0.0), Complex(1.0, 0.0), Complex(0.0, 0.0))
    m1, r = springs.trough_mass, 1.0 / springs.counter_mass
    mu = m1 / (1.0 + m1 * r)  # the mass that the springs move against each other
    w, w0 = TURN * frequency, TURN * natural_frequency
    ww = max(w * w, _LEAST_SQUARE)
    damping = 2.0 * springs.damping_ratio * mu * w0 * w
    kappa = Complex(mu * w0 * w0, damping)
    g = springs.base_stiffness * r / ww
    free = 1.0 - g
    coupling = Complex(kappa.real * r - ww * free, damping * r)  # dZ/dM
    detuning = mu * (TURN * TURN) * (natural_frequency - frequency) * (natural_frequency + frequency)
    whole = 1.0 + m1 * r
    empty = Complex(whole * detuning - g * (kappa.real - m1 * ww), (whole - g) * damping)  # Z_0, Eq. (82)
    mass = Complex(m1 + added.real, added.imaginary)
    impedance = plus(empty, times(added, coupling))
    # Eq. (83)
    trough, counter = Complex(free, 0.0), scaled(mass, -r)
    relative = Complex(free + mass.real * r, mass.imaginary * r)
    if springs.pushes_counter_mass:
        trough, relative = scaled(kappa, -r / ww), counter
        counter = Complex((mass.real - kappa.real / ww) * r, (mass.imaginary - damping / ww) * r)
    return Transfer(
        over(trough, impedance), over(counter, impedance), over(relative, impedance), over(coupling, empty)
    )


def bend(moved: Transfer) -> float:
    """Return the relative amplitude over that of the trough."""
    return size_of(over(moved.relative, moved.trough))


def filled_natural_frequency(springs: Springs, natural_frequency: float, added: float) -> float:
    """Return the natural frequency with a mass added to the trough.

    Infinite of a crank, and where a negative added mass leaves no mass of the trough [Hz].
    """
    r, m1 = 1.0 / springs.counter_mass, springs.trough_mass
    filled = m1 + added
    if not 0.0 < filled < INF:
        return INF
    return natural_frequency * math.sqrt((m1 / filled) * ((1.0 + filled * r) / (1.0 + m1 * r)))
