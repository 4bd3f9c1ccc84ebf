"""Inverse design: which drive conveys fast enough, for parts whose friction is known only as bands."""
