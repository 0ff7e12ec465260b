"""plan, plot: from a scenario to a plan folder, and what can be done with one."""

from __future__ import annotations

import functools
import json
import time
from contextlib import nullcontext
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from nospill.cli.checking import print_certificate, print_warnings
from nospill.cli.notes import say_notes
from nospill.cli.progress import FILES, LOADING, PLANNING_STEPS, ProgressLine
from nospill.cli.reporting import one_line, only_stderr, print_json
from nospill.cli.run_options import PlanOutput, Settings, seconds
from nospill.cli.sharing import write_plan_report
from nospill.cli.tables import print_lines, print_verdict, say
from nospill.errors import NoSolutionError, ScenarioError

if TYPE_CHECKING:  # for annotations only: at run time these would load numpy and CasADi before the help text
    from nospill.plans.plan import Plan


_OF_A_BAG = "metadata.yaml"
"""In the folder of a ROS 2 bag, and in none of a plan."""


def plan(
    scenario: Annotated[
        str, typer.Argument(help="A scenario file (TOML), a plan folder, or the name of a bundled example.")
    ],
    output: PlanOutput = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print summary.json on stdout and nothing else.")] = False,
    no_figures: Annotated[bool, typer.Option("--no-figures", help="Leave the figures out of the plan folder.")] = False,
    all_figures: Annotated[
        bool, typer.Option("--all-figures", help="Draw every figure, not the summary sheet alone.")
    ] = False,
    pdf: Annotated[bool, typer.Option("--pdf", help="Write the figures as PDF too.")] = False,
    report: Annotated[bool, typer.Option("--report", help="Write DIR.report.html beside the plan folder.")] = False,
    compare: Annotated[
        bool, typer.Option("--compare", help="State what is saved against a level tray and a trapezoid profile.")
    ] = False,
    settings: Settings = None,
    after: Annotated[
        Path | None,
        typer.Option(
            "--after",
            metavar="DIR|LOG",
            help="Begin where this plan ends, in its joints and with its swing, or with what this joint log leaves.",
            show_default=False,
        ),
    ] = None,
    wait: Annotated[str, typer.Option(metavar="TIME", help="Between that plan and this one.")] = "0 s",
) -> int:
    """Plan a scenario and certify the motion; with -o, write its folder. Exit code 0 only if certified."""
    from nospill.core.files import require_replaceable
    from nospill.plans.names import holds_a_plan, is_plan_folder
    from nospill.scenario.loading import has_legs

    if report and output is None:
        raise ScenarioError("--report is written beside the plan folder; name one with -o DIR")
    if output is not None:
        require_replaceable(output, replaceable=holds_a_plan)
    if has_legs(scenario):
        from nospill.cli.cycles import plan_legs

        given = {"--after": after, "--report": report, "--compare": compare, "--pdf": pdf, "--all-figures": all_figures}
        refused = [option for option, value in given.items() if value]
        figures = not no_figures
        return plan_legs(scenario, output, settings=settings or (), figures=figures, as_json=as_json, refused=refused)
    with only_stderr() if as_json else nullcontext(), ProgressLine(PLANNING_STEPS) as progress:
        from nospill.plans.loading import load_plan, require_no_own_limits
        from nospill.plans.names import SUMMARY_FILE
        from nospill.scenario import read_scenario

        if output is not None:
            require_replaceable(output, replaceable=is_plan_folder)
        require_no_own_limits(scenario)
        scene = read_scenario(scenario, settings=settings or ())
        say_notes(scene)
        if after is not None and not (after.is_file() or (after / _OF_A_BAG).is_file()):
            from nospill.plans.rows import with_residual_slosh

            scene = with_residual_slosh(scene, load_plan(after), seconds(wait))
        elif after is not None:
            from nospill.execution.going_on import after_log
            from nospill.execution.reading import read_log

            begun = after_log(scene, read_log(after, scene.robot), seconds(wait))
            scene = begun.scene
            say(begun.text)
        progress.say(LOADING)
        began = time.perf_counter()
        from nospill.planning.planner import plan as find_plan

        loading = time.perf_counter() - began
        outcome: Plan | NoSolutionError
        page: Path | None = None
        stopping = ""
        try:
            try:
                if scene.motion.stoppable is not None:
                    from nospill.stopping.stoppable import plan_stoppable

                    stoppable = plan_stoppable(scene, progress=progress.show, said=say)
                    found, stopping = stoppable.plan, stoppable.text
                else:
                    found = find_plan(scene, progress=progress.show)
                outcome = found.timed("import", loading).with_second_looks()
            except ScenarioError as error:  # the arm cannot follow the path: the file is named as where it is read
                raise ScenarioError(f"{scenario}: {error}", error.reason) from error
            if compare:
                from nospill.comparison import compared

                outcome = compared(outcome, say=lambda name: say(f"compared with a {name} ..."))
            if output is not None:
                progress.say(FILES)
                drawing = functools.partial(_write_figures, outcome, progress, pdf=pdf, everything=all_figures)
                figures = None if no_figures else drawing
                outcome.save(output, extra=figures, time_writing=True)
                page = write_plan_report(outcome, output) if report else None
        except NoSolutionError as error:
            outcome = error
    if isinstance(outcome, NoSolutionError):
        if as_json:
            from nospill.plans.summary import failed_summary

            print_json(failed_summary(scene.name, one_line(outcome)))
        raise NoSolutionError(f"{scenario}: {outcome}", outcome.reason)
    if as_json:
        saved = output / SUMMARY_FILE if output is not None else None
        print_json(outcome.summary() if saved is None else json.loads(saved.read_text(encoding="utf-8")))
    else:
        print_plan(outcome, output, page)
    if stopping:
        say(stopping)
    if not outcome.certificate.ok:
        say(one_line(outcome.message))
    return 0 if outcome.certificate.ok else 1


