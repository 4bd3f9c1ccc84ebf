"""What the tests of the command line share."""

from __future__ import annotations

"""The paper's scene."""
"""Two harmonics along the trough."""
"""A table and its sidecar, without pictures, which take most of a small run's time."""
"""The program, in a process of its own."""
"""The same, which prints in the end what it has loaded: libraries, or the source of the solver."""
