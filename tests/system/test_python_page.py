"""The snippets of the page "From Python" run as they stand, section by section."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

PAGE = Path(__file__).parents[2] / "docs" / "python.md"


def snippets() -> dict[str, list[str]]:
    """The Python of every section of the page, by its title."""
    found = {}
    for section in PAGE.read_text(encoding="utf-8").split("\n## ")[1:]:
        code = re.findall(r"^```python\n(.*?)^```", section, re.MULTILINE | re.DOTALL)
        if code:
            found[section.partition("\n")[0]] = code
    return found


def test_the_page_has_snippets() -> None:
    assert sum(map(len, snippets().values())) >= 5


@pytest.mark.slow
@pytest.mark.parametrize("section", snippets())
def test_snippets_run(section: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    names: dict[str, object] = {"__name__": "__main__"}
    for code in snippets()[section]:
        exec(compile(code, f"{PAGE.name}, {section}", "exec"), names)
