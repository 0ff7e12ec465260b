"""Slosh modes: closed forms of prisms, finite elements of bodies of revolution."""
