"""The solver's translator: compiled, statements do what they do in Python; and what is refused."""

from __future__ import annotations

import ctypes
import math
import re
import shutil
import subprocess
import types
from itertools import product
from pathlib import Path
from textwrap import indent
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest
from dialects import JavaScript
from helpers.cases import each
from helpers.node_doors import running
from translate import TranslationError, digest, translate

if TYPE_CHECKING:
    from collections.abc import Callable

CORE = Path(__file__).parents[1] / "src" / "vibro" / "core"
COMPILER = next((found for name in ("cc", "gcc", "clang") if (found := shutil.which(name))), None)
needs_compiler = pytest.mark.skipif(COMPILER is None, reason="there is no C compiler (cc, gcc, clang)")
FLAGS = ["-Wall", "-Werror", "-Wno-unused-function", "-Wno-unused-variable", "-Wno-unused-but-set-variable"]

HEADER = """
from __future__ import annotations
import math
from collections.abc import Callable
from typing import Final, NamedTuple, TypeVar
from vibro.core.numbers import Bytes, Doubles, Integers, doubles, integers
from vibro.core.codes import Mode, Pattern
"""
# What is not the same in C without care; that all else does as in Python tests/core/test_compiled.py shows.
PROGRAM = '''
# ---- expressions

def whole(i: int, j: int) -> int:
    k = 4 - j
    return i - (j - k) * 3 + (i + 7) // 3 - (j + 5) % 4 + (i & 6) - -k

def quotient(i: int, j: int) -> int:
    return i // j - 3 * (i % j)

def compared(a: float, b: float, i: int) -> int:
    found = (a < b) + 2 * (a <= b) + 4 * (a > b) + 8 * (a >= b) + 16 * (a == b) + 32 * (a != b)
    found += 64 * (0.0 < a <= b < 2) + 128 * (not a < b and (i == 3 or b > 1.0))
    known = a < i or False
    return found + (256 if not (a < b and i != 3) else 0) + (512 if known and True else 0)

def rounded(x: float) -> float:
    return float(math.floor(x)) + 10.0 * math.ceil(x) + x * math.floor(-x)

def no_minus_nothing(x: float) -> float:
    return float(math.ceil(x) * 1)

def least(x: float, y: float) -> float:
    return min(x, y)

def most(x: float, y: float) -> float:
    return max(x, 0.5, y)

def counts(x: float, i: int) -> float:
    return max(i, 2) + min(7, i, 4) + abs(x) + i / 2 + float(i) + abs(i - 5)

# ---- statements

def count(low: int, high: int) -> int:
    seen, i = 0, -5
    for i in range(low, high, 3):
        seen = 10 * seen + i
        high += 1  # the end is that of the start
        i += 100  # and so is the counter
    for j in range(high):
        if j == 2:
            continue
        if j > 4:
            break
        for _ in range(2):
            for _ in range(2):
                seen += j
    i_count, i_end, part0, part1, whole = 3, 5, 1, 2, 4
    for i in range(i_end - i_count):
        part0, part1 = part1 + i_count, part0 + i_end
        whole, seen = pair_of(whole, seen)
    while seen > 10000:
        seen = seen // 2
        if seen == 77:
            break
    return seen + i + part0 - part1 + whole

def pair_of(i: int, j: int) -> tuple[int, int]:
    return j % 100, i + j

# ---- tuples, records, buffers

def places(x: Doubles, i: int) -> int:
    x[0], x[i] = x[i], x[0]
    i, x[i] = i + 1, 5.0
    return i

class Point(NamedTuple):
    """A point, one of whose fields is a word of C."""

    x: float
    y: float
    n: int = 0
    double: bool = False

class Line(NamedTuple):
    begin: Point
    end: Point

def moved(p: Point, by: float) -> Point:
    return p._replace(x=p.x + by, n=p.n + 1)

def along(line: Line) -> float:
    return line.end.x - line.begin.x + 10.0 * (line.end.y - line.begin.y) + line.end.n

def records(x: float, long: int) -> float:
    one = Point(x, 2.0, long, double=x > 1.0)
    two = moved(one, 0.25)
    one, two = two, one
    both = Line(end=one, begin=two._replace(y=3.0))
    kept = both
    both = both._replace(begin=one)
    return along(both) + 1000.0 * along(kept) + (100.0 if one.double else 50.0)

def changed(p: Point, line: Line) -> float:
    before = p.x
    for switch in range(3):
        p = moved(p, 1.0 + switch)
    line = line._replace(end=p)
    return p.x - before + 100.0 * along(line)

def lent(x: float) -> float:
    one = Point(x, 1.0, 2, False)
    line = Line(one, moved(one, x))
    sum = changed(line.end, line) + changed(moved(line.begin, x), Line(line.end, one))
    return sum + 1e4 * along(line) + changed(one if x > 0.0 else line.end, line) + one.x

'''
WHOLE = (-9, -8, -7, -3, -2, -1, 1, 2, 3, 7, 8, 9)
NUMBERS = (0.0, -0.0, 1.0, -2.5, 0.3, 1e300, 5e-324, math.inf, -math.inf, math.nan)
SOME = (0.0, -0.0, 0.3, -0.7, -1.7, 2.5, 30.0)
ROW = np.array([1.0, 2.0, 3.0, 4.0])

