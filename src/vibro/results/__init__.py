"""Results: every field described once, and the plain containers that hold them."""
