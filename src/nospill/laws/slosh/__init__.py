"""Sloshing liquid: the modal record, its equation of motion, surface height, and what is left after the end."""
