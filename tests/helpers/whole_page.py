"""The page's modules in node: beside the solver's script, as in the page, with the page's own data."""

from __future__ import annotations

import json
import shutil
import subprocess
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Any

from helpers.node_doors import node

from vibro.explore import page
from vibro.explore.scenes import scene_data
from vibro.quantities import QUANTITIES

if TYPE_CHECKING:
    from collections.abc import Sequence

    from vibro.sweeps.request import Request

STATIC = Path(page.__file__).with_name("static")
_EVERYTHING = {"given": {"values": dict.fromkeys(QUANTITIES)}}  # a page has those of its scenes alone
# JSON has no infinities and no NaN, but Python's reader takes them.
_HOST = """
import { readFileSync } from "node:fs";
import { runInThisContext } from "node:vm";
const { data, solver, modules, asked } = JSON.parse(readFileSync(0, "utf-8"));
runInThisContext(solver);
const page = {};
for (const name of modules) Object.assign(page, await import(`./${name}.js`));
Object.assign(page, { data, engine: engineOf(exports, data.known) }); // that of state.js is of a document
const { run } = await import("./run.js");
const written = (_, x) => {
  if (ArrayBuffer.isView(x)) return Array.from(x);
  return typeof x === "number" && !Number.isFinite(x) ? `@${x}` : x;
};
const answer = JSON.stringify(await run(page, asked), written) ?? "null";
process.stdout.write(answer.replace(/"@(NaN|-?Infinity)"/g, "$1"));
"""


def in_modules(script: str, asked: Any = None, scenes: Sequence[Request | None] = (None,)) -> Any:
    """Run a module's ``run(page, asked)``; ``page`` has ``data``, ``engine`` and what modules export."""
    own = [scene_data(scene) for scene in scenes]
    given = {
        "data": page.page_data([*own, _EVERYTHING]) | {"scenes": own},
        "solver": page.solver_script(),
        # main.js starts the page
        "modules": [path.stem for path in STATIC.glob("*.js") if path.stem not in ("main", *page.SOLVER)],
        "asked": asked,
    }
    with TemporaryDirectory() as made:
        folder = Path(made)
        shutil.copytree(STATIC, folder, dirs_exist_ok=True)
        for name, text in {"package.json": '{"type": "module"}', "host.js": _HOST, "run.js": script}.items():
            (folder / name).write_text(text, encoding="utf-8")
        done = subprocess.run(
            [node(), str(folder / "host.js")], input=page._json(given), capture_output=True, encoding="utf-8"
        )
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)
