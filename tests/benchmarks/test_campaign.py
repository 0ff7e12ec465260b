"""The campaign's machinery: lines that are whole, processes that may die, resuming, a cluster, the report."""

from __future__ import annotations

import gzip
import json
import os
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import dask.config
import pytest
from dask.distributed import LocalCluster

from benchmarks.campaign import case as campaign_case
from benchmarks.campaign import process as campaign_process
from benchmarks.campaign import report as campaign_report
from benchmarks.campaign import run as campaign
from benchmarks.campaign.lines import Lines
from benchmarks.campaign.process import Job, line_of
from benchmarks.campaign.scenes import draw_case
from nospill.errors import MOTION, NOT_CONVERGED, REST, NoSolutionError, Reason, ScenarioError
from nospill.scenario import read_scenario
from tests.waiting import run_python

SEED = 6503
"""Of a case with one cup on a line, which is planned in a second."""

LIMITED = """
import resource, sys
seconds = int(sys.argv[sys.argv.index("--processor-time") + 1])
resource.setrlimit(resource.RLIMIT_CPU, (seconds, seconds + 5))
"""


def line(seed: int, **changes: Any) -> dict[str, Any]:
    planned = {
        "seed": seed,
        "scenario": {"name": f"campaign-{seed}"},
        "structure": "ur5e, line of 0.50 m, 1 liquids, 0 solids, level, residual",
        "unreachable": False,
        "kind": "planned",
        "reason": None,
        "duration_s": 1.0,
        "plan_processor_s": 2.0,
        "iterations": 50,
        "rounds": 1,
        "binding": "slip of c1",
        "peak_memory_mb": 200.0,
        "fine": {"ok": True, "broken": []},
        "verify": {"ok": True, "message": "Every object stays"},
        "commit": "abc",
    }
    return planned | changes


def test_lines_are_kept_and_found_again(tmp_path: Path) -> None:
    file = tmp_path / "results" / "campaign.jsonl"
    with Lines.writer(file) as lines:
        lines.append(line(3))
        lines.append({"seed": 3, "starts_from": []})
    with Lines.writer(file) as lines:
        assert list(lines.cases) == [3] and list(lines.starts) == [3]
    assert Lines.read(file)[0] == line(3)
    packed = tmp_path / "campaign.jsonl.gz"
    packed.write_bytes(gzip.compress(file.read_bytes()))
    assert Lines.read(packed) == Lines.read(file)


def test_one_campaign_a_file(tmp_path: Path) -> None:
    file = tmp_path / "campaign.jsonl"
    with Lines.writer(file), pytest.raises(SystemExit, match="another run is writing"), Lines.writer(file):
        pass


@pytest.mark.slow
@pytest.mark.parametrize(
    ("code", "limit", "kind", "reason"),
    [
        ('import os; print(\'{"structure": "s"}\', flush=True); os.abort()', 20.0, "crash", "exit code -6"),
        ("raise ValueError('no such thing')", 20.0, "crash", "exit code 1: ValueError: no such thing"),
        ('import time; print(\'{"structure": "s"}\', flush=True); time.sleep(60)', 0.2, "out of time", "0.2 s"),
        ("pass", 20.0, "crash", "exit code 0: no message"),
        ("import os; os.kill(os.getpid(), 9)", 20.0, "crash", "exit code -9"),
        (f"{LIMITED}\nwhile True: pass", 0.5, "out of time", "no answer within 0.5 s"),
    ],
)
def test_whatever_a_process_does_is_a_line(
    code: str, limit: float, kind: str, reason: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "stand_in.py").write_text(code)
    monkeypatch.setattr(campaign_process, "ROOT", str(tmp_path))
    found = campaign_process.run_job(Job(5, limit, module="stand_in"))
    assert found["seed"] == 5 and found["kind"] == kind and reason in found["reason"]
    assert found.get("structure") == ("s" if "structure" in code else None)


def test_noise_among_the_lines_of_a_process_is_passed_over() -> None:
    out = '{"scenario": {"a": 1}, "structure": "s"}\n*** IPOPT says hello\n{"kind": "planned"}\n{"kind": '
    assert line_of(Job(1, 9.0), out, "", 0) == {
        "seed": 1,
        "scenario": {"a": 1},
        "structure": "s",
        "kind": "planned",
    }
    starts = line_of(Job(1, 9.0, starts=2, table={"a": 1}), '{"start": 0}\n{"start": 1}\n', "", 0)
    assert starts["starts_from"] == [{"start": 0}, {"start": 1}] and starts["kind"] == "starts"


def test_failures_are_sorted_by_what_can_be_shown() -> None:
    scene = read_scenario("matrix-rigid")
    for told, kind in ((REST, "proven impossible"), (MOTION, "not found"), (NOT_CONVERGED, "not found")):
        failure = campaign_case.failure_of(NoSolutionError("No motion found", Reason(told, "slip", "c1")), scene)
        assert (failure.kind, failure.told, failure.blamed) == (kind, told, "slip of c1")
    assert campaign_case.failure_of(ScenarioError("path.degree"), scene).kind == "refused"


