"""The command line: reads arguments, calls one function, prints what it returned.

Exit codes: 0 certified (or done), 1 solved but not certified, 2 bad input, 3 no solution, 70 a fault of nospill itself,
130 stopped by the user. Heavy libraries are imported inside the commands, so that help and errors come at once.
"""

from __future__ import annotations

import functools
import json
import os
import signal
import sys
import threading
import time
import traceback
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager, nullcontext, redirect_stdout
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, ParamSpec, Self

import typer

from nospill.errors import NoSolutionError, NospillError

if TYPE_CHECKING:  # for annotations only: at run time these would load numpy and CasADi before the help text
    from nospill.certificate import Certificate
    from nospill.planner import PlanningProgress
    from nospill.plans import Plan

INTERNAL_ERROR = 70
STOPPED = 130
OUTPUT_CLOSED = 141

P = ParamSpec("P")

app = typer.Typer(
    name="nospill",
    help="Plan and certify the fastest motion of a robot arm that carries open cups and loose objects on a tray.",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
)


def main() -> None:
    """Entry point of the command `nospill`."""
    app()


def _reported(command: Callable[P, int]) -> Callable[P, None]:
    """Turn what a command returns or raises into one line and an exit code."""

    @functools.wraps(command)
    def run(*args: P.args, **kwargs: P.kwargs) -> None:
        try:
            code = command(*args, **kwargs)
            sys.stdout.flush()
        except NospillError as error:
            code = error.exit_code
            _say(_one_line(error))
        except KeyboardInterrupt:
            code = STOPPED
            _say("stopped; nothing was written")
        except BrokenPipeError:
            code = OUTPUT_CLOSED
            os.dup2(
                os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno()
            )  # or the interpreter complains when it flushes
        except Exception as error:
            code = INTERNAL_ERROR
            if os.environ.get("NOSPILL_TRACEBACK") == "1":
                traceback.print_exc()
            what = f"{type(error).__name__}: {_one_line(error)}"
            _say(f"internal error: {what}; please report it with the scenario (NOSPILL_TRACEBACK=1 shows where)")
        raise typer.Exit(code)

    return run


def _one_line(error: Exception | str) -> str:
    return " ".join(str(error).split())


def _say(line: str) -> None:
    print(line, file=sys.stderr, flush=True)


def _print_version(wanted: bool) -> None:
    if wanted:
        from importlib.metadata import version

        print(f"nospill {version('nospill')}")
        raise typer.Exit()


@app.callback()
def _options(
    version: Annotated[
        bool, typer.Option("--version", callback=_print_version, is_eager=True, help="Print the version and stop.")
    ] = False,
) -> None:
    """Plan and certify the fastest motion of a robot arm that carries open cups and loose objects on a tray."""


@app.command()
@_reported
def plan(
    scenario: Annotated[str, typer.Argument(help="A scenario file (TOML) or the name of a bundled example.")],
    output: Annotated[
        Path | None,
        typer.Option("-o", "--output", metavar="DIR", help="Write the plan folder here.", show_default=False),
    ] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print summary.json on stdout and nothing else.")] = False,
    no_figures: Annotated[bool, typer.Option("--no-figures", help="Leave the figures out of the plan folder.")] = False,
) -> int:
    """Plan a scenario and certify the motion; with -o, write its folder. Exit code 0 only if certified."""
    with _only_stderr() if as_json else nullcontext(), _Progress() as progress:
        from nospill.files import require_replaceable
        from nospill.scenario import read_scenario

        if output is not None:
            require_replaceable(output)
        scene = read_scenario(scenario)
        progress.say("load the optimiser")
        began = time.perf_counter()
        from nospill.planner import plan as find_plan

        loading = time.perf_counter() - began
        outcome: Plan | NoSolutionError
        try:
            outcome = find_plan(scene, progress=progress.show).timed("import", loading)
            if output is not None:
                progress.say("write")
                figures = None if no_figures else functools.partial(_write_figures, outcome)
                outcome.save(output, extra=figures, time_writing=True)
        except NoSolutionError as error:
            outcome = error
    if isinstance(outcome, NoSolutionError):
        if as_json:
            from nospill.plans import failed_summary

            _print_json(failed_summary(scene.name, _one_line(outcome)))
        raise outcome
    if as_json:
        saved = output / "summary.json" if output is not None else None
        _print_json(outcome.summary() if saved is None else json.loads(saved.read_text(encoding="utf-8")))
    else:
        _print_certificate(outcome.certificate)
        print(f"duration: {outcome.duration:.3f} s")
        print(f"written to {output}" if output is not None else "nothing written; -o DIR keeps the plan")
    if not outcome.certificate.ok:
        _say(_one_line(outcome.message))
    return 0 if outcome.certificate.ok else 1


