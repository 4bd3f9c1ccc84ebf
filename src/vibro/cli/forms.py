"""What files can be written as: endings of ``-o``."""

from __future__ import annotations

from typing import Final

from vibro.results.drawing import PICTURES

#: Endings of what the commands of series write: tables, their description, pictures.
SERIES: Final = ("csv", "json", "html", *PICTURES)
#: The same of commands whose answers are no pages.
HISTORIES: Final = ("csv", "json", *PICTURES)
#: Endings of what sweeps can be written as: ``vibro map``, and commands that draw nothing.
MAPS: Final = ("csv", "xlsx", "parquet", "json", *PICTURES)
TABLES: Final = ("csv", "xlsx", "json", "html")
