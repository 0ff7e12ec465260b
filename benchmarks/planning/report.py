"""What the benchmark says: machine, table with targets, plot."""

from __future__ import annotations

import os
import platform
import re
import subprocess
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from importlib.metadata import version
from pathlib import Path
from typing import Any

from benchmarks.planning.scenes import LARGER_CHANGES

BEGIN, END = "<!-- benchmark table: begin -->", "<!-- benchmark table: end -->"


_AS_IT_STANDS = ", twenty modes"
"""End of the keys of examples that are planned with the full model."""


@dataclass(frozen=True)
class Line:
    """One line of the table; `ratio` is what the target speaks of, `most` whether it is an upper limit."""

    what: str
    seconds: float
    ratio: float | None = None
    of: str = ""
    target: float | None = None
    most: bool = True

    @property
    def verdict(self) -> str:
        """Whether the target is met; empty where there is none."""
        if self.target is None or self.ratio is None:
            return ""
        return "met" if (self.ratio <= self.target) == self.most else "missed"


def machine(repository: Path) -> dict[str, Any]:
    """Where and with what the figures are made."""

    def git(*arguments: str) -> str:
        done = subprocess.run(["git", "-C", repository, *arguments], capture_output=True, text=True, check=False)
        return done.stdout.strip()

    return {
        "processor": _processor(),
        "cores": os.cpu_count(),
        "load_before": os.getloadavg()[0],
        "system": platform.system(),
        "python": platform.python_version(),
        "casadi": version("casadi"),
        "commit": git("rev-parse", "--short", "HEAD"),
        "changed_since": bool(git("status", "--porcelain", "--", "src")),
    }


def _processor() -> str:
    if sys.platform == "linux":
        for line in Path("/proc/cpuinfo").read_text().splitlines():
            if line.startswith("model name"):
                return line.split(":", 1)[1].strip()
    return platform.processor() or platform.machine()


def lines(results: dict[str, Any]) -> Iterator[Line]:
    """The table, as far as the measurements go."""
    found = {key: value for key, value in results["measurements"].items() if "failed" not in value}
    seconds = {key: value["seconds"] for key, value in found.items() if "seconds" in value}

    def together(key: str, reference: str) -> bool:
        """Only what was measured alternately in one run is compared."""
        return reference in seconds and found[key].get("run") == found[reference].get("run")

    def converged(key: str) -> bool:
        return found[key].get("status", "Solve_Succeeded") == "Solve_Succeeded"

    def faster(key: str, reference: str, target: float) -> Iterator[Line]:
        """Of a baseline that did not converge only the time is known that it had."""
        if key in seconds:
            compared = together(key, reference) and converged(reference)
            ratio = seconds[reference] / seconds[key] if compared else None
            yield Line(key, seconds[key], ratio, f"times faster than {reference}", target, most=False)

    def share(key: str, reference: str, target: float | None) -> Iterator[Line]:
        if key in seconds:
            ratio = seconds[key] / seconds[reference] if together(key, reference) else None
            yield Line(key, seconds[key], ratio, f"of {reference}", target)

    def cold(*, as_it_stands: bool) -> Iterator[Line]:
        """Plans of the examples as they stand, or with one mode of each liquid."""
        for key in seconds:
            if key.startswith("cold ") and "duration" in found[key] and key.endswith(_AS_IT_STANDS) == as_it_stands:
                target = 0.8 if key == "cold matrix-liquid-tilt" else None
                yield Line(key, seconds[key], seconds[key] / found[key]["duration"], "of the motion", target)

    yield from cold(as_it_stands=True)
    for key in ("baseline liquid", "baseline rigid"):
        if key in seconds:
            stopped = "" if converged(key) else ", not converged"
            yield Line(f"{key} ({found[key]['iterations']} iterations{stopped})", seconds[key])
    yield from faster("cold matrix-liquid", "baseline liquid", 100)
    yield from faster("cold matrix-rigid", "baseline rigid", 12)
    yield from faster("no compiler matrix-liquid", "baseline liquid", 45)
    yield from faster("no compiler matrix-rigid", "baseline rigid", 4)
    yield from cold(as_it_stands=False)
    limits = {"matrix-liquid": 0.05, "matrix-liquid-tilt": 0.1}
    for name in limits:
        run = found.get(f"warm {name}")
        for part in ("first", "again") if run else ():
            for change, figures in run[part].items() if run else ():
                label = f"warm {name}: {change}" + (", first time" if part == "first" else "")
                ratio = figures["seconds"] / figures["duration"]
                limit = 0.3 if change in LARGER_CHANGES else limits[name]
                yield Line(label, figures["seconds"], ratio, "of the motion", limit)
                if part == "again" and together(f"warm {name}", "baseline rigid"):  # the same on a slower machine
                    ratio = seconds["baseline rigid"] / figures["seconds"]
                    yield Line(label, figures["seconds"], ratio, "times faster than baseline rigid")
    processes = {"process, cold cache": None, "process, second run": 0.7, "process with figures, second run": 2.0}
    for key, target in processes.items():
        if key in seconds:
            yield Line(key, seconds[key], seconds[key] / found[key]["duration"], "of the motion", target)
    for key in seconds:
        if key.startswith("first plan") and found[key].get("again"):
            target = 3.0 if key.endswith("empty cache") else 1.5
            yield Line(key, seconds[key], seconds[key] / found[key]["again"], "of the second", target)
    if "import nospill" in seconds:
        own = seconds["import nospill"] - seconds["python -c pass"]
        yield Line("import nospill", own, own, "s, interpreter taken off", 0.6)
        own = seconds["import nospill.planning.planner"] - seconds["python -c pass"]
        yield Line("import nospill.planning.planner", own)
    for count in (1, 2, 4, 8, 16, 32):
        key = f"{count} cup{'s' if count > 1 else ''}"
        yield from share(key, "4 cups", 10 if count == 32 else None)
    for count in (4, 16, 64):
        yield from share(f"{count} different cups", "4 different cups", 20 if count == 64 else None)
    for count in (132, 500):
        yield from share(f"{count} wells and vials", "cold matrix-liquid", 5 if count == 132 else None)
    for intervals in (50, 100, 200, 400):
        yield from share(f"N = {intervals}", "N = 100", 4.2 if intervals == 400 else None)
    yield from share("toppra, rigid on a level tray", "cold matrix-rigid", None)
    memory = {key: value["peak_memory_mb"] for key, value in found.items() if "peak_memory_mb" in value}
    memory = {key: value for key, value in memory.items() if not key.startswith(("baseline", "toppra"))}
    if memory:
        key = max(memory, key=lambda one: memory[one])
        yield Line(f"peak memory: {key}", seconds.get(key, float("nan")), memory[key], "MB", 600)


