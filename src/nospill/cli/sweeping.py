"""sweep: many variants of a scenario, planned in processes or on a cluster."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from nospill.cli.progress import ProgressLine
from nospill.cli.reporting import STOPPED
from nospill.cli.tables import print_lines, print_table, print_verdict, say

if TYPE_CHECKING:  # for annotations only: at run time these would load numpy before the help text
    from nospill.sweeps.record import Sweep
    from nospill.sweeps.run import SweepProgress

_MOST_REASONS = 8


def sweep(
    file: Annotated[Path, typer.Argument(metavar="SWEEP.toml", help="What is varied, and of which scenario.")],
    output: Annotated[
        Path | None,
        typer.Option(
            "-o", "--output", metavar="DIR", help="Keep lines, table, figures and page here.", show_default=False
        ),
    ] = None,
    jobs: Annotated[
        int | None,
        typer.Option(
            "--jobs", metavar="N", help="Processes at a time.", show_default="as many as there are processors"
        ),
    ] = None,
    scheduler: Annotated[
        str | None,
        typer.Option("--scheduler", metavar="ADDRESS", help="Plan on a Dask cluster instead.", show_default=False),
    ] = None,
    plans: Annotated[bool, typer.Option("--plans", help="Keep the plan folder of every motion too.")] = False,
    retry: Annotated[
        bool, typer.Option("--retry", help="Plan again what ended out of time, out of memory or in a crash.")
    ] = False,
    no_figures: Annotated[bool, typer.Option("--no-figures", help="Draw none.")] = False,
) -> int:
    """Plan many variants of a scenario, one line each; the same command goes on where it stopped."""
    from nospill.errors import ScenarioError
    from nospill.sweeps.definition import read_sweep
    from nospill.sweeps.executors import usual_jobs
    from nospill.sweeps.run import run_sweep
    from nospill.sweeps.writing import write_sweep

    if output is None:
        raise ScenarioError("-o DIR is missing: name a folder, where a line is kept for every point")
    if jobs is not None and scheduler is not None:
        raise ScenarioError("--jobs is of this machine and --scheduler of a cluster; give one of them")
    definition = read_sweep(file)
    say(f"{len(definition.points)} points of {definition.base.name}")
    try:
        with ProgressLine() as progress:
            found = run_sweep(
                definition,
                folder=output,
                jobs=usual_jobs() if jobs is None else jobs,
                scheduler=scheduler,
                plans=plans,
                retry=retry,
                progress=lambda report: progress.say(*_told(report)),
            )
            progress.say("table, figures and page")
            write_sweep(found, output, scenario=definition.scenario_name, figures=not no_figures)
    except KeyboardInterrupt:
        say(f"stopped; every line that was finished is in {output}, and the same command goes on")
        return STOPPED
    _print(found, output)
    return 0 if any(line.certified for line in found.lines) else 1


def _told(report: SweepProgress) -> tuple[str, str]:
    what = "planned from nothing once more" if report.again else "points"
    if report.left_s is None:  # neighbours start from the plan at the middle of their group, and come with it
        left = "; plans that others start from are made anew" if report.done else "; the first group is being planned"
    else:
        left = f", {_span(report.left_s)} left"
    return what, f"{report.done} of {report.total}, {report.certified} certified{left}"


def _span(seconds: float) -> str:
    if seconds < 100.0:
        return f"{seconds:.0f} s"
    return f"{seconds / 60:.0f} min" if seconds < 6000.0 else f"{seconds / 3600:.1f} h"


def _print(found: Sweep, output: Path) -> None:
    reasons: dict[tuple[str, str], int] = {}
    for line in found.lines:
        if not line.certified:
            reasons[line.ending, line.reason] = reasons.get((line.ending, line.reason), 0) + 1
    if reasons:
        commonest = sorted(reasons.items(), key=lambda item: -item[1])
        print_table(("points", "ending", "reason"), [(count, *which) for which, count in commonest[:_MOST_REASONS]])
        if len(commonest) > _MOST_REASONS:
            print_lines(f"... and {len(commonest) - _MOST_REASONS} other reasons, in the table")
    if found.cold_text:
        print_lines(found.cold_text)
    best = found.best
    if best is not None:
        values = ", ".join(f"{key} = {value}" for key, value in best.values.items())
        name = found.definition.goals[0][0]
        [value] = [found.rows[index][name] for index, line in enumerate(found.lines) if line is best]
        print_lines(f"best: {name} {value:.4g} at {values}; nearest to its limit: {best.nearest}")
    print_lines(f"written to {output}; look: {output / 'index.html'}")
    print_verdict(found.headline, best is not None)
