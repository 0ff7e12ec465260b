"""cache: lists, fills and empties; says in one line why nothing can be compiled."""

from __future__ import annotations

from functools import partial
from pathlib import Path

import pytest

from nospill.compiled.entries import cache_entries
from nospill.warmup import warming
from nospill.warmup.usual import Part
from tests.cli.commands import nospill


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """No cache yet; compilation is on."""
    monkeypatch.setenv("NOSPILL_CACHE", str(tmp_path / "cache"))
    monkeypatch.setenv("NOSPILL_COMPILE", "background")
    monkeypatch.setenv("CC", "true")
    return tmp_path / "cache"


def made_up(folder: Path, name: str) -> Part:
    """A part whose functions are a file of 2 MB."""

    def make() -> None:
        (folder / f"{name}-{'0' * 32}.so").write_bytes(bytes(2_000_000))

    return Part(f"{name}: problem", make)


def stop(part: Part) -> None:
    part.make()
    raise KeyboardInterrupt


def test_the_list_of_an_empty_cache(folder: Path) -> None:
    result = nospill("cache")
    assert result.exit_code == 0
    assert str(folder) in result.stdout.replace("\n", "") and "0.0" in result.stdout
    assert not folder.exists()


def test_warm_makes_every_usual_part_and_clear_removes_them(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    parts = [made_up(folder, "tray"), made_up(folder, "object")]
    monkeypatch.setattr(warming, "usual_parts", lambda: iter(parts))
    result = nospill("cache", "--warm")
    assert result.exit_code == 0
    assert [item.kind for item in cache_entries()] == ["object", "tray"]
    assert "1 of 2" in result.stderr and "2 of 2" in result.stderr
    assert "object" in result.stdout and "4.0" in result.stdout
    assert nospill("cache", "--clear").stdout == "2 files removed\n"
    assert cache_entries() == ()


def test_stopped_it_keeps_what_it_has(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    first, second = made_up(folder, "tray"), made_up(folder, "object")
    parts = [Part(first.label, partial(stop, first)), second]
    monkeypatch.setattr(warming, "usual_parts", lambda: iter(parts))
    result = nospill("cache", "--warm")
    assert result.exit_code == 130
    assert [item.kind for item in cache_entries()] == ["tray"]
    assert "tray" in result.stdout


@pytest.mark.parametrize(
    ("name", "value", "message"),
    [("CC", "/nonexistent/cc", "there is no C compiler"), ("NOSPILL_COMPILE", "off", "NOSPILL_COMPILE=off")],
)
def test_where_nothing_can_be_compiled_one_line_says_so(
    folder: Path, monkeypatch: pytest.MonkeyPatch, name: str, value: str, message: str
) -> None:
    monkeypatch.setenv(name, value)
    result = nospill("cache", "--warm")
    assert result.exit_code == 2
    assert message in result.stderr and len(result.stderr.strip().splitlines()) == 1
    assert not folder.exists()


def test_a_folder_that_others_may_write_to_is_refused(folder: Path) -> None:
    folder.mkdir(mode=0o700)
    folder.chmod(0o777)
    with pytest.warns(RuntimeWarning, match="chmod go-w"):
        result = nospill("cache", "--warm")
    assert result.exit_code == 2 and "chmod go-w" in result.stderr
