"""Translate the solver, plain typed Python, into C or JavaScript.

The solver is written once, in Python that uses numbers, records (``NamedTuple``) and buffers alone, and
nothing but ``math``. Its annotations say all that a C compiler has to know, so that nothing is declared
twice: functions become static functions, records structs, and constants of modules literals. Every function
that the module ``loop`` lists in ``DOORS`` is exported, with the fields of records of buffers as arguments
of their own.

What would not mean the same in C is refused: the types of variables are fixed, a whole number in place of a
float is written ``float(n)`` (-0 is no -0.0), variables are set on every way to where they are read, ``and``
and ``or`` join truth values, what one operand writes no other one reads, and there are no exceptions. What
raises in Python must not be reachable: a division by zero, an argument outside of a function's domain. Nor
must whole numbers beyond 64 bits, or a negative index.
"""

from __future__ import annotations

import ast
import copy
import functools
import hashlib
import math
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

sys.path.insert(0, str(Path(__file__).parent))

from dialects import BUFFERS, SCALARS, C, JavaScript  # noqa: F401

if TYPE_CHECKING:
    from collections.abc import Collection, Sequence

ARRAYS = {"doubles": "Doubles", "integers": "Integers"}  # by the functions that make them
_LOOP = "loop"
_NO_EFFECT, _READS, _FILLS = range(3)  # of functions on buffers
_SHORT = 4  # loops in each other that last a few milliseconds
_NUMBERS = {"float", "int", "bool", "whole"}
_FUNCTIONS = {"sin", "cos", "tan", "asin", "acos", "atan", "atan2", "sqrt", "floor", "ceil", "copysign",
              "remainder", "log", "exp"}  # fmt: skip
_TESTS = {"isnan", "isinf", "isfinite"}
_BINARY = {ast.Add: "+", ast.Sub: "-", ast.Mult: "*", ast.Div: "/", ast.BitAnd: "&"}
_OF_WHOLE = {ast.FloorDiv: "floor_div", ast.Mod: "floor_mod", ast.BitAnd: ""}
_COMPARISONS = {ast.Lt: "<", ast.LtE: "<=", ast.Gt: ">", ast.GtE: ">=", ast.Eq: "==", ast.NotEq: "!="}


class TranslationError(Exception):
    """A statement that has no translation."""


class Signature(NamedTuple):
    """A function: its name in C, types of its arguments and its result, effect on buffers, depth of loops."""

    name: str
    arguments: tuple[str, ...]
    result: str
    effect: int
    depth: int


class Template(NamedTuple):
    """A function that takes functions: translated once for each that are passed.

    ``variables`` are the module's variables of types.
    """

    module: str
    names: dict[str, Any]
    node: ast.FunctionDef
    variables: set[str]
    effect: int
    depth: int


class Value(NamedTuple):
    """An expression in C, and its type in Python.

    What ``math.floor`` returns is ``whole``: whole in Python, a double in C.
    """

    text: str
    kind: str


def sources(folder: Path) -> list[Path]:
    """List the solver's modules, each after those that it imports."""
    order: list[Path] = []

    def visit(name: str) -> None:
        path = folder / f"{name}.py"
        if path in order:
            return
        for node in ast.parse(path.read_text("utf-8")).body:
            if isinstance(node, ast.ImportFrom) and (node.module or "").startswith("vibro.core."):
                visit(str(node.module).rpartition(".")[2])
        order.append(path)

    visit(_LOOP)
    return order


def digest(paths: list[Path]) -> str:
    """Return what tells the texts of modules from any others."""
    whole = hashlib.sha256()
    for path in sorted(paths):
        whole.update(path.name.encode() + b"\0" + path.read_bytes() + b"\0")
    return whole.hexdigest()


def translate(folder: Path, dialect: C | None = None) -> str:
    """Translate the modules that lie in a folder, into C if no dialect is given."""
    paths, to = sources(folder), dialect or C()
    program = _Program(to)
    for path in paths:
        program.add(path.stem, ast.parse(path.read_text("utf-8")))
    known = "\\n".join([digest(paths), *sorted(path.name for path in paths)])
    return "\n".join([to.prologue, *program.types, *program.headers, *program.bodies, to.known(known)])


