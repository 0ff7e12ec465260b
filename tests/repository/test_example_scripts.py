"""Scripts of examples/, each run as a user runs it, in a folder of its own."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.repository.modules import ROOT, label
from tests.waiting import run_python

SCRIPTS = sorted((ROOT / "examples").glob("*.py"))


@pytest.mark.parametrize("script", SCRIPTS, ids=label)
def test_a_script_is_short_and_says_what_it_shows(script: Path) -> None:
    lines = script.read_text(encoding="utf-8").splitlines()
    assert 15 <= len(lines) <= 60
    assert lines[0].startswith('"""')


@pytest.mark.slow
@pytest.mark.parametrize("script", SCRIPTS, ids=label)
def test_a_script_runs_and_prints(script: Path, tmp_path: Path) -> None:
    done = run_python("-W", "error", str(script), cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    assert done.stdout
