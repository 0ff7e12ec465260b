"""What tests of executed motions share."""

from __future__ import annotations

import pytest


@pytest.fixture
def verdict_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    """What each joint adds to the peaks is left out: a replay a joint, on which no verdict depends."""
    monkeypatch.setattr("nospill.execution.executed._peaks", lambda *_: ())
