"""verify, margins: a plan against another physics engine, and against numbers that are off."""

from __future__ import annotations

import json
from contextlib import nullcontext
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from nospill.cli.progress import ProgressLine
from nospill.cli.reporting import only_stderr, print_json, sibling_file
from nospill.cli.tables import print_lines, print_table, print_verdict, say

if TYPE_CHECKING:  # for annotations only: at run time these would load numpy and CasADi before the help text
    from nospill.margins import MarginsReport
    from nospill.verify import VerifyReport

_STUDY_FILES = {"margins.json", "samples.csv", "tornado.png", "tornado.pdf"}


def verify(
    folder: Annotated[Path, typer.Argument(metavar="DIR", help="A plan folder.")],
    distance: Annotated[
        str, typer.Option("--distance", metavar="LENGTH", help="Slide or lift-off from which on an object has moved.")
    ] = "0.5 mm",
    angle: Annotated[
        str, typer.Option("--angle", metavar="ANGLE", help="Rotation or tilt from which on an object has moved.")
    ] = "0.5 deg",
    water: Annotated[
        bool, typer.Option("--water", help="Follow the liquids by their nonlinear flow instead; no MuJoCo is needed.")
    ] = False,
    as_json: Annotated[bool, typer.Option("--json", help="Print the report as JSON and nothing else.")] = False,
    save: Annotated[
        bool,
        typer.Option(
            "--save", help="Write the report beside the folder, as DIR.verify.json, or DIR.water.json and .png."
        ),
    ] = False,
    video: Annotated[
        Path | None,
        typer.Option(
            "--video",
            metavar="FILE",
            help="Film the simulation (.mp4, .webp or .gif), at a quarter of its speed.",
            show_default=False,
        ),
    ] = None,
) -> int:
    """Simulate a plan's objects and liquids in MuJoCo, driven by the joint file; exit code 1 if one moves.

    Where the scenario has obstacles, also if arm, tray or cargo touches one. With --water: exit code 1 if a liquid
    does not keep its limits.
    """
    if water:
        from nospill.cli.water import follow_water, print_water
        from nospill.errors import ScenarioError

        if video is not None:
            raise ScenarioError("--video films the simulated objects; leave out --water or --video")
        with only_stderr() if as_json else nullcontext(), ProgressLine() as progress:
            found, written = follow_water(folder, save=save, progress=progress)
        return print_water(found, written, as_json=as_json)
    with only_stderr() if as_json else nullcontext(), ProgressLine() as progress:
        from nospill.core.files import atomic_text
        from nospill.core.units import quantity
        from nospill.plans.loading import load_plan
        from nospill.verify import Thresholds, folder_joints
        from nospill.verify import verify as simulate

        thresholds = Thresholds(quantity(distance, "length"), quantity(angle, "angle"))
        if video is not None:
            from nospill.film.writing import require_film

            require_film(video)
        plan = load_plan(folder)
        joints = folder_joints(folder, plan)
        progress.say("simulate")
        report = simulate(plan, thresholds=thresholds, joints=joints)
        record = sibling_file(folder, ".verify.json")
        if save:
            atomic_text(record, json.dumps(report.to_dict(), indent=2, allow_nan=False) + "\n")
        if video is not None:
            from nospill.verify.video import write_film

            progress.say("film")
            write_film(
                plan, joints, video, progress=lambda done, total: progress.say("film", f"picture {done} of {total}")
            )
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
    table = report.to_dict()
    keys = ("name", "slide_mm", "slide_at_s", "rotation_deg", "tilt_deg", "lift_off_mm", "moved_at_s")
    columns = ("object", "slide mm", "at s", "rotation deg", "tilt deg", "lift-off mm", "moves from s")
    still = "every object stays" if all(item.ok for item in report.objects) else "not every object stays"
    touching = ", ".join(f"{item.body} touches {item.obstacle}" for item in report.touches)
    verdict = f"{still} within {table['threshold_mm']:g} mm and {table['threshold_deg']:g} deg"
    if not report.objects:
        verdict = "nothing stands on the tray that could move"
    verdict += f"; {touching}" if touching else ""
    objects = table["objects"]
    print_verdict(verdict, report.ok)
    print()
    print_table(
        (*columns, "verdict"),
        [(*(item[key] for key in keys), "stays" if item["ok"] else "MOVES") for item in objects],
        drop=("at s", "moves from s", "tilt deg"),
        failing={index for index, item in enumerate(objects) if not item["ok"]},
    )
    print()
    print_lines(f"joints from {report.source}; {report.engine}, {report.simulated:.2f} s simulated")
    print_verdict(verdict, report.ok)


