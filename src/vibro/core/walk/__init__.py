"""One body from its first moment on: steps, histories, arrival."""
