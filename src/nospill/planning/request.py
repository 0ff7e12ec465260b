"""What a caller asks to plan, checked: a scene that was read, constraints, an earlier plan."""

from __future__ import annotations

from collections.abc import Collection

from nospill.core.suggestions import nearest
from nospill.errors import ScenarioError
from nospill.laws.constraints import CONSTRAINTS
from nospill.plans.plan import Plan
from nospill.scenario import load
from nospill.scenario.loading import ScenarioSource
from nospill.scene.scene import Scene


def requested_scene(scene: Scene | ScenarioSource) -> Scene:
    """The scene to plan: as it is where it is one, read where it is the name of one.

    Args:
        scene: a scene, or what `load` takes: a file, a plan folder, an example's name, a dictionary.

    Raises:
        ScenarioError: it is none of these, cannot be read, or is a copy made with `dataclasses.replace`.
    """
    if isinstance(scene, Plan):
        raise ScenarioError("a scene is needed, and this is a plan; its scene is plan.scene")
    return scene.require_as_read() if isinstance(scene, Scene) else load(scene)


def ignored_constraints(ignore: Collection[str] | str) -> frozenset[str]:
    """Names of constraints to leave out, of which one may stand alone.

    Raises:
        ScenarioError: one of them is no constraint, or they are no names at all.
    """
    names = (ignore,) if isinstance(ignore, str) else ignore
    if not isinstance(names, Collection) or not all(isinstance(name, str) for name in names):
        raise ScenarioError(f'ignore: {ignore!r} is no list of constraints; write ignore=["slosh height"]')
    known = [constraint.name for constraint in CONSTRAINTS]
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
