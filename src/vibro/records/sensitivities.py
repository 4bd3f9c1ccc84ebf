"""What the voltage of a sensor stands for."""

from __future__ import annotations

import math
import re
from typing import TYPE_CHECKING, Final, NamedTuple

from vibro.errors import InputError, cut, shown
from vibro.records.signals import KINDS, MOST, option_of, signal_unit

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

__all__ = ["EXAMPLES", "Sensitivity", "read_sensitivities"]

#: Of each kind of signal a sensitivity as people write it.
EXAMPLES: Final[Mapping[str, str]] = {
    "displacement": "2V/mm",
    "velocity": "20mV/mm/s",
    "acceleration": "100mV/g",
    "force": "50mV/N",
}


class Sensitivity(NamedTuple):
    """What a voltage stands for.

    Attributes
    ----------
    text : str
        As typed.
    role : str
        The column that it is for, a key of ``KINDS``; empty for every voltage of its kind.
    kind : str
        What the sensor measures: a key of ``SIGNAL_UNITS``.
    per_volt : float
        What one volt stands for, in the SI unit of the kind; negative for a sensor that points the other way.
    """

    text: str
    role: str
    kind: str
    per_volt: float

    def serves(self, role: str) -> bool:
        """Whether it is for the column of a signal, if that is a voltage."""
        return self.role == role if self.role else self.kind == KINDS[role]


# Possessive, so that the time of a refusal grows with the length of a text and not with its square.
_SENSITIVITY: Final = re.compile(r"([+-]?+(?:\d++\.?+\d*+|\.\d++)(?:[eE][+-]?+\d++)?+)\s*+([^\W\d].*|\(.*)")
_NOT_FINITE: Final = re.compile(r"[+-]?(?:nan|inf)", re.IGNORECASE)
_DECIMAL_COMMA: Final = re.compile(r"([+-]?\d{1,20}),(\d.{0,20})")
_HINT: Final = f"write it like {', '.join(EXAMPLES.values())} or 125mm/s/V"


def read_sensitivities(texts: Sequence[str]) -> tuple[Sensitivity, ...]:
    """Read the sensitivities of sensors, of which the record holds voltages.

    Parameters
    ----------
    texts : sequence of str
        Such as ``100mV/g``, ``-10.2 mV/(m/s²)`` or ``2mm/V``: its unit says which kind of signal it serves.
        ``trough-along=101.3mV/g`` serves that column alone.

    Raises
    ------
    InputError
        If one is no sensitivity, is 0, not finite, or of no size that could be computed with; or if two of
        them serve the same.
    """
    found: list[Sensitivity] = []
    for text in texts:
        one = _sensitivity(text)
        for other in found:
            if (one.role, "" if one.role else one.kind) == (other.role, "" if other.role else other.kind):
                of = option_of(one.role) if one.role else f"{_article(one.kind)} {one.kind}"
                raise InputError(
                    f"--sensitivity {cut(other.text)} and {cut(one.text)}: each is for {of}",
                    hint="say which column each is for: --sensitivity trough-along=100mV/g",
                )
        found.append(one)
    return tuple(found)


def _article(kind: str) -> str:
    return "an" if kind[0] in "aeiou" else "a"


def _sensitivity(text: str) -> Sensitivity:
    name, equals, value = text.rpartition("=")
    role = name.strip().removeprefix("--").replace("-", "_").casefold()
    said = f"--sensitivity {cut(text)}"
    if equals and (role not in KINDS or role == "time"):
        known = ", ".join(option_of(r).removeprefix("--") for r in KINDS if r != "time")
        raise InputError(f"{said}: {shown(name.strip())} is no signal", hint=f"signals are {known}")
    value = value.strip()
    match = _SENSITIVITY.fullmatch(value)
    if match is None:
        comma = _DECIMAL_COMMA.fullmatch(value)
        if _NOT_FINITE.match(value):
            raise InputError(f"{said}: must be finite and not 0", hint=_HINT)
        hint = f"write a decimal point: {comma[1]}.{comma[2]}" if comma and comma[2].isprintable() else _HINT
        raise InputError(f"{said}: not a number with a unit", hint=hint)
    number, unit_text = float(match[1]), match[2].strip()
    unit = _unit(unit_text)
    if unit is None:
        raise InputError(f"{said}: {shown(unit_text)} is no unit of a sensitivity", hint=_HINT)
    kind, size, inverse = unit
    if role and KINDS[role] != kind:
        raise InputError(
            f"{said}: {shown(unit_text)} is no sensitivity of {_article(KINDS[role])} {KINDS[role]}",
            hint=f"write it like {EXAMPLES[KINDS[role]]}",
        )
    if number == 0.0 or not math.isfinite(number):
        raise InputError(f"{said}: must be finite and not 0", hint=_HINT)
    per_volt = number * size if inverse else size / number
    if not 1.0 / MOST <= abs(per_volt) <= MOST:
        raise InputError(f"{said}: 1 V would be {per_volt:g} in SI units, which is beyond any sensor")
    return Sensitivity(text.strip(), role, kind, per_volt)


def _unit(text: str) -> tuple[str, float, bool] | None:
    """Read ``mV/g``, or the other way round ``mm/V``.

    Returns the kind, the SI units of it in a volt for a number of 1, and whether it is the other way round.
    """
    plain = re.sub(r"\s+(?:per|pro)\s+", "/", text)
    volt, _, measured = plain.partition("/")
    inverse = (signal_unit(volt.strip()) or "")[:1] != ("voltage",)
    if inverse:
        measured, _, volt = plain.rpartition("/")
    of_volt, of_signal = signal_unit(volt.strip()), signal_unit(measured.strip().strip("()[]").strip())
    if of_volt is None or of_volt[0] != "voltage" or of_signal is None or of_signal[0] not in EXAMPLES:
        return None
    return of_signal[0], of_signal[1] / of_volt[1], inverse
