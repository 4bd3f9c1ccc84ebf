"""The picture of the page in the README is of this page.

With VIBRO_DRAW it is made anew: VIBRO_DRAW=1 pytest tests/explore/test_page_picture.py
"""

from __future__ import annotations

import io
import os
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from helpers.pages import expect
from PIL import Image

if TYPE_CHECKING:
    from collections.abc import Callable

    from playwright.sync_api import Page

PICTURE = Path(__file__).parents[2] / "docs" / "images" / "explore.png"


def test_the_picture_in_the_readme_is_of_this_page(open_page: Callable[..., Page]) -> None:
    page = open_page("#view=speed", viewport={"width": 1360, "height": 860})
    expect(page.locator("#stage")).not_to_contain_text("exact")  # nothing is left to be computed
    page.mouse.move(1, 1)
    drawn = page.screenshot()
    if os.environ.get("VIBRO_DRAW"):
        PICTURE.write_bytes(drawn)
    fresh, shown = (np.asarray(Image.open(x).convert("L"), float) for x in (io.BytesIO(drawn), PICTURE))
    assert fresh.shape == shown.shape
    assert np.abs(fresh - shown).mean() < 2.0  # of 255: fonts differ from machine to machine
