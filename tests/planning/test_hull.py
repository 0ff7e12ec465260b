"""Many like objects: the optimiser knows the outer ones, the judge all."""

from __future__ import annotations

import copy
from typing import Any

import numpy as np
import pytest
from nospill.planning.hull import HullRun, hull_run, outer_objects
from nospill.planning.run import PlanningRun

from nospill.laws.scene_parameters import flange_load
from nospill.planning.planner import plan
from nospill.robots.joint_paths.search import joint_paths
from nospill.scenario import read_scenario, scene_from_table
from nospill.scene.scene import Scene

Places = list[tuple[float, float]]


def tray_of(places: Places, *, changes: dict[int, dict[str, Any]] | None = None, **cup: Any) -> Scene:
    """Small cups of water at places in mm, on few intervals; some with other keys."""
    table: Any = copy.deepcopy(read_scenario("matrix-liquid").source)
    keys = {"shape": "cylinder", "radius": "20 mm", "height": "60 mm", "liquid": "water", "liquid_height": "28 mm"}
    keys |= {"max_slosh_height": "10 mm", "mass": "0.045 kg", "centre_of_mass_height": "16 mm"} | cup
    table["cargo"] = [
        {"name": f"c{index + 1}", "at": [f"{x} mm", f"{y} mm"], **keys, **(changes or {}).get(index, {})}
        for index, (x, y) in enumerate(places)
    ]
    table["motion"]["end"] = "residual"
    table["planning"] = {"intervals": 40}
    return scene_from_table(table, name="cups")


GRID: Places = [(x, y) for x in (-60.0, 0.0, 60.0) for y in (-60.0, 0.0, 60.0)]


def names(scene: Scene) -> list[str]:
    return [cargo.name for cargo in outer_objects(scene)]


def test_of_a_grid_the_corners_are_left() -> None:
    assert names(tray_of(GRID)) == ["c1", "c3", "c7", "c9"]


def test_of_a_row_the_ends_are_left() -> None:
    assert names(tray_of([(x, 0.5 * x) for x in (-100.0, -50.0, 0.0, 50.0, 100.0)])) == ["c1", "c5"]


def test_two_or_three_apart_are_all_left() -> None:
    assert names(tray_of(GRID[:2])) == ["c1", "c2"]
    assert names(tray_of([(0, 0), (80, 0), (0, 80)])) == ["c1", "c2", "c3"]


@pytest.mark.parametrize(
    "other",
    [
        {"liquid_height": "30 mm"},
        {"max_slosh_height": "9 mm"},
        {"friction": 0.3},
        {"footprint_reserve": 0.2},
        {"yaw": "10 deg"},
        {"mass": "0.05 kg"},
        {"liquid": {"density": 900.0, "kinematic_viscosity": 1e-5}},
    ],
)
def test_one_that_differs_stays(other: dict[str, Any]) -> None:
    assert names(tray_of(GRID, changes={4: other})) == ["c1", "c3", "c5", "c7", "c9"]


def test_the_published_tray_is_planned_whole() -> None:
    run = hull_run(read_scenario("matrix-liquid"), None, frozenset())
    assert type(run) is PlanningRun and len(run.scene.cargo) == 4


def test_the_flange_carries_all_of_them() -> None:
    scene = tray_of(GRID)
    run = hull_run(scene, None, frozenset())
    assert isinstance(run, HullRun) and len(run.scene.cargo) == 4
    got, wanted = flange_load(run.scene, run.payload), flange_load(scene)
    for part in ("mass", "first_moment", "inertia"):
        np.testing.assert_array_equal(getattr(got, part), getattr(wanted, part))


@pytest.mark.slow
def test_the_answer_is_that_of_the_whole_tray() -> None:
    scene = tray_of(GRID)
    found = plan(scene)
    assert found.certificate.ok and set(found.trajectory.slosh) == {cargo.name for cargo in scene.cargo}
    tool: dict[str, Any] = {"tool_position": scene.tray.offset, "tool_yaw": scene.tray.yaw_on_flange}
    whole = PlanningRun(scene, None, frozenset())
    trajectory, judgement, _ = whole.tighten(whole.find(joint_paths(scene.robot, scene.path, **tool)[0]))
    assert judgement.certificate.ok
    assert found.duration == pytest.approx(trajectory.end_time, rel=1e-3)


@pytest.mark.slow
def test_what_the_judge_objects_to_joins(monkeypatch: pytest.MonkeyPatch) -> None:
    """Begun with one cup in the middle, the run takes in the outer ones that the motion spills."""
    scene = tray_of(GRID)
    monkeypatch.setattr("nospill.planning.hull.outer_objects", lambda scene: scene.cargo[4:5])
    runs: list[HullRun] = []

    def remembered(*arguments: Any) -> PlanningRun:
        run = hull_run(*arguments)
        assert isinstance(run, HullRun)
        runs.append(run)
        return run

    monkeypatch.setattr("nospill.planning.planner.hull_run", remembered)
    found = plan(scene)
    assert found.certificate.ok
    assert {cargo.name for cargo in runs[0].scene.cargo} > {"c5"}
