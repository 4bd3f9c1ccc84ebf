"""What the solver reads scenes from and writes answers to: flat buffers of one type of number."""

from __future__ import annotations

from typing import TypeAlias

__all__ = ["Bytes", "Doubles", "Integers"]

Doubles: TypeAlias = "memoryview[float]"
Integers: TypeAlias = "memoryview[int]"
Bytes: TypeAlias = "memoryview[int]"
