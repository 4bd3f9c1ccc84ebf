"""Machines that drive a trough: amplitude from setting, voltage, springs and filling; operating points."""
