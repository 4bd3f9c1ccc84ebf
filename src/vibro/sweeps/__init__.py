"""Sweeps: a grid of scenes, its solution block by block, and its tables."""
