"""Scripts of examples/, each run to its end in a folder of its own.

In the process of the tests, where packages are imported and functions made once for all of them, and warnings are
errors. What a script imports itself is checked with the types; the script of the README has a process of its own.
"""

from __future__ import annotations

import runpy
from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.repository.modules import ROOT, label

SCRIPTS = sorted((ROOT / "examples").glob("*.py"))


@pytest.fixture(autouse=True)
def no_figure_stays_open() -> Iterator[None]:
    yield
    from matplotlib import pyplot

    pyplot.close("all")


@pytest.mark.parametrize("script", SCRIPTS, ids=label)
def test_a_script_is_short_and_says_what_it_shows(script: Path) -> None:
    lines = script.read_text(encoding="utf-8").splitlines()
    assert 15 <= len(lines) <= 60
    assert lines[0].startswith('"""')


@pytest.mark.slow
@pytest.mark.parametrize("script", SCRIPTS, ids=label)
def test_a_script_runs_and_prints(
    script: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    runpy.run_path(str(script), run_name="__main__")
    assert capsys.readouterr().out
