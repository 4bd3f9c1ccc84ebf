"""The solver's translator: compiled, statements do what they do in Python; and what is refused."""

from __future__ import annotations

import ctypes
import importlib.util
import math
import shutil
import subprocess
import sys
import types
from itertools import product
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest
from helpers.cases import each

from vibro.core.codes import Mode, Pattern

if TYPE_CHECKING:
    from collections.abc import Callable

TOOLS = Path(__file__).parents[1] / "tools"
CORE = Path(__file__).parents[1] / "src" / "vibro" / "core"
COMPILER = next((found for name in ("cc", "gcc", "clang") if (found := shutil.which(name))), None)
needs_compiler = pytest.mark.skipif(COMPILER is None, reason="there is no C compiler (cc, gcc, clang)")

HEADER = """
from __future__ import annotations
import math
from collections.abc import Callable
from typing import Final, NamedTuple, TypeVar
from vibro.core.numbers import Bytes, Doubles, Integers, doubles, integers
from vibro.core.codes import Mode, Pattern
"""
# Two modules that have names in common.
ROOM = """
HALF: Final = 0.5
MANY: Final = 2 * 21
EVER: Final = math.inf
_SIZE: Final = 5.0

def _scaled(x: float) -> float:
    return _SIZE * x

def scale(x: float) -> float:
    return x + _SIZE

def other(x: float) -> float:
    return _scaled(x)
"""
PROGRAM = '''
import functools
from vibro.core.room import EVER, HALF, MANY as LOTS, other, scale

_SIZE: Final = 2.0
_SHIFT: Final = -HALF - math.pi
_COUNT: Final = -3
_NAN: Final = math.nan
_YES: Final = True
_NAMES: Final = ("a", "b")
_LATE = [1, 2]

class Name(str):
    pass

def spelt(text: str) -> list[str]:
    return [letter for letter in text]

# ---- expressions

def floats(a: float, b: float) -> float:
    c = 0.7
    return a - (b - c) * -a + (a - b) - c * (b + a) + a / 3.0

def whole(i: int, j: int) -> int:
    k = 4 - j
    return i - (j - k) * 3 + (i + 7) // 3 - (j + 5) % 4 + (i & 6) - -k + 17 // 5

def quotient(i: int, j: int) -> int:
    return i // j

def rest(i: int, j: int) -> int:
    return i % j

def by_three(i: int) -> int:
    return 100 * (i // 3) + 10 * (i // -3) + i % 3 - 7 % i + -i % 8 // 2

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
    return (a if flag else 7.5) + (i if a > 0.0 else 2) - (1.0 if i > 2 else 2.0 if flag else 3.0)

def two(x: float, y: float) -> float:
    return math.atan2(x, y) + 10.0 * math.copysign(x, y)

def remains(x: float, y: float) -> float:
    return math.remainder(x, y)

def rounded(x: float) -> float:
    return float(math.floor(x)) + 10.0 * math.ceil(x) + x * math.floor(-x)

def no_minus_nothing(x: float) -> float:
    return float(math.ceil(x) * 1)

def least(x: float, y: float) -> float:
    return min(x, y)

def most(x: float, y: float) -> float:
    return max(x, 0.5, y)

def counts(x: float, i: int) -> float:
    return max(i, 2) + min(7, i, 4) + abs(x) + abs(i) + float(i) / 2 + abs(i - 5)

# ---- statements

def sign(x: float) -> int:
    """Say what it does."""
    if x > 0.0:
        return 1
    elif x < 0.0:
        pass
    else:
        return 0
    return -1

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
    for k in range(1, 3):
        seen += k
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

def last(low: int, high: int) -> int:
    i, found = 7, 0
    for i in range(low, high):
        for i in range(i, i + 2):
            found += i
    while True:
        if found > i:
            known = 2
            break
        found += 5
    return 100 * found + i + known

def sweep(n: int) -> float:
    total: float = 0.0
    whole = 0.0
    whole += n
    x: float
    for i in range(n):
        x = float(i)
        total += x / (i + 1)
        total *= 1.5
        total -= whole
        total /= 2
    return total

# ---- tuples, records, buffers

def pair(a: float, i: int) -> tuple[float, int]:
    return (a + 1.0, i) if a > 0.0 else (a, 2 * i)

def first(a: float) -> tuple[float, bool]:
    return a, a > 0.0

def tuples(a: float, b: float) -> float:
    a, b = b, a + b
    c, j = pair(a, 3)
    _, j = pair(b, j)
    d, flag = first(c)
    d, _ = first(c - d) if flag else first(c + d)
    return a - 3.0 * b + c * j + 10.0 * d + (1.0 if flag else 0.0)

def places(x: Doubles, i: int) -> int:
    x[0], x[i] = x[i], x[0]
    i, x[i] = i + 1, 5.0
    x[2], i = pair(x[1], i)
    return i

class Point(NamedTuple):
    """A point."""

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

def records(x: float, y: float, n: int) -> float:
    one = Point(x, y, n, double=x > y)
    two = moved(one, 0.25)
    one, two = two, one
    both = Line(end=one, begin=two._replace(y=3.0))
    kept = both
    both = both._replace(begin=one)
    extra = 100.0 if one.double else 50.0
    return along(both) + 1000.0 * along(kept) + extra + moved(Point(x, 1.0, 2, False), x).x

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

def fill(x: Doubles, n: Integers, b: Bytes, size: int) -> int:
    for i in range(size):
        x[i] += n[i] / 2
        n[i] = n[i] * 3 - b[i]
        b[i] = -i
        b[size - 1 - i] = 2 if x[i] > 1.0 else b[i]
    x[0] = n[1]
    return n[size - 1]

class Rows(NamedTuple):
    x: Doubles
    count: int
    codes: Bytes

def total(rows: Rows, scale: float, out: Rows) -> None:
    for i in range(rows.count):
        out.x[i] = scale * rows.x[i]
        out.codes[i] = rows.codes[i] + out.count

# ---- names

def constants(x: float) -> float:
    return 3.0 * x - _SHIFT * LOTS - (-_SHIFT) + _COUNT - -_COUNT

def far(x: float) -> float:
    return -EVER if x > 0.0 else EVER

def codes(i: int) -> int:
    return 1 if i == Mode.REST else Pattern.FB if i < 0 else int(Pattern.F_B_)

class Kept(NamedTuple):
    register: float
    static: int

def words(double: float, long: int) -> float:
    auto = double + long
    short = Kept(auto, static=long)
    for switch in range(2):
        auto += switch
    return short._replace(register=short.register * 2.0).register + short.static + auto

def _scaled(x: float) -> float:
    return _SIZE * x

def neighbours(x: float) -> float:
    return _scaled(x) - other(x) - 10.0 * scale(x)

# ---- functions of functions, arrays

Of = TypeVar("Of")

def halved(f: Callable[[Of, float], float], of: Of, low: float, high: float) -> float:
    for _ in range(60):
        middle = 0.5 * (low + high)
        if f(of, middle) > 0.0:
            high = middle
        else:
            low = middle
    return high

def twice(f: Callable[[Of, float], float], of: Of, top: float) -> float:
    return halved(f, of, 0.0, top) + 10.0 * halved(_beyond, top, 0.0, 2.0 * top)

def _beyond(limit: float, x: float) -> float:
    return x * x - limit

def _over(p: Point, x: float) -> float:
    return p.n * x - p.y

def solved(x: float) -> float:
    return twice(_beyond, x, 4.0) - twice(_over, Point(1.0, x, 2, True), 3.0)

def reversed_sum(x: Doubles, n: int) -> float:
    room = doubles(2 * 4)
    for i in range(n):
        room[n - 1 - i] = x[i]
    found = room[7]
    for i in range(n):
        found = 2.0 * found + _second(room, i)
    return found

def _second(x: Doubles, i: int) -> float:
    room, order = doubles(2), integers(3)
    order[2] = 1
    room[order[2]] = x[i] + room[order[1]]
    return room[1]

def shared(x: Doubles) -> float:
    return reversed_sum(x, 3) + reversed_sum(x, 2)
'''
WHOLE = (-9, -8, -7, -3, -2, -1, 1, 2, 3, 7, 8, 9)
NUMBERS = (0.0, -0.0, 1.0, -2.5, 0.3, 1e300, 5e-324, math.inf, -math.inf, math.nan)
SOME = (0.0, -0.0, 0.3, -0.7, -1.7, 2.5, 30.0)


