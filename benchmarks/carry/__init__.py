"""Trays carried from here to there among obstacles: random cells of seven families."""
