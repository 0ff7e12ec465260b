"""Suggested changes in words."""

from __future__ import annotations

from collections.abc import Sequence

from nospill.errors import Change


def advice(changes: Sequence[Change], otherwise: str) -> str:
    """The last sentence of a message: the changes that were found, or what to try where none was."""
    if not changes:
        return otherwise
    return "Smallest single change found: " + "; or ".join(change.text for change in changes[:3]) + "."