# Each exported function, and what it is called with.
CALLS: dict[str, list[tuple[Any, ...]]] = {
    "whole": [*product((0, 1, 5, 6, 11, -4), (0, 2, 3, 9, -13))],
    "quotient": [*product((0, *WHOLE), WHOLE), (2**62, -3), (-(2**62), 3)],
    "compared": [*product(NUMBERS, NUMBERS, (2, 3))],
    "rounded": [*product(SOME)],
    "no_minus_nothing": [*product(SOME)],
    "least": [*product(NUMBERS, NUMBERS)],
    "most": [*product(NUMBERS, NUMBERS)],
    "counts": [*product(SOME, (-4, 0, 3))],
    "count": [*product((0, 2, 9), (0, 3, 8, 30))],
    "places": [*product([ROW], range(3))],
    "records": [*product((0.5, 2.0, math.inf), (3, -1))],
    "lent": [*product((0.5, -2.0, math.inf))],
}
KINDS: dict[str, Any] = {"float": ctypes.c_double, "int": ctypes.c_longlong, "bool": ctypes.c_int}


def written(folder: Path, text: str) -> Path:
    """Write a program of the solver's buffers and codes, and of this module."""
    for name in ("numbers.py", "codes.py"):
        shutil.copyfile(CORE / name, folder / name)
    (folder / "loop.py").write_text(text, "utf-8")
    return folder


