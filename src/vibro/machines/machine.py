"""The machines that drive troughs: their data, and the amplitude that follows from them."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, Final, Literal, NamedTuple

import numpy as np

from vibro.core.numbers import TURN
from vibro.errors import InputError, Problems, shown
from vibro.quantities import QUANTITIES
from vibro.reals import NotRealError, real_array, real_number, shielded
from vibro.threads import doors

if TYPE_CHECKING:
    from collections.abc import Mapping

    from numpy.typing import ArrayLike

    from vibro.reals import Complexes, Floats


# ------------------------------------------------------------------------------
# Kinds of machine: the numbers that describe each, and the force that drives it, Eq. (80).


class _Number(NamedTuple):
    """A number that describes a machine: finite and > 0, unless it may be 0 or infinite."""

    unit: str = ""
    may_be_0: bool = False
    may_be_infinite: bool = False
    below: float = math.inf
    remedy: str = ""

    def allowed(self, least: float | None) -> str:
        """Return its range in words."""
        if self.below < math.inf:
            return f"in [0, {self.below:g})"
        bound = f">= {least:.6g}" if least is not None else ">= 0" if self.may_be_0 else "> 0"
        return f"{'' if self.may_be_infinite else 'finite and '}{bound} {self.unit}".rstrip()


_NUMBERS: Final = {
    "trough_mass": _Number("kg"),
    "vibrating_mass": _Number("kg"),
    "counter_mass": _Number("kg", may_be_infinite=True),
    "natural_frequency": _Number(
        "Hz",
        remedy="measure it: let the empty machine ring down, or fit amplitudes over frequencies on both sides"
        " of resonance; which side of resonance the drive is on decides what a filling does",
    ),
    "mount_frequency": _Number("Hz", may_be_0=True),
    "damping_ratio": _Number(
        may_be_0=True,
        below=1.0,
        remedy="count the cycles n in which the free vibration halves: it is 0.11 / n; leaf springs have 0.01"
        " to 0.05",
    ),
    "base_stiffness": _Number("N/m", may_be_0=True),
    "rod_stiffness": _Number("N/m"),
    "radius": _Number("m"),
    "gap": _Number("m", may_be_infinite=True),
    "static_moment": _Number("kg m"),
    "force": _Number("N"),
    "force_frequency": _Number("Hz"),
    "voltage_exponent": _Number(may_be_0=True),
    "amplitude": _Number("m"),
    "frequency": _Number("Hz"),
    "setting": _Number(),
    "voltage": _Number(),
    "filling": _Number("kg", may_be_0=True),
}
_SPRINGS: Final = ("trough_mass", "counter_mass", "natural_frequency", "damping_ratio", "base_stiffness")
#: Numbers of each kind of machine, by the names of the arguments of its classmethod.
_KINDS: Final = {
    "unbalance": ("vibrating_mass", "mount_frequency", "damping_ratio", "static_moment"),
    "magnet": (*_SPRINGS, "voltage_exponent", "gap"),
    "exciter": (*_SPRINGS, "static_moment"),
    "crank": ("radius",),
    "rod": ("trough_mass", "natural_frequency", "damping_ratio", "rod_stiffness", "radius"),
    "measured": ("trough_mass", "counter_mass", "voltage_exponent", "gap"),
}
_FIELDS: Final = {"vibrating_mass": "trough_mass", "mount_frequency": "natural_frequency"}  # of Machine
_LAWS: Final = {"current": 0.0, "voltage": -2.0}  # exponent of a magnet's force over the frequency
_CALIBRATION: Final = ("amplitude", "frequency", "setting", "voltage", "filling")


def _checked(
    problems: Problems, name: str, value: Any, *, one: bool = False, least: float | None = None
) -> Floats:
    """Read one number, or an array, in the range of its name, or from ``least`` on; NaN after a problem."""
    number = _NUMBERS[name]
    if value is None:
        problems.add(f"{name}: missing", number.remedy or f"give {name} [{number.unit or 1}]", name)
        return np.array(math.nan)
    try:
        x = np.asarray(real_number(value)) if one else real_array(value)
    except NotRealError as exc:
        problems.add(f"{name} = {exc.value}: must be {exc.allowed}", field=name)
        return np.array(math.nan)
    low, with_low = (0.0, number.may_be_0) if least is None else (least, True)
    good = ((x > low) | (x == low) & with_low) & ((x < number.below) | (number.may_be_infinite & (x > 0.0)))
    if good.all():
        return x
    wrong, remedy = float(x[~good].flat[0]), ""
    if name == "damping_ratio" and 1.0 <= wrong < 100.0:
        remedy = f"of {wrong:.15g} % give {wrong / 100.0:.6g}"
    text = f"{name} = {wrong:.15g} {number.unit}".rstrip()
    problems.add(f"{text}: must be {number.allowed(least)}", remedy, name)
    return np.array(math.nan)


def _fields_of(kind: str, given: Mapping[str, Any], problems: Problems) -> dict[str, float]:
    """Read the numbers of a kind, and return the fields of ``Machine`` that follow from them."""
    numbers = {name: float(_checked(problems, name, given[name], one=True)) for name in _KINDS[kind]}
    fields = {_FIELDS.get(name, name): x for name, x in numbers.items()}
    if fields.get("counter_mass") == math.inf:
        if fields.get("base_stiffness", 0.0) > 0.0:
            base = f"base_stiffness = {fields['base_stiffness']:.15g} N/m"
            why, hint = "the springs stand on the floor", "give the counter_mass that stands on that mount"
            problems.add(f"{base}: must be left out where {why}", hint, "base_stiffness")
        if kind == "exciter":
            text = "counter_mass = inf kg: must be finite, as the motors sit on it"
            problems.add(text, field="counter_mass")
    if "static_moment" in fields:  # F = S w^2, here at 1 Hz
        fields |= {"force": fields.pop("static_moment") * TURN**2, "force_exponent": 2.0}
    if kind == "crank":
        fields["force"] = fields.pop("radius")
    if kind == "rod":  # F = k_r e
        rod = fields["rod_stiffness"]
        springs = fields["trough_mass"] * (TURN * fields["natural_frequency"]) ** 2
        fields["force"] = rod * fields.pop("radius")
        if rod > springs:
            text = f"rod_stiffness = {rod:.15g} N/m: must be <= {springs:.6g} N/m, that of all springs"
            hint = "natural_frequency is that on all springs, with the rod's while the crank stands"
            problems.add(text, hint, "rod_stiffness")
    return fields


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
    """

    amplitude: Floats
    phase: Floats
    counter_amplitude: Floats
    relative_amplitude: Floats
    filled_natural_frequency: Floats
    compliance: Complexes


