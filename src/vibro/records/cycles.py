"""Steady motions of many scenes, sampled at the times of one record, for searches."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import lru_cache
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from vibro.core.codes import Regime, is_answered
from vibro.drives import Ability
from vibro.errors import VibroError
from vibro.motion.settled import SettledMotion, settled_motion
from vibro.records.alignment import computed_signals
from vibro.records.folding import Floats
from vibro.results.steady import SteadyCycle
from vibro.scene import Fields, Scene
from vibro.slopes import slides_of
from vibro.steady import solve

Labels = NDArray[np.object_]  # of str

_REMEMBERED: Final = 256  # motions, of some kilobytes each: more than the points of a few steps

#: Label of every scene that hops: their patterns are too many, and too close to each other.
HOPS: Final = "H"


@dataclass(frozen=True, eq=False)
class SceneCycles:
    """Steady cycles of M scenes.

    Attributes
    ----------
    labels : object array of str, shape (M,)
        Pattern of each, or ``HOPS``; empty without a steady cycle.
    fields : Drive
        Fields of the scenes, each of shape (M,).
    slides : array, shape (7, 2, M)
        Both slides of each cycle, with the rows of ``Slides``; 0 without a slide.
    followed : mapping of int to SettledMotion
        Motions of scenes that hop, and of all beyond one harmonic, by their place among all.
    """

    labels: Labels
    fields: Fields
    slides: Floats
    followed: Mapping[int, SettledMotion]

    def signals(
        self, names: Iterable[str], time: Floats, shift: Floats, window: float, *, absolute: bool = False
    ) -> dict[str, Floats]:
        """Sample signals as ``computed_signals`` does.

        Parameters
        ----------
        names : iterable of str
            Signals of ``Observation``.
        time : array, shape (N,)
            Times on the record's clock [s].
        shift : array, shape (M,)
            Trough time at the clock's zero, for each scene [s].
        window : float
            Width of the averages of accelerations and friction [s].
        absolute : bool
            Whether to add the trough's motion to those of the body, which are relative to it.

        Returns
        -------
        dict of str to array, shape (M, N)
            The signals; those of a body at rest for scenes without a steady cycle.
        """
        names = list(names)
        if self.fields.can(Ability.ONE_HARMONIC):
            result = self._closed_forms(self.fields, names, time, shift, window)
            if absolute:
                for name, values in self._trough(time, shift).items():
                    if name in result:
                        result[name] = result[name] + values
        else:
            result = {name: np.zeros((shift.size, time.size)) for name in names}
        for scene, motion in self.followed.items():
            own = computed_signals(motion, names, time + shift[scene], window, absolute=absolute)
            for name, values in own.items():
                result[name][scene] = values
        return {name: result[name] for name in names}

    def landings(self, scene: int) -> Floats:
        """Return the phases at which flights of one scene end [drive cycles]."""
        motion = self.followed.get(scene)
        ends = [phase.end / motion.period for phase in motion.phases if phase.kind == "H"] if motion else []
        return np.array(ends)

    def _closed_forms(
        self, fields: Fields, names: list[str], time: Floats, shift: Floats, window: float
    ) -> dict[str, Floats]:
        rate = math.tau * fields.frequency[:, None]
        phase = rate * (time + shift[:, None])
        result = {}
        if "displacement" in names:
            result["displacement"] = self._displacements(phase)
        if "velocity" in names:
            result["velocity"] = self._velocities(phase)
        if {"acceleration", "friction"} & set(names):
            half = 0.5 * window * rate
            gained = self._velocities(phase + half) - self._velocities(phase - half)
            result["acceleration"] = gained / window
            weight = fields.gravity * np.sin(fields.trough_angle)
            inertial = fields.along[:, None] * rate**2 * np.sin(phase) - weight[:, None]
            result["friction"] = result["acceleration"] - inertial
        return result

    def _trough(self, time: Floats, shift: Floats) -> dict[str, Floats]:
        """Return the motions of the trough along itself, of one harmonic."""
        rate = math.tau * self.fields.frequency[:, None]
        phase, along = rate * (time + shift[:, None]), self.fields.along[:, None]
        return {
            "displacement": along * np.sin(phase),
            "velocity": along * rate * np.cos(phase),
            "acceleration": -along * rate**2 * np.sin(phase),
        }

    def _velocities(self, phase: Floats) -> Floats:
        total = np.zeros_like(phase)
        for way, zero, begin, end, load, resistance, _ in self._acting():
            since, start = (phase - begin) % math.tau, begin - zero
            gained = load * (np.cos(start) - np.cos(start + since) - resistance * since)
            total += np.where(since < end - begin, way * gained, 0.0)
        return total * (math.tau * self.fields.frequency * self.fields.scale)[:, None]

    def _displacements(self, phase: Floats) -> Floats:
        total = np.zeros_like(phase)
        for way, zero, begin, end, load, resistance, displacement in self._acting():
            turns, since = np.divmod(phase - begin, math.tau)
            since, start = np.minimum(since, end - begin), begin - zero
            turned = np.sin(start + since) - np.sin(start)
            moved = load * (since * np.cos(start) - turned - 0.5 * resistance * since**2)
            total += turns * displacement + way * moved
        return total * self.fields.scale[:, None]

    def _acting(self) -> list[Floats]:
        """Return the columns of the first and of the second slides, (7, M, 1), if any scene has one."""
        return [slide for slide in self.slides.swapaxes(0, 1)[..., None] if slide[0].any()]


def labels_of(values: Mapping[str, Any]) -> Labels:
    """Return the labels of scenes as in ``SceneCycles``, from their fields as for ``scene_cycles``."""
    return _labels(solve(Scene.computed(**values), flight=False))


def _labels(cycle: SteadyCycle) -> Labels:
    labels = np.where(is_answered(cycle.status), cycle.pattern, "")
    return np.where(cycle.regime == Regime.HOPPING, HOPS, labels)


def scene_cycles(values: Mapping[str, Any], *, hops: bool = True) -> SceneCycles:
    """Solve the steady cycles of scenes.

    Parameters
    ----------
    values : mapping of str to array
        All fields of the scenes, each of shape (M,) [SI]; harmonics are pairs of numbers, the same in all.
    hops : bool
        Whether to solve scenes that hop; else they have their label, and the signals of a body at rest.
    """
    scene = Scene.computed(**values)
    cycle = solve(scene, flight=False)
    labels = _labels(cycle)
    one_harmonic = scene.arrays().can(Ability.ONE_HARMONIC)
    wanted = (labels == HOPS) if one_harmonic else (labels != "")
    followed = {}
    for place in np.flatnonzero(wanted & ((labels != HOPS) | hops)).tolist():
        motion = _followed(tuple((name, _at(value, place)) for name, value in values.items()))
        if motion is None:
            labels[place] = ""
        else:
            followed[place] = motion
    if one_harmonic:
        slides = np.nan_to_num(slides_of(scene, np.broadcast_to(cycle.pattern_code, labels.shape)))
    else:
        slides = _slides(followed, labels.size)
    return SceneCycles(labels, scene.flat(), slides, followed)


@lru_cache(maxsize=_REMEMBERED)
def _followed(fields: tuple[tuple[str, Any], ...]) -> SettledMotion | None:
    """Return the motion of one scene; None where it repeats only every few cycles, or never, or is not known.

    A search moves the shift alone, or comes back to a point, about as often as it goes to a new scene.
    """
    try:
        return settled_motion(Scene(**dict(fields)))
    except VibroError:
        return None


def _at(values: Any, place: int) -> Any:
    """Return the field of one scene among several; harmonics are the same in all."""
    if isinstance(values, np.ndarray):
        return float(values[place])
    return tuple(values) if isinstance(values, list) else values


def _slides(followed: Mapping[int, SettledMotion], count: int) -> Floats:
    """Return direction, begin and end of the slides of motions in the rows of ``Slides``; else 0."""
    most = max((len(motion.slides) for motion in followed.values()), default=0)
    found = np.zeros((7, most, count))
    for place, motion in followed.items():
        for i, (way, start, end) in enumerate(motion.slides):
            rate = math.tau / motion.period
            found[[0, 2, 3], i, place] = way, rate * start, rate * end
    return found
