"""Results: every field described once, and the plain containers that hold them."""

from __future__ import annotations

from vibro.core.codes import Regime, Status
from vibro.results.steady import RESULTS, Result, SteadyCycle

__all__ = ["RESULTS", "Regime", "Result", "Status", "SteadyCycle"]
