"""nospill report and the record of verify beside a folder: what is written where, and what is refused."""

from __future__ import annotations

import json
import math
import os
from pathlib import Path

import pytest
from typer.testing import CliRunner, Result

from nospill.cli import app
from nospill.cli.sharing import report_place
from nospill.errors import PlanFolderError
from nospill.plans.plan import Plan
from nospill.report import make_report, read_second_opinion, save_report, writing
from nospill.report.second_opinion import NOT_ASKED, second_opinion
from nospill.scene.scene import Scene
from nospill.verify import ObjectReport, Peak, Thresholds, VerifyReport
from tests.waiting import run_python


def nospill(*arguments: str | Path) -> Result:
    return CliRunner().invoke(app, [str(item) for item in arguments], catch_exceptions=False, prog_name="nospill")


def simulated(scene: Scene, *, moved: str | None = None) -> VerifyReport:
    items = tuple(
        ObjectReport(
            item.name,
            slide=Peak(0.004 if item.name == moved else 1e-5, 0.7),
            rotation=Peak(math.radians(0.1), 0.2),
            tilt=Peak(0.0, 0.0),
            lift_off=Peak(0.0, 0.0),
            moved_at=0.65 if item.name == moved else None,
        )
        for item in scene.cargo
    )
    return VerifyReport(items, Thresholds(), "trajectory.csv", "MuJoCo 9.9", 2.5)


@pytest.fixture
def no_figures(monkeypatch: pytest.MonkeyPatch) -> None:
    """Pages without figures, where something else is looked at."""
    monkeypatch.setattr(writing, "report_svgs", lambda _: {})


def record(folder: Path, report: VerifyReport) -> Path:
    path = folder.with_name(f"{folder.name}.verify.json")
    path.write_text(json.dumps(report.to_dict()), encoding="utf-8")
    return path


@pytest.mark.slow
def test_page_goes_beside_the_folder_and_nothing_into_it(folder: Path) -> None:
    before = {path.name: path.read_bytes() for path in folder.iterdir()}
    result = nospill("report", folder)
    assert result.exit_code == 0, result.stderr
    page = folder.with_name("out.report.html")
    assert {path.name: path.read_bytes() for path in folder.iterdir()} == before
    assert {path.name for path in folder.parent.iterdir()} == {"out", "out.report.html"}
    assert result.stdout.split() == [
        *f"written to {page} ({page.stat().st_size / 1e6:.1f} MB), certified as published".split()
    ]
    text = page.read_text(encoding="utf-8")
    assert "holds the motion of trajectory.csv" in text  # robot.csv was compared
    assert 100_000 < len(text) < 3_000_000


