"""What the package offers, and that asking for it is all that loads anything."""

from __future__ import annotations

import subprocess
import sys

import pytest

import vibro

HEAVY = ("numpy", "scipy", "pandas", "matplotlib", "typer", "rich")


def _loaded_after(statement: str) -> set[str]:
    code = f"import sys; {statement}; print(*(name for name in {HEAVY} if name in sys.modules))"
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, encoding="utf-8", check=True
    )
    return set(done.stdout.split())


def test_the_package_alone_loads_no_library() -> None:
    assert _loaded_after("import vibro") == set()


def test_solving_loads_no_library_for_tables_pictures_or_the_command_line() -> None:
    scene = "amplitude=1e-3, frequency=15, drive_angle=0.35, static_friction=0.74, kinetic_friction=0.57"
    assert _loaded_after(f"import vibro; vibro.solve(vibro.Scene({scene}))") == {"numpy"}


def test_every_public_name_can_be_had_and_listed() -> None:
    for name in vibro.__all__:
        assert getattr(vibro, name).__name__ == name
        assert name in dir(vibro)


def test_a_name_that_does_not_exist_is_an_attribute_error() -> None:
    with pytest.raises(AttributeError, match="module 'vibro' has no attribute 'conveyor'"):
        _ = vibro.conveyor
