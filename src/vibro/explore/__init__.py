"""A page in the browser that moves with the drive: ``vibro explore``."""