@pytest.mark.slow
def test_a_case_of_its_own_and_its_starts() -> None:
    found = campaign_process.run_job(Job(SEED, 300.0))
    assert found["kind"] == "planned" and found["fine"]["ok"] and found["verify"]["ok"], found
    assert found["fine"]["grid_hz"] >= 8000.0 and found["scenario"]["name"] == f"campaign-{SEED}"
    starts = campaign_process.run_job(Job(SEED, 300.0, starts=1, table=found["scenario"]))
    assert len(starts["starts_from"]) == 1
    assert all(
        outcome["duration_s"] == pytest.approx(found["duration_s"], rel=1e-3) for outcome in starts["starts_from"]
    )


def stub(seed: int) -> dict[str, Any]:
    return line(seed, scenario={"name": f"campaign-{seed}"})


def test_a_run_goes_on_where_it_stopped(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: Any) -> None:
    asked: list[Job] = []

    def run_job(job: Job) -> dict[str, Any]:
        asked.append(job)
        return (
            stub(job.seed) if not job.starts else {"seed": job.seed, "kind": "starts", "starts_from": [], "asked": 10}
        )

    monkeypatch.setattr(campaign, "run_job", run_job)
    file = tmp_path / "campaign.jsonl"
    words = ["--out", str(file), "--live", "--cases"]
    campaign.main([*words, "2"])
    campaign.main([*words, "5", "--jobs", "2"])
    assert sorted(job.seed for job in asked) == [0, 1, 2, 3, 4]
    campaign.main([*words, "5", "--starts-check", "3"])
    chosen = [job.seed for job in asked if job.starts]
    campaign.main([*words, "5", "--starts-check", "3"])
    assert [job.seed for job in asked if job.starts] == chosen and len(set(chosen)) == 3
    assert asked[-1].table is not None
    capsys.readouterr()
    campaign.main(["--out", str(file), "--live", "--only", "3"])
    assert json.loads(capsys.readouterr().out)["seed"] == 3 and len(Lines.read(file)) == 8


def test_starts_are_drawn_from_cases_with_a_way() -> None:
    cases = {seed: line(seed, kind="out of reach" if seed % 2 else "not found") for seed in range(40)}
    chosen = campaign.starts_seeds(cases, 10)
    assert len(chosen) == 10 and all(seed % 2 == 0 for seed in chosen)
    assert chosen == campaign.starts_seeds(cases, 10) and campaign.starts_seeds({}, 5) == []


def test_starts_of_the_cases_in_another_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    asked: list[Job] = []

    def run_job(job: Job) -> dict[str, Any]:
        asked.append(job)
        return {"seed": job.seed, "kind": "starts", "starts_from": [], "asked": job.starts}

    monkeypatch.setattr(campaign, "run_job", run_job)
    cases, starts = tmp_path / "cases.jsonl", tmp_path / "starts.jsonl"
    cases.write_text("".join(json.dumps(stub(seed)) + "\n" for seed in range(4)))
    campaign.main(["--out", str(starts), "--live", "--starts-check", "2", "--of", str(cases)])
    assert len(asked) == 2 and all(job.table == {"name": f"campaign-{job.seed}"} for job in asked)
    assert len(Lines.read(cases)) == 4 and len(Lines.read(starts)) == 2


@pytest.mark.slow
def test_starts_that_come_to_the_same_are_refined_once() -> None:
    source = read_scenario("pp-two-cups").source
    outcomes = list(campaign_case.random_starts(source, "campaign-1", 3))  # type: ignore[arg-type]
    first = outcomes[0]
    assert first["duration_s"] == pytest.approx(1.850, rel=1e-3)
    assert [outcome.get("as") for outcome in outcomes] == [None, 0, 0]
    assert {outcome["duration_s"] for outcome in outcomes} == {first["duration_s"]}


SCHEDULER = {"allowed-failures": 0, "worker-saturation": 1.0}


@pytest.fixture
def cluster(tmp_path: Path) -> Iterator[str]:
    """The address of a scheduler with two workers, which are started where there is no package `benchmarks`.

    They are sent one case at a time, and a case at which one dies is not sent again.
    """
    with dask.config.set({f"distributed.scheduler.{key}": n for key, n in SCHEDULER.items()}):
        scheduler = LocalCluster(n_workers=0, dashboard_address=":0", scheduler_port=0)
    with scheduler:
        address = scheduler.scheduler_address
        command = [sys.executable, "-m", "dask", "worker", address, "--nthreads", "1", "--no-nanny", "--no-dashboard"]
        environment = os.environ | {"PYTHONPATH": str(campaign.REPOSITORY / "src")}
        with (tmp_path / "workers.log").open("w") as log:
            workers = [
                subprocess.Popen(command, cwd=tmp_path, env=environment, stdout=log, stderr=log) for _ in range(2)
            ]
        try:
            yield address
        finally:
            for worker in workers:
                worker.terminate()
                worker.wait()


