"""executed: a joint log judged as a plan is, beside the plan it is of."""

from __future__ import annotations

import json
from collections.abc import Sequence
from contextlib import nullcontext
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from nospill.cli.reporting import only_stderr, print_json
from nospill.cli.tables import print_lines, print_table, print_verdict, say

if TYPE_CHECKING:  # for annotations only: at run time these would load numpy and CasADi before the help text
    from nospill.execution.executed import Executed
    from nospill.execution.log import JointLog
    from nospill.plans.plan import Plan
    from nospill.scene.scene import Scene

_FILES = {"executed.json", "heights.png", "heights.pdf"}


def executed(
    log: Annotated[
        Path, typer.Argument(metavar="LOG", help="What the arm did: CSV of joint positions, RTDE recording, ROS bag.")
    ],
    plan: Annotated[
        Path | None, typer.Option("--plan", metavar="DIR", help="The plan that was executed.", show_default=False)
    ] = None,
    scenario: Annotated[
        str | None,
        typer.Option(
            "--scenario",
            metavar="SCENARIO",
            help="Without a plan: what the motion must keep to, a file or an example.",
            show_default=False,
        ),
    ] = None,
    measured: Annotated[
        list[str] | None,
        typer.Option(
            "--measured",
            metavar="CUP=FILE.csv",
            help="A measured height of a cup (t_s, height_mm); may be repeated.",
            show_default=False,
        ),
    ] = None,
    offset: Annotated[
        list[str] | None,
        typer.Option(
            "--offset",
            metavar="JOINT=ANGLE",
            help='Added to a joint that the log counts from another zero, as joint_6="180 deg"; may be repeated.',
            show_default=False,
        ),
    ] = None,
    unit: Annotated[
        str, typer.Option("--unit", metavar="rad|deg", help="Of angles whose columns do not name it.")
    ] = "rad",
    rate: Annotated[
        float | None,
        typer.Option("--rate", metavar="HZ", help="Rows a second, of a log without times.", show_default="500"),
    ] = None,
    output: Annotated[
        Path | None,
        typer.Option("-o", "--output", metavar="FOLDER", help="Write figure and record here.", show_default=False),
    ] = None,
    everything: Annotated[bool, typer.Option("--all", help="Print every row.")] = False,
    as_json: Annotated[bool, typer.Option("--json", help="Print the record as JSON and nothing else.")] = False,
) -> int:
    """Judge a joint log as a plan is judged, with the band that its noise leaves; exit code 1 if a row fails."""
    from nospill.core.files import atomic_folder, require_replaceable
    from nospill.execution.executed import executed as judged
    from nospill.execution.record import executed_table
    from nospill.simulation.motion_file import read_heights

    if output is not None:
        require_replaceable(output, replaceable=_only_ours)
    with only_stderr() if as_json else nullcontext():
        recorded, scene, planned = read_run(log, plan, scenario, offset or (), unit, rate)
        files = assigned("--measured", measured or (), "FILE.csv")
        heights = {name: read_heights(text) for name, text in files.items()}
        found = judged(recorded, scene, plan=planned, measured=heights)
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
        print_verdict(f"executed: {found.judgement.certificate.word}", found.ok)
    if not found.ok:
        from nospill.judge.wording import describe

        say(f"Not certified as executed: {describe(found.judgement.certificate.worst)}.")
    return 0 if found.ok else 1


def read_run(
    log: Path, plan: Path | None, scenario: str | None, offset: Sequence[str], unit: str, rate: float | None
) -> tuple[JointLog, Scene, Plan | None]:
    """A log with the scene that it is judged by, and its plan if there is one.

    Raises:
        ScenarioError: neither plan nor scenario or both, an offset or a log that cannot be read.
        PlanFolderError: no plan in the folder.
    """
    from nospill.core.units import quantity
    from nospill.errors import ScenarioError
    from nospill.execution.reading import read_log
    from nospill.plans.loading import load_plan
    from nospill.scenario import read_scenario

    if (plan is None) == (scenario is None):
        raise ScenarioError("give either --plan DIR or --scenario SCENARIO: what the log is judged by")
    offsets = {name: quantity(text, "angle") for name, text in assigned("--offset", offset, '"180 deg"').items()}
    planned = None if plan is None else load_plan(plan)
    scene = read_scenario(str(scenario)) if planned is None else planned.scene
    return read_log(log, scene.robot, offsets=offsets, rate=rate, unit=unit), scene, planned


