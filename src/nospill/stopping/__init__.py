"""Spill-free stops from every instant of a plan, beside what the controller's own stop does."""
