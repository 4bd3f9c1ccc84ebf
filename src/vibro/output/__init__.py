"""The forms in which solved sweeps are written."""
