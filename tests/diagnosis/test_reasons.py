"""Why there is no motion: tasks made impossible in a known way, and changes that make them possible."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from typer.testing import CliRunner

from nospill.cli import app
from nospill.diagnosis import last_resort, not_found
from nospill.diagnosis.search import Trials
from nospill.errors import NoSolutionError, ScenarioError
from nospill.planning.log import Log
from nospill.planning.planner import plan
from nospill.planning.search import searcher
from nospill.planning.task import Task
from nospill.robots.joint_paths.search import preferred_path
from nospill.scenario import read_scenario, scene_from_table
from nospill.scene.scene import Scene
from nospill.transcription.starting_motions import USUAL_START, coarse_start
from tests.builders import joint_paths_of

pytestmark = pytest.mark.slow

Changed = Callable[..., Scene]

FEW = {"planning.intervals": 30}


def first(name: str, count: int) -> dict[str, Any]:
    """Changes of an example: a coarse grid, and the first of its objects alone."""
    return FEW | {"cargo": read_scenario(name).source["cargo"][:count]}  # type: ignore[index]


def refusal(scene: Scene) -> NoSolutionError:
    with pytest.raises(NoSolutionError) as raised:
        plan(scene)
    assert "\n" not in str(raised.value) and raised.value.exit_code == 3
    return raised.value


@pytest.mark.parametrize(
    ("name", "changes", "named", "key", "told"),
    [
        # There is a motion, which takes too long.
        (
            "matrix-rigid",
            {"motion.path_jerk_limit": 0.001},
            "path jerk of path",
            "motion.path_jerk_limit",
            r"none within max_duration 20 s; the fastest found takes \d+\.\d s, held back by path jerk of path",
        ),
        # The slowest that is tried breaks the limit; one cup is not to blame.
        (
            "matrix-liquid",
            {"cargo.1.max_slosh_height": "0.01 mm"},
            "slosh height of c2",
            "cargo.c2.max_slosh_height",
            r"slosh height of c2 is .* against a limit of 0\.01 mm",
        ),
    ],
)
def test_a_limit_that_asks_for_more_than_the_usual_time_is_named(
    name: str, changes: dict[str, Any], named: str, key: str, told: str, changed_scene: Changed
) -> None:
    error = refusal(changed_scene(name, first(name, 2) | changes))
    require_named(error, named, key)
    assert re.match(f"No motion found: {told}", str(error))


def require_named(error: NoSolutionError, named: str, key: str) -> None:
    assert error.kind == "in motion" and named in str(error)
    assert error.reason is not None and f"{error.reason.constraint} of {error.reason.subject}".startswith(named)
    assert key in [change.place for change in error.changes]


def test_friction_that_asks_for_more_than_the_usual_time_is_named(changed_scene: Changed) -> None:
    """A bottle on a tray that holds nothing; that a suggested friction is enough: test_infeasible_cases.py."""
    error = refusal(changed_scene("matrix-rigid", first("matrix-rigid", 1) | {"tray.friction": 1e-4}))
    require_named(error, "slip of", "tray.friction")
    assert re.match(r"No motion found: slip of c1 uses \d+ % of its limit", str(error))


def test_too_short_a_duration_is_reported_with_the_least_that_suffices(changed_scene: Changed) -> None:
    changes = FEW | {"motion.max_duration": 1.2, "motion.path_jerk_limit": 500}
    error = refusal(changed_scene("matrix-rigid", changes))
    assert error.kind == "in motion"
    longest = next(change for change in error.changes if change.place == "motion.max_duration")
    assert "max_duration" in longest.text and longest.text in str(error)
    assert isinstance(longest.value, float)
    found = plan(changed_scene("matrix-rigid", changes | {"motion.max_duration": longest.value}))
    assert found.certificate.ok and 1.2 < found.duration <= longest.value
    # and no more than needed
    assert longest.value < 1.08 * found.duration


def test_a_search_that_is_out_of_time_says_what_its_last_motion_breaks(changed_scene: Changed) -> None:
    scene = changed_scene("matrix-rigid", FEW | {"tray.friction": 0.1, "planning.max_plan_time": 1e-3})
    way = preferred_path(joint_paths_of(scene), scene.robot, None)
    run = searcher(Task.of(scene), Log(None, scene.planning.max_plan_time))
    trial = run.trial(scene, way)
    last = trial.solve(coarse_start(trial.scene, way, USUAL_START), 12)
    assert run.out_of_time()
    with pytest.raises(NoSolutionError) as raised:
        last_resort(run, way, last)
    assert raised.value.kind == "not converged" and raised.value.reason is not None
    assert (raised.value.reason.constraint, raised.value.reason.subject) == ("planning", "max_plan_time")
    message = r"within planning\.max_plan_time 0\.001 s; the last one tried breaks the limit on slip of \w+\."
    assert re.search(message, str(raised.value))


def test_a_search_that_ends_without_a_motion_says_what_the_last_one_breaks(changed_scene: Changed) -> None:
    scene = changed_scene("matrix-rigid", FEW | {"tray.friction": 0.1})
    way = preferred_path(joint_paths_of(scene), scene.robot, None)
    run = searcher(Task.of(scene), Log(None, scene.planning.max_plan_time))
    trial = run.trial(scene, way)
    last = trial.solve(coarse_start(trial.scene, way, USUAL_START), 12)
    message = str(not_found.not_found(Trials(run, way), last))
    assert re.search(
        r"although a smooth motion of \d+ s keeps every limit.*; the last one tried breaks .* slip of", message
    )
    assert "the last one tried" not in str(not_found.not_found(Trials(run, way), None))


def test_a_motion_found_when_time_is_up_is_judged_as_it_is(changed_scene: Changed) -> None:
    found = plan(changed_scene("matrix-rigid", FEW | {"planning.max_plan_time": 1e-3}))
    assert found.report.starts.tried == 1 and found.report.rounds == 0
    assert found.report.ran_out
    usual = plan(changed_scene("matrix-rigid", FEW))
    assert not usual.report.ran_out and usual.certificate.ok
    assert not found.certificate.ok and found.duration == pytest.approx(usual.duration, rel=0.1)
    assert found.message.endswith(" Planning ended at planning.max_plan_time = 0.001 s: allow more.")
    assert "max_plan_time" not in replace(found, certificate=usual.certificate).message
    ranged = replace(found, scene=replace(found.scene, motion=replace(found.scene.motion, speed_range=(0.5, 1.0))))
    assert ranged.certified_speeds is None
    assert replace(ranged, certificate=usual.certificate).certified_speeds == (0.5, 1.0)


def test_a_path_out_of_reach_is_the_robots_fault(changed_scene: Changed) -> None:
    with pytest.raises(ScenarioError, match=r"out of reach .* from s = 0\.\d+ \(x, y, z = .* mm\) on, by up to \d+"):
        plan(changed_scene("matrix-rigid", {"robot.base_position": ["-0.6 m", "0 m", "0 m"]}))


def test_a_path_out_of_reach_of_a_tray_of_many_objects_has_a_suggestion() -> None:
    """The problem that confirms a suggestion carries some of them only."""
    table: Any = read_scenario("pp-two-cups").source
    cup = table["cargo"][0] | {"name": "cup", "at": [0.0, 0.0], "radius": 0.01, "height": 0.04, "liquid_height": 0.02}
    cup = {key: value for key, value in cup.items() if key not in ("mass", "centre_of_mass_height")}
    array = {"count": [4, 4], "pitch": [0.025, 0.025]}
    table["cargo"] = [cup | {"empty_mass": 0.01, "max_slosh_height": 0.005, "array": array}]
    table["fidelity"], table["robot"]["base_position"] = "full", [-0.6, 0.0, 0.0]
    with pytest.raises(ScenarioError, match="Smallest single change found") as raised:
        plan(scene_from_table(table, name="many"))
    assert raised.value.reason is not None


def test_the_command_line_names_the_file_and_says_what_would_help() -> None:
    file = Path(__file__).parents[2] / "docs" / "examples" / "out-of-reach.toml"
    result = CliRunner().invoke(app, ["plan", str(file)])
    assert result.exit_code == 2 and result.stdout == ""
    message = result.stderr.splitlines()[-1]
    assert message.startswith(f"{file}: path: out of reach") and "Smallest single change found: base" in message
