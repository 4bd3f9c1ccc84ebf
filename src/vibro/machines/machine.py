"""The machines that drive troughs: their data, and the amplitude that follows from them."""

from __future__ import annotations

import math
from dataclasses import dataclass, fields
from typing import TYPE_CHECKING, Any, Final, Literal, NamedTuple

import numpy as np

from vibro.core.numbers import TURN
from vibro.errors import InputError, Problems, shown
from vibro.reals import NotRealError, real_array, real_number, shielded

if TYPE_CHECKING:
    from collections.abc import Mapping

    from numpy.typing import ArrayLike

    from vibro.reals import Complexes, Floats


# ------------------------------------------------------------------------------
# A linear machine of one or two masses, Eq. (83): motion for a force of 1 N, and its logarithmic slopes.


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


class _Slopes(NamedTuple):
    """d ln A / d ln q with the force's own dependence, Eq. (84), each with all other inputs held [1].

    ``stiffness`` is k without the rod, ``damping`` c, ``filling`` the added mass.
    """

    frequency: Floats
    trough_mass: Floats
    filling: Floats
    stiffness: Floats
    damping: Floats


def transfer(machine: Machine, frequency: Any, natural_frequency: Any, added_mass: Any) -> Transfer:
    """Solve Eq. (83) for a force of 1 N.

    Parameters
    ----------
    machine : Machine
        Its masses, damping, and mount.
    frequency, natural_frequency : array_like
        Of the drive and of the empty machine between its masses, without the base mount [Hz].
    added_mass : complex array_like
        The filling's mass m (lambda - i delta) [kg].

    Notes
    -----
    Z is divided by -m2 w^2, so that a counter mass may be infinite, and grouped about the resonance: the
    detuning w0^2 - w^2 is a product, exact to rounding where the two nearly cancel.
    """
    m1, r, mu = machine.trough_mass, 1.0 / machine.counter_mass, machine.reduced_mass
    f, f0 = np.asarray(frequency, np.float64), np.asarray(natural_frequency, np.float64)
    w = TURN * f
    ww, w0 = w * w, TURN * f0
    damping = 2j * machine.damping_ratio * mu * w0 * w
    kappa = mu * w0 * w0 + damping
    g = machine.base_stiffness * r / ww
    free = 1.0 - g
    coupling = kappa * r - ww * free  # dZ/dM
    detuning = mu * TURN**2 * (f0 - f) * (f0 + f) + damping
    empty = (1.0 + m1 * r) * detuning - g * (kappa - m1 * ww)
    added = np.asarray(added_mass, np.complex128)
    mass = m1 + added
    impedance = empty + added * coupling
    if machine.kind == "exciter":
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


def _slopes(machine: Machine, frequency: Any, found: Transfer) -> _Slopes:
    """Differentiate ln A, Eq. (84).

    Parameters
    ----------
    machine : Machine
        Its masses, damping, and mount.
    frequency : array_like
        Of the drive [Hz].
    found : Transfer
        Its solution.
    """
    ww = (TURN * np.asarray(frequency, np.float64)) ** 2
    r, kappa, mass = 1.0 / machine.counter_mass, found.kappa, machine.trough_mass + found.added_mass
    exponent = machine.force_exponent
    elastic, damping = kappa.real, 1j * kappa.imag
    spring = elastic - machine.rod_stiffness
    g = machine.base_stiffness * r / ww
    free = 1.0 - g
    split, coupling = free + mass * r, kappa * r - ww * free
    if machine.kind == "exciter":  # terms of the force through the springs are merged: no cancellation
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
    return _Slopes(
        np.real(frequency_slope),
        np.real(-machine.trough_mass * coupling / found.impedance),
        np.real(-found.added_mass * coupling / found.impedance),
        np.real(spring_slope / found.impedance),
        np.real(damping_slope / found.impedance),
    )


#: Quantities by which ``Response.elasticities`` differentiates.
ELASTICITIES: Final = ("frequency", "setting", "voltage", "trough_mass", "filling", "stiffness", "damping")

_LAWS: Final = {"current": 0.0, "voltage": -2.0}  # exponent of a magnet's force over the frequency


