"""Build backend: hatchling, and before it the solver's library, by any C compiler that can be had.

Where the system has no compiler pip is asked for one that comes as a package. Where neither works the package
is built all the same: its solver then runs as plain Python, and ``vibro --version`` says so.
"""

from __future__ import annotations

import sys
import sysconfig
from pathlib import Path
from typing import Any

import hatchling.build
from hatchling.build import build_sdist, get_requires_for_build_sdist
from hatchling.builders.hooks.plugin.interface import BuildHookInterface

sys.path.insert(0, str(Path(__file__).parent))

from compiling import LIBRARY, compile_solver, required

__all__ = [
    "build_editable", "build_sdist", "build_wheel", "get_requires_for_build_editable",
    "get_requires_for_build_sdist", "get_requires_for_build_wheel",
]  # fmt: skip


def get_requires_for_build_wheel(config_settings: dict[str, Any] | None = None) -> list[str]:
    """Ask for a compiler where the system has none."""
    return [*hatchling.build.get_requires_for_build_wheel(config_settings), *required()]


def get_requires_for_build_editable(config_settings: dict[str, Any] | None = None) -> list[str]:
    """Ask for a compiler where the system has none."""
    return [*hatchling.build.get_requires_for_build_editable(config_settings), *required()]


def _compiled() -> None:
    if why := compile_solver():
        print(f"vibro's solver is not compiled and will be slow: {why}", file=sys.stderr)


def build_wheel(folder: str, config_settings: Any = None, metadata_directory: str | None = None) -> str:
    """Build a wheel for this platform and any version of Python; without a compiler for any platform."""
    _compiled()
    return str(hatchling.build.build_wheel(folder, config_settings, metadata_directory))


def build_editable(folder: str, config_settings: Any = None, metadata_directory: str | None = None) -> str:
    """Compile the solver in the source tree, and build a wheel that points to it."""
    _compiled()
    return str(hatchling.build.build_editable(folder, config_settings, metadata_directory))


class SolverHook(BuildHookInterface):  # type: ignore[misc]
    """Puts the library into the wheel, and names the wheel by its platform."""

    PLUGIN_NAME = "custom"

    def initialize(self, version: str, build_data: dict[str, Any]) -> None:
        """Add what was compiled, if anything was."""
        if self.target_name == "wheel" and version == "standard" and LIBRARY.is_file():
            platform = sysconfig.get_platform().replace("-", "_").replace(".", "_")
            build_data["pure_python"] = False
            build_data["tag"] = f"py3-none-{platform}"
            build_data["artifacts"].append(f"src/vibro/core/{LIBRARY.name}")
