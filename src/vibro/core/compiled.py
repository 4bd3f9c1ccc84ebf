"""The solver's doors: compiled where the library was built with the package, else plain Python.

Both are one source and give the same bits. Set ``VIBRO_SOLVER=python`` to run it uncompiled, in a debugger
for instance.
"""

from __future__ import annotations

import ctypes
import hashlib
import os
import sys
import threading
from contextlib import contextmanager
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    from numpy.typing import NDArray


_FOLDER: Final = Path(__file__).parent


def library_path() -> Path | None:
    """Find the compiled library; None where there is none, or plain Python is wanted."""
    path = _FOLDER / "_solver.native"
    return path if path.is_file() and os.environ.get("VIBRO_SOLVER") != "python" else None


class _Rows(tuple[int, ...]):
    """Addresses of the rows of an array, which lives as long as they do."""

    array: NDArray[Any]


class _Asked(threading.local):
    """What compiled functions ask in a thread: questions, of which each raises if they shall end."""

    questions: tuple[Callable[[], object], ...] = ()


_asked: Final = _Asked()


@contextmanager
def asking(*questions: Callable[[], object]) -> Iterator[None]:
    """Have compiled functions of this thread ask further questions every 50 ms, and end if one raises.

    Signals are handled then too, in the main thread: without any question an interrupt is heard.
    """
    before = _asked.questions
    _asked.questions = (*before, *questions)
    try:
        yield
    finally:
        _asked.questions = before


def questions() -> tuple[Callable[[], object], ...]:
    """Return the questions of this thread, for those that share its work."""
    return _asked.questions


def _ask() -> None:
    for question in _asked.questions:
        question()


class Doors:
    """Functions of ``vibro.core.loop``, called by name with numbers, arrays and tuples of rows.

    Attributes
    ----------
    compiled : bool
        Whether they are compiled: then they hold no lock, and threads may share the work.
    """

    def __init__(self, library: ctypes.PyDLL | None) -> None:
        self._library, self.compiled = library, library is not None

    def __getattr__(self, name: str) -> Callable[..., Any]:
        function = _plain(name) if self._library is None else _foreign(self._library, name)
        setattr(self, name, function)
        return function

    def rows(self, array: NDArray[Any]) -> tuple[Any, ...]:
        """Hand over the rows of a 2-D array in C order as buffers, which keep the array alive."""
        if self._library is None:
            return tuple(map(self.row, array))
        start, step = array.ctypes.data, array.strides[0]
        rows = _Rows(range(start, start + step * len(array), step) if step else (start,) * len(array))
        rows.array = array
        return rows

    def row(self, array: NDArray[Any]) -> Any:
        """Hand over a contiguous array, which must outlive the call, as one buffer."""
        if self._library is None:
            return memoryview(array.reshape(-1))  # type: ignore[arg-type]
        if array.size and array.flags.writeable:  # in a quarter of the time of ``array.ctypes``
            return ctypes.addressof(ctypes.c_char.from_buffer(array))  # type: ignore[arg-type]
        return array.ctypes.data


def _flattened(values: tuple[Any, ...]) -> list[Any]:
    flat: list[Any] = []
    for value in values:
        if isinstance(value, tuple):
            flat += [x if isinstance(x, int | float) else x.ctypes.data for x in value]
        else:
            flat.append(value if isinstance(value, int | float) else value.ctypes.data)
    return flat


def _foreign(library: ctypes.PyDLL, name: str) -> Callable[..., int]:
    """Wrap an exported function; addresses go as whole numbers of 64 bits."""
    function = getattr(library, f"vibro_{name}")
    function.restype = ctypes.c_longlong

    def call(*values: Any) -> int:
        flat = _flattened(values)
        if function.argtypes is None:
            function.argtypes = [_KINDS[type(value)] for value in flat]
        result: int = function(*flat)
        return result

    return call


_KINDS: Final[dict[type, Any]] = {bool: ctypes.c_int, int: ctypes.c_longlong, float: ctypes.c_double}


def _plain(name: str) -> Callable[..., Any]:
    """Wrap a function of the source; it reads and writes memory views."""
    from vibro.core import loop  # late: seldom needed

    function = getattr(loop, name)
    room = sys.modules[function.__module__]
    kinds = [getattr(room, str(k), None) for p, k in function.__annotations__.items() if p != "return"]

    def viewed(kind: Any, value: Any) -> Any:
        if isinstance(value, tuple):
            return kind(*(viewed(None, x) for x in value))
        return memoryview(value.reshape(-1)) if hasattr(value, "ctypes") else value

    def call(*values: Any) -> Any:
        return function(*(viewed(kind, value) for kind, value in zip(kinds, values, strict=True)))

    return call


@cache
def doors() -> Doors:
    """Load the solver.

    Raises
    ------
    ImportError
        If the compiled library is not of the source beside it.
    """
    path = library_path()
    if path is None:
        return Doors(None)
    try:
        library = ctypes.PyDLL(str(path))  # it releases Python's lock itself, and raises Python's exceptions
        library.vibro_sources.restype = ctypes.c_char_p
        digest, *names = library.vibro_sources().decode().split("\n")
    except (OSError, AttributeError) as exc:
        raise ImportError(f"the compiled solver {path} cannot be loaded: {exc}; {_REMEDY}") from None
    whole = hashlib.sha256()
    for name in names:
        source = _FOLDER / name
        text = source.read_bytes() if source.is_file() else b""
        whole.update(name.encode() + b"\0" + text + b"\0")
    if whole.hexdigest() != digest:
        raise ImportError(
            f"the compiled solver {path} was built from another version of the source; {_REMEDY}"
        )
    python = ctypes.pythonapi
    calls = (
        python.PyEval_SaveThread,
        python.PyEval_RestoreThread,
        python.PyObject_CallNoArgs,
        python.Py_DecRef,
    )
    library.vibro_listen(*(ctypes.cast(call, ctypes.c_void_p) for call in calls), ctypes.py_object(_ask))
    return Doors(library)


_REMEDY: Final = "install the package again, or set VIBRO_SOLVER=python to run it uncompiled"