def assigned(option: str, given: Sequence[str], example: str) -> dict[str, str]:
    """Values given as NAME=VALUE, by name.

    Raises:
        ScenarioError: an entry without a name or a value, or a name that is given twice.
    """
    from nospill.errors import ScenarioError

    found: dict[str, str] = {}
    for entry in given:
        name, sign, value = entry.partition("=")
        if not (name and sign and value) or name in found:
            raise ScenarioError(f"{option} {entry}: one NAME={example} for each name is needed")
        found[name] = value
    return found


def _text(table: dict[str, Any]) -> str:
    return json.dumps(table, indent=2, allow_nan=False) + "\n"


def _only_ours(names: set[str]) -> bool:
    return names <= _FILES


def _print(found: Executed, *, everything: bool) -> None:
    from nospill.execution.record import log_lines, tracking_lines, undecided
    from nospill.judge.wording import verdict_line

    certificate = found.judgement.certificate
    print_verdict(f"executed: {verdict_line(certificate)}", found.ok)
    if found.planned is not None:
        print_verdict(f"planned: {verdict_line(found.planned.certificate)}", found.planned.certificate.ok)
    print()
    _print_rows(found, everything=everything)
    print()
    print_lines(*log_lines(found), *tracking_lines(found))
    left_open = undecided(found)
    if left_open:
        names = ", ".join(f"{row.constraint} of {row.subject}" for row in left_open)
        print_lines(f"the noise of the log leaves open: {names}")
    print()
    if found.heights:
        _print_heights(found)
        print()


def _print_rows(found: Executed, *, everything: bool) -> None:
    """The fullest row of every constraint, or every row, as executed and as planned."""
    from nospill.execution.record import use_band
    from nospill.judge.wording import percent, row_text

    certificate = found.judgement.certificate
    rows = certificate.rows if everything else certificate.listed_rows()
    planned = {} if found.planned is None else {(r.constraint, r.subject): r for r in found.planned.certificate.rows}
    cells = []
    for row in rows:
        text, band = row_text(row), use_band(found, row)
        before = planned.get((row.constraint, row.subject))
        cells.append(
            [
                row.constraint,
                row.subject,
                *([] if found.planned is None else ["-" if before is None else percent(before.use, before.ok)]),
                text.use,
                "-" if band is None else f"± {100 * band:.2g} %",
                "" if row.ok else "FAILS",
                text.value,
                text.limit_and_unit,
                f"{row.at_s:.3f} s",
            ]
        )
    columns = ["constraint", "of", *(["planned"] if found.planned else []), "executed", "noise", "", "value", "limit"]
    failing = {index for index, row in enumerate(rows) if not row.ok}
    right = ("planned", "executed", "noise", "value", "limit", "at")
    print_table([*columns, "at"], cells, right=right, drop=("at", "limit", "value"), failing=failing)


def _print_heights(found: Executed) -> None:
    """Peaks of the liquids: planned, executed, measured, and which joint added most."""
    from nospill.laws.constraints.slosh_height import SloshHeight

    peaks = {peak.subject: peak for peak in found.peaks if peak.constraint == SloshHeight.name}
    cells = []
    for name, values in found.heights.items():
        peak, own = peaks.get(name), found.measured.get(name)
        at = int(values.argmax())
        line: list[object] = [name, f"{1e3 * values[at]:.2f} ± {1e3 * found.height_bands[name][at]:.2g}"]
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
