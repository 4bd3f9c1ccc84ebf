"""Building: of the source that it packs, and unnoticed by programs that run from the checkout."""

from __future__ import annotations

import ctypes
import importlib
import importlib.util
import os
import shutil
import sys
import sysconfig
from itertools import accumulate
from pathlib import Path
from types import ModuleType
from typing import TYPE_CHECKING, Any

import compiling
import pytest
import translate
from compiling import CORE, LIBRARY, SCRIPT, compile_solver, required

if TYPE_CHECKING:
    from collections.abc import Callable

ROOT = Path(__file__).parents[1]
has_compiler = any(map(shutil.which, ("cc", "gcc", "clang")))


# A solver of two modules, which is soon compiled.
SMALL = """
from vibro.core.numbers import wrap

def turned(angle: float) -> float:
    return wrap(angle + 1.0)

DOORS: Final = (turned,)
"""


@pytest.fixture
def checkout(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Copy the checkout with a small solver, no library, no compiler by name; only the digest goes to C."""
    monkeypatch.setattr(compiling, "translate", lambda core, *_: translate.digest(translate.sources(core)))
    monkeypatch.delenv("CC", raising=False)
    monkeypatch.delenv("VIBRO_CC", raising=False)
    copy = tmp_path / "checkout"
    for name in ("src", "tools"):
        shutil.copytree(ROOT / name, copy / name, ignore=shutil.ignore_patterns("__pycache__", LIBRARY))
    shutil.copy(ROOT / "pyproject.toml", copy)
    (copy / CORE / "loop.py").write_text(SMALL, encoding="utf-8")
    return copy


@pytest.fixture
def compiler(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Callable[[str], None]:
    """Give statements that serve as the compiler, which know the paths ``source`` and ``out``."""

    def set_compiler(statements: str) -> None:
        path = tmp_path / "compiler.py"
        head = "import sys, time\nfrom pathlib import Path\n"
        head += "at = sys.argv.index('-o')\nsource, out = (Path(sys.argv[i]) for i in (at - 1, at + 1))\n"
        path.write_text(head + statements, encoding="utf-8")
        monkeypatch.setenv("CC", f"{sys.executable} {path}")

    return set_compiler


def known(checkout: Path) -> str:
    return translate.digest(translate.sources(checkout / CORE))


def beside(library: Path) -> list[Path]:
    return sorted(library.parent.glob(f"{LIBRARY}*"))


@pytest.mark.skipif(not has_compiler, reason="there is no C compiler (cc, gcc, clang)")
def test_a_compiler_of_the_system_is_taken(checkout: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """And writes no byte of the library that programs run."""
    monkeypatch.setattr(compiling, "translate", translate.translate)
    assert required() == []
    (checkout / CORE / LIBRARY).write_text(known(checkout), encoding="utf-8")
    os.link(checkout / CORE / LIBRARY, checkout / "in use")
    assert compile_solver(checkout) == ""
    assert (checkout / "in use").read_text(encoding="utf-8") == known(checkout)
    library = ctypes.CDLL(str(checkout / CORE / LIBRARY))
    library.vibro_sources.restype = ctypes.c_char_p
    assert library.vibro_sources().decode().split("\n") == [known(checkout), "loop.py", "numbers.py"]


def test_where_there_is_no_compiler_one_is_required_if_it_is_wanted(
    checkout: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(shutil, "which", lambda name: None)
    monkeypatch.setattr(importlib.util, "find_spec", lambda name: None)
    assert required() == ["ziglang>=0.13"]
    assert compile_solver(checkout) == "no C compiler was found"
    monkeypatch.setenv("VIBRO_CC", "none")
    assert required() == []


FAILS = [f"{sys.executable} -c 'raise SystemExit(7)'", f"{sys.executable} -c ''", "no-such-compiler"]


@pytest.mark.parametrize("command", FAILS, ids=["ends with 7", "makes nothing", "is none"])
def test_a_compiler_that_fails_leaves_no_library_of_another_source(
    checkout: Path, monkeypatch: pytest.MonkeyPatch, command: str
) -> None:
    library = checkout / CORE / LIBRARY
    monkeypatch.setenv("CC", command)
    if command != FAILS[0]:
        library.write_text(f"of another source: {'0' * 64}", encoding="utf-8")
    said = compile_solver(checkout)
    assert " failed:" in said or "no-such-compiler cannot be run" in said
    assert "stays" not in said
    assert beside(library) == []
    library.write_text(known(checkout), encoding="utf-8")
    assert compile_solver(checkout).endswith("\nThe library that is there is of this source, and stays")
    assert library.read_text(encoding="utf-8") == known(checkout)
    monkeypatch.setenv("VIBRO_CC", "none")
    assert compile_solver(checkout) == "no C compiler was found"
    assert beside(library) == []


@pytest.mark.parametrize("step", ["replace", "unlink"])
def test_a_library_that_the_system_does_not_let_go_is_told(
    checkout: Path, compiler: Callable[[str], None], monkeypatch: pytest.MonkeyPatch, step: str
) -> None:
    """As Windows does while a program has loaded it."""
    library = checkout / CORE / LIBRARY
    library.write_text(known(checkout) if step == "replace" else "of another source", encoding="utf-8")
    before, acts = library.read_text(encoding="utf-8"), getattr(Path, step)

    def refuse(path: Path, *args: Any, **more: Any) -> None:
        if library in (path, *args):
            raise PermissionError(13, "Access is denied")
        acts(path, *args, **more)

    monkeypatch.setattr(Path, step, refuse)
    compiler("out.write_bytes(source.read_bytes())")
    said = f"Access is denied: {library} cannot be replaced; end the programs that run it, and try again"
    assert compile_solver(checkout) == said
    assert library.read_text(encoding="utf-8") == before
    assert beside(library) == [library]


class Hatchling(ModuleType):
    """Stands for hatchling: notes what it is asked to build, and in what state."""

    def __init__(self) -> None:
        super().__init__("hatchling.build")
        self.built: list[tuple[str, Path, bool]] = []

    def _build(self, folder: str, *_: object) -> str:
        library = Path(CORE, LIBRARY)
        is_whole = library.is_file() and known(Path()) in library.read_text(encoding="utf-8")
        self.built.append((folder, Path.cwd(), is_whole))
        return "vibro.whl"

    build_wheel = build_editable = build_sdist = _build

    @staticmethod
    def get_requires_for_build_wheel(*_: object) -> list[str]:
        return []

    get_requires_for_build_editable = get_requires_for_build_sdist = get_requires_for_build_wheel


@pytest.fixture
def hatchling(monkeypatch: pytest.MonkeyPatch, checkout: Path) -> Hatchling:
    made = Hatchling()
    for name in accumulate(("hatchling", "builders", "hooks", "plugin"), "{}.{}".format):
        monkeypatch.setitem(sys.modules, name, ModuleType(name))
    interface = ModuleType("hatchling.builders.hooks.plugin.interface")
    monkeypatch.setattr(interface, "BuildHookInterface", object, raising=False)
    monkeypatch.setitem(sys.modules, interface.__name__, interface)
    monkeypatch.setitem(sys.modules, made.__name__, made)
    monkeypatch.setattr(sys.modules["hatchling"], "build", made, raising=False)
    monkeypatch.delitem(sys.modules, "backend", raising=False)
    monkeypatch.chdir(checkout)
    return made


def test_a_wheel_is_built_from_a_copy_and_its_library_is_of_its_source(
    checkout: Path, compiler: Callable[[str], None], hatchling: Hatchling, tmp_path: Path
) -> None:
    source = checkout / CORE / "numbers.py"
    compiler(f"Path({str(source)!r}).open('a').write('# changed')\nout.write_bytes(source.read_bytes())")
    (checkout / CORE / LIBRARY).write_text("in use", encoding="utf-8")
    before = (checkout / CORE / LIBRARY).stat()
    backend = importlib.import_module("backend")
    assert backend.build_wheel("wheels") == "vibro.whl"
    [(folder, place, is_whole)] = hatchling.built
    assert folder == str(checkout / "wheels")
    assert is_whole
    assert place != checkout
    assert not place.exists()
    assert Path.cwd() == checkout
    assert (checkout / CORE / LIBRARY).stat() == before
    assert source.read_text(encoding="utf-8").endswith("# changed")
    compiler("out.write_bytes(source.read_bytes())")
    assert backend.build_editable("wheels") == "vibro.whl"  # compiled in place
    assert hatchling.built[1] == ("wheels", checkout, True)


@pytest.mark.parametrize("platform", ["", "win_amd64"])
@pytest.mark.parametrize("compiled", [True, False])
def test_a_wheel_with_a_library_is_of_a_platform(
    checkout: Path, hatchling: Hatchling, monkeypatch: pytest.MonkeyPatch, compiled: bool, platform: str
) -> None:
    monkeypatch.setenv("VIBRO_PLATFORM", platform)
    if compiled:
        (checkout / CORE / LIBRARY).touch()
    hook = importlib.import_module("backend").SolverHook()
    hook.root, hook.target_name = str(checkout), "wheel"
    editable: dict[str, Any] = {"artifacts": []}
    hook.initialize("editable", editable)
    assert editable == {"artifacts": []}
    data: dict[str, Any] = {"artifacts": []}
    hook.initialize("standard", data)
    assert data["artifacts"] == [f"{CORE.as_posix()}/{name}" for name in (SCRIPT, LIBRARY)[: 1 + compiled]]
    here = sysconfig.get_platform().replace("-", "_").replace(".", "_")
    assert data.get("tag") == (f"py3-none-{platform or here}" if compiled else None)
    assert data.get("pure_python", True) is not compiled