class _Program:
    """What has been translated so far."""

    def __init__(self, to: C) -> None:
        self.to = to
        self.types: list[str] = []
        self.headers: list[str] = []
        self.bodies: list[str] = []
        self.records: dict[str, dict[str, str]] = {}
        self.modules: dict[str, dict[str, Any]] = {}  # what the names of a module stand for
        self._tuples = set[str]()
        self._helpers = set[str]()
        self._specialized: dict[str, Signature] = {}

    def add(self, module: str, tree: ast.Module) -> None:
        """Translate one module, whose imports have been translated before."""
        tree = _Renamed(self.to.reserved).visit(tree)
        names: dict[str, Any] = {}
        self.modules[module] = names
        exported, variables = set[str](), set[str]()
        functions: list[ast.FunctionDef] = []
        for node in tree.body:
            match node:
                case ast.ImportFrom(module=str(path)) if path.startswith("vibro.core."):
                    theirs = self.modules[path.rpartition(".")[2]]
                    names |= {a.asname or a.name: theirs[a.name] for a in node.names if a.name in theirs}
                case ast.ClassDef(bases=[ast.Name("NamedTuple")]):
                    self._record(node)
                case ast.ClassDef(bases=[ast.Name("IntEnum")]):
                    names[node.name] = _members(node)
                case ast.FunctionDef() if any(_is_function(a.annotation) for a in node.args.args):
                    names[node.name] = Template(module, names, node, variables, _NO_EFFECT, 0)
                case ast.FunctionDef():
                    try:
                        kinds = tuple(self.kind(a.annotation) for a in node.args.args)
                        result = self.kind(node.returns)
                    except TranslationError:
                        continue  # for Python alone: a function that calls it is refused
                    names[node.name] = Signature(f"{module}_{node.name}", kinds, result, _NO_EFFECT, 0)
                    functions.append(node)
                case ast.Assign([ast.Name(name)], ast.Call(ast.Name("TypeVar"))):
                    variables.add(name)
                case ast.AnnAssign(target=ast.Name("DOORS"), value=ast.Tuple(elts=elements)):
                    exported = {ast.unparse(element) for element in elements}
                case ast.AnnAssign(target=ast.Name(name), annotation=ast.Name(kind)) if kind in BUFFERS:
                    names[name] = Value(self.to.nothing(kind), kind)  # of nothing
                case ast.AnnAssign(target=ast.Name(name), value=ast.expr() as value):
                    names[name] = _constant(names, value)
                case _:
                    pass  # what is for Python alone: nothing in a function can use it
        found = True
        while found:  # whoever calls a function has its effect
            found = False
            for node in (n for n in tree.body if isinstance(n, ast.FunctionDef) and n.name in names):
                now = {
                    "effect": _effect(node.body, names),
                    "depth": _depth(node.body, names, _variables(node)),
                }
                if any(getattr(names[node.name], key) != value for key, value in now.items()):
                    names[node.name], found = names[node.name]._replace(**now), True
        for function in functions:
            door = function.name in exported
            self._write(_Function(self, names, function, names[function.name], is_door=door))
        if module == _LOOP:
            for name in sorted(exported):
                door = names[name]
                self.bodies.append(self.to.door(name, door.name, door.arguments, self.records, door.result))

    def _write(self, function: _Function) -> None:
        self.headers += self.to.header(function.head, is_door=function.is_door)
        self.bodies.append("\n".join(function.lines))

    def specialized(self, template: Template, passed: dict[str, Signature]) -> Signature:
        """Translate a function for the functions that are passed to it, by the names of its arguments.

        Raises ``ValueError`` if these are not of the types that it takes.
        """
        name = "__".join([f"{template.module}_{template.node.name}", *(f.name for f in passed.values())])
        if name not in self._specialized:
            bound: dict[str, str] = {}  # what variables of types stand for
            others = []
            for argument in template.node.args.args:
                match argument.annotation:
                    case ast.Subscript(slice=ast.Tuple([ast.List(kinds), result])) if argument.arg in passed:
                        given = passed[argument.arg]
                        theirs = (*given.arguments, given.result)
                        for kind, is_ in zip([*kinds, result], theirs, strict=True):
                            if isinstance(kind, ast.Name) and kind.id in template.variables:
                                bound.setdefault(kind.id, is_)
                            if self.kind(kind, bound) != is_:
                                raise ValueError
                    case _:
                        others.append(argument)
            takes = tuple(self.kind(a.annotation, bound) for a in others)
            names = template.names | passed
            body, own = template.node.body, _variables(template.node) - passed.keys()
            does = _effect(body, names), _depth(body, names, own)
            signature = Signature(name, takes, self.kind(template.node.returns, bound), *does)
            self._specialized[name] = signature
            self._write(_Function(self, names, template.node, signature, others))
        return self._specialized[name]

    def kind(self, annotation: ast.expr | None, bound: dict[str, str] | None = None) -> str:
        """Name the type of an annotation; ``bound`` says what variables of types stand for."""
        match annotation:
            case None | ast.Constant(None):
                return "None"
            case ast.Name(name) if bound and name in bound:
                return bound[name]
            case ast.Name(name) if name in SCALARS or name in BUFFERS or name in self.records:
                return name
            case ast.Subscript(ast.Name("tuple"), ast.Tuple(elts)):
                return self.tuple_of([self.kind(e, bound) for e in elts])
        raise TranslationError(f"no type: {ast.unparse(annotation) if annotation else None}")

    def tuple_of(self, kinds: list[str]) -> str:
        """Declare the type of a tuple."""
        name = "tuple_" + "_".join(kinds)
        if name not in self.records:
            self._struct(name, {f"_{i}": kind for i, kind in enumerate(kinds)})
        return name

    def holds_buffers(self, kind: str) -> bool:
        """Return whether values of a type are, or have, buffers."""
        return kind in BUFFERS or any(map(self.holds_buffers, self.records.get(kind, {}).values()))

    def replacing(self, kind: str, fields: list[str]) -> str:
        """Write the function that replaces some fields of a record."""
        name = f"{kind}_with_{'_'.join(fields)}"
        if name not in self._helpers:
            self._helpers.add(name)
            self.headers.append(self.to.replacing(name, kind, self.records[kind], fields))
        return name

    def _record(self, node: ast.ClassDef) -> None:
        if node.name in self.records:
            raise TranslationError(f"two records are called {node.name}")
        fields = {}
        for field in node.body:
            if isinstance(field, ast.AnnAssign) and isinstance(field.target, ast.Name):
                fields[field.target.id] = self.kind(field.annotation)
        self._struct(node.name, fields)

    def _struct(self, name: str, fields: dict[str, str]) -> None:
        self.records[name] = fields
        self.types.append(self.to.record_type(name, fields))