# Numbers that describe a machine: units of those that have one, and those that may be 0, or infinite.
_UNITS: Final = {
    "trough_mass": "kg", "vibrating_mass": "kg", "counter_mass": "kg", "filling": "kg",
    "natural_frequency": "Hz", "mount_frequency": "Hz", "frequency": "Hz", "force_frequency": "Hz",
    "base_stiffness": "N/m", "rod_stiffness": "N/m", "radius": "m", "gap": "m", "amplitude": "m",
    "static_moment": "kg m", "force": "N",
}  # fmt: skip
_MAY_BE_0: Final = {"mount_frequency", "damping_ratio", "base_stiffness", "voltage_exponent", "filling"}
_MAY_BE_INFINITE: Final = {"counter_mass", "gap"}
_REMEDIES: Final = {
    "natural_frequency": "measure it: let the empty machine ring down, or fit amplitudes over frequencies on"
    " both sides of resonance; which side of resonance the drive is on decides what a filling does",
    "damping_ratio": "count the cycles n in which the free vibration halves: it is 0.11 / n; leaf springs"
    " have 0.01 to 0.05",
}
_SPRINGS: Final = ("trough_mass", "counter_mass", "natural_frequency", "damping_ratio", "base_stiffness")
#: Numbers that describe each kind of machine.
_KINDS: Final = {
    "unbalance": ("vibrating_mass", "mount_frequency", "damping_ratio", "static_moment"),
    "magnet": (*_SPRINGS, "voltage_exponent", "gap"),
    "exciter": (*_SPRINGS, "static_moment"),
    "crank": ("radius",),
    "rod": ("trough_mass", "natural_frequency", "damping_ratio", "rod_stiffness", "radius"),
    "measured": ("trough_mass", "counter_mass", "voltage_exponent", "gap"),
}
_CALIBRATION: Final = ("amplitude", "frequency", "setting", "voltage", "filling")
_FIELDS: Final = {"vibrating_mass": "trough_mass", "mount_frequency": "natural_frequency"}  # of Machine


@dataclass(frozen=True)
class Calibration:
    """A measured amplitude, from which the force of a machine follows.

    Attributes
    ----------
    amplitude : float
        Amplitude of the trough, half of its stroke, > 0 [m].
    frequency : float
        Drive frequency, > 0 [Hz].
    setting, voltage : float
        Setting and voltage during the measurement, over those that count as 100 %, > 0 [1].
    filling : float
        Mass that was clamped to the trough, >= 0; 0 if the machine was empty [kg].

    Examples
    --------
    0.35 mm at 50 Hz, measured with the controller at 80 %:

    >>> Calibration(0.35e-3, 50, setting=0.8)
    Calibration(amplitude=0.00035, frequency=50, setting=0.8, voltage=1.0, filling=0.0)
    """

    amplitude: float
    frequency: float
    setting: float = 1.0
    voltage: float = 1.0
    filling: float = 0.0


@dataclass(frozen=True, eq=False, kw_only=True)
class Response:
    """Steady motion of a linear machine: arrays of the broadcast shape, or NumPy scalars for one case.

    Attributes
    ----------
    amplitude : array
        Amplitude of the trough along the drive's line [m].
    phase : array
        Phase lead of the trough over the force, in (-pi, pi]; 0 for a crank [rad].
    counter_amplitude : array
        Amplitude of the counter mass; 0 if the springs stand on the floor [m].
    relative_amplitude : array
        Amplitude of the trough relative to the counter mass or the floor, by which the springs deflect [m].
    filled_natural_frequency : array
        Natural frequency with the real part of the added mass, without the base mount; inf for a crank, and
        where a negative added mass leaves no mass of the trough [Hz].
    compliance : complex array
        H: with a complex added mass m the amplitude is that of the empty machine over ``abs(1 + m H)``
        [1/kg].
    elasticities : mapping of str to array
        Relative change of the amplitude over the relative change of one quantity, the others constant:
        ``frequency``, ``setting``, ``voltage``, ``trough_mass``, ``filling``, ``stiffness`` (of the springs
        without a rod) and ``damping`` [1].
    """

    amplitude: Floats
    phase: Floats
    counter_amplitude: Floats
    relative_amplitude: Floats
    filled_natural_frequency: Floats
    compliance: Complexes
    elasticities: Mapping[str, Floats]


