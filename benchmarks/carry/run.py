"""The benchmark behind docs/carrying.md: trays carried among obstacles, each problem with a motion known to exist.

    python -m benchmarks.carry.run --out FILE --cases 236 --jobs 1     run, or go on where it stopped
    python -m benchmarks.carry.run --out FILE --only 17                one problem alone, printed and not kept
    python -m benchmarks.carry.run --report FILE ...                   tables into docs/carrying.md

The problems are those that `benchmarks.carry.draw` wrote. Each is a process with a limit of processor time; FILE holds
one JSON line a problem, and seeds that are in it are not run again. The package is taken from the last commit; `--live`
takes it as it stands.
"""

from __future__ import annotations

import argparse
import json
import subprocess
from pathlib import Path

from benchmarks.campaign.lines import Lines
from benchmarks.campaign.process import Job, run_job
from benchmarks.campaign.run import REPOSITORY, done, executor, package
from benchmarks.carry.draw import PROBLEMS, read_problems
from benchmarks.carry.report import write_page
from nospill.core.batches import thread_count

PAGE = REPOSITORY / "docs" / "carrying.md"
CASE = "benchmarks.carry.case"
_KEPT = ("seed", "family", "slow_s", "singular", "blocked", "pathless")


def main(words: list[str] | None = None) -> None:
    """Run the benchmark, or report."""
    arguments = _arguments(words)
    if arguments.report is not None:
        write_page([line for file in arguments.report for line in Lines.read(file)], PAGE)
        print(f"written: {PAGE}")
        return
    problems = read_problems(arguments.problems)
    threads = max(1, thread_count() // arguments.jobs)
    with package(live=arguments.live) as folder:
        jobs = {
            seed: Job(
                seed, arguments.limit, str(folder), table=item["table"], module=CASE, compiled=True, threads=threads
            )
            for seed, item in problems.items()
        }
        if arguments.only is not None:
            print(json.dumps(run_job(jobs[arguments.only]), indent=1))
            return
        with Lines.writer(arguments.out) as lines, executor(arguments.jobs) as where:
            wanted = [
                job
                for seed, job in jobs.items()
                if arguments.first <= seed < arguments.cases and seed not in lines.cases
            ]
            commit = subprocess.run(
                ["git", "-C", str(REPOSITORY), "rev-parse", "--short", "HEAD"], capture_output=True, text=True
            ).stdout.strip()
            for number, line in enumerate(done(where, wanted), start=1):
                known = problems[line["seed"]]
                head = {key: known[key] for key in _KEPT} | {"structure": structure(known["table"])}
                lines.append(
                    head | {key: value for key, value in line.items() if key != "scenario"} | {"commit": commit}
                )
                said = line.get("reason") or f"{line['duration_s']:.3f} s"
                print(
                    f"{number} of {len(wanted)}: {line['seed']}, {known['family']}: {line['kind']}: {said}", flush=True
                )


def structure(table: dict[str, object]) -> str:
    """Arm, objects and tilt in a few words."""
    robot, cargo, motion = table["robot"], table["cargo"], table["motion"]
    assert isinstance(robot, dict) and isinstance(cargo, list) and isinstance(motion, dict)  # as it was drawn
    liquids = sum("liquid" in item for item in cargo)
    tilt = "tilting" if motion["tilt"] == "free" else "level"
    return f"{robot['model']}, {liquids} liquids, {len(cargo) - liquids} solids, {tilt}"


def _arguments(words: list[str] | None) -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n")[0])
    parser.add_argument("--out", type=Path, default=REPOSITORY / "benchmarks" / "results" / "carry.jsonl")
    parser.add_argument("--problems", type=Path, default=PROBLEMS, help="as benchmarks.carry.draw wrote them")
    parser.add_argument("--first", type=int, default=0, metavar="SEED", help="of the problems")
    parser.add_argument("--cases", type=int, default=236, help="seeds from the first to this less one")
    parser.add_argument("--jobs", type=int, default=1, help="processes at a time")
    parser.add_argument("--limit", type=float, default=600.0, help="longest processor time of a problem, s")
    parser.add_argument("--only", type=int, metavar="SEED", help="run one problem alone and print its line")
    parser.add_argument("--live", action="store_true", help="the package as it stands and not as committed")
    parser.add_argument("--report", type=Path, nargs="+", metavar="FILE", help=f"write the tables into {PAGE.name}")
    arguments = parser.parse_args(words)
    if min(arguments.cases, arguments.jobs, arguments.limit) <= 0:
        parser.error("--cases, --jobs and --limit must be above 0")
    return arguments


if __name__ == "__main__":
    main()
