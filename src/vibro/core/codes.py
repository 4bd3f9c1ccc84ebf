"""Small integer codes of the results: regime, status, pattern and model of each cell."""

from __future__ import annotations

from enum import IntEnum
from typing import Final

__all__ = ["MODELS", "PATTERNS", "Model", "Pattern", "Regime", "Status"]


class Regime(IntEnum):
    """What a body on the trough does, as maps class it."""

    UNDEFINED = -1  # the cell has no regime: see its status
    NO_SLIP = 0
    FORWARD_SLIP = 1  # slides, never backwards
    BACK_SLIP = 2  # any back slide in the steady cycle
    HOPPING = 3  # throw number above 1

    @property
    def label(self) -> str:
        """The regime's name in tables and pictures; empty where there is none."""
        return "" if self is Regime.UNDEFINED else self.name.lower().replace("_", "-")


class Status(IntEnum):
    """How far the numbers of a cell can be trusted, and why one is missing."""

    OK = 0
    BOUNDARY = 1
    RUNAWAY = 2
    INDETERMINATE = 3
    FLIGHT_NOT_MODELLED = 4
    INFEASIBLE = 5
    UNRESOLVED = 6
    AVERAGED = 7

    @property
    def label(self) -> str:
        """The status's name in tables."""
        return self.name.lower().replace("_", "-")

    @property
    def message(self) -> str:
        """One sentence that tells a user what the status means."""
        return _STATUS_MESSAGES[self]


_STATUS_MESSAGES: Final = {
    Status.OK: "solved to rounding",
    Status.BOUNDARY: "within a few ulp of a threshold: the value is that of the side equality belongs to",
    Status.RUNAWAY: "the body never comes to rest and gains speed every cycle: no steady cycle exists",
    Status.INDETERMINATE: "without static friction the steady motion depends on how the body was started",
    Status.FLIGHT_NOT_MODELLED: "the body leaves the trough; its flight is not modelled",
    Status.INFEASIBLE: "the combination cannot be: mu_d > mu_s, or drive + trough angle of 90 deg or more",
    Status.AVERAGED: "the motion has no short period: mean over many flights, with its standard error",
    Status.UNRESOLVED: "the solver could not prove its answer; please report the scene",
}


class Pattern(IntEnum):
    """Phases of one steady cycle: F forward slide, B back slide, R rest (written ``_``)."""

    NONE = 0
    R = 1
    F_ = 2
    B_ = 3
    F_B_ = 4
    FB_ = 5
    F_B = 6
    FB = 7


PATTERNS: Final = ("", "_", "F_", "B_", "F_B_", "FB_", "F_B", "FB")


class Model(IntEnum):
    """The cheapest exact model that a cell's answer came from."""

    NONE = 0
    REST = 1  # thresholds alone
    ONE_SLIDE = 2
    TWO_SLIDES = 3
    CLOSED_FORM = 4  # never at rest
    FLIGHT = 5


MODELS: Final = ("", "rest", "one-slide", "two-slides", "closed-form", "flight")
