"""The scene tree of a real server: what stands where, what moves, what is taken away."""

# pyright: reportAttributeAccessIssue=false, reportOptionalMemberAccess=false
from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from itertools import combinations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

pytest.importorskip("viser", reason="viser is not installed")

import viser

from nospill.drawing.colours import SERIES, USE_STOPS, rgb, use_colours
from nospill.drawing.stage import camera, occupied, side_by_side, swept_box
from nospill.drawing.timeline import Film
from nospill.drawing.views import CLOSE, View, arrangement
from nospill.scenario import read_scenario, scene_from_table
from nospill.viewer.live import aim, running_server, short_titles, show_plans
from nospill.viewer.names import letters_of, name_boxes
from nospill.viewer.scene_view import PlanView, prepare
from nospill.viewer.surroundings import add_surroundings, region_edges
from nospill.viewer.words import title_of
from tests.films import UNLIKE, film_of


@pytest.fixture(scope="module")
def server() -> Iterator[viser.ViserServer]:
    with running_server(port=0) as found:
        yield found


def world(server: viser.ViserServer, name: str, points: np.ndarray) -> np.ndarray:
    """Points of a node in the world, by walking up its names."""
    while name:
        handle = server.scene.get_handle_by_name(name)
        assert handle is not None, name
        turn = Rotation.from_quat(np.asarray(handle.wxyz)[[1, 2, 3, 0]])
        points = turn.apply(points) + np.asarray(handle.position)
        name = name.rpartition("/")[0]
    return points


def node(server: viser.ViserServer, ending: str) -> str:
    names = [name for name in server.scene._handle_from_node_name if name.endswith(ending)]
    assert len(names) == 1, names
    return names[0]


