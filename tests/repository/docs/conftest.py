"""The documentation's own modules, which the build imports from docs/_ext."""

from __future__ import annotations

import importlib.util
import sys
from pathlib import Path

# They need Sphinx (the extra `docs`), which `make docs` and the gate install and `make test` alone does not.
collect_ignore_glob = [] if importlib.util.find_spec("sphinx") else ["test_*.py"]

sys.path.insert(0, str(Path(__file__).parents[3] / "docs" / "_ext"))
