"""Boxes of bands for the tests: drawn at random, sampled, and questions of the reference table."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from hypothesis import strategies as st

from vibro import Regime, Scene, SteadyCycle, solve
from vibro.designs.proofs import back_slip_load
from vibro.designs.questions import Drive, Goal, Question, Spec
from vibro.designs.spaces import uncertainty_set
from vibro.drives import Line

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import NDArray

    from vibro.results.designs import Guarantee

    Floats = NDArray[np.float64]
    Span = tuple[float, float]

FREQUENCY = 15.0
GRAVITY = 9.81
REGIMES = {r.label: r for r in (Regime.FORWARD_SLIP, Regime.BACK_SLIP, Regime.HOPPING)}
ROWS = json.loads((Path(__file__).parents[1] / "data" / "design_specs.json").read_text(encoding="utf-8"))


class Boxed(NamedTuple):
    """A scene and bands about it."""

    scene: Scene
    bands: dict[str, Any]

    def span(self, name: str) -> Any:
        """Return the band of a field, of no width where it has none."""
        if name in self.bands:
            return self.bands[name]
        value = float(getattr(self.scene, name))
        return value, value

    def samples(self, logarithm: int = 15) -> SteadyCycle:
        """Solve 2**logarithm points of the box; a tenth of each band lies at either end of it."""
        from scipy.stats import qmc  # late: it takes a fifth of a second to load

        names = ["amplitude", "frequency", "drive_angle", "trough_angle", "static_friction"]
        second = "friction_ratio" if "friction_ratio" in self.bands else "kinetic_friction"
        shares = qmc.Sobol(6, rng=np.random.default_rng(0)).random_base2(logarithm).T
        shares = np.clip((shares - 0.5) * 1.25 + 0.5, 0.0, 1.0)
        ends = (self.span(name) for name in [*names, second])
        fields: dict[str, Any] = {
            name: low + share * (high - low)
            for name, share, (low, high) in zip([*names, second], shares, ends, strict=True)
        }
        if second == "friction_ratio":
            fields["kinetic_friction"] = fields.pop("friction_ratio") * fields["static_friction"]
        inside = fields["kinetic_friction"] <= fields["static_friction"]
        return solve(Scene(**{name: values[inside] for name, values in fields.items()}))


def tolerance(guarantee: Guarantee) -> float:
    """Relative tolerance of the ends of a guarantee, by its proofs."""
    return 1e-9 if guarantee.proof_min == guarantee.proof_max == "corners" else 1e-6


@st.composite
def boxes(
    draw: Callable[[st.SearchStrategy[float]], float],
    *,
    most_load: float = 0.98,
    drifts: bool = False,
    forward: bool = False,
) -> Boxed:
    """Draw boxes in contact on level, climbing and declining troughs where parts do not run away.

    The largest load is a share of that of the first hop or, ``forward``, of the first slip back if that is
    less: at most ``most_load``. Frictions have bands; with ``drifts`` the rest too, but for the frequency.
    """
    low = draw(st.floats(0.1, 0.8))
    static = (low, low * draw(st.floats(1.0, 1.6)))
    least = draw(st.floats(0.3, 0.95))
    ratio = (least, least + draw(st.floats(0.0, 1.0)) * (1.0 - least))
    slope = draw(st.sampled_from([0.0, 1.0, -1.0])) * draw(st.floats(0.05, 0.7))
    trough = slope * math.atan(low * ratio[0])
    # with the widest bands below, drive and trough stay short of a right angle together
    drive = min(math.radians(draw(st.floats(2.0, 60.0))), 0.5 * math.pi - 0.11 - 1.1 * max(trough, 0.0))
    bands: dict[str, Any] = {"static_friction": static}
    if draw(st.booleans()):
        bands["friction_ratio"] = ratio
    else:
        bands["kinetic_friction"] = (low * ratio[0], low * ratio[1])
    drift = 0.0
    if drifts:
        drift = draw(st.floats(0.0, 0.05))
        bands["drive_angle"] = (drive, drive + draw(st.floats(0.0, 0.1)))
        bands["trough_angle"] = (trough - 0.1 * abs(trough), trough + 0.1 * abs(trough))
    scene = Scene(
        amplitude=1.0,
        frequency=FREQUENCY,
        drive_angle=drive,
        static_friction=static[1],
        kinetic_friction=low * ratio[0],
        trough_angle=trough,
    )
    box = uncertainty_set(scene, bands)
    most = float(box.hop_load)
    if forward:
        most = min(most, float(back_slip_load(box)))
    load = most * draw(st.floats(0.1, most_load))
    largest = load * GRAVITY / (2.0 * math.pi * FREQUENCY) ** 2
    if drifts:
        bands["amplitude"] = (largest * (1.0 - drift), largest)
    return Boxed(with_fields(scene, amplitude=largest), bands)


def with_fields(scene: Scene, **values: float) -> Scene:
    """Change some fields of a scene."""
    return Scene(**{**{name: float(x) for name, x in scene.arrays()._asdict().items()}, **values})


def friction_of(row: dict[str, Any]) -> dict[str, Any]:
    """Read the friction bands of a row of the reference."""
    static = row["mu_s"]
    bands: dict[str, Any] = {"static_friction": (static[0], static[1])}
    name = "friction_ratio" if "mu_d_over_mu_s" in row else "kinetic_friction"
    low, high = row.get("mu_d_over_mu_s") or row["mu_d"]
    return {**bands, name: (low, high)}


def question_of(row: dict[str, Any]) -> Question:
    """Read a row of the reference that asks for settings; a single value is a range without width."""

    def span(value: float | list[float]) -> Span:
        low, high = value if isinstance(value, list) else (value, value)
        return float(low), float(high)

    low, high = span(row["drive_angle_deg"])
    highest = REGIMES[row["regime"]]
    trough = math.radians(row["trough_angle_deg"])
    drive = Drive(
        name=row["id"],
        kind=Line,
        choices={
            "amplitude": ((0.0, row.get("amplitude_max_mm", math.inf) / 1e3),),
            "frequency": (span(row["frequency_hz"]),),
            "drive_angle": ((math.radians(low), math.radians(high)),),
        },
        acceleration=row.get("acceleration_max_g", math.inf),
    )
    bands = {**friction_of(row), "trough_angle": (trough, trough)}
    return Question(Spec(bands, (drive,), Goal(row["target_mm_s"] / 1e3, highest)), drive, highest)
