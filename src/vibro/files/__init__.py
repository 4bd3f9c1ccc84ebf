"""Scene and design files: what each may hold, described once, and how each is read and written."""
