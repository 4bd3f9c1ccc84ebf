"""Steady motions of many scenes at once, sampled at the times of one record, for searches."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from vibro.core.codes import PATTERNS, Regime, is_answered
from vibro.errors import VibroError
from vibro.motion.settled import SettledMotion, settled_motion
from vibro.records.alignment import computed_signals
from vibro.records.folding import Floats
from vibro.results.steady import SteadyCycle
from vibro.scene import Scene
from vibro.slopes import slides_of
from vibro.steady import solve

__all__ = ["HOPS", "SceneCycles", "labels_of", "scene_cycles"]

Labels = NDArray[np.str_]

HOPS: Final = "H"  # label of every scene that hops: its many patterns follow each other too closely
_WAYS: Final = (1, -1)
_TEXTS: Final = np.array(PATTERNS)


@dataclass(frozen=True, eq=False)
class SceneCycles:
    """Steady cycles of M scenes.

    Attributes
    ----------
    labels : str array, shape (M,)
        Pattern of each, or ``HOPS``; empty where there is no steady cycle.
    values : mapping of str to array
        The fields of the scenes, each of shape (M,).
    scales, inertias : array, shape (M,)
        Length that the loads are counted in [m]; amplitude of the trough's acceleration along itself [m/s^2].
    slides : array, shape (5, 2, M)
        Of the forward and the back slide: drive phase at which the load is zero and rises; phase of the
        start, counted from there, and length [rad]; amplitude of the load and its resistance, as in
        ``Slides``. The length is 0 without a slide.
    hopping : mapping of int to SettledMotion
        Scenes that hop.
    """

    labels: Labels
    values: Mapping[str, Floats]
    scales: Floats
    inertias: Floats
    slides: Floats
    hopping: Mapping[int, SettledMotion]

    def signals(self, names: Iterable[str], time: Floats, shift: Floats, window: float) -> dict[str, Floats]:
        """Sample signals as ``computed_signals`` does.

        Parameters
        ----------
        names : iterable of str
            Signals of ``Observation``.
        time : array, shape (N,)
            On the record's clock [s].
        shift : array, shape (M,)
            Trough time at the clock's zero, for each scene [s].
        window : float
            Width of the averages of accelerations and friction [s].

        Returns
        -------
        dict of str to array, shape (M, N)
            Of scenes without a steady cycle, those of a body at rest.
        """
        names = list(names)
        rate = math.tau * self.values["frequency"][:, None]
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
            weight = self.values["gravity"] * np.sin(self.values["trough_angle"])
            inertial = self.inertias[:, None] * np.sin(phase) - weight[:, None]
            result["friction"] = result["acceleration"] - inertial
        for scene, motion in self.hopping.items():
            for name, values in computed_signals(motion, names, time + shift[scene], window).items():
                result[name][scene] = values
        return {name: result[name] for name in names}

    def _velocities(self, phase: Floats) -> Floats:
        speed = self.scales * math.tau * self.values["frequency"]
        total = np.zeros_like(phase)
        for way, (zero, start, length, load, resistance) in self._acting():
            since = np.minimum((phase - start - zero) % math.tau, length)
            gained = np.cos(start) - np.cos(start + since) - resistance * since
            total += np.where(since < length, way * speed[:, None] * load * gained, 0.0)
        return total

    def _displacements(self, phase: Floats) -> Floats:
        total = np.zeros_like(phase)
        for way, (zero, start, length, load, resistance) in self._acting():
            turns, since = np.divmod(phase - start - zero, math.tau)
            size = way * self.scales[:, None] * load
            for times, until in ((1.0, np.minimum(since, length)), (turns, length)):
                turned = np.sin(start + until) - np.sin(start)
                moved = until * np.cos(start) - turned - 0.5 * resistance * until * until
                total += size * times * moved
        return total

    def _acting(self) -> list[tuple[int, Floats]]:
        """Direction and rows of ``slides``, of shape (5, M, 1), where any of the scenes slides that way."""
        rows = zip(_WAYS, self.slides.swapaxes(0, 1)[..., None], strict=True)
        return [(way, columns) for way, columns in rows if columns[2].any()]


def labels_of(values: Mapping[str, Floats]) -> Labels:
    """Label scenes as ``SceneCycles`` does, from all their fields, each of shape (M,) [SI]."""
    return _labels(solve(Scene.allowing_infeasible(**values), flight=False))


def _labels(cycle: SteadyCycle) -> Labels:
    labels = np.where(is_answered(cycle.status), _TEXTS[cycle.pattern_code], "")
    return np.where(cycle.regime == Regime.HOPPING, HOPS, labels)


def scene_cycles(values: Mapping[str, Floats], *, hops: bool = True) -> SceneCycles:
    """Solve the steady cycles of scenes.

    Parameters
    ----------
    values : mapping of str to array
        All fields of the scenes, each of shape (M,) [SI].
    hops : bool
        Whether scenes that hop are solved; else they have their label, and the signals of a body at rest.
    """
    scene = Scene.allowing_infeasible(**values)
    cycle = solve(scene, flight=False)
    labels = _labels(cycle)
    found = slides_of(scene, np.broadcast_to(cycle.pattern_code, labels.shape))
    slides = np.zeros((5, 2, labels.size))
    for row, way in enumerate(_WAYS):
        for part in range(2):
            cells = np.flatnonzero(found.way[part] == way)
            begin, end, zero = (x[part, cells] for x in (found.begin, found.end, found.zero))
            others = found.load[part, cells], found.resistance[part, cells]
            slides[:, row, cells] = (zero, begin - zero, end - begin, *others)
    hopping = {}
    for cell in np.flatnonzero(labels == HOPS).tolist() if hops else ():
        try:
            hopping[cell] = settled_motion(Scene(**{name: float(v[cell]) for name, v in values.items()}))
        except VibroError:  # it repeats its motion only every few cycles, or never
            labels[cell] = ""
    fields = scene.flat()
    scales, inertias = np.asarray(fields.scale), fields.along * (math.tau * fields.frequency) ** 2
    return SceneCycles(labels, values, scales, inertias, slides, hopping)
