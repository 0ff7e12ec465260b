"""judge: a motion that somebody planned, as the arm plays it, judged as a plan is."""

from __future__ import annotations

import json
from contextlib import nullcontext
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from nospill.cli.checking import check, print_certificate
from nospill.cli.reporting import only_stderr, print_json
from nospill.cli.run_options import Unit
from nospill.cli.tables import print_lines, print_verdict, say
from nospill.cli.viewing import AFTER_END

if TYPE_CHECKING:  # for annotations only: at run time these would load numpy and CasADi before the help text
    from nospill.motion_files.judging import JudgedMotion

_VERDICT, _FIGURES, _PAGE = "verdict.json", "figures", "motion.html"


def judge(
    motion: Annotated[
        Path,
        typer.Argument(
            metavar="MOTION", help="JointTrajectory as YAML, JSON or ROS bag; arrays as .npz; CSV; or a plan folder."
        ),
    ],
    scenario: Annotated[
        str | None,
        typer.Option("--scenario", metavar="SCENARIO", help="What it must keep to: a file, an example, a plan folder."),
    ] = None,
    receiver: Annotated[
        str | None,
        typer.Option(
            "--as",
            metavar="RECEIVER",
            help="Who plays the points: jtc, linear, cubic, quintic, servoj or fci.",
            show_default="by its columns",
        ),
    ] = None,
    unit: Unit = "rad",
    rate: Annotated[
        float | None, typer.Option("--rate", metavar="HZ", help="Rows a second, of a table without times.")
    ] = None,
    output: Annotated[
        Path | None,
        typer.Option("-o", "--output", metavar="FOLDER", help="Write verdict, figures and a page to watch it here."),
    ] = None,
    everything: Annotated[bool, typer.Option("--all", help="Print every row.")] = False,
    as_json: Annotated[bool, typer.Option("--json", help="Print the verdict as JSON and nothing else.")] = False,
) -> int:
    """Judge a motion of any origin before it runs: limits of the arm, spilling, sliding, tipping, clearances.

    Points are taken as they are, and played as their receiver plays them. Exit code 0 only if every row holds. What an
    arm did is judged by executed, which knows noise.
    """
    from nospill.core.files import require_replaceable
    from nospill.errors import ScenarioError
    from nospill.motion_files.judging import judge as judge_motion
    from nospill.plans.names import is_plan_folder
    from nospill.scenario import load

    if motion.is_dir() and is_plan_folder({item.name for item in motion.iterdir()}):
        if scenario is not None or receiver is not None or output is not None:
            raise ScenarioError(
                f"{motion}: is a plan folder, judged by its own scenario; leave --scenario, --as and -o out"
            )
        return check([motion], everything=everything)
    if scenario is None:
        raise ScenarioError("--scenario SCENARIO is needed: what the motion must keep to")
    if output is not None:
        require_replaceable(output, replaceable=_only_ours)
    with only_stderr() if as_json else nullcontext():
        judged = judge_motion(motion, load(scenario), receiver=receiver, unit=unit, rows_per_second=rate)
        if output is not None:
            _write(judged, output)
    if as_json:
        print_json(_table(judged))
    else:
        _print(judged, everything=everything)
        if output is not None:
            print(f"written to {output}")
    return 0 if judged.certificate.ok else 1


def _table(judged: JudgedMotion) -> dict[str, Any]:
    from nospill.motion_files.judging import NOT_JUDGED

    certificate = judged.certificate
    return {
        "scenario": judged.scene.name,
        "motion": judged.file.origin,
        "read": judged.file.read,
        "played_as": judged.played.name,
        "through_controller": judged.scene.controller is not None,
        "not_judged": NOT_JUDGED,
        "ok": certificate.ok,
        "failures": judged.failures(),
        "certificate": certificate.to_dict(),
    }


def _only_ours(names: set[str]) -> bool:
    return names <= {_VERDICT, _FIGURES, _PAGE}


def _write(judged: JudgedMotion, folder: Path) -> None:
    """The verdict as JSON, the figures, and the page of the viewer where its library is installed."""
    from nospill.core.files import atomic_folder
    from nospill.drawing.timeline import make_film
    from nospill.errors import MissingExtraError
    from nospill.plots import save_figures
    from nospill.viewer.html import HTML_RATE, save_html
    from nospill.viewer.library import require_viser

    with atomic_folder(folder, replaceable=_only_ours) as partial:
        (partial / _VERDICT).write_text(json.dumps(_table(judged), indent=2, allow_nan=False) + "\n", encoding="utf-8")
        save_figures(judged.plan, partial / _FIGURES)
        try:
            require_viser()
        except MissingExtraError as error:
            say(f"no page to watch it: {error}")
            return
        length = judged.plan.duration + AFTER_END
        save_html([make_film(judged.plan, judged.judgement, rate=HTML_RATE, length=length)], partial / _PAGE)


def _print(judged: JudgedMotion, *, everything: bool) -> None:
    from nospill.certification.wording import finding
    from nospill.motion_files.judging import NOT_JUDGED

    print_lines(f"read: {judged.file.read}", judged.played_text)
    print_certificate(judged.certificate, judged.scene, everything=everything)
    print_lines(f"not judged: {NOT_JUDGED}")
    for failure in judged.failures():
        print_lines(
            f"{failure['code']} of {failure['subject']}: first at t = {failure['first_s']:.3f} s, "
            f"after point {failure['point']}"
        )
    if not judged.certificate.ok:
        say(f"Not certified: {finding(judged.certificate)}.")
    print_verdict(f"{judged.file.origin}: {judged.certificate.word}", judged.certificate.ok)
