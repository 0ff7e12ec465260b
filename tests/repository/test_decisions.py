"""Decision records: each is a page, and the index and the page on the design lead to every one."""

from __future__ import annotations

import re
from pathlib import Path

from tests.repository.modules import ROOT, label

DOCS = ROOT / "docs"
RECORDS = sorted((DOCS / "decisions").glob("[0-9]*.md"))
NOTES = sorted((ROOT / "benchmarks" / "notes").glob("*.md"))
LONGEST = 60
"""Lines of a record; what is longer has notes in benchmarks/notes."""


def title(path: Path) -> tuple[str, str]:
    """Number and title in the first line of a record or of notes."""
    found = re.fullmatch(r"# (?:Notes to )?(\d{4}): (.+)", path.read_text(encoding="utf-8").splitlines()[0])
    assert found is not None, label(path)
    return found[1], found[2]


def test_the_index_has_every_record_once_and_in_order() -> None:
    index = (DOCS / "decisions" / "index.md").read_text(encoding="utf-8")
    listed = re.findall(r"^\| (\d{4}) \| \[(.+)\]\((.+)\) \|$", index, re.MULTILINE)
    assert listed == [(*title(path), path.name) for path in RECORDS]


def test_numbers_that_were_never_given_are_named() -> None:
    index = (DOCS / "decisions" / "index.md").read_text(encoding="utf-8")
    [sentence] = re.findall(r"^Numbers (.+) were never given\.$", index, re.MULTILINE)
    given = {int(title(path)[0]) for path in RECORDS}
    missing = [f"{number:04d}" for number in range(1, max(given)) if number not in given]
    assert re.findall(r"\d{4}", sentence) == missing


def test_a_record_is_a_page_with_a_decision() -> None:
    texts = {path: path.read_text(encoding="utf-8") for path in RECORDS}
    assert [label(path) for path in RECORDS if title(path)[0] != path.name[:4]] == []
    assert [label(path) for path, text in texts.items() if len(text.splitlines()) > LONGEST] == []
    assert [label(path) for path, text in texts.items() if "\n## Decision\n" not in text] == []


def test_notes_belong_to_a_record_that_names_them() -> None:
    records = {path: DOCS / "decisions" / path.name for path in NOTES}
    assert [label(path) for path, record in records.items() if title(path) != title(record)] == []
    texts = {path: record.read_text(encoding="utf-8") for path, record in records.items()}
    assert [label(path) for path in NOTES if f"(../../benchmarks/notes/{path.name})" not in texts[path]] == []


def test_the_page_on_the_design_leads_to_every_record_once() -> None:
    text = (DOCS / "design.md").read_text(encoding="utf-8")
    table = text[text.index("## Where the reasons are") :]
    assert sorted(re.findall(r"\]\(decisions/(.+?)\)", table)) == [path.name for path in RECORDS]
