"""The layers of one map: filled regions, hatched covers, critical curves, contours, and their words."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, Final, NamedTuple

import numpy as np

from vibro.core.codes import Regime, Status
from vibro.plots.fields import BEGINS_AT, HIDDEN_BY, hiding_fields, without_hidden, zero_lines, zero_region
from vibro.plots.labels import Labeller
from vibro.plots.neighbours import erode, spread_evenly
from vibro.plots.scales import colours_of
from vibro.plots.style import (
    AVERAGED_LABEL,
    BACKWARDS_HATCH,
    BACKWARDS_LABEL,
    COEXISTS_HATCH,
    COEXISTS_LABEL,
    CONTOURS_STOP_LABEL,
    CURVES,
    INK,
    NO_ANSWER_FACE,
    NO_ANSWER_HATCH,
    NO_ANSWER_INK,
    REGIME_COLOURS,
    ZERO_SPEED,
    CurveStyle,
    ink_on,
    number_text,
)

if TYPE_CHECKING:
    from collections.abc import Iterable

    from matplotlib.axes import Axes
    from numpy.typing import NDArray

    from vibro.plots.fields import Fields
    from vibro.plots.scales import Scale

    Floats = NDArray[np.float64]

__all__ = ["MapLayers"]

_COVERS: Final = 2.0  # zorder of the uppermost cover
# Where numbers jump up and down, contours break up into specks. Shorter pieces than this are left out.
_SPECK: Final = 0.04  # of the side of the map
_HATCHED: Final = 0.01  # of the side of the map: least width of an area in which a hatch is seen
_STRIPE: Final = 24.0  # [px] from one stripe over irregular motion to the next
_STRIPE_INK: Final = 0.4  # opacity of these stripes: the colours below must stay readable
_NUMBERED: Final = 0.25  # of the side of the map: longer pieces of a contour have its number each
_CUT_OFF: Final = 0.25  # of a field that is 0 where a contour is cut off, and 0.5 elsewhere
_NO_LINE: Final = {"color": INK, "linestyle": "none"}  # in the legend, of a remark
_FACET_TYPE: Final = 0.8  # size of type on facets, relative to that on single maps


def _coinciding(curves: list[tuple[CurveStyle, list[Floats]]]) -> list[tuple[CurveStyle, list[Floats]]]:
    """Join curves that are the same line under one name, with the pieces of both."""
    joined: list[tuple[CurveStyle, list[Floats]]] = []
    for style, pieces in curves:
        if joined and _are_same(joined[-1][1], pieces):
            first, others = joined.pop()
            joined.append((first._replace(label=f"{first.label}, {style.label}"), [*others, *pieces]))
        else:
            joined.append((style, pieces))
    return joined


def _are_same(pieces: list[Floats], others: list[Floats]) -> bool:
    return len(pieces) == len(others) and all(
        piece.shape == other.shape and np.allclose(piece, other)
        for piece, other in zip(pieces, others, strict=True)
    )


class _Contour(NamedTuple):
    """A contour, and the number that it gets."""

    text: str
    pieces: list[Floats]
    ground: Any  # colour
    artist: Any


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
        self.legend: dict[str, dict[str, Any]] = {}  # text -> style of its handle
        self._single = single
        self._scale = 1.0 if single else _FACET_TYPE
        self._has_numbers = False
        self._covers: list[Floats] = []
        self._regions: list[tuple[str, NDArray[np.bool_], dict[str, Any]]] = []
        self._words: list[Any] = []
        self._spines: dict[str, list[Floats]] = {}
        self._curves: list[tuple[CurveStyle, list[Floats]]] = []
        self._clear: list[Floats] = []  # lines that words keep clear of
        self._outlines: list[Floats] = []  # lines that numbers keep clear of, but curves may follow
        self._contours: list[_Contour] = []

    @property
    def open(self) -> NDArray[np.bool_]:
        """Grid points that no cover hides, of those drawn so far."""
        seen = np.ones((len(self.fields.y), len(self.fields.x)), np.bool_)
        for cover in self._covers:
            seen &= cover <= 0.0
        return seen

    def fill_regimes(self) -> None:
        """Fill every regime with its colour, bounded by the critical curves."""
        self.axes.set_facecolor(REGIME_COLOURS[Regime.NO_SLIP])
        for regime, curve in BEGINS_AT.items():
            self._fill(
                self.fields.log_ratio[curve],
                gid=regime.label,
                facecolor=REGIME_COLOURS[regime],
                zorder=1,
            )

    def name_regimes(self) -> None:
        """Have the visible regimes named by ``write``."""
        begun = [self.fields.log_ratio[curve] for curve in BEGINS_AT.values()]
        for regime, colour in REGIME_COLOURS.items():
            # Where it has begun and no later one has, as the areas are filled.
            place = list(BEGINS_AT).index(regime) + 1 if regime in BEGINS_AT else 0
            own, later = begun[max(place - 1, 0) : place], begun[place:]
            inside = np.minimum.reduce([*own, *(-field for field in later)])
            if self._name_region(regime.label, inside, facecolor=colour):
                self._spines[regime.label] = self._spine(regime)

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
        for status, hatch in NO_ANSWER_HATCH.items():
            known = regimes_show and status is Status.FLIGHT_NOT_MODELLED
            if status in self.fields.statuses and not known:
                self.hatch(self.fields.unanswered(status), status.label.replace("-", " "), hatch)

    def hatch(self, field: Floats, label: str, hatch: str, face: str = NO_ANSWER_FACE) -> None:
        """Hatch the area in which a field is positive, beneath earlier covers, and name the reason."""
        self._cover(field, label, facecolor=face, hatch=hatch, edgecolor=NO_ANSWER_INK)

    def cover_rest(self) -> None:
        """Cover the area where nothing moves with the colour of that regime, beneath earlier covers."""
        self._cover(self.fields.rest, Regime.NO_SLIP.label, facecolor=REGIME_COLOURS[Regime.NO_SLIP])

    def cover_contact(self) -> None:
        """Cover the area where nothing flies, beneath earlier covers."""
        self._cover(-self.fields.log_ratio["hop"], "no flight", facecolor=REGIME_COLOURS[Regime.NO_SLIP])

    def hatch_doubtful(self) -> None:
        """Hatch, over the colours, where another motion exists and where a number is a mean."""
        marks = [(self.fields.coexists, COEXISTS_LABEL, COEXISTS_HATCH, NO_ANSWER_INK)]
        if self._has_numbers:
            self._stripe(self.fields.averaged, AVERAGED_LABEL)
        for field, label, hatch, ink in marks:
            style = {"facecolor": "none", "hatch": hatch, "edgecolor": ink}
            if self._shows(field) and self._fill(field, gid=label, zorder=_COVERS, **style):
                self.legend[label] = style

    def _stripe(self, field: Floats, label: str) -> None:
        """Draw faint stripes, wide apart, over the area in which a field is positive, dark in white.

        A hatch of matplotlib's has one colour, and is so fine that it looks like a pattern of the numbers.
        """
        from matplotlib.collections import LineCollection
        from matplotlib.patheffects import withStroke

        if not self._shows(field) or not self._fill(field, gid=label, zorder=_COVERS, facecolor="none"):
            return
        box = self.axes.bbox
        rise = box.width / box.height  # of a stripe, which leans by 45 degrees on the paper
        feet = np.arange(-rise, 1.0, _STRIPE / box.height)
        stripes = LineCollection(
            [[(0.0, foot), (1.0, foot + rise)] for foot in feet],
            colors=INK,
            linewidths=0.6 * self._scale,
            alpha=_STRIPE_INK,
            transform=self.axes.transAxes,
            path_effects=[withStroke(linewidth=1.5 * self._scale, foreground="#FFFFFF", alpha=_STRIPE_INK)],
            zorder=_COVERS,
            gid=label,
        )
        self.axes.add_collection(stripes, autolim=False)
        stripes.set_clip_path(self.axes.patches[-1])
        self.legend[label] = {"facecolor": "none", "edgecolor": INK, "hatch": "//"}

    def draw_reversal(self) -> None:
        """Hatch where bodies move backwards, and draw the line on which they stand still on average."""
        fields = self.fields
        if not self._shows(fields.backwards):
            return
        style = {"facecolor": "none", "hatch": BACKWARDS_HATCH, "edgecolor": INK}
        self._fill(fields.backwards, gid=BACKWARDS_LABEL, zorder=1.2, **style)
        self.legend[BACKWARDS_LABEL] = style
        hidden = [*self._covers, fields.rest, fields.unknown, -fields.regular]
        pieces = zero_lines(fields, without_hidden(fields.reversal, hidden), hidden)
        self.draw_curve(ZERO_SPEED.label, ZERO_SPEED, [piece for piece in pieces if self._is_long(piece)])

    def draw_curves(self, names: Iterable[str]) -> None:
        """Draw the critical curves where they bound a regime."""
        for name in names:
            hidden_by = hiding_fields(self.fields, name)
            self.draw_curve(
                name, CURVES[name], zero_lines(self.fields, self.fields.log_ratio[name], hidden_by)
            )

    def draw_curve(self, name: str, style: CurveStyle, pieces: list[Floats]) -> None:
        """Draw the pieces of a curve, if any, and label it."""
        if not pieces:
            return
        width = style.width * self._scale
        look = {"color": style.colour, "linestyle": style.dashes, "linewidth": width}
        self._line(
            pieces,
            label=style.label,
            gid=name,
            zorder=3,
            path_effects=self._halo(style, width),
            **look,
        )
        self._curves.append((style, pieces))
        self._clear += pieces
        if not self._single:
            self._explain_curve(style)

    def _halo(self, style: CurveStyle, width: float) -> list[Any] | None:
        """Return the outline of a curve: white on coloured numbers, dark around a white curve."""
        from matplotlib.patheffects import withStroke

        if style.colour != INK:
            return [withStroke(linewidth=width + 1.8, foreground=INK)]
        light = withStroke(linewidth=width + 1.4, foreground="#FFFFFF", alpha=0.7)
        return [light] if self._has_numbers else None

    def draw_level(self, values: Floats, level: float, text: str) -> None:
        """Draw and label one thick contour of the numbers, or say that there is none."""
        heights = np.nan_to_num(values) - level
        # Irregular motion has no contour to be followed between its points: there they are outlined.
        outlined = np.where(heights >= 0.0, level, -level)
        heights = np.where(self.fields.regular > 0.0, heights, outlined)
        pieces = zero_lines(self.fields, without_hidden(heights, self._covers), self._covers)
        long = [piece for piece in pieces if self._is_long(piece)]
        self.draw_curve(text, CurveStyle(text, (0, (1, 1)), 2.2), long)
        reached = heights[self.open] >= 0.0
        if not reached.any():
            self.legend[f"{text} is reached nowhere"] = _NO_LINE
        elif reached.all():
            self.legend[f"{text} is reached everywhere"] = _NO_LINE

    def draw_numbers(self, values: Floats, scale: Scale) -> None:
        """Draw numbers as colours beneath the covers, with contours that ``write`` labels."""
        fields, norm, colours = self.fields, scale.norm, colours_of(scale)
        self._has_numbers = True
        self.axes.set_facecolor(NO_ANSWER_FACE)
        # A mesh of so many cells draws slowly, and so does mapping numbers to colours pixel by pixel. On a
        # grid that is even on the paper, for any scale of the axes, an image of colours is the same picture.
        # Numbers below a logarithmic scale have the colour of its foot.
        heights = np.asarray(norm(np.maximum(values, float(norm.vmin or 0.0))))
        x, y = fields.panel.x, fields.panel.y or fields.panel.x
        even = spread_evenly(heights, x.on_paper, y.on_paper)
        right, up = (0.5 / (n - 1) for n in even.shape[::-1])
        image = self.axes.imshow(
            colours(even, bytes=True),
            origin="lower",
            extent=(-right, 1.0 + right, -up, 1.0 + up),
            transform=self.axes.transAxes,
            aspect="auto",
            interpolation="nearest",
            zorder=0,
        )
        image.set(norm=norm, cmap=colours)  # not applied again: it only records the scale in the image
        hidden = [*self._covers, -fields.smooth]
        heights = without_hidden(np.nan_to_num(heights), hidden)
        for level in scale.levels:
            pieces = zero_lines(fields, heights - norm(level), hidden)
            pieces = [piece for piece in pieces if self._is_long(piece)]
            if pieces:
                ground = colours(norm(level))
                look = {"color": ink_on(ground), "linewidth": 0.6 * self._scale, "zorder": 1.5}
                line = self._line(pieces, gid=f"contour {level:g}", **look)
                self._contours.append(_Contour(number_text(level), pieces, ground, line))
            ends = [piece[end] for piece in pieces for end in (0, -1)]
            if ends and np.any(fields.at(fields.smooth, np.array(ends)) < _CUT_OFF):
                self.legend[CONTOURS_STOP_LABEL] = _NO_LINE

    def _is_long(self, piece: Floats, least: float = _SPECK) -> bool:
        """Whether a piece of a contour is long enough to draw."""
        width, height = np.ptp(
            self.axes.transAxes.inverted().transform(self.axes.transData.transform(piece)), 0
        )
        return bool(np.hypot(width, height) >= least)

    def write(self, *, avoid: Floats) -> None:
        """Write the words that fit, replacing those of an earlier call; others go to the legend.

        Parameters
        ----------
        avoid : (n, 2) float array
            Points, in the user's units, to be kept clear.
        """
        for word in self._words:
            word.remove()
        labeller = Labeller(self.axes)
        labeller.avoid(avoid, radius=9.0)
        labeller.avoid_lines(self._clear)
        self._write_regions(labeller)
        self._write_curves(labeller)
        labeller.avoid_lines(self._outlines)
        self._write_numbers(labeller)
        self._words = labeller.words

    def _write_regions(self, labeller: Labeller) -> None:
        for text, member, style in self._regions:
            face = style["facecolor"]
            halo = face if "hatch" in style else None
            type_style: dict[str, Any] = {"color": ink_on(face), "fontsize": 10.0 * self._scale}
            fits = labeller.in_region(text, member, halo=halo, **type_style)
            fits = fits or labeller.along(text, self._spines.get(text, []), **type_style)
            if not fits:
                self.legend[text] = style

    def _write_curves(self, labeller: Labeller) -> None:
        # A name beside a line could belong to the next line: it interrupts its own line instead.
        type_style: dict[str, Any] = {"plate": "#FFFFFF", "color": INK, "fontsize": 8.5}
        for style, pieces in _coinciding(self._curves) if self._single else []:
            if not labeller.along(style.label, pieces, **type_style):
                self._explain_curve(style)

    def _write_numbers(self, labeller: Labeller) -> None:
        """Write the numbers of contours; one that has no room for its number is hidden."""
        for contour in self._contours:
            labeller.avoid_lines(contour.pieces)
        crowded = [contour for contour in self._contours if not self._write_number(labeller, contour)]
        for contour in crowded:
            labeller.forget_lines(contour.pieces)
        for contour in crowded:  # fewer contours may leave room
            labeller.avoid_lines(contour.pieces)
            if not self._write_number(labeller, contour):
                labeller.forget_lines(contour.pieces)

    def _write_number(self, labeller: Labeller, contour: _Contour) -> bool:
        # Numbers of contours lie in the order of covers: hatches over the line go over the number too.
        style: dict[str, Any] = {"plate": contour.ground, "color": ink_on(contour.ground), "zorder": _COVERS}
        size = 8.0 * self._scale
        long = [piece for piece in contour.pieces if self._is_long(piece, _NUMBERED)]
        written = [labeller.along(contour.text, [piece], fontsize=size, **style) for piece in long]
        fits = any(written) or labeller.along(contour.text, contour.pieces, fontsize=size, **style)
        contour.artist.set_visible(fits)
        return fits

    def _shows(self, field: Floats) -> bool:
        """Whether the area in which a field is positive is wide enough to see a hatch there."""
        inside = self.fields.evenly(field) > 0.0
        return bool(erode(inside, math.ceil(_HATCHED * min(inside.shape)), beyond=False).any())

    def _explain_curve(self, style: CurveStyle) -> None:
        self.legend[style.label] = {
            "color": style.colour, "linestyle": style.dashes, "linewidth": style.width,
            "path_effects": self._halo(style, style.width),
        }  # fmt: skip

    def _cover(self, field: Floats, label: str, **style: Any) -> None:
        """Cover the area in which a field is positive, and label its visible part."""
        if self._fill(field, gid=label, zorder=_COVERS - 0.01 * len(self._covers), **style):
            self._name_region(label, field, **style)
            self._covers.append(field)

    def _name_region(self, text: str, field: Floats, **style: Any) -> bool:
        """Label the visible part of the area in which a field is positive; False if none is visible."""
        seen = np.minimum.reduce([field, *(-cover for cover in self._covers)])
        member = self.fields.evenly(seen) > 0.0
        if not member.any():
            return False
        self._regions.append((text, member, style))
        if not self._single:
            self.legend[text] = style
        return True

    def _fill(self, field: Floats, **style: Any) -> bool:
        """Fill the area in which a field is positive; False if there is none."""
        from matplotlib.patches import PathPatch

        path = zero_region(self.fields, field)
        if path is None:
            return False
        self.axes.add_artist(PathPatch(path, **{"linewidth": 0.0, "edgecolor": "none", **style}))
        return True

    def _line(self, pieces: list[Floats], **style: Any) -> Any:
        """Draw the pieces of one line as one artist, and return it."""
        gap = np.full((1, 2), np.nan)
        points = np.concatenate([part for piece in pieces for part in (piece, gap)])
        (line,) = self.axes.plot(points[:, 0], points[:, 1], **style)
        return line
