"""The theory and the reference say what the code says: equation numbers, code names, CSV columns."""

from __future__ import annotations

import doctest
import re
from dataclasses import fields, is_dataclass
from importlib import import_module
from pathlib import Path
from typing import Any

import pytest
from key_tables import PAGES as KEY_PAGES
from key_tables import page_with as page_with_keys
from nomenclature import PAGES as REFERENCE_PAGES
from nomenclature import REFERENCE, page_with
from PIL import Image

import vibro
from vibro.quantities import QUANTITIES
from vibro.results.steady import RESULTS
from vibro.sweeps.columns import columns_of
from vibro.sweeps.derived import (
    WITH_ACCELERATION,
    WITH_ARRIVAL,
    WITH_EXPONENT,
    WITH_LENGTH,
    WITH_STROKE,
    WITH_STROKES,
    standing,
    throughput,
)
from vibro.sweeps.whole import Sweep
from vibro.tables.stored import StoredSweep

ROOT = Path(__file__).parent.parent
CHAPTERS = sorted((ROOT / "docs" / "theory").glob("[0-9]*.md"))
THEORY = "\n".join(path.read_text(encoding="utf-8") for path in CHAPTERS)
COLUMNS, SYMBOLS = ((REFERENCE / name).read_text(encoding="utf-8") for name in ("columns.md", "symbols.md"))
MODULES = sorted((ROOT / "src" / "vibro").rglob("*.py"))

# "Eq. (7)", "Eqs. (4) and (5)", "Eqs. (3)-(6)"; a citation may continue on the next line of a comment
CITATION = re.compile(r"\bEqs?\.[\s#]+\(\d+\)(?:(?:-|,|[\s#]+and)?[\s#]*\(\d+\))*")
RANGE = re.compile(r"\((\d+)\)(?:-\((\d+)\))?")
SECTION = re.compile(r"theory,[\s#]+section (\d+)")


def cited(text: str) -> set[int]:
    """Numbers of all equations that a text cites, those inside ranges too."""
    numbers: set[int] = set()
    for citation in CITATION.findall(text):
        for first, last in RANGE.findall(citation):
            numbers.update(range(int(first), int(last or first) + 1))
    return numbers


def rows(page: str) -> list[list[str]]:
    """Cells of every table of a page that names code: not of designs and fillings, nor of others' words."""
    text = re.sub(r"## (Designs|A filling|What others).*?(?=\n## |\Z)", "", page, flags=re.DOTALL)
    lines = [line for line in text.splitlines() if line.startswith(("| `", "| $", "| -"))]
    return [[cell.strip() for cell in line.strip("|").split("|")] for line in lines]


def listed() -> list[str]:
    """Names of columns and of code that the reference lists; those of code have a dot."""
    cells = [row[0] for row in rows(COLUMNS)] + [row[1] for row in rows(SYMBOLS)]
    return [name for cell in cells for name in re.findall(r"`([^`]+)`", cell)]


def resolve(name: str) -> None:
    """Find a dotted name in the package, or a field of a dataclass; raise if there is none."""
    found: Any = vibro
    module = "vibro"
    for part in name.split("."):
        if is_dataclass(found) and part in {field.name for field in fields(found)}:
            return
        module += f".{part}"
        found = getattr(found, part) if hasattr(found, part) else import_module(module)


def test_equations_are_numbered_once_and_none_is_missing() -> None:
    numbers = [int(n) for n in re.findall(r"\\tag\{(\d+)\}", THEORY)]
    assert len(numbers) >= 22
    # an equation keeps its number when it moves, so that they do not ascend
    assert sorted(numbers) == list(range(1, len(numbers) + 1))


def test_every_equation_and_section_that_the_code_cites_exists() -> None:
    equations = {int(n) for n in re.findall(r"\\tag\{(\d+)\}", THEORY)}
    sections = set(re.findall(r"^# (\d+)\.", THEORY, flags=re.MULTILINE))
    seen: set[int] = set()
    for module in MODULES:
        text = module.read_text(encoding="utf-8")
        assert cited(text) <= equations, module
        assert set(SECTION.findall(text)) <= sections, module
        seen |= cited(text) if "core" in module.parts else set()
    assert len(seen) >= 15


METHODS = (Sweep.to_xarray, StoredSweep.to_xarray, vibro.History.to_frame)
FUNCTIONS = [vibro.Scene, *(getattr(vibro, name) for name in vibro.__all__ if name[0].islower()), *METHODS]


@pytest.mark.parametrize("example", FUNCTIONS, ids=lambda example: example.__qualname__)
def test_the_examples_of_public_names_run(example: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(ROOT)
    (test,) = doctest.DocTestFinder(recurse=False).find(example, example.__qualname__)
    assert test.examples
    assert doctest.DocTestRunner().run(test).failed == 0


def test_every_code_name_exists_and_is_listed_once() -> None:
    names = [name for name in listed() if "." in name]
    assert len(names) > 40
    assert len(set(names)) == len(names)
    for name in names:
        resolve(name)


def test_columns_are_those_of_the_tables() -> None:
    names = [name for name in listed() if "." not in name]
    assert len(set(names)) == len(names)
    extra = (WITH_LENGTH, WITH_STROKE, WITH_ACCELERATION, WITH_EXPONENT, WITH_ARRIVAL, WITH_STROKES)
    every = columns_of(
        QUANTITIES, *extra, *throughput({"pitch_mm": 25.0, "mass_kg": 0.1}), *standing(1.0), machine=True
    )
    assert {column.name for column in every} <= set(names)


def test_tables_of_the_reference_are_what_the_code_says() -> None:
    written = {
        name: (REFERENCE / name).read_text(encoding="utf-8") for name in (*REFERENCE_PAGES, *KEY_PAGES)
    }
    for name in REFERENCE_PAGES:
        assert page_with(name) == written[name], "python docs/ext/nomenclature.py writes them"
    for name in KEY_PAGES:
        assert page_with_keys(name) == written[name], "python docs/ext/key_tables.py writes them"


def test_all_fields_of_scenes_and_results_are_listed() -> None:
    assert {f"Scene.{name}" in listed() for name in vibro.Scene.__dataclass_fields__} == {True}
    described = {result.name for result in RESULTS}
    assert described | {"long_patterns"} == {field.name for field in fields(vibro.SteadyCycle)}


def test_pictures_of_the_docs_name_no_folder_of_a_machine() -> None:
    """They carry the command that made them: from the project's folder, with relative paths."""
    folder = re.compile(r"(^|[\s\"'=])(/|[A-Z]:)[\w.-]+/")
    for path in (ROOT / "docs" / "images").glob("*.png"):
        with Image.open(path) as image:
            told = {str(key): str(value) for key, value in image.info.items()}
        assert not [(key, text) for key, text in told.items() if folder.search(text)], path
