"""report: a plan folder as one page to share."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from nospill.cli.progress import ProgressLine
from nospill.cli.reporting import sibling_file
from nospill.cli.run_options import assigned, read_run
from nospill.core.files import require_writable
from nospill.errors import ScenarioError

if TYPE_CHECKING:  # for annotations only: at run time these would load numpy and CasADi before the help text
    from nospill.execution.executed import Executed
    from nospill.plans.plan import Plan


def report(
    folder: Annotated[Path, typer.Argument(metavar="DIR", help="A plan folder.")],
    output: Annotated[
        Path | None,
        typer.Option(
            "-o", "--output", metavar="FILE.html", help="Write here, not to DIR.report.html.", show_default=False
        ),
    ] = None,
    pdf: Annotated[
        Path | None, typer.Option("--pdf", metavar="FILE.pdf", help="Write a PDF too.", show_default=False)
    ] = None,
    verify: Annotated[bool, typer.Option("--verify", help="Simulate the objects in MuJoCo first.")] = False,
    executed: Annotated[
        Path | None,
        typer.Option("--executed", metavar="LOG", help="What was executed, as for that command.", show_default=False),
    ] = None,
    measured: Annotated[
        list[str] | None,
        typer.Option("--measured", metavar="CUP=FILE.csv", help="With --executed: see there.", show_default=False),
    ] = None,
    offset: Annotated[
        list[str] | None,
        typer.Option("--offset", metavar="JOINT=ANGLE", help="With --executed: see there.", show_default=False),
    ] = None,
    unit: Annotated[
        str, typer.Option("--unit", metavar="rad|deg", help="With --executed: of angles without a unit.")
    ] = "rad",
) -> int:
    """Write a plan as one self-contained HTML page: verdict, scenario, certificate, figures; with --pdf as PDF too."""
    page = report_place(folder, output)
    if pdf is not None:
        _require_outside(folder, pdf, ".pdf")
    with ProgressLine() as progress:
        from nospill.export.plan_files import compare_plan_files
        from nospill.plans.loading import load_plan
        from nospill.report import make_report, read_second_opinion, read_stopping_table, save_report

        plan = load_plan(folder)
        if verify:
            from nospill.report.second_opinion import second_opinion
            from nospill.verify import folder_joints
            from nospill.verify import verify as simulate

            progress.say("simulate")
            opinion = second_opinion(simulate(plan, joints=folder_joints(folder, plan)).to_dict())
        else:
            opinion = read_second_opinion(folder, plan.scene)
        progress.say("judge")
        compared = compare_plan_files(plan.trajectory, plan.scene, folder)
        run = None if executed is None else _judged_run(executed, folder, measured or (), offset or (), unit)
        stops = read_stopping_table(folder, plan)
        made = make_report(plan, opinion=opinion, controller_files=compared, executed=run, stops=stops)
        progress.say("draw")
        size = save_report(made, page, pdf=pdf)
    print(f"written to {page} ({size / 1e6:.1f} MB), {made.verdict}")
    if pdf is not None:
        print(f"written to {pdf}")
    return 0


def _judged_run(log: Path, folder: Path, measured: Sequence[str], offset: Sequence[str], unit: str) -> Executed:
    """A log of a plan, judged."""
    from nospill.execution.executed import executed
    from nospill.simulation.motion_file import read_heights

    recorded, scene, plan = read_run(log, folder, None, offset, unit, None, None)
    heights = {name: read_heights(text) for name, text in assigned("--measured", measured, "FILE.csv").items()}
    return executed(recorded, scene, plan=plan, measured=heights)


def report_place(folder: Path, output: Path | None = None) -> Path:
    """Where the page of a plan folder goes: the file named, or DIR.report.html beside the folder.

    Raises:
        ScenarioError: the file would lie in the plan folder, or has another ending. PlanFolderError: it cannot be
            written there.
    """
    if output is None:
        return sibling_file(folder, ".report.html")
    _require_outside(folder, output, ".html")
    return output


def write_plan_report(plan: Plan, folder: Path) -> Path:
    """Write the page of a plan that was just made and saved; its judgement is not made again."""
    from nospill.report import make_report, save_report

    page = report_place(folder)
    save_report(make_report(plan), page)
    return page


def _require_outside(folder: Path, file: Path, ending: str) -> None:
    if file.suffix.lower() != ending:
        raise ScenarioError(f"{file}: the name must end in {ending}")
    if folder.resolve() in file.resolve().parents:
        raise ScenarioError(f"{file}: a plan folder holds nothing but the plan; name a file outside of {folder}")
    require_writable(file)