def array(*values: float, kind: Any = np.float64) -> Any:
    return np.array(values, kind)


# Each exported function, and what it is called with.
CALLS: dict[str, list[tuple[Any, ...]]] = {
    "floats": [*product(NUMBERS, NUMBERS)],
    "whole": [*product((0, 1, 5, 6, 11, -4), (0, 2, 3, 9, -13))],
    "quotient": [*product((0, *WHOLE), WHOLE), (2**62, -3), (-(2**62), 3)],
    "rest": [*product((0, *WHOLE), WHOLE), (2**62, -3), (-(2**62), 3)],
    "by_three": [(i,) for i in WHOLE],
    "bits": [*product(NUMBERS, NUMBERS, (2, 3))],
    "choice": [(a, *x) for a in NUMBERS for x in ((2, True), (3, False), (1, False))],
    "two": [*product(SOME, (0.7, -2.0))],
    "remains": [*product(SOME, (0.7, -2.0))],
    "rounded": [(x,) for x in SOME],
    "no_minus_nothing": [(x,) for x in SOME],
    "least": [*product(NUMBERS, NUMBERS)],
    "most": [*product(NUMBERS, NUMBERS)],
    "counts": [*product(SOME, (-4, 0, 3))],
    "sign": [(x,) for x in NUMBERS],
    "count": [*product((0, 2, 9), (0, 3, 8, 30))],
    "last": [*product((0, 2), (0, 2, 5))],
    "sweep": [(n,) for n in range(6)],
    "tuples": [*product((-1.0, 0.5), (-2.0, 3.0))],
    "places": [(array(1.0, 2.0, 3.0, 4.0), i) for i in range(3)],
    "records": [(0.5, 2.0, 3), (2.0, 0.5, -1), (math.inf, 1.0, 0)],
    "lent": [(0.5,), (-2.0,), (math.inf,)],
    "fill": [(array(0.5, -1.0, 2.0), array(7, -8, 9, kind=np.int64), array(1, -2, 3, kind=np.int8), 3)],
    "constants": [(x,) for x in NUMBERS],
    "far": [(x,) for x in NUMBERS],
    "codes": [(-1,), (0,), (int(Mode.REST),), (int(Pattern.FB),)],
    "words": [(1.5, 4)],
    "neighbours": [(1.25,), (-3.0,)],
    "solved": [(0.5,), (3.0,)],
    "reversed_sum": [(array(1.0, 2.0, 3.0), n) for n in range(4)],
    "shared": [(array(1.0, 2.0, 3.0),)],
}
KINDS: dict[str, Any] = {"float": ctypes.c_double, "int": ctypes.c_longlong, "bool": ctypes.c_int}


