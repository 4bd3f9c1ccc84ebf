"""Units of signals, however programs spell them."""

from __future__ import annotations

import pytest

from vibro.records.signals import signal_unit


@pytest.mark.parametrize(
    ("text", "kind", "size"),
    [
        ("s", "time", 1.0),
        ("sec", "time", 1.0),
        ("ms", "time", 1e-3),
        ("us", "time", 1e-6),
        ("\u00b5s", "time", 1e-6),
        ("min", "time", 60.0),
        ("m", "displacement", 1.0),
        ("cm", "displacement", 1e-2),
        ("mm", "displacement", 1e-3),
        ("um", "displacement", 1e-6),
        ("\u03bcm", "displacement", 1e-6),
        ("MM", "displacement", 1e-3),
        ("in", "displacement", 0.0254),
        ("mm/sec", "velocity", 1e-3),
        ("mm_s", "velocity", 1e-3),
        ("m/s", "velocity", 1.0),
        ("mm/sec**2", "acceleration", 1e-3),
        ("mm/s\u00b2", "acceleration", 1e-3),
        ("m_s2", "acceleration", 1.0),
        ("g", "acceleration", 9.80665),
        ("newton", "force", 1.0),
        ("N", "force", 1.0),
        ("mN", "force", 1e-3),
        ("kN", "force", 1e3),
        ("mV", "voltage", 1e-3),
        ("V", "voltage", 1.0),
        ("Volt", "voltage", 1.0),
    ],
)
def test_spellings_of_units(text: str, kind: str, size: float) -> None:
    assert signal_unit(text) == (kind, size)


@pytest.mark.parametrize("text", ["", "deg", "1/s", "furlong", "v"])
def test_what_is_no_unit(text: str) -> None:
    assert signal_unit(text) is None
