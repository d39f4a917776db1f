"""What runs: a controller with its memory, limits and set points, and its programs."""

__all__: list = []
