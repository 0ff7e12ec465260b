"""measure: the height of a liquid at both walls of its vessel, from a film."""

from __future__ import annotations

from itertools import groupby
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from nospill.cli.reporting import print_json
from nospill.cli.tables import print_lines, print_table

if TYPE_CHECKING:  # for annotations only: at run time these would load numpy before the help text
    from nospill.measuring.measured import FilmedHeights


def measure(
    film: Annotated[Path, typer.Argument(metavar="FILM", help="From one side: mp4, mov, avi, mkv or webm.")],
    radius: Annotated[str, typer.Option("--radius", metavar="LENGTH", help="Of the vessel, inside.")],
    height: Annotated[str, typer.Option("--height", metavar="LENGTH", help="Of its rim above the tray.")],
    marker: Annotated[str, typer.Option("--marker", metavar="LENGTH", help="Side of the marker's black square.")],
    axis: Annotated[
        str,
        typer.Option(
            "--axis",
            metavar="LENGTH",
            help="From the middle of the marker to the vessel's axis; positive to the right.",
        ),
    ],
    rest: Annotated[
        str, typer.Option("--rest", metavar="TIME", help="So long the liquid is at rest when the film begins.")
    ] = "0.3 s",
    side: Annotated[
        str, typer.Option("--side", metavar="higher|left|right", help="What the column height_mm holds.")
    ] = "higher",
    rate: Annotated[
        float | None,
        typer.Option("--rate", metavar="HZ", help="Frames a second as filmed.", show_default="as the file says"),
    ] = None,
    output: Annotated[
        Path | None,
        typer.Option("-o", "--output", metavar="FILE.csv", help="Write the heights here.", show_default=False),
    ] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print the record as JSON and nothing else.")] = False,
) -> int:
    """Measure the height of a liquid at both walls of a transparent vessel, from a film with a marker beside it.

    Prints which frames tell nothing; the file has no row for them. `nospill compare` reads it.
    """
    from nospill.core.files import atomic_text
    from nospill.core.units import quantity
    from nospill.errors import ScenarioError
    from nospill.measuring.measured import SIDES, heights_text, measured_heights
    from nospill.measuring.region import Vessel

    def length(option: str, text: str, dimension: str = "length") -> float:
        try:
            return quantity(text, dimension)
        except ScenarioError as error:
            raise ScenarioError(f"{option}: {error}") from None

    named = {"--radius": radius, "--height": height, "--marker": marker, "--rest": rest}
    values = [length(option, text, "time" if option == "--rest" else "length") for option, text in named.items()]
    for (option, text), value in zip(named.items(), values, strict=True):
        if value <= 0.0:
            raise ScenarioError(f"{option} {text}: must be above zero")
    if side not in SIDES:
        raise ScenarioError(f"--side {side}: must be one of {', '.join(SIDES)}")
    vessel = Vessel(radius=values[0], height=values[1], marker=values[2], axis=length("--axis", axis))
    heights = measured_heights(film, vessel, rest=values[3], rate=rate)
    if output is not None:
        atomic_text(output, heights_text(heights, side))
    if as_json:
        print_json(_table(heights))
        return 0
    _print(heights)
    if output is not None:
        print(f"written to {output}")
    return 0


def _print(heights: FilmedHeights) -> None:
    rows = []
    for name in ("left", "right"):
        side = heights.side(name)
        high, low = int(side.argmax()), int(side.argmin())
        rows.append((name, f"{1e3 * side[high]:.2f}", f"{heights.t[high]:.3f}", f"{1e3 * side[low]:.2f}"))
    columns = ("wall", "highest mm", "at s", "lowest mm")
    print_table(columns, rows, right=columns[1:])
    print()
    count = len(heights.t) + len(heights.lost)
    print_lines(
        f"{len(heights.t)} of {count} frames tell the height; {1e3 * heights.scale:.3f} mm a pixel; "
        f"{1e3 * heights.noise:.2f} mm rms at rest; least confidence {heights.confidence.min():.2f}"
    )
    for reason, frames in groupby(heights.lost, key=lambda side: side[1]):
        times = [t for t, _ in frames]
        where = f"t = {times[0]:.3f} s" if len(times) == 1 else f"{len(times)} from {times[0]:.3f} to {times[-1]:.3f} s"
        print_lines(f"lost, {reason}: {where}")


def _table(heights: FilmedHeights) -> dict[str, object]:
    return {
        "t_s": heights.t.tolist(),
        "left_m": heights.left.tolist(),
        "right_m": heights.right.tolist(),
        "confidence": heights.confidence.tolist(),
        "lost": [{"t_s": t, "reason": reason} for t, reason in heights.lost],
        "scale_m_per_pixel": heights.scale,
        "noise_m": heights.noise,
        "liquid_is_brighter": heights.brighter,
    }
