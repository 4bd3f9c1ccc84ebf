"""What pictures of numbers show: headings, scales, and results."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final, NamedTuple

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Mapping

    from vibro.reals import Floats


# [m/s] Keeps times finite where the body moves backwards or rests.
_LEAST_VELOCITY: Final = 1e-12
_MILLIMETRE: Final = 1e3  # [1/m]


class Subject(NamedTuple):
    """Heading, label of the scale, attribute of ``SteadyCycle``, size over its unit, whether of flight."""

    heading: str
    label: str
    result: str
    size: float = _MILLIMETRE
    in_flight: bool = False

    def in_unit(self, values: Floats, length: float | None) -> Floats:
        """Return numbers of its result in its unit; times over a length [mm]."""
        if self is SUBJECTS["traverse"]:
            return (length or np.nan) / (_MILLIMETRE * np.maximum(values, _LEAST_VELOCITY))
        return self.size * values


SUBJECTS: Final[Mapping[str, Subject]] = {
    "speed": Subject("Mean conveying speed", "mean conveying speed [mm/s]", "mean_velocity"),
    "traverse": Subject("Traverse time", "traverse time [s]", "mean_velocity"),
    "impact": Subject(
        "Impact speed", "impact speed, normal to the trough [mm/s]", "impact_velocity", in_flight=True
    ),
    "flight": Subject(
        "Time in flight", "share of time in flight", "flight_fraction", size=1.0, in_flight=True
    ),
}


def heading_of(picture: str, length: float | None) -> str:
    """Return the heading of a picture; that of times says over which length [mm]."""
    if picture == "regime":
        return "Steady regimes"
    return SUBJECTS[picture].heading + (f" over {length:.6g} mm" if picture == "traverse" else "")
