"""Vibratory conveyors: regimes, conveying speed and traverse time, exact to rounding.

The public names load their modules on first use, so that ``vibro --help`` imports no numerical library.
"""

from __future__ import annotations

from vibro.results.drawing import drawings_are_found_by
from vibro.version import __version__ as __version__

TYPE_CHECKING = False  # typing and importlib take time in which a run could not be interrupted properly
if TYPE_CHECKING:
    from typing import Any

    from vibro.core.codes import Regime as Regime
    from vibro.core.codes import Status as Status
    from vibro.designs.design import design as design
    from vibro.designs.guarantees import guarantee as guarantee
    from vibro.designs.windows import feasible_amplitudes as feasible_amplitudes
    from vibro.designs.windows import yield_share as yield_share
    from vibro.drives import Motion as Motion
    from vibro.errors import FileError as FileError
    from vibro.errors import InputError as InputError
    from vibro.errors import SceneError as SceneError
    from vibro.errors import VibroError as VibroError
    from vibro.explore.page import Page as Page
    from vibro.explore.page import page as page
    from vibro.fillings import filling as filling
    from vibro.inverse_friction import critical_friction as critical_friction
    from vibro.inverse_friction import friction_for_speed as friction_for_speed
    from vibro.limits import critical_loads as critical_loads
    from vibro.limits import transitions as transitions
    from vibro.machines.machine import Calibration as Calibration
    from vibro.machines.machine import Machine as Machine
    from vibro.machines.operating import OperatingPoints as OperatingPoints
    from vibro.machines.operating import operate as operate
    from vibro.machines.operating import operating_points as operating_points
    from vibro.motion.attractors import attractors as attractors
    from vibro.motion.histories import arrival_time as arrival_time
    from vibro.motion.histories import simulate as simulate
    from vibro.records.comparison import Comparison as Comparison
    from vibro.records.measurement import compare as compare
    from vibro.records.speeds import SpeedFit as SpeedFit
    from vibro.records.speeds import fit_speeds as fit_speeds
    from vibro.records.trough import MeasuredMotion as MeasuredMotion
    from vibro.records.trough import measured_motion as measured_motion
    from vibro.records.trough import trough_motion as trough_motion
    from vibro.results.attractors import Attractor as Attractor
    from vibro.results.attractors import Attractors as Attractors
    from vibro.results.designs import Certificate as Certificate
    from vibro.results.designs import DesignResult as DesignResult
    from vibro.results.designs import Guarantee as Guarantee
    from vibro.results.designs import Interval as Interval
    from vibro.results.drawing import Drawing
    from vibro.results.history import History as History
    from vibro.results.operating import Filling as Filling
    from vibro.results.steady import SteadyCycle as SteadyCycle
    from vibro.scene import Scene as Scene
    from vibro.steady import solve as solve
    from vibro.sweeps.whole import read_scene as read_scene
    from vibro.sweeps.whole import sweep as sweep
    from vibro.tables.stored import open_sweep as open_sweep
    from vibro.tables.writing import write_sweep as write_sweep

_HOMES = {
    name: f"vibro.{home}"
    for home, names in (
        ("core.codes", "Regime Status"),
        ("designs.design", "design"),
        ("designs.guarantees", "guarantee"),
        ("designs.windows", "feasible_amplitudes yield_share"),
        ("drives", "Motion"),
        ("errors", "FileError InputError SceneError VibroError"),
        ("explore.page", "Page page"),
        ("fillings", "filling"),
        ("inverse_friction", "critical_friction friction_for_speed"),
        ("limits", "critical_loads transitions"),
        ("machines.machine", "Calibration Machine"),
        ("machines.operating", "OperatingPoints operate operating_points"),
        ("motion.attractors", "attractors"),
        ("motion.histories", "arrival_time simulate"),
        ("records.comparison", "Comparison"),
        ("records.measurement", "compare"),
        ("records.speeds", "SpeedFit fit_speeds"),
        ("records.trough", "MeasuredMotion measured_motion trough_motion"),
        ("results.attractors", "Attractor Attractors"),
        ("results.designs", "Certificate DesignResult Guarantee Interval"),
        ("results.history", "History"),
        ("results.operating", "Filling"),
        ("results.steady", "SteadyCycle"),
        ("scene", "Scene"),
        ("steady", "solve"),
        ("sweeps.whole", "read_scene sweep"),
        ("tables.stored", "open_sweep"),
        ("tables.writing", "write_sweep"),
    )
    for name in names.split()
}
__all__ = [*_HOMES]


def _drawing(kind: str) -> Drawing:
    from vibro.answers.drawing import DRAWINGS

    return DRAWINGS[kind]


drawings_are_found_by(_drawing)


def __getattr__(name: str) -> Any:
    if name not in _HOMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    from importlib import import_module

    value = getattr(import_module(_HOMES[name]), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