def print_plan(outcome: Plan, output: Path | None, page: Path | None = None) -> None:
    """Print verdict, certificate, what holds the motion back, what was chosen and written, and the verdict again."""
    from nospill.plans.text import plan_lines

    certificate = outcome.certificate
    print_certificate(certificate, outcome.scene)
    print_warnings(outcome.warnings)
    lines = plan_lines(outcome)
    lines.append(f"written to {output}" if output is not None else "nothing written; -o DIR keeps the plan")
    lines += [f"written to {page}"] if page is not None else []
    lines += [f"look: nospill view {output}"] if output is not None else []
    print_lines(*lines)
    print_verdict(f"{certificate.word}: {outcome.duration:.3f} s", certificate.ok)


def plot(
    folder: Annotated[Path, typer.Argument(metavar="DIR", help="A plan folder.")],
    pdf: Annotated[bool, typer.Option("--pdf", help="Write every figure as PDF too.")] = False,
) -> int:
    """Draw every figure of a plan folder, as PNG or also as PDF."""
    from nospill.core.files import atomic_folder
    from nospill.plans.loading import load_plan
    from nospill.plots import save_figures

    saved = load_plan(folder)
    figures = folder / "figures"
    with ProgressLine() as progress, atomic_folder(figures, replaceable=_only_figures) as partial:
        save_figures(saved, partial, pdf=pdf, progress=progress.drawn)
        names = sorted(path.name for path in partial.iterdir())
    for name in names:
        print(figures / name)
    return 0


def _write_figures(found: Plan, progress: ProgressLine, folder: Path, *, pdf: bool, everything: bool) -> None:
    from nospill.plots import FIRST_FIGURES, save_figures

    names = () if everything else FIRST_FIGURES
    save_figures(found, folder / "figures", names=names, pdf=pdf, progress=progress.drawn)


def _only_figures(names: set[str]) -> bool:
    return all(name.endswith((".png", ".pdf")) for name in names)
