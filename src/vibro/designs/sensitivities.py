"""What small changes of each input do to the mean speed: as derivatives, and as solved again."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from vibro.core.codes import Regime, Status
from vibro.designs.spaces import space_of
from vibro.quantities import QUANTITIES
from vibro.scene import Scene, check_single
from vibro.steady import solve

if TYPE_CHECKING:
    from vibro.results.steady import SteadyCycle

_STEP: Final = 3e-6  # [1, rad] step of the finite differences
_CHANGED: Final = 0.01  # [1] an input is raised by this share of it, or an angle by 1 deg
_RAISED: Final = 0.1  # [1] and the whole drive by this share
# Slopes at the first of four points a step apart: of the cubic through them, and of the parabola through
# three.
_SLOPES: Final = np.array([[-11.0, 18.0, -9.0, 2.0], [-9.0, 12.0, -3.0, 0.0]]) / 6.0
# Where the speed is smooth two of these differ by less than this share. If the next singularity is n steps
# away, slopes of both sides differ by some n^-3, and their mean is wrong by n^-4.
_SMOOTH: Final = 1e-5
_JUMP: Final = 100.0  # [%/%] a steeper slope over one step is a jump: beside an onset slopes reach some tens
_PARTS: Final = ("static_friction", "kinetic_friction", "trough_angle")
_ANGLES: Final = ("normal_phase", "trough_angle")  # of which 1 % may be too small a change
_BOUNCE: Final = "restitution"  # likewise, and only bodies that hop depend on it
#: Restitutions of ``speeds_over_restitution``: their number, and the largest; the least is 0 [1].
RESTITUTIONS: Final = 33
LARGEST: Final = 0.5


def speed_costs(scene: Scene) -> dict[str, float | str]:
    """Return by how many percent the mean speed changes for a small change of each input.

    Parameters
    ----------
    scene : Scene
        One operating point, of shape ().

    Returns
    -------
    dict of str to float or str
        ``amplitude``, ``frequency``, ``drive_angle``, ``static_friction``, ``kinetic_friction``: change in
        per cent for 1 % more of it; elliptical drives have ``along_amplitude`` and ``normal_amplitude``
        instead of amplitude and drive angle, given motions ``motion_scale``. ``trough_angle_deg`` and
        ``normal_phase_deg``: change for 1 deg more, since 1 % of an angle near 0 is nothing; likewise
        ``restitution``, which bodies that hop have: for 0.01 more. Positive
        values mean faster, also for a body that is conveyed backwards [%]. A text says why there is no
        number: the body rests, is not conveyed, runs away or hops irregularly, or its speed jumps or bends at
        the scene.

    Raises
    ------
    SceneError
        If the scene is more than one operating point.

    Notes
    -----
    Differences of third order, to 1e-6; there is a number where those below and above the scene agree. At
    mu_d = mu_s and e = 0, where one side alone can be, it is that of this side.
    """
    inputs = _inputs(scene)
    cycle = solve(scene)
    if why := _why_none(cycle):
        return dict.fromkeys(inputs.values(), why)
    return {key: _difference(scene, name) for name, key in inputs.items()}


def speeds_over_restitution(scene: Scene) -> tuple[float, float]:
    """Return the least and the largest mean speed of one scene over restitutions of 0 to 0.5 [m/s].

    Speeds are solved at ``RESTITUTIONS`` values, an even spread: between two of them there may be others.
    NaN where no speed is known.
    """
    fields = _fields(scene) | {_BOUNCE: np.linspace(0.0, LARGEST, RESTITUTIONS)}
    speed = np.asarray(solve(Scene.computed(**fields)).mean_velocity)
    known = speed[np.isfinite(speed)]
    return (float(known.min()), float(known.max())) if known.size else (math.nan, math.nan)


def changed_cycles(scene: Scene) -> tuple[list[str], SteadyCycle]:
    """Solve a scene, and again with a little more of each input, and with more of the whole drive.

    Derivatives hold within the pattern of a scene. Where bodies hop, 1 % leads into other patterns; and where
    they rest, hop irregularly or stand beside a threshold, there is no derivative at all.

    Parameters
    ----------
    scene : Scene
        One operating point, of shape ().

    Returns
    -------
    names : list of str
        Inputs that are changed, as ``speed_costs`` names them: by 1 %, those that end in ``_deg`` by 1 deg,
        restitution by 0.01. The last one is ``drive``: its amplitudes are 10 % larger.
    cycle : SteadyCycle
        Of shape (1 + len(names),): the scene itself is first. Cells that cannot be are infeasible.

    Raises
    ------
    SceneError
        If the scene is more than one operating point.
    """
    inputs, given, sizes = _inputs(scene), _fields(scene), space_of(scene).sizes
    changed = {name: np.full(len(inputs) + 2, given[name]) for name in inputs}
    for cell, name in enumerate(inputs, 1):
        size = math.radians(1.0) if name in _ANGLES else _CHANGED * (1.0 if name == _BOUNCE else given[name])
        changed[name][cell] += size
    for name in sizes:
        changed[name][-1] *= 1.0 + _RAISED
    return [*inputs.values(), "drive"], solve(Scene.computed(**{**given, **changed}))


def _inputs(scene: Scene) -> dict[str, str]:
    """Return the names of a drive's and a part's inputs as ``speed_costs`` writes them."""
    check_single(scene)
    hops = bool(solve(scene, output="regimes").regime == Regime.HOPPING)
    names = (*space_of(scene).knobs, *_PARTS, *[_BOUNCE] * hops)
    return {name: name + "_deg" * (name in _ANGLES) for name in names}


def _fields(scene: Scene) -> dict[str, Any]:
    """Return the fields of a scene as ``Scene`` takes them."""
    members = scene.arrays().members()
    fields: dict[str, Any] = {known: float(x) for field, known, x in members if field == known}
    return fields if scene.motion is None else {**fields, "motion": scene.motion}


def _why_none(cycle: SteadyCycle) -> str:
    """Return why the speed of a cycle has no sensitivities; empty where it may have some."""
    status = Status(int(cycle.status))
    if status is Status.AVERAGED:
        return "hops: irregular"
    if not status.answered:
        return "runs away" if status is Status.RUNAWAY else f"no speed: {status.label}"
    if cycle.regime == Regime.NO_SLIP:
        return "rests: no speed to change"
    return "" if cycle.mean_velocity != 0.0 else "slides to and fro: no speed to change"


def _difference(scene: Scene, name: str) -> float | str:
    """Return the change of the speed with one input by finite differences, or why it is not smooth there."""
    fields = _fields(scene)
    value = fields[name]
    is_angle = name in _ANGLES
    step = _STEP if is_angle or name == _BOUNCE else _STEP * value
    values = value + step * np.arange(-3.0, 4.0)
    possible = (name != _BOUNCE) | QUANTITIES[_BOUNCE].allows(values)
    cycle = solve(Scene.computed(**{**fields, name: np.where(possible, values, value)}))
    status = np.where(possible, cycle.status, Status.INFEASIBLE)
    speed = np.asarray(cycle.mean_velocity)
    sides = {1.0: slice(3, None), -1.0: slice(3, None, -1)}
    # at mu_d = mu_s and e = 0 there is one side alone
    sides = {way: side for way, side in sides.items() if not np.any(status[side] == Status.INFEASIBLE)}
    if any(np.any(status[side] == Status.AVERAGED) for side in sides.values()):
        return "hops: irregular"
    steepest = max(abs(speed[side][1] / speed[3] - 1.0) for side in sides.values()) / _STEP
    if not steepest <= _JUMP:
        return "jumps here"
    slopes = [way * (_SLOPES @ (speed[side] - speed[3])) / (_STEP * speed[3]) for way, side in sides.items()]
    # both sides or, of one, the cubic and the parabola
    apart = slopes[0][0] - slopes[-1][0 if len(slopes) > 1 else 1]
    if not abs(apart) <= _SMOOTH * max(steepest, 1.0):
        return "bends here"
    slope = sum(float(cubic) for cubic, _ in slopes) / len(slopes)
    return 100.0 * math.radians(slope) if is_angle else slope
