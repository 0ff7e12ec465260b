"""The campaign behind docs/reliability.md: thousands of scenarios nobody picked, planned, judged twice and simulated.

    python -m benchmarks.campaign.run --out FILE --cases 1000 --jobs 2        run, or go on where it stopped
    python -m benchmarks.campaign.run --out FILE --starts-check 100           further random starts for 100 of them
    python -m benchmarks.campaign.run --out FILE --starts-check 100 --of CASES    likewise of the cases in another file
    python -m benchmarks.campaign.run --out FILE --scheduler tcp://host:8786  the same on a Dask cluster
    python -m benchmarks.campaign.run --out FILE --only 17                    one case alone, printed and not kept
    python -m benchmarks.campaign.run --report FILE ...                       tables into docs/reliability.md

Every case is a process with a time limit (`case.py`), so a crash or a hang is a line like any other. FILE
holds one JSON line a case, each written at once and whole; seeds that are in it are not run again. The package is taken
from the last commit, so that it may be edited meanwhile; `--live` takes it as it stands.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
import tempfile
import time
import zipfile
from collections.abc import Iterator
from concurrent.futures import Executor, as_completed
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.campaign.lines import Lines
from benchmarks.campaign.process import Job, run_job
from nospill.errors import NospillError
from nospill.sweeps.executors import cluster, this_machine

REPOSITORY = Path(__file__).resolve().parents[2]
PAGE = REPOSITORY / "docs" / "reliability.md"
_STARTS_SEED = 6
_STARTS = 10


def main(words: list[str] | None = None) -> None:
    """Run the campaign, or report."""
    arguments = _arguments(words)
    if arguments.report is not None:
        from benchmarks.campaign.report import write_page  # a run needs none of it

        write_page([line for file in arguments.report for line in Lines.read(file)], PAGE)
        print(f"written: {PAGE}")
        return
    if arguments.only is not None:
        known = {line["seed"]: line for line in Lines.read(arguments.out)} if arguments.out.is_file() else {}
        kept = known.get(arguments.only, {})
        with package(live=arguments.live) as folder:
            starts = _STARTS if arguments.starts_check else 0
            limit = arguments.limit * max(1, starts)
            table = kept.get("scenario")
            job = Job(arguments.only, limit, str(folder), starts=starts, table=table, compiled=arguments.compiled)
            print(json.dumps(run_job(job), indent=1))
        return
    with (
        Lines.writer(arguments.out) as lines,
        package(live=arguments.live) as folder,
        executor(arguments.jobs, arguments.scheduler) as where,
    ):
        shared = None if arguments.scheduler else str(folder)
        jobs = _wanted(lines, arguments, shared)
        began, commit = time.perf_counter(), _commit()
        print(f"{len(jobs)} to do, {len(lines.cases)} cases there", file=sys.stderr, flush=True)
        for number, line in enumerate(done(where, jobs), start=1):
            lines.append(line | {"commit": commit, "compiled": arguments.compiled})
            said = line.get("reason") or line.get("duration_s") or len(line.get("starts_from", ()))
            spent = time.perf_counter() - began
            print(f"{number} of {len(jobs)}, {spent:.0f} s: {line['seed']}: {line['kind']}: {said}", flush=True)


def _arguments(words: list[str] | None) -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n")[0])
    parser.add_argument("--out", type=Path, default=REPOSITORY / "benchmarks" / "results" / "campaign.jsonl")
    parser.add_argument("--first", type=int, default=0, metavar="SEED", help="of the cases")
    parser.add_argument("--cases", type=int, default=1000, help="seeds from the first to this less one")
    parser.add_argument("--jobs", type=int, default=1, help="processes at a time on this machine")
    parser.add_argument(
        "--limit", type=float, default=900.0, help="longest processor time of a case, s; of a further start too"
    )
    parser.add_argument("--starts-check", type=int, default=0, metavar="COUNT", help="cases to start again at random")
    parser.add_argument("--scheduler", metavar="ADDRESS", help="of a Dask cluster whose workers have nospill installed")
    parser.add_argument("--only", type=int, metavar="SEED", help="run one case alone and print its line")
    parser.add_argument(
        "--compiled", action="store_true", help="use compiled functions: fill the cache by `nospill cache --warm` first"
    )
    parser.add_argument("--live", action="store_true", help="the package as it stands and not as committed")
    parser.add_argument("--of", type=Path, metavar="FILE", help="cases to start again, where they are not in --out")
    parser.add_argument("--report", type=Path, nargs="+", metavar="FILE", help=f"write the tables into {PAGE.name}")
    arguments = parser.parse_args(words)
    if min(arguments.cases, arguments.jobs, arguments.limit) <= 0:
        parser.error("--cases, --jobs and --limit must be above 0")
    return arguments


def _wanted(lines: Lines, arguments: argparse.Namespace, folder: str | None) -> list[Job]:
    """What is not in the file yet: cases, or the further starts of cases that are there."""
    limit = arguments.limit
    if not arguments.starts_check:
        wanted = (seed for seed in range(arguments.first, arguments.cases) if seed not in lines.cases)
        return [Job(seed, limit, folder, compiled=arguments.compiled) for seed in wanted]
    cases = lines.cases if arguments.of is None else {line["seed"]: line for line in Lines.read(arguments.of)}
    chosen = starts_seeds(cases, arguments.starts_check)
    tables = {seed: cases[seed]["scenario"] for seed in chosen if seed not in lines.starts}
    return [
        Job(seed, _STARTS * limit, folder, starts=_STARTS, table=table, compiled=arguments.compiled)
        for seed, table in tables.items()
    ]


def starts_seeds(cases: dict[int, dict[str, Any]], count: int) -> list[int]:
    """Cases drawn at random, the same ones every time, from those in which there is a way for the arm to start from."""
    open_cases = [seed for seed, line in cases.items() if line["kind"] not in ("out of reach", "refused")]
    return sorted(open_cases, key=lambda seed: np.random.default_rng([_STARTS_SEED, seed]).random())[:count]


@contextmanager
def executor(jobs: int, scheduler: str | None = None) -> Iterator[Executor]:
    """Where jobs run: so many at a time here, or on a Dask cluster whose workers get the package `benchmarks`.

    Raises:
        SystemExit: the cluster cannot be used.
    """
    try:
        if scheduler is None:
            with this_machine(jobs, lambda: None) as here:
                yield here
        else:
            with (
                tempfile.TemporaryDirectory() as folder,
                cluster(scheduler, packages=[archived(Path(folder))]) as there,
            ):
                yield there
    except NospillError as error:
        raise SystemExit(str(error)) from None


def done(executor: Executor, jobs: list[Job]) -> Iterator[dict[str, Any]]:
    """The lines of jobs, as they are done; a worker that dies must not end the campaign."""
    futures = {executor.submit(run_job, job): job for job in jobs}
    for future in as_completed(futures):
        try:
            yield future.result()
        except Exception as error:
            yield {"seed": futures[future].seed, "kind": "crash", "reason": f"worker: {error!r}"}


def archived(folder: Path) -> Path:
    """The package `benchmarks` as an archive from which a worker can import."""
    archive = folder / "benchmarks.zip"
    with zipfile.ZipFile(archive, "w") as file:
        for source in sorted((REPOSITORY / "benchmarks").rglob("*.py")):
            file.write(source, source.relative_to(REPOSITORY))
    return archive


@contextmanager
def package(*, live: bool) -> Iterator[Path]:
    """A folder with the package, and the campaign's modules beside it: of the last commit, or as they stand."""
    if live:
        yield REPOSITORY / "src"
        return
    with tempfile.TemporaryDirectory() as name:
        archive = subprocess.run(["git", "-C", str(REPOSITORY), "archive", "HEAD", "src"], capture_output=True)
        if archive.returncode:
            raise SystemExit(f"no commit to take the package from ({archive.stderr.decode().strip()}); use --live")
        subprocess.run(["tar", "-x", "-C", name], input=archive.stdout, check=True)
        yield Path(name) / "src"


def _commit() -> str:
    command = ["git", "-C", str(REPOSITORY), "rev-parse", "--short", "HEAD"]
    return subprocess.run(command, capture_output=True, text=True, check=False).stdout.strip() or os.environ.get(
        "COMMIT", ""
    )


if __name__ == "__main__":
    main()
