"""nospill view as a user calls it, without a browser."""

from __future__ import annotations

import re
import signal
import subprocess
import sys
import time
from dataclasses import replace
from pathlib import Path

import pytest
from typer.testing import CliRunner, Result

from nospill.cli import app
from nospill.drawing.timeline import Film
from nospill.plans.approach import judged
from nospill.viewer.words import title_of
from tests.waiting import finished, first_line


def run(*arguments: str) -> Result:
    return CliRunner().invoke(app, ["view", *arguments])


def test_without_viser_one_line_says_what_to_install(folders: tuple[str, str], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "viser", None)
    result = run(folders[0])
    assert result.exit_code == 2
    assert result.stderr == 'viewing needs viser, which is not installed; pip install "nospill[view]"\n'


@pytest.mark.slow
def test_file_of_two_plans(folders: tuple[str, str], tmp_path: Path) -> None:
    pytest.importorskip("viser", reason="viser is not installed")
    target = tmp_path / "both.html"
    result = run(*folders, "--html", str(target))
    assert result.exit_code == 0, result.output
    assert result.stdout == f"written to {target} ({target.stat().st_size / 1e6:.1f} MB)\n"
    assert target.stat().st_size < 5_000_000
    page = target.read_text()
    assert "<title>matrix-liquid (level)" in page
    assert not re.findall(r"<(?:script|link|img)[^>]+(?:src|href)=[\"']?https?:", page)
    assert [path.name for path in tmp_path.iterdir()] == ["both.html"]


def test_title_has_the_verdict_on_what_is_shown(tilting_film: Film) -> None:
    """A folder may say what it likes: the motion is judged again, as a report does."""
    plan = tilting_film.plan
    saved = replace(plan, certificate=replace(plan.certificate, ok=not plan.certificate.ok))
    film = replace(tilting_film, plan=saved, judgement=judged(saved))
    word = plan.certificate.word
    assert title_of(film).endswith(f" s, {word}")


@pytest.mark.slow
@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["nowhere"], "nowhere: no such folder"),
        (["{}", "nowhere"], "nowhere: no such folder"),
        (["{}", "--html", "nowhere/x.html"], "cannot write"),
        (["{}", "--urdf", "nowhere.urdf"], "nowhere.urdf: cannot be read"),
    ],
)
def test_mistakes_are_one_line(folders: tuple[str, str], tmp_path: Path, arguments: list[str], words: str) -> None:
    pytest.importorskip("viser", reason="viser is not installed")
    result = run(*[item.format(folders[0]) for item in arguments])
    assert result.exit_code == 2
    assert words in result.stderr
    assert result.stderr.count("\n") == 1


@pytest.mark.slow
def test_missing_meshes_are_said(folders: tuple[str, str], tmp_path: Path, tilting_film: Film) -> None:
    pytest.importorskip("viser", reason="viser is not installed")
    text = tilting_film.plan.scene.robot.urdf
    visual = '<link name="link_1"><visual><geometry><mesh filename="a.stl"/></geometry></visual></link>'
    (tmp_path / "arm.urdf").write_text(text.replace('<link name="link_1"/>', visual))
    result = run(folders[1], "--urdf", str(tmp_path / "arm.urdf"), "--html", str(tmp_path / "x.html"))
    assert result.exit_code == 0
    assert "1 meshes are missing (a.stl, ...); links are drawn instead" in result.stderr


@pytest.mark.slow
def test_live_viewer_names_its_address_and_ends_with_ctrl_c(folders: tuple[str, str]) -> None:
    pytest.importorskip("viser", reason="viser is not installed")
    code = "from nospill.cli import main; main()"
    arguments = [sys.executable, "-c", code, "view", folders[1], "--port", "0", "--no-browser"]
    with subprocess.Popen(arguments, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as process:
        try:
            address = first_line(process, "nospill view")
            time.sleep(0.2)
            process.send_signal(signal.SIGINT)
            rest, complaints = finished(process, "nospill view after Ctrl-C")
        finally:
            process.kill()
    assert re.fullmatch(r"http://127\.0\.0\.1:\d+ {2}\(stop with Ctrl-C\)\n", address)
    assert (process.returncode, rest, complaints) == (0, "", "")
