"""What is said of motions that begin in motion: nothing stands still that moves."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from types import SimpleNamespace
from typing import Any, cast

from nospill.diagnosis.quasi_static import require_possible_at_rest
from nospill.diagnosis.search import Trials
from nospill.plans.plan import Plan
from nospill.stopping.solving import joint_path_of, stopping_scene


def test_a_fast_beginning_is_not_called_impossible_even_standing_still(gentle_plan: Callable[[str, int], Plan]) -> None:
    """From three times the speed, half a second before the end, standing there keeps every limit as anywhere."""
    plan = gentle_plan("matrix-liquid-soft-end", 1)
    state = plan.state_at(plan.duration - 0.5)
    fast = replace(state, arm=replace(state.arm, s_rate=3.0 * state.arm.s_rate))
    scene = stopping_scene(plan.scene, fast)
    scene = replace(scene, motion=replace(plan.scene.motion, end="residual"))
    run: Any = SimpleNamespace(scene=scene, trial=lambda asked, joint_path: SimpleNamespace(scene=asked))
    require_possible_at_rest(cast(Trials, SimpleNamespace(run=run, joint_path=joint_path_of(plan), limit=20.0)))