# ------------------------------------------------------------------------------
# A linear machine of one or two masses, Eq. (81): its motion for a force of 1 N.


class Transfer(NamedTuple):
    """Motion of the masses over the force; arrays of one shape.

    Attributes
    ----------
    trough, counter, relative : complex array
        X_1, X_2 and X_1 - X_2 over F [m/N]; of a crank over its radius [1].
    compliance : complex array
        H of Eq. (85), A / A_0 = 1 / abs(1 + m H) for a complex added mass m [1/kg].
    filled_natural_frequency : array
        With the real part of the added mass [Hz].
    """

    trough: Complexes
    counter: Complexes
    relative: Complexes
    compliance: Complexes
    filled_natural_frequency: Floats


def springs_of(machine: Machine) -> tuple[float | bool, ...]:
    """Return the machine as the solver takes it: ``Springs``."""
    masses = machine.trough_mass, machine.counter_mass
    numbers = (*masses, machine.damping_ratio, machine.base_stiffness, machine.gap)
    return (*map(float, numbers), machine.kind == "exciter", *QUANTITIES["amplitude"].si_ends)


def transfer(machine: Machine, frequency: Floats, natural_frequency: Floats, added: Complexes) -> Transfer:
    """Solve Eq. (81) for a force of 1 N.

    Parameters
    ----------
    machine : Machine
        Its masses, damping, and mount.
    frequency, natural_frequency : array
        Of the drive and of the empty machine between its masses, without the base mount [Hz].
    added : complex array
        The filling's mass m (lambda - i delta), all of one shape [kg].
    """
    given = np.empty((4, *frequency.shape))
    given[0], given[1], given[2], given[3] = frequency, natural_frequency, added.real, added.imag
    moved, filled = np.empty((frequency.size, 8)), np.empty(frequency.shape)
    solver = doors()
    out = solver.row(moved), solver.row(filled)
    solver.transfers(springs_of(machine), *solver.rows(given.reshape(4, -1)), *out, frequency.size)
    trough, counter, relative, compliance = moved.view(np.complex128).T.reshape(4, *frequency.shape)
    return Transfer(trough, counter, relative, compliance, filled)


