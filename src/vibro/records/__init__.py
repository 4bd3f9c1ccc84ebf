"""Measured records: reading, alignment, comparison with the model, and fits."""
