"""The solver's translator: compiled, statements do what they do in Python; and what is refused."""

from __future__ import annotations

import ctypes
import importlib.util
import math
import shutil
import subprocess
import sys
import types
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest
from helpers.cases import each

from vibro.core.codes import Mode, Pattern

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

TOOLS = Path(__file__).parents[1] / "tools"
CORE = Path(__file__).parents[1] / "src" / "vibro" / "core"
COMPILER = next((found for name in ("cc", "gcc", "clang") if (found := shutil.which(name))), None)
needs_compiler = pytest.mark.skipif(COMPILER is None, reason="there is no C compiler (cc, gcc, clang)")

HEADER = """
from __future__ import annotations
import math
from typing import Final, NamedTuple
from vibro.core.buffers import Bytes, Doubles, Integers
from vibro.core.codes import Mode, Pattern
"""
KINDS: dict[str, Any] = {"float": ctypes.c_double, "int": ctypes.c_longlong, "bool": ctypes.c_int}
NUMBERS = (0.0, -0.0, 1.0, -2.5, 0.3, 1e300, 5e-324, math.inf, -math.inf, math.nan)


def _tool(name: str) -> Any:
    spec = importlib.util.spec_from_file_location(name, TOOLS / f"{name}.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


translate = _tool("translate")


class Built:
    """A solver of one small module, as Python and compiled."""

    def __init__(self, folder: Path, source: str, doors: Sequence[str], rooms: dict[str, str]) -> None:
        for name in ("buffers.py", "codes.py"):
            shutil.copyfile(CORE / name, folder / name)
        for name, text in rooms.items():
            (folder / f"{name}.py").write_text(HEADER + text, "utf-8")
        text = HEADER + f"__all__ = {list(doors)}\n" + source
        (folder / "loop.py").write_text(text, "utf-8")
        self.c: str = translate.translate(folder)
        self._made = types.ModuleType("loop")
        with pytest.MonkeyPatch.context() as patch:
            for name, room in rooms.items():
                module = types.ModuleType(f"vibro.core.{name}")
                patch.setitem(sys.modules, f"vibro.core.{name}", module)
                exec(compile(HEADER + room, name, "exec"), module.__dict__)
            exec(compile(text, "loop", "exec"), self._made.__dict__)
        code, library = folder / "loop.c", folder / "loop.lib"
        code.write_text(self.c, "utf-8")
        flags = ["-O2", "-ffp-contract=off", "-Wall", "-Werror", "-Wno-unused-function"]
        flags += ["-Wno-unused-variable", "-Wno-maybe-uninitialized"]
        command = [str(COMPILER), *flags, "-shared", "-fPIC", str(code), "-o", str(library), "-lm"]
        done = subprocess.run(command, capture_output=True, text=True)
        assert done.returncode == 0, done.stderr
        self.library = ctypes.CDLL(str(library))

    def python(self, name: str) -> Callable[..., Any]:
        function: Callable[..., Any] = getattr(self._made, name)
        return function

    def compiled(self, name: str) -> Callable[..., Any]:
        """Wrap an exported function of numbers and one-dimensional arrays."""
        function = getattr(self.library, f"vibro_{name}")
        hints = self.python(name).__annotations__
        function.restype = KINDS.get(hints["return"])
        kinds = [KINDS.get(kind, ctypes.c_void_p) for key, kind in hints.items() if key != "return"]

        def call(*values: Any) -> Any:
            given = [v.ctypes.data if isinstance(v, np.ndarray) else v for v in values]
            return function(*(kind(v) for kind, v in zip(kinds, given, strict=True)))

        return call

    def check(self, name: str, *values: Any) -> None:
        """Compare results, and what is in arrays afterwards, bit by bit."""
        ours = [v.copy() if isinstance(v, np.ndarray) else v for v in values]
        theirs = [v.copy() if isinstance(v, np.ndarray) else v for v in values]
        expected = self.python(name)(*(memoryview(v) if isinstance(v, np.ndarray) else v for v in ours))  # type: ignore[arg-type]
        found = self.compiled(name)(*theirs)
        assert same(found, expected), (name, values, found, expected)
        for one, other in zip(ours, theirs, strict=True):
            if isinstance(one, np.ndarray):
                assert one.tobytes() == other.tobytes(), (name, values)


def same(found: Any, expected: Any) -> bool:
    if isinstance(expected, float):
        if math.isnan(expected):
            return isinstance(found, float) and math.isnan(found)
        return float(found) == expected and math.copysign(1.0, found) == math.copysign(1.0, expected)
    return bool(found == expected)


@pytest.fixture
def build(tmp_path: Path) -> Callable[..., Built]:
    def made(source: str, *exported: str, **neighbours: str) -> Built:
        return Built(tmp_path, source, exported, neighbours)

    return made


# ------------------------------------------------------------------------------------------ expressions


@needs_compiler
def test_arithmetic_keeps_its_order(build: Callable[..., Built]) -> None:
    built = build(
        """
def floats(a: float, b: float, c: float) -> float:
    return a - (b - c) * -a + (a - b) - c * (b + a) + a / 3.0

def mixed(a: float, i: int, j: int) -> float:
    return a - i / 4 + j / 8 - (i - (j - 3)) + 2 * i * a

def whole(i: int, j: int, k: int) -> int:
    return i - (j - k) * 3 + (i + 7) // 3 - (j + 5) % 4 + (i & 6) - -k

def flags(i: int, a: bool) -> int:
    return i + a
""",
        "floats", "mixed", "whole", "flags",
    )  # fmt: skip
    for a in NUMBERS:
        for b in NUMBERS:
            built.check("floats", a, b, 0.7)
            built.check("mixed", a, 5, -3)
    for i in (0, 1, 5, 6, 11):
        for j in (0, 2, 3, 9):
            built.check("whole", i, j, 4 - j)
            built.check("mixed", 0.1, i, j)
            built.check("flags", i, j > 2)


@needs_compiler
def test_comparisons_and_truth_values(build: Callable[..., Built]) -> None:
    built = build(
        """
def bits(a: float, b: float, i: int) -> int:
    found = 0
    if a < b:
        found += 1
    if a <= b:
        found += 2
    if a > b:
        found += 4
    if a >= b:
        found += 8
    if a == b:
        found += 16
    if a != b:
        found += 32
    if 0.0 < a <= b < 2:
        found += 64
    if not a < b and (i == 3 or b > 1.0):
        found += 128
    if not (a < b and i != 3):
        found += 256
    known = a < i or False
    if known and True:
        found += 512
    return found

def choice(a: float, i: int, flag: bool) -> float:
    return (a if flag else i) + (i if a > 0.0 else 2.5) - (1.0 if i > 2 else 2.0 if flag else 3.0)

def test(a: float, b: float) -> bool:
    return not a > b
""",
        "bits", "choice", "test",
    )  # fmt: skip
    for a in NUMBERS:
        for b in NUMBERS:
            for i in (2, 3):
                built.check("bits", a, b, i)
            built.check("test", a, b)
        built.check("choice", a, 2, True)
        built.check("choice", a, 3, False)
        built.check("choice", a, 1, False)


@needs_compiler
def test_functions_of_numbers(build: Callable[..., Built]) -> None:
    one = ["sin", "cos", "tan", "atan", "exp", "ceil", "floor"]
    built = build(
        "".join(f"def {n}_of(x: float) -> float:\n    return 1.0 * math.{n}(x)\n" for n in one)
        + """
def inverse(x: float) -> float:
    return math.asin(x) - 2.0 * math.acos(x)

def positive(x: float) -> float:
    return math.sqrt(x) - math.log(x)

def two(x: float, y: float) -> float:
    return math.atan2(x, y) + 10.0 * math.copysign(x, y)

def rest(x: float, y: float) -> float:
    return math.remainder(x, y)

def tests(x: float) -> int:
    return (1 if math.isnan(x) else 0) + (2 if math.isinf(x) else 0) + (4 if math.isfinite(x) else 0)

def least(x: float, y: float, i: int) -> float:
    return min(x, y) - 2.0 * max(x, y) + 3.0 * min(x, y, 0.5) + max(i, 2) + min(i, x) + max(7, i, 4)

def sizes(x: float, i: int) -> float:
    return abs(x) + abs(i) + float(i) / 2 + abs(i - 5)

def cut(x: float, i: int) -> int:
    return int(x) + int(i) + int(math.floor(x))
""",
        *(f"{n}_of" for n in one), "inverse", "positive", "two", "rest", "tests", "least", "sizes", "cut",
    )  # fmt: skip
    for x in (0.0, -0.0, 0.3, -1.7, 2.5, 30.0):
        for name in one:
            built.check(f"{name}_of", x)
        for y in (0.7, -2.0):
            built.check("two", x, y)
            built.check("rest", x, y)
            built.check("least", x, y, 3)
            built.check("least", y, x, -3)
        built.check("sizes", x, -4)
        built.check("cut", x, 3)
    for x in (-1.0, 0.2, 1.0):
        built.check("inverse", x)
        built.check("positive", abs(x))
    for x in NUMBERS:
        built.check("tests", x)
        for y in NUMBERS:
            built.check("least", x, y, 1)


# ------------------------------------------------------------------------------------------- statements


@needs_compiler
def test_branches_and_loops(build: Callable[..., Built]) -> None:
    built = build(
        """
def sign(x: float) -> int:
    \"\"\"Say what it does.\"\"\"
    if x > 0.0:
        return 1
    elif x < 0.0:
        pass
    else:
        return 0
    return -1

def count(low: int, high: int, step: int) -> int:
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
    for k in range(1, 3):
        seen += k
    while seen > 10000:
        seen = seen // 2
        if seen == 77:
            break
    return seen + i

def sweep(n: int) -> float:
    total: float = 0
    whole = 0.0
    whole += n
    x: float
    for i in range(n):
        x = i
        total += x / (i + 1)
        total *= 1.5
        total -= whole
        total /= 2
    return total
""",
        "sign", "count", "sweep",
    )  # fmt: skip
    for x in NUMBERS:
        built.check("sign", x)
    for low in (0, 2, 9):
        for high in (0, 3, 8, 30):
            built.check("count", low, high, 1)
    for n in range(6):
        built.check("sweep", n)


@needs_compiler
def test_tuples_are_known_before_they_are_put_down(build: Callable[..., Built]) -> None:
    built = build(
        """
def pair(a: float, i: int) -> tuple[float, int]:
    return (a + 1.0, i) if a > 0.0 else (a, 2 * i)

def first(a: float) -> tuple[float, bool]:
    return a, a > 0.0

def use(a: float, b: float, i: int) -> float:
    a, b = b, a + b
    c, j = pair(a, i)
    _, j = pair(b, j)
    d, flag = first(c)
    d, _ = first(c - d) if flag else first(c + d)
    return a - 3.0 * b + c * j + 10.0 * d + (1.0 if flag else 0.0)

def places(x: Doubles, i: int) -> int:
    x[0], x[i] = x[i], x[0]
    i, x[i] = i + 1, 5.0
    x[2], i = pair(x[1], i)
    return i
""",
        "use", "places",
    )  # fmt: skip
    for a in (-1.0, 0.5):
        for b in (-2.0, 3.0):
            built.check("use", a, b, 3)
    for i in (0, 1, 2):
        built.check("places", np.array([1.0, 2.0, 3.0, 4.0]), i)


@needs_compiler
def test_records_are_values(build: Callable[..., Built]) -> None:
    built = build(
        """
class Point(NamedTuple):
    \"\"\"A point.\"\"\"

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

def use(x: float, y: float, n: int) -> float:
    one = Point(x, y, n, double=x > y)
    two = moved(one, 0.25)
    one, two = two, one
    both = Line(end=one, begin=two._replace(y=3))
    kept = both
    both = both._replace(begin=one)
    extra = 100.0 if one.double else 50.0
    return along(both) + 1000.0 * along(kept) + extra

def inner(x: float) -> float:
    return moved(Point(x, 1.0, 2, False), x).x

def changed(p: Point, line: Line) -> float:
    before = p.x
    for _ in range(3):
        p = moved(p, 1.0)
    line = line._replace(end=p)
    return p.x - before + 100.0 * along(line)

def lent(x: float) -> float:
    one = Point(x, 1.0, 2, False)
    line = Line(one, moved(one, x))
    sum = changed(line.end, line) + changed(moved(line.begin, x), Line(line.end, one))
    return sum + 1e4 * along(line) + changed(one if x > 0.0 else line.end, line) + one.x
""",
        "use", "inner", "lent",
    )  # fmt: skip
    for x, y, n in ((0.5, 2.0, 3), (2.0, 0.5, -1), (math.inf, 1.0, 0)):
        built.check("use", x, y, n)
        built.check("inner", x)
        built.check("lent", x)


@needs_compiler
def test_buffers_are_read_and_written(build: Callable[..., Built]) -> None:
    built = build(
        """
def fill(x: Doubles, n: Integers, b: Bytes, size: int) -> int:
    for i in range(size):
        x[i] += n[i] / 2
        n[i] = n[i] * 3 - b[i]
        b[i] = -i
        b[size - 1 - i] = 2 if x[i] > 1.0 else b[i]
    x[0] = n[1]
    return n[size - 1]
""",
        "fill",
    )
    built.check(
        "fill", np.array([0.5, -1.0, 2.0]), np.array([7, -8, 9], np.int64), np.array([1, -2, 3], np.int8), 3
    )


@needs_compiler
def test_records_of_buffers_are_handed_over_field_by_field(build: Callable[..., Built]) -> None:
    built = build(
        """
class Rows(NamedTuple):
    x: Doubles
    count: int
    codes: Bytes

def total(rows: Rows, scale: float, out: Rows) -> None:
    for i in range(rows.count):
        out.x[i] = scale * rows.x[i]
        out.codes[i] = rows.codes[i] + out.count
""",
        "total",
    )
    x, codes = np.array([1.0, 2.0]), np.array([3, 4], np.int8)
    out, marks = np.zeros(2), np.zeros(2, np.int8)
    function = built.library.vibro_total
    function.restype = None
    pointer = ctypes.c_void_p
    function(
        pointer(x.ctypes.data), ctypes.c_longlong(2), pointer(codes.ctypes.data), ctypes.c_double(0.5),
        pointer(out.ctypes.data), ctypes.c_longlong(7), pointer(marks.ctypes.data),
    )  # fmt: skip
    assert out.tolist() == [0.5, 1.0]
    assert marks.tolist() == [10, 11]


@needs_compiler
def test_constants_and_codes(build: Callable[..., Built]) -> None:
    built = build(
        """
from vibro.core.room import HALF, MANY as LOTS, tripled

_SHIFT: Final = -HALF - math.pi
_COUNT: Final = -3
_NAN: Final = math.nan
_NAMES: Final = ("a", "b")
_LATE = [1, 2]

def use(x: float) -> float:
    return tripled(x) - _SHIFT * LOTS - (-_SHIFT) + _COUNT - -_COUNT

def far(x: float) -> float:
    return math.inf_ if False else x

def codes(i: int) -> int:
    return 1 if i == Mode.REST else Pattern.FB if i < 0 else int(Pattern.F_B_)

def missing() -> float:
    return _NAN
""".replace("    return math.inf_ if False else x\n", "    return -EVER if x > 0.0 else EVER\n").replace(
            "HALF, MANY", "EVER, HALF, MANY"
        ),
        "use", "far", "codes", "missing",
        room="""
HALF: Final = 0.5
MANY: Final = 2 * 21
EVER: Final = math.inf

def tripled(x: float) -> float:
    return 3.0 * x
""",
    )  # fmt: skip
    for x in NUMBERS:
        built.check("use", x)
        built.check("far", x)
    for i in (-1, 0, int(Mode.REST), int(Pattern.FB)):
        built.check("codes", i)
    built.check("missing")


@needs_compiler
def test_words_of_c_are_other_names(build: Callable[..., Built]) -> None:
    built = build(
        """
class Kept(NamedTuple):
    register: float
    static: int

def use(double: float, long: int) -> float:
    auto = double + long
    short = Kept(auto, static=long)
    for switch in range(2):
        auto += switch
    return short._replace(register=short.register * 2.0).register + short.static + auto
""",
        "use",
    )
    built.check("use", 1.5, 4)


@needs_compiler
def test_the_same_names_in_two_modules_do_not_meet(build: Callable[..., Built]) -> None:
    built = build(
        """
from vibro.core.room import _scale, other

_SIZE: Final = 2.0

def _scaled(x: float) -> float:
    return _SIZE * x

def use(x: float) -> float:
    return _scaled(x) - other(x) - 10.0 * _scale(x)
""",
        "use",
        room="""
_SIZE: Final = 5.0

def _scaled(x: float) -> float:
    return _SIZE * x

def _scale(x: float) -> float:
    return x + _SIZE

def other(x: float) -> float:
    return _scaled(x)
""",
    )
    built.check("use", 1.25)


@needs_compiler
def test_what_is_for_python_alone_is_left_out(build: Callable[..., Built]) -> None:
    built = build(
        """
import functools

class Name(str):
    pass

def spelt(text: str) -> list[str]:
    return [letter for letter in text]

def use(x: float) -> float:
    return x

def inside(x: float) -> float:
    return 2.0 * x
""",
        "use",
    )
    assert "spelt" not in built.c
    built.check("use", 2.0)
    with pytest.raises(AttributeError):
        _ = built.library.vibro_inside  # not listed in __all__
    with pytest.raises(AttributeError):
        _ = built.library.loop_use


# --------------------------------------------------------------------------------------- whole programs


def test_modules_come_after_those_they_import(tmp_path: Path) -> None:
    texts = {
        "loop": "from vibro.core.b import f\nfrom vibro.core.a import g\n",
        "b": "import math\nfrom vibro.core.a import g\nfrom vibro.errors import X\n",
        "a": "from numpy import array\n",
        "unused": "",
    }
    for name, text in texts.items():
        (tmp_path / f"{name}.py").write_text(text)
    assert [path.stem for path in translate.sources(tmp_path)] == ["a", "b", "loop"]


def test_the_digest_is_of_names_and_texts(tmp_path: Path) -> None:
    one, two = tmp_path / "one.py", tmp_path / "two.py"
    one.write_text("a")
    two.write_text("b")
    first = translate.digest([one, two])
    assert first == translate.digest([two, one])
    two.write_text("c")
    changed = translate.digest([one, two])
    two.write_text("b")
    assert first == translate.digest([one, two])
    three = two.rename(tmp_path / "three.py")
    assert len({first, changed, translate.digest([one, three]), translate.digest([one])}) == 4


@needs_compiler
def test_a_library_says_what_it_is_of(build: Callable[..., Built], tmp_path: Path) -> None:
    built = build("def use(x: float) -> float:\n    return x\n", "use")
    built.library.vibro_sources.restype = ctypes.c_char_p
    digest, *names = built.library.vibro_sources().decode().split("\n")
    assert names == ["buffers.py", "codes.py", "loop.py"]
    assert digest == translate.digest([tmp_path / name for name in names])


@needs_compiler
def test_the_solver_translates_without_a_warning(tmp_path: Path) -> None:
    code = tmp_path / "solver.c"
    code.write_text(translate.translate(CORE), "utf-8")
    flags = ["-O0", "-Wall", "-Wextra", "-Werror", "-Wno-unused-function", "-Wno-unused-but-set-variable",
             "-Wno-unused-variable", "-Wno-unused-parameter"]  # fmt: skip
    command = [str(COMPILER), *flags, "-fsyntax-only", str(code)]
    done = subprocess.run(command, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr[-3000:]


# --------------------------------------------------------------------------------------- what is refused


def refusal(folder: Path, source: str) -> str:
    for name in ("buffers.py", "codes.py"):
        shutil.copyfile(CORE / name, folder / name)
    (folder / "loop.py").write_text(HEADER + source, "utf-8")
    with pytest.raises(translate.TranslationError) as caught:
        translate.translate(folder)
    return str(caught.value)


RECORD = "class Pair(NamedTuple):\n    a: float\n    n: int\n\n"


@each(
    ("body", "why"),
    [
        ("return x ** 2.0", "no translation: x ** 2.0"),
        ("return x // 2.0", "for whole numbers alone: x // 2.0"),
        ("return x % 2.0", "for whole numbers alone: x % 2.0"),
        ("return x if x else 1.0", "float in place of bool: x"),
        ("return x if n else 1.0", "int in place of bool: n"),
        ("return 1.0 if not n else x", "int in place of bool: n"),
        ("return 1.0 if x > 0.0 and n else x", "int in place of bool: n"),
        ("while n:\n        n -= 1\n    return x", "int in place of bool: n"),
        ("n = x\n    return x", "float in place of int: x"),
        ("n /= 2\n    return x", "float in place of int: n / 2"),
        ("k = 1\n    k = 0.5\n    return x", "float in place of int: 0.5"),
        ("k = True\n    k = 2\n    return x", "int in place of bool: 2"),
        ("for i in range(3.0):\n        pass\n    return x", "float in place of int: 3.0"),
        ("i = 0.0\n    for i in range(3):\n        pass\n    return x", "i is float and int"),
        (
            "for i in range(5, 0, -1):\n        x += i\n    return x",
            "not a positive number: -1",
        ),
        ("for i in range(0, 5, n):\n        x += i\n    return x", "not a positive number: n"),
        ("for i in range(0, 5, 0):\n        x += i\n    return x", "a step that is not a positive number"),
        ("for i in [1, 2]:\n        x += i\n    return x", "no translation"),
        ("for i in range(3):\n        pass\n    else:\n        x = 1.0\n    return x", "no translation"),
        ("while x > 0.0:\n        x -= 1.0\n    else:\n        x = 1.0\n    return x", "no translation"),
        ("y = z = x\n    return y + z", "no translation: y = z = x"),
        ("try:\n        return x\n    except ValueError:\n        return 0.0", "no translation"),
        ("with x:\n        return x", "no translation"),
        ("raise ValueError", "no translation"),
        ("assert x > 0.0\n    return x", "no translation"),
        ("def inner() -> float:\n        return 1.0\n    return x", "no translation"),
        ("y = lambda: x\n    return x", "no translation"),
        ("y = [x]\n    return x", "no translation"),
        ("y = 'text'\n    return x", "no translation"),
        ("y = None\n    return x", "no translation"),
        ("return float(x for _ in range(3))", "no translation"),
        ("return (y := x)", "no translation"),
        ("return ~n + x", "no translation"),
        ("return +x", "no translation"),
        ("return n @ n", "no translation: n @ n"),
        ("return 1.0 if x is x else 0.0", "no translation"),
        ("return 1.0 if n in (1, 2) else 0.0", "no translation"),
        ("return math.pi", "unknown: math"),
        ("return math.hypot(x, x)", "no translation: math.hypot"),
        ("return round(x)", "no translation: round(x)"),
        ("return missing", "unknown: missing"),
        ("return missing(x)", "no translation: missing(x)"),
        ("return helper(x)", "takes 2 arguments by position: helper(x)"),
        ("return helper(x, n=2)", "takes 2 arguments by position"),
        ("return helper(n, x)", "float in place of int: x"),
        ("return Pair(x, n)", "Pair in place of float"),
        ("return Pair(x).a", "takes a, n: Pair(x)"),
        ("return Pair(x, n, n).a", "takes a, n"),
        ("return Pair(x, m=n).a", "takes a, n"),
        ("return Pair(x, n, n=n).a", "takes a, n"),
        ("return Pair(x, x).a", "float in place of int: x"),
        ("return Pair(x, n).c", "no field: Pair(x, n).c"),
        ("return Pair(x, n)._replace(c=x).a", "no field"),
        ("return x.real", "no field: x.real"),
        ("return Mode.NOWHERE + x", "no field: Mode.NOWHERE"),
        ("return Pair(x, n) + x", "no translation"),
        ("p = Pair(x, n)\n    p.a = 1.0\n    return x", "no target: p.a"),
        ("a, b = x, n, n\n    return a", "2 targets: (x, n, n)"),
        ("a, b = Pair(x, n).a\n    return a", "2 targets"),
        ("a, b = helper(x, n)\n    return a", "2 targets: helper(x, n)"),
        ("return x[0]", "no translation: x[0]"),
        ("return values[x]", "float in place of int: x"),
        ("values[0] = Pair(x, n)\n    return x", "Pair in place of float"),
        ("del x\n    return 1.0", "no translation: del x"),
        ("global y\n    return x", "no translation: global y"),
        ("return _TEXT", "unknown: _TEXT"),
        ("return text(x)", "no translation: text(x)"),
    ],
)
def test_what_has_no_translation_is_refused_with_its_place(tmp_path: Path, body: str, why: str) -> None:
    source = RECORD + (
        "_TEXT: Final = 'text'\n\ndef text(x: str) -> float:\n    return 1.0\n\n"
        "def helper(x: float, n: int) -> float:\n    return x + n\n\n"
        f"def wrong(x: float, n: int, values: Doubles) -> float:\n    {body}\n"
    )
    said = refusal(tmp_path, source)
    assert why in said
    assert said.startswith("wrong, line ")
    number = int(said.split(":")[0].removeprefix("wrong, line "))
    first = (HEADER + source).splitlines().index("def wrong(x: float, n: int, values: Doubles) -> float:") + 1
    assert number >= first


def test_two_records_of_one_name_are_refused(tmp_path: Path) -> None:
    assert "two records are called Pair" in refusal(tmp_path, RECORD + RECORD)


def test_fields_that_are_no_numbers_are_refused(tmp_path: Path) -> None:
    assert "no type: str" in refusal(tmp_path, "class Pair(NamedTuple):\n    a: str\n")
