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

import pytest
from helpers.plans import store

import vibro

NUT = Path(__file__).parents[1] / "examples" / "safety_nut.toml"
RECORD = NUT.parent / "data" / "nut_trough_mv.csv"
HEAVY = ("numpy", "scipy", "pandas", "matplotlib", "typer", "rich")


def _loaded_after(statement: str) -> set[str]:
    code = f"import sys; {statement}; print(*(name for name in {HEAVY} if name in sys.modules))"
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, encoding="utf-8", check=True
    )
    return set(done.stdout.split())


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


def test_the_package_alone_loads_no_library() -> None:
    assert _loaded_after("import vibro") == set()


def test_solving_loads_no_library_for_tables_pictures_or_the_command_line() -> None:
    scene = "amplitude=1e-3, frequency=15, drive_angle=0.35, static_friction=0.74, kinetic_friction=0.57"
    assert _loaded_after(f"import vibro; vibro.solve(vibro.Scene({scene}))") == {"numpy"}


_MEASURED = (
    f"vibro.measured_motion({str(RECORD)!r}, trough_along='Trog längs', sensitivity='1V/g', drive_angle=0)"
)

_OPERATED = (
    "vibro.operate(vibro.Machine.crank(radius=1e-3), frequency=15, drive_angle=0.3, static_friction=0.5,"
    " kinetic_friction=0.4)"
)

_TIMED = (
    "vibro.fit_speeds({'amplitude_mm': [1], 'mean_velocity_mm_s': [16]}, frequency_hz=15, drive_angle_deg=20)"
)

# What each public name gives when it is called as its documentation says.
CALLS = {
    "Attractor": "isinstance(vibro.attractors(scene)[0], vibro.Attractor)",
    "Attractors": "isinstance(vibro.attractors(scene), vibro.Attractors)",
    "Calibration": "vibro.Calibration(1e-3, 50.0).setting == 1.0",
    "Certificate": "vibro.guarantee(scene, drive_angle=(0, 1)).certificate_min._fields[2] == 'bound'",
    "DesignResult": "vibro.DesignResult(True, (), ()).met",
    "FileError": "issubclass(vibro.FileError, vibro.VibroError)",
    "Filling": "isinstance(vibro.filling(scene), vibro.Filling)",
    "InputError": "issubclass(vibro.InputError, vibro.VibroError)",
    "Guarantee": "isinstance(vibro.guarantee(scene), vibro.Guarantee)",
    "Interval": "isinstance(vibro.feasible_amplitudes(scene, 0.02)[0], vibro.Interval)",
    "History": "vibro.simulate(scene, cycles=1).__class__ is vibro.History",
    "Machine": "vibro.Machine.crank(radius=1e-3).kind == 'crank'",
    "MeasuredMotion": f"isinstance({_MEASURED}, vibro.MeasuredMotion)",
    "Motion": "isinstance(vibro.Motion.steps([(0.5, 1.0), (0.5, -1.0)]), vibro.Motion)",
    "OperatingPoints": f"isinstance({_OPERATED}, vibro.OperatingPoints)",
    "Page": "vibro.page(scene).__class__ is vibro.Page",
    "Regime": "vibro.Regime(0).label == 'no-slip'",
    "Scene": "scene.shape == ()",
    "SceneError": "issubclass(vibro.SceneError, vibro.VibroError)",
    "Status": "vibro.Status(0).label == 'ok'",
    "SpeedFit": f"isinstance({_TIMED}, vibro.SpeedFit)",
    "SteadyCycle": "isinstance(vibro.solve(scene), vibro.SteadyCycle)",
    "VibroError": "issubclass(vibro.VibroError, Exception)",
    "arrival_time": "vibro.arrival_time(scene, 0.1) > 0",
    "attractors": "vibro.attractors(scene)[0].pattern == 'F_'",
    "critical_friction": "1 < vibro.critical_friction(scene).forward < 2",
    "critical_loads": "vibro.critical_loads(scene).hop > 1",
    "design": "len(vibro.design(question, only='goal').designs) == 3",
    "feasible_amplitudes": "len(vibro.feasible_amplitudes(scene, 0.02)) == 1",
    "filling": "0.5 < vibro.filling(scene).added_mass_share < 1.0",
    "fit_speeds": f"len({_TIMED}.parameters) == 1",
    "friction_for_speed": "len(vibro.friction_for_speed(scene, 0.01).solutions) == 2",
    "guarantee": "vibro.guarantee(scene).speed_min == vibro.solve(scene).mean_velocity",
    "measured_motion": f"{_MEASURED}.order == 1",
    "open_sweep": "vibro.open_sweep(stored).shape == (2,)",
    "operate": f"{_OPERATED}.number == 1",
    "operating_points": f"len({_OPERATED.replace('operate', 'operating_points')}) == 1",
    "page": "vibro.page(nut).html.startswith('<!doctype html>')",
    "read_scene": "vibro.read_scene(nut).shape == ()",
    "simulate": "vibro.simulate(scene, cycles=1).end > 0",
    "solve": "vibro.solve(scene).pattern == 'F_'",
    "sweep": "vibro.sweep(nut, frequency_hz=15).shape == (200,)",
    "transitions": "len(vibro.transitions(scene)) == 4",
    "trough_motion": f"isinstance({_MEASURED.replace('measured_motion', 'trough_motion')}, vibro.Motion)",
    "write_sweep": "vibro.write_sweep(f'{stored}2', nut, amplitude_mm=[1, 2], frequency_hz=15).shape == (2,)",
    "yield_share": "vibro.yield_share(scene, 0.01, highest_regime='back-slip')[0] == 1.0",
}