@pytest.mark.slow
def test_a_cluster_runs_cases_from_the_archive_and_a_dead_worker_is_a_line(
    cluster: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The real cluster: what its workers run is what they were sent, and one of them may die."""

    def run_or_die(job: Job) -> dict[str, Any]:
        from benchmarks.campaign import process

        if job.seed == 37:
            os._exit(1)
        return process.run_job(job) | {"from": process.ROOT, "folder": job.folder}

    monkeypatch.setattr(campaign, "run_job", run_or_die)  # which goes to the worker by its code, not by its name
    file = tmp_path / "campaign.jsonl"
    campaign.main(["--out", str(file), "--live", "--first", "37", "--cases", "39", "--scheduler", cluster])
    found = {found["seed"]: found for found in Lines.read(file)}
    assert found[37]["kind"] == "crash" and "KilledWorker" in found[37]["reason"]
    assert found[38]["kind"] == "out of reach" and "out of reach of robot" in found[38]["reason"]
    assert draw_case(38).unreachable and found[38]["unreachable"] and found[38]["folder"] is None
    assert Path(found[38]["from"]).name == "benchmarks.zip"


def test_a_worker_starts_cases_from_the_archive_it_was_sent(tmp_path: Path) -> None:
    code = "from benchmarks.campaign import process; print(process.ROOT); process.run_job"
    environment = {"PYTHONPATH": str(campaign.archived(tmp_path)), "PATH": ""}
    done = run_python("-c", code, cwd=tmp_path, env=environment, check=True)
    assert done.stdout.strip() == str(tmp_path / "benchmarks.zip")
    environment["PYTHONPATH"] = done.stdout.strip()
    run_python("-m", "benchmarks.campaign.case", "--help", cwd=tmp_path, env=environment, check=True)


def test_a_cluster_that_is_not_there_is_one_line(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "distributed", None)
    with pytest.raises(SystemExit, match=r"install nospill\[cluster\]"), campaign.executor(1, "tcp://nowhere:1"):
        pass


def test_report_counts_what_is_wrong(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    lines = [line(seed, plan_processor_s=float(seed)) for seed in range(20)]
    lines += [
        line(20, verify={"ok": False, "message": "c1 moves from t = 0.1 s on"}),
        line(21, fine={"ok": False, "broken": ["slip of c1 uses 100.2 %"]}),
        line(22, kind="crash", reason="exit code -11: Segmentation fault"),
        line(23, kind="not found", reason="No motion found: residual height of c1 is 3 mm against a limit of 2 mm"),
        line(24, kind="not found", reason="No motion found: residual height of c2 is 5 mm against a limit of 4 mm"),
        line(26, kind="not found", reason="No motion found: the arm turns round", blamed="singularity of ur5e"),
        line(27, kind="not found", reason="No motion found: ipopt gave up", blamed="planning of solver"),
        line(25, kind="out of reach", reason="path: out of reach of robot 'ur5e' from s = 0.1 on", unreachable=True),
    ]
    starts = [{"start": index, "duration_s": duration} for index, duration in enumerate([0.9, 1.2, None])]
    lines.append({"seed": 0, "kind": "starts", "starts_from": starts, "asked": 3})
    lines.append({"seed": 23, "kind": "starts", "starts_from": [{"start": 0, "duration_s": 2.0}], "asked": 1})
    page = tmp_path / "page.md"
    marks = [campaign_report.BEGIN, campaign_report.END, campaign_report.DRAWN_BEGIN, campaign_report.DRAWN_END]
    page.write_text("\n".join(["top", *marks, "bottom"]))
    monkeypatch.setattr(campaign, "PAGE", page)
    file = tmp_path / "campaign.jsonl"
    file.write_text("".join(json.dumps(one) + "\n" for one in lines))
    campaign.main(["--report", str(file)])
    campaign.main(["--report", str(file)])  # writing again does not pile up
    text = page.read_text()
    assert text.startswith("top") and text.endswith("bottom") and text.count("| crash |") == 1 + 1 + 1
    assert "| certified, rejected by the certificate at 8 kHz | 1 |" in text
    assert "| certified, something moves in MuJoCo | 1 |" in text
    assert "| failures that do not name what is in the way | 2 of 6" in text
    assert "| left out of reach on purpose and reported so | 1 of 1 |" in text
    assert "residual height of .. is # mm against a limit of # mm | 2 | 23 |" in text
    worst = [row.split(" | ")[0] for row in text.split("worst ten: seed")[1].splitlines()[2:]]
    assert {worst[0], worst[1]} == {"| 20", "| 21"} and worst[2] == "| 22"
    assert "| solved by any start | 2 |" in text and "plain `plan` | 1 of 2 (50.0%)" in text
    assert "within 1 % of the best duration | 0 of 1 (0.0%)" in text


def test_report_of_nothing() -> None:
    assert list(campaign_report.section([])) == ["No case has been run yet."]
