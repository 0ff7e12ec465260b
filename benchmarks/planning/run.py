"""The benchmark behind docs/performance.md: one table, a JSON file and a plot in benchmarks/results.

    make bench                               five alternating rounds, about half an hour
    python -m benchmarks.planning.run --quick         the long baseline once, the rest three times
    python -m benchmarks.planning.run --only cold,warm

Every measurement is a process of its own (`tasks.py`), so nothing a run has built serves the next one; what is kept
between them is the disk cache of compiled stage functions, which is filled first, and how long that took is noted. The
measurements of a round follow one another before the next round begins: whatever else the machine does falls on all of
them, and the ratios hold where the seconds do not. The package is copied first, so that it may be edited meanwhile.
"""

from __future__ import annotations

import argparse
import compileall
import json
import os
import resource
import shutil
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

from benchmarks.planning.measurements import EXAMPLES, GROUPS, WELLS, WHOLE_EXAMPLES, measurements
from benchmarks.planning.plot import save_plot
from benchmarks.planning.report import machine, table, write_page
from nospill.compiled.compilers import compiler_path
from nospill.native import libraries

REPOSITORY = Path(__file__).resolve().parents[2]
RESULTS = REPOSITORY / "benchmarks" / "results"
PAGE = REPOSITORY / "docs" / "performance.md"
_LONGEST = 1800.0


class Bench:
    """A copy of the package, a cache of compiled functions, and what is run with them."""

    def __init__(self, folder: Path) -> None:
        """Copy the package into `folder`; the cache is kept between benchmarks, by content.

        The libraries in C are compiled there as a wheel carries them.
        """
        self.folder = folder
        shutil.copytree(REPOSITORY / "src", folder / "src", ignore=shutil.ignore_patterns("__pycache__", "*.egg-info"))
        compiler = compiler_path()
        if compiler is not None:
            libraries.compile_into(folder / "src" / libraries.PREBUILT.relative_to(REPOSITORY / "src"), compiler)
        # As an installation leaves it: with PYTHONDONTWRITEBYTECODE every process would compile the sources anew.
        compileall.compile_dir(folder / "src", quiet=1)
        own = shutil.ignore_patterns("__pycache__", "results")
        shutil.copytree(REPOSITORY / "benchmarks", folder / "benchmarks", ignore=own)
        self.cache = RESULTS / "cache"

    def environment(self, compile_mode: str, cache: Path | None = None) -> dict[str, str]:
        """Of a child process: our copy first on the path, one thread, which compiler."""
        return os.environ | {
            "PYTHONPATH": os.pathsep.join((str(self.folder / "src"), str(self.folder))),
            "OMP_NUM_THREADS": "1",
            "NOSPILL_COMPILE": compile_mode,
            "NOSPILL_CACHE": str(cache or self.cache),
        }

    def task(self, *arguments: str, mode: str = "background", cache: Path | None = None) -> dict[str, Any]:
        """Run `tasks.py`; its figures, or `failed` with its last line."""
        command = [sys.executable, "-m", "benchmarks.planning.tasks", *arguments]
        done = subprocess.run(
            command, env=self.environment(mode, cache), capture_output=True, text=True, timeout=_LONGEST, check=False
        )
        if done.returncode:
            return {"failed": (done.stderr.strip().splitlines() or ["no message"])[-1]}
        return json.loads(done.stdout.strip().splitlines()[-1])

    def prepare(self, *arguments: str) -> dict[str, Any]:
        """Fill the cache for a task by compiling at once; `seconds` is the whole process."""
        began = time.perf_counter()
        figures = self.task(*arguments, mode="wait")
        return figures | {"seconds": time.perf_counter() - began}

    def warm(self) -> float:
        """Compile the usual blocks as `nospill cache --warm` does; seconds."""
        command = [sys.executable, "-c", "from nospill.cli import main; main()", "cache", "--warm"]
        return self._timed(command, self.cache)["seconds"]

    def first_plan(self, name: str, *, empty: bool) -> dict[str, Any]:
        """The first plan of a structure that no example has, with an empty cache or the usual blocks.

        `again` is the second, which finds everything compiled.
        """
        cache = self.folder / "first" / name / ("empty" if empty else "filled")
        shutil.rmtree(cache, ignore_errors=True)
        if empty:
            cache.mkdir(parents=True, mode=0o700)
        else:
            shutil.copytree(self.cache, cache)
        first = self.task("unseen", name, cache=cache)
        self._await_compilers(cache)
        second = self.task("unseen", name, cache=cache)
        return first | {"again": second.get("seconds")}

    def whole_process(self, *, cold_cache: bool, figures: bool = False) -> dict[str, Any]:
        """`nospill plan matrix-liquid -o DIR`, from start to exit, without its figures unless they are asked for."""
        cache = Path(tempfile.mkdtemp(dir=self.folder)) if cold_cache else self.cache
        command = [sys.executable, "-c", "from nospill.cli import main; main()", "plan", "matrix-liquid"]
        command += ["-o", str(self.folder / "plan")] + ([] if figures else ["--no-figures"])
        measured = self._timed(command, cache)
        self._await_compilers(cache)
        summary = json.loads((self.folder / "plan" / "summary.json").read_text())
        return measured | {"duration": summary["duration_s"], "phases": summary["phases_s"]}

    def _await_compilers(self, cache: Path) -> None:
        """Compilers that a cold cache has set off must not run beside the next measurement."""
        began = time.perf_counter()
        while any(cache.glob("*.lock")) and time.perf_counter() - began < _LONGEST:
            time.sleep(0.2)

    def python(self, statement: str) -> dict[str, Any]:
        """A whole interpreter that runs one statement."""
        return self._timed([sys.executable, "-c", statement], self.cache)

    def _timed(self, command: list[str], cache: Path) -> dict[str, Any]:
        began, used = time.perf_counter(), _of_children()
        done = subprocess.run(
            command, env=self.environment("background", cache), capture_output=True, text=True, check=False
        )
        figures = {"seconds": time.perf_counter() - began, "processor": _of_children() - used}
        if done.returncode:
            raise SystemExit(f"{' '.join(command)}: {done.stderr.strip()}")
        return figures