def compile_c(folder: Path, *flags: str) -> None:
    done = subprocess.run([str(COMPILER), *FLAGS, *flags], cwd=folder, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr[-3000:]


class Built:
    """``PROGRAM`` as Python and compiled."""

    def __init__(self, folder: Path) -> None:
        text = HEADER + PROGRAM + f"DOORS: Final = ({', '.join(CALLS)})\n"
        self.folder = written(folder, text)
        self.python = types.ModuleType("loop")
        exec(compile(text, "loop", "exec"), self.python.__dict__)

    def check(self, of: Callable[[str], Callable[..., Any]], most: int = 2**63) -> None:
        """Call all functions: results are the same bit by bit, and so is what is in arrays afterwards."""
        for name, values in [(name, values) for name, calls in CALLS.items() for values in calls]:
            if max((abs(v) for v in values if isinstance(v, int)), default=0) > most:
                continue
            ours, theirs = ([v.copy() if isinstance(v, np.ndarray) else v for v in values] for _ in range(2))
            buffers = [memoryview(v.data) if isinstance(v, np.ndarray) else v for v in ours]
            expected, found = float(getattr(self.python, name)(*buffers)), float(of(name)(*theirs))
            is_nan = math.isnan(found) and math.isnan(expected)  # one is as good as another
            assert is_nan or found.hex() == expected.hex(), (name, values)
            assert [np.asarray(x).tobytes() for x in ours] == [np.asarray(x).tobytes() for x in theirs], name


@needs_compiler
def test_compiled_it_does_what_it_does_in_python(tmp_path: Path) -> None:
    built = Built(tmp_path)
    (tmp_path / "loop.c").write_text(translate(tmp_path), "utf-8")
    compile_c(tmp_path, "-O2", "-ffp-contract=off", "-shared", "-fPIC", "loop.c", "-o", "loop.lib", "-lm")
    library = ctypes.CDLL(str(tmp_path / "loop.lib"))

    def compiled(name: str) -> Callable[..., Any]:
        """Wrap an exported function of numbers and one-dimensional arrays."""
        function, hints = getattr(library, f"vibro_{name}"), getattr(built.python, name).__annotations__
        function.restype = KINDS.get(hints["return"])
        kinds = [KINDS.get(kind, ctypes.c_void_p) for key, kind in hints.items() if key != "return"]

        def call(*values: Any) -> Any:
            given = [v.ctypes.data if isinstance(v, np.ndarray) else v for v in values]
            return function(*(kind(v) for kind, v in zip(kinds, given, strict=True)))

        return call

    built.check(compiled)
    library.vibro_sources.restype = ctypes.c_char_p
    known, *names = library.vibro_sources().decode().split("\n")
    assert names == ["codes.py", "loop.py", "numbers.py"]
    assert known == digest([tmp_path / name for name in names])
    assert not hasattr(library, "vibro_along")  # it exports doors alone
    first = {known, digest([tmp_path / "loop.py"])}
    (tmp_path / "loop.py").write_text("", "utf-8")
    assert digest([tmp_path / name for name in names]) not in first


def test_in_javascript_it_does_what_it_does_in_python(tmp_path: Path) -> None:
    """The same, but for whole numbers beyond 2^53."""
    built = Built(tmp_path)
    (tmp_path / "loop.cjs").write_text(translate(tmp_path, JavaScript()), "utf-8")
    with running(tmp_path / "loop.cjs") as doors:
        built.check(lambda name: getattr(doors, name), most=2**53)


# --------------------------------------------------------------------------------------- what is refused


RECORD = "class Pair(NamedTuple):\n    a: float\n    n: int\n\n"
OTHERS = (
    RECORD
    + """
_FEW: Final = 3.0

def helper(x: float, n: int) -> float:
    return x + n

def pair(x: float, y: float) -> tuple[float, float]:
    return x, y

def filled(x: Doubles, y: float) -> float:
    x[0] = y
    return y

def filling(x: Doubles) -> float:
    return filled(x, 2.0)

def zero(f: Callable[[float], float], x: float) -> float:
    return f(x)

"""
)
HEAD = "def wrong(x: float, n: int, values: Doubles) -> float:"

# What is said, and bodies of a function of a float x, a whole n and a buffer ``values`` of which it is said.
REFUSED: dict[str, tuple[str, ...]] = {
    "no translation": (
        "return x ** 2.0", "return round(x)", "return (y := x)", "y = z = x\nreturn y + z",
        "for i in range(3):\n pass\nelse:\n x = 1.0\nreturn x",
        "try:\n return x\nexcept ValueError:\n return 0.0",
    ),
    "for whole numbers alone": ("return x // 2.0", "return x % 2.0"),
    "float in place of bool: x": ("return x if x else 1.0",),
    "int in place of bool: n": ("return 1.0 if x > 0.0 and n else x",),
    "float in place of int": ("n = x\nreturn x", "return values[x]"),
    # a whole number in place of a float would be -0.0 where Python has 0
    "int in place of float": ("return n", "y: float = 0\nreturn -y", "return x if x > 0.0 else n"),
    "i is float and int": ("i = 0.0\nfor i in range(3):\n pass\nreturn x",),
    "n is int and float": ("n = 1\nn: float = x\nreturn n",),
    "float(...) or int(...) of what floor or ceil return": ("y = math.floor(x)\nreturn -y",),
    "no translation of minus whole": ("return -math.floor(x)",),
    "no translation of minus bool": ("return x - -(n > 2)",),
    "numbers of two types": ("return min(n, x)",),
    "more than 64 bits": ("return x + 9223372036854775808",),
    "a negative index": ("return values[-1]",),
    "a step that is not a positive number": tuple(
        f"for i in range(5, 0, {step}):\n x += i\nreturn x" for step in ("-1", "n")
    ),
    "part__0: names with __ are the translator's": ("part__0 = x\nreturn part__0",),
    # what Python finds unset is any number in C
    "not set on every way to here": (
        "if x > 0.0:\n y = x\nreturn y", "while x > 0.0:\n y = 1.0\n x -= y\nreturn y", "y += x\nreturn y",
        "for i in range(n):\n pass\nreturn x + i", "x = _FEW + x\n_FEW = 2.0\nreturn x",
        "while True:\n if n > 3:\n  break\n y = x\nreturn y",
    ),
    "it may end without a result": ("if x > 0.0:\n return x",),
    # C evaluates operands and arguments in any order
    "one part fills a buffer that another may read": (
        "return filled(values, x) + values[0]", "return max(filled(values, x), filling(values))",
        "values[0] += filled(values, x)\nreturn x", "a, b = pair(filled(values, x), values[0])\nreturn a",
    ),
    "would be evaluated twice": ("return x if 0.0 < filled(values, x) < 2.0 else 1.0",),
    # functions as arguments, and arrays
    "a function of other arguments, or another result": ("return zero(helper, x)",),
    "an array has a constant length": (
        "room = doubles(n)\nreturn room[0]", "for _ in range(2):\n room = doubles(2)\nreturn x",
        "values = doubles(2)\nreturn x",
    ),
}  # fmt: skip


@each(("why", "body"), [(why, body) for why, bodies in REFUSED.items() for body in bodies])
def test_what_has_no_translation_is_refused_with_its_place(tmp_path: Path, why: str, body: str) -> None:
    source = f"{HEADER}{HEAD}\n{indent(body, '    ')}\n{OTHERS}"
    with pytest.raises(TranslationError) as caught:
        translate(written(tmp_path, source))
    said = str(caught.value)
    assert why in said
    place = re.match(r"wrong, line (\d+): ", said)
    assert place is not None
    first = HEADER.count("\n") + 1
    assert first <= int(place[1]) <= first + 1 + body.count("\n")
