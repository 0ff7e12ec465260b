"""Atomic writing: killed, doubled, refused and full-disk runs leave the old folder or none."""

from __future__ import annotations

import errno
import os
import signal
import subprocess
import sys
import textwrap
from contextlib import suppress
from functools import partial
from pathlib import Path

import pytest

from nospill.core import files
from nospill.core.files import atomic_text
from nospill.errors import NospillError, PlanFolderError
from nospill.plans.names import STOPS_FIGURE, STOPS_FILE, STOPS_FOLDER, SUMMARY_FILE, is_plan_folder
from tests.waiting import finished

atomic_folder = partial(files.atomic_folder, replaceable=is_plan_folder)
require_replaceable = partial(files.require_replaceable, replaceable=is_plan_folder)

OLD_PLAN = {"trajectory.csv": "old", "summary.json": "{}"}


def make_plan(folder: Path, content: str = "old") -> Path:
    folder.mkdir(parents=True)
    (folder / "trajectory.csv").write_text(content)
    (folder / "summary.json").write_text("{}")
    return folder


def content(folder: Path) -> dict[str, str]:
    return {str(p.relative_to(folder)): p.read_text() for p in sorted(folder.rglob("*")) if p.is_file()}


def run(script: str, *arguments: str, **options: object) -> subprocess.Popen[str]:
    return subprocess.Popen(
        [sys.executable, "-c", textwrap.dedent(script), *arguments],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        **options,  # type: ignore[call-overload]
    )


def test_new_folder_with_missing_parents(tmp_path: Path) -> None:
    target = tmp_path / "out" / "deep" / "plan"
    with atomic_folder(target) as folder:
        assert folder.parent == target.parent
        assert not target.exists()
        (folder / "figures").mkdir()
        (folder / "figures" / "one.txt").write_text("1")
        (folder / "summary.json").write_text("{}")
    assert content(target) == {"figures/one.txt": "1", "summary.json": "{}"}
    assert os.listdir(target.parent) == ["plan"]


def test_old_plan_is_replaced_whole(tmp_path: Path) -> None:
    target = make_plan(tmp_path / "plan")
    (target / "robot.csv").write_text("from an earlier run")
    with atomic_folder(target) as folder:
        (folder / "summary.json").write_text("new")
        assert (target / "robot.csv").exists()
    assert content(target) == {"summary.json": "new"}
    assert os.listdir(tmp_path) == ["plan"]


def test_a_plan_folder_with_foreign_files_is_kept(tmp_path: Path) -> None:
    target = make_plan(tmp_path / "plan")
    (target / "thesis.tex").write_text("years of work")
    before = content(target)
    with (
        pytest.raises(PlanFolderError, match="holds files that nospill did not write"),
        atomic_folder(target) as folder,
    ):
        (folder / "summary.json").write_text("new")
    assert content(target) == before


def test_usual_permissions(tmp_path: Path) -> None:
    plain = tmp_path / "plain"
    plain.mkdir()
    with atomic_folder(tmp_path / "plan") as folder:
        (folder / "summary.json").write_text("{}")
    assert (tmp_path / "plan").stat().st_mode == plain.stat().st_mode


@pytest.mark.parametrize("failure", [ValueError("x"), KeyboardInterrupt(), NospillError("said why")])
def test_error_in_the_body_leaves_the_old_folder(tmp_path: Path, failure: BaseException) -> None:
    target = make_plan(tmp_path / "plan")
    with pytest.raises(type(failure)), atomic_folder(target) as folder:
        (folder / "trajectory.csv").write_text("half")
        raise failure
    assert content(target) == OLD_PLAN
    assert os.listdir(tmp_path) == ["plan"]


@pytest.mark.parametrize("name", ["thesis.tex", "Summary.json", ".git"])
def test_foreign_folder_is_refused_before_and_inside(tmp_path: Path, name: str) -> None:
    target = tmp_path / "home"
    target.mkdir()
    (target / name).write_text("dear")
    for call in (require_replaceable, lambda place: atomic_folder(place).__enter__()):
        with pytest.raises(PlanFolderError, match=r"holds files that nospill did not write; name a new or an empty"):
            call(target)
    assert content(target) == {name: "dear"}


def test_stops_of_a_plan_go_with_it(tmp_path: Path) -> None:
    target = tmp_path / "plan"
    (target / STOPS_FOLDER).mkdir(parents=True)
    for name in (SUMMARY_FILE, STOPS_FILE, STOPS_FIGURE):
        (target / name).write_text("of the plan before")
    with atomic_folder(target) as folder:
        (folder / SUMMARY_FILE).write_text("new")
    assert [item.name for item in target.iterdir()] == [SUMMARY_FILE]


def test_folder_that_became_foreign_meanwhile_is_kept(tmp_path: Path) -> None:
    target = tmp_path / "plan"
    with pytest.raises(PlanFolderError, match="did not write"), atomic_folder(target) as folder:
        (folder / "summary.json").write_text("{}")
        target.mkdir()
        (target / "thesis.tex").write_text("dear")
    assert content(target) == {"thesis.tex": "dear"}
    assert os.listdir(tmp_path) == ["plan"]


