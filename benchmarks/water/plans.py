"""Certified plans against the nonlinear flow of their liquids: crests and what is left after the end, as a table.

    python -m benchmarks.water.plans out/*          # plan folders; nothing is planned

For each liquid the limit, the highest crest in the certificate, linear with all modes, to the second order and of the
full flow, then the limit after the end and the same heights there; with a star where the flow is in doubt, and a dash
where it breaks down before. Heights in mm.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np

from nospill.errors import NospillError
from nospill.plans.loading import load_plan
from nospill.verify import CupReport, WaterReport, folder_joints, verify_water

HEAD = (
    "| plan | liquid | limit | certified | linear | second | full | after: limit | linear | second | full |",
    "|---|---|---|---|---|---|---|---|---|---|---|",
)


def main(folders: Sequence[str]) -> None:
    """Print the table, the plans' worst excesses and the time."""
    print(*HEAD, sep="\n")
    cups: list[CupReport] = []
    begun = time.process_time()
    for folder in map(Path, folders):
        try:
            report = _followed(folder)
        except NospillError as error:
            print(f"{folder}: {error}", file=sys.stderr)
            continue
        cups += report.cups
        print(*_lines(folder, report), sep="\n", flush=True)
    print()
    print(*summary(cups), sep="\n")
    if cups:
        print(f"{(time.process_time() - begun) / len(cups):.1f} s of processor time for each liquid, judging included.")


def _followed(folder: Path) -> WaterReport:
    plan = load_plan(folder)
    return verify_water(plan, joints=folder_joints(folder, plan))


def _lines(folder: Path, report: WaterReport) -> Iterator[str]:
    for cup in report.cups:
        star = "*" if cup.crests.doubt else ""
        crests = [1e3 * peak.value for peak in (cup.certified, cup.linear, cup.second, cup.full)]
        left = [None if value is None else 1e3 * value for value in (cup.residual_limit, *cup.residual)]
        cells = [f"{1e3 * cup.limit:.3g}", *(f"{value:.1f}" for value in crests)]
        cells += ["-" if value is None else f"{value:.1f}" for value in left]
        print(f"{folder}: {cup.sentence}", file=sys.stderr)
        yield f"| {folder.name} | {cup.name} | " + " | ".join(cells) + star + " |"
    for name, reason in report.left_out:
        yield f"| {folder.name} | {name} | not followed: {reason} |" + " |" * 8


def summary(cups: Sequence[CupReport]) -> Iterator[str]:
    """Excess over the limits by how high these are over the radius or half side, of flows that are trusted."""
    trusted = [cup for cup in cups if not cup.crests.doubt]
    yield f"{len(trusted)} of {len(cups)} flows are trusted."
    excess = np.array([cup.full.value / cup.limit - 1 for cup in trusted])
    left = [(cup.residual[2] or 0.0) / cup.residual_limit - 1 for cup in trusted if cup.residual_limit]
    for name, values in (("highest crest", excess), ("height after the end", np.array(left))):
        if len(values):
            low, middle, high = 1e2 * np.percentile(values, [0, 50, 100])
            yield f"{name} over its limit: {low:+.0f} to {high:+.0f} %, median {middle:+.0f} %."


if __name__ == "__main__":
    main(sys.argv[1:])
