"""What a caller asks to plan, checked: a scene that was read, constraints, an earlier plan."""

from __future__ import annotations

from collections.abc import Collection, Iterable

import numpy as np

from nospill.core.suggestions import nearest
from nospill.errors import ScenarioError
from nospill.laws.constraints import constrained, constraints_of
from nospill.laws.constraints.base import Constraint
from nospill.laws.constraints.slopes import require_slopes
from nospill.motion.trajectory import Trajectory
from nospill.plans.plan import Plan
from nospill.plans.state import MotionState, beginning_in
from nospill.scenario import load
from nospill.scenario.initial_state_entry import OFF_PATH
from nospill.scenario.loading import ScenarioSource
from nospill.scene.scene import Scene


def requested_scene(scene: Scene | ScenarioSource, constraints: Iterable[Constraint] | None = None) -> Scene:
    """The scene to plan: as it is where it is one, read where it is the name of one.

    Args:
        scene: a scene, or what `load` takes: a file, a plan folder, an example's name, a dictionary.
        constraints: limits added to those of the scenario; None for those that the scene has from an earlier call.

    Raises:
        ScenarioError: it is none of these, cannot be read, or is a copy made with `dataclasses.replace`; a constraint
            is none or has no slope at rest, or one that the scene was saved with is not at hand.
    """
    if isinstance(scene, Plan):
        raise ScenarioError("a scene is needed, and this is a plan; its scene is plan.scene")
    asked = constrained(scene.require_as_read() if isinstance(scene, Scene) else load(scene), constraints)
    require_constraints(asked)
    require_slopes(asked)
    return asked


def begun_in(scene: Scene, state: MotionState | None, *, stop: bool = False) -> Scene:
    """The scene whose motion begins in a state, a stop perhaps; as it is where none is given.

    Raises:
        ScenarioError: it is no state, a stop without one, or `beginning_in` refuses it.
    """
    if state is None:
        if stop:
            raise ScenarioError("stop=True without start: give the state to stop from, as plan.state_at(0.7) does")
        return scene
    if not isinstance(state, MotionState):  # pyright: ignore[reportUnnecessaryIsInstance]
        raise ScenarioError(
            f"start is a state of motion, as plan.state_at(0.7) gives it, not {str(state)[:60]!r} of type "
            f"{type(state).__name__}"
        )
    return beginning_in(scene, state, stop=stop)


def rest_along(scene: Scene, state: MotionState | None) -> Trajectory | None:
    """What is left of the motion before, where the scene goes on along the same path to the same end; None else."""
    if state is None or scene.initial_state is None:
        return None
    end = scene.path.at(1.0)[0, :3]
    same = scene.initial_state.s == state.arm.s and np.linalg.norm(state.rest.tray_position[-1] - end) <= OFF_PATH
    return state.rest if same else None


def require_constraints(scene: Scene) -> None:
    """Raise ScenarioError where a constraint that the scene was saved with is not at hand."""
    if scene.unjudged:
        limit = scene.unjudged[0]
        raise ScenarioError(
            f'{scene.name}: its plan was saved with the constraint "{limit.name}", whose class is not at hand; give '
            f"all that should hold, as constraints=[{limit.text}], or constraints=[] for none"
        )


def ignored_constraints(ignore: Collection[str] | str, scene: Scene) -> frozenset[str]:
    """Names of constraints of a scene to leave out, of which one may stand alone.

    Raises:
        ScenarioError: one of them is no constraint, or they are no names at all.
    """
    names = (ignore,) if isinstance(ignore, str) else ignore
    if not isinstance(names, Collection) or not all(isinstance(name, str) for name in names):
        raise ScenarioError(f'ignore: {ignore!r} is no list of constraints; write ignore=["slosh height"]')
    known = [constraint.name for constraint in constraints_of(scene)]
    unknown = sorted(set(names) - set(known))
    if unknown:
        near = nearest(unknown[0], known)
        hint = f'; did you mean "{near}"?' if near else ""
        raise ScenarioError(f'ignore: "{unknown[0]}" is no constraint; there are: {", ".join(known)}{hint}')
    return frozenset(names)


def earlier_plan(plan: Plan | None) -> Plan | None:
    """An earlier plan as it is.

    Raises:
        ScenarioError: it is something else.
    """
    if plan is None or isinstance(plan, Plan):
        return plan
    raise ScenarioError(
        f"an earlier plan is needed here, as load_plan(folder) reads it, not {str(plan)[:60]!r} of type "
        f"{type(plan).__name__}; a scenario goes to plan(...) or Planner().plan(...)"
    )
