"""How much longer the last motion would be in another scene, by the multipliers of its problem.

By the envelope theorem (`transcription.sensitivity`) the duration changes with any number of a scene by the multipliers
times what the rows move, the variables held: a place on the tray, the base of the arm, an end of the path, a fill. No
motion is planned for it.
"""

from __future__ import annotations

from dataclasses import replace

from nospill.errors import ScenarioError
from nospill.laws.scene_parameters import numbers_of, structure_of
from nospill.path_search.base_yaw import has_free_base
from nospill.path_search.candidates import has_free_path
from nospill.path_search.end_yaws import free_ends
from nospill.planning.candidate import Candidate
from nospill.planning.task import Task
from nospill.scene.scene import Scene
from nospill.transcription.sensitivity import lagrangian


def duration_change(candidate: Candidate, scene: Scene) -> float:
    """Seconds by which a motion would be longer in another scene, to the first order.

    What the planner has found itself stays: the way of a free path, and the planes between bodies, so that what moves
    near an obstacle does not count.

    Args:
        candidate: the motion, as it was solved.
        scene: the other one, with the same objects and liquids.

    Raises:
        ScenarioError: the scene is of another structure.
    """
    active, problem = candidate.active, candidate.problem
    if has_free_base(scene):
        raise ScenarioError('robot.base_yaw is "free", so that it changes with every scene; state an angle')
    if free_ends(scene):
        raise ScenarioError('yaw = "free" at an end of the path changes with every scene; state an angle')
    if has_free_path(scene):
        scene = replace(scene, path=active.task.scene.path)
    task = replace(Task.of(scene, active.task.ignored), passage=active.task.passage)
    other = task.problem_scene(active.members, active.refined, active.modes)
    if structure_of(other) != structure_of(problem.scene):
        raise ScenarioError(f"{scene.name}: other objects, liquids or rules than those of the motion before")
    solution = candidate.solution
    moved = lagrangian(problem, solution, problem.parameters_of(numbers_of(other), problem.backoff))
    return moved - lagrangian(problem, solution, problem.parameters)
