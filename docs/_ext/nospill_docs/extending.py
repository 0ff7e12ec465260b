"""The worked examples of the page on extending: new files as they are, and the lines that tables get."""

from __future__ import annotations

import shutil
import tomllib
from dataclasses import dataclass
from pathlib import Path

import nospill

EXAMPLES = "examples/extending"


@dataclass(frozen=True, slots=True)
class Line:
    """One change in a file of the package.

    Attributes:
        file: path in src/nospill.
        add: what is added, whole lines.
        after: part of the line behind which it goes, or replace: the text in whose place it goes. Either stands in one
            line of the file only.
    """

    file: str
    add: str
    after: str = ""
    replace: str = ""

    def change(self, package: Path) -> tuple[int, str, list[str]]:
        """Where the line stands in a package (index), the line itself and the lines that take its place.

        Raises:
            ValueError: it is not found exactly once, so the page no longer fits the package.
        """
        anchor, added = self.after or self.replace, self.add.strip("\n")
        lines = (package / self.file).read_text(encoding="utf-8").split("\n")
        found = [index for index, line in enumerate(lines) if anchor in line]
        if len(found) != 1:
            raise ValueError(f"{self.file}: {anchor!r} stands in {len(found)} lines; the worked example wants one")
        old = lines[found[0]]
        new = f"{old}\n{added}" if self.after else old.replace(self.replace, added)
        return found[0], old, new.split("\n")


def read_lines(example: Path) -> list[Line]:
    """The changes of one worked example, from its lines.toml."""
    return [Line(**entry) for entry in tomllib.loads((example / "lines.toml").read_text(encoding="utf-8"))["line"]]


def apply_example(example: Path, package: Path) -> None:
    """Do to a copy of the package what the page says: put the new files in place and change the lines.

    Raises:
        ValueError: a line is not found exactly once, so the page no longer fits the package.
    """
    for source in new_files(example):
        target = package / source.relative_to(example / "nospill")
        if target.exists():
            raise ValueError(f"{target} exists already; the worked example {example.name} does not add a file")
        shutil.copyfile(source, target)
    for line in read_lines(example):
        index, _, new = line.change(package)
        target = package / line.file
        lines = target.read_text(encoding="utf-8").split("\n")
        lines[index : index + 1] = new
        target.write_text("\n".join(lines), encoding="utf-8")


def new_files(example: Path) -> list[Path]:
    """The files that an example adds to the package."""
    found = (example / "nospill").rglob("*")
    return sorted(path for path in found if path.is_file() and "__pycache__" not in path.parts)


def worked_example(example: Path) -> str:
    """The files and lines of one worked example and the script that tries it, as a page shows them."""
    files = "".join(_file(path, example) for path in new_files(example))
    lines = "".join(_shown(line) for line in read_lines(example))
    tried = _fenced("python", (example / "try_it.py").read_text(encoding="utf-8"))
    return f"{files}{lines}Try it:\n\n{tried}"


def _file(path: Path, example: Path) -> str:
    language = {".py": "python", ".toml": "toml", ".urdf": "xml"}[path.suffix]
    place = path.relative_to(example / "nospill").as_posix()
    return f"New file `{place}`:\n\n" + _fenced(language, path.read_text(encoding="utf-8"))


def _shown(line: Line) -> str:
    _, old, new = line.change(Path(str(nospill.__file__)).parent)
    if new[0] == old:
        shown = [f" {old}", *(f"+{text}" for text in new[1:])]
    else:
        shown = [f"-{old}", *(f"+{text}" for text in new)]
    return f"In `{line.file}`:\n\n" + _fenced("diff", "\n".join(text.rstrip() for text in shown))


def _fenced(language: str, text: str) -> str:
    return f"```{language}\n{text.rstrip()}\n```\n\n"
