"""What tests of the repository share."""

from __future__ import annotations

import tomllib
from typing import Any

import pytest

from tests.repository.modules import ROOT


@pytest.fixture(scope="session")
def project() -> dict[str, Any]:
    """The project's pyproject.toml."""
    return tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
