"""Tests of nospill: a folder for each package, `system` for what crosses them, `repository` for the repository."""
