"""What tests of compiled flows share."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.compiling import own_library


@pytest.fixture(scope="module")
def flow_library(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    """The compiled flow, of one module's tests alone."""
    with own_library("flow", tmp_path_factory.mktemp("flow")) as found:
        yield found
