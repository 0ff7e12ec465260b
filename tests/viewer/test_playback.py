"""The clock in closed form, the player on a real server, the charts as a document."""

from __future__ import annotations

import threading
from dataclasses import replace
from itertools import pairwise
from types import SimpleNamespace
from xml.etree import ElementTree

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

pytest.importorskip("viser", reason="viser is not installed")

from nospill.certification.limiting import limiting_rows
from nospill.drawing.timeline import Film
from nospill.drawing.views import View
from nospill.viewer import playback
from nospill.viewer.charts import WIDTH, colour_key, draw_charts
from nospill.viewer.live import live_viewer, running_server, show_plans
from nospill.viewer.panels import Panel, contents
from nospill.viewer.playback import SPEEDS, Clock, Player
from nospill.viewer.scene_view import PlanView
from tests.waiting import wait_until

SVG = "{http://www.w3.org/2000/svg}"


@given(st.lists(st.floats(0, 0.5), max_size=30), st.sampled_from(sorted(SPEEDS.values())))
def test_clock_runs_at_its_speed_and_starts_again(steps: list[float], speed: float) -> None:
    clock = Clock(1.7)
    clock.speed = speed
    for step in steps:
        clock.advance(step)
    turns = (speed * sum(steps) - clock.t) / 1.7
    assert turns == pytest.approx(round(turns), abs=1e-9)
    assert 0.0 <= clock.t <= 1.7


def test_clock_stops_at_the_end_without_loop() -> None:
    clock = Clock(1.0)
    clock.loop = False
    clock.advance(0.4)
    assert clock.playing
    clock.advance(0.8)
    assert (clock.t, clock.playing) == (1.0, False)
    clock.advance(1.0)
    assert clock.t == 1.0
    clock.toggle()
    assert (clock.t, clock.playing) == (0.0, True)
    clock.seek(7.0)
    assert (clock.t, clock.playing) == (1.0, False)
    clock.seek(-7.0)
    assert clock.t == 0.0


def test_player_moves_views_and_controls_together(tilting_film: Film, level_film: Film) -> None:
    with running_server(port=0) as server:
        shown = show_plans(server, [level_film, tilting_film])
        chosen: list[View] = []
        player = Player(
            server.gui,
            shown.views,
            charts=shown.charts,
            atomic=server.atomic,
            aim=lambda view: bool(chosen.append(view)),
        )
        assert player.clock.speed == 0.25
        assert player._looks is not None
        for callback in player._looks._impl.update_cb:
            callback(SimpleNamespace(client=object(), target=SimpleNamespace(value="from above")))  # type: ignore[arg-type]
        assert chosen == [View.ABOVE]
        player._speed.value = "1x"
        player.step(0.3)
        player.step(0.2)
        assert player.clock.t == pytest.approx(0.5)
        assert [view._shown for view in shown.views] == [level_film.index(0.5), tilting_film.index(0.5)]
        assert player._slider.value == pytest.approx(0.5)
        assert "0.50 s" in player._cursor.content
        for handle in (player._names, player._path, player._loop):
            handle.value = False
        player._speed.value = "0.1x"
        # Values set from this side carry no client; a user's do.
        for callback in player._slider._impl.update_cb:
            callback(SimpleNamespace(client=object(), target=SimpleNamespace(value=0.2)))  # pyright: ignore[reportArgumentType]
        assert player.clock.t == pytest.approx(0.2)
        player.step(5.0)
        assert player.clock.t == pytest.approx(0.2)  # dragging the slider pauses
        assert player._button.label == "Play"
        player._names.value = False
        other = PlanView(server.scene, tilting_film, root="/other")
        player.replace([other], charts=draw_charts([tilting_film], [""]))
        shown.views[0].remove()
        assert not other.tray._labels[0].visible
        assert (player.clock.t, player.clock.playing, player.clock.speed) == (0.0, True, 0.1)
        assert player._slider.max == pytest.approx(tilting_film.length, abs=1e-3)
        player.step(1.0)
        assert other._shown == tilting_film.index(0.1)
        assert player._button.label == "Pause"
        player.remove()


class ScriptedTime:
    """A clock, and the event that ends playing: each wait lasts as long as was wanted, and what comes late on top."""

    def __init__(self, late: list[float]) -> None:
        self.now, self.late, self.waits = 0.0, late, 0

    def monotonic(self) -> float:
        return self.now

    def wait(self, seconds: float) -> bool:
        if self.waits == len(self.late):
            return True
        self.now += seconds + self.late[self.waits]
        self.waits += 1
        return False


def test_time_of_the_motion_is_real_time(tilting_film: Film, monkeypatch: pytest.MonkeyPatch) -> None:
    """A picture that comes late is left out: the clock of the motion is always where the wall's is."""
    with running_server(port=0) as server:
        shown = show_plans(server, [tilting_film.at_rate(50.0)])
        player = Player(server.gui, shown.views, charts=shown.charts, atomic=server.atomic)
        player.clock.speed = 1.0
        wall = ScriptedTime([0.0, 0.0, 0.3, 0.0, 0.004, 0.11])
        monkeypatch.setattr(playback, "time", wall)
        player.run(wall)  # type: ignore[arg-type]
        assert player.clock.t == pytest.approx(wall.now, abs=1e-12)
        assert wall.now == pytest.approx(6 * 0.02 + 0.414)


