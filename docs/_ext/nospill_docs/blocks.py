"""Blocks of a page that say what the package says: they stand in the page, and a test makes them again and compares.

A block lies between two comments, which no reader sees:

    <!-- made: table robots -->
    ...
    <!-- end -->

`make pages` writes every block again that no longer says what its maker says.
"""

from __future__ import annotations

import re
import sys
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

from nospill_docs import api, extending, tables, transcripts

DOCS = Path(__file__).parents[2]

BLOCK = re.compile(r"<!-- made: (?P<kind>\w+)\s(?P<words>[^>]*?) -->\n(?P<text>.*?)<!-- end -->", re.DOTALL)

_NUMBER = re.compile(r"(?:(?<=[\s(])[−+-])?\d+(?:\.\d+)?(?:e[-+]\d+)?")
_ROUNDING = 0.01
"""Part by which a number may differ from machine to machine where it comes from a plan."""


def _file(place: str) -> str:
    """A file of docs/ as it is."""
    return f"```{Path(place).suffix[1:]}\n{(DOCS / place).read_text(encoding='utf-8').rstrip()}\n```"


MAKERS: dict[str, Callable[..., str]] = {
    "table": lambda name: tables.TABLES[name](),
    "example": lambda name: extending.worked_example(DOCS / extending.EXAMPLES / name),
    "file": _file,
    "session": lambda name: transcripts.shown(name, DOCS / "examples"),
    "python": api.names_table,
}
"""Kind of a block -> what makes its text from the words behind the kind."""


@dataclass(frozen=True, slots=True)
class Block:
    """One block of one page.

    Attributes:
        page: the file.
        kind: key of `MAKERS`.
        words: arguments of its maker.
        text: what stands in the page.
    """

    page: Path
    kind: str
    words: tuple[str, ...]
    text: str

    @property
    def plans(self) -> bool:
        """Whether making it solves an optimal control problem."""
        return self.kind == "session" and self.words[0] in transcripts.PLANNED

    def made(self) -> str:
        """The text as its maker says it now."""
        return f"\n{MAKERS[self.kind](*self.words).strip()}\n\n"

    def is_fresh(self, made: str) -> bool:
        """Whether the page says what was made; figures of a plan may differ as they round."""
        return self.text == made or (self.plans and alike(self.text, made))


def alike(first: str, second: str) -> bool:
    """Whether two texts have the same words, and numbers that differ by rounding at most."""
    words = [_NUMBER.sub("#", text) for text in (first, second)]
    if [line.split() for line in words[0].splitlines()] != [line.split() for line in words[1].splitlines()]:
        return False
    pairs = zip(*([float(n.replace("−", "-")) for n in _NUMBER.findall(text)] for text in (first, second)), strict=True)
    return all(abs(a - b) <= _ROUNDING * max(abs(a), abs(b), 1.0) for a, b in pairs)


def pages() -> list[Path]:
    """Every page that is kept in docs/; of the gallery and the notebooks, which a build makes, the index alone."""
    made, alone = {"_build", "_generated"}, {"gallery", "notebooks"}
    return [
        path
        for path in sorted(DOCS.rglob("*.md"))
        if not made & set(path.relative_to(DOCS).parts) and (path.parent.name not in alone or path.stem == "index")
    ]


def blocks(page: Path) -> Iterator[Block]:
    """The blocks of a page, in order."""
    for found in BLOCK.finditer(page.read_text(encoding="utf-8")):
        yield _block(page, found)


def refresh(page: Path) -> int:
    """Write the blocks of a page again that are not fresh; how many there were."""
    count = 0

    def fresh(found: re.Match[str]) -> str:
        nonlocal count
        block = _block(page, found)
        made = block.made()
        if block.is_fresh(made):
            return found[0]
        count += 1
        start, end = found.start("text") - found.start(), found.end("text") - found.start()
        return found[0][:start] + made + found[0][end:]

    text = BLOCK.sub(fresh, page.read_text(encoding="utf-8"))
    if count:
        page.write_text(text, encoding="utf-8")
    return count


def _block(page: Path, found: re.Match[str]) -> Block:
    return Block(page, found["kind"], tuple(found["words"].split()), found["text"])


if __name__ == "__main__":
    for path in pages():
        if number := refresh(path):
            print(f"{path.relative_to(DOCS.parent)}: {number} written again", file=sys.stderr)
