"""Joint logs of executed motions: readers, clock, smoothing, and the verdict on what was executed."""
