"""What the site shows in the place of what a page says in a clone: contents, records in full, examples as planned.

A page is plain Markdown, which any host shows. Where the site has more, that takes its place when Sphinx reads it.
"""

from __future__ import annotations

import re

from nospill_docs import api
from nospill_docs.blocks import BLOCK

_LISTED = re.compile(r"^(?:[-|]|\d+\.).*?\]\((?P<page>[^)#:]+)\.md(?:#[^)]*)?\)", re.MULTILINE)
_OUTSIDE = re.compile(r"(?<!!)\[(?P<words>[^\]]+)\]\((?:\.\./)+(?P<file>(?:benchmarks|examples|src)/[^)]+)\)")
"""A link to a file that a clone has and the site has not."""
_HEADING = re.compile(r"^## (.+)$", re.MULTILINE)


def as_of_the_site(page: str, text: str) -> str:
    """A page as Sphinx is to read it.

    Args:
        page: its place in docs/, without the ending.
        text: what stands in the file.
    """
    text = re.sub(r"(\]\([^)#:]+)\.ipynb\)", r"\1.md)", text)  # a notebook is a page here
    text = BLOCK.sub(_in_full, text)
    text = _OUTSIDE.sub(r"\g<words> (`\g<file>`)", text)
    text = text.replace("<!-- screens -->", f"```{{include}} _generated/screens-{page}.md\n```")
    if page == "index" or page.endswith("/index"):
        text += "".join(contents(text))
    if page == "gallery/index":
        text += "\n```{toctree}\n:hidden:\n:glob:\n\n[0-9]*\n```\n"
    return text


def contents(text: str) -> list[str]:
    """Tables of contents of an index, one for each heading: the pages that its lists and tables lead to, in order."""
    parts = _HEADING.split(text)
    captions = ["", *parts[1::2]]
    tables = []
    for caption, part in zip(captions, parts[::2], strict=True):
        listed = list(dict.fromkeys(found["page"] for found in _LISTED.finditer(part)))
        inside = [page for page in listed if not page.startswith("..")]
        if inside:
            head = f":caption: {caption}\n" if caption else ""
            entries = "\n".join(inside)
            tables.append(f"\n```{{toctree}}\n{head}:maxdepth: 1\n:hidden:\n\n{entries}\n```\n")
    return tables


def _in_full(block: re.Match[str]) -> str:
    words = block["words"].split()
    if block["kind"] == "python":
        return f"```{{eval-rst}}\n{api.directives(*words)}```\n"
    if block["kind"] == "table" and words == ["examples"]:
        return "```{include} ../_generated/gallery.md\n```\n"
    return block["text"]
