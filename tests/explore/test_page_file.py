"""The file of the page: what is in it, and that nothing that somebody gives becomes markup."""

from __future__ import annotations

import hashlib
import json
import math
import re
from base64 import b64decode, b64encode
from html.parser import HTMLParser
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from helpers.cases import each
from helpers.explored_scenes import FEEDER, GIVEN_DRIVES

import vibro
from vibro.core.codes import Regime, Status
from vibro.explore import page as pages
from vibro.explore.controls import CONTROLS
from vibro.explore.page import page_script, page_text, solver_script, symbol_of
from vibro.explore.scenes import scene_data
from vibro.quantities import QUANTITIES
from vibro.sweeps.whole import request_of_call

NUT = Path(__file__).parents[2] / "examples" / "safety_nut.toml"
MOST = 700_000  # characters of a page

HOSTILE = [
    "</script><script>alert(1)</script>",
    "<!--<script>",
    "<img src=x onerror=alert(1)>",
    "\"' onload='alert(1)",
    "]]>&lt;&#60;",
    "\u2028\u2029\x00\x1b[2J",
    "\ud800",
    "<!--vibro solver--><!--vibro data-->",
    "Infinity",
    "a" * 100_000,
]


class Parsed(HTMLParser):
    """Elements with their attributes, and the texts of some."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.elements: list[tuple[str, dict[str, str | None]]] = []
        self.texts: dict[str, str] = {}
        self._inside = ""
        self.feed(text)
        self.close()

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.elements.append((tag, dict(attrs)))
        self._inside = dict(attrs).get("id") or dict(attrs).get("type") or tag

    def handle_endtag(self, tag: str) -> None:
        self._inside = ""

    def handle_data(self, data: str) -> None:
        self.texts[self._inside] = self.texts.get(self._inside, "") + data

    @property
    def shape(self) -> list[tuple[str, tuple[str, ...]]]:
        return [(tag, tuple(attributes)) for tag, attributes in self.elements]

    @property
    def policy(self) -> str:
        (found,) = [a["content"] for tag, a in self.elements if a.get("http-equiv")]
        return str(found)


def read(text: str) -> Any:
    """Read JSON as browsers do, which know no Infinity."""

    def refuse(constant: str) -> None:
        raise ValueError(constant)

    return json.loads(text, parse_constant=refuse)


def data_in(text: str) -> Any:
    return read(Parsed(text).texts["data"])


@pytest.fixture(scope="module")
def nut() -> str:
    return page_text()


def test_the_policy_allows_what_is_inside_and_nothing_else(nut: str) -> None:
    parsed = Parsed(nut)
    inside = [parsed.texts[name] for name in ("style", "solver", "module")]
    hashes = [f"'sha256-{b64encode(hashlib.sha256(text.encode()).digest()).decode()}'" for text in inside]
    assert parsed.policy == (
        f"default-src 'none'; script-src {hashes[1]} {hashes[2]}; style-src {hashes[0]};"
        " img-src data: blob:; worker-src blob:; base-uri 'none'; form-action 'none'"
    )
    first = [tag for tag, attributes in parsed.elements if attributes.get("http-equiv") or tag == "style"]
    assert first == ["meta", "style"]  # the policy stands before all that it is about


def test_it_is_small(nut: str, tmp_path: Path) -> None:
    assert len(nut.encode()) <= MOST
    (file := tmp_path / "feeder.toml").write_text(FEEDER, encoding="utf-8")
    several = page_text([request_of_call(file, {}), request_of_call(NUT, {})])
    assert len(several.encode()) <= MOST


@each("name", HOSTILE)
def test_no_name_becomes_markup(name: str, nut: str) -> None:
    request = request_of_call(NUT, {})
    object.__setattr__(request, "name", name)
    text = page_text([request])
    text.encode()
    parsed = Parsed(text)
    assert parsed.shape == Parsed(nut).shape
    assert parsed.texts["solver"] == Parsed(nut).texts["solver"]
    (scene,) = json.loads(parsed.texts["data"])["scenes"]
    assert len(scene["name"]) == len(name)
    assert scene["name"].isprintable()
    assert not {"\u2028", "\u2029"} & {*text}
    assert parsed.texts["title"] == f"{scene['name']} \u2013 vibro explore"


@each("name", [name for name in HOSTILE[:-1] if "\x00" not in name])
def test_no_text_of_a_scene_file_becomes_markup(name: str, nut: str, tmp_path: Path) -> None:
    name = name.encode(errors="replace").decode()
    pack = "".join(f"\\u{ord(c):04x}" for c in name)
    (file := tmp_path / "feeder.toml").write_text(FEEDER.replace("6 leaves", pack), encoding="utf-8")
    text = page_text([request_of_call(file, {})])
    assert Parsed(text).shape == Parsed(nut).shape
    (scene,) = data_in(text)["scenes"]
    assert next(iter(scene["machine"]["packs"].values())) == 55.6


def test_scripts_end_where_they_end() -> None:
    for script in (solver_script(), page_script(), pages._safe('a = "</script><!--<SCRIPT";')):
        assert not re.search("<(!--|/?script)", script, re.IGNORECASE)


def test_a_solver_that_is_missing_is_told(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setattr(pages, "files", lambda _: tmp_path)
    with pytest.raises(vibro.FileError, match="the solver in JavaScript is missing") as caught:
        pages.solver_script()
    assert caught.value.hint == "install vibro again: installing makes it"


def test_the_data_are_those_of_the_tables(nut: str) -> None:
    data = data_in(nut)
    assert [*data["quantities"]][: len(CONTROLS)] == [*CONTROLS]
    for name, told in data["quantities"].items():
        if name in ("speed", "acceleration"):
            continue
        quantity = QUANTITIES[name]
        assert (told["column"], told["default"], told["low"]) == (
            quantity.column, quantity.default, quantity.allowed.low,
        )  # fmt: skip
        for unit, size in quantity.kind.sizes.items():
            assert tuple(told["sizes"][unit]) == size.as_integer_ratio()
        assert quantity.from_si(1.0) == (told["per_si"] if told["per_si"] != 1.0 else 1.0)
    assert data["quantities"]["amplitude"]["options"] == "-A"
    assert data["quantities"]["gravity"]["sign"] == "m/s²"
    assert data["known"]["Status"] == {status.name: int(status) for status in Status}
    assert [one["label"] for one in data["regimes"]] == [regime.label for regime in Regime]
    assert symbol_of(QUANTITIES["static_friction"]) == "μ_s"
    first, count = data["looks"]["scale"]
    for name, colours in data["looks"]["palettes"].items():
        rows = np.frombuffer(b64decode(colours), np.uint8).reshape(-1, 3)
        assert len(rows) == (first if name == "plain" else count)
    assert (
        (data["looks"]["palettes"]["plain"])[:8] == b64encode(bytes([255, 255, 255, 102, 153, 204])).decode()
    )


def test_numbers_that_json_has_not_come_back() -> None:
    odd = {"a": [math.inf, -math.inf, 1e308], "Infinity, NaN": '"NaN\\" Infinity', "n": math.nan}
    text = pages._json(odd)
    assert read(text) == {**odd, "n": None}
    assert "</" not in pages._json({"</script>": "</script>"})


def test_scenes_come_back_as_they_were(tmp_path: Path) -> None:
    requests = []
    for number, text in enumerate(GIVEN_DRIVES.values()):
        (file := tmp_path / f"given{number}.toml").write_text(text, encoding="utf-8")
        requests.append(request_of_call(file, {}))
    assert data_in(page_text(requests))["scenes"] == json.loads(json.dumps([*map(scene_data, requests)]))


def test_notebooks_show_the_page_in_a_frame_of_its_own(tmp_path: Path) -> None:
    body = {"drive_angle": 0.35, "static_friction": 0.74, "kinetic_friction": 0.57}
    page = vibro.page(vibro.Scene(amplitude=1e-3, frequency=15, **body))
    ((tag, attributes),) = Parsed(page._repr_html_()).elements
    assert tag == "iframe"
    assert attributes["sandbox"] == "allow-scripts allow-downloads"
    assert attributes["title"] == "vibro explore"
    assert attributes["srcdoc"] == page.html
    page.write(tmp_path / "nut.html")
    assert (tmp_path / "nut.html").read_text(encoding="utf-8") == page.html
    assert repr(page) == f"<vibro explore, {len(page.html)} characters of HTML>"
    assert vibro.page(NUT).html == vibro.page(str(NUT)).html