class _Renamed(ast.NodeTransformer):
    """Renames what the other language could not call so."""

    def __init__(self, reserved: frozenset[str]) -> None:
        self._reserved = reserved

    def _safe(self, name: str) -> str:
        return f"{name}_" if name in self._reserved else name

    def visit_Name(self, node: ast.Name) -> ast.Name:
        """Rename a variable or the name of a field."""
        node.id = self._safe(node.id)
        return node

    def visit_arg(self, node: ast.arg) -> ast.arg:
        """Rename an argument."""
        self.generic_visit(node)
        node.arg = self._safe(node.arg)
        return node

    def visit_keyword(self, node: ast.keyword) -> ast.keyword:
        """Rename a field that is set."""
        self.generic_visit(node)
        node.arg = self._safe(node.arg or "")
        return node

    def visit_Attribute(self, node: ast.Attribute) -> ast.Attribute:
        """Rename a field that is read."""
        self.generic_visit(node)
        node.attr = self._safe(node.attr)
        return node


def _members(node: ast.ClassDef) -> dict[str, int]:
    members = {}
    for line in node.body:
        match line:
            case ast.Assign(targets=[ast.Name(name)], value=value):
                members[name] = int(ast.literal_eval(value))
    return members


def _constant(names: dict[str, Any], value: ast.expr) -> Any:
    """Evaluate a constant of a module; anything but a number is for Python alone."""
    known = {name: x for name, x in names.items() if isinstance(x, int | float)}
    try:
        code = compile(ast.Expression(value), "<constant>", "eval")
        number = eval(code, {"__builtins__": {}, "math": math, **known})
    except NameError:
        return None
    return number if isinstance(number, int | float) else None


def _is_function(annotation: ast.expr | None) -> bool:
    match annotation:
        case ast.Subscript(ast.Name("Callable"), ast.Tuple([ast.List(), _])):
            return True
    return False


def _is_array(value: ast.expr) -> bool:
    return isinstance(value, ast.Call) and isinstance(value.func, ast.Name) and value.func.id in ARRAYS


def _both(one: frozenset[str] | None, other: frozenset[str] | None) -> frozenset[str] | None:
    """Return what is set where two ways meet."""
    return other if one is None else one if other is None else one & other


