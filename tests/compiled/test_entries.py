"""The list of compiled functions, and what is removed of them: nothing else, and nothing that is being made."""

from __future__ import annotations

import json
import os
from pathlib import Path

import pytest

from nospill.compiled.codegen import source_digest
from nospill.compiled.compile_worker import LONGEST_COMPILATION
from nospill.compiled.entries import cache_entries, clear_cache, compiling

KEY = "0123456789abcdef" * 2


def entry(folder: Path, kind: str, *, source: str | None = None) -> Path:
    """Made-up files of an entry, of 10 bytes beside its table; its library."""
    library = folder / f"{kind}-{KEY}.so"
    library.write_bytes(b"12345678")
    library.with_suffix(".sum").write_bytes(b"12")
    library.with_suffix(".json").write_text(json.dumps({"source": source or source_digest()}))
    return library


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv("NOSPILL_CACHE", str(tmp_path))
    return tmp_path


def test_entries_are_listed_with_their_size_and_whether_they_are_used(folder: Path) -> None:
    entry(folder, "tray")
    entry(folder, "figures-end", source="another")
    entry(folder, "old").with_suffix(".json").write_text("{")
    entry(folder, "ldl").with_suffix(".json").unlink()
    (folder / f"half-{KEY}.json").write_text("{}")
    (folder / "notes.so").write_text("of the user")
    found = {item.kind: item for item in cache_entries()}
    current = {kind: item.current for kind, item in found.items()}
    assert current == {"tray": True, "figures-end": False, "old": False, "ldl": True}
    assert found["tray"].size == 10 + len(json.dumps({"source": source_digest()}))


def test_everything_of_the_cache_is_removed_and_nothing_else(folder: Path) -> None:
    entry(folder, "tray")
    (folder / f"half-{KEY}.json").write_text("{}")
    (folder / "build-abc").mkdir()
    kept = [folder / "notes.so", folder / "a-b.json"]
    for file in kept:
        file.write_text("of the user")
    assert clear_cache() == 4
    assert sorted(folder.iterdir()) == sorted(kept)
    assert clear_cache() == 0 and cache_entries() == ()


def test_what_is_being_compiled_is_left_alone(folder: Path) -> None:
    entry(folder, "tray")
    lock, dead = folder / f"object-{KEY}.lock", folder / f"end-{KEY}.lock"
    for file in (lock, dead, lock.with_suffix(".json"), folder / "build-abc"):
        file.touch()
    os.utime(dead, (0.0, dead.stat().st_mtime - 2 * LONGEST_COMPILATION))
    assert compiling() == 1
    assert clear_cache() == 4
    assert sorted(folder.iterdir()) == sorted([lock, lock.with_suffix(".json"), folder / "build-abc"])


def test_no_folder_is_an_empty_cache(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setenv("NOSPILL_CACHE", str(tmp_path / "none"))
    assert cache_entries() == () and compiling() == 0 and clear_cache() == 0
    assert not (tmp_path / "none").exists()
