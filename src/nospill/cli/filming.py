"""film: a plan folder as a film, drawn without a graphics card, a screen or a browser."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from nospill.cli.progress import ProgressLine

if TYPE_CHECKING:  # for annotations only: everything heavy is imported inside the command
    from nospill.drawing.timeline import Film
    from nospill.drawing.views import View

_AFTER_END = 0.4
"""s of the motion; how long the liquids are seen swinging freely."""

VIEWS = "tray: follow it; fixed: fixed to it, the world tilts; arm: all of it; above: all from there."
"""What --view may be."""


StopOption = Annotated[
    str | None,
    typer.Option(
        "--stop",
        metavar="TIME",
        help="The spill-free stop that nospill stops has found from there, beside the joints braked.",
        show_default=False,
    ),
]


def film(
    folder: Annotated[Path, typer.Argument(metavar="DIR", help="A plan folder.")],
    other: Annotated[
        Path | None, typer.Argument(metavar="[DIR2]", help="Another one, on the same clock.", show_default=False)
    ] = None,
    output: Annotated[
        Path, typer.Option("-o", "--output", metavar="FILE", help="Film to write: .mp4, .webp or .gif.")
    ] = Path("film.mp4"),
    speed: Annotated[float, typer.Option("--speed", metavar="FACTOR", help="1 is real time.")] = 0.25,
    view: Annotated[
        str,
        typer.Option(
            "--view",
            metavar="VIEW",
            help=VIEWS,
        ),
    ] = "tray",
    size: Annotated[str, typer.Option("--size", metavar="WxH", help="Width and height in pixels.")] = "1280x720",
    rate: Annotated[float, typer.Option("--rate", metavar="FPS", help="Pictures per second.")] = 25.0,
    stop: StopOption = None,
) -> int:
    """Film a plan, two side by side on one clock, or a stop beside the joints braked: arm, tray, liquids, verdict."""
    with ProgressLine() as progress:
        from nospill.film.writing import Format, require_film, save_film

        form = Format(chosen_view(view), speed, _size(size), rate)
        target = output.expanduser()
        require_film(target)
        films = shown_films(folder, other, stop, rate=form.motion_rate, after_end=_AFTER_END)
        count = save_film(
            films, target, form, progress=lambda done, total: progress.say("film", f"picture {done} of {total}")
        )
    print(f"written to {output} ({count} pictures, {count / rate:.1f} s, {target.stat().st_size / 1e6:.1f} MB)")
    return 0


def shown_films(folder: Path, other: Path | None, stop: str | None, *, rate: float, after_end: float) -> list[Film]:
    """A plan, two plans, or the two motions of a stop, cut at a rate, and so much longer, s.

    Raises:
        ScenarioError: a stop of two plans, or one that is not there. PlanFolderError: a folder is not a plan.
    """
    from nospill.core.units import quantity
    from nospill.drawing.timeline import load_films
    from nospill.errors import ScenarioError

    if stop is None:
        return load_films([folder] if other is None else [folder, other], rate=rate, after_end=after_end)
    if other is not None:
        raise ScenarioError(f"--stop {stop}: a stop is of one plan, and {other} is another; leave one of them out")
    from nospill.stopping.films import stop_films

    return stop_films(folder, quantity(stop, "time"), rate=rate, after_end=after_end)


def chosen_view(name: str) -> View:
    """The view with this name.

    Raises:
        ScenarioError: there is none.
    """
    from nospill.drawing.views import View
    from nospill.errors import ScenarioError

    if name not in list(View):
        raise ScenarioError(f'--view "{name}" is no view; there are {", ".join(View)}')
    return View(name)


def _size(text: str) -> tuple[int, int]:
    from nospill.errors import ScenarioError

    width, cross, height = text.lower().partition("x")
    if not (cross and width.isdecimal() and height.isdecimal()):
        raise ScenarioError(f'--size "{text}": width and height in pixels are needed, for example 1280x720')
    return int(width), int(height)
