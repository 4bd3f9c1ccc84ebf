"""Steady contact cycles of drives whose motion along and off the trough has several harmonics."""