def test_empty_folder_and_symbolic_link_are_followed(tmp_path: Path) -> None:
    (tmp_path / "real").mkdir()
    (tmp_path / "link").symlink_to("real")
    with atomic_folder(tmp_path / "link") as folder:
        (folder / "summary.json").write_text("{}")
    assert (tmp_path / "link").is_symlink()
    assert content(tmp_path / "real") == {"summary.json": "{}"}


def test_own_rule_for_what_may_be_replaced(tmp_path: Path) -> None:
    target = tmp_path / "figures"
    target.mkdir()
    (target / "a.png").write_text("old")

    def only_pictures(names: set[str]) -> bool:
        return all(name.endswith(".png") for name in names)

    with atomic_folder(target, replaceable=only_pictures) as folder:
        (folder / "b.png").write_text("new")
    assert content(target) == {"b.png": "new"}


@pytest.mark.parametrize("where", [".", "..", ""])
def test_the_folder_we_are_in_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, where: str) -> None:
    inside = tmp_path / "empty" / "inside"
    inside.mkdir(parents=True)
    monkeypatch.chdir(inside)
    with pytest.raises(PlanFolderError, match=r"holds the folder you are in|did not write"):
        require_replaceable(where)
    assert inside.exists()


def test_file_in_the_way_and_file_as_parent(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("dear")
    for target in (tmp_path / "file", tmp_path / "file" / "plan"):
        with pytest.raises(PlanFolderError, match=r"^cannot write .*file.*: Not a directory; make room") as caught:
            require_replaceable(target)
        assert "\n" not in str(caught.value)
    assert (tmp_path / "file").read_text() == "dear"


def test_links_in_a_circle_and_unknown_user(tmp_path: Path) -> None:
    (tmp_path / "a").symlink_to("b")
    (tmp_path / "b").symlink_to("a")
    for target in (tmp_path / "a", "~nobody-of-this-name/plan"):
        with pytest.raises(PlanFolderError, match=r"^cannot write "):
            require_replaceable(target)


def test_checking_writes_nothing(tmp_path: Path) -> None:
    assert require_replaceable(tmp_path / "out" / "plan") == tmp_path / "out" / "plan"
    assert os.listdir(tmp_path) == []


def test_read_only_parent(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(os, "access", lambda *_: False)
    with pytest.raises(PlanFolderError, match=r"cannot write .*plan: no permission to write in .*; make room, ask"):
        require_replaceable(tmp_path / "plan")


@pytest.mark.skipif(os.geteuid() == 0, reason="root may write everywhere")
def test_read_only_parent_for_real(tmp_path: Path) -> None:
    tmp_path.chmod(0o500)
    try:
        with pytest.raises(PlanFolderError, match="no permission"):
            require_replaceable(tmp_path / "plan")
    finally:
        tmp_path.chmod(0o700)


@pytest.mark.parametrize("stage", ["body", "flush", "rename"])
def test_disk_that_refuses_leaves_the_old_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, stage: str) -> None:
    target = make_plan(tmp_path / "plan")
    full = OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
    rename = Path.rename

    def refuse(*_: object) -> None:
        raise full

    def refuse_new(self: Path, place: Path) -> Path:
        return refuse() if self.suffix == ".partial" else rename(self, place)  # type: ignore[return-value]

    if stage == "flush":
        monkeypatch.setattr(files, "_flush", refuse)
    if stage == "rename":
        monkeypatch.setattr(files, "_exchange", lambda *_: False)
        monkeypatch.setattr(Path, "rename", refuse_new)
    with (
        pytest.raises(PlanFolderError, match="No space left on device; make room") as caught,
        atomic_folder(target) as f,
    ):
        (f / "summary.json").write_text("new")
        if stage == "body":
            refuse()
    assert "\n" not in str(caught.value)
    assert content(target) == OLD_PLAN
    assert os.listdir(tmp_path) == ["plan"]


def test_file_size_limit_of_the_system(tmp_path: Path) -> None:
    """A real refusal by the kernel, not a stand-in: no file of this process may pass 1000 bytes."""
    target = make_plan(tmp_path / "plan")
    script = """
        import resource, sys
        from nospill.errors import PlanFolderError
        from nospill.core.files import atomic_folder
        from nospill.plans.names import is_plan_folder
        resource.setrlimit(resource.RLIMIT_FSIZE, (1000, 1000))
        try:
            with atomic_folder(sys.argv[1], replaceable=is_plan_folder) as folder:
                (folder / "summary.json").write_text("{}" * 5000)
        except PlanFolderError as error:
            print(error)
    """
    process = run(script, str(target))
    out, err = finished(process, "the writer that may not write so much")
    assert "File too large" in out, err
    assert content(target) == OLD_PLAN
    assert os.listdir(tmp_path) == ["plan"]


@pytest.mark.parametrize("old", [True, False])
@pytest.mark.parametrize("stage", ["body", "between"])
def test_kill_nine(tmp_path: Path, old: bool, stage: str) -> None:
    """Killed in the body: exactly what was there. Killed between two renames: the old or none, never half."""
    target = tmp_path / "plan"
    if old:
        make_plan(target)
    script = """
        import sys, time
        from pathlib import Path
        from nospill.core import files
        from nospill.core.files import atomic_folder
        from nospill.plans.names import is_plan_folder
        target, stage = sys.argv[1:]
        files._exchange = lambda *_: False
        rename = Path.rename
        def slow(self, place):
            if self.suffix == ".partial":
                print("ready", flush=True)
                time.sleep(60)
            return rename(self, place)
        if stage == "between":
            Path.rename = slow
        with atomic_folder(target, replaceable=is_plan_folder) as folder:
            (folder / "trajectory.csv").write_text("half")
            if stage == "body":
                print("ready", flush=True)
                time.sleep(60)
            (folder / "summary.json").write_text("new")
    """
    process = run(script, str(target), stage)
    assert process.stdout is not None
    assert process.stdout.readline() == "ready\n"
    process.send_signal(signal.SIGKILL)
    finished(process, "the killed writer")
    if old and stage == "body":
        assert content(target) == OLD_PLAN
    else:
        assert not target.exists()
    with atomic_folder(target) as folder:
        (folder / "summary.json").write_text("next run")
    assert content(target) == {"summary.json": "next run"}


@pytest.mark.skipif(files.fcntl is None, reason="no locks on folders here")
def test_partial_folders_of_killed_runs_are_deleted_by_the_next(tmp_path: Path) -> None:
    target, others = tmp_path / "plan", ("plan.abcd.partial", ".other.0a1b2c3d.partial", ".plan.0a1b2c3d.old")
    dead, young = tmp_path / ".plan.0a1b2c3d.partial", tmp_path / ".plan.1a1b2c3d.partial"
    for folder in (dead, young, *(tmp_path / name for name in others)):
        folder.mkdir()
        (folder / "trajectory.csv").write_text("half")
        if folder != young:
            os.utime(folder, (0, 0))
    with atomic_folder(target) as first:
        (first / "summary.json").write_text("{}")
        os.utime(first, (0, 0))
        assert not dead.exists() and young.exists()
        with atomic_folder(target) as second:
            assert first.exists(), "it is still being written"
            (second / "summary.json").write_text("{}")
    assert sorted(os.listdir(tmp_path)) == sorted([*others, "plan", young.name])


@pytest.mark.slow
def test_many_writers_at_once(tmp_path: Path) -> None:
    """Four processes replace one folder 40 times each: whatever stands there is whole, and one whole plan stays."""
    target = tmp_path / "plan"
    script = """
        import sys
        from nospill.core.files import atomic_folder
        from nospill.plans.names import is_plan_folder
        target, who = sys.argv[1:]
        for turn in range(40):
            with atomic_folder(target, replaceable=is_plan_folder) as folder:
                for name in ("trajectory.csv", "certificate.json", "summary.json"):
                    (folder / name).write_text(f"{who}-{turn}")
    """
    writers = [run(script, str(target), str(who)) for who in range(4)]
    looks = 0
    while any(writer.poll() is None for writer in writers):
        try:
            handle = os.open(target, os.O_RDONLY)
        except FileNotFoundError:
            continue
        if len(os.listdir(handle)) == 3:
            looks += 1
        else:  # seen while it was being deleted: then it no longer stands at the target
            with suppress(FileNotFoundError):
                assert not os.path.samestat(os.stat(target), os.fstat(handle))
        os.close(handle)
    for writer in writers:
        _, err = finished(writer, "one of the writers")
        assert writer.returncode == 0, err
    assert len(set(content(target).values())) == 1
    assert len(content(target)) == 3
    assert looks > 0
    assert os.listdir(tmp_path) == ["plan"]


def test_text_is_replaced_at_once_and_exact(tmp_path: Path) -> None:
    path = tmp_path / "a.csv"
    path.write_text("old")
    atomic_text(path, "1;2\n\u00b0\r\n")
    assert path.read_bytes() == "1;2\n\u00b0\r\n".encode()
    assert os.listdir(tmp_path) == ["a.csv"]


def test_text_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "folder").mkdir()
    for path in (tmp_path / "folder", tmp_path / "missing" / "a.csv"):
        with pytest.raises(PlanFolderError, match=r"^cannot write "):
            atomic_text(path, "x")
    keep = tmp_path / "keep.csv"
    keep.write_text("old")

    def refuse(_: int) -> None:
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    monkeypatch.setattr(os, "fsync", refuse)
    with pytest.raises(PlanFolderError, match="No space left"):
        atomic_text(keep, "new")
    assert keep.read_text() == "old"
    assert sorted(os.listdir(tmp_path)) == ["folder", "keep.csv"]
