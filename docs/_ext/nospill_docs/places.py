"""Where generated content goes, and a cache of what takes seconds to make."""

from __future__ import annotations

import hashlib
import logging
import os
import shutil
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import nospill

_LOG = logging.getLogger(__name__)

_LEAVES = ("cli", "viewer", "studio", "report", "verify", "margins")
"""Parts of the package on which neither plans nor figures depend."""


@dataclass(frozen=True, slots=True)
class Places:
    """Folders of one build.

    Attributes:
        docs: the sources of the documentation.
        generated: pictures and pages of the site alone; made again by every build.
        cache: results kept between builds, by the content they were made from.
    """

    docs: Path
    generated: Path
    cache: Path

    @classmethod
    def of(cls, docs: str | os.PathLike[str]) -> Places:
        """The folders below `docs`; generated and cache are made."""
        root = Path(docs)
        places = cls(root, root / "_generated", root / "_build" / "cache")
        for folder in (places.generated, places.generated / "extra", places.cache):
            folder.mkdir(parents=True, exist_ok=True)
        return places

    def cached(self, name: str, key: str, make: Callable[[Path], None]) -> Path:
        """The folder that `make` fills, made only when `key` or the package has changed.

        Args:
            name: of the result, unique.
            key: text of everything but the package on which it depends.
            make: fills an empty folder.
        """
        digest = hashlib.sha256(f"{package_digest()} {key}".encode()).hexdigest()[:16]
        folder = self.cache / f"{name}-{digest}"
        if not folder.is_dir():
            for old in self.cache.glob(f"{name}-{'[0-9a-f]' * 16}*"):
                shutil.rmtree(old)
            partial = folder.with_suffix(".partial")
            partial.mkdir()
            _LOG.info("making %s ...", name)
            make(partial)
            partial.rename(folder)
        return folder


def package_digest() -> str:
    """Hash of the package's sources that plans and figures are made from."""
    root = Path(str(nospill.__file__)).parent
    files = [
        path
        for path in sorted(root.rglob("*"))
        if path.suffix in (".py", ".toml", ".urdf") and path.relative_to(root).parts[0] not in _LEAVES
    ]
    digest = hashlib.sha256()
    for path in files:
        digest.update(f"{path.relative_to(root)}\0".encode() + path.read_bytes())
    return digest.hexdigest()


def write_if_changed(path: Path, text: str) -> None:
    """Write a text; a file that says the same keeps its time, so that Sphinx reads only what has changed."""
    if not path.is_file() or path.read_text(encoding="utf-8") != text:
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, encoding="utf-8")


def copy_if_changed(source: Path, target: Path) -> None:
    """The same for any file."""
    if not target.is_file() or target.read_bytes() != source.read_bytes():
        target.parent.mkdir(parents=True, exist_ok=True)
        shutil.copyfile(source, target)
