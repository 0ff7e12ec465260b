"""The live viewer: a server on this machine, and what it shows."""

from __future__ import annotations

import io
import threading
import warnings
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, redirect_stdout
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from nospill.drawing.timeline import Film
from nospill.drawing.views import CLOSE, View, arrangement
from nospill.viewer.charts import Charts, draw_charts
from nospill.viewer.library import require_viser
from nospill.viewer.meshes import Visuals
from nospill.viewer.names import letters_of
from nospill.viewer.phone import PAGE, PHONE_STYLE
from nospill.viewer.playback import Player
from nospill.viewer.scene_view import PlanView, prepare
from nospill.viewer.words import INTRODUCTION, STYLE, introduction

if TYPE_CHECKING:
    import viser

LIVE_RATE = 50.0
"""Pictures per second of the live viewer."""
_ASPECT = 1.05
"""Width over height of the scene's part of a narrow window; a wider one shows more of what is around the tray."""


@dataclass(frozen=True, slots=True)
class Shown:
    """Plans in a scene: their views, their charts, titled alike, the ground, and whether names are shown at first."""

    views: tuple[PlanView, ...]
    charts: Charts
    ground: viser.SceneNodeHandle
    named: bool = True


def short_titles(films: Sequence[Film]) -> list[str]:
    """Titles of charts: "level" and "tilting" where that tells plans apart, else the scenarios' names."""
    kinds = ["level" if film.plan.scene.stays_level else "tilting" for film in films]
    if len(set(kinds)) == len(kinds):
        return kinds
    names = [film.plan.scene.name for film in films]
    return names if len(set(names)) == len(names) else [f"{name} ({index + 1})" for index, name in enumerate(names)]


def show_plans(
    server: viser.ViserServer, films: Sequence[Film], *, visuals: Visuals | None = None, view: View = View.TRAY
) -> Shown:
    """Build one or several plans side by side in an empty server, with ground, light and camera.

    Raises:
        ScenarioError: a robot's URDF cannot be read.
    """
    ground, titles = prepare(server.scene), short_titles(films)
    views = tuple(
        PlanView(
            server.scene,
            film,
            root=f"/plan_{number + 1}",
            title=title if len(films) > 1 else "",
            chain=visuals.chain if visuals else None,
            meshes=visuals.meshes if visuals else None,
            ground=ground if number == 0 else None,
        )
        for number, (film, title) in enumerate(zip(films, titles, strict=True))
    )
    shown = Shown(views, draw_charts(films, titles), ground)
    return replace(shown, named=aim(server, shown, view))


def aim(server: viser.ViserServer, shown: Shown, view: View) -> bool:
    """See everything from another view, in every browser that looks on and in those to come.

    Returns:
        Whether there is space for the names of the objects; they are hidden where there is none.
    """
    films = [item.film for item in shown.views]
    places, camera = arrangement(films, view, aspect=_ASPECT)
    letters = letters_of(films, [item.title for item in shown.views], places, view, camera)
    with server.atomic():
        for item, place in zip(shown.views, places, strict=True):
            item.ride(view, place)
            item.write_names(letters)
        # Trays that go their own ways have no ground in common.
        shown.ground.visible = view not in CLOSE or len(shown.views) == 1
        start = server.initial_camera
        start.position, start.look_at, start.fov = camera.position, camera.look_at, camera.angle
        for client in server.get_clients().values():
            now = client.camera
            now.position, now.look_at, now.fov = camera.position, camera.look_at, camera.angle
    return letters.apart


@contextmanager
def running_server(*, port: int, host: str = "127.0.0.1") -> Iterator[viser.ViserServer]:
    """A viser server without axes that says nothing on stdout; where the port is taken it is the next free one.

    Raises:
        MissingExtraError: viser is not installed.
    """
    library = require_viser()
    with redirect_stdout(io.StringIO()):
        server = library.ViserServer(host=host, port=port, label="nospill", verbose=False)
    server.scene.world_axes.visible = False
    try:
        with warnings.catch_warnings():
            # what is still on its way to a tab that was closed goes nowhere, which is right
            warnings.filterwarnings("ignore", message=r"Queued a \w+ on a closed connection")
            yield server
    finally:
        with redirect_stdout(io.StringIO()):
            server.stop()


@contextmanager
def live_viewer(
    films: Sequence[Film],
    *,
    port: int = 8080,
    host: str = "127.0.0.1",
    visuals: Visuals | None = None,
    view: View = View.TRAY,
) -> Iterator[tuple[str, Player]]:
    """A running viewer: its address and its player, which plays in a thread until the end of the block.

    Raises:
        MissingExtraError: viser is not installed.
        ScenarioError: a robot's URDF cannot be read.
    """
    with running_server(port=port, host=host) as server:
        server.gui.configure_theme(control_width="large", show_logo=False, show_share_button=False)
        server.gui.main_panel.dock_right()
        server.gui.set_panel_label("nospill")
        server.gui.add_html(
            f"<div id='{PAGE}' class='{INTRODUCTION}' style='padding:4px 8px'>"
            f"<style>{PHONE_STYLE}{STYLE}</style>{introduction(films)}</div>"
        )
        shown = show_plans(server, films, visuals=visuals, view=view)
        player = Player(
            server.gui,
            shown.views,
            charts=shown.charts,
            atomic=server.atomic,
            aim=lambda chosen: aim(server, shown, chosen),
            named=shown.named,
        )
        stop = threading.Event()
        thread = threading.Thread(target=player.run, args=(stop,), daemon=True)
        thread.start()
        try:
            yield f"http://{host}:{server.get_port()}", player
        finally:
            stop.set()
            thread.join()