@dataclass(frozen=True)
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
        Amplitude of the force at 100 % setting and voltage and at ``force_frequency`` [N]; of a crank, which
        moves the trough itself, its radius [m].
    force_frequency, force_exponent : float
        The force is proportional to ``(frequency / force_frequency) ** force_exponent`` [Hz], [1].
    voltage_exponent : float
        The force is proportional to ``voltage ** voltage_exponent`` [1].
    gap : float
        Relative amplitude at which the masses strike each other [m].

    Examples
    --------
    >>> feeder = Machine.magnet(trough_mass=6, counter_mass=12, natural_frequency=50 / 1.05,
    ...                         damping_ratio=0.015, calibration=Calibration(0.35e-3, 50))
    >>> print(f"{feeder.force:.1f} N, {feeder.load_proof_frequency(50):.1f} Hz")
    20.2 N, 86.6 Hz
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
    gap: float = math.inf

    @classmethod
    def _made(cls, kind: str, given: Mapping[str, Any]) -> Machine:
        """Make a machine that the numbers of its kind describe."""
        problems = Problems(f"Machine.{kind}: ")
        fields = _fields_of(kind, given, problems)
        problems.settle()
        return cls(kind, **fields)

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
        cls, *, trough_mass: float, counter_mass: float = math.inf, natural_frequency: float | None = None,
        damping_ratio: float | None = None, force: float | None = None,
        calibration: Calibration | None = None, voltage_exponent: float = 2.0,
        law: Literal["current", "voltage"] = "current",
        force_frequency: float | None = None, base_stiffness: float = 0.0, gap: float = math.inf,
    ) -> Machine:  # fmt: skip
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
        problems = Problems("Machine.magnet: ")
        fields = _fields_of("magnet", locals(), problems)
        if law not in _LAWS:
            problems.add(f"law = {shown(law)}: must be 'current' or 'voltage'", field="law")
        if (force is None) == (calibration is None):
            problems.add(
                f"force = {shown(force)} and calibration = {shown(calibration)}: must be one or the other",
                "give the force, or one amplitude that was measured:"
                " calibration=vibro.Calibration(amplitude=0.35e-3, frequency=50)",
                "force",
            )
        fields["force"] = 1.0 if force is None else float(_checked(problems, "force", force, one=True))
        known: object = calibration
        if known is not None and not isinstance(known, Calibration):
            wrong = f"calibration = {shown(calibration)}: must be a vibro.Calibration"
            problems.add(wrong, field="calibration")
        elif calibration is not None:
            numbers = ((name, getattr(calibration, name)) for name in _CALIBRATION)
            calibration = Calibration(*(float(_checked(problems, *pair, one=True)) for pair in numbers))
        if law == "voltage":
            at = calibration.frequency if force_frequency is None and calibration else force_frequency
            fields["force_frequency"] = float(_checked(problems, "force_frequency", at, one=True))
        elif force_frequency is not None:
            text = f"force_frequency = {shown(force_frequency)}: must be left out where law = {shown(law)}"
            hint = "only with law='voltage' does the force depend on the frequency"
            problems.add(text, hint, "force_frequency")
        problems.settle()
        machine = cls("magnet", force_exponent=_LAWS[law], **fields)
        if calibration is None:
            return machine
        at_100 = machine.response(
            calibration.frequency,
            setting=calibration.setting,
            voltage=calibration.voltage,
            added_mass=calibration.filling,
        )
        return replace(machine, force=calibration.amplitude / float(at_100.amplitude))

    @classmethod
    @shielded
    def exciter(
        cls, *, trough_mass: float, counter_mass: float, static_moment: float,
        natural_frequency: float | None = None, damping_ratio: float | None = None,
        base_stiffness: float = 0.0,
    ) -> Machine:  # fmt: skip
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
        cls, *, radius: float, rod_stiffness: float, trough_mass: float,
        natural_frequency: float | None = None, damping_ratio: float | None = None,
    ) -> Machine:  # fmt: skip
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
        cls, *, points: Any, trough_mass: float, counter_mass: float = math.inf,
        law: Literal["constant", "square"] = "constant", voltage_exponent: float | None = None,
        gap: float = math.inf,
    ) -> Machine:  # fmt: skip
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
        problems = Problems("Machine.measured: ")
        fields = _fields_of("measured", locals(), problems)
        if is_square and fields["counter_mass"] < math.inf:
            text = f"counter_mass = {counter_mass:.15g} kg: must be left out where law = 'square'"
            hint = "unbalance on a counter mass has law='constant' for the trough"
            problems.add(text, hint, "counter_mass")
        f0, damping = fit.natural_frequency, fit.damping_ratio
        if math.isnan(f0) or math.isnan(damping):
            problems.add(
                f"points: they do not determine the {'natural frequency' if math.isnan(f0) else 'damping'}",
                "measure on both sides of the resonance, some points within 5 % of it; or describe a magnet,"
                " by its natural frequency and damping ratio",
                "points",
            )
        problems.settle()
        # static amplitude times stiffness; times m1 w^2 at 1 Hz where the force grows with the square
        force = fit.static_amplitude * (fields["trough_mass"] * TURN**2) * (1.0 if is_square else f0**2)
        fields |= {"natural_frequency": f0, "damping_ratio": damping, "force": force}
        return cls("measured", force_exponent=2.0 if is_square else 0.0, **fields)

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
        problems = Problems()
        value = self._naturals(problems, natural_frequency)
        if value.shape:
            problems.add(f"natural_frequency = {shown(natural_frequency)}: must be one real number")
        problems.settle()
        return replace(self, natural_frequency=float(value))

    @shielded
    def response(
        self, frequency: ArrayLike, *, setting: ArrayLike = 1.0, voltage: ArrayLike = 1.0,
        added_mass: Any = 0.0, natural_frequency: ArrayLike | None = None,
    ) -> Response:  # fmt: skip
        """Return the steady motion of the machine: amplitudes, phase and natural frequency.

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
        Eqs. (80) to (85); within 1e-12 of a computation in 60 digits on 40 machines
        (tests/machines/test_machine.py).

        Examples
        --------
        >>> machine = Machine.magnet(trough_mass=6, natural_frequency=55, damping_ratio=0.02, force=40)
        >>> print(*(f"{1e3 * x:.3f} mm" for x in machine.response(50, added_mass=[0, 0.4]).amplitude))
        0.315 mm 0.451 mm
        """
        f, s, u, f0, added = self.broadcast(frequency, setting, voltage, natural_frequency, added_mass)
        found = transfer(self, f, f0, added)
        with np.errstate(invalid="ignore", over="ignore"):
            force = self.force_at(f, s, u)
            return Response(
                amplitude=(force * np.abs(found.trough))[()],
                phase=np.angle(found.trough + 0.0)[()],
                counter_amplitude=(force * np.abs(found.counter))[()],
                relative_amplitude=(force * np.abs(found.relative))[()],
                filled_natural_frequency=found.filled_natural_frequency[()],
                compliance=found.compliance[()],
            )

    def broadcast(
        self, frequency: ArrayLike, setting: ArrayLike, voltage: ArrayLike,
        natural_frequency: ArrayLike | None, added_mass: Any = 0.0,
    ) -> tuple[Floats, Floats, Floats, Floats, Complexes]:  # fmt: skip
        """Check the arguments of ``response`` and broadcast them against each other.

        Returns
        -------
        frequency, setting, voltage, natural_frequency, added_mass : array
            Arrays of the common shape.
        """
        problems = Problems()
        given = {"frequency": frequency, "setting": setting, "voltage": voltage}
        arrays: dict[str, Any] = {name: _checked(problems, name, value) for name, value in given.items()}
        own = natural_frequency is None
        arrays["natural_frequency"] = (
            np.asarray(self.natural_frequency) if own else self._naturals(problems, natural_frequency)
        )
        added = np.asarray(added_mass)
        if added.dtype.kind not in "fciu" or not np.all(np.isfinite(added)):
            wrong = f"added_mass = {shown(added_mass)}: must be finite numbers, real or complex"
            problems.add(wrong, field="added_mass")
        problems.settle()
        arrays["added_mass"] = added.astype(np.complex128)
        f, s, u, f0, m = broadcast(arrays)
        return f, s, u, f0, m

    def _naturals(self, problems: Problems, natural_frequency: Any) -> Floats:
        """Read natural frequencies of spring packs, which a crank has not."""
        if self.kind == "crank":
            raise InputError(
                f"natural_frequency = {shown(natural_frequency)}: must be left out of a crank, whose"
                " amplitude is its radius",
                hint="Machine.rod is a crank that acts through springs",
                fields=["natural_frequency"],
            )
        least = 0.0 if self.kind == "unbalance" else None
        if self.rod_stiffness:  # the springs cannot be softer than the rod's among them
            least = math.sqrt(self.rod_stiffness / self.trough_mass) / TURN
        return _checked(problems, "natural_frequency", natural_frequency, least=least)

    def force_at(self, frequency: Any, setting: Any = 1.0, voltage: Any = 1.0) -> Any:
        """Return the amplitude of the force, Eq. (80) [N].

        Parameters
        ----------
        frequency : array_like
            Drive frequency [Hz].
        setting, voltage : array_like, optional
            Setting and voltage over those at 100 % [1].
        """
        ratio = frequency / self.force_frequency
        return self.force * setting * voltage**self.voltage_exponent * ratio**self.force_exponent

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
        problems = Problems(f"Machine.{self.kind}: ")
        f = float(_checked(problems, "frequency", frequency, one=True))
        problems.settle()
        if not self.counter_mass < math.inf:
            raise InputError(
                f"counter_mass = {self.counter_mass:.15g} kg: no spring pack makes this machine load-proof",
                hint="it takes two masses, one of them free to move: the counter mass acts as an absorber",
            )
        inertia = self.counter_mass * (TURN * f) ** 2
        if not (stiffness := inertia - self.base_stiffness) > 0.0:  # k = m2 w^2 - k_b, Eq. (86)
            raise InputError(
                f"base_stiffness = {self.base_stiffness:.15g} N/m: must be < m2 w^2 = {inertia:.6g} N/m for a"
                " load-proof pack",
                hint="mount the counter mass softer",
            )
        return math.sqrt(stiffness / self.reduced_mass) / TURN

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
        r, m1 = 1.0 / self.counter_mass, self.trough_mass
        with np.errstate(divide="ignore", over="ignore", invalid="ignore"):
            detuning = (f0 - f) * (f0 + f)  # f0^2 - f^2, exact near resonance
            left = f**2 / m1 - detuning * r  # f0^2 over the filled trough mass
            added = detuning * (1.0 + m1 * r) / left
        return np.where(left > 0.0, added, math.inf)[()]


def broadcast(arrays: Mapping[str, Any]) -> tuple[Any, ...]:
    """Broadcast arguments against each other; InputError with their shapes if that cannot be."""
    try:
        return tuple(np.broadcast_arrays(*arrays.values()))
    except ValueError:
        shapes = ", ".join(f"{name} {np.shape(x)}" for name, x in arrays.items())
        raise InputError(f"shapes = {shapes}: must be broadcastable against each other") from None
