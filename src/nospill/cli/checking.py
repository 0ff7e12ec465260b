"""check: judge plan folders again; and how every command prints a certificate."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from nospill.cli.run_options import seconds
from nospill.cli.tables import print_lines, print_table, print_verdict, say

if TYPE_CHECKING:  # for annotations only: at run time these would load numpy and CasADi before the help text
    from nospill.certification.verdict import Certificate
    from nospill.plans.plan import Plan
    from nospill.plans.warnings.record import PlanWarning
    from nospill.scene.scene import Scene


def check(
    folders: Annotated[
        list[Path], typer.Argument(metavar="DIR...", help="Plan folders; several are motions in a row.")
    ],
    everything: Annotated[
        bool, typer.Option("--all", help="Print every row, the checks of the file included.")
    ] = False,
    wait: Annotated[str, typer.Option(metavar="TIME", help="Between one motion and the next.")] = "0 s",
) -> int:
    """Judge a plan folder again, from its trajectory and scenario alone, and compare its controller files with that.

    Of several, each begins with the swing that the one before it and the wait leave. Nothing is optimised or written.
    """
    from nospill.plans.loading import load_plan
    from nospill.plans.names import CYCLE_FILE

    good, before = True, None
    if len(folders) == 1 and (folders[0] / CYCLE_FILE).is_file():
        from nospill.cli.cycles import check_legs

        return check_legs(folders[0], printed=print_certificate if everything else None)
    for folder in folders:
        saved, fault = load_plan(folder), ""
        if before is not None:
            from nospill.plans.rows import judged_after

            saved, fault = judged_after(saved, before, seconds(wait))
        if len(folders) > 1:
            print_lines(f"{folder}:" if before is None else f"{folder}, {wait} after the one before:")
        good &= _check(saved, folder, everything=everything)
        if fault:
            say(f"Not certified in a row: {fault}.")
            good = False
        before = saved
    return 0 if good else 1


def _check(saved: Plan, folder: Path, *, everything: bool) -> bool:
    """Judge a plan, print what is found, and return whether all is well."""
    from nospill.certification.full_model import judged_in_full
    from nospill.certification.other_speeds import uses_at
    from nospill.certification.wording import finding
    from nospill.export.plan_files import compare_plan_files
    from nospill.plans.approach import judge_whole
    from nospill.plans.warnings import plan_warnings, slower_warnings

    judgement = judge_whole(saved)
    certificate = judgement.certificate
    print_certificate(certificate, saved.scene, everything=everything)
    certified = saved.scene.motion.speed_range if certificate.ok else None
    full = judged_in_full(judgement, saved.trajectory, saved.scene)
    slower = slower_warnings(saved.scene, judgement, full, uses_at(saved.trajectory, saved.scene), certified)
    print_warnings([*plan_warnings(saved.scene, judgement, saved.report.backoff, saved.report.fallbacks), *slower])
    compared = compare_plan_files(saved.trajectory, saved.scene, folder)
    for name, difference in compared.items():
        print_lines(f"{name} {difference or 'holds the motion of the trajectory'}")
    changed = [f"{folder / name} {difference}" for name, difference in compared.items() if difference]
    if not certificate.ok:
        say(f"Not certified: {finding(certificate)}.")
    elif changed:
        say(f"{changed[0]}; plan again before it goes to a robot.")
    good = certificate.ok and not changed
    print_verdict(certificate.word + (", but another file was changed" if changed else ""), good)
    return good


def print_certificate(certificate: Certificate, scene: Scene, *, everything: bool = False) -> None:
    """Print the verdict, then the fullest row of each constraint, the fullest first, or all rows, and the rims."""
    from nospill.certification.table import RIGHT, certificate_notes, certificate_table
    from nospill.certification.wording import verdict_line

    table = certificate_table(certificate, scene, everything=everything)
    drop = [name for name in ("with", "at", "value", "limit") if name in table.columns]
    print_verdict(verdict_line(certificate), certificate.ok)
    print()
    print_table(table.columns, table.cells, right=RIGHT, drop=drop, failing=table.failing)
    print_lines(*certificate_notes(certificate, scene, everything=everything))
    print()


def print_warnings(warnings: Sequence[PlanWarning]) -> None:
    """Print a line for each kind of warning, where the verdict stands."""
    from nospill.plans.warnings.record import warning_lines

    for line in warning_lines(warnings):
        print_lines(f"warning: {line}")