def margins(
    folder: Annotated[Path, typer.Argument(metavar="DIR", help="A plan folder.")],
    samples: Annotated[int, typer.Option("--samples", metavar="N", help="Sets of numbers that are drawn.")] = 1000,
    seed: Annotated[int, typer.Option("--seed", metavar="S", help="Of the draw.")] = 0,
    friction: Annotated[
        str | None, typer.Option("--friction", metavar="RATIO", help="Friction, relative, +-.", show_default=False)
    ] = None,
    fill: Annotated[
        str | None,
        typer.Option("--fill", metavar="LENGTH", help="Height of the liquid at rest, +-.", show_default=False),
    ] = None,
    damping: Annotated[
        str | None,
        typer.Option("--damping", metavar="LOW..HIGH", help="Factor on the damping.", show_default=False),
    ] = None,
    position: Annotated[
        str | None,
        typer.Option("--position", metavar="LENGTH", help="Place on the tray, +- in x and y.", show_default=False),
    ] = None,
    mass: Annotated[
        str | None, typer.Option("--mass", metavar="RATIO", help="Mass of an object, relative, +-.", show_default=False)
    ] = None,
    delay: Annotated[
        str | None,
        typer.Option(
            "--delay", metavar="TIME", help="Delay of every joint, +- about the controller's.", show_default=False
        ),
    ] = None,
    lag: Annotated[
        str | None, typer.Option("--lag", metavar="TIME", help="Lag of every joint, likewise.", show_default=False)
    ] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print the figures as JSON and nothing else.")] = False,
    output: Annotated[
        Path | None,
        typer.Option(
            "-o",
            "--output",
            metavar="FOLDER",
            help="Write figures, samples and a tornado plot here.",
            show_default=False,
        ),
    ] = None,
) -> int:
    """Draw friction, fill, damping, place and mass anew and report what is left of a plan's margins.

    Drawn are the scenario's tolerances, where it states any; else friction +-10 %, fill +-2 mm, damping x0.5 to x2,
    place +-1 mm and mass +-2 %. An option counts for all objects. Delay and lag of the arm are drawn where asked for,
    and all that tolerance.tracking states where the scenario states it.
    """
    with only_stderr() if as_json else nullcontext(), ProgressLine() as progress:
        from nospill.core.files import atomic_folder, require_replaceable
        from nospill.margins import margins as study
        from nospill.margins import scenario_ranges
        from nospill.margins.arms import ArmRanges
        from nospill.plans.loading import load_plan

        given = _range_options(friction, fill, damping, position, mass)
        times = {name: _time_option(f"--{name}", text) for name, text in (("delay", delay), ("lag", lag))}
        if output is not None:
            require_replaceable(output, replaceable=_only_study)
        plan = load_plan(folder)
        report = study(
            plan,
            ranges=[replace(own, **given) for own in scenario_ranges(plan.scene)],
            arm=None if delay is None and lag is None else ArmRanges(**times),
            samples=samples,
            seed=seed,
            progress=lambda done, total: progress.say("draw", f"{done} of {total}"),
        )
        if output is not None:
            with atomic_folder(output, replaceable=_only_study) as partial:
                _write_study(report, partial, [cargo.name for cargo in plan.scene.cargo])
    if as_json:
        print_json(report.to_dict())
    else:
        _print_margins(report)
        if output is not None:
            print(f"written to {output}")
    return 0


def _time_option(option: str, text: str | None) -> float:
    """A time that may be left out, s."""
    from nospill.core.units import quantity
    from nospill.errors import ScenarioError

    try:
        return 0.0 if text is None else quantity(text, "time")
    except ScenarioError as error:
        raise ScenarioError(f"{option}: {error}") from None


