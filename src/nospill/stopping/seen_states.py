"""A state of a plan with liquids as somebody has seen them: checked, and put on the way along which the plan stops."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from nospill.errors import ScenarioError
from nospill.plans.plan import Plan
from nospill.plans.state import MotionState
from nospill.scenario.initial_state_entry import OFF_PATH
from nospill.stopping.own_way import along_own_way
from nospill.stopping.stops import require_stoppable


def on_own_way(plan: Plan, state: MotionState) -> tuple[Plan, MotionState]:
    """The plan as one along its own way, and a state of it there, with the swings that it has.

    Args:
        plan: certified.
        state: of the plan (`plan.state_at`), its swings perhaps others.

    Raises:
        ScenarioError: the plan has no stops (`stops.require_stoppable`), or the state is not one of its own, or does
            not say how all its liquids swing.
    """
    _require_swings(plan, state)
    plan = along_own_way(plan, at=state.t)
    own = plan.state_at(state.t)
    _require_same_joints(plan, own, state)
    return plan, replace(own, swings=state.swings)


def _require_swings(plan: Plan, state: MotionState) -> None:
    """Refuse what is no plan with stops, and what is no state of it that says how every liquid swings.

    Raises:
        ScenarioError: says which of the two it is, and what to give.
    """
    if not isinstance(plan, Plan) or not isinstance(state, MotionState):  # pyright: ignore[reportUnnecessaryIsInstance]
        raise ScenarioError(
            f"recover({type(plan).__name__}, {type(state).__name__}): the plan comes first, and then a state of it, as "
            "plan.state_at(0.7) gives it"
        )
    require_stoppable(plan)
    liquids = [item.name for item in plan.scene.cargo if item.filling is not None]
    for name in liquids:
        if name not in state.swings:
            given = ", ".join(state.swings) or "none"
            raise ScenarioError(
                f"{plan.scene.name}: state.swings does not say how the liquid of {name} swings, only {given}; write "
                "replace(state, swings={**state.swings, name: swing})"
            )
        swing = state.swings[name]
        if not np.all(np.isfinite([*np.ravel(swing.displacement), *np.ravel(swing.velocity)])):
            raise ScenarioError(f"{plan.scene.name}: the swing of {name} has a value that is no number: {swing}"[:200])


def _require_same_joints(plan: Plan, own: MotionState, state: MotionState) -> None:
    """Refuse a state of another plan: the stop goes along this one's path."""
    there, given = (np.array(item.arm.joint_position) for item in (own, state))
    if there.shape != given.shape or np.abs(there - given).max() > OFF_PATH:
        raise ScenarioError(
            f"{plan.scene.name}: the state is not one of this plan, whose joints stand otherwise at {state.t:g} s; "
            "take it by plan.state_at(t), and replace its swings alone"
        )
