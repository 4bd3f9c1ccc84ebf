"""The page of ``vibro explore``: one HTML file that holds scenes, the solver in JavaScript and its script."""

from __future__ import annotations

import hashlib
import json
import os
import re
from base64 import b64encode
from html import escape
from importlib.resources import files
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from vibro.answers.scene import page_texts
from vibro.core import codes, numbers
from vibro.core.codes import Regime, Status
from vibro.errors import FileError, InputError, shown
from vibro.explore.controls import CONTROLS, DRIVES, PRESETS, VIEWS
from vibro.explore.looks import HATCHES, looks
from vibro.explore.scenes import USUAL, request_of_scene, scene_data
from vibro.plots.style import REGIME_COLOURS, UNIT_SIGNS, visible
from vibro.quantities import LEAST_SPEED, LOAD, QUANTITIES
from vibro.reals import shielded
from vibro.results.operating import MACHINE_RESULTS
from vibro.results.steady import RESULTS
from vibro.scene import Scene
from vibro.sweeps.whole import request_of_call
from vibro.version import __version__

if TYPE_CHECKING:
    from collections.abc import Sequence
    from os import PathLike

    from vibro.quantities import Quantity
    from vibro.sweeps.request import Request

#: Scripts of the solver, whose names are global in the page and in its workers, in their order.
SOLVER: Final = ("engine", "scenes", "worker")

_IMPORT: Final = re.compile(r'^import\b[^;"]*"\./(\w+)\.js";\n', re.MULTILINE)
_EXPORT: Final = re.compile(r"^export (?=(?:async )?function|const|let|class)", re.MULTILINE)
_COMMENT: Final = re.compile(r"^[ \t]*(?:/\*(?:[^*]|\*(?!/))*\*/[ \t]*\n|//.*\n)", re.MULTILINE)
_INDENT: Final = re.compile(r"^[ \t]+", re.MULTILINE)
_PLACE: Final = re.compile(r"<!--vibro (\w+)-->")
_TOKEN: Final = re.compile(r'"(?:[^"\\]|\\.)*"|-?Infinity|NaN')
_MARKUP: Final = re.compile(r"<(?=!--|/?script|/?style)", re.IGNORECASE)
_HEIGHT: Final = 820  # [px] of the page in a notebook


def page_text(requests: Sequence[Request | None] = (None,)) -> str:
    """Return the page as HTML, which needs no other file.

    Parameters
    ----------
    requests : sequence of Request or None
        Its scenes, in tabs if they are several; None is the nut of examples/safety_nut.toml.

    Raises
    ------
    FileError
        If the solver's script is missing.
    """
    scenes = [scene_data(request) for request in requests]
    title = ", ".join(scene["name"] for scene in scenes if scene["name"])
    parts = {
        "title": escape(f"{title} \N{EN DASH} vibro explore" if title else "vibro explore"),
        "style": _asset("style.css"),
        "data": _json(page_data(scenes)),
        "solver": solver_script(),
        "script": page_script(),
    }
    hashes = {name: f"'sha256-{_digest(parts[name])}'" for name in ("style", "solver", "script")}
    parts["policy"] = (
        f"default-src 'none'; script-src {hashes['solver']} {hashes['script']}; style-src {hashes['style']};"
        " img-src data: blob:; worker-src blob:; base-uri 'none'; form-action 'none'"
    )
    return _PLACE.sub(lambda place: parts[place[1]], _asset("page.html"))


def page_data(scenes: Sequence[dict[str, Any]]) -> dict[str, Any]:
    """Return what the script has to know, as JSON values; numbers may be infinite."""
    further = {name: None for scene in scenes if scene["given"] for name in scene["given"]["values"]}
    return {
        "version": __version__,
        "known": _known(),
        "quantities": {name: _quantity(QUANTITIES[name]) for name in (*CONTROLS, *further)}
        | {quantity.name: _quantity(quantity) for quantity in (LEAST_SPEED, LOAD)},
        "drives": {name: drive.data() for name, drive in DRIVES.items()},
        "presets": {name: preset._asdict() for name, preset in PRESETS.items()},
        "views": VIEWS,
        "regimes": [
            {"code": int(regime), "label": regime.label, "colour": REGIME_COLOURS.get(regime, "")}
            for regime in Regime
        ],
        "statuses": [
            {
                "code": int(status),
                "name": status.name,
                "label": status.label.replace("-", " "),
                "message": "" if status is Status.OK else status.message,
                "hatch": HATCHES.get(status, ""),
            }
            for status in Status
        ],
        "columns": {
            kind: [
                {"name": r.name, "column": r.column, "per_si": r.kind.per_si, "texts": r.texts}
                for r in results
                if not (r.on_request or r.of_starts)
            ]
            for kind, results in (("cycle", RESULTS), ("machine", MACHINE_RESULTS))
        },
        "looks": looks(),
        "texts": page_texts(),
        "scenes": scenes,
    }


def _known() -> dict[str, Any]:
    """Return the constants of the solver that its doors need, and the names of its codes."""
    sizes = {name: value for name, value in vars(numbers).items() if name.isupper() and name[0] != "_"}
    named = {kind.__name__: {code.name: int(code) for code in kind} for kind in (Status, Regime, codes.Mode)}
    return {
        **{name: value for name, value in sizes.items() if type(value) is int},
        **named,
        "IRREGULAR": codes.IRREGULAR,
        "SPELT_PATTERNS": codes.SPELT_PATTERNS,
        "LETTERS": codes.LETTERS,
        "PATTERNS": codes.PATTERNS,
        "answered": [int(status) for status in Status if status.answered],
    }


