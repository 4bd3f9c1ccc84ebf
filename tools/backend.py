"""Build backend: hatchling, and before it the solver's library, by any C compiler that can be had.

Where the system has no compiler pip is asked for one that comes as a package. Where neither works the package
is built all the same: its solver then runs as plain Python, and ``vibro --version`` says so.
"""

from __future__ import annotations

import contextlib
import shutil
import sys
import tempfile
from pathlib import Path
from typing import Any

import hatchling.build
from hatchling.build import build_sdist, get_requires_for_build_sdist
from hatchling.builders.hooks.plugin.interface import BuildHookInterface

sys.path.insert(0, str(Path(__file__).parent))

from compiling import CORE, LIBRARY, SCRIPT, compile_solver, platform_tag, required

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


def _compile(checkout: Path) -> None:
    if why := compile_solver(checkout):
        print(f"vibro's solver could not be compiled, without which it is slow: {why}", file=sys.stderr)


def build_wheel(folder: str, config_settings: Any = None, metadata_directory: str | None = None) -> str:
    """Build a wheel for this platform and any version of Python; without a compiler for any platform.

    Programs may be running from the checkout, and people changing it meanwhile. So it is built from a copy:
    nothing in the checkout changes, and the library in the wheel is of the source in it.
    """
    wheels = str(Path(folder).absolute())
    with tempfile.TemporaryDirectory() as copy:
        for path in Path().iterdir():
            if path.is_file():
                shutil.copy(path, copy)
        for name in ("src", "tools"):
            shutil.copytree(
                name,
                Path(copy, name),
                ignore=shutil.ignore_patterns("__pycache__", f"{LIBRARY}*", f"{SCRIPT}*"),
            )
        _compile(Path(copy))
        with contextlib.chdir(copy):
            return str(hatchling.build.build_wheel(wheels, config_settings, metadata_directory))


def build_editable(folder: str, config_settings: Any = None, metadata_directory: str | None = None) -> str:
    """Compile the solver in the source tree, and build a wheel that points to it."""
    _compile(Path())
    return str(hatchling.build.build_editable(folder, config_settings, metadata_directory))


class SolverHook(BuildHookInterface):  # type: ignore[misc]
    """Puts the script and the library into the wheel, which is named by the platform of the library."""

    PLUGIN_NAME = "custom"

    def initialize(self, version: str, build_data: dict[str, Any]) -> None:
        """Add the script, and what was compiled, if anything was."""
        if self.target_name != "wheel" or version != "standard":
            return
        build_data["artifacts"].append((CORE / SCRIPT).as_posix())
        library = CORE / LIBRARY
        if Path(self.root, library).is_file():
            build_data["pure_python"] = False
            build_data["tag"] = f"py3-none-{platform_tag()}"
            build_data["artifacts"].append(library.as_posix())
