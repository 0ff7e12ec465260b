"""Every feature against every other: how the scenarios that had both have ended, as a table and its refusals."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Sequence
from itertools import combinations
from typing import Any

from benchmarks.campaign.combined import FEATURES, NEWER

Line = dict[str, Any]

_TOGETHER = "stated together"
"""In what the reader says of keys that do not go together."""


def features_in(line: Line) -> tuple[str, ...]:
    """The features of a case, as its structure names them."""
    return tuple(line["structure"].rpartition("; ")[2].split(", "))


def pair_table(cases: Sequence[Line]) -> Iterator[str]:
    """Lines of Markdown: certified cases out of all for each pair, and below what was refused and why.

    A case counts for each of its three pairs. `r` stands where two of its keys cannot be stated together. Cases in
    which the arm cannot stand at an end, or its load stands in an obstacle there, say nothing of their features.
    """
    ended: dict[frozenset[str], Counter[str]] = {}
    cases = [line for line in cases if line["kind"] != "refused" or _TOGETHER in line["reason"]]
    for line in cases:
        for pair in combinations(features_in(line), 2):
            ended.setdefault(frozenset(pair), Counter())[line["kind"]] += 1
    names = [*FEATURES, *NEWER]
    yield f"| | {' | '.join(names[:-1])} |"
    yield "|---|" + "---:|" * (len(names) - 1)
    for row, name in enumerate(names[1:], start=1):
        cells = [_cell(ended.get(frozenset((name, other)), Counter())) for other in names[:row]]
        yield f"| {name} | {' | '.join(cells + [''] * (len(names) - 1 - row))} |"
    refused: dict[str, list[Line]] = {}
    for line in cases:
        if line["kind"] == "refused":
            refused.setdefault(line["reason"].split("; ")[0].split(": ", 1)[-1], []).append(line)
    if refused:
        yield ""
        yield "| refused | cases | features of the first | seed |"
        yield "|---|---:|---|---:|"
        for reason, lines in sorted(refused.items(), key=lambda item: -len(item[1])):
            first = lines[0]
            words = reason.replace("|", "/")
            yield f"| {words} | {len(lines)} | {', '.join(features_in(first))} | {first['seed']} |"


def _cell(ended: Counter[str]) -> str:
    every, refused = ended.total(), ended["refused"]
    if not every:
        return "-"
    return "r" if refused == every else f"{ended['planned']}/{every - refused}"
