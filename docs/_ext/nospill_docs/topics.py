"""The part of the table of contents that needs no list: every page in docs/ that the index does not name itself."""

from __future__ import annotations

import re

from nospill_docs.places import Places, write_if_changed

_FIRST = (
    "robots",
    "exports",
    "viewer",
    "studio",
    "uncertainty",
    "verify",
    "after-the-run",
    "reliability",
    "performance",
)
"""Pages that come first, in this order, where they exist; others follow by name."""


def write_topics(places: Places) -> None:
    """Write the toctree of topics, so that a new page is in the contents as soon as its file is there."""
    index = (places.docs / "index.md").read_text(encoding="utf-8")
    named = set(re.findall(r"^[a-z][a-z-]*$", index, flags=re.MULTILINE)) | {"index"}
    pages = [path.stem for path in sorted(places.docs.glob("*.md")) if path.stem not in named]
    pages.sort(key=lambda page: (_FIRST.index(page) if page in _FIRST else len(_FIRST), page))
    entries = "\n".join(pages)
    write_if_changed(
        places.generated / "topics.md", f"```{{toctree}}\n:caption: Topics\n:maxdepth: 1\n:hidden:\n\n{entries}\n```\n"
    )
