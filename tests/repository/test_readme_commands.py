"""The commands of the README, as they are printed, one after the other, in one folder."""

from __future__ import annotations

import ast
import re
import shlex
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from nospill.scenario import read_scenario
from nospill.scenario.examples import EXAMPLES
from tests.cli.commands import nospill
from tests.repository.modules import ROOT
from tests.waiting import run_python

pytestmark = pytest.mark.slow

README = (ROOT / "README.md").read_text(encoding="utf-8")
WAITS = {"view", "studio"}
"""Commands that go on until they are stopped; tests of their own start and end them."""


def commands() -> Iterator[list[str]]:
    """Words after `nospill` in every indented command line, in order."""
    for line in re.findall(r"^ {4}(?:\$ )?\.venv/bin/nospill (.+)$", README, re.MULTILINE):
        words = shlex.split(line, comments=True)
        if words[0] not in WAITS:
            yield words


def write_what_they_read(folder: Path) -> None:
    """The scenario that the README prints; a cup, a motion and a measured height for the commands that take some."""
    [scenario] = re.findall(r"```toml\n(.*?)```", README, re.DOTALL)
    (folder / "tea.toml").write_text(scenario)
    (folder / "cup.toml").write_text(
        'shape = "cylinder"\nradius = "35 mm"\nheight = "99.1 mm"\nliquid = "water"\nliquid_height = "49 mm"\n'
    )
    t = np.arange(0.0, 3.0, 0.005)
    u = np.clip(t / 2.0, 0.0, 1.0)
    x = 0.5 * (10 * u**3 - 15 * u**4 + 6 * u**5)
    rows = [
        "t_s,x_m,y_m,z_m,qx,qy,qz,qw",
        *(f"{a!r},{b!r},0,1,0,0,0,1" for a, b in zip(t.tolist(), x.tolist(), strict=True)),
    ]
    (folder / "motion.csv").write_text("\n".join(rows) + "\n")
    height = 5.0 * np.sin(16.0 * t) * (t < 2.0)
    rows = ["t_s,height_mm", *(f"{a!r},{b!r}" for a, b in zip(t.tolist(), height.tolist(), strict=True))]
    (folder / "camera.csv").write_text("\n".join(rows) + "\n")


PYTHON: str = re.findall(r"```python\n(.*?)```", README, re.DOTALL)[0]


@pytest.fixture(scope="module")
def printed(tmp_path_factory: pytest.TempPathFactory) -> tuple[str, Path]:
    """What the Python of the page prints, in a process of its own, and its folder."""
    folder = tmp_path_factory.mktemp("python")
    done = run_python("-W", "error", "-c", PYTHON, cwd=folder)
    assert done.returncode == 0, done.stderr
    return done.stdout, folder


def test_the_python_of_the_page_runs_as_printed(printed: tuple[str, Path]) -> None:
    [message] = re.findall(r"# (certified: .*) \.\.\.", PYTHON)
    assert message in printed[0] and (printed[1] / "summary.png").is_file()


def test_the_demo_leads_on_to_the_full_physics_with_its_true_figure(printed: tuple[str, Path]) -> None:
    """Its command plans the scene of the page's Python."""
    recipe = (ROOT / "Makefile").read_text(encoding="utf-8").partition("\ndemo:")[2].partition("\n\n")[0]
    [(verdict, command)] = re.findall(r'physics, (.+)"\n.+"    \$\(VENV\)/bin/nospill (.+)"', recipe)
    [plan, name, setting, value, output, place] = shlex.split(command)
    assert (plan, setting, output) == ("plan", "--set", "-o") and place
    [(loaded, changes)] = re.findall(r'ns\.load\("(.+)"\)[\s\S]+scene\.changed\((.+)\)\)\n', PYTHON)
    assert read_scenario(name, settings=[value]) == read_scenario(loaded).changed(ast.literal_eval(changes))
    status, _, duration = verdict.partition(": ")
    assert status == "certified" and duration in printed[0]


def test_the_commands_run_as_printed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    write_what_they_read(tmp_path)
    # `make demo` comes before them in the page.
    demo = ["plan", "matrix-liquid", "-o", "out/matrix-liquid"]
    assert f"`make demo` plans the bundled example `{demo[1]}`" in README and demo[1] in EXAMPLES
    listed = list(commands())
    assert {words[0] for words in listed} >= {"plan", "check"}
    for words in [demo, *listed]:
        done = nospill(*words)
        assert done.exit_code == 0, f"nospill {shlex.join(words)}: {done.stderr}"
    for words in listed:
        if "-o" in words:
            assert (tmp_path / words[words.index("-o") + 1]).exists(), words
