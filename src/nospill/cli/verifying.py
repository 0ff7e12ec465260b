"""verify, margins: a plan against another physics engine, and against numbers that are off."""

from __future__ import annotations

import json
from contextlib import nullcontext
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from nospill.cli.progress import Progress
from nospill.cli.reporting import only_stderr, print_json, print_table, say

if TYPE_CHECKING:  # for annotations only: at run time these would load numpy and CasADi before the help text
    from nospill.verify import VerifyReport


def verify(
    folder: Annotated[Path, typer.Argument(metavar="DIR", help="A plan folder.")],
    distance: Annotated[
        str, typer.Option("--distance", metavar="LENGTH", help="Slide or lift-off from which on an object has moved.")
    ] = "0.5 mm",
    angle: Annotated[
        str, typer.Option("--angle", metavar="ANGLE", help="Rotation or tilt from which on an object has moved.")
    ] = "0.5 deg",
    as_json: Annotated[bool, typer.Option("--json", help="Print the report as JSON and nothing else.")] = False,
    save: Annotated[
        bool, typer.Option("--save", help="Write the report beside the folder, as DIR.verify.json.")
    ] = False,
    video: Annotated[
        Path | None,
        typer.Option("--video", metavar="FILE", help="Film the simulation (.mp4 or .gif).", show_default=False),
    ] = None,
) -> int:
    """Simulate a plan's objects and liquids in MuJoCo, driven by the joint file; exit code 1 if one moves."""
    with only_stderr() if as_json else nullcontext(), Progress() as progress:
        from nospill.files import atomic_text
        from nospill.plans import load_plan
        from nospill.units import quantity
        from nospill.verify import Thresholds, folder_joints
        from nospill.verify import verify as simulate

        thresholds = Thresholds(quantity(distance, "length"), quantity(angle, "angle"))
        if video is not None:
            from nospill.verify.video import require_film

            require_film(video)
        plan = load_plan(folder)
        joints = folder_joints(folder, plan)
        progress.say("simulate")
        report = simulate(plan, thresholds=thresholds, joints=joints)
        record = folder.resolve().with_name(f"{folder.resolve().name}.verify.json")
        if save:
            atomic_text(record, json.dumps(report.to_dict(), indent=2, allow_nan=False) + "\n")
        if video is not None:
            from nospill.verify.video import write_film

            progress.say("film")
            write_film(plan, joints, video)
    if as_json:
        print_json(report.to_dict())
    else:
        _print_verification(report)
        if save:
            print(f"written to {record}")
        if video is not None:
            print(f"filmed to {video}")
    if not report.ok:
        say(report.message)
    return 0 if report.ok else 1


def _print_verification(report: VerifyReport) -> None:
    """Print the figures of every object and the verdict."""
    found = report.to_dict()
    keys = ("name", "slide_mm", "slide_at_s", "rotation_deg", "tilt_deg", "lift_off_mm", "moved_at_s")
    columns = ("object", "slide mm", "at s", "rotation deg", "tilt deg", "lift-off mm", "moves from s")
    print_table(
        (*columns, ""), [(*(item[key] for key in keys), "ok" if item["ok"] else "MOVES") for item in found["objects"]]
    )
    print(f"joints from {report.source}; {report.engine}, {report.simulated:.2f} s simulated")
    still = "every object stays" if report.ok else "not every object stays"
    print(f"{still} within {found['threshold_mm']:g} mm and {found['threshold_deg']:g} deg")