def test_public_names_do_what_is_said_of_them(tmp_path: Path) -> None:
    assert set(CALLS) == set(vibro.__all__)
    scene = vibro.Scene(
        amplitude=1e-3, frequency=15, drive_angle=0.35, static_friction=0.74, kinetic_friction=0.57
    )
    stored = store(vibro.sweep(NUT, amplitude_mm=[1, 2], frequency_hz=15), tmp_path / "stored")
    drive = {"amplitude_mm": 1, "frequency_hz": 15, "drive_angle_deg": 20}
    friction = {"static_friction": 0.74, "kinetic_friction": 0.57}
    question = {"scene": friction, "drive": [drive], "goal": {"speed_mm_s": 10}}
    known = {"vibro": vibro, "scene": scene, "nut": str(NUT), "stored": str(stored), "question": question}
    for name, call in CALLS.items():
        assert eval(call, known), name


def test_no_submodule_hides_a_public_name() -> None:
    """Once imported, a submodule is an attribute of the package: no public name may be the same."""
    assert {module.name for module in pkgutil.iter_modules(vibro.__path__)}.isdisjoint(vibro.__all__)


def test_every_public_name_can_be_had_and_listed() -> None:
    for name in vibro.__all__:
        assert getattr(vibro, name).__name__ == name
        assert name in dir(vibro)


def test_type_checkers_see_every_public_name_where_it_lives() -> None:
    seen = re.findall(r"    from (\S+) import (\w+) as \2\n", Path(vibro.__file__).read_text("utf-8"))
    assert {name: home for home, name in seen} == vibro._HOMES


def test_a_name_that_does_not_exist_is_an_attribute_error() -> None:
    with pytest.raises(AttributeError, match="module 'vibro' has no attribute 'conveyor'"):
        _ = vibro.conveyor


def test_the_engines_of_the_tests_share_nothing_with_the_package() -> None:
    engines = sorted((Path(__file__).parent / "engines").glob("*.py"))
    assert len(engines) > 8
    for path in engines:
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.ImportFrom):
                assert (node.module or "").partition(".")[0] != "vibro", path
            elif isinstance(node, ast.Import):
                assert all(alias.name.partition(".")[0] != "vibro" for alias in node.names), path


def _imports() -> dict[str, dict[str, bool]]:
    """Return which modules of the package each imports, late ones too, and whether for more than types."""
    source = NUT.parents[1] / "src"
    paths = {
        ".".join(path.relative_to(source).with_suffix("").parts).removesuffix(".__init__"): path
        for path in source.rglob("*.py")
    }
    found: dict[str, dict[str, bool]] = {name: {} for name in paths}

    def visit(node: ast.AST, name: str, counts: bool) -> None:
        if isinstance(node, ast.ImportFrom) and node.module in paths:
            for alias in node.names:
                one = f"{node.module}.{alias.name}"
                one = one if one in paths else node.module
                found[name][one] = found[name].get(one, False) or counts
        for child in ast.iter_child_nodes(node):
            for_types = isinstance(node, ast.If) and ast.unparse(node.test) == "TYPE_CHECKING"
            visit(child, name, counts and not for_types)

    for name, path in paths.items():
        visit(ast.parse(path.read_text(encoding="utf-8")), name, counts=True)
    return found


def test_no_import_runs_back_up() -> None:
    contracts = tomllib.loads((NUT.parents[1] / "pyproject.toml").read_text(encoding="utf-8"))
    layers = contracts["tool"]["importlinter"]["contracts"][0]["layers"]
    height = {room: -i for i, layer in enumerate(layers) for room in layer.split(" : ")}
    back = [
        (name, other)
        for name, imported in _imports().items()
        for other, counts in imported.items()
        if counts and "." in name and "." in other
        if height[name.split(".")[1]] < height[other.split(".")[1]]
    ]
    assert not back


def test_no_two_files_import_each_other() -> None:
    """Not even for types, and not by way of others."""
    left = {name: set(imported) - {name} for name, imported in _imports().items() if name != "vibro"}
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