def _range_options(
    friction: str | None, fill: str | None, damping: str | None, position: str | None, mass: str | None
) -> dict[str, Any]:
    """The fields of `Ranges` that options set.

    Raises:
        ScenarioError: a value that cannot be read or is no range.
    """
    from nospill.core.units import quantity
    from nospill.errors import ScenarioError
    from nospill.margins import Ranges

    def read(option: str, text: str, dimension: str) -> float:
        try:
            return quantity(text, dimension)
        except ScenarioError as error:
            raise ScenarioError(f"--{option} {error}") from error

    given: dict[str, Any] = {}
    for option, text, dimension in (
        ("friction", friction, "ratio"),
        ("fill", fill, "length"),
        ("position", position, "length"),
        ("mass", mass, "ratio"),
    ):
        if text is not None:
            given[option] = read(option, text, dimension)
    if damping is not None:
        low, dots, high = damping.partition("..")
        if not dots:
            raise ScenarioError(f'--damping "{damping}": two factors are needed, for example "0.5..2"')
        given["damping"] = (read("damping", low, "number"), read("damping", high, "number"))
    Ranges(**given)  # refuses what is no range before anything is read
    return given


def _only_study(names: set[str]) -> bool:
    return "margins.json" in names and names <= _STUDY_FILES


def _write_study(report: MarginsReport, folder: Path, names: list[str]) -> None:
    import numpy as np

    from nospill.margins import FACTORS
    from nospill.plots.margins_tornado import Bar, save_tornado

    text = json.dumps(report.to_dict(), indent=2, allow_nan=False) + "\n"
    (folder / "margins.json").write_text(text, encoding="utf-8")
    columns = ["worst_margin", *(f"{name}: {factor}" for name in names for factor in FACTORS)]
    table = np.column_stack([report.worst_margin, report.draws.reshape(report.samples, -1)])
    np.savetxt(folder / "samples.csv", table, delimiter=",", fmt="%.9g", header=",".join(columns), comments="")
    bars = [
        Bar(
            item.factor,
            item.measure,
            item.nominal,
            item.least,
            item.greatest,
            item.least_at,
            item.greatest_at,
            item.limited_by,
        )
        for item in report.influences
    ]
    save_tornado(
        bars,
        report.worst_margin,
        folder,
        nominal=report.nominal,
        title=f"{report.scenario}: what the use of the limits depends on",
    )


def _print_margins(report: MarginsReport) -> None:
    """Print whether anything spills, the probabilities, the constraints and the influences."""
    from nospill.certification.wording import percent

    chances = {
        "spill: over the rim": report.spill,
        "surface over max_slosh_height": report.over_limit,
        "slide: more friction needed than there is": report.slide,
        "tip": report.tip,
        "any limit of the certificate": report.any_limit,
    }
    if report.arms and report.arm.certain:
        print_lines(f"arm: {report.arms} drawn from the band of the scenario (tolerance.tracking)")
    elif report.arms:
        print_lines(
            f"arm: {report.arms} drawn, delay +- {1e3 * report.arm.delay:g} ms and lag +- {1e3 * report.arm.lag:g} ms "
            "of every joint about the controller's"
        )
    spill = report.spill
    print_verdict(
        f"{spill.count} of {report.samples} samples spill: a probability of at most {1e2 * spill.high:.1f} %",
        spill.count == 0,
    )
    print()
    print_table(
        ("what", "samples", "probability", "at least", "at most"),
        [
            (name, item.count, *(f"{1e2 * share:.1f} %" for share in (item.value, item.low, item.high)))
            for name, item in chances.items()
        ],
        drop=("at least", "probability"),
        right=("probability", "at least", "at most"),
    )
    print()
    print_table(
        ("constraint", "of", "largest use", "broken in"),
        [
            (item.constraint, item.subject, percent(item.largest_use, item.largest_use <= 1.0), item.broken.count)
            for item in report.constraints
        ],
        right=("largest use",),
    )
    print()
    print_table(
        ("number", "limits of", "largest use", "at", "least use", "at best", "limit"),
        [
            (
                item.factor,
                item.measure,
                _use(item.least),
                item.least_at,
                _use(item.greatest),
                item.greatest_at,
                item.limited_by,
            )
            for item in report.influences
        ],
        drop=("at best", "at", "limits of", "least use"),
        right=("largest use", "least use"),
    )
    worst, middle, best = (_use(report.percentiles[key]) for key in (0, 50, 100))
    print()
    print_lines(
        f"largest use: {worst} in the worst of {report.samples} samples (seed {report.seed}), {middle} in the middle "
        f"one, {best} in the best",
        f"largest use with the scenario's own numbers, friction without reserve: {_use(report.nominal)}",
    )


def _use(margin: float) -> str:
    """Use of a limit of which a margin is left, as certificates state it."""
    from nospill.certification.wording import percent

    return percent(1.0 - margin, margin >= 0.0)
