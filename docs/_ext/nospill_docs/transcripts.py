"""Sessions with the command line, run by the build, so that what the pages print is what the program prints."""

from __future__ import annotations

import os
import shlex
import shutil
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from nospill_docs.places import Places, copy_if_changed

TRANSCRIPTS: dict[str, tuple[str, ...]] = {
    "two-cups": ("nospill plan two-cups.toml -o out/two-cups", "nospill check out/two-cups"),
    "executed": (
        "nospill plan two-cups.toml -o out/two-cups",
        "nospill executed out/two-cups/robot.csv --plan out/two-cups --bandwidth 250",
        "nospill identify out/two-cups/robot.csv --plan out/two-cups --stayed tea",
    ),
    "misspelt": ("nospill plan misspelt.toml",),
    "out-of-reach": ("nospill plan out-of-reach.toml",),
    "impossible": ("nospill plan impossible.toml",),
    "bad-value": ("nospill plan overfull.toml",),
}
"""Name -> what is typed in a folder that holds the files of docs/examples."""


def write_transcripts(places: Places) -> None:
    """Run every session and write it as text, with the exit code where it is not 0."""
    with ThreadPoolExecutor(max_workers=os.cpu_count()) as pool:
        folders = pool.map(lambda name: _run(places, name), TRANSCRIPTS)
        for name, folder in zip(TRANSCRIPTS, folders, strict=True):
            copy_if_changed(folder / "session.txt", places.generated / "sessions" / f"{name}.txt")


def planned_session(places: Places) -> Path:
    """The plan folder that the session `two-cups` leaves behind."""
    return _run(places, "two-cups") / "work" / "out" / "two-cups"


def _run(places: Places, name: str) -> Path:
    """The folder of a session, run where it, its files or the package has changed."""
    examples = sorted((places.docs / "examples").glob("*.toml"))
    commands = TRANSCRIPTS[name]

    def run(folder: Path) -> None:
        work = folder / "work"
        work.mkdir()
        for path in examples:
            shutil.copy(path, work)
        (folder / "session.txt").write_text(session(commands, work), encoding="utf-8")

    key = "".join(path.read_text(encoding="utf-8") for path in examples)
    return places.cached(f"session-{name}", f"{commands} {key}", run)


def session(commands: tuple[str, ...], folder: Path) -> str:
    """What a terminal would show: each command, its output, and its exit code unless it is 0."""
    text = ""
    environment = {**os.environ, "NOSPILL_COMPILE": "off", "COLUMNS": "120"}
    for command in commands:
        _, *arguments = shlex.split(command)
        program = [sys.executable, "-c", "from nospill.cli import main; main()", *arguments]
        done = subprocess.run(program, cwd=folder, env=environment, text=True, capture_output=True, check=False)
        said = [line for line in done.stderr.splitlines() if not line.endswith(" ...")]
        lines = [line.rstrip() for line in [*done.stdout.splitlines(), *said]]
        while lines and not lines[0]:
            lines.pop(0)
        # Rules end with their table, and are of a character that is as wide as the others in every browser.
        width = max((len(line) for line in lines if "─" not in line), default=0)
        lines = [line.replace("─", "-")[:width] if "─" in line else line for line in lines]
        text += f"$ {command}\n" + "".join(f"{line}\n" for line in lines)
        text += f"(exit code {done.returncode})\n" if done.returncode else ""
    return text
