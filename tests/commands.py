"""What the tests of the command line share."""

from __future__ import annotations

import csv
import io
from collections.abc import Callable

from typer.testing import Result

Run = Callable[..., Result]

NUT = ("-A", "1", "-f", "15", "-a", "20", "--mu-s", "0.74", "--mu-d", "0.57")
"""The paper's scene."""

NUT_ANGLE_AND_FRICTION = NUT[4:]


def rows_of(text: str) -> list[dict[str, str]]:
    """Read a CSV as a user's script would."""
    return list(csv.DictReader(io.StringIO(text, newline="")))
