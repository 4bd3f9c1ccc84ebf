"""A browser for printed pages."""

from __future__ import annotations

from helpers.browsers import axe, browser

__all__ = ["axe", "browser"]