def _of_children() -> float:
    """Processor time of the processes that were waited for, s."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def fill_cache(bench: Bench, groups: set[str]) -> dict[str, float]:
    """Compile what the measurements need; seconds of each first run."""
    needed = [("whole", name) for name in WHOLE_EXAMPLES if groups & {"whole", "whole-warm"}]
    needed += [("cold", name) for name in EXAMPLES if groups & {"cold", "warm", "process", "first", "grid"}]
    needed += [("wells", str(count)) for count in WELLS if "wells" in groups]
    seconds = {"cache --warm": bench.warm()} if "first" in groups else {}
    for arguments in needed:
        label = " ".join(arguments)
        figures = bench.prepare(*arguments)
        seconds[label] = figures["seconds"]
        print(f"prepared {label}: {figures['seconds']:.1f} s {figures.get('failed', '')}", file=sys.stderr, flush=True)
    return seconds


def main() -> None:
    """Run the benchmark."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n")[0])
    parser.add_argument("--quick", action="store_true", help="three rounds, the longest measurements once")
    parser.add_argument("--rounds", type=int, help="number of rounds")
    parser.add_argument("--only", help=f"some of {','.join(GROUPS)}", default=",".join(GROUPS))
    parser.add_argument("--show", action="store_true", help="print the table and draw the plot of the last results")
    parser.add_argument("--page", action="store_true", help="also put the table into docs/performance.md")
    arguments = parser.parse_args()
    RESULTS.mkdir(exist_ok=True)
    place = RESULTS / "summary.json"
    if not arguments.show:
        groups = set(arguments.only.split(","))
        if groups - set(GROUPS):
            parser.error(f"--only: {', '.join(sorted(groups - set(GROUPS)))} is none of {', '.join(GROUPS)}")
        rounds = arguments.rounds or (3 if arguments.quick else 5)
        results = _measure(groups, rounds, hurry=arguments.quick)
        if groups != set(GROUPS) and place.is_file():
            # A partial run renews its own measurements and leaves the others of the last run.
            kept = json.loads(place.read_text())
            results["measurements"] = kept["measurements"] | results["measurements"]
            results["prepared"] = kept["prepared"] | results["prepared"]
        place.write_text(json.dumps(results, indent=1) + "\n")
    results = json.loads(place.read_text())
    print(table(results))
    save_plot(results, RESULTS / "times.png")
    if arguments.page:
        write_page(results, PAGE)
    print(f"written: {place}, {RESULTS / 'times.png'}")


def _measure(groups: set[str], rounds: int, *, hurry: bool) -> dict[str, Any]:
    with tempfile.TemporaryDirectory() as folder:
        bench = Bench(Path(folder))
        before, started = machine(REPOSITORY), time.strftime("%Y-%m-%d %H:%M")
        prepared = fill_cache(bench, groups)
        chosen = [one for one in measurements(bench) if one.group in groups]
        runs: dict[str, list[dict[str, Any]]] = {one.key: [] for one in chosen}
        for number in range(rounds):
            for one in chosen:
                if hurry and one.once and number > 0:
                    continue
                figures = one.run()
                runs[one.key].append(figures)
                said = figures.get("seconds") or figures.get("missing") or figures.get("failed") or "done"
                print(f"round {number + 1} of {rounds}: {one.key}: {said}", file=sys.stderr, flush=True)
        return {
            "machine": before | {"load_after": os.getloadavg()[0]},
            "prepared": prepared,
            "measurements": {key: _summary(found) | {"run": started} for key, found in runs.items()},
        }


def _summary(runs: list[dict[str, Any]]) -> dict[str, Any]:
    """Median seconds beside the run they belong to; those of all runs are kept."""
    good = [run for run in runs if "failed" not in run and "missing" not in run]
    if not good:
        return runs[0]
    if "changes" in good[0]:
        changes = {change: _summary([run["changes"][change] for run in good]) for change in good[0]["changes"]}
        return good[0] | {"changes": changes}
    middle = sorted(good, key=lambda run: run["seconds"])[len(good) // 2]
    clock, processor = ([run[key] for run in good] for key in ("seconds", "processor"))
    return middle | {"seconds": statistics.median(clock), "all_seconds": clock, "all_processor": processor}


if __name__ == "__main__":
    main()
