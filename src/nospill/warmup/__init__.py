"""Compiling beforehand what plans usually need."""
