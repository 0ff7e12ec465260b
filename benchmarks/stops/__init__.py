"""Stops of plans in a second physics engine."""
