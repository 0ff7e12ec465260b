"""The worked examples of the page on extending: done to a copy of the package as the page says, and tried."""

from __future__ import annotations

import os
import shutil
from pathlib import Path

import pytest
from nospill_docs.extending import apply_example

from tests.repository.modules import ROOT
from tests.waiting import run_python

EXAMPLES = sorted(path for path in (ROOT / "docs" / "examples" / "extending").iterdir() if path.is_dir())


@pytest.fixture
def extended(tmp_path: Path, request: pytest.FixtureRequest) -> Path:
    """A folder with a copy of the package, changed as the example says."""
    package = tmp_path / "nospill"
    shutil.copytree(ROOT / "src" / "nospill", package)  # with the bytecode of the files that stay as they are
    apply_example(request.param, package)
    return tmp_path


@pytest.mark.slow
@pytest.mark.parametrize(
    ("extended", "example"), [(e, e) for e in EXAMPLES], ids=[e.name for e in EXAMPLES], indirect=["extended"]
)
def test_a_worked_example_does_what_its_page_says(extended: Path, example: Path) -> None:
    settings = {"PYTHONPATH": str(extended), "PYTHONDONTWRITEBYTECODE": "1", "NOSPILL_COMPILE": "wait"}
    tried = run_python("-W", "error", str(example / "try_it.py"), cwd=extended, env={**os.environ, **settings})
    assert tried.returncode == 0, tried.stderr
    assert tried.stdout


def test_there_is_one_for_each_family() -> None:
    assert [example.name for example in EXAMPLES] == ["constraint", "exporter", "robot", "shape"]
