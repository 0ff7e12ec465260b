"""Every page as a host shows it that knows Markdown alone: nothing is left out, every link leads somewhere."""

from __future__ import annotations

import re
import subprocess
from collections import Counter
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from urllib.parse import unquote

import pytest
from markdown_it import MarkdownIt
from markdown_it.token import Token
from nospill_docs.blocks import DOCS, Block, alike, blocks, pages

from tests.repository.modules import ROOT, label

_MARKDOWN = MarkdownIt("commonmark").enable("table")
_SITE_ONLY = re.compile(r"\{[a-z:-]+\}`|^:::|^```\{(?!figure\})\w*", re.MULTILINE)
"""Roles and directives of the site's own Markdown; a figure is read as its description and its caption."""


@cache
def kept() -> frozenset[Path]:
    """Every file that a clone has."""
    listed = subprocess.run(
        ["git", "ls-files", "--cached", "--others", "--exclude-standard"],
        cwd=ROOT,
        text=True,
        capture_output=True,
        check=False,
    )
    if listed.returncode:
        pytest.skip("no clone")
    return frozenset(path for name in listed.stdout.splitlines() if (path := ROOT / name).is_file())


@cache
def tokens(page: Path) -> tuple[Token, ...]:
    return tuple(_MARKDOWN.parse(page.read_text(encoding="utf-8")))


def inline(page: Path) -> Iterator[Token]:
    for token in tokens(page):
        yield from token.children or ()


def headings(page: Path) -> list[tuple[int, str]]:
    """Level and text of every heading, in order."""
    found = tokens(page)
    return [
        (int(token.tag[1:]), "".join(child.content for child in found[index + 1].children or ()))
        for index, token in enumerate(found)
        if token.type == "heading_open"
    ]


@cache
def anchors(page: Path) -> frozenset[str]:
    """Names under which the headings of a page are reached: small letters, hyphens for spaces, no other signs."""
    names = [re.sub(r"[^\w\- ]", "", text.lower()).replace(" ", "-") for _, text in headings(page)]
    seen: Counter[str] = Counter()
    found = set()
    for name in names:
        found.add(f"{name}-{seen[name]}" if seen[name] else name)
        seen[name] += 1
    return frozenset(found)


def links(page: Path) -> Iterator[tuple[str, str]]:
    """Address and text of every link and picture of a page."""
    text, address = "", None
    for token in inline(page):
        if token.type == "link_open":
            text, address = "", str(token.attrs["href"])
        elif token.type == "link_close" and address is not None:
            yield address, text
            address = None
        elif token.type == "image":
            yield str(token.attrs["src"]), token.content
            text += token.content
        else:
            text += token.content


def faults(page: Path) -> Iterator[str]:
    """What a reader of a page in a clone would miss."""
    text = page.read_text(encoding="utf-8")
    for found in _SITE_ONLY.finditer(text):
        yield f"line {text.count(chr(10), 0, found.start()) + 1}: {found[0]!r} is shown as it is written"
    for token in tokens(page):
        if token.type == "fence" and token.info.startswith("{figure}"):
            about, _, caption = token.content.partition("\n\n")
            if not re.search(r"^:alt: \S", about, re.MULTILINE) or not caption.strip():
                yield f"{token.info}: a figure has a description and a caption"
    for address, words in links(page):
        if not words.strip():
            yield f"{address}: a link without words"
        place, _, anchor = unquote(address).partition("#")
        if "://" in place or place.startswith("mailto:"):
            continue
        target = (page.parent / place).resolve() if place else page
        if place and target not in kept() and not any(target in path.parents for path in kept()):
            yield f"{address}: no file of the repository"
        elif anchor and target.suffix == ".md" and anchor not in anchors(target):
            yield f"{address}: no such heading"
    yield from (f"{name}: an empty section" for name in empty_sections(page))


def empty_sections(page: Path) -> Iterator[str]:
    """Headings below which nothing stands before the next one that is no deeper."""
    open_heading: tuple[int, str] | None = None
    found = [*tokens(page), Token("heading_open", "h1", 1)]
    for index, token in enumerate(found):
        if token.type == "heading_open":
            level = int(token.tag[1:])
            if open_heading is not None and level <= open_heading[0]:
                yield open_heading[1]
            name = found[index + 1].content if index + 1 < len(found) else ""
            open_heading = (level, name)
        elif token.type in ("paragraph_open", "fence", "code_block", "table_open", "bullet_list_open", "math_block"):
            open_heading = None


MARKDOWN = [*pages(), *sorted(ROOT.glob("*.md")), *sorted((ROOT / "benchmarks").rglob("*.md"))]


def test_a_page_says_in_a_clone_what_it_says_on_the_site() -> None:
    assert {label(page): found for page in MARKDOWN if (found := list(faults(page)))} == {}


def test_what_a_host_does_not_show_is_found(tmp_path: Path) -> None:
    page = tmp_path / "page.md"
    page.write_text(
        "# A\n\n## B\n\n```{include} x.md\n```\n\n## C\n\n## D\n\n{doc}`x` [](y.md) [z](#b) [w](#e)\n"
        "```{figure} f.svg\n:alt: f\n```\n"
    )
    found = "\n".join(faults(page))
    for part in (
        "'```{include'",
        "'{doc}`'",
        "y.md: a link without words",
        "y.md: no file",
        "#e: no such",
        "C: an empty",
    ):
        assert part in found
    assert "f.svg: a figure has" in found and "#b:" not in found and "D:" not in found


def test_every_page_is_one_link_from_an_index() -> None:
    indices = [page for page in pages() if page.name == "index.md"]
    reached = {(index.parent / address.partition("#")[0]).resolve() for index in indices for address, _ in links(index)}
    assert [label(page) for page in pages() if page not in reached and page != DOCS / "index.md"] == []


# --- blocks that are made ---------------------------------------------------------------------------------------------

BLOCKS = [block for page in pages() for block in blocks(page)]


def name(block: Block) -> str:
    return f"{block.page.stem}-{block.kind}-{block.words[0]}"


@pytest.mark.parametrize("block", [block for block in BLOCKS if not block.plans], ids=name)
def test_a_block_is_fresh(block: Block) -> None:
    assert block.is_fresh(block.made()), "make pages writes it again"


@pytest.mark.slow
@pytest.mark.parametrize("block", [block for block in BLOCKS if block.plans], ids=name)
def test_a_session_that_plans_prints_what_its_page_shows(block: Block) -> None:
    made = block.made()
    assert block.is_fresh(made), f"make pages writes it again:\n{made}"


def test_sessions_are_alike_up_to_rounding_only() -> None:
    assert alike("a 1.192 s  b -0.00\n", "a  1.193 s b +0.00\n")
    assert alike("noise 4.6e-10 rad", "noise 5.9e-10 rad")
    assert not alike("a 1.192 s", "a 1.392 s")
    assert not alike("a 1 s", "b 1 s")
    assert not alike("a 1 s\nc", "a 1 s")
