"""export: from a plan folder to a file for a controller, judged as that controller will play it."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from nospill.cli.reporting import sibling_file
from nospill.cli.tables import print_table, print_verdict, say
from nospill.errors import ScenarioError

if TYPE_CHECKING:  # for annotations only: at run time these would load numpy and CasADi before the help text
    from nospill.export import Exporter
    from nospill.plans.handover import Handover
    from nospill.plans.plan import Plan


def export(
    folder: Annotated[Path | None, typer.Argument(metavar="DIR", help="A plan folder.", show_default=False)] = None,
    format_name: Annotated[
        str | None, typer.Option("--format", metavar="NAME", help="One of the formats of --list.", show_default=False)
    ] = None,
    output: Annotated[
        Path | None,
        typer.Option("-o", "--output", metavar="FILE", help="Write here, not next to the plan.", show_default=False),
    ] = None,
    rate: Annotated[
        float | None,
        typer.Option(metavar="HZ", help="Samples per second; the plan's when left out.", show_default=False),
    ] = None,
    frame: Annotated[
        str | None,
        typer.Option(metavar="NAME", help="Of poses: world (default), base_link or base.", show_default=False),
    ] = None,
    profile: Annotated[
        str | None,
        typer.Option(metavar="NAME", help="Of csv: who reads it, franka, servoj, rsi-4ms ...", show_default=False),
    ] = None,
    form: Annotated[
        str | None,
        typer.Option(metavar="NAME", help="Of urscript: socket (default) or script-node.", show_default=False),
    ] = None,
    gain: Annotated[
        float | None, typer.Option(metavar="NUMBER", help="Of servoj: 100 to 2000 (300).", show_default=False)
    ] = None,
    lookahead: Annotated[
        float | None, typer.Option(metavar="S", help="Of servoj: 0.03 to 0.2 s (0.03).", show_default=False)
    ] = None,
    prefix: Annotated[
        str | None, typer.Option(metavar="TEXT", help="Of ROS: before every joint's name.", show_default=False)
    ] = None,
    topic: Annotated[
        str | None, typer.Option(metavar="NAME", help="Of ROS: the controller's topic or action.", show_default=False)
    ] = None,
    lead: Annotated[
        float | None,
        typer.Option(metavar="S", help="Of ROS: time until the first point, s.", show_default=False),
    ] = None,
    points: Annotated[
        int | None,
        typer.Option(
            min=2,
            metavar="N",
            help="The fewest points that stay certified, unevenly spaced; at most N.",
            show_default=False,
        ),
    ] = None,
    with_approach: Annotated[
        bool,
        typer.Option(
            "--with-approach", help="Write the approach too, as a file of its own with -approach in its name."
        ),
    ] = False,
    only_list: Annotated[bool, typer.Option("--list", help="List the formats and stop.")] = False,
) -> int:
    """Write a plan as a controller's file, read it back and certify it as its receiver plays it.

    Exit code 0 only if what was read back is certified; a file that is not is written all the same, and said to be so.
    """
    if only_list:
        _print_formats()
        return 0
    if folder is None or format_name is None:
        raise ScenarioError("nospill export wants a plan folder and --format NAME; nospill export --list shows formats")
    from nospill.export.payload import payload_of
    from nospill.plans.handover import exporter_named, hand_over, with_options
    from nospill.plans.loading import load_plan
    from nospill.plans.names import CYCLE_FILE

    options = {
        "frame": frame,
        "profile": profile,
        "form": form,
        "gain": gain,
        "lookahead": lookahead,
        "prefix": prefix,
        "topic": topic,
        "lead": lead,
    }
    exporter = with_options(exporter_named(format_name), options)
    if (folder / CYCLE_FILE).is_file():
        from nospill.cli.cycles import export_legs

        if points is not None or with_approach:
            raise ScenarioError(f"{folder}: a cycle is exported without --points and --with-approach, or leg by leg")
        return export_legs(folder, exporter, _target(folder, output, exporter), rate=rate)
    plan = load_plan(folder)
    target = _target(folder, output, exporter)
    if with_approach and plan.approach is None:
        raise ScenarioError(f"{folder}: this plan has no approach; plan again with a table [approach] in the scenario")
    done = hand_over(plan, exporter, target, rate=rate, points=points)
    _report(done)
    print(payload_of(plan.scene).words())
    caution = exporter.caution(plan.scene, round(done.rate, 3))
    if caution is not None:
        say(f"{done.path}: {caution}.")
    if not done.certificate.ok:
        _say_why(plan, done)
    ok = done.certificate.ok
    if with_approach:
        from nospill.plans.approach import hand_over_approach

        there = hand_over_approach(plan, exporter, _approach_file(target, exporter), rate=rate)
        _report(there)
        unchecked = "" if plan.scene.obstacles else "; collisions with what is around are not checked"
        print(f"the approach ends where the motion begins{unchecked}")
        if not there.certificate.ok:
            _say_why_not_approach(there)
        ok = ok and there.certificate.ok
    return 0 if ok else 1


def _print_formats() -> None:
    from nospill.export import EXPORTERS

    rows = [(item.name, " ".join(item.suffixes), item.title, item.receiver) for item in EXPORTERS.values()]
    print_table(("format", "file", "what it is", "who plays it, and how"), rows, drop=("who plays it, and how", "file"))


def _target(folder: Path, output: Path | None, exporter: Exporter) -> Path:
    """The file to write: the one named, or the plan folder's name with the format's suffix, beside it."""
    place = folder.resolve()
    target = sibling_file(folder, exporter.suffixes[0]) if output is None else output
    if place == target.resolve() or place in target.resolve().parents:
        raise ScenarioError(f"{target}: a plan folder holds nothing but the plan; name a file outside of {folder}")
    return target


def _approach_file(target: Path, exporter: Exporter) -> Path:
    """The approach's file beside that of the motion: tea.script and tea-approach.script."""
    suffix = next((end for end in exporter.suffixes if target.name.endswith(end)), target.suffix)
    stem = target.name[: len(target.name) - len(suffix)] if suffix else target.name
    return target.with_name(f"{stem}-approach{suffix}")


def _say_why_not_approach(done: Handover) -> None:
    from nospill.certification.wording import finding

    name = done.exporter.name
    say(f"{done.path} is not certified as {name}: {finding(done.certificate)}; try another --rate.")


def _report(done: Handover) -> None:
    from nospill.certification.wording import verdict_line

    certificate = done.certificate
    spaced = f"at {done.rate:.6g} Hz" if done.even else "unevenly spaced"
    print(f"written to {done.path}: {done.samples} samples {spaced} ({done.exporter.name})")
    print(f"played by {done.exporter.receiver}")
    print(f"read back: joints within {done.joint_deviation:.2g} rad of the plan at all times")
    print_verdict(verdict_line(certificate), certificate.ok)


def _say_why(plan: Plan, done: Handover) -> None:
    from nospill.certification.wording import finding
    from nospill.plans.handover import rate_that_would_do

    name = done.exporter.name
    would_do = rate_that_would_do(plan, done.exporter) if plan.certificate.ok else None
    if not plan.certificate.ok:
        advice = "nor is the plan itself"
    elif would_do is not None:
        advice = f"--rate {would_do:g} would do"
    else:
        advice = f'none of the usual rates would do; plan with rate = "{done.rate:.6g} Hz" under [output]'
    say(f"{done.path} is not certified as {name}: {finding(done.certificate)}; {advice}.")
