"""From a plant and its requirements to a proven gain."""