@dataclass(frozen=True, init=False)
class Machine:
    """A linear machine that drives a trough along a line, against the floor or a counter mass.

    Make it with the classmethod of its kind: ``unbalance``, ``magnet``, ``exciter``, ``crank``, ``rod`` or
    ``measured``.

    Attributes
    ----------
    kind : str
        Name of the classmethod that made it.
    trough_mass : float
        Mass m1 of the empty trough with all that moves with it; inf for a crank, whose amplitude does not
        depend on the filling [kg].
    counter_mass : float
        Counter mass m2; inf if the springs stand on the floor [kg].
    natural_frequency : float
        Natural frequency f0 of the empty machine, without the base mount; 0 for infinitely soft mounts, inf
        for a crank [Hz].
    damping_ratio : float
        Damping ratio zeta of the empty machine [1].
    base_stiffness : float
        Stiffness of the mount of the counter mass on the floor [N/m].
    rod_stiffness : float
        Stiffness of the springs through which a crank acts [N/m].
    force : float
        Amplitude of the force at 100 % setting and voltage and at ``force_frequency``; 0 for a crank [N].
    force_frequency, force_exponent : float
        The force is proportional to ``(frequency / force_frequency) ** force_exponent`` [Hz], [1].
    voltage_exponent : float
        The force is proportional to ``voltage ** voltage_exponent`` [1].
    radius : float
        Radius of a crank; 0 for other machines [m].
    gap : float
        Relative amplitude at which the masses strike each other [m].

    Examples
    --------
    >>> feeder = Machine.magnet(trough_mass=6, counter_mass=12, natural_frequency=50 / 1.05,
    ...                         damping_ratio=0.015, calibration=Calibration(0.35e-3, 50))
    >>> print(f"{feeder.force:.1f} N, {feeder.load_proof_frequency(50):.1f} Hz")
    20.2 N, 86.6 Hz
    >>> print(f"{feeder.response(50, added_mass=0.2).elasticities['filling']:.3f}")
    -0.189
    """

    kind: str
    trough_mass: float = math.inf
    counter_mass: float = math.inf
    natural_frequency: float = math.inf
    damping_ratio: float = 0.0
    base_stiffness: float = 0.0
    rod_stiffness: float = 0.0
    force: float = 0.0
    force_frequency: float = 1.0
    force_exponent: float = 0.0
    voltage_exponent: float = 0.0
    radius: float = 0.0
    gap: float = math.inf

    def __init__(self) -> None:
        raise InputError(
            "Machine() cannot be called: every machine has a kind",
            hint="call Machine.unbalance, .magnet, .exciter, .crank, .rod or .measured",
        )

    @classmethod
    def _made(cls, kind: str, given: Mapping[str, Any]) -> Machine:
        """Make a machine that the numbers of its kind describe."""
        read = _Reading(kind)
        values = read.fields(given)
        read.settle()
        return cls._of(kind, **values)

    @classmethod
    def _of(cls, kind: str, **values: float) -> Machine:
        machine = cls.__new__(cls)
        for field in fields(cls)[1:]:
            object.__setattr__(machine, field.name, values.get(field.name, field.default))
        object.__setattr__(machine, "kind", kind)
        return machine

    def _changed(self, **values: float) -> Machine:
        return self._of(self.kind, **{**{f.name: getattr(self, f.name) for f in fields(self)[1:]}, **values})

    @classmethod
    @shielded
    def unbalance(
        cls,
        *,
        vibrating_mass: float,
        static_moment: float,
        mount_frequency: float = 0.0,
        damping_ratio: float = 0.0,
    ) -> Machine:
        """Make a trough on soft mounts that is driven by counter-rotating unbalance motors.

        Parameters
        ----------
        vibrating_mass : float
            Mass of the trough with the motors, > 0 [kg].
        static_moment : float
            Eccentric mass times its radius, of all motors together, at 100 % setting, > 0 [kg m].
        mount_frequency : float, optional
            Natural frequency of the empty trough on its mounts, >= 0; by default 0, infinitely soft mounts.
            Mounts at a third of the drive frequency increase the amplitude by 12.5 % [Hz].
        damping_ratio : float, optional
            Damping ratio of the mounts, in [0, 1) [1].

        Returns
        -------
        Machine
            Of the kind ``unbalance``.

        Raises
        ------
        InputError
            If an argument is out of its range; the message lists all of them.

        Examples
        --------
        >>> machine = Machine.unbalance(vibrating_mass=200, static_moment=1.2, mount_frequency=4)
        >>> print(f"{1e3 * machine.response(24.5).amplitude:.2f} mm")
        6.16 mm
        """
        return cls._made("unbalance", locals())

    @classmethod
    @shielded
    def magnet(
        cls,
        *,
        trough_mass: float,
        counter_mass: float = math.inf,
        natural_frequency: float | None = None,
        damping_ratio: float | None = None,
        force: float | None = None,
        calibration: Calibration | None = None,
        voltage_exponent: float = 2.0,
        law: Literal["current", "voltage"] = "current",
        force_frequency: float | None = None,
        base_stiffness: float = 0.0,
        gap: float = math.inf,
    ) -> Machine:
        """Make a trough on springs that a magnet or a piezo drive moves against a counter mass or the floor.

        Parameters
        ----------
        trough_mass : float
            Mass of the trough with all that moves with it, > 0 [kg].
        counter_mass : float, optional
            Counter mass, > 0; by default the springs stand on the floor [kg].
        natural_frequency : float
            Natural frequency of the empty machine, without the base mount, > 0 [Hz].
        damping_ratio : float
            Damping ratio, in [0, 1) [1].
        force : float, optional
            Amplitude of the force at 100 % setting and voltage, > 0 [N]. Give either this or ``calibration``.
        calibration : Calibration, optional
            A measured amplitude, from which the force follows.
        voltage_exponent : float, optional
            The force is proportional to this power of the voltage: 2 for a magnet, 1 for a piezo drive, > 0
            [1].
        law : {"current", "voltage"}, optional
            ``current``: the force does not depend on the frequency. ``voltage``: it is proportional to
            1 / frequency^2, as that of a coil at constant voltage.
        force_frequency : float, optional
            With ``law="voltage"``, the frequency at which the force is as given; by default that of the
            calibration [Hz].
        base_stiffness : float, optional
            Stiffness of the mount of the counter mass on the floor, >= 0 [N/m].
        gap : float, optional
            Relative amplitude at which the faces of the magnet strike each other, > 0 [m].

        Returns
        -------
        Machine
            Of the kind ``magnet``.

        Raises
        ------
        InputError
            If an argument is missing, out of its range or given twice; the message lists all of them.

        Examples
        --------
        >>> machine = Machine.magnet(trough_mass=6, natural_frequency=55, damping_ratio=0.02, force=40)
        >>> print(f"{1e3 * machine.response(50).amplitude:.3f} mm")
        0.315 mm
        """
        read = _Reading("magnet")
        values = read.fields(locals())
        if law not in _LAWS:
            read.add(f"law = {shown(law)}: must be 'current' or 'voltage'", field="law")
        if (force is None) == (calibration is None):
            read.add(
                f"force = {shown(force)} and calibration = {shown(calibration)}: must be one or the other",
                "give the force, or one amplitude that was measured:"
                " calibration=vibro.Calibration(amplitude=0.35e-3, frequency=50)",
                "force",
            )
        values["force"] = 1.0 if force is None else read.number("force", force)
        if law == "voltage":
            if force_frequency is None and isinstance(calibration, Calibration):
                force_frequency = calibration.frequency
            values["force_frequency"] = read.number("force_frequency", force_frequency)
        elif force_frequency is not None:
            read.add(
                f"force_frequency = {shown(force_frequency)}: must be left out where law = {shown(law)}",
                "only with law='voltage' does the force depend on the frequency",
                "force_frequency",
            )
        known = None if calibration is None else read.calibration(calibration)
        read.settle()
        machine = cls._of("magnet", force_exponent=_LAWS[law], **values)
        return machine if known is None else machine._calibrated(known)

    @classmethod
    @shielded
    def exciter(
        cls,
        *,
        trough_mass: float,
        counter_mass: float,
        static_moment: float,
        natural_frequency: float | None = None,
        damping_ratio: float | None = None,
        base_stiffness: float = 0.0,
    ) -> Machine:
        """Make a trough on springs on an exciter mass that is driven by unbalance motors.

        Parameters
        ----------
        trough_mass, counter_mass : float
            Masses of the trough and of the exciter with its motors, > 0 [kg].
        static_moment : float
            Eccentric mass times its radius, of all motors together, at 100 % setting, > 0 [kg m].
        natural_frequency : float
            Natural frequency of the empty machine, without the base mount, > 0 [Hz].
        damping_ratio : float
            Damping ratio, in [0, 1) [1].
        base_stiffness : float, optional
            Stiffness of the mount of the exciter mass on the floor, >= 0 [N/m].

        Returns
        -------
        Machine
            Of the kind ``exciter``.

        Raises
        ------
        InputError
            If an argument is missing or out of its range; the message lists all of them.

        Examples
        --------
        >>> machine = Machine.exciter(trough_mass=100, counter_mass=50, static_moment=0.3,
        ...                           natural_frequency=18, damping_ratio=0.02)
        >>> print(f"{1e3 * machine.response(16.5).amplitude:.2f} mm")
        12.21 mm
        """
        return cls._made("exciter", locals())

    @classmethod
    @shielded
    def crank(cls, *, radius: float) -> Machine:
        """Make a trough that is driven by a rigid crank; its amplitude does not depend on the filling.

        Parameters
        ----------
        radius : float
            Radius of the crank at 100 % setting, > 0 [m].

        Returns
        -------
        Machine
            Of the kind ``crank``.

        Raises
        ------
        InputError
            If the radius is out of its range.

        Examples
        --------
        >>> print(f"{1e3 * Machine.crank(radius=8e-3).response(8).amplitude:.2f} mm")
        8.00 mm
        """
        return cls._made("crank", locals())

    @classmethod
    @shielded
    def rod(
        cls,
        *,
        radius: float,
        rod_stiffness: float,
        trough_mass: float,
        natural_frequency: float | None = None,
        damping_ratio: float | None = None,
    ) -> Machine:
        """Make a trough on springs that is driven by a crank through a soft rod.

        Parameters
        ----------
        radius : float
            Radius of the crank at 100 % setting, > 0 [m].
        rod_stiffness : float
            Stiffness of the springs in the rod, > 0 [N/m].
        trough_mass : float
            Mass of the trough with all that moves with it, > 0 [kg].
        natural_frequency : float
            Natural frequency of the empty trough on all its springs, those of the rod included, with the
            crank at rest, > 0 [Hz].
        damping_ratio : float
            Damping ratio, in [0, 1) [1].

        Returns
        -------
        Machine
            Of the kind ``rod``.

        Raises
        ------
        InputError
            If an argument is missing or out of its range, or the rod is stiffer than all springs together;
            the message lists all problems.

        Examples
        --------
        >>> machine = Machine.rod(radius=5e-3, rod_stiffness=2e5, trough_mass=80, natural_frequency=12,
        ...                       damping_ratio=0.03)
        >>> print(f"{1e3 * machine.response(10).amplitude:.2f} mm")
        7.10 mm
        """
        return cls._made("rod", locals())

    @classmethod
    @shielded
    def measured(
        cls,
        *,
        points: Any,
        trough_mass: float,
        counter_mass: float = math.inf,
        law: Literal["constant", "square"] = "constant",
        voltage_exponent: float | None = None,
        gap: float = math.inf,
    ) -> Machine:
        """Make a machine from measured amplitudes of the empty trough at several frequencies.

        Parameters
        ----------
        points : array_like, shape (n, 2)
            Frequency [Hz] and amplitude [m] at 100 % setting, at 3 or more frequencies on both sides of the
            resonance.
        trough_mass : float
            Mass of the trough with all that moves with it, > 0 [kg].
        counter_mass : float, optional
            Counter mass, > 0; by default the springs stand on the floor [kg].
        law : {"constant", "square"}, optional
            How the force depends on the frequency: ``constant`` for a magnet, and for unbalance motors on a
            counter mass; ``square`` for unbalance motors on the trough.
        voltage_exponent : float, optional
            The force is proportional to this power of the voltage; by default 2 with ``law="constant"``, and
            0 with ``law="square"`` [1].
        gap : float, optional
            Relative amplitude at which the masses strike each other, > 0 [m].

        Returns
        -------
        Machine
            Of the kind ``measured``, with the natural frequency, damping ratio and force that fit best.

        Raises
        ------
        InputError
            If an argument is out of its range, or the points do not determine the natural frequency or the
            damping; the message lists all problems.
        SceneError
            If the points are not such pairs.

        Examples
        --------
        >>> points = [(44, 0.21e-3), (47, 0.62e-3), (48, 0.71e-3), (50, 0.34e-3), (54, 0.14e-3)]
        >>> machine = Machine.measured(points=points, trough_mass=6, counter_mass=12)
        >>> print(f"{machine.natural_frequency:.1f} Hz, {machine.damping_ratio:.3f}")
        47.9 Hz, 0.025
        """
        from vibro.machines.fitting import fit_response

        fit, is_square = fit_response(points, law=law), law == "square"
        if voltage_exponent is None:
            voltage_exponent = 0.0 if is_square else 2.0
        read = _Reading("measured")
        values = read.fields(locals())
        if is_square and values["counter_mass"] < math.inf:
            read.add(
                f"counter_mass = {counter_mass:.15g} kg: must be left out where law = 'square'",
                "unbalance on a counter mass has law='constant' for the trough",
                "counter_mass",
            )
        f0, damping = fit.natural_frequency, fit.damping_ratio
        if math.isnan(f0) or math.isnan(damping):
            read.add(
                f"points: they do not determine the {'natural frequency' if math.isnan(f0) else 'damping'}",
                "measure on both sides of the resonance, some points within 5 % of it; or describe a magnet,"
                " by its natural frequency and damping ratio",
                "points",
            )
        read.settle()
        # static amplitude times stiffness; times m1 w^2 at 1 Hz where the force grows with the square
        force = fit.static_amplitude * (values["trough_mass"] * TURN**2) * (1.0 if is_square else f0**2)
        values |= {"natural_frequency": f0, "damping_ratio": damping, "force": force}
        return cls._of("measured", force_exponent=2.0 if is_square else 0.0, **values)

    @shielded
    def with_natural_frequency(self, natural_frequency: float) -> Machine:
        """Return the machine with another spring pack: the same masses, force and damping ratio.

        Parameters
        ----------
        natural_frequency : float
            Natural frequency of the empty machine with that pack, > 0 [Hz].

        Returns
        -------
        Machine
            A new machine.

        Raises
        ------
        InputError
            If the frequency is out of its range, or the machine is a crank.
        """
        self._require_springs("natural_frequency", natural_frequency)
        problems = Problems()
        value = self._naturals(problems, natural_frequency)
        if value.shape:
            problems.add(f"natural_frequency = {shown(natural_frequency)}: must be one real number")
        problems.settle()
        return self._changed(natural_frequency=float(value))

    @shielded
    def response(
        self,
        frequency: ArrayLike,
        *,
        setting: ArrayLike = 1.0,
        voltage: ArrayLike = 1.0,
        added_mass: Any = 0.0,
        natural_frequency: ArrayLike | None = None,
    ) -> Response:
        """Return the steady motion of the machine: amplitudes, phase, natural frequency and elasticities.

        Parameters
        ----------
        frequency : array_like
            Drive frequency, > 0 [Hz].
        setting : array_like, optional
            Force, static moment or radius over its value at 100 %, > 0 [1].
        voltage : array_like, optional
            Voltage over that at 100 %, > 0; it has an effect on magnets only [1].
        added_mass : complex array_like, optional
            Complex mass ``m (lambda - i delta)`` of the filling; ``vibro.filling`` computes the shares [kg].
        natural_frequency : array_like, optional
            Natural frequencies of other spring packs, as in ``with_natural_frequency`` [Hz].

        Returns
        -------
        Response
            Arrays of the broadcast shape; inf at the resonance of a machine without damping.

        Raises
        ------
        InputError
            If an argument is out of its range, or they do not broadcast.

        Notes
        -----
        Eqs. (83) to (85); within 1e-12 of a computation in 60 digits on 40 machines
        (tests/machines/test_machine.py).

        Examples
        --------
        >>> machine = Machine.magnet(trough_mass=6, natural_frequency=55, damping_ratio=0.02, force=40)
        >>> print(*(f"{1e3 * x:.3f} mm" for x in machine.response(50, added_mass=[0, 0.4]).amplitude))
        0.315 mm 0.451 mm
        """
        f, s, u, f0, added = self.broadcast(frequency, setting, voltage, natural_frequency, added_mass)
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
            return self._response(f, s, u, f0, added)

    def _response(self, f: Floats, s: Floats, u: Floats, f0: Floats, added: Complexes) -> Response:
        zero, one = np.zeros(f.shape), np.ones(f.shape)
        if self.kind == "crank":
            amplitude, nothing = self.radius * s, dict.fromkeys(ELASTICITIES, zero[()])
            return Response(
                amplitude=amplitude[()],
                phase=zero[()],
                counter_amplitude=zero[()],
                relative_amplitude=amplitude[()],
                filled_natural_frequency=np.full(f.shape, math.inf)[()],
                compliance=np.zeros(f.shape, np.complex128)[()],
                elasticities={**nothing, "setting": one[()]},
            )
        found = transfer(self, f, f0, added)
        force = self.force_at(f, s, u)
        slope = _slopes(self, f, found)
        return Response(
            amplitude=(force * np.abs(found.trough))[()],
            phase=np.angle(found.trough + 0.0)[()],
            counter_amplitude=(force * np.abs(found.counter))[()],
            relative_amplitude=(force * np.abs(found.relative))[()],
            filled_natural_frequency=self.filled_natural_frequency(f0, added.real)[()],
            compliance=found.compliance[()],
            elasticities={
                "setting": one[()],
                "voltage": (self.voltage_exponent * one)[()],
                **{name: value[()] for name, value in slope._asdict().items()},
            },
        )

    def broadcast(
        self,
        frequency: ArrayLike,
        setting: ArrayLike,
        voltage: ArrayLike,
        natural_frequency: ArrayLike | None,
        added_mass: Any = 0.0,
    ) -> tuple[Floats, Floats, Floats, Floats, Complexes]:
        """Check the arguments of ``response`` and broadcast them against each other.

        Returns
        -------
        frequency, setting, voltage, natural_frequency, added_mass : array
            Arrays of the common shape.
        """
        if natural_frequency is not None:
            self._require_springs("natural_frequency", natural_frequency)
        problems = Problems()
        own = np.asarray(self.natural_frequency)
        real = [
            _positive(problems, "frequency", frequency, "Hz"),
            _positive(problems, "setting", setting),
            _positive(problems, "voltage", voltage),
            own if natural_frequency is None else self._naturals(problems, natural_frequency),
        ]
        added = _complex(problems, added_mass)
        problems.settle()
        f, s, u, f0, m = broadcast(
            ("frequency", "setting", "voltage", "natural_frequency", "added_mass"), (*real, added)
        )
        return f, s, u, f0, m

    def _naturals(self, problems: Problems, natural_frequency: ArrayLike) -> Floats:
        least = 0.0 if self.kind == "unbalance" else None
        if self.rod_stiffness:  # the springs cannot be softer than the rod's among them
            least = math.sqrt(self.rod_stiffness / self.trough_mass) / (TURN)
        return _positive(problems, "natural_frequency", natural_frequency, "Hz", least)

    def force_at(self, frequency: Any, setting: Any = 1.0, voltage: Any = 1.0) -> Any:
        """Return the amplitude of the force [N].

        Parameters
        ----------
        frequency : array_like
            Drive frequency [Hz].
        setting, voltage : array_like, optional
            Setting and voltage over those at 100 % [1].
        """
        ratio = frequency / self.force_frequency
        return self.force * setting * voltage**self.voltage_exponent * ratio**self.force_exponent

    def filled_natural_frequency(self, natural_frequency: Floats, added: Floats) -> Floats:
        """Return the natural frequency with a mass added to the trough.

        Parameters
        ----------
        natural_frequency : array
            Natural frequency of the empty machine [Hz].
        added : array
            Added mass, which may be negative [kg].

        Returns
        -------
        array
            Natural frequency; inf where a negative added mass leaves no mass of the trough [Hz].
        """
        r, m1 = 1.0 / self.counter_mass, self.trough_mass
        filled = m1 + added
        ratio = (m1 / filled) * ((1.0 + filled * r) / (1.0 + m1 * r))
        return natural_frequency * np.sqrt(np.where(ratio > 0.0, ratio, math.inf))

    @property
    def reduced_mass(self) -> float:
        """Mass mu that the springs move against each other [kg]."""
        return self.trough_mass / (1.0 + self.trough_mass * (1.0 / self.counter_mass))

    @shielded
    def load_proof_frequency(self, frequency: float) -> float:
        """Return the natural frequency at which the amplitude does not depend on the filling, Eq. (86).

        Parameters
        ----------
        frequency : float
            Drive frequency, > 0 [Hz].

        Returns
        -------
        float
            Natural frequency of the empty machine, for which the counter mass acts as an absorber; exact
            without damping [Hz].

        Raises
        ------
        InputError
            If the machine has no counter mass, or its base mount is too stiff.
        """
        read = _Reading(self.kind)
        f = read.number("frequency", frequency)
        read.settle()
        if not self.counter_mass < math.inf:
            raise InputError(
                f"counter_mass = {self.counter_mass:.15g} kg: no spring pack makes this machine load-proof",
                hint="it takes two masses, one of them free to move: the counter mass acts as an absorber",
            )
        stiffness = self.counter_mass * (TURN * f) ** 2 - self.base_stiffness
        if not stiffness > 0.0:
            raise InputError(
                f"base_stiffness = {self.base_stiffness:.15g} N/m: must be < m2 w^2 ="
                f" {self.counter_mass * (TURN * f) ** 2:.6g} N/m for a load-proof pack",
                hint="mount the counter mass softer",
            )
        return math.sqrt(stiffness / self.reduced_mass) / (TURN)

    @shielded
    def load_proof_force(self, frequency: float) -> float:
        """Return the force needed with the load-proof spring pack, over that with the present pack [1].

        Both forces give the empty trough the same amplitude. Parameters and errors are those of
        ``load_proof_frequency``.
        """
        pack = self.with_natural_frequency(self.load_proof_frequency(frequency))
        own, other = (float(m.response(frequency).amplitude) for m in (self, pack))
        return own / other

    @shielded
    def mass_to_resonance(
        self, frequency: ArrayLike, *, natural_frequency: ArrayLike | None = None
    ) -> Floats:
        """Return the mass that, added to the trough, brings the machine into resonance.

        Parameters
        ----------
        frequency : array_like
            Drive frequency, > 0 [Hz].
        natural_frequency : array_like, optional
            Natural frequencies of other spring packs [Hz].

        Returns
        -------
        array
            Added mass, that is ``filling * added_mass_share`` of a filling, computed without base mount and
            damping [kg]. It is negative if the drive is above resonance, so that a filling moves the machine
            away from it; inf if no mass is large enough, and for a crank.

        Raises
        ------
        InputError
            If an argument is out of its range, or they do not broadcast.

        Examples
        --------
        >>> machine = Machine.magnet(trough_mass=6, natural_frequency=55, damping_ratio=0.02, force=40)
        >>> print(f"{machine.mass_to_resonance(50):.2f} kg")
        1.26 kg
        """
        f, _, _, f0, _ = self.broadcast(frequency, 1.0, 1.0, natural_frequency)
        if self.kind == "crank":
            return np.full(f.shape, math.inf)[()]
        r, m1 = 1.0 / self.counter_mass, self.trough_mass
        with np.errstate(divide="ignore", over="ignore", invalid="ignore"):
            detuning = (f0 - f) * (f0 + f)  # f0^2 - f^2, exact near resonance
            left = f**2 / m1 - detuning * r  # f0^2 over the filled trough mass
            added = detuning * (1.0 + m1 * r) / left
        return np.where(left > 0.0, added, math.inf)[()]

    def _calibrated(self, known: Calibration) -> Machine:
        reached = self.response(
            known.frequency, setting=known.setting, voltage=known.voltage, added_mass=known.filling
        )
        return self._changed(force=self.force * known.amplitude / float(reached.amplitude))

    def _require_springs(self, name: str, value: Any) -> None:
        if self.kind == "crank":
            raise InputError(
                f"{name} = {shown(value)}: must be left out of a crank, whose amplitude is its radius",
                hint="Machine.rod is a crank that acts through springs",
                fields=[name],
            )


