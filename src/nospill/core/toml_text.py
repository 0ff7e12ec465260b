"""Tables as TOML that people read: short lists on one line, where tomli-w gives every member one of its own."""

from __future__ import annotations

import re
import tomllib
from collections.abc import Mapping
from typing import Any

import tomli_w

_WIDTH = 100
_LIST = re.compile(r"^(.*)\[\n((?: +[^\n\[\]]+,\n)+) *\]", re.MULTILINE)
"""A list of no lists, as a value or in another list; no member holds a bracket."""


def toml_text(content: Mapping[str, Any]) -> str:
    """The text of a table, which reads as the same: texts of many lines as such where that says the same."""
    readable = tomli_w.dumps(content, multiline_strings=True)
    for text in (_LIST.sub(_on_one_line, readable), readable):
        if tomllib.loads(text) == content:
            return text
    return tomli_w.dumps(content)


def _on_one_line(found: re.Match[str]) -> str:
    members = ", ".join(line.strip().removesuffix(",") for line in found[2].splitlines())
    line = f"{found[1]}[{members}]"
    return line if len(line) <= _WIDTH else found[0]
