"""Stops of scenarios nobody picked: the cases of the campaign that have a plan, planned again and stopped all along.

    python -m benchmarks.stops.campaign --cases 200 -o stops.jsonl     run, or go on where it stopped
    python -m benchmarks.stops.campaign --report benchmarks/results/stops.jsonl.gz     count

Every case is a process with a limit on its processor time, and one JSON line of the file, so that a crash or a hang is
a line like any other. The stops come from `ns.stops`, every 60 ms; each is judged anew with the plan before it,
as one motion from rest to a second of rest, and one of two is played in MuJoCo.
"""

from __future__ import annotations

import argparse
import json
import resource
import sys
import time
from collections import Counter
from pathlib import Path
from typing import Any

import numpy as np

import nospill as ns
from benchmarks.campaign.lines import Lines
from benchmarks.campaign.process import Job, run_job
from benchmarks.campaign.run import package
from benchmarks.stops.judging import played_joints, verdict_from_rest
from nospill.certification.wording import finding
from nospill.errors import NospillError
from nospill.plans.stops import Stop
from nospill.scenario import scene_from_table

CASES = Path(__file__).parents[1] / "results" / "campaign.jsonl.gz"
MODULE = "benchmarks.stops.campaign"
_PLAYED = 2
"""One of so many sooner stops is played in MuJoCo."""
_EVEN = 1e-6
"""s, by which a stop that is the rest of the plan may seem longer than it."""


def case(table: dict[str, Any], name: str, every: float) -> dict[str, Any]:
    """What becomes of the stops of a scenario."""
    from nospill.verify import verify  # the engine is loaded where something is played

    began = time.process_time()
    try:
        plan = ns.plan(scene_from_table(table, name=name))
        line: dict[str, Any] = {"duration_s": plan.duration, "plan_processor_s": time.process_time() - began}
        if not plan.certificate.ok:
            return line | {"kind": "not certified"}
        began = time.process_time()
        found = ns.stops(plan, every=every)
    except NospillError as error:
        return {"kind": "no plan", "reason": str(error)}
    line |= {"kind": "stopped", "stops_processor_s": time.process_time() - began}
    line |= {"origins": Counter(stop.origin for stop in found.stops)}
    line |= {"part_left": found.part_left, "bound_of_left": found.bound_of_left, "stops": len(found.stops)}
    line["longer"] = [_told(stop) for stop in found.stops if stop.duration > stop.left + _EVEN]
    line["broken"], line["moved"], line["played"] = [], [], 0
    sooner = [stop for stop in found.stops if stop.is_sooner]
    for number, stop in enumerate(sooner):
        certificate = verdict_from_rest(plan, stop, found.residual)
        if not certificate.ok:
            line["broken"].append(_told(stop) | {"row": finding(certificate)})
        if number % _PLAYED == 0:
            line["played"] += 1
            report = verify(plan, joints=played_joints(plan, stop))
            if not report.ok:
                line["moved"].append(_told(stop) | {"message": report.message})
    return line


def _told(stop: Stop) -> dict[str, Any]:
    return {"t_s": stop.t, "duration_s": stop.duration, "left_s": stop.left, "origin": stop.origin}


def report(lines: list[dict[str, Any]]) -> str:
    """What a file says, in a few lines."""
    kinds = Counter(line["kind"] for line in lines)
    done = [line for line in lines if line["kind"] == "stopped"]
    origins: Counter[str] = sum((Counter(line["origins"]) for line in done), Counter())
    words = [f"{len(lines)} cases: {dict(kinds)}", f"{sum(origins.values())} stops: {dict(origins)}"]
    for name in ("broken", "longer", "moved"):
        found = [(line["seed"], item) for line in done for item in line[name]]
        words += [f"{name}: {len(found)}", *(f"  {seed}: {item}" for seed, item in found)]
    words.append(f"played in MuJoCo: {sum(line['played'] for line in done)}")
    if done:
        middle = np.median([(line["part_left"], line["bound_of_left"]) for line in done], axis=0)
        spent = sum(line["stops_processor_s"] for line in done)
        words.append(f"median of the cases: {middle[0]:.2f} of the rest of the plan, bound {middle[1]:.2f}")
        words.append(f"processor time: {spent / max(1, sum(origins.values())):.2f} s a stop, the controller's included")
    return "\n".join(words)


def main() -> None:
    """Run cases, one of them where this is its process, or count."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n")[0])
    parser.add_argument("seed", type=int, nargs="?", help="of one case, which is read from the standard input")
    parser.add_argument("--cases", type=int, default=200, help="with a plan, in the order of the campaign's file")
    parser.add_argument("--of", type=Path, default=CASES, metavar="FILE", help="of the campaign")
    parser.add_argument("--every", type=float, default=0.06, help="s, between the instants")
    parser.add_argument("--limit", type=float, default=400.0, help="longest processor time of a case, s")
    parser.add_argument("--spend", type=float, default=np.inf, help="processor time after which no case is begun, s")
    parser.add_argument("-o", "--output", type=Path, default=Path("stops.jsonl"))
    parser.add_argument("--live", action="store_true", help="the package as it stands and not as committed")
    parser.add_argument("--report", type=Path, metavar="FILE", help="count what is in it")
    parser.add_argument("--processor-time", type=int, help=argparse.SUPPRESS)
    parser.add_argument("--given", action="store_true", help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.report is not None:
        print(report(Lines.read(options.report)))
        return
    if options.seed is not None:
        resource.setrlimit(resource.RLIMIT_CPU, (options.processor_time, options.processor_time + 5))
        print(json.dumps(case(json.load(sys.stdin), f"campaign-{options.seed}", options.every)))
        return
    known = [line for line in Lines.read(options.of) if line["kind"] == "planned"][: options.cases]
    known.sort(key=lambda line: line["plan_processor_s"])  # so that a run that is cut short has as many as it can
    with Lines.writer(options.output) as lines, package(live=options.live) as folder:
        for wanted in known:
            spent = resource.getrusage(resource.RUSAGE_CHILDREN)
            if wanted["seed"] in lines.cases or spent.ru_utime + spent.ru_stime > options.spend:
                continue
            job = Job(wanted["seed"], options.limit, str(folder), table=wanted["scenario"], module=MODULE)
            line = {key: value for key, value in run_job(job).items() if key != "scenario"}
            lines.append(line)
            print(json.dumps(line), flush=True)
    print(report(Lines.read(options.output)))


if __name__ == "__main__":
    main()
