"""A sweep on a real Dask scheduler with two real workers; and clusters that cannot be used."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import zipfile
from collections.abc import Iterator
from io import BytesIO
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import dask.config
import pytest
from distributed import LocalCluster

import nospill
from nospill.compiled.entries import current_files
from nospill.errors import ClusterError, MissingExtraError
from nospill.scenario import load
from nospill.sweeps import cluster_set_up
from nospill.sweeps.definition import define_sweep
from nospill.sweeps.executors import cluster
from nospill.sweeps.run import SweepProgress, run_sweep

ROOT = Path(__file__).parents[2]


@pytest.fixture
def started(tmp_path: Path) -> Iterator[tuple[str, list[subprocess.Popen[bytes]]]]:
    """The address of a scheduler, and its two workers, processes as `dask worker` starts them."""
    with dask.config.set({"distributed.scheduler.worker-saturation": 1.0}):
        scheduler = LocalCluster(n_workers=0, dashboard_address=":0", scheduler_port=0)
    with scheduler:
        address = scheduler.scheduler_address
        command = [sys.executable, "-m", "dask", "worker", address, "--nthreads", "1", "--no-nanny", "--no-dashboard"]
        with (tmp_path / "workers.log").open("w") as log:
            environment = os.environ | {"PYTHONPATH": str(ROOT / "src")}
            workers = [
                subprocess.Popen(command, cwd=tmp_path, env=environment, stdout=log, stderr=log) for _ in range(2)
            ]
        try:
            yield address, workers
        finally:
            for worker in workers:
                worker.kill()
                worker.wait()


@pytest.mark.slow
def test_the_lines_of_a_cluster_are_those_of_one_process_though_a_worker_dies(
    started: tuple[str, list[subprocess.Popen[bytes]]], tmp_path: Path
) -> None:
    address, workers = started
    axes = {"tray.friction": [0.45, 0.5], "motion.tilt": ["fixed", "free"]}
    whole = load("matrix-rigid")
    scene = whole.changed({"planning.intervals": 25, "cargo": whole.source["cargo"][:1]})
    definition = define_sweep(scene, axes, again_cold=1)

    def kill_one(report: SweepProgress) -> None:
        if report.done and workers[0].poll() is None:
            workers[0].send_signal(signal.SIGKILL)

    spread = run_sweep(definition, folder=tmp_path, scheduler=address, progress=kill_one)
    assert workers[0].wait() == -signal.SIGKILL and spread.endings == {"planned": 4}
    alone = run_sweep(definition)
    assert [(line.key, line.figures, line.warm_from) for line in spread.lines] == [
        (line.key, line.figures, line.warm_from) for line in alone.lines
    ]
    assert [line.figures for line in spread.cold] == [line.figures for line in alone.cold]


def test_nobody_answers(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("nospill.sweeps.executors._PATIENCE", 0.5)
    with pytest.raises(ClusterError, match="nobody answers there") as caught, cluster("tcp://127.0.0.1:1"):
        pass
    assert "\n" not in str(caught.value)
    with pytest.raises(ClusterError, match="nobody answers there"), cluster("no address"):
        pass
    monkeypatch.setitem(sys.modules, "distributed", None)
    with pytest.raises(MissingExtraError, match=r"install nospill\[cluster\]"), cluster("tcp://127.0.0.1:1"):
        pass


class Answers:
    """A client of a cluster that has what it is told."""

    def __init__(self, scheduler: str, worker: str, nospill_there: object) -> None:
        self.scheduler, self.worker, self.nospill_there = scheduler, worker, nospill_there

    def wait_for_workers(self, n_workers: int, **_: object) -> None:
        if not self.worker:
            raise TimeoutError

    def get_versions(self, check: bool) -> dict[str, Any]:
        def packages(version: str) -> dict[str, Any]:
            return {"packages": {"distributed": version}}

        return {"scheduler": packages(self.scheduler), "workers": {"tcp://w": packages(self.worker)}}

    def run(self, *_: object, on_error: str) -> dict[str, object]:
        assert on_error == "return"
        return {"tcp://w": self.nospill_there}


@pytest.mark.parametrize(
    ("scheduler", "worker", "there", "words"),
    [
        ("here", "", "here", "has no worker; start some with `dask worker tcp://s --nthreads 1`"),
        ("2020.1.0", "here", "here", "the scheduler has distributed 2020.1.0, here is"),
        ("here", "2020.1.0", "here", "worker tcp://w has distributed 2020.1.0"),
        ("here", "here", ModuleNotFoundError("nospill"), "worker tcp://w has no nospill"),
        ("here", "here", "0.0.1", "worker tcp://w has nospill 0.0.1"),
    ],
)
def test_a_cluster_that_is_not_alike_is_refused(scheduler: str, worker: str, there: object, words: str) -> None:
    own = cluster_set_up.metadata.version("distributed")
    own_package = nospill.__version__ if there == "here" else there
    client = Answers(scheduler.replace("here", own), worker.replace("here", own), own_package)
    with pytest.raises(ClusterError, match=words) as caught:
        cluster_set_up.require_alike(client, "tcp://s", patience=1.0)  # type: ignore[arg-type]
    assert "\n" not in str(caught.value)


def test_compiled_functions_reach_the_cache_of_a_worker_once(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("NOSPILL_COMPILE", "background")
    here, there = tmp_path / "here", tmp_path / "there"
    here.mkdir()
    stem = "ldl-" + "0" * 32
    for ending in (".so", ".sum"):
        (here / f"{stem}{ending}").write_bytes(b"content")
    monkeypatch.setenv("NOSPILL_CACHE", str(here))
    sent = cluster_set_up.sent_functions()
    assert len(current_files()) == 2
    monkeypatch.setenv("NOSPILL_CACHE", str(there))
    sent.setup(SimpleNamespace())
    found = {file.name: file.read_bytes() for file in there.iterdir()}
    assert found == {f"{stem}.so": b"content", f"{stem}.sum": b"content"}
    (there / f"{stem}.so").write_bytes(b"own")
    sent.setup(SimpleNamespace())
    assert (there / f"{stem}.so").read_bytes() == b"own"
    content = BytesIO()
    with zipfile.ZipFile(content, "w") as archive:
        archive.writestr("../outside.so", b"x")
    cluster_set_up.unpack(content.getvalue())
    assert not (tmp_path / "outside.so").exists()