def symbol_of(quantity: Quantity) -> str:
    """Return the letter of a quantity: ``μ_s``."""
    from unicodedata import lookup

    return re.sub(
        r"\\(?:var)?([a-z]+)", lambda name: lookup(f"GREEK SMALL LETTER {name[1]}"), quantity.symbol
    )


def _quantity(quantity: Quantity) -> dict[str, Any]:
    """Describe a quantity: its names, units, ranges and slider."""
    kind, allowed = quantity.kind, quantity.allowed
    control = CONTROLS.get(quantity.name)
    own = {
        name: getattr(quantity, name) for name in ("column", "label", "unit", "default", "meaning", "order")
    }
    return {
        **own,
        **vars(allowed),
        "symbol": symbol_of(quantity),
        "sign": UNIT_SIGNS.get(quantity.unit, quantity.unit),
        "per_si": kind.per_si,
        "si": kind.si,
        "sizes": {unit: size.as_integer_ratio() for unit, size in kind.sizes.items()},
        "start": f"{USUAL.get(quantity.name, 1.0):g}",
        "usual": [quantity.usual.low, quantity.usual.high],
        "doubts": quantity.doubts,
        "options": quantity.options[0] if quantity.options else "",
        "control": control and control._asdict(),
    }


# ------------------------------------------------------------------------------
# The file: modules of the script joined, texts that cannot become markup, a policy.


def solver_script() -> str:
    """Return the solver, and what turns scenes into its numbers; each worker runs it too."""
    solver = _INDENT.sub("", _COMMENT.sub("", _solver_text()))
    parts = [_COMMENT.sub("", _asset(f"{name}.js")) for name in SOLVER]
    # Within a block the names of the solver are its own.
    return _safe("\n".join(['"use strict";', "const exports = {};", "{", solver, "}", *parts]))


def page_script() -> str:
    """Return the modules of the page as one, each after those that it imports: each name is there for all."""
    modules: dict[str, str] = {}
    _gather("main", modules)
    return _safe("\n".join(_EXPORT.sub("", _IMPORT.sub("", _COMMENT.sub("", x))) for x in modules.values()))


def _gather(name: str, modules: dict[str, str]) -> None:
    """Add a module to others by their names, after those that it imports and that are not there yet."""
    text = _asset(f"{name}.js")
    for other in _IMPORT.findall(text):
        if other not in modules:
            _gather(other, modules)
    modules[name] = text


def _solver_text() -> str:
    script = files("vibro.core") / "_solver.js"
    if not script.is_file():
        raise FileError(
            "the solver in JavaScript is missing", hint="install vibro again: installing makes it"
        )
    return script.read_text(encoding="utf-8")


def _asset(name: str) -> str:
    return (files("vibro.explore") / "static" / name).read_text(encoding="utf-8")


def _safe(script: str) -> str:
    """Return a script that ends where it ends: within strings, signs that begin markup are escaped."""
    return _MARKUP.sub(r"\\x3C", script)


def _json(data: dict[str, Any]) -> str:
    """Write data as JSON that can stand in an element: ASCII, and without a sign that begins markup."""
    beyond = {"Infinity": "1e999", "-Infinity": "-1e999", "NaN": "null"}  # as JSON.parse takes them
    text = json.dumps(data, separators=(",", ":"))
    return _TOKEN.sub(lambda token: beyond.get(token[0], token[0]), text).replace("<", "\\u003c")


def _digest(text: str) -> str:
    return b64encode(hashlib.sha256(text.encode()).digest()).decode()


# ------------------------------------------------------------------------------
# The page in a notebook.


class Page:
    """A page as ``vibro.page`` makes it; notebooks show it.

    Attributes
    ----------
    html : str
        The whole page.
    """

    def __init__(self, html: str, title: str) -> None:
        self.html, self._title = html, title

    def write(self, path: str | PathLike[str]) -> None:
        """Write the page to a file."""
        Path(path).write_text(self.html, encoding="utf-8")

    def _repr_html_(self) -> str:
        return (
            f'<iframe title="{escape(self._title)}" sandbox="allow-scripts allow-downloads" width="100%"'
            f' height="{_HEIGHT}" style="border: 0" srcdoc="{escape(self.html)}"></iframe>'
        )

    def __repr__(self) -> str:
        return f"<{self._title}, {len(self.html)} characters of HTML>"


@shielded
def page(scene: Scene | str | PathLike[str]) -> Page:
    """Make the page of ``vibro explore``: a map, sliders, the motion and all numbers, in one HTML file.

    Parameters
    ----------
    scene : Scene or path
        A single scene, or a scene file.

    Returns
    -------
    Page
        A notebook shows it. ``page.write(path)`` keeps it; it needs no other file, and no network.

    Raises
    ------
    InputError
        If it is no single scene.
    FileError
        If the file cannot be read.

    Examples
    --------
    >>> import vibro
    >>> page = vibro.page(vibro.Scene(amplitude=1e-3, frequency=15, drive_angle=0.35,
    ...                               static_friction=0.74, kinetic_friction=0.57))
    >>> page.html[:15]
    '<!doctype html>'
    """
    if isinstance(scene, Scene):
        request = request_of_scene(scene)
    elif isinstance(scene, str | os.PathLike):
        request = request_of_call(scene, {}, page)
    else:
        raise InputError(f"scene = {shown(scene)}: must be a vibro.Scene, or the path of a scene file")
    name = visible(request.name or "")
    return Page(page_text([request]), f"vibro explore: {name}" if name else "vibro explore")
