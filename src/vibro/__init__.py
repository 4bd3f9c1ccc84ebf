"""Vibratory conveyors: regimes, conveying speed and traverse time, exact to rounding.

The public names load their modules on first use, so that ``vibro --help`` imports no numerical library.
"""

from __future__ import annotations

from vibro.version import __version__ as __version__

TYPE_CHECKING = False  # typing and importlib take time in which a run could not be interrupted properly
if TYPE_CHECKING:
    from typing import Any

    from vibro.core.codes import Regime, Status
    from vibro.designs.design import design
    from vibro.designs.guarantees import guarantee
    from vibro.designs.windows import feasible_amplitudes, yield_share
    from vibro.drives import Motion
    from vibro.errors import FileError, InputError, SceneError, VibroError
    from vibro.fillings import filling
    from vibro.limits import critical_loads, transitions
    from vibro.machines.machine import Calibration, Machine
    from vibro.machines.operating import OperatingPoints, operate, operating_points
    from vibro.motion.attractors import attractors
    from vibro.motion.histories import arrival_time, simulate
    from vibro.records.trough import MeasuredMotion, measured_motion, trough_motion
    from vibro.results.attractors import Attractor, Attractors
    from vibro.results.designs import Certificate, DesignResult, Guarantee, Interval
    from vibro.results.history import History
    from vibro.results.operating import Filling
    from vibro.results.steady import SteadyCycle
    from vibro.scene import Scene
    from vibro.steady import solve
    from vibro.sweeps.whole import read_scene, sweep
    from vibro.tables.stored import open_sweep
    from vibro.tables.writing import write_sweep

__all__ = [
    "Attractor",
    "Attractors",
    "Calibration",
    "Certificate",
    "DesignResult",
    "FileError",
    "Filling",
    "Guarantee",
    "History",
    "InputError",
    "Interval",
    "Machine",
    "MeasuredMotion",
    "Motion",
    "OperatingPoints",
    "Regime",
    "Scene",
    "SceneError",
    "Status",
    "SteadyCycle",
    "VibroError",
    "arrival_time",
    "attractors",
    "critical_loads",
    "design",
    "feasible_amplitudes",
    "filling",
    "guarantee",
    "measured_motion",
    "open_sweep",
    "operate",
    "operating_points",
    "read_scene",
    "simulate",
    "solve",
    "sweep",
    "transitions",
    "trough_motion",
    "write_sweep",
    "yield_share",
]

_HOMES = {
    "Attractor": "vibro.results.attractors",
    "Attractors": "vibro.results.attractors",
    "Calibration": "vibro.machines.machine",
    "Certificate": "vibro.results.designs",
    "DesignResult": "vibro.results.designs",
    "FileError": "vibro.errors",
    "Filling": "vibro.results.operating",
    "Guarantee": "vibro.results.designs",
    "History": "vibro.results.history",
    "InputError": "vibro.errors",
    "Interval": "vibro.results.designs",
    "Machine": "vibro.machines.machine",
    "MeasuredMotion": "vibro.records.trough",
    "Motion": "vibro.drives",
    "OperatingPoints": "vibro.machines.operating",
    "Regime": "vibro.core.codes",
    "Scene": "vibro.scene",
    "SceneError": "vibro.errors",
    "Status": "vibro.core.codes",
    "SteadyCycle": "vibro.results.steady",
    "VibroError": "vibro.errors",
    "arrival_time": "vibro.motion.histories",
    "attractors": "vibro.motion.attractors",
    "critical_loads": "vibro.limits",
    "design": "vibro.designs.design",
    "feasible_amplitudes": "vibro.designs.windows",
    "filling": "vibro.fillings",
    "guarantee": "vibro.designs.guarantees",
    "measured_motion": "vibro.records.trough",
    "open_sweep": "vibro.tables.stored",
    "operate": "vibro.machines.operating",
    "operating_points": "vibro.machines.operating",
    "read_scene": "vibro.sweeps.whole",
    "simulate": "vibro.motion.histories",
    "solve": "vibro.steady",
    "sweep": "vibro.sweeps.whole",
    "transitions": "vibro.limits",
    "trough_motion": "vibro.records.trough",
    "write_sweep": "vibro.tables.writing",
    "yield_share": "vibro.designs.windows",
}


def __getattr__(name: str) -> Any:
    if name not in _HOMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    from importlib import import_module

    value = getattr(import_module(_HOMES[name]), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
