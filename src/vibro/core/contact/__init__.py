"""One slide, onsets, and the steady cycle of bodies that stay on the trough."""