class _Reading(Problems):
    """Reads the numbers of one kind of machine, and collects what is wrong with them."""

    def __init__(self, kind: str) -> None:
        super().__init__(f"Machine.{kind}: ")
        self._kind = kind

    def number(self, name: str, value: Any) -> float:
        """Read a number by its name; NaN after a problem."""
        unit = f" {_UNITS.get(name, '')}".rstrip()
        if value is None:
            self.add(f"{name}: missing", _REMEDIES.get(name, f"give {name} [{unit[1:] or 1}]"), name)
            return math.nan
        try:
            x = real_number(value)
        except NotRealError as exc:
            self.add(f"{name} = {exc.value}: must be {exc.allowed}", field=name)
            return math.nan
        is_finite, sign = name not in _MAY_BE_INFINITE, ">=" if name in _MAY_BE_0 else ">"
        if not (x > 0.0 or (x == 0.0 and sign == ">=")) or (is_finite and x == math.inf):
            allowed = f"{'finite and ' * is_finite}{sign} 0{unit}"
            self.add(f"{name} = {x:.15g}{unit}: must be {allowed}", field=name)
            return math.nan
        if name == "damping_ratio" and x >= 1.0:
            remedy = f"of {x:.15g} % give {x / 100.0:.6g}" if x < 100.0 else ""
            self.add(f"damping_ratio = {x:.15g}: must be in [0, 1)", remedy, name)
        return x

    def fields(self, given: Mapping[str, Any]) -> dict[str, float]:
        """Read the numbers of the kind, and return the fields of ``Machine`` that follow from them."""
        numbers = {name: self.number(name, given[name]) for name in _KINDS[self._kind]}
        fields = {_FIELDS.get(name, name): x for name, x in numbers.items()}
        floor = fields.get("counter_mass") == math.inf
        if floor and fields.get("base_stiffness", 0.0) > 0.0:
            self.add(
                f"base_stiffness = {fields['base_stiffness']:.15g} N/m: must be left out where the springs"
                " stand on the floor",
                "give the counter_mass that stands on that mount",
                "base_stiffness",
            )
        if floor and self._kind == "exciter":
            text = "counter_mass = inf kg: must be finite, as the motors sit on it"
            self.add(text, field="counter_mass")
        if "static_moment" in fields:  # F = S w^2, here at 1 Hz
            fields |= {"force": fields.pop("static_moment") * TURN**2, "force_exponent": 2.0}
        if self._kind == "rod":  # F = k_r R
            rod, total = (
                fields["rod_stiffness"],
                fields["trough_mass"] * (TURN * fields["natural_frequency"]) ** 2,
            )
            fields["force"] = rod * fields.pop("radius")
            if rod > total:
                self.add(
                    f"rod_stiffness = {rod:.15g} N/m: must be <= {total:.6g} N/m, that of all springs",
                    "natural_frequency is that on all springs, with the rod's while the crank stands",
                    "rod_stiffness",
                )
        return fields

    def calibration(self, given: object) -> Calibration | None:
        """Read the numbers of a calibration."""
        if not isinstance(given, Calibration):
            self.add(f"calibration = {shown(given)}: must be a vibro.Calibration", field="calibration")
            return None
        return Calibration(*(self.number(name, getattr(given, name)) for name in _CALIBRATION))