def test_a_live_viewer_plays_on_a_thread_of_its_own_and_ends_it(tilting_film: Film) -> None:
    with live_viewer([tilting_film.at_rate(50.0)], port=0) as (address, player):
        assert address.startswith("http://127.0.0.1:")
        wait_until(lambda: player.clock.t > 0.0, "the motion plays")
    assert not [thread for thread in threading.enumerate() if "run" in thread.name]


def test_charts_are_documents_with_every_line_and_limit(tilting_film: Film, mixed_film: Film) -> None:
    for film in (tilting_film, mixed_film):
        charts = draw_charts([film], [""])
        documents = [ElementTree.fromstring(picture) for picture in charts.pictures]
        assert len(documents) == 3 + bool(limiting_rows(film.judgement, film.plan.scene))
        texts = [item.text or "" for document in documents for item in document.iter(f"{SVG}text")]
        for title in ("liquid height [mm]", "contact, use of limit [1]", "joint speed over limit [1]", "0 s"):
            assert title in texts
        assert {"limit 1", "limit -1"} <= set(texts)
        for name in (*film.liquids, *film.plan.scene.robot.joints, *film.contact_use):
            assert name in texts
        lines = [line for document in documents for line in document.iter(f"{SVG}polyline")]
        count = len(film.liquids) + len(film.contact_use) + len(film.plan.scene.robot.joints)
        assert len(lines) == count
        for line in lines:
            points = np.array([[float(part) for part in pair.split(",")] for pair in line.get("points", "").split()])
            assert points[:, 0].min() >= charts.left - 0.1
            assert points[:, 0].max() <= charts.right + 0.1
            assert np.all(np.diff(points[:, 0]) > 0)
            assert points[:, 1].min() >= 0
        for document in documents:
            height = float(document.get("viewBox", "").split()[3])
            for item in document.iter(f"{SVG}text"):
                assert 0 <= float(item.get("x", "0")) <= WIDTH
                assert 0 <= float(item.get("y", "0")) <= height
    ElementTree.fromstring(colour_key())


def test_charts_call_objects_as_people_do(mixed_film: Film) -> None:
    scene = mixed_film.plan.scene
    named = replace(scene, cargo=tuple(replace(item, label="beer 0.3 l") for item in scene.cargo))
    film = replace(mixed_film, plan=replace(mixed_film.plan, scene=named))
    panel = next(panel for rank, panel in contents(film, "") if rank == 1)
    assert isinstance(panel, Panel)
    assert [line.name for line in panel.lines] == [f"beer 0.3 l ({name})" for name in film.liquids]  # two alike


def test_limits_of_heights_name_their_liquids_and_go_on_after_the_end(tilting_film: Film, mixed_film: Film) -> None:
    def heights(film: Film) -> Panel:
        panel = next(panel for rank, panel in contents(film, "") if rank == 1)
        assert isinstance(panel, Panel)
        return panel

    def limits(film: Film) -> list[tuple[float, str, float]]:
        return [(round(limit.value, 3), limit.name, limit.start) for limit in heights(film).limits]

    assert limits(tilting_film) == [(15.0, "15 mm", 0.0), (3.0, "", tilting_film.end_time)]
    assert heights(tilting_film).note == "limit after the end: 3 mm"
    found = limits(mixed_film)
    values = sorted({1e3 * track.limit for track in mixed_film.liquids.values()}, reverse=True)
    assert [value for value, _, start in found if start == 0.0] == pytest.approx(values, abs=1e-3)
    if len(values) > 1:
        assert all(any(name in text for name in mixed_film.liquids) for _, text, start in found if start == 0.0)


def test_two_plans_share_the_axis_and_stand_like_beside_like(tilting_film: Film, level_film: Film) -> None:
    charts = draw_charts([level_film, tilting_film], ["level", "tilting"])
    texts = [
        item.text or "" for picture in charts.pictures for item in ElementTree.fromstring(picture).iter(f"{SVG}text")
    ]
    titles = [text for text in texts if text.startswith(("level: ", "tilting: "))]
    assert len(titles) == 2 * 3 + sum(
        bool(limiting_rows(film.judgement, film.plan.scene)) for film in (tilting_film, level_film)
    )
    titles = [title for title in titles if "holds" not in title]
    assert all(b.split(": ")[1] == a.split(": ")[1] for a, b in list(pairwise(titles))[::2])
    assert charts.length == max(level_film.length, tilting_film.length)


def test_cursor_goes_from_axis_to_axis(tilting_film: Film) -> None:
    charts = draw_charts([tilting_film], [""])
    assert charts.cursor_at(0.0) == pytest.approx(100 * charts.left / WIDTH)
    assert charts.cursor_at(charts.length) == pytest.approx(100 * charts.right / WIDTH)
    assert charts.cursor_at(2 * charts.length) == charts.cursor_at(charts.length)
    assert "'1.25 s'" in charts.cursor_style(1.25)
