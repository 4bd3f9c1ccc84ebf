"""The steady motions of many scenes at once, at the times of one record: what a search needs of the model."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from vibro.core.codes import PATTERNS, Regime, is_answered
from vibro.errors import VibroError
from vibro.motion.settled import settled_motion
from vibro.records.alignment import computed
from vibro.scene import Scene
from vibro.slopes import slides_of
from vibro.steady import solve

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping

    from numpy.typing import NDArray

    from vibro.motion.settled import SettledMotion
    from vibro.results.steady import SteadyCycle

    Floats = NDArray[np.float64]
    Labels = NDArray[np.str_]

__all__ = ["HOPS", "Cycles", "labels_of", "steady_cycles"]

HOPS: Final = "H"  # label of every scene that hops: its many patterns follow each other too closely
_TURN: Final = 2.0 * math.pi
_WAYS: Final = (1, -1)
_TEXTS: Final = np.array(PATTERNS)


@dataclass(frozen=True, eq=False)
class Cycles:
    """Steady cycles of M scenes.

    Attributes
    ----------
    labels : str array, shape (M,)
        Pattern of each, or ``HOPS``; empty where there is no steady cycle.
    values : mapping of str to array
        The fields of the scenes, each of shape (M,).
    scales, inertias : array, shape (M,)
        Length that the loads are counted in [m]; amplitude of the trough's acceleration along itself [m/s^2].
    zeros, starts, lengths, loads, resistances : array, shape (2, M)
        Of the forward and the back slide: drive phase at which the load is zero and rises; phase of the
        start, counted from there, and length [rad]; amplitude of the load and its resistance, as in
        ``Onset``. The length is 0 without a slide.
    hopping : mapping of int to SettledMotion
        Scenes that hop.
    """

    labels: Labels
    values: Mapping[str, Floats]
    scales: Floats
    inertias: Floats
    zeros: Floats
    starts: Floats
    lengths: Floats
    loads: Floats
    resistances: Floats
    hopping: Mapping[int, SettledMotion]

    def signals(self, names: Iterable[str], time: Floats, shift: Floats, window: float) -> dict[str, Floats]:
        """Sample signals as ``alignment.computed`` does.

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
        rate = _TURN * self.values["frequency"][:, None]
        phase = rate * (time + shift[:, None])
        result = {}
        if "displacement" in names:
            result["displacement"] = self._displacements(phase)
        if "velocity" in names:
            result["velocity"] = self._velocities(phase)
        if {"acceleration", "friction"} & set(names):
            half = 0.5 * window * rate
            result["acceleration"] = (
                self._velocities(phase + half) - self._velocities(phase - half)
            ) / window
            weight = self.values["gravity"] * np.sin(self.values["trough_angle"])
            inertial = self.inertias[:, None] * np.sin(phase) - weight[:, None]
            result["friction"] = result["acceleration"] - inertial
        for scene, motion in self.hopping.items():
            for name, values in computed(motion, names, time + shift[scene], window).items():
                result[name][scene] = values
        return {name: result[name] for name in names}

    def _velocities(self, phase: Floats) -> Floats:
        speed = self.scales * _TURN * self.values["frequency"]
        total = np.zeros_like(phase)
        for row, way in enumerate(_WAYS):
            if not self.lengths[row].any():
                continue
            zero, start, length, load, k = self._slide(row)
            since = np.minimum((phase - start - zero) % _TURN, length)
            swing = np.cos(start) - np.cos(start + since) - k * since
            total += np.where(since < length, way * speed[:, None] * load * swing, 0.0)
        return total

    def _displacements(self, phase: Floats) -> Floats:
        total = np.zeros_like(phase)
        for row, way in enumerate(_WAYS):
            if not self.lengths[row].any():
                continue
            zero, start, length, load, k = self._slide(row)
            turns, since = np.divmod(phase - start - zero, _TURN)

            def path(since: Floats, start: Floats = start, k: Floats = k) -> Floats:
                turned = np.sin(start + since) - np.sin(start)
                return np.asarray(since * np.cos(start) - turned - 0.5 * k * since * since)

            size = way * self.scales[:, None] * load
            total += size * (path(np.minimum(since, length)) + turns * path(length))
        return total

    def _slide(self, row: int) -> tuple[Floats, Floats, Floats, Floats, Floats]:
        columns = (self.zeros, self.starts, self.lengths, self.loads, self.resistances)
        zero, start, length, load, k = (column[row][:, None] for column in columns)
        return zero, start, length, load, k


def labels_of(values: Mapping[str, Floats]) -> Labels:
    """Label scenes as ``Cycles`` does, from all their fields, each of shape (M,) [SI]."""
    return _labels(solve(Scene.allowing_infeasible(**values), flight=False))


def _labels(cycle: SteadyCycle) -> Labels:
    labels = np.where(is_answered(cycle.status), _TEXTS[cycle.pattern_code], "")
    return np.where(cycle.regime == Regime.HOPPING, HOPS, labels)


def steady_cycles(values: Mapping[str, Floats], *, hops: bool = True) -> Cycles:
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
    scales, inertias = np.asarray(fields.scale), fields.along * (_TURN * fields.frequency) ** 2
    zeros, starts, lengths, sizes, resistances = slides
    return Cycles(labels, values, scales, inertias, zeros, starts, lengths, sizes, resistances, hopping)
