"""What the package offers, and that asking for it is all that loads anything."""

from __future__ import annotations

import ast
import itertools
import pkgutil
import re
import subprocess
import sys
import tomllib
from pathlib import Path

import vibro

NUT = Path(__file__).parents[1] / "examples" / "safety_nut.toml"
HEAVY = ("numpy", "scipy", "pandas", "matplotlib", "typer", "rich")


# Every absolute import, wherever it stands, by its first part.
IMPORTED = re.compile(
    r"^ *(?:from (\w+)[\w.]* import |import (\w+)[\w.]*(?: as \w+)? *(?:#.*)?$)", re.MULTILINE
)


def test_every_library_that_is_imported_is_declared() -> None:
    project = tomllib.loads((NUT.parents[1] / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    extras = project["optional-dependencies"]
    users = [extra for name, extra in extras.items() if name not in ("test", "lint", "docs")]
    lines = itertools.chain(project["dependencies"], *users)
    declared = {re.split(r"[>=\[]", line)[0].lower() for line in lines}
    sources = (path.read_text(encoding="utf-8") for path in (NUT.parents[1] / "src").rglob("*.py"))
    imported = {one or other for source in sources for one, other in IMPORTED.findall(source)}
    assert imported - sys.stdlib_module_names - {"vibro"} == declared - {"gmpy2", "h5netcdf", "h5py"}


def test_solving_loads_no_library_for_tables_pictures_or_the_command_line() -> None:
    scene = "amplitude=1e-3, frequency=15, drive_angle=0.35, static_friction=0.74, kinetic_friction=0.57"
    code = f"""
import sys, vibro
print(*(name for name in {HEAVY} if name in sys.modules))
vibro.solve(vibro.Scene({scene}))
print(*(name for name in {HEAVY} if name in sys.modules))
"""
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, encoding="utf-8", check=True)
    assert done.stdout == "\nnumpy\n"


def test_every_public_name_is_listed_where_it_lives_and_hidden_by_no_submodule() -> None:
    """Once imported, a submodule is an attribute of the package: no public name may be the same."""
    assert {module.name for module in pkgutil.iter_modules(vibro.__path__)}.isdisjoint(vibro.__all__)
    for name in vibro.__all__:
        assert getattr(vibro, name).__name__ == name
        assert name in dir(vibro)
    seen = re.findall(r"    from (\S+) import (\w+) as \2\n", Path(vibro.__file__).read_text("utf-8"))
    assert {name: home for home, name in seen} == vibro._HOMES  # what type checkers see
    assert not hasattr(vibro, "conveyor")


def test_the_engines_of_the_tests_share_nothing_with_the_package() -> None:
    engines = sorted((Path(__file__).parent / "engines").glob("*.py"))
    assert len(engines) > 8
    for path in engines:
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.ImportFrom):
                assert (node.module or "").partition(".")[0] != "vibro", path
            elif isinstance(node, ast.Import):
                assert all(alias.name.partition(".")[0] != "vibro" for alias in node.names), path


def test_no_two_files_import_each_other() -> None:
    """Not even for types, late, or by way of others, which import-linter leaves out."""
    source = NUT.parents[1] / "src"
    paths = {
        ".".join(path.relative_to(source).with_suffix("").parts).removesuffix(".__init__"): path
        for path in source.rglob("*.py")
    }
    left: dict[str, set[str]] = {}
    for name, path in paths.items():
        nodes = [
            node for node in ast.walk(ast.parse(path.read_text("utf-8"))) if isinstance(node, ast.ImportFrom)
        ]
        taken = [(node.module or "", f"{node.module}.{alias.name}") for node in nodes for alias in node.names]
        left[name] = ({one if one in paths else module for module, one in taken} & paths.keys()) - {name}
    del left["vibro"]
    while free := {name for name, imported in left.items() if not imported & left.keys()}:
        left = {name: imported for name, imported in left.items() if name not in free}
    assert not left


def test_submodules_leave_public_names_alone() -> None:
    code = (
        "import importlib, pkgutil, vibro; listed = {n: getattr(vibro, n) for n in vibro.__all__};"
        " [importlib.import_module(m.name) for m in pkgutil.walk_packages(vibro.__path__, 'vibro.')"
        " if not m.name.endswith('__main__')];"
        " assert all(getattr(vibro, n) is value for n, value in listed.items())"
    )
    subprocess.run([sys.executable, "-c", code], check=True)
