"""Sessions with the command line, so that what the pages print is what the program prints."""

from __future__ import annotations

import atexit
import os
import shlex
import shutil
import subprocess
import sys
import tempfile
from functools import cache
from pathlib import Path

from nospill_docs.places import Places

_PLAN = "nospill plan two-cups.toml -o out/two-cups"

SESSIONS: dict[str, tuple[str, ...]] = {
    "two-cups": (_PLAN,),
    "executed": (
        "nospill executed out/two-cups/robot.csv --plan out/two-cups",
        "nospill identify out/two-cups/robot.csv --plan out/two-cups --stayed tea",
    ),
    "misspelt": ("nospill plan misspelt.toml",),
    "out-of-reach": ("nospill plan out-of-reach.toml",),
    "impossible": ("nospill plan impossible.toml",),
    "bad-value": ("nospill plan overfull.toml",),
}
"""Name -> what is typed in a folder that holds the files of docs/examples."""

AFTER = {"executed": "two-cups"}
"""Session -> the one that it continues, in the folder which that has left."""

PLANNED = {"two-cups", "executed", "out-of-reach", "impossible"}
"""Sessions that solve an optimal control problem."""


def shown(name: str, examples: Path) -> str:
    """A session as a page shows it."""
    return f"```console\n{_typed(name, examples)[0].rstrip()}\n```"


@cache
def _typed(name: str, examples: Path) -> tuple[str, Path]:
    """A session, typed once a process, and its folder, which stays until the process ends."""
    folder = Path(tempfile.mkdtemp())
    atexit.register(shutil.rmtree, folder, ignore_errors=True)
    if name in AFTER:
        work = Path(shutil.copytree(_typed(AFTER[name], examples)[1], folder / "work"))
    else:
        work = _work(examples, folder)
    return session(SESSIONS[name], work, unsaid=("--no-figures",)), work  # which no page shows


def planned_session(places: Places) -> Path:
    """The plan folder that the session `two-cups` leaves behind."""
    examples = places.docs / "examples"
    key = "".join(path.read_text(encoding="utf-8") for path in sorted(examples.glob("*.toml")))

    def run(folder: Path) -> None:
        session((_PLAN,), _work(examples, folder))

    made = places.cached("two-cups", f"{_PLAN} {key}", run)
    return made / "work" / "out" / "two-cups"


def _work(examples: Path, folder: Path) -> Path:
    """A folder with the scenarios of docs/examples."""
    work = folder / "work"
    work.mkdir()
    for path in sorted(examples.glob("*.toml")):
        shutil.copy(path, work)
    return work


def session(commands: tuple[str, ...], folder: Path, *, unsaid: tuple[str, ...] = ()) -> str:
    """What a terminal would show: each command, its output, and its exit code unless it is 0.

    Commands wait for what is compiled: where the package's linear solver is not there yet, another one takes its place
    and rounds otherwise, and of two subjects that come equally near to a limit a table then names the other one.

    Args:
        commands: as they are shown.
        folder: in which they are typed.
        unsaid: options that every planning is given and that change nothing of what is printed.
    """
    text = ""
    environment = {**os.environ, "NOSPILL_COMPILE": "wait", "COLUMNS": "120"}
    for command in commands:
        _, *arguments = shlex.split(command)
        arguments += unsaid if arguments[0] == "plan" else ()
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
