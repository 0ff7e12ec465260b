"""stops: the spill-free stop from every instant of a plan, and what the controller's own stop does."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from nospill.cli.progress import FILES, LOADING, ProgressLine
from nospill.cli.reporting import sibling_file
from nospill.cli.tables import print_lines, print_table, print_verdict, say

if TYPE_CHECKING:  # for annotations only: at run time these would load numpy and CasADi before the help text
    from nospill.plans.stops import Stops
    from nospill.stopping.files import WrittenStop

FINDING = "find the stops"
_STEPS = (LOADING, FINDING, FILES)

_ROWS = 12
"""Instants that are printed; all of them are in the file."""


def stops(
    folder: Annotated[Path, typer.Argument(metavar="DIR", help="A plan folder.")],
    every: Annotated[
        str, typer.Option(metavar="TIME", help="Between the instants; a plain number is seconds.")
    ] = "20 ms",
    residual: Annotated[
        str,
        typer.Option(metavar="RATIO", help="How high liquids may swing on after a stop, over max_slosh_height."),
    ] = "100 %",
    deceleration: Annotated[
        str | None,
        typer.Option(
            metavar="RATE",
            help='With which the controller brakes each joint, as "6 rad/s^2"; the arm\'s limits when left out.',
            show_default=False,
        ),
    ] = None,
    slowing: Annotated[
        str, typer.Option(metavar="TIME", help="In which the controller scales time to zero along the path.")
    ] = "0.25 s",
    within: Annotated[
        str | None,
        typer.Option(
            metavar="TIME", help="Exit code 1 unless a stop from every instant takes no longer.", show_default=False
        ),
    ] = None,
    format_name: Annotated[
        str | None,
        typer.Option(
            "--format",
            metavar="NAME",
            help="Write the stops for a controller too, beside the plan: action-goal, urscript ... (nospill export "
            "--list).",
            show_default=False,
        ),
    ] = None,
) -> int:
    """Find the fastest spill-free stop from every instant of a plan, and say what the controller's own stop does.

    A stop is a certified motion to rest along what is left of the path, after which the liquids may swing on below
    their limits; the rest of the plan always is one. Writes
    stops.json, stops.png and the samples of every stop into the plan folder. With --format: exit code 1 if one is not
    certified as its controller plays it, read back from the file. This is no safety function.
    """
    with ProgressLine(_STEPS) as progress:
        from nospill.core.units import quantity
        from nospill.plans.handover import exporter_named
        from nospill.plans.loading import load_plan
        from nospill.plans.names import STOPS_FIGURE, STOPS_FILE, STOPS_FOLDER
        from nospill.plots.stopping import save_stops
        from nospill.stopping.files import hand_over_stops
        from nospill.stopping.stops import stops as find_stops
        from nospill.stopping.stops import write_stops

        times = quantity(every, "time"), quantity(slowing, "time")
        longest = None if within is None else quantity(within, "time")
        braking = None if deceleration is None else quantity(deceleration, "angular_acceleration")
        exporter = None if format_name is None else exporter_named(format_name)
        progress.say(LOADING)
        plan = load_plan(folder)
        progress.say(FINDING)
        found = find_stops(
            plan,
            every=times[0],
            residual=quantity(residual, "ratio"),
            deceleration=braking,
            slowing=times[1],
            progress=lambda done, of: progress.say(FINDING, f"{done} of {of} instants"),
        )
        progress.say(FILES)
        write_stops(found, plan, folder)
        save_stops(found, folder / STOPS_FIGURE)
        written = []
        if exporter is not None:
            place = sibling_file(folder, "-stops" + (".script" if exporter.name == "urscript" else ""))
            written = hand_over_stops(found, plan, exporter, place)
    _print(found)
    print_lines(f"Written: {folder / STOPS_FILE}, {folder / STOPS_FIGURE}, {folder / STOPS_FOLDER}")
    stoppable = longest is None or _print_longest(found, longest)
    certified = not written or _print_written(written)
    return 0 if stoppable and certified else 1


def _print_longest(found: Stops, within: float) -> bool:
    """Say whether the plan can be stopped within a time, s, from every instant."""
    stop, late = found.longest, sum(stop.duration > within for stop in found.stops)
    verdict = f"stoppable within {within:g} s from every instant" if not late else f"not stoppable within {within:g} s"
    of_all = f", {late} of {len(found.stops)} take longer" if late else ""
    print_verdict(f"{verdict}: the longest stop takes {stop.duration:.3f} s, from {stop.t:.3f} s{of_all}", not late)
    return not late


def _print_written(written: list[WrittenStop]) -> bool:
    """Say where the files are and whether every stop in them is certified."""
    from nospill.certification.wording import finding

    wrong = [item for item in written if not item.certificate.ok]
    places = sorted({item.path if item.path.suffix == ".script" else item.path.parent for item in written})
    verdict = f"{len(written) - len(wrong)} of {len(written)} stops are certified as read back and played"
    print_verdict(f"{', '.join(map(str, places))}: {verdict}", not wrong)
    for item in wrong[:_ROWS]:
        say(f"stop from {item.stop.t:g} s: {finding(item.certificate)}")
    return not wrong


def _print(found: Stops) -> None:
    own = {(item.t, item.kind): item.text for item in found.controller}
    chosen = found.stops[:: -(-len(found.stops) // _ROWS)]
    print_table(
        ("at [s]", "stop [s]", "bound [s]", "rest [s]", "joints braked", "time scaled to zero"),
        [
            (stop.t, stop.duration, stop.bound.duration, stop.left, own[stop.t, "joints"], own[stop.t, "path"])
            for stop in chosen
        ],
        drop=("bound [s]",),
    )
    for kind, name in (("joints", "each joint braked by itself"), ("path", "time scaled to zero along the path")):
        verdicts = [item.certified for item in found.controller if item.kind == kind]
        print_lines(f"{name}: {sum(verdicts)} of {len(verdicts)} stops keep every limit")
    print_lines(
        f"spill-free stops sooner than the rest of the plan: {100 * found.solved:.0f} % of the instants; from one to "
        f"two thirds of the motion they take {100 * found.part_left:.0f} % of it (median), "
        f"{found.over_bound:.2g} times the bound below which no motion stops.",
        *([] if found.doubt is None else [found.doubt]),
        "They are motions, and no safety function.",
    )
