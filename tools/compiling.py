"""Make the solver beside its source, ``python tools/compiling.py``: a script for pages, and a library.

The script is in JavaScript. The library needs a C compiler: that of the system is taken where there is one,
otherwise the one of the package ``ziglang``. Set ``CC`` to choose the compiler, ``VIBRO_CC=none`` to leave
the solver uncompiled, ``VIBRO_PLATFORM`` to name the platform that a cross compiler in ``CC`` compiles for
(``win_amd64``).
"""

from __future__ import annotations

import importlib.util
import os
import shlex
import shutil
import subprocess
import sys
import sysconfig
import tempfile
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))

from dialects import JavaScript
from translate import digest, sources, translate

__all__ = ["CORE", "LIBRARY", "SCRIPT", "compile_solver", "platform_tag", "required"]

CORE = Path("src", "vibro", "core")  # in a checkout
LIBRARY = "_solver.native"  # no name that Python would import
SCRIPT = "_solver.js"
# No fast arithmetic and no fused multiplications: the same bits as in Python, on any processor.
_FLAGS = ["-O3", "-ffp-contract=off", "-fno-math-errno", "-shared", "-s", "-fvisibility=hidden"]
_COMPILER_PACKAGE = "ziglang>=0.13"


def _system_compiler() -> list[str] | None:
    named = os.environ.get("CC")
    if named:
        return shlex.split(named)
    return next(([found] for name in ("cc", "gcc", "clang") if (found := shutil.which(name))), None)


def _is_wanted() -> bool:
    return os.environ.get("VIBRO_CC") != "none"


def _compiler() -> list[str] | None:
    """Command of a C compiler; None where there is none, or none is wanted."""
    if not _is_wanted():
        return None
    if found := _system_compiler():
        return found
    return [sys.executable, "-m", "ziglang", "cc"] if importlib.util.find_spec("ziglang") else None


def platform_tag() -> str:
    """Name the platform that the library is for, as wheels do: this one unless another is named."""
    return os.environ.get("VIBRO_PLATFORM") or sysconfig.get_platform().replace("-", "_").replace(".", "_")


def required() -> list[str]:
    """List the packages that bring a compiler, where one is wanted and the system has none."""
    return [_COMPILER_PACKAGE] if _is_wanted() and not _system_compiler() else []


def compile_solver(checkout: Path) -> str:
    """Make the script, and compile the solver; return why that was not possible, or nothing.

    Programs may be running the library that is there. So it stays as it is until a new one, whole, takes its
    name, and where there is no new one. One of another source would be refused, and goes: without it they
    run the source.
    """
    core = checkout / CORE
    library = core / LIBRARY
    _put(core / SCRIPT, translate(core, JavaScript()).encode())
    try:
        if library.is_file() and not (_is_wanted() and _is_of(library, core)):
            library.unlink()
        why = _build(core, library)
    except PermissionError as exc:
        return f"{exc.strerror}: {library} cannot be replaced; end the programs that run it, and try again"
    if why and library.is_file():
        why += "\nThe library that is there is of this source, and stays"
    return why


def _put(path: Path, content: bytes) -> None:
    """Write a file that takes its name once it is whole."""
    waiting = path.with_name(f"{path.name}-{os.getpid()}")  # beside it: on one file system
    try:
        waiting.write_bytes(content)
        waiting.replace(path)
    finally:
        waiting.unlink(missing_ok=True)


def _is_of(library: Path, core: Path) -> bool:
    return digest(sources(core)).encode() in library.read_bytes()


def _build(core: Path, library: Path) -> str:
    compiler = _compiler()
    if compiler is None:
        return "no C compiler was found"
    links = [] if platform_tag().startswith("win") else ["-fPIC", "-lm"]
    with tempfile.TemporaryDirectory() as folder:
        source, built = Path(folder, "solver.c"), Path(folder, LIBRARY)
        source.write_text(translate(core), "utf-8")
        command = [*compiler, *_FLAGS, str(source), "-o", str(built), *links]
        try:
            done = subprocess.run(command, capture_output=True, text=True, errors="replace")
        except OSError as exc:
            return f"{compiler[0]} cannot be run: {exc}"
        if done.returncode or not built.is_file():
            return f"{shlex.join(command)} failed:\n{done.stderr[-2000:]}"
        _put(library, built.read_bytes())
    return ""


if __name__ == "__main__":
    sys.exit(compile_solver(Path(__file__).parents[1]) or 0)
