"""Which way round obstacles a free path takes, and what is said where all are blocked."""

from __future__ import annotations

import re
from itertools import islice

import numpy as np
import pytest

from benchmarks.carry.draw import PROBLEMS, read_problems
from nospill.collisions.along_path import nearest_along, nearest_of_tray
from nospill.collisions.configurations import Configurations
from nospill.collisions.distances import Distances
from nospill.diagnosis.not_found import not_found
from nospill.diagnosis.search import Trials
from nospill.errors import NoSolutionError, ScenarioError
from nospill.path_search import candidates, free_path
from nospill.path_search.branches import are_clear, tray_is_clear
from nospill.path_search.candidates import PathCandidate, feasible_paths, with_path
from nospill.path_search.free_path import fastest_clear_path
from nospill.planning.log import Log
from nospill.planning.search import searcher
from nospill.planning.task import Task
from nospill.robots.joint_paths.search import joint_paths, preferred_path
from nospill.robots.kinematics.frames import arm_chain, joint_frames
from nospill.scenario import read_scenario, scene_from_table
from nospill.scene.scene import Scene

pytestmark = pytest.mark.slow


@pytest.fixture(autouse=True)
def _one_short_search(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(free_path, "SEEDS", (0,))
    monkeypatch.setattr(free_path, "SAMPLES", 300)


COLUMN = {"name": "column", "shape": "box", "at": [0.86, 0.0, 0.45], "size": [0.15, 0.15, 0.9], "clearance": 0.01}
TABLE = {"name": "table", "shape": "halfspace", "at": [0.0, 0.0, 0.0]}


def scene_of(*obstacles: dict[str, object]) -> Scene:
    table = read_scenario("cups-around-a-column").source
    return scene_from_table({**table, "obstacle": [*obstacles], "motion": {"tilt": "fixed"}}, name="around")


def middle_of(scene: Scene) -> np.ndarray:
    return scene.path.at(0.5)[0, :3]


def test_without_obstacles_three_ways_are_looked_at() -> None:
    table = read_scenario("cups-around-a-column").source
    scene = scene_from_table({key: value for key, value in table.items() if key != "obstacle"}, name="open")
    assert fastest_clear_path(scene).source == feasible_paths(scene)[0].scene.source
    assert len(feasible_paths(scene)) <= 3 < len(feasible_paths(scene_of(TABLE)))


def test_inside_a_tall_column_and_over_a_low_one() -> None:
    inside = middle_of(fastest_clear_path(scene_of(COLUMN, TABLE)))
    assert 0.3 < inside[0] < 0.66 and inside[2] == pytest.approx(0.45)
    low = {**COLUMN, "at": [0.86, 0.0, 0.15], "size": [0.15, 0.15, 0.3]}
    over = middle_of(fastest_clear_path(scene_of(low, TABLE)))
    assert over[2] > 0.5


def test_no_long_way_round_where_sampling_finds_a_short_one(monkeypatch: pytest.MonkeyPatch) -> None:
    """Round the back of the arm nothing is in the way, but the arm takes more than twice as long."""
    scene = scene_of(COLUMN, TABLE)
    start, goal = scene.path.at([0.0, 1.0])[:, :3]
    turn = np.linspace(np.arctan2(start[1], start[0]), np.arctan2(goal[1], goal[0]) - 2 * np.pi, 13)
    points = np.column_stack([*(np.hypot(*start[:2]) * np.array([np.cos(turn), np.sin(turn)])), np.full(13, start[2])])
    points[[0, -1]] = start, goal
    behind = with_path(scene, points)
    possible = [PathCandidate(scene, scene.path), PathCandidate(scene, behind.path, points)]
    monkeypatch.setattr(free_path, "path_candidates", lambda _: possible)
    monkeypatch.setattr(free_path, "SAMPLES", 2000)
    found = fastest_clear_path(scene)
    assert middle_of(found)[0] > 0.0
    figures = [joint_paths(own.robot, own.path, tool=own.tray.tool)[0].speed_figure for own in (found, behind)]
    assert figures[0] < 0.75 * figures[1]
    monkeypatch.setattr(free_path, "fastest_sampled_path", lambda _: (0.8 * figures[1], found))
    fastest_clear_path.cache_clear()
    assert fastest_clear_path(scene).source["path"] == behind.source["path"]  # what is a little faster stays


def test_where_all_are_blocked_one_line_says_so(monkeypatch: pytest.MonkeyPatch) -> None:
    """Of the forty ways, every thirteenth."""
    possible = candidates.path_candidates
    for module in (candidates, free_path):
        monkeypatch.setattr(module, "path_candidates", lambda scene: islice(possible(scene), 0, None, 13))
    walls = [
        {"name": name, "shape": "box", "at": [side, 0.0, 1.25], "size": ["1.8 m", "20 mm", "2.5 m"]}
        for name, side in (("front", 1.1), ("back", -1.1))
    ]
    with pytest.raises(NoSolutionError, match=r"No way found for the arm: .* ways that were tried") as caught:
        fastest_clear_path(scene_of(*walls, TABLE))
    assert caught.value.exit_code == 3


def test_a_blocked_way_that_was_taken_for_its_room_is_no_limit_to_relax() -> None:
    """Straight through a column, where no way round it was found: the message is about the way."""
    scene = scene_of(COLUMN, TABLE)
    scene = scene.changed({"motion.slosh_height": "linear", "cargo": scene.source["cargo"][:1]})
    through = with_path(scene, scene.path.at(np.linspace(0.0, 1.0, 7))[:, :3])
    path = preferred_path(joint_paths(through.robot, through.path, tool=through.tray.tool), through.robot, None)
    run = searcher(Task.of(through), Log(None, 60.0))
    error = not_found(Trials(run, path), None)
    assert re.match(
        r"No way found: on the one with most slack clearance of \w+ to column is −.* and random searches found no "
        r"clear one\. Move the obstacle, the ends of the path or the arm's base",
        str(error),
    )
    assert error.reason is not None and error.reason.constraint == "clearance"


def test_a_way_that_the_arm_cannot_follow_is_no_bad_input(monkeypatch: pytest.MonkeyPatch) -> None:
    """Of the benchmark: behind the arm its elbow is bent the other way than in front of it."""
    scene = scene_from_table(read_problems(PROBLEMS)[61]["table"], name="behind")
    for module in (candidates, free_path):
        monkeypatch.setattr(module, "path_candidates", lambda scene: iter([PathCandidate(scene, scene.path)]))
    with pytest.raises(NoSolutionError, match=r"the only way that was tried .*; random searches found no") as caught:
        fastest_clear_path(scene)
    assert caught.value.exit_code == 3


def test_seven_joints_find_a_way_that_keeps_all_of_them(monkeypatch: pytest.MonkeyPatch) -> None:
    """Of the benchmark: on the motion that is known the self-motion turns joint 7 back three times."""
    monkeypatch.setattr(free_path, "SAMPLES", 2000)
    scene = scene_from_table(read_problems(PROBLEMS)[50]["table"], name="shelf")
    found = free_path.fastest_sampled_path(scene)
    assert found is not None
    stated = found[1].source["path"]["way_joints"]  # type: ignore[index,call-overload]
    paths = joint_paths(scene.robot, found[1].path, tool=scene.tray.tool)
    np.testing.assert_allclose(paths[0].at(np.linspace(0.0, 1.0, len(stated))), stated, atol=0.02)
    assert Configurations(scene).clear(paths[0].at(np.linspace(0.0, 1.0, 301))).all()


def test_a_goal_beside_an_obstacle_is_bad_input() -> None:
    with pytest.raises(ScenarioError, match=r"where the path ends; move the obstacle or the path") as caught:
        fastest_clear_path(scene_of({**COLUMN, "at": [0.75, 0.66, 0.45]}, TABLE))
    assert caught.value.exit_code == 2


def test_a_sampled_way_round_a_column_is_clear_and_the_same_every_time() -> None:
    scene = scene_of(COLUMN, TABLE)
    found, again = free_path.fastest_sampled_path(scene), free_path.fastest_sampled_path(scene)
    assert found is not None and again is not None
    assert found[1].source == again[1].source
    assert found[1].path.length < 2.0  # the arc the other way round is 4.6 m long
    looks = np.linspace(0.0, 1.0, 301)
    paths = joint_paths(scene.robot, found[1].path, tool=scene.tray.tool)
    assert any(Configurations(scene).clear(path.at(looks)).all() for path in paths[:40])
    kept = scene_from_table(found[1].source, name="kept")
    assert np.array_equal(kept.path.coefficients, found[1].path.coefficients)


def test_what_is_in_the_way_of_the_tray_is_seen_without_the_arm() -> None:
    scene = scene_of(COLUMN, TABLE)
    (path, *_) = joint_paths(scene.robot, scene.path, tool=scene.tray.tool)
    of_tray, of_all = nearest_of_tray(scene, scene.path, places=41), nearest_along(scene, path, places=41)
    assert of_tray.pair.first.on_path and of_tray.slack >= of_all.slack
    assert of_tray.slack < 0.0 and not tray_is_clear(scene, scene.path)
    frames = joint_frames(arm_chain(scene.robot), path.at(np.array([of_tray.s])))
    room = Distances(of_tray.pair.first, of_tray.pair.second).at(frames, np.zeros(1, dtype=int))[0][0]
    assert of_tray.slack == pytest.approx(room - of_tray.pair.limit, abs=1e-6)


def test_what_a_glimpse_shows_is_what_following_finds(monkeypatch: pytest.MonkeyPatch) -> None:
    """Ways that are open on some branch all along, and their figures, from places against the whole path."""
    scene = scene_of({**COLUMN, "at": [0.86, 0.0, 0.15], "size": [0.15, 0.15, 0.3]}, TABLE)
    found = free_path.clear_candidates(scene)
    monkeypatch.setenv("NOSPILL_THREADS", "2")
    by_two = free_path.clear_candidates(scene)
    assert [own.path.coefficients.tobytes() for own in by_two] == [own.path.coefficients.tobytes() for own in found]
    assert scene not in found
    clear = {}
    for way in feasible_paths(scene):
        fastest = next((path for path, own in zip(way.paths, are_clear(scene, way.paths), strict=True) if own), None)
        if fastest is not None:
            clear[way.scene.path.coefficients.tobytes()] = fastest.speed_figure
    figures = [clear.get(own.path.coefficients.tobytes()) for own in found]
    assert len([figure for figure in figures if figure is not None]) == len(clear) > 3
    assert figures[0] is not None and figures[0] < 1.1 * min(clear.values())
