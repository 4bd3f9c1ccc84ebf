"""Compile the solver beside its source, by any C compiler that can be had: ``python tools/compiling.py``.

A system compiler is taken where there is one, otherwise the one of the package ``ziglang``. Set ``CC`` to
choose the compiler, ``VIBRO_CC=none`` to leave the solver uncompiled.
"""

from __future__ import annotations

import importlib.util
import os
import shlex
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))

from translate import translate

__all__ = ["LIBRARY", "compile_solver", "required"]

_CORE = Path(__file__).parent.parent / "src" / "vibro" / "core"
LIBRARY = _CORE / "_solver.native"  # no name that Python would import
# No fast arithmetic and no fused multiplications: the same bits as in Python, on any processor.
_FLAGS = ["-O3", "-ffp-contract=off", "-fno-math-errno", "-shared", "-s", "-fvisibility=hidden"]
_COMPILER_PACKAGE = "ziglang>=0.13"


def _system_compiler() -> list[str] | None:
    named = os.environ.get("CC")
    if named:
        return shlex.split(named)
    return next(([found] for name in ("cc", "gcc", "clang") if (found := shutil.which(name))), None)


def _compiler() -> list[str] | None:
    """Command of a C compiler; None where there is none, or none is wanted."""
    if os.environ.get("VIBRO_CC") == "none":
        return None
    if found := _system_compiler():
        return found
    return [sys.executable, "-m", "ziglang", "cc"] if importlib.util.find_spec("ziglang") else None


def required() -> list[str]:
    """List the packages that bring a compiler, where one is wanted and the system has none."""
    wanted = os.environ.get("VIBRO_CC") != "none" and not _system_compiler()
    return [_COMPILER_PACKAGE] if wanted else []


def compile_solver() -> str:
    """Compile the solver beside its source; return why that was not possible, or nothing.

    What an earlier build has left is removed first: a library of another source would be refused.
    """
    LIBRARY.unlink(missing_ok=True)
    compiler = _compiler()
    if compiler is None:
        return "no C compiler was found"
    links = [] if sys.platform == "win32" else ["-fPIC", "-lm"]
    with tempfile.TemporaryDirectory() as folder:
        source, library = Path(folder, "solver.c"), Path(folder, LIBRARY.name)
        source.write_text(translate(_CORE), "utf-8")
        command = [*compiler, *_FLAGS, str(source), "-o", str(library), *links]
        try:
            done = subprocess.run(command, capture_output=True, text=True, errors="replace")
        except OSError as exc:
            return f"{compiler[0]} cannot be run: {exc}"
        if done.returncode or not library.is_file():
            return f"{shlex.join(command)} failed:\n{done.stderr[-2000:]}"
        shutil.copyfile(library, LIBRARY)
    return ""


if __name__ == "__main__":
    sys.exit(compile_solver() or 0)
