"""The page's scripts in node, with the constants and quantities that the page's JSON gives them."""

from __future__ import annotations

import json
import math
import subprocess
from pathlib import Path
from typing import Any

from helpers.node_doors import SCRIPT, node

from vibro import Regime, Status
from vibro.core import codes, numbers
from vibro.quantities import QUANTITIES

STATIC = Path(SCRIPT).parents[1] / "explore" / "static"
_NUMBERS = (
    "FIELDS", "LINE", "ELLIPSE", "HARMONICS", "PIECES", "ROOM", "MIXES", "BODIES", "MOST_HOPS",
    "MOST_BOUNCES", "LONGEST_CYCLE",
)  # fmt: skip
KNOWN = {
    **{name: getattr(numbers, name) for name in _NUMBERS},
    "IRREGULAR": codes.IRREGULAR,
    "LETTERS": codes.LETTERS,
    "FLIGHT_NOT_MODELLED": int(Status.FLIGHT_NOT_MODELLED),
    "Status": {status.name: int(status) for status in Status},
    "Regime": {regime.name: int(regime) for regime in Regime},
    "answered": [int(status) for status in Status if status.answered],
}
UNITS = {
    name: {
        "per_si": quantity.kind.per_si,
        "si": quantity.kind.si,
        "default": quantity.default,
        "low": quantity.allowed.low,
        "high": quantity.allowed.high,
    }
    for name, quantity in QUANTITIES.items()
}
# JSON has no infinities and no NaN: they travel as texts.
_HOST = """
const fs = require("fs");
const odd = { nan: NaN, inf: Infinity, "-inf": -Infinity };
const read = (_, x) => (typeof x === "string" && x in odd ? odd[x] : x);
const written = (_, x) => {
  if (ArrayBuffer.isView(x)) return Array.from(x);
  if (typeof x !== "number" || Number.isFinite(x)) return x;
  return Number.isNaN(x) ? "nan" : x > 0 ? "inf" : "-inf";
};
const given = JSON.parse(fs.readFileSync(0, "utf8"), read);
const { engineOf } = require(given.static + "/engine.js");
const scenes = require(given.static + "/scenes.js");
const engine = engineOf(require(given.solver), given.known);
const data = { quantities: given.units };
process.stdout.write(JSON.stringify(run(given.asked), written));
"""


def spelt(value: Any) -> Any:
    """Spell infinities and NaN as texts, all through."""
    if isinstance(value, dict):
        return {key: spelt(part) for key, part in value.items()}
    if isinstance(value, list | tuple):
        return [spelt(part) for part in value]
    return str(value) if isinstance(value, float) and not math.isfinite(value) else value


def in_scripts(function: str, asked: Any) -> Any:
    """Call a function of JavaScript, ``run(asked)``, beside ``engine``, ``scenes`` and ``data``."""
    given = {"static": str(STATIC), "solver": str(SCRIPT), "known": KNOWN, "units": UNITS, "asked": asked}
    done = subprocess.run(
        [node(), "-e", function + _HOST], input=json.dumps(spelt(given)), capture_output=True, text=True
    )
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)