@app.command()
@_reported
def check(
    folder: Annotated[Path, typer.Argument(metavar="DIR", help="A plan folder.")],
) -> int:
    """Judge a plan folder again, from its trajectory and scenario alone; nothing is optimised or written."""
    from nospill.certificate import certify
    from nospill.plans import describe, load_plan

    saved = load_plan(folder)
    certificate = certify(saved.trajectory, saved.scene)
    _print_certificate(certificate)
    if not certificate.ok:
        _say(f"Not certified: {describe(certificate.worst)}.")
    return 0 if certificate.ok else 1


@app.command()
@_reported
def plot(
    folder: Annotated[Path, typer.Argument(metavar="DIR", help="A plan folder.")],
) -> int:
    """Draw the figures of a plan folder again."""
    from nospill.files import atomic_folder
    from nospill.plans import load_plan
    from nospill.plots import save_figures

    saved = load_plan(folder)
    figures = folder / "figures"
    with _Progress() as progress, atomic_folder(figures, replaceable=_only_figures) as partial:
        progress.say("draw")
        save_figures(saved, partial)
        names = sorted(path.name for path in partial.iterdir())
    for name in names:
        print(figures / name)
    return 0


@app.command()
@_reported
def simulate(
    cup: Annotated[Path, typer.Argument(metavar="CUP.toml", help="A container: the keys of a cargo entry.")],
    motion: Annotated[
        Path, typer.Argument(metavar="MOTION.csv", help="Its motion: t_s, x_m, y_m, z_m, qx, qy, qz, qw.")
    ],
    output: Annotated[
        Path | None,
        typer.Option("-o", "--output", metavar="OUT.csv", help="Write t_s, height_mm here.", show_default=False),
    ] = None,
    modes: Annotated[int, typer.Option("--modes", metavar="N", help="Liquid modes in each direction.")] = 2,
    height: Annotated[
        str,
        typer.Option(
            "--height",
            metavar="one-mode|corrected",
            help="The carried modes alone, or with the quasi-static part of all the others.",
        ),
    ] = "one-mode",
) -> int:
    """Predict the height of the liquid in one container that is moved in a given way."""
    from nospill.motion_file import read_motion, write_heights
    from nospill.simulate import simulate_slosh

    given = read_motion(motion)
    found = simulate_slosh(cup, given.t, given.position, given.quaternion, modes=modes, height=height)
    if output is not None:
        write_heights(output, found.heights)
    print(f"peak height: {1e3 * found.peak:.2f} mm above rest at t = {found.peak_time:.3f} s")
    print(f"rim: {1e3 * found.room:.2f} mm above rest" + (": the liquid spills" if found.peak > found.room else ""))
    if output is not None:
        print(f"written to {output}")
    return 0


@app.command()
@_reported
def compare(
    predicted: Annotated[
        str, typer.Argument(metavar="PREDICTED", help="A CSV (t_s, height_mm), or a plan folder and a cup as DIR:CUP.")
    ],
    measured: Annotated[Path, typer.Argument(metavar="MEASURED.csv", help="The measured height: t_s, height_mm.")],
    figure: Annotated[
        Path | None,
        typer.Option("-o", "--output", metavar="FIG", help="Draw both (.png, .pdf or .svg).", show_default=False),
    ] = None,
) -> int:
    """Compare a predicted liquid height with a measured one; the clocks are aligned by best correlation."""
    from nospill.compare import compare as compare_heights
    from nospill.compare import predicted_heights
    from nospill.motion_file import read_heights

    if figure is not None:
        from nospill.plots.comparison import require_figure_name

        require_figure_name(figure)
    found = compare_heights(predicted_heights(predicted), read_heights(measured))
    _print_table(
        ("figure", "value", "unit"),
        [
            ("predicted peak", 1e3 * found.predicted_peak, "mm"),
            ("measured peak", 1e3 * found.measured_peak, "mm"),
            ("peak error", 1e3 * found.peak_error, "mm"),
            ("peak error", 1e2 * found.relative_peak_error, "%"),
            ("root mean square error", 1e3 * found.rmse, "mm"),
            ("correlation", found.correlation, ""),
            ("integral error", 1e2 * found.integral_error, "%"),
            ("clock shift", found.shift, "s"),
        ],
    )
    if figure is not None:
        from nospill.plots.comparison import save_comparison

        save_comparison(found, figure)
        print(f"drawn to {figure}")
    return 0


@app.command()
@_reported
def examples() -> int:
    """List the bundled examples."""
    from nospill.examples import EXAMPLES

    _print_table(("example", "what it shows"), [(name, text) for name, text in EXAMPLES.items()])
    return 0