def _effect(nodes: Sequence[ast.AST], names: dict[str, Any]) -> int:
    """Return what a piece of a program does to buffers, by itself or by the functions that it names."""
    inside, own = [n for part in nodes for n in ast.walk(part)], set()
    for node in inside:
        match node:
            case ast.Assign([ast.Name(name)], value) if _is_array(value):
                own.add(name)
            case ast.Assign([ast.Tuple(targets)], ast.Tuple(values)) if all(map(_is_array, values)):
                own |= {target.id for target in targets if isinstance(target, ast.Name)}
    effect = _NO_EFFECT
    for node in inside:
        match node:
            case ast.Subscript(ast.Name(name)) if name in own:
                pass
            case ast.Subscript(ctx=ctx):
                effect = max(effect, _FILLS if isinstance(ctx, ast.Store) else _READS)
            case ast.Name(name):
                effect = max(effect, getattr(names.get(name), "effect", _NO_EFFECT))
    return effect


def _depth(nodes: Sequence[ast.AST], names: dict[str, Any], own: Collection[str] = ()) -> int:
    """Return how deep the loops of a piece of a program lie in each other, with those of what it names.

    ``own`` are its variables, which may be called as functions are.
    """
    depth = 0
    for node in nodes:
        loops = isinstance(node, ast.For | ast.While)
        if isinstance(node, ast.Name) and node.id not in own:
            depth = max(depth, getattr(names.get(node.id), "depth", 0))
        depth = max(depth, loops + _depth([*ast.iter_child_nodes(node)], names, own))
    return min(depth, _SHORT + 1)


def _variables(node: ast.FunctionDef) -> set[str]:
    inside = (n for n in ast.walk(node) if isinstance(n, ast.Name) and isinstance(n.ctx, ast.Store))
    return {n.id for n in inside} | {a.arg for a in node.args.args}


