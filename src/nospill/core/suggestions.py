"""The nearest known name for one that is not known, for error messages."""

from __future__ import annotations

import difflib
from collections.abc import Iterable


def nearest(name: str, known: Iterable[str], *, likeness: float = 0.6) -> str | None:
    """Return the known name most like `name`, whatever its case and its hyphens; None where none is.

    Args:
        name: as written.
        known: names to choose from.
        likeness: least ratio of `difflib.SequenceMatcher`, 0 to 1.
    """
    by_plain = {_plain(item): item for item in known}
    matches = difflib.get_close_matches(_plain(name), list(by_plain), n=1, cutoff=likeness)
    return by_plain[matches[0]] if matches else None


def _plain(name: str) -> str:
    return name.casefold().replace("_", "-").replace(" ", "-")
