"""Tests of what needs Sphinx."""

from __future__ import annotations

import importlib.util

# The extra `docs`, which `make docs` and the gate install and `make test` alone does not.
collect_ignore_glob = [] if importlib.util.find_spec("sphinx") else ["test_*.py"]