class _Function:
    """Translates one function."""

    def __init__(
        self,
        program: _Program,
        names: dict[str, Any],
        node: ast.FunctionDef,
        signature: Signature,
        arguments: list[ast.arg] | None = None,
        *,
        is_door: bool = False,
    ) -> None:
        self.is_door = is_door
        self._program, self._names, self._node, self._to = program, names, node, program.to
        self._result = signature.result
        given = node.args.args if arguments is None else arguments
        self._kinds = {a.arg: k for a, k in zip(given, signature.arguments, strict=True)}
        # Names that are set somewhere, and on every way to where we are; None where no way leads.
        self._stored = {
            n.id for n in ast.walk(node) if isinstance(n, ast.Name) and isinstance(n.ctx, ast.Store)
        }
        self._set: frozenset[str] | None = frozenset(self._kinds)
        self._breaks: list[list[frozenset[str] | None]] = []  # the same where each loop around is left
        self._rooms: list[str] = []
        if node.decorator_list or node.args.posonlyargs or node.args.kwonlyargs:
            raise self._refused(node, "no decorators, and arguments by position or name")
        if wrong := [name for name in sorted(self._stored | set(self._kinds)) if "__" in name]:
            raise self._refused(node, f"{wrong[0]}: names with __ are the translator's")
        # Records are lent by their address, since copies of them cost time; one that is changed is copied.
        lent = {a for a, k in self._kinds.items() if k in program.records}
        changed = lent & self._stored
        self._lent = lent - changed
        self.head = self._to.head(signature.name, self._kinds, lent, changed, signature.result)
        known = set(self._kinds)
        body = self._block(node.body, "    ")
        if self._result != "None" and self._is_reached():
            raise self._refused(node, "it may end without a result")
        variables = {a: k for a, k in self._kinds.items() if a not in known}
        copied = {a: self._kinds[a] for a in changed}
        declared = [f"    {line}" for line in [*self._to.declared(variables, copied), *self._rooms]]
        self.lines = [self.head, "{", *declared, *body, "}", ""]

    def _is_reached(self) -> bool:
        return self._set is not None

    def _refused(self, node: ast.AST, why: str) -> TranslationError:
        line = getattr(node, "lineno", 0)
        return TranslationError(f"{self._node.name}, line {line}: {why}: {ast.unparse(node)[:90]}")

    # ------------------------------------------------------------------ statements

    def _block(self, statements: list[ast.stmt], indent: str) -> list[str]:
        return [indent + line for node in statements for line in self._statement(node)]

    def _statement(self, node: ast.stmt) -> list[str]:
        match node:
            case ast.Expr(ast.Constant()) | ast.Pass():
                return []
            case ast.Expr(value):
                return [f"{self._value(value).text};"]
            case ast.Assign(targets=[target], value=value):
                return self._assign(target, value)
            case ast.AnnAssign(target=ast.Name(name), value=value):
                self._declare(node.target, name, self._program.kind(node.annotation))
                return [] if value is None else self._assign(node.target, value)
            case ast.AugAssign(target=target, op=op, value=value):
                now = copy.copy(target)
                now.ctx = ast.Load()
                changed = ast.BinOp(left=now, op=op, right=value)
                return self._assign(target, ast.copy_location(changed, node))
            case ast.Return(None) if self._result == "None":
                self._set = None
                return ["return;"]
            case ast.Return(value) if value is not None:
                line = f"return {self._converted(value, self._result)};"
                self._set = None
                return [line]
            case ast.If(test, body, orelse):
                lines = [f"if ({self._test(test)}) {{"]
                before = self._set
                lines += self._block(body, "    ")
                after, self._set = self._set, before
                if orelse:
                    lines += ["} else {", *self._block(orelse, "    ")]
                self._set = _both(after, self._set)
                return [*lines, "}"]
            case ast.While(test, body, []):
                head, endless = self._test(test), isinstance(test, ast.Constant) and test.value is True
                return [f"while ({head}) {{", *self._repeated(body, None if endless else self._set), "}"]
            case ast.For(ast.Name(name), ast.Call(ast.Name("range"), arguments), body, []):
                return self._loop(name, arguments, body)
            case ast.Break():
                self._breaks[-1].append(self._set)
                self._set = None
                return ["break;"]
            case ast.Continue():
                self._set = None
                return ["continue;"]
        raise self._refused(node, "no translation")

    def _repeated(self, body: list[ast.stmt], behind: frozenset[str] | None) -> list[str]:
        """Translate the body of a loop; ``behind`` is what is set where the loop's head ends it.

        The innermost loops, and those around them, take no time: they do not listen.
        """
        self._breaks.append([behind])
        lines = self._block(body, "    ")
        if self.is_door or _depth(body, self._names, self._stored | self._kinds.keys()) >= _SHORT:
            lines = [*(f"    {line}" for line in self._to.listens()), *lines]
        self._set = functools.reduce(_both, self._breaks.pop())
        return lines

    def _loop(self, name: str, arguments: list[ast.expr], body: list[ast.stmt]) -> list[str]:
        bounds = [self._converted(a, "int") for a in arguments]
        low, high = ("0", bounds[0]) if len(bounds) == 1 else bounds[:2]
        step = bounds[2] if len(bounds) == 3 else "1"
        if step.startswith(("0", "(")) or not step[0].isdigit():
            raise self._refused(arguments[-1], "no translation of a step that is not a positive number")
        counter, end, begin, before = f"{name}__count", f"{name}__end", [], self._set
        if name != "_":
            self._declare(self._node, name, "int")
            begin = [f"    {name} = {counter};"]
            self._sets(name)
        return [
            self._to.loop(counter, low, end, high, step),
            *begin,
            *self._repeated(body, before),
            "}",
        ]

    def _assign(self, target: ast.expr, value: ast.expr) -> list[str]:
        match target, value:
            case ast.Name(name), ast.Call(ast.Name(array), [ast.expr() as length]) if array in ARRAYS:
                return self._array(value, name, ARRAYS[array], _constant(self._names, length))
            case ast.Name(name), _:
                found = self._value(value, self._kinds.get(name, ""))
                kind = self._kinds.get(name, found.kind)
                self._fits(value, found.kind, kind)
                self._declare(target, name, kind)
                self._sets(name)
                return [f"{name} = {found.text};"]
            case ast.Subscript(slice=index), _:
                self._in_any_order(target, [index, value])
                place, found = self._value(target), self._value(value)
                self._fits(target, found.kind, place.kind)
                return [f"{place.text} = {found.text};"]
            case ast.Tuple(targets), _:
                return self._unpack(targets, value)
        raise self._refused(target, "no target")

    def _array(self, value: ast.expr, name: str, kind: str, length: Any) -> list[str]:
        """Make an array of a fixed length, all 0, that lives as long as the function runs."""
        if not isinstance(length, int) or self._breaks or name in self._kinds:
            raise self._refused(value, "an array has a constant length, a name of its own, and is in no loop")
        if self._program.holds_buffers(self._result):
            raise self._refused(value, "an array does not outlive its function, whose result may have it")
        self._declare(value, name, kind)
        self._sets(name)
        self._rooms += self._to.room(name, kind, length)
        return self._to.cleared(name, kind, length)

    def _unpack(self, targets: list[ast.expr], value: ast.expr) -> list[str]:
        """Assign a tuple: all of its values are known before the first is put down."""
        before = []
        if isinstance(value, ast.Tuple) and all(_is_array(v) for v in value.elts):
            pairs = zip(targets, value.elts, strict=False)
            return [line for one, room in pairs for line in self._assign(one, room)]
        if isinstance(value, ast.Tuple):
            values = [self._value(v) for v in value.elts]
        else:
            whole = self._value(value)
            before.append(self._to.local("all__", whole.kind, whole.text))
            fields = self._program.records.get(whole.kind, {})
            values = [Value(f"all__.{f}", k) for f, k in fields.items()]
        if len(values) != len(targets):
            raise self._refused(value, f"{len(targets)} targets")
        after = []
        for i, (target, v) in enumerate(zip(targets, values, strict=True)):
            if isinstance(target, ast.Name):
                if target.id == "_":
                    continue
                self._kinds.setdefault(target.id, v.kind)
                self._sets(target.id)
                place = self._name(target, target.id)
            else:
                place = self._value(target)
            self._fits(target, v.kind, place.kind)
            before.append(self._to.local(f"part__{i}", place.kind, v.text))
            after.append(f"{place.text} = part__{i};")
        return ["{", *("    " + line for line in before + after), "}"]

    def _sets(self, name: str) -> None:
        if self._set is not None:
            self._set |= {name}

    def _declare(self, node: ast.AST, name: str, kind: str) -> None:
        if kind == "whole":
            raise self._refused(node, "float(...) or int(...) of what floor or ceil return")
        if self._kinds.setdefault(name, kind) != kind:
            raise self._refused(node, f"{name} is {self._kinds[name]} and {kind}")

    # ------------------------------------------------------------------ expressions

    def _fits(self, node: ast.AST, kind: str, wanted: str) -> None:
        # a buffer of floats converts what is put into it
        element = wanted == "float" and isinstance(node, ast.Subscript) and isinstance(node.ctx, ast.Store)
        if kind != wanted and (kind, wanted) != ("bool", "int") and not (element and kind in _NUMBERS):
            raise self._refused(node, f"{kind} in place of {wanted}")

    def _converted(self, node: ast.expr, wanted: str) -> str:
        value = self._value(node, wanted)
        self._fits(node, value.kind, wanted)
        return self._to.as_int(value.text) if (value.kind, wanted) == ("bool", "int") else value.text

    def _test(self, node: ast.expr) -> str:
        return self._converted(node, "bool")

    def _in_any_order(self, node: ast.AST, parts: Sequence[ast.AST]) -> None:
        """Refuse parts that C evaluates in any order, where one fills a buffer and another has one too."""
        effects = [effect for part in parts if (effect := _effect([part], self._names)) != _NO_EFFECT]
        if _FILLS in effects and len(effects) > 1:
            raise self._refused(node, "one part fills a buffer that another may read")

    def _value(self, node: ast.expr, wanted: str = "") -> Value:
        if isinstance(node, ast.BinOp | ast.Compare | ast.Call | ast.Tuple):
            called = node.func if isinstance(node, ast.Call) and isinstance(node.func, ast.Name) else None
            self._in_any_order(node, [part for part in ast.iter_child_nodes(node) if part is not called])
        match node:
            case ast.Constant(value) if isinstance(value, int | float):
                if abs(value) >= 2**63 and isinstance(value, int):
                    raise self._refused(node, "more than 64 bits")
                return self._literal(value)
            case ast.Name(name):
                return self._name(node, name)
            case ast.Attribute(ast.Name(owner), member) if isinstance(self._names.get(owner), dict):
                return Value(str(self._field(node, self._names[owner], member)), "int")
            case ast.Attribute(value, member):
                record = self._value(value)
                fields = self._program.records.get(record.kind, {})
                return Value(f"{record.text}.{member}", self._field(node, fields, member))
            case ast.Subscript(ast.Name(name), index) if self._kinds.get(name) in BUFFERS:
                return Value(f"{name}[{self._index(index)}]", BUFFERS[self._kinds[name]])
            case ast.Subscript(ast.Attribute() as buffer, index):
                found = self._value(buffer)
                return Value(f"{found.text}[{self._index(index)}]", BUFFERS[found.kind])
            case ast.UnaryOp(ast.Not(), operand):
                return Value(f"!({self._test(operand)})", "bool")
            case ast.UnaryOp(ast.USub(), operand):
                one = self._value(operand)
                if one.kind not in ("int", "float"):
                    raise self._refused(node, f"no translation of minus {one.kind}")
                text = f"(-{one.text})"
                return Value(self._to.whole(text) if one.kind == "int" else text, one.kind)
            case ast.BoolOp(op, values):
                sign = " && " if isinstance(op, ast.And) else " || "
                return Value(f"({sign.join(self._test(v) for v in values)})", "bool")
            case ast.Compare(left, ops, comparators):
                if not {type(op) for op in ops} <= set(_COMPARISONS):
                    raise self._refused(node, "no translation")
                return self._comparison([left, *comparators], ops)
            case ast.BinOp(left, op, right):
                return self._operation(node, left, op, right)
            case ast.IfExp(test, body, orelse):
                one, two = self._value(body, wanted), self._value(orelse, wanted)
                self._fits(orelse, two.kind, one.kind)
                return Value(f"({self._test(test)} ? {one.text} : {two.text})", one.kind)
            case ast.Tuple(elts):
                kinds = list(self._program.records[wanted].values()) if wanted.startswith("tuple_") else []
                kinds = kinds if len(kinds) == len(elts) else [self._value(e).kind for e in elts]
                name = self._program.tuple_of(kinds)
                parts = [self._converted(e, k) for e, k in zip(elts, kinds, strict=True)]
                return Value(self._to.record(name, {f"_{i}": part for i, part in enumerate(parts)}), name)
            case ast.Call():
                return self._call(node)
        raise self._refused(node, "no translation")

    def _field(self, node: ast.expr, fields: dict[str, Any], name: str) -> Any:
        if name not in fields:
            raise self._refused(node, "no field")
        return fields[name]

    def _index(self, node: ast.expr) -> str:
        text = self._converted(node, "int")
        if text.startswith("(-"):
            raise self._refused(node, "a negative index counts from the end in Python alone")
        return text

    def _name(self, node: ast.expr, name: str) -> Value:
        if name in self._stored and self._set is not None and name not in self._set:
            raise self._refused(node, "not set on every way to here")
        if name in self._lent:
            return Value(self._to.lent(name), self._kinds[name])
        if name in self._kinds:
            return Value(name, self._kinds[name])
        number = self._names.get(name)
        if isinstance(number, int | float):
            return self._literal(number)
        if isinstance(number, Value):
            return number
        raise self._refused(node, "unknown")

    def _comparison(self, sides: list[ast.expr], ops: list[ast.cmpop]) -> Value:
        values = [self._value(side) for side in sides]
        for side, value in zip(sides, values, strict=True):
            if value.kind not in _NUMBERS:
                raise self._refused(side, f"no comparison of {value.kind}")
        for side in sides[1:-1]:
            if _effect([side], self._names) == _FILLS:
                raise self._refused(side, "it fills a buffer, and would be evaluated twice")
        parts = [
            f"({a.text} {_COMPARISONS[type(op)]} {b.text})"
            for a, op, b in zip(values, ops, values[1:], strict=False)
        ]
        return Value(parts[0] if len(parts) == 1 else f"({' && '.join(parts)})", "bool")

    def _operation(self, node: ast.expr, left: ast.expr, op: ast.operator, right: ast.expr) -> Value:
        one, two = self._value(left), self._value(right)
        kinds = {one.kind, two.kind}
        if not kinds <= _NUMBERS:
            raise self._refused(node, "no translation")
        if type(op) in _OF_WHOLE and not kinds <= {"int", "bool"}:
            raise self._refused(node, "for whole numbers alone")
        if helper := _OF_WHOLE.get(type(op)):
            return Value(f"{helper}({one.text}, {two.text})", "int")
        if type(op) not in _BINARY:
            raise self._refused(node, "no translation")
        kind = (
            "float" if "float" in kinds or isinstance(op, ast.Div) else "whole" if "whole" in kinds else "int"
        )
        dividend = (
            self._to.dividend(one.text) if isinstance(op, ast.Div) and one.kind != "float" else one.text
        )
        text = f"({dividend} {_BINARY[type(op)]} {two.text})"
        return Value(self._to.whole(text) if kind == "int" and isinstance(op, ast.Mult) else text, kind)

    def _call(self, node: ast.Call) -> Value:
        match node.func:
            case ast.Attribute(ast.Name("math"), "floor" | "ceil" as name):  # whole numbers have no -0
                return Value(f"({name}({self._converted(node.args[0], 'float')}) + 0.0)", "whole")
            case ast.Attribute(ast.Name("math"), name) if name in _FUNCTIONS:
                return Value(f"{name}({', '.join(self._converted(a, 'float') for a in node.args)})", "float")
            case ast.Attribute(ast.Name("math"), name) if name in _TESTS:
                return Value(self._to.test(name, self._converted(node.args[0], "float")), "bool")
            case ast.Attribute(record, "_replace"):
                whole = self._value(record)
                kinds = self._program.records.get(whole.kind, {})
                given = [
                    (str(k.arg), self._converted(k.value, self._field(node, kinds, str(k.arg))))
                    for k in node.keywords
                ]
                helper = self._program.replacing(whole.kind, [f for f, _ in given])
                return Value(f"{helper}({', '.join([whole.text, *(v for _, v in given)])})", whole.kind)
            case ast.Name("abs" | "int" | "float" as name) if len(node.args) == 1:
                value = self._value(node.args[0])
                kind = value.kind if name == "abs" else name
                if value.kind not in _NUMBERS or kind not in ("int", "float"):
                    raise self._refused(node, f"no translation of {value.kind}")
                if name == "abs":
                    return Value(self._to.size(value.text, kind), kind)
                return Value(self._to.cast(value.text, value.kind, kind), kind)
            case ast.Name("min" | "max" as name) if len(node.args) > 1 and not node.keywords:
                values = [self._value(a) for a in node.args]
                kind = values[0].kind
                if kind not in ("int", "float") or any(v.kind != kind for v in values):
                    raise self._refused(node, "no translation of numbers of two types")
                text = values[0].text
                for value in values[1:]:
                    text = f"{kind}_{name}({text}, {value.text})"
                return Value(text, kind)
            case ast.Name(name) if name in self._program.records:
                return self._record(node, name)
            case ast.Name(name) if isinstance(self._names.get(name), Signature | Template):
                signature, args = self._called(node, self._names[name])
                if len(args) != len(signature.arguments) or node.keywords:
                    raise self._refused(node, f"takes {len(signature.arguments)} arguments by position")
                pairs = zip(args, signature.arguments, strict=True)
                arguments = ", ".join(self._argument(a, k) for a, k in pairs)
                return Value(f"{signature.name}({arguments})", signature.result)
        raise self._refused(node, "no translation")

    def _called(self, node: ast.Call, called: Signature | Template) -> tuple[Signature, list[ast.expr]]:
        """Return what is called, made for the functions among its arguments, and the other arguments."""
        if isinstance(called, Signature):
            return called, node.args
        passed, others = {}, []
        for argument, place in zip(node.args, called.node.args.args, strict=False):
            if not _is_function(place.annotation):
                others.append(argument)
            elif isinstance(argument, ast.Name) and isinstance(f := self._names.get(argument.id), Signature):
                passed[place.arg] = f
            else:
                raise self._refused(argument, "no function of the solver")
        try:
            return self._program.specialized(called, passed), others
        except ValueError:
            raise self._refused(node, "a function of other arguments, or another result") from None

    def _argument(self, node: ast.expr, kind: str) -> str:
        # a record that is no variable, or field of one, is put into a place of its own
        value, owner = self._converted(node, kind), node
        if kind not in self._program.records:
            return value
        while isinstance(owner, ast.Attribute):
            owner = owner.value
        return self._to.lend(value, kind, has_place=isinstance(owner, ast.Name))

    def _record(self, node: ast.Call, name: str) -> Value:
        fields = self._program.records[name]
        given = dict(zip(fields, node.args, strict=False)) | {str(k.arg): k.value for k in node.keywords}
        if set(given) != set(fields) or len(node.args) + len(node.keywords) > len(fields):
            raise self._refused(node, f"takes {', '.join(fields)}")
        return Value(
            self._to.record(name, {f: self._converted(given[f], k) for f, k in fields.items()}), name
        )

    def _literal(self, value: float) -> Value:
        kind = "bool" if isinstance(value, bool) else "int" if isinstance(value, int) else "float"
        text = self._to.literal(value if kind == "bool" else int(value) if kind == "int" else value)
        return Value(text if text[0].isdigit() else f"({text})", kind)
