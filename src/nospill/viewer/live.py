"""The live viewer: a server on this machine, and what it shows."""

from __future__ import annotations

import io
import threading
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, redirect_stdout
from dataclasses import dataclass
from html import escape
from typing import TYPE_CHECKING

from nospill.viewer.charts import Charts, draw_charts
from nospill.viewer.film import Film
from nospill.viewer.library import require_viser
from nospill.viewer.meshes import Visuals
from nospill.viewer.playback import Player
from nospill.viewer.scene_view import PlanView, prepare
from nospill.viewer.stage import camera, side_by_side

if TYPE_CHECKING:
    import viser

LIVE_RATE = 50.0
"""Pictures per second of the live viewer."""


@dataclass(frozen=True, slots=True)
class Shown:
    """Plans in a scene: their views and their charts, titled alike."""

    views: tuple[PlanView, ...]
    charts: Charts


def title_of(film: Film) -> str:
    """A plan in a few words: how the tray may move, how long it takes, the verdict on the motion that is shown."""
    scene = film.plan.scene
    kind = "tilting" if scene.motion.tilt_free else "level"
    verdict = "certified" if film.judgement.certificate.ok else "NOT certified"
    return f"{scene.name} ({kind}): {film.end_time:.3f} s, {verdict}"


def short_titles(films: Sequence[Film]) -> list[str]:
    """Titles of charts: "level" and "tilting" where that tells plans apart, else the scenarios' names."""
    kinds = ["tilting" if film.plan.scene.motion.tilt_free else "level" for film in films]
    if len(set(kinds)) == len(kinds):
        return kinds
    names = [film.plan.scene.name for film in films]
    return names if len(set(names)) == len(names) else [f"{name} ({index + 1})" for index, name in enumerate(names)]


def show_plans(server: viser.ViserServer, films: Sequence[Film], *, visuals: Visuals | None = None) -> Shown:
    """Build one or several plans side by side in an empty server, with ground, light and camera.

    Raises:
        ScenarioError: a robot's URDF cannot be read.
    """
    prepare(server.scene)
    places = side_by_side(films)
    view = camera(films, places)
    server.initial_camera.position = view.position
    server.initial_camera.look_at = view.look_at
    server.initial_camera.fov = view.angle
    views = tuple(
        PlanView(
            server.scene,
            film,
            root=f"/plan_{number + 1}",
            title=title_of(film) if len(films) > 1 else "",
            position=(float(place[0]), float(place[1]), float(place[2])),
            chain=visuals.chain if visuals else None,
            meshes=visuals.meshes if visuals else None,
        )
        for number, (film, place) in enumerate(zip(films, places, strict=True))
    )
    return Shown(views, draw_charts(films, short_titles(films)))


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
        yield server
    finally:
        with redirect_stdout(io.StringIO()):
            server.stop()


@contextmanager
def live_viewer(
    films: Sequence[Film], *, port: int = 8080, host: str = "127.0.0.1", visuals: Visuals | None = None
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
        lines = "<br>".join(escape(title_of(film)) for film in films)
        server.gui.add_html(f"<div style='padding:4px 8px;font-size:14px;line-height:1.4'>{lines}</div>")
        shown = show_plans(server, films, visuals=visuals)
        player = Player(server.gui, shown.views, charts=shown.charts, atomic=server.atomic)
        stop = threading.Event()
        thread = threading.Thread(target=player.run, args=(stop,), daemon=True)
        thread.start()
        try:
            yield f"http://{host}:{server.get_port()}", player
        finally:
            stop.set()
            thread.join()
