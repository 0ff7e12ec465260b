"""plan, check, plot: from a scenario to a plan folder, and what can be done with one."""

from __future__ import annotations

import functools
import json
import time
from contextlib import nullcontext
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from nospill.cli.progress import ProgressLine
from nospill.cli.reporting import one_line, only_stderr, print_json, print_table, say
from nospill.cli.sharing import write_plan_report
from nospill.errors import NoSolutionError, ScenarioError

if TYPE_CHECKING:  # for annotations only: at run time these would load numpy and CasADi before the help text
    from nospill.judge.verdict import Certificate
    from nospill.plans.plan import Plan


def plan(
    scenario: Annotated[str, typer.Argument(help="A scenario file (TOML) or the name of a bundled example.")],
    output: Annotated[
        Path | None,
        typer.Option("-o", "--output", metavar="DIR", help="Write the plan folder here.", show_default=False),
    ] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print summary.json on stdout and nothing else.")] = False,
    no_figures: Annotated[bool, typer.Option("--no-figures", help="Leave the figures out of the plan folder.")] = False,
    report: Annotated[bool, typer.Option("--report", help="Write DIR.report.html beside the plan folder.")] = False,
) -> int:
    """Plan a scenario and certify the motion; with -o, write its folder. Exit code 0 only if certified."""
    with only_stderr() if as_json else nullcontext(), ProgressLine() as progress:
        from nospill.core.files import require_replaceable
        from nospill.plans.names import SUMMARY_FILE, is_plan_folder
        from nospill.scenario import read_scenario

        if report and output is None:
            raise ScenarioError("--report is written beside the plan folder; name one with -o DIR")
        if output is not None:
            require_replaceable(output, replaceable=is_plan_folder)
        scene = read_scenario(scenario)
        for note in scene.robot.notes:
            say(f"{scene.robot.name}: {one_line(note)}")
        progress.say("load the optimiser")
        began = time.perf_counter()
        from nospill.planning.planner import plan as find_plan

        loading = time.perf_counter() - began
        outcome: Plan | NoSolutionError
        page: Path | None = None
        try:
            try:
                outcome = find_plan(scene, progress=progress.show).timed("import", loading)
            except ScenarioError as error:  # the arm cannot follow the path: the file is named as where it is read
                raise ScenarioError(f"{scenario}: {error}", error.reason) from error
            if output is not None:
                progress.say("write")
                figures = None if no_figures else functools.partial(_write_figures, outcome)
                outcome.save(output, extra=figures, time_writing=True)
                page = write_plan_report(outcome, output) if report else None
        except NoSolutionError as error:
            outcome = error
    if isinstance(outcome, NoSolutionError):
        if as_json:
            from nospill.plans.plan import failed_summary

            print_json(failed_summary(scene.name, one_line(outcome)))
        raise NoSolutionError(f"{scenario}: {outcome}", outcome.reason)
    if as_json:
        saved = output / SUMMARY_FILE if output is not None else None
        print_json(outcome.summary() if saved is None else json.loads(saved.read_text(encoding="utf-8")))
    else:
        _print_certificate(outcome.certificate)
        print(f"duration: {outcome.duration:.3f} s")
        for line in _choices(outcome):
            print(line)
        print(f"written to {output}" if output is not None else "nothing written; -o DIR keeps the plan")
        if page is not None:
            print(f"written to {page}")
    if not outcome.certificate.ok:
        say(one_line(outcome.message))
    return 0 if outcome.certificate.ok else 1


def check(
    folder: Annotated[Path, typer.Argument(metavar="DIR", help="A plan folder.")],
) -> int:
    """Judge a plan folder again, from its trajectory and scenario alone, and compare its controller files with that.

    Nothing is optimised or written.
    """
    from nospill.export.plan_files import compare_plan_files
    from nospill.judge.wording import describe
    from nospill.plans.approach import certify_whole
    from nospill.plans.loading import load_plan

    saved = load_plan(folder)
    certificate = certify_whole(saved)
    _print_certificate(certificate)
    compared = compare_plan_files(saved.trajectory, saved.scene, folder)
    for name, difference in compared.items():
        print(f"{name} {difference or 'holds the motion of the trajectory'}")
    changed = [f"{folder / name} {difference}" for name, difference in compared.items() if difference]
    if not certificate.ok:
        say(f"Not certified: {describe(certificate.worst)}.")
    elif changed:
        say(f"{changed[0]}; plan again before it goes to a robot.")
    return 0 if certificate.ok and not changed else 1


def plot(
    folder: Annotated[Path, typer.Argument(metavar="DIR", help="A plan folder.")],
) -> int:
    """Draw the figures of a plan folder again."""
    from nospill.core.files import atomic_folder
    from nospill.plans.loading import load_plan
    from nospill.plots import save_figures

    saved = load_plan(folder)
    figures = folder / "figures"
    with ProgressLine() as progress, atomic_folder(figures, replaceable=_only_figures) as partial:
        progress.say("draw")
        save_figures(saved, partial)
        names = sorted(path.name for path in partial.iterdir())
    for name in names:
        print(figures / name)
    return 0


def _choices(found: Plan) -> list[str]:
    """What was chosen for the arm, and how it gets to the start, a line each."""
    from nospill.plans.approach import settling_time

    lines = [f"branch: {found.report.branch}"]
    if found.report.base_yaw is not None:
        lines.append(f"base yaw: {found.report.base_yaw} (left free)")
    rules = found.scene.motion
    if rules.hold_before or rules.hold_after:
        lines.append(f"holds: {rules.hold_before:g} s before and {rules.hold_after:g} s after, in exported files")
    segment = found.approach
    if segment is not None:
        tray = "loaded" if segment.loaded else "empty"
        slowed = "" if segment.stretch == 1.0 else f", {segment.stretch:g} times as slowly as its limits allow"
        lines.append(
            f"approach: {segment.duration:.3f} s with the tray {tray}{slowed}; "
            "nothing checks for collisions, here or on the way after it"
        )
        wait = settling_time(found)
        if wait > 0.0:
            lines.append(f"approach: the liquids swing on; wait {wait:.1f} s before the motion, which starts from rest")
    return lines


def _write_figures(found: Plan, folder: Path) -> None:
    from nospill.plots import save_figures

    save_figures(found, folder / "figures")


def _only_figures(names: set[str]) -> bool:
    return all(name.endswith((".png", ".pdf")) for name in names)


def _print_certificate(certificate: Certificate) -> None:
    """Print the worst row of each constraint and the verdict."""
    from nospill.judge.wording import full_model_note, shown_unit

    lines = []
    for row in certificate.worst_rows():
        factor, unit = shown_unit(row.unit, row.limit)
        figures = (factor * row.worst_value, factor * row.limit, factor * row.worst_margin)
        lines.append((row.constraint, row.label, *figures, unit, row.at_s, "ok" if row.ok else "FAILS"))
    print_table(("constraint", "worst at", "value", "limit", "margin", "unit", "t / s", ""), lines)
    grid = f"on a grid of {certificate.grid_hz:g} Hz"
    failed = [row for row in certificate.rows if not row.ok]
    if certificate.ok:
        print(f"{certificate.word}: all {len(certificate.rows)} rows hold {grid}")
    else:
        print(f"not certified: {len(failed)} of {len(certificate.rows)} rows fail {grid}")
    note = full_model_note(certificate)
    if note:
        say(f"warning: {note}.")
