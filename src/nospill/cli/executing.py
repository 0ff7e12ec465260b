"""executed: a joint log judged as a plan is, compared with the plan it is of."""

from __future__ import annotations

import json
from contextlib import nullcontext
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from nospill.cli.reporting import only_stderr, print_json
from nospill.cli.run_options import (
    Log,
    Measured,
    Offset,
    PlanFolder,
    Rate,
    ScenarioName,
    Topic,
    Unit,
    assigned,
    read_run,
)
from nospill.cli.tables import print_lines, print_table, print_verdict, say

if TYPE_CHECKING:  # for annotations only: at run time these would load numpy and CasADi before the help text
    from nospill.execution.executed import Executed

_FILES = {"executed.json", "heights.png", "heights.pdf"}


def executed(
    log: Log,
    plan: PlanFolder = None,
    scenario: ScenarioName = None,
    measured: Measured = None,
    offset: Offset = None,
    unit: Unit = "rad",
    rate: Rate = None,
    topic: Topic = None,
    bandwidth: Annotated[
        float,
        typer.Option("--bandwidth", metavar="HZ", help="Motion that is followed; what is faster counts as noise."),
    ] = 50.0,
    output: Annotated[
        Path | None,
        typer.Option("-o", "--output", metavar="FOLDER", help="Write figure and record here.", show_default=False),
    ] = None,
    everything: Annotated[bool, typer.Option("--all", help="Print every row.")] = False,
    as_json: Annotated[bool, typer.Option("--json", help="Print the record as JSON and nothing else.")] = False,
) -> int:
    """Judge a joint log as a plan is judged, with the band that its noise leaves.

    Exit code 1 if a row fails beyond what noise and smoothing leave open.
    """
    from nospill.core.files import atomic_folder, require_replaceable
    from nospill.execution.bands import NOT_CERTIFIED
    from nospill.execution.executed import executed as judged
    from nospill.execution.record import executed_table
    from nospill.simulation.motion_file import read_heights

    if output is not None:
        require_replaceable(output, replaceable=_only_ours)
    with only_stderr() if as_json else nullcontext():
        recorded, scene, planned = read_run(log, plan, scenario, offset or (), unit, rate, topic)
        files = assigned("--measured", measured or (), "FILE.csv")
        heights = {name: read_heights(text) for name, text in files.items()}
        found = judged(recorded, scene, plan=planned, measured=heights, bandwidth=bandwidth)
        table = executed_table(found)
        if output is not None:
            from nospill.plots.executed import save_executed

            with atomic_folder(output, replaceable=_only_ours) as partial:
                (partial / "executed.json").write_text(_text(table), encoding="utf-8")
                if found.heights:
                    save_executed(found, partial / "heights.png")
    if as_json:
        print_json(table)
    else:
        _print(found, everything=everything)
        if output is not None:
            print(f"written to {output}")
        print_verdict(f"executed: {found.word}", found.outcome != NOT_CERTIFIED)
    if found.outcome == NOT_CERTIFIED:
        say(f"Not certified as executed: {_finding(found)}.")
    return 1 if found.outcome == NOT_CERTIFIED else 0


def _finding(found: Executed) -> str:
    """The row that fails most, of what is on the tray if one does, or a limit that nobody could judge."""
    from nospill.certification.wording import describe, finding
    from nospill.execution.record import failing

    rows = failing(found)
    return describe(rows[0]) if rows else finding(found.judgement.certificate)


def _text(table: dict[str, Any]) -> str:
    return json.dumps(table, indent=2, allow_nan=False) + "\n"


def _only_ours(names: set[str]) -> bool:
    return names <= _FILES


def _print(run: Executed, *, everything: bool) -> None:
    from nospill.certification.happening import happening_line
    from nospill.certification.wording import verdict_line
    from nospill.execution.bands import NOT_CERTIFIED
    from nospill.execution.record import log_lines, open_line, tracking_lines, verdict

    print_verdict(f"executed: {verdict(run)}", run.outcome != NOT_CERTIFIED)
    if run.planned is not None:
        print_verdict(f"planned: {verdict_line(run.planned.certificate)}", run.planned.certificate.ok)
    print_lines(happening_line(run.without_reserve))
    print()
    _print_rows(run, everything=everything)
    print()
    print_lines(*log_lines(run), *tracking_lines(run))
    left_open = open_line(run)
    if left_open:
        print_lines(left_open)
    print()
    if run.heights:
        _print_heights(run)
        print()


def _print_rows(found: Executed, *, everything: bool) -> None:
    """The fullest row of every constraint, or every row, as executed and as planned; those about the tray first."""
    from nospill.certification.happening import tray_first
    from nospill.certification.wording import percent, row_text
    from nospill.execution.bands import NOT_CERTIFIED
    from nospill.execution.record import band_text, mark

    certificate = found.judgement.certificate
    rows = tray_first(certificate.rows if everything else certificate.listed_rows())
    planned = {} if found.planned is None else {row.id: row for row in found.planned.certificate.rows}
    cells = []
    for row in rows:
        text = row_text(row)
        before = planned.get(row.id)
        cells.append(
            [
                row.constraint,
                row.subject,
                *([] if found.planned is None else ["-" if before is None else percent(before.use, before.ok)]),
                text.use,
                band_text(found, row),
                mark(found, row),
                text.value,
                text.limit_and_unit,
                text.at_with_unit,
            ]
        )
    columns = ["constraint", "of", *(["planned"] if found.planned else []), "executed", "noise", "", "value", "limit"]
    failing = {index for index, row in enumerate(rows) if found.outcomes[row.id] == NOT_CERTIFIED}
    right = ("planned", "executed", "noise", "value", "limit", "at")
    print_table([*columns, "at"], cells, right=right, drop=("at", "limit", "value"), failing=failing)


def _print_heights(found: Executed) -> None:
    """Peaks of the liquids: planned, executed, measured, and which joint added most."""
    from nospill.execution.record import height_text
    from nospill.laws.constraints.slosh_height import SloshHeight

    peaks = {peak.subject: peak for peak in found.peaks if peak.constraint == SloshHeight.name}
    cells = []
    for name, values in found.heights.items():
        peak, own = peaks.get(name), found.measured.get(name)
        at = int(values.argmax())
        line: list[object] = [name, height_text(float(values[at]), float(found.height_bands[name][at]))]
        if peak is not None:
            line.insert(1, f"{1e3 * peak.planned:.2f}")
            most = sorted(peak.by_joint.items(), key=lambda item: -abs(item[1]))[:2]
            line.append(", ".join(f"{joint} {1e3 * value:+.2g} mm" for joint, value in most))
        if found.measured:
            line += ["-", "-"] if own is None else [f"{1e3 * own.measured_peak:.2f}", f"{own.correlation:.3f}"]
        cells.append(line)
    columns = ["peak of", *(["planned mm"] if peaks else []), "executed mm", *(["added by"] if peaks else [])]
    columns += ["measured mm", "correlation"] if found.measured else []
    print_table(columns, cells, right=("planned mm", "executed mm", "measured mm", "correlation"))
