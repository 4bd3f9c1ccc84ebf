"""A linear machine of one or two masses, Eq. (83): motion for a force of 1 N, and its logarithmic slopes."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Floats = NDArray[np.float64]
    Complexes = NDArray[np.complex128]

__all__ = ["Masses", "Slopes", "Transfer", "slopes", "transfer"]


class Masses(NamedTuple):
    """What of a machine decides its motion for a given force.

    Attributes
    ----------
    trough : float
        m1 [kg].
    counter_inverse : float
        1 / m2; 0 where the springs stand on the floor [1/kg].
    damping_ratio : float
        zeta of the empty machine [1].
    base_stiffness : float
        k_b, mount of m2 on the floor [N/m].
    rod_stiffness : float
        k_r, part of the springs that a crank's rod adds [N/m].
    on_counter_mass : bool
        Whether the force acts on m2 alone; else on m1, and its reaction on m2 or the floor.
    """

    trough: float
    counter_inverse: float
    damping_ratio: float
    base_stiffness: float = 0.0
    rod_stiffness: float = 0.0
    on_counter_mass: bool = False

    @property
    def reduced(self) -> float:
        """Mass mu that the springs move against each other [kg]."""
        return self.trough / (1.0 + self.trough * self.counter_inverse)


class Transfer(NamedTuple):
    """Motion of the masses over the force, and what it is made of; arrays of one shape.

    Attributes
    ----------
    trough, counter, relative : complex array
        X_1, X_2 and X_1 - X_2 over F [m/N].
    compliance : complex array
        H of Eq. (85), A / A_0 = 1 / abs(1 + m H) for a complex added mass m [1/kg].
    kappa : complex array
        k + k_r + i w c [N/m].
    added_mass : complex array
        Of the filling [kg].
    impedance : complex array
        -Z / (m2 w^2) of Eq. (83) [N/m].
    """

    trough: Complexes
    counter: Complexes
    relative: Complexes
    compliance: Complexes
    kappa: Complexes
    added_mass: Complexes
    impedance: Complexes


class Slopes(NamedTuple):
    """d ln A / d ln q with the force's own dependence, Eq. (84), each with all other inputs held [1].

    ``stiffness`` is k without the rod, ``damping`` c, ``filling`` the added mass.
    """

    frequency: Floats
    trough_mass: Floats
    filling: Floats
    stiffness: Floats
    damping: Floats


def transfer(masses: Masses, frequency: Any, natural_frequency: Any, added_mass: Any) -> Transfer:
    """Solve Eq. (83) for a force of 1 N.

    Parameters
    ----------
    masses : Masses
        The machine.
    frequency, natural_frequency : array_like
        Of the drive and of the empty machine between its masses, without the base mount [Hz].
    added_mass : complex array_like
        The filling's mass m (lambda - i delta) [kg].

    Notes
    -----
    Z is divided by -m2 w^2, so that a counter mass may be infinite, and grouped about the resonance: the
    detuning w0^2 - w^2 is a product, exact to rounding where the two nearly cancel.
    """
    m1, r, mu = masses.trough, masses.counter_inverse, masses.reduced
    f, f0 = np.asarray(frequency, np.float64), np.asarray(natural_frequency, np.float64)
    w = 2.0 * np.pi * f
    ww, w0 = w * w, 2.0 * np.pi * f0
    damping = 2j * masses.damping_ratio * mu * w0 * w
    kappa = mu * w0 * w0 + damping
    g = masses.base_stiffness * r / ww
    free = 1.0 - g
    coupling = kappa * r - ww * free  # dZ/dM
    detuning = mu * (4.0 * np.pi**2) * (f0 - f) * (f0 + f) + damping
    empty = (1.0 + m1 * r) * detuning - g * (kappa - m1 * ww)
    added = np.asarray(added_mass, np.complex128)
    mass = m1 + added
    impedance = empty + added * coupling
    if masses.on_counter_mass:
        trough, counter, relative = -kappa * r / ww, (mass - kappa / ww) * r, -mass * r
    else:
        trough, counter, relative = free, -mass * r, free + mass * r
    return Transfer(
        np.asarray(trough / impedance),
        np.asarray(counter / impedance),
        np.asarray(relative / impedance),
        np.asarray(coupling / empty),
        kappa,
        added,
        impedance,
    )


def slopes(masses: Masses, frequency: Any, found: Transfer, exponent: float) -> Slopes:
    """Differentiate ln A, Eq. (84).

    Parameters
    ----------
    masses : Masses
        The machine.
    frequency : array_like
        Of the drive [Hz].
    found : Transfer
        Its solution.
    exponent : float
        Of the force over the frequency [1].
    """
    ww = (2.0 * np.pi * np.asarray(frequency, np.float64)) ** 2
    r, kappa, mass = masses.counter_inverse, found.kappa, masses.trough + found.added_mass
    elastic, damping = kappa.real, 1j * kappa.imag
    spring = elastic - masses.rod_stiffness
    g = masses.base_stiffness * r / ww
    free = 1.0 - g
    split, coupling = free + mass * r, kappa * r - ww * free
    if masses.on_counter_mass:  # terms of the force through the springs are merged: no cancellation
        through = mass * ww * free / kappa
        forced = (exponent - 2.0) * found.impedance
        changed = 2.0 * mass * ww - 2.0 * g * kappa - damping * through
        frequency_slope = (forced + changed) / found.impedance
        spring_slope, damping_slope = -spring * through, -damping * through
    else:
        frequency_slope = (
            (exponent * elastic + (exponent - 1.0) * damping) * split
            + (2.0 - exponent * free) * mass * ww
            - 2.0 * g * kappa
        ) / found.impedance + 2.0 * g / free
        spring_slope, damping_slope = -spring * split, -damping * split
    return Slopes(
        np.real(frequency_slope),
        np.real(-masses.trough * coupling / found.impedance),
        np.real(-found.added_mass * coupling / found.impedance),
        np.real(spring_slope / found.impedance),
        np.real(damping_slope / found.impedance),
    )
