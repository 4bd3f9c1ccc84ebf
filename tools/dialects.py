"""The two languages into which tools/translate.py translates the solver: how each spells what it finds.

Both are for the same walk over the source. Types are named as in Python: ``float``, ``int``, ``bool``,
buffers (``Doubles``, ``Integers``, ``Bytes``), records by their names, and ``None`` of what returns nothing.
"""

from __future__ import annotations

import json
import math

SCALARS = {"float": "double", "int": "long long", "bool": "int"}
BUFFERS = {"Doubles": "float", "Integers": "int", "Bytes": "int"}
_POINTERS = {"Doubles": "double *", "Integers": "long long *", "Bytes": "signed char *"}


class C:
    """C99: records are structs, lent by their address, and a door takes the fields of records of buffers."""

    prologue = """\
/* Translated from Python by tools/translate.py. */
#include <math.h>
#include <setjmp.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#ifdef _WIN32
#define EXPORTED __declspec(dllexport)
#define set_mark setjmp
#define go_back longjmp
#else
#define EXPORTED __attribute__((visibility("default")))
#define set_mark _setjmp /* without the signals that are held off, which takes a call of the system */
#define go_back _longjmp
#endif

/* A call holds no lock of Python's, and asks Python now and then whether it shall go on: that is where
   Python handles signals. An exception that it raises ends the call. */
#define TURNS 32 /* of the outer loops, between two looks at the clock */
#define PATIENCE 0.05 /* [s] between two questions */

struct Call {
    struct Call *outer;
    void *thread;
    double asked;
    jmp_buf begin;
};
static struct {
    void *(*release)(void);
    void (*acquire)(void *);
    void *(*ask)(void *);
    void (*drop)(void *);
    void *question;
} python;
static _Thread_local struct Call *running;
static _Thread_local int turns;

EXPORTED void vibro_listen(void *(*release)(void), void (*acquire)(void *), void *(*ask)(void *),
                           void (*drop)(void *), void *question) {
    python.release = release;
    python.acquire = acquire;
    python.ask = ask;
    python.drop = drop;
    python.question = question;
}
static double seconds(void) {
    struct timespec now;
    timespec_get(&now, TIME_UTC);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}
static void enter(struct Call *call) {
    call->outer = running;
    call->asked = seconds();
    running = call;
    turns = TURNS;
    if (python.ask) call->thread = python.release();
}
static void leave(struct Call *call) {
    if (python.ask) python.acquire(call->thread);
    running = call->outer;
}
static __attribute__((noinline, cold)) void listen(void) {
    struct Call *call = running;
    turns = TURNS;
    if (!python.ask || fabs(seconds() - call->asked) < PATIENCE) return;
    python.acquire(call->thread);
    void *answer = python.ask(python.question);
    if (!answer) {
        running = call->outer;
        go_back(call->begin, 1);
    }
    python.drop(answer);
    running = call;
    call->thread = python.release();
    call->asked = seconds();
}

static inline double float_min(double a, double b) { return b < a ? b : a; }
static inline double float_max(double a, double b) { return b > a ? b : a; }
static inline long long int_min(long long a, long long b) { return b < a ? b : a; }
static inline long long int_max(long long a, long long b) { return b > a ? b : a; }
/* C rounds quotients towards 0, Python downwards. */
static inline long long floor_div(long long a, long long b) {
    return a / b - (a % b != 0 && (a < 0) != (b < 0));
}
static inline long long floor_mod(long long a, long long b) {
    long long rest = a % b;
    return rest != 0 && (rest < 0) != (b < 0) ? rest + b : rest;
}
"""
    # Names of Python that are words of the language.
    reserved = frozenset({
        "auto", "case", "char", "const", "default", "do", "double", "enum", "extern", "goto",
        "inline", "long", "register", "restrict", "short", "signed", "sizeof", "static", "struct",
        "switch", "typedef", "union", "unsigned", "void", "volatile",
    })  # fmt: skip

    def type(self, kind: str) -> str:
        """Spell a type."""
        return "void" if kind == "None" else SCALARS.get(kind) or _POINTERS.get(kind) or f"struct {kind}"

    def known(self, text: str) -> str:
        """Say of which source this is."""
        return f'EXPORTED const char *vibro_sources(void) {{ return "{text}"; }}\n'

    def record_type(self, name: str, fields: dict[str, str]) -> str:
        """Declare a record."""
        return f"struct {name} {{ {' '.join(f'{self.type(k)} {f};' for f, k in fields.items())} }};"

    def record(self, name: str, values: dict[str, str]) -> str:
        """Make a record."""
        return f"(struct {name}){{{', '.join(f'.{f} = {v}' for f, v in values.items())}}}"

    def replacing(self, name: str, record: str, fields: dict[str, str], changed: list[str]) -> str:
        """Write the function that replaces some fields of a record."""
        arguments = "".join(f", {self.type(fields[f])} {f}" for f in changed)
        changes = "".join(f" record.{f} = {f};" for f in changed)
        head = f"static inline struct {record} {name}(struct {record} record{arguments})"
        return f"{head} {{{changes} return record; }}"

    def lent(self, name: str) -> str:
        """Read a record that was lent."""
        return f"(*{name})"

    def lend(self, text: str, kind: str, *, has_place: bool) -> str:
        """Lend a record: one that is no variable, or field of one, is put into a place of its own."""
        return f"&{text}" if has_place else f"(struct {kind}[1]){{{text}}}"

    def head(
        self, name: str, arguments: dict[str, str], lent: set[str], changed: set[str], result: str
    ) -> str:
        """Write the head of a function; records are lent, and of those that are changed copies are made."""
        heads = [
            f"const {self.type(k)} *{a}{'__lent' * (a in changed)}" if a in lent else f"{self.type(k)} {a}"
            for a, k in arguments.items()
        ]
        return f"static {self.type(result)} {name}({', '.join(heads) or 'void'})"

    def header(self, head: str, *, is_door: bool) -> list[str]:
        """Announce a function; one with a way back into it is optimized less, and so a door stays apart."""
        return [f"{head}{' __attribute__((noinline))' * is_door};"]

    def declared(self, variables: dict[str, str], changed: dict[str, str]) -> list[str]:
        """Declare the variables of a function, and copies of records that it changes."""
        lines = [f"{self.type(k)} {a};" for a, k in variables.items()]
        return lines + [f"{self.type(k)} {a} = *{a}__lent;" for a, k in sorted(changed.items())]

    def room(self, name: str, kind: str, length: int) -> list[str]:
        """Declare the room of an array that lives as long as its function runs."""
        return [f"{SCALARS[BUFFERS[kind]]} {name}__room[{length}];"]

    def cleared(self, name: str, kind: str, length: int) -> list[str]:
        """Fill it with zeros."""
        return [f"memset({name}__room, 0, sizeof {name}__room);", f"{name} = {name}__room;"]

    def local(self, name: str, kind: str, text: str) -> str:
        """Keep a value in a block."""
        return f"{self.type(kind)} {name} = {text};"

    def loop(self, counter: str, low: str, end: str, high: str, step: str) -> str:
        """Begin a loop over whole numbers."""
        return f"for (long long {counter} = {low}, {end} = {high}; {counter} < {end}; {counter} += {step}) {{"

    def listens(self) -> list[str]:
        """Count a turn of a loop that may last, and listen to Python now and then."""
        return ["if (__builtin_expect(--turns < 0, 0)) listen();"]

    def nothing(self, kind: str) -> str:
        """Write a buffer of nothing."""
        return f"(({_POINTERS[kind]})0)"

    def literal(self, value: float) -> str:
        """Write a number."""
        if isinstance(value, bool):
            return str(int(value))
        if isinstance(value, int):
            return f"{value}LL"
        if math.isfinite(value):
            return repr(value)
        return f"{'-' * (value < 0.0)}(double){'NAN' if math.isnan(value) else 'INFINITY'}"

    def cast(self, text: str, kind: str, to: str) -> str:
        """Convert a number."""
        return f"(({SCALARS[to]})({text}))"

    def dividend(self, text: str) -> str:
        """Write a whole number whose quotient is none."""
        return f"(double){text}"

    def size(self, text: str, kind: str) -> str:
        """Write an absolute value."""
        return f"({'fabs' if kind == 'float' else 'llabs'}({text}))"

    def test(self, name: str, text: str) -> str:
        """Ask ``isnan``, ``isinf`` or ``isfinite``, which may answer with any number but 0."""
        return f"({name}({text}) != 0)"

    def whole(self, text: str) -> str:
        """Take the result of an operation for a whole number: there is no -0 among them."""
        return text

    def as_int(self, text: str) -> str:
        """Take a truth value for a whole number."""
        return text

    def door(
        self,
        name: str,
        inside: str,
        arguments: tuple[str, ...],
        records: dict[str, dict[str, str]],
        result: str,
    ) -> str:
        """Export a function; a record of buffers is handed over field by field."""
        heads, values = [], []
        for i, kind in enumerate(arguments):
            if kind in records:
                fields = [(f"a{i}_{f}", k) for f, k in records[kind].items()]
                heads += [f"{self.type(k)} {f}" for f, k in fields]
                values.append(f"&(struct {kind}){{{', '.join(f for f, _ in fields)}}}")
            else:
                heads.append(f"{self.type(kind)} a{i}")
                values.append(f"a{i}")
        call, taken, given, failed = f"{inside}({', '.join(values)});", "", "return;", "return;"
        if result != "None":
            taken, given, failed = f"{self.type(result)} result = ", "return result;", "return 0;"
        lines = [
            "struct Call here;",
            "enter(&here);",
            f"if (set_mark(here.begin)) {failed}",
            f"{taken}{call}",
            "leave(&here);",
            given,
        ]
        head = f"EXPORTED {self.type(result)} vibro_{name}({', '.join(heads)})"
        return "\n".join([f"{head} {{", *(f"    {line}" for line in lines), "}"])


