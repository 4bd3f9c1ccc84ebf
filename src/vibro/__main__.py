"""The program ``vibro``: it can be interrupted from its first moment on."""

from __future__ import annotations

from vibro.interrupts import end_on_signals

__all__ = ["main"]


def main() -> None:
    """Run the command line of this process."""
    # Before anything else is imported, which takes most of a short run's time.
    end_on_signals()
    from vibro.cli.app import main as run

    run()


if __name__ == "__main__":
    main()
