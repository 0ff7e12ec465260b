"""Whether failures tell the truth: thirty tasks that cannot be planned, the reason said, and the change suggested.

    python -m benchmarks.infeasible.run                all, each in a process of its own; writes docs/reasons.md
    python -m benchmarks.infeasible.run --only NAME    one, as JSON
    python -m benchmarks.infeasible.run --bases        that the tasks they are made from can be planned

The reason counts as named where kind, constraint, subject and place on the path are the built ones, compared as values.
A change counts as enough where the scenario with the change made is planned and certified.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

from benchmarks.infeasible.cases import BASES, CASES, Case, Table, spoiled_table
from nospill.errors import Change, NospillError, Reason
from nospill.planning.planner import plan
from nospill.scenario import scene_from_table
from nospill.scenario.settings import changed_table

BEGIN, END = "<!-- infeasible: begin -->", "<!-- infeasible: end -->"
PAGE = Path(__file__).parents[2] / "docs" / "reasons.md"
NAMED_TARGET, SOLVED_TARGET = 28, 25
_LONGEST = 300.0
"""s; a case that takes longer counts as failed."""
_SLACK = 1e-9
_SHOWN = 260


def is_named(case: Case, reason: Reason | None) -> bool:
    """Whether a reason is the one that was built in."""
    if reason is None or (reason.kind, reason.constraint) != (case.kind, case.constraint):
        return False
    if case.subjects and reason.subject not in case.subjects:
        return False
    if case.between is None:
        return True
    first, last = case.between
    return reason.at_s is not None and first - _SLACK <= reason.at_s <= last + _SLACK


def planned(table: Table, name: str) -> tuple[float | None, str]:
    """Duration of a certified motion, s, or None and why there is none."""
    try:
        found = plan(scene_from_table(table, name=name))
    except NospillError as error:
        return None, str(error)
    return (found.duration, "") if found.certificate.ok else (None, found.message)


def run(case: Case) -> dict[str, Any]:
    """One case: what is said, how long that takes, and what becomes of the scenario with each change."""
    table, name = spoiled_table(case), case.name.replace(" ", "-").replace("'", "")
    began = time.perf_counter()
    try:
        plan(scene_from_table(table, name=name))
    except NospillError as error:
        seconds = time.perf_counter() - began
        return {
            "name": case.name,
            "kind": case.kind,
            "constraint": case.constraint,
            "said": str(error),
            "named": is_named(case, error.reason),
            "seconds": seconds,
            "changes": [_tried(table, change, name) for change in error.changes],
        }
    return {
        "name": case.name,
        "kind": case.kind,
        "constraint": case.constraint,
        "said": "a motion was found",
        "named": False,
        "seconds": time.perf_counter() - began,
        "changes": [],
    }


def _tried(table: Table, change: Change, name: str) -> dict[str, Any]:
    duration, why = planned(changed_table(table, change.values), name)
    return {"place": change.place, "text": change.text, "duration": duration, "why": why}


def _in_process(case: Case) -> dict[str, Any]:
    """The same in a process of its own: nothing is warm, and a case that hangs ends."""
    command = [sys.executable, "-m", "benchmarks.infeasible.run", "--only", case.name]
    environment = os.environ | {"NOSPILL_COMPILE": "off"}
    try:
        done = subprocess.run(command, capture_output=True, text=True, timeout=_LONGEST, env=environment, check=True)
    except (subprocess.TimeoutExpired, subprocess.CalledProcessError) as error:
        said = f"{type(error).__name__}: {str(error.stderr)[-200:]}"
        failed = {"said": said, "named": False, "seconds": _LONGEST, "changes": []}
        return {"name": case.name, "kind": case.kind, "constraint": case.constraint} | failed
    line: dict[str, Any] = json.loads(done.stdout)
    return line


def is_enough(line: dict[str, Any]) -> bool:
    """Whether the first, smallest change makes the scenario solvable."""
    return bool(line["changes"]) and line["changes"][0]["duration"] is not None


def report(lines: list[dict[str, Any]]) -> str:
    """The part of the page that is measured."""
    commit = subprocess.run(
        ["git", "rev-parse", "--short", "HEAD"], cwd=PAGE.parent, capture_output=True, text=True, check=False
    ).stdout.strip()
    named, enough = sum(line["named"] for line in lines), sum(map(is_enough, lines))
    changes = [change for line in lines for change in line["changes"]]
    held = sum(change["duration"] is not None for change in changes)
    times = sorted(line["seconds"] for line in lines)
    text = [
        f"Commit {commit}, no compiled functions, each case in a process of its own.",
        "",
        "| | measured | target |",
        "|---|---:|---:|",
        f"| built reason named | {named} of {len(lines)} | {NAMED_TARGET} |",
        f"| planned and certified with the first change | {enough} of {len(lines)} | {SOLVED_TARGET} |",
        f"| all suggested changes that are enough | {held} of {len(changes)} | |",
        f"| until the message, s: median, greatest | {times[len(times) // 2]:.1f}, {times[-1]:.1f} | 30 |",
        "",
        "| case | kind | built in | named | changes, smallest first; with it, s | s |",
        "|---|---|---|---|---|---:|",
    ]
    for line in lines:
        shown = "<br>".join(
            f"{change['text']}: {'not enough' if change['duration'] is None else format(change['duration'], '.3g')}"
            for change in line["changes"]
        )
        named_text = "yes" if line["named"] else "**no**"
        text.append(
            f"| {line['name']} | {line['kind']} | {line['constraint']} | {named_text} | {shown or 'none'} "
            f"| {line['seconds']:.1f} |"
        )
    text += ["", "What is said:", ""]
    text += [f"- {line['name']}: {_shortened(line['said'])}" for line in lines]
    return "\n".join(text)


def _shortened(said: str) -> str:
    said = said.split(" Smallest single change found:")[0]
    return said if len(said) <= _SHOWN else said[:_SHOWN] + " ..."


def write_page(lines: list[dict[str, Any]]) -> None:
    """Put the measured part into the page."""
    page = PAGE.read_text(encoding="utf-8")
    before, after = page.split(BEGIN)[0], page.split(END)[1]
    PAGE.write_text(f"{before}{BEGIN}\n{report(lines)}\n{END}{after}", encoding="utf-8")


def main() -> None:
    """Run the cases."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n")[0])
    parser.add_argument("--only", metavar="NAME")
    parser.add_argument("--bases", action="store_true")
    arguments = parser.parse_args()
    if arguments.only:
        print(json.dumps(run(next(case for case in CASES if case.name == arguments.only))))
        return
    if arguments.bases:
        for name, table in BASES.items():
            duration, why = planned(table, name.replace(" ", "-"))
            print(f"{name}: {why if duration is None else f'{duration:.3f} s'}", flush=True)
        return
    lines = []
    for case in CASES:
        lines.append(_in_process(case))
        line = lines[-1]
        print(
            f"{line['seconds']:6.1f} s  {'named' if line['named'] else 'WRONG'}  "
            f"{'enough' if is_enough(line) else 'NOT   '}  {case.name}",
            flush=True,
        )
    write_page(lines)


if __name__ == "__main__":
    main()
