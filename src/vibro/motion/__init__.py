"""Motion over time: histories, arrivals and settled motion, in SI units."""
