"""Boxes of the solver, drawn or by hand, and bodies of them as scenes (shares the record ``Box``)."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np
from hypothesis import strategies as st

from vibro import Regime, Scene, solve
from vibro.core.boxes import AXES, Box

if TYPE_CHECKING:
    from collections.abc import Callable

    from vibro import SteadyCycle

GRAVITY = 9.81
FREQUENCY = 15.0


def box_of(low: Any, high: Any = None, **fields: Any) -> Box:
    """Make a box of its ends; of a line unless ``ellipse``, at 15 Hz unless ``frequency`` is a band."""
    low = [float(x) for x in low]
    high = low if high is None else [float(x) for x in high]
    f_low, f_high = fields.pop("frequency", (FREQUENCY, FREQUENCY))
    known: dict[str, Any] = {
        "low": low, "high": high, "ellipse": False, "ratio_low": 0.0, "ratio_high": 1.0,
        "factor_low": low[0] * GRAVITY / (2.0 * math.pi * f_high) ** 2,
        "factor_high": high[0] * GRAVITY / (2.0 * math.pi * f_low) ** 2,
        "frequency_low": f_low, "frequency_high": f_high, "gravity": GRAVITY, "way": 1.0,
        "highest": int(Regime.HOPPING),
    }  # fmt: skip
    return Box(**(known | fields))


def bodies(box: Box, shares: Any) -> SteadyCycle:
    """Solve the bodies at shares of the bands, (AXES, n) and of the frequencies, where friction can be so."""
    low, high = np.array(box.low)[:, None], np.array(box.high)[:, None]
    x = np.clip(low + shares[:AXES] * (high - low), low, high)
    ratio = np.clip(x[6], box.ratio_low * x[5], box.ratio_high * x[5])
    kept = (ratio >= low[6]) & (ratio <= high[6])
    f = box.frequency_low + shares[AXES] * (box.frequency_high - box.frequency_low)
    factor = x[0] * box.gravity / (2.0 * math.pi * f) ** 2
    fields: dict[str, Any] = {
        "frequency": f, "trough_angle": x[4], "static_friction": x[5], "kinetic_friction": ratio,
    }  # fmt: skip
    if box.ellipse:
        fields |= {
            "along_amplitude": factor * x[1], "normal_amplitude": factor * x[2], "normal_phase": x[3],
        }  # fmt: skip
    else:
        fields |= {"amplitude": factor, "drive_angle": x[1]}
    return solve(Scene(**{name: value[kept] for name, value in fields.items()}), flight=False)


def largest_speed(box: Box) -> float:
    """Return the trough's, at its largest amplitude [m/s]."""
    size = max(box.high[1], box.high[2]) if box.ellipse else 1.0
    return 2.0 * math.pi * box.frequency_high * box.factor_high * size


@st.composite
def solver_boxes(draw: Callable[[Any], Any], *, widest: float = 0.3, steep: bool = False) -> Box:
    """Draw boxes in contact; the widths of half of the axes are 0."""
    width = [draw(st.sampled_from([0.0, 0.0, 1e-4, 1e-2, 0.1, 1.0])) * widest for _ in range(AXES)]
    mu_s = draw(st.floats(0.1, 1.0))
    mu_d = mu_s * draw(st.one_of(st.just(1.0), st.floats(0.3, 1.0)))
    beta = math.atan(mu_d) * draw(st.one_of(st.just(0.0), st.floats(-1.5 if steep else -0.9, 0.9)))
    ellipse = draw(st.booleans())
    if ellipse:
        along = draw(st.sampled_from([1e-3, 1e-3, 1e-3, 0.0]))
        normal, phase = 1e-3 * draw(st.floats(0.01, 2.0)), draw(st.floats(-math.pi, math.pi))
        low = [along, normal, phase]
        high = [along + 1e-3 * width[1], normal * (1.0 + width[2]), phase + 3.0 * width[3]]
    else:
        low = [draw(st.floats(0.0, 1.0)), 0.0, 0.0]
        high = [low[0] + 0.3 * width[1], 0.0, 0.0]
    troughs = [beta, beta + 0.2 * width[4]]
    normal = high[1] if ellipse else math.sin(high[0])
    hop = min(map(math.cos, troughs)) / max(normal, 0.05 * (1e-3 if ellipse else 1.0))
    load = hop * draw(st.one_of(st.just(1.0), st.floats(0.1, 1.0)))
    static = [mu_s, mu_s * (1.0 + width[5])]
    kinetic = [mu_d * (1.0 - width[6]), min(mu_d * (1.0 + width[6]), static[1])]
    ratio = (0.0, 1.0)
    if draw(st.booleans()):
        ratio = kinetic[0] / static[0], min(kinetic[1] / static[0], 1.0)
        kinetic = [ratio[0] * static[0], ratio[1] * static[1]]
    return box_of(
        [load * (1.0 - 0.5 * width[0]), *low, troughs[0], static[0], kinetic[0]],
        [load, *high, troughs[1], static[1], max(kinetic)],
        ellipse=ellipse, ratio_low=ratio[0], ratio_high=ratio[1], way=draw(st.sampled_from([1.0, -1.0])),
        frequency=draw(st.sampled_from([(15.0, 15.0), (14.0, 15.0)])),
    )  # fmt: skip
