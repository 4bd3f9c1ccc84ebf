"""A question about one drive within a regime: the uncertainty sets of its settings, and their speeds."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from vibro.core.codes import Regime
from vibro.inverse.extremes import ANY_LANDING, Landings, counted
from vibro.inverse.spaces import UncertaintySet, cut, off
from vibro.inverse.tolerances import TOLERANCES
from vibro.limits import stays_upright
from vibro.scene import Scene
from vibro.steady import solve

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from vibro.inverse.scenarios import Scenarios
    from vibro.inverse.spaces import AnySetting, Ends, Points, Space
    from vibro.inverse.specs import Drift, Drive, Span, Spec

    Floats = NDArray[np.float64]

__all__ = ["MOST_DESIGN_THROW", "Question"]

_RIGHT_ANGLE: Final = 0.5 * math.pi
#: [1] Throw number up to which hopping settings are searched: beyond, flights last many cycles, and landings
#: damage parts and drive.
MOST_DESIGN_THROW: Final = 10.0


@dataclass(frozen=True)
class Question:
    """A question about one drive within a regime.

    Attributes
    ----------
    spec : Spec
        The whole question.
    drive : Drive
        The drive.
    highest : Regime
        Highest regime that may occur.
    """

    spec: Spec
    drive: Drive
    highest: Regime

    @property
    def space(self) -> Space:
        """Space of the drive's settings."""
        return self.drive.space

    @property
    def flies(self) -> bool:
        """Whether bodies may hop."""
        return self.highest is Regime.HOPPING

    @cached_property
    def drift(self) -> Drift:
        """Deviations of drive and trough; voltage and filling of a machine add to that of the amplitude."""
        drift, machine = self.spec.drift, self.drive.machine
        if machine is None:
            return drift
        return replace(drift, amplitude=(1.0 + drift.amplitude) * (1.0 + machine.drift) - 1.0)

    @property
    def landings(self) -> Landings:
        """Limits on landings."""
        goal = self.spec.goal
        return Landings(goal.impact_speed, goal.flight_fraction) if self.flies else ANY_LANDING

    def box(self, setting: AnySetting, scale: Floats | float = 1.0) -> UncertaintySet:
        """Return the uncertainty set of a setting, or of several where these are arrays of shape (m, 1).

        Parameters
        ----------
        setting : AnySetting
            Nominal values.
        scale : float or array
            Factor on all bands and drifts about their middles; bands are cut at impossible values.
        """
        bands, drift = self.spec.bands, self.drift
        is_ratio = "friction_ratio" in bands
        low, high = bands["trough_angle"]
        short, most = TOLERANCES.short, 1.0 if is_ratio else math.inf
        trough = cut(
            _scaled((low - drift.trough_angle, high + drift.trough_angle), scale),
            short - _RIGHT_ANGLE,
            _RIGHT_ANGLE - short,
        )
        second = _scaled(bands["friction_ratio" if is_ratio else "kinetic_friction"], scale)
        factor, shape = self.space.band(setting, drift, scale, _RIGHT_ANGLE - short - trough[1])
        return UncertaintySet(
            space=self.space,
            factor=factor,
            frequency=off(setting.frequency, drift.frequency * scale),
            shape=shape,
            trough_angle=trough,
            static_friction=cut(_scaled(bands["static_friction"], scale), 0.0, math.inf),
            second_friction=cut(second, 0.0, most),
            is_ratio=is_ratio,
            gravity=self.spec.gravity,
            restitution=self.spec.restitution,
        )

    def load(self, setting: AnySetting) -> Floats:
        """Nominal load of a setting: the largest acceleration along its path over g [1]."""
        return self.space.load(setting, self.spec.gravity)

    def nominal_scene(self, setting: AnySetting) -> Scene:
        """Return the scene of a setting in the middle of all bands."""
        box = self.box(setting, 0.0)
        points = box.points(np.full((len(box.axes), *np.shape(setting[0])), 0.5))
        return box.scene(points, fast=False)

    def growth(self, scale: Floats | float) -> Floats | float:
        """Return the ratio of the largest load in a box to the nominal one."""
        drift = self.drift
        return (1.0 + drift.amplitude * scale) * (1.0 + drift.frequency * scale) ** self.space.power

    def hardest_impacts(
        self, setting: AnySetting, scenarios: Scenarios, scale: Floats | float = 1.0
    ) -> Floats:
        """Return the largest impact speed of scenarios at each of some settings, 1-D; 0 where none lands."""
        boxes, points = self._bodies(setting, scenarios, scale)
        # at one load landings are hardest at the lowest frequency
        cycle = solve(boxes.scene(points, fast=True), flight=self.flies)
        return np.asarray(np.nanmax(cycle.impact_velocity, axis=1, initial=0.0))

    def speeds(self, setting: AnySetting, scenarios: Scenarios, scale: Floats | float = 1.0) -> Floats:
        """Speeds of scenarios at settings, 1-D, of shape (settings, scenarios).

        -inf where a body breaks a constraint; NaN where its speed is unknown and it is left out.
        """
        boxes, points = self._bodies(setting, scenarios, scale)
        scene = boxes.scene(points, fast=False)
        cycle = solve(scene, flight=self.flies)
        bad = self.landings.broken(boxes, points, cycle)
        if not self.space.proves:  # for lines the limits on the load have excluded these already
            bad |= np.asarray(cycle.regime) > self.highest
            if math.isfinite(self.spec.stand_ratio):
                bad |= stays_upright(scene, self.spec.stand_ratio) != 1
        return np.where(bad, -np.inf, counted(cycle, fast=False))

    def _bodies(
        self, setting: AnySetting, scenarios: Scenarios, scale: Floats | float
    ) -> tuple[UncertaintySet, Points]:
        """Return the uncertainty sets of settings, 1-D, and the scenarios of each."""
        columns = setting._make(np.reshape(x, (-1, 1)) for x in setting)
        boxes = self.box(columns, np.reshape(scale, (-1, 1)))
        return boxes, boxes.points(scenarios.at(boxes))


def _scaled(band: Span, scale: Any) -> Ends:
    """Scale a band about its middle; a scale of 1 keeps it to the last bit."""
    low, high = band
    middle, half = 0.5 * (low + high), 0.5 * (high - low)
    plain = np.equal(scale, 1.0)
    return np.where(plain, low, middle - half * scale), np.where(plain, high, middle + half * scale)
