"""What the benchmark says: machine and tables with targets."""

from __future__ import annotations

import os
import platform
import subprocess
import sys
from importlib.metadata import version
from pathlib import Path
from typing import Any

from benchmarks.planning.rows import TABLES, Found

BEGIN, END = "<!-- benchmark table: begin -->", "<!-- benchmark table: end -->"


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


HEADER = (
    "| measurement | clock, s | p98 | processor, s | p98 | ratio | | target | |",
    "|---|---:|---:|---:|---:|---:|---|---:|---|",
)


def table(results: dict[str, Any]) -> str:
    """The machine, the tables and what is missing from them, as Markdown."""
    machine = results["machine"]
    text = [
        f"{machine['processor']}, {machine['cores']} cores, "
        f"load {machine['load_before']:.1f} to {machine['load_after']:.1f}; "
        f"Python {machine['python']}, CasADi {machine['casadi']}, commit {machine['commit']}"
        + (" and changes" if machine["changed_since"] else ""),
    ]
    found = Found(results["measurements"])
    for title, rows in TABLES.items():
        lines = list(rows(found))
        if lines:
            text += ["", f"{title}:", "", *HEADER, *(f"| {' | '.join(line.cells)} |" for line in lines)]
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
