"""view: a plan folder in the browser, or as one file."""

from __future__ import annotations

import threading
import webbrowser
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from nospill.cli.filming import VIEWS, StopOption, chosen_view, shown_films
from nospill.cli.tables import say

if TYPE_CHECKING:  # for annotations only, as everything heavy is imported inside the command
    from nospill.drawing.timeline import Film
    from nospill.viewer.meshes import Visuals

AFTER_END = 0.5
"""s; for which the liquids swing on in the picture."""


def view(
    folder: Annotated[Path, typer.Argument(metavar="DIR", help="A plan folder.")],
    other: Annotated[
        Path | None, typer.Argument(metavar="[DIR2]", help="Another one, to stand beside it.", show_default=False)
    ] = None,
    html: Annotated[
        Path | None,
        typer.Option("--html", metavar="FILE", help="Write one self-contained file instead.", show_default=False),
    ] = None,
    port: Annotated[int, typer.Option("--port", min=0, max=65535, help="Port of the live viewer.")] = 8080,
    no_browser: Annotated[bool, typer.Option("--no-browser", help="Only print the address.")] = False,
    urdf: Annotated[
        Path | None,
        typer.Option("--urdf", metavar="FILE", help="A URDF of the same arm with meshes.", show_default=False),
    ] = None,
    start: Annotated[str, typer.Option("--view", metavar="VIEW", help=f"{VIEWS} Live there are buttons.")] = "tray",
    stop: StopOption = None,
) -> int:
    """Watch a plan: arm, tray, liquids and charts in the browser, or as one HTML file."""
    from nospill.viewer.library import require_viser

    require_viser()
    seen = chosen_view(start)
    if html is not None:
        from nospill.viewer.html import HTML_RATE, LARGEST_FILE, save_html

        films = shown_films(folder, other, stop, rate=HTML_RATE, after_end=AFTER_END)
        size = save_html(films, html, visuals=_visuals(urdf, films), view=seen)
        print(f"written to {html} ({size / 1e6:.1f} MB)")
        if size > LARGEST_FILE:
            smaller = "leave --urdf out" if urdf is not None else "send it as a file, not by mail"
            say(f"{html} is larger than {LARGEST_FILE / 1e6:.0f} MB; {smaller}")
        return 0
    from nospill.viewer.live import LIVE_RATE, live_viewer

    films = shown_films(folder, other, stop, rate=LIVE_RATE, after_end=AFTER_END)
    visuals = _visuals(urdf, films)
    with suppress(KeyboardInterrupt), live_viewer(films, port=port, visuals=visuals, view=seen) as (address, _):
        print(f"{address}  (stop with Ctrl-C)", flush=True)
        if not no_browser:
            webbrowser.open(address)
        threading.Event().wait()
    return 0


def _visuals(urdf: Path | None, films: list[Film]) -> Visuals | None:
    if urdf is None:
        return None
    from nospill.viewer.meshes import load_visuals

    found = [load_visuals(urdf, film.plan.scene.robot) for film in films].pop()
    if found.missing:
        say(f"{urdf}: {len(found.missing)} meshes are missing ({found.missing[0]}, ...); links are drawn instead")
    return found
