"""The solver: arrays in, arrays out; knows no files, units or screens."""
