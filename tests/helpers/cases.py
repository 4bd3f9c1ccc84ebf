"""Many cheap cases in one test, which names all that fail."""

from __future__ import annotations

import functools
import inspect
from collections.abc import Callable, Iterable
from typing import Any, Final

import pytest

Test = Callable[..., None]

_LONGEST: Final = 400  # characters of a case that are shown


def each(names: str | tuple[str, ...], cases: Iterable[Any]) -> Callable[[Test], Test]:
    """Run a test with every case, as ``pytest.mark.parametrize`` would, but as one test.

    For cases so cheap that a test of its own would cost more than the case: wrong values, spellings. All run,
    with the same fixtures; the failure holds the error of each that fails, with its arguments.
    """
    arguments = [
        {names: case} if isinstance(names, str) else dict(zip(names, case, strict=True)) for case in cases
    ]
    assert arguments

    def decorate(test: Test) -> Test:
        @functools.wraps(test)
        def run_all(*fixtures: Any, **more: Any) -> None:
            failures: list[BaseException] = []
            for given in arguments:
                try:
                    test(*fixtures, **more, **given)
                except (Exception, BaseExceptionGroup, pytest.fail.Exception) as exc:
                    exc.add_note(f"with {given}"[:_LONGEST])
                    failures.append(exc)
            if failures:
                raise BaseExceptionGroup(f"{len(failures)} of {len(arguments)} cases fail", failures)

        signature = inspect.signature(test)
        fixtures = [p for name, p in signature.parameters.items() if name not in arguments[0]]
        run_all.__signature__ = signature.replace(parameters=fixtures)  # type: ignore[attr-defined]
        return run_all

    return decorate
