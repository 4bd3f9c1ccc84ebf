"""Inverse design: which drive does it, for parts of which the friction is known as bands alone."""
