"""The program ``vibro``: it can be interrupted from its first moment on."""

from __future__ import annotations

import os

from vibro.interrupts import end_on_signals

__all__ = ["main"]


def main() -> None:
    """Run the command line of this process."""
    # Before anything else is imported, which takes most of a short run's time.
    end_on_signals()
    # OpenBLAS starts a thread a core as NumPy is imported, which costs more CPU than all products of small
    # matrices here. The solver's own threads do not depend on it, and workers inherit it.
    os.environ.setdefault("OPENBLAS_NUM_THREADS", os.environ.get("OMP_NUM_THREADS", "1"))
    from vibro.cli.app import main as run

    run()


if __name__ == "__main__":
    main()
