"""Drafts to edit: the examples' tables, and a small one that plans in about a second."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest

from nospill.scenario import read_scenario
from nospill.studio.draft import Draft


def small_table(**planning: Any) -> dict[str, Any]:
    """Two cups along `pp` on few intervals."""
    table = read_scenario("pp-two-cups").source
    return table | {"planning": {"intervals": 20, "starts": 1} | planning}


@pytest.fixture
def table() -> dict[str, Any]:
    return small_table()


@pytest.fixture
def draft_of() -> Callable[[str], Draft]:
    """A draft of an example."""
    return lambda name: Draft(read_scenario(name).source)
