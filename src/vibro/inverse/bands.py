"""Check the bands that a caller passes with a scene, and build the uncertainty set that they span."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, Final

from vibro.errors import Problem, SceneError, shown
from vibro.inverse.spaces import UncertaintySet, space_of
from vibro.quantities import QUANTITIES
from vibro.reals import NotRealError, real_array
from vibro.scene import Scene, field_range, field_text

if TYPE_CHECKING:
    from collections.abc import Collection, Mapping

    from vibro.inverse.specs import Span

__all__ = ["one_point", "uncertainty_set"]

_PARTS: Final = ("static_friction", "friction_ratio", "kinetic_friction", "trough_angle")
_RIGHT_ANGLE: Final = 0.5 * math.pi


def one_point(scene: object) -> None:
    """Raise SceneError unless the scene is one operating point of a trough that moves."""
    if not isinstance(scene, Scene):
        raise SceneError((Problem("scene", shown(scene), "a vibro.Scene"),))
    if scene.shape:
        raise SceneError((Problem("scene", f"shape {scene.shape}", "one operating point, of shape ()"),))
    if scene.motion is not None and not scene.load > 0.0:
        raise SceneError((Problem("motion", "no acceleration at all", "a motion that moves the trough"),))


def uncertainty_set(
    scene: Scene, bands: Mapping[str, Any], *, leaves_out: Collection[str] = ()
) -> UncertaintySet:
    """Return the uncertainty set (box) that bands span around a scene.

    Parameters
    ----------
    scene : Scene
        One operating point; it gives the values of fields without a band.
    bands : mapping of str to pair of float
        By field name, in SI units and radians.
    leaves_out : collection of str
        Fields that must not have a band.

    Raises
    ------
    SceneError
        If the scene is more than one operating point or a band is invalid; it lists every problem.
    """
    one_point(scene)
    space = space_of(scene)
    banded = (*space.knobs, *_PARTS)
    known = [name for name in banded if name not in leaves_out]
    problems = []
    given: dict[str, Span] = {}
    for name, band in bands.items():
        if name not in known:
            problems.append(Problem(f"band {shown(name)}", shown(band), f"of one of {', '.join(known)}"))
            continue
        found = _span(name, band)
        if isinstance(found, Problem):
            problems.append(found)
        elif name == "normal_phase" and found[1] - found[0] > 2.0 * math.pi:
            problems.append(Problem(name, shown(band), "a band of at most one turn, in radians"))
        else:
            given[name] = found
    if "friction_ratio" in given and "kinetic_friction" in given:
        problems.append(
            Problem("friction_ratio", shown(bands["friction_ratio"]), "left out beside kinetic_friction")
        )
    if problems:
        raise SceneError(tuple(problems))
    fields = {name: float(value) for _, name, value in scene.arrays().members()}
    spans = {name: given.get(name, (fields.get(name, math.nan),) * 2) for name in banded}
    is_ratio = "friction_ratio" in given
    shape = {name: spans[name] for name in space.shape}
    box = UncertaintySet(
        space=space,
        factor=spans.get("amplitude", spans.get("motion_scale", (1.0, 1.0))),
        frequency=spans["frequency"],
        shape=shape,
        trough_angle=spans["trough_angle"],
        static_friction=spans["static_friction"],
        second_friction=spans["friction_ratio" if is_ratio else "kinetic_friction"],
        is_ratio=is_ratio,
        gravity=fields["gravity"],
        restitution=fields["restitution"],
    )
    if not is_ratio and spans["kinetic_friction"][0] > spans["static_friction"][1]:
        limit = f"<= static_friction = {spans['static_friction'][1]:.15g} somewhere in its band"
        problems.append(Problem("kinetic_friction", f"{spans['kinetic_friction'][0]:.15g}", limit))
    if "drive_angle" in shape:
        problems += _line_problems(box)
    if problems:
        raise SceneError(tuple(problems))
    return box


def _line_problems(box: UncertaintySet) -> list[Problem]:
    """Return the problem of a drive along a line with too steep an angle."""
    drive, trough = box.shape["drive_angle"][1], box.trough_angle[1]
    if drive + trough < _RIGHT_ANGLE:
        return []
    limit = f"less than 90 deg together with trough_angle = {field_text('trough_angle', trough)}"
    return [Problem("drive_angle", field_text("drive_angle", drive), limit)]


def _span(name: str, band: Any) -> Span | Problem:
    """Read a band; return the problem if it is invalid."""
    try:
        ends = real_array(band)
    except NotRealError as exc:
        return Problem(name, exc.value, "a pair of numbers (low, high)")
    if ends.shape != (2,):
        return Problem(name, shown(band), "a pair of numbers (low, high)")
    low, high = (float(end) for end in ends)
    for end in (low, high):
        if not (math.isfinite(end) and QUANTITIES[name].allows(end)):
            return Problem(name, field_text(name, end), field_range(name))
    if low > high:
        return Problem(name, shown(band), "a pair (low, high) with low <= high")
    return low, high