def broadcast(names: tuple[str, ...], arrays: tuple[Any, ...]) -> tuple[Any, ...]:
    """Broadcast arguments against each other; InputError with their shapes if that cannot be."""
    try:
        return tuple(np.broadcast_arrays(*arrays))
    except ValueError:
        shapes = ", ".join(f"{name} {np.shape(x)}" for name, x in zip(names, arrays, strict=True))
        raise InputError(f"shapes = {shapes}: must be broadcastable against each other") from None


def _positive(
    problems: Problems, name: str, value: Any, unit: str = "", least: float | None = None
) -> Floats:
    """Read an array of finite numbers > 0, or >= ``least``."""
    try:
        x = real_array(value)
    except NotRealError as exc:
        problems.add(f"{name} = {exc.value}: must be {exc.allowed}", field=name)
        return np.ones(())
    good = np.isfinite(x) & ((x > 0.0) if least is None else (x >= least))
    if not np.all(good):
        unit = f" {unit}" if unit else ""
        allowed = f"finite and > 0{unit}" if least is None else f"finite and >= {least:.6g}{unit}"
        wrong = float(x[~good].flat[0])
        problems.add(f"{name} = {wrong:.15g}{unit}: must be {allowed}", field=name)
    return x


def _complex(problems: Problems, value: Any) -> Complexes:
    array = np.asarray(value)
    if array.dtype.kind in "fciu" and np.all(np.isfinite(array)):
        return array.astype(np.complex128)
    problems.add(f"added_mass = {shown(value)}: must be finite numbers, real or complex", field="added_mass")
    return np.zeros((), np.complex128)


def driven(machine: Machine, f: Floats, s: Floats, u: Floats, f0: Floats) -> tuple[Floats, Transfer | None]:
    """Return the empty machine's amplitude and its transfer; None for a crank, whose amplitude is fixed."""
    if machine.kind == "crank":
        return machine.radius * s, None
    found = transfer(machine, f, f0, 0.0)
    return machine.force_at(f, s, u) * np.abs(found.trough), found
