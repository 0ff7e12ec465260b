"""verify --water: the liquids of a plan by their nonlinear flow."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING

from nospill.cli.reporting import print_json, sibling_file
from nospill.cli.tables import print_lines, print_table, print_verdict, say

if TYPE_CHECKING:  # for annotations only: at run time this would load numpy and CasADi before the help text
    from nospill.cli.progress import ProgressLine
    from nospill.verify.water import WaterReport


def follow_water(folder: Path, *, save: bool, progress: ProgressLine) -> tuple[WaterReport, list[Path]]:
    """Follow the liquids of a plan folder, and write record and picture beside it where asked to."""
    from nospill.core.files import atomic_text
    from nospill.plans.loading import load_plan
    from nospill.verify import folder_joints, verify_water

    plan = load_plan(folder)
    progress.say("follow the water")
    report = verify_water(plan, joints=folder_joints(folder, plan))
    if not save:
        return report, []
    written = [sibling_file(folder, ".water.json")]
    atomic_text(written[0], json.dumps(report.to_dict(), indent=2, allow_nan=False) + "\n")
    if report.cups:
        from nospill.plots.water import save_water

        written.append(sibling_file(folder, ".water.png"))
        save_water(report, written[1])
    return report, written


def print_water(report: WaterReport, written: list[Path], *, as_json: bool) -> int:
    """Print what the liquids do; exit code 1 where one does not keep its limits."""
    if as_json:
        print_json(report.to_dict())
    else:
        _print_table(report, written)
    if not report.ok or report.left_out:
        say(report.message)
    return 0 if report.ok else 1


def _print_table(report: WaterReport, written: list[Path]) -> None:
    print_verdict(report.verdict, report.ok)
    print()
    names = ("liquid", "limit mm", "certified", "second order", "full", "at s")
    left = ("after: limit", "linear", "second", "full after")
    rows = []
    for cup in report.cups:
        crests = [1e3 * peak.value for peak in (cup.certified, cup.second, cup.full)]
        after = [None if value is None else 1e3 * value for value in (cup.residual_limit, *cup.residual)]
        verdict_of = "keeps" if cup.ok else "IN DOUBT" if cup.crests.doubt else "OVER"
        rows.append((cup.name, 1e3 * cup.limit, *crests, cup.full.at_s, *after, verdict_of))
    print_table(
        (*names, *left, "verdict"),
        rows,
        drop=("at s", "linear", "second"),
        failing={index for index, cup in enumerate(report.cups) if not cup.ok},
    )
    print()
    print_lines(
        f"joints from {report.source}; heights in mm, after: what is left after the end; numbers of the objects as "
        "stated, at the planned speed: tolerances and speed_range are not followed"
    )
    for path in written:
        print(f"written to {path}")
    print_verdict(report.verdict, report.ok)
