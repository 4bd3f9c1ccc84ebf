"""Slides from rest: where they start, and whether they last until the opposite window opens or closes.

Equation numbers are those of docs/theory.md. Lengths in A, speeds in A w, phases in radians.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Final, NamedTuple

import numpy as np

from vibro.core.contact.slide import Onset
from vibro.core.contact.windows import load_amplitude, skew_of, turn_of

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from vibro.core.contact.onset import Margins
    from vibro.core.contact.slide import Floats
    from vibro.core.contact.windows import Turn
    from vibro.core.groups import Loads

    Bools = NDArray[np.bool_]

__all__ = ["Pair", "Start", "Verdict", "Window", "pair_of", "resting_start", "verdict"]

# [1] Relative rounding noise of a slide's speed, and of a load, where the next leg is decided.
_NOISE: Final = 16 * 2.0**-52


class Verdict(NamedTuple):
    """Sign of a speed or a load margin, and whether rounding decides it."""

    positive: Bools
    edge: Bools


def verdict(value: Floats, scale: Floats) -> Verdict:
    """Tell the sign of a number that rounding has changed by up to 16 eps of a scale."""
    noise = _NOISE * scale
    return Verdict(value > noise, np.abs(value) <= noise)


class Window(NamedTuple):
    """Half the length of a static window, its sine and its cosine."""

    c: Floats
    sin: Floats
    cos: Floats


class Start(NamedTuple):
    """A slide from rest.

    Attributes
    ----------
    onset : Onset
        Where it starts, in its own phase.
    load : array
        Load amplitude while it slides, C of Eq. (52).
    window : Window
        The static window that it starts from.
    turn : Turn, or None
        From the window's phase to the slide's; None of drives along a line, where it is zero.
    """

    onset: Onset
    load: Floats
    window: Window
    turn: Turn | None


def resting_start(scene: Loads, at: Margins, direction: int) -> Start:
    """Slide from rest, forward (+1) or back (-1), Eqs. (3)-(6) and (54), without cancellation."""
    margin, static_load = (at.forward, at.forward_load) if direction > 0 else (at.back, at.back_load)
    mu_s, mu_d = scene.static_friction, scene.kinetic_friction
    load = load_amplitude(scene, direction, mu_d)
    vers = margin / static_load  # 1 - sin p0
    k = (mu_d * scene.normal + direction * scene.tangential) / load
    if scene.lead is None:
        excess = (mu_s - mu_d) * scene.contrast / (static_load * load)
        turn, c, sin = None, 2.0 * np.arcsin(np.sqrt(0.5 * vers)), np.sqrt(vers * (2.0 - vers))
    else:
        cos = (mu_s * scene.normal + direction * scene.tangential) / static_load
        window = Window(2.0 * np.arcsin(np.sqrt(0.5 * vers)), np.sqrt(vers * (2.0 - vers)), cos)
        excess = (mu_s - mu_d) * _normal_load(scene, direction, static_load, window) / load
        turn = turn_of(scene, direction, static_load, load)
        c = window.c + turn.angle
        half = np.tan(0.5 * c)
        sin = 2.0 * half / (1.0 + half * half)
        vers = sin * half
    if np.count_nonzero(scene.tangential):
        # Where the weight down the trough nearly cancels friction, rounding may bring k above sin p0, and no
        # slide would start: take it from sin p0 there.
        shared = 1.0 - vers - excess
        k = np.where(np.abs(k - shared) > _NOISE, shared, k)
    cos = excess + k  # keeps its digits where p0 -> 0, unlike 1 - vers
    onset = Onset(c=c, cos=cos, sin=sin, vers=vers, excess=excess, k=k)
    return Start(onset, load, Window(c, sin, cos) if turn is None else window, turn)


def _normal_load(scene: Loads, direction: int, static_load: Floats, window: Window) -> Floats:
    """Load on the trough where a slide of an elliptical drive starts, as a sum of what is not negative."""
    assert scene.lead is not None
    level = (direction * scene.along * scene.lead.cosine + scene.static_friction * scene.across) / static_load
    steep = -direction * scene.along * scene.lead.sine / static_load
    # phase from there to the lift-off's crest
    sine, cosine = window.sin * level + window.cos * steep, window.cos * level - window.sin * steep
    versine = np.where(cosine > 0.0, sine * sine / (1.0 + np.abs(cosine)), 1.0 - cosine)
    return (scene.normal - scene.across) + scene.across * versine


class Pair(NamedTuple):
    """Both slides from rest of scenes whose load exceeds static friction both ways.

    Attributes
    ----------
    forward, back : Start
        The slides.
    lead : CosineLead, or None
        What decides between slides with a k far below the rounding of a cosine; of drives along a line.
    skew : Turn, or None
        How much more than half a turn after the forward window the back window lies; None of drives along a
        line, where it is zero.
    """

    forward: Start
    back: Start
    lead: CosineLead | None
    skew: Turn | None

    def swing(self) -> Floats:
        """Kinetic phase of the back slide's zero beyond half a turn after that of the forward slide."""
        if self.skew is None or self.forward.turn is None or self.back.turn is None:
            return np.zeros(())
        return self.skew.angle - self.forward.turn.angle + self.back.turn.angle

    def reaches(self, direction: int) -> Verdict:
        """Whether a slide still moves where the opposite load window opens, Eqs. (17) and (56)."""
        start, other, skew = self._seen(direction)
        onset = start.onset
        if skew is None or start.turn is None:
            sine, lag = other.sin, np.pi + onset.c - other.c
        else:
            sine_e, cosine_e = _difference(skew, start.turn)
            sine = other.sin * cosine_e - other.cos * sine_e
            lag = np.pi + start.window.c + skew.angle - other.c
        speed = onset.sin + sine - onset.k * lag
        return verdict(speed, np.abs(onset.sin) + np.abs(sine) + np.abs(onset.k))

    def outlasts(self, direction: int) -> Verdict:
        """Whether a slide still moves where the opposite load window closes, Eqs. (17) and (56).

        For k < 0 the speed grows again after 2 pi - asin|k|, and is looked at there if that comes first.
        |k| < 1 where the other onset exists and the body can rest.
        """
        start, other, skew = self._seen(direction)
        onset, k = start.onset, start.onset.k
        if self.lead is not None:
            ahead, size, c = direction * self.lead.value, self.lead.size, other.c
            early = -k > other.cos
        else:
            assert skew is not None
            assert start.turn is not None
            sine_e, cosine_e = _difference(skew, start.turn)
            sine = other.sin * cosine_e + other.cos * sine_e
            ahead, size = onset.sin - sine, np.abs(onset.sin) + np.abs(sine)
            c = other.c + skew.angle - start.turn.angle
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

    def _seen(self, direction: int) -> tuple[Start, Window, Turn | None]:
        """Return a slide, the window that it runs into, and how that lies."""
        if direction > 0:
            return self.forward, self.back.window, self.skew
        return self.back, self.forward.window, None if self.skew is None else self.skew.back()


def _difference(first: Turn, second: Turn) -> tuple[Floats, Floats]:
    """Sine and cosine of a difference of angles."""
    return (
        first.sine * second.cosine - first.cosine * second.sine,
        first.cosine * second.cosine + first.sine * second.sine,
    )


def pair_of(scene: Loads, at: Margins) -> Pair:
    """Slides from rest in both directions."""
    forward, back = resting_start(scene, at, 1), resting_start(scene, at, -1)
    if scene.lead is None:
        return Pair(forward, back, _lead(scene, at, forward.onset, back.onset), None)
    return Pair(forward, back, None, skew_of(scene, at.forward_load, at.back_load))


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