@pytest.mark.parametrize(("given", "page"), [("out", "out.report.html"), ("./out/", "out.report.html")])
def test_the_page_is_named_as_the_folder_was(
    given: str, page: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    assert report_place(Path(given)) == Path(page)
    assert report_place(Path()) == tmp_path.with_name(f"{tmp_path.name}.report.html")


@pytest.mark.slow
@pytest.mark.usefixtures("no_figures")  # the pages without a PDF have them
def test_pdf_and_names_of_ones_own(folder: Path, tmp_path: Path) -> None:
    page, pdf = tmp_path / "a.html", tmp_path / "b.pdf"
    result = nospill("report", folder, "-o", page, "--pdf", pdf)
    assert result.exit_code == 0 and result.stdout.splitlines()[-1] == f"written to {pdf}"
    assert page.read_text(encoding="utf-8").startswith("<!DOCTYPE html>")
    assert pdf.read_bytes().startswith(b"%PDF")
    assert not (tmp_path / "out.report.html").exists()


@pytest.mark.slow
@pytest.mark.usefixtures("no_figures")
@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("-o", "out/page.html"), "holds nothing but the plan"),
        (("-o", "page.txt"), "must end in .html"),
        (("--pdf", "page.html"), "must end in .pdf"),
        (("--pdf", "out/page.pdf"), "holds nothing but the plan"),
        (("-o", "missing/page.html"), "cannot write"),
        (("--pdf", "missing/page.pdf"), "cannot write"),
    ],
)
def test_places_that_are_refused(
    folder: Path, arguments: tuple[str, str], message: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(folder.parent)
    result = nospill("report", "out", *arguments)
    assert result.exit_code == 2
    assert message in result.stderr
    assert result.stderr.strip().splitlines()[-1].count(". ") == 0
    assert not list(folder.parent.rglob("*.partial"))


def test_no_plan_no_report(tmp_path: Path) -> None:
    result = nospill("report", tmp_path / "nowhere")
    assert result.exit_code == 2 and "no such folder" in result.stderr
    assert list(tmp_path.iterdir()) == []


@pytest.mark.slow
def test_an_old_report_survives_a_disk_that_refuses(
    slow_plan: Plan, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    page, pdf = tmp_path / "a.html", tmp_path / "a.pdf"
    for path in (page, pdf):
        path.write_text("old")

    def full(_: int) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(os, "fsync", full)
    monkeypatch.setattr(writing, "report_svgs", lambda _: {})
    monkeypatch.setattr(writing, "report_pdf", lambda *_: b"new")
    with pytest.raises(PlanFolderError, match="No space left"):
        save_report(make_report(slow_plan), page)
    with pytest.raises(PlanFolderError, match="No space left"):
        writing.atomic_bytes(pdf, b"new")
    assert [path.read_text() for path in (page, pdf)] == ["old", "old"]
    assert {path.name for path in tmp_path.iterdir()} == {"a.html", "a.pdf"}


def test_plan_with_a_report_needs_a_folder(monkeypatch: pytest.MonkeyPatch) -> None:
    result = nospill("plan", "matrix-liquid", "--report")
    assert result.exit_code == 2 and "name one with -o DIR" in result.stderr


def test_importing_the_command_draws_in_nothing() -> None:
    code = "import sys, nospill.cli; print([m for m in ('matplotlib', 'casadi', 'numpy') if m in sys.modules])"
    run = run_python("-c", code, check=True)
    assert run.stdout.strip() == "[]"


# --- the record of verify ---------------------------------------------------------------------------------------------


def test_no_record_is_no_verdict(folder: Path, slow_plan: Plan) -> None:
    assert read_second_opinion(folder, slow_plan.scene) is NOT_ASKED


@pytest.mark.slow
@pytest.mark.usefixtures("no_figures")
@pytest.mark.parametrize("moved", [None, "block"])
def test_record_is_shown(folder: Path, slow_plan: Plan, moved: str | None) -> None:
    wanted = simulated(slow_plan.scene, moved=moved)
    record(folder, wanted)
    found = read_second_opinion(folder, slow_plan.scene)
    assert found == second_opinion(wanted.to_dict())
    assert found.ok is (moved is None) and found.message == wanted.message
    assert found.table is not None
    assert [row[0] for row in found.table.rows] == ["cup", "block"]
    assert found.table.failing == (() if moved is None else (1,))
    page = Path(str(folder) + ".report.html")
    assert nospill("report", folder).exit_code == 0
    text = page.read_text(encoding="utf-8")
    assert ("EVERY OBJECT STAYS" if moved is None else "AN OBJECT MOVES") in text
    assert "MuJoCo 9.9, 2.50 s simulated" in text


def test_record_of_another_plan_is_not_shown(folder: Path, slow_plan: Plan) -> None:
    path = record(folder, simulated(slow_plan.scene))
    written = (folder / "trajectory.csv").stat().st_mtime
    os.utime(path, (written - 10, written - 10))
    found = read_second_opinion(folder, slow_plan.scene)
    assert found.ok is None and "older than the plan" in found.message
    other = simulated(slow_plan.scene).to_dict()
    other["objects"][0]["name"] = "vase"
    path.write_text(json.dumps(other), encoding="utf-8")
    assert read_second_opinion(folder, slow_plan.scene).ok is None


@pytest.mark.parametrize("text", ["", "[]", "{}", '{"objects": [{}]}', '{"objects": 3}', "\xff"])
def test_damaged_record_is_named(folder: Path, slow_plan: Plan, text: str) -> None:
    path = folder.with_name("out.verify.json")
    path.write_bytes(text.encode("latin-1"))
    with pytest.raises(PlanFolderError, match=r"out\.verify\.json: damaged"):
        read_second_opinion(folder, slow_plan.scene)


@pytest.mark.slow
@pytest.mark.oracle
@pytest.mark.usefixtures("no_figures")
def test_simulation_on_request(folder: Path) -> None:
    pytest.importorskip("mujoco")
    result = nospill("report", folder, "--verify")
    assert result.exit_code == 0, result.stderr
    text = folder.with_name("out.report.html").read_text(encoding="utf-8")
    assert "EVERY OBJECT STAYS" in text and "joints from robot.csv" in text
    assert not folder.with_name("out.verify.json").exists()
