"""Solvers written apart from the package: README.md lists them."""
