"""Draw the problems of the benchmark into a file: one JSON line each, those that are there are kept.

    python -m benchmarks.carry.draw --first 0 --cases 236 --out benchmarks/results/carry-problems.jsonl.gz

Most of the time goes into problems for which no motion is found; so they are drawn once, and the runs read them.
"""

from __future__ import annotations

import argparse
import gzip
import json
from dataclasses import asdict
from pathlib import Path
from typing import Any

from benchmarks.campaign.lines import Lines
from benchmarks.carry.scenes import CELLS, draw_problem

PROBLEMS = Path(__file__).resolve().parents[1] / "results" / "carry-problems.jsonl.gz"


def read_problems(path: Path) -> dict[int, dict[str, Any]]:
    """Seed -> problem, of a file that may not exist."""
    return {line["seed"]: line for line in Lines.read(path)} if path.is_file() else {}


def write_problems(path: Path, problems: dict[int, dict[str, Any]]) -> None:
    """All problems in the order of their seeds; the same ones give the same file."""
    text = "".join(json.dumps(problems[seed]) + "\n" for seed in sorted(problems))
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_bytes(gzip.compress(text.encode(), mtime=0) if path.suffix == ".gz" else text.encode())


def main(words: list[str] | None = None) -> None:
    """Draw what is missing."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n")[0])
    parser.add_argument("--first", type=int, default=0, metavar="SEED", help="of the problems")
    parser.add_argument("--cases", type=int, default=236, help="seeds from the first to this less one")
    parser.add_argument("--out", type=Path, default=PROBLEMS)
    arguments = parser.parse_args(words)
    problems = read_problems(arguments.out)
    for seed in range(arguments.first, arguments.cases):
        if seed not in problems:
            problem = draw_problem(seed)
            if problem is None:
                print(f"{seed}: no problem with a motion in any of {CELLS} cells", flush=True)
                continue
            problems[seed] = asdict(problem)
            write_problems(arguments.out, problems)
            print(f"{seed}: {problem.family}, {problem.slow_s:.1f} s slowly", flush=True)


if __name__ == "__main__":
    main()
