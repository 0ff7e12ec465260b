"""The command line: reads arguments, calls one function, prints what it returned.

Exit codes: 0 certified (or done), 1 solved but not certified, 2 bad input, 3 no solution, 70 a fault of nospill itself,
130 stopped by the user. Heavy libraries are imported inside the commands, so that help and errors come at once.
"""

from __future__ import annotations

import gc
import io
import sys
from collections.abc import Callable
from typing import Annotated

import typer

from nospill import __version__
from nospill.cli.arranging import layout
from nospill.cli.bounding import largest
from nospill.cli.cache import cache
from nospill.cli.checking import check
from nospill.cli.designing import design_test
from nospill.cli.executing import executed
from nospill.cli.exporting import export
from nospill.cli.filming import film
from nospill.cli.identifying import identify
from nospill.cli.judging import judge
from nospill.cli.listings import examples, robots, schema
from nospill.cli.measuring import measure
from nospill.cli.planning import plan, plot
from nospill.cli.reporting import reported
from nospill.cli.retiming import retime
from nospill.cli.sharing import report
from nospill.cli.slosh import compare, simulate
from nospill.cli.slowing import slow
from nospill.cli.stopping import stops
from nospill.cli.studio import studio
from nospill.cli.sweeping import sweep
from nospill.cli.verifying import margins, verify
from nospill.cli.viewing import view
from nospill.core.blas_threads import one_thread_by_default

GROUPS: dict[str, tuple[Callable[..., int], ...]] = {
    "Plan": (plan, examples, robots, schema, studio, retime, slow),
    "Look": (view, plot, report, film),
    "Judge": (judge, check, executed, verify, stops),
    "Hand over": (export,),
    "Laboratory": (identify, design_test, measure, simulate, compare),
    "Many": (sweep, largest, layout, margins, cache),
}
"""What a user wants -> the commands for it, both in the order of the help text: a new command is a function in a file
here and an entry in this table."""

app = typer.Typer(
    name="nospill",
    help="Plan and certify the fastest motion of a robot arm that carries open cups and loose objects on a tray.",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
)


def main() -> None:
    """Entry point of the command `nospill`."""
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="replace")  # a sign that the encoding lacks must not end a command
    one_thread_by_default()
    # Imports alone make a hundred thousand objects that stay, through which the usual threshold of 700 looks 170 times;
    # one look through them takes 0.04 s.
    gc.set_threshold(200_000)
    try:
        app()
    finally:
        # Before it ends the interpreter looks through all objects for cycles: a tenth of a second for memory that is
        # freed all the same.
        gc.freeze()


def _print_version(wanted: bool) -> None:
    if wanted:
        print(f"nospill {__version__}")
        raise typer.Exit()


@app.callback()
def _options(
    version: Annotated[
        bool, typer.Option("--version", callback=_print_version, is_eager=True, help="Print the version and stop.")
    ] = False,
) -> None:
    """Plan and certify the fastest motion of a robot arm that carries open cups and loose objects on a tray."""


for _group, _commands in GROUPS.items():
    for _command in _commands:
        app.command(rich_help_panel=_group)(reported(_command))
