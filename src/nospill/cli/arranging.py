"""layout: where objects, tray and arm had best stand for the shortest certified motion."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from nospill.cli.progress import ProgressLine
from nospill.cli.run_options import PlanOutput, Settings
from nospill.cli.tables import print_lines, print_table, print_verdict

if TYPE_CHECKING:  # for annotations only: at run time these would load numpy and CasADi before the help text
    from nospill.layouts.record import Layout
    from nospill.scene.scene import Scene


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
    plans: Annotated[int, typer.Option("--plans", min=1, help="How many layouts are planned.")] = 30,
    seed: Annotated[int, typer.Option("--seed", min=0, help="Of the random starts.")] = 0,
    settings: Settings = None,
    output: PlanOutput = None,
) -> int:
    """Find the places of objects, tray or arm with the shortest certified motion."""
    with ProgressLine() as progress:
        from nospill.core.files import require_replaceable
        from nospill.layouts.search import layout
        from nospill.plans.names import is_plan_folder
        from nospill.scenario import read_scenario

        if output is not None:
            require_replaceable(output, replaceable=is_plan_folder)
        scene = read_scenario(scenario, settings=settings or ())
        found = layout(
            scene,
            dict(map(_range, free)),
            plans=plans,
            seed=seed,
            progress=lambda trial: progress.say(
                "layouts", "no motion" if trial.duration is None else f"{trial.duration:.3f} s"
            ),
        )
        if output is not None:
            found.plan.with_second_looks().save(output, extra=lambda folder: _draw(scene, found, folder))
    _print(scene, found)
    if output is not None:
        print_lines(f"written to {output}", f"look: {output / 'figures' / 'layout.png'}")
    print_verdict(found.text, ok=True)
    return 0


def _range(text: str) -> tuple[str, Any]:
    """Key and range; None where there is none."""
    from nospill.scenario.settings import value_from_text

    key, equals, value = text.partition("=")
    return key.strip(), value_from_text(value.strip()) if equals else None


def _draw(scene: Scene, found: Layout, folder: Path) -> None:
    from nospill.plots.layouts import save_layout

    before = None if found.before is None else found.before.duration
    (folder / "figures").mkdir(exist_ok=True)
    durations = [trial.duration for trial in found.tried]
    save_layout((scene, before), (found.plan.scene, found.plan.duration), durations, folder / "figures" / "layout.png")


def _print(scene: Scene, found: Layout) -> None:
    from nospill.core.units import as_written
    from nospill.scenario.settings import stated_value

    if found.values:
        rows = [
            (key, as_written(stated_value(scene.source, key)), as_written(value)) for key, value in found.values.items()
        ]
        print_table(("key", "as stated", "best, SI"), rows)
    for key, why in found.stuck.items():
        print_lines(f"{key} was not moved from some layouts: {why}")
    failed = [trial for trial in found.tried if trial.duration is None]
    if failed:
        print_lines(f"{len(failed)} of {len(found.tried)} layouts without a motion, the last: {failed[-1].why_not}")
