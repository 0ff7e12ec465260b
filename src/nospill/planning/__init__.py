"""From a scene to a certified plan."""
