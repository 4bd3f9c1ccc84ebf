"""Scene files, and sets of output files that appear whole or not at all."""
