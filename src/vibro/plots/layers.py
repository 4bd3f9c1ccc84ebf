"""The layers of one map: filled regions, hatched covers, critical curves, contours, and their words."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Final

import numpy as np
from matplotlib.patches import PathPatch

from vibro.core.codes import Regime, Status
from vibro.plots import style
from vibro.plots.fields import BEGINS_AT, HIDDEN_BY, hiding_fields, zero_lines, zero_region
from vibro.plots.labels import Labeller
from vibro.plots.neighbours import erode, spread_evenly
from vibro.plots.scales import colours_of

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping

    from matplotlib.axes import Axes
    from numpy.typing import NDArray

    from vibro.plots.fields import Fields
    from vibro.plots.scales import Scale
    from vibro.reals import Floats


WHITE: Final = {"facecolor": style.REGIME_COLOURS[Regime.NO_SLIP]}
_COVERS: Final = 2.0  # zorder of the uppermost cover
# Where numbers jump up and down, contours break up into specks. Shorter pieces than this are left out.
_SPECK: Final = 0.04  # of the side of the map
_HATCHED: Final = 3  # of 200 points along a map's sides: least width of an area in which a hatch is seen
_NUMBERED: Final = 0.25  # of the side of the map: longer pieces of a contour have its number each
_FACET_TYPE: Final = 0.8  # size of type on facets, relative to that on single maps
_HALO: Final = 1.4  # [pt] around lines, on either side together


class MapLayers:
    """The layers of one map. Each is drawn by a call of its own; ``write`` comes last, for the words.

    Parameters
    ----------
    axes : Axes
        With their final limits.
    fields : Fields
        Of the map.
    single : bool
        Whether the map stands alone: the legend then explains only things that cannot be labelled on it.
    """

    def __init__(self, axes: Axes, fields: Fields, single: bool) -> None:
        self.axes = axes
        self.fields = fields
        self._single = single
        self._scale = 1.0 if single else _FACET_TYPE
        self._has_numbers = False
        self._covers: list[Floats] = []
        self._regions: list[tuple[str, NDArray[np.bool_], Any]] = []
        self._spines: dict[str, list[Floats]] = {}
        self._curves: list[tuple[str, list[Floats], Any]] = []
        self._clear: list[Floats] = []  # lines that words keep clear of
        # Number, pieces, colour of the ground, and line of each contour.
        self._contours: list[tuple[str, list[Floats], Any, Any]] = []

    @property
    def open(self) -> NDArray[np.bool_]:
        """Grid points that no cover hides, of those drawn so far."""
        seen = np.ones((len(self.fields.y), len(self.fields.x)), np.bool_)
        return np.asarray(np.logical_and.reduce([seen, *(cover <= 0.0 for cover in self._covers)]))

    def fill_regimes(self) -> None:
        """Fill every regime with its colour, bounded by the critical curves, and have its seen part named."""
        begun = [self.fields.rest, *(self.fields.log_ratio[curve] for curve in BEGINS_AT.values())]
        for place, regime in enumerate((Regime.NO_SLIP, *BEGINS_AT)):
            # Where it has begun and no later one has, as the areas are filled.
            seen = np.minimum.reduce([begun[place], *(-field for field in begun[place + 1 :])])
            face = {"facecolor": style.REGIME_COLOURS[regime]}
            if self.fill_region(regime.label, begun[place], seen, face):
                self._spines[regime.label] = self._spine(regime)

    def fill_region(self, text: str, field: Floats, seen: Floats, look: Mapping[str, Any]) -> bool:
        """Fill the area in which a field is positive, if any, and have the part where it is seen named."""
        filled = self.fill(field, gid=text, zorder=1, **look)
        if filled is not None:
            self._name_region(text, seen, filled)
        return filled is not None

    def _spine(self, regime: Regime) -> list[Floats]:
        """Return the line midway between the curves that bound a regime; none for the first and the last."""
        if regime not in BEGINS_AT or regime is Regime.HOPPING:
            return []
        ratio = self.fields.log_ratio
        begin = ratio[BEGINS_AT[regime]]
        end = np.maximum.reduce([ratio[name] for name in HIDDEN_BY[BEGINS_AT[regime]]])
        return zero_lines(self.fields, begin + end, [-begin, *self._covers])

    def hatch_unanswered(self, *, regimes_show: bool) -> None:
        """Hatch the area without an answer.

        Where flight is not modelled the regime is still known: a picture of regimes shows it.
        """
        for status in style.NO_ANSWER_HATCH:
            known = regimes_show and status is Status.FLIGHT_NOT_MODELLED
            if status in self.fields.statuses and not known:
                self.cover(self.fields.unanswered(status), *style.no_answer(status))

    def hatch_doubtful(self) -> None:
        """Hatch, over the colours, where another motion exists and where a number is a mean."""
        label, field = self.fields.others
        self._hatch_over(field, label)
        if self._has_numbers:
            self._hatch_over(self.fields.averaged, style.AVERAGED_LABEL)

    def _hatch_over(self, field: Floats, label: str, zorder: float = _COVERS) -> bool:
        """Hatch the area in which a field is positive over its colours; False where it is hardly seen."""
        look = {"gid": label, "label": label, "zorder": zorder, **style.OVER[label]}
        inside = self.fields.evenly(field) > 0.0
        return bool(erode(inside, _HATCHED, beyond=False).any()) and self.fill(field, **look) is not None

    def draw_reversal(self) -> None:
        """Hatch where bodies move backwards, and draw the line on which they stand still on average."""
        fields = self.fields
        if not self._hatch_over(fields.backwards, style.BACKWARDS_LABEL, zorder=1.2):
            return
        hidden = [*self._covers, fields.rest, fields.unknown, -fields.regular]
        pieces = zero_lines(fields, fields.reversal, hidden)
        self.draw_curve(style.ZERO_SPEED.label, style.ZERO_SPEED, self._long(pieces))

    def draw_curves(self, names: Iterable[str]) -> None:
        """Draw the critical curves where they bound a regime."""
        for name in names:
            hidden_by = hiding_fields(self.fields, name)
            pieces = zero_lines(self.fields, self.fields.log_ratio[name], hidden_by)
            self.draw_curve(name, style.CURVES[name], pieces)

    def draw_curve(self, name: str, curve: style.CurveStyle, pieces: list[Floats]) -> None:
        """Draw the pieces of a curve, if any, to be named by ``write``."""
        if not pieces:
            return
        width = curve.width * self._scale
        # Dark around a white curve, white around others on coloured numbers.
        ground = style.INK if curve.colour == style.ZERO_SPEED.colour else "#FFFFFF"
        has_halo = self._has_numbers or ground == style.INK
        halo = style.halo(ground, width + _HALO, alpha=0.8) if has_halo else None
        look = {**curve.look, "linewidth": width, "path_effects": halo}
        line = self._line(pieces, gid=name, zorder=3.0 + 0.1 * width, **look)
        line.set_label("" if self._single else curve.label)
        self._curves += [(curve.label, pieces, line)] if curve.label else []
        self._clear += pieces

    def draw_level(self, values: Floats, level: float, text: str) -> None:
        """Draw and label one thick contour of the numbers."""
        heights = np.nan_to_num(values) - level
        # Irregular motion has no contour to be followed between its points: there they are outlined.
        outlined = np.where(heights >= 0.0, level, -level)
        heights = np.where(self.fields.regular > 0.0, heights, outlined)
        pieces = zero_lines(self.fields, heights, self._covers)
        self.draw_curve(text, style.WANTED._replace(label=text), self._long(pieces))

    def draw_numbers(self, values: Floats, scale: Scale) -> None:
        """Draw numbers as colours beneath the covers, with contours that ``write`` labels."""
        fields, norm, colours = self.fields, scale.norm, colours_of(scale.colours)
        self._has_numbers = True
        self.axes.set_facecolor(style.NO_ANSWER_FACE)
        # A mesh of so many cells draws slowly, and so does mapping numbers to colours pixel by pixel. On a
        # grid that is even on the paper, for any scale of the axes, an image of colours is the same picture.
        # Numbers below a logarithmic scale have the colour of its foot.
        heights = np.asarray(norm(np.maximum(values, float(norm.vmin or 0.0))))
        even = spread_evenly(heights, fields.panel.x.on_paper, (fields.panel.y or fields.panel.x).on_paper)
        right, up = (0.5 / (n - 1) for n in even.shape[::-1])
        place: Any = {"extent": (-right, 1.0 + right, -up, 1.0 + up), "transform": self.axes.transAxes}
        look: Any = {"origin": "lower", "aspect": "auto", "interpolation": "nearest", "zorder": 0}
        image = self.axes.imshow(colours(even, bytes=True), **place, **look)
        image.set(norm=norm, cmap=colours)  # not applied again: it only records the scale in the image
        hidden = [*self._covers, -fields.regular]
        heights = np.nan_to_num(heights)
        for level in scale.levels:
            if pieces := self._long(zero_lines(fields, heights - norm(level), hidden)):
                ground = colours(norm(level))
                look = {"color": style.ink_on(ground), "linewidth": 0.6 * self._scale, "zorder": 1.5}
                line = self._line(pieces, gid=f"contour {level:g}", **look)
                self._contours.append((style.number_text(level), pieces, ground, line))

    def _long(self, pieces: list[Floats], least: float = _SPECK) -> list[Floats]:
        """Return the pieces of a contour that are long enough to draw."""
        to_axes = self.axes.transData - self.axes.transAxes
        return [piece for piece in pieces if np.hypot(*np.ptp(to_axes.transform(piece), 0)) >= least]

    def write(self, *, avoid: Floats) -> bool:
        """Write the words that fit, replacing those of an earlier call; leave others to the legend.

        Parameters
        ----------
        avoid : (n, 2) float array
            Points, in the user's units, to be kept clear.

        Returns
        -------
        bool
            Whether the legend has to change.
        """
        for word in [*self.axes.texts]:
            word.remove()
        before = [artist.get_label() for _, _, artist in (*self._regions, *self._curves)]
        labeller = Labeller(self.axes)
        labeller.avoid(avoid, radius=9.0)
        labeller.avoid_lines(self._clear)
        self._write_regions(labeller)
        for text, pieces, line in self._curves:
            look: dict[str, Any] = {"color": style.INK, "path_effects": style.halo("#FFFFFF")}
            if line.get_label() != text:
                fits = self._single and labeller.along(text, pieces, beside=True, fontsize=8.5, **look)
                line.set_label("" if fits else text)
        self._write_numbers(labeller)
        return before != [artist.get_label() for _, _, artist in (*self._regions, *self._curves)]

    def _write_regions(self, labeller: Labeller) -> None:
        for text, member, artist in self._regions:
            if self._single and artist.get_label() == text:
                continue
            face = artist.get_facecolor()
            look: dict[str, Any] = {"color": style.ink_on(face), "fontsize": 10.0 * self._scale}
            look["path_effects"] = style.halo(face) if artist.get_hatch() else None
            fits = labeller.in_region(text, member, **look)
            fits = fits or labeller.along(text, self._spines.get(text, []), **look)
            artist.set_label("" if fits and self._single else text)

    def _write_numbers(self, labeller: Labeller) -> None:
        """Write the numbers of contours; one that has no room for its number is hidden."""
        for _, pieces, _, _ in self._contours:
            labeller.avoid_lines(pieces)
        for text, pieces, ground, line in self._contours:
            # They lie in the order of covers: hatches over the line go over the number too.
            plate = {"boxstyle": "square,pad=0.12", "facecolor": ground, "edgecolor": "none"}
            look: dict[str, Any] = {"bbox": plate, "color": style.ink_on(ground), "zorder": _COVERS}
            look["fontsize"] = 8.0 * self._scale
            written = [labeller.along(text, [piece], **look) for piece in self._long(pieces, _NUMBERED)]
            line.set_visible(any(written) or labeller.along(text, pieces, **look))

    def cover(self, field: Floats, label: str, look: Mapping[str, Any]) -> None:
        """Cover the area in which a field is positive, and have its visible part named."""
        filled = self.fill(field, gid=label, zorder=_COVERS - 0.01 * len(self._covers), **look)
        if filled is not None:
            self._name_region(label, field, filled)
            self._covers.append(field)

    def _name_region(self, text: str, field: Floats, filled: Any) -> None:
        """Have the visible part of the area in which a field is positive named, if there is any."""
        seen = np.minimum.reduce([field, *(-cover for cover in self._covers)])
        member = self.fields.evenly(seen) > 0.0
        if member.any():
            filled.set_label("" if self._single else text)
            self._regions.append((text, member, filled))

    def fill(self, field: Floats, **look: Any) -> Any:
        """Fill the area in which a field is positive, and return what does; None if there is none."""
        path = zero_region(self.fields, field)
        if path is None:
            return None
        return self.axes.add_artist(PathPatch(path, **{"linewidth": 0.0, "edgecolor": "none", **look}))

    def _line(self, pieces: list[Floats], **look: Any) -> Any:
        """Draw the pieces of one line as one artist, and return it."""
        gap = np.full((1, 2), np.nan)
        points = np.concatenate([part for piece in pieces for part in (piece, gap)])
        (line,) = self.axes.plot(points[:, 0], points[:, 1], **look)
        return line
