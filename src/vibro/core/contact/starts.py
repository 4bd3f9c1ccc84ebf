"""Slides from rest: where they start, and whether they last until the opposite window opens or closes.

Equation numbers are those of docs/theory.md. Lengths in A, speeds in A w, phases in radians.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Final, NamedTuple

import numpy as np

from vibro.core.contact.slide import Onset
from vibro.core.contact.windows import load_amplitude, skew_of
from vibro.core.groups import take

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from vibro.core.contact.onset import Margins
    from vibro.core.contact.slide import Floats
    from vibro.core.groups import Loads

    Bools = NDArray[np.bool_]

__all__ = ["Pair", "Start", "Verdict", "Window", "pair_of", "resting_start", "verdict"]

# [1] Relative rounding noise of a slide's speed, and of a load, where the next leg is decided.
_NOISE: Final = 16 * 2.0**-52
_NEARLY_LIFTED: Final = 0.25  # [n] normal load below which it is formed without a difference


class Verdict(NamedTuple):
    """Sign of a speed or a load margin, and whether rounding decides it."""

    positive: Bools
    edge: Bools


def verdict(value: Floats, scale: Floats) -> Verdict:
    """Tell the sign of a number that rounding has changed by up to 16 eps of a scale."""
    noise = _NOISE * scale
    return Verdict(value > noise, np.abs(value) <= noise)


class Window(NamedTuple):
    """A static window of an elliptical drive, and what a slide has to do with it.

    Attributes
    ----------
    c : array
        Half of its length [rad].
    open_rate, close_rate : array
        How fast the load of the opposite slide changes where it opens, and where it closes.
    """

    c: Floats
    open_rate: Floats
    close_rate: Floats


class Start(NamedTuple):
    """A slide from rest.

    Attributes
    ----------
    onset : Onset
        Where it starts, in its own phase.
    load : array
        Load amplitude while it slides, C of Eq. (54).
    window : Window, or None
        The static window that it starts from; None of drives along a line, where the onset says it all.
    """

    onset: Onset
    load: Floats
    window: Window | None


def resting_start(scene: Loads, at: Margins, direction: int) -> Start:
    """Slide from rest, forward (+1) or back (-1), Eqs. (3)-(6) and (56), without cancellation."""
    margin, static_load = (at.forward, at.forward_load) if direction > 0 else (at.back, at.back_load)
    mu_s, mu_d = scene.static_friction, scene.kinetic_friction
    window, drag = None, mu_d * scene.normal + direction * scene.tangential
    if scene.lead is None:
        load = load_amplitude(scene, direction, mu_d)
        k, vers = drag / load, margin / static_load  # 1 - sin p0
        excess = (mu_s - mu_d) * scene.contrast / (static_load * load)
        c, sin = 2.0 * np.arcsin(np.sqrt(0.5 * vers)), np.sqrt(vers * (2.0 - vers))
    else:
        load, window, sin, excess = _elliptical_start(scene, direction, margin, static_load)
        k = drag / load
        half = sin / (1.0 + (excess + k))
        c, vers = 2.0 * np.arctan(half), sin * half
    if np.count_nonzero(scene.tangential):
        # Where the weight down the trough nearly cancels friction, rounding may bring k above sin p0, and no
        # slide would start: take it from sin p0 there.
        shared = 1.0 - vers - excess
        k = np.where(np.abs(k - shared) > _NOISE, shared, k)
    cos = excess + k  # keeps its digits where p0 -> 0, unlike 1 - vers
    return Start(Onset(c=c, cos=cos, sin=sin, vers=vers, excess=excess, k=k), load, window)


def _elliptical_start(
    scene: Loads, direction: int, margin: Floats, static_load: Floats
) -> tuple[Floats, Window, Floats, Floats]:
    """Return the load and the static window of an elliptical drive, and sin c and the excess of a slide."""
    assert scene.lead is not None
    mu_s, mu_d, b, way = scene.static_friction, scene.kinetic_friction, scene.across, direction * scene.along
    level, steep = way * scene.lead.cosine + mu_s * b, way * scene.lead.sine
    less = mu_s - mu_d
    loss = less * b
    kinetic_level = level - loss
    load = np.sqrt(kinetic_level * kinetic_level + steep * steep)  # C of Eq. (54) again
    hold = mu_s * scene.normal + direction * scene.tangential
    rate = np.sqrt(margin * (2.0 * static_load - margin))  # of the load at the window's edges
    scale = 1.0 / (static_load * static_load)
    level, steep = level * scale, steep * scale
    # sine of the normal motion's phase at the window's start, its cosine there and, turned, at its end
    crest, near, far = hold * level + rate * steep, rate * level, hold * steep
    opens = near - far
    normal = scene.normal - b * crest
    cells = np.flatnonzero(normal < _NEARLY_LIFTED * scene.normal)
    if cells.size:  # a sum of what is not negative, in place of a difference
        lifts, n, y, s = take((crest, scene.normal, b, opens), cells)
        normal[cells] = (n - y) + y * s * s / (1.0 + lifts)
    both = (mu_s + mu_d) * b
    c = 2.0 * np.arctan(rate / (static_load + hold))
    window = Window(c, both * opens - rate, rate - both * (near + far))
    return load, window, (rate - loss * opens) / load, less * normal / load


class Pair(NamedTuple):
    """Both slides from rest of scenes whose load exceeds static friction both ways.

    Attributes
    ----------
    forward, back : Start
        The slides.
    lead : CosineLead, or None
        What decides between slides with a k far below the rounding of a cosine; of drives along a line.
    skew : array, or None
        How much more than half a turn after the forward window the back window lies; None of drives along a
        line, where it is zero [rad].
    """

    forward: Start
    back: Start
    lead: CosineLead | None
    skew: Floats | None

    def mirrored(self) -> Pair:
        """Look at them from the other side."""
        return self._replace(forward=self.back, back=self.forward, skew=-np.asarray(self.skew))

    def reaches(self, direction: int) -> Verdict:
        """Whether a slide still moves where the opposite load window opens, Eqs. (17) and (58)."""
        start, other, skew = self._seen(direction)
        onset = start.onset
        if start.window is None or other.window is None:
            c = other.onset.c
            speed = onset.sin + other.onset.sin - onset.k * (np.pi + onset.c - c)
            return verdict(speed, onset.sin + other.onset.sin + np.abs(onset.k))
        begin, end, drag = start.load * onset.sin, other.window.open_rate, start.load * onset.k
        loss = drag * (start.window.c - other.window.c + (skew + np.pi))
        return verdict(begin - end - loss, start.load + other.load + np.abs(drag))

    def outlasts(self, direction: int) -> Verdict:
        """Whether a slide still moves where the opposite load window closes, Eqs. (17) and (58).

        For k < 0 the speed grows again after 2 pi - asin|k|, and is looked at there if that comes first.
        |k| < 1 where the other onset exists and the body can rest.
        """
        start, other, skew = self._seen(direction)
        onset, k = start.onset, start.onset.k
        if self.lead is not None:
            ahead, size, c = direction * self.lead.value, self.lead.size, other.onset.c
            early = -k > other.onset.cos
        else:
            assert start.window is not None
            assert other.window is not None
            end = other.window.close_rate / start.load
            ahead, size = onset.sin - end, 1.0 + other.load / start.load
            c = other.window.c + skew - (onset.c - start.window.c)
            early = k < 0.0
            if early.any():
                early &= c > np.arccos(np.minimum(-k, 1.0))
        if early.any():
            c = np.where(early, np.arccos(np.where(early, -k, 0.0)), c)
            crest = np.sqrt((1.0 - k) * (1.0 + k))
            rising = onset.sin > 0.0
            cosines = np.where(rising, onset.sin + crest, 1.0)
            gain = np.where(rising, -onset.excess * (onset.excess + 2.0 * k) / cosines, onset.sin - crest)
            ahead = np.where(early, gain, ahead)
            spread = np.where(rising, onset.excess * (onset.excess - 2.0 * k) / cosines, np.abs(gain))
            size = np.where(early, spread, size)
        loss = k * (np.pi + onset.c + c)
        return verdict(ahead - loss, size + np.abs(loss))

    def _seen(self, direction: int) -> tuple[Start, Start, Floats]:
        """Return a slide, the one against whose window it runs, and how that lies."""
        skew = np.zeros(()) if self.skew is None else self.skew
        return (self.forward, self.back, skew) if direction > 0 else (self.back, self.forward, -skew)


def pair_of(scene: Loads, at: Margins) -> Pair:
    """Slides from rest in both directions."""
    forward, back = resting_start(scene, at, 1), resting_start(scene, at, -1)
    if scene.lead is None:
        return Pair(forward, back, _lead(scene, at, forward.onset, back.onset), None)
    return Pair(forward, back, None, skew_of(scene, scene.static_friction))


class CosineLead(NamedTuple):
    """cos p_f - cos p_b of the two onsets, and the size of what cancels in it."""

    value: Floats
    size: Floats


def _lead(scene: Loads, at: Margins, forward: Onset, back: Onset) -> CosineLead:
    """Difference of the onsets' cosines from that of their squared sines, which cancels only where they do.

    It decides between cycles whose k is far below the rounding of either cosine.
    """
    mu_s = scene.static_friction
    lift, hold = mu_s * scene.across, mu_s * scene.normal
    loads = at.forward_load * at.back_load
    scale = 4.0 / (loads * loads * (forward.sin + back.sin))
    if not np.count_nonzero(scene.tangential):
        value = lift * hold * (hold * scene.along) * scale
        return CosineLead(value, value)
    a, b = lift * hold, scene.tangential * scene.along
    c, d = hold * scene.along, scene.tangential * lift
    return CosineLead((a - b) * (c - d) * scale, (a + np.abs(b)) * (c + np.abs(d)) * scale)