@app.command()
@_reported
def robots(
    as_json: Annotated[bool, typer.Option("--json", help="Print limits and their sources as JSON.")] = False,
) -> int:
    """List the robots in the catalogue."""
    from nospill.robots.catalog import robot_table

    table = robot_table()
    if as_json:
        _print_json(table)
        return 0
    keys = ("name", "title", "reach_m", "payload_kg")
    _print_table(("robot", "what it is", "reach m", "payload kg"), [[row[key] for key in keys] for row in table])
    return 0


@app.command()
@_reported
def schema() -> int:
    """Print the JSON schema of a scenario file."""
    from nospill.scenario import scenario_schema

    _print_json(scenario_schema())
    return 0


class _Progress:
    """Where planning stands, on stderr: one moving line on a terminal, elsewhere one line for each phase.

    A solver takes the KeyboardInterrupt raised inside it for a failed step and goes on, so Ctrl-C is kept here too and
    raised again by the next report.
    """

    def __init__(self) -> None:
        from rich.console import Console

        console = Console(stderr=True)
        self._status = console.status("") if console.is_terminal else None
        self._last = ""
        self._stopped = False
        self._usual: Any = None

    def __enter__(self) -> Self:
        if threading.current_thread() is threading.main_thread():
            self._usual = signal.signal(signal.SIGINT, self._stop)
        if self._status is not None:
            self._status.start()
        return self

    def __exit__(self, kind: type[BaseException] | None, *_: object) -> None:
        if self._usual is not None:
            signal.signal(signal.SIGINT, self._usual)
        if self._status is not None:
            self._status.stop()
        if self._stopped and kind is not None:  # whatever the libraries made of it
            raise KeyboardInterrupt

    def _stop(self, *_: object) -> None:
        self._stopped = True
        raise KeyboardInterrupt

    def show(self, report: PlanningProgress) -> None:
        """Say what the planner reports; called once an iteration."""
        details = [
            f"iteration {report.iteration}" if report.iteration is not None else "",
            f"{report.duration_s:.3f} s" if report.duration_s is not None else "",
            f"violation {report.violation:.1e}" if report.violation is not None else "",
        ]
        self.say(report.phase, ", ".join(filter(None, details)))

    def say(self, phase: str, details: str = "") -> None:
        """Say a phase and, where the line can move, its details.

        Raises:
            KeyboardInterrupt: Ctrl-C came since the last report and was swallowed.
        """
        if self._stopped:
            raise KeyboardInterrupt
        if self._status is not None:
            self._status.update(f"{phase} {details}")
        elif phase != self._last:
            _say(f"{phase} ...")
        self._last = phase


@contextmanager
def _only_stderr() -> Iterator[None]:
    """Send everything that Python and the compiled solvers print to stderr, so that stdout stays clean for JSON."""
    import ctypes

    sys.stdout.flush()
    stdout = os.dup(1)
    os.dup2(2, 1)
    try:
        with redirect_stdout(sys.stderr):
            yield
    finally:
        if os.name == "posix":
            ctypes.CDLL(None).fflush(None)  # what C code has printed may still wait in its own buffer
        os.dup2(stdout, 1)
        os.close(stdout)


def _write_figures(found: Plan, folder: Path) -> None:
    from nospill.plots import save_figures

    save_figures(found, folder / "figures")


def _only_figures(names: set[str]) -> bool:
    return all(name.endswith((".png", ".pdf")) for name in names)


def _print_json(value: object) -> None:
    print(json.dumps(value, indent=2, allow_nan=False))


def _print_certificate(certificate: Certificate) -> None:
    """Print the worst row of each constraint and the verdict."""
    from nospill.plans import shown_unit

    lines = []
    for row in certificate.worst_rows():
        factor, unit = shown_unit(row.unit, row.limit)
        figures = (factor * row.worst_value, factor * row.limit, factor * row.worst_margin)
        lines.append((row.constraint, row.subject, *figures, unit, row.at_s, "ok" if row.ok else "FAILS"))
    _print_table(("constraint", "worst at", "value", "limit", "margin", "unit", "t / s", ""), lines)
    grid = f"on a grid of {certificate.grid_hz:g} Hz"
    failed = [row for row in certificate.rows if not row.ok]
    if certificate.ok:
        print(f"certified: all {len(certificate.rows)} rows hold {grid}")
    else:
        print(f"not certified: {len(failed)} of {len(certificate.rows)} rows fail {grid}")


def _print_table(columns: Sequence[str], rows: Iterable[Sequence[object]]) -> None:
    from rich import box
    from rich.console import Console
    from rich.table import Table
    from rich.text import Text

    table = Table(box=box.SIMPLE_HEAD)
    for column in columns:
        table.add_column(column)
    for row in rows:
        table.add_row(*(Text(_cell(value)) for value in row))  # Text: names may hold what rich takes for markup
    Console(width=None if sys.stdout.isatty() else 120).print(table)


def _cell(value: object) -> str:
    if value is None:
        return "-"
    return f"{value:.4g}" if isinstance(value, float) else str(value)
