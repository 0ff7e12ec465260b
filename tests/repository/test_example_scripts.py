"""Scripts of examples/, each run to its end in a folder of its own.

In the process of the tests, where packages are imported and functions made once for all of them, and warnings are
errors. What a script imports itself is checked with the types; the script of the README has a process of its own.
Scenes that a script loads are planned on a coarse grid with one mode; fifty variants are five, the film has fewer
pictures, and the limit of one's own is kept with one cup. What is tried is that every line runs, not what the planner
finds; the pages show whole runs.
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


COARSE = {"planning.intervals": 40, "planning.slosh_modes": 1}
ONE_CUP = '.changed({"cargo": ns.load("matrix-liquid").source["cargo"][:1]})'
FEWER = {
    "fifty_variants.py": ("0.60, 50)", "0.60, 5)"),
    "report_and_film.py": ("rate=10)", "rate=2)"),
    "own_limit.py": ('ns.load("matrix-liquid")', f'ns.load("matrix-liquid"){ONE_CUP}'),
}


@pytest.fixture
def coarse_scenes(monkeypatch: pytest.MonkeyPatch) -> None:
    import nospill as ns

    load = ns.load
    monkeypatch.setattr(ns, "load", lambda name: load(name).changed(COARSE), raising=False)


@pytest.mark.slow
@pytest.mark.usefixtures("coarse_scenes")
@pytest.mark.parametrize("script", SCRIPTS, ids=label)
def test_a_script_runs_and_prints(
    script: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    if script.name in FEWER:
        text = script.read_text(encoding="utf-8")
        many, few = FEWER[script.name]
        assert text.count(many) == 1
        script = tmp_path / script.name
        script.write_text(text.replace(many, few), encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    runpy.run_path(str(script), run_name="__main__")
    assert capsys.readouterr().out
