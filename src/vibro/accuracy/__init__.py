"""Speed against accuracy, measured: other methods on the same scenes, and a reference."""
