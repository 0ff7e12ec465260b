"""plan, check, plot: from a scenario to a plan folder, and what can be done with one."""

from __future__ import annotations

import functools
import json
import time
from contextlib import nullcontext
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from nospill.cli.progress import Progress
from nospill.cli.reporting import one_line, only_stderr, print_json, print_table, say
from nospill.errors import NoSolutionError

if TYPE_CHECKING:  # for annotations only: at run time these would load numpy and CasADi before the help text
    from nospill.certificate import Certificate
    from nospill.plans import Plan


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
    with only_stderr() if as_json else nullcontext(), Progress() as progress:
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

            print_json(failed_summary(scene.name, one_line(outcome)))
        raise outcome
    if as_json:
        saved = output / "summary.json" if output is not None else None
        print_json(outcome.summary() if saved is None else json.loads(saved.read_text(encoding="utf-8")))
    else:
        _print_certificate(outcome.certificate)
        print(f"duration: {outcome.duration:.3f} s")
        print(f"written to {output}" if output is not None else "nothing written; -o DIR keeps the plan")
    if not outcome.certificate.ok:
        say(one_line(outcome.message))
    return 0 if outcome.certificate.ok else 1


def check(
    folder: Annotated[Path, typer.Argument(metavar="DIR", help="A plan folder.")],
) -> int:
    """Judge a plan folder again, from its trajectory and scenario alone, and compare its controller files with that.

    Nothing is optimised or written.
    """
    from nospill.certificate import certify
    from nospill.export.plan_files import compare_plan_files
    from nospill.plans import describe, load_plan

    saved = load_plan(folder)
    certificate = certify(saved.trajectory, saved.scene)
    _print_certificate(certificate)
    if not certificate.ok:
        say(f"Not certified: {describe(certificate.worst)}.")
    differences = compare_plan_files(saved.trajectory, saved.scene, folder)
    for name, difference in differences.items():
        if difference is None:
            print(f"{name}: holds the motion of the trajectory")
        else:
            say(f"{folder / name} {difference}; write the plan again before it goes to a robot.")
    return 0 if certificate.ok and not any(differences.values()) else 1


def plot(
    folder: Annotated[Path, typer.Argument(metavar="DIR", help="A plan folder.")],
) -> int:
    """Draw the figures of a plan folder again."""
    from nospill.files import atomic_folder
    from nospill.plans import load_plan
    from nospill.plots import save_figures

    saved = load_plan(folder)
    figures = folder / "figures"
    with Progress() as progress, atomic_folder(figures, replaceable=_only_figures) as partial:
        progress.say("draw")
        save_figures(saved, partial)
        names = sorted(path.name for path in partial.iterdir())
    for name in names:
        print(figures / name)
    return 0


def _write_figures(found: Plan, folder: Path) -> None:
    from nospill.plots import save_figures

    save_figures(found, folder / "figures")


def _only_figures(names: set[str]) -> bool:
    return all(name.endswith((".png", ".pdf")) for name in names)


def _print_certificate(certificate: Certificate) -> None:
    """Print the worst row of each constraint and the verdict."""
    from nospill.plans import shown_unit

    lines = []
    for row in certificate.worst_rows():
        factor, unit = shown_unit(row.unit, row.limit)
        figures = (factor * row.worst_value, factor * row.limit, factor * row.worst_margin)
        lines.append((row.constraint, row.subject, *figures, unit, row.at_s, "ok" if row.ok else "FAILS"))
    print_table(("constraint", "worst at", "value", "limit", "margin", "unit", "t / s", ""), lines)
    grid = f"on a grid of {certificate.grid_hz:g} Hz"
    failed = [row for row in certificate.rows if not row.ok]
    if certificate.ok:
        print(f"certified: all {len(certificate.rows)} rows hold {grid}")
    else:
        print(f"not certified: {len(failed)} of {len(certificate.rows)} rows fail {grid}")