class JavaScript(C):
    """JavaScript: records are objects that nobody changes, buffers typed arrays.

    All numbers are doubles. Whole ones are exact up to 2^53: codes of long patterns are not.
    """

    prologue = """\
// Translated from Python by tools/translate.py.
"use strict";
const { sin, cos, tan, asin, acos, atan, atan2, sqrt, floor, ceil, log, exp } = Math;
const float_min = (a, b) => (b < a ? b : a), float_max = (a, b) => (b > a ? b : a);
const int_min = float_min, int_max = float_max;
const floor_div = (a, b) => floor(a / b) + 0, floor_mod = (a, b) => a - b * floor(a / b) + 0;  // + 0: no -0
const isnan = Number.isNaN, isfinite = Number.isFinite, isinf = (x) => Math.abs(x) === Infinity;
const copysign = (a, b) => (b < 0 || Object.is(b, -0) ? -Math.abs(a) : Math.abs(a));
// Rounded to the nearest quotient, to the even one of two, as C does.
function remainder(x, y) {
    const size = Math.abs(y), half = 0.5 * size;
    let rest = Math.abs(x % (size + size));
    if (rest > half) { rest -= size; if (rest >= half) rest -= size; }
    return copysign(1, x) * rest;
}
"""
    reserved = frozenset({
        "arguments", "await", "case", "catch", "const", "debugger", "default", "delete", "do", "enum",
        "eval", "export", "extends", "final", "function", "implements", "in", "instanceof",
        "interface", "let", "new", "null", "package", "private", "protected", "public", "static",
        "super", "switch", "this", "throw", "true", "typeof", "undefined", "var", "void",
    })  # fmt: skip

    def known(self, text: str) -> str:
        return f'exports.sources = "{text}";\n'

    def record_type(self, name: str, fields: dict[str, str]) -> str:
        return f"// {name}: {', '.join(fields)}"

    def record(self, name: str, values: dict[str, str]) -> str:
        return f"({{{', '.join(f'{f}: {v}' for f, v in values.items())}}})"

    def replacing(self, name: str, record: str, fields: dict[str, str], changed: list[str]) -> str:
        values = {f: f if f in changed else f"record.{f}" for f in fields}
        return f"const {name} = (record, {', '.join(changed)}) => {self.record(record, values)};"

    def lent(self, name: str) -> str:
        return name

    def lend(self, text: str, kind: str, *, has_place: bool) -> str:
        return text

    def head(
        self, name: str, arguments: dict[str, str], lent: set[str], changed: set[str], result: str
    ) -> str:
        return f"function {name}({', '.join(arguments)})"

    def header(self, head: str, *, is_door: bool) -> list[str]:
        return []

    def declared(self, variables: dict[str, str], changed: dict[str, str]) -> list[str]:
        return [f"let {a}{' = 0' * (k in SCALARS)};" for a, k in variables.items()]

    def room(self, name: str, kind: str, length: int) -> list[str]:
        return []

    def cleared(self, name: str, kind: str, length: int) -> list[str]:
        return [f"{name} = new Float64Array({length});"]

    def local(self, name: str, kind: str, text: str) -> str:
        return f"const {name} = {text};"

    def loop(self, counter: str, low: str, end: str, high: str, step: str) -> str:
        return f"for (let {counter} = {low}, {end} = {high}; {counter} < {end}; {counter} += {step}) {{"

    def listens(self) -> list[str]:
        return []

    def nothing(self, kind: str) -> str:
        return "null"

    def literal(self, value: float) -> str:
        if isinstance(value, bool):
            return str(value).lower()
        if isinstance(value, int) or math.isfinite(value):
            return repr(value)
        return f"{'-' * (value < 0.0)}{'NaN' if math.isnan(value) else 'Infinity'}"

    def cast(self, text: str, kind: str, to: str) -> str:
        # + 0, since whole numbers have no -0, and truth values are no numbers yet
        return (
            f"(Math.trunc({text}) + 0)"
            if (kind, to) in (("float", "int"), ("whole", "int"))
            else f"({text} + 0)"
        )

    def dividend(self, text: str) -> str:
        return text

    def size(self, text: str, kind: str) -> str:
        return f"Math.abs({text})"

    def test(self, name: str, text: str) -> str:
        return f"{name}({text})"

    def whole(self, text: str) -> str:
        return f"({text} + 0)"

    as_int = whole

    def door(
        self,
        name: str,
        inside: str,
        arguments: tuple[str, ...],
        records: dict[str, dict[str, str]],
        result: str,
    ) -> str:
        takes = json.dumps([[*records[kind]] if kind in records else None for kind in arguments])
        return f"exports.{name} = {inside};\n{inside}.takes = {takes};  // fields of each argument"