def table(results: dict[str, Any]) -> str:
    """The machine, the table and what is missing from it, as Markdown."""
    machine = results["machine"]
    text = [
        f"{machine['processor']}, {machine['cores']} cores, "
        f"load {machine['load_before']:.1f} to {machine['load_after']:.1f}; "
        f"Python {machine['python']}, CasADi {machine['casadi']}, commit {machine['commit']}"
        + (" and changes" if machine["changed_since"] else ""),
        "",
        "| measurement | s | ratio | | target | |",
        "|---|---:|---:|---|---:|---|",
    ]
    for line in lines(results):
        ratio = "" if line.ratio is None else f"{line.ratio:.3g}"
        target = "" if line.target is None else f"{'≤' if line.most else '≥'} {line.target:.3g}"
        text.append(f"| {line.what} | {line.seconds:.3f} | {ratio} | {line.of} | {target} | {line.verdict} |")
    for key, value in results["measurements"].items():
        reason = value.get("failed") or value.get("missing")
        if reason:
            text += ["", f"not measured: {key}: {reason}"]
        elif value.get("certified") is False:
            text += ["", f"not certified: {key}"]
    return "\n".join(text) + "\n"


def write_page(results: dict[str, Any], page: Path) -> None:
    """Replace the table between the page's markers."""
    before, rest = page.read_text(encoding="utf-8").split(BEGIN)
    _, after = rest.split(END)
    page.write_text(f"{before}{BEGIN}\n{table(results)}{END}{after}", encoding="utf-8")


def save_plot(results: dict[str, Any], place: Path) -> None:
    """Times by phase of cold plans, and how they grow with the number of cups and of intervals."""
    # imported here: a measuring process that is itself large makes its children look so
    from matplotlib.figure import Figure
    from matplotlib.ticker import LogLocator

    found = results["measurements"]
    figure = Figure(figsize=(9.0, 3.2), layout="constrained")
    bars, growth = figure.subplots(1, 2, width_ratios=(3, 2))
    keys = [key for key in found if key.startswith(("cold ", "no compiler ")) and "phases" in found[key]]
    left = [0.0] * len(keys)
    for phase in dict.fromkeys(name for key in keys for name in found[key]["phases"]):
        widths = [found[key]["phases"].get(phase, 0.0) for key in keys]
        bars.barh(keys, widths, left=left, label=phase)
        left = [start + width for start, width in zip(left, widths, strict=True)]
    bars.invert_yaxis()
    bars.set_xlabel("time / s")
    if keys:
        bars.legend(fontsize=7)
    for label, name, marker in (
        ("equal cups", r"(\d+) cups?", "o"),
        ("different cups", r"(\d+) different cups", "^"),
        ("intervals", r"N = (\d+)", "s"),
    ):
        points = sorted(
            (int(match[1]), value["seconds"])
            for key, value in found.items()
            if (match := re.fullmatch(name, key)) and "seconds" in value
        )
        if points:
            growth.loglog(*zip(*points, strict=True), marker=marker, label=label)
    growth.set_xlabel("number")
    growth.set_ylabel("time of a cold plan / s")
    for axis, labelled in ((growth.xaxis, (1.0,)), (growth.yaxis, (1.0, 2.0, 5.0))):  # 0.5, 1, 2 instead of powers
        axis.set_major_locator(LogLocator(subs=labelled))
        axis.set_major_formatter("{x:g}")
        axis.set_minor_formatter("")
    growth.grid(alpha=0.3)
    if growth.lines:
        growth.legend(loc="upper left", fontsize=7)
    figure.savefig(place, dpi=130)
