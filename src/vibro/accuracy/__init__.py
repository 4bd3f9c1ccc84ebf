"""Speed against accuracy, measured: other ways to solve the same scenes, and a reference beside them."""
