"""Hopping bodies: flights and bounces, the return map between them, and its cycles."""