def _tool(name: str) -> Any:
    spec = importlib.util.spec_from_file_location(name, TOOLS / f"{name}.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


translate = _tool("translate")


class Built:
    """``PROGRAM`` as Python and compiled."""

    def __init__(self, folder: Path) -> None:
        text = HEADER + PROGRAM + f"DOORS: Final = ({', '.join(CALLS)}, total)\n"
        self.folder = written(folder, loop=text, room=HEADER + ROOM)
        self.c: str = translate.translate(folder)
        self._made = types.ModuleType("loop")
        with pytest.MonkeyPatch.context() as patch:
            room = types.ModuleType("vibro.core.room")
            patch.setitem(sys.modules, "vibro.core.room", room)
            exec(compile(HEADER + ROOM, "room", "exec"), room.__dict__)
            exec(compile(text, "loop", "exec"), self._made.__dict__)
        code, library = folder / "loop.c", folder / "loop.lib"
        code.write_text(self.c, "utf-8")
        flags = ["-O2", "-ffp-contract=off", "-Wall", "-Werror", "-Wno-unused-function"]
        flags += ["-Wno-unused-variable", "-Wno-unused-but-set-variable"]
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


def written(folder: Path, **modules: str) -> Path:
    """Write a program of the solver's buffers and codes, and of these modules."""
    for name in ("numbers.py", "codes.py"):
        shutil.copyfile(CORE / name, folder / name)
    for name, text in modules.items():
        (folder / f"{name}.py").write_text(text, "utf-8")
    return folder


def same(found: Any, expected: Any) -> bool:
    if isinstance(expected, float):
        if math.isnan(expected):
            return isinstance(found, float) and math.isnan(found)
        return float(found) == expected and math.copysign(1.0, found) == math.copysign(1.0, expected)
    return bool(found == expected)


@pytest.fixture(scope="module")
def built(tmp_path_factory: pytest.TempPathFactory) -> Built:
    return Built(tmp_path_factory.mktemp("program"))


@needs_compiler
@pytest.mark.parametrize("name", CALLS)
def test_compiled_it_does_what_it_does_in_python(built: Built, name: str) -> None:
    """Results are the same bit by bit, and so is what is in arrays afterwards."""
    for values in CALLS[name]:
        ours, theirs = ([v.copy() if isinstance(v, np.ndarray) else v for v in values] for _ in range(2))
        expected = built.python(name)(*(memoryview(v) if isinstance(v, np.ndarray) else v for v in ours))  # type: ignore[arg-type]
        found = built.compiled(name)(*theirs)
        assert same(found, expected), (values, found, expected)
        for one, other in zip(ours, theirs, strict=True):
            if isinstance(one, np.ndarray):
                assert one.tobytes() == other.tobytes(), values


@needs_compiler
def test_records_of_buffers_are_handed_over_field_by_field(built: Built) -> None:
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
def test_what_is_for_python_alone_is_left_out(built: Built) -> None:
    assert "spelt" not in built.c
    for name in ("vibro_along", "loop_sign"):  # no doors: not exported
        with pytest.raises(AttributeError):
            getattr(built.library, name)


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
def test_a_library_says_what_it_is_of(built: Built) -> None:
    built.library.vibro_sources.restype = ctypes.c_char_p
    digest, *names = built.library.vibro_sources().decode().split("\n")
    assert names == ["codes.py", "loop.py", "numbers.py", "room.py"]
    assert digest == translate.digest([built.folder / name for name in names])


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
    with pytest.raises(translate.TranslationError) as caught:
        translate.translate(written(folder, loop=HEADER + source))
    return str(caught.value)


RECORD = "class Pair(NamedTuple):\n    a: float\n    n: int\n\n"
OTHERS = (
    RECORD
    + """
_TEXT: Final = 'text'
_BACK: Final = -1
_FEW: Final = 3.0

def text(x: str) -> float:
    return 1.0

def helper(x: float, n: int) -> float:
    return x + n

def pair(x: float, y: float) -> tuple[float, float]:
    return x, y

def total(x: Doubles) -> float:
    return x[0] + x[1]

def filled(x: Doubles, y: float) -> float:
    x[0] = y
    return y

def filling(x: Doubles) -> float:
    return filled(x, 2.0)

def half(x: float) -> float:
    return 0.5 * x

def zero(f: Callable[[float], float], x: float) -> float:
    return f(x)

class Other(NamedTuple):
    a: float

def off(of: Other, x: float) -> float:
    return of.a - x

def zero_of(f: Callable[[Pair, float], float], of: Pair, x: float) -> float:
    return f(of, x)

"""
)


@each(
    ("body", "why"),
    [
        ("return x ** 2.0", "no translation: x ** 2.0"),
        ("return x // 2.0", "for whole numbers alone: x // 2.0"),
        ("return x % 2.0", "for whole numbers alone: x % 2.0"),
        ("return x if x else 1.0", "float in place of bool: x"),
        ("return x if n else 1.0", "int in place of bool: n"),
        ("return 1.0 if x > 0.0 and n else x", "int in place of bool: n"),
        ("n = x\n    return x", "float in place of int: x"),
        ("n /= 2\n    return x", "float in place of int: n / 2"),
        ("k = 1\n    k = 0.5\n    return x", "float in place of int: 0.5"),
        ("i = 0.0\n    for i in range(3):\n        pass\n    return x", "i is float and int"),
        (
            "for i in range(5, 0, -1):\n        x += i\n    return x",
            "not a positive number: -1",
        ),
        ("for i in range(0, 5, n):\n        x += i\n    return x", "not a positive number: n"),
        ("for i in range(0, 5, 0):\n        x += i\n    return x", "a step that is not a positive number"),
        ("for i in range(3):\n        pass\n    else:\n        x = 1.0\n    return x", "no translation"),
        ("while x > 0.0:\n        x -= 1.0\n    else:\n        x = 1.0\n    return x", "no translation"),
        ("y = z = x\n    return y + z", "no translation: y = z = x"),
        ("try:\n        return x\n    except ValueError:\n        return 0.0", "no translation"),
        ("return (y := x)", "no translation"),
        ("return 1.0 if n in (1, 2) else 0.0", "no translation"),
        ("return math.pi", "unknown: math"),
        ("return round(x)", "no translation: round(x)"),
        ("return missing(x)", "no translation: missing(x)"),
        ("return helper(x)", "takes 2 arguments by position: helper(x)"),
        ("return helper(x, x)", "float in place of int: x"),
        ("return Pair(x, n)", "Pair in place of float"),
        ("return Pair(x).a", "takes a, n: Pair(x)"),
        ("return Pair(x, n, n=n).a", "takes a, n"),
        ("return Pair(x, n).c", "no field: Pair(x, n).c"),
        ("return Mode.NOWHERE + x", "no field: Mode.NOWHERE"),
        ("return Pair(x, n) + x", "no translation"),
        ("p = Pair(x, n)\n    p.a = 1.0\n    return x", "no target: p.a"),
        ("a, b = x, n, n\n    return a", "2 targets: (x, n, n)"),
        ("a, b = helper(x, n)\n    return a", "2 targets: helper(x, n)"),
        ("return x[0]", "no translation: x[0]"),
        ("return values[x]", "float in place of int: x"),
        ("values[0] = Pair(x, n)\n    return x", "Pair in place of float"),
        ("return _TEXT", "unknown: _TEXT"),
        ("return text(x)", "no translation: text(x)"),
        # a whole number in place of a float would be -0.0 where Python has 0
        ("return n", "int in place of float: n"),
        ("y: float = 0\n    return -y", "int in place of float: 0"),
        ("return x if x > 0.0 else n", "int in place of float: n"),
        ("return -math.floor(x)", "no translation of minus whole"),
        ("return math.floor(x)", "whole in place of float"),
        ("y = math.floor(x)\n    return -y", "float(...) or int(...) of what floor or ceil return"),
        ("return math.floor(x) // 2", "for whole numbers alone"),
        ("return min(n, x)", "numbers of two types"),
        ("return max(x, key=abs)", "no translation: max(x, key=abs)"),
        ("return x - -(n > 2)", "no translation of minus bool"),
        ("return float(values)", "no translation of Doubles"),
        ("return x + 9223372036854775808", "more than 64 bits"),
        ("return values[-1]", "a negative index"),
        ("return 1.0 if values == values else x", "no comparison of Doubles"),
        ("n = 1\n    n: float = x\n    return n", "n is int and float"),
        ("part__0 = x\n    return part__0", "part__0: names with __ are the translator's"),
        # what Python finds unset is any number in C
        ("if x > 0.0:\n        y = x\n    return y", "not set on every way to here: y"),
        ("if x > 0.0:\n        return x", "it may end without a result"),
        ("while x > 0.0:\n        y = 1.0\n        x -= y\n    return y", "not set on every way to here: y"),
        ("for i in range(n):\n        pass\n    return x + i", "not set on every way to here: i"),
        ("while True:\n        if n > 3:\n            break\n        y = x\n    return y", "to here: y"),
        ("y += x\n    return y", "not set on every way to here: y"),
        ("x = _FEW + x\n    _FEW = 2.0\n    return x", "not set on every way to here: _FEW"),
        ("return", "no translation: return"),
        # C evaluates operands and arguments in any order
        ("return filled(values, x) + values[0]", "one part fills a buffer that another may read"),
        ("return max(filled(values, x), filling(values))", "one part fills a buffer"),
        ("values[0] += filled(values, x)\n    return x", "one part fills a buffer"),
        ("a, b = pair(filled(values, x), values[0])\n    return a", "one part fills a buffer"),
        ("return x if 0.0 < filled(values, x) < 2.0 else 1.0", "would be evaluated twice"),
        # functions as arguments, and arrays
        ("return zero(x)", "no function of the solver: x"),
        ("return zero(helper, x)", "a function of other arguments, or another result: zero(helper, x)"),
        ("return zero(half)", "takes 1 arguments by position: zero(half)"),
        ("y = total\n    return x", "unknown: total"),
        ("room = doubles(n)\n    return room[0]", "an array has a constant length"),
        ("for _ in range(2):\n        room = doubles(2)\n    return x", "and is in no loop"),
        ("values = doubles(2)\n    return x", "a name of its own"),
        ("return doubles(2)[0]", "no translation: doubles(2)"),
    ],
)
def test_what_has_no_translation_is_refused_with_its_place(tmp_path: Path, body: str, why: str) -> None:
    source = f"def wrong(x: float, n: int, values: Doubles) -> float:\n    {body}\n" + OTHERS
    said = refusal(tmp_path, source)
    assert why in said
    assert said.startswith("wrong, line ")
    number = int(said.split(":")[0].removeprefix("wrong, line "))
    first = (HEADER + source).splitlines().index("def wrong(x: float, n: int, values: Doubles) -> float:") + 1
    assert number >= first


def test_two_records_of_one_name_are_refused(tmp_path: Path) -> None:
    assert "two records are called Pair" in refusal(tmp_path, RECORD + RECORD)


def test_decorators_are_refused(tmp_path: Path) -> None:
    source = "@staticmethod\ndef wrong(x: float) -> float:\n    return x\n"
    assert "no decorators" in refusal(tmp_path, source)


def test_an_array_does_not_outlive_its_function(tmp_path: Path) -> None:
    source = "def wrong() -> Doubles:\n    room = doubles(2)\n    return room\n"
    assert "does not outlive its function" in refusal(tmp_path, source)


def test_fields_that_are_no_numbers_are_refused(tmp_path: Path) -> None:
    assert "no type: str" in refusal(tmp_path, "class Pair(NamedTuple):\n    a: str\n")