@pytest.mark.parametrize("which", ["tilting_film", "mixed_film"])
def test_everything_stands_where_the_judge_says(
    server: viser.ViserServer, which: str, request: pytest.FixtureRequest
) -> None:
    film: Film = request.getfixturevalue(which)
    view = PlanView(server.scene, film, root="/one", position=(0.5, -1.0, 0.0))
    tray_node, played = node(server, "/tray"), film.judgement.replay
    for index in (0, len(film.t) // 3, len(film.t) // 2):
        view.show(float(film.t[index]))
        picked = int(np.rint(film.t[index] * played.rate))
        # The tray's frame is that of the judge's replay, moved to where the robot stands.
        axes = world(server, tray_node, np.vstack([np.zeros(3), np.eye(3)]))
        assert axes[0] - (0.5, -1.0, 0.0) == pytest.approx(played.tray.position[picked], abs=1e-6)
        assert pytest.approx(played.tray.rotation[picked], abs=1e-6) == (axes[1:] - axes[0]).T
        normal = played.tray.rotation[picked][:, 2]
        top = world(server, f"{tray_node}/board", server.scene.get_handle_by_name(f"{tray_node}/board").vertices)
        assert (top - axes[0]) @ normal == pytest.approx(np.clip((top - axes[0]) @ normal, -1, 0), abs=1e-6)
        for cargo in film.plan.scene.cargo:
            body = server.scene.get_handle_by_name(f"{tray_node}/{cargo.name}/body")
            height = (world(server, f"{tray_node}/{cargo.name}/body", body.vertices) - axes[0]) @ normal
            assert height.min() == pytest.approx(0.0, abs=1e-6)  # stands on the board
            assert height.max() == pytest.approx(cargo.container.height, abs=1e-6)
            name = world(server, f"/one/names/name_{cargo.name}", np.zeros((1, 3)))[0]
            assert (name - axes[0]) @ normal == pytest.approx(cargo.container.height + 0.012, abs=1e-6)
            foot = world(server, f"{tray_node}/{cargo.name}", np.zeros((1, 3)))[0]
            assert (foot - axes[0]) @ played.tray.rotation[picked] == pytest.approx([*cargo.position, 0.0], abs=1e-6)
            if cargo.filling:
                liquid = server.scene.get_handle_by_name(f"{tray_node}/{cargo.name}/liquid").vertices
                assert np.all(np.abs(liquid[:, :2]).max(axis=0) < np.abs(body.vertices[:, :2]).max(axis=0))
                assert 0.0 < liquid[:, 2].min() < liquid[:, 2].max() < cargo.container.height
    view.remove()
    assert server.scene.get_handle_by_name("/one") is None


def test_views_move_the_world_and_not_the_tray(tilting_film: Film) -> None:
    with running_server(port=0) as server:
        shown = show_plans(server, [tilting_film], view=View.FIXED)
        view, tray = shown.views[0], node(server, "/tray")
        half = max(item.container.height for item in tilting_film.plan.scene.cargo) / 2
        ground = []
        for t in (0.0, 0.4, 0.8):
            view.show(t)
            axes = world(server, tray, np.vstack([np.zeros(3), np.eye(3)]))
            assert axes - (0.0, 0.0, -half) == pytest.approx(np.vstack([np.zeros(3), np.eye(3)]), abs=1e-6)
            ground.append(np.array(shown.ground.wxyz))
        assert not np.allclose(ground[0], ground[1])
        assert not view._paths[0].visible
        aim(server, shown, View.TRAY)  # at the same time as before, level
        axes = world(server, tray, np.vstack([np.zeros(3), np.eye(3)]))
        assert axes[0] + half * (axes[3] - axes[0]) == pytest.approx(np.zeros(3), abs=1e-6)
        assert np.asarray(shown.ground.wxyz)[1:3] == pytest.approx([0.0, 0.0], abs=1e-6)
        aim(server, shown, View.ARM)
        axes = world(server, tray, np.zeros((1, 3)))
        assert axes[0] == pytest.approx(tilting_film.tray_position[tilting_film.index(0.8)], abs=1e-6)
        assert view._paths[0].visible
        for item in ("c1", "c4"):
            assert server.scene.get_handle_by_name(f"{tray}/{item}/limit") is not None


def test_colours_follow_the_use_of_limits(server: viser.ViserServer, tilting_film: Film) -> None:
    view = PlanView(server.scene, tilting_film, root="/colours")
    index = int(np.argmax(tilting_film.contact_use["c1"]))
    view.show(float(tilting_film.t[index]))
    tray = node(server, "/tray")
    contact = server.scene.get_handle_by_name(f"{tray}/c1/contact")
    liquid = server.scene.get_handle_by_name(f"{tray}/c1/liquid")
    track = tilting_film.liquids["c1"]
    assert np.array_equal(contact.color, use_colours(tilting_film.contact_use["c1"][[index]])[0])
    assert np.array_equal(liquid.color, use_colours(track.height[[index]] / track.limit)[0])
    view.show_path(False)
    view.tray.show_names(False)
    view.remove()


def test_scale_of_uses() -> None:
    ends = use_colours(np.array([stop for stop, _ in USE_STOPS]))
    assert [tuple(row) for row in ends.tolist()] == [rgb(colour) for _, colour in USE_STOPS]
    assert use_colours(np.array([-1.0])).tolist() == use_colours(np.array([0.0])).tolist()
    assert not use_colours(np.array([1.001, np.inf, np.nan])).any()  # black: broken


def test_palette_is_that_of_the_figures() -> None:
    style = pytest.importorskip("nospill.plots.style")
    assert SERIES == style.COLOURS
    assert USE_STOPS[-1][1] == style.RED


def test_two_plans_do_not_meet_and_are_seen_whole(tilting_film: Film, level_film: Film) -> None:
    films = [level_film, tilting_film]
    places = side_by_side(films)
    boxes = [(low + place, high + place) for place, (low, high) in zip(places, map(swept_box, films), strict=True)]
    assert boxes[0][1][1] < boxes[1][0][1]
    for count in (1, 2):
        view = camera(films[:count], places[:count])
        back = view.position - view.look_at
        distance = np.linalg.norm(back)
        back /= distance
        right = np.cross([0, 0, 1], back) / np.linalg.norm(np.cross([0, 0, 1], back))
        up = np.cross(back, right)
        for film, place in zip(films[:count], places, strict=False):
            seen = occupied(film) + place - view.look_at
            depth = distance - seen @ back
            assert np.all(depth > 0)
            used = np.abs([(seen @ up) / depth, (seen @ right) / depth / 1.2]) / np.tan(view.angle / 2)
            assert used.max() <= 1.0
        assert view.position[2] > 1.0


def test_scene_of_two_plans(tilting_film: Film, level_film: Film) -> None:
    with running_server(port=0) as server:
        shown = show_plans(server, [level_film, tilting_film])
        assert [view.root for view in shown.views] == ["/plan_1", "/plan_2"]
        for root in ("/plan_1", "/plan_2"):
            assert server.scene.get_handle_by_name(f"{root}/world/path/line") is not None
            assert server.scene.get_handle_by_name(f"{root}/title") is not None
    assert short_titles([level_film, tilting_film]) == ["level", "tilting"]
    assert short_titles([tilting_film, tilting_film]) == ["matrix-liquid-tilt (1)", "matrix-liquid-tilt (2)"]
    assert title_of(level_film).startswith("matrix-liquid (level): ")


@pytest.mark.parametrize("view", View)
def test_names_cover_no_other_whatever_the_window(view: View, tilting_film: Film, level_film: Film) -> None:
    for films, titles in (([tilting_film], [""]), ([level_film, tilting_film], ["level", "tilting"])):
        places, camera = arrangement(films, view, aspect=1.05)
        letters = letters_of(films, titles, places, view, camera)
        assert letters.apart or view in (View.ARM, View.ABOVE)  # near the cups there is room
        centres, sizes = name_boxes(films, titles, places, view, camera)
        assert centres.shape[1] == sum(len(film.plan.scene.cargo) for film in films) + sum(map(bool, titles))
        if not letters.apart:
            continue
        for one, other in combinations(range(centres.shape[1]), 2):
            apart = (
                np.abs(centres[:, one] - centres[:, other])
                >= letters.names * (sizes[:, one] + sizes[:, other]) / 2.0001
            )
            assert np.all(np.any(apart, axis=1))


@pytest.mark.slow
@pytest.mark.parametrize("name", UNLIKE)
def test_names_of_an_example_have_room_near_the_cups(name: str, example_film: Callable[[str], Film]) -> None:
    films = [example_film(name)]
    for view in CLOSE:
        places, camera = arrangement(films, view, aspect=1.05)
        assert letters_of(films, [""], places, view, camera).apart


def test_names_are_hidden_where_they_would_cover_each_other(tilting_film: Film) -> None:
    crowded = replace(tilting_film.plan.scene.cargo[0], label="a name as long as the tray is wide")
    scene = replace(tilting_film.plan.scene, cargo=(crowded, *tilting_film.plan.scene.cargo[1:]))
    film = replace(tilting_film, plan=replace(tilting_film.plan, scene=scene))
    places, camera = arrangement([film], View.ARM, aspect=1.05)
    assert not letters_of([film], [""], places, View.ARM, camera).apart
    with running_server(port=0) as server:
        shown = show_plans(server, [film], view=View.ARM)
        assert not shown.named
        label = server.scene.get_handle_by_name("/plan_1/names/name_c1")
        assert label.text == crowded.label and not label.visible


def test_the_arrow_points_where_things_fall(server: viser.ViserServer, tilting_film: Film) -> None:
    view = PlanView(server.scene, tilting_film, root="/pull")
    for index in (0, len(tilting_film.t) // 3, len(tilting_film.t) - 1):
        view.show(float(tilting_film.t[index]))
        name = next(n for n in server.scene._handle_from_node_name if n.startswith("/pull") and n.endswith("/gravity"))
        wxyz = np.asarray(server.scene.get_handle_by_name(name).wxyz)
        shaft = Rotation.from_quat(wxyz[[1, 2, 3, 0]]).apply([0.0, 0.0, 1.0])
        force = tilting_film.specific_force[index]
        assert shaft == pytest.approx(force / np.linalg.norm(force), abs=1e-9)
    # The arm stands after the end: what pulls is gravity alone.
    assert tilting_film.tray_rotation[-1] @ tilting_film.specific_force[-1] == pytest.approx([0, 0, 9.80665], abs=1e-3)
    body = server.scene.get_handle_by_name(f"{name}/arrow").vertices
    spot = np.asarray(server.scene.get_handle_by_name(name).position)
    assert body[:, 2].min() == pytest.approx(0.0, abs=3e-4) and 0.08 <= body[:, 2].max() <= 0.14
    for item in tilting_film.plan.scene.cargo:
        assert np.linalg.norm(spot[:2] - item.position) > 0.035  # beside the cups
    view.remove()


def test_nothing_is_printed(capsys: pytest.CaptureFixture[str]) -> None:
    with running_server(port=0) as server:
        prepare(server.scene)
    assert capsys.readouterr().out == ""


def test_obstacles_stand_in_the_frame_of_the_path(server: viser.ViserServer, changed_scene) -> None:
    """The column's corners and the robot's foot in one world; the table at the height of the ground is not drawn."""
    film = film_of(changed_scene("cups-past-a-column", {"planning.slosh_modes": 1, "obstacle.0.yaw": "90 deg"}))
    view = PlanView(server.scene, film, root="/cell", position=(0.5, -1.0, 0.0))
    corners = np.array([[0.785, -0.075, 0.0], [0.935, 0.075, 0.9]])
    handle = server.scene.get_handle_by_name("/cell/world/around/obstacles/column")
    drawn = world(server, "/cell/world/around/obstacles", np.asarray(handle.vertices, dtype=float))
    assert drawn.min(axis=0) == pytest.approx(corners[0] + (0.5, -1.0, 0.0), abs=1e-6)
    assert drawn.max(axis=0) == pytest.approx(corners[1] + (0.5, -1.0, 0.0), abs=1e-6)
    assert server.scene.get_handle_by_name("/cell/world/around/obstacles/table") is None
    view.remove()


def test_places_and_regions_are_drawn_where_they_are(server: viser.ViserServer) -> None:
    table = {**read_scenario("matrix-rigid").source}
    table["path"] = {
        "type": "free",
        "start": {"position": [0.154, -0.6, 1.22]},
        "goal": {"position": [0.154, 0.6, 1.22]},
        "via": [{"position": [0.85, 0.0, 1.4], "radius": 0.02, "name": "door"}],
        "region": [{"at": [0.4, 0.0, 1.3], "size": [1.5, 2.0, 0.5], "yaw": "30 deg"}],
    }
    scene = scene_from_table(table, name="drawn")
    add_surroundings(server.scene, "/around", scene)
    ball = server.scene.get_handle_by_name("/around/via/door")
    assert tuple(ball.position) == (0.85, 0.0, 1.4) and ball.radius == 0.02
    edges = region_edges(scene.regions[0])
    assert sorted(np.round(np.linalg.norm(edges[:, 1] - edges[:, 0], axis=1), 9)) == [0.5] * 4 + [1.5] * 4 + [2.0] * 4
    assert all(abs(scene.regions[0].slack(corner)) < 1e-9 for corner in edges.reshape(-1, 3))
    assert server.scene.get_handle_by_name("/around/regions/region") is not None
