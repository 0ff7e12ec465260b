"""Plan folders under attack: killed writers, a full disk, folders nobody may write, two plans at once, links."""

from __future__ import annotations

import errno
import os
import signal
import subprocess
import sys
import textwrap
import time
from collections.abc import Callable
from pathlib import Path

import pytest

from nospill.cli import app
from nospill.core import files
from nospill.errors import PlanFolderError
from nospill.plans.loading import load_plan
from nospill.plans.plan import Plan
from tests.waiting import finished

NAMES = {"scenario.toml", "trajectory.csv", "certificate.json", "summary.json", "robot.csv"}

WRITER = """
    import sys
    from nospill.plans.loading import load_plan
    plan = load_plan(sys.argv[1])
    print("ready", flush=True)
    for _ in range(int(sys.argv[3])):
        plan.save(sys.argv[2])
    print("done", flush=True)
"""


def run(script: str, *words: str) -> subprocess.Popen[str]:
    command = [sys.executable, "-c", textwrap.dedent(script), *words]
    return subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)


def content(folder: Path) -> dict[str, bytes]:
    return {str(place.relative_to(folder)): place.read_bytes() for place in folder.rglob("*") if place.is_file()}


def whole(folder: Path, plan: Plan) -> None:
    """It is a plan folder that is read, with the motion in it."""
    assert set(content(folder)) <= NAMES
    assert load_plan(folder).duration == plan.duration


