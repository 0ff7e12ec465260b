"""layout: where objects, tray and arm had best stand for the shortest motion or cycle, or the largest margin."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from nospill.cli.progress import ProgressLine
from nospill.cli.run_options import PlanOutput, Settings
from nospill.cli.tables import print_lines, print_table, print_verdict

if TYPE_CHECKING:  # for annotations only: at run time these would load numpy and CasADi before the help text
    from nospill.layouts.record import Layout, Trial
    from nospill.planning.varied import Varied


def layout(
    scenario: Annotated[
        str, typer.Argument(help="A scenario file (TOML), a plan folder, or the name of a bundled example.")
    ],
    free: Annotated[
        list[str],
        typer.Option(
            "--free",
            metavar="KEY=RANGE",
            help='What may change, as \'tray.offset=["80 mm", "150 mm"]\'; the place of an object, as cargo.c1.at or '
            "cargo.*.at, needs no range. Repeatable.",
            show_default=False,
        ),
    ],
    within: Annotated[
        str | None,
        typer.Option(
            "--within",
            metavar="TIME",
            help='Seek the largest margin of liquids and contacts within this time, as "2.2 s".',
            show_default="the shortest motion",
        ),
    ] = None,
    plans: Annotated[
        int,
        typer.Option("--plans", min=1, help="How many layouts are planned, each once, with --within up to 6 times."),
    ] = 30,
    seed: Annotated[int, typer.Option("--seed", min=0, help="Of the random starts.")] = 0,
    settings: Settings = None,
    output: PlanOutput = None,
) -> int:
    """Find the places of objects, tray or arm with the shortest certified motion or cycle, or the largest margin."""
    with ProgressLine() as progress:
        from nospill.core.files import require_replaceable
        from nospill.layouts.search import layout
        from nospill.planning.varied import varied
        from nospill.plans.names import holds_a_plan

        if output is not None:
            require_replaceable(output, replaceable=holds_a_plan)
        base = varied(scenario, settings=settings or ())
        found = layout(
            base,
            dict(map(_range, free)),
            within=within,
            plans=plans,
            seed=seed,
            progress=lambda trial: progress.say("layouts", _told(trial)),
        )
        if output is not None:
            _save(base, found, output)
    _print(base, found)
    if output is not None:
        print_lines(f"written to {output}", f"look: {output / 'figures' / 'layout.png'}")
    print_verdict(found.text, ok=True)
    return 0


def _range(text: str) -> tuple[str, Any]:
    """Key and range; None where there is none."""
    from nospill.scenario.settings import value_from_text

    key, equals, value = text.partition("=")
    return key.strip(), value_from_text(value.strip()) if equals else None


def _told(trial: Trial) -> str:
    if trial.duration is None:
        return "no motion"
    return f"{trial.duration:.3f} s" if trial.reserve is None else f"margin {trial.reserve:.1%}, {trial.duration:.3f} s"


def _save(base: Varied, found: Layout, folder: Path) -> None:
    from nospill.plans.cycle import CyclePlan

    plan = found.plan.with_second_looks()
    if isinstance(plan, CyclePlan):
        plan.save(folder, figures=lambda place: _draw(base, found, place))
        return
    plan.save(folder, extra=lambda place: _draw(base, found, place / "figures"))


def _draw(base: Varied, found: Layout, figures: Path) -> None:
    from nospill.plans.cycle import CyclePlan
    from nospill.plots.layouts import save_layout

    figures.mkdir(exist_ok=True)
    scene = found.plan.legs[0].scene if isinstance(found.plan, CyclePlan) else found.plan.scene
    if found.within is None:
        before, after = None if found.before is None else found.before.duration, found.plan.duration
        tried = [trial.duration for trial in found.tried]
    else:
        before, after, tried = found.margin_before, found.margin, [trial.reserve for trial in found.tried]
    stated, best, sought = (base.scenes[0], before), (scene, after), found.within is not None
    save_layout(stated, best, tried, figures / "layout.png", margin=sought)


def _print(base: Varied, found: Layout) -> None:
    from nospill.core.units import as_written
    from nospill.scenario.settings import stated_value

    if found.values:
        rows = [
            (key, as_written(stated_value(base.table, key)), as_written(value)) for key, value in found.values.items()
        ]
        print_table(("key", "as stated", "best, SI"), rows)
    for key, why in found.stuck.items():
        print_lines(f"{key} was not moved from some layouts: {why}")
    failed = [trial for trial in found.tried if trial.duration is None]
    if failed:
        print_lines(f"{len(failed)} of {len(found.tried)} layouts without a motion, the last: {failed[-1].why_not}")
