"""The page's modules in node: beside the solver's script, as in the page, with the page's own data."""

from __future__ import annotations

import json
import subprocess
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Any

from helpers.node_doors import node

from vibro.explore import page
from vibro.explore.scenes import scene_data

if TYPE_CHECKING:
    from collections.abc import Sequence

    from vibro.sweeps.request import Request

STATIC = Path(page.__file__).with_name("static")
#: What each run has: ``data``, and functions of the modules by name.
_HOST = """
import { readFileSync, writeFileSync } from "node:fs";
import { runInThisContext } from "node:vm";
const [, , solver, given, answer] = process.argv;
runInThisContext(readFileSync(solver, "utf-8"));
const { data, asked } = JSON.parse(readFileSync(given, "utf-8"));
const page = {};
for (const name of NAMES) Object.assign(page, await import(`./${name}.js`));
page.data = data; // that of state.js is of a document
const { run } = await import("./run.js");
const written = (_, x) => (ArrayBuffer.isView(x) ? Array.from(x) : x === Infinity ? 1e999 : x);
writeFileSync(answer, JSON.stringify(await run(page, asked), written) ?? "null");
"""
_MODULES = ("typed", "state", "draw", "contours", "scales", "jobs", "pool", "fields", "tables", "files")


def in_modules(script: str, asked: Any = None, scenes: Sequence[Request | None] = (None,)) -> Any:
    """Run a module's ``run(page, asked)``; numbers that are not finite come back as None."""
    data = page._json({"data": page.page_data([scene_data(scene) for scene in scenes]), "asked": asked})
    with TemporaryDirectory() as made:
        folder = Path(made)
        for path in STATIC.glob("*.js"):
            (folder / path.name).write_text(path.read_text(encoding="utf-8"), encoding="utf-8")
        texts = {
            "package.json": '{"type": "module"}',
            "host.js": _HOST.replace("NAMES", json.dumps(_MODULES)),
            "run.js": script,
            "solver.txt": page.solver_script(),
            "given.json": data,
        }
        for name, text in texts.items():
            (folder / name).write_text(text, encoding="utf-8")
        places = [str(folder / name) for name in ("host.js", "solver.txt", "given.json", "answer.json")]
        done = subprocess.run([node(), *places], capture_output=True, text=True, encoding="utf-8")
        assert done.returncode == 0, done.stderr
        return json.loads((folder / "answer.json").read_text(encoding="utf-8"))