@pytest.mark.slow
@pytest.mark.parametrize("after", [0.0, 0.005, 0.02])
def test_killed_at_any_moment(saved: Path, small_plan: Plan, tmp_path: Path, after: float) -> None:
    """kill -9 while a plan is written again and again: under its name, or aside, there is a whole plan."""
    target = tmp_path / "out" / "plan"
    small_plan.save(target)
    writer = run(WRITER, str(saved), str(target), "1000")
    assert writer.stdout is not None and writer.stdout.readline() == "ready\n"
    time.sleep(0.05 + after)
    writer.send_signal(signal.SIGKILL)
    finished(writer, "the killed writer")
    aside = [place for place in target.parent.iterdir() if place.suffix == ".old"]
    # What was moved aside may be half removed, but only once the new folder has the name.
    kept = [target] if target.exists() else aside
    assert kept, "the old plan is gone and the new one not there"
    for place in kept:
        whole(place, small_plan)
    small_plan.save(target)  # what is left does not disturb the next run
    whole(target, small_plan)


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="names are exchanged in one step on Linux only")
def test_both_plans_are_whole_until_they_exchange_their_names(
    saved: Path, small_plan: Plan, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Whenever a writer is killed: what the moments above meet by chance."""
    exchange, seen = files._exchange, []

    def looked_at(partial: Path, place: Path) -> bool:
        seen.extend((partial, place))
        for folder in seen:
            whole(folder, small_plan)
        return exchange(partial, place)

    monkeypatch.setattr(files, "_exchange", looked_at)
    small_plan.save(saved)
    assert len(seen) == 2
    whole(saved, small_plan)


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="names are exchanged in one step on Linux only")
def test_killed_before_the_old_folder_is_deleted_the_plan_keeps_its_name(saved: Path, tmp_path: Path) -> None:
    target = tmp_path / "out" / "plan"
    load_plan(saved).save(target)
    script = """
        import os, shutil, sys
        from nospill.plans.loading import load_plan
        plan = load_plan(sys.argv[1])
        shutil.rmtree = lambda *_, **__: os.kill(os.getpid(), 9)
        plan.save(sys.argv[2])
    """
    finished(run(script, str(saved), str(target)), "the writer that kills itself")
    assert target.is_dir()


def test_a_disk_that_is_full(saved: Path, small_plan: Plan, tmp_path: Path) -> None:
    """No file of this process may pass 2 kB: the kernel refuses as a full disk does, in the middle of a file."""
    target = tmp_path / "out" / "plan"
    small_plan.save(target)
    before = content(target)
    script = """
        import resource, sys
        from nospill.errors import NospillError
        from nospill.plans.loading import load_plan
        plan = load_plan(sys.argv[1])
        resource.setrlimit(resource.RLIMIT_FSIZE, (2000, 2000))
        try:
            plan.save(sys.argv[2])
        except NospillError as error:
            print(error)
    """
    out, errors = finished(run(script, str(saved), str(target)), "the writer on a full disk")
    assert "cannot write" in out and len(out.splitlines()) == 1, errors
    assert content(target) == before and os.listdir(target.parent) == ["plan"]


@pytest.mark.parametrize("name", sorted(NAMES - {"robot.csv"}))
def test_no_space_left_for_any_of_the_files(
    saved: Path, small_plan: Plan, monkeypatch: pytest.MonkeyPatch, name: str
) -> None:
    before = content(saved)
    write = Path.write_text

    def refuse(self: Path, *words: object, **more: object) -> int:
        if self.name == name:
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        return write(self, *words, **more)  # type: ignore[arg-type]

    monkeypatch.setattr(Path, "write_text", refuse)
    with pytest.raises(PlanFolderError, match="No space left on device; make room"):
        small_plan.save(saved)
    assert content(saved) == before and os.listdir(saved.parent) == ["plan"]


@pytest.mark.skipif(os.geteuid() == 0, reason="root may write into folders that are read-only")
def test_a_folder_that_is_read_only(small_plan: Plan, tmp_path: Path) -> None:
    tmp_path.chmod(0o500)
    try:
        with pytest.raises(PlanFolderError, match="no permission"):
            small_plan.save(tmp_path / "plan")
    finally:
        tmp_path.chmod(0o700)
    assert not any(tmp_path.iterdir())


def test_a_folder_in_which_nothing_can_be_made(small_plan: Plan) -> None:
    """/proc is read-only for everybody, root too."""
    with pytest.raises(PlanFolderError, match="cannot write"):
        small_plan.save("/proc/nospill-plan")


def test_the_command_line_says_so_before_it_plans(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    (tmp_path / "thesis").mkdir()
    (tmp_path / "thesis" / "chapter.tex").write_text("years of work")

    def planned(*_: object, **__: object) -> None:
        pytest.fail("planned before the folder was looked at")

    monkeypatch.setattr("nospill.planning.planner.plan", planned)
    with pytest.raises(SystemExit) as caught:
        app(["plan", "matrix-liquid", "-o", str(tmp_path / "thesis")])
    assert caught.value.code == 2
    assert "holds files that nospill did not write" in capsys.readouterr().err
    assert content(tmp_path) == {"thesis/chapter.tex": b"years of work"}


@pytest.mark.slow
def test_two_plans_into_one_folder(saved: Path, small_plan: Plan, tmp_path: Path) -> None:
    target = tmp_path / "out" / "plan"
    writers = [run(WRITER, str(saved), str(target), "4") for _ in range(2)]
    for writer in writers:
        out, errors = finished(writer, "one of two writers")
        assert out == "ready\ndone\n", errors
    whole(target, small_plan)
    assert os.listdir(target.parent) == ["plan"]


@pytest.mark.slow
@pytest.mark.parametrize("there", ["plan", "foreign", "nothing"])
def test_a_link_in_the_place_of_the_folder(small_plan: Plan, tmp_path: Path, there: str) -> None:
    """It is followed, and what it leads to is held to the same rule."""
    outside = tmp_path / "elsewhere" / "kept"
    if there == "plan":
        small_plan.save(outside)
    elif there == "foreign":
        outside.mkdir(parents=True)
        (outside / "thesis.tex").write_text("years of work")
    (tmp_path / "link").symlink_to(outside)
    if there == "foreign":
        with pytest.raises(PlanFolderError, match="holds files that nospill did not write"):
            small_plan.save(tmp_path / "link")
        assert content(outside) == {"thesis.tex": b"years of work"}
        return
    small_plan.save(tmp_path / "link")
    assert (tmp_path / "link").is_symlink()
    whole(outside, small_plan)


def test_links_inside_the_old_folder_are_not_followed(saved: Path, small_plan: Plan, tmp_path: Path) -> None:
    """Taking the old plan away removes the link in it and not what it leads to."""
    (tmp_path / "valued").mkdir()
    (tmp_path / "valued" / "chapter.tex").write_text("years of work")
    (saved / "figures").symlink_to(tmp_path / "valued")
    small_plan.save(saved)
    assert content(tmp_path / "valued") == {"chapter.tex": b"years of work"}
    assert not (saved / "figures").exists()


def test_figures_that_fail_leave_the_old_plan(saved: Path, small_plan: Plan) -> None:
    before = content(saved)

    def stop(folder: Path) -> None:
        raise KeyboardInterrupt

    extra: Callable[[Path], None] = stop
    with pytest.raises(KeyboardInterrupt):
        small_plan.save(saved, extra=extra)
    assert content(saved) == before and os.listdir(saved.parent) == ["plan"]
